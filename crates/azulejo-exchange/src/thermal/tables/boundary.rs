//! Temperatures and fluxes.

use super::TableError;
use super::names::RecordNames;
use super::numbers::{self, NumberRecord};
use super::records::{NamedRecord, records};
use crate::enclosure::Enclosure;
use crate::thermal::network::RowCondition;

/// What is known of surfaces and of what surrounds them, by name.
///
/// | column | meaning |
/// |---|---|
/// | `name` | an object, material, face or row, `*` and `?` are allowed; or `space`, `sky`, `ground` |
/// | `T` | temperature, K; or `T_C`, °C |
/// | `q` | net heat that leaves by radiation, W/m²; 0 for adiabatic surfaces |
/// | `solar` | sunlight that falls on it from outside, W/m², instead of that of the matrix |
#[derive(Clone, Debug)]
pub struct BoundaryTable {
    names: RecordNames,
    records: Vec<BoundaryRecord>,
    /// Temperatures of sky and ground, K, as far as the table has them.
    pub surroundings: [Option<f64>; 2],
}

/// What is said under one name.
#[derive(Clone, Copy, Debug)]
struct BoundaryRecord {
    condition: RowCondition,
    solar: Option<f64>,
}

/// What is known of all rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conditions {
    /// Temperature or flux of each row.
    pub rows: Vec<RowCondition>,
    /// Sunlight on each row, where the table says so, W/m².
    pub solar: Vec<Option<f64>>,
}

/// 0 °C in kelvin.
const ZERO_CELSIUS: f64 = 273.15;

impl BoundaryTable {
    /// Reads a table as CSV, TSV or TOML.
    ///
    /// # Errors
    /// The place, what was found, what was expected.
    pub fn read(text: &str) -> Result<BoundaryTable, TableError> {
        let (around, surfaces): (Vec<NamedRecord>, Vec<NamedRecord>) =
            records(text)?.into_iter().partition(is_surroundings);
        BoundaryTable::new(&around, &surfaces)
    }

    /// A table of numbers by name and column. All names are those of surfaces, which may be called `sky`
    /// or `ground` here.
    ///
    /// # Errors
    /// The name, what was found, what was expected.
    pub fn from_numbers(numbers: &[NumberRecord]) -> Result<BoundaryTable, TableError> {
        BoundaryTable::new(&[], &numbers::records(numbers, "conditions"))
    }

    fn new(around: &[NamedRecord], surfaces: &[NamedRecord]) -> Result<BoundaryTable, TableError> {
        let mut surroundings = [None; 2];
        for record in around {
            let t = temperature(record)?;
            let t = t.ok_or_else(|| record.wrong("T", "missing", "a temperature in kelvin"))?;
            match record.name.as_str() {
                "sky" => surroundings[0] = Some(t),
                "ground" => surroundings[1] = Some(t),
                _ => surroundings = surroundings.map(|known| known.or(Some(t))),
            }
        }
        Ok(BoundaryTable {
            names: RecordNames::new(surfaces)?,
            records: surfaces.iter().map(boundary).collect::<Result<_, _>>()?,
            surroundings,
        })
    }

    /// What is known of each row.
    ///
    /// # Errors
    /// The names of rows that have no record.
    pub fn of_rows(&self, enclosure: &Enclosure) -> Result<Conditions, TableError> {
        let needed = "temperature or flux (T, or q)";
        let records = self.names.required_records(enclosure, needed)?;
        let records = || records.iter().map(|&k| &self.records[k]);
        Ok(Conditions {
            rows: records().map(|r| r.condition).collect(),
            solar: records().map(|r| r.solar).collect(),
        })
    }

    /// Names that no row has.
    pub fn unused(&self, enclosure: &Enclosure) -> Vec<&str> {
        self.names.unused(enclosure)
    }
}

fn is_surroundings(record: &NamedRecord) -> bool {
    ["space", "sky", "ground"].contains(&record.name.as_str())
}

/// The temperature of a record in kelvin.
fn temperature(record: &NamedRecord) -> Result<Option<f64>, TableError> {
    let (column, zero) = match (record.number("T")?, record.number("T_C")?) {
        (Some(t), Some(_)) => {
            return Err(record.wrong("T", t, "no T beside T_C: one of them"));
        }
        (Some(_), None) => ("T", 0.0),
        (None, _) => ("T_C", ZERO_CELSIUS),
    };
    match record.number(column)?.map(|t| (t, t + zero)) {
        Some((given, kelvin)) if kelvin < 0.0 => {
            Err(record.wrong(column, given, format_args!("at least {}", 0.0 - zero)))
        }
        known => Ok(known.map(|(_, kelvin)| kelvin)),
    }
}

fn boundary(record: &NamedRecord) -> Result<BoundaryRecord, TableError> {
    const COLUMNS: [&str; 5] = ["T", "T_C", "q", "adiabatic", "solar"];
    if let Some((column, _)) = record
        .fields
        .iter()
        .find(|(c, _)| !COLUMNS.contains(&c.as_str()))
    {
        return Err(TableError::new(format_args!(
            "{}: there is no column \"{column}\"; there are T, T_C, q and solar",
            record.place
        )));
    }
    let adiabatic = record
        .number("adiabatic")?
        .filter(|&x| x != 0.0)
        .map(|_| 0.0);
    let flux = record.number("q")?.or(adiabatic);
    let condition = match (temperature(record)?, flux) {
        (Some(t), None) => RowCondition::Temperature(t),
        (None, Some(q)) => RowCondition::Flux(q),
        (Some(_), Some(_)) => return Err(record.wrong("T", "given beside q", "one of them")),
        (None, None) => return Err(record.wrong("T", "missing", "T in kelvin, or q in W/m²")),
    };
    let solar = record.number("solar")?;
    match solar {
        Some(e) if e < 0.0 => Err(record.wrong("solar", e, "0 or more, in W/m²")),
        solar => Ok(BoundaryRecord { condition, solar }),
    }
}
