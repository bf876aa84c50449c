//! Integrals of a power of the cosine over any part of a half turn, from one table.

use crate::brdf::quadrature::{gauss_legendre, lagrange};

/// Steps of the table per unit of s.
const PER_UNIT: f64 = 64.0;

/// The largest s of the table: the cosine's power is 1e-18 there.
const MOST: f64 = 6.5;

/// Nodes of an interpolation; a value lies between the middle two.
const NODES: usize = 6;

/// Nodes below 0.
const BORDER: usize = NODES / 2 - 1;

/// ∫ cosⁿ x dx up to a quarter turn, for one exponent n ≥ 0, with an error of 1e-12 of the whole.
///
/// By s² = −(n + 1) ln cos x it is exp(−s²) M(s), M(s) = 2/(n + 1) ∫ exp(s² − r²) r/sin x(r) dr over r > s. M is smooth
/// for every exponent; for large ones it is Mills' ratio.
#[derive(Debug)]
pub(super) struct CosinePower {
    n: f64,
    /// M at equal steps of s.
    ratios: Vec<f64>,
}

/// Integrals of cosⁿ x times 1, cos² x, and cos x sin x.
#[derive(Default)]
pub(super) struct PowerIntegrals {
    pub plain: f64,
    pub cos2: f64,
    pub cos_sin: f64,
}

/// One end of a range of x.
struct RangeEnd {
    sin: f64,
    cos: f64,
    /// cosⁿ⁺¹ x.
    power: f64,
    /// ∫ cosⁿ from |x| to a quarter turn.
    tail: f64,
}

impl CosinePower {
    pub fn new(n: f64) -> CosinePower {
        let rule = gauss_legendre(64);
        let nodes = (MOST * PER_UNIT) as usize + NODES;
        let place = |node: usize| (node as f64 - BORDER as f64) / PER_UNIT;
        CosinePower {
            n,
            ratios: (0..nodes)
                .map(|node| ratio(n, place(node), &rule))
                .collect(),
        }
    }

    /// Over a range within −π/2..π/2; 0 if it is empty.
    pub fn integrals(&self, [from, to]: [f64; 2]) -> PowerIntegrals {
        if !(from < to) {
            return PowerIntegrals::default();
        }
        let [a, b] = [self.end(from), self.end(to)];
        // Differences of what is small on the same side, so that tails keep their digits.
        let plain = if from >= 0.0 {
            a.tail - b.tail
        } else if to <= 0.0 {
            b.tail - a.tail
        } else {
            2.0 * self.ratios[BORDER] - a.tail - b.tail
        };
        let n = self.n;
        PowerIntegrals {
            plain,
            cos2: (b.power * b.sin - a.power * a.sin + (n + 1.0) * plain) / (n + 2.0),
            cos_sin: (a.power * a.cos - b.power * b.cos) / (n + 2.0),
        }
    }

    fn end(&self, x: f64) -> RangeEnd {
        let (sin, cos) = x.sin_cos();
        let cos = cos.max(f64::MIN_POSITIVE);
        // Near 0 the cosine does not tell x.
        let log = if cos > 0.7 {
            0.5 * (-sin * sin).ln_1p()
        } else {
            cos.ln()
        };
        let square = -(self.n + 1.0) * log;
        let power = (-square).exp();
        RangeEnd {
            sin,
            cos,
            power,
            tail: power * self.ratio(square.sqrt()),
        }
    }

    /// M(s), or 0 beyond the table.
    fn ratio(&self, s: f64) -> f64 {
        let at = s * PER_UNIT;
        let first = at as usize;
        let Some(nodes) = self.ratios.get(first..first.saturating_add(NODES)) else {
            return 0.0;
        };
        let weights = lagrange::<NODES>(at - first as f64 + BORDER as f64);
        nodes.iter().zip(weights).map(|(m, w)| m * w).sum()
    }
}

/// M(s), also where s is a little below 0.
fn ratio(n: f64, s: f64, rule: &[(f64, f64)]) -> f64 {
    // The integrand falls by exp(−40) over this length.
    let reach = 40.0 / (s + (s * s + 40.0).sqrt());
    let term = |&(x, weight): &(f64, f64)| {
        let r = s + reach * x;
        let square = (r * r).max(f64::MIN_POSITIVE);
        let over_sin = (square / -(-2.0 * square / (n + 1.0)).exp_m1()).sqrt();
        weight * (-(r - s) * (r + s)).exp() * over_sin
    };
    2.0 / (n + 1.0) * reach * rule.iter().map(term).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// By a rule of many points in pieces that are short compared with the width of the power.
    fn brute_force(n: f64, [from, to]: [f64; 2]) -> [f64; 3] {
        let (rule, pieces) = (gauss_legendre(20), 400);
        let length = (to - from) / f64::from(pieces);
        let mut sums = [0.0; 3];
        for piece in 0..pieces {
            for (u, weight) in &rule {
                let (sin, cos) = (from + length * (f64::from(piece) + u)).sin_cos();
                let term = cos.powf(n) * weight * length;
                let factors = [1.0, cos * cos, cos * sin];
                std::iter::zip(&mut sums, factors).for_each(|(s, f)| *s += term * f);
            }
        }
        sums
    }

    #[test]
    fn integrals_are_those_of_brute_force() {
        for n in [0.0, 0.3, 1.0, 20.0, 777.0, 1e5] {
            let powers = CosinePower::new(n);
            let width = (1.0 + n).sqrt().recip();
            let whole = powers.integrals([-FRAC_PI_2, FRAC_PI_2]).plain;
            for (from, to) in [
                (-9.0, 9.0),
                (-1.0, 3.0),
                (-0.2, -0.199_999),
                (-5.0, -2.0),
                (0.0, 1.0),
                (2.0, 2.001),
                (4.0, 4.5),
                (1.5, 40.0),
            ] {
                let range = [from, to].map(|x: f64| (x * width).clamp(-1.5, 1.5));
                let found = powers.integrals(range);
                let found = [found.plain, found.cos2, found.cos_sin];
                let expected = brute_force(n, range);
                for (a, b) in found.into_iter().zip(expected) {
                    assert!((a - b).abs() < 3e-12 * whole, "{n}, {range:?}: {a:e} {b:e}");
                }
                // Tails keep their digits.
                let ratio = found[0] / expected[0];
                assert!(
                    (ratio - 1.0).abs() < 1e-6 || expected[0] < 1e-17 * whole,
                    "{n}, {range:?}: {ratio}"
                );
            }
        }
    }

    #[test]
    fn whole_turns_are_beta_functions() {
        for n in [0.0f64, 1.0, 3.5, 200.0, 1e5] {
            let gamma = |x: f64| libm::lgamma(x);
            let expected = PI.sqrt() * (gamma(0.5 * n + 0.5) - gamma(0.5 * n + 1.0)).exp();
            let whole = CosinePower::new(n).integrals([-FRAC_PI_2, FRAC_PI_2]).plain;
            assert!(
                (whole / expected - 1.0).abs() < 1e-9,
                "{n}: {whole} {expected}"
            );
        }
    }
}
