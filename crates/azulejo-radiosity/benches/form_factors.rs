//! Form factors against known truths, and what a room of 10,000 patches costs.
//!
//! `cargo bench -p azulejo-radiosity --bench form_factors [-- rays]`.

// Printing is what a bench is for.
#![allow(clippy::print_stdout)]

mod usage;

use azulejo_radiosity::truth::{Kind, cases};
use azulejo_radiosity::{FormFactorOptions, FormFactors, PatchSize, form_factors};
use azulejo_scene::Scene;
use azulejo_scene::synthetic::furnished_room;
use azulejo_trace::{Progress, Tracer};
use std::time::Instant;
use usage::{cpu_seconds, peak_mebibytes};

fn main() {
    let rays = std::env::args()
        .skip(1)
        .find_map(|a| a.parse().ok())
        .unwrap_or(4_096);
    truths();
    room(rays);
}

/// Every pair of polygons: by rays alone, and with formulas.
fn truths() {
    println!(
        "{:15} {:>14}   by 65,536 rays{:21} with formulas",
        "case", "truth", ""
    );
    for case in cases().iter().filter(|c| c.kind != Kind::Curved) {
        print!("{:15} {:14.11}", case.id, case.truth.value);
        for analytic in [false, true] {
            let options = options(1 << 16, analytic);
            let tracer = Tracer::new(&case.scene);
            let found = case.ask(&tracer, &options, &Progress::new());
            let (found, _) = found.expect("there are surfaces");
            let (f, error) = (found.value, found.error);
            let off = (f - case.truth.value) / error;
            print!("   {f:.9} ± {error:.1e} {off:+6.2} SE");
        }
        println!();
    }
}

fn options(rays: u32, analytic: bool) -> FormFactorOptions {
    FormFactorOptions {
        size: PatchSize::Edge(0.0),
        rays,
        analytic,
        ..FormFactorOptions::default()
    }
}

fn compute(scene: &Scene, options: &FormFactorOptions) -> FormFactors {
    form_factors(scene, &Tracer::new(scene), options, &Progress::new()).expect("there are surfaces")
}

fn room(rays: u32) {
    let scene = furnished_room(14_500);
    for analytic in [false, true] {
        let (wall, cpu) = (Instant::now(), cpu_seconds());
        let found = compute(&scene, &options(rays, analytic));
        let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu_seconds() - cpu);
        let (n, entries) = (found.len() as f64, found.exchange.entries() as f64);
        let mean = |v: &[f64]| v.iter().sum::<f64>() / n;
        println!(
            "\nroom, {n} patches, {rays} rays each, formulas {analytic}\n\
             {wall:.2} s wall, {cpu:.2} s CPU, {:.0} patches/s, {:.2e} rays/s\n\
             {:.0} entries a row, {:.0} bytes a patch, peak {:.0} MiB\n\
             row error {:.4}, correction {:.3}, closed {}, escaped {:.1e}",
            n / wall,
            found.rays as f64 / wall,
            entries / n,
            found.exchange.bytes() as f64 / n,
            peak_mebibytes(),
            mean(&found.row_errors),
            found.closed.map_or(0.0, |m| m.total),
            found.is_closed,
            found.rest.iter().map(|r| r.escaped()).sum::<f64>() / n,
        );
    }
}
