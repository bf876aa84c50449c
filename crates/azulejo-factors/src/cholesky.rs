//! Dense symmetric positive definite systems.

use azulejo_trace::{Cancelled, Progress};
use rayon::prelude::*;

/// K = L Lᵀ, L by rows of a full matrix.
pub struct Cholesky {
    n: usize,
    lower: Vec<f64>,
}

impl Cholesky {
    /// Factors a matrix of `n` rows given row by row, of which the lower triangle counts. Fails with
    /// the number of the row at which the matrix proves not to be positive definite. Takes 8 n² bytes
    /// and n³/3 operations.
    ///
    /// Each column is computed for all rows below at once; these are independent, so the result
    /// does not depend on the number of threads.
    pub fn new(
        mut lower: Vec<f64>,
        n: usize,
        progress: &Progress,
    ) -> Result<Result<Cholesky, usize>, Cancelled> {
        for j in 0..n {
            progress.advance(0)?;
            let (above, below) = lower.split_at_mut((j + 1) * n);
            let row = &mut above[j * n..];
            let pivot = row[j] - dot(&row[..j], &row[..j]);
            // Written so that NaN fails.
            let is_positive = pivot > 0.0;
            if !is_positive {
                return Ok(Err(j));
            }
            row[j] = pivot.sqrt();
            let row = &*row;
            below.par_chunks_mut(n).with_min_len(64).for_each(|other| {
                other[j] = (other[j] - dot(&other[..j], &row[..j])) / row[j];
            });
        }
        Ok(Ok(Cholesky { n, lower }))
    }

    /// The solution x of K x = `right`, by two substitutions.
    ///
    /// # Panics
    /// If `right` has not one number for each row.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        assert_eq!(right.len(), self.n, "one number for each row");
        let mut x = right.to_vec();
        for k in 0..self.n {
            let row = &self.lower[k * self.n..];
            x[k] = (x[k] - dot(&row[..k], &x[..k])) / row[k];
        }
        self.substitute_back(x)
    }

    /// Row i of the inverse, which is also its column.
    pub fn inverse_row(&self, i: usize) -> Vec<f64> {
        let mut x = vec![0.0; self.n];
        x[i] = 1.0 / self.lower[i * self.n + i];
        for k in i + 1..self.n {
            let row = &self.lower[k * self.n..];
            x[k] = -dot(&row[i..k], &x[i..k]) / row[k];
        }
        self.substitute_back(x)
    }

    /// Solves Lᵀ x = `x`.
    fn substitute_back(&self, mut x: Vec<f64>) -> Vec<f64> {
        for k in (0..self.n).rev() {
            let row = &self.lower[k * self.n..];
            let value = x[k] / row[k];
            x[k] = value;
            x[..k]
                .iter_mut()
                .zip(row)
                .for_each(|(x, l)| *x -= value * l);
        }
        x
    }
}

/// Sum of products, in eight partial sums that vectorize.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<8>();
    let (b, b_rest) = b.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_is_one() {
        let n = 23;
        let entry = |i: usize, j: usize| {
            if i == j {
                30.0 + i as f64
            } else {
                1.0 / (1.0 + (i + j) as f64)
            }
        };
        let matrix: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
        let system = Cholesky::new(matrix.clone(), n, &Progress::new())
            .unwrap()
            .ok()
            .unwrap();
        for i in 0..n {
            let row = system.inverse_row(i);
            for j in 0..n {
                let product = dot(&row, &matrix[j * n..(j + 1) * n]);
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 1e-13, "{i} {j} {product}");
            }
        }
    }

    #[test]
    fn a_solution_is_one() {
        let matrix = vec![4.0, 9e9, 9e9, 1.0, 3.0, 9e9, 0.5, -1.0, 5.0];
        let system = Cholesky::new(matrix, 3, &Progress::new()).unwrap();
        let x = system.ok().unwrap().solve(&[1.0, 2.0, 3.0]);
        let rows = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 5.0]];
        for (row, right) in rows.iter().zip([1.0, 2.0, 3.0]) {
            assert!((dot(row, &x) - right).abs() < 1e-14);
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_named() {
        let matrix = vec![1.0, 2.0, 2.0, 1.0];
        let refused = Cholesky::new(matrix, 2, &Progress::new()).unwrap();
        assert_eq!(refused.err(), Some(1));
    }
}
