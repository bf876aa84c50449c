//! Models as people type them.

use super::args::{DirectionAngles, ModelArgs};
use crate::failure::Failure;
use crate::session::Session;
use azulejo::models::read_bytes;
use azulejo_formats::Folder;
use azulejo_formats::brdf::LoadedBrdf;
use azulejo_scene::Brdf;
use azulejo_scene::brdf::{Description, Problem, find};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;

/// The model that is meant: by name, or from a file.
pub fn read(args: &ModelArgs, session: &mut Session) -> Result<Brdf, Failure> {
    let description = describe(&args.model, &args.parameters, session)?;
    Brdf::new(description).map_err(|problem| refuse(&args.model, problem))
}

/// As [`read`], of one text: `name key=value ...`.
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
            let message = format!("{name} is a file, which `{parameter}` cannot change");
            return Err(Failure::Misuse(message));
        }
        return read_file(Path::new(name), session);
    }
    let text = format!("{name} {}", parameters.join(" "));
    text.parse().map_err(|problem| refuse(name, problem))
}

/// A model that a file holds; says what is doubtful in it.
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

/// Names of models come first: a file of the same name is meant as `./ward`.
fn is_file(name: &str) -> bool {
    let is_model = name.eq_ignore_ascii_case("combination") || find(name).is_ok();
    !is_model && (name.contains(['/', '\\', '.']) || Path::new(name).exists())
}

/// A description that makes no model is a slip in what was typed.
fn refuse(name: &str, problem: Problem) -> Failure {
    match problem {
        Problem::UnknownModel { .. } => Failure::Misuse(format!(
            "{problem}, and no file is called so; `azulejo brdf list` lists the models"
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

/// A model in one line: its description, shortened where it is very long.
pub fn words(brdf: &Brdf) -> String {
    brdf.description().to_string()
}
