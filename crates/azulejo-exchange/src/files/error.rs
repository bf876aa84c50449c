//! Why a matrix cannot be written for a program.

use std::fmt;
use std::io;

/// Why a matrix cannot be written for a program.
#[derive(Debug)]
#[non_exhaustive]
pub enum FactorFileError {
    /// The program takes direct factors, and mirrors or glass take part in those that there are.
    Mirrors {
        /// The program.
        program: &'static str,
    },
    /// Rows are not what the program counts.
    Rows {
        /// The program.
        program: &'static str,
        /// What was found, and what was expected, each with its count.
        message: String,
    },
    /// A name that the program cannot read.
    BadName {
        /// The program.
        program: &'static str,
        /// The name.
        name: String,
        /// What it must not have.
        why: &'static str,
    },
    /// A chosen row that there is not.
    UnknownRow {
        /// Its name.
        name: String,
        /// Names that there are.
        known: Vec<String>,
    },
    /// An array with another number of values than there are rows.
    ArrayLength {
        /// Its name.
        name: String,
        /// Its values.
        found: usize,
        /// The rows.
        expected: usize,
    },
    /// Polygons are needed, and the matrix came from a file that has none.
    NoPolygons,
    /// Something that the format needs was not given.
    Missing {
        /// The format.
        format: &'static str,
        /// What is missing, and how to give it.
        message: &'static str,
    },
    /// The matrix is not among its factors, and has no single entries.
    Elsewhere,
    /// A format of several files cannot be written to one.
    SeveralFiles {
        /// The format.
        format: &'static str,
    },
    /// The file could not be written.
    Writing(io::Error),
}

/// Names of rows that a message lists at most.
const LISTED: usize = 8;

impl fmt::Display for FactorFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use FactorFileError as E;
        match self {
            E::Mirrors { program } => write!(
                f,
                "{program} takes direct factors, and mirrors or glass are part of these: compute them \
                 with --separate, and the direct part is written"
            ),
            E::Rows { program, message } => write!(f, "{program}: {message}"),
            E::BadName { program, name, why } => {
                write!(f, "{program} cannot read the name \"{name}\": it has {why}")
            }
            E::UnknownRow { name, known } => {
                let listed: Vec<_> = known.iter().take(LISTED).map(String::as_str).collect();
                let more = if known.len() > LISTED { ", …" } else { "" };
                write!(
                    f,
                    "found no row \"{name}\", expected one of {}{more}",
                    listed.join(", ")
                )
            }
            E::ArrayLength {
                name,
                found,
                expected,
            } => write!(
                f,
                "array {name}: found {found} values, expected {expected}, one for each row"
            ),
            E::NoPolygons => f.write_str(
                "the matrix has no polygons, which .vtu shows: compute it from a model, or read an \
                 .npz that was",
            ),
            E::Missing { format, message } => write!(f, "{format}: {message}"),
            E::Elsewhere => f.write_str(
                "the matrix is in blocks, which have no single entries: write that between groups of its rows",
            ),
            E::SeveralFiles { format } => {
                write!(f, "{format} consists of several files, which need a folder")
            }
            E::Writing(e) => e.fmt(f),
        }
    }
}

impl std::error::Error for FactorFileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            FactorFileError::Writing(e) => Some(e),
            _ => None,
        }
    }
}
