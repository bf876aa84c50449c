//! Checks of reflection models: reciprocity, energy conservation, and whether samples follow their
//! density. They return numbers, not verdicts, and are deterministic.
//!
//! ```
//! use azulejo_scene::brdf::{Brdf, check};
//!
//! let gold = Brdf::new("ggx_smith ax = 0.2 metal = gold".parse().unwrap()).unwrap();
//! assert!(check::reciprocity(&gold, 100).largest < 1e-12);
//! let wo = check::direction(60.0, 20.0);
//! assert!(check::albedo(&gold, wo).max_channel() < 1.0);
//! assert!(check::chi_square(&gold, wo, 10_000).probability > 1e-3);
//! ```

mod cells;
mod chi_square;
mod random;

pub use chi_square::{ChiSquare, chi_square};

use super::Brdf;
use crate::Rgb;
use cells::Cell;
use glam::DVec3;
use random::Random;

/// Angles to the normal that [`check`] tests, in degrees.
pub const ANGLES: [f64; 8] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0, 89.0];

/// The azimuth that [`check`] tests, in degrees: off the axes of all models.
pub const AZIMUTH: f64 = 20.0;

/// Sample counts of [`check`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Pairs of directions of the reciprocity test.
    pub pairs: u32,
    /// Samples at each angle.
    pub samples: u32,
}

impl Default for Effort {
    fn default() -> Effort {
        Effort {
            pairs: 10_000,
            samples: 100_000,
        }
    }
}

/// The results of [`check`] for one model.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Deviation from reciprocity.
    pub reciprocity: Reciprocity,
    /// At each of [`ANGLES`].
    pub angles: Vec<Angle>,
}

/// The results for one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Angle {
    /// Angle to the normal, in degrees.
    pub theta: f64,
    /// Directional albedo by quadrature, perfect specular reflection included.
    pub albedo: Rgb,
    /// Whether samples follow the density.
    pub sampling: ChiSquare,
    /// Statistics of the sample weights.
    pub weights: Weights,
}

impl Report {
    /// The angle with the largest albedo, and that albedo, of the largest channel.
    pub fn largest_albedo(&self) -> (f64, f64) {
        let albedo = |a: &Angle| (a.theta, a.albedo.max_channel());
        let albedos = self.angles.iter().map(albedo);
        albedos
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or_default()
    }
}

/// The largest difference between f(o, i) and f(i, o).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reciprocity {
    /// Number of pairs tested.
    pub pairs: u32,
    /// The largest difference of a channel over its larger value; 0 where both are 0.
    pub largest: f64,
    /// One of the two directions of that pair.
    pub wo: DVec3,
    /// The other.
    pub wi: DVec3,
}

/// Statistics of the sample weights of one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Number of samples, lost ones included.
    pub samples: u32,
    /// Their mean: the albedo without the perfectly specular part. With that part it is the
    /// radiance in a white furnace, under uniform light of radiance 1.
    pub mean: Rgb,
    /// Standard error of the mean.
    pub standard_error: Rgb,
    /// The largest weight of a channel.
    pub largest: f64,
    /// The expected mean, by quadrature.
    pub expected: Rgb,
}

impl Weights {
    /// The difference between mean and expected value in standard errors, of the worst channel.
    ///
    /// A difference of 2e-5, the error of the quadrature, is ignored.
    pub fn deviation(&self) -> f64 {
        let of = |c: usize| {
            let off = (self.mean[c] - self.expected[c]).abs();
            off / (self.standard_error[c] + 2e-5)
        };
        if !self.mean.is_finite() {
            return f64::NAN;
        }
        of(0).max(of(1)).max(of(2))
    }
}

/// The direction at an angle to the normal and an azimuth from the tangent, in degrees.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    let ((st, ct), (sp, cp)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    DVec3::new(st * cp, st * sp, ct)
}

/// Runs all checks, at [`ANGLES`].
pub fn check(brdf: &Brdf, effort: Effort) -> Report {
    let angle = |theta: f64| {
        let wo = direction(theta, AZIMUTH);
        let weights = weights(brdf, wo, effort.samples);
        Angle {
            theta,
            albedo: weights.expected + brdf.mirror(wo.z),
            sampling: chi_square(brdf, wo, effort.samples),
            weights,
        }
    };
    Report {
        reciprocity: reciprocity(brdf, effort.pairs),
        angles: ANGLES.map(angle).to_vec(),
    }
}

/// Exchanges light and viewer for pairs of directions: half of them at random, half near the
/// specular direction, where lobes are steep.
pub fn reciprocity(brdf: &Brdf, pairs: u32) -> Reciprocity {
    let mut random = Random::new(1);
    let mut worst = Reciprocity {
        pairs,
        largest: 0.0,
        wo: DVec3::Z,
        wi: DVec3::Z,
    };
    for pair in 0..pairs {
        let (wo, other) = (random.hemisphere(), random.hemisphere());
        let wi = if pair % 2 == 0 {
            other
        } else {
            near_mirrored(wo, other)
        };
        let (there, back) = (brdf.eval(wo, wi), brdf.eval(wi, wo));
        for channel in 0..3 {
            let (a, b) = (there[channel], back[channel]);
            let difference = (a - b).abs() / a.max(b).max(f64::MIN_POSITIVE);
            // What is not a number is worse than all that is.
            if difference > worst.largest || difference.is_nan() {
                worst = Reciprocity {
                    largest: difference,
                    wo,
                    wi,
                    ..worst
                };
            }
        }
    }
    worst
}

/// The specular direction, moved a tenth of the way towards another.
fn near_mirrored(wo: DVec3, towards: DVec3) -> DVec3 {
    (DVec3::new(-wo.x, -wo.y, wo.z) * 0.9 + towards * 0.1).normalize_or(DVec3::Z)
}

/// Albedo for `wo`, perfect specular reflection included, by adaptive quadrature; to about 1e-5
/// unless lobes are narrower than half a degree.
pub fn albedo(brdf: &Brdf, wo: DVec3) -> Rgb {
    if !(wo.z > 0.0) {
        return Rgb::BLACK;
    }
    scattered(brdf, wo) + brdf.mirror(wo.z)
}

fn scattered(brdf: &Brdf, wo: DVec3) -> Rgb {
    let reflected = |wi: DVec3| brdf.eval(wo, wi) * wi.z;
    Cell::HEMISPHERE.integral(wo, &reflected)
}

/// Statistics of the weights of samples for `wo`, whose mean is compared with the albedo by
/// quadrature.
pub fn weights(brdf: &Brdf, wo: DVec3, samples: u32) -> Weights {
    let mut random = Random::new(2);
    let (mut sum, mut squares, mut largest) = (Rgb::BLACK, Rgb::BLACK, 0.0f64);
    for _ in 0..samples {
        let Some(sample) = brdf.sample(wo, random.numbers()) else {
            continue;
        };
        sum += sample.weight;
        squares += sample.weight * sample.weight;
        largest = largest.max(sample.weight.max_channel());
    }
    let count = f64::from(samples.max(2));
    let mean = sum / count;
    let variance = squares / count - mean * mean;
    Weights {
        samples,
        mean,
        standard_error: variance.map(|v| (v.max(0.0) / (count - 1.0)).sqrt()),
        largest,
        expected: scattered(brdf, wo),
    }
}
