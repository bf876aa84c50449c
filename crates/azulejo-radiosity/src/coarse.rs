//! Irradiance before a deadline that is too near for all points: it is gathered at
//! [records](crate::records), each of which stands for the points of its cell.
//!
//! What that costs is measured: at a keyed sample of the points, in proportion to their areas,
//! irradiance is path traced and compared with that of the record. The mean square of the difference,
//! less its noise, is part of the stated error.

use crate::gather_pass::GatherPass;
use crate::gathered_values::GatheredValues;
use crate::gathering::{FEWEST_RAYS, GatherError, Gathering, HASTY_RAYS};
use crate::records::RecordCells;
use azulejo_trace::sampling::{hash, uniform};
use azulejo_trace::{DiffuseLight, Gathered, Measure, SplitIrradiance, Termination};

/// Share of the time that is left for the rays of records.
const RECORDS_SHARE: f64 = 0.5;

/// Fewest records that are worth having.
const LEAST_RECORDS: usize = 64;

/// Most rays of a record: from then on the cells are what is wrong.
const MOST_RECORD_RAYS: u32 = 512;

/// Largest error, relative to the mean irradiance, of light that is worth having.
const MOST_ERROR: f64 = 1.0;

/// Points of the sample.
const SAMPLE: usize = 1024;

/// Rays of the sample, as a share of those of the records.
const SAMPLE_SHARE: f64 = 0.2;

/// Standard errors of a mean square that are added to it: a few points may miss what is worst.
const DOUBT: f64 = 1.0;

impl<L: DiffuseLight> GatherPass<'_, L> {
    /// Gathers at as many records as the time suffices for, whose light all points of their cells get;
    /// with at most `most_rays` from each.
    ///
    /// # Errors
    /// [`GatherError::OutOfTime`] if it suffices for hardly any, or the error is larger than the light.
    pub fn reach_coarsely(
        &self,
        all: &mut Gathering,
        goal: Option<f64>,
        most_rays: u32,
    ) -> Result<(), GatherError> {
        let termination = all.strata.termination(0);
        let left = self.run.progress.time_left().unwrap_or_default();
        let seconds_per_ray = self.pace.seconds_per_ray(termination);
        let rays = RECORDS_SHARE * left.as_secs_f64() / seconds_per_ray.max(f64::MIN_POSITIVE);
        let most = (rays / f64::from(FEWEST_RAYS)).min(self.points.len() as f64) as usize;
        if most < LEAST_RECORDS {
            return Err(GatherError::OutOfTime);
        }
        let records = ((rays / f64::from(HASTY_RAYS)) as usize).max(LEAST_RECORDS);
        let cells = RecordCells::at_most(self.points, self.seed, records.min(most));
        let most_rays = f64::from(most_rays.min(MOST_RECORD_RAYS));
        let each = (rays / cells.count() as f64).min(most_rays) as u32;
        // Sequences are best distributed in powers of two.
        let each = 1 << each.max(FEWEST_RAYS).ilog2();
        self.gather_cells(all, &cells, each)?;
        if all.relative_error() > MOST_ERROR {
            return Err(GatherError::OutOfTime);
        }
        if let Some(goal) = goal {
            let more = all.needed(goal);
            all.rays_needed = more * self.points.len() as f64 / cells.count() as f64;
            let rays = f64::from(each) * more;
            self.run.progress.measured(Measure::OutOfReach {
                error: goal,
                seconds: rays * self.points.len() as f64 * seconds_per_ray,
                rays,
            });
        }
        Ok(())
    }

    /// Gathers at the records of cells with so many rays, and measures the error of that.
    fn gather_cells(
        &self,
        all: &mut Gathering,
        cells: &RecordCells,
        rays: u32,
    ) -> Result<(), GatherError> {
        let records: Vec<u32> = cells.records().collect();
        self.run.progress.begin("irradiance", records.len() as u64);
        let irradiance = self.gather_at(&records, 0..rays, all.strata.termination(0))?;
        let irradiance: Option<Vec<SplitIrradiance>> = irradiance.into_iter().collect();
        let irradiance = irradiance.ok_or(GatherError::OutOfTime)?;
        all.values = GatheredValues::of_cells(cells, &all.strata, &irradiance);
        all.spent = vec![rays; self.points.len()];
        all.records = Some(records.len());
        all.combine();
        all.strata.divide(&all.gathered);
        let of_sample = SAMPLE_SHARE * f64::from(rays) * records.len() as f64 / SAMPLE as f64;
        self.measure_cells(all, (of_sample as u32).clamp(FEWEST_RAYS, rays))
    }

    /// States the error that comes of giving points the light of their records, by this many rays from
    /// each point of a sample.
    fn measure_cells(&self, all: &mut Gathering, rays: u32) -> Result<(), GatherError> {
        let sample = self.sample_by_area(all);
        self.run
            .progress
            .begin("comparing with paths", sample.len() as u64);
        let paths = self.gather_at(&sample, 0..rays, Termination::Roulette)?;
        let mut squares = vec![Vec::new(); all.strata.count()];
        for (&point, paths) in sample.iter().zip(&paths) {
            let Some(paths) = paths else { continue };
            let square = square_difference(all, point as usize, &paths.whole());
            squares[all.strata.of(point as usize)].push(square);
        }
        let whole = mean_with_doubt(&squares.concat()).ok_or(GatherError::OutOfTime)?;
        for (stratum, squares) in squares.iter().enumerate() {
            let mean_square = mean_with_doubt(squares).unwrap_or(whole);
            all.strata.interpolate(stratum, mean_square);
        }
        Ok(())
    }

    /// Points chosen with probabilities in proportion to the areas for which they stand.
    fn sample_by_area(&self, all: &Gathering) -> Vec<u32> {
        let mut sum = 0.0;
        let add = |share: &f64| {
            sum += share;
            sum
        };
        let ends: Vec<f64> = all.strata.shares().iter().map(add).collect();
        let last = ends.len() - 1;
        let chosen = |k: usize| {
            let chance = f64::from(uniform(&[hash(&[self.seed, 0xce11]), k as u32]));
            let place = (k as f64 + chance) / SAMPLE as f64 * ends[last];
            ends.partition_point(|&end| end <= place).min(last) as u32
        };
        (0..SAMPLE).map(chosen).collect()
    }
}

/// Square of the difference between what a point has and its path traced irradiance, less its noise,
/// (W/m²)².
fn square_difference(all: &Gathering, point: usize, paths: &Gathered) -> f64 {
    let difference = all.gathered[point].minus(paths);
    let mean = difference.mean();
    all.strata.mean_of(mean * mean) - all.strata.mean_of(difference.variance())
}

/// The mean of squares, not below zero, and its standard error on top; `None` for less than two.
fn mean_with_doubt(squares: &[f64]) -> Option<f64> {
    let count = squares.len() as f64;
    let mean = squares.iter().sum::<f64>() / count;
    let spread: f64 = squares.iter().map(|s| (s - mean).powi(2)).sum();
    let doubt = (spread / (count * (count - 1.0))).sqrt();
    (squares.len() > 1).then(|| mean.max(0.0) + DOUBT * doubt)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deadline::GatherPace;
    use crate::gather_pass::GatherLight;
    use crate::gathering::GatherTargets;
    use azulejo_scene::synthetic::{CornellVariant, cornell_box};
    use azulejo_trace::{DiffuseHit, GatherPoint, Gatherer, OutgoingRadiosity, Progress, Run};
    use azulejo_trace::{Surfaces, Tracer};
    use glam::dvec3;

    /// Nothing is known of the light: paths find it.
    struct Unknown<'a>(&'a Surfaces<'a>);

    impl DiffuseLight for Unknown<'_> {
        fn outgoing(&self, _at: &DiffuseHit, _replicate: usize) -> OutgoingRadiosity {
            OutgoingRadiosity::default()
        }

        fn reflectance(&self, at: &DiffuseHit) -> azulejo_scene::Rgb {
            self.0.material(at.hit.item).diffuse
        }
    }

    /// Points of the floor, some of them in the shadow of the blocks, by 200 of them: the stated error
    /// is that which all of them have.
    #[test]
    fn cells_know_their_error() {
        let scene = cornell_box(CornellVariant::Diffuse);
        let tracer = Tracer::new(&scene);
        let gatherer = Gatherer::new(Surfaces::new(&scene, &tracer));
        let point = |k: u32| GatherPoint {
            position: dvec3(
                5.0 + 9.0 * f64::from(k % 60),
                0.0,
                5.0 + 9.0 * f64::from(k / 60),
            ),
            normal: glam::DVec3::Y,
            key: k,
        };
        let points: Vec<GatherPoint> = (0..3600).map(point).collect();
        let light = Unknown(gatherer.surfaces());
        let progress = Progress::new();
        let pass = GatherPass {
            gatherer: &gatherer,
            light: GatherLight::new(&light, None),
            points: &points,
            pace: &GatherPace::default(),
            seed: 3,
            run: Run::alone(&progress),
        };
        let targets = GatherTargets {
            points: &points,
            areas: &[],
        };
        let all_points: Vec<u32> = (0..3600).collect();
        let truth = pass
            .gather_at(&all_points, 0..256, Termination::Roulette)
            .unwrap();
        let mut all = Gathering::new(targets);
        all.strata.trace_paths(0);
        let cells = RecordCells::at_most(&points, 3, 200);
        assert!((50..=200).contains(&cells.count()), "{}", cells.count());
        pass.gather_cells(&mut all, &cells, 64).unwrap();
        assert_eq!(all.records, Some(cells.count()));
        assert!(all.interpolated() > 0.9);
        let (mut squares, mut sum) = (0.0, 0.0);
        for (gathered, truth) in all.gathered.iter().zip(&truth) {
            let truth = truth.unwrap().whole();
            let off = gathered.minus(&truth).mean();
            squares += (off * off).mean() - truth.variance().mean();
            sum += truth.mean().mean();
        }
        let error = (squares / 3600.0).sqrt() / (sum / 3600.0);
        let stated = all.relative_error();
        assert!(error > 0.03, "{error}");
        assert!(
            (0.85..1.3).contains(&(stated / error)),
            "{stated} of {error}"
        );
    }
}
