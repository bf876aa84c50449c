//! Rows by rays, handed out as they are traced, for those who do not keep them.

use super::PreparedPlan;
use super::matrix::RowRemainder;
use super::rows::{self, RowTracing};
use super::spread::mean_and_variance;
use crate::engine::EngineUsed;
use crate::estimator::Estimator;
use crate::proxy::PointNormal;
use crate::row::{Row, Side};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, Progress, REPLICATES};
use rayon::prelude::*;

/// Rows of any sides of a plan, by rays.
pub(crate) struct RowStream<'a> {
    plan: &'a PreparedPlan<'a>,
    estimator: Estimator<'a>,
    /// Share of the light on each column that ends there.
    pub ends: Vec<f64>,
}

/// One row.
pub(crate) struct StreamedRow {
    /// Column and form factor, columns ascending.
    pub entries: Vec<(u32, f32)>,
    /// Shares that reach no column.
    pub rest: RowRemainder,
    /// Share that ends on columns, and its standard error by the four replicates.
    pub ended: (f64, f64),
}

impl PreparedPlan<'_> {
    /// The centre of each row's patch and the normal of its side.
    pub fn places(&self) -> Vec<PointNormal> {
        let patches = self.sides.patches;
        let place = |row: usize| {
            let patch = self.sides.patch(row);
            let flip = self.sides.flip(row);
            PointNormal {
                position: patches.centre(patch),
                normal: flip * patches.normal(patch),
            }
        };
        (0..self.rows()).map(place).collect()
    }

    /// Area of each row, in square scene units.
    pub fn areas(&self) -> Vec<f64> {
        (0..self.rows()).map(|row| self.sides.area(row)).collect()
    }

    /// The engine of rows by rays, whatever the plan's own.
    pub(crate) fn rays_used(&self) -> EngineUsed {
        EngineUsed::new("rays", self.gatherer.surfaces().tracer.kernel_name())
    }

    /// Rays per row that are asked for.
    pub(crate) fn requested_rays(&self) -> u32 {
        self.row_rays()
    }

    /// Rows by `rays` rays each; streams of different `stream` are independent.
    pub(crate) fn row_stream(&self, rays: u32, stream: u32) -> RowStream<'_> {
        let patches = self.sides.patches;
        let seed = hash(&[self.seed, 2, stream]);
        let end = |row: usize| {
            let material = patches.material(self.sides.patch(row)) as usize;
            rows::ending(&self.materials()[material]).mean()
        };
        RowStream {
            plan: self,
            estimator: self.ray_estimator(rays, seed),
            ends: (0..self.rows()).map(end).collect(),
        }
    }
}

impl RowStream<'_> {
    /// Rays per row.
    pub fn rays(&self) -> u32 {
        self.estimator.rays()
    }

    /// Some rows, in order. Advances `progress` by one for each.
    pub fn rows(&self, rows: &[u32], progress: &Progress) -> Result<Vec<StreamedRow>, Cancelled> {
        let estimated = self.estimated(rows, progress)?;
        let tracing = RowTracing::new(self.plan, &self.estimator);
        let streamed = |(&i, row): (&u32, &Row)| {
            let sorted = tracing.ray_row(i as usize, row);
            let entries = sorted.far.iter().flatten();
            StreamedRow {
                entries: entries.map(|e| (e.column, e.mean)).collect(),
                rest: sorted.rest,
                ended: self.ended(row),
            }
        };
        Ok(rows.par_iter().zip(&estimated).map(streamed).collect())
    }

    /// X x of some rows in each replicate, for each of the vectors `x`: independent estimates without bias.
    pub fn products(
        &self,
        rows: &[u32],
        x: &[Vec<f64>],
        progress: &Progress,
    ) -> Result<Vec<Vec<[f64; REPLICATES]>>, Cancelled> {
        let estimated = self.estimated(rows, progress)?;
        let products = |row: &Row| x.iter().map(|x| self.product(row, x)).collect();
        Ok(estimated.par_iter().map(products).collect())
    }

    fn estimated(&self, rows: &[u32], progress: &Progress) -> Result<Vec<Row>, Cancelled> {
        let sides = rows.iter().map(|&i| self.plan.sides.side(i as usize));
        self.estimator.rows(&sides.collect::<Vec<Side>>(), progress)
    }

    /// Σ_j X_ij x_j of a row in each replicate.
    fn product(&self, row: &Row, x: &[f64]) -> [f64; REPLICATES] {
        let column = |side: Side| self.plan.sides.column(side / 2, side.is_multiple_of(2));
        row.entries.each_ref().map(|entries| {
            let terms = entries
                .iter()
                .filter_map(|e| Some(x[column(e.side)? as usize] * e.weight.mean()));
            terms.sum()
        })
    }

    /// The share of a row that ends on columns, and its standard error.
    fn ended(&self, row: &Row) -> (f64, f64) {
        let (mean, variance) = mean_and_variance(self.product(row, &self.ends));
        (mean, variance.sqrt())
    }
}
