//! What is baked: a glTF file that stays as it is, or models that become one.

use super::args::{BakeArgs, DoubleSidedArg};
use crate::failure::Failure;
use crate::input::{self, ReadingArgs};
use crate::session::Session;
use azulejo::lightmap::SourceFile;
use azulejo::models::read_bytes;
use azulejo_formats::gltf;
use azulejo_formats::{Folder, Format};
use azulejo_trace::Progress;
use std::path::Path;

pub use azulejo::lightmap::BakeSource;

/// Reads the models of a command.
pub fn read(args: &BakeArgs, session: &mut Session) -> Result<BakeSource, Failure> {
    let scene = input::read_relit(&args.input, args.first_pass.instant(), session)?;
    let is_split = args.texels.double_sided == Some(DoubleSidedArg::Split);
    let is_gltf = session.formats().first() == Some(&Format::Gltf);
    if is_gltf && is_split {
        session.note(
            "--double-sided split: the file is rewritten, because backs become faces of their own",
        );
    } else if is_gltf && args.texels.split_contacts {
        session.note("--split-contacts: the file is rewritten, because faces are cut");
    } else if is_gltf {
        let path = &args.input.scenes[0];
        if path == Path::new("-") {
            return Err(Failure::misuse(
                "a glTF file that gets a lightmap cannot come from standard input: name the file",
            ));
        }
        let is_alone = args.input.scenes.len() == 1;
        let given = BakeSource::given(&scene, read_file(&args.input.reading, path)?, is_alone);
        if let Some(source) = given.map_err(Failure::failed)? {
            source.notes.iter().for_each(|note| session.note(note));
            return Ok(source);
        }
        session.note("several models with surfaces: they become a new glTF file");
    }
    BakeSource::written(&scene, !args.texels.no_split_contacts).map_err(Failure::failed)
}

/// Reads a glTF file as the command says.
pub fn read_file(reading: &ReadingArgs, path: &Path) -> Result<SourceFile, Failure> {
    let files = Folder::of_model(path);
    Ok(SourceFile {
        bytes: read_bytes(path)?,
        name: path.to_string_lossy().into_owned(),
        files: (reading.allow.iter()).fold(files, |files, more| files.allow(more)),
        options: reading.options(true),
    })
}

/// Removes the lightmap of a file.
pub fn stripped(path: &Path, progress: &Progress) -> Result<gltf::patch::StrippedFile, Failure> {
    progress.begin("reading", 0);
    let bytes = read_bytes(path)?;
    gltf::patch::strip(&bytes, &path.to_string_lossy()).map_err(Failure::failed)
}
