//! Checkpoints: finished blocks of rows are stored and need not be computed again after an
//! interruption.

use super::Exchange;
use azulejo_trace::{Cancelled, Progress};
use std::ops::Range;

/// The computation that a block belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum JournalStage {
    /// Rows by rays or item buffers.
    Rows,
    /// Upper rows of exchange areas by formulas.
    Pairs,
}

/// Storage of finished blocks.
///
/// A block depends only on the scene, the options and its number, so a result assembled from stored
/// blocks is the same to the bit. The implementer has to make sure that blocks are returned
/// undamaged, and only for the same scene and options.
pub trait Journal: Sync {
    /// The bytes stored for a block, if any.
    fn load(&self, stage: JournalStage, block: usize) -> Option<Vec<u8>>;

    /// Stores a block. Failure is not an error here; the journal reports it to its owner.
    fn save(&self, stage: JournalStage, block: usize, bytes: &[u8]);

    /// Whether anything is stored at all.
    fn is_kept(&self) -> bool {
        true
    }
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

/// A row that a journal can store.
pub(crate) trait Record: Sized {
    /// Appends the row's bytes.
    fn write(&self, bytes: &mut Vec<u8>);

    /// The inverse of `write`; `None` if the bytes are invalid.
    fn read(bytes: &mut RecordReader) -> Option<Self>;

    /// Whether it is complete; blocks with incomplete rows are not stored.
    fn is_complete(&self) -> bool {
        true
    }
}

/// Computes the rows 0..`rows` in blocks of `size`, in order, except blocks that the journal holds.
/// `compute` advances `progress` by one per row.
///
/// # Errors
/// [`Cancelled`]; finished blocks are in the journal then.
pub(crate) fn resumed<R: Record>(
    journal: &dyn Journal,
    stage: JournalStage,
    (rows, size): (usize, usize),
    progress: &Progress,
    mut compute: impl FnMut(Range<usize>) -> Result<Vec<R>, Cancelled>,
) -> Result<Vec<R>, Cancelled> {
    let mut all = Vec::with_capacity(rows);
    for (block, start) in (0..rows).step_by(size.max(1)).enumerate() {
        let range = start..(start + size.max(1)).min(rows);
        let kept = journal.load(stage, block);
        if let Some(known) = kept.and_then(|bytes| decoded(&bytes, range.len())) {
            progress.advance(range.len() as u64)?;
            all.extend::<Vec<R>>(known);
            continue;
        }
        let found = compute(range)?;
        if journal.is_kept() && found.iter().all(R::is_complete) {
            let mut bytes = Vec::new();
            found.iter().for_each(|row| row.write(&mut bytes));
            journal.save(stage, block, &bytes);
        }
        all.extend(found);
    }
    Ok(all)
}

fn decoded<R: Record>(bytes: &[u8], rows: usize) -> Option<Vec<R>> {
    let mut reader = RecordReader { bytes };
    let found = (0..rows).map(|_| R::read(&mut reader)).collect();
    if reader.bytes.is_empty() { found } else { None }
}

/// Reads numbers from the front of a byte slice.
pub(crate) struct RecordReader<'a> {
    bytes: &'a [u8],
}

impl RecordReader<'_> {
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.bytes.split_first_chunk()?;
        self.bytes = rest;
        Some(*first)
    }

    pub fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub fn f32(&mut self) -> Option<f32> {
        self.array().map(f32::from_le_bytes)
    }

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
pub(crate) fn write_list<T>(items: &[T], bytes: &mut Vec<u8>, write: impl Fn(&T, &mut Vec<u8>)) {
    bytes.extend((items.len() as u32).to_le_bytes());
    items.iter().for_each(|item| write(item, bytes));
}

impl Record for Vec<Exchange> {
    fn write(&self, bytes: &mut Vec<u8>) {
        write_list(self, bytes, |e, bytes| {
            bytes.extend(e.column.to_le_bytes());
            bytes.extend(e.value.to_le_bytes());
            bytes.extend(e.error.to_le_bytes());
        });
    }

    fn read(bytes: &mut RecordReader) -> Option<Vec<Exchange>> {
        bytes.list(|b| {
            Some(Exchange {
                column: b.u32()?,
                value: b.f64()?,
                error: b.f32()?,
            })
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::collections::HashMap;
    use std::sync::Mutex;

    /// Stores blocks in memory.
    #[derive(Default)]
    pub struct Memory(pub Mutex<HashMap<(JournalStage, usize), Vec<u8>>>);

    impl Journal for Memory {
        fn load(&self, stage: JournalStage, block: usize) -> Option<Vec<u8>> {
            self.0.lock().unwrap().get(&(stage, block)).cloned()
        }

        fn save(&self, stage: JournalStage, block: usize, bytes: &[u8]) {
            let mut blocks = self.0.lock().unwrap();
            blocks.insert((stage, block), bytes.to_vec());
        }
    }

    fn row(i: usize) -> Vec<Exchange> {
        let exchange = |j: usize| Exchange {
            column: j as u32,
            value: 1.0 / (1 + i + j) as f64,
            error: 0.1 * j as f32,
        };
        (i..7).map(exchange).collect()
    }

    /// All rows, and how many of them had to be computed.
    fn run(journal: &Memory) -> (Vec<Vec<Exchange>>, usize) {
        let (progress, mut computed) = (Progress::new(), 0);
        let compute = |range: Range<usize>| {
            computed += range.len();
            Ok(range.map(row).collect())
        };
        let rows = resumed(journal, JournalStage::Pairs, (7, 3), &progress, compute).unwrap();
        assert_eq!(progress.done() + computed as u64, 7);
        (rows, computed)
    }

    #[test]
    fn what_is_kept_is_not_computed_again() {
        let journal = Memory::default();
        let whole: Vec<_> = (0..7).map(row).collect();
        assert_eq!(run(&journal), (whole.clone(), 7));
        assert_eq!(run(&journal), (whole.clone(), 0));
        journal.0.lock().unwrap().remove(&(JournalStage::Pairs, 1));
        assert_eq!(run(&journal), (whole, 3));
    }

    #[test]
    fn bytes_that_are_no_rows_are_not_taken() {
        let mut good = Vec::new();
        (0..3).for_each(|i| row(i).write(&mut good));
        let long = [&good[..], &[0]].concat();
        let endless = u32::MAX.to_le_bytes().repeat(3);
        for bytes in [&good[..good.len() - 1], &long, &endless, &[], &[1, 2, 3]] {
            let journal = Memory::default();
            journal.save(JournalStage::Pairs, 0, bytes);
            assert_eq!(run(&journal).1, 7);
        }
    }
}
