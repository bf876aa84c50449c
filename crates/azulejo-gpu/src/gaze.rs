//! What one view has found so far, and where it looks on: the windows of mirrors, level by level.

use crate::atlas::{Atlas, FACES};
use crate::face::{Picture, Region, picture};
use crate::mesh::{Kind, Mesh};
use crate::sight::Sight;
use crate::tally::{Shares, Tally};
use crate::target::NOTHING;
use azulejo_scene::Rgb;
use azulejo_trace::item_buffer::{Beyond, Seen, SpecularPixel};
use glam::DVec3;
use std::ops::Range;

/// Most windows that are drawn for one view; what further ones would show counts as cut. Worlds
/// of countless small mirrors that face each other would otherwise never be done. Tests get there
/// sooner.
const MOST_WINDOWS: usize = if cfg!(test) { 500 } else { 16_384 };

/// What gazes have in common.
pub struct Ground<'a> {
    pub mesh: &'a Mesh,
    /// Shares of the pixels of a hemicube, which sum to 1.
    pub weights: &'a [f64],
    pub atlas: &'a Atlas,
    pub beyond: Beyond,
}

/// The pixels of a tile, read back.
#[derive(Clone, Copy)]
pub struct Pixels<'a> {
    pub sides: &'a [u32],
    /// 1/w in local coordinates, as bits; there if somebody asks for distances.
    pub nearness: Option<&'a [u32]>,
    /// Words from row to row.
    pub stride: usize,
}

/// Pixels that show one reflected world.
struct Window {
    sight: Sight,
    /// Its pixels, among those of the level.
    pixels: Range<usize>,
    /// What they carry in the strongest channel.
    share: f64,
}

/// One view on its way through the mirrors.
pub struct Gaze {
    /// The tile that it is drawn in.
    pub tile: u32,
    sight: Sight,
    shares: Shares,
    seen: Seen,
    /// Mirrors on the way.
    depth: u32,
    windows: Vec<Window>,
    /// Pixels of the windows, sorted in each.
    pixels: Vec<u32>,
    /// Windows opened so far.
    opened: usize,
}

/// What windows ask of the card: their pictures, and for each pixel of some rows its window.
pub struct Request {
    pub pictures: Vec<Picture>,
    pub first_row: u32,
    pub numbers: Vec<u32>,
}

impl Gaze {
    pub fn new(tile: u32, sight: Sight) -> Gaze {
        Gaze {
            tile,
            sight,
            shares: Shares::default(),
            seen: Seen::default(),
            depth: 0,
            windows: Vec::new(),
            pixels: Vec::new(),
            opened: 0,
        }
    }

    /// The pictures of the world as it is seen straight.
    pub fn straight(&self, ground: &Ground) -> Vec<Picture> {
        let face = |face| {
            let region = Region::whole(ground.atlas.resolution, face);
            let place = (self.tile, face);
            picture(ground.mesh, ground.atlas, &self.sight, place, &region, 0)
        };
        (0..FACES).map(face).collect()
    }

    /// The world's up along the axes of the hemicube.
    pub fn up(&self, ground: &Ground) -> [f32; 4] {
        let [x, y, z] = self.sight.axes.map(|a| a.dot(ground.mesh.up) as f32);
        [x, y, z, 0.0]
    }

    pub fn has_windows(&self) -> bool {
        !self.windows.is_empty()
    }

    /// Takes what the card has added up, in units of 1/`scale`; says whether pixels have to be
    /// read, because some go on.
    pub fn add_sums(&mut self, ground: &Ground, sums: &[u32], scale: f64) -> bool {
        let mut goes_on = false;
        for (slot, words) in (0u32..).zip(sums.chunks_exact(2)) {
            let whole = u64::from(words[1]) << 32 | u64::from(words[0]);
            if whole == 0 {
                continue;
            }
            let share = Rgb::grey(whole as f64 / scale);
            match slot.checked_sub(2 * ground.mesh.patches) {
                Some(way) => self.seen.escaped[way as usize] += share,
                None => {
                    self.shares.add(slot, 0, share);
                    goes_on |= ground.mesh.kind(slot / 2) != Kind::Matt;
                }
            }
        }
        goes_on
    }

    /// Reads all pixels of the straight view. Shares are added up unless the card has done it.
    pub fn read_all(&mut self, ground: &Ground, pixels: Pixels, tally: Option<&mut Tally>) {
        let mut reader = Reader::new(ground, &self.sight, 0, pixels, tally);
        let n = ground.atlas.resolution;
        for row in 0..3 * n {
            reader.row(row, 0..n);
        }
        let found = reader.finished(&mut self.seen, &mut self.shares);
        self.open(ground, vec![(self.sight.clone(), found)]);
    }

    /// Reads the pixels of all windows.
    pub fn read_windows(&mut self, ground: &Ground, pixels: Pixels, tally: &mut Tally) {
        self.depth += 1;
        let n = ground.atlas.resolution;
        let mut found = Vec::new();
        for window in std::mem::take(&mut self.windows) {
            let tally = Some(&mut *tally);
            let mut reader = Reader::new(ground, &window.sight, self.depth, pixels, tally);
            let listed = &self.pixels[window.pixels.clone()];
            for run in listed.chunk_by(|a, b| a + 1 == *b && b % n != 0) {
                let first = run[0] % n;
                reader.row(run[0] / n, first..first + run.len() as u32);
            }
            let mirrored = reader.finished(&mut self.seen, &mut self.shares);
            found.push((window.sight, mirrored));
        }
        self.open(ground, found);
    }

    /// Opens windows for pixels that show mirrors, each group by the sight that sees them.
    fn open(&mut self, ground: &Ground, found: Vec<(Sight, Vec<(u32, u32)>)>) {
        let Beyond::Windows { cut, depth } = ground.beyond else {
            return;
        };
        self.pixels.clear();
        for (sight, mut mirrored) in found {
            mirrored.sort_unstable();
            for group in mirrored.chunk_by(|a, b| a.0 == b.0) {
                let number = group[0].0;
                let mirror = &ground.mesh.mirrors[number as usize];
                let sight = sight.behind(number, &mirror.plane, mirror.reflectance);
                let weight = |&(_, p): &(u32, u32)| ground.weights[p as usize];
                let share: f64 = group.iter().map(weight).sum();
                let strongest = sight.tint.max_channel();
                if strongest <= 0.0 || strongest < f64::from(cut) || self.depth >= depth {
                    self.seen.cut += sight.tint * share;
                    continue;
                }
                let first = self.pixels.len();
                self.pixels.extend(group.iter().map(|&(_, p)| p));
                self.windows.push(Window {
                    sight,
                    pixels: first..self.pixels.len(),
                    share: strongest * share,
                });
            }
        }
        self.keep_the_strongest(ground.weights);
        self.opened += self.windows.len();
    }

    /// Closes windows until few enough are left, the weakest first.
    fn keep_the_strongest(&mut self, weights: &[f64]) {
        let room = MOST_WINDOWS - self.opened.min(MOST_WINDOWS);
        if self.windows.len() <= room {
            return;
        }
        // Stable: among equals those stay that were found first.
        self.windows.sort_by(|a, b| b.share.total_cmp(&a.share));
        for window in self.windows.drain(room..) {
            let pixels = &self.pixels[window.pixels];
            let share: f64 = pixels.iter().map(|&p| weights[p as usize]).sum();
            self.seen.cut += window.sight.tint * share;
        }
    }

    /// What the card has to draw next; windows are numbered from 1.
    pub fn request(&self, ground: &Ground) -> Request {
        let n = ground.atlas.resolution;
        let rows = self.windows.iter().flat_map(|w| {
            let pixels = &self.pixels[w.pixels.clone()];
            [pixels[0] / n, pixels[pixels.len() - 1] / n]
        });
        let (first, last) = rows.fold((u32::MAX, 0), |(a, b), row| (a.min(row), b.max(row)));
        let mut request = Request {
            pictures: Vec::new(),
            first_row: first,
            numbers: vec![0; ((last + 1 - first) * n) as usize],
        };
        for (number, window) in (1..).zip(&self.windows) {
            let mut regions = [const { Region::EMPTY }; FACES];
            for &p in &self.pixels[window.pixels.clone()] {
                request.numbers[(p - first * n) as usize] = number;
                let (face, column, row) = ground.atlas.place(p);
                regions[face].add(column, row);
            }
            for (face, region) in regions.iter().enumerate() {
                if !region.columns.is_empty() {
                    let (mesh, atlas) = (ground.mesh, ground.atlas);
                    let place = (self.tile, face);
                    let picture = picture(mesh, atlas, &window.sight, place, region, number);
                    request.pictures.push(picture);
                }
            }
        }
        request
    }

    /// All that was found; nothing is left.
    pub fn take(&mut self) -> Seen {
        Seen {
            shares: std::mem::take(&mut self.shares).finished(),
            ..std::mem::take(&mut self.seen)
        }
    }
}

/// Reads the pixels of one sight.
struct Reader<'a> {
    ground: &'a Ground<'a>,
    sight: &'a Sight,
    depth: u32,
    pixels: Pixels<'a>,
    tally: Option<&'a mut Tally>,
    /// The world's up in the pictures of the faces: coefficients of u, v and 1.
    ups: [[f64; 3]; FACES],
    /// Pixels of mirrors with windows.
    mirrored: Vec<(u32, u32)>,
    specular: Vec<SpecularPixel>,
    /// Share that escaped, upwards and downwards.
    escaped: [f64; 2],
}

impl<'a> Reader<'a> {
    fn new(
        ground: &'a Ground,
        sight: &'a Sight,
        depth: u32,
        pixels: Pixels<'a>,
        tally: Option<&'a mut Tally>,
    ) -> Reader<'a> {
        let up = ground.mesh.up;
        Reader {
            ground,
            sight,
            depth,
            pixels,
            tally,
            ups: std::array::from_fn(|face| sight.face(face).map(|a| a.dot(up))),
            mirrored: Vec::new(),
            specular: Vec::new(),
            escaped: [0.0; 2],
        }
    }

    /// Reads some columns of a row of the tile.
    fn row(&mut self, row: u32, columns: Range<u32>) {
        let n = self.ground.atlas.resolution;
        let start = row as usize * self.pixels.stride;
        let range = start + columns.start as usize..start + columns.end as usize;
        let mut pixel = row * n + columns.start;
        for run in self.pixels.sides[range].chunk_by(|a, b| a == b) {
            let end = pixel + run.len() as u32;
            self.run(run[0], pixel..end);
            pixel = end;
        }
    }

    /// Takes neighbours in a row that show one side.
    fn run(&mut self, side: u32, pixels: Range<u32>) {
        let weights = &self.ground.weights[pixels.start as usize..pixels.end as usize];
        // A number that is no side's can only come from a broken driver: nothing is there.
        if side == NOTHING || side / 2 >= self.ground.mesh.patches {
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
        match (self.ground.mesh.kind(side / 2), self.ground.beyond) {
            (Kind::Matt, _) => {}
            (Kind::Mirror(mirror), Beyond::Windows { .. }) => {
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

    /// Face, and point of its picture.
    fn picture(&self, pixel: u32) -> (usize, f64, f64) {
        let (face, column, row) = self.ground.atlas.place(pixel);
        let at = |k: u32| (2.0 * f64::from(k) + 1.0) / f64::from(self.ground.atlas.resolution);
        let low = if face == 0 { -1.0 } else { 0.0 };
        (face, at(column) - 1.0, at(row) + low)
    }

    fn looks_up(&self, pixel: u32) -> bool {
        let (face, u, v) = self.picture(pixel);
        let [a, b, c] = self.ups[face];
        a * u + b * v + c >= 0.0
    }

    fn specular(&self, pixel: u32, side: u32) -> SpecularPixel {
        let (face, u, v) = self.picture(pixel);
        let axes = self.sight.face(face);
        let direction: DVec3 = u * axes[0] + v * axes[1] + axes[2];
        let (n, p) = (self.ground.atlas.resolution, pixel);
        let place = (p / n) as usize * self.pixels.stride + (p % n) as usize;
        let nearness = self.pixels.nearness.map_or(0, |bits| bits[place]);
        let along = 1.0 / f64::from(f32::from_bits(nearness)).max(1e-30);
        // The leg begins where the sight leaves the last mirror.
        let start = self.sight.begin_in(&axes).map_or(0.0, |[a, b, c]| {
            (1.0 / (a * u + b * v + c).max(1e-30)).min(along)
        });
        let local = &self.ground.mesh.local;
        SpecularPixel {
            origin: local.world_point(self.sight.eye + start * direction),
            direction: direction.normalize(),
            distance: (along - start) * direction.length() * local.reach,
            side,
            order: self.order(),
            weight: self.sight.tint * self.ground.weights[p as usize],
        }
    }

    fn order(&self) -> u8 {
        self.depth.min(2) as u8
    }

    /// Hands over what was found; returns the pixels that show mirrors.
    fn finished(self, seen: &mut Seen, shares: &mut Shares) -> Vec<(u32, u32)> {
        let order = self.order();
        let tint = self.sight.tint;
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
