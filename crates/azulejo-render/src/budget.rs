//! What a picture will cost, from a few of its pixels, and options under which it costs less.
//!
//! Costs are numbers of rays, never seconds, so that the same scene always gives the same picture.

use crate::film::{Film, Lens};
use crate::integrator::{Integrator, Scratch};
use crate::path_cost::PathCost;
use crate::path_sampler::PathSampler;
use crate::{FinalGather, SecondPass};
use azulejo_scene::Camera;
use azulejo_trace::KernelRay;

/// Distance of the pixels of the pilot, along rows and columns.
const STRIDE: u32 = 8;

/// Fewest directions of a gather, one for each replicate.
const FEWEST_DIRECTIONS: u32 = 4;

/// Fewest camera paths per pixel: edges would show steps with fewer.
const FEWEST_SAMPLES: u32 = 4;

/// The same options with fewer rays, if the picture would take more than about `rays`: first with fewer directions in
/// the gathers of [`FinalGather::Uneven`], then with fewer samples per pixel, but at least four of each.
///
/// A pilot of one path in each 64th pixel says what they cost. The result depends on the scene, the camera and the
/// options alone.
pub(crate) fn within(
    rays: u64,
    options: &SecondPass,
    integrator: &Integrator,
    camera: &Camera,
) -> SecondPass {
    let cost = pilot(integrator, camera, options.size);
    let pixels = f64::from(options.size.0) * f64::from(options.size.1);
    let mut options = options.clone();
    loop {
        let each = cost.with_gathers(options.gather.rays());
        let samples = f64::from(options.samples_per_pixel.max(1));
        let is_affordable = pixels * samples * each <= rays as f64;
        if is_affordable || !options.halve(cost.gathers > 0.0) {
            return options;
        }
    }
}

impl SecondPass {
    /// Halves what costs rays and shows least; false if nothing is left to halve.
    fn halve(&mut self, has_gathers: bool) -> bool {
        if let FinalGather::Uneven(directions) = &mut self.gather
            && has_gathers
            && *directions > FEWEST_DIRECTIONS
        {
            *directions = (*directions / 2).max(FEWEST_DIRECTIONS);
            return true;
        }
        let can_halve = self.samples_per_pixel > FEWEST_SAMPLES;
        if can_halve {
            self.samples_per_pixel = (self.samples_per_pixel / 2).max(FEWEST_SAMPLES);
        }
        can_halve
    }
}

/// What paths of a picture cost, from one path in the middle of each block of pixels.
fn pilot(integrator: &Integrator, camera: &Camera, (width, height): (u32, u32)) -> PathCost {
    let film = Film::new((width, height), integrator.seed());
    let lens = Lens::new(camera, f64::from(width) / f64::from(height));
    let middles = |length: u32| {
        (0..length.div_ceil(STRIDE)).map(move |k| (k * STRIDE + STRIDE / 2).min(length - 1))
    };
    let pixels: Vec<u32> = middles(height)
        .flat_map(|y| middles(width).map(move |x| y * width + x))
        .collect();
    let ray = |&pixel: &u32| integrator.kernel_ray(&lens.ray(film.pixel(pixel).position(0)));
    let rays: Vec<KernelRay> = pixels.iter().map(ray).collect();
    let sampler = |k: usize| PathSampler::new(pixels[k], 0);
    integrator.cost(&rays, sampler, &mut Scratch::default())
}
