//! One row of the matrix by itself: what a single patch sees.

use super::merge::{better, sum};
use super::near::{self, PairEstimate};
use super::rows::{RayEntry, RowTracing};
use super::{FormFactorOptions, Plan, PreparedPlan};
use crate::engine::Engine;
use crate::error::FactorsError;
use crate::patch::Patches;
use azulejo_scene::Scene;
use azulejo_scene::math::Ray;
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, Progress, Tracer};

/// A form factor with its standard error, both shares of what leaves the row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Factor {
    /// X_ij, as [`FormFactors`](super::FormFactors) defines it.
    pub value: f64,
    /// Its standard error: the truth lies within two of them 95 times in 100.
    pub error: f64,
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
        let rows = tracing.block(&[row], progress)?;
        let area = sides.area(row);
        let by_rays = |entries: &[RayEntry]| -> Vec<PairEstimate> {
            let estimates = entries.iter().map(|e| tracing.pair_estimate(row, e));
            estimates.collect()
        };
        let mut factors = vec![Factor::default(); sides.len()];
        for traced in &rows {
            let direct = better(&exact[row], &by_rays(&traced.near));
            let far = traced.far.iter().map(|far| by_rays(far));
            for e in far.fold(direct, |total, far| sum(&total, &far)) {
                factors[e.column as usize] = Factor {
                    value: e.value / area,
                    error: e.error / area,
                };
            }
        }
        Ok(factors)
    }
}

impl RowTracing<'_> {
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
