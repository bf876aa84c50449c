//! Sparse matrices of form factors, for solvers.

use crate::row::Entry;
use azulejo_scene::Rgb;
use azulejo_trace::run::{Record, RecordReader};
use rayon::prelude::*;

/// A matrix in compressed rows with one or three `f32` weights per entry.
///
/// Rows are appended in any order; columns are sides.
#[derive(Clone, Debug)]
pub struct SparseMatrix {
    /// 1 where every weight is grey, else 3.
    channels: usize,
    starts: Vec<u64>,
    columns: Vec<u32>,
    weights: Vec<f32>,
}

/// One row of a [`SparseMatrix`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SparseRow {
    /// Sides, ascending.
    pub columns: Vec<u32>,
    /// One weight for each, or three of them.
    pub weights: Vec<f32>,
}

impl SparseRow {
    /// A row of one or three channels, from `entries` sorted by side. Orders to the same side are added up.
    pub fn new(channels: usize, entries: &[Entry]) -> SparseRow {
        let mut row = SparseRow::default();
        for ways in entries.chunk_by(|a, b| a.side == b.side) {
            row.columns.push(ways[0].side);
            let sum: Rgb = ways.iter().map(|e| e.weight).sum();
            row.weights.extend(&sum.to_f32()[..channels]);
        }
        row
    }
}

impl Record for SparseRow {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.columns.write(bytes);
        self.weights.write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<SparseRow> {
        Some(SparseRow {
            columns: Vec::read(bytes)?,
            weights: Vec::read(bytes)?,
        })
    }
}

impl SparseMatrix {
    /// A matrix without rows.
    pub fn new(channels: usize) -> SparseMatrix {
        assert!(
            channels == 1 || channels == 3,
            "grey or RGB, not {channels} channels"
        );
        SparseMatrix {
            channels,
            starts: vec![0],
            columns: Vec::new(),
            weights: Vec::new(),
        }
    }

    /// Appends a row of [`SparseRow::new`] with as many channels.
    pub fn push(&mut self, row: &SparseRow) {
        debug_assert_eq!(row.weights.len(), self.channels * row.columns.len());
        self.columns.extend(&row.columns);
        self.weights.extend(&row.weights);
        self.starts.push(self.columns.len() as u64);
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of entries.
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        8 * self.starts.len() + 4 * self.columns.len() + 4 * self.weights.len()
    }

    /// Entries of a row: column and weight.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (u32, Rgb)> {
        let range = self.starts[row] as usize..self.starts[row + 1] as usize;
        range.map(|e| {
            let weight = |k: usize| f64::from(self.weights[self.channels * e + k % self.channels]);
            (self.columns[e], Rgb::new(weight(0), weight(1), weight(2)))
        })
    }

    /// The product of row `row` with the vector `x` over columns, in `f64`, in column order.
    pub fn row_times(&self, row: usize, x: &[Rgb]) -> Rgb {
        let range = self.starts[row] as usize..self.starts[row + 1] as usize;
        let mut sum = Rgb::BLACK;
        if self.channels == 1 {
            for (&j, &w) in self.columns[range.clone()].iter().zip(&self.weights[range]) {
                sum += x[j as usize] * f64::from(w);
            }
        } else {
            let weights = self.weights[3 * range.start..3 * range.end].chunks_exact(3);
            for (&j, w) in self.columns[range].iter().zip(weights) {
                sum += x[j as usize] * Rgb::new(w[0].into(), w[1].into(), w[2].into());
            }
        }
        sum
    }

    /// Applies `f(row)` to all rows in parallel.
    pub fn map_rows<T: Send>(&self, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        (0..self.rows()).into_par_iter().map(f).collect()
    }
}
