//! Compression of an existing matrix, from the leaves of the block tree up.

use super::blocks::{BlockDraft, BlockNumbers, sparse_bytes};
use super::clusters::{Clusters, NodePair, PairArea};
use super::low_rank::LowRank;
use azulejo_trace::{Cancelled, Progress};
use std::ops::Range;

/// Rows of a leaf: blocks of 128² are small enough to be factored and large enough to have a rank.
pub(super) const LEAF: usize = 128;

/// Compresses the pairs between all rows; an error is measured and allowed in the matrix
/// A^−½ S A^−½.
pub(super) struct Compression<'a> {
    pub clusters: &'a Clusters,
    /// Largest Frobenius norm of the error of the whole matrix. A block may have its share by area:
    /// √(A_I A_J) / A of it.
    pub allowed: f64,
    pub progress: &'a Progress,
}

/// The blocks between two clusters.
pub(super) struct Compressed {
    pub blocks: Vec<BlockDraft>,
    /// Square of the error's Frobenius norm, of these blocks alone, without their transposes.
    pub error: f64,
}

/// The same as long as it may become part of a larger block.
enum Built {
    /// One block of low rank, of the matrix A^−½ S A^−½.
    One(LowRank, f64),
    Many(Compressed),
}

impl Compression<'_> {
    /// The blocks of a cluster with itself.
    pub fn diagonal(&self, node: usize, pairs: &mut [PairArea]) -> Result<Compressed, Cancelled> {
        let range = self.clusters.node(node).range.clone();
        if self.clusters.node(node).is_leaf() {
            self.progress.advance(pairs.len() as u64)?;
            let content = BlockNumbers::Sparse(sparse(pairs, range.start, range.start));
            return Ok(Compressed {
                blocks: vec![BlockDraft {
                    rows: range.clone(),
                    columns: range,
                    content,
                }],
                error: 0.0,
            });
        }
        let (first, beside, second) = self.clusters.quartered(
            node,
            pairs,
            |node, pairs| self.diagonal(node, pairs),
            |halves, pairs| Ok::<_, Cancelled>(self.finished(halves, self.between(halves, pairs)?)),
        );
        let mut blocks = first?;
        blocks.append(beside?);
        blocks.append(second?);
        Ok(blocks)
    }

    /// The blocks between two clusters, the first before the second.
    fn between(&self, block: NodePair, pairs: &mut [PairArea]) -> Result<Built, Cancelled> {
        if pairs.is_empty() {
            return Ok(Built::One(LowRank::default(), 0.0));
        }
        let between = |half, pairs: &mut [PairArea]| self.between(half, pairs);
        match self.clusters.halved(block, pairs, between) {
            Some([(one, first), (other, second)]) => {
                Ok(self.joined(block, [one, other], [first?, second?]))
            }
            None => {
                self.progress.advance(pairs.len() as u64)?;
                Ok(self.leaf(block, pairs))
            }
        }
    }

    /// Largest norm of the error of a block.
    fn share(&self, block: NodePair) -> f64 {
        let [a, b] = self
            .clusters
            .ranges(block)
            .map(|range| self.clusters.area(&range));
        self.allowed * (a * b).sqrt() / self.clusters.whole()
    }

    /// A block between two leaves: of low rank with three quarters of the error that it may have, if that is
    /// smaller than its entries.
    fn leaf(&self, block: NodePair, pairs: &[PairArea]) -> Built {
        let [rows, columns] = self.clusters.ranges(block);
        let entries = sparse(pairs, rows.start, columns.start);
        let (m, n) = (rows.len(), columns.len());
        let bytes = sparse_bytes(&entries).min(4 * m * n);
        let most = bytes / (4 * (m + n));
        let allowed = (0.75 * self.share(block)).powi(2);
        if allowed > 0.0 && most > 0 {
            let mut dense = vec![vec![0.0; m]; n];
            for e in &entries {
                dense[usize::from(e.1)][usize::from(e.0)] = self.normalized([&rows, &columns], e);
            }
            if let Some((low_rank, error)) = LowRank::of(dense, allowed, most) {
                return Built::One(low_rank, error);
            }
        }
        let (entries, error) = self.without_smallest([&rows, &columns], entries, allowed);
        let content = BlockNumbers::Sparse(entries);
        Built::Many(Compressed {
            blocks: vec![BlockDraft {
                rows,
                columns,
                content,
            }],
            error,
        })
    }

    /// An entry of a block of A^−½ S A^−½.
    fn normalized(
        &self,
        [rows, columns]: [&Range<u32>; 2],
        &(p, q, value): &(u16, u16, f32),
    ) -> f64 {
        let areas = self.weight(rows.start, p.into()) * self.weight(columns.start, q.into());
        f64::from(value) / areas
    }

    /// √A of a position; 1 for groups without area, which exchange nothing.
    fn weight(&self, start: u32, place: usize) -> f64 {
        let area = self.clusters.areas[start as usize + place];
        if area > 0.0 { area.sqrt() } else { 1.0 }
    }

    /// Drops the smallest entries while the sum of their squares is at most `allowed`, if that makes the
    /// block smaller.
    fn without_smallest(
        &self,
        ranges: [&Range<u32>; 2],
        entries: Vec<(u16, u16, f32)>,
        allowed: f64,
    ) -> (Vec<(u16, u16, f32)>, f64) {
        let square = |e: &(u16, u16, f32)| self.normalized(ranges, e).powi(2);
        let mut squares: Vec<f64> = entries.iter().map(square).collect();
        squares.sort_unstable_by(f64::total_cmp);
        let (mut dropped, mut least) = (0.0, f64::INFINITY);
        for s in squares {
            if dropped + s > allowed {
                least = s;
                break;
            }
            dropped += s;
        }
        let kept: Vec<_> = entries.into_iter().filter(|e| square(e) >= least).collect();
        (kept, dropped)
    }

    /// Two blocks beside each other: one, if that is smaller, with half of the error that is left.
    fn joined(&self, whole: NodePair, parts: [NodePair; 2], built: [Built; 2]) -> Built {
        let length = |node: usize| self.clusters.node(node).len();
        let [first, second] = match built {
            [Built::One(first, e1), Built::One(second, e2)] => {
                let terms = |k: usize, (a, b): NodePair| k * (length(a) + length(b));
                let apart = terms(first.rank(), parts[0]) + terms(second.rank(), parts[1]);
                let left = 0.5 * (self.share(whole) - (e1 + e2).sqrt()).max(0.0);
                let (upper, lower) = (first.clone(), second.clone());
                let mut one = if parts[0].1 == whole.1 {
                    upper.above(lower, length(parts[0].0), length(parts[1].0))
                } else {
                    upper.beside(lower, length(parts[0].1), length(parts[1].1))
                };
                let dropped = one.truncate(left * left);
                if terms(one.rank(), whole) <= apart {
                    // The triangle inequality, because the errors need not be orthogonal.
                    let error = ((e1 + e2).sqrt() + dropped.sqrt()).powi(2);
                    return Built::One(one, error);
                }
                [Built::One(first, e1), Built::One(second, e2)]
            }
            built => built,
        };
        let mut blocks = self.finished(parts[0], first);
        blocks.append(self.finished(parts[1], second));
        Built::Many(blocks)
    }

    /// Blocks to be stored.
    fn finished(&self, block: NodePair, built: Built) -> Compressed {
        let (low_rank, error) = match built {
            Built::Many(blocks) => return blocks,
            Built::One(low_rank, error) => (low_rank, error),
        };
        let [rows, columns] = self.clusters.ranges(block);
        let mut factors = Vec::with_capacity(low_rank.rank() * (rows.len() + columns.len()));
        let mut put = |vector: &[f64], start: u32, scale: f64| {
            let places = vector.iter().enumerate();
            factors.extend(places.map(|(k, x)| (x * scale * self.weight(start, k)) as f32));
        };
        for (u, v) in low_rank.u.iter().zip(&low_rank.v) {
            // Both factors get the root of the singular value.
            let root = v.iter().map(|x| x * x).sum::<f64>().sqrt().sqrt();
            put(u, rows.start, root);
            let inverse = if root > 0.0 { root.recip() } else { 0.0 };
            put(v, columns.start, inverse);
        }
        let rank = low_rank.rank() as u32;
        let content = BlockNumbers::LowRank { rank, factors };
        let draft = (rank > 0).then_some(BlockDraft {
            rows,
            columns,
            content,
        });
        Compressed {
            blocks: draft.into_iter().collect(),
            error,
        }
    }
}

impl Compressed {
    fn append(&mut self, other: Compressed) {
        self.blocks.extend(other.blocks);
        self.error += other.error;
    }
}

/// Pairs as entries of a block that starts at these positions; what several pairs say of one entry is
/// added up.
pub(super) fn sparse(pairs: &[PairArea], row: u32, column: u32) -> Vec<(u16, u16, f32)> {
    let mut entries: Vec<(u16, u16, f32)> = pairs
        .iter()
        .map(|e| ((e.p - row) as u16, (e.q - column) as u16, e.value))
        .collect();
    // By value too, so that sums do not depend on the order of arrival.
    entries.sort_unstable_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    let sum = |same: &[(u16, u16, f32)]| {
        let value: f64 = same.iter().map(|e| f64::from(e.2)).sum();
        (same[0].0, same[0].1, value as f32)
    };
    let same = entries.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    same.map(sum).collect()
}
