//! Rough diffuse surfaces that conserve energy: `eon`.
//!
//! J. Portsmouth, P. Kutz, S. Hill, *EON: a practical energy-preserving rough diffuse BRDF*, JCGT
//! 14(1), 2025: Fujii's variant of Oren and Nayar's model, with a lobe for multiple scattering that
//! compensates its loss of energy, tinted by each further reflection. The base of OpenPBR.

use super::BrdfError;
use super::arguments::Arguments;
use super::lobe::Lobe;
use super::matt::{Matt, across};
use super::models::{ModelInfo, PLAIN, ParameterInfo};
use super::oren_nayar::RHO;
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "eon",
    aliases: &["openpbr_diffuse"],
    title: "Energy-preserving Oren–Nayar",
    paper: "J. Portsmouth, P. Kutz, S. Hill, EON: a practical energy-preserving rough diffuse \
            BRDF, JCGT 14(1), 2025",
    parameters: &[
        RHO,
        ParameterInfo::number("r", [0.0, 1.0], "roughness; 0 is Lambert's").also(&["rough"]),
    ],
    examples: &[
        "eon rho = 1 r = 1",
        "eon rho = (0.8, 0.5, 0.2) r = 0.7",
        "eon rho = 0.5 r = 0",
    ],
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    Ok(vec![Lobe::Eon(Eon::new(
        arguments.color("rho"),
        arguments.number("r"),
    ))])
}

#[derive(Clone, Debug)]
pub(super) struct Eon {
    albedo: Rgb,
    roughness: f64,
    /// A_F: Fujii's factor of the Lambertian part.
    even: f64,
    /// Factor of the light lost by single scattering, 1/sr.
    lost: Rgb,
}

impl Eon {
    fn new(albedo: Rgb, roughness: f64) -> Eon {
        let even = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness);
        let mean = even * (1.0 + roughness * (2.0 / 3.0 - 28.0 / (15.0 * PI)));
        let missing = 1.0 - mean;
        let tinted = albedo.map(|rho| rho * rho * mean / (1.0 - rho * missing));
        Eon {
            albedo,
            roughness,
            even,
            // Without roughness single scattering loses nothing.
            lost: if missing > f64::EPSILON {
                tinted * (FRAC_1_PI / missing)
            } else {
                Rgb::BLACK
            },
        }
    }

    /// Energy that single scattering at a white surface loses, for the cosine to the normal.
    fn loss(&self, cos: f64) -> f64 {
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let over_cos = sin * (1.0 - sin.powi(3)) / cos.max(f64::MIN_POSITIVE);
        let g = sin * (cos.min(1.0).acos() - sin * cos) + 2.0 / 3.0 * (over_cos - sin);
        1.0 - self.even * (1.0 + self.roughness * g * FRAC_1_PI)
    }
}

impl Matt for Eon {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let s = across(wo, wi);
        let s_over_t = if s > 0.0 {
            s / wo.z.max(wi.z).max(f64::MIN_POSITIVE)
        } else {
            s
        };
        let single = FRAC_1_PI * self.even * (1.0 + self.roughness * s_over_t);
        let several = self.loss(wo.z) * self.loss(wi.z);
        self.albedo * single + self.lost * several
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A white surface reflects all light, whatever its roughness and the angle.
    #[test]
    fn white_loses_nothing() {
        let check = |roughness: f64, cos: f64| {
            let eon = Eon::new(Rgb::WHITE, roughness);
            // The albedo of single scattering is 1 less the loss; the other lobe compensates it.
            let several = eon.lost.r * eon.loss(cos) * PI;
            let mean_loss = crate::brdf::quadrature::midpoints(20_000)
                .map(|mu| 2.0 * mu * eon.loss(mu) / 20_000.0)
                .sum::<f64>();
            let albedo = 1.0 - eon.loss(cos) + several * mean_loss;
            assert!((albedo - 1.0).abs() < 1e-6, "{roughness} {cos}: {albedo}");
        };
        for roughness in [0.0, 0.3, 1.0] {
            for cos in [1.0, 0.7, 0.1, 1e-3] {
                check(roughness, cos);
            }
        }
    }
}
