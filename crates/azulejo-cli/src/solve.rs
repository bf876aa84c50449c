//! `solve`: the first pass, from scene to irradiance on its vertices.

use super::args::{FirstPassArgs, SidesArg, SolveArgs};
use super::engine::PreparedEngine;
use super::failure::Failure;
use super::in_place::InPlace;
use super::kept_gltf::KeptGltf;
use super::ranks::RankJournal;
use super::report::Report;
use super::session::Session;
use super::shards::{MergedParts, PartPlan, Shard};
use super::workers::Workers;
use super::{convert, input, pass};
use azulejo::models::ModelOutput;
use azulejo_radiosity::{LightSolution, SolveError};
use azulejo_scene::Scene;
use std::path::Path;

/// Digits of light in a file that people edit: far more than its error leaves.
const IN_PLACE_DIGITS: usize = 6;

/// Where the solved scene goes.
enum SolvedOutput {
    /// A model file of its own.
    Model(ModelOutput),
    /// The text of the file that was read.
    InPlace(Box<InPlace>),
}

impl SolvedOutput {
    fn check(args: &SolveArgs) -> Result<SolvedOutput, Failure> {
        match &args.output {
            _ if args.in_place => Ok(SolvedOutput::InPlace(Box::new(InPlace::open(args)?))),
            Some(path) => {
                let output = ModelOutput::check_lit(path)?;
                convert::checked_digits(args.digits, &output)?;
                Ok(SolvedOutput::Model(output))
            }
            None => Err(Failure::misuse(
                "-o OUT is missing, or --in-place to write into the file itself",
            )),
        }
    }

    /// The file that is written; nothing for standard output.
    fn file(&self) -> Option<&Path> {
        match self {
            SolvedOutput::Model(output) => output.file(),
            SolvedOutput::InPlace(text) => Some(text.target()).filter(|_| !text.is_stdout()),
        }
    }

    fn is_stdout(&self) -> bool {
        match self {
            SolvedOutput::Model(output) => output.is_stdout(),
            SolvedOutput::InPlace(text) => text.is_stdout(),
        }
    }
}

/// Runs `solve`.
pub fn run(args: &SolveArgs, session: &mut Session) -> Result<Report, Failure> {
    match (args.shard, session.ranks().cloned()) {
        (Some(shard), _) => part(args, shard, session),
        (None, Some(ranks)) if !ranks.is_root() => help(args, session),
        (None, _) => whole(args, None, session),
    }
}

/// Runs `solve` with vertices from parts.
pub fn run_merged(
    args: &SolveArgs,
    parts: &MergedParts,
    session: &mut Session,
) -> Result<Report, Failure> {
    whole(args, Some(parts), session)
}

/// The options of the first pass.
fn pass_args(args: &SolveArgs) -> FirstPassArgs {
    if args.in_place {
        InPlace::options(&args.first_pass)
    } else {
        args.first_pass.clone()
    }
}

/// Gathers the light at a part of the vertices.
fn part(args: &SolveArgs, shard: Shard, session: &mut Session) -> Result<Report, Failure> {
    pass::refuse_indivisible(&args.first_pass)?;
    let Some(output) = &args.output else {
        return Err(Failure::misuse("--shard: -o PART is missing"));
    };
    let planned = PartPlan::check(shard, output)?;
    let prepared = args.first_pass.engine.prepare()?;
    let scene = input::read_relit(&args.input, args.first_pass.instant(), session)?;
    let tracer = prepared.tracer(&scene)?;
    let options = pass::options(&pass_args(args), &prepared, session);
    let part = planned.open(&pass::work_key(&scene, &tracer, &options, &[]), session)?;
    let mut report = Report::default();
    part.fill(session, &mut report, |part, session| {
        let done = session.with_progress(|p| {
            azulejo_radiosity::solve_in_blocks(&scene, &tracer, &options, part, p)
        });
        match done {
            Ok(_) | Err(SolveError::Elsewhere) => Ok(()),
            Err(e) => Err(pass::failure(e)),
        }
    })?;
    Ok(report)
}

/// Takes part in the work of rank 0.
fn help(args: &SolveArgs, session: &mut Session) -> Result<Report, Failure> {
    let first_pass = pass_args(args);
    pass::refuse_time(&first_pass)?;
    let prepared = first_pass.engine.prepare()?;
    let scene = input::read_relit(&args.input, first_pass.instant(), session)?;
    let tracer = prepared.tracer(&scene)?;
    let options = pass::options(&first_pass, &prepared, session);
    let key = || pass::work_key(&scene, &tracer, &options, &[]);
    Workers::new(None, None, session).compute(key, session, |journal, session| {
        let how = (&options, journal);
        pass::solve_in_blocks(&scene, &tracer, &first_pass, how, session)
    })?;
    Ok(Report::default())
}

/// Solves the light, or makes it from parts, and writes the scene with it.
fn whole(
    args: &SolveArgs,
    parts: Option<&MergedParts>,
    session: &mut Session,
) -> Result<Report, Failure> {
    let output = SolvedOutput::check(args)?;
    session.claim_stdout(output.is_stdout())?;
    let prepared = args.first_pass.engine.prepare()?;
    let scene = input::read_relit(&args.input, args.first_pass.instant(), session)?;
    session.share_files()?;
    let kept = KeptGltf::of(args, &scene, session)?;
    let first_pass = pass_args(args);
    let tracer = prepared.tracer(&scene)?;
    let options = pass::options(&first_pass, &prepared, session);
    if session.ranks().is_some() {
        pass::refuse_time(&first_pass)?;
    }
    let workers = Workers::new(parts, output.file(), session);
    let key = || pass::work_key(&scene, &tracer, &options, &[]);
    let (light, journal) = workers.compute(key, session, |journal, session| {
        let how = (&options, journal);
        pass::solve_in_blocks(&scene, &tracer, &first_pass, how, session)
    })?;
    let report = write(args, (scene, light), (&output, kept), &prepared, session)?;
    journal.iter().for_each(RankJournal::remove);
    Ok(report)
}

/// Writes the scene with its light.
fn write(
    args: &SolveArgs,
    (mut scene, light): (Scene, LightSolution),
    (output, kept): (&SolvedOutput, Option<KeptGltf>),
    prepared: &PreparedEngine,
    session: &mut Session,
) -> Result<Report, Failure> {
    let first_pass = pass_args(args);
    let mut report = Report::default();
    pass::describe(&light.report, &first_pass, prepared, &scene, &mut report)?;
    let fits = KeptGltf::fits(&light.irradiance);
    if kept.is_some() && !fits {
        session.note(
            "some faces are turned to the side that is lit, so the file is written anew: --sides front \
             keeps it as it is",
        );
    }
    scene.set_irradiance(light.irradiance);
    if let Some(kept) = kept.filter(|_| fits) {
        kept.write(&scene, session, &mut report)?;
        return Ok(report);
    }
    let path: &Path = match output {
        SolvedOutput::Model(output) => {
            if first_pass.sides == Some(SidesArg::Split) {
                scene = scene.split_sides().into_owned();
            }
            convert::round(&mut scene, args.digits);
            session.write(&scene, output)?;
            args.output.as_deref().unwrap_or(Path::new("-"))
        }
        SolvedOutput::InPlace(text) => {
            scene.round_light(args.digits.map_or(IN_PLACE_DIGITS, usize::from));
            text.write(&scene, session)?;
            text.target()
        }
    };
    let path = path.display().to_string();
    report.fact("output", path.clone(), "wrote", path);
    Ok(report)
}
