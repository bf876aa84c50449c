//! Surfaces that emit a picture, sampled texel by texel.
//!
//! Every triangle is divided into cells of about a texel, and a cell is chosen in proportion to what it
//! emits: a black picture with one bright window costs no more than a lamp of the window's size.

use super::emitters::{Emission, EmitterPoint};
use super::flat_faces::FaceKey;
use crate::Surfaces;
use crate::sampling::uniform;
use azulejo_scene::{Rgb, Texture};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Most cells of all triangles together, beside one for each triangle: 8 bytes each. Where texels are
/// more, cells hold several.
const MOST_CELLS: f64 = (1 << 20) as f64;

/// Most cells along one side of a triangle.
const MOST_STEPS: u32 = 1024;

/// Most samples along each side of a cell, by which its brightness is estimated.
const MOST_PER_CELL: u32 = 8;

/// Share of the samples that are spread over all of the area, so that nothing is missed that is smaller
/// than what the estimates of cells resolve.
const EVERYWHERE: f64 = 0.01;

/// Triangles that show more texels than this are taken to show some that shine.
const MOST_TEXELS_READ: u64 = 4096;

/// A triangle of a surface that emits a picture.
struct PicturedTriangle<'a> {
    key: FaceKey,
    corners: [DVec3; 3],
    uvs: [DVec2; 3],
    texture: &'a Texture,
    /// Radiance where the picture is white, W/(sr·m²).
    emission: Rgb,
    emits_back: bool,
    /// Cells along each side.
    steps: u32,
    /// The number of its first cell.
    first: usize,
}

/// All surfaces of a scene that emit pictures, as one light.
#[derive(Default)]
pub(crate) struct PicturedEmitters<'a> {
    /// Ascending by their keys; those that show only black are left out.
    triangles: Vec<PicturedTriangle<'a>>,
    /// Per cell, the probability of all cells up to it.
    ends: Vec<f64>,
    /// Power of both sides, mean over the channels, W/sr: to be divided by that of all lights.
    pub share: f64,
}

/// A place on a triangle in cells.
struct CellPlace {
    /// Its number within the triangle.
    number: usize,
    row: u32,
    column: u32,
    /// Whether it is one of the cells that are turned round.
    is_turned: bool,
}

impl CellPlace {
    /// The cell of a triangle of `steps` cells a side that holds barycentric weights `u`, `v`.
    fn holding(u: f64, v: f64, steps: u32) -> CellPlace {
        let (x, y) = (u * f64::from(steps), v * f64::from(steps));
        let row = (x.max(0.0) as u32).min(steps - 1);
        let column = (y.max(0.0) as u32).min(steps - 1 - row);
        let is_turned = (x - f64::from(row)) + (y - f64::from(column)) > 1.0;
        CellPlace::new(row, column, is_turned && row + column + 1 < steps, steps)
    }

    fn new(row: u32, column: u32, is_turned: bool, steps: u32) -> CellPlace {
        // A row of index i has 2(n − i) − 1 cells.
        let (i, n) = (row as usize, steps as usize);
        CellPlace {
            number: i * (2 * n - i) + 2 * column as usize + usize::from(is_turned),
            row,
            column,
            is_turned,
        }
    }

    /// The cell of that number.
    fn numbered(number: usize, steps: u32) -> CellPlace {
        // The largest i with i (2n − i) ≤ number; the root is right to within one row.
        let (n, k) = (f64::from(steps), number as f64);
        let root = n - (n * n - k).max(0.0).sqrt();
        let before = |i: u32| i as usize * (2 * steps - i) as usize;
        let mut row = (root as u32).min(steps - 1);
        while row > 0 && before(row) > number {
            row -= 1;
        }
        while row + 1 < steps && before(row + 1) <= number {
            row += 1;
        }
        let rest = number - before(row);
        CellPlace::new(row, (rest / 2) as u32, rest % 2 == 1, steps)
    }

    /// Barycentric weights in the triangle of those in the cell.
    fn weights(&self, a: f64, b: f64, steps: u32) -> [f64; 2] {
        let at = |index: u32, x: f64| {
            let x = if self.is_turned { 1.0 - x } else { x };
            (f64::from(index) + x) / f64::from(steps)
        };
        [at(self.row, a), at(self.column, b)]
    }
}

impl PicturedTriangle<'_> {
    /// Half the cross product of two of its sides: the normal of the front, as long as the area.
    fn area_vector(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        0.5 * (b - a).cross(c - a)
    }

    fn sides(&self) -> f64 {
        if self.emits_back { 2.0 } else { 1.0 }
    }

    /// Its longest side in texels.
    fn texels(&self) -> f64 {
        let size = self.texture.image.as_ref();
        let size = size.map_or(DVec2::ZERO, |i| DVec2::new(i.width.into(), i.height.into()));
        let [a, b, c] = self.uvs.map(|uv| uv * size);
        let longest = (a - b).length().max((b - c).length()).max((c - a).length());
        if longest.is_finite() { longest } else { 1.0 }
    }

    fn cells(&self) -> usize {
        self.steps as usize * self.steps as usize
    }

    /// Radiance at barycentric weights.
    fn radiance(&self, [u, v]: [f64; 2]) -> Rgb {
        let [a, b, c] = self.uvs;
        let color = self.texture.sample(a + u * (b - a) + v * (c - a));
        self.emission * Rgb::from(color.unwrap_or_default().map(f64::from))
    }

    /// Whether a cheap test proves that all that it shows is black.
    fn is_black(&self) -> bool {
        let [a, b, c] = self.uvs;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        self.texture
            .is_black_between(low, high, MOST_TEXELS_READ)
            .unwrap_or(false)
    }

    /// The power of each cell, mean over the channels, by samples spread evenly.
    fn powers(&self) -> Vec<f64> {
        let per_side = (self.texels() / f64::from(self.steps)).ceil();
        let n = (per_side as u32).clamp(1, MOST_PER_CELL);
        let area = self.area_vector().length() * self.sides() / self.cells() as f64;
        let power = |number: usize| {
            let cell = CellPlace::numbered(number, self.steps);
            let value = |k: usize| {
                let part = CellPlace::numbered(k, n);
                let value = |[a, b]: [f64; 2]| {
                    let [a, b] = part.weights(a, b, n);
                    self.radiance(cell.weights(a, b, self.steps)).mean()
                };
                if n > 1 {
                    // Parts of a cell are about as small as texels: their middles miss none.
                    return value([1.0 / 3.0; 2]);
                }
                // Toward the corners, too, so that nothing bright is missed.
                let corners = [
                    [1.0 / 6.0; 2],
                    [2.0 / 3.0, 1.0 / 6.0],
                    [1.0 / 6.0, 2.0 / 3.0],
                ];
                corners.map(value).iter().sum::<f64>() / 3.0
            };
            let parts = (n * n) as usize;
            let mean = (0..parts).map(value).sum::<f64>() / parts as f64;
            if mean.is_finite() { mean * area } else { 0.0 }
        };
        (0..self.cells()).into_par_iter().map(power).collect()
    }
}

impl<'a> PicturedEmitters<'a> {
    /// Collects the triangles of all surfaces that emit pictures.
    pub fn new(surfaces: &Surfaces<'a>) -> PicturedEmitters<'a> {
        let mut triangles = shining_triangles(surfaces);
        let cells: f64 = triangles.iter().map(|t| t.texels().max(1.0).powi(2)).sum();
        let coarser = (MOST_CELLS / cells).sqrt().min(1.0);
        let mut count = 0;
        for triangle in &mut triangles {
            let steps = (triangle.texels() * coarser).floor();
            // Rounded down where the budget matters, so that it holds.
            let steps = if coarser < 1.0 { steps } else { steps + 1.0 };
            triangle.steps = (steps as u32).clamp(1, MOST_STEPS);
            triangle.first = count;
            count += triangle.cells();
        }
        let mut ends: Vec<f64> = Vec::with_capacity(count);
        for triangle in &triangles {
            ends.extend(triangle.powers());
        }
        let power: f64 = ends.iter().sum();
        if power.is_nan() || power <= 0.0 {
            return PicturedEmitters::default();
        }
        let area = |t: &PicturedTriangle| t.area_vector().length() * t.sides();
        let whole: f64 = triangles.iter().map(area).sum();
        let mut sum = 0.0;
        for triangle in &triangles {
            let everywhere = EVERYWHERE * area(triangle) / (whole * triangle.cells() as f64);
            for end in &mut ends[triangle.first..][..triangle.cells()] {
                sum += (1.0 - EVERYWHERE) * *end / power + everywhere;
                *end = sum;
            }
        }
        PicturedEmitters {
            triangles,
            ends,
            share: power,
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The point of two numbers in 0..1, and what it emits.
    ///
    /// # Panics
    /// If there is no emitter.
    pub fn point(&self, u: (f64, f64)) -> (Emission, EmitterPoint) {
        let last = self.ends.len() - 1;
        // The numbers have 24 bits, fewer than cells and places in them need.
        let fine = uniform(&[
            u.0.to_bits() as u32,
            (u.0.to_bits() >> 32) as u32,
            u.1.to_bits() as u32,
            (u.1.to_bits() >> 32) as u32,
        ]);
        let chosen = (u.0 + f64::from(fine) / f64::from(1 << 24)) * self.ends[last];
        let number = self.ends.partition_point(|&end| end <= chosen).min(last);
        let before = if number == 0 {
            0.0
        } else {
            self.ends[number - 1]
        };
        let rest = ((chosen - before) / (self.ends[number] - before)).clamp(0.0, 1.0);
        let index = self.triangles.partition_point(|t| t.first <= number) - 1;
        let triangle = &self.triangles[index];
        let cell = CellPlace::numbered(number - triangle.first, triangle.steps);
        // Osada et al. 2002, eq. (1): uniform over the triangle.
        let a = rest.sqrt();
        let at = cell.weights(a * (1.0 - u.1), a * u.1, triangle.steps);
        let [p, q, r] = triangle.corners;
        let across = triangle.area_vector();
        let point = EmitterPoint {
            position: p + at[0] * (q - p) + at[1] * (r - p),
            normal: across.normalize_or_zero(),
            area: self.area(triangle, number),
        };
        let emission = Emission {
            radiance: triangle.radiance(at),
            emits_back: triangle.emits_back,
            share: self.share,
        };
        (emission, point)
    }

    /// Area of a cell over its probability.
    fn area(&self, triangle: &PicturedTriangle, number: usize) -> f64 {
        let before = if number == 0 {
            0.0
        } else {
            self.ends[number - 1]
        };
        let whole = self.ends[self.ends.len() - 1];
        let probability = (self.ends[number] - before) / whole;
        triangle.area_vector().length() / (triangle.cells() as f64 * probability)
    }

    /// The share of these emitters among the lights, and one over the density by area of
    /// [`point`](PicturedEmitters::point) at barycentric weights of a triangle; `None` for one that is
    /// never chosen.
    pub fn find(&self, key: FaceKey, (u, v): (f64, f64)) -> Option<(f64, f64)> {
        let index = self.triangles.binary_search_by_key(&key, |t| t.key).ok()?;
        let triangle = &self.triangles[index];
        let cell = CellPlace::holding(u, v, triangle.steps);
        let area = self.area(triangle, triangle.first + cell.number);
        Some((self.share, area))
    }
}

/// The triangles of all surfaces that emit pictures and show some light, in the order of their keys.
fn shining_triangles<'a>(surfaces: &Surfaces<'a>) -> Vec<PicturedTriangle<'a>> {
    let scene = surfaces.scene;
    let mut triangles = Vec::new();
    for (object, o) in (0..).zip(&scene.objects) {
        let Some(mesh) = o.shape.mesh() else {
            continue;
        };
        for (face, &id) in (0u32..).zip(&mesh.face_materials) {
            let Some(texture) = surfaces.emitted_picture(object, id) else {
                continue;
            };
            let material = &scene.materials[id as usize];
            for triangle in 0..mesh.faces.get(face as usize).len().saturating_sub(2) as u32 {
                let Some((corners, uvs)) = surfaces.triangle(object, face, triangle) else {
                    continue;
                };
                let shown = PicturedTriangle {
                    key: FaceKey {
                        object,
                        face,
                        triangle,
                    },
                    corners,
                    uvs,
                    texture,
                    emission: material.emission,
                    emits_back: material.emits_back,
                    steps: 1,
                    first: 0,
                };
                if shown.area_vector() != DVec3::ZERO && !shown.is_black() {
                    triangles.push(shown);
                }
            }
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tracer;
    use crate::sampling::sobol;
    use azulejo_scene::{Attribute, Image, Material, Mesh, Object, Scene, Shape};

    #[test]
    fn cells_hold_their_places() {
        for steps in [1, 2, 7, 100] {
            for number in 0..(steps * steps) as usize {
                let cell = CellPlace::numbered(number, steps);
                assert_eq!(cell.number, number);
                let [u, v] = cell.weights(0.3, 0.4, steps);
                assert!(u > 0.0 && v > 0.0 && u + v < 1.0, "{u} {v}");
                assert_eq!(CellPlace::holding(u, v, steps).number, number);
            }
        }
    }

    /// A rectangle of 2 × 1 that shows `image` once.
    fn sheet(image: Image) -> Scene {
        let mut scene = Scene::default();
        scene.textures.push(Texture {
            image: Some(image),
            ..Texture::default()
        });
        let lamp = scene.add_material(Material {
            emission_picture: Some(0),
            ..Material::emitter("lamp", Rgb::new(1.0, 2.0, 3.0))
        });
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut mesh = Mesh {
            positions: corners.map(|[x, y]| DVec3::new(2.0 * x, y, 0.0)).to_vec(),
            uvs: Some(Attribute::per_vertex(corners.map(DVec2::from).to_vec())),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], lamp);
        scene.objects.push(Object::new("sheet", Shape::Mesh(mesh)));
        scene.validate().unwrap();
        scene
    }

    /// ∫ L dA by this many samples, and the spread of one of them; the density must be that of hits.
    fn integral(scene: &Scene, count: u32) -> (Rgb, f64) {
        let tracer = Tracer::new(scene);
        let surfaces = Surfaces::new(scene, &tracer);
        let lamps = PicturedEmitters::new(&surfaces);
        let (mut sum, mut squares) = (Rgb::BLACK, 0.0);
        for k in 0..count {
            let u = [0, 1].map(|d| f64::from(sobol(k, d, 7)));
            let (emission, point) = lamps.point((u[0], u[1]));
            let value = emission.radiance * point.area;
            sum += value;
            squares += value.mean().powi(2);
            let ray = azulejo_scene::math::Ray::new(point.position + DVec3::Z, -DVec3::Z);
            let mut hits = Vec::new();
            tracer.closest(&[tracer.kernel_ray(&ray)], &mut hits);
            if hits[0].is_hit() {
                let seen = surfaces.emitted(&hits[0], true);
                let off = (seen - emission.radiance).map(f64::abs).max_channel();
                assert!(off < 2e-2 * (1.0 + seen.max_channel()), "{seen:?}");
            }
        }
        let mean = sum / f64::from(count);
        let variance = squares / f64::from(count) - mean.mean().powi(2);
        (mean, variance.max(0.0).sqrt())
    }

    /// A window of a thousandth of the area costs as little as a lamp of its size.
    #[test]
    fn one_bright_window_is_found() {
        let size = 256u32;
        let is_bright = |k: u32| (k % size).abs_diff(40) < 4 && (k / size).abs_diff(100) < 4;
        let pixel = |k: u32| {
            if is_bright(k) {
                [9.0, 5.0, 1.0]
            } else {
                [0.0; 3]
            }
        };
        let scene = sheet(Image::opaque(
            size,
            size,
            (0..size * size).map(pixel).collect(),
        ));
        let expected = scene.mean_emissions()[0] * 2.0;
        let (emission, spread) = integral(&scene, 4096);
        let off = (emission - expected).map(f64::abs).max_channel();
        assert!(
            off < 0.01 * expected.max_channel(),
            "{emission:?} {expected:?}"
        );
        // Sampled evenly it would be 35 times the mean.
        assert!(spread < 0.5 * expected.mean(), "{spread} of {expected:?}");
    }

    #[test]
    fn large_pictures_keep_the_budget() {
        let size = 1200u32;
        let pixel = |k: u32| [(k.wrapping_mul(2_654_435_761) >> 24) as f32 / 256.0; 3];
        let scene = sheet(Image::opaque(
            size,
            size,
            (0..size * size).map(pixel).collect(),
        ));
        let tracer = Tracer::new(&scene);
        let lamps = PicturedEmitters::new(&Surfaces::new(&scene, &tracer));
        assert!(lamps.ends.len() as f64 <= MOST_CELLS);
        let expected = scene.mean_emissions()[0] * 2.0;
        let (emission, _) = integral(&scene, 16_384);
        let off = (emission - expected).map(f64::abs).max_channel();
        assert!(
            off < 0.02 * expected.max_channel(),
            "{emission:?} {expected:?}"
        );
    }

    #[test]
    fn black_pictures_are_no_lights() {
        let scene = sheet(Image::new(8, 8));
        let tracer = Tracer::new(&scene);
        assert!(PicturedEmitters::new(&Surfaces::new(&scene, &tracer)).is_empty());
    }
}
