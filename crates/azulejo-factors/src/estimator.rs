//! Rows of form factors by any of the engines.

pub use crate::analytic_engine::estimator::AnalyticEstimator;
use crate::engine::{Engine, EngineUsed, Hemicube};
use crate::hemicube::{HemicubeEstimator, MirrorHandling};
use crate::patch::Patches;
use crate::rays::RayEstimator;
use crate::row::{Columns, Row, Side};
use crate::samples::RowSamples;
use azulejo_trace::{Cancelled, Gatherer, Progress};

/// Computes rows of form factors by one of the engines. Immutable; shared by all threads.
pub enum Estimator<'a> {
    /// By rays.
    Rays(RayEstimator<'a>),
    /// By item buffers.
    Hemicube(Box<HemicubeEstimator<'a>>),
    /// By formulas.
    Analytic(Box<AnalyticEstimator<'a>>),
}

impl<'a> Estimator<'a> {
    /// The estimator of an engine; engines that trace rays take `rays` per row.
    pub fn new(
        engine: &Engine,
        gatherer: &'a Gatherer<'a>,
        patches: &'a Patches,
        rays: u32,
        seed: u32,
        columns: Columns,
    ) -> Estimator<'a> {
        let samples = RowSamples::of_rays(rays);
        Estimator::sampled(engine, gatherer, patches, &samples, seed, columns)
    }

    /// The same where each patch has a number of samples of its own. The analytic engine takes the largest of
    /// them for all.
    pub fn sampled(
        engine: &Engine,
        gatherer: &'a Gatherer<'a>,
        patches: &'a Patches,
        samples: &RowSamples,
        seed: u32,
        columns: Columns,
    ) -> Estimator<'a> {
        let drawn = |options: &Hemicube, mirrors: MirrorHandling| {
            let new = HemicubeEstimator::new;
            let points = samples.hemicubes.as_ref();
            let estimator = new(options, points, mirrors, gatherer, patches, seed, columns);
            Estimator::Hemicube(Box::new(estimator))
        };
        let rays = &samples.rays;
        match engine {
            Engine::Hemicube(options) => drawn(options, MirrorHandling::Windows),
            Engine::Hybrid(options) => drawn(options, MirrorHandling::Rays),
            Engine::Analytic => {
                let new = AnalyticEstimator::new;
                let estimator = new(gatherer, patches, rays.most(), seed, columns);
                Estimator::Analytic(Box::new(estimator))
            }
            // Automatic choices are made before this; rays handle every scene.
            Engine::Auto | Engine::Rays | Engine::Particles => {
                let new = RayEstimator::with_counts;
                Estimator::Rays(new(gatherer, patches, rays, seed, columns))
            }
        }
    }

    /// The engine and its device; after the last row also deviations from what was requested, such
    /// as a lost device.
    pub fn engine_used(&self) -> EngineUsed {
        match self {
            Estimator::Rays(estimator) => EngineUsed::new("rays", estimator.kernel_name()),
            Estimator::Hemicube(estimator) => estimator.engine_used(),
            Estimator::Analytic(estimator) => estimator.engine_used(),
        }
    }

    /// Rays or pixels per row, the largest number of all rows.
    pub fn rays(&self) -> u32 {
        match self {
            Estimator::Rays(estimator) => estimator.rays(),
            Estimator::Hemicube(estimator) => estimator.pixels(),
            Estimator::Analytic(estimator) => estimator.rays(),
        }
    }

    /// Rays or pixels of the row of a side.
    pub fn rays_of(&self, side: Side) -> u32 {
        match self {
            Estimator::Rays(estimator) => estimator.rays_of(side),
            Estimator::Hemicube(estimator) => estimator.pixels_of(side),
            Estimator::Analytic(estimator) => estimator.rays(),
        }
    }

    /// Steps of progress of the row of a side: one, or more the more samples it takes where their numbers
    /// differ.
    pub fn steps(&self, side: Side) -> u64 {
        match self {
            Estimator::Rays(estimator) => estimator.steps(side),
            Estimator::Hemicube(estimator) => estimator.steps(side),
            Estimator::Analytic(_) => 1,
        }
    }

    /// Whether all entries of a row share a handful of viewpoints.
    pub(crate) fn shares_viewpoints(&self) -> bool {
        matches!(self, Estimator::Hemicube(_))
    }

    /// Whether replicates of a row are independent, so that their spread tells its error.
    pub(crate) fn knows_its_spread(&self) -> bool {
        match self {
            Estimator::Hemicube(estimator) => estimator.knows_its_spread(),
            Estimator::Rays(_) | Estimator::Analytic(_) => true,
        }
    }

    /// The rows of some sides, in order; each depends on its side alone. Advances `progress` by the
    /// [steps](Estimator::steps) of each.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn rows(&self, sides: &[Side], progress: &Progress) -> Result<Vec<Row>, Cancelled> {
        match self {
            Estimator::Rays(estimator) => estimator.rows(sides, progress),
            Estimator::Hemicube(estimator) => estimator.rows(sides, progress),
            Estimator::Analytic(estimator) => estimator.rows(sides, progress),
        }
    }
}
