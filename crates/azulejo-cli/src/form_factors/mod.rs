//! `form-factors`: the matrix between patches, or between groups of them.

pub mod args;
pub mod compress;
mod destination;
mod facing;
mod grouping;
mod outside;
mod points;
pub mod stored;
pub mod summary;
mod view3d;
mod zones;

use super::content_key::{ContentHasher, ContentKey};
use super::engine::{self, EngineName, PreparedEngine};
use super::failure::Failure;
use super::input::{ClockArgs, InputArgs};
use super::report::{Report, bytes, count};
use super::runner::{Completed, DividedWork, Runner, Sharing, WorkKey};
use super::session::Session;
use super::{input, pass};
use args::{ClosureName, ComputationArgs, FormFactorArgs, FormulasName};
use azulejo::models;
use azulejo_exchange::thermal::tables::{MaterialTable, TableError};
use azulejo_exchange::{Enclosure, GroupBy};
use azulejo_factors::form_factors::{Forecast, NOT_RECONCILED, Plan, PreparedPlan};
use azulejo_factors::{Engine, FormFactorOptions, Hemicube, PatchSize};
use azulejo_formats::Format;
use azulejo_scene::Scene;
use azulejo_trace::{Run, Tracer};
use destination::Destination;
use outside::AskedSky;
use std::path::Path;
use view3d::View3dInput;

/// Computes the matrix, or a part of its rows, and writes it.
pub fn run(
    args: &FormFactorArgs,
    runner: Runner,
    session: &mut Session,
) -> Result<Report, Failure> {
    if let Some(from) = &args.from.from {
        if let Some(by) = runner.shared_by() {
            return Err(Failure::misuse(format_args!(
                "{by} and --from: points take little time; divide their file, if they are very many"
            )));
        }
        return points::run(args, from, session);
    }
    // Compression is the work of one process, since its blocks depend on all rows.
    if let Some(tolerance) = args.matrix.compress {
        let merge = runner.is_merged().then_some("merge");
        if let Some(by) = runner.shared_by().or(merge) {
            return Err(Failure::misuse(format_args!(
                "--compress and {by}: the blocks of a part are not those of the whole; compress the model in one piece"
            )));
        }
        return compress::run(args, tolerance, session);
    }
    if let Some(by) = runner.shared_by() {
        refuse_computed(args, by)?;
    }
    // Check the output before the work begins; a process that does not make the result has none.
    let destination = runner
        .writes()
        .then(|| Destination::new(args))
        .transpose()?;
    session.claim_stdout(destination.as_ref().is_some_and(|to| to.output.is_stdout()))?;
    let mut report = Report::default();
    // Factors that were computed before are only reworked: closed, grouped or truncated.
    if let Some(enclosure) = stored::read(args, session)? {
        let enclosure = stored::rework(enclosure, args, session)?;
        if let Some(to) = destination {
            write(args, (enclosure, None), to, session, &mut report)?;
        }
        return Ok(report);
    }
    // A View3D file keeps its own rows; other models are divided into patches.
    let (room, scene) = read_scene(args, session)?;
    runner.share_files(session)?;
    let scene = room.as_ref().map_or(&scene, View3dInput::scene);
    let computation = ComputationArgs {
        closure: args.closure(),
        ..args.computation.clone()
    };
    let sky = AskedSky::of(args)?;
    if sky.is_some() && room.is_some() {
        return Err(Failure::misuse(
            "--sky-patches: a View3D file has rows of its own, without a sky in patches",
        ));
    }
    let request = FactorRequest {
        computation: &computation,
        sky,
        separate: args.matrix.separate,
        groups: args.only_groups(),
        room: room.as_ref(),
    };
    let beside = destination.as_ref().and_then(|to| to.output.file());
    let beside = beside.filter(|_| !args.no_journal);
    // The zones of a building are enclosures of their own, which do not see each other.
    let computed = match zones::scenes(scene, args)?.as_slice() {
        [] => enclosure(scene, request, (runner, beside), session, &mut report)?,
        [zone] => enclosure(zone, request, (runner, beside), session, &mut report)?,
        zones => zones::enclosures(zones, request, runner, session, &mut report)?,
    };
    let (Some(Completed { value, rest }), Some(to)) = (computed, destination) else {
        return Ok(report);
    };
    let enclosure = match room {
        None => grouping::grouped(value, args, session)?,
        Some(_) => value,
    };
    write(args, (enclosure, room.as_ref()), to, session, &mut report)?;
    rest.finish(&mut report);
    Ok(report)
}

/// Writes the matrix, and describes it.
fn write(
    args: &FormFactorArgs,
    (mut enclosure, room): (Enclosure, Option<&View3dInput>),
    to: Destination,
    session: &mut Session,
    report: &mut Report,
) -> Result<(), Failure> {
    if let Some(share) = args.matrix.truncate {
        session.with_progress(|p| enclosure.factors.truncate(share, p))?;
    }
    refuse_impossible(args, &enclosure)?;
    let written = to.write(&enclosure, room, session)?;
    summary::describe(&enclosure, report);
    outside::describe(&enclosure, report);
    let path = args.output.display().to_string();
    report.fact("output", path, "wrote", written);
    Ok(())
}

/// Refuses a matrix that no scene has, and one that could not be closed as asked.
fn refuse_impossible(args: &FormFactorArgs, enclosure: &Enclosure) -> Result<(), Failure> {
    let factors = &enclosure.factors;
    if let Some((row, sum)) = factors.impossible_row() {
        return Err(Failure::failed(format_args!(
            "row \"{}\" adds up to {sum:.4}, more than all of its light, and nothing is written: faces that coincide \
             or overlap count several times; remove duplicates",
            enclosure.rows.names[row]
        )));
    }
    let notes = &factors.engine_used.notes;
    if args.computation.closure == Some(ClosureName::Always)
        && notes.iter().any(|note| note == NOT_RECONCILED)
    {
        return Err(Failure::failed(format_args!("--closure: {NOT_RECONCILED}")));
    }
    Ok(())
}

/// Refuses to share the work of what is computed already.
fn refuse_computed(args: &FormFactorArgs, by: &str) -> Result<(), Failure> {
    let mut scenes = args.input.scenes.iter();
    if scenes.any(|path| stored::is_archive(path)) {
        return Err(Failure::misuse(format_args!(
            "{by}: the factors of an .npz are computed, there is nothing to divide"
        )));
    }
    Ok(())
}

/// The View3D file, or the scene of other models.
fn read_scene(
    args: &FormFactorArgs,
    session: &mut Session,
) -> Result<(Option<View3dInput>, Scene), Failure> {
    match view3d::read(args, session)? {
        Some(room) => Ok((Some(room), Scene::default())),
        None => Ok((
            None,
            painted(args, read_models(&args.input, args.clock, session)?)?,
        )),
    }
}

/// How a matrix is computed.
#[derive(Clone, Copy)]
pub struct FactorRequest<'a> {
    /// The options.
    pub computation: &'a ComputationArgs,
    /// The patches of the sky that are wanted beside the matrix.
    pub sky: Option<AskedSky>,
    /// Whether orders of mirrors are kept apart.
    pub separate: bool,
    /// The groups of rows that alone are wanted.
    pub groups: Option<GroupBy>,
    /// The View3D file whose rows are wanted.
    pub room: Option<&'a View3dInput>,
}

/// What a plan refers to.
struct FactorSetup {
    engine: PreparedEngine,
    tracer: Tracer,
    options: FormFactorOptions,
}

impl FactorSetup {
    fn new(scene: &Scene, how: FactorRequest, session: &Session) -> Result<FactorSetup, Failure> {
        refuse_contradiction(how.computation)?;
        let engine = how.computation.engine.prepare()?;
        let tracer = repeated(engine.tracer(scene)?, how.computation)?;
        let mut options = options(how, &engine, session);
        if let Some(room) = how.room {
            options = room.options(options, how.computation);
        }
        Ok(FactorSetup {
            engine,
            tracer,
            options,
        })
    }

    /// Divides the scene, and says what is wrong with it.
    fn plan<'a>(
        &'a self,
        scene: &'a Scene,
        how: FactorRequest,
        session: &mut Session,
    ) -> Result<Plan<'a>, Failure> {
        let plan = Plan::new(scene, &self.tracer, &self.options).map_err(pass::failure)?;
        if how.room.is_none() {
            plan.flaws().iter().for_each(|flaw| session.note(flaw));
        }
        Ok(plan)
    }

    /// What all blocks depend on.
    fn work_key(&self, scene: &Scene, plan: &PreparedPlan) -> WorkKey {
        WorkKey {
            scene: ContentHasher::new().add(scene).key(),
            settings: key(&Scene::default(), &self.tracer, &self.options),
            engine: engine::word(plan.engine()).to_owned(),
        }
    }
}

/// The factors between patches of a scene, with what they receive from outside; `None` if another process makes the
/// result. Finished blocks are kept next to a file until the matrix is written to it.
///
/// # Errors
/// The options contradict each other or the scene; those of the work, and of [`Runner::compute`].
pub fn enclosure(
    scene: &Scene,
    how: FactorRequest,
    (runner, output): (Runner, Option<&Path>),
    session: &mut Session,
    report: &mut Report,
) -> Result<Option<Completed<Enclosure>>, Failure> {
    let setup = FactorSetup::new(scene, how, session)?;
    let plan = setup.plan(scene, how, session)?;
    let prepared = plan.prepare();
    if runner.writes() {
        forecast(&prepared, session, report)?;
    }
    let work = DividedWork {
        key: &|| setup.work_key(scene, &prepared),
        sharing: Sharing::Root,
        output,
    };
    let computed = runner.compute(&work, session, report, |blocks, session| {
        let factors = session.with_progress(|p| prepared.compute(Run::new(blocks, p)));
        pass::unless_elsewhere(factors)
    })?;
    let Some(Completed {
        value: factors,
        rest,
    }) = computed
    else {
        return Ok(None);
    };
    let mut value = Enclosure::new(&prepared, scene, factors);
    if !setup.options.two_sided && how.room.is_none() {
        facing::advise(scene, &setup.tracer, &value, session)?;
    }
    setup.engine.describe(&value.factors.engine_used, report);
    let used = &value.factors.engine_used.name;
    if how.computation.tolerance.is_some() && used != "analytic" {
        session.note(&format!(
            "--tolerance has no effect: it is for the analytic engine, and the factors are by {used}"
        ));
    }
    match how.room {
        Some(room) => value = room.finish(&value, session, report)?,
        None => {
            value.sky = outside::sky(&prepared, &value.factors, how.sky, session)?;
            value.outside = outside::irradiance(&prepared, scene, &value.factors, session)?;
        }
    }
    Ok(Some(Completed { value, rest }))
}

/// A tracer of the model with the copies of it that were asked for.
fn repeated(tracer: Tracer, args: &ComputationArgs) -> Result<Tracer, Failure> {
    let Some(periods) = args.periodic else {
        return Ok(tracer);
    };
    let repeated = periods.repeated(tracer);
    repeated.map_err(|e| Failure::failed(format_args!("--periodic: {e}")))
}

/// The analytic engine without formulas would be nothing, and particles have no form factors.
fn refuse_contradiction(args: &ComputationArgs) -> Result<(), Failure> {
    let is_analytic = args.engine.engine == EngineName::Analytic;
    if args.engine.engine == EngineName::Particles {
        let message =
            "particles have no form factors: --engine particles is for solve, render and probe";
        return Err(Failure::misuse(message));
    }
    if is_analytic && args.formulas == FormulasName::Never {
        return Err(Failure::misuse(format_args!(
            "--formulas=never does not apply to --engine analytic, which is formulas alone"
        )));
    }
    Ok(())
}

/// Reads models whose rows are patches or groups of them.
pub fn read_models(
    input: &InputArgs,
    clock: ClockArgs,
    session: &mut Session,
) -> Result<Scene, Failure> {
    let scene = input::read_all(input, clock, session)?;
    if session.formats().contains(&Format::View3d) {
        session.note(
            "rows are patches: View3D's own rows, with its masks, combinations and enclosures, \
             require a single View3D file, given by name, neither placed nor divided",
        );
    }
    Ok(scene)
}

/// The scene with the reflectances of the table of materials, if there is one.
fn painted(args: &FormFactorArgs, mut scene: Scene) -> Result<Scene, Failure> {
    let Some(path) = &args.materials else {
        return Ok(scene);
    };
    let failed = |e: TableError| Failure::failed(format_args!("{}: {e}", path.display()));
    let text = String::from_utf8_lossy(&models::read_bytes(path)?).into_owned();
    let table = MaterialTable::read(&text).map_err(failed)?;
    if !table.has_same_mirrors() {
        return Err(Failure::failed(format_args!(
            "{}: mirror reflectances differ from band to band; compute one matrix for each set of them, from a \
             table with that set alone, and give all of them to exchange",
            path.display()
        )));
    }
    table.paint(&mut scene, 0).map_err(failed)?;
    Ok(scene)
}

fn options(how: FactorRequest, prepared: &PreparedEngine, session: &Session) -> FormFactorOptions {
    let args = how.computation;
    let default = FormFactorOptions::default();
    let machine = || session.memory().unwrap_or(u64::MAX);
    let has_formulas = args.formulas == FormulasName::Auto;
    let engine = match (&prepared.engine, args.rays) {
        (Engine::Auto, Some(_)) => Engine::Rays,
        (Engine::Auto, None) if !has_formulas => Engine::Rays,
        (engine, _) => engine.clone(),
    };
    let is_planned = args.is_planned() && how.room.is_none();
    let groups = how.groups.filter(|_| is_planned);
    let engine = match (groups, args.engine.resolution) {
        (Some(_), None) => engine.with_resolution(Hemicube::GROUP_RESOLUTION),
        _ => engine,
    };
    FormFactorOptions {
        engine,
        groups,
        size: pass::patch_size(&args.division).unwrap_or(default.size),
        rays: args.rays.unwrap_or(default.rays),
        two_sided: args.two_sided,
        seed: args.seed,
        accuracy: args.tolerance,
        separate: how.separate,
        closure: args.closure(),
        analytic: has_formulas,
        memory: args.memory.unwrap_or_else(machine),
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
        seconds,
    } = forecast;
    let time = seconds.map_or(String::new(), |s| format!(", about {s:.2} s of CPU time"));
    session.say(&format!(
        "forecast  {} rows, up to {} pairs, {} of memory{time}",
        count(rows),
        count(pairs),
        bytes(needed)
    ));
    report.value("forecast_pairs", pairs);
    report.value("forecast_bytes", needed);
    if let Some(seconds) = seconds {
        report.value("forecast_seconds", seconds);
    }
    Ok(())
}

/// A hash of everything that the rows depend on.
fn key(scene: &Scene, tracer: &Tracer, options: &FormFactorOptions) -> ContentKey {
    let FormFactorOptions {
        engine,
        groups,
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
        .add(&tracer.kernel_name())
        .add(&tracer.period());
    engine::add_to_key(engine, &mut hasher);
    match *size {
        PatchSize::Count(patches) => hasher.add(&0u8).add(&patches),
        PatchSize::Squares(patches) => hasher.add(&1u8).add(&patches),
        PatchSize::Edge(length) => hasher.add(&2u8).add(&length),
        PatchSize::FlatWhole(patches) => hasher.add(&3u8).add(&patches),
    };
    let groups = groups.map_or(0u8, |by| match by {
        GroupBy::Face => 1,
        GroupBy::Object => 2,
        GroupBy::Material => 3,
    });
    hasher
        .add(&groups)
        .add(rays)
        .add(two_sided)
        .add(seed)
        .add(analytic)
        .add(separate)
        .add(accuracy)
        .add(scene)
        .key()
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
                groups: Some(GroupBy::Face),
                ..default()
            },
            FormFactorOptions {
                groups: Some(GroupBy::Object),
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
