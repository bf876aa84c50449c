//! Previews: a watched solution converges, and watching does not change it.

use crate::rooms::on_threads;
use azulejo_radiosity::{
    Engine, FirstPass, LightSolution, PatchSize, Preview, PreviewStage, solve, solve_watched,
};
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_scene::{Object, Rgb, Scene, Shape};
use azulejo_trace::{Measure, Progress, Tracer};
use std::thread;
use std::time::Duration;

fn pass() -> FirstPass {
    FirstPass {
        engine: Engine::Rays,
        size: PatchSize::Count(200),
        error: Some(0.02),
        ..FirstPass::default()
    }
}

fn measures(progress: &Progress) -> Vec<Measure> {
    progress.take_measures().iter().map(|m| m.measure).collect()
}

fn check_measures(pass: &FirstPass) {
    let (scene, progress) = (cornell_box(CornellVariant::Diffuse), Progress::new());
    let report = solve(&scene, &Tracer::new(&scene), pass, &progress)
        .unwrap()
        .report;
    let measures = measures(&progress);
    let mut residuals: Vec<(u32, u32, f64)> = measures
        .iter()
        .filter_map(|m| match *m {
            Measure::Residual {
                replicate,
                iteration,
                value,
            } => Some((replicate, iteration, value)),
            _ => None,
        })
        .collect();
    // Replicates may take their bounces together.
    residuals.sort_by_key(|residual| residual.0);
    let solutions: Vec<_> = residuals.chunk_by(|a, b| a.0 == b.0 && a.1 < b.1).collect();
    assert!(solutions.len() >= 4, "{} solutions", solutions.len());
    for solution in &solutions {
        let [first, .., last] = solution else {
            panic!("one bounce: {solution:?}")
        };
        assert!(last.2 < 1e-2 * first.2, "{solution:?}");
    }
    let last = (0..4).map(|replicate| solutions.iter().rfind(|s| s[0].0 == replicate).unwrap());
    let worst = last.map(|s| s[s.len() - 1].2).fold(0.0, f64::max);
    assert_eq!(worst, report.residual);
    let patches = measures.iter().rev().find_map(|m| match m {
        Measure::PatchError(error) => Some(*error),
        _ => None,
    });
    assert_eq!(patches, Some(report.patch_error));
    assert_eq!(measures.last(), Some(&Measure::Error(report.error)));
}

#[test]
fn a_solution_leaves_a_falling_residual_and_its_error() {
    let pass = FirstPass {
        error: Some(0.04),
        ..pass()
    };
    check_measures(&pass);
    let shot = FirstPass { memory: 0, ..pass };
    check_measures(&shot);
}

fn watched(scene: &Scene, pass: &FirstPass, watch: &mut dyn FnMut(Preview)) -> LightSolution {
    solve_watched(scene, &Tracer::new(scene), pass, &Progress::new(), watch).unwrap()
}

/// Irradiance of all vertices, mean of the channels.
fn values(scene: &Scene) -> Vec<f64> {
    let of_object = |o: &Object| match &o.shape {
        Shape::Mesh(mesh) => mesh.irradiance.iter().map(|e| e.mean()).collect(),
        _ => Vec::new(),
    };
    scene.objects.iter().flat_map(of_object).collect()
}

/// The first preview is within `most` of the final light, mean over the vertices, relative.
fn check_previews(scene: &Scene, pass: &FirstPass, most: f64) {
    let mut previews = Vec::new();
    let light = watched(scene, pass, &mut |preview| previews.push(preview));
    let plain = solve(scene, &Tracer::new(scene), pass, &Progress::new()).unwrap();
    assert_eq!(plain, light, "watching has changed the light");
    let first = &previews[0];
    assert_eq!(first.stage, PreviewStage::Patches);
    assert!(first.error > 0.0 && first.error < 1.0, "{}", first.error);
    let on = |irradiance| {
        let mut lit = scene.clone();
        lit.set_irradiance(irradiance);
        lit.validate().unwrap();
        values(&lit)
    };
    let (seen, last) = (on(first.irradiance.clone()), on(light.irradiance));
    assert_eq!(seen.len(), last.len());
    let mean = last.iter().sum::<f64>() / last.len() as f64;
    let off = |(a, b): (&f64, &f64)| (a - b).abs();
    let off = seen.iter().zip(&last).map(off).sum::<f64>() / last.len() as f64;
    assert!(off < most * mean, "the preview is {off} off, of {mean}");
}

#[test]
fn previews_show_the_light_and_do_not_change_it() {
    let scene = cornell_box(CornellVariant::Diffuse);
    // The light varies strongly between few patches: the difference halves with four times as many.
    check_previews(&scene, &pass(), 0.3);
    let finer = FirstPass {
        size: PatchSize::Count(1_600),
        error: None,
        rays: Some(64),
        ..pass()
    };
    check_previews(&scene, &finer, 0.1);
    let kept = FirstPass {
        keep_mesh: true,
        ..finer
    };
    check_previews(&scene, &kept, 0.15);
}

#[test]
fn rounds_of_the_gather_are_shown_too() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let fine = FirstPass {
        error: Some(0.01),
        ..pass()
    };
    let mut errors = Vec::new();
    let light = watched(&scene, &fine, &mut |preview| {
        if preview.stage == PreviewStage::Vertices {
            errors.push(preview.error);
        }
    });
    let better = errors.iter().all(|&e| e > light.report.error);
    assert!(
        better && !errors.is_empty(),
        "{errors:?} before {}",
        light.report.error
    );
}

#[test]
fn failed_solutions_have_no_previews() {
    let mut dark = cornell_box(CornellVariant::Diffuse);
    dark.materials
        .iter_mut()
        .for_each(|m| m.emission = Rgb::BLACK);
    let tracer = Tracer::new(&dark);
    let mut shown = 0;
    let result = solve_watched(&dark, &tracer, &pass(), &Progress::new(), &mut |_| {
        shown += 1
    });
    assert!(result.is_err());
    assert_eq!(shown, 0);
}

#[test]
fn a_paused_solution_continues_to_the_same_light() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let tracer = Tracer::new(&scene);
    let plain = solve(&scene, &tracer, &pass(), &Progress::new()).unwrap();
    let progress = Progress::new();
    progress.pause();
    let paused = thread::scope(|scope| {
        // A pool of its own: threads shared by all tests must not sleep.
        let solve = || solve(&scene, &tracer, &pass(), &progress).unwrap();
        let solver = scope.spawn(move || on_threads(2, solve));
        for _ in 0..3 {
            thread::sleep(Duration::from_millis(30));
            assert!(!solver.is_finished(), "it does not wait");
            progress.resume();
            progress.pause();
        }
        progress.resume();
        solver.join().unwrap()
    });
    assert_eq!(paused, plain);
}
