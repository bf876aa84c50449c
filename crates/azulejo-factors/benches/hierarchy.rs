//! Compressed form factors: memory, time and errors.
//!
//! `cargo bench -p azulejo-factors --bench hierarchy -- WORK FACETS [RAYS] [TOLERANCE]`, with the work
//! `exact` (compress a matrix by formulas), `noisy` (compress one by rays), `rays` (build by rays,
//! against the matrix of the same rays and formulas) or `large` (build by rays alone), each followed by
//! `city`, `room` or `mirrors`: `exact-room 5000`.

// Printing is what a bench is for.
#![allow(clippy::print_stdout)]

mod usage;

use azulejo_factors::form_factors::{Plan, PreparedPlan};
use azulejo_factors::hierarchy::{OperatorError, radiosities};
use azulejo_factors::{
    CompressedFactors, CompressionOptions, Engine, FactorOperator, FormFactorOptions, FormFactors,
    PatchSize, form_factors,
};
use azulejo_scene::Scene;
use azulejo_scene::synthetic::{cornell_thesis_at, cube_array, room_with_table};
use azulejo_trace::{Progress, Tracer};
use std::time::Instant;
use usage::{cpu_seconds, peak_mebibytes};

const TOLERANCES: [f64; 3] = [1e-2, 1e-3, 1e-4];

fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| a != "--bench")
        .collect();
    let Some((work, scene)) = arguments.first().and_then(|a| a.split_once('-')) else {
        return println!("which work? See the top of benches/hierarchy.rs.");
    };
    let number = |k: usize| arguments.get(k).and_then(|a| a.parse::<f64>().ok());
    let facets = number(1).unwrap_or(5_000.0) as usize;
    let options = FormFactorOptions {
        size: PatchSize::Edge(0.0),
        engine: if work == "exact" {
            Engine::Analytic
        } else {
            Engine::Rays
        },
        rays: number(2).unwrap_or(1_024.0) as u32,
        ..FormFactorOptions::default()
    };
    let scene = named(scene, facets);
    match work {
        "exact" | "noisy" => compress(&scene, &options),
        "rays" => rays(&scene, &options),
        _ => large(&scene, &options, number(3).unwrap_or(1e-2)),
    }
}

/// A city of blocks, an open scene; a furnished room; a room with 64 mirrors and a curved lamp.
fn named(name: &str, facets: usize) -> Scene {
    match name {
        // Eight unit squares for each cube.
        "city" => {
            let squares = 8.0 * f64::from(CUBES * CUBES);
            cube_array(CUBES, (facets as f64 / squares).sqrt().round() as u32)
        }
        "mirrors" => cornell_thesis_at(64, facets as f64 / 12_922.0),
        _ => room_with_table(facets),
    }
}

/// Cubes along either side of the city.
const CUBES: u32 = 12;

/// Seconds by the clock and of all threads.
#[derive(Clone, Copy)]
struct Seconds {
    wall: f64,
    cpu: f64,
}

/// What something takes, with its result.
fn timed<T>(work: impl FnOnce() -> T) -> (T, Seconds) {
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let result = work();
    let wall = start.elapsed().as_secs_f64();
    let cpu = cpu_seconds() - cpu;
    (result, Seconds { wall, cpu })
}

/// Seconds of a product with a vector, mean of a few.
fn product_seconds(operator: &dyn FactorOperator) -> f64 {
    let x = vec![1.0; operator.row_areas().len()];
    let products = 5;
    let work = || (0..products).for_each(|_| drop(std::hint::black_box(operator.apply(&x))));
    timed(work).1.wall / f64::from(products)
}

fn compress(scene: &Scene, options: &FormFactorOptions) {
    let tracer = Tracer::new(scene);
    let plan = Plan::new(scene, &tracer, options).expect("there are surfaces");
    let plan = plan.prepare();
    let (full, seconds) = timed(|| whole(scene, &tracer, options));
    describe("full", &full, seconds);
    let places = plan.places();
    for tolerance in TOLERANCES {
        let options = CompressionOptions {
            tolerance,
            keep_sums: true,
        };
        let new = || CompressedFactors::new(&full, &places, &options, &Progress::new());
        let (compressed, seconds) = timed(new);
        let compressed = compressed.expect("a tolerance");
        describe(&format!("{tolerance:e}"), &compressed, seconds);
        structure(&compressed);
        errors(&compressed, &full);
    }
}

fn whole(scene: &Scene, tracer: &Tracer, options: &FormFactorOptions) -> FormFactors {
    form_factors(scene, tracer, options, &Progress::new()).expect("there are surfaces")
}

fn describe(name: &str, operator: &dyn FactorOperator, seconds: Seconds) {
    let n = operator.row_areas().len();
    println!(
        "{name}: {n} rows, {:.1} MB, {:.2} bytes a pair of n², built in {:.2} s wall, {:.2} s CPU, product {:.1} ms, peak {:.0} MiB",
        operator.bytes() as f64 / 1e6,
        operator.bytes() as f64 / (n * n) as f64,
        seconds.wall,
        seconds.cpu,
        1e3 * product_seconds(operator),
        peak_mebibytes(),
    );
}

fn structure(compressed: &CompressedFactors) {
    let ([sparse, dense, low], [mean, most]) = (compressed.kinds(), compressed.deficit);
    println!(
        "   {sparse} sparse, {dense} dense, {low} of low rank; bound {:.1e}; rows scaled by up to {:.1e}, sums off by {mean:.1e} RMS, {most:.1e} at most",
        compressed.bound, compressed.scaled
    );
}

fn errors(compressed: &dyn FactorOperator, exact: &dyn FactorOperator) {
    let OperatorError {
        product,
        worst,
        most_of_sum,
        mean_of_sum,
    } = OperatorError::of(compressed, exact, 4, 1);
    println!(
        "   product {product:.1e}, worst x {worst:.1e}; row sums {mean_of_sum:.1e} RMS, {most_of_sum:.1e} at most"
    );
}

/// Built by rays, beside the matrix by the same number of rays; errors against many rays or formulas.
fn rays(scene: &Scene, options: &FormFactorOptions) {
    let tracer = Tracer::new(scene);
    let has_mirrors = scene.materials.iter().any(|m| m.is_specular());
    let best = FormFactorOptions {
        engine: if has_mirrors {
            Engine::Rays
        } else {
            Engine::Analytic
        },
        rays: 32_768,
        seed: 7,
        ..options.clone()
    };
    let (exact, seconds) = timed(|| whole(scene, &tracer, &best));
    describe("reference", &exact, seconds);
    let (full, seconds) = timed(|| whole(scene, &tracer, options));
    describe("full", &full, seconds);
    errors(&full, &exact);
    light(&full, &exact);
    let plan = Plan::new(scene, &tracer, options).expect("there are surfaces");
    let plan = plan.prepare();
    for tolerance in [0.0, 1e-2, 1e-3] {
        let compressed = built(&plan, tolerance);
        structure(&compressed);
        errors(&compressed, &exact);
        light(&compressed, &exact);
        calibration(&compressed, &exact);
    }
}

fn built(plan: &PreparedPlan, tolerance: f64) -> CompressedFactors {
    let options = CompressionOptions {
        tolerance,
        keep_sums: true,
    };
    let build = || CompressedFactors::from_rays(plan, &options, &Progress::new());
    let (compressed, seconds) = timed(build);
    let compressed = compressed.expect("a tolerance");
    describe(&format!("by rays, {tolerance:e}"), &compressed, seconds);
    compressed
}

/// The error of radiosities: one row in 16 emits, all reflect 0.7.
fn light(compressed: &dyn FactorOperator, exact: &dyn FactorOperator) {
    let n = compressed.row_areas().len();
    let exitance: Vec<f64> = (0..n)
        .map(|i| if i % 1_600 < 100 { 1.0 } else { 0.0 })
        .collect();
    let solve = |operator: &dyn FactorOperator| {
        let ends = (1e-8, 200);
        let work = || radiosities(operator, &exitance, &vec![0.7; n], ends, &Progress::new());
        let (solution, seconds) = timed(work);
        let (solution, iterations) = solution.expect("nobody cancels");
        (solution, iterations, seconds)
    };
    let ((b, iterations, seconds), (truth, ..)) = (solve(compressed), solve(exact));
    let reflected = |k: usize| truth[k] - exitance[k];
    let off: f64 = (0..n).map(|k| (b[k] - truth[k]).powi(2)).sum();
    let whole: f64 = (0..n).map(|k| reflected(k).powi(2)).sum();
    println!(
        "   radiosity: {iterations} iterations, {:.2} s, reflected light off by {:.1e} (RMS over RMS)",
        seconds.wall,
        (off / whole).sqrt()
    );
}

/// Stated over actual errors of a product, and the share within two of them.
fn calibration(compressed: &CompressedFactors, exact: &dyn FactorOperator) {
    let x: Vec<f64> = (0..compressed.len())
        .map(|i| ((i / 100) % 7) as f64)
        .collect();
    let ((y, stated), truth) = (compressed.apply_with_errors(&x), exact.apply(&x));
    let off: Vec<f64> = y.iter().zip(&truth).map(|(y, t)| (y - t).abs()).collect();
    let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let within = off
        .iter()
        .zip(&stated)
        .filter(|(off, stated)| **off <= 2.0 * **stated)
        .count();
    println!(
        "   stated errors of a product {:.2} of the actual ones, {:.1}% within two",
        square(&stated) / square(&off),
        100.0 * within as f64 / off.len() as f64
    );
}

fn large(scene: &Scene, options: &FormFactorOptions, tolerance: f64) {
    let start = Instant::now();
    let tracer = Tracer::new(scene);
    let plan = Plan::new(scene, &tracer, options).expect("there are surfaces");
    let plan = plan.prepare();
    println!(
        "prepared in {:.1} s, peak {:.0} MiB",
        start.elapsed().as_secs_f64(),
        peak_mebibytes()
    );
    let compressed = built(&plan, tolerance);
    structure(&compressed);
    println!(
        "   {:.2e} rays; {:.1} s and {:.0} MiB in all",
        compressed.rays as f64,
        start.elapsed().as_secs_f64(),
        peak_mebibytes()
    );
}
