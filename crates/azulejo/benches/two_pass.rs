//! Two passes against brute force: what a picture costs either way, for the same error.
//!
//! `cargo bench -p azulejo --bench two_pass`. For each scene one truth by `reference` with many
//! samples; then the two passes and the reference at several costs, each with its CPU seconds and
//! its relative RMSE against that truth. The last column is the time that the reference would take
//! for the error of the line: its error falls with the root of its time.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo::radiosity::{self, FirstPass};
use azulejo::render::{self, FinalGather, ReferencePass, SecondPass};
use azulejo::scene::synthetic::{CornellVariant, cornell_box};
use azulejo::scene::{Image, Scene};
use azulejo::trace::{Progress, Tracer};
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike;

/// Pixels along the picture's edges.
const SIZE: (u32, u32) = (96, 96);

/// Samples per pixel of what is taken for the truth.
const TRUTH: u32 = 8192;

/// Samples per pixel of the reference that is timed.
const TIMED: u32 = 64;

fn main() {
    println!(
        "{:<8} {:<50} {:>8} {:>8} {:>12}",
        "scene", "how", "CPU s", "RMSE", "reference s"
    );
    for (name, variant) in [
        ("matt", CornellVariant::Diffuse),
        ("mirror", CornellVariant::MirrorBlock),
        ("glossy", CornellVariant::Glossy),
    ] {
        measure(name, &cornell_box(variant));
    }
}

/// CPU seconds of this process so far, all threads.
fn cpu() -> f64 {
    let usage = getrusage(UsageWho::RUSAGE_SELF).expect("the system tells what we used");
    (usage.user_time() + usage.system_time()).num_microseconds() as f64 * 1e-6
}

/// What work gives, and what it took.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let begin = cpu();
    let result = work();
    (result, cpu() - begin)
}

fn by_reference(scene: &Scene, samples: u32, seed: u64) -> render::MeasuredImage {
    let options = ReferencePass {
        size: SIZE,
        samples_per_pixel: samples,
        seed,
        ..ReferencePass::default()
    };
    let tracer = Tracer::new(scene);
    let progress = Progress::new();
    render::reference(scene, &tracer, &scene.cameras[0], &options, &progress)
        .expect("nobody cancels")
}

fn measure(name: &str, scene: &Scene) {
    let truth = by_reference(scene, TRUTH, 1);
    let (noisy, cost) = timed(|| by_reference(scene, TIMED, 2).image);
    let noise = render::relative_rmse(&noisy, &truth.image);
    let line = |how: String, cpu: f64, error: f64, equal: f64| {
        println!("{name:<8} {how:<50} {cpu:>8.2} {error:>8.4} {equal:>12.1}");
    };
    let known = truth.relative_error();
    line(format!("truth, {TRUTH} samples"), f64::NAN, known, f64::NAN);
    line(format!("reference, {TIMED} samples"), cost, noise, cost);
    let (unknown, uneven) = (FinalGather::Unknown, FinalGather::Uneven(16));
    for (patches, gather, samples) in [
        (1_500, unknown, 64),
        (10_000, unknown, 64),
        (1_500, uneven, 64),
        (1_500, FinalGather::Everywhere(64), 16),
    ] {
        let (image, cpu) = timed(|| two_passes(scene, patches, gather, samples));
        let error = render::relative_rmse(&image, &truth.image);
        let gathers = match gather {
            FinalGather::Unknown => String::new(),
            FinalGather::Uneven(rays) => format!(", gather {rays} where uneven"),
            FinalGather::Everywhere(rays) => format!(", gather {rays}"),
        };
        let how = format!("two passes, {patches} patches, {samples} samples{gathers}");
        line(how, cpu, error, cost * (noise / error).powi(2));
    }
}

fn two_passes(scene: &Scene, patches: usize, gather: FinalGather, samples: u32) -> Image {
    let first = FirstPass {
        size: azulejo::factors::PatchSize::Count(patches),
        ..FirstPass::default()
    };
    let second = SecondPass {
        size: SIZE,
        samples_per_pixel: samples,
        gather,
        ..SecondPass::default()
    };
    let progress = Progress::new();
    let mut lit = scene.clone();
    let light = radiosity::solve(&lit, &Tracer::new(&lit), &first, &progress);
    lit.set_irradiance(light.expect("there is light").irradiance);
    let (tracer, camera) = (Tracer::new(&lit), &scene.cameras[0]);
    render::render(&lit, &tracer, camera, &second, &progress).expect("nobody cancels")
}
