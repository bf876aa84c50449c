//! What is written down of every task, and read again.

use serde::{Deserialize, Serialize};

/// One line of the journal.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TaskRecord {
    /// Key of the task that this belongs to; a task may have several records.
    pub key: String,
    /// The azulejo that did it.
    pub version: String,
    /// What the task produced.
    #[serde(rename = "found")]
    pub outcome: Outcome,
}

/// What a task found.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// A matrix to compare with.
    Reference(RunRecord),
    /// A matrix.
    Run(RunRecord),
    /// One answer of an engine whose truth is known.
    Truth(TruthRecord),
    /// The task came to nothing, for this reason.
    Failure {
        /// The task, for people.
        task: String,
        /// Why.
        reason: String,
    },
}

/// One computation of form factors.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct RunRecord {
    /// Name of the scene.
    pub scene: String,
    /// Mirrors, where the suite chose how many.
    pub mirrors: Option<usize>,
    /// Name of the engine in the report.
    pub engine: String,
    /// Its settings, in words.
    pub setting: String,
    /// Seed of the random numbers.
    pub seed: u64,
    /// The engine that really ran.
    pub ran: String,
    /// What did the work.
    pub device: String,
    /// Why this engine, and what was not done as asked.
    pub notes: Vec<String>,
    /// Rows of the matrix.
    pub facets: usize,
    /// Entries of the matrix.
    pub entries: u64,
    /// Rays or pixels per row.
    pub samples: f64,
    /// Seconds on the wall for all form factors, from the scene in memory.
    pub seconds: f64,
    /// The same of all processors together.
    pub cpu_seconds: f64,
    /// Seconds on the wall for solving B = M + ρXB.
    pub solve_seconds: f64,
    /// Most memory of the process when the form factors were done.
    pub peak_bytes: Option<u64>,
    /// Mean relative row error, Σ|X − R|/ΣR.
    pub row_error_mean: Option<f64>,
    /// The largest.
    pub row_error_max: Option<f64>,
    /// Mean relative row error that the engine itself expects.
    pub row_error_stated: f64,
    /// Mean relative error of B.
    pub b_error_mean: Option<f64>,
    /// The largest.
    pub b_error_max: Option<f64>,
    /// Root of the mean square of what rows lack of 1.
    pub closure_rms: f64,
    /// The most that a row lacks.
    pub closure_max: f64,
    /// Share of the matrix that was moved to make rows add up.
    pub moved: f64,
    /// Largest difference of A_i X_ij and A_j X_ji, relative to the mean entry.
    pub reciprocity: f64,
    /// Power that is not accounted for, relative.
    pub energy: Option<f64>,
}

/// One answer of an engine whose truth is known.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct TruthRecord {
    /// Name of the engine in the report.
    pub engine: String,
    /// Its settings, in words.
    pub setting: String,
    /// The engine that really ran.
    pub ran: String,
    /// Name of the case.
    pub case: String,
    /// What it is.
    pub words: String,
    /// Where its truth comes from.
    pub source: String,
    /// What makes it difficult.
    pub kind: String,
    /// The engine's answer.
    pub value: f64,
    /// The truth.
    pub truth: f64,
    /// What the truth leaves open.
    pub truth_error: f64,
    /// The engine's standard error.
    pub standard_error: f64,
    /// How many of them the answer is off; `None` where an answer without error is wrong.
    pub standard_errors: Option<f64>,
    /// Seconds on the wall.
    pub seconds: f64,
}
