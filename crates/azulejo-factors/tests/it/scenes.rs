//! Scenes for the tests, and how estimates are compared with known answers.

// Each test crate that includes this module uses a part of it.
#![allow(dead_code)]

use azulejo_scene::synthetic::cube_room;
use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
use glam::DVec3;
use std::f64::consts::PI;

/// A grey surface that reflects, mirrors and emits, the last as exitance in W/m².
pub fn surface(diffuse: f64, mirror: f64, exitance: f64) -> Material {
    Material {
        diffuse: Rgb::grey(diffuse),
        mirror: Rgb::grey(mirror),
        emission: Rgb::grey(exitance / PI),
        ..Material::default()
    }
}

/// The unit cube seen from inside; materials of z = 0, z = 1, x = 0, x = 1, y = 0, y = 1.
pub fn cube(materials: [Material; 6]) -> Scene {
    let mut scene = cube_room();
    scene.materials = materials.to_vec();
    mesh_of(&mut scene, 0).face_materials = vec![2, 3, 4, 5, 0, 1];
    scene
}

/// Face of the cube's mesh with the material of this number: see [`cube`].
pub fn cube_face(material: usize) -> u32 {
    [4, 5, 0, 1, 2, 3][material]
}

/// Adds a parallelogram whose front looks toward `edge1 × edge2`.
pub fn add_sheet(scene: &mut Scene, corner: DVec3, edge1: DVec3, edge2: DVec3, material: Material) {
    let material = scene.add_material(material);
    let positions = vec![
        corner,
        corner + edge1,
        corner + edge1 + edge2,
        corner + edge2,
    ];
    let mut mesh = Mesh {
        positions,
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], material);
    scene.objects.push(Object::new("sheet", Shape::Mesh(mesh)));
}

/// Adds a parallelogram cut into `n × n` faces.
pub fn add_tiles(
    scene: &mut Scene,
    corner: DVec3,
    edge1: DVec3,
    edge2: DVec3,
    n: u32,
    material: Material,
) {
    let material = scene.add_material(material);
    let at = |i: u32, j: u32| {
        corner + edge1 * (f64::from(i) / f64::from(n)) + edge2 * (f64::from(j) / f64::from(n))
    };
    let mut mesh = Mesh::default();
    for j in 0..=n {
        mesh.positions.extend((0..=n).map(|i| at(i, j)));
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            mesh.push_face(&[a, a + 1, a + n + 2, a + n + 1], material);
        }
    }
    scene.objects.push(Object::new("tiles", Shape::Mesh(mesh)));
}

/// The mesh of an object that is one.
pub fn mesh_of(scene: &mut Scene, object: usize) -> &mut Mesh {
    match &mut scene.objects[object].shape {
        Shape::Mesh(mesh) => mesh,
        _ => panic!("object {object} is not a mesh"),
    }
}

/// Mean and standard error of independent estimates.
pub fn spread(each: &[f64]) -> (f64, f64) {
    let n = each.len() as f64;
    let mean = each.iter().sum::<f64>() / n;
    let square = each.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    (mean, (square / (n * (n - 1.0))).sqrt())
}

/// Asserts that an estimate agrees with the truth within five standard errors of four
/// replicates, and `tolerance` besides; no error is smaller than `floor`, the rounding.
#[track_caller]
pub fn check(what: &str, (value, error): (f64, f64), truth: f64, tolerance: f64, floor: f64) {
    eprintln!("{what}: {value:.7} ± {error:.1e}, truth {truth:.7}");
    let off = (value - truth).abs();
    assert!(
        off <= tolerance,
        "{what}: {value} is {off:.2e} off {truth}, more than {tolerance:.1e}"
    );
    assert!(
        off <= 5.0 * error + floor,
        "{what}: {value} ± {error:.1e} claims too much: {truth}"
    );
}
