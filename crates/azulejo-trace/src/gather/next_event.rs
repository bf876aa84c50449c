//! Next event estimation at glossy surfaces: rays toward the lights, as a path that continues in a
//! sampled direction seldom hits a lamp or the sun, and never a light without area.

use super::Gatherer;
use crate::follow::{Path, branching};
use crate::interaction::{SurfaceInteraction, shadow_ray};
use crate::lights::{LightSample, mis_weight};
use crate::sampling::{hash, uniform};
use crate::{KernelHit, KernelRay};
use azulejo_scene::Rgb;
use azulejo_scene::brdf::Lobes;
use azulejo_scene::math::Frame;
use glam::DVec3;
use std::f64::consts::PI;

/// Light samples of glossy surfaces that are still to be tested for shadow.
#[derive(Default)]
pub struct NextEvent {
    rays: Vec<KernelRay>,
    /// The caller's tag of each ray, and what it contributes if nothing stands between.
    contributions: Vec<(u32, Rgb)>,
    /// What passes along each ray.
    shares: Vec<Rgb>,
    /// Surfaces that took samples since the last [`resolve`](NextEvent::resolve), those whose
    /// samples were black included: the keys of random numbers must not depend on what earlier
    /// samples found.
    taken: u32,
}

impl NextEvent {
    /// Samples the lights from the surface at the end of `path`, if it is glossy. `tag` comes back
    /// with the contribution; `seed` keys the choice of points on lamps.
    pub fn add(&mut self, gatherer: &Gatherer, path: &Path, hit: &KernelHit, tag: u32, seed: u32) {
        let Some(gloss) = Gloss::new(gatherer, path, hit) else {
            return;
        };
        let key = self.key(seed);
        let u = [0, 1, 2].map(|d| f64::from(uniform(&[key, d])));
        let sample = gatherer.lights.sample(gatherer.surfaces(), gloss.origin, u);
        if let Some(sample) = sample {
            self.test(&gloss, tag, sample.target, gloss.reflected(&sample));
        }
        self.other_lights(&gloss, tag, key);
    }

    /// [`add`](NextEvent::add) without lamps: for lights without area, and what is outside.
    pub fn add_other_lights(
        &mut self,
        gatherer: &Gatherer,
        path: &Path,
        hit: &KernelHit,
        tag: u32,
        seed: u32,
    ) {
        if let Some(gloss) = Gloss::new(gatherer, path, hit) {
            let key = self.key(seed);
            self.other_lights(&gloss, tag, key);
        }
    }

    /// Keys the random numbers of one surface.
    fn key(&mut self, seed: u32) -> u32 {
        self.taken += 1;
        hash(&[seed, self.taken])
    }

    fn other_lights(&mut self, gloss: &Gloss, tag: u32, key: u32) {
        let Gloss {
            gatherer,
            origin,
            frame,
            ..
        } = *gloss;
        let u = [4, 5, 6].map(|d| f64::from(uniform(&[key, d])));
        let outside = gatherer
            .lights
            .sample_outside(gatherer.surfaces(), origin, u);
        if let Some(sample) = outside {
            self.test(gloss, tag, sample.target, gloss.reflected(&sample));
        }
        let u = uniform(&[key, 3]).into();
        let samples = gatherer
            .lights
            .sample_delta(gatherer.surfaces(), origin, frame.z, u);
        for sample in samples {
            let wi = frame.to_local(sample.direction);
            let reflected = gloss.lobes.eval(gloss.wo, wi) * sample.irradiance;
            self.test(gloss, tag, sample.target, reflected);
        }
    }

    /// Plans the shadow ray to a light of which `radiance` would be reflected.
    fn test(&mut self, gloss: &Gloss, tag: u32, target: DVec3, radiance: Rgb) {
        if radiance.max_channel() > 0.0 {
            let tracer = gloss.gatherer.surfaces().tracer;
            self.rays.push(shadow_ray(tracer, gloss.origin, target));
            self.contributions.push((tag, gloss.weight * radiance * PI));
        }
    }

    /// Tests all samples for shadow and forgets them. Reports the tag of each that sees its light
    /// and its contribution: exitance times the weight of the path.
    pub fn resolve(&mut self, gatherer: &Gatherer, mut report: impl FnMut(u32, Rgb)) {
        self.taken = 0;
        if self.rays.is_empty() {
            return;
        }
        let tracer = gatherer.surfaces().tracer;
        tracer.transmittance(&self.rays, &mut self.shares);
        for (&(tag, light), &share) in self.contributions.iter().zip(&self.shares) {
            if !share.is_black() {
                report(tag, light * share);
            }
        }
        self.rays.clear();
        self.contributions.clear();
    }
}

/// A glossy surface that a path hits.
struct Gloss<'g, 'a> {
    gatherer: &'g Gatherer<'a>,
    lobes: &'g Lobes,
    weight: Rgb,
    frame: Frame,
    /// Where rays start that leave it.
    origin: DVec3,
    /// Unit, back along the path, in the frame.
    wo: DVec3,
    /// Probability that the path goes on by the lobes.
    lobe_probability: f64,
}

impl<'g, 'a> Gloss<'g, 'a> {
    /// `None` where the surface is not glossy or the scene has no lights to sample.
    fn new(gatherer: &'g Gatherer<'a>, path: &Path, hit: &KernelHit) -> Option<Gloss<'g, 'a>> {
        let surfaces = gatherer.surfaces();
        let lobes = surfaces.glossy(hit.item)?;
        if gatherer.lights.is_empty() {
            return None;
        }
        let at = SurfaceInteraction::new(surfaces.tracer, &path.leg.ray, hit);
        let frame = at.frame(surfaces);
        let wo = frame.to_local(-at.direction);
        let material = surfaces.material(hit.item);
        Some(Gloss {
            gatherer,
            lobes,
            weight: path.weight,
            frame,
            origin: at.origin(surfaces.tracer),
            wo,
            lobe_probability: branching(material, lobes, wo, path.depth).lobe_probability(),
        })
    }

    /// What is reflected of a sample of a lamp, weighted against the lobes' own samples.
    fn reflected(&self, sample: &LightSample) -> Rgb {
        let wi = self.frame.to_local(sample.direction);
        let by_lobes = self.lobe_probability * self.lobes.pdf(self.wo, wi);
        let share = mis_weight(sample.pdf, by_lobes);
        let reflected = self.lobes.eval(self.wo, wi) * sample.radiance;
        reflected * (wi.z.max(0.0) * share / sample.pdf)
    }
}
