//! Adaptive refinement: rows that dominate the error get more rays, until it is reached.

use crate::rooms::*;
use azulejo_radiosity::{Engine, FirstPass, PatchRadiosity, PatchSize, radiosity};
use azulejo_scene::Scene;
use azulejo_scene::synthetic::{CornellVariant, cornell_box, cornell_thesis_at};
use azulejo_trace::{Progress, Tracer};
use std::time::{Duration, Instant};

fn solved(scene: &Scene, pass: &FirstPass, progress: &Progress) -> PatchRadiosity {
    radiosity(scene, &Tracer::new(scene), pass, progress).unwrap()
}

fn asked(error: f64, seed: u64) -> FirstPass {
    FirstPass {
        engine: Engine::Rays,
        error: Some(error),
        size: PatchSize::Count(500),
        seed,
        ..FirstPass::default()
    }
}

/// Root mean square difference of the reflected light of two solutions relative to the second, and
/// the share of patches within two of their common standard errors.
fn compare(scene: &Scene, a: &PatchRadiosity, b: &PatchRadiosity) -> (f64, f64) {
    let patches = &a.patches;
    let is_lamp = |p: usize| scene.materials[patches.material(p) as usize].is_emitter();
    let (mut errors, mut squares, mut inside, mut count) = (0.0, 0.0, 0.0, 0.0);
    for p in (0..patches.len()).filter(|&p| !is_lamp(p)) {
        let (x, y) = (a.sides[2 * p], b.sides[2 * p]);
        let off = (x.value - y.value).mean();
        errors += patches.area(p) * off * off;
        squares += patches.area(p) * y.value.mean().powi(2);
        let sigma = x.error.mean().hypot(y.error.mean());
        inside += f64::from(u8::from(off.abs() <= 2.0 * sigma + 1e-12));
        count += 1.0;
    }
    ((errors / squares).sqrt(), inside / count)
}

#[track_caller]
fn check_error(name: &str, scene: &Scene, error: f64) {
    let found = solved(scene, &asked(error, 1), &Progress::new());
    let truth = solved(scene, &asked(0.25 * error, 2), &Progress::new());
    let (off, inside) = compare(scene, &found, &truth);
    let report = &found.report;
    eprintln!(
        "{name}: asked {error}, said {:.5}, is {off:.5}, {:.1}% within 2 SE, {} rows refined, {} rays",
        report.patch_error,
        100.0 * inside,
        report.refined_rows,
        report.patch_rays
    );
    assert!(report.refined_rows > 0 && truth.report.patch_rays > 2 * report.patch_rays);
    assert!(report.patch_error < 1.4 * error, "{}", report.patch_error);
    assert!(off < 1.5 * error, "{off} off, {error} asked");
    assert!(inside > 0.9, "{inside} of the patches are within 2 SE");
}

#[test]
fn the_requested_error_is_reached_and_reported() {
    check_error("box", &cornell_box(CornellVariant::Diffuse), 0.005);
    check_error("mirror", &cornell_box(CornellVariant::MirrorBlock), 0.005);
}

#[test]
fn mirrors_in_a_crowd_are_refined_too() {
    let scene = cornell_thesis_at(64, 0.05);
    check_error("panel of mirrors", &scene, 0.02);
}

/// In a furnace every row is exact, and refinement must preserve that.
#[test]
fn a_furnace_stays_exact() {
    let scene = cube([0; 6].map(|_| surface(0.5, 0.3, 1.0)));
    let pass = FirstPass {
        size: PatchSize::Count(96),
        ..asked(1e-7, 1)
    };
    let pass = FirstPass {
        rays: Some(512),
        ..pass
    };
    let found = solved(&scene, &pass, &Progress::new());
    for p in 0..found.patches.len() {
        let b = found.sides[2 * p].value.mean();
        assert!((b - 3.5).abs() < 1e-5, "B = {b} instead of 3.5");
    }
}

#[test]
fn refinement_does_not_depend_on_threads() {
    let scene = cornell_box(CornellVariant::MirrorBlock);
    let on = |threads: usize| {
        on_threads(threads, || {
            solved(&scene, &asked(0.01, 3), &Progress::new())
        })
    };
    let (one, three) = (on(1), on(3));
    assert!(one.sides == three.sides && one.report == three.report);
}

#[test]
fn a_deadline_ends_refinement_in_good_order() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let progress = Progress::new();
    let start = Instant::now();
    progress.set_deadline(start + Duration::from_secs(8));
    let found = on_threads(2, || solved(&scene, &asked(1e-5, 1), &progress));
    let seconds = start.elapsed().as_secs_f64();
    assert!(seconds < 100.0, "{seconds} s");
    let error = found.report.patch_error;
    assert!(error > 1e-5 && error < 0.1, "{error}");
}
