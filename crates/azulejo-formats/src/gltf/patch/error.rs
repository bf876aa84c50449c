//! Why a file is not edited.

use crate::ReadError;
use std::fmt;

/// Why a file is not edited.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PatchError {
    /// It cannot be read.
    Read(ReadError),
    /// It can be read, but not edited, or what was asked for does not fit it.
    Refused {
        /// File name as given.
        file: String,
        /// What is in the way.
        found: String,
    },
}

impl PatchError {
    /// The error of a file with this in the way.
    pub(super) fn of(file: &str, found: impl Into<String>) -> PatchError {
        PatchError::Refused {
            file: file.to_owned(),
            found: found.into(),
        }
    }
}

impl fmt::Display for PatchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PatchError::Read(error) => error.fmt(f),
            PatchError::Refused { file, found } => write!(f, "{file}: not edited: {found}"),
        }
    }
}

impl std::error::Error for PatchError {}

impl From<ReadError> for PatchError {
    fn from(error: ReadError) -> PatchError {
        PatchError::Read(error)
    }
}
