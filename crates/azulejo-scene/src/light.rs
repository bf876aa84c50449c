//! Lights without area. Lamps with area are objects whose material emits.

use crate::Rgb;
use glam::DVec3;

/// A named light.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name in the file; may be empty.
    pub name: String,
    /// What kind, and its numbers.
    pub kind: LightKind,
}

/// The kinds of light without area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Shines alike in all directions, falling with the square of the distance.
    Point {
        /// Where it is.
        position: DVec3,
        /// Radiant intensity, W/sr.
        intensity: Rgb,
    },
    /// A point light limited to a cone.
    Spot {
        /// Where it is.
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
    /// Parallel light from infinitely far away.
    Directional {
        /// Unit vector in which the light travels.
        direction: DVec3,
        /// Irradiance on a surface that faces the light, W/m².
        irradiance: Rgb,
    },
    /// The same radiance from everywhere: what a ray finds that leaves the scene.
    Ambient {
        /// Radiance, W/(sr·m²).
        radiance: Rgb,
    },
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
            LightKind::Directional { .. } | LightKind::Ambient { .. } => Rgb::BLACK,
        }
    }
}
