//! What came out of all poses: tables on the terminal, and files.

use super::changes::CHANGES;
use super::commands::commands;
use super::compare::Comparison;
use std::fmt;

/// The result of one pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoseOutcome {
    /// The same within the errors.
    Right,
    /// Something else, or an error.
    Off,
    /// A run did not end within its time.
    Unfinished,
}

/// One scene, command and combination of changes, and what came out.
#[derive(Clone, Debug)]
pub struct PoseRecord {
    /// What names it, to run it alone.
    pub key: String,
    /// Name of the scene.
    pub scene: String,
    /// Name of the command.
    pub command: String,
    /// Names of the changes.
    pub changes: Vec<&'static str>,
    /// The changes with their parameters.
    pub words: String,
    /// The result.
    pub outcome: PoseOutcome,
    /// What is wrong.
    pub problem: String,
    /// Numbers that were compared, and those beyond their bounds.
    pub quantities: usize,
    /// Numbers beyond their bounds.
    pub off: usize,
    /// The largest difference over its bound.
    pub nearness: Option<f64>,
    /// What the changes may alter, relative to the size of quantities.
    pub slack: f64,
    /// Wall-clock time of the two runs, s.
    pub seconds: f64,
}

/// Counts of outcomes.
#[derive(Clone, Copy, Debug, Default)]
pub struct PoseCounts {
    /// All.
    pub run: usize,
    /// The same within the errors.
    pub right: usize,
    /// Something else.
    pub off: usize,
    /// Without end.
    pub unfinished: usize,
}

impl PoseRecord {
    /// Takes over a comparison.
    pub fn judge(&mut self, comparison: &Comparison) {
        self.quantities = comparison.quantities;
        self.off = comparison.off;
        let Some(worst) = &comparison.worst else {
            return;
        };
        let difference = (worst.expected - worst.found).abs();
        self.nearness = Some(difference / worst.bound.max(f64::MIN_POSITIVE));
        if comparison.off > 0 {
            self.outcome = PoseOutcome::Off;
            self.problem = format!(
                "{} of {} quantities; {}: {:.5e} in the original, {:.5e} in the pose, ± {:.1e}",
                comparison.off,
                comparison.quantities,
                worst.name,
                worst.expected,
                worst.found,
                worst.bound
            );
        }
    }

    /// A line of the table as CSV.
    pub fn csv_line(&self) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let outcome = format!("{:?}", self.outcome).to_lowercase();
        format!(
            "{},{},{},{},{},{outcome},{},{},{},{:e},{:.2},{}\n",
            quoted(&self.key),
            quoted(&self.scene),
            self.command,
            self.changes.join("+"),
            quoted(&self.words),
            self.quantities,
            self.off,
            self.nearness
                .map_or_else(String::new, |n| format!("{n:.3}")),
            self.slack,
            self.seconds,
            quoted(&self.problem)
        )
    }
}

impl PoseCounts {
    /// Counts some records.
    pub fn of<'a>(records: impl IntoIterator<Item = &'a PoseRecord>) -> PoseCounts {
        let mut counts = PoseCounts::default();
        for record in records {
            counts.run += 1;
            match record.outcome {
                PoseOutcome::Right => counts.right += 1,
                PoseOutcome::Off => counts.off += 1,
                PoseOutcome::Unfinished => counts.unfinished += 1,
            }
        }
        counts
    }

    /// Those that are not right.
    pub fn failures(&self) -> usize {
        self.off + self.unfinished
    }
}

impl fmt::Display for PoseCounts {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let PoseCounts {
            run,
            right,
            off,
            unfinished,
        } = self;
        write!(f, "{run:>6} {right:>6} {off:>6} {unfinished:>11}")
    }
}

/// First line of a table of records as CSV.
pub fn csv_heading() -> &'static str {
    "pose,scene,command,changes,details,outcome,quantities,off,nearness,slack,seconds,problem\n"
}

/// Counts by change and by command, in aligned columns.
pub fn tables(records: &[PoseRecord]) -> Vec<String> {
    let change_counts = |name: &'static str| {
        let own = records.iter().filter(move |r| r.changes.contains(&name));
        (name.to_owned(), PoseCounts::of(own))
    };
    let command_counts = |name: String| {
        let own = records.iter().filter(|r| r.command == name);
        (name.clone(), PoseCounts::of(own))
    };
    let mut lines = table("change", CHANGES.iter().map(|c| change_counts(c.name)));
    lines.push(String::new());
    lines.extend(table(
        "command",
        commands().into_iter().map(|c| command_counts(c.name)),
    ));
    lines
}

fn table(heading: &str, rows: impl Iterator<Item = (String, PoseCounts)>) -> Vec<String> {
    const WIDTH: usize = 40;
    let head = format!(
        "{heading:<WIDTH$} {:>6} {:>6} {:>6} {:>11}",
        "run", "right", "off", "unfinished"
    );
    let rows = rows.filter(|(_, counts)| counts.run > 0);
    let rows = rows.map(|(name, counts)| format!("{name:<WIDTH$} {counts}"));
    [head].into_iter().chain(rows).collect()
}
