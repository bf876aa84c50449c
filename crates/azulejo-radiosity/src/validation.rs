//! Where patches are too coarse: irradiance from patches beside path traced irradiance, at a keyed
//! sample of the points.

use crate::deadline::{StratumWays, best_ways, hasty_rays, planned_seconds, seconds_for};
use crate::gather_pass::{GatherPass, PointList};
use crate::gathering::{FEWEST_RAYS, FIRST_RAYS, Gathering};
use crate::strata::StratumError;
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, DiffuseLight, SplitIrradiance, Termination};

/// Points of the sample, per stratum.
const SAMPLE: usize = 12;

/// Part of the error permitted to a stratum that the discretization may make up.
const SHARE: f64 = 0.5;

/// How much more noise paths are expected to have than a sample shows, which may miss rare light.
const RARE: f64 = 1.5;

/// Share of the time until a deadline that the samples may take.
const COMPARISON_SHARE: f64 = 0.15;

/// Most rays of a sampled point: by then either answer costs little.
const MOST_SAMPLE_RAYS: u32 = 1 << 13;

/// Standard errors by which the difference must be beyond what is allowed for patches to be too coarse.
/// Samples are judged up to six times in each of eight strata: with one of them, noise alone would have
/// an eighth of the points path traced.
const SURE: f64 = 3.0;

/// Fewest rays per point at which a difference is believed: variances of fewer miss rare light.
const LEAST_SURE: u32 = 1024;

/// One point of the sample, gathered both ways from the same directions.
struct Comparison {
    point: u32,
    patches: SplitIrradiance,
    paths: SplitIrradiance,
}

/// What the sample says of a stratum.
enum Verdict {
    /// The patches will do; the mean square of their error.
    Good(f64),
    /// They will not; the same.
    Bad(f64),
    /// More rays are needed to tell; the same as far as known, and its standard error.
    Open(f64, f64),
}

/// A sample that was gathered both ways.
struct Compared {
    /// Rays of each point.
    spent: u32,
    sample: Vec<Comparison>,
    verdict: Verdict,
}

impl<L: DiffuseLight> GatherPass<'_, L> {
    /// Decides for every stratum whether it may read patches, to reach `goal`, and path traces those
    /// that may not. Without a goal, all read patches, and their error is measured until what is not known of it
    /// hardly counts beside the noise, or a sample has as many rays as the points.
    pub fn validate(
        &self,
        all: &mut Gathering,
        goal: Option<f64>,
        most: u32,
    ) -> Result<(), Cancelled> {
        let permitted = match goal {
            Some(goal) => all.strata.permitted(&all.errors(), goal),
            None => all.errors().iter().map(|error| error.noise).collect(),
        };
        if goal.is_some() && self.run.progress.has_deadline() {
            return self.validate_in_time(all, &permitted, most);
        }
        let reads =
            |(stratum, _): &(usize, f64)| all.strata.termination(*stratum) != Termination::Roulette;
        let strata: Vec<(usize, f64)> = permitted.into_iter().enumerate().filter(reads).collect();
        let samples = strata.iter().map(|&(stratum, permitted)| {
            let sample = self.sample(all.strata.points(stratum));
            (sample, SHARE * SHARE * permitted)
        });
        let compared = self.compare(all, samples.collect(), most)?;
        for (
            (stratum, _),
            Compared {
                spent,
                sample,
                verdict,
            },
        ) in strata.into_iter().zip(compared)
        {
            match verdict {
                Verdict::Bad(square) if goal.is_some() && !self.run.progress.out_of_time() => {
                    self.trace_paths(all, stratum, square, (spent, sample), most)?;
                }
                Verdict::Good(square) | Verdict::Bad(square) => {
                    all.strata.read_patches(stratum, square);
                }
                Verdict::Open(square, doubt) if goal.is_none() => {
                    all.strata.read_patches(stratum, square + 0.5 * doubt);
                }
                Verdict::Open(square, _)
                    if all.strata.is_each() && !self.run.progress.out_of_time() =>
                {
                    self.trace_paths(all, stratum, square, (spent, sample), most)?;
                }
                // To tell would take about as long as to path trace all: the doubt is stated instead.
                Verdict::Open(square, doubt) => all.strata.read_patches(stratum, square + doubt),
            }
        }
        Ok(())
    }

    /// The same before a deadline: all strata are compared first, each for its part of the time, and
    /// then path traced where that leaves the least error in the time that is left, or where the
    /// goal demands it and there is time for it.
    fn validate_in_time(
        &self,
        all: &mut Gathering,
        permitted: &[f64],
        most: u32,
    ) -> Result<(), Cancelled> {
        // Compare stratum after stratum, each in its part of the time.
        let mut samples = Vec::new();
        for (stratum, permitted_here) in permitted.iter().enumerate() {
            let rest = (permitted.len() - stratum) as f64;
            self.run.progress.limit_phase(COMPARISON_SHARE / rest);
            let sample = self.sample(all.strata.points(stratum));
            let allowed = SHARE * SHARE * permitted_here;
            let Some(Compared {
                spent,
                sample,
                verdict,
            }) = self.compare(all, vec![(sample, allowed)], most)?.pop()
            else {
                continue;
            };
            // All strata read patches at first; what stays open counts with its doubt.
            let (square, is_bad) = match verdict {
                Verdict::Good(square) => (square, false),
                Verdict::Bad(square) => (square, true),
                Verdict::Open(square, doubt) => (square + doubt, false),
            };
            all.strata.read_patches(stratum, square);
            samples.push((spent, sample, is_bad));
        }
        self.run.progress.limit_phase(1.0);
        // Path trace what the goal demands if there is time, else what lowers the error most.
        let seconds = planned_seconds(self.run.progress);
        let errors = all.errors();
        let ways: Vec<StratumWays> = (0..samples.len())
            .map(|k| self.ways(all, k, &errors[k], &samples[k]))
            .collect();
        let demanded: Vec<bool> = samples.iter().map(|f| f.2).collect();
        let chosen = if seconds_for(&ways, &demanded, permitted) <= seconds {
            demanded
        } else {
            best_ways(&ways, seconds)
        };
        for (stratum, (spent, sample, _)) in samples.into_iter().enumerate() {
            if chosen[stratum] && !self.run.progress.out_of_time() {
                let discretization = errors[stratum].discretization;
                self.trace_paths(all, stratum, discretization, (spent, sample), most)?;
            }
        }
        Ok(())
    }

    /// What a stratum would cost and gain, from what its sample took.
    fn ways(
        &self,
        all: &Gathering,
        stratum: usize,
        error: &StratumError,
        (spent, sample, _): &(u32, Vec<Comparison>, bool),
    ) -> StratumWays {
        let points = all.strata.points(stratum).len() as f64;
        let [read, paths] = [Termination::Radiosity, Termination::Roulette]
            .map(|termination| points * self.pace.seconds_per_ray(termination));
        let variance = |c: &Comparison| all.strata.mean_of(c.paths.whole().variance());
        let noise = sample.iter().map(variance).sum::<f64>() / sample.len().max(1) as f64;
        StratumWays {
            share: error.share,
            discretization: error.discretization,
            strength: [
                error.noise * all.spent_on(stratum) / points.max(1.0) * read,
                RARE * noise * f64::from(*spent) * paths,
            ],
            fewest: f64::from(FEWEST_RAYS) * paths,
        }
    }

    /// Path traces all points of a stratum, of which a sample is known. If the time does not suffice
    /// for all, they keep what they have, whose mean square error is `discretization`.
    fn trace_paths(
        &self,
        all: &mut Gathering,
        stratum: usize,
        discretization: f64,
        (spent, sample): (u32, Vec<Comparison>),
        most: u32,
    ) -> Result<(), Cancelled> {
        let before = (all.values.clone(), all.spent.clone());
        let points = all.strata.points(stratum).to_vec();
        all.strata.trace_paths(stratum);
        points.iter().for_each(|&i| all.spent[i as usize] = 0);
        for known in sample {
            all.values.add(known.point as usize, &known.paths, 1.0);
            all.spent[known.point as usize] = spent;
        }
        let seconds = self.pace.seconds_per_ray(Termination::Roulette);
        let first = if self.run.progress.has_deadline() {
            hasty_rays(points.len(), seconds, self.run.progress).unwrap_or(FEWEST_RAYS)
        } else {
            FIRST_RAYS
        };
        let first = first.min(most);
        let totals: Vec<u32> = all.spent.iter().map(|&n| n.max(first)).collect();
        self.raise(all, &totals)?;
        if points.iter().any(|&i| all.spent[i as usize] == 0) {
            (all.values, all.spent) = before;
            all.combine();
            all.strata.read_patches(stratum, discretization);
        }
        Ok(())
    }

    /// The points of a stratum whose keys come first.
    fn sample(&self, points: &[u32]) -> Vec<Comparison> {
        let key = |&i: &u32| (hash(&[self.seed, i, 0x7a1]), i);
        let mut keyed: Vec<(u32, u32)> = points.iter().map(key).collect();
        keyed.sort_unstable();
        let new = |&(_, point): &(u32, u32)| Comparison {
            point,
            patches: SplitIrradiance::default(),
            paths: SplitIrradiance::default(),
        };
        keyed.iter().take(SAMPLE).map(new).collect()
    }

    /// Gathers samples both ways until it is clear whether the difference of each is within what is allowed for
    /// it: all that are not clear together, so that processes that share the work meet seldom.
    fn compare(
        &self,
        all: &Gathering,
        samples: Vec<(Vec<Comparison>, f64)>,
        most: u32,
    ) -> Result<Vec<Compared>, Cancelled> {
        let most = most.min(MOST_SAMPLE_RAYS);
        // Rays double from round to round; before a deadline the first round is a quarter as large.
        let first = if self.run.progress.has_deadline() {
            FIRST_RAYS / 2
        } else {
            2 * FIRST_RAYS
        };
        let (mut spent, mut next) = (0, first.min(most));
        let compared = |(sample, allowed)| {
            let verdict = Verdict::Open(0.0, 0.0);
            let start = Compared {
                spent,
                sample,
                verdict,
            };
            (start, allowed, true)
        };
        let mut samples: Vec<(Compared, f64, bool)> = samples.into_iter().map(compared).collect();
        loop {
            let mut open: Vec<_> = samples.iter_mut().filter(|sample| sample.2).collect();
            if open.is_empty() {
                return Ok(samples.into_iter().map(|sample| sample.0).collect());
            }
            // Gather both ways from the same directions, so that their difference has little noise.
            let ways = [Termination::Radiosity, Termination::Roulette];
            let lists = open.iter().flat_map(|(compared, ..)| {
                ways.map(|termination| PointList {
                    points: compared.sample.iter().map(|c| c.point).collect(),
                    rays: spent..next,
                    termination,
                    has_direct: true,
                })
            });
            let lists: Vec<PointList> = lists.collect();
            let points: usize = lists.iter().map(|list| list.points.len()).sum();
            self.run
                .progress
                .begin("comparing with paths", points as u64);
            let light = self.gather_lists(&lists, true)?;
            let share = f64::from(next - spent) / f64::from(next);
            spent = next;
            let is_last = spent >= most || self.run.progress.phase_is_over();
            for ((compared, allowed, is_open), light) in open.iter_mut().zip(light.chunks(2)) {
                compared.spent = spent;
                let (patches, paths) = (light[0].iter(), light[1].iter());
                for (known, (patches, paths)) in compared.sample.iter_mut().zip(patches.zip(paths))
                {
                    if let (Some(patches), Some(paths)) = (patches, paths) {
                        known.patches = known.patches.blend(patches, share);
                        known.paths = known.paths.blend(paths, share);
                    }
                }
                let mut verdict = judge(all, &compared.sample, *allowed);
                // Few rays may miss rare light and underestimate the noise: they do not condemn the patches yet.
                if let (Verdict::Bad(square), true) = (&verdict, spent < LEAST_SURE && !is_last) {
                    verdict = Verdict::Open(*square, *square);
                }
                *is_open = !is_last && matches!(verdict, Verdict::Open(..));
                compared.verdict = verdict;
            }
            next = (2 * spent).min(most);
        }
    }
}

/// Compares the mean square of the differences, less their noise, with what is `allowed`.
fn judge(all: &Gathering, sample: &[Comparison], allowed: f64) -> Verdict {
    let (mut squares, mut noise) = (0.0, 0.0);
    for known in sample {
        let difference = known.patches.indirect.minus(&known.paths.indirect);
        let (mean, variance) = (difference.mean(), difference.variance());
        let variance = all.strata.mean_of(variance);
        squares += all.strata.mean_of(mean * mean) - variance;
        noise += variance * variance;
    }
    let count = sample.len().max(1) as f64;
    // A square of a normal error varies by √2 of its mean, and its estimated variance by as much.
    let (square, doubt) = (squares / count, (4.0 * noise).sqrt() / count);
    if square + doubt <= allowed {
        Verdict::Good(square.max(0.0) + 0.5 * doubt)
    } else if square - SURE * doubt > allowed {
        Verdict::Bad(square)
    } else {
        Verdict::Open(square.max(0.0), doubt)
    }
}
