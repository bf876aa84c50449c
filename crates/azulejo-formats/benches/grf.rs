//! Throughput of reading and writing GRF: MB of text per second on one thread, best of several runs.
//!
//! `cargo bench -p azulejo-formats --bench grf -- [FILE...]`; without files, a generated grid.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo_formats::{Folder, grf};
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
        measure("solved grid with normals", grid(400, true).as_bytes());
    }
}

fn measure(name: &str, bytes: &[u8]) {
    let (mut read, mut written) = (f64::INFINITY, f64::INFINITY);
    let mut size = 0;
    for _ in 0..RUNS {
        let start = Instant::now();
        let loaded = match grf::read(bytes, name, &Folder::of_model(Path::new(name))) {
            Ok(loaded) => loaded,
            Err(e) => return println!("{e}"),
        };
        read = read.min(start.elapsed().as_secs_f64());
        let start = Instant::now();
        let mut out = Vec::new();
        if let Err(e) = grf::write(&loaded.scene, &mut out) {
            return println!("{name}: {e}");
        }
        written = written.min(start.elapsed().as_secs_f64());
        size = out.len();
    }
    let megabytes = |bytes: usize| bytes as f64 / 1e6;
    println!(
        "{name}: read {:.1} MB at {:.0} MB/s, written {:.1} MB at {:.0} MB/s",
        megabytes(bytes.len()),
        megabytes(bytes.len()) / read,
        megabytes(size),
        megabytes(size) / written,
    );
}

/// A quad in each of `n × n` cells, with numbers formatted as exporters do.
fn grid(n: usize, is_solved: bool) -> String {
    let mut text = String::from("begin mesh\nbegin vertices\n");
    for k in 0..=n * n + 2 * n {
        let (x, y) = ((k % (n + 1)) as f64 * 0.013, (k / (n + 1)) as f64 * 0.017);
        let light = if is_solved {
            format!("normal (0.0, 0.0, 1.0) irad ({x:.6}, {y:.6}, 1.25) ")
        } else {
            String::new()
        };
        let _ = writeln!(text, "{light}({x:.6}, {y:.6}, {:.6})", x * y);
    }
    text += "end vertices\nbegin faces\n";
    for k in 0..n * n {
        let a = k / n * (n + 1) + k % n;
        let _ = writeln!(text, "({a}, {}, {}, {})", a + 1, a + n + 2, a + n + 1);
    }
    text + "end faces\nend mesh\n"
}
