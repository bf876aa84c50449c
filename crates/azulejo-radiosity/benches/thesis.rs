//! Radiosity of a closed box with a ball lamp, a panel of mirrors and four bodies, 12,922 facets:
//! seconds, and the error of B against a converged reference.
//!
//! `cargo bench -p azulejo-radiosity --bench thesis [-- mirrors [error in % [reference error in
//! % [patches [MiB for rows]]]]]`, by default 64 mirrors, 0.1, 0.03, the facets as they are, and 4,096 MiB. The reference has another seed and comes from the
//! same code: it checks convergence, and the estimated errors; independent truths are in the tests.

#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

#[path = "../../azulejo-factors/benches/usage/mod.rs"]
mod usage;

use azulejo_radiosity::{FirstPass, PatchRadiosity, PatchSize, radiosity};
use azulejo_scene::Scene;
use azulejo_scene::synthetic::cornell_thesis;
use azulejo_trace::{Progress, Tracer};
use std::time::Instant;
use usage::{cpu_seconds, peak_mebibytes};

fn main() {
    let numbers: Vec<f64> = std::env::args()
        .skip(1)
        .filter_map(|a| a.parse().ok())
        .collect();
    let number = |k: usize, default: f64| numbers.get(k).copied().unwrap_or(default);
    let scene = cornell_thesis(number(0, 64.0) as usize);
    let (error, fine) = (0.01 * number(1, 0.1), 0.01 * number(2, 0.03));
    let threads = rayon::current_num_threads();
    println!("asked for {}%, {threads} threads", 100.0 * error);
    let pass = |error: f64, seed: u64| FirstPass {
        size: match number(3, 0.0) as usize {
            0 => PatchSize::Edge(0.0),
            count => PatchSize::Count(count),
        },
        error: Some(error),
        seed,
        memory: (number(4, 4096.0) as u64) << 20,
        ..FirstPass::default()
    };
    let found = run("found", &scene, &pass(error, 1));
    println!("{:.0} MiB at most", peak_mebibytes());
    let reference = run("reference", &scene, &pass(fine, 2));
    compare(&found, &reference);
}

fn run(what: &str, scene: &Scene, pass: &FirstPass) -> PatchRadiosity {
    let (wall, cpu) = (Instant::now(), cpu_seconds());
    let tracer = Tracer::new(scene);
    let found = radiosity(scene, &tracer, pass, &Progress::new()).expect("a lamp shines");
    let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu_seconds() - cpu);
    let report = &found.report;
    println!(
        "{what}: {} patches, {wall:.1} s, {cpu:.1} CPU s, {:.1} M rays, {:.2} M rays/s, {} rows refined, error of B said {:.4}%",
        report.patches,
        report.patch_rays as f64 * 1e-6,
        report.patch_rays as f64 * 1e-6 / wall,
        report.refined_rows,
        100.0 * report.patch_error
    );
    found
}

/// Errors of reflected radiosity over fronts that reflect, weighted by area: relative to each
/// patch's own (at least a tenth of the mean), and to the mean square of all.
fn compare(found: &PatchRadiosity, reference: &PatchRadiosity) {
    let patches = &found.patches;
    let emits = |p: usize| reference.sides[2 * p].value.max_channel() > 20.0;
    let fronts: Vec<usize> = (0..patches.len())
        .filter(|&p| reference.sides[2 * p].value.max_channel() > 0.0 && !emits(p))
        .collect();
    let area: f64 = fronts.iter().map(|&p| patches.area(p)).sum();
    let value = |p: usize| reference.sides[2 * p].value.mean();
    let mean = fronts
        .iter()
        .map(|&p| value(p) * patches.area(p))
        .sum::<f64>()
        / area;
    let off = |p: usize| (found.sides[2 * p].value - reference.sides[2 * p].value).mean();
    let rms = |of: &dyn Fn(usize) -> f64| {
        let sum: f64 = fronts
            .iter()
            .map(|&p| of(p).powi(2) * patches.area(p))
            .sum();
        (sum / area).sqrt()
    };
    let own = |p: usize| off(p) / value(p).max(0.1 * mean);
    println!(
        "error of B, patch by patch: RMS {:.4}%, mean {:.4}%, max {:.3}%; RMS over RMS of B: {:.4}%",
        100.0 * rms(&own),
        100.0 * fronts.iter().map(|&p| own(p).abs()).sum::<f64>() / fronts.len() as f64,
        100.0 * fronts.iter().map(|&p| own(p).abs()).fold(0.0, f64::max),
        100.0 * rms(&off) / rms(&value),
    );
    let sigma = |p: usize| {
        let errors = [found, reference].map(|f| f.sides[2 * p].error.mean());
        errors[0].hypot(errors[1])
    };
    let covered = fronts
        .iter()
        .filter(|&&p| off(p).abs() <= 2.0 * sigma(p))
        .count();
    println!(
        "within two of their standard errors: {:.1}% of {} patches",
        100.0 * covered as f64 / fronts.len() as f64,
        fronts.len()
    );
}
