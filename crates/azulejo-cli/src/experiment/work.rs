//! One task, in its child process.

use super::plan::{EngineSetting, Origin, SceneChoice, Task, model_scene};
use super::record::{RunRecord, TaskOutcome, TaskRecord, TruthRecord};
use super::reference::{ReferenceData, spread};
use crate::clock::{Clock, peak_memory};
use crate::content_key::{self, ContentHasher};
use crate::engine::PreparedEngine;
use crate::failure::Failure;
use crate::known::factors::{Case, cases};
use crate::matrix_metrics::{self as metrics, PatchSurfaces};
use crate::pass;
use azulejo_factors::{FormFactorOptions, FormFactors, PatchSize, Patches, faceted};
use azulejo_radiosity::{FirstPass, radiosity};
use azulejo_scene::{Rgb, Scene, synthetic};
use azulejo_trace::Progress;
use std::path::Path;

/// Runs the task; `reference` is the reference task of its scene, with files in `folder`.
pub fn run(
    task: &Task,
    reference: Option<&Task>,
    folder: &Path,
    progress: &Progress,
) -> Result<Vec<TaskRecord>, Failure> {
    // An optional engine that is missing skips its task; that of a reference has to be there.
    let missing = match task {
        Task::Run(_, setting, _) | Task::Truths(setting) => setting.missing(),
        Task::Reference(..) => None,
    };
    let skipped = |reason| TaskOutcome::Skipped {
        task: task.to_string(),
        reason,
    };
    // Particles have light without a matrix, and are compared with the reference by radiosities alone.
    let outcomes = match task {
        _ if missing.is_some() => missing.into_iter().map(skipped).collect(),
        Task::Reference(scene, setting, rows) => {
            let matrix = ComputedMatrix::new(scene, setting, REFERENCE_SEED, progress)?;
            let (run, reference) = matrix.measured(None, *rows);
            reference.write(folder, &file_name(task), progress)?;
            vec![TaskOutcome::Reference(run)]
        }
        Task::Run(scene, setting, seed) if setting.is_particles() => {
            let reference = match reference {
                Some(task @ Task::Reference(_, _, rows)) => {
                    Some(ReferenceData::read(folder, &file_name(task), *rows)?)
                }
                _ => None,
            };
            let run = particles(scene, setting, *seed, reference.as_ref(), progress)?;
            vec![TaskOutcome::Run(run)]
        }
        Task::Run(scene, setting, seed) => {
            let matrix = ComputedMatrix::new(scene, setting, *seed, progress)?;
            // Take the rows of the reference; without one, reciprocity is still measured on some.
            let (reference, rows) = match reference {
                Some(task @ Task::Reference(_, _, rows)) => {
                    let read = ReferenceData::read(folder, &file_name(task), *rows)?;
                    (Some(read), *rows)
                }
                _ => (None, 256),
            };
            vec![TaskOutcome::Run(
                matrix.measured(reference.as_ref(), rows).0,
            )]
        }
        Task::Truths(setting) => truths(setting, progress)?,
    };
    let record = |outcome| TaskRecord {
        key: task.key(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        outcome,
    };
    Ok(outcomes.into_iter().map(record).collect())
}

/// A seed that no run has by accident: runs must not share the noise of the reference.
const REFERENCE_SEED: u64 = 0x7265_6665_7265_6e63;

/// Name of a reference's files: a hash of its key, which is not a valid file name.
fn file_name(task: &Task) -> String {
    let key = ContentHasher::new().add(&*task.key()).key();
    format!("reference-{}", content_key::shown(&key))
}

/// Form factors, with the time and memory they took.
struct ComputedMatrix {
    scene: Scene,
    choice: SceneChoice,
    setting: EngineSetting,
    seed: u64,
    size: PatchSize,
    factors: FormFactors,
    notes: Vec<String>,
    seconds: f64,
    cpu_seconds: f64,
    peak_bytes: Option<u64>,
}

impl ComputedMatrix {
    fn new(
        choice: &SceneChoice,
        setting: &EngineSetting,
        seed: u64,
        progress: &Progress,
    ) -> Result<ComputedMatrix, Failure> {
        let scene = scene(&choice.origin)?;
        let prepared = setting.args.prepare()?;
        let size = choice.size();
        let options = FormFactorOptions {
            size,
            seed,
            ..options(setting, &prepared)
        };
        let clock = Clock::start();
        let tracer = prepared.tracer(&scene)?;
        let factors = azulejo_factors::form_factors(&scene, &tracer, &options, progress)
            .map_err(pass::failure)?;
        Ok(ComputedMatrix {
            seconds: clock.wall(),
            cpu_seconds: clock.cpu(),
            peak_bytes: peak_memory(),
            scene,
            choice: choice.clone(),
            setting: setting.clone(),
            seed,
            size,
            factors,
            notes: prepared.notes().to_vec(),
        })
    }

    /// Its measures, and its data as a reference.
    fn measured(
        self,
        reference: Option<&ReferenceData>,
        rows: usize,
    ) -> (RunRecord, ReferenceData) {
        // Divide the scene as the matrix does, and solve for radiosities by its factors.
        let (factors, scene) = (&self.factors, faceted(&self.scene, self.size));
        let surfaces = PatchSurfaces::new(&scene, &Patches::new(&scene, self.size));
        let clock = Clock::start();
        let light = metrics::radiosity(factors, &surfaces);
        let solve_seconds = clock.wall();
        // A sample of rows, evenly spread, stands for the matrix in comparisons.
        let indices = spread(factors.len(), rows);
        let row = |&i: &usize| factors.row(i).map(|(j, x, _)| (j, x)).collect();
        let own = ReferenceData {
            rows: indices.iter().map(row).collect(),
            radiosity: light.leaving.clone(),
            indices,
        };
        // Compare rows and radiosities with those of the reference, where there is one.
        let row_errors = reference.map(|r| {
            let pairs = own.rows.iter().zip(&r.rows);
            metrics::mean_and_largest(
                &pairs
                    .map(|(a, b)| metrics::row_error(a, b))
                    .collect::<Vec<_>>(),
            )
        });
        let b_errors = reference
            .map(|r| metrics::radiosity_errors(&own.radiosity, &r.radiosity))
            .filter(|errors| !errors.is_empty())
            .map(|errors| metrics::mean_and_largest(&errors));
        // Measure what the matrix shows by itself: its closure, and the errors that its engine states.
        let closure = metrics::closure_errors(factors);
        let squares: Vec<f64> = closure.iter().map(|e| e * e).collect();
        let sums = factors.row_sums();
        let stated = factors
            .row_errors
            .iter()
            .zip(&sums)
            .filter(|(_, sum)| **sum > 0.0);
        let stated: Vec<f64> = stated.map(|(error, sum)| error / sum).collect();
        let ran = &factors.engine_used;
        let run = RunRecord {
            scene: self.choice.to_string(),
            mirrors: self.choice.mirrors(),
            engine: self.setting.name.clone(),
            setting: self.setting.to_string(),
            rays: self.setting.rays,
            resolution: self.setting.args.resolution,
            patch_points: self.setting.args.patch_points,
            seed: self.seed,
            ran: ran.name.clone(),
            device: ran.device.clone(),
            notes: self.notes.iter().chain(&ran.notes).cloned().collect(),
            facets: factors.len(),
            entries: factors.exchange.entries() as u64,
            samples: factors.rays as f64 / factors.len().max(1) as f64,
            seconds: self.seconds,
            cpu_seconds: self.cpu_seconds,
            solve_seconds,
            peak_bytes: self.peak_bytes,
            row_error_mean: row_errors.map(|e| e.0),
            row_error_max: row_errors.map(|e| e.1),
            row_error_stated: Some(metrics::mean_and_largest(&stated).0).filter(|e| e.is_finite()),
            b_error_mean: b_errors.map(|e| e.0),
            b_error_max: b_errors.map(|e| e.1),
            closure_rms: metrics::mean_and_largest(&squares).0.sqrt(),
            closure_max: metrics::mean_and_largest(&closure).1,
            moved: factors.closed.map_or(0.0, |m| m.total),
            reciprocity: metrics::reciprocity_error(factors, &own.indices),
            energy: metrics::energy_error(factors, &surfaces, &light),
        };
        (run, own)
    }
}

/// B by particles: of the light that emitters send, as the matrices of the other engines give it.
fn particles(
    choice: &SceneChoice,
    setting: &EngineSetting,
    seed: u64,
    reference: Option<&ReferenceData>,
    progress: &Progress,
) -> Result<RunRecord, Failure> {
    let mut scene = scene(&choice.origin)?;
    // Matrices know only surfaces that emit, so other lights are left out for a comparison.
    scene.lights.clear();
    let prepared = setting.args.prepare()?;
    let pass = FirstPass {
        engine: prepared.engine.clone(),
        size: choice.size(),
        rays: Some(setting.rays.unwrap_or(FormFactorOptions::default().rays)),
        seed,
        ..FirstPass::default()
    };
    // The time includes building the tracer, as that of matrices does.
    let clock = Clock::start();
    let tracer = prepared.tracer(&scene)?;
    let solution = radiosity(&scene, &tracer, &pass, progress).map_err(Failure::failed)?;
    let (wall, cpu, peak_bytes) = (clock.wall(), clock.cpu(), peak_memory());
    // The rows of a reference are the fronts of patches, which are the even ones among the sides.
    let fronts: Vec<Rgb> = solution.sides.iter().step_by(2).map(|e| e.value).collect();
    let errors = reference.map(|r| metrics::radiosity_errors(&fronts, &r.radiosity));
    let errors = errors.filter(|errors| !errors.is_empty());
    let errors = errors.map(|errors| metrics::mean_and_largest(&errors));
    // Without a matrix there are no rows to measure: radiosities and the energy balance remain.
    let (report, facets) = (&solution.report, solution.patches.len());
    let balance = &report.balance;
    Ok(RunRecord {
        scene: choice.to_string(),
        mirrors: choice.mirrors(),
        engine: setting.name.clone(),
        setting: setting.to_string(),
        rays: setting.rays,
        seed,
        ran: report.engine_used.name.clone(),
        device: report.engine_used.device.clone(),
        notes: report.engine_used.notes.clone(),
        facets,
        samples: report.patch_rays as f64 / facets.max(1) as f64,
        seconds: wall,
        cpu_seconds: cpu,
        peak_bytes,
        b_error_mean: errors.map(|e| e.0),
        b_error_max: errors.map(|e| e.1),
        energy: Some(balance.error()),
        ..RunRecord::default()
    })
}

fn options(setting: &EngineSetting, prepared: &PreparedEngine) -> FormFactorOptions {
    let default = FormFactorOptions::default();
    FormFactorOptions {
        engine: prepared.engine.clone(),
        rays: setting.rays.unwrap_or(default.rays),
        analytic: setting.formulas,
        accuracy: setting.accuracy,
        closure: setting.closure,
        memory: azulejo::machine::memory_budget(),
        ..default
    }
}

fn scene(origin: &Origin) -> Result<Scene, Failure> {
    Ok(match origin {
        Origin::Cube => synthetic::cube_room(),
        &Origin::RoomWithTable(facets) => synthetic::room_with_table(facets),
        &Origin::CornellThesis(mirrors, detail) => synthetic::cornell_thesis_at(mirrors, detail),
        &Origin::Street(detail) => synthetic::street_with_detail(detail),
        Origin::File(path, _) => model_scene(path)?,
    })
}

/// Default number of rays of all rows of a case together; undivided faces have 65,536 each.
const TRUTH_RAYS: usize = 1 << 19;

fn truths(setting: &EngineSetting, progress: &Progress) -> Result<Vec<TaskOutcome>, Failure> {
    let prepared = setting.args.prepare()?;
    let mut outcomes = Vec::new();
    for case in cases() {
        outcomes.push(TaskOutcome::Truth(answered(
            &case, setting, &prepared, progress,
        )?));
    }
    Ok(outcomes)
}

fn answered(
    case: &Case,
    setting: &EngineSetting,
    prepared: &PreparedEngine,
    progress: &Progress,
) -> Result<TruthRecord, Failure> {
    let patches = Patches::new(&case.scene, case.size).len().max(1);
    let rays = (TRUTH_RAYS / patches).clamp(1 << 10, 1 << 16) as u32;
    let options = FormFactorOptions {
        rays: setting.rays.unwrap_or(rays),
        ..options(setting, prepared)
    };
    let clock = Clock::start();
    let tracer = prepared.tracer(&case.scene)?;
    let (answer, factors) = case
        .ask(&tracer, &options, progress)
        .map_err(pass::failure)?;
    let off = answer.standard_errors(case);
    Ok(TruthRecord {
        engine: setting.name.clone(),
        setting: setting.to_string(),
        ran: factors.engine_used.name,
        case: case.id.clone(),
        words: case.description.clone(),
        source: case.source.clone(),
        kind: format!("{:?}", case.kind).to_lowercase(),
        value: answer.value,
        truth: case.truth.value,
        truth_error: case.truth.error,
        standard_error: Some(answer.error).filter(|e| e.is_finite()),
        standard_errors: off.is_finite().then_some(off),
        seconds: clock.wall(),
    })
}
