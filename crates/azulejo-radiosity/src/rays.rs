//! Form factors by rays, row after row: the share of a patch's diffuse light that each patch
//! receives, directly or after any chain of mirrors and panes.
//!
//! A row is area-averaged: its rays start all over the patch, in the first two dimensions of a
//! scrambled Sobol sequence, and leave with the cosine's density in the other two (Malley's
//! method), so that a row's entry is the weight of the rays that arrive. Four independent
//! scramblings give four estimates of every row; their spread is its standard error.

use crate::patch::Patches;
use crate::row::{Columns, Row, Side, Tally, order, side};
use azulejo_scene::Rgb;
use azulejo_scene::math::{Frame, Ray};
use azulejo_trace::follow::{Event, Path, Scratch, Via, follow};
use azulejo_trace::sampling::{SobolTable, cosine_about, hash, seeds};
use azulejo_trace::{Gatherer, KernelHit, NextEvent, REPLICATES, Surfaces, Tracer};
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Mutex;

/// Rays followed at a time: enough to keep the tracer busy, few enough to stay in the cache.
pub(crate) const BATCH: usize = 1024;

/// Where the rays of rows start and where they go.
pub(crate) struct Starts<'a> {
    tracer: &'a Tracer,
    patches: &'a Patches,
    table: SobolTable,
    seed: u32,
}

impl<'a> Starts<'a> {
    /// At most `count` rays per side and replicate.
    pub fn new(tracer: &'a Tracer, patches: &'a Patches, count: usize, seed: u32) -> Starts<'a> {
        Starts {
            tracer,
            patches,
            table: SobolTable::new(count),
            seed,
        }
    }

    /// Rays over a side and its hemisphere, a stretch of a replicate's sequence; each carries the
    /// `share`.
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
            Path {
                ray: self
                    .tracer
                    .kernel_ray(&Ray::new(origin, cosine_about(&frame, u3, u4))),
                id: replicate as u32,
                weight: Rgb::grey(share * at.weight),
                via: Via::Direct,
                depth: 0,
                density: 0.0,
            }
        }));
    }
}

/// Finds the patch of a hit: at once where all of what was hit is one patch.
pub(crate) struct HitPatches<'a> {
    surfaces: &'a Surfaces<'a>,
    patches: &'a Patches,
    /// For each item its only patch, or [`SEVERAL`].
    only: Vec<u32>,
}

const SEVERAL: u32 = u32::MAX;

impl<'a> HitPatches<'a> {
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

/// Computes rows. Immutable; shared by all threads.
pub struct RayEstimator<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    starts: Starts<'a>,
    hit_patches: HitPatches<'a>,
    per_replicate: usize,
    seed: u32,
    columns: Columns,
    /// Working memory that no thread uses at the moment.
    spare: Mutex<Vec<Work>>,
}

/// What it takes to compute a row.
pub(crate) struct Work {
    /// Rays that are about to be followed.
    pub paths: Vec<Path>,
    scratch: Scratch,
    next_event: NextEvent,
    /// What they have met.
    pub tally: Tally,
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
        let per_replicate = rays.div_ceil(REPLICATES as u32).max(1) as usize;
        RayEstimator {
            gatherer,
            patches,
            starts: Starts::new(gatherer.surfaces().tracer, patches, per_replicate, seed),
            hit_patches: HitPatches::new(gatherer.surfaces(), patches),
            per_replicate,
            seed,
            columns,
            spare: Mutex::new(Vec::new()),
        }
    }

    /// Rays per row.
    pub fn rays(&self) -> u32 {
        (self.per_replicate * REPLICATES) as u32
    }

    /// Who traces.
    pub fn kernel_name(&self) -> String {
        self.gatherer.surfaces().tracer.kernel_name()
    }

    /// The row of one side of a patch. Depends on nothing but the arguments of
    /// [`new`](RayEstimator::new) and `side`.
    pub fn row(&self, side: Side) -> Row {
        let mut row = Row {
            rays: self.rays(),
            ..Row::default()
        };
        let mut work = self.work();
        let (all, share) = (self.per_replicate, 1.0 / self.per_replicate as f64);
        for replicate in 0..REPLICATES {
            for first in (0..all).step_by(BATCH) {
                let stretch = first..(first + BATCH).min(all);
                self.starts
                    .fill(side, replicate, stretch, share, &mut work.paths);
                let chances = hash(&[self.seed, side, replicate as u32, first as u32]);
                self.follow(&mut work, chances, (replicate, 1.0), &mut row);
            }
            row.entries[replicate] = work.tally.take();
        }
        self.give_back(work);
        row
    }

    /// Memory to work with, empty.
    pub(crate) fn work(&self) -> Work {
        let spare = self.spare.lock().ok().and_then(|mut spare| spare.pop());
        spare.unwrap_or_else(|| Work {
            paths: Vec::new(),
            scratch: Scratch::default(),
            next_event: NextEvent::default(),
            tally: Tally::new(2 * self.patches.len()),
        })
    }

    /// Keeps memory, emptied, for the next that asks.
    pub(crate) fn give_back(&self, work: Work) {
        if let Ok(mut spare) = self.spare.lock() {
            spare.push(work);
        }
    }

    /// Follows the paths of `work` to their ends, and adds what they meet to its tally and to
    /// what `row` says of a replicate, all times `scale`. `chances` keys the choices at glass.
    pub(crate) fn follow(
        &self,
        work: &mut Work,
        chances: u32,
        (replicate, scale): (usize, f64),
        row: &mut Row,
    ) {
        let surfaces = self.gatherer.surfaces();
        let share = 1.0 / REPLICATES as f64;
        let ambient = self.gatherer.ambient() * PI;
        let up = surfaces.scene.units.up.axis();
        let Work {
            paths,
            scratch,
            next_event,
            tally,
        } = work;
        follow(surfaces, paths, scratch, chances, |path, event| {
            let weight = path.weight * scale;
            match event {
                Event::Escape => {
                    let is_up = surfaces.tracer.world_ray(&path.ray).direction.dot(up) >= 0.0;
                    row.escaped[replicate][usize::from(!is_up)] += weight;
                    row.stray[replicate] += weight * ambient;
                    row.foreign += weight * ambient * share;
                }
                Event::Cut => row.cut += weight * share,
                Event::Absorbed => row.absorbed += weight * share,
                Event::Surface { hit, front } => {
                    let material = surfaces.material(hit.item);
                    if material.dielectric.is_none() {
                        let kept = Rgb::WHITE - material.mirror - material.diffuse;
                        row.absorbed += weight * kept * share;
                    }
                    row.stray[replicate] +=
                        weight * self.gatherer.stray_exitance(path, &hit, front);
                    next_event.add(self.gatherer, path, &hit, 0, chances);
                    if self.columns == Columns::All || !material.diffuse.is_black() {
                        let patch = self.hit_patches.at(&hit);
                        tally.add(side(patch, front), order(path.via), weight);
                    }
                }
            }
        });
        next_event.resolve(self.gatherer, |_, found| {
            row.stray[replicate] += found * scale
        });
    }
}
