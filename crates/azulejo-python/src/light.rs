//! The first pass: light on all surfaces, or at points.

use crate::arrays::{points_with_normals, triples};
use crate::choices;
use crate::error::{light_error, refused};
use crate::scene::NativeScene;
use crate::work::{self, WorkOptions};
use azulejo::machine;
use azulejo_radiosity::{FirstPass, Method, Report, SolveError, solve};
use azulejo_scene::Rgb;
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Duration;

/// Options by name; what is `None` is the default.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct LightArgs {
    engine: String,
    patches: Option<usize>,
    patch_size: Option<f64>,
    error: Option<f64>,
    rays: Option<u32>,
    bounces: Option<u32>,
    time: Option<f64>,
    seed: u64,
    memory: Option<u64>,
    sides: String,
    keep_mesh: bool,
    interpolate: bool,
    allow_imbalance: bool,
    resolution: Option<u32>,
    patch_points: Option<u32>,
}

impl LightArgs {
    /// The library's options, as the command makes them of its own.
    pub fn options(&self) -> PyResult<FirstPass> {
        let default = FirstPass::default();
        Ok(FirstPass {
            engine: choices::engine(&self.engine, self.resolution, self.patch_points)?,
            size: choices::patch_size(self.patches, self.patch_size).unwrap_or(default.size),
            error: self.error,
            error_each: false,
            rays: self.rays,
            ray_budget: None,
            bounces: self.bounces,
            seed: self.seed,
            memory: self.memory.unwrap_or_else(machine::memory_budget),
            interpolate: self.interpolate,
            keep_mesh: self.keep_mesh,
            sides: choices::sides(&self.sides)?,
        })
    }

    /// How the work is run.
    pub fn work(&self, threads: Option<usize>, callback: Option<Py<PyAny>>) -> WorkOptions {
        let time = self.time.map(Duration::try_from_secs_f64);
        WorkOptions {
            threads,
            callback,
            time: time.and_then(Result::ok),
        }
    }

    /// Refuses light of which so much is missing that it cannot be trusted.
    pub fn check(&self, report: &Report) -> PyResult<()> {
        if !report.balance.is_broken(report.balance_error)
            || self.allow_imbalance
            || self.bounces.is_some()
        {
            return Ok(());
        }
        Err(refused(format_args!(
            "{:.1}% of the emitted power is not accounted for: ask for a smaller error, more rays or \
             more time, or accept it with allow_imbalance=True",
            100.0 * report.balance.error()
        )))
    }
}

/// Light at points: irradiance, its standard error, and statistics.
type ProbeArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyDict>,
);

/// Solves the light of a scene and returns the scene with it, and statistics.
#[pyfunction]
pub fn solve_light<'py>(
    py: Python<'py>,
    scene: &NativeScene,
    options: LightArgs,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(NativeScene, Bound<'py, PyDict>)> {
    let (pass, shared) = (options.options()?, scene.shared());
    let (lit, report) = work::run(py, &options.work(threads, progress), move |p| {
        let light = solve(&shared.scene, shared.tracer(), &pass, p).map_err(explained)?;
        let mut lit = azulejo_scene::Scene::clone(&shared.scene);
        lit.set_irradiance(light.irradiance);
        Ok((lit, light.report))
    })?;
    options.check(&report)?;
    Ok((NativeScene::new(lit, Vec::new()), described(py, &report)?))
}

/// Irradiance at points and normals, n × 3 each.
#[pyfunction]
pub fn probe_irradiance<'py>(
    py: Python<'py>,
    scene: &NativeScene,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    options: LightArgs,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<ProbeArrays<'py>> {
    let points = points_with_normals(&points, &normals)?;
    let (pass, shared) = (options.options()?, scene.shared());
    let probed = work::run(py, &options.work(threads, progress), move |p| {
        let probes = azulejo_radiosity::probe(&shared.scene, shared.tracer(), &points, &pass, p);
        probes.map_err(explained)
    })?;
    options.check(&probed.report)?;
    let estimates = &probed.estimates;
    let values = estimates.iter().map(|e| e.value.to_array());
    let errors = estimates.iter().map(|e| e.error.to_array());
    let report = described(py, &probed.report)?;
    Ok((triples(py, values)?, triples(py, errors)?, report))
}

/// Says how a scene without light gets some.
pub fn explained(error: SolveError) -> PyErr {
    match error {
        SolveError::NoLight => refused(
            "nothing in the scene emits light: give a Material an emission, or the Scene a sky",
        ),
        other => light_error(other),
    }
}

/// Statistics by name.
pub fn described<'py>(py: Python<'py>, report: &Report) -> PyResult<Bound<'py, PyDict>> {
    let rgb = |c: Rgb| c.to_array();
    let statistics = PyDict::new(py);
    let method = match report.method {
        Method::Matrix => "matrix",
        Method::Stochastic => "stochastic",
        Method::Paths => "paths",
    };
    statistics.set_item("method", method)?;
    statistics.set_item("engine", &report.engine_used.name)?;
    statistics.set_item("patches", report.patches)?;
    statistics.set_item("points", report.points)?;
    statistics.set_item("rays_per_point", report.point_rays)?;
    statistics.set_item("bounces", report.iterations)?;
    statistics.set_item("error", report.error)?;
    statistics.set_item("rays_needed", report.rays_needed)?;
    statistics.set_item("emitted", rgb(report.balance.emitted))?;
    statistics.set_item("absorbed", rgb(report.balance.absorbed))?;
    statistics.set_item("escaped", rgb(report.balance.escaped))?;
    statistics.set_item("energy_error", report.balance.error())?;
    Ok(statistics)
}
