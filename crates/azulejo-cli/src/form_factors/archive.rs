//! The matrix as an archive for NumPy and SciPy.

use super::NamedMatrix;
use crate::npy::{self, Element};
use crate::npz::Archive;
use azulejo_factors::FormFactors;
use azulejo_factors::form_factors::RowRemainder;
use azulejo_scene::Rgb;
use azulejo_trace::Gathered;
use std::io::{self, Write};
use std::ops::Range;

/// Array names of the separate orders of reflection.
const ORDERS: [[&str; 2]; 3] = [
    ["direct.npy", "direct_error.npy"],
    ["one_mirror.npy", "one_mirror_error.npy"],
    ["more_mirrors.npy", "more_mirrors_error.npy"],
];

/// Writes the arrays of `scipy.sparse.load_npz` (`format`, `shape`, `indptr`, `indices`, `data`);
/// one `std_error` per entry; per row `areas`, `row_error`, `sky`, `sky_error`, `ground`,
/// `ground_error`, `escaped` (sky and ground), `hidden`, `cut`, with light from outside `irradiance` and
/// `irradiance_error` (n × 3), and `names` of groups, or
/// `patch_face` (n × 2: object, face) and `patch_back` (1 for back sides) of patches. Separate
/// orders of reflection are arrays aligned with `data`.
pub fn write(matrix: &NamedMatrix, out: &mut dyn Write) -> io::Result<()> {
    let factors = matrix.factors;
    let rows = MatrixRows::new(factors);
    let mut archive = Archive::new(out);
    archive.add("format.npy", |w| npy::write_bytes(b"csr", w))?;
    archive.add("shape.npy", |w| {
        npy::write(&[2], &[factors.len() as i64; 2], w)
    })?;
    // SciPy requires both index arrays to have one type, and is faster with the smaller one.
    if i32::try_from(rows.entries().max(factors.len())).is_ok() {
        archive.add("indptr.npy", |w| list(&rows.starts, |&x| x as i32, w))?;
        archive.add("indices.npy", |w| rows.write(|(j, ..)| j as i32, w))?;
    } else {
        archive.add("indptr.npy", |w| list(&rows.starts, |&x| x as i64, w))?;
        archive.add("indices.npy", |w| rows.write(|(j, ..)| i64::from(j), w))?;
    }
    archive.add("data.npy", |w| rows.write(|(_, x, _)| x, w))?;
    archive.add("std_error.npy", |w| rows.write(|(.., e)| e, w))?;
    for (order, [values, errors]) in (0..factors.orders.len()).zip(ORDERS) {
        archive.add(values, |w| rows.write_order(order, |(_, x, _)| x, w))?;
        archive.add(errors, |w| rows.write_order(order, |(.., e)| e, w))?;
    }
    archive.add("areas.npy", |w| list(&factors.areas, |&x| x, w))?;
    archive.add("row_error.npy", |w| list(&factors.row_errors, |&x| x, w))?;
    let mut add = |name, share: fn(&RowRemainder) -> f64| {
        archive.add(name, |w| list(&factors.rest, share, w))
    };
    add("sky.npy", |r| r.sky)?;
    add("sky_error.npy", |r| r.sky_error)?;
    add("ground.npy", |r| r.ground)?;
    add("ground_error.npy", |r| r.ground_error)?;
    add("escaped.npy", RowRemainder::escaped)?;
    add("hidden.npy", |r| r.hidden)?;
    add("cut.npy", |r| r.cut)?;
    if let Some(rows) = matrix.outside {
        archive.add("irradiance.npy", |w| colours(rows, Gathered::mean, w))?;
        let error = |row: &Gathered| row.standard_error();
        archive.add("irradiance_error.npy", |w| colours(rows, error, w))?;
    }
    match matrix.names {
        Some(names) => archive.add("names.npy", |w| npy::write_texts(names, w))?,
        None => {
            archive.add("patch_face.npy", |w| {
                npy::write_header(i64::DESCR, &[factors.len(), 2], w)?;
                let numbers = factors.faces.iter().flat_map(|f| [f.object, f.face]);
                numbers.map(i64::from).try_for_each(|x| x.write(w))
            })?;
            archive.add("patch_back.npy", |w| {
                list(&factors.is_back, |&b| i32::from(b), w)
            })?;
        }
    }
    archive.finish()?;
    Ok(())
}

/// An array of red, green and blue for each row.
fn colours(
    rows: &[Gathered],
    of: impl Fn(&Gathered) -> Rgb,
    out: &mut dyn Write,
) -> io::Result<()> {
    npy::write_header(f64::DESCR, &[rows.len(), 3], out)?;
    let mut numbers = rows.iter().flat_map(|row| of(row).to_array());
    numbers.try_for_each(|x: f64| x.write(out))
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
                let mut entries = row.iter().map(|e| super::entry_of(part, e.column));
                entries.try_for_each(|e| convert(e).write(out))?;
            }
        }
        Ok(())
    }
}

/// Writes a one-dimensional array, converting entry by entry to avoid a copy.
fn list<T, E: Element>(
    values: &[T],
    convert: impl Fn(&T) -> E,
    out: &mut dyn Write,
) -> io::Result<()> {
    npy::write_header(E::DESCR, &[values.len()], out)?;
    values.iter().try_for_each(|v| convert(v).write(out))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form_factors::tests::two_squares;
    use crate::npz::tests::members;
    use std::collections::HashMap;

    /// The members of an archive by name: type and shape, and data.
    fn arrays(bytes: &[u8]) -> HashMap<String, (String, Vec<u8>)> {
        let array = |(name, array): (String, Vec<u8>)| {
            let header = usize::from(u16::from_le_bytes([array[8], array[9]]));
            let description = String::from_utf8(array[10..10 + header].to_vec()).unwrap();
            (name, (description, array[10 + header..].to_vec()))
        };
        members(bytes).into_iter().map(array).collect()
    }

    fn f64s((described, bytes): &(String, Vec<u8>)) -> Vec<f64> {
        assert!(described.contains("'<f8'"), "{described}");
        let numbers = bytes.chunks_exact(8);
        numbers
            .map(|b| f64::from_le_bytes(*b.first_chunk().unwrap()))
            .collect()
    }

    fn archive(names: Option<&[String]>) -> HashMap<String, (String, Vec<u8>)> {
        let factors = two_squares();
        let mut bytes = Vec::new();
        let matrix = NamedMatrix {
            factors: &factors,
            names,
            outside: None,
        };
        write(&matrix, &mut bytes).unwrap();
        arrays(&bytes)
    }

    #[test]
    fn both_halves_are_written() {
        let found = archive(None);
        assert_eq!(f64s(&found["data.npy"]), [0.25, 0.5]);
        assert_eq!(found["indices.npy"].1, [1, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(found["indptr.npy"].1, [0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!(f64s(&found["direct.npy"]), [0.125, 0.25]);
        assert_eq!(f64s(&found["one_mirror.npy"]), [0.125, 0.25]);
        assert_eq!(f64s(&found["more_mirrors.npy"]), [0.0, 0.0]);
        assert_eq!(f64s(&found["sky.npy"]), [0.75, 0.5]);
        assert_eq!(f64s(&found["areas.npy"]), [2.0, 1.0]);
        assert!(found["patch_face.npy"].0.contains("(2, 2)") && !found.contains_key("names.npy"));
    }

    #[test]
    fn groups_have_names() {
        let found = archive(Some(&["a".to_owned(), "wän".to_owned()]));
        let (described, bytes) = &found["names.npy"];
        assert!(
            described.contains("'<U3'") && described.contains("(2,)"),
            "{described}"
        );
        assert_eq!(bytes[..16], *b"a\0\0\0\0\0\0\0\0\0\0\0w\0\0\0");
        assert!(!found.contains_key("patch_face.npy"));
    }

    /// Reads with SciPy, where Python has it.
    #[test]
    fn scipy_reads_the_archive() {
        let Some(python) = azulejo_testing::python() else {
            return;
        };
        let path = std::env::temp_dir().join(format!("azulejo-{}.npz", std::process::id()));
        let mut file = std::fs::File::create(&path).unwrap();
        let (factors, names) = (two_squares(), ["floor".to_owned(), "wänd".to_owned()]);
        let matrix = NamedMatrix {
            factors: &factors,
            names: Some(&names),
            outside: None,
        };
        write(&matrix, &mut file).unwrap();
        let script = "import sys, numpy, scipy.sparse as s\n\
            f = s.load_npz(sys.argv[1]); assert f.format == 'csr'\n\
            assert (f.toarray() == [[0, 0.25], [0.5, 0]]).all()\n\
            z = numpy.load(sys.argv[1])\n\
            assert z['names'].tolist() == ['floor', 'wänd']\n\
            d = s.csr_matrix((z['direct'], z['indices'], z['indptr']), z['shape'])\n\
            assert (d.toarray() == [[0, 0.125], [0.25, 0]]).all()\n\
            assert z['areas'].tolist() == [2, 1] and z['std_error'].tolist() == [0.125, 0.25]\n";
        let status = std::process::Command::new(python)
            .args(["-c", script])
            .arg(&path)
            .status();
        std::fs::remove_file(&path).unwrap();
        assert!(status.unwrap().success());
    }
}
