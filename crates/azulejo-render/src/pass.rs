//! The second pass: options, and the loops over pixels and probe rays.

use crate::film::{Film, Lens, Tile};
use crate::integrator::{Integrator, Scratch};
use crate::measured::{MeasuredImage, PixelSums, RayRadiance};
use crate::path_sampler::PathSampler;
use azulejo_scene::math::Ray;
use azulejo_scene::{Camera, Image, Rgb, Scene};
use azulejo_trace::{Cancelled, KernelRay, Progress, Tracer};
use rayon::prelude::*;

/// How the second pass works.
#[derive(Clone, Debug, PartialEq)]
pub struct SecondPass {
    /// Image size in pixels, width then height. An image without pixels is allowed and empty.
    pub size: (u32, u32),
    /// Camera paths per pixel; 0 counts as 1.
    pub samples_per_pixel: u32,
    /// Where irradiance is gathered instead of interpolated between vertices.
    pub gather: FinalGather,
    /// Keys all random numbers. The same seed gives the same bits, whatever the threads.
    pub seed: u64,
    /// A safety cap on mirrors and boundaries along one path, for closed rooms of perfect
    /// mirrors, from which light never leaves. What a path still carries then is lost; paths end
    /// long before it by Russian roulette, which loses nothing on average.
    pub max_depth: u32,
    /// The most radiance, W/(sr·m²), that paths behind the first surface that scatters may add to one
    /// sample: above it is scaled down, which removes bright dots, and light. `None` removes
    /// nothing.
    pub clamp: Option<f64>,
}

/// Where paths gather irradiance, by rays over the hemisphere and the direct light of all lamps and
/// lights, at the diffuse surfaces that the camera sees straight or by mirrors and glass, instead of
/// interpolating it between vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FinalGather {
    /// Nowhere but on sides of which the scene carries no irradiance.
    #[default]
    Unknown,
    /// Also where the irradiance of the corners of a face differs so much that the light between
    /// them is not known: at the edges of shadows, and where a face passes from the light into the
    /// dark. So many rays at each hit.
    Uneven(u32),
    /// Everywhere, with so many rays at each hit. This hides the patches and sharpens contact shadows.
    /// It also renders a scene without irradiance, slowly: light is then followed over its first
    /// bounces only.
    Everywhere(u32),
}

impl FinalGather {
    /// Rays of a gather.
    pub(crate) fn rays(self) -> u32 {
        /// On a side of which the scene carries no irradiance.
        const BACK_RAYS: u32 = 32;
        match self {
            FinalGather::Unknown => BACK_RAYS,
            FinalGather::Uneven(rays) | FinalGather::Everywhere(rays) => rays.max(1),
        }
    }
}

impl Default for SecondPass {
    /// 512 × 512 pixels, 16 samples each, no final gather, seed 0, at most 1000 interfaces, no clamp.
    fn default() -> SecondPass {
        SecondPass {
            size: (512, 512),
            samples_per_pixel: 16,
            gather: FinalGather::Unknown,
            seed: 0,
            max_depth: 1000,
            clamp: None,
        }
    }
}

impl SecondPass {
    /// Paths that are followed together: enough to keep the kernel busy, few enough for the
    /// cache and for cancelling within a moment.
    fn batch(&self) -> u32 {
        const RAYS: u32 = 4096;
        const GATHER_RAYS: u32 = 1 << 18;
        let gathers = match self.gather {
            FinalGather::Everywhere(rays) => rays.max(1),
            FinalGather::Unknown | FinalGather::Uneven(_) => 1,
        };
        (GATHER_RAYS / gathers).clamp(1, RAYS)
    }
}

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
    let integrator = Integrator::new(scene, tracer, options);
    Ok(measure(integrator, camera, options, progress)?.image)
}

/// [`render`] with standard errors, and with direct and indirect light apart.
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

/// Renders all tiles.
fn measure(
    integrator: Integrator,
    camera: &Camera,
    options: &SecondPass,
    progress: &Progress,
) -> Result<MeasuredImage, Cancelled> {
    let (width, height) = options.size;
    assert!(
        width.checked_mul(height).is_some(),
        "an image of {width} × {height} pixels is too large"
    );
    let film = Film {
        width,
        height,
        seed: integrator.seed(),
    };
    let pass = ImagePass {
        integrator: integrator.behind(camera, options.size),
        lens: Lens::new(camera, f64::from(width) / f64::from(height)),
        film,
        samples: options.samples_per_pixel.max(1),
        batch: options.batch(),
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
            let found = probe(&integrator, rays, first, options, batch);
            progress.advance(rays.len() as u64)?;
            Ok(found)
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
        for (&i, found) in open.iter().zip(&batch.found) {
            sums[i] += found.radiance();
            counts[i] += 1;
        }
        let mut random = batch.found.iter().map(|found| found.is_random);
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
    progress: &'a Progress,
}

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
        let together = (self.batch / self.samples).max(1) as usize;
        for (pixels, sums) in pixels.chunks(together).zip(sums.chunks_mut(together)) {
            self.expose(pixels, sums, batch)?;
            self.progress.advance(pixels.len() as u64)?;
        }
        Ok(sums)
    }

    /// Adds up all samples of some pixels, a batch at a time.
    fn expose(
        &self,
        pixels: &[u32],
        sums: &mut [PixelSums],
        batch: &mut Batch,
    ) -> Result<(), Cancelled> {
        for start in (0..self.samples).step_by(self.batch as usize) {
            self.progress.advance(0)?;
            let count = self.batch.min(self.samples - start) as usize;
            let rays = pixels.iter().flat_map(|&pixel| {
                let pixel = self.film.pixel(pixel);
                let ray = move |sample| self.lens.ray(pixel.position(sample));
                (0..count as u32).map(move |k| self.integrator.kernel_ray(&ray(start + k)))
            });
            let sampler =
                |k: usize| PathSampler::new(pixels[k / count], start + (k % count) as u32);
            batch.trace(&self.integrator, rays, sampler);
            for (sum, found) in sums.iter_mut().zip(batch.found.chunks(count)) {
                for (sample, found) in (start..).zip(found) {
                    sum.add(found, sample, self.samples);
                }
            }
        }
        Ok(())
    }
}
