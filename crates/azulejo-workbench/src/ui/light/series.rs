//! Convergence measures as curves.

use azulejo::trace::time::Instant;
use azulejo::trace::{Measure, Measured};

/// Limit on the points of a curve: more than a panel has pixels.
const MAX_POINTS: usize = 400;
/// Limit on the number of curves; the latest are kept.
const MAX_CURVES: usize = 16;

/// Residual of one replicate over the bounces.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualCurve {
    /// Index of the independent replicate.
    pub replicate: u32,
    /// Bounces, and log₁₀ of the residual.
    pub points: Vec<[f64; 2]>,
    /// Whether the same replicate was solved again later.
    pub is_superseded: bool,
}

/// All curves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConvergenceCurves {
    /// Residuals; one curve for each time a replicate was solved.
    pub residuals: Vec<ResidualCurve>,
    /// log₁₀ of seconds since the solver started, log₁₀ of the estimated error of the irradiance.
    pub errors: Vec<[f64; 2]>,
    /// The same for the radiosity of the patches.
    pub patch_errors: Vec<[f64; 2]>,
}

impl ConvergenceCurves {
    /// Sorts measures into curves and thins them. Values without a logarithm are skipped.
    pub fn new(measures: &[Measured], began: Instant) -> ConvergenceCurves {
        let mut curves = ConvergenceCurves::default();
        let mut bounces = Vec::new();
        for measured in measures {
            let after = measured.at.saturating_duration_since(began).as_secs_f64();
            let at = after.max(1e-3).log10();
            match measured.measure {
                Measure::Residual {
                    replicate,
                    iteration,
                    value,
                } => residual(&mut bounces, replicate, iteration, value),
                Measure::Error(value) => push(&mut curves.errors, at, value),
                Measure::PatchError(value) => push(&mut curves.patch_errors, at, value),
                _ => {}
            }
        }
        bounces.drain(..bounces.len().saturating_sub(MAX_CURVES));
        curves.residuals = bounces;
        for curve in &mut curves.residuals {
            thin(&mut curve.points);
        }
        thin(&mut curves.errors);
        thin(&mut curves.patch_errors);
        curves
    }
}

fn residual(curves: &mut Vec<ResidualCurve>, replicate: u32, iteration: u32, value: f64) {
    let x = f64::from(iteration);
    let latest = curves.iter_mut().rev().find(|c| c.replicate == replicate);
    match latest {
        // Continues the same solution.
        Some(curve) if curve.points.last().is_some_and(|p| p[0] < x) => {
            push(&mut curve.points, x, value);
        }
        latest => {
            let mut points = Vec::new();
            push(&mut points, x, value);
            if points.is_empty() {
                return;
            }
            if let Some(curve) = latest {
                curve.is_superseded = true;
            }
            curves.push(ResidualCurve {
                replicate,
                points,
                is_superseded: false,
            });
        }
    }
}

fn push(points: &mut Vec<[f64; 2]>, x: f64, value: f64) {
    let y = value.log10();
    if y.is_finite() {
        points.push([x, y]);
    }
}

/// Keeps every n-th point, and always the last one.
fn thin(points: &mut Vec<[f64; 2]>) {
    let step = points.len().div_ceil(MAX_POINTS).max(1);
    let last = points.len().saturating_sub(1);
    let mut index = 0;
    points.retain(|_| {
        let keep = index % step == 0 || index == last;
        index += 1;
        keep
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn curves(measures: &[Measure]) -> ConvergenceCurves {
        let began = Instant::now();
        let at = |(k, &measure): (usize, &Measure)| Measured {
            at: began + Duration::from_secs(1 + k as u64),
            measure,
        };
        let measured: Vec<Measured> = measures.iter().enumerate().map(at).collect();
        ConvergenceCurves::new(&measured, began)
    }

    fn bounce(replicate: u32, iteration: u32, value: f64) -> Measure {
        Measure::Residual {
            replicate,
            iteration,
            value,
        }
    }

    #[test]
    fn a_replicate_that_is_solved_again_gets_a_new_curve() {
        let curves = curves(&[
            bounce(0, 1, 1.0),
            bounce(0, 2, 0.1),
            bounce(1, 1, 1.0),
            bounce(0, 1, 0.01),
        ]);
        let kinds: Vec<_> = (curves.residuals.iter())
            .map(|c| (c.replicate, c.points.len(), c.is_superseded))
            .collect();
        assert_eq!(kinds, [(0, 2, true), (1, 1, false), (0, 1, false)]);
        assert_eq!(curves.residuals[0].points, [[1.0, 0.0], [2.0, -1.0]]);
    }

    #[test]
    fn what_has_no_logarithm_is_left_out() {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let curves = curves(&[
                bounce(0, 1, value),
                Measure::Error(value),
                Measure::PatchError(value),
            ]);
            assert_eq!(curves, ConvergenceCurves::default(), "{value}");
        }
    }

    #[test]
    fn long_series_are_thinned_and_keep_their_ends() {
        let measures: Vec<Measure> = (1..=100_000)
            .map(|k| Measure::Error(1.0 / f64::from(k)))
            .collect();
        let errors = curves(&measures).errors;
        assert!(errors.len() <= MAX_POINTS + 1, "{}", errors.len());
        assert_eq!(errors.first(), Some(&[0.0, 0.0]));
        assert_eq!(errors.last().map(|p| p[1]), Some(1e-5f64.log10()));
    }

    #[test]
    fn of_many_curves_the_last_are_kept() {
        let many: Vec<Measure> = (0..1_000).map(|_| bounce(0, 1, 1.0)).collect();
        let residuals = curves(&many).residuals;
        assert_eq!(residuals.len(), MAX_CURVES);
        assert!(!residuals.last().unwrap().is_superseded);
    }
}
