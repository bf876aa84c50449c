//! `solve`: the first pass, from scene to irradiance on its vertices.

use super::args::SolveArgs;
use super::failure::Failure;
use super::output::Output;
use super::report::Report;
use super::session::Session;
use super::{input, pass};
use azulejo_formats::grf;
use azulejo_trace::Tracer;

/// Runs `solve`.
pub fn run(args: &SolveArgs, session: &mut Session) -> Result<Report, Failure> {
    let is_grf = args
        .output
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("grf"));
    let output = Output::check(&args.output)?;
    if !is_grf && !output.is_stdout() {
        return Err(Failure::misuse(format_args!(
            "{}: only .grf can hold the light",
            args.output.display()
        )));
    }
    session.claim_stdout(output.is_stdout())?;
    let mut scene = input::read_all(&args.input, session)?;
    let tracer = Tracer::new(&scene);
    let light = pass::solve(&scene, &tracer, &args.first_pass, session)?;
    let mut report = Report::default();
    pass::describe(&light.report, &mut report);
    scene.set_irradiance(light.irradiance);
    output.write(session.progress(), |out| grf::write(&scene, out))?;
    let path = args.output.display().to_string();
    report.fact("output", path.clone(), "wrote", path);
    Ok(report)
}
