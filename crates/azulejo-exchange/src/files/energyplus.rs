//! EnergyPlus' `ZoneProperty:UserViewFactors:BySurfaceName`, of version 9.4 and later.

use super::direct::DirectFactors;
use super::text::{DIGITS, general, json};
use super::{FactorFileError, FactorFiles, FileOptions, notes};
use crate::enclosure::Enclosure;
use std::borrow::Cow;
use std::io::{self, Write};

const OBJECT: &str = "ZoneProperty:UserViewFactors:BySurfaceName";

/// Names of EnergyPlus have no more characters.
const LONGEST: usize = 100;

/// Rows up to which it makes rows reciprocal, but not closed.
const SMALL: usize = 3;

/// What both notations write.
pub(super) struct SurfaceFactors<'a> {
    zone: &'a str,
    names: Vec<Cow<'a, str>>,
    factors: DirectFactors<'a>,
}

pub(super) fn prepare<'a>(
    enclosure: &'a Enclosure,
    options: &'a FileOptions,
    write: fn(&SurfaceFactors<'_>, &mut dyn Write) -> io::Result<()>,
) -> Result<FactorFiles<'a>, FactorFileError> {
    let surfaces = SurfaceFactors {
        zone: options.zone.as_deref().unwrap_or("Zone"),
        names: notes::row_names(enclosure),
        factors: DirectFactors::new(enclosure, "EnergyPlus")?,
    };
    check_names(&surfaces)?;
    let mut notes = notes::about_losses(enclosure, "EnergyPlus");
    if options.zone.is_none() {
        notes.push("the zone is named Zone: the option zone gives it that of the model".to_owned());
    }
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
    let mut files = FactorFiles::single(move |out| write(&surfaces, out));
    files.notes = notes;
    Ok(files)
}

/// Names must be those of its surfaces, so that they cannot be altered.
fn check_names(surfaces: &SurfaceFactors<'_>) -> Result<(), FactorFileError> {
    let names = surfaces.names.iter().map(Cow::as_ref);
    for name in names.chain([surfaces.zone]) {
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
            name: name.to_owned(),
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

/// All triples of a matrix, zeros and the row itself included: those that are missing are a warning.
pub(super) fn write_idf(surfaces: &SurfaceFactors<'_>, out: &mut dyn Write) -> io::Result<()> {
    let names = &surfaces.names;
    write!(out, "{OBJECT},\n  {}", surfaces.zone)?;
    surfaces.factors.each_full_row(|i, row| {
        for (name, f) in names.iter().zip(row) {
            write!(out, ",\n  {}, {name}, {}", names[i], general(*f, DIGITS))?;
        }
        Ok(())
    })?;
    writeln!(out, ";")
}

/// The same as an object of epJSON, to be merged into the model's.
pub(super) fn write_json(surfaces: &SurfaceFactors<'_>, out: &mut dyn Write) -> io::Result<()> {
    let names: Vec<String> = surfaces.names.iter().map(|n| json(n)).collect();
    let label = json(&format!("{} factors", surfaces.zone));
    write!(
        out,
        "{{\n  \"{OBJECT}\": {{\n    {label}: {{\n      \
         \"zone_or_zonelist_or_space_or_spacelist_name\": {},\n      \"view_factors\": [",
        json(surfaces.zone)
    )?;
    let mut separator = "\n";
    surfaces.factors.each_full_row(|i, row| {
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
    writeln!(out, "\n      ]\n    }}\n  }}\n}}")
}
