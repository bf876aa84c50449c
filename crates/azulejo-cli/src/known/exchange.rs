//! Exchange with known answers: enclosures with a question, to judge the solvers of
//! [`network`](azulejo_exchange::thermal::network) and those of other programs by.
//!
//! [`exchange_cases`] returns 156 of them. Truths are what textbooks say: closed formulas, or, where there are
//! three surfaces or more, the textbooks' own equations. [`ExchangeCase::ask`] asks the solver, with the
//! extended form factors F^s of the enclosure, which are data, too.

use azulejo_exchange::thermal::network::{
    ExchangeError, ExchangeFactors, HeatBalance, HeatProblem, STEFAN_BOLTZMANN, SurfaceBand,
    exchange_factors, heat_balance,
};
use azulejo_exchange::{Enclosure, Groups, RowCondition, RowTable, SpectralRange};
use azulejo_factors::FormFactors;
use azulejo_factors::form_factors::{Exchange, RowRemainder};
use azulejo_trace::Progress;
use serde::Deserialize;
use std::sync::Arc;

/// Shares below which a row counts as closed.
const CLOSED: f64 = 1e-12;

/// A question about the exchange in an enclosure, with its known answer.
#[derive(Clone, Debug)]
pub struct ExchangeCase {
    /// The enclosure with its properties.
    pub enclosure: Arc<KnownEnclosure>,
    /// What is asked of it, and the answer.
    pub problem: EnclosureQuestion,
}

/// What is asked of an enclosure, with the known answer.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnclosureQuestion {
    /// Short name, unique.
    pub id: String,
    /// What is asked, for reports. Rows count from 1.
    asks: String,
    /// What is asked. Rows count from 0.
    pub question: ExchangeQuestion,
    /// What is known of each row, where temperatures or fluxes are asked for.
    #[serde(default)]
    pub given: Vec<GivenRow>,
    /// The sun's irradiation of each row, W/m²; none for a dark sky.
    #[serde(default)]
    pub sun: Vec<f64>,
    /// Temperature of the sky, K.
    #[serde(default)]
    pub sky: f64,
    /// The known answer, in the unit of the question.
    pub truth: f64,
    /// The formula, rule or book that the truth follows.
    pub source: String,
}

/// Surfaces, each a row, with factors from each to those from it on. What rows lack goes to the sky.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct KnownEnclosure {
    /// The enclosure with its properties, for reports. Rows count from 1.
    about: String,
    /// Areas, m²; of infinitely long enclosures per metre.
    pub areas: Vec<f64>,
    /// Emissivities of a grey enclosure.
    pub emissivity: Vec<f64>,
    /// Mirror reflectances, 0 if there are none; what is left of 1 is reflected diffusely.
    pub mirror: Vec<f64>,
    /// F^s from each row to itself and to those after it.
    pub factors: Vec<Vec<f64>>,
    /// Emissivities in bands, of an enclosure that is not grey.
    pub bands: Vec<KnownBand>,
    /// The enclosures of two rows that make this one, which exchanges heat through all of them in turn.
    pub gaps: Vec<KnownEnclosure>,
    /// What is asked.
    case: Vec<EnclosureQuestion>,
}

/// Emissivities of rows in a band.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownBand {
    /// Wavelengths.
    pub range: KnownRange,
    /// Emissivities.
    pub emissivity: Vec<f64>,
}

/// Wavelengths of a band.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum KnownRange {
    /// All, by name.
    Named(RangeName),
    /// Between two, µm.
    Between([f64; 2]),
}

/// A range with a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RangeName {
    /// What surfaces emit.
    Thermal,
    /// What the sun emits.
    Solar,
}

/// What is known of a row.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub enum GivenRow {
    /// Its temperature, K.
    #[serde(rename = "T")]
    Temperature(f64),
    /// The flux that it gives off, W/m².
    #[serde(rename = "q")]
    Flux(f64),
}

/// What is asked of an enclosure.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ExchangeQuestion {
    /// F^s between two rows, extended by mirrors. The solver has no part in it.
    Factor([usize; 2]),
    /// F^s from a row to the sky.
    ToSpace(usize),
    /// Gebhart's absorption factor B.
    Gebhart([usize; 2]),
    /// The transfer factor, script-F.
    ScriptF([usize; 2]),
    /// A conductance GR, m²; of infinitely long enclosures per metre, m²/m.
    Conductance([usize; 2]),
    /// The sum of GR from a row to all rows.
    AllConductances(usize),
    /// Emissivity of an opening of this area, m², through which all rows see the sky.
    Opening(f64),
    /// GR between rows 0 and 1 with all others adiabatic, where the first has this area, m².
    Reradiating(f64),
    /// The flux that a row gives off, W/m², or rows that are alike.
    Flux(Vec<usize>),
    /// The irradiation of a row, W/m².
    Irradiation(usize),
    /// The temperature of a row, K.
    Temperature(usize),
    /// GR through all gaps.
    ConductanceOfGaps(bool),
    /// The flux through all gaps between these temperatures, W/m².
    FluxThroughGaps([f64; 2]),
    /// The temperature before the first gap, K.
    TemperatureBeforeGaps {
        /// The flux through all of them, W/m².
        flux: f64,
        /// The temperature behind the last, K.
        last: f64,
    },
    /// Share of a black body's emission in a band.
    Emitted {
        /// Wavelengths, µm.
        range: [f64; 2],
        /// Its temperature, K.
        temperature: f64,
    },
}

impl ExchangeQuestion {
    /// The unit of answers; `1` for ratios.
    pub fn unit(&self) -> &'static str {
        match self {
            ExchangeQuestion::Conductance(_)
            | ExchangeQuestion::AllConductances(_)
            | ExchangeQuestion::ConductanceOfGaps(_)
            | ExchangeQuestion::Reradiating(_) => "m²",
            ExchangeQuestion::Temperature(_) | ExchangeQuestion::TemperatureBeforeGaps { .. } => {
                "K"
            }
            ExchangeQuestion::Flux(_)
            | ExchangeQuestion::Irradiation(_)
            | ExchangeQuestion::FluxThroughGaps(_) => "W/m²",
            _ => "1",
        }
    }
}

/// All cases, in a fixed order.
pub fn exchange_cases() -> Vec<ExchangeCase> {
    let files = [
        include_str!("../../data/exchange/plates.toml"),
        include_str!("../../data/exchange/round.toml"),
        include_str!("../../data/exchange/ducts.toml"),
        include_str!("../../data/exchange/boxes.toml"),
        include_str!("../../data/exchange/spectra.toml"),
    ];
    files.into_iter().flat_map(read).collect()
}

/// The cases of a file that is part of the program.
fn read(text: &str) -> Vec<ExchangeCase> {
    #[derive(Deserialize)]
    struct EnclosureFile {
        enclosure: Vec<KnownEnclosure>,
    }
    let file: EnclosureFile = toml::from_str(text).expect("tests have read this file");
    let cases = |mut enclosure: KnownEnclosure| {
        let questions = std::mem::take(&mut enclosure.case);
        let enclosure = Arc::new(enclosure);
        let case = move |problem| ExchangeCase {
            enclosure: enclosure.clone(),
            problem,
        };
        questions.into_iter().map(case)
    };
    file.enclosure.into_iter().flat_map(cases).collect()
}

impl ExchangeCase {
    /// The enclosure with its properties, and what is asked, for reports. Rows count from 1.
    pub fn description(&self) -> String {
        format!("{}: {}", self.enclosure.about, self.problem.asks)
    }

    /// How far an answer may be off, in its unit: ten digits of the truth, for temperatures 1e-8 K.
    pub fn tolerance(&self) -> f64 {
        match self.problem.question.unit() {
            "K" => 1e-8,
            _ => 1e-10 * self.problem.truth.abs(),
        }
    }

    /// The answer of the solver, in the unit of the question.
    ///
    /// # Errors
    /// [`ExchangeError`] if the solver finds no solution, which no case is made for.
    pub fn ask(&self) -> Result<f64, ExchangeError> {
        let enclosure = &*self.enclosure;
        match &self.problem.question {
            ExchangeQuestion::Factor([i, j]) => {
                Ok(enclosure.solvable().factors.get(*i, *j as u32).0)
            }
            ExchangeQuestion::ToSpace(i) => Ok(enclosure.solvable().factors.rest[*i].sky),
            ExchangeQuestion::Gebhart([i, j]) => Ok(enclosure.exchange()?.gebhart(*i, *j).0),
            ExchangeQuestion::ScriptF([i, j]) => Ok(enclosure.exchange()?.script_f(*i, *j).0),
            ExchangeQuestion::Conductance([i, j]) => enclosure.conductance(*i, *j),
            ExchangeQuestion::AllConductances(i) => {
                let exchange = enclosure.exchange()?;
                let rows = 0..enclosure.areas.len();
                Ok(rows.map(|j| exchange.conductance(*i, j).0).sum())
            }
            ExchangeQuestion::Opening(area) => {
                let (exchange, sky) = (enclosure.exchange()?, enclosure.areas.len());
                let through: f64 = (0..sky).map(|i| exchange.conductance(i, sky).0).sum();
                Ok(through / area)
            }
            ExchangeQuestion::Reradiating(area) => enclosure.through_reradiating(*area),
            ExchangeQuestion::Flux(rows) => {
                let fluxes = self.heat()?.fluxes;
                let is_alike = |&i: &usize| (fluxes[i] - fluxes[rows[0]]).abs() < 1e-9;
                Ok(if rows.iter().all(is_alike) {
                    fluxes[rows[0]]
                } else {
                    f64::NAN
                })
            }
            ExchangeQuestion::Irradiation(i) => Ok(self.heat()?.irradiations[*i]),
            ExchangeQuestion::Temperature(i) => Ok(self.heat()?.temperatures[*i]),
            ExchangeQuestion::ConductanceOfGaps(_) => enclosure.conductance_of_gaps(),
            ExchangeQuestion::FluxThroughGaps([t1, t2]) => {
                let between = t1.powi(4) - t2.powi(4);
                Ok(STEFAN_BOLTZMANN * between * enclosure.conductance_of_gaps()?)
            }
            ExchangeQuestion::TemperatureBeforeGaps { flux, last } => {
                let given =
                    |cold: f64| [RowCondition::Flux(*flux), RowCondition::Temperature(cold)];
                let before = |cold: f64, gap: &KnownEnclosure| {
                    Ok(gap.heat(&given(cold), &[], 0.0)?.temperatures[0])
                };
                enclosure.gaps.iter().rev().try_fold(*last, before)
            }
            ExchangeQuestion::Emitted { range, temperature } => {
                Ok(SpectralRange::Between(range[0], range[1]).share(*temperature))
            }
        }
    }

    /// Temperatures and fluxes, from what is given.
    fn heat(&self) -> Result<HeatBalance, ExchangeError> {
        let problem = &self.problem;
        let conditions: Vec<RowCondition> = problem.given.iter().map(|&row| row.into()).collect();
        self.enclosure.heat(&conditions, &problem.sun, problem.sky)
    }
}

impl KnownEnclosure {
    /// Mirror reflectance of a row.
    pub fn mirror_of(&self, row: usize) -> f64 {
        self.mirror.get(row).copied().unwrap_or(0.0)
    }

    /// F^s from a row to any.
    pub fn factor(&self, i: usize, j: usize) -> f64 {
        let (low, high) = (i.min(j), i.max(j));
        self.factors[low][high - low] * self.areas[low] / self.areas[i]
    }

    /// The enclosure as the solver takes it.
    fn solvable(&self) -> Enclosure {
        let n = self.areas.len();
        let row = |i: usize| {
            let entry = |j: usize| Exchange {
                column: j as u32,
                value: self.areas[i] * self.factors[i][j - i],
                error: 0.0,
            };
            (i..n).map(entry).collect::<Vec<Exchange>>()
        };
        let factors = FormFactors {
            exchange: (0..n).map(row).collect(),
            areas: self.areas.clone(),
            rest: (0..n).map(|i| self.remainder(i)).collect(),
            ends: (0..n).map(|i| 1.0 - self.mirror_of(i)).collect(),
            ..FormFactors::default()
        };
        let rows = RowTable {
            names: (0..n).map(|i| i.to_string()).collect(),
            ..RowTable::default()
        };
        Enclosure {
            factors,
            rows,
            outside: None,
            sky: None,
            elsewhere: None,
        }
    }

    /// What leaves the scene from a row.
    fn remainder(&self, i: usize) -> RowRemainder {
        let ends = |j: usize| self.factor(i, j) * (1.0 - self.mirror_of(j));
        let ended: f64 = (0..self.areas.len()).map(ends).sum();
        let is_open = 1.0 - ended > CLOSED;
        RowRemainder {
            sky: if is_open { 1.0 - ended } else { 0.0 },
            ..RowRemainder::default()
        }
    }

    /// Exchange factors between rows, and the sky after them.
    fn exchange(&self) -> Result<ExchangeFactors, ExchangeError> {
        let enclosure = self.solvable();
        let band = SurfaceBand {
            enclosure: &enclosure,
            range: SpectralRange::Thermal,
            emissivity: self.emissivity.clone(),
        };
        exchange_factors(&band, &nodes(self.areas.len()), &Progress::new())
    }

    fn conductance(&self, i: usize, j: usize) -> Result<f64, ExchangeError> {
        Ok(self.exchange()?.conductance(i, j).0)
    }

    /// GR between rows 0 and 1 with all others adiabatic, from the heat at 400 and 300 K.
    fn through_reradiating(&self, area: f64) -> Result<f64, ExchangeError> {
        let (hot, cold) = (400f64, 300f64);
        let mut given = vec![RowCondition::Flux(0.0); self.areas.len()];
        given[0] = RowCondition::Temperature(hot);
        given[1] = RowCondition::Temperature(cold);
        let flux = self.heat(&given, &[], 0.0)?.fluxes[0];
        Ok(area * flux / (STEFAN_BOLTZMANN * (hot.powi(4) - cold.powi(4))))
    }

    /// GR of all gaps: their resistances are added.
    fn conductance_of_gaps(&self) -> Result<f64, ExchangeError> {
        let gaps = self.gaps.iter().map(|gap| gap.conductance(0, 1));
        let gaps: Vec<f64> = gaps.collect::<Result<_, _>>()?;
        Ok(1.0 / gaps.iter().map(|g| 1.0 / g).sum::<f64>())
    }

    /// Temperatures and fluxes under a black sky of a temperature in kelvin.
    fn heat(
        &self,
        conditions: &[RowCondition],
        sun: &[f64],
        sky: f64,
    ) -> Result<HeatBalance, ExchangeError> {
        let enclosure = self.solvable();
        let band = |range, emissivity: &[f64]| SurfaceBand {
            enclosure: &enclosure,
            range,
            emissivity: emissivity.to_vec(),
        };
        let bands = self.bands.iter();
        let mut bands: Vec<SurfaceBand> = bands
            .map(|known| band(known.range.into(), &known.emissivity))
            .collect();
        if bands.is_empty() {
            bands.push(band(SpectralRange::Thermal, &self.emissivity));
        }
        let problem = HeatProblem {
            bands: &bands,
            conditions,
            surroundings: [sky, 0.0],
            solar: sun,
        };
        heat_balance(&problem, &nodes(conditions.len()), &Progress::new())
    }
}

impl From<GivenRow> for RowCondition {
    fn from(row: GivenRow) -> RowCondition {
        match row {
            GivenRow::Temperature(t) => RowCondition::Temperature(t),
            GivenRow::Flux(q) => RowCondition::Flux(q),
        }
    }
}

impl From<KnownRange> for SpectralRange {
    fn from(range: KnownRange) -> SpectralRange {
        match range {
            KnownRange::Named(RangeName::Thermal) => SpectralRange::Thermal,
            KnownRange::Named(RangeName::Solar) => SpectralRange::Solar,
            KnownRange::Between([low, high]) => SpectralRange::Between(low, high),
        }
    }
}

/// Each row a node.
fn nodes(count: usize) -> Groups {
    Groups {
        of_rows: (0..count as u32).map(Some).collect(),
        names: (0..count).map(|i| i.to_string()).collect(),
    }
}
