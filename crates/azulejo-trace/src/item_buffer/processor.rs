//! Item buffers drawn by the processor, in software: always available.

use super::face::Face;
use super::prepared_world::LocalWorld;
use super::raster::{Canvas, NOTHING, Region, draw};
use super::tally::Tally;
use super::view::{DepthPrecision, HemicubeView, PatchOptics};
use super::{
    Beyond, Device, DrawError, Hemicube, ItemBuffers, Seen, Settings, SpecularPixel, View,
    WindowBudget, World,
};
use azulejo_scene::Rgb;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Mutex;

/// The processor as a [`Device`]: draws views side by side on all threads of the current rayon
/// pool, each alone on its thread. Never fails.
///
/// Works in `f32` about the world's centre, planes in `f64`. Facets thinner than 1e-9 of their
/// length, with corners that are not finite, or of nonexistent patches are left out. Of coplanar
/// facets (to 1e-8 of the world's size) the lowest patch is visible. Facets in the viewpoint's own
/// plane are invisible, and so are, in a mirror, those nearer to its plane than 2e-6 of half the
/// world's size or, if that is more, of the mirrored viewpoint's distance. Each thread needs 8
/// bytes per pixel, up to 36 where no two neighbours show the same patch of a mirror, and 24 per
/// patch, regardless of how many mirrors face each other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Processor;

/// Views per thread in a call.
const BATCH: usize = 16;
/// Pixels per thread in a call, but at least one view: all pixels may be listed.
const MOST_PIXELS: usize = 1 << 20;

impl Device for Processor {
    fn name(&self) -> String {
        "processor".to_owned()
    }

    fn load(&self, world: &World, settings: &Settings) -> Result<Box<dyn ItemBuffers>, DrawError> {
        Ok(Box::new(ProcessorBuffers::new(world, settings)))
    }
}

/// A world ready to be drawn by the processor.
pub struct ProcessorBuffers {
    world: LocalWorld,
    cube: Hemicube,
    /// Delta form factors of the pixels, in `f64`; their sum is 1 to the last digits.
    weights: Vec<f64>,
    /// The sum of the weights before each pixel, and of all: adding up each run by itself would take as long as
    /// drawing it.
    weights_before: Vec<f64>,
    beyond: Beyond,
    /// Centres of columns and rows, −1..1.
    centres: Vec<f32>,
    /// Working memory that no thread is using.
    idle: Mutex<Vec<RasterScratch>>,
}

impl ItemBuffers for ProcessorBuffers {
    fn batch(&self) -> usize {
        let most = MOST_PIXELS / self.weights.len();
        rayon::current_num_threads().max(1) * most.clamp(1, BATCH)
    }

    fn draw(&self, views: &[View]) -> Result<Vec<Seen>, DrawError> {
        Ok(self.see(views))
    }
}

/// Pixels and sums of one view at a time.
struct RasterScratch {
    /// Nearness of what each pixel shows; infinite between draws.
    nearness: Vec<f32>,
    sides: Vec<u32>,
    tally: Tally,
}

/// Consecutive pixels in one row of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct PixelRun {
    first: u32,
    count: u32,
}

impl PixelRun {
    fn end(self) -> u32 {
        self.first + self.count
    }

    /// The numbers of its pixels.
    fn pixels(self) -> Range<usize> {
        self.first as usize..self.end() as usize
    }
}

/// Pixels that show one reflected world.
struct MirrorWindow {
    view: HemicubeView,
    /// Its pixels, among the runs of the level, ascending.
    runs: Range<usize>,
    /// Their delta form factors, before any mirror.
    share: f64,
}

/// All windows behind the same number of mirrors.
#[derive(Default)]
struct WindowLevel {
    windows: Vec<MirrorWindow>,
    runs: Vec<PixelRun>,
}

impl ProcessorBuffers {
    /// Copies a world.
    pub fn new(world: &World, settings: &Settings) -> ProcessorBuffers {
        let cube = Hemicube::new(settings.resolution);
        let n = cube.resolution();
        let centre = |k: u32| ((2.0 * f64::from(k) + 1.0) / f64::from(n) - 1.0) as f32;
        let sum: f64 = cube.weights().iter().map(|&w| f64::from(w)).sum();
        let weights = cube.weights().iter().map(|&w| f64::from(w) / sum);
        let weights: Vec<f64> = weights.collect();
        let mut weights_before = vec![0.0];
        weights_before.extend(weights.iter().scan(0.0, |sum, weight| {
            *sum += weight;
            Some(*sum)
        }));
        ProcessorBuffers {
            world: LocalWorld::new(world),
            beyond: settings.mirrors,
            centres: (0..n).map(centre).collect(),
            weights,
            weights_before,
            cube,
            idle: Mutex::default(),
        }
    }

    /// Draws hemicubes as [`ItemBuffers::draw`] does, without ever failing.
    pub fn see(&self, views: &[View]) -> Vec<Seen> {
        views.par_iter().map(|view| self.see_one(view)).collect()
    }

    fn see_one(&self, view: &View) -> Seen {
        let idle = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        let mut scratch = idle.unwrap_or_else(|| self.scratch());
        let seen = self.see_with(view, &mut scratch);
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(scratch);
        }
        seen
    }

    fn scratch(&self) -> RasterScratch {
        let pixels = self.cube.pixels() as usize;
        RasterScratch {
            nearness: vec![f32::INFINITY; pixels],
            sides: vec![NOTHING; pixels],
            tally: Tally::new(self.world.patches),
        }
    }

    /// Draws level by level: the view behind k mirrors is drawn after all views behind fewer, into
    /// the pixels that show the last mirror. Windows of one level never overlap.
    fn see_with(&self, view: &View, scratch: &mut RasterScratch) -> Seen {
        let mut seen = Seen::default();
        let count = self.side() as u32;
        let rows = (0..self.cube.pixels()).step_by(self.side());
        let rows: Vec<PixelRun> = rows.map(|first| PixelRun { first, count }).collect();
        let whole = MirrorWindow {
            view: HemicubeView::new(view, &self.world.local, DepthPrecision::Double),
            runs: 0..rows.len(),
            share: 1.0,
        };
        let mut budget = match self.beyond {
            Beyond::Windows { cut, windows, .. } => WindowBudget::new(&whole.view, cut, windows),
            Beyond::List => WindowBudget::new(&whole.view, 0.0, 0),
        };
        let mut level = WindowLevel {
            windows: vec![whole],
            runs: rows,
        };
        let mut depth = 0;
        while !level.windows.is_empty() {
            let mut next = WindowLevel::default();
            for window in &level.windows {
                let runs = &level.runs[window.runs.clone()];
                self.draw_view(&window.view, depth, runs, scratch, &mut seen, &mut next);
            }
            thin(&mut next, &mut budget, &mut seen);
            level = next;
            depth += 1;
        }
        seen.shares = scratch.tally.take();
        seen
    }

    /// Draws some pixels, which are sorted, and adds up their form factors; mirrors are left to the
    /// next level.
    fn draw_view(
        &self,
        view: &HemicubeView,
        depth: u32,
        runs: &[PixelRun],
        scratch: &mut RasterScratch,
        seen: &mut Seen,
        next: &mut WindowLevel,
    ) {
        let mut mirrored = Vec::new();
        for runs in runs.chunk_by(|a, b| self.face_of(a.first) == self.face_of(b.first)) {
            let number = self.face_of(runs[0].first);
            let face = Face::new(view, number);
            self.draw_face(number, &face, runs, scratch);
            let drawn = DrawnFace {
                buffers: self,
                view,
                face: &face,
                depth,
            };
            drawn.read(runs, scratch, seen, &mut mirrored);
        }
        mirrored.sort_unstable();
        for group in mirrored.chunk_by(|a, b| a.0 == b.0) {
            self.open(view, depth, group, seen, next);
        }
    }

    /// Draws the world into some pixels of a face.
    fn draw_face(
        &self,
        number: usize,
        face: &Face,
        runs: &[PixelRun],
        scratch: &mut RasterScratch,
    ) {
        let mut region = Region::EMPTY;
        for run in runs {
            scratch.nearness[run.pixels()].fill(0.0);
            scratch.sides[run.pixels()].fill(NOTHING);
            let (column, row) = self.column_and_row(run.first);
            region.add(column..column + run.count as usize, row);
        }
        let range = self.pixels_of(number);
        let mut canvas = Canvas {
            nearness: &mut scratch.nearness[range.clone()],
            sides: &mut scratch.sides[range],
            centres: &self.centres,
            first_row: if number == 0 { 0 } else { self.side() / 2 },
        };
        draw(&self.world, face, &region, &mut canvas);
    }

    /// Opens a window for the pixels of one mirror, or counts them as cut.
    fn open(
        &self,
        view: &HemicubeView,
        depth: u32,
        group: &[(u32, PixelRun)],
        seen: &mut Seen,
        next: &mut WindowLevel,
    ) {
        let number = group[0].0;
        let view = view.behind(number, &self.world.mirrors[number as usize]);
        let share: f64 = group.iter().map(|&(_, run)| self.weight(run)).sum();
        let is_open = matches!(self.beyond, Beyond::Windows { depth: most, .. } if depth < most);
        if !is_open {
            seen.cut += view.tint * share;
            return;
        }
        let first = next.runs.len();
        for &(_, run) in group {
            // Adjacent pieces of one mirror form one run.
            match next.runs[first..].last_mut() {
                Some(last) if last.end() == run.first && self.column_and_row(run.first).0 > 0 => {
                    last.count += run.count;
                }
                _ => next.runs.push(run),
            }
        }
        next.windows.push(MirrorWindow {
            view,
            runs: first..next.runs.len(),
            share,
        });
    }

    /// The delta form factor of a run's pixels, before any mirror.
    fn weight(&self, run: PixelRun) -> f64 {
        let Range { start, end } = run.pixels();
        self.weights_before[end] - self.weights_before[start]
    }

    /// Pixels along a face.
    fn side(&self) -> usize {
        self.centres.len()
    }

    /// The pixels of a face.
    fn pixels_of(&self, face: usize) -> Range<usize> {
        let (n, half) = (self.side(), self.side() * self.side() / 2);
        match face {
            0 => 0..n * n,
            _ => n * n + (face - 1) * half..n * n + face * half,
        }
    }

    fn face_of(&self, pixel: u32) -> usize {
        let (p, n) = (pixel as usize, self.side());
        match p.checked_sub(n * n) {
            None => 0,
            Some(rest) => 1 + rest / (n * n / 2),
        }
    }

    /// Column and row of a pixel; rows of side faces begin at the horizon, in the middle.
    fn column_and_row(&self, pixel: u32) -> (usize, usize) {
        let (p, n) = (pixel as usize, self.side());
        match p.checked_sub(n * n) {
            None => (p % n, p / n),
            Some(rest) => (rest % n, rest % (n * n / 2) / n + n / 2),
        }
    }
}

/// Leaves those windows that are to be drawn; what the others carry is cut.
fn thin(level: &mut WindowLevel, budget: &mut WindowBudget, seen: &mut Seen) {
    let weight = |w: &MirrorWindow| w.view.tint.max_channel() * w.share;
    let weights: Vec<f64> = level.windows.iter().map(weight).collect();
    let mut factors = budget.factors(&weights).into_iter();
    level.windows.retain_mut(|window| {
        let factor = factors.next().unwrap_or(0.0);
        if factor != 1.0 {
            seen.cut += window.view.tint * (window.share * (1.0 - factor));
            window.view.tint *= factor;
        }
        factor > 0.0
    });
}

/// A face whose pixels have been drawn.
struct DrawnFace<'a> {
    buffers: &'a ProcessorBuffers,
    view: &'a HemicubeView,
    face: &'a Face,
    /// Mirrors on the way.
    depth: u32,
}

impl DrawnFace<'_> {
    /// Adds up the pixels, collects those that show mirrors with the mirrors' numbers, and closes
    /// the pixels for what is drawn next.
    fn read(
        &self,
        runs: &[PixelRun],
        scratch: &mut RasterScratch,
        seen: &mut Seen,
        mirrored: &mut Vec<(u32, PixelRun)>,
    ) {
        for run in runs {
            let mut first = run.first;
            for alike in scratch.sides[run.pixels()].chunk_by(|a, b| a == b) {
                let count = alike.len() as u32;
                let run = PixelRun { first, count };
                first += count;
                if alike[0] == NOTHING {
                    self.escape(run, seen);
                    continue;
                }
                let share = self.view.tint * self.buffers.weight(run);
                let order = self.depth.min(2) as u8;
                scratch.tally.add(alike[0], order, share);
                match (self.buffers.world.optics(alike[0] / 2), self.buffers.beyond) {
                    (PatchOptics::Diffuse, _) => {}
                    (PatchOptics::Mirror(mirror), Beyond::Windows { .. }) => {
                        mirrored.push((mirror, run))
                    }
                    _ => {
                        let pixels = (run.first..run.end()).zip(&scratch.nearness[run.pixels()]);
                        let specular = pixels.map(|(p, &near)| self.specular(p, alike[0], near));
                        seen.specular.extend(specular);
                    }
                }
            }
            scratch.nearness[run.pixels()].fill(f32::INFINITY);
        }
    }

    /// Adds pixels that show nothing to what leaves the world upwards and downwards.
    fn escape(&self, run: PixelRun, seen: &mut Seen) {
        let up = self.face.components(self.buffers.world.up);
        for p in run.first..run.end() {
            let (x, y) = self.image_point(p);
            let is_up = x * up[0] + y * up[1] + up[2] >= 0.0;
            seen.escaped[usize::from(!is_up)] += self.share(p);
        }
    }

    /// The weight of a pixel.
    fn share(&self, pixel: u32) -> Rgb {
        self.view.tint * self.buffers.weights[pixel as usize]
    }

    /// The point of the face's image in the middle of a pixel.
    fn image_point(&self, pixel: u32) -> (f64, f64) {
        let (column, row) = self.buffers.column_and_row(pixel);
        let centre = |k: usize| f64::from(self.buffers.centres[k]);
        (centre(column), centre(row))
    }

    fn specular(&self, pixel: u32, side: u32, nearness: f32) -> SpecularPixel {
        let (x, y) = self.image_point(pixel);
        let local = &self.buffers.world.local;
        let direction = self.face.direction(x, y);
        let along = 1.0 / f64::from(nearness);
        // The segment begins where the line of sight leaves the last mirror.
        let start = self.face.begin.as_ref().map_or(0.0, |begin| {
            let [a, b, c] = begin.nearness;
            (1.0 / (a * x + b * y + c)).min(along)
        });
        SpecularPixel {
            origin: local.world_point(self.view.eye + start * direction),
            direction: direction.normalize(),
            distance: (along - start) * direction.length() * local.reach,
            side,
            order: self.depth.min(2) as u8,
            weight: self.share(pixel),
        }
    }
}
