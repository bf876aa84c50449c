//! Radiance along rays: what the first pass left on the surfaces, seen through mirrors and glass.

use crate::SecondPass;
use crate::interpolate::Interpolator;
use azulejo_scene::math::{Ray, reflect};
use azulejo_scene::{Dielectric, Material, Rgb, Scene, fresnel};
use azulejo_trace::sampling::{DIMENSIONS, hash, sobol, uniform};
use azulejo_trace::{Arrival, DiffuseLight, GatherOptions, GatherPoint, Gatherer, Glow};
use azulejo_trace::{Hit, KernelHit, KernelRay, Surfaces, Tracer};
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
    gatherer: Gatherer<'a>,
    interpolator: Interpolator<'a>,
    /// Gather rays per diffuse hit; `None` to show what the first pass left.
    gather: Option<u32>,
    /// What a path finds that leaves the scene: the background, else the surroundings.
    sky: Rgb,
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
}

/// The random numbers of one path: stratified over the samples of its stream.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draws {
    stream: u32,
    sample: u32,
    used: u32,
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
}

impl<'a> Integrator<'a> {
    pub fn new(scene: &'a Scene, tracer: &'a Tracer, options: &SecondPass) -> Integrator<'a> {
        let gatherer = Gatherer::new(Surfaces::new(scene, tracer));
        Integrator {
            sky: scene.background.unwrap_or(gatherer.ambient()),
            gatherer,
            interpolator: Interpolator::new(scene, tracer),
            gather: options.gather,
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
        self.surfaces().tracer
    }

    fn surfaces(&self) -> &Surfaces<'a> {
        self.gatherer.surfaces()
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

    /// Diffusely reflected exitance ρE that the first pass left on the front, W/m².
    fn radiosity(&self, at: &Arrival, material: &Material) -> Rgb {
        let spot = self.interpolator.spot(&at.ray, &at.hit);
        spot.irradiance() * self.interpolator.reflectance(&at.hit, material)
    }

    /// The normal that mirrors and glass bend a ray by: the interpolated one of a smooth mesh, on
    /// the side of the face's own, `facing`; `facing` itself where the mesh has none, or where the
    /// interpolated one would mirror the ray into the face.
    fn smooth_normal(&self, hit: &KernelHit, facing: DVec3, direction: DVec3) -> DVec3 {
        let Some(normal) = self.interpolator.shading_normal(hit) else {
            return facing;
        };
        let n = normal * 1f64.copysign(normal.dot(facing));
        let is_usable = direction.dot(n) < 0.0 && reflect(direction, n).dot(facing) > 0.0;
        if is_usable { n } else { facing }
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
            let gathered = self.gatherer.gather(&scratch.points, &options, self);
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

impl Path<'_, '_> {
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
            is_random: self.draws.used > 0,
        }
    }

    /// The first leg with what the fog leaves of its light, and what the fog adds. Fog is a matter
    /// of the viewer: it hides no background, and mirrors show what they show.
    fn through_fog(&self, first: Leg, hit: &KernelHit) -> (Leg, Rgb) {
        let Some(fog) = self
            .integrator
            .surfaces()
            .scene
            .fog
            .filter(|_| hit.is_hit())
        else {
            return (first, Rgb::BLACK);
        };
        let tracer = self.integrator.tracer();
        let ray = tracer.world_ray(&first.ray);
        let distance = tracer.resolve(&ray, hit).position.distance(ray.origin);
        let clear = fog.transmittance(distance);
        let weight = first.weight * clear;
        (
            Leg { weight, ..first },
            first.weight * fog.color * (1.0 - clear),
        )
    }

    /// What a leg adds where it ends; what goes on from there becomes pending.
    fn arrive(&mut self, leg: &Leg, hit: &KernelHit) -> Rgb {
        if !hit.is_hit() {
            return leg.weight * self.integrator.sky;
        }
        let surfaces = self.integrator.surfaces();
        let material = surfaces.material(hit.item);
        let mut own = Rgb::BLACK;
        if material.is_emitter() || !material.diffuse.is_black() {
            let front = surfaces.is_front(&leg.ray, hit);
            let (ray, hit) = (leg.ray, *hit);
            own = self.own_light(leg, &Arrival { ray, hit, front }, material);
        }
        if material.is_specular() {
            self.scatter(leg, hit, material);
        }
        leg.weight * own
    }

    /// Radiance that leaves a surface by itself: emitted, and reflected diffusely.
    fn own_light(&mut self, leg: &Leg, at: &Arrival, material: &Material) -> Rgb {
        let emitted = material.emission_from(at.front);
        if material.diffuse.is_black() {
            return emitted;
        }
        emitted + self.reflected(leg, at, material)
    }

    /// Diffusely reflected radiance ρE/π; black if its irradiance is still to be gathered.
    fn reflected(&mut self, leg: &Leg, at: &Arrival, material: &Material) -> Rgb {
        if self.integrator.gather.is_none() && at.front {
            return self.integrator.radiosity(at, material) * FRAC_1_PI;
        }
        let tracer = self.integrator.tracer();
        let place = tracer.resolve(&tracer.world_ray(&leg.ray), &at.hit);
        let serial = self.scratch.wishes.len() as u32;
        self.scratch.wishes.push(Wish {
            ray: self.number,
            weight: leg.weight * self.integrator.reflectance(at) * FRAC_1_PI,
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

    /// Sends the path on into mirrored and refracted directions.
    fn scatter(&mut self, leg: &Leg, hit: &KernelHit, material: &Material) {
        let tracer = self.integrator.tracer();
        let ray = tracer.world_ray(&leg.ray);
        let at = tracer.resolve(&ray, hit);
        let facing = if at.entering { at.normal } else { -at.normal };
        let direction = ray.direction.normalize();
        let smooth = self.integrator.smooth_normal(hit, facing, direction);
        let Some(glass) = material.dielectric else {
            let mirrored = (reflect(direction, smooth), material.mirror);
            return self.send(leg, &at, facing, mirrored);
        };
        let boundary = Boundary::new(&glass, material.mirror, direction, smooth, at.entering);
        if leg.depth < SPLIT_DEPTH {
            self.send(leg, &at, facing, boundary.mirrored());
            if let Some(passed) = boundary.passed() {
                self.send(leg, &at, facing, passed);
            }
        } else {
            let chosen = boundary.chosen(self.chance());
            self.send(leg, &at, facing, chosen);
        }
    }

    /// Makes the leg pending that leaves `at` in a direction with a share of the weight, unless
    /// roulette or the safety cap ends it. `facing` is the normal toward where the path came from.
    fn send(&mut self, leg: &Leg, at: &Hit, facing: DVec3, (direction, share): (DVec3, Rgb)) {
        if leg.depth >= self.integrator.max_depth {
            return;
        }
        let tracer = self.integrator.tracer();
        let side = facing * 1f64.copysign(direction.dot(facing));
        let ray = Ray::new(tracer.leaving(at.position, side), direction);
        let next = Leg {
            ray: tracer.kernel_ray(&ray),
            weight: leg.weight * share,
            depth: leg.depth + 1,
        };
        let survivor = next.survivor(|| self.chance());
        self.scratch.pending.extend(survivor);
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
        let spot = self.interpolator.spot(&at.ray, &at.hit);
        let reflectance = self.interpolator.reflectance(&at.hit, material);
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
        self.interpolator.reflectance(&at.hit, material)
    }
}

impl Leg {
    fn first(ray: KernelRay) -> Leg {
        Leg {
            ray,
            weight: Rgb::WHITE,
            depth: 0,
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

/// A dielectric boundary, or a pane, as one path meets it.
struct Boundary {
    split: fresnel::Split,
    /// Scales the mirrored part.
    mirror: Rgb,
    /// Scales the part that passes.
    transmittance: Rgb,
}

impl Boundary {
    fn new(
        glass: &Dielectric,
        mirror: Rgb,
        direction: DVec3,
        facing: DVec3,
        entering: bool,
    ) -> Boundary {
        if glass.thin {
            return Boundary {
                split: fresnel::pane(direction, facing, glass.ior),
                mirror,
                transmittance: glass.transmittance,
            };
        }
        let eta = if entering { glass.ior } else { 1.0 / glass.ior };
        Boundary {
            split: fresnel::split(direction, facing, eta),
            mirror,
            // Refraction conserves L/n², so radiance from the far side arrives divided by η².
            transmittance: glass.transmittance / (eta * eta),
        }
    }

    /// Direction and share of the mirrored part.
    fn mirrored(&self) -> (DVec3, Rgb) {
        let split = &self.split;
        (split.reflected, self.mirror * split.reflectance)
    }

    /// Direction and share of the part that passes.
    fn passed(&self) -> Option<(DVec3, Rgb)> {
        let share = self.transmittance * (1.0 - self.split.reflectance);
        self.split.refracted.map(|direction| (direction, share))
    }

    /// One of the two by a `chance` in 0..1, mirrored with probability R, and the share that
    /// keeps the mean right.
    fn chosen(&self, chance: f64) -> (DVec3, Rgb) {
        match self.split.refracted {
            Some(direction) if chance >= self.split.reflectance => (direction, self.transmittance),
            _ => (self.split.reflected, self.mirror),
        }
    }
}

impl Draws {
    /// The numbers of sample `sample` of pixel or probe ray `stream`.
    pub fn new(stream: u32, sample: u32) -> Draws {
        Draws {
            stream,
            sample,
            used: 0,
        }
    }

    /// The next number in 0..1.
    ///
    /// The first six come from Sobol dimensions 2 to 7 (the film has 0 and 1).
    fn next(&mut self, seed: u32) -> f64 {
        let dimension = self.used + 2;
        self.used += 1;
        let key = [seed, self.stream, dimension];
        f64::from(if (dimension as usize) < DIMENSIONS {
            sobol(self.sample, dimension as usize, hash(&key))
        } else {
            uniform(&[hash(&key), self.sample])
        })
    }
}
