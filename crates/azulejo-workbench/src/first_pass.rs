//! The first pass as run by the window.

use crate::document::{ItemId, SceneDocument, Solution, SurfacePick};
use azulejo::factors::form_factors::{Factor, GroupFactor, Plan};
use azulejo::factors::{Engine, FormFactorOptions, Hemicube, PatchSize, PointNormal};
use azulejo::radiosity::{Estimate, FirstPass, Preview, SolveError, probe, solve_watched};
use azulejo::scene::math::Ray;
use azulejo::scene::{Irradiance, Mesh, Scene};
use azulejo::trace::time::{Duration, Instant};
use azulejo::trace::{Progress, Tracer};
use clap::ValueEnum;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// How form factors are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum EngineChoice {
    /// Chosen automatically for the scene.
    #[default]
    Auto,
    /// Ray casting.
    Rays,
    /// Hemicubes.
    Hemicube,
    /// Hemicubes, with rays for mirror reflections.
    Hybrid,
    /// Closed-form expressions.
    Analytic,
}

impl EngineChoice {
    /// The library's type for this engine.
    pub fn engine(self) -> Engine {
        match self {
            EngineChoice::Auto => Engine::Auto,
            EngineChoice::Rays => Engine::Rays,
            EngineChoice::Hemicube => Engine::Hemicube(Hemicube::default()),
            EngineChoice::Hybrid => Engine::Hybrid(Hemicube::default()),
            EngineChoice::Analytic => Engine::Analytic,
        }
    }
}

/// Settings of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSettings {
    /// How form factors are computed.
    pub engine: EngineChoice,
    /// A patch is this fraction of the total surface area; smaller faces are patches too.
    pub patches: u32,
    /// Relative error at which the solver stops.
    pub error: f64,
    /// Time limit in seconds; `None` for none.
    pub time: Option<f64>,
    /// Number of diffuse bounces; `None` for all.
    pub bounces: Option<u32>,
    /// Whether light is stored on the vertices of the model, and not on those of a finer mesh.
    pub keep_mesh: bool,
}

/// Default time limit in seconds.
pub const DEFAULT_TIME: f64 = 60.0;

impl LightSettings {
    /// The library's type for these settings.
    pub fn first_pass(&self) -> FirstPass {
        FirstPass {
            engine: self.engine.engine(),
            size: PatchSize::Squares(self.patches.max(1) as usize),
            error: Some(self.error),
            bounces: self.bounces,
            keep_mesh: self.keep_mesh,
            memory: azulejo::machine::memory_budget(),
            ..FirstPass::default()
        }
    }

    fn limit_time(&self, progress: &Progress) {
        if let Some(seconds) = self.time {
            let time = Duration::from_secs_f64(seconds.clamp(0.0, 1e6));
            progress.set_deadline(Instant::now() + time);
        }
    }
}

impl Default for LightSettings {
    fn default() -> LightSettings {
        LightSettings {
            engine: EngineChoice::Auto,
            patches: 1_500,
            error: 0.03,
            // Models whose undersides receive hardly any light converge slowly in the last few
            // percent, and interactive use needs results soon.
            time: Some(DEFAULT_TIME),
            bounces: None,
            keep_mesh: false,
        }
    }
}

/// Solves the light of a document; passes intermediate solutions and the final one to `show`. If `is_dark`,
/// the first of them is a coarse one within a second, because nothing better is shown.
///
/// # Errors
///
/// The solver's error as text.
pub fn solve_document(
    document: &SceneDocument,
    settings: &LightSettings,
    is_dark: bool,
    progress: &Progress,
    show: &dyn Fn(Solution),
) -> Result<(), String> {
    settings.limit_time(progress);
    let scene = document.scene();
    let tracer = Tracer::new(&scene);
    let send = |irradiance, report| {
        show(Solution::new(
            document.clone(),
            scene.clone(),
            irradiance,
            report,
        ));
    };
    let pass = settings.first_pass();
    if is_dark
        && progress.advance(0).is_ok()
        && let Some(irradiance) = first_light(&scene, &tracer, &pass)
    {
        send(irradiance, None);
    }
    let mut watch = |preview: Preview| send(preview.irradiance, None);
    match solve_watched(&scene, &tracer, &pass, progress, &mut watch) {
        Err(SolveError::Cancelled) => Ok(()),
        Err(other) => Err(other.to_string()),
        Ok(light) => {
            send(light.irradiance, Some(light.report));
            Ok(())
        }
    }
}

/// How long the first light may take: what is slower is not shown, as the solver's own first
/// solution comes soon after.
const FIRST_LIGHT: Duration = Duration::from_millis(700);
/// Patches, faces, and rays of the first light.
const FIRST_PATCHES: usize = 200;
const FIRST_FACES: usize = 20_000;
const FIRST_RAYS: u32 = 8;

/// A coarse and noisy solution within a second, so that something is seen at once; `None` for models
/// that take longer.
fn first_light(scene: &Scene, tracer: &Tracer, pass: &FirstPass) -> Option<Irradiance> {
    let faces = scene.objects.iter().filter_map(|o| o.shape.mesh());
    if faces.map(|mesh| mesh.faces.len()).sum::<usize>() > FIRST_FACES {
        return None;
    }
    let coarse = FirstPass {
        engine: Engine::Rays,
        size: PatchSize::Squares(FIRST_PATCHES),
        error: None,
        rays: Some(FIRST_RAYS),
        ..pass.clone()
    };
    let own = Progress::new();
    own.set_deadline(Instant::now() + FIRST_LIGHT);
    let mut ignore = |_: Preview| {};
    let light = solve_watched(scene, tracer, &coarse, &own, &mut ignore).ok()?;
    Some(light.irradiance)
}

/// Irradiance at surface points, one estimate for each; none if the job was cancelled.
///
/// # Errors
///
/// The solver's error as text.
pub fn measure(
    document: &SceneDocument,
    settings: &LightSettings,
    places: &[SurfacePick],
    progress: &Progress,
) -> Result<Vec<Estimate>, String> {
    settings.limit_time(progress);
    let scene = document.scene();
    let tracer = Tracer::new(&scene);
    let points = places.iter().map(|pick| {
        let surface = on_surface(document, &tracer, pick);
        PointNormal {
            position: surface.map_or(pick.position, |s| s.position),
            normal: pick.normal,
        }
    });
    let points: Vec<PointNormal> = points.collect();
    match probe(&scene, &tracer, &points, &settings.first_pass(), progress) {
        Err(SolveError::Cancelled) => Ok(Vec::new()),
        Err(other) => Err(other.to_string()),
        Ok(probed) => Ok(probed.estimates),
    }
}

/// Irradiance at points of space on the side of their normals; `None` inside solids. All is `None`
/// if the job was cancelled.
///
/// # Errors
///
/// The solver's error as text.
pub fn measure_in_space(
    document: &SceneDocument,
    settings: &LightSettings,
    points: &[PointNormal],
    progress: &Progress,
) -> Result<Option<Vec<Option<Estimate>>>, String> {
    settings.limit_time(progress);
    let scene = document.scene();
    let tracer = Tracer::new(&scene);
    let mut is_free: Vec<bool> = points.iter().map(|p| !is_inside(&tracer, p)).collect();
    if !is_free.contains(&true) {
        // A model that is turned inside out is not solid.
        is_free.fill(true);
    }
    let both = points.iter().zip(&is_free);
    let free: Vec<PointNormal> = both.filter(|(_, free)| **free).map(|(p, _)| *p).collect();
    match probe(&scene, &tracer, &free, &settings.first_pass(), progress) {
        Err(SolveError::Cancelled) => Ok(None),
        Err(other) => Err(other.to_string()),
        Ok(probed) => {
            let mut estimates = probed.estimates.into_iter();
            let estimate = |free: bool| if free { estimates.next() } else { None };
            Ok(Some(is_free.into_iter().map(estimate).collect()))
        }
    }
}

/// Whether a point lies in a solid: along its normal it sees a back, and so it does in most other
/// directions. Below a shelf or a ceiling of one face it sees walls, too.
fn is_inside(tracer: &Tracer, point: &PointNormal) -> bool {
    let (u, v) = point.normal.any_orthonormal_pair();
    let sees_back = |direction: &DVec3| {
        let hit = tracer.hit(&Ray::new(point.position, *direction));
        hit.is_some_and(|hit| !hit.entering)
    };
    let others = [-point.normal, u, -u, v, -v];
    sees_back(&point.normal) && others.iter().filter(|d| sees_back(d)).count() >= 3
}

/// A point on the exact surface.
struct ExactPoint {
    position: DVec3,
    /// Whether the picked side is the front.
    is_front: bool,
    /// A ray that hits the point first, from the picked side.
    from_outside: Ray,
}

/// Projects a picked point from the displayed polygons to the exact surface: the chords of a sphere
/// lie inside it, by up to a 64th of its size.
fn on_surface(document: &SceneDocument, tracer: &Tracer, pick: &SurfacePick) -> Option<ExactPoint> {
    let index = document.objects.iter().position(|i| i.id == pick.item)?;
    let size = document.objects[index].bounds().diagonal();
    let reach = (size / 32.0).max(f64::MIN_POSITIVE);
    let mut origin = pick.position + reach * pick.normal;
    // Other surfaces may be in between, however close.
    const MAX_HITS: usize = 64;
    for _ in 0..MAX_HITS {
        let hit = tracer.hit(&Ray::new(origin, -pick.normal))?;
        if hit.object as usize == index {
            let clear = (hit.position - origin).length().min(reach);
            let from = hit.position + 0.5 * clear * pick.normal;
            return Some(ExactPoint {
                position: hit.position,
                is_front: hit.entering,
                from_outside: Ray::new(from, -pick.normal),
            });
        }
        origin = hit.position - 1e-9 * size * pick.normal;
    }
    None
}

/// The form factors of one patch.
#[derive(Clone, Debug)]
pub struct PatchFormFactors {
    /// Unique for each result.
    pub number: u64,
    /// The point that was picked.
    pub pick: SurfacePick,
    /// The patches as triangles, one face each.
    pub patches: Arc<Mesh>,
    /// Form factor from the picked patch to the patch of each face.
    pub factors: Vec<f64>,
    /// Sum over all patches; the difference to 1 leaves the scene.
    pub sum: f64,
    /// Sums over the patches of each visible object, in descending order.
    pub objects: Vec<(ItemId, GroupFactor)>,
}

/// Rays of a row that is computed by itself: one takes no time worth saving.
const ROW_RAYS: u32 = 1 << 16;

/// The options of the form factors between the patches that the solver would use. An engine that was chosen by name
/// gets no help from formulas: it is to be seen as it is.
pub(crate) fn factor_options(settings: &LightSettings) -> FormFactorOptions {
    let pass = settings.first_pass();
    FormFactorOptions {
        size: pass.size,
        analytic: pass.engine == Engine::Auto,
        engine: pass.engine,
        two_sided: true,
        rays: ROW_RAYS,
        ..FormFactorOptions::default()
    }
}

/// The row of the side that was picked: rows are the front of each patch, then its back.
pub(crate) fn picked_row(
    document: &SceneDocument,
    tracer: &Tracer,
    plan: &Plan,
    pick: &SurfacePick,
) -> Result<usize, String> {
    let nowhere = || "there is no patch at that place".to_owned();
    let surface = on_surface(document, tracer, pick).ok_or_else(nowhere)?;
    let picked = plan.patch_at(&surface.from_outside).ok_or_else(nowhere)?;
    Ok(2 * picked + usize::from(!surface.is_front))
}

/// Computes the form factors of the patch at a picked point, with the patches that the solver would
/// use.
///
/// # Errors
///
/// A message: no surface, too many patches, or no patch at that point.
pub fn patch_form_factors(
    document: &SceneDocument,
    settings: &LightSettings,
    pick: &SurfacePick,
    progress: &Progress,
) -> Result<Option<PatchFormFactors>, String> {
    let scene = document.scene();
    let tracer = Tracer::new(&scene);
    let options = factor_options(settings);
    let plan = Plan::new(&scene, &tracer, &options).map_err(|e| e.to_string())?;
    let row = picked_row(document, &tracer, &plan, pick)?;
    let objects = document.objects.len();
    let groups: Vec<Option<u32>> = objects_of_sides(&plan, objects);
    let Ok(sides) = plan.prepare().grouped_row(row, &groups, objects, progress) else {
        return Ok(None);
    };
    let both = |side: &[Factor]| side.iter().map(|f| f.value).sum();
    let factors: Vec<f64> = sides.factors.chunks(2).map(both).collect();
    // The scene has the objects of the document, in the same order.
    let ids = document.objects.iter().map(|item| item.id);
    let mut objects: Vec<_> = ids.zip(sides.groups).collect();
    objects.retain(|(_, f)| f.factor.value > 0.0);
    objects.sort_by(|a, b| b.1.factor.value.total_cmp(&a.1.factor.value));
    let mut found = PatchFormFactors::new(*pick, &plan, row / 2, &factors);
    found.objects = objects;
    Ok(Some(found))
}

/// The object of each row and column.
fn objects_of_sides(plan: &Plan, objects: usize) -> Vec<Option<u32>> {
    let mut owners = vec![None; 2 * plan.patches().len()];
    for object in 0..objects as u32 {
        let patches = plan.patches().patches_of(object);
        owners[2 * patches.start..2 * patches.end].fill(Some(object));
    }
    owners
}

impl PatchFormFactors {
    /// The number of a new result.
    pub(crate) fn next_number() -> u64 {
        static NUMBER: AtomicU64 = AtomicU64::new(1);
        NUMBER.fetch_add(1, Ordering::Relaxed)
    }

    fn new(pick: SurfacePick, plan: &Plan, picked: usize, factors: &[f64]) -> PatchFormFactors {
        let mut mesh = Mesh::default();
        let mut values = Vec::new();
        for (patch, corners) in plan.patches().triangles() {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.push_face(&[first, first + 1, first + 2], 0);
            values.push(if patch as usize == picked {
                // The picked patch itself is displayed as unknown.
                f64::NAN
            } else {
                factors.get(patch as usize).copied().unwrap_or(0.0)
            });
        }
        PatchFormFactors {
            number: PatchFormFactors::next_number(),
            pick,
            patches: Arc::new(mesh),
            factors: values,
            sum: factors.iter().sum(),
            objects: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::synthetic::cube_room;
    use azulejo::scene::{Object, Primitive, Shape};

    /// A sphere in the middle of a closed room.
    fn document() -> SceneDocument {
        let mut scene = cube_room();
        let ball = Primitive::sphere(DVec3::splat(0.5), 0.25, 0);
        scene
            .objects
            .push(Object::new("ball", Shape::Primitive(ball)));
        SceneDocument::of_scene(scene, None)
    }

    #[test]
    fn chords_of_a_ball_stand_for_its_outside() {
        let document = document();
        let ball = document.objects.last().expect("a ball").id;
        let tracer = Tracer::new(&document.scene());
        for normal in [DVec3::X, DVec3::NEG_Z, DVec3::ONE.normalize()] {
            let pick = SurfacePick {
                item: ball,
                position: DVec3::splat(0.5) + 0.245 * normal,
                normal,
            };
            let point = on_surface(&document, &tracer, &pick).expect("the ball");
            let expected = DVec3::splat(0.5) + 0.25 * normal;
            assert!((point.position - expected).length() < 1e-9 && point.is_front);
        }
    }

    #[test]
    fn a_patch_sees_what_is_before_the_side_that_was_picked() {
        let document = document();
        let ball = document.objects.last().expect("a ball").id;
        let settings = LightSettings {
            patches: 60,
            ..LightSettings::default()
        };
        let seen = |item, position, normal| {
            let pick = SurfacePick {
                item,
                position,
                normal,
            };
            let seen = patch_form_factors(&document, &settings, &pick, &Progress::new());
            seen.expect("an answer").expect("not cancelled")
        };
        // From outside, the sphere sees only the room.
        let from_ball = seen(ball, DVec3::new(0.745, 0.5, 0.5), DVec3::X);
        assert!((from_ball.sum - 1.0).abs() < 0.02, "{}", from_ball.sum);
        assert!(from_ball.objects.iter().all(|(id, _)| *id != ball));
        // From outside, the room sees nothing.
        let wall = document.objects[0].id;
        let outside = seen(wall, DVec3::new(0.0, 0.2, 0.2), DVec3::NEG_X);
        assert!(outside.sum < 1e-9, "{}", outside.sum);
        let inside = seen(wall, DVec3::new(0.0, 0.2, 0.2), DVec3::X);
        assert!((inside.sum - 1.0).abs() < 0.02, "{}", inside.sum);
    }
}
