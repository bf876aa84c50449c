//! Whether exact letters are met where they are, and whether what enters leaves.

use crate::curves::Random;
use crate::letters::bevel;
use crate::timed;
use azulejo_scene::math::Ray;
use azulejo_scene::rim::Rim;
use azulejo_scene::{
    BevelProfile, Exact, Figure, Material, Object, Prism, Rgb, Scene, Shape, Solid,
};
use azulejo_trace::{KernelRay, Tracer};
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Letters as they are, with edges cut off, and with round ones.
pub const EDGES: [Option<BevelProfile>; 3] =
    [None, Some(BevelProfile::Chamfer), Some(BevelProfile::Round)];

/// How far chords may leave the curves, in ems, and how far polygons may leave bevels.
const CHORD_ERROR: f64 = 1e-6;
const BEVEL_ERROR: f64 = 2e-5;
/// The letters are that deep, in ems.
const DEPTH: f64 = 0.3;
/// What the rounding of rays to `f32` may add, in ems.
const ROUNDING: f64 = 2e-6;
/// Rays traced together.
const BATCH: usize = 4096;

fn letter(figure: &Arc<Figure>, edge: Option<BevelProfile>) -> Exact {
    Exact::new(vec![Solid::Prism(Prism {
        figure: Arc::clone(figure),
        world_from_figure: DAffine3::from_scale(DVec3::new(1.0, 1.0, DEPTH)),
        material: 0,
        bevel: edge.map(|profile| Arc::new(bevel(profile, DEPTH))),
    })])
}

fn tracer(shape: Shape) -> Tracer {
    let mut scene = Scene::default();
    scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    scene.objects.push(Object::new("letter", shape));
    Tracer::new(&scene)
}

/// From a random point in the box around a letter, half as large again, in a random direction.
fn random_ray(tracer: &Tracer, random: &mut Random) -> Ray {
    let bounds = tracer.bounds();
    let at = DVec3::new(random.next(), random.next(), random.next()) - 0.5;
    let z = 2.0 * random.next() - 1.0;
    let around = glam::DVec2::from_angle(std::f64::consts::TAU * random.next());
    let direction = (around * (1.0 - z * z).sqrt()).extend(z);
    Ray::new(bounds.centre() + 1.5 * at * bounds.size(), direction)
}

/// What a comparison found.
#[derive(Default, Clone, Copy)]
struct Comparison {
    rays: usize,
    hits: usize,
    /// One is met, the other not, or elsewhere.
    differ: usize,
    /// Largest distance between the surfaces among the others, in ems.
    farthest: f64,
}

/// Random rays against exact letters and their polygons.
pub fn against_chords(figures: &[Arc<Figure>], edge: Option<BevelProfile>, quick: bool) {
    let error = edge.map_or(CHORD_ERROR, |_| BEVEL_ERROR);
    let each = if quick {
        20_000
    } else {
        10_000_000 / figures.len() + 1
    };
    let (total, seconds) = timed(|| {
        let all = figures.par_iter().enumerate();
        let all = all.map(|(k, figure)| compare(figure, edge, each, k as u64));
        all.reduce(Comparison::default, |a, b| Comparison {
            rays: a.rays + b.rays,
            hits: a.hits + b.hits,
            differ: a.differ + b.differ,
            farthest: a.farthest.max(b.farthest),
        })
    });
    println!(
        "chords ({edge:?}): {} rays at {} letters beside polygons within {error:.0e} em: {} hits on \
         both, apart at most {:.1e} em; {} rays graze what only one of them has ({seconds:.0} CPU s)",
        total.rays,
        figures.len(),
        total.hits,
        total.farthest,
        total.differ,
    );
}

fn compare(figure: &Arc<Figure>, edge: Option<BevelProfile>, rays: usize, seed: u64) -> Comparison {
    let exact = letter(figure, edge);
    let error = edge.map_or(CHORD_ERROR, |_| BEVEL_ERROR);
    let polygons = tracer(Shape::Mesh(exact.tessellate(error)));
    let exact = tracer(Shape::Exact(exact));
    let mut random = Random(seed);
    let mut result = Comparison {
        rays,
        ..Comparison::default()
    };
    for _ in 0..rays.div_ceil(BATCH) {
        let batch: Vec<Ray> = (0..BATCH)
            .map(|_| random_ray(&exact, &mut random))
            .collect();
        let found = [&exact, &polygons].map(|tracer| {
            let kernel: Vec<KernelRay> = batch.iter().map(|r| tracer.kernel_ray(r)).collect();
            let mut hits = Vec::new();
            tracer.closest(&kernel, &mut hits);
            hits
        });
        for (ray, (a, b)) in batch.iter().zip(found[0].iter().zip(&found[1])) {
            if !a.is_hit() && !b.is_hit() {
                continue;
            }
            if a.is_hit() != b.is_hit() {
                result.differ += 1;
                continue;
            }
            let (a, b) = (exact.resolve(ray, a), polygons.resolve(ray, b));
            // Distance of one surface from the other: along the ray it grows where it grazes.
            let apart = (b.position - a.position).dot(a.normal).abs();
            if a.entering == b.entering && apart <= error + ROUNDING {
                result.hits += 1;
                result.farthest = result.farthest.max(apart);
            } else {
                result.differ += 1;
            }
        }
    }
    result
}

/// What following rays found.
#[derive(Default, Clone, Copy)]
struct Turns {
    rays: usize,
    inside: usize,
    /// Inside, and nothing is met, or something that is entered.
    stays: usize,
    /// Outside, and something is met that is left.
    leaves: usize,
    /// `any` and `closest` disagree.
    disagree: usize,
}

/// Random rays from inside and outside of all glyphs.
pub fn parity(fonts: &[(String, Vec<Arc<Figure>>)], edge: Option<BevelProfile>, quick: bool) {
    let glyphs: usize = fonts.iter().map(|(_, f)| f.len()).sum();
    let each = if quick {
        20_000
    } else {
        100_000_000 / glyphs + 1
    };
    for (name, figures) in fonts {
        let (total, seconds) = timed(|| {
            let all = figures.par_iter().enumerate();
            let all = all.map(|(k, figure)| follow(figure, edge, each, k as u64));
            all.reduce(Turns::default, |a, b| Turns {
                rays: a.rays + b.rays,
                inside: a.inside + b.inside,
                stays: a.stays + b.stays,
                leaves: a.leaves + b.leaves,
                disagree: a.disagree + b.disagree,
            })
        });
        println!(
            "parity ({edge:?}): {name}, {} glyphs, {} rays ({} from inside): {} failures ({} from inside \
             that do not leave, {} from outside that do; closest and any disagree on {}; \
             {seconds:.0} CPU s)",
            figures.len(),
            total.rays,
            total.inside,
            total.stays + total.leaves + total.disagree,
            total.stays,
            total.leaves,
            total.disagree,
        );
    }
}

/// Whether a point is inside a letter; `rim` is its border.
fn is_inside(figure: &Figure, rim: &Rim, edge: Option<BevelProfile>, p: DVec3) -> bool {
    let over = p.truncate();
    let setback = edge.map_or(0.0, |profile| bevel(profile, DEPTH).setback(p.z / DEPTH));
    let is_kept = || setback == 0.0 || rim.nearest(over, setback).is_none();
    (0.0..=DEPTH).contains(&p.z) && figure.contains(over) && is_kept()
}

fn follow(figure: &Arc<Figure>, edge: Option<BevelProfile>, rays: usize, seed: u64) -> Turns {
    let tracer = tracer(Shape::Exact(letter(figure, edge)));
    let rim = Rim::new(figure);
    let mut random = Random(!seed);
    let mut turns = Turns::default();
    let (mut hits, mut blocked) = (Vec::new(), Vec::new());
    for _ in 0..rays.div_ceil(BATCH) {
        let mut ray = || tracer.kernel_ray(&random_ray(&tracer, &mut random));
        let batch: Vec<KernelRay> = (0..BATCH).map(|_| ray()).collect();
        tracer.closest(&batch, &mut hits);
        tracer.any(&batch, &mut blocked);
        turns.rays += batch.len();
        for ((ray, hit), blocked) in batch.iter().zip(&hits).zip(&blocked) {
            // The ray as it was traced, so that both start at one point.
            let ray = tracer.world_ray(ray);
            let is_inside = is_inside(figure, &rim, edge, ray.origin);
            turns.disagree += usize::from(hit.is_hit() != *blocked);
            turns.inside += usize::from(is_inside);
            let enters = hit.is_hit() && tracer.resolve(&ray, hit).entering;
            if is_inside {
                turns.stays += usize::from(!hit.is_hit() || enters);
            } else {
                turns.leaves += usize::from(hit.is_hit() && !enters);
            }
        }
    }
    turns
}
