//! Blinn's lobe around the half vector, normalized: `blinn`.
//!
//! J. F. Blinn, *Models of light reflection for computer synthesized pictures*, SIGGRAPH 1977. The
//! factor makes the albedo exactly ks at normal incidence; (n + 8)/(8π), which is often used,
//! approximates it.

use super::BrdfError;
use super::arguments::Arguments;
use super::lambert::Lambert;
use super::lobe::{Lobe, Reflect, Spread};
use super::microfacet::{HalfVector, mirrored_by};
use super::models::{EXPONENT, KD, KS, ModelInfo, PLAIN};
use super::quadrature::cosine_hemisphere;
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "blinn",
    aliases: &["blinn_half", "blinn_phong"],
    title: "Blinn",
    paper: "J. F. Blinn, Models of light reflection for computer synthesized pictures, SIGGRAPH 1977",
    parameters: &[KD, KS, EXPONENT],
    examples: &[
        "blinn kd = 0.3 ks = 0.6 n = 20",
        "blinn ks = 1 n = 0",
        "blinn kd = (0.1, 0.2, 0.3) ks = 0.5 n = 1000",
    ],
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    arguments.bounded_sum("kd", "ks")?;
    Ok(vec![
        Lobe::Lambert(Lambert {
            albedo: arguments.color("kd"),
        }),
        Lobe::Blinn(Blinn {
            albedo: arguments.color("ks"),
            exponent: arguments.number("n"),
        }),
    ])
}

/// Exponents below this are sampled as diffuse surfaces are: weights are then at most C(2) π = 1.2 times the albedo. By
/// half vectors they are in proportion to 1/cos θh, whose variance is (n + 2)/n: without bound where n is 0, and the
/// light between close walls the work of a few paths.
const WIDE: f64 = 2.0;

/// ks C(n) cosⁿ θh.
#[derive(Clone, Debug)]
pub(super) struct Blinn {
    /// Albedo at normal incidence; it falls with the angle.
    albedo: Rgb,
    exponent: f64,
}

/// C(n), 1/sr.
pub(super) fn normalization(n: f64) -> f64 {
    (n + 2.0) * (n + 4.0) / (8.0 * PI * ((-0.5 * n).exp2() + n))
}

/// Density of the half vectors of [`sample_half`], 1/sr, for the cosine to the normal.
pub(super) fn half_pdf(n: f64, cos: f64) -> f64 {
    (n + 2.0) / TAU * cos.powf(n + 1.0)
}

/// Cosine to the normal of a half vector.
pub(super) fn sample_half(n: f64, u: f64) -> f64 {
    (1.0 - u).powf(1.0 / (n + 2.0))
}

impl Reflect for Blinn {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let cos = HalfVector::new(wo, wi).cos_h();
        self.albedo * (normalization(self.exponent) * cos.powf(self.exponent))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if self.exponent < WIDE {
            return wi.z / PI;
        }
        let half = HalfVector::new(wo, wi);
        half.reflected(half_pdf(self.exponent, half.cos_h()))
    }

    fn sample(&self, wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        if self.exponent < WIDE {
            return cosine_hemisphere(u1, u2);
        }
        let cos = sample_half(self.exponent, u1);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (y, x) = (TAU * u2).sin_cos();
        mirrored_by(wo, DVec3::new(sin * x, sin * y, cos))
    }

    fn spread(&self) -> Spread {
        // Reflection doubles the angle of the half vector.
        Spread::Glossy(2.0 * sample_half(self.exponent, 0.5).acos())
    }
}
