//! Materials and Geometry Format (MGF), version 2.
//!
//! What is read: all entities of the format, arrays, includes and luminaires of IES LM-63.
//! `docs/formats/mgf.md` says how every one is understood.

mod build;
mod color;
mod context;
mod holes;
mod ies;
mod lines;
mod luminaire;
mod material;
mod reader;
mod solids;
mod surfaces;
#[cfg(test)]
mod tests;
mod transform;

use crate::reading::text::decoded;
use crate::{Files, Loaded, ReadError, ReadOptions};
pub(crate) use color::rgb_weights;
use reader::Reader;

/// Reads a scene; `name` stands in messages, `files` gives what the file includes.
///
/// # Errors
/// Arrays and includes that unfold to more than `options` allow. Whatever else is wrong is skipped
/// with a warning.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let bytes = &*decoded(bytes);
    let mut reader = Reader::new(files, options);
    reader.run(bytes, name).map_err(|e| e.error(name))?;
    Ok(reader.finish(name))
}
