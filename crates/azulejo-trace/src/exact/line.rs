//! Lines in space, in double precision.

use crate::frame::double;
use crate::kernel::KernelRay;
use glam::{DAffine3, DVec3};

/// The points `origin + t direction` for all `t`; the direction has any length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line3 {
    pub origin: DVec3,
    pub direction: DVec3,
}

impl Line3 {
    /// The line of a ray, in the kernel's coordinates.
    #[inline(always)]
    pub(crate) fn of(ray: &KernelRay) -> Line3 {
        Line3 {
            origin: double(ray.origin),
            direction: double(ray.direction),
        }
    }

    /// The point at `t`.
    #[inline(always)]
    pub(crate) fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }

    /// The line under a map; `t` is unchanged.
    #[inline(always)]
    pub(crate) fn mapped(&self, map: &DAffine3) -> Line3 {
        Line3 {
            origin: map.transform_point3(self.origin),
            direction: map.transform_vector3(self.direction),
        }
    }
}
