//! Models on the command line.

use super::args::{DirectionAngles, ModelArgs};
use crate::failure::Failure;
use crate::session::Session;
use azulejo::models::read_bytes;
use azulejo_formats::Folder;
use azulejo_formats::brdf::LoadedBrdf;
use azulejo_scene::Brdf;
use azulejo_scene::brdf::{BrdfError, Description, find};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;

/// Reads a model, by name or from a file.
pub fn read(args: &ModelArgs, session: &mut Session) -> Result<Brdf, Failure> {
    let description = describe(&args.model, &args.parameters, session)?;
    Brdf::new(description).map_err(|problem| refuse(&args.model, problem))
}

/// As [`read`], from a single text: `name key=value ...`.
pub fn read_text(text: &str, session: &mut Session) -> Result<Brdf, Failure> {
    let mut words = text.split_whitespace();
    let args = ModelArgs {
        model: words.next().unwrap_or_default().to_owned(),
        parameters: words.map(str::to_owned).collect(),
    };
    read(&args, session)
}

fn describe(
    name: &str,
    parameters: &[String],
    session: &mut Session,
) -> Result<Description, Failure> {
    if is_file(name) {
        if let Some(parameter) = parameters.first() {
            let message = format!("{name} is a file, for which `{parameter}` cannot be set");
            return Err(Failure::Misuse(message));
        }
        return read_file(Path::new(name), session);
    }
    let text = format!("{name} {}", parameters.join(" "));
    text.parse().map_err(|problem| refuse(name, problem))
}

/// Reads the model of a file, and reports warnings about it.
fn read_file(path: &Path, session: &mut Session) -> Result<Description, Failure> {
    let bytes = read_bytes(path)?;
    session.progress().advance(0)?;
    let name = path.to_string_lossy();
    let read = azulejo_formats::brdf::read(&bytes, &name, &Folder::of_model(path));
    let LoadedBrdf { content, warnings } = read.map_err(Failure::failed)?;
    warnings.iter().for_each(|w| session.warn(w));
    Ok(Description::File {
        path: name.into_owned(),
        content: Some(Arc::new(content)),
    })
}

/// Names of models take precedence: a file of the same name is given as `./ward`.
fn is_file(name: &str) -> bool {
    let is_model = name.eq_ignore_ascii_case("combination") || find(name).is_ok();
    !is_model && (name.contains(['/', '\\', '.']) || Path::new(name).exists())
}

/// The failure for an invalid description.
fn refuse(name: &str, problem: BrdfError) -> Failure {
    match problem {
        BrdfError::UnknownModel { .. } => Failure::Misuse(format!(
            "{problem}, and there is no file of that name; `azulejo brdf list` lists the models"
        )),
        _ if is_file(name) => Failure::Failed(format!("{name}: {problem}")),
        _ => Failure::misuse(problem),
    }
}

/// The unit vector of angles in degrees.
pub fn direction(DirectionAngles { theta, phi }: DirectionAngles) -> DVec3 {
    let ((st, ct), (sp, cp)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    DVec3::new(st * cp, st * sp, ct)
}

/// A model in one line: its description.
pub fn words(brdf: &Brdf) -> String {
    brdf.description().to_string()
}
