//! Time until a large model is visible, frame times while the solver runs, and memory use:
//! `cargo bench -p azulejo-workbench --bench session`.
//!
//! The whole window is drawn without a display by the installed driver: widgets, the model and
//! egui's own pass, until the GPU has finished. Without a driver it prints a note and ends.

// A benchmark prints its results.
#![allow(clippy::print_stdout)]

use azulejo::models;
use azulejo::scene::{Material, Mesh, Object, Rgb, Scene, Shape};
use azulejo::trace::Progress;
use azulejo_workbench::app::App;
use azulejo_workbench::command::Command;
use azulejo_workbench::first_pass::LightSettings;
use azulejo_workbench::gpu::HeadlessDevice;
use azulejo_workbench::jobs::JobKind;
use azulejo_workbench::ui::{Viewport, Workbench};
use azulejo_workbench::view::{ModelView, Shading};
use egui_kittest::Harness;
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Size of the window, points.
const SIZE: [f32; 2] = [1280.0, 800.0];

fn main() {
    if let Err(why) = HeadlessDevice::open(wgpu::Backends::all()) {
        println!("skipped: {why}");
        return;
    }
    let folder = std::env::temp_dir().join(format!("azulejo-session-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    large_model(&folder);
    while_solving(&folder);
    let _ = std::fs::remove_dir_all(folder);
}

/// A model of a million triangles: loading, the first frame, further frames, memory.
fn large_model(folder: &Path) {
    let path = folder.join("large.ply");
    let (triangles, bytes) = write_large(&path);
    let before = resident();
    let mut window = window();
    let empty = resident();
    let begin = Instant::now();
    window.state_mut().app.execute(Command::Open(vec![path]));
    while window.state().app.is_busy(JobKind::Load) {
        window.state_mut().app.poll();
        std::thread::sleep(Duration::from_millis(1));
    }
    let read = begin.elapsed();
    let loaded = resident();
    frame(&mut window);
    let first = begin.elapsed() - read;
    println!("{triangles} triangles, {:.1} MB as a scene", mega(bytes));
    println!(
        "  reading the file                {:>8.2} s",
        read.as_secs_f64()
    );
    println!(
        "  from there to the first picture {:>8.2} s",
        first.as_secs_f64()
    );
    let orbit: Vec<Duration> = (0..20).map(|_| orbited(&mut window)).collect();
    println!("  a picture while orbiting        {}", spread(orbit));
    let still: Vec<Duration> = (0..20).map(|_| frame(&mut window)).collect();
    println!("  a frame without a new picture   {}", spread(still));
    let answers: Vec<Duration> = (0..20).map(|_| step(&mut window)).collect();
    println!("  the interface's own work        {}", spread(answers));
    let after = resident();
    println!(
        "  memory: the window alone {:.0} MB, what was read {:.0} MB, what is shown {:.0} MB, \
         together {:.2} times the scene",
        mega(empty.saturating_sub(before)),
        mega(loaded.saturating_sub(empty)),
        mega(after.saturating_sub(loaded)),
        after.saturating_sub(empty) as f64 / bytes as f64
    );
}

/// Frame times while the solver runs.
fn while_solving(folder: &Path) {
    let path = folder.join("cornell.grf");
    let variant = azulejo::scene::synthetic::CornellVariant::Diffuse;
    let scene = azulejo::scene::synthetic::cornell_box(variant);
    models::write(&scene, &path, &Progress::new()).expect("a written file");
    let mut window = window();
    let app = &mut window.state_mut().app;
    app.execute(Command::Open(vec![path]));
    settle(app);
    app.execute(Command::SetLight(LightSettings {
        patches: 6_000,
        error: 0.005,
        ..LightSettings::default()
    }));
    shade(app, Shading::Irradiance);
    app.execute(Command::Solve);
    let (mut answers, mut still, mut orbit) = (Vec::new(), Vec::new(), Vec::new());
    let begin = Instant::now();
    while window.state().app.is_busy(JobKind::Solve) && begin.elapsed() < Duration::from_secs(20) {
        answers.push(step(&mut window));
        still.push(frame(&mut window));
        orbit.push(orbited(&mut window));
        std::thread::sleep(Duration::from_millis(5));
    }
    let seen = window.state().app.lighting.solution.is_some();
    window.state_mut().app.execute(Command::StopSolving);
    println!("the Cornell box while 6,000 patches are solved (light seen: {seen})");
    println!("  the interface's own work        {}", spread(answers));
    println!("  a frame of the window           {}", spread(still));
    println!("  a frame that turns the model    {}", spread(orbit));
}

fn window() -> Harness<'static, Workbench> {
    let mut window = Harness::builder()
        .with_size(SIZE)
        .wgpu()
        .build_eframe(|context| {
            let viewport = Viewport::of_window(context).expect("a driver that draws");
            Workbench::in_window(App::quiet(), viewport, context)
        });
    frame(&mut window);
    window
}

/// The CPU part of a frame: handles events, executes commands and lays out the widgets.
fn step(window: &mut Harness<'_, Workbench>) -> Duration {
    let begin = Instant::now();
    window.step();
    begin.elapsed()
}

/// One complete frame including reading the pixels back, which a window on a screen does not do.
fn frame(window: &mut Harness<'_, Workbench>) -> Duration {
    let begin = Instant::now();
    window.step();
    window.render().expect("a picture of the window");
    begin.elapsed()
}

fn orbited(window: &mut Harness<'_, Workbench>) -> Duration {
    let app = &mut window.state_mut().app;
    let mut view: ModelView = app.view.clone();
    view.orbit(0.05, 0.01, DVec3::Y);
    app.execute(Command::SetView(Box::new(view)));
    frame(window)
}

fn shade(app: &mut App, shading: Shading) {
    let mut view = app.view.clone();
    view.shading = shading;
    app.execute(Command::SetView(Box::new(view)));
}

fn settle(app: &mut App) {
    while !app.jobs().is_empty() {
        app.poll();
        std::thread::sleep(Duration::from_millis(1));
    }
    app.poll();
}

/// Writes a wavy sheet of a million triangles as binary PLY; returns the number of triangles and
/// the size of the scene in bytes.
fn write_large(path: &Path) -> (usize, u64) {
    const SIDE: u32 = 708;
    let mut mesh = Mesh::default();
    for j in 0..=SIDE {
        for i in 0..=SIDE {
            let (x, z) = (f64::from(i) / 100.0, f64::from(j) / 100.0);
            mesh.positions
                .push(DVec3::new(x, 0.3 * (x * 3.0).sin() * (z * 2.0).cos(), z));
        }
    }
    let row = SIDE + 1;
    for j in 0..SIDE {
        for i in 0..SIDE {
            let a = j * row + i;
            mesh.push_face(&[a, a + row, a + 1], 0);
            mesh.push_face(&[a + 1, a + row, a + row + 1], 0);
        }
    }
    let triangles = mesh.faces.len();
    let bytes = 24 * mesh.positions.len() + 4 * (mesh.faces.corners.len() + 2 * triangles);
    let mut scene = Scene::default();
    scene.add_material(Material::diffuse("grey", Rgb::grey(0.6)));
    scene.objects.push(Object::new("sheet", Shape::Mesh(mesh)));
    models::write(&scene, &PathBuf::from(path), &Progress::new()).expect("a written file");
    (triangles, bytes as u64)
}

fn spread(mut times: Vec<Duration>) -> String {
    times.sort();
    let at = |share: f64| {
        let last = times.len().saturating_sub(1);
        let k = (share * last as f64).round() as usize;
        times.get(k).map_or(0.0, |t| 1e3 * t.as_secs_f64())
    };
    format!(
        "{:>7.1} ms median, {:>7.1} ms of 19 in 20, {:>7.1} ms at most, of {}",
        at(0.5),
        at(0.95),
        at(1.0),
        times.len()
    )
}

fn mega(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}

/// Resident memory of the process in bytes, on Linux.
fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = text
        .split_whitespace()
        .nth(1)
        .and_then(|w| w.parse::<u64>().ok());
    4096 * pages.unwrap_or(0)
}
