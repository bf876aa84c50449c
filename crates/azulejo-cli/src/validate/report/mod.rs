//! The report: a self-contained page, plots as separate files, and the numbers as CSV and JSON.

mod page;
mod plots;

use super::ValidationResults;
use super::args::ValidateArgs;
use super::engines::CheckedEngines;
use super::record::CheckRecord;
use crate::charts::write_report;
use crate::failure::Failure;
use crate::machine_info::MachineInfo;
use crate::report::csv_cell;
use azulejo_trace::Progress;

/// File name of the page.
pub const PAGE: &str = "index.html";

/// Writes the report, replacing an existing one atomically.
pub fn write(
    args: &ValidateArgs,
    results: &ValidationResults,
    engines: &CheckedEngines,
    machine: &MachineInfo,
    progress: &Progress,
) -> Result<(), Failure> {
    let figures = plots::of(results);
    let page = page::ValidationPage {
        args,
        results,
        engines,
        machine,
        figures: &figures,
    };
    let files = vec![
        ("results.csv".to_owned(), csv(&results.records)),
        ("results.json".to_owned(), json(args, results, machine)),
        (PAGE.to_owned(), page.html()),
    ];
    write_report(&args.output, files, &figures, progress)
}

fn json(args: &ValidateArgs, results: &ValidationResults, machine: &MachineInfo) -> String {
    let value = serde_json::json!({
        "machine": machine.json(),
        "quick": !args.full,
        "seed": args.seed,
        "seconds": results.seconds,
        "checks": results.records,
        "peers": results.peers,
    });
    format!("{value:#}\n")
}

/// A column: heading and value.
type CsvColumn = (&'static str, fn(&CheckRecord) -> String);

const COLUMNS: [CsvColumn; 14] = [
    ("part", |r| r.part.to_string()),
    ("engine", |r| r.engine.clone()),
    ("subject", |r| r.subject.clone()),
    ("description", |r| r.description.clone()),
    ("source", |r| r.source.clone()),
    ("unit", |r| r.unit.to_owned()),
    ("found", |r| r.found.to_string()),
    ("expected", |r| r.expected.to_string()),
    ("expected_error", |r| r.expected_error.to_string()),
    ("standard_error", |r| {
        r.standard_error.map_or(String::new(), |e| e.to_string())
    }),
    ("bound", |r| r.bound.to_string()),
    ("outcome", |r| format!("{:?}", r.outcome).to_lowercase()),
    ("note", |r| r.note.clone()),
    ("seconds", |r| format!("{:.4}", r.seconds)),
];

fn csv(records: &[CheckRecord]) -> String {
    let head = COLUMNS.map(|c| c.0).join(",");
    let row = |r: &CheckRecord| {
        COLUMNS
            .map(|(_, of)| csv_cell(&of(r)).into_owned())
            .join(",")
    };
    let lines = std::iter::once(head).chain(records.iter().map(row));
    lines.map(|line| line + "\n").collect()
}
