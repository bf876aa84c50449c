//! Elmer's `ViewFactors.dat`: rows are the boundary elements with `Radiation = diffuse gray`, in the
//! order of its mesh.

use super::direct::DirectFactors;
use super::text::{DIGITS, general};
use super::{FactorFileError, FactorFiles, notes};
use crate::enclosure::Enclosure;
use std::io::{self, Write};

pub(super) fn prepare<'a>(
    enclosure: &'a Enclosure,
    write: fn(&DirectFactors<'_>, &mut dyn Write) -> io::Result<()>,
) -> Result<FactorFiles<'a>, FactorFileError> {
    let factors = DirectFactors::new(enclosure, "Elmer")?;
    let mut files = FactorFiles::single(move |out| write(&factors, out));
    files.notes = notes::about_hidden(enclosure).into_iter().collect();
    Ok(files)
}

/// The number of entries of each row, then its lines `i j F`, from 1.
pub(super) fn write_text(factors: &DirectFactors<'_>, out: &mut dyn Write) -> io::Result<()> {
    factors.each_row(|i, row| {
        writeln!(out, "{}", row.len())?;
        for &(j, f) in row {
            writeln!(out, "{} {} {}", i + 1, j + 1, general(f, DIGITS))?;
        }
        Ok(())
    })
}

/// The number of rows; then for each the number of its entries, and their columns, from 1, and
/// factors.
pub(super) fn write_binary(factors: &DirectFactors<'_>, out: &mut dyn Write) -> io::Result<()> {
    out.write_all(&(factors.len() as i32).to_le_bytes())?;
    factors.each_row(|_, row| {
        out.write_all(&(row.len() as i32).to_le_bytes())?;
        for &(j, f) in row {
            out.write_all(&(j as i32 + 1).to_le_bytes())?;
            out.write_all(&f.to_le_bytes())?;
        }
        Ok(())
    })
}
