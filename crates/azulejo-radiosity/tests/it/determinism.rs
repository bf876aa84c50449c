//! Bit-identical results for any number of threads; cancellation and deadlines.

use crate::rooms::*;
use azulejo_factors::Engine;
use azulejo_radiosity::{Estimate, FirstPass, LightSolution, PatchSize, SolveError, probe, solve};
use azulejo_scene::Scene;
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_trace::run::{CountedBlocks, together};
use azulejo_trace::{Blocks, Progress, Run, Tracer};
use std::time::{Duration, Instant};

fn pass() -> FirstPass {
    FirstPass {
        size: PatchSize::Count(300),
        ..rays(128)
    }
}

fn solved(scene: &Scene, pass: &FirstPass, threads: usize) -> LightSolution {
    on_threads(threads, || {
        solve(scene, &Tracer::new(scene), pass, &Progress::new()).unwrap()
    })
}

/// Matrix and shooting, with given rays and with an error to reach.
#[test]
fn threads_do_not_matter() {
    let scene = cornell_box(CornellVariant::MirrorBlock);
    let by_error = FirstPass {
        rays: None,
        error: Some(0.05),
        ..pass()
    };
    for pass in [
        pass(),
        FirstPass {
            memory: 0,
            ..pass()
        },
        by_error,
    ] {
        let alone = solved(&scene, &pass, 1);
        for threads in [2, 5] {
            assert!(
                solved(&scene, &pass, threads) == alone,
                "{threads} threads, {pass:?}"
            );
        }
    }
}

/// Checks that processes that share some work all get what one process gets, and that all items of its loops are
/// computed once, by several of them.
fn check_shared<T: PartialEq + Send + Sync>(
    what: &str,
    whole: &T,
    work: impl Fn(&dyn Blocks) -> T + Sync,
) {
    let (mut alone, mut most_busy) = (None, 0);
    for processes in [2, 5] {
        let found = together(processes, |blocks| {
            let blocks = CountedBlocks::new(blocks);
            (work(&blocks), blocks.items())
        });
        assert!(
            found.iter().all(|(found, _)| found == whole),
            "{what}: {processes} processes"
        );
        let items: usize = found.iter().map(|(_, items)| items).sum();
        assert_eq!(items, *alone.get_or_insert(items), "{what}: {processes}");
        let busy = found.iter().filter(|(_, items)| *items > 0).count();
        most_busy = most_busy.max(busy);
    }
    // One may be so quick that others find nothing left, but hardly each time.
    assert!(most_busy > 1, "{what}");
}

/// To an error and by rays, with many bounces and few, by matrix and shooting, and at points.
#[test]
fn processes_do_not_matter() {
    let scene = cornell_box(CornellVariant::MirrorBlock);
    let tracer = Tracer::new(&scene);
    let pass = || FirstPass {
        size: PatchSize::Count(60),
        ..rays(64)
    };
    let by_error = FirstPass {
        rays: None,
        error: Some(0.03),
        ..pass()
    };
    let limited = FirstPass {
        bounces: Some(2),
        ..pass()
    };
    let shooting = FirstPass {
        memory: 0,
        ..pass()
    };
    for pass in [&pass(), &by_error, &limited, &shooting] {
        // Each of several processes keeps a part of the matrix.
        let without_bytes = |mut found: LightSolution| {
            found.report.bytes = 0;
            found
        };
        let whole = solve(&scene, &tracer, pass, &Progress::new()).unwrap();
        let whole = without_bytes(whole);
        check_shared(&format!("{pass:?}"), &whole, |blocks| {
            let progress = Progress::new();
            let found = solve(&scene, &tracer, pass, Run::new(blocks, &progress));
            without_bytes(found.unwrap())
        });
    }
    let scene = cube([0; 6].map(|_| surface(0.5, 0.2, 1.0)));
    let (tracer, points) = (Tracer::new(&scene), points_on_cube(100));
    let whole = probe(&scene, &tracer, &points, &by_error, &Progress::new()).unwrap();
    check_shared("points", &whole.estimates, |blocks| {
        let progress = Progress::new();
        let run = Run::new(blocks, &progress);
        let found = probe(&scene, &tracer, &points, &by_error, run);
        found.unwrap().estimates
    });
}

#[test]
fn threads_do_not_matter_to_probes() {
    let scene = cube([0; 6].map(|_| surface(0.5, 0.2, 1.0)));
    let found = [1, 2, 5].map(|threads| {
        let tracer = Tracer::new(&scene);
        on_threads(threads, || {
            probe(
                &scene,
                &tracer,
                &points_on_cube(50),
                &pass(),
                &Progress::new(),
            )
            .unwrap()
        })
    });
    assert!(found[0] == found[1] && found[1] == found[2]);
}

/// Rows of the analytic engine are computed in groups, and solvers request as many at a time as
/// there are threads.
#[test]
fn threads_do_not_matter_to_formulas() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let pass = FirstPass {
        engine: Engine::Analytic,
        ..pass()
    };
    let alone = solved(&scene, &pass, 1);
    for threads in [2, 3, 8] {
        assert!(solved(&scene, &pass, threads) == alone, "{threads} threads");
    }
}

#[test]
fn another_seed_is_other_noise() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let [a, b] = [1, 1 << 40].map(|seed| solved(&scene, &FirstPass { seed, ..pass() }, 2));
    assert!(a.irradiance != b.irradiance);
}

/// Far more work than a test can wait for.
fn endless() -> FirstPass {
    FirstPass {
        size: PatchSize::Count(20_000),
        ..rays(1 << 16)
    }
}

#[test]
fn cancelling_ends_at_once() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let tracer = Tracer::new(&scene);
    for memory in [u64::MAX, 0] {
        let progress = Progress::new();
        let (result, waited) = std::thread::scope(|s| {
            let pass = FirstPass {
                memory,
                ..endless()
            };
            let (progress, scene, tracer) = (&progress, &scene, &tracer);
            let work = s.spawn(move || solve(scene, tracer, &pass, progress));
            std::thread::sleep(Duration::from_millis(300));
            let told = Instant::now();
            progress.cancel();
            (work.join().unwrap(), told.elapsed())
        });
        eprintln!("cancelled after {waited:?}");
        assert_eq!(result.unwrap_err(), SolveError::Cancelled);
        assert!(waited < Duration::from_secs(100), "{waited:?}");
    }
}

/// Out of time, the result is rough, and its error says so.
#[test]
fn a_deadline_ends_in_good_order() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let tracer = Tracer::new(&scene);
    let pass = FirstPass {
        size: PatchSize::Count(1000),
        error: Some(1e-4),
        ..FirstPass::default()
    };
    let progress = Progress::new();
    let begin = Instant::now();
    progress.set_deadline(begin + Duration::from_secs(6));
    let points: Vec<_> = (0..40)
        .map(|k| {
            at(
                14.0 * f64::from(k),
                0.0,
                13.0 * f64::from(k),
                glam::DVec3::Y,
            )
        })
        .collect();
    let found = on_threads(2, || probe(&scene, &tracer, &points, &pass, &progress)).unwrap();
    let took = begin.elapsed();
    eprintln!(
        "deadline of 6 s: {took:?}, error {:.1e}",
        found.report.error
    );
    assert!(took < Duration::from_secs(100), "{took:?}");
    assert!(found.report.error > 1e-4, "{}", found.report.error);
    let truth = irradiance(
        &scene,
        &points,
        &FirstPass {
            size: PatchSize::Count(1000),
            ..rays(1 << 12)
        },
    );
    let sum = |all: &[Estimate]| all.iter().map(|e| e.value.mean()).sum::<f64>();
    let ratio = sum(&found.estimates) / sum(&truth);
    let agrees = |(a, b): (&Estimate, &Estimate)| {
        (a.value.mean() - b.value.mean()).abs() <= 3.0 * (a.error.mean() + b.error.mean()) + 1e-3
    };
    let share = found
        .estimates
        .iter()
        .zip(&truth)
        .filter(|&pair| agrees(pair))
        .count();
    assert!(
        (ratio - 1.0).abs() < 0.15 && share >= 34,
        "ratio {ratio}, {share} of 40 agree"
    );
}
