//! Trowbridge and Reitz's facets with Smith's masking and shadowing: `ggx_smith`.
//!
//! T. S. Trowbridge, K. P. Reitz, JOSA 65(5), 1975; B. Walter et al., EGSR 2007; height-correlated
//! masking and shadowing: E. Heitz, JCGT 3(2), 2014. Multiple scattering is lost; `ggx_ms` includes
//! it.

use super::arguments::Arguments;
use super::lobe::{Lobe, Reflect, Spread};
use super::microfacet::{AX, AY, HalfVector, mirrored_by, over_base, roughness};
use super::models::{KD, KS, ModelInfo, PLAIN};
use super::vndf::Ggx;
use super::{BrdfError, Fresnel};
use crate::Rgb;
use glam::DVec3;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "ggx_smith",
    aliases: &["ggx"],
    title: "GGX",
    paper: "B. Walter et al., Microfacet models for refraction through rough surfaces, EGSR 2007",
    parameters: &[KD, KS, AX, AY],
    examples: &[
        "ggx_smith ax = 0.1 ay = 0.4 metal = gold",
        "ggx_smith kd = 0.4 ks = 0.6 ax = 0.3 eta = 1.5",
        "ggx_smith ax = 0.02",
        "ggx_smith ax = 1 f0 = (0.9, 0.5, 0.2) tint = 0.7",
    ],
    has_fresnel: true,
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let [ax, ay] = roughness(arguments);
    let lobe = Lobe::GgxSmith(GgxSmith {
        scale: arguments.color("ks"),
        fresnel: arguments.fresnel()?,
        facets: Ggx { ax, ay },
    });
    over_base(arguments, vec![lobe])
}

/// ks F D G/(4 cos θi cos θo), G = 1/(1 + Λ(i) + Λ(o)).
#[derive(Clone, Debug)]
pub(super) struct GgxSmith {
    pub scale: Rgb,
    pub fresnel: Fresnel,
    pub facets: Ggx,
}

impl Reflect for GgxSmith {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let half = HalfVector::new(wo, wi);
        // cos θi cos θo (1 + Λ(i) + Λ(o)), whose Λ are infinite at grazing angles.
        let seen = 0.5 * (wo.z * self.facets.stretch(wi) + wi.z * self.facets.stretch(wo));
        let density = self.facets.density(half.v.normalize());
        self.scale * self.fresnel.at(half.cos_d()) * (density / (4.0 * seen))
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.facets.pdf(wo, (wo + wi).normalize())
    }

    fn sample(&self, wo: DVec3, u: [f64; 3]) -> DVec3 {
        mirrored_by(wo, self.facets.sample(wo, u))
    }

    fn spread(&self) -> Spread {
        self.facets.spread()
    }
}
