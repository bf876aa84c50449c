//! Rows and solution of a furnished room: `cargo bench -p azulejo-radiosity --bench room
//! [-- patches rays]`, by default 10,000 patches of 4,096 rays each.

#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

#[path = "../../azulejo-factors/benches/usage/mod.rs"]
mod usage;

use azulejo_factors::estimator::Estimator;
use azulejo_factors::row::Columns;
use azulejo_factors::{Engine, PatchSize, Patches, reflectances};
use azulejo_radiosity::system::System;
use azulejo_scene::synthetic::furnished_room;
use azulejo_trace::{Gatherer, Progress, Run, Surfaces, Tracer};
use std::time::Instant;
use usage::{cpu_seconds, peak_mebibytes};

fn main() {
    let mut numbers = std::env::args()
        .skip(1)
        .filter_map(|a| a.parse::<u32>().ok());
    let (patches, rays) = (
        numbers.next().unwrap_or(10_000),
        numbers.next().unwrap_or(4_096),
    );
    let scene = furnished_room(14_500);
    let threads = rayon::current_num_threads();
    let (wall, cpu) = (Instant::now(), cpu_seconds());
    let tracer = Tracer::new(&scene);
    let patches = Patches::new(&scene, PatchSize::Count(patches as usize));
    let reflectance = reflectances(&scene, &patches);
    let gatherer = Gatherer::new(Surfaces::new(&scene, &tracer));
    let prepared = wall.elapsed().as_secs_f64();
    let progress = Progress::new();
    let estimator = Estimator::new(
        &Engine::Rays,
        &gatherer,
        &patches,
        rays,
        1,
        Columns::Diffuse,
    );
    let system = System::trace(
        &gatherer,
        &patches,
        &reflectance,
        &estimator,
        1,
        Run::alone(&progress),
    )
    .expect("nobody cancels")
    .expect("there is no deadline");
    let traced = wall.elapsed().as_secs_f64();
    let found = system.solve_all(None).expect("nobody cancels");
    let solved = wall.elapsed().as_secs_f64();
    let cpu = cpu_seconds() - cpu;
    let count = patches.len() as f64;
    println!(
        "{} triangles, {count} patches, {rays} rays each, {threads} threads",
        tracer.item_count()
    );
    println!(
        "prepare {prepared:.2} s, rows {:.2} s, solve {:.2} s; {cpu:.2} CPU s",
        traced - prepared,
        solved - traced
    );
    println!(
        "{:.0} patches/s, {:.2} M rays/s",
        count / traced,
        found.rays as f64 / (traced - prepared) * 1e-6
    );
    println!(
        "{:.0} bytes/patch of rows, {:.0} MiB at most in all",
        found.bytes as f64 / count,
        peak_mebibytes()
    );
    println!(
        "{} bounces, residual {:.1e}, balance off by {:.3}%",
        found.convergence.iterations,
        found.convergence.residual,
        100.0 * found.balance.error()
    );
}
