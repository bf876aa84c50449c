//! Diffuse surfaces that darken or brighten towards their limb, as moons do: `minnaert`.
//!
//! M. Minnaert, *The reciprocity principle in lunar photometry*, Astrophysical Journal 93, 1941,
//! in its reciprocal form.

use super::BrdfError;
use super::arguments::Arguments;
use super::lobe::{Lobe, Reflect, Spread};
use super::models::{ModelInfo, PLAIN, ParameterInfo};
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, TAU};

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "minnaert",
    title: "Minnaert",
    paper: "M. Minnaert, The reciprocity principle in lunar photometry, ApJ 93, 1941",
    parameters: &[
        ParameterInfo::color("kd", [0.0, 1.0], "reflectance where k = 1").also(&["rho", "rd"]),
        ParameterInfo::number("k", [0.0, 10.0], "darkening of the rim; 1 is Lambert's"),
    ],
    examples: &[
        "minnaert kd = 0.5 k = 0.6",
        "minnaert kd = (0.9, 0.7, 0.5) k = 1.5",
        "minnaert kd = 1 k = 10",
    ],
    is_energy_safe: false,
    make,
    ..PLAIN
};

/// Rejects surfaces that reflect more uniform light than they receive. Below k = 1 the reflectance
/// is still unbounded at grazing angles.
fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let (kd, k) = (arguments.color("kd"), arguments.number("k"));
    let mean = kd.max_channel() * 4.0 / (k + 1.0).powi(2);
    if mean > 1.0 + 1e-9 {
        return Err(BrdfError::Energy {
            what: format!("the mean reflectance 4 kd/(k + 1)² of `minnaert` with k = {k}"),
            sum: mean,
        });
    }
    Ok(vec![Lobe::Minnaert(Minnaert { kd, k })])
}

/// kd/π (cos θi cos θo)^(k − 1). Its albedo is kd 2/(k + 1) cos^(k − 1) θo.
#[derive(Clone, Debug)]
pub(super) struct Minnaert {
    kd: Rgb,
    k: f64,
}

/// Lower bound for products of cosines, whose negative powers are unbounded.
const GRAZING: f64 = 1e-12;

impl Reflect for Minnaert {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.kd * (FRAC_1_PI * (wo.z * wi.z).max(GRAZING).powf(self.k - 1.0))
    }

    fn pdf(&self, _wo: DVec3, wi: DVec3) -> f64 {
        (self.k + 1.0) / TAU * wi.z.powf(self.k)
    }

    fn sample(&self, _wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        super::lewis::about(DVec3::Z, (1.0 - u1).powf(1.0 / (self.k + 1.0)), u2)
    }

    fn spread(&self) -> Spread {
        Spread::Matt
    }
}
