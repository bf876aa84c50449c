//! Throughput of reading OBJ: MB of text per second on one thread, best of several runs.
//!
//! `cargo bench -p azulejo-formats --bench obj -- [FILE...]`; without files, a generated grid.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo_formats::{Folder, obj};
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

/// Runs per file.
const RUNS: usize = 5;

fn main() {
    // Cargo itself passes `--bench`.
    let files: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    for file in &files {
        match std::fs::read(file) {
            Ok(bytes) => measure(file, &bytes),
            Err(e) => println!("{file}: {e}"),
        }
    }
    if files.is_empty() {
        measure("grid of positions", grid(600, false).as_bytes());
        measure("grid with uvs and normals", grid(400, true).as_bytes());
    }
}

fn measure(name: &str, bytes: &[u8]) {
    let mut best = f64::INFINITY;
    let mut faces = 0;
    for _ in 0..RUNS {
        let start = Instant::now();
        let loaded = match obj::read(bytes, name, &Folder::of_model(Path::new(name))) {
            Ok(loaded) => loaded,
            Err(e) => return println!("{e}"),
        };
        best = best.min(start.elapsed().as_secs_f64());
        faces = loaded
            .scene
            .objects
            .iter()
            .map(|o| match &o.shape {
                azulejo_scene::Shape::Mesh(mesh) => mesh.faces.len(),
                _ => 0,
            })
            .sum();
    }
    let megabytes = bytes.len() as f64 / 1e6;
    println!(
        "{name}: {megabytes:.1} MB, {faces} faces, {best:.3} s, {:.0} MB/s",
        megabytes / best
    );
}

/// Two triangles in each of `n × n` cells, with numbers formatted as exporters do.
fn grid(n: usize, attributes: bool) -> String {
    let mut text = String::new();
    let points =
        || (0..=n).flat_map(|y| (0..=n).map(move |x| (x as f64 / n as f64, y as f64 / n as f64)));
    for (x, y) in points() {
        let _ = writeln!(
            text,
            "v {x:.6} {y:.6} {:.6}",
            (7.0 * x).sin() * (5.0 * y).cos()
        );
    }
    for (x, y) in points().filter(|_| attributes) {
        let _ = writeln!(
            text,
            "vt {x:.4} {y:.4}\nvn {:.4} {:.4} 0.5",
            x - 0.5,
            y - 0.5
        );
    }
    let corner = |i: usize| {
        if attributes {
            format!("{i}/{i}/{i}")
        } else {
            i.to_string()
        }
    };
    for y in 0..n {
        for x in 0..n {
            let a = y * (n + 1) + x + 1;
            let [a, b, c, d] = [a, a + 1, a + n + 2, a + n + 1].map(corner);
            let _ = writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}");
        }
    }
    text
}
