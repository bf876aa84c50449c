//! Matrix Market coordinates (Boisvert, Pozo, Remington 1996).

use super::text::comment;
use crate::enclosure::Enclosure;
use std::io::{self, Write};

/// Longest line of the format, 1,024 characters, less some for the number.
const NAME: usize = 1_000;

/// Writes X, to the bit, with the names of its rows as comments.
pub(super) fn write(enclosure: &Enclosure, out: &mut dyn Write) -> io::Result<()> {
    let factors = &enclosure.factors;
    writeln!(out, "%%MatrixMarket matrix coordinate real general")?;
    for (i, name) in enclosure.rows.names.iter().enumerate() {
        writeln!(out, "% {} {}", i + 1, comment(name, NAME))?;
    }
    let (n, entries) = (factors.len(), factors.exchange.entries());
    writeln!(out, "{n} {n} {entries}")?;
    for block in factors.blocks() {
        for (i, row) in block.clone().zip(factors.rows(block)) {
            for (j, f, _) in row {
                writeln!(out, "{} {} {f:e}", i + 1, j + 1)?;
            }
        }
    }
    Ok(())
}
