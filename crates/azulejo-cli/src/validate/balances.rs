//! Closure, reciprocity and energy of whole scenes, and whether their stated errors are true.

use super::Validator;
use super::engines::{CheckedEngine, EngineFamily};
use super::record::{CheckRecord, ValidationPart};
use crate::clock::Clock;
use crate::failure::Failure;
use crate::matrix_metrics::{self as metrics, PatchSurfaces};
use crate::pass;
use azulejo_factors::form_factors::Closure;
use azulejo_factors::{
    Engine, FormFactorOptions, FormFactors, PatchSize, Patches, faceted, form_factors,
};
use azulejo_scene::{Scene, synthetic};
use azulejo_trace::Tracer;

const PART: ValidationPart = ValidationPart::Balances;

/// Deviations of sums from 1, and of energy, after closure.
const BALANCED: f64 = 1e-6;

/// Relative difference of A_i X_ij and A_j X_ji, of which one is stored.
const RECIPROCAL: f64 = 1e-12;

/// Stated errors are between a half and twice the true ones.
const HONEST: [f64; 2] = [0.5, 2.0];

/// Rows whose reciprocity is checked.
const ROWS: usize = 64;

/// A scene by its name.
pub struct WholeScene {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// The scene.
    pub scene: Scene,
    /// Its division.
    pub size: PatchSize,
}

impl WholeScene {
    /// Those of which several matrices are computed.
    pub fn small() -> Vec<WholeScene> {
        vec![
            WholeScene {
                name: "cube of 96 facets",
                about: "unit cube, inside",
                scene: synthetic::cube_room(),
                size: PatchSize::Edge(0.25),
            },
            WholeScene {
                name: "room with table",
                about: "room with a table and two boxes",
                scene: synthetic::room_with_table(500),
                size: PatchSize::Edge(0.0),
            },
        ]
    }

    /// All of them.
    pub fn all() -> Vec<WholeScene> {
        let mut scenes = WholeScene::small();
        scenes.push(WholeScene {
            name: "room with mirrors",
            about: "box with two blocks, of which 16 facets are mirrors",
            scene: synthetic::cornell_thesis_at(16, 0.05),
            size: PatchSize::Edge(0.0),
        });
        scenes.push(WholeScene {
            name: "street",
            about: "street of 24 houses below a dome, a quarter of the windows mirrors",
            scene: synthetic::street_with_detail(0.02),
            size: PatchSize::Edge(0.0),
        });
        scenes.push(WholeScene {
            name: "array of cubes",
            about: "16 cubes on a plane below the sky, a quarter of it built on",
            scene: synthetic::cube_array(4, 2),
            size: PatchSize::Edge(0.0),
        });
        scenes
    }
}

/// Checks all scenes by all engines.
pub fn check(validator: &Validator) -> Result<Vec<CheckRecord>, Failure> {
    let mut records = Vec::new();
    for scene in WholeScene::all() {
        if !validator.wants(PART, scene.name) {
            continue;
        }
        validator.tell(&format!("{}: {}", scene.name, scene.about));
        let reference = reference(validator, &scene)?;
        for engine in &validator.engines.engines {
            records.extend(balances(validator, engine, &scene)?);
            if engine.family != EngineFamily::Analytic {
                records.push(stated_error(validator, engine, &scene, &reference)?);
            }
        }
    }
    Ok(records)
}

/// Closed forms with exact occlusion; many rays where mirrors make endless chains.
fn reference(validator: &Validator, scene: &WholeScene) -> Result<FormFactors, Failure> {
    let options = FormFactorOptions {
        engine: Engine::Analytic,
        size: scene.size,
        closure: Closure::Never,
        // Not the noise of what is compared with it.
        seed: !validator.seed,
        rays: 1 << 16,
        ..FormFactorOptions::default()
    };
    let tracer = Tracer::new(&scene.scene);
    form_factors(&scene.scene, &tracer, &options, validator.progress).map_err(pass::failure)
}

/// The balances of a matrix with closure, as users get it.
fn balances(
    validator: &Validator,
    engine: &CheckedEngine,
    whole: &WholeScene,
) -> Result<[CheckRecord; 3], Failure> {
    let clock = Clock::start();
    let rays = validator.effort.rays;
    let options = FormFactorOptions {
        closure: Closure::Always,
        ..engine.options(&whole.scene, whole.size, rays, validator.seed)
    };
    let tracer = engine.prepared.tracer(&whole.scene)?;
    let factors = form_factors(&whole.scene, &tracer, &options, validator.progress);
    let factors = factors.map_err(pass::failure)?;
    let seconds = clock.wall();
    let scene = faceted(&whole.scene, whole.size);
    let mut surfaces = PatchSurfaces::new(&scene, &Patches::new(&scene, whole.size));
    // All surfaces shine: each pair takes part in the balance.
    surfaces.exitance.fill(azulejo_scene::Rgb::WHITE);
    let light = metrics::radiosity(&factors, &surfaces);
    let closure = metrics::mean_and_largest(&metrics::closure_errors(&factors)).1;
    let rows: Vec<usize> = (0..factors.len())
        .step_by(factors.len().div_ceil(ROWS).max(1))
        .collect();
    let reciprocity = metrics::reciprocity_error(&factors, &rows);
    let energy = metrics::energy_error(&factors, &surfaces, &light).unwrap_or(f64::NAN);
    let facets = factors.len();
    let check = |words: &str, value: f64, bound: f64| CheckRecord {
        note: format!("{facets} facets"),
        source: whole.about.to_owned(),
        seconds,
        ..CheckRecord::new(PART, whole.name, [value, 0.0, bound]).of(engine.name, words)
    };
    Ok([
        check("largest deviation of a row's sum from 1", closure, BALANCED),
        check(
            "largest difference of A_i X_ij and A_j X_ji",
            reciprocity,
            RECIPROCAL,
        ),
        check(
            "power that is neither absorbed nor leaves",
            energy,
            BALANCED,
        ),
    ])
}

/// The mean error that rows state over that against the reference, without closure.
fn stated_error(
    validator: &Validator,
    engine: &CheckedEngine,
    whole: &WholeScene,
    reference: &FormFactors,
) -> Result<CheckRecord, Failure> {
    let clock = Clock::start();
    // Fewer rays than for balances, so that the error is far above that of the reference.
    let rays = validator.effort.rays / 4;
    let options = FormFactorOptions {
        closure: Closure::Never,
        ..engine.options(&whole.scene, whole.size, rays, validator.seed)
    };
    let tracer = engine.prepared.tracer(&whole.scene)?;
    let factors = form_factors(&whole.scene, &tracer, &options, validator.progress);
    let factors = factors.map_err(pass::failure)?;
    let sums = factors.row_sums();
    let row_sum = |i: usize| sums[i] + factors.rest[i].escaped();
    let seeing: Vec<usize> = (0..factors.len()).filter(|&i| row_sum(i) > 0.0).collect();
    let mean = |error: &dyn Fn(usize) -> f64| {
        let errors: Vec<f64> = seeing.iter().map(|&i| error(i)).collect();
        metrics::mean_and_largest(&errors).0
    };
    let true_error =
        mean(&|i| metrics::row_error(&whole_row(&factors, i), &whole_row(reference, i)));
    let stated = mean(&|i| factors.row_errors[i] / row_sum(i));
    let [low, high] = HONEST;
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    Ok(CheckRecord {
        note: format!(
            "true {:.2}%, stated {:.2}%",
            100.0 * true_error,
            100.0 * stated
        ),
        source: format!("{}; against closed forms", whole.about),
        seconds: clock.wall(),
        ..CheckRecord::new(PART, whole.name, [stated / true_error, middle, half])
            .of(engine.name, "mean row error: stated over true")
    })
}

/// A row with sky and ground, which its stated error includes, as further columns.
fn whole_row(factors: &FormFactors, i: usize) -> metrics::SparseRow {
    let rest = &factors.rest[i];
    let outside = [(u32::MAX - 1, rest.sky), (u32::MAX, rest.ground)];
    let row = factors.row(i).map(|(j, x, _)| (j, x));
    row.chain(outside).collect()
}
