//! Trowbridge and Reitz's distribution of facets (GGX) and its sampling.

use super::lobe::Spread;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Facets whose slopes along x and y are distributed as an ellipse's, after Trowbridge and Reitz
/// 1975 and Walter et al. 2007.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ggx {
    pub ax: f64,
    pub ay: f64,
}

impl Ggx {
    /// Facets per solid angle of their normals, 1/sr: ∫ D cos θ = 1.
    pub fn density(&self, h: DVec3) -> f64 {
        let s = (h.x / self.ax).powi(2) + (h.y / self.ay).powi(2) + h.z * h.z;
        1.0 / (PI * self.ax * self.ay * s * s)
    }

    /// The visible fraction of facets, G₁, over the cosine to the normal.
    pub fn visible_over_cos(&self, w: DVec3) -> f64 {
        2.0 / (w.z + self.stretch(w))
    }

    /// Length of a direction in the space where the facets' slopes are 1.
    pub fn stretch(&self, w: DVec3) -> f64 {
        DVec3::new(w.x * self.ax, w.y * self.ay, w.z).length()
    }

    /// Samples the normal of a facet that is visible from `wo`. After Heitz, *Sampling the GGX
    /// distribution of visible normals*, JCGT 7(4), 2018, in the form of Dupuy and Benyoub's
    /// spherical caps (2023): on the unit hemisphere the reflected directions fill a cap uniformly.
    pub fn sample(&self, wo: DVec3, [u1, u2, _]: [f64; 3]) -> DVec3 {
        let stretched = DVec3::new(wo.x * self.ax, wo.y * self.ay, wo.z).normalize();
        let z = (1.0 - u1) * (1.0 + stretched.z) - stretched.z;
        let (sin, cos) = (TAU * u2).sin_cos();
        let r = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
        let h = DVec3::new(r * cos, r * sin, z) + stretched;
        DVec3::new(h.x * self.ax, h.y * self.ay, h.z.max(0.0)).normalize_or(DVec3::Z)
    }

    /// Density of the direction into which a facet of [`sample`](Ggx::sample) reflects `wo`, 1/sr.
    pub fn pdf(&self, wo: DVec3, h: DVec3) -> f64 {
        0.25 * self.density(h) * self.visible_over_cos(wo)
    }

    /// Half of the facets have slopes below the roughness; reflection doubles the angle.
    pub fn spread(&self) -> Spread {
        Spread::Glossy(2.0 * (self.ax * self.ay).sqrt().atan())
    }
}
