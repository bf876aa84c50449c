//! Where the light of rows goes that no column receives, by formulas.
//!
//! Without mirrors, a row's light that leaves upwards is the share of its hemisphere above the
//! horizon, (1 + cos β) / 2 for a facet tilted by β, less what columns above the horizon receive.
//! Columns are above it, below it, or cut by it, point by point; these are integrated again with
//! the horizon as one more edge. An unobstructed facet is therefore exact.

use super::PreparedPlan;
use super::matrix::{FormFactors, RowRemainder};
use crate::analytic_engine::exchanger::{Exchanger, Horizon, SplitRow, UpwardSum};
use crate::row::Side;
use azulejo_trace::{Cancelled, Progress};

impl PreparedPlan<'_> {
    /// The remainders of rows that formulas know completely. Where no row lacks more than twice its
    /// error, apart from what ends on sides that are not rows, the scene is closed.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn remainders(
        &self,
        factors: &FormFactors,
        exchanger: &Exchanger,
        known: Option<&[UpwardSum]>,
        progress: &Progress,
    ) -> Result<Vec<RowRemainder>, Cancelled> {
        // Which rows lack something: none of those that see anything, if all of them lack no more than their errors.
        let n = factors.len();
        let missing: Vec<f64> = factors.ended().iter().map(|ended| 1.0 - ended).collect();
        let errors = factors.per_area(factors.exchange.sums(|_, e| [f64::from(e.error); 2]));
        let lengths = factors.exchange.row_lengths();
        let is_seeing: Vec<bool> = lengths.iter().map(|&count| count > 0).collect();
        let lacks = |i: usize, share: f64| share > 2.0 * errors[i] + ROUNDING + exchanger.crack(i);
        let is_short_somewhere = (0..n).any(|i| is_seeing[i] && lacks(i, missing[i]));
        let rows: Vec<usize> = (0..n)
            .filter(|&i| missing[i] > ROUNDING && (is_short_somewhere || !is_seeing[i]))
            .collect();
        // What columns above the horizon receive, and what the horizon cuts.
        let up = self.plan.proxy.scene.units.up.axis();
        let hidden = exchanger.hidden_sides(|p, front| self.sides.column(p, front).is_some());
        let horizons: Vec<Horizon> = (0..n).map(|i| exchanger.horizon(i, up)).collect();
        let upward = upward(factors, &horizons);
        let variance = factors
            .exchange
            .sums(|_, e| [f64::from(e.error).powi(2); 2]);
        let split = self.split(exchanger, &rows, &hidden, known.is_some(), progress)?;
        let hidden_share =
            |i: usize, split: &SplitRow| (split.hidden / factors.areas[i]).min(missing[i]);
        // The scene is open if a row lacks more than what hidden sides explain.
        let lacks_more = |(&i, split): (&usize, &SplitRow)| {
            is_seeing[i] && lacks(i, missing[i] - hidden_share(i, split))
        };
        let is_open = rows.iter().zip(&split).any(lacks_more);
        let mut remainders = vec![RowRemainder::default(); n];
        for (&i, split) in rows.iter().zip(split) {
            let (area, hidden) = (factors.areas[i], hidden_share(i, &split));
            let mut remainder = RowRemainder::default();
            if !is_seeing[i] || is_open {
                let cut = known.map_or(UpwardSum::default(), |known| known[i]);
                let above = horizons[i].sky() - (upward[i] + cut.value + split.upward) / area;
                let error = (variance[i] + cut.variance + split.variance).sqrt() / area;
                remainder = escaped(missing[i] - hidden, above, error, horizons[i].sky());
            }
            remainders[i] = RowRemainder {
                hidden,
                hidden_error: if hidden > 0.0 {
                    split.variance.sqrt() / area
                } else {
                    0.0
                },
                ..remainder
            };
        }
        Ok(remainders)
    }

    /// What the horizons of some rows cut; `hidden` are sides that are not rows and may be seen.
    fn split(
        &self,
        exchanger: &Exchanger,
        rows: &[usize],
        hidden: &[Side],
        is_cut_known: bool,
        progress: &Progress,
    ) -> Result<Vec<SplitRow>, Cancelled> {
        let up = self.plan.proxy.scene.units.up.axis();
        let n = self.sides.len();
        if hidden.is_empty() && is_cut_known {
            return Ok(vec![SplitRow::default(); rows.len()]);
        }
        if hidden.is_empty() || rows.is_empty() {
            return exchanger.split_at_horizon(rows, up, n, is_cut_known, progress);
        }
        let sides = (0..n).map(|row| self.sides.side(row));
        let sides: Vec<Side> = sides.chain(hidden.iter().copied()).collect();
        self.exchanger(sides, f64::INFINITY)
            .split_at_horizon(rows, up, n, is_cut_known, progress)
    }
}

/// What each row sends to columns above its horizon, times its area.
fn upward(factors: &FormFactors, horizons: &[Horizon]) -> Vec<f64> {
    factors.exchange.sums(|i, e| {
        let j = e.column as usize;
        [(i, j), (j, i)].map(|(from, to)| horizons[from].share_above(&horizons[to]) * e.value)
    })
}

/// A share of a row's light that leaves the scene: upwards as much as goes `above` the horizon, the rest
/// downwards. What the row cannot see, by the share of its hemisphere in the `sky`, has no error.
fn escaped(share: f64, above: f64, error: f64, sky: f64) -> RowRemainder {
    let upwards = above.clamp(0.0, share);
    RowRemainder {
        sky: upwards,
        sky_error: if sky > 0.0 { error } else { 0.0 },
        ground: share - upwards,
        ground_error: if sky < 1.0 { error } else { 0.0 },
        ..RowRemainder::default()
    }
}

/// Shares below this are missing only by rounding.
const ROUNDING: f64 = 1e-12;
