//! What rows receive from lights that are not patches: skies, suns, pictures of the surroundings.

use super::PreparedPlan;
use crate::error::FactorsError;
use crate::patch::Sampler;
use azulejo_scene::{LightKind, Rgb};
use azulejo_trace::sampling::{hash, seeds, sobol};
use azulejo_trace::{GatherPoint, Gathered, Progress, REPLICATES};
use rayon::prelude::*;

/// Positions on a patch, of all replicates.
pub(super) const POSITIONS: u32 = 64;

/// Rows between two updates of the progress.
const ROWS_AT_ONCE: usize = 64;

impl PreparedPlan<'_> {
    /// Whether there are lights whose irradiance [`light_from_outside`](PreparedPlan::light_from_outside)
    /// finds.
    pub fn has_light_from_outside(&self) -> bool {
        let lights = &self.plan.proxy.scene.lights;
        let is_direct = |kind: &LightKind| !matches!(kind, LightKind::Ambient { .. });
        lights.iter().any(|light| is_direct(&light.kind))
    }

    /// Mean irradiance of each row, W/m², from environments, suns, and lights without area, straight and by
    /// way of one flat mirror; without ambient light, which is its radiance times π times what
    /// escapes ([`RowRemainder::escaped`](super::RowRemainder::escaped)).
    ///
    /// Each of the four replicates has positions of its own, so that the standard error includes what
    /// differs over a patch. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`FactorsError::Cancelled`].
    pub fn light_from_outside(&self, progress: &Progress) -> Result<Vec<Gathered>, FactorsError> {
        let rows = self.sides.len();
        progress.begin("light from outside", rows as u64);
        let (seed, counts) = (hash(&[self.seed, 2]), self.positions());
        let blocks = (0..rows.div_ceil(ROWS_AT_ONCE))
            .into_par_iter()
            .map(|block| {
                let from = block * ROWS_AT_ONCE;
                let range = from..rows.min(from + ROWS_AT_ONCE);
                progress.advance(range.len() as u64)?;
                Ok(range
                    .map(|row| self.row_from_outside(row, counts.of(self.sides.patch(row)), seed))
                    .collect())
            });
        let blocks: Result<Vec<Vec<Gathered>>, FactorsError> = blocks.collect();
        Ok(blocks?.concat())
    }

    fn row_from_outside(&self, row: usize, positions: u32, seed: u32) -> Gathered {
        let count = positions / REPLICATES as u32;
        let side = self.sides.side(row);
        let flip = self.sides.flip(row);
        let sampler = self.plan.patches.sampler(self.sides.patch(row));
        let points = positions_on(&sampler, flip, count, [seed, side]);
        let light = self.gatherer.direct(&points, 1, seed);
        let mut irradiance = Gathered::default();
        for (k, light) in light.iter().enumerate() {
            let share: Rgb = light.external() / f64::from(count);
            irradiance.replicates[k / count as usize] += share;
        }
        irradiance
    }
}

/// Positions on one side of a patch, `count` for each replicate, one replicate after the other.
fn positions_on(
    sampler: &Sampler,
    flip: f64,
    count: u32,
    [seed, side]: [u32; 2],
) -> Vec<GatherPoint> {
    let mut points = Vec::with_capacity(REPLICATES * count as usize);
    for r in 0..REPLICATES as u32 {
        let [s1, s2, ..] = seeds(&[seed, side, r]);
        points.extend((0..count).map(|k| {
            let at = sampler.sample(sobol(k, 0, s1).into(), sobol(k, 1, s2).into());
            GatherPoint {
                position: at.position,
                normal: flip * at.normal,
                key: hash(&[side, r, k]),
            }
        }));
    }
    points
}
