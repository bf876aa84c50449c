//! Form factors by rays, row by row: the share of a patch's diffuse light that each patch receives,
//! directly or after any chain of mirrors and panes.
//!
//! A row is an area average: its rays start all over the patch, by the first two dimensions of a
//! scrambled Sobol sequence, and leave with cosine density by the other two (Malley's method), so
//! that an entry is the weight of the rays that arrive. Four independent scramblings give four
//! estimates of every row; their spread gives its standard error.

use crate::patch::Patches;
use crate::row::{Columns, Row, RowAccumulator, Side, order, side};
use crate::samples::{SampleCounts, steps_of_part};
use azulejo_scene::Rgb;
use azulejo_scene::math::{Frame, Ray};
use azulejo_trace::follow::{Event, Path, Scratch, follow};
use azulejo_trace::sampling::{SobolTable, cosine_about, hash, seeds};
use azulejo_trace::{
    Cancelled, Gatherer, KernelHit, NextEvent, Progress, REPLICATES, Surfaces, Tracer,
};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Mutex;

mod visits;

pub(crate) use visits::Visits;

/// Rays traced at a time: enough to keep the tracer busy, few enough to stay in the cache.
pub const BATCH: usize = 1024;

/// Rays of a step of progress, where rows have different numbers of rays.
const RAYS_PER_STEP: u32 = 1 << 12;

/// Samples the rays of rows.
pub struct RowSampler<'a> {
    tracer: &'a Tracer,
    patches: &'a Patches,
    table: SobolTable,
    seed: u32,
}

impl<'a> RowSampler<'a> {
    /// At most `count` rays per side and replicate.
    pub fn new(
        tracer: &'a Tracer,
        patches: &'a Patches,
        count: usize,
        seed: u32,
    ) -> RowSampler<'a> {
        RowSampler {
            tracer,
            patches,
            table: SobolTable::new(count),
            seed,
        }
    }

    /// Rays over a side and its hemisphere, for a range of a replicate's sequence; each carries the
    /// weight `share`.
    pub fn fill(
        &self,
        side: Side,
        replicate: usize,
        stretch: Range<usize>,
        share: f64,
        paths: &mut Vec<Path>,
    ) {
        let (patch, flip) = (
            (side / 2) as usize,
            if side.is_multiple_of(2) { 1.0 } else { -1.0 },
        );
        let sampler = self.patches.sampler(patch);
        let flat_frame = Frame::from_normal(flip * self.patches.normal(patch));
        let scrambling = seeds(&[self.seed, side, replicate as u32]);
        paths.extend(stretch.map(|k| {
            let [u1, u2, u3, u4] = self.table.point(k, scrambling).map(f64::from);
            let at = sampler.sample(u1, u2);
            let normal = flip * at.normal;
            let frame = if normal == flat_frame.z {
                flat_frame
            } else {
                Frame::from_normal(normal)
            };
            let origin = self.tracer.leaving(at.position, normal);
            let ray = Ray::new(origin, cosine_about(&frame, u3, u4));
            straight(self.tracer, &ray, share * at.weight, replicate as u32)
        }));
    }
}

/// A path that begins with a ray and this weight.
pub(crate) fn straight(tracer: &Tracer, ray: &Ray, weight: f64, id: u32) -> Path {
    Path::new(tracer.kernel_ray(ray), id, Rgb::grey(weight))
}

/// Finds the patch of a hit, immediately where the whole item is one patch.
pub struct HitPatches<'a> {
    surfaces: &'a Surfaces<'a>,
    patches: &'a Patches,
    /// For each item its only patch, or [`SEVERAL`].
    only: Vec<u32>,
}

const SEVERAL: u32 = u32::MAX;

impl<'a> HitPatches<'a> {
    /// A table of the items of the tracer.
    pub fn new(surfaces: &'a Surfaces<'a>, patches: &'a Patches) -> HitPatches<'a> {
        let only = |k: u32| {
            let item = surfaces.item(k);
            let patch = patches.only_patch(item.object, item.face, item.triangle);
            patch.unwrap_or(SEVERAL)
        };
        let only = (0..surfaces.tracer.item_count()).map(only).collect();
        HitPatches {
            surfaces,
            patches,
            only,
        }
    }

    /// The patch that `hit` lies on.
    #[inline]
    pub fn at(&self, hit: &KernelHit) -> u32 {
        match self.only[hit.item as usize] {
            SEVERAL => self.patches.locate_hit(self.surfaces, hit),
            patch => patch,
        }
    }
}

/// Computes rows by rays. Immutable; shared by all threads.
pub struct RayEstimator<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    sampler: RowSampler<'a>,
    hit_patches: HitPatches<'a>,
    /// Rays of each replicate.
    per_replicate: SampleCounts,
    seed: u32,
    columns: Columns,
    /// Whether paths go on from some surface.
    is_specular: bool,
    /// Working memory not in use by any thread.
    spare: Mutex<Vec<RowWorkspace>>,
}

/// Working memory for a row.
pub(crate) struct RowWorkspace {
    /// Rays to be traced next.
    pub paths: Vec<Path>,
    scratch: Scratch,
    next_event: NextEvent,
    /// Sums of what they hit.
    pub sums: RowAccumulator,
    /// What each of them hit by mirrors and glass; only in rows by rays.
    visits: Option<Visits>,
}

impl<'a> RayEstimator<'a> {
    /// An estimator that spends `rays` per row, rounded up to a multiple of [`REPLICATES`].
    pub fn new(
        gatherer: &'a Gatherer<'a>,
        patches: &'a Patches,
        rays: u32,
        seed: u32,
        columns: Columns,
    ) -> RayEstimator<'a> {
        RayEstimator::with_counts(gatherer, patches, &SampleCounts::Alike(rays), seed, columns)
    }

    /// The same where each patch has a number of rays of its own.
    pub fn with_counts(
        gatherer: &'a Gatherer<'a>,
        patches: &'a Patches,
        rays: &SampleCounts,
        seed: u32,
        columns: Columns,
    ) -> RayEstimator<'a> {
        let per_replicate = rays.map(|n| RayEstimator::rounded(n) / REPLICATES as u32);
        let most = per_replicate.most() as usize;
        let materials = patches.materials_in_use(gatherer.surfaces().scene);
        RayEstimator {
            gatherer,
            patches,
            sampler: RowSampler::new(gatherer.surfaces().tracer, patches, most, seed),
            hit_patches: HitPatches::new(gatherer.surfaces(), patches),
            per_replicate,
            seed,
            columns,
            is_specular: materials.iter().any(|m| m.is_specular()),
            spare: Mutex::new(Vec::new()),
        }
    }

    /// `rays` rounded up to a positive multiple of [`REPLICATES`].
    pub(crate) fn rounded(rays: u32) -> u32 {
        rays.div_ceil(REPLICATES as u32).max(1) * REPLICATES as u32
    }

    /// Rays per row, the largest number of all rows.
    pub fn rays(&self) -> u32 {
        self.per_replicate.most() * REPLICATES as u32
    }

    /// Rays of the row of a side.
    pub fn rays_of(&self, side: Side) -> u32 {
        self.per_replicate.of((side / 2) as usize) * REPLICATES as u32
    }

    /// Steps of progress of the row of a side.
    pub(crate) fn steps(&self, side: Side) -> u64 {
        let unit = RAYS_PER_STEP / REPLICATES as u32;
        self.per_replicate.steps((side / 2) as usize, unit)
    }

    /// The name of the ray tracing kernel.
    pub fn kernel_name(&self) -> String {
        self.gatherer.surfaces().tracer.kernel_name()
    }

    /// The row of one side of a patch. Depends only on the arguments of [`new`](RayEstimator::new)
    /// and on `side`.
    pub fn row(&self, side: Side) -> Row {
        Row::from_parts((0..REPLICATES).map(|replicate| self.part(side, replicate)))
    }

    /// The rows of some sides, in order, as [`row`](RayEstimator::row) computes them. Advances
    /// `progress` by the [steps](RayEstimator::steps) of each.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(crate) fn rows(&self, sides: &[Side], progress: &Progress) -> Result<Vec<Row>, Cancelled> {
        let part = |k: usize| {
            let (side, replicate) = (sides[k / REPLICATES], k % REPLICATES);
            progress.advance(steps_of_part(self.steps(side), replicate, REPLICATES))?;
            Ok(self.part(side, replicate))
        };
        let parts = (0..sides.len() * REPLICATES).into_par_iter().map(part);
        let mut parts = parts.collect::<Result<Vec<Row>, _>>()?.into_iter();
        let row = |_: &Side| Row::from_parts(parts.by_ref().take(REPLICATES));
        Ok(sides.iter().map(row).collect())
    }

    /// One replicate of a row.
    fn part(&self, side: Side, replicate: usize) -> Row {
        let mut row = Row {
            rays: self.rays_of(side),
            ..Row::default()
        };
        let mut work = self.work();
        let all = self.per_replicate.of((side / 2) as usize) as usize;
        let share = 1.0 / all as f64;
        if self.is_specular {
            let sides = 2 * self.patches.len();
            work.visits.get_or_insert_with(|| Visits::new(sides));
        }
        for first in (0..all).step_by(BATCH) {
            let stretch = first..(first + BATCH).min(all);
            self.sampler
                .fill(side, replicate, stretch, share, &mut work.paths);
            let paths = work.paths.iter_mut().zip(0..);
            paths.for_each(|(path, number)| path.id = number);
            let chances = hash(&[self.seed, side, replicate as u32, first as u32]);
            self.follow(&mut work, chances, (replicate, 1.0), &mut row);
            work.visits.iter_mut().for_each(|visits| visits.end(share));
        }
        row.entries[replicate] = work.sums.take();
        let visits = work.visits.as_mut();
        row.excess[replicate] = visits.map(Visits::take).unwrap_or_default();
        self.give_back(work);
        row
    }

    /// Empty working memory.
    pub(crate) fn work(&self) -> RowWorkspace {
        let spare = self.spare.lock().ok().and_then(|mut spare| spare.pop());
        spare.unwrap_or_else(|| RowWorkspace {
            paths: Vec::new(),
            scratch: Scratch::default(),
            next_event: NextEvent::default(),
            sums: RowAccumulator::new(2 * self.patches.len()),
            visits: None,
        })
    }

    /// Returns working memory, emptied, for reuse.
    pub(crate) fn give_back(&self, work: RowWorkspace) {
        if let Ok(mut spare) = self.spare.lock() {
            spare.push(work);
        }
    }

    /// Traces the paths of `work` to their ends, and adds what they hit to its sums and to the
    /// replicate of `row`, all times `scale`. `chances` seeds the random choices at glass.
    pub(crate) fn follow(
        &self,
        work: &mut RowWorkspace,
        chances: u32,
        (replicate, scale): (usize, f64),
        row: &mut Row,
    ) {
        let surfaces = self.gatherer.surfaces();
        let share = 1.0 / REPLICATES as f64;
        let up = surfaces.scene.units.up.axis();
        let RowWorkspace {
            paths,
            scratch,
            next_event,
            sums,
            visits,
        } = work;
        follow(surfaces, paths, scratch, chances, |path, event| {
            let weight = path.weight * scale;
            match event {
                Event::Escape => {
                    // Tell sky from ground by the direction in which the path leaves.
                    let is_up = surfaces.tracer.world_ray(&path.leg.ray).direction.dot(up) >= 0.0;
                    row.escaped[replicate][usize::from(!is_up)] += weight;
                    let light = weight * self.gatherer.escaped_exitance(path);
                    row.stray[replicate] += light;
                    row.external += light * share;
                }
                Event::Cut => row.cut += weight * share,
                Event::Absorbed => row.absorbed += weight * share,
                Event::Surface { hit, front } => {
                    let material = surfaces.material(hit.item);
                    // What glass absorbs is an event of its own.
                    if material.dielectric.is_none() {
                        let kept = Rgb::WHITE - material.mirror - material.diffuse;
                        row.absorbed += weight * kept * share;
                    }
                    // Add the emission that the direct light leaves out; glossy surfaces sample the lights besides.
                    row.stray[replicate] +=
                        weight * self.gatherer.stray_exitance(path, &hit, front);
                    next_event.add(self.gatherer, path, &hit, 0, chances);
                    // Keep the columns: a solver needs only those that reflect diffusely.
                    if self.columns == Columns::All || !material.diffuse.is_black() {
                        let patch = self.hit_patches.at(&hit);
                        let (side, order) = (side(patch, front), order(path));
                        sums.add(side, order, weight);
                        if let Some(visits) = visits
                            && (order > 0 || surfaces.is_specular(hit.item))
                        {
                            visits.add(path.id, side, order, weight.mean());
                        }
                    }
                }
            }
        });
        // Trace the shadow rays of glossy surfaces together.
        next_event.resolve(self.gatherer, |_, contribution| {
            row.stray[replicate] += contribution * scale
        });
    }
}
