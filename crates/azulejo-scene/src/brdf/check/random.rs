//! Random numbers for checks, the same every time.

use crate::brdf::quadrature::cosine_hemisphere;
use glam::DVec3;

/// Steele, Lea and Flood's SplitMix64, *Fast splittable pseudorandom number generators*, 2014.
pub(super) struct Random {
    state: u64,
}

impl Random {
    pub fn new(seed: u64) -> Random {
        Random { state: seed }
    }

    /// In 0..1.
    pub fn number(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Three of them.
    pub fn numbers(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| self.number())
    }

    /// A direction above the surface, with density cos θ/π.
    pub fn hemisphere(&mut self) -> DVec3 {
        let w = cosine_hemisphere(self.number(), self.number());
        // On the horizon itself nothing is reflected, and nothing is learnt.
        if w.z > 0.0 { w } else { DVec3::Z }
    }
}
