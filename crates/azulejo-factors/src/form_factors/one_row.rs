//! One row of the matrix by itself: what a single patch sees.

use super::merge::{better, sum};
use super::near::{self, PairEstimate};
use super::rows::{RayEntry, RowTracing};
use super::spread::mean_and_variance;
use super::{FormFactorOptions, Plan, PreparedPlan};
use crate::engine::Engine;
use crate::error::FactorsError;
use crate::patch::Patches;
use crate::row::Row;
use azulejo_scene::Scene;
use azulejo_scene::math::Ray;
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, Progress, REPLICATES, Tracer};

/// A form factor with its standard error, both shares of what leaves the row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Factor {
    /// X_ij, as [`FormFactors`](super::FormFactors) defines it.
    pub value: f64,
    /// Its standard error: the truth lies within two of them 95 times in 100.
    pub error: f64,
}

/// The form factor from a row to a group of columns, such as the patches of an object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroupFactor {
    /// The sum over the columns, with its standard error.
    pub factor: Factor,
    /// The independent estimates whose mean it is; `None` where formulas take part.
    pub estimates: Option<[f64; REPLICATES]>,
}

/// One row, and its sums over groups of columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GroupedRow {
    /// The form factor to each column.
    pub factors: Vec<Factor>,
    /// The form factor to each group.
    pub groups: Vec<GroupFactor>,
}

/// The form factors from one patch.
pub struct FactorsFrom {
    /// The patches of the scene.
    pub patches: Patches,
    /// The form factor to each column: to each patch, or to each side of one with `two_sided`.
    pub factors: Vec<Factor>,
}

/// Form factors from one patch to all, in the time of one row: `patch` is a row of the matrix that
/// [`form_factors`](super::form_factors()) computes with the same options.
///
/// A single row makes no use of reciprocity or closure, so its errors are somewhat larger than in
/// the matrix. Formulas supply the direct part of all flat pairs, if the options or the engine use
/// them; rays or hemicubes supply the rest. For several rows, use one [`PreparedPlan`].
///
/// # Errors
/// [`FactorsError::NoSurface`], [`FactorsError::TooLarge`], [`FactorsError::Cancelled`].
///
/// # Panics
/// If there is no such row.
///
/// ```
/// use azulejo_factors::{FormFactorOptions, PatchSize, form_factors_from};
/// use azulejo_scene::synthetic::cube_room;
/// use azulejo_trace::{Progress, Tracer};
///
/// let scene = cube_room();
/// let whole = FormFactorOptions { size: PatchSize::Edge(0.0), ..Default::default() };
/// let from = form_factors_from(&scene, &Tracer::new(&scene), 0, &whole, &Progress::new())?;
/// assert!((from.factors[1].value - 0.19982489569839).abs() < 1e-9);
/// let corners = from.patches.polygon(1).expect("a cube is flat").to_vec();
/// assert_eq!(corners.len(), 4);
/// # Ok::<(), azulejo_factors::FactorsError>(())
/// ```
pub fn form_factors_from(
    scene: &Scene,
    tracer: &Tracer,
    patch: usize,
    options: &FormFactorOptions,
    progress: &Progress,
) -> Result<FactorsFrom, FactorsError> {
    let plan = Plan::new(scene, tracer, options)?;
    let factors = plan.prepare().row(patch, progress)?;
    Ok(FactorsFrom {
        factors,
        patches: plan.patches,
    })
}

impl Plan<'_> {
    /// The first patch that a ray hits.
    pub fn patch_at(&self, ray: &Ray) -> Option<usize> {
        let hit = self.proxy.tracer.hit(ray)?;
        let (u, v) = (hit.u as f32, hit.v as f32);
        let patch = self
            .patches
            .locate(hit.object, hit.face, hit.triangle, u, v);
        Some(patch as usize)
    }
}

impl PreparedPlan<'_> {
    /// The form factors of one row to each column, as [`form_factors_from`] computes them.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, row: usize, progress: &Progress) -> Result<Vec<Factor>, Cancelled> {
        Ok(self.grouped_row(row, &[], 0, progress)?.factors)
    }

    /// The same with sums over `count` groups; `groups` has the group of each column that is in one.
    ///
    /// The error of a sum comes from the spread of its own independent estimates, so what the errors of its columns
    /// have in common counts. Where formulas take part, errors are added up as independent.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// If there is no such row, or a group is not below `count`.
    pub fn grouped_row(
        &self,
        row: usize,
        groups: &[Option<u32>],
        count: usize,
        progress: &Progress,
    ) -> Result<GroupedRow, Cancelled> {
        let sides = &self.sides;
        let is_analytic = self.engine == Engine::Analytic;
        let mut exact = vec![Vec::new(); sides.len()];
        if self.uses_formulas() || is_analytic {
            let surfaces = self.gatherer.surfaces();
            let seed = hash(&[self.seed, 0]);
            exact[row] = near::exact_row(sides, surfaces, row, seed, progress)?;
        }
        let estimator = if is_analytic {
            self.ray_estimator(self.plan.options.rays, hash(&[self.seed, 1]))
        } else {
            self.sampled_estimator(&self.engine)
        };
        let tracing = RowTracing {
            exact: &exact,
            estimates: 1.0,
            ..RowTracing::new(self, &estimator)
        };
        progress.begin("form factors", 1);
        let estimated = estimator.rows(&[sides.side(row)], progress)?;
        let area = sides.area(row);
        let by_rays = |entries: &[RayEntry]| -> Vec<PairEstimate> {
            let estimates = entries.iter().map(|e| tracing.pair_estimate(row, e));
            estimates.collect()
        };
        let mut factors = vec![Factor::default(); sides.len()];
        for raw in &estimated {
            let traced = tracing.ray_row(row, raw);
            let direct = better(&exact[row], &by_rays(&traced.near));
            let far = traced.far.iter().map(|far| by_rays(far));
            for e in far.fold(direct, |total, far| sum(&total, &far)) {
                factors[e.column as usize] = Factor {
                    value: e.value / area,
                    error: e.error / area,
                };
            }
        }
        let mut sums = added(&factors, groups, count);
        if exact[row].is_empty() {
            for raw in &estimated {
                tracing.set_estimates(row, raw, groups, &mut sums);
            }
        }
        let groups = sums.into_iter().map(|sum| sum.group).collect();
        Ok(GroupedRow { factors, groups })
    }
}

/// The sum over a group of columns.
#[derive(Clone, Copy, Default)]
struct GroupSum {
    group: GroupFactor,
    /// Columns that are not zero.
    columns: usize,
}

/// The sums of factors whose errors are independent.
fn added(factors: &[Factor], groups: &[Option<u32>], count: usize) -> Vec<GroupSum> {
    let mut sums = vec![GroupSum::default(); count];
    for (factor, group) in factors.iter().zip(groups) {
        let Some(group) = group.filter(|_| *factor != Factor::default()) else {
            continue;
        };
        let sum = &mut sums[group as usize];
        sum.group.factor.value += factor.value;
        sum.group.factor.error = sum.group.factor.error.hypot(factor.error);
        sum.columns += 1;
    }
    sums
}

impl RowTracing<'_> {
    /// Sets the estimates of sums by a row without formulas, and from them the errors of those of several columns.
    fn set_estimates(&self, row: usize, raw: &Row, groups: &[Option<u32>], sums: &mut [GroupSum]) {
        let mut estimates = vec![[0.0; REPLICATES]; sums.len()];
        for (replicate, entries) in raw.entries.iter().enumerate() {
            for entry in entries {
                let column = self
                    .sides
                    .column(entry.side / 2, entry.side.is_multiple_of(2));
                let group = column.and_then(|c| *groups.get(c as usize)?);
                if let Some(group) = group {
                    estimates[group as usize][replicate] += entry.weight.mean();
                }
            }
        }
        for (sum, estimates) in sums.iter_mut().zip(estimates) {
            sum.group.estimates = Some(estimates);
            if sum.columns > 1 {
                let (value, variance) = mean_and_variance(estimates);
                let error = self.noise().error(value, variance, self.hit(row));
                sum.group.factor = Factor { value, error };
            }
        }
    }

    /// The estimate of a pair by one row's rays alone, as an exchange area.
    fn pair_estimate(&self, row: usize, entry: &RayEntry) -> PairEstimate {
        let (value, area) = (f64::from(entry.mean), self.sides.area(row));
        let error = self
            .noise()
            .error(value, entry.variance.into(), self.hit(row));
        PairEstimate {
            column: entry.column,
            value: value * area,
            error: error * area,
        }
    }
}
