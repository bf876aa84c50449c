//! Gauss–Legendre quadrature.

use std::f64::consts::PI;

/// The Gauss–Legendre rule on −1..1: `count` nodes in descending order, each with its weight;
/// exact for polynomials up to degree 2 `count` − 1.
///
/// ```
/// use azulejo_scene::quadrature::gauss_legendre;
///
/// let integral: f64 = gauss_legendre(3).iter().map(|&(x, w)| w * x.powi(4)).sum();
/// assert!((integral - 2.0 / 5.0).abs() < 1e-15);
/// ```
pub fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let node = |k: usize| {
        let mut x = (PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        // Newton's step squares the error; four suffice from this start, two are a margin.
        for _ in 0..6 {
            let (value, slope) = legendre(count, x);
            x -= value / slope;
        }
        let slope = legendre(count, x).1;
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

/// Legendre polynomial of the given degree and its derivative, at `x` inside −1..1.
fn legendre(degree: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=degree {
        let k = k as f64;
        (before, value) = (
            value,
            ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k,
        );
    }
    (value, degree as f64 * (before - x * value) / (1.0 - x * x))
}
