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

use crate::reading::options::check_length;
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions};
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
    let bytes = decoded(bytes);
    let mut warnings = Warnings::default();
    let mut sources = SffSources::default();
    let document = parse(&bytes, &mut sources, &mut warnings)?;
    let scene = resolve::resolve(&document, &mut sources, files, options, &mut warnings)?;
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}
