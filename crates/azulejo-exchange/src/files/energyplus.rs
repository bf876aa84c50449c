//! EnergyPlus' `ZoneProperty:UserViewFactors:BySurfaceName`, of version 9.4 and later.

use super::direct::DirectFactors;
use super::text::{DIGITS, general, json};
use super::{FactorFileError, FactorFiles, FileOptions, notes};
use crate::enclosure::{Enclosure, Groups};
use azulejo_scene::Zone;
use std::borrow::Cow;
use std::io::{self, Write};
use std::sync::Arc;

const OBJECT: &str = "ZoneProperty:UserViewFactors:BySurfaceName";

/// Names of EnergyPlus have no more characters.
const LONGEST: usize = 100;

/// Rows up to which it makes rows reciprocal, but not closed.
const SMALL: usize = 3;

/// Most of the light of a surface that ends on what has no place.
const MOST_MASS: f64 = 0.9;

/// The object of one zone.
pub(super) struct SurfaceFactors {
    zone: String,
    /// Of surfaces, followed by those of internal masses.
    names: Vec<String>,
    factors: DirectFactors<'static>,
    /// Areas of internal masses, in square units of the model.
    masses: Vec<f64>,
}

pub(super) fn prepare<'a>(
    enclosure: &'a Enclosure,
    options: &'a FileOptions,
    write: fn(&[SurfaceFactors], &mut dyn Write) -> io::Result<()>,
) -> Result<FactorFiles<'a>, FactorFileError> {
    let zones = zones(enclosure, options.zone.as_deref())?;
    let (mut objects, mut notes) = (Vec::new(), Vec::new());
    let names = notes::row_names(enclosure);
    for (zone, rows) in &zones {
        let mut of_rows = vec![None; enclosure.len()];
        (0..).zip(rows).for_each(|(k, &row)| of_rows[row] = Some(k));
        let of_zone = enclosure.grouped(&Groups {
            of_rows,
            names: rows.iter().map(|&row| names[row].to_string()).collect(),
        });
        let several = zones.len() > 1;
        let about = about_zone(&of_zone).into_iter();
        notes.extend(about.map(|note| {
            if several {
                format!("{}: {note}", zone.name)
            } else {
                note
            }
        }));
        objects.push(surface_factors(zone, of_zone)?);
    }
    if enclosure.rows.zones.is_empty() && options.zone.is_none() {
        notes.push("the zone is named Zone: the option zone gives it that of the model".to_owned());
    }
    let mut files = FactorFiles::single(move |out| write(&objects, out));
    files.notes = notes;
    Ok(files)
}

/// A zone with its rows.
type ZoneRows = (Arc<Zone>, Vec<usize>);

/// The zones to write, each with its rows: those of the model, or all rows as one.
fn zones(enclosure: &Enclosure, zone_name: Option<&str>) -> Result<Vec<ZoneRows>, FactorFileError> {
    let (rows, faces) = (&enclosure.rows, &enclosure.factors.faces);
    if rows.zones.is_empty() {
        let name = zone_name.unwrap_or("Zone").to_owned();
        let zone = Zone {
            name,
            masses: Vec::new(),
        };
        return Ok(vec![(Arc::new(zone), (0..enclosure.len()).collect())]);
    }
    let mut zones: Vec<ZoneRows> = Vec::new();
    // What only shades is in no zone, and exchanges no heat.
    for (row, face) in faces.iter().enumerate() {
        let Some(zone) = rows.zone(*face) else {
            continue;
        };
        match zones.iter_mut().find(|(known, _)| known.name == zone.name) {
            Some((_, members)) => members.push(row),
            None => zones.push((zone.clone(), vec![row])),
        }
    }
    let refused = |message: String| FactorFileError::Rows {
        program: "EnergyPlus",
        message,
    };
    for (zone, members) in &zones {
        let mut objects: Vec<u32> = members.iter().map(|&row| faces[row].object).collect();
        objects.dedup();
        if objects.len() < members.len() {
            return Err(refused(format!(
                "found {} rows, expected one for each of the {} surfaces of {}: --by object makes them",
                members.len(),
                objects.len(),
                zone.name
            )));
        }
    }
    let known: Vec<String> = zones.iter().map(|(zone, _)| zone.name.clone()).collect();
    zones.retain(|(zone, _)| zone_name.is_none_or(|name| name.eq_ignore_ascii_case(&zone.name)));
    if zones.is_empty() {
        let known = known.join(", ");
        let name = zone_name.unwrap_or_default();
        return Err(refused(format!(
            "found no zone \"{name}\", expected one of {known}"
        )));
    }
    Ok(zones)
}

fn surface_factors(zone: &Zone, of_zone: Enclosure) -> Result<SurfaceFactors, FactorFileError> {
    let square_metres = of_zone.metres_per_unit().powi(2);
    let masses = zone.masses.iter();
    let names = of_zone.rows.names.into_iter();
    let surfaces = SurfaceFactors {
        zone: zone.name.clone(),
        names: names.chain(masses.clone().map(|m| m.0.clone())).collect(),
        factors: DirectFactors::of(Cow::Owned(of_zone.factors), "EnergyPlus")?,
        masses: masses.map(|m| m.1 / square_metres).collect(),
    };
    check_names(&surfaces)?;
    Ok(surfaces)
}

/// What is lost of the light of a zone, in sentences.
fn about_zone(enclosure: &Enclosure) -> Vec<String> {
    let mut notes = notes::about_losses(enclosure, "EnergyPlus");
    // What goes to the sky or to backs has a note of its own.
    let residuals = enclosure.factors.residuals();
    let worst = residuals.iter().map(|r| r.abs()).fold(0.0, f64::max);
    if worst > 1e-3 {
        let fate = if enclosure.len() > SMALL {
            "scales in its own way"
        } else {
            "takes as they are"
        };
        notes.push(format!(
            "row sums are off by up to {}, which EnergyPlus {fate}: closing the rows (--closure) corrects what \
             is noise",
            general(worst, 2)
        ));
    }
    notes
}

impl SurfaceFactors {
    /// Calls `write` with each row, zeros and internal masses included.
    ///
    /// Furniture is everywhere in the zone: every surface sees as much of it, in proportion to its area, and it sees
    /// surfaces in proportion to theirs. That is what EnergyPlus' own weights by area become once they are
    /// reciprocal; where there is so much that surfaces would see little else, it sees itself.
    fn each_row(&self, mut write: impl FnMut(usize, &[f64]) -> io::Result<()>) -> io::Result<()> {
        let n = self.factors.len();
        let areas: Vec<f64> = (0..n).map(|i| self.factors.area(i)).collect();
        let (surfaces, whole) = (areas.iter().sum::<f64>(), self.masses.iter().sum::<f64>());
        // Share of the light of a surface that ends on masses.
        let share = if self.masses.is_empty() {
            0.0
        } else {
            (whole / surfaces).min(MOST_MASS)
        };
        let to_masses = |share: f64| self.masses.iter().map(move |mass| share * mass / whole);
        self.factors.each_full_row(|i, row| {
            let row = row.iter().map(|f| (1.0 - share) * f);
            write(i, &row.chain(to_masses(share)).collect::<Vec<_>>())
        })?;
        for k in 0..self.masses.len() {
            let row = areas.iter().map(|area| share * area / whole);
            let itself = to_masses(1.0 - share * surfaces / whole);
            write(n + k, &row.chain(itself).collect::<Vec<_>>())?;
        }
        Ok(())
    }
}

/// Names must be those of its surfaces, so that they cannot be altered.
fn check_names(surfaces: &SurfaceFactors) -> Result<(), FactorFileError> {
    for name in surfaces.names.iter().chain([&surfaces.zone]) {
        let why = if name.contains([',', ';', '!']) || name.contains(char::is_control) {
            "a comma, semicolon, exclamation mark or control character"
        } else if name.chars().count() > LONGEST {
            "more than 100 characters"
        } else if name.trim().is_empty() {
            "nothing but blanks"
        } else {
            continue;
        };
        return Err(FactorFileError::BadName {
            program: "EnergyPlus",
            name: name.clone(),
            why,
        });
    }
    let mut small: Vec<String> = surfaces.names.iter().map(|n| n.to_lowercase()).collect();
    small.sort();
    match small.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(FactorFileError::BadName {
            program: "EnergyPlus",
            name: pair[0].clone(),
            why: "a twin: small and capital letters are the same to it",
        }),
        None => Ok(()),
    }
}

/// All triples of each matrix, zeros and the row itself included: those that are missing are a warning.
pub(super) fn write_idf(zones: &[SurfaceFactors], out: &mut dyn Write) -> io::Result<()> {
    for surfaces in zones {
        let names = &surfaces.names;
        write!(out, "{OBJECT},\n  {}", surfaces.zone)?;
        surfaces.each_row(|i, row| {
            for (name, f) in names.iter().zip(row) {
                write!(out, ",\n  {}, {name}, {}", names[i], general(*f, DIGITS))?;
            }
            Ok(())
        })?;
        writeln!(out, ";")?;
    }
    Ok(())
}

/// The same as objects of epJSON, to be merged into the model's.
pub(super) fn write_json(zones: &[SurfaceFactors], out: &mut dyn Write) -> io::Result<()> {
    write!(out, "{{\n  \"{OBJECT}\": {{")?;
    for (k, surfaces) in zones.iter().enumerate() {
        let names: Vec<String> = surfaces.names.iter().map(|n| json(n)).collect();
        let label = json(&format!("{} factors", surfaces.zone));
        write!(
            out,
            "{}\n    {label}: {{\n      \"zone_or_zonelist_or_space_or_spacelist_name\": {},\n      \
             \"view_factors\": [",
            if k == 0 { "" } else { "," },
            json(&surfaces.zone)
        )?;
        let mut separator = "\n";
        surfaces.each_row(|i, row| {
            for (name, f) in names.iter().zip(row) {
                write!(
                    out,
                    "{separator}        {{\"from_surface\": {}, \"to_surface\": {name}, \
                     \"view_factor\": {}}}",
                    names[i],
                    general(*f, DIGITS)
                )?;
                separator = ",\n";
            }
            Ok(())
        })?;
        write!(out, "\n      ]\n    }}")?;
    }
    writeln!(out, "\n  }}\n}}")
}
