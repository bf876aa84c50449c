//! Under construction.

use crate::{Files, Loaded, ReadError, ReadOptions};

/// Reads.
pub fn read(
    _bytes: &[u8],
    name: &str,
    _files: &dyn Files,
    _options: &ReadOptions,
) -> Result<Loaded, ReadError> {
    Err(ReadError::whole(name, "gltf", "another format"))
}
