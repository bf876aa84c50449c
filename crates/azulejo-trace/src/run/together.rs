//! Processes that talk to each other, as threads of one.

use super::{Blocks, Division, RunRole, RunStage};
use crate::progress::Cancelled;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

/// Runs the same work so many times at once, as processes that share it would; the results in their order. For tests:
/// threads of one process need none of it.
///
/// Once one of them is cancelled, all are.
pub fn together<T: Send>(processes: usize, work: impl Fn(&dyn Blocks) -> T + Sync) -> Vec<T> {
    let table = Table::default();
    thread::scope(|scope| {
        let start = |place: usize| {
            let (table, work) = (&table, &work);
            scope.spawn(move || {
                let seat = Seat {
                    table,
                    place,
                    processes,
                    loops: AtomicU32::new(0),
                };
                let result = work(&seat);
                seat.leave();
                result
            })
        };
        let threads: Vec<_> = (0..processes).map(start).collect();
        let join = |thread: thread::ScopedJoinHandle<'_, T>| match thread.join() {
            Ok(result) => result,
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
    next: HashMap<RunStage, usize>,
    /// What was given, by the number of the exchange and the place.
    given: HashMap<(usize, usize), Vec<u8>>,
    /// Exchanges that each place has begun.
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
    place: usize,
    processes: usize,
    loops: AtomicU32,
}

impl Seat<'_> {
    fn leave(&self) {
        self.table.state().has_left = true;
        self.table.changed.notify_all();
    }
}

impl Blocks for Seat<'_> {
    fn load(&self, _: RunStage, _: usize) -> Option<Vec<u8>> {
        None
    }

    fn save(&self, _: RunStage, _: usize, _: &[u8]) {}

    fn role(&self) -> RunRole {
        RunRole {
            processes: self.processes,
            ..RunRole::default()
        }
    }

    fn loop_stage(&self) -> RunStage {
        RunStage::Loop(self.loops.fetch_add(1, Ordering::Relaxed))
    }

    fn next(
        &self,
        stage: RunStage,
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

    fn gather(&self, _: RunStage, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Cancelled> {
        let mut state = self.table.state();
        let exchange = *state.exchanges.entry(self.place).or_default();
        *state.exchanges.entry(self.place).or_default() += 1;
        state.given.insert((exchange, self.place), own);
        self.table.changed.notify_all();
        loop {
            let of = |place: usize| state.given.get(&(exchange, place)).cloned();
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

/// Blocks that count the items that their process computes. For tests.
pub struct CountedBlocks<'a> {
    blocks: &'a dyn Blocks,
    items: AtomicUsize,
}

impl<'a> CountedBlocks<'a> {
    /// Of blocks that are not stored.
    pub fn new(blocks: &'a dyn Blocks) -> CountedBlocks<'a> {
        CountedBlocks {
            blocks,
            items: AtomicUsize::new(0),
        }
    }

    /// Items of all stages so far.
    pub fn items(&self) -> usize {
        self.items.load(Ordering::Relaxed)
    }
}

impl Blocks for CountedBlocks<'_> {
    fn role(&self) -> RunRole {
        self.blocks.role()
    }

    fn load(&self, stage: RunStage, block: usize) -> Option<Vec<u8>> {
        self.blocks.load(stage, block)
    }

    fn save(&self, stage: RunStage, block: usize, bytes: &[u8]) {
        self.blocks.save(stage, block, bytes);
    }

    fn next(
        &self,
        stage: RunStage,
        division: Division,
        left: Range<usize>,
        most: usize,
    ) -> Result<Vec<usize>, Cancelled> {
        let next = self.blocks.next(stage, division, left, most)?;
        let items = next.iter().map(|&block| division.of(block).count());
        self.items.fetch_add(items.sum(), Ordering::Relaxed);
        Ok(next)
    }

    fn gather(&self, stage: RunStage, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Cancelled> {
        self.blocks.gather(stage, own)
    }

    fn loop_stage(&self) -> RunStage {
        self.blocks.loop_stage()
    }

    fn rely_on(&self, stage: RunStage, digest: u64) -> Result<(), Cancelled> {
        self.blocks.rely_on(stage, digest)
    }
}
