//! Long work in blocks that are stored when they are done, and that others may compute.
//!
//! Work is a list of items (rows, groups of points) in blocks with numbers. A [`Journal`] stores finished
//! blocks, so that they need not be computed again after an interruption, and says which blocks this
//! process computes: all of them, or those of one part where several processes divide the work, by
//! numbers given in advance (shards) or handed out one by one (ranks of MPI). [`resumed`] is the
//! one loop that all work in blocks uses.

mod record;
mod together;

use crate::progress::{Cancelled, Progress};
pub use record::{Record, RecordReader, write_list};
use std::ops::Range;
pub use together::{CountedJournal, together};

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
    /// One of the loops whose results all processes need to go on, by its place in the order of the
    /// program: see [`Journal::step`].
    Step(u32),
}

/// How many of the blocks that are left one of several processes is given that asks for `most`: fewer toward
/// the end, so that none has much to do when there is no more for others (guided self-scheduling: Polychronopoulos
/// and Kuck, IEEE Transactions on Computers 36, 1987).
pub fn guided_share(left: usize, processes: usize, most: usize) -> usize {
    left.div_ceil(2 * processes.max(1)).min(most)
}

/// How work is divided, stored, counted and stopped.
pub type Work<'a> = (&'a dyn Journal, &'a Progress);

/// Finished blocks by their numbers.
pub type Blocks = Vec<(usize, Vec<u8>)>;

/// Storage of finished blocks, and who computes which.
///
/// A block depends only on the scene, the options, the number of parts and its number, so a result
/// assembled from stored blocks is the same to the bit, whoever computed them. The implementer has to
/// make sure that blocks are returned undamaged, and only for the same scene and options.
///
/// The methods with a default serve a single process. There are two ways to share the work:
///
/// | | overrides |
/// |---|---|
/// | parts that never meet: each process computes its blocks and ends, one assembles them afterwards | [`parts`](Journal::parts), [`next`](Journal::next), [`assembles`](Journal::assembles) |
/// | processes that talk to each other, and all go on with the blocks of all | [`processes`](Journal::processes), [`has_steps`](Journal::has_steps), [`step`](Journal::step), [`next`](Journal::next), [`of_others`](Journal::of_others), [`all_gather`](Journal::all_gather) |
///
/// The latter run the same program on the same data, each of them as if it were alone, and come to
/// the same loops in the same order.
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

    /// Number of processes that talk to each other, at least 1.
    fn processes(&self) -> usize {
        1
    }

    /// Whether loops are divided whose results all processes need to go on: by [`shared`] and
    /// [`distributed`]. Otherwise each process does them by itself.
    fn has_steps(&self) -> bool {
        false
    }

    /// The stage of the next of these loops.
    fn step(&self) -> JournalStage {
        JournalStage::Step(0)
    }

    /// The next blocks for this process, at most `most` (1 or more), in the range `left` of those that it was
    /// not given yet; none when no more are left for it. Numbers ascend.
    ///
    /// # Errors
    /// [`Cancelled`] if the work is to end after the last blocks.
    fn next(
        &self,
        _stage: JournalStage,
        _division: Division,
        left: Range<usize>,
        most: usize,
    ) -> Result<Vec<usize>, Cancelled> {
        Ok(left.take(most).collect())
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

    /// Waits for the blocks of a stage that others compute, and returns them, except those that
    /// [`load`](Journal::load) has. `own` are the blocks of this process, of which nothing is given if
    /// [`processes`](Journal::processes) is 1.
    ///
    /// # Errors
    /// [`Cancelled`].
    fn of_others(&self, _stage: JournalStage, _own: Blocks) -> Result<Blocks, Cancelled> {
        Ok(Blocks::new())
    }

    /// Says that what follows, until this process asks for something, is its part of a work that is divided though
    /// not in blocks: for journals that measure what is not.
    fn begins_part(&self) {}

    /// The bytes that each process gives, in their order.
    ///
    /// # Errors
    /// [`Cancelled`].
    fn all_gather(&self, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Cancelled> {
        Ok(vec![own])
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

/// How many items of a loop go together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoopSize {
    /// Number of items.
    pub items: usize,
    /// Items of a block, which is stored or given to a process as a whole. It must not depend on the
    /// machine, for another may go on with the work.
    pub block: usize,
    /// Items that a process computes at once, in whole blocks: enough that its threads, or its graphics
    /// card, are busy.
    pub at_once: usize,
}

impl LoopSize {
    /// The same with no more blocks than a loop that all processes share should have.
    fn in_steps(self) -> LoopSize {
        let block = self.block.max(self.items.div_ceil(MOST_BLOCKS)).max(1);
        LoopSize {
            block,
            at_once: self.at_once.max(block),
            ..self
        }
    }

    /// Most blocks that a process computes at once.
    fn blocks_at_once(&self) -> usize {
        (self.at_once / self.block.max(1)).max(1)
    }
}

/// Computes the items of a loop block by block, except blocks that the journal holds or others
/// compute; all of them in order, or `None` if the result is made elsewhere. `compute` gets the numbers of items,
/// ascending, and advances `progress` by one per item.
///
/// # Errors
/// [`Cancelled`]; finished blocks are in the journal then.
pub fn resumed<R: Record>(
    journal: &dyn Journal,
    stage: JournalStage,
    size: LoopSize,
    progress: &Progress,
    mut compute: impl FnMut(&[usize]) -> Result<Vec<R>, Cancelled>,
) -> Result<Option<Vec<R>>, Cancelled> {
    let division = Division::new(size.items, size.block, journal);
    let mut all = AllItems::new(if journal.assembles() { size.items } else { 0 });
    let mut own = Blocks::new();
    let mut given = GivenBlocks::new(journal, stage, division, size.blocks_at_once());
    while let Some(blocks) = given.next()? {
        for block in known_or_computed(journal, stage, blocks, progress, &mut compute)? {
            if journal.assembles() && journal.processes() > 1 {
                own.push((block.number, bytes_of(&block.found)));
            }
            if journal.assembles() {
                all.put(&block.items, block.found);
            }
        }
    }
    if !journal.assembles() {
        return Ok(None);
    }
    for (block, bytes) in journal.of_others(stage, own)? {
        let wanted: Vec<usize> = division.of(block).collect();
        if let Some(found) = decoded(&bytes, wanted.len()) {
            all.put(&wanted, found);
        }
    }
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

/// Most blocks of a loop that all processes share: enough for 1,000 of them to be busy to the end.
const MOST_BLOCKS: usize = 1 << 13;

/// Most blocks of such a loop that a process computes at once, for each of its threads: asking for one after
/// the other would take as long as computing them.
const BLOCKS_AT_ONCE: usize = 8;

/// The items of a loop whose results all processes need to go on: as [`resumed`] in the order of the
/// program, in blocks of `least` items or more, of which a process computes a few for each of its threads at
/// once; all at once where the journal does not divide such loops.
/// `compute` gets the numbers of items, ascending.
///
/// # Errors
/// [`Cancelled`].
pub fn shared<R: Record>(
    journal: &dyn Journal,
    (items, least): (usize, usize),
    progress: &Progress,
    mut compute: impl FnMut(&[usize]) -> Result<Vec<R>, Cancelled>,
) -> Result<Vec<R>, Cancelled> {
    let all = || (0..items).collect::<Vec<usize>>();
    if !journal.has_steps() {
        return compute(&all());
    }
    let size = LoopSize {
        items,
        block: least,
        at_once: least * BLOCKS_AT_ONCE * rayon::current_num_threads().max(1),
    }
    .in_steps();
    match resumed(journal, journal.step(), size, progress, &mut compute)? {
        Some(found) => Ok(found),
        None => compute(&all()),
    }
}

/// Items that stay with the process that computed them, while all processes get a summary of each: for
/// data too large for one memory. `keep` gets the items of this process with their numbers, ascending,
/// and returns their summaries. In blocks of `size.block` items or more; the journal stores the items.
///
/// # Errors
/// [`Cancelled`].
pub fn distributed<R: Record, S: Record>(
    journal: &dyn Journal,
    size: LoopSize,
    progress: &Progress,
    mut compute: impl FnMut(&[usize]) -> Result<Vec<R>, Cancelled>,
    mut keep: impl FnMut(usize, R) -> S,
) -> Result<Vec<S>, Cancelled> {
    let mut all = AllItems::<S>::new(size.items);
    if !journal.has_steps() {
        let numbers: Vec<usize> = (0..size.items).collect();
        for wanted in numbers.chunks(size.at_once.max(1)) {
            let found = compute(wanted)?;
            let kept = wanted.iter().zip(found).map(|(&item, row)| keep(item, row));
            all.put(wanted, kept.collect());
        }
        return all.complete();
    }
    let (stage, size) = (journal.step(), size.in_steps());
    let division = Division::new(size.items, size.block, journal);
    let mut own = Vec::new();
    let mut given = GivenBlocks::new(journal, stage, division, size.blocks_at_once());
    while let Some(blocks) = given.next()? {
        for block in known_or_computed(journal, stage, blocks, progress, &mut compute)? {
            let found = block.items.iter().zip(block.found);
            let summaries: Vec<S> = found.map(|(&item, row)| keep(item, row)).collect();
            own.extend((block.number as u64).to_le_bytes());
            own.extend(bytes_of(&summaries));
            all.put(&block.items, summaries);
        }
    }
    for bytes in journal.all_gather(own)? {
        let mut reader = RecordReader { bytes: &bytes };
        while let Some(block) = reader.u64() {
            let wanted: Vec<usize> = division.of(block as usize).collect();
            let read = wanted.iter().map(|_| S::read(&mut reader));
            let Some(found) = read.collect() else { break };
            all.put(&wanted, found);
        }
    }
    all.complete()
}

/// The blocks of a stage that a process is given, some at a time.
struct GivenBlocks<'a> {
    journal: &'a dyn Journal,
    stage: JournalStage,
    division: Division,
    left: Range<usize>,
    most: usize,
}

impl<'a> GivenBlocks<'a> {
    fn new(
        journal: &'a dyn Journal,
        stage: JournalStage,
        division: Division,
        most: usize,
    ) -> GivenBlocks<'a> {
        GivenBlocks {
            journal,
            stage,
            division,
            left: 0..division.blocks(),
            most,
        }
    }

    /// The next of them, with their items; `None` when there are no more.
    fn next<R>(&mut self) -> Result<Option<Vec<ItemBlock<R>>>, Cancelled> {
        let (left, most) = (self.left.clone(), self.most);
        let numbers = self.journal.next(self.stage, self.division, left, most)?;
        let Some(last) = numbers.last() else {
            return Ok(None);
        };
        self.left.start = last + 1;
        let block = |number: usize| ItemBlock {
            number,
            items: self.division.of(number).collect(),
            found: Vec::new(),
        };
        Ok(Some(numbers.into_iter().map(block).collect()))
    }
}

/// A block with the numbers of its items, and the items themselves once they are known.
struct ItemBlock<R> {
    number: usize,
    items: Vec<usize>,
    found: Vec<R>,
}

/// Blocks with the items that the journal holds; others are computed, all at once, and stored in it.
fn known_or_computed<R: Record>(
    journal: &dyn Journal,
    stage: JournalStage,
    mut blocks: Vec<ItemBlock<R>>,
    progress: &Progress,
    compute: &mut impl FnMut(&[usize]) -> Result<Vec<R>, Cancelled>,
) -> Result<Vec<ItemBlock<R>>, Cancelled> {
    blocks.retain(|block| !block.items.is_empty());
    let mut missing: Vec<(usize, usize)> = Vec::new();
    for (place, block) in blocks.iter_mut().enumerate() {
        match stored(journal, stage, block.number, block.items.len()) {
            Some(known) => {
                progress.advance(known.len() as u64)?;
                block.found = known;
            }
            None => missing.extend(block.items.iter().map(|&item| (item, place))),
        }
    }
    if missing.is_empty() {
        return Ok(blocks);
    }
    // Blocks of several parts interleave.
    missing.sort_unstable();
    let wanted: Vec<usize> = missing.iter().map(|m| m.0).collect();
    let mut is_new = vec![false; blocks.len()];
    for (found, (_, place)) in compute(&wanted)?.into_iter().zip(missing) {
        blocks[place].found.push(found);
        is_new[place] = true;
    }
    for (block, _) in blocks.iter().zip(is_new).filter(|(_, is_new)| *is_new) {
        save(journal, stage, block.number, &block.found);
    }
    Ok(blocks)
}

/// The blocks of all processes, through [`Journal::all_gather`].
///
/// # Errors
/// [`Cancelled`].
pub fn exchanged(journal: &dyn Journal, own: Blocks) -> Result<Blocks, Cancelled> {
    let mut bytes = Vec::new();
    for (block, content) in own {
        bytes.extend((block as u64).to_le_bytes());
        bytes.extend((content.len() as u64).to_le_bytes());
        bytes.extend(content);
    }
    let mut all = Blocks::new();
    for bytes in journal.all_gather(bytes)? {
        let mut rest = &bytes[..];
        while let Some((head, behind)) = rest.split_first_chunk::<16>() {
            let number = |at: usize| {
                let word = head[at..].first_chunk().copied().unwrap_or_default();
                u64::from_le_bytes(word) as usize
            };
            let Some((content, next)) = behind.split_at_checked(number(8)) else {
                break;
            };
            all.push((number(0), content.to_vec()));
            rest = next;
        }
    }
    Ok(all)
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

    /// All of them. A process that does not deliver its own has ended, and so do all.
    fn complete(self) -> Result<Vec<R>, Cancelled> {
        let all: Option<Vec<R>> = self.0.into_iter().collect();
        all.ok_or(Cancelled)
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
        journal.save(stage, block, &bytes_of(found));
    }
}

fn bytes_of<R: Record>(items: &[R]) -> Vec<u8> {
    let mut bytes = Vec::new();
    items.iter().for_each(|item| item.write(&mut bytes));
    bytes
}

fn decoded<R: Record>(bytes: &[u8], rows: usize) -> Option<Vec<R>> {
    let mut reader = RecordReader { bytes };
    let found = (0..rows).map(|_| R::read(&mut reader)).collect();
    if reader.bytes.is_empty() { found } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicUsize, Ordering};

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
            _: Division,
            left: Range<usize>,
            most: usize,
        ) -> Result<Vec<usize>, Cancelled> {
            let is_mine = |b: &usize| self.part == 0 || b % self.parts == self.part - 1;
            Ok(left.filter(is_mine).take(most).collect())
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

    /// 17 items in blocks of 3, of which so many are computed at once.
    fn size(at_once: usize) -> LoopSize {
        LoopSize {
            items: 17,
            block: 3,
            at_once,
        }
    }

    /// All items, and how many of them had to be computed.
    fn run(journal: &Memory) -> (Option<Vec<Item>>, usize) {
        run_at_once(journal, 3)
    }

    fn run_at_once(journal: &Memory, at_once: usize) -> (Option<Vec<Item>>, usize) {
        let (progress, mut computed) = (Progress::new(), 0);
        let compute = |wanted: &[usize]| {
            assert!(wanted.is_sorted(), "{wanted:?}");
            assert!(wanted.len() <= at_once.max(3), "{wanted:?}");
            computed += wanted.len();
            Ok(wanted.iter().map(|&i| item(i)).collect())
        };
        let items = resumed(journal, STAGE, size(at_once), &progress, compute).unwrap();
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
    fn blocks_that_are_computed_at_once_are_those_that_are_computed_one_by_one() {
        for (parts, at_once) in [(1, 7), (1, 100), (3, 6), (5, 17), (1, 0)] {
            let [one_by_one, journal] = [(); 2].map(|()| Memory::whole(parts));
            assert_eq!(run(&one_by_one), (whole(), 17));
            assert_eq!(run_at_once(&journal, at_once), (whole(), 17));
            let stored = one_by_one.blocks.into_inner().unwrap();
            assert_eq!(*journal.blocks.lock().unwrap(), stored);
            // Only what is missing is computed again.
            journal.blocks.lock().unwrap().remove(&(STAGE, 0));
            let (found, computed) = run_at_once(&journal, at_once);
            assert_eq!(found, whole());
            assert!((1..=3).contains(&computed), "{computed}");
        }
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

    #[test]
    fn processes_go_on_with_the_blocks_of_all() {
        for processes in [1, 2, 3, 5, 30] {
            let computed = AtomicUsize::new(0);
            let found = together(processes, |journal| {
                let compute = |wanted: &[usize]| {
                    computed.fetch_add(wanted.len(), Ordering::Relaxed);
                    Ok(wanted.iter().map(|&i| item(i)).collect())
                };
                // Twice, so that steps are told apart.
                let progress = Progress::new();
                let first = shared(journal, (17, 3), &progress, compute).unwrap();
                let lengths = |wanted: &[usize]| Ok(wanted.iter().map(|&i| i as u32).collect());
                let second = shared(journal, (9, 1), &progress, lengths).unwrap();
                let points = resumed(journal, JournalStage::Points, size(6), &progress, compute);
                (first, second, points.unwrap())
            });
            for (first, second, points) in found {
                assert_eq!((Some(first), points), (whole(), whole()));
                assert_eq!(second, (0..9).collect::<Vec<u32>>());
            }
            assert_eq!(computed.into_inner(), 34);
        }
    }

    #[test]
    fn items_stay_where_they_were_computed() {
        for processes in [1, 2, 3, 5] {
            let found = together(processes, |journal| {
                let mut kept = Vec::new();
                let compute = |wanted: &[usize]| Ok(wanted.iter().map(|&i| item(i)).collect());
                let keep = |i: usize, row: Item| {
                    kept.push(i);
                    row.0.len() as u64
                };
                let progress = Progress::new();
                let size = LoopSize {
                    items: 17,
                    block: 2,
                    at_once: 5,
                };
                let lengths = distributed(journal, size, &progress, compute, keep).unwrap();
                assert_eq!(lengths, (0..17).rev().map(|n| n + 1).collect::<Vec<u64>>());
                kept
            });
            let mut all: Vec<usize> = found.into_iter().flatten().collect();
            all.sort_unstable();
            assert_eq!(all, (0..17).collect::<Vec<usize>>());
        }
    }

    #[test]
    fn one_that_is_cancelled_ends_all() {
        let ends = together(3, |journal| {
            let compute = |wanted: &[usize]| {
                if wanted.contains(&5) {
                    return Err(Cancelled);
                }
                Ok(wanted.iter().map(|&i| item(i)).collect::<Vec<Item>>())
            };
            shared(journal, (17, 1), &Progress::new(), compute)
        });
        assert_eq!(ends, [Err(Cancelled), Err(Cancelled), Err(Cancelled)]);
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
