//! What light does at a surface that a path hits: where the path continues, and with what weight.
//!
//! Both passes and the reference image use this one account of mirrors, dielectrics and lobes.
//! They differ only in where their random numbers come from, in how often they split a path, and
//! in what they do with a path that carries little.

use crate::{Hit, KernelHit, KernelRay, Surfaces, Tracer};
use azulejo_scene::math::{Frame, Ray, reflect};
use azulejo_scene::{Material, MaterialId, Rgb, fresnel};
use glam::DVec3;

/// Dielectrics split a path in two at its first interfaces, where that removes most of the noise;
/// later interfaces choose one branch, or the number of paths would double each time.
pub const SPLIT_DEPTH: u32 = 2;

/// Shadow rays end this share of their length before the light, so that they do not hit it.
const SHADOW_END: f64 = 1.0 - 1e-4;

/// The ray that tests whether anything stands between two points.
pub fn shadow_ray(tracer: &Tracer, from: DVec3, to: DVec3) -> KernelRay {
    let ray = Ray {
        t_max: SHADOW_END,
        ..Ray::between(from, to)
    };
    tracer.kernel_ray(&ray)
}

/// The point where a ray hits a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInteraction {
    /// The surface point.
    pub hit: Hit,
    /// Unit direction of the ray.
    pub direction: DVec3,
    /// Unit geometric normal of the side that the ray arrives at.
    pub facing: DVec3,
    /// Unit normal for mirrors, dielectrics and reflection models: `facing` unless the caller
    /// sets an interpolated one.
    pub shading_normal: DVec3,
    /// The same ray from behind the surface on.
    pub straight_on: KernelRay,
    /// The film of air that it is, if it is one.
    pub film: Option<AirFilm>,
}

/// A film of air between glass and another surface, as one ray hits it.
#[derive(Clone, Copy, Debug)]
pub struct AirFilm {
    pub(crate) glass: MaterialId,
    /// The surface behind it.
    pub(crate) behind: KernelHit,
}

impl SurfaceInteraction {
    /// The interaction at the end of a ray, with the geometric normal for shading.
    pub fn new(tracer: &Tracer, ray: &KernelRay, hit: &KernelHit) -> SurfaceInteraction {
        let straight_on = ray.behind(hit);
        let ray = tracer.world_ray(ray);
        let hit = tracer.resolve(&ray, hit);
        let facing = if hit.entering {
            hit.normal
        } else {
            -hit.normal
        };
        SurfaceInteraction {
            hit,
            direction: ray.direction.normalize(),
            facing,
            shading_normal: facing,
            straight_on,
            film: None,
        }
    }

    /// The frame in which reflection models are evaluated.
    pub fn frame(&self, surfaces: &Surfaces) -> Frame {
        surfaces.frame(&self.hit, self.shading_normal)
    }

    /// Where rays start that leave on the side that the ray arrived at.
    pub fn origin(&self, tracer: &Tracer) -> DVec3 {
        tracer.leaving(self.hit.position, self.facing)
    }

    /// The exact mirror reflection, for a surface that mirrors `share`.
    pub fn mirrored(&self, share: Rgb) -> Continuation {
        Continuation::specular(reflect(self.direction, self.shading_normal), share)
    }

    /// What the surface does with the ray if its material is a dielectric, or that of the film.
    pub fn interface(&self, material: &Material) -> Option<DielectricInterface> {
        let glass = material.dielectric.as_ref()?;
        let eta = if self.hit.entering || glass.thin {
            glass.ior
        } else {
            1.0 / glass.ior
        };
        let (direction, normal) = (self.direction, self.shading_normal);
        let (split, compression) = if glass.thin {
            (fresnel::pane(direction, normal, eta), 1.0)
        } else {
            (fresnel::split(direction, normal, eta), eta * eta)
        };
        Some(DielectricInterface {
            reflectance: split.reflectance,
            reflected: split.reflected,
            refracted: split.refracted,
            mirror: material.mirror,
            transmittance: glass.transmittance,
            compression,
            power: if self.hit.entering {
                1.0
            } else {
                1.0 / compression
            },
            is_straight: glass.is_straight(),
        })
    }
}

/// A direction in which a path continues from a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Continuation {
    /// Unit, away from the surface.
    pub direction: DVec3,
    /// By what the weight of the path is multiplied: BSDF times cosine over density, or the
    /// share that a mirror or a dielectric sends that way.
    pub weight: Rgb,
    /// Density with which the direction was sampled, 1/sr; 0 if it is mirrored or refracted.
    pub density: f64,
    /// Whether the path passes a pane, straight on. Shadow rays pass panes too
    /// ([`Tracer::transmittance`]), so the light behind is still that for which lights were sampled at
    /// the surface before: it keeps the density of the path so far.
    pub is_straight: bool,
}

impl Continuation {
    /// A mirrored or refracted direction.
    pub fn specular(direction: DVec3, weight: Rgb) -> Continuation {
        Continuation {
            direction,
            weight,
            density: 0.0,
            is_straight: false,
        }
    }

    /// The density of the direction after the surface, of a path that arrives with one.
    pub fn density_after(&self, before: f64) -> f64 {
        if self.is_straight {
            before
        } else {
            self.density
        }
    }

    /// The same, taken with that probability.
    pub fn over(self, probability: f64) -> Continuation {
        Continuation {
            weight: self.weight / probability,
            ..self
        }
    }
}

/// The surface of a transparent body, or a thin pane, as one ray hits it.
#[derive(Clone, Copy, Debug)]
pub struct DielectricInterface {
    /// Fresnel reflectance.
    reflectance: f64,
    /// Mirrored direction.
    reflected: DVec3,
    /// Direction of what passes; `None` at total reflection.
    refracted: Option<DVec3>,
    /// Scales what is mirrored.
    mirror: Rgb,
    /// Scales what passes.
    transmittance: Rgb,
    /// The square of the ratio of indices: refraction conserves L/n², so radiance that arrives
    /// from the far side is divided by it. 1 for a pane, which has the same medium on both sides.
    compression: f64,
    /// Power per weight on the side that the ray comes from: weights are of radiance, and paths set out in air.
    power: f64,
    is_straight: bool,
}

impl DielectricInterface {
    /// What is mirrored.
    pub fn reflected(&self) -> Continuation {
        Continuation::specular(self.reflected, self.mirror * self.reflectance)
    }

    /// What passes; `None` at total reflection.
    pub fn refracted(&self) -> Option<Continuation> {
        let passed = (1.0 - self.reflectance) / self.compression;
        let share = self.transmittance * passed;
        Some(Continuation {
            is_straight: self.is_straight,
            ..Continuation::specular(self.refracted?, share)
        })
    }

    /// Where a path continues that has passed `depth` interfaces: both ways if that is less than
    /// `split_depth`, else one of the two, reflected with probability R for a number in 0..1.
    pub fn continuations(
        &self,
        depth: u32,
        split_depth: u32,
        chance: impl FnOnce() -> f64,
    ) -> [Option<Continuation>; 2] {
        if depth < split_depth {
            [Some(self.reflected()), self.refracted()]
        } else {
            [Some(self.chosen(chance())), None]
        }
    }

    /// One of the two directions, by a number in 0..1.
    pub fn chosen(&self, chance: f64) -> Continuation {
        match self.refracted() {
            Some(refracted) if chance >= self.reflectance => refracted.over(1.0 - self.reflectance),
            _ => Continuation::specular(self.reflected, self.mirror),
        }
    }

    /// The power that the interface neither mirrors nor passes, by the weight of the path: more than 1 inside glass,
    /// where less radiance is as much power.
    pub fn absorbed(&self) -> Rgb {
        let passed = self.transmittance * (1.0 - self.reflectance);
        (Rgb::WHITE - self.reflected().weight - passed) * self.power
    }
}

/// How a path continues from a surface that mirrors exactly, by lobes, or both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Branching {
    /// Nothing is mirrored exactly.
    Lobes,
    /// The path is split in two.
    Both,
    /// One of the two is chosen.
    One {
        /// Probability of the mirrored direction.
        mirror: f64,
    },
}

impl Branching {
    /// For a surface that mirrors `mirrored` and whose lobes reflect about `lobes`, both means
    /// over the channels; `splits` if both parts are to be followed.
    pub fn new(splits: bool, mirrored: f64, lobes: impl FnOnce() -> f64) -> Branching {
        if mirrored == 0.0 {
            Branching::Lobes
        } else if splits {
            Branching::Both
        } else {
            let mirror = mirrored / (mirrored + lobes());
            Branching::One { mirror }
        }
    }

    /// Probability that a path follows the lobes.
    pub fn lobe_probability(self) -> f64 {
        match self {
            Branching::Lobes | Branching::Both => 1.0,
            Branching::One { mirror } => 1.0 - mirror,
        }
    }

    /// The probabilities of the mirrored part and of the lobes, each `None` if it is not
    /// followed; the choice takes a number in 0..1.
    pub fn choose(self, chance: impl FnOnce() -> f64) -> (Option<f64>, Option<f64>) {
        match self {
            Branching::Lobes => (None, Some(1.0)),
            Branching::Both => (Some(1.0), Some(1.0)),
            Branching::One { mirror } if chance() < mirror => (Some(mirror), None),
            Branching::One { mirror } => (None, Some(1.0 - mirror)),
        }
    }
}

/// Russian roulette: a path that carries little survives by chance, with more weight, so that
/// paths end and the mean stays right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    /// Weight below which a path may end.
    pub below: f64,
    /// Highest probability of survival, in 0..=1.
    pub most: f64,
}

impl Roulette {
    /// Share of the weight of a path at its start below which both passes play roulette.
    pub const SHARE: f64 = 0.01;

    /// Spares paths that carry at least `below`.
    pub const fn below(below: f64) -> Roulette {
        Roulette { below, most: 1.0 }
    }

    /// The probability with which a path of that weight survived, by which the survivor's weight
    /// is divided; `None` if it ended. `chance` in 0..1 is called only where it matters.
    pub fn survival(&self, weight: f64, chance: impl FnOnce() -> f64) -> Option<f64> {
        let odds = (weight / self.below).min(self.most);
        if odds >= 1.0 {
            return Some(1.0);
        }
        (odds > 0.0 && chance() < odds).then_some(odds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roulette_spares_what_is_heavy_and_keeps_the_mean() {
        let roulette = Roulette::below(0.01);
        assert_eq!(roulette.survival(0.01, || unreachable!()), Some(1.0));
        assert_eq!(roulette.survival(0.0, || 0.0), None);
        let draws = (0..1000).map(|k| (f64::from(k) + 0.5) / 1000.0);
        let survivors = draws.filter_map(|u| roulette.survival(0.0025, || u));
        let mean: f64 = survivors.map(|odds| 0.0025 / odds).sum::<f64>() / 1000.0;
        assert!((mean - 0.0025).abs() < 1e-12);
    }

    #[test]
    fn a_choice_between_mirror_and_lobes_has_its_probabilities() {
        assert_eq!(Branching::new(true, 0.0, || 1.0), Branching::Lobes);
        assert_eq!(Branching::new(true, 0.5, || 1.0), Branching::Both);
        let one = Branching::new(false, 0.2, || 0.6);
        assert!((one.lobe_probability() - 0.75).abs() < 1e-12);
        assert_eq!(
            one.choose(|| 0.1),
            (Some(1.0 - one.lobe_probability()), None)
        );
        assert_eq!(one.choose(|| 0.9), (None, Some(one.lobe_probability())));
    }
}
