//! Reference images by path tracing, which both passes are tested against.
//!
//! No first pass, no patches, no irradiance: every surface reflects by its model at every bounce
//! (Kajiya, *The Rendering Equation*, SIGGRAPH 1986) until Russian roulette ends the path. Lamps
//! are sampled at each surface and hit by chance, weighted so that each counts once (Veach and
//! Guibas 1995). Slow, unbiased, and with a standard error for every pixel.

use crate::film::{Film, Lens, Tile};
use crate::measured::{MeasuredImage, PixelSums, RayRadiance};
use crate::path_sampler::PathSampler;
use crate::render_scene::{RenderScene, ShadowBatch};
use crate::shading::{Parts, mirrored};
use azulejo_scene::math::Ray;
use azulejo_scene::{Camera, Rgb, Scene};
use azulejo_trace::interaction::{Branching, Continuation, Roulette, SurfaceInteraction};
use azulejo_trace::medium::Leg;
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, KernelHit, KernelRay, Progress, Tracer};
use rayon::prelude::*;

/// Number of surfaces after which roulette may end a path.
const ROULETTE_DEPTH: u32 = 4;

/// Starts at the full weight of a path, not at 1% of it as in the two passes: paths scatter at
/// every surface here, and would be several times longer. No path survives with certainty, so that
/// those in white rooms end too.
const ROULETTE: Roulette = Roulette {
    below: 1.0,
    most: 0.98,
};

/// Options of a reference image.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferencePass {
    /// Image size in pixels, width then height.
    pub size: (u32, u32),
    /// Paths per pixel; fewer than 2 count as 2, as one path has no standard error.
    pub samples_per_pixel: u32,
    /// Keys all random numbers.
    pub seed: u64,
    /// A safety cap on surfaces along one path. What a path still carries there is lost; roulette
    /// ends it long before, which loses nothing on average.
    pub max_depth: u32,
    /// The most radiance, W/(sr·m²), that the indirect light of one path may have: above it is
    /// scaled down, which removes bright dots, and light. `None` for an unbiased image.
    pub clamp: Option<f64>,
}

impl Default for ReferencePass {
    /// 512 × 512 pixels, 256 samples each, seed 0, at most 1000 surfaces.
    fn default() -> ReferencePass {
        ReferencePass {
            size: (512, 512),
            samples_per_pixel: 256,
            seed: 0,
            max_depth: 1000,
            clamp: None,
        }
    }
}

/// Renders what `camera` sees by path tracing; irradiance that the scene may carry is ignored.
///
/// `tracer` must have been made from `scene`. The pixel filter, fog, and what is seen beyond the
/// scene are those of [`render`](crate::render()). Caustics of point and spot lights, which no path
/// can find, are missing. Counts pixels on `progress`.
///
/// # Errors
/// [`Cancelled`] when `progress` was.
///
/// # Panics
/// If the image has 2³² pixels or more.
pub fn reference(
    scene: &Scene,
    tracer: &Tracer,
    camera: &Camera,
    options: &ReferencePass,
    progress: &Progress,
) -> Result<MeasuredImage, Cancelled> {
    let (width, height) = options.size;
    let mut path_tracer = PathTracer::new(scene, tracer, options);
    path_tracer.scene = path_tracer.scene.behind(camera, options.size);
    let film = Film::new(options.size, path_tracer.seed);
    let lens = Lens::new(camera, f64::from(width) / f64::from(height));
    progress.begin("reference", u64::from(width) * u64::from(height));
    let tile = |scratch: &mut Scratch, tile: Tile| -> Result<Vec<PixelSums>, Cancelled> {
        let pixel = |index: u32| {
            progress.advance(1)?;
            let pixel = film.pixel(index);
            let ray = |sample| path_tracer.kernel_ray(&lens.ray(pixel.position(sample)));
            path_tracer.average(index, ray, scratch, progress)
        };
        tile.pixels(width).map(pixel).collect()
    };
    let parts = film.tiles().into_par_iter();
    let parts = parts.map_init(Scratch::default, tile);
    let parts: Vec<Vec<PixelSums>> = parts.collect::<Result<_, Cancelled>>()?;
    Ok(MeasuredImage::assemble(&film, &parts))
}

/// Radiance that arrives at the origin of each ray from its direction, and its standard error, by
/// the path tracing of [`reference()`] with `samples_per_pixel` paths per ray.
///
/// # Errors
/// [`Cancelled`] when `progress` was.
pub fn reference_radiance(
    scene: &Scene,
    tracer: &Tracer,
    rays: &[Ray],
    options: &ReferencePass,
    progress: &Progress,
) -> Result<Vec<(Rgb, Rgb)>, Cancelled> {
    let path_tracer = PathTracer::new(scene, tracer, options);
    progress.begin("reference", rays.len() as u64);
    let one = |scratch: &mut Scratch, (index, ray): (usize, &Ray)| {
        progress.advance(1)?;
        let ray = path_tracer.kernel_ray(ray);
        let sums = path_tracer.average(index as u32, |_| ray, scratch, progress)?;
        Ok((sums.mean(), sums.standard_error()))
    };
    let rays = rays.par_iter().enumerate();
    rays.map_init(Scratch::default, one).collect()
}

/// Traces paths in one scene. Immutable, shared by all threads.
struct PathTracer<'a> {
    scene: RenderScene<'a>,
    seed: u32,
    samples: u32,
    max_depth: u32,
    clamp: Option<f64>,
}

/// Working memory of one thread.
#[derive(Default)]
struct Scratch {
    hits: Vec<KernelHit>,
    shadows: ShadowBatch,
}

/// A path while it is traced.
struct PathState {
    leg: Leg,
    weight: Rgb,
    /// What was found so far.
    found: RayRadiance,
    /// Surfaces so far that scattered the path; mirrors and glass do not.
    scattered: u32,
    /// Density of the direction, 1/sr, if it was sampled where the lamps were sampled too; 0
    /// otherwise.
    density: f64,
}

impl PathState {
    /// Counts light that arrives by so many more surfaces that scatter.
    fn count(&mut self, more: u32, light: Rgb) {
        let light = self.weight * light;
        if self.scattered + more <= 1 {
            self.found.direct += light;
        } else {
            self.found.sampled += light;
        }
    }
}

impl<'a> PathTracer<'a> {
    fn new(scene: &'a Scene, tracer: &'a Tracer, options: &ReferencePass) -> PathTracer<'a> {
        PathTracer {
            scene: RenderScene::new(scene, tracer),
            seed: hash(&[options.seed as u32, (options.seed >> 32) as u32, 0x7ef]),
            samples: options.samples_per_pixel.max(2),
            max_depth: options.max_depth,
            clamp: options.clamp,
        }
    }

    fn kernel_ray(&self, ray: &Ray) -> KernelRay {
        self.scene.tracer().kernel_ray(ray)
    }

    /// All samples of a stream.
    fn average(
        &self,
        stream: u32,
        ray: impl Fn(u32) -> KernelRay,
        scratch: &mut Scratch,
        progress: &Progress,
    ) -> Result<PixelSums, Cancelled> {
        let mut sums = PixelSums::default();
        for sample in 0..self.samples {
            if sample % 64 == 0 {
                progress.advance(0)?;
            }
            let radiance = self.trace(ray(sample), PathSampler::new(stream, sample), scratch);
            sums.add(&radiance, sample, self.samples);
        }
        Ok(sums)
    }

    /// Radiance along one path.
    fn trace(
        &self,
        ray: KernelRay,
        mut sampler: PathSampler,
        scratch: &mut Scratch,
    ) -> RayRadiance {
        let mut path = PathState {
            leg: Leg::from(ray),
            weight: Rgb::WHITE,
            found: RayRadiance::default(),
            scattered: 0,
            density: 0.0,
        };
        for depth in 0..self.max_depth {
            let ray = std::slice::from_ref(&path.leg.ray);
            self.scene.tracer().closest(ray, &mut scratch.hits);
            let (hit, _) = path.leg.hit(self.scene.surfaces(), &scratch.hits[0]);
            if depth == 0 {
                self.through_fog(&mut path, &hit);
            }
            if !hit.is_hit() {
                let is_sharp = path.scattered == 0;
                path.count(0, self.scene.beyond(&path.leg.ray, is_sharp, path.density));
                break;
            }
            let (at, next) =
                if let Some((film, glass)) = path.leg.air_film(self.scene.surfaces(), &hit) {
                    let interface = film.interface(glass);
                    let next = interface.map(|glass| glass.chosen(sampler.next(self.seed)));
                    (film, next)
                } else {
                    path.count(0, self.scene.emitted(&path.leg.ray, &hit, path.density));
                    let at = self.scene.interaction(&path.leg.ray, &hit);
                    let next = self.scatter(&mut path, &hit, &at, &mut sampler, scratch);
                    (at, next)
                };
            let Some(next) = next.and_then(|n| self.roulette(n, depth, &path, &mut sampler)) else {
                break;
            };
            self.turn(&mut path, &at, &next);
        }
        if let Some(most) = self.clamp {
            path.found.limit(most);
        }
        path.found
    }

    fn through_fog(&self, path: &mut PathState, hit: &KernelHit) {
        if let Some((clear, added)) = self.scene.fog(&path.leg.ray, hit) {
            path.found.direct += added;
            path.weight *= clear;
        }
    }

    /// Adds the light of lamps at a surface, and chooses where the path continues.
    fn scatter(
        &self,
        path: &mut PathState,
        hit: &KernelHit,
        at: &SurfaceInteraction,
        sampler: &mut PathSampler,
        scratch: &mut Scratch,
    ) -> Option<Continuation> {
        let material = self.scene.surfaces().material(hit.item);
        if let Some(interface) = at.interface(material) {
            return Some(interface.chosen(sampler.next(self.seed)));
        }
        let shading = self.scene.shading(hit, at, material, Parts::All);
        let mirror = mirrored(material, -at.direction.dot(at.shading_normal));
        let scattered = if shading.is_black() {
            0.0
        } else {
            shading.likely()
        };
        let branching = Branching::new(false, mirror.mean(), || scattered);
        let mut four = || [(); 4].map(|()| sampler.next(self.seed));
        if scattered > 0.0 {
            let (u, shadows) = (four(), &mut scratch.shadows);
            let probability = branching.lobe_probability();
            path.count(1, self.scene.lit(&shading, u, probability, shadows));
        }
        let u = four();
        // Each surface takes as many random numbers, whatever it chooses from.
        let chance = sampler.next(self.seed);
        match branching.choose(|| chance) {
            (Some(probability), _) => Some(at.mirrored(mirror).over(probability)),
            (None, probability) => Some(shading.sample(u)?.chosen(probability?)),
        }
    }

    /// The continuation, or a heavier one, or none, by chance.
    fn roulette(
        &self,
        next: Continuation,
        depth: u32,
        path: &PathState,
        sampler: &mut PathSampler,
    ) -> Option<Continuation> {
        let weight = (path.weight * next.weight).max_channel();
        if depth < ROULETTE_DEPTH {
            return (weight > 0.0).then_some(next);
        }
        let survival = ROULETTE.survival(weight, || sampler.next(self.seed));
        survival.map(|odds| next.over(odds))
    }

    /// The path leaves the surface in that direction.
    fn turn(&self, path: &mut PathState, at: &SurfaceInteraction, next: &Continuation) {
        path.leg = at.leg(self.scene.surfaces(), next, path.leg.medium);
        path.weight *= next.weight;
        path.scattered += u32::from(next.density != 0.0);
        path.density = next.density_after(path.density);
    }
}
