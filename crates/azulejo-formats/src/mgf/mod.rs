//! Materials and Geometry Format (MGF), version 2.
//!
//! All entities of the format are read, with arrays, includes and luminaires of IES LM-63.
//! `docs/formats/mgf.md` describes how each of them is interpreted.

mod build;
mod color;
mod context;
mod lines;
mod luminaire;
mod material;
mod reader;
mod sharing;
mod solids;
mod surfaces;
#[cfg(test)]
mod tests;
mod transform;

use crate::reading::text::decoded;
use crate::{Files, Loaded, ReadError, ReadOptions};
pub(crate) use color::rgb_weights;
use reader::MgfReader;

/// The colour of a black body at a temperature in kelvin, of luminance 1, desaturated where linear
/// BT.709 cannot show it; `None` if it is invisible. White is equal energy, as in MGF.
pub fn black_body_color(kelvin: f64) -> Option<azulejo_scene::Rgb> {
    color::Chroma::black_body(kelvin).map(|chroma| chroma.rgb(1.0))
}

/// Reads a scene; `name` is used in messages, `files` provides included files.
///
/// # Errors
/// Arrays and includes that unfold to more than `options` allow. Any other error is skipped with a
/// warning.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    let bytes = &*decoded(bytes);
    let mut reader = MgfReader::new(files, options);
    reader.run(bytes, name).map_err(|e| e.error(name))?;
    Ok(reader.finish(name))
}
