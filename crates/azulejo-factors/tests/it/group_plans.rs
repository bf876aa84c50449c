//! Sums over groups of rows by planned division and samples, against closed forms and explicit divisions.

use crate::scenes::{add_sheet, surface};
use azulejo_factors::estimator::Estimator;
use azulejo_factors::row::{Columns, side};
use azulejo_factors::samples::{RowSamples, SampleCounts};
use azulejo_factors::{
    Closure, Engine, FormFactorOptions, FormFactors, GroupBy, Hemicube, PatchSize, Patches,
    form_factors,
};
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_scene::{Object, Primitive, Scene, Shape};
use azulejo_testing::closed_forms::{on_common_edge, opposed, unit_spheres};
use azulejo_trace::{Gatherer, Progress, Surfaces, Tracer};
use glam::{DVec3, dvec3};

/// A factor with its standard error.
fn entry(matrix: &FormFactors, i: usize, j: usize) -> (f64, f64) {
    let (value, error) = matrix.get(i, j as u32);
    (value, f64::from(error))
}

/// Lengths of the box along x, y and z.
const SIZE: [f64; 3] = [4.0, 3.0, 2.5];

/// A closed box seen from inside: walls of x, y and z, that at 0 before the other.
fn room() -> Scene {
    let mut scene = Scene::default();
    let edges = [0, 1, 2].map(|k| SIZE[k] * DVec3::AXES[k]);
    for k in 0..3 {
        let (normal, u, v) = (edges[k], edges[(k + 1) % 3], edges[(k + 2) % 3]);
        add_sheet(&mut scene, DVec3::ZERO, u, v, surface(0.5, 0.0, 0.0));
        add_sheet(&mut scene, normal, v, u, surface(0.5, 0.0, 0.0));
    }
    scene
}

/// The form factor between two walls of the box.
fn truth(from: usize, to: usize) -> f64 {
    let [a, b] = [from / 2, to / 2];
    if from == to {
        0.0
    } else if a == b {
        opposed(SIZE[(a + 1) % 3], SIZE[(a + 2) % 3], SIZE[a])
    } else {
        on_common_edge(SIZE[3 - a - b], SIZE[b], SIZE[a])
    }
}

fn hemicubes() -> Hemicube {
    Hemicube {
        resolution: Hemicube::GROUP_RESOLUTION,
        ..Hemicube::default()
    }
}

/// The engines that sample.
fn samplers() -> [Engine; 3] {
    let hemicube = hemicubes();
    [
        Engine::Rays,
        Engine::Hemicube(hemicube.clone()),
        Engine::Hybrid(hemicube),
    ]
}

/// What is planned for sums over objects, by the engine alone.
fn planned(engine: &Engine) -> FormFactorOptions {
    FormFactorOptions {
        engine: engine.clone(),
        groups: Some(GroupBy::Object),
        closure: Closure::Never,
        analytic: false,
        ..FormFactorOptions::default()
    }
}

fn by_object(scene: &Scene, options: &FormFactorOptions) -> FormFactors {
    let tracer = Tracer::new(scene);
    let matrix = form_factors(scene, &tracer, options, &Progress::new()).expect("surfaces");
    let groups: Vec<Option<u32>> = matrix.faces.iter().map(|f| Some(f.object)).collect();
    matrix.grouped(&groups, scene.objects.len())
}

#[test]
fn groups_of_a_box_have_their_closed_forms_within_honest_errors() {
    const SEEDS: u64 = 8;
    let scene = room();
    for engine in samplers() {
        let (mut within, mut count, mut squares) = (0, 0, 0.0);
        for seed in 0..SEEDS {
            let options = FormFactorOptions {
                seed,
                ..planned(&engine)
            };
            let matrix = by_object(&scene, &options);
            for (i, j) in (0..6).flat_map(|i| (i + 1..6).map(move |j| (i, j))) {
                let ((factor, error), truth) = (entry(&matrix, i, j), truth(i, j));
                within += usize::from((factor - truth).abs() <= 2.0 * error);
                count += 1;
                squares += (factor / truth - 1.0).powi(2);
            }
        }
        let (share, rms) = (
            f64::from(within as u32) / f64::from(count),
            (squares / f64::from(count)).sqrt(),
        );
        eprintln!("{engine:?}: {share:.3} within 2 errors, RMS {rms:.1e}");
        assert!(share >= 0.9, "{engine:?}: {share}");
        assert!(rms < 1e-3, "{engine:?}: {rms}");
    }
}

#[test]
fn by_default_groups_of_a_box_are_exact() {
    let scene = room();
    for engine in samplers()
        .into_iter()
        .chain([Engine::Analytic, Engine::Auto])
    {
        let options = FormFactorOptions {
            engine,
            groups: Some(GroupBy::Object),
            ..FormFactorOptions::default()
        };
        let matrix = by_object(&scene, &options);
        for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
            let off = (entry(&matrix, i, j).0 - truth(i, j)).abs();
            assert!(off < 1e-6, "{:?}, {i} {j}: {off}", options.engine);
        }
        let note = matrix
            .engine_used
            .notes
            .iter()
            .find(|n| n.contains("sums over 6 groups"));
        assert!(note.is_some(), "{:?}", matrix.engine_used.notes);
    }
}

/// Largest and 95th hundredth of the differences between two matrices, in their common errors.
fn distances(a: &FormFactors, b: &FormFactors) -> [f64; 2] {
    let mut distances = Vec::new();
    for (i, j) in (0..a.len()).flat_map(|i| (i..a.len()).map(move |j| (i, j))) {
        let ((x, s), (y, t)) = (entry(a, i, j), entry(b, i, j));
        // Smaller ones may fall between the pixels of all hemicubes.
        if y > 1e-4 {
            distances.push((x - y).abs() / s.hypot(t).max(1e-9));
        }
    }
    distances.sort_by(f64::total_cmp);
    let at = |share: f64| distances[((distances.len() - 1) as f64 * share) as usize];
    [at(1.0), at(0.95)]
}

#[test]
fn planned_groups_with_shadows_are_those_of_a_fine_division() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let fine = FormFactorOptions {
        engine: Engine::Analytic,
        size: PatchSize::Count(600),
        closure: Closure::Never,
        ..FormFactorOptions::default()
    };
    let known = by_object(&scene, &fine);
    for engine in samplers() {
        let matrix = by_object(&scene, &planned(&engine));
        let [most, most_of_95] = distances(&matrix, &known);
        eprintln!("{engine:?}: at most {most:.1}, 95% within {most_of_95:.1}");
        assert!(
            most < 6.0 && most_of_95 < 2.5,
            "{engine:?}: {most} {most_of_95}"
        );
    }
    let analytic = FormFactorOptions {
        groups: Some(GroupBy::Object),
        ..fine
    };
    let matrix = by_object(&scene, &analytic);
    for (i, j) in (0..matrix.len()).flat_map(|i| (0..matrix.len()).map(move |j| (i, j))) {
        let off = (entry(&matrix, i, j).0 - entry(&known, i, j).0).abs();
        assert!(off < 2e-4, "{i} {j}: {off}");
    }
}

/// Exact spheres, whose facets must not be coarse because nothing else asks for small ones.
#[test]
fn curved_groups_have_their_closed_form() {
    let mut scene = Scene::default();
    let material = scene.add_material(surface(0.5, 0.0, 0.0));
    for x in [0.0, 3.0] {
        let sphere = Primitive::sphere(dvec3(x, 0.0, 0.0), 1.0, material);
        scene
            .objects
            .push(Object::new("sphere", Shape::Primitive(sphere)));
    }
    let truth = unit_spheres(3.0);
    for engine in samplers() {
        let matrix = by_object(&scene, &planned(&engine));
        let (factor, error) = entry(&matrix, 0, 1);
        eprintln!("{engine:?}: {factor:.6} ± {error:.6}, truth {truth:.6}");
        assert!(
            (factor - truth).abs() < 4.0 * error,
            "{engine:?}: {factor} ± {error}"
        );
        assert!(error < 0.02 * truth, "{engine:?}: {error}");
    }
}

#[test]
fn progress_moves_within_a_row_of_many_samples() {
    let scene = room();
    let tracer = Tracer::new(&scene);
    let patches = Patches::new(&scene, PatchSize::Edge(0.0));
    let gatherer = Gatherer::new(Surfaces::new(&scene, &tracer));
    let samples = RowSamples {
        rays: SampleCounts::ByPatch(vec![1 << 14, 4, 4, 4, 4, 8]),
        hemicubes: Some(SampleCounts::ByPatch(vec![64, 4, 4, 4, 4, 8])),
    };
    let sides: Vec<u32> = (0..6).map(|patch| side(patch, true)).collect();
    for engine in samplers() {
        let columns = Columns::All;
        let estimator = Estimator::sampled(&engine, &gatherer, &patches, &samples, 1, columns);
        let progress = Progress::new();
        let rows = estimator.rows(&sides, &progress).expect("nobody cancels");
        let steps: u64 = sides.iter().map(|&side| estimator.steps(side)).sum();
        assert_eq!((steps, progress.done()), (9, 9), "{engine:?}");
        for (row, &side) in rows.iter().zip(&sides) {
            assert_eq!(row.rays, estimator.rays_of(side), "{engine:?}");
            let sum: f64 = row.entries.iter().flatten().map(|e| e.weight.g).sum();
            assert!((sum / 4.0 - 1.0).abs() < 1e-6, "{engine:?}: {sum}");
        }
    }
}
