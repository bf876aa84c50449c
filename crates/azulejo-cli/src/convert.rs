//! `convert`: reads models and writes them as one.

use super::args::ConvertArgs;
use super::failure::Failure;
use super::input;
use super::report::{Report, count};
use super::session::Session;
use azulejo::models::ModelOutput;
use azulejo_scene::Scene;

/// Runs `convert`.
pub fn run(args: &ConvertArgs, session: &mut Session) -> Result<Report, Failure> {
    let output = if args.plain {
        ModelOutput::check_plain(&args.output)?
    } else {
        ModelOutput::check(&args.output)?
    };
    let digits = checked_digits(args.digits, &output)?;
    session.claim_stdout(output.is_stdout())?;
    let mut scene = input::read_all(&args.input, session)?;
    if args.triangles {
        scene.divide_into_triangles();
    }
    round(&mut scene, digits);
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

/// The number of digits, if the format has digits.
pub fn checked_digits(digits: Option<u8>, output: &ModelOutput) -> Result<Option<u8>, Failure> {
    let format = output.format();
    if digits.is_some() && !format.is_text() {
        return Err(Failure::misuse(format_args!(
            "--digits applies to text formats; {} has numbers of fixed size",
            format.name
        )));
    }
    Ok(digits)
}

/// Gives the numbers of all meshes this many digits.
pub fn round(scene: &mut Scene, digits: Option<u8>) {
    if let Some(digits) = digits {
        scene.round_meshes(usize::from(digits));
    }
}
