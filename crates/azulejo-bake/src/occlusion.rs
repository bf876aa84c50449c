//! Which share of the hemispheres over points is free of things that are near.

use crate::atlas::Atlas;
use crate::layout::NO_CHART;
use azulejo_scene::Rgb;
use azulejo_scene::math::{Frame, Ray};
use azulejo_trace::run::batches::{SHORT_BLOCK, in_counted_batches};
use azulejo_trace::run::{LoopSize, digest};
use azulejo_trace::sampling::{cosine_about, hash, uniform};
use azulejo_trace::{
    Cancelled, GatherPoint, Gathered, KernelRay, REPLICATES, Run, RunStage, Tracer,
};
use glam::DVec3;
use rayon::prelude::*;

/// Points whose rays are traced together.
const BATCH: usize = 32;

/// Strata that are enough to see which side of a surface is freer.
const FEW_STRATA: u32 = 4;

/// Rays of a block that is stored, about, and fewest and most of its points.
const BLOCK_RAYS: usize = 1 << 20;
const BLOCK: [usize; 2] = [256, 1 << 15];

/// Points of a block that is stored.
fn block_points(strata: u32) -> usize {
    let rays = REPLICATES * (strata * strata).max(1) as usize;
    (BLOCK_RAYS / rays).clamp(BLOCK[0], BLOCK[1])
}

/// Hemispheres over points of a scene.
pub struct Hemispheres<'a> {
    /// What may be in them.
    pub tracer: &'a Tracer,
    /// Up to which distance that counts, scene units.
    pub distance: f64,
    /// Keys the rays.
    pub seed: u32,
    /// Divides, counts and stops.
    pub run: Run<'a>,
}

impl Hemispheres<'_> {
    /// The free share at points, weighted by the cosine, 0 to 1: replicates of `strata`² rays each.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn free(&self, points: &[GatherPoint], strata: u32) -> Result<Vec<Gathered>, Cancelled> {
        self.run.progress.begin("occlusion", points.len() as u64);
        in_counted_batches(points, (BATCH, SHORT_BLOCK), self.run, |batch| {
            Ok(self.free_of(batch, strata))
        })
    }

    /// The same, as the result of a run: in blocks that are stored and divided; `None` if the result is made elsewhere.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn free_of_all(
        &self,
        points: &[GatherPoint],
        strata: u32,
    ) -> Result<Option<Vec<Gathered>>, Cancelled> {
        let run = self.run;
        if !run.role().is_kept || run.is_shared() {
            return self.free(points, strata).map(Some);
        }
        let places = points.iter().flat_map(|p| [p.position, p.normal]);
        let numbers = places.flat_map(|v| v.to_array());
        run.blocks.rely_on(RunStage::Points, digest(numbers))?;
        let size = LoopSize {
            items: points.len(),
            block: block_points(strata),
            at_once: block_points(strata),
        };
        let own = run.own_items(size.items);
        run.progress.begin("occlusion", own as u64);
        run.resumed(RunStage::Points, size, |items| {
            let of_batch = |batch: &[usize]| {
                run.progress.advance(batch.len() as u64)?;
                let points: Vec<GatherPoint> = batch.iter().map(|&i| points[i]).collect();
                Ok(self.free_of(&points, strata))
            };
            let shares: Result<Vec<_>, Cancelled> = items.par_chunks(BATCH).map(of_batch).collect();
            Ok(shares?.concat())
        })
    }

    /// The free share at points whose rays are traced together.
    fn free_of(&self, points: &[GatherPoint], strata: u32) -> Vec<Gathered> {
        let rays: Vec<KernelRay> = points.iter().flat_map(|p| self.rays(p, strata)).collect();
        let mut blocked = Vec::new();
        self.tracer.any(&rays, &mut blocked);
        let of_replicate = (strata * strata) as usize;
        let points = blocked.chunks_exact(REPLICATES * of_replicate);
        let free = |replicate: &[bool]| {
            let free = replicate.iter().filter(|blocked| !**blocked).count();
            Rgb::grey(free as f64 / of_replicate as f64)
        };
        let gathered = |point: &[bool]| {
            let mut of_point = point.chunks_exact(of_replicate).map(free);
            Gathered {
                replicates: std::array::from_fn(|_| of_point.next().unwrap_or_default()),
            }
        };
        points.map(gathered).collect()
    }

    fn rays(&self, point: &GatherPoint, strata: u32) -> Vec<KernelRay> {
        let frame = Frame::from_normal(point.normal);
        let origin = self.tracer.leaving(point.position, point.normal);
        let ray = |k: u32| {
            let jitter = |d: u32| f64::from(uniform(&[self.seed, point.key, k, d]));
            let cell = [k % strata, k / strata % strata].map(f64::from);
            let [u1, u2] = [cell[0] + jitter(0), cell[1] + jitter(1)];
            let width = f64::from(strata);
            let direction = cosine_about(&frame, u1 / width, u2 / width);
            self.tracer.kernel_ray(&Ray {
                t_max: self.distance,
                ..Ray::new(origin, direction)
            })
        };
        (0..REPLICATES as u32 * strata * strata).map(ray).collect()
    }

    /// For each chart whether its back is freer than its front.
    ///
    /// # Errors
    /// The caller cancelled.
    pub fn freer_sides(&self, atlas: &Atlas) -> Result<Vec<bool>, Cancelled> {
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for (r, receiver) in atlas.receivers.iter().enumerate() {
            for (t, &chart) in atlas.layout.receivers[r].charts.iter().enumerate() {
                if chart == NO_CHART {
                    continue;
                }
                let vector = receiver.area_vector(t);
                let position = receiver.corners(t).iter().sum::<DVec3>() / 3.0;
                for side in [1.0, -1.0] {
                    points.push(GatherPoint {
                        position,
                        normal: side * vector.normalize_or(DVec3::Z),
                        key: hash(&[r as u32, t as u32]),
                    });
                    weights.push((chart, side * vector.length()));
                }
            }
        }
        let mut excess = vec![0.0; atlas.layout.charts as usize];
        for (free, (chart, weight)) in self.free(&points, FEW_STRATA)?.iter().zip(weights) {
            excess[chart as usize] -= weight * free.mean().mean();
        }
        Ok(excess.into_iter().map(|e| e > 0.0).collect())
    }
}
