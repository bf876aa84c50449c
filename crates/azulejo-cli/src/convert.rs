//! `convert`: reads models and writes them as one.

use super::args::ConvertArgs;
use super::failure::Failure;
use super::input;
use super::report::{Report, count};
use super::session::Session;
use azulejo::models::ModelOutput;

/// Runs `convert`.
pub fn run(args: &ConvertArgs, session: &mut Session) -> Result<Report, Failure> {
    let output = ModelOutput::check(&args.output)?;
    session.claim_stdout(output.is_stdout())?;
    let scene = input::read_all(&args.input, session)?;
    session.write(&scene, &output)?;
    let mut report = Report::default();
    report.value("objects", scene.objects.len());
    report.value("materials", scene.materials.len());
    let path = args.output.display().to_string();
    let words = format!(
        "{path}: {} objects, {} materials",
        count(scene.objects.len()),
        count(scene.materials.len())
    );
    report.fact("output", path, "wrote", words);
    Ok(report)
}
