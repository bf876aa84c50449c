//! Form factors by rays, row after row: the share of a patch's diffuse light that each patch
//! receives, directly or after any chain of mirrors and panes.
//!
//! A row is area-averaged: its rays start all over the patch, in the first two dimensions of a
//! scrambled Sobol sequence, and leave with the cosine's density in the other two (Malley's
//! method), so that a row's entry is the weight of the rays that arrive. Four independent
//! scramblings give four estimates of every row; their spread is its standard error.

use crate::patch::Patches;
use azulejo_scene::Rgb;
use azulejo_scene::math::{Frame, Ray};
use azulejo_trace::follow::{Event, Path, Scratch, Via, follow};
use azulejo_trace::sampling::{SobolTable, cosine_about, hash, seeds, sobol};
use azulejo_trace::{DirectLight, GatherPoint, Gatherer, REPLICATES};
use std::f64::consts::PI;

/// One side of a patch: twice the patch for the front, one more for the back.
pub type Side = u32;

/// The side of `patch` that is seen from its front, or from its back.
pub fn side(patch: u32, front: bool) -> Side {
    2 * patch + u32::from(!front)
}

/// Entries of one replicate of a row, sorted by side.
pub type Entries = Vec<(Side, [f32; 3])>;

/// What the rays of one side of a patch found.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Per replicate, the extended form factor to each side that was reached.
    pub entries: [Entries; REPLICATES],
    /// Per replicate, irradiance from emission and surroundings that the rays met and that
    /// [`RayEstimator::direct`] does not count, W/m².
    pub stray: [Rgb; REPLICATES],
    /// The part of `stray` that came from the surroundings.
    pub foreign: Rgb,
    /// Share of the rays' weight that surfaces absorbed.
    pub absorbed: Rgb,
    /// Share that left the scene.
    pub escaped: Rgb,
    /// Share that was cut off because it was too weak, or reflected too often.
    pub cut: Rgb,
    /// Rays traced from the patch, without those that mirrors added.
    pub rays: u32,
}

/// Which sides of patches a row keeps as columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Columns {
    /// All that rays reach, mirrors too: whole rows, whose shares add up.
    All,
    /// Only sides that reflect diffusely: what a solver needs.
    Diffuse,
}

/// Computes rows. Immutable; shared by all threads.
pub struct RayEstimator<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    table: SobolTable,
    seed: u32,
    columns: Columns,
}

/// Positions per replicate at which a patch's direct light is computed.
const DIRECT_POSITIONS: u32 = 4;

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
        for (sorted, mut raw) in row.entries.iter_mut().zip(found) {
            // A stable sort keeps the order of the rays, so sums don't depend on anything else.
            raw.sort_by_key(|&(j, _)| j);
            *sorted = merged(&raw);
        }
        row
    }

    /// Rays over the patch and its hemisphere, each carrying its share of a replicate.
    pub(crate) fn start(&self, side: Side) -> Vec<Path> {
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
        follow(surfaces, paths, scratch, seed, |path, event| {
            let weight = Rgb::from(path.weight.map(f64::from));
            let replicate = path.id as usize;
            match event {
                Event::Escape => {
                    row.escaped += weight * share;
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
                        found[replicate].push((side_of(patch, front), path.weight));
                    }
                }
            }
        });
    }

    /// The light that formulas count on one side of a patch, area-averaged.
    pub fn direct(&self, side: Side) -> DirectLight {
        let (patch, flip) = (
            (side / 2) as usize,
            if side.is_multiple_of(2) { 1.0 } else { -1.0 },
        );
        let mut points = Vec::with_capacity(REPLICATES * DIRECT_POSITIONS as usize);
        for r in 0..REPLICATES as u32 {
            let [s1, s2, ..] = seeds(&[self.seed, side, r, 0xd1]);
            for k in 0..DIRECT_POSITIONS {
                let at = self
                    .patches
                    .sample(patch, sobol(k, 0, s1).into(), sobol(k, 1, s2).into());
                let key = hash(&[side, r, k]);
                points.push(GatherPoint {
                    position: at.position,
                    normal: flip * at.normal,
                    key,
                });
            }
        }
        let found = self.gatherer.direct(&points, 1, self.seed);
        let mut light = DirectLight::default();
        let share = 1.0 / f64::from(DIRECT_POSITIONS);
        for (k, at) in found.iter().enumerate() {
            light.lamps.replicates[k / DIRECT_POSITIONS as usize] += at.lamps.mean() * share;
            light.lights += at.lights * (share / REPLICATES as f64);
        }
        light
    }
}

use side as side_of;

/// Entries of equal side added up.
fn merged(sorted: &[(Side, [f32; 3])]) -> Entries {
    let mut out: Entries = Vec::with_capacity(sorted.len());
    for &(j, w) in sorted {
        match out.last_mut() {
            Some((last, sum)) if *last == j => (0..3).for_each(|k| sum[k] += w[k]),
            _ => out.push((j, w)),
        }
    }
    out
}
