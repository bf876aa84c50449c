//! Processes that talk to each other, as threads of one.

use super::{Blocks, Division, Journal, JournalStage};
use crate::progress::Cancelled;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

/// Runs the same work so many times at once, as processes that share it through their journals would; the
/// results in their order. For tests: threads of one process need no journals.
///
/// Once one of them is cancelled, all are.
pub fn together<T: Send>(processes: usize, work: impl Fn(&dyn Journal) -> T + Sync) -> Vec<T> {
    let table = Table::default();
    thread::scope(|scope| {
        let start = |rank: usize| {
            let (table, work) = (&table, &work);
            scope.spawn(move || {
                let seat = Seat {
                    table,
                    rank,
                    processes,
                    steps: AtomicU32::new(0),
                };
                let found = work(&seat);
                seat.leave();
                found
            })
        };
        let threads: Vec<_> = (0..processes).map(start).collect();
        let join = |thread: thread::ScopedJoinHandle<'_, T>| match thread.join() {
            Ok(found) => found,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        threads.into_iter().map(join).collect()
    })
}

/// What all of them see.
#[derive(Default)]
struct Table {
    state: Mutex<TableState>,
    changed: Condvar,
}

#[derive(Default)]
struct TableState {
    /// The first block of each stage that nobody has.
    next: HashMap<JournalStage, usize>,
    /// What was given, by the number of the exchange and the rank.
    given: HashMap<(usize, usize), Vec<u8>>,
    /// Exchanges that each rank has begun.
    exchanges: HashMap<usize, usize>,
    /// Whether one of them has ended: no exchange after it can be complete.
    has_left: bool,
}

impl Table {
    fn state(&self) -> MutexGuard<'_, TableState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One of the processes.
struct Seat<'a> {
    table: &'a Table,
    rank: usize,
    processes: usize,
    steps: AtomicU32,
}

impl Seat<'_> {
    fn leave(&self) {
        self.table.state().has_left = true;
        self.table.changed.notify_all();
    }
}

impl Journal for Seat<'_> {
    fn load(&self, _: JournalStage, _: usize) -> Option<Vec<u8>> {
        None
    }

    fn save(&self, _: JournalStage, _: usize, _: &[u8]) {}

    fn processes(&self) -> usize {
        self.processes
    }

    fn has_steps(&self) -> bool {
        true
    }

    fn step(&self) -> JournalStage {
        JournalStage::Step(self.steps.fetch_add(1, Ordering::Relaxed))
    }

    fn next(
        &self,
        stage: JournalStage,
        division: Division,
        left: Range<usize>,
        most: usize,
    ) -> Result<Vec<usize>, Cancelled> {
        let mut state = self.table.state();
        let next = state.next.entry(stage).or_default();
        let first = (*next).max(left.start);
        let left = division.blocks().saturating_sub(first);
        let end = first + super::guided_share(left, self.processes, most);
        *next = end.max(*next);
        Ok((first..end).collect())
    }

    fn of_others(&self, _: JournalStage, own: Blocks) -> Result<Blocks, Cancelled> {
        super::exchanged(self, own)
    }

    fn all_gather(&self, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Cancelled> {
        let mut state = self.table.state();
        let exchange = *state.exchanges.entry(self.rank).or_default();
        *state.exchanges.entry(self.rank).or_default() += 1;
        state.given.insert((exchange, self.rank), own);
        self.table.changed.notify_all();
        loop {
            let of = |rank: usize| state.given.get(&(exchange, rank)).cloned();
            if let Some(all) = (0..self.processes).map(of).collect::<Option<Vec<_>>>() {
                return Ok(all);
            }
            if state.has_left {
                return Err(Cancelled);
            }
            let waiting = self.table.changed.wait(state);
            state = waiting.unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// A journal that counts the items that its process computes. For tests.
pub struct CountedJournal<'a> {
    journal: &'a dyn Journal,
    items: AtomicUsize,
}

impl<'a> CountedJournal<'a> {
    /// Of a journal that stores nothing.
    pub fn new(journal: &'a dyn Journal) -> CountedJournal<'a> {
        CountedJournal {
            journal,
            items: AtomicUsize::new(0),
        }
    }

    /// Items of all stages so far.
    pub fn items(&self) -> usize {
        self.items.load(Ordering::Relaxed)
    }
}

impl Journal for CountedJournal<'_> {
    fn load(&self, stage: JournalStage, block: usize) -> Option<Vec<u8>> {
        self.journal.load(stage, block)
    }

    fn save(&self, stage: JournalStage, block: usize, bytes: &[u8]) {
        self.journal.save(stage, block, bytes);
    }

    fn is_kept(&self) -> bool {
        self.journal.is_kept()
    }

    fn parts(&self) -> usize {
        self.journal.parts()
    }

    fn processes(&self) -> usize {
        self.journal.processes()
    }

    fn has_steps(&self) -> bool {
        self.journal.has_steps()
    }

    fn step(&self) -> JournalStage {
        self.journal.step()
    }

    fn next(
        &self,
        stage: JournalStage,
        division: Division,
        left: Range<usize>,
        most: usize,
    ) -> Result<Vec<usize>, Cancelled> {
        let next = self.journal.next(stage, division, left, most)?;
        let items = next.iter().map(|&block| division.of(block).count());
        self.items.fetch_add(items.sum(), Ordering::Relaxed);
        Ok(next)
    }

    fn assembles(&self) -> bool {
        self.journal.assembles()
    }

    fn rely_on(&self, stage: JournalStage, digest: u64) -> Result<(), Cancelled> {
        self.journal.rely_on(stage, digest)
    }

    fn of_others(&self, stage: JournalStage, own: Blocks) -> Result<Blocks, Cancelled> {
        self.journal.of_others(stage, own)
    }

    fn begins_part(&self) {
        self.journal.begins_part();
    }

    fn all_gather(&self, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Cancelled> {
        self.journal.all_gather(own)
    }
}
