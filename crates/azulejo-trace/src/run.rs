//! Long work in blocks that are stored when they are done, and that others may compute.
//!
//! Work is a list of items (rows, groups of points) in blocks with numbers. [`Blocks`] stores finished
//! ones, so that they need not be computed again after an interruption, and says which of them this
//! process computes: all, or those of one part where several processes divide the work, by
//! numbers given in advance or handed out one by one. A [`Run`] is that with a [`Progress`];
//! [`Run::resumed`] is the one loop that all work in blocks uses.

pub mod batches;
mod blocks;
mod division;
mod record;
#[cfg(test)]
mod tests;
mod together;

use crate::progress::{Cancelled, Progress};

pub use blocks::{Alone, Blocks, RunRole, RunStage, guided_share};
pub use division::{Division, LoopSize};
pub use record::{Record, RecordReader, write_list};
use std::ops::Range;
pub use together::{CountedBlocks, together};

/// Most blocks of a loop that all processes share which a process computes at once, for each of its threads: asking for
/// one after the other would take as long as computing them.
const BLOCKS_AT_ONCE: usize = 8;

/// Long work: its blocks, and the progress that counts and stops it.
///
/// A `&Progress` is a run of one process, which keeps nothing.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// Finished blocks, and who computes which.
    pub blocks: &'a dyn Blocks,
    /// Counts and stops the work.
    pub progress: &'a Progress,
}

impl<'a> From<&'a Progress> for Run<'a> {
    fn from(progress: &'a Progress) -> Run<'a> {
        Run::alone(progress)
    }
}

impl<'a> Run<'a> {
    /// By one process, which keeps nothing.
    pub fn alone(progress: &'a Progress) -> Run<'a> {
        Run {
            blocks: &Alone,
            progress,
        }
    }

    /// With these blocks.
    pub fn new(blocks: &'a dyn Blocks, progress: &'a Progress) -> Run<'a> {
        Run { blocks, progress }
    }

    /// The part that this process has in it.
    pub fn role(self) -> RunRole {
        self.blocks.role()
    }

    /// Whether several processes go on with the results of all.
    pub fn is_shared(self) -> bool {
        self.role().processes > 1
    }

    /// The same without blocks, unless several processes go on with the results of all: for loops of which nothing is
    /// worth keeping.
    pub fn without_storage(self) -> Run<'a> {
        if self.is_shared() {
            self
        } else {
            Run::alone(self.progress)
        }
    }

    /// Number of the items of a loop that this process computes: those of a part if the result is made elsewhere.
    pub fn own_items(self, items: usize) -> usize {
        let role = self.role();
        if role.assembles {
            items
        } else {
            items.div_ceil(role.parts.max(1))
        }
    }

    /// Computes the items of a loop block by block, except blocks that are stored or that others
    /// compute; all of them in order, or `None` if the result is made elsewhere. `compute` gets the numbers of items,
    /// ascending, and advances the progress by one per item.
    ///
    /// # Errors
    /// [`Cancelled`]; finished blocks are stored then.
    pub fn resumed<R: Record>(
        self,
        stage: RunStage,
        size: LoopSize,
        mut compute: impl FnMut(&[usize]) -> Result<Vec<R>, Cancelled>,
    ) -> Result<Option<Vec<R>>, Cancelled> {
        let role = self.role();
        let division = Division::new(size, role);
        let mut items = ItemList::new(if role.assembles { size.items } else { 0 });
        let mut own = Vec::new();
        let mut given = GivenBlocks::new(self, stage, division, size.blocks_at_once());
        while let Some(blocks) = given.next()? {
            for block in self.stored_or_computed(stage, blocks, &mut compute)? {
                if role.processes > 1 {
                    write_block(block.number, &bytes_of(&block.values), &mut own);
                }
                if role.assembles {
                    items.put(&block.items, block.values);
                }
            }
        }
        if !role.assembles {
            return Ok(None);
        }
        for (number, bytes) in blocks_in(&self.blocks.gather(stage, own)?) {
            let numbers: Vec<usize> = division.of(number).collect();
            if let Some(values) = decoded(bytes, numbers.len()) {
                items.put(&numbers, values);
            }
        }
        for block in 0..division.blocks() {
            let numbers: Vec<usize> = division.of(block).collect();
            if items.has(&numbers) {
                continue;
            }
            // What others did not deliver is computed here.
            let stored = self.stored(stage, block, numbers.len());
            let values = stored.map_or_else(|| compute(&numbers), Ok)?;
            items.put(&numbers, values);
        }
        items.complete().map(Some)
    }

    /// The items of a loop whose results all processes need to go on: as [`resumed`](Run::resumed) in the order of the
    /// program, in blocks of `least` items or more, of which a process computes a few for each of its threads at
    /// once; all at once where no other process shares such loops.
    /// `compute` gets the numbers of items, ascending.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn shared<R: Record>(
        self,
        (items, least): (usize, usize),
        mut compute: impl FnMut(&[usize]) -> Result<Vec<R>, Cancelled>,
    ) -> Result<Vec<R>, Cancelled> {
        let numbers = || (0..items).collect::<Vec<usize>>();
        if !self.is_shared() {
            return compute(&numbers());
        }
        let size = LoopSize {
            items,
            block: least,
            at_once: least * BLOCKS_AT_ONCE * rayon::current_num_threads().max(1),
        };
        let stage = self.blocks.loop_stage();
        match self.resumed(stage, size.of_shared_loop(), &mut compute)? {
            Some(values) => Ok(values),
            None => compute(&numbers()),
        }
    }

    /// Items that stay with the process that computed them, while all processes get a summary of each: for
    /// data too large for one memory. `keep` gets the items of this process with their numbers, ascending,
    /// and returns their summaries. In blocks of `size.block` items or more; the items are stored.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn distributed<R: Record, S: Record>(
        self,
        size: LoopSize,
        mut compute: impl FnMut(&[usize]) -> Result<Vec<R>, Cancelled>,
        mut keep: impl FnMut(usize, R) -> S,
    ) -> Result<Vec<S>, Cancelled> {
        let mut summaries = ItemList::<S>::new(size.items);
        if !self.is_shared() {
            let numbers: Vec<usize> = (0..size.items).collect();
            for numbers in numbers.chunks(size.at_once.max(1)) {
                let values = compute(numbers)?.into_iter().zip(numbers);
                let kept = values.map(|(value, &item)| keep(item, value)).collect();
                summaries.put(numbers, kept);
            }
            return summaries.complete();
        }
        let (stage, size) = (self.blocks.loop_stage(), size.of_shared_loop());
        let division = Division::new(size, self.role());
        let mut own = Vec::new();
        let mut given = GivenBlocks::new(self, stage, division, size.blocks_at_once());
        while let Some(blocks) = given.next()? {
            for block in self.stored_or_computed(stage, blocks, &mut compute)? {
                let values = block.items.iter().zip(block.values);
                let kept: Vec<S> = values.map(|(&item, value)| keep(item, value)).collect();
                write_block(block.number, &bytes_of(&kept), &mut own);
                summaries.put(&block.items, kept);
            }
        }
        for (number, bytes) in blocks_in(&self.blocks.gather(stage, own)?) {
            let numbers: Vec<usize> = division.of(number).collect();
            if let Some(kept) = decoded(bytes, numbers.len()) {
                summaries.put(&numbers, kept);
            }
        }
        summaries.complete()
    }

    /// Blocks with the items that are stored; others are computed, all at once, and stored.
    fn stored_or_computed<R: Record>(
        self,
        stage: RunStage,
        mut blocks: Vec<ItemBlock<R>>,
        compute: &mut impl FnMut(&[usize]) -> Result<Vec<R>, Cancelled>,
    ) -> Result<Vec<ItemBlock<R>>, Cancelled> {
        blocks.retain(|block| !block.items.is_empty());
        let mut missing: Vec<(usize, usize)> = Vec::new();
        for (place, block) in blocks.iter_mut().enumerate() {
            match self.stored(stage, block.number, block.items.len()) {
                Some(stored) => {
                    self.progress.advance(stored.len() as u64)?;
                    block.values = stored;
                }
                None => missing.extend(block.items.iter().map(|&item| (item, place))),
            }
        }
        if missing.is_empty() {
            return Ok(blocks);
        }
        // Blocks of several parts interleave.
        missing.sort_unstable();
        let numbers: Vec<usize> = missing.iter().map(|m| m.0).collect();
        let mut is_new = vec![false; blocks.len()];
        for (value, (_, place)) in compute(&numbers)?.into_iter().zip(missing) {
            blocks[place].values.push(value);
            is_new[place] = true;
        }
        for (block, _) in blocks.iter().zip(is_new).filter(|(_, is_new)| *is_new) {
            self.save(stage, block);
        }
        Ok(blocks)
    }

    /// The items of a block that is stored.
    fn stored<R: Record>(self, stage: RunStage, block: usize, items: usize) -> Option<Vec<R>> {
        decoded(&self.blocks.load(stage, block)?, items)
    }

    fn save<R: Record>(self, stage: RunStage, block: &ItemBlock<R>) {
        if self.role().is_kept && block.values.iter().all(R::is_complete) {
            let bytes = bytes_of(&block.values);
            self.blocks.save(stage, block.number, &bytes);
        }
    }
}

/// A digest of numbers, for [`Blocks::rely_on`]: the same only for the same bits, but for chance (64-bit FNV-1a).
pub fn digest(numbers: impl Iterator<Item = f64>) -> u64 {
    let bytes = numbers.flat_map(|x| x.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// The blocks of a stage that a process is given, some at a time.
struct GivenBlocks<'a> {
    blocks: &'a dyn Blocks,
    stage: RunStage,
    division: Division,
    left: Range<usize>,
    most: usize,
}

impl<'a> GivenBlocks<'a> {
    fn new(run: Run<'a>, stage: RunStage, division: Division, most: usize) -> GivenBlocks<'a> {
        GivenBlocks {
            blocks: run.blocks,
            stage,
            division,
            left: 0..division.blocks(),
            most,
        }
    }

    /// The next of them, with their items; `None` when there are no more.
    fn next<R>(&mut self) -> Result<Option<Vec<ItemBlock<R>>>, Cancelled> {
        let (left, most) = (self.left.clone(), self.most);
        let numbers = self.blocks.next(self.stage, self.division, left, most)?;
        let Some(last) = numbers.last() else {
            return Ok(None);
        };
        self.left.start = last + 1;
        let block = |number: usize| ItemBlock {
            number,
            items: self.division.of(number).collect(),
            values: Vec::new(),
        };
        Ok(Some(numbers.into_iter().map(block).collect()))
    }
}

/// A block with the numbers of its items, and the items themselves once they are known.
struct ItemBlock<R> {
    number: usize,
    items: Vec<usize>,
    values: Vec<R>,
}

/// Appends a block with its number and length, for [`Blocks::gather`].
pub fn write_block(number: usize, content: &[u8], bytes: &mut Vec<u8>) {
    (number as u64).write(bytes);
    (content.len() as u64).write(bytes);
    bytes.extend(content);
}

/// The blocks that each process gave, written by [`write_block`]; those behind one that is cut off are left out.
fn blocks_in(processes: &[Vec<u8>]) -> impl Iterator<Item = (usize, &[u8])> {
    processes.iter().flat_map(|bytes| {
        let mut rest = &bytes[..];
        std::iter::from_fn(move || {
            let mut reader = RecordReader::new(rest);
            let (number, length) = (reader.u64()?, reader.u64()?);
            let (content, next) = reader.rest().split_at_checked(length as usize)?;
            rest = next;
            Some((number as usize, content))
        })
    })
}

/// Items that are there so far.
struct ItemList<R>(Vec<Option<R>>);

impl<R> ItemList<R> {
    fn new(items: usize) -> ItemList<R> {
        ItemList((0..items).map(|_| None).collect())
    }

    fn put(&mut self, places: &[usize], values: Vec<R>) {
        for (&place, value) in places.iter().zip(values) {
            self.0[place] = Some(value);
        }
    }

    fn has(&self, places: &[usize]) -> bool {
        places.iter().all(|&place| self.0[place].is_some())
    }

    /// All of them. A process that does not deliver its own has ended, and so do all.
    fn complete(self) -> Result<Vec<R>, Cancelled> {
        let items: Option<Vec<R>> = self.0.into_iter().collect();
        items.ok_or(Cancelled)
    }
}

fn bytes_of<R: Record>(items: &[R]) -> Vec<u8> {
    let mut bytes = Vec::new();
    items.iter().for_each(|item| item.write(&mut bytes));
    bytes
}

fn decoded<R: Record>(bytes: &[u8], items: usize) -> Option<Vec<R>> {
    let mut reader = RecordReader::new(bytes);
    let values = (0..items).map(|_| R::read(&mut reader)).collect();
    if reader.rest().is_empty() {
        values
    } else {
        None
    }
}
