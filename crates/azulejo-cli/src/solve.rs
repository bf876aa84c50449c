//! `solve`: the first pass, from scene to irradiance on its vertices.

use super::args::{SidesArg, SolveArgs};
use super::failure::Failure;
use super::report::Report;
use super::session::Session;
use super::{input, pass};
use azulejo::models::ModelOutput;

/// Runs `solve`.
pub fn run(args: &SolveArgs, session: &mut Session) -> Result<Report, Failure> {
    let output = ModelOutput::check_lit(&args.output)?;
    session.claim_stdout(output.is_stdout())?;
    let prepared = args.first_pass.engine.prepare()?;
    let mut scene = input::read_all_at(&args.input, args.first_pass.instant(), session)?;
    let tracer = prepared.tracer(&scene)?;
    let light = pass::solve(&scene, &tracer, &args.first_pass, &prepared, session)?;
    let mut report = Report::default();
    pass::describe(
        &light.report,
        &args.first_pass,
        &prepared,
        &scene,
        &mut report,
    )?;
    scene.set_irradiance(light.irradiance);
    if args.first_pass.sides == Some(SidesArg::Split) {
        scene = scene.split_sides().into_owned();
    }
    session.write(&scene, &output)?;
    let path = args.output.display().to_string();
    report.fact("output", path.clone(), "wrote", path);
    Ok(report)
}
