//! Enforcing closure: rows changed within their errors so that no light is missing.

use super::matrix::{Adjustment, FormFactors, RowRemainder};
use super::smoothing::{LEAST, Smoothing, SmoothingChange};
use crate::exchange_areas::Exchange;
use azulejo_trace::{Cancelled, Progress};

/// Tolerated deficit of a row's sum.
const TOLERANCE: f64 = 1e-9;

/// Deficits above this, which exact entries or those at their least left, are spread over all entries.
const LEFT: f64 = 1e-7;

/// Deficits above this do not come from errors: light that ends at an unknown place stays missing.
const MISSING: f64 = 1e-3;

/// Least standard error of an entry, as a share of its value, where deficits are left.
const SPREAD: f64 = 1e-3;

/// Most times that deficits are spread: each time entries at their least start from there.
const SPREADS: usize = 4;

/// Most that a row may move: the first number times the sum of its errors, and the second times the worst deficit.
/// A row that would move further sees only what cannot be reconciled with it.
const MOST_MOVED: (f64, f64) = (4.0, 30.0);

/// Share of a row's light that a closed scene may lose: rays through cracks.
const LOSS: f64 = 1e-6;

/// The note on rows that no closure reconciles.
pub const NOT_RECONCILED: &str = "rows were not closed, because some would move by many times their errors: they see \
                                  only each other, or count light twice";

impl FormFactors {
    /// Whether no row that sees anything loses light. Rows that see nothing are the outside of a
    /// closed room.
    pub(super) fn loses_no_light(&self) -> bool {
        let lengths = self.exchange.row_lengths();
        self.seeing_lose_no_light(|i| lengths[i] > 0)
    }

    /// The same where the matrix is elsewhere, which says which rows see anything.
    pub(crate) fn seeing_lose_no_light(&self, sees: impl Fn(usize) -> bool) -> bool {
        let mut seeing = (0..self.len()).filter(|&i| sees(i)).peekable();
        seeing.peek().is_some() && seeing.all(|i| self.rest[i].escaped() <= LOSS)
    }

    /// Enforces closure: makes Σ_j X_ij `ends`_j and the shares of `rest` sum to 1 in every row by
    /// the smallest change of exchange areas and of the shares of sky, ground and hidden sides, weighted by
    /// their standard errors, or by their values where no entry has an error. Light that leaked through
    /// cracks of a closed scene is put back first. Where exact
    /// entries leave no room for that, all entries of rows that lack 0.1% or less give way as if their
    /// errors were at least 0.1%.
    /// [`closed`](FormFactors::closed) records how much was moved; standard errors stay as they
    /// were.
    ///
    /// Rows without an entry or share that could change stay as they are, no entry falls below a tenth of
    /// its value at a time, and two halves that see only each other may have sums that no change
    /// reconciles: [`Adjustment::deficit`] is what a row lacks then. Where a row would move by far more than
    /// its errors and all deficits explain, nothing is changed, and the notes of the engine say so.
    ///
    /// # Errors
    /// [`Cancelled`]; what was changed by then stays changed.
    pub fn close(&mut self, progress: &Progress) -> Result<(), Cancelled> {
        self.put_back_leaks();
        let Some(mut moved) = self.close_within(self.closure_weight(), progress)? else {
            self.engine_used.notes.push(NOT_RECONCILED.to_owned());
            return Ok(());
        };
        for _ in 0..SPREADS {
            let is_left = |d: &f64| (LEFT..=MISSING).contains(&d.abs());
            if !self.residuals().iter().any(is_left) {
                break;
            }
            let weight = ClosureWeight::Errors { least: SPREAD };
            let Some(more) = self.close_within(weight, progress)? else {
                break;
            };
            moved.iter_mut().zip(more).for_each(|(m, more)| *m += more);
        }
        self.closed = Some(self.adjustment(&moved, &self.residuals()));
        Ok(())
    }

    /// Removes escaped light so small that it must have leaked, and all of it from rows that see anything of a
    /// closed scene.
    fn put_back_leaks(&mut self) {
        let lengths = self.exchange.row_lengths();
        for (rest, length) in self.rest.iter_mut().zip(lengths) {
            if rest.escaped() <= LOSS || self.is_closed && length > 0 {
                (rest.sky, rest.sky_error) = (0.0, 0.0);
                (rest.ground, rest.ground_error) = (0.0, 0.0);
            }
        }
    }

    /// Where no entry has an error, none could change by its own.
    fn closure_weight(&self) -> ClosureWeight {
        let has_error = |i| self.exchange.upper(i).iter().any(|e| e.error != 0.0);
        if (0..self.len()).any(has_error) {
            ClosureWeight::Errors { least: 0.0 }
        } else {
            ClosureWeight::Values
        }
    }

    /// One smoothing; returns Σ_j |ΔX_ij| of each row, with sky, ground and hidden sides. `None`, and nothing is
    /// changed, if a row would move too far.
    fn close_within(
        &mut self,
        weight: ClosureWeight,
        progress: &Progress,
    ) -> Result<Option<Vec<f64>>, Cancelled> {
        let change = self.smoothing(weight).solve(progress)?;
        // How far it would move each row, which has to agree with the row's errors.
        let changed = |i| changed_rest(&self.rest[i], weight, &change, i, self.areas[i]);
        let rest: Vec<RowRemainder> = (0..self.len()).map(changed).collect();
        let variance = |e: &Exchange| weight.variance(f64::from(e.error), e.value);
        let ratio = |i: usize, e: &Exchange| Some(change.ratio(variance(e), i, e));
        let mut moved = self.moved(ratio);
        for (i, moved) in moved.iter_mut().enumerate() {
            *moved += (rest[i].sky - self.rest[i].sky).abs();
            *moved += (rest[i].ground - self.rest[i].ground).abs();
            *moved += (rest[i].hidden - self.rest[i].hidden).abs();
        }
        let limits = self.movable();
        let is_too_far = |(moved, limit): (&f64, f64)| moved.is_nan() || *moved > limit;
        if moved.iter().zip(limits).any(is_too_far) {
            return Ok(None);
        }
        self.scale(false, ratio);
        self.rest = rest;
        Ok(Some(moved))
    }

    /// The smallest change that makes all rows complete.
    fn smoothing(
        &self,
        weight: ClosureWeight,
    ) -> Smoothing<'_, impl Fn(usize, &Exchange) -> f64 + Sync> {
        let (mut free, mut deficits) = (Vec::new(), Vec::new());
        for ((&a, rest), ended) in self.areas.iter().zip(&self.rest).zip(self.ended()) {
            let shares = [
                (rest.sky, rest.sky_error),
                (rest.ground, rest.ground_error),
                (rest.hidden, rest.hidden_error),
            ];
            let variances = shares.map(|(value, error)| a * a * weight.variance(error, value));
            free.push(variances.iter().sum());
            let lacks = 1.0 - rest.sum() - ended;
            let is_missing = weight.is_spread() && lacks.abs() > MISSING;
            deficits.push(if is_missing { 0.0 } else { a * lacks });
        }
        Smoothing {
            exchange: &self.exchange,
            variance: move |_, e: &Exchange| weight.variance(f64::from(e.error), e.value),
            weights: &self.ends,
            free,
            deficits,
            tolerated: self.areas.iter().map(|a| a * TOLERANCE).collect(),
        }
    }

    /// The largest Σ_j |ΔX_ij| of each row that its errors and the deficits explain.
    fn movable(&self) -> Vec<f64> {
        let worst = self
            .residuals()
            .iter()
            .fold(LEFT, |most: f64, d| most.max(d.abs()));
        let errors = self.exchange.sums(|_, e| [f64::from(e.error); 2]);
        let rows = self.per_area(errors).into_iter().zip(&self.rest);
        rows.map(|(errors, rest)| {
            let own = errors + rest.sky_error + rest.ground_error + rest.hidden_error;
            // Without known errors there is no limit.
            if own.is_nan() {
                return f64::INFINITY;
            }
            MOST_MOVED.0 * own + MOST_MOVED.1 * worst
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
#[derive(Clone, Copy, PartialEq)]
enum ClosureWeight {
    /// By its error, which is at least this share of its value; errors that are not a number are in
    /// proportion to the entries.
    Errors {
        /// The share.
        least: f64,
    },
    /// In proportion to the entries: no error is known, as of matrices of other programs.
    Values,
}

impl ClosureWeight {
    fn variance(self, error: f64, value: f64) -> f64 {
        match self {
            ClosureWeight::Errors { least } if !error.is_nan() => error.max(least * value).powi(2),
            _ => value.powi(2),
        }
    }

    /// Whether exact entries give way, too.
    fn is_spread(self) -> bool {
        matches!(self, ClosureWeight::Errors { least } if least > 0.0)
    }
}

/// Sky, ground and hidden sides after the change.
fn changed_rest(
    rest: &RowRemainder,
    weight: ClosureWeight,
    change: &SmoothingChange,
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
        hidden: share(rest.hidden, rest.hidden_error),
        ..*rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_trace::Progress;

    /// Three rows; the entries between the first two are exact.
    fn with_exact_entries(missing: f64) -> FormFactors {
        let entry = |column, value, error| Exchange {
            column,
            value,
            error,
        };
        FormFactors {
            exchange: [
                vec![entry(1, 0.5 - missing, 0.0), entry(2, 0.5 - missing, 0.0)],
                vec![entry(2, 0.5, 0.01)],
                vec![],
            ]
            .into_iter()
            .collect(),
            areas: vec![1.0; 3],
            rest: vec![RowRemainder::default(); 3],
            ends: vec![1.0; 3],
            ..FormFactors::default()
        }
    }

    /// A floor and a ceiling whose walls look away see only each other, and rounding keeps their rows from
    /// agreeing: F was 1.3e8.
    #[test]
    fn rows_that_cannot_be_reconciled_stay() {
        let entry = Exchange {
            column: 1,
            value: 0.34,
            error: 1e-9,
        };
        let rest = |hidden| RowRemainder {
            hidden,
            ..RowRemainder::default()
        };
        let mut factors = FormFactors {
            exchange: [vec![entry], vec![]].into_iter().collect(),
            areas: vec![1.0; 2],
            rest: vec![rest(0.66 - 1e-6), rest(0.66 + 1e-6)],
            ends: vec![1.0; 2],
            ..FormFactors::default()
        };
        factors.close(&Progress::new()).unwrap();
        assert!(
            (factors.get(0, 1).0 - 0.34).abs() < 1e-4,
            "{:?}",
            factors.get(0, 1)
        );
    }

    /// The first row has no error, and lacks something nevertheless.
    #[test]
    fn exact_entries_give_way_where_nothing_else_does() {
        let mut factors = with_exact_entries(1e-4);
        factors.close(&Progress::new()).unwrap();
        let closed = factors.closed.unwrap();
        assert!(closed.deficit < 1e-7, "{closed:?}");
        assert!(closed.most > 1e-4 && closed.most < 1e-3, "{closed:?}");
        // What lacks much lacks something else.
        let mut factors = with_exact_entries(0.1);
        factors.close(&Progress::new()).unwrap();
        let closed = factors.closed.unwrap();
        assert!((closed.deficit - 0.2).abs() < 1e-6, "{closed:?}");
        // What is right to the last digits stays.
        let mut factors = with_exact_entries(1e-9);
        let before = factors.get(0, 1);
        factors.close(&Progress::new()).unwrap();
        assert_eq!(factors.get(0, 1), before);
    }
}
