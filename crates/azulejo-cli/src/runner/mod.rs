//! Who computes the blocks of a command's work, and what becomes of finished ones.
//!
//! | | blocks |
//! |---|---|
//! | one process | all; kept in a [`journal`] next to the output, if the work is to be resumed |
//! | `--shard K/N` | those of a [`part`], which is a file of finished blocks behind a [`header`] that says of what work they are |
//! | `merge` | none: the recorded command runs with its [parts](merge), so that its result is that of one process by construction |
//! | `mpiexec` | those that rank 0 hands out: see [`ranks`] |
//!
//! A command reads its input, and gives its work to [`Runner::compute`]; a process that does not make the result gets
//! none, and is done.

mod command;
mod header;
mod journal;
pub mod merge;
mod part;
#[cfg_attr(
    not(feature = "mpi"),
    allow(
        dead_code,
        reason = "without MPI nobody starts ranks; tests and lints see their messages all the same"
    )
)]
mod ranks;
mod record_file;

use crate::failure::Failure;
use crate::first_pass::FirstPassArgs;
use crate::parts::Shard;
use crate::report::Report;
use crate::session::{Session, SessionSetup};
use azulejo_trace::Blocks;
use azulejo_trace::run::Alone;
pub use command::{DescribedCommand, OutputArg, ShardedArgs, typed};
pub use header::WorkKey;
use journal::FileJournal;
use merge::MergedParts;
use part::PartPlan;
use ranks::{RankCosts, Ranks};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Who computes the work of a command.
pub struct Runner<'a>(Workers<'a>);

/// Describes the command of this process, once that is needed.
type Describe = fn() -> Result<DescribedCommand, Failure>;

enum Workers<'a> {
    /// This process.
    One,
    /// This process a part, which it writes in place of the result.
    Part(PartPlan),
    /// All ranks.
    Ranks(Ranks, Describe),
    /// Shards, which have ended: the result is made of their parts.
    Merged(&'a MergedParts),
}

/// Who needs the blocks of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sharing {
    /// The process that makes the result alone. One process keeps finished ones, too.
    Root,
    /// All processes, which go on with them.
    All,
}

/// Work that can be divided.
pub struct DividedWork<'a> {
    /// What its blocks depend on.
    pub key: &'a dyn Fn() -> WorkKey,
    /// Who needs them.
    pub sharing: Sharing,
    /// The file next to which they are kept until it is written, if it is one.
    pub output: Option<&'a Path>,
}

/// The result of work, and what is left to do once it is written.
pub struct Completed<T> {
    /// The result.
    pub value: T,
    /// What is left to do.
    pub rest: Completion,
}

/// What is left to do once a result is written.
#[derive(Default)]
pub struct Completion {
    journal: Option<Arc<FileJournal>>,
    costs: Option<RankCosts>,
}

impl Completion {
    /// The result is written: its blocks are of no more use, and what the work took each process is reported.
    pub fn finish(self, report: &mut Report) {
        if let Some(journal) = &self.journal {
            journal.remove();
        }
        if let Some(costs) = &self.costs {
            costs.describe(report);
        }
    }
}

impl<'a> Runner<'a> {
    /// One process.
    pub fn alone() -> Runner<'a> {
        Runner(Workers::One)
    }

    /// Those of a command: its shard, or all processes that were started together.
    ///
    /// # Errors
    /// The part cannot be written.
    pub fn new(
        shard: Option<(Shard, Option<&Path>)>,
        described: Describe,
        started: Started,
    ) -> Result<Runner<'a>, Failure> {
        let workers = match (shard, started.0) {
            (Some((shard, output)), _) => Workers::Part(PartPlan::check(shard, output, described)?),
            (None, Some(ranks)) => Workers::Ranks(ranks, described),
            (None, None) => Workers::One,
        };
        Ok(Runner(workers))
    }

    /// Parts that were computed before.
    fn merged(parts: &'a MergedParts) -> Runner<'a> {
        Runner(Workers::Merged(parts))
    }

    /// Whether this process makes the result and writes it.
    pub fn writes(&self) -> bool {
        match &self.0 {
            Workers::One | Workers::Merged(_) => true,
            Workers::Part(_) => false,
            Workers::Ranks(ranks, _) => ranks.is_root(),
        }
    }

    /// Whether it computes a part by itself, without the results of others.
    pub fn is_part(&self) -> bool {
        matches!(self.0, Workers::Part(_))
    }

    /// Whether the result is made of parts.
    pub fn is_merged(&self) -> bool {
        matches!(self.0, Workers::Merged(_))
    }

    /// The option or program by which several processes share the work, now.
    pub fn shared_by(&self) -> Option<&'static str> {
        match &self.0 {
            Workers::One | Workers::Merged(_) => None,
            Workers::Part(_) => Some("--shard"),
            Workers::Ranks(..) => Some("mpiexec"),
        }
    }

    /// Gives the files that were read to the other ranks, if there are any.
    ///
    /// # Errors
    /// See [`Ranks::share_files`].
    pub fn share_files(&self, session: &Session) -> Result<(), Failure> {
        match &self.0 {
            Workers::Ranks(ranks, described) if ranks.is_root() => {
                ranks.share_files(&described()?.files, session.files())
            }
            _ => Ok(()),
        }
    }

    /// Does the work, which gets the blocks; `None` if this process does not make the result. A part is described in
    /// the report.
    ///
    /// # Errors
    /// Those of the work; processes do not have the same; parts are of other work; blocks cannot be kept.
    pub fn compute<T>(
        self,
        plan: &DividedWork,
        session: &mut Session,
        report: &mut Report,
        work: impl FnOnce(&dyn Blocks, &mut Session) -> Result<Option<T>, Failure>,
    ) -> Result<Option<Completed<T>>, Failure> {
        let (value, rest) = match self.0 {
            Workers::One => {
                let output = plan.output.filter(|_| plan.sharing == Sharing::Root);
                let journal =
                    output.map(|output| FileJournal::beside(output, (plan.key)().whole()));
                let journal = journal.transpose()?.map(Arc::new);
                let value = match journal.as_deref() {
                    Some(file) => file.keeping(session, |session| work(file, session))?,
                    None => work(&Alone, session)?,
                };
                (
                    value,
                    Completion {
                        journal,
                        costs: None,
                    },
                )
            }
            Workers::Part(part) => {
                let part = part.open(&(plan.key)(), session)?;
                part.fill(session, report, |part, session| {
                    work(part, session).map(|_| ())
                })?;
                (None, Completion::default())
            }
            Workers::Ranks(ranks, _) => {
                let blocks = ranks.blocks(plan)?;
                let value = blocks.run(session, work)?;
                (
                    value.filter(|_| ranks.is_root()),
                    blocks.completion(session)?,
                )
            }
            Workers::Merged(parts) => {
                parts.check(&(plan.key)())?;
                (parts.used(work(parts, session))?, Completion::default())
            }
        };
        Ok(value.map(|value| Completed { value, rest }))
    }
}

/// Processes that a launcher started together, if there are several.
pub struct Started(Option<Ranks>);

impl Started {
    /// One process.
    pub fn alone() -> Started {
        Started(None)
    }

    /// How this process works for all of them.
    pub fn setup(&self) -> SessionSetup {
        self.0.as_ref().map(Ranks::setup).unwrap_or_default()
    }
}

/// Runs a command by all processes that were started together; `files` are those that it reads.
///
/// # Errors
/// Those of the command; this program cannot share work.
pub fn launch<C: Send + 'static>(
    command: C,
    files: fn(&mut C) -> Vec<&mut PathBuf>,
    work: fn(C, Started) -> Result<(), Failure>,
) -> Result<(), Failure> {
    ranks::launch(command, files, move |command, ranks| {
        work(command, Started(ranks))
    })
}

/// Whether a launcher started several processes.
pub fn is_started_together() -> bool {
    ranks::is_started_together()
}

/// Whether another process of those that were started together says what all of them would say.
pub fn is_silent() -> bool {
    ranks::is_helper()
}

/// Refuses to share work between processes that depends on the time, or, if they never meet, on the results of all
/// points.
///
/// # Errors
/// The options ask for such work.
pub fn refuse_indivisible(args: &FirstPassArgs, runner: &Runner) -> Result<(), Failure> {
    let is_timed = args.limit().is_some();
    match &runner.0 {
        Workers::Part(_) if is_timed => Err(Failure::misuse(
            "--shard: how far work comes in a --time depends on the machine, so that parts would not fit together; \
             give --rays N alone",
        )),
        Workers::Part(_) if args.requested_error().is_some() || args.rays.is_none() => {
            Err(Failure::misuse(
                "--shard: work to an error, by --error or to 3% by default, looks at the results of all points before it \
             traces more rays, which a shard does not have; give --rays N alone",
            ))
        }
        Workers::Ranks(..) if is_timed => Err(Failure::misuse(
            "--time: how far work comes in a time depends on the machines, and several processes share it: give --error \
             or --rays, and the time to the queue; what is done by then is kept",
        )),
        _ => Ok(()),
    }
}
