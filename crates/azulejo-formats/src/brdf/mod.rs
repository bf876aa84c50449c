//! Files of reflection models: measured data.
//!
//! [`read`] tells them apart by their content; names and their endings say nothing, because other
//! programs call quite different things `.brdf`.

mod measured;
pub mod merl;
pub mod rgl;
mod tensors;

pub(crate) use measured::measured;

use crate::{ReadError, Warning};
use azulejo_scene::brdf::Content;

/// A file that was read, and what was skipped or doubtful in it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// What it holds.
    pub content: Content,
    /// What was skipped, and what the model does that a model should not.
    pub warnings: Vec<Warning>,
}

/// Reads a file of a reflection model. `name` is what messages call it.
///
/// # Errors
/// No form that is known, or something that is wrong in it, with its place.
pub fn read(bytes: &[u8], name: &str) -> Result<Loaded, ReadError> {
    measured(bytes, name).unwrap_or_else(|| {
        Err(ReadError::whole(
            name,
            "bytes of no form that is known",
            "a reflection model measured by MERL (.binary) or RGL (.bsdf)",
        ))
    })
}
