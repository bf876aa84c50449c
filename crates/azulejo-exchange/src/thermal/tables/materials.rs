//! Emissivities and mirror reflectances.

use super::TableError;
use super::names::RecordNames;
use super::numbers::{self, NumberRecord};
use super::records::{NamedRecord, records};
use crate::enclosure::Enclosure;
use crate::thermal::bands::SpectralRange;

/// What surfaces emit and reflect, by name and band.
///
/// | column | meaning |
/// |---|---|
/// | `name` | an object, material, face (`object/3`) or row; `*` and `?` are allowed |
/// | `eps` | emissivity at all wavelengths, or `eps@8-14` between two, in micrometres; `0` and `inf` are allowed |
/// | `alpha` | absorptance of sunlight |
/// | `rho_s` | mirror reflectance (0), or `rho_s@8-14`, `rho_s@solar` in one band |
///
/// What is neither absorbed nor mirrored is reflected diffusely: ρ_d = 1 − ε − ρ_s.
#[derive(Clone, Debug)]
pub struct MaterialTable {
    pub(super) names: RecordNames,
    /// The bands, the solar one last.
    pub bands: Vec<TableBand>,
}

/// A band with the properties of each record.
#[derive(Clone, Debug, PartialEq)]
pub struct TableBand {
    /// Its wavelengths.
    pub range: SpectralRange,
    pub(super) records: Vec<Properties>,
}

/// Properties of a surface in a band.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Properties {
    /// Emissivity, which is absorptance, 0..1.
    pub emissivity: f64,
    /// Mirror reflectance, 0..1 − `emissivity`.
    pub mirror: f64,
}

/// Rounding that sums of properties may have.
const ROUNDING: f64 = 1e-9;

impl MaterialTable {
    /// Reads a table as CSV, TSV or TOML.
    ///
    /// # Errors
    /// The place, what was found, what was expected.
    pub fn read(text: &str) -> Result<MaterialTable, TableError> {
        MaterialTable::new(&records(text)?)
    }

    /// A table of numbers by name and column.
    ///
    /// # Errors
    /// The name, what was found, what was expected.
    pub fn from_numbers(numbers: &[NumberRecord]) -> Result<MaterialTable, TableError> {
        MaterialTable::new(&numbers::records(numbers, "materials"))
    }

    fn new(records: &[NamedRecord]) -> Result<MaterialTable, TableError> {
        let names = RecordNames::new(records)?;
        let ranges = ranges(records)?;
        let band = |range: SpectralRange| -> Result<TableBand, TableError> {
            let records = records.iter().map(|record| properties(record, range));
            Ok(TableBand {
                range,
                records: records.collect::<Result<_, _>>()?,
            })
        };
        Ok(MaterialTable {
            bands: ranges.into_iter().map(band).collect::<Result<_, _>>()?,
            names,
        })
    }

    /// For each band the properties of each row.
    ///
    /// # Errors
    /// The names of rows that have no record.
    pub fn of_rows(&self, enclosure: &Enclosure) -> Result<Vec<Vec<Properties>>, TableError> {
        let records = self.names.required_records(enclosure, "the emissivity")?;
        let band = |band: &TableBand| records.iter().map(|&k| band.records[k]).collect();
        Ok(self.bands.iter().map(band).collect())
    }

    /// Names that no row has.
    pub fn unused(&self, enclosure: &Enclosure) -> Vec<&str> {
        self.names.unused(enclosure)
    }
}

/// The bands that columns name.
fn ranges(records: &[NamedRecord]) -> Result<Vec<SpectralRange>, TableError> {
    let mut thermal: Vec<SpectralRange> = Vec::new();
    let mut solar = false;
    for record in records {
        for (column, _) in &record.fields {
            let (quantity, band) = column.split_once('@').unwrap_or((column, ""));
            let range = match (quantity, band) {
                ("alpha", "") => SpectralRange::Solar,
                ("eps", "") => SpectralRange::Thermal,
                ("rho_s", "") | ("rho_s", "solar") => continue,
                ("eps" | "rho_s", band) => between(record, column, band)?,
                _ => {
                    return Err(TableError::new(format_args!(
                        "{}: there is no column \"{column}\"; there are eps, alpha, rho_s, and eps and rho_s \
                         in a band, as in eps@8-14",
                        record.place
                    )));
                }
            };
            match range {
                SpectralRange::Solar => solar = true,
                _ if thermal.contains(&range) => {}
                _ => thermal.push(range),
            }
        }
    }
    check_cover(&mut thermal)?;
    thermal.extend(solar.then_some(SpectralRange::Solar));
    Ok(thermal)
}

/// A band as columns name it.
fn between(record: &NamedRecord, column: &str, band: &str) -> Result<SpectralRange, TableError> {
    let ends = band.split_once('-').and_then(|(low, high)| {
        let low: f64 = low.trim().parse().ok()?;
        let high: f64 = high.trim().parse().ok()?;
        (low >= 0.0 && low < high).then_some(SpectralRange::Between(low, high))
    });
    ends.ok_or_else(|| {
        TableError::new(format_args!(
            "{}: the band of \"{column}\" is not a range of wavelengths in micrometres, as in eps@8-14 or \
             eps@4-inf",
            record.place
        ))
    })
}

/// Bands must follow one another from 0 to infinity, or there is a single one for all.
fn check_cover(bands: &mut [SpectralRange]) -> Result<(), TableError> {
    if bands.is_empty() {
        return Err(TableError::new(
            "there is no emissivity, expected a column `eps` with a number in every record",
        ));
    }
    // One emissivity for all wavelengths is enough, but cannot stand beside those of bands.
    if bands == [SpectralRange::Thermal] {
        return Ok(());
    }
    let ends = |band: &SpectralRange| match band {
        SpectralRange::Between(low, high) => Some((*low, *high)),
        _ => None,
    };
    if bands.iter().any(|b| ends(b).is_none()) {
        return Err(TableError::new(
            "there is eps for all wavelengths beside eps of bands, expected one or the other",
        ));
    }
    // In order, each band has to begin where the one before ends.
    bands.sort_by(|a, b| {
        ends(a)
            .partial_cmp(&ends(b))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut next = 0.0;
    for (low, high) in bands.iter().filter_map(ends) {
        if low != next {
            return Err(TableError::new(format_args!(
                "bands leave a gap or overlap between {} and {} µm, expected them to follow one another from 0 to \
                 inf",
                low.min(next),
                low.max(next)
            )));
        }
        next = high;
    }
    // The last band has to reach infinity, so that no emission is left out.
    if next.is_finite() {
        return Err(TableError::new(format_args!(
            "bands end at {next} µm, expected a last one to inf, as in eps@{next}-inf"
        )));
    }
    Ok(())
}

/// The column of a record that is written as this one, or has the same wavelengths, as eps@0.0-4 has those
/// of eps@0-4.
fn own_column(record: &NamedRecord, column: &str, range: SpectralRange) -> String {
    let quantity = column.split_once('@').map_or("", |(quantity, _)| quantity);
    let is_same = |other: &str| {
        let (what, band) = other.split_once('@').unwrap_or((other, ""));
        what == quantity && between(record, other, band).is_ok_and(|r| r == range)
    };
    let mut columns = record.fields.iter().map(|(other, _)| other);
    let same = columns.find(|other| is_same(other));
    same.map_or_else(|| column.to_owned(), Clone::clone)
}

/// The properties of a record in a band.
fn properties(record: &NamedRecord, range: SpectralRange) -> Result<Properties, TableError> {
    let (column, own_mirror) = match range {
        SpectralRange::Thermal => ("eps".to_owned(), "rho_s".to_owned()),
        SpectralRange::Solar => ("alpha".to_owned(), "rho_s@solar".to_owned()),
        range => (format!("eps@{range}"), format!("rho_s@{range}")),
    };
    let share = |column: &str| -> Result<Option<f64>, TableError> {
        match record.number(&own_column(record, column, range))? {
            Some(x) if !(0.0..=1.0).contains(&x) => Err(record.wrong(column, x, "0 to 1")),
            share => Ok(share),
        }
    };
    let emissivity = share(&column)?;
    let emissivity = emissivity.ok_or_else(|| {
        TableError::new(format_args!(
            "{}: \"{}\" has no {column}, expected a number from 0 to 1",
            record.place, record.name
        ))
    })?;
    let mirror = match share(&own_mirror)? {
        Some(mirror) => mirror,
        None => share("rho_s")?.unwrap_or(0.0),
    };
    let sum = emissivity + mirror;
    if sum > 1.0 + ROUNDING {
        return Err(record.wrong(&format!("{column} + {own_mirror}"), sum, "at most 1"));
    }
    Ok(Properties {
        emissivity,
        mirror: if sum > 1.0 { 1.0 - emissivity } else { mirror },
    })
}
