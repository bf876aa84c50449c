//! Irradiance at points, to a requested error that includes the discretization.
//!
//! Reading the radiosity of patches is quick and leaves little noise, but patches that are too coarse
//! for what a point sees leave an error that no number of rays removes: light leaks into dark rooms.
//! So the points are divided into [strata](crate::strata) of brightness, and at a keyed sample of each
//! stratum irradiance is also path traced, so that its mean does not depend on the patches
//! ([`Termination::Roulette`]). Where the two differ by more than a part of the requested error, all
//! points of the stratum are path traced; elsewhere the difference is part of the stated error.

use crate::deadline::{FEWEST_RAYS, GatherPace, hasty_rays, planned_seconds};
use crate::sparse::{self, GatheredValues, PointKind};
use crate::standard_errors::standard_errors;
use crate::strata::{Strata, StratumError};
use azulejo_scene::Rgb;
use azulejo_trace::run::{LoopSize, Record, RecordReader, write_list};
use azulejo_trace::sampling::hash;
use azulejo_trace::{
    Cancelled, DiffuseLight, DirectionTables, GatherOptions, GatherPoint, Gathered, Gatherer,
    Measure, REPLICATES, Run, RunStage, SplitIrradiance, Termination,
};
use rayon::prelude::*;
use std::ops::Range;
use std::time::Instant;

/// Points gathered together: enough to fill the tracer's batches, few enough that their paths stay
/// in the cache.
pub(crate) const CHUNK: usize = 8;

/// Rays per point of the first pass to an error; later passes make a point's total a power of two
/// times this, or one and a half times that.
pub(crate) const FIRST_RAYS: u32 = 128;

/// Most rays per patch and per point of the first pass if there is a deadline: all get some light
/// soon.
pub(crate) const HASTY_RAYS: u32 = 32;

/// Most rays per point of any gather.
pub const MOST_RAYS: u32 = 1 << 17;

/// Points whose time is measured before a first pass that has a deadline.
const PACE_POINTS: u32 = 64;

/// How many more rays than are permitted a goal may take before it is said to be out of reach.
const TOLERATED: f64 = 0.1;

/// How many times the error of a dark stratum may be that of the law of [`Strata::permitted`]: to keep to it takes
/// several times the rays of the whole (measured in rooms); with three times it, the dark is still as exact as
/// where all points get the same rays.
const UNEVEN: f64 = 3.0;

/// Largest growth of a point's total per pass: early variances are too uncertain to be trusted
/// further.
const GROWTH: f64 = 8.0;

/// When gathering stops: at an error, at a number of rays, or at whichever comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatherEffort {
    /// Error of irradiance to reach, see [`Gathering::relative_error`]; `None` uses all rays.
    pub error: Option<f64>,
    /// Whether each point is to reach it, relative to its own irradiance.
    pub is_each: bool,
    /// Most rays per point.
    pub rays: u32,
    /// Which points are path traced.
    pub paths: Paths,
    /// Whether indirect light may be interpolated between points, as far as `error` permits.
    pub interpolate: bool,
}

/// Which points of a gather are path traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paths {
    /// Those where a sample shows that patches are too coarse.
    Measured,
    /// All: there is no light on patches to be read.
    Always,
}

/// The light that a gather finds at diffuse surfaces.
pub struct GatherLight<'a, L> {
    /// The light on patches.
    pub patches: &'a L,
    /// Where bounces are limited, black light for the paths, and the number of bounces: patches do
    /// not tell how often their light was reflected.
    pub limited: Option<(&'a L, u32)>,
}

impl<L> Clone for GatherLight<'_, L> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<L> Copy for GatherLight<'_, L> {}

impl<'a, L> GatherLight<'a, L> {
    /// Light on patches, and black light with the most bounces that paths may have.
    pub fn new(patches: &'a L, limited: Option<&'a (L, u32)>) -> GatherLight<'a, L> {
        GatherLight {
            patches,
            limited: limited.map(|(black, bounces)| (black, *bounces)),
        }
    }

    /// What paths with this end read, and how they end.
    fn ending(&self, termination: Termination) -> (&'a L, Termination) {
        match (termination, self.limited) {
            (Termination::Roulette, Some((black, bounces))) => {
                (black, Termination::Bounces(bounces))
            }
            _ => (self.patches, termination),
        }
    }
}

/// Why there is no irradiance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GatherError {
    /// The caller cancelled.
    Cancelled,
    /// Long after the deadline some points still had no light.
    OutOfTime,
    /// No failure: the blocks of this process are done, and another makes the result of them
    /// ([`RunRole::assembles`](azulejo_trace::RunRole::assembles)).
    Elsewhere,
}

impl From<Cancelled> for GatherError {
    fn from(_: Cancelled) -> GatherError {
        GatherError::Cancelled
    }
}

/// The points of a gather.
#[derive(Clone, Copy)]
pub struct GatherTargets<'a> {
    /// The points.
    pub points: &'a [GatherPoint],
    /// The area for which each stands, square scene units; empty if all count alike.
    pub areas: &'a [f64],
}

/// Irradiance at points, with the rays it took.
pub struct Gathering {
    /// One entry per point.
    pub gathered: Vec<Gathered>,
    /// Rays traced from each point.
    pub spent: Vec<u32>,
    /// The points by brightness, and how each stratum is gathered.
    pub strata: Strata,
    /// How many times as many rays the requested error would take; 1 if it is reached.
    pub rays_needed: f64,
    /// Points at which irradiance was gathered, if a deadline left no time for all: the others have
    /// that of one of them.
    pub records: Option<usize>,
    /// What `gathered` is computed from.
    pub(crate) values: GatheredValues,
}

impl Gathering {
    /// No light yet at this many points.
    pub fn new(targets: GatherTargets) -> Gathering {
        let count = targets.points.len();
        Gathering {
            gathered: vec![Gathered::default(); count],
            spent: vec![0; count],
            strata: Strata::new(count, targets.areas),
            rays_needed: 1.0,
            records: None,
            values: GatheredValues::everywhere(count),
        }
    }

    /// Indirect light of each point, where it is kept apart.
    pub(crate) fn indirect(&self) -> Vec<Gathered> {
        self.values.indirect()
    }

    /// Direct light of each point, where the rest is kept apart.
    pub(crate) fn direct(&self) -> &[Gathered] {
        self.values.direct()
    }

    /// Computes `gathered` again after a change of what it is computed from.
    pub(crate) fn combine(&mut self) {
        self.gathered = self.values.combined();
    }

    /// Share of the points whose indirect light is interpolated.
    pub fn interpolated(&self) -> f64 {
        let records = self.values.records();
        1.0 - records as f64 / self.gathered.len().max(1) as f64
    }

    /// Mean number of rays per point, shadow rays not counted.
    pub fn rays_per_point(&self) -> u32 {
        let rays = |(i, &spent): (usize, &u32)| match self.values.kind(i) {
            PointKind::Record => u64::from(spent),
            PointKind::Interpolated => 0,
        };
        let sum: u64 = self.spent.iter().enumerate().map(rays).sum();
        sum.div_ceil(self.spent.len().max(1) as u64) as u32
    }

    /// Estimated error: the root mean square, over points and channels, of the error of irradiance,
    /// noise and discretization, over the mean irradiance. Points count by their areas.
    pub fn relative_error(&self) -> f64 {
        let parts = self.parts();
        parts
            .noise
            .hypot(parts.discretization)
            .hypot(parts.interpolation)
    }

    /// Root mean square over the points of the standard error of each relative to its irradiance, where there is any.
    pub fn error_of_each(&self) -> f64 {
        let errors = self.standard_errors();
        let relative = |(g, error): (&Gathered, &Rgb)| {
            let mean = self.strata.mean_of(g.mean());
            (mean > 0.0).then(|| self.strata.mean_of(*error * *error) / (mean * mean))
        };
        let squares: Vec<f64> = self
            .gathered
            .iter()
            .zip(&errors)
            .filter_map(relative)
            .collect();
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
    }

    /// The error by its causes.
    pub fn parts(&self) -> ErrorParts {
        self.strata.error(&self.errors())
    }

    /// The error of each stratum.
    pub(crate) fn errors(&self) -> Vec<StratumError> {
        self.strata.errors(&self.gathered)
    }

    /// Mean irradiance and error of the quarters of the points, from dark to bright.
    pub fn quarters(&self) -> [QuarterError; 4] {
        self.strata.quarters(&self.gathered, &self.errors())
    }

    /// Standard error of every point, discretization included: the truth lies within two of them
    /// 95.4 times in 100.
    pub fn standard_errors(&self) -> Vec<Rgb> {
        standard_errors(self)
    }

    /// Share of the points that are path traced.
    pub fn path_traced(&self) -> f64 {
        self.strata.path_traced()
    }
}

/// An error by its causes, both relative to the mean irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorParts {
    /// From the number of rays.
    pub noise: f64,
    /// From the size of the patches, measured at a sample of the points.
    pub discretization: f64,
    /// From interpolating indirect light between points.
    pub interpolation: f64,
}

/// The error of a quarter of the points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QuarterError {
    /// Mean irradiance, W/m².
    pub mean: f64,
    /// Root mean square of the error, W/m².
    pub error: f64,
}

/// Gathers at all points until `effort` is reached or the progress is out of time.
///
/// To reach an error, a first pass measures the noise of each point; later ones spend rays where
/// they reduce the error most.
///
/// # Errors
/// [`GatherError`].
pub fn gather<'r>(
    gatherer: &Gatherer,
    light: GatherLight<impl DiffuseLight>,
    targets: GatherTargets,
    effort: GatherEffort,
    seed: u32,
    run: impl Into<Run<'r>>,
) -> Result<Gathering, GatherError> {
    let run = run.into();
    gather_watched(gatherer, light, targets, effort, seed, run, &mut |_| ())
}

/// As [`gather`]; passes intermediate results to `watch` after each pass but the last.
pub(crate) fn gather_watched(
    gatherer: &Gatherer,
    light: GatherLight<impl DiffuseLight>,
    targets: GatherTargets,
    effort: GatherEffort,
    seed: u32,
    run: Run,
    watch: &mut dyn FnMut(&Gathering),
) -> Result<Gathering, GatherError> {
    let pass = GatherPass {
        gatherer,
        light,
        points: targets.points,
        pace: &GatherPace::default(),
        seed,
        run,
    };
    run.progress.limit_phase(1.0);
    // Before a deadline, all points are planned together.
    let is_sparse = effort.interpolate && !effort.is_each && !run.progress.has_deadline();
    if effort.error.is_some() && is_sparse && targets.points.len() >= sparse::LEAST_POINTS {
        return sparse::gather_sparse(&pass, targets, effort, watch);
    }
    let mut all = Gathering::new(targets);
    pass.reach(&mut all, effort, watch)?;
    Ok(all)
}

/// As [`gather`] without interpolation, with indirect light apart ([`Gathering::indirect`]).
pub(crate) fn gather_split(
    gatherer: &Gatherer,
    light: GatherLight<impl DiffuseLight>,
    targets: GatherTargets,
    effort: GatherEffort,
    seed: u32,
    run: Run,
) -> Result<Gathering, GatherError> {
    let pass = GatherPass {
        gatherer,
        light,
        points: targets.points,
        pace: &GatherPace::default(),
        seed,
        run,
    };
    run.progress.limit_phase(1.0);
    let mut all = Gathering {
        values: GatheredValues::apart(&Strata::new(targets.points.len(), targets.areas)),
        ..Gathering::new(targets)
    };
    pass.reach(&mut all, effort, &mut |_| ())?;
    Ok(all)
}

impl GatherEffort {
    /// Most rays per point.
    pub(crate) fn most(&self) -> u32 {
        self.rays.clamp(1, MOST_RAYS)
    }
}

impl Gathering {
    /// How many times as many rays reach `goal`, if there is no limit to them.
    pub(crate) fn needed(&self, goal: f64) -> f64 {
        let sum = |rays: &[u32]| rays.iter().map(|&n| f64::from(n)).sum::<f64>();
        let totals = self.allocate(goal, f64::INFINITY, u32::MAX);
        sum(&totals) / sum(&self.spent).max(1.0)
    }

    /// Totals of rays that bring every stratum to its share of `goal`, each point to at most
    /// `growth` times what it has, and to `most`.
    fn allocate(&self, goal: f64, growth: f64, most: u32) -> Vec<u32> {
        self.allocate_to(&self.allowed_noise(&self.errors(), goal), growth, most)
    }

    /// The mean variance to which each stratum should be brought, so that all reach `goal` with the fewest rays,
    /// and no stratum has an error above [`UNEVEN`] times what [`permitted`](Strata::permitted) would give it.
    ///
    /// Variance falls with rays n as strength · n^−rate. With points N for a share a of the area, by Lagrange the whole
    /// is cheapest where variances are in proportion to (N/a)^(rate/(1 + rate)) · strength^(1/(1 + rate)), whose mean over
    /// the points is [`mean_strength`]. Strata that have less already leave more to the others.
    pub(crate) fn allowed_noise(&self, errors: &[StratumError], goal: f64) -> Vec<f64> {
        let permitted = self.strata.permitted(errors, goal);
        let beside = |e: &StratumError, p: f64| noise_beside(e.discretization + e.interpolation, p);
        let cheapest = |(k, e): (usize, &StratumError)| {
            let rate = noise_rate(self.strata.termination(k));
            let points_per_share =
                self.strata.points(k).len() as f64 / e.share.max(f64::MIN_POSITIVE);
            points_per_share.powf(rate / (1.0 + rate)) * mean_strength(&self.strengths(k, e), rate)
        };
        let cheapest: Vec<f64> = errors.iter().enumerate().map(cheapest).collect();
        let pairs = || errors.iter().zip(&permitted);
        let most: Vec<f64> = pairs()
            .map(|(e, p)| beside(e, UNEVEN * UNEVEN * p))
            .collect();
        if self.strata.is_each() {
            return pairs().map(|(e, &p)| beside(e, p)).collect();
        }
        let budget: f64 = pairs().map(|(e, &p)| e.share * beside(e, p)).sum();
        let allowed = |scale: f64, k: usize| most[k].min(scale * cheapest[k]);
        let noise = |scale: f64| -> f64 {
            let of = |(k, e): (usize, &StratumError)| e.share * e.noise.min(allowed(scale, k));
            errors.iter().enumerate().map(of).sum()
        };
        // The largest factor, to a thousandth, at which all together are within the budget.
        let (mut low, mut high) = (1e-12, 1e12);
        while high > 1.001 * low {
            let middle = f64::sqrt(low * high);
            if noise(middle * budget) <= budget {
                low = middle;
            } else {
                high = middle;
            }
        }
        (0..errors.len())
            .map(|k| allowed(low * budget, k))
            .collect()
    }

    /// The same for given mean variances.
    fn allocate_to(&self, allowed: &[f64], growth: f64, most: u32) -> Vec<u32> {
        let mut totals = self.spent.clone();
        let errors = self.errors();
        for (stratum, (error, &allowed)) in errors.iter().zip(allowed).enumerate() {
            if error.noise <= allowed {
                continue;
            }
            let rate = noise_rate(self.strata.termination(stratum));
            let strengths = self.strengths(stratum, error);
            for (i, rays) in cheapest(&strengths, rate, allowed) {
                let total = &mut totals[i as usize];
                *total = well_spread(*total, rays.min(growth * f64::from(*total)), most);
            }
        }
        totals
    }

    /// Variance times rays^rate of every point of a stratum, by its part of the stratum's area relative to the mean, and
    /// the cost of its rays.
    pub(crate) fn strengths(&self, stratum: usize, error: &StratumError) -> Vec<(f64, f64, u32)> {
        let rate = noise_rate(self.strata.termination(stratum));
        let points = self.strata.points(stratum);
        let weight = |i: usize| self.strata.weight(i);
        let mean_weight =
            points.iter().map(|&i| weight(i as usize)).sum::<f64>() / points.len() as f64;
        let own = |i: usize| {
            let variance = self.strata.mean_of(self.values.variance(i, weight(i)));
            variance * error.gain * f64::from(self.spent[i]).powf(rate) / mean_weight
        };
        // What the rays of points of equal areas leave, as far as they are alike.
        let shared = self.values.mean_by_kind(points, &|i| own(i) / weight(i));
        let strength = |&i: &u32| {
            let i = i as usize;
            let kind = self.values.kind(i);
            let (shared, spent) = (shared[kind as usize] * weight(i), self.spent[i]);
            // Four replicates estimate a point's variance badly; half of it is taken from all. Of few
            // rays, all is: points that miss a rare light would be believed to be dark, and stay so.
            let is_known = spent >= FIRST_RAYS || kind == PointKind::Interpolated;
            let own = if is_known { own(i) } else { shared };
            (0.5 * (own + shared), kind.cost(), i as u32)
        };
        points.iter().map(strength).collect()
    }
}

/// What the patches and interpolation leave to noise of a mean square error, and never less than a part.
pub(crate) fn noise_beside(fixed: f64, permitted: f64) -> f64 {
    (permitted - fixed).max(0.25 * permitted)
}

/// Decline of the variance with rays n, about n^−rate.
pub(crate) fn noise_rate(termination: Termination) -> f64 {
    match termination {
        // Measured: between random, 1, and 2-D strata, 3/2.
        Termination::Radiosity => 1.2,
        // All but the first direction of a path is random.
        Termination::Roulette | Termination::Bounces(_) => 1.0,
    }
}

/// The mean of strength^(1/(1 + rate)) · cost^(rate/(1 + rate)), to which the cost of an error is in
/// proportion.
pub(crate) fn mean_strength(strengths: &[(f64, f64, u32)], rate: f64) -> f64 {
    let power = 1.0 / (1.0 + rate);
    let term = |s: &(f64, f64, u32)| s.0.powf(power) * s.1.powf(rate * power);
    strengths.iter().map(term).sum::<f64>() / strengths.len().max(1) as f64
}

/// Rays that make the mean variance of points `allowed` at least cost, given the strength of each
/// and the cost of its rays.
///
/// A point's variance falls with its rays n as strength n^−rate; the sum of costs is then least for n
/// in proportion to (strength/cost)^(1/(1 + rate)), by Lagrange.
fn cheapest(
    strengths: &[(f64, f64, u32)],
    rate: f64,
    allowed: f64,
) -> impl Iterator<Item = (u32, f64)> {
    let power = 1.0 / (1.0 + rate);
    let mean = mean_strength(strengths, rate);
    let scale = (mean / allowed.max(f64::MIN_POSITIVE)).powf(1.0 / rate);
    strengths
        .iter()
        .map(move |&(s, cost, i)| (i, scale * (s / cost).powf(power)))
}

/// The constants of all passes.
#[derive(Clone, Copy)]
pub(crate) struct GatherPass<'a, L> {
    pub gatherer: &'a Gatherer<'a>,
    pub light: GatherLight<'a, L>,
    pub points: &'a [GatherPoint],
    pub pace: &'a GatherPace,
    pub seed: u32,
    pub run: Run<'a>,
}

/// A group of points that are gathered alike: from this many rays, to this many, ending so, and whether
/// their indirect light is gathered at all.
type Way = (u32, u32, Termination, PointKind);

impl<L: DiffuseLight> GatherPass<'_, L> {
    /// Rays of the first pass before a deadline, from the pace of a keyed sample; `None` if there is no
    /// time for all points.
    fn hasty(&self, all: &Gathering) -> Result<Option<u32>, GatherError> {
        let count = self.points.len() as u32;
        let key = |k: u32| hash(&[self.seed, k, 0x9ace]) % count.max(1);
        let sample: Vec<u32> = (0..count.min(PACE_POINTS)).map(key).collect();
        let termination = all.strata.termination(0);
        self.gather_at(&sample, 0..FEWEST_RAYS, termination)?;
        let seconds = self.pace.seconds_per_ray(termination);
        Ok(hasty_rays(self.points.len(), seconds, self.run.progress))
    }

    /// Says early if the goal will not be reached, and what it would take.
    fn forecast(&self, all: &Gathering, goal: f64, most: u32) {
        let sum = |rays: &[u32]| rays.iter().map(|&n| f64::from(n)).sum::<f64>();
        let [free, capped] =
            [u32::MAX, most].map(|most| sum(&all.allocate(goal, f64::INFINITY, most)));
        let seconds = all.seconds_needed(goal, self.pace);
        let left = self.run.progress.time_left();
        let is_late = left.is_some_and(|left| seconds > left.as_secs_f64());
        if is_late || free > (1.0 + TOLERATED) * capped {
            self.run.progress.measured(Measure::OutOfReach {
                error: goal,
                seconds,
                rays: free / self.points.len().max(1) as f64,
            });
        }
    }

    /// Seconds in which all points get this many rays.
    fn seconds_to_all(&self, all: &Gathering, most: u32) -> f64 {
        let seconds = |k: usize| {
            let whole = all.strata.points(k).len() as f64 * f64::from(most);
            let pace = self.pace.seconds_per_ray(all.strata.termination(k));
            (whole - all.spent_on(k)).max(0.0) * pace
        };
        (0..all.strata.count()).map(seconds).sum()
    }

    /// Gathers from nothing until `effort` is reached or the progress is out of time; passes
    /// intermediate results to `watch` after each pass but the last.
    pub fn reach(
        &self,
        all: &mut Gathering,
        effort: GatherEffort,
        watch: &mut dyn FnMut(&Gathering),
    ) -> Result<(), GatherError> {
        let most = effort.most();
        if effort.paths == Paths::Always {
            all.strata.trace_paths(0);
        }
        if effort.is_each {
            all.strata.ask_each();
        }
        let rays = match effort.error {
            _ if self.run.progress.has_deadline() => match self.hasty(all)? {
                Some(rays) => rays.min(most),
                None => return self.reach_coarsely(all, effort.error, most),
            },
            Some(_) => FIRST_RAYS.min(most),
            None => most,
        };
        self.begin(all, rays)?;
        if all.spent.contains(&0) {
            return Err(GatherError::OutOfTime);
        }
        all.strata.divide(&all.gathered);
        if effort.paths == Paths::Measured {
            self.validate(all, effort.error, most)?;
        }
        if let Some(goal) = effort.error {
            self.forecast(all, goal, most);
        }
        self.spend(all, effort, watch)
    }

    /// Spends rays where they reduce the error most until `effort` is reached or the phase is over.
    pub fn spend(
        &self,
        all: &mut Gathering,
        effort: GatherEffort,
        watch: &mut dyn FnMut(&Gathering),
    ) -> Result<(), GatherError> {
        let most = effort.most();
        loop {
            self.run
                .progress
                .measured(Measure::Error(all.relative_error()));
            if let Some(goal) = effort.error {
                all.rays_needed = all.needed(goal);
            }
            let seconds = planned_seconds(self.run.progress);
            let totals = match effort.error {
                None if self.seconds_to_all(all, most) <= seconds => vec![most; all.spent.len()],
                Some(goal) if seconds.is_infinite() => all.allocate(goal, GROWTH, most),
                goal => {
                    let goal = goal.unwrap_or(0.0);
                    let allowed = all.noise_within_reach(goal, seconds, self.pace);
                    all.allocate_to(&allowed, GROWTH, most)
                }
            };
            if self.run.progress.phase_is_over() || totals == all.spent {
                return Ok(());
            }
            watch(all);
            self.raise(all, &totals)?;
        }
    }

    /// Gathers with so many rays at all points, which have none yet, in blocks that are stored and
    /// divided. What there is time for before a deadline is not kept.
    fn begin(&self, all: &mut Gathering, rays: u32) -> Result<(), GatherError> {
        let is_divided = self.run.role().is_kept && !self.run.is_shared();
        if self.run.progress.has_deadline() || !is_divided {
            return Ok(self.raise(all, &vec![rays; self.points.len()])?);
        }
        let termination = all.strata.termination(0);
        let count = self.points.len();
        let size = LoopSize {
            items: count.div_ceil(CHUNK),
            block: block_chunks(rays),
            at_once: block_chunks(rays),
        };
        let own = self.run.own_items(size.items);
        self.run.progress.begin("irradiance", (own * CHUNK) as u64);
        let chunks = self.run.resumed(RunStage::Points, size, |chunks| {
            let of = |&chunk: &usize| (chunk * CHUNK) as u32..count.min((chunk + 1) * CHUNK) as u32;
            let chosen: Vec<u32> = chunks.iter().flat_map(of).collect();
            let irradiance = self.gather_at(&chosen, 0..rays, termination)?;
            Ok(irradiance
                .chunks(CHUNK)
                .map(|c| PointChunk(c.to_vec()))
                .collect())
        })?;
        let chunks = chunks.ok_or(GatherError::Elsewhere)?;
        let irradiance = chunks.iter().flat_map(|chunk| &chunk.0);
        for (i, new) in irradiance.flatten().enumerate() {
            all.values.add(i, new, 1.0);
            all.spent[i] = rays;
        }
        all.combine();
        Ok(())
    }

    /// Raises every point to its total, in groups with the same start and total; points keep what
    /// they have when time runs out.
    pub fn raise(&self, all: &mut Gathering, totals: &[u32]) -> Result<(), Cancelled> {
        let way = |i: usize| -> Way {
            let termination = all.strata.termination_of(i);
            (all.spent[i], totals[i], termination, all.values.kind(i))
        };
        let groups: Vec<Way> = (0..totals.len()).map(way).collect();
        let mut ways: Vec<Way> = groups.iter().copied().filter(|w| w.1 > w.0).collect();
        self.run.progress.begin("irradiance", ways.len() as u64);
        ways.sort_unstable();
        ways.dedup();
        let chosen = |way: &Way| -> Vec<u32> {
            let points = 0..groups.len() as u32;
            points.filter(|&i| groups[i as usize] == *way).collect()
        };
        let of_ways: Vec<Vec<u32>> = ways.iter().map(chosen).collect();
        for batch in batches(&ways, self.run.progress.has_deadline()) {
            let (ways, of_ways) = (&ways[batch.clone()], &of_ways[batch]);
            let pairs = ways.iter().zip(of_ways);
            let together: Vec<PointGroup> = pairs
                .map(|(way, chosen)| self.group_of(way, chosen))
                .collect();
            let light = self.gather_groups(&together)?;
            for ((&(spent, total, ..), chosen), light) in ways.iter().zip(of_ways).zip(light) {
                for (&i, new) in chosen.iter().zip(light) {
                    if let Some(new) = new {
                        let share = f64::from(total - spent) / f64::from(total);
                        all.values.add(i as usize, &new, share);
                        all.spent[i as usize] = total;
                    }
                }
            }
        }
        all.combine();
        Ok(())
    }

    /// Gathers once at the chosen points with a range of their rays; `None` where time ran out.
    pub fn gather_at(
        &self,
        chosen: &[u32],
        rays: Range<u32>,
        termination: Termination,
    ) -> Result<Vec<Option<SplitIrradiance>>, Cancelled> {
        self.gather_group(self.irradiance_group(chosen, rays, termination))
    }

    /// Whether there is no time for rays from this one on: the first of a point have some grace.
    fn is_over(&self, first_ray: u32) -> bool {
        match first_ray {
            0 => self.run.progress.is_overdue(),
            _ => self.run.progress.phase_is_over(),
        }
    }

    /// Gathers once at each list of points with its range of their rays, in one loop that processes share; `None` where
    /// time ran out, if that is minded.
    pub fn gather_lists(
        &self,
        lists: &[PointList],
        minds_time: bool,
    ) -> Result<Vec<Vec<Option<SplitIrradiance>>>, Cancelled> {
        let groups = lists.iter().map(|list| {
            let (points, rays) = (&list.points, list.rays.clone());
            let group = if list.has_direct {
                self.irradiance_group(points, rays, list.termination)
            } else {
                self.indirect_group(points, rays, list.termination)
            };
            PointGroup {
                minds_time,
                ..group
            }
        });
        self.gather_groups(&groups.collect::<Vec<_>>())
    }

    /// Points that go the same way.
    fn group_of<'g>(&'g self, way: &Way, chosen: &'g [u32]) -> PointGroup<'g> {
        let &(spent, total, termination, kind) = way;
        match kind {
            PointKind::Record => self.irradiance_group(chosen, spent..total, termination),
            PointKind::Interpolated => self.direct_group(chosen, spent..total),
        }
    }

    /// Points whose irradiance is gathered with a range of their rays.
    fn irradiance_group<'g>(
        &'g self,
        chosen: &'g [u32],
        rays: Range<u32>,
        termination: Termination,
    ) -> PointGroup<'g> {
        let (light, ending) = self.light.ending(termination);
        let options = self.options(&rays, ending);
        let directions = DirectionTables::new(&options);
        PointGroup {
            chosen,
            rays,
            minds_time: true,
            gather: Box::new(move |points| {
                let start = Instant::now();
                let irradiance = self
                    .gatherer
                    .gather_with(points, &options, &directions, light);
                let rays = points.len() as u64 * u64::from(options.rays);
                self.pace.add(termination, rays, start.elapsed());
                irradiance
            }),
        }
    }

    /// Points whose indirect light alone is gathered.
    fn indirect_group<'g>(
        &'g self,
        chosen: &'g [u32],
        rays: Range<u32>,
        termination: Termination,
    ) -> PointGroup<'g> {
        let (light, ending) = self.light.ending(termination);
        let options = self.options(&rays, ending);
        let directions = DirectionTables::new(&options);
        let split = |indirect| SplitIrradiance {
            direct: Gathered::default(),
            indirect,
        };
        PointGroup {
            chosen,
            rays,
            minds_time: true,
            gather: Box::new(move |points| {
                let gatherer = self.gatherer;
                let indirect = gatherer.gather_indirect(points, &options, &directions, light);
                indirect.into_iter().map(split).collect()
            }),
        }
    }

    /// Points at which direct light alone is gathered.
    fn direct_group<'g>(&'g self, chosen: &'g [u32], rays: Range<u32>) -> PointGroup<'g> {
        let options = self.options(&rays, Termination::Radiosity);
        let split = |direct| SplitIrradiance {
            direct,
            indirect: Gathered::default(),
        };
        PointGroup {
            chosen,
            rays,
            minds_time: true,
            gather: Box::new(move |points| {
                let direct = self.gatherer.gather_direct(points, &options);
                direct.into_iter().map(split).collect()
            }),
        }
    }

    fn options(&self, rays: &Range<u32>, termination: Termination) -> GatherOptions {
        GatherOptions {
            rays: rays.end - rays.start,
            spent: rays.start,
            seed: self.seed,
            termination,
        }
    }

    fn gather_group(&self, group: PointGroup) -> Result<Vec<Option<SplitIrradiance>>, Cancelled> {
        let irradiance = self.gather_groups(&[group])?;
        Ok(irradiance.into_iter().flatten().collect())
    }

    /// Gathers at the points of all groups, in one loop that processes share; `None` where time ran out.
    fn gather_groups(
        &self,
        groups: &[PointGroup],
    ) -> Result<Vec<Vec<Option<SplitIrradiance>>>, Cancelled> {
        let of_group = |(number, group): (usize, &PointGroup)| {
            let size = CHUNK * step_chunks(group.rays.len() as u32);
            let starts = (0..group.chosen.len()).step_by(size);
            let end = |start: usize| (start + size).min(group.chosen.len());
            starts
                .map(move |start| (number, start..end(start)))
                .collect::<Vec<_>>()
        };
        let pieces: Vec<(usize, Range<usize>)> =
            groups.iter().enumerate().flat_map(of_group).collect();
        let of_chunk = |group: &PointGroup, chunk: &[u32]| {
            self.run.progress.advance(chunk.len() as u64)?;
            if group.minds_time && self.is_over(group.rays.start) {
                return Ok(vec![None; chunk.len()]);
            }
            let points: Vec<GatherPoint> = chunk.iter().map(|&i| self.points[i as usize]).collect();
            Ok((group.gather)(&points).into_iter().map(Some).collect())
        };
        let of_piece = |&piece: &usize| {
            let (number, range) = &pieces[piece];
            let group = &groups[*number];
            let chunks = group.chosen[range.clone()].par_chunks(CHUNK);
            let irradiance: Result<Vec<Vec<_>>, Cancelled> =
                chunks.map(|chunk| of_chunk(group, chunk)).collect();
            Ok(PointChunk(irradiance?.concat()))
        };
        let irradiance = self.run.shared((pieces.len(), 1), |indices| {
            indices.par_iter().map(of_piece).collect()
        })?;
        let mut of_groups: Vec<Vec<Option<SplitIrradiance>>> = vec![Vec::new(); groups.len()];
        for ((number, _), piece) in pieces.iter().zip(irradiance) {
            of_groups[*number].extend(piece.0);
        }
        Ok(of_groups)
    }
}

/// Ways that are gathered in one loop, so that processes that share the work meet once: as many as leave the tables
/// of directions small; before a deadline one after the other, those of fewest rays first.
fn batches(ways: &[Way], has_deadline: bool) -> Vec<Range<usize>> {
    let mut batches: Vec<Range<usize>> = Vec::new();
    let mut rays = 0;
    for (number, &(spent, total, ..)) in ways.iter().enumerate() {
        rays += total - spent;
        match batches.last_mut() {
            Some(batch) if rays <= MOST_RAYS && !has_deadline => batch.end = number + 1,
            _ => {
                rays = total - spent;
                batches.push(number..number + 1);
            }
        }
    }
    batches
}

/// Points that are gathered alike, all of them.
pub struct PointList {
    /// Their numbers.
    pub points: Vec<u32>,
    /// Which rays of each.
    pub rays: Range<u32>,
    /// How their paths end.
    pub termination: Termination,
    /// Whether direct light is gathered, too.
    pub has_direct: bool,
}

/// The light at points that are gathered together.
type BatchGather<'g> = dyn Fn(&[GatherPoint]) -> Vec<SplitIrradiance> + Sync + 'g;

/// Points that are gathered alike.
struct PointGroup<'g> {
    /// Their numbers.
    chosen: &'g [u32],
    /// Which rays of each.
    rays: Range<u32>,
    /// Whether points are left out once time is over.
    minds_time: bool,
    /// The light of some of them.
    gather: Box<BatchGather<'g>>,
}

/// Rays of a block that is stored, about, and fewest and most of its chunks.
const BLOCK_RAYS: usize = 1 << 20;
const BLOCK: [usize; 2] = [32, 4096];

/// Chunks of a block that is stored.
fn block_chunks(rays: u32) -> usize {
    (BLOCK_RAYS / (CHUNK * rays.max(1) as usize)).clamp(BLOCK[0], BLOCK[1])
}

/// Rays of a block that processes share, about: some milliseconds of one thread; and most of its chunks.
const STEP_RAYS: usize = 1 << 15;
const STEP: usize = 512;

/// Chunks of a block that processes share.
fn step_chunks(rays: u32) -> usize {
    (STEP_RAYS / (CHUNK * rays.max(1) as usize)).clamp(1, STEP)
}

/// Points that were gathered together; `None` where time ran out.
struct PointChunk(Vec<Option<SplitIrradiance>>);

impl Record for PointChunk {
    fn write(&self, bytes: &mut Vec<u8>) {
        write_list(&self.0, bytes, |point, bytes| {
            let both = point.map(|p| [p.direct.replicates, p.indirect.replicates]);
            both.write(bytes);
        });
    }

    fn read(bytes: &mut RecordReader) -> Option<PointChunk> {
        let points = bytes.list(Option::<[[Rgb; REPLICATES]; 2]>::read)?;
        let split = |[direct, indirect]: [[Rgb; REPLICATES]; 2]| {
            let [direct, indirect] = [direct, indirect].map(|replicates| Gathered { replicates });
            SplitIrradiance { direct, indirect }
        };
        let points = points.into_iter().map(|point| point.map(split));
        Some(PointChunk(points.collect()))
    }

    fn is_complete(&self) -> bool {
        self.0.iter().all(Option::is_some)
    }
}

/// The total nearest to `wanted`, from `spent` to `most`, that is well distributed: a power of two,
/// or one and a half times one, in units of the first pass.
pub(crate) fn well_spread(spent: u32, wanted: f64, most: u32) -> u32 {
    let below = [FEWEST_RAYS, 16, 32, 48, 64, 96].into_iter();
    let totals = (0..24).map(|k| ((FIRST_RAYS * [2, 3][k as usize % 2]) << (k / 2)) / 2);
    let enough = |&t: &u32| t >= spent && f64::from(t) >= 0.85 * wanted;
    below
        .chain(totals)
        .find(enough)
        .unwrap_or(most)
        .clamp(spent, most.max(spent))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_gathered_together_while_their_tables_are_small() {
        let way =
            |(spent, total): (u32, u32)| (spent, total, Termination::Radiosity, PointKind::Record);
        let of = |rays: &[(u32, u32)], has_deadline: bool| -> Vec<(usize, usize)> {
            let ways: Vec<Way> = rays.iter().copied().map(way).collect();
            let spans = batches(&ways, has_deadline);
            spans.iter().map(|batch| (batch.start, batch.end)).collect()
        };
        assert_eq!(of(&[], false), []);
        assert_eq!(of(&[(0, 128), (0, 256), (128, 512)], false), [(0, 3)]);
        assert_eq!(of(&[(0, 128), (0, 256)], true), [(0, 1), (1, 2)]);
        let most = MOST_RAYS;
        let rays = [(0, 1), (0, most), (0, most - 1), (5, 6)];
        assert_eq!(of(&rays, false), [(0, 1), (1, 2), (2, 4)]);
    }
}
