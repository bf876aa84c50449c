//! Reproducible random numbers for checks.

use crate::brdf::quadrature::cosine_hemisphere;
use crate::random::split_mix64;
use glam::DVec3;

/// Random numbers and directions, from a seed.
pub(super) struct Random {
    state: u64,
}

impl Random {
    pub fn new(seed: u64) -> Random {
        Random { state: seed }
    }

    /// In 0..1.
    pub fn number(&mut self) -> f64 {
        split_mix64(&mut self.state)
    }

    /// Three of them.
    pub fn numbers(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| self.number())
    }

    /// A direction above the surface, with density cos θ/π.
    pub fn hemisphere(&mut self) -> DVec3 {
        let w = cosine_hemisphere(self.number(), self.number());
        // On the horizon itself nothing is reflected, so it would test nothing.
        if w.z > 0.0 { w } else { DVec3::Z }
    }
}
