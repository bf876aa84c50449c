//! Numbers in rows: CSV, and the mean over repetitions.

use super::super::record::{RunRecord, TaskOutcome, TaskRecord, TruthRecord};
use crate::report::csv_cell;
use serde::Serialize;
use serde_json::Value;
use std::fmt::Write;

/// The columns of the CSV of runs before the last: fields of [`RunRecord`].
const RUN_COLUMNS: &str = "scene,mirrors,engine,setting,seed,ran,device,facets,entries,samples,seconds,\
     cpu_seconds,solve_seconds,peak_bytes,row_error_mean,row_error_max,row_error_stated,b_error_mean,b_error_max,\
     closure_rms,closure_max,moved,reciprocity,energy,notes";

/// The columns of the CSV of answers: fields of [`TruthRecord`].
const TRUTH_COLUMNS: &str = "engine,setting,ran,case,words,source,kind,value,truth,truth_error,standard_error,\
     standard_errors,seconds";

/// The text of a field.
fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Array(list) => list.iter().map(cell).collect::<Vec<_>>().join("; "),
        Value::Number(n) if n.is_f64() => n.as_f64().unwrap_or_default().to_string(),
        other => other.to_string(),
    }
}

/// The texts of some fields of a record.
fn cells(record: &impl Serialize, columns: &str) -> Vec<String> {
    let fields = serde_json::to_value(record).unwrap_or_default();
    columns.split(',').map(|name| cell(&fields[name])).collect()
}

/// All runs and references.
pub fn runs_csv(records: &[&TaskRecord]) -> String {
    let mut text = format!("{RUN_COLUMNS},role\n");
    for record in records {
        let (run, role) = match &record.outcome {
            TaskOutcome::Run(run) => (run, "run"),
            TaskOutcome::Reference(run) => (run, "reference"),
            _ => continue,
        };
        let cells = cells(run, RUN_COLUMNS).into_iter();
        text += &line(cells.chain([role.to_owned()]));
    }
    text
}

/// All answers of engines.
pub fn truths_csv(records: &[&TaskRecord]) -> String {
    let mut text = format!("{TRUTH_COLUMNS}\n");
    for truth in truths(records) {
        text += &line(cells(truth, TRUTH_COLUMNS).into_iter());
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

fn line(cells: impl Iterator<Item = String>) -> String {
    let cells: Vec<String> = cells.map(|c| csv_cell(&c).into_owned()).collect();
    cells.join(",") + "\n"
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
