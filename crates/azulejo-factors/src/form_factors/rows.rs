//! Rows by rays or item buffers, sorted by what has a formula.

use super::PreparedPlan;
use super::design_effect::{self, DesignEffect, ErrorGroup};
use super::matrix::{RowRemainder, row_freedom};
use super::near::{PairEstimate, PairEstimates, formulas};
use super::sides::Sides;
use super::spread::{NoiseModel, SPREAD_FREEDOM, excess_spread, mean_and_variance};
use crate::estimator::Estimator;
use crate::row::{ORDERS, Order, Row, Side};
use azulejo_scene::brdf::Lobes;
use azulejo_scene::{Material, Rgb};
use azulejo_trace::run::{LoopSize, Record, RecordReader};
use azulejo_trace::{Cancelled, Gatherer, Progress, REPLICATES, Run, RunStage};
use rayon::prelude::*;

/// A form factor as estimated by one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RayEntry {
    pub column: u32,
    /// Mean of the replicates.
    pub mean: f32,
    /// Variance of `mean`, from the spread of the replicates.
    pub variance: f32,
}

/// Entries by column, ascending.
pub(super) type RayEntries = Vec<RayEntry>;

/// The estimates of one row.
#[derive(Debug, Default, PartialEq)]
pub(super) struct RayRow {
    /// Direct light to columns for which there is an exact estimate too.
    pub near: RayEntries,
    /// All the rest: together, or one list per order.
    pub far: Vec<RayEntries>,
    /// Shares that reach no column.
    pub rest: RowRemainder,
    /// Correlated errors of its entries, if they share viewpoints.
    pub error_groups: Vec<ErrorGroup>,
}

/// The rows of all sides.
pub(super) struct TracedRows {
    pub rows: Vec<RayRow>,
    /// Number of `far` lists per row.
    pub orders: usize,
    /// Rays or pixels of each row.
    pub rays: Vec<u32>,
    /// The noise of entries.
    pub noise: NoiseModel,
}

impl TracedRows {
    /// The design effect of sums over the entries of all rows.
    pub fn design_effect(&self, sides: &Sides) -> DesignEffect {
        let mut design_effect = DesignEffect::default();
        for (i, row) in self.rows.iter().enumerate() {
            design_effect.add(sides, i, &row.error_groups);
        }
        design_effect
    }

    /// Post-stratification (Holt and Smith, *Post stratification*, Journal of the Royal Statistical Society A 142,
    /// 1979): of each row the share that goes to columns with an exact formula is known, so that what its rays or
    /// pixels found elsewhere is scaled to what that leaves. Rows stay that contradict their formulas, as those of
    /// faces that are there twice do. For scenes in which all light ends where it arrives.
    pub fn fit_to_formulas(&mut self, sides: &Sides, exact: &[PairEstimates]) {
        let rows = self.rows.par_iter_mut().zip(&self.rays).zip(exact);
        let fit = |(i, ((row, &rays), exact)): (usize, ((&mut RayRow, &u32), &PairEstimates))| {
            row.fit_to_formulas((sides.area(i), rays), exact);
        };
        rows.enumerate().for_each(fit);
    }
}

impl RayRow {
    /// Scales the row, of a patch of this area and by this many rays, to what exact formulas leave of its light.
    fn fit_to_formulas(&mut self, (area, rays): (f64, u32), exact: &[PairEstimate]) {
        let is_exact = |column: u32| {
            let place = exact.binary_search_by_key(&column, |e| e.column);
            place.is_ok_and(|k| exact[k].is_exact())
        };
        let known: f64 = exact.iter().filter(|e| e.is_exact()).map(|e| e.value).sum();
        let known = known / area;
        let found = self.near.iter().filter(|e| is_exact(e.column));
        let (found, error) = found.fold((0.0, 0.0), |(sum, error), e| {
            let more: [f64; 2] = [e.mean, e.variance].map(f64::from);
            (sum + more[0], error + more[1].sqrt())
        });
        let others = 1.0 - found;
        let doubt = row_freedom(error, f64::from(rays));
        if exact.is_empty() || others < ROUNDING || (known - found).abs() > doubt || area <= 0.0 {
            return;
        }
        let scale = (1.0 - known).max(0.0) / others;
        let near = self.near.iter_mut().filter(|e| !is_exact(e.column));
        for entry in near.chain(self.far.iter_mut().flatten()) {
            entry.mean *= scale as f32;
            entry.variance *= (scale * scale) as f32;
        }
        self.rest = self.rest.scaled(scale);
    }
}

/// Fewest and most rows that are computed at once. A graphics card wants many in flight.
const AT_ONCE: [usize; 2] = [64, 256];

/// Their rays, within these limits.
const RAYS_AT_ONCE: usize = 1 << 20;

/// Blocks that are computed at once: fewer of them by each process where many share the rows.
const BLOCKS_AT_ONCE: usize = 8;

/// Rows that are computed at once.
pub(super) fn rows_at_once(rays: u32) -> usize {
    (RAYS_AT_ONCE / rays.max(1) as usize).clamp(AT_ONCE[0], AT_ONCE[1])
}

/// How rows are estimated.
pub(super) struct RowTracing<'a> {
    pub sides: &'a Sides<'a>,
    pub gatherer: &'a Gatherer<'a>,
    /// For each row the columns that also have a formula; empty where none has.
    pub exact: &'a [PairEstimates],
    pub estimator: &'a Estimator<'a>,
    /// Whether orders are kept separately.
    pub separate: bool,
    /// How many rows estimate each entry: both of a pair, or one by itself.
    pub estimates: f64,
    /// Row, column and order of what is known by formula, and not kept.
    pub is_known: &'a (dyn Fn(usize, u32, Order) -> bool + Sync),
}

impl<'a> RowTracing<'a> {
    /// Rows of a plan without formulas, and without separate orders.
    pub fn new(plan: &'a PreparedPlan<'a>, estimator: &'a Estimator<'a>) -> RowTracing<'a> {
        RowTracing {
            sides: &plan.sides,
            gatherer: &plan.gatherer,
            exact: &[],
            estimator,
            separate: false,
            estimates: 2.0,
            is_known: &|_, _, _| false,
        }
    }

    /// All rows, except blocks that are stored; `None` if others make the result.
    pub fn trace(&self, run: Run) -> Result<Option<TracedRows>, Cancelled> {
        let rays = self.estimator.rays();
        // Blocks must not depend on the machine, which may be another after an interruption.
        let size = LoopSize {
            items: self.sides.len(),
            block: rows_at_once(rays) / BLOCKS_AT_ONCE,
            at_once: rows_at_once(rays),
        };
        run.progress.begin("form factors", self.steps(size, run));
        let rows = run.resumed(RunStage::Rows, size, |rows| self.block(rows, run.progress))?;
        Ok(rows.map(|rows| TracedRows {
            rows,
            orders: self.orders(),
            rays: (0..size.items).map(|row| self.rays_of(row)).collect(),
            noise: self.noise(),
        }))
    }

    /// Steps of progress of the rows of this process, about.
    fn steps(&self, size: LoopSize, run: Run) -> u64 {
        let own = run.own_items(size.items) as u64;
        let rows = 0..size.items;
        let steps = rows.map(|row| self.estimator.steps(self.sides.side(row)));
        steps.sum::<u64>() * own / (size.items as u64).max(1)
    }

    /// Rays or pixels of a row.
    fn rays_of(&self, row: usize) -> u32 {
        self.estimator.rays_of(self.sides.side(row))
    }

    /// The value of a single hit in a row.
    pub fn hit(&self, row: usize) -> f64 {
        1.0 / f64::from(self.rays_of(row).max(1))
    }

    /// Some rows.
    pub fn block(&self, rows: &[usize], progress: &Progress) -> Result<Vec<RayRow>, Cancelled> {
        let sides: Vec<Side> = rows.iter().map(|&i| self.sides.side(i)).collect();
        let estimated = self.estimator.rows(&sides, progress)?;
        let rows = rows.par_iter().zip(&estimated);
        Ok(rows.map(|(&i, row)| self.ray_row(i, row)).collect())
    }

    pub fn noise(&self) -> NoiseModel {
        if !self.estimator.knows_its_spread() {
            NoiseModel::NoSpread
        } else if self.estimator.shares_viewpoints() {
            NoiseModel::Unknown
        } else {
            NoiseModel::Hits
        }
    }

    fn orders(&self) -> usize {
        if self.separate { ORDERS } else { 1 }
    }

    /// Sorts the estimates of row `i` by whether there is a formula for them.
    pub fn ray_row(&self, i: usize, row: &Row) -> RayRow {
        let materials = &self.gatherer.surfaces().scene.materials;
        let exact = formulas(self.exact, i);
        // Entries with a formula, and the others; light on sides without a column is hidden.
        let mut near = Vec::new();
        let mut far = vec![Vec::new(); self.orders()];
        let (mut hidden, mut ended) = ([0.0; REPLICATES], 0.0);
        for (replicate, entries) in row.entries.iter().enumerate() {
            for entry in entries {
                let patch = entry.side / 2;
                let material = &materials[self.sides.patches.material(patch as usize) as usize];
                let ends = (entry.weight * ending(material)).mean();
                let Some(column) = self.sides.column(patch, entry.side.is_multiple_of(2)) else {
                    hidden[replicate] += ends;
                    continue;
                };
                ended += ends / REPLICATES as f64;
                if (self.is_known)(i, column, entry.order) {
                    continue;
                }
                let has_formula =
                    |order| order == 0 && exact.binary_search_by_key(&column, |e| e.column).is_ok();
                let list = match entry.order {
                    order if has_formula(order) => &mut near,
                    order if self.separate => &mut far[usize::from(order)],
                    _ => &mut far[0],
                };
                list.push((column, replicate, entry.weight.mean()));
            }
        }
        let near = columns(near);
        let far: Vec<Vec<Column>> = far.into_iter().map(columns).collect();
        let excess = self.excess(i, row);
        let lists = far.iter().chain([&near]);
        let error_groups = lists.flat_map(|columns| design_effect::groups(columns, self.sides));
        // Rays start at independent points: their errors are not correlated.
        let is_correlated = self.estimator.shares_viewpoints() && self.estimator.knows_its_spread();
        let error_groups = error_groups.filter(|_| is_correlated);
        let far = far.iter().zip(&excess);
        let far = far.map(|(columns, excess)| self.far_entries(i, columns, excess));
        RayRow {
            error_groups: error_groups.collect(),
            near: near.iter().map(entry).collect(),
            far: far.collect(),
            rest: rest(row, (self.noise(), self.hit(i)), hidden, ended),
        }
    }

    /// By how much the squares of what single rays bring exceed those of hits, by column, for each list of
    /// entries without a formula.
    fn excess(&self, i: usize, row: &Row) -> Vec<Vec<(u32, f64)>> {
        let exact = formulas(self.exact, i);
        let mut lists = vec![Vec::new(); self.orders()];
        for entry in row.excess.iter().flatten() {
            let Some(column) = self.sides.column(entry.side / 2, entry.side % 2 == 0) else {
                continue;
            };
            let has_formula =
                entry.order == 0 && exact.binary_search_by_key(&column, |e| e.column).is_ok();
            if !has_formula && !(self.is_known)(i, column, entry.order) {
                let order = usize::from(entry.order).min(lists.len() - 1);
                let share = (REPLICATES as f64).powi(-2);
                lists[order].push((column, entry.weight.mean() * share));
            }
        }
        for list in &mut lists {
            list.sort_by_key(|&(column, _)| column);
        }
        lists
    }

    /// Entries with their variances, where single rays may bring more than a hit.
    fn far_entries(&self, i: usize, columns: &[Column], excess: &[(u32, f64)]) -> RayEntries {
        let freedom = self.estimates * SPREAD_FREEDOM;
        let mut excess = excess.chunk_by(|a, b| a.0 == b.0).peekable();
        let far = |column: &Column| {
            let plain = entry(column);
            // Columns are ascending in both lists.
            while excess.next_if(|e| e[0].0 < column.0).is_some() {}
            let Some(own) = excess.next_if(|e| e[0].0 == column.0) else {
                return plain;
            };
            let own = own.iter().map(|(_, excess)| excess).sum();
            let more = excess_spread(plain.mean.into(), self.hit(i), own, freedom);
            RayEntry {
                variance: (f64::from(plain.variance) + more) as f32,
                ..plain
            }
        };
        columns.iter().map(far).collect()
    }
}

/// Shares of a row that reach no column. What the colour of glass absorbs is what the other shares
/// lack.
fn rest(
    row: &Row,
    (noise, hit): (NoiseModel, f64),
    hidden: [f64; REPLICATES],
    ended: f64,
) -> RowRemainder {
    let share = |replicates| {
        let (share, spread) = mean_and_variance(replicates);
        (share, noise.error(share, spread, hit))
    };
    let [(sky, sky_error), (ground, ground_error)] =
        [0, 1].map(|way| share(row.escaped.map(|e| e[way].mean())));
    let (hidden, hidden_error) = share(hidden);
    let cut = row.cut.mean();
    let lost = 1.0 - ended - hidden - cut - sky - ground;
    RowRemainder {
        sky,
        sky_error,
        ground,
        ground_error,
        hidden,
        hidden_error,
        cut,
        lost: if lost > ROUNDING { lost } else { 0.0 },
    }
}

/// Below this, a share is missing only by rounding.
const ROUNDING: f64 = 1e-9;

/// Share of the light on a surface that ends there. Glass absorbs only by its colour, which is
/// counted as lost; glossy reflection is taken at its mean albedo.
pub(super) fn ending(material: &Material) -> Rgb {
    if material.dielectric.is_some() {
        return Rgb::BLACK;
    }
    let glossy = material.glossy().map(Lobes::mean_albedo);
    Rgb::WHITE - material.mirror - glossy.unwrap_or(Rgb::BLACK)
}

/// A column, with the estimate of each replicate.
pub(super) type Column = (u32, [f64; REPLICATES]);

/// The estimates of replicates, by column.
fn columns(mut hits: Vec<(u32, usize, f64)>) -> Vec<Column> {
    hits.sort_by_key(|&(column, ..)| column);
    let column = |group: &[(u32, usize, f64)]| {
        let mut values = [0.0; REPLICATES];
        group.iter().for_each(|&(_, r, w)| values[r] += w);
        (group[0].0, values)
    };
    hits.chunk_by(|a, b| a.0 == b.0).map(column).collect()
}

fn entry(&(column, values): &Column) -> RayEntry {
    let (mean, variance) = mean_and_variance(values);
    RayEntry {
        column,
        mean: mean as f32,
        variance: variance as f32,
    }
}

impl Record for RayRow {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.near.write(bytes);
        self.far.write(bytes);
        self.rest.to_array().write(bytes);
        self.error_groups.write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<RayRow> {
        Some(RayRow {
            near: Record::read(bytes)?,
            far: Record::read(bytes)?,
            rest: RowRemainder::from_array(Record::read(bytes)?),
            error_groups: Record::read(bytes)?,
        })
    }
}

impl Record for RayEntry {
    fn write(&self, bytes: &mut Vec<u8>) {
        (self.column, (self.mean, self.variance)).write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<RayEntry> {
        let (column, (mean, variance)) = Record::read(bytes)?;
        Some(RayEntry {
            column,
            mean,
            variance,
        })
    }
}
