//! Item buffers: the patch that is visible in each pixel of a hemicube.
//!
//! A [`World`] holds triangles with the numbers of their patches, and flat mirrors. A [`Device`]
//! keeps a world in its memory and draws hemicubes of it ([`ItemBuffers::draw`]), many at a time,
//! each reduced to form factors by patch. There are two kinds of devices: the processor, which is
//! always available, and graphics cards, which programs supply. They share [`UnitCube`] and
//! [`HemicubeView`], so that both draw from the same viewpoints.

#[cfg(test)]
mod drawn_tests;
mod face;
mod prepared_world;
mod processor;
mod raster;
mod tally;
mod view;
mod window_budget;

pub use processor::{Processor, ProcessorBuffers};
pub use view::{DepthPrecision, HemicubeView, LocalMirror, PatchOptics, Plane, UnitCube};
pub use window_budget::WindowBudget;

use azulejo_scene::Rgb;
use glam::DVec3;
use std::fmt;

/// The content of item buffers.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// All surfaces that can be visible or occlude others.
    pub triangles: Vec<Facet>,
    /// Number of patches; patch numbers are below.
    pub patches: u32,
    /// For each patch the mirror that it is a part of, or [`NO_MIRROR`]. Empty: none is.
    pub mirror_of: Vec<u32>,
    /// Flat mirrors. All patches in one plane with one reflectance are one mirror.
    pub mirrors: Vec<Mirror>,
    /// For each patch whether it reflects or transmits light in a way that item buffers cannot
    /// draw: a curved mirror or glass. Empty: none does.
    pub is_bent: Vec<bool>,
    /// The direction that is up, for light that leaves the world: unit length.
    pub up: DVec3,
}

/// No mirror, in [`World::mirror_of`].
pub const NO_MIRROR: u32 = u32::MAX;

/// A triangle of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Corners in scene units, counter-clockwise from the front.
    pub corners: [DVec3; 3],
    /// The patch it is a part of.
    pub patch: u32,
}

/// The plane of a mirror, which reflects on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// A point of the plane.
    pub point: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// Reflectance ρ_s, 0..=1 per channel.
    pub reflectance: Rgb,
}

/// A viewpoint from which a hemicube is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The viewpoint, in scene units.
    pub eye: DVec3,
    /// Unit normal of the surface at the viewpoint.
    pub normal: DVec3,
    /// Rotation of the hemicube about the normal, radians: different rotations turn aliasing into
    /// noise.
    pub turn: f64,
}

impl View {
    /// Axes of the hemicube in the world: x, y, and z along the normal.
    pub fn axes(&self) -> [DVec3; 3] {
        let frame = azulejo_scene::math::Frame::from_normal(self.normal);
        let (sin, cos) = self.turn.sin_cos();
        [
            cos * frame.x + sin * frame.y,
            cos * frame.y - sin * frame.x,
            frame.z,
        ]
    }
}

/// How hemicubes are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Pixels along the side of the top face: even, 2..=[`MOST_RESOLUTION`].
    pub resolution: u32,
    /// The treatment of mirrors.
    pub mirrors: Beyond,
}

/// Largest resolution of a hemicube: 12 million pixels.
pub const MOST_RESOLUTION: u32 = 2048;

/// The treatment of pixels that show a specular patch, besides counting their form factor for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Beyond {
    /// Flat mirrors are windows to the reflected world, drawn in the window's pixels, whose shares
    /// continue with the mirror's reflectance; and so on. Windows that carry less than `cut` of the
    /// hemicube's light are drawn by chance, and so are the weakest where there are more than
    /// `windows` of them ([`WindowBudget`]): those that are drawn stand for the others, on average
    /// without error, and [`Seen::cut`] is the difference. After `depth` mirrors a chain ends, and
    /// what it carries is in [`Seen::cut`]. Pixels of bent patches are listed as in
    /// [`Beyond::List`], in all windows; a patch that is both bent and part of a mirror counts as
    /// bent.
    Windows {
        /// Share of the hemicube below which a window is drawn by chance.
        cut: f32,
        /// Largest number of mirrors in a chain.
        depth: u32,
        /// Windows of a hemicube, besides a few for each level.
        windows: u32,
    },
    /// Pixels of mirrors and of bent patches are listed in [`Seen::specular`], for rays to continue.
    List,
}

/// The form factors from one hemicube.
///
/// At order 0 the shares and the escaped light sum to 1; what is visible behind each mirror,
/// escapes there or is cut there sums to the mirror's share times its reflectance. Devices that add
/// in single precision keep that to about 1e-6, the processor to 1e-12.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// Form factors by side and order, sorted by both; each pair once.
    pub shares: Vec<Share>,
    /// Form factor of light that hits nothing, upwards and downwards.
    pub escaped: [Rgb; 2],
    /// Form factor of light that was cut between mirrors. It balances the other shares exactly, and
    /// is negative where the windows that were drawn by chance happen to carry more light than all.
    pub cut: Rgb,
    /// Pixels from which rays have to continue, by the number of mirrors on the way; their form
    /// factors are in `shares` too. No share mixes listed pixels with others.
    pub specular: Vec<SpecularPixel>,
}

/// The light of a hemicube that reaches one side of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Twice the patch, one more for its back.
    pub side: u32,
    /// Number of mirrors on the way; 2 for more.
    pub order: u8,
    /// Form factor, per channel.
    pub weight: Rgb,
}

/// A pixel that shows a mirror or a bent patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecularPixel {
    /// Start of the last segment of the line of sight: the viewpoint, or the point on the last
    /// mirror on the way (off its plane by rounding, towards the segment).
    pub origin: DVec3,
    /// Direction of the pixel's centre in the world, after the mirrors on the way; unit length.
    pub direction: DVec3,
    /// Distance from `origin` to the visible surface, in scene units, to about 1e-4 of itself and
    /// of the distance from the viewpoint to `origin`.
    pub distance: f64,
    /// Twice the patch that it shows, one more for its back.
    pub side: u32,
    /// Number of mirrors on the way.
    pub order: u8,
    /// The pixel's share, after those mirrors.
    pub weight: Rgb,
}

/// Reasons for failing to draw item buffers.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DrawError {
    /// There is no such device, or its driver refuses. The text states what was searched and how to
    /// fix it.
    Missing(String),
    /// The world or the hemicubes exceed the capacity of the device. The text states which, its
    /// size, and the limit.
    TooLarge(String),
    /// The device was lost while drawing: reset, unplugged, or out of memory.
    Lost(String),
}

impl fmt::Display for DrawError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DrawError::Missing(what) => f.write_str(what),
            DrawError::TooLarge(what) => write!(f, "too large for the device: {what}"),
            DrawError::Lost(what) => write!(f, "the device was lost: {what}"),
        }
    }
}

impl std::error::Error for DrawError {}

/// Something that can draw item buffers.
pub trait Device: Send + Sync + fmt::Debug {
    /// Its name for reports: the processor, or a card with its driver.
    fn name(&self) -> String;

    /// Copies a world to the device.
    ///
    /// # Errors
    /// [`DrawError`].
    fn load(&self, world: &World, settings: &Settings) -> Result<Box<dyn ItemBuffers>, DrawError>;
}

/// A world on a device.
pub trait ItemBuffers: Send + Sync {
    /// Number of views per call that keeps the device busy.
    fn batch(&self) -> usize;

    /// Draws hemicubes: one [`Seen`] per view, in their order. The result depends on each view, the
    /// world and the settings alone, not on threads or other views.
    ///
    /// # Errors
    /// [`DrawError::Lost`], [`DrawError::TooLarge`].
    fn draw(&self, views: &[View]) -> Result<Vec<Seen>, DrawError>;
}

/// The pixels of a hemicube, and the delta form factor of each.
///
/// Pixel numbers: the top face row by row (y up, then x), then the upper halves of the faces
/// towards +x, −x, +y, −y, each row by row from the horizon up. On a side face the columns run
/// along +y, −y, −x, +x, so that each appears from the viewpoint with z up and the columns to the
/// left.
#[derive(Clone, Debug, PartialEq)]
pub struct Hemicube {
    resolution: u32,
    weights: Vec<f32>,
}

impl Hemicube {
    /// A hemicube of `resolution` pixels along the top's side; rounded up to an even number.
    pub fn new(resolution: u32) -> Hemicube {
        let resolution = resolution.clamp(2, MOST_RESOLUTION).next_multiple_of(2);
        let mut cube = Hemicube {
            resolution,
            weights: Vec::new(),
        };
        // The midpoint rule. What it is off at the borders of faces is corrected there: spread over all
        // pixels, it would take 33 millionths of each form factor at 128 pixels. The sum is then 1 up to
        // O(1/n⁴), by which they are divided.
        let raw = |p: u32| density(cube.unnormalized(p)) + cube.border_correction(p);
        let raw: Vec<f64> = (0..cube.pixels()).map(raw).collect();
        let sum: f64 = raw.iter().sum();
        cube.weights = raw.iter().map(|w| (w / sum) as f32).collect();
        cube
    }

    /// Pixels along the side of the top face.
    pub fn resolution(&self) -> u32 {
        self.resolution
    }

    /// Number of pixels: three squares of the resolution.
    pub fn pixels(&self) -> u32 {
        3 * self.resolution * self.resolution
    }

    /// Delta form factors of all pixels, which sum to 1 up to their rounding.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Direction of a pixel's centre in the hemicube's axes, unit length.
    pub fn direction(&self, pixel: u32) -> DVec3 {
        self.unnormalized(pixel).normalize()
    }

    /// The terms of Euler and Maclaurin for a pixel at borders of its face: a 24th of its width times the slope
    /// of the density outward.
    fn border_correction(&self, pixel: u32) -> f64 {
        let width = 2.0 / f64::from(self.resolution);
        let centre = self.unnormalized(pixel);
        let outward = self
            .borders(pixel)
            .into_iter()
            .filter(|&way| way != DVec3::ZERO);
        let slopes = outward.map(|way| way.dot(density_gradient(centre + 0.5 * width * way)));
        width / 24.0 * slopes.sum::<f64>()
    }

    /// The ways from a pixel across the borders of its face that it lies at; zero for others.
    fn borders(&self, pixel: u32) -> [DVec3; 4] {
        let centre = self.unnormalized(pixel);
        let last = 1.0 - 1.5 / f64::from(self.resolution);
        let across = |axis: DVec3| {
            let along = centre.dot(axis);
            // The face itself lies at 1.
            if along.abs() > last && along.abs() < 1.0 {
                along.signum() * axis
            } else {
                DVec3::ZERO
            }
        };
        let is_lowest = centre.z < 1.0 - last;
        let down = if is_lowest { -DVec3::Z } else { DVec3::ZERO };
        let [x, y, z] = DVec3::AXES.map(across);
        [x, y, z, down]
    }

    /// The point where the direction intersects the cube of side 2.
    fn unnormalized(&self, pixel: u32) -> DVec3 {
        let n = self.resolution;
        let at = |k: u32| (2.0 * f64::from(k) + 1.0) / f64::from(n) - 1.0;
        if pixel < n * n {
            return DVec3::new(at(pixel % n), at(pixel / n), 1.0);
        }
        let half = n * n / 2;
        let (face, rest) = ((pixel - n * n) / half, (pixel - n * n) % half);
        let along = at(rest % n);
        let up = (2.0 * f64::from(rest / n) + 1.0) / f64::from(n);
        match face {
            0 => DVec3::new(1.0, along, up),
            1 => DVec3::new(-1.0, -along, up),
            2 => DVec3::new(-along, 1.0, up),
            _ => DVec3::new(along, -1.0, up),
        }
    }
}

/// Form factor per area at a point of the cube, times π: on top 1 / (x² + y² + 1)², on a side z / (y² + z² + 1)²
/// (Cohen and Greenberg 1985, eq. 10 and 11); as direction · normal over the fourth power of its length they are
/// one.
fn density(at: DVec3) -> f64 {
    at.z / at.length_squared().powi(2)
}

/// Its gradient.
fn density_gradient(at: DVec3) -> DVec3 {
    let squared = at.length_squared();
    (DVec3::Z - 4.0 * at.z / squared * at) / squared.powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 2 over an element at distance 1 receives 4/π atan(1/√2)/√2.
    #[test]
    fn faces_have_their_form_factors() {
        let root = std::f64::consts::FRAC_1_SQRT_2;
        let top = 4.0 * std::f64::consts::FRAC_1_PI * root * root.atan();
        for (n, most) in [(16, 1e-5), (32, 1e-6), (128, 1e-8)] {
            let cube = Hemicube::new(n);
            let sum: f64 = (0..n * n)
                .map(|p| f64::from(cube.weights()[p as usize]))
                .sum();
            assert!((sum - top).abs() < most + 1e-7, "{n}: {sum} {top}");
            assert!(cube.weights().iter().all(|&w| w > 0.0));
        }
    }

    #[test]
    fn weights_are_shares_and_directions_lie_above_the_horizon() {
        for n in [2, 8, 64] {
            let cube = Hemicube::new(n);
            let sum: f64 = cube.weights().iter().map(|&w| f64::from(w)).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
            assert!((0..cube.pixels()).all(|p| cube.direction(p).z > 0.0));
        }
        assert_eq!(Hemicube::new(7).resolution(), 8);
    }

    #[test]
    fn the_mean_direction_is_the_cosine_s() {
        // ∫ d cosθ/π dω = 2/3 z.
        let cube = Hemicube::new(64);
        let mean: DVec3 = (0..cube.pixels())
            .map(|p| f64::from(cube.weights()[p as usize]) * cube.direction(p))
            .sum();
        assert!((mean - DVec3::Z * 2.0 / 3.0).length() < 1e-3, "{mean}");
    }
}
