//! The rays of a picture with soft shadows.

use crate::letters::Lights;
use azulejo_scene::Camera;
use azulejo_scene::math::Ray;
use azulejo_trace::{KernelRay, Tracer};
use glam::DVec3;

/// Pixels across and down.
const SIZE: [u32; 2] = [1280, 720];
/// The lamp is sampled so often in each direction.
const SIDE: u32 = 4;

/// Traces a ray through every pixel, and from what it meets one to the point light and 16 to the
/// lamp where these are before the surface. Returns how many rays that were.
pub fn shadows(tracer: &Tracer, camera: &Camera, lights: &Lights) -> usize {
    let (mut hits, mut blocked) = (Vec::new(), Vec::new());
    let mut shadows: Vec<KernelRay> = Vec::new();
    let (mut count, mut lit) = (0, 0);
    for y in 0..SIZE[1] {
        let rays: Vec<Ray> = (0..SIZE[0]).map(|x| pixel(camera, x, y)).collect();
        let kernel: Vec<KernelRay> = rays.iter().map(|r| tracer.kernel_ray(r)).collect();
        tracer.closest(&kernel, &mut hits);
        shadows.clear();
        for (x, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
            if hit.is_hit() {
                let at = tracer.resolve(ray, hit);
                let normal = if at.entering { at.normal } else { -at.normal };
                let from = tracer.leaving(at.position, normal);
                let seed = y * SIZE[0] + x as u32;
                for to in targets(lights, seed) {
                    if (to - from).dot(normal) > 0.0 {
                        shadows.push(tracer.kernel_ray(&Ray::between(from, to)));
                    }
                }
            }
        }
        tracer.any(&shadows, &mut blocked);
        count += rays.len() + shadows.len();
        lit += blocked.iter().filter(|b| !**b).count();
    }
    assert!(lit > 0, "the lights are not seen at all");
    count
}

fn pixel(camera: &Camera, x: u32, y: u32) -> Ray {
    let at = |k: u32, n: u32| (f64::from(k) + 0.5) / f64::from(n);
    let aspect = f64::from(SIZE[0]) / f64::from(SIZE[1]);
    camera.ray(at(x, SIZE[0]), at(y, SIZE[1]), aspect)
}

/// The point light, and a point in each cell of the lamp.
fn targets(lights: &Lights, seed: u32) -> impl Iterator<Item = DVec3> {
    let [corner, a, b] = lights.area;
    let cells = (0..SIDE * SIDE).map(move |k| {
        let jitter = |salt: u32| f64::from(hash(seed ^ (k << 24) ^ salt)) / 4294967296.0;
        let u = (f64::from(k % SIDE) + jitter(1)) / f64::from(SIDE);
        let v = (f64::from(k / SIDE) + jitter(0x8000_0001)) / f64::from(SIDE);
        corner + u * a + v * b
    });
    std::iter::once(lights.point).chain(cells)
}

/// PCG's output function, as a hash.
fn hash(x: u32) -> u32 {
    let x = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((x >> ((x >> 28) + 4)) ^ x).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}
