//! Smoothness, metalness and one colour, for animators: `strauss`.
//!
//! P. S. Strauss, *A realistic lighting model for computer animators*, IEEE CG&A 10(6), 1990. The
//! paper defines the radiance for a point light and a viewer, not a BRDF. This is the closest
//! physical model: the diffuse part is the paper's; the highlight is the paper's reflectance r_j
//! and colour C_s times Lewis' lobe (h + 2)/(2π) cos^h, and the Fresnel term is evaluated at the
//! half vector instead of the normal. Both agree with the paper in the specular direction, and make
//! the model reciprocal and bounded: the paper's constant 0.1 for edges raises the albedo of a
//! white surface by at most 0.3 %.

use super::BrdfError;
use super::arguments::Arguments;
use super::lambert::Lambert;
use super::lewis::Lewis;
use super::lobe::{Lobe, Reflect, Spread};
use super::microfacet::half;
use super::models::{ModelInfo, PLAIN, ParameterInfo};
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::FRAC_2_PI;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "strauss",
    title: "Strauss",
    paper: "P. S. Strauss, A realistic lighting model for computer animators, CG&A 10(6), 1990",
    parameters: &[
        ParameterInfo::color("color", [0.0, 1.0], "colour of the surface")
            .also(&["colour", "kd", "c"]),
        ParameterInfo::number("smoothness", [0.0, 1.0], "0 is matt, 1 a mirror")
            .also(&["smooth", "s"]),
        ParameterInfo::number(
            "metalness",
            [0.0, 1.0],
            "1 colours the highlight, and darkens what is smooth",
        )
        .or(0.0)
        .also(&["metallic", "metal", "m"]),
        ParameterInfo::number(
            "transparency",
            [0.0, 1.0],
            "share of the light that the surface lets through, which is lost here",
        )
        .or(0.0)
        .also(&["t"]),
    ],
    examples: &[
        "strauss color = (0.8, 0.6, 0.2) smoothness = 0.6 metalness = 0.8",
        "strauss color = 1 smoothness = 0.9",
        "strauss color = 1 smoothness = 0.3 metalness = 1",
        "strauss color = (0.2, 0.4, 0.9) smoothness = 0.8 transparency = 0.5",
    ],
    is_energy_safe: false,
    make,
    ..PLAIN
};

/// Largest exponent of a highlight; 3/(1 − s) is unbounded.
const SHARPEST: f64 = 1e6;

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let color = arguments.color("color");
    let (s, m) = (
        arguments.number("smoothness"),
        arguments.number("metalness"),
    );
    let opaque = 1.0 - arguments.number("transparency");
    let diffuse = (1.0 - s.powi(3)) * opaque;
    let exponent = (3.0 / (1.0 - s)).min(SHARPEST);
    Ok(vec![
        Lobe::Lambert(Lambert {
            albedo: color * ((1.0 - m * s) * diffuse),
        }),
        Lobe::Strauss(Strauss {
            color,
            metalness: m,
            reflectance: opaque - diffuse,
            lobe: Lewis::white(exponent),
        }),
    ])
}

#[derive(Clone, Debug)]
pub(super) struct Strauss {
    color: Rgb,
    metalness: f64,
    /// r_n: reflectance along the normal.
    reflectance: f64,
    lobe: Lewis,
}

/// The increase of the reflectance at grazing angles, from that along the normal.
const EDGE: f64 = 0.1;

/// Strauss' F, of an angle in units of π/2: 0 along the normal, 1 at grazing angles.
fn fresnel(x: f64) -> f64 {
    const K: f64 = 1.12;
    let at = |x: f64| (x - K).powi(-2);
    (at(x) - at(0.0)) / (at(1.0) - at(0.0))
}

/// Strauss' G, of an angle in units of π/2: 1 along the normal, 0 at grazing angles.
fn shadow(x: f64) -> f64 {
    const K: f64 = 1.01;
    let at = |x: f64| (x - K).powi(-2);
    (at(1.0) - at(x)) / (at(1.0) - at(0.0))
}

/// An angle in units of π/2.
fn angle(cos: f64) -> f64 {
    cos.clamp(0.0, 1.0).acos() * FRAC_2_PI
}

impl Strauss {
    /// C_s r_j: the colour of the highlight.
    fn highlight(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let f = fresnel(angle(wo.dot(half(wo, wi))));
        let j = f * shadow(angle(wo.z)) * shadow(angle(wi.z));
        let r = self.reflectance;
        let tint = Rgb::WHITE + (self.color - Rgb::WHITE) * (self.metalness * (1.0 - f));
        // The term for edges belongs to the surface: a fully transparent one has none.
        tint * (r + (r + EDGE) * j).min(1.0)
    }
}

impl Reflect for Strauss {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.highlight(wo, wi) * self.lobe.eval(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.lobe.pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> DVec3 {
        self.lobe.sample(wo, u)
    }

    fn spread(&self) -> Spread {
        self.lobe.spread()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_reach_their_ends() {
        assert_eq!((fresnel(0.0), fresnel(1.0)), (0.0, 1.0));
        assert_eq!((shadow(0.0), shadow(1.0)), (1.0, 0.0));
        // The paper's figures: Fresnel rises late, the shadow falls later still.
        assert!(fresnel(0.5) < 0.03 && shadow(0.9) > 0.98);
    }
}
