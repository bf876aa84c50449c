//! Files of matrices, for other programs.
//!
//! A [`FactorFormat`] has a name, extensions and a description in one table, from which the command
//! line and Python take theirs. [`prepare`](FactorFormat::prepare) checks everything and returns the
//! files to write with notes about what their program will not see; nothing is written before.
//!
//! Solvers of diffuse exchange take direct factors. Where mirrors or glass take part in X, these
//! formats write [`FormFactors::orders`](azulejo_factors::FormFactors::orders)`[0]`, or refuse if
//! the orders were not kept apart.

mod calculix;
pub mod csv;
mod direct;
mod elmer;
mod energyplus;
mod error;
mod format;
mod matrix_market;
mod moose;
mod nastran;
mod netcdf;
mod notes;
pub mod openfoam;
#[cfg(test)]
mod tests;
pub(crate) mod text;
mod udales;
pub mod view3d;
mod vtu;

pub use error::FactorFileError;
pub use format::{FactorFormat, FormatEntry};

use crate::archive::{self, ArchivePrecision};
use crate::enclosure::Enclosure;
use openfoam::OpenFoamCase;
use std::io::{self, Write};
use view3d::View3dTable;

/// What formats need to know beyond the matrix.
#[derive(Clone, Debug, Default)]
pub struct FileOptions {
    /// How exactly an archive stores factors.
    pub precision: ArchivePrecision,
    /// Header and emissivities of a View3D file; by default those of a plain matrix whose rows
    /// absorb as their materials do.
    pub view3d: Option<View3dTable>,
    /// Further numbers for each row, by name, for VTU.
    pub arrays: Vec<(String, Vec<f64>)>,
    /// Names of rows whose factors VTU gets as arrays `F_from_NAME`.
    pub shown_rows: Vec<String>,
    /// The zone, space or enclosure of EnergyPlus; `Zone` if not given.
    pub zone: Option<String>,
    /// The case that OpenFOAM's files are for.
    pub case: Option<OpenFoamCase>,
    /// The version of CalculiX, which reads files of its own version only; 2.20 if not given.
    pub calculix: Option<String>,
    /// The experiment of uDALES, which is the suffix of its files.
    pub experiment: Option<String>,
}

/// Files that belong together, checked and ready to be written.
pub struct FactorFiles<'a> {
    /// The files, in the order in which they should be put in place.
    pub files: Vec<FactorFile<'a>>,
    /// Sentences about what the program that reads the files will not see, or must be told.
    pub notes: Vec<String>,
}

/// A file to be written.
pub struct FactorFile<'a> {
    /// Its name within the folder that was chosen; empty for formats of a single file, which the
    /// user names.
    pub name: String,
    writer: Writer<'a>,
}

type Writer<'a> = Box<dyn Fn(&mut dyn Write) -> io::Result<()> + 'a>;

impl FactorFile<'_> {
    /// Writes the content.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        (self.writer)(out)
    }
}

impl<'a> FactorFiles<'a> {
    /// A single file without notes.
    fn single(writer: impl Fn(&mut dyn Write) -> io::Result<()> + 'a) -> FactorFiles<'a> {
        let mut files = FactorFiles::new();
        files.add("", writer);
        files
    }

    fn new() -> FactorFiles<'a> {
        FactorFiles {
            files: Vec::new(),
            notes: Vec::new(),
        }
    }

    fn add(
        &mut self,
        name: impl Into<String>,
        writer: impl Fn(&mut dyn Write) -> io::Result<()> + 'a,
    ) {
        self.files.push(FactorFile {
            name: name.into(),
            writer: Box::new(writer),
        });
    }
}

impl FactorFormat {
    /// Checks that a matrix can be written in this format, and prepares its files.
    ///
    /// # Errors
    /// [`FactorFileError`]: rows that the program does not have, names that it cannot read, mirrors, blocks.
    pub fn prepare<'a>(
        self,
        enclosure: &'a Enclosure,
        options: &'a FileOptions,
    ) -> Result<FactorFiles<'a>, FactorFileError> {
        use FactorFormat as F;
        // Polygons show what is known of rows; only factors of single rows need the matrix itself.
        let shows_rows_alone = self == F::Vtu && options.shown_rows.is_empty();
        if enclosure.elsewhere.is_some() && !shows_rows_alone {
            return Err(FactorFileError::Elsewhere);
        }
        match self {
            F::Npz => Ok(FactorFiles::single(|out| {
                archive::write(enclosure, options.precision, out)
            })),
            F::Csv => Ok(FactorFiles::single(|out| csv::write(enclosure, out))),
            F::View3d | F::View3dBinary => Ok(view3d::prepare(self, enclosure, options)),
            F::Vtu => vtu::prepare(enclosure, options),
            F::OpenFoam => openfoam::prepare(enclosure, options, false),
            F::OpenFoamBinary => openfoam::prepare(enclosure, options, true),
            F::EnergyPlus => energyplus::prepare(enclosure, options, energyplus::write_idf),
            F::EnergyPlusJson => energyplus::prepare(enclosure, options, energyplus::write_json),
            F::Udales => udales::prepare(enclosure, options),
            F::CalculiX => calculix::prepare(enclosure, options),
            F::Elmer => elmer::prepare(enclosure, elmer::write_text),
            F::ElmerBinary => elmer::prepare(enclosure, elmer::write_binary),
            F::Moose => moose::prepare(enclosure),
            F::Nastran => nastran::prepare(enclosure, nastran::Dialect::Modern),
            F::NastranClassic => nastran::prepare(enclosure, nastran::Dialect::Classic),
            F::MatrixMarket => Ok(FactorFiles::single(|out| {
                matrix_market::write(enclosure, out)
            })),
        }
    }
}

/// Writes a matrix in a format of a single file, and returns notes about it.
///
/// # Errors
/// [`FactorFileError`]: what [`prepare`](FactorFormat::prepare) refuses, formats of several files,
/// and errors of `out`.
pub fn write(
    enclosure: &Enclosure,
    format: FactorFormat,
    options: &FileOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, FactorFileError> {
    let FactorFiles { files, notes } = format.prepare(enclosure, options)?;
    let [file] = &files[..] else {
        return Err(FactorFileError::SeveralFiles {
            format: format.name(),
        });
    };
    file.write(out).map_err(FactorFileError::Writing)?;
    Ok(notes)
}
