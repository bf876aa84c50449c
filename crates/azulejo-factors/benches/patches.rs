//! How fast faces are divided and hits are located: patches per second, nanoseconds per hit.

#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo_factors::{PatchSize, Patches};
use azulejo_scene::synthetic::{CornellVariant, cornell_box, furnished_room};
use azulejo_scene::{Mesh, Object, Scene, Shape};
use glam::DVec3;
use std::hint::black_box;
use std::time::Instant;

fn main() {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let trapezoid = [(0.0, 0.0), (1.0, 0.0), (0.62, 0.6), (0.38, 0.6)];
    let l = [
        (0.0, 0.0),
        (1.0, 0.0),
        (1.0, 0.4),
        (0.4, 0.4),
        (0.4, 1.0),
        (0.0, 1.0),
    ];
    for count in [10_000, 1_000_000] {
        report("one square", &[Shape::Mesh(polygon(&square))], count);
        report("one triangle", &[Shape::Mesh(polygon(&square[..3]))], count);
        report("one trapezoid", &[Shape::Mesh(polygon(&trapezoid))], count);
        report("one L", &[Shape::Mesh(polygon(&l))], count);
    }
    let hills = hills(512);
    report("524k triangles", &[Shape::Mesh(hills)], 1);
    // Scenes whose faces touch: their contacts are found and cut.
    let shapes =
        |scene: Scene| -> Vec<Shape> { scene.objects.into_iter().map(|o| o.shape).collect() };
    report(
        "cornell box",
        &shapes(cornell_box(CornellVariant::Diffuse)),
        2_500,
    );
    report("room, 200k", &shapes(furnished_room(200_000)), 100_000);
}

fn polygon(outline: &[(f64, f64)]) -> Mesh {
    let mut mesh = Mesh::default();
    let corner = |p: &(f64, f64)| DVec3::new(p.0, p.1, 0.0);
    mesh.positions = outline.iter().map(corner).collect();
    let ring: Vec<u32> = (0..outline.len() as u32).collect();
    mesh.push_face(&ring, 0);
    mesh
}

fn hills(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for (i, j) in (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))) {
        let (x, y) = (f64::from(i), f64::from(j));
        mesh.positions
            .push(DVec3::new(x, y, (0.1 * x).sin() + (0.13 * y).cos()));
    }
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let p = j * (n + 1) + i;
        mesh.push_face(&[p, p + 1, p + n + 2], 0);
        mesh.push_face(&[p, p + n + 2, p + n + 1], 0);
    }
    mesh
}

fn report(name: &str, shapes: &[Shape], count: usize) {
    let mut scene = Scene::default();
    scene
        .objects
        .extend(shapes.iter().map(|s| Object::new(name, s.clone())));
    let start = Instant::now();
    let patches = Patches::new(&scene, PatchSize::Count(count));
    let seconds = start.elapsed().as_secs_f64();
    let rate = patches.len() as f64 / seconds;
    println!(
        "{name:>16}: {:>8} patches, {:>6.2} M/s, locate {:>5.1} ns, sample {:>5.1} ns",
        patches.len(),
        rate * 1e-6,
        locate_nanoseconds(&scene, &patches),
        sample_nanoseconds(&patches),
    );
}

const CALLS: u32 = 4_000_000;

/// Random order of lookups, as the hits of a diffuse patch have it.
fn scattered() -> impl FnMut() -> u32 {
    let mut state = 1u64;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 32) as u32
    }
}

fn locate_nanoseconds(scene: &Scene, patches: &Patches) -> f64 {
    let Shape::Mesh(mesh) = &scene.objects[0].shape else {
        return 0.0;
    };
    let mut next = scattered();
    let hits: Vec<(u32, u32, f32, f32)> = (0..CALLS)
        .map(|_| {
            let face = next() % mesh.faces.len() as u32;
            let triangles = mesh.faces.get(face as usize).len() as u32 - 2;
            let (u, v) = (next() as f32 / 4.3e9, next() as f32 / 4.3e9);
            let (u, v) = if u + v > 1.0 {
                (1.0 - u, 1.0 - v)
            } else {
                (u, v)
            };
            (face, next() % triangles, u, v)
        })
        .collect();
    fastest(&hits, |&(face, triangle, u, v)| {
        black_box(patches.locate(0, face, triangle, u, v));
    })
}

fn sample_nanoseconds(patches: &Patches) -> f64 {
    // Each patch is sampled many times in a row.
    let points: Vec<(usize, f64)> = (0..CALLS)
        .map(|k| (k as usize / 64 % patches.len(), f64::from(k % 64) / 64.0))
        .collect();
    fastest(&points, |&(i, u)| {
        black_box(patches.sample(i, u, 0.6));
    })
}

/// Nanoseconds per item; the fastest of many batches, because other programs only slow one down.
fn fastest<T>(items: &[T], mut each: impl FnMut(&T)) -> f64 {
    let batches = items.chunks(20_000).map(|batch| {
        let start = Instant::now();
        batch.iter().for_each(&mut each);
        start.elapsed().as_nanos() as f64 / batch.len() as f64
    });
    batches.fold(f64::INFINITY, f64::min)
}
