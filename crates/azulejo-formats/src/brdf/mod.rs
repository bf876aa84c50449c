//! Files of reflection models: azulejo's text format ([`text`]), and measured data.
//!
//! [`read`] recognizes them by their content; file names and extensions do not matter, because
//! other programs use `.brdf` for various formats.

pub(crate) mod inline;
mod measured;
pub mod merl;
pub mod rgl;
mod tensors;
pub mod text;

pub(crate) use measured::measured;

use crate::{Files, ReadError, Warning};
use azulejo_scene::brdf::Content;

/// A file that was read, with warnings.
#[derive(Clone, Debug)]
pub struct LoadedBrdf {
    /// What it holds.
    pub content: Content,
    /// Warnings about skipped content, and about physically questionable properties of the model.
    pub warnings: Vec<Warning>,
}

/// Reads a file of a reflection model. `name` is its name in messages, and its location; files that
/// it refers to come from `files`.
///
/// # Errors
/// An unknown format, or an error in the file, with its position.
pub fn read(bytes: &[u8], name: &str, files: &dyn Files) -> Result<LoadedBrdf, ReadError> {
    match measured(bytes, name) {
        Some(read) => read,
        None => text::read(bytes, name, files),
    }
}

#[cfg(test)]
mod tests;
