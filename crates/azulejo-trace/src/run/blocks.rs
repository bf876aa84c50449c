//! Storage of finished blocks, and who computes which.

use super::Division;
use crate::progress::Cancelled;
use std::ops::Range;

/// The computation that a block belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RunStage {
    /// Rows of form factors by rays or item buffers.
    Rows,
    /// Upper rows of exchange areas by formulas.
    Pairs,
    /// Close pairs by formulas, for rows by rays.
    Formulas,
    /// Irradiance at points: the first rays of each.
    Points,
    /// One of the loops whose results all processes need to go on, by its place in the order of the
    /// program: see [`Blocks::loop_stage`].
    Loop(u32),
}

/// The part that a process has in a run; it does not change while the run lasts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunRole {
    /// Parts that items are dealt to, at least 1: see [`Division`].
    pub parts: usize,
    /// Processes that go on with the blocks of all, at least 1. Where there are several, loops whose results all
    /// of them need are divided, too.
    pub processes: usize,
    /// Whether this process makes the result. One that does not computes its blocks of all stages that do not
    /// depend on one another, and ends without a result.
    pub assembles: bool,
    /// Whether finished blocks are stored, or sent to another process.
    pub is_kept: bool,
}

impl Default for RunRole {
    /// One process, which stores nothing.
    fn default() -> RunRole {
        RunRole {
            parts: 1,
            processes: 1,
            assembles: true,
            is_kept: false,
        }
    }
}

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
/// | parts that never meet: each process computes its blocks and ends, one assembles them afterwards | [`role`](Blocks::role), [`next`](Blocks::next), [`rely_on`](Blocks::rely_on) |
/// | processes that talk to each other, and all go on with the blocks of all | these and [`gather`](Blocks::gather), [`loop_stage`](Blocks::loop_stage) |
///
/// The latter run the same program on the same data, each of them as if it were alone, and come to
/// the same loops in the same order.
pub trait Blocks: Sync {
    /// The part of this process.
    fn role(&self) -> RunRole {
        RunRole::default()
    }

    /// The bytes stored for a block, if any.
    fn load(&self, stage: RunStage, block: usize) -> Option<Vec<u8>>;

    /// Stores a block. Failure is not an error here; the implementer reports it to its owner.
    fn save(&self, stage: RunStage, block: usize, bytes: &[u8]);

    /// The next blocks for this process, at most `most` (1 or more), in the range `left` of those that it was
    /// not given yet; none when no more are left for it. Numbers ascend.
    ///
    /// # Errors
    /// [`Cancelled`] if the work is to end after the last blocks.
    fn next(
        &self,
        _stage: RunStage,
        _division: Division,
        left: Range<usize>,
        most: usize,
    ) -> Result<Vec<usize>, Cancelled> {
        Ok(left.take(most).collect())
    }

    /// The bytes that each of the [`processes`](RunRole::processes) gives for a stage, in their order; where this one
    /// alone makes the result, the blocks that others computed and [`load`](Blocks::load) does not have, as
    /// [`write_block`](super::write_block) writes them.
    ///
    /// # Errors
    /// [`Cancelled`].
    fn gather(&self, _stage: RunStage, own: Vec<u8>) -> Result<Vec<Vec<u8>>, Cancelled> {
        Ok(vec![own])
    }

    /// The stage of the next loop whose results all processes need.
    fn loop_stage(&self) -> RunStage {
        RunStage::Loop(0)
    }

    /// Says on what the blocks of a stage depend besides the scene and the options, as a
    /// [`digest`](super::digest): what each process computed itself, and may have computed otherwise on another
    /// machine.
    ///
    /// # Errors
    /// [`Cancelled`] if that of others differs: their blocks do not fit. The implementer reports it to its owner.
    fn rely_on(&self, _stage: RunStage, _digest: u64) -> Result<(), Cancelled> {
        Ok(())
    }
}

/// One process, which stores nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Blocks for Alone {
    fn load(&self, _: RunStage, _: usize) -> Option<Vec<u8>> {
        None
    }

    fn save(&self, _: RunStage, _: usize, _: &[u8]) {}
}

/// How many of the blocks that are left one of several processes is given that asks for `most`: fewer toward
/// the end, so that none has much to do when there is no more for others (guided self-scheduling: Polychronopoulos
/// and Kuck, IEEE Transactions on Computers 36, 1987).
pub fn guided_share(left: usize, processes: usize, most: usize) -> usize {
    left.div_ceil(2 * processes.max(1)).min(most)
}
