//! One exchange area per pair, from the rays of both sides and the formula.

use super::matrix::FormFactors;
use super::near::{PairEstimate, PairEstimates, formulas};
use super::rows::{RayEntries, RayEntry, RayRow, TracedRows};
use super::sides::Sides;
use super::spread::NoiseModel;
use crate::exchange_areas::{Exchange, ExchangeAreas, union};
use azulejo_trace::{Cancelled, Progress};
use rayon::prelude::*;
use std::ops::Range;

/// Number of blocks in which rows are merged: finding the start of a block in each row has to stay
/// cheap, and a block has to fit in memory besides the rest.
const BLOCKS: usize = 128;

/// Merges all pairs.
pub(super) fn merge(
    sides: &Sides,
    mut traced: TracedRows,
    exact: &[PairEstimates],
    progress: &Progress,
) -> Result<FormFactors, Cancelled> {
    let n = sides.len();
    let areas: Vec<f64> = (0..n).map(|i| sides.area(i)).collect();
    let weights = areas.iter().zip(&traced.rays).map(PairWeight::new);
    let weights: Vec<PairWeight> = weights.collect();
    let mut factors = FormFactors {
        rest: traced.rows.iter().map(|r| r.rest).collect(),
        rays: traced.rays.iter().map(|&rays| u64::from(rays)).sum(),
        design_effect: traced.design_effect(sides),
        ..FormFactors::default()
    };
    let size = n.div_ceil(BLOCKS).max(16);
    let blocks: Vec<Range<usize>> = (0..n).step_by(size).map(|i| i..(i + size).min(n)).collect();
    let mut orders = vec![ExchangeAreas::new(); traced.orders];
    progress.begin("merging", n as u64);
    for wave in blocks.chunks(2 * rayon::current_num_threads().max(1)) {
        progress.advance((wave.len() * size) as u64)?;
        let merger = Merger {
            traced: &traced,
            exact,
            weights: &weights,
        };
        let merged: Vec<Vec<Vec<Vec<PairEstimate>>>> =
            wave.par_iter().map(|b| merger.block(b.clone())).collect();
        for row in merged.iter().flatten() {
            let orders = orders.iter_mut().zip(row);
            orders.for_each(|(areas, row)| areas.push_row(row.iter().map(Exchange::from)));
        }
        // These rows are not needed again, and the matrix needs the memory.
        for rows in wave {
            traced.rows[rows.clone()].fill_with(RayRow::default);
        }
    }
    if orders.len() == 1 {
        factors.exchange = orders.remove(0);
    } else {
        factors.exchange = ExchangeAreas::sum_of(&orders);
        factors.orders = orders;
    }
    if traced.noise == NoiseModel::Hits {
        factors.unseen = unseen(&factors.exchange, &areas, &weights);
    }
    Ok(factors)
}

/// The share of each row that no ray found: the expected sum of the pairs that a single ray found.
///
/// With N rays per row, the rays that find a pair, from either side, are a Poisson number of mean
/// λ = N (X_ij + X_ji). The expectation of what is estimated by a single ray, λ e^−λ times the value
/// of one hit, is X_ij e^−λ, that of what is missed.
fn unseen(exchange: &ExchangeAreas, areas: &[f64], weights: &[PairWeight]) -> Vec<f64> {
    let singles = exchange.sums(|i, e| {
        let hit = weights[i].hit(weights[e.column as usize]);
        // Formulas may find as little, but with a small error.
        let is_single = e.value < 1.5 * hit && f64::from(e.error) > 0.5 * e.value;
        [if is_single { e.value } else { 0.0 }; 2]
    });
    let share = |(&sum, &area): (&f64, &f64)| if area > 0.0 { sum / area } else { 0.0 };
    singles.iter().zip(areas).map(share).collect()
}

impl From<&PairEstimate> for Exchange {
    fn from(e: &PairEstimate) -> Exchange {
        Exchange {
            column: e.column,
            value: e.value,
            error: e.error as f32,
        }
    }
}

/// How much the estimate of a row counts in its pairs.
///
/// The variance of A_i X_ij by N_i rays is proportional to A_i / N_i. Weighted by its inverse, S = (N_i X_ij +
/// N_j X_ji) / (N_i / A_i + N_j / A_j).
#[derive(Clone, Copy)]
struct PairWeight {
    /// N_i: rays, or pixels.
    rays: f64,
    /// N_i / A_i.
    density: f64,
}

impl PairWeight {
    fn new((&area, &rays): (&f64, &u32)) -> PairWeight {
        let rays = f64::from(rays.max(1));
        let density = rays / area;
        PairWeight { rays, density }
    }

    /// The exchange area of a pair by a single hit, from either side.
    fn hit(self, other: PairWeight) -> f64 {
        1.0 / (self.density + other.density)
    }
}

struct Merger<'a> {
    traced: &'a TracedRows,
    exact: &'a [PairEstimates],
    weights: &'a [PairWeight],
}

impl Merger<'_> {
    /// The merged rows of a block, from the diagonal on, order by order.
    fn block(&self, rows: Range<usize>) -> Vec<Vec<Vec<PairEstimate>>> {
        let near = transposed(&self.traced.rows, |r| &r.near, rows.clone());
        let far: Vec<Vec<RayEntries>> = (0..self.traced.orders)
            .map(|order| transposed(&self.traced.rows, |r| &r.far[order], rows.clone()))
            .collect();
        let row = |(k, i): (usize, usize)| {
            let own = &self.traced.rows[i];
            let known = upper(i, formulas(self.exact, i), |e| e.column);
            let direct = better(known, &self.rays(i, &own.near, &near[k]));
            let orders = own.far.iter().zip(&far).enumerate();
            let order = |(order, (own, others)): (usize, (&RayEntries, &Vec<RayEntries>))| {
                let direct = if order == 0 { &direct[..] } else { &[] };
                sum(&self.rays(i, own, &others[k]), direct)
            };
            orders.map(order).collect()
        };
        rows.enumerate().map(row).collect()
    }

    /// Row `i` from the diagonal on, from its own rays and, transposed, those of the others.
    fn rays(&self, i: usize, own: &[RayEntry], others: &[RayEntry]) -> Vec<PairEstimate> {
        let mut merged = Vec::with_capacity(own.len().max(others.len()));
        let key = |e: &RayEntry| e.column;
        union(upper(i, own, key), others, key, key, |column, a, b| {
            let parts =
                [a, b].map(|e| e.map_or((0.0, 0.0), |e| (e.mean.into(), e.variance.into())));
            let (value, variance) = self.pair(i, column as usize, parts);
            merged.push(PairEstimate {
                column,
                value,
                error: variance.sqrt(),
            });
        });
        merged
    }

    /// Exchange area and variance of a pair from the form factors and variances that its two sides
    /// found, each with its [weight](PairWeight). Symmetric in every bit.
    fn pair(
        &self,
        i: usize,
        j: usize,
        [(x_ij, v_ij), (x_ji, v_ji)]: [(f64, f64); 2],
    ) -> (f64, f64) {
        let (a, b) = (self.weights[i], self.weights[j]);
        let (noise, hit) = (self.traced.noise, a.hit(b));
        let value = hit * (a.rays * x_ij + b.rays * x_ji);
        let [spread_i, spread_j] =
            [(a, v_ij), (b, v_ji)].map(|(weight, v)| (hit * weight.rays).powi(2) * v);
        let spread = spread_i + spread_j;
        // The two estimates of a patch's view of itself are the same one.
        let (twins, spreads) = if i == j {
            (2.0, [spread_i, 0.0])
        } else {
            (1.0, [spread_i, spread_j])
        };
        let freedom = noise.freedom(spreads);
        let variance = noise.posterior_variance(value, spread * twins, freedom, hit * twins, 1.0);
        (value, variance)
    }
}

/// The entries of row `i` from the diagonal on.
fn upper<E>(i: usize, row: &[E], column: impl Fn(&E) -> u32) -> &[E] {
    &row[row.partition_point(|e| (column(e) as usize) < i)..]
}

/// The entries of all rows in the columns `block` on or below the diagonal, by column.
fn transposed(
    rows: &[RayRow],
    part: impl Fn(&RayRow) -> &RayEntries,
    block: Range<usize>,
) -> Vec<RayEntries> {
    let mut columns = vec![RayEntries::new(); block.len()];
    for (j, row) in rows.iter().enumerate().skip(block.start) {
        let entries = part(row);
        let first = entries.partition_point(|e| (e.column as usize) < block.start);
        let is_inside = |e: &&RayEntry| (e.column as usize) < block.end.min(j + 1);
        for e in entries[first..].iter().take_while(is_inside) {
            columns[e.column as usize - block.start].push(RayEntry {
                column: j as u32,
                ..*e
            });
        }
    }
    columns
}

/// For each column with a formula, the estimate with the smaller error of formula and rays.
pub(super) fn better(exact: &[PairEstimate], rays: &[PairEstimate]) -> Vec<PairEstimate> {
    let mut chosen = Vec::with_capacity(exact.len());
    let column = |e: &PairEstimate| e.column;
    union(exact, rays, column, column, |_, e, r| {
        chosen.extend(match (e, r) {
            (Some(e), Some(r)) if r.error < e.error => Some(*r),
            (Some(e), _) => Some(*e),
            (None, r) => r.copied(),
        });
    });
    chosen
}

/// The sum of two rows of independent estimates, without zeros.
pub(super) fn sum(a: &[PairEstimate], b: &[PairEstimate]) -> Vec<PairEstimate> {
    let mut row = Vec::with_capacity(a.len() + b.len());
    let key = |e: &PairEstimate| e.column;
    union(a, b, key, key, |column, a, b| {
        let parts = |f: fn(&PairEstimate) -> f64| [a, b].map(|e| e.map_or(0.0, f));
        let ([v, w], [s, t]) = (parts(|e| e.value), parts(|e| e.error));
        if v + w > 0.0 {
            row.push(PairEstimate {
                column,
                value: v + w,
                error: s.hypot(t),
            });
        }
    });
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_without_area_miss_nothing() {
        let exchange = ExchangeAreas::from_rows(vec![Box::default(); 2]);
        let areas = [1.0, 0.0];
        let weights = areas.map(|area| PairWeight::new((&area, &64)));
        assert_eq!(unseen(&exchange, &areas, &weights), [0.0, 0.0]);
    }
}
