//! Least-squares smoothing: the smallest change of a symmetric matrix that corrects its row sums.

use crate::exchange_areas::{Exchange, ExchangeAreas};
use azulejo_trace::{Cancelled, Progress};

/// Most iterations; rooms take 10 to 40.
const STEPS: u32 = 200;

/// No entry falls below this share of its value.
pub(super) const LEAST: f64 = 0.1;

/// A smoothing problem: the deficits of rows and the variances of entries.
///
/// Of all symmetric ΔS with Σ_j ΔS_ij k_j = the deficit of row i, the smallest in the norm weighted
/// by the variances V has the form ΔS_ij = V_ij (λ_i k_j + λ_j k_i), with one Lagrange multiplier λ
/// per row. Entries by rays, whose variance is about proportional to S, are scaled as by a diagonal
/// matrix from both sides; exact entries stay as they are. (Larsen and Howell, *Least-squares
/// smoothing of direct-exchange areas in zonal analysis*, J. Heat Transfer 108, 1986.)
pub(super) struct Smoothing<'a, V> {
    pub exchange: &'a ExchangeAreas,
    /// V of the pair of row i.
    pub variance: V,
    /// k: the weight of each column in the sums of rows.
    pub weights: &'a [f64],
    /// Variance of what each row has besides its pairs, which may change too.
    pub free: Vec<f64>,
    /// The deficit of each row's sum.
    pub deficits: Vec<f64>,
    /// The deficit tolerated in each row.
    pub tolerated: Vec<f64>,
}

impl<V: Fn(usize, &Exchange) -> f64 + Sync> Smoothing<'_, V> {
    /// The solution, or the last iterate where no change can correct all rows, as between two
    /// halves that see only each other.
    ///
    /// Conjugate gradients, preconditioned with the diagonal.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn solve(&self, progress: &Progress) -> Result<SmoothingChange, Cancelled> {
        let inverse = self.inverse();
        let precondition =
            |rest: &[f64]| -> Vec<f64> { rest.iter().zip(&inverse).map(|(r, m)| r * m).collect() };
        let n = self.deficits.len();
        let mut multipliers = vec![0.0; n];
        let mut rest = self.deficits.clone();
        mask(&mut rest, &inverse);
        let mut direction = precondition(&rest);
        let mut product = dot(&rest, &direction);
        progress.begin("row sums", u64::from(STEPS));
        for _ in 0..STEPS {
            progress.advance(1)?;
            if (0..n).all(|i| rest[i].abs() <= self.tolerated[i]) {
                break;
            }
            let mut image = self.times(&direction);
            mask(&mut image, &inverse);
            let step = product / dot(&direction, &image);
            if !step.is_finite() {
                break;
            }
            add(&mut multipliers, step, &direction);
            add(&mut rest, -step, &image);
            let next = precondition(&rest);
            let grown = dot(&rest, &next);
            let turn = grown / product;
            direction
                .iter_mut()
                .zip(&next)
                .for_each(|(d, z)| *d = z + turn * *d);
            product = grown;
        }
        Ok(SmoothingChange {
            multipliers,
            weights: self.weights.to_vec(),
        })
    }

    /// The matrix of the equations for λ times `x`.
    fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut product = self.exchange.sums(|i, e| {
            let change = (self.variance)(i, e) * slope(x, self.weights, i, e);
            [
                change * self.weights[e.column as usize],
                change * self.weights[i],
            ]
        });
        let free = product.iter_mut().zip(&self.free).zip(x);
        free.for_each(|((p, free), x)| *p += free * x);
        product
    }

    /// Inverse of the matrix's diagonal; 0 for rows without anything to change.
    fn inverse(&self) -> Vec<f64> {
        let diagonal = self.exchange.sums(|i, e| {
            let variance = (self.variance)(i, e);
            [
                variance * self.weights[e.column as usize].powi(2),
                variance * self.weights[i].powi(2),
            ]
        });
        let rows = diagonal.iter().zip(&self.free);
        rows.map(|(d, free)| {
            if d + free > 0.0 {
                (d + free).recip()
            } else {
                0.0
            }
        })
        .collect()
    }
}

/// A change of a matrix and of what its rows have besides.
pub(super) struct SmoothingChange {
    /// λ of every row; 0 for rows without anything to change.
    multipliers: Vec<f64>,
    /// k of every row.
    weights: Vec<f64>,
}

impl SmoothingChange {
    /// The positive factor for S of a pair of row `i` with this variance.
    pub fn ratio(&self, variance: f64, i: usize, e: &Exchange) -> f64 {
        let change = variance * slope(&self.multipliers, &self.weights, i, e);
        if change == 0.0 {
            return 1.0;
        }
        (1.0 + change / e.value).max(LEAST)
    }

    /// What to add to a value of row `i` besides its pairs, with this variance.
    pub fn beside(&self, variance: f64, i: usize) -> f64 {
        variance * self.multipliers[i]
    }
}

/// λ_i k_j + λ_j k_i.
fn slope(multipliers: &[f64], weights: &[f64], i: usize, e: &Exchange) -> f64 {
    let j = e.column as usize;
    multipliers[i] * weights[j] + multipliers[j] * weights[i]
}

/// Zeroes the values of rows that stay as they are.
fn mask(values: &mut [f64], inverse: &[f64]) {
    let fixed = values.iter_mut().zip(inverse).filter(|(_, m)| **m == 0.0);
    fixed.for_each(|(v, _)| *v = 0.0);
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn add(to: &mut [f64], share: f64, x: &[f64]) {
    to.iter_mut().zip(x).for_each(|(t, x)| *t += share * x);
}
