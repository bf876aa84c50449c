//! Results of `exchange` as text.

use super::args::ExchangeArgs;
use super::{Exchange, ExchangeFormat};
use azulejo_exchange::ExchangeFactors;
use azulejo_exchange::files::conductances::{
    ConductanceFormat, ConductanceOptions, Conductances, NodePair, SpaceNode, write,
};
use std::io::{self, Write};

/// Writes nodes with their temperatures and heat.
pub fn write_heat(exchange: &Exchange, out: &mut dyn Write) -> io::Result<()> {
    let Some((_, heat)) = &exchange.heat else {
        return Ok(());
    };
    let network = &exchange.networks[0].1;
    writeln!(out, "name,area,T,T_error,Q,Q_error")?;
    for (a, name) in exchange.nodes.names.iter().enumerate() {
        let (t, dt) = (heat.node_temperatures[a], heat.node_temperature_errors[a]);
        let (q, dq) = (heat.node_heat[a], heat.node_heat_errors[a]);
        let name = if name.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", name.replace('"', "\"\""))
        } else {
            name.clone()
        };
        writeln!(out, "{name},{},{t},{dt},{q},{dq}", network.areas[a])?;
    }
    Ok(())
}

/// Writes the conductances of each band.
pub fn write_conductances(
    args: &ExchangeArgs,
    exchange: &Exchange,
    format: ExchangeFormat,
    out: &mut dyn Write,
) -> io::Result<()> {
    let format = match format {
        ExchangeFormat::Esatan => ConductanceFormat::Esatan,
        ExchangeFormat::Sinda => ConductanceFormat::Sinda,
        _ => ConductanceFormat::Csv,
    };
    let options = ConductanceOptions {
        model: args.model.clone(),
        sigma: args.sigma,
        ..ConductanceOptions::default()
    };
    for (_, network) in &exchange.networks {
        let list = conductances(network, args.truncate.unwrap_or(0.0), exchange.surroundings);
        write(&list, format, &options, out)?;
    }
    Ok(())
}

/// The pairs of a network, without those below a share of the smaller emitting area.
fn conductances(network: &ExchangeFactors, share: f64, surroundings: [f64; 2]) -> Conductances {
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
    let pairs = (0..surfaces).flat_map(|a| (a + 1..surfaces).map(move |b| (a, b)));
    let space = |s: usize| {
        let gr = (0..surfaces).map(|a| {
            if is_kept(a, s) {
                network.conductance(a, s)
            } else {
                (0.0, 0.0)
            }
        });
        SpaceNode {
            name: network.names[s].clone(),
            temperature: Some(surroundings[usize::from(network.names[s] == "ground")]),
            gr: gr.collect(),
        }
    };
    let eps = |a: usize| network.emitting[a] / network.areas[a].max(f64::MIN_POSITIVE);
    Conductances {
        names: network.names[..surfaces].to_vec(),
        areas: network.areas[..surfaces].to_vec(),
        eps: Some((0..surfaces).map(eps).collect()),
        pairs: pairs
            .filter(|&(a, b)| is_kept(a, b))
            .map(|(a, b)| pair(a, b))
            .collect(),
        space: (surfaces..network.len()).map(space).collect(),
    }
}
