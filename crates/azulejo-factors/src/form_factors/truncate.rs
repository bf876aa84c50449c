//! Truncation: a sparser matrix with the same row sums.

use super::matrix::{FormFactors, Truncation};
use super::smoothing::{LEAST, Smoothing};
use crate::exchange_areas::Exchange;
use azulejo_trace::{Cancelled, Progress};

/// Tolerated deficit of a row sum, relative to 1: rounding.
const TOLERANCE: f64 = 1e-13;

/// Attempts to find the rows that cannot do without their small entries.
const ATTEMPTS: usize = 30;

impl FormFactors {
    /// Drops pairs whose form factor is below `share` in both directions, and moves their weight
    /// onto the pairs that stay, so that every row's Σ_j X_ij `ends`_j (without mirrors the row's
    /// sum) is unchanged to rounding and reciprocity still holds. What moves is added to the
    /// standard errors. Rows that have only small entries, or whose weight has nowhere to go, keep
    /// them.
    ///
    /// # Errors
    /// [`Cancelled`]; the matrix is as before then.
    pub fn truncate(&mut self, share: f64, progress: &Progress) -> Result<(), Cancelled> {
        let areas = self.areas.clone();
        let small =
            |i: usize, e: &Exchange| e.value < share * areas[i].min(areas[e.column as usize]);
        let large = self
            .exchange
            .sums(|i, e| [f64::from(u8::from(!small(i, e))); 2]);
        // Rows that keep all their entries.
        let mut whole: Vec<bool> = large.iter().map(|&n| n == 0.0).collect();
        for _ in 0..ATTEMPTS {
            let drops =
                |i: usize, e: &Exchange| small(i, e) && !whole[i] && !whole[e.column as usize];
            let variance = |i: usize, e: &Exchange| if drops(i, e) { 0.0 } else { e.value };
            let smoothing = Smoothing {
                exchange: &self.exchange,
                variance,
                weights: &self.ends,
                free: vec![0.0; self.len()],
                deficits: self.weighted(|i, e| if drops(i, e) { e.value } else { 0.0 }),
                tolerated: areas.iter().map(|a| a * TOLERANCE).collect(),
            };
            let change = smoothing.solve(progress)?;
            let ratio =
                |i: usize, e: &Exchange| (!drops(i, e)).then(|| change.ratio(variance(i, e), i, e));
            let unbalanced_rows = self.unbalanced_rows(ratio);
            if unbalanced_rows.iter().all(|fails| !fails) {
                self.apply_truncation(ratio);
                return Ok(());
            }
            whole
                .iter_mut()
                .zip(unbalanced_rows)
                .for_each(|(w, fails)| *w |= fails);
        }
        self.apply_truncation(|_, _| Some(1.0));
        Ok(())
    }

    /// Rows whose sum a change would alter, or whose entries it would reduce to the least allowed
    /// value.
    fn unbalanced_rows(&self, ratio: impl Fn(usize, &Exchange) -> Option<f64> + Sync) -> Vec<bool> {
        let kept_ratio = |i: usize, e: &Exchange| ratio(i, e).unwrap_or(0.0);
        let off = self.weighted(|i, e| e.value * (kept_ratio(i, e) - 1.0));
        let is_least = |i: usize, e: &Exchange| ratio(i, e).is_some_and(|r| r <= LEAST);
        let least = self
            .exchange
            .sums(|i, e| [f64::from(u8::from(is_least(i, e))); 2]);
        (0..self.len())
            .map(|i| off[i].abs() > 10.0 * TOLERANCE * self.areas[i] || least[i] > 0.0)
            .collect()
    }

    /// Σ_j f(i, S_ij) `ends`_j of every row.
    fn weighted(&self, f: impl Fn(usize, &Exchange) -> f64 + Sync) -> Vec<f64> {
        let ends = &self.ends;
        self.exchange.sums(|i, e| {
            let value = f(i, e);
            [value * ends[e.column as usize], value * ends[i]]
        })
    }

    /// Applies the change and records it.
    fn apply_truncation(&mut self, ratio: impl Fn(usize, &Exchange) -> Option<f64> + Sync) {
        let before = self.exchange.entries();
        let dropped = |i: usize, e: &Exchange| if ratio(i, e).is_none() { e.value } else { 0.0 };
        let dropped: f64 = self.exchange.sums(|i, e| [dropped(i, e); 2]).iter().sum();
        let whole: f64 = self.exchange.row_sums().iter().sum();
        let moved = self.moved(&ratio);
        let sums = self.ended();
        self.scale(true, ratio);
        let deficits: Vec<f64> = sums.iter().zip(self.ended()).map(|(a, b)| a - b).collect();
        self.truncated = Some(Truncation {
            before,
            after: self.exchange.entries(),
            dropped: if whole > 0.0 { dropped / whole } else { 0.0 },
            moved: self.adjustment(&moved, &deficits),
        });
        self.update_row_errors();
    }
}
