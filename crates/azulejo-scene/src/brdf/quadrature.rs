//! Points and rules for quadrature.

use glam::DVec3;
use std::f64::consts::TAU;

/// Middles of `count` equal intervals of 0..1.
pub(super) fn midpoints(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| (k as f64 + 0.5) / count as f64)
}

/// `count` points spread evenly over the unit cube. The first two coordinates are Roberts' R2
/// sequence, whose steps are powers of the inverse of the plastic number; the third advances by the
/// golden ratio.
pub(super) fn lattice(count: usize) -> impl Iterator<Item = [f64; 3]> {
    const STEPS: [f64; 3] = [
        0.754_877_666_246_692_7,
        0.569_840_290_998_053_2,
        0.618_033_988_749_894_8,
    ];
    (0..count).map(|k| STEPS.map(|step| (0.5 + k as f64 * step).fract()))
}

/// Maps two numbers in 0..1 to a direction with density cos θ/π.
pub(super) fn cosine_hemisphere(u1: f64, u2: f64) -> DVec3 {
    let (sin, cos) = (TAU * u2).sin_cos();
    let r = u1.sqrt();
    DVec3::new(r * cos, r * sin, (1.0 - u1).sqrt())
}

/// The Gauss–Legendre rule on 0..1, nodes ascending.
pub(super) fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let rule = crate::quadrature::gauss_legendre(count).into_iter();
    rule.map(|(x, weight)| (0.5 * (1.0 - x), 0.5 * weight))
        .collect()
}

/// Weights of `N` nodes at 0, 1, 2, … for the value at `t` of the polynomial through theirs (Lagrange).
pub(super) fn lagrange<const N: usize>(t: f64) -> [f64; N] {
    let weight = |k: usize| {
        let others = (0..N).filter(|j| *j != k);
        let (over, under) = others.fold((1.0, 1.0), |(over, under), j| {
            (over * (t - j as f64), under * (k as f64 - j as f64))
        });
        over / under
    };
    std::array::from_fn(weight)
}
