//! Disney's diffuse base, which darkens or brightens at grazing angles: `burley_diffuse`.
//!
//! B. Burley, *Physically-based shading at Disney*, SIGGRAPH 2012 courses, section 5.3. Rough white
//! surfaces create energy: their albedo is 1.04 at normal incidence and 1.5 at grazing angles.

use super::BrdfError;
use super::arguments::Arguments;
use super::lobe::Lobe;
use super::matt::Matt;
use super::models::{ModelInfo, PLAIN, ParameterInfo};
use super::oren_nayar::RHO;
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "burley_diffuse",
    aliases: &["burley", "disney_diffuse"],
    title: "Burley (Disney) diffuse",
    paper: "B. Burley, Physically-based shading at Disney, SIGGRAPH 2012 courses",
    parameters: &[
        RHO,
        ParameterInfo::number("rough", [0.0, 1.0], "roughness").also(&["roughness"]),
    ],
    examples: &[
        "burley_diffuse rho = 0.8 rough = 0.6",
        "burley_diffuse rho = 1 rough = 1",
        "burley_diffuse rho = 0.5 rough = 0",
    ],
    is_energy_safe: false,
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    Ok(vec![Lobe::BurleyDiffuse(BurleyDiffuse {
        albedo: arguments.color("rho"),
        roughness: arguments.number("rough"),
    })])
}

/// ρ/π (1 + (f90 − 1)(1 − cos θi)⁵)(1 + (f90 − 1)(1 − cos θo)⁵), f90 = ½ + 2 rough cos² of the
/// angle to the half vector.
#[derive(Clone, Debug)]
pub(super) struct BurleyDiffuse {
    albedo: Rgb,
    roughness: f64,
}

impl Matt for BurleyDiffuse {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        // 2 cos² is 1 and the cosine of the double angle, which lies between the directions.
        let beyond = 0.5 + self.roughness * (1.0 + wo.dot(wi)) - 1.0;
        let towards = |cos: f64| 1.0 + beyond * (1.0 - cos).powi(5);
        self.albedo * (FRAC_1_PI * towards(wo.z) * towards(wi.z))
    }
}
