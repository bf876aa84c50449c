//! Matrices in blocks between clusters, which products know and single entries do not.

use crate::error::{factors_error, file_error, output_error, refused};
use crate::form_factors::{NativeFormFactors, OptionArgs};
use crate::scene::NativeScene;
use crate::work::{self, WorkOptions};
use azulejo::output::{Output, commit};
use azulejo_exchange::OutsideLight;
use azulejo_exchange::archive::{self, BlockArchive, StoredFactors};
use azulejo_factors::form_factors::Plan;
use azulejo_factors::hierarchy::{CompressionError, FactorOperator, StatedFactors};
use azulejo_factors::{CompressionOptions, FormFactorOptions};
use azulejo_scene::Scene;
use azulejo_scene::sky::SkyDivision;
use azulejo_trace::Progress;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyIsADirectoryError;
use pyo3::prelude::*;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
use std::sync::Arc;

/// Values, and their standard errors.
type ArrayPair<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// A matrix in blocks. It never changes.
#[pyclass(frozen, module = "pyazulejo._pyazulejo")]
pub struct NativeCompressedFactors {
    archive: Arc<BlockArchive>,
}

/// Computes form factors in blocks, and says what of the scene makes them wrong.
#[pyfunction]
pub fn compute_compressed_factors(
    py: Python<'_>,
    scene: &NativeScene,
    compress: f64,
    options: OptionArgs,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(NativeCompressedFactors, Vec<String>)> {
    let (shared, periods) = (scene.shared(), options.periods()?);
    let (sky, options) = (options.sky()?, options.options()?);
    let (archive, flaws) = work::run(py, &WorkOptions::new(threads, progress), move |p| {
        let tracer = shared.repeated(periods)?;
        compute(&shared.scene, &tracer, (compress, sky), &options, p)
    })?;
    let archive = Arc::new(archive);
    Ok((NativeCompressedFactors { archive }, flaws))
}

/// As the command, step by step, so that the bits are the same.
fn compute(
    scene: &Scene,
    tracer: &azulejo_trace::Tracer,
    (tolerance, sky): (f64, Option<(SkyDivision, f64)>),
    options: &FormFactorOptions,
    progress: &Progress,
) -> PyResult<(BlockArchive, Vec<String>)> {
    let plan = Plan::new(scene, tracer, options).map_err(factors_error)?;
    let prepared = plan.prepare();
    let compression = CompressionOptions {
        tolerance,
        keep_sums: true,
    };
    let stated = StatedFactors::of(&prepared, &compression, progress);
    let stated = stated.map_err(|e| match e {
        CompressionError::Factors(e) => factors_error(e),
        other => refused(other),
    })?;
    let mut archive = BlockArchive::of(&prepared, scene, stated, tolerance);
    let factors = &archive.enclosure.factors;
    let outside = OutsideLight::of_rows(&prepared, scene, factors, progress);
    archive.enclosure.outside = outside.map_err(factors_error)?;
    if let Some((division, north)) = sky {
        let factors = &archive.enclosure.factors;
        let seen = prepared.sky_factors(division, north, factors, progress);
        archive.enclosure.sky = Some(seen.map_err(factors_error)?);
    }
    Ok((archive, plan.flaws()))
}

/// Reads blocks that were saved.
#[pyfunction]
pub fn load_compressed_factors(
    py: Python<'_>,
    path: PathBuf,
    memory: Option<u64>,
) -> PyResult<NativeCompressedFactors> {
    let archive = work::run(py, &WorkOptions::new(None, None), move |_| {
        if path.is_dir() {
            let message = format!("{} is a folder, expected an .npz", path.display());
            return Err(PyIsADirectoryError::new_err(message));
        }
        let file = File::open(&path).map_err(|e| file_error(e, &path))?;
        let budget = memory.or_else(azulejo::machine::memory);
        let read = archive::open(BufReader::new(file), budget.unwrap_or(u64::MAX));
        let failed = |e: &dyn std::fmt::Display| refused(format_args!("{}: {e}", path.display()));
        match read.map_err(|e| failed(&e))? {
            StoredFactors::Blocks(read) => Ok(*read),
            StoredFactors::Whole(_) => Err(failed(
                &"a whole matrix, expected blocks (form_factors(..., compress=1e-3)): use FormFactors.load",
            )),
        }
    })?;
    Ok(NativeCompressedFactors {
        archive: Arc::new(archive),
    })
}

#[pymethods]
impl NativeCompressedFactors {
    fn __len__(&self) -> usize {
        self.archive.factors.len()
    }

    /// The rows, as of a matrix without entries.
    #[getter]
    fn rows(&self) -> NativeFormFactors {
        NativeFormFactors::new(self.archive.enclosure.clone())
    }

    /// X times the columns of a matrix, or Xᵀ times them.
    fn products<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray2<'py, f64>,
        transposed: bool,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let x = x.as_array();
        let (n, lanes) = (self.archive.factors.len(), x.ncols());
        if x.nrows() != n {
            return Err(refused(format_args!(
                "{} numbers for {n} rows: expected one for each",
                x.nrows()
            )));
        }
        // Row by row, as operators want them.
        let x: Vec<f64> = x.iter().copied().collect();
        let archive = self.archive.clone();
        let product = work::run(py, &WorkOptions::new(None, None), move |_| {
            if lanes == 0 {
                return Ok(Vec::new());
            }
            let factors = &*archive.factors;
            let over = |x: Vec<f64>| -> Vec<f64> {
                let rows = x.chunks_exact(lanes).zip(factors.row_areas());
                let share = |x: f64, area: f64| if area > 0.0 { x / area } else { 0.0 };
                rows.flat_map(|(x, &area)| x.iter().map(move |&x| share(x, area)))
                    .collect()
            };
            Ok(if transposed {
                factors.exchanged_lanes(&over(x), lanes)
            } else {
                over(factors.exchanged_lanes(&x, lanes))
            })
        })?;
        let product = Array2::from_shape_vec((n, lanes), product);
        Ok(product.map_err(refused)?.into_pyarray(py))
    }

    /// X x and its standard errors by the noise of rays.
    fn product_with_errors<'py>(&self, py: Python<'py>, x: Vec<f64>) -> PyResult<ArrayPair<'py>> {
        if x.len() != self.archive.factors.len() {
            return Err(refused(format_args!(
                "{} numbers for {} rows: expected one for each",
                x.len(),
                self.archive.factors.len()
            )));
        }
        let archive = self.archive.clone();
        let (product, errors) = work::run(py, &WorkOptions::new(None, None), move |_| {
            Ok(archive.factors.apply_with_errors(&x))
        })?;
        Ok((product.into_pyarray(py), errors.into_pyarray(py)))
    }

    /// Tolerance, error of products and of row sums, each with its standard error.
    #[getter]
    fn stated(&self) -> [f64; 5] {
        let stated = &self.archive.stated;
        [
            self.archive.tolerance,
            stated.product.value,
            stated.product.error,
            stated.sums.value,
            stated.sums.error,
        ]
    }

    /// Rows that were traced again for these errors; 0 if they are against the whole matrix.
    #[getter]
    fn traced_again(&self) -> u64 {
        self.archive.stated.rows
    }

    /// Bytes of the blocks, and of the whole matrix or a forecast of them.
    #[getter]
    fn bytes(&self) -> (usize, u64) {
        (self.archive.factors.bytes(), self.archive.whole_bytes)
    }

    /// Number of blocks that are sparse, dense and of low rank.
    #[getter]
    fn blocks(&self) -> [usize; 3] {
        self.archive.factors.kinds()
    }

    /// Writes the blocks.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let archive = self.archive.clone();
        work::run(py, &WorkOptions::new(None, None), move |p| {
            let output = Output::check(&path).map_err(output_error)?;
            let mut draft = output.draft().map_err(output_error)?;
            let written = archive::write_blocks(&archive, &mut draft);
            written.map_err(|e| output_error(output.error(e)))?;
            commit(vec![draft], p).map_err(output_error)
        })
    }
}
