//! `grf lint`: what should be mended.

use super::super::failure::Failure;
use super::super::report::{Report, count};
use super::args::LintArgs;
use azulejo::models::read_bytes;
use azulejo_formats::grf::{LintFinding, lint};
use azulejo_formats::{Folder, Position};
use serde_json::{Value, json};

/// Runs `grf lint`; the second result is the end of the command after its report.
pub fn run(args: &LintArgs) -> Result<(Report, Result<(), Failure>), Failure> {
    let mut findings = Vec::new();
    for path in &args.files {
        let bytes = read_bytes(path)?;
        let own = Folder::of_model(path);
        let files = (args.allow.iter()).fold(own, |folder, more| folder.allow(more));
        findings.extend(lint(&bytes, &path.to_string_lossy(), &files));
    }
    findings.retain(|f| !args.skip.iter().any(|rule| rule == f.rule));
    let mut report = Report::default();
    for finding in &findings {
        report.plain(finding.to_string());
    }
    let values: Vec<Value> = findings.iter().map(value).collect();
    report.value("findings", values);
    if findings.is_empty() {
        return Ok((report, Ok(())));
    }
    let total: usize = findings.iter().map(|f| f.count).sum();
    let s = if total == 1 { "" } else { "s" };
    report.plain(format!("{} finding{s}", count(total)));
    Ok((report, Err(Failure::Found)))
}

fn value(finding: &LintFinding) -> Value {
    let (line, column) = match finding.position {
        Position::Line(line, column) => (Some(line), Some(column)),
        _ => (None, None),
    };
    json!({
        "file": finding.file,
        "line": line,
        "column": column,
        "rule": finding.rule,
        "message": finding.message,
        "count": finding.count,
    })
}
