//! A mesh of a million triangles: upload and first frame, further frames, picking.
//!
//! `cargo bench -p azulejo-workbench --bench viewport` runs on each graphics API that has a driver;
//! `WGPU_BACKEND=vulkan` or `gl` narrows them. Wall-clock times at 1280 x 720 pixels; a frame
//! ends when the GPU has finished it.
#![allow(clippy::print_stdout, reason = "a benchmark prints its table")]

use azulejo::scene::math::Ray;
use azulejo::scene::synthetic::displaced_sphere;
use azulejo::scene::{Camera, Material, Mesh, Rgb, Shape};
use azulejo_workbench::gpu::{DrawnMesh, HeadlessDevice, Overlay, Renderer, ViewportFrame, pick};
use azulejo_workbench::view::Shading;
use glam::DVec3;
use std::time::Instant;

const SIZE: [u32; 2] = [1280, 720];
const MODES: [Shading; 7] = [
    Shading::Gouraud,
    Shading::Flat,
    Shading::Irradiance,
    Shading::FalseColor,
    Shading::HiddenLines,
    Shading::Patches,
    Shading::Points,
];

fn main() {
    let mesh = million();
    let camera = Camera::framing(mesh.bounds(), 16.0 / 9.0, DVec3::Y);
    println!(
        "{} triangles, {} vertices, {} MB in memory; {} threads",
        mesh.faces.triangle_count(),
        mesh.positions.len(),
        bytes_of(&mesh) >> 20,
        rayon::current_num_threads()
    );
    for (name, backends) in [
        ("Vulkan", wgpu::Backends::VULKAN),
        ("OpenGL", wgpu::Backends::GL),
    ] {
        match HeadlessDevice::open(backends) {
            Ok(card) => {
                println!("{name}: {}", card.device.adapter_info().name);
                measure(card, &mesh, &camera);
            }
            Err(e) => println!("{name}: {e}"),
        }
    }
    picking(&mesh, &camera);
}

/// A sphere of about a million triangles, with irradiance.
fn million() -> Mesh {
    let scene = displaced_sphere(1_000_000);
    let shapes = scene.objects.into_iter().map(|o| o.shape);
    let meshes = shapes.filter_map(|shape| match shape {
        Shape::Mesh(mesh) => Some(mesh),
        _ => None,
    });
    let mut mesh = meshes.max_by_key(|m| m.faces.len()).unwrap_or_default();
    let light = |p: &DVec3| Rgb::grey(1.0 + p.normalize_or_zero().y);
    mesh.irradiance = mesh.positions.iter().map(light).collect();
    mesh
}

fn bytes_of(mesh: &Mesh) -> usize {
    let normals = mesh.normals.as_ref().map_or(0, |n| n.values.len());
    24 * (mesh.positions.len() + normals + mesh.irradiance.len())
        + 4 * (mesh.faces.corners.len() + mesh.faces.starts.len() + mesh.face_materials.len())
}

fn measure(card: HeadlessDevice, mesh: &Mesh, camera: &Camera) {
    let white = Material::diffuse("", Rgb::grey(0.8));
    let materials = [&white; 4];
    let drawn = [DrawnMesh::new(1, mesh)];
    let device = card.device.clone();
    let mut renderer = match Renderer::new(card.device, card.queue) {
        Ok(renderer) => renderer,
        Err(e) => return println!("  {e}"),
    };
    let mut frame = ViewportFrame::new(SIZE, camera, &drawn, &materials);
    frame.overlay = Overlay::none();
    println!("  mode          first ms   next ms   next without antialiasing ms   bytes/triangle");
    for shading in MODES {
        renderer.forget();
        frame.shading = shading;
        frame.antialiasing = true;
        let mut draw = |frame: &ViewportFrame| {
            let start = Instant::now();
            if let Err(e) = renderer.draw(frame) {
                println!("  {e}");
            }
            // If this fails the times are wrong, and the next frame reports the reason.
            let _ = device.poll(wgpu::PollType::wait_indefinitely());
            let bytes = renderer.statistics().bytes_loaded;
            (1e3 * start.elapsed().as_secs_f64(), bytes)
        };
        let (first, bytes) = draw(&frame);
        let next = (0..3).map(|_| draw(&frame).0).fold(f64::MAX, f64::min);
        frame.antialiasing = false;
        let rough = (0..3).map(|_| draw(&frame).0).fold(f64::MAX, f64::min);
        let share = bytes as f64 / mesh.faces.triangle_count() as f64;
        let name = format!("{shading:?}");
        println!("  {name:12} {first:9.0} {next:9.0} {rough:30.0} {share:16.1}");
    }
}

fn picking(mesh: &Mesh, camera: &Camera) {
    let drawn = [DrawnMesh::new(1, mesh)];
    let rays: Vec<Ray> = (0..20)
        .map(|k| camera.ray(0.5, f64::from(k) / 20.0, 16.0 / 9.0))
        .collect();
    let start = Instant::now();
    let met = rays.iter().filter(|r| pick(&drawn, r, false).is_some());
    let met = met.count();
    let each = 1e3 * start.elapsed().as_secs_f64() / rays.len() as f64;
    println!(
        "picking: {each:.1} ms each, {met} of {} rays met",
        rays.len()
    );
}
