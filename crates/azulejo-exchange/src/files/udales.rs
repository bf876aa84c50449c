//! Files of uDALES: its rows are the facets of an STL file, in order.

use super::direct::DirectFactors;
use super::netcdf::write_square;
use super::text::general;
use super::{FactorFileError, FactorFiles, FileOptions, notes};
use crate::enclosure::Enclosure;
use azulejo_factors::form_factors::RowRemainder;
use std::io::{self, Write};

/// Factors below are left out, as in the eighth decimal they would not be seen.
const LEAST: f64 = 5e-7;

/// Rows up to which the full matrix is written, too: 256 MiB.
const FULL: usize = 8_192;

/// Share from which light that goes down matters, as uDALES counts it as sky.
const LEAK: f64 = 1e-3;

pub(super) fn prepare<'a>(
    enclosure: &'a Enclosure,
    options: &FileOptions,
) -> Result<FactorFiles<'a>, FactorFileError> {
    let Some(suffix) = options.experiment.clone() else {
        return Err(FactorFileError::Missing {
            format: "udales",
            message: "no number of the experiment, expected vfsparse.inp.NNN as output",
        });
    };
    notes::check_faces(enclosure, "uDALES", "STL file")?;
    let factors = DirectFactors::new(enclosure, "uDALES")?;
    let types = wall_types(enclosure);
    let mut notes = about_leaks(enclosure);
    let lines = entries(&factors);
    notes.push(format!(
        "for &ENERGYBALANCE: lvfsparse=.true., nnz={lines}, and for &WALLS: nfcts={}",
        enclosure.len()
    ));
    if types.iter().all(Option::is_none) {
        notes.push(
            "all facets have wall type 1: materials named by numbers are types of that number"
                .to_owned(),
        );
    }
    let is_full = enclosure.len() <= FULL;
    if !is_full {
        notes.push(format!(
            "vf.nc.inp.{suffix} is left out, which would be large: lvfsparse=.true. reads \
             vfsparse.inp.{suffix}"
        ));
    }
    let mut files = FactorFiles::new();
    let factors = std::rc::Rc::new(factors);
    let sparse = factors.clone();
    files.add(format!("vfsparse.inp.{suffix}"), move |out| {
        write_sparse(&sparse, out)
    });
    if is_full {
        files.add(format!("vf.nc.inp.{suffix}"), move |out| {
            write_full(&factors, out)
        });
    }
    files.add(format!("svf.inp.{suffix}"), |out| {
        writeln!(out, "# sky view factors")?;
        // As uDALES defines it: what no facet gets.
        let mut sums = enclosure.factors.row_sums().into_iter();
        sums.try_for_each(|sum| writeln!(out, "{:.8}", (1.0 - sum).max(0.0)))
    });
    files.add(format!("facetarea.inp.{suffix}"), |out| {
        write_areas(enclosure, out)
    });
    files.add(format!("facets.inp.{suffix}"), move |out| {
        write_facets(enclosure, &types, out)
    });
    files.notes = notes;
    Ok(files)
}

/// The wall type of each facet: the number that its material's name is.
fn wall_types(enclosure: &Enclosure) -> Vec<Option<u32>> {
    let names = &enclosure.rows.materials;
    let material = enclosure.factors.materials.iter();
    let number = |&m: &u32| names.get(m as usize)?.parse().ok();
    material.map(number).collect()
}

fn about_leaks(enclosure: &Enclosure) -> Vec<String> {
    let mut notes: Vec<_> = notes::about_hidden(enclosure).into_iter().collect();
    let down = |r: &RowRemainder| r.ground;
    if let Some((rows, worst)) = notes::losing(enclosure, LEAK, down) {
        notes.push(format!(
            "{rows} lose light downwards, {worst}: uDALES takes it for sky, and expects the ground among the facets"
        ));
    }
    notes
}

/// Number of lines of the sparse matrix.
fn entries(factors: &DirectFactors<'_>) -> usize {
    let mut lines = 0;
    // Counting does not fail.
    let _ = factors.each_row(|_, row| {
        lines += row.iter().filter(|(_, f)| *f >= LEAST).count();
        Ok(())
    });
    lines
}

fn write_sparse(factors: &DirectFactors<'_>, out: &mut dyn Write) -> io::Result<()> {
    factors.each_row(|i, row| {
        let mut row = row.iter().filter(|(_, f)| *f >= LEAST);
        row.try_for_each(|(j, f)| writeln!(out, "{} {} {f:.8}", i + 1, j + 1))
    })
}

/// The full matrix. Fortran's first index is the one that runs fastest, so that `vf(i, j)` is F_ij
/// where columns are written one after the other.
fn write_full(factors: &DirectFactors<'_>, out: &mut dyn Write) -> io::Result<()> {
    write_square("view factor", factors.len(), out, |add| {
        factors.each_full_column(|_, column| column.iter().try_for_each(|&f| add(f as f32)))
    })
}

fn write_areas(enclosure: &Enclosure, out: &mut dyn Write) -> io::Result<()> {
    let square_metres = enclosure.metres_per_unit().powi(2);
    writeln!(out, "# area of facets")?;
    let mut areas = enclosure.factors.areas.iter();
    areas.try_for_each(|a| writeln!(out, "{}", general(a * square_metres, 9)))
}

fn write_facets(
    enclosure: &Enclosure,
    types: &[Option<u32>],
    out: &mut dyn Write,
) -> io::Result<()> {
    writeln!(out, "# type, normal")?;
    let frames = enclosure.rows.cells.frames(enclosure.len());
    for (kind, (_, normal)) in types.iter().zip(frames) {
        // Adding 0 removes the minus of −0.
        let [x, y, z] = normal.to_array().map(|x| (x * 1e4).round() / 1e4 + 0.0);
        writeln!(out, "{} {x:.4} {y:.4} {z:.4}", kind.unwrap_or(1))?;
    }
    Ok(())
}
