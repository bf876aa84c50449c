//! What error is delivered when an error is requested: `azulejo probe` as a whole process, against
//! irradiance by brute force in scenes of others.
//!
//! `cargo bench -p azulejo-cli --bench delivered -- [ERROR...]`, with the environment variable
//! `AZULEJO_DATA`: `reference/real/NAME_{points,normals,E,E_se}.npy` for each `scenes/real/NAME`. The
//! reference's own noise is subtracted. All errors are root mean squares over the mean irradiance; in
//! the quarters of the points, from bright to dark, over the mean of the quarter.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo_cli::parsers::parse_npy;
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Requested errors.
const ERRORS: [&str; 3] = ["5%", "2%", "1%"];

fn main() {
    let Some(data) = std::env::var_os("AZULEJO_DATA").map(PathBuf::from) else {
        println!("nothing to measure: AZULEJO_DATA is not set");
        return;
    };
    let mut errors: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| a.ends_with('%'))
        .collect();
    if errors.is_empty() {
        errors = ERRORS.map(str::to_owned).to_vec();
    }
    let scenes = fs::read_dir(data.join("scenes/real")).expect("real scenes");
    let mut names: Vec<String> = scenes
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    names.sort();
    println!(
        "{:<8} {:>5} {:>7} {:>7} {:>7} {:>7} | {:>29} | {:>7} {:>7}",
        "scene",
        "asked",
        "said",
        "found",
        "in 2 SE",
        "bias",
        "quarters, bright to dark",
        "CPU s",
        "traced"
    );
    for name in &names {
        let truth = Truth::read(&data.join("reference/real"), name);
        for error in &errors {
            measure(&data, name, error, &truth);
        }
    }
}

/// Irradiance by brute force.
struct Truth {
    folder: PathBuf,
    /// Three channels of every point, W/m².
    values: Vec<f64>,
    /// Their standard errors.
    errors: Vec<f64>,
}

impl Truth {
    fn read(folder: &Path, name: &str) -> Truth {
        Truth {
            folder: folder.to_owned(),
            values: array(&folder.join(format!("{name}_E.npy"))),
            errors: array(&folder.join(format!("{name}_E_se.npy"))),
        }
    }

    /// Mean of the channels of a point.
    fn brightness(&self, point: usize) -> f64 {
        self.values[3 * point..3 * point + 3].iter().sum::<f64>() / 3.0
    }

    fn mean(&self, points: &[usize]) -> f64 {
        points.iter().map(|&p| self.brightness(p)).sum::<f64>() / points.len() as f64
    }
}

/// Values of a `.npy` file.
fn array(path: &Path) -> Vec<f64> {
    let bytes = fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    parse_npy(&bytes).expect("an array").values
}

fn measure(data: &Path, name: &str, asked: &str, truth: &Truth) {
    let scene = data.join("scenes/real").join(name);
    let lights = scene.join("lights.grf");
    let output = std::env::temp_dir().join(format!("azulejo-{name}-{}.npy", std::process::id()));
    let cpu = cpu_seconds();
    let run = Command::new(env!("CARGO_BIN_EXE_azulejo"))
        .arg("probe")
        .arg(scene.join(format!("{name}.obj")))
        .args(lights.exists().then_some(&lights))
        .arg("--points")
        .arg(truth.folder.join(format!("{name}_points.npy")))
        .arg("--normals")
        .arg(truth.folder.join(format!("{name}_normals.npy")))
        .args(["--error", asked, "--json", "-o"])
        .arg(&output)
        .output()
        .expect("the program runs");
    let cpu = cpu_seconds() - cpu;
    if !run.status.success() {
        println!(
            "{name:<8} {asked:>5} {}",
            String::from_utf8_lossy(&run.stderr)
        );
        return;
    }
    let report: Value = serde_json::from_slice(&run.stdout).expect("a report");
    let found = array(&output);
    let _ = fs::remove_file(&output);
    let compared = Comparison {
        truth,
        found: &found,
    };
    let mut order: Vec<usize> = (0..truth.values.len() / 3).collect();
    order.sort_by(|&a, &b| truth.brightness(b).total_cmp(&truth.brightness(a)));
    let quarters: Vec<String> = order
        .chunks(order.len().div_ceil(4))
        .map(|quarter| match truth.mean(quarter) / truth.mean(&order) {
            share if share >= 0.01 => format!("{:.1}%", 100.0 * compared.error(quarter)),
            _ => "dark".to_owned(),
        })
        .collect();
    let number = |key: &str| report[key].as_f64().unwrap_or(f64::NAN);
    println!(
        "{name:<8} {asked:>5} {:>6.2}% {:>6.2}% {:>6.0}% {:>+6.2}% | {:>29} | {cpu:>7.1} {:>6.0}%",
        100.0 * number("error"),
        100.0 * compared.error(&order),
        100.0 * compared.within(),
        100.0 * compared.bias(&order),
        quarters.join(" "),
        100.0 * number("path_traced"),
    );
}

/// Rows of six numbers, irradiance and its standard error, beside the truth.
struct Comparison<'a> {
    truth: &'a Truth,
    found: &'a [f64],
}

impl Comparison<'_> {
    /// Found less true, of a channel of a point.
    fn difference(&self, point: usize, channel: usize) -> f64 {
        self.found[6 * point + channel] - self.truth.values[3 * point + channel]
    }

    /// Root mean square of the differences, less the truth's own noise, over the mean.
    fn error(&self, points: &[usize]) -> f64 {
        let square = |&p: &usize| {
            (0..3)
                .map(|k| self.difference(p, k).powi(2) - self.truth.errors[3 * p + k].powi(2))
                .sum::<f64>()
        };
        let mean = points.iter().map(square).sum::<f64>() / (3 * points.len()) as f64;
        mean.max(0.0).sqrt() / self.truth.mean(points)
    }

    /// Mean of the differences over the mean.
    fn bias(&self, points: &[usize]) -> f64 {
        let sum = |&p: &usize| (0..3).map(|k| self.difference(p, k)).sum::<f64>() / 3.0;
        points.iter().map(sum).sum::<f64>() / points.len() as f64 / self.truth.mean(points)
    }

    /// Share of the values within two standard errors, those of both.
    fn within(&self) -> f64 {
        let is_within = |i: &usize| {
            let (p, k) = (i / 3, i % 3);
            let both = self.found[6 * p + 3 + k].hypot(self.truth.errors[*i]);
            self.difference(p, k).abs() <= 2.0 * both
        };
        let count = self.truth.values.len();
        (0..count).filter(is_within).count() as f64 / count as f64
    }
}

/// CPU seconds of all processes that have ended.
fn cpu_seconds() -> f64 {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).expect("the system counts");
    let total = usage.user_time() + usage.system_time();
    total.num_microseconds() as f64 * 1e-6
}
