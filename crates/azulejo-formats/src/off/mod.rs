//! Object File Format of Geomview, `.off`, as text.
//!
//! Supported are polygons with colours, and vertices with normals, colours and texture coordinates.
//! `docs/formats/off.md` has the details.

mod finish;
mod parse;
#[cfg(test)]
mod tests;

use crate::reading::options::check_length;
use crate::reading::text::decoded;
use crate::reading::warnings::Warnings;
use crate::{Files, Loaded, ReadError, ReadOptions};
use parse::OffParser;

/// Reads a model. `name` is used in messages; OFF refers to no other files and has no options.
///
/// # Errors
/// Binary files, vertices of more than three dimensions, words that are not numbers, fewer vertices and
/// faces than the header states, and faces with vertices that do not exist.
pub fn read(
    bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    _options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    check_length(bytes, name)?;
    let bytes = &*decoded(bytes);
    let mut warnings = Warnings::default();
    let lists = OffParser::new(bytes, name).read()?;
    let scene = finish::scene(lists, name, &mut warnings);
    Ok(Loaded {
        scene,
        warnings: warnings.finish(name),
    })
}
