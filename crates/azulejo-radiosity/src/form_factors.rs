//! Form factors as a product: the whole matrix, with a standard error for every entry.
//!
//! 1. [`Plan`] divides the scene and says how much memory the matrix will take.
//! 2. `near` finds the pairs for which a formula pays: close ones, and those with lamps. Their
//!    direct part is the exact form factor times the visible fraction.
//! 3. `rows` asks the engine for the rows of all sides. What is done is kept in a [`Journal`].
//! 4. `merge` makes one exchange area of the two estimates that the sides of a pair give.
//! 5. [`FormFactors::close`] changes scenes within their errors so that no light is missing.
//!
//! [`form_factors`] does all of it, in this order. [`FormFactors::grouped`] and
//! [`FormFactors::truncate`] make smaller matrices of the result, [`FormFactors::interchange`] one
//! with all reflections in it. [`form_factors_from`] finds one row alone.

mod analytic;
mod balance;
mod boxes;
mod close;
mod enclosure;
mod exchange;
mod forecast;
mod group;
pub(crate) mod journal;
mod kinship;
mod matrix;
mod merge;
mod near;
mod one_row;
mod options;
mod rows;
mod shaft;
mod sides;
mod spread;
mod truncate;

use crate::choice::Facts;
use crate::engine::{Engine, Estimator};
use crate::patch::{PatchSize, Patches};
use crate::row::Columns;
use crate::solve::SolveError;
use crate::stand_in::StandIn;
use azulejo_scene::{Material, MaterialId, Scene};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, Gatherer, Progress, Surfaces, Tracer};
pub use enclosure::{NoInterchange, Scaled};
pub use exchange::{Exchange, ExchangeAreas};
use forecast::Costs;
pub use forecast::Forecast;
pub use journal::{Journal, NoJournal, Stage};
pub use kinship::Kinship;
pub use matrix::{FormFactors, Moved, Rest, Truncated};
pub use one_row::{Factor, FactorsFrom, form_factors_from};
pub use options::{Closure, FormFactorOptions, MOST_RAYS};
use rows::Tracing;
use sides::Sides;

/// Computes the form factors of a scene; lights play no part, but for the choice of formulas.
///
/// Rows of exact shapes are pieces of the polygons that [`faceted`](crate::faceted) puts in their
/// place. The result is the same to the bit for any number of threads. Beside the result it takes 12
/// bytes for each entry that rays found.
///
/// # Errors
/// [`SolveError::NoSurface`], [`SolveError::TooLarge`], [`SolveError::Cancelled`].
///
/// ```
/// use azulejo_radiosity::{FormFactorOptions, PatchSize, form_factors};
/// use azulejo_scene::synthetic::cube_room;
/// use azulejo_trace::{Progress, Tracer};
///
/// let scene = cube_room();
/// let whole = FormFactorOptions { size: PatchSize::Edge(0.0), ..Default::default() };
/// let factors = form_factors(&scene, &Tracer::new(&scene), &whole, &Progress::new())?;
/// let (opposite, error) = factors.get(0, 1);
/// assert!((opposite - 0.19982489569839).abs() < 1e-9, "{opposite} ± {error}");
/// # Ok::<(), azulejo_radiosity::SolveError>(())
/// ```
pub fn form_factors(
    scene: &Scene,
    tracer: &Tracer,
    options: &FormFactorOptions,
    progress: &Progress,
) -> Result<FormFactors, SolveError> {
    Plan::new(scene, tracer, options)?.compute(&NoJournal, progress)
}

/// A scene divided into the patches whose form factors are wanted.
pub struct Plan<'a> {
    options: &'a FormFactorOptions,
    stand_in: StandIn<'a>,
    patches: Patches,
}

impl<'a> Plan<'a> {
    /// Divides the scene.
    ///
    /// # Errors
    /// [`SolveError::NoSurface`]; [`SolveError::TooLarge`] if not even the patches fit in the
    /// memory.
    pub fn new(
        scene: &'a Scene,
        tracer: &'a Tracer,
        options: &'a FormFactorOptions,
    ) -> Result<Plan<'a>, SolveError> {
        if let PatchSize::Count(rows) | PatchSize::Squares(rows) = options.size {
            refuse(options, rows, rows as f64 * forecast::PATCH_BYTES)?;
        }
        let stand_in = StandIn::new(scene, tracer, options.size);
        let patches = Patches::new(&stand_in.scene, options.size);
        if patches.is_empty() {
            return Err(SolveError::NoSurface);
        }
        Ok(Plan {
            options,
            stand_in,
            patches,
        })
    }

    /// The patches.
    pub fn patches(&self) -> &Patches {
        &self.patches
    }

    /// Looks at a few rows to see how much memory the matrix will take. The same plan has the
    /// same forecast.
    ///
    /// # Errors
    /// [`SolveError::Cancelled`].
    pub fn forecast(&self, progress: &Progress) -> Result<Forecast, SolveError> {
        let prepared = Prepared::new(self);
        if prepared.engine == Engine::Analytic {
            return prepared.forecast_of_formulas(progress);
        }
        let rays = prepared.estimator().rays();
        Ok(prepared.forecast(rays, progress)?)
    }

    /// Computes the matrix, going on from what the journal has.
    ///
    /// # Errors
    /// [`SolveError::TooLarge`] if the forecast exceeds the memory, [`SolveError::Cancelled`].
    pub fn compute(
        &self,
        journal: &dyn Journal,
        progress: &Progress,
    ) -> Result<FormFactors, SolveError> {
        let prepared = Prepared::new(self);
        let mut factors = prepared.estimate(journal, progress)?;
        prepared.describe(&mut factors);
        factors.is_closed = factors.keeps_its_light();
        if self.is_to_close(&mut factors, prepared.materials()) {
            factors.close(progress)?;
        }
        factors.find_row_errors();
        Ok(factors)
    }

    fn is_to_close(&self, factors: &mut FormFactors, materials: &[Material]) -> bool {
        let is_coloured = materials.iter().any(|m| !m.mirror.is_grey());
        let has_glass = materials.iter().any(|m| m.dielectric.is_some());
        let has_gloss = materials.iter().any(|m| m.glossy().is_some());
        match self.options.closure {
            Closure::Never => false,
            Closure::Closed => factors.is_closed && !materials.iter().any(Material::is_specular),
            Closure::Always if is_coloured || has_glass || has_gloss => {
                let why = match (has_glass, has_gloss) {
                    (true, _) => "there is glass",
                    (_, true) => "there are glossy surfaces",
                    _ => "mirrors are coloured",
                };
                let note = format!("rows were not closed, because {why}");
                factors.ran.notes.push(note);
                false
            }
            Closure::Always => true,
        }
    }
}

/// Most rays of a row that is looked at for the forecast.
const FORECAST_RAYS: u32 = 4_096;

/// What all engines work with.
struct Prepared<'a> {
    plan: &'a Plan<'a>,
    sides: Sides<'a>,
    gatherer: Gatherer<'a>,
    seed: u32,
    /// Who computes, and why if that was left open.
    engine: Engine,
    why: Option<String>,
}

impl<'a> Prepared<'a> {
    fn new(plan: &'a Plan<'a>) -> Prepared<'a> {
        let (scene, tracer) = (&plan.stand_in.scene, &plan.stand_in.tracer);
        let seed = plan.options.seed;
        let (engine, why) = match &plan.options.engine {
            Engine::Auto => {
                let chosen = Facts::of(scene, &plan.patches, plan.options.memory).for_factors();
                (chosen.0, Some(chosen.1))
            }
            asked => (asked.clone(), None),
        };
        Prepared {
            plan,
            sides: Sides::new(&plan.patches, plan.options.two_sided),
            gatherer: Gatherer::new(Surfaces::new(scene, tracer)),
            seed: hash(&[seed as u32, (seed >> 32) as u32]),
            engine,
            why,
        }
    }

    fn materials(&self) -> &[Material] {
        &self.plan.stand_in.scene.materials
    }

    /// What the rows are pieces of.
    fn describe(&self, factors: &mut FormFactors) {
        let (sides, patches) = (&self.sides, &self.plan.patches);
        let rows = || (0..sides.len()).map(|i| (i, sides.patch(i)));
        factors.areas = rows().map(|(i, _)| sides.area(i)).collect();
        factors.faces = rows().map(|(_, p)| patches.face(p)).collect();
        factors.materials = rows().map(|(_, p)| patches.material(p)).collect();
        factors.is_back = rows().map(|(i, _)| sides.is_back(i)).collect();
        let ending = |&m: &MaterialId| rows::ending(&self.materials()[m as usize]).mean();
        factors.ends = factors.materials.iter().map(ending).collect();
    }

    fn estimator(&self) -> Estimator<'_> {
        let options = self.plan.options;
        Estimator::new(
            &self.engine,
            &self.gatherer,
            &self.plan.patches,
            options.rays.min(MOST_RAYS),
            hash(&[self.seed, 1]),
            Columns::All,
        )
    }

    /// What it will take if rows have so many rays or pixels.
    fn forecast(&self, rays: u32, progress: &Progress) -> Result<Forecast, Cancelled> {
        let looker = Estimator::new(
            &Engine::Rays,
            &self.gatherer,
            &self.plan.patches,
            rays.min(FORECAST_RAYS),
            hash(&[self.seed, 1]),
            Columns::All,
        );
        let costs = Costs {
            sides: &self.sides,
            tracer: self.gatherer.surfaces().tracer,
            looker: &looker,
            rays,
            by_rows: true,
            // Beside the parts there is their sum.
            matrices: if self.plan.options.separate { 2 } else { 1 },
            seed: self.seed,
        };
        costs.forecast(progress)
    }

    /// All rows as they are found, before anything is made to add up.
    fn estimate(
        &self,
        journal: &dyn Journal,
        progress: &Progress,
    ) -> Result<FormFactors, SolveError> {
        let options = self.plan.options;
        if self.engine == Engine::Analytic {
            let mut factors = self.by_formulas(journal, progress)?;
            factors.ran = factors.ran.because(self.why.clone());
            return Ok(factors);
        }
        let estimator = self.estimator();
        let forecast = self.forecast(estimator.rays(), progress)?;
        refuse(options, forecast.rows, forecast.bytes as f64)?;
        let exact = match options.analytic {
            true => near::exact(
                &self.sides,
                self.gatherer.surfaces(),
                hash(&[self.seed, 0]),
                progress,
            )?,
            false => vec![Vec::new(); self.sides.len()],
        };
        let tracing = Tracing {
            sides: &self.sides,
            gatherer: &self.gatherer,
            exact: &exact,
            estimator: &estimator,
            separate: options.separate,
            is_known: &|_, _, _| false,
        };
        let traced = tracing.trace(journal, progress)?;
        let factors = merge::merge(&self.sides, traced, &exact, progress)?;
        Ok(FormFactors {
            ran: estimator.ran().because(self.why.clone()),
            ..factors
        })
    }
}

/// Refuses what needs more memory than there may be.
fn refuse(options: &FormFactorOptions, rows: usize, bytes: f64) -> Result<(), SolveError> {
    match bytes <= options.memory as f64 {
        true => Ok(()),
        false => Err(SolveError::TooLarge {
            rows,
            bytes: bytes as u64,
            memory: options.memory,
        }),
    }
}
