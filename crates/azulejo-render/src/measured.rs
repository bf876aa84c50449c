//! What is measured of every pixel: its value by how the light came, and its standard error.

use crate::film::Film;
use azulejo_scene::{Image, Rgb};

/// An estimate of the radiance along one ray, W/(sr·m²), by how the light came.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RayRadiance {
    /// From lights by one surface at most, mirrors and glass not counted.
    pub direct: Rgb,
    /// Irradiance at the first surface that scatters; without its direct part where that is told
    /// apart.
    pub stored: Rgb,
    /// What paths found behind that surface.
    pub sampled: Rgb,
    /// What of that was clamped, and is lost.
    pub removed: Rgb,
    /// Whether it depends on random numbers, so that another sample may differ.
    pub is_random: bool,
}

impl RayRadiance {
    /// All of it.
    pub fn radiance(&self) -> Rgb {
        self.direct + self.indirect()
    }

    /// All but the direct light.
    pub fn indirect(&self) -> Rgb {
        self.stored + self.sampled
    }

    /// Scales what paths found down to the largest value allowed, in either direction.
    pub fn limit(&mut self, most: f64) {
        let largest = self.sampled.map(f64::abs).max_channel();
        if largest > most {
            let kept = self.sampled * (most / largest);
            self.removed += self.sampled - kept;
            self.sampled = kept;
        }
    }
}

/// An image with its standard error, and what it is the sum of. All images have one size.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredImage {
    /// Radiance, W/(sr·m²).
    pub image: Image,
    /// Standard error of each pixel and channel, as if the samples were independent. They are
    /// stratified, so it is a little too large. In an image of the second pass it is the noise of
    /// the paths alone, without the error of the irradiance on the vertices.
    pub error: Image,
    /// Light that met one surface at most on its way from a light to the camera; mirrors and glass
    /// between surface and camera do not count.
    pub direct: Image,
    /// All other light: with `direct` it adds up to `image`.
    pub indirect: Image,
    /// The same image from the first and from the second half of the samples: two estimates with
    /// noise of their own.
    pub halves: [Image; 2],
    /// The light that a clamp removed, as a share of the light that the image would have without;
    /// mean over the channels. 0 without a clamp. It is the bias of the image's mean.
    pub removed: f64,
}

impl MeasuredImage {
    /// Expected [`relative_rmse`] of the image against the truth, from its standard errors.
    pub fn relative_error(&self) -> f64 {
        let errors = self.error.pixels.iter().flatten();
        let light = self.image.pixels.iter().flatten();
        let dim = dim(&self.image);
        let square = |(&e, &l): (&f32, &f32)| relative_square(e.into(), l.into(), dim);
        root_mean(errors.zip(light).map(square))
    }

    /// Assembles the image from the sums of its pixels, tile by tile.
    pub(crate) fn assemble(film: &Film, parts: &[Vec<PixelSums>]) -> MeasuredImage {
        let image = |of: &dyn Fn(&PixelSums) -> Rgb| {
            let values = |part: &Vec<PixelSums>| part.iter().map(|s| of(s).to_f32()).collect();
            let parts: Vec<Vec<[f32; 3]>> = parts.iter().map(values).collect();
            film.assemble(&parts)
        };
        let all = parts.iter().flatten();
        let [removed, kept] = all.fold([0.0; 2], |[removed, kept], s| {
            [removed + s.removed.mean(), kept + s.sum().mean()]
        });
        MeasuredImage {
            image: image(&PixelSums::mean),
            error: image(&PixelSums::standard_error),
            direct: image(&|s| s.direct / s.count()),
            indirect: image(&|s| (s.sum() - s.direct) / s.count()),
            halves: [0, 1].map(|k| image(&|s| s.half(k))),
            removed: if removed == 0.0 {
                0.0
            } else {
                removed / (removed + kept)
            },
        }
    }
}

/// Root mean square of the relative error of an image, over all pixels and channels.
///
/// The error is relative to the truth plus a tenth of the truth's mean radiance, so that neither
/// dark pixels nor the edges of lamps dominate. The images must have the same size; 0 for black
/// ones.
pub fn relative_rmse(found: &Image, truth: &Image) -> f64 {
    let (a, b) = (found.pixels.iter().flatten(), truth.pixels.iter().flatten());
    let dim = dim(truth);
    root_mean(
        a.zip(b)
            .map(|(&a, &b)| relative_square(f64::from(a) - f64::from(b), b.into(), dim)),
    )
}

/// A tenth of the mean radiance.
fn dim(image: &Image) -> f64 {
    let all = image.pixels.iter().flatten().map(|&v| f64::from(v));
    0.1 * all.sum::<f64>() / (3 * image.pixels.len()).max(1) as f64
}

fn relative_square(error: f64, light: f64, dim: f64) -> f64 {
    if error == 0.0 {
        return 0.0;
    }
    error * error / (light * light + dim * dim)
}

fn root_mean(squares: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0u32);
    for square in squares {
        sum += square;
        count += 1;
    }
    (sum / f64::from(count.max(1))).sqrt()
}

/// Sums over the samples of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PixelSums {
    /// Of the first and the second half of the samples.
    halves: [Rgb; 2],
    counts: [u32; 2],
    squares: Rgb,
    direct: Rgb,
    removed: Rgb,
    /// Whether any path depended on random numbers.
    pub is_random: bool,
}

impl PixelSums {
    /// Adds sample `sample` of `samples`.
    pub fn add(&mut self, found: &RayRadiance, sample: u32, samples: u32) {
        let (value, half) = (found.radiance(), usize::from(2 * sample >= samples));
        self.halves[half] += value;
        self.counts[half] += 1;
        self.squares += value * value;
        self.direct += found.direct;
        self.removed += found.removed;
        self.is_random |= found.is_random;
    }

    fn sum(&self) -> Rgb {
        self.halves[0] + self.halves[1]
    }

    fn count(&self) -> f64 {
        f64::from((self.counts[0] + self.counts[1]).max(1))
    }

    /// The mean of one half; of all samples if that half has none.
    fn half(&self, k: usize) -> Rgb {
        match self.counts[k] {
            0 => self.mean(),
            count => self.halves[k] / f64::from(count),
        }
    }

    /// Mean of the samples.
    pub fn mean(&self) -> Rgb {
        self.sum() / self.count()
    }

    /// Standard deviation of the samples.
    pub fn deviation(&self) -> Rgb {
        self.standard_error() * self.count().sqrt()
    }

    /// Its standard error as if the samples were independent; 0 for one sample.
    pub fn standard_error(&self) -> Rgb {
        let (n, mean) = (self.count(), self.mean());
        let variance = (self.squares / n - mean * mean) / (n - 1.0).max(1.0);
        variance.map(|v| v.max(0.0).sqrt())
    }
}
