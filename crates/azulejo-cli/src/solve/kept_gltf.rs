//! `solve --keep-mesh` of a glTF file: the light goes onto the vertices of the file itself.

use super::args::SolveArgs;
use crate::bake::read_file;
use crate::draft_list::DraftList;
use crate::failure::Failure;
use crate::first_pass::SidesArg;
use crate::report::Report;
use crate::session::Session;
use azulejo::lightmap::SourceFile;
use azulejo::models::unbaked;
use azulejo::output::Output;
use azulejo_formats::Format;
use azulejo_formats::gltf::patch::{self, Container};
use azulejo_formats::gltf::{self, ObjectOrigin};
use azulejo_scene::{Irradiance, Object, ObjectIrradiance, Scene};
use std::path::Path;

/// The glTF file that light is put into.
pub struct KeptGltf {
    file: SourceFile,
    origins: Vec<ObjectOrigin>,
    output: Output,
    container: Container,
}

impl KeptGltf {
    /// The file of a command that keeps its mesh, and writes glTF from glTF; `None` for others, and for
    /// those that change more than light, which is said.
    ///
    /// # Errors
    /// The file can no longer be read.
    pub fn of(
        args: &SolveArgs,
        scene: &Scene,
        session: &mut Session,
    ) -> Result<Option<KeptGltf>, Failure> {
        let Some((path, container)) = output_of(args) else {
            return Ok(None);
        };
        if session.formats() != [Format::Gltf] {
            return Ok(None);
        }
        if let Some(option) = changed(args) {
            session.note(&format!(
                "{option} changes more than light: the file is rewritten"
            ));
            return Ok(None);
        }
        let mut file = read_file(&args.input.reading, &args.input.scenes[0])?;
        // As the scene was read: without the light of azulejo's.
        file.bytes = unbaked(file.bytes, &file.name).0;
        let read = gltf::read_with_origins(&file.bytes, &file.name, &file.files, &file.options);
        let (_, origins) = read.map_err(Failure::failed)?;
        if !is_same(scene, &origins) {
            session
                .note("the faces of the scene are not those of the file, so the file is rewritten");
            return Ok(None);
        }
        Ok(Some(KeptGltf {
            file,
            origins,
            output: Output::check(path)?,
            container,
        }))
    }

    /// Whether the light fits the faces as they are: one value for each vertex, that of the fronts.
    pub fn fits(light: &Irradiance) -> bool {
        let is_front = |object: &ObjectIrradiance| match object {
            ObjectIrradiance::Vertices { back, turned, .. } => back.is_none() && turned.is_empty(),
            ObjectIrradiance::Refined(_) | ObjectIrradiance::Surface(_) => false,
        };
        light.objects.iter().all(is_front)
    }

    /// Writes the file with the light of the solved scene.
    ///
    /// # Errors
    /// It does not fit, or cannot be written.
    pub fn write(
        &self,
        scene: &Scene,
        session: &mut Session,
        report: &mut Report,
    ) -> Result<(), Failure> {
        let stem = self.output.path().file_stem().unwrap_or_default();
        let output = patch::Output {
            container: self.container,
            stem: &stem.to_string_lossy(),
        };
        let file = self.file.patched();
        let patched = patch::with_vertex_light(&file, &self.origins, scene, output);
        let patched = patched.map_err(Failure::failed)?;
        patched.notes.iter().for_each(|note| session.note(note));
        let mut drafts = DraftList::default();
        for (name, file) in &patched.files {
            drafts.add(&self.output.path().with_file_name(name), file)?;
        }
        drafts.add_to(&self.output, &patched.bytes)?;
        let written = drafts.commit(session)?;
        let path = self.output.path().display().to_string();
        report.fact("output", path, "wrote", written.join(", "));
        Ok(())
    }
}

/// The output of a command whose mesh is kept, if it is glTF.
fn output_of(args: &SolveArgs) -> Option<(&Path, Container)> {
    let path = args
        .output
        .as_deref()
        .filter(|_| args.first_pass.keep_mesh)?;
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    match extension.as_str() {
        _ if args.in_place || args.input.scenes[..] == [Path::new("-")] => None,
        "glb" => Some((path, Container::Glb)),
        "gltf" => Some((path, Container::Json)),
        _ => None,
    }
}

/// An option by which more than light changes.
fn changed(args: &SolveArgs) -> Option<&'static str> {
    let (input, reading) = (&args.input, &args.input.reading);
    let is_split = args.first_pass.sides == Some(SidesArg::Split);
    let options = [
        (reading.placements().next().is_some(), "--place"),
        (input.outside.studio, "--studio"),
        (reading.up.is_some(), "--up"),
        (reading.unit.is_some(), "--unit"),
        (!reading.recipe.is_empty(), "--recipe"),
        (is_split, "--sides split"),
    ];
    options
        .into_iter()
        .find_map(|(is_given, option)| is_given.then_some(option))
}

/// Whether the objects of a scene have the faces that were read.
fn is_same(scene: &Scene, origins: &[ObjectOrigin]) -> bool {
    let has_faces = |(object, origin): (&Object, &ObjectOrigin)| {
        let mesh = object.shape.mesh();
        mesh.is_some_and(|mesh| mesh.faces.len() == origin.faces.len())
    };
    scene.objects.len() == origins.len() && scene.objects.iter().zip(origins).all(has_faces)
}
