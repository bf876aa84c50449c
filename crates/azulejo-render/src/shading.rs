//! What a surface does with light at one place: its reflection model, in the place's frame, with
//! the colour that textures give it there.

use azulejo_scene::brdf::{Brdf, Lobes};
use azulejo_scene::math::Frame;
use azulejo_scene::{Material, Rgb};
use azulejo_trace::interaction::Continuation;
use azulejo_trace::sampling::cosine_hemisphere;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Which parts of a model are asked for; what is left out is found in another way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parts {
    /// Glossy and nearly mirrored light; the rest stands in the irradiance.
    Lobes,
    /// And matt lobes, whose look depends on where they are seen from.
    MattAndLobes,
    /// All but what is mirrored exactly.
    All,
}

/// A surface at one place, seen from one direction.
pub(crate) struct Shading<'a> {
    /// The place's frame; its normal is the smooth one, on the side that is seen.
    pub frame: Frame,
    /// Unit geometric normal of the side that is seen.
    pub facing: DVec3,
    /// Where rays start that leave it on that side.
    pub origin: DVec3,
    /// Toward where it is seen from, in the frame.
    pub wo: DVec3,
    /// Diffuse reflectance.
    lambert: Rgb,
    /// By what textures and colours scale the matt lobes.
    pattern: Rgb,
    /// Matt, glossy and narrow lobes, as far as they are asked for.
    lobes: [Option<&'a Lobes>; 3],
}

/// The parts of a surface's reflectance that do not depend on direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Colors {
    /// Of the part that is alike in all directions.
    pub lambert: Rgb,
    /// By what textures, colours and the file scale matt lobes.
    pub pattern: Rgb,
}

impl Colors {
    /// Divides the `reflectance` that was found at a place, of which the model's own is the mean.
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

/// Share of the light at that cosine that a material mirrors exactly: its model's, scaled as the
/// file scales its mean.
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
    /// `at` is the frame, the geometric normal and where rays start; `direction` runs against it.
    pub fn new(
        (frame, facing, origin): (Frame, DVec3, DVec3),
        direction: DVec3,
        colors: Colors,
        brdf: Option<&'a Brdf>,
        parts: Parts,
    ) -> Shading<'a> {
        let some = |lobes: &'a Lobes| (!lobes.is_empty()).then_some(lobes);
        let matt = brdf.filter(|_| parts != Parts::Lobes).map(Brdf::matt);
        let rest = [brdf.map(Brdf::glossy), brdf.map(Brdf::narrow)];
        Shading {
            frame,
            facing,
            origin,
            wo: frame.to_local(-direction),
            lambert: if parts == Parts::All {
                colors.lambert
            } else {
                Rgb::BLACK
            },
            pattern: colors.pattern,
            lobes: [matt, rest[0], rest[1]].map(|lobes| lobes.and_then(some)),
        }
    }

    /// Whether nothing is reflected.
    pub fn is_black(&self) -> bool {
        self.lambert.is_black() && self.lobes.iter().all(Option::is_none)
    }

    /// About how much is reflected, mean over the channels, in all.
    pub fn likely(&self) -> f64 {
        self.shares().iter().sum()
    }

    /// About how much the diffuse part and each kind of lobes reflect.
    fn shares(&self) -> [f64; 4] {
        let of = |k: usize| self.lobes[k].map_or(0.0, |l| l.likely(self.wo));
        let matt = of(0) * self.pattern.mean();
        [self.lambert.mean(), matt, of(1), of(2)]
    }

    fn pattern_of(&self, kind: usize) -> Rgb {
        if kind == 0 { self.pattern } else { Rgb::WHITE }
    }

    /// The BRDF times the cosine toward a world direction; black below either horizon.
    pub fn eval(&self, direction: DVec3) -> Rgb {
        let wi = self.frame.to_local(direction);
        if !(wi.z > 0.0 && self.wo.z > 0.0 && direction.dot(self.facing) > 0.0) {
            return Rgb::BLACK;
        }
        self.brdf(wi) * wi.z
    }

    fn brdf(&self, wi: DVec3) -> Rgb {
        let kinds = self.lobes.iter().enumerate();
        let lobes =
            kinds.filter_map(|(k, l)| Some(l.as_ref()?.eval(self.wo, wi) * self.pattern_of(k)));
        self.lambert * FRAC_1_PI + lobes.sum()
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
        let of = |k: usize| self.lobes[k].map_or(0.0, |l| shares[k + 1] * l.pdf(self.wo, wi));
        (shares[0] * wi.z * FRAC_1_PI + of(0) + of(1) + of(2)) / sum
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
            k => self.lobes[k - 1]?.direction(self.wo, [u[1], u[2], u[3]]),
        }?;
        let direction = self.frame.to_world(wi);
        let pdf = self.density(wi);
        let weight = self.eval(direction) / pdf;
        let is_useful = pdf > 0.0 && weight.is_finite() && !weight.is_black();
        is_useful.then_some(Scattered(Continuation {
            direction,
            weight,
            density: pdf,
        }))
    }
}
