//! Facets whose slopes are Gaussian: Beckmann's distribution and how its normals are sampled.

use super::lobe::Spread;
use super::microfacet::{HalfVector, mirrored_by};
use glam::DVec3;
use std::f64::consts::{LN_2, PI, TAU};

/// Slopes with root mean squares `ax`/√2 and `ay`/√2 along x and y.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beckmann {
    pub ax: f64,
    pub ay: f64,
}

impl Beckmann {
    pub fn isotropic(m: f64) -> Beckmann {
        Beckmann { ax: m, ay: m }
    }

    /// exp(−s²) of the half vector's slope s in units of the roughness.
    pub fn exponential(&self, half: &HalfVector) -> f64 {
        let v = half.v;
        let (x, y) = (v.x / (self.ax * v.z), v.y / (self.ay * v.z));
        (-(x * x + y * y)).exp()
    }

    /// D: facets per solid angle of their normals, 1/sr; ∫ D cos θ = 1.
    pub fn density(&self, half: &HalfVector) -> f64 {
        self.exponential(half) / (PI * self.ax * self.ay * half.cos_h().powi(4))
    }

    /// Smith's Λ: hidden facets per visible one. Walter et al. 2007, eq. 26, without its fit.
    pub fn hidden(&self, w: DVec3) -> f64 {
        let slope = w.z / (w.x * self.ax).hypot(w.y * self.ay);
        hidden(slope)
    }

    /// Samples the direction in which a facet reflects `wo`; facets have density D cos θh.
    pub fn sample(&self, wo: DVec3, u1: f64, u2: f64) -> DVec3 {
        let slope = (-(1.0 - u1).ln()).sqrt();
        let (sin, cos) = (TAU * u2).sin_cos();
        let h = DVec3::new(self.ax * slope * cos, self.ay * slope * sin, 1.0);
        mirrored_by(wo, h.normalize())
    }

    /// Density of [`sample`](Beckmann::sample), 1/sr.
    pub fn pdf(&self, half: &HalfVector) -> f64 {
        half.reflected(self.density(half) * half.cos_h())
    }

    /// Half of the facets lie within a slope of √ln 2; reflection doubles the angle.
    pub fn spread(&self) -> Spread {
        Spread::Glossy(2.0 * (self.ax.max(self.ay) * LN_2.sqrt()).atan())
    }
}

/// Λ for the cotangent of the direction's angle in units of the roughness.
pub(super) fn hidden(a: f64) -> f64 {
    (0.5 * ((-a * a).exp() / (a * PI.sqrt()) - libm::erfc(a))).max(0.0)
}
