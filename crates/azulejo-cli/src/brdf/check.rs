//! `brdf check`: tests whether a model has the properties that it claims.

use super::args::CheckArgs;
use super::model;
use crate::failure::Failure;
use crate::report::{Report, number, numbers, percent, short};
use crate::session::Session;
use azulejo_scene::Brdf;
use azulejo_scene::brdf::check::{self, ANGLES, AZIMUTH, Angle, Reciprocity};
use azulejo_scene::brdf::{Content, Description, Model, find};
use azulejo_trace::Progress;
use rayon::prelude::*;
use serde_json::{Value, json};

/// Pairs of directions in the test of reciprocity.
const PAIRS: u32 = 20_000;

/// Relative differences above this are not rounding errors, also in models with quadrature.
const SAME: f64 = 1e-9;

/// Largest albedo that is accepted: 1 with the error of quadrature.
const BRIGHT: f64 = 1.0 + 1e-4;

/// Smallest p-value of the χ² test that is accepted.
const CHANCE: f64 = 1e-5;

/// Largest deviation of a mean that is accepted, in standard errors.
const FAR: f64 = 5.0;

/// Properties that a model claims, besides samples that follow their density.
#[derive(Clone, Copy)]
struct ModelProperties {
    is_reciprocal: bool,
    is_energy_safe: bool,
}

/// The result of one test.
struct CheckResult {
    key: &'static str,
    label: &'static str,
    is_promised: bool,
    holds: bool,
    words: String,
}

/// Runs `brdf check`; the second value is the failure, if there is one.
pub fn run(
    args: &CheckArgs,
    session: &mut Session,
) -> Result<(Report, Result<(), Failure>), Failure> {
    let brdf = model::read(&args.model, session)?;
    let (reciprocity, angles) =
        session.with_progress(|progress| measure(&brdf, args.samples, progress))?;
    let verdicts = verdicts(promises(brdf.description()), &reciprocity, &angles);
    let mut report = Report::default();
    let words = model::words(&brdf);
    report.fact("model", words.clone(), "model", words);
    table(&angles, &mut report);
    verdicts
        .iter()
        .for_each(|verdict| say(verdict, &mut report));
    let failed = verdicts.iter().filter(|v| v.is_promised && !v.holds);
    let failed: Vec<&str> = failed.map(|v| v.label).collect();
    report.value("passed", failed.is_empty());
    let end = if failed.is_empty() {
        Ok(())
    } else {
        Err(Failure::Failed(format!(
            "does not hold: {}",
            failed.join(", ")
        )))
    };
    Ok((report, end))
}

fn measure(
    brdf: &Brdf,
    samples: u32,
    progress: &Progress,
) -> Result<(Reciprocity, Vec<Angle>), Failure> {
    progress.begin("check", 2 * ANGLES.len() as u64 + 1);
    let reciprocity = check::reciprocity(brdf, PAIRS);
    progress.advance(1)?;
    let angle = |theta: f64| {
        let wo = check::direction(theta, AZIMUTH);
        let weights = check::weights(brdf, wo, samples);
        progress.advance(1)?;
        let sampling = check::chi_square(brdf, wo, samples);
        progress.advance(1)?;
        Ok(Angle {
            theta,
            albedo: weights.expected + brdf.mirror(wo.z),
            sampling,
            weights,
        })
    };
    let angles: Result<Vec<Angle>, Failure> = ANGLES.into_par_iter().map(angle).collect();
    Ok((reciprocity, angles?))
}

/// The properties in the table of models; those of a combination are common to all of its parts.
fn promises(description: &Description) -> ModelProperties {
    let properties = |model: &Model| {
        find(&model.name).map_or(ModelProperties::NONE, |info| ModelProperties {
            is_reciprocal: info.is_reciprocal,
            is_energy_safe: info.is_energy_safe,
        })
    };
    match description {
        Description::Model(model) => properties(model),
        Description::Combination(parts) => ModelProperties {
            is_reciprocal: parts.iter().all(|(_, m)| properties(m).is_reciprocal),
            is_energy_safe: parts.iter().all(|(_, m)| properties(m).is_energy_safe),
        },
        Description::File { content, .. } => match content.as_deref() {
            Some(Content::Text(description)) => promises(description),
            _ => ModelProperties::NONE,
        },
    }
}

impl ModelProperties {
    /// Measured data claims nothing.
    const NONE: ModelProperties = ModelProperties {
        is_reciprocal: false,
        is_energy_safe: false,
    };
}

fn verdicts(
    promises: ModelProperties,
    reciprocity: &Reciprocity,
    angles: &[Angle],
) -> Vec<CheckResult> {
    // The worst angle decides each test, and is named. What is not a number is worse than all that is.
    let largest = |of: &dyn Fn(&Angle) -> f64| {
        let values = angles.iter().map(|a| (of(a), a.theta));
        let worse = |a: (f64, f64), b: (f64, f64)| if b.0 > a.0 || b.0.is_nan() { b } else { a };
        values.fold((f64::NEG_INFINITY, 0.0), worse)
    };
    let brightest = largest(&|a| {
        if a.albedo.is_finite() {
            a.albedo.max_channel()
        } else {
            f64::NAN
        }
    });
    let unlikely = largest(&|a| -a.sampling.probability);
    let off = largest(&|a| a.weights.deviation());
    // Models may lack reciprocity or exceed an albedo of 1 if they do not claim otherwise; sampling has to be right.
    vec![
        CheckResult {
            key: "reciprocity",
            label: "reciprocal",
            is_promised: promises.is_reciprocal,
            holds: reciprocity.largest <= SAME,
            words: format!(
                "light and eye exchanged, {} pairs: at most {} different",
                reciprocity.pairs,
                percent(reciprocity.largest)
            ),
        },
        CheckResult {
            key: "energy",
            label: "energy-safe",
            is_promised: promises.is_energy_safe,
            holds: brightest.0 <= BRIGHT,
            words: format!("albedo at most {:.5}, at {}°", brightest.0, brightest.1),
        },
        CheckResult {
            key: "sampling",
            label: "samples follow their density",
            is_promised: true,
            holds: -unlikely.0 >= CHANCE,
            words: format!(
                "χ²: the smallest p-value is {}, at {}°",
                short(-unlikely.0),
                unlikely.1
            ),
        },
        CheckResult {
            key: "furnace",
            label: "white furnace",
            is_promised: true,
            holds: off.0 <= FAR,
            words: format!(
                "mean sample weights deviate from the albedo by at most {:.1} standard errors, at {}°",
                off.0, off.1
            ),
        },
    ]
}

fn say(verdict: &CheckResult, report: &mut Report) {
    let words = match (verdict.holds, verdict.is_promised) {
        (true, _) => "holds",
        (false, true) => "FAILS",
        (false, false) => "does not hold, and is not claimed",
    };
    report.line(verdict.label, format!("{words}: {}", verdict.words));
    report.value(
        verdict.key,
        json!({
            "promised": verdict.is_promised,
            "holds": verdict.holds,
            "words": verdict.words,
        }),
    );
}

/// Adds the results at each angle.
fn table(angles: &[Angle], report: &mut Report) {
    report.line(
        "angle",
        "albedo    mean weight ± its error       χ² (cells)   p-value      lost",
    );
    let mut rows = Vec::new();
    for angle in angles {
        let (weights, sampling) = (&angle.weights, &angle.sampling);
        report.line(
            &format!("{}°", angle.theta),
            format!(
                "{:.5}   {:.5} ± {:.5}          {:>8.1} ({:>4})   {:.5}   {:>6}",
                angle.albedo.max_channel(),
                weights.mean.max_channel(),
                weights.standard_error.max_channel(),
                sampling.statistic,
                sampling.degrees + 1,
                sampling.probability,
                percent(sampling.lost),
            ),
        );
        rows.push(row(angle));
    }
    report.value("angles", Value::Array(rows));
}

fn row(angle: &Angle) -> Value {
    json!({
        "theta": angle.theta,
        "albedo": numbers(angle.albedo.to_array()),
        "mean_weight": numbers(angle.weights.mean.to_array()),
        "standard_error": numbers(angle.weights.standard_error.to_array()),
        "largest_weight": number(angle.weights.largest),
        "chi_square": number(angle.sampling.statistic),
        "degrees_of_freedom": angle.sampling.degrees,
        "probability": number(angle.sampling.probability),
        "lost": number(angle.sampling.lost),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A comparison with NaN is neither larger nor smaller, and would pass unseen.
    #[test]
    fn values_that_are_not_numbers_pass_no_test() {
        let model = Model::new("lambert", []);
        let brdf = Brdf::new(Description::Model(model)).unwrap();
        let (mut reciprocity, mut angles) = measure(&brdf, 1000, &Progress::new()).unwrap();
        let promises = ModelProperties {
            is_reciprocal: true,
            is_energy_safe: true,
        };
        let all = |verdicts: Vec<CheckResult>, holds: bool| {
            verdicts.iter().all(|verdict| verdict.holds == holds)
        };
        assert!(all(verdicts(promises, &reciprocity, &angles), true));
        reciprocity.largest = f64::NAN;
        let worst = &mut angles[2];
        worst.albedo.g = f64::NAN;
        worst.sampling.probability = f64::NAN;
        worst.weights.mean.b = f64::NAN;
        assert!(all(verdicts(promises, &reciprocity, &angles), false));
    }
}
