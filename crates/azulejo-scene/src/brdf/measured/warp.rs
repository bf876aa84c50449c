//! Functions tabulated on the unit square, and densities of them that can be sampled.

use crate::content_bytes::{ContentBytes, ContentSink, content_of_fields};

/// Tables of the same size, each linear between its nodes, which lie on the edges too.
#[derive(Clone, PartialEq)]
pub(super) struct Tables {
    width: usize,
    height: usize,
    /// Row by row, table by table.
    values: Vec<f32>,
}

/// Four tables with weights whose sum is 1.
pub(super) type Mix = [(usize, f64); 4];

/// The tables around a pair of parameters whose nodes are given; the second runs fastest.
/// Parameters beyond the last nodes count as those.
pub(super) fn mix(nodes: [&[f32]; 2], at: [f64; 2]) -> Mix {
    let (i, s) = between(nodes[0], at[0]);
    let (j, t) = between(nodes[1], at[1]);
    let below = |k: usize, n: &[f32]| (k + 1).min(n.len() - 1);
    let index = |i: usize, j: usize| i * nodes[1].len() + j;
    let (i1, j1) = (below(i, nodes[0]), below(j, nodes[1]));
    [
        (index(i, j), (1.0 - s) * (1.0 - t)),
        (index(i, j1), (1.0 - s) * t),
        (index(i1, j), s * (1.0 - t)),
        (index(i1, j1), s * t),
    ]
}

/// The weighted sum of a value of four tables.
fn mixed(mix: &Mix, value: impl Fn(usize) -> f64) -> f64 {
    mix.iter()
        .map(|&(table, weight)| weight * value(table))
        .sum()
}

/// The last node at or before `x` that has a next one, and how far `x` is towards that.
fn between(nodes: &[f32], x: f64) -> (usize, f64) {
    if nodes.len() < 2 {
        return (0, 0.0);
    }
    let after = nodes.partition_point(|node| f64::from(*node) <= x);
    let k = after.saturating_sub(1).min(nodes.len() - 2);
    let (a, b) = (f64::from(nodes[k]), f64::from(nodes[k + 1]));
    (k, ((x - a) / (b - a)).clamp(0.0, 1.0))
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

// All else of a warp is derived from its tables.
content_of_fields! {
    Tables { width, height, values }
    Warp { tables; in_row, below }
}

impl Tables {
    /// `None` unless the size is at least 2 × 2 and fills the values exactly.
    pub fn new(width: usize, height: usize, values: Vec<f32>) -> Option<Tables> {
        let size = width.checked_mul(height)?;
        let fits = width >= 2 && height >= 2 && values.len().is_multiple_of(size);
        (fits && !values.is_empty()).then_some(Tables {
            width,
            height,
            values,
        })
    }

    /// How many tables there are.
    pub fn count(&self) -> usize {
        self.values.len() / (self.width * self.height)
    }

    fn node(&self, mix: &Mix, x: usize, y: usize) -> f64 {
        let size = self.width * self.height;
        let at = |table: usize| f64::from(self.values[table * size + y * self.width + x]);
        mixed(mix, at)
    }

    /// The cell of a position, and the position within it.
    fn cell(&self, [x, y]: [f64; 2]) -> ([usize; 2], [f64; 2]) {
        let split = |x: f64, nodes: usize| {
            let x = x.clamp(0.0, 1.0) * (nodes - 1) as f64;
            let cell = (x as usize).min(nodes - 2);
            (cell, x - cell as f64)
        };
        let ((i, s), (j, t)) = (split(x, self.width), split(y, self.height));
        ([i, j], [s, t])
    }

    /// Values at the left and the right side of a cell, `t` of the way up.
    fn sides(&self, mix: &Mix, [i, j]: [usize; 2], t: f64) -> [f64; 2] {
        let side = |x| lerp(self.node(mix, x, j), self.node(mix, x, j + 1), t);
        [side(i), side(i + 1)]
    }

    /// The value at a position in the unit square.
    pub fn at(&self, mix: &Mix, place: [f64; 2]) -> f64 {
        let (cell, [s, t]) = self.cell(place);
        let [left, right] = self.sides(mix, cell, t);
        lerp(left, right, s)
    }
}

/// Densities on the unit square in proportion to tables. Rows are chosen first, then the
/// position in them. After the marginal-conditional warps of Dupuy and Jakob, *An adaptive parameterization
/// for efficient material acquisition and rendering*, SIGGRAPH Asia 2018.
#[derive(Clone, PartialEq)]
pub(super) struct Warp {
    tables: Tables,
    /// Cumulative integral before each node of a row, in units of cells.
    in_row: Vec<f64>,
    /// Cumulative integral below each row.
    below: Vec<f64>,
}

impl Warp {
    /// Scales each table to an integral of 1; where it is 0, the density is uniform.
    pub fn new(mut tables: Tables) -> Warp {
        let (w, h) = (tables.width, tables.height);
        let (mut in_row, mut below) = (Vec::new(), Vec::new());
        for table in tables.values.chunks_exact_mut(w * h) {
            normalize(table, w);
            let rows = in_row.len();
            for row in table.chunks_exact(w) {
                cumulate(row.iter().map(|v| f64::from(*v)), &mut in_row);
            }
            let whole_rows = in_row[rows..].chunks_exact(w).map(|row| row[w - 1]);
            cumulate(whole_rows, &mut below);
        }
        Warp {
            tables,
            in_row,
            below,
        }
    }

    fn below(&self, mix: &Mix, row: usize) -> f64 {
        let at = |table: usize| self.below[table * self.tables.height + row];
        mixed(mix, at)
    }

    fn in_row(&self, mix: &Mix, column: usize, row: usize) -> f64 {
        let (w, h) = (self.tables.width, self.tables.height);
        let at = |table: usize| self.in_row[(table * h + row) * w + column];
        mixed(mix, at)
    }

    /// Cumulative integral before a column, interpolated between two rows.
    fn before(&self, mix: &Mix, column: usize, row: usize, t: f64) -> f64 {
        lerp(
            self.in_row(mix, column, row),
            self.in_row(mix, column, row + 1),
            t,
        )
    }

    fn whole(&self, mix: &Mix) -> f64 {
        self.below(mix, self.tables.height - 1)
    }

    /// From the mean over a cell's area to a density on the unit square.
    fn scale(&self, mix: &Mix) -> f64 {
        ((self.tables.width - 1) * (self.tables.height - 1)) as f64 / self.whole(mix)
    }

    /// The density at a position.
    pub fn density(&self, mix: &Mix, place: [f64; 2]) -> f64 {
        self.tables.at(mix, place) * self.scale(mix)
    }

    /// Samples a position from two numbers in 0..1.
    pub fn sample(&self, mix: &Mix, [u, v]: [f64; 2]) -> [f64; 2] {
        let (w, h) = (self.tables.width, self.tables.height);
        let target = v.clamp(0.0, 1.0) * self.whole(mix);
        let row = last(h - 1, |row| self.below(mix, row) <= target);
        let [low, high] = [row, row + 1].map(|row| self.in_row(mix, w - 1, row));
        let t = part(low, high, target - self.below(mix, row));

        let target = u.clamp(0.0, 1.0) * lerp(low, high, t);
        let column = last(w - 1, |column| self.before(mix, column, row, t) <= target);
        let [left, right] = self.tables.sides(mix, [column, row], t);
        let s = part(left, right, target - self.before(mix, column, row, t));
        [
            (column as f64 + s) / (w - 1) as f64,
            (row as f64 + t) / (h - 1) as f64,
        ]
    }

    /// The inverse of [`sample`](Warp::sample): the numbers that yield a position.
    pub fn invert(&self, mix: &Mix, place: [f64; 2]) -> [f64; 2] {
        let w = self.tables.width;
        let ([column, row], [s, t]) = self.tables.cell(place);
        let [left, right] = self.tables.sides(mix, [column, row], t);
        let [low, high] = [row, row + 1].map(|row| self.in_row(mix, w - 1, row));
        let u = (self.before(mix, column, row, t) + until(left, right, s)) / lerp(low, high, t);
        let v = (self.below(mix, row) + until(low, high, t)) / self.whole(mix);
        // A row without any density is never sampled: any number will do.
        [u, v].map(|x| if x.is_nan() { 0.5 } else { x.clamp(0.0, 1.0) })
    }
}

/// Scales a table of rows of `width` to the sum 1 of its cells' means.
fn normalize(table: &mut [f32], width: usize) {
    let row = |row: &[f32]| {
        row.windows(2)
            .map(|p| 0.5 * (f64::from(p[0]) + f64::from(p[1])))
            .sum()
    };
    let rows: Vec<f64> = table.chunks_exact(width).map(row).collect();
    let sum: f64 = rows.windows(2).map(|p| 0.5 * (p[0] + p[1])).sum();
    if sum > 0.0 {
        table
            .iter_mut()
            .for_each(|v| *v = (f64::from(*v) / sum) as f32);
    } else {
        let cells = (rows.len() - 1) * (width - 1);
        table.fill(1.0 / cells as f32);
    }
}

/// Appends the integral of a function, linear between its nodes, from the first to each of them.
fn cumulate(nodes: impl Iterator<Item = f64>, sums: &mut Vec<f64>) {
    let (mut sum, mut before) = (0.0, None);
    for value in nodes {
        if let Some(before) = before {
            sum += 0.5 * (before + value);
        }
        sums.push(sum);
        before = Some(value);
    }
}

/// The last index of `0..count` for which `holds` is true, given that it is true for a prefix; 0 if
/// for none.
fn last(count: usize, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, count);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The integral from 0 to `t` of the linear function with value `a` at 0 and `b` at 1.
fn until(a: f64, b: f64, t: f64) -> f64 {
    t * (a + 0.5 * t * (b - a))
}

/// The `t` at which that integral reaches `sum`.
fn part(a: f64, b: f64, sum: f64) -> f64 {
    let root = (a * a + 2.0 * (b - a) * sum).max(0.0).sqrt();
    let t = 2.0 * sum / (a + root);
    if t.is_nan() { 0.5 } else { t.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warp() -> Warp {
        let tables = vec![0.0, 1.0, 2.0, 3.0, 1.0, 0.5, 0.0, 4.0, 1.0, 0.0, 0.0, 0.0];
        Warp::new(Tables::new(3, 2, tables).unwrap())
    }

    #[test]
    fn what_is_sampled_is_inverted() {
        let warp = warp();
        for at in [[0.0, 0.0], [0.3, 0.0], [1.0, 0.0]] {
            let mix = mix([&[0.0, 1.0], &[5.0]], at);
            for u in [[0.1, 0.2], [0.5, 0.5], [0.9, 0.01], [0.3, 0.99]] {
                let again = warp.invert(&mix, warp.sample(&mix, u));
                let off = (again[0] - u[0]).abs() + (again[1] - u[1]).abs();
                assert!(off < 1e-9, "{u:?} {again:?}");
            }
        }
    }

    #[test]
    fn densities_integrate_to_one() {
        let (warp, n) = (warp(), 200);
        let mix = mix([&[0.0, 1.0], &[5.0]], [0.3, 0.0]);
        let middles = |k: usize| (k as f64 + 0.5) / n as f64;
        let places = (0..n * n).map(|k| [middles(k % n), middles(k / n)]);
        let sum: f64 = places.map(|place| warp.density(&mix, place)).sum();
        assert!((sum / (n * n) as f64 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn nothing_is_sampled_evenly() {
        let warp = Warp::new(Tables::new(2, 2, vec![0.0; 4]).unwrap());
        let mix = mix([&[0.0], &[0.0]], [0.0, 0.0]);
        assert_eq!(warp.sample(&mix, [0.25, 0.75]), [0.25, 0.75]);
        assert_eq!(warp.density(&mix, [0.1, 0.9]), 1.0);
    }

    #[test]
    fn sizes_must_fit() {
        let check =
            |w, h, n, fits: bool| assert_eq!(Tables::new(w, h, vec![0.0; n]).is_some(), fits);
        check(2, 2, 8, true);
        check(2, 2, 7, false);
        check(1, 4, 4, false);
        check(2, 2, 0, false);
        check(usize::MAX, 2, 4, false);
    }
}
