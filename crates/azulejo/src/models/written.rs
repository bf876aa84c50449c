//! Writing of model files.

use super::pictures::Pictures;
use super::writable;
use super::written_formats::{
    ModelWriter, NamedFiles, PLAIN_GRF, WrittenFormat, by_extension, extensions, is_gzip,
};
use crate::output::{self, Draft, Output, OutputError};
use azulejo_formats::{divide_into_triangles, open_objects, tessellate};
use azulejo_scene::{Mesh, Object, Scene};
use azulejo_trace::Progress;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::borrow::Cow;
use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why a scene was not written.
#[derive(Debug)]
#[non_exhaustive]
pub enum WriteFailure {
    /// The path's extension is not that of a format.
    UnknownKind(PathBuf),
    /// The format cannot store irradiance, which is required.
    NoPlaceForLight {
        /// The path.
        path: PathBuf,
        /// The name of the format.
        format: &'static str,
    },
    /// Only GRF has a plain form.
    NotPlain(PathBuf),
    /// The format keeps exact shapes, so that there is no tolerance for polygons.
    NoPolygons {
        /// The path.
        path: PathBuf,
        /// The name of the format.
        format: &'static str,
    },
    /// The files could not be written, or the work was cancelled.
    Output(OutputError),
}

impl fmt::Display for WriteFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WriteFailure::UnknownKind(path) => {
                let (path, known) = (path.display(), extensions(|_| true));
                write!(f, "{path}: unknown model format, expected {known}")
            }
            WriteFailure::NoPlaceForLight { path, format } => {
                let (path, lit) = (path.display(), extensions(|f| f.keeps_light));
                write!(
                    f,
                    "{path}: {format} cannot store irradiance, expected {lit}"
                )
            }
            WriteFailure::NotPlain(path) => {
                let path = path.display();
                write!(
                    f,
                    "{path}: only GRF has a plain form, expected .grf or .grf.gz"
                )
            }
            WriteFailure::NoPolygons { path, format } => {
                let (path, others) = (path.display(), extensions(|f| !f.keeps_outlines()));
                write!(
                    f,
                    "{path}: {format} keeps exact shapes and needs no tolerance, expected {others}"
                )
            }
            WriteFailure::Output(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for WriteFailure {}

impl From<OutputError> for WriteFailure {
    fn from(error: OutputError) -> WriteFailure {
        WriteFailure::Output(error)
    }
}

/// Writes a scene atomically in the format of the path's extension; returns what the format cannot
/// represent, as text.
///
/// # Errors
/// [`WriteFailure`]; an existing file is then unchanged.
pub fn write(scene: &Scene, path: &Path, progress: &Progress) -> Result<Vec<String>, WriteFailure> {
    Ok(ModelOutput::check(path)?.write(scene, progress)?)
}

/// As [`write()`], for a copy that will be read with this [home](crate::models::Reading::home):
/// images that are found from there remain where they are, and all others are written next to the
/// copy, under names that start with its own.
///
/// # Errors
/// As [`write()`].
pub fn write_copy(
    scene: &Scene,
    path: &Path,
    home: Option<&Path>,
    progress: &Progress,
) -> Result<Vec<String>, WriteFailure> {
    Ok(ModelOutput::check(path)?.write_with_home(scene, home, progress)?)
}

/// The output file of a scene, checked before the work begins.
#[derive(Debug)]
pub struct ModelOutput {
    format: &'static WrittenFormat,
    model: Output,
    /// Whether polygons are divided into triangles; without it, where most readers want them.
    triangles: Option<bool>,
    /// The chord error of polygons for exact shapes, scene units; without it, a thousandth of their size.
    tolerance: Option<f64>,
}

impl ModelOutput {
    /// Chooses the format by extension and checks that the file can be written.
    ///
    /// # Errors
    /// [`WriteFailure`].
    pub fn check(path: &Path) -> Result<ModelOutput, WriteFailure> {
        let format =
            by_extension(path).ok_or_else(|| WriteFailure::UnknownKind(path.to_owned()))?;
        if let ModelWriter::Two(extension, _) = format.writer {
            // Before the work begins; what is beside the model is written with it.
            Output::check(&path.with_extension(extension))?;
        }
        Ok(ModelOutput {
            format,
            model: Output::check(path)?,
            triangles: None,
            tolerance: None,
        })
    }

    /// As [`check`](ModelOutput::check), for GRF without extensions.
    ///
    /// # Errors
    /// [`WriteFailure`].
    pub fn check_plain(path: &Path) -> Result<ModelOutput, WriteFailure> {
        let output = ModelOutput::check(path)?;
        if output.format.extension != PLAIN_GRF.extension {
            return Err(WriteFailure::NotPlain(path.to_owned()));
        }
        Ok(ModelOutput {
            format: &PLAIN_GRF,
            ..output
        })
    }

    /// As [`check`](ModelOutput::check), for formats that can store irradiance.
    ///
    /// # Errors
    /// [`WriteFailure`].
    pub fn check_lit(path: &Path) -> Result<ModelOutput, WriteFailure> {
        let output = ModelOutput::check(path)?;
        if output.format.keeps_light {
            Ok(output)
        } else {
            Err(WriteFailure::NoPlaceForLight {
                path: path.to_owned(),
                format: output.format.name,
            })
        }
    }

    /// The same with polygons divided into triangles, or not; PLY is divided by default.
    pub fn with_triangles(self, triangles: Option<bool>) -> ModelOutput {
        ModelOutput { triangles, ..self }
    }

    /// The same with polygons whose chords deviate from exact shapes by at most `tolerance` scene units, > 0.
    ///
    /// # Errors
    /// [`WriteFailure::NoPolygons`].
    pub fn with_tolerance(self, tolerance: Option<f64>) -> Result<ModelOutput, WriteFailure> {
        if tolerance.is_some() && self.format.keeps_outlines() {
            return Err(WriteFailure::NoPolygons {
                path: self.model.path().to_owned(),
                format: self.format.name,
            });
        }
        Ok(ModelOutput { tolerance, ..self })
    }

    /// Says which objects of a scene are not closed, if the format is for printers; `None` if all are.
    pub fn open_objects(&self, scene: &Scene) -> Option<String> {
        const NAMED: usize = 5;
        if !self.format.is_for_printers() {
            return None;
        }
        let open = open_objects(scene);
        let name = |(name, edges): &(&str, usize)| format!("\"{name}\" ({edges} open edges)");
        let names: Vec<String> = open.iter().take(NAMED).map(name).collect();
        let more = if open.len() > NAMED { ", ..." } else { "" };
        (!open.is_empty()).then(|| {
            format!(
                "{} of {} objects are not closed, so that slicers may refuse them: {}{more}",
                open.len(),
                scene.objects.len(),
                names.join(", ")
            )
        })
    }

    /// The chosen format.
    pub fn format(&self) -> &'static WrittenFormat {
        self.format
    }

    /// Whether the scene goes to standard output.
    pub fn is_stdout(&self) -> bool {
        self.model.is_stdout()
    }

    /// The path of the regular file, existing or not; nothing for standard output.
    pub fn file(&self) -> Option<&Path> {
        self.model.file()
    }

    /// Writes the scene atomically, with the files that belong to it; returns what the format cannot
    /// represent, as text.
    ///
    /// # Errors
    /// [`OutputError`]; existing files are then unchanged.
    pub fn write(&self, scene: &Scene, progress: &Progress) -> Result<Vec<String>, OutputError> {
        let own = self.model.path().parent();
        self.write_with_home(scene, own, progress)
    }

    /// Images that are found from `home` remain where they are.
    fn write_with_home(
        &self,
        scene: &Scene,
        home: Option<&Path>,
        progress: &Progress,
    ) -> Result<Vec<String>, OutputError> {
        if let Some(problem) = writable::problem(scene, self.format.is_single) {
            let error = io::Error::new(io::ErrorKind::InvalidData, problem);
            return Err(self.model.error(error));
        }
        let mut scene = Cow::Borrowed(scene);
        self.smooth(&mut scene);
        let mut losses = self.format.losses(&scene);
        let by_writer = self.format.is_for_printers();
        if let Some(tolerance) = self.tolerance.filter(|_| !by_writer) {
            tessellate(scene.to_mut(), tolerance);
        }
        self.divide(&mut scene);
        let scene = &*scene;
        let keeps = self.format.keeps_surface_pictures();
        let even = (!keeps).then(|| scene.with_even_emission()).flatten();
        let scene = even.as_ref().unwrap_or(scene);
        match &self.format.writer {
            ModelWriter::Pictured(write) if self.model.file().is_some() => {
                self.write_pictured(*write, scene, home, progress)?;
            }
            ModelWriter::Pictured(write) => {
                // There is no place beside a pipe.
                let names: Vec<String> = scene.textures.iter().map(|t| t.path.clone()).collect();
                let write = |out: &mut dyn Write| write(scene, &names, out);
                let packed = |out: &mut dyn Write| self.packed(out, write);
                self.model.write(progress, packed)?;
                let loaded = scene.textures.iter().filter(|t| t.image.is_some()).count();
                losses.extend((loaded > 0).then(|| format!("the pixels of {loaded} images")));
            }
            ModelWriter::One(write) => {
                let packed = |out: &mut dyn Write| self.packed(out, |out| write(scene, out));
                self.model.write(progress, packed)?;
            }
            ModelWriter::Solid(write) => {
                let tolerance = self.tolerance;
                let packed =
                    |out: &mut dyn Write| self.packed(out, |out| write(scene, tolerance, out));
                self.model.write(progress, packed)?;
            }
            ModelWriter::Several(write) => self.write_several(*write, scene, progress)?,
            ModelWriter::Two(extension, write) => {
                let companion = Output::check(&self.model.path().with_extension(extension))?;
                let name = companion.path().file_name().unwrap_or_default();
                let (mut first, mut second) = (self.model.draft()?, companion.draft()?);
                write(scene, &name.to_string_lossy(), &mut first, &mut second)
                    .map_err(|e| first.error(e))?;
                output::commit(vec![second, first], progress)?;
            }
        }
        Ok(losses)
    }

    /// Gives meshes with smoothing groups their normals, for formats that have normals, since few programs know groups.
    fn smooth(&self, scene: &mut Cow<'_, Scene>) {
        let is_grouped = |o: &Object| o.shape.mesh().is_some_and(Mesh::is_grouped);
        if self.format.has_normals() && scene.objects.iter().any(is_grouped) {
            scene.to_mut().for_each_mesh(Mesh::take_group_normals);
        }
    }

    /// Divides polygons into triangles, if that is wished.
    fn divide(&self, scene: &mut Cow<'_, Scene>) {
        let is_polygonal = |mesh: &Mesh| mesh.faces.corners.len() != 3 * mesh.faces.len();
        let has_polygons = |o: &Object| o.shape.mesh().is_none_or(is_polygonal);
        let is_wished = self.triangles.unwrap_or(self.format.extension == "ply");
        if is_wished && scene.objects.iter().any(has_polygons) {
            if self.format.has_exact_shapes() {
                scene.to_mut().divide_into_triangles();
            } else {
                divide_into_triangles(scene.to_mut());
            }
        }
    }

    /// Compresses what is written, if the path asks for it.
    fn packed(
        &self,
        out: &mut dyn Write,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        if !is_gzip(self.model.path()) {
            return write(out);
        }
        // Without name and time, so that equal models are equal files.
        let mut packer = GzEncoder::new(out, Compression::default());
        write(&mut packer)?;
        packer.finish()?.flush()
    }

    /// Writes a model and the images that it would not find from its folder.
    fn write_pictured(
        &self,
        write: fn(&Scene, &[String], &mut dyn Write) -> io::Result<()>,
        scene: &Scene,
        home: Option<&Path>,
        progress: &Progress,
    ) -> Result<(), OutputError> {
        let path = self.model.path();
        let mut model = self.model.draft()?;
        let pictures = Pictures::beside(path, home, scene).map_err(|e| model.error(e))?;
        self.packed(&mut model, |out| write(scene, &pictures.names, out))
            .map_err(|e| model.error(e))?;
        self.commit_with(model, pictures.new, progress)
    }

    /// Writes a model and the files that it refers to, all of them or none.
    fn write_several(
        &self,
        write: fn(&Scene, &str, &mut dyn Write) -> io::Result<NamedFiles>,
        scene: &Scene,
        progress: &Progress,
    ) -> Result<(), OutputError> {
        let path = self.model.path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let mut model = self.model.draft()?;
        let named = write(scene, &stem, &mut model).map_err(|e| model.error(e))?;
        self.commit_with(model, named, progress)
    }

    /// Moves a model and its files into place.
    fn commit_with(
        &self,
        model: Draft,
        named: NamedFiles,
        progress: &Progress,
    ) -> Result<(), OutputError> {
        let path = self.model.path();
        let mut drafts = Vec::new();
        for (name, bytes) in named {
            let mut draft = Output::check(&path.with_file_name(name))?.draft()?;
            draft.write_all(&bytes).map_err(|e| draft.error(e))?;
            drafts.push(draft);
        }
        drafts.push(model);
        output::commit(drafts, progress)
    }
}

#[cfg(test)]
mod tests {
    use super::super::written_formats::FORMATS;
    use super::*;
    use azulejo_scene::synthetic::cube_room;
    use std::fs;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("azulejo-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn check(name: &str, expected: Option<&str>) {
        let extension = by_extension(Path::new(name)).map(|f| f.extension);
        assert_eq!(extension, expected, "{name}");
    }

    #[test]
    fn extensions_choose_formats() {
        check("a.grf", Some("grf"));
        check("a.b.GLB", Some("glb"));
        check("-", Some("grf"));
        check("grf", None);
        check("a.3ds", None);
        check("a.grf.gz", Some("grf"));
        check("a.WRL.GZ", Some("wrl"));
        // A model of several files is not compressed.
        check("a.obj.gz", None);
        check("gz", None);
    }

    #[test]
    fn compressed_and_plain_models_read_again() {
        use crate::models::{Reading, read};
        let folder = folder("packed");
        let (room, progress) = (cube_room(), Progress::new());
        for format in FORMATS
            .iter()
            .filter(|f| matches!(f.extension, "grf" | "wrl" | "x3d"))
        {
            let path = folder.join(format!("room.{}.gz", format.extension));
            write(&room, &path, &progress).unwrap();
            let bytes = fs::read(&path).unwrap();
            assert!(bytes.starts_with(&[0x1f, 0x8b]), "{}", format.extension);
            write(&room, &path, &progress).unwrap();
            assert_eq!(fs::read(&path).unwrap(), bytes, "the same every time");
            let again = read(&path, &Reading::default(), &progress).unwrap();
            assert_eq!(again.scene.objects.len(), room.objects.len());
        }
        let path = folder.join("plain.grf");
        let plain = ModelOutput::check_plain(&path).unwrap();
        plain.write(&room, &progress).unwrap();
        assert!(!fs::read_to_string(&path).unwrap().contains("ext "));
        let message = ModelOutput::check_plain(&folder.join("a.glb")).unwrap_err();
        assert!(message.to_string().contains("expected .grf or .grf.gz"));
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn every_format_is_written_whole_or_not_at_all() {
        let folder = folder("formats");
        let (room, progress) = (cube_room(), Progress::new());
        for format in &FORMATS {
            let path = folder.join(format!("room.{}", format.extension));
            let losses = write(&room, &path, &progress).unwrap();
            assert_eq!(losses, format.losses(&room), "{}", format.name);
            let old = fs::read(&path).unwrap();
            assert!(!old.is_empty());
            let cancelled = Progress::new();
            cancelled.cancel();
            let result = write(&Scene::default(), &path, &cancelled);
            assert!(matches!(
                result,
                Err(WriteFailure::Output(OutputError::Cancelled))
            ));
            assert_eq!(fs::read(&path).unwrap(), old, "{}", format.name);
        }
        let drafts = fs::read_dir(&folder).unwrap();
        let is_draft = |e: &fs::DirEntry| e.file_name().to_string_lossy().ends_with(".tmp");
        assert_eq!(drafts.flatten().filter(is_draft).count(), 0);
        fs::remove_dir_all(folder).unwrap();
    }

    /// Nothing at all, in every format: what a reader makes of it is nothing again.
    #[test]
    fn an_empty_scene_reads_again() {
        use crate::models::{Reading, read};
        let folder = folder("empty");
        for format in &FORMATS {
            let path = folder.join(format!("empty.{}", format.extension));
            write(&Scene::default(), &path, &Progress::new()).unwrap();
            let again = read(&path, &Reading::default(), &Progress::new());
            let again = again.unwrap_or_else(|e| panic!("{}: {e}", format.extension));
            assert!(again.scene.objects.is_empty(), "{}", format.extension);
        }
        fs::remove_dir_all(folder).unwrap();
    }

    /// Light that is not finite, and light that only 64 bits can hold.
    #[test]
    fn what_no_reader_accepts_is_not_written() {
        use azulejo_scene::{Rgb, Shape};
        let folder = folder("overflow");
        let lit = |irradiance: f64| {
            let mut room = cube_room();
            if let Shape::Mesh(mesh) = &mut room.objects[0].shape {
                mesh.irradiance = vec![Rgb::grey(irradiance); mesh.positions.len()];
            }
            room
        };
        for format in &FORMATS {
            let path = folder.join(format!("room.{}", format.extension));
            let failure = |light: f64| write(&lit(light), &path, &Progress::new()).err();
            assert!(failure(1e30).is_none(), "{}", format.extension);
            let old = fs::read(&path).unwrap();
            for bad in [f64::INFINITY, f64::NAN] {
                let message = failure(bad).unwrap().to_string();
                assert!(
                    message.contains("finite"),
                    "{}: {message}",
                    format.extension
                );
            }
            assert_eq!(
                failure(1e300).is_some(),
                format.is_single,
                "{}",
                format.extension
            );
            if format.is_single {
                assert_eq!(fs::read(&path).unwrap(), old);
            }
        }
        let names = fs::read_dir(&folder).unwrap().flatten();
        let drafts = names.filter(|e| e.file_name().to_string_lossy().ends_with(".tmp"));
        assert_eq!(drafts.count(), 0);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_cannot_be_written_says_what_can() {
        let folder = folder("unwritten");
        let unknown = ModelOutput::check(&folder.join("a.3ds")).unwrap_err();
        let message = unknown.to_string();
        assert!(message.contains("expected .grf, .obj, .glb"), "{message}");
        let unlit = ModelOutput::check_lit(&folder.join("a.obj")).unwrap_err();
        let message = unlit.to_string();
        assert!(message.contains("OBJ cannot store irradiance"), "{message}");
        assert!(
            message.contains("expected .grf, .glb, .gltf, .ply"),
            "{message}"
        );
        fs::remove_dir_all(folder).unwrap();
    }
}
