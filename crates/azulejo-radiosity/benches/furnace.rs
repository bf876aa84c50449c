//! Furnaces: closed rooms with uniform light, whose radiosity is known whatever the form factors.
//! `cargo bench -p azulejo-radiosity --bench furnace`.
//!
//! With exitance M, diffuse reflectance ρ and mirror reflectance σ on every wall, irradiance is
//! H = M/(1 − ρ − σ) and radiosity B = M + ρ H.

#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo_factors::estimator::Estimator;
use azulejo_factors::row::Columns;
use azulejo_factors::{Engine, PatchSize, Patches, reflectances};
use azulejo_radiosity::system::System;
use azulejo_scene::Rgb;
use azulejo_scene::synthetic::cube_room;
use azulejo_trace::{Gatherer, Progress, Run, Surfaces, Tracer};
use std::f64::consts::PI;

fn main() {
    println!("largest relative error of B on 600 patches of a cube, M = 1");
    for (diffuse, mirror) in [(0.5, 0.0), (0.5, 0.3)] {
        for rays in [64, 1024] {
            let error = worst_error(diffuse, mirror, rays);
            println!("diffuse {diffuse}, mirror {mirror}, {rays:>4} rays a patch: {error:.1e}");
        }
    }
}

/// Largest relative error of a patch's radiosity.
fn worst_error(diffuse: f64, mirror: f64, rays: u32) -> f64 {
    let mut scene = cube_room();
    let wall = &mut scene.materials[0];
    (wall.diffuse, wall.mirror) = (Rgb::grey(diffuse), Rgb::grey(mirror));
    wall.emission = Rgb::grey(1.0 / PI);
    let tracer = Tracer::new(&scene);
    let patches = Patches::new(&scene, PatchSize::Count(600));
    let reflectance = reflectances(&scene, &patches);
    let gatherer = Gatherer::new(Surfaces::new(&scene, &tracer));
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
    let found = system.solve_all(None).expect("nobody cancels");
    let expected = 1.0 + diffuse / (1.0 - diffuse - mirror);
    let reflected = found.mean();
    let fronts = (0..patches.len()).map(|p| 1.0 + reflected[2 * p].mean());
    fronts
        .map(|b| (b / expected - 1.0).abs())
        .fold(0.0, f64::max)
}
