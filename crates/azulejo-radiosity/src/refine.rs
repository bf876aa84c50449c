//! More rays for the rows that matter, until the error of the radiosity is as small as asked.
//!
//! Rows of many rays would fill the memory, and what is wanted of them is a sum: the irradiance
//! X R. So the rows that are kept stay coarse, and what further rays meet is summed up as they
//! arrive, in the light R₀ that the coarse system gives: G ≈ X R₀. The system solved at last,
//!
//! R = ρ (H₀ + G + X_c (R − R₀)),
//!
//! needs the coarse rows X_c for a small difference alone: R₀ is a control variate (in the words
//! of numerical analysis this is a defect correction). What is left of the coarse rows' noise is
//! a product of two small errors.
//!
//! Rays, and positions at which direct light is computed, go where they lower the error of B most
//! for their cost, in doublings. With area A, reflectance ρ, variance σ² of the irradiance and its
//! decline as count^−rate that is in proportion to (A ρ² σ² / cost)^(1/(1 + rate)), by Lagrange.

use crate::direct::{DIRECT_POSITIONS, direct_at};
use crate::patch::Patches;
use crate::rays::{BATCH, HitPatches, Starts};
use crate::row::{Side, side};
use crate::system::{Found, System};
use azulejo_scene::Rgb;
use azulejo_trace::follow::{Event, Path, Scratch, follow};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, Gathered, Gatherer, Measure, NextEvent, Progress, REPLICATES};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Variance falls about as count^−1.2 (measured: between random, 1, and 2-D strata, 3/2).
const RATE: f64 = 1.2;

/// No round makes a count more than this many times what it was: four replicates tell a row's
/// variance badly, and the next round knows more.
const GROWTH: f64 = 4.0;

/// Most rounds; counts have long reached their limits by then.
const MOST_ROUNDS: u32 = 24;

/// To either side of a patch so many neighbours in the numbering share their variances with it.
const NEIGHBOURS: usize = 4;

/// Most positions of direct light per patch and replicate.
const MOST_POSITIONS: u32 = 1024;

/// What refinement aims at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Relative RMS error of the radiosity, as [`Found::error`] says it.
    pub error: f64,
    /// Most rays per row.
    pub rays: u32,
}

/// What refinement did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spent {
    /// Rays beyond those of the coarse rows.
    pub rays: u64,
    /// Rows that got more rays, or more positions of direct light.
    pub rows: usize,
}

/// Refines `system`, of whose rows each took `rays`; `coarse` is its solution. Afterwards the
/// system's solution is the refined one.
///
/// Ends in good order when the progress is out of time. The result does not depend on threads.
///
/// # Errors
/// [`Cancelled`].
#[allow(
    clippy::too_many_arguments,
    reason = "one call; a struct would only rename them"
)]
pub fn refine(
    system: &mut System,
    coarse: &Found,
    gatherer: &Gatherer,
    patches: &Patches,
    rays: u32,
    goal: Goal,
    seed: u32,
    progress: &Progress,
) -> Result<Spent, Cancelled> {
    let most = (goal.rays / REPLICATES as u32).max(1) as usize;
    let tracer = gatherer.surfaces().tracer;
    let refiner = Refiner {
        gatherer,
        patches,
        starts: Starts::new(tracer, patches, most, seed),
        hit_patches: HitPatches::new(gatherer.surfaces(), patches),
        seed,
        reference: coarse.mean().iter().map(|r| r.to_f32()).collect(),
        progress,
    };
    let reference: Vec<Rgb> = refiner.reference.iter().map(rgb).collect();
    let mut rows = refiner.begin(system, &reference, rays);
    let costs = [1.0, gatherer.direct_cost()];
    let most = [most as u32, MOST_POSITIONS];
    let mut spent = Spent::default();
    for _ in 0..MOST_ROUNDS {
        let strengths = strengths(&rows, system, patches);
        let reached = reached(&rows, &strengths);
        progress.measured(Measure::PatchError(reached.sqrt()));
        if progress.out_of_time() || reached <= goal.error * goal.error {
            break;
        }
        let totals = allot(&rows, &strengths, costs, goal.error, most);
        let work = tasks(&rows, &totals);
        if work.is_empty() {
            break;
        }
        spent.rays += refiner.round(&mut rows, &work)?;
    }
    spent.rows = rows.iter().filter(|r| r.is_refined).count();
    for (i, row) in rows.iter().enumerate() {
        let known = |r: usize| system.matrices[r].row_times(i, &reference);
        let beyond: [Rgb; REPLICATES] =
            std::array::from_fn(|r| row.parts[RAYS].values[r] - known(r));
        let unknown = &mut system.unknowns[i];
        (unknown.direct, unknown.stray) = (row.parts[LAMPS].values, beyond);
    }
    system.rays += spent.rays;
    Ok(spent)
}

fn rgb(v: &[f32; 3]) -> Rgb {
    Rgb::from(v.map(f64::from))
}

/// The parts of a row's irradiance: what its rays meet, and the direct light.
const RAYS: usize = 0;
const LAMPS: usize = 1;

/// Irradiance of one row, as it is known so far.
struct Fine {
    side: Side,
    parts: [Part; 2],
    is_refined: bool,
}

/// One part of it per replicate, and how many samples of each replicate made it.
#[derive(Clone, Copy)]
struct Part {
    values: [Rgb; REPLICATES],
    count: u32,
}

impl Part {
    /// Adds what `count` further samples of each replicate found.
    fn add(&mut self, values: &[Rgb; REPLICATES], count: u32) {
        let total = self.count + count;
        let share = f64::from(count) / f64::from(total);
        for (old, &new) in self.values.iter_mut().zip(values) {
            *old = *old * (1.0 - share) + new * share;
        }
        self.count = total;
    }
}

/// More samples for one part of one row.
struct Task {
    row: usize,
    part: usize,
    side: Side,
    from: u32,
    to: u32,
}

/// What stays the same over all rounds.
struct Refiner<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    starts: Starts<'a>,
    hit_patches: HitPatches<'a>,
    seed: u32,
    /// R₀ per side.
    reference: Vec<[f32; 3]>,
    progress: &'a Progress,
}

impl Refiner<'_> {
    /// What the coarse rows know.
    fn begin(&self, system: &System, reference: &[Rgb], rays: u32) -> Vec<Fine> {
        let row = |i: usize| {
            let u = &system.unknowns[i];
            let met = |r: usize| u.stray[r] + system.matrices[r].row_times(i, reference);
            let parts = [
                Part {
                    values: std::array::from_fn(met),
                    count: rays.div_ceil(REPLICATES as u32).max(1),
                },
                Part {
                    values: u.direct,
                    count: DIRECT_POSITIONS,
                },
            ];
            Fine {
                side: u.side,
                parts,
                is_refined: false,
            }
        };
        (0..system.matrices[0].rows())
            .into_par_iter()
            .map(row)
            .collect()
    }

    /// Does the tasks that there is time for; returns the number of rays.
    fn round(&self, rows: &mut [Fine], tasks: &[Task]) -> Result<u64, Cancelled> {
        let steps = |t: &Task| u64::from(t.to - t.from);
        self.progress
            .begin("refining", tasks.iter().map(steps).sum());
        let found: Vec<Option<[Rgb; REPLICATES]>> = tasks
            .par_iter()
            .map_init(Work::default, |work, task| {
                self.progress.advance(steps(task))?;
                if self.progress.out_of_time() {
                    return Ok(None);
                }
                Ok(Some(match task.part {
                    RAYS => self.rays(task, work),
                    _ => self.lamps(task),
                }))
            })
            .collect::<Result<_, Cancelled>>()?;
        let mut rays = 0;
        for (task, values) in tasks.iter().zip(&found) {
            let Some(values) = values else { continue };
            let row = &mut rows[task.row];
            row.parts[task.part].add(values, task.to - task.from);
            row.is_refined = true;
            if task.part == RAYS {
                rays += steps(task) * REPLICATES as u64;
            }
        }
        Ok(rays)
    }

    /// Irradiance by a stretch of each replicate's rays, in the light R₀.
    fn rays(&self, task: &Task, work: &mut Work) -> [Rgb; REPLICATES] {
        let Work {
            paths,
            scratch,
            next_event,
        } = work;
        let surfaces = self.gatherer.surfaces();
        let ambient = self.gatherer.ambient() * PI;
        let (from, to) = (task.from as usize, task.to as usize);
        let share = 1.0 / (to - from) as f64;
        let mut sums = [Rgb::BLACK; REPLICATES];
        for (replicate, sum) in sums.iter_mut().enumerate() {
            for first in (from..to).step_by(BATCH) {
                let stretch = first..(first + BATCH).min(to);
                self.starts
                    .fill(task.side, replicate, stretch, share, paths);
                let chances = hash(&[self.seed, task.side, replicate as u32, first as u32]);
                follow(surfaces, paths, scratch, chances, |path, event| {
                    let light = match event {
                        Event::Escape => ambient,
                        Event::Surface { hit, front } => {
                            let patch = self.hit_patches.at(&hit);
                            let reflected = rgb(&self.reference[side(patch, front) as usize]);
                            next_event.add(self.gatherer, path, &hit, 0, chances);
                            reflected + self.gatherer.stray_exitance(path, &hit, front)
                        }
                        Event::Cut | Event::Absorbed => return,
                    };
                    *sum += path.weight * light;
                });
                next_event.resolve(self.gatherer, |_, found| *sum += found);
            }
        }
        sums
    }

    /// Direct light from a stretch of each replicate's positions.
    fn lamps(&self, task: &Task) -> [Rgb; REPLICATES] {
        let stretch = task.from..task.to;
        let light = direct_at(self.gatherer, self.patches, self.seed, task.side, stretch);
        light.lamps.replicates.map(|e| e + light.lights)
    }
}

/// Working memory of one thread.
#[derive(Default)]
struct Work {
    paths: Vec<Path>,
    scratch: Scratch,
    next_event: NextEvent,
}

/// For every row and part, what it adds to the square of the relative error, times count^rate.
///
/// Four replicates tell a variance badly, so that neighbours on a surface share theirs.
fn strengths(rows: &[Fine], system: &System, patches: &Patches) -> Vec<[f64; 2]> {
    let shares = relative_shares(rows, system);
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_unstable_by_key(|&i| rows[i].side);
    let mut shared = vec![[0.0; 2]; rows.len()];
    let kind = |i: usize| {
        let s = rows[i].side;
        let patch = (s / 2) as usize;
        (patches.face(patch).object, patches.material(patch), s % 2)
    };
    for (place, &i) in order.iter().enumerate() {
        let range = place.saturating_sub(NEIGHBOURS)..(place + NEIGHBOURS + 1).min(order.len());
        let alike = order[range].iter().filter(|&&j| kind(j) == kind(i));
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for &j in alike {
            (0..2).for_each(|part| sum[part] += shares[j][part]);
            count += 1.0;
        }
        shared[i] = sum.map(|s| s / count);
    }
    shared
}

/// What each row and part adds to the square of the relative error, as its own replicates say,
/// times count^rate.
fn relative_shares(rows: &[Fine], system: &System) -> Vec<[f64; 2]> {
    let unknowns = &system.unknowns[..rows.len()];
    let (mut shares, mut squares) = (Vec::with_capacity(rows.len()), 0.0);
    for (row, u) in rows.iter().zip(unknowns) {
        let reflected = row.parts.map(|part| Gathered {
            replicates: part.values.map(|h| h * u.reflectance),
        });
        let whole = reflected[RAYS].mean() + reflected[LAMPS].mean();
        squares += u.area * (whole * whole).mean();
        shares.push([RAYS, LAMPS].map(|p| {
            let count = f64::from(row.parts[p].count);
            u.area * reflected[p].variance().mean() * count.powf(RATE)
        }));
    }
    let relative = |s: [f64; 2]| s.map(|s| s / f64::max(squares, f64::MIN_POSITIVE));
    shares.into_iter().map(relative).collect()
}

/// The square of the relative error that the strengths predict.
fn reached(rows: &[Fine], strengths: &[[f64; 2]]) -> f64 {
    let of = |(row, s): (&Fine, &[f64; 2])| {
        (0..2)
            .map(|p| s[p] * f64::from(row.parts[p].count).powf(-RATE))
            .sum::<f64>()
    };
    rows.iter().zip(strengths).map(of).sum()
}

/// Counts that bring the error to the goal at least cost, as far as one round should go: powers
/// of two times what there is.
fn allot(
    rows: &[Fine],
    strengths: &[[f64; 2]],
    costs: [f64; 2],
    goal: f64,
    most: [u32; 2],
) -> Vec<[u32; 2]> {
    let power = 1.0 / (1.0 + RATE);
    let term = |s: &[f64; 2]| {
        (0..2)
            .map(|p| s[p].powf(power) * costs[p].powf(RATE * power))
            .sum::<f64>()
    };
    let scale = (strengths.iter().map(term).sum::<f64>() / (goal * goal)).powf(1.0 / RATE);
    let total = |(row, s): (&Fine, &[f64; 2])| {
        [RAYS, LAMPS].map(|p| {
            let count = row.parts[p].count;
            let wanted = (scale * (s[p] / costs[p]).powf(power)).min(GROWTH * f64::from(count));
            let mut next = count;
            // Nearest in the logarithm.
            while f64::from(next) * std::f64::consts::SQRT_2 < wanted && 2 * next <= most[p] {
                next *= 2;
            }
            next
        })
    };
    rows.iter().zip(strengths).map(total).collect()
}

/// What is to be done to reach the totals; the longest first, so that threads end together.
fn tasks(rows: &[Fine], totals: &[[u32; 2]]) -> Vec<Task> {
    let mut tasks = Vec::new();
    for (k, (row, total)) in rows.iter().zip(totals).enumerate() {
        for part in [RAYS, LAMPS] {
            let from = row.parts[part].count;
            if total[part] > from {
                tasks.push(Task {
                    row: k,
                    part,
                    side: row.side,
                    from,
                    to: total[part],
                });
            }
        }
    }
    tasks
}
