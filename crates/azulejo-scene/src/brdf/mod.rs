//! Reflection models: how much light from one direction a surface reflects in another.
//!
//! A [`Description`] is the model in the notation of files, by the names of [`MODELS`]; a [`Brdf`]
//! is what the passes evaluate. `wo` points to the viewer, `wi` to the light; both point away from
//! the surface and are given in its own frame: tangent x, bitangent y, normal z. A BRDF is in 1/sr
//! per channel, and nothing is reflected where `wo.z <= 0` or `wi.z <= 0`.
//!
//! ```
//! use azulejo_scene::brdf::{Brdf, Description};
//! use glam::DVec3;
//!
//! let ward: Description = "ward_gmd ks = 0.5 ax = 0.1 ay = 0.3".parse().unwrap();
//! let ward = Brdf::new(ward).unwrap();
//! let wo = DVec3::new(0.6, 0.0, 0.8);
//! let sample = ward.sample(wo, [0.3, 0.6, 0.1]).unwrap();
//! let weight = ward.eval(wo, sample.wi) * (sample.wi.z / sample.pdf);
//! assert!((weight.r - sample.weight.r).abs() < 1e-12);
//! ```

#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "NaN must fail the comparison, too"
)]

mod arguments;
pub mod check;
mod description;
mod error;
mod fresnel;
mod lobe;
mod lobes;
mod metals;
mod microfacet;
mod models;
mod quadrature;

mod ashikhmin_shirley;
mod beard_maxwell;
mod beckmann;
mod beckmann_smith;
mod blinn;
mod burley_diffuse;
mod cook_torrance;
mod eon;
mod facet_guide;
mod ggx_ms;
mod ggx_smith;
mod gltf_mr;
mod he_torrance;
mod lafortune;
mod lambert;
mod lewis;
mod matt;
mod measured;
mod minnaert;
mod oren_nayar;
mod phong;
mod poulin_fournier;
mod schlick;
mod smooth;
mod strauss;
mod torrance_sparrow_gauss;
mod vndf;
mod ward;

pub use description::{Content, Description, Model, Parameter, Value};
pub use error::BrdfError;
pub use fresnel::Fresnel;
pub use lobes::{BrdfSample, Lobes};
pub use measured::{Grid, HalfAngles, Measured, Merl, Rgl, RglTensors};
pub use metals::{METALS, Metal, WAVELENGTHS, find_metal};
pub use models::{FRESNEL, MODELS, ModelInfo, ParameterInfo, ParameterKind, find};

use crate::Rgb;
use glam::DVec3;
use lobe::{Lobe, Reflect, Spread};
use std::f64::consts::FRAC_1_PI;
use std::fmt;
use std::sync::Arc;

/// Lobes that reflect half of their light within this angle of the specular direction are mirrors
/// to the first pass, in degrees.
pub const NARROW: f64 = 1.0;

/// Amount by which sampling error may take a mean reflectance above 1.
const ROUNDING: f64 = 1e-3;

/// A reflection model, ready to be evaluated: the sum of a diffuse part and of [`Lobes`] in three
/// groups, which the passes treat differently.
pub struct Brdf {
    description: Description,
    diffuse: Rgb,
    matt: Lobes,
    glossy: Lobes,
    narrow: Lobes,
}

impl Brdf {
    /// Builds a model from its description.
    ///
    /// # Errors
    /// [`BrdfError`]: unknown names, numbers out of range, weights that create energy.
    pub fn new(description: Description) -> Result<Brdf, BrdfError> {
        Brdf::scaled(description, 1.0)
    }

    /// The model itself or, if it reflects more of uniform light than it receives, the model scaled
    /// down to an albedo of 1: otherwise light between such surfaces would grow without bound. The
    /// description is unchanged.
    pub fn limited(self: Arc<Brdf>) -> Arc<Brdf> {
        let most = self.mean_reflectance().max_channel();
        if most <= 1.0 + ROUNDING {
            return self;
        }
        let scaled = Brdf::scaled(self.description.clone(), 1.0 / most);
        scaled.map_or(self, Arc::new)
    }

    fn scaled(description: Description, scale: f64) -> Result<Brdf, BrdfError> {
        let mut diffuse = Rgb::BLACK;
        let [mut matt, mut glossy, mut narrow] = [const { Vec::new() }; 3];
        for (weight, lobe) in description.lobes()? {
            let weight = weight * scale;
            match (&lobe, lobe.spread()) {
                (Lobe::Lambert(lambert), _) => diffuse += lambert.albedo * weight,
                (_, Spread::Matt) => matt.push((weight, lobe)),
                (_, Spread::Glossy(angle)) if angle.to_degrees() >= NARROW => {
                    glossy.push((weight, lobe));
                }
                _ => narrow.push((weight, lobe)),
            }
        }
        Ok(Brdf {
            description,
            diffuse,
            matt: Lobes::new(matt),
            glossy: Lobes::new(glossy),
            narrow: Lobes::new(narrow),
        })
    }

    /// The description that it was made from.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Reflectance of the diffuse part, 0..=1.
    pub fn diffuse(&self) -> Rgb {
        self.diffuse
    }

    /// Lobes about as wide as the hemisphere, such as Oren and Nayar's. Passes that do not keep
    /// directions use their [`Lobes::mean_albedo`].
    pub fn matt(&self) -> &Lobes {
        &self.matt
    }

    /// Lobes around the specular direction, wider than [`NARROW`].
    pub fn glossy(&self) -> &Lobes {
        &self.glossy
    }

    /// Lobes of mirrors and near-mirrors.
    pub fn narrow(&self) -> &Lobes {
        &self.narrow
    }

    /// Mean reflectance of the [`diffuse`](Brdf::diffuse) part and the [`matt`](Brdf::matt) lobes.
    pub fn mean_diffuse(&self) -> Rgb {
        self.diffuse + self.matt.mean_albedo()
    }

    /// Fraction of uniform light that is reflected; more than 1 for models that create energy.
    pub fn mean_reflectance(&self) -> Rgb {
        self.mean_diffuse() + self.mean_mirror() + self.glossy.mean_albedo()
    }

    /// Mean reflectance of mirrors and near-mirrors.
    pub fn mean_mirror(&self) -> Rgb {
        let mirrors: Rgb = self.groups().iter().map(|l| l.mean_mirror()).sum();
        self.narrow.mean_albedo() + mirrors
    }

    fn groups(&self) -> [&Lobes; 3] {
        [&self.matt, &self.glossy, &self.narrow]
    }

    /// The BRDF, 1/sr, without perfect specular reflection ([`mirror`](Brdf::mirror)).
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if !(wo.z > 0.0 && wi.z > 0.0) {
            return Rgb::BLACK;
        }
        let lobes: Rgb = self.groups().iter().map(|l| l.eval(wo, wi)).sum();
        self.diffuse * FRAC_1_PI + lobes
    }

    /// Reflectance of the perfect specular part, for the cosine of the angle to the normal.
    pub fn mirror(&self, cos: f64) -> Rgb {
        self.groups().iter().map(|l| l.mirror(cos)).sum()
    }

    /// Directional albedo: the fraction of the light from `wo`'s direction that is reflected in any
    /// direction, perfect specular reflection included; by reciprocity also the radiance under a
    /// uniform sky of radiance 1. From 4,096 evaluations of each lobe, to about 0.001.
    pub fn albedo(&self, wo: DVec3) -> Rgb {
        self.albedo_by(wo, lobes::FINE_SAMPLES)
    }

    /// The same from another number of evaluations, 1 or more; 256 find it to about 0.02.
    pub fn albedo_by(&self, wo: DVec3, samples: usize) -> Rgb {
        if !(wo.z > 0.0) {
            return Rgb::BLACK;
        }
        let groups = self.groups();
        self.diffuse + groups.iter().map(|l| l.albedo_by(wo, samples)).sum::<Rgb>()
    }

    /// Sampling probabilities of the diffuse part and of each group of lobes for `wo`.
    fn shares(&self, wo: DVec3) -> [f64; 4] {
        let [m, g, n] = self.groups().map(|l| l.likely(wo));
        let shares = [self.diffuse.mean(), m, g, n];
        let sum: f64 = shares.iter().sum();
        if sum > 0.0 {
            shares.map(|x| x / sum)
        } else {
            [1.0, 0.0, 0.0, 0.0]
        }
    }

    /// Samples a direction `wi`, with a density roughly proportional to its contribution; `None` if
    /// the sample falls below the surface or all reflection is perfectly specular. `u` are three
    /// numbers in 0..1. The mean of the weights is the albedo without the specular part.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BrdfSample> {
        if !(wo.z > 0.0) {
            return None;
        }
        let shares = self.shares(wo);
        let mut rest = u[0];
        let chosen = shares.iter().position(|s| {
            let here = rest < *s;
            if !here {
                rest -= s;
            }
            here
        });
        let chosen = chosen.unwrap_or(0);
        let again = (rest / shares[chosen]).clamp(0.0, 1.0 - f64::EPSILON);
        let wi = match chosen {
            0 => Some(quadrature::cosine_hemisphere(u[1], u[2])),
            k => self.groups()[k - 1].direction(wo, [again, u[1], u[2]]),
        }?;
        let pdf = self.pdf(wo, wi);
        let weight = self.eval(wo, wi) * (wi.z / pdf);
        (pdf > 0.0 && weight.is_finite()).then_some(BrdfSample { wi, weight, pdf })
    }

    /// Density of [`sample`](Brdf::sample) over the solid angle of `wi`, 1/sr.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if !(wo.z > 0.0 && wi.z > 0.0) {
            return 0.0;
        }
        let [d, shares @ ..] = self.shares(wo);
        let lobes = self.groups().map(|l| l.pdf(wo, wi));
        let lobes: f64 = shares.iter().zip(lobes).map(|(s, p)| s * p).sum();
        d * wi.z * FRAC_1_PI + lobes
    }
}

/// Models are equal if their descriptions are.
impl PartialEq for Brdf {
    fn eq(&self, other: &Brdf) -> bool {
        self.description == other.description
    }
}

impl fmt::Debug for Brdf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.description.fmt(f)
    }
}

#[cfg(test)]
mod tests;
