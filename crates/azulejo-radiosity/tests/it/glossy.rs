//! Rooms with glossy walls: every engine against the others, and narrow gloss against mirrors.

use crate::rooms::*;
use azulejo_factors::Hemicube;
use azulejo_radiosity::{Engine, FirstPass, PatchSize, PointNormal, probe, solve};
use azulejo_scene::brdf::{Brdf, Description};
use azulejo_scene::{Light, LightKind, Material, Rgb, Scene};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};
use std::sync::Arc;

fn glossy(text: &str) -> Material {
    let description: Description = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
    let brdf = Brdf::new(description).unwrap_or_else(|e| panic!("{text}: {e}"));
    Material::with_brdf("glossy", Arc::new(brdf))
}

/// A cube whose floor emits, with that material on the walls x = 0 and y = 1.
fn room(wall: &Material) -> Scene {
    let matt = |rho| surface(rho, 0.0, 0.0);
    let floor = surface(0.5, 0.0, 1.0);
    cube([
        floor,
        matt(0.7),
        wall.clone(),
        matt(0.3),
        matt(0.6),
        wall.clone(),
    ])
}

const POINTS: [PointNormal; 3] = [
    PointNormal {
        position: dvec3(0.3, 0.6, 0.0),
        normal: DVec3::Z,
    },
    PointNormal {
        position: dvec3(1.0, 0.4, 0.7),
        normal: DVec3::NEG_X,
    },
    PointNormal {
        position: dvec3(0.25, 0.7, 1.0),
        normal: DVec3::NEG_Z,
    },
];

/// Irradiance at the points and its standard error.
fn irradiance(scene: &Scene, engine: Engine, rays: u32) -> Vec<(f64, f64)> {
    scene.validate().expect("the test's scene is valid");
    let tracer = Tracer::new(scene);
    let pass = FirstPass {
        engine,
        size: PatchSize::Edge(0.5),
        rays: Some(rays),
        ..FirstPass::default()
    };
    let found = probe(scene, &tracer, &POINTS, &pass, &Progress::new()).unwrap();
    let pair = |e: &azulejo_radiosity::Estimate| (e.value.g, e.error.g);
    found.estimates.iter().map(pair).collect()
}

#[track_caller]
fn assert_alike(found: &[(f64, f64)], expected: &[(f64, f64)], slack: f64, what: &str) {
    for (a, b) in found.iter().zip(expected) {
        let margin = 4.0 * a.1.hypot(b.1) + slack * b.0;
        assert!(
            (a.0 - b.0).abs() < margin,
            "{what}: {found:?}, {expected:?}"
        );
    }
}

#[test]
fn all_engines_agree() {
    let scene = room(&glossy("lewis n = 25 kd = 0.2 ks = (0.6, 0.7, 0.4)"));
    let truth = irradiance(&scene, Engine::Rays, 4096);
    let cubes = Hemicube {
        resolution: 64,
        ..Hemicube::default()
    };
    for (engine, what) in [
        (Engine::Analytic, "analytic"),
        (Engine::Hybrid(cubes.clone()), "hybrid"),
        (Engine::Hemicube(cubes), "hemicube"),
    ] {
        assert_alike(&irradiance(&scene, engine, 1024), &truth, 4e-3, what);
    }
}

/// A lobe of two degrees nearly equals a mirror of its mean reflectance.
#[test]
fn narrow_gloss_is_a_mirror() {
    let text = |m| format!("cook_torrance m = {m} kd = 0.1 F = 0.8");
    let wall = glossy(&text(0.02));
    assert!(wall.glossy().is_some() && wall.mirror.is_black());
    let narrower = glossy(&text(0.004));
    assert!(narrower.glossy().is_none() && !narrower.mirror.is_black());
    let (wide, narrow) = (
        irradiance(&room(&wall), Engine::Rays, 8192),
        irradiance(&room(&narrower), Engine::Rays, 8192),
    );
    assert_alike(&wide, &narrow, 0.01, "two degrees");
}

/// Lights without area reach matt surfaces by way of glossy ones, with and without the matrix.
#[test]
fn beams_by_way_of_gloss() {
    let mut scene = room(&glossy("lewis n = 8 ks = 0.9"));
    scene.materials[0].emission = Rgb::BLACK;
    scene.lights.push(Light {
        name: "lamp".into(),
        kind: LightKind::Point {
            position: dvec3(0.8, 0.2, 0.6),
            intensity: Rgb::WHITE,
        },
    });
    let truth = irradiance(&scene, Engine::Rays, 16384);
    let mut dull = scene.clone();
    for material in &mut dull.materials {
        material.brdf = None;
    }
    let without = irradiance(&dull, Engine::Rays, 4096);
    assert!(truth[1].0 > 1.05 * without[1].0, "{truth:?} {without:?}");
    let tracer = Tracer::new(&scene);
    let shot = FirstPass {
        size: PatchSize::Edge(0.25),
        rays: Some(8192),
        memory: 0,
        ..FirstPass::default()
    };
    let found = probe(&scene, &tracer, &POINTS, &shot, &Progress::new()).unwrap();
    assert_eq!(found.report.method, azulejo_radiosity::Method::Stochastic);
    let pair = |e: &azulejo_radiosity::Estimate| (e.value.g, e.error.g);
    let found: Vec<_> = found.estimates.iter().map(pair).collect();
    assert_alike(&found, &truth, 0.01, "without a matrix");
}

#[test]
fn no_light_is_lost() {
    let scene = room(&glossy("lewis n = 10 kd = 0.3 ks = 0.6"));
    let tracer = Tracer::new(&scene);
    for memory in [1 << 30, 0] {
        let pass = FirstPass {
            size: PatchSize::Edge(0.25),
            rays: Some(4096),
            memory,
            ..FirstPass::default()
        };
        let light = solve(&scene, &tracer, &pass, &Progress::new()).unwrap();
        let rest = light.report.balance.error();
        assert!(rest < 5e-3, "{rest}: {:?}", light.report);
    }
}
