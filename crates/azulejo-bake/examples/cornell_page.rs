//! Writes a page of the Cornell box: `cargo run --example cornell_page -- OUT.html [TEXELS]`.
//!
//! Its light is that of the lamp with soft shadows, by random rays, and a guess at the reflected rest: not a
//! solution, but as noisy as one.

#[path = "../tests/it/room.rs"]
#[allow(dead_code, reason = "tests use more of the room")]
mod room;

use azulejo_bake::web_page;
use azulejo_scene::math::Ray;
use azulejo_scene::random::split_mix64;
use glam::DVec3;
use room::Room;
use std::fs::File;
use std::io::BufWriter;

/// Rays per texel.
const RAYS: u32 = 96;

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().unwrap_or_else(|| "cornell.html".into());
    let size = arguments.next().and_then(|s| s.parse().ok()).unwrap_or(256);
    let mut model = Room::cornell().page(size, shadowed_light);
    model.note = "Direct light by 96 rays per texel, reflected light by a guess.".into();
    web_page::write(&model, &mut BufWriter::new(File::create(path)?))
}

fn shadowed_light(room: &Room, place: DVec3, normal: DVec3) -> ([f32; 3], [f32; 3]) {
    let seed =
        place.x.to_bits() ^ place.y.to_bits().rotate_left(21) ^ place.z.to_bits().rotate_left(42);
    let mut state = seed;
    let mut random = move || split_mix64(&mut state);
    let (low, high) = (
        DVec3::new(213.0, 548.7, 227.0),
        DVec3::new(343.0, 548.7, 332.0),
    );
    let area = (high.x - low.x) * (high.z - low.z);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..RAYS {
        let target = low + (high - low) * DVec3::new(random(), 0.0, random());
        let way = target - place;
        let cosines = way.dot(normal).max(0.0) * way.y.max(0.0) / way.length_squared();
        let ray = Ray::new(place + 1e-6 * normal, way);
        let is_open = cosines > 0.0 && !blocks(room, &ray);
        let sample = if is_open {
            area * cosines / way.length_squared()
        } else {
            0.0
        };
        sum += sample;
        squares += sample * sample;
    }
    let count = f64::from(RAYS);
    let mean = sum / count;
    let error = ((squares / count - mean * mean).max(0.0) / (count - 1.0)).sqrt();
    let (left, right) = (place.x / 556.0, 1.0 - place.x / 556.0);
    let rest = 0.25 + 0.1 * (1.0 - place.y / 548.8);
    let reflected = [
        rest * (1.0 + 0.5 * left),
        rest * (0.8 + 0.2 * right),
        rest * 0.45,
    ];
    let lamp = [17.0, 12.0, 4.0];
    let value = |c: usize| (lamp[c] * (mean + 0.35 * reflected[c] / 1.2)) as f32;
    (
        [value(0), value(1), value(2)],
        lamp.map(|l| (l * (error + 2e-3)) as f32),
    )
}

/// Whether a face is between the ends of a ray of length 1, whichever side it shows.
fn blocks(room: &Room, ray: &Ray) -> bool {
    room.faces.iter().any(|face| {
        let slope = ray.direction.dot(face.normal);
        let distance = (face.corners[0] - ray.origin).dot(face.normal) / slope;
        distance > 1e-6 && distance < 0.9999 && face.holds(ray.at(distance))
    })
}
