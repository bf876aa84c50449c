//! The analytic engine on a closed room: `cargo bench -p azulejo-factors --bench analytic
//! [-- facets...]`, by default about 500, 2,000, 5,000 and 20,000.
//!
//! Every row of exact factors sums to 1, so the sums show the error, without closure. Beside it are
//! figures of View3D 4.0 (eps 1e-4, one core, CPU seconds) on such a room.

#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

mod usage;

use azulejo_factors::form_factors::Closure;
use azulejo_factors::{Engine, FormFactorOptions, PatchSize, form_factors};
use azulejo_scene::synthetic::room_with_table;
use azulejo_trace::{Progress, Tracer};
use std::time::Instant;
use usage::{cpu_seconds, peak_mebibytes};

fn main() {
    let mut sizes: Vec<usize> = std::env::args()
        .skip(1)
        .filter_map(|a| a.parse().ok())
        .collect();
    if sizes.is_empty() {
        sizes = vec![500, 2_000, 5_000, 20_000];
    }
    println!("facets   wall s    CPU s  exponent      pairs  peak MiB  row sums: RMS      max");
    let mut before: Option<(f64, f64)> = None;
    for size in sizes {
        let (facets, cpu) = room(size);
        let exponent = before.map(|(n, t)| (cpu / t).ln() / (facets / n).ln());
        println!("         exponent {exponent:.2?}");
        before = Some((facets, cpu));
    }
    println!("View3D: 490 facets 2.4 s, 2,006 facets 22.6 s, 4,992 facets 107.8 s");
}

fn room(size: usize) -> (f64, f64) {
    let scene = room_with_table(size);
    let options = FormFactorOptions {
        engine: Engine::Analytic,
        size: PatchSize::Edge(0.0),
        closure: Closure::Never,
        ..FormFactorOptions::default()
    };
    let (wall, cpu) = (Instant::now(), cpu_seconds());
    let tracer = Tracer::new(&scene);
    let found = form_factors(&scene, &tracer, &options, &Progress::new()).expect("a room");
    let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu_seconds() - cpu);
    let off: Vec<f64> = found.row_sums().iter().map(|s| s - 1.0).collect();
    let rms = (off.iter().map(|d| d * d).sum::<f64>() / off.len() as f64).sqrt();
    let max = off.iter().map(|d| d.abs()).fold(0.0, f64::max);
    println!(
        "{:6} {wall:8.2} {cpu:8.2}            {:9}  {:8.0}       {rms:.2e} {max:.2e}",
        found.len(),
        found.exchange.pairs(),
        peak_mebibytes(),
    );
    found
        .engine_used
        .notes
        .iter()
        .for_each(|n| println!("         {n}"));
    let worst = (0..off.len()).max_by(|&a, &b| off[a].abs().total_cmp(&off[b].abs()));
    println!(
        "         worst row {worst:?}, mean {:.1e}",
        off.iter().sum::<f64>() / off.len() as f64
    );
    (found.len() as f64, cpu)
}
