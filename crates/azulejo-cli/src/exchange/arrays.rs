//! Results of `exchange` as arrays.

use super::Exchange;
use azulejo_exchange::{ExchangeFactors, HeatBalance, SpectralRange};
use azulejo_formats::numpy::npy;
use azulejo_formats::numpy::npz::NpzWriter;
use std::io::{self, Write};

/// Numbers of each row, for VTU and the archive.
pub fn of_rows(exchange: &Exchange) -> Vec<(String, Vec<f64>)> {
    let Some((_, heat)) = &exchange.heat else {
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
    arrays
        .map(|(name, values)| (name.to_owned(), values.clone()))
        .into()
}

/// Writes an archive: nodes with their networks, and rows with temperatures and fluxes.
pub fn write(exchange: &Exchange, out: &mut dyn Write) -> io::Result<()> {
    let mut archive = NpzWriter::new(out);
    let one_band = exchange.networks.len() == 1;
    for (k, (range, network)) in exchange.networks.iter().enumerate() {
        if k == 0 {
            write_nodes(network, &mut archive)?;
        }
        let suffix = match range {
            SpectralRange::Thermal => String::new(),
            _ if one_band => String::new(),
            range => format!("@{range}"),
        };
        write_network(network, &suffix, &mut archive)?;
    }
    archive.add("row_names", |w| {
        npy::write_texts(&exchange.enclosure.rows.names, w)
    })?;
    let node = |node: &Option<u32>| node.map_or(-1, i64::from);
    let of_rows: Vec<i64> = exchange.nodes.of_rows.iter().map(node).collect();
    archive.add("row_node", |w| npy::write(&[of_rows.len()], &of_rows, w))?;
    for (name, values) in self::of_rows(exchange) {
        archive.add(&name, |w| npy::write(&[values.len()], &values, w))?;
    }
    if let Some((_, heat)) = &exchange.heat {
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
        archive.add("surroundings_T", |w| {
            npy::write(&[2], &exchange.surroundings, w)
        })?;
    }
    archive.finish()?;
    Ok(())
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
