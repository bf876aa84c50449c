//! Where the light of rows goes that no column receives, by formulas.
//!
//! Without mirrors, a row's light that leaves upwards is the share of its hemisphere above the
//! horizon, (1 + cos β) / 2 for a facet tilted by β, less what columns above the horizon receive.
//! Columns are above it, below it, or cut by it, point by point; these are integrated again with
//! the horizon as one more edge. An unobstructed facet is therefore exact.

use super::PreparedPlan;
use super::matrix::{FormFactors, RowRemainder};
use crate::analytic_engine::exchanger::{Exchanger, Horizon, SplitRow};
use crate::row::Side;
use azulejo_trace::{Cancelled, Progress};

impl PreparedPlan<'_> {
    /// The remainders of rows that formulas know completely. Where no row lacks more than twice its
    /// error, beside what ends on sides that are no rows, the scene is closed.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn remainders(
        &self,
        factors: &FormFactors,
        exchanger: &Exchanger,
        progress: &Progress,
    ) -> Result<Vec<RowRemainder>, Cancelled> {
        let n = factors.len();
        let missing: Vec<f64> = factors.ended().iter().map(|ended| 1.0 - ended).collect();
        let most = factors.per_area(factors.exchange.sums(|_, e| [f64::from(e.error); 2]));
        let is_seeing: Vec<bool> = factors
            .exchange
            .row_lengths()
            .iter()
            .map(|&count| count > 0)
            .collect();
        let allowed = |i: usize| 2.0 * most[i] + ROUNDING + exchanger.crack(i);
        let lacks = |i: usize, share: f64| share > allowed(i);
        let is_short = |i: usize| lacks(i, missing[i]);
        let is_short_somewhere = (0..n).any(|i| is_seeing[i] && is_short(i));
        let rows: Vec<usize> = (0..n)
            .filter(|&i| missing[i] > ROUNDING && (is_short_somewhere || !is_seeing[i]))
            .collect();
        let up = self.plan.proxy.scene.units.up.axis();
        let hidden = exchanger.hidden_sides(|p, front| self.sides.column(p, front).is_some());
        let horizons: Vec<Horizon> = (0..n).map(|i| exchanger.horizon(i, up)).collect();
        let upward = factors.exchange.sums(|i, e| {
            let j = e.column as usize;
            [
                horizons[i].share_above(&horizons[j]) * e.value,
                horizons[j].share_above(&horizons[i]) * e.value,
            ]
        });
        let variance = factors
            .exchange
            .sums(|_, e| [f64::from(e.error).powi(2); 2]);
        let split = self.split(exchanger, &rows, &hidden, progress)?;
        let hidden_of =
            |i: usize, split: &SplitRow| (split.hidden / factors.areas[i]).min(missing[i]);
        let is_open = rows
            .iter()
            .zip(&split)
            .any(|(&i, split)| is_seeing[i] && lacks(i, missing[i] - hidden_of(i, split)));
        let mut remainders = vec![RowRemainder::default(); n];
        for (&i, split) in rows.iter().zip(split) {
            let area = factors.areas[i];
            let hidden = hidden_of(i, &split);
            if is_seeing[i] && !is_open {
                remainders[i].hidden = hidden;
                continue;
            }
            let rest = missing[i] - hidden;
            let above = horizons[i].sky() - (upward[i] + split.upward) / area;
            let sky = above.clamp(0.0, rest);
            let error = (variance[i] + split.variance).sqrt() / area;
            let error_of = |can: bool| if can { error } else { 0.0 };
            remainders[i] = RowRemainder {
                sky,
                sky_error: error_of(horizons[i].sky() > 0.0),
                ground: rest - sky,
                ground_error: error_of(horizons[i].sky() < 1.0),
                hidden,
                ..RowRemainder::default()
            };
        }
        Ok(remainders)
    }

    /// What the horizons of some rows cut; `hidden` are sides that are no rows and may be seen.
    fn split(
        &self,
        exchanger: &Exchanger,
        rows: &[usize],
        hidden: &[Side],
        progress: &Progress,
    ) -> Result<Vec<SplitRow>, Cancelled> {
        let up = self.plan.proxy.scene.units.up.axis();
        let n = self.sides.len();
        if hidden.is_empty() || rows.is_empty() {
            return exchanger.split_at_horizon(rows, up, n, progress);
        }
        let sides = (0..n).map(|row| self.sides.side(row));
        let all: Vec<Side> = sides.chain(hidden.iter().copied()).collect();
        self.exchanger(all, f64::INFINITY)
            .split_at_horizon(rows, up, n, progress)
    }
}

/// Shares below this are missing only by rounding.
const ROUNDING: f64 = 1e-12;
