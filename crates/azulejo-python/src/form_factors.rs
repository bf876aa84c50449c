//! Matrices of form factors, computed as the command computes them.

mod csr;
mod options;

use crate::choices;
use crate::error::{cancelled, of_factors, refused};
use crate::geometry::{GeometryArrays, RowGeometry};
use crate::scene::NativeScene;
use crate::work::{self, WorkOptions};
use azulejo_factors::form_factors::{
    Adjustment, GroupBy, NamedGroups, NoJournal, Plan, RowRemainder,
};
use azulejo_factors::{FormFactorOptions, FormFactors};
use azulejo_scene::Scene;
use azulejo_trace::Progress;
use csr::{CsrArrays, CsrBuffers, OrderArrays};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use options::OptionArgs;
use pyo3::prelude::*;
use std::sync::Arc;

/// A matrix with what is known of its rows. It never changes.
#[pyclass(frozen, module = "pyazulejo._pyazulejo")]
pub struct NativeFormFactors {
    /// The scene whose matrix it is.
    pub scene: Arc<Scene>,
    /// The matrix.
    pub factors: Arc<FormFactors>,
    /// Names of the rows, if they are groups.
    pub names: Option<Vec<String>>,
    /// Where the rows lie, if they are patches.
    geometry: Option<Arc<RowGeometry>>,
}

/// A matrix on its way out of a thread.
struct ComputedMatrix {
    factors: FormFactors,
    names: Option<Vec<String>>,
    geometry: Option<RowGeometry>,
}

/// Computes the form factors of a scene.
#[pyfunction]
pub fn compute_form_factors(
    py: Python<'_>,
    scene: &NativeScene,
    by: &str,
    options: OptionArgs,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<NativeFormFactors> {
    let by = choices::group_by(by)?;
    let (shared, options) = (scene.shared(), options.options()?);
    let found = work::run(py, &WorkOptions::new(threads, progress), move |p| {
        let (scene, tracer) = (&shared.scene, shared.tracer());
        compute(scene, tracer, by, &options, p)
    })?;
    Ok(NativeFormFactors {
        scene: scene.scene.clone(),
        factors: Arc::new(found.factors),
        names: found.names,
        geometry: found.geometry.map(Arc::new),
    })
}

/// As the command, step by step, so that the bits are the same.
fn compute(
    scene: &Scene,
    tracer: &azulejo_trace::Tracer,
    by: Option<GroupBy>,
    options: &FormFactorOptions,
    progress: &Progress,
) -> PyResult<ComputedMatrix> {
    let plan = Plan::new(scene, tracer, options).map_err(of_factors)?;
    let factors = plan.prepare().compute(&NoJournal, progress);
    let factors = factors.map_err(of_factors)?;
    Ok(match by {
        Some(by) => {
            let groups = NamedGroups::new(scene, &factors, by);
            ComputedMatrix {
                factors: factors.grouped(&groups.of_rows, groups.names.len()),
                names: Some(groups.names),
                geometry: None,
            }
        }
        None => ComputedMatrix {
            geometry: Some(RowGeometry::new(plan.patches(), &factors)),
            factors,
            names: None,
        },
    })
}

impl NativeFormFactors {
    /// The same rows after a change of their entries.
    fn changed(
        &self,
        py: Python<'_>,
        options: &WorkOptions,
        change: impl FnOnce(&mut FormFactors, &Progress) -> PyResult<()> + Send + 'static,
    ) -> PyResult<NativeFormFactors> {
        let factors = self.factors.clone();
        let factors = work::run(py, options, move |p| {
            let mut changed = FormFactors::clone(&factors);
            change(&mut changed, p)?;
            Ok(changed)
        })?;
        Ok(NativeFormFactors {
            scene: self.scene.clone(),
            factors: Arc::new(factors),
            names: self.names.clone(),
            geometry: self.geometry.clone(),
        })
    }

    fn in_groups(
        &self,
        py: Python<'_>,
        of_rows: Vec<Option<u32>>,
        names: Vec<String>,
    ) -> PyResult<NativeFormFactors> {
        let (factors, count) = (self.factors.clone(), names.len());
        let grouped = work::run(py, &WorkOptions::new(None, None), move |_| {
            Ok(factors.grouped(&of_rows, count))
        })?;
        Ok(NativeFormFactors {
            scene: self.scene.clone(),
            factors: Arc::new(grouped),
            names: Some(names),
            geometry: None,
        })
    }

    fn rest<'py>(
        &self,
        py: Python<'py>,
        share: impl Fn(&RowRemainder) -> f64,
    ) -> Bound<'py, PyArray1<f64>> {
        let shares: Vec<f64> = self.factors.rest.iter().map(share).collect();
        shares.into_pyarray(py)
    }
}

#[pymethods]
impl NativeFormFactors {
    fn __len__(&self) -> usize {
        self.factors.len()
    }

    /// The buffers of a compressed matrix: data, standard errors, columns, starts of rows. Each call
    /// makes new ones.
    fn csr<'py>(&self, py: Python<'py>) -> PyResult<CsrArrays<'py>> {
        let factors = self.factors.clone();
        let buffers = work::run(py, &WorkOptions::new(None, None), move |_| {
            Ok(CsrBuffers::new(&factors))
        })?;
        Ok(buffers.into_arrays(py))
    }

    /// Data and standard errors of one order of reflection, aligned with those of the matrix.
    fn order<'py>(&self, py: Python<'py>, order: usize) -> PyResult<OrderArrays<'py>> {
        if order >= self.factors.orders.len() {
            return Err(refused(
                "the orders of reflection were not kept: ask for form_factors(..., separate=True)",
            ));
        }
        let factors = self.factors.clone();
        work::run(py, &WorkOptions::new(None, None), move |_| {
            Ok(csr::order(&factors, order))
        })
        .map(|(data, error)| (data.into_pyarray(py), error.into_pyarray(py)))
    }

    /// One entry and its standard error.
    fn get(&self, row: usize, column: u32) -> PyResult<(f64, f32)> {
        let count = self.factors.len();
        if row < count && (column as usize) < count {
            return Ok(self.factors.get(row, column));
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
        if groups.len() != self.factors.len() || !groups.iter().all(is_known) {
            return Err(refused("one group is needed for each row"));
        }
        self.in_groups(py, groups.iter().map(group).collect(), names)
    }

    /// The matrix between faces, objects or materials.
    fn grouped_by(&self, py: Python<'_>, by: &str) -> PyResult<NativeFormFactors> {
        let by = choices::group_by(by)?;
        let by = by.ok_or_else(|| refused("patches cannot be made of groups of them"))?;
        let groups = NamedGroups::new(&self.scene, &self.factors, by);
        self.in_groups(py, groups.of_rows, groups.names)
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
        self.names.clone()
    }

    /// Corners, their offsets, centroids and normals of patches; none of groups.
    #[getter]
    fn geometry<'py>(&self, py: Python<'py>) -> PyResult<Option<GeometryArrays<'py>>> {
        let arrays = self.geometry.as_ref().map(|g| g.arrays(py));
        arrays.transpose()
    }

    /// Area of each row.
    #[getter]
    fn areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.factors.areas.clone().into_pyarray(py)
    }

    /// Shares that reach no column, by name: sky, sky_error, ground, ground_error, hidden, cut, lost.
    fn share<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let share: fn(&RowRemainder) -> f64 = match name {
            "sky" => |r| r.sky,
            "sky_error" => |r| r.sky_error,
            "ground" => |r| r.ground,
            "ground_error" => |r| r.ground_error,
            "hidden" => |r| r.hidden,
            "cut" => |r| r.cut,
            "lost" => |r| r.lost,
            _ => return Err(refused(format_args!("there is no share \"{name}\""))),
        };
        Ok(self.rest(py, share))
    }

    /// Expected error of each row.
    #[getter]
    fn row_error<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.factors.row_errors.clone().into_pyarray(py)
    }

    /// Share of the light arriving at each column that ends there.
    #[getter]
    fn ends<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.factors.ends.clone().into_pyarray(py)
    }

    /// Object, face in it, material, and whether it is a back, of each row.
    #[getter]
    fn pieces<'py>(&self, py: Python<'py>) -> [Bound<'py, PyAny>; 4] {
        let factors = &self.factors;
        let numbers = |of: &dyn Fn(usize) -> u32| {
            let all: Vec<i32> = (0..factors.len()).map(|i| of(i) as i32).collect();
            all.into_pyarray(py).into_any()
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
        let used = self.factors.engine_used.clone();
        (used.name, used.device, used.notes)
    }

    /// Whether no row loses light to the outside.
    #[getter]
    fn is_closed(&self) -> bool {
        self.factors.is_closed
    }

    /// How much closure moved, if it was enforced: total, mean, most, deficit.
    #[getter]
    fn closed(&self) -> Option<[f64; 4]> {
        self.factors.closed.as_ref().map(shares)
    }

    /// How much truncation moved, if there was one: total, mean, most, deficit.
    #[getter]
    fn truncated(&self) -> Option<[f64; 4]> {
        let truncated = self.factors.truncated.as_ref();
        truncated.map(|t| shares(&t.moved))
    }

    /// Rays traced from patches.
    #[getter]
    fn rays(&self) -> u64 {
        self.factors.rays
    }
}

fn shares(moved: &Adjustment) -> [f64; 4] {
    [moved.total, moved.mean, moved.most, moved.deficit]
}
