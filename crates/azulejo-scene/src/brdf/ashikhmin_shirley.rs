//! An anisotropic lobe of cosines with a Fresnel term, over a diffuse base: `ashikhmin_shirley`.
//!
//! M. Ashikhmin, P. Shirley, *An anisotropic Phong BRDF model*, Journal of Graphics Tools 5(2),
//! 2000: equations 4 and 5, sampling by 6 to 9.

use super::arguments::Arguments;
use super::lobe::{Lobe, Reflect, Spread};
use super::matt::Matt;
use super::microfacet::{half, mirrored_by};
use super::models::{KD, KS, ModelInfo, PLAIN, ParameterInfo};
use super::{BrdfError, Fresnel};
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "ashikhmin_shirley",
    aliases: &["shirley", "ashikhmin", "ashikhmin-shirley"],
    title: "Ashikhmin–Shirley",
    paper: "M. Ashikhmin, P. Shirley, An anisotropic Phong BRDF model, JGT 5(2), 2000",
    parameters: &[
        KD,
        KS,
        ParameterInfo::number("nu", [0.0, 1e6], "exponent along the tangent").also(&["n", "nx"]),
        ParameterInfo::number("nv", [0.0, 1e6], "exponent along the bitangent").also(&["ny"]),
    ],
    examples: &[
        "ashikhmin_shirley kd = (0.5, 0.3, 0.2) ks = 0.05 nu = 10 nv = 1000",
        "ashikhmin_shirley kd = 1 ks = 0.8 nu = 1 nv = 1",
        "ashikhmin_shirley ks = 1 nu = 400 nv = 50",
    ],
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let (kd, ks) = (arguments.color("kd"), arguments.color("ks"));
    let base = Lobe::AshikhminShirleyBase(AshikhminShirleyBase {
        scale: kd * (Rgb::WHITE - ks) * (28.0 / (23.0 * PI)),
    });
    let surface = Lobe::AshikhminShirley(AshikhminShirley {
        fresnel: Fresnel::Schlick {
            f0: ks,
            tint: Rgb::WHITE,
        },
        nu: arguments.number("nu"),
        nv: arguments.number("nv"),
    });
    Ok(vec![base, surface])
}

/// The base, which reflects light that the surface transmits: 28 kd/(23π) (1 − ks)(1 − (1 − cos
/// θi/2)⁵) (1 − (1 − cos θo/2)⁵).
#[derive(Clone, Debug)]
pub(super) struct AshikhminShirleyBase {
    scale: Rgb,
}

impl Matt for AshikhminShirleyBase {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let through = |cos: f64| 1.0 - (1.0 - 0.5 * cos).powi(5);
        self.scale * (through(wo.z) * through(wi.z))
    }
}

/// √((nu + 1)(nv + 1))/(8π) F cosᵉ θh/(cos at h × max(cos θi, cos θo)), where the exponent e varies
/// from nu along the tangent to nv along the bitangent.
#[derive(Clone, Debug)]
pub(super) struct AshikhminShirley {
    fresnel: Fresnel,
    nu: f64,
    nv: f64,
}

/// Lower bound for products of cosines, to avoid division by 0.
const GRAZING: f64 = 1e-18;

impl AshikhminShirley {
    /// Density of half vectors, 1/sr.
    fn density(&self, h: DVec3) -> f64 {
        let (x2, y2) = (h.x * h.x, h.y * h.y);
        let exponent = if x2 + y2 > 0.0 {
            (self.nu * x2 + self.nv * y2) / (x2 + y2)
        } else {
            self.nu
        };
        self.norm() / TAU * h.z.clamp(0.0, 1.0).powf(exponent)
    }

    fn norm(&self) -> f64 {
        ((self.nu + 1.0) * (self.nv + 1.0)).sqrt()
    }
}

impl Reflect for AshikhminShirley {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let h = half(wo, wi);
        let cos = wo.dot(h);
        let below = (cos * wo.z.max(wi.z)).max(GRAZING);
        self.fresnel.at(cos) * (0.25 * self.density(h) / below)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let h = half(wo, wi);
        0.25 * self.density(h) / wo.dot(h).max(GRAZING)
    }

    fn sample(&self, wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        // With equal exponents azimuths are uniform; otherwise they are denser where the exponent
        // is low.
        let (y, x) = (TAU * u2).sin_cos();
        let around = glam::DVec2::new(x * (self.nv + 1.0).sqrt(), y * (self.nu + 1.0).sqrt());
        let around = around.normalize();
        let exponent = self.nu * around.x * around.x + self.nv * around.y * around.y;
        let cos = (1.0 - u1).powf(1.0 / (exponent + 1.0));
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        mirrored_by(wo, (around * sin).extend(cos))
    }

    fn spread(&self) -> Spread {
        Spread::Glossy(2.0 * 0.5f64.powf(1.0 / self.norm()).acos())
    }
}
