//! The material of glTF 2.0, base colour, metalness and roughness: `gltf_mr`.
//!
//! Khronos, glTF 2.0 specification, appendix B: Schlick's Fresnel term, GGX facets with Smith's
//! separable masking and shadowing, over a diffuse base. Smooth white dielectrics create up to a
//! tenth of the incident energy at grazing angles.

use super::arguments::Arguments;
use super::lobe::{Lobe, Reflect, Spread};
use super::matt::Matt;
use super::microfacet::{half, mirrored_by};
use super::models::{ModelInfo, PLAIN, ParameterInfo};
use super::smooth::Smooth;
use super::vndf::Ggx;
use super::{BrdfError, Fresnel};
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "gltf_mr",
    aliases: &["gltf", "metallic_roughness"],
    title: "glTF metallic-roughness",
    paper: "Khronos, glTF 2.0 specification, appendix B, 2021",
    parameters: &[
        ParameterInfo::color("base", [0.0, 1.0], "colour of the base or of the metal")
            .also(&["color", "kd"]),
        ParameterInfo::number("metallic", [0.0, 1.0], "0 is a dielectric, 1 a metal")
            .or(0.0)
            .also(&["metal", "metalness"]),
        ParameterInfo::number(
            "roughness",
            [0.0, 1.0],
            "its square is the facets' mean slope",
        )
        .or(1.0)
        .also(&["rough"]),
    ],
    examples: &[
        "gltf_mr base = (0.8, 0.5, 0.3) roughness = 0.5",
        "gltf_mr base = (1, 0.77, 0.34) metallic = 1 roughness = 0.2",
        "gltf_mr base = 1 metallic = 0.5 roughness = 1",
    ],
    is_energy_safe: false,
    make,
    ..PLAIN
};

/// Reflectance of a dielectric of index 1.5 along the normal.
const DIELECTRIC: f64 = 0.04;

/// Below this roughness the surface is a perfect mirror.
const SMOOTH: f64 = 1e-4;

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let (base, metallic) = (arguments.color("base"), arguments.number("metallic"));
    let fresnel = Fresnel::Schlick {
        f0: Rgb::grey(DIELECTRIC * (1.0 - metallic)) + base * metallic,
        tint: Rgb::WHITE,
    };
    let alpha = arguments.number("roughness").powi(2);
    let surface = if alpha < SMOOTH {
        Lobe::Smooth(Smooth {
            scale: Rgb::WHITE,
            fresnel,
        })
    } else {
        let facets = Ggx {
            ax: alpha,
            ay: alpha,
        };
        Lobe::GltfSurface(GltfSurface { fresnel, facets })
    };
    let base = Lobe::GltfBase(GltfBase {
        albedo: base * (1.0 - metallic),
        fresnel,
    });
    Ok(vec![base, surface])
}

/// The diffuse base, lit by what the surface transmits: (1 − F) c/π.
#[derive(Clone, Debug)]
pub(super) struct GltfBase {
    albedo: Rgb,
    fresnel: Fresnel,
}

impl Matt for GltfBase {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let through = Rgb::WHITE - self.fresnel.at(wo.dot(half(wo, wi)));
        self.albedo * through * FRAC_1_PI
    }
}

/// Reflection at the surface: F D G₁(i) G₁(o)/(4 cos θi cos θo).
#[derive(Clone, Debug)]
pub(super) struct GltfSurface {
    fresnel: Fresnel,
    facets: Ggx,
}

impl Reflect for GltfSurface {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let h = half(wo, wi);
        let facets = &self.facets;
        let seen = facets.visible_over_cos(wo) * facets.visible_over_cos(wi);
        self.fresnel.at(wo.dot(h)) * (0.25 * facets.density(h) * seen)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.facets.pdf(wo, half(wo, wi))
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> DVec3 {
        mirrored_by(wo, self.facets.sample(wo, u))
    }

    fn spread(&self) -> Spread {
        self.facets.spread()
    }
}
