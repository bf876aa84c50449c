//! Errors of form factor computations.

use azulejo_trace::Cancelled;
use std::fmt;

/// Why form factors could not be computed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FactorsError {
    /// There is no surface with an area.
    NoSurface,
    /// The caller cancelled.
    Cancelled,
    /// No failure: the blocks of this process are done, and another makes the result of them
    /// ([`RunRole::assembles`](azulejo_trace::RunRole::assembles)).
    Elsewhere,
    /// A few rays contradict the formulas of many rows.
    Doubtful {
        /// Rows whose light rays find elsewhere.
        doubtful: usize,
        /// All rows.
        rows: usize,
    },
    /// The forecast of the matrix exceeds the memory that may be used.
    TooLarge {
        /// Rows of the matrix.
        rows: usize,
        /// Bytes it needs, by the forecast.
        bytes: u64,
        /// Bytes that may be used.
        memory: u64,
    },
}

impl From<Cancelled> for FactorsError {
    fn from(_: Cancelled) -> FactorsError {
        FactorsError::Cancelled
    }
}

impl fmt::Display for FactorsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FactorsError::NoSurface => f.write_str("the scene has no surface for light to fall on"),
            FactorsError::Cancelled => f.write_str("cancelled"),
            FactorsError::Elsewhere => f.write_str("the result is made elsewhere"),
            FactorsError::Doubtful { doubtful, rows } => write!(
                f,
                "a few rays contradict the formulas of {doubtful} of {rows} rows: trace rays instead, and look for \
                 faces that overlap"
            ),
            FactorsError::TooLarge {
                rows,
                bytes,
                memory,
            } => {
                let size = |&bytes: &u64| match bytes as f64 / f64::from(1 << 20) {
                    mebibytes if mebibytes < 1000.0 => format!("{mebibytes:.1} MiB"),
                    mebibytes => format!("{:.1} GiB", mebibytes / 1024.0),
                };
                write!(
                    f,
                    "form factors between {rows} patches need about {} of memory, and {} may be used: divide \
                     into fewer patches, trace fewer rays from each, or allow more memory",
                    size(bytes),
                    size(memory)
                )
            }
        }
    }
}

impl std::error::Error for FactorsError {}
