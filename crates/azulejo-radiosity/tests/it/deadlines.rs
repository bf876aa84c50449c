//! What is said early of goals out of reach, and errors that are no smaller than what is missing.

use crate::rooms::*;
use azulejo_radiosity::{Engine, FirstPass, Method, PatchSize, Report, SolveError, probe, solve};
use azulejo_scene::Scene;
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_trace::{Measure, Progress, Tracer};
use std::time::{Duration, Instant};

fn pass(error: f64, rays: Option<u32>) -> FirstPass {
    FirstPass {
        size: PatchSize::Count(300),
        error: Some(error),
        rays,
        ..FirstPass::default()
    }
}

/// Solves until a goal is said to be out of reach, or to the end; returns how often the error was measured before, with
/// the seconds and rays that the goal would take.
fn warnings(pass: &FirstPass, allowed: Option<Duration>) -> Vec<(usize, f64, f64)> {
    let scene = cornell_box(CornellVariant::Diffuse);
    let progress = Progress::new();
    if let Some(allowed) = allowed {
        progress.set_deadline(Instant::now() + allowed);
    }
    let (mut passes, mut found) = (0, Vec::new());
    let mut look = || {
        for measured in progress.take_measures() {
            match measured.measure {
                Measure::Error(_) => passes += 1,
                Measure::OutOfReach {
                    seconds,
                    rays,
                    error,
                } => {
                    assert_eq!(Some(error), pass.error);
                    found.push((passes, seconds, rays));
                    progress.cancel();
                }
                _ => {}
            }
        }
    };
    let solved = std::thread::scope(|scope| {
        let solving = scope.spawn(|| solve(&scene, &Tracer::new(&scene), pass, &progress));
        while !solving.is_finished() {
            look();
            std::thread::sleep(Duration::from_millis(5));
        }
        solving.join().unwrap()
    });
    look();
    assert!(matches!(solved, Ok(_) | Err(SolveError::Cancelled)));
    found
}

#[test]
fn goals_out_of_reach_are_said_after_the_first_pass() {
    // With few rays.
    let found = warnings(&pass(0.002, Some(256)), None);
    assert!(
        matches!(found[..], [(0, seconds, rays)] if seconds > 0.0 && rays > 300.0),
        "{found:?}"
    );
    // With little time.
    let found = warnings(&pass(0.000_01, None), Some(Duration::from_secs(60)));
    assert!(
        matches!(found[..], [(0, seconds, _)] if seconds > 60.0),
        "{found:?}"
    );
    // What is within reach is not mentioned.
    assert_eq!(warnings(&pass(0.2, Some(4096)), None), []);
    assert_eq!(
        warnings(&pass(0.2, None), Some(Duration::from_secs(600))),
        []
    );
}

/// Points know their side: where there is no time for patches, no paths are spent on them.
#[test]
fn probes_take_what_time_there_is() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let points = [at(100.0, 0.0, 100.0, glam::DVec3::Y)];
    let tracer = Tracer::new(&scene);
    let plenty = probe(
        &scene,
        &tracer,
        &points,
        &pass(0.01, None),
        &Progress::new(),
    );
    let truth = plenty.unwrap().estimates[0];
    let progress = Progress::new();
    progress.set_deadline(Instant::now() + Duration::from_millis(400));
    let many = FirstPass {
        size: PatchSize::Count(100_000),
        ..pass(0.01, None)
    };
    match probe(&scene, &tracer, &points, &many, &progress) {
        Err(SolveError::OutOfTime) => {}
        Err(other) => panic!("{other}"),
        Ok(found) => {
            let e = found.estimates[0];
            let off = (e.value - truth.value).map(f64::abs).max_channel();
            let error = e.error.max_channel() + truth.error.max_channel();
            assert!(off < 4.0 * error, "{off} {error} {:?}", found.report.method);
        }
    }
}

fn solved(scene: &Scene, pass: &FirstPass) -> Report {
    let tracer = Tracer::new(scene);
    let light = solve(scene, &tracer, pass, &Progress::new());
    light.unwrap().report
}

/// All methods estimate how uncertain their balance is.
#[test]
fn balances_have_standard_errors() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let few = FirstPass {
        size: PatchSize::Count(300),
        rays: Some(64),
        ..FirstPass::default()
    };
    let particles = FirstPass {
        engine: Engine::Particles,
        ..few.clone()
    };
    let shot = FirstPass {
        memory: 0,
        ..few.clone()
    };
    let traced = FirstPass {
        engine: Engine::Rays,
        ..few
    };
    for (pass, method) in [
        (traced, Method::Matrix),
        (shot, Method::Stochastic),
        (particles, Method::Stochastic),
    ] {
        let report = solved(&scene, &pass);
        assert_eq!(report.method, method);
        let (off, error) = (report.balance.error(), report.balance_error);
        eprintln!("{method:?}: {off:.5} with a standard error of {error:.5}");
        assert!(error.is_finite() && error < 0.05, "{report:?}");
    }
}

/// Faces that coincide all count what one of them absorbs: the balance is off, and the light is not.
/// Nor is it where light is on its way, because bounces are limited.
#[test]
fn only_light_that_is_missing_is_an_error() {
    let mut scene = cornell_box(CornellVariant::Diffuse);
    let twins: Vec<_> = scene.objects[..3].to_vec();
    scene.objects.extend(twins);
    let report = solved(&scene, &pass(0.05, Some(1024)));
    let beyond = report.balance.error() - report.balance_error;
    assert!(
        beyond > 0.1,
        "the balance shows nothing: {:?}",
        report.balance
    );
    assert!(report.error <= 0.05, "{report:?}");
    let limited = FirstPass {
        bounces: Some(1),
        ..pass(0.05, Some(1024))
    };
    let report = solved(&cornell_box(CornellVariant::Diffuse), &limited);
    assert!(
        report.balance.error() > 0.1 && report.error < 0.1,
        "light on its way is not missing: {report:?}"
    );
}
