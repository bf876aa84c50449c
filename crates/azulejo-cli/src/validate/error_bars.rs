//! How often the truth lies within the error bars, over many seeds.

use super::record::{CheckRecord, ValidationPart};
use super::{CoverageCurve, Validator};
use crate::clock::Clock;
use crate::failure::Failure;
use crate::known::factors::{Case, CaseKind, Question, cases};
use crate::pass;
use azulejo_exchange::{
    Enclosure, ExchangeError, GroupBy, HeatProblem, RowCondition, SpectralRange, SurfaceBand,
    exchange_factors, heat_balance,
};
use azulejo_factors::form_factors::{Closure, Plan};
use azulejo_factors::{Engine, FormFactorOptions, PatchSize};
use azulejo_scene::synthetic::cube_room;
use azulejo_trace::Tracer;

const PART: ValidationPart = ValidationPart::ErrorBars;

/// Share of answers that lie within two standard errors of the truth, at least; 0.954 of normal errors.
const WITHIN_TWO: f64 = 0.93;

/// Rays of a row.
const RAYS: u32 = 1 << 10;

/// Cases of each kind.
const CASES: usize = 4;

/// Standard errors at which coverage is drawn.
const WIDTHS: [f64; 12] = [
    0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 3.0, 4.0,
];

/// The checks, and the curves of coverage.
pub fn check(validator: &Validator) -> Result<(Vec<CheckRecord>, Vec<CoverageCurve>), Failure> {
    let mut records = Vec::new();
    let mut curves = Vec::new();
    for (kind, name) in [
        (CaseKind::Polygons, "polygons"),
        (CaseKind::Shadow, "occluded polygons"),
        (CaseKind::Mirrors, "mirrors"),
        (CaseKind::Curved, "curved bodies"),
    ] {
        let subject = format!("form factors of {name}");
        if validator.wants(PART, &subject) {
            let clock = Clock::start();
            validator.tell(&format!(
                "error bars of {subject}, {} seeds",
                validator.effort.seeds
            ));
            let scores = factor_scores(validator, kind)?;
            records.push(covered(&subject, &scores, &clock));
            curves.push(curve(name.to_owned(), &scores));
        }
    }
    let names = ["conductances GR", "heat flows Q"];
    if names.iter().any(|name| validator.wants(PART, name)) {
        let clock = Clock::start();
        validator.tell(&format!(
            "error bars of exchange, {} seeds",
            validator.effort.seeds
        ));
        for (name, scores) in names.into_iter().zip(exchange_scores(validator)?) {
            records.push(covered(name, &scores, &clock));
            curves.push(curve(name.to_owned(), &scores));
        }
    }
    Ok((records, curves))
}

/// Deviations in standard errors of the answers to cases of a kind.
fn factor_scores(validator: &Validator, kind: CaseKind) -> Result<Vec<f64>, Failure> {
    let is_wanted = |c: &Case| c.kind == kind && matches!(c.question, Question::Factor { .. });
    let cases: Vec<Case> = cases().into_iter().filter(is_wanted).take(CASES).collect();
    let mut scores = Vec::new();
    for case in &cases {
        let tracer = Tracer::new(&case.scene);
        for seed in 0..validator.effort.seeds {
            let options = options(validator, seed);
            let outcome = case.ask(&tracer, &options, validator.progress);
            let (answer, _) = outcome.map_err(pass::failure)?;
            scores.push((answer.value - case.truth.value) / answer.error);
        }
    }
    Ok(scores)
}

fn options(validator: &Validator, seed: u64) -> FormFactorOptions {
    FormFactorOptions {
        engine: Engine::Rays,
        analytic: false,
        closure: Closure::Never,
        rays: RAYS,
        seed: validator.seed.wrapping_add(seed),
        ..FormFactorOptions::default()
    }
}

/// Emissivity and temperature of the faces of a cube.
const FACES: [(f64, f64); 6] = [
    (0.9, 300.0),
    (0.3, 400.0),
    (0.6, 350.0),
    (0.8, 500.0),
    (0.2, 450.0),
    (0.5, 600.0),
];

/// Deviations in standard errors of conductances between the faces of a cube of 24 facets, and of the
/// heat that faces give off; the truth is by closed forms.
fn exchange_scores(validator: &Validator) -> Result<[Vec<f64>; 2], Failure> {
    let exact = FormFactorOptions {
        engine: Engine::Analytic,
        closure: Closure::Never,
        ..FormFactorOptions::default()
    };
    let truth = solved(validator, &exact)?;
    let mut scores = [Vec::new(), Vec::new()];
    for seed in 0..validator.effort.seeds {
        let estimates = solved(validator, &options(validator, seed))?;
        for ((scores, estimates), truth) in scores.iter_mut().zip(&estimates).zip(&truth) {
            let pairs = estimates.iter().zip(truth);
            scores.extend(pairs.map(|((value, error), (truth, _))| (value - truth) / error));
        }
    }
    Ok(scores)
}

/// GR of all pairs of faces and the heat of faces, each with its standard error.
fn solved(
    validator: &Validator,
    options: &FormFactorOptions,
) -> Result<[Vec<(f64, f64)>; 2], Failure> {
    let progress = validator.progress;
    let scene = cube_room();
    let options = FormFactorOptions {
        size: PatchSize::Edge(0.5),
        ..options.clone()
    };
    let tracer = Tracer::new(&scene);
    let plan = Plan::new(&scene, &tracer, &options).map_err(pass::failure)?;
    let prepared = plan.prepare();
    let factors = prepared.compute(progress).map_err(pass::failure)?;
    let enclosure = Enclosure::new(&prepared, &scene, factors);
    let nodes = enclosure.groups(GroupBy::Face);
    let face = |node: &Option<u32>| FACES[node.map_or(0, |n| n as usize)];
    let band = SurfaceBand {
        enclosure: &enclosure,
        range: SpectralRange::Thermal,
        emissivity: nodes.of_rows.iter().map(|n| face(n).0).collect(),
    };
    let conditions = nodes
        .of_rows
        .iter()
        .map(|n| RowCondition::Temperature(face(n).1));
    let conditions: Vec<RowCondition> = conditions.collect();
    let network = exchange_factors(&band, &nodes, progress).map_err(failure)?;
    let problem = HeatProblem {
        bands: &[band],
        conditions: &conditions,
        surroundings: [0.0; 2],
        solar: &[],
    };
    let heat = heat_balance(&problem, &nodes, progress).map_err(failure)?;
    let pairs = (0..6).flat_map(|a| (a + 1..6).map(move |b| (a, b)));
    Ok([
        pairs.map(|(a, b)| network.conductance(a, b)).collect(),
        heat.node_heat
            .into_iter()
            .zip(heat.node_heat_errors)
            .collect(),
    ])
}

fn failure(error: ExchangeError) -> Failure {
    match error {
        ExchangeError::Cancelled => Failure::Cancelled,
        other => Failure::failed(other),
    }
}

fn share_within(scores: &[f64], width: f64) -> f64 {
    let inside = scores.iter().filter(|z| z.abs() <= width).count();
    inside as f64 / scores.len().max(1) as f64
}

/// The check that enough answers lie within two standard errors; more is not a fault.
fn covered(subject: &str, scores: &[f64], clock: &Clock) -> CheckRecord {
    let share = share_within(scores, 2.0);
    let (middle, half) = (0.5 * (1.0 + WITHIN_TWO), 0.5 * (1.0 - WITHIN_TWO));
    let one = 100.0 * share_within(scores, 1.0);
    CheckRecord {
        note: format!("{} answers; {one:.1}% within one", scores.len()),
        seconds: clock.wall(),
        ..CheckRecord::new(PART, subject, [share, middle, half]).of(
            "rays",
            "share of answers within two standard errors of the truth",
        )
    }
}

fn curve(name: String, scores: &[f64]) -> CoverageCurve {
    CoverageCurve {
        name,
        points: WIDTHS.map(|w| [w, share_within(scores, w)]).to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::record::CheckOutcome;

    #[test]
    fn coverage_counts_both_sides() {
        let scores = [-3.0, -1.5, 0.0, 0.5, 2.0];
        assert!((share_within(&scores, 2.0) - 0.8).abs() < 1e-12);
        let check = |scores: &[f64]| covered("x", scores, &Clock::start()).outcome;
        assert_eq!(check(&scores), CheckOutcome::Failed);
        assert_eq!(check(&[0.5; 3]), CheckOutcome::Passed);
        assert_eq!(check(&[f64::NAN]), CheckOutcome::Failed);
    }
}
