//! The radiosity system B = M + ρ (H₀ + X R): its rows and its solution.
//!
//! Emission M enters through H₀, the irradiance that arrives without diffuse reflection, which is
//! exact where formulas compute it. The unknown is R = B − M, the light that leaves by diffuse
//! reflection. Four replicates of every row make four independent systems; the spread of their
//! solutions carries the noise of the rows through to the result.

use crate::deadline::PhaseWatch;
use crate::direct::direct;
use azulejo_factors::Patches;
use azulejo_factors::estimator::Estimator;
use azulejo_factors::row::{Entry, Row, Side, side};
use azulejo_factors::sparse::{SparseMatrix, SparseRow};
use azulejo_scene::{Material, Rgb};
use azulejo_trace::run::{LoopSize, Record, RecordReader};
use azulejo_trace::{Cancelled, Gathered, Gatherer, Measure, REPLICATES, Run};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Rows of a block that processes share, at least.
const BLOCK: usize = 8;

/// Rows computed at once, between two checks of the progress, by each thread.
const AT_ONCE: usize = 64;

/// Sides whose direct light is computed in a block that processes share, at least.
const DIRECT_BLOCK: usize = 64;

/// One unknown: a side of a patch that reflects diffusely and that light can reach.
#[derive(Clone, Debug)]
pub struct Unknown {
    /// The side.
    pub side: Side,
    /// Area of the patch.
    pub area: f64,
    /// Diffuse reflectance ρ_d.
    pub reflectance: Rgb,
    /// Emitted exitance M of this side, W/m².
    pub exitance: Rgb,
    /// The part of H₀ that formulas compute, per replicate, W/m².
    pub direct: [Rgb; REPLICATES],
    /// The part of H₀ that rays found, per replicate; after [refinement](crate::refine), the
    /// difference to what the rows give.
    pub stray: [Rgb; REPLICATES],
    /// The part of H₀ that no patch emitted: lights without area and the surroundings.
    pub external: Rgb,
    /// Shares of what leaves this side that are absorbed, escape, or are cut off.
    pub outcomes: [Rgb; 3],
}

/// The rows of all unknowns: all in this process, or those that it computed, where several share the
/// work. These exchange vectors, never rows.
pub struct System<'j> {
    /// All unknowns.
    pub unknowns: Vec<Unknown>,
    /// The unknowns whose rows this process has, in the order of the matrices' rows.
    rows: Vec<u32>,
    /// One matrix per replicate; columns are sides.
    matrices: Vec<SparseMatrix>,
    /// The work on it, by all processes that share the rows.
    run: Run<'j>,
    /// Number of sides: twice the patches.
    pub sides: usize,
    /// Rays traced from patches.
    pub rays: u64,
}

/// Convergence of a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Convergence {
    /// Bounces of light followed.
    pub iterations: u32,
    /// Largest change of a patch in the last iteration, relative to the largest R.
    pub residual: f64,
    /// Whether iteration ended because little light was left.
    pub is_reached: bool,
    /// Change half a [`PERIOD`] ago, W/m², and the factor by which it fell at each bounce since.
    pub(crate) before: f64,
    pub(crate) rate: f64,
}

impl Convergence {
    /// Whether light hardly dies out: what is reflected most lasts longest, so that changes never fall faster than they
    /// have begun to.
    fn is_endless(&self) -> bool {
        self.residual.is_infinite() || self.iterations >= 2 * PERIOD && self.rate >= ENDLESS
    }

    /// Notes the change of a bounce; every [`PERIOD`] returns how much of it is still to come, if it goes on to fall so
    /// (Lyusternik 1947, after Varga, *Matrix Iterative Analysis*, 1962).
    fn note(&mut self, change: f64) -> Option<f64> {
        match self.iterations % PERIOD {
            0 => {
                self.rate = (change / self.before).powf(2.0 / f64::from(PERIOD));
                let is_slow = (SLOW..ENDLESS).contains(&self.rate);
                is_slow.then(|| self.rate / (1.0 - self.rate))
            }
            HALF_PERIOD => {
                self.before = change;
                None
            }
            _ => None,
        }
    }

    /// The progress of one replicate.
    pub(crate) fn measure(&self, replicate: usize) -> Measure {
        Measure::Residual {
            replicate: replicate as u32,
            iteration: self.iterations,
            value: self.residual,
        }
    }
}

/// What a row contributes to its unknown, and to the matrices.
struct TracedRow {
    /// One per replicate.
    rows: [SparseRow; REPLICATES],
    stray: [Rgb; REPLICATES],
    external: Rgb,
    outcomes: [Rgb; 3],
    rays: u32,
}

impl Record for TracedRow {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.rows.iter().for_each(|row| row.write(bytes));
        self.stray.write(bytes);
        self.external.write(bytes);
        self.outcomes.write(bytes);
        self.rays.write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<TracedRow> {
        let mut rows: [SparseRow; REPLICATES] = Default::default();
        for row in &mut rows {
            *row = SparseRow::read(bytes)?;
        }
        Some(TracedRow {
            rows,
            stray: Record::read(bytes)?,
            external: Record::read(bytes)?,
            outcomes: Record::read(bytes)?,
            rays: Record::read(bytes)?,
        })
    }
}

/// What all processes need to know of a row.
struct RowSummary {
    stray: [Rgb; REPLICATES],
    external: Rgb,
    outcomes: [Rgb; 3],
    rays: u32,
    /// Sides that it reaches, of which this process has not yet told.
    reached: Vec<Side>,
}

impl Record for RowSummary {
    fn write(&self, bytes: &mut Vec<u8>) {
        self.stray.write(bytes);
        self.external.write(bytes);
        self.outcomes.write(bytes);
        self.rays.write(bytes);
        self.reached.write(bytes);
    }

    fn read(bytes: &mut RecordReader) -> Option<RowSummary> {
        Some(RowSummary {
            stray: Record::read(bytes)?,
            external: Record::read(bytes)?,
            outcomes: Record::read(bytes)?,
            rays: Record::read(bytes)?,
            reached: Record::read(bytes)?,
        })
    }
}

impl<'j> System<'j> {
    /// Traces the rows of every side that light can reach: all fronts, then the backs that rays
    /// from reached sides hit, and so on. If no light starts in front of any surface, as in a room
    /// that is inside out, backs come first too. Rows stay with the process that computed them.
    ///
    /// `None` if the phase of the progress is over before: some rows alone would leave the rest of
    /// the scene dark.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn trace(
        gatherer: &Gatherer,
        patches: &Patches,
        reflectance: &[Rgb],
        estimator: &Estimator,
        seed: u32,
        run: Run<'j>,
    ) -> Result<Option<System<'j>>, Cancelled> {
        let progress = run.progress;
        let materials = &gatherer.surfaces().scene.materials;
        let reflects = |p: usize| {
            let m = &materials[patches.material(p) as usize];
            !m.diffuse.is_black() || m.is_emitter()
        };
        let channels = if materials.iter().all(is_grey) { 1 } else { 3 };
        let mut system = System {
            unknowns: Vec::new(),
            rows: Vec::new(),
            matrices: vec![SparseMatrix::new(channels); REPLICATES],
            run,
            sides: 2 * patches.len(),
            rays: 0,
        };
        // The first wave has the fronts of patches that reflect or emit, and the backs that emit.
        let mut is_planned = vec![false; system.sides];
        let mut wave: Vec<Side> = (0..patches.len())
            .filter(|&p| reflects(p))
            .map(|p| side(p as u32, true))
            .collect();
        let emits_back = |&p: &usize| materials[patches.material(p) as usize].emits_back;
        let backs = (0..patches.len()).filter(emits_back);
        wave.extend(backs.map(|p| side(p as u32, false)));
        // If no light starts before a side of the wave, as in a room that is inside out, the other backs come too.
        let begins = |&s: &Side| {
            let material = &materials[patches.material((s / 2) as usize) as usize];
            material.is_emitter() || !direct(gatherer, patches, seed, s).external().is_black()
        };
        if !gatherer.has_surroundings() && !wave.iter().any(begins) {
            wave.extend(
                (0..patches.len())
                    .filter(|p| reflects(*p) && !emits_back(p))
                    .map(|p| side(p as u32, false)),
            );
        }
        wave.iter().for_each(|&s| is_planned[s as usize] = true);
        let diffuse = |j: usize| materials[patches.material(j) as usize].diffuse;
        let lost = |j: usize| diffuse(j) - reflectance[j];
        // Follow the light from wave to wave: each has the sides that rows of the one before reach first.
        while !wave.is_empty() {
            // Compute the part of H₀ that formulas give; what the rays of the rows add to it follows.
            progress.begin("direct light", wave.len() as u64);
            let light = |&i: &usize| {
                progress.advance(1)?;
                if progress.phase_is_over() {
                    return Ok(None);
                }
                let incident = direct(gatherer, patches, seed, wave[i]);
                Ok(Some((incident.whole().replicates, incident.external())))
            };
            let size = (wave.len(), DIRECT_BLOCK);
            let lights = run.shared(size, |indices| indices.par_iter().map(light).collect())?;
            let lights: Option<Vec<([Rgb; REPLICATES], Rgb)>> = lights.into_iter().collect();
            let Some(lights) = lights else {
                return Ok(None);
            };
            let first = system.unknowns.len();
            for (&s, (direct, external)) in wave.iter().zip(lights) {
                let patch = (s / 2) as usize;
                let material = &materials[patches.material(patch) as usize];
                let emitted = patches.emission(patch, material, s.is_multiple_of(2));
                system.unknowns.push(Unknown {
                    side: s,
                    area: patches.area(patch),
                    reflectance: reflectance[patch],
                    exitance: emitted * PI,
                    direct,
                    stray: [Rgb::BLACK; REPLICATES],
                    external,
                    outcomes: [Rgb::BLACK; 3],
                });
            }
            // Trace the rows; give up as soon as their pace shows that the phase will end before they do.
            progress.begin("form factors", wave.len() as u64);
            let (watch, all) = (PhaseWatch::new(progress), wave.len() as f64);
            let (mut done, mut is_hopeless) = (0, false);
            let compute = |indices: &[usize]| {
                is_hopeless = progress.phase_is_over() || watch.is_hopeless(f64::from(done) / all);
                if is_hopeless {
                    return Err(Cancelled);
                }
                done += indices.len() as u32;
                let sides: Vec<Side> = indices.iter().map(|&i| wave[i]).collect();
                let rows = estimator.rows(&sides, progress)?;
                let traced = rows
                    .par_iter()
                    .map(|row| TracedRow::new(row, channels, diffuse, lost));
                Ok(traced.collect())
            };
            // Rows stay in this process, which tells all others the sides that they reach, each once in a wave.
            let mut is_told = is_planned.clone();
            let keep = |i: usize, row: TracedRow| {
                let reached = row.rows.iter().flat_map(|row| &row.columns);
                let is_new = |&&s: &&Side| !std::mem::replace(&mut is_told[s as usize], true);
                let reached = reached.filter(is_new).copied().collect();
                system.rows.push((first + i) as u32);
                for (matrix, row) in system.matrices.iter_mut().zip(&row.rows) {
                    matrix.push(row);
                }
                RowSummary {
                    stray: row.stray,
                    external: row.external,
                    outcomes: row.outcomes,
                    rays: row.rays,
                    reached,
                }
            };
            let size = LoopSize {
                items: wave.len(),
                block: BLOCK,
                at_once: AT_ONCE * rayon::current_num_threads().max(1),
            };
            let summaries = run.distributed(size, compute, keep);
            if is_hopeless {
                return Ok(None);
            }
            // Complete the unknowns, and merge the sides reached, as several processes may tell of the same.
            let mut reached = Vec::new();
            for (unknown, row) in system.unknowns[first..].iter_mut().zip(summaries?) {
                unknown.stray = row.stray;
                unknown.external += row.external;
                unknown.outcomes = row.outcomes;
                system.rays += u64::from(row.rays);
                reached.extend(row.reached);
            }
            reached.sort_unstable();
            reached.dedup();
            reached.iter().for_each(|&s| is_planned[s as usize] = true);
            wave = reached;
        }
        Ok(Some(system))
    }

    /// The work on it.
    pub(crate) fn run(&self) -> Run<'j> {
        self.run
    }

    /// Bytes of the rows that this process has, and of all unknowns.
    pub fn bytes(&self) -> usize {
        self.matrices.iter().map(SparseMatrix::bytes).sum::<usize>()
            + self.unknowns.len() * size_of::<Unknown>()
    }

    /// Solves the system of each replicate: R per side, W/m².
    ///
    /// Jacobi iteration from R = ρ H₀, one bounce of light per iteration, until the residual is
    /// below `tolerance` or `bounces` are done. It converges since max ρ_d/(1 − ρ_s) < 1. All replicates take their
    /// bounces at once, so that processes that share the rows meet once for each.
    ///
    /// # Errors
    /// [`Cancelled`].
    fn solve(
        &self,
        bounces: Option<u32>,
        tolerance: f64,
    ) -> Result<Vec<(Vec<Rgb>, Convergence)>, Cancelled> {
        let progress = self.run.progress;
        let most = bounces.unwrap_or(MOST_ITERATIONS);
        let start = Convergence {
            iterations: 0,
            is_reached: false,
            ..Convergence::default()
        };
        let mut all = vec![(vec![Rgb::BLACK; self.sides], start); REPLICATES];
        loop {
            progress.advance(0)?;
            let is_open = |state: &Convergence| {
                let is_limited = bounces.is_some();
                !state.is_reached && state.iterations < most && (is_limited || !state.is_endless())
            };
            let open = all.iter().enumerate();
            let open = open.filter(|(_, (_, state))| is_open(state));
            let open: Vec<(usize, &[Rgb])> = open.map(|(r, (light, _))| (r, &light[..])).collect();
            if open.is_empty() {
                return Ok(all);
            }
            let replicates: Vec<usize> = open.iter().map(|(r, _)| *r).collect();
            let arriving = self.arriving(&open)?;
            for (replicate, arriving) in replicates.into_iter().zip(arriving) {
                let (reflected, state) = &mut all[replicate];
                self.bounce(replicate, arriving, reflected, state, bounces.is_some());
                state.is_reached = state.residual <= tolerance;
                progress.measured(state.measure(replicate));
            }
        }
    }

    /// One bounce more of the light `reflected` from each side, which arrives at every unknown; where bounces are not
    /// limited, now and then with what is expected of those to come.
    fn bounce(
        &self,
        replicate: usize,
        arriving: Vec<Rgb>,
        reflected: &mut [Rgb],
        state: &mut Convergence,
        is_limited: bool,
    ) {
        let next = self.unknowns.iter().zip(arriving);
        let next = next.map(|(u, h)| u.reflectance * (u.unbounced(replicate) + h));
        let next: Vec<Rgb> = next.collect();
        let (mut change, mut largest) = (0f64, 0f64);
        for (u, &value) in self.unknowns.iter().zip(&next) {
            let old = reflected[u.side as usize];
            change = change.max((value - old).map(f64::abs).max_channel());
            largest = largest.max(value.max_channel());
        }
        state.iterations += 1;
        // Maxima pass over what is not a number.
        state.residual = match largest {
            _ if !next.iter().all(|value| value.mean().is_finite()) => f64::INFINITY,
            0.0 => 0.0,
            largest => change / largest,
        };
        let to_come = state.note(change).filter(|_| !is_limited).unwrap_or(0.0);
        for (u, value) in self.unknowns.iter().zip(next) {
            let old = &mut reflected[u.side as usize];
            *old = value + (value - *old) * to_come;
        }
    }

    /// Irradiance of every unknown by light reflected from each side, for some replicates, with that of each: 4
    /// bytes of each row and 24 for each replicate go to all processes.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(crate) fn arriving(
        &self,
        reflected: &[(usize, &[Rgb])],
    ) -> Result<Vec<Vec<Rgb>>, Cancelled> {
        let of_rows = |&(replicate, light): &(usize, &[Rgb])| {
            let matrix = &self.matrices[replicate];
            matrix.map_rows(|i| matrix.row_times(i, light))
        };
        let irradiance: Vec<Vec<Rgb>> = reflected.iter().map(of_rows).collect();
        let mut all = vec![vec![Rgb::BLACK; self.unknowns.len()]; reflected.len()];
        if !self.run.is_shared() {
            for (all, irradiance) in all.iter_mut().zip(irradiance) {
                for (&i, h) in self.rows.iter().zip(irradiance) {
                    all[i as usize] = h;
                }
            }
            return Ok(all);
        }
        let (stage, mut bytes) = (self.run.blocks.loop_stage(), Vec::new());
        self.rows.write(&mut bytes);
        irradiance.write(&mut bytes);
        for bytes in self.run.blocks.gather(stage, bytes)? {
            let mut reader = RecordReader::new(&bytes);
            let rows = Vec::<u32>::read(&mut reader).ok_or(Cancelled)?;
            let irradiance = Vec::<Vec<Rgb>>::read(&mut reader).ok_or(Cancelled)?;
            for (all, irradiance) in all.iter_mut().zip(irradiance) {
                for (&i, h) in rows.iter().zip(irradiance) {
                    all[i as usize] = h;
                }
            }
        }
        Ok(all)
    }

    /// Energy balance, W, for the reflected light `reflected` (mean of the replicates, per side).
    pub fn balance(&self, reflected: &[Rgb]) -> EnergyBalance {
        let mut b = EnergyBalance::default();
        for u in &self.unknowns {
            let leaving = (u.exitance + reflected[u.side as usize]) * u.area;
            b.emitted += u.exitance * u.area + u.external * u.area;
            // Light of no patch is absorbed by its first surface here; the rest is absorbed by
            // rows.
            b.absorbed +=
                leaving * u.outcomes[0] + u.external * (Rgb::WHITE - u.reflectance) * u.area;
            b.escaped += leaving * u.outcomes[1];
            b.cut += leaving * u.outcomes[2];
        }
        b
    }
}

impl System<'_> {
    /// Standard error of [`EnergyBalance::error`], from the balances of the replicates.
    fn balance_error(&self, solutions: &[Vec<Rgb>]) -> f64 {
        let shares: Vec<f64> = solutions
            .iter()
            .map(|reflected| self.balance(reflected).missing())
            .collect();
        standard_error(&shares)
    }
}

/// Standard error of the mean of independent values.
pub(crate) fn standard_error(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count.max(1.0);
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (squares / (count * (count - 1.0)).max(1.0)).sqrt()
}

impl Unknown {
    /// H₀ of one replicate.
    fn unbounced(&self, replicate: usize) -> Rgb {
        self.direct[replicate] + self.stray[replicate]
    }
}

impl TracedRow {
    /// `diffuse` is the reflectance of a patch's material, and `lost` what vertex colours and textures absorb of it.
    fn new(
        row: &Row,
        channels: usize,
        diffuse: impl Fn(usize) -> Rgb,
        lost: impl Fn(usize) -> Rgb,
    ) -> TracedRow {
        let share = 1.0 / REPLICATES as f64;
        let pattern = |e: &Entry| lost((e.side / 2) as usize) * e.weight * share;
        let patterns: Rgb = row.entries.iter().flatten().map(pattern).sum();
        // Of what coincides, each counts all of the light that arrives: it would grow.
        let reflected = |e: &Entry| diffuse((e.side / 2) as usize) * e.weight * share;
        let reflected: Rgb = row.entries.iter().flatten().map(reflected).sum();
        let arrived = reflected + row.absorbed + row.all_escaped() + row.cut;
        let whole = match arrived.max_channel() {
            arrived if arrived > 1.0 + OFF => arrived,
            _ => 1.0,
        };
        let scaled = |entries: &[Entry]| -> Vec<Entry> {
            let weight = |e: &Entry| e.weight / whole;
            let entry = |e: &Entry| Entry {
                weight: weight(e),
                ..*e
            };
            entries.iter().map(entry).collect()
        };
        TracedRow {
            rows: std::array::from_fn(|r| SparseRow::new(channels, &scaled(&row.entries[r]))),
            stray: row.stray,
            external: row.external,
            outcomes: [row.absorbed + patterns, row.all_escaped(), row.cut].map(|o| o / whole),
            rays: row.rays,
        }
    }
}

impl System<'_> {
    /// Solves all replicates.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn solve_all(&self, bounces: Option<u32>) -> Result<RadiositySolution, Cancelled> {
        let progress = self.run.progress;
        progress.begin("bounces", REPLICATES as u64);
        let mut radiosity = RadiositySolution::new(self.sides);
        let solved = self.solve(bounces, TOLERANCE)?;
        let light = solved.iter().enumerate();
        let light: Vec<(usize, &[Rgb])> = light.map(|(r, (light, _))| (r, &light[..])).collect();
        let arriving = self.arriving(&light)?;
        for (r, ((solution, state), arriving)) in solved.into_iter().zip(arriving).enumerate() {
            let mut incident = vec![Rgb::BLACK; self.sides];
            for (u, h) in self.unknowns.iter().zip(arriving) {
                incident[u.side as usize] = u.unbounced(r) + h;
            }
            radiosity.add_replicate(solution, &incident, state);
            progress.advance(1)?;
        }
        radiosity.balance = self.balance(&radiosity.mean());
        radiosity.balance_error = self.balance_error(&radiosity.solutions);
        (radiosity.rays, radiosity.bytes) = (self.rays, self.bytes());
        Ok(radiosity)
    }
}

/// The light on the sides of patches, by either method.
pub struct RadiositySolution {
    /// R per side, one solution per replicate, W/m².
    pub solutions: Vec<Vec<Rgb>>,
    /// Irradiance per side, mean of the replicates, W/m²; black on sides without a row.
    pub incident: Vec<Rgb>,
    /// The worst of the replicates.
    pub convergence: Convergence,
    /// Energy balance.
    pub balance: EnergyBalance,
    /// Standard error of the share of the emitted power that is unaccounted for, from the
    /// replicates.
    pub balance_error: f64,
    /// Rays traced from patches.
    pub rays: u64,
    /// Bytes of stored rows.
    pub bytes: usize,
}

impl RadiositySolution {
    /// An empty solution over this many sides.
    pub fn new(sides: usize) -> RadiositySolution {
        RadiositySolution {
            solutions: Vec::with_capacity(REPLICATES),
            incident: vec![Rgb::BLACK; sides],
            convergence: Convergence {
                is_reached: true,
                ..Convergence::default()
            },
            balance: EnergyBalance::default(),
            balance_error: 0.0,
            rays: 0,
            bytes: 0,
        }
    }

    /// No light on this many sides: what gathers that read no patches take.
    pub fn dark(sides: usize) -> RadiositySolution {
        RadiositySolution {
            solutions: vec![vec![Rgb::BLACK; sides]],
            ..RadiositySolution::new(sides)
        }
    }

    /// Adds one of [`REPLICATES`] solutions, with its irradiance.
    pub fn add_replicate(&mut self, solution: Vec<Rgb>, incident: &[Rgb], state: Convergence) {
        self.solutions.push(solution);
        let share = 1.0 / REPLICATES as f64;
        self.incident
            .iter_mut()
            .zip(incident)
            .for_each(|(mean, h)| *mean += *h * share);
        self.convergence.iterations = self.convergence.iterations.max(state.iterations);
        self.convergence.residual = self.convergence.residual.max(state.residual);
        self.convergence.is_reached &= state.is_reached;
    }

    /// Estimated error of the reflected radiosity R: root mean square over the sides, weighted by
    /// area and relative to that of R itself, over all channels.
    pub fn error(&self, patches: &Patches) -> f64 {
        let (mut errors, mut squares) = (0.0, 0.0);
        for s in 0..self.incident.len() {
            let reflected = Gathered {
                replicates: std::array::from_fn(|r| self.solutions[r % self.solutions.len()][s]),
            };
            let (area, mean) = (patches.area(s / 2), reflected.mean());
            errors += area * reflected.variance().mean();
            squares += area * (mean * mean).mean();
        }
        (errors / f64::max(squares, f64::MIN_POSITIVE)).sqrt()
    }

    /// Mean of the solutions, per side.
    pub fn mean(&self) -> Vec<Rgb> {
        let share = 1.0 / self.solutions.len().max(1) as f64;
        (0..self.incident.len())
            .map(|s| self.solutions.iter().map(|x| x[s]).sum::<Rgb>() * share)
            .collect()
    }
}

/// Relative residual at which iteration ends: the error that it leaves is several times as large
/// where little is absorbed.
const TOLERANCE: f64 = 1e-6;

/// Even facing perfect mirrors end here.
const MOST_ITERATIONS: u32 = 2_000;

/// Bounces in the second half of which it is measured how fast changes fall.
const PERIOD: u32 = 64;
const HALF_PERIOD: u32 = PERIOD / 2;

/// Factors by which changes fall at each bounce: from the first on, later bounces are foreseen, and from the second on
/// light is taken not to die out.
const SLOW: f64 = 0.8;
const ENDLESS: f64 = 0.9999;

/// Share of the emitted power that may be unaccounted for.
const OFF: f64 = 0.02;

/// Share of the emitted power without which a solution is none.
const BROKEN: f64 = 0.1;

/// The energy balance: where the emitted power went, per channel; W, where areas are in m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Emitted by surfaces, and by lights without area as far as it reaches a surface.
    pub emitted: Rgb,
    /// Absorbed by surfaces.
    pub absorbed: Rgb,
    /// Lost out of an open scene.
    pub escaped: Rgb,
    /// Cut off by the limits on mirror chains.
    pub cut: Rgb,
}

impl EnergyBalance {
    /// All powers times `factor`.
    pub fn scaled(&self, factor: f64) -> EnergyBalance {
        let mut scaled = EnergyBalance::default();
        scaled.add(self, factor);
        scaled
    }

    /// Adds `share` of another balance.
    pub fn add(&mut self, other: &EnergyBalance, share: f64) {
        self.emitted += other.emitted * share;
        self.absorbed += other.absorbed * share;
        self.escaped += other.escaped * share;
        self.cut += other.cut * share;
    }

    /// Whether more is missing than should be: more rays or more time are needed then.
    pub fn is_off(&self) -> bool {
        self.error() > OFF
    }

    /// Whether so much is missing, beyond what two of its standard errors explain, that the solution cannot be trusted.
    /// What these explain is in the error of the light, too.
    pub fn is_broken(&self, standard_error: f64) -> bool {
        self.error() - 2.0 * standard_error > BROKEN
    }

    /// |emitted − absorbed − escaped − cut| over emitted, all channels together; zero in the dark.
    /// It reflects the noise of the rows: with exact ones it would be the solver's residual.
    pub fn error(&self) -> f64 {
        self.missing().abs()
    }

    /// The same with its sign: positive if emitted power is missing, negative if there is too much.
    pub fn missing(&self) -> f64 {
        let rest = (self.emitted - self.absorbed - self.escaped - self.cut).mean();
        let emitted = self.emitted.mean();
        if emitted > 0.0 { rest / emitted } else { 0.0 }
    }

    /// The share of the emitted power that is missing beyond its standard error. Power that
    /// is there too much is not light: faces that coincide all count what one of them absorbs.
    pub(crate) fn lost(&self, standard_error: f64) -> f64 {
        (self.missing() - standard_error).max(0.0)
    }
}

/// Whether this material keeps the colour of light on specular paths.
fn is_grey(m: &Material) -> bool {
    let is_glossy_grey = m.glossy().is_none_or(|lobes| lobes.mean_albedo().is_grey());
    m.mirror.is_grey() && is_glossy_grey && m.dielectric.is_none_or(|d| d.transmittance.is_grey())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_power_is_lost_light_and_too_much_is_not() {
        let balance = |absorbed: f64| EnergyBalance {
            emitted: Rgb::grey(10.0),
            absorbed: Rgb::grey(absorbed),
            escaped: Rgb::grey(4.0),
            ..EnergyBalance::default()
        };
        assert!((balance(5.0).lost(0.02) - 0.08).abs() < 1e-12);
        assert!(balance(5.9).lost(0.02) == 0.0);
        assert!(balance(8.0).lost(0.02) == 0.0);
        assert!(balance(4.5).is_broken(0.02) && !balance(4.5).is_broken(0.03));
        assert!(balance(7.5).is_broken(0.02) && !balance(5.1).is_broken(0.0));
    }
}
