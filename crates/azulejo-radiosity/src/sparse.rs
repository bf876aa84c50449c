//! Irradiance at many points from that at fewer: direct light at every point, indirect light at
//! [records](crate::records), [interpolated](crate::interpolation) between them.
//!
//! Records are first chosen evenly. Leaving out one of them and interpolating it from the others
//! measures the error of interpolation, over thousands of records to a small part of their noise;
//! cells are divided where it is largest, until it is a small part of the error that is permitted.
//! What remains is part of the stated error.

use crate::gather_pass::GatherPass;
use crate::gathered_values::{GatheredValues, PointKind};
use crate::gathering::{GatherEffort, GatherError, GatherTargets, Gathering, well_spread};
use crate::interpolation::{Interpolator, Stencil};
use crate::records::RecordCells;
use azulejo_trace::{Cancelled, DiffuseLight, GatherPoint, Gathered, SplitIrradiance};

/// Fewest points at which indirect light is interpolated: fewer are soon gathered.
pub const LEAST_POINTS: usize = 4096;

/// Records to begin with: one for this many points.
const POINTS_PER_RECORD: usize = 32;

/// Records to begin with, at least.
const LEAST_RECORDS: usize = 1000;

/// Part of the mean square error permitted to a stratum that interpolation may make up.
const SHARE: f64 = 0.2;

/// Mean square error of interpolation at a point relative to that at a record that was left out: at
/// the edge of a shadow a half, because twice as many points are beyond the next record; where light
/// is smooth much less, because errors grow with the square of the distance.
const LEFT_OUT: f64 = 0.5;

/// The same after its cell was divided.
const DIVIDED: f64 = 0.25;

/// A point is gathered if its records tell each other so badly, relative to the mean square error
/// that interpolation may make.
const MOST_LOCAL: f64 = 4.0;

/// Most divisions of a cell.
const MOST_ROUNDS: usize = 6;

/// Rays, for direct light alone, of the first pass over the points between records.
const DIRECT_RAYS: u32 = 64;

/// The error of a stratum by interpolation, while it is summed.
#[derive(Clone, Copy, Default)]
struct StatedError {
    /// Area of all points, of those that are interpolated, and the sum of these times the mean square
    /// errors, (W/m²)².
    all: f64,
    interpolated: f64,
    squares: f64,
}

impl StatedError {
    /// Mean square over all points, with a mean `doubt` at those that are interpolated.
    fn mean(&self, doubt: f64) -> f64 {
        // Errors of single neighbourhoods are noise on both sides of the truth; their mean is not.
        let sum = self.squares.max(0.0) + doubt * self.interpolated;
        sum / self.all.max(f64::MIN_POSITIVE)
    }
}

/// The records of a gather, each of which stands for the points of its cell.
struct RecordGather {
    cells: RecordCells,
    /// Index of each record among all points.
    records: Vec<u32>,
    points: Vec<GatherPoint>,
    found: Gathering,
    /// How each follows from the others.
    left_out: Vec<Option<Stencil>>,
}

/// Gathers at records, chooses more of them where interpolation is too coarse, and gathers direct
/// light at all points.
pub(crate) fn gather_sparse<L: DiffuseLight>(
    pass: &GatherPass<L>,
    targets: GatherTargets,
    effort: GatherEffort,
    watch: &mut dyn FnMut(&Gathering),
) -> Result<Gathering, GatherError> {
    let count = (targets.points.len() / POINTS_PER_RECORD).max(LEAST_RECORDS);
    let cells = RecordCells::new(targets.points, pass.seed, count);
    let mut chosen = RecordGather::new(pass, targets, cells)?;
    let of_records = GatherPass {
        points: &chosen.points,
        ..*pass
    };
    of_records.reach(&mut chosen.found, effort, &mut |_| ())?;
    let goal = effort.error.unwrap_or(0.0);
    for _ in 0..MOST_ROUNDS {
        let errors = chosen.interpolation_errors();
        let coarse = chosen.coarse_cells(&errors, goal);
        if pass.run.progress.phase_is_over() || !coarse.contains(&true) {
            break;
        }
        chosen = chosen.divided(pass, targets, &coarse)?;
    }
    chosen.spread(pass, targets, effort, watch)
}

impl RecordGather {
    fn new<L: DiffuseLight>(
        pass: &GatherPass<L>,
        targets: GatherTargets,
        cells: RecordCells,
    ) -> Result<RecordGather, Cancelled> {
        let records: Vec<u32> = cells.records().collect();
        let points: Vec<GatherPoint> = records
            .iter()
            .map(|&i| targets.points[i as usize])
            .collect();
        let area = |cell: &[u32]| -> f64 {
            match targets.areas {
                [] => cell.len() as f64,
                areas => cell.iter().map(|&i| areas[i as usize]).sum(),
            }
        };
        let areas: Vec<f64> = cells.points().map(area).collect();
        let interpolator = Interpolator::new(pass.gatherer.surfaces().tracer, &points);
        let left_out = interpolator.left_out(pass.run)?;
        let around = interpolator.stencils(&points, pass.run)?;
        let alone = |(r, stencil): (usize, Option<Stencil>)| {
            stencil.unwrap_or_else(|| Stencil::alone(r as u32))
        };
        let stencils = around.into_iter().enumerate().map(alone).collect();
        let nothing = Gathering::new(GatherTargets {
            points: &points,
            areas: &areas,
        });
        let record_of = (0..records.len() as u32).map(Some).collect();
        let gathering = Gathering {
            values: GatheredValues::at_records(record_of, stencils, &nothing.strata),
            ..nothing
        };
        Ok(RecordGather {
            cells,
            records,
            points,
            found: gathering,
            left_out,
        })
    }

    /// What was gathered at a record.
    fn known(&self, record: usize) -> SplitIrradiance {
        SplitIrradiance {
            direct: self.found.values.direct()[record],
            indirect: self.found.values.indirect_of_records()[record],
        }
    }

    /// Of each record the square of the difference that interpolating it from the others makes, less
    /// its noise, and the variance of that noise.
    fn interpolation_errors(&self) -> Vec<Option<(f64, f64)>> {
        let indirect = self.found.values.indirect_of_records();
        let strata = &self.found.strata;
        let error = |(own, stencil): (&Gathered, &Option<Stencil>)| {
            let difference = own.minus(&stencil.as_ref()?.apply(indirect));
            let (mean, noise) = (difference.mean(), strata.mean_of(difference.variance()));
            Some((strata.mean_of(mean * mean) - noise, noise))
        };
        indirect.iter().zip(&self.left_out).map(error).collect()
    }

    /// The mean square error of interpolating a point by a stencil, with its standard error; `None`
    /// where the records are too few to know.
    fn local_error(&self, stencil: &Stencil, errors: &[Option<(f64, f64)>]) -> Option<(f64, f64)> {
        let (mut sum, mut doubt, mut known, mut all) = (0.0, 0.0, 0.0, 0.0);
        for (record, weight) in stencil.weights() {
            let weight = weight.abs();
            all += weight;
            if let Some((square, noise)) = errors[record] {
                sum += weight * square;
                doubt += (weight * noise).powi(2);
                known += weight;
            }
        }
        let scale = LEFT_OUT / known;
        (2.0 * known > all).then_some((scale * sum, scale * (4.0 * doubt).sqrt()))
    }

    /// The error of each stratum by interpolation, (W/m²)², with its standard error.
    fn stratum_errors(&self, errors: &[Option<(f64, f64)>]) -> Vec<(f64, f64)> {
        let strata = &self.found.strata;
        let of = |stratum: usize| {
            let (mut sum, mut doubt, mut count) = (0.0, 0.0, 0.0);
            for &i in strata.points(stratum) {
                let share = strata.share(i as usize);
                count += share;
                if let Some((square, noise)) = errors[i as usize] {
                    sum += share * square;
                    doubt += (share * noise).powi(2);
                }
            }
            let scale = LEFT_OUT / f64::max(count, f64::MIN_POSITIVE);
            (scale * sum.max(0.0), scale * (4.0 * doubt).sqrt())
        };
        (0..strata.count()).map(of).collect()
    }

    /// The cells to be divided so that interpolation is only a small part of `goal`: those with the
    /// largest errors, by the mean of theirs and their neighbours'.
    fn coarse_cells(&self, errors: &[Option<(f64, f64)>], goal: f64) -> Vec<bool> {
        let strata = &self.found.strata;
        let permitted = strata.permitted(&self.found.errors(), goal);
        let pooled = |r: usize| {
            let stencil = self.left_out[r].as_ref()?;
            let known = stencil.weights().filter_map(|(n, _)| errors[n]);
            let own = errors[r].into_iter();
            let (sum, count) = own
                .chain(known)
                .fold((0.0, 0), |(sum, n), e| (sum + e.0, n + 1));
            Some(sum / f64::from(count))
        };
        let pooled: Vec<f64> = (0..errors.len())
            .map(|r| pooled(r).map_or(0.0, |e| e.max(0.0)))
            .collect();
        let mut is_coarse = vec![false; errors.len()];
        for (stratum, (square, doubt)) in self.stratum_errors(errors).into_iter().enumerate() {
            let allowed = SHARE * permitted[stratum];
            if square <= allowed.max(doubt) {
                continue;
            }
            let points = strata.points(stratum);
            let total: f64 = points.iter().map(|&i| strata.share(i as usize)).sum();
            let mut worst: Vec<u32> = points.to_vec();
            worst.sort_by(|&a, &b| pooled[b as usize].total_cmp(&pooled[a as usize]));
            let mut left = square;
            for i in worst {
                let i = i as usize;
                if left <= 0.8 * allowed || pooled[i] == 0.0 {
                    break;
                }
                is_coarse[i] = true;
                left -= (1.0 - DIVIDED) * LEFT_OUT * pooled[i] * strata.share(i) / total;
            }
        }
        is_coarse
    }

    /// Divides cells, and gathers at their new records as at those before them.
    fn divided<L: DiffuseLight>(
        &self,
        pass: &GatherPass<L>,
        targets: GatherTargets,
        is_coarse: &[bool],
    ) -> Result<RecordGather, GatherError> {
        let mut cells = self.cells.clone();
        let parents = cells.divide(is_coarse);
        let mut next = RecordGather::new(pass, targets, cells)?;
        let areas = next.found.strata.shares();
        next.found.strata = self.found.strata.spread(&parents, areas);
        let mut totals = vec![0; parents.len()];
        for (new, &parent) in parents.iter().enumerate() {
            let parent = parent as usize;
            totals[new] = self.found.spent[parent];
            if next.records[new] != self.records[parent] {
                continue;
            }
            next.found.values.add(new, &self.known(parent), 1.0);
            next.found.spent[new] = self.found.spent[parent];
        }
        let of_records = GatherPass {
            points: &next.points,
            ..*pass
        };
        of_records.raise(&mut next.found, &totals)?;
        Ok(next)
    }

    /// Gathers direct light at all points, and everything where the records are too far away.
    fn spread<L: DiffuseLight>(
        self,
        pass: &GatherPass<L>,
        targets: GatherTargets,
        effort: GatherEffort,
        watch: &mut dyn FnMut(&Gathering),
    ) -> Result<Gathering, GatherError> {
        let count = targets.points.len();
        let tracer = pass.gatherer.surfaces().tracer;
        let mut parents = vec![0; count];
        for (record, cell) in self.cells.points().enumerate() {
            cell.iter()
                .for_each(|&i| parents[i as usize] = record as u32);
        }
        let strata = self.found.strata.spread(&parents, targets.areas);
        let errors = self.interpolation_errors();
        let goal = effort.error.unwrap_or(0.0);
        let permitted = strata.permitted(&self.found.errors(), goal);
        let stencils =
            Interpolator::new(tracer, &self.points).stencils(targets.points, pass.run)?;
        let mut stated = vec![StatedError::default(); strata.count()];
        let checked = stencils.into_iter().enumerate().map(|(i, stencil)| {
            let (stratum, share) = (strata.of(i), strata.share(i));
            // Points that are gathered have no error of interpolation, but count.
            stated[stratum].all += share;
            let stencil = stencil?;
            let (error, doubt) = self.local_error(&stencil, &errors)?;
            let most = MOST_LOCAL * SHARE * permitted[stratum];
            if error > most.max(doubt) {
                return None;
            }
            stated[stratum].interpolated += share;
            stated[stratum].squares += share * error;
            Some(stencil)
        });
        let interpolations: Vec<Option<Stencil>> = checked.collect();
        let mut record_of = vec![None; count];
        for (record, &i) in self.records.iter().enumerate() {
            record_of[i as usize] = Some(record as u32);
        }
        let mut next = self.records.len() as u32;
        let mut stencils = Vec::with_capacity(count);
        for (i, stencil) in interpolations.into_iter().enumerate() {
            stencils.push(stencil.unwrap_or_else(|| {
                Stencil::alone(*record_of[i].get_or_insert_with(|| {
                    next += 1;
                    next - 1
                }))
            }));
        }
        let mut all = Gathering {
            values: GatheredValues::at_records(record_of, stencils, &strata),
            strata,
            ..Gathering::new(targets)
        };
        let doubts = self.stratum_errors(&errors);
        for (stratum, (stated, (_, doubt))) in stated.into_iter().zip(doubts).enumerate() {
            all.strata.interpolate(stratum, stated.mean(0.5 * doubt));
        }
        for (record, &i) in self.records.iter().enumerate() {
            all.values.add(i as usize, &self.known(record), 1.0);
            all.spent[i as usize] = self.found.spent[record];
        }
        // What the record of a cell took, by the root of the area, as rays are distributed.
        let cell_weights: Vec<f64> = (self.cells.points())
            .map(|cell| {
                let sum: f64 = cell.iter().map(|&i| all.strata.weight(i as usize)).sum();
                sum / cell.len() as f64
            })
            .collect();
        let total = |i: usize| match all.values.kind(i) {
            PointKind::Record => {
                let cell = parents[i] as usize;
                let relative = (all.strata.weight(i) / cell_weights[cell]).sqrt();
                let rays = relative * f64::from(self.found.spent[cell]);
                well_spread(all.spent[i], rays, effort.most())
            }
            PointKind::Interpolated => DIRECT_RAYS.min(effort.most()),
        };
        let totals: Vec<u32> = (0..count).map(total).collect();
        pass.raise(&mut all, &totals)?;
        if all.spent.contains(&0) {
            return Err(GatherError::OutOfTime);
        }
        pass.spend(&mut all, effort, watch)?;
        Ok(all)
    }
}
