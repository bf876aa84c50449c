//! Hemicubes per second on the processor, compared with rays; and both in a closed body of mirrors.
//!
//! `cargo bench -p azulejo-factors --bench hemicube -- [rooms] [mirrors] [body]`; all three without
//! arguments.
#![allow(clippy::print_stdout, reason = "a benchmark prints its table")]

#[path = "drawing/mod.rs"]
mod drawing;
#[path = "usage/mod.rs"]
mod usage;

use azulejo_factors::{Engine, FormFactorOptions, FormFactors, Hemicube, PatchSize, form_factors};
use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
use azulejo_trace::item_buffer::Processor;
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let named = |word: &str| words.iter().any(|w| w == word);
    let has = |word: &str| named(word) || !["rooms", "mirrors", "body"].into_iter().any(named);
    if has("rooms") {
        drawing::print_table(&[&Processor]);
    }
    if has("mirrors") {
        drawing::print_mirrors(&[&Processor]);
    }
    if has("body") {
        print_body();
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
            let found = form_factors(&scene, &tracer, &options, &Progress::new());
            let took = usage::cpu_seconds() - before;
            match found.map(|factors| radiosity(&factors, diffuse, truth)) {
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
