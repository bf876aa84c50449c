//! Light sources without area. Area lights are objects whose material emits.

use crate::{Environment, PhotometricWeb, Rgb, TextureId};
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// A named light source.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name in the file; may be empty.
    pub name: String,
    /// Its kind with the parameters.
    pub kind: LightKind,
}

/// The kinds of light sources without area.
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// Emits equally in all directions; irradiance falls with the square of the distance.
    Point {
        /// World position.
        position: DVec3,
        /// Radiant intensity, W/sr.
        intensity: Rgb,
    },
    /// A point light limited to a cone.
    Spot {
        /// World position.
        position: DVec3,
        /// Unit vector along the axis of the cone.
        direction: DVec3,
        /// Radiant intensity on the axis, W/sr.
        intensity: Rgb,
        /// Half angle, radians, inside which the intensity is full; `<= outer`.
        inner: f64,
        /// Half angle, radians, outside which there is no light; `<= π`. Between the two the
        /// intensity falls by smoothstep of the angle's cosine.
        outer: f64,
    },
    /// A point light whose intensity was measured in many directions.
    Luminaire {
        /// World position.
        position: DVec3,
        /// The axes of the luminaire's frame as unit vectors of the world, orthogonal; left-handed of a mirror image.
        world_from_web: DMat3,
        /// Radiant intensity where the web says 1, W/sr.
        scale: Rgb,
        /// The intensities by direction.
        web: Arc<PhotometricWeb>,
    },
    /// Parallel light from infinitely far away.
    Directional {
        /// Unit vector in which the light travels.
        direction: DVec3,
        /// Irradiance on a surface that faces the light, W/m².
        irradiance: Rgb,
        /// Half of the angle that the light's disc subtends, radians, in 0..π/2: 0.00465 for the
        /// sun, 0 for sharp shadows.
        half_angle: f64,
    },
    /// The same radiance from all directions, for rays that leave the scene.
    Ambient {
        /// Radiance, W/(sr·m²).
        radiance: Rgb,
    },
    /// A radiance by direction, for rays that leave the scene.
    Environment(Environment),
}

impl Light {
    /// The same, with its texture numbered anew, if it shows one.
    #[must_use]
    pub fn with_texture(mut self, number: impl Fn(TextureId) -> TextureId) -> Light {
        if let LightKind::Environment(environment) = &mut self.kind {
            *environment = environment.with_texture(number);
        }
        self
    }
}

impl LightKind {
    /// Radiant intensity toward the unit direction `w` that leaves the light, W/sr.
    ///
    /// Zero for lights that have no position.
    pub fn intensity_toward(&self, w: DVec3) -> Rgb {
        match *self {
            LightKind::Point { intensity, .. } => intensity,
            LightKind::Spot {
                direction,
                intensity,
                inner,
                outer,
                ..
            } => {
                let (c, hi, lo) = (direction.dot(w), inner.cos(), outer.cos());
                let x = if c >= hi {
                    1.0
                } else {
                    ((c - lo) / (hi - lo)).max(0.0)
                };
                intensity * (x * x * (3.0 - 2.0 * x))
            }
            LightKind::Luminaire {
                world_from_web,
                scale,
                ref web,
                ..
            } => scale * web.toward(world_from_web.transpose() * w),
            LightKind::Directional { .. }
            | LightKind::Ambient { .. }
            | LightKind::Environment(_) => Rgb::BLACK,
        }
    }

    /// The world position; `None` of lights infinitely far away.
    pub fn position(&self) -> Option<DVec3> {
        match *self {
            LightKind::Point { position, .. }
            | LightKind::Spot { position, .. }
            | LightKind::Luminaire { position, .. } => Some(position),
            LightKind::Directional { .. }
            | LightKind::Ambient { .. }
            | LightKind::Environment(_) => None,
        }
    }

    /// The strength by which two lights of a kind are compared: the largest radiant intensity, W/sr, the irradiance, W/m²,
    /// or the radiance, W/(sr·m²); of an environment the factor of its radiance.
    pub fn strength(&self) -> Rgb {
        match *self {
            LightKind::Point { intensity, .. } | LightKind::Spot { intensity, .. } => intensity,
            LightKind::Luminaire { scale, ref web, .. } => scale * web.most(),
            LightKind::Directional { irradiance, .. } => irradiance,
            LightKind::Ambient { radiance } => radiance,
            LightKind::Environment(environment) => environment.scale,
        }
    }

    /// A luminaire as a point light of the same power, for formats that know no more; other lights as they are.
    #[must_use]
    pub fn without_web(&self) -> LightKind {
        match *self {
            LightKind::Luminaire {
                position,
                scale,
                ref web,
                ..
            } => LightKind::Point {
                position,
                intensity: scale * (web.sphere_integral() / (4.0 * std::f64::consts::PI)),
            },
            _ => self.clone(),
        }
    }
}
