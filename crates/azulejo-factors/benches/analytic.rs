//! The analytic engine on a closed room: `cargo bench -p azulejo-factors --bench analytic
//! [-- [box] facets...]`, by default about 500, 2,000, 5,000 and 20,000. The room has a table and two boxes on
//! its floor; with the word `box` it has one box, which hangs in the air, and fewer partial shadows.
//!
//! `-- town [blocks...]` computes towns of so many blocks a side, by default 4, 8 and 12, with 18 triangles each: by what
//! `auto` chooses and by rays, with the stated error of a row, and the actual one up to 6 blocks, against formulas for
//! all pairs.
//!
//! Every row of exact factors sums to 1, so the sums show the error, without closure. Beside it are
//! figures of View3D 4.0 (eps 1e-4, one core, CPU seconds) on such a room.

#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

mod usage;

use azulejo_factors::form_factors::Closure;
use azulejo_factors::{Engine, FormFactorOptions, PatchSize, form_factors};
use azulejo_scene::synthetic::room_with_table;
use azulejo_scene::{Material, MaterialId, Mesh, Object, Rgb, Scene, Shape, Up};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};
use std::time::Instant;
use usage::{cpu_seconds, peak_mebibytes};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut sizes: Vec<usize> = arguments.iter().filter_map(|a| a.parse().ok()).collect();
    if arguments.iter().any(|a| a == "town") {
        let blocks = if sizes.is_empty() {
            vec![4, 8, 12]
        } else {
            sizes
        };
        blocks.into_iter().for_each(towns);
        return;
    }
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

/// Blocks of 12 m × 12 m and 6 to 21 m on streets of 8 m, `n` by `n`, as triangles.
fn town(n: usize) -> Scene {
    let mut scene = Scene::default();
    let wall = scene.add_material(Material::diffuse("wall", Rgb::grey(0.3)));
    let mut mesh = Mesh::default();
    for k in 0..n * n {
        let (x, y) = (20.0 * (k % n) as f64, 20.0 * (k / n) as f64);
        let height = [6.0, 9.0, 12.0, 15.0, 21.0][hash(&[k as u32]) as usize % 5];
        let square = |low: f64, high: f64, z: f64| {
            let corners = [(low, low), (high, low), (high, high), (low, high)];
            corners.map(|(u, v)| dvec3(x + u, y + v, z))
        };
        let (border, foot, roof) = (
            square(0.0, 20.0, 0.0),
            square(4.0, 16.0, 0.0),
            square(4.0, 16.0, height),
        );
        let next = |k: usize| (k + 1) % 4;
        let ring = |low: [DVec3; 4], high: [DVec3; 4]| {
            [0, 1, 2, 3].map(|k| [low[k], low[next(k)], high[next(k)], high[k]])
        };
        let quads = ring(border, foot).into_iter().chain(ring(foot, roof));
        for [a, b, c, d] in quads.chain([roof]) {
            for corners in [[a, b, c], [a, c, d]] {
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(corners);
                mesh.push_face(&[first, first + 1, first + 2], wall);
            }
        }
    }
    scene.objects.push(Object::new("town", Shape::Mesh(mesh)));
    scene.units.up = Up::Z;
    scene
}

/// A town by each engine.
fn towns(blocks: usize) {
    let scene = town(blocks);
    let tracer = Tracer::new(&scene);
    let computed = |engine: Engine| {
        let options = FormFactorOptions {
            engine,
            size: PatchSize::Edge(0.0),
            ..FormFactorOptions::default()
        };
        let cpu = cpu_seconds();
        let factors = form_factors(&scene, &tracer, &options, &Progress::new()).expect("a town");
        (factors, cpu_seconds() - cpu)
    };
    let truth = (blocks <= MOST_EXACT).then(|| computed(Engine::Analytic).0);
    for engine in [Engine::Auto, Engine::Rays] {
        let (factors, cpu) = computed(engine);
        let rows = 0..factors.len();
        let stated = factors.row_errors.iter().sum::<f64>() / factors.len() as f64;
        let actual = truth.as_ref().map(|truth| {
            let off = |i: usize| {
                let differences =
                    |&(j, value, _): &(u32, f64, f32)| (value - factors.get(i, j).0).abs();
                truth.row(i).map(|e| differences(&e)).sum::<f64>()
            };
            let sums = truth.row_sums();
            let seeing = rows.clone().filter(|&i| sums[i] > 0.0);
            let shares: Vec<f64> = seeing.map(|i| off(i) / sums[i]).collect();
            shares.iter().sum::<f64>() / shares.len() as f64
        });
        println!(
            "{:6} facets {cpu:8.2} CPU s, error of a row stated {:.3}%, actual {:.3?}%  {}",
            rows.len(),
            100.0 * stated,
            actual.map(|share| 100.0 * share),
            factors
                .engine_used
                .notes
                .first()
                .map_or("rays", |note| note),
        );
    }
}

/// Most blocks a side that formulas for all pairs are tried with.
const MOST_EXACT: usize = 6;

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
