//! `exchange`: Gebhart factors, conductances, temperatures and heat fluxes from form factors.

pub mod args;
mod sources;

use super::failure::Failure;
use super::report::{Report, count, number, short, with_error};
use super::session::Session;
use args::ExchangeArgs;
use azulejo::models;
use azulejo::output::{Output, commit};
use azulejo_exchange::thermal::model::{SolutionFormat, SolutionOptions};
use azulejo_exchange::thermal::tables::{BoundaryTable, MaterialTable};
use azulejo_exchange::{
    Enclosure, ExchangeError, HeatBalance, ModelError, SpectralRange, ThermalModel, ThermalSolution,
};
use std::io;
use std::path::Path;

/// Nodes whose temperatures the summary has.
const LISTED: usize = 20;

/// Runs `exchange`.
pub fn run(args: &ExchangeArgs, session: &mut Session) -> Result<Report, Failure> {
    let outputs = outputs(args)?;
    session.claim_stdout(outputs.iter().any(|(output, _)| output.is_stdout()))?;
    let materials = MaterialTable::read(&text(&args.materials)?);
    let materials = materials.map_err(|e| in_file(&args.materials, e))?;
    let boundary = match &args.boundary {
        Some(path) => Some(BoundaryTable::read(&text(path)?).map_err(|e| in_file(path, e))?),
        None => None,
    };
    refuse_formats(&outputs, &materials, boundary.is_some())?;
    let mut report = Report::default();
    let matrices = sources::enclosures(args, &materials, session, &mut report)?;
    let model = model(args, matrices, &materials, boundary.as_ref(), session)?;
    let solution = session.with_progress(|p| model.solve(p));
    let solution = solution.map_err(|e| match e {
        ModelError::Exchange(ExchangeError::Cancelled) => Failure::Cancelled,
        other => Failure::failed(other),
    })?;
    solution.notes.iter().for_each(|note| session.note(note));
    describe(&solution, &mut report);
    write(args, &solution, &outputs, session, &mut report)?;
    Ok(report)
}

/// Where to write what.
fn outputs(args: &ExchangeArgs) -> Result<Vec<(Output, SolutionFormat)>, Failure> {
    let output = |path: &std::path::PathBuf| {
        let output = Output::check(path)?;
        match SolutionFormat::from_path(path) {
            Some(format) => Ok((output, format)),
            None if output.is_stdout() => Ok((output, SolutionFormat::Csv)),
            None => Err(Failure::misuse(format_args!(
                "{}: unknown format, expected .npz, .csv, .esatan, .sinda or .vtu",
                path.display()
            ))),
        }
    };
    args.output.iter().map(output).collect()
}

/// Refuses formats that cannot hold the solution before the work begins.
fn refuse_formats(
    outputs: &[(Output, SolutionFormat)],
    materials: &MaterialTable,
    has_conditions: bool,
) -> Result<(), Failure> {
    let ranges = materials.bands.iter().map(|band| band.range);
    let bands = ranges.filter(|r| *r != SpectralRange::Solar).count();
    for (output, format) in outputs {
        if let Some(why) = format.refusal(has_conditions, bands) {
            let hint = match format {
                SolutionFormat::Vtu => " (--boundary)",
                _ => "",
            };
            return Err(Failure::misuse(format_args!(
                "{}: {why}{hint}",
                output.path().display()
            )));
        }
    }
    Ok(())
}

fn text(path: &Path) -> Result<String, Failure> {
    let bytes = models::read_bytes(path)?;
    String::from_utf8(bytes)
        .map_err(|_| Failure::failed(format_args!("{}: not a text in UTF-8", path.display())))
}

fn in_file(path: &Path, error: impl std::fmt::Display) -> Failure {
    Failure::failed(format_args!("{}: {error}", path.display()))
}

/// The model that tables and matrices make.
fn model(
    args: &ExchangeArgs,
    matrices: Vec<(String, Enclosure)>,
    materials: &MaterialTable,
    boundary: Option<&BoundaryTable>,
    session: &mut Session,
) -> Result<ThermalModel, Failure> {
    let first = &matrices[0].1;
    let properties = materials.of_rows(first);
    let properties = properties.map_err(|e| in_file(&args.materials, e))?;
    note_unused(&materials.unused(first), &args.materials, session);
    let mut conditions = None;
    if let (Some(table), Some(path)) = (boundary, &args.boundary) {
        conditions = Some(table.of_rows(first).map_err(|e| in_file(path, e))?);
        note_unused(&table.unused(first), path, session);
    }
    let ranges = materials.bands.iter().map(|band| band.range);
    Ok(ThermalModel {
        matrices,
        bands: ranges.zip(properties).collect(),
        conditions,
        surroundings: boundary.map_or([None; 2], |b| b.surroundings),
        nodes: args.by.groups(),
        lump: args.lump,
    })
}

fn note_unused(unused: &[&str], path: &Path, session: &mut Session) {
    if !unused.is_empty() {
        let names = unused.join("\", \"");
        session.note(&format!(
            "{}: no row has the name \"{names}\"",
            path.display()
        ));
    }
}

/// Adds the size of the network, its balance, and the heat of nodes.
fn describe(solution: &ThermalSolution, report: &mut Report) {
    let rows = solution.enclosure.len();
    report.fact("rows", rows, "rows", count(rows));
    let nodes = solution.nodes.names.len();
    report.fact("nodes", nodes, "nodes", count(nodes));
    for (range, network) in &solution.networks {
        let off = ThermalSolution::closure(network);
        let label = match range {
            SpectralRange::Thermal => "closure".to_owned(),
            range => format!("closure {range}"),
        };
        let words = format!(
            "Gebhart factors of a node add up to 1 within {}",
            short(off)
        );
        report.fact(&label.replace(' ', "_"), number(off), &label, words);
        report.value("asymmetry", number(network.asymmetry));
    }
    if let Some(heat) = &solution.heat {
        describe_heat(solution, heat, report);
    }
}

fn describe_heat(solution: &ThermalSolution, heat: &HeatBalance, report: &mut Report) {
    let names = &solution.nodes.names;
    let mut node_values = Vec::new();
    for (a, name) in names.iter().enumerate() {
        let (t, dt) = (heat.node_temperatures[a], heat.node_temperature_errors[a]);
        let (q, dq) = (heat.node_heat[a], heat.node_heat_errors[a]);
        if a < LISTED {
            let words = format!("{} K, {} W", with_error(t, dt), with_error(q, dq));
            report.line(name, words);
        }
        node_values.push(serde_json::json!({
            "name": name,
            "T": number(t),
            "T_error": number(dt),
            "Q": number(q),
            "Q_error": number(dq),
        }));
    }
    if names.len() > LISTED {
        report.line("", format!("and {} more nodes", names.len() - LISTED));
    }
    report.value("heat", node_values);
    for (k, name) in ["sky", "ground"].into_iter().enumerate() {
        let (gain, t) = (heat.to_surroundings[k], solution.surroundings[k]);
        if gain != 0.0 {
            report.line(name, format!("{} K, {} W", short(t), short(-gain)));
        }
        report.value(&format!("to_{name}"), number(gain));
    }
    let off = solution.imbalance().unwrap_or_default();
    let words = format!(
        "net heat of all rows, sky, ground and sun: {} W",
        short(off)
    );
    report.fact("imbalance", number(off), "balance", words);
}

/// Writes all outputs, or none.
fn write(
    args: &ExchangeArgs,
    solution: &ThermalSolution,
    outputs: &[(Output, SolutionFormat)],
    session: &mut Session,
    report: &mut Report,
) -> Result<(), Failure> {
    let options = SolutionOptions {
        model: args.model.clone(),
        sigma: args.sigma,
        truncate: args.truncate,
        ..SolutionOptions::default()
    };
    let (mut drafts, mut names) = (Vec::new(), Vec::new());
    for (output, format) in outputs {
        let mut draft = output.draft()?;
        let written: io::Result<()> = solution.write(*format, &options, &mut draft);
        written.map_err(|e| output.error(e))?;
        drafts.push(draft);
        names.push(output.path().display().to_string());
    }
    commit(drafts, session.progress())?;
    let words = names.join(", ");
    report.fact("output", names, "wrote", words);
    Ok(())
}
