//! Bulk data of NASTRAN and the programs that speak it, `.bdf`, `.nas`, `.dat`, `.fem`.
//!
//! Shells and the boundary of solids become objects by their property, with the names that HyperMesh, Patran,
//! ANSA and Femap write in comments; elements for radiation (`CHBDYG`, `CHBDYE`) become objects by cavity and
//! view. `docs/formats/nastran.md` has the details.

mod card;
mod cards;
mod coordinates;
mod deck;
mod elements;
mod fields;
mod names;
mod reader;
#[cfg(test)]
mod tests;
mod thermal;

use crate::{Files, Loaded, ReadError, ReadOptions};
use reader::BulkReader;

/// Reads a model. `name` is used in messages, `files` provides included files.
///
/// # Errors
/// Fields that are not the numbers they should be, files that include themselves, and coordinate systems
/// that do not exist or are defined by themselves.
pub fn read(
    bytes: &[u8],
    name: &str,
    files: &dyn Files,
    options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    BulkReader::new(files, options).read(bytes, name)
}
