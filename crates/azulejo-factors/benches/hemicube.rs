//! Hemicubes per second on the processor, compared with rays; and both in a closed body of mirrors, and
//! between the walls of a box.
//!
//! `cargo bench -p azulejo-factors --bench hemicube -- [rooms] [mirrors] [body] [groups]`; all four without
//! arguments.
#![allow(clippy::print_stdout, reason = "a benchmark prints its table")]

#[path = "drawing/mod.rs"]
mod drawing;
#[path = "usage/mod.rs"]
mod usage;

use azulejo_factors::{
    Closure, Engine, FormFactorOptions, FormFactors, GroupBy, Hemicube, PatchSize, form_factors,
};
use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
use azulejo_testing::closed_forms::{on_common_edge, opposed};
use azulejo_trace::item_buffer::Processor;
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let named = |word: &str| words.iter().any(|w| w == word);
    let has = |word: &str| {
        named(word)
            || !["rooms", "mirrors", "body", "groups"]
                .into_iter()
                .any(named)
    };
    if has("rooms") {
        drawing::print_table(&[&Processor]);
    }
    if has("mirrors") {
        drawing::print_mirrors(&[&Processor]);
    }
    if has("body") {
        print_body();
    }
    if has("groups") {
        print_groups();
    }
}

/// Random seeds of each engine for the walls of a box.
const SEEDS: u64 = 10;

/// CPU seconds, errors and stated errors of form factors between the six walls of a closed box of 4 × 3 × 2.5, by
/// the engines alone: without formulas and closure.
fn print_groups() {
    println!("six walls of a box       CPU s   RMS error  stated, relative");
    let scene = walls();
    let hemicube = Hemicube {
        resolution: Hemicube::GROUP_RESOLUTION,
        ..Hemicube::default()
    };
    for (name, engine) in [
        ("rays", Engine::Rays),
        ("hemicube", Engine::Hemicube(hemicube.clone())),
        ("hybrid", Engine::Hybrid(hemicube)),
        ("analytic", Engine::Analytic),
    ] {
        for (plan, groups) in [("planned", Some(GroupBy::Object)), ("2,500 patches", None)] {
            let is_drawn = matches!(engine, Engine::Hemicube(_) | Engine::Hybrid(_));
            let (engine, seeds) = match groups {
                None if is_drawn => (engine.clone().with_resolution(128), 1),
                None => (engine.clone(), 2),
                Some(_) => (engine.clone(), SEEDS),
            };
            let (cpu, off, stated) = box_errors(&scene, &engine, groups, seeds);
            println!("  {name:<9} {plan:<13}  {cpu:>5.2}  {off:>10.1e}  {stated:>16.1e}");
        }
    }
}

/// CPU seconds of a matrix, and the RMS of errors and stated errors of the factors between walls, both relative.
fn box_errors(
    scene: &Scene,
    engine: &Engine,
    groups: Option<GroupBy>,
    seeds: u64,
) -> (f64, f64, f64) {
    let before = usage::cpu_seconds();
    let (mut off, mut stated, mut count) = (0.0, 0.0, 0.0);
    for seed in 0..seeds {
        let options = FormFactorOptions {
            engine: engine.clone(),
            groups,
            seed,
            analytic: false,
            closure: Closure::Never,
            ..FormFactorOptions::default()
        };
        let tracer = Tracer::new(scene);
        let factors = form_factors(scene, &tracer, &options, &Progress::new());
        let factors = factors.expect("there are surfaces");
        let objects: Vec<Option<u32>> = factors.faces.iter().map(|f| Some(f.object)).collect();
        let factors = factors.grouped(&objects, 6);
        for (i, j) in (0..6).flat_map(|i| (i + 1..6).map(move |j| (i, j))) {
            let ((factor, error), truth) = (factors.get(i, j as u32), between_walls(i, j));
            off += (factor / truth - 1.0).powi(2);
            stated += (f64::from(error) / truth).powi(2);
            count += 1.0;
        }
    }
    let cpu = (usage::cpu_seconds() - before) / seeds as f64;
    (cpu, (off / count).sqrt(), (stated / count).sqrt())
}

/// Lengths of the box.
const SIZE: [f64; 3] = [4.0, 3.0, 2.5];

/// The closed box from inside, each wall an object: those of x, y and z, that at 0 before the other.
fn walls() -> Scene {
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("wall", Rgb::grey(0.5)));
    let edges = [0, 1, 2].map(|k| SIZE[k] * DVec3::AXES[k]);
    for k in 0..3 {
        let (away, u, v) = (edges[k], edges[(k + 1) % 3], edges[(k + 2) % 3]);
        for (corner, u, v) in [(DVec3::ZERO, u, v), (away, v, u)] {
            let mut mesh = Mesh {
                positions: vec![corner, corner + u, corner + u + v, corner + v],
                ..Mesh::default()
            };
            mesh.push_face(&[0, 1, 2, 3], grey);
            scene.objects.push(Object::new("wall", Shape::Mesh(mesh)));
        }
    }
    scene
}

/// The form factor between two different walls.
fn between_walls(from: usize, to: usize) -> f64 {
    let [a, b] = [from / 2, to / 2];
    if a == b {
        opposed(SIZE[(a + 1) % 3], SIZE[(a + 2) % 3], SIZE[a])
    } else {
        on_common_edge(SIZE[3 - a - b], SIZE[b], SIZE[a])
    }
}

/// CPU seconds and errors of rays and hemicubes in a ball of 320 flat facets, all of them mirrors
/// that reflect diffusely too. In any closed furnace of M = 1, B = M / (1 − ρ_d / (1 − ρ_s)).
fn print_body() {
    println!("a ball of 320 mirrors      CPU s   mean of B  RMS error of B");
    for (diffuse, mirror) in [(0.5, 0.3), (0.05, 0.9)] {
        let scene = body(diffuse, mirror);
        let truth = 1.0 / (1.0 - diffuse / (1.0 - mirror));
        println!("ρ_d = {diffuse}, ρ_s = {mirror}: B = {truth}");
        let hemicube = |resolution, points| {
            let options = Hemicube {
                resolution,
                points,
                ..Hemicube::default()
            };
            let name = format!("hemicube, {resolution} px, {points}");
            (name, Engine::Hemicube(options), 0)
        };
        for (name, engine, rays) in [
            ("rays, 1024".to_owned(), Engine::Rays, 1024),
            ("rays, 16384".to_owned(), Engine::Rays, 16384),
            hemicube(32, 4),
            hemicube(64, 4),
            hemicube(64, 16),
        ] {
            let options = FormFactorOptions {
                engine,
                rays,
                size: PatchSize::Edge(0.0),
                ..FormFactorOptions::default()
            };
            let before = usage::cpu_seconds();
            let tracer = Tracer::new(&scene);
            let result = form_factors(&scene, &tracer, &options, &Progress::new());
            let took = usage::cpu_seconds() - before;
            match result.map(|factors| radiosity(&factors, diffuse, truth)) {
                Ok((mean, error)) => {
                    println!("  {name:<22}  {took:>7.2}  {mean:>10.4}  {error:>14.5}");
                }
                Err(why) => println!("  {name:<22}  {why}"),
            }
        }
    }
}

/// The mean of B = 1 + ρ X B over the area, and its root mean square deviation from `truth`, relative.
fn radiosity(factors: &FormFactors, diffuse: f64, truth: f64) -> (f64, f64) {
    let rows = factors.rows(0..factors.len());
    let mut b = vec![1.0; factors.len()];
    for _ in 0..200 {
        let arriving = |row: &Vec<(u32, f64, f32)>| -> f64 {
            row.iter().map(|&(j, x, _)| x * b[j as usize]).sum()
        };
        b = rows
            .iter()
            .map(|row| 1.0 + diffuse * arriving(row))
            .collect();
    }
    let whole: f64 = factors.areas.iter().sum();
    let mean = |of: &dyn Fn(f64) -> f64| {
        let weighted = b.iter().zip(&factors.areas).map(|(&b, a)| of(b) * a);
        weighted.sum::<f64>() / whole
    };
    let error = mean(&|b| (b / truth - 1.0).powi(2)).sqrt();
    (mean(&|b| b), error)
}

/// A ball of flat facets, seen from inside.
fn body(diffuse: f64, mirror: f64) -> Scene {
    const AROUND: usize = 20;
    const ALONG: usize = 16;
    let point = |i: usize, j: usize| {
        let (t, p) = (
            PI * i as f64 / ALONG as f64,
            TAU * (j % AROUND) as f64 / AROUND as f64,
        );
        DVec3::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos())
    };
    let mut scene = Scene::default();
    let wall = scene.add_material(Material {
        diffuse: Rgb::grey(diffuse),
        mirror: Rgb::grey(mirror),
        emission: Rgb::grey(FRAC_1_PI),
        ..Material::default()
    });
    let mut mesh = Mesh::default();
    for (i, j) in (0..ALONG).flat_map(|i| (0..AROUND).map(move |j| (i, j))) {
        let [a, b, c, d] = [
            point(i, j),
            point(i, j + 1),
            point(i + 1, j + 1),
            point(i + 1, j),
        ];
        let corners = match i {
            0 => vec![a, c, d],
            _ if i + 1 == ALONG => vec![a, b, c],
            _ => vec![a, b, c, d],
        };
        let first = mesh.positions.len() as u32;
        let numbers: Vec<u32> = (first..first + corners.len() as u32).collect();
        mesh.positions.extend(corners);
        mesh.push_face(&numbers, wall);
    }
    scene.objects.push(Object::new("ball", Shape::Mesh(mesh)));
    scene
}
