//! Hemicubes per second of a device, in rooms of several sizes.

use azulejo_factors::hemicube::world_of;
use azulejo_factors::rays::RayEstimator;
use azulejo_factors::row::{Columns, side};
use azulejo_factors::{PatchSize, Patches};
use azulejo_scene::Scene;
use azulejo_scene::synthetic::{cornell_thesis, furnished_room};
use azulejo_trace::item_buffer::{Beyond, Device, Hemicube, NO_MIRROR, Settings, View, World};
use azulejo_trace::sampling::uniform;
use azulejo_trace::{Gatherer, Surfaces, Tracer};
use rayon::prelude::*;
use std::time::Instant;

/// Requested facets of the rooms; the smallest has half as many again.
const FACETS: [usize; 3] = [1_000, 10_000, 100_000];
/// Pixels along the side of the top face.
const RESOLUTIONS: [u32; 4] = [64, 128, 256, 512];
/// Mirrors of the box whose windows are rendered.
const MIRRORS: [usize; 4] = [0, 16, 64, 1_500];
/// Approximate seconds per measurement.
const SECONDS: f64 = 1.0;

/// Prints a table of hemicubes per second, with a column for each device, and one of rays: rows of
/// as many rays as a hemicube has pixels. Uses all threads of the current pool.
pub fn print_table(devices: &[&dyn Device]) {
    let names: String = devices
        .iter()
        .map(|d| format!("{:>28}", d.name()))
        .collect();
    println!("hemicubes/s, {} threads", rayon::current_num_threads());
    println!("facets  pixels{names}        rays: rows/s (M rays/s)");
    for facets in FACETS {
        let room = Room::new(furnished_room(2 * facets));
        for resolution in RESOLUTIONS {
            let drawn = room.all_drawn(devices, &room.world(), resolution, Beyond::List);
            let rows = room.traced(resolution);
            let rays = rows * f64::from(Hemicube::new(resolution).pixels()) * 1e-6;
            let facets = room.patches.len();
            println!("{facets:>6}  {resolution:>6}{drawn}  {rows:>14.1} ({rays:.1})");
        }
    }
}

/// Prints a table of hemicubes per second of a box with flat mirrors, which are windows: one
/// window, as all lie in one plane, and one for each.
pub fn print_mirrors(devices: &[&dyn Device]) {
    let names: String = devices
        .iter()
        .map(|d| format!("{:>28}", d.name()))
        .collect();
    println!(
        "hemicubes/s with windows, {} threads",
        rayon::current_num_threads()
    );
    println!("mirrors  windows  facets  pixels{names}");
    let windows = Beyond::Windows {
        cut: azulejo_factors::hemicube::WINDOW_CUT,
        depth: azulejo_trace::follow::DEPTH_CUT.into(),
        windows: azulejo_factors::hemicube::MOST_WINDOWS,
    };
    for mirrors in MIRRORS {
        let room = Room::new(cornell_thesis(mirrors));
        let facets = room.patches.len();
        let joined = room.world();
        let apart = apart(joined.clone());
        let worlds = match mirrors {
            0 => vec![joined],
            _ => vec![joined, apart],
        };
        for (world, resolution) in worlds.iter().flat_map(|w| [(w, 128), (w, 512)]) {
            let drawn = room.all_drawn(devices, world, resolution, windows);
            let count = world.mirrors.len();
            println!("{mirrors:>7}  {count:>7}  {facets:>6}  {resolution:>6}{drawn}");
        }
    }
}

/// The same world with a separate mirror for each specular patch.
fn apart(mut world: World) -> World {
    let together = std::mem::take(&mut world.mirrors);
    for mirror in world.mirror_of.iter_mut().filter(|m| **m != NO_MIRROR) {
        world.mirrors.push(together[*mirror as usize]);
        *mirror = world.mirrors.len() as u32 - 1;
    }
    world
}

/// A scene and its patches.
struct Room {
    scene: Scene,
    tracer: Tracer,
    patches: Patches,
}

impl Room {
    fn new(scene: Scene) -> Room {
        Room {
            tracer: Tracer::new(&scene),
            patches: Patches::new(&scene, PatchSize::Edge(0.0)),
            scene,
        }
    }

    fn world(&self) -> World {
        world_of(&self.scene, &self.patches)
    }

    /// The next viewpoint of a measurement: all over the room.
    fn patch(&self, k: usize) -> usize {
        (f64::from(uniform(&[k as u32])) * self.patches.len() as f64) as usize
    }

    fn view(&self, k: usize) -> View {
        let patch = self.patch(k);
        let normal = self.patches.normal(patch);
        View {
            eye: self.tracer.leaving(self.patches.centre(patch), normal),
            normal,
            turn: f64::from(uniform(&[k as u32, 1])),
        }
    }

    /// A column of the table for each device.
    fn all_drawn(
        &self,
        devices: &[&dyn Device],
        world: &World,
        resolution: u32,
        mirrors: Beyond,
    ) -> String {
        let settings = Settings {
            resolution,
            mirrors,
        };
        let drawn = devices
            .iter()
            .map(|d| match self.drawn(*d, world, settings) {
                Ok(rate) => format!("{rate:>28.1}"),
                Err(why) => format!("{why:>28}"),
            });
        drawn.collect()
    }

    /// Hemicubes per second, or why there are none.
    fn drawn(&self, device: &dyn Device, world: &World, settings: Settings) -> Result<f64, String> {
        let loaded = device.load(world, &settings);
        let buffers = loaded.map_err(|e| e.to_string())?;
        let batch = buffers.batch();
        let views = |call: usize| (call * batch..(call + 1) * batch).map(|k| self.view(k));
        // The first call also allocates.
        let first = buffers.draw(&views(0).collect::<Vec<View>>());
        first.map_err(|e| e.to_string())?;
        rate(batch, |call| {
            let seen = buffers.draw(&views(call + 1).collect::<Vec<View>>());
            std::hint::black_box(seen).map_err(|e| e.to_string())
        })
    }

    /// Rows per second of as many rays as a hemicube has pixels.
    fn traced(&self, resolution: u32) -> f64 {
        let gatherer = Gatherer::new(Surfaces::new(&self.scene, &self.tracer));
        let rays = Hemicube::new(resolution).pixels();
        let estimator = RayEstimator::new(&gatherer, &self.patches, rays, 1, Columns::All);
        let batch = 4 * rayon::current_num_threads();
        let rows_per_second = rate(batch, |call| {
            let rows = (call * batch..(call + 1) * batch).into_par_iter();
            let row = |k| estimator.row(side(self.patch(k) as u32, true));
            rows.map(row)
                .for_each(|row| drop(std::hint::black_box(row)));
            Ok::<(), String>(())
        });
        rows_per_second.unwrap_or(0.0)
    }
}

/// Repeats calls of `batch` pieces of work for a while; pieces per second.
fn rate<T>(batch: usize, work: impl Fn(usize) -> Result<T, String>) -> Result<f64, String> {
    let start = Instant::now();
    let mut calls = 0;
    while calls == 0 || start.elapsed().as_secs_f64() < SECONDS {
        work(calls)?;
        calls += 1;
    }
    Ok((calls * batch) as f64 / start.elapsed().as_secs_f64())
}
