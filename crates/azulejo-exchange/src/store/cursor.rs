//! Rows of a store, one after the other, with one chunk of each array in memory.

use super::MatrixStore;
use crate::archive::ArchiveError;
use azulejo_factors::form_factors::Exchange;
use azulejo_formats::numpy::npy::StoredArray;
use azulejo_formats::zarr::{ZarrArray, ZarrGroup};
use std::ops::Range;

/// One chunk of an array.
struct ChunkCursor<'a, T> {
    array: &'a ZarrArray,
    convert: fn(&StoredArray) -> Option<Vec<T>>,
    expected: &'static str,
    /// The chunk in memory, and its number.
    chunk: Option<(u64, Vec<T>)>,
    /// The numbers of the last row that was read.
    row: Vec<T>,
}

impl<T: Copy> ChunkCursor<'_, T> {
    fn read(&mut self, group: &ZarrGroup, entries: Range<usize>) -> Result<(), ArchiveError> {
        self.row.clear();
        let rows = self.array.chunk_rows();
        let mut at = entries.start as u64;
        while at < entries.end as u64 {
            let number = at / rows;
            if self.chunk.as_ref().is_none_or(|(n, _)| *n != number) {
                let stored = group.chunk(self.array, number).map_err(String::from)?;
                let numbers = (self.convert)(&stored).ok_or_else(|| {
                    let message = format!("chunk {number}: expected {}", self.expected);
                    ArchiveError::from(message)
                })?;
                self.chunk = Some((number, numbers));
            }
            let Some((_, chunk)) = &self.chunk else {
                break;
            };
            let from = (at - number * rows) as usize;
            let part = (entries.end as u64 - at).min(rows - from as u64) as usize;
            self.row.extend_from_slice(&chunk[from..from + part]);
            at += part as u64;
        }
        Ok(())
    }
}

fn columns(stored: &StoredArray) -> Option<Vec<u32>> {
    let integers = stored.integers()?;
    let columns = integers.into_iter().map(u32::try_from);
    columns.collect::<Result<_, _>>().ok()
}

/// Columns, values and errors of one row after the other.
pub(super) struct RowCursor<'a> {
    store: &'a MatrixStore,
    columns: ChunkCursor<'a, u32>,
    /// Values of each field, and errors where there are any and they are wanted.
    fields: Vec<(ChunkCursor<'a, f64>, Option<ChunkCursor<'a, f64>>)>,
}

impl<'a> RowCursor<'a> {
    pub fn new(store: &'a MatrixStore, with_errors: bool) -> RowCursor<'a> {
        fn numbers(array: &ZarrArray) -> ChunkCursor<'_, f64> {
            ChunkCursor {
                array,
                convert: StoredArray::numbers,
                expected: "real numbers",
                chunk: None,
                row: Vec::new(),
            }
        }
        let fields = store.fields.iter().filter_map(|[values, errors]| {
            let errors = errors.as_ref().filter(|_| with_errors);
            Some((numbers(values.as_ref()?), errors.map(numbers)))
        });
        RowCursor {
            columns: ChunkCursor {
                array: &store.indices,
                convert: columns,
                expected: "whole numbers from 0 on, the columns",
                chunk: None,
                row: Vec::new(),
            },
            fields: fields.collect(),
            store,
        }
    }

    /// Reads row `i`.
    pub fn read(&mut self, i: usize) -> Result<(), ArchiveError> {
        let entries = self.store.starts[i]..self.store.starts[i + 1];
        let group = &self.store.group;
        self.columns.read(group, entries.clone())?;
        for (values, errors) in &mut self.fields {
            values.read(group, entries.clone())?;
            if let Some(errors) = errors {
                errors.read(group, entries.clone())?;
            }
        }
        Ok(())
    }

    /// Refuses columns that do not ascend or are none, and values that are not finite.
    pub fn check(&self, i: usize) -> Result<(), ArchiveError> {
        let columns = self.columns();
        if columns
            .last()
            .is_some_and(|&j| j as usize >= self.store.len())
            || !columns.is_sorted_by(|a, b| a < b)
        {
            return Err(ArchiveError::from(format!(
                "indices: the columns of row {i} do not ascend below {}, the number of rows (in SciPy: \
                 sum_duplicates())",
                self.store.len()
            )));
        }
        for (values, _) in &self.fields {
            if let Some(x) = values.row.iter().find(|x| !x.is_finite()) {
                return Err(ArchiveError::from(format!(
                    "row {i} has a factor of {x}, expected finite numbers"
                )));
            }
        }
        Ok(())
    }

    /// The columns of the row.
    pub fn columns(&self) -> &[u32] {
        &self.columns.row
    }

    /// The factors of the row.
    pub fn values(&self, field: usize) -> &[f64] {
        &self.fields[field].0.row
    }

    /// Exchange areas of the upper triangle by one field, without zeros.
    pub fn upper_of(&self, i: usize, field: usize) -> impl Iterator<Item = Exchange> {
        let (area, columns) = (self.store.areas[i], self.columns());
        let (values, errors) = &self.fields[field];
        let first = columns.partition_point(|&j| (j as usize) < i);
        (first..columns.len())
            .map(move |k| Exchange {
                column: columns[k],
                value: area * values.row[k],
                error: errors.as_ref().map_or(0.0, |e| (area * e.row[k]) as f32),
            })
            .filter(|e| e.value != 0.0 || e.error != 0.0)
    }

    /// Exchange areas of the upper triangle, of orders of reflection their sum, as
    /// [`ExchangeAreas::sum_of`](azulejo_factors::form_factors::ExchangeAreas::sum_of) adds them.
    pub fn upper(&self, i: usize, row: &mut Vec<Exchange>) {
        row.clear();
        if self.fields.len() == 1 {
            row.extend(self.upper_of(i, 0));
            return;
        }
        let (area, columns) = (self.store.areas[i], self.columns());
        let first = columns.partition_point(|&j| (j as usize) < i);
        for (k, &column) in columns.iter().enumerate().skip(first) {
            let mut sum = Exchange {
                column,
                ..Exchange::default()
            };
            let mut is_zero = true;
            for (values, errors) in &self.fields {
                let value = area * values.row[k];
                let error = errors.as_ref().map_or(0.0, |e| (area * e.row[k]) as f32);
                is_zero &= value == 0.0 && error == 0.0;
                sum.value += value;
                sum.error = sum.error.hypot(error);
            }
            if !is_zero {
                row.push(sum);
            }
        }
    }
}
