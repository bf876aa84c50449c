//! Scenes to files: the format by the extension, whole or not at all.

use super::failure::Failure;
use super::output::{self, Output};
use super::session::Session;
use azulejo_formats::{gltf, grf, obj, ply, sff, view3d};
use azulejo_scene::Scene;
use azulejo_trace::Progress;
use std::io::{self, Write};
use std::path::Path;

/// Where a scene goes, and how it is written.
#[derive(Debug)]
pub struct SceneOutput {
    format: &'static WrittenFormat,
    model: Output,
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
    /// A file and one beside it, which has this extension and is named in the first.
    Two(
        &'static str,
        fn(&Scene, &str, &mut dyn Write, &mut dyn Write) -> io::Result<()>,
    ),
    /// A file and those that it turns out to name, which begin with its own name.
    Several(fn(&Scene, &str, &mut dyn Write) -> io::Result<NamedFiles>),
}

/// Files by name.
type NamedFiles = Vec<(String, Vec<u8>)>;

/// All of them; the first is what goes to standard output.
static FORMATS: [WrittenFormat; 7] = [
    WrittenFormat {
        name: "GRF",
        extension: "grf",
        write: Writer::One(grf::write),
        keeps_light: true,
        losses: grf::losses,
    },
    WrittenFormat {
        name: "OBJ",
        extension: "obj",
        write: Writer::Two("mtl", obj::write),
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
        write: Writer::Two("bin", gltf::write_json),
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
    WrittenFormat {
        name: "SFF",
        extension: "sff",
        write: Writer::Several(sff::write),
        keeps_light: false,
        losses: sff::losses,
    },
    WrittenFormat {
        name: "View3D",
        extension: "vs3",
        write: Writer::One(view3d::write),
        keeps_light: false,
        losses: view3d::losses,
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
        if let Writer::Two(extension, _) = format.write {
            // Before the work begins; what is beside the model is written with it.
            Output::check(&path.with_extension(extension))?;
        }
        Ok(SceneOutput {
            format,
            model: Output::check(path)?,
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
        match &self.format.write {
            Writer::One(write) => self.model.write(progress, |out| write(scene, out)),
            Writer::Several(write) => self.write_several(*write, scene, progress),
            Writer::Two(extension, write) => {
                let companion = Output::check(&self.model.path().with_extension(extension))?;
                let name = companion.path().file_name().unwrap_or_default();
                let (mut first, mut second) = (self.model.draft()?, companion.draft()?);
                write(scene, &name.to_string_lossy(), &mut first, &mut second)
                    .map_err(|e| first.failure(&e))?;
                output::commit(vec![second, first], progress)
            }
        }
    }

    /// Writes a model and the files that it names, all of them or none.
    fn write_several(
        &self,
        write: fn(&Scene, &str, &mut dyn Write) -> io::Result<NamedFiles>,
        scene: &Scene,
        progress: &Progress,
    ) -> Result<(), Failure> {
        let path = self.model.path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let mut model = self.model.draft()?;
        let named = write(scene, &stem, &mut model).map_err(|e| model.failure(&e))?;
        let mut drafts = Vec::new();
        for (name, bytes) in named {
            let mut draft = Output::check(&path.with_file_name(name))?.draft()?;
            draft.write_all(&bytes).map_err(|e| draft.failure(&e))?;
            drafts.push(draft);
        }
        drafts.push(model);
        output::commit(drafts, progress)
    }
}
