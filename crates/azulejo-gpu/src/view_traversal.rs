//! The traversal of one view through its mirrors, level by level: the results so far, and the
//! windows to draw next.

use crate::atlas::{Atlas, FACES};
use crate::face::{FaceDrawing, FaceRegion, face_drawing};
use crate::mesh::Mesh;
use crate::tally::{Shares, Tally};
use crate::target::NOTHING;
use azulejo_scene::Rgb;
use azulejo_trace::item_buffer::{
    Beyond, HemicubeView, PatchOptics, Seen, SpecularPixel, WindowBudget,
};
use glam::DVec3;
use std::ops::Range;

/// Data that all views of a batch share.
pub struct ViewContext<'a> {
    pub mesh: &'a Mesh,
    /// Delta form factors of the pixels of a hemicube, which sum to 1.
    pub weights: &'a [f64],
    pub atlas: &'a Atlas,
    pub beyond: Beyond,
}

/// The pixels of a tile, read back.
#[derive(Clone, Copy)]
pub struct Pixels<'a> {
    pub sides: &'a [u32],
    /// 1/w in local coordinates, as bits; present if distances are requested.
    pub nearness: Option<&'a [u32]>,
    /// Row stride in words.
    pub stride: usize,
}

/// Pixels that show one reflected world.
struct WindowPixels {
    view: HemicubeView,
    /// Its pixels, among those of the level.
    pixels: Range<usize>,
    /// Their delta form factors, before any mirror.
    share: f64,
}

/// The traversal of one view.
pub struct ViewTraversal {
    /// Its tile in the atlas.
    pub tile: u32,
    view: HemicubeView,
    shares: Shares,
    seen: Seen,
    /// Number of mirrors on the way.
    depth: u32,
    windows: Vec<WindowPixels>,
    /// Pixels of the windows, sorted within each.
    pixels: Vec<u32>,
    /// What is left of the windows that may be drawn.
    budget: WindowBudget,
}

/// Drawings of windows: their faces, and the window of each pixel in some rows.
pub struct WindowRequest {
    pub drawings: Vec<FaceDrawing>,
    pub first_row: u32,
    pub numbers: Vec<u32>,
}

impl ViewTraversal {
    pub fn new(tile: u32, view: HemicubeView, beyond: Beyond) -> ViewTraversal {
        let budget = match beyond {
            Beyond::Windows { cut, windows, .. } => WindowBudget::new(&view, cut, windows),
            Beyond::List => WindowBudget::new(&view, 0.0, 0),
        };
        ViewTraversal {
            tile,
            view,
            shares: Shares::default(),
            seen: Seen::default(),
            depth: 0,
            windows: Vec::new(),
            pixels: Vec::new(),
            budget,
        }
    }

    /// The faces of the directly visible world.
    pub fn straight(&self, context: &ViewContext) -> Vec<FaceDrawing> {
        let face = |face| {
            let region = FaceRegion::whole(context.atlas.resolution, face);
            let target = (self.tile, face);
            face_drawing(context.mesh, context.atlas, &self.view, target, &region, 0)
        };
        (0..FACES).map(face).collect()
    }

    /// The world's up along the axes of the hemicube.
    pub fn up(&self, context: &ViewContext) -> [f32; 4] {
        let [x, y, z] = self.view.axes.map(|a| a.dot(context.mesh.up) as f32);
        [x, y, z, 0.0]
    }

    pub fn has_windows(&self) -> bool {
        !self.windows.is_empty()
    }

    /// Takes the sums of the card, in units of 1/`scale`; returns whether pixels have to be read
    /// because light continues at some of them.
    pub fn add_sums(&mut self, context: &ViewContext, sums: &[u32], scale: f64) -> bool {
        let mut goes_on = false;
        for (slot, words) in (0u32..).zip(sums.chunks_exact(2)) {
            let whole = u64::from(words[1]) << 32 | u64::from(words[0]);
            if whole == 0 {
                continue;
            }
            let share = Rgb::grey(whole as f64 / scale);
            match slot.checked_sub(2 * context.mesh.patches) {
                Some(way) => self.seen.escaped[way as usize] += share,
                None => {
                    self.shares.add(slot, 0, share);
                    goes_on |= context.mesh.optics(slot / 2) != PatchOptics::Diffuse;
                }
            }
        }
        goes_on
    }

    /// Reads all pixels of the direct view. Their form factors are summed unless the card has done
    /// so.
    pub fn read_all(&mut self, context: &ViewContext, pixels: Pixels, tally: Option<&mut Tally>) {
        let mut reader = PixelReader::new(context, &self.view, 0, pixels, tally);
        let n = context.atlas.resolution;
        for row in 0..3 * n {
            reader.row(row, 0..n);
        }
        let shares = reader.finished(&mut self.seen, &mut self.shares);
        self.open(context, vec![(self.view.clone(), shares)]);
    }

    /// Reads the pixels of all windows.
    pub fn read_windows(&mut self, context: &ViewContext, pixels: Pixels, tally: &mut Tally) {
        self.depth += 1;
        let n = context.atlas.resolution;
        let mut windows = Vec::new();
        for window in std::mem::take(&mut self.windows) {
            let tally = Some(&mut *tally);
            let mut reader = PixelReader::new(context, &window.view, self.depth, pixels, tally);
            let listed = &self.pixels[window.pixels.clone()];
            for run in listed.chunk_by(|a, b| a + 1 == *b && b % n != 0) {
                let first = run[0] % n;
                reader.row(run[0] / n, first..first + run.len() as u32);
            }
            let mirrored = reader.finished(&mut self.seen, &mut self.shares);
            windows.push((window.view, mirrored));
        }
        self.open(context, windows);
    }

    /// Opens windows for pixels that show mirrors, grouped by view.
    fn open(&mut self, context: &ViewContext, found: Vec<(HemicubeView, Vec<(u32, u32)>)>) {
        let Beyond::Windows { depth, .. } = context.beyond else {
            return;
        };
        self.pixels.clear();
        for (view, mut mirrored) in found {
            mirrored.sort_unstable();
            for group in mirrored.chunk_by(|a, b| a.0 == b.0) {
                let number = group[0].0;
                let mirror = &context.mesh.mirrors[number as usize];
                let view = view.behind(number, mirror);
                let weight = |&(_, p): &(u32, u32)| context.weights[p as usize];
                let share: f64 = group.iter().map(weight).sum();
                if self.depth >= depth {
                    self.seen.cut += view.tint * share;
                    continue;
                }
                let first = self.pixels.len();
                self.pixels.extend(group.iter().map(|&(_, p)| p));
                self.windows.push(WindowPixels {
                    view,
                    pixels: first..self.pixels.len(),
                    share,
                });
            }
        }
        self.thin();
    }

    /// Leaves those windows that are to be drawn; what the others carry is cut.
    fn thin(&mut self) {
        let weight = |w: &WindowPixels| w.view.tint.max_channel() * w.share;
        let weights: Vec<f64> = self.windows.iter().map(weight).collect();
        let mut factors = self.budget.factors(&weights).into_iter();
        let cut = &mut self.seen.cut;
        self.windows.retain_mut(|window| {
            let factor = factors.next().unwrap_or(0.0);
            if factor != 1.0 {
                *cut += window.view.tint * (window.share * (1.0 - factor));
                window.view.tint *= factor;
            }
            factor > 0.0
        });
    }

    /// The next drawings of the card; windows are numbered from 1.
    pub fn request(&self, context: &ViewContext) -> WindowRequest {
        let n = context.atlas.resolution;
        let rows = self.windows.iter().flat_map(|w| {
            let pixels = &self.pixels[w.pixels.clone()];
            [pixels[0] / n, pixels[pixels.len() - 1] / n]
        });
        let (first, last) = rows.fold((u32::MAX, 0), |(a, b), row| (a.min(row), b.max(row)));
        let mut request = WindowRequest {
            drawings: Vec::new(),
            first_row: first,
            numbers: vec![0; ((last + 1 - first) * n) as usize],
        };
        for (number, window) in (1..).zip(&self.windows) {
            let mut regions = [const { FaceRegion::EMPTY }; FACES];
            for &p in &self.pixels[window.pixels.clone()] {
                request.numbers[(p - first * n) as usize] = number;
                let (face, column, row) = context.atlas.locate(p);
                regions[face].add(column, row);
            }
            for (face, region) in regions.iter().enumerate() {
                if !region.columns.is_empty() {
                    let (mesh, atlas) = (context.mesh, context.atlas);
                    let target = (self.tile, face);
                    let drawing = face_drawing(mesh, atlas, &window.view, target, region, number);
                    request.drawings.push(drawing);
                }
            }
        }
        request
    }

    /// Takes the results.
    pub fn take(&mut self) -> Seen {
        Seen {
            shares: std::mem::take(&mut self.shares).finished(),
            ..std::mem::take(&mut self.seen)
        }
    }
}

/// Reads the pixels of one view.
struct PixelReader<'a> {
    context: &'a ViewContext<'a>,
    view: &'a HemicubeView,
    depth: u32,
    pixels: Pixels<'a>,
    tally: Option<&'a mut Tally>,
    /// The world's up in the images of the faces: coefficients of u, v and 1.
    ups: [[f64; 3]; FACES],
    /// Pixels of mirrors with windows.
    mirrored: Vec<(u32, u32)>,
    specular: Vec<SpecularPixel>,
    /// Share that escaped, upwards and downwards.
    escaped: [f64; 2],
}

impl<'a> PixelReader<'a> {
    fn new(
        context: &'a ViewContext,
        view: &'a HemicubeView,
        depth: u32,
        pixels: Pixels<'a>,
        tally: Option<&'a mut Tally>,
    ) -> PixelReader<'a> {
        let up = context.mesh.up;
        PixelReader {
            context,
            view,
            depth,
            pixels,
            tally,
            ups: std::array::from_fn(|face| view.face_axes(face).map(|a| a.dot(up))),
            mirrored: Vec::new(),
            specular: Vec::new(),
            escaped: [0.0; 2],
        }
    }

    /// Reads some columns of a row of the tile.
    fn row(&mut self, row: u32, columns: Range<u32>) {
        let n = self.context.atlas.resolution;
        let start = row as usize * self.pixels.stride;
        let range = start + columns.start as usize..start + columns.end as usize;
        let mut pixel = row * n + columns.start;
        for run in self.pixels.sides[range].chunk_by(|a, b| a == b) {
            let end = pixel + run.len() as u32;
            self.run(run[0], pixel..end);
            pixel = end;
        }
    }

    /// Adds consecutive pixels in a row that show the same side.
    fn run(&mut self, side: u32, pixels: Range<u32>) {
        let weights = &self.context.weights[pixels.start as usize..pixels.end as usize];
        // An invalid side can only come from a broken driver: it counts as nothing.
        if side == NOTHING || side / 2 >= self.context.mesh.patches {
            if self.tally.is_some() {
                for (p, weight) in pixels.zip(weights) {
                    self.escaped[usize::from(!self.looks_up(p))] += weight;
                }
            }
            return;
        }
        if let Some(tally) = &mut self.tally {
            tally.add(side, weights.iter().sum());
        }
        match (self.context.mesh.optics(side / 2), self.context.beyond) {
            (PatchOptics::Diffuse, _) => {}
            (PatchOptics::Mirror(mirror), Beyond::Windows { .. }) => {
                self.mirrored.extend(pixels.map(|p| (mirror, p)));
            }
            _ => {
                for p in pixels {
                    let pixel = self.specular(p, side);
                    self.specular.push(pixel);
                }
            }
        }
    }

    /// Face, and point of its image.
    fn image_point(&self, pixel: u32) -> (usize, f64, f64) {
        let (face, column, row) = self.context.atlas.locate(pixel);
        let at = |k: u32| (2.0 * f64::from(k) + 1.0) / f64::from(self.context.atlas.resolution);
        let low = if face == 0 { -1.0 } else { 0.0 };
        (face, at(column) - 1.0, at(row) + low)
    }

    fn looks_up(&self, pixel: u32) -> bool {
        let (face, u, v) = self.image_point(pixel);
        let [a, b, c] = self.ups[face];
        a * u + b * v + c >= 0.0
    }

    fn specular(&self, pixel: u32, side: u32) -> SpecularPixel {
        let (face, u, v) = self.image_point(pixel);
        let axes = self.view.face_axes(face);
        let direction: DVec3 = u * axes[0] + v * axes[1] + axes[2];
        let (n, p) = (self.context.atlas.resolution, pixel);
        let word = (p / n) as usize * self.pixels.stride + (p % n) as usize;
        let nearness = self.pixels.nearness.map_or(0, |bits| bits[word]);
        let along = 1.0 / f64::from(f32::from_bits(nearness)).max(1e-30);
        // The segment begins at the last mirror on the way.
        let start = self.view.begin_nearness(&axes).map_or(0.0, |[a, b, c]| {
            (1.0 / (a * u + b * v + c).max(1e-30)).min(along)
        });
        let local = &self.context.mesh.local;
        SpecularPixel {
            origin: local.world_point(self.view.eye + start * direction),
            direction: direction.normalize(),
            distance: (along - start) * direction.length() * local.reach,
            side,
            order: self.order(),
            weight: self.view.tint * self.context.weights[p as usize],
        }
    }

    fn order(&self) -> u8 {
        self.depth.min(2) as u8
    }

    /// Adds the results to the view's; returns the pixels that show mirrors.
    fn finished(self, seen: &mut Seen, shares: &mut Shares) -> Vec<(u32, u32)> {
        let order = self.order();
        let tint = self.view.tint;
        for (all, part) in seen.escaped.iter_mut().zip(self.escaped) {
            *all += tint * part;
        }
        if let Some(tally) = self.tally {
            tally
                .take()
                .for_each(|(side, share)| shares.add(side, order, tint * share));
        }
        seen.specular.extend(self.specular);
        self.mirrored
    }
}
