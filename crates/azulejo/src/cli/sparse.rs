//! The matrix of form factors in files, as SciPy and as spreadsheets read it.

use super::npy::{self, Element};
use super::npz::Archive;
use azulejo_radiosity::{FaceId, FormFactors};
use std::io::{self, Write};
use std::ops::Range;

/// Writes what `scipy.sparse.load_npz` reads (`format`, `shape`, `indptr`, `indices`, `data`),
/// and beside it `std_error` (one per entry), `areas`, `patch_face` (n × 2: object, face),
/// `patch_back` (n: 1 for back sides), `escaped` and `row_error` (n: share of light that leaves
/// the scene; error to be expected of the whole row).
pub fn write_npz(factors: &FormFactors, out: &mut dyn Write) -> io::Result<()> {
    let rows = Rows::new(factors);
    let mut archive = Archive::new(out);
    archive.add("format.npy", |w| npy::write_bytes(b"csr", w))?;
    archive.add("shape.npy", |w| {
        npy::write(&[2], &[factors.len() as i64; 2], w)
    })?;
    // SciPy wants both index arrays of one type, and works faster on the small one.
    if i32::try_from(rows.entries().max(factors.len())).is_ok() {
        archive.add("indptr.npy", |w| list(&rows.starts, |&x| x as i32, w))?;
        archive.add("indices.npy", |w| rows.write(|(j, ..)| j as i32, w))?;
    } else {
        archive.add("indptr.npy", |w| list(&rows.starts, |&x| x as i64, w))?;
        archive.add("indices.npy", |w| rows.write(|(j, ..)| i64::from(j), w))?;
    }
    archive.add("data.npy", |w| rows.write(|(_, x, _)| x, w))?;
    archive.add("std_error.npy", |w| rows.write(|(.., e)| e, w))?;
    archive.add("areas.npy", |w| list(&factors.areas, |&x| x, w))?;
    archive.add("patch_face.npy", |w| {
        npy::write_header(i64::DESCR, &[factors.len(), 2], w)?;
        let numbers = factors.faces.iter().flat_map(|f| [f.object, f.face]);
        numbers.map(i64::from).try_for_each(|x| x.write(w))
    })?;
    archive.add("patch_back.npy", |w| {
        list(&factors.is_back, |&b| i32::from(b), w)
    })?;
    archive.add("escaped.npy", |w| list(&factors.rest, |r| r.escaped(), w))?;
    archive.add("row_error.npy", |w| list(&factors.row_errors, |&x| x, w))?;
    archive.finish()?;
    Ok(())
}

/// Writes one line per entry: i, j, F_ij, its standard error, and patch i's area, object, face
/// and side.
pub fn write_csv(factors: &FormFactors, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "i,j,f_ij,std_error,area_i,object_i,face_i,side_i")?;
    for block in factors.blocks() {
        for (i, row) in block.clone().zip(factors.rows(block)) {
            let FaceId { object, face } = factors.faces[i];
            let side = if factors.is_back[i] { "back" } else { "front" };
            let area = factors.areas[i];
            for (j, f, e) in row {
                writeln!(out, "{i},{j},{f},{e},{area},{object},{face},{side}")?;
            }
        }
    }
    Ok(())
}

/// The whole rows of a matrix, of which half is in memory.
struct Rows<'a> {
    factors: &'a FormFactors,
    blocks: Vec<Range<usize>>,
    /// Where each row starts, and after the last where it ends.
    starts: Vec<usize>,
}

impl Rows<'_> {
    fn new(factors: &FormFactors) -> Rows<'_> {
        let mut starts = vec![0];
        for length in factors.exchange.row_lengths() {
            starts.push(starts[starts.len() - 1] + length);
        }
        Rows {
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
            for entry in self.factors.rows(block.clone()).into_iter().flatten() {
                convert(entry).write(out)?;
            }
        }
        Ok(())
    }
}

/// A one-dimensional array, converted entry by entry so that nothing is copied.
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
    use azulejo_radiosity::form_factors::{Exchange, ExchangeAreas, Rest};

    fn two_squares() -> FormFactors {
        let face = |object, face| FaceId { object, face };
        let pair = Exchange {
            column: 1,
            value: 0.5,
            error: 0.25,
        };
        FormFactors {
            exchange: ExchangeAreas::from_iter([vec![pair], vec![]]),
            areas: vec![2.0, 1.0],
            faces: vec![face(0, 3), face(7, 0)],
            is_back: vec![false, true],
            rest: [0.75, 0.5]
                .map(|sky| Rest {
                    sky,
                    ..Rest::default()
                })
                .to_vec(),
            row_errors: vec![0.1, 0.2],
            ..FormFactors::default()
        }
    }

    #[test]
    fn csv_is_one_line_per_entry() {
        let mut text = Vec::new();
        write_csv(&two_squares(), &mut text).unwrap();
        assert_eq!(
            String::from_utf8(text).unwrap(),
            "i,j,f_ij,std_error,area_i,object_i,face_i,side_i\n\
             0,1,0.25,0.125,2,0,3,front\n1,0,0.5,0.25,1,7,0,back\n"
        );
    }

    /// Asks SciPy itself, where there is one: `AZULEJO_PYTHON` names a Python that has it.
    #[test]
    fn scipy_reads_the_archive() {
        let Some(python) = std::env::var_os("AZULEJO_PYTHON") else {
            let _ = writeln!(io::stderr(), "skipped: AZULEJO_PYTHON is not set");
            return;
        };
        let path = std::env::temp_dir().join(format!("azulejo-{}.npz", std::process::id()));
        let mut file = std::fs::File::create(&path).unwrap();
        write_npz(&two_squares(), &mut file).unwrap();
        let script = "import sys, numpy, scipy.sparse as s\n\
            f = s.load_npz(sys.argv[1]); assert f.format == 'csr'\n\
            assert (f.toarray() == [[0, 0.25], [0.5, 0]]).all()\n\
            z = numpy.load(sys.argv[1])\n\
            assert z['patch_face'].tolist() == [[0, 3], [7, 0]]\n\
            assert z['areas'].tolist() == [2, 1] and z['std_error'].tolist() == [0.125, 0.25]\n";
        let status = std::process::Command::new(python)
            .args(["-c", script])
            .arg(&path)
            .status();
        std::fs::remove_file(&path).unwrap();
        assert!(status.unwrap().success());
    }
}
