//! Matrices of form factors, computed as the command computes them.

mod csr;
mod options;

use crate::arrays::{SkyArrays, sky_arrays, triples};
use crate::choices;
use crate::error::{cancelled, factors_error, refused};
use crate::geometry::{self, GeometryArrays};
use crate::scene::NativeScene;
use crate::work::{self, WorkOptions};
use azulejo_exchange::{ClusterOptions, Enclosure, GroupBy, Groups, OutsideLight};
use azulejo_factors::form_factors::{Adjustment, Plan, RowRemainder};
use azulejo_factors::{FormFactorOptions, FormFactors};
use azulejo_scene::Scene;
use azulejo_scene::sky::SkyDivision;
use azulejo_trace::Progress;
use csr::{CsrArrays, CsrBuffers, OrderArrays};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
pub use options::OptionArgs;
use pyo3::prelude::*;
use std::sync::Arc;

/// A matrix with what is known of its rows. It never changes.
#[pyclass(frozen, module = "pyazulejo._pyazulejo")]
pub struct NativeFormFactors {
    /// The matrix and its rows.
    pub enclosure: Arc<Enclosure>,
}

/// Computes the form factors of a scene, and says what of the scene makes them wrong.
#[pyfunction]
pub fn compute_form_factors(
    py: Python<'_>,
    scene: &NativeScene,
    by: &str,
    options: OptionArgs,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(NativeFormFactors, Vec<String>)> {
    let by = choices::group_by(by)?;
    let (periods, sky, options) = (options.periods()?, options.sky()?, options.options_for(by)?);
    let shared = scene.shared();
    let (enclosure, flaws) = work::run(py, &WorkOptions::new(threads, progress), move |p| {
        let tracer = shared.repeated(periods)?;
        compute(&shared.scene, &tracer, (by, sky), &options, p)
    })?;
    Ok((NativeFormFactors::new(enclosure), flaws))
}

/// As the command, step by step, so that the bits are the same.
fn compute(
    scene: &Scene,
    tracer: &azulejo_trace::Tracer,
    (by, sky): (Option<GroupBy>, Option<(SkyDivision, f64)>),
    options: &FormFactorOptions,
    progress: &Progress,
) -> PyResult<(Enclosure, Vec<String>)> {
    let plan = Plan::new(scene, tracer, options).map_err(factors_error)?;
    let prepared = plan.prepare();
    let factors = prepared.compute(progress);
    let mut enclosure = Enclosure::new(&prepared, scene, factors.map_err(factors_error)?);
    let outside = OutsideLight::of_rows(&prepared, scene, &enclosure.factors, progress);
    enclosure.outside = outside.map_err(factors_error)?;
    if let Some((division, north)) = sky {
        let seen = prepared.sky_factors(division, north, &enclosure.factors, progress);
        enclosure.sky = Some(seen.map_err(factors_error)?);
    }
    let enclosure = match by {
        Some(by) => enclosure.grouped(&enclosure.groups(by)),
        None => enclosure,
    };
    Ok((enclosure, plan.flaws()))
}

impl NativeFormFactors {
    /// A matrix.
    pub fn new(enclosure: Enclosure) -> NativeFormFactors {
        NativeFormFactors {
            enclosure: Arc::new(enclosure),
        }
    }

    fn factors(&self) -> &FormFactors {
        &self.enclosure.factors
    }

    /// The same rows after a change of their entries.
    fn changed(
        &self,
        py: Python<'_>,
        options: &WorkOptions,
        change: impl FnOnce(&mut FormFactors, &Progress) -> PyResult<()> + Send + 'static,
    ) -> PyResult<NativeFormFactors> {
        let enclosure = self.enclosure.clone();
        let changed = work::run(py, options, move |p| {
            let mut changed = Enclosure::clone(&enclosure);
            change(&mut changed.factors, p)?;
            Ok(changed)
        })?;
        Ok(NativeFormFactors::new(changed))
    }

    fn in_groups(&self, py: Python<'_>, groups: Groups) -> PyResult<NativeFormFactors> {
        let enclosure = self.enclosure.clone();
        let grouped = work::run(py, &WorkOptions::new(None, None), move |p| {
            enclosure.gathered(&groups, p).map_err(cancelled)
        })?;
        Ok(NativeFormFactors::new(grouped))
    }

    fn rest<'py>(
        &self,
        py: Python<'py>,
        share: impl Fn(&RowRemainder) -> f64,
    ) -> Bound<'py, PyArray1<f64>> {
        let shares: Vec<f64> = self.factors().rest.iter().map(share).collect();
        shares.into_pyarray(py)
    }
}

#[pymethods]
impl NativeFormFactors {
    fn __len__(&self) -> usize {
        self.factors().len()
    }

    /// The buffers of a compressed matrix: data, standard errors, columns, starts of rows. Each call
    /// makes new ones.
    fn csr<'py>(&self, py: Python<'py>) -> PyResult<CsrArrays<'py>> {
        let enclosure = self.enclosure.clone();
        let buffers = work::run(py, &WorkOptions::new(None, None), move |_| {
            Ok(CsrBuffers::new(&enclosure.factors))
        })?;
        Ok(buffers.into_arrays(py))
    }

    /// Data and standard errors of one order of reflection, aligned with those of the matrix.
    fn order<'py>(&self, py: Python<'py>, order: usize) -> PyResult<OrderArrays<'py>> {
        if order >= self.factors().orders.len() {
            return Err(refused(
                "the orders of reflection were not kept: ask for form_factors(..., separate=True)",
            ));
        }
        let enclosure = self.enclosure.clone();
        work::run(py, &WorkOptions::new(None, None), move |_| {
            Ok(csr::order(&enclosure.factors, order))
        })
        .map(|(data, error)| (data.into_pyarray(py), error.into_pyarray(py)))
    }

    /// One entry and its standard error.
    fn get(&self, row: usize, column: u32) -> PyResult<(f64, f32)> {
        let count = self.factors().len();
        if row < count && (column as usize) < count {
            return Ok(self.factors().get(row, column));
        }
        Err(refused(format_args!(
            "there is no entry {row}, {column}: the matrix has {count} rows"
        )))
    }

    /// The matrix between groups: a number below the count of `names` for each row, or −1.
    fn grouped(
        &self,
        py: Python<'_>,
        groups: PyReadonlyArray1<'_, i64>,
        names: Vec<String>,
    ) -> PyResult<NativeFormFactors> {
        let groups = groups.as_array();
        let group = |&g: &i64| u32::try_from(g).ok();
        let is_known = |&g: &i64| g < names.len() as i64;
        if groups.len() != self.factors().len() || !groups.iter().all(is_known) {
            return Err(refused("one group is needed for each row"));
        }
        let of_rows = groups.iter().map(group).collect();
        self.in_groups(py, Groups { of_rows, names })
    }

    /// The matrix between faces, objects or materials.
    fn grouped_by(&self, py: Python<'_>, by: &str) -> PyResult<NativeFormFactors> {
        let by = choices::group_by(by)?;
        let by = by.ok_or_else(|| refused("patches cannot be made of groups of them"))?;
        if self.enclosure.rows.cells.is_empty() {
            return Err(refused(
                "rows without geometry are of no face, object or material: pass a label for each row",
            ));
        }
        self.in_groups(py, self.enclosure.groups(by))
    }

    /// The matrix between clusters of neighbouring patches, whose normals differ by at most this many degrees.
    fn clustered(
        &self,
        py: Python<'_>,
        count: usize,
        angle: f64,
        whole_faces: bool,
    ) -> PyResult<NativeFormFactors> {
        let options = ClusterOptions {
            count,
            angle: angle.to_radians(),
            whole_faces,
        };
        let enclosure = self.enclosure.clone();
        let clusters = work::run(py, &WorkOptions::new(None, None), move |_| {
            Ok(enclosure.clusters(&options))
        })?;
        self.in_groups(py, clusters.map_err(refused)?)
    }

    /// The matrix with closure enforced.
    fn close(
        &self,
        py: Python<'_>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<NativeFormFactors> {
        let options = WorkOptions::new(threads, progress);
        self.changed(py, &options, |f, p| f.close(p).map_err(cancelled))
    }

    /// The matrix without small entries.
    fn truncate(
        &self,
        py: Python<'_>,
        share: f64,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<NativeFormFactors> {
        let options = WorkOptions::new(threads, progress);
        self.changed(py, &options, move |f, p| {
            f.truncate(share, p).map_err(cancelled)
        })
    }

    /// Names of groups.
    #[getter]
    fn names(&self) -> Option<Vec<String>> {
        let rows = &self.enclosure.rows;
        rows.are_groups.then(|| rows.names.clone())
    }

    /// Corners, their offsets, centroids and normals of patches; none of groups.
    #[getter]
    fn geometry<'py>(&self, py: Python<'py>) -> PyResult<Option<GeometryArrays<'py>>> {
        let rows = &self.enclosure.rows;
        let is_patches = !rows.are_groups && !rows.cells.is_empty();
        let arrays = is_patches.then(|| geometry::arrays(&self.enclosure, py));
        arrays.transpose()
    }

    /// Area of each row.
    #[getter]
    fn areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.factors().areas.clone().into_pyarray(py)
    }

    /// Shares that reach no column, by name: sky, sky_error, ground, ground_error, hidden, hidden_error, cut, lost.
    fn share<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let share: fn(&RowRemainder) -> f64 = match name {
            "sky" => |r| r.sky,
            "sky_error" => |r| r.sky_error,
            "ground" => |r| r.ground,
            "ground_error" => |r| r.ground_error,
            "hidden" => |r| r.hidden,
            "hidden_error" => |r| r.hidden_error,
            "cut" => |r| r.cut,
            "lost" => |r| r.lost,
            _ => return Err(refused(format_args!("there is no share \"{name}\""))),
        };
        Ok(self.rest(py, share))
    }

    /// Expected error of each row.
    #[getter]
    fn row_error<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.factors().row_errors.clone().into_pyarray(py)
    }

    /// Light from outside on each row, W/m², red, green and blue, and its standard error.
    #[getter]
    fn outside<'py>(&self, py: Python<'py>) -> PyResult<Option<[Bound<'py, PyArray2<f64>>; 2]>> {
        let Some(rows) = &self.enclosure.outside else {
            return Ok(None);
        };
        let of = |light: fn(&OutsideLight) -> [f64; 3]| triples(py, rows.iter().map(light));
        Ok(Some([
            of(|l| l.irradiance.to_array())?,
            of(|l| l.error.to_array())?,
        ]))
    }

    /// What rows see of the patches of the sky, if that was asked for.
    #[getter]
    fn sky_patches<'py>(&self, py: Python<'py>) -> PyResult<Option<SkyArrays<'py>>> {
        let enclosure = &self.enclosure;
        let arrays = enclosure
            .sky
            .as_ref()
            .map(|sky| sky_arrays(py, sky, enclosure.rows.up));
        arrays.transpose()
    }

    /// Share of the light arriving at each column that ends there.
    #[getter]
    fn ends<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.factors().ends.clone().into_pyarray(py)
    }

    /// Object, face in it, material, and whether it is a back, of each row.
    #[getter]
    fn pieces<'py>(&self, py: Python<'py>) -> [Bound<'py, PyAny>; 4] {
        let factors = self.factors();
        let numbers = |of: &dyn Fn(usize) -> u32| {
            let numbers: Vec<i32> = (0..factors.len()).map(|i| of(i) as i32).collect();
            numbers.into_pyarray(py).into_any()
        };
        [
            numbers(&|i| factors.faces[i].object),
            numbers(&|i| factors.faces[i].face),
            numbers(&|i| factors.materials[i]),
            factors.is_back.clone().into_pyarray(py).into_any(),
        ]
    }

    /// Engine, its device, and why it ran.
    #[getter]
    fn engine(&self) -> (String, String, Vec<String>) {
        let used = self.factors().engine_used.clone();
        (used.name, used.device, used.notes)
    }

    /// Whether no row loses light to the outside.
    #[getter]
    fn is_closed(&self) -> bool {
        self.factors().is_closed
    }

    /// How much closure moved, if it was enforced: total, mean, most, deficit.
    #[getter]
    fn closed(&self) -> Option<[f64; 4]> {
        self.factors().closed.as_ref().map(shares)
    }

    /// How much truncation moved, if there was one: total, mean, most, deficit.
    #[getter]
    fn truncated(&self) -> Option<[f64; 4]> {
        let truncated = self.factors().truncated.as_ref();
        truncated.map(|t| shares(&t.moved))
    }

    /// Rays traced from patches.
    #[getter]
    fn rays(&self) -> u64 {
        self.factors().rays
    }
}

fn shares(moved: &Adjustment) -> [f64; 4] {
    [moved.total, moved.mean, moved.most, moved.deficit]
}
