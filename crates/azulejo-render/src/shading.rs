//! The reflection of a surface at one point: its model in the point's frame, with the colour of its
//! textures there.

use crate::surface_maps::FinishLobes;
use azulejo_scene::brdf::{Brdf, Lobes};
use azulejo_scene::math::Frame;
use azulejo_scene::{Material, Rgb};
use azulejo_trace::interaction::Continuation;
use azulejo_trace::sampling::cosine_hemisphere;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Which parts of a model are evaluated; the rest is accounted for elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parts {
    /// Glossy lobes and narrow ones; the irradiance accounts for the rest.
    Lobes,
    /// Matt lobes too, whose reflection depends on the viewing direction.
    MattAndLobes,
    /// Everything but exact mirror reflection.
    All,
}

/// A surface at one point, seen from one direction.
pub(crate) struct Shading<'a> {
    /// The frame of the point; its `z` is the shading normal, on the side that is seen.
    pub frame: Frame,
    /// Unit geometric normal of the side that is seen.
    pub facing: DVec3,
    /// Where rays start that leave the surface on that side.
    pub origin: DVec3,
    /// Unit, toward the viewer, in the frame.
    pub wo: DVec3,
    /// Diffuse reflectance.
    lambert: Rgb,
    /// Lobes and their factors, as far as they are evaluated: matt, glossy and narrow ones, or those of
    /// a finish, the matt ones first.
    lobes: [Option<(&'a Lobes, Rgb)>; 5],
    /// Reflectance that the caller reads from stored irradiance, and which the matt lobes lack.
    stored: Rgb,
}

/// Where a surface is seen, and from which direction.
pub(crate) struct ShadingPoint {
    /// Its frame; `z` is the shading normal, on the side that is seen.
    pub frame: Frame,
    /// Unit geometric normal of the side that is seen.
    pub facing: DVec3,
    /// Where rays start that leave the surface on that side.
    pub origin: DVec3,
    /// Unit direction of the ray that hit the surface.
    pub direction: DVec3,
}

/// How often the matt lobes are sampled, as a share of their albedo, where only their difference
/// from a diffuse surface is left to paths.
const RESIDUAL_SHARE: f64 = 0.1;

/// The parts of a surface's reflectance that do not depend on direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Colors {
    /// Reflectance of the ideally diffuse part.
    pub lambert: Rgb,
    /// Factor of textures, colours and the file on the matt lobes.
    pub pattern: Rgb,
}

impl Colors {
    /// Divides the `reflectance` at a point between the two; the model's own is its mean.
    pub fn new(reflectance: Rgb, brdf: Option<&Brdf>) -> Colors {
        let Some(brdf) = brdf else {
            return Colors {
                lambert: reflectance,
                pattern: Rgb::WHITE,
            };
        };
        let mean = brdf.mean_diffuse();
        let mut colors = Colors {
            lambert: reflectance,
            pattern: Rgb::WHITE,
        };
        for k in 0..3 {
            if mean[k] > 0.0 {
                colors.pattern[k] = reflectance[k] / mean[k];
                colors.lambert[k] = brdf.diffuse()[k] * colors.pattern[k];
            }
        }
        colors
    }
}

/// Exact mirror reflectance of a material at that cosine: its model's, scaled as the file scales
/// the mean.
pub(crate) fn mirrored(material: &Material, cos: f64) -> Rgb {
    let Some(brdf) = material.brdf.as_deref() else {
        return material.mirror;
    };
    let (mean, exact) = (brdf.mean_mirror(), brdf.mirror(cos));
    let mut share = material.mirror;
    for k in 0..3 {
        if mean[k] > 0.0 {
            share[k] *= exact[k] / mean[k];
        }
    }
    share
}

/// A direction sampled from a surface's diffuse part and lobes.
pub(crate) struct Scattered(Continuation);

impl Scattered {
    /// The continuation of a path that follows the lobes with that probability: its density is
    /// what next event estimation weights itself against.
    pub fn chosen(self, probability: f64) -> Continuation {
        Continuation {
            density: self.0.density * probability,
            ..self.0.over(probability)
        }
    }
}

impl<'a> Shading<'a> {
    /// Some parts of a model.
    pub fn new(
        point: &ShadingPoint,
        colors: Colors,
        brdf: Option<&'a Brdf>,
        parts: Parts,
    ) -> Shading<'a> {
        let some = |lobes: &'a Lobes| (!lobes.is_empty()).then_some(lobes);
        let of = |lobes: Option<&'a Lobes>, factor| Some((lobes.and_then(some)?, factor));
        let matt = brdf.filter(|_| parts != Parts::Lobes).map(Brdf::matt);
        Shading {
            lambert: if parts == Parts::All {
                colors.lambert
            } else {
                Rgb::BLACK
            },
            lobes: [
                of(matt, colors.pattern),
                of(brdf.map(Brdf::glossy), Rgb::WHITE),
                of(brdf.map(Brdf::narrow), Rgb::WHITE),
                None,
                None,
            ],
            ..Shading::at(point)
        }
    }

    /// The diffuse reflectance nearest to the matt lobes as they are seen: with it the irradiance
    /// that is known is a control variate for them.
    pub fn matt_albedo(&self) -> Rgb {
        self.lobes[0].map_or(Rgb::BLACK, |(matt, factor)| {
            let mean = matt.mean_albedo();
            mean * factor * (matt.likely(self.wo) / mean.mean().max(f64::MIN_POSITIVE))
        })
    }

    /// Leaves the matt lobes' [`matt_albedo`](Shading::matt_albedo) to the caller: paths find what
    /// they reflect otherwise than a diffuse surface, more or less, and no longer the whole.
    pub fn without_albedo(self) -> Shading<'a> {
        Shading {
            stored: self.matt_albedo(),
            ..self
        }
    }

    /// Some parts of a surface whose finish pictures vary.
    pub fn finished(point: &ShadingPoint, lobes: FinishLobes<'a>, parts: Parts) -> Shading<'a> {
        let mut lobes =
            lobes.map(|(lobes, factor)| (!factor.is_black()).then_some((lobes, factor)));
        if parts == Parts::Lobes {
            lobes[0] = None;
        }
        Shading {
            lobes,
            ..Shading::at(point)
        }
    }

    /// A black surface.
    fn at(point: &ShadingPoint) -> Shading<'a> {
        Shading {
            frame: point.frame,
            facing: point.facing,
            origin: point.origin,
            wo: point.frame.to_local(-point.direction),
            lambert: Rgb::BLACK,
            lobes: [None; 5],
            stored: Rgb::BLACK,
        }
    }

    /// Whether nothing is reflected.
    pub fn is_black(&self) -> bool {
        self.lambert.is_black() && self.lobes.iter().all(Option::is_none)
    }

    /// Estimated total reflectance, mean over the channels.
    pub fn likely(&self) -> f64 {
        self.shares().iter().sum()
    }

    /// Estimated reflectance of the diffuse part and of each kind of lobes.
    fn shares(&self) -> [f64; 6] {
        let of = |part: Option<(&Lobes, Rgb)>| {
            part.map_or(0.0, |(lobes, factor)| lobes.likely(self.wo) * factor.mean())
        };
        let [mut matt, b, c, d, e] = self.lobes.map(of);
        if !self.stored.is_black() {
            matt *= RESIDUAL_SHARE;
        }
        [self.lambert.mean(), matt, b, c, d, e]
    }

    /// The BRDF times the cosine toward a world direction; black below either horizon. May be
    /// negative [`without_albedo`](Shading::without_albedo).
    pub fn eval(&self, direction: DVec3) -> Rgb {
        let wi = self.frame.to_local(direction);
        if !(wi.z > 0.0 && self.wo.z > 0.0 && direction.dot(self.facing) > 0.0) {
            return Rgb::BLACK;
        }
        self.brdf(wi) * wi.z
    }

    fn brdf(&self, wi: DVec3) -> Rgb {
        let lobes = self.lobes.iter().flatten();
        let lobes = lobes.map(|(lobes, factor)| lobes.eval(self.wo, wi) * *factor);
        (self.lambert - self.stored) * FRAC_1_PI + lobes.sum()
    }

    /// Density of [`sample`](Shading::sample) for a world direction, 1/sr.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        self.density(self.frame.to_local(direction))
    }

    fn density(&self, wi: DVec3) -> f64 {
        let shares = self.shares();
        let sum: f64 = shares.iter().sum();
        if !(wi.z > 0.0 && self.wo.z > 0.0 && sum > 0.0) {
            return 0.0;
        }
        let lobes = self.lobes.iter().zip(&shares[1..]);
        let density = |(part, share): (&Option<(&Lobes, Rgb)>, &f64)| match part {
            Some((lobes, _)) => share * lobes.pdf(self.wo, wi),
            None => 0.0,
        };
        (shares[0] * wi.z * FRAC_1_PI + lobes.map(density).sum::<f64>()) / sum
    }

    /// A world direction that light may come from, for four numbers in 0..1, with the weight
    /// BRDF × cosine / density.
    pub fn sample(&self, u: [f64; 4]) -> Option<Scattered> {
        let shares = self.shares();
        let mut rest = u[0] * shares.iter().sum::<f64>();
        let chosen = shares.iter().position(|share| {
            let here = rest < *share;
            rest -= share;
            here
        })?;
        let wi = match chosen {
            0 => Some(cosine_hemisphere(u[2], u[3])),
            k => self.lobes[k - 1]?.0.direction(self.wo, [u[1], u[2], u[3]]),
        }?;
        let direction = self.frame.to_world(wi);
        let pdf = self.density(wi);
        let weight = self.eval(direction) / pdf;
        let is_useful = pdf > 0.0 && weight.is_finite() && !weight.is_black();
        is_useful.then_some(Scattered(Continuation {
            direction,
            weight,
            density: pdf,
            is_straight: false,
        }))
    }
}
