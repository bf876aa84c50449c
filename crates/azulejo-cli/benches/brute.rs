//! How far ahead of brute force an answer is: `azulejo probe` as a whole process beside a plain path
//! tracer, in the same run.
//!
//! `cargo bench -p azulejo-cli --bench brute -- [ERROR] [SCENE...]`, by default 2% and all scenes: generated
//! ones, whose truth is the path tracer's with many paths at some of the points, and, with the environment
//! variable `AZULEJO_DATA`, each `scenes/real/NAME` with `reference/real/NAME_{points,normals,E,E_se}.npy`.
//! All are diffuse.
//!
//! Errors are root mean squares over the mean irradiance, at the points whose truth is known; the truth's own
//! noise is subtracted. The ratio is the CPU seconds that brute force would take to the error that the command
//! delivers, over those of the command: the error of brute force falls as the square root of its paths. Above
//! 1, the command is ahead. Reading and building are counted for the command only, and no threads help brute
//! force, so that its CPU seconds are as few as they can be.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

mod path_tracer;

use azulejo::models;
use azulejo_cli::parsers::parse_npy;
use azulejo_formats::grf;
use azulejo_scene::synthetic::{CornellVariant, cornell_box, furnished_room};
use azulejo_scene::{Rgb, Scene};
use azulejo_trace::Progress;
use glam::DVec3;
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike;
use path_tracer::{Estimate, PathTracer, Point};
use rayon::prelude::*;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Default of the requested error.
const ERROR: &str = "2%";

/// Paths of brute force at each point.
const PATHS: u32 = 1024;

/// Points at which truth is computed, at most, and its paths at each.
const TRUE_POINTS: usize = 400;
const TRUE_PATHS: u32 = 32_768;

/// Seeds of the points, of brute force and of the truth.
const SEEDS: [u64; 3] = [1, 2, 3];

/// A generated scene, and how many points of it are measured.
struct Generated {
    name: &'static str,
    points: usize,
    scene: fn() -> Scene,
}

const GENERATED: [Generated; 3] = [
    Generated {
        name: "cornell",
        points: 1_000,
        scene: || cornell_box(CornellVariant::Diffuse),
    },
    Generated {
        name: "cornell-dense",
        points: 10_000,
        scene: || cornell_box(CornellVariant::Diffuse),
    },
    Generated {
        name: "furnished",
        points: 1_200,
        scene: || furnished_room(20_000),
    },
];

fn main() {
    let words = std::env::args().skip(1).filter(|a| !a.starts_with('-'));
    let (errors, names): (Vec<String>, Vec<String>) = words.partition(|w| w.ends_with('%'));
    let error = errors.first().map_or(ERROR, String::as_str);
    let is_chosen = |name: &str| names.is_empty() || names.iter().any(|n| n == name);
    let folder = std::env::temp_dir().join(format!("azulejo-brute-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a temporary folder");
    println!(
        "{:<16} {:>7} {:>6} {:>9} {:>7} | {:>9} {:>7} | {:>6}",
        "scene",
        "points",
        "asked",
        "delivered",
        "CPU s",
        format!("{PATHS} paths"),
        "CPU s",
        "ratio"
    );
    for generated in GENERATED.iter().filter(|g| is_chosen(g.name)) {
        Trial::generated(generated, &folder).measure(error, &folder);
    }
    if let Some(data) = std::env::var_os("AZULEJO_DATA").map(PathBuf::from) {
        for name in real(&data).iter().filter(|name| is_chosen(name)) {
            Trial::real(name, &data).measure(error, &folder);
        }
    }
    let _ = fs::remove_dir_all(folder);
}

/// Names of the scenes of others, in order.
fn real(data: &Path) -> Vec<String> {
    let scenes = fs::read_dir(data.join("scenes/real")).expect("real scenes");
    let mut names: Vec<String> = scenes
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    names.sort();
    names
}

/// A scene, points of it, and their irradiance.
struct Trial {
    name: String,
    /// Models of the command.
    models: Vec<PathBuf>,
    tracer: PathTracer,
    points: Vec<Point>,
    truth: Truth,
}

impl Trial {
    /// Writes the scene for the command, and computes the truth.
    fn generated(generated: &Generated, folder: &Path) -> Trial {
        let scene = (generated.scene)();
        let model = folder.join(format!("{}.grf", generated.name));
        let mut file = fs::File::create(&model).expect("a file");
        grf::write(&scene, &mut file).expect("space for a file");
        let tracer = PathTracer::new(&scene, &scene);
        let points = tracer.points(generated.points, SEEDS[0]);
        Trial {
            name: generated.name.to_owned(),
            models: vec![model],
            truth: Truth::traced(&tracer, &points),
            tracer,
            points,
        }
    }

    /// Reads a scene of others with its reference.
    fn real(name: &str, data: &Path) -> Trial {
        let folder = data.join("scenes/real").join(name);
        let model = folder.join(format!("{name}.obj"));
        let lights = Some(folder.join("lights.grf")).filter(|path| path.exists());
        let lit = lights.as_deref().map_or_else(Scene::default, read);
        let reference = data.join("reference/real");
        let rows = |of: &str| array(&reference.join(format!("{name}_{of}.npy")), 3);
        let points = rows("points").into_iter().zip(rows("normals"));
        let point = |(position, normal): (Rgb, Rgb)| Point {
            position: position.to_array().into(),
            normal: DVec3::from(normal.to_array()).normalize(),
        };
        Trial {
            name: name.to_owned(),
            tracer: PathTracer::new(&read(&model), &lit),
            models: [model].into_iter().chain(lights).collect(),
            points: points.map(point).collect(),
            truth: Truth::new(rows("E"), &rows("E_se")),
        }
    }

    /// Prints a row.
    fn measure(&self, error: &str, folder: &Path) {
        print!("{:<16} {:>7} {error:>6} ", self.name, self.points.len());
        let (delivered, cpu) = match self.probe(error, folder) {
            Ok(row) => row,
            Err(message) => return println!("{message}"),
        };
        let (brute, brute_cpu) = self.brute();
        let needed = brute_cpu * (brute / delivered).powi(2);
        println!(
            "{:>8.2}% {cpu:>7.1} | {:>8.2}% {brute_cpu:>7.2} | {:>6.1}",
            100.0 * delivered,
            100.0 * brute,
            needed / cpu
        );
    }

    /// Error and CPU seconds of the command.
    fn probe(&self, error: &str, folder: &Path) -> Result<(f64, f64), String> {
        let (points, output) = (folder.join("points.txt"), folder.join("light.npy"));
        fs::write(&points, self.point_table()).expect("space for a file");
        let cpu = cpu_seconds(UsageWho::RUSAGE_CHILDREN);
        let run = Command::new(env!("CARGO_BIN_EXE_azulejo"))
            .arg("probe")
            .args(&self.models)
            .arg("--points")
            .arg(points)
            .args(["--error", error, "--json", "-o"])
            .arg(&output)
            .output()
            .expect("the program runs");
        let cpu = cpu_seconds(UsageWho::RUSAGE_CHILDREN) - cpu;
        if !run.status.success() {
            return Err(String::from_utf8_lossy(&run.stderr).into_owned());
        }
        Ok((self.truth.error(&array(&output, 6)), cpu))
    }

    /// Points and normals, one of each a line.
    fn point_table(&self) -> String {
        let mut text = String::new();
        for Point { position, normal } in &self.points {
            let [x, y, z] = position.to_array();
            let [i, j, k] = normal.to_array();
            writeln!(text, "{x} {y} {z} {i} {j} {k}").expect("a string takes all");
        }
        text
    }

    /// Error and CPU seconds of brute force.
    fn brute(&self) -> (f64, f64) {
        let cpu = cpu_seconds(UsageWho::RUSAGE_SELF);
        let trace = |(key, point)| self.tracer.irradiance(point, PATHS, SEEDS[1], key);
        let estimates = (0..).zip(&self.points).map(trace);
        let values: Vec<Rgb> = estimates.map(|e| e.value).collect();
        let cpu = cpu_seconds(UsageWho::RUSAGE_SELF) - cpu;
        (self.truth.error(&values), cpu)
    }
}

/// Irradiance that is known at some of the points.
struct Truth {
    /// Numbers of these points.
    points: Vec<usize>,
    estimates: Vec<Estimate>,
}

impl Truth {
    /// At all points, with standard errors.
    fn new(values: Vec<Rgb>, errors: &[Rgb]) -> Truth {
        let estimate = |(value, &error): (Rgb, &Rgb)| Estimate {
            value,
            variance: error * error,
        };
        Truth {
            points: (0..values.len()).collect(),
            estimates: values.into_iter().zip(errors).map(estimate).collect(),
        }
    }

    /// By many paths at every n-th point.
    fn traced(tracer: &PathTracer, points: &[Point]) -> Truth {
        let step = points.len().div_ceil(TRUE_POINTS);
        let chosen: Vec<usize> = (0..points.len()).step_by(step).collect();
        let trace = |&i: &usize| tracer.irradiance(&points[i], TRUE_PATHS, SEEDS[2], i as u64);
        let estimates = chosen.par_iter().map(trace).collect();
        Truth {
            points: chosen,
            estimates,
        }
    }

    /// Root mean square of the differences of all points' values, less the truth's own noise, over the mean.
    fn error(&self, values: &[Rgb]) -> f64 {
        let square = |(&point, truth): (&usize, &Estimate)| {
            let difference = values[point] - truth.value;
            (difference * difference - truth.variance).mean()
        };
        let squares: f64 = self.points.iter().zip(&self.estimates).map(square).sum();
        let sum: f64 = self.estimates.iter().map(|e| e.value.mean()).sum();
        let count = self.points.len() as f64;
        (squares / count).max(0.0).sqrt() / (sum / count)
    }
}

fn read(path: &Path) -> Scene {
    let model = models::read(path, &models::Reading::default(), &Progress::new());
    model
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()))
        .scene
}

/// The first three numbers of each row of a `.npy` file.
fn array(path: &Path, columns: usize) -> Vec<Rgb> {
    let bytes = fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let values = parse_npy(&bytes).expect("an array").values;
    let row = |row: &[f64]| Rgb::new(row[0], row[1], row[2]);
    values.chunks_exact(columns).map(row).collect()
}

/// CPU seconds of this process, or of all its children that have ended.
fn cpu_seconds(who: UsageWho) -> f64 {
    let usage = getrusage(who).expect("the system counts");
    let total = usage.user_time() + usage.system_time();
    total.num_microseconds() as f64 * 1e-6
}
