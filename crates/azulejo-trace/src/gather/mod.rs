//! Irradiance at points: direct light by formula and shadow rays, the rest by rays over the
//! hemisphere that read the light of whatever diffuse surface they find, by way of mirrors and
//! glass too.
//!
//! Both passes end here: the first gathers at the vertices it writes, the second at the pixels
//! of a final gather; they differ in where the light of diffuse surfaces comes from
//! ([`DiffuseLight`]).

mod crowd;
mod direct;
mod emitters;
mod glints;
mod tiles;

use crate::follow::{Event, Path, Scratch, Via, follow};
use crate::lights::{Lights, mis_weight};
use crate::sampling::{cosine_hemisphere, hash, seeds, sobol, uniform};
use crate::{KernelHit, KernelRay, Surfaces};
use azulejo_scene::math::{Frame, Ray};
use azulejo_scene::{Rgb, Shape};
pub use crowd::Places;
pub(crate) use direct::unoccluded;
use direct::{Direct, MOST_TERMS};
use emitters::Emitters;
use glam::DVec3;
pub use glints::Glints;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Estimates of every quantity, from equal shares of its samples: their spread is its standard
/// error. Those of rows of form factors are independent; those of a gather are consecutive
/// stretches of one sequence (shadow rays: of one for each half of them), each well spread and
/// all together better still.
pub const REPLICATES: usize = 4;

/// A hit nearer than the patch it falls on is replaced by a gather of its own, at most this many
/// times in a row.
const MOST_CONTACTS: u32 = 6;

/// One shadow ray per source for so many rays over the hemisphere.
const SHADOW_SHARE: u32 = 4;

/// Shadow rays for each place at which [`Gatherer::direct_over`] evaluates formulas: a good number,
/// not a rule.
pub const RAYS_PER_FORMULA: usize = 16;

/// Where irradiance is asked for.
#[derive(Clone, Copy, Debug)]
pub struct GatherPoint {
    /// World position, on or off a surface.
    pub position: DVec3,
    /// Unit normal of the side that receives.
    pub normal: DVec3,
    /// Keys the random numbers: equal keys give equal samples.
    pub key: u32,
}

/// A diffuse surface at the end of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// The ray.
    pub ray: KernelRay,
    /// Where.
    pub hit: KernelHit,
    /// Which side.
    pub front: bool,
}

/// The light that leaves a diffuse surface, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Glow {
    /// Radiosity by diffuse reflection, without emission, W/m².
    pub radiosity: [f32; 3],
    /// Distance below which `radiosity` is too coarse to be seen from, such as the size of the
    /// patch; zero if it is exact.
    pub grain: f32,
}

/// What is known of the light that leaves diffuse surfaces.
pub trait DiffuseLight: Sync {
    /// The light at a hit. A solver that has independent estimates gives the one of
    /// `replicate`; others give the same to all.
    fn glow(&self, at: &Arrival, replicate: usize) -> Glow;

    /// Diffuse reflectance at the hit.
    fn reflectance(&self, at: &Arrival) -> Rgb;
}

/// Irradiance of one point as independent estimates, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    /// One estimate per replicate; the mean is the answer.
    pub replicates: [Rgb; REPLICATES],
}

impl Gathered {
    /// The estimate.
    pub fn mean(&self) -> Rgb {
        self.replicates.iter().copied().sum::<Rgb>() / REPLICATES as f64
    }

    /// Standard error of [`mean`](Gathered::mean), if the replicates are independent: two to either
    /// side hold the truth with the normal law's probability of 95.4%. The spread of four
    /// replicates is itself uncertain, and Student's t with three degrees of freedom says by how
    /// much (2 σ become 3.307 s).
    pub fn standard_error(&self) -> Rgb {
        self.variance().map(f64::sqrt) * (3.307 / 2.0)
    }

    /// The mean of two independent estimates, `share` of the other's.
    pub fn blend(&self, other: &Gathered, share: f64) -> Gathered {
        let of = |r: usize| self.replicates[r] * (1.0 - share) + other.replicates[r] * share;
        Gathered {
            replicates: std::array::from_fn(of),
        }
    }

    /// Variance of [`mean`](Gathered::mean), per channel, from the spread of the replicates as
    /// if they were independent; stretches of one sequence have a mean that is better than this.
    pub fn variance(&self) -> Rgb {
        let mean = self.mean();
        let square = |c: Rgb| c * c;
        let spread: Rgb = self.replicates.iter().map(|&r| square(r - mean)).sum();
        spread / (REPLICATES * (REPLICATES - 1)) as f64
    }
}

/// Direct irradiance of one point, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectLight {
    /// From lamps, one estimate per replicate.
    pub lamps: Gathered,
    /// From lights without area, exact.
    pub lights: Rgb,
}

/// How much work a gather spends.
#[derive(Clone, Copy, Debug)]
pub struct GatherOptions {
    /// Rays over the hemisphere per point, rounded up to a multiple of [`REPLICATES`]. Sobol
    /// points are best in powers of two.
    pub rays: u32,
    /// Rays per point that earlier gathers with the same seed have spent: this one goes on where
    /// they ended, and both together are one well spread set.
    pub spent: u32,
    /// Keys all random numbers, with each point's own key.
    pub seed: u32,
}

/// Gathers irradiance in a scene. Immutable; shared by all threads.
pub struct Gatherer<'a> {
    surfaces: Surfaces<'a>,
    emitters: Emitters<'a>,
    lights: Lights<'a>,
}

impl<'a> Gatherer<'a> {
    /// Collects the scene's lamps, mirrors and lights.
    pub fn new(surfaces: Surfaces<'a>) -> Gatherer<'a> {
        let emitters = Emitters::new(&surfaces);
        let lights = Lights::new(&surfaces);
        Gatherer {
            surfaces,
            emitters,
            lights,
        }
    }

    /// The scene, its tracer and its items.
    pub fn surfaces(&self) -> &Surfaces<'a> {
        &self.surfaces
    }

    /// Radiance of the surroundings, W/(sr·m²).
    pub fn ambient(&self) -> Rgb {
        self.emitters.ambient
    }

    /// Whether the light of an emitter is in the [`direct`](Gatherer::direct) light of what it
    /// reaches `via` this way: straight, or from flat emitters by way of one flat mirror.
    pub fn counts_direct(&self, is_flat: bool, via: Via) -> bool {
        self.emitters.counts_direct(is_flat, via)
    }

    /// Lamps and lights as targets of rays.
    pub fn lights(&self) -> &Lights<'a> {
        &self.lights
    }

    /// Whether glossy surfaces may show lights without area.
    pub fn shows_beams(&self) -> bool {
        let materials = &self.surfaces.scene.materials;
        self.lights.has_beams() && materials.iter().any(|m| m.glossy().is_some())
    }

    /// Exitance that a path finds at a hit beyond what [`direct`](Gatherer::direct) counts
    /// already: zero for most. Exact shapes are no lamps of the direct light: all that they emit
    /// is found here. What a glossy surface sent the path to is also found by [`Glints`], and
    /// counts in part.
    pub fn stray_exitance(&self, path: &Path, hit: &KernelHit, front: bool) -> Rgb {
        if !self.surfaces.is_emitter(hit.item) {
            return Rgb::BLACK;
        }
        let is_flat = self.surfaces.flat_normal(hit.item).is_some();
        let object = self.surfaces.item(hit.item).object as usize;
        let is_exact = matches!(self.surfaces.scene.objects[object].shape, Shape::Exact(_));
        if !is_exact && self.counts_direct(is_flat, path.via) {
            return Rgb::BLACK;
        }
        let exitance = self.surfaces.material(hit.item).emission_from(front) * PI;
        if path.density == 0.0 {
            return exitance;
        }
        let looked_for = self.lights.pdf(&self.surfaces, &path.ray, hit);
        exitance * mis_weight(path.density.into(), looked_for)
    }

    /// What the direct light of one point costs, in rays: a fourth for every lamp, light and image
    /// of one that a formula must be evaluated for, and those that test what is visible.
    pub fn direct_cost(&self) -> f64 {
        let sources = self.emitters.sources() as f64;
        let tests = match self.lights_crowd() {
            true => RAYS_PER_FORMULA as f64,
            false => 4.0 * sources,
        };
        0.25 * sources + tests
    }

    /// Whether there are so many lamps that the direct light of a surface is better found by
    /// [`direct_over`](Gatherer::direct_over) than point by point.
    pub fn lights_crowd(&self) -> bool {
        let emitters = &self.emitters;
        emitters.sources() > MOST_TERMS && emitters.lights.is_empty() && emitters.globes.is_empty()
    }

    /// Mean direct irradiance over a surface of flat lamps, straight and by one flat mirror.
    pub fn direct_over(&self, places: &Places, seed: u32) -> DirectLight {
        Direct::new(&self.surfaces, &self.emitters).over(places, seed)
    }

    /// Direct irradiance at points: lamps, lights, and both by way of one flat mirror, from
    /// `rays` shadow rays per replicate and source.
    pub fn direct(&self, points: &[GatherPoint], rays: u32, seed: u32) -> Vec<DirectLight> {
        self.direct_range(points, 0..rays, seed)
    }

    fn direct_range(
        &self,
        points: &[GatherPoint],
        rays: Range<u32>,
        seed: u32,
    ) -> Vec<DirectLight> {
        Direct::new(&self.surfaces, &self.emitters).irradiance(points, rays, seed)
    }

    /// Irradiance at points, direct and indirect.
    ///
    /// Runs on the calling thread; give it some tens of points at a time. The result depends on
    /// the points' keys, the options and the batch, never on threads.
    pub fn gather(
        &self,
        points: &[GatherPoint],
        options: &GatherOptions,
        light: &impl DiffuseLight,
    ) -> Vec<Gathered> {
        self.gather_with(points, options, &DirectionTables::new(options), light)
    }

    /// [`gather`](Gatherer::gather) with directions made beforehand from the same options, for
    /// callers with many batches.
    pub fn gather_with(
        &self,
        points: &[GatherPoint],
        options: &GatherOptions,
        directions: &DirectionTables,
        light: &impl DiffuseLight,
    ) -> Vec<Gathered> {
        let per_replicate = directions.count as u32;
        let first = (options.spent / REPLICATES as u32).div_ceil(SHADOW_SHARE);
        let shadow_rays = first..first + per_replicate.div_ceil(SHADOW_SHARE);
        let direct = self.direct_range(points, shadow_rays, options.seed);
        let mut collector = Collector {
            gatherer: self,
            light,
            sums: vec![[[0.0; 3]; REPLICATES]; points.len()],
            near: Vec::new(),
            glints: Glints::default(),
        };
        let mut paths = self.hemispheres(points, directions, options.seed);
        let mut scratch = Scratch::default();
        for round in 0..=MOST_CONTACTS {
            collector.follow(
                &mut paths,
                &mut scratch,
                hash(&[options.seed, options.spent, round]),
                round < MOST_CONTACTS,
            );
            if collector.near.is_empty() {
                break;
            }
            collector.contacts(
                points,
                &mut paths,
                hash(&[options.seed, options.spent, round, 1]),
            );
        }
        let total = |(d, sums): (&DirectLight, &[[f64; 3]; REPLICATES])| {
            let of = |r: usize| {
                d.lamps.replicates[r] + d.lights + Rgb::from(sums[r]) / f64::from(per_replicate)
            };
            Gathered {
                replicates: std::array::from_fn(of),
            }
        };
        direct.iter().zip(&collector.sums).map(total).collect()
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
                paths.push(Path {
                    ray,
                    id,
                    weight: Rgb::WHITE,
                    via: Via::Direct,
                    depth: 0,
                    density: 0.0,
                });
            }
        }
        paths
    }
}

/// Cosine-distributed directions about +z, in several scramblings of one stretch of the Sobol
/// sequence. A point takes one of them, turned about its normal by an angle of its own: as well
/// spread as a scrambling of its own, and several times cheaper.
pub struct DirectionTables {
    /// Directions per replicate.
    count: usize,
    directions: Vec<[f32; 3]>,
}

/// Scramblings to choose from.
const TABLES: u32 = 32;

impl DirectionTables {
    /// The directions that a gather with these options takes.
    pub fn new(options: &GatherOptions) -> DirectionTables {
        let count = options.rays.div_ceil(REPLICATES as u32).max(1);
        let indices = options.spent..options.spent + count * REPLICATES as u32;
        let mut directions = Vec::with_capacity(TABLES as usize * indices.len());
        for table in 0..TABLES {
            let [s1, s2, ..] = seeds(&[options.seed, table, 0x9a7]);
            for k in indices.clone() {
                let d = cosine_hemisphere(sobol(k, 0, s1).into(), sobol(k, 1, s2).into());
                directions.push(d.as_vec3().to_array());
            }
        }
        DirectionTables {
            count: count as usize,
            directions,
        }
    }

    /// One table: a stretch of directions for each replicate, one after the other.
    fn table(&self, choice: u32) -> &[[f32; 3]] {
        let all = self.count * REPLICATES;
        let start = (choice % TABLES) as usize * all;
        &self.directions[start..start + all]
    }
}

/// A hit too near to be read from its patch.
struct Contact {
    id: u32,
    weight: Rgb,
    at: Arrival,
}

/// Sums what paths find.
struct Collector<'g, 'a, L> {
    gatherer: &'g Gatherer<'a>,
    light: &'g L,
    sums: Vec<[[f64; 3]; REPLICATES]>,
    near: Vec<Contact>,
    glints: Glints,
}

impl<L: DiffuseLight> Collector<'_, '_, L> {
    /// Follows `paths` and reads the light where they end; hits that are too near are kept for
    /// [`contacts`](Collector::contacts) if those are `allowed`.
    fn follow(&mut self, paths: &mut Vec<Path>, scratch: &mut Scratch, seed: u32, allowed: bool) {
        let (gatherer, light) = (self.gatherer, self.light);
        let ambient = gatherer.ambient() * PI;
        let (sums, near, glints) = (&mut self.sums, &mut self.near, &mut self.glints);
        follow(&gatherer.surfaces, paths, scratch, seed, |path, event| {
            let (point, replicate) = (path.id as usize / REPLICATES, path.id as usize % REPLICATES);
            let found = match event {
                Event::Escape => ambient,
                Event::Cut | Event::Absorbed => return,
                Event::Surface { hit, front } => {
                    glints.add(gatherer, path, &hit, path.id, seed);
                    let ray = path.ray;
                    let at = Arrival { ray, hit, front };
                    let glow = light.glow(&at, replicate);
                    let stray = gatherer.stray_exitance(path, &hit, front);
                    if allowed && path.depth == 0 && hit.t < glow.grain {
                        near.push(Contact {
                            id: path.id,
                            weight: path.weight,
                            at,
                        });
                        stray
                    } else {
                        stray + Rgb::from(glow.radiosity.map(f64::from))
                    }
                }
            };
            let sum = &mut sums[point][replicate];
            (0..3).for_each(|k| sum[k] += path.weight[k] * found[k]);
        });
        glints.settle(gatherer, |id, found| {
            let sum = &mut sums[id as usize / REPLICATES][id as usize % REPLICATES];
            (0..3).for_each(|k| sum[k] += found[k]);
        });
    }

    /// Replaces the light of near hits by a gather of their own: a glimpse of the direct light,
    /// and one ray that goes on. Fills `paths`.
    fn contacts(&mut self, places: &[GatherPoint], paths: &mut Vec<Path>, seed: u32) {
        let gatherer = self.gatherer;
        let tracer = gatherer.surfaces.tracer;
        let contacts = std::mem::take(&mut self.near);
        let mut points = Vec::with_capacity(contacts.len());
        paths.clear();
        for (index, contact) in contacts.iter().enumerate() {
            let found = tracer.resolve(&tracer.world_ray(&contact.at.ray), &contact.at.hit);
            let normal = if contact.at.front {
                found.normal
            } else {
                -found.normal
            };
            let weight = contact.weight * self.light.reflectance(&contact.at);
            let key = hash(&[places[contact.id as usize / REPLICATES].key, index as u32]);
            points.push((
                GatherPoint {
                    position: found.position,
                    normal,
                    key,
                },
                weight,
            ));
            let [u1, u2] = [0, 1].map(|d| f64::from(uniform(&[seed, key, contact.id, d])));
            let direction = Frame::from_normal(normal).to_world(cosine_hemisphere(u1, u2));
            let ray =
                tracer.kernel_ray(&Ray::new(tracer.leaving(found.position, normal), direction));
            if weight.max_channel() > 0.0 {
                paths.push(Path {
                    ray,
                    id: contact.id,
                    weight,
                    via: Via::Direct,
                    depth: 0,
                    density: 0.0,
                });
            }
        }
        let places: Vec<GatherPoint> = points.iter().map(|(p, _)| *p).collect();
        let glimpses =
            Direct::new(&gatherer.surfaces, &gatherer.emitters).glimpse(&places, seed ^ 0x51);
        for ((contact, (_, weight)), e) in contacts.iter().zip(&points).zip(glimpses) {
            let sum =
                &mut self.sums[contact.id as usize / REPLICATES][contact.id as usize % REPLICATES];
            (0..3).for_each(|k| sum[k] += weight[k] * e[k]);
        }
    }
}
