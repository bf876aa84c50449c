//! `form-factors`: the matrix between patches, or between groups of them.

mod archive;
pub mod args;
mod journal;
mod outside;
mod summary;
mod table;
mod view3d;

use super::content_key::{ContentHasher, ContentKey};
use super::engine::{EngineName, PreparedEngine};
use super::failure::Failure;
use super::report::{Report, bytes, count};
use super::session::Session;
use super::{input, pass};
use args::{FormFactorArgs, FormatName, FormulasName};
use azulejo::output::Output;
use azulejo_factors::form_factors::{
    Forecast, Journal, NamedGroups, NoJournal, Plan, PreparedPlan,
};
use azulejo_factors::{
    Engine, FactorsError, FormFactorOptions, FormFactors, Hemicube, HemicubeBackend, PatchSize,
};
use azulejo_formats::Format;
use azulejo_formats::view3d::MatrixLayout;
use azulejo_scene::Scene;
use azulejo_trace::{Gathered, Tracer};
use journal::FileJournal;
use std::borrow::Cow;
use std::path::PathBuf;

/// A matrix to be written.
struct NamedMatrix<'a> {
    factors: &'a FormFactors,
    /// Names of the rows, if they are groups.
    names: Option<&'a [String]>,
    /// Irradiance of the rows by light from outside, if there is any.
    outside: Option<&'a [Gathered]>,
}

/// Output formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MatrixFormat {
    Archive,
    Table,
    /// View3D's; without a layout, in the one its input specifies.
    View3d(Option<MatrixLayout>),
}

/// Runs `form-factors`.
pub fn run(args: &FormFactorArgs, session: &mut Session) -> Result<Report, Failure> {
    let output = Output::check(&args.output)?;
    let format = matrix_format(args, &output)?;
    session.claim_stdout(output.is_stdout())?;
    refuse_contradiction(args)?;
    if args.engine.engine == EngineName::Particles {
        let message =
            "particles have no form factors: --engine particles is for solve, render and probe";
        return Err(Failure::misuse(message));
    }
    let engine = args.engine.prepare()?;
    let room = view3d::read(args, session)?;
    let scene = match &room {
        Some(room) => Cow::Borrowed(room.scene()),
        None => Cow::Owned(read_models(args, session)?),
    };
    let tracer = engine.tracer(&scene)?;
    let mut options = options(args, &engine);
    if let Some(room) = &room {
        options = room.options(options, args.rays);
    }
    let mut report = Report::default();
    let plan = Plan::new(&scene, &tracer, &options).map_err(pass::failure)?;
    let prepared = plan.prepare();
    forecast(&prepared, session, &mut report)?;
    let journal = open_journal(args, &output, &scene, &tracer, &options)?;
    let computed = compute(&prepared, journal.as_ref(), session);
    journal
        .iter()
        .flat_map(FileJournal::take_messages)
        .for_each(|message| session.note(&message));
    let (mut factors, names, outside) = match &room {
        Some(room) => (
            room.finish(&computed?, session, &mut report)?,
            Some(room.names()),
            None,
        ),
        None => {
            let computed = computed?;
            let outside = outside::irradiance(&prepared, &scene, &computed, session)?;
            grouped(&scene, computed, outside, args)
        }
    };
    if let Some(share) = args.matrix.truncate {
        session.with_progress(|p| factors.truncate(share, p))?;
    }
    let matrix = NamedMatrix {
        factors: &factors,
        names: names.as_deref(),
        outside: outside.as_deref(),
    };
    output.write(session.progress(), |out| match format {
        MatrixFormat::Archive => archive::write(&matrix, out),
        MatrixFormat::Table => table::write(&matrix, out),
        MatrixFormat::View3d(layout) => {
            view3d::write(room.as_ref(), layout, &factors, &scene.materials, out)
        }
    })?;
    if let Some(journal) = journal {
        journal.remove();
    }
    engine.describe(&factors.engine_used, &mut report);
    summary::describe(&matrix, &mut report);
    if let Some(rows) = matrix.outside {
        outside::describe(rows, &factors.areas, &mut report);
    }
    let path = args.output.display().to_string();
    report.fact("output", path.clone(), "wrote", path);
    Ok(report)
}

/// The analytic engine without formulas would be nothing.
fn refuse_contradiction(args: &FormFactorArgs) -> Result<(), Failure> {
    let is_analytic = args.engine.engine == EngineName::Analytic;
    if is_analytic && args.matrix.formulas == FormulasName::Never {
        return Err(Failure::misuse(format_args!(
            "--formulas=never does not apply to --engine analytic, which is formulas alone"
        )));
    }
    Ok(())
}

/// Reads models whose rows are patches or groups of them.
fn read_models(args: &FormFactorArgs, session: &mut Session) -> Result<Scene, Failure> {
    let scene = input::read_all(&args.input, session)?;
    if session.formats().contains(&Format::View3d) {
        session.note(
            "rows are patches: View3D's own rows, with its masks, combinations and enclosures, \
             require a single View3D file, given by name, neither placed nor divided",
        );
    }
    Ok(scene)
}

fn matrix_format(args: &FormFactorArgs, output: &Output) -> Result<MatrixFormat, Failure> {
    match args.format {
        Some(FormatName::Npz) => return Ok(MatrixFormat::Archive),
        Some(FormatName::Csv) => return Ok(MatrixFormat::Table),
        Some(FormatName::View3d) => return Ok(MatrixFormat::View3d(Some(MatrixLayout::Text))),
        Some(FormatName::View3dBinary) => {
            return Ok(MatrixFormat::View3d(Some(MatrixLayout::Binary)));
        }
        None => {}
    }
    let extension = args.output.extension().and_then(|e| e.to_str());
    match extension.unwrap_or("").to_ascii_lowercase().as_str() {
        "npz" => Ok(MatrixFormat::Archive),
        "csv" => Ok(MatrixFormat::Table),
        "txt" => Ok(MatrixFormat::View3d(Some(MatrixLayout::Text))),
        "vf" => Ok(MatrixFormat::View3d(None)),
        _ if output.is_stdout() => Ok(MatrixFormat::Table),
        _ => Err(Failure::misuse(format_args!(
            "{}: unknown matrix format, expected .npz, .csv, .txt or .vf (View3D), or --format",
            args.output.display()
        ))),
    }
}

/// The rows of groups with their names, if groups are requested, and the light of each from outside.
fn grouped(
    scene: &Scene,
    factors: FormFactors,
    outside: Option<Vec<Gathered>>,
    args: &FormFactorArgs,
) -> (FormFactors, Option<Vec<String>>, Option<Vec<Gathered>>) {
    match args.matrix.by {
        None => (factors, None, outside),
        Some(by) => {
            let groups = NamedGroups::new(scene, &factors, by.into());
            let count = groups.names.len();
            let light = |rows: Vec<Gathered>| {
                outside::grouped(&rows, &factors.areas, &groups.of_rows, count)
            };
            let outside = outside.map(light);
            let factors = factors.grouped(&groups.of_rows, count);
            (factors, Some(groups.names), outside)
        }
    }
}

fn options(args: &FormFactorArgs, prepared: &PreparedEngine) -> FormFactorOptions {
    let default = FormFactorOptions::default();
    let machine = || azulejo::machine::memory().unwrap_or(u64::MAX);
    let has_formulas = args.matrix.formulas == FormulasName::Auto;
    let engine = match (&prepared.engine, args.rays) {
        (Engine::Auto, Some(_)) => Engine::Rays,
        (Engine::Auto, None) if !has_formulas => Engine::Rays,
        (engine, _) => engine.clone(),
    };
    FormFactorOptions {
        engine,
        size: pass::patch_size(&args.division).unwrap_or(default.size),
        rays: args.rays.unwrap_or(default.rays),
        two_sided: args.two_sided,
        seed: args.seed,
        separate: args.matrix.separate,
        closure: args.matrix.closure(),
        analytic: has_formulas,
        memory: args.memory.unwrap_or_else(machine),
        ..default
    }
}

/// Reports the expected size of the matrix before the work begins.
fn forecast(
    plan: &PreparedPlan,
    session: &mut Session,
    report: &mut Report,
) -> Result<(), Failure> {
    let forecast = session
        .with_progress(|p| plan.forecast(p))
        .map_err(pass::failure)?;
    let Forecast {
        rows,
        pairs,
        bytes: needed,
    } = forecast;
    session.say(&format!(
        "forecast  {} rows, up to {} pairs, {} of memory",
        count(rows),
        count(pairs),
        bytes(needed)
    ));
    report.value("forecast_pairs", pairs);
    report.value("forecast_bytes", needed);
    Ok(())
}

/// The journal next to an output file; standard output and devices have none.
fn open_journal(
    args: &FormFactorArgs,
    output: &Output,
    scene: &Scene,
    tracer: &Tracer,
    options: &FormFactorOptions,
) -> Result<Option<FileJournal>, Failure> {
    let Some(file) = output.file().filter(|_| !args.no_journal) else {
        return Ok(None);
    };
    let mut name = file.as_os_str().to_owned();
    name.push(".journal");
    FileJournal::open(PathBuf::from(name), key(scene, tracer, options)).map(Some)
}

/// A hash of everything that the rows depend on.
fn key(scene: &Scene, tracer: &Tracer, options: &FormFactorOptions) -> ContentKey {
    let FormFactorOptions {
        engine,
        size,
        rays,
        two_sided,
        seed,
        analytic,
        separate,
        accuracy,
        // These affect what is done with the rows afterwards.
        closure: _,
        memory: _,
    } = options;
    let mut hasher = ContentHasher::new();
    hasher
        .add(env!("CARGO_PKG_VERSION"))
        .add(&tracer.kernel_name());
    add_engine(engine, &mut hasher);
    match *size {
        PatchSize::Count(patches) => hasher.add(&0u8).add(&patches),
        PatchSize::Squares(patches) => hasher.add(&1u8).add(&patches),
        PatchSize::Edge(length) => hasher.add(&2u8).add(&length),
    };
    hasher
        .add(rays)
        .add(two_sided)
        .add(seed)
        .add(analytic)
        .add(separate)
        .add(accuracy)
        .add(scene)
        .key()
}

/// An engine with all its settings.
fn add_engine(engine: &Engine, hasher: &mut ContentHasher) {
    let mut hemicubes = |kind: &str, hemicube: &Hemicube| {
        let Hemicube {
            resolution,
            points,
            device,
        } = hemicube;
        let device = match device {
            HemicubeBackend::Processor => "processor".to_owned(),
            HemicubeBackend::Device(device) => device.name(),
        };
        hasher.add(kind).add(resolution).add(points).add(&device);
    };
    match engine {
        Engine::Hemicube(hemicube) => hemicubes("hemicube", hemicube),
        Engine::Hybrid(hemicube) => hemicubes("hybrid", hemicube),
        Engine::Auto => {
            hasher.add("auto");
        }
        Engine::Rays => {
            hasher.add("rays");
        }
        Engine::Analytic => {
            hasher.add("analytic");
        }
        Engine::Particles => {
            hasher.add("particles");
        }
    }
}

/// Computes under a progress bar, and reports how to resume if interrupted.
fn compute(
    plan: &PreparedPlan,
    journal: Option<&FileJournal>,
    session: &mut Session,
) -> Result<FormFactors, Failure> {
    if let Some(journal) = journal.filter(|j| j.blocks() > 0) {
        let words = format!("resuming from {}", journal.path().display());
        session.say(&words);
    }
    let kept: &dyn Journal = match journal {
        Some(journal) => journal,
        None => &NoJournal,
    };
    match session.with_progress(|p| plan.compute(kept, p)) {
        Ok(factors) => Ok(factors),
        Err(FactorsError::Cancelled) if journal.is_some_and(|j| j.blocks() > 0) => {
            session.say("completed work is kept: the same command resumes from there");
            Err(Failure::Cancelled)
        }
        Err(e) => Err(pass::failure(e)),
    }
}

/// The entry of a column in a row, or zeros.
fn entry_of(row: &[(u32, f64, f32)], column: u32) -> (u32, f64, f32) {
    let found = row.binary_search_by_key(&column, |&(j, ..)| j);
    found.map_or((column, 0.0, 0.0), |k| row[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_factors::FaceId;
    use azulejo_factors::form_factors::{Exchange, ExchangeAreas, RowRemainder};

    /// A matrix of two rows, half of whose light came by a mirror.
    pub fn two_squares() -> FormFactors {
        let face = |object, face| FaceId { object, face };
        let pair = |share: f64| Exchange {
            column: 1,
            value: 0.5 * share,
            error: 0.25 * share as f32,
        };
        let areas = |share| ExchangeAreas::from_iter([vec![pair(share)], vec![]]);
        let rest = |sky| RowRemainder {
            sky,
            sky_error: 0.0625,
            ..RowRemainder::default()
        };
        FormFactors {
            exchange: areas(1.0),
            orders: vec![
                areas(0.5),
                areas(0.5),
                ExchangeAreas::from_iter([vec![], vec![]]),
            ],
            areas: vec![2.0, 1.0],
            faces: vec![face(0, 3), face(7, 0)],
            materials: vec![0, 0],
            is_back: vec![false, true],
            rest: vec![rest(0.75), rest(0.5)],
            ends: vec![1.0; 2],
            row_errors: vec![0.1, 0.2],
            ..FormFactors::default()
        }
    }
}

#[cfg(test)]
mod key_tests {
    use super::*;
    use azulejo_scene::brdf::{Brdf, Content, Description, Measured, Merl};
    use azulejo_scene::synthetic::cube_room;
    use std::sync::Arc;

    /// A room whose walls reflect by a measured table.
    fn room(value: f32) -> Scene {
        let mut scene = cube_room();
        let table = Merl::new([2, 2, 2], vec![[0.1, 0.1, value]; 8]).unwrap();
        let content = Content::Measured(Arc::new(Measured::Merl(table)));
        let file = Description::File {
            path: "wall.binary".into(),
            content: Some(Arc::new(content)),
        };
        scene.materials[0].brdf = Some(Arc::new(Brdf::new(file).unwrap()));
        scene
    }

    #[test]
    fn rows_of_another_table_or_of_other_options_are_not_continued() {
        let options = FormFactorOptions::default();
        let key_of =
            |scene: &Scene, options: &FormFactorOptions| key(scene, &Tracer::new(scene), options);
        let first = key_of(&room(0.1), &options);
        assert_eq!(key_of(&room(0.1), &options), first);
        assert_ne!(key_of(&room(0.125), &options), first);
        let default = FormFactorOptions::default;
        let others = [
            FormFactorOptions {
                rays: 7,
                ..default()
            },
            FormFactorOptions {
                seed: 7,
                ..default()
            },
            FormFactorOptions {
                accuracy: Some(0.1),
                ..default()
            },
            FormFactorOptions {
                engine: Engine::Rays,
                ..default()
            },
            FormFactorOptions {
                engine: Engine::Hybrid(Hemicube::default()),
                ..default()
            },
            FormFactorOptions {
                size: PatchSize::Count(9),
                ..default()
            },
            FormFactorOptions {
                size: PatchSize::Squares(9),
                ..default()
            },
            FormFactorOptions {
                size: PatchSize::Edge(9.0),
                ..default()
            },
        ];
        for (k, other) in others.iter().enumerate() {
            assert_ne!(key_of(&room(0.1), other), first, "{k}");
        }
        let later = FormFactorOptions {
            memory: 1,
            ..default()
        };
        assert_eq!(key_of(&room(0.1), &later), first);
    }
}
