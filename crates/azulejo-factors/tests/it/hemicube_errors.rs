//! Errors of form factors by hemicubes: of single entries, and of their sums.

use crate::scenes::{cube, surface};
use azulejo_factors::{
    Closure, Engine, FormFactorOptions, FormFactors, Hemicube, PatchSize, form_factors,
};
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_scene::{Object, Primitive, Scene, Shape};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};

fn compute(scene: &Scene, patches: usize, engine: &Engine, analytic: bool) -> FormFactors {
    let options = FormFactorOptions {
        engine: engine.clone(),
        size: PatchSize::Count(patches),
        rays: 1 << 13,
        closure: Closure::Never,
        analytic,
        ..FormFactorOptions::default()
    };
    form_factors(scene, &Tracer::new(scene), &options, &Progress::new()).expect("nobody cancels")
}

fn by_object(factors: &FormFactors, objects: usize) -> FormFactors {
    let groups: Vec<Option<u32>> = factors.faces.iter().map(|f| Some(f.object)).collect();
    factors.grouped(&groups, objects)
}

/// Form factors below this may fall between the pixels of all hemicubes.
const SMALLEST: f64 = 1e-5;

/// Differences between two matrices in their common standard errors, for entries that are
/// significant in the second.
fn distances(a: &FormFactors, b: &FormFactors) -> Vec<f64> {
    let mut distances = Vec::new();
    for i in 0..a.len() {
        for j in i..a.len() {
            let (x, y) = (a.exchange.get(i, j), b.exchange.get(i, j));
            let error = f64::from(x.error.hypot(y.error));
            if y.value > SMALLEST * a.areas[i].max(a.areas[j]) {
                distances.push((x.value - y.value).abs() / error);
            }
        }
    }
    distances
}

fn share_within(distances: &[f64], most: f64) -> f64 {
    let within = distances.iter().filter(|&&d| d <= most).count();
    within as f64 / distances.len() as f64
}

/// The errors of pieces seen by one hemicube are correlated, so that the sum over a wall errs more
/// than independent pieces would.
#[test]
fn engines_agree_on_whole_objects() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let objects = scene.objects.len();
    let computed = |engine: Engine| by_object(&compute(&scene, 300, &engine, true), objects);
    let drawn = computed(Engine::Hemicube(Hemicube::default()));
    let others = [computed(Engine::Rays), computed(Engine::Analytic)];
    let [rays, exact] = &others;
    for (names, a, b) in [
        ("hemicube and rays", &drawn, rays),
        ("hemicube and analytic", &drawn, exact),
        ("rays and analytic", rays, exact),
    ] {
        let distances = distances(a, b);
        let worst = distances.iter().copied().fold(0.0, f64::max);
        let within = share_within(&distances, 2.0);
        eprintln!(
            "{names}: at most {worst:.2}, {:.1}% within 2",
            100.0 * within
        );
        assert!(worst <= 4.0, "{names}: {worst}");
        assert!(within >= 0.9, "{names}: {within}");
    }
}

/// A cube with one mirror wall, and a sheet in it that hides one half from the other.
fn mirror_room() -> Scene {
    let mirror = |k: usize| if k == 2 { 0.9 } else { 0.0 };
    let mut scene = cube(std::array::from_fn(|k| surface(0.05, mirror(k), 0.0)));
    let sheet = Primitive::parallelogram(dvec3(0.3, 0.3, 0.5), 0.5 * DVec3::X, 0.4 * DVec3::Y, 0);
    let sheet = Object::new("sheet", Shape::Primitive(sheet));
    scene.objects.push(sheet);
    scene
}

#[test]
fn standard_errors_of_hemicubes_are_honest() {
    let box_of_cornell = cornell_box(CornellVariant::Diffuse);
    // By formulas, images in the mirror take most of the time.
    for (what, scene, patches) in [("box", box_of_cornell, 200), ("mirror", mirror_room(), 100)] {
        let known = compute(&scene, patches, &Engine::Analytic, true);
        let options = Hemicube::default();
        for engine in [Engine::Hemicube(options.clone()), Engine::Hybrid(options)] {
            let drawn = compute(&scene, patches, &engine, false);
            let distances = distances(&drawn, &known);
            let shares = [2.0, 4.0].map(|most| share_within(&distances, most));
            let (name, entries) = (&drawn.engine_used.name, distances.len());
            eprintln!("{what}, {name}: {shares:?} of {entries}");
            assert!(shares[0] >= 0.9 && shares[1] >= 0.99, "{name}: {shares:?}");
        }
    }
}
