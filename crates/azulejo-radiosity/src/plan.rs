//! Whether light between patches pays: a pilot of paths measures what it would cost to trace all points, and that is
//! compared with the rows of patches and what remains to be traced beside them.
//!
//! Costs are numbers of rays, never seconds, so that the same scene is always solved in the same way.

use crate::gathering::{CHUNK, GatherTargets, noise_rate, well_spread};
use crate::light::PatchLight;
use crate::sparse::LEAST_POINTS;
use crate::strata::{DARKEST_OF_EACH, Strata};
use azulejo_factors::{PatchSize, Patches};
use azulejo_scene::{Material, Rgb};
use azulejo_trace::sampling::hash;
use azulejo_trace::{
    DiffuseHit, DiffuseLight, DirectionTables, GatherOptions, GatherPoint, Gathered, Gatherer,
    OutgoingRadiosity, SplitIrradiance, Termination,
};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Points of the pilot, and paths from each.
const PILOT_POINTS: usize = 128;
const PILOT_PATHS: u32 = 64;

/// Points of a first look at how long paths are, paths from each, and bounces after which they end.
const LENGTH_POINTS: usize = 16;
const LENGTH_PATHS: u32 = 4;
const LENGTH_BOUNCES: u32 = 512;

/// Bounces of an average path from which paths are out of the question: that of walls that reflect 0.996.
const LONG: f64 = 256.0;

/// Points for each at which indirect light is gathered, where there are enough to interpolate it.
const POINTS_PER_RECORD: usize = 4;

/// Rays that cost as much as sampling lamps that show pictures.
const RAYS_OF_PICTURES: f64 = 10.0;

/// Paths from a point for each time that its direct light is found.
const DIRECT_SHARE: f64 = 16.0;

/// Fewest paths from each point, however small the budget.
const FEWEST_PATHS: u32 = 16;

/// Cost of a point that reads patches, relative to that of paths with the same noise: an estimate, from the rays and
/// the variance that paths have after their first segment.
const READING: f64 = 1.0 / 6.0;

/// The relative error that the points are to reach, all together or each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GatherGoal {
    pub error: f64,
    pub is_each: bool,
}

/// What all points would cost in either way, in paths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GatherForecast {
    /// Paths from all points, on average.
    pub paths_per_point: f64,
    /// All paths from the points.
    pub by_paths: f64,
    /// Rows of patches, and what is gathered with them.
    pub by_patches: f64,
}

impl GatherForecast {
    /// Whether paths alone are cheaper.
    pub fn prefers_paths(&self) -> bool {
        self.by_paths < self.by_patches
    }
}

/// A few paths from some of the points.
///
/// The points are chosen evenly in proportion to the roots w of their areas, so that the mean of w·σ over all points is
/// that of σ over the pilot, times the mean of w.
pub(crate) struct Pilot {
    /// Number of all points.
    count: usize,
    /// Mean of w over all points.
    mean_root: f64,
    /// Each chosen point's w, and what its paths found.
    gathered: Vec<(f64, Gathered)>,
    /// Segments and shadow rays of a path, with its share of the direct light of its point.
    rays_per_path: f64,
}

impl Pilot {
    /// From the points, which count by their areas; `light` is that at the ends of paths. Where paths hardly ever end, their
    /// light is not found, so that there is no forecast.
    pub fn new(
        gatherer: &Gatherer,
        light: &PatchLight,
        targets: GatherTargets,
        seed: u32,
    ) -> Pilot {
        let (points, direct) = (targets.points, direct_rays(gatherer));
        let rays_per_path = |hits: f64| 1.0 + direct + hits * (2.0 + direct);
        let options = GatherOptions {
            rays: LENGTH_PATHS,
            spent: 0,
            seed: hash(&[seed, 0x1e2]),
            termination: Termination::Bounces(LENGTH_BOUNCES),
        };
        let few = evenly(&vec![1.0; points.len()], LENGTH_POINTS.min(points.len()));
        let few: Vec<GatherPoint> = few.into_iter().map(|i| points[i]).collect();
        let (_, hits) = traced(gatherer, light, &few, &options);
        if hits > LONG {
            return Pilot {
                count: points.len(),
                mean_root: 0.0,
                gathered: Vec::new(),
                rays_per_path: rays_per_path(hits),
            };
        }
        let strata = Strata::new(points.len(), targets.areas);
        let roots: Vec<f64> = (0..points.len()).map(|i| strata.weight(i).sqrt()).collect();
        let options = GatherOptions {
            rays: PILOT_PATHS,
            spent: 0,
            seed: hash(&[seed, 0x9107]),
            termination: Termination::Roulette,
        };
        let chosen: Vec<usize> = evenly(&roots, PILOT_POINTS.min(points.len()));
        let sampled: Vec<GatherPoint> = chosen.iter().map(|&i| points[i]).collect();
        let (gathered, hits) = traced(gatherer, light, &sampled, &options);
        Pilot {
            count: points.len(),
            mean_root: roots.iter().sum::<f64>() / points.len() as f64,
            gathered: gathered
                .iter()
                .zip(&chosen)
                .map(|(split, &i)| (roots[i], split.whole()))
                .collect(),
            rays_per_path: rays_per_path(hits),
        }
    }

    /// What all points would cost to reach `goal`, by paths and by rows of `patches` with this many rays each; `None`
    /// if the pilot found no light.
    pub fn forecast(
        &self,
        (patches, size, rays): (&Patches, PatchSize, u32),
        goal: GatherGoal,
    ) -> Option<GatherForecast> {
        let paths_per_point = self.paths_per_point(goal)?;
        let gathered = match self.count {
            LEAST_POINTS.. => (self.count / POINTS_PER_RECORD).max(LEAST_POINTS),
            _ => self.count,
        };
        let by_paths = paths_per_point * gathered as f64;
        let rows = patches.len() as f64 * f64::from(rays) / self.rays_per_path;
        let traced = clutter(patches.len(), size);
        Some(GatherForecast {
            paths_per_point,
            by_paths,
            by_patches: rows + by_paths * (traced + (1.0 - traced) * READING),
        })
    }

    /// As many paths from each point as `budget` rays allow, up to `most`.
    pub fn affordable_paths(&self, budget: f64, most: u32) -> u32 {
        let paths = budget / self.rays_per_path / self.count.max(1) as f64;
        well_spread(FEWEST_PATHS, paths, most)
    }

    /// Paths from each point that reach `goal`, on average, if all points get as many as are best for
    /// them: by Lagrange in proportion to their standard deviations, and to the roots of their areas. `None` without
    /// light.
    fn paths_per_point(&self, goal: GatherGoal) -> Option<f64> {
        let count = self.gathered.len() as f64;
        let deviation = |g: &Gathered| g.variance().mean().sqrt();
        let exponent = 2.0 / noise_rate(Termination::Roulette);
        if goal.is_each {
            let lit = self.gathered.iter().map(|(_, g)| g.mean().mean());
            let mean = lit.sum::<f64>() / count;
            let least = DARKEST_OF_EACH * mean;
            let paths = |(_, g): &(f64, Gathered)| {
                let relative = deviation(g) / (goal.error * g.mean().mean().max(least));
                relative.powf(exponent)
            };
            let sum: f64 = self.gathered.iter().map(paths).sum();
            return (mean > 0.0).then(|| f64::from(PILOT_PATHS) * sum / count);
        }
        let lit = self.gathered.iter().map(|(root, g)| root * g.mean().mean());
        let mean = self.mean_root * lit.sum::<f64>() / count;
        let deviations = self.gathered.iter().map(|(_, g)| deviation(g));
        let deviation = self.mean_root * deviations.sum::<f64>() / count;
        let paths = (deviation / (goal.error * mean)).powf(exponent);
        (mean > 0.0).then(|| f64::from(PILOT_PATHS) * paths)
    }
}

/// What paths from points find, and from how many hits an average one goes on.
fn traced(
    gatherer: &Gatherer,
    light: &PatchLight,
    points: &[GatherPoint],
    options: &GatherOptions,
) -> (Vec<SplitIrradiance>, f64) {
    let directions = DirectionTables::new(options);
    let counted = CountedHits {
        light,
        hits: AtomicU64::new(0),
    };
    let gathered = points
        .par_chunks(CHUNK)
        .flat_map_iter(|points| gatherer.gather_with(points, options, &directions, &counted))
        .collect();
    let paths = points.len() * options.rays as usize;
    let hits = counted.hits.into_inner() as f64 / paths.max(1) as f64;
    (gathered, hits)
}

/// Rays that cost as much as the direct light of a path's vertex.
fn direct_rays(gatherer: &Gatherer) -> f64 {
    let shows = |m: &Material| m.is_emitter() && m.emission_picture.is_some();
    let has_pictures = gatherer.surfaces().scene.materials.iter().any(shows);
    let pictures = if has_pictures { RAYS_OF_PICTURES } else { 0.0 };
    gatherer.direct_cost() / DIRECT_SHARE + pictures
}

/// Light with a count of the hits from which paths may go on.
struct CountedHits<'l, 'a> {
    light: &'l PatchLight<'a>,
    hits: AtomicU64,
}

impl DiffuseLight for CountedHits<'_, '_> {
    fn outgoing(&self, at: &DiffuseHit, replicate: usize) -> OutgoingRadiosity {
        self.light.outgoing(at, replicate)
    }

    fn reflectance(&self, at: &DiffuseHit) -> Rgb {
        self.hits.fetch_add(1, Ordering::Relaxed);
        self.light.reflectance(at)
    }

    fn is_unknown(&self) -> bool {
        self.light.is_unknown()
    }
}

/// The share of the points at which patches are expected to be too coarse: where faces are smaller than the patches
/// asked for, much is hidden behind little, and the light between has more edges than patches. A guess: in a furnished
/// room of even light it is too high, and paths are taken though patches would cost a quarter less.
fn clutter(patches: usize, size: PatchSize) -> f64 {
    let count = match size {
        PatchSize::Squares(count) | PatchSize::Count(count) => count,
        PatchSize::FlatWhole(_) | PatchSize::Edge(_) => patches,
    };
    1.0 - count.min(patches) as f64 / patches.max(1) as f64
}

/// So many indices, evenly in proportion to `weights`: the same one several times where one weighs as much.
fn evenly(weights: &[f64], count: usize) -> Vec<usize> {
    let step = weights.iter().sum::<f64>() / count as f64;
    let mut chosen = Vec::with_capacity(count);
    let mut end = 0.0;
    for (i, weight) in weights.iter().enumerate() {
        end += weight;
        while chosen.len() < count && (chosen.len() as f64 + 0.5) * step < end {
            chosen.push(i);
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pilot_takes_points_by_their_weights() {
        assert_eq!(evenly(&[1.0; 8], 4), [1, 3, 5, 7]);
        assert_eq!(evenly(&[1.0; 3], 3), [0, 1, 2]);
        assert_eq!(evenly(&[0.1, 5.9, 1.0, 1.0], 4), [1, 1, 1, 3]);
    }

    #[test]
    fn faces_smaller_than_patches_are_clutter() {
        assert_eq!(clutter(1500, PatchSize::Squares(1500)), 0.0);
        assert_eq!(clutter(1200, PatchSize::Count(1500)), 0.0);
        assert!((clutter(15_000, PatchSize::Squares(1500)) - 0.9).abs() < 1e-12);
        assert_eq!(clutter(15_000, PatchSize::Edge(0.1)), 0.0);
    }
}
