//! The same in all directions: `diffuse`.

use super::BrdfError;
use super::arguments::Arguments;
use super::lobe::{Lobe, Reflect, Spread};
use super::models::{KD, ModelInfo};
use super::quadrature::cosine_hemisphere;
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "diffuse",
    aliases: &["lambert"],
    title: "Lambert",
    paper: "J. H. Lambert, Photometria, 1760",
    parameters: &[KD],
    examples: &["diffuse kd = (0.8, 0.5, 0.3)"],
    has_fresnel: false,
    is_reciprocal: true,
    is_energy_safe: true,
    make,
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    Ok(vec![Lobe::Lambert(Lambert {
        albedo: arguments.color("kd"),
    })])
}

/// Constant reflection in all directions.
#[derive(Clone, Debug)]
pub(super) struct Lambert {
    pub albedo: Rgb,
}

impl Reflect for Lambert {
    fn eval(&self, _wo: DVec3, _wi: DVec3) -> Rgb {
        self.albedo * FRAC_1_PI
    }

    fn pdf(&self, _wo: DVec3, wi: DVec3) -> f64 {
        wi.z * FRAC_1_PI
    }

    fn sample(&self, _wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        cosine_hemisphere(u1, u2)
    }

    fn spread(&self) -> Spread {
        Spread::Matt
    }
}
