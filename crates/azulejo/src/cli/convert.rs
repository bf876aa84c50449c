//! `convert`: models in, one model out.

use super::args::ConvertArgs;
use super::failure::Failure;
use super::input;
use super::output::{self, Output};
use super::report::{Report, count};
use super::session::Session;
use azulejo_formats::{grf, obj};
use azulejo_scene::Scene;
use azulejo_trace::Progress;
use std::path::Path;

/// Where a scene goes, and how it is written.
#[derive(Debug)]
pub enum SceneOutput {
    /// One file.
    Grf(Output),
    /// The model and its materials.
    Obj {
        /// The `.obj`.
        model: Output,
        /// The `.mtl` beside it.
        materials: Output,
    },
}

impl SceneOutput {
    /// Chooses the format by extension and checks that the place can be written.
    pub fn check(path: &Path) -> Result<SceneOutput, Failure> {
        let extension = path.extension().and_then(|e| e.to_str());
        match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("grf") => Ok(SceneOutput::Grf(Output::check(path)?)),
            None if path == Path::new("-") => Ok(SceneOutput::Grf(Output::check(path)?)),
            Some("obj") => Ok(SceneOutput::Obj {
                model: Output::check(path)?,
                materials: Output::check(&path.with_extension("mtl"))?,
            }),
            _ => Err(Failure::misuse(format_args!(
                "{}: unknown kind of model file, expected .grf or .obj",
                path.display()
            ))),
        }
    }

    /// Whether the scene goes to standard output.
    pub fn is_stdout(&self) -> bool {
        matches!(self, SceneOutput::Grf(output) if output.is_stdout())
    }

    /// Writes the scene whole or not at all.
    pub fn write(&self, scene: &Scene, progress: &Progress) -> Result<(), Failure> {
        match self {
            SceneOutput::Grf(output) => output.write(progress, |out| grf::write(scene, out)),
            SceneOutput::Obj { model, materials } => {
                let name = materials.path().file_name().unwrap_or_default();
                let (mut obj, mut mtl) = (model.draft()?, materials.draft()?);
                obj::write(scene, &name.to_string_lossy(), &mut obj, &mut mtl)
                    .map_err(|e| obj.failure(&e))?;
                output::commit(vec![mtl, obj], progress)
            }
        }
    }
}

/// Runs `convert`.
pub fn run(args: &ConvertArgs, session: &mut Session) -> Result<Report, Failure> {
    let output = SceneOutput::check(&args.output)?;
    session.claim_stdout(output.is_stdout())?;
    let scene = input::read_all(&args.input, session)?;
    if let SceneOutput::Obj { .. } = output {
        let losses = obj::losses(&scene);
        if !losses.is_empty() {
            session.note(&format!("OBJ does not keep all: {}", losses.join(", ")));
        }
    }
    output.write(&scene, session.progress())?;
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
