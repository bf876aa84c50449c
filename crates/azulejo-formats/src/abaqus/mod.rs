//! Input of Abaqus and CalculiX, `.inp`.
//!
//! Named surfaces become objects; without them shells and the boundary of solids do, by their sets.
//! `docs/formats/abaqus.md` has the details.

mod assembly;
mod data;
mod elements;
mod keyword;
mod keywords;
mod part;
mod reader;
mod scene;
#[cfg(test)]
mod tests;

use crate::{Files, Loaded, ReadError, ReadOptions};
use reader::AbaqusReader;

/// Reads a model. `name` is used in messages, `files` provides included files.
///
/// # Errors
/// Fields that are not the numbers they should be, files that include themselves, and instances or sets that
/// unfold to more than `options` allow.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    AbaqusReader::new(files, options).read(bytes, name)
}
