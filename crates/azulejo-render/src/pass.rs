//! The second pass: the loops over pixels and probe rays.

use crate::budget;
use crate::film::{Film, Lens, Tile};
use crate::integrator::{Integrator, Scratch};
use crate::measured::{MeasuredImage, PixelSums, RayRadiance};
use crate::options::SecondPass;
use crate::path_sampler::PathSampler;
use azulejo_scene::math::Ray;
use azulejo_scene::{Camera, Image, Rgb, Scene};
use azulejo_trace::{Cancelled, KernelRay, Progress, Tracer};
use rayon::prelude::*;
use std::ops::Range;

/// Renders what `camera` sees: linear radiance, W/(sr·m²), averaged over each pixel by a tent
/// filter of one pixel's radius.
///
/// `tracer` must have been made from `scene`. Radiance at a surface is its emission plus ρ/π times
/// the irradiance of the vertices; mirrors, dielectrics and glossy lobes are followed; rays that
/// leave the scene find the background, or without one the ambient light; fog hides what is far
/// from the viewer. Surfaces without irradiance reflect nothing diffusely: without a first pass and
/// without [`gather`](SecondPass::gather) only lamps, their mirror images and the ambient light
/// show. Vertices carry the irradiance of the front, and of the back too where both sides of
/// a sheet were solved; where a path hits the side of a diffuse surface that they do not carry,
/// irradiance is gathered there. Meshes whose vertices have no irradiance show that of their lightmaps; beside
/// those, surfaces with neither gather it, too.
///
/// Counts pixels on `progress`.
///
/// # Errors
/// [`Cancelled`] when `progress` was, within about one batch of rays per thread.
///
/// # Panics
/// If the image has 2³² pixels or more.
pub fn render(
    scene: &Scene,
    tracer: &Tracer,
    camera: &Camera,
    options: &SecondPass,
    progress: &Progress,
) -> Result<Image, Cancelled> {
    Ok(render_with_errors(scene, tracer, camera, options, progress)?.image)
}

/// [`render`] with standard errors. Irradiance that is read from vertices counts as indirect light, though it
/// holds the direct part, too: [`render_measured`] tells them apart, by rays to every light from every sample.
///
/// # Errors
/// [`Cancelled`] when `progress` was.
///
/// # Panics
/// As [`render`].
pub fn render_with_errors(
    scene: &Scene,
    tracer: &Tracer,
    camera: &Camera,
    options: &SecondPass,
    progress: &Progress,
) -> Result<MeasuredImage, Cancelled> {
    measure(
        Integrator::new(scene, tracer, options),
        camera,
        options,
        progress,
    )
}

/// [`render_with_errors`] with fewer rays, if the picture would take more than about `rays`, and the options under
/// which it takes no more: first with fewer directions in the gathers of [`FinalGather::Uneven`](crate::FinalGather::Uneven), then with fewer
/// samples per pixel, but at least four of each.
///
/// A pilot of one path in each 64th pixel says what they cost, so the result is the same on every machine.
///
/// # Errors
/// [`Cancelled`] when `progress` was.
///
/// # Panics
/// As [`render`].
pub fn render_within(
    rays: u64,
    scene: &Scene,
    tracer: &Tracer,
    camera: &Camera,
    options: &SecondPass,
    progress: &Progress,
) -> Result<(MeasuredImage, SecondPass), Cancelled> {
    let mut integrator = Integrator::new(scene, tracer, options);
    let taken = budget::within(rays, options, &integrator, camera);
    integrator.gather = taken.gather;
    Ok((measure(integrator, camera, &taken, progress)?, taken))
}

/// [`render_with_errors`] with direct and indirect light apart.
///
/// The irradiance on vertices holds both: the direct part is computed anew where the camera sees it,
/// exactly at the edges of shadows, and the rest is indirect. Where the vertices do not resolve a
/// shadow, that may be negative. The image is the same as that of [`render`].
///
/// # Errors
/// [`Cancelled`] when `progress` was.
///
/// # Panics
/// As [`render`].
pub fn render_measured(
    scene: &Scene,
    tracer: &Tracer,
    camera: &Camera,
    options: &SecondPass,
    progress: &Progress,
) -> Result<MeasuredImage, Cancelled> {
    let mut integrator = Integrator::new(scene, tracer, options);
    integrator.splits = true;
    measure(integrator, camera, options, progress)
}

/// Irradiance, in the red of pixels that see no surface.
pub const NO_IRRADIANCE: f32 = -1.0;

/// Irradiance at the surfaces that `camera` sees first, W/m² (lx in photometric scenes), averaged over each pixel as by
/// [`render`]; [`NO_IRRADIANCE`] in all channels where its middle sees none.
///
/// On the side that is seen, whatever it reflects: mirrors, glass and lamps included. As in [`render`] it is that of the
/// vertices, or gathered by [`gather`](SecondPass::gather).
///
/// # Errors
/// [`Cancelled`] when `progress` was.
///
/// # Panics
/// As [`render`].
pub fn render_irradiance(
    scene: &Scene,
    tracer: &Tracer,
    camera: &Camera,
    options: &SecondPass,
    progress: &Progress,
) -> Result<Image, Cancelled> {
    let mut integrator = Integrator::new(scene, tracer, options);
    integrator.shows_irradiance = true;
    let mut image = measure(integrator, camera, options, progress)?.image;
    let (width, height) = options.size;
    let lens = Lens::new(camera, f64::from(width) / f64::from(height));
    let film = Film::new(options.size, 0);
    let middles = (0..width * height).map(|k| film.pixel(k).middle());
    let rays: Vec<KernelRay> = middles.map(|at| tracer.kernel_ray(&lens.ray(at))).collect();
    let mut hits = Vec::new();
    tracer.closest(&rays, &mut hits);
    for (pixel, hit) in image.pixels.iter_mut().zip(&hits) {
        if !hit.is_hit() {
            *pixel = [NO_IRRADIANCE; 3];
        }
    }
    Ok(image)
}

/// Renders all tiles.
fn measure(
    integrator: Integrator,
    camera: &Camera,
    options: &SecondPass,
    progress: &Progress,
) -> Result<MeasuredImage, Cancelled> {
    let (width, height) = options.size;
    let film = Film::new(options.size, integrator.seed());
    let pass = ImagePass {
        integrator: integrator.behind(camera, options.size),
        lens: Lens::new(camera, f64::from(width) / f64::from(height)),
        film,
        samples: options.samples_per_pixel.max(1),
        batch: options.batch(),
        contrast: options.contrast,
        progress,
    };
    progress.begin("render", u64::from(width) * u64::from(height));
    let parts: Result<Vec<_>, Cancelled> = film
        .tiles()
        .into_par_iter()
        .map_init(Batch::default, |batch, tile| pass.tile(tile, batch))
        .collect();
    Ok(MeasuredImage::assemble(&film, &parts?))
}

/// Radiance that arrives at the origin of each ray from its direction, W/(sr·m²), in their order.
///
/// Follows `samples_per_pixel` paths along a ray where random numbers are used (dielectrics, deep
/// mirrors, final gathers) and one where it does not. `t_min` and `t_max` of the rays hold for
/// the first surface; a ray that ends before one finds the background or the ambient light.
///
/// Counts rays on `progress`.
///
/// # Errors
/// [`Cancelled`] when `progress` was.
pub fn radiance(
    scene: &Scene,
    tracer: &Tracer,
    rays: &[Ray],
    options: &SecondPass,
    progress: &Progress,
) -> Result<Vec<Rgb>, Cancelled> {
    let integrator = Integrator::new(scene, tracer, options);
    let chunk = options.batch() as usize;
    progress.begin("radiance", rays.len() as u64);
    let parts: Result<Vec<Vec<Rgb>>, Cancelled> = rays
        .par_chunks(chunk)
        .enumerate()
        .map_init(Batch::default, |batch, (number, rays)| {
            progress.advance(0)?;
            let first = (number * chunk) as u32;
            let radiance = probe(&integrator, rays, first, options, batch);
            progress.advance(rays.len() as u64)?;
            Ok(radiance)
        })
        .collect();
    Ok(parts?.concat())
}

/// Radiance along the rays numbered from `first`.
fn probe(
    integrator: &Integrator,
    rays: &[Ray],
    first: u32,
    options: &SecondPass,
    batch: &mut Batch,
) -> Vec<Rgb> {
    let mut sums = vec![Rgb::BLACK; rays.len()];
    let mut counts = vec![0u32; rays.len()];
    let mut open: Vec<usize> = (0..rays.len()).collect();
    for sample in 0..options.samples_per_pixel.max(1) {
        let stream = |k: usize| first + open[k] as u32;
        let kernel = open.iter().map(|&i| integrator.kernel_ray(&rays[i]));
        batch.trace(integrator, kernel, |k| PathSampler::new(stream(k), sample));
        for (&i, light) in open.iter().zip(&batch.found) {
            sums[i] += light.radiance();
            counts[i] += 1;
        }
        let mut random = batch.found.iter().map(|light| light.is_random);
        open.retain(|_| random.next() == Some(true));
    }
    let mean = |(sum, count): (&Rgb, u32)| *sum / f64::from(count);
    sums.iter().zip(counts).map(mean).collect()
}

/// Everything that the tiles of one image share.
struct ImagePass<'a> {
    integrator: Integrator<'a>,
    lens: Lens,
    film: Film,
    samples: u32,
    batch: u32,
    contrast: Option<f64>,
    progress: &'a Progress,
}

/// Paths of a pixel that say whether it is even.
const FIRST_SAMPLES: u32 = 4;

/// Working memory of one thread.
#[derive(Default)]
struct Batch {
    rays: Vec<KernelRay>,
    found: Vec<RayRadiance>,
    scratch: Scratch,
}

impl Batch {
    /// Estimates the radiance along `rays`.
    fn trace(
        &mut self,
        integrator: &Integrator,
        rays: impl Iterator<Item = KernelRay>,
        sampler: impl Fn(usize) -> PathSampler,
    ) {
        self.rays.clear();
        self.rays.extend(rays);
        integrator.radiance(&self.rays, sampler, &mut self.scratch, &mut self.found);
    }
}

impl ImagePass<'_> {
    /// The pixels of one tile.
    fn tile(&self, tile: Tile, batch: &mut Batch) -> Result<Vec<PixelSums>, Cancelled> {
        let pixels: Vec<u32> = tile.pixels(self.film.width).collect();
        let mut sums = vec![PixelSums::default(); pixels.len()];
        let Some(contrast) = self.contrast.filter(|_| self.samples > FIRST_SAMPLES) else {
            self.expose(&pixels, &mut sums, 0..self.samples, batch)?;
            self.progress.advance(pixels.len() as u64)?;
            return Ok(sums);
        };
        self.expose(&pixels, &mut sums, 0..FIRST_SAMPLES, batch)?;
        let rough: Vec<usize> = rough_pixels(&sums, tile.width() as usize, contrast);
        let rough_numbers: Vec<u32> = rough.iter().map(|&k| pixels[k]).collect();
        let mut rough_sums: Vec<PixelSums> = rough.iter().map(|&k| sums[k]).collect();
        let rest = FIRST_SAMPLES..self.samples;
        self.expose(&rough_numbers, &mut rough_sums, rest, batch)?;
        for (k, sum) in rough.into_iter().zip(rough_sums) {
            sums[k] = sum;
        }
        self.progress.advance(pixels.len() as u64)?;
        Ok(sums)
    }

    /// Adds up a range of the samples of some pixels, a batch at a time.
    fn expose(
        &self,
        pixels: &[u32],
        sums: &mut [PixelSums],
        samples: Range<u32>,
        batch: &mut Batch,
    ) -> Result<(), Cancelled> {
        let together = (self.batch / samples.len().max(1) as u32).max(1) as usize;
        for (pixels, sums) in pixels.chunks(together).zip(sums.chunks_mut(together)) {
            self.expose_together(pixels, sums, samples.clone(), batch)?;
        }
        Ok(())
    }

    /// The same for pixels that fit into a batch, or one pixel.
    fn expose_together(
        &self,
        pixels: &[u32],
        sums: &mut [PixelSums],
        samples: Range<u32>,
        batch: &mut Batch,
    ) -> Result<(), Cancelled> {
        for start in samples.clone().step_by(self.batch as usize) {
            self.progress.advance(0)?;
            let count = self.batch.min(samples.end - start) as usize;
            let rays = pixels.iter().flat_map(|&pixel| {
                let pixel = self.film.pixel(pixel);
                let ray = move |sample| self.lens.ray(pixel.position(sample));
                (0..count as u32).map(move |k| self.integrator.kernel_ray(&ray(start + k)))
            });
            let sampler =
                |k: usize| PathSampler::new(pixels[k / count], start + (k % count) as u32);
            batch.trace(&self.integrator, rays, sampler);
            for (sum, of_pixel) in sums.iter_mut().zip(batch.found.chunks(count)) {
                for (sample, light) in (start..).zip(of_pixel) {
                    sum.add(light, sample, self.samples);
                }
            }
        }
        Ok(())
    }
}

/// The pixels of a tile, `width` wide, that are not even: within themselves, or beside another that differs. Where
/// paths are random, few of them may have missed what is seldom found.
fn rough_pixels(sums: &[PixelSums], width: usize, contrast: f64) -> Vec<usize> {
    let differs = |a: Rgb, b: Rgb, by: Rgb| {
        by.map(f64::abs).max_channel() > contrast * a.mean().max(b.mean())
    };
    let means: Vec<Rgb> = sums.iter().map(PixelSums::mean).collect();
    let mut rough: Vec<bool> = sums
        .iter()
        .zip(&means)
        .map(|(sum, &mean)| sum.is_random || differs(mean, mean, sum.deviation() * 2.0))
        .collect();
    for k in 0..sums.len() {
        let right = (k % width + 1 < width).then_some(k + 1);
        let below = Some(k + width).filter(|&q| q < sums.len());
        for q in [right, below].into_iter().flatten() {
            if differs(means[k], means[q], means[k] - means[q]) {
                rough[k] = true;
                rough[q] = true;
            }
        }
    }
    (0..sums.len()).filter(|&k| rough[k]).collect()
}
