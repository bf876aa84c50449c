//! Processes that MPI started together, which share one work: its ranks.
//!
//! All ranks run the same command on the same data, as if each were alone. Where a loop is worth it, its
//! blocks are handed out by rank 0 and the results of all are exchanged, through the journal
//! ([`RankJournal`]); so nothing else knows of ranks, and results have the bytes of one process. Rank 0
//! reads the files for all, keeps the journal, and alone writes and says anything.
//!
//! | | thread of the work | main thread |
//! |---|---|---|
//! | rank 0 | the command | [`messenger`]: hands out blocks, keeps those of others |
//! | others | the command without its output | [`messenger`]: asks rank 0 |
//!
//! Only main threads call MPI, through [`Transport`]. A [`Link`] connects the two threads of a rank.

mod inputs;
mod journal;
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
use crate::file_journal::FileJournal;
use crate::shards::WorkKey;
pub use journal::{RankCosts, RankJournal, Sharing};
pub use launcher::{files_of, has_own_work, is_helper};
use link::Link;
pub use messenger::Control;
use std::path::Path;
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

    /// The journal of the work, once all ranks agree on what it is. At rank 0, blocks are kept next to `output`, if
    /// there is one.
    ///
    /// # Errors
    /// They do not agree; the file next to the output is no journal; the work was cancelled.
    pub fn journal(
        &self,
        sharing: Sharing,
        key: &WorkKey,
        output: Option<&Path>,
    ) -> Result<RankJournal, Failure> {
        self.agree(key)?;
        let file = output.filter(|_| self.is_root()).map(|output| {
            let mut name = output.as_os_str().to_owned();
            name.push(".journal");
            FileJournal::open(name.into(), key.whole())
        });
        self.journal_in(sharing, file.transpose()?)
    }

    /// The same, with blocks in a given file at rank 0.
    ///
    /// # Errors
    /// The work was cancelled.
    pub fn journal_in(
        &self,
        sharing: Sharing,
        file: Option<FileJournal>,
    ) -> Result<RankJournal, Failure> {
        let (place, block_end) = ((self.rank, self.size), &self.control.block_end);
        RankJournal::new(
            self.link.clone(),
            place,
            sharing,
            file,
            Arc::clone(block_end),
        )
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
