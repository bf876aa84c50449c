//! Loops over many items, by all threads of all processes that share the work.

use super::{Record, Run};
use crate::progress::Cancelled;
use rayon::prelude::*;

/// Batches of a block that one thread of a process computes before it asks for the next: some milliseconds.
pub const BLOCK: usize = 4;

/// The same where batches take longer.
pub const SHORT_BLOCK: usize = 1;

/// The results of `of_batch` for all items in their order. Batches are of `size` items, whoever computes them.
pub fn in_batches<I: Sync, T: Record + Send>(
    items: &[I],
    size: usize,
    run: Run,
    of_batch: impl Fn(&[I]) -> Result<Vec<T>, Cancelled> + Sync,
) -> Result<Vec<T>, Cancelled> {
    in_blocks(items, (size, BLOCK), run, of_batch)
}

/// The same with blocks of this many batches.
pub fn in_blocks<I: Sync, T: Record + Send>(
    items: &[I],
    (size, block): (usize, usize),
    run: Run,
    of_batch: impl Fn(&[I]) -> Result<Vec<T>, Cancelled> + Sync,
) -> Result<Vec<T>, Cancelled> {
    let batches: Vec<&[I]> = items.chunks(size).collect();
    numbered(batches.len(), block, run, &|number| {
        of_batch(batches[number])
    })
}

/// The results of all batches, by their numbers. Apart, so that the loops of threads are compiled for each type of result
/// and not for each closure.
fn numbered<T: Record + Send>(
    count: usize,
    block: usize,
    run: Run,
    of_number: &(dyn Fn(usize) -> Result<Vec<T>, Cancelled> + Sync),
) -> Result<Vec<T>, Cancelled> {
    let counted = |&number: &usize| {
        run.progress.advance(0)?;
        of_number(number)
    };
    let results = run.shared((count, block), |numbers| {
        numbers.par_iter().map(counted).collect()
    })?;
    Ok(results.into_iter().flatten().collect())
}

/// The same with blocks of so many batches, for items that the progress counts.
pub fn in_counted_batches<I: Sync, T: Record + Send>(
    items: &[I],
    size: (usize, usize),
    run: Run,
    of_batch: impl Fn(&[I]) -> Result<Vec<T>, Cancelled> + Sync,
) -> Result<Vec<T>, Cancelled> {
    in_blocks(items, size, run, |batch| {
        run.progress.advance(batch.len() as u64)?;
        of_batch(batch)
    })
}
