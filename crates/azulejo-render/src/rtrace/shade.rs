//! Shading: RTRACE's two reflection models.

use super::light::LightIncidence;
use super::strauss::{self, StraussFactors};
use super::texture::TexturedSurface;
use super::view::Lens;
use super::world::{Intersection, Owner, World, is_above};
use super::{Model, Options, Shadows, Textures};
use azulejo_scene::math::Ray;
use azulejo_scene::rtrace::{Rtrace, RtraceSurface};
use azulejo_scene::{Rgb, Scene};
use azulejo_trace::sampling::hash;
use glam::DVec3;

/// Values of at most this count as zero.
pub(super) const NOTHING: f64 = 1e-12;

/// A scene, ready to be shaded.
pub(super) struct Shader<'a> {
    pub world: World<'a>,
    pub lens: &'a Lens,
    pub options: &'a Options,
}

/// What a ray carries along a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayState {
    /// Product of the reflectances and transmittances before it.
    pub level: Rgb,
    /// Whether it runs inside glass: one flag, however objects are nested.
    pub is_inside: bool,
    /// Surfaces before it.
    pub depth: u32,
}

impl RayState {
    /// From the eye.
    pub const START: RayState = RayState {
        level: Rgb::WHITE,
        is_inside: false,
        depth: 0,
    };

    /// After one more surface.
    pub fn next(self, level: Rgb, is_inside: bool) -> RayState {
        RayState {
            level,
            is_inside,
            depth: self.depth + 1,
        }
    }
}

/// The random numbers of one camera ray, in the order in which they are used.
#[derive(Clone, Copy, Debug)]
pub(super) struct RaySampler {
    key: u32,
    count: u32,
}

impl RaySampler {
    /// Keyed by a position in the image.
    pub fn new(x: u32, y: u32) -> RaySampler {
        RaySampler {
            key: hash(&[x, y]),
            count: 0,
        }
    }

    /// A number in 0..1.
    pub fn uniform(&mut self) -> f64 {
        self.count += 1;
        f64::from(azulejo_trace::sampling::uniform(&[self.key, self.count]))
    }

    /// A number in −½..½.
    pub fn jitter(&mut self) -> f64 {
        self.uniform() - 0.5
    }
}

/// A surface point with its textures applied, before any light is computed.
pub(super) struct ShadingPoint<'f, 'a> {
    pub found: &'f Intersection<'a>,
    pub path: RayState,
    /// Position and surface after the textures.
    pub position: DVec3,
    pub surface: RtraceSurface,
    /// Turned toward the ray, with and without the textures' bumps.
    pub normal: DVec3,
    pub smooth_normal: DVec3,
    /// The ray, and its mirror image about the smooth normal.
    pub direction: DVec3,
    pub mirrored: DVec3,
    /// The refracted ray, once it is known.
    pub refracted: Option<DVec3>,
    /// Shadowing of the incoming ray, for Strauss's model.
    pub incidence: f64,
    /// Ks; total reflection adds Kt.
    pub specular: Rgb,
}

impl<'a> Shader<'a> {
    pub fn new(
        scene: &'a Scene,
        rtrace: &'a Rtrace,
        lens: &'a Lens,
        options: &'a Options,
    ) -> Shader<'a> {
        Shader {
            world: World::new(scene, rtrace),
            lens,
            options,
        }
    }

    /// The colour along a camera ray, and the object it is from; `counts` selects the objects that
    /// may be hit.
    pub fn seen(
        &self,
        ray: &Ray,
        counts: impl Fn(Owner) -> bool,
        sampler: &mut RaySampler,
    ) -> Option<(Rgb, Owner)> {
        let hit = self.world.first(ray, counts)?;
        let color = self.shade(&hit, ray.direction, RayState::START, sampler);
        Some((color, hit.owner))
    }

    /// The colour of rays that hit nothing.
    pub fn background(&self) -> Rgb {
        self.world.rtrace().background
    }

    /// The colour seen from a surface along `direction`.
    pub fn radiance(
        &self,
        at: &ShadingPoint,
        direction: DVec3,
        path: RayState,
        sampler: &mut RaySampler,
    ) -> Rgb {
        let ray = self.world.leaving(at.found, at.position, direction);
        let skip = at.found.is_passed_by(path.is_inside);
        let own = at.found.owner;
        match self.world.first(&ray, |owner| !(skip && owner == own)) {
            Some(hit) => self.shade(&hit, direction, path, sampler),
            None => self.background(),
        }
    }

    /// The colour of a surface, faded by the length of the ray that hit it.
    fn shade(
        &self,
        found: &Intersection,
        direction: DVec3,
        path: RayState,
        sampler: &mut RaySampler,
    ) -> Rgb {
        let color = self.surface_color(found, direction, path, sampler);
        self.lens.fade(found.distance) * color
    }

    fn surface_color(
        &self,
        found: &Intersection,
        direction: DVec3,
        path: RayState,
        sampler: &mut RaySampler,
    ) -> Rgb {
        let mut at = self.prepare(found, direction, path);
        if at.surface.is_emitter {
            return -direction.dot(at.normal) * at.surface.color;
        }
        let transmitted = self.transmitted(&mut at, sampler);
        let reflected = self.reflected(&at, sampler);
        let ambient = self.ambient(&at, sampler);
        transmitted + reflected + ambient + self.lit(&at, sampler)
    }

    fn prepare<'f>(
        &self,
        found: &'f Intersection<'a>,
        direction: DVec3,
        path: RayState,
    ) -> ShadingPoint<'f, 'a> {
        let cosine = -direction.dot(found.normal);
        let smooth_normal = if cosine < 0.0 {
            -found.normal
        } else {
            found.normal
        };
        let mut textured = TexturedSurface {
            surface: found.surface,
            position: found.position,
            normal: smooth_normal,
        };
        let textures = match self.options.textures {
            Textures::None => &[][..],
            Textures::Inline => &found.material.inline_textures,
            Textures::Section => &found.material.section_textures,
        };
        textured.apply(textures, &self.world.rtrace().surfaces);
        ShadingPoint {
            found,
            path,
            position: textured.position,
            surface: textured.surface,
            normal: textured.normal,
            smooth_normal,
            direction,
            mirrored: (direction + 2.0 * cosine * found.normal).normalize_or(smooth_normal),
            refracted: None,
            // A back side counts as grazing: the cosine is that of the object's own normal.
            incidence: strauss::incidence(cosine),
            specular: textured.surface.specular,
        }
    }

    /// The continuation behind a surface that passes on `share` of the light, if it is worth
    /// following.
    fn onward(&self, path: RayState, share: Rgb, is_inside: bool) -> Option<RayState> {
        let level = path.level * share;
        let continues = is_above(share, NOTHING)
            && path.depth + 1 < self.options.depth
            && is_above(level, self.options.cut);
        continues.then(|| path.next(level, is_inside))
    }

    /// Light from behind glass. At total reflection its share is added to the mirror's.
    fn transmitted(&self, at: &mut ShadingPoint, sampler: &mut RaySampler) -> Rgb {
        let kt = at.surface.transparency;
        let is_inside = at.path.is_inside;
        let Some(path) = self.onward(at.path, kt, !is_inside) else {
            return Rgb::BLACK;
        };
        let ior = at.found.material.ior;
        let ratio = if is_inside { ior } else { 1.0 / ior };
        at.refracted = refract(at.direction, at.normal, ratio);
        let Some(refracted) = at.refracted else {
            at.specular += kt;
            return Rgb::BLACK;
        };
        let share = match self.options.model {
            Model::Phong => kt * at.surface.color,
            Model::Strauss => at.transmittance(refracted),
        };
        share * self.radiance(at, refracted, path, sampler)
    }

    fn reflected(&self, at: &ShadingPoint, sampler: &mut RaySampler) -> Rgb {
        let Some(path) = self.onward(at.path, at.specular, at.path.is_inside) else {
            return Rgb::BLACK;
        };
        let share = match self.options.model {
            Model::Phong => at.phong_mirror(),
            Model::Strauss => at.strauss_mirror(at.normal.dot(at.mirrored)),
        };
        share * self.radiance(at, at.mirrored, path, sampler)
    }

    /// All lights.
    fn lit(&self, at: &ShadingPoint, sampler: &mut RaySampler) -> Rgb {
        let lights = &self.world.rtrace().lights;
        let lit = lights.iter().map(|light| {
            let lit = self.light(at, light);
            if lit.diffuse < NOTHING && lit.specular < NOTHING {
                return Rgb::BLACK;
            }
            let share = at.response(&lit, self.options.model);
            share * self.brightness(at, light, &lit, sampler)
        });
        lit.sum()
    }

    /// Whether lights behind the glass illuminate it.
    pub fn transmits_light(&self, at: &ShadingPoint) -> bool {
        at.refracted.is_some() && self.options.shadows == Shadows::Transmitted
    }
}

impl ShadingPoint<'_, '_> {
    /// D: what is reflected diffusely.
    pub fn diffuse(&self) -> Rgb {
        self.surface.diffuse * self.surface.color
    }

    /// S of Phong's model: metal mirrors white, plastic its own colour.
    pub fn phong_mirror(&self) -> Rgb {
        let s = &self.surface;
        self.specular * (s.color * (Rgb::WHITE - s.metal) + s.metal)
    }

    /// S of Strauss's model for light that leaves at an angle.
    pub fn strauss_mirror(&self, cosine: f64) -> Rgb {
        let factors = StraussFactors::new(cosine, self.incidence);
        factors.mirror(self.specular) * factors.tint(&self.surface)
    }

    /// T of Strauss's model: only metal colours it, and it is less around the straight direction.
    fn transmittance(&self, refracted: DVec3) -> Rgb {
        let factors = StraussFactors::new(-self.normal.dot(refracted), self.incidence);
        let straight = lobe(self.direction.dot(refracted), self.surface.phong);
        let mirror = factors.mirror(self.specular);
        let share = |k: usize| {
            let left = (1.0 - straight * mirror[k]) / (1.0 + NOTHING - self.specular[k]);
            (self.surface.transparency[k] * left).min(1.0)
        };
        Rgb::new(share(0), share(1), share(2)) * factors.tint(&self.surface)
    }

    /// The factor on a light's brightness.
    fn response(&self, lit: &LightIncidence, model: Model) -> Rgb {
        let df = self.surface.diffuse_factor;
        let diffuse = lit.diffuse * self.diffuse() * df;
        match model {
            // RTRACE applies the factor twice here.
            Model::Phong => diffuse * df + lit.specular * self.phong_mirror(),
            Model::Strauss => diffuse + lit.specular * self.strauss_mirror(lit.diffuse),
        }
    }
}

/// Phong's lobe; nothing on its far side.
pub(super) fn lobe(cosine: f64, exponent: f64) -> f64 {
    if cosine > NOTHING {
        cosine.powf(exponent)
    } else {
        0.0
    }
}

/// Snell's law for a unit normal against the ray; `None` where all is reflected, or the surface
/// is grazed.
fn refract(direction: DVec3, normal: DVec3, ratio: f64) -> Option<DVec3> {
    let cosine = -direction.dot(normal);
    let rest = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if cosine.abs() < NOTHING || rest < NOTHING {
        return None;
    }
    let refracted = ratio * direction + (ratio * cosine - rest.sqrt()) * normal;
    refracted.try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refraction_bends_by_the_ratio_or_reflects_all() {
        let slant = DVec3::new(0.6, -0.8, 0.0);
        let into = refract(slant, DVec3::Y, 1.0 / 1.5).unwrap();
        assert!(
            (into.x - 0.4).abs() < 1e-12 && into.y < 0.0 && (into.length() - 1.0).abs() < 1e-12
        );
        assert_eq!(refract(DVec3::new(0.8, -0.6, 0.0), DVec3::Y, 1.5), None);
        assert!((refract(slant, DVec3::Y, 1.0).unwrap() - slant).length() < 1e-12);
    }
}
