//! Enclosures with a question whose answer is known, to judge the solvers of [`network`](crate::thermal::network)
//! and those of other programs by.
//!
//! [`exchange_cases`] returns 156 of them. [`ExchangeCase::truth`] is what a textbook says: a
//! closed formula of [`expected`], or, where there are three surfaces or more, the textbook's own
//! equations, written down as they stand and solved by elimination. None of it uses the crate's solver,
//! which [`ExchangeCase::ask`] asks. Both sides get their form factors in different ways: truths by
//! formulas of catalogues, questions between polygons, by crossed strings between points, and mirror image
//! by mirror image.
//!
//! ```
//! let cases = azulejo_exchange::truth::exchange_cases();
//! let plates = cases.iter().find(|case| case.id == "plates_dd_GR").unwrap();
//! assert!((plates.truth - 1.0 / (1.0 / 0.8 + 1.0 / 0.3 - 1.0)).abs() < 1e-15);
//! assert!(plates.is_within(plates.ask().unwrap()));
//! ```
//!
//! | module | content |
//! |---|---|
//! | [`expected`] | closed formulas |
//! | `net_radiation` | the textbook's equations, and elimination |
//! | `planck` | black emission in bands, by quadrature |
//! | `known_factors` | form factors for truths, by formulas |
//! | `enclosures`, `images` | the enclosures that the solver is asked about |
//! | `cases/` | the cases |

mod cases;
mod enclosures;
pub mod expected;
mod images;
mod known_factors;
mod net_radiation;
mod planck;
#[cfg(test)]
mod tests;

use crate::thermal::network::ExchangeError;
use std::fmt;
use std::sync::Arc;

/// What answers a question by the crate's solver.
type Answerer = Arc<dyn Fn() -> Result<f64, ExchangeError> + Send + Sync>;

/// A question about the exchange in an enclosure, with its known answer.
#[derive(Clone)]
pub struct ExchangeCase {
    /// Short name, unique.
    pub id: &'static str,
    /// The enclosure with its properties, and what is asked, for reports. Rows count from 1.
    pub description: String,
    /// The formula, rule or book that the truth follows.
    pub source: &'static str,
    /// What is asked, with its unit.
    pub quantity: ExchangeQuantity,
    /// The known answer, in the unit of `quantity`.
    pub truth: f64,
    /// How far an answer may be off: a share of the truth, for temperatures kelvin.
    pub tolerance: f64,
    answer: Answerer,
}

/// The quantity of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExchangeQuantity {
    /// A form factor, extended by mirrors: F^s. The solver has no part in it.
    Factor,
    /// Gebhart's absorption factor B.
    Gebhart,
    /// The transfer factor, script-F.
    ScriptF,
    /// A conductance GR, m²; of infinitely long enclosures per metre, m²/m.
    Conductance,
    /// Emissivity of an opening: GR to black surroundings over the area of the opening.
    ApparentEmissivity,
    /// A temperature, K.
    Temperature,
    /// A flux or an irradiation, W/m².
    Flux,
    /// Share of a black body's emission in a band.
    BandFraction,
}

impl ExchangeQuantity {
    /// Its unit; `1` for ratios.
    pub fn unit(self) -> &'static str {
        match self {
            ExchangeQuantity::Conductance => "m²",
            ExchangeQuantity::Temperature => "K",
            ExchangeQuantity::Flux => "W/m²",
            _ => "1",
        }
    }

    /// Its usual tolerance: a share, for temperatures kelvin.
    fn tolerance(self) -> f64 {
        match self {
            ExchangeQuantity::Temperature => 1e-8,
            _ => 1e-10,
        }
    }
}

impl ExchangeCase {
    /// The answer of the crate's solver, in the unit of `quantity`.
    ///
    /// # Errors
    /// [`ExchangeError`] if the solver finds no solution, which no case is made for.
    pub fn ask(&self) -> Result<f64, ExchangeError> {
        (self.answer)()
    }

    /// How far an answer is off, as `tolerance` counts: a share of the truth, for temperatures kelvin.
    pub fn deviation(&self, found: f64) -> f64 {
        let scale = match self.quantity {
            ExchangeQuantity::Temperature => 1.0,
            _ => self.truth.abs(),
        };
        (found - self.truth).abs() / scale
    }

    /// Whether an answer is the truth within the tolerance; NaN is not.
    pub fn is_within(&self, found: f64) -> bool {
        self.deviation(found) <= self.tolerance
    }
}

impl fmt::Debug for ExchangeCase {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("ExchangeCase")
            .field("id", &self.id)
            .field("quantity", &self.quantity)
            .field("truth", &self.truth)
            .field("tolerance", &self.tolerance)
            .finish_non_exhaustive()
    }
}

/// All cases, in a fixed order.
pub fn exchange_cases() -> Vec<ExchangeCase> {
    cases::all()
}

/// Emissivities and mirror reflectances of rows, 0..1; what is left of 1 is reflected diffusely.
#[derive(Clone, Debug, PartialEq)]
struct GreyPaint {
    emissivity: Vec<f64>,
    mirror: Vec<f64>,
}

impl GreyPaint {
    fn new(emissivity: &[f64], mirror: &[f64]) -> GreyPaint {
        assert_eq!(emissivity.len(), mirror.len(), "one of each for each row");
        GreyPaint {
            emissivity: emissivity.to_vec(),
            mirror: mirror.to_vec(),
        }
    }

    /// Without mirrors.
    fn matt(emissivity: &[f64]) -> GreyPaint {
        GreyPaint::new(emissivity, &vec![0.0; emissivity.len()])
    }

    fn rows(&self) -> usize {
        self.emissivity.len()
    }
}
