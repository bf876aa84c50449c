//! Form factors whose values are known, by every engine.

use super::engines::{CheckedEngine, EngineFamily};
use super::record::{CheckOutcome, CheckRecord, ValidationPart};
use super::{ErrorCurve, Validator};
use crate::clock::Clock;
use crate::failure::Failure;
use crate::known::factors::{Answer, Case, CaseKind, cases, series};
use crate::pass;
use azulejo_factors::form_factors::Closure;
use azulejo_factors::{Engine, FormFactorOptions, Hemicube};

const PART: ValidationPart = ValidationPart::ClosedForms;

/// Estimates further from the truth than this many standard errors are outlying.
pub const FAR: f64 = 4.0;

/// Share of an engine's answers that may be outlying. Of normal errors it would be 0.006%; but standard
/// errors are estimates themselves, from a few replicates.
pub const OUTLYING: f64 = 0.01;

/// Relative difference in size between curved bodies and the facets that are rendered for them.
const FACETS: f64 = 0.015;

/// Rounding of sums: answers without error are right to this.
const ROUNDING: f64 = 1e-12;

/// All cases: those that test one capability each, and series over ranges of parameters.
pub fn all() -> Vec<Case> {
    [cases(), series()].concat()
}

/// Checks all cases by all engines.
pub fn check(validator: &Validator) -> Result<Vec<CheckRecord>, Failure> {
    let selected: Vec<Case> = all()
        .into_iter()
        .filter(|case| validator.wants(PART, &case.id))
        .collect();
    let mut records = Vec::new();
    if selected.is_empty() {
        return Ok(records);
    }
    for engine in &validator.engines.engines {
        validator.tell(&format!(
            "{} closed forms by {}",
            selected.len(),
            engine.name
        ));
        let first = records.len();
        for case in &selected {
            records.push(answered(validator, engine, case)?);
        }
        records.extend(outlying(engine, &records[first..]));
    }
    Ok(records)
}

/// One case by one engine.
fn answered(
    validator: &Validator,
    engine: &CheckedEngine,
    case: &Case,
) -> Result<CheckRecord, Failure> {
    let clock = Clock::start();
    let rays = validator.effort.rays;
    let options = FormFactorOptions {
        closure: closure(engine, case),
        ..engine.options(&case.scene, case.size, rays, validator.seed)
    };
    let tracer = engine.prepared.tracer(&case.scene)?;
    let outcome = case.ask(&tracer, &options, validator.progress);
    let (answer, factors) = outcome.map_err(pass::failure)?;
    let (bound, is_estimate) = bound(engine.family, case, &answer);
    let values = [answer.value, case.truth.value, bound];
    let mut record =
        CheckRecord::new(PART, &*case.id, values).of(engine.name, case.description.clone());
    if is_estimate && record.outcome == CheckOutcome::Failed {
        record.outcome = CheckOutcome::Outlying;
    }
    record.source = case.provenance();
    record.expected_error = case.truth.error;
    record.standard_error = Some(answer.error).filter(|e| e.is_finite() && *e > 0.0);
    record.note = factors.engine_used.notes.join("; ");
    record.seconds = clock.wall();
    Ok(record)
}

/// Where mirrors make endless chains, closure takes care of what the analytic engine leaves to rays.
fn closure(engine: &CheckedEngine, case: &Case) -> Closure {
    match (engine.family, case.kind) {
        (EngineFamily::Analytic, CaseKind::Mirrors) => Closure::Always,
        _ => Closure::default(),
    }
}

/// The largest deviation that passes, and whether chance may exceed it.
fn bound(family: EngineFamily, case: &Case, answer: &Answer) -> (f64, bool) {
    let truth = case.truth.value.abs();
    let exact = match case.kind {
        CaseKind::Polygons => Some(1e-10),
        CaseKind::Shadow => Some(1e-6),
        CaseKind::Mirrors => Some(1e-8),
        CaseKind::Curved | CaseKind::Glass => None,
    };
    match (family, exact) {
        (EngineFamily::Analytic, Some(relative)) => (relative * truth + case.truth.error, false),
        (family, _) => {
            let is_faceted = family == EngineFamily::Rendering && case.kind == CaseKind::Curved;
            let facets = if is_faceted { FACETS * truth } else { 0.0 };
            let estimate = (FAR * answer.error).max(ROUNDING);
            (estimate + case.truth.error + facets, true)
        }
    }
}

/// The check of the number of outlying answers of an engine.
fn outlying(engine: &CheckedEngine, answers: &[CheckRecord]) -> Option<CheckRecord> {
    let number = |outcome| answers.iter().filter(|a| a.outcome == outcome).count() as f64;
    let most = (OUTLYING * answers.len() as f64).ceil();
    let values = [number(CheckOutcome::Outlying), 0.0, most];
    let words = format!("answers beyond {FAR} standard errors, of {}", answers.len());
    let record = CheckRecord::new(PART, "outlying answers", values).of(engine.name, words);
    (!answers.is_empty()).then_some(record)
}

/// Root mean square of the relative errors of unoccluded polygons against rays or pixels of a row.
pub fn convergence(validator: &Validator) -> Result<Vec<ErrorCurve>, Failure> {
    let flat = all().into_iter();
    let flat = flat.filter(|c| c.kind == CaseKind::Polygons && validator.wants(PART, &c.id));
    let flat: Vec<Case> = flat.step_by(validator.effort.convergence_step).collect();
    let mut curves = Vec::new();
    if flat.is_empty() {
        return Ok(curves);
    }
    let engines = validator.engines.engines.iter();
    // Closed forms leave no error of polygons.
    for engine in engines.filter(|e| !e.formulas) {
        let mut points = Vec::new();
        for step in 0..validator.effort.convergence {
            points.push(one_effort(validator, engine, &flat, step)?);
        }
        curves.push(ErrorCurve {
            engine: engine.name,
            points,
        });
    }
    Ok(curves)
}

/// Samples of a row and the error with them: 256 rays, or 4 hemicubes of 16 pixels, four times as many
/// with each step.
fn one_effort(
    validator: &Validator,
    engine: &CheckedEngine,
    flat: &[Case],
    step: u32,
) -> Result<[f64; 2], Failure> {
    let (mut samples, mut squares) = (0.0, 0.0);
    for case in flat {
        let mut options = FormFactorOptions {
            closure: Closure::Never,
            ..engine.options(&case.scene, case.size, 0, validator.seed)
        };
        samples = match &mut options.engine {
            Engine::Hemicube(hemicube) | Engine::Hybrid(hemicube) => pixels(hemicube, step),
            _ => {
                options.rays = 256 << (2 * step);
                f64::from(options.rays)
            }
        };
        let tracer = engine.prepared.tracer(&case.scene)?;
        let outcome = case.ask(&tracer, &options, validator.progress);
        let (answer, _) = outcome.map_err(pass::failure)?;
        squares += (answer.off(case) / case.truth.value).powi(2);
    }
    Ok([samples, (squares / flat.len() as f64).sqrt()])
}

/// Sets the points and the resolution of a step, and returns the pixels of a patch.
fn pixels(hemicube: &mut Hemicube, step: u32) -> f64 {
    hemicube.points = 4 << (2 * (step / 2));
    hemicube.resolution = 16 << step.div_ceil(2);
    // A top face, and four halves.
    3.0 * f64::from(hemicube.points) * f64::from(hemicube.resolution).powi(2)
}
