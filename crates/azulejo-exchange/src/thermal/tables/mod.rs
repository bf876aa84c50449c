//! What users say of surfaces: tables of materials and of boundary conditions, as CSV, TSV or TOML.
//!
//! A record is for the rows whose own name, face, object or material it names, in this order; names may have
//! `*` and `?`. Exact names come before patterns, and patterns in the order of the table, so that `*`
//! may stand anywhere for all others.

mod boundary;
mod materials;
mod names;
mod numbers;
mod paint;
mod records;
#[cfg(test)]
mod tests;

pub use boundary::{BoundaryTable, Conditions};
pub use materials::{MaterialTable, Properties, TableBand};
pub use numbers::{NamedValues, NumberRecord};

use std::collections::BTreeSet;
use std::fmt;

/// What is wrong with a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableError(String);

impl TableError {
    pub(crate) fn new(words: impl fmt::Display) -> TableError {
        TableError(words.to_string())
    }

    /// That nothing says `what` of these.
    fn without_record(missing: &BTreeSet<String>, what: &str) -> TableError {
        TableError::new(format_args!(
            "nothing says {what} of {}; a record named * is for all others",
            names::listed(missing)
        ))
    }
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for TableError {}
