//! SFF, the scene format of the ray tracer RTRACE, and its text blocks.
//!
//! The whole format is read, with exact shapes. Parameters that only RTRACE's own shading model
//! uses are kept beside the physical scene, in [`Scene::rtrace`](azulejo_scene::Scene::rtrace).
//! `docs/formats/sff.md` describes how every record is interpreted.

mod block;
mod coons;
mod data;
pub(crate) mod document;
mod from_scene;
mod lights;
mod lines;
mod parse;
mod pictures;
pub(crate) mod print;
mod record;
pub(crate) mod resolve;
mod shapes;
mod surfaces;
#[cfg(test)]
mod tests;
mod textures;
mod tree;
mod typeset;
mod write;

use crate::files::beside;
use crate::options::check_length;
use crate::text::without_utf16;
use crate::warnings::Warnings;
use crate::{FileError, Files, Loaded, ReadError, ReadOptions};
use document::{SffDocument, SffSources};
use lines::SffLines;

pub use write::{losses, write};

/// The result of reading a part of a file.
type SffResult<T> = Result<T, ReadError>;

/// Reads a scene; `name` is used in messages, `files` provides fonts, encodings, data, colour maps
/// and images.
///
/// # Errors
/// Malformed records, invalid objects, and files of data, fonts and encodings that cannot be read.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    read_by(bytes, name, files, options, |text, sources, warnings| {
        let file = sources.add(name, text);
        SffDocument::parse(&mut SffLines::new(text, name, file, warnings))
    })
}

/// Reads a scene whose text `parse` converts to records; the text is its first source.
pub(crate) fn read_by(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
    parse: impl for<'t> FnOnce(
        &'t [u8],
        &mut SffSources<'t>,
        &mut Warnings,
    ) -> Result<SffDocument, ReadError>,
) -> Result<Loaded, ReadError> {
    check_length(bytes, name)?;
    let bytes = without_utf16(bytes);
    let mut warnings = Warnings::default();
    let mut sources = SffSources::default();
    let document = parse(&bytes, &mut sources, &mut warnings)?;
    let scene = resolve::resolve(&document, &mut sources, files, options, &mut warnings)?;
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}

/// The bytes of a file that is named in the file `of`, and its name relative to the scene's folder:
/// looked up beside `of`, beside the scene, or there without the folders of its name.
pub(crate) fn open_beside(
    files: &dyn Files,
    of: &str,
    name: &str,
) -> Result<(String, Vec<u8>), FileError> {
    let wanted = beside(of, name);
    let plain = beside("", name);
    let base = plain.rsplit('/').next().unwrap_or_default().to_owned();
    let first = files.read(&wanted);
    if let Ok(bytes) = first {
        return Ok((wanted, bytes));
    }
    for other in [plain, base] {
        if other != wanted
            && let Ok(bytes) = files.read(&other)
        {
            return Ok((other, bytes));
        }
    }
    first.map(|bytes| (wanted, bytes))
}
