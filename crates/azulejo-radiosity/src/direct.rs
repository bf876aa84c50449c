//! The direct light of patches: what formulas count, area-averaged.

use crate::patch::Patches;
use crate::row::Side;
use azulejo_trace::sampling::{hash, seeds, sobol};
use azulejo_trace::{DirectLight, GatherPoint, Gatherer, REPLICATES};
use std::ops::Range;

/// Positions per replicate at which a patch's direct light is computed first.
pub(crate) const DIRECT_POSITIONS: u32 = 4;

/// The light that formulas count on one side of a patch, area-averaged. Depends on the arguments
/// alone.
pub fn direct(gatherer: &Gatherer, patches: &Patches, seed: u32, side: Side) -> DirectLight {
    direct_at(gatherer, patches, seed, side, 0..DIRECT_POSITIONS)
}

/// The same from a stretch of each replicate's sequence of positions.
pub(crate) fn direct_at(
    gatherer: &Gatherer,
    patches: &Patches,
    seed: u32,
    side: Side,
    stretch: Range<u32>,
) -> DirectLight {
    let (patch, flip) = (
        (side / 2) as usize,
        if side.is_multiple_of(2) { 1.0 } else { -1.0 },
    );
    let count = stretch.len();
    let mut points = Vec::with_capacity(REPLICATES * count);
    for r in 0..REPLICATES as u32 {
        let [s1, s2, ..] = seeds(&[seed, side, r, 0xd1]);
        for k in stretch.clone() {
            let at = patches.sample(patch, sobol(k, 0, s1).into(), sobol(k, 1, s2).into());
            points.push(GatherPoint {
                position: at.position,
                normal: flip * at.normal,
                key: hash(&[side, r, k]),
            });
        }
    }
    let found = gatherer.direct(&points, 1, seed);
    let mut light = DirectLight::default();
    let share = 1.0 / count as f64;
    for (k, at) in found.iter().enumerate() {
        light.lamps.replicates[k / count] += at.lamps.mean() * share;
        light.lights += at.lights * (share / REPLICATES as f64);
    }
    light
}
