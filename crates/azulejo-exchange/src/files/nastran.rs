//! Nastran's `RADLST` and `RADMTX`: the elements of a cavity, and the lower triangle of A_i F_ij by
//! columns.
//!
//! Two dialects exist: that of NASTRAN-95, and that of the programs after it, whose entries begin
//! with the number of the cavity, and of `RADLST` also with the type of the matrix.

use super::direct::DirectFactors;
use super::text::{comment, exponential};
use super::{FactorFileError, FactorFiles, notes};
use crate::enclosure::Enclosure;
use std::collections::HashSet;
use std::io::{self, Write};

/// Digits that fit a field of 16 characters.
const DIGITS: usize = 10;

/// Longest comment.
const COMMENT: usize = 60;

/// The layout of entries.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Dialect {
    Classic,
    Modern,
}

pub(super) fn prepare(
    enclosure: &Enclosure,
    dialect: Dialect,
) -> Result<FactorFiles<'_>, FactorFileError> {
    let factors = DirectFactors::new(enclosure, "Nastran")?;
    let elements = element_numbers(enclosure);
    let mut notes: Vec<_> = notes::about_hidden(enclosure).into_iter().collect();
    notes.push(match &elements {
        Some(_) => "elements are those that rows are named by".to_owned(),
        None => format!(
            "elements are 1 to {}, the rows in order: renumber them to those of CHBDYi",
            enclosure.len()
        ),
    });
    let elements = elements.unwrap_or_else(|| (1..=enclosure.len() as u32).collect());
    let mut files =
        FactorFiles::single(move |out| write(enclosure, &factors, &elements, dialect, out));
    files.notes = notes;
    Ok(files)
}

/// Numbers of elements, if all rows are named by different ones.
fn element_numbers(enclosure: &Enclosure) -> Option<Vec<u32>> {
    /// Largest number that Nastran accepts.
    const LARGEST: u32 = 99_999_999;
    let names = notes::row_names(enclosure);
    let number = |name: &std::borrow::Cow<'_, str>| {
        let number = name.parse().ok();
        number.filter(|n| (1..=LARGEST).contains(n))
    };
    let numbers = names.iter().map(number).collect::<Option<Vec<u32>>>()?;
    let different: HashSet<&u32> = numbers.iter().collect();
    (different.len() == numbers.len()).then_some(numbers)
}

fn write(
    enclosure: &Enclosure,
    factors: &DirectFactors<'_>,
    elements: &[u32],
    dialect: Dialect,
    out: &mut dyn Write,
) -> io::Result<()> {
    for (element, name) in elements.iter().zip(&enclosure.rows.names) {
        writeln!(out, "$ {element} = {}", comment(name, COMMENT))?;
    }
    let cavity = match dialect {
        Dialect::Classic => vec![],
        Dialect::Modern => vec!["1".to_owned()],
    };
    // Type 1: symmetric.
    let kind = cavity.iter().cloned();
    let list = elements.iter().map(u32::to_string);
    entry(
        "RADLST",
        cavity.iter().cloned().chain(kind).chain(list),
        out,
    )?;
    factors.each_full_row(|i, row| {
        let length = row
            .iter()
            .rposition(|f| *f != 0.0)
            .map_or(0, |last| last + 1);
        // A column has its diagonal, even if that is all, and zero.
        let column = &row[i..length.max(i + 1)];
        let area = factors.area(i);
        let values = column.iter().map(|f| exponential(f * area, DIGITS));
        let number = (i + 1).to_string();
        entry(
            "RADMTX",
            cavity.iter().cloned().chain([number]).chain(values),
            out,
        )
    })
}

/// An entry in fields of 16 characters, four to a line.
fn entry(name: &str, fields: impl Iterator<Item = String>, out: &mut dyn Write) -> io::Result<()> {
    let fields: Vec<String> = fields.collect();
    let mut first = format!("{name}*");
    // Lines come in pairs, and the second of the last pair may be empty.
    for pair in fields.chunks(8) {
        for line in [&pair[..pair.len().min(4)], &pair[pair.len().min(4)..]] {
            let text: String = line.iter().map(|field| format!("{field:>16}")).collect();
            writeln!(out, "{}", format!("{first:8}{text}").trim_end())?;
            first = "*".to_owned();
        }
    }
    Ok(())
}
