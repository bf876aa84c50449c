//! Time of the second pass alone: a Cornell-like room of 10,000 patches, 256 × 256 pixels, 16
//! samples each.
//!
//! Prints seconds of one thread, the best of five runs: CPU seconds on Linux, wall-clock
//! seconds elsewhere. An argument selects the cases whose name contains it.

#[path = "../tests/it/gallery.rs"]
mod gallery;

use azulejo_render::{FinalGather, SecondPass, render};
use azulejo_scene::{Camera, Material, Rgb, Scene};
use azulejo_trace::{Progress, Tracer};
use std::time::SystemTime;

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("a pool of one thread").install(|| {
        let (mut scene, eye) = gallery::gallery(45);
        report("mirror and glass", &scene, &eye, FinalGather::Unknown);
        report(
            "final gather, 16 rays",
            &scene,
            &eye,
            FinalGather::Everywhere(16),
        );
        for material in &mut scene.materials[4..] {
            *material = Material::diffuse("matt", Rgb::grey(0.7));
        }
        report("matt", &scene, &eye, FinalGather::Unknown);
    });
}

#[allow(clippy::print_stdout)] // The output of the benchmark.
fn report(name: &str, scene: &Scene, eye: &Camera, gather: FinalGather) {
    let wanted = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    if wanted.is_some_and(|w| !name.contains(&w)) {
        return;
    }
    let options = SecondPass {
        size: (256, 256),
        samples_per_pixel: if gather == FinalGather::Unknown {
            16
        } else {
            1
        },
        gather,
        ..SecondPass::default()
    };
    let tracer = Tracer::new(scene);
    let seconds = (0..5).map(|_| {
        let start = now();
        render(scene, &tracer, eye, &options, &Progress::new()).expect("nobody cancels");
        now() - start
    });
    let best = seconds.fold(f64::INFINITY, f64::min);
    let samples = 256.0 * 256.0 * f64::from(options.samples_per_pixel);
    println!(
        "{name}: {best:.3} s, {:.0} ns per sample",
        best / samples * 1e9
    );
}

/// CPU seconds of this thread; wall-clock seconds where the system does not report them.
fn now() -> f64 {
    let ran = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = ran.and_then(|line| line.split(' ').next()?.parse::<f64>().ok());
    let clock = || {
        SystemTime::UNIX_EPOCH
            .elapsed()
            .map_or(0.0, |t| t.as_secs_f64())
    };
    nanoseconds.map_or_else(clock, |ns| ns * 1e-9)
}
