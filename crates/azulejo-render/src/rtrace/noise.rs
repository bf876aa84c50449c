//! Solid noise, and sums of its octaves.
//!
//! RTRACE hashes the bytes of its numbers, so its noise differs between machines. This noise has
//! the same shape and distribution with another hash: at every point of the integer lattice a
//! value and a gradient, four numbers uniform in −1..1, blended by cubics.

use azulejo_trace::sampling::{hash, uniform};
use glam::DVec3;

/// Octaves beyond these are below the resolution of a number.
const MOST_OCTAVES: u32 = 64;

/// Noise of mean ½ in 0..=1.
pub(super) fn noise(p: DVec3) -> f64 {
    let [value] = lattice(p);
    (value + 0.5).clamp(0.0, 1.0)
}

/// Noise whose components have mean 0.
pub(super) fn vector_noise(p: DVec3) -> DVec3 {
    DVec3::from_array(lattice(p))
}

/// A sum of noises, each `lambda` times finer and `gain` times weaker than the one before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Octaves {
    pub gain: f64,
    pub lambda: f64,
    pub count: f64,
}

impl Octaves {
    /// Each half as strong at twice the frequency.
    pub const fn halves(count: u32) -> Octaves {
        Octaves {
            gain: 0.5,
            lambda: 2.0,
            count: count as f64,
        }
    }

    /// Fractional Brownian motion; natural textures have an `omega` of 0.5.
    pub fn brownian(omega: f64, lambda: f64, count: f64) -> Octaves {
        Octaves {
            gain: lambda.powf(-0.5 - omega),
            lambda,
            count,
        }
    }

    pub fn sum(self, p: DVec3) -> f64 {
        let octaves = self.weights().map(|(f, w)| w * noise(f * p));
        octaves.sum()
    }

    pub fn vector_sum(self, p: DVec3) -> DVec3 {
        let octaves = self.weights().map(|(f, w)| w * vector_noise(f * p));
        octaves.sum()
    }

    /// Frequency and weight of each octave: always the first, and the rest while finite.
    fn weights(self) -> impl Iterator<Item = (f64, f64)> {
        let count = (self.count.round() as u32).clamp(1, MOST_OCTAVES);
        let next = move |&(f, w): &(f64, f64)| {
            let (f, w) = (f * self.lambda, w * self.gain);
            (f.is_finite() && w.is_finite()).then_some((f, w))
        };
        std::iter::successors(Some((1.0, 1.0)), next).take(count as usize)
    }
}

/// Light and dark bands around turbulent waves.
pub(super) fn bands(phase: f64) -> f64 {
    (0.5 * (phase.sin() + 1.0)).powf(0.77)
}

/// A sine whose period is 1, the same on both sides of 0.
pub(super) fn wave(phase: f64) -> f64 {
    (std::f64::consts::TAU * phase.abs().fract()).sin()
}

/// `N` independent sums over the eight lattice points around a point.
fn lattice<const N: usize>(p: DVec3) -> [f64; N] {
    let mut sums = [0.0; N];
    if !p.is_finite() {
        return sums;
    }
    let (cell, inside) = (p.floor(), p - p.floor());
    let blend = inside * inside * (3.0 - 2.0 * inside);
    for k in 0..8u32 {
        let corner = DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
        let weights = corner * blend + (1.0 - corner) * (1.0 - blend);
        let weight = weights.x * weights.y * weights.z;
        let key = hash(&(cell + corner).to_array().map(|x| x as i64 as u32));
        let offset = inside - corner;
        for (n, sum) in sums.iter_mut().enumerate() {
            let random = |j: u32| 2.0 * f64::from(uniform(&[key, 4 * n as u32 + j])) - 1.0;
            let slope = DVec3::new(random(1), random(2), random(3));
            *sum += weight * (0.5 * random(0) + slope.dot(offset));
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and standard deviation over points far apart.
    fn statistics(f: impl Fn(DVec3) -> f64) -> (f64, f64) {
        let n = 20_000;
        let values: Vec<f64> = (0..n)
            .map(|i| f(f64::from(i) * DVec3::new(0.754, -0.569, 1.324)))
            .collect();
        let mean = values.iter().sum::<f64>() / f64::from(n);
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / f64::from(n);
        (mean, variance.sqrt())
    }

    #[test]
    fn noise_spreads_around_a_half() {
        let (mean, deviation) = statistics(noise);
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        assert!((deviation - 0.25).abs() < 0.01, "{deviation}");
        let (mean, deviation) = statistics(|p| vector_noise(p).z);
        assert!(mean.abs() < 0.01, "{mean}");
        // Nothing is cut off here.
        assert!((deviation - 0.26).abs() < 0.02, "{deviation}");
    }

    #[test]
    fn noise_is_smooth_and_in_range() {
        for i in 0..2000 {
            let p = f64::from(i) * DVec3::new(0.37, -1.11, 0.93);
            assert!((0.0..=1.0).contains(&noise(p)));
            assert!((noise(p) - noise(p + DVec3::splat(1e-7))).abs() < 1e-5);
            // Across the faces of the cells, too.
            let edge = DVec3::new(f64::from(i), 0.3, 0.7);
            assert!((noise(edge - 1e-9 * DVec3::X) - noise(edge + 1e-9 * DVec3::X)).abs() < 1e-7);
        }
    }

    #[test]
    fn octaves_add_up_and_end() {
        let p = DVec3::new(0.3, 0.4, 0.5);
        assert_eq!(Octaves::halves(1).sum(p), noise(p));
        let two = noise(p) + 0.5 * noise(2.0 * p);
        assert!((Octaves::halves(2).sum(p) - two).abs() < 1e-12);
        let endless = Octaves::brownian(0.5, 2.0, 1e9).sum(p);
        assert!(endless.is_finite());
        assert!(Octaves::brownian(0.5, 0.0, 9.0).sum(p).is_finite());
    }

    #[test]
    fn what_is_not_a_point_has_no_noise() {
        assert_eq!(noise(DVec3::NAN), 0.5);
        assert_eq!(vector_noise(DVec3::INFINITY), DVec3::ZERO);
    }
}
