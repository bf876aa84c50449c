//! Irradiance at points to an asked error.

use azulejo_scene::Rgb;
use azulejo_trace::{Cancelled, DiffuseLight, DirectionTables, GatherOptions, GatherPoint, Gathered, Gatherer, Progress};
use rayon::prelude::*;

/// Points gathered in one go: enough to fill the tracer's batches, few enough that their paths
/// stay in the cache.
const CHUNK: usize = 8;

/// Rays per point of the first pass when an error is asked for; later passes make the total a
/// power of two times this, or one and a half times that.
const FIRST_RAYS: u32 = 128;

/// Rays per point at which gathering gives up on an error.
const MOST_RAYS: u32 = 1 << 17;

/// Error falls about as rays^−0.6 (measured: between random, ½, and 2-D strata, ¾).
const RATE: f64 = 0.6;

/// Irradiance below this share of the mean counts as that when errors are made relative, so
/// that points in the dark don't decide alone.
const DARK: f64 = 0.1;

/// When gathering stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effort {
    /// At this many rays per point.
    Rays(u32),
    /// At this relative RMS error of irradiance, see [`relative_error`].
    Error(f64),
}

/// Gathers at all points until `effort` is reached or the progress is out of time; returns the
/// estimates and the rays spent per point.
///
/// # Errors
/// [`Cancelled`].
pub fn gather(
    gatherer: &Gatherer,
    light: &impl DiffuseLight,
    points: &[GatherPoint],
    effort: Effort,
    seed: u32,
    progress: &Progress,
) -> Result<(Vec<Gathered>, u32), Cancelled> {
    let mut rays = match effort {
        Effort::Rays(n) => n.max(1),
        Effort::Error(_) => FIRST_RAYS,
    };
    let (mut sum, mut spent) = (Vec::new(), 0);
    loop {
        let found = gather_pass(gatherer, light, points, &GatherOptions { rays, spent, seed }, progress)?;
        sum = combined(sum, spent, found, rays);
        spent += rays;
        let Effort::Error(goal) = effort else { break };
        let error = relative_error(&sum);
        if error <= goal || spent >= MOST_RAYS || progress.out_of_time() {
            break;
        }
        let wanted = f64::from(spent) * (error / goal).powf(1.0 / RATE);
        rays = next_total(spent, wanted) - spent;
    }
    Ok((sum, spent))
}

/// The least total of rays that is more than `spent`, at least `wanted` but for a tenth, and well
/// spread: a power of two, or one and a half times one, in units of the first pass.
fn next_total(spent: u32, wanted: f64) -> u32 {
    let totals = (0..).map(|k| FIRST_RAYS * [2, 3][k as usize % 2] << (k / 2)).map(|t| t / 2);
    let enough = |&t: &u32| t > spent && f64::from(t) >= 0.9 * wanted;
    totals.take_while(|&t| t <= MOST_RAYS).find(enough).unwrap_or(MOST_RAYS)
}

fn gather_pass(
    gatherer: &Gatherer,
    light: &impl DiffuseLight,
    points: &[GatherPoint],
    options: &GatherOptions,
    progress: &Progress,
) -> Result<Vec<Gathered>, Cancelled> {
    progress.begin("irradiance", points.len() as u64);
    let directions = DirectionTables::new(options);
    let chunks: Result<Vec<Vec<Gathered>>, Cancelled> = points
        .par_chunks(CHUNK)
        .map(|chunk| {
            progress.advance(chunk.len() as u64)?;
            Ok(gatherer.gather_with(chunk, options, &directions, light))
        })
        .collect();
    Ok(chunks?.into_iter().flatten().collect())
}

/// The mean of two passes by their rays, replicate by replicate.
fn combined(old: Vec<Gathered>, old_rays: u32, new: Vec<Gathered>, new_rays: u32) -> Vec<Gathered> {
    if old.is_empty() {
        return new;
    }
    let share = f64::from(new_rays) / f64::from(old_rays + new_rays);
    old.iter().zip(&new).map(|(a, b)| a.blend(b, share)).collect()
}

/// Root mean square, over points and channels, of standard error over irradiance; irradiance
/// below a tenth of the mean counts as that.
pub fn relative_error(gathered: &[Gathered]) -> f64 {
    let means: Vec<Rgb> = gathered.iter().map(Gathered::mean).collect();
    let average = means.iter().copied().sum::<Rgb>() / means.len().max(1) as f64;
    let (mut sum, mut count) = (0.0, 0);
    for (g, mean) in gathered.iter().zip(&means) {
        let variance = g.variance();
        for k in 0..3 {
            let against = mean[k].max(DARK * average[k]);
            if against > 0.0 {
                sum += variance[k] / (against * against);
                count += 1;
            }
        }
    }
    if count > 0 { (sum / f64::from(count)).sqrt() } else { 0.0 }
}

/// Standard error of an estimate such that two of them to either side hold the truth with the
/// normal law's probability of 95.4%: the spread of four replicates is itself uncertain, and
/// Student's t with three degrees of freedom says by how much (2 σ become 3.307 s).
pub fn standard_error(gathered: &Gathered) -> Rgb {
    const STUDENT: f64 = 3.307 / 2.0;
    gathered.variance().map(f64::sqrt) * STUDENT
}
