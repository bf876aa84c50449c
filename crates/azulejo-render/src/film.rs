//! The image plane: tiles, sample positions, pixel filter.

use azulejo_scene::math::Ray;
use azulejo_scene::{Camera, Image};
use azulejo_trace::sampling::{hash, sobol};
use glam::{DMat3, DVec3};

/// Pixels along the edge of a tile: small enough to share out evenly and to keep a batch of rays
/// coherent, large enough that taking one costs nothing.
const TILE: u32 = 16;

/// An image plane of `width × height` pixels, and the sample positions of each.
///
/// The pixel filter is a tent of one pixel's radius, realized by sampling positions in proportion
/// to it (Ernst, Stamminger and Greiner, *Filter Importance Sampling*, IEEE RT 2006). It is
/// smoother than a box along edges, and unlike a filter with negative lobes it makes no dark
/// rings around lamps, which are a hundred times brighter than what is beside them. As each
/// sample belongs to one pixel, tiles share nothing and the result cannot depend on threads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Film {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Keys the sample positions.
    pub seed: u32,
}

/// A pixel, ready to be sampled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    /// Column and row.
    corner: (f64, f64),
    /// Size of a pixel where the image is 1 × 1.
    size: (f64, f64),
    seeds: [u32; 2],
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

impl Film {
    /// A film of a size in pixels; panics if these are 2³² or more.
    pub fn new((width, height): (u32, u32), seed: u32) -> Film {
        assert!(
            width.checked_mul(height).is_some(),
            "a picture of {width} × {height} pixels is too large"
        );
        Film {
            width,
            height,
            seed,
        }
    }

    /// All pixels, each in one tile, row by row.
    pub fn tiles(&self) -> Vec<Tile> {
        let (columns, rows) = (self.width.div_ceil(TILE), self.height.div_ceil(TILE));
        let tile = |k: u32| {
            let (x, y) = (k % columns * TILE, k / columns * TILE);
            Tile {
                x,
                y,
                width: TILE.min(self.width - x),
                height: TILE.min(self.height - y),
            }
        };
        (0..columns * rows).map(tile).collect()
    }

    /// The sample positions of a pixel.
    pub fn pixel(&self, pixel: u32) -> Pixel {
        let key = |dimension| hash(&[self.seed, pixel, dimension]);
        Pixel {
            corner: (f64::from(pixel % self.width), f64::from(pixel / self.width)),
            size: (1.0 / f64::from(self.width), 1.0 / f64::from(self.height)),
            seeds: [key(0), key(1)],
        }
    }

    /// Assembles the image from the pixels of tiles; `parts` pairs with [`Film::tiles`].
    pub fn assemble(&self, parts: &[Vec<[f32; 3]>]) -> Image {
        let mut image = Image::new(self.width, self.height);
        for (tile, pixels) in self.tiles().iter().zip(parts) {
            for (pixel, &value) in tile.pixels(self.width).zip(pixels) {
                image.pixels[pixel as usize] = value;
            }
        }
        image
    }
}

impl Tile {
    /// Columns.
    pub fn width(self) -> u32 {
        self.width
    }

    /// Indices of its pixels in an image of `width` columns.
    pub fn pixels(self, width: u32) -> impl Iterator<Item = u32> {
        (self.y..self.y + self.height)
            .flat_map(move |y| (self.x..self.x + self.width).map(move |x| y * width + x))
    }
}

impl Pixel {
    /// Position of its middle.
    pub fn middle(&self) -> (f64, f64) {
        let (x, y) = self.corner;
        ((x + 0.5) * self.size.0, (y + 0.5) * self.size.1)
    }

    /// Position of sample `sample`: 0..=1 from the upper left corner of the image, slightly outside
    /// at its borders.
    pub fn position(&self, sample: u32) -> (f64, f64) {
        let offset = |dimension: usize| {
            let u = sobol(sample, dimension, self.seeds[dimension]);
            0.5 + tent(f64::from(u))
        };
        (
            (self.corner.0 + offset(0)) * self.size.0,
            (self.corner.1 + offset(1)) * self.size.1,
        )
    }
}

/// A number in −1..=1 with density 1 − |x|, from a uniform one in 0..1.
fn tent(u: f64) -> f64 {
    if u < 0.5 {
        (2.0 * u).sqrt() - 1.0
    } else {
        1.0 - (2.0 - 2.0 * u).sqrt()
    }
}

/// A camera with what its rays share computed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    eye: DVec3,
    corner: DVec3,
    across: DVec3,
    down: DVec3,
}

impl Lens {
    /// The lens of `camera` for an image of the given width over height.
    pub fn new(camera: &Camera, aspect: f64) -> Lens {
        let (right, up, forward) = camera.axes();
        let h = (0.5 * camera.vertical_fov).tan();
        Lens {
            eye: camera.eye,
            corner: forward - h * aspect * right + h * up,
            across: 2.0 * h * aspect * right,
            down: -2.0 * h * up,
        }
    }

    /// The ray of [`Camera::ray`], of unit direction.
    pub fn ray(&self, (x, y): (f64, f64)) -> Ray {
        let direction = self.corner + x * self.across + y * self.down;
        Ray::new(self.eye, direction.normalize())
    }

    /// The point of the image, 0..1, through which rays of this direction pass; `None` beside it.
    pub fn point(&self, direction: DVec3) -> Option<(f64, f64)> {
        let basis = DMat3::from_cols(self.across, self.down, self.corner);
        let coordinates = basis.inverse() * direction;
        let (x, y) = (coordinates.x / coordinates.z, coordinates.y / coordinates.z);
        let inside = |t: f64| (0.0..=1.0).contains(&t);
        (coordinates.z > 0.0 && inside(x) && inside(y)).then_some((x, y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_lead_back_to_the_points_of_the_image() {
        let camera = Camera {
            name: String::new(),
            eye: DVec3::new(1.0, 2.0, 3.0),
            target: DVec3::new(-4.0, 0.5, 1.0),
            up: DVec3::Z,
            vertical_fov: 1.0,
            size: None,
        };
        let lens = Lens::new(&camera, 1.5);
        for (x, y) in [(0.1, 0.9), (0.5, 0.5), (0.75, 0.0625)] {
            let point = lens.point(lens.ray((x, y)).direction).unwrap();
            assert!((point.0 - x).abs() < 1e-12 && (point.1 - y).abs() < 1e-12);
        }
        assert_eq!(lens.point(lens.ray((1.1, 0.5)).direction), None);
        assert_eq!(lens.point(-lens.ray((0.5, 0.5)).direction), None);
    }

    #[test]
    fn tiles_hold_every_pixel_once() {
        for (width, height) in [(1, 1), (16, 16), (17, 33), (100, 5)] {
            let film = Film {
                width,
                height,
                seed: 0,
            };
            let mut pixels: Vec<u32> = film
                .tiles()
                .iter()
                .flat_map(|t| t.pixels(width).collect::<Vec<_>>())
                .collect();
            pixels.sort_unstable();
            assert!(
                pixels.into_iter().eq(0..width * height),
                "{width} × {height}"
            );
        }
    }

    #[test]
    fn positions_follow_the_tent_of_their_pixel() {
        let film = Film {
            width: 10,
            height: 10,
            seed: 7,
        };
        let n = 4096;
        let (mut mean, mut variance) = (0.0, 0.0);
        for s in 0..n {
            let (x, y) = film.pixel(34).position(s);
            let (dx, dy) = (10.0 * x - 4.5, 10.0 * y - 3.5);
            assert!(dx.abs() <= 1.0 && dy.abs() <= 1.0);
            mean += (dx + dy) / f64::from(2 * n);
            variance += (dx * dx + dy * dy) / f64::from(2 * n);
        }
        // The tent has variance 1/6.
        assert!(
            mean.abs() < 1e-3 && (variance - 1.0 / 6.0).abs() < 1e-3,
            "{mean} {variance}"
        );
    }

    #[test]
    fn lens_agrees_with_the_camera() {
        let camera = Camera {
            name: String::new(),
            eye: DVec3::new(3.0, -2.0, 1.0),
            target: DVec3::new(-1.0, 4.0, 0.5),
            up: DVec3::new(0.1, 0.2, 1.0),
            vertical_fov: 0.8,
            size: None,
        };
        let lens = Lens::new(&camera, 1.6);
        for at in [(0.0, 0.0), (1.0, 0.25), (0.3, 0.9)] {
            let (a, b) = (lens.ray(at), camera.ray(at.0, at.1, 1.6));
            assert!((a.direction - b.direction).length() < 1e-14 && a.origin == b.origin);
        }
    }
}
