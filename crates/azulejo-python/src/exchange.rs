//! Exchange factors, temperatures and fluxes.

mod conditions;
mod forecast;

use crate::arrays::triples;
use crate::choices;
use crate::error::{output_error, refused};
use crate::form_factors::NativeFormFactors;
use crate::materials::NativeMaterials;
use crate::work::{self, WorkOptions};
use azulejo::output::Output;
use azulejo_exchange::thermal::model::{SolutionFormat, SolutionOptions, SolutionPart};
use azulejo_exchange::thermal::tables::MaterialTable;
use azulejo_exchange::{
    Enclosure, ExchangeFactors, HeatBalance, SpectralRange, ThermalModel, ThermalSolution,
    band_fraction,
};
use azulejo_factors::form_factors::RowRemainder;
use conditions::ConditionArgs;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How nodes are made and solved.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ExchangeArgs {
    /// `row`, `face`, `object` or `material`.
    by: String,
    lump: bool,
    lost_to_sky: bool,
    /// Bytes; by default those of the machine.
    memory: Option<u64>,
}

/// A solved model.
#[pyclass(frozen, module = "pyazulejo._pyazulejo")]
pub struct NativeThermalSolution {
    solution: Arc<ThermalSolution>,
    notes: Vec<String>,
}

/// What is written, and how.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct SolutionArgs {
    model: String,
    sigma: bool,
    truncate: Option<f64>,
    /// Whether temperatures are wanted, if there are any.
    heat: bool,
    /// The only band that is wanted.
    band: Option<usize>,
}

impl SolutionArgs {
    fn options(self) -> SolutionOptions {
        SolutionOptions {
            model: self.model,
            sigma: self.sigma,
            truncate: self.truncate,
            part: match self.band {
                _ if self.heat => SolutionPart::Whole,
                Some(band) => SolutionPart::Network(band),
                None => SolutionPart::Networks,
            },
        }
    }
}

/// Share of a row's light that may be lost without a word.
const LOST: f64 = 1e-3;

/// Conductances between nodes in each band, and temperatures and fluxes if there are conditions.
#[pyfunction]
#[allow(
    clippy::too_many_arguments,
    reason = "they are the keywords of a Python function"
)]
pub fn solve_exchange(
    py: Python<'_>,
    factors: Vec<PyRef<'_, NativeFormFactors>>,
    materials: &NativeMaterials,
    conditions: Option<ConditionArgs<'_>>,
    args: ExchangeArgs,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<NativeThermalSolution> {
    let mut notes = Vec::new();
    let matrices: Vec<Arc<Enclosure>> = factors.iter().map(|f| f.enclosure.clone()).collect();
    let first = matrices.first();
    let first = first.ok_or_else(|| refused("there are no form factors"))?;
    // A name in the table that no row has is worth a note, but no error.
    let unused = materials.table.unused(first);
    if !unused.is_empty() {
        let names = unused.join("\", \"");
        let place = &materials.place;
        notes.push(format!("{place}no row has the name \"{names}\""));
    }
    // Refuse a network that would not fit in memory before any long work.
    let nodes = choices::node(&args.by)?;
    let memory = args.memory.or_else(azulejo::machine::memory);
    forecast::check(
        first,
        nodes,
        materials.table.bands.len(),
        memory.unwrap_or(u64::MAX),
    )?;
    // Look up materials and conditions by the rows of the first matrix; solving checks the others.
    let properties = materials.table.of_rows(first);
    let properties = properties.map_err(|e| materials.refuse(e))?;
    let surroundings = conditions.as_ref().map_or([None; 2], |c| c.surroundings);
    let given = conditions.map(|c| c.of_rows(first, &mut notes));
    let (given, bands) = (given.transpose()?, ranges(&materials.table));
    // Solve in another thread, without the interpreter, while this one listens for Ctrl-C.
    let (solution, lost) = work::run(py, &WorkOptions::new(threads, progress), move |p| {
        let (matrices, lost) = owned(&matrices, args.lost_to_sky);
        let model = ThermalModel {
            matrices,
            bands: bands.into_iter().zip(properties).collect(),
            conditions: given,
            surroundings,
            nodes,
            lump: args.lump,
        };
        Ok((model.solve(p).map_err(refused)?, lost))
    })?;
    notes.extend(solution.notes.iter().cloned());
    notes.extend(lost);
    Ok(NativeThermalSolution {
        solution: Arc::new(solution),
        notes,
    })
}

fn ranges(table: &MaterialTable) -> Vec<SpectralRange> {
    table.bands.iter().map(|band| band.range).collect()
}

/// The matrices as a model wants them, with what they lose given to the sky if that is requested, or else
/// sentences about it.
fn owned(matrices: &[Arc<Enclosure>], to_sky: bool) -> (Vec<(String, Enclosure)>, Vec<String>) {
    let mut notes = Vec::new();
    let lost = |r: &RowRemainder| r.hidden + r.cut;
    let matrix = |(k, matrix): (usize, &Arc<Enclosure>)| {
        let mut matrix = Enclosure::clone(matrix);
        let rest = &mut matrix.factors.rest;
        let most = rest.iter().map(lost).fold(0.0, f64::max);
        if to_sky {
            for row in rest {
                row.sky += lost(row);
                row.sky_error = row.sky_error.hypot(row.hidden_error);
                (row.hidden, row.hidden_error, row.cut) = (0.0, 0.0, 0.0);
            }
        } else if most > LOST {
            notes.push(format!(
                "up to {:.2}% of a row's light ends on backs or is cut off between mirrors, where nothing \
                 absorbs it; lost_to_sky=True gives it to the sky, form_factors(two_sided=True) makes rows \
                 of backs",
                100.0 * most
            ));
        }
        let name = match matrices.len() {
            1 => "form factors".to_owned(),
            _ => format!("form factors {k}"),
        };
        (name, matrix)
    };
    let matrices = matrices.iter().enumerate().map(matrix).collect();
    (matrices, notes)
}

/// Corners of polygons, where those of each start, and the row of each.
type CellArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u32>>,
);

#[pymethods]
impl NativeThermalSolution {
    /// Sentences that matter to the caller.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Names of bands; of a single one of all wavelengths an empty text.
    #[getter]
    fn bands(&self) -> Vec<String> {
        let networks = self.solution.networks.iter();
        networks.map(|(range, _)| range.to_string()).collect()
    }

    /// What is known of the nodes of a band's network, by name.
    fn network<'py>(&self, py: Python<'py>, band: usize) -> PyResult<Bound<'py, PyDict>> {
        let network = self.exchange_factors(band)?;
        let arrays = PyDict::new(py);
        arrays.set_item("names", network.names.clone())?;
        arrays.set_item("areas", network.areas.clone().into_pyarray(py))?;
        arrays.set_item("emitting", network.emitting.clone().into_pyarray(py))?;
        arrays.set_item("is_surface", network.is_surface.clone().into_pyarray(py))?;
        arrays.set_item("asymmetry", network.asymmetry)?;
        Ok(arrays)
    }

    /// A matrix of a band's network: `GR`, `B` or `script_f`, or with `_error` its standard errors.
    fn matrix<'py>(
        &self,
        py: Python<'py>,
        band: usize,
        name: &str,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let network = self.exchange_factors(band)?;
        let of: fn(&ExchangeFactors, usize, usize) -> f64 = match name {
            "GR" => |x, a, b| x.conductance(a, b).0,
            "GR_error" => |x, a, b| x.conductance(a, b).1,
            "B" => |x, a, b| x.gebhart(a, b).0,
            "B_error" => |x, a, b| x.gebhart(a, b).1,
            "script_f" => |x, a, b| x.script_f(a, b).0,
            "script_f_error" => |x, a, b| x.script_f(a, b).1,
            _ => return Err(refused(format_args!("there is no matrix \"{name}\""))),
        };
        let n = network.len();
        let values = (0..n * n).map(|k| of(network, k / n, k % n)).collect();
        let array = Array2::from_shape_vec((n, n), values).map_err(refused)?;
        Ok(array.into_pyarray(py))
    }

    /// Names of the nodes that are surfaces.
    #[getter]
    fn node_names(&self) -> Vec<String> {
        self.solution.nodes.names.clone()
    }

    /// Names of the rows.
    #[getter]
    fn row_names(&self) -> Vec<String> {
        self.solution.enclosure.rows.names.clone()
    }

    /// Areas of the nodes that are surfaces, m².
    #[getter]
    fn node_areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let network = self.solution.networks.first();
        let count = self.solution.nodes.names.len();
        let areas = network.map_or(Vec::new(), |(_, network)| network.areas[..count].to_vec());
        areas.into_pyarray(py)
    }

    /// Areas of rows, m².
    #[getter]
    fn row_areas<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let unit = self.solution.enclosure.metres_per_unit().powi(2);
        let areas = self.solution.enclosure.factors.areas.iter();
        areas
            .map(|a| unit * a)
            .collect::<Vec<f64>>()
            .into_pyarray(py)
    }

    /// The node of each row, or −1.
    #[getter]
    fn row_nodes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let rows = self.solution.nodes.of_rows.iter();
        let node = |node: &Option<u32>| node.map_or(-1, i64::from);
        rows.map(node).collect::<Vec<i64>>().into_pyarray(py)
    }

    /// An array of temperatures and fluxes by its name.
    fn heat<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let heat = self.solution.heat.as_ref();
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
        self.solution.heat.as_ref().map_or(0, |h| h.iterations)
    }

    /// The polygons of rows; none of matrices without.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Option<CellArrays<'py>>> {
        let cells = &self.solution.enclosure.rows.cells;
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

    /// Heat that rows give off in excess of what sky, ground and sun explain, W.
    #[getter]
    fn imbalance(&self) -> f64 {
        self.solution.imbalance().unwrap_or(0.0)
    }

    /// Writes a file of the format that its extension means.
    fn save(&self, py: Python<'_>, path: PathBuf, args: SolutionArgs) -> PyResult<()> {
        let options = args.options();
        let format = self.format(&path, options.part)?;
        let solution = self.solution.clone();
        work::run(py, &WorkOptions::new(None, None), move |p| {
            let output = Output::check(&path).map_err(output_error)?;
            let mut problem = None;
            let written = output.write(p, |out| {
                solution.write(format, &options, out).inspect_err(|e| {
                    // Not of the disk, but of the solution.
                    problem = e.get_ref().map(ToString::to_string);
                })
            });
            match problem {
                Some(words) if written.is_err() => {
                    Err(refused(format_args!("{}: {words}", path.display())))
                }
                _ => written.map(|_| ()).map_err(output_error),
            }
        })
    }
}

impl NativeThermalSolution {
    fn exchange_factors(&self, band: usize) -> PyResult<&ExchangeFactors> {
        let network = self.solution.networks.get(band);
        let (_, network) = network.ok_or_else(|| refused("there is no such band"))?;
        Ok(network)
    }

    fn format(&self, path: &Path, part: SolutionPart) -> PyResult<SolutionFormat> {
        let wrong = |why: &str| refused(format_args!("{}: {why}", path.display()));
        let format = SolutionFormat::from_path(path);
        let format = format.ok_or_else(|| {
            wrong("unknown format, expected .npz, .csv, .esatan, .sinda, or .vtu of temperatures")
        })?;
        let (networks, heat) = self.solution.part(part);
        match format.refusal(heat.is_some(), networks.len()) {
            Some(why) => Err(wrong(why)),
            None => Ok(format),
        }
    }
}

/// Share of black emission below a product of wavelength and temperature, µm·K.
#[pyfunction]
pub fn band_fractions<'py>(
    py: Python<'py>,
    products: PyReadonlyArray1<'py, f64>,
) -> Bound<'py, PyArray1<f64>> {
    let products = products.as_array();
    let fraction = |&x: &f64| match x {
        f64::INFINITY => 1.0,
        x if x.is_nan() => x,
        x => band_fraction(x, 1.0),
    };
    let shares: Vec<f64> = products.iter().map(fraction).collect();
    shares.into_pyarray(py)
}
