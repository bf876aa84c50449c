//! The part above the horizon of pairs of facets that touch, or nearly do.
//!
//! Points of one facet do not tell it, because the view of the other changes without bound towards a common
//! edge. Both are cut into slabs between the same heights instead. What lies in a higher slab is above all
//! that lies in a lower one, and formulas know the exchange area of such parts. Of two parts in the same slab
//! half the light goes upwards, the closer the thinner the slab is.

use super::Facet;
use super::partial::PairGoal;
use crate::analytic::{Approximate, exchange_area_fast};
use azulejo_trace::lambert::clip;
use glam::DVec3;

/// Fewest and most slabs between two heights of corners.
const SLABS: [usize; 2] = [4, 128];

/// The exchange area of what points of `a` see of `b` above their own height, nothing being between them,
/// and the number of slabs that it took.
pub(super) fn exchange_above(
    [a, b]: [&Facet; 2],
    up: DVec3,
    goal: PairGoal,
) -> (Approximate, usize) {
    let corners = shared_heights([a, b], up, goal.graze);
    let [mut slabs, most] = SLABS;
    let of = |slabs| {
        above(
            [a.polygon(), b.polygon()],
            up,
            &divided(&corners, slabs),
            goal.whole,
        )
    };
    let mut coarse = of(slabs);
    let mut cut = slabs * (corners.len() - 1);
    loop {
        slabs *= 2;
        cut += slabs * (corners.len() - 1);
        let fine = of(slabs);
        // Halves of thin slabs err with the square of their height.
        let change = (fine - coarse) / 3.0;
        if change.abs() < goal.error || slabs >= most {
            let seen = Approximate {
                value: (fine + change).max(0.0),
                error: change.abs(),
            };
            return (seen, cut);
        }
        coarse = fine;
    }
}

/// The heights of corners that both facets reach, in order; at least one.
fn shared_heights(pair: [&Facet; 2], up: DVec3, graze: f64) -> Vec<f64> {
    let heights = pair.map(|f| f.polygon().iter().map(|p| up.dot(*p)).collect::<Vec<f64>>());
    let low = heights
        .each_ref()
        .map(|h| h.iter().copied().fold(f64::INFINITY, f64::min));
    let high = heights
        .each_ref()
        .map(|h| h.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    let (low, high) = (low[0].max(low[1]), high[0].min(high[1]));
    let mut shared: Vec<f64> = heights.concat();
    shared.retain(|&h| low < h && h < high);
    shared.extend([low, high]);
    shared.sort_by(f64::total_cmp);
    shared.dedup_by(|next, last| *next - *last <= graze);
    shared
}

/// Heights with this many slabs between each two.
fn divided(heights: &[f64], slabs: usize) -> Vec<f64> {
    let mut all = vec![heights[0]];
    for pair in heights.windows(2) {
        let step = (pair[1] - pair[0]) / slabs as f64;
        all.extend((1..slabs).map(|k| pair[0] + k as f64 * step));
        all.push(pair[1]);
    }
    all
}

fn above([a, b]: [&[DVec3]; 2], up: DVec3, heights: &[f64], accuracy: f64) -> f64 {
    let over = |p: &[DVec3], height: f64| clip(p, height * up, up);
    let under = |p: &[DVec3], height: f64| clip(p, height * up, -up);
    let exchange = |a: &[DVec3], b: &[DVec3]| {
        if a.len() < 3 || b.len() < 3 {
            0.0
        } else {
            exchange_area_fast(a, b, accuracy)
        }
    };
    // Below the heights that both reach there is nothing of the second if there is some of the first.
    let mut sum = exchange(&under(a, heights[0]), b);
    let mut rest = [over(a, heights[0]), over(b, heights[0])];
    for &height in &heights[1..] {
        let slab = rest.each_ref().map(|p| under(p, height));
        rest = rest.map(|p| over(&p, height));
        sum += exchange(&slab[0], &rest[1]) + 0.5 * exchange(&slab[0], &slab[1]);
    }
    sum
}
