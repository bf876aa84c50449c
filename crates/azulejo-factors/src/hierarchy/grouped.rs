//! Groups of rows of a matrix, wherever it is: by products with what belongs to a group.

use super::operator::FactorOperator;
use crate::form_factors::{Exchange, ExchangeAreas, FormFactors};
use azulejo_trace::{Cancelled, Progress};

/// Groups whose products are computed together.
const LANES: usize = 8;

/// [`FormFactors::grouped`] where the matrix is `operator`, and `rows` describes its rows. One product for
/// every group, and one for its errors.
///
/// # Errors
/// [`Cancelled`].
///
/// # Panics
/// If `groups` has another length than the operator, or numbers from `count` on.
pub fn grouped(
    operator: &dyn FactorOperator,
    rows: &FormFactors,
    groups: &[Option<u32>],
    count: usize,
    progress: &Progress,
) -> Result<FormFactors, Cancelled> {
    let row_count = operator.row_areas().len();
    assert_eq!(groups.len(), row_count, "one group for each row");
    let mut exchange = ExchangeAreas::new();
    progress.begin("groups", count as u64);
    for first in (0..count).step_by(LANES) {
        let lanes = LANES.min(count - first);
        let mut members = vec![0.0; lanes * groups.len()];
        for (i, group) in groups.iter().enumerate() {
            let lane = group.and_then(|g| (g as usize).checked_sub(first));
            if let Some(lane) = lane.filter(|&lane| lane < lanes) {
                members[i * lanes + lane] = 1.0;
            }
        }
        let sum = |rows: Vec<f64>| by_group(&rows, groups, count, lanes);
        let sums = sum(operator.exchanged_lanes(&members, lanes));
        let spread = sum(operator.variance_lanes(&members, lanes));
        for lane in 0..lanes {
            let group = first + lane;
            let entry = |b: usize| {
                let at = b * lanes + lane;
                // Within a group a pair counts in both directions, with one error.
                let ways = if b == group { 2.0 } else { 1.0 };
                Exchange {
                    column: b as u32,
                    value: sums[at],
                    error: (ways * spread[at].max(0.0)).sqrt() as f32,
                }
            };
            let row = (group..count).map(entry);
            exchange.push_row(row.filter(|e| e.value > 0.0 || e.error > 0.0));
        }
        progress.advance(lanes as u64)?;
    }
    let outside = groups.iter().zip(&rows.ends);
    let outside: Vec<f64> = outside
        .map(|(group, ends)| if group.is_none() { *ends } else { 0.0 })
        .collect();
    let to_nobody = operator.exchanged(&outside);
    Ok(rows.grouped_as(groups, exchange, &to_nobody))
}

/// Sums over the rows of each group, of `lanes` numbers for each row.
fn by_group(rows: &[f64], groups: &[Option<u32>], count: usize, lanes: usize) -> Vec<f64> {
    let mut sums = vec![0.0; count * lanes];
    for (row, group) in rows.chunks_exact(lanes).zip(groups) {
        if let Some(group) = group {
            let to = &mut sums[*group as usize * lanes..][..lanes];
            to.iter_mut().zip(row).for_each(|(to, x)| *to += x);
        }
    }
    sums
}
