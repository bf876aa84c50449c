//! What was checked, with what came out.

use serde::Serialize;
use std::fmt;

/// Parts of the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ValidationPart {
    /// Form factors with known values.
    ClosedForms,
    /// Exchange factors, temperatures and fluxes with known values.
    Exchange,
    /// Closure, reciprocity and energy of whole scenes, and their stated errors.
    Balances,
    /// How often the truth lies within the error bars.
    ErrorBars,
    /// The same bits for any number of threads.
    Repeatability,
}

impl ValidationPart {
    /// All of them, in the order of the report.
    pub const ALL: [ValidationPart; 5] = [
        ValidationPart::ClosedForms,
        ValidationPart::Exchange,
        ValidationPart::Balances,
        ValidationPart::ErrorBars,
        ValidationPart::Repeatability,
    ];
}

impl fmt::Display for ValidationPart {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            ValidationPart::ClosedForms => "closed forms",
            ValidationPart::Exchange => "exchange",
            ValidationPart::Balances => "balances",
            ValidationPart::ErrorBars => "error bars",
            ValidationPart::Repeatability => "repeatability",
        })
    }
}

/// The result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CheckOutcome {
    /// Within its bound.
    Passed,
    /// An estimate further from the truth than four of its standard errors, of which a few are due to
    /// chance: a check of their number decides.
    Outlying,
    /// Outside of its bound.
    Failed,
}

/// One number that was compared.
#[derive(Clone, Debug, Serialize)]
pub struct CheckRecord {
    /// The part of the report.
    pub part: ValidationPart,
    /// The engine with its setting; empty where there is none.
    pub engine: String,
    /// Case or scene.
    pub subject: String,
    /// What was computed.
    pub description: String,
    /// Where the expected value is from.
    pub source: String,
    /// Unit of the values; empty for shares.
    pub unit: &'static str,
    /// The value found.
    pub found: f64,
    /// The value expected.
    pub expected: f64,
    /// Uncertainty of the value expected: rounding, digits, and what the scene simplifies.
    pub expected_error: f64,
    /// Standard error of the value found, if it is an estimate.
    pub standard_error: Option<f64>,
    /// Largest |found − expected| that passes.
    pub bound: f64,
    /// The result.
    pub outcome: CheckOutcome,
    /// What else is to be known.
    pub note: String,
    /// Wall-clock time, s.
    pub seconds: f64,
}

impl CheckRecord {
    /// A check of a value against a bound on its deviation.
    pub fn new(part: ValidationPart, subject: impl Into<String>, values: [f64; 3]) -> CheckRecord {
        let [value, expected, bound] = values;
        let is_within = (value - expected).abs() <= bound;
        CheckRecord {
            part,
            engine: String::new(),
            subject: subject.into(),
            description: String::new(),
            source: String::new(),
            unit: "",
            found: value,
            expected,
            expected_error: 0.0,
            standard_error: None,
            bound,
            outcome: if is_within {
                CheckOutcome::Passed
            } else {
                CheckOutcome::Failed
            },
            note: String::new(),
            seconds: 0.0,
        }
    }

    /// The same, with the engine and what was computed.
    pub fn of(self, engine: &str, description: impl Into<String>) -> CheckRecord {
        CheckRecord {
            engine: engine.to_owned(),
            description: description.into(),
            ..self
        }
    }

    /// The deviation.
    pub fn deviation(&self) -> f64 {
        self.found - self.expected
    }

    /// The deviation in standard errors of the difference; `None` for values without.
    pub fn standard_score(&self) -> Option<f64> {
        let error = self.standard_error.filter(|e| *e > 0.0 && e.is_finite())?;
        Some(self.deviation() / error.hypot(self.expected_error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_decide() {
        let check = |value| CheckRecord::new(ValidationPart::Balances, "x", [value, 1.0, 0.25]);
        assert_eq!(check(1.25).outcome, CheckOutcome::Passed);
        assert_eq!(check(0.7).outcome, CheckOutcome::Failed);
        assert_eq!(check(f64::NAN).outcome, CheckOutcome::Failed);
        let estimate = CheckRecord {
            standard_error: Some(0.1),
            ..check(1.2)
        };
        assert!((estimate.standard_score().unwrap() - 2.0).abs() < 1e-12);
        let beside = CheckRecord {
            expected_error: 1.0,
            ..estimate
        };
        assert!((beside.standard_score().unwrap() - 0.2).abs() < 0.01);
        assert_eq!(check(1.2).standard_score(), None);
    }
}
