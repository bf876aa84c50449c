//! The matrix of form factors, with what is known of its rows.

use super::spread::{PAIR_FREEDOM, student};
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
/// Rows and columns are the same list: without `two_sided` the fronts of the patches, in the order
/// of [`Patches`](crate::Patches). Light that hits a back ends there, unless a front covers it (two
/// coinciding patches, back to back). With `two_sided`, front and back of patch p are entries 2p
/// and 2p + 1. Where mirrors are coloured, X is the mean of the three channels.
///
/// Reciprocity is exact: one number S_ij is stored per pair, and X_ij is S_ij / A_i, rounded. It
/// holds for mirrors and for glass between equal media, so X is not defined for patches inside
/// glass. Storage is sparse; an absent pair is an estimate of 0. X is not negative, and at most 1
/// for patches that no mirror shows twice.
///
/// Rows are complete: Σ_j X_ij `ends`_j and the shares of `rest` sum to 1, apart from noise, which
/// closure removes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FormFactors {
    /// S_ij = A_i X_ij of every pair, with its standard error: the truth lies within two of them 95
    /// times in 100.
    pub exchange: ExchangeAreas,
    /// S of direct light, of light by one mirror, and of light by more mirrors or through glass, if
    /// requested; else empty. Their sum, in this order, is `exchange` to the bit.
    pub orders: Vec<ExchangeAreas>,
    /// Area of each row, in square scene units.
    pub areas: Vec<f64>,
    /// The face that each row is a piece of; of a group, the face of its first row.
    pub faces: Vec<FaceId>,
    /// The material of each row; of a group, that of its first row.
    pub materials: Vec<MaterialId>,
    /// Whether each row is the back of its patch.
    pub is_back: Vec<bool>,
    /// Shares of each row's light that reach no column.
    pub rest: Vec<RowRemainder>,
    /// Share of the light arriving at each column that ends there: 1 − ρ_s, 0 for glass.
    pub ends: Vec<f64>,
    /// Expected error of each row, Σ_j E|error of X_ij|, with sky and ground: √(2/π) times the sum of
    /// the standard errors, for normal errors, and what went [`unseen`](FormFactors::unseen); at least what
    /// the row lacks of 1 or has too much. By rays, 0.95 to 1.25 times the true one, in a cube of 384 patches
    /// and rooms like it.
    pub row_errors: Vec<f64>,
    /// The share of each row's light that goes to columns which no ray found, as expected from those
    /// that a single ray found: the estimate of unseen mass of Good, *The population frequencies of
    /// species and the estimation of population parameters*, Biometrika 40, 1953, attributed to
    /// Turing. Empty for matrices without rays, and for groups.
    pub unseen: Vec<f64>,
    /// Correlation of the errors of entries between two faces or objects, where rows are rendered
    /// from a handful of viewpoints.
    pub design_effect: DesignEffect,
    /// Whether no row that sees anything loses more than 1e-6 of its light to the outside.
    pub is_closed: bool,
    /// What closure changed, if it was enforced.
    pub closed: Option<Adjustment>,
    /// What truncation changed, if there was one.
    pub truncated: Option<Truncation>,
    /// Rays traced from patches, without those added by mirrors and visibility tests.
    pub rays: u64,
    /// The engine that ran.
    pub engine_used: EngineUsed,
}

/// Shares of a row's light that reach no column.
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
    /// Ends on sides without a column: backs, without `two_sided`.
    pub hidden: f64,
    /// Standard error of `hidden`.
    pub hidden_error: f64,
    /// Cut off between mirrors as too weak.
    pub cut: f64,
    /// Absorbed where there is no column: by coloured glass.
    pub lost: f64,
}

impl RowRemainder {
    /// Share that leaves the scene, upwards or downwards.
    pub fn escaped(&self) -> f64 {
        self.sky + self.ground
    }

    /// All shares and errors, in the order of the fields.
    pub(crate) fn to_array(self) -> [f64; 8] {
        let RowRemainder {
            sky,
            sky_error,
            ground,
            ground_error,
            hidden,
            hidden_error,
            cut,
            lost,
        } = self;
        [
            sky,
            sky_error,
            ground,
            ground_error,
            hidden,
            hidden_error,
            cut,
            lost,
        ]
    }

    /// The inverse of [`to_array`](RowRemainder::to_array).
    pub(crate) fn from_array(shares: [f64; 8]) -> RowRemainder {
        let [
            sky,
            sky_error,
            ground,
            ground_error,
            hidden,
            hidden_error,
            cut,
            lost,
        ] = shares;
        RowRemainder {
            sky,
            sky_error,
            ground,
            ground_error,
            hidden,
            hidden_error,
            cut,
            lost,
        }
    }

    /// All shares and errors times `factor`.
    pub(super) fn scaled(self, factor: f64) -> RowRemainder {
        RowRemainder::from_array(self.to_array().map(|part| part * factor))
    }

    /// The sum of all shares.
    pub fn sum(&self) -> f64 {
        self.escaped() + self.hidden + self.cut + self.lost
    }

    /// The sum of the standard errors of all shares.
    fn error(&self) -> f64 {
        self.sky_error + self.ground_error + self.hidden_error
    }
}

/// How much of the light was moved between entries to correct row sums.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Adjustment {
    /// Σ|ΔS_ij| / ΣS_ij over the whole matrix.
    pub total: f64,
    /// Mean over the rows of Σ_j |ΔX_ij|, including changes of sky, ground and hidden sides.
    pub mean: f64,
    /// The largest Σ_j |ΔX_ij| of a row.
    pub most: f64,
    /// The remaining deficit of the worst row.
    pub deficit: f64,
}

/// Statistics of a truncation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truncation {
    /// Entries of the whole matrix before.
    pub before: usize,
    /// Entries of the whole matrix after.
    pub after: usize,
    /// Share of the matrix's sum in the dropped entries.
    pub dropped: f64,
    /// How the remaining entries changed.
    pub moved: Adjustment,
}

/// Entries per block of whole rows: 8 MiB, and as much again while they are assembled.
const BLOCK: usize = 1 << 19;

/// Bytes that a block of whole rows takes while it is written, of a matrix with this many entries.
pub(super) fn block_bytes(entries: f64, rows: f64) -> f64 {
    let most = BLOCK as f64 + entries / rows.max(1.0);
    // Lists grow by doubling.
    2.0 * 2.0 * 16.0 * entries.min(most)
}

/// What the sum of a row may have too much: this many times the sum of its standard errors, and what slivers and small
/// overlaps add.
const FREEDOM: (f64, f64) = (2.0, 0.1);

/// By how much the sum of a row may be off, of this sum of standard errors and by this many rays, if any.
pub(super) fn row_freedom(errors: f64, rays: f64) -> f64 {
    // A handful of rays do not know how far off they are.
    let few = if rays > 0.0 {
        rays.max(1.0).sqrt().recip()
    } else {
        0.0
    };
    FREEDOM.1 + FREEDOM.0 * (errors + few)
}

impl FormFactors {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Column, X and standard error of each entry of row `i`, columns ascending. Searches all rows
    /// above: [`rows`](FormFactors::rows) is faster for many rows.
    ///
    /// # Panics
    /// If there is no such row.
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
    /// If the orders were not kept separately, or the range goes beyond the last row.
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

    /// Ranges of rows, in order, each of a few million entries: a good amount to request from
    /// [`rows`](FormFactors::rows) at a time.
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
    /// If there is no row with the smaller index.
    pub fn get(&self, i: usize, j: u32) -> (f64, f32) {
        self.factor(i, self.exchange.get(i, j as usize))
    }

    /// Σ_j X_ij of every row. Without mirrors it is 1 less the shares of `rest`, apart from noise.
    /// With mirrors the plain sum exceeds 1, and [`ended`](FormFactors::ended) is the sum that
    /// closes.
    pub fn row_sums(&self) -> Vec<f64> {
        self.per_area(self.exchange.row_sums())
    }

    /// Σ_j X_ij `ends`_j of every row: the share of its light that ends on columns. Together with
    /// [`RowRemainder::sum`] it is 1.
    pub fn ended(&self) -> Vec<f64> {
        let ends = &self.ends;
        let ended = |i: usize, e: &Exchange| [e.value * ends[e.column as usize], e.value * ends[i]];
        self.per_area(self.exchange.sums(ended))
    }

    /// Sums of rows over their areas; 0 for groups without rows.
    pub(super) fn per_area(&self, mut sums: Vec<f64>) -> Vec<f64> {
        let rows = sums.iter_mut().zip(&self.areas);
        rows.for_each(|(sum, &area)| *sum = if area > 0.0 { *sum / area } else { 0.0 });
        sums
    }

    /// Multiplies S of each pair by `ratio`, or drops it where that is `None`, in the orders too.
    /// With `widen` the change is added to the errors.
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

    /// Computes `row_errors` from the errors of entries, sky and ground, and from `unseen`.
    pub(super) fn update_row_errors(&mut self) {
        // Standard errors by rays are widened for intervals; an expectation is not.
        let widening = if self.unseen.is_empty() {
            1.0
        } else {
            student(PAIR_FREEDOM)
        };
        let share = FRAC_2_PI.sqrt() / widening;
        let expected = |e: &Exchange| share * f64::from(e.error);
        self.row_errors = self.per_area(self.exchange.sums(|_, e| [expected(e); 2]));
        for (error, rest) in self.row_errors.iter_mut().zip(&self.rest) {
            *error += share * (rest.sky_error + rest.ground_error);
        }
        // Pairs that no ray found are zeros without an error, and off by their whole value.
        let rows = self.row_errors.iter_mut().zip(&self.unseen);
        rows.for_each(|(error, unseen)| *error += unseen);
        let residuals = self.residuals();
        for (error, residual) in self.row_errors.iter_mut().zip(&residuals) {
            // What is unknown stays unknown.
            if residual.abs() > *error {
                *error = residual.abs();
            }
        }
    }

    /// Standard error of the sum of each row, if entries erred by themselves.
    pub fn noise_of_sums(&self) -> Vec<f64> {
        let variances = self.exchange.sums(|_, e| [f64::from(e.error).powi(2); 2]);
        let errors = variances.iter().map(|v| v.sqrt()).collect();
        self.per_area(errors)
    }

    /// What each row lacks of 1, with the shares of `rest`: negative if it has too much, 0 if it sees nothing.
    pub fn residuals(&self) -> Vec<f64> {
        let rows = self.ended().into_iter().zip(&self.rest);
        let residual = |(ended, rest): (f64, &RowRemainder)| {
            if ended > 0.0 {
                1.0 - ended - rest.sum()
            } else {
                0.0
            }
        };
        rows.map(residual).collect()
    }

    /// The row that violates most what holds for all factors, and its sum: that none is negative (compressed ones may be
    /// by a little), and that no row has more than all of its light, apart from errors. `None` if all is well. Sums with
    /// mirrors are not judged, because they may be coloured.
    pub fn impossible_row(&self) -> Option<(usize, f64)> {
        let errors = self.exchange.sums(|_, e| [f64::from(e.error); 2]);
        let errors = self.per_area(errors).into_iter().zip(&self.rest);
        let errors = errors.map(|(entries, rest)| entries + rest.error());
        let rows = self.residuals().into_iter().zip(errors);
        let rays_per_row = self.rays as f64 / self.len().max(1) as f64;
        let excess = rows.map(|(residual, errors)| -residual - row_freedom(errors, rays_per_row));
        let worst = excess.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        let worst = worst.filter(|_| self.ends.iter().all(|&ends| ends == 1.0));
        let is_negative = |&i: &usize| {
            let least = -FREEDOM.1 * self.areas[i];
            let mut entries = self.exchange.upper(i).iter();
            entries.any(|e| e.value.is_nan() || e.value < least)
        };
        let negative = (0..self.len()).find(is_negative);
        let row = negative.or(worst.filter(|(_, excess)| *excess > 0.0).map(|(i, _)| i))?;
        Some((row, 1.0 - self.residuals()[row]))
    }

    fn factor(&self, i: usize, e: Exchange) -> (f64, f32) {
        let area = self.areas[i];
        (e.value / area, (f64::from(e.error) / area) as f32)
    }
}
