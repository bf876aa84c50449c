//! Speed of building and tracing, beside Embree's where that is installed.
//!
//! `cargo bench -p azulejo-trace --bench rays [-- scene] [-- quick]`. Everything runs on one
//! thread and is measured in CPU time where the system tells it (Linux), so that other work on
//! the machine matters less; each figure is the median of several repetitions that alternate
//! between the two. Ratios above 1 are in azulejo's favour.
#![allow(clippy::print_stdout, reason = "a benchmark prints its table")]

#[path = "rays/embree.rs"]
mod embree;

use azulejo_scene::math::{Frame, Ray};
use azulejo_scene::synthetic::{self, CornellVariant};
use azulejo_scene::{Scene, Shape};
use azulejo_trace::{KernelHit, KernelRay, Tracer};
use embree::Embree;
use glam::DVec3;
use std::time::Instant;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let repetitions = if words.iter().any(|w| w == "quick") {
        3
    } else {
        9
    };
    match Embree::version() {
        Some(major) => println!("Embree {major} found: ratios are azulejo / Embree."),
        None => println!("No Embree on this machine: absolute figures only."),
    }
    let scenes: [(&str, fn() -> Scene, Kind); 3] = [
        (
            "room 250k, cosine",
            || synthetic::furnished_room(250_000),
            Kind::Surface,
        ),
        (
            "model 1.5M, primary",
            || synthetic::displaced_sphere(1_500_000),
            Kind::Primary,
        ),
        (
            "cornell box, cosine",
            || synthetic::cornell_box(CornellVariant::Diffuse),
            Kind::Surface,
        ),
    ];
    println!("build: M triangles/s; trace: M rays/s; one thread, CPU time\n");
    for (name, make, kind) in scenes {
        let wanted = words
            .iter()
            .filter(|w| *w != "quick" && !w.starts_with('-'));
        if wanted.clone().count() == 0 || wanted.clone().any(|w| name.contains(w.as_str())) {
            measure(name, &make(), kind, repetitions);
        }
    }
}

/// Where rays start.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Cosine-distributed rays from random surface points; for any hit, segments between them.
    Surface,
    /// A camera of odd width that looks along an axis; the same rays for any hit.
    Primary,
}

fn measure(name: &str, scene: &Scene, kind: Kind, repetitions: usize) {
    let (tracer, whole) = on_one_thread(|| {
        let mut tracer = None;
        let seconds = cpu_seconds(|| tracer = Some(Tracer::new(scene)));
        (tracer.expect("built"), seconds)
    });
    let soup = Soup::new(scene, &tracer);
    let millions = soup.triangles.len() as f64 * 1e-6;
    println!("{name}: {} triangles", soup.triangles.len());
    println!("  build                    {:7.2}", millions / whole);
    let (closest_rays, any_rays) = rays(&tracer, &soup, kind);
    let mut ours = Times::default();
    let (mut hits, mut blocked) = (Vec::new(), Vec::new());
    let mut rivals: Vec<(&str, Embree, Times)> = Vec::new();
    for (label, robust) in [("Embree", false), ("Embree robust", true)] {
        let time = |commit: &mut dyn FnMut()| cpu_seconds(commit);
        if let Some((embree, seconds)) = Embree::new(&soup.vertices, &soup.triangles, robust, time)
        {
            println!("  build {label:18} {:7.2}", millions / seconds);
            rivals.push((label, embree, Times::default()));
        }
    }
    let (mut other_hits, mut other_blocked) = (Vec::new(), Vec::new());
    for _ in 0..repetitions {
        ours.closest
            .push(cpu_seconds(|| tracer.closest(&closest_rays, &mut hits)));
        for (_, embree, times) in &mut rivals {
            let run = || embree.closest(&closest_rays, &mut other_hits);
            times.closest.push(cpu_seconds(run));
            times.differing_closest = differing(&hits, &other_hits);
        }
        ours.any
            .push(cpu_seconds(|| tracer.any(&any_rays, &mut blocked)));
        for (_, embree, times) in &mut rivals {
            times
                .any
                .push(cpu_seconds(|| embree.any(&any_rays, &mut other_blocked)));
            let pairs = blocked.iter().zip(&other_blocked);
            times.differing_any = pairs.filter(|(a, b)| a != b).count();
        }
    }
    let (n, m) = (
        closest_rays.len() as f64 * 1e-6,
        any_rays.len() as f64 * 1e-6,
    );
    let (c, a) = (median(&ours.closest), median(&ours.any));
    println!(
        "  azulejo        closest {:7.2}             any {:7.2}",
        n / c,
        m / a
    );
    for (label, _, times) in &rivals {
        let ratio = |theirs: &[f64], ours: &[f64]| {
            let ratios: Vec<f64> = theirs.iter().zip(ours).map(|(t, o)| t / o).collect();
            median(&ratios)
        };
        println!(
            "  {label:14} closest {:7.2} ratio {:5.2} any {:7.2} ratio {:5.2}; differing: {} of {} closest, {} of {} any",
            n / median(&times.closest),
            ratio(&times.closest, &ours.closest),
            m / median(&times.any),
            ratio(&times.any, &ours.any),
            times.differing_closest,
            closest_rays.len(),
            times.differing_any,
            any_rays.len(),
        );
    }
    let found = hits.iter().filter(|h| h.is_hit()).count();
    let shadowed = blocked.iter().filter(|&&b| b).count();
    println!(
        "  {found} of {} closest rays hit, {shadowed} of {} segments are blocked\n",
        hits.len(),
        blocked.len()
    );
}

#[derive(Default)]
struct Times {
    closest: Vec<f64>,
    any: Vec<f64>,
    differing_closest: usize,
    differing_any: usize,
}

/// Rays whose hits differ: one misses, or another triangle is met at another distance. The two
/// triangles of a shared edge are both right.
fn differing(ours: &[KernelHit], theirs: &[KernelHit]) -> usize {
    let differ = |(a, b): &(&KernelHit, &KernelHit)| {
        a.is_hit() != b.is_hit() || (a.item != b.item && (a.t - b.t).abs() > 1e-4 * a.t.abs())
    };
    ours.iter().zip(theirs).filter(differ).count()
}

/// A scene's triangles in the tracer's own coordinates and in the order of its items, so that
/// both tracers get the same numbers.
struct Soup {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    corners: Vec<[DVec3; 3]>,
}

impl Soup {
    fn new(scene: &Scene, tracer: &Tracer) -> Soup {
        let mut soup = Soup {
            vertices: Vec::new(),
            triangles: Vec::new(),
            corners: Vec::new(),
        };
        for object in &scene.objects {
            let Shape::Mesh(mesh) = &object.shape else {
                continue;
            };
            let base = soup.vertices.len() as u32;
            let local = |&p: &DVec3| tracer.kernel_ray(&Ray::new(p, DVec3::X)).origin;
            soup.vertices.extend(mesh.positions.iter().map(local));
            for (face, corners) in mesh.faces.iter().enumerate() {
                for t in mesh.triangulate(face) {
                    let vertices = t.map(|k| corners[k as usize]);
                    soup.triangles.push(vertices.map(|v| base + v));
                    soup.corners
                        .push(vertices.map(|v| mesh.positions[v as usize]));
                }
            }
        }
        soup
    }

    /// A random point, uniform over triangles, and the normal of its triangle.
    fn point(&self, random: &mut Random) -> (DVec3, DVec3) {
        let k = (random.next() * self.corners.len() as f64) as usize;
        let [a, b, c] = self.corners[k];
        let (r, s) = (random.next().sqrt(), random.next());
        let p = (1.0 - r) * a + r * (1.0 - s) * b + r * s * c;
        (p, (b - a).cross(c - a).normalize())
    }
}

fn rays(tracer: &Tracer, soup: &Soup, kind: Kind) -> (Vec<KernelRay>, Vec<KernelRay>) {
    if kind == Kind::Primary {
        let size = 701;
        let at = |k: usize| (k as f64 + 0.5) / f64::from(size) - 0.5;
        let ray = |k: usize| {
            let (x, y) = (at(k % size as usize), at(k / size as usize));
            tracer.kernel_ray(&Ray::new(DVec3::new(0.0, 0.0, 3.0), DVec3::new(x, y, -1.0)))
        };
        let rays: Vec<KernelRay> = (0..(size * size) as usize).map(ray).collect();
        return (rays.clone(), rays);
    }
    let mut random = Random(1);
    let count = 300_000;
    let closest = (0..count)
        .map(|_| {
            let (p, n) = soup.point(&mut random);
            let (r, phi) = (random.next().sqrt(), std::f64::consts::TAU * random.next());
            let local = DVec3::new(r * phi.cos(), r * phi.sin(), (1.0 - r * r).sqrt());
            let direction = Frame::from_normal(n).to_world(local);
            tracer.kernel_ray(&Ray::new(tracer.leaving(p, n), direction))
        })
        .collect();
    let any = (0..count)
        .map(|_| {
            let ((p, m), (q, n)) = (soup.point(&mut random), soup.point(&mut random));
            let (from, to) = (tracer.leaving(p, m), tracer.leaving(q, n));
            tracer.kernel_ray(&Ray::between(from, to))
        })
        .collect();
    (closest, any)
}

/// SplitMix64; numbers in 0..1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("a pool of one thread").install(work)
}

/// CPU seconds that this thread spends on `work`; wall-clock seconds where the system keeps no
/// account of it.
fn cpu_seconds(work: impl FnOnce()) -> f64 {
    let account = || -> Option<f64> {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
        Some(nanoseconds * 1e-9)
    };
    let (before, start) = (account(), Instant::now());
    work();
    let wall = start.elapsed().as_secs_f64();
    match (before, account()) {
        (Some(before), Some(after)) if after > before => after - before,
        _ => wall,
    }
}
