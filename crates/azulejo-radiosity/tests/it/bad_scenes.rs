//! Odd and impossible scenes: no panic, no hang, no NaN.

use crate::rooms::*;
use azulejo_radiosity::{
    FirstPass, LightSolution, PatchSize, PointNormal, SolveError, probe, solve,
};
use azulejo_scene::brdf::Description;
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_scene::{
    Brdf, LightKind, Material, Mesh, Object, ObjectIrradiance, Primitive, Rgb, Scene, Shape,
};
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DVec3, dvec3};

fn run(scene: &Scene, pass: &FirstPass) -> Result<LightSolution, SolveError> {
    solve(scene, &Tracer::new(scene), pass, &Progress::new())
}

fn small() -> FirstPass {
    FirstPass {
        size: PatchSize::Count(200),
        ..rays(64)
    }
}

fn values(light: &LightSolution) -> Vec<Rgb> {
    let of = |o: &ObjectIrradiance| match o {
        ObjectIrradiance::Vertices {
            irradiance, error, ..
        } => [&irradiance[..], error].concat(),
        ObjectIrradiance::Refined(mesh) => [&mesh.irradiance[..], &mesh.irradiance_error].concat(),
        ObjectIrradiance::Surface(s) => [&s.irradiance[..], &s.error].concat(),
    };
    light.irradiance.objects.iter().flat_map(of).collect()
}

/// Solves by both methods; all values are finite and not negative.
#[track_caller]
fn check_sane(what: &str, scene: &Scene) {
    check_sane_with(what, scene, &small());
}

#[track_caller]
fn check_sane_with(what: &str, scene: &Scene, pass: &FirstPass) {
    for memory in [u64::MAX, 0] {
        for keep_mesh in [false, true] {
            let light = run(
                scene,
                &FirstPass {
                    memory,
                    keep_mesh,
                    ..pass.clone()
                },
            )
            .unwrap();
            let bad = values(&light)
                .into_iter()
                .find(|e| !e.is_finite() || e.r < 0.0 || e.g < 0.0 || e.b < 0.0);
            assert_eq!(bad, None, "{what}");
            assert!(
                light.report.error.is_finite() && light.report.residual.is_finite(),
                "{what}"
            );
            assert!(
                light.report.balance.error().is_finite(),
                "{what}: {:?}",
                light.report.balance
            );
        }
    }
}

#[test]
fn nothing_to_solve() {
    let mut scene = Scene::default();
    assert_eq!(run(&scene, &small()).unwrap_err(), SolveError::NoLight);
    let kind = LightKind::Ambient {
        radiance: Rgb::WHITE,
    };
    scene.lights.push(azulejo_scene::Light {
        name: "sky".into(),
        kind,
    });
    assert_eq!(run(&scene, &small()).unwrap_err(), SolveError::NoSurface);
    add_sheet(
        &mut scene,
        DVec3::ZERO,
        DVec3::X,
        DVec3::ZERO,
        surface(0.5, 0.0, 0.0),
    );
    assert_eq!(run(&scene, &small()).unwrap_err(), SolveError::NoSurface);
    let dark = cube([0; 6].map(|_| surface(0.5, 0.0, 0.0)));
    assert_eq!(run(&dark, &small()).unwrap_err(), SolveError::NoLight);
}

#[test]
fn faces_without_area() {
    let mut scene = cornell_box(CornellVariant::MirrorBlock);
    for material in [
        surface(0.5, 0.0, 0.0),
        surface(0.0, 0.9, 0.0),
        surface(0.0, 0.0, 5.0),
    ] {
        add_sheet(
            &mut scene,
            dvec3(9.0, 9.0, 9.0),
            DVec3::ZERO,
            DVec3::ZERO,
            material.clone(),
        );
        add_sheet(
            &mut scene,
            dvec3(9.0, 9.0, 9.0),
            50.0 * DVec3::X,
            DVec3::ZERO,
            material.clone(),
        );
        add_sheet(
            &mut scene,
            dvec3(9.0, 9.0, 9.0),
            50.0 * DVec3::X,
            1e-9 * DVec3::Y,
            material,
        );
    }
    check_sane("no area", &scene);
}

#[test]
fn twice_the_same_place() {
    let mut scene = cornell_box(CornellVariant::Diffuse);
    let again = scene.objects.clone();
    scene.objects.extend(again);
    check_sane("twice", &scene);
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 1.0)));
    let mut reversed = scene.objects[0].clone();
    if let Shape::Mesh(mesh) = &mut reversed.shape {
        mesh.faces.corners.reverse();
    }
    scene.objects.push(reversed);
    // A face that coincides with another may take what both are due, so that light grows.
    for memory in [u64::MAX, 0] {
        match run(&scene, &FirstPass { memory, ..small() }) {
            Ok(light) => assert!(values(&light).iter().all(|e| e.is_finite()), "opposed"),
            Err(error) => assert!(matches!(error, SolveError::Endless(_)), "{error}"),
        }
    }
}

/// A room of walls that are there twice, of a wide gloss over a diffuse base.
fn double_glossy_room(ks: f64, kd: f64, emission: f64) -> Scene {
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 1.0)));
    let parameters = [("n", 0.0.into()), ("ks", ks.into()), ("kd", kd.into())];
    let brdf = Brdf::new(Description::model("blinn", parameters)).unwrap();
    let brdf = std::sync::Arc::new(brdf);
    for material in &mut scene.materials {
        *material = Material {
            emission: Rgb::grey(emission),
            ..Material::with_brdf("", brdf.clone())
        };
    }
    let mut reversed = scene.objects[0].clone();
    if let Shape::Mesh(mesh) = &mut reversed.shape {
        mesh.faces.corners.reverse();
    }
    scene.objects.push(reversed);
    scene
}

/// Gloss with an exponent of 0 is diffuse, and a closed room that emits 1 has irradiance π/(1 − ρ). Samples by half
/// vectors gave this room light that grew without end, because few of them brought most of it.
#[test]
fn wide_gloss_between_double_walls_is_solved() {
    let scene = double_glossy_room(0.7, 0.2, 1.0);
    let light = run(&scene, &small()).unwrap();
    let expected = std::f64::consts::PI / 0.1;
    let ObjectIrradiance::Refined(mesh) = &light.irradiance.objects[0] else {
        panic!("{:?}", light.irradiance.objects[0]);
    };
    let mean = mesh.irradiance.iter().map(|e| e.mean()).sum::<f64>() / mesh.irradiance.len() as f64;
    assert!((mean / expected - 1.0).abs() < 0.03, "{mean}, {expected}");
}

/// Light that grows beyond the numbers of rays is not refined: that gave NaN, and 0% as its error.
#[test]
fn light_that_grows_is_refused() {
    let pass = FirstPass {
        error: Some(0.01),
        ..small()
    };
    let grown = run(&double_glossy_room(0.8, 0.19, 1e37), &pass);
    assert!(matches!(grown, Err(SolveError::Endless(1..))), "{grown:?}");
}

#[test]
fn huge_tiny_and_far() {
    for (scale, shift) in [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e5)] {
        let mut scene = cornell_box(CornellVariant::MirrorBlock);
        for object in &mut scene.objects {
            let Shape::Mesh(mesh) = &mut object.shape else {
                continue;
            };
            mesh.positions
                .iter_mut()
                .for_each(|p| *p = *p * scale + DVec3::splat(shift));
        }
        check_sane(&format!("scale {scale}, shift {shift}"), &scene);
    }
}

#[test]
fn flat_primitives() {
    let mut scene = cornell_box(CornellVariant::Diffuse);
    let material = scene.add_material(surface(0.3, 0.3, 1.0));
    for kind in [
        azulejo_scene::PrimitiveKind::Sphere,
        azulejo_scene::PrimitiveKind::Cylinder,
        azulejo_scene::PrimitiveKind::Cuboid,
    ] {
        let map = DAffine3::from_scale_rotation_translation(
            dvec3(50.0, 50.0, 1e-7),
            glam::DQuat::IDENTITY,
            dvec3(100.0, 300.0, 100.0),
        );
        scene.objects.push(Object::new(
            "flat",
            Shape::Primitive(Primitive::new(kind, map, material)),
        ));
    }
    check_sane("flat primitives", &scene);
}

#[test]
fn mirrors_and_glass_alone() {
    let mirrors = cube(std::array::from_fn(|k| {
        surface(0.0, 1.0, f64::from(k == 0))
    }));
    // Every ray continues to the limit of a thousand mirrors.
    check_sane_with("mirrors", &mirrors, &rays(16));
    let mut scene = Scene::default();
    let glass = scene.add_material(Material::dielectric("glass", 1.5));
    scene.objects.push(Object::new(
        "ball",
        Shape::Primitive(Primitive::sphere(DVec3::ZERO, 1.0, glass)),
    ));
    let kind = LightKind::Point {
        position: DVec3::ZERO,
        intensity: Rgb::WHITE,
    };
    scene.lights.push(azulejo_scene::Light {
        name: "bulb".into(),
        kind,
    });
    check_sane("a bulb in a glass ball", &scene);
}

#[test]
fn black_surfaces_receive() {
    let scene = cube(std::array::from_fn(|k| {
        surface(0.0, 0.0, f64::from(k == 1))
    }));
    check_sane("black", &scene);
    let e = irradiance(&scene, &[at(0.5, 0.5, 0.0, DVec3::Z)], &small())[0];
    let ceiling = [
        dvec3(0., 0., 1.),
        dvec3(0., 1., 1.),
        dvec3(1., 1., 1.),
        dvec3(1., 0., 1.),
    ];
    let truth = azulejo_trace::lambert::point_to_polygon(dvec3(0.5, 0.5, 0.0), DVec3::Z, &ceiling);
    assert!(
        (e.value.mean() - truth).abs() < 1e-12,
        "{e:?}, truth {truth}"
    );
}

/// What leaves an open scene is reported: a lamp over nothing loses everything.
#[test]
fn open_scenes_lose_light() {
    let mut scene = Scene::default();
    add_sheet(
        &mut scene,
        DVec3::ZERO,
        DVec3::X,
        DVec3::Y,
        surface(0.5, 0.0, 1.0),
    );
    for memory in [u64::MAX, 0] {
        let balance = run(&scene, &FirstPass { memory, ..small() })
            .unwrap()
            .report
            .balance;
        assert!((balance.emitted.mean() - 1.0).abs() < 1e-6, "{balance:?}");
        assert!((balance.escaped.mean() - 1.0).abs() < 1e-3, "{balance:?}");
        assert!(balance.error() < 1e-3, "{balance:?}");
    }
}

/// In a closed room that absorbs nothing, light adds up forever: the solver gives up, and reports
/// that it has not converged.
#[test]
fn rooms_that_absorb_nothing() {
    let scene = cube(std::array::from_fn(|k| {
        surface(1.0, 0.0, f64::from(k == 0))
    }));
    for memory in [u64::MAX, 0] {
        let endless = run(&scene, &FirstPass { memory, ..small() });
        assert!(
            matches!(endless, Err(SolveError::Endless(1..))),
            "{endless:?}"
        );
        let limited = FirstPass {
            memory,
            bounces: Some(5),
            ..small()
        };
        let report = run(&scene, &limited).unwrap().report;
        assert!(report.residual > 1e-5, "{report:?}");
    }
}

/// Paths of points in such a room would never end: none is traced to find out what they cost.
#[test]
fn points_in_rooms_that_absorb_nothing() {
    let scene = cube(std::array::from_fn(|k| {
        surface(1.0, 0.0, f64::from(k == 0))
    }));
    let pass = FirstPass {
        size: PatchSize::Count(200),
        error: Some(0.05),
        ..FirstPass::default()
    };
    let middle = scene.bounds().centre();
    let points = [DVec3::Y, DVec3::X].map(|normal| PointNormal {
        position: middle,
        normal,
    });
    let found = probe(
        &scene,
        &Tracer::new(&scene),
        &points,
        &pass,
        &Progress::new(),
    );
    assert!(matches!(found, Err(SolveError::Endless(1..))), "{found:?}");
}

/// A cavity that absorbs nothing does not darken the rest of a scene, if little light gets into it:
/// the limit of its reflectance is said, with what it absorbs.
#[test]
fn cavities_that_absorb_nothing() {
    for (power, is_solved) in [(1e-3, true), (0.5, false)] {
        let mut scene = cube(std::array::from_fn(|k| {
            surface(0.5, 0.0, f64::from(k == 0))
        }));
        let mut cavity = cube(std::array::from_fn(|k| {
            surface(1.0, 0.0, if k == 0 { power } else { 0.0 })
        }));
        for object in &mut cavity.objects {
            if let Shape::Mesh(mesh) = &mut object.shape {
                mesh.transform(&DAffine3::from_translation(10.0 * DVec3::X));
            }
        }
        let alone = run(&scene, &small()).unwrap();
        scene.merge(cavity);
        for memory in [u64::MAX, 0] {
            let found = run(&scene, &FirstPass { memory, ..small() });
            if !is_solved {
                assert!(matches!(found, Err(SolveError::Endless(1..))), "{found:?}");
                continue;
            }
            let found = found.unwrap();
            let notes = &found.report.engine_used.notes;
            assert!(
                notes.iter().any(|n| n.contains("taken to reflect")),
                "{notes:?}"
            );
            let mean = |light: &LightSolution| {
                let room = &light.irradiance.objects[..alone.irradiance.objects.len()];
                let all = room.iter().flat_map(|o| match o {
                    ObjectIrradiance::Vertices { irradiance, .. } => irradiance.clone(),
                    ObjectIrradiance::Refined(mesh) => mesh.irradiance.clone(),
                    ObjectIrradiance::Surface(s) => s.irradiance.clone(),
                });
                let all: Vec<f64> = all.map(|e| e.mean()).collect();
                all.iter().sum::<f64>() / all.len() as f64
            };
            let (a, b) = (mean(&alone), mean(&found));
            assert!((a / b - 1.0).abs() < 0.1, "{a} {b}");
        }
    }
}

/// Points far outside, or without a normal, get some answer.
#[test]
fn points_that_make_no_sense() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let nan = DVec3::splat(f64::NAN);
    let points = [
        at(f64::NAN, 0.0, 0.0, DVec3::Y),
        at(100.0, 0.0, 100.0, nan),
        at(100.0, 0.0, 100.0, DVec3::ZERO),
        at(1e300, 0.0, f64::INFINITY, DVec3::Y),
        at(100.0, 0.0, 100.0, DVec3::Y),
    ];
    let found = probe(
        &scene,
        &Tracer::new(&scene),
        &points,
        &small(),
        &Progress::new(),
    )
    .unwrap();
    assert!(found.estimates[4].value.is_finite() && found.estimates[4].value.mean() > 0.0);
}

/// A mesh that no light reaches, beside one that is lit.
#[test]
fn a_mesh_in_the_dark() {
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 1.0)));
    let mut far = Mesh {
        positions: vec![dvec3(5., 5., 5.), dvec3(6., 5., 5.), dvec3(5., 6., 5.)],
        ..Mesh::default()
    };
    let grey = scene.add_material(surface(0.5, 0.0, 0.0));
    far.push_face(&[0, 1, 2], grey);
    scene.objects.push(Object::new("far", Shape::Mesh(far)));
    check_sane("dark", &scene);
}
