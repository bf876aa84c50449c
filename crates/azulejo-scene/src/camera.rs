//! Pinhole cameras.

use crate::math::{Aabb, Ray};
use glam::DVec3;

/// A pinhole camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name in the file; may be empty.
    pub name: String,
    /// Position of the pinhole.
    pub eye: DVec3,
    /// A point that appears in the middle of the image; differs from the pinhole.
    pub target: DVec3,
    /// Any vector that points up in the image; not along the view direction.
    pub up: DVec3,
    /// Vertical field of view, radians, 0..π.
    pub vertical_fov: f64,
    /// Image size in pixels, width then height, if the file has one.
    pub size: Option<(u32, u32)>,
}

impl Camera {
    /// A camera that sees all of `bounds`, from the front and a little above, for scenes without
    /// one. `up` is the up axis of the model.
    pub fn framing(bounds: Aabb, aspect: f64, up: DVec3) -> Camera {
        let vertical_fov = 40f64.to_radians();
        let radius = (0.5 * bounds.diagonal()).max(f64::MIN_POSITIVE);
        let half = (vertical_fov / 2.0).min((vertical_fov / 2.0).tan().mul_add(aspect, 0.0).atan());
        let front = if up.y.abs() > 0.5 {
            DVec3::new(0.5, 0.35, 1.0)
        } else {
            DVec3::new(0.5, -1.0, 0.35)
        };
        let target = bounds.centre();
        Camera {
            name: String::new(),
            eye: target + front.normalize() * (radius / half.sin()),
            target,
            up,
            vertical_fov,
            size: None,
        }
    }

    /// Right, up and forward, unit length, right-handed with forward into the image.
    ///
    /// Finite for every camera that [`Scene::validate`](crate::Scene::validate) accepts.
    pub fn axes(&self) -> (DVec3, DVec3, DVec3) {
        let forward = (self.target - self.eye).normalize();
        let right = forward.cross(self.up).normalize();
        (right, right.cross(forward), forward)
    }

    /// The ray through a point of the image: `x`, `y` in 0..=1 from the upper left corner;
    /// `aspect` is width over height.
    pub fn ray(&self, x: f64, y: f64, aspect: f64) -> Ray {
        let (right, up, forward) = self.axes();
        let h = (0.5 * self.vertical_fov).tan();
        let direction = forward + (2.0 * x - 1.0) * h * aspect * right + (1.0 - 2.0 * y) * h * up;
        Ray::new(self.eye, direction.normalize())
    }
}
