//! Matrices to files and back, and those of other programs.

use crate::error::{file_error, output_error, refused};
use crate::form_factors::NativeFormFactors;
use crate::work::{self, WorkOptions};
use azulejo::output::{Output, commit};
use azulejo_exchange::archive::{self, ArchivePrecision, StoredFactors};
use azulejo_exchange::files::openfoam::{OpenFoamCase, OpenFoamVersion};
use azulejo_exchange::files::{FactorFiles, FactorFormat, FileOptions};
use azulejo_exchange::{Enclosure, RowTable};
use azulejo_factors::form_factors::RowRemainder;
use azulejo_factors::{EngineUsed, FaceId, FormFactors};
use azulejo_scene::{Rgb, Up};
use azulejo_trace::Progress;
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyIsADirectoryError;
use pyo3::prelude::*;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// Options of formats by name.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct FileArgs {
    format: Option<String>,
    precision: String,
    rows: Vec<String>,
    zone: Option<String>,
    version: Option<String>,
}

/// Where files go, checked before anything is prepared.
struct Target {
    format: FactorFormat,
    options: FileOptions,
    output: Output,
    folder: PathBuf,
}

impl FileArgs {
    fn format(&self, path: &Path) -> PyResult<FactorFormat> {
        match &self.format {
            Some(name) => FactorFormat::from_name(name).ok_or_else(|| {
                let table = FactorFormat::table().iter();
                let names: Vec<&str> = table.map(|e| e.name).collect();
                refused(azulejo::spelling::unknown("format", name, &names))
            }),
            None => FactorFormat::from_path(path).ok_or_else(|| {
                let what = if is_zarr(path) {
                    NO_ZARR
                } else if path.is_dir() {
                    "a folder: format=\"openfoam\" writes to the folder of a case"
                } else {
                    "unknown matrix format, expected .npz, .csv, .txt or .vf (View3D), .vtu, .idf, \
                     .epjson, .vwf, .dat, .i, .bdf, .mtx or format="
                };
                refused(format_args!("{}: {what}", path.display()))
            }),
        }
    }

    fn options(&self, format: FactorFormat) -> PyResult<FileOptions> {
        let precision = match self.precision.as_str() {
            "auto" => ArchivePrecision::Auto,
            "single" => ArchivePrecision::Single,
            "double" => ArchivePrecision::Double,
            other => {
                let known = ["auto", "single", "double"];
                return Err(refused(azulejo::spelling::unknown(
                    "precision",
                    other,
                    &known,
                )));
            }
        };
        let calculix = (format == FactorFormat::CalculiX).then(|| self.version.clone());
        Ok(FileOptions {
            precision,
            shown_rows: self.rows.clone(),
            zone: self.zone.clone(),
            calculix: calculix.flatten(),
            ..FileOptions::default()
        })
    }

    fn case(&self, path: &Path) -> PyResult<OpenFoamCase> {
        let known = |word: &String| {
            OpenFoamVersion::from_word(word).ok_or_else(|| {
                refused(format_args!(
                    "unknown version of OpenFOAM \"{word}\", expected v1912, v2312 or org"
                ))
            })
        };
        let version = self.version.as_ref().map(known).transpose()?;
        let environment_version = || {
            let word = std::env::var("WM_PROJECT_VERSION").ok()?;
            OpenFoamVersion::from_word(&word)
        };
        OpenFoamCase::open(path, version.or_else(environment_version)).map_err(refused)
    }

    fn target(&self, path: &Path) -> PyResult<Target> {
        let format = self.format(path)?;
        let mut options = self.options(format)?;
        let mut folder = PathBuf::new();
        let file = match format {
            FactorFormat::OpenFoam | FactorFormat::OpenFoamBinary => {
                let case = self.case(path)?;
                folder.clone_from(&case.folder);
                options.case = Some(case);
                folder.join("F")
            }
            FactorFormat::Udales => {
                let name = path.file_name().and_then(|n| n.to_str()).unwrap_or("");
                options.experiment = name.rsplit_once(".inp.").map(|(_, e)| e.to_owned());
                folder = path.with_file_name("");
                path.to_owned()
            }
            _ => path.to_owned(),
        };
        Ok(Target {
            output: Output::check(&file).map_err(output_error)?,
            format,
            options,
            folder,
        })
    }
}

impl Target {
    /// Writes all files, or none; returns their names, and notes about them.
    fn write(
        &self,
        enclosure: &Enclosure,
        progress: &Progress,
    ) -> PyResult<(Vec<String>, Vec<String>)> {
        let prepared = self.format.prepare(enclosure, &self.options);
        let FactorFiles { files, notes } = prepared.map_err(refused)?;
        let (mut drafts, mut names) = (Vec::new(), Vec::new());
        for file in &files {
            let own = match file.name.as_str() {
                "" => None,
                name => Some(Output::check(&self.folder.join(name)).map_err(output_error)?),
            };
            let output = own.as_ref().unwrap_or(&self.output);
            let mut draft = output.draft().map_err(output_error)?;
            let written = file.write(&mut draft);
            written.map_err(|e| output_error(output.error(e)))?;
            drafts.push(draft);
            names.push(output.path().display().to_string());
        }
        commit(drafts, progress).map_err(output_error)?;
        Ok((names, notes))
    }
}

/// Writes a matrix; returns the names of the files, and what their program must be told.
#[pyfunction]
pub fn save_form_factors(
    py: Python<'_>,
    factors: &NativeFormFactors,
    path: PathBuf,
    options: FileArgs,
) -> PyResult<(Vec<String>, Vec<String>)> {
    let enclosure = factors.enclosure.clone();
    work::run(py, &WorkOptions::new(None, None), move |p| {
        options.target(&path)?.write(&enclosure, p)
    })
}

/// Reads an archive, and the largest difference of both directions of a pair.
#[pyfunction]
pub fn load_form_factors(
    py: Python<'_>,
    path: PathBuf,
    memory: Option<u64>,
) -> PyResult<(NativeFormFactors, f64)> {
    let read = work::run(py, &WorkOptions::new(None, None), move |_| {
        if is_zarr(&path) {
            return Err(refused(format_args!("{}: {NO_ZARR}", path.display())));
        }
        if path.is_dir() {
            let message = format!("{} is a folder, expected an .npz", path.display());
            return Err(PyIsADirectoryError::new_err(message));
        }
        let file = File::open(&path).map_err(|e| file_error(e, &path))?;
        let budget = memory.or_else(azulejo::machine::memory);
        let read = archive::open(BufReader::new(file), budget.unwrap_or(u64::MAX));
        match read.map_err(|e| refused(format_args!("{}: {e}", path.display())))? {
            StoredFactors::Whole(read) => Ok(*read),
            StoredFactors::Blocks(_) => Err(refused(format_args!(
                "{}: the matrix is compressed into blocks, which have no single entries: use \
                 CompressedFactors.load",
                path.display()
            ))),
        }
    })?;
    let mut enclosure = read.enclosure;
    if enclosure.rows.cells.is_empty() {
        // A matrix of another program, whose rows are not patches of ours.
        enclosure.rows.are_groups = true;
        let engine = &mut enclosure.factors.engine_used.name;
        if engine.is_empty() {
            GIVEN.clone_into(engine);
        }
    }
    Ok((NativeFormFactors::new(enclosure), read.asymmetry))
}

/// A matrix of another program: compressed rows that have been checked, areas, mirror reflectances,
/// the share of each row that goes to the sky, where that is known, and names.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "they are the parts of a matrix")]
pub fn foreign_form_factors(
    py: Python<'_>,
    starts: PyReadonlyArray1<'_, i64>,
    columns: PyReadonlyArray1<'_, i64>,
    values: PyReadonlyArray1<'_, f64>,
    areas: PyReadonlyArray1<'_, f64>,
    mirrors: PyReadonlyArray1<'_, f64>,
    sky: PyReadonlyArray1<'_, f64>,
    names: Vec<String>,
    unit: Option<f64>,
) -> PyResult<(NativeFormFactors, f64)> {
    let count = areas.as_array().len();
    let fits = [mirrors.as_array().len(), sky.as_array().len(), names.len()] == [count; 3];
    let starts: Vec<usize> = starts.as_array().iter().map(|&s| s as usize).collect();
    let whole: Option<Vec<u32>> = (columns.as_array().iter())
        .map(|&c| u32::try_from(c).ok().filter(|&c| (c as usize) < count))
        .collect();
    let values = values.as_array().to_vec();
    let is_whole = starts.len() == count + 1
        && starts.first() == Some(&0)
        && starts.is_sorted()
        && starts.last() == Some(&values.len());
    let columns = whole.filter(|c| c.len() == values.len() && is_whole && fits);
    let columns = columns.ok_or_else(|| refused("the parts of the matrix do not fit together"))?;
    let (areas, mirrors) = (areas.as_array().to_vec(), mirrors.as_array().to_vec());
    let sky = sky.as_array().to_vec();
    let made = work::run(py, &WorkOptions::new(None, None), move |_| {
        let (exchange, asymmetry) = archive::reciprocal(&starts, &columns, &values, &areas);
        let mut factors = FormFactors {
            exchange,
            faces: vec![FaceId { object: 0, face: 0 }; count],
            materials: vec![0; count],
            is_back: vec![false; count],
            ends: mirrors.iter().map(|m| 1.0 - m).collect(),
            row_errors: vec![0.0; count],
            rest: vec![RowRemainder::default(); count],
            engine_used: EngineUsed {
                name: GIVEN.to_owned(),
                ..EngineUsed::default()
            },
            areas,
            ..FormFactors::default()
        };
        let ended = factors.ended();
        for ((rest, ended), sky) in factors.rest.iter_mut().zip(ended).zip(&sky) {
            // NaN: what is missing.
            rest.sky = if sky.is_nan() {
                (1.0 - ended).max(0.0)
            } else {
                *sky
            };
        }
        factors.is_closed = factors.rest.iter().all(|r| r.sky <= OPEN);
        let rows = RowTable {
            names: azulejo_exchange::enclosure::unique(names),
            are_groups: true,
            objects: vec!["object 0".to_owned()],
            materials: vec!["material 0".to_owned()],
            diffuse: vec![Rgb::BLACK; count],
            metres_per_unit: unit,
            up: Up::Z,
            ..RowTable::default()
        };
        let enclosure = Enclosure {
            factors,
            rows,
            outside: None,
            sky: None,
            elsewhere: None,
        };
        Ok((enclosure, asymmetry))
    });
    let (enclosure, asymmetry) = made?;
    Ok((NativeFormFactors::new(enclosure), asymmetry))
}

/// What those are told who ask for a Zarr store, which early versions had for matrices larger than memory.
const NO_ZARR: &str = "stores in chunks (.zarr) are neither read nor written any more, expected .npz; where a \
                       matrix is larger than memory, form_factors(compress=1e-3) makes blocks";

/// Whether this was a store of chunks in early versions, by its name.
fn is_zarr(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("zarr"))
}

/// The engine of matrices that were not computed here.
const GIVEN: &str = "given";

/// Share of a row's light from which it is open.
const OPEN: f64 = 1e-6;
