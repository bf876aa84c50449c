//! Lamps and lights as glossy surfaces show them: found by rays toward them, where a path that
//! goes on from the surface by chance would seldom meet a lamp and never a light without area.

use super::Gatherer;
use crate::follow::Path;
use crate::lights::{Look, mis_weight};
use crate::sampling::{hash, uniform};
use crate::{KernelHit, KernelRay};
use azulejo_scene::Rgb;
use azulejo_scene::brdf::Lobes;
use azulejo_scene::math::{Frame, Ray};
use glam::DVec3;
use std::f64::consts::PI;

/// Shadow rays end this share of their length before the lamp.
const SHORT: f64 = 1.0 - 1e-4;

/// Looks from glossy surfaces at lamps and lights that are still to be tested for shadow.
#[derive(Default)]
pub struct Glints {
    rays: Vec<KernelRay>,
    /// Whom each ray is for, and what it finds if nothing stands between.
    found: Vec<(u32, Rgb)>,
    blocked: Vec<bool>,
    /// Looks taken since the last were settled, those that showed nothing included: what keys
    /// random numbers must not depend on what earlier ones found.
    taken: u32,
}

impl Glints {
    /// Adds what the glossy surface at the end of `path` shows of lamps and lights, on behalf of
    /// `tag`; nothing where the surface is not glossy. `seed` keys the choice of places on lamps.
    pub fn add(&mut self, gatherer: &Gatherer, path: &Path, hit: &KernelHit, tag: u32, seed: u32) {
        let Some(gloss) = Gloss::new(gatherer, path, hit) else {
            return;
        };
        let key = self.key(seed);
        let u = [0, 1, 2].map(|d| f64::from(uniform(&[key, d])));
        if let Some(look) = gatherer.lights.look(gatherer.surfaces(), gloss.origin, u) {
            self.test(&gloss, tag, look.target, gloss.of_lamp(&look));
        }
        self.beams(&gloss, tag, key);
    }

    /// The same of lights without area alone.
    pub fn add_beams(
        &mut self,
        gatherer: &Gatherer,
        path: &Path,
        hit: &KernelHit,
        tag: u32,
        seed: u32,
    ) {
        if let Some(gloss) = Gloss::new(gatherer, path, hit) {
            let key = self.key(seed);
            self.beams(&gloss, tag, key);
        }
    }

    /// Keys the random numbers of one look.
    fn key(&mut self, seed: u32) -> u32 {
        self.taken += 1;
        hash(&[seed, self.taken])
    }

    fn beams(&mut self, gloss: &Gloss, tag: u32, key: u32) {
        let Gloss {
            gatherer,
            origin,
            frame,
            ..
        } = *gloss;
        let u = uniform(&[key, 3]).into();
        let beams = gatherer
            .lights
            .beams(gatherer.surfaces(), origin, frame.z, u);
        for beam in beams {
            let reflected = gloss.lobes.eval(gloss.wo, frame.to_local(beam.direction));
            self.test(gloss, tag, beam.target, reflected * beam.irradiance);
        }
    }

    /// Plans the shadow ray to a light by which `radiance` would be reflected.
    fn test(&mut self, gloss: &Gloss, tag: u32, target: DVec3, radiance: Rgb) {
        if radiance.max_channel() > 0.0 {
            let ray = Ray::between(gloss.origin, target);
            let ray = Ray {
                t_max: SHORT,
                ..ray
            };
            let tracer = gloss.gatherer.surfaces().tracer;
            self.rays.push(tracer.kernel_ray(&ray));
            self.found.push((tag, gloss.weight * radiance * PI));
        }
    }

    /// Tests all looks, tells of each that sees its light for whom it was and what it found, as
    /// exitance times the weight of the path, and forgets them.
    pub fn settle(&mut self, gatherer: &Gatherer, mut tell: impl FnMut(u32, Rgb)) {
        self.taken = 0;
        if self.rays.is_empty() {
            return;
        }
        let tracer = gatherer.surfaces().tracer;
        tracer.any(&self.rays, &mut self.blocked);
        for (&(tag, found), &blocked) in self.found.iter().zip(&self.blocked) {
            if !blocked {
                tell(tag, found);
            }
        }
        self.rays.clear();
        self.found.clear();
    }
}

/// A glossy surface as a path meets it.
struct Gloss<'g, 'a> {
    gatherer: &'g Gatherer<'a>,
    lobes: &'g Lobes,
    weight: Rgb,
    frame: Frame,
    /// Where rays start that leave it.
    origin: DVec3,
    /// Back along the path, in the frame.
    wo: DVec3,
}

impl<'g, 'a> Gloss<'g, 'a> {
    /// `None` where nothing is glossy, or nothing to be looked at.
    fn new(gatherer: &'g Gatherer<'a>, path: &Path, hit: &KernelHit) -> Option<Gloss<'g, 'a>> {
        let surfaces = gatherer.surfaces();
        let lobes = surfaces.glossy(hit.item)?;
        if gatherer.lights.is_empty() {
            return None;
        }
        let ray = surfaces.tracer.world_ray(&path.ray);
        let at = surfaces.tracer.resolve(&ray, hit);
        let facing = if at.entering { at.normal } else { -at.normal };
        let frame = surfaces.frame(&at, facing);
        Some(Gloss {
            gatherer,
            lobes,
            weight: path.weight,
            frame,
            origin: surfaces.tracer.leaving(at.position, facing),
            wo: frame.to_local(-ray.direction.normalize()),
        })
    }

    /// What is reflected of a look at a lamp, as far as the lobes would not find it themselves.
    fn of_lamp(&self, look: &Look) -> Rgb {
        let wi = self.frame.to_local(look.direction);
        let share = mis_weight(look.pdf, self.lobes.pdf(self.wo, wi));
        let reflected = self.lobes.eval(self.wo, wi) * look.radiance;
        reflected * (wi.z.max(0.0) * share / look.pdf)
    }
}
