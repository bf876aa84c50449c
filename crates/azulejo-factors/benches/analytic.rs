//! The analytic engine on a closed room: `cargo bench -p azulejo-factors --bench analytic
//! [-- [box] facets...]`, by default about 500, 2,000, 5,000 and 20,000. The room has a table and two boxes on
//! its floor; with the word `box` it has one box, which hangs in the air, and fewer partial shadows.
//!
//! Every row of exact factors sums to 1, so the sums show the error, without closure. Beside it are
//! figures of View3D 4.0 (eps 1e-4, one core, CPU seconds) on such a room.

#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

mod usage;

use azulejo_factors::form_factors::Closure;
use azulejo_factors::{Engine, FormFactorOptions, PatchSize, form_factors};
use azulejo_scene::synthetic::room_with_table;
use azulejo_scene::{Material, MaterialId, Mesh, Object, Rgb, Scene, Shape};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};
use std::time::Instant;
use usage::{cpu_seconds, peak_mebibytes};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut sizes: Vec<usize> = arguments.iter().filter_map(|a| a.parse().ok()).collect();
    let furnish = if arguments.iter().any(|a| a == "box") {
        room_with_box
    } else {
        room_with_table
    };
    if sizes.is_empty() {
        sizes = vec![500, 2_000, 5_000, 20_000];
    }
    println!("facets   wall s    CPU s  exponent      pairs  peak MiB  row sums: RMS      max");
    let mut before: Option<(f64, f64)> = None;
    for size in sizes {
        let (facets, cpu) = room(&furnish(size));
        let exponent = before.map(|(n, t)| (cpu / t).ln() / (facets / n).ln());
        println!("         exponent {exponent:.2?}");
        before = Some((facets, cpu));
    }
    println!("View3D: 490 facets 2.4 s, 2,006 facets 22.6 s, 4,992 facets 107.8 s");
}

/// A room of 4 m × 3 m × 2.5 m with a box of 1 m × 1 m × 0.75 m half a metre above its floor: n² facets on each
/// side of the room and about n²/2 on each of the box.
fn room_with_box(facets: usize) -> Scene {
    let n = (facets as f64 / 9.0).sqrt().round().max(1.0);
    let m = ((facets as f64 / 6.0 - n * n).max(1.0)).sqrt().round();
    let mut scene = Scene::default();
    let wall = scene.add_material(Material::diffuse("wall", Rgb::grey(0.7)));
    let mut mesh = Mesh::default();
    add_box(
        &mut mesh,
        [DVec3::ZERO, dvec3(4.0, 3.0, 2.5)],
        n,
        true,
        wall,
    );
    let hanging = [dvec3(1.5, 1.0, 0.5), dvec3(2.5, 2.0, 1.25)];
    add_box(&mut mesh, hanging, m, false, wall);
    scene.objects.push(Object::new("room", Shape::Mesh(mesh)));
    scene
}

/// The sides of a box between two corners, each divided into n by n, seen from inside or from outside.
fn add_box(mesh: &mut Mesh, [low, high]: [DVec3; 2], n: f64, is_room: bool, wall: MaterialId) {
    let size = high - low;
    for axis in 0..3 {
        let [depth, u, v] = [0, 1, 2].map(|k| {
            let axis = (axis + k) % 3;
            DVec3::AXES[axis] * size[axis] / if k == 0 { 1.0 } else { n }
        });
        for is_far in [false, true] {
            let corner = low + if is_far { depth } else { DVec3::ZERO };
            for k in 0..(n * n) as u32 {
                let place = corner + f64::from(k % n as u32) * u + f64::from(k / n as u32) * v;
                let mut quad = [place, place + u, place + u + v, place + v];
                if is_far == is_room {
                    quad.reverse();
                }
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(quad);
                mesh.push_face(&[first, first + 1, first + 2, first + 3], wall);
            }
        }
    }
}

fn room(scene: &Scene) -> (f64, f64) {
    let options = FormFactorOptions {
        engine: Engine::Analytic,
        size: PatchSize::Edge(0.0),
        closure: Closure::Never,
        ..FormFactorOptions::default()
    };
    let (wall, cpu) = (Instant::now(), cpu_seconds());
    let tracer = Tracer::new(scene);
    let factors = form_factors(scene, &tracer, &options, &Progress::new()).expect("a room");
    let (wall, cpu) = (wall.elapsed().as_secs_f64(), cpu_seconds() - cpu);
    let off: Vec<f64> = factors.row_sums().iter().map(|s| s - 1.0).collect();
    let rms = (off.iter().map(|d| d * d).sum::<f64>() / off.len() as f64).sqrt();
    let max = off.iter().map(|d| d.abs()).fold(0.0, f64::max);
    println!(
        "{:6} {wall:8.2} {cpu:8.2}            {:9}  {:8.0}       {rms:.2e} {max:.2e}",
        factors.len(),
        factors.exchange.pairs(),
        peak_mebibytes(),
    );
    factors
        .engine_used
        .notes
        .iter()
        .for_each(|n| println!("         {n}"));
    let worst = (0..off.len()).max_by(|&a, &b| off[a].abs().total_cmp(&off[b].abs()));
    println!(
        "         worst row {worst:?}, mean {:.1e}",
        off.iter().sum::<f64>() / off.len() as f64
    );
    (factors.len() as f64, cpu)
}
