//! The map between the world and the kernel's own coordinates.

use azulejo_scene::math::Aabb;
use glam::{DAffine3, DMat3, DVec3};

/// World to kernel coordinates: `(p − centre) · scale`, which lie in −1..=1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalFrame {
    centre: DVec3,
    /// A power of two, so that scaling rounds nothing.
    scale: f64,
}

impl LocalFrame {
    pub(crate) fn around(bounds: &Aabb) -> LocalFrame {
        let half = 0.5 * bounds.size().max_element();
        // A single point, or a size that no power of two scales to 1, is not scaled.
        let scale = (-half.log2().ceil()).exp2();
        LocalFrame {
            centre: bounds.centre(),
            scale: if scale.is_normal() { scale } else { 1.0 },
        }
    }

    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        (p - self.centre) * self.scale
    }

    pub(crate) fn vector(&self, v: DVec3) -> DVec3 {
        v * self.scale
    }

    pub(crate) fn world_point(&self, p: DVec3) -> DVec3 {
        p / self.scale + self.centre
    }

    pub(crate) fn world_vector(&self, v: DVec3) -> DVec3 {
        v / self.scale
    }

    /// Largest coordinate of a point relative to the centre, in world units.
    pub(crate) fn distance(&self, p: DVec3) -> f64 {
        (p - self.centre).abs().max_element()
    }

    pub(crate) fn world_from_local(&self) -> DAffine3 {
        DAffine3 {
            matrix3: DMat3::from_diagonal(DVec3::splat(1.0 / self.scale)),
            translation: self.centre,
        }
    }

    pub(crate) fn local_from_world(&self) -> DAffine3 {
        DAffine3 {
            matrix3: DMat3::from_diagonal(DVec3::splat(self.scale)),
            translation: -self.centre * self.scale,
        }
    }
}

pub(crate) fn single(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

pub(crate) fn double(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}
