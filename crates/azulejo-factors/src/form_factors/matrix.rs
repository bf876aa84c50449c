//! The matrix, and what else is known of its rows.

use super::{DesignEffect, Exchange, ExchangeAreas};
use crate::engine::EngineUsed;
use crate::patch::FaceId;
use azulejo_scene::MaterialId;
use std::f64::consts::FRAC_2_PI;
use std::ops::Range;

/// The extended form factors X of a scene: X_ij is the share of the light leaving row i
/// diffusely that arrives at column j, directly or after any chain of mirrors and glass, with
/// its whole weight (additive model, Sillion and Puech 1989).
///
/// Rows and columns are the same list. Without `two_sided` it is the fronts of the patches, in
/// the order of [`Patches`](crate::Patches): light that meets a back ends there, unless it is
/// covered by a front (two patches in one place, back to back). With it, front and back of
/// patch p are entries 2p and 2p + 1. Where mirrors are coloured X is the mean of the three
/// channels.
///
/// Reciprocity is exact: one number S_ij is kept per pair, and X_ij is S_ij / A_i, rounded. It
/// holds for mirrors and for glass between equal media, so X is not defined where a patch lies
/// inside glass. Pairs are stored sparsely; one that is absent is an estimate of 0. X is not
/// negative, and at most 1 for patches that no mirror shows twice.
///
/// Nothing of a row's light is missing: Σ_j X_ij `ends`_j and the shares of `rest` sum to 1, but
/// for noise, which closure takes away.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FormFactors {
    /// S_ij = A_i X_ij of every pair, with its standard error: two to either side hold the truth
    /// 95 times in 100.
    pub exchange: ExchangeAreas,
    /// S of light that came straight, by one mirror, and by more mirrors or through glass, if
    /// that was asked for; else empty. Their sum, in this order, is `exchange` to the bit.
    pub orders: Vec<ExchangeAreas>,
    /// Area of each row, in square scene units.
    pub areas: Vec<f64>,
    /// The face that each row is a piece of; of a group, the face of its first row.
    pub faces: Vec<FaceId>,
    /// The material of each row; of a group, that of its first row.
    pub materials: Vec<MaterialId>,
    /// Whether each row is the back of its patch.
    pub is_back: Vec<bool>,
    /// Where the light of each row goes that meets no column.
    pub rest: Vec<RowRemainder>,
    /// Share of the light arriving at each column that ends there: 1 − ρ_s, 0 for glass.
    pub ends: Vec<f64>,
    /// Error to be expected of each row, Σ_j E|error of X_ij|: for normal errors √(2/π) times the
    /// sum of the standard errors. In rooms with known entries 1.2 to 1.3 times the true one.
    pub row_errors: Vec<f64>,
    /// What the errors of entries between two faces or objects have in common: of what is drawn
    /// from a handful of points they are all too large where these see more of it.
    pub design_effect: DesignEffect,
    /// Whether no row that sees anything loses light to the outside, but for 1e-6 of it.
    pub is_closed: bool,
    /// What closure moved, if there was one.
    pub closed: Option<Adjustment>,
    /// What truncation dropped and moved, if there was one.
    pub truncated: Option<Truncation>,
    /// Rays traced from patches, without those that mirrors and visibility tests added.
    pub rays: u64,
    /// Which engine ran.
    pub engine_used: EngineUsed,
}

/// Where the light of a row goes that meets no column: shares of 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RowRemainder {
    /// Leaves the scene upwards: the view factor of the sky.
    pub sky: f64,
    /// Standard error of `sky`.
    pub sky_error: f64,
    /// Leaves the scene downwards: the view factor of ground that is not modelled.
    pub ground: f64,
    /// Standard error of `ground`.
    pub ground_error: f64,
    /// Ends on sides which have no column: backs, without `two_sided`.
    pub hidden: f64,
    /// Was not followed to its end between mirrors: what was too weak.
    pub cut: f64,
    /// Is absorbed where there is no column: in coloured glass.
    pub lost: f64,
}

impl RowRemainder {
    /// Share that leaves the scene, upwards or downwards.
    pub fn escaped(&self) -> f64 {
        self.sky + self.ground
    }

    /// All of it.
    pub fn sum(&self) -> f64 {
        self.escaped() + self.hidden + self.cut + self.lost
    }
}

/// How much of the light was moved between the entries of a matrix to make its rows add up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Adjustment {
    /// Σ|ΔS_ij| / ΣS_ij over the whole matrix.
    pub total: f64,
    /// Mean over the rows of Σ_j |ΔX_ij|, what moved to or from sky and ground included.
    pub mean: f64,
    /// The same of the row with the most.
    pub most: f64,
    /// What the sum of the worst row still lacks.
    pub deficit: f64,
}

/// What truncation did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truncation {
    /// Entries of the whole matrix before.
    pub before: usize,
    /// Entries of the whole matrix now.
    pub after: usize,
    /// Share of the matrix' sum that the dropped entries had.
    pub dropped: f64,
    /// How the kept entries changed for it.
    pub moved: Adjustment,
}

/// Entries that are looked at together where whole rows are wanted: 64 MiB of them.
const BLOCK: usize = 1 << 22;

impl FormFactors {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Column, X and standard error of each entry of row `i`, columns ascending. Searches all
    /// rows above: [`rows`](FormFactors::rows) finds many at once.
    ///
    /// # Panics
    /// Without such a row.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (u32, f64, f32)> {
        self.rows(i..i + 1).into_iter().flatten()
    }

    /// Column, X and standard error of the entries of some rows, columns ascending.
    ///
    /// # Panics
    /// If the range goes beyond the last row.
    pub fn rows(&self, range: Range<usize>) -> Vec<Vec<(u32, f64, f32)>> {
        self.factors(&self.exchange, range)
    }

    /// The same of one of the [`orders`](FormFactors::orders).
    ///
    /// # Panics
    /// If the orders were not kept apart, or the range goes beyond the last row.
    pub fn rows_of_order(&self, order: usize, range: Range<usize>) -> Vec<Vec<(u32, f64, f32)>> {
        self.factors(&self.orders[order], range)
    }

    fn factors(&self, areas: &ExchangeAreas, range: Range<usize>) -> Vec<Vec<(u32, f64, f32)>> {
        let rows = areas.rows(range.clone());
        let factors = |(i, row): (usize, Vec<Exchange>)| {
            let factor = |e: Exchange| {
                let (value, error) = self.factor(i, e);
                (e.column, value, error)
            };
            row.into_iter().map(factor).collect()
        };
        range.zip(rows).map(factors).collect()
    }

    /// Ranges of rows, in order, each of a few million entries: as much as
    /// [`rows`](FormFactors::rows) should be asked for at a time.
    pub fn blocks(&self) -> Vec<Range<usize>> {
        let (mut blocks, mut start, mut entries) = (Vec::new(), 0, 0);
        for (i, length) in self.exchange.row_lengths().iter().enumerate() {
            entries += length;
            if entries >= BLOCK || i + 1 == self.len() {
                blocks.push(start..i + 1);
                (start, entries) = (i + 1, 0);
            }
        }
        blocks
    }

    /// X_ij and its standard error; zeros if the pair is absent.
    ///
    /// # Panics
    /// Without a row of the smaller number.
    pub fn get(&self, i: usize, j: u32) -> (f64, f32) {
        self.factor(i, self.exchange.get(i, j as usize))
    }

    /// Σ_j X_ij of every row. Without mirrors it is 1 less what goes elsewhere, but for noise,
    /// which closure takes away. With mirrors that is Σ_j X_ij `ends`_j
    /// ([`ended`](FormFactors::ended)), so that the plain sum exceeds 1.
    pub fn row_sums(&self) -> Vec<f64> {
        self.per_area(self.exchange.row_sums())
    }

    /// Σ_j X_ij `ends`_j of every row: the share of its light that ends on columns. With
    /// [`RowRemainder::sum`] it makes 1.
    pub fn ended(&self) -> Vec<f64> {
        let ends = &self.ends;
        let weigh = |i: usize, e: &Exchange| [e.value * ends[e.column as usize], e.value * ends[i]];
        self.per_area(self.exchange.sums(weigh))
    }

    /// Sums of rows over their areas; 0 for groups without rows.
    pub(super) fn per_area(&self, mut sums: Vec<f64>) -> Vec<f64> {
        let rows = sums.iter_mut().zip(&self.areas);
        rows.for_each(|(sum, &area)| *sum = if area > 0.0 { *sum / area } else { 0.0 });
        sums
    }

    /// Multiplies S of each pair by `ratio`, drops it where that is `None`, and does the same to
    /// the orders. With `widen`, what changed is added to the errors.
    pub(super) fn scale(
        &mut self,
        widen: bool,
        ratio: impl Fn(usize, &Exchange) -> Option<f64> + Sync,
    ) {
        let change = |e: &mut Exchange, ratio: Option<f64>| {
            let Some(ratio) = ratio else {
                return false;
            };
            let value = e.value * ratio;
            if widen {
                e.error = e.error.hypot((value - e.value) as f32);
            }
            e.value = value;
            true
        };
        if self.orders.is_empty() {
            self.exchange.retain(|i, e| change(e, ratio(i, e)));
            return;
        }
        for order in &mut self.orders {
            order.retain(|i, e| {
                let whole = self.exchange.get(i, e.column as usize);
                change(e, ratio(i, &whole))
            });
        }
        self.exchange = ExchangeAreas::sum_of(&self.orders);
    }

    /// Works out what depends on the entries' errors alone.
    pub(super) fn find_row_errors(&mut self) {
        let expected = |e: &Exchange| FRAC_2_PI.sqrt() * f64::from(e.error);
        self.row_errors = self.per_area(self.exchange.sums(|_, e| [expected(e); 2]));
    }

    fn factor(&self, i: usize, e: Exchange) -> (f64, f32) {
        let area = self.areas[i];
        (e.value / area, (f64::from(e.error) / area) as f32)
    }
}
