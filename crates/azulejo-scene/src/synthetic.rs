//! Scenes made by formula: for tests, examples and benchmarks.
//!
//! All are deterministic, and closed where their documentation says so: faces that meet share
//! their corners' positions exactly.

mod ball;
mod cornell_box;
mod cornell_thesis;
mod furnished_room;
mod room_with_table;
mod sheets;
mod street;
#[cfg(test)]
mod tests;

pub use ball::displaced_sphere;
pub use cornell_box::{CornellVariant, cornell_box};
pub use cornell_thesis::{cornell_thesis, cornell_thesis_at};
pub use furnished_room::furnished_room;
pub use room_with_table::room_with_table;
pub use street::{street, street_at};

use crate::{Material, MaterialId, Mesh, Object, Rgb, Scene, Shape};
use glam::DVec3;

/// The closed unit cube, six quadrilaterals that face inward, reflectance 0.5, no light.
///
/// Form factors between its sides are known: 0.1998 to the opposite one, 0.2000 to each other.
pub fn cube_room() -> Scene {
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let mut mesh = Mesh {
        positions: (0..8)
            .map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)))
            .collect(),
        ..Mesh::default()
    };
    for corners in [
        [0, 2, 6, 4],
        [1, 5, 7, 3],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 1, 3, 2],
        [4, 6, 7, 5],
    ] {
        mesh.push_face(&corners, grey);
    }
    scene.objects.push(Object::new("cube", Shape::Mesh(mesh)));
    scene
}

/// Random numbers in 0..1, from a seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        crate::random::split_mix64(&mut self.0)
    }
}

/// Adds `nu × nv` quadrilaterals over the vertices `place(i, j)`.
fn add_grid(
    mesh: &mut Mesh,
    nu: u32,
    nv: u32,
    material: MaterialId,
    place: impl Fn(u32, u32) -> DVec3,
) {
    let base = mesh.positions.len() as u32;
    for j in 0..=nv {
        mesh.positions.extend((0..=nu).map(|i| place(i, j)));
    }
    let at = |i: u32, j: u32| base + j * (nu + 1) + i;
    for j in 0..nv {
        for i in 0..nu {
            mesh.push_face(
                &[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)],
                material,
            );
        }
    }
}
