//! Errors in descriptions of reflection models.

use std::fmt;

/// Why a description is not a valid model.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum BrdfError {
    /// No model has this name.
    UnknownModel {
        /// The name as written.
        name: String,
        /// The most similar known name.
        nearest: &'static str,
    },
    /// The table of metals has none of this name.
    UnknownMetal {
        /// The name as written.
        name: String,
        /// The most similar known name.
        nearest: &'static str,
    },
    /// The model has no parameter of this name.
    UnknownParameter {
        /// Name of the model.
        model: &'static str,
        /// The name as written.
        name: String,
        /// Names of its parameters.
        known: Vec<&'static str>,
        /// The most similar of them.
        nearest: Option<&'static str>,
    },
    /// A parameter that must be given is not.
    Missing {
        /// Name of the model.
        model: &'static str,
        /// Its name.
        name: &'static str,
    },
    /// A parameter is given twice.
    Twice {
        /// Its name.
        name: &'static str,
    },
    /// The value is of the wrong type.
    WrongKind {
        /// Name of the parameter.
        name: &'static str,
        /// The expected type, in words.
        expected: String,
    },
    /// A number is outside the allowed range.
    Range {
        /// Name of the parameter.
        name: &'static str,
        /// The name as written.
        value: f64,
        /// The smallest allowed value.
        least: f64,
        /// The largest allowed value.
        most: f64,
    },
    /// The model reflects more light than it receives.
    Energy {
        /// The names of the summands.
        what: String,
        /// The sum.
        sum: f64,
    },
    /// Any other error, in words.
    Other(String),
    /// The text is not a description.
    Syntax {
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
}

impl fmt::Display for BrdfError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BrdfError::UnknownModel { name, nearest } => write!(
                f,
                "there is no reflection model `{name}`; the nearest name is `{nearest}`"
            ),
            BrdfError::UnknownMetal { name, nearest } => write!(
                f,
                "there is no metal `{name}`; the nearest name is `{nearest}`"
            ),
            BrdfError::UnknownParameter {
                model,
                name,
                known,
                nearest,
            } => {
                write!(f, "`{model}` has no parameter `{name}`")?;
                if let Some(nearest) = nearest {
                    write!(f, "; the nearest name is `{nearest}`")?;
                }
                write!(f, " (it has {})", known.join(", "))
            }
            BrdfError::Missing { model, name } => write!(f, "`{model}` needs `{name}`"),
            BrdfError::Twice { name } => write!(f, "`{name}` is given twice"),
            BrdfError::WrongKind { name, expected } => write!(f, "`{name}` must be {expected}"),
            BrdfError::Range {
                name,
                value,
                least,
                most,
            } => write!(
                f,
                "`{name}` is {value}; it must be between {least} and {most}"
            ),
            BrdfError::Energy { what, sum } => {
                write!(f, "{what} is {sum}: more than 1 would create energy")
            }
            BrdfError::Other(text) => f.write_str(text),
            BrdfError::Syntax { found, expected } => {
                write!(f, "found {found}, expected {expected}")
            }
        }
    }
}

impl std::error::Error for BrdfError {}
