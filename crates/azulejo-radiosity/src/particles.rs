//! Particle tracing: power followed from the light sources through the scene, and its density
//! estimated on the surfaces.
//!
//! Particles leave the emitters and lights in proportion to their power, pass mirrors, glass and
//! glossy surfaces as every other ray does, are counted at each surface that they reach, and are
//! reflected diffusely or absorbed there by chance. What reaches a side of a patch, over its area,
//! is the irradiance H of that side, and R = ρ H: the density estimate with one cell per patch, a
//! histogram (Arvo, *Backward ray tracing*, SIGGRAPH course 1986; Heckbert, *Adaptive radiosity
//! textures for bidirectional ray tracing*, SIGGRAPH 1990). It has no bias but that of the division
//! into patches; kernels and regressions over several hits trade less noise for bias (Jensen, *Global
//! illumination using photon maps*, EGWR 1996; Walter, Hubbard, Shirley and Greenberg, *Global
//! illumination using local linear density estimation*, ACM Trans. Graphics 16, 1997; Lastra, Ureña,
//! Revelles and Montes, *A particle-path based method for Monte-Carlo density estimation*, EGWR
//! 2002).
//!
//! Particles are the only engine that starts at the lights: it finds caustics of small lamps, which
//! rays from the patches meet by chance, and its work does not grow with the patches; but dark
//! corners get few particles. Four independent replicates give the standard error.

use crate::system::{Convergence, EnergyBalance, RadiositySolution, standard_error};
use azulejo_factors::Patches;
use azulejo_factors::rays::{HitPatches, RowSampler};
use azulejo_factors::row::{Side, side};
use azulejo_scene::math::{Frame, Ray};
use azulejo_scene::{LightKind, Rgb};
use azulejo_trace::follow::{Event, Path, Scratch, Via, follow};
use azulejo_trace::interaction::SurfaceInteraction;
use azulejo_trace::sampling::{concentric_disk, cosine_about, hash, seeds, sobol, uniform};
use azulejo_trace::{Cancelled, Gatherer, Measure, Progress, REPLICATES};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Particles of a batch, which one thread follows to their ends.
const BATCH: u32 = 4096;

/// Batches between two sums of their results: limits the memory.
const WAVE: usize = 64;

/// Particles end after this many diffuse reflections: where nothing is absorbed they never would.
const MOST_REFLECTIONS: u32 = 1000;

/// Most particles of a replicate, by which points of the sources are tabulated.
const MOST_PARTICLES: u64 = 1 << 24;

/// How many particles to follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleEffort {
    /// Particles per patch of the first round, all replicates together.
    pub first: u32,
    /// Relative RMS error of R at which to stop ([`RadiositySolution::error`]); `None` stops after
    /// the first round.
    pub error: Option<f64>,
    /// Most particles per patch.
    pub most: u32,
}

/// Solves for R by particles. Rounds double the number of particles until the error is reached.
/// Follows the light of `bounces` diffuse reflections, the last one not shot on.
///
/// # Errors
/// [`Cancelled`].
pub fn solve(
    gatherer: &Gatherer,
    patches: &Patches,
    reflectance: &[Rgb],
    effort: ParticleEffort,
    bounces: Option<u32>,
    seed: u32,
    progress: &Progress,
) -> Result<RadiositySolution, Cancelled> {
    let tracing = ParticleTracing {
        gatherer,
        patches,
        reflectance,
        hit_patches: HitPatches::new(gatherer.surfaces(), patches),
        sources: sources(gatherer, patches),
        most: bounces.unwrap_or(MOST_REFLECTIONS),
        is_limited: bounces.is_some(),
    };
    let per_patch = |n: u32| {
        let all = u64::from(n.max(1)) * patches.len() as u64;
        (all / REPLICATES as u64).clamp(1, MOST_PARTICLES)
    };
    let (mut count, most) = (per_patch(effort.first), per_patch(effort.most));
    let mut sums = vec![ReplicateSums::new(2 * patches.len()); REPLICATES];
    for round in 0.. {
        for (r, sums) in (0u32..).zip(&mut sums) {
            let key = hash(&[seed, r, round]);
            tracing.shoot(count as u32, key, sums, progress)?;
        }
        let solution = tracing.solution(&sums);
        let reached = solution.error(patches);
        progress.measured(Measure::PatchError(reached));
        // The particles so far are as many as those of the next round.
        count = sums[0].count;
        let is_enough = effort.error.is_none_or(|goal| reached <= goal);
        if is_enough || 2 * count > most || progress.out_of_time() {
            return Ok(solution);
        }
    }
    Ok(tracing.solution(&sums))
}

/// A source of particles, with its power.
struct ParticleSource {
    kind: SourceKind,
    /// Per channel, W: of lights from outside, what passes the ball around the scene.
    power: Rgb,
}

enum SourceKind {
    /// A side of a patch that emits.
    Surface(Side),
    /// A point or spot light.
    Point(LightKind),
    /// A directional light, and half the angle that it subtends.
    Parallel(DVec3, f64),
    /// The same radiance from everywhere.
    Ambient,
    /// All environments.
    Environments,
}

/// All sources of a scene, the surfaces first, in their order.
fn sources(gatherer: &Gatherer, patches: &Patches) -> Vec<ParticleSource> {
    let scene = gatherer.surfaces().scene;
    let surface = |s: Side| {
        let patch = (s / 2) as usize;
        let material = &scene.materials[patches.material(patch) as usize];
        ParticleSource {
            power: patches.emission(patch, material, s.is_multiple_of(2))
                * (PI * patches.area(patch)),
            kind: SourceKind::Surface(s),
        }
    };
    let radius = ball(gatherer).1;
    let light = |kind: &LightKind| match *kind {
        LightKind::Point { intensity, .. } => ParticleSource {
            power: intensity * (4.0 * PI),
            kind: SourceKind::Point(kind.clone()),
        },
        LightKind::Luminaire { scale, ref web, .. } => ParticleSource {
            power: scale * web.sphere_integral(),
            kind: SourceKind::Point(kind.clone()),
        },
        LightKind::Spot {
            intensity, outer, ..
        } => ParticleSource {
            // More than it emits: particles between the full cone and its edge are lighter.
            power: intensity * (TAU * (1.0 - outer.cos())),
            kind: SourceKind::Point(kind.clone()),
        },
        LightKind::Directional {
            direction,
            irradiance,
            half_angle,
        } => ParticleSource {
            power: irradiance * (PI * radius * radius),
            kind: SourceKind::Parallel(direction, half_angle),
        },
        // They are two sources, below.
        LightKind::Ambient { .. } | LightKind::Environment(_) => ParticleSource {
            power: Rgb::BLACK,
            kind: SourceKind::Environments,
        },
    };
    let ambient = ParticleSource {
        // Irradiance πL on the inside of the ball.
        power: gatherer.ambient() * (PI * 4.0 * PI * radius * radius),
        kind: SourceKind::Ambient,
    };
    let environments = ParticleSource {
        power: gatherer.lights().outside().total() * (PI * radius * radius),
        kind: SourceKind::Environments,
    };
    let surfaces = (0..2 * patches.len() as Side).map(surface);
    let lights = scene.lights.iter().map(|l| light(&l.kind));
    let all = surfaces.chain(lights).chain([ambient, environments]);
    all.filter(|s| s.power.max_channel() > 0.0).collect()
}

/// Centre and radius of a ball around the scene.
fn ball(gatherer: &Gatherer) -> (DVec3, f64) {
    let bounds = gatherer.surfaces().tracer.bounds();
    (bounds.centre(), 0.5 * bounds.diagonal() * 1.001)
}

/// Some particles of one source.
struct ParticleShot {
    source: usize,
    range: Range<u32>,
    /// What each carries, W.
    weight: Rgb,
}

/// The sums of one replicate, over all rounds.
#[derive(Clone)]
struct ReplicateSums {
    /// Power that arrived at each side, times the particles of its round.
    arrived: Vec<Rgb>,
    balance: EnergyBalance,
    /// Particles so far.
    count: u64,
    /// Longest chain of diffuse reflections.
    reflections: u32,
}

impl ReplicateSums {
    fn new(sides: usize) -> ReplicateSums {
        ReplicateSums {
            arrived: vec![Rgb::BLACK; sides],
            balance: EnergyBalance::default(),
            count: 0,
            reflections: 0,
        }
    }
}

/// What a batch found.
#[derive(Default)]
struct BatchDeposits {
    /// Power that arrived at diffuse sides, W.
    deposits: Vec<(Side, Rgb)>,
    balance: EnergyBalance,
    reflections: u32,
}

struct ParticleTracing<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    reflectance: &'a [Rgb],
    hit_patches: HitPatches<'a>,
    sources: Vec<ParticleSource>,
    /// Most diffuse reflections of a particle.
    most: u32,
    /// Whether that is a wish, and what is left over is not a loss.
    is_limited: bool,
}

impl ParticleTracing<'_> {
    /// Adds a round of `count` particles to a replicate.
    fn shoot(
        &self,
        count: u32,
        key: u32,
        sums: &mut ReplicateSums,
        progress: &Progress,
    ) -> Result<(), Cancelled> {
        let shots = self.share_out(count, uniform(&[key]).into());
        let longest = shots.iter().map(|s| s.range.end).max().unwrap_or(0);
        let tracer = self.gatherer.surfaces().tracer;
        let sampler = RowSampler::new(tracer, self.patches, longest as usize, key);
        let batches: Vec<&[ParticleShot]> = batches(&shots).collect();
        progress.begin("particles", count.into());
        let share = f64::from(count);
        for wave in batches.chunks(WAVE) {
            let deposits: Vec<BatchDeposits> = wave
                .par_iter()
                .map_init(Scratch::default, |scratch, batch| {
                    let particles = batch.iter().map(|s| s.range.len() as u64).sum();
                    progress.advance(particles)?;
                    Ok(self.follow_batch(batch, &sampler, key, scratch))
                })
                .collect::<Result<_, Cancelled>>()?;
            for batch in deposits {
                sums.balance.add(&batch.balance, share);
                sums.reflections = sums.reflections.max(batch.reflections);
                for (s, power) in batch.deposits {
                    sums.arrived[s as usize] += power * share;
                }
            }
        }
        sums.count += u64::from(count);
        Ok(())
    }

    /// Particles of each source: stratified over the power of all, so that each gets its share to
    /// within one particle.
    fn share_out(&self, count: u32, offset: f64) -> Vec<ParticleShot> {
        let strength = |s: &ParticleSource| s.power.max_channel();
        let total: f64 = self.sources.iter().map(strength).sum();
        let (mut sum, mut before, mut shots) = (0.0, 0.0, Vec::new());
        for (source, s) in self.sources.iter().enumerate() {
            sum += strength(s);
            let reached = (sum / total * f64::from(count) + offset).floor();
            let particles = (reached - before) as u32;
            before = reached;
            let weight = s.power * (total / (strength(s) * f64::from(count)));
            for first in (0..particles).step_by(BATCH as usize) {
                shots.push(ParticleShot {
                    source,
                    range: first..(first + BATCH).min(particles),
                    weight,
                });
            }
        }
        shots
    }

    /// Follows the particles of a batch through all reflections.
    fn follow_batch(
        &self,
        batch: &[ParticleShot],
        sampler: &RowSampler,
        key: u32,
        scratch: &mut Scratch,
    ) -> BatchDeposits {
        let mut deposits = BatchDeposits::default();
        let mut paths = Vec::new();
        for shot in batch {
            self.start(shot, sampler, key, &mut paths, &mut deposits);
        }
        let first = batch
            .first()
            .map_or([0; 2], |s| [s.source as u32, s.range.start]);
        let key = hash(&[key, first[0], first[1]]);
        let weights = paths.iter().map(|p| p.weight.max_channel());
        let unit = weights.fold(f64::MIN_POSITIVE, f64::max);
        let mut reflections = 0;
        while !paths.is_empty() {
            deposits.reflections = deposits.reflections.max(reflections + 1);
            paths = self.generation(
                paths,
                hash(&[key, reflections]),
                reflections,
                unit,
                scratch,
                &mut deposits,
            );
            reflections += 1;
        }
        deposits
    }

    /// Starts particles, and counts their power as emitted.
    fn start(
        &self,
        shot: &ParticleShot,
        sampler: &RowSampler,
        key: u32,
        paths: &mut Vec<Path>,
        deposits: &mut BatchDeposits,
    ) {
        let ParticleShot {
            source,
            range,
            weight,
        } = shot;
        let begin = paths.len();
        if let SourceKind::Surface(s) = self.sources[*source].kind {
            let range = range.start as usize..range.end as usize;
            sampler.fill(s, 0, range, 1.0, paths);
        } else {
            let scrambling = seeds(&[key, *source as u32, 0x70]);
            paths.extend(
                range
                    .clone()
                    .map(|k| self.light_particle(*source, k, scrambling)),
            );
        }
        for path in &mut paths[begin..] {
            path.weight *= *weight;
            // Marks particles of lights, whose power counts only if it reaches a surface.
            path.id = u32::from(!matches!(
                self.sources[*source].kind,
                SourceKind::Surface(_)
            ));
            deposits.balance.emitted += path.weight;
        }
    }

    /// Particle `k` of a light without area: of weight 1 on average, or 1 at most and less where the source has more power
    /// than it emits.
    fn light_particle(&self, source: usize, k: u32, scrambling: [u32; 4]) -> Path {
        let u: [f64; 4] = std::array::from_fn(|d| f64::from(sobol(k, d, scrambling[d])));
        let (centre, radius) = ball(self.gatherer);
        let mut weight = Rgb::WHITE;
        let (origin, direction) = match self.sources[source].kind {
            SourceKind::Point(LightKind::Luminaire {
                position,
                world_from_web,
                ref web,
                ..
            }) => match web.sample([u[0], u[1]]) {
                Some((direction, density)) => {
                    let expected = density * web.sphere_integral();
                    weight = Rgb::grey(web.toward(direction) / expected);
                    (position, world_from_web * direction)
                }
                // It has no power.
                None => (position, world_from_web * DVec3::NEG_Z),
            },
            SourceKind::Point(ref light) => {
                let (position, axis, lowest) = match *light {
                    LightKind::Spot {
                        position,
                        direction,
                        outer,
                        ..
                    } => (position, direction, outer.cos()),
                    LightKind::Point { position, .. } => (position, DVec3::Z, -1.0),
                    _ => (centre, DVec3::Z, -1.0),
                };
                let direction = on_cap(axis, lowest, [u[0], u[1]]);
                let full = light.intensity_toward(axis).max_channel();
                weight = Rgb::grey(light.intensity_toward(direction).max_channel() / full);
                (position, direction)
            }
            SourceKind::Parallel(axis, half_angle) => {
                let (x, y) = concentric_disk(u[2], u[3]);
                let (x, y) = (x * half_angle.sin(), y * half_angle.sin());
                let z = (1.0 - x * x - y * y).sqrt();
                let direction = Frame::from_normal(axis).to_world(DVec3::new(x, y, z));
                // The light is as strong on a surface that faces the centre of its disc.
                weight = Rgb::grey(1.0 / z);
                parallel([u[0], u[1]], direction, (centre, radius))
            }
            SourceKind::Environments => {
                let outside = self.gatherer.lights().outside();
                let choice = f64::from(uniform(&[scrambling[0], k, 1]));
                let (toward, pdf) = outside
                    .sample_environment([choice, u[2], u[3]])
                    .expect("a source of particles has power");
                let share = outside.environment(toward) / pdf;
                let total = outside.total();
                let of = |c: usize| {
                    if total[c] > 0.0 {
                        share[c] / total[c]
                    } else {
                        0.0
                    }
                };
                weight = Rgb::new(of(0), of(1), of(2));
                parallel([u[0], u[1]], -toward, (centre, radius))
            }
            SourceKind::Ambient | SourceKind::Surface(_) => {
                let out = on_cap(DVec3::Z, -1.0, [u[0], u[1]]);
                let frame = Frame::from_normal(-out);
                (centre + radius * out, cosine_about(&frame, u[2], u[3]))
            }
        };
        let tracer = self.gatherer.surfaces().tracer;
        Path::new(tracer.kernel_ray(&Ray::new(origin, direction)), 0, weight)
    }

    /// Follows particles to the surfaces that they reach; returns those that are reflected
    /// diffusely there. Survivors carry `unit`, what the heaviest of the batch began with.
    fn generation(
        &self,
        mut paths: Vec<Path>,
        key: u32,
        reflections: u32,
        unit: f64,
        scratch: &mut Scratch,
        deposits: &mut BatchDeposits,
    ) -> Vec<Path> {
        let surfaces = self.gatherer.surfaces();
        let mut next: Vec<Path> = Vec::new();
        let mut reached = 0;
        follow(surfaces, &mut paths, scratch, key, |path, event| {
            let balance = &mut deposits.balance;
            let weight = path.weight;
            let (hit, front) = match event {
                Event::Escape if path.id == 1 && path.via == Via::Direct => {
                    return balance.emitted += weight * -1.0;
                }
                Event::Escape => return balance.escaped += weight,
                Event::Cut => return balance.cut += weight,
                Event::Absorbed => return balance.absorbed += weight,
                Event::Surface { hit, front } => (hit, front),
            };
            let material = surfaces.material(hit.item);
            if material.dielectric.is_none() {
                balance.absorbed += weight * (Rgb::WHITE - material.mirror - material.diffuse);
            }
            if material.diffuse.is_black() {
                return;
            }
            let patch = self.hit_patches.at(&hit);
            let reflectance = self.reflectance[patch as usize];
            deposits.deposits.push((side(patch, front), weight));
            // What vertex colours and textures absorb.
            balance.absorbed += weight * (material.diffuse - reflectance);
            reached += 1;
            let reflected = weight * reflectance;
            if reflections + 1 >= self.most {
                if !self.is_limited {
                    balance.cut += reflected;
                }
                return;
            }
            let key = hash(&[key, reached]);
            // A mirror sends a part on besides: odds by the weight alone would let particles multiply.
            let odds = (reflected.max_channel() / unit).min(1.0);
            let survives = f64::from(uniform(&[key, 0])) < odds;
            let carried = if survives {
                reflected / odds
            } else {
                Rgb::BLACK
            };
            // By chance: nothing on average.
            balance.absorbed += reflected - carried;
            if survives {
                let at = SurfaceInteraction::new(surfaces.tracer, &path.leg.ray, &hit);
                let u = [1, 2].map(|d| f64::from(uniform(&[key, d])));
                let direction = cosine_about(&Frame::from_normal(at.facing), u[0], u[1]);
                next.push(Path::new(
                    surfaces
                        .tracer
                        .kernel_ray(&Ray::new(at.origin(surfaces.tracer), direction)),
                    0,
                    carried,
                ));
            }
        });
        next
    }

    /// The solution of all replicates.
    fn solution(&self, sums: &[ReplicateSums]) -> RadiositySolution {
        let mut radiosity = RadiositySolution::new(2 * self.patches.len());
        for sums in sums {
            let share = 1.0 / sums.count.max(1) as f64;
            let irradiance =
                |(s, power): (usize, &Rgb)| *power * (share / self.patches.area(s / 2));
            let incident: Vec<Rgb> = sums.arrived.iter().enumerate().map(irradiance).collect();
            let reflected = |(s, h): (usize, &Rgb)| *h * self.reflectance[s / 2];
            let solution = incident.iter().enumerate().map(reflected).collect();
            radiosity
                .balance
                .add(&sums.balance, share / REPLICATES as f64);
            radiosity.rays += sums.count;
            let state = Convergence {
                iterations: sums.reflections,
                residual: 0.0,
                is_reached: true,
                ..Convergence::default()
            };
            radiosity.add_replicate(solution, &incident, state);
        }
        let missing: Vec<f64> = sums.iter().map(|s| s.balance.missing()).collect();
        radiosity.balance_error = standard_error(&missing);
        radiosity
    }
}

/// Where a ray of that direction starts, on a disc across it that covers the ball, uniformly.
fn parallel(u: [f64; 2], direction: DVec3, (centre, radius): (DVec3, f64)) -> (DVec3, DVec3) {
    let frame = Frame::from_normal(direction);
    let (x, y) = concentric_disk(u[0], u[1]);
    let across = radius * (x * frame.x + y * frame.y);
    (centre + across - radius * direction, direction)
}

/// A direction of the cap of the sphere about `axis` down to the cosine `lowest`, uniformly.
fn on_cap(axis: DVec3, lowest: f64, [u, v]: [f64; 2]) -> DVec3 {
    let frame = Frame::from_normal(axis);
    let z = 1.0 - u * (1.0 - lowest);
    let (sin, cos) = (TAU * v).sin_cos();
    let across = (1.0 - z * z).max(0.0).sqrt();
    across * (cos * frame.x + sin * frame.y) + z * frame.z
}

/// Shots in groups of about [`BATCH`] particles.
fn batches(shots: &[ParticleShot]) -> impl Iterator<Item = &[ParticleShot]> {
    let mut rest = shots;
    std::iter::from_fn(move || {
        let mut sum = 0;
        let end = rest.iter().position(|s| {
            sum += s.range.len();
            sum >= BATCH as usize
        });
        let (head, tail) = rest.split_at(end.map_or(rest.len(), |e| e + 1));
        rest = tail;
        (!head.is_empty()).then_some(head)
    })
}
