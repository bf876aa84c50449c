//! Hemicubes per second: by the card that is found, by the processor in software, and as rays.
//!
//! `cargo bench -p azulejo-gpu --bench hemicubes -- [room] [thesis] [quick]`; all without words.
//! `WGPU_BACKEND=vulkan` or `gl` chooses the interface. Wall-clock seconds, all threads; the
//! views stand on facets spread over the scene and draw what they see straight. "Rays" are as
//! many as the hemicube has pixels, with the cosine's density, by the tracer's own kernel.
//!
//! `thesis` is the case of B. Sena, "Radiosity with specular surfaces" (2019): the box of 12,922
//! facets at 786,432 samples each, which took 251 s on a GTX 1070 Ti. A real card draws all of
//! it; a software driver a part, and no figure of it says anything about a card.
#![allow(clippy::print_stdout, reason = "a benchmark prints its table")]

use azulejo_gpu::{Backend, Card};
use azulejo_scene::math::{Frame, Ray};
use azulejo_scene::synthetic::{cornell_thesis, room_with_table};
use azulejo_scene::{Scene, Shape};
use azulejo_trace::item_buffer::{
    Beyond, Device, DrawError, Facet, Processor, Settings, View, World,
};
use azulejo_trace::sampling::{SobolTable, cosine_about, seeds};
use azulejo_trace::{KernelRay, Tracer};
use glam::DVec3;
use rayon::prelude::*;
use std::time::Instant;

/// Seconds that the thesis reports for its box on its card.
const THESIS_SECONDS: f64 = 251.0;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let has = |word: &str| words.iter().any(|w| w == word);
    let has_no_filter = !has("room") && !has("thesis");
    let card = match Card::open(Backend::Auto) {
        Ok(card) => Some(card),
        Err(e) => {
            println!("no card: {e}");
            None
        }
    };
    if let Some(card) = &card {
        println!("card: {}", card.name());
        if card.is_software() {
            println!("This is a software driver: its figures are not those of a graphics card.");
        }
    }
    println!("processor: {} threads", rayon::current_num_threads());
    let seconds = if has("quick") { 0.5 } else { 3.0 };
    if has_no_filter || has("room") {
        rooms(card.as_ref(), seconds);
    }
    if has_no_filter || has("thesis") {
        thesis(card.as_ref(), seconds);
    }
}

/// What is drawn, and from where.
struct Case {
    world: World,
    views: Vec<View>,
    tracer: Tracer,
}

impl Case {
    fn new(scene: &Scene) -> Case {
        let mut case = Case {
            world: World {
                up: DVec3::Z,
                ..World::default()
            },
            views: Vec::new(),
            tracer: Tracer::new(scene),
        };
        for object in &scene.objects {
            let Shape::Mesh(mesh) = &object.shape else {
                continue;
            };
            for (face, corners) in mesh.faces.iter().enumerate() {
                let corners: Vec<DVec3> = corners
                    .iter()
                    .map(|&v| mesh.positions[v as usize])
                    .collect();
                let triangles = mesh.triangulate(face);
                case.add(
                    triangles
                        .into_iter()
                        .map(|t| t.map(|k| corners[k as usize])),
                );
            }
        }
        case
    }

    /// Adds a patch, and the view from its middle.
    fn add(&mut self, triangles: impl Iterator<Item = [DVec3; 3]>) {
        let patch = self.world.patches;
        let first = self.world.triangles.len();
        self.world
            .triangles
            .extend(triangles.map(|corners| Facet { corners, patch }));
        self.world.patches += 1;
        let Some(facet) = self.world.triangles.get(first) else {
            return;
        };
        let [a, b, c] = facet.corners;
        let normal = (b - a).cross(c - a).normalize();
        let middle = (a + b + c) / 3.0;
        self.views.push(View {
            eye: self.tracer.leaving(middle, normal),
            normal,
            turn: f64::from(patch),
        });
    }

    /// Every n-th view, `count` in all, over and over if there are fewer.
    fn spread(&self, count: usize) -> Vec<View> {
        let view_count = self.views.len();
        (0..count)
            .map(|k| self.views[k * view_count / count.min(view_count) % view_count])
            .collect()
    }

    /// Hemicubes per second that a device draws.
    fn drawn(&self, device: &dyn Device, n: u32, seconds: f64) -> Result<f64, DrawError> {
        let settings = Settings {
            resolution: n,
            mirrors: Beyond::List,
        };
        let buffers = device.load(&self.world, &settings)?;
        // Once without a clock: shaders are compiled when they are first needed.
        let mut views = self.spread(buffers.batch());
        buffers.draw(&views[..views.len().min(8)])?;
        loop {
            let start = Instant::now();
            buffers.draw(&views)?;
            let taken = start.elapsed().as_secs_f64();
            if taken > 0.5 * seconds {
                return Ok(views.len() as f64 / taken);
            }
            let more = (0.8 * seconds / taken * views.len() as f64) as usize;
            views = self.spread(more.clamp(2 * views.len(), 20 * views.len()));
        }
    }

    /// Hemicubes per second of which the pixels are rays.
    fn traced(&self, n: u32, seconds: f64) -> f64 {
        let rays = (3 * n * n) as usize;
        let table = SobolTable::new(rays);
        let views = self.spread(1 << 12);
        let one = |(k, view): (usize, &View)| {
            let frame = Frame::from_normal(view.normal);
            let scrambling = seeds(&[k as u32]);
            let ray = |i: usize| -> KernelRay {
                let [u, v, ..] = table.point(i, scrambling).map(f64::from);
                let ray = Ray::new(view.eye, cosine_about(&frame, u, v));
                self.tracer.kernel_ray(&ray)
            };
            let rays: Vec<KernelRay> = (0..rays).map(ray).collect();
            let mut hits = Vec::new();
            self.tracer.closest(&rays, &mut hits);
            std::hint::black_box(hits.len())
        };
        let mut count = rayon::current_num_threads();
        loop {
            let start = Instant::now();
            let part: Vec<(usize, &View)> = views.iter().cycle().take(count).enumerate().collect();
            part.into_par_iter().for_each(|v| {
                one(v);
            });
            let taken = start.elapsed().as_secs_f64();
            if taken > 0.5 * seconds {
                return count as f64 / taken;
            }
            count = (0.8 * seconds / taken * count as f64) as usize;
            count = count.max(2 * rayon::current_num_threads());
        }
    }
}

fn rooms(card: Option<&Card>, seconds: f64) {
    println!("\nroom with a table, hemicubes per second");
    println!("facets   pixels        card   processor        rays");
    for facets in [1_000, 10_000, 100_000] {
        let case = Case::new(&room_with_table(facets));
        for n in [64, 128, 256, 512] {
            let drawn = |device: &dyn Device| case.drawn(device, n, seconds);
            let card = card.map(|card| drawn(card));
            let columns = [
                words(card),
                words(Some(drawn(&Processor))),
                format!("{:.1}", case.traced(n, seconds)),
            ];
            let [card, processor, rays] = columns;
            let facets = case.world.patches;
            println!("{facets:<8} {n:<6} {card:>11} {processor:>11} {rays:>11}");
        }
    }
}

fn words(rate: Option<Result<f64, DrawError>>) -> String {
    match rate {
        None => "-".to_owned(),
        Some(Ok(rate)) => format!("{rate:.1}"),
        Some(Err(e)) => e.to_string(),
    }
}

fn thesis(card: Option<&Card>, seconds: f64) {
    let case = Case::new(&cornell_thesis(0));
    let (facets, n) = (case.world.patches, 512);
    println!(
        "\nthe thesis' box: {facets} facets, {} pixels each",
        3 * n * n
    );
    println!("GTX 1070 Ti, 2019 (reported): {THESIS_SECONDS} s");
    match card {
        None => println!("card: not measured, there is none"),
        Some(card) if card.is_software() => {
            let rate = case.drawn(card, n, seconds);
            println!("graphics card: not measured, {} is software", card.name());
            println!("  that driver draws {} hemicubes/s", words(Some(rate)));
        }
        Some(card) => match case.all(card, n) {
            Ok(taken) => {
                let times = THESIS_SECONDS / taken;
                println!("{}: {taken:.2} s, {times:.1} times as fast", card.name());
            }
            Err(e) => println!("{}: {e}", card.name()),
        },
    }
    let processor = words(Some(case.drawn(&Processor, n, seconds)));
    let rays = case.traced(n, seconds);
    println!("processor in software: {processor} hemicubes/s; as rays: {rays:.1} hemicubes/s");
}

impl Case {
    /// Seconds to draw one hemicube of every facet, loading included.
    fn all(&self, card: &Card, n: u32) -> Result<f64, DrawError> {
        self.drawn(card, n, 0.1)?;
        let start = Instant::now();
        let settings = Settings {
            resolution: n,
            mirrors: Beyond::List,
        };
        let buffers = card.load(&self.world, &settings)?;
        for views in self.views.chunks(buffers.batch()) {
            buffers.draw(views)?;
        }
        Ok(start.elapsed().as_secs_f64())
    }
}
