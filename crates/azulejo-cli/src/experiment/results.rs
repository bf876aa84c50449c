//! The results so far, in the report's folder: one line of JSON for each record, appended when its
//! task is done and read by the next run.

use super::record::{TaskOutcome, TaskRecord};
use crate::failure::Failure;
use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The name of the file.
const NAME: &str = "results.jsonl";

/// The results so far.
#[derive(Debug)]
pub struct StoredResults {
    path: PathBuf,
    file: File,
    /// The records, in order.
    pub records: Vec<TaskRecord>,
    /// Their keys.
    keys: HashSet<String>,
}

impl StoredResults {
    /// Opens or creates the results of a folder. Records of other versions, truncated lines,
    /// failures and what was skipped are ignored: their tasks are repeated.
    pub fn open(folder: &Path) -> Result<StoredResults, Failure> {
        let path = folder.join(NAME);
        let failed = |e| Failure::file("write", &path, &e);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(e) => return Err(failed(e)),
        };
        let records: Vec<TaskRecord> = text.lines().filter_map(record).collect();
        let mut file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&path)
            .map_err(failed)?;
        if !text.is_empty() && !text.ends_with('\n') {
            writeln!(file).map_err(failed)?;
        }
        Ok(StoredResults {
            keys: records.iter().map(|r| r.key.clone()).collect(),
            path,
            file,
            records,
        })
    }

    /// Whether a task is done.
    pub fn holds(&self, key: &str) -> bool {
        self.keys.contains(key)
    }

    /// Appends the records of a task.
    pub fn add(&mut self, records: Vec<TaskRecord>) -> Result<(), Failure> {
        let mut lines = String::new();
        for record in &records {
            lines += &serde_json::to_string(record).map_err(Failure::failed)?;
            lines.push('\n');
        }
        let written = self.file.write_all(lines.as_bytes());
        let written = written.and_then(|()| self.file.sync_data());
        written.map_err(|e| Failure::file("write", &self.path, &e))?;
        self.keys.extend(records.iter().map(|r| r.key.clone()));
        self.records.extend(records);
        Ok(())
    }
}

fn record(line: &str) -> Option<TaskRecord> {
    let record: TaskRecord = serde_json::from_str(line).ok()?;
    let is_ours = record.version == env!("CARGO_PKG_VERSION");
    let is_done = !matches!(
        record.outcome,
        TaskOutcome::Failure { .. } | TaskOutcome::Skipped { .. }
    );
    (is_ours && is_done).then_some(record)
}

#[cfg(test)]
mod tests {
    use super::super::record::RunRecord;
    use super::*;

    fn found(key: &str, outcome: TaskOutcome) -> TaskRecord {
        TaskRecord {
            key: key.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            outcome,
        }
    }

    #[test]
    fn what_is_done_stays_done() {
        let folder = std::env::temp_dir().join(format!("azulejo-results-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let run = RunRecord {
            seconds: 0.1 + 0.2,
            energy: None,
            ..RunRecord::default()
        };
        let failure = TaskOutcome::Failure {
            task: "b".into(),
            reason: "no".into(),
        };
        let mut results = StoredResults::open(&folder).unwrap();
        results
            .add(vec![found("a", TaskOutcome::Run(run))])
            .unwrap();
        results.add(vec![found("b", failure)]).unwrap();
        let kept = results.records[..1].to_vec();
        drop(results);
        // A line truncated by a crash affects neither the lines before nor those after.
        let path = folder.join(NAME);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text + "{\"key\":\"c\",\"vers").unwrap();
        let mut results = StoredResults::open(&folder).unwrap();
        assert_eq!(results.records, kept);
        assert!(results.holds("a") && !results.holds("b") && !results.holds("c"));
        results
            .add(vec![TaskRecord {
                key: "d".into(),
                ..kept[0].clone()
            }])
            .unwrap();
        assert!(StoredResults::open(&folder).unwrap().holds("d"));
        std::fs::remove_dir_all(folder).unwrap();
    }
}
