//! The matrix of form factors, with a standard error for every entry.
//!
//! 1. [`Plan`] divides the scene; [`PreparedPlan`] chooses the engine and forecasts the memory.
//! 2. `near` finds the pairs for which a formula pays: close ones, and those with emitters. Their
//!    direct part is the exact form factor times the visible fraction.
//! 3. `rows` asks the engine for the rows of all sides. Finished blocks are kept by a [`Run`].
//! 4. `merge` makes one exchange area of the two estimates that the sides of a pair give.
//! 5. [`FormFactors::close`] enforces closure: changes entries within their errors so that no
//!    light is missing.
//!
//! [`form_factors()`] does all of it, in this order. [`FormFactors::grouped`] and
//! [`FormFactors::truncate`] derive smaller matrices, [`FormFactors::interchange`] one that
//! includes all reflections. [`form_factors_from`] computes a single row, and
//! [`PreparedPlan::factors_from_points`] what sensors see.

mod analytic;
mod boxes;
mod closure;
mod design_effect;
mod doubt;
mod enclosure;
mod forecast;
mod group;
mod group_plan;
mod matrix;
mod merge;
mod near;
mod one_row;
mod options;
mod outside;
mod parallel;
mod points;
mod remainder;
pub(crate) mod row_stream;
mod rows;
mod shaft;
mod sides;
mod sky_patches;
mod smoothing;
mod spread;
mod truncate;

use crate::choice::EngineChoice;
use crate::engine::Engine;
use crate::error::FactorsError;
use crate::estimator::Estimator;
pub use crate::exchange_areas::{Exchange, ExchangeAreas};
use crate::patch::{PatchSize, Patches};
use crate::proxy::ProxyScene;
use crate::rays::RayEstimator;
use crate::row::Columns;
use crate::samples::{RowSamples, SampleCounts};
use azulejo_scene::{Material, MaterialId, Rgb, Scene};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Gatherer, Progress, Run, Surfaces, Tracer};
pub use closure::NOT_RECONCILED;
pub use design_effect::DesignEffect;
pub use enclosure::{InterchangeError, Scaled};
use forecast::Costs;
pub use forecast::Forecast;
use glam::DVec3;
use group_plan::GroupAreas;
pub use group_plan::GroupBy;
pub use matrix::{Adjustment, FormFactors, RowRemainder, Truncation};
pub use one_row::{Factor, FactorsFrom, GroupFactor, GroupedRow, form_factors_from};
pub use options::{Closure, FormFactorOptions, MOST_RAYS};
pub use points::{FactorPoint, PointFactors};
use rows::RowTracing;
use sides::Sides;
pub use sky_patches::SkyFactors;
use std::sync::OnceLock;

/// Computes the form factors of a scene; lights matter only for the choice of formulas.
///
/// Rows of exact shapes are pieces of the polygons that [`faceted`](crate::faceted) puts in their
/// place. The result is the same to the bit for any number of threads. Besides the result it
/// takes 12 bytes for each entry that rays found.
///
/// # Errors
/// [`FactorsError::NoSurface`], [`FactorsError::TooLarge`], [`FactorsError::Cancelled`].
///
/// ```
/// use azulejo_factors::{FormFactorOptions, PatchSize, form_factors};
/// use azulejo_scene::synthetic::cube_room;
/// use azulejo_trace::{Progress, Tracer};
///
/// let scene = cube_room();
/// let whole = FormFactorOptions { size: PatchSize::Edge(0.0), ..Default::default() };
/// let factors = form_factors(&scene, &Tracer::new(&scene), &whole, &Progress::new())?;
/// let (opposite, error) = factors.get(0, 1);
/// assert!((opposite - 0.19982489569839).abs() < 1e-9, "{opposite} ± {error}");
/// # Ok::<(), azulejo_factors::FactorsError>(())
/// ```
pub fn form_factors(
    scene: &Scene,
    tracer: &Tracer,
    options: &FormFactorOptions,
    progress: &Progress,
) -> Result<FormFactors, FactorsError> {
    let plan = Plan::new(scene, tracer, options)?;
    plan.prepare().compute(progress)
}

/// A scene divided into the patches whose form factors are computed.
pub struct Plan<'a> {
    options: &'a FormFactorOptions,
    proxy: ProxyScene<'a>,
    patches: Patches,
}

impl<'a> Plan<'a> {
    /// Divides the scene.
    ///
    /// # Errors
    /// [`FactorsError::NoSurface`]; [`FactorsError::TooLarge`] if not even the patches fit in
    /// memory.
    pub fn new(
        scene: &'a Scene,
        tracer: &'a Tracer,
        options: &'a FormFactorOptions,
    ) -> Result<Plan<'a>, FactorsError> {
        let (proxy_size, size) = match options.groups {
            None => (options.size, options.size),
            Some(_) => (group_plan::PROXY_SIZE, group_plan::size(&options.engine)),
        };
        if let PatchSize::Count(rows) | PatchSize::Squares(rows) = size {
            refuse(options, rows, rows as f64 * forecast::PATCH_BYTES)?;
        }
        let proxy = ProxyScene::new(scene, tracer, proxy_size);
        let patches = Patches::new(&proxy.scene, size);
        if patches.is_empty() {
            return Err(FactorsError::NoSurface);
        }
        Ok(Plan {
            options,
            proxy,
            patches,
        })
    }

    /// What in the scene makes form factors wrong without a trace in their sums, in sentences: faces that overlap
    /// in one plane, and faces without area. Empty if there is nothing of the kind.
    pub fn flaws(&self) -> Vec<String> {
        self.patches
            .flaws(&self.proxy.scene, self.options.two_sided)
    }

    /// The patches.
    pub fn patches(&self) -> &Patches {
        &self.patches
    }

    /// Chooses the engine and sets up what every engine needs: once for a forecast, the matrix
    /// and any number of rows.
    pub fn prepare(&self) -> PreparedPlan<'_> {
        PreparedPlan::new(self)
    }

    /// Whether closure is to be enforced; materials that no patch has do not matter.
    fn is_to_close(&self, factors: &mut FormFactors) -> bool {
        let materials = self.patches.materials_in_use(&self.proxy.scene);
        let is_coloured = materials.iter().any(|m| !m.mirror.is_grey());
        let has_glass = materials.iter().any(|m| m.dielectric.is_some());
        let has_gloss = materials.iter().any(|m| m.glossy().is_some());
        match self.options.closure {
            Closure::Never => false,
            Closure::Closed => factors.is_closed && !materials.iter().any(|m| m.is_specular()),
            Closure::Always if is_coloured || has_glass || has_gloss => {
                let why = match (has_glass, has_gloss) {
                    (true, _) => "there is glass",
                    (_, true) => "there are glossy surfaces",
                    _ => "mirrors are coloured",
                };
                let note = format!("rows were not closed, because {why}");
                factors.engine_used.notes.push(note);
                false
            }
            Closure::Always => true,
        }
    }
}

/// Most rays of a row that is computed for the forecast.
const FORECAST_RAYS: u32 = 4_096;

/// A plan with its engine chosen, ready to forecast and to compute.
pub struct PreparedPlan<'a> {
    plan: &'a Plan<'a>,
    sides: Sides<'a>,
    gatherer: Gatherer<'a>,
    seed: u32,
    engine: Engine,
    /// Why this engine, if it was chosen automatically.
    why: Option<String>,
    /// Seconds of counted work after which a row of formulas is left to rays; infinite where formulas were
    /// asked for.
    row_budget: f64,
    /// RMS error of the sums of rows by formulas, unless the usual.
    accuracy: Option<f64>,
    /// Seconds of CPU time of the chosen engine, if it was chosen automatically.
    seconds: Option<f64>,
    /// The groups for which everything is planned.
    groups: Option<GroupAreas>,
    /// Rays and hemicubes of rows.
    samples: RowSamples,
    /// The forecast, once there is one.
    forecast: OnceLock<Forecast>,
}

impl<'a> PreparedPlan<'a> {
    fn new(plan: &'a Plan<'a>) -> PreparedPlan<'a> {
        let (scene, tracer) = (&plan.proxy.scene, &plan.proxy.tracer);
        let seed = plan.options.seed;
        // Where only sums over groups are needed, each row takes the samples that these need.
        let groups = plan.options.groups;
        let groups = groups.map(|by| GroupAreas::new(&plan.patches, by));
        let samples = match &groups {
            Some(groups) => groups.samples(&plan.patches),
            None => RowSamples::of_rays(plan.options.rays.min(MOST_RAYS)),
        };
        let sides = Sides::new(&plan.patches, plan.options.two_sided);
        // The engine: as requested, or chosen by the work that formulas and rays would take.
        let mut accuracy = plan.options.accuracy;
        let (mut row_budget, mut seconds) = (f64::INFINITY, None);
        let (engine, why) = match &plan.options.engine {
            Engine::Auto => {
                let surfaces = Surfaces::new(scene, tracer);
                let close_pairs = if plan.options.analytic {
                    near::count(&sides, &surfaces)
                } else {
                    0
                };
                let memory = plan.options.memory;
                let choice =
                    EngineChoice::of(&surfaces, &plan.patches, accuracy, memory, close_pairs);
                let choice = match accuracy {
                    Some(_) => choice,
                    None => choice.or_rough(&surfaces, &plan.patches),
                };
                let choice = choice.for_factors(samples.rays.mean(plan.patches.len()));
                row_budget = choice.row_budget;
                seconds = Some(choice.seconds);
                accuracy = accuracy.or(choice.accuracy);
                (choice.engine, Some(choice.why))
            }
            requested => (requested.clone(), None),
        };
        let (engine, instead) = engine.for_tracer(tracer);
        let why = instead.or(why);
        PreparedPlan {
            plan,
            sides,
            gatherer: Gatherer::new(Surfaces::new(scene, tracer)),
            seed: hash(&[seed as u32, (seed >> 32) as u32]),
            engine,
            why,
            row_budget,
            accuracy,
            seconds,
            groups,
            samples,
            forecast: OnceLock::new(),
        }
    }

    /// How much memory the matrix will take, from a few sampled rows and pairs, and how much time if the engine
    /// was chosen for it; computed once.
    ///
    /// # Errors
    /// [`FactorsError::Cancelled`].
    pub fn forecast(&self, progress: &Progress) -> Result<Forecast, FactorsError> {
        if let Some(&known) = self.forecast.get() {
            return Ok(known);
        }
        let rays = match (&self.engine, &self.groups) {
            (Engine::Analytic, _) => None,
            (engine, None) => Some(engine.rays_per_row(self.row_rays())),
            (_, Some(_)) => Some(RayEstimator::rounded(self.row_rays())),
        };
        let sampled = rays.unwrap_or(FORECAST_RAYS);
        let costs = Costs {
            sides: &self.sides,
            tracer: self.gatherer.surfaces().tracer,
            sampler: &self.ray_estimator(sampled.min(FORECAST_RAYS), hash(&[self.seed, 1])),
            rays: sampled,
            by_rows: rays.is_some(),
            // Besides the parts there is their sum.
            matrices: if self.plan.options.separate { 2 } else { 1 },
            seed: self.seed,
        };
        let forecast = Forecast {
            seconds: self.seconds,
            ..costs.forecast(progress)?
        };
        Ok(*self.forecast.get_or_init(|| forecast))
    }

    /// Computes the matrix, except blocks that are stored. A `&Progress` is a run of one process.
    ///
    /// # Errors
    /// [`FactorsError::TooLarge`] if the forecast exceeds the memory,
    /// [`FactorsError::Cancelled`], and [`FactorsError::Elsewhere`] when all blocks of this process are done and
    /// another makes the result of them.
    pub fn compute<'r>(&self, run: impl Into<Run<'r>>) -> Result<FormFactors, FactorsError> {
        let run = run.into();
        let mut factors = self.estimate(run)?;
        factors.engine_used.notes.extend(self.group_note());
        self.describe(&mut factors);
        self.empty_covered_backs(&mut factors);
        factors.is_closed = factors.loses_no_light() || self.loses_only_strays(&factors);
        if self.plan.is_to_close(&mut factors) {
            factors.close(run.progress)?;
        }
        factors.update_row_errors();
        Ok(factors)
    }

    /// Leaves nothing to backs that fronts of other faces cover: those have their light.
    fn empty_covered_backs(&self, factors: &mut FormFactors) {
        if !self.plan.options.two_sided {
            return;
        }
        let mut is_covered = vec![false; factors.len()];
        for patch in self.plan.patches.covered_backs() {
            is_covered[2 * patch + 1] = true;
            factors.rest[2 * patch + 1] = RowRemainder::default();
        }
        let is_left = |i: usize, e: &mut Exchange| !is_covered[i] && !is_covered[e.column as usize];
        factors.exchange.retain(is_left);
        let orders = &mut factors.orders;
        orders.iter_mut().for_each(|order| order.retain(is_left));
    }

    /// Whether light is lost by nothing but rays of rows that are too narrow for them.
    fn loses_only_strays(&self, factors: &FormFactors) -> bool {
        let tracer = self.gatherer.surfaces().tracer;
        let lengths = factors.exchange.row_lengths();
        let is_seeing = |row: usize| lengths[row] > 0 && !self.sides.is_too_narrow(row, tracer);
        self.engine != Engine::Analytic && factors.seeing_lose_no_light(is_seeing)
    }

    /// The engine of the matrix: as requested, or as chosen automatically.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Memory that may be used, in bytes.
    pub(crate) fn memory(&self) -> u64 {
        self.plan.options.memory
    }

    /// Whether the engine was asked for, not chosen here.
    pub(crate) fn has_engine_by_name(&self) -> bool {
        self.plan.options.engine != Engine::Auto
    }

    /// The plan.
    pub fn plan(&self) -> &'a Plan<'a> {
        self.plan
    }

    /// Number of rows of the matrix.
    pub fn rows(&self) -> usize {
        self.sides.len()
    }

    /// The corners of a row's patch, counter-clockwise as seen from the side that the row is; of a
    /// curved patch those on its surface.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn outline(&self, row: usize) -> Vec<DVec3> {
        let (patches, patch) = (&self.plan.patches, self.sides.patch(row));
        let mut corners = patches.corner_positions(patch);
        if self.sides.is_back(row) {
            corners.reverse();
        }
        corners
    }

    fn materials(&self) -> &[Material] {
        &self.plan.proxy.scene.materials
    }

    /// Fills in what each row is a piece of.
    pub(crate) fn describe(&self, factors: &mut FormFactors) {
        let (sides, patches) = (&self.sides, &self.plan.patches);
        let rows = || (0..sides.len()).map(|i| (i, sides.patch(i)));
        factors.areas = rows().map(|(i, _)| sides.area(i)).collect();
        factors.faces = rows().map(|(_, p)| patches.face(p)).collect();
        factors.materials = rows().map(|(_, p)| patches.material(p)).collect();
        factors.is_back = rows().map(|(i, _)| sides.is_back(i)).collect();
        let ending = |&m: &MaterialId| rows::ending(&self.materials()[m as usize]).mean();
        factors.ends = factors.materials.iter().map(ending).collect();
    }

    /// Rays per row, the largest number of all rows.
    fn row_rays(&self) -> u32 {
        self.samples.rays.most()
    }

    /// An error if the matrix is assembled here and does not fit in memory.
    fn refuse_too_large(&self, run: Run) -> Result<(), FactorsError> {
        if !run.role().assembles {
            return Ok(());
        }
        self.refuse_above_memory(self.forecast(run.progress)?.bytes)
    }

    /// An error if `bytes` exceed the memory that may be used.
    pub(crate) fn refuse_above_memory(&self, bytes: u64) -> Result<(), FactorsError> {
        refuse(self.plan.options, self.rows(), bytes as f64)
    }

    /// The estimator of an engine with the samples of the plan.
    fn sampled_estimator(&self, engine: &Engine) -> Estimator<'_> {
        Estimator::sampled(
            engine,
            &self.gatherer,
            &self.plan.patches,
            &self.samples,
            hash(&[self.seed, 1]),
            Columns::All,
        )
    }

    /// Positions on each patch at which light from outside is gathered.
    fn positions(&self) -> SampleCounts {
        match &self.groups {
            Some(groups) => groups.positions(&self.plan.patches),
            None => SampleCounts::Alike(outside::POSITIONS),
        }
    }

    /// Whether formulas replace what rays find of near pairs. They know neither opacity nor copies.
    fn uses_formulas(&self) -> bool {
        let tracer = &self.plan.proxy.tracer;
        self.plan.options.analytic && !tracer.has_see_through() && !tracer.is_repeated()
    }

    /// All rows as estimated, before closure.
    fn estimate(&self, run: Run) -> Result<FormFactors, FactorsError> {
        if self.engine != Engine::Analytic {
            return self.by_rows(&self.engine, self.why.clone(), run);
        }
        match self.by_formulas(run) {
            Err(doubt @ FactorsError::Doubtful { .. }) if !self.has_engine_by_name() => {
                let why = format!("rays, because {doubt}");
                self.by_rows(&Engine::Rays, Some(why), run)
            }
            Err(error) => Err(error),
            Ok(mut factors) => {
                factors.engine_used = factors.engine_used.because(self.why.clone());
                Ok(factors)
            }
        }
    }

    /// All rows by the estimator of an engine, before closure.
    fn by_rows(
        &self,
        engine: &Engine,
        why: Option<String>,
        run: Run,
    ) -> Result<FormFactors, FactorsError> {
        self.refuse_too_large(run)?;
        let estimator = self.sampled_estimator(engine);
        let exact = if self.uses_formulas() {
            let seed = hash(&[self.seed, 0]);
            near::exact(&self.sides, self.gatherer.surfaces(), seed, run)?
        } else {
            Vec::new()
        };
        let tracing = RowTracing {
            exact: &exact,
            separate: self.plan.options.separate,
            ..RowTracing::new(self, &estimator)
        };
        let traced = tracing.trace(run)?;
        let mut traced = traced.ok_or(FactorsError::Elsewhere)?;
        if self
            .materials()
            .iter()
            .all(|material| rows::ending(material) == Rgb::WHITE)
        {
            traced.fit_to_formulas(&self.sides, &exact);
        }
        let factors = merge::merge(&self.sides, traced, &exact, run.progress)?;
        let mut engine_used = estimator.engine_used().because(why);
        let narrow = self.sides.narrow_note(self.gatherer.surfaces().tracer);
        engine_used.notes.extend(narrow);
        Ok(FormFactors {
            engine_used,
            ..factors
        })
    }
}

/// An error if `bytes` exceed the memory that may be used.
fn refuse(options: &FormFactorOptions, rows: usize, bytes: f64) -> Result<(), FactorsError> {
    if bytes <= options.memory as f64 {
        return Ok(());
    }
    Err(FactorsError::TooLarge {
        rows,
        bytes: bytes as u64,
        memory: options.memory,
    })
}
