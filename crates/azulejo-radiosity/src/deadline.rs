//! What the time until a deadline suffices for: rays per patch, the error within reach, and where
//! paths pay.
//!
//! Times are measured, never assumed: that of a keyed sample before the work, and that of all rays
//! gathered so far. So results under a deadline depend on the machine; without one, nothing here
//! is asked.

use crate::direct::direct;
use crate::gathering::{
    FEWEST_RAYS, Gathering, HASTY_RAYS, mean_strength, noise_beside, noise_rate,
};
use crate::strata::StratumError;
use azulejo_factors::estimator::Estimator;
use azulejo_factors::row::{Columns, Side, side};
use azulejo_factors::{Engine, Patches};
use azulejo_trace::sampling::hash;
use azulejo_trace::time::{Duration, Instant};
use azulejo_trace::{Cancelled, Gatherer, Progress, Termination};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Sides of patches that are timed together before all others are begun.
const TIMED: usize = 1024;

/// Neighbours among them.
const TIMED_RUN: usize = 128;

/// Share of a phase for that.
const TIMING_SHARE: f64 = 0.02;

/// Share of the sides that light reaches: all fronts, and of the backs some.
const REACHED: f64 = 0.75;

/// Share of a phase, or of the time that is left, for which work is planned: predicted times are
/// uncertain, and numbers of rays are rounded.
const PLANNED: f64 = 0.85;

/// Share of the time that is left for the first rays of all points.
const FIRST_SHARE: f64 = 0.4;

/// How many times the time that is left a stage may seem to take before it is given up.
const HOPELESS: f64 = 1.5;

/// Share of a phase after which its end is foreseen.
const SOON: f64 = 0.15;

/// Most rays per patch, of 32, 16 and 8, with which all rows are done in the phase of `progress`, or
/// any number without a deadline; `None` if not even the fewest are. A keyed sample of the sides is timed.
///
/// # Errors
/// [`Cancelled`].
pub(crate) fn affordable_patch_rays(
    gatherer: &Gatherer,
    patches: &Patches,
    seed: u32,
    progress: &Progress,
) -> Result<Option<u32>, Cancelled> {
    let sides = 2 * patches.len();
    let Some(left) = progress.phase_left() else {
        return Ok(Some(u32::MAX));
    };
    if sides <= TIMED {
        return Ok(Some(HASTY_RAYS));
    }
    let (engine, columns) = (Engine::Rays, Columns::Diffuse);
    let estimator = Estimator::new(&engine, gatherer, patches, HASTY_RAYS, seed, columns);
    let start = Instant::now();
    let (mut formulas, mut rows, mut timed) = (0.0, 0.0, 0);
    // Time slices of a busy machine are longer than a small sample takes.
    while timed < TIMED || start.elapsed() < left.mul_f64(TIMING_SHARE) {
        // Neighbours, as in the work itself, where they share what is in the cache.
        let place = |k: usize| {
            let first = hash(&[seed, (k / TIMED_RUN) as u32, 0x51de]) as usize % patches.len();
            side(((first + k % TIMED_RUN) % patches.len()) as u32, true)
        };
        let sample: Vec<Side> = (timed..timed + TIMED).map(place).collect();
        let begun = Instant::now();
        sample.par_iter().for_each(|&s| {
            direct(gatherer, patches, seed, s);
        });
        formulas += begun.elapsed().as_secs_f64();
        estimator.rows(&sample, progress)?;
        rows += begun.elapsed().as_secs_f64();
        timed += TIMED;
    }
    rows -= formulas;
    let all = REACHED * sides as f64 / timed as f64;
    let fits = |rays: u32, share: f64| {
        let rows = rows * f64::from(rays) / f64::from(HASTY_RAYS);
        (formulas + rows) * all <= share * left.as_secs_f64()
    };
    let comfortable = [HASTY_RAYS, HASTY_RAYS / 2].into_iter();
    let most = comfortable.into_iter().find(|&rays| fits(rays, 0.4));
    Ok(most.or(fits(FEWEST_RAYS, 1.0).then_some(FEWEST_RAYS)))
}

/// Foresees whether a stage of equal steps ends within the phase of a progress.
pub(crate) struct PhaseWatch<'a> {
    progress: &'a Progress,
    /// Time until the end of the phase when the stage began; `None` without a deadline.
    begun: Option<Duration>,
}

impl<'a> PhaseWatch<'a> {
    /// Begins to watch.
    pub fn new(progress: &'a Progress) -> PhaseWatch<'a> {
        PhaseWatch {
            progress,
            begun: progress.phase_left(),
        }
    }

    /// Whether the phase is over, or will be before the stage is, of which a `share` is done: so
    /// that what is left of the time can be used otherwise.
    pub fn is_hopeless(&self, share: f64) -> bool {
        let (Some(begun), Some(left)) = (self.begun, self.progress.phase_left()) else {
            return false;
        };
        let (begun, left) = (begun.as_secs_f64(), left.as_secs_f64());
        let spent = begun - left;
        left <= 0.0 || (spent > SOON * begun && spent > HOPELESS * share * begun)
    }
}

/// The time that rays from points took, by how they end.
#[derive(Debug, Default)]
pub(crate) struct GatherPace {
    read: PaceOf,
    paths: PaceOf,
}

#[derive(Debug, Default)]
struct PaceOf {
    nanoseconds: AtomicU64,
    rays: AtomicU64,
}

impl GatherPace {
    fn of(&self, termination: Termination) -> &PaceOf {
        match termination {
            Termination::Radiosity => &self.read,
            Termination::Roulette | Termination::Bounces(_) => &self.paths,
        }
    }

    /// Adds what one thread did.
    pub fn add(&self, termination: Termination, rays: u64, time: Duration) {
        let of = self.of(termination);
        of.rays.fetch_add(rays, Ordering::Relaxed);
        let nanoseconds = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        of.nanoseconds.fetch_add(nanoseconds, Ordering::Relaxed);
    }

    /// Seconds per ray when all threads work; zero if none was traced.
    pub fn seconds_per_ray(&self, termination: Termination) -> f64 {
        let of = self.of(termination);
        let rays = of.rays.load(Ordering::Relaxed).max(1) as f64;
        let threads = rayon::current_num_threads().max(1) as f64;
        of.nanoseconds.load(Ordering::Relaxed) as f64 * 1e-9 / (rays * threads)
    }
}

/// Seconds that are left for planned work; infinite without a deadline.
pub(crate) fn planned_seconds(progress: &Progress) -> f64 {
    let left = progress.time_left();
    left.map_or(f64::INFINITY, |left| PLANNED * left.as_secs_f64())
}

/// Rays of the first pass over this many points, of 32, 16 and 8; `None` if even the fewest would end
/// after the deadline.
pub(crate) fn hasty_rays(points: usize, seconds_per_ray: f64, progress: &Progress) -> Option<u32> {
    let left = progress.time_left()?.as_secs_f64();
    let time = |rays: u32| points as f64 * f64::from(rays) * seconds_per_ray;
    let all = [HASTY_RAYS, HASTY_RAYS / 2, FEWEST_RAYS];
    let most = all
        .into_iter()
        .find(|&rays| time(rays) <= FIRST_SHARE * left);
    most.or((time(FEWEST_RAYS) <= PLANNED * left).then_some(FEWEST_RAYS))
}

/// What one stratum costs and gains, either way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StratumWays {
    /// Share of the area.
    pub share: f64,
    /// Mean square error by discretization if patches are read, (W/m²)².
    pub discretization: f64,
    /// Mean variance times seconds, if patches are read and if paths are traced: what the variance
    /// is after a second of work on the stratum.
    pub strength: [f64; 2],
    /// Seconds that the fewest paths from all its points take.
    pub fewest: f64,
}

/// Which strata should be path traced, so that the whole error is least after `seconds` of work. The
/// strata are at most eight, so all sets are compared.
///
/// Within a set, the sum of share · strength / time is least for times in proportion to
/// √(share · strength), by Lagrange.
pub(crate) fn best_ways(strata: &[StratumWays], seconds: f64) -> Vec<bool> {
    let is_traced = |set: u32, k: usize| set >> k & 1 == 1;
    let root = |set: u32, k: usize| {
        let s = &strata[k];
        (s.share * s.strength[usize::from(is_traced(set, k))]).sqrt()
    };
    let error = |set: u32| {
        let sum: f64 = (0..strata.len()).map(|k| root(set, k)).sum();
        let (mut square, mut is_possible) = (sum * sum / seconds, true);
        for (k, s) in strata.iter().enumerate() {
            if !is_traced(set, k) {
                square += s.share * s.discretization;
            } else if seconds * root(set, k) < s.fewest * sum {
                is_possible = false;
            }
        }
        if is_possible { square } else { f64::INFINITY }
    };
    let sets = 0..1u32 << strata.len();
    let best = sets.min_by(|&a, &b| error(a).total_cmp(&error(b)));
    let best = best.unwrap_or(0);
    (0..strata.len()).map(|k| is_traced(best, k)).collect()
}

/// Seconds of work that bring all strata to their `permitted` mean square errors, if some are path
/// traced.
pub(crate) fn seconds_for(strata: &[StratumWays], is_traced: &[bool], permitted: &[f64]) -> f64 {
    let all = strata.iter().zip(is_traced).zip(permitted);
    let seconds = |((s, &is_traced), &permitted): ((&StratumWays, &bool), &f64)| {
        let noise = if is_traced {
            permitted
        } else {
            noise_beside(s.discretization, permitted)
        };
        s.strength[usize::from(is_traced)] / noise.max(f64::MIN_POSITIVE)
    };
    all.map(seconds).sum()
}

/// What brings one stratum to an error.
struct StratumDemand {
    error: StratumError,
    /// Of its noise with its rays.
    rate: f64,
    /// Points, and their [`mean_strength`].
    points: f64,
    mean: f64,
    /// Seconds spent so far, and per ray.
    spent: f64,
    seconds_per_ray: f64,
}

impl StratumDemand {
    /// Seconds until the noise of the stratum is `allowed`.
    fn seconds(&self, allowed: f64) -> f64 {
        if self.error.noise <= allowed {
            return 0.0;
        }
        let scale = (self.mean / allowed.max(f64::MIN_POSITIVE)).powf(1.0 / self.rate);
        (self.points * self.mean * scale * self.seconds_per_ray - self.spent).max(0.0)
    }
}

impl Gathering {
    /// The mean variance to which each stratum should be brought by `seconds` of rays: what `goal`
    /// asks if there is time for it, or else what makes the whole noise least.
    ///
    /// Variance falls in proportion to the time on a stratum, about; so that is
    /// √(share · variance · time) over all strata that shall have more than they have, by Lagrange.
    pub(crate) fn noise_within_reach(
        &self,
        goal: f64,
        seconds: f64,
        pace: &GatherPace,
    ) -> Vec<f64> {
        let demands = self.demands(pace);
        let allowed = self.allowed_by(goal, &demands);
        if seconds_to(&allowed, &demands) <= seconds {
            return allowed;
        }
        let root = |d: &StratumDemand| (d.error.share * d.error.noise * d.spent).sqrt();
        let mut is_open = vec![true; demands.len()];
        loop {
            let open = || demands.iter().zip(&is_open).filter(|x| *x.1).map(|x| x.0);
            let budget = seconds + open().map(|d| d.spent).sum::<f64>();
            let roots = open().map(root).sum::<f64>().max(f64::MIN_POSITIVE);
            let time = |d: &StratumDemand| budget * root(d) / roots;
            let has_enough = |k: &usize| is_open[*k] && time(&demands[*k]) < demands[*k].spent;
            let enough: Vec<usize> = (0..demands.len()).filter(has_enough).collect();
            if enough.is_empty() {
                let noise = |(d, &is_open): (&StratumDemand, &bool)| {
                    let share = if is_open { d.spent / time(d) } else { 1.0 };
                    d.error.noise * if share.is_finite() { share } else { 1.0 }
                };
                return demands.iter().zip(&is_open).map(noise).collect();
            }
            enough.into_iter().for_each(|k| is_open[k] = false);
        }
    }

    /// Seconds of rays that bring every stratum to its share of `goal`.
    pub(crate) fn seconds_needed(&self, goal: f64, pace: &GatherPace) -> f64 {
        let demands = self.demands(pace);
        seconds_to(&self.allowed_by(goal, &demands), &demands)
    }

    fn demands(&self, pace: &GatherPace) -> Vec<StratumDemand> {
        let demand = |(k, error): (usize, StratumError)| {
            let termination = self.strata.termination(k);
            let rate = noise_rate(termination);
            let strengths = self.strengths(k, &error);
            let seconds_per_ray = pace.seconds_per_ray(termination);
            StratumDemand {
                error,
                rate,
                points: strengths.len() as f64,
                mean: mean_strength(&strengths, rate),
                spent: self.spent_on(k) * seconds_per_ray,
                seconds_per_ray,
            }
        };
        self.errors().into_iter().enumerate().map(demand).collect()
    }

    fn allowed_by(&self, goal: f64, demands: &[StratumDemand]) -> Vec<f64> {
        let errors: Vec<StratumError> = demands.iter().map(|d| d.error).collect();
        self.allowed_noise(&errors, goal)
    }

    /// Rays traced from all points of a stratum, times their costs.
    pub(crate) fn spent_on(&self, stratum: usize) -> f64 {
        let cost = |&i: &u32| {
            let i = i as usize;
            f64::from(self.spent[i]) * self.values.kind(i).cost()
        };
        self.strata.points(stratum).iter().map(cost).sum()
    }
}

/// Seconds of rays that bring every stratum to what is allowed.
fn seconds_to(allowed: &[f64], demands: &[StratumDemand]) -> f64 {
    demands
        .iter()
        .zip(allowed)
        .map(|(d, &a)| d.seconds(a))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn way(discretization: f64, read: f64, paths: f64, fewest: f64) -> StratumWays {
        StratumWays {
            share: 0.5,
            discretization,
            strength: [read, paths],
            fewest,
        }
    }

    #[track_caller]
    fn check(strata: &[StratumWays], seconds: f64, expected: &[bool]) {
        assert_eq!(best_ways(strata, seconds), expected, "{seconds} s");
    }

    #[test]
    fn paths_are_traced_once_noise_is_less_than_discretization() {
        let strata = [way(1e-2, 1e-3, 1e-2, 0.1), way(1e-6, 1e-3, 1e-2, 0.1)];
        check(&strata, 0.1, &[false, false]);
        check(&strata, 1.0, &[false, false]);
        check(&strata, 10.0, &[true, false]);
        check(&strata, 1e6, &[true, true]);
        // Even the fewest paths would take too long.
        check(&[way(1.0, 1e-3, 1e-2, 5.0)], 4.0, &[false]);
        check(&[way(1.0, 1e-3, 1e-2, 5.0)], 6.0, &[true]);
        check(&[], 1.0, &[]);
    }

    #[test]
    fn more_time_never_makes_it_worse() {
        let strata = [
            way(4e-3, 2e-3, 3e-2, 0.2),
            way(1e-4, 5e-3, 1e-2, 0.2),
            way(3e-2, 1e-4, 9e-2, 0.9),
        ];
        let error = |seconds: f64| {
            let ways = best_ways(&strata, seconds);
            let root =
                |(s, &w): (&StratumWays, &bool)| (s.share * s.strength[usize::from(w)]).sqrt();
            let sum: f64 = strata.iter().zip(&ways).map(root).sum();
            let read = strata.iter().zip(&ways).filter(|x| !*x.1);
            sum * sum / seconds + read.map(|(s, _)| s.share * s.discretization).sum::<f64>()
        };
        let errors: Vec<f64> = (0..40).map(|k| error(0.1 * 1.3f64.powi(k))).collect();
        assert!(errors.is_sorted_by(|a, b| a >= b), "{errors:?}");
    }

    #[test]
    fn the_pace_is_that_of_all_threads() {
        let pace = GatherPace::default();
        assert_eq!(pace.seconds_per_ray(Termination::Roulette), 0.0);
        pace.add(Termination::Bounces(2), 500, Duration::from_secs(1));
        pace.add(Termination::Roulette, 500, Duration::from_secs(3));
        let threads = rayon::current_num_threads() as f64;
        let seconds = pace.seconds_per_ray(Termination::Roulette);
        assert!((seconds * threads - 4e-3).abs() < 1e-12, "{seconds}");
        assert_eq!(pace.seconds_per_ray(Termination::Radiosity), 0.0);
    }

    #[test]
    fn first_passes_are_shorter_when_time_is() {
        let progress = Progress::new();
        assert_eq!(hasty_rays(1000, 1e-6, &progress), None, "no deadline");
        progress.set_deadline(Instant::now() + Duration::from_secs(1000));
        let check = |seconds_per_ray: f64, expected| {
            assert_eq!(hasty_rays(1000, seconds_per_ray, &progress), expected);
        };
        check(1e-3, Some(HASTY_RAYS));
        check(2e-2, Some(HASTY_RAYS / 2));
        check(1e-1, Some(FEWEST_RAYS));
        check(1.0, None);
        let watch = PhaseWatch::new(&progress);
        assert!(!watch.is_hopeless(0.0), "too early to tell");
        progress.set_deadline(Instant::now());
        assert!(watch.is_hopeless(0.99));
    }
}
