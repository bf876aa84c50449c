//! Errors of the libraries as Python's exceptions.

use azulejo::files::{Refused, reason};
use azulejo::models::ReadFailure;
use azulejo::output::OutputError;
use azulejo_factors::FactorsError;
use azulejo_radiosity::SolveError;
use azulejo_trace::Cancelled;
use pyo3::PyErr;
use pyo3::exceptions::{PyIsADirectoryError, PyMemoryError, PyOSError, PyValueError};
use std::fmt;
use std::io;
use std::path::Path;

pyo3::create_exception!(
    pyazulejo,
    AzulejoError,
    PyValueError,
    "What was asked for cannot be done; the message says why, and what to change."
);

/// An [`AzulejoError`] with this message.
pub fn refused(message: impl fmt::Display) -> PyErr {
    AzulejoError::new_err(message.to_string())
}

/// Work that was cancelled. Nobody sees it: whoever cancels raises what he cancelled for.
pub fn cancelled(_: Cancelled) -> PyErr {
    refused(Cancelled)
}

/// Why there are no form factors.
pub fn factors_error(error: FactorsError) -> PyErr {
    match error {
        FactorsError::TooLarge { .. } => PyMemoryError::new_err(error.to_string()),
        other => refused(other),
    }
}

/// Why there is no light.
pub fn light_error(error: SolveError) -> PyErr {
    match error {
        SolveError::Factors(error) => factors_error(error),
        other => refused(other),
    }
}

/// Why a model could not be read.
pub fn reading_error(failure: ReadFailure) -> PyErr {
    match failure {
        ReadFailure::File(refused) => refused_error(&refused),
        ReadFailure::Directory(_) => PyIsADirectoryError::new_err(failure.to_string()),
        other => refused(other),
    }
}

/// Why nothing was written.
pub fn output_error(error: OutputError) -> PyErr {
    match error {
        OutputError::File(refused) => file_error(refused.error, &refused.path),
        other => refused(other),
    }
}

fn refused_error(refused: &Refused) -> PyErr {
    let Refused { error, path, .. } = refused;
    match error.raw_os_error() {
        Some(number) => numbered_error(number, error, path),
        None => PyOSError::new_err(refused.to_string()),
    }
}

/// An error of the file system.
pub fn file_error(error: io::Error, path: &Path) -> PyErr {
    match error.raw_os_error() {
        Some(number) => numbered_error(number, &error, path),
        None => PyOSError::new_err(format!("{}: {error}", path.display())),
    }
}

/// Python chooses the class by the number: `FileNotFoundError`, `PermissionError`.
fn numbered_error(number: i32, error: &io::Error, path: &Path) -> PyErr {
    let path = path.to_string_lossy().into_owned();
    PyOSError::new_err((number, reason(error), path))
}
