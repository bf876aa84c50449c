//! The first pass: from a scene to irradiance on its vertices, or at any points.

use crate::gather::{
    ErrorParts, GatherEffort, GatherError, GatherLight, GatherTargets, MOST_RAYS, Paths,
    QuarterError, gather_watched,
};
use crate::preview::{Preview, PreviewReporter};
use crate::refine::RefinementGoal;
use crate::sides::StoredSides;
use crate::solved::SolvedPatches;
use crate::system::EnergyBalance;
use crate::vertices;
use azulejo_factors::{Engine, EngineUsed, FactorsError, PatchSize, ProxyScene};
use azulejo_scene::{Irradiance, Rgb, Scene};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Cancelled, GatherPoint, Progress, Run, RunStage, Tracer};
use std::fmt;

/// Options of the first pass.
#[derive(Clone, Debug, PartialEq)]
pub struct FirstPass {
    /// The engine for the form factors between patches.
    pub engine: Engine,
    /// How finely faces are divided.
    pub size: PatchSize,
    /// Estimated relative RMS errors of the patches' radiosity and of irradiance at which to stop;
    /// `None` leaves it to `rays`.
    pub error: Option<f64>,
    /// Whether irradiance is to reach `error` at each point, relative to its own, instead of the mean of all: many more
    /// rays in the dark. Points darker than a thousandth of the mean are taken to have that.
    pub error_each: bool,
    /// Rays per patch, and most rays per vertex; with an `error`, most of both. `None` chooses by
    /// `error`. With neither, the goal is 3% at no more than 2,048 rays per vertex.
    pub rays: Option<u32>,
    /// Rays from all vertices or points together, about: each gets as many as that leaves by a pilot of paths, up to
    /// the default, and no more for `error`. Takes the place of `rays`.
    pub ray_budget: Option<f64>,
    /// Diffuse bounces of light to follow; `None` follows them to convergence.
    pub bounces: Option<u32>,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Bytes that the rows of form factors may take; beyond, light is shot without a matrix.
    pub memory: u64,
    /// Interpolate indirect light between vertices or points, where there are thousands of them, as
    /// far as the requested error permits.
    pub interpolate: bool,
    /// Write irradiance on the vertices of the given mesh instead of those of the patches.
    pub keep_mesh: bool,
    /// Which side's irradiance the surfaces of meshes store.
    pub sides: StoredSides,
}

impl Default for FirstPass {
    /// Patches of a 1,500th of the area, 3% error or 2,048 rays, bounces to convergence, 4 GiB.
    fn default() -> FirstPass {
        FirstPass {
            engine: Engine::Auto,
            size: PatchSize::Squares(1_500),
            error: None,
            error_each: false,
            rays: None,
            ray_budget: None,
            bounces: None,
            seed: 0,
            memory: 4 << 30,
            interpolate: true,
            keep_mesh: false,
            sides: StoredSides::default(),
        }
    }
}

/// Relative error to reach by default.
const DEFAULT_ERROR: f64 = 0.03;

/// Most rays per point by default: caustics of glass and curved mirrors would take far more.
pub(crate) const DEFAULT_RAYS: u32 = 2048;

/// Most rays per patch where only an error is requested.
const MOST_PATCH_RAYS: u32 = 1 << 17;

/// Rays of the stored rows of patches, at least.
const FEWEST_PATCH_RAYS: u32 = 32;

/// Patches whose errors may be as large as that of the light that is gathered from them; the squares
/// of errors grow with their number.
const AVERAGED_PATCHES: f64 = 20_000.0;

/// Largest error of patches, however many there are.
const MOST_PATCH_ERROR: f64 = 0.25;

impl FirstPass {
    pub(crate) fn effort(&self, method: Method) -> GatherEffort {
        let paths = match method {
            Method::Paths => Paths::Always,
            Method::Matrix | Method::Stochastic => Paths::Measured,
        };
        match (self.error, self.rays) {
            (None, None) => GatherEffort {
                error: Some(DEFAULT_ERROR),
                is_each: self.error_each,
                rays: DEFAULT_RAYS,
                paths,
                interpolate: self.interpolate,
            },
            (error, rays) => GatherEffort {
                error,
                is_each: self.error_each,
                rays: rays.unwrap_or(MOST_RAYS),
                paths,
                interpolate: self.interpolate,
            },
        }
    }

    /// Rays of the stored rows: all that were requested, if no error is.
    ///
    /// The error of a patch from n rays is about a half n^−0.6, and refinement leaves about that
    /// times n^−½ of the rows' noise: a fourth of the requested error.
    pub(crate) fn patch_rays(&self, purpose: PatchPurpose, patches: usize) -> u32 {
        let relief = purpose.relief(patches);
        let enough = (2.0 / (relief * self.aim())).powf(0.9);
        let fewest = ((128.0 / relief) as u32).clamp(FEWEST_PATCH_RAYS, 128);
        let enough = (enough as u32).max(fewest).next_power_of_two().min(2048);
        match (self.error, self.rays) {
            (None, Some(rays)) => rays,
            (_, most) => enough.min(most.unwrap_or(u32::MAX)),
        }
    }

    /// The relative error to reach, as far as the rays allow.
    pub(crate) fn aim(&self) -> f64 {
        self.error.unwrap_or(DEFAULT_ERROR)
    }

    /// The goal of refinement, if an error is to be reached. A limited number of bounces cannot be
    /// refined: the light of the last but one would be needed.
    pub(crate) fn goal(&self, purpose: PatchPurpose, patches: usize) -> Option<RefinementGoal> {
        let error = match (self.error, self.rays) {
            (None, Some(_)) => None,
            (error, _) => Some(error.unwrap_or(DEFAULT_ERROR)),
        };
        let larger = |e: f64| e.max(MOST_PATCH_ERROR.min(e * purpose.relief(patches)));
        let error = error.map(larger);
        let rays = self.rays.unwrap_or(MOST_PATCH_RAYS);
        let goal = error.map(|error| RefinementGoal { error, rays });
        goal.filter(|_| self.bounces.is_none())
    }

    /// The same with as many rays from each vertex or point as its budget affords.
    pub(crate) fn within_budget(&self, affordable: impl Fn(f64) -> u32) -> FirstPass {
        let Some(budget) = self.ray_budget else {
            return self.clone();
        };
        FirstPass {
            error: Some(self.aim()),
            rays: Some(affordable(budget)),
            ..self.clone()
        }
    }

    pub(crate) fn key(&self) -> u32 {
        hash(&[self.seed as u32, (self.seed >> 32) as u32])
    }
}

/// What the radiosity of patches is for: how large its error may be.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PatchPurpose<'p> {
    /// Each patch is a result.
    Result,
    /// To be gathered to vertices, which need to know which sides of surfaces are lit: every point
    /// reads hundreds of patches, whose errors are independent, so the more there are, the larger they
    /// may be.
    Vertices,
    /// To be gathered to these points, whose side is given; none if they are not known yet.
    Points(&'p [GatherPoint]),
}

impl PatchPurpose<'_> {
    /// How much larger the error of so many patches may be than that of the light in the end.
    fn relief(self, patches: usize) -> f64 {
        match self {
            PatchPurpose::Result => 1.0,
            PatchPurpose::Vertices | PatchPurpose::Points(_) => {
                (patches as f64 / AVERAGED_PATCHES).max(1.0).sqrt()
            }
        }
    }
}

/// Why there is no solution.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SolveError {
    /// Nothing in the scene emits light.
    NoLight,
    /// There is no surface with an area.
    NoSurface,
    /// After this many bounces light had not died out: hardly anything absorbs it, and it cannot escape.
    Endless(u32),
    /// The deadline passed before there was light on all vertices or points.
    OutOfTime,
    /// The caller cancelled.
    Cancelled,
    /// No failure: the blocks of this process are done, and another makes the result of them
    /// ([`RunRole::assembles`](azulejo_trace::RunRole::assembles)).
    Elsewhere,
    /// Form factors failed for another reason. [`solve`] keeps to its memory and never returns
    /// this; programs that also compute matrices do.
    Factors(FactorsError),
}

impl From<FactorsError> for SolveError {
    fn from(error: FactorsError) -> SolveError {
        match error {
            FactorsError::NoSurface => SolveError::NoSurface,
            FactorsError::Cancelled => SolveError::Cancelled,
            FactorsError::Elsewhere => SolveError::Elsewhere,
            other => SolveError::Factors(other),
        }
    }
}

impl From<GatherError> for SolveError {
    fn from(error: GatherError) -> SolveError {
        match error {
            GatherError::Cancelled => SolveError::Cancelled,
            GatherError::OutOfTime => SolveError::OutOfTime,
            GatherError::Elsewhere => SolveError::Elsewhere,
        }
    }
}

impl From<Cancelled> for SolveError {
    fn from(_: Cancelled) -> SolveError {
        SolveError::Cancelled
    }
}

impl fmt::Display for SolveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SolveError::NoLight => f.write_str(
                "nothing in the scene emits light: add a light, or a material that emits",
            ),
            SolveError::NoSurface => FactorsError::NoSurface.fmt(f),
            SolveError::Endless(bounces) => write!(
                f,
                "after {bounces} bounces the light has not died out, because surfaces reflect all or \
                 nearly all of it, or coincide: give some a lower reflectance, remove duplicates, or \
                 limit the bounces"
            ),
            SolveError::OutOfTime => f.write_str(
                "the time was over before all of the scene had light: allow more time, \
                 or ask for fewer patches",
            ),
            SolveError::Cancelled => FactorsError::Cancelled.fmt(f),
            SolveError::Elsewhere => FactorsError::Elsewhere.fmt(f),
            SolveError::Factors(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SolveError {}

/// How the light between patches was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Rows of form factors, then Jacobi iteration.
    Matrix,
    /// Power shot by rays, nothing stored: Stochastic Jacobi (Neumann 1995), or particles.
    Stochastic,
    /// None: a deadline left no time for patches, and paths were traced from every point.
    Paths,
}

/// Statistics of a first pass, with its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The method.
    pub method: Method,
    /// The engine that computed the form factors; empty if there are none.
    pub engine_used: EngineUsed,
    /// Number of patches.
    pub patches: usize,
    /// Vertices or points at which irradiance was gathered.
    pub points: usize,
    /// Rays traced from patches.
    pub patch_rays: u64,
    /// Rows with more rays than the others, to reach the error.
    pub refined_rows: usize,
    /// Estimated relative RMS error of the radiosity that patches reflect: see
    /// [`RadiositySolution::error`](crate::system::RadiositySolution::error).
    pub patch_error: f64,
    /// Rays traced from each point, on average.
    pub point_rays: u32,
    /// Bytes of the stored rows.
    pub bytes: usize,
    /// Bounces of light followed.
    pub iterations: u32,
    /// Change of the last bounce relative to the brightest patch.
    pub residual: f64,
    /// Energy balance, W.
    pub balance: EnergyBalance,
    /// Standard error of the share of the emitted power that is unaccounted for.
    pub balance_error: f64,
    /// Estimated RMS error of irradiance over its mean: see
    /// [`Gathering::relative_error`](crate::gather::Gathering::relative_error); at least the share of
    /// the emitted power that is unaccounted for beyond its standard error.
    pub error: f64,
    /// Root mean square over the points of the standard error of each relative to its irradiance; points without light
    /// are left out.
    pub error_each: f64,
    /// `error` by its causes.
    pub error_parts: ErrorParts,
    /// Mean irradiance and error of the quarters of the vertices or points, from dark to bright.
    pub quarters: [QuarterError; 4],
    /// Share of the vertices or points at which patches would have been too coarse, so that paths
    /// were traced.
    pub path_traced: f64,
    /// How many times as many rays from points the requested error would take; 1 if it is reached.
    pub rays_needed: f64,
    /// Share of the vertices or points at which indirect light is interpolated.
    pub interpolated: f64,
}

/// A solved scene.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSolution {
    /// What [`Scene::set_irradiance`] takes.
    pub irradiance: Irradiance,
    /// Statistics and error of the solution.
    pub report: Report,
}

/// Solves the light of a scene for all viewpoints and gathers it to the vertices.
///
/// [`Shape::Exact`](azulejo_scene::Shape::Exact) objects are divided as polygons whose chords leave
/// them by at most [`CHORD_ERROR`](azulejo_factors::CHORD_ERROR) patch edges; these become the
/// objects' proxy meshes, with `keep_mesh` too.
///
/// A `&Progress` is a run of one process. Where several share it, vertices are divided, and the light between patches
/// too if they talk to each other.
///
/// # Errors
/// [`SolveError`]: no light, no surface, or cancelled. An expired deadline of the progress is an error
/// only if there is no light on some vertices yet: otherwise the result is as good as the time
/// allowed, and its error says how good. [`SolveError::Elsewhere`] where another process makes the result.
pub fn solve<'r>(
    scene: &Scene,
    tracer: &Tracer,
    pass: &FirstPass,
    run: impl Into<Run<'r>>,
) -> Result<LightSolution, SolveError> {
    solve_for(None, scene, tracer, pass, run.into())
}

/// As [`solve`], with previews: as soon as the patches are solved, and after each pass over the
/// vertices, but at most once a second. The last pass is not previewed, because it is the result,
/// the same to the bit as that of [`solve`].
///
/// The solver waits while `watch` runs; a preview costs about as much as a copy of the divided
/// scene.
///
/// # Errors
/// As [`solve`].
///
/// ```
/// use azulejo_factors::PatchSize;
/// use azulejo_radiosity::{FirstPass, solve_watched};
/// use azulejo_scene::synthetic::{CornellVariant, cornell_box};
/// use azulejo_trace::{Progress, Tracer};
///
/// let mut scene = cornell_box(CornellVariant::Diffuse);
/// let (tracer, given) = (Tracer::new(&scene), scene.clone());
/// let pass = FirstPass { size: PatchSize::Count(100), ..FirstPass::default() };
/// let mut shown = 0;
/// let light = solve_watched(&given, &tracer, &pass, &Progress::new(), &mut |preview| {
///     scene.set_irradiance(preview.irradiance);
///     shown += 1;
/// })?;
/// assert!(shown > 0);
/// scene.set_irradiance(light.irradiance);
/// # Ok::<(), azulejo_radiosity::SolveError>(())
/// ```
pub fn solve_watched(
    scene: &Scene,
    tracer: &Tracer,
    pass: &FirstPass,
    progress: &Progress,
    watch: &mut dyn FnMut(Preview),
) -> Result<LightSolution, SolveError> {
    solve_for(Some(watch), scene, tracer, pass, Run::alone(progress))
}

fn solve_for(
    watch: Option<&mut dyn FnMut(Preview)>,
    scene: &Scene,
    tracer: &Tracer,
    pass: &FirstPass,
    run: Run,
) -> Result<LightSolution, SolveError> {
    let proxy = ProxyScene::new(scene, tracer, pass.size);
    let mut reporter = PreviewReporter::new(watch, &proxy, pass);
    let purpose = PatchPurpose::Vertices;
    let solved = SolvedPatches::new(&proxy, pass, purpose, run, &mut |patches, solution| {
        reporter.show_patches(patches, solution);
    })?;
    reporter.show_patches(&solved.patches, &solved.solution);
    let targets = vertices::targets(scene, &solved.patches, &solved.solution, pass);
    let (light, black) = (solved.light(), solved.black_light());
    run.blocks.rely_on(RunStage::Points, solved.digest())?;
    let seed = hash(&[pass.key(), 1]);
    // Where each point is to reach an error, all count alike.
    let areas = if pass.error_each {
        Vec::new()
    } else {
        targets.areas(&solved.patches)
    };
    let gathering = gather_watched(
        &solved.gatherer,
        GatherLight::new(&light, black.as_ref()),
        GatherTargets {
            points: &targets.points,
            areas: &areas,
        },
        solved.effort(),
        seed,
        run,
        &mut |gathering| reporter.show_vertices(&targets, &solved.patches, gathering),
    )?;
    let irradiance = targets.irradiance(&proxy.scene, &solved.patches, &gathering);
    Ok(LightSolution {
        irradiance,
        report: solved.report(&gathering),
    })
}

/// An estimate with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: Rgb,
    /// Its standard error: the truth lies within two of them 95 times in 100.
    pub error: Rgb,
}
