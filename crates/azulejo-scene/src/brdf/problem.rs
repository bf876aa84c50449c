//! What can be wrong with a description.

use std::fmt;

/// Why a description makes no model.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Problem {
    /// No model has this name.
    UnknownModel {
        /// As it was written.
        name: String,
        /// The known name that is most like it.
        nearest: &'static str,
    },
    /// The table of metals has none of this name.
    UnknownMetal {
        /// As it was written.
        name: String,
        /// The known name that is most like it.
        nearest: &'static str,
    },
    /// The model has no parameter of this name.
    UnknownParameter {
        /// Of which model.
        model: &'static str,
        /// As it was written.
        name: String,
        /// Those that it has.
        known: Vec<&'static str>,
        /// The one that is most like it.
        nearest: Option<&'static str>,
    },
    /// A parameter that must be given is not.
    Missing {
        /// Of which model.
        model: &'static str,
        /// Its name.
        name: &'static str,
    },
    /// A parameter is given twice.
    Twice {
        /// Its name.
        name: &'static str,
    },
    /// The value is of another kind.
    Kind {
        /// Of which parameter.
        name: &'static str,
        /// What is expected.
        expected: String,
    },
    /// A number is outside of what the model allows.
    Range {
        /// Of which parameter.
        name: &'static str,
        /// As it was written.
        value: f64,
        /// The least that is allowed.
        least: f64,
        /// The most.
        most: f64,
    },
    /// More is reflected than arrives.
    Energy {
        /// What was added.
        what: String,
        /// What it came to.
        sum: f64,
    },
    /// Anything else, said in words.
    Other(String),
    /// The text is not one of a description.
    Syntax {
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Problem::UnknownModel { name, nearest } => write!(
                f,
                "there is no reflection model `{name}`; the nearest name is `{nearest}`"
            ),
            Problem::UnknownMetal { name, nearest } => write!(
                f,
                "there is no metal `{name}`; the nearest name is `{nearest}`"
            ),
            Problem::UnknownParameter {
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
            Problem::Missing { model, name } => write!(f, "`{model}` needs `{name}`"),
            Problem::Twice { name } => write!(f, "`{name}` is given twice"),
            Problem::Kind { name, expected } => write!(f, "`{name}` must be {expected}"),
            Problem::Range {
                name,
                value,
                least,
                most,
            } => write!(
                f,
                "`{name}` is {value}; it must be between {least} and {most}"
            ),
            Problem::Energy { what, sum } => {
                write!(
                    f,
                    "{what} is {sum}: more than 1 would reflect more than arrives"
                )
            }
            Problem::Other(text) => f.write_str(text),
            Problem::Syntax { found, expected } => {
                write!(f, "found {found}, expected {expected}")
            }
        }
    }
}

impl std::error::Error for Problem {}
