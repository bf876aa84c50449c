//! Form factors by rays, row after row: the share of a patch's diffuse light that each patch
//! receives, directly or after any chain of mirrors and panes.
//!
//! A row is area-averaged: its rays start all over the patch, in the first two dimensions of a
//! scrambled Sobol sequence, and leave with the cosine's density in the other two (Malley's
//! method), so that a row's entry is the weight of the rays that arrive. Four independent
//! scramblings give four estimates of every row; their spread is its standard error.

use crate::patch::Patches;
use crate::row::{Columns, Entries, Entry, Row, Side, merged, order, side};
use azulejo_scene::Rgb;
use azulejo_scene::math::{Frame, Ray};
use azulejo_trace::follow::{Event, Path, Scratch, Via, follow};
use azulejo_trace::sampling::{SobolTable, cosine_about, hash, seeds};
use azulejo_trace::{Gatherer, REPLICATES};
use std::f64::consts::PI;

/// Computes rows. Immutable; shared by all threads.
pub struct RayEstimator<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    table: SobolTable,
    seed: u32,
    columns: Columns,
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
        let table = SobolTable::new(rays.div_ceil(REPLICATES as u32).max(1) as usize);
        RayEstimator {
            gatherer,
            patches,
            table,
            seed,
            columns,
        }
    }

    /// Rays per row.
    pub fn rays(&self) -> u32 {
        (self.table.len() * REPLICATES) as u32
    }

    /// The row of one side of a patch. Depends on nothing but the arguments of
    /// [`new`](RayEstimator::new) and `side`.
    pub fn row(&self, side: Side, scratch: &mut Scratch) -> Row {
        let mut row = Row {
            rays: self.rays(),
            ..Row::default()
        };
        let mut paths = self.start(side);
        let mut found: [Entries; REPLICATES] = Default::default();
        self.follow(
            &mut paths,
            scratch,
            hash(&[self.seed, side]),
            &mut row,
            &mut found,
        );
        row.entries = found.map(merged);
        row
    }

    /// Rays over the patch and its hemisphere, each carrying its share of a replicate.
    fn start(&self, side: Side) -> Vec<Path> {
        let (patch, flip) = (
            (side / 2) as usize,
            if side.is_multiple_of(2) { 1.0 } else { -1.0 },
        );
        let tracer = self.gatherer.surfaces().tracer;
        let share = 1.0 / self.table.len() as f64;
        let mut paths = Vec::with_capacity(self.table.len() * REPLICATES);
        let flat_frame = Frame::from_normal(flip * self.patches.normal(patch));
        for r in 0..REPLICATES as u32 {
            let scrambling = seeds(&[self.seed, side, r]);
            for k in 0..self.table.len() {
                let [u1, u2, u3, u4] = self.table.point(k, scrambling).map(f64::from);
                let at = self.patches.sample(patch, u1, u2);
                let normal = flip * at.normal;
                let frame = if normal == flat_frame.z {
                    flat_frame
                } else {
                    Frame::from_normal(normal)
                };
                let origin = tracer.leaving(at.position, normal);
                let ray = tracer.kernel_ray(&Ray::new(origin, cosine_about(&frame, u3, u4)));
                let weight = [(share * at.weight) as f32; 3];
                paths.push(Path {
                    ray,
                    id: r,
                    weight,
                    via: Via::Direct,
                    depth: 0,
                });
            }
        }
        paths
    }

    fn follow(
        &self,
        paths: &mut Vec<Path>,
        scratch: &mut Scratch,
        seed: u32,
        row: &mut Row,
        found: &mut [Entries; REPLICATES],
    ) {
        let surfaces = self.gatherer.surfaces();
        let share = 1.0 / REPLICATES as f64;
        let ambient = self.gatherer.ambient() * PI;
        let up = surfaces.scene.units.up.axis();
        follow(surfaces, paths, scratch, seed, |path, event| {
            let weight = Rgb::from(path.weight.map(f64::from));
            let replicate = path.id as usize;
            match event {
                Event::Escape => {
                    let is_up = surfaces.tracer.world_ray(&path.ray).direction.dot(up) >= 0.0;
                    row.escaped[usize::from(!is_up)] += weight * share;
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
                        weight * self.gatherer.stray_exitance(&hit, front, path.via);
                    if self.columns == Columns::All || !material.diffuse.is_black() {
                        let patch = self.patches.locate_hit(surfaces, &hit);
                        found[replicate].push(Entry {
                            side: side(patch, front),
                            order: order(path.via),
                            weight: path.weight,
                        });
                    }
                }
            }
        });
    }
}
