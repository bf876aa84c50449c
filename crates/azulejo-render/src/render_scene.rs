//! What camera paths need of a scene: interactions, shading, emission, direct light and fog.

use crate::film::Lens;
use crate::interpolate::Interpolator;
use crate::shading::{Colors, Parts, Shading, ShadingPoint};
use crate::surface_maps::{Finish, FinishLobes, SurfaceMaps};
use azulejo_scene::math::reflect;
use azulejo_scene::{Backplate, Camera, Image, Material, Rgb, Scene, SceneBackground};
use azulejo_trace::interaction::{SurfaceInteraction, shadow_ray};
use azulejo_trace::lights::mis_weight;
use azulejo_trace::{Gatherer, KernelHit, KernelRay, Surfaces, Tracer};
use glam::DVec3;

/// A scene with its tables for rendering. Immutable, shared by all threads.
pub(crate) struct RenderScene<'a> {
    pub gatherer: Gatherer<'a>,
    pub interpolator: Interpolator<'a>,
    maps: SurfaceMaps,
    /// What the camera sees beyond the scene, straight and in mirrors, unless that is the
    /// surroundings.
    background: Option<SceneBackground>,
    /// A picture that fills the image, where it is known which image that is.
    backplate: Option<PlacedBackplate<'a>>,
}

/// A backplate behind an image.
struct PlacedBackplate<'a> {
    plate: Backplate,
    picture: Option<&'a Image>,
    lens: Lens,
    size: [f64; 2],
}

impl PlacedBackplate<'_> {
    /// The radiance in a direction; `None` for directions beside the image.
    fn seen(&self, direction: DVec3) -> Option<Rgb> {
        let point = self.lens.point(direction)?;
        Some(self.plate.seen(point, self.size, self.picture))
    }
}

/// Contributions of lights that are still to be tested for shadow.
#[derive(Default)]
pub(crate) struct ShadowBatch {
    rays: Vec<KernelRay>,
    light: Vec<Rgb>,
    /// What passes along each ray.
    shares: Vec<Rgb>,
}

impl<'a> RenderScene<'a> {
    pub fn new(scene: &'a Scene, tracer: &'a Tracer) -> RenderScene<'a> {
        let gatherer = Gatherer::new(Surfaces::new(scene, tracer));
        RenderScene {
            // Without an image, there is nowhere to put a backplate.
            background: scene
                .background
                .filter(|b| !matches!(b, SceneBackground::Backplate(_))),
            backplate: None,
            gatherer,
            interpolator: Interpolator::new(scene, tracer),
            maps: SurfaceMaps::new(scene),
        }
    }

    /// The same for an image of this size of what a camera sees, behind which a backplate is shown.
    pub fn behind(mut self, camera: &Camera, (width, height): (u32, u32)) -> RenderScene<'a> {
        let scene = self.surfaces().scene;
        if let Some(SceneBackground::Backplate(plate)) = scene.background {
            let size = [width, height].map(f64::from);
            let texture = scene.textures.get(plate.texture as usize);
            self.backplate = Some(PlacedBackplate {
                plate,
                picture: texture.and_then(|t| t.image.as_ref()),
                lens: Lens::new(camera, size[0] / size[1]),
                size,
            });
        }
        self
    }

    /// Radiance that a ray finds where it leaves the scene. Surfaces receive the light of the
    /// surroundings, and only the camera sees the background, straight and in mirrors: `is_sharp`.
    /// `density` as for [`emitted`](RenderScene::emitted).
    pub fn beyond(&self, ray: &KernelRay, is_sharp: bool, density: f64) -> Rgb {
        let lights = self.gatherer.lights();
        if let (true, Some(SceneBackground::Color(color))) = (is_sharp, self.background) {
            return color;
        }
        if let (true, Some(plate)) = (is_sharp, &self.backplate) {
            let direction = self.tracer().world_ray(ray).direction;
            if let Some(seen) = plate.seen(direction) {
                return seen;
            }
        }
        let ambient = self.gatherer.ambient();
        let outside = lights.outside();
        if outside.is_empty() && (self.background.is_none() || !is_sharp) {
            return ambient;
        }
        let direction = self.tracer().world_ray(ray).direction.normalize_or_zero();
        match self.background {
            Some(SceneBackground::Environment(background)) if is_sharp => {
                let texture = background.texture();
                let textures = &self.surfaces().scene.textures;
                let image = texture.and_then(|id| textures.get(id as usize)?.image.as_ref());
                background.seen(direction, image)
            }
            _ if is_sharp => ambient + outside.seen(direction),
            _ if density > 0.0 => {
                let weight = mis_weight(density, outside.pdf(direction));
                ambient + outside.radiance(direction) * weight
            }
            _ => ambient + outside.environment(direction),
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
        let smooth = self.shading_normal(hit, at.facing, at.direction);
        SurfaceInteraction {
            shading_normal: self.tilted(hit, &at, smooth).unwrap_or(smooth),
            ..at
        }
    }

    /// The normal that a relief tilts, where there is one.
    fn tilted(&self, hit: &KernelHit, at: &SurfaceInteraction, smooth: DVec3) -> Option<DVec3> {
        let surfaces = self.surfaces();
        let material = surfaces.material(hit.item);
        let relief = material.relief.as_ref()?;
        let place = (surfaces.picture_place(hit)?, surfaces.picture_axes(hit)?);
        let normals = (smooth, at.facing);
        let mirrors = material.dielectric.is_some() || !material.mirror.is_black();
        Some((self.maps).tilted(relief, place, normals, (at.direction, mirrors)))
    }

    /// Whether a relief tilts the normal at a hit of which no irradiance is known: a lightmap has that of the
    /// relief, as far as its baker knew it.
    pub fn has_relief(&self, hit: &KernelHit) -> bool {
        let surfaces = self.surfaces();
        surfaces.material(hit.item).relief.is_some()
            && surfaces.picture_place(hit).is_some()
            && !self.interpolator.is_baked(hit)
    }

    /// Diffuse reflectance at a hit, with what vertex colours and all pictures say of it.
    pub fn reflectance(&self, hit: &KernelHit, material: &Material) -> Rgb {
        match self.finish(hit, material) {
            Some((finish, _)) => self.maps.diffuse(&finish),
            None => self.interpolator.reflectance(hit, material),
        }
    }

    /// The finish at a hit of a material that has pictures of it.
    fn finish(&self, hit: &KernelHit, material: &Material) -> Option<(Finish, FinishLobes<'_>)> {
        material.finish.as_ref()?;
        let pattern = self.interpolator.pattern(hit, material);
        let uv = self.surfaces().picture_place(hit);
        self.maps.finish(material, uv, pattern)
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
    pub fn shading<'s>(
        &'s self,
        hit: &KernelHit,
        at: &SurfaceInteraction,
        material: &'s Material,
        parts: Parts,
    ) -> Shading<'s> {
        let point = ShadingPoint {
            frame: at.frame(self.surfaces()),
            facing: at.facing,
            origin: at.origin(self.tracer()),
            direction: at.direction,
        };
        if let Some((_, lobes)) = self.finish(hit, material) {
            return Shading::finished(&point, lobes, parts);
        }
        let brdf = material.brdf.as_deref();
        let reflectance = self.interpolator.reflectance(hit, material);
        Shading::new(&point, Colors::new(reflectance, brdf), brdf, parts)
    }

    /// Radiance that a surface reflects of one sample of the lamps, one of what is outside, and of
    /// the lights without area, for four numbers in 0..1. The sample is weighted against the surface's own, which paths
    /// take with `lobe_probability`.
    pub fn lit(
        &self,
        shading: &Shading,
        u: [f64; 4],
        lobe_probability: f64,
        shadows: &mut ShadowBatch,
    ) -> Rgb {
        let (surfaces, lights) = (self.surfaces(), self.gatherer.lights());
        shadows.clear();
        if let Some(sample) = lights.sample(surfaces, shading.origin, [u[0], u[1], u[2]]) {
            let density = lobe_probability * shading.pdf(sample.direction);
            let share = mis_weight(sample.pdf, density) / sample.pdf;
            let light = shading.eval(sample.direction) * sample.radiance * share;
            shadows.push(self.tracer(), shading.origin, sample.target, light);
        }
        let outside = lights.sample_outside(surfaces, shading.origin, [u[0], u[1], u[2]]);
        if let Some(sample) = outside {
            let density = lobe_probability * shading.pdf(sample.direction);
            let share = mis_weight(sample.pdf, density) / sample.pdf;
            let light = shading.eval(sample.direction) * sample.radiance * share;
            shadows.push(self.tracer(), shading.origin, sample.target, light);
        }
        let normal = shading.frame.z;
        for sample in lights.sample_delta(surfaces, shading.origin, normal, u[3]) {
            let cos = sample.direction.dot(normal);
            let light = shading.eval(sample.direction) * sample.irradiance / cos;
            shadows.push(self.tracer(), shading.origin, sample.target, light);
        }
        shadows.visible(self.tracer())
    }

    /// Radiance that an emitter sends back along a ray that hit it.
    ///
    /// `density` is that of the ray's direction if it was sampled where the lamps were sampled
    /// too, against which the emission is then weighted; 0 otherwise.
    pub fn emitted(&self, ray: &KernelRay, hit: &KernelHit, density: f64) -> Rgb {
        let surfaces = self.surfaces();
        if !surfaces.is_emitter(hit.item) {
            return Rgb::BLACK;
        }
        let is_front = surfaces.is_front(ray, hit);
        let emitted = surfaces.emitted(hit, is_front);
        if density == 0.0 || emitted.is_black() {
            return emitted;
        }
        let sampled = self.gatherer.lights().pdf(surfaces, ray, hit);
        emitted * mis_weight(density, sampled)
    }

    /// The transmittance of fog along a camera ray, and the radiance that it adds. Fog depends on
    /// the distance from the viewer alone: it does not hide the background, nor what is behind
    /// mirrors.
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

impl ShadowBatch {
    fn clear(&mut self) {
        self.rays.clear();
        self.light.clear();
    }

    /// Number of shadow rays.
    pub fn len(&self) -> usize {
        self.rays.len()
    }

    fn push(&mut self, tracer: &Tracer, from: DVec3, to: DVec3, light: Rgb) {
        if !light.is_black() && light.is_finite() {
            self.rays.push(shadow_ray(tracer, from, to));
            self.light.push(light);
        }
    }

    /// The sum of the contributions, of what passes all that stands between.
    fn visible(&mut self, tracer: &Tracer) -> Rgb {
        if self.rays.is_empty() {
            return Rgb::BLACK;
        }
        tracer.transmittance(&self.rays, &mut self.shares);
        let free = self.light.iter().zip(&self.shares);
        free.map(|(&light, &share)| light * share).sum()
    }
}
