//! Rows by formulas that a few rays contradict.

use super::sides::Sides;
use crate::analytic_engine::check::Strata;
use crate::analytic_engine::exchanger::{AllPairs, Exchanger};
use crate::exchange_areas::ExchangeAreas;
use crate::rays::{HitPatches, RowSampler};
use azulejo_trace::{Cancelled, Gatherer, KernelRay, Progress, REPLICATES};
use rayon::prelude::*;

/// Rays of all rows together, about, and the fewest and most of a row.
const RAYS: usize = 1 << 17;
const ROW_RAYS: [usize; 2] = [64, 4096];

/// Neighbouring rows that are also compared together.
const NEIGHBOURS: usize = 16;

/// The rows of exchange areas, and what a few rays find from them.
pub(super) struct RowCheck<'a> {
    pub sides: &'a Sides<'a>,
    pub gatherer: &'a Gatherer<'a>,
    pub exchanger: &'a Exchanger<'a>,
    pub seed: u32,
}

impl RowCheck<'_> {
    /// The rows, in order, whose direct light is not where rays find it: by themselves, together with their
    /// neighbours, or all rows together. Columns without formulas are left out, and rows that are too narrow for
    /// rays.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn doubtful(&self, pairs: &AllPairs, progress: &Progress) -> Result<Vec<usize>, Cancelled> {
        let n = self.sides.len();
        let rays = (RAYS / n.max(1)).clamp(ROW_RAYS[0], ROW_RAYS[1]) / REPLICATES * REPLICATES;
        let tracer = self.gatherer.surfaces().tracer;
        let is_compared = |row: usize| {
            self.exchanger.has(row) && pairs.is_done[row] && !self.sides.is_too_narrow(row, tracer)
        };
        // The form factors of each row, and what rays from it hit, by stratum.
        let mut strata = vec![Strata::default(); n];
        self.add_factors(&pairs.orders[0], is_compared, &mut strata);
        progress.begin("rows against rays", n as u64);
        let surfaces = self.gatherer.surfaces();
        let patches = self.sides.patches;
        let sampler = RowSampler::new(surfaces.tracer, patches, rays / REPLICATES, self.seed);
        let patches = HitPatches::new(surfaces, patches);
        let add_hits = |(row, strata): (usize, &mut Strata)| {
            progress.advance(1)?;
            if is_compared(row) {
                let hits = self.hits(row, rays, &sampler, &patches).into_iter();
                let columns = hits.filter(|&column| is_compared(column));
                for stratum in columns.filter_map(|column| self.exchanger.stratum(column)) {
                    strata.add_hits(stratum, 1.0 / rays as f64);
                }
            }
            Ok(())
        };
        strata.par_iter_mut().enumerate().try_for_each(add_hits)?;
        // All rows together, then neighbours together, then each by itself.
        let order = self.exchanger.rows_in_order();
        let order: Vec<usize> = order.into_iter().filter(|&row| is_compared(row)).collect();
        let disagree = |rows: &[usize]| {
            let rows: Vec<_> = rows.iter().map(|&row| &strata[row]).collect();
            Strata::mean(&rows).disagree(rays * rows.len())
        };
        if disagree(&order) {
            return Ok(order);
        }
        let doubtful = order.chunks(NEIGHBOURS).flat_map(|rows| {
            let is_group = disagree(rows);
            let rows = rows.iter().copied();
            rows.filter(move |&row| is_group || disagree(&[row]))
        });
        let mut doubtful: Vec<usize> = doubtful.collect();
        doubtful.sort_unstable();
        Ok(doubtful)
    }

    /// Adds the form factors of all rows between rows that are compared.
    fn add_factors(
        &self,
        exchange: &ExchangeAreas,
        is_compared: impl Fn(usize) -> bool,
        strata: &mut [Strata],
    ) {
        let mut add = |row: usize, column: usize, value: f64, error: f64| {
            if let Some(stratum) = self.exchanger.stratum(column) {
                let area = self.sides.area(row);
                strata[row].add_factor(stratum, value / area, error / area);
            }
        };
        for row in (0..self.sides.len()).filter(|&row| is_compared(row)) {
            let upper = exchange.upper(row).iter();
            for e in upper.filter(|e| is_compared(e.column as usize)) {
                let column = e.column as usize;
                add(row, column, e.value, f64::from(e.error));
                if column != row {
                    add(column, row, e.value, f64::from(e.error));
                }
            }
        }
    }

    /// The columns that rays from a row hit.
    fn hits(
        &self,
        row: usize,
        rays: usize,
        sampler: &RowSampler,
        patches: &HitPatches,
    ) -> Vec<usize> {
        let surfaces = self.gatherer.surfaces();
        let (mut paths, mut hits) = (Vec::with_capacity(rays), Vec::new());
        for replicate in 0..REPLICATES {
            let (side, stretch) = (self.sides.side(row), 0..rays / REPLICATES);
            sampler.fill(side, replicate, stretch, 1.0, &mut paths);
        }
        let rays: Vec<KernelRay> = paths.iter().map(|path| path.leg.ray).collect();
        surfaces.tracer.closest(&rays, &mut hits);
        let hit = rays.iter().zip(&hits).filter(|(_, hit)| hit.is_hit());
        hit.filter_map(|(ray, hit)| {
            let (hit, is_front) = surfaces.facing(ray, hit);
            let column = self.sides.column(patches.at(&hit), is_front)?;
            Some(column as usize)
        })
        .collect()
    }
}
