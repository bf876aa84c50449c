//! Exchange areas S_ij = A_i X_ij, stored once per pair.

use azulejo_trace::run::{RecordReader, write_list};
use rayon::prelude::*;
use std::ops::Range;

/// The exchange area of a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange {
    /// The column; in storage never below the row.
    pub column: u32,
    /// S, in square scene units.
    pub value: f64,
    /// Its standard error.
    pub error: f32,
}

/// Appends a row's bytes, for storage.
pub(crate) fn write_row(row: &[Exchange], bytes: &mut Vec<u8>) {
    write_list(row, bytes, |e, bytes| {
        bytes.extend(e.column.to_le_bytes());
        bytes.extend(e.value.to_le_bytes());
        bytes.extend(e.error.to_le_bytes());
    });
}

/// The inverse of [`write_row`].
pub(crate) fn read_row(bytes: &mut RecordReader) -> Option<Vec<Exchange>> {
    bytes.list(|b| {
        Some(Exchange {
            column: b.u32()?,
            value: b.f64()?,
            error: b.f32()?,
        })
    })
}

/// Sums over rows are computed in this many parts, whatever the number of threads.
const PARTS: usize = 16;

/// A sparse symmetric matrix of exchange areas: the upper triangle, row by row.
///
/// 16 bytes per pair, so that 20,000 patches that nearly all see each other fit in 3.2 GB.
/// Reciprocity holds to the last bit, because both directions are one number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExchangeAreas {
    /// Per row the entries from the diagonal on, columns ascending. Each row has its own
    /// allocation, so that nothing is moved when the matrix grows.
    rows: Vec<Box<[Exchange]>>,
}

impl ExchangeAreas {
    /// A matrix without rows.
    pub fn new() -> ExchangeAreas {
        ExchangeAreas::default()
    }

    /// Rows of entries from the diagonal on, columns ascending.
    pub fn from_rows(rows: Vec<Box<[Exchange]>>) -> ExchangeAreas {
        ExchangeAreas { rows }
    }

    /// Appends the next row i: entries with columns ≥ i, ascending.
    pub fn push_row(&mut self, entries: impl IntoIterator<Item = Exchange>) {
        let entries: Box<[Exchange]> = entries.into_iter().collect();
        let row = self.len() as u32;
        debug_assert!(
            entries.iter().all(|e| e.column >= row),
            "row {row} is not upper"
        );
        debug_assert!(
            entries.is_sorted_by(|a, b| a.column < b.column),
            "row {row} ascends"
        );
        self.rows.push(entries);
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Number of stored pairs, including those of a row with itself.
    pub fn pairs(&self) -> usize {
        self.rows.iter().map(|r| r.len()).sum()
    }

    /// Number of entries of the whole matrix.
    pub fn entries(&self) -> usize {
        self.row_lengths().iter().sum()
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        size_of::<Box<[Exchange]>>() * self.len() + size_of::<Exchange>() * self.pairs()
    }

    /// The part of row `i` from the diagonal on.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn upper(&self, i: usize) -> &[Exchange] {
        &self.rows[i]
    }

    /// S_ij; zero if the pair is absent.
    ///
    /// # Panics
    /// If there is no row with the smaller index.
    pub fn get(&self, i: usize, j: usize) -> Exchange {
        let (low, high) = (i.min(j), i.max(j) as u32);
        let row = &self.rows[low];
        let place = row.binary_search_by_key(&high, |e| e.column);
        Exchange {
            column: j as u32,
            ..place.map_or(Exchange::default(), |k| row[k])
        }
    }

    /// The whole rows of a range, columns ascending. Visits every row before the range's end once:
    /// request many rows at a time.
    ///
    /// # Panics
    /// If the range goes beyond the last row.
    pub fn rows(&self, range: Range<usize>) -> Vec<Vec<Exchange>> {
        let mut rows = vec![Vec::new(); range.len()];
        for (i, upper) in self.rows[..range.end].iter().enumerate() {
            // The entries below the diagonal come from the rows above.
            let first = upper.partition_point(|e| (e.column as usize) < range.start.max(i + 1));
            let is_inside = |e: &&Exchange| (e.column as usize) < range.end;
            for e in upper[first..].iter().take_while(is_inside) {
                let mirrored = Exchange {
                    column: i as u32,
                    ..*e
                };
                rows[e.column as usize - range.start].push(mirrored);
            }
        }
        let uppers = &self.rows[range];
        rows.iter_mut()
            .zip(uppers)
            .for_each(|(row, upper)| row.extend_from_slice(upper));
        rows
    }

    /// Adds to S_ij, i ≤ j, creating the pair if it is absent; its error stays.
    pub(crate) fn add(&mut self, i: usize, j: usize, value: f64) {
        let mut row = std::mem::take(&mut self.rows[i]).into_vec();
        let column = j as u32;
        match row.binary_search_by_key(&column, |e| e.column) {
            Ok(k) => row[k].value += value,
            Err(k) => {
                let error = 0.0;
                row.insert(
                    k,
                    Exchange {
                        column,
                        value,
                        error,
                    },
                );
            }
        }
        self.rows[i] = row.into();
    }

    /// Number of entries of each whole row.
    pub fn row_lengths(&self) -> Vec<usize> {
        let mut lengths = vec![0; self.len()];
        for (i, upper) in self.rows.iter().enumerate() {
            lengths[i] += upper.len();
            let below = upper.iter().filter(|e| e.column as usize != i);
            below.for_each(|e| lengths[e.column as usize] += 1);
        }
        lengths
    }

    /// Σ_j S_ij of every row.
    pub fn row_sums(&self) -> Vec<f64> {
        self.sums(|_, e| [e.value; 2])
    }

    /// Sums over whole rows: `f(i, S_ij)` returns what a pair adds to row i and to row j. A pair of
    /// a row with itself adds the first alone.
    pub fn sums(&self, f: impl Fn(usize, &Exchange) -> [f64; 2] + Sync) -> Vec<f64> {
        let part_sums = |part: &Range<usize>| {
            let mut sums = vec![0.0; self.len()];
            for i in part.clone() {
                for e in self.upper(i) {
                    let [to_row, to_column] = f(i, e);
                    sums[i] += to_row;
                    if e.column as usize != i {
                        sums[e.column as usize] += to_column;
                    }
                }
            }
            sums
        };
        self.added_parts(&part_sums)
    }

    /// The sum of what `part_sums` gives for each part. Apart, so that the loops of threads are compiled once and not
    /// for each closure of [`ExchangeAreas::sums`].
    fn added_parts(&self, part_sums: &(dyn Fn(&Range<usize>) -> Vec<f64> + Sync)) -> Vec<f64> {
        let parts = self.parts();
        let sums: Vec<Vec<f64>> = parts.par_iter().map(part_sums).collect();
        let total = |i: usize| sums.iter().map(|s| s[i]).sum();
        (0..self.len()).into_par_iter().map(total).collect()
    }

    /// The symmetric matrix of `weight(S_ij)` times L vectors at once, whose numbers of one row stand side
    /// by side: reading the pairs is what takes the time. The same bits for any number of threads.
    ///
    /// # Panics
    /// If `x` has fewer rows.
    pub fn products<const L: usize>(
        &self,
        x: &[[f64; L]],
        weight: impl Fn(&Exchange) -> f64 + Sync,
    ) -> Vec<[f64; L]> {
        let part_sums = |part: &Range<usize>| {
            let mut sums = vec![[0.0; L]; x.len()];
            for i in part.clone() {
                let (from, mut own) = (x[i], [0.0; L]);
                for e in self.upper(i) {
                    let (j, weight) = (e.column as usize, weight(e));
                    (0..L).for_each(|lane| own[lane] += weight * x[j][lane]);
                    if j != i {
                        (0..L).for_each(|lane| sums[j][lane] += weight * from[lane]);
                    }
                }
                (0..L).for_each(|lane| sums[i][lane] += own[lane]);
            }
            sums
        };
        self.added_lanes(x.len(), &part_sums)
    }

    /// As [`ExchangeAreas::added_parts`], of L vectors.
    fn added_lanes<const L: usize>(
        &self,
        rows: usize,
        part_sums: &(dyn Fn(&Range<usize>) -> Vec<[f64; L]> + Sync),
    ) -> Vec<[f64; L]> {
        let sums: Vec<Vec<[f64; L]>> = self.parts().par_iter().map(part_sums).collect();
        let total = |i: usize| {
            let mut total = [0.0; L];
            for sums in &sums {
                (0..L).for_each(|lane| total[lane] += sums[i][lane]);
            }
            total
        };
        (0..rows).into_par_iter().map(total).collect()
    }

    /// Changes each pair in place; drops it if `keep(i, S_ij)` returns false.
    pub fn retain(&mut self, keep: impl Fn(usize, &mut Exchange) -> bool + Sync) {
        self.change_rows(&|i, row| {
            let mut entries = std::mem::take(row).into_vec();
            entries.retain_mut(|e| keep(i, e));
            *row = entries.into_boxed_slice();
        });
    }

    fn change_rows(&mut self, change: &(dyn Fn(usize, &mut Box<[Exchange]>) + Sync)) {
        let rows = self.rows.par_iter_mut().enumerate();
        rows.for_each(|(i, row)| change(i, row));
    }

    /// The sum of matrices with the same number of rows; errors are added as of independent
    /// estimates.
    pub fn sum_of(parts: &[ExchangeAreas]) -> ExchangeAreas {
        let row = |i: usize| {
            let rows = parts.iter().map(|p| p.upper(i));
            rows.fold(Vec::new(), |sum, row| added(&sum, row)).into()
        };
        let rows = 0..parts.first().map_or(0, ExchangeAreas::len);
        ExchangeAreas {
            rows: rows.into_par_iter().map(row).collect(),
        }
    }

    /// Ranges of rows with about equal numbers of pairs, which depend on the matrix alone.
    fn parts(&self) -> Vec<Range<usize>> {
        let share = self.pairs() / PARTS + 1;
        let (mut parts, mut start, mut pairs) = (Vec::new(), 0, 0);
        for (i, row) in self.rows.iter().enumerate() {
            pairs += row.len();
            if pairs >= share || i + 1 == self.len() {
                parts.push(start..i + 1);
                (start, pairs) = (i + 1, 0);
            }
        }
        parts
    }
}

/// The sum of two rows.
fn added(a: &[Exchange], b: &[Exchange]) -> Vec<Exchange> {
    let mut sum = Vec::with_capacity(a.len().max(b.len()));
    let column = |e: &Exchange| e.column;
    union(a, b, column, column, |column, a, b| {
        let [a, b] = [a, b].map(|e| e.copied().unwrap_or_default());
        sum.push(Exchange {
            column,
            value: a.value + b.value,
            error: a.error.hypot(b.error),
        });
    });
    sum
}

/// Visits the union of two lists sorted by key, in order, with the items of either list for the
/// key.
pub(crate) fn union<A, B>(
    a: &[A],
    b: &[B],
    key_a: impl Fn(&A) -> u32,
    key_b: impl Fn(&B) -> u32,
    mut visit: impl FnMut(u32, Option<&A>, Option<&B>),
) {
    let (mut i, mut j) = (0, 0);
    loop {
        let (x, y) = (a.get(i), b.get(j));
        let Some(key) = x.map(&key_a).into_iter().chain(y.map(&key_b)).min() else {
            return;
        };
        let (x, y) = (x.filter(|x| key_a(x) == key), y.filter(|y| key_b(y) == key));
        visit(key, x, y);
        i += usize::from(x.is_some());
        j += usize::from(y.is_some());
    }
}

impl FromIterator<Vec<Exchange>> for ExchangeAreas {
    /// The matrix with these upper rows.
    fn from_iter<T: IntoIterator<Item = Vec<Exchange>>>(rows: T) -> ExchangeAreas {
        let mut areas = ExchangeAreas::new();
        rows.into_iter().for_each(|row| areas.push_row(row));
        areas
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exchange(column: u32, value: f64) -> Exchange {
        Exchange {
            column,
            value,
            error: 0.5,
        }
    }

    #[test]
    fn a_pair_takes_sixteen_bytes() {
        assert_eq!(size_of::<Exchange>(), 16);
    }

    #[test]
    fn rows_are_whole_from_half_of_the_matrix() {
        let areas = ExchangeAreas::from_iter([
            vec![exchange(0, 1.0), exchange(2, 2.0)],
            vec![exchange(2, 3.0)],
            vec![],
        ]);
        let columns = |row: &Vec<Exchange>| row.iter().map(|e| e.column).collect::<Vec<_>>();
        let rows = areas.rows(0..3);
        assert_eq!(
            rows.iter().map(columns).collect::<Vec<_>>(),
            [vec![0, 2], vec![2], vec![0, 1]]
        );
        assert_eq!(areas.rows(1..3), rows[1..]);
        assert_eq!(areas.row_sums(), [3.0, 3.0, 5.0]);
        assert_eq!(areas.row_lengths(), [2, 1, 2]);
        assert_eq!((areas.get(2, 1).value, areas.get(1, 2).value), (3.0, 3.0));
        assert_eq!(areas.get(1, 1).value, 0.0);
        assert_eq!((areas.pairs(), areas.entries()), (3, 5));
    }
}
