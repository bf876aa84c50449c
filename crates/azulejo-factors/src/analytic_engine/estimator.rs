//! Rows for solvers: formulas where there are any, rays for the rest.

use super::exchanger::{Exchanger, ExchangerOptions, Orders};
use crate::engine::EngineUsed;
use crate::patch::Patches;
use crate::rays::RayEstimator;
use crate::row::{Columns, Entry, Order, Row, Side};
use azulejo_scene::Rgb;
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, Gatherer, Progress};
use rayon::prelude::*;

/// Computes rows by formulas. Rays supply what has no formula: curved patches, mirrors without
/// images, what leaves the scene, and emission that direct light does not count. Immutable; shared
/// by all threads.
pub struct AnalyticEstimator<'a> {
    exchanger: Exchanger<'a>,
    rays: RayEstimator<'a>,
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    columns: Columns,
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
        };
        let sides = (0..2 * patches.len() as u32).collect();
        AnalyticEstimator {
            exchanger: Exchanger::new(patches, gatherer.surfaces(), sides, options),
            rays: RayEstimator::new(gatherer, patches, rays, seed, columns),
            gatherer,
            patches,
            columns,
        }
    }

    /// Rays per row.
    pub fn rays(&self) -> u32 {
        self.rays.rays()
    }

    /// The engine and the kernel in use.
    pub fn engine_used(&self) -> EngineUsed {
        let mut notes = Vec::from_iter(self.exchanger.flatness.clone());
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
        let known = self.exchanger.rows(&rows);
        let row = |(&side, known): (&Side, &Orders)| {
            progress.advance(1)?;
            Ok(self.joined(side, known))
        };
        sides.par_iter().zip(&known).map(row).collect()
    }

    fn joined(&self, side: Side, known: &Orders) -> Row {
        let mut row = self.rays.row(side);
        let area = self.patches.area((side / 2) as usize);
        let entry = |(order, e): (usize, &crate::form_factors::Exchange)| Entry {
            side: e.column,
            order: order as Order,
            weight: Rgb::grey(e.value / area),
        };
        let by_order = known.iter().enumerate();
        let all = by_order.flat_map(|(order, row)| row.iter().map(move |e| (order, e)));
        let exact: Vec<Entry> = all.map(entry).filter(|e| self.is_column(e.side)).collect();
        let row_has = self.exchanger.has(side as usize);
        for entries in &mut row.entries {
            entries.retain(|e| {
                let is_known = row_has
                    && self.exchanger.has(e.side as usize)
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
