//! The same in all directions: `diffuse`.

use super::BrdfError;
use super::arguments::Arguments;
use super::lobe::Lobe;
use super::matt::Matt;
use super::models::{KD, ModelInfo, PLAIN};
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
    make,
    ..PLAIN
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

impl Matt for Lambert {
    fn eval(&self, _wo: DVec3, _wi: DVec3) -> Rgb {
        self.albedo * FRAC_1_PI
    }
}
