//! The blocks of a rank: handed out by rank 0, which may keep finished ones in a file.

use super::Ranks;
use super::link::{Link, Traffic};
use crate::failure::Failure;
use crate::interrupt::BlockEnd;
use crate::report::{self, Report};
use crate::runner::journal::FileJournal;
use crate::runner::{Completion, Sharing};
use crate::session::Session;
use azulejo_trace::run::{Division, Record, RecordReader, RunRole, write_block};
use azulejo_trace::{Blocks, Cancelled, RunStage};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// What a work took all ranks.
pub struct RankCosts {
    ranks: Vec<RankCost>,
    /// Number of machines.
    nodes: usize,
}

/// What it took one of them.
#[derive(Clone, Copy, Debug)]
struct RankCost {
    /// Seconds of processors.
    cpu: f64,
    /// What it exchanged.
    traffic: Traffic,
}

/// The blocks of a rank.
pub struct RankBlocks {
    link: Link,
    rank: usize,
    size: usize,
    nodes: usize,
    sharing: Sharing,
    /// Whether rank 0 keeps blocks in a file.
    is_kept: bool,
    file: Option<Arc<FileJournal>>,
    block_end: Arc<BlockEnd>,
    /// Of the blocks that rank 0 handed out last, those that are known already.
    known: Mutex<HashMap<(RunStage, usize), Vec<u8>>>,
    loops: AtomicU32,
    /// Whether ranks computed something differently.
    differs: AtomicBool,
}

impl RankBlocks {
    /// Of all ranks at once, which agree on whether there is a file.
    ///
    /// # Errors
    /// The work was cancelled.
    pub fn new(
        ranks: &Ranks,
        sharing: Sharing,
        file: Option<FileJournal>,
    ) -> Result<RankBlocks, Failure> {
        let (link, file) = (ranks.link.clone(), file.map(Arc::new));
        if let Some(file) = &file {
            link.keep(Arc::clone(file));
        }
        let has_file = link.broadcast(vec![u8::from(file.is_some())])?;
        Ok(RankBlocks {
            link,
            rank: ranks.rank,
            size: ranks.size,
            nodes: ranks.nodes,
            sharing,
            is_kept: has_file == [1],
            file,
            block_end: Arc::clone(&ranks.control.block_end),
            known: Mutex::default(),
            loops: AtomicU32::new(0),
            differs: AtomicBool::new(false),
        })
    }

    /// Does the work with them, and says what is to be known of it.
    ///
    /// # Errors
    /// Those of the work; ranks had different results.
    pub fn run<T>(
        &self,
        session: &mut Session,
        work: impl FnOnce(&dyn Blocks, &mut Session) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let ended = |session: &mut Session| {
            let outcome = work(self, session);
            self.block_end.set_in_block(false);
            if self.differs.load(Ordering::Relaxed) {
                return Err(Failure::failed(
                    "ranks compute the light between patches differently, because of their processors: run on machines \
                     of one kind",
                ));
            }
            outcome
        };
        match &self.file {
            Some(file) => file.keeping(session, ended),
            None => ended(session),
        }
    }

    /// What is left to do once the result is written, and what the work took all ranks.
    ///
    /// # Errors
    /// The work was cancelled.
    pub fn completion(&self, session: &Session) -> Result<Completion, Failure> {
        Ok(Completion {
            journal: self.file.clone(),
            costs: Some(self.costs(session.cpu_seconds())?),
        })
    }

    /// What the work took each rank, once all have done it.
    fn costs(&self, cpu: f64) -> Result<RankCosts, Failure> {
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
        let gathered = self.link.all_gather(bytes)?;
        let costs = gathered.iter().filter_map(|bytes| {
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
            Some(RankCost { cpu, traffic })
        });
        Ok(RankCosts {
            ranks: costs.collect(),
            nodes: self.nodes,
        })
    }
}

impl RankCosts {
    /// Adds them to the report of rank 0.
    pub fn describe(&self, report: &mut Report) {
        let nodes = match self.nodes {
            1 => "one machine".to_owned(),
            nodes => format!("{nodes} machines"),
        };
        let cpu = |c: &RankCost| c.cpu;
        let least = self.ranks.iter().map(cpu).fold(f64::INFINITY, f64::min);
        let most = self.ranks.iter().map(cpu).fold(0.0, f64::max);
        let exchanged: u64 = self.ranks.iter().map(|c| c.traffic.given).sum();
        let words = format!(
            "{} on {nodes}, {} of CPU time, {} to {} each, {} exchanged; time and memory below are those of rank 0",
            self.ranks.len(),
            report::seconds(self.ranks.iter().map(cpu).sum()),
            report::seconds(least.min(most)),
            report::seconds(most),
            report::bytes(exchanged)
        );
        report.fact("ranks", self.ranks.len(), "ranks", words);
        let costs: Vec<Value> = self.ranks.iter().map(RankCost::value).collect();
        report.value("rank_costs", costs);
    }
}

impl RankCost {
    fn value(&self) -> Value {
        json!({
            "cpu_seconds": report::number(self.cpu),
            "divided_seconds": report::number(self.traffic.divided),
            "waited_seconds": report::number(self.traffic.waited),
            "blocks": self.traffic.blocks,
            "exchanges": self.traffic.exchanges,
            "given_bytes": self.traffic.given,
            "gathered_bytes": self.traffic.gathered,
        })
    }
}

impl Blocks for RankBlocks {
    fn role(&self) -> RunRole {
        let (processes, assembles) = match self.sharing {
            Sharing::Root => (1, self.rank == 0),
            Sharing::All => (self.size, true),
        };
        RunRole {
            parts: 1,
            processes,
            assembles,
            is_kept: self.is_kept || !assembles,
        }
    }

    fn load(&self, stage: RunStage, block: usize) -> Option<Vec<u8>> {
        if let Some(file) = &self.file {
            return file.load(stage, block);
        }
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.remove(&(stage, block))
    }

    fn save(&self, stage: RunStage, block: usize, bytes: &[u8]) {
        if let Some(file) = &self.file {
            file.save(stage, block, bytes);
        } else if self.rank > 0 {
            self.link.deliver(stage, block, bytes);
        }
    }

    fn next(
        &self,
        stage: RunStage,
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

    fn gather(&self, stage: RunStage, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Cancelled> {
        if self.sharing == Sharing::All {
            return self.link.all_gather(own);
        }
        let mut bytes = Vec::new();
        for (block, content) in self.link.collect(stage)? {
            write_block(block, &content, &mut bytes);
        }
        Ok(vec![bytes])
    }

    fn loop_stage(&self) -> RunStage {
        RunStage::Loop(self.loops.fetch_add(1, Ordering::Relaxed))
    }

    fn rely_on(&self, _: RunStage, digest: u64) -> Result<(), Cancelled> {
        if self.sharing == Sharing::Root {
            return Ok(());
        }
        let digests = self.link.all_gather(digest.to_le_bytes().to_vec())?;
        if digests.iter().all(|other| *other == digests[0]) {
            return Ok(());
        }
        self.differs.store(true, Ordering::Relaxed);
        Err(Cancelled)
    }
}
