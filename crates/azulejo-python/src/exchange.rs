//! Exchange factors, temperatures and fluxes.

mod conditions;

use crate::arrays::triples;
use crate::choices;
use crate::error::{of_output, refused};
use crate::form_factors::NativeFormFactors;
use crate::materials::NativeMaterials;
use crate::work::{self, WorkOptions};
use azulejo::output::Output;
use azulejo_exchange::model::{
    self, ConductanceList, SPACE, ThermalModel, ThermalResult, ThermalResultFormat,
};
use azulejo_exchange::tables::MaterialTable;
use azulejo_exchange::{Enclosure, ExchangeFactors, Groups, HeatBalance, band_fraction};
use azulejo_trace::Progress;
use conditions::ConditionArgs;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// What is solved, beside surfaces and conditions.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ExchangeArgs<'py> {
    /// `row`, `face`, `object` or `material`, unless there are `groups`.
    by: String,
    /// The node of each row, or −1, and the names of the nodes.
    groups: Option<(PyReadonlyArray1<'py, i64>, Vec<String>)>,
    lump: bool,
    lost_to_sky: bool,
}

/// A solved model.
#[pyclass(frozen, module = "pyazulejo._pyazulejo")]
pub struct NativeThermalResult {
    result: Arc<ThermalResult>,
    notes: Vec<String>,
}

/// Share of a row's light that may be lost without a word.
const LOST: f64 = 1e-3;

impl ExchangeArgs<'_> {
    fn nodes(&self, enclosure: &Enclosure) -> PyResult<Groups> {
        let Some((groups, names)) = &self.groups else {
            return Ok(model::nodes(enclosure, choices::node(&self.by)?));
        };
        let groups = groups.as_array();
        let is_known = |&g: &i64| g < names.len() as i64;
        if groups.len() != enclosure.len() || !groups.iter().all(is_known) {
            return Err(refused("one node is needed for each row"));
        }
        Ok(Groups {
            of_rows: groups.iter().map(|&g| u32::try_from(g).ok()).collect(),
            names: names.clone(),
        })
    }

    /// The matrices, with what they lose given to the sky if that is asked for.
    fn enclosures(
        &self,
        factors: &[PyRef<'_, NativeFormFactors>],
        notes: &mut Vec<String>,
    ) -> Vec<Arc<Enclosure>> {
        let mut prepared = Vec::new();
        for factors in factors {
            let lost = model::lost(&factors.enclosure);
            if self.lost_to_sky && lost > 0.0 {
                let mut changed = Enclosure::clone(&factors.enclosure);
                model::give_lost_to_sky(&mut changed);
                prepared.push(Arc::new(changed));
                continue;
            }
            if lost > LOST {
                notes.push(format!(
                    "up to {:.2}% of a row's light ends on backs or is cut off between mirrors, where \
                     nothing absorbs it; lost_to_sky=True gives it to the sky, \
                     form_factors(two_sided=True) has rows of backs",
                    100.0 * lost
                ));
            }
            prepared.push(factors.enclosure.clone());
        }
        prepared
    }
}

/// Conductances between nodes, in each band.
#[pyfunction]
pub fn solve_exchange(
    py: Python<'_>,
    factors: Vec<PyRef<'_, NativeFormFactors>>,
    materials: &NativeMaterials,
    args: ExchangeArgs<'_>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<NativeThermalResult> {
    let mut notes = Vec::new();
    let (enclosures, nodes, table) = prepare(&factors, materials, &args, &mut notes)?;
    let (lump, place) = (args.lump, materials.place.clone());
    let result = work::run(py, &WorkOptions::new(threads, progress), move |p| {
        let model = made(enclosures, &table, nodes, lump, &place)?;
        let networks = model.networks(p).map_err(refused)?;
        Ok(ThermalResult::new(&model, networks, None, [SPACE; 2]))
    })?;
    Ok(NativeThermalResult {
        result: Arc::new(result),
        notes,
    })
}

/// Temperatures and fluxes.
#[pyfunction]
#[allow(
    clippy::too_many_arguments,
    reason = "they are the keywords of a Python function"
)]
pub fn solve_radiosity(
    py: Python<'_>,
    factors: Vec<PyRef<'_, NativeFormFactors>>,
    materials: &NativeMaterials,
    args: ExchangeArgs<'_>,
    conditions: ConditionArgs<'_>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<NativeThermalResult> {
    let mut notes = Vec::new();
    let (enclosures, nodes, table) = prepare(&factors, materials, &args, &mut notes)?;
    let given = conditions.of_rows(&enclosures[0], &mut notes)?;
    conditions.note_surroundings(&enclosures[0], &mut notes);
    let surroundings = conditions.surroundings.map(|t| t.unwrap_or(SPACE));
    let (lump, place) = (args.lump, materials.place.clone());
    let work = move |p: &Progress| {
        let model = made(enclosures, &table, nodes, lump, &place)?;
        let given = model.conditions(given).map_err(refused)?;
        let heat = model.heat(&given, surroundings, p).map_err(refused)?;
        let is_dark = model.has_solar_band() || model.sunlight(&given).is_empty();
        let result = ThermalResult::new(&model, Vec::new(), Some(heat), surroundings);
        Ok((result, is_dark))
    };
    let (result, has_effect) = work::run(py, &WorkOptions::new(threads, progress), work)?;
    if !has_effect {
        notes.push("sunlight has no effect, because no material has alpha".to_owned());
    }
    Ok(NativeThermalResult {
        result: Arc::new(result),
        notes,
    })
}

/// What both solvers take.
type Prepared = (Vec<Arc<Enclosure>>, Groups, Arc<MaterialTable>);

fn prepare(
    factors: &[PyRef<'_, NativeFormFactors>],
    materials: &NativeMaterials,
    args: &ExchangeArgs,
    notes: &mut Vec<String>,
) -> PyResult<Prepared> {
    let enclosures = args.enclosures(factors, notes);
    let first = enclosures.first();
    let first = first.ok_or_else(|| refused("there are no form factors"))?;
    let nodes = args.nodes(first)?;
    let unused = materials.table.unused(first);
    if !unused.is_empty() {
        notes.push(format!(
            "{}no row has the name \"{}\"",
            materials.place,
            unused.join("\", \"")
        ));
    }
    Ok((enclosures, nodes, materials.table.clone()))
}

fn made(
    enclosures: Vec<Arc<Enclosure>>,
    table: &MaterialTable,
    nodes: Groups,
    lump: bool,
    place: &str,
) -> PyResult<ThermalModel> {
    let model = ThermalModel::new(enclosures, table, nodes, lump);
    model.map_err(|e| refused(format_args!("{place}{e}")))
}

/// Corners of polygons, where those of each start, and the row of each.
type CellArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u32>>,
);

#[pymethods]
impl NativeThermalResult {
    /// Sentences that matter to the caller.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Names of bands; of a single one of all wavelengths an empty text.
    #[getter]
    fn bands(&self) -> Vec<String> {
        let networks = self.result.networks.iter();
        networks.map(|(range, _)| range.to_string()).collect()
    }

    /// The network of a band: names, and arrays by name.
    fn network<'py>(&self, py: Python<'py>, band: usize) -> PyResult<Bound<'py, PyDict>> {
        let networks = &self.result.networks;
        let network = networks.get(band).map(|(_, network)| network);
        let network = network.ok_or_else(|| refused("there is no such band"))?;
        network_arrays(py, network)
    }

    /// Names of the nodes that are surfaces.
    #[getter]
    fn node_names(&self) -> Vec<String> {
        self.result.nodes.names.clone()
    }

    /// Names of the rows.
    #[getter]
    fn row_names(&self) -> Vec<String> {
        self.result.enclosure.rows.names.clone()
    }

    /// Areas of the nodes that are surfaces, m².
    #[getter]
    fn node_areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.result.node_areas().into_pyarray(py)
    }

    /// Areas of rows, m².
    #[getter]
    fn row_areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let unit = self.result.enclosure.metres_per_unit().powi(2);
        let areas = self.result.enclosure.factors.areas.iter();
        areas
            .map(|a| unit * a)
            .collect::<Vec<f64>>()
            .into_pyarray(py)
    }

    /// The node of each row, or −1.
    #[getter]
    fn row_nodes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let rows = self.result.nodes.of_rows.iter();
        let node = |node: &Option<u32>| node.map_or(-1, i64::from);
        rows.map(node).collect::<Vec<i64>>().into_pyarray(py)
    }

    /// An array of temperatures and fluxes by its name.
    fn heat<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let heat = self.result.heat.as_ref();
        let heat = heat.ok_or_else(|| refused("there are no temperatures"))?;
        let of: fn(&HeatBalance) -> &[f64] = match name {
            "T" => |h| &h.temperatures,
            "q" => |h| &h.fluxes,
            "J" => |h| &h.radiosities,
            "H" => |h| &h.irradiations,
            "solar" => |h| &h.solar,
            "node_T" => |h| &h.node_temperatures,
            "node_T_error" => |h| &h.node_temperature_errors,
            "node_Q" => |h| &h.node_heat,
            "node_Q_error" => |h| &h.node_heat_errors,
            "to_surroundings" => |h| &h.to_surroundings,
            _ => return Err(refused(format_args!("there is no array \"{name}\""))),
        };
        Ok(of(heat).to_vec().into_pyarray(py))
    }

    /// Steps of Newton's method.
    #[getter]
    fn iterations(&self) -> usize {
        self.result.heat.as_ref().map_or(0, |h| h.iterations)
    }

    /// The polygons of rows; none of matrices without.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Option<CellArrays<'py>>> {
        let cells = &self.result.enclosure.rows.cells;
        if cells.is_empty() {
            return Ok(None);
        }
        Ok(Some((
            triples(py, cells.points.iter().map(|p| p.to_array()))?,
            cells.corners.clone().into_pyarray(py),
            cells.starts.clone().into_pyarray(py),
            cells.rows.clone().into_pyarray(py),
        )))
    }

    /// Writes a file of the format that its extension means.
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        model: String,
        sigma: bool,
        truncate: f64,
    ) -> PyResult<()> {
        let format = self.format(&path)?;
        let list = ConductanceList {
            model,
            sigma,
            truncate,
        };
        let result = self.result.clone();
        work::run(py, &WorkOptions::new(None, None), move |p| {
            let output = Output::check(&path).map_err(of_output)?;
            let mut problem = None;
            let written = output.write(p, |out| {
                result.write(format, &list, out).inspect_err(|e| {
                    // Not of the disk, but of the matrix.
                    problem = e.get_ref().map(ToString::to_string);
                })
            });
            match problem {
                Some(words) if written.is_err() => {
                    Err(refused(format_args!("{}: {words}", path.display())))
                }
                _ => written.map(|_| ()).map_err(of_output),
            }
        })
    }
}

impl NativeThermalResult {
    fn format(&self, path: &std::path::Path) -> PyResult<ThermalResultFormat> {
        use ThermalResultFormat as F;
        let has_heat = self.result.heat.is_some();
        let is_list = |f: F| f == F::Esatan || f == F::Sinda;
        let expected = match has_heat {
            true => ".npz, .csv or .vtu",
            false => ".npz, .csv, .esatan or .sinda",
        };
        match F::from_path(path) {
            Some(F::Vtu) if !has_heat => Err(refused(format_args!(
                "{}: a VTU shows temperatures and fluxes, which radiosity computes",
                path.display()
            ))),
            Some(list) if has_heat && is_list(list) => Err(refused(format_args!(
                "{}: a list of conductances, which exchange computes",
                path.display()
            ))),
            Some(format) => Ok(format),
            None => Err(refused(format_args!(
                "{}: unknown format, expected {expected}",
                path.display()
            ))),
        }
    }
}

fn network_arrays<'py>(py: Python<'py>, network: &ExchangeFactors) -> PyResult<Bound<'py, PyDict>> {
    let n = network.len();
    let arrays = PyDict::new(py);
    arrays.set_item("names", network.names.clone())?;
    arrays.set_item("areas", network.areas.clone().into_pyarray(py))?;
    arrays.set_item("emitting", network.emitting.clone().into_pyarray(py))?;
    arrays.set_item("is_surface", network.is_surface.clone().into_pyarray(py))?;
    arrays.set_item("asymmetry", network.asymmetry)?;
    let add = |name: &str, of: &dyn Fn(usize, usize) -> (f64, f64)| -> PyResult<()> {
        for (suffix, is_error) in [("", false), ("_error", true)] {
            let number = |k: usize| {
                let (value, error) = of(k / n, k % n);
                if is_error { error } else { value }
            };
            let all: Vec<f64> = (0..n * n).map(number).collect();
            let array = Array2::from_shape_vec((n, n), all).map_err(refused)?;
            arrays.set_item(format!("{name}{suffix}"), array.into_pyarray(py))?;
        }
        Ok(())
    };
    add("GR", &|a, b| network.conductance(a, b))?;
    add("B", &|a, b| network.gebhart(a, b))?;
    add("script_f", &|a, b| network.script_f(a, b))?;
    Ok(arrays)
}

/// Share of black emission below a product of wavelength and temperature, µm·K.
#[pyfunction]
pub fn band_fractions<'py>(
    py: Python<'py>,
    products: PyReadonlyArray1<'py, f64>,
) -> Bound<'py, PyArray1<f64>> {
    let products = products.as_array();
    let fraction = |&x: &f64| {
        if x.is_infinite() && x > 0.0 {
            1.0
        } else {
            band_fraction(x, 1.0)
        }
    };
    let shares: Vec<f64> = products.iter().map(fraction).collect();
    shares.into_pyarray(py)
}
