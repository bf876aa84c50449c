//! Tables that programs have as numbers, without a file.

use super::TableError;
use super::names::RecordNames;
use super::records::{NamedRecord, TableCell};
use crate::enclosure::Enclosure;

/// A name with numbers by column.
pub type NumberRecord = (String, Vec<(String, f64)>);

/// Records of numbers; `place` begins the sentences about them.
pub(super) fn records(numbers: &[NumberRecord], place: &str) -> Vec<NamedRecord> {
    let record = |(name, fields): &NumberRecord| NamedRecord {
        name: name.clone(),
        place: place.to_owned(),
        fields: (fields.iter())
            .map(|(column, x)| (column.clone(), TableCell::Number(*x)))
            .collect(),
    };
    numbers.iter().map(record).collect()
}

/// One number for the rows that a name is of, by the same rules as records of tables.
#[derive(Clone, Debug)]
pub struct NamedValues {
    names: RecordNames,
    values: Vec<f64>,
}

impl NamedValues {
    /// Values by name; `what` they are begins the sentences about them.
    ///
    /// # Errors
    /// A name that is there twice, a number that is not finite.
    pub fn new(values: &[(String, f64)], what: &str) -> Result<NamedValues, TableError> {
        let field = |(name, x): &(String, f64)| (name.clone(), vec![(what.to_owned(), *x)]);
        let numbers: Vec<NumberRecord> = values.iter().map(field).collect();
        let records = records(&numbers, what);
        for record in &records {
            record.number(what)?;
        }
        Ok(NamedValues {
            names: RecordNames::new(&records)?,
            values: values.iter().map(|(_, x)| *x).collect(),
        })
    }

    /// The value of each row that has one.
    pub fn of_rows(&self, enclosure: &Enclosure) -> Vec<Option<f64>> {
        let records = self.names.records(enclosure);
        let value = |k: &Option<usize>| k.map(|k| self.values[k]);
        records.iter().map(value).collect()
    }

    /// Names that no row has.
    pub fn unused(&self, enclosure: &Enclosure) -> Vec<&str> {
        self.names.unused(enclosure)
    }
}
