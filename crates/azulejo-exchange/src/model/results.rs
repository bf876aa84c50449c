//! What was solved, as files.

use super::ThermalModel;
use crate::bands::SpectralRange;
use crate::enclosure::{Enclosure, Groups};
use crate::files::conductances::{
    self, ConductanceFormat, ConductanceOptions, Conductances, NodePair, SpaceNode,
};
use crate::files::{self, FactorFormat, FileOptions};
use crate::network::{ExchangeFactors, HeatBalance};
use azulejo_formats::numpy::npy;
use azulejo_formats::numpy::npz::NpzWriter;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

/// Conductances, temperatures and fluxes of a model, as far as they were asked for.
#[derive(Clone, Debug)]
pub struct ThermalResult {
    /// The rows.
    pub enclosure: Arc<Enclosure>,
    /// The nodes of rows.
    pub nodes: Groups,
    /// Conductances in each band in which surfaces emit.
    pub networks: Vec<(SpectralRange, ExchangeFactors)>,
    /// Temperatures and fluxes.
    pub heat: Option<HeatBalance>,
    /// Temperatures of sky and ground, K.
    pub surroundings: [f64; 2],
}

/// Formats of results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThermalResultFormat {
    /// All arrays, for NumPy.
    Archive,
    /// Nodes with temperatures and heat, or else conductances.
    Csv,
    /// Conductances for ESATAN.
    Esatan,
    /// Conductances for SINDA.
    Sinda,
    /// Temperatures and fluxes of polygons.
    Vtu,
}

impl ThermalResultFormat {
    /// The format that an extension means.
    pub fn from_path(path: &Path) -> Option<ThermalResultFormat> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "npz" => Some(ThermalResultFormat::Archive),
            "csv" => Some(ThermalResultFormat::Csv),
            "esatan" => Some(ThermalResultFormat::Esatan),
            "sinda" => Some(ThermalResultFormat::Sinda),
            "vtu" => Some(ThermalResultFormat::Vtu),
            _ => None,
        }
    }
}

/// How lists of conductances are written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConductanceList {
    /// Name of the model in ESATAN, of the submodel in SINDA.
    pub model: String,
    /// Whether SINDA's values are multiplied by the Stefan–Boltzmann constant.
    pub sigma: bool,
    /// Conductances below this share of the smaller node's emitting area are left out.
    pub truncate: f64,
}

impl ThermalResult {
    /// Results of a model.
    pub fn new(
        model: &ThermalModel,
        networks: Vec<(SpectralRange, ExchangeFactors)>,
        heat: Option<HeatBalance>,
        surroundings: [f64; 2],
    ) -> ThermalResult {
        ThermalResult {
            enclosure: model.enclosure().clone(),
            nodes: model.nodes().clone(),
            networks,
            heat,
            surroundings,
        }
    }

    /// Area of each node, m².
    pub fn node_areas(&self) -> Vec<f64> {
        let unit = self.enclosure.metres_per_unit().powi(2);
        let mut areas = vec![0.0; self.nodes.names.len()];
        for (area, node) in self.enclosure.factors.areas.iter().zip(&self.nodes.of_rows) {
            if let Some(node) = node {
                areas[*node as usize] += unit * area;
            }
        }
        areas
    }

    /// Writes a file.
    ///
    /// # Errors
    /// Those of writing, and [`FactorFileError`](crate::files::FactorFileError) in them: rows without polygons.
    pub fn write(
        &self,
        format: ThermalResultFormat,
        list: &ConductanceList,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        use ThermalResultFormat as F;
        match (format, &self.heat) {
            (F::Archive, _) => self.write_archive(out),
            (F::Vtu, _) => self.write_polygons(out),
            (F::Csv, Some(heat)) => self.write_heat(heat, out),
            (F::Csv, None) => self.write_list(ConductanceFormat::Csv, list, out),
            (F::Esatan, _) => self.write_list(ConductanceFormat::Esatan, list, out),
            (F::Sinda, _) => self.write_list(ConductanceFormat::Sinda, list, out),
        }
    }

    /// Numbers of each row, by name.
    pub fn arrays_of_rows(&self) -> Vec<(String, Vec<f64>)> {
        let Some(heat) = &self.heat else {
            return Vec::new();
        };
        let arrays = [
            ("T", &heat.temperatures),
            ("q", &heat.fluxes),
            ("J", &heat.radiosities),
            ("H", &heat.irradiations),
            ("solar", &heat.solar),
        ];
        arrays
            .map(|(name, values)| (name.to_owned(), values.clone()))
            .into()
    }

    fn write_polygons(&self, out: &mut dyn Write) -> io::Result<()> {
        let options = FileOptions {
            arrays: self.arrays_of_rows(),
            ..FileOptions::default()
        };
        let written = files::write(&self.enclosure, FactorFormat::Vtu, &options, out);
        written.map(|_| ()).map_err(io::Error::other)
    }

    /// Nodes with their temperatures and heat.
    fn write_heat(&self, heat: &HeatBalance, out: &mut dyn Write) -> io::Result<()> {
        let areas = self.node_areas();
        writeln!(out, "name,area,T,T_error,Q,Q_error")?;
        for (a, name) in self.nodes.names.iter().enumerate() {
            let (t, dt) = (heat.node_temperatures[a], heat.node_temperature_errors[a]);
            let (q, dq) = (heat.node_heat[a], heat.node_heat_errors[a]);
            let name = if name.contains([',', '"', '\n', '\r']) {
                format!("\"{}\"", name.replace('"', "\"\""))
            } else {
                name.clone()
            };
            writeln!(out, "{name},{},{t},{dt},{q},{dq}", areas[a])?;
        }
        Ok(())
    }

    /// The conductances of each band.
    fn write_list(
        &self,
        format: ConductanceFormat,
        list: &ConductanceList,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let options = ConductanceOptions {
            model: list.model.clone(),
            sigma: list.sigma,
            ..ConductanceOptions::default()
        };
        for (_, network) in &self.networks {
            let pairs = pairs(network, list.truncate, self.surroundings);
            conductances::write(&pairs, format, &options, out)?;
        }
        Ok(())
    }

    /// Nodes with their networks, and rows with temperatures and fluxes.
    fn write_archive(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut archive = NpzWriter::new(out);
        match self.networks.first() {
            Some((_, network)) => write_nodes(network, &mut archive)?,
            None => self.write_plain_nodes(&mut archive)?,
        }
        let one_band = self.networks.len() == 1;
        for (range, network) in &self.networks {
            let suffix = match range {
                SpectralRange::Thermal => String::new(),
                _ if one_band => String::new(),
                range => format!("@{range}"),
            };
            write_network(network, &suffix, &mut archive)?;
        }
        archive.add("row_names", |w| {
            npy::write_texts(&self.enclosure.rows.names, w)
        })?;
        let node = |node: &Option<u32>| node.map_or(-1, i64::from);
        let of_rows: Vec<i64> = self.nodes.of_rows.iter().map(node).collect();
        archive.add("row_node", |w| npy::write(&[of_rows.len()], &of_rows, w))?;
        for (name, values) in self.arrays_of_rows() {
            archive.add(&name, |w| npy::write(&[values.len()], &values, w))?;
        }
        if let Some(heat) = &self.heat {
            write_heat_of_nodes(heat, self.surroundings, &mut archive)?;
        }
        archive.finish()?;
        Ok(())
    }

    /// Nodes where no network was asked for.
    fn write_plain_nodes<W: Write>(&self, archive: &mut NpzWriter<W>) -> io::Result<()> {
        let areas = self.node_areas();
        archive.add("names", |w| npy::write_texts(&self.nodes.names, w))?;
        archive.add("areas", |w| npy::write(&[areas.len()], &areas, w))
    }
}

fn write_heat_of_nodes<W: Write>(
    heat: &HeatBalance,
    surroundings: [f64; 2],
    archive: &mut NpzWriter<W>,
) -> io::Result<()> {
    let arrays = [
        ("node_T", &heat.node_temperatures),
        ("node_T_error", &heat.node_temperature_errors),
        ("node_Q", &heat.node_heat),
        ("node_Q_error", &heat.node_heat_errors),
    ];
    for (name, values) in arrays {
        archive.add(name, |w| npy::write(&[values.len()], values, w))?;
    }
    archive.add("to_surroundings", |w| {
        npy::write(&[2], &heat.to_surroundings, w)
    })?;
    archive.add("surroundings_T", |w| npy::write(&[2], &surroundings, w))
}

fn write_nodes<W: Write>(network: &ExchangeFactors, archive: &mut NpzWriter<W>) -> io::Result<()> {
    let n = network.len();
    archive.add("names", |w| npy::write_texts(&network.names, w))?;
    archive.add("areas", |w| npy::write(&[n], &network.areas, w))?;
    let is_surface: Vec<i32> = network.is_surface.iter().map(|&s| i32::from(s)).collect();
    archive.add("is_surface", |w| npy::write(&[n], &is_surface, w))
}

fn write_network<W: Write>(
    network: &ExchangeFactors,
    suffix: &str,
    archive: &mut NpzWriter<W>,
) -> io::Result<()> {
    let n = network.len();
    archive.add(&format!("emitting{suffix}"), |w| {
        npy::write(&[n], &network.emitting, w)
    })?;
    let mut add = |name: &str, of: &dyn Fn(usize, usize) -> f64| {
        archive.add(&format!("{name}{suffix}"), |w| {
            let all: Vec<f64> = (0..n * n).map(|k| of(k / n, k % n)).collect();
            npy::write(&[n, n], &all, w)
        })
    };
    add("GR", &|a, b| network.conductance(a, b).0)?;
    add("GR_error", &|a, b| network.conductance(a, b).1)?;
    add("B", &|a, b| network.gebhart(a, b).0)?;
    add("B_error", &|a, b| network.gebhart(a, b).1)?;
    add("script_F", &|a, b| network.script_f(a, b).0)?;
    add("script_F_error", &|a, b| network.script_f(a, b).1)
}

/// The pairs of a network, without those below a share of the smaller emitting area.
fn pairs(network: &ExchangeFactors, share: f64, surroundings: [f64; 2]) -> Conductances {
    let surfaces = network.is_surface.iter().filter(|s| **s).count();
    let is_kept = |a: usize, b: usize| {
        let smaller = network.emitting[a].min(network.emitting[b]);
        let (gr, _) = network.conductance(a, b);
        gr > 0.0 && gr >= share * smaller
    };
    let pair = |a: usize, b: usize| {
        let (gr, error) = network.conductance(a, b);
        NodePair {
            nodes: [a as u32, b as u32],
            gr,
            error,
        }
    };
    let all = (0..surfaces).flat_map(|a| (a + 1..surfaces).map(move |b| (a, b)));
    let space = |s: usize| {
        let of = |a: usize| {
            if is_kept(a, s) {
                network.conductance(a, s)
            } else {
                (0.0, 0.0)
            }
        };
        SpaceNode {
            name: network.names[s].clone(),
            temperature: Some(surroundings[usize::from(network.names[s] == "ground")]),
            gr: (0..surfaces).map(of).collect(),
        }
    };
    let eps = |a: usize| network.emitting[a] / network.areas[a].max(f64::MIN_POSITIVE);
    Conductances {
        names: network.names[..surfaces].to_vec(),
        areas: network.areas[..surfaces].to_vec(),
        eps: Some((0..surfaces).map(eps).collect()),
        pairs: all
            .filter(|&(a, b)| is_kept(a, b))
            .map(|(a, b)| pair(a, b))
            .collect(),
        space: (surfaces..network.len()).map(space).collect(),
    }
}
