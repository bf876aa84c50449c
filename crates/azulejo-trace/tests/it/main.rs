//! What the tracer promises, seen from outside.

mod air_films;
mod bevels;
mod csg;
mod glossy;
mod indirect;
mod mirrors;
mod precision;
mod prisms;
mod shapes;
mod transparency;
mod watertight;

use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
use glam::DVec3;

/// A scene of one grey material.
fn scene(shapes: impl IntoIterator<Item = Shape>) -> Scene {
    let mut scene = Scene::default();
    scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    scene.objects = shapes.into_iter().map(|s| Object::new("", s)).collect();
    scene
}

fn triangle_mesh(triangles: &[[DVec3; 3]]) -> Shape {
    let mut mesh = Mesh::default();
    for t in triangles {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(t);
        mesh.push_face(&[first, first + 1, first + 2], 0);
    }
    Shape::Mesh(mesh)
}

/// Random numbers, from a seed.
struct Random(u64);

impl Random {
    /// In −1..1.
    fn next(&mut self) -> f64 {
        2.0 * azulejo_scene::random::split_mix64(&mut self.0) - 1.0
    }

    /// In the cube −1..1.
    fn point(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }

    fn unit(&mut self) -> DVec3 {
        loop {
            let p = self.point();
            if (0.01..1.0).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }
}
