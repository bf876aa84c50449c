//! Truncated singular value decompositions of blocks, and of blocks beside each other.

/// Σ_k u_k v_kᵀ with orthonormal u_k and orthogonal v_k, whose lengths are the singular values: a
/// singular value decomposition.
#[derive(Clone, Debug, Default)]
pub(super) struct LowRank {
    pub u: Vec<Vec<f64>>,
    pub v: Vec<Vec<f64>>,
}

/// Sweeps of Jacobi's method; blocks take 4 to 8.
const SWEEPS: usize = 30;

/// Cosine of the angle between two vectors that counts as right.
const RIGHT: f64 = 1e-12;

impl LowRank {
    /// The matrix with these columns, each of equal length, with an error whose square (the sum of
    /// squares of all entries) is at most `allowed`; `None` if that takes more than `most` terms.
    /// Returns the square of the error too.
    ///
    /// Gram and Schmidt's method with the longest remaining column as the next pivot finds a subspace,
    /// in which singular vectors are found by Jacobi's method.
    pub fn of(mut columns: Vec<Vec<f64>>, allowed: f64, most: usize) -> Option<(LowRank, f64)> {
        let mut block = LowRank::default();
        let mut left: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
        // The last term or two that pivots need beyond singular vectors are cut off again.
        let slack = most + 2;
        loop {
            let error: f64 = left.iter().sum();
            if error <= allowed {
                orthogonalize(&mut block.v, &mut block.u);
                let error = error + block.truncate(allowed - error);
                return Some((block, error)).filter(|b| b.0.rank() <= most);
            }
            if block.rank() == slack {
                return None;
            }
            let pivot = (0..left.len()).max_by(|&a, &b| left[a].total_cmp(&left[b]))?;
            let length = left[pivot].sqrt();
            if length.is_nan() || length <= 0.0 {
                return None;
            }
            let unit: Vec<f64> = columns[pivot].iter().map(|x| x / length).collect();
            let mut shares = Vec::with_capacity(columns.len());
            for (column, left) in columns.iter_mut().zip(&mut left) {
                let share = dot(&unit, column);
                add(column, -share, &unit);
                *left = dot(column, column);
                shares.push(share);
            }
            // What rounding leaves of the pivot would be noise.
            columns[pivot].fill(0.0);
            left[pivot] = 0.0;
            block.u.push(unit);
            block.v.push(shares);
        }
    }

    /// Number of terms.
    pub fn rank(&self) -> usize {
        self.u.len()
    }

    /// This block above another with the same columns, m and n being their numbers of rows.
    pub fn above(self, below: LowRank, m: usize, n: usize) -> LowRank {
        let upper = self.u.into_iter().map(|u| padded(u, 0, n));
        let lower = below.u.into_iter().map(|u| padded(u, m, 0));
        let mut whole = LowRank {
            u: upper.chain(lower).collect(),
            v: self.v.into_iter().chain(below.v).collect(),
        };
        orthogonalize(&mut whole.v, &mut whole.u);
        whole
    }

    /// This block left of another with the same rows, m and n being their numbers of columns.
    pub fn beside(self, right: LowRank, m: usize, n: usize) -> LowRank {
        self.transposed()
            .above(right.transposed(), m, n)
            .transposed()
    }

    fn transposed(mut self) -> LowRank {
        for (u, v) in self.u.iter_mut().zip(&mut self.v) {
            let length = dot(v, v).sqrt();
            if length > 0.0 {
                v.iter_mut().for_each(|x| *x /= length);
            }
            u.iter_mut().for_each(|x| *x *= length);
        }
        LowRank {
            u: self.v,
            v: self.u,
        }
    }

    /// Drops the smallest terms while the sum of their squares is at most `allowed`; returns that sum.
    pub fn truncate(&mut self, allowed: f64) -> f64 {
        let mut order: Vec<(f64, usize)> = (0..self.rank())
            .map(|k| (dot(&self.v[k], &self.v[k]), k))
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let (mut dropped, mut rank) = (0.0, order.len());
        while rank > 0 && dropped + order[rank - 1].0 <= allowed {
            rank -= 1;
            dropped += order[rank].0;
        }
        order.truncate(rank);
        let take = |from: &mut Vec<Vec<f64>>| {
            order
                .iter()
                .map(|&(_, k)| std::mem::take(&mut from[k]))
                .collect()
        };
        self.u = take(&mut self.u);
        self.v = take(&mut self.v);
        dropped
    }
}

/// Turns the vectors `a` in pairs until they are orthogonal, and `b` with them, so that Σ a bᵀ stays:
/// Jacobi's method for singular values (Hestenes, *Inversion of matrices by biorthogonalization and
/// related results*, 1958).
fn orthogonalize(a: &mut [Vec<f64>], b: &mut [Vec<f64>]) {
    for _ in 0..SWEEPS {
        let mut is_done = true;
        for j in 1..a.len() {
            for i in 0..j {
                let (x, y, c) = (dot(&a[i], &a[i]), dot(&a[j], &a[j]), dot(&a[i], &a[j]));
                if c.abs() <= RIGHT * (x * y).sqrt() || c == 0.0 {
                    continue;
                }
                is_done = false;
                let slope = (y - x) / (2.0 * c);
                let tangent = slope.signum() / (slope.abs() + slope.hypot(1.0));
                let cosine = tangent.hypot(1.0).recip();
                turn(a, i, j, cosine, tangent * cosine);
                turn(b, i, j, cosine, tangent * cosine);
            }
        }
        if is_done {
            return;
        }
    }
}

fn turn(vectors: &mut [Vec<f64>], i: usize, j: usize, cosine: f64, sine: f64) {
    let (first, second) = vectors.split_at_mut(j);
    for (x, y) in first[i].iter_mut().zip(&mut second[0]) {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
}

fn padded(mut vector: Vec<f64>, before: usize, after: usize) -> Vec<f64> {
    vector.splice(0..0, std::iter::repeat_n(0.0, before));
    vector.resize(vector.len() + after, 0.0);
    vector
}

/// In four sums, so that processors work on several at a time.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a_chunks, b_chunks) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest = a_chunks.remainder().iter().zip(b_chunks.remainder());
    let rest: f64 = rest.map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 4];
    for (a, b) in a_chunks.zip(b_chunks) {
        (0..4).for_each(|k| sums[k] += a[k] * b[k]);
    }
    sums.iter().sum::<f64>() + rest
}

fn add(to: &mut [f64], share: f64, x: &[f64]) {
    to.iter_mut().zip(x).for_each(|(to, x)| *to += share * x);
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_trace::sampling::uniform;

    /// Columns of smooth numbers with a little noise.
    fn columns(m: usize, n: usize, noise: f64) -> Vec<Vec<f64>> {
        let entry = |i: usize, j: usize| {
            let distance = 2.0 + (i as f64 / m as f64) + (j as f64 / n as f64);
            distance.powi(-2) + noise * f64::from(uniform(&[i as u32, j as u32]))
        };
        (0..n)
            .map(|j| (0..m).map(|i| entry(i, j)).collect())
            .collect()
    }

    fn error(block: &LowRank, columns: &[Vec<f64>]) -> f64 {
        let mut sum = 0.0;
        for (j, column) in columns.iter().enumerate() {
            for (i, value) in column.iter().enumerate() {
                let terms = block.u.iter().zip(&block.v);
                sum += (terms.map(|(u, v)| u[i] * v[j]).sum::<f64>() - value).powi(2);
            }
        }
        sum
    }

    #[test]
    fn the_stated_error_is_the_error() {
        for (allowed, most) in [(1e-2, 1), (1e-6, 4), (1e-12, 8)] {
            let matrix = columns(23, 17, 0.0);
            let (block, stated) = LowRank::of(matrix.clone(), allowed, most).unwrap();
            let actual = error(&block, &matrix);
            assert!(
                stated <= allowed && (actual - stated).abs() <= 1e-9 * allowed.max(1e-9),
                "{actual} {stated}"
            );
        }
    }

    #[test]
    fn noise_has_no_low_rank() {
        assert!(LowRank::of(columns(20, 20, 1.0), 1e-3, 8).is_none());
        assert_eq!(
            LowRank::of(vec![vec![0.0; 4]; 3], 0.0, 1).unwrap().0.rank(),
            0
        );
    }

    #[test]
    fn blocks_beside_each_other_become_one() {
        let matrix = columns(24, 16, 0.0);
        let halves = |from: usize, to: usize| matrix.iter().map(|c| c[from..to].to_vec()).collect();
        let factored = |columns| LowRank::of(columns, 1e-20, 16).unwrap().0;
        let (upper, lower) = (factored(halves(0, 10)), factored(halves(10, 24)));
        let mut whole = upper.above(lower, 10, 14);
        assert!(error(&whole, &matrix) < 1e-18);
        let dropped = whole.truncate(1e-8);
        assert!(dropped <= 1e-8 && error(&whole, &matrix) <= 1.0001e-8);
        assert!(whole.rank() < 5, "{}", whole.rank());
        let (left, right) = (
            factored(matrix[..7].to_vec()),
            factored(matrix[7..].to_vec()),
        );
        assert!(error(&left.beside(right, 7, 9), &matrix) < 1e-18);
    }
}
