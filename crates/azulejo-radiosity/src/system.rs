//! The radiosity system B = M + ρ (H₀ + X R): its rows and its solution.
//!
//! Emission M enters through H₀, the irradiance that arrives without diffuse reflection, which is
//! exact where formulas compute it. The unknown is R = B − M, the light that leaves by diffuse
//! reflection. Four replicates of every row make four independent systems; the spread of their
//! solutions carries the noise of the rows through to the result.

use crate::deadline::PhaseWatch;
use crate::direct::direct;
use azulejo_factors::Patches;
use azulejo_factors::engine::Estimator;
use azulejo_factors::row::{Entry, Row, Side, side};
use azulejo_factors::sparse::SparseMatrix;
use azulejo_scene::{Material, Rgb};
use azulejo_trace::{Cancelled, DirectLight, Gathered, Gatherer, Measure, Progress, REPLICATES};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Rows computed between two checks of the progress.
const BLOCK: usize = 64;

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

/// The rows of all unknowns.
pub struct System {
    /// The unknowns, in the order of the matrices' rows.
    pub unknowns: Vec<Unknown>,
    /// One matrix per replicate; columns are sides.
    pub matrices: Vec<SparseMatrix>,
    /// Number of sides: twice the patches.
    pub sides: usize,
    /// Rays traced from patches.
    pub rays: u64,
}

/// Convergence of a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// Bounces of light followed.
    pub iterations: u32,
    /// Largest change of a patch in the last iteration, relative to the largest R.
    pub residual: f64,
    /// Whether iteration ended because little light was left.
    pub is_reached: bool,
}

impl Convergence {
    /// The progress of one replicate.
    pub(crate) fn measure(&self, replicate: usize) -> Measure {
        Measure::Residual {
            replicate: replicate as u32,
            iteration: self.iterations,
            value: self.residual,
        }
    }
}

impl System {
    /// Traces the rows of every side that light can reach: all fronts, then the backs that rays
    /// from reached sides hit, and so on. If no light starts in front of any surface, as in a room
    /// that is inside out, backs come first too.
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
        progress: &Progress,
    ) -> Result<Option<System>, Cancelled> {
        let materials = &gatherer.surfaces().scene.materials;
        let reflects = |p: usize| {
            let m = &materials[patches.material(p) as usize];
            !m.diffuse.is_black() || m.is_emitter()
        };
        let channels = if materials.iter().all(is_grey) { 1 } else { 3 };
        let mut system = System {
            unknowns: Vec::new(),
            matrices: vec![SparseMatrix::new(channels); REPLICATES],
            sides: 2 * patches.len(),
            rays: 0,
        };
        let mut is_planned = vec![false; system.sides];
        let mut wave: Vec<Side> = (0..patches.len())
            .filter(|&p| reflects(p))
            .map(|p| side(p as u32, true))
            .collect();
        let emits_back = |&p: &usize| materials[patches.material(p) as usize].emits_back;
        let backs = (0..patches.len()).filter(emits_back);
        wave.extend(backs.map(|p| side(p as u32, false)));
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
        while !wave.is_empty() {
            progress.begin("direct light", wave.len() as u64);
            let unknown = |&s: &Side| {
                progress.advance(1)?;
                if progress.phase_is_over() {
                    return Ok(None);
                }
                let material = &materials[patches.material((s / 2) as usize) as usize];
                let light = direct(gatherer, patches, seed, s);
                Ok(Some(Unknown::new(
                    s,
                    patches,
                    reflectance,
                    material,
                    &light,
                )))
            };
            let unknowns: Result<Option<Vec<Unknown>>, Cancelled> = wave
                .par_iter()
                .map(unknown)
                .collect::<Result<Vec<_>, _>>()
                .map(|all| all.into_iter().collect());
            let Some(mut unknowns) = unknowns? else {
                return Ok(None);
            };
            progress.begin("form factors", wave.len() as u64);
            let (watch, all) = (PhaseWatch::new(progress), wave.len() as f64);
            let mut done = 0;
            wave.clear();
            for block in unknowns.chunks_mut(BLOCK * rayon::current_num_threads().max(1)) {
                if progress.phase_is_over() || watch.is_hopeless(f64::from(done) / all) {
                    return Ok(None);
                }
                done += block.len() as u32;
                let sides: Vec<Side> = block.iter().map(|u| u.side).collect();
                let rows = estimator.rows(&sides, progress)?;
                for (u, row) in block.iter_mut().zip(&rows) {
                    u.add_row(row, |j| {
                        materials[patches.material(j) as usize].diffuse - reflectance[j]
                    });
                    system.push(row);
                    for entry in row.entries.iter().flatten() {
                        if !std::mem::replace(&mut is_planned[entry.side as usize], true) {
                            wave.push(entry.side);
                        }
                    }
                }
            }
            system.unknowns.append(&mut unknowns);
            wave.sort_unstable();
        }
        Ok(Some(system))
    }

    fn push(&mut self, row: &Row) {
        for (matrix, entries) in self.matrices.iter_mut().zip(&row.entries) {
            matrix.push_row(entries);
        }
        self.rays += u64::from(row.rays);
    }

    /// Bytes of all rows.
    pub fn bytes(&self) -> usize {
        self.matrices.iter().map(SparseMatrix::bytes).sum::<usize>()
            + self.unknowns.len() * size_of::<Unknown>()
    }

    /// Solves the system of one replicate: R per side, W/m².
    ///
    /// Jacobi iteration from R = ρ H₀, one bounce of light per iteration, until the residual is
    /// below `tolerance` or `bounces` are done. It converges since max ρ_d/(1 − ρ_s) < 1.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn solve(
        &self,
        replicate: usize,
        bounces: Option<u32>,
        tolerance: f64,
        progress: &Progress,
    ) -> Result<(Vec<Rgb>, Convergence), Cancelled> {
        let most = bounces.unwrap_or(MOST_ITERATIONS);
        let mut reflected = vec![Rgb::BLACK; self.sides];
        let mut state = Convergence {
            iterations: 0,
            residual: 0.0,
            is_reached: false,
        };
        while state.iterations < most {
            progress.advance(0)?;
            let arriving = self.arriving(replicate, &reflected);
            let next = self
                .unknowns
                .iter()
                .zip(arriving)
                .map(|(u, h)| u.reflectance * (u.unbounced(replicate) + h));
            let (mut change, mut largest) = (0f64, 0f64);
            for (u, value) in self.unknowns.iter().zip(next) {
                let old = &mut reflected[u.side as usize];
                change = change.max((value - *old).map(f64::abs).max_channel());
                largest = largest.max(value.max_channel());
                *old = value;
            }
            state.iterations += 1;
            state.residual = if largest > 0.0 { change / largest } else { 0.0 };
            progress.measured(state.measure(replicate));
            if state.residual <= tolerance {
                state.is_reached = true;
                break;
            }
        }
        Ok((reflected, state))
    }

    /// Irradiance of every unknown by diffusely reflected light.
    fn arriving(&self, replicate: usize, reflected: &[Rgb]) -> Vec<Rgb> {
        let matrix = &self.matrices[replicate];
        matrix.map_rows(|i| matrix.row_times(i, reflected))
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

impl System {
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
    fn new(
        s: Side,
        patches: &Patches,
        reflectance: &[Rgb],
        material: &Material,
        light: &DirectLight,
    ) -> Unknown {
        let emitted = patches.emission((s / 2) as usize, material, s.is_multiple_of(2));
        let exitance = emitted * PI;
        Unknown {
            side: s,
            area: patches.area((s / 2) as usize),
            reflectance: reflectance[(s / 2) as usize],
            exitance,
            direct: light.whole().replicates,
            stray: [Rgb::BLACK; REPLICATES],
            external: light.external(),
            outcomes: [Rgb::BLACK; 3],
        }
    }

    /// H₀ of one replicate.
    fn unbounced(&self, replicate: usize) -> Rgb {
        self.direct[replicate] + self.stray[replicate]
    }

    /// Adds a row; `lost` is what vertex colours and textures of a patch absorb beyond its
    /// material.
    fn add_row(&mut self, row: &Row, lost: impl Fn(usize) -> Rgb) {
        self.stray = row.stray;
        self.external += row.external;
        let share = 1.0 / REPLICATES as f64;
        let pattern = |e: &Entry| lost((e.side / 2) as usize) * e.weight * share;
        let patterns: Rgb = row.entries.iter().flatten().map(pattern).sum();
        self.outcomes = [row.absorbed + patterns, row.all_escaped(), row.cut];
    }
}

impl System {
    /// Solves all replicates.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn solve_all(
        &self,
        bounces: Option<u32>,
        progress: &Progress,
    ) -> Result<RadiositySolution, Cancelled> {
        progress.begin("bounces", REPLICATES as u64);
        let mut found = RadiositySolution::new(self.sides);
        for r in 0..REPLICATES {
            let (solution, state) = self.solve(r, bounces, TOLERANCE, progress)?;
            let mut incident = vec![Rgb::BLACK; self.sides];
            for (u, h) in self.unknowns.iter().zip(self.arriving(r, &solution)) {
                incident[u.side as usize] = u.unbounced(r) + h;
            }
            found.add_replicate(solution, &incident, state);
            progress.advance(1)?;
        }
        found.balance = self.balance(&found.mean());
        found.balance_error = self.balance_error(&found.solutions);
        (found.rays, found.bytes) = (self.rays, self.bytes());
        Ok(found)
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
    /// An empty solution over so many sides.
    pub fn new(sides: usize) -> RadiositySolution {
        RadiositySolution {
            solutions: Vec::with_capacity(REPLICATES),
            incident: vec![Rgb::BLACK; sides],
            convergence: Convergence {
                iterations: 0,
                residual: 0.0,
                is_reached: true,
            },
            balance: EnergyBalance::default(),
            balance_error: 0.0,
            rays: 0,
            bytes: 0,
        }
    }

    /// No light on so many sides: what gathers that read no patches take.
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

    /// Whether so much is missing that the solution cannot be trusted.
    pub fn is_broken(&self) -> bool {
        self.error() > BROKEN
    }

    /// |emitted − absorbed − escaped − cut| over emitted, all channels together; zero in the dark.
    /// It reflects the noise of the rows: with exact ones it would be the solver's residual.
    pub fn error(&self) -> f64 {
        self.missing().abs()
    }

    /// The same with its sign: positive if emitted power is missing, negative if there is too much.
    pub(crate) fn missing(&self) -> f64 {
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
    }
}
