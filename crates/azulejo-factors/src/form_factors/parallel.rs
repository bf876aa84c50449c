//! Parallel light, such as that of the sun, on rows and at points.

use super::sky_patches::RayStart;
use super::{FactorPoint, PreparedPlan};
use azulejo_scene::math::Ray;
use azulejo_trace::sampling::{hash, seeds, sobol};
use azulejo_trace::{Cancelled, Progress};
use glam::DVec3;
use rayon::prelude::*;

/// Keys the random numbers of parallel light.
const PARALLEL: u32 = 0x9a7;

impl PreparedPlan<'_> {
    /// Irradiance of each row by parallel light from each of the unit directions `toward`, relative to that of a surface
    /// which faces it: straight, and through panes, for which the mean of the channels counts.
    ///
    /// One row after the other, a number for each direction, of one ray from a position on the row: the positions of
    /// many directions cover it evenly. `first` is the number of the first direction among all, where these are asked
    /// for a few at a time. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn parallel_on_rows(
        &self,
        (toward, first): (&[DVec3], usize),
        progress: &Progress,
    ) -> Result<Vec<f32>, Cancelled> {
        self.parallel(self.rows(), toward, progress, |row| {
            let sampler = self.plan.patches.sampler(self.sides.patch(row));
            let flip = self.sides.flip(row);
            let [s1, s2, ..] = seeds(&[hash(&[self.seed, PARALLEL]), self.sides.side(row)]);
            move |k| {
                let k = (first + k) as u32;
                let at = sampler.sample(sobol(k, 0, s1).into(), sobol(k, 1, s2).into());
                RayStart {
                    position: at.position,
                    normal: Some(flip * at.normal),
                    weight: at.weight,
                }
            }
        })
    }

    /// The same at points; 0 at those without a normal.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn parallel_at_points(
        &self,
        points: &[FactorPoint],
        toward: &[DVec3],
        progress: &Progress,
    ) -> Result<Vec<f32>, Cancelled> {
        let placed = self.placed(points);
        self.parallel(points.len(), toward, progress, |k| {
            let (position, normal) = (placed[k], points[k].normal);
            move |_| RayStart {
                position,
                normal,
                weight: 1.0,
            }
        })
    }

    /// For each of `count` rows or points and each direction, the irradiance where `starts` says for both.
    fn parallel<At: Fn(usize) -> RayStart>(
        &self,
        count: usize,
        toward: &[DVec3],
        progress: &Progress,
        starts: impl Fn(usize) -> At + Sync,
    ) -> Result<Vec<f32>, Cancelled> {
        let tracer = self.gatherer.surfaces().tracer;
        let mut all = vec![0f32; count * toward.len()];
        let each = all.par_chunks_mut(toward.len().max(1)).enumerate();
        each.try_for_each_init(Default::default, |(rays, shares), (k, irradiances)| {
            progress.advance(0)?;
            let start = starts(k);
            let (rays, shares): (&mut Vec<_>, &mut Vec<_>) = (rays, shares);
            rays.clear();
            for (d, (irradiance, &toward)) in irradiances.iter_mut().zip(toward).enumerate() {
                let at = start(d);
                let normal = at.normal.unwrap_or_default();
                *irradiance = (at.weight * normal.dot(toward)).max(0.0) as f32;
                if *irradiance > 0.0 {
                    let origin = tracer.leaving(at.position, normal);
                    rays.push(tracer.kernel_ray(&Ray::new(origin, toward)));
                }
            }
            tracer.transmittance(rays, shares);
            let lit = irradiances
                .iter_mut()
                .filter(|irradiance| **irradiance > 0.0);
            lit.zip(shares.iter())
                .for_each(|(irradiance, share)| *irradiance *= share.mean() as f32);
            Ok(())
        })?;
        Ok(all)
    }
}
