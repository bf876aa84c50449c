//! Scenes to files: the format by the extension, whole or not at all.

use super::failure::Failure;
use super::output::{self, Output};
use super::session::Session;
use azulejo_formats::{gltf, grf, obj, ply};
use azulejo_scene::Scene;
use std::io::{self, Write};
use std::path::Path;

/// Where a scene goes, and how it is written.
#[derive(Debug)]
pub struct SceneOutput {
    format: &'static WrittenFormat,
    model: Output,
    /// The `.mtl` beside an `.obj`.
    materials: Option<Output>,
}

/// A format that scenes are written in.
#[derive(Debug)]
struct WrittenFormat {
    name: &'static str,
    extension: &'static str,
    write: Writer,
    /// Whether it holds the irradiance on the vertices.
    keeps_light: bool,
    /// What of a scene the format has no words for.
    losses: fn(&Scene) -> Vec<String>,
}

#[derive(Debug)]
enum Writer {
    /// One file.
    One(fn(&Scene, &mut dyn Write) -> io::Result<()>),
    /// OBJ, with its materials in a second file.
    ObjAndMtl,
}

/// All of them; the first is what goes to standard output.
static FORMATS: [WrittenFormat; 5] = [
    WrittenFormat {
        name: "GRF",
        extension: "grf",
        write: Writer::One(grf::write),
        keeps_light: true,
        losses: |_| Vec::new(),
    },
    WrittenFormat {
        name: "OBJ",
        extension: "obj",
        write: Writer::ObjAndMtl,
        keeps_light: false,
        losses: obj::losses,
    },
    WrittenFormat {
        name: "glTF",
        extension: "glb",
        write: Writer::One(gltf::write),
        keeps_light: true,
        losses: gltf::losses,
    },
    WrittenFormat {
        name: "glTF",
        extension: "gltf",
        write: Writer::One(gltf::write_json),
        keeps_light: true,
        losses: gltf::losses,
    },
    WrittenFormat {
        name: "PLY",
        extension: "ply",
        write: Writer::One(ply::write),
        keeps_light: true,
        losses: ply::losses,
    },
];

/// The extensions of some formats, for a message.
fn extensions(which: fn(&WrittenFormat) -> bool) -> String {
    let some = FORMATS.iter().filter(|f| which(f));
    let names: Vec<String> = some.map(|f| format!(".{}", f.extension)).collect();
    names.join(", ")
}

impl SceneOutput {
    /// Chooses the format by extension and checks that the place can be written.
    pub fn check(path: &Path) -> Result<SceneOutput, Failure> {
        let extension = path.extension().and_then(|e| e.to_str());
        let extension = match extension {
            None if path == Path::new("-") => Some(FORMATS[0].extension.to_owned()),
            other => other.map(str::to_ascii_lowercase),
        };
        let format = FORMATS
            .iter()
            .find(|f| Some(f.extension) == extension.as_deref())
            .ok_or_else(|| {
                Failure::misuse(format_args!(
                    "{}: unknown kind of model file, expected {}",
                    path.display(),
                    extensions(|_| true)
                ))
            })?;
        let materials = match format.write {
            Writer::One(_) => None,
            Writer::ObjAndMtl => Some(Output::check(&path.with_extension("mtl"))?),
        };
        Ok(SceneOutput {
            format,
            model: Output::check(path)?,
            materials,
        })
    }

    /// As [`check`](SceneOutput::check), but only formats that hold the light.
    pub fn check_lit(path: &Path) -> Result<SceneOutput, Failure> {
        let output = SceneOutput::check(path)?;
        match output.format.keeps_light {
            true => Ok(output),
            false => Err(Failure::misuse(format_args!(
                "{}: {} has no place for the light, expected {}",
                path.display(),
                output.format.name,
                extensions(|f| f.keeps_light)
            ))),
        }
    }

    /// Whether the scene goes to standard output.
    pub fn is_stdout(&self) -> bool {
        self.model.is_stdout()
    }

    /// Writes the scene whole or not at all; says what of it the format does not keep.
    pub fn write(&self, scene: &Scene, session: &mut Session) -> Result<(), Failure> {
        let losses = (self.format.losses)(scene);
        if !losses.is_empty() {
            let (name, losses) = (self.format.name, losses.join(", "));
            session.note(&format!("{name} does not keep all: {losses}"));
        }
        let progress = session.progress();
        match (&self.format.write, &self.materials) {
            (Writer::One(write), _) => self.model.write(progress, |out| write(scene, out)),
            (Writer::ObjAndMtl, None) => unreachable!("an .obj has its .mtl"),
            (Writer::ObjAndMtl, Some(materials)) => {
                let name = materials.path().file_name().unwrap_or_default();
                let (mut obj, mut mtl) = (self.model.draft()?, materials.draft()?);
                obj::write(scene, &name.to_string_lossy(), &mut obj, &mut mtl)
                    .map_err(|e| obj.failure(&e))?;
                output::commit(vec![mtl, obj], progress)
            }
        }
    }
}
