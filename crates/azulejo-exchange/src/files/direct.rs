//! Direct factors, which is all that solvers of diffuse exchange take.

use super::FactorFileError;
use crate::enclosure::Enclosure;
use azulejo_factors::FormFactors;
use azulejo_factors::form_factors::ExchangeAreas;
use std::borrow::Cow;
use std::io;

/// An entry of a row: column and factor.
pub(super) type Factor = (u32, f64);

/// The factors of an enclosure by direct light alone.
pub(super) struct DirectFactors<'a> {
    factors: Cow<'a, FormFactors>,
    /// Whether direct light was kept apart.
    is_apart: bool,
}

impl<'a> DirectFactors<'a> {
    /// The direct part: of factors that were kept apart, or all of them if nothing mirrors or
    /// transmits.
    pub(super) fn new(
        enclosure: &'a Enclosure,
        program: &'static str,
    ) -> Result<DirectFactors<'a>, FactorFileError> {
        DirectFactors::of(Cow::Borrowed(&enclosure.factors), program)
    }

    /// The same in another order: row k of the file is `rows[k]`, each row at most once. Others are
    /// left out.
    pub(super) fn reordered(
        enclosure: &'a Enclosure,
        rows: &[u32],
        program: &'static str,
    ) -> Result<DirectFactors<'a>, FactorFileError> {
        if rows.is_sorted() && rows.len() == enclosure.len() {
            return DirectFactors::new(enclosure, program);
        }
        let mut numbers = vec![None; enclosure.len()];
        for (k, &row) in (0..).zip(rows) {
            numbers[row as usize] = Some(k);
        }
        let ordered = enclosure.factors.grouped(&numbers, rows.len());
        DirectFactors::of(Cow::Owned(ordered), program)
    }

    pub(super) fn of(
        factors: Cow<'a, FormFactors>,
        program: &'static str,
    ) -> Result<DirectFactors<'a>, FactorFileError> {
        let is_apart = !factors.orders.is_empty();
        if !is_apart && factors.ends.iter().any(|&ends| ends < 1.0) {
            return Err(FactorFileError::Mirrors { program });
        }
        Ok(DirectFactors { factors, is_apart })
    }

    pub(super) fn len(&self) -> usize {
        self.factors.len()
    }

    pub(super) fn area(&self, i: usize) -> f64 {
        self.factors.areas[i]
    }

    fn exchange(&self) -> &ExchangeAreas {
        if self.is_apart {
            &self.factors.orders[0]
        } else {
            &self.factors.exchange
        }
    }

    /// F_ii of every row.
    pub(super) fn diagonal(&self) -> Vec<f64> {
        let own = |i: usize| {
            let entry = self.exchange().upper(i).iter();
            let mut own = entry.filter(|e| e.column as usize == i);
            own.next().map_or(0.0, |e| share(e.value, self.area(i)))
        };
        (0..self.len()).map(own).collect()
    }

    /// Σ_j F_ij of every row.
    pub(super) fn sums(&self) -> Vec<f64> {
        let sums = self.exchange().row_sums();
        sums.iter()
            .zip(&self.factors.areas)
            .map(|(&s, &a)| share(s, a))
            .collect()
    }

    /// Calls `write` with each row, columns ascending.
    pub(super) fn each_row(
        &self,
        mut write: impl FnMut(usize, &[Factor]) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut row = Vec::new();
        for block in self.factors.blocks() {
            let rows = self.exchange().rows(block.clone());
            for (i, entries) in block.zip(rows) {
                row.clear();
                let area = self.area(i);
                row.extend(entries.iter().map(|e| (e.column, share(e.value, area))));
                write(i, &row)?;
            }
        }
        Ok(())
    }

    /// Calls `write` with each row, zeros included.
    pub(super) fn each_full_row(
        &self,
        mut write: impl FnMut(usize, &[f64]) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut whole = vec![0.0; self.len()];
        self.each_row(|i, row| {
            whole.fill(0.0);
            row.iter().for_each(|&(j, f)| whole[j as usize] = f);
            write(i, &whole)
        })
    }

    /// Calls `write` with F_ij for all i of each column j, zeros included.
    pub(super) fn each_full_column(
        &self,
        mut write: impl FnMut(usize, &[f64]) -> io::Result<()>,
    ) -> io::Result<()> {
        // A row and a column hold the same exchange areas, divided by other areas.
        self.each_full_row(|j, row| {
            let of = |(i, &f): (usize, &f64)| share(f * self.area(j), self.area(i));
            let column: Vec<f64> = row.iter().enumerate().map(of).collect();
            write(j, &column)
        })
    }
}

/// An exchange area as a share of a row's area; 0 for rows without area, which see nothing.
fn share(exchange: f64, area: f64) -> f64 {
    if area > 0.0 { exchange / area } else { 0.0 }
}
