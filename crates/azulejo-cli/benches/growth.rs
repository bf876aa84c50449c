//! How time and memory grow with the number of faces: `azulejo info`, `solve` and `form-factors` as
//! whole processes on furnished rooms of 10³ to 10⁶ triangles, `render` on pages of letters, and `probe` under
//! point lights.
//!
//! `cargo bench -p azulejo-cli --bench growth -- [COMMAND...] [LARGEST]`, with commands of `info`,
//! `solve`, `factors`, `letters` and `lights`, by default all, and the largest number of triangles, by default
//! 1,000,000; of letters it is a hundredth of that, of lights a tenth. The last column of each row is
//! the exponent since the row before: CPU seconds grow as the number of faces to its power.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo_formats::grf;
use azulejo_scene::random::split_mix64;
use azulejo_scene::synthetic::{cube_room, furnished_room};
use azulejo_scene::{Light, LightKind, Rgb};
use glam::DVec3;
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Default of the largest number of triangles.
const LARGEST: usize = 1_000_000;

/// Smallest number of triangles; also of letters, divided by [`LETTER_SHARE`].
const SMALLEST: usize = 1_000;

/// Letters are a hundredth of the triangles: each has about thirty faces, of three objects or more.
const LETTER_SHARE: usize = 100;

/// The same of lights.
const LIGHT_SHARE: usize = 10;

/// Points at which lights are measured.
const LIT_POINTS: usize = 300;

/// Rays of each row of form factors.
const FACTOR_RAYS: &str = "256";

/// The largest room whose matrix is computed: memory grows as the square.
const LARGEST_MATRIX: usize = 20_000;

/// A command that takes longer is stopped.
const LONGEST: Duration = Duration::from_secs(900);

fn main() {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    let largest = words.iter().find_map(|w| w.parse().ok()).unwrap_or(LARGEST);
    let chosen: Vec<&String> = words
        .iter()
        .filter(|w| w.parse::<usize>().is_err())
        .collect();
    let is_chosen = |name: &str| chosen.is_empty() || chosen.iter().any(|w| *w == name);
    let folder = std::env::temp_dir().join(format!("azulejo-growth-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a temporary folder");
    let rooms: Vec<(usize, PathBuf)> = sizes(SMALLEST, largest)
        .map(|triangles| (triangles, room(&folder, triangles)))
        .collect();
    for (name, arguments) in [
        ("info", vec![]),
        ("solve", vec!["-o", "out.glb"]),
        ("factors", vec!["--rays", FACTOR_RAYS, "-o", "out.npz"]),
    ] {
        if !is_chosen(name) {
            continue;
        }
        let mut growth = Growth::titled(name, "triangles");
        for (triangles, file) in &rooms {
            if name == "factors" && *triangles > LARGEST_MATRIX {
                continue;
            }
            let command = if name == "factors" {
                "form-factors"
            } else {
                name
            };
            growth.measure(*triangles, &folder, command, &[file], &arguments);
        }
    }
    if is_chosen("letters") {
        let mut growth = Growth::titled("render page", "letters");
        let (wall, sizes) = (
            folder.join("wall.grf"),
            sizes(SMALLEST / LETTER_SHARE, largest / LETTER_SHARE),
        );
        for letters in sizes {
            let page = page(&folder, letters);
            fs::write(&wall, wall_and_lamp(letters)).expect("space for a file");
            let files = [page.as_path(), wall.as_path()];
            growth.measure(letters, &folder, "render", &files, &["-o", "out.png"]);
        }
    }
    if is_chosen("lights") {
        let mut growth = Growth::titled("probe", "lights");
        let points = folder.join("points.txt");
        fs::write(&points, floor_points()).expect("space for a file");
        let points = points.to_str().expect("a path in Unicode").to_owned();
        for lights in sizes(SMALLEST / LIGHT_SHARE, largest / LIGHT_SHARE) {
            let room = lit_room(&folder, lights);
            let arguments = ["--points", &points, "-o", "lit.npy", "--error", "5%"];
            growth.measure(lights, &folder, "probe", &[room], &arguments);
        }
    }
    let _ = fs::remove_dir_all(folder);
}

/// Points all over the floor of the unit cube.
fn floor_points() -> String {
    let point = |k: usize| {
        let along = (k as f64 + 0.5) / LIT_POINTS as f64;
        format!("{along} {} 0 0 0 1\n", (along * 97.0).fract())
    };
    (0..LIT_POINTS).map(point).collect()
}

/// The unit cube, from within, with point lights in it.
fn lit_room(folder: &Path, lights: usize) -> PathBuf {
    let (mut scene, mut state) = (cube_room(), 1);
    scene.lights.extend((0..lights).map(|k| {
        let at = [(); 3].map(|()| 0.05 + 0.9 * split_mix64(&mut state));
        let kind = LightKind::Point {
            position: DVec3::from(at),
            intensity: Rgb::grey(1.0),
        };
        let name = k.to_string();
        Light { name, kind }
    }));
    let path = folder.join(format!("lights-{lights}.grf"));
    let mut file = fs::File::create(&path).expect("a file");
    grf::write(&scene, &mut file).expect("space for a file");
    path
}

/// Sizes in steps of ten, and the largest.
fn sizes(smallest: usize, largest: usize) -> impl Iterator<Item = usize> {
    let steps = std::iter::successors(Some(smallest), |n| Some(n * 10));
    steps.take_while(move |&n| n < largest).chain([largest])
}

fn room(folder: &Path, triangles: usize) -> PathBuf {
    let path = folder.join(format!("room-{triangles}.grf"));
    let mut file = fs::File::create(&path).expect("a file");
    grf::write(&furnished_room(triangles), &mut file).expect("space for a file");
    path
}

/// A square page of random letters, by `azulejo text`.
fn page(folder: &Path, letters: usize) -> PathBuf {
    let line = (letters as f64).sqrt().round() as usize;
    let mut text = String::new();
    let mut state = 1u64;
    for k in 0..letters {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        text.push(char::from(b'a' + ((state >> 33) % 26) as u8));
        if (k + 1) % line == 0 {
            text.push('\n');
        }
    }
    let (words, path) = (folder.join("page.txt"), folder.join("page.grf"));
    fs::write(&words, text).expect("space for a file");
    let fonts = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/fonts");
    let made = Command::new(env!("CARGO_BIN_EXE_azulejo"))
        .arg("text")
        .arg("--font")
        .arg(fonts.join("dejavu-serif.ppf"))
        .arg("--encoding")
        .arg(fonts.join("latin.ppe"))
        .arg("--file")
        .arg(&words)
        .arg("-o")
        .arg(&path)
        .stdout(Stdio::null())
        .status()
        .expect("the program runs");
    assert!(made.success(), "no page of {letters} letters");
    path
}

/// A wall behind a page of letters, which stands one line of 1.2 below the other with some 0.6 per
/// letter, a lamp before it, and a camera that sees all.
fn wall_and_lamp(letters: usize) -> String {
    let height = 1.2 * (letters as f64).sqrt();
    let (x, y, h) = (0.3 * height, -0.5 * height, height);
    let mut text = String::new();
    write!(
        text,
        "ext camera begin\nname = \"front\"\neye = ({x}, {y}, {})\ntarget = ({x}, {y}, 0)\n\
         up = (0, 1, 0)\nfov = 55\nsize = 640 480\nend ext\n\
         def wall = brdf diffuse kd = (0.65, 0.66, 0.68)\nbegin\n\
         ext object begin name = \"wall\" end ext\n\
         ext primitive begin kind = parallelogram \
         map = {} 0 0 0 {} 0 0 0 1 {} {} -0.25 material = wall end ext\n\
         ext object begin name = \"lamp\" end ext\n\
         light begin rgb (240, 220, 190) ({}, {}, {}) ({}, 0, 0) (0, {}, {}) end light\nend def\n",
        1.1 * h,
        2.0 * h,
        2.0 * h,
        x - h,
        y - h,
        x - 0.8 * h,
        y + 0.8 * h,
        0.7 * h,
        0.35 * h,
        -0.35 * h,
        -0.1 * h,
    )
    .expect("a string takes all");
    text
}

/// One command over growing scenes.
struct Growth {
    command: &'static str,
    /// Size and CPU seconds of the row before.
    before: Option<(usize, f64)>,
}

impl Growth {
    fn titled(command: &'static str, items: &str) -> Growth {
        println!(
            "\n{command:<12} | {items:>9} | {:>8} | {:>6} | exponent",
            "CPU s", "MB"
        );
        Growth {
            command,
            before: None,
        }
    }

    fn measure(
        &mut self,
        size: usize,
        folder: &Path,
        command: &str,
        files: &[impl AsRef<Path>],
        arguments: &[&str],
    ) {
        let Some((seconds, peak)) = run(folder, command, files, arguments) else {
            println!("{:<12} | {size:>9} | failed", self.command);
            self.before = None;
            return;
        };
        let exponent = self.before.map_or_else(String::new, |(n, s)| {
            format!("{:.2}", (seconds / s).ln() / (size as f64 / n as f64).ln())
        });
        println!(
            "{:<12} | {size:>9} | {seconds:>8.2} | {peak:>6.0} | {exponent:>8}",
            self.command
        );
        self.before = Some((size, seconds));
    }
}

/// CPU seconds and megabytes of a command; `None` if it fails or takes too long.
fn run(
    folder: &Path,
    command: &str,
    files: &[impl AsRef<Path>],
    arguments: &[&str],
) -> Option<(f64, f64)> {
    let mut process = Command::new(env!("CARGO_BIN_EXE_azulejo"))
        .current_dir(folder)
        .arg(command)
        .args(files.iter().map(AsRef::as_ref))
        .args(arguments)
        .arg("--json")
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program runs");
    let start = Instant::now();
    while process.try_wait().expect("a process").is_none() {
        if start.elapsed() > LONGEST {
            process.kill().expect("a process");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = process.wait_with_output().expect("a process");
    let report: Value = serde_json::from_slice(&output.stdout).ok()?;
    let number = |key: &str| report[key].as_f64();
    Some((number("cpu_seconds")?, number("peak_memory_bytes")? / 1e6))
}
