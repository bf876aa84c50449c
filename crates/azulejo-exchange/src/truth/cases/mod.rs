//! The cases.

mod boxes;
mod ducts;
mod plates;
mod round;
mod spectra;

use super::enclosures::GreyEnclosure;
use super::net_radiation::KnownBalance;
use super::{ExchangeCase, ExchangeQuantity, GreyPaint};
use crate::thermal::network::{ExchangeError, RowCondition};
use std::sync::Arc;

/// The equations of `net_radiation`, for absorption factors.
const GEBHART: &str = "Gebhart 1961, absorption factors, by elimination";

/// The same with mirrors.
const GEBHART_IMAGES: &str = "F^s by images; Gebhart 1961 with F^s for F, by elimination";

/// Those for temperatures and fluxes.
const NET_RADIATION: &str =
    "net-radiation equations (Modest, Radiative Heat Transfer), by elimination";

/// All cases, in a fixed order.
pub fn all() -> Vec<ExchangeCase> {
    [
        plates::cases(),
        round::cases(),
        ducts::cases(),
        boxes::cases(),
        spectra::cases(),
    ]
    .concat()
}

/// A row of a given temperature, K.
fn at(temperature: f64) -> RowCondition {
    RowCondition::Temperature(temperature)
}

/// A row that gives off W/m².
fn giving(flux: f64) -> RowCondition {
    RowCondition::Flux(flux)
}

/// σ-less difference of black emission, T₁⁴ − T₂⁴ in K⁴.
fn fourth_powers(t1: f64, t2: f64) -> f64 {
    t1.powi(4) - t2.powi(4)
}

/// A case that stands alone.
fn case(
    id: &'static str,
    description: impl Into<String>,
    source: &'static str,
    quantity: ExchangeQuantity,
    truth: f64,
    answer: impl Fn() -> Result<f64, ExchangeError> + Send + Sync + 'static,
) -> ExchangeCase {
    ExchangeCase {
        id,
        description: description.into(),
        source,
        quantity,
        truth,
        tolerance: quantity.tolerance(),
        answer: Arc::new(answer),
    }
}

/// Questions about one enclosure.
struct EnclosureCases {
    description: String,
    build: Arc<dyn Fn() -> GreyEnclosure + Send + Sync>,
}

/// A quantity of one row or a pair, with its truth, and the source of that.
struct KnownAnswer {
    id: &'static str,
    source: &'static str,
    truth: f64,
}

fn known(id: &'static str, source: &'static str, truth: f64) -> KnownAnswer {
    KnownAnswer { id, source, truth }
}

impl EnclosureCases {
    fn new(
        description: impl Into<String>,
        build: impl Fn() -> GreyEnclosure + Send + Sync + 'static,
    ) -> EnclosureCases {
        EnclosureCases {
            description: description.into(),
            build: Arc::new(build),
        }
    }

    fn case(
        &self,
        known: KnownAnswer,
        asked: &str,
        quantity: ExchangeQuantity,
        answer: impl Fn(GreyEnclosure) -> Result<f64, ExchangeError> + Send + Sync + 'static,
    ) -> ExchangeCase {
        let build = self.build.clone();
        let description = format!("{}: {asked}", self.description);
        let answer = move || answer(build());
        case(
            known.id,
            description,
            known.source,
            quantity,
            known.truth,
            answer,
        )
    }

    fn factor(&self, known: KnownAnswer, i: usize, j: usize) -> ExchangeCase {
        let asked = format!("F^s from {} to {}", i + 1, j + 1);
        let answer = move |e: GreyEnclosure| Ok(e.factor(i, j));
        self.case(known, &asked, ExchangeQuantity::Factor, answer)
    }

    fn gebhart(&self, known: KnownAnswer, i: usize, j: usize) -> ExchangeCase {
        let asked = format!("B from {} to {}", i + 1, j + 1);
        let answer = move |e: GreyEnclosure| Ok(e.exchange()?.gebhart(i, j).0);
        self.case(known, &asked, ExchangeQuantity::Gebhart, answer)
    }

    fn script_f(&self, known: KnownAnswer, i: usize, j: usize) -> ExchangeCase {
        let asked = format!("script-F from {} to {}", i + 1, j + 1);
        let answer = move |e: GreyEnclosure| Ok(e.exchange()?.script_f(i, j).0);
        self.case(known, &asked, ExchangeQuantity::ScriptF, answer)
    }

    fn conductance(&self, known: KnownAnswer, i: usize, j: usize) -> ExchangeCase {
        let asked = format!("GR between {} and {}", i + 1, j + 1);
        let answer = move |e: GreyEnclosure| e.conductance(i, j);
        self.case(known, &asked, ExchangeQuantity::Conductance, answer)
    }

    /// Emissivity of an opening of this area, through which all rows see the sky.
    fn opening(&self, known: KnownAnswer, area: f64) -> ExchangeCase {
        let answer = move |e: GreyEnclosure| {
            let (exchange, sky) = (e.exchange()?, e.emissivity.len());
            let through: f64 = (0..sky).map(|i| exchange.conductance(i, sky).0).sum();
            Ok(through / area)
        };
        let asked = "apparent emissivity of the opening, all rows at one temperature";
        self.case(known, asked, ExchangeQuantity::ApparentEmissivity, answer)
    }

    fn flux(&self, known: KnownAnswer, row: usize, conditions: &[RowCondition]) -> ExchangeCase {
        let (asked, conditions) = (format!("q of {}", row + 1), conditions.to_vec());
        let answer = move |e: GreyEnclosure| Ok(e.heat(&conditions)?.fluxes[row]);
        self.case(known, &asked, ExchangeQuantity::Flux, answer)
    }

    fn temperature(
        &self,
        known: KnownAnswer,
        row: usize,
        conditions: &[RowCondition],
    ) -> ExchangeCase {
        let (asked, conditions) = (format!("T of {}", row + 1), conditions.to_vec());
        let answer = move |e: GreyEnclosure| Ok(e.heat(&conditions)?.temperatures[row]);
        self.case(known, &asked, ExchangeQuantity::Temperature, answer)
    }

    /// GR between rows 1 and 2 with all others adiabatic, from the heat at 400 and 300 K.
    fn through_reradiating(&self, known: KnownAnswer, area: f64) -> ExchangeCase {
        let answer = move |e: GreyEnclosure| {
            let mut conditions = vec![giving(0.0); e.emissivity.len()];
            (conditions[0], conditions[1]) = (at(400.0), at(300.0));
            let sigma = crate::thermal::network::STEFAN_BOLTZMANN;
            Ok(area * e.heat(&conditions)?.fluxes[0] / (sigma * fourth_powers(400.0, 300.0)))
        };
        let asked = "GR between 1 and 2, the others adiabatic";
        self.case(known, asked, ExchangeQuantity::Conductance, answer)
    }
}
