//! How far compressed factors are off, as stated with them.

use super::operator::{FactorOperator, OperatorError};
use super::{CompressedFactors, probe_vector};
use crate::form_factors::PreparedPlan;
use azulejo_trace::{Cancelled, Progress, REPLICATES};

/// Random vectors whose products are compared.
const PROBES: u32 = 4;

/// Most rows that are traced again.
const ROWS: usize = 1_024;

/// Rows traced at a time.
const BLOCK: usize = 128;

/// The stream of rays of rows that are traced again: others choose blocks and fill them.
const STREAM: u32 = 2;

/// A number and its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimated {
    /// The number.
    pub value: f64,
    /// Its standard error; 0 where it is not estimated.
    pub error: f64,
}

/// How far products and row sums are off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StatedErrors {
    /// ‖ΔX x‖ / ‖X x‖ in the norm ‖x‖² = Σ A_i x_i², root mean square over vectors x of independent numbers
    /// in 0..1.
    pub product: Estimated,
    /// Root mean square of Σ_j ΔX_ij over the rows.
    pub sums: Estimated,
    /// Rows that were traced again by rays of their own, for an estimate of the errors against the truth;
    /// 0 if these are exact, against the matrix that was compressed, whatever its own errors are.
    pub rows: u64,
}

impl StatedErrors {
    /// The errors against the matrix that was compressed.
    ///
    /// # Panics
    /// If the two have different numbers of rows.
    pub fn against(compressed: &CompressedFactors, exact: &dyn FactorOperator) -> StatedErrors {
        let error = OperatorError::of(compressed, exact, PROBES, 0);
        let known = |value: f64| Estimated { value, error: 0.0 };
        StatedErrors {
            product: known(error.product),
            sums: known(error.mean_of_sum),
            rows: 0,
        }
    }

    /// Estimates of the errors against the truth, noise and what blocks average out included, by rays that
    /// neither chose blocks nor filled them, from up to 1,024 rows spread over all clusters.
    ///
    /// Each replicate of such a row is an unbiased estimate y of its product, independent of the product f
    /// of the factors and of the other replicates, so that (f − y_a) (f − y_b) has the square of the error
    /// as its mean. Its standard error is that of means over these rows.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// If the plan has other rows.
    pub fn by_rays(
        factors: &CompressedFactors,
        plan: &PreparedPlan,
        progress: &Progress,
    ) -> Result<StatedErrors, Cancelled> {
        let n = factors.len();
        assert_eq!(n, plan.rows(), "the rows of the plan");
        let stream = plan.row_stream(plan.requested_rays(), STREAM);
        let mut vectors: Vec<Vec<f64>> = (0..PROBES).map(|k| probe_vector(n, 0, k)).collect();
        vectors.push(vec![1.0; n]);
        let products: Vec<Vec<f64>> = vectors.iter().map(|x| factors.apply(x)).collect();
        let count = ROWS.min(n);
        let rows: Vec<u32> = (0..count).map(|k| factors.order[k * n / count]).collect();
        let (mut product_squares, mut sum_squares) = (Vec::new(), Vec::new());
        progress.begin("stated errors", count as u64);
        for rows in rows.chunks(BLOCK) {
            let again = stream.products(rows, &vectors, progress)?;
            for (&row, again) in rows.iter().zip(again) {
                let (row, area) = (row as usize, factors.areas[row as usize]);
                let square = |k: usize| squared_error(products[k][row], again[k]);
                let probes = 0..PROBES as usize;
                let off: f64 = probes.clone().map(square).sum();
                let whole: f64 = probes.map(|k| products[k][row].powi(2)).sum();
                product_squares.push([area * off, area * whole]);
                sum_squares.push([square(PROBES as usize), 1.0]);
            }
        }
        Ok(StatedErrors {
            product: root_of_ratio(&product_squares),
            sums: root_of_ratio(&sum_squares),
            rows: count as u64,
        })
    }
}

/// An unbiased estimate of the square of the error of a `product`: the mean of (f − y_a) (f − y_b) over pairs
/// of replicates.
fn squared_error(product: f64, replicates: [f64; REPLICATES]) -> f64 {
    let off = replicates.map(|y| product - y);
    let sum: f64 = off.iter().sum();
    let squares: f64 = off.iter().map(|d| d * d).sum();
    (sum * sum - squares) / (REPLICATES * (REPLICATES - 1)) as f64
}

/// √(Σ a / Σ b) of pairs [a, b], and how far it goes up with one standard error of the ratio.
fn root_of_ratio(pairs: &[[f64; 2]]) -> Estimated {
    let sum = |k: usize| pairs.iter().map(|p| p[k]).sum::<f64>();
    let (a, b) = (sum(0), sum(1));
    if b <= 0.0 {
        return Estimated::default();
    }
    let ratio = a / b;
    let spread: f64 = pairs.iter().map(|[a, b]| (a - ratio * b).powi(2)).sum();
    let count = pairs.len() as f64;
    let error = (spread * count / (count - 1.0).max(1.0)).sqrt() / b;
    let value = ratio.max(0.0).sqrt();
    Estimated {
        value,
        error: (ratio.max(0.0) + error).sqrt() - value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_trace::sampling::uniform;

    #[test]
    fn noise_of_replicates_does_not_count() {
        // A product that is off by 0.1, known by replicates with ten times that noise.
        let pair = |k: u32| {
            let noise = |r: u32| f64::from(uniform(&[k, r])) - 0.5;
            let again = [0, 1, 2, 3].map(|r| 1.0 + 2.0 * noise(r));
            [squared_error(1.1, again), 1.0]
        };
        let pairs: Vec<[f64; 2]> = (0..20_000).map(pair).collect();
        let Estimated { value, error } = root_of_ratio(&pairs);
        assert!((value - 0.1).abs() < 3.0 * error, "{value} ± {error}");
        assert!(error < 0.02 && error > 1e-4, "{error}");
    }

    #[test]
    fn errors_below_nothing_are_none() {
        let root = root_of_ratio(&[[-1.0, 4.0], [0.5, 4.0]]);
        assert!(root.value == 0.0 && root.error > 0.0, "{root:?}");
        assert_eq!(root_of_ratio(&[]), Estimated::default());
    }
}
