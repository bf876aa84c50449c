//! VRML 1.0, VRML97 and X3D, the latter in XML or in the classic encoding.

#[allow(dead_code, reason = "the readers that use it follow")]
mod faces;
#[allow(dead_code, reason = "the readers that use it follow")]
mod lexer;

use crate::{Files, Loaded, ReadError, ReadOptions};

/// Reads.
pub fn read(
    _bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    _options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    Err(ReadError::whole(name, "vrml", "another format"))
}
