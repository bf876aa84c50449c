//! Radiance along rays: what the first pass left on the surfaces, seen through mirrors and glass and
//! by way of glossy lobes.

use crate::SecondPass;
use crate::boundary::Boundary;
use crate::draws::Draws;
use crate::scenery::{Arrived, Scenery, Shadows};
use crate::shading::{Colors, Parts, Shading, mirrored};
use azulejo_scene::math::{Ray, reflect};
use azulejo_scene::{Material, Rgb, Scene};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Arrival, DiffuseLight, GatherOptions, GatherPoint, Glow};
use azulejo_trace::{KernelHit, KernelRay, Surfaces, Tracer};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Dielectrics split a path at its first interfaces, which makes the picture nearly free of
/// noise there; at later ones it takes one way, or the number of paths would double each time.
const SPLIT_DEPTH: u32 = 2;

/// Below this weight a path lives on by chance, and what survives weighs this much: the mean
/// stays right, and a hall of mirrors ends.
const ROULETTE_BELOW: f64 = 0.01;

/// Gather rays per hit on the back of a surface, of whose light the first pass says nothing.
const BACK_RAYS: u32 = 32;

/// Rays of one call of the gatherer, about: bounds its memory.
const GATHER_BATCH: u32 = 16_384;

/// Finds radiance in one scene under one set of options. Immutable, shared by all threads.
pub(crate) struct Integrator<'a> {
    scenery: Scenery<'a>,
    /// Gather rays per diffuse hit; `None` to show what the first pass left.
    gather: Option<u32>,
    /// Whether the first pass left anything.
    is_solved: bool,
    seed: u32,
    max_depth: u32,
}

/// What was found along one ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// Radiance, W/(sr·m²).
    pub radiance: Rgb,
    /// Whether chance played a part, so that another try may find something else.
    pub is_random: bool,
}

/// One straight piece of a path from the eye, still to be traced.
#[derive(Clone, Copy, Debug)]
struct Leg {
    ray: KernelRay,
    /// Share of the radiance found that reaches the eye.
    weight: Rgb,
    /// Interfaces passed so far.
    depth: u32,
    /// Whether mirrors and glass alone lie between the eye and the leg.
    is_sharp: bool,
    /// Density of its direction, 1/sr, if that was drawn where the lamps were also looked for; 0
    /// otherwise.
    density: f64,
}

/// Irradiance that is still to be gathered.
#[derive(Clone, Copy, Debug)]
struct Wish {
    /// The ray that asks, by its number in the batch.
    ray: usize,
    /// What one unit of irradiance adds to the ray's radiance.
    weight: Rgb,
    point: GatherPoint,
}

/// Working memory for a batch, kept between batches to save allocations.
#[derive(Default)]
pub(crate) struct Scratch {
    hits: Vec<KernelHit>,
    next: Vec<KernelHit>,
    pending: Vec<Leg>,
    wishes: Vec<Wish>,
    points: Vec<GatherPoint>,
    shadows: Shadows,
}

impl<'a> Integrator<'a> {
    pub fn new(scene: &'a Scene, tracer: &'a Tracer, options: &SecondPass) -> Integrator<'a> {
        Integrator {
            scenery: Scenery::new(scene, tracer),
            gather: options.gather,
            is_solved: scene.is_solved(),
            seed: hash(&[options.seed as u32, (options.seed >> 32) as u32]),
            max_depth: options.max_depth,
        }
    }

    /// Keys all random numbers.
    pub fn seed(&self) -> u32 {
        self.seed
    }

    /// The ray as the kernel wants it.
    pub fn kernel_ray(&self, ray: &Ray) -> KernelRay {
        self.tracer().kernel_ray(ray)
    }

    fn tracer(&self) -> &'a Tracer {
        self.scenery.tracer()
    }

    fn surfaces(&self) -> &Surfaces<'a> {
        self.scenery.surfaces()
    }

    /// Finds the radiance that arrives along each ray, in their order, into `found`. `draws` are
    /// the random numbers of the ray of that number.
    pub fn radiance(
        &self,
        rays: &[KernelRay],
        draws: impl Fn(usize) -> Draws,
        scratch: &mut Scratch,
        found: &mut Vec<Found>,
    ) {
        let mut hits = std::mem::take(&mut scratch.hits);
        self.tracer().closest(rays, &mut hits);
        found.clear();
        found.extend(
            rays.iter()
                .zip(&hits)
                .enumerate()
                .map(|(number, (&ray, hit))| {
                    let mut path = Path {
                        integrator: self,
                        number,
                        draws: draws(number),
                        scratch: &mut *scratch,
                    };
                    path.radiance(Leg::first(ray), hit)
                }),
        );
        scratch.hits = hits;
        self.grant(scratch, found);
    }

    /// Irradiance that the first pass left on the front, W/m².
    fn irradiance(&self, at: &Arrival) -> Rgb {
        self.scenery
            .interpolator
            .spot(&at.ray, &at.hit)
            .irradiance()
    }

    /// Gathers what paths wished for.
    fn grant(&self, scratch: &mut Scratch, found: &mut [Found]) {
        let options = GatherOptions {
            rays: self.gather.unwrap_or(BACK_RAYS),
            seed: self.seed,
            spent: 0,
        };
        let together = (GATHER_BATCH / options.rays.max(1)).max(1) as usize;
        for wishes in scratch.wishes.chunks(together) {
            scratch.points.clear();
            scratch.points.extend(wishes.iter().map(|wish| wish.point));
            let gathered = self
                .scenery
                .gatherer
                .gather(&scratch.points, &options, self);
            for (wish, gathered) in wishes.iter().zip(gathered) {
                let found = &mut found[wish.ray];
                found.radiance += wish.weight * gathered.mean();
                found.is_random = true;
            }
        }
        scratch.wishes.clear();
    }
}

/// One path from the eye, while it is followed.
struct Path<'p, 'a> {
    integrator: &'p Integrator<'a>,
    /// The ray's number in its batch.
    number: usize,
    draws: Draws,
    scratch: &'p mut Scratch,
}

impl<'a> Path<'_, 'a> {
    /// Radiance along the first leg, which ends at `hit`, and along all that come of it; less
    /// what is still to be gathered.
    fn radiance(&mut self, first: Leg, hit: &KernelHit) -> Found {
        let (first, fog) = self.through_fog(first, hit);
        let mut radiance = fog + self.arrive(&first, hit);
        while let Some(leg) = self.scratch.pending.pop() {
            let ray = std::slice::from_ref(&leg.ray);
            self.integrator
                .tracer()
                .closest(ray, &mut self.scratch.next);
            let hit = self.scratch.next[0];
            radiance += self.arrive(&leg, &hit);
        }
        Found {
            radiance,
            is_random: self.draws.is_used(),
        }
    }

    /// The first leg with what the fog leaves of its light, and what the fog adds.
    fn through_fog(&self, first: Leg, hit: &KernelHit) -> (Leg, Rgb) {
        let Some((clear, added)) = self.integrator.scenery.fog(&first.ray, hit) else {
            return (first, Rgb::BLACK);
        };
        let weight = first.weight * clear;
        (Leg { weight, ..first }, first.weight * added)
    }

    /// What a leg adds where it ends; what goes on from there becomes pending.
    fn arrive(&mut self, leg: &Leg, hit: &KernelHit) -> Rgb {
        let scenery = &self.integrator.scenery;
        if !hit.is_hit() {
            let beyond = match leg.is_sharp {
                true => scenery.sky,
                // Light on surfaces is that of the surroundings; the background is for the eye.
                false => scenery.gatherer.ambient(),
            };
            return leg.weight * beyond;
        }
        let surfaces = scenery.surfaces();
        let material = surfaces.material(hit.item);
        let mut own = scenery.emitted(&leg.ray, hit, leg.density);
        if !material.diffuse.is_black() {
            let front = surfaces.is_front(&leg.ray, hit);
            let (ray, hit) = (leg.ray, *hit);
            own += self.reflected(leg, &Arrival { ray, hit, front }, material);
        }
        if material.is_specular() || material.brdf.is_some() {
            own += self.scatter(leg, hit, material);
        }
        leg.weight * own
    }

    /// Diffusely reflected radiance ρE/π; black if its irradiance is still to be gathered. Matt
    /// lobes that are seen sharply are left to [`scatter`](Path::scatter).
    fn reflected(&mut self, leg: &Leg, at: &Arrival, material: &Material) -> Rgb {
        let mut reflectance = self.integrator.reflectance(at);
        if leg.is_sharp {
            reflectance = Colors::new(reflectance, material.brdf.as_deref()).lambert;
        }
        let shows_patches =
            self.integrator.gather.is_none() || (self.integrator.is_solved && !leg.is_sharp);
        if shows_patches && at.front {
            return self.integrator.irradiance(at) * reflectance * FRAC_1_PI;
        }
        let tracer = self.integrator.tracer();
        let place = tracer.resolve(&tracer.world_ray(&leg.ray), &at.hit);
        let serial = self.scratch.wishes.len() as u32;
        self.scratch.wishes.push(Wish {
            ray: self.number,
            weight: leg.weight * reflectance * FRAC_1_PI,
            point: GatherPoint {
                position: place.position,
                normal: if at.front {
                    place.normal
                } else {
                    -place.normal
                },
                key: hash(&[self.draws.stream, self.draws.sample, serial]),
            },
        });
        Rgb::BLACK
    }

    /// Sends the path on into mirrored, refracted and drawn directions; returns the radiance that
    /// glossy lobes show of lamps and lights.
    fn scatter(&mut self, leg: &Leg, hit: &KernelHit, material: &'a Material) -> Rgb {
        let arrived = self.integrator.scenery.arrived(&leg.ray, hit);
        let Some(glass) = material.dielectric else {
            return self.reflect(leg, hit, &arrived, material);
        };
        let Arrived {
            at,
            direction,
            smooth,
            ..
        } = &arrived;
        let boundary = Boundary::new(&glass, material.mirror, *direction, *smooth, at.entering);
        if leg.depth < SPLIT_DEPTH {
            self.send(leg, &arrived, Way::sharp(boundary.mirrored()));
            if let Some(passed) = boundary.passed() {
                self.send(leg, &arrived, Way::sharp(passed));
            }
        } else {
            let chosen = boundary.chosen(self.chance());
            self.send(leg, &arrived, Way::sharp(chosen));
        }
        Rgb::BLACK
    }

    /// Sends the path on into the mirrored direction and one that is drawn from the lobes, at
    /// first interfaces into both, later into one by chance; returns what the lobes show of lamps
    /// and lights. Rays to lamps and rays from the lobes count a lamp once.
    fn reflect(
        &mut self,
        leg: &Leg,
        hit: &KernelHit,
        arrived: &Arrived,
        material: &'a Material,
    ) -> Rgb {
        let parts = match leg.is_sharp {
            true => Parts::MattAndLobes,
            false => Parts::Lobes,
        };
        let scenery = &self.integrator.scenery;
        let shading = scenery.shading(hit, arrived, material, parts);
        let Arrived {
            direction, smooth, ..
        } = *arrived;
        let share = mirrored(material, -direction.dot(smooth));
        let mirror = Way::sharp((reflect(direction, smooth), share));
        if shading.is_black() {
            if !share.is_black() {
                self.send(leg, arrived, mirror);
            }
            return Rgb::BLACK;
        }
        let divides = leg.depth < SPLIT_DEPTH || share.is_black();
        let odds = match divides {
            true => 0.0,
            false => share.mean() / (share.mean() + shading.likely()),
        };
        if divides && !share.is_black() {
            self.send(leg, arrived, mirror);
        } else if !divides && self.chance() < odds {
            self.send(leg, arrived, mirror.over(odds));
            return self.lit(&shading, 1.0 - odds);
        }
        let u = [(); 4].map(|()| self.chance());
        if let Some(sample) = shading.sample(u) {
            let way = Way {
                direction: sample.wi,
                share: sample.weight / (1.0 - odds),
                density: sample.pdf * (1.0 - odds),
            };
            self.send(leg, arrived, way);
        }
        self.lit(&shading, 1.0 - odds)
    }

    /// What lobes show of lamps and lights; `by_chance` as for [`Scenery::lit`].
    fn lit(&mut self, shading: &Shading, by_chance: f64) -> Rgb {
        let u = [(); 4].map(|()| self.chance());
        let scenery = &self.integrator.scenery;
        scenery.lit(shading, u, by_chance, &mut self.scratch.shadows)
    }

    /// Makes the leg pending that goes on that way, unless roulette or the safety cap ends it.
    fn send(&mut self, leg: &Leg, arrived: &Arrived, way: Way) {
        if leg.depth >= self.integrator.max_depth {
            return;
        }
        let tracer = self.integrator.tracer();
        let side = arrived.facing * 1f64.copysign(way.direction.dot(arrived.facing));
        let origin = tracer.leaving(arrived.at.position, side);
        let next = Leg {
            ray: tracer.kernel_ray(&Ray::new(origin, way.direction)),
            weight: leg.weight * way.share,
            depth: leg.depth + 1,
            is_sharp: leg.is_sharp && way.density == 0.0,
            density: way.density,
        };
        let survivor = next.survivor(|| self.chance());
        self.scratch.pending.extend(survivor);
    }

    /// A random number in 0..1.
    fn chance(&mut self) -> f64 {
        self.draws.next(self.integrator.seed)
    }
}

/// A direction in which a path goes on.
struct Way {
    direction: DVec3,
    share: Rgb,
    /// Density of the direction, 1/sr, if it was drawn; 0 if it is mirrored or refracted.
    density: f64,
}

impl Way {
    /// The same, taken with that probability.
    fn over(self, odds: f64) -> Way {
        Way {
            share: self.share / odds,
            ..self
        }
    }

    fn sharp((direction, share): (DVec3, Rgb)) -> Way {
        Way {
            direction,
            share,
            density: 0.0,
        }
    }
}

/// The light that the first pass left on the surfaces.
impl DiffuseLight for Integrator<'_> {
    /// Coarse below the size of the patch, and at any distance on backs, whose light the first
    /// pass does not say.
    fn glow(&self, at: &Arrival, _replicate: usize) -> Glow {
        let material = self.surfaces().material(at.hit.item);
        if material.diffuse.is_black() {
            return Glow::default();
        }
        let spot = self.scenery.interpolator.spot(&at.ray, &at.hit);
        let reflectance = self.reflectance(at);
        Glow {
            radiosity: (spot.irradiance() * reflectance).to_f32(),
            grain: if at.front {
                spot.grain()
            } else {
                f32::INFINITY
            },
        }
    }

    fn reflectance(&self, at: &Arrival) -> Rgb {
        let material = self.surfaces().material(at.hit.item);
        self.scenery.interpolator.reflectance(&at.hit, material)
    }
}

impl Leg {
    fn first(ray: KernelRay) -> Leg {
        Leg {
            ray,
            weight: Rgb::WHITE,
            depth: 0,
            is_sharp: true,
            density: 0.0,
        }
    }

    /// Russian roulette: the leg itself while it carries enough, by chance a heavier one when it
    /// carries little, nothing when it carries nothing.
    fn survivor(self, chance: impl FnOnce() -> f64) -> Option<Leg> {
        let odds = self.weight.max_channel() / ROULETTE_BELOW;
        if odds >= 1.0 {
            return Some(self);
        }
        (odds > 0.0 && chance() < odds).then(|| Leg {
            weight: self.weight / odds,
            ..self
        })
    }
}
