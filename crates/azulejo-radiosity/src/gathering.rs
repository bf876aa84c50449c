//! Irradiance at points with the rays it took, its error by strata, and the rays that would lower it at least cost.

use crate::gathered_values::{GatheredValues, PointKind};
use crate::strata::{ErrorParts, QuarterError, Strata, StratumError};
use azulejo_trace::{Cancelled, GatherPoint, Gathered, Termination};

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

/// Fewest rays per patch or point: two for each replicate.
pub(crate) const FEWEST_RAYS: u32 = 8;

/// How many times the error of a dark stratum may be that of the law of [`Strata::permitted`]: to keep to it takes
/// several times the rays of the whole (measured in rooms); with three times it, the dark is still as exact as
/// where all points get the same rays.
const UNEVEN: f64 = 3.0;

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

impl GatherEffort {
    /// Most rays per point.
    pub(crate) fn most(&self) -> u32 {
        self.rays.clamp(1, MOST_RAYS)
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

    /// Share of the points that are path traced.
    pub fn path_traced(&self) -> f64 {
        self.strata.path_traced()
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
    pub(crate) fn allocate(&self, goal: f64, growth: f64, most: u32) -> Vec<u32> {
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
    pub(crate) fn allocate_to(&self, allowed: &[f64], growth: f64, most: u32) -> Vec<u32> {
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
