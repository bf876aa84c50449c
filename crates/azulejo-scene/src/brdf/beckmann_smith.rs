//! Beckmann's facets with Smith's masking and shadowing: `beckmann_smith`.
//!
//! B. Walter et al., *Microfacet models for refraction through rough surfaces*, EGSR 2007; E.
//! Heitz, *Understanding the masking-shadowing function*, JCGT 3(2), 2014.

use super::arguments::Arguments;
use super::beckmann::Beckmann;
use super::lobe::{Lobe, Reflect, Spread};
use super::microfacet::{AX, AY, HalfVector, over_base, roughness};
use super::models::{KD, KS, ModelInfo, PLAIN};
use super::{BrdfError, Fresnel};
use crate::Rgb;
use glam::DVec3;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "beckmann_smith",
    aliases: &["beckmann"],
    title: "Beckmann",
    paper: "B. Walter et al., Microfacet models for refraction through rough surfaces, EGSR 2007",
    parameters: &[KD, KS, AX, AY],
    examples: &[
        "beckmann_smith ax = 0.1 ay = 0.4 metal = silver",
        "beckmann_smith kd = 0.4 ks = 0.6 ax = 0.3 eta = 1.5",
        "beckmann_smith ax = 0.02",
    ],
    has_fresnel: true,
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let [ax, ay] = roughness(arguments);
    let lobe = Lobe::BeckmannSmith(BeckmannSmith {
        scale: arguments.color("ks"),
        fresnel: arguments.fresnel()?,
        facets: Beckmann { ax, ay },
    });
    over_base(arguments, vec![lobe])
}

/// ks F D G/(4 cos θi cos θo), G = 1/(1 + Λ(i) + Λ(o)).
#[derive(Clone, Debug)]
pub(super) struct BeckmannSmith {
    scale: Rgb,
    fresnel: Fresnel,
    facets: Beckmann,
}

impl Reflect for BeckmannSmith {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let half = HalfVector::new(wo, wi);
        let hidden = self.facets.hidden(wo) + self.facets.hidden(wi);
        let facets = self.facets.density(&half) / (4.0 * wo.z * wi.z * (1.0 + hidden));
        self.scale * self.fresnel.at(half.cos_d()) * facets
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.facets.pdf(&HalfVector::new(wo, wi))
    }

    fn sample(&self, wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        self.facets.sample(wo, u1, u2)
    }

    fn spread(&self) -> Spread {
        self.facets.spread()
    }
}
