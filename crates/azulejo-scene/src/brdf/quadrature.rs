//! Points to integrate with.

use glam::DVec3;
use std::f64::consts::TAU;

/// Middles of `count` equal intervals of 0..1.
pub(super) fn midpoints(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| (k as f64 + 0.5) / count as f64)
}

/// `count` points spread evenly over the unit cube. Their first two numbers are Roberts' R2
/// sequence, whose steps are powers of the inverse of the plastic number; the third goes by the
/// golden ratio.
pub(super) fn lattice(count: usize) -> impl Iterator<Item = [f64; 3]> {
    const STEPS: [f64; 3] = [
        0.754_877_666_246_692_7,
        0.569_840_290_998_053_2,
        0.618_033_988_749_894_8,
    ];
    (0..count).map(|k| STEPS.map(|step| (0.5 + k as f64 * step).fract()))
}

/// A direction with density cos θ/π.
pub(super) fn cosine_hemisphere(u1: f64, u2: f64) -> DVec3 {
    let (sin, cos) = (TAU * u2).sin_cos();
    let r = u1.sqrt();
    DVec3::new(r * cos, r * sin, (1.0 - u1).sqrt())
}

/// Gauss and Legendre's points and weights for 0..1: exact for polynomials up to degree
/// 2 `count` − 1.
pub(super) fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    (0..count).map(|k| legendre_root(count, k)).collect()
}

/// The `k`-th root of the Legendre polynomial of degree `n`, by Newton's method, with its weight.
fn legendre_root(n: usize, k: usize) -> (f64, f64) {
    let mut x = (std::f64::consts::PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
    let mut slope = 1.0;
    for _ in 0..8 {
        let (mut p, mut before) = (1.0, 0.0);
        for j in 1..=n {
            let j = j as f64;
            (p, before) = (((2.0 * j - 1.0) * x * p - (j - 1.0) * before) / j, p);
        }
        slope = n as f64 * (x * p - before) / (x * x - 1.0);
        x -= p / slope;
    }
    (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
}
