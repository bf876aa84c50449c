//! Adaptive refinement: more rays for the rows that dominate the error.
//!
//! Rows of many rays would fill the memory, and only a sum of them is needed: the irradiance X R.
//! So the stored rows stay coarse, and what further rays hit is accumulated directly, in the light
//! R₀ that the coarse system gives: G ≈ X R₀. The final system,
//!
//! R = ρ (H₀ + G + X_c (R − R₀)),
//!
//! needs the coarse rows X_c only for a small difference: R₀ is a control variate (in numerical
//! analysis, this is a defect correction). The remaining noise of the coarse rows is a product of
//! two small errors.
//!
//! Rays, and positions of direct light, go where they reduce the error of B most for their cost, in
//! doublings. With area A, reflectance ρ, variance σ² of the irradiance and its decline as
//! count^−rate, that is in proportion to (A ρ² σ² / cost)^(1/(1 + rate)), by Lagrange.

use crate::direct::{DIRECT_POSITIONS, direct_at};
use crate::system::{RadiositySolution, System, Unknown};
use azulejo_factors::Patches;
use azulejo_factors::rays::{BATCH, HitPatches, RowSampler};
use azulejo_factors::row::{Side, side};
use azulejo_scene::Rgb;
use azulejo_trace::follow::{Event, Path, Scratch, follow};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, Gathered, Gatherer, Measure, NextEvent, REPLICATES, Run};
use rayon::prelude::*;

/// Decline of the variance, about count^−1.2 (measured: between random, 1, and 2-D strata, 3/2).
const RATE: f64 = 1.2;

/// Largest growth of a count per round: four replicates estimate a row's variance badly, and the
/// next round knows more.
const GROWTH: f64 = 4.0;

/// Most rounds; counts reach their limits long before.
const MOST_ROUNDS: u32 = 24;

/// Neighbours in the numbering, to either side, with which a patch shares its variance.
const NEIGHBOURS: usize = 4;

/// Tasks of a block that processes share, at least: a task may take a hundred milliseconds.
const TASK_BLOCK: usize = 2;

/// Most positions of direct light per patch and replicate.
const MOST_POSITIONS: u32 = 1024;

/// The goal of refinement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefinementGoal {
    /// Relative RMS error of the radiosity, see [`RadiositySolution::error`].
    pub error: f64,
    /// Most rays per row.
    pub rays: u32,
}

/// The work of a refinement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RefinementWork {
    /// Rays in addition to those of the coarse rows.
    pub rays: u64,
    /// Rows that got more rays, or more positions of direct light.
    pub rows: usize,
}

/// Refines `system`, whose rows took `rays` each; `coarse` is its solution. Solving the system
/// afterwards gives the refined solution.
///
/// Ends early when the phase of the progress is over. The result does not depend on threads.
///
/// # Errors
/// [`Cancelled`].
pub fn refine(
    system: &mut System,
    coarse: &RadiositySolution,
    gatherer: &Gatherer,
    patches: &Patches,
    rays: u32,
    goal: RefinementGoal,
    seed: u32,
) -> Result<RefinementWork, Cancelled> {
    let run = system.run();
    let most = (goal.rays / REPLICATES as u32).max(1) as usize;
    let tracer = gatherer.surfaces().tracer;
    let refiner = Refiner {
        gatherer,
        patches,
        sampler: RowSampler::new(tracer, patches, most, seed),
        hit_patches: HitPatches::new(gatherer.surfaces(), patches),
        seed,
        reference: coarse.mean().iter().map(|r| r.to_f32()).collect(),
        run,
    };
    // Start from what the coarse rows give in the light R₀.
    let reference: Vec<Rgb> = refiner.reference.iter().map(rgb).collect();
    let known = arriving(system, &reference)?;
    let mut rows = refiner.begin(system, &known, rays);
    let costs = [1.0, gatherer.direct_cost()];
    let most = [most as u32, MOST_POSITIONS];
    let mut spent = RefinementWork::default();
    // Each round goes a few doublings towards the goal, with what is known of the variances by then.
    for _ in 0..MOST_ROUNDS {
        let strengths = strengths(&rows, system, patches);
        let reached = reached(&rows, &strengths);
        run.progress.measured(Measure::PatchError(reached.sqrt()));
        if run.progress.phase_is_over() || reached <= goal.error * goal.error {
            break;
        }
        let totals = allocate(&rows, &strengths, costs, goal.error, most);
        let work = tasks(&rows, &totals);
        if work.is_empty() {
            break;
        }
        spent.rays += refiner.round(&mut rows, &work)?;
    }
    spent.rows = rows.iter().filter(|r| r.is_refined).count();
    // State as stray light what the rays gather beyond X R₀: the system adds X R, with R₀ as control variate.
    for (i, row) in rows.iter().enumerate() {
        let beyond: [Rgb; REPLICATES] =
            std::array::from_fn(|r| row.parts[RAYS].values[r] - known[r][i]);
        let unknown = &mut system.unknowns[i];
        (unknown.direct, unknown.stray) = (row.parts[LAMPS].values, beyond);
    }
    system.rays += spent.rays;
    Ok(spent)
}

/// X R₀ of every unknown, for each replicate.
fn arriving(system: &System, reference: &[Rgb]) -> Result<Vec<Vec<Rgb>>, Cancelled> {
    let light: Vec<(usize, &[Rgb])> = (0..REPLICATES).map(|r| (r, reference)).collect();
    system.arriving(&light)
}

fn rgb(v: &[f32; 3]) -> Rgb {
    Rgb::from(v.map(f64::from))
}

/// The parts of a row's irradiance: indirect light from its rays, and direct light.
const RAYS: usize = 0;
const LAMPS: usize = 1;

/// The current estimate of the irradiance of one row.
struct RefinedRow {
    side: Side,
    parts: [RowPart; 2],
    is_refined: bool,
}

/// One part of it per replicate, and the number of samples of each.
#[derive(Clone, Copy)]
struct RowPart {
    values: [Rgb; REPLICATES],
    count: u32,
}

impl RowPart {
    /// Adds `count` further samples of each replicate.
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
struct RefinementTask {
    row: usize,
    part: usize,
    side: Side,
    from: u32,
    to: u32,
}

/// The constants of all rounds.
struct Refiner<'a> {
    gatherer: &'a Gatherer<'a>,
    patches: &'a Patches,
    sampler: RowSampler<'a>,
    hit_patches: HitPatches<'a>,
    seed: u32,
    /// R₀ per side.
    reference: Vec<[f32; 3]>,
    run: Run<'a>,
}

impl Refiner<'_> {
    /// The estimates of the coarse rows.
    fn begin(&self, system: &System, known: &[Vec<Rgb>], rays: u32) -> Vec<RefinedRow> {
        let row = |(i, u): (usize, &Unknown)| {
            let met = |r: usize| u.stray[r] + known[r][i];
            let parts = [
                RowPart {
                    values: std::array::from_fn(met),
                    count: rays.div_ceil(REPLICATES as u32).max(1),
                },
                RowPart {
                    values: u.direct,
                    count: DIRECT_POSITIONS,
                },
            ];
            RefinedRow {
                side: u.side,
                parts,
                is_refined: false,
            }
        };
        system.unknowns.iter().enumerate().map(row).collect()
    }

    /// Carries out tasks while there is time; returns the number of rays.
    fn round(&self, rows: &mut [RefinedRow], tasks: &[RefinementTask]) -> Result<u64, Cancelled> {
        let steps = |t: &RefinementTask| u64::from(t.to - t.from);
        self.run
            .progress
            .begin("refining", tasks.iter().map(steps).sum());
        let carry_out = |work: &mut RayScratch, &task: &usize| {
            let task = &tasks[task];
            self.run.progress.advance(steps(task))?;
            if self.run.progress.phase_is_over() {
                return Ok(None);
            }
            Ok(Some(match task.part {
                RAYS => self.rays(task, work),
                _ => self.lamps(task),
            }))
        };
        let size = (tasks.len(), TASK_BLOCK);
        let irradiance: Vec<Option<[Rgb; REPLICATES]>> = self.run.shared(size, |indices| {
            let indices = indices.par_iter();
            indices.map_init(RayScratch::default, carry_out).collect()
        })?;
        let mut rays = 0;
        for (task, values) in tasks.iter().zip(&irradiance) {
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

    /// Irradiance from a range of each replicate's rays, in the light R₀.
    fn rays(&self, task: &RefinementTask, work: &mut RayScratch) -> [Rgb; REPLICATES] {
        let RayScratch {
            paths,
            scratch,
            next_event,
        } = work;
        let surfaces = self.gatherer.surfaces();
        let (from, to) = (task.from as usize, task.to as usize);
        let share = 1.0 / (to - from) as f64;
        let mut sums = [Rgb::BLACK; REPLICATES];
        for (replicate, sum) in sums.iter_mut().enumerate() {
            for first in (from..to).step_by(BATCH) {
                let stretch = first..(first + BATCH).min(to);
                self.sampler
                    .fill(task.side, replicate, stretch, share, paths);
                let chances = hash(&[self.seed, task.side, replicate as u32, first as u32]);
                follow(surfaces, paths, scratch, chances, |path, event| {
                    let light = match event {
                        Event::Escape => self.gatherer.escaped_exitance(path),
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
                next_event.resolve(self.gatherer, |_, contribution| *sum += contribution);
            }
        }
        sums
    }

    /// Direct light from a range of each replicate's positions.
    fn lamps(&self, task: &RefinementTask) -> [Rgb; REPLICATES] {
        let stretch = task.from..task.to;
        let light = direct_at(self.gatherer, self.patches, self.seed, task.side, stretch);
        light.whole().replicates
    }
}

/// Working memory of one thread.
#[derive(Default)]
struct RayScratch {
    paths: Vec<Path>,
    scratch: Scratch,
    next_event: NextEvent,
}

/// The contribution of every row and part to the squared relative error, times count^rate.
///
/// Four replicates estimate a variance badly, so neighbours on a surface share theirs.
fn strengths(rows: &[RefinedRow], system: &System, patches: &Patches) -> Vec<[f64; 2]> {
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

/// The contribution of each row and part to the squared relative error, from its own replicates,
/// times count^rate.
fn relative_shares(rows: &[RefinedRow], system: &System) -> Vec<[f64; 2]> {
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

/// The squared relative error that the strengths predict.
fn reached(rows: &[RefinedRow], strengths: &[[f64; 2]]) -> f64 {
    let of = |(row, s): (&RefinedRow, &[f64; 2])| {
        (0..2)
            .map(|p| s[p] * f64::from(row.parts[p].count).powf(-RATE))
            .sum::<f64>()
    };
    rows.iter().zip(strengths).map(of).sum()
}

/// Counts that reach the goal at least cost, as far as one round should go: the present counts
/// times powers of two.
fn allocate(
    rows: &[RefinedRow],
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
    let total = |(row, s): (&RefinedRow, &[f64; 2])| {
        [RAYS, LAMPS].map(|p| {
            let count = row.parts[p].count;
            let samples = (scale * (s[p] / costs[p]).powf(power)).min(GROWTH * f64::from(count));
            let mut next = count;
            // Nearest on a logarithmic scale.
            while f64::from(next) * std::f64::consts::SQRT_2 < samples && 2 * next <= most[p] {
                next *= 2;
            }
            next
        })
    };
    rows.iter().zip(strengths).map(total).collect()
}

/// The tasks that reach the totals; the longest first, so that threads finish together.
fn tasks(rows: &[RefinedRow], totals: &[[u32; 2]]) -> Vec<RefinementTask> {
    let mut tasks = Vec::new();
    for (k, (row, total)) in rows.iter().zip(totals).enumerate() {
        for part in [RAYS, LAMPS] {
            let from = row.parts[part].count;
            if total[part] > from {
                tasks.push(RefinementTask {
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
