//! Why there is no light.

use crate::gathering::GatherError;
use azulejo_factors::FactorsError;
use azulejo_trace::Cancelled;
use std::fmt;

/// Why there is no solution.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SolveError {
    /// Nothing in the scene emits light.
    NoLight,
    /// There is no surface with an area.
    NoSurface,
    /// After this many bounces light had not died out: hardly anything absorbs it, and it cannot escape.
    Endless(u32),
    /// The deadline passed before there was light on all vertices or points.
    OutOfTime,
    /// The caller cancelled.
    Cancelled,
    /// No failure: the blocks of this process are done, and another makes the result of them
    /// ([`RunRole::assembles`](azulejo_trace::RunRole::assembles)).
    Elsewhere,
    /// Form factors failed for another reason. [`solve`](crate::solve()) keeps to its memory and never returns
    /// this; programs that also compute matrices do.
    Factors(FactorsError),
}

impl From<FactorsError> for SolveError {
    fn from(error: FactorsError) -> SolveError {
        match error {
            FactorsError::NoSurface => SolveError::NoSurface,
            FactorsError::Cancelled => SolveError::Cancelled,
            FactorsError::Elsewhere => SolveError::Elsewhere,
            other => SolveError::Factors(other),
        }
    }
}

impl From<GatherError> for SolveError {
    fn from(error: GatherError) -> SolveError {
        match error {
            GatherError::Cancelled => SolveError::Cancelled,
            GatherError::OutOfTime => SolveError::OutOfTime,
            GatherError::Elsewhere => SolveError::Elsewhere,
        }
    }
}

impl From<Cancelled> for SolveError {
    fn from(_: Cancelled) -> SolveError {
        SolveError::Cancelled
    }
}

impl fmt::Display for SolveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SolveError::NoLight => f.write_str(
                "nothing in the scene emits light: add a light, or a material that emits",
            ),
            SolveError::NoSurface => FactorsError::NoSurface.fmt(f),
            SolveError::Endless(bounces) => write!(
                f,
                "after {bounces} bounces the light has not died out, because surfaces reflect all or \
                 nearly all of it, or coincide: give some a lower reflectance, remove duplicates, or \
                 limit the bounces"
            ),
            SolveError::OutOfTime => f.write_str(
                "the time was over before all of the scene had light: allow more time, \
                 or ask for fewer patches",
            ),
            SolveError::Cancelled => FactorsError::Cancelled.fmt(f),
            SolveError::Elsewhere => FactorsError::Elsewhere.fmt(f),
            SolveError::Factors(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SolveError {}
