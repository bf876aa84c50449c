//! Stochastic Jacobi: radiosity without a matrix, for scenes whose rows would not fit.
//!
//! Each iteration shoots the power that arrived in the one before, by a number of rays in
//! proportion to it, so that all iterations together cost little more than the first. Neumann,
//! *Monte Carlo radiosity*, Computing 55, 1995; Bekaert, *Hierarchical and stochastic algorithms
//! for radiosity*, 1999, section 6.

use crate::system::{Convergence, EnergyBalance, RadiositySolution, standard_error};
use azulejo_factors::Patches;
use azulejo_factors::row::{Side, side};
use azulejo_scene::Rgb;
use azulejo_scene::math::{Frame, Ray};
use azulejo_trace::follow::{Event, Path, Scratch, follow};
use azulejo_trace::sampling::{cosine_about, hash, seeds, sobol, uniform};
use azulejo_trace::{
    Cancelled, DirectLight, EmitterForm, GatherPoint, Gatherer, NextEvent, Progress, REPLICATES,
};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Iteration ends when less than this share of the first iteration's power is left.
const REST: f64 = 1e-4;

/// Iteration ends, unconverged, after this many times the first iteration's power: where nothing is
/// absorbed it would not end.
const MOST_SHOTS: f64 = 100.0;

/// Rays traced between two merges of their results: limits the memory.
const BLOCK: usize = 1 << 18;

/// Rays per batch of a thread.
const BATCH: usize = 4096;

/// Rays per replicate and side that sample the surroundings.
const AMBIENT_RAYS: u32 = 16;

/// What is being shot, which determines what counts at the receiver.
#[derive(Clone, Copy, PartialEq)]
enum ShotKind {
    /// Emission: counts only where formulas do not count it.
    Emission,
    /// Diffusely reflected light: counts everywhere.
    Reflected,
}

/// The result of a batch of rays.
#[derive(Default)]
struct BatchResult {
    /// Power that reached diffuse sides, W.
    deposits: Vec<(Side, Rgb)>,
    balance: EnergyBalance,
}

/// Solves for R with about `rays` rays per patch in all replicates together; `None` if the phase of
/// the progress is over before.
///
/// # Errors
/// [`Cancelled`].
pub fn solve(
    gatherer: &Gatherer,
    patches: &Patches,
    reflectance: &[Rgb],
    rays: u32,
    bounces: Option<u32>,
    seed: u32,
    progress: &Progress,
) -> Result<Option<RadiositySolution>, Cancelled> {
    let shooter = Shooter {
        gatherer,
        patches,
        reflectance,
        seed,
    };
    let Some(direct) = shooter.direct(progress)? else {
        return Ok(None);
    };
    // Divide the rays among independent replicates, whose spread gives the error.
    let budget = u64::from(rays) * patches.len() as u64 / REPLICATES as u64;
    let mut radiosity = RadiositySolution::new(2 * patches.len());
    let mut missing = Vec::new();
    for r in 0..REPLICATES {
        let before = radiosity.balance;
        let mut incident: Vec<Rgb> = direct.iter().map(|d| d.0[r]).collect();
        let mut solution = vec![Rgb::BLACK; incident.len()];
        let share = 1.0 / REPLICATES as f64;
        // Of light that no patch emitted, the first surface absorbs what it does not reflect.
        for (s, (_, external)) in direct.iter().enumerate() {
            let (area, rho) = (patches.area(s / 2), reflectance[s / 2]);
            radiosity.balance.emitted += *external * (area * share);
            radiosity.balance.absorbed += *external * (Rgb::WHITE - rho) * (area * share);
        }
        // Shoot the emission, of which only what the direct light leaves out counts.
        let exitance: Vec<Rgb> = (0..incident.len())
            .map(|s| shooter.exitance(s as Side))
            .collect();
        radiosity.balance.emitted += shooter.total(&exitance) * share;
        let stray = shooter.shoot(
            &exitance,
            budget,
            ShotKind::Emission,
            r as u32,
            0,
            &mut radiosity,
            progress,
        )?;
        let Some(stray) = stray else {
            return Ok(None);
        };
        incident.iter_mut().zip(&stray).for_each(|(h, s)| *h += *s);
        let mut unshot: Vec<Rgb> = (0..incident.len())
            .map(|s| incident[s] * reflectance[s / 2])
            .collect();
        let first = shooter.total(&unshot).max_channel();
        let mut state = Convergence {
            iterations: 1,
            ..Convergence::default()
        };
        let mut shots = 0.0;
        // Follow one bounce an iteration, by rays in proportion to the power that was reflected last.
        loop {
            solution.iter_mut().zip(&unshot).for_each(|(x, u)| *x += *u);
            let power = shooter.total(&unshot).max_channel();
            state.residual = if first > 0.0 { power / first } else { 0.0 };
            shots += state.residual;
            progress.measured(state.measure(r));
            state.is_reached = state.residual <= REST;
            if state.is_reached
                || shots > MOST_SHOTS
                || bounces.is_some_and(|most| state.iterations >= most)
            {
                break;
            }
            let count = (budget as f64 * power / first).ceil() as u64;
            let arrived = shooter.shoot(
                &unshot,
                count,
                ShotKind::Reflected,
                r as u32,
                state.iterations,
                &mut radiosity,
                progress,
            )?;
            let Some(arrived) = arrived else {
                return Ok(None);
            };
            incident
                .iter_mut()
                .zip(&arrived)
                .for_each(|(h, a)| *h += *a);
            unshot = (0..arrived.len())
                .map(|s| arrived[s] * reflectance[s / 2])
                .collect();
            state.iterations += 1;
        }
        radiosity.add_replicate(solution, &incident, state);
        // All replicates share one balance: what this one misses is in the difference to that before.
        let mut own = radiosity.balance;
        own.add(&before, -1.0);
        missing.push(own.missing());
    }
    radiosity.balance_error = standard_error(&missing);
    Ok(Some(radiosity))
}

/// Irradiance of a side per replicate, and the part that no patch emitted.
type DirectOfSide = ([Rgb; REPLICATES], Rgb);

struct Shooter<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    reflectance: &'a [Rgb],
    seed: u32,
}

impl Shooter<'_> {
    fn exitance(&self, s: Side) -> Rgb {
        let patch = (s / 2) as usize;
        let material = self.patches.material(patch);
        let material = &self.gatherer.surfaces().scene.materials[material as usize];
        self.patches.emission(patch, material, s.is_multiple_of(2)) * PI
    }

    /// How the emission of a patch is sampled.
    fn form(&self, patch: usize) -> EmitterForm {
        let object = self.patches.face(patch).object;
        let is_flat = self.patches.polygon(patch).is_some();
        (self.gatherer).emitter_form(object, self.patches.material(patch), is_flat)
    }

    /// Power of a radiosity per side, W.
    fn total(&self, radiosity: &[Rgb]) -> Rgb {
        radiosity
            .iter()
            .enumerate()
            .map(|(s, &b)| b * self.patches.area(s / 2))
            .sum()
    }

    /// H₀ of every diffuse side, one estimate per replicate, and the part that no patch emitted.
    fn direct(&self, progress: &Progress) -> Result<Option<Vec<DirectOfSide>>, Cancelled> {
        let sides = 2 * self.patches.len();
        progress.begin("direct light", sides as u64);
        let all: Vec<Option<DirectOfSide>> = (0..sides as Side)
            .into_par_iter()
            .map_init(Scratch::default, |scratch, s| {
                progress.advance(1)?;
                if progress.phase_is_over() {
                    return Ok(None);
                }
                if self.reflectance[(s / 2) as usize].is_black() {
                    return Ok(Some(DirectOfSide::default()));
                }
                let points: [GatherPoint; REPLICATES] =
                    std::array::from_fn(|r| self.point(s, r as u32));
                let light = self.gatherer.direct(&points, 1, self.seed);
                let ambient = self.ambient(s, scratch);
                let mut lamps = ambient;
                (0..REPLICATES).for_each(|r| lamps[r] += light[r].whole().mean());
                let lights =
                    light.iter().map(DirectLight::external).sum::<Rgb>() / REPLICATES as f64;
                Ok(Some((
                    lamps,
                    lights + ambient.iter().copied().sum::<Rgb>() / REPLICATES as f64,
                )))
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(all.into_iter().collect())
    }

    fn point(&self, s: Side, r: u32) -> GatherPoint {
        let key = hash(&[self.seed, s, r]);
        let at = self.patches.sample(
            (s / 2) as usize,
            uniform(&[key, 0]).into(),
            uniform(&[key, 1]).into(),
        );
        GatherPoint {
            position: at.position,
            normal: facing(s) * at.normal,
            key,
        }
    }

    /// Irradiance per replicate that no patch shoots: from the surroundings, and by way of glossy
    /// surfaces from lights without area.
    fn ambient(&self, s: Side, scratch: &mut Scratch) -> [Rgb; REPLICATES] {
        let mut sums = [Rgb::BLACK; REPLICATES];
        let has_glossy_lights = self.gatherer.has_glossy_lights();
        if !self.gatherer.has_surroundings() && !has_glossy_lights {
            return sums;
        }
        let mut next_event = NextEvent::default();
        let seed = hash(&[self.seed, s]);
        let share = 1.0 / f64::from(AMBIENT_RAYS);
        let rays = (0..REPLICATES as u32).flat_map(|r| (0..AMBIENT_RAYS).map(move |k| (r, k)));
        let mut paths: Vec<Path> = rays
            .map(|(r, k)| self.path(s, k, hash(&[r, 7]), r, Rgb::grey(share)))
            .collect();
        follow(
            self.gatherer.surfaces(),
            &mut paths,
            scratch,
            seed,
            |path, event| match event {
                Event::Escape => {
                    sums[path.id as usize] += self.gatherer.escaped_exitance(path) * path.weight;
                }
                Event::Surface { hit, .. } if has_glossy_lights => {
                    next_event.add_other_lights(self.gatherer, path, &hit, path.id, seed);
                }
                _ => {}
            },
        );
        next_event.resolve(self.gatherer, |id, contribution| {
            sums[id as usize] += contribution
        });
        sums
    }

    /// Ray `k` of a side: area-averaged, cosine-distributed, carrying `weight`.
    fn path(&self, s: Side, k: u32, key: u32, id: u32, weight: Rgb) -> Path {
        let tracer = self.gatherer.surfaces().tracer;
        let scrambling = seeds(&[self.seed, s, key]);
        let [u1, u2, u3, u4] = std::array::from_fn(|d| f64::from(sobol(k, d, scrambling[d])));
        let at = self.patches.sample((s / 2) as usize, u1, u2);
        let normal = facing(s) * at.normal;
        let direction = cosine_about(&Frame::from_normal(normal), u3, u4);
        let ray = tracer.kernel_ray(&Ray::new(tracer.leaving(at.position, normal), direction));
        Path::new(ray, id, weight * at.weight)
    }

    /// Shoots a radiosity per side by `count` rays; returns the irradiance that arrives per side,
    /// `None` if the phase of the progress is over before.
    #[allow(
        clippy::too_many_arguments,
        reason = "private, two calls; a struct would only rename them"
    )]
    fn shoot(
        &self,
        radiosity: &[Rgb],
        count: u64,
        shot: ShotKind,
        replicate: u32,
        iteration: u32,
        solution: &mut RadiositySolution,
        progress: &Progress,
    ) -> Result<Option<Vec<Rgb>>, Cancelled> {
        let mut power = vec![Rgb::BLACK; radiosity.len()];
        let total: f64 = self.total(radiosity).max_channel().max(0.0);
        if total <= 0.0 || count == 0 {
            return Ok(Some(power));
        }
        progress.begin("shooting", count);
        let key = hash(&[self.seed, replicate, iteration, shot as u32]);
        let work = self.share_out(radiosity, count, uniform(&[key]).into());
        for block in split(&work, BLOCK) {
            if progress.phase_is_over() {
                return Ok(None);
            }
            let batches: Vec<&[(Side, u32, Rgb)]> = split(block, BATCH).collect();
            let arrivals: Vec<BatchResult> = batches
                .par_iter()
                .map_init(Scratch::default, |scratch, batch| {
                    progress.advance(batch.iter().map(|w| u64::from(w.1)).sum())?;
                    Ok(self.shoot_batch(batch, shot, key, scratch))
                })
                .collect::<Result<_, Cancelled>>()?;
            for a in arrivals {
                solution.balance.add(&a.balance, 1.0 / REPLICATES as f64);
                for (s, w) in a.deposits {
                    power[s as usize] += w;
                }
            }
        }
        solution.rays += count;
        let arrived = |s: usize| power[s] / self.patches.area(s / 2);
        Ok(Some((0..power.len()).map(arrived).collect()))
    }

    /// Sides with their number of rays and the power of each ray: stratified over the sides' power,
    /// so that every side gets its share to within one ray.
    fn share_out(&self, radiosity: &[Rgb], count: u64, offset: f64) -> Vec<(Side, u32, Rgb)> {
        let power = |s: usize| radiosity[s] * self.patches.area(s / 2);
        let total: f64 = (0..radiosity.len()).map(|s| power(s).max_channel()).sum();
        let (mut sum, mut before, mut work) = (0.0, offset.floor(), Vec::new());
        for s in 0..radiosity.len() {
            let p = power(s);
            sum += p.max_channel();
            let reached = (sum / total * count as f64 + offset).floor();
            let rays = (reached - before) as u32;
            before = reached;
            if rays > 0 {
                work.push((
                    s as Side,
                    rays,
                    p * (total / (p.max_channel() * count as f64)),
                ));
            }
        }
        work
    }

    fn shoot_batch(
        &self,
        batch: &[(Side, u32, Rgb)],
        shot: ShotKind,
        key: u32,
        scratch: &mut Scratch,
    ) -> BatchResult {
        let surfaces = self.gatherer.surfaces();
        let one = |&(s, rays, weight): &(Side, u32, Rgb)| {
            (0..rays).map(move |k| self.path(s, k, key, s, weight))
        };
        let mut paths: Vec<Path> = batch.iter().flat_map(one).collect();
        let mut a = BatchResult::default();
        let first = batch.first().map_or(0, |w| w.0);
        follow(
            surfaces,
            &mut paths,
            scratch,
            hash(&[key, first]),
            |path, event| {
                let weight = path.weight;
                match event {
                    Event::Escape => a.balance.escaped += weight,
                    Event::Cut => a.balance.cut += weight,
                    Event::Absorbed => a.balance.absorbed += weight,
                    Event::Surface { hit, front } => {
                        let material = surfaces.material(hit.item);
                        if material.dielectric.is_none() {
                            a.balance.absorbed +=
                                weight * (Rgb::WHITE - material.mirror - material.diffuse);
                        }
                        let counted = shot == ShotKind::Emission
                            && self
                                .gatherer
                                .counts_direct(self.form((path.id / 2) as usize), path.via);
                        if !material.diffuse.is_black() {
                            let patch = self.patches.locate_hit(surfaces, &hit);
                            // What vertex colours and textures absorb.
                            let kept = material.diffuse - self.reflectance[patch as usize];
                            a.balance.absorbed += weight * kept;
                            if !counted {
                                a.deposits.push((side(patch, front), path.weight));
                            }
                        }
                    }
                }
            },
        );
        a
    }
}

fn facing(s: Side) -> f64 {
    if s.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// Splits work into runs of about `rays` rays, whole sides each.
fn split(work: &[(Side, u32, Rgb)], rays: usize) -> impl Iterator<Item = &[(Side, u32, Rgb)]> {
    let mut rest = work;
    std::iter::from_fn(move || {
        let mut sum = 0;
        let end = rest.iter().position(|w| {
            sum += w.1 as usize;
            sum >= rays
        });
        let (head, tail) = rest.split_at(end.map_or(rest.len(), |e| e + 1));
        rest = tail;
        (!head.is_empty()).then_some(head)
    })
}
