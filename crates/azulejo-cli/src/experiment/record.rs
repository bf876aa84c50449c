//! The results of tasks as they are stored in the results.

use serde::{Deserialize, Serialize};

/// One line of the results.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TaskRecord {
    /// Key of the task that this belongs to; a task may have several records.
    pub key: String,
    /// The azulejo that did it.
    pub version: String,
    /// What the task produced.
    #[serde(rename = "found")]
    pub outcome: TaskOutcome,
}

/// The result of a task.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskOutcome {
    /// The matrix of a reference.
    Reference(RunRecord),
    /// The matrix of a run.
    Run(RunRecord),
    /// The solution of one case whose exact solution is known.
    Truth(TruthRecord),
    /// The engine is optional, and not available.
    Skipped {
        /// Name of the task.
        task: String,
        /// What is missing.
        reason: String,
    },
    /// The task failed.
    Failure {
        /// Name of the task.
        task: String,
        /// Reason of the failure.
        reason: String,
    },
}

/// One computation of form factors.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct RunRecord {
    /// Name of the scene.
    pub scene: String,
    /// Number of mirrors, if the suite specifies it.
    pub mirrors: Option<usize>,
    /// Name of the engine in the report.
    pub engine: String,
    /// Its settings as text.
    pub setting: String,
    /// Rays per row, if the suite specifies them.
    #[serde(default)]
    pub rays: Option<u32>,
    /// Pixels along the side of a hemicube, if the suite specifies them.
    #[serde(default)]
    pub resolution: Option<u32>,
    /// Hemicubes per patch, if the suite specifies them.
    #[serde(default)]
    pub patch_points: Option<u32>,
    /// Seed of the random numbers.
    pub seed: u64,
    /// The engine that was used.
    pub ran: String,
    /// The device that was used.
    pub device: String,
    /// Why this engine was used, and deviations from what was requested.
    pub notes: Vec<String>,
    /// Rows of the matrix.
    pub facets: usize,
    /// Entries of the matrix.
    pub entries: u64,
    /// Rays or pixels per row.
    pub samples: f64,
    /// Wall-clock time for all form factors, from the scene in memory, seconds.
    pub seconds: f64,
    /// The same in CPU time of all threads.
    pub cpu_seconds: f64,
    /// Wall-clock time for solving B = M + ρXB, seconds.
    pub solve_seconds: f64,
    /// Peak memory of the process when the form factors were done, bytes.
    pub peak_bytes: Option<u64>,
    /// Mean relative row error, Σ|X − R|/ΣR.
    pub row_error_mean: Option<f64>,
    /// The largest.
    pub row_error_max: Option<f64>,
    /// Mean relative row error, as estimated by the engine; `None` if it does not know.
    pub row_error_stated: Option<f64>,
    /// Mean relative error of B.
    pub b_error_mean: Option<f64>,
    /// The largest.
    pub b_error_max: Option<f64>,
    /// Root mean square of the deviation of row sums from 1.
    pub closure_rms: f64,
    /// The largest deviation.
    pub closure_max: f64,
    /// Share of the matrix that was moved to enforce closure.
    pub moved: f64,
    /// Largest difference of A_i X_ij and A_j X_ji, relative to the mean entry.
    pub reciprocity: f64,
    /// Unaccounted power, relative.
    pub energy: Option<f64>,
}

/// The solution of one case whose exact solution is known.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct TruthRecord {
    /// Name of the engine in the report.
    pub engine: String,
    /// Its settings as text.
    pub setting: String,
    /// The engine that was used.
    pub ran: String,
    /// Name of the case.
    pub case: String,
    /// Description of the case.
    pub words: String,
    /// Source of the exact solution.
    pub source: String,
    /// The difficulty that it tests.
    pub kind: String,
    /// The engine's solution.
    pub value: f64,
    /// The exact solution.
    pub truth: f64,
    /// Uncertainty of the exact solution.
    pub truth_error: f64,
    /// The engine's standard error; `None` if it does not know.
    pub standard_error: Option<f64>,
    /// The error in standard errors; `None` if the standard error is unknown, or zero where the
    /// error is not.
    pub standard_errors: Option<f64>,
    /// Wall-clock time, seconds.
    pub seconds: f64,
}
