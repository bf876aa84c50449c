//! Operations of thermal engineering: masks, rows scaled to given sums, grey interchange.

use super::matrix::{Adjustment, FormFactors, RowRemainder};
use crate::cholesky::{Cholesky, dot};
use crate::exchange_areas::{Exchange, ExchangeAreas};
use azulejo_trace::{Cancelled, Progress};
use rayon::prelude::*;
use std::fmt;

/// How well the scaling of rows converged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scaled {
    /// Sweeps over all rows.
    pub sweeps: usize,
    /// Largest error of a row's sum in the last sweep.
    pub error: f64,
    /// How much was moved.
    pub moved: Adjustment,
}

/// Why there are no grey interchange factors.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InterchangeError {
    /// The caller cancelled.
    Cancelled,
    /// Light would grow from reflection to reflection: the rows up to this one sum to more than one
    /// over their reflectances.
    Grows {
        /// The row, from 0.
        row: usize,
    },
}

impl fmt::Display for InterchangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            InterchangeError::Cancelled => write!(f, "cancelled"),
            InterchangeError::Grows { row } => write!(
                f,
                "row {} sums to so much more than 1 that light grows from reflection to \
                 reflection: ask for more rays, or scale the rows of an enclosure",
                row + 1
            ),
        }
    }
}

impl std::error::Error for InterchangeError {}

impl From<Cancelled> for InterchangeError {
    fn from(_: Cancelled) -> InterchangeError {
        InterchangeError::Cancelled
    }
}

/// The largest error of a row's sum at which scaling ends.
const TOLERANCE: f64 = 1e-7;

impl FormFactors {
    /// Makes row `mask`, a surface of this area that has seen nothing so far, cover a part of row
    /// `base` that is not in its area yet: the two see each other, and the base grows by `area`,
    /// which is positive.
    ///
    /// # Panics
    /// If there are no such rows.
    pub fn cover(&mut self, mask: usize, base: usize, area: f64) {
        let whole = self.areas[base] + area;
        self.rest[base] = self.rest[base].scaled(self.areas[base] / whole);
        self.areas[base] = whole;
        self.areas[mask] += area;
        self.exchange.add(mask.min(base), mask.max(base), area);
        self.update_row_errors();
    }

    /// Scales rows and columns until row i sums to `targets[i]`, as View3D does: sweeps over all
    /// rows scale each row and its column, until no sum of a sweep is off by more than 1e-7, or
    /// after `most` sweeps. Reciprocity is kept, and so are standard errors. Rows that see nothing
    /// stay.
    ///
    /// Takes 12 bytes per entry of the whole matrix. Meant for scenes without mirrors, because sums
    /// count all entries alike; the separate orders are dropped.
    ///
    /// # Errors
    /// [`Cancelled`]; the matrix is as before then.
    ///
    /// # Panics
    /// If the number of targets is not that of the rows.
    pub fn scale_rows(
        &mut self,
        targets: &[f64],
        most: usize,
        progress: &Progress,
    ) -> Result<Scaled, Cancelled> {
        assert_eq!(targets.len(), self.len(), "one target for each row");
        let rows = WholeRows::new(&self.exchange);
        let mut factors = vec![1.0; self.len()];
        let mut scaled = Scaled::default();
        progress.begin("scaling rows", most as u64);
        while scaled.sweeps < most {
            progress.advance(1)?;
            scaled.error = rows.sweep(&mut factors, &self.areas, targets);
            scaled.sweeps += 1;
            if scaled.error <= TOLERANCE {
                break;
            }
        }
        self.orders.clear();
        let ratio = |i: usize, e: &Exchange| Some(factors[i] * factors[e.column as usize]);
        let moved = self.moved(ratio);
        self.scale(false, ratio);
        let sums = self.row_sums();
        let deficits: Vec<f64> = sums.iter().zip(targets).map(|(s, t)| t - s).collect();
        scaled.moved = self.adjustment(&moved, &deficits);
        self.update_row_errors();
        Ok(scaled)
    }

    /// Grey interchange factors 𝓕 (Hottel's script-F): the share of a black surface's emission
    /// at the temperature of row i that row j absorbs, directly and after any number of diffuse
    /// reflections, with emissivities 0 < ε < 1. In an enclosure row i sums to ε_i.
    ///
    /// With S = A F and ρ = 1 − ε: K = diag(A/ρ) − S is positive definite, and A_i 𝓕_ij = v_i
    /// (K⁻¹)_ij v_j with v = Aε/ρ, less v_i ε_i on the diagonal. Standard errors are of first
    /// order, and up to √2 too large because the two halves of a pair have the same error. What a
    /// row emits less than a black one, 1 − ε, counts as [`lost`](RowRemainder::lost), so that sums
    /// are complete.
    ///
    /// Takes 24 bytes per entry of a full matrix, and time cubic in the number of rows.
    ///
    /// # Errors
    /// [`InterchangeError`].
    ///
    /// # Panics
    /// If the number of emissivities is not that of the rows.
    pub fn interchange(
        &self,
        emissivities: &[f64],
        progress: &Progress,
    ) -> Result<FormFactors, InterchangeError> {
        let n = self.len();
        assert_eq!(emissivities.len(), n, "one emissivity for each row");
        progress.begin("grey interchange", 2 * n as u64);
        let system = Cholesky::new(self.grey_system(emissivities), n, progress)?;
        let system = system.map_err(|row| InterchangeError::Grows { row })?;
        let own = |i: usize| self.areas[i] * emissivities[i] / (1.0 - emissivities[i]);
        let own: Vec<f64> = (0..n).map(own).collect();
        // Row i of diag(v) K⁻¹: how much of what each surface emits and reflects at first row i
        // absorbs.
        let absorbed: Result<Vec<Vec<f64>>, Cancelled> = (0..n)
            .into_par_iter()
            .map(|i| {
                progress.advance(1)?;
                let mut row = system.inverse_row(i);
                row.iter_mut().for_each(|w| *w *= own[i]);
                Ok(row)
            })
            .collect();
        let absorbed = absorbed?;
        let errors = self.interchange_errors(&absorbed, progress)?;
        let upper = |i: usize| -> Vec<Exchange> {
            let entry = |j: usize| {
                let own_emission = own[i] * emissivities[i];
                let diagonal = if i == j { own_emission } else { 0.0 };
                Exchange {
                    column: j as u32,
                    value: absorbed[i][j] * own[j] - diagonal,
                    error: errors[i][j - i],
                }
            };
            (i..n).map(entry).collect()
        };
        let mut grey = FormFactors {
            exchange: (0..n).map(upper).collect(),
            areas: self.areas.clone(),
            faces: self.faces.clone(),
            materials: self.materials.clone(),
            is_back: self.is_back.clone(),
            rest: (0..n)
                .map(|i| self.grey_rest(i, &absorbed[i], emissivities))
                .collect(),
            ends: vec![1.0; n],
            is_closed: self.is_closed,
            rays: self.rays,
            engine_used: self.engine_used.clone(),
            ..FormFactors::default()
        };
        grey.update_row_errors();
        Ok(grey)
    }

    /// diag(A/ρ) − S, row by row.
    fn grey_system(&self, emissivities: &[f64]) -> Vec<f64> {
        let n = self.len();
        let mut system = vec![0.0; n * n];
        for i in 0..n {
            system[i * n + i] = self.areas[i] / (1.0 - emissivities[i]);
            for e in self.exchange.upper(i) {
                let j = e.column as usize;
                system[i * n + j] -= e.value;
                if j != i {
                    system[j * n + i] -= e.value;
                }
            }
        }
        system
    }

    /// The shares of row i's emission that reach no column, after all reflections.
    fn grey_rest(&self, i: usize, absorbed: &[f64], emissivities: &[f64]) -> RowRemainder {
        let sent = |k: usize| absorbed[k] * self.areas[k] / self.areas[i];
        let sum = |part: fn(&RowRemainder) -> f64| -> f64 {
            let rest = self.rest.iter().enumerate();
            rest.map(|(k, r)| sent(k) * part(r)).sum()
        };
        let error = |part: fn(&RowRemainder) -> f64| {
            let rest = self.rest.iter().enumerate();
            let variance: f64 = rest.map(|(k, r)| (sent(k) * part(r)).powi(2)).sum();
            variance.sqrt()
        };
        RowRemainder {
            sky: sum(|r| r.sky),
            sky_error: error(|r| r.sky_error),
            ground: sum(|r| r.ground),
            ground_error: error(|r| r.ground_error),
            hidden: sum(|r| r.hidden),
            hidden_error: error(|r| r.hidden_error),
            cut: sum(|r| r.cut),
            lost: sum(|r| r.lost) + 1.0 - emissivities[i],
        }
    }

    /// Standard errors of the upper rows. A change dS of S changes A𝓕 by P dS Pᵀ, where P are the
    /// rows of `absorbed`.
    fn interchange_errors(
        &self,
        absorbed: &[Vec<f64>],
        progress: &Progress,
    ) -> Result<Vec<Vec<f32>>, Cancelled> {
        let n = self.len();
        let squares: Vec<Vec<f64>> = absorbed
            .par_iter()
            .map(|row| row.iter().map(|p| p * p).collect())
            .collect();
        let row = |i: usize| {
            progress.advance(1)?;
            let mut received = vec![0.0; n];
            for k in 0..n {
                for e in self.exchange.upper(k) {
                    let (j, variance) = (e.column as usize, f64::from(e.error).powi(2));
                    received[j] += squares[i][k] * variance;
                    if j != k {
                        received[k] += squares[i][j] * variance;
                    }
                }
            }
            let error = |j: usize| (2.0 * dot(&received, &squares[j])).sqrt() as f32;
            Ok((i..n).map(error).collect())
        };
        (0..n).into_par_iter().map(row).collect()
    }
}

/// The whole matrix by rows, which sweeps need one after the other.
struct WholeRows {
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl WholeRows {
    fn new(exchange: &ExchangeAreas) -> WholeRows {
        let mut starts = vec![0];
        for length in exchange.row_lengths() {
            starts.push(starts[starts.len() - 1] + length);
        }
        let entries = starts[starts.len() - 1];
        let mut rows = WholeRows {
            columns: vec![0; entries],
            values: vec![0.0; entries],
            starts,
        };
        let mut next = rows.starts.clone();
        let mut put = |i: usize, column: usize, value: f64| {
            rows.columns[next[i]] = column as u32;
            rows.values[next[i]] = value;
            next[i] += 1;
        };
        for i in 0..exchange.len() {
            for e in exchange.upper(i) {
                let j = e.column as usize;
                put(i, j, e.value);
                if j != i {
                    put(j, i, e.value);
                }
            }
        }
        rows
    }

    /// Scales each row to its target in turn; returns the largest error before.
    fn sweep(&self, factors: &mut [f64], areas: &[f64], targets: &[f64]) -> f64 {
        let mut worst: f64 = 0.0;
        for i in 0..factors.len() {
            let row = self.starts[i]..self.starts[i + 1];
            let (mut others, mut own) = (0.0, 0.0);
            for (&j, s) in self.columns[row.clone()].iter().zip(&self.values[row]) {
                if j as usize == i {
                    own = *s
                } else {
                    others += s * factors[j as usize]
                }
            }
            let sum = factors[i] * (others + own * factors[i]) / areas[i];
            if sum > 0.0 {
                worst = worst.max((targets[i] - sum).abs());
                factors[i] = factor_for(targets[i] * areas[i], others, own);
            }
        }
        worst
    }
}

/// The factor f with f (others + own f) = `target`: an entry of a row with itself is scaled twice.
fn factor_for(target: f64, others: f64, own: f64) -> f64 {
    // Written so that it holds for `own` = 0.
    2.0 * target / (others + (others * others + 4.0 * own * target).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix of whole rows of S.
    fn matrix(areas: &[f64], s: &[&[f64]]) -> FormFactors {
        let n = areas.len();
        let upper = |i: usize| -> Vec<Exchange> {
            let entry = |j: usize| Exchange {
                column: j as u32,
                value: s[i][j],
                error: 0.01,
            };
            (i..n).filter(|&j| s[i][j] > 0.0).map(entry).collect()
        };
        FormFactors {
            exchange: (0..n).map(upper).collect(),
            areas: areas.to_vec(),
            rest: vec![RowRemainder::default(); n],
            ends: vec![1.0; n],
            ..FormFactors::default()
        }
    }

    /// Three sides of a triangular duct: every row sums to 1.
    fn duct() -> FormFactors {
        matrix(
            &[1.0; 3],
            &[&[0.0, 0.5, 0.5], &[0.5, 0.0, 0.5], &[0.5, 0.5, 0.0]],
        )
    }

    #[test]
    fn rows_are_scaled_to_their_targets() {
        let mut factors = matrix(
            &[1.0, 2.0, 1.5],
            &[&[0.0, 0.6, 0.41], &[0.6, 0.3, 1.1], &[0.41, 1.1, 0.0]],
        );
        let scaled = factors
            .scale_rows(&[1.0; 3], 100, &Progress::new())
            .unwrap();
        assert!(scaled.sweeps < 100 && scaled.error <= 1e-7, "{scaled:?}");
        assert!(scaled.moved.total > 0.0 && scaled.moved.deficit <= 1e-6);
        assert!(factors.row_sums().iter().all(|s| (s - 1.0).abs() < 1e-6));
        // Nothing to do, nothing done.
        let scaled = duct().scale_rows(&[1.0; 3], 100, &Progress::new()).unwrap();
        assert_eq!((scaled.sweeps, scaled.moved.total), (1, 0.0));
    }

    #[test]
    fn a_row_that_sees_nothing_stays() {
        let mut factors = matrix(&[1.0, 1.0], &[&[0.0, 0.0], &[0.0, 0.4]]);
        factors
            .scale_rows(&[1.0; 2], 100, &Progress::new())
            .unwrap();
        assert_eq!(factors.row_sums()[0], 0.0);
        assert!((factors.row_sums()[1] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_mask_sees_what_it_covers() {
        // A floor whose middle is covered: 0.75 of it remain.
        let mut factors = matrix(
            &[0.75, 1.0, 0.0],
            &[&[0.0, 0.15, 0.0], &[0.15, 0.0, 0.0], &[0.0; 3]],
        );
        factors.rest[0].sky = 0.8;
        factors.cover(2, 0, 0.25);
        assert_eq!(factors.areas, [1.0, 1.0, 0.25]);
        assert_eq!((factors.get(0, 2).0, factors.get(2, 0).0), (0.25, 1.0));
        assert_eq!((factors.get(0, 1).0, factors.get(1, 0).0), (0.15, 0.15));
        assert!((factors.rest[0].sum() + factors.row_sums()[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn parallel_plates_exchange_as_the_textbook_says() {
        // Infinite plates: 𝓕_12 = 1/(1/ε₁ + 1/ε₂ − 1).
        let plates = matrix(&[2.0, 2.0], &[&[0.0, 2.0], &[2.0, 0.0]]);
        let grey = plates.interchange(&[0.8, 0.4], &Progress::new()).unwrap();
        let expected = 1.0 / (1.0 / 0.8 + 1.0 / 0.4 - 1.0);
        assert!((grey.get(0, 1).0 - expected).abs() < 1e-12);
        let sums = grey.row_sums();
        assert!((sums[0] - 0.8).abs() < 1e-12 && (sums[1] - 0.4).abs() < 1e-12);
        assert!(grey.get(0, 1).1 > 0.0);
        // An open pair is complete too.
        let mut open = matrix(&[2.0, 2.0], &[&[0.0, 1.0], &[1.0, 0.0]]);
        open.rest.iter_mut().for_each(|r| r.sky = 0.5);
        let grey = open.interchange(&[0.8, 0.4], &Progress::new()).unwrap();
        for (sum, rest) in grey.row_sums().iter().zip(&grey.rest) {
            assert!((sum + rest.sum() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn errors_of_interchange_are_those_of_small_changes() {
        let emissivities = [0.3, 0.6, 0.9];
        let grey = duct().interchange(&emissivities, &Progress::new()).unwrap();
        let mut variances = [[0.0; 3]; 3];
        let step = 1e-6;
        for (a, b) in [(0, 1), (0, 2), (1, 2)] {
            let mut other = duct();
            other.exchange.add(a, b, step);
            let other = other.interchange(&emissivities, &Progress::new()).unwrap();
            for (i, row) in variances.iter_mut().enumerate() {
                for (j, v) in row.iter_mut().enumerate() {
                    let slope = (other.get(i, j as u32).0 - grey.get(i, j as u32).0) / step;
                    *v += (0.01 * slope).powi(2);
                }
            }
        }
        for (i, row) in variances.iter().enumerate() {
            for (j, v) in row.iter().enumerate() {
                let ratio = f64::from(grey.get(i, j as u32).1) / v.sqrt();
                assert!((0.99..1.45).contains(&ratio), "{i} {j}: {ratio}");
            }
        }
    }

    #[test]
    fn growing_light_is_refused() {
        let plates = matrix(&[1.0, 1.0], &[&[0.0, 1.2], &[1.2, 0.0]]);
        let refused = plates
            .interchange(&[0.1, 0.1], &Progress::new())
            .unwrap_err();
        assert_eq!(refused, InterchangeError::Grows { row: 1 });
        let cancelled = Progress::new();
        cancelled.cancel();
        let refused = duct().interchange(&[0.5; 3], &cancelled).unwrap_err();
        assert_eq!(refused, InterchangeError::Cancelled);
    }
}
