//! SFF, the scenes of the ray tracer RTRACE, and their text blocks.
//!
//! What is read: all of the format, with shapes kept exact. What only RTRACE's own shading
//! understands stays beside the physical scene, in
//! [`Scene::rtrace`](azulejo_scene::Scene::rtrace). `docs/formats/sff.md` says how every record is
//! understood.

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
use document::{Document, Sources};
use lines::Lines;

pub use write::{losses, write};

/// Reads a scene; `name` stands in messages, `files` gives fonts, encodings, data, colour maps and
/// pictures.
///
/// # Errors
/// Records that are not as the format has them, objects that cannot be, and files of data, fonts
/// and encodings that cannot be read.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    read_by(bytes, name, files, options, |text, sources, warnings| {
        let file = sources.add(name, text);
        Document::parse(&mut Lines::new(text, name, file, warnings))
    })
}

/// Reads a scene whose text `parse` turns into records; the text is its first source.
pub(crate) fn read_by(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
    parse: impl for<'t> FnOnce(&'t [u8], &mut Sources<'t>, &mut Warnings) -> Result<Document, ReadError>,
) -> Result<Loaded, ReadError> {
    check_length(bytes, name)?;
    let bytes = decoded(bytes);
    let mut warnings = Warnings::default();
    let mut sources = Sources::default();
    let document = parse(&bytes, &mut sources, &mut warnings)?;
    let scene = resolve::resolve(&document, &mut sources, files, options, &mut warnings)?;
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}
