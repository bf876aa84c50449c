//! Antialiasing: rays through the corners of pixels and between them.

use super::shade::{RaySampler, Shader};
use super::view::Lens;
use super::world::Owner;
use super::{Antialiasing, AntialiasingMode};
use azulejo_scene::Rgb;
use azulejo_trace::{Cancelled, Progress};
use rayon::prelude::*;

/// Steps along an edge of a pixel at the finest subdivision.
const STEPS: u32 = 8;

/// The result of one camera ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub color: Rgb,
    /// The object; `None` for the background.
    pub owner: Option<Owner>,
}

/// The four corners of a pixel or of a part of it: the upper ones first, each pair from the left.
type Corners = [Sample; 4];

/// The image plane.
pub(super) struct Pixels<'a> {
    pub shader: &'a Shader<'a>,
    pub lens: &'a Lens,
    pub options: Antialiasing,
}

/// Samples inside a pixel, so that its quarters share them.
type Inner = [[Option<Sample>; STEPS as usize + 1]; STEPS as usize + 1];

/// A square part of a pixel, in steps from its upper left corner.
#[derive(Clone, Copy, Debug)]
struct Part {
    x: u32,
    y: u32,
    size: u32,
}

/// One pixel while it is subdivided.
struct Pixel<'p, 'a> {
    pixels: &'p Pixels<'a>,
    x: u32,
    y: u32,
    inner: Inner,
}

impl Pixels<'_> {
    /// Samples at the corners of all pixels: one more per row and column than there are pixels.
    pub fn corners(&self, progress: &Progress) -> Result<Vec<Sample>, Cancelled> {
        let (width, height) = self.lens.size;
        let row = |y: u32| -> Result<Vec<Sample>, Cancelled> {
            let corner = |x: u32| {
                progress.advance(1)?;
                Ok(self.sample(2 * STEPS * x, 2 * STEPS * y, |_| true))
            };
            (0..=width).map(corner).collect()
        };
        let rows: Result<Vec<_>, Cancelled> = (0..=height).into_par_iter().map(row).collect();
        Ok(rows?.concat())
    }

    /// A row of the image.
    pub fn row(
        &self,
        y: u32,
        corners: &[Sample],
        progress: &Progress,
    ) -> Result<Vec<[f32; 3]>, Cancelled> {
        let width = self.lens.size.0;
        let pitch = width as usize + 1;
        let pixel = |x: u32| {
            progress.advance(1)?;
            let first = y as usize * pitch + x as usize;
            let around = [0, 1, pitch, pitch + 1].map(|k| corners[first + k]);
            Ok(self.color(x, y, around).to_f32())
        };
        (0..width).map(pixel).collect()
    }

    fn color(&self, x: u32, y: u32, around: Corners) -> Rgb {
        let options = &self.options;
        if options.levels == 0 {
            return mean(&around);
        }
        match options.mode {
            AntialiasingMode::Adaptive => {
                let mut pixel = Pixel {
                    pixels: self,
                    x,
                    y,
                    inner: Inner::default(),
                };
                let whole = Part {
                    x: 0,
                    y: 0,
                    size: STEPS,
                };
                pixel.divided(whole, around, options.levels.min(STEPS.ilog2()))
            }
            AntialiasingMode::SemiAdaptive if !self.differ(&around) => mean(&around),
            AntialiasingMode::SemiAdaptive => {
                self.grid(x, y, &around, |owner| sees(&around, owner))
            }
            AntialiasingMode::Fixed => self.grid(x, y, &around, |_| true),
        }
    }

    /// The mean of the corners and of a grid of rays through the middles of cells.
    fn grid(&self, x: u32, y: u32, around: &Corners, counts: impl Fn(Owner) -> bool) -> Rgb {
        let cells = 1 << self.options.levels.min(STEPS.ilog2());
        let middle = |cell: u32, i: u32| 2 * STEPS * cell + (2 * i + 1) * STEPS / cells;
        let mut sum = 4.0 * mean(around);
        for i in 0..cells * cells {
            let at = (middle(x, i % cells), middle(y, i / cells));
            sum += self.sample_of(at.0, at.1, &counts).color;
        }
        sum / f64::from(cells * cells + 4)
    }

    /// A ray inside a pixel, which is tested against all objects only if the option is set.
    fn sample_of(&self, x: u32, y: u32, counts: impl Fn(Owner) -> bool) -> Sample {
        let sample = self.sample(x, y, counts);
        if sample.owner.is_none() && self.options.all_objects {
            return self.sample(x, y, |_| true);
        }
        sample
    }

    /// A ray through a point in half steps from the image's upper left corner.
    fn sample(&self, x: u32, y: u32, counts: impl Fn(Owner) -> bool) -> Sample {
        let pixels = |x: u32| f64::from(x) / f64::from(2 * STEPS);
        let mut sampler = RaySampler::new(x, y);
        let ray = self.lens.ray(pixels(x), pixels(y), &mut sampler);
        match self.shader.seen(&ray, counts, &mut sampler) {
            Some((color, owner)) => Sample {
                color,
                owner: Some(owner),
            },
            None => Sample {
                color: self.shader.background(),
                owner: None,
            },
        }
    }

    /// Whether any two corners differ too much.
    fn differ(&self, corners: &Corners) -> bool {
        let threshold = self.options.threshold;
        let distance = |a: Rgb, b: Rgb| {
            let difference = |k: usize| {
                let scale = if threshold < 0.0 {
                    a[k] + b[k] + 1e-12
                } else {
                    1.0
                };
                ((a[k] - b[k]) / scale).powi(2)
            };
            difference(0) + difference(1) + difference(2)
        };
        let too_much =
            |a: &Sample, b: &Sample| distance(a.color, b.color) > 3.0 * threshold * threshold;
        (0..4).any(|i| (i + 1..4).any(|j| too_much(&corners[i], &corners[j])))
    }
}

impl Pixel<'_, '_> {
    /// The mean of a part, quartered while its corners differ and `levels` are left.
    fn divided(&mut self, part: Part, corners: Corners, levels: u32) -> Rgb {
        if levels == 0 || !self.pixels.differ(&corners) {
            return mean(&corners);
        }
        let Part { x, y, size } = part;
        let half = size / 2;
        let [upper_left, upper_right, lower_left, lower_right] = corners;
        let quarter = |dx: u32, dy: u32| Part {
            x: x + dx * half,
            y: y + dy * half,
            size: half,
        };
        // The order matters: shared samples depend on which quarter takes them first.
        let upper = self.between(x + half, y, &corners);
        let left = self.between(x, y + half, &corners);
        let middle = self.between(x + half, y + half, &corners);
        let a = self.divided(quarter(0, 0), [upper_left, upper, left, middle], levels - 1);
        let right = self.between(x + size, y + half, &corners);
        let b = self.divided(
            quarter(1, 0),
            [upper, upper_right, middle, right],
            levels - 1,
        );
        let lower = self.between(x + half, y + size, &corners);
        let c = self.divided(quarter(0, 1), [left, middle, lower_left, lower], levels - 1);
        let d = self.divided(
            quarter(1, 1),
            [middle, right, lower, lower_right],
            levels - 1,
        );
        0.25 * (a + b + c + d)
    }

    /// The sample at a point of the pixel, of the objects that `corners` hit.
    fn between(&mut self, x: u32, y: u32, corners: &Corners) -> Sample {
        let is_inner = |x: u32| x > 0 && x < STEPS;
        let known = self.inner[y as usize][x as usize].filter(|_| is_inner(x) && is_inner(y));
        known.unwrap_or_else(|| {
            let at = |cell: u32, x: u32| 2 * (STEPS * cell + x);
            let counts = |owner| sees(corners, owner);
            let sample = self.pixels.sample_of(at(self.x, x), at(self.y, y), counts);
            self.inner[y as usize][x as usize] = Some(sample);
            sample
        })
    }
}

fn sees(corners: &Corners, owner: Owner) -> bool {
    corners.iter().any(|c| c.owner == Some(owner))
}

fn mean(corners: &Corners) -> Rgb {
    0.25 * corners.iter().map(|c| c.color).sum::<Rgb>()
}
