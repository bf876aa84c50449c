//! Cook and Torrance's metals and plastics: `cook_torrance`.
//!
//! R. L. Cook, K. E. Torrance, *A reflectance model for computer graphics*, ACM TOG 1(1), 1982,
//! with Beckmann's facets in V-grooves. The paper prints F D G/(π cos θi cos θo) with a D that
//! lacks 1/π; this is F D G/(4 cos θi cos θo), where the 4 is the Jacobian of reflection.

use super::arguments::Arguments;
use super::beckmann::Beckmann;
use super::lobe::{Lobe, Reflect, Spread};
use super::microfacet::{HalfVector, over_base, v_grooves};
use super::models::{KD, KS, ModelInfo, PLAIN, ParameterInfo};
use super::{BrdfError, Fresnel};
use crate::Rgb;
use glam::DVec3;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "cook_torrance",
    aliases: &["torrance"],
    title: "Cook–Torrance",
    paper: "R. L. Cook, K. E. Torrance, A reflectance model for computer graphics, ACM TOG 1(1), 1982",
    parameters: &[
        KD,
        KS,
        ParameterInfo::number(
            "m",
            [1e-4, 10.0],
            "root mean square slope of the facets, times √2",
        )
        .also(&["rough", "roughness"]),
    ],
    examples: &[
        "cook_torrance kd = 0.4 ks = 0.6 m = 0.2 eta = 1.5",
        "cook_torrance m = 0.3 metal = copper",
        "cook_torrance m = 0.5",
    ],
    has_fresnel: true,
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let lobe = Lobe::CookTorrance(CookTorrance {
        scale: arguments.color("ks"),
        fresnel: arguments.fresnel()?,
        facets: Beckmann::isotropic(arguments.number("m")),
    });
    over_base(arguments, vec![lobe])
}

/// ks F D G/(4 cos θi cos θo).
#[derive(Clone, Debug)]
pub(super) struct CookTorrance {
    scale: Rgb,
    fresnel: Fresnel,
    facets: Beckmann,
}

impl Reflect for CookTorrance {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let half = HalfVector::new(wo, wi);
        let facets = self.facets.density(&half) * v_grooves(&half, wo, wi);
        self.scale * self.fresnel.at(half.cos_d()) * (facets / (4.0 * wo.z * wi.z))
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
