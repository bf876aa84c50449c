//! CalculiX' `.vwf`, which `*VIEWFACTOR, READ, INPUT=name.vwf` reads: Fortran's unformatted sequential
//! records.
//!
//! Rows are the faces with a radiation load (`RkCR`) of one cavity, by ascending element; of an element, the face
//! whose load comes last in the deck is first. Decks are read in this order.

use super::direct::DirectFactors;
use super::{FactorFileError, FactorFiles, FileOptions, notes};
use crate::enclosure::Enclosure;
use std::io::{self, Write};

/// The version that is written unless another is asked for.
const VERSION: &str = "2.20";

/// Characters of the first record.
const TITLE: usize = 80;

/// Longest part of a record, as the length before and after it is a signed 32-bit number: gfortran
/// divides longer records, at other places, but reads all.
const PART: u64 = (1 << 31) - 16;

pub(super) fn prepare<'a>(
    enclosure: &'a Enclosure,
    options: &FileOptions,
) -> Result<FactorFiles<'a>, FactorFileError> {
    notes::check_faces(enclosure, "CalculiX", "model")?;
    let factors = DirectFactors::new(enclosure, "CalculiX")?;
    let version = options.calculix.clone().unwrap_or_else(|| VERSION.into());
    let title = format!("Version {version}");
    if title.len() > TITLE || !title.is_ascii() {
        return Err(FactorFileError::BadName {
            program: "CalculiX",
            name: version,
            why: "more than 72 characters, or others than ASCII",
        });
    }
    let mut files = FactorFiles::single(move |out| write(&factors, &title, PART, out));
    files.notes = notes::about_hidden(enclosure).into_iter().collect();
    Ok(files)
}

pub(super) fn write(
    factors: &DirectFactors<'_>,
    title: &str,
    part: u64,
    out: &mut dyn Write,
) -> io::Result<()> {
    let n = factors.len() as u64;
    let mut record = Record::begin(TITLE as u64, part, out)?;
    record.add(format!("{title:TITLE$}").as_bytes())?;
    let mut record = Record::begin(8 * n, part, out)?;
    for f in factors.diagonal() {
        record.add(&f.to_le_bytes())?;
    }
    let pairs = n * n.saturating_sub(1) / 2;
    let mut record = Record::begin(2 * 8 * pairs, part, out)?;
    // The lower triangle, column by column: from the row to the column, then back.
    factors.each_full_column(|j, column| numbers(&column[j + 1..], &mut record))?;
    factors.each_full_row(|i, row| numbers(&row[i + 1..], &mut record))?;
    let mut record = Record::begin(8 * n, part, out)?;
    for sum in factors.sums() {
        record.add(&(1.0 - sum).to_le_bytes())?;
    }
    Ok(())
}

fn numbers(numbers: &[f64], record: &mut Record<'_>) -> io::Result<()> {
    numbers
        .iter()
        .try_for_each(|f| record.add(&f.to_le_bytes()))
}

/// A record of Fortran, divided into parts if it is long: each between its length in bytes, as 32
/// bits, negative before a part if another follows, and after it if another went before.
struct Record<'a> {
    out: &'a mut dyn Write,
    part: u64,
    /// Bytes of the record that belong to later parts.
    later: u64,
    /// Length of this part, and what is missing of it.
    length: u64,
    missing: u64,
    is_first: bool,
}

impl<'a> Record<'a> {
    fn begin(length: u64, part: u64, out: &'a mut dyn Write) -> io::Result<Record<'a>> {
        let mut record = Record {
            out,
            part,
            later: length,
            length: 0,
            missing: 0,
            is_first: true,
        };
        record.begin_part()?;
        if length == 0 {
            record.end_part()?;
        }
        Ok(record)
    }

    fn begin_part(&mut self) -> io::Result<()> {
        self.length = self.later.min(self.part);
        self.missing = self.length;
        self.later -= self.length;
        self.mark(self.later > 0)
    }

    fn end_part(&mut self) -> io::Result<()> {
        self.mark(!self.is_first)?;
        self.is_first = false;
        Ok(())
    }

    fn mark(&mut self, is_negative: bool) -> io::Result<()> {
        let length = self.length as i32;
        let mark = if is_negative { -length } else { length };
        self.out.write_all(&mark.to_le_bytes())
    }

    fn add(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        while !bytes.is_empty() {
            let (now, then) = bytes.split_at(bytes.len().min(self.missing as usize));
            self.out.write_all(now)?;
            self.missing -= now.len() as u64;
            bytes = then;
            if self.missing == 0 {
                self.end_part()?;
                if self.later > 0 {
                    self.begin_part()?;
                }
            }
        }
        Ok(())
    }
}
