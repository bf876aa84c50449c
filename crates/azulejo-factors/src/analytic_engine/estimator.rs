//! Rows for solvers: formulas where there are any, rays for the rest.

use super::check::Strata;
use super::exchanger::{Exchanger, ExchangerOptions, Orders};
use crate::engine::EngineUsed;
use crate::patch::Patches;
use crate::rays::RayEstimator;
use crate::row::{Columns, Entry, Order, Row, Side};
use azulejo_scene::Rgb;
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, Gatherer, Progress, REPLICATES};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Computes rows by formulas. Rays supply what has no formula: curved patches, mirrors without
/// images, what leaves the scene, and emission that direct light does not count. Immutable; shared
/// by all threads.
pub struct AnalyticEstimator<'a> {
    exchanger: Exchanger<'a>,
    rays: RayEstimator<'a>,
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    columns: Columns,
    /// Rows that were left to rays because these contradict formulas.
    doubtful: AtomicUsize,
}

impl<'a> AnalyticEstimator<'a> {
    /// An estimator that traces `rays` per row for what has no formula.
    pub fn new(
        gatherer: &'a Gatherer<'a>,
        patches: &'a Patches,
        rays: u32,
        seed: u32,
        columns: Columns,
    ) -> AnalyticEstimator<'a> {
        let options = ExchangerOptions {
            accuracy: None,
            is_per_channel: true,
            seed: hash(&[seed, 2]),
            row_budget: f64::INFINITY,
        };
        let sides = (0..2 * patches.len() as u32).collect();
        AnalyticEstimator {
            exchanger: Exchanger::new(patches, gatherer.surfaces(), sides, options),
            rays: RayEstimator::new(gatherer, patches, rays, seed, columns),
            gatherer,
            patches,
            columns,
            doubtful: AtomicUsize::new(0),
        }
    }

    /// Rays per row.
    pub fn rays(&self) -> u32 {
        self.rays.rays()
    }

    /// The engine and the kernel in use.
    pub fn engine_used(&self) -> EngineUsed {
        let mut notes = Vec::from_iter(self.exchanger.flatness.clone());
        let doubtful = self.doubtful.load(Ordering::Relaxed);
        if doubtful > 0 {
            notes.push(format!(
                "{doubtful} rows took rays, which contradict their formulas"
            ));
        }
        if !self.exchanger.is_complete() {
            notes.push("curved surfaces, glass and long chains of mirrors take rays".to_owned());
        }
        EngineUsed {
            name: "analytic".to_owned(),
            device: self.rays.kernel_name(),
            notes,
        }
    }

    /// The rows of some sides, in their order.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn rows(&self, sides: &[Side], progress: &Progress) -> Result<Vec<Row>, Cancelled> {
        let rows: Vec<usize> = sides.iter().map(|&side| side as usize).collect();
        let known = self.exchanger.rows(&rows, progress)?;
        let row = |(&side, known): (&Side, &Option<Orders>)| {
            // Rows without a formula were not counted.
            progress.advance(u64::from(!self.exchanger.has(side as usize)))?;
            let row = self.rays.row(side);
            Ok(match known {
                Some(known) if self.agree(&row, side, known) => self.joined(row, side, known),
                Some(_) => {
                    self.doubtful.fetch_add(1, Ordering::Relaxed);
                    row
                }
                None => row,
            })
        };
        sides.par_iter().zip(&known).map(row).collect()
    }

    /// Whether the rays of a row do not contradict the formulas.
    fn agree(&self, row: &Row, side: Side, known: &Orders) -> bool {
        let area = self.patches.area((side / 2) as usize);
        let mut strata = Strata::default();
        for e in known[0].iter().filter(|e| self.is_column(e.column)) {
            if let Some(stratum) = self.exchanger.stratum(e.column as usize) {
                strata.add_factor(stratum, e.value / area, f64::from(e.error) / area);
            }
        }
        let direct = row.entries.iter().flatten().filter(|e| e.order == 0);
        for e in direct {
            if let Some(stratum) = self.exchanger.stratum(e.side as usize) {
                strata.add_hits(stratum, e.weight.mean() / REPLICATES as f64);
            }
        }
        !strata.disagree(row.rays as usize)
    }

    /// A row by rays, with formulas instead of what they know.
    fn joined(&self, mut row: Row, side: Side, known: &Orders) -> Row {
        let area = self.patches.area((side / 2) as usize);
        let entry = |(order, e): (usize, &crate::exchange_areas::Exchange)| Entry {
            side: e.column,
            order: order as Order,
            weight: Rgb::grey(e.value / area),
        };
        let by_order = known.iter().enumerate();
        let all = by_order.flat_map(|(order, row)| row.iter().map(move |e| (order, e)));
        let exact: Vec<Entry> = all.map(entry).filter(|e| self.is_column(e.side)).collect();
        for entries in &mut row.entries {
            entries.retain(|e| {
                let is_known = self.exchanger.has(e.side as usize)
                    && self.exchanger.known[usize::from(e.order)];
                !is_known
            });
            entries.extend(&exact);
            entries.sort_unstable_by_key(|e| (e.side, e.order));
        }
        row
    }

    fn is_column(&self, side: Side) -> bool {
        let material = self.patches.material((side / 2) as usize);
        let materials = &self.gatherer.surfaces().scene.materials;
        self.columns == Columns::All || !materials[material as usize].diffuse.is_black()
    }
}
