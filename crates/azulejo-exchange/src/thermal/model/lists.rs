//! What a thermal model gives, as text.

use super::{BandNetwork, SolutionFormat, SolutionOptions, ThermalSolution};
use crate::files::text::csv_field;
use crate::thermal::bands::SpectralRange;
use crate::thermal::conductances::{
    ConductanceFormat, ConductanceOptions, Conductances, NodePair, SpaceNode, write,
};
use crate::thermal::network::{ExchangeFactors, HeatBalance};
use azulejo_factors::FormFactors;
use azulejo_factors::form_factors::{Exchange, RowRemainder};
use azulejo_trace::Progress;
use std::io::{self, Write};

/// Writes nodes with their temperatures and heat.
pub fn write_heat(
    solution: &ThermalSolution,
    heat: &HeatBalance,
    out: &mut dyn Write,
) -> io::Result<()> {
    let Some((_, network)) = solution.networks.first() else {
        return Ok(());
    };
    writeln!(out, "name,area,T,T_error,Q,Q_error")?;
    for (a, name) in solution.nodes.names.iter().enumerate() {
        let (t, dt) = (heat.node_temperatures[a], heat.node_temperature_errors[a]);
        let (q, dq) = (heat.node_heat[a], heat.node_heat_errors[a]);
        let (name, area) = (csv_field(name), network.areas[a]);
        writeln!(out, "{name},{area},{t},{dt},{q},{dq}")?;
    }
    Ok(())
}

/// Writes the conductances of each band; those of several as CSV with a column for it.
pub fn write_conductances(
    solution: &ThermalSolution,
    networks: &[BandNetwork],
    format: SolutionFormat,
    options: &SolutionOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    let format = match format {
        SolutionFormat::Esatan => ConductanceFormat::Esatan,
        SolutionFormat::Sinda => ConductanceFormat::Sinda,
        _ => ConductanceFormat::Csv,
    };
    for (k, (range, network)) in networks.iter().enumerate() {
        let band = match range {
            SpectralRange::Thermal => None,
            range => Some(range.to_string()),
        };
        let list_options = ConductanceOptions {
            model: options.model.clone(),
            sigma: options.sigma,
            band,
            with_header: k == 0,
            ..ConductanceOptions::default()
        };
        let list = conductances(network, options.truncate, solution.surroundings);
        write(&list, format, &list_options, out)?;
    }
    Ok(())
}

/// The pairs of a network, without those below a share of the smaller emitting area.
fn conductances(
    network: &ExchangeFactors,
    share: Option<f64>,
    surroundings: [f64; 2],
) -> Conductances {
    let surfaces = network.is_surface.iter().filter(|s| **s).count();
    let areas = exchange_areas(network, share);
    let pair = |a: usize, e: &Exchange| NodePair {
        nodes: [a as u32, e.column],
        gr: e.value,
        error: f64::from(e.error),
    };
    let is_pair = |a: usize, e: &Exchange| e.column as usize != a && (e.column as usize) < surfaces;
    let pairs = (0..surfaces).flat_map(|a| {
        let row = areas.exchange.upper(a).iter();
        row.filter(move |e| is_pair(a, e)).map(move |e| pair(a, e))
    });
    let with_space = |s: usize, a: usize| {
        let e = areas.exchange.get(a, s);
        (e.value, f64::from(e.error))
    };
    let space = |s: usize| SpaceNode {
        name: network.names[s].clone(),
        // Beside a surface of the same name it has a number.
        temperature: Some(surroundings[usize::from(network.names[s].starts_with("ground"))]),
        gr: (0..surfaces).map(|a| with_space(s, a)).collect(),
    };
    let eps = |a: usize| network.emitting[a] / network.areas[a].max(f64::MIN_POSITIVE);
    Conductances {
        names: network.names[..surfaces].to_vec(),
        areas: network.areas[..surfaces].to_vec(),
        eps: Some((0..surfaces).map(eps).collect()),
        pairs: pairs.collect(),
        space: (surfaces..network.len()).map(space).collect(),
    }
}

/// A network as exchange areas: truncation keeps the sums of their rows and their symmetry.
fn exchange_areas(network: &ExchangeFactors, share: Option<f64>) -> FormFactors {
    let n = network.len();
    let row = |a: usize| -> Vec<Exchange> {
        let entry = |b: usize| {
            let (value, error) = network.conductance(a, b);
            Exchange {
                column: b as u32,
                value,
                error: error as f32,
            }
        };
        (a..n).map(entry).filter(|e| e.value > 0.0).collect()
    };
    let mut areas = FormFactors {
        exchange: (0..n).map(row).collect(),
        areas: network.emitting.clone(),
        rest: vec![RowRemainder::default(); n],
        ends: vec![1.0; n],
        ..FormFactors::default()
    };
    if let Some(share) = share {
        // Nobody can cancel this progress.
        let _ = areas.truncate(share, &Progress::new());
    }
    areas
}
