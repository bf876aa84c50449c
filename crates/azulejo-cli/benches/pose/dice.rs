//! Random choices, the same on all machines.

use azulejo_scene::random::split_mix64;
use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::TAU;

/// A sequence of random numbers that depends on its key alone.
#[derive(Clone, Debug)]
pub struct Dice(u64);

impl Dice {
    /// The sequence of a seed and of words that say what it is for.
    pub fn new(seed: u64, words: &str) -> Dice {
        // FNV-1a: short, and the same everywhere.
        let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        let hash = words.bytes().fold(0xcbf2_9ce4_8422_2325, mix);
        let mut dice = Dice(hash ^ seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        dice.unit();
        dice
    }

    /// Uniform in 0..1.
    pub fn unit(&mut self) -> f64 {
        split_mix64(&mut self.0)
    }

    /// Uniform below `n`, which is not 0.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }

    /// One of several, of which there is at least one.
    pub fn one_of<'a, T>(&mut self, choices: &'a [T]) -> &'a T {
        &choices[self.below(choices.len())]
    }

    /// Puts elements in a random order.
    pub fn shuffle<T>(&mut self, elements: &mut [T]) {
        for last in (1..elements.len()).rev() {
            let other = self.below(last + 1);
            elements.swap(last, other);
        }
    }

    /// A unit vector, uniform on the sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = 2.0 * self.unit() - 1.0;
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }

    /// A rotation, uniform among all.
    ///
    /// Shoemake, *Uniform random rotations*, Graphics Gems III, 1992.
    pub fn rotation(&mut self) -> DMat3 {
        let (u, a, b) = (self.unit(), TAU * self.unit(), TAU * self.unit());
        let (p, q) = ((1.0 - u).sqrt(), u.sqrt());
        let turn = DQuat::from_xyzw(p * a.sin(), p * a.cos(), q * b.sin(), q * b.cos());
        DMat3::from_quat(turn.normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_decides() {
        let first = |seed, words| Dice::new(seed, words).unit();
        assert_eq!(first(3, "a"), first(3, "a"));
        assert_ne!(first(3, "a"), first(3, "b"));
        assert_ne!(first(3, "a"), first(4, "a"));
    }

    #[test]
    fn rotations_are_rotations() {
        let mut dice = Dice::new(0, "turn");
        for _ in 0..20 {
            let turn = dice.rotation();
            assert!((turn.determinant() - 1.0).abs() < 1e-12);
            assert!((dice.direction().length() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn shuffling_keeps_all() {
        let mut order: Vec<usize> = (0..9).collect();
        Dice::new(1, "order").shuffle(&mut order);
        assert_ne!(order, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
    }
}
