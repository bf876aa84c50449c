//! Particles from the lights against closed forms and the other engines.

use crate::rooms::*;
use azulejo_factors::Engine;
use azulejo_radiosity::{Estimate, FirstPass, PatchRadiosity, PatchSize, probe, radiosity};
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_scene::{Light, LightKind, Rgb, Scene};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};

fn particles(per_patch: u32, patches: usize) -> FirstPass {
    FirstPass {
        engine: Engine::Particles,
        size: PatchSize::Count(patches),
        ..rays(per_patch)
    }
}

fn solved(scene: &Scene, pass: &FirstPass) -> PatchRadiosity {
    radiosity(scene, &Tracer::new(scene), pass, &Progress::new()).expect("solved")
}

/// Radiosity of the fronts, averaged by area, and the root mean square of deviations from `truth` in
/// standard errors.
fn mean_and_deviation(found: &PatchRadiosity, truth: f64) -> (f64, f64) {
    let (mut sum, mut area, mut squares) = (0.0, 0.0, 0.0);
    let count = found.patches.len();
    for p in 0..count {
        let Estimate { value, error } = found.sides[2 * p];
        sum += value.mean() * found.patches.area(p);
        area += found.patches.area(p);
        squares += ((value.mean() - truth) / error.mean()).powi(2).min(100.0);
    }
    (sum / area, (squares / count as f64).sqrt())
}

/// B = M / (1 − ρ_d / (1 − ρ_s)) in any closed furnace: 2 without mirrors, 3.5 with ρ_s = 0.3.
#[test]
fn furnaces_glow_alike() {
    for (diffuse, mirror, truth) in [(0.5, 0.0, 2.0), (0.5, 0.3, 3.5), (0.8, 0.1, 9.0)] {
        let scene = cube([0; 6].map(|_| surface(diffuse, mirror, 1.0)));
        let found = solved(&scene, &particles(1024, 150));
        let (mean, deviation) = mean_and_deviation(&found, truth);
        let balance = found.report.balance;
        eprintln!(
            "ρ {diffuse} {mirror}: B {mean} of {truth}, {deviation:.2} SE, {} reflections, {balance:?}",
            found.report.iterations
        );
        assert!((mean / truth - 1.0).abs() < 6e-3, "{mean} {truth}");
        // Errors of four replicates are Student's with three degrees: their squares' mean is 3.
        assert!((0.7..2.6).contains(&deviation), "{deviation}");
        assert!(balance.error() < 1e-9, "{balance:?}");
        assert_eq!(found.report.engine_used.name, "particles");
    }
}

/// A cube whose floor emits 1: after one bounce whole walls reflect ρ times their view factors of the
/// floor, 0.19982489569838746 for the ceiling. Later bounces depend on where on the walls light fell,
/// which particles know and whole patches do not.
#[test]
fn a_cube_by_its_closed_form() {
    let (f, rho) = (0.199_824_895_698_387_46, 0.6);
    let scene = cube([0.0, rho, rho, rho, rho, rho].map(|rho| {
        let exitance = if rho == 0.0 { 1.0 } else { 0.0 };
        surface(rho, 0.0, exitance)
    }));
    let pass = FirstPass {
        size: PatchSize::Edge(0.0),
        bounces: Some(1),
        ..particles(1 << 14, 0)
    };
    let found = solved(&scene, &pass);
    for material in 1..6 {
        let truth = rho * if material == 1 { f } else { (1.0 - f) / 4.0 };
        let Estimate { value, error } = found.sides[2 * cube_face(material) as usize];
        let (value, error) = (value.mean(), error.mean());
        eprintln!("wall {material}: {value} ± {error}, {truth}");
        assert!(
            (value - truth).abs() < 6.0 * error + 1e-3 * truth,
            "{value} ± {error}, {truth}"
        );
        assert!((1e-6..0.03 * truth).contains(&error), "{error}");
    }
}

fn lights() -> Vec<(&'static str, LightKind)> {
    let position = dvec3(278.0, 400.0, 279.0);
    let intensity = Rgb::new(1e5, 2e5, 1e5);
    vec![
        (
            "point",
            LightKind::Point {
                position,
                intensity,
            },
        ),
        (
            "spot",
            LightKind::Spot {
                position,
                direction: dvec3(0.2, -1.0, 0.1).normalize(),
                intensity,
                inner: 0.4,
                outer: 0.9,
            },
        ),
        (
            "sun",
            LightKind::Directional {
                direction: dvec3(0.3, -0.3, 1.0).normalize(),
                irradiance: Rgb::grey(3.0),
                half_angle: 0.0,
            },
        ),
        (
            "sky",
            LightKind::Ambient {
                radiance: Rgb::WHITE,
            },
        ),
    ]
}

/// Every kind of light, through the open side of the box and by its mirror, gives what rays from the
/// patches find.
#[test]
fn particles_agree_with_rays() {
    let dark = |variant| {
        let mut scene = cornell_box(variant);
        scene
            .materials
            .iter_mut()
            .for_each(|m| m.emission = Rgb::BLACK);
        scene
    };
    let mut scenes = vec![
        ("lamp", cornell_box(CornellVariant::Diffuse)),
        ("lamp and mirror", cornell_box(CornellVariant::MirrorBlock)),
    ];
    for (name, kind) in lights() {
        let mut scene = dark(CornellVariant::Diffuse);
        scene.lights.push(Light {
            name: name.into(),
            kind,
        });
        scenes.push((name, scene));
    }
    for (name, scene) in scenes {
        // Rays leave out the backs of walls that only the outside lights.
        let by = |engine| {
            let pass = FirstPass {
                engine,
                ..particles(128, 1500)
            };
            let found = solved(&scene, &pass);
            let fronts = || (0..found.sides.len()).step_by(2);
            let power = |s: usize| found.sides[s].value * found.patches.area(s / 2);
            let error =
                |s: usize| (found.sides[s].error.mean() * found.patches.area(s / 2)).powi(2);
            let all: Rgb = fronts().map(power).sum();
            let error: f64 = fronts().map(error).sum();
            (all.mean(), error.sqrt(), found.report.balance)
        };
        let (shot, error, balance) = by(Engine::Particles);
        let (rays, other, emitted) = by(Engine::Rays);
        let error = error.hypot(other);
        eprintln!("{name}: {shot}, rays {rays} ± {error}");
        assert!(
            (shot / rays - 1.0).abs() < 2e-3 + 5.0 * error / rays,
            "{name}: {shot} {rays}"
        );
        assert!(balance.error() < 1e-9, "{name}: {balance:?}");
        if name.starts_with("lamp") {
            let ratio = balance.emitted.mean() / emitted.emitted.mean();
            assert!((ratio - 1.0).abs() < 1e-6, "{name}: emitted {ratio}");
        }
    }
}

/// Half the error, four times the particles; and the same bits whatever the threads.
#[test]
fn particles_stop_at_the_error_and_do_not_depend_on_threads() {
    let scene = cornell_box(CornellVariant::MirrorBlock);
    let solve = |error, threads| {
        let pass = FirstPass {
            error: Some(error),
            rays: None,
            ..particles(0, 200)
        };
        on_threads(threads, || solved(&scene, &pass))
    };
    let (coarse, fine) = (solve(0.2, 1), solve(0.02, 1));
    assert!(
        fine.report.patch_error <= 0.02,
        "{}",
        fine.report.patch_error
    );
    assert!(fine.report.patch_rays > coarse.report.patch_rays);
    assert_eq!(coarse.sides, solve(0.2, 3).sides);
}

/// One bounce: what the lamp lights directly, as rays see it.
#[test]
fn bounces_may_be_limited() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let points = [
        at(278.0, 0.0, 100.0, DVec3::Y),
        at(100.0, 0.0, 400.0, DVec3::Y),
    ];
    for bounces in [1, 2] {
        let by = |engine| {
            let pass = FirstPass {
                engine,
                bounces: Some(bounces),
                ..particles(256, 200)
            };
            let found = probe(
                &scene,
                &Tracer::new(&scene),
                &points,
                &pass,
                &Progress::new(),
            );
            found
                .expect("probed")
                .estimates
                .iter()
                .map(|e| e.value.mean())
                .sum::<f64>()
        };
        let (shot, rays) = (by(Engine::Particles), by(Engine::Rays));
        assert!((shot / rays - 1.0).abs() < 0.02, "{bounces}: {shot} {rays}");
    }
}
