//! Numbers in rows: CSV, and the mean over repetitions.

use super::super::record::{RunRecord, TaskOutcome, TaskRecord, TruthRecord};
use std::fmt::Write;

/// One column of the CSV of runs.
type Column<T> = (&'static str, fn(&T) -> String);

const RUN_COLUMNS: [Column<RunRecord>; 26] = [
    ("scene", |r| r.scene.clone()),
    ("mirrors", |r| {
        r.mirrors.map_or(String::new(), |m| m.to_string())
    }),
    ("engine", |r| r.engine.clone()),
    ("setting", |r| r.setting.clone()),
    ("seed", |r| r.seed.to_string()),
    ("ran", |r| r.ran.clone()),
    ("device", |r| r.device.clone()),
    ("facets", |r| r.facets.to_string()),
    ("entries", |r| r.entries.to_string()),
    ("samples", |r| r.samples.to_string()),
    ("seconds", |r| r.seconds.to_string()),
    ("cpu_seconds", |r| r.cpu_seconds.to_string()),
    ("solve_seconds", |r| r.solve_seconds.to_string()),
    ("peak_bytes", |r| {
        r.peak_bytes.map_or(String::new(), |b| b.to_string())
    }),
    ("row_error_mean", |r| optional(r.row_error_mean)),
    ("row_error_max", |r| optional(r.row_error_max)),
    ("row_error_stated", |r| optional(r.row_error_stated)),
    ("b_error_mean", |r| optional(r.b_error_mean)),
    ("b_error_max", |r| optional(r.b_error_max)),
    ("closure_rms", |r| r.closure_rms.to_string()),
    ("closure_max", |r| r.closure_max.to_string()),
    ("moved", |r| r.moved.to_string()),
    ("reciprocity", |r| r.reciprocity.to_string()),
    ("energy", |r| optional(r.energy)),
    ("notes", |r| r.notes.join("; ")),
    ("role", |_| String::new()),
];

const TRUTH_COLUMNS: [Column<TruthRecord>; 13] = [
    ("engine", |t| t.engine.clone()),
    ("setting", |t| t.setting.clone()),
    ("ran", |t| t.ran.clone()),
    ("case", |t| t.case.clone()),
    ("words", |t| t.words.clone()),
    ("source", |t| t.source.clone()),
    ("kind", |t| t.kind.clone()),
    ("value", |t| t.value.to_string()),
    ("truth", |t| t.truth.to_string()),
    ("truth_error", |t| t.truth_error.to_string()),
    ("standard_error", |t| optional(t.standard_error)),
    ("standard_errors", |t| optional(t.standard_errors)),
    ("seconds", |t| t.seconds.to_string()),
];

fn optional(x: Option<f64>) -> String {
    x.map_or(String::new(), |x| x.to_string())
}

/// All runs and references.
pub fn runs_csv(records: &[&TaskRecord]) -> String {
    let last = RUN_COLUMNS.len() - 1;
    let mut text = header(RUN_COLUMNS.iter().map(|c| c.0));
    for record in records {
        let (run, role) = match &record.outcome {
            TaskOutcome::Run(run) => (run, "run"),
            TaskOutcome::Reference(run) => (run, "reference"),
            _ => continue,
        };
        let cells = RUN_COLUMNS[..last].iter().map(|c| (c.1)(run));
        text += &line(cells.chain([role.to_owned()]));
    }
    text
}

/// All answers of engines.
pub fn truths_csv(records: &[&TaskRecord]) -> String {
    let mut text = header(TRUTH_COLUMNS.iter().map(|c| c.0));
    for truth in truths(records) {
        text += &line(TRUTH_COLUMNS.iter().map(|c| (c.1)(truth)));
    }
    text
}

/// The answers among the records.
pub fn truths<'a>(records: &[&'a TaskRecord]) -> Vec<&'a TruthRecord> {
    let truth = |r: &&'a TaskRecord| match &r.outcome {
        TaskOutcome::Truth(truth) => Some(truth),
        _ => None,
    };
    records.iter().filter_map(truth).collect()
}

fn header<'a>(names: impl Iterator<Item = &'a str>) -> String {
    line(names.map(str::to_owned))
}

fn line(cells: impl Iterator<Item = String>) -> String {
    let mut text = cells.map(|c| quoted(&c)).collect::<Vec<_>>().join(",");
    text.push('\n');
    text
}

/// RFC 4180: quotation marks around what holds commas, quotes or ends of lines.
fn quoted(cell: &str) -> String {
    if !cell.contains([',', '"', '\n', '\r']) {
        return cell.to_owned();
    }
    format!("\"{}\"", cell.replace('"', "\"\""))
}

/// Repetitions of one setting on one scene.
pub struct RepeatedRun<'a> {
    /// The first of them.
    pub run: &'a RunRecord,
    /// Whether it is the reference.
    pub is_reference: bool,
    /// All of them.
    all: Vec<&'a RunRecord>,
}

/// Runs that differ in their seed alone are one row.
pub fn repeated<'a>(records: &[&'a TaskRecord]) -> Vec<RepeatedRun<'a>> {
    let mut rows: Vec<RepeatedRun> = Vec::new();
    for record in records {
        let (run, is_reference) = match &record.outcome {
            TaskOutcome::Run(run) => (run, false),
            TaskOutcome::Reference(run) => (run, true),
            _ => continue,
        };
        let same = |row: &&mut RepeatedRun| {
            let [a, b] = [row.run, run].map(|r| (&r.scene, &r.engine, &r.setting));
            a == b && row.is_reference == is_reference
        };
        match rows.iter_mut().find(same) {
            Some(row) => row.all.push(run),
            None => rows.push(RepeatedRun {
                run,
                is_reference,
                all: vec![run],
            }),
        }
    }
    rows
}

impl RepeatedRun<'_> {
    /// Mean of a measure; `None` if no run has it.
    pub fn mean(&self, measure: impl Fn(&RunRecord) -> Option<f64>) -> Option<f64> {
        let values: Vec<f64> = self.all.iter().filter_map(|r| measure(r)).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    }

    /// Standard deviation of a measure between repetitions; `None` for fewer than two.
    pub fn deviation(&self, measure: impl Fn(&RunRecord) -> Option<f64>) -> Option<f64> {
        let mean = self.mean(&measure)?;
        let values: Vec<f64> = self.all.iter().filter_map(|r| measure(r)).collect();
        let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.all.len()
    }
}

/// A number for people: three digits.
pub fn short(x: f64) -> String {
    let mut text = String::new();
    let written = match x.abs() {
        0.0 => write!(text, "0"),
        m if (1e-3..1e5).contains(&m) => {
            let decimals = (2 - m.log10().floor() as i32).clamp(0, 5) as usize;
            write!(text, "{x:.decimals$}")
        }
        _ => write!(text, "{x:.1e}"),
    };
    // Writing to a string does not fail.
    written.map_or(String::new(), |()| text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(scene: &str, seed: u64, seconds: f64) -> TaskRecord {
        TaskRecord {
            key: String::new(),
            version: String::new(),
            outcome: TaskOutcome::Run(RunRecord {
                scene: scene.into(),
                seed,
                seconds,
                ..RunRecord::default()
            }),
        }
    }

    #[test]
    fn repetitions_are_one_row() {
        let records = [
            record("a", 0, 1.0),
            record("b", 0, 5.0),
            record("a", 1, 3.0),
        ];
        let records: Vec<&TaskRecord> = records.iter().collect();
        let rows = repeated(&records);
        assert_eq!(rows.len(), 2);
        assert_eq!(
            (rows[0].count(), rows[0].mean(|r| Some(r.seconds))),
            (2, Some(2.0))
        );
        assert_eq!(rows[1].mean(|r| r.energy), None);
        // 1 and 3 are √2 apart from their mean in the sense of the sample's standard deviation.
        let deviation = rows[0].deviation(|r| Some(r.seconds));
        assert!(
            deviation.is_some_and(|d| (d - 2f64.sqrt()).abs() < 1e-12),
            "{deviation:?}"
        );
        assert_eq!(rows[1].deviation(|r| Some(r.seconds)), None);
    }

    #[test]
    fn cells_are_quoted_where_they_must() {
        let records = [record("a, \"b\"", 7, 1.5)];
        let csv = runs_csv(&records.iter().collect::<Vec<_>>());
        let lines: Vec<&str> = csv.lines().collect();
        assert!(lines[0].starts_with("scene,mirrors,engine") && lines[0].ends_with(",role"));
        assert!(lines[1].starts_with("\"a, \"\"b\"\"\",,") && lines[1].ends_with(",run"));
        assert_eq!(lines.len(), 2);
    }

    #[test]
    fn numbers_for_people() {
        for (x, want) in [
            (0.0, "0"),
            (12.345, "12.3"),
            (0.0123456, "0.0123"),
            (1.5e-7, "1.5e-7"),
            (123456.0, "1.2e5"),
        ] {
            assert_eq!(short(x), want);
        }
    }
}
