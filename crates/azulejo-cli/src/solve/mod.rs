//! `solve`: the first pass, from scene to irradiance on its vertices.

pub mod args;
mod in_place;
mod kept_gltf;

use crate::failure::Failure;
use crate::first_pass::SidesArg;
use crate::report::Report;
use crate::runner::{DividedWork, Runner, Sharing};
use crate::session::Session;
use crate::{convert, input, pass, runner};
use args::SolveArgs;
use azulejo::models::ModelOutput;
use azulejo_radiosity::LightSolution;
use azulejo_scene::Scene;
use in_place::InPlace;
use kept_gltf::KeptGltf;
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
                let output = output.with_triangles(args.triangles);
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

/// Solves the light, or a part of it, and writes the scene with it.
pub fn run(args: &SolveArgs, runner: Runner, session: &mut Session) -> Result<Report, Failure> {
    // Light that goes into the user's own text needs faces and vertices that stay as they are.
    let first_pass = if args.in_place {
        InPlace::options(&args.first_pass)
    } else {
        args.first_pass.clone()
    };
    // Refuse what cannot be divided or written before the work begins.
    runner::refuse_indivisible(&first_pass, &runner)?;
    let output = runner
        .writes()
        .then(|| SolvedOutput::check(args))
        .transpose()?;
    session.claim_stdout(output.as_ref().is_some_and(SolvedOutput::is_stdout))?;
    let prepared = first_pass.engine.prepare()?;
    let scene = input::read_relit(&args.input, first_pass.instant(), session)?;
    runner.share_files(session)?;
    // A glTF file that keeps its mesh is read again before the work, so that what prevents it is told early.
    let kept = match &output {
        Some(_) => KeptGltf::of(args, &scene, session)?,
        None => None,
    };
    let tracer = prepared.tracer(&scene)?;
    let options = pass::options(&first_pass, &prepared, session);
    // Solve in blocks, whose results all processes exchange, since each of them goes on with all.
    let plan = DividedWork {
        key: &|| pass::work_key(&scene, &tracer, &options, &[]),
        sharing: Sharing::All,
        output: output.as_ref().and_then(SolvedOutput::file),
    };
    let mut report = Report::default();
    let light = runner.compute(&plan, session, &mut report, |blocks, session| {
        let light = pass::with_forecast(&first_pass, (blocks, session), |run| {
            azulejo_radiosity::solve(&scene, &tracer, &options, run)
        });
        pass::unless_elsewhere(light)
    })?;
    // Only the process that makes the result describes and writes it.
    let (Some(light), Some(output)) = (light, &output) else {
        return Ok(report);
    };
    pass::describe(
        &light.value.report,
        &first_pass,
        &prepared,
        &scene,
        &mut report,
    )?;
    write(
        args,
        (scene, light.value),
        (output, kept),
        session,
        &mut report,
    )?;
    light.rest.finish(&mut report);
    Ok(report)
}

/// Writes the scene with its light.
fn write(
    args: &SolveArgs,
    (mut scene, light): (Scene, LightSolution),
    (output, kept): (&SolvedOutput, Option<KeptGltf>),
    session: &mut Session,
    report: &mut Report,
) -> Result<(), Failure> {
    let fits = KeptGltf::fits(&light.irradiance);
    if kept.is_some() && !fits {
        session.note(
            "some faces are turned to the side that is lit, so the file is written anew: --sides front \
             keeps it as it is",
        );
    }
    scene.set_irradiance(light.irradiance);
    if let Some(kept) = kept.filter(|_| fits) {
        return kept.write(&scene, session, report);
    }
    let path: &Path = match output {
        SolvedOutput::Model(output) => {
            if args.first_pass.sides == Some(SidesArg::Split) {
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
    Ok(())
}
