//! What `auto` forecasts against what it takes: `azulejo form-factors` as a whole process on models.
//!
//! `cargo bench -p azulejo-cli --bench forecasts -- FILE...`, each divided into 600 patches, or with its faces
//! whole where they are more; without files on generated rooms, streets and towns. CPU seconds of one thread,
//! less those of reading the model (`azulejo info`). A row ends with the ratio of both, and the last line says
//! how many are within a factor of two.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo_formats::grf;
use azulejo_scene::Scene;
use azulejo_scene::synthetic::{
    CornellVariant, cornell_box, cube_array, furnished_room, room_with_table, street_with_detail,
};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Patches of a model.
const PATCHES: &str = "600";

/// A run that takes longer is stopped.
const LONGEST: Duration = Duration::from_secs(120);

/// Times below this, of a process, are measured too badly.
const SHORTEST: f64 = 0.02;

fn main() {
    let folder = std::env::temp_dir().join(format!("azulejo-forecasts-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a temporary folder");
    let mut files: Vec<PathBuf> = std::env::args_os()
        .skip(1)
        .map(PathBuf::from)
        .filter(|path| path.exists())
        .collect();
    if files.is_empty() {
        files = generated(&folder);
    }
    println!(
        "{:>9} {:>9} {:>6}  engine    model",
        "forecast", "took", "ratio"
    );
    let (mut compared, mut near) = (0, 0);
    for file in &files {
        let Some((engine, forecast, took)) = measured(file, &folder) else {
            println!("{:>9} {:>9} {:>6}  -         {}", "-", "-", "-", name(file));
            continue;
        };
        let ratio = forecast.max(SHORTEST) / took.max(SHORTEST);
        compared += 1;
        near += u32::from((0.5..=2.0).contains(&ratio));
        println!(
            "{forecast:9.3} {took:9.3} {ratio:6.2}  {engine:9} {}",
            name(file)
        );
    }
    println!("{near} of {compared} within a factor of two");
    let _ = fs::remove_dir_all(&folder);
}

fn name(file: &Path) -> String {
    file.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

fn generated(folder: &Path) -> Vec<PathBuf> {
    let scenes: [(&str, Scene); 6] = [
        ("furnished", furnished_room(600)),
        ("table", room_with_table(300)),
        ("table-fine", room_with_table(1_000)),
        ("cubes", cube_array(4, 2)),
        ("cornell", cornell_box(CornellVariant::Diffuse)),
        ("street", street_with_detail(0.1)),
    ];
    let write = |(name, scene): (&str, Scene)| {
        let path = folder.join(format!("{name}.grf"));
        let mut bytes = Vec::new();
        grf::write(&scene, &mut bytes).expect("scenes fit into GRF");
        fs::write(&path, bytes).expect("the temporary folder can be written");
        path
    };
    scenes.into_iter().map(write).collect()
}

/// Engine, forecast and CPU seconds of form factors; `None` without a forecast or if it takes too long.
fn measured(file: &Path, folder: &Path) -> Option<(String, f64, f64)> {
    let out = folder.join("f.npz");
    let mut command = azulejo("form-factors");
    command
        .arg(file)
        .arg("-o")
        .arg(&out)
        .args(["--patches", PATCHES, "--no-journal"]);
    let report = run(command)?;
    let mut reading = azulejo("info");
    reading.arg(file);
    let reading = run(reading)?;
    let number = |report: &Value, key: &str| report.get(key).and_then(Value::as_f64);
    let took = number(&report, "cpu_seconds")? - number(&reading, "cpu_seconds").unwrap_or(0.0);
    let engine = report.get("engine").and_then(Value::as_str).unwrap_or("?");
    Some((
        engine.to_owned(),
        number(&report, "forecast_seconds")?,
        took,
    ))
}

fn azulejo(command: &str) -> Command {
    let mut process = Command::new(env!("CARGO_BIN_EXE_azulejo"));
    process
        .arg(command)
        .args(["--json", "--quiet", "--threads", "1"]);
    process
}

/// The report of a run.
fn run(mut command: Command) -> Option<Value> {
    let begin = Instant::now();
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    loop {
        if child.try_wait().ok()?.is_some() {
            let output = child.wait_with_output().ok()?;
            return serde_json::from_slice(&output.stdout).ok();
        }
        if begin.elapsed() > LONGEST {
            let _ = child.kill();
            let _ = child.wait();
            return None;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}
