//! Diffuse surfaces of V-grooves: `oren_nayar`.
//!
//! M. Oren and S. K. Nayar, *Generalization of Lambert's reflectance model*, SIGGRAPH 1994: the
//! qualitative model, equation 30, with 0.33 in A. Texts that print 0.57 there, or that add
//! interreflections, are other models. White surfaces with σ about 10° create up to 1.4 % of energy
//! at grazing angles; [`eon`](super::eon) does not.

use super::BrdfError;
use super::arguments::Arguments;
use super::lobe::Lobe;
use super::matt::{Matt, across};
use super::models::{ModelInfo, PLAIN, ParameterInfo};
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "oren_nayar",
    aliases: &["oren_nayar_qual", "oren-nayar", "orennayar"],
    title: "Oren–Nayar",
    paper: "M. Oren, S. K. Nayar, Generalization of Lambert's reflectance model, SIGGRAPH 1994",
    parameters: &[
        RHO,
        ParameterInfo::number(
            "sigma",
            [0.0, 90.0],
            "standard deviation of the facets' slope angles",
        )
        .in_unit("degrees"),
    ],
    examples: &[
        "oren_nayar rho = 0.8 sigma = 30",
        "oren_nayar rho = 1 sigma = 90",
        "oren_nayar rho = (0.6, 0.4, 0.2) sigma = 0",
    ],
    is_energy_safe: false,
    make,
    ..PLAIN
};

/// Reflectance of the facets.
pub(super) const RHO: ParameterInfo =
    ParameterInfo::color("rho", [0.0, 1.0], "reflectance of the material").also(&["kd", "rd"]);

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let variance = arguments.number("sigma").to_radians().powi(2);
    Ok(vec![Lobe::OrenNayar(OrenNayar {
        albedo: arguments.color("rho"),
        even: 1.0 - 0.5 * variance / (variance + 0.33),
        back: 0.45 * variance / (variance + 0.09),
    })])
}

/// ρ/π (A + B max(0, cos Δφ) sin α tan β), where α and β are the greater and the smaller of the
/// angles to the normal.
#[derive(Clone, Debug)]
pub(super) struct OrenNayar {
    albedo: Rgb,
    /// A.
    even: f64,
    /// B.
    back: f64,
}

impl Matt for OrenNayar {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        // sin α sin β cos Δφ needs no angles, and tan β is sin β over the cosine.
        let cos_beta = wo.z.max(wi.z).max(f64::MIN_POSITIVE);
        let back = self.back * across(wo, wi).max(0.0) / cos_beta;
        self.albedo * (FRAC_1_PI * (self.even + back))
    }
}
