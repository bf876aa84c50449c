//! Whether two results are the same within their errors.
//!
//! Each quantity may differ by five standard errors of the difference, by the systematic errors of both, by
//! what the change legitimately alters, and by the last digits of its file:
//!
//! |a − b| ≤ k √(σ_a² + σ_b²) + β_a + β_b + slack · span + 10⁻⁶ span, with k = 5 + 130 / 4ν
//!
//! Many errors are themselves estimates, from four replicates. So that one that is too small by chance is
//! no failure, quantities of a family, as the factors of a row, share theirs: σ² is at least c |value|,
//! c = Σσ² / Σ|value| over the family, or the median of c over all families, if that is larger. k is the
//! quantile of Student's distribution that belongs to 5 of the normal one, to first order, with
//! ν = 3 degrees of freedom for each quantity.

use std::collections::{BTreeMap, HashMap};

/// A number of a result.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// What it is; the same in both results.
    pub name: String,
    /// Its value, in the units of the original.
    pub value: f64,
    /// Its standard error, 0 for what is exact.
    pub error: f64,
    /// A bound on its systematic error, as that of a division into patches.
    pub bias: f64,
    /// What the slack is multiplied with: how large it could be.
    pub span: f64,
    /// Those of one number share their errors.
    pub family: Option<usize>,
}

/// The quantity that differs most.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// What it is.
    pub name: String,
    /// Its value in the original.
    pub expected: f64,
    /// Its value in the changed scene.
    pub found: f64,
    /// Standard error of the difference.
    pub error: f64,
    /// The largest difference that is right.
    pub bound: f64,
}

/// What a comparison found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Number of quantities.
    pub quantities: usize,
    /// How many of them are beyond their bounds.
    pub off: usize,
    /// The one that is closest to its bound, or farthest beyond it.
    pub worst: Option<Difference>,
}

/// Standard errors that a difference may be large.
const SIGMAS: f64 = 5.0;

/// Degrees of freedom of an error of four replicates.
const FREEDOM: f64 = 3.0;

/// Last digits of files, relative to the span.
const DIGITS: f64 = 1e-6;

impl Quantity {
    /// A number without error.
    pub fn exact(name: impl Into<String>, value: f64) -> Quantity {
        Quantity {
            name: name.into(),
            value,
            error: 0.0,
            bias: 0.0,
            span: value.abs(),
            family: None,
        }
    }
}

/// Compares two results; `slack` is what the change alters, relative to the span of a quantity. With
/// `is_exact` they have to be the same bits.
pub fn compare(
    expected: &[Quantity],
    found: &[Quantity],
    slack: f64,
    is_exact: bool,
) -> Comparison {
    let (expected_errors, found_errors) = (shared_errors(expected), shared_errors(found));
    let mut pairs: BTreeMap<&str, [Option<(&Quantity, f64)>; 2]> = BTreeMap::new();
    for (k, quantities, errors) in [(0, expected, &expected_errors), (1, found, &found_errors)] {
        for (quantity, &error) in quantities.iter().zip(errors) {
            pairs.entry(&quantity.name).or_default()[k] = Some((quantity, error));
        }
    }
    let freedom = FREEDOM * (expected.len() + found.len()).max(1) as f64;
    let sigmas = SIGMAS + (SIGMAS.powi(3) + SIGMAS) / (4.0 * freedom);
    let mut comparison = Comparison::default();
    let mut nearness = f64::NEG_INFINITY;
    for (name, pair) in pairs {
        let value = |k: usize| pair[k].map_or(0.0, |(q, _)| q.value);
        let error = |k: usize| pair[k].map_or(0.0, |(_, e)| e);
        let bias: f64 = pair.iter().flatten().map(|(q, _)| q.bias).sum();
        let span = pair.iter().flatten().map(|(q, _)| q.span);
        let span = span.fold(0.0, f64::max);
        let error = error(0).hypot(error(1));
        let bound = if is_exact {
            0.0
        } else {
            sigmas * error + bias + (slack + DIGITS) * span
        };
        let difference = (value(0) - value(1)).abs();
        // Not a number is beyond any bound.
        let is_right = difference <= bound;
        comparison.quantities += 1;
        comparison.off += usize::from(!is_right);
        let own = if is_right && bound == 0.0 {
            0.0
        } else if difference.is_finite() {
            difference / bound.max(f64::MIN_POSITIVE)
        } else {
            f64::INFINITY
        };
        if own > nearness {
            nearness = own;
            comparison.worst = Some(Difference {
                name: name.to_owned(),
                expected: value(0),
                found: value(1),
                error,
                bound,
            });
        }
    }
    comparison
}

/// The error of each quantity, at least what its family has for its value.
fn shared_errors(quantities: &[Quantity]) -> Vec<f64> {
    let mut sums: HashMap<usize, [f64; 2]> = HashMap::new();
    for quantity in quantities {
        if let Some(family) = quantity.family {
            let sum = sums.entry(family).or_default();
            sum[0] += quantity.error * quantity.error;
            sum[1] += quantity.value.abs();
        }
    }
    let ratio = |[square, value]: [f64; 2]| if value > 0.0 { square / value } else { 0.0 };
    let mut ratios: Vec<f64> = sums.values().map(|&sum| ratio(sum)).collect();
    ratios.sort_by(f64::total_cmp);
    let median = ratios.get(ratios.len() / 2).copied().unwrap_or(0.0);
    let error = |q: &Quantity| {
        let Some(sum) = q.family.and_then(|family| sums.get(&family)) else {
            return q.error;
        };
        let share = ratio(*sum).max(median);
        q.error.max((share * q.value.abs()).sqrt())
    };
    quantities.iter().map(error).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(name: &str, value: f64, error: f64) -> Quantity {
        Quantity {
            name: name.to_owned(),
            value,
            error,
            bias: 0.0,
            span: 1.0,
            family: Some(0),
        }
    }

    #[test]
    fn errors_and_slack_decide() {
        let check = |value: f64, slack: f64| {
            let many = |x: f64| (0..50).map(move |k| factor(&k.to_string(), x, 0.01));
            let (a, b): (Vec<_>, Vec<_>) = (many(0.2).collect(), many(value).collect());
            compare(&a, &b, slack, false).off
        };
        assert_eq!(check(0.27, 0.0), 0);
        assert_eq!(check(0.28, 0.0), 50);
        assert_eq!(check(0.28, 0.01), 0);
        assert_eq!(check(f64::NAN, 9.0), 50);
    }

    /// A quantity whose own error is too small by chance is judged by that of its family.
    #[test]
    fn families_share_errors() {
        let a = [factor("a", 0.5, 0.01), factor("b", 0.5, 0.0)];
        let b = [factor("a", 0.5, 0.01), factor("b", 0.53, 0.0)];
        assert_eq!(compare(&a, &b, 0.0, false).off, 0);
    }

    #[test]
    fn what_is_missing_is_zero() {
        let a = [factor("a", 0.5, 0.0)];
        let comparison = compare(&a, &[], 0.0, false);
        assert_eq!((comparison.quantities, comparison.off), (1, 1));
        assert_eq!(comparison.worst.unwrap().found, 0.0);
    }

    #[test]
    fn bits_are_bits() {
        let a = [Quantity::exact("a", 1.0)];
        let b = [Quantity::exact("a", 1.0 + 1e-12)];
        assert_eq!(compare(&a, &b, 0.0, false).off, 0);
        assert_eq!(compare(&a, &b, 0.0, true).off, 1);
        assert_eq!(compare(&a, &a, 0.0, true).off, 0);
    }
}
