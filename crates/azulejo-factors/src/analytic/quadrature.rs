//! Quadrature rules on 0..1: Gauss–Legendre for smooth integrands, tanh-sinh for integrands that
//! lose their smoothness at an end.

use azulejo_scene::quadrature::gauss_legendre;
use std::f64::consts::FRAC_PI_2;
use std::sync::LazyLock;

/// Pairs of a point in 0..1 and its weight; the weights sum to 1.
pub(crate) type Rule = [(f64, f64)];

/// Most points that [`gauss`] offers.
pub(super) const MOST_POINTS: usize = 24;

/// The Gauss–Legendre rule with `points` in 1..=[`MOST_POINTS`] points.
pub(crate) fn gauss(points: usize) -> &'static Rule {
    static RULES: LazyLock<Vec<Vec<(f64, f64)>>> =
        LazyLock::new(|| (1..=MOST_POINTS).map(gauss_rule).collect());
    &RULES[points - 1]
}

/// The tanh-sinh rule (Takahasi and Mori 1974) for about the given error: 27, 53 or 105 points.
pub(super) fn tanh_sinh(tolerance: f64) -> &'static Rule {
    static RULES: LazyLock<[Vec<(f64, f64)>; 3]> =
        LazyLock::new(|| [1.0 / 4.0, 1.0 / 8.0, 1.0 / 16.0].map(tanh_sinh_rule));
    let [coarse, middle, fine] = &*RULES;
    if tolerance > 1e-5 {
        coarse
    } else if tolerance > 1e-9 {
        middle
    } else {
        fine
    }
}

fn gauss_rule(points: usize) -> Vec<(f64, f64)> {
    let rule = gauss_legendre(points).into_iter();
    rule.map(|(x, weight)| (0.5 * (1.0 + x), 0.5 * weight))
        .collect()
}

fn tanh_sinh_rule(step: f64) -> Vec<(f64, f64)> {
    // Beyond |t| = 3.25 the weights are below 1e-16 of the middle one.
    let half = (3.25 / step) as i32;
    (-half..=half)
        .map(|k| {
            let t = f64::from(k) * step;
            let u = FRAC_PI_2 * t.sinh();
            let weight = 0.5 * step * FRAC_PI_2 * t.cosh() / u.cosh().powi(2);
            (1.0 / (1.0 + (-2.0 * u).exp()), weight)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(rule: &Rule, error: f64, integrand: impl Fn(f64) -> f64, expected: f64) {
        let sum: f64 = rule.iter().map(|&(x, w)| w * integrand(x)).sum();
        assert!(
            (sum - expected).abs() <= error,
            "{} points: {sum}, not {expected}",
            rule.len()
        );
    }

    #[test]
    fn gauss_is_exact_up_to_its_degree() {
        for points in 1..=MOST_POINTS {
            let degree = 2 * points as i32 - 1;
            check(
                gauss(points),
                1e-14,
                |x| x.powi(degree),
                1.0 / f64::from(degree + 1),
            );
        }
    }

    #[test]
    fn tanh_sinh_bears_singular_ends() {
        for (tolerance, error) in [(1e-4, 2e-7), (1e-8, 1e-14), (1e-16, 1e-14)] {
            let rule = tanh_sinh(tolerance);
            check(rule, error, |_| 1.0, 1.0);
            check(rule, error, |x| x * x.ln(), -0.25);
            check(rule, error, f64::sqrt, 2.0 / 3.0);
        }
    }
}
