//! Enforcing closure: rows changed within their errors so that no light is missing.

use super::exchange::Exchange;
use super::matrix::{Adjustment, FormFactors, RowRemainder};
use super::smoothing::{LEAST, Smoothing, SmoothingChange};
use azulejo_trace::{Cancelled, Progress};

/// Tolerated deficit of a row's sum.
const TOLERANCE: f64 = 1e-9;

/// Share of a row's light that a closed scene may lose: rays through cracks.
const LOSS: f64 = 1e-6;

impl FormFactors {
    /// Whether no row that sees anything loses light. Rows that see nothing are the outside of a
    /// closed room.
    pub(super) fn loses_no_light(&self) -> bool {
        let lengths = self.exchange.row_lengths();
        let seeing: Vec<usize> = (0..self.len()).filter(|&i| lengths[i] > 0).collect();
        !seeing.is_empty() && seeing.iter().all(|&i| self.rest[i].escaped() <= LOSS)
    }

    /// Enforces closure: makes Σ_j X_ij `ends`_j and the shares of `rest` sum to 1 in every row by
    /// the smallest change of exchange areas and of the shares of sky and ground, weighted by their
    /// standard errors, or by their values where no entry has an error. Light that leaked through cracks of a closed scene is put back first.
    /// [`closed`](FormFactors::closed) records how much was moved; standard errors stay as they
    /// were.
    ///
    /// Rows without an entry or share that could change stay as they are, and no entry falls below
    /// a tenth of its value: [`Adjustment::deficit`] is what a row lacks then.
    ///
    /// # Errors
    /// [`Cancelled`]; the matrix is as before then.
    pub fn close(&mut self, progress: &Progress) -> Result<(), Cancelled> {
        let rest: Vec<RowRemainder> = self.rest.iter().map(without_leaks).collect();
        let weight = self.closure_weights();
        let variance = |e: &Exchange| weight.variance(f64::from(e.error), e.value);
        let ended = self.ended();
        let rows = || self.areas.iter().zip(&rest);
        let smoothing = Smoothing {
            exchange: &self.exchange,
            variance: |_, e: &Exchange| variance(e),
            weights: &self.ends,
            free: rows()
                .map(|(a, r)| {
                    let [sky, ground] = [(r.sky_error, r.sky), (r.ground_error, r.ground)]
                        .map(|(error, value)| weight.variance(error, value));
                    a * a * (sky + ground)
                })
                .collect(),
            deficits: rows()
                .zip(&ended)
                .map(|((a, r), ended)| a * (1.0 - r.sum() - ended))
                .collect(),
            tolerated: self.areas.iter().map(|a| a * TOLERANCE).collect(),
        };
        let change = smoothing.solve(progress)?;
        let rest: Vec<RowRemainder> = (0..self.len())
            .map(|i| changed_rest(&rest[i], &change, weight, i, self.areas[i]))
            .collect();
        let ratio = |i: usize, e: &Exchange| Some(change.ratio(variance(e), i, e));
        let mut moved = self.moved(ratio);
        for (i, moved) in moved.iter_mut().enumerate() {
            *moved += (rest[i].sky - self.rest[i].sky).abs();
            *moved += (rest[i].ground - self.rest[i].ground).abs();
        }
        self.scale(false, ratio);
        self.rest = rest;
        self.closed = Some(self.adjustment(&moved, &self.deficits()));
        Ok(())
    }

    /// Where no entry has an error, none could change by its own.
    fn closure_weights(&self) -> ClosureWeight {
        let has_error = |i| self.exchange.upper(i).iter().any(|e| e.error != 0.0);
        if (0..self.len()).any(has_error) {
            ClosureWeight::Errors
        } else {
            ClosureWeight::Values
        }
    }

    /// The deficit of each row, 1 less its sum; 0 for rows that see nothing.
    fn deficits(&self) -> Vec<f64> {
        let rows = self.ended().into_iter().zip(&self.rest);
        rows.map(|(ended, rest)| {
            if ended > 0.0 {
                1.0 - ended - rest.sum()
            } else {
                0.0
            }
        })
        .collect()
    }

    /// Σ_j |ΔX_ij| of every row, for a change that is about to be made.
    pub(super) fn moved(&self, ratio: impl Fn(usize, &Exchange) -> Option<f64> + Sync) -> Vec<f64> {
        let moved = |i: usize, e: &Exchange| {
            let ratio = ratio(i, e).unwrap_or(0.0);
            [e.value * (ratio - 1.0).abs(); 2]
        };
        self.per_area(self.exchange.sums(moved))
    }

    /// Statistics of a change, from what moved in each row and the remaining deficits.
    pub(super) fn adjustment(&self, moved: &[f64], deficits: &[f64]) -> Adjustment {
        let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let changed: f64 = moved.iter().zip(&self.areas).map(|(m, a)| m * a).sum();
        let whole: f64 = self.exchange.row_sums().iter().sum();
        Adjustment {
            total: if whole > 0.0 { changed / whole } else { 0.0 },
            mean: moved.iter().sum::<f64>() / self.len().max(1) as f64,
            most: largest(moved),
            deficit: largest(deficits),
        }
    }
}

/// How much of a change an entry takes.
#[derive(Clone, Copy)]
enum ClosureWeight {
    /// By its error; errors that are not a number are in proportion to the entries.
    Errors,
    /// In proportion to the entries: no error is known, as of matrices of other programs.
    Values,
}

impl ClosureWeight {
    fn variance(self, error: f64, value: f64) -> f64 {
        match self {
            ClosureWeight::Errors if !error.is_nan() => error.powi(2),
            _ => value.powi(2),
        }
    }
}

/// The same without escaped light so small that it must have leaked.
fn without_leaks(rest: &RowRemainder) -> RowRemainder {
    if rest.escaped() > LOSS {
        return *rest;
    }
    RowRemainder {
        sky: 0.0,
        sky_error: 0.0,
        ground: 0.0,
        ground_error: 0.0,
        ..*rest
    }
}

/// Sky and ground after the change.
fn changed_rest(
    rest: &RowRemainder,
    change: &SmoothingChange,
    weight: ClosureWeight,
    i: usize,
    area: f64,
) -> RowRemainder {
    let share = |value: f64, error: f64| {
        let added = change.beside(area * weight.variance(error, value), i);
        (value + added).max(LEAST * value)
    };
    RowRemainder {
        sky: share(rest.sky, rest.sky_error),
        ground: share(rest.ground, rest.ground_error),
        ..*rest
    }
}
