//! What a thermal model gives, as files.

use super::lists;
use super::{BandNetwork, ThermalSolution};
use crate::files::{self, FactorFormat, FileOptions};
use crate::thermal::bands::SpectralRange;
use crate::thermal::network::{ExchangeFactors, HeatBalance};
use azulejo_formats::numpy::npy;
use azulejo_formats::numpy::npz::NpzWriter;
use std::io::{self, Write};
use std::path::Path;

/// Formats of solutions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolutionFormat {
    /// NumPy arrays of everything.
    Archive,
    /// Temperatures and heat of nodes if there are any, else conductances.
    Csv,
    /// Conductances for ESATAN.
    Esatan,
    /// Conductances for SINDA.
    Sinda,
    /// The surfaces with temperatures and fluxes per cell.
    Vtu,
}

/// What of a solution is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolutionPart {
    /// All: temperatures and fluxes if there are any, and all networks.
    #[default]
    Whole,
    /// The networks of all bands, without temperatures.
    Networks,
    /// The network of one band.
    Network(usize),
}

/// How solutions are written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolutionOptions {
    /// The model or submodel of ESATAN's and SINDA's nodes; none if empty.
    pub model: String,
    /// Whether SINDA's values are multiplied by σ.
    pub sigma: bool,
    /// Share of the smaller node's emitting area below which lists leave out conductances and give their
    /// weight to the others.
    pub truncate: Option<f64>,
    /// What is written.
    pub part: SolutionPart,
}

impl SolutionFormat {
    /// The format that a file's extension means.
    pub fn from_path(path: &Path) -> Option<SolutionFormat> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "npz" => Some(SolutionFormat::Archive),
            "csv" => Some(SolutionFormat::Csv),
            "esatan" => Some(SolutionFormat::Esatan),
            "sinda" => Some(SolutionFormat::Sinda),
            "vtu" => Some(SolutionFormat::Vtu),
            _ => None,
        }
    }

    /// Why this format cannot hold solutions with or without temperatures, in this number of bands.
    pub fn refusal(self, has_conditions: bool, bands: usize) -> Option<&'static str> {
        match self {
            SolutionFormat::Vtu if !has_conditions => {
                Some("a VTU shows temperatures and fluxes, expected those of some surfaces")
            }
            SolutionFormat::Esatan | SolutionFormat::Sinda if bands > 1 => Some(
                "its conductances are for one band, and these materials have several: .npz and .csv have them all",
            ),
            _ => None,
        }
    }
}

impl ThermalSolution {
    /// Writes a file.
    ///
    /// # Errors
    /// Those of writing, and a [refusal](SolutionFormat::refusal).
    ///
    /// # Panics
    /// If a [part](SolutionPart::Network) is requested that does not exist.
    pub fn write(
        &self,
        format: SolutionFormat,
        options: &SolutionOptions,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let (networks, heat) = self.part(options.part);
        if let Some(why) = format.refusal(heat.is_some(), networks.len()) {
            return Err(io::Error::other(why));
        }
        match (format, heat) {
            (SolutionFormat::Archive, heat) => self.write_archive(networks, heat, out),
            (SolutionFormat::Csv, Some(heat)) => lists::write_heat(self, heat, out),
            (SolutionFormat::Vtu, _) => {
                let options = FileOptions {
                    arrays: self.arrays_of_rows(),
                    ..FileOptions::default()
                };
                let written = files::write(&self.enclosure, FactorFormat::Vtu, &options, out);
                written.map(|_| ()).map_err(io::Error::other)
            }
            (format, _) => lists::write_conductances(self, networks, format, options, out),
        }
    }

    /// The networks of a part, and its temperatures and fluxes.
    pub fn part(&self, part: SolutionPart) -> (&[BandNetwork], Option<&HeatBalance>) {
        match part {
            SolutionPart::Whole => (&self.networks, self.heat.as_ref()),
            SolutionPart::Networks => (&self.networks, None),
            SolutionPart::Network(k) => (&self.networks[k..=k], None),
        }
    }

    /// Temperatures, fluxes and light of each row, by name; nothing without conditions.
    pub fn arrays_of_rows(&self) -> Vec<(String, Vec<f64>)> {
        let Some(heat) = &self.heat else {
            return Vec::new();
        };
        let HeatBalance {
            temperatures,
            fluxes,
            radiosities,
            irradiations,
            solar,
            ..
        } = heat;
        let arrays = [
            ("T", temperatures),
            ("q", fluxes),
            ("J", radiosities),
            ("H", irradiations),
            ("solar", solar),
        ];
        let owned = arrays.map(|(name, values)| (name.to_owned(), values.clone()));
        owned.into()
    }

    /// Nodes with their networks, and rows with temperatures and fluxes.
    fn write_archive(
        &self,
        networks: &[BandNetwork],
        heat: Option<&HeatBalance>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let mut archive = NpzWriter::new(out);
        if let Some((_, network)) = networks.first() {
            write_nodes(network, &mut archive)?;
        }
        for (range, network) in networks {
            let suffix = match range {
                SpectralRange::Thermal => String::new(),
                range => format!("@{range}"),
            };
            write_network(network, &suffix, &mut archive)?;
        }
        archive.add("row_names", |w| {
            npy::write_texts(&self.enclosure.rows.names, w)
        })?;
        let node = |node: &Option<u32>| node.map_or(-1, i64::from);
        let row_nodes: Vec<i64> = self.nodes.of_rows.iter().map(node).collect();
        archive.add("row_node", |w| {
            npy::write(&[row_nodes.len()], &row_nodes, w)
        })?;
        if let Some(heat) = heat {
            for (name, values) in self.arrays_of_rows() {
                archive.add(&name, |w| npy::write(&[values.len()], &values, w))?;
            }
            let arrays = [
                ("node_T", &heat.node_temperatures[..]),
                ("node_T_error", &heat.node_temperature_errors),
                ("node_Q", &heat.node_heat),
                ("node_Q_error", &heat.node_heat_errors),
                ("to_surroundings", &heat.to_surroundings),
                ("surroundings_T", &self.surroundings),
            ];
            for (name, values) in arrays {
                archive.add(name, |w| npy::write(&[values.len()], values, w))?;
            }
        }
        archive.finish()
    }
}

fn write_nodes(network: &ExchangeFactors, archive: &mut NpzWriter) -> io::Result<()> {
    let n = network.len();
    archive.add("names", |w| npy::write_texts(&network.names, w))?;
    archive.add("areas", |w| npy::write(&[n], &network.areas, w))?;
    let is_surface: Vec<i32> = network.is_surface.iter().map(|&s| i32::from(s)).collect();
    archive.add("is_surface", |w| npy::write(&[n], &is_surface, w))
}

fn write_network(
    network: &ExchangeFactors,
    suffix: &str,
    archive: &mut NpzWriter,
) -> io::Result<()> {
    let n = network.len();
    archive.add(&format!("emitting{suffix}"), |w| {
        npy::write(&[n], &network.emitting, w)
    })?;
    let mut add = |name: &str, of: &dyn Fn(usize, usize) -> f64| {
        archive.add(&format!("{name}{suffix}"), |w| {
            let values: Vec<f64> = (0..n * n).map(|k| of(k / n, k % n)).collect();
            npy::write(&[n, n], &values, w)
        })
    };
    add("GR", &|a, b| network.conductance(a, b).0)?;
    add("GR_error", &|a, b| network.conductance(a, b).1)?;
    add("B", &|a, b| network.gebhart(a, b).0)?;
    add("B_error", &|a, b| network.gebhart(a, b).1)?;
    add("script_F", &|a, b| network.script_f(a, b).0)?;
    add("script_F_error", &|a, b| network.script_f(a, b).1)
}
