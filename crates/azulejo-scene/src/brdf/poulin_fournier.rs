//! Surfaces of parallel cylinders, such as brushed metal and thread: `poulin_fournier`.
//!
//! P. Poulin, A. Fournier, *A model for anisotropic reflection*, SIGGRAPH 1990. Each point of the
//! cylinders, and of the floor between them, reflects light diffusely and by Blinn's lobe about its
//! own normal. Masking and shadowing between cylinders is exact; interreflection is left out.

mod profile;

use super::BrdfError;
use super::arguments::Arguments;
use super::blinn::{half_pdf, normalization, sample_half};
use super::lewis::about;
use super::lobe::{Lobe, Reflect, Spread};
use super::lobes::median_angle;
use super::microfacet::{HalfVector, mirrored_by};
use super::models::{EXPONENT, KD, KS, ModelInfo, PLAIN, ParameterInfo};
use super::quadrature::{cosine_hemisphere, gauss_legendre};
use crate::Rgb;
use crate::math::Frame;
use glam::DVec3;
use profile::{Profile, Range, VisibleSection};
use std::f64::consts::FRAC_1_PI;
use std::sync::Arc;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "poulin_fournier",
    aliases: &["poulin"],
    title: "Poulin–Fournier",
    paper: "P. Poulin, A. Fournier, A model for anisotropic reflection, SIGGRAPH 1990",
    parameters: &[
        KD,
        KS,
        EXPONENT,
        ParameterInfo::number("d", [1e-3, 1e6], "distance between the cylinders' axes")
            .in_unit("radii"),
        ParameterInfo::number("h", [0.0, 0.999_999], "depth of the axes below the floor")
            .or(0.0)
            .in_unit("radii"),
    ],
    examples: &[
        "poulin_fournier d = 2 kd = 1 ks = 0 n = 1",
        "poulin_fournier d = 2 kd = 0.2 ks = 0.6 n = 20",
        "poulin_fournier d = 3 h = 0.5 kd = (0.1, 0.2, 0.3) ks = 0.5 n = 200",
        "poulin_fournier d = 1.2 h = 0.2 kd = 0.5 ks = 0.3 n = 10",
    ],
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    arguments.bounded_sum("kd", "ks")?;
    let profile = Profile::new(arguments.number("d"), arguments.number("h"));
    let matt = MattCylinders {
        albedo: arguments.color("kd"),
        profile,
    };
    let mut lobes = vec![Lobe::MattCylinders(matt)];
    let ks = arguments.color("ks");
    if !ks.is_black() {
        let shiny = ShinyCylinders::new(ks, arguments.number("n"), profile);
        lobes.push(Lobe::ShinyCylinders(shiny));
    }
    Ok(lobes)
}

/// The diffuse reflection of the cylinders, in closed form.
#[derive(Clone, Debug)]
pub(super) struct MattCylinders {
    albedo: Rgb,
    profile: Profile,
}

impl Reflect for MattCylinders {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let both = self.profile.seen(wo).and(&self.profile.seen(wi));
        let exchanged = both.product(wo, wi) / (self.profile.d * wo.z * wi.z);
        self.albedo * (exchanged * FRAC_1_PI)
    }

    /// The density ignores the shadowing of the light, so that no sample weighs more than the
    /// albedo.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let seen = self.profile.seen(wo);
        let lit = seen.and(&self.profile.facing(wi));
        lit.product(wo, wi) * FRAC_1_PI / seen.projected(wo)
    }

    fn sample(&self, wo: DVec3, [u1, u2, u3]: [f64; 3]) -> DVec3 {
        let normal = self.profile.seen(wo).normal(wo, u3);
        Frame::from_normal(normal).to_world(cosine_hemisphere(u1, u2))
    }

    fn spread(&self) -> Spread {
        Spread::Matt
    }
}

/// The cylinders' highlights.
#[derive(Clone, Debug)]
pub(super) struct ShinyCylinders {
    albedo: Rgb,
    exponent: f64,
    profile: Profile,
    points: Arc<[(f64, f64)]>,
    spread: f64,
}

/// Points of the quadrature. They are placed around the highlight, where cosⁿ is at most as steep
/// as a Gaussian that falls to 1e-17 at both ends; for that the error is 1e-13.
const POINTS: usize = 32;

/// Minus the logarithm of cosⁿ at both ends of the range.
const DEPTH: f64 = 39.0;

impl ShinyCylinders {
    fn new(albedo: Rgb, exponent: f64, profile: Profile) -> ShinyCylinders {
        let mut lobe = ShinyCylinders {
            albedo,
            exponent,
            profile,
            points: gauss_legendre(POINTS).into(),
            spread: 0.0,
        };
        lobe.spread = median_angle(&lobe);
        lobe
    }

    /// ∫ over the visible parts `seen` of `term`(cosine between the normal and the half vector,
    /// normal). `term` falls with at least the exponent `n` of that cosine.
    fn integral(
        &self,
        seen: &VisibleSection,
        h: DVec3,
        n: f64,
        term: impl Fn(f64, DVec3) -> f64,
    ) -> f64 {
        let middle = h.y.atan2(h.z);
        let reach = (-DEPTH / n.max(1e-3)).exp().acos();
        let arc = seen.arc.and(&Range::new(middle - reach, middle + reach));
        let at = |normal: DVec3| {
            let cos = normal.dot(h);
            if cos > 0.0 { term(cos, normal) } else { 0.0 }
        };
        let of = |&(x, weight): &(f64, f64)| weight * at(profile::normal(arc.at(x)));
        let mut sum = seen.floor.length() * at(DVec3::Z);
        if arc.length() > 0.0 {
            sum += arc.length() * self.points.iter().map(of).sum::<f64>();
        }
        sum
    }
}

impl Reflect for ShinyCylinders {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let n = self.exponent;
        let both = self.profile.seen(wo).and(&self.profile.seen(wi));
        let h = (wo + wi).normalize();
        let sum = self.integral(&both, h, n, |cos, normal| {
            cos.powf(n) * normal.dot(wo).max(0.0) * normal.dot(wi).max(0.0)
        });
        self.albedo * (normalization(n) * sum / (self.profile.d * wo.z * wi.z))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let n = self.exponent;
        let (seen, half) = (self.profile.seen(wo), HalfVector::new(wo, wi));
        let h = half.v.normalize();
        let sum = self.integral(&seen, h, n + 1.0, |cos, normal| {
            half_pdf(n, cos) * normal.dot(wo).max(0.0)
        });
        half.reflected(sum / seen.projected(wo))
    }

    /// Samples a point that is visible from `wo`, and Blinn's half vector about its normal.
    fn sample(&self, wo: DVec3, [u1, u2, u3]: [f64; 3]) -> DVec3 {
        let normal = self.profile.seen(wo).normal(wo, u3);
        let h = about(normal, sample_half(self.exponent, u1), u2);
        if wo.dot(h) > 0.0 {
            mirrored_by(wo, h)
        } else {
            // The back of the facet: the reflected direction is below the point's own horizon.
            -DVec3::Z
        }
    }

    fn spread(&self) -> Spread {
        Spread::Glossy(self.spread)
    }
}

#[cfg(test)]
mod tests;
