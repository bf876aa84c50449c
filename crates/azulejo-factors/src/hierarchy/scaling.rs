//! Rows and columns scaled until row sums are what they should be.

use super::blocks::{BlockPart, product};
use azulejo_trace::{Cancelled, Progress};

/// Most sweeps; rooms take 10 to 40.
const SWEEPS: u64 = 60;

/// Relative error of the worst sum at which sweeps end.
const TOLERANCE: f64 = 1e-9;

/// Largest factor of a row: sums that take more stay too small. None is too small: where others see a
/// row that does not see them, as where fronts and backs are mixed up, it would get light that is not
/// there.
const MOST: f64 = 4.0;

/// Multiplies row and column p by a factor d_p each, so that Σ_q d_p S_pq d_q `weights`_q becomes
/// `targets`_p, all by position. Returns the factors.
///
/// Blocks stay symmetric and what is positive stays so; a correction on the diagonal would let flat
/// patches see themselves, and with a negative sum half of the time. Sweeps of the square roots of what
/// is missing (Knight, Ruiz, Uçar, *A symmetry preserving algorithm for matrix scaling*, SIAM J. Matrix
/// Anal. Appl. 35, 2014). Rows that see nothing stay.
pub(super) fn scale(
    parts: &mut [BlockPart],
    weights: &[f64],
    targets: &[f64],
    progress: &Progress,
) -> Result<Vec<f64>, Cancelled> {
    let mut factors = vec![1.0; targets.len()];
    progress.begin("row sums", SWEEPS);
    for _ in 0..SWEEPS {
        progress.advance(1)?;
        let weighted: Vec<f64> = factors.iter().zip(weights).map(|(d, k)| d * k).collect();
        let sums = product(parts, &weighted, 1);
        let mut worst = 0.0f64;
        for ((factor, sum), target) in factors.iter_mut().zip(sums).zip(targets) {
            let ratio = target / (*factor * sum);
            if ratio.is_finite() {
                let next = (*factor * ratio.sqrt()).min(MOST);
                worst = worst.max((next / *factor - 1.0).abs());
                *factor = next;
            }
        }
        if worst <= TOLERANCE {
            break;
        }
    }
    parts.iter_mut().for_each(|part| part.scale(&factors));
    Ok(factors)
}
