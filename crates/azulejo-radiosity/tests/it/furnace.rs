//! Furnaces: closed rooms in which every point receives the same light, whatever the form factors.

use crate::rooms::*;
use azulejo_radiosity::{FirstPass, PatchSize, solve};
use azulejo_scene::synthetic::{self, displaced_sphere};
use azulejo_scene::{
    Light, LightKind, Material, Mesh, Object, ObjectIrradiance, Primitive, Rgb, Scene, Shape,
};
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DQuat, DVec3, EulerRot, dvec3};
use std::f64::consts::PI;

fn furnace(diffuse: f64, mirror: f64) -> Scene {
    cube([0; 6].map(|_| surface(diffuse, mirror, 1.0)))
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// B = M / (1 − ρ_d/(1 − ρ_s)): every patch has the same, from 16 rays on.
#[track_caller]
fn check_patches(scene: &Scene, rays_per_patch: u32, radiosity: f64, within: f64) {
    let pass = FirstPass {
        size: PatchSize::Count(150),
        ..rays(rays_per_patch)
    };
    let solved = Matrix::solve(scene, &pass);
    let off = (0..solved.patches.len()).map(|p| (solved.radiosity(p, true).0 - radiosity).abs());
    let off = largest(off);
    eprintln!(
        "B of {} patches: {off:.1e} off {radiosity}",
        solved.patches.len()
    );
    assert!(off < within, "B is {off} off {radiosity}");
    assert!(
        solved.found.balance.error() < within,
        "balance: {:?}",
        solved.found.balance
    );
}

#[test]
fn diffuse_patches_glow_alike() {
    check_patches(&furnace(0.5, 0.0), 16, 2.0, 4e-5);
}

#[test]
fn mirroring_patches_glow_alike() {
    check_patches(&furnace(0.5, 0.3), 16, 3.5, 1e-4);
}

/// The light of a room this white falls by a fiftieth at each bounce, so that one after another would take some 600.
#[test]
fn light_that_dies_out_slowly_is_foreseen() {
    let pass = FirstPass {
        size: PatchSize::Count(150),
        ..rays(16)
    };
    let solved = Matrix::solve(&furnace(0.98, 0.0), &pass);
    let off = (0..solved.patches.len()).map(|p| (solved.radiosity(p, true).0 / 50.0 - 1.0).abs());
    let off = largest(off);
    let bounces = solved.found.convergence.iterations;
    assert!(off < 1e-3, "B is {off} off");
    assert!(bounces < 150, "{bounces} bounces");
}

/// A closed room of unit size, whose walls are divided by other numbers than those that they meet.
fn divided_room() -> Mesh {
    let mut mesh = Mesh::default();
    for (axis, count) in [1, 3, 5].into_iter().enumerate() {
        for side in [0.0, 1.0] {
            let point = |k: u32, l: u32| {
                let [u, v] = [k, l].map(|k| f64::from(k) / f64::from(count));
                let (u, v) = if side > 0.0 { (v, u) } else { (u, v) };
                let mut p = [side; 3];
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u, v);
                DVec3::from_array(p)
            };
            for (k, l) in (0..count).flat_map(|k| (0..count).map(move |l| (k, l))) {
                let ring = [(k, l), (k + 1, l), (k + 1, l + 1), (k, l + 1)];
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(ring.map(|(k, l)| point(k, l)));
                mesh.push_face(&[first, first + 1, first + 2, first + 3], 0);
            }
        }
    }
    mesh
}

/// Single precision bends and moves the walls of rooms that are turned and far from the origin: vertices inside of some
/// walls lay behind the triangles that rays meet, and others past the next wall, and were black.
#[test]
fn vertices_of_rounded_walls_are_lit() {
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.5, 0.9, 0.2);
    let Shape::Mesh(cube) = synthetic::cube_room().objects.remove(0).shape else {
        panic!("a mesh")
    };
    for (room, size, far) in [
        (cube, 500.0, dvec3(207_425.0, -151_520.0, 341_360.0)),
        (divided_room(), 5.0, dvec3(42_001.0, -33_333.0, 65_710.0)),
    ] {
        let map = DAffine3::from_scale_rotation_translation(DVec3::splat(size), turn, far);
        let mut mesh = room;
        let rounded = |p: &DVec3| map.transform_point3(*p).as_vec3().as_dvec3();
        mesh.positions = mesh.positions.iter().map(rounded).collect();
        let mut scene = Scene::default();
        scene.add_material(surface(0.5, 0.0, 1.0));
        scene.objects.push(Object::new("room", Shape::Mesh(mesh)));
        let pass = FirstPass {
            size: PatchSize::Count(150),
            ..rays(256)
        };
        let light = solve(&scene, &Tracer::new(&scene), &pass, &Progress::new()).unwrap();
        let ObjectIrradiance::Refined(mesh) = &light.irradiance.objects[0] else {
            panic!("a divided mesh")
        };
        let worst = largest(mesh.irradiance.iter().map(|e| (e.mean() - 2.0).abs()));
        assert!(worst < 0.5, "size {size}: {worst} off 2");
    }
}

/// At points the formulas are exact, and so are rays that read equal radiosities; the rest is light
/// of nearby corners, which final gathers sample.
#[track_caller]
fn check_points(scene: &Scene, size: PatchSize, truth: f64, rms: f64) {
    let points = points_on_cube(120);
    let found = irradiance(scene, &points, &FirstPass { size, ..rays(256) });
    let square = |e: &azulejo_radiosity::Estimate| (e.value.mean() - truth).powi(2);
    let error = (found.iter().map(square).sum::<f64>() / points.len() as f64).sqrt() / truth;
    let said = (found.iter().map(|e| e.error.mean().powi(2)).sum::<f64>() / points.len() as f64)
        .sqrt()
        / truth;
    let mean = found.iter().map(|e| e.value.mean()).sum::<f64>() / points.len() as f64;
    eprintln!("H at points: mean {mean}, rms error {error:.2e}, said {said:.2e}");
    assert!(error < rms, "rms error {error}");
    assert!(
        (mean / truth - 1.0).abs() < 3.0 * said / 11.0 + 1e-5,
        "mean {mean}, truth {truth}"
    );
}

#[test]
fn points_receive_alike() {
    check_points(&furnace(0.5, 0.0), PatchSize::Count(600), 2.0, 2e-2);
    check_points(&furnace(0.5, 0.3), PatchSize::Count(600), 5.0, 3e-2);
}

#[test]
fn direct_light_of_a_furnace_is_exact_at_points() {
    let pass = FirstPass {
        bounces: Some(0),
        ..rays(64)
    };
    for e in irradiance(&furnace(0.5, 0.0), &points_on_cube(60), &pass) {
        assert!((e.value.mean() - 1.0).abs() < 1e-12, "{e:?}");
    }
}

/// Light of n bounces is a geometric series, at patches and at points alike.
#[test]
fn bounces_are_counted() {
    for n in 0..4 {
        let truth: f64 = (0..=n).map(|k| 0.5f64.powi(k)).sum();
        let pass = FirstPass {
            bounces: Some(n as u32),
            size: PatchSize::Count(150),
            ..rays(64)
        };
        let found = irradiance(&furnace(0.5, 0.0), &points_on_cube(60), &pass);
        let off = largest(found.iter().map(|e| (e.value.mean() - truth).abs()));
        assert!(off < 1e-5, "{n} bounces: {off:.1e} off {truth}");
    }
}

#[test]
fn vertices_receive_alike() {
    let scene = furnace(0.5, 0.0);
    let pass = FirstPass {
        size: PatchSize::Count(96),
        ..rays(1024)
    };
    let light = solve(&scene, &Tracer::new(&scene), &pass, &Progress::new()).unwrap();
    let ObjectIrradiance::Refined(mesh) = &light.irradiance.objects[0] else {
        panic!("a divided mesh")
    };
    let mean = mesh.irradiance.iter().map(|e| e.mean()).sum::<f64>() / mesh.irradiance.len() as f64;
    let worst = largest(mesh.irradiance.iter().map(|e| (e.mean() - 2.0).abs()));
    eprintln!(
        "H at {} vertices: mean {mean}, worst {worst:.2e} off",
        mesh.irradiance.len()
    );
    assert!(
        (mean - 2.0).abs() < 5e-3 && worst < 0.15,
        "mean {mean}, worst {worst}"
    );
}

fn in_white_surroundings(mut scene: Scene) -> Scene {
    let kind = LightKind::Ambient {
        radiance: Rgb::WHITE,
    };
    scene.lights.push(Light {
        name: "sky".into(),
        kind,
    });
    scene
}

/// Objects that absorb nothing are invisible in uniform surroundings: every point receives π times
/// their radiance.
#[track_caller]
fn check_white(what: &str, scene: &Scene, points: &[azulejo_radiosity::PointNormal], within: f64) {
    let found = irradiance(
        scene,
        points,
        &FirstPass {
            size: PatchSize::Count(200),
            ..rays(256)
        },
    );
    let off = largest(found.iter().map(|e| (e.value.mean() / PI - 1.0).abs()));
    eprintln!("white furnace, {what}: {off:.1e} off");
    assert!(off < within, "{what}: {off}");
}

#[test]
fn white_objects_vanish_in_white_surroundings() {
    let sheet = |material: Material| {
        let mut scene = in_white_surroundings(Scene::default());
        add_sheet(
            &mut scene,
            dvec3(-2.0, -2.0, 0.0),
            4.0 * DVec3::X,
            4.0 * DVec3::Y,
            surface(1.0, 0.0, 0.0),
        );
        let ball = scene.add_material(material);
        scene.objects.push(Object::new(
            "ball",
            Shape::Primitive(Primitive::sphere(dvec3(0.0, 0.0, 1.0), 0.8, ball)),
        ));
        scene
    };
    let points = [
        at(0.3, 0.2, 0.0, DVec3::Z),
        at(1.5, 0.0, 0.0, DVec3::Z),
        at(-0.9, 0.7, 0.0, DVec3::Z),
    ];
    check_white("white ball", &sheet(surface(1.0, 0.0, 0.0)), &points, 1e-4);
    check_white("mirror ball", &sheet(surface(0.0, 1.0, 0.0)), &points, 1e-4);
    check_white(
        "half mirror ball",
        &sheet(surface(0.4, 0.6, 0.0)),
        &points,
        1e-4,
    );
    check_white(
        "glass ball",
        &sheet(Material::dielectric("glass", 1.5)),
        &points,
        1e-4,
    );
}

#[test]
fn a_white_hilly_ball_vanishes_too() {
    let mut scene = in_white_surroundings(displaced_sphere(600));
    scene.materials[0] = surface(1.0, 0.0, 0.0);
    let tracer = Tracer::new(&scene);
    let light = solve(
        &scene,
        &tracer,
        &FirstPass {
            size: PatchSize::Count(600),
            ..rays(64)
        },
        &Progress::new(),
    )
    .unwrap();
    let ObjectIrradiance::Refined(mesh) = &light.irradiance.objects[0] else {
        panic!("a divided mesh")
    };
    let off = largest(mesh.irradiance.iter().map(|e| (e.mean() / PI - 1.0).abs()));
    eprintln!(
        "white hills: {off:.1e} off, residual {:.1e}",
        light.report.residual
    );
    assert!(off < 1e-4, "{off}");
    assert!(
        light.report.balance.error() < 1e-3,
        "{:?}",
        light.report.balance
    );
}
