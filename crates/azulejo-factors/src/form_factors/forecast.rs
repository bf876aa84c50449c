//! How much memory a matrix will take, found out before it is begun.

use super::sides::Sides;
use crate::engine::Estimator;
use crate::row::{Row, Side};
use azulejo_scene::math::Ray;
use azulejo_trace::sampling::{seeds, sobol};
use azulejo_trace::{Cancelled, KernelRay, Progress, Tracer};

/// Rows that are computed to see how many entries they have.
const ROWS: usize = 24;

/// Pairs of patches that are asked whether they see each other.
const PAIRS: u32 = 4_096;

/// So few rows have memory enough for all pairs: nobody asks.
const FEW: usize = 512;

/// Bytes of a patch and of what belongs to its row, about.
pub(super) const PATCH_BYTES: f64 = 700.0;

/// Bytes of a pair in the matrix.
const PAIR_BYTES: f64 = 16.0;

/// Bytes of an entry of a row before it is merged with those of other rows.
const ENTRY_BYTES: f64 = 12.0;

/// What a matrix will take. Its figures are rather too high than too low.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forecast {
    /// Rows of the matrix.
    pub rows: usize,
    /// Pairs that will be kept.
    pub pairs: u64,
    /// Bytes at the worst moment.
    pub bytes: u64,
}

/// What is known of an engine that estimates rows.
pub(super) struct Costs<'a> {
    pub sides: &'a Sides<'a>,
    pub tracer: &'a Tracer,
    /// Finds a few rows by rays, whoever finds the rest.
    pub sampler: &'a Estimator<'a>,
    /// Rays or pixels of the rows that will be found.
    pub rays: u32,
    /// Whether each row is kept until all are there, and finds no more than its rays do; else
    /// pairs go straight into the matrix, and all that are visible do.
    pub by_rows: bool,
    /// Matrices that are kept.
    pub matrices: usize,
    pub seed: u32,
}

impl Costs<'_> {
    /// Looks at a few rows and pairs to see how many patches see each other.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn forecast(&self, progress: &Progress) -> Result<Forecast, Cancelled> {
        let n = self.sides.len() as f64;
        let seen = if self.sides.len() <= FEW {
            n
        } else {
            self.seen(progress)?.min(n)
        };
        let rays = f64::from(self.rays);
        let found_by = |rays: f64| {
            if self.by_rows {
                seen * (1.0 - (-rays / seen.max(1.0)).exp())
            } else {
                seen
            }
        };
        // The rays of both sides find a pair.
        let pairs = n * (found_by(2.0 * rays) + 1.0) / 2.0;
        let entries = if self.by_rows {
            n * found_by(rays)
        } else {
            0.0
        };
        let matrix = pairs * PAIR_BYTES * self.matrices as f64;
        // Rows go while the matrix comes, but allocators seldom give back what they left.
        let bytes = n * PATCH_BYTES + entries * ENTRY_BYTES + matrix;
        Ok(Forecast {
            rows: self.sides.len(),
            pairs: pairs as u64,
            bytes: bytes as u64,
        })
    }

    /// Number of patches that a row sees, on average: what rows find, corrected for what so few
    /// rays miss, or what pairs of points show, whichever is more.
    fn seen(&self, progress: &Progress) -> Result<f64, Cancelled> {
        progress.begin("forecast", ROWS as u64);
        let step = self.sides.len().div_ceil(ROWS);
        let rows: Vec<Side> = (0..self.sides.len())
            .step_by(step)
            .map(|i| self.sides.side(i))
            .collect();
        let found = self.sampler.rows(&rows, progress)?;
        let columns: usize = found.iter().map(columns).sum();
        let mean = columns as f64 / rows.len() as f64;
        let by_rows = behind(mean, f64::from(self.sampler.rays()));
        Ok(by_rows.max(self.visible_share() * self.sides.len() as f64))
    }

    /// Share of all pairs that see each other between two random points.
    fn visible_share(&self) -> f64 {
        let scrambling = seeds(&[self.seed, 0xf0]);
        let n = self.sides.len() as f64;
        let mut rays = Vec::new();
        for k in 0..PAIRS {
            let u = [0, 1, 2, 3].map(|d| f64::from(sobol(k, d, scrambling[d])));
            let [i, j] = [u[0], u[1]].map(|u| (u * n) as usize % self.sides.len());
            rays.extend(self.between(i, j, u[2], u[3]));
        }
        let mut blocked = Vec::new();
        self.tracer.any(&rays, &mut blocked);
        let free = blocked.iter().filter(|&&blocked| !blocked).count();
        free as f64 / f64::from(PAIRS)
    }

    /// A ray between points of two rows that face each other.
    fn between(&self, i: usize, j: usize, u: f64, v: f64) -> Option<KernelRay> {
        let at = |row: usize| {
            let point = self.sides.patches.sample(self.sides.patch(row), u, v);
            let flip = if self.sides.is_back(row) { -1.0 } else { 1.0 };
            (point.position, flip * point.normal)
        };
        let ((x, m), (y, n)) = (at(i), at(j));
        let way = y - x;
        let faces = way.dot(m) > 0.0 && way.dot(n) < 0.0;
        let ends = || (self.tracer.leaving(x, m), self.tracer.leaving(y, n));
        faces.then(|| {
            let (from, to) = ends();
            self.tracer.kernel_ray(&Ray::between(from, to))
        })
    }
}

/// Different sides that a row found.
fn columns(row: &Row) -> usize {
    let entries = row.entries.iter().flatten();
    let mut sides: Vec<Side> = entries.map(|e| e.side).collect();
    sides.sort_unstable();
    sides.dedup();
    sides.len()
}

/// How many equal targets there are, if `rays` rays found so many of them: the solution V of
/// V (1 − e^(−rays/V)) = found, by bisection.
fn behind(found: f64, rays: f64) -> f64 {
    let (mut low, mut high) = (found, 1e12f64.max(found));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if middle * (1.0 - (-rays / middle).exp()) < found {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_few_rays_miss() {
        for (targets, rays) in [(100.0f64, 50.0f64), (1_000.0, 4_096.0), (5e5, 4_096.0)] {
            let found = targets * (1.0 - (-rays / targets).exp());
            let said = behind(found, rays);
            assert!((said / targets - 1.0).abs() < 0.01, "{said} {targets}");
        }
    }
}
