//! What can be counted in a scene.

use azulejo_scene::math::Aabb;
use azulejo_scene::{Mesh, Scene, Shape};
use std::collections::BTreeSet;

/// azulejo's own convention, which the table prints: an object is a placed mesh or primitive; its
/// vertices are those that its faces can name; faces are polygons; triangles are corners − 2 of
/// each. Exact primitives have neither vertices nor faces.
pub struct Counts {
    pub objects: usize,
    pub vertices: usize,
    pub faces: usize,
    pub triangles: usize,
    /// Pairs of an object and a material in it: what some programs call meshes.
    pub parts: usize,
    /// Distinct positions of each such part, as floats.
    pub positions: usize,
    /// Around the vertices of all faces, and all primitives.
    pub bounds: Aabb,
}

impl Counts {
    pub fn of(scene: &Scene) -> Counts {
        let meshes = || {
            scene.objects.iter().filter_map(|o| match &o.shape {
                Shape::Mesh(mesh) => Some(mesh),
                _ => None,
            })
        };
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
            // As floats, because that is how most programs tell them apart; and -0 is 0.
            let bits = p.to_array().map(|x| (x as f32 + 0.0).to_bits());
            positions.insert((material, bits));
        }
    }
    (parts.len(), positions.len())
}
