//! Tests of the second pass through its public interface.

mod behaviour;
mod exact;
mod furnace;
mod gallery;
mod gather;
mod glossy;
mod golden;
mod lightmap;
mod maps;
mod opacity;
mod optics;
mod surfaces;

use azulejo_render::SecondPass;
use azulejo_scene::math::Ray;
use azulejo_scene::{Camera, Mesh, Object, Primitive, Rgb, Scene, Shape};
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;

/// Adds a mesh of one polygon; returns the index of its object.
fn polygon(scene: &mut Scene, corners: &[DVec3], material: u32) -> usize {
    let mut mesh = Mesh {
        positions: corners.to_vec(),
        ..Mesh::default()
    };
    let face: Vec<u32> = (0..corners.len() as u32).collect();
    mesh.push_face(&face, material);
    scene
        .objects
        .push(Object::new("polygon", Shape::Mesh(mesh)));
    scene.objects.len() - 1
}

/// Adds a primitive.
fn primitive(scene: &mut Scene, primitive: Primitive) {
    let shape = Shape::Primitive(primitive);
    scene.objects.push(Object::new("primitive", shape));
}

/// The mesh of an object.
fn mesh_of(scene: &mut Scene, object: usize) -> &mut Mesh {
    match &mut scene.objects[object].shape {
        Shape::Mesh(mesh) => mesh,
        _ => panic!("object {object} is a primitive"),
    }
}

/// Radiance along rays, each from the first point toward the second.
fn radiance_along(scene: &Scene, rays: &[(DVec3, DVec3)], options: &SecondPass) -> Vec<Rgb> {
    scene.validate().expect("the test's scene is valid");
    let rays: Vec<Ray> = rays
        .iter()
        .map(|&(from, to)| Ray::new(from, (to - from).normalize()))
        .collect();
    let tracer = Tracer::new(scene);
    azulejo_render::radiance(scene, &tracer, &rays, options, &Progress::new())
        .expect("nobody cancels")
}

/// A camera at `eye` that looks at `target`, y up.
fn camera(eye: DVec3, target: DVec3, degrees: f64) -> Camera {
    Camera {
        name: String::new(),
        eye,
        target,
        up: DVec3::Y,
        vertical_fov: degrees.to_radians(),
        size: None,
    }
}

/// Asserts that two colours agree to `tolerance` in every channel.
#[track_caller]
fn assert_close(found: Rgb, expected: Rgb, tolerance: f64) {
    let worst = (0..3)
        .map(|k| (found[k] - expected[k]).abs())
        .fold(0.0, f64::max);
    assert!(
        worst <= tolerance,
        "found {found:?}, expected {expected:?} to {tolerance}"
    );
}
