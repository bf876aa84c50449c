//! Phong's lobe as he published it: `phong`.
//!
//! B. T. Phong, *Illumination for computer generated pictures*, CACM 18(6), 1975. The paper has a
//! radiance, ks cosⁿ α; divided by cos θi it is a BRDF that is neither reciprocal nor bounded. For
//! materials of old files only; `lewis` is the physically plausible form of this lobe.

use super::BrdfError;
use super::arguments::Arguments;
use super::lambert::Lambert;
use super::lewis::{about, mirrored, power};
use super::lobe::{Lobe, Reflect, Spread};
use super::models::{EXPONENT, KD, KS, ModelInfo, PLAIN};
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::TAU;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "phong",
    aliases: &["phong_original"],
    title: "Phong (original)",
    paper: "B. T. Phong, Illumination for computer generated pictures, CACM 18(6), 1975",
    parameters: &[KD, KS, EXPONENT],
    examples: &[
        "phong kd = 0.3 ks = 0.4 n = 10",
        "phong kd = (0.1, 0.2, 0.3) ks = 0.5 n = 200",
    ],
    is_reciprocal: false,
    is_energy_safe: false,
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    Ok(vec![
        Lobe::Lambert(Lambert {
            albedo: arguments.color("kd"),
        }),
        Lobe::Phong(Phong {
            scale: arguments.color("ks"),
            exponent: arguments.number("n"),
        }),
    ])
}

/// ks cosⁿ α/cos θi, α the angle to the specular direction.
#[derive(Clone, Debug)]
pub(super) struct Phong {
    /// Not an albedo: with ks = 1, n = 20, the albedo is 0.29 at normal incidence, but 1.6 at 89°.
    scale: Rgb,
    exponent: f64,
}

impl Reflect for Phong {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.scale * (power(mirrored(wo).dot(wi), self.exponent) / wi.z)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        (self.exponent + 1.0) / TAU * power(mirrored(wo).dot(wi), self.exponent)
    }

    fn sample(&self, wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        let cos = (1.0 - u1).powf(1.0 / (self.exponent + 1.0));
        about(mirrored(wo), cos, u2)
    }

    fn spread(&self) -> Spread {
        Spread::Glossy(0.5f64.powf(1.0 / (self.exponent + 1.0)).acos())
    }
}
