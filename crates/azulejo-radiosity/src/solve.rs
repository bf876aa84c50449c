//! The first pass: from a scene to irradiance on its vertices, or at any points.

use crate::error::SolveError;
use crate::first_pass::{FirstPass, PatchPurpose};
use crate::gather::gather_watched;
use crate::gather_pass::GatherLight;
use crate::gathering::GatherTargets;
use crate::preview::{Preview, PreviewReporter};
use crate::report::Report;
use crate::solved::SolvedPatches;
use crate::vertices;
use azulejo_factors::ProxyScene;
use azulejo_scene::{Irradiance, Scene};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Progress, Run, RunStage, Tracer};

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
    let all = GatherTargets {
        points: &targets.points,
        areas: &areas,
    };
    let gathering = gather_watched(
        &solved.gatherer,
        GatherLight::new(&light, black.as_ref()),
        all,
        solved.effort_at(&light, all, pass.ray_budget, seed),
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
