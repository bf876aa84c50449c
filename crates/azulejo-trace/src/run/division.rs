//! Items in blocks.

use super::RunRole;

/// Most blocks of a loop that all processes share: enough for 1,000 of them to be busy to the end.
const MOST_BLOCKS: usize = 1 << 13;

/// Items in blocks.
///
/// Of one part, a block is this many items in a row. Of several, the items are dealt like cards: part k of
/// n has the items k, k + n, k + 2 n, ..., so that all have as much to do as nearly as possible, and a
/// block is this many of these. Block b belongs to part b mod n.
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
    /// The items of a loop among the parts of a run.
    pub fn new(size: LoopSize, role: RunRole) -> Division {
        Division {
            items: size.items,
            size: size.block.max(1),
            parts: role.parts.max(1),
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
    pub(super) fn of_shared_loop(self) -> LoopSize {
        let block = self.block.max(self.items.div_ceil(MOST_BLOCKS)).max(1);
        LoopSize {
            block,
            at_once: self.at_once.max(block),
            ..self
        }
    }

    /// Most blocks that a process computes at once.
    pub(super) fn blocks_at_once(&self) -> usize {
        (self.at_once / self.block.max(1)).max(1)
    }
}
