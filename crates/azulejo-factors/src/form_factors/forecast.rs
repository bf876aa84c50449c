//! Forecast of the memory that a matrix takes.

use super::matrix::block_bytes;
use super::rows;
use super::sides::Sides;
use crate::analytic_engine::exchanger;
use crate::estimator::Estimator;
use crate::row::{Entry, ORDERS, Row, Side};
use crate::shadow_rays::facing_ray;
use azulejo_trace::sampling::{seeds, sobol};
use azulejo_trace::{Cancelled, KernelRay, Progress, REPLICATES, Tracer};

/// Rows sampled to count their entries.
const ROWS: usize = 24;

/// Pairs of patches sampled for visibility.
const PAIRS: u32 = 4_096;

/// Up to this many rows all pairs are assumed to be visible: they fit anyway.
const FEW: usize = 512;

/// Bytes of a process before it reads a model, about.
const PROCESS_BYTES: f64 = 8e6;

/// Bytes per patch and row, about.
pub(super) const PATCH_BYTES: f64 = 700.0;

/// Bytes per pair of the matrix.
const PAIR_BYTES: f64 = 16.0;

/// Bytes per entry of a row before merging.
const ENTRY_BYTES: f64 = 12.0;

/// The size of a matrix before it is computed; an upper estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forecast {
    /// Rows of the matrix.
    pub rows: usize,
    /// Pairs that will be stored.
    pub pairs: u64,
    /// Bytes at the peak.
    pub bytes: u64,
    /// Seconds of CPU time on a usual core; `None` where the engine has no forecast.
    pub seconds: Option<f64>,
}

/// Cost model of an engine.
pub(super) struct Costs<'a> {
    pub sides: &'a Sides<'a>,
    pub tracer: &'a Tracer,
    /// Samples a few rows by rays, whatever the engine.
    pub sampler: &'a Estimator<'a>,
    /// Rays or pixels per row of the engine.
    pub rays: u32,
    /// Whether rows are stored until all are complete and find no more than their rays do; else all
    /// visible pairs go straight into the matrix.
    pub by_rows: bool,
    /// Number of matrices that are stored.
    pub matrices: usize,
    pub seed: u32,
}

impl Costs<'_> {
    /// Samples a few rows and pairs to estimate how many patches see each other.
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
        let columns = |rays: f64| {
            if self.by_rows {
                seen * (1.0 - (-rays / seen.max(1.0)).exp())
            } else {
                seen
            }
        };
        // The rays of both sides find a pair.
        let pairs = n * (columns(2.0 * rays) + 1.0) / 2.0;
        let entries = if self.by_rows { n * columns(rays) } else { 0.0 };
        let matrix = pairs * PAIR_BYTES * self.matrices as f64;
        // Rows are freed while the matrix grows, but allocators seldom return the memory.
        let bytes = PROCESS_BYTES
            + n * PATCH_BYTES
            + entries * ENTRY_BYTES
            + matrix
            + block_bytes(2.0 * pairs, n)
            + self.working_bytes(columns(0.25 * rays));
        Ok(Forecast {
            rows: self.sides.len(),
            pairs: pairs as u64,
            bytes: bytes as u64,
            seconds: None,
        })
    }

    /// Bytes of what is in progress at a time, if a replicate of a row finds this many columns.
    fn working_bytes(&self, columns: f64) -> f64 {
        let (rows, threads) = (self.sides.len(), rayon::current_num_threads());
        if !self.by_rows {
            return exchanger::working_bytes(rows, threads);
        }
        // A block of rows as their estimator returns them, and sorted by columns.
        let block = rows::rows_at_once(self.rays).min(rows) as f64;
        let columns = block * REPLICATES as f64 * columns;
        let sums = (threads * 2 * ORDERS * rows * size_of::<u32>()) as f64;
        columns * (size_of::<Entry>() + size_of::<(u32, usize, f64)>()) as f64 + sums
    }

    /// Average number of patches that a row sees: the larger of what sampled rows find, corrected
    /// for what so few rays miss, and what sampled pairs of points show.
    fn seen(&self, progress: &Progress) -> Result<f64, Cancelled> {
        progress.begin("forecast", ROWS as u64);
        let step = self.sides.len().div_ceil(ROWS);
        let rows = (0..self.sides.len()).step_by(step);
        let sides: Vec<Side> = rows.map(|i| self.sides.side(i)).collect();
        let rows = self.sampler.rows(&sides, progress)?;
        let columns: usize = rows.iter().map(columns).sum();
        let mean = columns as f64 / sides.len() as f64;
        let by_rows = target_count(mean, f64::from(self.sampler.rays()));
        Ok(by_rows.max(self.visible_share() * self.sides.len() as f64))
    }

    /// Share of all pairs of random points that see each other.
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

    /// A ray between points of two rows, if these face each other.
    fn between(&self, i: usize, j: usize, u: f64, v: f64) -> Option<KernelRay> {
        let end = |row: usize| {
            let point = self.sides.patches.sample(self.sides.patch(row), u, v);
            (point.position, self.sides.flip(row) * point.normal)
        };
        facing_ray(self.tracer, [end(i), end(j)])
    }
}

/// Number of distinct sides in a row.
fn columns(row: &Row) -> usize {
    let entries = row.entries.iter().flatten();
    let mut sides: Vec<Side> = entries.map(|e| e.side).collect();
    sides.sort_unstable();
    sides.dedup();
    sides.len()
}

/// The number of equal targets of which `rays` rays hit `hit`: the solution V of V (1 − e^(−rays/V)) = hit,
/// by bisection.
fn target_count(hit: f64, rays: f64) -> f64 {
    let (mut low, mut high) = (hit, 1e12f64.max(hit));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if middle * (1.0 - (-rays / middle).exp()) < hit {
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
            let hit = targets * (1.0 - (-rays / targets).exp());
            let count = target_count(hit, rays);
            assert!((count / targets - 1.0).abs() < 0.01, "{count} {targets}");
        }
    }
}
