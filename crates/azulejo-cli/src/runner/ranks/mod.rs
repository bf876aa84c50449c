//! Processes that MPI started together, which share one work: its ranks.
//!
//! All ranks run the same command on the same data, as if each were alone. Where a loop is worth it, its
//! blocks are handed out by rank 0 and the results of all are exchanged
//! ([`RankBlocks`]); so nothing else knows of ranks, and results have the bytes of one process. Rank 0
//! reads the files for all, keeps finished blocks, and alone writes and says anything.
//!
//! | | thread of the work | main thread |
//! |---|---|---|
//! | rank 0 | the command | [`messenger`]: hands out blocks, keeps those of others |
//! | others | the command without its output | [`messenger`]: asks rank 0 |
//!
//! Only main threads call MPI, through [`Transport`](messenger::Transport). A [`Link`] connects the two threads of a rank.

mod blocks;
mod inputs;
mod link;
mod messenger;
#[cfg(feature = "mpi")]
mod mpi;
#[cfg(test)]
mod tests;

use crate::content_key::shown;
use crate::failure::Failure;
use crate::runner::journal::FileJournal;
use crate::runner::{DividedWork, WorkKey};
use crate::session::SessionSetup;
use blocks::RankBlocks;
pub use blocks::RankCosts;
use link::Link;
pub use messenger::Control;
use std::env;
use std::path::PathBuf;
use std::sync::Arc;

/// This process among all ranks.
#[derive(Clone, Debug)]
pub struct Ranks {
    link: Link,
    /// Its number; 0 has the output.
    pub rank: usize,
    /// Number of all, at least 2.
    pub size: usize,
    /// Number of machines.
    pub nodes: usize,
    /// Threads for each, if the command line does not say.
    pub threads: usize,
    /// Memory of the machine of rank 0, bytes; what depends on it has to be the same for all.
    pub memory: Option<u64>,
    /// What the work and its messages have in common.
    pub control: Control,
}

impl Ranks {
    /// How this process works for all of them.
    pub fn setup(&self) -> SessionSetup {
        SessionSetup {
            is_silent: !self.is_root(),
            progress: Arc::clone(&self.control.progress),
            block_end: Arc::clone(&self.control.block_end),
            threads: Some(self.threads),
            memory: self.memory,
        }
    }

    /// Whether it has the output.
    pub fn is_root(&self) -> bool {
        self.rank == 0
    }

    /// Makes sure that all ranks do the same work.
    ///
    /// # Errors
    /// Some do not, and why; the work was cancelled.
    pub fn agree(&self, key: &WorkKey) -> Result<(), Failure> {
        let parts = [shown(&key.scene), shown(&key.settings), key.engine.clone()];
        let keys = self.link.all_gather(parts.join("\n").into_bytes())?;
        let keys: Vec<String> = keys
            .iter()
            .map(|bytes| String::from_utf8_lossy(bytes).into_owned())
            .collect();
        for (rank, theirs) in keys.iter().enumerate() {
            let differs = |k: usize| theirs.lines().nth(k) != keys[0].lines().nth(k);
            let why = if differs(0) {
                "reads another scene than rank 0: files in folders of --allow have to be the same on all machines"
            } else if differs(2) {
                "chooses another engine than rank 0: give --engine"
            } else if differs(1) {
                "has a processor with other instructions for rays than that of rank 0, whose results differ in the \
                 last bits: run on machines of one kind"
            } else {
                continue;
            };
            return Err(Failure::failed(format_args!("rank {rank} {why}")));
        }
        Ok(())
    }

    /// The blocks of the work, once all ranks agree on what it is. At rank 0, finished ones are kept next to the output,
    /// if there is one.
    ///
    /// # Errors
    /// They do not agree; the file next to the output is not a journal; the work was cancelled.
    pub fn blocks(&self, plan: &DividedWork) -> Result<RankBlocks, Failure> {
        let key = (plan.key)();
        self.agree(&key)?;
        let output = plan.output.filter(|_| self.is_root());
        let file = output.map(|output| FileJournal::beside(output, key.whole()));
        RankBlocks::new(self, plan.sharing, file.transpose()?)
    }
}

/// Runs a command by all ranks; `files` are those that it reads.
///
/// # Errors
/// Those of the command; this program cannot share work.
#[cfg_attr(not(feature = "mpi"), allow(unused_variables))]
pub fn launch<C: Send + 'static>(
    command: C,
    files: fn(&mut C) -> Vec<&mut PathBuf>,
    work: impl FnOnce(C, Option<Ranks>) -> Result<(), Failure> + Send + 'static,
) -> Result<(), Failure> {
    #[cfg(feature = "mpi")]
    return mpi::launch(command, files, work);
    #[cfg(not(feature = "mpi"))]
    Err(without_mpi())
}

/// Variables of launchers of MPI programs with the number of this rank: Open MPI's, MPICH's and Intel's, MVAPICH's, that of PMIx.
const RANK: [&str; 4] = [
    "OMPI_COMM_WORLD_RANK",
    "PMI_RANK",
    "MV2_COMM_WORLD_RANK",
    "PMIX_RANK",
];

/// Variables with the number of ranks; that of SLURM counts beside one of those above.
const SIZE: [&str; 4] = [
    "OMPI_COMM_WORLD_SIZE",
    "PMI_SIZE",
    "MV2_COMM_WORLD_SIZE",
    "SLURM_STEP_NUM_TASKS",
];

/// Whether the launcher says that this is not rank 0, which alone says anything.
pub fn is_helper() -> bool {
    number(&RANK).is_some_and(|rank| rank > 0)
}

/// Whether a launcher started several processes.
pub fn is_started_together() -> bool {
    number(&RANK).is_some() && number(&SIZE).is_some_and(|size| size >= 2)
}

/// Several processes, of a program that cannot share.
#[cfg(not(feature = "mpi"))]
fn without_mpi() -> Failure {
    Failure::misuse(
        "MPI started several processes, but this azulejo was built without it, and each would do all of the work: build \
         with --features mpi (docs/mpi.md), divide the work by --shard, or run one process",
    )
}

/// Threads of each of this many ranks of one machine: its part of the processors, or those that it is bound to.
#[cfg(feature = "mpi")]
fn threads(ranks: usize) -> usize {
    let bound = std::thread::available_parallelism().map_or(1, usize::from);
    // A rank that is bound to some processors does not see the others there.
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let processors = text
        .lines()
        .filter(|line| line.starts_with("processor"))
        .count();
    (processors.max(bound) / ranks.max(1)).clamp(1, bound)
}

fn number(names: &[&str]) -> Option<usize> {
    let value = |name: &&str| env::var(name).ok()?.trim().parse().ok();
    names.iter().find_map(value)
}
