//! VTK's unstructured grids (`.vtu`): one file, XML with raw data after it.
//!
//! All numbers are little-endian, and each array is its length in bytes as 64 bits and then its
//! content. Rows have no names here: readers other than VTK stop at arrays of text.

use super::text::xml;
use super::{FactorFileError, FactorFiles, FileOptions};
use crate::enclosure::{CellMesh, Enclosure};
use azulejo_factors::form_factors::RowRemainder;
use azulejo_scene::Rgb;
use std::io::{self, Write};

/// Cell types of VTK.
const TRIANGLE: u8 = 5;
const POLYGON: u8 = 7;
const QUAD: u8 = 9;

/// Columns of a matrix that are shown, by which an array of shares begins.
const FROM: &str = "F_from_";

/// An array of the file.
struct DataArray {
    name: String,
    components: usize,
    /// VTK's name of the type of its numbers.
    type_name: &'static str,
    /// The numbers, in order.
    bytes: Vec<u8>,
}

impl DataArray {
    /// An array of numbers by their bytes, `components` for each point or cell.
    fn new<const N: usize>(
        name: impl Into<String>,
        components: usize,
        type_name: &'static str,
        numbers: impl Iterator<Item = [u8; N]>,
    ) -> DataArray {
        DataArray {
            name: name.into(),
            components,
            type_name,
            bytes: numbers.flatten().collect(),
        }
    }

    fn tag(&self) -> ArrayTag<'_> {
        ArrayTag {
            name: &self.name,
            components: self.components,
            type_name: self.type_name,
            bytes: self.bytes.len() as u64,
        }
    }

    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&(self.bytes.len() as u64).to_le_bytes())?;
        out.write_all(&self.bytes)
    }
}

/// What the XML says of an array.
struct ArrayTag<'a> {
    name: &'a str,
    components: usize,
    type_name: &'static str,
    bytes: u64,
}

pub(super) fn prepare<'a>(
    enclosure: &'a Enclosure,
    options: &'a FileOptions,
) -> Result<FactorFiles<'a>, FactorFileError> {
    let cells = &enclosure.rows.cells;
    if cells.is_empty() && !enclosure.is_empty() {
        return Err(FactorFileError::NoPolygons);
    }
    for (name, values) in &options.arrays {
        if values.len() != enclosure.len() {
            return Err(FactorFileError::ArrayLength {
                name: name.clone(),
                found: values.len(),
                expected: enclosure.len(),
            });
        }
    }
    let shown = shown_rows(enclosure, &options.shown_rows)?;
    Ok(FactorFiles::single(move |out| {
        let mut arrays = row_arrays(enclosure, cells);
        let given = options.arrays.iter();
        arrays.extend(given.map(|(name, values)| per_cell(cells, name, values)));
        for (name, row) in options.shown_rows.iter().zip(&shown) {
            arrays.push(factors_from(enclosure, cells, name, *row));
        }
        write(&geometry(cells), &arrays, cells, out)
    }))
}

/// The numbers of rows that were chosen by name.
fn shown_rows(enclosure: &Enclosure, names: &[String]) -> Result<Vec<usize>, FactorFileError> {
    let known = &enclosure.rows.names;
    let find = |name: &String| {
        let unknown = || FactorFileError::UnknownRow {
            name: name.clone(),
            known: known.clone(),
        };
        known.iter().position(|k| k == name).ok_or_else(unknown)
    };
    names.iter().map(find).collect()
}

/// Points, corners, ends and types of all cells.
fn geometry(cells: &CellMesh) -> [DataArray; 4] {
    let points = cells.points.iter().flat_map(|p| p.to_array());
    let cell_type = |i: usize| match cells.cell(i).len() {
        3 => TRIANGLE,
        4 => QUAD,
        _ => POLYGON,
    };
    let integers = |name, numbers: &[u32]| {
        let numbers = numbers.iter().map(|&x| i64::from(x).to_le_bytes());
        DataArray::new(name, 1, "Int64", numbers)
    };
    let types = (0..cells.len()).map(|i| [cell_type(i)]);
    [
        DataArray::new("Points", 3, "Float64", points.map(f64::to_le_bytes)),
        integers("connectivity", &cells.corners),
        integers("offsets", &cells.starts[cells.starts.len().min(1)..]),
        DataArray::new("types", 1, "UInt8", types),
    ]
}

/// A number for each row, repeated for its cells.
fn per_cell(cells: &CellMesh, name: &str, values: &[f64]) -> DataArray {
    let numbers = cells.rows.iter().map(|&row| values[row as usize]);
    DataArray::new(name, 1, "Float64", numbers.map(f64::to_le_bytes))
}

fn integers(cells: &CellMesh, name: &str, of: impl Fn(usize) -> u32) -> DataArray {
    let numbers = cells.rows.iter().map(|&row| of(row as usize) as i32);
    DataArray::new(name, 1, "Int32", numbers.map(i32::to_le_bytes))
}

fn colours<'a>(cells: &CellMesh, name: &str, of: impl Fn(usize) -> &'a Rgb) -> DataArray {
    let colours = cells.rows.iter().map(|&row| of(row as usize).to_array());
    DataArray::new(name, 3, "Float64", colours.flatten().map(f64::to_le_bytes))
}

/// What is known of rows.
fn row_arrays(enclosure: &Enclosure, cells: &CellMesh) -> Vec<DataArray> {
    let (factors, rows) = (&enclosure.factors, &enclosure.rows);
    let sums = if enclosure.elsewhere.is_some() {
        enclosure.operator().sums()
    } else {
        factors.row_sums()
    };
    // What rows lack with all shares counted, which is noise; closure removes it.
    let residual = enclosure.residuals();
    let shares =
        |of: fn(&RowRemainder) -> f64| -> Vec<f64> { factors.rest.iter().map(of).collect() };
    let mut arrays = vec![
        integers(cells, "row", |i| i as u32),
        integers(cells, "object", |i| factors.faces[i].object),
        integers(cells, "side", |i| u32::from(factors.is_back[i])),
        per_cell(cells, "area", &factors.areas),
        per_cell(cells, "sky", &shares(|r| r.sky)),
        per_cell(cells, "ground", &shares(|r| r.ground)),
        per_cell(cells, "hidden", &shares(|r| r.hidden)),
        per_cell(cells, "row_sum", &sums),
        per_cell(cells, "residual", &residual),
        per_cell(cells, "rho_s", &enclosure.mirror_reflectances()),
        colours(cells, "diffuse", |i| &rows.diffuse[i]),
    ];
    // Those of a matrix in blocks are not known.
    if factors.row_errors.len() == factors.len() {
        arrays.push(per_cell(cells, "row_error", &factors.row_errors));
    }
    if let Some(light) = &enclosure.outside {
        arrays.push(colours(cells, "irradiance", |i| &light[i].irradiance));
    }
    arrays
}

/// X from one row to the rows of all cells.
fn factors_from(enclosure: &Enclosure, cells: &CellMesh, name: &str, row: usize) -> DataArray {
    let mut values = vec![0.0; enclosure.len()];
    let entries = enclosure.factors.row(row);
    entries.for_each(|(j, x, _)| values[j as usize] = x);
    per_cell(cells, &format!("{FROM}{name}"), &values)
}

fn write(
    geometry: &[DataArray; 4],
    arrays: &[DataArray],
    cells: &CellMesh,
    out: &mut dyn Write,
) -> io::Result<()> {
    let tags: Vec<_> = arrays.iter().map(DataArray::tag).collect();
    let counts = [cells.points.len(), cells.len()];
    header(counts, geometry.each_ref().map(DataArray::tag), &tags, out)?;
    out.write_all(b"_")?;
    for array in geometry.iter().chain(arrays) {
        array.write(out)?;
    }
    writeln!(out, "\n  </AppendedData>\n</VTKFile>")
}

/// The XML before the data, for these numbers of points and cells. Offsets count from the first byte of data.
fn header(
    [points, cells]: [usize; 2],
    geometry: [ArrayTag<'_>; 4],
    arrays: &[ArrayTag<'_>],
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut offset = 0;
    writeln!(
        out,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <UnstructuredGrid>\n    \
         <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">\n      <Points>"
    )?;
    let [points, cells @ ..] = &geometry;
    data_array(points, &mut offset, out)?;
    writeln!(out, "      </Points>\n      <Cells>")?;
    for array in cells {
        data_array(array, &mut offset, out)?;
    }
    writeln!(out, "      </Cells>\n      <CellData>")?;
    for array in arrays {
        data_array(array, &mut offset, out)?;
    }
    write!(
        out,
        "      </CellData>\n    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n"
    )
}

fn data_array(array: &ArrayTag<'_>, offset: &mut u64, out: &mut dyn Write) -> io::Result<()> {
    write!(
        out,
        "        <DataArray type=\"{}\" Name=\"{}\"",
        array.type_name,
        xml(array.name)
    )?;
    if array.components > 1 {
        write!(out, " NumberOfComponents=\"{}\"", array.components)?;
    }
    writeln!(out, " format=\"appended\" offset=\"{offset}\"/>")?;
    // The length of each array is written before it.
    *offset += size_of::<u64>() as u64 + array.bytes;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_go_beyond_four_gibibytes() {
        const BYTES: u64 = 5 << 30;
        let tag = |name| ArrayTag {
            name,
            components: 1,
            type_name: "Float64",
            bytes: BYTES,
        };
        let mut out = Vec::new();
        let geometry = ["Points", "connectivity", "offsets", "types"].map(tag);
        header([1, 1], geometry, &[tag("a<b")], &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        for (k, name) in ["Points", "connectivity", "offsets", "types", "a&lt;b"]
            .iter()
            .enumerate()
        {
            let offset = k as u64 * (BYTES + 8);
            let expected = format!("Name=\"{name}\" format=\"appended\" offset=\"{offset}\"/>");
            assert!(text.contains(&expected), "{expected}\n{text}");
        }
    }
}
