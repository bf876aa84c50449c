//! Exchange areas S_ij = A_i X_ij, each pair kept once.

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

/// A sparse symmetric matrix of exchange areas: the upper triangle, row by row.
///
/// 16 bytes per pair, so that 20,000 patches that nearly all see each other fit in 3 GB, and
/// reciprocity holds to the last bit because there is nothing to disagree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExchangeAreas {
    /// Where each row starts, and after the last where it ends.
    starts: Vec<u64>,
    columns: Vec<u32>,
    values: Vec<f64>,
    errors: Vec<f32>,
}

impl ExchangeAreas {
    /// No rows yet.
    pub fn new() -> ExchangeAreas {
        ExchangeAreas {
            starts: vec![0],
            ..ExchangeAreas::default()
        }
    }

    /// Appends the next row i: entries with columns ≥ i, ascending.
    pub fn push_row(&mut self, entries: impl IntoIterator<Item = Exchange>) {
        let row = self.len() as u32;
        for e in entries {
            debug_assert!(e.column >= row, "{} is below row {row}", e.column);
            self.columns.push(e.column);
            self.values.push(e.value);
            self.errors.push(e.error);
        }
        self.starts.push(self.columns.len() as u64);
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of pairs kept, those of a row with itself included.
    pub fn pairs(&self) -> usize {
        self.columns.len()
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        8 * self.starts.len() + 16 * self.columns.len()
    }

    /// The part of row `i` from the diagonal on.
    pub fn upper(&self, i: usize) -> impl Iterator<Item = Exchange> {
        self.range(i).map(|k| self.at(k))
    }

    /// S_ij; zero if the pair is absent.
    pub fn get(&self, i: usize, j: usize) -> Exchange {
        let (low, high) = (i.min(j), i.max(j) as u32);
        let range = self.range(low);
        match self.columns[range.clone()].binary_search(&high) {
            Ok(k) => Exchange {
                column: j as u32,
                ..self.at(range.start + k)
            },
            Err(_) => Exchange {
                column: j as u32,
                ..Exchange::default()
            },
        }
    }

    /// The whole rows of a range, columns ascending. Looks once at every row before the range's
    /// end: ask for many rows at a time.
    pub fn rows(&self, range: Range<usize>) -> Vec<Vec<Exchange>> {
        let mut rows = vec![Vec::new(); range.len()];
        for i in 0..range.end.min(self.len()) {
            let entries = self.range(i);
            let columns = &self.columns[entries.clone()];
            let first = columns.partition_point(|&j| (j as usize) < range.start);
            for k in entries.start + first..entries.end {
                let e = self.at(k);
                if e.column as usize >= range.end {
                    break;
                }
                if e.column as usize != i {
                    rows[e.column as usize - range.start].push(Exchange {
                        column: i as u32,
                        ..e
                    });
                }
            }
            if i >= range.start {
                rows[i - range.start].extend(self.upper(i));
            }
        }
        rows
    }

    /// Σ_j S_ij of every row.
    pub fn row_sums(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.len()];
        for i in 0..self.len() {
            for e in self.upper(i) {
                sums[i] += e.value;
                if e.column as usize != i {
                    sums[e.column as usize] += e.value;
                }
            }
        }
        sums
    }

    /// Changes all pairs: `change(i, S_ij)` gives the new value and error.
    pub fn map(&mut self, mut change: impl FnMut(usize, Exchange) -> (f64, f32)) {
        for i in 0..self.len() {
            for k in self.range(i) {
                (self.values[k], self.errors[k]) = change(i, self.at(k));
            }
        }
    }

    fn range(&self, i: usize) -> Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }

    fn at(&self, k: usize) -> Exchange {
        Exchange {
            column: self.columns[k],
            value: self.values[k],
            error: self.errors[k],
        }
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
    fn rows_are_whole_from_half_of_the_matrix() {
        let mut areas = ExchangeAreas::new();
        areas.push_row([exchange(0, 1.0), exchange(2, 2.0)]);
        areas.push_row([exchange(2, 3.0)]);
        areas.push_row([]);
        let columns = |row: &Vec<Exchange>| row.iter().map(|e| e.column).collect::<Vec<_>>();
        let rows = areas.rows(0..3);
        assert_eq!(
            rows.iter().map(columns).collect::<Vec<_>>(),
            [vec![0, 2], vec![2], vec![0, 1]]
        );
        assert_eq!(areas.rows(1..3), rows[1..]);
        assert_eq!(areas.row_sums(), [3.0, 3.0, 5.0]);
        assert_eq!((areas.get(2, 1).value, areas.get(1, 2).value), (3.0, 3.0));
        assert_eq!(areas.get(1, 1).value, 0.0);
        assert_eq!(areas.pairs(), 3);
    }
}
