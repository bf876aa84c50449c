//! Form factors against known truths, and the cost of a room of 10,000 patches.
//!
//! `cargo bench -p azulejo-factors --bench form_factors [-- rays]`.

// Printing is what a bench is for.
#![allow(clippy::print_stdout)]

// The cases of `azulejo validate`; of their reader, benches need but a part.
#[allow(dead_code, unused_imports)]
#[path = "../../azulejo-cli/src/known/factors/mod.rs"]
mod cases;
mod usage;

use azulejo_factors::form_factors::{Exchange, ExchangeAreas, RowRemainder};
use azulejo_factors::{FormFactorOptions, FormFactors, PatchSize, form_factors};
use azulejo_scene::Scene;
use azulejo_scene::synthetic::furnished_room;
use azulejo_trace::{Progress, Tracer};
use cases::{CaseKind, cases};
use std::time::Instant;
use usage::{cpu_seconds, peak_mebibytes};

fn main() {
    if std::env::args().any(|a| a == "dense") {
        return dense(20_000);
    }
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
    for case in cases().iter().filter(|c| c.kind != CaseKind::Curved) {
        print!("{:15} {:14.11}", case.id, case.truth.value);
        for analytic in [false, true] {
            let options = options(1 << 16, analytic);
            let tracer = Tracer::new(&case.scene);
            let factor = case.ask(&tracer, &options, &Progress::new());
            let (factor, _) = factor.expect("there are surfaces");
            let (f, error) = (factor.value, factor.error);
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
        let factors = compute(&scene, &options(rays, analytic));
        let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu_seconds() - cpu);
        let (n, entries) = (factors.len() as f64, factors.exchange.entries() as f64);
        let mean = |v: &[f64]| v.iter().sum::<f64>() / n;
        println!(
            "\nroom, {n} patches, {rays} rays each, formulas {analytic}\n\
             {wall:.2} s wall, {cpu:.2} s CPU, {:.0} patches/s, {:.2e} rays/s\n\
             {:.0} entries a row, {:.0} bytes a patch, peak {:.0} MiB\n\
             row error {:.4}, correction {:.3}, closed {}, escaped {:.1e}",
            n / wall,
            factors.rays as f64 / wall,
            entries / n,
            factors.exchange.bytes() as f64 / n,
            peak_mebibytes(),
            mean(&factors.row_errors),
            factors.closed.map_or(0.0, |m| m.total),
            factors.is_closed,
            factors.rest.iter().map(|r| r.escaped()).sum::<f64>() / n,
        );
    }
}

/// A sphere from inside, with the noise of rays: S_ij = A_i A_j / A, off by up to 2%.
fn dense(n: usize) {
    let share = 1.0 / (n * n) as f64;
    let noise = |i: usize, j: usize| {
        let mixed = (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (j as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        (mixed.wrapping_mul(0xd6e8_feb8_6659_fd93) >> 40) as f64 / f64::from(1 << 24) - 0.5
    };
    let entry = |i: usize, j: usize| Exchange {
        column: j as u32,
        value: share * (1.0 + 0.04 * noise(i, j)),
        error: (0.02 * share) as f32,
    };
    let mut exchange = ExchangeAreas::new();
    let start = Instant::now();
    (0..n).for_each(|i| exchange.push_row((i..n).map(|j| entry(i, j))));
    let mut factors = FormFactors {
        exchange,
        areas: vec![1.0 / n as f64; n],
        rest: vec![RowRemainder::default(); n],
        ends: vec![1.0; n],
        ..FormFactors::default()
    };
    let report = |what: &str, start: Instant| {
        let seconds = start.elapsed().as_secs_f64();
        println!("{what}: {seconds:.1} s, peak {:.0} MiB", peak_mebibytes());
    };
    let pairs = factors.exchange.pairs();
    report(&format!("{n} patches, {pairs} pairs made"), start);
    let start = Instant::now();
    factors.close(&Progress::new()).expect("nobody cancels");
    report(&format!("closed, {:?}", factors.closed), start);
    let start = Instant::now();
    let blocks = factors.blocks();
    let sum: f64 = blocks
        .iter()
        .flat_map(|b| factors.rows(b.clone()))
        .flatten()
        .map(|(_, x, _)| x)
        .sum();
    report(
        &format!("whole rows in {} blocks, sum {sum:.6}", blocks.len()),
        start,
    );
}
