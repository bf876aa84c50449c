//! Irradiance at points, to a requested error.

use azulejo_scene::Rgb;
use azulejo_trace::{
    Cancelled, DiffuseLight, DirectionTables, GatherOptions, GatherPoint, Gathered, Gatherer,
    Measure, Progress, REPLICATES,
};
use rayon::prelude::*;

/// Points gathered together: enough to fill the tracer's batches, few enough that their paths stay
/// in the cache.
const CHUNK: usize = 8;

/// Rays per point of the first pass to an error; later passes make a point's total a power of two
/// times this, or one and a half times that.
const FIRST_RAYS: u32 = 128;

/// Rays per point if time is out before the first pass: every point gets some light.
const HASTY_RAYS: u32 = 32;

/// Most rays per point of any gather.
pub const MOST_RAYS: u32 = 1 << 17;

/// Largest growth of a point's total per pass: early variances are too uncertain to be trusted
/// further.
const GROWTH: f64 = 8.0;

/// Decline of the variance, about rays^−1.2 (measured: between random, 1, and 2-D strata, 3/2).
const RATE: f64 = 1.2;

/// Share of the mean irradiance below which errors are relative to that share, so that dark points
/// do not dominate.
const DARK: f64 = 0.1;

/// When gathering stops: at an error, at a number of rays, or at whichever comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatherEffort {
    /// Relative RMS error of irradiance to reach, see [`Gathering::relative_error`]; `None` uses
    /// all rays.
    pub error: Option<f64>,
    /// Most rays per point.
    pub rays: u32,
}

/// Irradiance at points, with the rays it took.
pub struct Gathering {
    /// One entry per point.
    pub gathered: Vec<Gathered>,
    /// Rays traced from each point.
    pub spent: Vec<u32>,
}

impl Gathering {
    /// Mean number of rays per point.
    pub fn rays_per_point(&self) -> u32 {
        let sum: u64 = self.spent.iter().map(|&n| u64::from(n)).sum();
        (sum / self.spent.len().max(1) as u64) as u32
    }

    /// Estimated root mean square, over points and channels, of error over irradiance; irradiance
    /// below a tenth of the mean counts as a tenth of it.
    pub fn relative_error(&self) -> f64 {
        rms(&relative_variances(&self.gathered)) * self.gain().sqrt()
    }

    /// Standard error of every point: the truth lies within two of them 95.4 times in 100.
    pub fn standard_errors(&self) -> Vec<Rgb> {
        let scale = self.gain().sqrt();
        self.gathered
            .iter()
            .map(|g| g.standard_error() * scale)
            .collect()
    }

    /// Variance of the estimates relative to that of independent replicates, a quarter to 1.
    ///
    /// Replicates are parts of one sequence, so two together are better distributed than each
    /// alone. Comparing the variance of halves with that of quarters, over all points, measures how
    /// much this helps; the whole is assumed to gain over halves what these gain over quarters.
    fn gain(&self) -> f64 {
        /// Weight of the conservative assumption, in points: a few points carry little information.
        const DOUBT: f64 = 20.0;
        let average = average(&self.gathered);
        let (mut halves, mut quarters, mut count) = (0.0, 0.0, 0.0);
        for g in &self.gathered {
            let [a, b, c, d] = g.replicates;
            let (half, variance, mean) = ((a + b - c - d) * 0.5, g.variance(), g.mean());
            for k in (0..3).filter(|&k| average[k] > 0.0) {
                let against = mean[k].max(DARK * average[k]).powi(2);
                // Both estimate the variance of one of their parts, times one minus the parts'
                // correlation.
                halves += half[k] * half[k] / 2.0 / against;
                quarters += REPLICATES as f64 * variance[k] / against;
                count += 1.0 / 3.0;
            }
        }
        let step = if quarters > 0.0 {
            (2.0 * halves / quarters).clamp(0.5, 1.0)
        } else {
            1.0
        };
        (count * step * step + DOUBT) / (count + DOUBT)
    }
}

/// Gathers at all points until `effort` is reached or the progress is out of time.
///
/// To reach an error, a first pass measures the noise of each point; later ones spend rays where
/// they reduce the error most.
///
/// # Errors
/// [`Cancelled`].
pub fn gather(
    gatherer: &Gatherer,
    light: &impl DiffuseLight,
    points: &[GatherPoint],
    effort: GatherEffort,
    seed: u32,
    progress: &Progress,
) -> Result<Gathering, Cancelled> {
    gather_watched(gatherer, light, points, effort, seed, progress, &mut |_| ())
}

/// As [`gather`]; passes intermediate results to `watch` after each pass but the last.
pub(crate) fn gather_watched(
    gatherer: &Gatherer,
    light: &impl DiffuseLight,
    points: &[GatherPoint],
    effort: GatherEffort,
    seed: u32,
    progress: &Progress,
    watch: &mut dyn FnMut(&Gathering),
) -> Result<Gathering, Cancelled> {
    let task = GatherPass {
        gatherer,
        light,
        points,
        seed,
        progress,
    };
    let most = effort.rays.clamp(1, MOST_RAYS);
    let rays = match effort.error {
        _ if progress.out_of_time() => HASTY_RAYS.min(most),
        Some(_) => FIRST_RAYS.min(most),
        None => most,
    };
    let mut all = Gathering {
        gathered: vec![Gathered::default(); points.len()],
        spent: vec![0; points.len()],
    };
    task.raise(&mut all, &vec![rays; points.len()])?;
    loop {
        let error = all.relative_error();
        progress.measured(Measure::Error(error));
        let Some(goal) = effort.error else { break };
        if progress.out_of_time() || error <= goal {
            break;
        }
        let variances = relative_variances(&all.gathered);
        let totals = allot(&variances, &all.spent, goal / all.gain().sqrt(), most);
        if totals == all.spent {
            break;
        }
        watch(&all);
        task.raise(&mut all, &totals)?;
    }
    Ok(all)
}

/// The constants of all passes.
struct GatherPass<'a, L> {
    gatherer: &'a Gatherer<'a>,
    light: &'a L,
    points: &'a [GatherPoint],
    seed: u32,
    progress: &'a Progress,
}

impl<L: DiffuseLight> GatherPass<'_, L> {
    /// Raises every point to its total, in groups with the same start and total; points keep what
    /// they have when time runs out.
    fn raise(&self, all: &mut Gathering, totals: &[u32]) -> Result<(), Cancelled> {
        let groups: Vec<(u32, u32)> = all
            .spent
            .iter()
            .copied()
            .zip(totals.iter().copied())
            .collect();
        let mut ways = groups.clone();
        ways.sort_unstable();
        ways.dedup();
        let work = groups.iter().filter(|(spent, total)| total > spent).count();
        self.progress.begin("irradiance", work as u64);
        for (spent, total) in ways.into_iter().filter(|(spent, total)| total > spent) {
            let chosen: Vec<u32> = (0..groups.len() as u32)
                .filter(|&i| groups[i as usize] == (spent, total))
                .collect();
            let rays = total - spent;
            let found = self.pass(
                &chosen,
                &GatherOptions {
                    rays,
                    spent,
                    seed: self.seed,
                },
            )?;
            for (&i, new) in chosen.iter().zip(found) {
                if let Some(new) = new {
                    let old = &mut all.gathered[i as usize];
                    *old = old.blend(&new, f64::from(rays) / f64::from(total));
                    all.spent[i as usize] = total;
                }
            }
        }
        Ok(())
    }

    /// Gathers once at the chosen points; `None` where time ran out.
    fn pass(
        &self,
        chosen: &[u32],
        options: &GatherOptions,
    ) -> Result<Vec<Option<Gathered>>, Cancelled> {
        let directions = DirectionTables::new(options);
        let chunks: Result<Vec<Vec<Option<Gathered>>>, Cancelled> = chosen
            .par_chunks(CHUNK)
            .map(|chunk| {
                self.progress.advance(chunk.len() as u64)?;
                if options.spent > 0 && self.progress.out_of_time() {
                    return Ok(vec![None; chunk.len()]);
                }
                let points: Vec<GatherPoint> =
                    chunk.iter().map(|&i| self.points[i as usize]).collect();
                let found = self
                    .gatherer
                    .gather_with(&points, options, &directions, self.light);
                Ok(found.into_iter().map(Some).collect())
            })
            .collect();
        Ok(chunks?.into_iter().flatten().collect())
    }
}

/// Totals of rays that bring the root mean square of `variances` to `goal` at least cost, as far as
/// one pass should go.
///
/// A point's variance falls with its rays n as n^−[`RATE`]; the sum of rays is then least for n in
/// proportion to variance^(1/(1 + RATE)), by Lagrange.
fn allot(variances: &[f64], spent: &[u32], goal: f64, most: u32) -> Vec<u32> {
    let mean = variances.iter().sum::<f64>() / variances.len() as f64;
    // Four replicates estimate a point's variance badly; half of it is taken from all points.
    let per_ray = |(v, &n): (&f64, &u32)| 0.5 * (v + mean) * f64::from(n).powf(RATE);
    let strength: Vec<f64> = variances.iter().zip(spent).map(per_ray).collect();
    let power = 1.0 / (1.0 + RATE);
    let sum: f64 = strength.iter().map(|s| s.powf(power)).sum();
    let scale = (sum / (strength.len() as f64 * goal * goal)).powf(1.0 / RATE);
    let total = |(s, &n): (&f64, &u32)| {
        well_spread(n, (scale * s.powf(power)).min(GROWTH * f64::from(n)), most)
    };
    strength.iter().zip(spent).map(total).collect()
}

/// The total nearest to `wanted`, from `spent` to `most`, that is well distributed: a power of two,
/// or one and a half times one, in units of the first pass.
fn well_spread(spent: u32, wanted: f64, most: u32) -> u32 {
    let totals = (0..24).map(|k| ((FIRST_RAYS * [2, 3][k as usize % 2]) << (k / 2)) / 2);
    let enough = |&t: &u32| t >= spent && f64::from(t) >= 0.85 * wanted;
    totals
        .into_iter()
        .find(enough)
        .unwrap_or(most)
        .clamp(spent, most.max(spent))
}

fn rms(variances: &[f64]) -> f64 {
    (variances.iter().sum::<f64>() / variances.len().max(1) as f64).sqrt()
}

/// Relative variance of each point's estimate, mean of the channels that have light.
fn relative_variances(gathered: &[Gathered]) -> Vec<f64> {
    let average = average(gathered);
    let lit = (0..3).filter(|&k| average[k] > 0.0).count().max(1) as f64;
    let relative = |g: &Gathered| {
        let (mean, variance) = (g.mean(), g.variance());
        let channel = |k: usize| {
            let against = mean[k].max(DARK * average[k]);
            if against > 0.0 {
                variance[k] / (against * against)
            } else {
                0.0
            }
        };
        (0..3).map(channel).sum::<f64>() / lit
    };
    gathered.iter().map(relative).collect()
}

/// Mean irradiance of all points.
fn average(gathered: &[Gathered]) -> Rgb {
    gathered.iter().map(Gathered::mean).sum::<Rgb>() / gathered.len().max(1) as f64
}
