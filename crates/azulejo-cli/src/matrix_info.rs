//! `info` of form factors in an `.npz`.

use super::failure::Failure;
use super::form_factors::{compress, stored, summary};
use super::info::InfoArgs;
use super::report::{Report, count, number, percent, short};
use super::session::Session;
use azulejo_exchange::archive::StoredFactors;
use azulejo_exchange::{Enclosure, GroupBy};
use serde_json::json;
use std::path::Path;

/// Objects listed in the text; the JSON has all of them.
const LISTED: usize = 20;

/// Runs `info` if its input is a single archive; otherwise `None`.
pub fn run(args: &InfoArgs, session: &mut Session) -> Result<Option<Report>, Failure> {
    let [path] = &args.input.scenes[..] else {
        return Ok(None);
    };
    if !stored::is_archive(path) {
        return Ok(None);
    }
    if args.output.is_some() {
        return Err(Failure::misuse(
            "--output: form factors have no luminaire to plot",
        ));
    }
    let read = stored::read_whole(path, None, session)?;
    let mut report = Report::default();
    match &read {
        StoredFactors::Whole(read) => {
            let bits = if read.is_single { 32 } else { 64 };
            let what = "form factors as NumPy archive (.npz)";
            archive(path, what, bits, &read.arrays, &mut report);
            report.value("asymmetry", number(read.asymmetry));
            engine(&read.enclosure, &mut report);
            summary::describe(&read.enclosure, &mut report);
        }
        StoredFactors::Blocks(read) => {
            let what = "form factors in blocks between clusters, as NumPy archive (.npz)";
            archive(path, what, 32, &read.arrays, &mut report);
            engine(&read.enclosure, &mut report);
            compress::describe(read, &mut report);
        }
    }
    let enclosure = read.into_enclosure();
    rows(&enclosure, &mut report);
    if !enclosure.rows.are_groups {
        objects(&enclosure, &mut report);
    }
    Ok(Some(report))
}

/// The file and its arrays.
fn archive(path: &Path, what: &str, bits: u32, arrays: &[String], report: &mut Report) {
    let name = path.display().to_string();
    report.fact("file", name.clone(), "file", name);
    report.fact("format", "npz", "format", what);
    let words = format!("{bits} bits for factors: {}", arrays.join(", "));
    report.line("arrays", words);
    report.value("arrays", arrays.to_vec());
    report.value("bits", bits);
}

fn engine(enclosure: &Enclosure, report: &mut Report) {
    let engine = &enclosure.factors.engine_used.name;
    if !engine.is_empty() {
        report.fact("engine", engine.clone(), "engine", engine.clone());
    }
}

/// Area, unit, geometry and mirrors of the rows.
fn rows(enclosure: &Enclosure, report: &mut Report) {
    let factors = &enclosure.factors;
    let area: f64 = factors.areas.iter().sum();
    let words = match enclosure.rows.metres_per_unit {
        Some(unit) => format!("{} m²", short(area * unit * unit)),
        None => format!("{} square units (unknown; taken as metres)", short(area)),
    };
    report.fact("area", number(area), "area", words);
    let unit = enclosure.rows.metres_per_unit;
    report.value("metres_per_unit", unit.map(number));
    let backs = factors.is_back.iter().filter(|b| **b).count();
    report.value("backs", backs);
    if backs > 0 {
        report.line("backs", format!("{} of the rows", count(backs)));
    }
    let mirrors = factors.ends.iter().filter(|e| **e < 1.0).count();
    report.value("mirrors", mirrors);
    if mirrors > 0 {
        let most = factors.ends.iter().copied().fold(1.0, f64::min);
        let words = format!(
            "{} rows reflect specularly, up to {}",
            count(mirrors),
            percent(1.0 - most)
        );
        report.line("mirrors", words);
    }
    let cells = &enclosure.rows.cells;
    let words = if cells.is_empty() {
        "none: not an archive of azulejo, or an early one".to_owned()
    } else {
        format!("{} corners of polygons", count(cells.corners.len()))
    };
    report.fact("geometry", !cells.is_empty(), "geometry", words);
}

/// A line for each object: rows and area.
fn objects(enclosure: &Enclosure, report: &mut Report) {
    let groups = enclosure.groups(GroupBy::Object);
    let mut totals = vec![(0usize, 0.0); groups.names.len()];
    for (group, area) in groups.of_rows.iter().zip(&enclosure.factors.areas) {
        if let Some(total) = group.and_then(|g| totals.get_mut(g as usize)) {
            total.0 += 1;
            total.1 += area;
        }
    }
    let named = || groups.names.iter().zip(&totals);
    let list = named()
        .map(|(name, (rows, area))| json!({ "name": name, "rows": rows, "area": number(*area) }));
    report.value("objects", list.collect::<Vec<_>>());
    let width = groups.names.iter().map(|n| n.chars().count()).max();
    let width = width.unwrap_or(0).clamp(6, 32);
    report.plain("");
    report.plain(format!(
        "{:<width$}  {:>8}  {:>10}",
        "object", "rows", "area"
    ));
    for (name, (rows, area)) in named().take(LISTED) {
        let (rows, area) = (count(*rows), short(*area));
        report.plain(format!("{name:<width$}  {rows:>8}  {area:>10}"));
    }
    if groups.names.len() > LISTED {
        let more = count(groups.names.len() - LISTED);
        report.plain(format!("and {more} more"));
    }
}
