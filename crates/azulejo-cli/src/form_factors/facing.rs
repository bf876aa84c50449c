//! Advice on objects that are turned inside out.

use crate::failure::Failure;
use crate::matrix_metrics::{closure_errors, mean_and_largest};
use crate::session::Session;
use azulejo_exchange::Enclosure;
use azulejo_factors::facing::{InsideOut, inside_out};
use azulejo_scene::Scene;
use azulejo_trace::Tracer;

/// Mean share of light that ends on backs, or is not accounted for, from which it is worth a look.
const LOST: f64 = 1e-3;

/// Objects that the advice names.
const NAMED: usize = 5;

/// Says which objects are probably turned inside out, where light is lost to backs or meets nothing at all.
pub fn advise(
    scene: &Scene,
    tracer: &Tracer,
    enclosure: &Enclosure,
    session: &mut Session,
) -> Result<(), Failure> {
    let factors = &enclosure.factors;
    let hidden: Vec<f64> = factors.rest.iter().map(|r| r.hidden).collect();
    // Closed forms do not look for light that ends on backs, and closure may have hidden that it is missing.
    let moved = factors.closed.map_or(0.0, |closed| closed.mean);
    let (missing, is_empty) = match &enclosure.elsewhere {
        None => (closure_errors(factors), factors.exchange.entries() == 0),
        Some(matrix) => {
            let missing = enclosure.residuals().iter().map(|r| r.abs()).collect();
            (missing, matrix.numbers() == 0)
        }
    };
    let lost = mean_and_largest(&hidden).0 + mean_and_largest(&missing).0 + moved;
    if lost < LOST && !is_empty {
        return Ok(());
    }
    match session.with_progress(|p| inside_out(scene, tracer, p))? {
        InsideOut::Nothing => {}
        InsideOut::Objects(numbers) => {
            let named = numbers.iter().take(NAMED);
            let names = named.map(|&k| format!("\"{}\"", scene.objects[k as usize].name));
            let names = names.collect::<Vec<_>>().join(", ");
            let more = match numbers.len().saturating_sub(NAMED) {
                0 => String::new(),
                n => format!(" and {n} more"),
            };
            session.note(&format!(
                "the backs of {names}{more} see the others, and the fronts hardly do: probably turned inside out \
                 (--flip NAME turns objects, --two-sided gives all faces a back side)"
            ));
        }
        InsideOut::Everything => session.note(
            "no front sees another face, and backs see backs: if this is a room, its faces are turned outward \
             (--flip \"*\" turns all)",
        ),
    }
    Ok(())
}
