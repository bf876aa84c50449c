//! Rows that sum to 1, by symmetric scaling.

use super::FormFactors;
use azulejo_trace::{Cancelled, Progress};
use rayon::prelude::*;

/// Deviation of row sums from 1 at which the scaling ends.
const TOLERANCE: f64 = 1e-9;

/// Most steps; each takes away a quarter or more of what is left in all but strange rooms.
const STEPS: u32 = 200;

/// Share of a row's light that may be lost in a closed scene: what rays lose in cracks.
const LOSS: f64 = 1e-6;

/// Whether all rows that see anything keep their light. Rows that see nothing are the outside of
/// a closed room.
pub(super) fn is_closed(factors: &FormFactors) -> bool {
    let keeps = |i: usize| factors.escaped[i] + factors.hidden[i] <= LOSS;
    let sees = |i: usize| !factors.range(i).is_empty();
    (0..factors.len()).any(sees) && (0..factors.len()).all(|i| keeps(i) || !sees(i))
}

/// Scales exchange areas S to D S D with a diagonal D such that rows sum to their areas, less
/// what was cut off; errors are scaled along. Returns the largest relative change of an entry.
///
/// Half a step of Sinkhorn and Knopp (1967) for both sides at once keeps S symmetric to the bit.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn restore(factors: &mut FormFactors, progress: &Progress) -> Result<f64, Cancelled> {
    let n = factors.len();
    let mut scale = vec![1.0; n];
    progress.begin("row sums", u64::from(STEPS));
    for _ in 0..STEPS {
        progress.advance(1)?;
        let missing: Vec<f64> = (0..n)
            .into_par_iter()
            .map(|i| missing(factors, &scale, i))
            .collect();
        scale
            .iter_mut()
            .zip(&missing)
            .for_each(|(d, m)| *d *= m.sqrt());
        if missing.iter().all(|m| (m - 1.0).abs() <= TOLERANCE) {
            break;
        }
    }
    Ok(apply(factors, &scale))
}

/// What the scaled row `i` must be multiplied with to sum to its area.
fn missing(factors: &FormFactors, scale: &[f64], i: usize) -> f64 {
    let entries = factors
        .range(i)
        .map(|k| factors.values[k] * scale[factors.columns[k] as usize]);
    let sum = scale[i] * entries.sum::<f64>();
    if sum > 0.0 {
        factors.areas[i] / sum
    } else {
        1.0
    }
}

fn apply(factors: &mut FormFactors, scale: &[f64]) -> f64 {
    let mut largest = 0_f64;
    for i in 0..factors.len() {
        for k in factors.range(i) {
            let change = scale[i] * scale[factors.columns[k] as usize];
            factors.values[k] *= change;
            factors.errors[k] = (f64::from(factors.errors[k]) * change) as f32;
            largest = largest.max((change - 1.0).abs());
        }
    }
    largest
}
