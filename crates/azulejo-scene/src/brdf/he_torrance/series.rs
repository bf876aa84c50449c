//! He and Torrance's series over the powers of the roughness.

use std::f64::consts::TAU;

/// The smallest g whose series is summed with a stride.
const LARGE: f64 = 60.0;

/// Logarithm of the fraction of the sum below which terms are neglected.
const LEAST: f64 = -34.0;

/// Σ gᵐ e⁻ᵍ/(m·m!) exp(−x/m) over m ≥ 1, for g, x ≥ 0.
///
/// The terms are those of a Poisson distribution about g, or beyond where x is large. Relative
/// error below 1e-12 where g < 60, and below 1e-10 above.
pub(super) fn sum(g: f64, x: f64) -> f64 {
    if !(g > 0.0 && g.is_finite() && x.is_finite()) {
        0.0
    } else if g < LARGE {
        one_by_one(g, x)
    } else {
        by_strides(g, x)
    }
}

fn one_by_one(g: f64, x: f64) -> f64 {
    let last = (g + 14.0 * g.sqrt() + 60.0).ceil();
    let (mut sum, mut poisson, mut m) = (0.0, (-g).exp(), 1.0);
    while m <= last {
        poisson *= g / m;
        sum += poisson / m * (-x / m).exp();
        // exp(−x/m) never exceeds 1, and the other factor falls by more than half with each term.
        if m > 2.0 * g && poisson < 1e-18 * sum {
            break;
        }
        m += 1.0;
    }
    sum
}

/// Logarithm of the term m times √(2π) g^(3/2), a smooth function of m by Stirling's series.
fn log_term(g: f64, x: f64, m: f64) -> f64 {
    let off = (g - m) / m;
    let inverse = 1.0 / m;
    let square = inverse * inverse;
    let stirling = inverse * (1.0 / 12.0 - square * (1.0 / 360.0 - square / 1260.0));
    let log = off.ln_1p();
    // The powers of m in m! and m: (g/m)^(3/2), without g.
    -m * (off - log) + 1.5 * log - stirling - x * inverse
}

/// The sum over all integers equals that over every s-th number, times s, as long as a stride is
/// narrower than the terms' bell: both are its integral, with errors of exp(−2π² width²/s²)
/// (Poisson's summation formula). So no g needs more than some sixty terms.
fn by_strides(g: f64, x: f64) -> f64 {
    let peak = peak(g, x);
    let width = 1.0 / (1.0 / peak + 2.0 * x / peak.powi(3)).sqrt();
    let stride = 0.75 * width;
    let top = log_term(g, x, peak);
    let term = |k: f64| {
        let m = peak + k * stride;
        if m < 1.0 {
            f64::NEG_INFINITY
        } else {
            log_term(g, x, m) - top
        }
    };
    let mut sum = 1.0;
    for side in [-1.0, 1.0] {
        for k in 1..100 {
            let log = term(side * f64::from(k));
            if log < LEAST {
                break;
            }
            sum += log.exp();
        }
    }
    sum * stride * top.exp() / (TAU.sqrt() * g * g.sqrt())
}

/// The largest term, by Newton's method on the derivative of the logarithm.
fn peak(g: f64, x: f64) -> f64 {
    let mut m = g;
    for _ in 0..60 {
        let slope = (g / m).ln() - 1.5 / m + x / (m * m);
        let bend = -1.0 / m + 1.5 / (m * m) - 2.0 * x / m.powi(3);
        let next = (m - slope / bend).max(0.5 * m);
        if (next - m).abs() < 1e-3 * m.sqrt() {
            return next;
        }
        m = next;
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every term, in log space.
    fn plain(g: f64, x: f64) -> f64 {
        let last = (g + 14.0 * g.sqrt() + 60.0) as u32;
        let term = |m: u32| {
            let m = f64::from(m);
            (m * g.ln() - g - m.ln() - libm::lgamma(m + 1.0) - x / m).exp()
        };
        (1..=last).map(term).sum()
    }

    #[test]
    fn sums_are_those_of_all_terms() {
        let check = |g: f64, x: f64| {
            let (value, expected) = (sum(g, x), plain(g, x));
            // log Γ of large numbers has few digits after the decimal point.
            let tolerance = 1e-12 * (10.0 + g);
            assert!(
                (value - expected).abs() <= tolerance * expected,
                "g = {g}, x = {x}: {value:e} instead of {expected:e}"
            );
        };
        for g in [1e-9, 0.3, 7.0, 59.9, 60.1, 150.0, 400.0, 5000.0] {
            for x in [0.0, 0.1, 1.0, 5.0, 0.5 * g, 3.0 * g] {
                check(g, x);
            }
        }
    }

    #[test]
    fn extremes_are_numbers() {
        for g in [0.0, 1e-300, 1.0, 1e3, 1e12, 1e300] {
            for x in [0.0, 1e-300, 1e3, 1e12, 1e300] {
                let value = sum(g, x);
                assert!(
                    value >= 0.0 && value.is_finite(),
                    "g = {g}, x = {x}: {value}"
                );
            }
        }
        assert_eq!(sum(f64::INFINITY, 1.0), 0.0);
    }
}
