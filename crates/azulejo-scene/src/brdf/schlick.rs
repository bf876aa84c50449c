//! Schlick's inexpensive model, from a mirror to a diffuse surface by one number: `schlick`.
//!
//! C. Schlick, *An inexpensive BRDF model for physically-based rendering*, Computer Graphics Forum
//! 13(3), 1994: the single material, S(u) (a/π + b G(v) G(v′) Z(t) A(w)/(4π v v′) + c of a mirror),
//! where b = 4r (1 − r) and the rest is diffuse (a) for r > ½, specular (c) below. The paper's term
//! for interreflection between facets, (1 − G G′)/(4π v v′), is left out: it is unbounded at
//! grazing angles. Without it, white surfaces with r between 0.004 and 0.2 still create up to a
//! fifth of energy at grazing angles, where the paper's G is too large.
//!
//! u is the cosine at the half vector h, t = cos of h to the normal, w = cos of h around the normal
//! to the tangent, v and v′ the cosines of the two directions.

use super::arguments::Arguments;
use super::lobe::{Lobe, Reflect, Spread};
use super::matt::Matt;
use super::microfacet::{half, mirrored_by};
use super::models::{ModelInfo, PLAIN, ParameterInfo};
use super::smooth::Smooth;
use super::{BrdfError, Fresnel};
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "schlick",
    title: "Schlick",
    paper: "C. Schlick, An inexpensive BRDF model for physically-based rendering, CGF 13(3), 1994",
    parameters: &[
        ParameterInfo::color("ks", [0.0, 1.0], "reflectance along the normal")
            .or(1.0)
            .also(&["f0", "rs", "c"]),
        ParameterInfo::number("r", [0.0, 1.0], "roughness: 0 is a mirror, 1 is matt")
            .also(&["rough", "roughness"]),
        ParameterInfo::number(
            "p",
            [0.01, 1.0],
            "isotropy: 1 is the same around the normal, less is brushed along the tangent",
        )
        .or(1.0)
        .also(&["isotropy"]),
    ],
    examples: &[
        "schlick r = 0.3",
        "schlick ks = (0.9, 0.6, 0.4) r = 0.5 p = 0.2",
        "schlick ks = 0.05 r = 0.8",
        "schlick ks = 0.9 r = 0.02 p = 0.5",
    ],
    is_energy_safe: false,
    make,
    ..PLAIN
};

/// Below this roughness the surface is a perfect mirror.
const SMOOTH: f64 = 1e-8;

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let fresnel = Fresnel::Schlick {
        f0: arguments.color("ks"),
        tint: Rgb::WHITE,
    };
    let (roughness, isotropy) = (arguments.number("r"), arguments.number("p"));
    let scale = 4.0 * roughness * (1.0 - roughness);
    let mut lobes = Vec::new();
    if roughness > 0.5 {
        lobes.push(Lobe::SchlickBase(SchlickBase {
            fresnel,
            scale: 1.0 - scale,
        }));
    } else {
        lobes.push(Lobe::Smooth(Smooth {
            fresnel,
            scale: Rgb::grey(1.0 - scale),
        }));
    }
    if roughness > SMOOTH && scale > 0.0 {
        lobes.push(Lobe::Schlick(Schlick {
            fresnel,
            scale,
            roughness,
            isotropy,
        }));
    }
    Ok(lobes)
}

/// The diffuse part: S(u) a/π.
#[derive(Clone, Debug)]
pub(super) struct SchlickBase {
    fresnel: Fresnel,
    /// a.
    scale: f64,
}

impl Matt for SchlickBase {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.fresnel.at(wo.dot(half(wo, wi))) * (self.scale * FRAC_1_PI)
    }
}

/// The glossy part: S(u) b G(v) G(v′) Z(t) A(w)/(4π v v′).
#[derive(Clone, Debug)]
pub(super) struct Schlick {
    fresnel: Fresnel,
    /// b.
    scale: f64,
    roughness: f64,
    isotropy: f64,
}

impl Schlick {
    /// Z(t), whose integral over t² is 1.
    fn zenith(&self, h: DVec3) -> f64 {
        // 1 + r t² − t², without cancellation near the normal.
        let s = h.x * h.x + h.y * h.y + self.roughness * h.z * h.z;
        self.roughness / (s * s)
    }

    /// w²: the squared cosine of the half vector's azimuth.
    fn along(h: DVec3) -> f64 {
        let (x2, y2) = (h.x * h.x, h.y * h.y);
        if x2 + y2 > 0.0 { x2 / (x2 + y2) } else { 0.5 }
    }

    /// A(w), whose mean around the normal is at most 1.
    fn azimuth(&self, h: DVec3) -> f64 {
        let (p, w2) = (self.isotropy, Self::along(h));
        (p / (p * p + (1.0 - p * p) * w2)).sqrt()
    }

    /// The replacement for A(w) in the density: it has the same ratio of extremes, and a mean of 1.
    fn azimuth_density(&self, h: DVec3) -> f64 {
        let p = self.isotropy;
        p.sqrt() / (p + (1.0 - p) * Self::along(h))
    }

    /// G(v)/v.
    fn visible_over_cos(&self, cos: f64) -> f64 {
        1.0 / (self.roughness + (1.0 - self.roughness) * cos)
    }
}

impl Reflect for Schlick {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let h = half(wo, wi);
        let seen = self.visible_over_cos(wo.z) * self.visible_over_cos(wi.z);
        let facets = self.zenith(h) * self.azimuth(h) * seen / (4.0 * PI);
        self.fresnel.at(wo.dot(h)) * (self.scale * facets)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let h = half(wo, wi);
        let cos = wo.dot(h).max(f64::MIN_POSITIVE);
        self.zenith(h) * self.azimuth_density(h) * h.z / (4.0 * PI * cos)
    }

    fn sample(&self, wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        let cos2 = u1 / (self.roughness + u1 * (1.0 - self.roughness));
        let (y, x) = (TAU * u2).sin_cos();
        let around = glam::DVec2::new(x * self.isotropy.sqrt(), y).normalize();
        let sin = (1.0 - cos2).max(0.0).sqrt();
        mirrored_by(wo, (around * sin).extend(cos2.sqrt()))
    }

    fn spread(&self) -> Spread {
        // Half of Z lies below the slope √r; reflection doubles the angle.
        Spread::Glossy(2.0 * self.roughness.sqrt().atan())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::{Brdf, quadrature::midpoints};

    #[test]
    fn between_mirror_and_matt() {
        let check = |r: f64, cos: f64, mirror: f64, diffuse: f64| {
            let schlick = Brdf::new(format!("schlick r = {r}").parse().unwrap()).unwrap();
            let matt = schlick
                .matt()
                .albedo(DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos));
            assert_eq!(schlick.mirror(cos).r, mirror, "r = {r}");
            assert!((matt.r - diffuse).abs() < 1e-12, "r = {r}: {}", matt.r);
        };
        check(0.0, 0.3, 1.0, 0.0);
        check(0.25, 0.6, 0.25, 0.0);
        check(0.5, 0.6, 0.0, 0.0);
        check(0.75, 0.2, 0.0, 0.25);
        check(1.0, 0.9, 0.0, 1.0);
    }

    /// The paper's A is only approximately normalized: never above 1, and 3 % below it at p = ½.
    #[test]
    fn brushed_metal_reflects_no_more() {
        let check = |isotropy: f64, expected: f64| {
            let schlick = Schlick {
                fresnel: Fresnel::Constant(Rgb::WHITE),
                scale: 1.0,
                roughness: 0.5,
                isotropy,
            };
            let around =
                |u: f64| schlick.azimuth(DVec3::new((TAU * u).cos(), (TAU * u).sin(), 0.0));
            let mean = midpoints(4096).map(around).sum::<f64>() / 4096.0;
            assert!((mean - expected).abs() < 1e-3, "{isotropy}: {mean}");
        };
        check(1.0, 1.0);
        check(0.5, 0.971);
        check(0.1, 0.744);
    }
}
