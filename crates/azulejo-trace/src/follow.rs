//! Follows rays through mirrors and glass to everything that they see.

use crate::sampling::uniform;
use crate::{KernelHit, KernelRay, Surfaces};
use azulejo_scene::fresnel;
use azulejo_scene::math::{Ray, reflect};
use azulejo_scene::{Dielectric, Rgb};
use glam::DVec3;

/// A ray on its way, and what it stands for.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// Where it goes next.
    pub ray: KernelRay,
    /// Whatever the caller wants to know when the path arrives.
    pub id: u32,
    /// Share of the light that this path carries, per channel.
    pub weight: [f32; 3],
    /// What it met so far.
    pub via: Via,
    /// Interfaces met so far.
    pub depth: u16,
}

/// What stood between the start of a path and where it is now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Via {
    /// Nothing.
    Direct,
    /// One mirror, this item.
    Mirror(u32),
    /// Glass, or more than one mirror.
    Many,
}

/// What happened to a path.
#[derive(Clone, Copy, Debug)]
pub enum Event {
    /// It reached a surface, with its whole weight; what the surface mirrors or transmits goes
    /// on (additive model, Sillion and Puech 1989).
    Surface {
        /// Where.
        hit: KernelHit,
        /// Whether it arrived at the front.
        front: bool,
    },
    /// It left the scene.
    Escape,
    /// What it still carried was too little to follow: the residue.
    Cut,
}

/// A path is dropped, and its weight reported as [`Event::Cut`], below this weight.
pub const WEIGHT_CUT: f32 = 1e-7;

/// A path is dropped after this many interfaces: facing perfect mirrors would hold it forever.
pub const DEPTH_CUT: u16 = 1000;

/// Dielectrics split a path in two at its first interfaces; later ones choose one branch.
const SPLIT_DEPTH: u16 = 2;

/// Working memory of [`follow`], kept between calls to save allocations.
#[derive(Default)]
pub struct Scratch {
    rays: Vec<KernelRay>,
    hits: Vec<KernelHit>,
    next: Vec<Path>,
}

/// Traces `paths` to their ends and tells `on_event` of every surface they reach.
///
/// Per path the shares add up: what is deposited at surfaces times what these absorb or reflect
/// diffusely, what escapes and what is cut make the weight it started with. Empties `paths`.
/// The order of events depends on the paths alone. `seed` keys the choices at glass.
pub fn follow(
    surfaces: &Surfaces,
    paths: &mut Vec<Path>,
    scratch: &mut Scratch,
    seed: u32,
    mut on_event: impl FnMut(&Path, Event),
) {
    let mut wave = 0;
    while !paths.is_empty() {
        scratch.rays.clear();
        scratch.rays.extend(paths.iter().map(|p| p.ray));
        surfaces.tracer.closest(&scratch.rays, &mut scratch.hits);
        for (index, (path, hit)) in paths.iter().zip(&scratch.hits).enumerate() {
            if hit.item == KernelHit::MISS {
                on_event(path, Event::Escape);
                continue;
            }
            on_event(
                path,
                Event::Surface {
                    hit: *hit,
                    front: surfaces.is_front(&path.ray, hit),
                },
            );
            if surfaces.is_specular(hit.item) {
                let chance = uniform(&[seed, wave, index as u32]);
                go_on(surfaces, path, hit, chance, |next| match next {
                    Ok(p) => scratch.next.push(p),
                    Err(rest) => on_event(&rest, Event::Cut),
                });
            }
        }
        std::mem::swap(paths, &mut scratch.next);
        scratch.next.clear();
        wave += 1;
    }
}

/// The paths that leave a mirror or glass when `path` arrives at it; those that are too weak to
/// follow come as errors.
fn go_on(
    surfaces: &Surfaces,
    path: &Path,
    hit: &KernelHit,
    chance: f32,
    mut push: impl FnMut(Result<Path, Path>),
) {
    let ray = surfaces.tracer.world_ray(&path.ray);
    let at = surfaces.tracer.resolve(&ray, hit);
    let direction = ray.direction.normalize();
    let facing = if at.entering { at.normal } else { -at.normal };
    let material = surfaces.material(hit.item);
    let mut send = |direction: DVec3, share: Rgb, via: Via| {
        let s = share.to_f32();
        let weight = [0, 1, 2].map(|k| path.weight[k] * s[k]);
        let side = if direction.dot(facing) >= 0.0 {
            facing
        } else {
            -facing
        };
        let ray = Ray::new(surfaces.tracer.leaving(at.position, side), direction);
        let next = Path {
            ray: surfaces.tracer.kernel_ray(&ray),
            weight,
            via,
            depth: path.depth + 1,
            ..*path
        };
        let alive = weight.iter().any(|&w| w > WEIGHT_CUT) && next.depth < DEPTH_CUT;
        push(if alive { Ok(next) } else { Err(next) });
    };
    match material.dielectric {
        None => {
            let via = if path.via == Via::Direct {
                Via::Mirror(hit.item)
            } else {
                Via::Many
            };
            send(reflect(direction, facing), material.mirror, via);
        }
        Some(glass) => {
            let (mirrored, passed) = glass_shares(&glass, direction, facing, at.entering);
            let reflected_share = material.mirror * mirrored.0;
            let Some((direction_in, passed_share)) = passed else {
                return send(mirrored.1, reflected_share, Via::Many);
            };
            if path.depth < SPLIT_DEPTH {
                send(mirrored.1, reflected_share, Via::Many);
                send(direction_in, passed_share, Via::Many);
            } else if f64::from(chance) < mirrored.0 {
                send(mirrored.1, material.mirror, Via::Many);
            } else {
                send(direction_in, passed_share / (1.0 - mirrored.0), Via::Many);
            }
        }
    }
}

/// Reflectance and direction of the mirrored part; direction and share of the part that passes.
///
/// Paths run against the light, so the share that passes carries the square of the ratio of
/// indices: L/n² is what refraction conserves.
fn glass_shares(
    glass: &Dielectric,
    direction: DVec3,
    facing: DVec3,
    entering: bool,
) -> ((f64, DVec3), Option<(DVec3, Rgb)>) {
    let eta = if entering { glass.ior } else { 1.0 / glass.ior };
    let split = fresnel::split(direction, facing, eta);
    let passed = split.refracted.map(|d| {
        (
            d,
            glass.transmittance * ((1.0 - split.reflectance) / (eta * eta)),
        )
    });
    ((split.reflectance, split.reflected), passed)
}
