//! Paint, as modelled in remote sensing: `beard_maxwell`.
//!
//! J. R. Maxwell, J. Beard, S. Weiner, D. Ladd, S. Ladd, *Bidirectional reflectance model
//! validation and utilization*, AFAL-TR-73-303, 1973, in the form of the Nonconventional
//! Exploitation Factors database: H. B. Westlund, G. W. Meyer, *A BRDF database employing the
//! Beard-Maxwell reflection model*, Graphics Interface 2002, equation 10,
//!
//! f = R(β)/R(0) ρ_fs(θh) cos² θh/(cos θi cos θo) SO + ρ_d + 2 ρ_v/(cos θi + cos θo),
//! SO = (1 + θh/Ω e^(−2β/τ))/(1 + θh/Ω),
//!
//! with θh between half vector and normal and β between half vector and light. The database
//! tabulates the first surface ρ_fs as it was measured; here it is R(0) B D/(4 cos² θh) for facets
//! D whose slopes are Gaussian, as DIRSIG fits it (J. R. Shell, *Polarimetric remote sensing in the
//! visible to near infrared*, RIT 2005). In the database's units ρ_d = kd/π and ρ_v = kv/(4π).
//!
//! The shadowing SO does not vanish at grazing angles, where the first surface is unbounded.

use super::arguments::Arguments;
use super::lambert::Lambert;
use super::lobe::{Lobe, Reflect, Spread};
use super::matt::Matt;
use super::microfacet::{half, mirrored_by};
use super::models::{KD, ModelInfo, PLAIN, ParameterInfo};
use super::{BrdfError, Fresnel};
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::{LN_2, TAU};

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "beard_maxwell",
    aliases: &["beardmaxwell", "maxwell_beard", "beard-maxwell"],
    title: "Beard–Maxwell",
    paper: "J. R. Maxwell et al., Bidirectional reflectance model validation and utilization, \
            1973; H. B. Westlund, G. W. Meyer, A BRDF database employing the Beard-Maxwell \
            reflection model, Graphics Interface 2002",
    parameters: &[
        KD,
        ParameterInfo::color(
            "kv",
            [0.0, 1.0],
            "reflectance of the layer below at grazing angles; 0.31 of it along the normal",
        )
        .or(0.0),
        ParameterInfo::color("bias", [0.0, 1.0], "scale of the first surface")
            .or(1.0)
            .also(&["ks", "b"]),
        ParameterInfo::number(
            "sigma",
            [1e-4, 1.0],
            "standard deviation of the facets' slopes",
        )
        .also(&["rough"]),
        ParameterInfo::number("tau", [0.1, 1e4], "how fast shadows fade with β")
            .or(1e4)
            .in_unit("degrees"),
        ParameterInfo::number("omega", [0.1, 1e4], "how fast shadows grow with θh")
            .or(1e4)
            .in_unit("degrees"),
    ],
    examples: &[
        "beard_maxwell kd = 0.1 kv = 0.3 sigma = 0.2 eta = 1.65 tau = 15 omega = 40",
        "beard_maxwell sigma = 0.4 bias = 0.8",
        "beard_maxwell kd = (0.3, 0.1, 0.1) kv = 0.1 bias = 0.7 sigma = 0.05 eta = 1.4",
    ],
    has_fresnel: true,
    is_energy_safe: false,
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    arguments.bounded_sum("kd", "kv")?;
    Ok(vec![
        Lobe::Lambert(Lambert {
            albedo: arguments.color("kd"),
        }),
        Lobe::BeardMaxwellBelow(BeardMaxwellBelow {
            albedo: arguments.color("kv"),
        }),
        Lobe::BeardMaxwell(BeardMaxwell {
            fresnel: arguments.fresnel()?,
            scale: arguments.color("bias"),
            sigma: arguments.number("sigma"),
            tau: arguments.number("tau").to_radians(),
            omega: arguments.number("omega").to_radians(),
        }),
    ])
}

/// Scattering below the surface: kv/(2π (cos θi + cos θo)). Its albedo is
/// kv (1 − cos θo ln(1 + 1/cos θo)).
#[derive(Clone, Debug)]
pub(super) struct BeardMaxwellBelow {
    albedo: Rgb,
}

impl Matt for BeardMaxwellBelow {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.albedo * (1.0 / (TAU * (wo.z + wi.z).max(GRAZING)))
    }
}

/// The first surface: B R(β) D(θh) SO/(4 cos θi cos θo).
#[derive(Clone, Debug)]
pub(super) struct BeardMaxwell {
    fresnel: Fresnel,
    scale: Rgb,
    /// Standard deviation of slopes.
    sigma: f64,
    /// τ, Ω in radians.
    tau: f64,
    omega: f64,
}

/// Lower bound for products of cosines, to avoid division by 0.
const GRAZING: f64 = 1e-18;

impl BeardMaxwell {
    /// D(θh) cos θh: the projected area of facets per solid angle of their normals, 1/sr.
    fn density(&self, h: DVec3) -> f64 {
        let cos2 = (h.z * h.z).max(GRAZING);
        let tan2 = (h.x * h.x + h.y * h.y) / cos2;
        let variance = self.sigma * self.sigma;
        (-0.5 * tan2 / variance).exp() / (TAU * variance * cos2 * h.z.max(GRAZING))
    }

    /// Maxwell's shadowing and obscuration.
    fn shadow(&self, h: DVec3, cos_beta: f64) -> f64 {
        let tilt = h.z.clamp(0.0, 1.0).acos() / self.omega;
        let faded = (-2.0 * cos_beta.clamp(0.0, 1.0).acos() / self.tau).exp();
        (1.0 + tilt * faded) / (1.0 + tilt)
    }
}

impl Reflect for BeardMaxwell {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let h = half(wo, wi);
        let cos_beta = wo.dot(h);
        let below = (4.0 * wo.z * wi.z * h.z).max(GRAZING);
        let facets = self.density(h) * self.shadow(h, cos_beta) / below;
        self.fresnel.at(cos_beta) * self.scale * facets
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let h = half(wo, wi);
        0.25 * self.density(h) / wo.dot(h).max(GRAZING)
    }

    fn sample(&self, wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        let slope = self.sigma * (-2.0 * (1.0 - u1).ln()).sqrt();
        let (y, x) = (TAU * u2).sin_cos();
        mirrored_by(wo, DVec3::new(slope * x, slope * y, 1.0).normalize())
    }

    fn spread(&self) -> Spread {
        // Half of the slopes lie below σ √(2 ln 2); reflection doubles the angle.
        Spread::Glossy(2.0 * (self.sigma * (2.0 * LN_2).sqrt()).atan())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Brdf;

    fn direction(theta: f64) -> DVec3 {
        let (sin, cos) = theta.to_radians().sin_cos();
        DVec3::new(sin, 0.0, cos)
    }

    /// A scan with light and viewer in the same direction measures the first surface, ρ_fs.
    #[test]
    fn a_zero_bistatic_scan_shows_the_facets() {
        let text = "beard_maxwell sigma = 0.3 eta = 1.65 tau = 15 omega = 40";
        let brdf = Brdf::new(text.parse().unwrap()).unwrap();
        for theta in [0.0f64, 20.0, 45.0] {
            let (tan, cos) = (theta.to_radians().tan(), theta.to_radians().cos());
            let facets = (-0.5 * (tan / 0.3).powi(2)).exp() / (TAU * 0.09 * cos.powi(4));
            let expected = (0.65f64 / 2.65).powi(2) * facets / (4.0 * cos * cos);
            let value = brdf.eval(direction(theta), direction(theta)).r;
            assert!((value / expected - 1.0).abs() < 1e-9, "{theta}: {value}");
        }
    }

    #[test]
    fn the_layer_below_has_its_albedo() {
        let text = "beard_maxwell sigma = 0.3 bias = 0 kv = 0.8";
        let brdf = Brdf::new(text.parse().unwrap()).unwrap();
        for theta in [0.0f64, 60.0, 85.0] {
            let cos = theta.to_radians().cos();
            let expected = 0.8 * (1.0 - cos * (1.0 + 1.0 / cos).ln());
            let albedo = brdf.albedo(direction(theta)).r;
            assert!((albedo - expected).abs() < 2e-3, "{theta}: {albedo}");
        }
    }
}
