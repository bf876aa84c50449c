//! Files of OpenFOAM's view factor model, in the folder of a case's `polyMesh`.
//!
//! | file | content |
//! |---|---|
//! | `F` | factors of the rows that each row sees |
//! | `globalFaceFaces` | the numbers of these rows |
//! | `finalAgglom` | the row of each face, for each patch, from 0 |
//! | `mapDist`; `subMap`, `constructMap`, `constructMapDim` at openfoam.org | which processor has which row: one has all |
//!
//! Rows are faces of the patches that take part, clusters of them, or whole patches, in the order of
//! `polyMesh/boundary`.

mod boundary;
mod case;
mod rows;
#[cfg(test)]
mod tests;

pub use boundary::{BoundaryPatch, read_boundary};
pub use case::{OpenFoamCase, OpenFoamVersion};

use super::direct::DirectFactors;
use super::text::general;
use super::{FactorFileError, FactorFiles, FileOptions, notes};
use crate::enclosure::Enclosure;
use rows::CaseRows;
use std::io::{self, Write};
use std::rc::Rc;

/// Digits of factors as text: results of linear solvers are compared to more than the usual nine.
const DIGITS: usize = 15;

/// Factor of a row with itself from which versions that ignore it are off.
const BENT: f64 = 1e-6;

pub(super) fn prepare<'a>(
    enclosure: &'a Enclosure,
    options: &'a FileOptions,
    is_binary: bool,
) -> Result<FactorFiles<'a>, FactorFileError> {
    let Some(case) = &options.case else {
        return Err(FactorFileError::Missing {
            format: "openfoam",
            message: "no case, expected the folder of one as output",
        });
    };
    let rows = CaseRows::new(enclosure, case)?;
    let factors = DirectFactors::reordered(enclosure, &rows.rows, "OpenFOAM")?;
    refuse_bent(&factors, case.version)?;
    let mut notes = notes_about(enclosure, case, &rows);
    notes.extend(about_left_out(&rows, &factors));
    let factors = Rc::new(factors);
    let writer = FoamWriter {
        location: case.location(),
        is_binary,
    };
    let mut files = FactorFiles::new();
    add_factors(&factors, &writer, &mut files);
    let w = writer.clone();
    files.add("finalAgglom", move |out| {
        w.header("labelListList", "finalAgglom", out)?;
        w.lists(&rows.agglomeration, out)
    });
    add_maps(factors.len(), case.version, &writer, &mut files);
    files.notes = notes;
    Ok(files)
}

/// v2312's solver drops the factor of a row with itself.
fn refuse_bent(
    factors: &DirectFactors<'_>,
    version: OpenFoamVersion,
) -> Result<(), FactorFileError> {
    let own = factors.diagonal();
    let bent = own.iter().filter(|&&f| f > BENT).count();
    if version != OpenFoamVersion::V2312 || bent == 0 {
        return Ok(());
    }
    let most = own.iter().copied().fold(0.0, f64::max);
    Err(FactorFileError::Rows {
        program: "OpenFOAM",
        message: format!(
            "found {bent} of {} rows that see themselves, with a factor of up to {}, expected flat \
             rows (of clusters: --cluster-angle 0): this version ignores the light between parts of a row",
            own.len(),
            general(most, 3)
        ),
    })
}

fn notes_about(enclosure: &Enclosure, case: &OpenFoamCase, rows: &CaseRows) -> Vec<String> {
    let mut notes = notes::about_losses(enclosure, "OpenFOAM");
    notes.push("for serial runs: the files of parallel ones are numbered by processor".to_owned());
    match case.version {
        OpenFoamVersion::V1912 => {}
        OpenFoamVersion::V2312 => {
            notes.push("set useDirectSolver true in viewFactorCoeffs: the other solver takes one number for both \
                        directions of a pair".to_owned());
        }
        OpenFoamVersion::Org => notes.push(format!(
            "patches that take part are those with rows ({}): the condition of qr must be \
             greyDiffusiveRadiationViewFactor on these, and no others",
            rows.taking_part.join(", ")
        )),
    }
    notes
}

/// A note about patches that take no part, which stand in the way, but give and get nothing.
fn about_left_out(rows: &CaseRows, factors: &DirectFactors<'_>) -> Option<String> {
    let least = factors.sums().into_iter().fold(1.0, f64::min);
    (!rows.left_out.is_empty()).then(|| {
        format!(
            "without rows, as they take no part: {}; row sums are down to {}",
            rows.left_out.join(", "),
            general(least, 6)
        )
    })
}

fn add_factors<'a>(
    factors: &Rc<DirectFactors<'a>>,
    writer: &FoamWriter,
    files: &mut FactorFiles<'a>,
) {
    let (f, w) = (factors.clone(), writer.clone());
    files.add("F", move |out| {
        w.header("scalarListList", "F", out)?;
        w.begin(f.len(), out)?;
        f.each_row(|_, row| w.scalars(row.iter().map(|(_, f)| *f), out))?;
        w.end(out)
    });
    let (f, w) = (factors.clone(), writer.clone());
    files.add("globalFaceFaces", move |out| {
        w.header("labelListList", "globalFaceFaces", out)?;
        w.begin(f.len(), out)?;
        f.each_row(|_, row| w.labels(row.iter().map(|(j, _)| *j), out))?;
        w.end(out)
    });
}

/// The map of rows to processors: the identity. Its lists are short, and always text.
fn add_maps(
    rows: usize,
    version: OpenFoamVersion,
    writer: &FoamWriter,
    files: &mut FactorFiles<'_>,
) {
    let w = FoamWriter {
        is_binary: false,
        ..writer.clone()
    };
    // Number of rows, both directions, whether they are flipped, perhaps the communicator, and no
    // transformation.
    let flags = match version {
        OpenFoamVersion::V1912 => "0 0",
        OpenFoamVersion::V2312 => "0 0 0",
        OpenFoamVersion::Org => return add_org_maps(rows, w, files),
    };
    files.add("mapDist", move |out| {
        w.header("mapDistribute", "mapDist", out)?;
        writeln!(out, "{rows}")?;
        w.identity(rows, out)?;
        w.identity(rows, out)?;
        writeln!(out, "{flags}\n0()\n0()")
    });
}

fn add_org_maps(rows: usize, writer: FoamWriter, files: &mut FactorFiles<'_>) {
    for name in ["subMap", "constructMap"] {
        let w = writer.clone();
        files.add(name, move |out| {
            w.header("labelListList", name, out)?;
            w.identity(rows, out)
        });
    }
    files.add("constructMapDim", move |out| {
        writer.header("labelList", "constructMapDim", out)?;
        writeln!(out, "1({rows})")
    });
}

/// Lists in OpenFOAM's notation.
#[derive(Clone)]
struct FoamWriter {
    location: String,
    is_binary: bool,
}

impl FoamWriter {
    fn header(&self, class: &str, name: &str, out: &mut dyn Write) -> io::Result<()> {
        let format = if self.is_binary {
            "binary;\n    arch        \"LSB;label=32;scalar=64\";"
        } else {
            "ascii;"
        };
        writeln!(
            out,
            "FoamFile\n{{\n    version     2.0;\n    format      {format}\n    class       {class};\n    \
             location    \"{}\";\n    object      {name};\n}}\n",
            self.location
        )
    }

    fn begin(&self, length: usize, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{length}\n(")
    }

    fn end(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, ")")
    }

    fn lists(&self, lists: &[Vec<u32>], out: &mut dyn Write) -> io::Result<()> {
        self.begin(lists.len(), out)?;
        for list in lists {
            self.labels(list.iter().copied(), out)?;
        }
        self.end(out)
    }

    fn identity(&self, rows: usize, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "1\n(")?;
        self.labels(0..rows as u32, out)?;
        writeln!(out, ")")
    }

    fn scalars(
        &self,
        list: impl ExactSizeIterator<Item = f64>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        self.list(list, |f| general(f, DIGITS), f64::to_le_bytes, out)
    }

    fn labels(
        &self,
        list: impl ExactSizeIterator<Item = u32>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        self.list(list, |j| j.to_string(), u32::to_le_bytes, out)
    }

    fn list<T: Copy, const N: usize>(
        &self,
        mut list: impl ExactSizeIterator<Item = T>,
        word: impl Fn(T) -> String,
        bytes: impl Fn(T) -> [u8; N],
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let length = list.len();
        if !self.is_binary {
            let words: Vec<String> = list.map(word).collect();
            return writeln!(out, "{length}({})", words.join(" "));
        }
        // Nothing follows the length of an empty list of bytes, no brackets either.
        if length == 0 {
            return writeln!(out, "0");
        }
        write!(out, "{length}\n(")?;
        list.try_for_each(|x| out.write_all(&bytes(x)))?;
        writeln!(out, ")")
    }
}
