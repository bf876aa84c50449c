//! What a ray sees: RTRACE's two shading models.

use super::light::Lit;
use super::strauss::{self, Glance};
use super::texture::Painted;
use super::view::Lens;
use super::world::{Found, Owner, World, is_above};
use super::{Model, Options, Shadows, Textures};
use azulejo_scene::math::Ray;
use azulejo_scene::rtrace::{Rtrace, RtraceSurface};
use azulejo_scene::{Rgb, Scene};
use azulejo_trace::sampling::hash;
use glam::DVec3;

/// What is not more than this is nothing.
pub(super) const NOTHING: f64 = 1e-12;

/// A scene, ready to be shaded.
pub(super) struct Shader<'a> {
    pub world: World<'a>,
    pub lens: &'a Lens,
    pub options: &'a Options,
}

/// A ray on its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// Product of the mirrors and glasses before it.
    pub level: Rgb,
    /// Whether it runs in glass: one flag, whatever is nested.
    pub is_inside: bool,
    /// Surfaces before it.
    pub depth: u32,
}

impl Path {
    /// From the eye.
    pub const START: Path = Path {
        level: Rgb::WHITE,
        is_inside: false,
        depth: 0,
    };

    /// After one more surface.
    pub fn next(self, level: Rgb, is_inside: bool) -> Path {
        Path {
            level,
            is_inside,
            depth: self.depth + 1,
        }
    }
}

/// The random numbers of one ray from the eye, in the order they are asked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draws {
    key: u32,
    count: u32,
}

impl Draws {
    /// Keyed by a place in the picture.
    pub fn new(x: u32, y: u32) -> Draws {
        Draws {
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

/// A surface under a ray, with what is known before any light is followed.
pub(super) struct Shaded<'f, 'a> {
    pub found: &'f Found<'a>,
    pub path: Path,
    /// Where it is, and how its textures left it.
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

    /// What a ray from the eye sees, and of which object; `counts` says which may be met.
    pub fn seen(
        &self,
        ray: &Ray,
        counts: impl Fn(Owner) -> bool,
        draws: &mut Draws,
    ) -> Option<(Rgb, Owner)> {
        let found = self.world.first(ray, counts)?;
        let color = self.shade(&found, ray.direction, Path::START, draws);
        Some((color, found.owner))
    }

    /// What RTRACE shows where nothing is met.
    pub fn background(&self) -> Rgb {
        self.world.rtrace().background
    }

    /// What is seen from a surface along `direction`.
    pub fn radiance(&self, at: &Shaded, direction: DVec3, path: Path, draws: &mut Draws) -> Rgb {
        let ray = self.world.leaving(at.found, at.position, direction);
        let skip = at.found.is_passed_by(path.is_inside);
        let own = at.found.owner;
        match self.world.first(&ray, |owner| !(skip && owner == own)) {
            Some(found) => self.shade(&found, direction, path, draws),
            None => self.background(),
        }
    }

    /// The colour of a surface, faded by the length of the ray that found it.
    fn shade(&self, found: &Found, direction: DVec3, path: Path, draws: &mut Draws) -> Rgb {
        let color = self.surface_color(found, direction, path, draws);
        self.lens.fade(found.distance) * color
    }

    fn surface_color(&self, found: &Found, direction: DVec3, path: Path, draws: &mut Draws) -> Rgb {
        let mut at = self.prepare(found, direction, path);
        if at.surface.is_emitter {
            return -direction.dot(at.normal) * at.surface.color;
        }
        let transmitted = self.transmitted(&mut at, draws);
        let reflected = self.reflected(&at, draws);
        let ambient = self.ambient(&at, draws);
        transmitted + reflected + ambient + self.lit(&at, draws)
    }

    fn prepare<'f>(&self, found: &'f Found<'a>, direction: DVec3, path: Path) -> Shaded<'f, 'a> {
        let cosine = -direction.dot(found.normal);
        let smooth_normal = if cosine < 0.0 {
            -found.normal
        } else {
            found.normal
        };
        let mut painted = Painted {
            surface: found.surface,
            position: found.position,
            normal: smooth_normal,
        };
        let textures = match self.options.textures {
            Textures::None => &[][..],
            Textures::Inline => &found.material.inline_textures,
            Textures::Section => &found.material.section_textures,
        };
        painted.apply(textures, &self.world.rtrace().surfaces);
        Shaded {
            found,
            path,
            position: painted.position,
            surface: painted.surface,
            normal: painted.normal,
            smooth_normal,
            direction,
            mirrored: (direction + 2.0 * cosine * found.normal).normalize_or(smooth_normal),
            refracted: None,
            // A back side counts as grazed: the cosine is that of the normal as the object has it.
            incidence: strauss::incidence(cosine),
            specular: painted.surface.specular,
        }
    }

    /// The path behind a surface that keeps `share` of the light, if it is worth following.
    fn onward(&self, path: Path, share: Rgb, is_inside: bool) -> Option<Path> {
        let level = path.level * share;
        let goes_on = is_above(share, NOTHING)
            && path.depth + 1 < self.options.depth
            && is_above(level, self.options.cut);
        goes_on.then(|| path.next(level, is_inside))
    }

    /// Light from behind glass. Where all of it is reflected, the mirror takes it over.
    fn transmitted(&self, at: &mut Shaded, draws: &mut Draws) -> Rgb {
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
        share * self.radiance(at, refracted, path, draws)
    }

    fn reflected(&self, at: &Shaded, draws: &mut Draws) -> Rgb {
        let Some(path) = self.onward(at.path, at.specular, at.path.is_inside) else {
            return Rgb::BLACK;
        };
        let share = match self.options.model {
            Model::Phong => at.phong_mirror(),
            Model::Strauss => at.strauss_mirror(at.normal.dot(at.mirrored)),
        };
        share * self.radiance(at, at.mirrored, path, draws)
    }

    /// All lights.
    fn lit(&self, at: &Shaded, draws: &mut Draws) -> Rgb {
        let lights = &self.world.rtrace().lights;
        let lit = lights.iter().map(|light| {
            let lit = self.light(at, light);
            if lit.diffuse < NOTHING && lit.specular < NOTHING {
                return Rgb::BLACK;
            }
            let share = at.response(&lit, self.options.model);
            share * self.brightness(at, light, &lit, draws)
        });
        lit.sum()
    }

    /// Whether lights behind glass light it.
    pub fn transmits_light(&self, at: &Shaded) -> bool {
        at.refracted.is_some() && self.options.shadows == Shadows::Transmitted
    }
}

impl Shaded<'_, '_> {
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
        let glance = Glance::new(cosine, self.incidence);
        glance.mirror(self.specular) * glance.tint(&self.surface)
    }

    /// T of Strauss's model: no colour but metal's, less around the straight line.
    fn transmittance(&self, refracted: DVec3) -> Rgb {
        let glance = Glance::new(-self.normal.dot(refracted), self.incidence);
        let straight = lobe(self.direction.dot(refracted), self.surface.phong);
        let mirror = glance.mirror(self.specular);
        let share = |k: usize| {
            let left = (1.0 - straight * mirror[k]) / (1.0 + NOTHING - self.specular[k]);
            (self.surface.transparency[k] * left).min(1.0)
        };
        Rgb::new(share(0), share(1), share(2)) * glance.tint(&self.surface)
    }

    /// What becomes of a light's brightness.
    fn response(&self, lit: &Lit, model: Model) -> Rgb {
        let df = self.surface.diffuse_factor;
        let diffuse = lit.diffuse * self.diffuse() * df;
        match model {
            // The factor enters twice, there.
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
