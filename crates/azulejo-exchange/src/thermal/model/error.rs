//! Why a thermal model has no solution.

use crate::thermal::bands::SpectralRange;
use crate::thermal::network::ExchangeError;
use std::fmt;

/// Why a thermal model has no solution.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelError {
    /// There is no matrix.
    NoMatrix,
    /// Two matrices have different rows.
    OtherRows {
        /// The name of the one.
        matrix: String,
        /// The name of the other.
        of: String,
    },
    /// No matrix has the mirrors of a band.
    OtherMirrors {
        /// The name of the first matrix.
        matrix: String,
        /// A row whose mirror reflectance is another.
        row: String,
        /// The reflectance in the matrix.
        computed: f64,
        /// That of the band.
        expected: f64,
        /// The band.
        range: SpectralRange,
    },
    /// The rows of a node differ, so that they cannot be lumped.
    Uneven {
        /// The node.
        node: String,
        /// In what they differ, as columns of tables are called.
        what: &'static str,
        /// The smallest and the largest value.
        between: [f64; 2],
    },
    /// The rows of a node have different temperatures or fluxes, so that they cannot be lumped.
    UnevenConditions {
        /// The node.
        node: String,
    },
    /// The exchange has no solution.
    Exchange(ExchangeError),
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            ModelError::NoMatrix => write!(f, "there are no form factors"),
            ModelError::OtherRows { matrix, of } => {
                write!(f, "{matrix}: its rows are not those of {of}")
            }
            ModelError::OtherMirrors {
                matrix,
                row,
                computed,
                expected,
                range,
            } => {
                let band = match range {
                    SpectralRange::Thermal => String::new(),
                    range => format!(" in the band {range}"),
                };
                // They are kept as differences from 1, whose last digits nobody wrote.
                let [computed, expected] = [computed, expected].map(|x| (x * 1e6).round() / 1e6);
                write!(
                    f,
                    "{matrix}: its factors were computed with mirror reflectance {computed} of \"{row}\", the \
                     materials have {expected}{band}: compute factors with these materials"
                )
            }
            ModelError::Uneven {
                node,
                what,
                between: [low, high],
            } => write!(
                f,
                "the rows of \"{node}\" have {what} from {low} to {high} and cannot be lumped, expected one value: \
                 choose nodes that are even (by material), or do not lump"
            ),
            ModelError::UnevenConditions { node } => write!(
                f,
                "the rows of \"{node}\" have different temperatures or fluxes and cannot be lumped"
            ),
            ModelError::Exchange(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ModelError {}

impl From<ExchangeError> for ModelError {
    fn from(error: ExchangeError) -> ModelError {
        ModelError::Exchange(error)
    }
}
