//! Temperatures, fluxes and sunlight of rows.

use crate::error::refused;
use azulejo_exchange::thermal::tables::{BoundaryTable, Conditions, NamedValues};
use azulejo_exchange::{Enclosure, RowCondition};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

/// Numbers by name, or one for each row, NaN where it has none.
#[derive(FromPyObject)]
pub enum RowValues<'py> {
    /// By name; `*` and `?` are allowed.
    Named(Vec<(String, f64)>),
    /// For each row.
    Each(PyReadonlyArray1<'py, f64>),
}

/// What is known of rows, and of sky and ground, K.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ConditionArgs<'py> {
    temperatures: Option<RowValues<'py>>,
    fluxes: Option<RowValues<'py>>,
    solar: Option<RowValues<'py>>,
    /// Of sky and ground.
    pub surroundings: [Option<f64>; 2],
}

impl ConditionArgs<'_> {
    /// The conditions of all rows.
    pub fn of_rows(&self, enclosure: &Enclosure, notes: &mut Vec<String>) -> PyResult<Conditions> {
        let mut conditions = match (&self.temperatures, &self.fluxes) {
            (None | Some(RowValues::Named(_)), None | Some(RowValues::Named(_))) => {
                self.of_names(enclosure, notes)?
            }
            _ => self.of_arrays(enclosure, notes)?,
        };
        if let Some(solar) = &self.solar {
            conditions.solar = values(solar, enclosure, "solar", notes)?;
            let is_bad = |e: &&f64| **e < 0.0;
            if let Some(e) = conditions.solar.iter().flatten().find(is_bad) {
                return Err(refused(format_args!(
                    "solar is {e}, expected 0 or more, in W/m²"
                )));
            }
        }
        Ok(conditions)
    }

    /// As those of a table.
    fn of_names(&self, enclosure: &Enclosure, notes: &mut Vec<String>) -> PyResult<Conditions> {
        let mut records: Vec<(String, Vec<(String, f64)>)> = Vec::new();
        for (column, given) in [("T", &self.temperatures), ("q", &self.fluxes)] {
            let Some(RowValues::Named(given)) = given else {
                continue;
            };
            for (name, x) in given {
                let field = (column.to_owned(), *x);
                match records.iter_mut().find(|(known, _)| known == name) {
                    Some((_, fields)) => fields.push(field),
                    None => records.push((name.clone(), vec![field])),
                }
            }
        }
        let table = BoundaryTable::from_numbers(&records).map_err(refused)?;
        note_unused(&table.unused(enclosure), "T, q", notes);
        table.of_rows(enclosure).map_err(refused)
    }

    fn of_arrays(&self, enclosure: &Enclosure, notes: &mut Vec<String>) -> PyResult<Conditions> {
        let none = || vec![None; enclosure.len()];
        let mut of = |given: &Option<RowValues>, what: &str| match given {
            Some(given) => values(given, enclosure, what, notes),
            None => Ok(none()),
        };
        let (temperatures, fluxes) = (of(&self.temperatures, "T")?, of(&self.fluxes, "q")?);
        let condition = |(i, (t, q)): (usize, (Option<f64>, Option<f64>))| {
            let name = &enclosure.rows.names[i];
            match (t, q) {
                (Some(t), None) if t < 0.0 => Err(refused(format_args!(
                    "T of row {i} (\"{name}\") is {t}, expected 0 K or more"
                ))),
                (Some(t), None) => Ok(RowCondition::Temperature(t)),
                (None, Some(q)) => Ok(RowCondition::Flux(q)),
                (Some(_), Some(_)) => Err(refused(format_args!(
                    "row {i} (\"{name}\") has T and q, expected one of them: NaN stands for none"
                ))),
                (None, None) => Err(refused(format_args!(
                    "row {i} (\"{name}\") has neither T nor q, expected one of them"
                ))),
            }
        };
        let rows = temperatures.into_iter().zip(fluxes).enumerate();
        Ok(Conditions {
            rows: rows.map(condition).collect::<PyResult<_>>()?,
            solar: none(),
        })
    }
}

/// The value of each row that has one.
fn values(
    given: &RowValues,
    enclosure: &Enclosure,
    what: &str,
    notes: &mut Vec<String>,
) -> PyResult<Vec<Option<f64>>> {
    match given {
        RowValues::Named(given) => {
            let named = NamedValues::new(given, what).map_err(refused)?;
            note_unused(&named.unused(enclosure), what, notes);
            Ok(named.of_rows(enclosure))
        }
        RowValues::Each(array) => {
            let array = array.as_array();
            if array.len() != enclosure.len() {
                return Err(refused(format_args!(
                    "{what} has {} values for {} rows",
                    array.len(),
                    enclosure.len()
                )));
            }
            if let Some(x) = array.iter().find(|x| x.is_infinite()) {
                return Err(refused(format_args!(
                    "{what} is {x}, expected finite numbers"
                )));
            }
            let value = |&x: &f64| (!x.is_nan()).then_some(x);
            Ok(array.iter().map(value).collect())
        }
    }
}

fn note_unused(unused: &[&str], what: &str, notes: &mut Vec<String>) {
    if !unused.is_empty() {
        let names = unused.join("\", \"");
        notes.push(format!("{what}: no row has the name \"{names}\""));
    }
}
