//! Irradiance at points: direct light by formulas and shadow rays, the rest by rays over the
//! hemisphere that read the radiosity of the diffuse surfaces they reach, through mirrors and glass
//! too.
//!
//! Both passes gather here: the first at the vertices, the second at the hits of a final gather.
//! They differ in where the radiosity of diffuse surfaces comes from ([`DiffuseLight`]).

mod collector;
mod direct;
mod directions;
mod estimate;
mod harmonics;
mod light_clusters;
mod many_lights;
mod next_event;
mod outside;
mod pictured;
mod polygon;
mod shadow;
mod sources;
mod terms;

use crate::follow::{Path, Scratch, Via};
use crate::lights::{Lights, mis_weight};
use crate::sampling::{hash, seeds, uniform};
use crate::{KernelHit, KernelRay, Surfaces};
use azulejo_scene::math::{Frame, Ray};
use azulejo_scene::{MaterialId, Rgb, Shape};
use collector::Collector;
use direct::{Direct, MOST_TERMS, ShadowRays};
pub use directions::DirectionTables;
pub use estimate::{DirectLight, Gathered, SplitIrradiance, sequence_gain};
use glam::DVec3;
pub use harmonics::{Harmonics, IncidentDomain};
pub use many_lights::SurfaceSamples;
pub use next_event::NextEvent;
use sources::DirectSources;
pub use sources::EmitterForm;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Number of estimates of every quantity, from equal shares of its samples: their spread gives its
/// standard error. Those of rows of form factors are independent; those of a gather are
/// consecutive stretches of one sequence (shadow rays: of one for each half of them), each well
/// stratified and all together better still.
pub const REPLICATES: usize = 4;

/// A hit nearer than the footprint of its patch is replaced by a gather at the hit, at most this
/// many times in a row.
const MOST_CONTACTS: u32 = 6;

/// Share of a surface's reflectance by which paths survive whatever its radiosity is said to be.
const UNKNOWN_SHARE: f64 = 0.25;

/// How much likelier than in proportion to what they carry paths survive: the noise of roulette is
/// worth more than the few segments that it saves (measured; 1 takes three times as long).
const SURVIVAL: f64 = 4.0;

/// Paths that are traced together where nothing is known of the light: enough for the tracer's lanes, few enough for
/// the second level of the cache.
const PIECE: usize = 1024;

/// How much likelier than in proportion to what they carry paths survive where nothing is known of the light: less
/// has more noise than it saves segments (measured in three rooms: 0.5 and 1 take longer to the same error).
const UNKNOWN_SURVIVAL: f64 = 1.4;

/// Weight below which paths may end where the patch they hit is too near to be read.
const LIGHT_WEIGHT: f64 = 0.1;

/// Highest probability of survival of roulette: even where nothing is absorbed paths end, after some
/// fifty bounces.
const MOST_SURVIVAL: f64 = 0.98;

/// Diffuse bounces after which a path is dropped. Roulette leaves one in e^1000 so long.
const MOST_BOUNCES: u32 = 50_000;

/// Rays over the hemisphere for each shadow ray per source.
const SHADOW_SHARE: u32 = 4;

/// Shadow rays for each point at which [`Gatherer::direct_over`] evaluates formulas: a good default,
/// which callers may exceed.
pub const RAYS_PER_FORMULA: usize = 16;

/// A point at which irradiance is gathered.
#[derive(Clone, Copy, Debug)]
pub struct GatherPoint {
    /// World position, on or off a surface.
    pub position: DVec3,
    /// Unit normal of the side that receives.
    pub normal: DVec3,
    /// Keys the random numbers: equal keys give equal samples.
    pub key: u32,
}

/// A hit of a diffuse surface.
#[derive(Clone, Copy, Debug)]
pub struct DiffuseHit {
    /// The ray.
    pub ray: KernelRay,
    /// Where it ends.
    pub hit: KernelHit,
    /// Whether it arrives at the front.
    pub front: bool,
}

/// The radiosity that leaves a diffuse surface, and how coarse it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutgoingRadiosity {
    /// Radiosity by diffuse reflection, without emission, W/m².
    pub radiosity: [f32; 3],
    /// Distance, scene units, from nearer than which `radiosity` is too coarse to be used, such as
    /// the size of the patch; zero if it is exact.
    pub footprint: f32,
}

/// A source of the radiosity of diffuse surfaces.
pub trait DiffuseLight: Sync {
    /// The radiosity at a hit. A solver with independent estimates returns that of `replicate`;
    /// others return the same for all.
    fn outgoing(&self, at: &DiffuseHit, replicate: usize) -> OutgoingRadiosity;

    /// Diffuse reflectance at the hit.
    fn reflectance(&self, at: &DiffuseHit) -> Rgb;

    /// Whether nothing is known of the radiosity, so that [`outgoing`](DiffuseLight::outgoing) returns black
    /// everywhere: paths then survive by what they carry, not by what they are expected to find.
    fn is_unknown(&self) -> bool {
        false
    }
}

/// Where a gather's paths end at diffuse surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Termination {
    /// At the first diffuse surface that is farther than its footprint, whose radiosity is read:
    /// little noise, and the error of that radiosity.
    #[default]
    Radiosity,
    /// By Russian roulette, as in a path tracer that samples a light at every hit (Kajiya, *The
    /// rendering equation*, SIGGRAPH 1986; Arvo and Kirk, *Particle transport and image synthesis*,
    /// 1990). The radiosity at a hit is a control variate alone: it affects the noise, but not the
    /// mean, so its discretization does no harm, for several times the rays and more noise.
    Roulette,
    /// The same after at most this many diffuse reflections. The light that is read must then be
    /// black: radiosity does not tell how often its light was reflected.
    Bounces(u32),
}

impl Termination {
    /// Diffuse surfaces that a path may leave.
    fn most_bounces(self) -> u32 {
        match self {
            Termination::Radiosity => MOST_CONTACTS,
            Termination::Roulette => MOST_BOUNCES,
            Termination::Bounces(most) => most,
        }
    }

    /// Whether paths end by chance.
    fn is_random(self) -> bool {
        self != Termination::Radiosity
    }
}

/// The number and the seed of a gather's samples.
#[derive(Clone, Copy, Debug)]
pub struct GatherOptions {
    /// Rays over the hemisphere per point, rounded up to a multiple of [`REPLICATES`]. Sobol
    /// points are best in powers of two.
    pub rays: u32,
    /// Rays per point that earlier gathers with the same seed have used: this one continues their
    /// sequence, so that all together are one well stratified set.
    pub spent: u32,
    /// Keys all random numbers, together with the key of each point.
    pub seed: u32,
    /// Where paths end.
    pub termination: Termination,
}

impl GatherOptions {
    /// Directions per replicate.
    fn per_replicate(&self) -> u32 {
        self.rays.div_ceil(REPLICATES as u32).max(1)
    }

    /// Shadow rays per replicate and source.
    fn shadow_rays(&self) -> Range<u32> {
        let first = (self.spent / REPLICATES as u32).div_ceil(SHADOW_SHARE);
        first..first + self.per_replicate().div_ceil(SHADOW_SHARE)
    }
}

/// Gathers irradiance in a scene. Immutable; shared by all threads.
pub struct Gatherer<'a> {
    surfaces: Surfaces<'a>,
    lights: Lights<'a>,
    sources: DirectSources,
}

impl<'a> Gatherer<'a> {
    /// Collects the lights and mirrors of a scene.
    pub fn new(surfaces: Surfaces<'a>) -> Gatherer<'a> {
        let lights = Lights::new(&surfaces);
        let sources = DirectSources::new(&surfaces, &lights);
        Gatherer {
            surfaces,
            lights,
            sources,
        }
    }

    /// The scene, its tracer and its items.
    pub fn surfaces(&self) -> &Surfaces<'a> {
        &self.surfaces
    }

    /// Radiance of the surroundings that is the same from all directions, W/(sr·m²).
    pub fn ambient(&self) -> Rgb {
        self.lights.ambient
    }

    /// Whether [`direct`](Gatherer::direct) counts the light that an emitter sends `via` this way:
    /// straight, or from flat emitters by one flat mirror.
    pub fn counts_direct(&self, form: EmitterForm, via: Via) -> bool {
        self.sources.counts_direct(form, via)
    }

    /// The form of an emitter of an object that is `is_flat` and has this material.
    pub fn emitter_form(&self, object: u32, material: MaterialId, is_flat: bool) -> EmitterForm {
        if self.surfaces.emitted_picture(object, material).is_some() {
            EmitterForm::Pictured
        } else if is_flat {
            EmitterForm::Flat
        } else {
            EmitterForm::Curved
        }
    }

    /// The light sources.
    pub fn lights(&self) -> &Lights<'a> {
        &self.lights
    }

    /// Whether the scene has both glossy surfaces and lights that they may show and no surface emits:
    /// without area, or from outside.
    pub fn has_glossy_lights(&self) -> bool {
        let materials = &self.surfaces.scene.materials;
        let has_lights = self.lights.has_delta_lights() || !self.lights.outside.is_empty();
        has_lights && materials.iter().any(|m| m.glossy().is_some())
    }

    /// Exitance that a path finds at a hit beyond what [`direct`](Gatherer::direct) counts: zero for
    /// most hits. The direct light leaves out exact shapes, so all that they emit is found here.
    /// Light in a direction that was sampled from a glossy surface is also found by [`NextEvent`]
    /// and weighted against it.
    pub fn stray_exitance(&self, path: &Path, hit: &KernelHit, front: bool) -> Rgb {
        if !self.surfaces.is_emitter(hit.item) {
            return Rgb::BLACK;
        }
        let is_flat = self.surfaces.flat_normal(hit.item).is_some();
        let object = self.surfaces.item(hit.item).object;
        let shape = &self.surfaces.scene.objects[object as usize].shape;
        let is_exact = matches!(shape, Shape::Exact(_));
        let form = self.emitter_form(object, self.surfaces.material_id(hit.item), is_flat);
        if !is_exact && self.counts_direct(form, path.via) {
            return Rgb::BLACK;
        }
        let exitance = self.surfaces.emitted(hit, front) * PI;
        if path.density == 0.0 {
            return exitance;
        }
        let sampled = self.lights.pdf(&self.surfaces, &path.leg.ray, hit);
        exitance * mis_weight(path.density.into(), sampled)
    }

    /// Cost of the direct light of one point, in rays: a quarter for each formula (of a lamp, a light
    /// or an image of one), and the shadow rays.
    pub fn direct_cost(&self) -> f64 {
        let sources = self.sources.count() as f64;
        let tests = if self.many_lights() {
            RAYS_PER_FORMULA as f64
        } else {
            4.0 * sources
        };
        let pictured = if self.lights.has_pictures() { 4.0 } else { 0.0 };
        0.25 * sources + tests + pictured
    }

    /// Whether there are so many lamps that [`direct_over`](Gatherer::direct_over) finds the direct
    /// light of a surface better than point by point.
    pub fn many_lights(&self) -> bool {
        let curved = self.sources.curved(&self.lights);
        let lamps_alone = self.lights.delta.is_empty() && self.lights.outside.is_empty();
        let is_even = curved.is_empty() && !self.lights.has_pictures();
        self.sources.count() > MOST_TERMS && lamps_alone && is_even
    }

    /// Mean direct irradiance over a surface from flat lamps, straight and by one flat mirror.
    pub fn direct_over(&self, samples: &SurfaceSamples, seed: u32) -> DirectLight {
        self.direct_light().over(samples, seed)
    }

    /// Direct irradiance at points: lamps, lights, and both by way of one flat mirror, from
    /// `rays` shadow rays per replicate and source.
    pub fn direct(&self, points: &[GatherPoint], rays: u32, seed: u32) -> Vec<DirectLight> {
        self.direct_range(points, 0..rays, seed)
    }

    /// Direct irradiance at points of one small area, from one shadow ray per point, replicate and
    /// source. All rays to a source are of one sequence, so that their mean has less noise than that of
    /// as many points by themselves; points in the order of a grid would align with it.
    pub fn direct_at_near(&self, points: &[GatherPoint], seed: u32) -> Vec<DirectLight> {
        self.direct_light()
            .irradiance(points, ShadowRays::Shared, seed)
    }

    fn direct_range(
        &self,
        points: &[GatherPoint],
        rays: Range<u32>,
        seed: u32,
    ) -> Vec<DirectLight> {
        self.direct_light()
            .irradiance(points, ShadowRays::Own(rays), seed)
    }

    fn direct_light(&self) -> Direct<'_> {
        Direct::new(&self.surfaces, &self.lights, &self.sources)
    }

    /// Irradiance at points, direct and indirect.
    ///
    /// Runs on the calling thread; works best with some tens of points at a time. The result
    /// depends on the points' keys, the options and the batch, never on threads.
    pub fn gather(
        &self,
        points: &[GatherPoint],
        options: &GatherOptions,
        light: &impl DiffuseLight,
    ) -> Vec<Gathered> {
        let directions = DirectionTables::new(options);
        let irradiance = self.gather_with(points, options, &directions, light);
        irradiance.iter().map(SplitIrradiance::whole).collect()
    }

    /// The direct part alone of what [`gather_with`](Gatherer::gather_with) finds with the same
    /// options, for the same batch.
    pub fn gather_direct(&self, points: &[GatherPoint], options: &GatherOptions) -> Vec<Gathered> {
        let direct = self.direct_range(points, options.shadow_rays(), options.seed);
        direct.iter().map(DirectLight::whole).collect()
    }

    /// [`gather`](Gatherer::gather), with the direct part apart, and with directions that the caller
    /// makes once from the same options, for many batches.
    pub fn gather_with(
        &self,
        points: &[GatherPoint],
        options: &GatherOptions,
        directions: &DirectionTables,
        light: &impl DiffuseLight,
    ) -> Vec<SplitIrradiance> {
        let direct = self.direct_range(points, options.shadow_rays(), options.seed);
        let indirect = self.indirect(points, options, directions, light, &direct);
        let split = |(d, indirect): (&DirectLight, Gathered)| SplitIrradiance {
            direct: d.whole(),
            indirect,
        };
        direct.iter().zip(indirect).map(split).collect()
    }

    /// The indirect part alone, for as many directions; roulette differs.
    pub fn gather_indirect(
        &self,
        points: &[GatherPoint],
        options: &GatherOptions,
        directions: &DirectionTables,
        light: &impl DiffuseLight,
    ) -> Vec<Gathered> {
        // How bright a point is decides on roulette alone.
        let direct = if options.termination.is_random() && !light.is_unknown() {
            self.direct_range(points, 0..1, options.seed)
        } else {
            vec![DirectLight::default(); points.len()]
        };
        self.indirect(points, options, directions, light, &direct)
    }

    /// What paths find beside `direct` light.
    fn indirect(
        &self,
        points: &[GatherPoint],
        options: &GatherOptions,
        directions: &DirectionTables,
        light: &impl DiffuseLight,
        direct: &[DirectLight],
    ) -> Vec<Gathered> {
        let mut collector = Collector::new(self, light, points.len(), options.termination);
        let starts = self.hemispheres(points, directions, options.seed);
        // Where roulette knows nothing of the light, it needs not wait for what the first rays of all points find, and
        // the paths of a piece stay in the cache.
        let piece = if light.is_unknown() {
            PIECE
        } else {
            starts.len().max(1)
        };
        let (mut paths, mut scratch) = (Vec::new(), Scratch::default());
        for (number, starts) in (0..).zip(starts.chunks(piece)) {
            paths.clear();
            paths.extend_from_slice(starts);
            for round in 0..=options.termination.most_bounces() {
                // Rounds are fewer than 2^16.
                let round_key = number << 16 | round;
                let key = hash(&[options.seed, options.spent, round_key]);
                collector.follow(&mut paths, &mut scratch, key, round);
                if !collector.has_contacts() {
                    break;
                }
                if round == 0 {
                    collector.expect(direct, directions.count);
                }
                let key = hash(&[options.seed, options.spent, round_key, 1]);
                collector.contacts(points, &mut paths, key);
            }
        }
        let mean = |sums: &[[f64; 3]; REPLICATES]| Gathered {
            replicates: sums.map(|sum| Rgb::from(sum) / directions.count as f64),
        };
        collector.sums().iter().map(mean).collect()
    }

    /// Cosine-distributed rays of all points and replicates.
    fn hemispheres(
        &self,
        points: &[GatherPoint],
        directions: &DirectionTables,
        seed: u32,
    ) -> Vec<Path> {
        let tracer = self.surfaces.tracer;
        let mut paths = Vec::with_capacity(points.len() * REPLICATES * directions.count);
        for (index, point) in points.iter().enumerate() {
            let frame = Frame::from_normal(point.normal);
            let origin = tracer.leaving(point.position, point.normal);
            let [turn, table, ..] = seeds(&[seed, point.key]);
            let (sin, cos) = (TAU * f64::from(uniform(&[turn]))).sin_cos();
            // The kernel's rays are linear in their directions, so three of them serve all.
            let axis = |v: DVec3| tracer.kernel_ray(&Ray::new(origin, v));
            let x = axis(cos * frame.x + sin * frame.y).direction;
            let y = axis(cos * frame.y - sin * frame.x).direction;
            let z = axis(frame.z);
            for (k, d) in directions.table(table).iter().enumerate() {
                let direction =
                    [0, 1, 2].map(|k| d[0] * x[k] + d[1] * y[k] + d[2] * z.direction[k]);
                let id = (index * REPLICATES + k / directions.count) as u32;
                let ray = KernelRay { direction, ..z };
                paths.push(Path::new(ray, id, Rgb::WHITE));
            }
        }
        paths
    }
}
