//! Whether a model stands on a ground of its own.

use azulejo_scene::math::area_vector;
use azulejo_scene::{Mesh, Scene, Shape};

/// Share of the model's footprint that a ground covers.
const COVERED: f64 = 0.5;

/// Height above the lowest point, relative to the model's size, below which faces may be ground.
const BOTTOM: f64 = 0.02;

/// The name of the object whose upward faces near the bottom cover most of the model's footprint.
pub fn modelled_ground(scene: &Scene) -> Option<&str> {
    let bounds = scene.bounds();
    if bounds.is_empty() {
        return None;
    }
    let up = scene.units.up.axis();
    let size = bounds.size();
    let height = size.dot(up);
    let footprint = size.x * size.y * size.z / height.max(f64::MIN_POSITIVE);
    let limit = bounds.min.dot(up) + BOTTOM * size.max_element();
    let covers = |mesh: &Mesh| {
        // Of both orientations: many models have floors that are turned. The larger of the two, because
        // a plate has both.
        let mut areas = [0.0f64; 2];
        for k in 0..mesh.faces.len() {
            let corners = mesh.faces.get(k).iter();
            let corners: Vec<_> = corners.map(|&c| mesh.positions[c as usize]).collect();
            if corners.iter().all(|p| p.dot(up) <= limit) {
                let area = area_vector(&corners).dot(up);
                areas[usize::from(area > 0.0)] += area.abs();
            }
        }
        areas[0].max(areas[1]) > COVERED * footprint
    };
    let is_flat = height <= 1e-9 * size.max_element();
    let ground = scene.objects.iter().find(|object| match &object.shape {
        Shape::Mesh(mesh) => is_flat || covers(mesh),
        Shape::Instance(instance) => is_flat || covers(&instance.to_mesh()),
        Shape::Primitive(p) => covers(&p.tessellate(&p.grids(0.2, f64::INFINITY))),
        Shape::Exact(_) => false,
    });
    ground.map(|object| object.name.as_str())
}
