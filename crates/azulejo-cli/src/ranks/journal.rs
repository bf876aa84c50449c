//! The journal of a rank: blocks are handed out by rank 0, which may keep them in a file.

use super::link::{Link, Traffic};
use crate::failure::Failure;
use crate::file_journal::FileJournal;
use crate::interrupt::BlockEnd;
use crate::session::Session;
use azulejo_trace::journal::{Blocks, Division, Record, RecordReader, exchanged};
use azulejo_trace::{Cancelled, Journal, JournalStage};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Who needs the blocks of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sharing {
    /// Rank 0 alone, which makes the result of them.
    Root,
    /// All ranks, which go on with them.
    All,
}

/// What a work took one rank.
#[derive(Clone, Copy, Debug)]
pub struct RankCosts {
    /// Seconds of processors.
    pub cpu: f64,
    /// What it exchanged.
    pub traffic: Traffic,
}

/// The journal of a rank.
pub struct RankJournal {
    link: Link,
    rank: usize,
    size: usize,
    sharing: Sharing,
    /// Whether rank 0 keeps blocks in a file.
    is_kept: bool,
    file: Option<Arc<FileJournal>>,
    block_end: Arc<BlockEnd>,
    /// Of the blocks that rank 0 handed out last, those that are known already.
    known: Mutex<HashMap<(JournalStage, usize), Vec<u8>>>,
    steps: AtomicU32,
    /// Whether ranks computed something differently.
    differs: AtomicBool,
}

impl RankJournal {
    /// Of all ranks at once, which agree on whether there is a file.
    pub fn new(
        link: Link,
        (rank, size): (usize, usize),
        sharing: Sharing,
        file: Option<FileJournal>,
        block_end: Arc<BlockEnd>,
    ) -> Result<RankJournal, Failure> {
        let file = file.map(Arc::new);
        if let Some(file) = &file {
            link.keep(Arc::clone(file));
        }
        let said = link.broadcast(vec![u8::from(file.is_some())])?;
        Ok(RankJournal {
            link,
            rank,
            size,
            sharing,
            is_kept: said == [1],
            file,
            block_end,
            known: Mutex::default(),
            steps: AtomicU32::new(0),
            differs: AtomicBool::new(false),
        })
    }

    /// Does the work with this journal, and says what is to be known of it.
    ///
    /// # Errors
    /// Those of the work; ranks had different results.
    pub fn run<T>(
        &self,
        session: &mut Session,
        work: impl FnOnce(&dyn Journal, &mut Session) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let file = self.file.as_deref();
        let messages = |session: &mut Session| {
            let said = file.map(FileJournal::take_messages).unwrap_or_default();
            said.iter().for_each(|message| session.note(message));
        };
        messages(session);
        if let Some(file) = file.filter(|file| file.blocks() > 0) {
            session.say(&format!("resuming from {}", file.path().display()));
        }
        let outcome = work(self, session);
        self.block_end.set_in_block(false);
        messages(session);
        if self.differs.load(Ordering::Relaxed) {
            return Err(Failure::failed(
                "ranks compute the light between patches differently, because of their processors: run on machines of \
                 one kind",
            ));
        }
        if let (Err(_), Some(file)) = (&outcome, file.filter(|file| file.blocks() > 0)) {
            session.say(&format!(
                "completed work is kept in {}: the same command resumes from there",
                file.path().display()
            ));
        }
        if outcome.is_ok() {
            session.set_rank_costs(self.costs(session.cpu_seconds())?);
        }
        outcome
    }

    /// What the work took each rank, once all have done it.
    fn costs(&self, cpu: f64) -> Result<Vec<RankCosts>, Failure> {
        let Traffic {
            given,
            gathered,
            exchanges,
            blocks,
            waited,
            divided,
        } = self.link.traffic();
        let mut bytes = Vec::new();
        [given, gathered, exchanges, blocks].write(&mut bytes);
        [cpu, waited, divided].write(&mut bytes);
        let all = self.link.all_gather(bytes)?;
        let costs = all.iter().filter_map(|bytes| {
            let mut reader = RecordReader::new(bytes);
            let [given, gathered, exchanges, blocks] = Record::read(&mut reader)?;
            let [cpu, waited, divided] = Record::read(&mut reader)?;
            let traffic = Traffic {
                given,
                gathered,
                exchanges,
                blocks,
                waited,
                divided,
            };
            Some(RankCosts { cpu, traffic })
        });
        Ok(costs.collect())
    }

    /// The work is written: its blocks are of no more use.
    pub fn remove(&self) {
        self.file.iter().for_each(|file| file.remove());
    }
}

impl Journal for RankJournal {
    fn load(&self, stage: JournalStage, block: usize) -> Option<Vec<u8>> {
        if let Some(file) = &self.file {
            return file.load(stage, block);
        }
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.remove(&(stage, block))
    }

    fn save(&self, stage: JournalStage, block: usize, bytes: &[u8]) {
        if let Some(file) = &self.file {
            file.save(stage, block, bytes);
        } else if self.rank > 0 {
            self.link.deliver(stage, block, bytes);
        }
    }

    fn is_kept(&self) -> bool {
        self.is_kept || (self.sharing == Sharing::Root && self.rank > 0)
    }

    fn processes(&self) -> usize {
        match self.sharing {
            Sharing::Root => 1,
            Sharing::All => self.size,
        }
    }

    fn has_steps(&self) -> bool {
        self.sharing == Sharing::All
    }

    fn step(&self) -> JournalStage {
        JournalStage::Step(self.steps.fetch_add(1, Ordering::Relaxed))
    }

    fn next(
        &self,
        stage: JournalStage,
        division: Division,
        mut left: Range<usize>,
        most: usize,
    ) -> Result<Vec<usize>, Cancelled> {
        self.block_end.set_in_block(true);
        loop {
            if self.block_end.is_asked() {
                return Err(Cancelled);
            }
            let mut handed = self.link.next(stage, division, left.clone(), most)?;
            let Some((last, _)) = handed.last() else {
                return Ok(Vec::new());
            };
            left.start = last + 1;
            if self.sharing == Sharing::Root {
                // What rank 0 has, it needs from nobody.
                handed.retain(|(_, known)| known.is_none());
                if handed.is_empty() {
                    continue;
                }
            }
            let blocks = handed.iter().map(|(block, _)| *block).collect();
            let known = handed
                .into_iter()
                .filter_map(|(block, known)| Some(((stage, block), known?)));
            *self.known.lock().unwrap_or_else(PoisonError::into_inner) = known.collect();
            return Ok(blocks);
        }
    }

    fn assembles(&self) -> bool {
        self.rank == 0 || self.sharing == Sharing::All
    }

    fn rely_on(&self, _: JournalStage, digest: u64) -> Result<(), Cancelled> {
        if self.sharing == Sharing::Root {
            return Ok(());
        }
        let all = self.link.all_gather(digest.to_le_bytes().to_vec())?;
        if all.iter().all(|other| *other == all[0]) {
            return Ok(());
        }
        self.differs.store(true, Ordering::Relaxed);
        Err(Cancelled)
    }

    fn of_others(&self, stage: JournalStage, own: Blocks) -> Result<Blocks, Cancelled> {
        match self.sharing {
            Sharing::Root => self.link.collect(stage),
            Sharing::All => exchanged(self, own),
        }
    }

    fn begins_part(&self) {
        self.link.begins_part();
    }

    fn all_gather(&self, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Cancelled> {
        self.link.all_gather(own)
    }
}
