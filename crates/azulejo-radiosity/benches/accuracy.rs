//! Time to error of irradiance at points, on Cornell boxes, against brute force.
//!
//! `cargo bench -p azulejo-radiosity --bench accuracy [-- paths]`. The truth at 500 of 10,000 and of
//! 100,000 points is path traced, by code independent of azulejo's, with `paths` paths per point;
//! its own noise is subtracted from the measured error. Each error is requested with interpolation of
//! indirect light, and without.

#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

mod truth;
#[path = "../../azulejo-factors/benches/usage/mod.rs"]
mod usage;

use azulejo_radiosity::{FirstPass, PointNormal, probe};
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_scene::{Rgb, Scene};
use azulejo_trace::{Progress, Tracer};
use std::time::Instant;
use usage::cpu_seconds;

/// Numbers of points, and the errors requested at them.
const SIZES: [(usize, &[f64]); 2] = [
    (10_000, &[0.05, 0.03, 0.02, 0.015, 0.01]),
    (100_000, &[0.02, 0.01]),
];

/// Points at which the truth is known.
const KNOWN: usize = 500;

fn main() {
    let paths = std::env::args()
        .skip(1)
        .find_map(|a| a.parse().ok())
        .unwrap_or(25_000);
    for (name, variant) in [
        ("s1, diffuse", CornellVariant::Diffuse),
        ("s2, mirror block", CornellVariant::MirrorBlock),
    ] {
        let scene = cornell_box(variant);
        for (points, errors) in SIZES {
            println!("\n{name}: {points} points, truth at {KNOWN} of {paths} paths each");
            measure(&scene, points, errors, paths);
        }
    }
}

fn measure(scene: &Scene, points: usize, errors: &[f64], paths: u32) {
    let brute = truth::Brute::new(scene);
    let every = points / KNOWN;
    let points = brute.points(points, 0x5eed);
    let some: Vec<_> = points.iter().copied().step_by(every).collect();
    let truth = brute.irradiance(&some, paths);
    println!(
        "{:>9} {:>12} {:>7} {:>8} {:>8} {:>9} {:>9} {:>9} {:>8}",
        "asked",
        "interpolated",
        "rays",
        "wall s",
        "cpu s",
        "said",
        "rel RMSE",
        "RMSE/mean",
        "in 2 SE"
    );
    let ways = errors.iter().flat_map(|&e| [(e, true), (e, false)]);
    for (error, interpolate) in ways {
        let asked: Vec<PointNormal> = points
            .iter()
            .map(|&(position, normal)| PointNormal { position, normal })
            .collect();
        let (wall, cpu) = (Instant::now(), cpu_seconds());
        let tracer = Tracer::new(scene);
        let pass = FirstPass {
            error: Some(error),
            interpolate,
            ..FirstPass::default()
        };
        let probed =
            probe(scene, &tracer, &asked, &pass, &Progress::new()).expect("the box has a lamp");
        let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu_seconds() - cpu);
        let mean = truth.iter().map(|t| t.0).sum::<Rgb>() / truth.len() as f64;
        let (mut relative, mut absolute, mut inside, mut n) = (0.0, 0.0, 0, 0);
        for (estimate, (e, variance)) in probed.estimates.iter().step_by(every).zip(&truth) {
            for k in 0..3 {
                let square = (estimate.value[k] - e[k]).powi(2) - variance[k];
                let against = e[k].max(0.1 * mean[k]);
                relative += square / (against * against);
                absolute += square / (mean[k] * mean[k]);
                let two = 2.0 * (estimate.error[k].powi(2) + variance[k]).sqrt();
                inside += u32::from((estimate.value[k] - e[k]).abs() <= two);
                n += 1;
            }
        }
        let rms = |s: f64| (s / f64::from(n)).max(0.0).sqrt() * 100.0;
        println!(
            "{:>8}% {:>11.0}% {:>7} {:>8.3} {:>8.3} {:>8.2}% {:>8.2}% {:>8.2}% {:>7.1}%",
            error * 100.0,
            100.0 * probed.report.interpolated,
            probed.report.point_rays,
            wall,
            cpu,
            probed.report.error * 100.0,
            rms(relative),
            rms(absolute),
            100.0 * f64::from(inside) / f64::from(n),
        );
    }
}
