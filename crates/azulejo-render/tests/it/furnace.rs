//! Closed rooms in which radiance is 1 everywhere and in every direction.

use crate::{assert_close, camera, primitive, radiance_along};
use azulejo_render::{SecondPass, render};
use azulejo_scene::{
    Light, LightKind, Material, Object, Primitive, PrimitiveKind, Rgb, Scene, Shape, SurfaceLight,
};
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;

/// Emits 1 − ρ and reflects ρ: of radiance 1 where E = π.
fn grey_body(scene: &mut Scene, reflectance: Rgb) -> u32 {
    let emission = Rgb::WHITE - reflectance;
    scene.add_material(Material {
        emission,
        ..Material::diffuse("furnace", reflectance)
    })
}

/// The room from −3 to 3, seen from inside, with irradiance π.
pub fn room() -> Scene {
    let mut scene = Scene::default();
    let wall = grey_body(&mut scene, Rgb::new(0.3, 0.5, 0.9));
    let map = DAffine3::from_scale(DVec3::splat(6.0));
    let cube = Primitive::new(PrimitiveKind::Cuboid, map, wall);
    let mut mesh = cube.tessellate(&cube.grids(1.0, 1.3));
    mesh.positions
        .iter_mut()
        .for_each(|p| *p -= DVec3::splat(3.0));
    mesh.normals = None;
    mesh.irradiance = vec![Rgb::grey(PI); mesh.positions.len()];
    // The cuboid's front is outside; the room is seen from inside.
    for face in 0..mesh.faces.len() {
        let range = mesh.faces.corner_range(face);
        mesh.faces.corners[range].reverse();
    }
    scene.objects.push(Object::new("room", Shape::Mesh(mesh)));
    scene
}

/// Adds a primitive of radiance 1.
fn grey_primitive(scene: &mut Scene, kind: PrimitiveKind, map: DAffine3) {
    let material = grey_body(scene, Rgb::grey(0.4));
    let mut shape = Primitive::new(kind, map, material);
    let grids = shape.grids(0.1, f64::INFINITY);
    let count: usize = grids.iter().map(|g| g.vertices()).sum();
    shape.light = Some(Box::new(SurfaceLight {
        grids,
        irradiance: vec![Rgb::grey(PI); count],
        error: Vec::new(),
    }));
    primitive(scene, shape);
}

/// The mean and the worst pixel of an image of the room from one corner.
fn check(scene: &Scene, worst: f64, mean: f64) {
    scene.validate().expect("the test's scene is valid");
    let eye = camera(DVec3::new(-2.5, 2.0, -2.4), DVec3::ZERO, 80.0);
    let options = SecondPass {
        size: (40, 30),
        samples_per_pixel: 16,
        ..SecondPass::default()
    };
    let tracer = Tracer::new(scene);
    let image = render(scene, &tracer, &eye, &options, &Progress::new()).expect("not cancelled");
    let mut sum = Rgb::BLACK;
    for p in &image.pixels {
        let p = Rgb::from(p.map(f64::from));
        assert_close(p, Rgb::WHITE, worst);
        sum += p / image.pixels.len() as f64;
    }
    assert_close(sum, Rgb::WHITE, mean);
}

#[test]
fn diffuse_room_has_radiance_one() {
    let mut scene = room();
    check(&scene, 1e-6, 1e-6);
    let at = DAffine3::from_translation;
    grey_primitive(
        &mut scene,
        PrimitiveKind::Sphere,
        at(DVec3::new(1.0, 0.0, 1.0)),
    );
    grey_primitive(
        &mut scene,
        PrimitiveKind::Cylinder,
        at(DVec3::new(-1.5, -1.0, 0.5)),
    );
    grey_primitive(
        &mut scene,
        PrimitiveKind::Cone { top: 0.3 },
        at(DVec3::new(1.0, 1.0, -2.0)),
    );
    check(&scene, 1e-6, 1e-6);
}

#[test]
fn perfect_mirrors_change_nothing() {
    let mut scene = room();
    let mirror = scene.add_material(Material::mirror("mirror", Rgb::WHITE));
    for x in [-1.2, 1.2] {
        primitive(
            &mut scene,
            Primitive::sphere(DVec3::new(x, 0.0, 0.5), 1.0, mirror),
        );
    }
    check(&scene, 1e-6, 1e-6);
}

#[test]
fn coated_walls_change_nothing() {
    // Emits 0.2, reflects 0.5 diffusely and 0.3 as a mirror: of radiance 1 again.
    let mut scene = room();
    scene.materials[0] = Material {
        emission: Rgb::grey(0.2),
        mirror: Rgb::grey(0.3),
        ..Material::diffuse("coated", Rgb::grey(0.5))
    };
    // Roulette decides where 0.3 to the 4th is left.
    check(&scene, 0.05, 1e-3);
}

#[test]
fn clear_glass_changes_nothing() {
    let mut scene = room();
    let glass = scene.add_material(Material::dielectric("glass", 1.5));
    let bubble = scene.add_material(Material::dielectric("bubble", 1.0 / 1.5));
    primitive(
        &mut scene,
        Primitive::sphere(DVec3::new(0.0, 0.0, 0.0), 1.2, glass),
    );
    primitive(
        &mut scene,
        Primitive::sphere(DVec3::new(0.1, 0.0, 0.2), 0.6, bubble),
    );
    // Choosing between reflection and refraction keeps the radiance of each path at 1; roulette at
    // grazing angles is the only noise.
    check(&scene, 0.05, 1e-3);
}

#[test]
fn ambient_light_is_what_rays_find_outside() {
    let mut scene = Scene::default();
    for radiance in [Rgb::new(0.5, 0.0, 1.0), Rgb::new(0.5, 1.0, 0.0)] {
        scene.lights.push(Light {
            name: "sky".into(),
            kind: LightKind::Ambient { radiance },
        });
    }
    let glass = scene.add_material(Material::dielectric("glass", 1.5));
    primitive(&mut scene, Primitive::sphere(DVec3::ZERO, 1.0, glass));
    let found = radiance_along(
        &scene,
        &[
            (DVec3::new(5.0, 3.0, 0.0), DVec3::new(5.0, 9.0, 2.0)),
            (DVec3::new(5.0, 0.0, 0.0), DVec3::new(0.0, 0.3, 0.0)),
        ],
        &SecondPass::default(),
    );
    assert_close(found[0], Rgb::WHITE, 1e-12);
    assert_close(found[1], Rgb::WHITE, 1e-3);
}

#[test]
fn emission_leaves_the_front_only() {
    let mut scene = Scene::default();
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::new(1.0, 2.0, 3.0)));
    let square = Primitive::parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y, lamp);
    primitive(&mut scene, square);
    let middle = DVec3::new(0.5, 0.4, 0.0);
    let found = radiance_along(
        &scene,
        &[(middle + DVec3::Z, middle), (middle - DVec3::Z, middle)],
        &SecondPass::default(),
    );
    assert_close(found[0], Rgb::new(1.0, 2.0, 3.0), 1e-12);
    assert_close(found[1], Rgb::BLACK, 0.0);
}
