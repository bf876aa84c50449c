//! Black emission in bands, by quadrature of Planck's law, and bisection.

use std::f64::consts::PI;

/// Second radiation constant hc/k, µm·K.
const C2: f64 = 14_387.768_77;

/// Panels of the quadrature, equal in the logarithm of λT.
const PANELS: u32 = 600;

/// c₂/(λT) where the quadrature starts: nothing measurable is emitted at shorter wavelengths.
const START: f64 = 700.0;

/// Share of a black body's emission at wavelengths below λ, where `product` is λT in µm·K.
///
/// Planck's law over σT⁵ is (15/π⁴) c₂⁴/(u⁵ (e^(c₂/u) − 1)) with u = λT; its integral over ln u, by Gauss's
/// five points in each panel.
pub fn planck_fraction(product: f64) -> f64 {
    let start = (C2 / START).ln();
    let width = (product.ln() - start) / f64::from(PANELS);
    let panel = |k: u32| five_points(start + f64::from(k) * width, width, emitted_per_logarithm);
    (0..PANELS).map(panel).sum()
}

/// Share between two products.
pub fn planck_between(low: f64, high: f64) -> f64 {
    planck_fraction(high) - planck_fraction(low)
}

fn emitted_per_logarithm(logarithm: f64) -> f64 {
    let x = C2 / logarithm.exp();
    15.0 / PI.powi(4) * x.powi(4) / x.exp_m1()
}

/// ∫ f over an interval, by Gauss's rule of five points.
fn five_points(start: f64, width: f64, f: impl Fn(f64) -> f64) -> f64 {
    let root = (10.0f64 / 7.0).sqrt();
    let nodes = [
        (5.0 - 2.0 * root).sqrt() / 3.0,
        (5.0 + 2.0 * root).sqrt() / 3.0,
    ];
    let part = 13.0 * 70f64.sqrt();
    let weights = [(322.0 + part) / 900.0, (322.0 - part) / 900.0];
    let (middle, half) = (start + 0.5 * width, 0.5 * width);
    let pair = |k: usize| weights[k] * (f(middle - half * nodes[k]) + f(middle + half * nodes[k]));
    half * (128.0 / 225.0 * f(middle) + pair(0) + pair(1))
}

/// Where a rising function is zero, by bisection until nothing changes.
pub fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if f(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
