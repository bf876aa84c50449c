//! Form factors from points.

use crate::arrays::{SkyArrays, points_with_normals, sky_arrays, vectors};
use crate::choices;
use crate::error::{cancelled, factors_error};
use crate::form_factors::OptionArgs;
use crate::scene::NativeScene;
use crate::work::{self, WorkOptions};
use azulejo_exchange::GroupBy;
use azulejo_exchange::points::{SeenFromPoints, numbered};
use azulejo_factors::FormFactorOptions;
use azulejo_factors::form_factors::{FactorPoint, Plan, PointFactors, RowRemainder};
use azulejo_radiosity::PointNormal;
use azulejo_scene::Scene;
use azulejo_scene::sky::SkyDivision;
use azulejo_trace::{Progress, Tracer};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// Compressed rows of points: values, standard errors, columns, starts.
type PointRows<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<i64>>,
);

/// Rows, names of columns (none of patches), their number, what reaches no column (sky and ground with errors, hidden,
/// cut, lost), and patches of the sky.
type PointArrays<'py> = (
    PointRows<'py>,
    Option<Vec<String>>,
    usize,
    Vec<Bound<'py, PyArray1<f64>>>,
    Option<SkyArrays<'py>>,
);

/// What points see: n × 3 positions, and normals or whole spheres.
#[pyfunction]
#[allow(
    clippy::too_many_arguments,
    reason = "they are the keywords of a Python function"
)]
pub fn compute_point_factors<'py>(
    py: Python<'py>,
    scene: &NativeScene,
    points: PyReadonlyArray2<'py, f64>,
    normals: Option<PyReadonlyArray2<'py, f64>>,
    by: &str,
    options: OptionArgs,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<PointArrays<'py>> {
    let by = choices::group_by(by)?;
    let (periods, sky, options) = (options.periods()?, options.sky()?, options.options()?);
    let points = factor_points(&points, normals.as_ref())?;
    let shared = scene.shared();
    let seen = work::run(py, &WorkOptions::new(threads, progress), move |p| {
        let tracer = shared.repeated(periods)?;
        from_points(&shared.scene, &tracer, (by, sky), &options, points, p)
    })?;
    let up = scene.shared().scene.units.up;
    let patches = seen.sky.as_ref().map(|sky| sky_arrays(py, sky, up));
    let patches = patches.transpose()?;
    let (factors, groups) = (seen.seen, seen.groups);
    let count = groups.names.len();
    let names = by.is_some().then_some(groups.names);
    let rests = rests(py, &factors);
    Ok((rows(py, &factors), names, count, rests, patches))
}

fn factor_points(
    points: &PyReadonlyArray2<f64>,
    normals: Option<&PyReadonlyArray2<f64>>,
) -> PyResult<Vec<FactorPoint>> {
    let Some(normals) = normals else {
        let globe = |position| FactorPoint {
            position,
            normal: None,
        };
        return Ok(vectors(points)?.into_iter().map(globe).collect());
    };
    let facing = |point: PointNormal| FactorPoint {
        position: point.position,
        normal: Some(point.normal),
    };
    let points = points_with_normals(points, normals)?;
    Ok(points.into_iter().map(facing).collect())
}

fn from_points(
    scene: &Scene,
    tracer: &Tracer,
    (by, sky): (Option<GroupBy>, Option<(SkyDivision, f64)>),
    options: &FormFactorOptions,
    points: Vec<FactorPoint>,
    progress: &Progress,
) -> PyResult<SeenFromPoints> {
    let plan = Plan::new(scene, tracer, options).map_err(factors_error)?;
    let prepared = plan.prepare();
    let seen = SeenFromPoints::compute(&prepared, (scene, by), numbered(points), progress);
    let mut seen = seen.map_err(cancelled)?;
    if let Some(sky) = sky {
        let added = seen.add_sky(&prepared, sky, progress);
        added.map_err(factors_error)?;
    }
    Ok(seen)
}

fn rows<'py>(py: Python<'py>, points: &[PointFactors]) -> PointRows<'py> {
    let entries = || points.iter().flat_map(|p| &p.factors);
    let values: Vec<f64> = entries().map(|(_, f)| f.value).collect();
    let errors: Vec<f64> = entries().map(|(_, f)| f.error).collect();
    let columns: Vec<i64> = entries().map(|(k, _)| i64::from(*k)).collect();
    let mut starts = vec![0];
    for point in points {
        starts.push(starts[starts.len() - 1] + point.factors.len() as i64);
    }
    (
        values.into_pyarray(py),
        errors.into_pyarray(py),
        columns.into_pyarray(py),
        starts.into_pyarray(py),
    )
}

fn rests<'py>(py: Python<'py>, points: &[PointFactors]) -> Vec<Bound<'py, PyArray1<f64>>> {
    let shares: [fn(&RowRemainder) -> f64; 8] = [
        |r| r.sky,
        |r| r.sky_error,
        |r| r.ground,
        |r| r.ground_error,
        |r| r.hidden,
        |r| r.cut,
        |r| r.lost,
        |r| r.hidden_error,
    ];
    let array = |share: fn(&RowRemainder) -> f64| {
        let shares: Vec<f64> = points.iter().map(|p| share(&p.rest)).collect();
        shares.into_pyarray(py)
    };
    shares.map(array).into()
}
