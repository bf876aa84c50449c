//! He and Torrance's series, tabulated: its logarithm, interpolated.

use super::series;
use crate::brdf::quadrature::lagrange;

/// Nodes per unit of the square root of √g.
const PER_ROOT: f64 = 57.0;

/// Nodes per unit of √x/(1 + √g).
const PER_OFFSET: f64 = 40.0;

/// The largest √x/(1 + √g) in the table. Farther out next to nothing is reflected.
const MOST_OFFSET: f64 = 8.0;

/// The largest √g in the table. Where it is larger, few rays hit so rough a surface so steeply.
const MOST_ROOT: f64 = 80.0;

/// Distance of the nodes at which the series is summed, in nodes of the table. The others are interpolated between
/// them, by a polynomial through more nodes than would be quick enough for every evaluation.
const STRIDE: usize = 3;

/// Nodes of that polynomial.
const COARSE: usize = 8;

/// Nodes beside those between which a value lies.
const BORDER: usize = 2;

/// Σ gᵐ e⁻ᵍ/(m·m!) exp(−x/m) by interpolation, for √g up to that of one surface.
///
/// The coordinates √√g and √x/(1 + √g) make features as wide for small g, where the series is a
/// few Gaussians, as for large g, where it is one of a slope in proportion to 1/√g.
#[derive(Debug)]
pub(super) struct SeriesTable {
    /// Logarithms of the sum times (1 + g)²/g, row by row.
    values: Vec<f64>,
    rows: usize,
    columns: usize,
}

impl SeriesTable {
    /// For √g up to `most_root` and √x up to `most_offset`.
    pub fn new(most_root: f64, most_offset: f64) -> SeriesTable {
        let count = |most: f64| most.ceil() as usize + 2 * BORDER;
        let rows = count(most_root.min(MOST_ROOT).sqrt() * PER_ROOT);
        let columns = count(most_offset.min(MOST_OFFSET) * PER_OFFSET);
        // The function is even in both coordinates, so that nodes below zero mirror others.
        let coarse = |row: usize| {
            let root = (coarse_place(row) / PER_ROOT).powi(2).max(1e-8);
            let g = root * root;
            let log = |column: usize| {
                let offset = coarse_place(column) / PER_OFFSET * (1.0 + root);
                let sum = series::sum(g, offset * offset) * (1.0 + g).powi(2) / g;
                sum.max(f64::MIN_POSITIVE).ln()
            };
            let logs: Vec<f64> = (0..coarse_count(columns)).map(log).collect();
            let fine = |column: usize| {
                let (first, weights) = coarse_weights(column);
                logs[first..].iter().zip(weights).map(|(v, w)| v * w).sum()
            };
            (0..columns).map(fine).collect()
        };
        let coarse: Vec<Vec<f64>> = (0..coarse_count(rows)).map(coarse).collect();
        let mut values = vec![0.0; rows * columns];
        for (row, line) in values.chunks_exact_mut(columns).enumerate() {
            let (first, weights) = coarse_weights(row);
            for (logs, weight) in coarse[first..].iter().zip(weights) {
                line.iter_mut()
                    .zip(logs)
                    .for_each(|(v, log)| *v += weight * log);
            }
        }
        SeriesTable {
            values,
            rows,
            columns,
        }
    }

    /// The sum for √g = `root` and √x = `offset`.
    pub fn sum(&self, root: f64, offset: f64) -> f64 {
        let g = root * root;
        let (row, s) = split(root.sqrt() * PER_ROOT);
        let (column, t) = split(offset / (1.0 + root) * PER_OFFSET);
        if row + 2 * BORDER > self.rows || column + 2 * BORDER > self.columns {
            return series::sum(g, offset * offset);
        }
        let (down, across) = (lagrange::<4>(s + 1.0), lagrange::<4>(t + 1.0));
        let mut log = 0.0;
        for (k, weight) in down.iter().enumerate() {
            let start = (row + k) * self.columns + column;
            let line = &self.values[start..start + 4];
            let sum: f64 = line.iter().zip(across).map(|(v, w)| v * w).sum();
            log += weight * sum;
        }
        log.exp() * g / (1.0 + g).powi(2)
    }
}

/// Coordinate of a coarse node, in steps of the table.
fn coarse_place(node: usize) -> f64 {
    (node * STRIDE) as f64 - (COARSE / 2 * STRIDE) as f64
}

/// Number of coarse nodes around some of the table.
fn coarse_count(nodes: usize) -> usize {
    nodes / STRIDE + COARSE + 1
}

/// The first of the coarse nodes around a node of the table, whose own coordinate is one less, and their weights.
fn coarse_weights(node: usize) -> (usize, [f64; COARSE]) {
    let at = (node as f64 - 1.0) / STRIDE as f64 + 1.0;
    let first = at as usize;
    (first, lagrange(at - first as f64 + (COARSE / 2 - 1) as f64))
}

/// The first of the four nodes around a coordinate, and where between the middle two it lies.
fn split(at: f64) -> (usize, f64) {
    let floor = at.floor();
    (floor as usize, at - floor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::quadrature::midpoints;

    #[test]
    fn interpolation_is_close_where_light_is_reflected() {
        for most in [0.3, 3.0, 12.0, 54.0] {
            let table = SeriesTable::new(most, 200.0);
            for root in midpoints(301).map(|u| most * u) {
                let peak = series::sum(root * root, 0.0);
                for offset in midpoints(301).map(|u| 8.0 * (1.0 + root) * u) {
                    let exact = series::sum(root * root, offset * offset);
                    let error = (table.sum(root, offset) - exact).abs() / peak;
                    assert!(error < 2e-6, "√g {root}, √x {offset}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn beyond_the_table_is_the_series() {
        let table = SeriesTable::new(1.0, 2.0);
        for (root, offset) in [(3.0, 0.5), (0.5, 40.0), (1e3, 1e3), (0.0, 0.0)] {
            let exact = series::sum(root * root, offset * offset);
            assert_eq!(table.sum(root, offset), exact);
        }
    }
}
