//! Speed of building and tracing, beside Embree's if that is installed.
//!
//! `cargo bench -p azulejo-trace --bench rays -- [room|model|cornell] [quick]`.
//! Everything runs on one thread and is
//! measured in CPU time where the system reports it (Linux), so that other work on the machine
//! matters less; each figure is the median of several repetitions that alternate between the two.
//! Ratios above 1 are in azulejo's favour.
#![allow(clippy::print_stdout, reason = "a benchmark prints its table")]

use azulejo_scene::math::{Frame, Ray};
use azulejo_scene::synthetic::{self, CornellVariant};
use azulejo_scene::{Scene, Shape};
use azulejo_trace::{KernelHit, KernelRay, Tracer};
use glam::DVec3;
use std::time::Instant;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let quick = words.iter().any(|w| w == "quick");
    let repetitions = if quick { 3 } else { 9 };
    let embree = rival::find();
    match &embree {
        Ok(embree) => println!(
            "Embree {} found: ratios are azulejo / Embree.",
            embree.version()
        ),
        Err(reason) => println!("Absolute figures only: {reason}."),
    }
    println!("build: M triangles/s; trace: M rays/s; one thread, CPU time\n");
    let mut wanted = words
        .iter()
        .filter(|w| *w != "quick" && !w.starts_with('-'));
    let wanted: Option<&String> = wanted.next();
    let run = |name: &str, make: &dyn Fn() -> Scene, start: Start| {
        if wanted.is_none_or(|w| name.contains(w.as_str())) {
            measure(name, &make(), start, repetitions, embree.as_ref().ok());
        }
    };
    let room = || synthetic::furnished_room(250_000);
    run("room 250k, cosine", &room, Start::Surface);
    let model = || synthetic::displaced_sphere(1_500_000);
    run("model 1.5M, primary", &model, Start::Primary);
    let cornell = || synthetic::cornell_box(CornellVariant::Diffuse);
    run("cornell box, cosine", &cornell, Start::Surface);
}

/// Where rays start.
#[derive(Clone, Copy, PartialEq)]
enum Start {
    /// Cosine-distributed rays from random surface points; for any hit, segments between them.
    Surface,
    /// A camera of odd width, directed along an axis; the same rays for any hit.
    Primary,
}

/// The rays of one scene.
struct Rays {
    closest: Vec<KernelRay>,
    any: Vec<KernelRay>,
    /// How often they are traced in one measurement.
    passes: usize,
}

/// A tracer's answers, and seconds per pass for each repetition.
#[derive(Default)]
struct Runs {
    hits: Vec<KernelHit>,
    blocked: Vec<bool>,
    closest: Vec<f64>,
    any: Vec<f64>,
}

fn measure(
    name: &str,
    scene: &Scene,
    start: Start,
    repetitions: usize,
    embree: Option<&rival::Embree>,
) {
    let (tracer, seconds) = on_one_thread(|| {
        let mut tracer = None;
        let seconds = cpu_seconds(|| tracer = Some(Tracer::new(scene)));
        (tracer.expect("built"), seconds)
    });
    let soup = TriangleSoup::new(scene, &tracer);
    let millions = soup.triangles.len() as f64 * 1e-6;
    println!("{name}: {} triangles", soup.triangles.len());
    println!("  build azulejo        {:7.2}", millions / seconds);
    let rays = rays(&tracer, &soup, start);
    let mut ours = Runs::default();
    let mut rivals: Vec<(&str, rival::EmbreeScene, Runs)> = Vec::new();
    for (label, robust) in [("Embree", false), ("Embree robust", true)] {
        let Some(embree) = embree else { break };
        let mut built = None;
        let seconds = cpu_seconds(|| built = rival::build(embree, &soup, robust));
        if let Some(scene) = built {
            println!("  build {label:14} {:7.2}", millions / seconds);
            rivals.push((label, scene, Runs::default()));
        }
    }
    // All take turns, so that the machine's other work hits them alike.
    for _ in 0..repetitions {
        ours.closest(&rays, |rays, hits| tracer.closest(rays, hits));
        for (_, embree, runs) in &mut rivals {
            runs.closest(&rays, |rays, hits| {
                hits.resize(rays.len(), KernelHit::NOTHING);
                embree.closest(rays, hits);
            });
        }
        ours.any(&rays, |rays, blocked| tracer.any(rays, blocked));
        for (_, embree, runs) in &mut rivals {
            runs.any(&rays, |rays, blocked| {
                blocked.resize(rays.len(), false);
                embree.any(rays, blocked);
            });
        }
    }
    ours.report(&rays);
    for (label, _, runs) in &rivals {
        ours.report_beside(label, runs, &rays);
    }
}

impl Runs {
    fn closest(&mut self, rays: &Rays, trace: impl Fn(&[KernelRay], &mut Vec<KernelHit>)) {
        let run = || (0..rays.passes).for_each(|_| trace(&rays.closest, &mut self.hits));
        self.closest.push(cpu_seconds(run) / rays.passes as f64);
    }

    fn any(&mut self, rays: &Rays, trace: impl Fn(&[KernelRay], &mut Vec<bool>)) {
        let run = || (0..rays.passes).for_each(|_| trace(&rays.any, &mut self.blocked));
        self.any.push(cpu_seconds(run) / rays.passes as f64);
    }

    /// Millions of rays per second, for closest and any hit.
    fn rates(&self, rays: &Rays) -> (f64, f64) {
        let rate = |rays: &[KernelRay], times: &[f64]| rays.len() as f64 * 1e-6 / median(times);
        (
            rate(&rays.closest, &self.closest),
            rate(&rays.any, &self.any),
        )
    }

    fn report(&self, rays: &Rays) {
        let (closest, any) = self.rates(rays);
        println!("  azulejo        closest {closest:6.2}            any {any:6.2}");
        let hit = self.hits.iter().filter(|h| h.is_hit()).count();
        let blocked = self.blocked.iter().filter(|&&b| b).count();
        println!(
            "  ({hit} of {} closest rays hit, {blocked} of {} any-hit rays are blocked)",
            self.hits.len(),
            self.blocked.len()
        );
    }

    fn report_beside(&self, label: &str, other: &Runs, rays: &Rays) {
        let ratio = |theirs: &[f64], ours: &[f64]| {
            let ratios: Vec<f64> = theirs.iter().zip(ours).map(|(t, o)| t / o).collect();
            median(&ratios)
        };
        let (closest, any) = other.rates(rays);
        let pairs = self.blocked.iter().zip(&other.blocked);
        println!(
            "  {label:14} closest {closest:6.2} ratio {:4.2} any {any:6.2} ratio {:4.2}; differing: {} closest, {} any",
            ratio(&other.closest, &self.closest),
            ratio(&other.any, &self.any),
            differing(&self.hits, &other.hits),
            pairs.filter(|(a, b)| a != b).count(),
        );
    }
}

/// Rays whose hits differ: one misses, or another triangle is hit at another distance. The two
/// triangles of a shared edge are both right.
fn differing(ours: &[KernelHit], theirs: &[KernelHit]) -> usize {
    let differ = |(a, b): &(&KernelHit, &KernelHit)| {
        a.is_hit() != b.is_hit() || (a.item != b.item && (a.t - b.t).abs() > 1e-4 * a.t.abs())
    };
    ours.iter().zip(theirs).filter(differ).count()
}

/// A scene's triangles in the tracer's own coordinates and in the order of its items, so that
/// both tracers get the same numbers.
struct TriangleSoup {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    corners: Vec<[DVec3; 3]>,
}

impl TriangleSoup {
    fn new(scene: &Scene, tracer: &Tracer) -> TriangleSoup {
        let mut soup = TriangleSoup {
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

fn rays(tracer: &Tracer, soup: &TriangleSoup, start: Start) -> Rays {
    if start == Start::Primary {
        let size = 701;
        let at = |k: usize| (k as f64 + 0.5) / f64::from(size) - 0.5;
        let ray = |k: usize| {
            let (x, y) = (at(k % size as usize), at(k / size as usize));
            tracer.kernel_ray(&Ray::new(DVec3::new(0.0, 0.0, 3.0), DVec3::new(x, y, -1.0)))
        };
        let rays: Vec<KernelRay> = (0..(size * size) as usize).map(ray).collect();
        return Rays {
            closest: rays.clone(),
            any: rays,
            passes: 2,
        };
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
    // The system's account of CPU time is coarse: small scenes are traced more often.
    let passes = if soup.triangles.len() < 1000 { 8 } else { 1 };
    Rays {
        closest,
        any,
        passes,
    }
}

/// Embree, loaded at run time.
mod rival {
    pub use azulejo_trace::embree::{Embree, EmbreeScene};

    pub fn find() -> Result<Embree, String> {
        Embree::load(None).map_err(|error| error.to_string())
    }

    pub fn build(embree: &Embree, soup: &super::TriangleSoup, robust: bool) -> Option<EmbreeScene> {
        let triangle = |k: usize| {
            let corners = soup.triangles[k].map(|v| soup.vertices[v as usize]);
            (corners, k as u32)
        };
        EmbreeScene::new(embree, soup.triangles.len(), triangle, robust).ok()
    }
}

/// Random numbers in 0..1, from a seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        azulejo_scene::random::split_mix64(&mut self.0)
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
