//! Form factors by item buffers: hemicubes rendered from many points of each patch.
//!
//! A hemicube samples what a point sees (Cohen and Greenberg, *The hemi-cube*, SIGGRAPH 1985). From
//! the barycentre alone it would leave an error that no resolution removes, so hemicubes stand at
//! Sobol points all over the patch, each rotated about the normal by a random angle; four
//! scramblings of the points give four estimates, whose spread gives the standard error. A single
//! hemicube stands at the barycentre, and its error is unknown. Flat
//! mirrors are windows to reflected worlds, which the device renders too
//! ([`Engine::Hemicube`](crate::Engine)), or light is traced on from their pixels by rays
//! ([`Engine::Hybrid`](crate::Engine)), as it always is from curved mirrors and glass.
//!
//! Curved patches are rendered as facets (`patch::facets`), and their hemicubes stand on these.

mod backend;
mod world;

use crate::engine::{EngineUsed, Hemicube};
use crate::patch::{PatchFacets, PatchPoint, Patches};
use crate::rays::{BATCH, RayEstimator, RowWorkspace};
use crate::row::{Columns, Order, Row, Side};
use crate::samples::{SampleCounts, steps_of_part};
use azulejo_scene::math::Ray;
use azulejo_scene::{Rgb, Scene, Shape};
use azulejo_trace::follow::{Path, Via};
use azulejo_trace::item_buffer::{
    Beyond, Hemicube as Pixels, NO_MIRROR, Seen, Settings, SpecularPixel, View, World,
};
use azulejo_trace::sampling::{SobolTable, hash, seeds};
use azulejo_trace::{Cancelled, Gatherer, Kernel, Progress, REPLICATES, Surfaces};
use backend::BackendBuffers;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Longest chain of reflected worlds: as many mirrors as rays follow.
const MOST_MIRRORS: u32 = azulejo_trace::follow::DEPTH_CUT as u32;

/// Share of a hemicube below which a window is drawn by chance: about that of a pixel.
pub const WINDOW_CUT: f32 = 1e-4;

/// Windows of a hemicube, besides a few for each level of mirrors. More of them cost time in
/// proportion, and lower an error that the few viewpoints of a patch leave anyway.
pub const MOST_WINDOWS: u32 = 512;

/// Hemicubes of a step of progress, where rows have different numbers of hemicubes.
const HEMICUBES_PER_STEP: u32 = 16;

/// How flat mirrors are treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MirrorHandling {
    /// Their reflected worlds are rendered.
    Windows,
    /// Rays continue from their pixels.
    Rays,
}

/// Computes rows by item buffers. Immutable except for the device; shared by all threads.
pub struct HemicubeEstimator<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    facets: PatchFacets<'a>,
    /// Traces light from pixels of specular patches.
    rays: RayEstimator<'a>,
    buffers: BackendBuffers,
    mirrors: MirrorHandling,
    /// For each patch whether its pixels are listed, for rays to continue from.
    is_listed: Vec<bool>,
    /// Some flat mirror, which stands for all of them in [`Via::Mirror`].
    mirror_item: Option<u32>,
    /// Pixels of a hemicube.
    pixels: u32,
    /// Estimates of a row: four, or a single one from a single hemicube.
    replicates: usize,
    /// Hemicubes of each replicate.
    per_replicate: SampleCounts,
    /// The positions of each replicate.
    table: SobolTable,
    seed: u32,
    columns: Columns,
}

/// The patches of a scene as geometry for item buffers: flat ones as they are, curved ones as
/// facets.
pub fn world_of(scene: &Scene, patches: &Patches) -> World {
    world::world(scene, patches, &PatchFacets::new(patches))
}

/// The position of a hemicube.
struct HemicubePoint {
    view: View,
    /// Where its rays start: on the exact surface of a curved patch instead of its facet.
    start: DVec3,
    /// Weight of its shares.
    weight: f64,
}

/// One replicate of a side's row.
struct RowPart {
    side: Side,
    replicate: usize,
    points: Vec<HemicubePoint>,
    /// The row so far, with this replicate only.
    row: Row,
    /// Accumulates shares over all its hemicubes.
    work: Option<RowWorkspace>,
}

impl<'a> HemicubeEstimator<'a> {
    /// An estimator with the given `options`, with [`Hemicube::eyes`] hemicubes per patch, or as many as `points`
    /// says. A device that is not available, or cannot hold the scene, is replaced by the processor;
    /// [`engine_used`](HemicubeEstimator::engine_used) reports it.
    pub fn new(
        options: &Hemicube,
        points: Option<&SampleCounts>,
        mirrors: MirrorHandling,
        gatherer: &'a Gatherer<'a>,
        patches: &'a Patches,
        seed: u32,
        columns: Columns,
    ) -> HemicubeEstimator<'a> {
        // The scene as facets, and the patches whose reflections item buffers cannot render.
        let facets = PatchFacets::new(patches);
        let world = world::world(gatherer.surfaces().scene, patches, &facets);
        let is_window = |m: u32| m != NO_MIRROR && mirrors == MirrorHandling::Rays;
        let patch = |(&is_bent, &mirror): (&bool, &u32)| is_bent || is_window(mirror);
        let is_listed = world.is_bent.iter().zip(&world.mirror_of).map(patch);
        let is_listed: Vec<bool> = is_listed.collect();
        let settings = Settings {
            resolution: Pixels::new(options.resolution).resolution(),
            mirrors: match mirrors {
                MirrorHandling::Windows => Beyond::Windows {
                    cut: WINDOW_CUT,
                    depth: MOST_MIRRORS,
                    windows: MOST_WINDOWS,
                },
                MirrorHandling::Rays => Beyond::List,
            },
        };
        // Every replicate of a row has equally many hemicubes.
        let eyes = match points {
            Some(points) => points.map(|n| eyes(n.max(2))),
            None => SampleCounts::Alike(options.eyes()),
        };
        let replicates = (eyes.most() as usize).clamp(1, REPLICATES);
        let per_replicate = eyes.map(|n| n / replicates as u32);
        HemicubeEstimator {
            gatherer,
            patches,
            facets,
            rays: RayEstimator::new(gatherer, patches, 1, seed, columns),
            buffers: BackendBuffers::new(world, settings, &options.device),
            mirrors,
            is_listed,
            mirror_item: flat_mirror(gatherer.surfaces()),
            pixels: options.pixels(),
            replicates,
            table: SobolTable::new(per_replicate.most() as usize),
            per_replicate,
            seed,
            columns,
        }
    }

    /// Pixels per row, the largest number of all rows.
    pub fn pixels(&self) -> u32 {
        self.row_pixels(self.per_replicate.most())
    }

    /// Pixels of the row of a side.
    pub fn pixels_of(&self, side: Side) -> u32 {
        self.row_pixels(self.points_of(side) as u32)
    }

    fn row_pixels(&self, per_replicate: u32) -> u32 {
        let hemicubes = per_replicate.saturating_mul(self.replicates as u32);
        self.pixels.saturating_mul(hemicubes)
    }

    /// Hemicubes of each replicate of a side's row.
    fn points_of(&self, side: Side) -> usize {
        self.per_replicate.of((side / 2) as usize) as usize
    }

    /// Steps of progress of the row of a side.
    pub(crate) fn steps(&self, side: Side) -> u64 {
        let unit = HEMICUBES_PER_STEP / REPLICATES as u32;
        self.per_replicate.steps((side / 2) as usize, unit)
    }

    /// Whether the spread of several hemicubes tells the error.
    pub(crate) fn knows_its_spread(&self) -> bool {
        self.replicates > 1
    }

    /// The device, and deviations from what was requested so far.
    pub fn engine_used(&self) -> EngineUsed {
        let listed = self.is_listed.iter().filter(|&&l| l).count();
        let (engine, specular) = match self.mirrors {
            MirrorHandling::Windows => ("hemicube", "patches of curved mirrors or glass"),
            MirrorHandling::Rays => ("hybrid", "specular patches"),
        };
        let mut notes = self.buffers.notes();
        if listed > 0 {
            notes.push(format!(
                "rays continue from the pixels of {listed} {specular}"
            ));
        }
        if !self.knows_its_spread() {
            notes.push(
                "one hemicube per patch: the spread between viewpoints is unknown, and stated \
                 errors leave it out"
                    .to_owned(),
            );
        }
        EngineUsed {
            notes,
            ..EngineUsed::new(engine, self.device(listed > 0))
        }
    }

    /// The device that renders, and the kernel that traces on from pixels if it is not our own.
    fn device(&self, traces: bool) -> String {
        let (device, tracer) = (self.buffers.device(), self.gatherer.surfaces().tracer);
        if traces && tracer.kernel() != Kernel::Own {
            format!("{device}, rays by {}", tracer.kernel_name())
        } else {
            device
        }
    }

    /// The rows of some sides, in order; each depends on its side alone. Advances `progress` by the
    /// steps of each.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn rows(&self, sides: &[Side], progress: &Progress) -> Result<Vec<Row>, Cancelled> {
        let replicates = self.replicates;
        // Rows of as many hemicubes are rendered together.
        let mut order: Vec<usize> = (0..sides.len()).collect();
        order.sort_by_key(|&k| self.points_of(sides[k]));
        let part = |&k: &usize| (0..replicates).map(move |r| (sides[k], r));
        let replicate_keys: Vec<(Side, usize)> = order.iter().flat_map(part).collect();
        let mut parts = Vec::with_capacity(replicate_keys.len());
        for alike in replicate_keys.chunk_by(|a, b| self.points_of(a.0) == self.points_of(b.0)) {
            let at_once = (self.buffers.batch() / self.points_of(alike[0].0)).max(1);
            for some in alike.chunks(at_once) {
                progress.advance(0)?;
                parts.extend(self.parts(some));
                let steps =
                    |&(side, r): &(Side, usize)| steps_of_part(self.steps(side), r, replicates);
                let steps = some.iter().map(steps);
                progress.advance(steps.sum())?;
            }
        }
        let mut rows = vec![Row::default(); sides.len()];
        let mut parts = parts.into_iter();
        for k in order {
            rows[k] = self.joined(sides[k], parts.by_ref().take(replicates));
        }
        Ok(rows)
    }

    /// The row of its replicates.
    fn joined(&self, side: Side, parts: impl Iterator<Item = Row>) -> Row {
        let mut row = Row::from_parts(parts);
        row.rays = self.pixels_of(side);
        if self.replicates == 1 {
            repeat(&mut row);
        }
        row
    }

    /// Some replicates of rows with as many hemicubes each, rendered together.
    fn parts(&self, replicates: &[(Side, usize)]) -> Vec<Row> {
        let part = |&(side, replicate): &(Side, usize)| RowPart {
            side,
            replicate,
            points: self.points(side, replicate),
            row: Row::default(),
            work: None,
        };
        let mut parts: Vec<RowPart> = replicates.par_iter().map(part).collect();
        let batch = (self.buffers.batch() / replicates.len()).max(1);
        let count = parts.first().map_or(0, |part| part.points.len());
        for first in (0..count).step_by(batch) {
            let stretch = first..(first + batch).min(count);
            let some = parts.iter().flat_map(|p| &p.points[stretch.clone()]);
            let views: Vec<View> = some.map(|p| p.view).collect();
            let seen = self.buffers.draw(&views);
            let seen = seen.par_chunks(stretch.len());
            parts.par_iter_mut().zip(seen).for_each(|(part, seen)| {
                for (k, seen) in stretch.clone().zip(seen) {
                    self.add(part, k, seen);
                }
                if stretch.end == count {
                    self.finish(part);
                }
            });
        }
        parts.into_iter().map(|part| part.row).collect()
    }

    /// The positions and weights of the hemicubes of a part.
    ///
    /// On curved patches the weights of points are divided by their sum, so that a row's shares sum
    /// to 1 as they do on flat ones; the bias falls as one over the number of points.
    fn points(&self, side: Side, replicate: usize) -> Vec<HemicubePoint> {
        let (patch, is_front) = ((side / 2) as usize, side.is_multiple_of(2));
        let tracer = self.gatherer.surfaces().tracer;
        let scrambling = seeds(&[self.seed, side, replicate as u32, 0x4e]);
        let leaving = |at: &PatchPoint| {
            let normal = if is_front { at.normal } else { -at.normal };
            (tracer.leaving(at.position, normal), normal)
        };
        let is_central = !self.knows_its_spread() && self.patches.polygon(patch).is_some();
        let point = |k: usize| {
            let [u1, u2, u3, _] = self.table.point(k, scrambling).map(f64::from);
            let turn = TAU * u3;
            if is_central {
                let normal = self.patches.normal(patch);
                let normal = if is_front { normal } else { -normal };
                let centre = self.facets.above(patch, self.patches.centre(patch));
                let eye = tracer.leaving(centre, normal);
                return HemicubePoint {
                    view: View { eye, normal, turn },
                    start: eye,
                    weight: 1.0,
                };
            }
            let at = self.facets.sample(patch, u1, u2);
            let (eye, normal) = leaving(&at);
            HemicubePoint {
                view: View { eye, normal, turn },
                start: leaving(&self.patches.sample(patch, u1, u2)).0,
                weight: at.weight,
            }
        };
        let mut points: Vec<HemicubePoint> = (0..self.points_of(side)).map(point).collect();
        let sum: f64 = points.iter().map(|p| p.weight).sum();
        points.iter_mut().for_each(|p| p.weight /= sum);
        points
    }

    /// Adds what the hemicube at point `k` of a part saw.
    fn add(&self, part: &mut RowPart, k: usize, seen: &Seen) {
        let HemicubePoint { start, weight, .. } = part.points[k];
        let mut work = part.work.take().unwrap_or_else(|| self.rays.work());
        let row = &mut part.row;
        let share = 1.0 / self.replicates as f64;
        for entry in &seen.shares {
            if self.is_listed[(entry.side / 2) as usize] {
                continue; // rays find it again and continue from there
            }
            let arriving = entry.weight * weight;
            let material = self.material(entry.side);
            let kept = Rgb::WHITE - material.mirror - material.diffuse;
            row.absorbed += arriving * kept * share;
            row.stray[part.replicate] += arriving * self.stray(entry.side, entry.order);
            if self.columns == Columns::All || !material.diffuse.is_black() {
                work.sums.add(entry.side, entry.order, arriving);
            }
        }
        let ambient = self.gatherer.ambient() * PI;
        let ways = row.escaped[part.replicate].iter_mut();
        for (escaped, seen) in ways.zip(seen.escaped) {
            let seen = seen * weight;
            *escaped += seen;
            row.stray[part.replicate] += seen * ambient;
            row.external += seen * ambient * share;
        }
        row.cut += seen.cut * (weight * share);
        for (number, pixels) in seen.specular.chunks(BATCH).enumerate() {
            // Paths start with a weight of about 1, because they end when too little of it is left.
            let heaviest = pixels.iter().map(|p| p.weight.max_channel());
            let heaviest = heaviest.fold(f64::MIN_POSITIVE, f64::max);
            let paths = pixels.iter().map(|p| self.path(p, start, heaviest));
            work.paths.extend(paths);
            let place = [part.side, part.replicate as u32, k as u32, number as u32];
            let chances = hash(&[self.seed, hash(&place)]);
            let scaled = (part.replicate, weight * heaviest);
            self.rays.follow(&mut work, chances, scaled, &mut part.row);
        }
        part.work = Some(work);
    }

    /// Takes the sums of a part after all its hemicubes.
    fn finish(&self, part: &mut RowPart) {
        if let Some(mut work) = part.work.take() {
            part.row.entries[part.replicate] = work.sums.take();
            self.rays.give_back(work);
        }
    }

    /// The path of a pixel, in units of `unit`, on the leg that ends at a specular patch: a ray
    /// finds the exact point where the pixel's centre hits it. The first leg begins at `start`.
    fn path(&self, pixel: &SpecularPixel, start: DVec3, unit: f64) -> Path {
        let is_first_leg = pixel.order == 0;
        let origin = if is_first_leg { start } else { pixel.origin };
        let tracer = self.gatherer.surfaces().tracer;
        let ray = tracer.kernel_ray(&Ray::new(origin, pixel.direction));
        Path {
            via: self.via(pixel.order),
            depth: u16::from(pixel.order),
            ..Path::new(ray, 0, pixel.weight / unit)
        }
    }

    /// The path class after `order` rendered mirrors.
    fn via(&self, order: Order) -> Via {
        match (order, self.mirror_item) {
            (0, _) => Via::Direct,
            (1, Some(item)) => Via::Mirror(item),
            _ => Via::Many,
        }
    }

    fn material(&self, side: Side) -> &azulejo_scene::Material {
        let scene = self.gatherer.surfaces().scene;
        &scene.materials[self.patches.material((side / 2) as usize) as usize]
    }

    /// Exitance of a side that direct lighting does not count, as [`Gatherer::stray_exitance`]
    /// computes it for hits.
    fn stray(&self, side: Side, order: Order) -> Rgb {
        let material = self.material(side);
        if !material.is_emitter() {
            return Rgb::BLACK;
        }
        let patch = (side / 2) as usize;
        let object = self.patches.face(patch).object;
        let shape = &self.gatherer.surfaces().scene.objects[object as usize].shape;
        let is_flat = self.patches.polygon(patch).is_some();
        let is_exact = matches!(shape, Shape::Exact(_));
        let id = self.patches.material(patch);
        let form = self.gatherer.emitter_form(object, id, is_flat);
        if !is_exact && self.gatherer.counts_direct(form, self.via(order)) {
            Rgb::BLACK
        } else {
            let front = side.is_multiple_of(2);
            self.patches.emission(patch, material, front) * PI
        }
    }
}

impl Hemicube {
    /// Hemicubes per patch: one, or the next multiple of [`REPLICATES`].
    pub fn eyes(&self) -> u32 {
        eyes(self.points)
    }

    /// Pixels of all hemicubes of a row.
    pub(crate) fn pixels_per_row(&self) -> u32 {
        self.pixels().saturating_mul(self.eyes())
    }

    /// Pixels of a hemicube.
    fn pixels(&self) -> u32 {
        let side = Pixels::new(self.resolution).resolution();
        3 * side * side
    }
}

/// `points`, rounded up to a multiple of [`REPLICATES`] if there are several.
fn eyes(points: u32) -> u32 {
    match points {
        0 | 1 => 1,
        points => points.div_ceil(REPLICATES as u32) * REPLICATES as u32,
    }
}

/// Puts a single estimate in the place of all replicates, so that their mean is the estimate.
fn repeat(row: &mut Row) {
    let entries = row.entries[0].clone();
    row.entries.fill(entries);
    row.stray = [row.stray[0]; REPLICATES];
    row.escaped = [row.escaped[0]; REPLICATES];
}

/// Some flat item that mirrors.
fn flat_mirror(surfaces: &Surfaces) -> Option<u32> {
    let is_mirror = |&item: &u32| {
        let material = surfaces.material(item);
        surfaces.flat_normal(item).is_some()
            && material.dielectric.is_none()
            && !material.mirror.is_black()
    };
    (0..surfaces.tracer.item_count()).find(is_mirror)
}
