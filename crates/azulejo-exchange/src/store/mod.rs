//! Enclosures as stores of chunks (Zarr version 3), which zarr-python and dask read, and which can be
//! solved without being in memory.
//!
//! A store has the arrays of an [archive], by the same names, in chunks of at most 524,288
//! entries or rows. [`write`](fn@write) streams them; [`MatrixStore::read`] brings all of them into memory, and
//! [`MatrixStore::out_of_core`] all but the pairs, which are read again in each product, part by part.
//!
//! S_ij of a store is A_i X_ij of its upper triangle, so that reading and solving do not depend on where
//! pairs are, to the last bit. X_ji says the same but for rounding; a store in which it does not, one of
//! other programs, can be read into memory, where the mean of both is taken, and not be solved out of core.

mod cursor;
mod folder;
mod out_of_core;
#[cfg(test)]
mod tests;

pub use folder::{StoreFolder, StoreFolderSink};

use crate::archive::{
    self, ArchiveError, ArchiveOptions, ArraySource, ORDERS, ReadEnclosure, VERSION, has_orders,
};
use crate::enclosure::Enclosure;
use azulejo_factors::form_factors::{Exchange, ExchangeAreas};
use azulejo_formats::numpy::npy::StoredArray;
use azulejo_formats::zarr::{ZarrArray, ZarrGroup, ZarrSink, ZarrStore, ZarrWriter};
use azulejo_trace::sampling::{hash, uniform};
use azulejo_trace::{Cancelled, Progress};
use cursor::RowCursor;
use rayon::prelude::*;
use std::fmt;
use std::io;
use std::ops::Range;

/// The file that a store has, written last.
pub const MARK: &str = "zarr.json";

/// Entries or rows of a chunk: 4 MiB of 64-bit numbers.
const CHUNK: usize = 1 << 19;

/// Parts in which a store is scanned, whatever the number of threads.
const PARTS: usize = 16;

/// Difference of A_i Σ_j X_ij p_j by rows and by the upper triangle from which it is no rounding of 32-bit
/// numbers, as a share of their sum.
const NOT_RECIPROCAL: f64 = 1e-5;

/// Bytes that each entry takes while a matrix is read into memory, with its errors: 8 of half a pair, as
/// much again while lists grow.
const BYTES_PER_ENTRY: u64 = 16;

/// Writes an enclosure as a store: chunk by chunk, the metadata of the group last. The bytes depend on the
/// content alone.
///
/// # Errors
/// Those of writing.
pub fn write(
    enclosure: &Enclosure,
    options: ArchiveOptions,
    sink: &mut dyn ZarrSink,
) -> io::Result<()> {
    write_chunks(enclosure, options, CHUNK, sink)
}

fn write_chunks(
    enclosure: &Enclosure,
    options: ArchiveOptions,
    chunk: usize,
    sink: &mut dyn ZarrSink,
) -> io::Result<()> {
    let mut writer = ZarrWriter::new(options.compression, sink).with_chunks(chunk);
    archive::write_arrays(enclosure, options.precision, &mut writer)?;
    writer.finish(&[("azulejo_form_factors", VERSION as u64)])
}

/// A store with its metadata and starts of rows, all checked; its pairs are not read yet.
pub struct MatrixStore {
    group: ZarrGroup,
    names: Vec<String>,
    starts: Vec<usize>,
    areas: Vec<f64>,
    indices: ZarrArray,
    /// Values and errors: of the whole, or of each order of reflection.
    fields: Vec<[Option<ZarrArray>; 2]>,
    /// Bytes that arrays may still take.
    budget: u64,
}

impl fmt::Debug for MatrixStore {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("MatrixStore")
            .field("rows", &self.len())
            .field("entries", &self.entries())
            .finish_non_exhaustive()
    }
}

/// Arrays of a store, as those of an archive.
struct StoredArrays<'a> {
    group: &'a ZarrGroup,
    names: &'a [String],
    budget: &'a mut u64,
}

impl<S: ArraySource> ArraySource for &mut S {
    fn names(&self) -> Vec<String> {
        (**self).names()
    }

    fn array(&mut self, name: &str) -> Result<Option<StoredArray>, String> {
        (**self).array(name)
    }
}

impl ArraySource for StoredArrays<'_> {
    fn names(&self) -> Vec<String> {
        self.names.to_vec()
    }

    fn array(&mut self, name: &str) -> Result<Option<StoredArray>, String> {
        Ok(self.group.whole(name, self.budget)?)
    }
}

impl MatrixStore {
    /// Reads metadata, areas and starts of rows. Arrays may together expand to at most `budget` bytes.
    ///
    /// # Errors
    /// The key within the store, what was found and what was expected.
    pub fn open(store: impl ZarrStore + 'static, budget: u64) -> Result<MatrixStore, ArchiveError> {
        let group = ZarrGroup::open(store).map_err(String::from)?;
        let names = group.names().map_err(String::from)?;
        let mut budget = budget;
        let mut source = StoredArrays {
            group: &group,
            names: &names,
            budget: &mut budget,
        };
        let (rows, starts) = archive::read_starts(&mut source)?;
        let areas = archive::read_areas(&mut source, rows)?;
        let entries = starts.last().copied().unwrap_or(0) as u64;
        let found = |name: &str| -> Result<Option<ZarrArray>, ArchiveError> {
            let array = group.array(name).map_err(String::from)?;
            match &array {
                Some(array) if array.shape() != [entries] => Err(ArchiveError::from(format!(
                    "{name}/zarr.json: its shape is {:?}, expected [{entries}], where indptr ends",
                    array.shape()
                ))),
                _ => Ok(array),
            }
        };
        let required = |name: &str| -> Result<ZarrArray, ArchiveError> {
            found(name)?.ok_or_else(|| {
                let has = names.join(", ");
                ArchiveError::from(format!("there is no array \"{name}\" (there are: {has})"))
            })
        };
        let indices = required("indices")?;
        let mut fields = Vec::new();
        if has_orders(&names) {
            for [values, errors] in ORDERS {
                fields.push([Some(required(values)?), found(errors)?]);
            }
        } else {
            fields.push([Some(required("data")?), found("std_error")?]);
        }
        Ok(MatrixStore {
            indices,
            fields,
            starts,
            areas,
            budget,
            names,
            group,
        })
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Number of entries of the whole matrix.
    pub fn entries(&self) -> usize {
        self.starts.last().copied().unwrap_or(0)
    }

    /// Bytes that the matrix takes while it is read into memory, about.
    pub fn bytes_in_memory(&self) -> u64 {
        let fields = match self.fields.len() {
            1 => 1,
            // Each order, and their sum.
            orders => orders as u64 + 1,
        };
        (self.entries() as u64).saturating_mul(fields * BYTES_PER_ENTRY)
    }

    /// Whether the matrix may be read into memory within the budget.
    pub fn fits(&self) -> bool {
        self.bytes_in_memory() <= self.budget
    }

    /// Whether factors are stored in 32 bits.
    fn is_single(&self) -> Result<bool, ArchiveError> {
        let Some([Some(values), _]) = self.fields.first().filter(|_| self.entries() > 0) else {
            return Ok(false);
        };
        let chunk = self.group.chunk(values, 0).map_err(String::from)?;
        Ok(chunk.is_single())
    }

    /// Brings the whole into memory.
    ///
    /// # Errors
    /// The key within the store, what was found and what was expected; a matrix that exceeds the budget.
    pub fn read(mut self, progress: &Progress) -> Result<ReadEnclosure, StoreError> {
        if !self.fits() {
            return Err(StoreError::Store(ArchiveError::from(format!(
                "the matrix takes {} bytes in memory, expected at most {}: allow more with --memory, or solve it \
                 out of core (azulejo exchange)",
                self.bytes_in_memory(),
                self.budget
            ))));
        }
        let scan = self.scan(true, progress)?;
        let is_single = self.is_single()?;
        let arrays = self.names.clone();
        if !scan.is_reciprocal {
            let read = archive::read_arrays(self.source())?;
            return Ok(read);
        }
        let mut matrices = scan.matrices.into_iter();
        let (exchange, orders) = if self.fields.len() == 1 {
            (matrices.next().unwrap_or_default(), Vec::new())
        } else {
            let orders: Vec<ExchangeAreas> = matrices.collect();
            (ExchangeAreas::sum_of(&orders), orders)
        };
        let rows = self.len();
        Ok(ReadEnclosure {
            enclosure: archive::read_rows(self.source(), rows, exchange, orders)?,
            arrays,
            is_single,
            asymmetry: 0.0,
        })
    }

    fn source(&mut self) -> StoredArrays<'_> {
        StoredArrays {
            group: &self.group,
            names: &self.names,
            budget: &mut self.budget,
        }
    }

    /// Ranges of rows with about equal numbers of entries.
    fn parts(&self) -> Vec<Range<usize>> {
        let bound = |k: usize| {
            let entry = self.entries() as u128 * k as u128 / PARTS as u128;
            let row = self.starts.partition_point(|&s| (s as u128) < entry);
            row.min(self.len())
        };
        let bounds = (0..PARTS).map(|k| {
            let end = if k + 1 == PARTS {
                self.len()
            } else {
                bound(k + 1)
            };
            bound(k)..end
        });
        bounds.filter(|range| !range.is_empty()).collect()
    }

    /// Passes over all entries once, and checks them.
    fn scan(&self, keep: bool, progress: &Progress) -> Result<StoreScan, StoreError> {
        let probe: Vec<f64> = (0..self.len())
            .map(|i| 0.5 + f64::from(uniform(&[hash(&[71, i as u32])])))
            .collect();
        let part = |rows: Range<usize>| self.scan_part(rows, keep, &probe, progress);
        let parts = self.parts().into_par_iter().map(part);
        let parts: Vec<StoreScan> = parts.collect::<Result<_, StoreError>>()?;
        let mut whole = StoreScan::new(self, keep);
        let mut matrices: Vec<Vec<Box<[Exchange]>>> = vec![Vec::new(); whole.kept.len()];
        for part in parts {
            whole.lengths.extend(part.lengths);
            whole.own.extend(part.own);
            whole.by_rows.extend(part.by_rows);
            for (sum, part) in whole.by_pairs.iter_mut().zip(&part.by_pairs) {
                *sum += part;
            }
            for (matrix, rows) in matrices.iter_mut().zip(part.kept) {
                matrix.extend(rows);
            }
        }
        whole.matrices = matrices.into_iter().map(ExchangeAreas::from_rows).collect();
        let sides = whole.by_rows.iter().zip(&whole.by_pairs);
        let mut off = sides.map(|(a, b)| (a - b).abs() > NOT_RECIPROCAL * (a.abs() + b.abs()));
        whole.is_reciprocal = !off.any(|is_off| is_off);
        Ok(whole)
    }

    fn scan_part(
        &self,
        rows: Range<usize>,
        keep: bool,
        probe: &[f64],
        progress: &Progress,
    ) -> Result<StoreScan, StoreError> {
        let mut scan = StoreScan::new(self, keep);
        let mut cursor = RowCursor::new(self, true);
        let mut sum = Vec::new();
        for i in rows {
            if i % 64 == 0 {
                progress.advance(0)?;
            }
            cursor.read(i)?;
            cursor.check(i)?;
            let by_row: f64 = (0..self.fields.len())
                .map(|field| {
                    let values = cursor.columns().iter().zip(cursor.values(field));
                    values.map(|(&j, x)| x * probe[j as usize]).sum::<f64>()
                })
                .sum();
            scan.by_rows.push(self.areas[i] * by_row);
            cursor.upper(i, &mut sum);
            scan.lengths.push(sum.len() as u32);
            let first = sum.first().filter(|e| e.column as usize == i);
            scan.own.push(first.map_or(0.0, |e| e.value));
            for e in &sum {
                let j = e.column as usize;
                scan.by_pairs[i] += e.value * probe[j];
                if j != i {
                    scan.by_pairs[j] += e.value * probe[i];
                }
            }
            for (field, kept) in scan.kept.iter_mut().enumerate() {
                kept.push(cursor.upper_of(i, field).collect());
            }
        }
        Ok(scan)
    }
}

/// What a pass over all entries finds.
struct StoreScan {
    /// Pairs of each row.
    lengths: Vec<u32>,
    /// S_ii of each row.
    own: Vec<f64>,
    /// A_i Σ_j X_ij p_j by whole rows, and by the upper triangle.
    by_rows: Vec<f64>,
    by_pairs: Vec<f64>,
    /// The rows of each field, if they are kept.
    kept: Vec<Vec<Box<[Exchange]>>>,
    /// The same as matrices, of the whole.
    matrices: Vec<ExchangeAreas>,
    is_reciprocal: bool,
}

impl StoreScan {
    fn new(store: &MatrixStore, keep: bool) -> StoreScan {
        StoreScan {
            lengths: Vec::new(),
            own: Vec::new(),
            by_rows: Vec::new(),
            by_pairs: vec![0.0; store.len()],
            kept: vec![Vec::new(); if keep { store.fields.len() } else { 0 }],
            matrices: Vec::new(),
            is_reciprocal: true,
        }
    }
}

/// Why a store could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StoreError {
    /// The caller cancelled.
    Cancelled,
    /// What is wrong with the store.
    Store(ArchiveError),
}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            StoreError::Cancelled => Cancelled.fmt(f),
            StoreError::Store(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for StoreError {}

impl From<Cancelled> for StoreError {
    fn from(_: Cancelled) -> StoreError {
        StoreError::Cancelled
    }
}

impl From<ArchiveError> for StoreError {
    fn from(error: ArchiveError) -> StoreError {
        StoreError::Store(error)
    }
}
