//! Whole matrices in compressed rows, from the one half that is stored.

use azulejo_factors::FormFactors;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use rayon::prelude::*;
use std::ops::Range;

/// Compressed rows, in vectors that become arrays without a copy.
pub struct CsrBuffers {
    data: Vec<f64>,
    error: Vec<f32>,
    columns: IndexBuffer,
    starts: IndexBuffer,
}

/// Indices of the smaller type that suffices for columns and entries: SciPy wants one type for both,
/// and would copy other ones.
enum IndexBuffer {
    Small(Vec<i32>),
    Large(Vec<i64>),
}

/// Data, standard errors, columns, starts of rows.
pub type CsrArrays<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
);

/// Data and standard errors.
pub type OrderArrays<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f32>>);

impl CsrBuffers {
    /// The whole matrix.
    pub fn new(factors: &FormFactors) -> CsrBuffers {
        let starts = starts(factors);
        let count = starts[factors.len()];
        let is_small = i32::try_from(count.max(factors.len())).is_ok();
        let (mut data, mut error) = (vec![0.0; count], vec![0.0; count]);
        let mut small = vec![0i32; if is_small { count } else { 0 }];
        let mut large = vec![0i64; if is_small { 0 } else { count }];
        let blocks = blocks(factors, &starts);
        let pieces = cut(&mut data, &blocks).into_par_iter();
        let pieces = pieces.zip(cut(&mut error, &blocks));
        let columns = cut(&mut small, &blocks).into_par_iter();
        let columns = columns.zip(cut(&mut large, &blocks));
        let parts = pieces.zip(columns).zip(&blocks);
        parts.for_each(|(((data, error), (small, large)), (rows, _))| {
            let entries = factors.rows(rows.clone()).into_iter().flatten();
            for (k, (column, value, spread)) in entries.enumerate() {
                (data[k], error[k]) = (value, spread);
                if is_small {
                    small[k] = column as i32;
                } else {
                    large[k] = i64::from(column);
                }
            }
        });
        let (columns, starts) = if is_small {
            let starts = starts.iter().map(|&s| s as i32).collect();
            (IndexBuffer::Small(small), IndexBuffer::Small(starts))
        } else {
            let starts = starts.iter().map(|&s| s as i64).collect();
            (IndexBuffer::Large(large), IndexBuffer::Large(starts))
        };
        CsrBuffers {
            data,
            error,
            columns,
            starts,
        }
    }

    /// As arrays that own these vectors.
    pub fn into_arrays(self, py: Python<'_>) -> CsrArrays<'_> {
        let indices = |buffer: IndexBuffer| match buffer {
            IndexBuffer::Small(numbers) => numbers.into_pyarray(py).into_any(),
            IndexBuffer::Large(numbers) => numbers.into_pyarray(py).into_any(),
        };
        (
            self.data.into_pyarray(py),
            self.error.into_pyarray(py),
            indices(self.columns),
            indices(self.starts),
        )
    }
}

/// Data and standard errors of one order of reflection for every entry of the matrix, zeros where it
/// has none.
pub fn order(factors: &FormFactors, order: usize) -> (Vec<f64>, Vec<f32>) {
    let starts = starts(factors);
    let count = starts[factors.len()];
    let (mut data, mut error) = (vec![0.0; count], vec![0.0; count]);
    let blocks = blocks(factors, &starts);
    let pieces = cut(&mut data, &blocks).into_par_iter();
    let parts = pieces.zip(cut(&mut error, &blocks)).zip(&blocks);
    parts.for_each(|((data, error), (rows, _))| {
        let whole = factors.exchange.rows(rows.clone());
        let parts = factors.rows_of_order(order, rows.clone());
        let entries = whole.iter().zip(&parts).flat_map(|(row, part)| {
            row.iter().map(|e| {
                let position = part.binary_search_by_key(&e.column, |&(j, ..)| j);
                position.map_or((0.0, 0.0), |k| (part[k].1, part[k].2))
            })
        });
        for (k, (value, spread)) in entries.enumerate() {
            (data[k], error[k]) = (value, spread);
        }
    });
    (data, error)
}

/// The start of each row, and the end of the last.
fn starts(factors: &FormFactors) -> Vec<usize> {
    let mut starts = vec![0];
    for length in factors.exchange.row_lengths() {
        starts.push(starts[starts.len() - 1] + length);
    }
    starts
}

/// Blocks of rows, with the number of their entries.
fn blocks(factors: &FormFactors, starts: &[usize]) -> Vec<(Range<usize>, usize)> {
    let sized = |rows: Range<usize>| {
        let entries = starts[rows.end] - starts[rows.start];
        (rows, entries)
    };
    factors.blocks().into_iter().map(sized).collect()
}

/// A list cut into the pieces of blocks; of a list that is not used, empty ones.
fn cut<'a, T>(mut list: &'a mut [T], blocks: &[(Range<usize>, usize)]) -> Vec<&'a mut [T]> {
    let mut pieces = Vec::with_capacity(blocks.len());
    for (_, entries) in blocks {
        let (piece, rest) = list.split_at_mut((*entries).min(list.len()));
        pieces.push(piece);
        list = rest;
    }
    pieces
}
