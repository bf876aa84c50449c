//! `experiment`: runs a suite of scenes and engines, each run in a process of its own, and writes
//! a report.
//!
//! Separate processes keep the times and the memory of runs apart: nothing that an earlier run left
//! in memory, in the allocator or in a driver is counted. The results of a run are stored
//! at once, so that an interrupted suite resumes where it was.
//!
//! | module | what it does |
//! |---|---|
//! | `suite` | the suite's file, and messages on errors in it |
//! | `plan` | tasks, with keys of all that their results depend on |
//! | `work` | one task, in the child process |
//! | `reference` | the reference data |
//! | `record`, `results` | results on disk |
//! | `report` | tables and plots |

pub mod args;
mod plan;
mod record;
mod reference;
mod report;
mod results;

mod suite;
mod work;

use super::child;
use super::failure::Failure;
use super::machine_info::MachineInfo;
use super::report::{Report, number, seconds};
use super::session::Session;
use args::ExperimentArgs;
use azulejo_trace::Progress;
use plan::{ExperimentPlan, Task};
use record::{TaskOutcome, TaskRecord};
use results::StoredResults;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};
use suite::{Suite, SuiteSource};

/// Parses the text of a suite; its models are not read.
///
/// # Errors
/// What is wrong, with line and column.
pub fn parse_suite(text: &str) -> Result<(), String> {
    let source = SuiteSource::new(Path::new("suite.toml"), text.to_owned());
    source.parse().map(drop).map_err(|e| e.to_string())
}

/// Runs `experiment`; a child has no report.
pub fn run(args: &ExperimentArgs, session: &mut Session) -> Result<Option<Report>, Failure> {
    let (suite, source) = SuiteSource::read(&args.suite)?;
    let mut plan = ExperimentPlan::new(&suite, &source)?;
    if let (Some(key), Some(folder)) = (&args.task, &args.output) {
        return one(&plan, key, folder, session.progress()).map(|()| None);
    }
    if args.quick {
        plan.quick();
    }
    if let Some(name) = &args.only {
        plan.only(name);
    }
    let folder = match &args.output {
        Some(folder) if !args.list => folder,
        _ => return Ok(Some(list(&plan))),
    };
    if plan.is_empty() {
        let name = args.only.as_deref().unwrap_or_default();
        let message = format_args!("no task has \"{name}\" in its name: see --list");
        return Err(Failure::misuse(message));
    }
    std::fs::create_dir_all(folder).map_err(|e| Failure::file("create", folder, &e))?;
    let mut results = StoredResults::open(folder)?;
    let runner = SuiteRunner {
        suite: &suite,
        plan: &plan,
        machine: MachineInfo::detect(),
        folder,
        name: &args.suite,
    };
    let did = session.with_progress(|progress| {
        runner.run_all(&mut results, progress, &|words| session.tell(words))
    })?;
    Ok(Some(runner.summary(&results, did)))
}

/// The tasks, for `--list`.
fn list(plan: &ExperimentPlan) -> Report {
    let mut report = Report::default();
    let lines = plan.lines();
    lines.iter().for_each(|line| report.plain(line.clone()));
    report.value("tasks", lines);
    report.value("task_count", plan.len());
    report
}

/// The child process: runs one task and prints its records.
fn one(
    plan: &ExperimentPlan,
    key: &str,
    folder: &Path,
    progress: &Progress,
) -> Result<(), Failure> {
    let task = plan.find(key);
    let task = task.ok_or_else(|| Failure::misuse(format_args!("no task \"{key}\"")))?;
    let reference = task.scene().and_then(|scene| plan.reference_of(scene));
    let records = work::run(&task, reference.as_ref(), folder, progress)?;
    let mut out = io::stdout().lock();
    for record in records {
        serde_json::to_writer(&mut out, &record).map_err(io::Error::from)?;
        writeln!(out)?;
    }
    Ok(out.flush()?)
}

/// Runs the tasks of a suite and writes its report.
struct SuiteRunner<'a> {
    suite: &'a Suite,
    plan: &'a ExperimentPlan,
    machine: MachineInfo,
    folder: &'a Path,
    name: &'a PathBuf,
}

/// Numbers of tasks by what became of them in this run.
#[derive(Clone, Copy, Default)]
struct TaskCounts {
    done: u64,
    skipped: u64,
    failed: u64,
}

impl SuiteRunner<'_> {
    /// Runs the tasks that are not in the results; the report is updated meanwhile.
    fn run_all(
        &self,
        results: &mut StoredResults,
        progress: &Progress,
        tell: &dyn Fn(&str),
    ) -> Result<TaskCounts, Failure> {
        let task_count = self.plan.len();
        let mut count = TaskCounts::default();
        let mut written: Option<Instant> = None;
        progress.begin("tasks", task_count);
        for (task, number) in self.plan.tasks().zip(1..) {
            progress.advance(0)?;
            if !results.holds(&task.key()) {
                let start = Instant::now();
                let records = self.run_one(&task, progress)?;
                let took = seconds(start.elapsed().as_secs_f64());
                let (counter, words) = match records.iter().find_map(obstacle) {
                    Some(TaskOutcome::Skipped { reason, .. }) => {
                        (&mut count.skipped, format!("skipped: {reason}"))
                    }
                    Some(TaskOutcome::Failure { reason, .. }) => {
                        (&mut count.failed, format!("failed: {reason}"))
                    }
                    _ => (&mut count.done, took),
                };
                *counter += 1;
                tell(&format!("[{number}/{task_count}] {task}: {words}"));
                results.add(records)?;
                if written.is_none_or(|at| at.elapsed() > UPDATE) {
                    self.write(results, progress)?;
                    written = Some(Instant::now());
                }
            }
            progress.advance(1)?;
        }
        self.write(results, progress)?;
        Ok(count)
    }

    /// Runs a task in a child process. Its failure is a record, too.
    fn run_one(&self, task: &Task, progress: &Progress) -> Result<Vec<TaskRecord>, Failure> {
        let key = task.key();
        let program = std::env::current_exe()
            .map_err(|e| Failure::failed(format_args!("cannot find this program: {e}")))?;
        let mut command = Command::new(program);
        command
            .arg("experiment")
            .arg(self.name)
            .arg("--output")
            .arg(self.folder)
            .args([
                "--task",
                &key,
                "--threads",
                &self.machine.threads.to_string(),
            ]);
        let limit = self.suite.run.timeout.map(|t| t.0);
        let failure = |reason: String| TaskRecord {
            key: key.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            outcome: TaskOutcome::Failure {
                task: task.to_string(),
                reason,
            },
        };
        match child::output(&mut command, limit, progress)? {
            Ok(text) => {
                let lines = text.lines().map(serde_json::from_str);
                let records: Result<Vec<TaskRecord>, _> = lines.collect();
                Ok(records.unwrap_or_else(|e| vec![failure(e.to_string())]))
            }
            Err(reason) => Ok(vec![failure(reason)]),
        }
    }

    fn write(&self, results: &StoredResults, progress: &Progress) -> Result<(), Failure> {
        let is_ours = |r: &&TaskRecord| self.plan.find(&r.key).is_some();
        let records: Vec<&TaskRecord> = results.records.iter().filter(is_ours).collect();
        report::write(self.suite, &self.machine, &records, self.folder, progress)
    }

    fn summary(&self, results: &StoredResults, did: TaskCounts) -> Report {
        let mut report = Report::default();
        let task_count = self.plan.len();
        let before = task_count - did.done - did.failed - did.skipped;
        let mut words = format!("{} of {task_count}", did.done);
        if before > 0 {
            words += &format!(", {before} were done before");
        }
        report.fact("tasks", task_count, "tasks done", words);
        report.value("tasks_before", before);
        if did.skipped > 0 {
            let words = format!("{}, not available here: see the report", did.skipped);
            report.line("skipped", words);
        }
        report.value("tasks_skipped", did.skipped);
        if did.failed > 0 {
            report.line("failed", format!("{}, see the report", did.failed));
        }
        report.value("tasks_failed", did.failed);
        let truths = results.records.iter().filter_map(|r| match &r.outcome {
            TaskOutcome::Truth(t) => Some(t.standard_errors.is_some_and(|s| s <= 4.0)),
            _ => None,
        });
        let truths: Vec<bool> = truths.collect();
        if !truths.is_empty() {
            let inside = truths.iter().filter(|t| **t).count();
            let words = format!("{inside} of {} within 4 standard errors", truths.len());
            let share = inside as f64 / truths.len() as f64;
            report.fact("truths_within_4", number(share), "truths", words);
        }
        let path = self.folder.join(report::PAGE).display().to_string();
        report.fact("output", path.clone(), "report", path);
        report
    }
}

/// Why a task has no result.
fn obstacle(record: &TaskRecord) -> Option<&TaskOutcome> {
    let outcome = &record.outcome;
    let is_obstacle = matches!(
        outcome,
        TaskOutcome::Failure { .. } | TaskOutcome::Skipped { .. }
    );
    is_obstacle.then_some(outcome)
}

/// Least time between two updates of the report, which grows with the results.
const UPDATE: Duration = Duration::from_secs(1);
