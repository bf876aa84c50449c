//! The report: a self-contained page, plots as separate files, and the numbers as CSV and JSON.

mod figures;
mod page;
mod tables;

use super::record::{TaskOutcome, TaskRecord};
use super::suite::Suite;
use crate::charts::write_report;
use crate::failure::Failure;
use crate::machine_info::MachineInfo;
use azulejo_trace::Progress;
use std::path::Path;

/// File name of the page.
pub const PAGE: &str = "report.html";

/// Writes the report, replacing an existing one atomically.
pub fn write(
    suite: &Suite,
    machine: &MachineInfo,
    records: &[&TaskRecord],
    folder: &Path,
    progress: &Progress,
) -> Result<(), Failure> {
    let figures = figures::of(records);
    let page = page::Page {
        suite,
        machine,
        records,
        figures: &figures,
    };
    let mut files = vec![
        ("results.csv".to_owned(), tables::runs_csv(records)),
        ("results.json".to_owned(), json(suite, machine, records)),
        (PAGE.to_owned(), page.html()),
    ];
    if records
        .iter()
        .any(|r| matches!(r.outcome, TaskOutcome::Truth(_)))
    {
        files.push(("truths.csv".to_owned(), tables::truths_csv(records)));
    }
    write_report(folder, files, &figures, progress)
}

fn json(suite: &Suite, machine: &MachineInfo, records: &[&TaskRecord]) -> String {
    let value = serde_json::json!({
        "title": suite.title,
        "about": suite.about,
        "machine": machine.json(),
        "results": records,
    });
    format!("{value:#}\n")
}
