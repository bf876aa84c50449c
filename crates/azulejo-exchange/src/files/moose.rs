//! A block of MOOSE's input.

use super::direct::DirectFactors;
use super::text::{DIGITS, general, words, wrapped};
use super::{FactorFileError, FactorFiles, notes};
use crate::enclosure::Enclosure;
use std::io::{self, Write};

/// Width of lines.
const WIDTH: usize = 110;

pub(super) fn prepare(enclosure: &Enclosure) -> Result<FactorFiles<'_>, FactorFileError> {
    let factors = DirectFactors::new(enclosure, "MOOSE")?;
    // Blanks separate names, and others have a meaning in its input.
    let names = notes::row_names(enclosure);
    let boundaries = words(&names, |c| {
        c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.' | ':')
    });
    let changed = names.iter().zip(&boundaries).filter(|(a, b)| a != b);
    let mut notes = notes::about_losses(enclosure, "MOOSE");
    if let Some((name, boundary)) = changed.clone().next() {
        notes.push(format!(
            "{} names are not words, and are written as such: \"{name}\" as {boundary}",
            changed.count()
        ));
    }
    let mut files = FactorFiles::single(move |out| write(enclosure, &factors, &boundaries, out));
    files.notes = notes;
    Ok(files)
}

fn write(
    enclosure: &Enclosure,
    factors: &DirectFactors<'_>,
    boundaries: &[String],
    out: &mut dyn Write,
) -> io::Result<()> {
    let emissivities = enclosure.absorptances();
    let emissivities = emissivities.iter().map(|e| general(*e, DIGITS));
    writeln!(out, "[UserObjects]\n  [surface_radiation]")?;
    writeln!(out, "    type = ConstantViewFactorSurfaceRadiation")?;
    writeln!(
        out,
        "    # Add temperature = VARIABLE, and fixed_temperature_boundary or adiabatic_boundary."
    )?;
    writeln!(out, "    boundary = '")?;
    wrapped(boundaries.iter().cloned(), "      ", WIDTH, out)?;
    writeln!(
        out,
        "    '\n    # What the materials of the model absorb.\n    emissivity = '"
    )?;
    wrapped(emissivities, "      ", WIDTH, out)?;
    writeln!(out, "    '\n    view_factors = '")?;
    let last = factors.len().saturating_sub(1);
    factors.each_full_row(|i, row| {
        let numbers = row.iter().map(|f| general(*f, DIGITS));
        let end = (i < last).then(|| ";".to_owned());
        wrapped(numbers.chain(end), "      ", WIDTH, out)
    })?;
    writeln!(out, "    '\n  []\n[]")
}
