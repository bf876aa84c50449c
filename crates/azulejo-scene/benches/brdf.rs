//! What it costs to evaluate and to sample each reflection model.
//!
//! `cargo bench -p azulejo-scene --bench brdf -- [part of a name]`. One thread; each figure is the
//! least of several repetitions, which other work on the machine disturbs the least. An
//! evaluation is of a pair of directions near each other's mirrored ones, where lobes are; a
//! sample brings its weight and its density, and so evaluates all lobes, too.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo_scene::brdf::{Brdf, MODELS};
use glam::DVec3;
use std::hint::black_box;
use std::time::Instant;

/// Pairs of directions, and numbers to sample with.
const COUNT: usize = 1000;

const REPETITIONS: usize = 15;

fn main() {
    let filter = std::env::args().skip(1).find(|word| !word.starts_with('-'));
    println!("{:>10} {:>10} {:>10}", "make µs", "eval ns", "sample ns");
    for text in MODELS.iter().flat_map(|m| m.examples) {
        if filter.as_ref().is_none_or(|w| text.contains(w.as_str())) {
            measure(text);
        }
    }
}

fn measure(text: &str) {
    let make = || Brdf::new(text.parse().expect("an example is a description")).expect("a model");
    let made = make();
    let directions: Vec<DVec3> = (0..COUNT).map(direction).collect();
    let evaluate = || {
        for pair in directions.windows(2) {
            let mirrored = DVec3::new(-pair[0].x, -pair[0].y, pair[0].z);
            let wi = (0.8 * mirrored + 0.2 * pair[1]).normalize();
            black_box(made.eval(pair[0], wi));
        }
    };
    let sample = || {
        for (k, wo) in directions.iter().enumerate() {
            let u = [0.618, 0.755, 0.57].map(|step| (0.5 + k as f64 * step).fract());
            black_box(made.sample(*wo, u));
        }
    };
    let made_in = least(&|| {
        black_box(make());
    });
    println!(
        "{:10.0} {:10.0} {:10.0}  {text}",
        1e6 * made_in,
        1e9 * least(&evaluate) / COUNT as f64,
        1e9 * least(&sample) / COUNT as f64
    );
}

/// Seconds of the fastest repetition.
fn least(work: &dyn Fn()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..REPETITIONS).map(time).fold(f64::INFINITY, f64::min)
}

/// Directions spread over the hemisphere, with density cos θ/π.
fn direction(k: usize) -> DVec3 {
    let u = (k as f64 + 0.5) / COUNT as f64;
    let (sin, cos) = (k as f64 * 2.399_963).sin_cos();
    DVec3::new(u.sqrt() * cos, u.sqrt() * sin, (1.0 - u).sqrt())
}
