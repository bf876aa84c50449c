//! Triangles that coincide with others of their mesh.

use crate::kernel::KernelTriangle;
use azulejo_scene::MaterialId;
use rayon::prelude::*;
use std::collections::HashSet;

/// Drops the triangles from `start` on that have the corners of an earlier one, in the same order,
/// and its material: a ray would hit one of them at random. No box of the tree separates them, so
/// every ray near a million of them would test them all. `material` is that of an item.
pub(super) fn drop_twins(
    triangles: &mut Vec<KernelTriangle>,
    start: usize,
    material: impl Fn(u32) -> MaterialId + Sync,
) {
    let own = &triangles[start..];
    let mut hashes: Vec<u64> = (own.par_iter())
        .map(|t| hash(t, material(t.item)))
        .collect();
    hashes.par_sort_unstable();
    // Most meshes have none, and need no set of all triangles.
    if !hashes.windows(2).any(|w| w[0] == w[1]) {
        return;
    }
    drop(hashes);
    let mut seen = HashSet::new();
    let kept: Vec<KernelTriangle> = own
        .iter()
        .filter(|t| seen.insert((bits(t), material(t.item))))
        .copied()
        .collect();
    triangles.truncate(start);
    triangles.extend(kept);
}

fn bits(triangle: &KernelTriangle) -> [[u32; 3]; 3] {
    // Adding zero turns −0 into 0.
    triangle.corners.map(|c| c.map(|x| (x + 0.0).to_bits()))
}

fn hash(triangle: &KernelTriangle, material: MaterialId) -> u64 {
    let corners = bits(triangle);
    let words = corners.as_flattened().iter().chain([&material]);
    words.fold(0, |hash: u64, &word| {
        let mixed = (hash ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ mixed >> 29
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tracer;
    use azulejo_scene::math::Ray;
    use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
    use glam::DVec3;

    #[test]
    fn only_equal_triangles_of_one_material_are_dropped() {
        let [a, b, c] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let corners = [
            [a, b, c],
            [a, b, c],
            [a, c, b],
            [a, b, c],
            [a, b, [0.0, 2.0, 0.0]],
            [a, b, [-0.0, 1.0, -0.0]],
        ];
        let materials = [0, 0, 0, 1, 0, 0];
        let mut all: Vec<KernelTriangle> = (0..)
            .zip(corners)
            .map(|(item, corners)| KernelTriangle { corners, item })
            .collect();
        let kept = |all: &[KernelTriangle]| all.iter().map(|t| t.item).collect::<Vec<u32>>();
        let mut behind = all.clone();
        drop_twins(&mut all, 0, |item| materials[item as usize]);
        assert_eq!(kept(&all), [0, 2, 3, 4]);
        // Triangles before the start belong to other meshes.
        drop_twins(&mut behind, 1, |item| materials[item as usize]);
        assert_eq!(kept(&behind), [0, 1, 2, 3, 4]);
    }

    /// Without dropping, these rays would test 10¹⁰ triangles.
    #[test]
    fn rays_pass_a_hundred_thousand_coincident_triangles() {
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            ..Mesh::default()
        };
        (0..100_000).for_each(|_| mesh.push_face(&[0, 1, 2], 0));
        let mut scene = Scene::default();
        scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        scene.objects.push(Object::new("many", Shape::Mesh(mesh)));
        let tracer = Tracer::new(&scene);
        for k in 0..100_000 {
            let x = 0.9 * f64::from(k) / 100_000.0;
            let ray = Ray::new(DVec3::new(x, 0.05, 1.0), -DVec3::Z);
            let hit = tracer.hit(&ray).expect("over the triangle");
            assert_eq!(hit.face, 0);
        }
    }
}
