//! Counts of a scene's elements.

use azulejo_scene::math::Aabb;
use azulejo_scene::{Mesh, Scene};
use std::collections::BTreeSet;

/// azulejo's own convention, which the table prints: an object is a placed mesh or primitive; its
/// vertices are those that its faces can refer to; faces are polygons; each counts as corners − 2
/// triangles. Exact primitives have neither vertices nor faces.
pub struct Counts {
    pub objects: usize,
    pub vertices: usize,
    pub faces: usize,
    pub triangles: usize,
    /// Pairs of an object and a material in it, which some programs call meshes.
    pub parts: usize,
    /// Distinct positions of each such part, in single precision.
    pub positions: usize,
    /// Of the vertices of all faces, and of all primitives.
    pub bounds: Aabb,
}

impl Counts {
    pub fn of(scene: &Scene) -> Counts {
        let meshes = || scene.objects.iter().filter_map(|o| o.shape.mesh());
        let parts: Vec<(usize, usize)> = meshes().map(parts_and_positions).collect();
        Counts {
            objects: scene.objects.len(),
            vertices: meshes().map(|m| m.positions.len()).sum(),
            faces: meshes().map(|m| m.faces.len()).sum(),
            triangles: meshes().map(|m| m.faces.triangle_count()).sum(),
            parts: parts.iter().map(|p| p.0).sum(),
            positions: parts.iter().map(|p| p.1).sum(),
            bounds: scene.bounds(),
        }
    }
}

fn parts_and_positions(mesh: &Mesh) -> (usize, usize) {
    let parts: BTreeSet<u32> = mesh.face_materials.iter().copied().collect();
    let mut positions = BTreeSet::new();
    for (face, &material) in mesh.face_materials.iter().enumerate() {
        for p in mesh.face_positions(face) {
            // Compared in single precision, as in most programs; and -0 equals 0.
            let bits = p.to_array().map(|x| (x as f32 + 0.0).to_bits());
            positions.insert((material, bits));
        }
    }
    (parts.len(), positions.len())
}
