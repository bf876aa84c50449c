//! The matrix of a store as an operator: its pairs are read anew in each product.

use super::cursor::RowCursor;
use super::{MatrixStore, StoreError};
use crate::archive::{self, ArchiveError};
use crate::enclosure::Enclosure;
use azulejo_factors::form_factors::{Exchange, ExchangeAreas};
use azulejo_factors::hierarchy::FactorOperator;
use azulejo_trace::Progress;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Parts in which products are computed: those of [`ExchangeAreas`], so that products have the same bits.
const PARTS: usize = 16;

/// Pairs that are gathered before variances are computed from them.
const BATCH: usize = 1 << 16;

impl MatrixStore {
    /// Reads everything but the pairs, after one pass over all of them that checks them. The matrix of the
    /// enclosure then reads the store in each product, a chunk of each array at a time on each thread.
    ///
    /// # Errors
    /// As [`read`](MatrixStore::read), and a matrix that is not reciprocal.
    pub fn out_of_core(mut self, progress: &Progress) -> Result<Enclosure, StoreError> {
        let scan = self.scan(false, progress)?;
        if !scan.is_reciprocal {
            return Err(StoreError::Store(ArchiveError::from(
                "A_i X_ij and A_j X_ji differ by more than rounding, and only one of them is read out of core: \
                 form-factors F.zarr -o G.zarr takes their mean, with enough --memory"
                    .to_owned(),
            )));
        }
        let rows = self.len();
        let none = ExchangeAreas::new();
        let enclosure = archive::read_rows(self.source(), rows, none, Vec::new())?;
        let pairs = scan.lengths.iter().map(|&l| l as usize).sum();
        Ok(Enclosure {
            elsewhere: Some(Arc::new(StoredExchange {
                parts: parts(&scan.lengths, pairs),
                pairs,
                own: scan.own,
                store: self,
                failure: OnceLock::new(),
            })),
            ..enclosure
        })
    }
}

/// Ranges of rows with about equal numbers of pairs, as [`ExchangeAreas`] divides itself.
fn parts(lengths: &[u32], pairs: usize) -> Vec<Range<usize>> {
    let share = pairs / PARTS + 1;
    let (mut parts, mut start, mut found) = (Vec::new(), 0, 0);
    for (i, &length) in lengths.iter().enumerate() {
        found += length as usize;
        if found >= share || i + 1 == lengths.len() {
            parts.push(start..i + 1);
            (start, found) = (i + 1, 0);
        }
    }
    parts
}

/// The pairs of a store.
#[derive(Debug)]
struct StoredExchange {
    store: MatrixStore,
    parts: Vec<Range<usize>>,
    pairs: usize,
    /// S_ii of each row.
    own: Vec<f64>,
    /// What kept pairs from being read; products are not numbers from then on.
    failure: OnceLock<String>,
}

impl StoredExchange {
    /// Shows the pairs of some rows, row by row; errors of pairs are zeros unless they are wanted.
    fn visit(
        &self,
        rows: Range<usize>,
        with_errors: bool,
        mut show: impl FnMut(usize, &[Exchange]),
    ) -> Result<(), ArchiveError> {
        let mut cursor = RowCursor::new(&self.store, with_errors);
        let mut row = Vec::new();
        for i in rows {
            cursor.read(i)?;
            // Another process may have written to the store since it was checked.
            cursor.check(i)?;
            cursor.upper(i, &mut row);
            show(i, &row);
        }
        Ok(())
    }

    /// Remembers what went wrong.
    fn fail(&self, error: &ArchiveError) {
        let _ = self.failure.set(error.to_string());
    }

    /// The matrix of `weight(S_ij)` times L vectors, in the order of sums of
    /// [`ExchangeAreas::products`].
    fn products<const L: usize>(
        &self,
        x: &[[f64; L]],
        with_errors: bool,
        weight: impl Fn(&Exchange) -> f64 + Sync,
    ) -> Vec<[f64; L]> {
        let mut total = vec![[0.0; L]; x.len()];
        let part_sums = |part: &Range<usize>| {
            let mut sums = vec![[0.0; L]; x.len()];
            self.visit(part.clone(), with_errors, |i, row| {
                let (from, mut own) = (x[i], [0.0; L]);
                for e in row {
                    let (j, weight) = (e.column as usize, weight(e));
                    (0..L).for_each(|lane| own[lane] += weight * x[j][lane]);
                    if j != i {
                        (0..L).for_each(|lane| sums[j][lane] += weight * from[lane]);
                    }
                }
                (0..L).for_each(|lane| sums[i][lane] += own[lane]);
            })?;
            Ok(sums)
        };
        // As many parts at a time as there are threads, whose sums must be in memory together.
        for few in self.parts.chunks(rayon::current_num_threads().max(1)) {
            if self.failure.get().is_some() {
                break;
            }
            let sums: Result<Vec<Vec<[f64; L]>>, ArchiveError> =
                few.par_iter().map(part_sums).collect();
            match sums {
                Ok(sums) => total.par_iter_mut().enumerate().for_each(|(i, total)| {
                    for sums in &sums {
                        (0..L).for_each(|lane| total[lane] += sums[i][lane]);
                    }
                }),
                Err(error) => self.fail(&error),
            }
        }
        if self.failure.get().is_some() {
            return vec![[f64::NAN; L]; x.len()];
        }
        total
    }

    /// The same for any number of vectors, as many at a time as there are loops for.
    fn in_lanes(
        &self,
        x: &[f64],
        lanes: usize,
        with_errors: bool,
        weight: impl Fn(&Exchange) -> f64 + Sync,
    ) -> Vec<f64> {
        assert_eq!(x.len(), lanes * self.store.len(), "lanes for each row");
        match lanes {
            1 => self
                .products(x.as_chunks::<1>().0, with_errors, weight)
                .into_flattened(),
            2 => self
                .products(x.as_chunks::<2>().0, with_errors, weight)
                .into_flattened(),
            4 => self
                .products(x.as_chunks::<4>().0, with_errors, weight)
                .into_flattened(),
            8 => self
                .products(x.as_chunks::<8>().0, with_errors, weight)
                .into_flattened(),
            _ => {
                let mut found = vec![0.0; x.len()];
                for lane in 0..lanes {
                    let own = x.iter().skip(lane).step_by(lanes);
                    let own: Vec<[f64; 1]> = own.map(|&x| [x]).collect();
                    let product = self.products(&own, with_errors, &weight);
                    let places = found.iter_mut().skip(lane).step_by(lanes);
                    places.zip(product).for_each(|(to, [value])| *to = value);
                }
                found
            }
        }
    }
}

impl FactorOperator for StoredExchange {
    fn row_areas(&self) -> &[f64] {
        &self.store.areas
    }

    fn exchanged_lanes(&self, x: &[f64], lanes: usize) -> Vec<f64> {
        self.in_lanes(x, lanes, false, |e| e.value)
    }

    fn variance_lanes(&self, x: &[f64], lanes: usize) -> Vec<f64> {
        self.in_lanes(x, lanes, true, |e| {
            let variance = f64::from(e.error).powi(2);
            if variance.is_finite() { variance } else { 0.0 }
        })
    }

    fn for_each_pair(&self, visit: &mut dyn FnMut(usize, usize, f64)) {
        let visited = self.visit(0..self.store.len(), false, |i, row| {
            row.iter()
                .for_each(|e| visit(i, e.column as usize, e.value));
        });
        if let Err(error) = visited {
            self.fail(&error);
        }
    }

    fn numbers(&self) -> u64 {
        self.pairs as u64
    }

    fn bytes(&self) -> usize {
        size_of::<usize>() * self.store.starts.len() + 16 * self.store.len()
    }

    fn own(&self) -> Vec<f64> {
        self.own.clone()
    }

    fn variance_between(&self, r: &[f64], x: &[f64]) -> f64 {
        self.variances_between(&[(r, x)])[0]
    }

    /// One pass over the store for all of them. Each has the sum that [`FormFactors`] computes, pair by
    /// pair.
    ///
    /// [`FormFactors`]: azulejo_factors::FormFactors
    fn variances_between(&self, vectors: &[(&[f64], &[f64])]) -> Vec<f64> {
        let mut variances = vec![0.0; vectors.len()];
        let mut batch: Vec<(usize, usize, f64)> = Vec::with_capacity(2 * BATCH);
        let mut add = |batch: &mut Vec<(usize, usize, f64)>| {
            let vectors = vectors.par_iter().zip(&mut variances);
            vectors.for_each(|(&(r, x), variance)| {
                for &(i, k, error) in batch.iter() {
                    let slope = if k == i {
                        r[i] * x[i]
                    } else {
                        r[i] * x[k] + r[k] * x[i]
                    };
                    *variance += (error * slope).powi(2);
                }
            });
            batch.clear();
        };
        let visited = self.visit(0..self.store.len(), true, |i, row| {
            let pairs = row
                .iter()
                .map(|e| (i, e.column as usize, f64::from(e.error)));
            // Errors that are unknown are left out.
            batch.extend(pairs.filter(|(.., error)| error.is_finite()));
            if batch.len() >= BATCH {
                add(&mut batch);
            }
        });
        add(&mut batch);
        if let Err(error) = visited {
            self.fail(&error);
            return vec![f64::NAN; vectors.len()];
        }
        variances
    }

    fn failure(&self) -> Option<String> {
        self.failure.get().cloned()
    }
}
