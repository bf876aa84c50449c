//! Direct light of patches, area-averaged: the part of the light that formulas compute.

use azulejo_factors::Patches;
use azulejo_factors::patch::Sampler;
use azulejo_factors::row::Side;
use azulejo_trace::sampling::{hash, seeds, sobol};
use azulejo_trace::{
    DirectLight, GatherPoint, Gatherer, RAYS_PER_FORMULA, REPLICATES, SurfaceSamples,
};
use std::ops::Range;

/// Positions per replicate of the first estimate of a patch's direct light.
pub(crate) const DIRECT_POSITIONS: u32 = 4;

/// Area-averaged direct light on one side of a patch. Depends on the arguments alone.
pub fn direct(gatherer: &Gatherer, patches: &Patches, seed: u32, side: Side) -> DirectLight {
    direct_at(gatherer, patches, seed, side, 0..DIRECT_POSITIONS)
}

/// The same from a range of each replicate's sequence of positions.
pub(crate) fn direct_at(
    gatherer: &Gatherer,
    patches: &Patches,
    seed: u32,
    side: Side,
    stretch: Range<u32>,
) -> DirectLight {
    let positions = Positions {
        sampler: patches.sampler((side / 2) as usize),
        seed,
        side,
    };
    if gatherer.many_lights() {
        let rays = RAYS_PER_FORMULA as u32;
        let many = stretch.start * rays..stretch.end * rays;
        let samples = SurfaceSamples {
            formulas: &positions.of(stretch, 0xd1),
            rays: &positions.of(many.clone(), 0xd2),
            before: many.start,
        };
        return gatherer.direct_over(&samples, hash(&[seed, side]));
    }
    let count = stretch.len();
    let lights = gatherer.direct(&positions.of(stretch, 0xd1), 1, seed);
    let mut light = DirectLight::default();
    let share = 1.0 / count as f64;
    for (k, at) in lights.iter().enumerate() {
        light.lamps.replicates[k / count] += at.lamps.mean() * share;
        light.outside.replicates[k / count] += at.outside.mean() * share;
        light.lights += at.lights * (share / REPLICATES as f64);
    }
    light
}

/// Positions on one side of a patch.
struct Positions<'a> {
    sampler: Sampler<'a>,
    seed: u32,
    side: Side,
}

impl Positions<'_> {
    /// A range of each replicate's sequence; `purpose` selects an independent sequence.
    fn of(&self, stretch: Range<u32>, purpose: u32) -> Vec<GatherPoint> {
        let flip = if self.side.is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        let mut points = Vec::with_capacity(REPLICATES * stretch.len());
        for r in 0..REPLICATES as u32 {
            let [s1, s2, ..] = seeds(&[self.seed, self.side, r, purpose]);
            points.extend(stretch.clone().map(|k| {
                let at = self
                    .sampler
                    .sample(sobol(k, 0, s1).into(), sobol(k, 1, s2).into());
                GatherPoint {
                    position: at.position,
                    normal: flip * at.normal,
                    key: hash(&[self.side, r, k]),
                }
            }));
        }
        points
    }
}
