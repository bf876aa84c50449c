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
//! Only main threads call MPI, through [`Transport`]. A [`Link`] connects the two threads of a rank.

mod blocks;
mod inputs;
mod launcher;
mod link;
mod messages;
mod messenger;
#[cfg(feature = "mpi")]
mod mpi;
#[cfg(test)]
mod tests;
mod transport;

use crate::args::Cli;
use crate::content_key::shown;
use crate::failure::Failure;
use crate::runner::journal::FileJournal;
use crate::runner::{DividedWork, WorkKey};
use crate::session::SessionSetup;
use blocks::RankBlocks;
pub use blocks::RankCosts;
pub use launcher::{files_of, is_helper};
use link::Link;
pub use messenger::Control;
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
        let all = self.link.all_gather(parts.join("\n").into_bytes())?;
        let all: Vec<String> = all
            .iter()
            .map(|bytes| String::from_utf8_lossy(bytes).into_owned())
            .collect();
        for (rank, theirs) in all.iter().enumerate() {
            let differs = |k: usize| theirs.lines().nth(k) != all[0].lines().nth(k);
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
    /// They do not agree; the file next to the output is no journal; the work was cancelled.
    pub fn blocks(&self, plan: &DividedWork) -> Result<RankBlocks, Failure> {
        let key = (plan.key)();
        self.agree(&key)?;
        let output = plan.output.filter(|_| self.is_root());
        let file = output.map(|output| FileJournal::beside(output, key.whole()));
        RankBlocks::new(self, plan.sharing, file.transpose()?)
    }
}

/// Runs a command, by all ranks if there are several.
///
/// # Errors
/// Those of the command; it is one that ranks cannot share.
pub fn launch(
    cli: Cli,
    work: impl FnOnce(Cli, Option<Ranks>) -> Result<(), Failure> + Send + 'static,
) -> Result<(), Failure> {
    if !launcher::is_shared(&cli)? {
        return work(cli, None);
    }
    #[cfg(feature = "mpi")]
    return mpi::launch(cli, work);
    #[cfg(not(feature = "mpi"))]
    Err(launcher::without_mpi())
}
