//! Radiance along rays: the irradiance of the first pass, seen through mirrors and glass and by way
//! of glossy lobes.

use crate::measured::RayRadiance;
use crate::path_cost::PathCost;
use crate::path_sampler::PathSampler;
use crate::render_scene::{RenderScene, ShadowBatch};
use crate::shading::{Colors, Parts, Shading, mirrored};
use crate::{FinalGather, SecondPass};
use azulejo_scene::math::Ray;
use azulejo_scene::{Camera, Material, Rgb, Scene};
use azulejo_trace::interaction::{
    Branching, Continuation, Roulette, SPLIT_DEPTH, SurfaceInteraction,
};
use azulejo_trace::medium::Leg;
use azulejo_trace::sampling::hash;
use azulejo_trace::{
    DiffuseHit, DiffuseLight, DirectionTables, GatherOptions, GatherPoint, OutgoingRadiosity,
    REPLICATES, Termination,
};
use azulejo_trace::{KernelHit, KernelRay, Surfaces, Tracer};
use std::f64::consts::FRAC_1_PI;
use std::sync::atomic::{AtomicU64, Ordering};

/// Ends paths that carry little of what the camera sees: a hall of mirrors ends.
const ROULETTE: Roulette = Roulette::below(Roulette::SHARE);

/// Samples of the lamps, and of directions, where a relief is seen: all of its irradiance is sampled.
const RELIEF_SAMPLES: u32 = 4;

/// About how many rays one call of the gatherer traces: bounds its memory.
const GATHER_BATCH: u32 = 16_384;

/// Finds radiance in one scene under one set of options. Immutable, shared by all threads.
pub(crate) struct Integrator<'a> {
    scene: RenderScene<'a>,
    /// Where irradiance is gathered.
    pub gather: FinalGather,
    /// See [`SecondPass::evenness`](crate::SecondPass::evenness).
    evenness: f64,
    /// Whether the scene carries irradiance.
    is_solved: bool,
    /// Whether it has a lightmap, of which surfaces without one get light.
    has_lightmap: bool,
    seed: u32,
    max_depth: u32,
    /// Whether direct light is told from indirect light in stored irradiance.
    pub splits: bool,
    /// Most radiance that the indirect paths of one ray add.
    clamp: Option<f64>,
}

/// A segment of a camera path, still to be traced.
#[derive(Clone, Copy, Debug)]
struct Segment {
    leg: Leg,
    /// Share of the radiance found that reaches the camera.
    weight: Rgb,
    /// Interfaces passed so far.
    depth: u32,
    /// Surfaces so far that scattered the path; mirrors and glass do not.
    scattered: u32,
    /// Density of its direction, 1/sr, if that was sampled where the lamps were sampled too; 0
    /// otherwise.
    density: f64,
}

/// A final gather at a hit, put off so that the gathers of a batch run together.
#[derive(Clone, Copy, Debug)]
struct DeferredGather {
    /// Number of the camera ray in the batch.
    ray: usize,
    /// What one unit of irradiance adds to the ray's radiance.
    weight: Rgb,
    point: GatherPoint,
    /// Whether the camera sees the point sharply.
    is_first: bool,
}

/// Working memory for a batch, kept between batches to save allocations.
#[derive(Default)]
pub(crate) struct Scratch {
    hits: Vec<KernelHit>,
    next: Vec<KernelHit>,
    pending: Vec<Segment>,
    deferred: Vec<DeferredGather>,
    /// Where irradiance was read whose direct part is to be told apart.
    to_split: Vec<DeferredGather>,
    points: Vec<GatherPoint>,
    shadows: ShadowBatch,
    /// Rays of camera paths after their first segment.
    traced: u64,
}

impl<'a> Integrator<'a> {
    pub fn new(scene: &'a Scene, tracer: &'a Tracer, options: &SecondPass) -> Integrator<'a> {
        Integrator {
            scene: RenderScene::new(scene, tracer),
            gather: options.gather,
            evenness: options.evenness,
            is_solved: scene.is_solved(),
            has_lightmap: scene.has_lightmap(),
            seed: hash(&[options.seed as u32, (options.seed >> 32) as u32]),
            max_depth: options.max_depth,
            splits: false,
            clamp: options.clamp,
        }
    }

    /// The same for an image of this size of what a camera sees.
    pub fn behind(mut self, camera: &Camera, size: (u32, u32)) -> Integrator<'a> {
        self.scene = self.scene.behind(camera, size);
        self
    }

    /// Keys all random numbers.
    pub fn seed(&self) -> u32 {
        self.seed
    }

    /// A ray in the coordinates of the kernel.
    pub fn kernel_ray(&self, ray: &Ray) -> KernelRay {
        self.tracer().kernel_ray(ray)
    }

    fn tracer(&self) -> &'a Tracer {
        self.scene.tracer()
    }

    fn surfaces(&self) -> &Surfaces<'a> {
        self.scene.surfaces()
    }

    /// Estimates the radiance along each ray, in their order, into `found`. `sampler` gives the
    /// random numbers of the ray of that number.
    pub fn radiance(
        &self,
        rays: &[KernelRay],
        sampler: impl Fn(usize) -> PathSampler,
        scratch: &mut Scratch,
        found: &mut Vec<RayRadiance>,
    ) {
        self.follow(rays, sampler, scratch, found);
        self.resolve(scratch, found);
        self.split(scratch, found);
        if let Some(most) = self.clamp {
            found.iter_mut().for_each(|radiance| radiance.limit(most));
        }
    }

    /// Mean cost of the paths that start along `rays`.
    pub fn cost(
        &self,
        rays: &[KernelRay],
        sampler: impl Fn(usize) -> PathSampler,
        scratch: &mut Scratch,
    ) -> PathCost {
        self.follow(rays, sampler, scratch, &mut Vec::new());
        let mean = |sum: usize| sum as f64 / rays.len().max(1) as f64;
        PathCost {
            rays: mean(rays.len() + scratch.traced as usize),
            gathers: mean(scratch.deferred.len()),
            per_direction: self.cost_per_direction(&scratch.deferred),
            direct: self.scene.gatherer.direct_cost(),
        }
    }

    /// Mean cost of a direction of deferred gathers: its first ray, and two for each hit from which it goes on.
    fn cost_per_direction(&self, deferred: &[DeferredGather]) -> f64 {
        let options = GatherOptions {
            rays: REPLICATES as u32,
            ..self.gather_options()
        };
        let light = CountedLight {
            light: self,
            read: AtomicU64::new(0),
        };
        let directions = DirectionTables::new(&options);
        let points: Vec<GatherPoint> = deferred.iter().map(|d| d.point).collect();
        for points in points.chunks(GATHER_BATCH as usize / REPLICATES) {
            let gatherer = &self.scene.gatherer;
            gatherer.gather_with(points, &options, &directions, &light);
        }
        let hits = light.read.into_inner() as f64;
        let rays = (points.len() * REPLICATES).max(1) as f64;
        (2.0 * hits / rays - 1.0).max(1.0)
    }

    /// How gathers are made.
    fn gather_options(&self) -> GatherOptions {
        GatherOptions {
            rays: self.gather.rays(),
            seed: self.seed,
            spent: 0,
            termination: Termination::Radiosity,
        }
    }

    /// Radiance along each ray into `found`, without the deferred gathers.
    fn follow(
        &self,
        rays: &[KernelRay],
        sampler: impl Fn(usize) -> PathSampler,
        scratch: &mut Scratch,
        found: &mut Vec<RayRadiance>,
    ) {
        let mut hits = std::mem::take(&mut scratch.hits);
        self.tracer().closest(rays, &mut hits);
        found.clear();
        found.extend(
            rays.iter()
                .zip(&hits)
                .enumerate()
                .map(|(number, (&ray, hit))| {
                    let mut path = CameraPath {
                        integrator: self,
                        number,
                        sampler: sampler(number),
                        scratch: &mut *scratch,
                        found: RayRadiance::default(),
                    };
                    path.radiance(Segment::first(ray), hit)
                }),
        );
        scratch.hits = hits;
    }

    /// Runs the deferred gathers and adds what they find to their rays.
    fn resolve(&self, scratch: &mut Scratch, found: &mut [RayRadiance]) {
        let options = self.gather_options();
        let directions = DirectionTables::new(&options);
        let gatherer = &self.scene.gatherer;
        let together = (GATHER_BATCH / options.rays.max(1)).max(1) as usize;
        for batch in scratch.deferred.chunks(together) {
            scratch.points.clear();
            scratch.points.extend(batch.iter().map(|d| d.point));
            let gathered = gatherer.gather_with(&scratch.points, &options, &directions, self);
            for (deferred, gathered) in batch.iter().zip(gathered) {
                let radiance = &mut found[deferred.ray];
                let [direct, indirect] = [gathered.direct, gathered.indirect];
                if !deferred.is_first {
                    radiance.sampled += deferred.weight * gathered.whole().mean();
                } else if self.splits {
                    radiance.direct += deferred.weight * direct.mean();
                    radiance.stored += deferred.weight * indirect.mean();
                } else {
                    radiance.stored += deferred.weight * gathered.whole().mean();
                }
                radiance.is_random = true;
            }
        }
        scratch.deferred.clear();
    }

    /// Tells the direct part of the irradiance that was read from the rest, which it leaves: both
    /// together stay what was read.
    fn split(&self, scratch: &mut Scratch, found: &mut [RayRadiance]) {
        for batch in scratch.to_split.chunks(GATHER_BATCH as usize) {
            scratch.points.clear();
            scratch.points.extend(batch.iter().map(|d| d.point));
            let direct = self.scene.gatherer.direct(&scratch.points, 1, self.seed);
            for (at, direct) in batch.iter().zip(direct) {
                let light = at.weight * direct.whole().mean();
                found[at.ray].direct += light;
                found[at.ray].stored += light * -1.0;
            }
        }
        scratch.to_split.clear();
    }
}

/// A camera path while it is followed.
struct CameraPath<'p, 'a> {
    integrator: &'p Integrator<'a>,
    /// The ray's number in its batch.
    number: usize,
    sampler: PathSampler,
    scratch: &'p mut Scratch,
    /// What was found so far.
    found: RayRadiance,
}

impl<'a> CameraPath<'_, 'a> {
    /// Radiance along the first segment, which ends at `hit`, and along all that follow from it,
    /// without the deferred gathers.
    fn radiance(&mut self, first: Segment, hit: &KernelHit) -> RayRadiance {
        let (first, fog) = self.through_fog(first, hit);
        self.found.direct += fog;
        self.shade(&first, hit);
        while let Some(segment) = self.scratch.pending.pop() {
            let ray = std::slice::from_ref(&segment.leg.ray);
            self.scratch.traced += 1;
            self.integrator
                .tracer()
                .closest(ray, &mut self.scratch.next);
            let found = self.scratch.next[0];
            self.shade(&segment, &found);
        }
        RayRadiance {
            is_random: self.sampler.is_used(),
            ..self.found
        }
    }

    /// Counts light that a path found after as many surfaces that scattered it.
    fn count(&mut self, scattered: u32, light: Rgb) {
        if scattered <= 1 {
            self.found.direct += light;
        } else {
            self.found.sampled += light;
        }
    }

    /// The first segment with the share of its light that the fog lets through, and the radiance
    /// that the fog adds.
    fn through_fog(&self, first: Segment, hit: &KernelHit) -> (Segment, Rgb) {
        let Some((clear, added)) = self.integrator.scene.fog(&first.leg.ray, hit) else {
            return (first, Rgb::BLACK);
        };
        let weight = first.weight * clear;
        (Segment { weight, ..first }, first.weight * added)
    }

    /// Adds what a segment contributes; its continuations become pending.
    fn shade(&mut self, segment: &Segment, found: &KernelHit) {
        let scene = &self.integrator.scene;
        let (hit, front) = segment.leg.hit(scene.surfaces(), found);
        let hit = &hit;
        if !hit.is_hit() {
            let beyond = scene.beyond(&segment.leg.ray, segment.is_sharp(), segment.density);
            self.count(segment.scattered, segment.weight * beyond);
            return;
        }
        let surfaces = scene.surfaces();
        if let Some((film, glass)) = segment.leg.air_film(surfaces, hit) {
            self.pass(segment, &film, glass);
            return;
        }
        let material = surfaces.material(hit.item);
        let emitted = scene.emitted(&segment.leg.ray, hit, segment.density);
        self.count(segment.scattered, segment.weight * emitted);
        // The irradiance of a tilted normal is not known: lamps and directions are sampled, as for matt
        // lobes.
        let is_tilted =
            segment.is_sharp() && material.dielectric.is_none() && scene.has_relief(hit);
        let is_glossy = material.is_specular() || material.brdf.is_some();
        let at = (is_glossy || is_tilted).then(|| scene.interaction(&segment.leg.ray, hit));
        let mut is_lit = false;
        if !material.diffuse.is_black() && !is_tilted {
            let (ray, hit) = (segment.leg.ray, *hit);
            let reflectance = self.read_reflectance(segment, &hit, at.as_ref(), material);
            is_lit = self.reflect_irradiance(segment, &DiffuseHit { ray, hit, front }, reflectance);
        }
        if let Some(at) = at {
            self.scatter(segment, hit, &at, material, is_lit);
        }
    }

    /// Reflectance for the irradiance at a hit: of a surface that is seen sharply the diffuse part,
    /// and the albedo of its matt lobes in that direction; else the mean of both.
    fn read_reflectance(
        &self,
        segment: &Segment,
        hit: &KernelHit,
        at: Option<&SurfaceInteraction>,
        material: &'a Material,
    ) -> Rgb {
        let scene = &self.integrator.scene;
        let reflectance = scene.reflectance(hit, material);
        let Some(at) = at.filter(|_| segment.is_sharp()) else {
            return reflectance;
        };
        let matt = scene.shading(hit, at, material, Parts::MattAndLobes);
        Colors::new(reflectance, material.brdf.as_deref()).lambert + matt.matt_albedo()
    }

    /// Adds diffusely reflected radiance ρE/π, or defers its gather; false if the irradiance is not
    /// known at all, because there was no first pass.
    fn reflect_irradiance(&mut self, segment: &Segment, at: &DiffuseHit, reflectance: Rgb) -> bool {
        let weight = segment.weight * reflectance * FRAC_1_PI;
        let is_everywhere = matches!(self.integrator.gather, FinalGather::Everywhere(_));
        let shows_patches = !is_everywhere || (self.integrator.is_solved && !segment.is_sharp());
        let look_up = || self.integrator.scene.interpolator.lookup(&at.ray, &at.hit);
        // The lamps of a lightmap may be gone, so that nothing else finds their light.
        let may_be_baked = self.integrator.has_lightmap;
        let solved = (shows_patches || may_be_baked).then(look_up);
        if let Some(solved) = solved.filter(|s| shows_patches || s.is_baked()) {
            let may_gather = matches!(self.integrator.gather, FinalGather::Uneven(_));
            let is_uneven = may_gather
                && segment.is_sharp()
                && solved.is_uneven(at.front, self.integrator.evenness);
            match solved.irradiance(at.front) {
                Some(irradiance) if !is_uneven => {
                    self.read_irradiance(segment, at, irradiance, weight);
                    return true;
                }
                // Without a solution only lamps show.
                None if at.front && !self.integrator.has_lightmap => return false,
                _ => {}
            }
        }
        let deferred = self.deferred(segment, at, weight);
        self.scratch.deferred.push(deferred);
        true
    }

    /// Adds the light of irradiance that was read.
    fn read_irradiance(&mut self, segment: &Segment, at: &DiffuseHit, found: Rgb, weight: Rgb) {
        let light = weight * found;
        if segment.scattered > 0 {
            self.found.sampled += light;
            return;
        }
        self.found.stored += light;
        if self.integrator.splits {
            let deferred = self.deferred(segment, at, weight);
            self.scratch.to_split.push(deferred);
        }
    }

    /// The point of a hit, for work that is put off.
    fn deferred(&self, segment: &Segment, at: &DiffuseHit, weight: Rgb) -> DeferredGather {
        let tracer = self.integrator.tracer();
        let point = tracer.resolve(&tracer.world_ray(&segment.leg.ray), &at.hit);
        let serial = self.scratch.deferred.len() as u32;
        DeferredGather {
            ray: self.number,
            weight,
            is_first: segment.scattered == 0,
            point: GatherPoint {
                position: point.position,
                normal: if at.front {
                    point.normal
                } else {
                    -point.normal
                },
                key: hash(&[self.sampler.stream, self.sampler.sample, serial]),
            },
        }
    }

    /// Continues the path in mirrored, refracted and sampled directions, and adds the radiance of
    /// lamps and lights that glossy lobes reflect. `is_lit` if the irradiance was reflected already.
    fn scatter(
        &mut self,
        segment: &Segment,
        hit: &KernelHit,
        at: &SurfaceInteraction,
        material: &'a Material,
        is_lit: bool,
    ) {
        if material.dielectric.is_some() {
            self.pass(segment, at, material);
        } else {
            self.reflect(segment, hit, at, material, is_lit);
        }
    }

    /// Continues the path in the mirrored and the refracted direction.
    fn pass(&mut self, segment: &Segment, at: &SurfaceInteraction, glass: &Material) {
        let Some(interface) = at.interface(glass) else {
            return;
        };
        let next = interface.continuations(segment.depth, SPLIT_DEPTH, || self.chance());
        for next in next.into_iter().flatten() {
            self.send(segment, at, next);
        }
    }

    /// Continues the path in the mirrored direction and in one sampled from the lobes, at first
    /// interfaces in both, later in one by chance; adds the radiance of lamps and lights that the
    /// lobes reflect. Rays to lamps and rays from the lobes count a lamp once.
    ///
    /// Where irradiance was read (`is_lit`), matt lobes contribute what they reflect otherwise than a
    /// diffuse surface of their albedo alone. To follow them whole, from every pixel, would find the
    /// caustics of all glossy surfaces around, a sample in a thousand at a time.
    fn reflect(
        &mut self,
        segment: &Segment,
        hit: &KernelHit,
        at: &SurfaceInteraction,
        material: &'a Material,
        is_lit: bool,
    ) {
        let scene = &self.integrator.scene;
        // Seen sharply, matt lobes are sampled too, and a relief whole, as its irradiance is not known.
        let parts = match segment.is_sharp() {
            true if scene.has_relief(hit) => Parts::All,
            true => Parts::MattAndLobes,
            false => Parts::Lobes,
        };
        let shading = scene.shading(hit, at, material, parts);
        let shading = if is_lit {
            shading.without_albedo()
        } else {
            shading
        };
        let share = mirrored(material, -at.direction.dot(at.shading_normal));
        let mirror = at.mirrored(share);
        // A surface that only mirrors needs neither samples nor lamps.
        if shading.is_black() {
            if !share.is_black() {
                self.send(segment, at, mirror);
            }
            return;
        }
        // At first interfaces follow both parts; then one by chance, so that paths do not multiply.
        let splits = segment.depth < SPLIT_DEPTH;
        let branching = Branching::new(splits, share.mean(), || shading.likely());
        let (of_mirror, of_lobes) = branching.choose(|| self.chance());
        if let Some(probability) = of_mirror {
            self.send(segment, at, mirror.over(probability));
        }
        // A relief that the camera sees itself takes more samples, because all of its light comes from them.
        let is_first = segment.depth == 0 && parts == Parts::All;
        let count = if is_first { RELIEF_SAMPLES } else { 1 };
        let mut light = Rgb::BLACK;
        for _ in 0..count {
            if let Some(probability) = of_lobes {
                let u = [(); 4].map(|()| self.chance());
                if let Some(sample) = shading.sample(u) {
                    let next = sample.chosen(probability).over(f64::from(count));
                    self.send(segment, at, next);
                }
            }
            light += self.lit(&shading, branching.lobe_probability());
        }
        let lit = segment.weight * (light / f64::from(count));
        self.count(segment.scattered + 1, lit);
    }

    /// What lobes show of lamps and lights; `lobe_probability` as for [`RenderScene::lit`].
    fn lit(&mut self, shading: &Shading, lobe_probability: f64) -> Rgb {
        let u = [(); 4].map(|()| self.chance());
        let scene = &self.integrator.scene;
        let lit = scene.lit(shading, u, lobe_probability, &mut self.scratch.shadows);
        self.scratch.traced += self.scratch.shadows.len() as u64;
        lit
    }

    /// Makes the segment in that direction pending, unless roulette or the safety cap ends it.
    fn send(&mut self, segment: &Segment, at: &SurfaceInteraction, next: Continuation) {
        if segment.depth >= self.integrator.max_depth {
            return;
        }
        let weight = segment.weight * next.weight;
        let carried = weight.map(f64::abs).max_channel();
        let survival = ROULETTE.survival(carried, || self.chance());
        let Some(survival) = survival else { return };
        self.scratch.pending.push(Segment {
            leg: at.leg(self.integrator.scene.surfaces(), &next, segment.leg.medium),
            weight: weight / survival,
            depth: segment.depth + 1,
            scattered: segment.scattered + u32::from(next.density != 0.0),
            density: next.density_after(segment.density),
        });
    }

    /// A random number in 0..1.
    fn chance(&mut self) -> f64 {
        self.sampler.next(self.integrator.seed)
    }
}

/// The irradiance of the first pass.
impl DiffuseLight for Integrator<'_> {
    /// Too coarse from nearer than the size of the patch, and from any distance on a side of which
    /// the scene carries no irradiance.
    fn outgoing(&self, at: &DiffuseHit, _replicate: usize) -> OutgoingRadiosity {
        let material = self.surfaces().material(at.hit.item);
        if material.diffuse.is_black() {
            return OutgoingRadiosity::default();
        }
        let lookup = self.scene.interpolator.lookup(&at.ray, &at.hit);
        let reflectance = self.reflectance(at);
        let known = lookup.irradiance(at.front);
        OutgoingRadiosity {
            radiosity: (known.unwrap_or(Rgb::BLACK) * reflectance).to_f32(),
            footprint: known.map_or(f32::INFINITY, |_| lookup.footprint()),
        }
    }

    /// By the means of pictures of metalness, as the glossy paths of a gather have them, so that both
    /// together reflect no more than arrives.
    fn reflectance(&self, at: &DiffuseHit) -> Rgb {
        let material = self.surfaces().material(at.hit.item);
        self.scene.interpolator.reflectance(&at.hit, material)
    }
}

/// The same, which counts how often it is read.
struct CountedLight<'i, 'a> {
    light: &'i Integrator<'a>,
    read: AtomicU64,
}

impl DiffuseLight for CountedLight<'_, '_> {
    fn outgoing(&self, at: &DiffuseHit, replicate: usize) -> OutgoingRadiosity {
        self.read.fetch_add(1, Ordering::Relaxed);
        self.light.outgoing(at, replicate)
    }

    fn reflectance(&self, at: &DiffuseHit) -> Rgb {
        self.light.reflectance(at)
    }
}

impl Segment {
    /// Whether only mirrors and glass lie between the camera and the segment.
    fn is_sharp(&self) -> bool {
        self.scattered == 0
    }

    fn first(ray: KernelRay) -> Segment {
        Segment {
            leg: Leg::from(ray),
            weight: Rgb::WHITE,
            depth: 0,
            scattered: 0,
            density: 0.0,
        }
    }
}
