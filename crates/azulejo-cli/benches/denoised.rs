//! What `render --denoise` leaves of the noise.
//!
//! `cargo bench -p azulejo-cli --bench denoised`, the dining room and Sponza with `AZULEJO_DATA`. Each
//! scene is rendered by `--reference` with 16 samples per pixel, with and without the filter, and with
//! 1024 samples of another seed. Errors are mean squares relative to the square of the pixel, as
//! [`relative_rmse`] defines them; the last column is what the program said of itself.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo_formats::picture::exr;
use azulejo_render::relative_rmse;
use azulejo_scene::Image;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Pixels of each picture.
const SIZE: &str = "96x72";

/// Samples of the noisy pictures and of those taken for the truth.
const SAMPLES: [&str; 2] = ["16", "1024"];

fn main() {
    let project = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let example = |name: &str| vec![project.join("examples").join(name)];
    let mut scenes = vec![
        ("cornell", example("cornell.grf"), ""),
        ("cornell-glossy", example("cornell-glossy.grf"), ""),
    ];
    match std::env::var_os("AZULEJO_DATA").map(PathBuf::from) {
        Some(data) => {
            let real = data.join("scenes/real");
            let sponza = ["sponza/sponza.obj", "sponza/lights.grf"];
            scenes.push(("dining", vec![real.join("dining/dining.obj")], ""));
            let files = sponza.map(|name| real.join(name)).to_vec();
            scenes.push(("sponza", files, ""));
        }
        None => println!("the dining room and Sponza are left out: AZULEJO_DATA is not set"),
    }
    println!(
        "{:<15} {:>9} {:>9} {:>7} {:>8} {:>8} {:>9}",
        "scene", "before", "after", "ratio", "CPU s", "with", "said"
    );
    let folder = std::env::temp_dir().join(format!("azulejo-denoised-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for pictures");
    for (name, files, view) in scenes {
        measure(name, &files, view, &folder);
    }
    std::fs::remove_dir_all(&folder).expect("the folder is ours");
}

fn measure(name: &str, files: &[PathBuf], view: &str, folder: &Path) {
    let render = |options: &str| render(files, folder, &format!("{view} {options}"));
    let [few, many] = SAMPLES;
    let (noisy, raw) = render(&format!("--spp {few}"));
    let (filtered, report) = render(&format!("--spp {few} --denoise"));
    let (truth, _) = render(&format!("--spp {many} --seed 1"));
    let square = |image: &Image| relative_rmse(image, &truth).powi(2);
    let (before, after) = (square(&noisy), square(&filtered));
    let of = |report: &Value, key: &str| report[key].as_f64().unwrap_or(f64::NAN);
    println!(
        "{name:<15} {before:>9.4} {after:>9.4} {:>7.1} {:>8.2} {:>8.2} {:>9.4}",
        before / after,
        of(&raw, "cpu_seconds"),
        of(&report, "cpu_seconds"),
        of(&report, "denoised_error").powi(2)
    );
}

/// A picture by the program, and its report.
fn render(files: &[PathBuf], folder: &Path, options: &str) -> (Image, Value) {
    let path = folder.join("picture.exr");
    let run = Command::new(env!("CARGO_BIN_EXE_azulejo"))
        .arg("render")
        .args(files)
        .args(["--reference", "--json", "--size", SIZE, "-o"])
        .arg(&path)
        .args(options.split_whitespace())
        .output()
        .expect("the program runs");
    let words = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{words}");
    let image = exr::read(&std::fs::read(&path).expect("it wrote")).expect("a picture");
    (
        image,
        serde_json::from_slice(&run.stdout).expect("a report"),
    )
}
