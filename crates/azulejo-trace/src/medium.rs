//! The film of air between a body of glass and a surface that it touches, or that reaches into it.
//!
//! A vase stands on a table, at the same height to the last bit or a hair above or below. Whether a ray finds the glass
//! first or the table is rounding, and a ray that leaves the glass may start below the table. All surfaces but glass
//! are therefore taken to lie in air: where a path inside a body meets another surface it leaves the glass there first,
//! and where a path that starts on a surface finds itself inside a body it has entered the glass at its start. Emitted
//! and reflected light then is the same in glass and beside it, and between any two surfaces reciprocity holds, which
//! it does not between surfaces in different media. This holds for closed bodies; what lies behind a single sheet of
//! refracting glass lies in glass.

use crate::interaction::{AirFilm, Continuation, SurfaceInteraction};
use crate::{KernelHit, KernelRay, Surfaces, Tracer};
use azulejo_scene::math::Ray;
use azulejo_scene::{Material, MaterialId};
use glam::DVec3;

/// How far beyond a body's surface another one touches it, in steps of [`Tracer::leaving`], from one step before.
const TOUCHING: f64 = 3.0;

/// How far back along a ray the surface is looked for on which it starts, in the same steps: as far as it is for rays
/// that almost graze it.
const BACK: f64 = 1000.0;

/// Most surfaces in one place that are looked at.
const MOST_IN_PLACE: usize = 4;

/// In what a path travels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Medium {
    /// That of the surface from which it set out.
    #[default]
    Unknown,
    /// Air.
    Air,
    /// Glass of this material.
    Glass(MaterialId),
}

/// A stretch of a path from one surface to the next.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// The ray.
    pub ray: KernelRay,
    /// In what it travels.
    pub medium: Medium,
    /// What the ray hits, where that is known: the surface behind a film.
    pub known: Option<KernelHit>,
}

impl Leg {
    /// From a surface, or from anywhere.
    pub fn from(ray: KernelRay) -> Leg {
        Leg {
            ray,
            medium: Medium::Unknown,
            known: None,
        }
    }

    /// What it hits, if `found` is what the ray does, and whether at the front ([`Surfaces::facing`]).
    pub fn hit(&self, surfaces: &Surfaces, found: &KernelHit) -> (KernelHit, bool) {
        let hit = self.known.unwrap_or(*found);
        if !hit.is_hit() {
            return (hit, false);
        }
        surfaces.facing(&self.ray, &hit)
    }

    /// The film that the path meets before what it hits, and its glass.
    pub fn air_film<'a>(
        &self,
        surfaces: &Surfaces<'a>,
        hit: &KernelHit,
    ) -> Option<(SurfaceInteraction, &'a Material)> {
        if !surfaces.has_bodies() || !hit.is_hit() {
            return None;
        }
        let tracer = surfaces.tracer;
        let is_glass = surfaces.material(hit.item).dielectric.is_some();
        let (at, film) = match self.medium {
            // A surface inside a body, but no pane.
            Medium::Glass(glass) if !is_glass => {
                let behind = *hit;
                let at = SurfaceInteraction::new(tracer, &self.ray, hit);
                (at.through(false), AirFilm { glass, behind })
            }
            // The inside of a body, for a path that set out from a surface.
            Medium::Unknown if surfaces.is_body(hit.item) && !surfaces.is_front(&self.ray, hit) => {
                let (back, behind) = start(surfaces, &self.ray)?;
                let glass = surfaces.material_id(hit.item);
                let at = SurfaceInteraction::new(tracer, &back, &behind);
                (at.turned().through(true), AirFilm { glass, behind })
            }
            _ => return None,
        };
        let glass = &surfaces.scene.materials[film.glass as usize];
        let film = Some(film);
        Some((SurfaceInteraction { film, ..at }, glass))
    }
}

/// The surface on which a ray starts, and a ray back to it.
fn start(surfaces: &Surfaces, ray: &KernelRay) -> Option<(KernelRay, KernelHit)> {
    let tracer = surfaces.tracer;
    let forth = tracer.world_ray(ray);
    let length = BACK * step(tracer, forth.origin) / forth.direction.length();
    let back = KernelRay {
        direction: ray.direction.map(|x| -x),
        t_min: 0.0,
        t_max: length as f32,
        ..*ray
    };
    let hit = other_than_glass(surfaces, back)?;
    Some((back, hit))
}

/// The first surface along a ray that is not glass.
fn other_than_glass(surfaces: &Surfaces, mut ray: KernelRay) -> Option<KernelHit> {
    let mut hits = [KernelHit::NOTHING];
    for _ in 0..MOST_IN_PLACE {
        surfaces.tracer.closest_into(&[ray], &mut hits);
        let [hit] = hits;
        if !hit.is_hit() {
            return None;
        }
        if surfaces.material(hit.item).dielectric.is_none() {
            return Some(hit);
        }
        ray = ray.behind(&hit);
    }
    None
}

/// The length of the steps of [`Tracer::leaving`].
fn step(tracer: &Tracer, at: DVec3) -> f64 {
    tracer.leaving(at, DVec3::X).distance(at)
}

impl SurfaceInteraction {
    /// How a path continues, to either side, that came by a leg in `before`. One that passes straight keeps its origin:
    /// lights behind are sampled from there.
    pub fn leg(&self, surfaces: &Surfaces, next: &Continuation, before: Medium) -> Leg {
        let tracer = surfaces.tracer;
        if next.is_straight {
            return Leg {
                medium: before,
                ..Leg::from(self.straight_on)
            };
        }
        let away = next.direction.dot(self.facing);
        let side = self.facing * 1f64.copysign(away);
        let onward = |medium| Leg {
            medium,
            ..Leg::from(self.ray_from(tracer, side, next.direction))
        };
        let glass = match &self.film {
            Some(film) => Some(film.glass),
            None => (surfaces.is_body(self.hit.item)).then(|| surfaces.material_id(self.hit.item)),
        };
        let Some(glass) = glass else {
            let is_pane = surfaces.material(self.hit.item).dielectric.is_some();
            return onward(if is_pane { before } else { Medium::Unknown });
        };
        let is_in_air = (away > 0.0) == self.hit.entering;
        match &self.film {
            _ if !is_in_air => onward(Medium::Glass(glass)),
            // The air of a film ends at once.
            Some(film) => self.behind(tracer, next.direction, &film.behind),
            None if self.hit.entering => onward(Medium::Air),
            None => self
                .touched(surfaces, next.direction)
                .unwrap_or_else(|| onward(Medium::Air)),
        }
    }

    /// The ray that leaves the point to a side.
    fn ray_from(&self, tracer: &Tracer, side: DVec3, direction: DVec3) -> KernelRay {
        let origin = tracer.leaving(self.hit.position, side);
        tracer.kernel_ray(&Ray::new(origin, direction))
    }

    /// Through the film to the surface behind it.
    fn behind(&self, tracer: &Tracer, direction: DVec3, surface: &KernelHit) -> Leg {
        let side = self.facing * 1f64.copysign(-direction.dot(self.facing));
        let t = step(tracer, self.hit.position) / -direction.dot(side);
        Leg {
            known: Some(surface.at(t as f32)),
            medium: Medium::Air,
            ..Leg::from(self.ray_from(tracer, side, direction))
        }
    }

    /// Out of the glass to a surface that touches it.
    fn touched(&self, surfaces: &Surfaces, direction: DVec3) -> Option<Leg> {
        let tracer = surfaces.tracer;
        let ray = self.ray_from(tracer, self.facing, direction);
        let far = TOUCHING * step(tracer, self.hit.position) / direction.dot(self.facing).abs();
        let known = other_than_glass(
            surfaces,
            KernelRay {
                t_max: far as f32,
                ..ray
            },
        )?;
        Some(Leg {
            known: Some(known),
            medium: Medium::Air,
            ..Leg::from(ray)
        })
    }

    /// The same point as a film has it, whose glass the ray enters or leaves.
    fn through(self, entering: bool) -> SurfaceInteraction {
        let mut at = self;
        at.hit.entering = entering;
        at
    }

    /// The same point, for a ray that starts there instead of arriving.
    fn turned(self) -> SurfaceInteraction {
        SurfaceInteraction {
            direction: -self.direction,
            facing: -self.facing,
            shading_normal: -self.facing,
            ..self
        }
    }
}
