//! Blocks of exchange areas between two clusters: how they are stored and multiplied.

use rayon::prelude::*;
use std::ops::Range;

/// Parts into which blocks are divided, whatever the number of threads.
const PARTS: usize = 16;

/// Most rows or columns of a sparse block, whose indices take two bytes.
pub(super) const MOST_SPARSE: usize = 65_535;

/// Bytes of a block besides its numbers.
const HEADER: usize = size_of::<Block>();

/// The exchange areas S_pq between a range of positions p and one of positions q.
///
/// The block on the other side of the diagonal is its transpose and not stored. A block on the
/// diagonal, with equal ranges, has the entries p ≤ q alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Positions p.
    pub rows: Range<u32>,
    /// Positions q: those of `rows`, or after them.
    pub columns: Range<u32>,
    /// How the numbers are laid out.
    pub kind: BlockKind,
    /// Its numbers among [`BlockPart::values`].
    pub values: Range<u32>,
    /// Its indices among [`BlockPart::layout`]; empty unless it is sparse.
    pub layout: Range<u32>,
}

/// Layout of a block of m rows and n columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockKind {
    /// The entries that are not zero, row by row. The layout has, for each row with entries, the row,
    /// the number of its entries and their columns, counted from the first of the block.
    Sparse,
    /// All m n entries, row by row.
    Dense,
    /// Σ u vᵀ: for each term the m numbers of u, then the n numbers of v.
    LowRank {
        /// Number of terms.
        rank: u32,
    },
}

/// Some blocks with all their numbers: plain arrays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlockPart {
    /// The blocks.
    pub blocks: Vec<Block>,
    /// The numbers of all of them, in square scene units or, in factors of low rank, its root.
    pub values: Vec<f32>,
    /// The indices of the sparse ones.
    pub layout: Vec<u16>,
}

/// The numbers of a block that is not stored yet.
pub(super) enum BlockNumbers {
    /// Row, column and value, sorted, each pair once.
    Sparse(Vec<(u16, u16, f32)>),
    /// u and v of each term.
    LowRank { rank: u32, factors: Vec<f32> },
}

/// A block that is not stored yet.
pub(super) struct BlockDraft {
    pub rows: Range<u32>,
    pub columns: Range<u32>,
    pub content: BlockNumbers,
}

impl BlockDraft {
    /// Bytes that it will take.
    pub fn bytes(&self) -> usize {
        let numbers = match &self.content {
            BlockNumbers::Sparse(entries) if self.is_dense(entries) => {
                self.rows.len() * self.columns.len() * 4
            }
            BlockNumbers::Sparse(entries) => sparse_bytes(entries),
            BlockNumbers::LowRank { factors, .. } => 4 * factors.len(),
        };
        HEADER + numbers
    }

    /// Whether all entries take less than those that are not zero with their indices.
    fn is_dense(&self, entries: &[(u16, u16, f32)]) -> bool {
        let dense_bytes = self.rows.len() * self.columns.len() * 4;
        self.rows != self.columns && dense_bytes <= sparse_bytes(entries)
    }
}

/// Bytes of sparse entries.
pub(super) fn sparse_bytes(entries: &[(u16, u16, f32)]) -> usize {
    let rows = entries.chunk_by(|a, b| a.0 == b.0).count();
    6 * entries.len() + 4 * rows
}

/// Stores blocks in parts that depend on the blocks alone.
pub(super) fn store(drafts: Vec<BlockDraft>) -> Vec<BlockPart> {
    let total: usize = drafts.iter().map(BlockDraft::bytes).sum();
    let (mut parts, mut part, mut bytes) = (Vec::new(), BlockPart::default(), 0);
    for draft in drafts {
        bytes += draft.bytes();
        part.push(draft);
        if bytes * PARTS >= total * (parts.len() + 1) {
            parts.push(std::mem::take(&mut part).fitted());
        }
    }
    if !part.blocks.is_empty() {
        parts.push(part.fitted());
    }
    parts
}

impl BlockPart {
    fn push(&mut self, draft: BlockDraft) {
        let (values, layout) = (self.values.len() as u32, self.layout.len() as u32);
        let kind = match &draft.content {
            BlockNumbers::Sparse(entries) if entries.is_empty() => return,
            BlockNumbers::Sparse(entries) if draft.is_dense(entries) => {
                let (m, n) = (draft.rows.len(), draft.columns.len());
                self.values.resize(self.values.len() + m * n, 0.0);
                let dense = &mut self.values[values as usize..];
                for &(p, q, value) in entries {
                    dense[usize::from(p) * n + usize::from(q)] = value;
                }
                BlockKind::Dense
            }
            BlockNumbers::Sparse(entries) => {
                for row in entries.chunk_by(|a, b| a.0 == b.0) {
                    self.layout.extend([row[0].0, row.len() as u16]);
                    self.layout.extend(row.iter().map(|e| e.1));
                    self.values.extend(row.iter().map(|e| e.2));
                }
                BlockKind::Sparse
            }
            BlockNumbers::LowRank { rank: 0, .. } => return,
            BlockNumbers::LowRank { rank, factors } => {
                self.values.extend_from_slice(factors);
                BlockKind::LowRank { rank: *rank }
            }
        };
        self.blocks.push(Block {
            rows: draft.rows,
            columns: draft.columns,
            kind,
            values: values..self.values.len() as u32,
            layout: layout..self.layout.len() as u32,
        });
    }

    fn fitted(mut self) -> BlockPart {
        self.blocks.shrink_to_fit();
        self.values.shrink_to_fit();
        self.layout.shrink_to_fit();
        self
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        HEADER * self.blocks.len() + 4 * self.values.len() + 2 * self.layout.len()
    }

    /// Adds S x, both by position, to `y`, for vectors of `length` numbers that follow each other. A
    /// block is multiplied by all of them while it is near the processor.
    fn add_products(&self, x: &[f64], y: &mut [f64], length: usize) {
        for block in &self.blocks {
            let lanes = x.chunks_exact(length).zip(y.chunks_exact_mut(length));
            lanes.for_each(|(x, y)| self.add_product(block, x, y));
        }
    }

    fn add_product(&self, block: &Block, x: &[f64], y: &mut [f64]) {
        let values = &self.values[range(&block.values)];
        let (rows, columns) = (range(&block.rows), range(&block.columns));
        match block.kind {
            BlockKind::Sparse => {
                let layout = &self.layout[range(&block.layout)];
                for_each_sparse(layout, values, |p, q, value| {
                    let (p, q) = (rows.start + p, columns.start + q);
                    y[p] += value * x[q];
                    if p != q {
                        y[q] += value * x[p];
                    }
                });
            }
            BlockKind::Dense => {
                for (p, row) in rows.zip(values.chunks_exact(columns.len())) {
                    y[p] += dot(row, &x[columns.clone()]);
                    add(&mut y[columns.clone()], x[p], row);
                }
            }
            BlockKind::LowRank { .. } => {
                for term in values.chunks_exact(rows.len() + columns.len()) {
                    let (u, v) = term.split_at(rows.len());
                    let (to_rows, to_columns) =
                        (dot(v, &x[columns.clone()]), dot(u, &x[rows.clone()]));
                    add(&mut y[rows.clone()], to_rows, u);
                    add(&mut y[columns.clone()], to_columns, v);
                }
            }
        }
    }

    /// Visits row, column and value of the entries that a block stores, counted from its first; none of one of
    /// low rank.
    fn for_each_stored(&self, block: &Block, mut visit: impl FnMut(usize, usize, f64)) {
        let values = &self.values[range(&block.values)];
        let columns = block.columns.len();
        match block.kind {
            BlockKind::Sparse => for_each_sparse(&self.layout[range(&block.layout)], values, visit),
            BlockKind::Dense => {
                for (k, &value) in values.iter().enumerate() {
                    visit(k / columns, k % columns, value.into());
                }
            }
            BlockKind::LowRank { .. } => {}
        }
    }

    /// The terms of a block of low rank, each u and then v; none of another block.
    fn terms(&self, block: &Block) -> impl Iterator<Item = &[f32]> {
        let values = match block.kind {
            BlockKind::LowRank { .. } => range(&block.values),
            _ => 0..0,
        };
        self.values[values].chunks_exact(block.rows.len() + block.columns.len())
    }

    /// Visits both positions and S_pq of all pairs p ≤ q that are not 0.
    pub fn for_each(&self, visit: &mut dyn FnMut(usize, usize, f64)) {
        for block in &self.blocks {
            let (rows, columns) = (range(&block.rows), range(&block.columns));
            let mut visit = |p: usize, q: usize, value: f64| {
                if value != 0.0 {
                    visit(rows.start + p, columns.start + q, value);
                }
            };
            self.for_each_stored(block, &mut visit);
            if let BlockKind::LowRank { .. } = block.kind {
                for (p, q) in (0..rows.len()).flat_map(|p| (0..columns.len()).map(move |q| (p, q)))
                {
                    let value = |t: &[f32]| f64::from(t[p]) * f64::from(t[rows.len() + q]);
                    visit(p, q, self.terms(block).map(value).sum());
                }
            }
        }
    }

    /// Visits position and S_pp of rows that see themselves. Blocks on the diagonal are sparse.
    pub fn for_each_own(&self, visit: &mut dyn FnMut(usize, f64)) {
        for block in self.blocks.iter().filter(|b| b.rows == b.columns) {
            self.for_each_stored(block, |p, q, value| {
                if p == q {
                    visit(block.rows.start as usize + p, value);
                }
            });
        }
    }

    /// Visits pairs of positions that exchange light, enough of them to connect all that do.
    pub fn for_each_link(&self, visit: &mut dyn FnMut(usize, usize)) {
        for block in &self.blocks {
            let (rows, columns) = (range(&block.rows), range(&block.columns));
            self.for_each_stored(block, |p, q, value| {
                if value > 0.0 {
                    visit(rows.start + p, columns.start + q);
                }
            });
            // In a product u vᵀ all rows with u exchange with all columns with v.
            for term in self.terms(block) {
                let (u, v) = term.split_at(rows.len());
                let [u, v] = [u, v].map(|x| (0..x.len()).filter(move |&k| x[k] != 0.0));
                let (first_u, first_v) = (u.clone().next(), v.clone().next());
                if let (Some(p), Some(q)) = (first_u, first_v) {
                    u.for_each(|u| visit(rows.start + u, columns.start + q));
                    v.for_each(|v| visit(rows.start + p, columns.start + v));
                }
            }
        }
    }

    /// Multiplies rows and columns by `factors`, by position.
    pub fn scale(&mut self, factors: &[f64]) {
        for block in &self.blocks {
            let values = &mut self.values[range(&block.values)];
            let (rows, columns) = (range(&block.rows), range(&block.columns));
            match block.kind {
                BlockKind::Sparse => {
                    let mut k = 0;
                    let layout = &self.layout[range(&block.layout)];
                    for_each_index(layout, |p, q| {
                        let factor = factors[rows.start + p] * factors[columns.start + q];
                        values[k] = (f64::from(values[k]) * factor) as f32;
                        k += 1;
                    });
                }
                BlockKind::Dense => {
                    for (p, row) in rows.zip(values.chunks_exact_mut(columns.len())) {
                        for (value, factor) in row.iter_mut().zip(&factors[columns.clone()]) {
                            *value = (f64::from(*value) * factors[p] * factor) as f32;
                        }
                    }
                }
                BlockKind::LowRank { .. } => {
                    for term in values.chunks_exact_mut(rows.len() + columns.len()) {
                        let places = rows.clone().chain(columns.clone());
                        for (value, place) in term.iter_mut().zip(places) {
                            *value = (f64::from(*value) * factors[place]) as f32;
                        }
                    }
                }
            }
        }
    }

    /// S_pq, p ≤ q, if one of the blocks has this pair.
    pub fn get(&self, p: u32, q: u32) -> Option<f64> {
        let has = |b: &&Block| b.rows.contains(&p) && b.columns.contains(&q);
        let block = self.blocks.iter().find(has)?;
        let (m, n) = (block.rows.len(), block.columns.len());
        let (i, j) = (
            (p - block.rows.start) as usize,
            (q - block.columns.start) as usize,
        );
        let mut area = 0.0;
        match block.kind {
            BlockKind::Sparse => self.for_each_stored(block, |p, q, value| {
                if (p, q) == (i, j) {
                    area = value;
                }
            }),
            BlockKind::Dense => area = self.values[range(&block.values)][i * n + j].into(),
            BlockKind::LowRank { .. } => {
                let terms = self.terms(block);
                area = terms.map(|t| f64::from(t[i]) * f64::from(t[m + j])).sum();
            }
        }
        Some(area)
    }
}

/// S x by position, for `lanes` vectors that follow each other: the same bits for any number of threads.
pub(super) fn product(parts: &[BlockPart], x: &[f64], lanes: usize) -> Vec<f64> {
    let length = (x.len() / lanes).max(1);
    let part = |part: &BlockPart| {
        let mut y = vec![0.0; x.len()];
        part.add_products(x, &mut y, length);
        y
    };
    let sums: Vec<Vec<f64>> = parts.par_iter().map(part).collect();
    let total = |p: usize| sums.iter().map(|s| s[p]).sum();
    (0..x.len()).into_par_iter().map(total).collect()
}

fn range(range: &Range<u32>) -> Range<usize> {
    range.start as usize..range.end as usize
}

/// Visits row and column of all sparse entries.
fn for_each_index(mut layout: &[u16], mut visit: impl FnMut(usize, usize)) {
    while let [row, count, rest @ ..] = layout {
        let (columns, rest) = rest.split_at(usize::from(*count));
        for &column in columns {
            visit(usize::from(*row), usize::from(column));
        }
        layout = rest;
    }
}

/// Visits row, column and value of all sparse entries.
fn for_each_sparse(layout: &[u16], values: &[f32], mut visit: impl FnMut(usize, usize, f64)) {
    let mut values = values.iter();
    for_each_index(layout, |p, q| {
        if let Some(&value) = values.next() {
            visit(p, q, value.into());
        }
    });
}

/// In four sums, so that processors work on several at a time.
fn dot(a: &[f32], b: &[f64]) -> f64 {
    let (a_chunks, b_chunks) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest = a_chunks.remainder().iter().zip(b_chunks.remainder());
    let rest: f64 = rest.map(|(a, b)| f64::from(*a) * b).sum();
    let mut sums = [0.0; 4];
    for (a, b) in a_chunks.zip(b_chunks) {
        (0..4).for_each(|k| sums[k] += f64::from(a[k]) * b[k]);
    }
    sums.iter().sum::<f64>() + rest
}

fn add(to: &mut [f64], share: f64, x: &[f32]) {
    for (to, x) in to.iter_mut().zip(x) {
        *to += share * f64::from(*x);
    }
}
