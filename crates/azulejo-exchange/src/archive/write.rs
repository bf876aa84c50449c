//! Writing archives.

use super::{ORDERS, VERSION};
use crate::enclosure::{CellMesh, Enclosure, RowTable, entry_of};
use azulejo_factors::FormFactors;
use azulejo_factors::form_factors::{RowRemainder, SkyFactors};
use azulejo_formats::numpy::npy::{self, Element};
use azulejo_formats::numpy::npz::NpzWriter;
use azulejo_scene::{Up, Zone};
use std::io::{self, Write};
use std::ops::Range;
use std::sync::Arc;

/// How exactly factors are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ArchivePrecision {
    /// 64 bits for up to 4,194,304 entries (2,048 rows that all see each other), 32 bits beyond.
    #[default]
    Auto,
    /// 32 bits: seven digits, far more than factors by rays are good for.
    Single,
    /// 64 bits.
    Double,
}

/// Entries up to which [`ArchivePrecision::Auto`] takes 64 bits.
const FEW: usize = 1 << 22;

/// Writes an enclosure as `.npz`. Its bytes depend on its content alone, and go out as they are made: what
/// is in memory beside the enclosure are 8 MiB of whole rows at a time.
///
/// # Errors
/// Those of writing.
pub fn write(
    enclosure: &Enclosure,
    precision: ArchivePrecision,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut archive = NpzWriter::new(out);
    write_matrix(&enclosure.factors, precision, &mut archive)?;
    write_around(enclosure, &mut archive)?;
    archive.finish()
}

/// All but the matrix and its errors.
pub(super) fn write_around(enclosure: &Enclosure, archive: &mut NpzWriter) -> io::Result<()> {
    write_shares(&enclosure.factors, archive)?;
    if let Some(rows) = &enclosure.outside {
        archive.add("irradiance", |w| {
            triples(rows.iter().map(|r| r.irradiance.to_array()), w)
        })?;
        archive.add("irradiance_error", |w| {
            triples(rows.iter().map(|r| r.error.to_array()), w)
        })?;
    }
    if let Some(sky) = &enclosure.sky {
        write_sky(sky, enclosure.rows.up, archive)?;
    }
    write_rows(enclosure, archive)?;
    write_cells(&enclosure.rows.cells, enclosure.len(), archive)?;
    write_whole(enclosure, archive)
}

/// What SciPy reads, and the errors of entries.
fn write_matrix(
    factors: &FormFactors,
    precision: ArchivePrecision,
    archive: &mut NpzWriter,
) -> io::Result<()> {
    let rows = MatrixRows::new(factors);
    archive.add("format", |w| npy::write_bytes(b"csr", w))?;
    archive.add("shape", |w| npy::write(&[2], &[factors.len() as i64; 2], w))?;
    // SciPy requires both index arrays to have one type, and is faster with the smaller one.
    if i32::try_from(rows.entries().max(factors.len())).is_ok() {
        archive.add("indptr", |w| list(&rows.starts, |&x| x as i32, w))?;
        archive.add("indices", |w| rows.write(|(j, ..)| j as i32, w))?;
    } else {
        archive.add("indptr", |w| list(&rows.starts, |&x| x as i64, w))?;
        archive.add("indices", |w| rows.write(|(j, ..)| i64::from(j), w))?;
    }
    let is_double = match precision {
        ArchivePrecision::Auto => rows.entries() <= FEW,
        ArchivePrecision::Single => false,
        ArchivePrecision::Double => true,
    };
    if is_double {
        archive.add("data", |w| rows.write(|(_, x, _)| x, w))?;
    } else {
        archive.add("data", |w| rows.write(|(_, x, _)| x as f32, w))?;
    }
    let error = |e: f32| if is_double { e } else { short(e) };
    archive.add("std_error", |w| rows.write(|(.., e)| error(e), w))?;
    for (order, [values, errors]) in (0..factors.orders.len()).zip(ORDERS) {
        if is_double {
            archive.add(values, |w| rows.write_order(order, |(_, x, _)| x, w))?;
        } else {
            archive.add(values, |w| rows.write_order(order, |(_, x, _)| x as f32, w))?;
        }
        archive.add(errors, |w| rows.write_order(order, |(.., e)| error(e), w))?;
    }
    Ok(())
}

/// A standard error with 8 bits of its fraction, rounded up, for large matrices: errors are known no
/// better, and zeros compress.
fn short(error: f32) -> f32 {
    const DROPPED: u32 = (1 << 15) - 1;
    if !error.is_finite() {
        return error;
    }
    f32::from_bits(error.to_bits().saturating_add(DROPPED) & !DROPPED)
}

/// Shares of rows, and their errors.
fn write_shares(factors: &FormFactors, archive: &mut NpzWriter) -> io::Result<()> {
    archive.add("areas", |w| list(&factors.areas, |&x| x, w))?;
    // Of rows that were not kept nobody knows these.
    if factors.row_errors.len() == factors.len() {
        archive.add("row_error", |w| list(&factors.row_errors, |&x| x, w))?;
        archive.add("unseen", |w| list(&factors.unseen, |&x| x, w))?;
    }
    let mut add = |name, share: fn(&RowRemainder) -> f64| {
        archive.add(name, |w| list(&factors.rest, share, w))
    };
    add("sky", |r| r.sky)?;
    add("sky_error", |r| r.sky_error)?;
    add("ground", |r| r.ground)?;
    add("ground_error", |r| r.ground_error)?;
    add("escaped", RowRemainder::escaped)?;
    add("hidden", |r| r.hidden)?;
    add("hidden_error", |r| r.hidden_error)?;
    add("cut", |r| r.cut)?;
    add("lost", |r| r.lost)
}

/// What rows see of the patches of the sky, and what these are.
pub(crate) fn write_sky(sky: &SkyFactors, up: Up, archive: &mut NpzWriter) -> io::Result<()> {
    let division = sky.division;
    let rows = sky.shares.len() / division.count();
    for (name, numbers) in [
        ("sky_patches", &sky.shares),
        ("sky_patches_error", &sky.errors),
    ] {
        archive.add(name, |w| npy::write(&[rows, division.count()], numbers, w))?;
    }
    let directions = sky.directions(up).into_iter().map(|d| d.to_array());
    archive.add("sky_directions", |w| triples(directions, w))?;
    archive.add("sky_solid_angles", |w| list(&sky.solid_angles(), |&x| x, w))?;
    archive.add("sky_division", |w| {
        npy::write_texts(&[division.to_string()], w)
    })?;
    archive.add("sky_north", |w| npy::write(&[], &[sky.north], w))
}

/// What rows are.
fn write_rows(enclosure: &Enclosure, archive: &mut NpzWriter) -> io::Result<()> {
    let (factors, rows) = (&enclosure.factors, &enclosure.rows);
    archive.add("names", |w| npy::write_texts(&rows.names, w))?;
    archive.add("patch_face", |w| {
        npy::write_header(i64::DESCR, &[factors.len(), 2], w)?;
        let numbers = factors.faces.iter().flat_map(|f| [f.object, f.face]);
        numbers.map(i64::from).try_for_each(|x| x.write(w))
    })?;
    archive.add("patch_back", |w| {
        list(&factors.is_back, |&b| i32::from(b), w)
    })?;
    archive.add("material", |w| {
        list(&factors.materials, |&m| i64::from(m), w)
    })?;
    archive.add("rho_s", |w| list(&factors.ends, |end| 1.0 - end, w))?;
    let diffuse = rows.diffuse.iter().map(|c| c.to_array());
    archive.add("diffuse", |w| triples(diffuse, w))?;
    if !rows.grouped_faces.is_empty() {
        archive.add("group_faces", |w| {
            npy::write_header(i64::DESCR, &[rows.grouped_faces.len(), 3], w)?;
            let faces = rows.grouped_faces.iter();
            let numbers = faces.flat_map(|&(f, group)| [f.object, f.face, group]);
            numbers.map(i64::from).try_for_each(|x| x.write(w))
        })?;
    }
    archive.add("object_names", |w| npy::write_texts(&rows.objects, w))?;
    write_zones(rows, archive)?;
    archive.add("material_names", |w| npy::write_texts(&rows.materials, w))
}

/// The zones of objects, and what has no place in them; nothing if the model has no zones.
fn write_zones(rows: &RowTable, archive: &mut NpzWriter) -> io::Result<()> {
    if rows.zones.is_empty() {
        return Ok(());
    }
    let name = |zone: &Option<Arc<Zone>>| zone.as_ref().map_or(String::new(), |z| z.name.clone());
    let names: Vec<String> = rows.zones.iter().map(name).collect();
    archive.add("object_zones", |w| npy::write_texts(&names, w))?;
    let mut zones: Vec<&Arc<Zone>> = rows.zones.iter().flatten().collect();
    zones.sort_by_key(|zone| &zone.name);
    zones.dedup_by_key(|zone| &zone.name);
    let masses = || {
        zones
            .iter()
            .flat_map(|z| z.masses.iter().map(|m| (&z.name, &m.0, m.1)))
    };
    let of: Vec<String> = masses().map(|m| m.0.clone()).collect();
    let named: Vec<String> = masses().map(|m| m.1.clone()).collect();
    let areas: Vec<f64> = masses().map(|m| m.2).collect();
    archive.add("mass_zones", |w| npy::write_texts(&of, w))?;
    archive.add("mass_names", |w| npy::write_texts(&named, w))?;
    archive.add("mass_areas", |w| list(&areas, |&a| a, w))
}

/// Where rows are.
fn write_cells(cells: &CellMesh, rows: usize, archive: &mut NpzWriter) -> io::Result<()> {
    if cells.is_empty() {
        return Ok(());
    }
    let frames = cells.frames(rows);
    archive.add("centroids", |w| {
        triples(frames.iter().map(|f| f.0.to_array()), w)
    })?;
    archive.add("normals", |w| {
        triples(frames.iter().map(|f| f.1.to_array()), w)
    })?;
    archive.add("points", |w| {
        triples(cells.points.iter().map(|p| p.to_array()), w)
    })?;
    archive.add("cell_corners", |w| {
        list(&cells.corners, |&c| i64::from(c), w)
    })?;
    archive.add("cell_starts", |w| list(&cells.starts, |&s| i64::from(s), w))?;
    archive.add("cell_rows", |w| list(&cells.rows, |&r| i64::from(r), w))
}

/// What holds for the whole.
fn write_whole(enclosure: &Enclosure, archive: &mut NpzWriter) -> io::Result<()> {
    let (factors, rows) = (&enclosure.factors, &enclosure.rows);
    if let Some(length) = rows.metres_per_unit {
        archive.add("metres_per_unit", |w| npy::write(&[], &[length], w))?;
    }
    let up = if rows.up == Up::Y { "y" } else { "z" };
    archive.add("up", |w| npy::write_texts(&[up.to_owned()], w))?;
    let engine = [factors.engine_used.name.clone()];
    archive.add("engine", |w| npy::write_texts(&engine, w))?;
    archive.add("rays", |w| npy::write(&[], &[factors.rays as i64], w))?;
    archive.add("groups", |w| {
        npy::write(&[], &[i32::from(rows.are_groups)], w)
    })?;
    archive.add("closed", |w| {
        npy::write(&[], &[i32::from(factors.is_closed)], w)
    })?;
    archive.add("version", |w| npy::write(&[], &[VERSION], w))
}

/// An array of three numbers for each row.
pub(crate) fn triples(
    rows: impl ExactSizeIterator<Item = [f64; 3]>,
    out: &mut dyn Write,
) -> io::Result<()> {
    npy::write_header(f64::DESCR, &[rows.len(), 3], out)?;
    rows.flatten().try_for_each(|x| x.write(out))
}

/// Complete rows of a matrix, of which one half is in memory.
struct MatrixRows<'a> {
    factors: &'a FormFactors,
    blocks: Vec<Range<usize>>,
    /// The start of each row, and the end of the last.
    starts: Vec<usize>,
}

impl MatrixRows<'_> {
    fn new(factors: &FormFactors) -> MatrixRows<'_> {
        let mut starts = vec![0];
        for length in factors.exchange.row_lengths() {
            starts.push(starts[starts.len() - 1] + length);
        }
        MatrixRows {
            factors,
            blocks: factors.blocks(),
            starts,
        }
    }

    fn entries(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }

    /// An array with one number for each entry.
    fn write<E: Element>(
        &self,
        convert: impl Fn((u32, f64, f32)) -> E,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        npy::write_header(E::DESCR, &[self.entries()], out)?;
        for block in &self.blocks {
            let mut entries = self.factors.rows(block.clone()).into_iter().flatten();
            entries.try_for_each(|e| convert(e).write(out))?;
        }
        Ok(())
    }

    /// The same for an order of reflection, with zeros where it has no entry.
    fn write_order<E: Element>(
        &self,
        order: usize,
        convert: impl Fn((u32, f64, f32)) -> E,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        npy::write_header(E::DESCR, &[self.entries()], out)?;
        for block in &self.blocks {
            let whole = self.factors.exchange.rows(block.clone());
            let parts = self.factors.rows_of_order(order, block.clone());
            for (row, part) in whole.iter().zip(&parts) {
                let mut entries = row.iter().map(|e| entry_of(part, e.column));
                entries.try_for_each(|e| convert(e).write(out))?;
            }
        }
        Ok(())
    }
}

/// Writes a one-dimensional array, converting entry by entry to avoid a copy.
pub(crate) fn list<T, E: Element>(
    values: &[T],
    convert: impl Fn(&T) -> E,
    out: &mut dyn Write,
) -> io::Result<()> {
    npy::write_header(E::DESCR, &[values.len()], out)?;
    values.iter().try_for_each(|v| convert(v).write(out))
}
