//! Torrance and Sparrow's facets with Gaussian angles: `torrance_sparrow_gauss`.
//!
//! K. E. Torrance, E. M. Sparrow, *Theory for off-specular reflection from roughened surfaces*,
//! JOSA 57(9), 1967. The paper's distribution is not normalized; this one is.

use super::arguments::Arguments;
use super::lobe::{Lobe, Reflect, Spread};
use super::microfacet::{HalfVector, mirrored_by, over_base, v_grooves};
use super::models::{KD, KS, ModelInfo, PLAIN, ParameterInfo};
use super::quadrature::gauss_legendre;
use super::{BrdfError, Fresnel};
use crate::Rgb;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, LN_2, PI, TAU};

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "torrance_sparrow_gauss",
    aliases: &["torrance_sparrow"],
    title: "Torrance–Sparrow",
    paper: "K. E. Torrance, E. M. Sparrow, Theory for off-specular reflection from roughened surfaces, JOSA 57(9), 1967",
    parameters: &[
        KD,
        KS,
        ParameterInfo::number(
            "c",
            [0.01, 1e4],
            "1/c is the angle where e times fewer facets lie",
        )
        .in_unit("1/rad"),
    ],
    examples: &[
        "torrance_sparrow_gauss kd = 0.2 ks = 0.8 c = 2.5 eta = 1.5",
        "torrance_sparrow_gauss c = 10 metal = gold",
    ],
    has_fresnel: true,
    make,
    ..PLAIN
};

fn make(arguments: &Arguments) -> Result<Vec<Lobe>, BrdfError> {
    let c = arguments.number("c");
    let lobe = Lobe::TorranceSparrow(TorranceSparrow {
        scale: arguments.color("ks"),
        fresnel: arguments.fresnel()?,
        c,
        norm: norm(c),
    });
    over_base(arguments, vec![lobe])
}

/// N(c) = 1/(2π ∫ exp(−c²θ²) cos θ sin θ dθ), by quadrature.
fn norm(c: f64) -> f64 {
    // The integrand is negligible beyond 8/c.
    let end = FRAC_PI_2.min(8.0 / c);
    let term = |(x, weight): (f64, f64)| {
        let theta = x * end;
        weight * (-(c * theta).powi(2)).exp() * theta.cos() * theta.sin()
    };
    1.0 / (TAU * end * gauss_legendre(64).into_iter().map(term).sum::<f64>())
}

/// ks F D G/(4 cos θi cos θo), D = N exp(−c² θh²).
#[derive(Clone, Debug)]
pub(super) struct TorranceSparrow {
    scale: Rgb,
    fresnel: Fresnel,
    c: f64,
    norm: f64,
}

impl TorranceSparrow {
    /// The fraction of the planar Gaussian, θ exp(−c²θ²), between 0 and π/2.
    fn within(&self) -> f64 {
        -(-(self.c * FRAC_PI_2).powi(2)).exp_m1()
    }
}

impl Reflect for TorranceSparrow {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let half = HalfVector::new(wo, wi);
        let density = self.norm * (-(self.c * half.theta_h()).powi(2)).exp();
        let facets = density * v_grooves(&half, wo, wi) / (4.0 * wo.z * wi.z);
        self.scale * self.fresnel.at(half.cos_d()) * facets
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let half = HalfVector::new(wo, wi);
        let theta = half.theta_h();
        // θ/sin θ converts the measure of the plane to that of the sphere.
        let stretch = if theta > 1e-6 {
            theta / theta.sin()
        } else {
            1.0
        };
        let gauss = self.c * self.c / PI * (-(self.c * theta).powi(2)).exp();
        half.reflected(gauss * stretch / self.within())
    }

    fn sample(&self, wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        let theta = (-(-u1 * self.within()).ln_1p()).sqrt() / self.c;
        let ((sin, cos), (y, x)) = (theta.sin_cos(), (TAU * u2).sin_cos());
        mirrored_by(wo, DVec3::new(sin * x, sin * y, cos))
    }

    fn spread(&self) -> Spread {
        Spread::Glossy((2.0 * LN_2.sqrt() / self.c).min(FRAC_PI_2))
    }
}
