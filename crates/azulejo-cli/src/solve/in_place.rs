//! `solve --in-place`: the light goes into the text of the user's own file.

use super::args::SolveArgs;
use crate::failure::Failure;
use crate::first_pass::{FirstPassArgs, SidesArg};
use crate::input::InputArgs;
use crate::session::Session;
use azulejo::models::read_bytes;
use azulejo::output::Output;
use azulejo_formats::grf::{GrfText, LitText};
use azulejo_formats::{Folder, Format, recognize};
use azulejo_scene::Scene;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The first bytes of a compressed file.
const GZIP: &[u8] = &[0x1f, 0x8b];

/// The file into whose text light will be written, checked before the work begins.
pub struct InPlace {
    path: PathBuf,
    files: Folder,
    text: GrfText,
    output: Output,
    /// Whether the result replaces the file that was read.
    replaces: bool,
}

impl InPlace {
    /// Reads the file and checks that its text can take light.
    ///
    /// # Errors
    /// Misuse if there is not one GRF file, or if the options would change more than light.
    pub fn open(args: &SolveArgs) -> Result<InPlace, Failure> {
        let path = only_file(&args.input)?;
        if args.first_pass.sides == Some(SidesArg::Brighter) {
            return Err(Failure::misuse(
                "--in-place keeps all faces as they are, which --sides brighter would turn",
            ));
        }
        let bytes = read_bytes(path)?;
        let name = path.to_string_lossy();
        if !matches!(recognize(&bytes, &name), Ok(Format::Grf)) {
            return Err(Failure::misuse(format_args!(
                "--in-place: {name} is not a GRF file; convert it to one first"
            )));
        }
        if bytes.starts_with(GZIP) {
            return Err(Failure::misuse(format_args!(
                "--in-place: {name} is compressed; decompress it with gunzip first"
            )));
        }
        let allow = &args.input.reading.allow;
        let files = (allow.iter()).fold(Folder::of_model(path), |folder, more| folder.allow(more));
        let text = GrfText::parse(bytes, &name, &files).map_err(Failure::failed)?;
        let target = args.output.as_deref().unwrap_or(path);
        let output = Output::check(target)?;
        if text.names_files() && !is_beside(target, path) {
            return Err(Failure::misuse(format_args!(
                "{}: {name} names files relative to its folder, so its text has to stay there",
                target.display()
            )));
        }
        Ok(InPlace {
            path: path.to_owned(),
            replaces: output.file().is_some() && output.file() == Output::check(path)?.file(),
            files,
            text,
            output,
        })
    }

    /// Whether the result goes to standard output.
    pub fn is_stdout(&self) -> bool {
        self.output.is_stdout()
    }

    /// The path of the result.
    pub fn target(&self) -> &Path {
        self.output.path()
    }

    /// The options of a first pass that leaves faces and vertices as they are.
    pub fn options(args: &FirstPassArgs) -> FirstPassArgs {
        FirstPassArgs {
            keep_mesh: true,
            sides: args.sides.or(Some(SidesArg::Unturned)),
            ..args.clone()
        }
    }

    /// Writes the text with the light of the solved scene, and says what could not stay literal.
    pub fn write(&self, scene: &Scene, session: &mut Session) -> Result<(), Failure> {
        if let Err(invalid) = scene.validate() {
            return Err(Failure::failed(format_args!(
                "cannot write {}: the result is not a valid scene: {invalid}",
                self.target().display()
            )));
        }
        let name = self.path.display();
        let lit = self.text.lit(scene, &self.files);
        let lit = lit.map_err(|e| {
            Failure::failed(format_args!(
                "{name}: {e}. Nothing was written; -o OTHER.grf without --in-place writes the scene as a new file"
            ))
        })?;
        notes(&lit).iter().for_each(|note| session.note(note));
        if self.replaces && read_bytes(&self.path)? != self.text.bytes() {
            return Err(Failure::failed(format_args!(
                "{name} was changed while it was being solved, so nothing was written: solve it again"
            )));
        }
        let write = |out: &mut dyn Write| out.write_all(&lit.bytes);
        Ok(self.output.write(session.progress(), write)?)
    }
}

/// What could not stay literal, as text.
fn notes(lit: &LitText) -> Vec<String> {
    let mut notes = Vec::new();
    if !lit.unfolded.is_empty() {
        let names: Vec<&str> = lit.unfolded.iter().map(String::as_str).collect();
        notes.push(format!(
            "each use of an included part has light of its own, so these stand in the text now, in place \
             of their include: {}; the files themselves are unchanged",
            names.join(", ")
        ));
    }
    if lit.backs > 0 {
        notes.push(format!(
            "the light on the backs of {} object{} is in `ext irad_back`, which other programs skip; \
             without --in-place faces are turned to their light",
            lit.backs,
            if lit.backs == 1 { "" } else { "s" }
        ));
    }
    if lit.exact > 0 {
        notes.push(format!(
            "the light of {} exact shape{} is in `ext skin` and `ext surface_light`, which other \
             programs skip",
            lit.exact,
            if lit.exact == 1 { "" } else { "s" }
        ));
    }
    notes
}

/// The one model, if nothing moves it.
fn only_file(input: &InputArgs) -> Result<&Path, Failure> {
    let reading = &input.reading;
    let changed = [
        (reading.placements().next().is_some(), "--place"),
        (input.outside.studio, "--studio"),
        (reading.up.is_some(), "--up"),
        (reading.unit.is_some(), "--unit"),
        (!reading.recipe.is_empty(), "--recipe"),
    ];
    if let Some((_, option)) = changed.iter().find(|(given, _)| *given) {
        return Err(Failure::misuse(format_args!(
            "{option} would change more than light, which --in-place does not"
        )));
    }
    match &input.scenes[..] {
        [path] if path == Path::new("-") => Err(Failure::misuse(
            "--in-place needs a file: standard input has no place",
        )),
        [path] => Ok(path),
        _ => Err(Failure::misuse("--in-place needs one scene, not several")),
    }
}

/// Whether both paths are in one folder; standard output is wherever it is read.
fn is_beside(target: &Path, path: &Path) -> bool {
    let folder = |p: &Path| {
        let parent = p.parent().filter(|f| !f.as_os_str().is_empty());
        parent.unwrap_or(Path::new(".")).canonicalize().ok()
    };
    target == Path::new("-") || folder(target) == folder(path)
}
