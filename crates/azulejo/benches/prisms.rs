//! Exact letters beside their tessellation: time, memory, and whether they are right.
//!
//! `cargo bench -p azulejo --bench prisms -- [speed] [memory] [curves] [chords] [parity] [quick]`;
//! all parts if none is named.
//!
//! - `speed`: CPU seconds of a picture of 1280×720, one ray and 17 shadow rays a pixel, of a line
//!   of text and of a page; exact, as polygons in the same kernel, exact with round edges, and by POV-Ray 3.7's
//!   `text` where that program is installed.
//! - `memory`: what a process holds that has read the scene and built its tracer.
//! - `curves`: how many tests of a line with a curve end before its cubic is solved, and how long
//!   a test takes: for both pages and all fonts.
//! - `chords`: rays against polygons that leave the curves by 1e-6, or bevels by 2e-5.
//! - `parity`: whether rays that enter leave, over all glyphs of all fonts, also with bevels.
//!
//! Scenes and fonts come from the folder in the environment variable `AZULEJO_DATA`; without it,
//! letters made up here stand in for them.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

#[path = "prisms/accuracy.rs"]
mod accuracy;
#[path = "prisms/curves.rs"]
mod curves;
#[path = "prisms/letters.rs"]
mod letters;
#[path = "prisms/picture.rs"]
mod picture;
#[path = "prisms/povray.rs"]
mod povray;

use letters::Page;
use nix::sys::resource::{UsageWho, getrusage};
use std::process::Command;

fn main() {
    // Cargo itself passes `--bench`.
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    if let ["hold", page, kind] = words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        return hold(page, kind == "exact");
    }
    let quick = words.iter().any(|w| w == "quick");
    let parts: Vec<&String> = words.iter().filter(|w| *w != "quick").collect();
    let wants = |part: &str| parts.is_empty() || parts.iter().any(|p| *p == part);
    if letters::data().is_none() {
        println!("AZULEJO_DATA is not set: made-up letters stand in for its scenes and fonts");
    }
    let pages = || Page::NAMES.map(Page::load);
    if wants("speed") {
        pages()
            .iter()
            .for_each(|page| speed(page, if quick { 1 } else { 5 }));
    }
    if wants("memory") {
        Page::NAMES.into_iter().for_each(memory);
    }
    if wants("curves") {
        for page in pages() {
            let figures: Vec<_> = page.outlines.into_values().collect();
            curves::measure(&page.name, &figures, quick);
        }
        for (name, figures) in letters::fonts() {
            curves::measure(&name, &figures, quick);
        }
    }
    if wants("chords") {
        let figures: Vec<_> = Page::load("s4page").outlines.into_values().collect();
        accuracy::EDGES
            .into_iter()
            .for_each(|edge| accuracy::against_chords(&figures, edge, quick));
    }
    if wants("parity") {
        let fonts = letters::fonts();
        accuracy::EDGES
            .into_iter()
            .for_each(|edge| accuracy::parity(&fonts, edge, quick));
    }
}

/// CPU seconds of this process so far, or of the processes it has waited for.
fn cpu(who: UsageWho) -> f64 {
    let seconds = |t: nix::sys::time::TimeVal| t.tv_sec() as f64 + t.tv_usec() as f64 * 1e-6;
    let usage = getrusage(who).expect("the system's own numbers");
    seconds(usage.user_time()) + seconds(usage.system_time())
}

/// CPU seconds that `work` takes.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let before = cpu(UsageWho::RUSAGE_SELF);
    let result = work();
    (result, cpu(UsageWho::RUSAGE_SELF) - before)
}

/// The least of several runs, in turns, so that what else the machine does hits all alike.
fn speed(page: &Page, runs: usize) {
    println!(
        "{}: {} glyphs, 1280x720, 1 + 17 rays a pixel, one thread",
        page.name,
        page.glyphs()
    );
    let camera = page.camera();
    let mut best = [f64::INFINITY; 3];
    let mut builds = [0.0; 3];
    let mut rays = [0; 3];
    let scenes = [page.exact(), page.polygons(), page.bevelled()];
    let tracers = [0, 1, 2].map(|k| {
        let (tracer, seconds) = timed(|| azulejo_trace::Tracer::new(&scenes[k]));
        builds[k] = seconds;
        tracer
    });
    for _ in 0..runs {
        for k in 0..3 {
            let (count, seconds) = timed(|| picture::shadows(&tracers[k], &camera, &page.lights()));
            (best[k], rays[k]) = (best[k].min(seconds), count);
        }
    }
    for (k, name) in ["exact", "polygons", "bevelled"].into_iter().enumerate() {
        println!(
            "  {name:9} {:6.2} CPU s ({:.2} M rays, {:.0} ns each; built in {:.3} s)",
            best[k],
            rays[k] as f64 * 1e-6,
            best[k] / rays[k] as f64 * 1e9,
            builds[k],
        );
    }
    println!("  exact / polygons: {:.2}", best[0] / best[1]);
    println!("  bevelled / exact: {:.2}", best[2] / best[0]);
    match povray::seconds(page) {
        Some(seconds) => println!("  POV-Ray   {seconds:6.2} CPU s"),
        None => println!("  POV-Ray is left out: not installed, or without its font"),
    }
}

/// Lets processes of their own hold the scenes, and asks the system how large they are.
fn memory(page: &str) {
    let held = |kind: &str| {
        let program = std::env::current_exe().ok()?;
        let output = Command::new(program)
            .args(["hold", page, kind])
            .output()
            .ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        let numbers: Vec<f64> = text.split_whitespace().flat_map(str::parse).collect();
        (numbers.len() == 3).then(|| [numbers[0], numbers[1], numbers[2]])
    };
    let (Some(exact), Some(polygons)) = (held("exact"), held("polygons")) else {
        return println!("{page}: the system does not tell the size of processes");
    };
    println!("{page}: megabytes of a process with its scene and tracer (before them; peak)");
    for (name, [before, after, peak]) in [("exact", exact), ("polygons", polygons)] {
        println!(
            "  {name:9} {after:7.2} ({before:.2}; {peak:.2}): they take {:.2}",
            after - before
        );
    }
    let ratio = (polygons[1] - polygons[0]) / (exact[1] - exact[0]);
    println!("  polygons / exact: {ratio:.1}");
}

/// Prints the size of this process before it has a scene with its tracer, and with it.
fn hold(page: &str, is_exact: bool) {
    let megabytes = |key: &str| {
        let status = std::fs::read_to_string("/proc/self/status").ok()?;
        let line = status.lines().find_map(|l| l.strip_prefix(key))?;
        let kibibytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
        Some(kibibytes * 1.024e-3)
    };
    let Some(before) = megabytes("VmRSS") else {
        return;
    };
    let scene = if is_exact {
        Page::load(page).exact()
    } else {
        Page::load(page).polygons()
    };
    let tracer = azulejo_trace::Tracer::new(&scene);
    let (after, peak) = (megabytes("VmRSS"), megabytes("VmHWM"));
    println!("{before} {} {}", after.unwrap_or(0.0), peak.unwrap_or(0.0));
    assert!(tracer.item_count() > 0 && !scene.objects.is_empty());
}
