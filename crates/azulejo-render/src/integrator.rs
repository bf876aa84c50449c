//! Radiance along rays: what the first pass left on the surfaces, seen through mirrors and glass and
//! by way of glossy lobes.

use crate::SecondPass;
use crate::draws::Draws;
use crate::scenery::{Scenery, Shadows};
use crate::shading::{Colors, Parts, Shading, mirrored};
use azulejo_scene::math::Ray;
use azulejo_scene::{Material, Rgb, Scene};
use azulejo_trace::interaction::{
    Branching, Continuation, Roulette, SPLIT_DEPTH, SurfaceInteraction,
};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Arrival, DiffuseLight, GatherOptions, GatherPoint, Glow};
use azulejo_trace::{KernelHit, KernelRay, Surfaces, Tracer};
use std::f64::consts::FRAC_1_PI;

/// Ends paths that carry little of what the camera sees: a hall of mirrors ends.
const ROULETTE: Roulette = Roulette::below(Roulette::SHARE);

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

    /// Continues the path in mirrored, refracted and sampled directions; returns the radiance of
    /// lamps and lights that glossy lobes reflect.
    fn scatter(&mut self, leg: &Leg, hit: &KernelHit, material: &'a Material) -> Rgb {
        let at = self.integrator.scenery.interaction(&leg.ray, hit);
        let Some(glass) = material.dielectric else {
            return self.reflect(leg, hit, &at, material);
        };
        let interface = at.dielectric(&glass, material.mirror);
        let next = interface.continuations(leg.depth, SPLIT_DEPTH, || self.chance());
        for next in next.into_iter().flatten() {
            self.send(leg, &at, next);
        }
        Rgb::BLACK
    }

    /// Continues the path in the mirrored direction and in one sampled from the lobes, at first
    /// interfaces in both, later in one by chance; returns the radiance of lamps and lights that
    /// the lobes reflect. Rays to lamps and rays from the lobes count a lamp once.
    fn reflect(
        &mut self,
        leg: &Leg,
        hit: &KernelHit,
        at: &SurfaceInteraction,
        material: &'a Material,
    ) -> Rgb {
        let parts = if leg.is_sharp {
            Parts::MattAndLobes
        } else {
            Parts::Lobes
        };
        let scenery = &self.integrator.scenery;
        let shading = scenery.shading(hit, at, material, parts);
        let share = mirrored(material, -at.direction.dot(at.shading_normal));
        let mirror = at.mirrored(share);
        if shading.is_black() {
            if !share.is_black() {
                self.send(leg, at, mirror);
            }
            return Rgb::BLACK;
        }
        let splits = leg.depth < SPLIT_DEPTH;
        let branching = Branching::new(splits, share.mean(), || shading.likely());
        let (of_mirror, of_lobes) = branching.choose(|| self.chance());
        if let Some(probability) = of_mirror {
            self.send(leg, at, mirror.over(probability));
        }
        if let Some(probability) = of_lobes {
            let u = [(); 4].map(|()| self.chance());
            if let Some(sample) = shading.sample(u) {
                self.send(leg, at, sample.chosen(probability));
            }
        }
        self.lit(&shading, branching.lobe_probability())
    }

    /// What lobes show of lamps and lights; `by_chance` as for [`Scenery::lit`].
    fn lit(&mut self, shading: &Shading, by_chance: f64) -> Rgb {
        let u = [(); 4].map(|()| self.chance());
        let scenery = &self.integrator.scenery;
        scenery.lit(shading, u, by_chance, &mut self.scratch.shadows)
    }

    /// Makes the leg in that direction pending, unless roulette or the safety cap ends it.
    fn send(&mut self, leg: &Leg, at: &SurfaceInteraction, next: Continuation) {
        if leg.depth >= self.integrator.max_depth {
            return;
        }
        let weight = leg.weight * next.weight;
        let survival = ROULETTE.survival(weight.max_channel(), || self.chance());
        let Some(survival) = survival else { return };
        self.scratch.pending.push(Leg {
            ray: at.spawn_ray(self.integrator.tracer(), next.direction),
            weight: weight / survival,
            depth: leg.depth + 1,
            is_sharp: leg.is_sharp && next.density == 0.0,
            density: next.density,
        });
    }

    /// A random number in 0..1.
    fn chance(&mut self) -> f64 {
        self.draws.next(self.integrator.seed)
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
}
