//! Origins near the geometry, for positions in single precision.
//!
//! Positions of glTF have 32 bits, but the numbers in its JSON 64: what is far from the origin is written
//! relative to a point near it, which becomes the translation of a node.

use crate::surface::single::{self, CoordinateReach, near};
use azulejo_scene::math::Aabb;
use azulejo_scene::{Mesh, Scene, Shape};
use glam::DVec3;

/// The origin relative to which positions of a scene are best stored in single precision: that of its
/// coordinates, unless it is far away and has positions that single precision would change there.
///
/// In coordinates of the scene, with few decimal digits.
pub fn local_origin(scene: &Scene) -> DVec3 {
    let bounds = scene.bounds();
    let is_far = CoordinateReach::of(bounds).is_some_and(|extent| extent.is_far());
    if is_far && scene.objects.iter().any(|o| is_changed(&o.shape)) {
        near(bounds)
    } else {
        DVec3::ZERO
    }
}

/// Whether single precision changes positions of a shape; of exact shapes any.
fn is_changed(shape: &Shape) -> bool {
    match shape {
        Shape::Mesh(mesh) => rounding(mesh, DVec3::ZERO) > 0.0,
        Shape::Instance(instance) => {
            single::rounding([instance.world_from_mesh.translation].into_iter()) > 0.0
        }
        Shape::Primitive(_) | Shape::Exact(_) => true,
    }
}

/// The origin of a mesh of its own, relative to that of the scene: zero, unless its details would
/// suffer from its distance.
pub(super) fn of_mesh(mesh: &Mesh, scene_origin: DVec3) -> DVec3 {
    let bounds = mesh.bounds();
    let bounds = Aabb {
        min: bounds.min - scene_origin,
        max: bounds.max - scene_origin,
    };
    let is_far = CoordinateReach::of(bounds).is_some_and(|extent| extent.is_far());
    let is_lost = || single::is_noticed(rounding(mesh, scene_origin), mesh);
    if is_far && is_lost() {
        near(bounds)
    } else {
        DVec3::ZERO
    }
}

/// The largest change of a position relative to an origin.
fn rounding(mesh: &Mesh, origin: DVec3) -> f64 {
    single::rounding(single::used_positions(mesh).map(|p| p - origin))
}
