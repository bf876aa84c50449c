//! Surfaces of parallel cylinders, such as brushed metal and thread: `poulin_fournier`.
//!
//! P. Poulin, A. Fournier, *A model for anisotropic reflection*, SIGGRAPH 1990. Each point of the
//! cylinders, and of the floor between them, reflects light diffusely and by Blinn's lobe about its
//! own normal. Masking and shadowing between cylinders is exact; interreflection is left out.

mod cosine_power;
mod profile;

use super::BrdfError;
use super::arguments::Arguments;
use super::blinn::{half_pdf, normalization, sample_half};
use super::lewis::about;
use super::lobe::{Lobe, Reflect, Spread};
use super::lobes::median_angle;
use super::microfacet::{HalfVector, mirrored_by};
use super::models::{EXPONENT, KD, KS, ModelInfo, PLAIN, ParameterInfo};
use super::quadrature::cosine_hemisphere;
use crate::Rgb;
use crate::math::Frame;
use cosine_power::CosinePower;
use glam::DVec3;
use profile::{NearestNormal, Profile, VisibleSection};
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
    powers: Arc<CosinePower>,
    spread: f64,
}

impl ShinyCylinders {
    fn new(albedo: Rgb, exponent: f64, profile: Profile) -> ShinyCylinders {
        let mut lobe = ShinyCylinders {
            albedo,
            exponent,
            profile,
            powers: Arc::new(CosinePower::new(exponent)),
            spread: 0.0,
        };
        lobe.spread = median_angle(&lobe);
        lobe
    }

    /// ∫ (n·a)(n·b) cosᵐ ds over the points `seen`, whose normals n face `a` and `b`, by the cosine between n and the
    /// half vector `h`; m is the exponent.
    fn product(&self, seen: &VisibleSection, h: DVec3, a: DVec3, b: DVec3) -> f64 {
        let middle = NearestNormal::of(h);
        let ([a_cos, a_sin], [b_cos, b_sin]) = (middle.components(a), middle.components(b));
        let powers = self.powers.integrals(seen.arc.offsets(middle.angle));
        let arc = powers.plain * (a_sin * b_sin)
            + powers.cos2 * (a_cos * b_cos - a_sin * b_sin)
            + powers.cos_sin * (a_cos * b_sin + a_sin * b_cos);
        let flat = seen.floor.length() * a.z * b.z;
        middle.cos.powf(self.exponent) * arc.max(0.0) + flat * h.z.powf(self.exponent)
    }

    /// ∫ (n·w) cosᵐ⁺¹ ds over the points `seen`, whose normals face `w`.
    fn projected(&self, seen: &VisibleSection, h: DVec3, w: DVec3) -> f64 {
        let middle = NearestNormal::of(h);
        let [cos, sin] = middle.components(w);
        let powers = self.powers.integrals(seen.arc.offsets(middle.angle));
        let arc = powers.cos2 * cos + powers.cos_sin * sin;
        let flat = seen.floor.length() * w.z;
        let exponent = self.exponent + 1.0;
        middle.cos.powf(exponent) * arc.max(0.0) + flat * h.z.powf(exponent)
    }
}

impl Reflect for ShinyCylinders {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let both = self.profile.seen(wo).and(&self.profile.seen(wi));
        let sum = self.product(&both, (wo + wi).normalize(), wo, wi);
        self.albedo * (normalization(self.exponent) * sum / (self.profile.d * wo.z * wi.z))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let (seen, half) = (self.profile.seen(wo), HalfVector::new(wo, wi));
        let sum = self.projected(&seen, half.v.normalize(), wo);
        half.reflected(half_pdf(self.exponent, 1.0) * sum / seen.projected(wo))
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
