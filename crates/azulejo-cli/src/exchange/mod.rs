//! `exchange`: Gebhart factors, conductances, temperatures and heat fluxes from form factors.

pub mod args;
mod arrays;
mod lists;

use super::failure::Failure;
use super::form_factors::stored::read_archive;
use super::report::{Report, count, number, percent};
use super::session::Session;
use args::ExchangeArgs;
use azulejo::models;
use azulejo::output::{Output, commit};
use azulejo_exchange::files::{FactorFormat, FileOptions};
use azulejo_exchange::tables::{BoundaryTable, Conditions, MaterialTable, Properties};
use azulejo_exchange::{
    Enclosure, ExchangeFactors, Groups, HeatBalance, HeatProblem, RowCondition, SpectralRange,
    SurfaceBand, exchange_factors, heat_balance,
};
use std::io::{self, Write};
use std::path::Path;

/// All that is known at the end.
struct Exchange {
    enclosure: Enclosure,
    nodes: Groups,
    /// Each band in which surfaces emit, by the name of its columns, with its network.
    networks: Vec<(SpectralRange, ExchangeFactors)>,
    heat: Option<(Conditions, HeatBalance)>,
    surroundings: [f64; 2],
}

/// What a file gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ExchangeFormat {
    Archive,
    Csv,
    Esatan,
    Sinda,
    Vtu,
}

/// Difference of mirror reflectances that counts as none.
const SAME: f64 = 1e-6;

/// Share of a row's light that may be lost without a word.
const LOST: f64 = 1e-3;

/// Temperature of sky and ground that no table has: that of space, K.
const SPACE: f64 = 3.0;

/// Runs `exchange`.
pub fn run(args: &ExchangeArgs, session: &mut Session) -> Result<Report, Failure> {
    let outputs = outputs(args)?;
    session.claim_stdout(outputs.iter().any(|(output, _)| output.is_stdout()))?;
    let materials = MaterialTable::read(&text(&args.materials)?);
    let materials = materials.map_err(|e| of_table(&args.materials, e))?;
    let boundary = match &args.boundary {
        Some(path) => Some(BoundaryTable::read(&text(path)?).map_err(|e| of_table(path, e))?),
        None => None,
    };
    let mut enclosures = Vec::new();
    for path in &args.factors {
        enclosures.push(prepared(args, path, session)?);
    }
    let mut report = Report::default();
    let exchange = solve(args, enclosures, &materials, boundary.as_ref(), session)?;
    describe(&exchange, &mut report);
    write(args, &exchange, &outputs, session, &mut report)?;
    Ok(report)
}

/// Where to write what.
fn outputs(args: &ExchangeArgs) -> Result<Vec<(Output, ExchangeFormat)>, Failure> {
    let output = |path: &std::path::PathBuf| {
        let output = Output::check(path)?;
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        let format = match extension.to_ascii_lowercase().as_str() {
            "npz" => ExchangeFormat::Archive,
            "csv" => ExchangeFormat::Csv,
            "esatan" => ExchangeFormat::Esatan,
            "sinda" => ExchangeFormat::Sinda,
            "vtu" => ExchangeFormat::Vtu,
            _ if output.is_stdout() => ExchangeFormat::Csv,
            _ => {
                return Err(Failure::misuse(format_args!(
                    "{}: unknown format, expected .npz, .csv, .esatan, .sinda or .vtu",
                    path.display()
                )));
            }
        };
        if format == ExchangeFormat::Vtu && args.boundary.is_none() {
            return Err(Failure::misuse(format_args!(
                "{}: a VTU shows temperatures and fluxes, which need --boundary",
                path.display()
            )));
        }
        Ok((output, format))
    };
    args.output.iter().map(output).collect()
}

fn text(path: &Path) -> Result<String, Failure> {
    let bytes = models::read_bytes(path)?;
    String::from_utf8(bytes)
        .map_err(|_| Failure::failed(format_args!("{}: not a text in UTF-8", path.display())))
}

fn of_table(path: &Path, error: impl std::fmt::Display) -> Failure {
    Failure::failed(format_args!("{}: {error}", path.display()))
}

/// A matrix as it was computed, or lumped, with what it loses given to the sky if that is asked for.
fn prepared(args: &ExchangeArgs, path: &Path, session: &mut Session) -> Result<Enclosure, Failure> {
    let mut enclosure = read_archive(path, args.memory, session)?;
    let rest = &mut enclosure.factors.rest;
    let lost = |r: &azulejo_factors::form_factors::RowRemainder| r.hidden + r.cut;
    let most = rest.iter().map(lost).fold(0.0, f64::max);
    if args.lost_to_sky {
        for row in rest {
            row.sky += lost(row);
            (row.hidden, row.cut) = (0.0, 0.0);
        }
    } else if most > LOST {
        session.note(&format!(
            "{}: up to {} of a row's light ends on backs or is cut off between mirrors, where nothing absorbs it; \
             --lost-to-sky gives it to the sky, form-factors --two-sided has rows of backs",
            path.display(),
            percent(most)
        ));
    }
    Ok(enclosure)
}

/// Nodes of the rows.
fn nodes(args: &ExchangeArgs, enclosure: &Enclosure) -> Groups {
    match args.by.groups() {
        Some(by) if !enclosure.rows.are_groups => enclosure.groups(by),
        _ => Groups {
            of_rows: (0..enclosure.len() as u32).map(Some).collect(),
            names: enclosure.rows.names.clone(),
        },
    }
}

fn solve(
    args: &ExchangeArgs,
    enclosures: Vec<Enclosure>,
    materials: &MaterialTable,
    boundary: Option<&BoundaryTable>,
    session: &mut Session,
) -> Result<Exchange, Failure> {
    let first = &enclosures[0];
    if let Some(k) = enclosures
        .iter()
        .position(|e| e.rows.names != first.rows.names)
    {
        return Err(Failure::failed(format_args!(
            "{}: its rows are not those of {}",
            args.factors[k].display(),
            args.factors[0].display()
        )));
    }
    let properties = materials.of_rows(first);
    let properties = properties.map_err(|e| of_table(&args.materials, e))?;
    note_unused(&materials.unused(first), &args.materials, session);
    let mut conditions = None;
    if let (Some(table), Some(path)) = (boundary, &args.boundary) {
        conditions = Some(table.of_rows(first).map_err(|e| of_table(path, e))?);
        note_unused(&table.unused(first), path, session);
    }
    let mut groups = nodes(args, first);
    let (mut used, mut emissivities) = (Vec::new(), Vec::new());
    for (band, rows) in materials.bands.iter().zip(&properties) {
        used.push(matching(args, &enclosures, band.range, rows)?);
        emissivities.push(rows.iter().map(|p| p.emissivity).collect::<Vec<f64>>());
    }
    let mut enclosures = enclosures;
    if args.lump {
        let areas = enclosures[0].factors.areas.clone();
        for e in &mut emissivities {
            *e = lumped(e, &areas, &groups)
                .map_err(|(node, low, high)| uneven(node, low, high, "eps"))?;
        }
        for enclosure in &mut enclosures {
            let mirrors = enclosure.mirror_reflectances();
            lumped(&mirrors, &areas, &groups)
                .map_err(|(node, low, high)| uneven(node, low, high, "rho_s"))?;
            *enclosure = enclosure.grouped(&groups);
        }
        conditions = conditions
            .map(|c| lumped_conditions(c, &groups))
            .transpose()?;
        groups = Groups {
            of_rows: (0..groups.names.len() as u32).map(Some).collect(),
            names: groups.names,
        };
    }
    let bands: Vec<SurfaceBand> = materials
        .bands
        .iter()
        .zip(used.iter().zip(emissivities))
        .map(|(band, (&k, emissivity))| SurfaceBand {
            enclosure: &enclosures[k],
            range: band.range,
            emissivity,
        })
        .collect();
    let failed = |e: azulejo_exchange::ExchangeError| match e {
        azulejo_exchange::ExchangeError::Cancelled => Failure::Cancelled,
        other => Failure::failed(other),
    };
    let mut networks = Vec::new();
    for band in bands.iter().filter(|b| b.range != SpectralRange::Solar) {
        let network = session.with_progress(|p| exchange_factors(band, &groups, p));
        networks.push((band.range, network.map_err(failed)?));
    }
    let given = boundary.map_or([None; 2], |b| b.surroundings);
    let surroundings = given.map(|t| t.unwrap_or(SPACE));
    let mut heat = None;
    if let Some(conditions) = conditions {
        let solar = solar(&conditions, &enclosures[0], materials, session);
        let problem = HeatProblem {
            bands: &bands,
            conditions: &conditions.rows,
            surroundings,
            solar: &solar,
        };
        let balance = session.with_progress(|p| heat_balance(&problem, &groups, p));
        heat = Some((conditions.clone(), balance.map_err(failed)?));
    }
    note_surroundings(&given, heat.is_some(), &enclosures[0], session);
    Ok(Exchange {
        enclosure: enclosures.swap_remove(0),
        nodes: groups,
        networks,
        heat,
        surroundings,
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

fn note_surroundings(
    given: &[Option<f64>; 2],
    has_heat: bool,
    enclosure: &Enclosure,
    session: &mut Session,
) {
    let rest = &enclosure.factors.rest;
    let shares = [
        rest.iter().any(|r| r.sky > 1e-6),
        rest.iter().any(|r| r.ground > 1e-6),
    ];
    for (k, name) in ["sky", "ground"].into_iter().enumerate() {
        if has_heat && shares[k] && given[k].is_none() {
            session.note(&format!(
                "no temperature of the {name} is given: {SPACE} K, that of space, is taken"
            ));
        }
    }
}

/// The first matrix that was computed with the mirrors of a band.
fn matching(
    args: &ExchangeArgs,
    enclosures: &[Enclosure],
    range: SpectralRange,
    rows: &[Properties],
) -> Result<usize, Failure> {
    let differs = |enclosure: &Enclosure| {
        let mirrors = enclosure.mirror_reflectances();
        let mut pairs = mirrors.iter().zip(rows).enumerate();
        let off = pairs.find(|(_, (a, b))| (*a - b.mirror).abs() > SAME);
        off.map(|(i, (a, b))| (i, *a, b.mirror))
    };
    let found = enclosures.iter().position(|e| differs(e).is_none());
    found.ok_or_else(|| {
        let (i, computed, asked) = differs(&enclosures[0]).unwrap_or_default();
        let band = match range {
            SpectralRange::Thermal => String::new(),
            range => format!(" in the band {range}"),
        };
        Failure::failed(format_args!(
            "{}: its factors were computed with mirror reflectance {computed} of \"{}\", the table has {asked}{band}: \
             compute them with form-factors --materials {}",
            args.factors[0].display(),
            enclosures[0].rows.names[i],
            args.materials.display()
        ))
    })
}

/// The one value of each node, or the node whose rows have several.
fn lumped<'a>(
    values: &[f64],
    areas: &[f64],
    groups: &'a Groups,
) -> Result<Vec<f64>, (&'a str, f64, f64)> {
    let mut of_nodes: Vec<Option<f64>> = vec![None; groups.names.len()];
    for ((&value, &area), group) in values.iter().zip(areas).zip(&groups.of_rows) {
        let Some(group) = group.filter(|_| area > 0.0) else {
            continue;
        };
        let known = *of_nodes[group as usize].get_or_insert(value);
        if (known - value).abs() > SAME {
            return Err((
                &groups.names[group as usize],
                known.min(value),
                known.max(value),
            ));
        }
    }
    Ok(of_nodes
        .into_iter()
        .map(Option::unwrap_or_default)
        .collect())
}

fn uneven(node: &str, low: f64, high: f64, what: &str) -> Failure {
    Failure::failed(format_args!(
        "--lump: the rows of \"{node}\" have {what} from {low} to {high}, expected one value: choose nodes that are \
         even (--by material), or leave out --lump"
    ))
}

/// The one condition of each node.
fn lumped_conditions(conditions: Conditions, groups: &Groups) -> Result<Conditions, Failure> {
    let count = groups.names.len();
    let mut rows: Vec<Option<RowCondition>> = vec![None; count];
    let mut solar: Vec<Option<f64>> = vec![None; count];
    for (i, group) in groups.of_rows.iter().enumerate() {
        let Some(group) = group.map(|g| g as usize) else {
            continue;
        };
        let known = *rows[group].get_or_insert(conditions.rows[i]);
        if known != conditions.rows[i] {
            return Err(Failure::failed(format_args!(
                "--lump: the rows of \"{}\" have different temperatures or fluxes",
                groups.names[group]
            )));
        }
        solar[group] = conditions.solar[i];
    }
    Ok(Conditions {
        rows: rows
            .into_iter()
            .map(|row| row.unwrap_or(RowCondition::Flux(0.0)))
            .collect(),
        solar,
    })
}

/// Sunlight on each row: of the table, or else of the matrix.
fn solar(
    conditions: &Conditions,
    enclosure: &Enclosure,
    materials: &MaterialTable,
    session: &mut Session,
) -> Vec<f64> {
    let outside = |i: usize| {
        enclosure
            .outside
            .as_ref()
            .map_or(0.0, |o| o[i].irradiance.mean())
    };
    let rows = conditions.solar.iter().enumerate();
    let solar: Vec<f64> = rows.map(|(i, e)| e.unwrap_or_else(|| outside(i))).collect();
    let is_lit = solar.iter().any(|&e| e > 0.0);
    let has_band = materials
        .bands
        .iter()
        .any(|b| b.range == SpectralRange::Solar);
    if is_lit && !has_band {
        session.note("sunlight has no effect, because the table of materials has no alpha");
    }
    if is_lit { solar } else { Vec::new() }
}

/// Adds the size of the network, its balance, and the heat of nodes.
fn describe(exchange: &Exchange, report: &mut Report) {
    let rows = exchange.enclosure.len();
    report.fact("rows", rows, "rows", count(rows));
    let nodes = exchange.nodes.names.len();
    report.fact("nodes", nodes, "nodes", count(nodes));
    for (range, network) in &exchange.networks {
        let sums = network.row_sums();
        let off = sums.iter().map(|s| (s - 1.0).abs()).fold(0.0, f64::max);
        let label = match range {
            SpectralRange::Thermal => "closure".to_owned(),
            range => format!("closure {range}"),
        };
        let words = format!("Gebhart factors of a node add up to 1 within {off:.1e}");
        report.fact(&label.replace(' ', "_"), number(off), &label, words);
        report.value("asymmetry", number(network.asymmetry));
    }
    let Some((_, heat)) = &exchange.heat else {
        return;
    };
    let names = exchange.nodes.names.iter().enumerate();
    for (a, name) in names.clone().take(20) {
        let (t, dt) = (heat.node_temperatures[a], heat.node_temperature_errors[a]);
        let (q, dq) = (heat.node_heat[a], heat.node_heat_errors[a]);
        report.line(
            name,
            format!("{t:.2} ± {dt:.2} K, gives off {q:.4} ± {dq:.2} W"),
        );
    }
    if nodes > 20 {
        report.line("", format!("and {} more nodes", nodes - 20));
    }
    let of_nodes: Vec<serde_json::Value> = names
        .map(|(a, name)| {
            serde_json::json!({
                "name": name,
                "T": number(heat.node_temperatures[a]),
                "T_error": number(heat.node_temperature_errors[a]),
                "Q": number(heat.node_heat[a]),
                "Q_error": number(heat.node_heat_errors[a]),
            })
        })
        .collect();
    report.value("heat", of_nodes);
    let [sky, ground] = heat.to_surroundings;
    report.value("to_sky", number(sky));
    report.value("to_ground", number(ground));
}

/// Writes all outputs, or none.
fn write(
    args: &ExchangeArgs,
    exchange: &Exchange,
    outputs: &[(Output, ExchangeFormat)],
    session: &mut Session,
    report: &mut Report,
) -> Result<(), Failure> {
    let (mut drafts, mut names) = (Vec::new(), Vec::new());
    for (output, format) in outputs {
        let mut draft = output.draft()?;
        write_one(args, exchange, *format, &mut draft).map_err(|e| output.error(e))?;
        drafts.push(draft);
        names.push(output.path().display().to_string());
    }
    commit(drafts, session.progress())?;
    let words = names.join(", ");
    report.fact("output", names, "wrote", words);
    Ok(())
}

fn write_one(
    args: &ExchangeArgs,
    exchange: &Exchange,
    format: ExchangeFormat,
    out: &mut dyn Write,
) -> io::Result<()> {
    match format {
        ExchangeFormat::Archive => arrays::write(exchange, out),
        ExchangeFormat::Vtu => {
            let options = FileOptions {
                arrays: arrays::of_rows(exchange),
                ..FileOptions::default()
            };
            let written = azulejo_exchange::files::write(
                &exchange.enclosure,
                FactorFormat::Vtu,
                &options,
                out,
            );
            written.map(|_| ()).map_err(io::Error::other)
        }
        ExchangeFormat::Csv if exchange.heat.is_some() => lists::write_heat(exchange, out),
        format => lists::write_conductances(args, exchange, format, out),
    }
}
