//! Rows that sum to what they should.

use super::{Exchange, FormFactors};
use azulejo_trace::{Cancelled, Progress};

/// Deviation of row sums, relative to the area, at which the iteration ends.
const TOLERANCE: f64 = 1e-8;

/// Most steps; rooms take 10 to 30.
const STEPS: u32 = 200;

/// Share of a row's light that a closed scene may lose: what rays lose in cracks.
const LOSS: f64 = 1e-6;

/// No entry falls below this share of itself.
const LEAST: f64 = 0.1;

/// Whether all rows that see anything keep their light. Rows that see nothing are the outside of
/// a closed room.
pub(super) fn is_closed(factors: &FormFactors) -> bool {
    let keeps = |i: usize| factors.escaped[i] <= LOSS;
    let lengths = factors.exchange.row_lengths();
    let sees = |i: usize| lengths[i] > 0;
    (0..factors.len()).any(sees) && (0..factors.len()).all(|i| keeps(i) || !sees(i))
}

/// Changes exchange areas so that rows sum to their areas, less what ended on hidden sides or was
/// cut off. Returns the change of all entries, relative to their sum.
///
/// Of all symmetric matrices with these row sums it is the one closest to the estimates by their
/// variances V: ΔS_ij = V_ij (λ_i + λ_j), where Σ_j ΔS_ij is what row i lacks. Entries by rays,
/// whose variance is about in proportion to S, are scaled as by a diagonal matrix from both
/// sides; those that formulas know stay as they are. (Larsen and Howell, *Least-squares smoothing
/// of direct-exchange areas in zonal analysis*, J. Heat Transfer 108, 1986.)
///
/// # Errors
/// [`Cancelled`].
pub(super) fn restore(factors: &mut FormFactors, progress: &Progress) -> Result<f64, Cancelled> {
    let system = System::new(factors);
    let multipliers = system.solve(progress)?;
    Ok(apply(factors, &multipliers))
}

/// The equations for λ: Σ_j V_ij (λ_i + λ_j) = what row i lacks.
struct System<'a> {
    factors: &'a FormFactors,
    /// What each row lacks.
    lacks: Vec<f64>,
    /// Inverse of the matrix's diagonal; 0 for rows that stay as they are.
    inverse: Vec<f64>,
}

impl System<'_> {
    fn new(factors: &FormFactors) -> System<'_> {
        let kept = |i: usize| 1.0 - factors.hidden[i] - factors.cut[i];
        let sums = factors.exchange.row_sums();
        let diagonal = factors.exchange.sums(|_, e| variance(e));
        let lack = |i: usize| kept(i) * factors.areas[i] - sums[i];
        let inverse = |i: usize| {
            if diagonal[i] > 0.0 && kept(i) > LOSS {
                diagonal[i].recip()
            } else {
                0.0
            }
        };
        let rows = 0..factors.len();
        System {
            factors,
            lacks: rows.clone().map(lack).collect(),
            inverse: rows.map(inverse).collect(),
        }
    }

    /// Conjugate gradients, preconditioned with the diagonal.
    fn solve(&self, progress: &Progress) -> Result<Vec<f64>, Cancelled> {
        let n = self.lacks.len();
        let mut solution = vec![0.0; n];
        let mut rest: Vec<f64> = (0..n)
            .map(|i| {
                if self.inverse[i] > 0.0 {
                    self.lacks[i]
                } else {
                    0.0
                }
            })
            .collect();
        let mut direction = self.precondition(&rest);
        let mut product = dot(&rest, &direction);
        progress.begin("row sums", u64::from(STEPS));
        for _ in 0..STEPS {
            progress.advance(1)?;
            if (0..n).all(|i| rest[i].abs() <= TOLERANCE * self.factors.areas[i]) {
                break;
            }
            let image = self.times(&direction);
            let step = product / dot(&direction, &image);
            // A scene of facing halves has no answer; then the last one stands.
            if !step.is_finite() {
                break;
            }
            add(&mut solution, step, &direction);
            add(&mut rest, -step, &image);
            let next = self.precondition(&rest);
            let grown = dot(&rest, &next);
            let turn = grown / product;
            direction
                .iter_mut()
                .zip(&next)
                .for_each(|(d, z)| *d = z + turn * *d);
            product = grown;
        }
        Ok(solution)
    }

    fn precondition(&self, rest: &[f64]) -> Vec<f64> {
        rest.iter().zip(&self.inverse).map(|(r, m)| r * m).collect()
    }

    fn times(&self, x: &[f64]) -> Vec<f64> {
        let term = |i: usize, e: &Exchange| variance(e) * (x[i] + x[e.column as usize]);
        let mut product = self.factors.exchange.sums(term);
        let stay = product.iter_mut().zip(&self.inverse);
        stay.filter(|(_, m)| **m == 0.0).for_each(|(p, _)| *p = 0.0);
        product
    }
}

fn variance(e: &Exchange) -> f64 {
    f64::from(e.error).powi(2)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn add(to: &mut [f64], share: f64, x: &[f64]) {
    to.iter_mut().zip(x).for_each(|(t, x)| *t += share * x);
}

fn apply(factors: &mut FormFactors, multipliers: &[f64]) -> f64 {
    let change = |i: usize, e: &Exchange| {
        let change = variance(e) * (multipliers[i] + multipliers[e.column as usize]);
        change.max((LEAST - 1.0) * e.value)
    };
    let exchange = &mut factors.exchange;
    let whole: f64 = exchange.row_sums().iter().sum();
    let changed: f64 = exchange.sums(|i, e| change(i, e).abs()).iter().sum();
    exchange.map(|i, e| (e.value + change(i, e), e.error));
    if whole > 0.0 { changed / whole } else { 0.0 }
}
