//! Radiative exchange: who absorbs what others emit, after all reflections.
//!
//! With emissivity ε, diffuse and specular reflectance ρ_d and ρ_s (ε + ρ_d + ρ_s = 1), extended factors
//! F^s (direct, and by all chains of mirrors), black emission E = σT⁴, irradiation H, of which H₀ comes
//! from outside, diffuse radiosity J and the net flux q that leaves a row:
//!
//! ```text
//! H_i = Σ_j F^s_ij J_j + H₀_i      J_i = ε_i E_i + ρ_d,i H_i      q_i = ε_i (E_i − H_i)
//! ```
//!
//! (Sarofim and Hottel, *Radiation exchange among non-Lambert surfaces*, J. Heat Transfer 88, 1966.)
//! [`exchange_factors`] solves this once for each node that emits alone, [`heat_balance`] for given
//! temperatures and fluxes. Sky and ground are black nodes, reached through what leaves the scene
//! upwards and downwards.

mod factors;
mod heat;
mod newton;
pub(crate) mod reflections;
#[cfg(test)]
pub(crate) mod tests;

pub use factors::{ExchangeFactors, exchange_factors};
pub use heat::{HeatBalance, HeatProblem, RowCondition, heat_balance};

use crate::enclosure::Enclosure;
use crate::thermal::bands::SpectralRange;
use azulejo_trace::Cancelled;
use std::fmt;

/// The Stefan–Boltzmann constant, W/(m²K⁴), CODATA 2018.
pub const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

/// Surfaces in one band.
#[derive(Clone, Debug)]
pub struct SurfaceBand<'a> {
    /// The factors, with the specular reflectances of this band.
    pub enclosure: &'a Enclosure,
    /// The wavelengths.
    pub range: SpectralRange,
    /// Emissivity of each row, which is its absorptance, 0..1 − ρ_s.
    pub emissivity: Vec<f64>,
}

impl SurfaceBand<'_> {
    /// ρ_d of each row.
    fn diffuse(&self) -> Vec<f64> {
        let rows = self.emissivity.iter().zip(&self.enclosure.factors.ends);
        rows.map(|(e, ends)| (ends - e).max(0.0)).collect()
    }
}

/// Why there is no solution.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ExchangeError {
    /// The caller cancelled.
    Cancelled,
    /// Light would grow from reflection to reflection: rows up to this one sum to more than one.
    Grows {
        /// Its name.
        row: String,
    },
    /// These rows exchange heat among themselves alone, and none of them has a temperature.
    Floating {
        /// The name of one of them.
        row: String,
        /// How many there are.
        rows: usize,
    },
    /// A row that neither emits nor absorbs is to give off heat.
    NeitherEmitsNorAbsorbs {
        /// Its name.
        row: String,
    },
    /// The temperature of a row would be below absolute zero: it is to give off more than arrives.
    BelowZero {
        /// Its name.
        row: String,
    },
    /// A temperature or a flux is too large for floating-point numbers.
    TooHot {
        /// The name of the row.
        row: String,
    },
    /// Iterations do not converge.
    Diverges {
        /// Iterations that were made.
        iterations: usize,
    },
}

impl fmt::Display for ExchangeError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            ExchangeError::Cancelled => write!(f, "cancelled"),
            ExchangeError::Grows { row } => write!(
                f,
                "row \"{row}\" and those before it sum to so much more than 1 that light grows from \
                 reflection to reflection: close the rows (--closure), or ask for more rays"
            ),
            ExchangeError::Floating { row, rows } => write!(
                f,
                "\"{row}\" and {} other rows exchange heat among themselves alone and none of them has a \
                 temperature, so that theirs could be any: give one of them T, or an opening",
                rows - 1
            ),
            ExchangeError::NeitherEmitsNorAbsorbs { row } => write!(
                f,
                "\"{row}\" has emissivity 0 and cannot give off heat: expected q = 0 (adiabatic) or T"
            ),
            ExchangeError::BelowZero { row } => write!(
                f,
                "\"{row}\" would have to be colder than absolute zero to take up what q asks for: less \
                 arrives there"
            ),
            ExchangeError::TooHot { row } => write!(
                f,
                "temperature or flux of \"{row}\" would be too large to compute with: are T in kelvin and q in \
                 W/m²?"
            ),
            ExchangeError::Diverges { iterations } => write!(
                f,
                "no solution after {iterations} iterations: are there closed groups of mirrors, or rows \
                 that nearly see themselves alone?"
            ),
        }
    }
}

impl std::error::Error for ExchangeError {}

impl From<Cancelled> for ExchangeError {
    fn from(_: Cancelled) -> ExchangeError {
        ExchangeError::Cancelled
    }
}
