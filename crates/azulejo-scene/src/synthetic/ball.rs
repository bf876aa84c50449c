//! Balls with hills.

use super::{Random, add_grid};
use crate::{Material, MaterialId, Mesh, Object, Rgb, Scene, Shape};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A closed sphere of radius about 1 with hills of 15 %, of about `triangles` triangles (12 n²):
/// a stand-in for a scanned model, all triangles of similar size.
pub fn displaced_sphere(triangles: usize) -> Scene {
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let n = ((triangles as f64 / 12.0).sqrt().round() as u32).clamp(1, 16_384);
    let mut mesh = Mesh::default();
    add_ball(&mut mesh, DVec3::ZERO, 1.0, n, 0, grey);
    let mut triangulated = Mesh {
        positions: mesh.positions,
        ..Mesh::default()
    };
    for quad in mesh.faces.iter() {
        triangulated.push_face(&[quad[0], quad[1], quad[2]], grey);
        triangulated.push_face(&[quad[0], quad[2], quad[3]], grey);
    }
    scene
        .objects
        .push(Object::new("displaced sphere", Shape::Mesh(triangulated)));
    scene
}

/// Adds a sphere with hills: a cube of n × n cells per side, projected onto the sphere. Front
/// outside.
pub(super) fn add_ball(
    mesh: &mut Mesh,
    centre: DVec3,
    radius: f64,
    n: u32,
    seed: u32,
    material: MaterialId,
) {
    let waves = Waves::new(seed);
    let place = |cube: DVec3| {
        // Equal angles instead of equal lengths: cells of similar size.
        let p = (cube * (PI / 4.0)).map(f64::tan).normalize();
        centre + radius * waves.height(p) * p
    };
    let along = |k: u32| f64::from(2 * k) / f64::from(n) - 1.0;
    for side in 0..6 {
        let place_on_side = |i: u32, j: u32| place(on_cube(side, along(i), along(j)));
        add_grid(mesh, n, n, material, place_on_side);
    }
}

/// Point of the cube −1..=1: side 0..6, whose `u × v` points outside.
fn on_cube(side: u32, u: f64, v: f64) -> DVec3 {
    match side {
        0 => DVec3::new(1.0, u, v),
        1 => DVec3::new(-1.0, v, u),
        2 => DVec3::new(v, 1.0, u),
        3 => DVec3::new(u, -1.0, v),
        4 => DVec3::new(u, v, 1.0),
        _ => DVec3::new(v, u, -1.0),
    }
}

/// A sum of plane waves: smooth hills in four sizes.
struct Waves([(DVec3, f64, f64); 12]);

impl Waves {
    fn new(seed: u32) -> Waves {
        let mut random = Random(u64::from(seed));
        Waves(std::array::from_fn(|k| {
            let octave = f64::powi(2.0, k as i32 / 3);
            let direction = DVec3::new(random.next(), random.next(), random.next()) - 0.5;
            let frequency = 6.0 * octave * direction.normalize_or_zero();
            (frequency, TAU * random.next(), 0.07 / octave)
        }))
    }

    fn height(&self, p: DVec3) -> f64 {
        let wave = |&(frequency, phase, height): &(DVec3, f64, f64)| {
            height * (frequency.dot(p) + phase).sin()
        };
        1.0 + self.0.iter().map(wave).sum::<f64>()
    }
}
