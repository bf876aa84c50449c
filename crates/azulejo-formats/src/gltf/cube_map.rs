//! Cube maps: six square pictures around a point, +x, −x, +y, −y, −z, +z, as Babylon.js shows them: faces of
//! OpenGL (OpenGL 4.6, table 8.19) whose z axis is reversed, upside down. And RGBD, in which their pixels may
//! exceed 1.

use super::image_based::harmonics;
use crate::picture::srgb::{linear_table, srgb_bytes};
use azulejo_scene::harmonics::cosine_factor;
use azulejo_scene::{Image, Rgb};
use glam::DVec3;
use std::f64::consts::PI;

/// Largest value in RGBD: 1 divided by an alpha of 1/255.
pub(super) const MOST_RGBD: f64 = 255.0;

/// The face that a direction meets, and where: from the left and from the top, −1..=1.
pub(super) fn face_of(d: DVec3) -> (usize, f64, f64) {
    let (face, s, t) = opengl_face_of(DVec3::new(d.x, d.y, -d.z));
    (face, s, -t)
}

/// The same with the orientation of OpenGL.
pub(super) fn opengl_face_of(d: DVec3) -> (usize, f64, f64) {
    let size = d.abs();
    let (face, s, t, depth) = if size.x >= size.y && size.x >= size.z {
        let is_back = d.x < 0.0;
        let s = if is_back { d.z } else { -d.z };
        (usize::from(is_back), s, -d.y, size.x)
    } else if size.y >= size.z {
        let is_down = d.y < 0.0;
        let t = if is_down { -d.z } else { d.z };
        (2 + usize::from(is_down), d.x, t, size.y)
    } else {
        let is_back = d.z < 0.0;
        let s = if is_back { -d.x } else { d.x };
        (4 + usize::from(is_back), s, -d.y, size.z)
    };
    (face, s / depth, t / depth)
}

/// The unit direction to a place on a face.
fn direction(face: usize, s: f64, t: f64) -> DVec3 {
    let d = match face {
        0 => DVec3::new(1.0, t, s),
        1 => DVec3::new(-1.0, t, -s),
        2 => DVec3::new(s, 1.0, t),
        3 => DVec3::new(s, -1.0, -t),
        4 => DVec3::new(s, t, -1.0),
        _ => DVec3::new(-s, t, 1.0),
    };
    d.normalize()
}

/// Radiance by direction.
#[derive(Clone, Debug)]
pub(super) struct CubeMap {
    /// Rows and columns of each face.
    size: u32,
    /// Face after face, row after row.
    pixels: Vec<Rgb>,
}

impl CubeMap {
    /// The mean of what is seen in `samples` × `samples` directions of each pixel.
    pub fn of(size: u32, samples: u32, seen: impl Fn(DVec3) -> Rgb) -> CubeMap {
        let step = 2.0 / f64::from(size * samples);
        let at = |k: u32| (f64::from(k) + 0.5) * step - 1.0;
        let pixel = |(face, x, y): (usize, u32, u32)| {
            let places = (0..samples * samples).map(|k| (k % samples, k / samples));
            let sum: Rgb = places
                .map(|(i, j)| seen(direction(face, at(x * samples + i), at(y * samples + j))))
                .sum();
            sum / f64::from(samples * samples)
        };
        CubeMap {
            size,
            pixels: places(size).map(pixel).collect(),
        }
    }

    /// Half as many rows and columns, each pixel the mean of four.
    pub fn halved(&self) -> CubeMap {
        let at = |face: usize, x: u32, y: u32| {
            let row = face as u32 * self.size + y;
            self.pixels[(row * self.size + x) as usize]
        };
        let size = self.size / 2;
        let pixel = |(face, x, y): (usize, u32, u32)| {
            let (x, y) = (2 * x, 2 * y);
            let four = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
            four.into_iter().map(|(x, y)| at(face, x, y)).sum::<Rgb>() / 4.0
        };
        CubeMap {
            size,
            pixels: places(size).map(pixel).collect(),
        }
    }

    /// Directions, solid angles and radiances of all pixels.
    fn directions(&self) -> impl Iterator<Item = (DVec3, f64, Rgb)> {
        let at = |k: u32| 2.0 * (f64::from(k) + 0.5) / f64::from(self.size) - 1.0;
        let area = (2.0 / f64::from(self.size)).powi(2);
        let pixels = places(self.size).zip(&self.pixels);
        pixels.map(move |((face, x, y), &radiance)| {
            let (s, t) = (at(x), at(y));
            let solid_angle = area * (1.0 + s * s + t * t).powf(-1.5);
            (direction(face, s, t), solid_angle, radiance)
        })
    }

    /// The mean over all directions.
    pub fn mean(&self) -> Rgb {
        let sum: Rgb = self.directions().map(|(_, weight, l)| l * weight).sum();
        sum / (4.0 * PI)
    }

    /// The largest channel of any pixel.
    pub fn peak(&self) -> f64 {
        let channels = self.pixels.iter().map(|p| p.max_channel());
        channels.fold(0.0, f64::max)
    }

    /// The same, times a factor.
    pub fn scaled(mut self, factor: f64) -> CubeMap {
        self.pixels.iter_mut().for_each(|p| *p *= factor);
        self
    }

    /// Nine coefficients of the irradiance: those of the radiance, each band times its factor.
    pub fn irradiance_coefficients(&self) -> [Rgb; 9] {
        let mut sums = [Rgb::BLACK; 9];
        for (d, solid_angle, radiance) in self.directions() {
            for (sum, y) in sums.iter_mut().zip(harmonics(d)) {
                *sum += radiance * (solid_angle * y);
            }
        }
        std::array::from_fn(|k| sums[k] * cosine_factor(k))
    }

    /// What surfaces of a roughness reflect that are seen along their normals: this map, blurred by the
    /// GGX distribution of their normals (Karis, *Real Shading in Unreal Engine 4*, SIGGRAPH 2013).
    pub fn blurred(&self, size: u32, roughness: f64) -> CubeMap {
        let alpha2 = roughness.powi(4);
        let source: Vec<(DVec3, f64, Rgb)> = self.directions().collect();
        CubeMap::of(size, 1, |n| {
            let (mut sum, mut weights) = (Rgb::BLACK, 0.0);
            for &(l, solid_angle, radiance) in &source {
                let cos = n.dot(l);
                if cos > 0.0 {
                    // The half vector of n and l: cos²θ = (1 + cos) / 2.
                    let d = 0.5 * (1.0 + cos) * (alpha2 - 1.0) + 1.0;
                    let weight = solid_angle * cos / (d * d);
                    sum += radiance * weight;
                    weights += weight;
                }
            }
            sum / weights
        })
    }

    /// The faces in RGBD.
    pub fn rgbd_faces(&self) -> impl Iterator<Item = Image> {
        let faces = self.pixels.chunks((self.size * self.size) as usize);
        faces.map(|pixels| rgbd(self.size, pixels))
    }
}

/// Face, column and row of all pixels, in their order.
fn places(size: u32) -> impl Iterator<Item = (usize, u32, u32)> {
    let on_face = move || (0..size * size).map(move |k| (k % size, k / size));
    (0..6).flat_map(move |face| on_face().map(move |(x, y)| (face, x, y)))
}

/// Pixels whose colours, divided by their alpha, are the given ones, up to [`MOST_RGBD`].
fn rgbd(size: u32, pixels: &[Rgb]) -> Image {
    let divisor = |p: &Rgb| (255.0 / p.max_channel()).floor().clamp(1.0, 255.0) / 255.0;
    let alpha: Vec<f32> = pixels.iter().map(|p| divisor(p) as f32).collect();
    let colors = pixels.iter().map(|p| (*p * divisor(p)).to_f32());
    let image = Image::opaque(size, size, colors.collect());
    // Rounded here, so that the file gets 8 bits.
    let table = linear_table();
    let bytes = srgb_bytes(&image);
    let (bytes, _) = bytes.as_chunks::<3>();
    let rounded = bytes.iter().map(|p| p.map(|b| table[usize::from(b)]));
    Image::opaque(size, size, rounded.collect()).with_alpha(alpha)
}

/// The colours of a picture in RGBD; those of a picture without alpha channel as they are.
pub(super) fn unpacked(image: Image) -> Image {
    let Some(alpha) = &image.alpha else {
        return image;
    };
    let pixels = image.pixels.iter().zip(alpha);
    let pixels = pixels.map(|(p, a)| p.map(|c| c / a.max(1.0 / MOST_RGBD as f32)));
    Image::opaque(image.width, image.height, pixels.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_meet_their_faces() {
        for face in 0..6 {
            for (s, t) in [(0.3, -0.8), (-0.9, 0.1), (0.0, 0.0)] {
                let (hit_face, u, v) = face_of(direction(face, s, t));
                assert_eq!(hit_face, face);
                assert!((u - s).abs() < 1e-12 && (v - t).abs() < 1e-12, "{face}");
            }
        }
    }

    #[test]
    fn coefficients_are_those_of_irradiance() {
        // L = 1 + z has the irradiance π + 2π/3 n·z.
        let map = CubeMap::of(32, 2, |d| Rgb::grey(1.0 + d.z));
        let c = map.irradiance_coefficients();
        for n in [DVec3::Z, DVec3::NEG_Z, DVec3::new(0.6, 0.0, 0.8)] {
            let terms = c.iter().zip(harmonics(n)).map(|(c, y)| c.g * y);
            let irradiance: f64 = terms.sum();
            let truth = PI + 2.0 * PI / 3.0 * n.z;
            assert!(
                (irradiance - truth).abs() < 2e-3 * PI,
                "{n}: {irradiance}, {truth}"
            );
        }
        assert!((map.mean().g - 1.0).abs() < 1e-3);
    }

    #[test]
    fn rough_surfaces_reflect_the_mean() {
        let map = CubeMap::of(16, 1, |d| Rgb::grey(f64::from(u8::from(d.y > 0.0))));
        let along = |m: &CubeMap, d: DVec3| {
            let (face, s, t) = face_of(d);
            let index = |x: f64| ((0.5 + 0.5 * x) * f64::from(m.size)) as u32;
            let row = face as u32 * m.size + index(t);
            m.pixels[(row * m.size + index(s)) as usize].g
        };
        let toward = DVec3::new(0.05, 0.3, 1.0).normalize();
        let [smooth, rough] = [0.2, 1.0].map(|r| along(&map.blurred(16, r), toward));
        assert!(
            smooth > 0.97 && (0.5..0.8).contains(&rough),
            "{smooth} {rough}"
        );
        assert!(along(&map.blurred(16, 1.0), DVec3::new(0.01, 1.0, 0.01)) > 0.99);
    }

    #[test]
    fn rgbd_keeps_what_is_brighter_than_white() {
        let values = [0.0, 0.02, 0.5, 1.0, 3.0, 40.0, 255.0];
        let pixels = values.map(|v| Rgb::new(v, 0.5 * v, 0.9 * v));
        let mut list = pixels.to_vec();
        list.resize(9, Rgb::BLACK);
        let image = rgbd(3, &list);
        let mut file = Vec::new();
        crate::picture::png::write_linear(&image, &mut file).unwrap();
        let back = unpacked(crate::picture::png::read(&file).unwrap());
        for (pixel, given) in back.pixels.iter().zip(&pixels) {
            for k in 0..3 {
                let off = f64::from(pixel[k]) - given[k];
                assert!(off.abs() <= 0.013 * given[k] + 2e-3, "{pixel:?} {given:?}");
            }
        }
    }
}
