//! Long work in blocks that are stored when they are done, and that others may compute.
//!
//! Work is a list of items (rows, groups of points) in blocks with numbers. A [`Journal`] stores finished
//! blocks, so that they need not be computed again after an interruption, and says which blocks this
//! process computes: all of them, or those of one part where several processes divide the work, by
//! numbers given in advance (shards) or handed out one by one (ranks of MPI). [`resumed`] is the
//! one loop that all work in blocks uses.

use crate::progress::{Cancelled, Progress};
use std::ops::Range;

/// The computation that a block belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum JournalStage {
    /// Rows of form factors by rays or item buffers.
    Rows,
    /// Upper rows of exchange areas by formulas.
    Pairs,
    /// Close pairs by formulas, for rows by rays.
    Formulas,
    /// Irradiance at points: the first rays of each.
    Points,
}

/// Storage of finished blocks, and who computes which.
///
/// A block depends only on the scene, the options, the number of parts and its number, so a result
/// assembled from stored blocks is the same to the bit, whoever computed them. The implementer has to
/// make sure that blocks are returned undamaged, and only for the same scene and options.
///
/// The methods with a default serve a single process. A process that shares the work with others
/// overrides [`parts`](Journal::parts), [`next`](Journal::next) and either
/// [`assembles`](Journal::assembles) (it computes its blocks, and the result is made elsewhere) or
/// [`await_others`](Journal::await_others) (it goes on with the blocks of all).
pub trait Journal: Sync {
    /// The bytes stored for a block, if any.
    fn load(&self, stage: JournalStage, block: usize) -> Option<Vec<u8>>;

    /// Stores a block. Failure is not an error here; the journal reports it to its owner.
    fn save(&self, stage: JournalStage, block: usize, bytes: &[u8]);

    /// Whether anything is stored at all.
    fn is_kept(&self) -> bool {
        true
    }

    /// In how many parts the work is divided, at least 1: see [`Division`].
    fn parts(&self) -> usize {
        1
    }

    /// The next block for this process, in the range of those that it was not given yet; `None` when no
    /// more are left for it. Numbers ascend.
    ///
    /// # Errors
    /// [`Cancelled`] if the work is to end after the last block.
    fn next(&self, _stage: JournalStage, blocks: Range<usize>) -> Result<Option<usize>, Cancelled> {
        Ok((!blocks.is_empty()).then_some(blocks.start))
    }

    /// Whether this process makes the result from the blocks of all. One that does not computes its
    /// blocks of all stages that do not depend on one another, and ends without a result.
    fn assembles(&self) -> bool {
        true
    }

    /// Says on what the blocks of a stage depend besides the scene and the options, as a
    /// [`digest`]: what each process computed itself, and may have computed otherwise on another
    /// machine.
    ///
    /// # Errors
    /// [`Cancelled`] if that of others is another: their blocks do not fit. The journal reports it to
    /// its owner.
    fn rely_on(&self, _stage: JournalStage, _digest: u64) -> Result<(), Cancelled> {
        Ok(())
    }

    /// Waits until [`load`](Journal::load) has all blocks of a stage that others compute.
    ///
    /// # Errors
    /// [`Cancelled`].
    fn await_others(&self, _stage: JournalStage, _blocks: usize) -> Result<(), Cancelled> {
        Ok(())
    }
}

/// A digest of numbers, for [`Journal::rely_on`]: the same only for the same bits, but for chance (64-bit FNV-1a).
pub fn digest(numbers: impl Iterator<Item = f64>) -> u64 {
    let bytes = numbers.flat_map(|x| x.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Stores nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoJournal;

impl Journal for NoJournal {
    fn load(&self, _: JournalStage, _: usize) -> Option<Vec<u8>> {
        None
    }

    fn save(&self, _: JournalStage, _: usize, _: &[u8]) {}

    fn is_kept(&self) -> bool {
        false
    }
}

/// An item that a journal can store.
pub trait Record: Sized {
    /// Appends the item's bytes.
    fn write(&self, bytes: &mut Vec<u8>);

    /// The inverse of `write`; `None` if the bytes are invalid.
    fn read(bytes: &mut RecordReader) -> Option<Self>;

    /// Whether it is complete; blocks with incomplete items are not stored.
    fn is_complete(&self) -> bool {
        true
    }
}

/// Items in blocks.
///
/// Of one part, a block is so many items in a row. Of several, the items are dealt like cards: part k of
/// n has the items k, k + n, k + 2 n, ..., so that all have as much to do as nearly as possible, and a
/// block is so many of these. Block b belongs to part b mod n.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Division {
    /// Number of items.
    pub items: usize,
    /// Most items of a block.
    pub size: usize,
    /// Number of parts.
    pub parts: usize,
}

impl Division {
    /// `items` in blocks of `size`, in the parts of a journal.
    pub fn new(items: usize, size: usize, journal: &dyn Journal) -> Division {
        Division {
            items,
            size: size.max(1),
            parts: journal.parts().max(1),
        }
    }

    /// Number of blocks. Some of the last ones are empty if the items do not suffice for all parts.
    pub fn blocks(&self) -> usize {
        self.items.div_ceil(self.size * self.parts) * self.parts
    }

    /// The items of a block, ascending.
    pub fn of(&self, block: usize) -> impl Iterator<Item = usize> + use<> {
        let start = block / self.parts * self.parts * self.size;
        let end = (start + self.parts * self.size).min(self.items);
        (start + block % self.parts..end).step_by(self.parts)
    }

    /// Number of items that a process computes: those of a part if the result is made elsewhere.
    pub fn own_items(&self, journal: &dyn Journal) -> usize {
        if journal.assembles() {
            self.items
        } else {
            self.items.div_ceil(self.parts)
        }
    }
}

/// Computes the items of a division block by block, except blocks that the journal holds or others
/// compute; all of them in order, or `None` if the result is made elsewhere. `compute` gets the numbers of items,
/// ascending, and advances `progress` by one per item.
///
/// # Errors
/// [`Cancelled`]; finished blocks are in the journal then.
pub fn resumed<R: Record>(
    journal: &dyn Journal,
    stage: JournalStage,
    (items, size): (usize, usize),
    progress: &Progress,
    mut compute: impl FnMut(&[usize]) -> Result<Vec<R>, Cancelled>,
) -> Result<Option<Vec<R>>, Cancelled> {
    let division = Division::new(items, size, journal);
    let mut all = AllItems::new(if journal.assembles() { items } else { 0 });
    let mut left = 0..division.blocks();
    while let Some(block) = journal.next(stage, left.clone())? {
        left.start = block + 1;
        let wanted: Vec<usize> = division.of(block).collect();
        if wanted.is_empty() {
            continue;
        }
        let found = match stored(journal, stage, block, wanted.len()) {
            Some(known) => {
                progress.advance(wanted.len() as u64)?;
                known
            }
            None => {
                let found = compute(&wanted)?;
                save(journal, stage, block, &found);
                found
            }
        };
        if journal.assembles() {
            all.put(&wanted, found);
        }
    }
    if !journal.assembles() {
        return Ok(None);
    }
    journal.await_others(stage, division.blocks())?;
    for block in 0..division.blocks() {
        let wanted: Vec<usize> = division.of(block).collect();
        if all.has(&wanted) {
            continue;
        }
        // What others did not deliver is computed here.
        let known = stored(journal, stage, block, wanted.len());
        let found = known.map_or_else(|| compute(&wanted), Ok)?;
        all.put(&wanted, found);
    }
    Ok(Some(all.0.into_iter().flatten().collect()))
}

/// Items that are there so far.
struct AllItems<R>(Vec<Option<R>>);

impl<R> AllItems<R> {
    fn new(items: usize) -> AllItems<R> {
        AllItems((0..items).map(|_| None).collect())
    }

    fn put(&mut self, places: &[usize], found: Vec<R>) {
        for (&place, item) in places.iter().zip(found) {
            self.0[place] = Some(item);
        }
    }

    fn has(&self, places: &[usize]) -> bool {
        places.iter().all(|&place| self.0[place].is_some())
    }
}

/// The items of a block that the journal holds.
fn stored<R: Record>(
    journal: &dyn Journal,
    stage: JournalStage,
    block: usize,
    items: usize,
) -> Option<Vec<R>> {
    decoded(&journal.load(stage, block)?, items)
}

fn save<R: Record>(journal: &dyn Journal, stage: JournalStage, block: usize, found: &[R]) {
    if journal.is_kept() && found.iter().all(R::is_complete) {
        let mut bytes = Vec::new();
        found.iter().for_each(|item| item.write(&mut bytes));
        journal.save(stage, block, &bytes);
    }
}

fn decoded<R: Record>(bytes: &[u8], rows: usize) -> Option<Vec<R>> {
    let mut reader = RecordReader { bytes };
    let found = (0..rows).map(|_| R::read(&mut reader)).collect();
    if reader.bytes.is_empty() { found } else { None }
}

/// Reads numbers from the front of a byte slice.
pub struct RecordReader<'a> {
    bytes: &'a [u8],
}

impl RecordReader<'_> {
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.bytes.split_first_chunk()?;
        self.bytes = rest;
        Some(*first)
    }

    /// Four bytes, little-endian.
    pub fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    /// Eight bytes, little-endian.
    pub fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// A number of single precision.
    pub fn f32(&mut self) -> Option<f32> {
        self.array().map(f32::from_le_bytes)
    }

    /// A number of double precision.
    pub fn f64(&mut self) -> Option<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// A list written by [`write_list`]; `None`, before anything is allocated, for a count that the
    /// bytes cannot hold.
    pub fn list<T>(&mut self, read: impl Fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let count = self.u32()? as usize;
        if count > self.bytes.len() {
            return None;
        }
        (0..count).map(|_| read(self)).collect()
    }
}

/// Appends a count and then each item by `write`.
pub fn write_list<T>(items: &[T], bytes: &mut Vec<u8>, write: impl Fn(&T, &mut Vec<u8>)) {
    bytes.extend((items.len() as u32).to_le_bytes());
    items.iter().for_each(|item| write(item, bytes));
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;
    use std::sync::Mutex;

    const STAGE: JournalStage = JournalStage::Pairs;

    /// Stores blocks in memory, as one of several processes.
    #[derive(Default)]
    struct Memory {
        blocks: Mutex<HashMap<(JournalStage, usize), Vec<u8>>>,
        /// Which part of how many this is; 0 assembles all.
        part: usize,
        parts: usize,
    }

    impl Memory {
        fn whole(parts: usize) -> Memory {
            Memory {
                parts,
                ..Memory::default()
            }
        }
    }

    impl Journal for Memory {
        fn load(&self, stage: JournalStage, block: usize) -> Option<Vec<u8>> {
            self.blocks.lock().unwrap().get(&(stage, block)).cloned()
        }

        fn save(&self, stage: JournalStage, block: usize, bytes: &[u8]) {
            let mut blocks = self.blocks.lock().unwrap();
            blocks.insert((stage, block), bytes.to_vec());
        }

        fn parts(&self) -> usize {
            self.parts.max(1)
        }

        fn next(
            &self,
            _: JournalStage,
            mut blocks: Range<usize>,
        ) -> Result<Option<usize>, Cancelled> {
            let is_mine = |b: &usize| self.part == 0 || b % self.parts == self.part - 1;
            Ok(blocks.find(is_mine))
        }

        fn assembles(&self) -> bool {
            self.part == 0
        }
    }

    #[derive(Clone, Debug, PartialEq)]
    struct Item(Vec<f64>);

    impl Record for Item {
        fn write(&self, bytes: &mut Vec<u8>) {
            write_list(&self.0, bytes, |x, bytes| bytes.extend(x.to_le_bytes()));
        }

        fn read(bytes: &mut RecordReader) -> Option<Item> {
            bytes.list(RecordReader::f64).map(Item)
        }
    }

    fn item(i: usize) -> Item {
        Item((i..17).map(|j| 1.0 / (1 + i + j) as f64).collect())
    }

    /// All items, and how many of them had to be computed.
    fn run(journal: &Memory) -> (Option<Vec<Item>>, usize) {
        let (progress, mut computed) = (Progress::new(), 0);
        let compute = |wanted: &[usize]| {
            computed += wanted.len();
            Ok(wanted.iter().map(|&i| item(i)).collect())
        };
        let items = resumed(journal, STAGE, (17, 3), &progress, compute).unwrap();
        if items.is_some() {
            assert_eq!(progress.done() + computed as u64, 17);
        }
        (items, computed)
    }

    fn whole() -> Option<Vec<Item>> {
        Some((0..17).map(item).collect())
    }

    #[test]
    fn what_is_kept_is_not_computed_again() {
        let journal = Memory::default();
        assert_eq!(run(&journal), (whole(), 17));
        assert_eq!(run(&journal), (whole(), 0));
        journal.blocks.lock().unwrap().remove(&(STAGE, 1));
        assert_eq!(run(&journal), (whole(), 3));
    }

    #[test]
    fn parts_together_are_the_whole() {
        for parts in [1, 2, 3, 7, 17, 40] {
            let all = Memory::whole(parts);
            let mut computed = 0;
            for part in 1..=parts {
                let journal = Memory {
                    part,
                    ..Memory::whole(parts)
                };
                let (items, own) = run(&journal);
                assert_eq!(items, None);
                // Nobody has more than one item more than another.
                assert!(
                    (17 / parts..=17usize.div_ceil(parts)).contains(&own),
                    "{own}"
                );
                assert_eq!(run(&journal), (None, 0));
                computed += own;
                let blocks = journal.blocks.into_inner().unwrap();
                all.blocks.lock().unwrap().extend(blocks);
            }
            assert_eq!(computed, 17);
            assert_eq!(run(&all), (whole(), 0));
        }
    }

    /// One of two processes that both go on with the blocks of both.
    struct Rank<'a> {
        own: Memory,
        other: &'a Memory,
    }

    impl Journal for Rank<'_> {
        fn load(&self, stage: JournalStage, block: usize) -> Option<Vec<u8>> {
            self.own.load(stage, block)
        }

        fn save(&self, stage: JournalStage, block: usize, bytes: &[u8]) {
            self.own.save(stage, block, bytes);
        }

        fn parts(&self) -> usize {
            self.own.parts()
        }

        fn next(
            &self,
            stage: JournalStage,
            blocks: Range<usize>,
        ) -> Result<Option<usize>, Cancelled> {
            self.own.next(stage, blocks)
        }

        fn await_others(&self, _: JournalStage, blocks: usize) -> Result<(), Cancelled> {
            assert_eq!(blocks, 6);
            let others = self.other.blocks.lock().unwrap().clone();
            self.own.blocks.lock().unwrap().extend(others);
            Ok(())
        }
    }

    #[test]
    fn ranks_go_on_with_the_blocks_of_all() {
        let other = Memory {
            part: 1,
            ..Memory::whole(2)
        };
        assert_eq!(run(&other), (None, 9));
        let own = Memory {
            part: 2,
            ..Memory::whole(2)
        };
        let rank = Rank { own, other: &other };
        let mut computed = 0;
        let compute = |wanted: &[usize]| {
            computed += wanted.len();
            Ok(wanted.iter().map(|&i| item(i)).collect())
        };
        let items = resumed(&rank, STAGE, (17, 3), &Progress::new(), compute).unwrap();
        assert_eq!((items, computed), (whole(), 8));
    }

    #[test]
    fn digests_tell_bits_apart() {
        assert_eq!(digest([].into_iter()), 0xcbf2_9ce4_8422_2325);
        let of = |x: f64| digest([1.0, x].into_iter());
        assert_eq!(of(2.0), of(2.0));
        assert_ne!(of(2.0), of(2.0_f64.next_up()));
        assert_ne!(of(0.0), of(-0.0));
    }

    #[test]
    fn bytes_that_are_no_items_are_not_taken() {
        let mut good = Vec::new();
        (0..3).for_each(|i| item(i).write(&mut good));
        let long = [&good[..], &[0]].concat();
        let endless = u32::MAX.to_le_bytes().repeat(3);
        for bytes in [&good[..good.len() - 1], &long, &endless, &[], &[1, 2, 3]] {
            let journal = Memory::default();
            journal.save(STAGE, 0, bytes);
            assert_eq!(run(&journal).1, 17);
        }
    }
}
