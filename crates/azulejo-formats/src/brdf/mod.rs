//! Files of reflection models: azulejo's text form ([`text`]), and measured data.
//!
//! [`read`] tells them apart by their content; names and their endings say nothing, because other
//! programs call quite different things `.brdf`.

pub(crate) mod inline;
mod measured;
pub mod merl;
pub mod rgl;
mod tensors;
pub mod text;

pub(crate) use measured::measured;

use crate::{Files, ReadError, Warning};
use azulejo_scene::brdf::Content;

/// A file that was read, and what was skipped or doubtful in it.
#[derive(Clone, Debug)]
pub struct LoadedBrdf {
    /// What it holds.
    pub content: Content,
    /// What was skipped, and what the model does that a model should not.
    pub warnings: Vec<Warning>,
}

/// Reads a file of a reflection model. `name` is what messages call it, and where it lies; the
/// files that it names come from `files`.
///
/// # Errors
/// No form that is known, or something that is wrong in it, with its place.
pub fn read(bytes: &[u8], name: &str, files: &dyn Files) -> Result<LoadedBrdf, ReadError> {
    match measured(bytes, name) {
        Some(read) => read,
        None => text::read(bytes, name, files),
    }
}

#[cfg(test)]
mod tests;
