//! A scene as paths from the eye meet it: what stands where, what shines, and what is seen beyond.

use crate::interpolate::Interpolator;
use crate::shading::{Colors, Parts, Shading};
use azulejo_scene::math::{Ray, reflect};
use azulejo_scene::{Material, Rgb, Scene};
use azulejo_trace::interaction::SurfaceInteraction;
use azulejo_trace::lights::mis_weight;
use azulejo_trace::{Gatherer, KernelHit, KernelRay, Surfaces, Tracer};
use glam::DVec3;

/// Shadow rays end this share of their length before the lamp.
const SHORT: f64 = 1.0 - 1e-4;

/// A scene with all that its pictures look up. Immutable, shared by all threads.
pub(crate) struct Scenery<'a> {
    pub gatherer: Gatherer<'a>,
    pub interpolator: Interpolator<'a>,
    /// What the eye sees beyond the scene, straight and in mirrors: the background, else the
    /// surroundings.
    pub sky: Rgb,
}

/// What is still to be tested for shadow.
#[derive(Default)]
pub(crate) struct Shadows {
    rays: Vec<KernelRay>,
    light: Vec<Rgb>,
    blocked: Vec<bool>,
}

impl<'a> Scenery<'a> {
    pub fn new(scene: &'a Scene, tracer: &'a Tracer) -> Scenery<'a> {
        let gatherer = Gatherer::new(Surfaces::new(scene, tracer));
        Scenery {
            sky: scene.background.unwrap_or(gatherer.ambient()),
            gatherer,
            interpolator: Interpolator::new(scene, tracer),
        }
    }

    pub fn tracer(&self) -> &'a Tracer {
        self.surfaces().tracer
    }

    pub fn surfaces(&self) -> &Surfaces<'a> {
        self.gatherer.surfaces()
    }

    /// The interaction at a hit, with the interpolated normal for shading.
    pub fn interaction(&self, ray: &KernelRay, hit: &KernelHit) -> SurfaceInteraction {
        let at = SurfaceInteraction::new(self.tracer(), ray, hit);
        SurfaceInteraction {
            shading_normal: self.shading_normal(hit, at.facing, at.direction),
            ..at
        }
    }

    /// The normal for mirrors, dielectrics and reflection models: the interpolated one of a
    /// smooth mesh, on the side of the face's own, `facing`; `facing` itself where the mesh has
    /// none, or where the interpolated one would mirror the ray into the face.
    fn shading_normal(&self, hit: &KernelHit, facing: DVec3, direction: DVec3) -> DVec3 {
        let Some(normal) = self.interpolator.shading_normal(hit) else {
            return facing;
        };
        let n = normal * 1f64.copysign(normal.dot(facing));
        let is_usable = direction.dot(n) < 0.0 && reflect(direction, n).dot(facing) > 0.0;
        if is_usable { n } else { facing }
    }

    /// Some parts of the reflection model of a surface at a hit.
    pub fn shading(
        &self,
        hit: &KernelHit,
        at: &SurfaceInteraction,
        material: &'a Material,
        parts: Parts,
    ) -> Shading<'a> {
        let brdf = material.brdf.as_deref();
        let frame = at.frame(self.surfaces());
        let origin = at.origin(self.tracer());
        let reflectance = self.interpolator.reflectance(hit, material);
        let colors = Colors::new(reflectance, brdf);
        Shading::new(
            (frame, at.facing, origin),
            at.direction,
            colors,
            brdf,
            parts,
        )
    }

    /// Radiance that a surface reflects of one look at the lamps and of the lights without area,
    /// for four numbers in 0..1. The look counts as far as it is likelier than to be found by
    /// chance in the surface's own directions, of which a share `by_chance` of paths draws one.
    pub fn lit(
        &self,
        shading: &Shading,
        u: [f64; 4],
        by_chance: f64,
        shadows: &mut Shadows,
    ) -> Rgb {
        let (surfaces, lights) = (self.surfaces(), self.gatherer.lights());
        shadows.forget();
        if let Some(look) = lights.look(surfaces, shading.origin, [u[0], u[1], u[2]]) {
            let chance = by_chance * shading.pdf(look.direction);
            let share = mis_weight(look.pdf, chance) / look.pdf;
            let light = shading.eval(look.direction) * look.radiance * share;
            shadows.plan(self.tracer(), shading.origin, look.target, light);
        }
        let normal = shading.frame.z;
        for beam in lights.beams(surfaces, shading.origin, normal, u[3]) {
            let cos = beam.direction.dot(normal);
            let light = shading.eval(beam.direction) * beam.irradiance / cos;
            shadows.plan(self.tracer(), shading.origin, beam.target, light);
        }
        shadows.light(self.tracer())
    }

    /// Radiance that an emitter sends along a ray that arrived at it, less what was looked for
    /// where the ray set out: its direction was drawn there with this `density`, zero if it was
    /// not drawn.
    pub fn emitted(&self, ray: &KernelRay, hit: &KernelHit, density: f64) -> Rgb {
        let surfaces = self.surfaces();
        if !surfaces.is_emitter(hit.item) {
            return Rgb::BLACK;
        }
        let is_front = surfaces.is_front(ray, hit);
        let emitted = surfaces.material(hit.item).emission_from(is_front);
        if density == 0.0 || emitted.is_black() {
            return emitted;
        }
        let looked_for = self.gatherer.lights().pdf(surfaces, ray, hit);
        emitted * mis_weight(density, looked_for)
    }

    /// What fog leaves of the light along a camera's ray, and what it adds. Fog is a matter of
    /// the viewer: it hides no background, and mirrors show what they show.
    pub fn fog(&self, ray: &KernelRay, hit: &KernelHit) -> Option<(f64, Rgb)> {
        let fog = self.surfaces().scene.fog.filter(|_| hit.is_hit())?;
        let ray = self.tracer().world_ray(ray);
        let distance = self
            .tracer()
            .resolve(&ray, hit)
            .position
            .distance(ray.origin);
        let clear = fog.transmittance(distance);
        Some((clear, fog.color * (1.0 - clear)))
    }
}

impl Shadows {
    fn forget(&mut self) {
        self.rays.clear();
        self.light.clear();
    }

    fn plan(&mut self, tracer: &Tracer, from: DVec3, to: DVec3, light: Rgb) {
        if light.max_channel() > 0.0 && light.is_finite() {
            let ray = Ray {
                t_max: SHORT,
                ..Ray::between(from, to)
            };
            self.rays.push(tracer.kernel_ray(&ray));
            self.light.push(light);
        }
    }

    /// The sum of what nothing stands before.
    fn light(&mut self, tracer: &Tracer) -> Rgb {
        if self.rays.is_empty() {
            return Rgb::BLACK;
        }
        tracer.any(&self.rays, &mut self.blocked);
        let free = self.light.iter().zip(&self.blocked);
        free.filter(|(_, blocked)| !**blocked)
            .map(|(light, _)| *light)
            .sum()
    }
}
