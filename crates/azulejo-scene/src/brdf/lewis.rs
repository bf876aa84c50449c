//! Phong's lobe made reciprocal and bounded: `lewis`.
//!
//! R. R. Lewis, *Making shaders more physically plausible*, Computer Graphics Forum 13(2), 1994;
//! sampling after Lafortune and Willems, *Using the modified Phong reflectance model for
//! physically based rendering*, 1994.

use super::BrdfError;
use super::arguments::Arguments;
use super::lambert::Lambert;
use super::lobe::{Lobe, Reflect, Spread};
use super::models::{EXPONENT, KD, KS, ModelInfo, PLAIN};
use crate::Rgb;
use crate::math::Frame;
use glam::DVec3;
use std::f64::consts::TAU;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "lewis",
    aliases: &["lewis_phong"],
    title: "Lewis (modified Phong)",
    paper: "R. R. Lewis, Making shaders more physically plausible, CGF 13(2), 1994",
    parameters: &[KD, KS, EXPONENT],
    examples: &[
        "lewis kd = 0.3 ks = 0.6 n = 20",
        "lewis ks = 1 n = 0",
        "lewis kd = (0.1, 0.2, 0.3) ks = 0.5 n = 1000",
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
        Lobe::Lewis(Lewis {
            albedo: arguments.color("ks"),
            exponent: arguments.number("n"),
        }),
    ])
}

/// ks (n + 2)/(2π) cosⁿ of the angle to the specular direction.
#[derive(Clone, Debug)]
pub(super) struct Lewis {
    /// Albedo at normal incidence; it falls with the angle.
    albedo: Rgb,
    exponent: f64,
}

impl Lewis {
    /// A lobe of albedo 1 at normal incidence.
    pub(super) fn white(exponent: f64) -> Lewis {
        Lewis {
            albedo: Rgb::WHITE,
            exponent,
        }
    }
}

impl Reflect for Lewis {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let power = power(mirrored(wo).dot(wi), self.exponent);
        self.albedo * ((self.exponent + 2.0) / TAU * power)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        (self.exponent + 1.0) / TAU * power(mirrored(wo).dot(wi), self.exponent)
    }

    fn sample(&self, wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        about(
            mirrored(wo),
            (1.0 - u1).powf(1.0 / (self.exponent + 1.0)),
            u2,
        )
    }

    fn spread(&self) -> Spread {
        // ∫ cosⁿ over the cone is 1 − cosⁿ⁺¹ of the whole.
        Spread::Glossy(0.5f64.powf(1.0 / (self.exponent + 1.0)).acos())
    }
}

/// cosⁿ, and 0 for negative cosines, also for n = 0, so that it is continuous in n.
pub(super) fn power(cos: f64, n: f64) -> f64 {
    if cos > 0.0 { cos.min(1.0).powf(n) } else { 0.0 }
}

/// The specular direction.
pub(super) fn mirrored(w: DVec3) -> DVec3 {
    DVec3::new(-w.x, -w.y, w.z)
}

/// The direction at an angle to an axis, rotated about it by the fraction `turn` of a full turn.
pub(super) fn about(axis: DVec3, cos: f64, turn: f64) -> DVec3 {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (y, x) = (TAU * turn).sin_cos();
    Frame::from_normal(axis).to_world(DVec3::new(sin * x, sin * y, cos))
}
