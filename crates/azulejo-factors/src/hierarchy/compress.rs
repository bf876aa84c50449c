//! Compression of a matrix that is there, from the leaves of the block tree up.

use super::blocks::{BlockDraft, BlockNumbers, sparse_bytes};
use super::clusters::{Clusters, PairArea};
use super::low_rank::LowRank;
use azulejo_trace::{Cancelled, Progress};

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
            |a, b, pairs| Ok(self.finished(a, b, self.between(a, b, pairs)?)),
        );
        let mut all = first?;
        let beside: Result<Compressed, Cancelled> = beside;
        all.append(beside?);
        all.append(second?);
        Ok(all)
    }

    /// The blocks between two clusters, the first before the second.
    fn between(&self, a: usize, b: usize, pairs: &mut [PairArea]) -> Result<Built, Cancelled> {
        if pairs.is_empty() {
            return Ok(Built::One(LowRank::default(), 0.0));
        }
        let halved = self
            .clusters
            .halved((a, b), pairs, |a, b, pairs| self.between(a, b, pairs));
        match halved {
            Some([(one, first), (other, second)]) => {
                Ok(self.joined((a, b), [one, other], [first?, second?]))
            }
            None => {
                self.progress.advance(pairs.len() as u64)?;
                Ok(self.leaf(a, b, pairs))
            }
        }
    }

    /// Largest norm of the error of a block.
    fn share(&self, a: usize, b: usize) -> f64 {
        let area = |node: usize| self.clusters.area(&self.clusters.node(node).range);
        self.allowed * (area(a) * area(b)).sqrt() / self.clusters.whole()
    }

    /// A block between two leaves: of low rank with three quarters of the error that it may have, if that is
    /// smaller than its entries.
    fn leaf(&self, a: usize, b: usize, pairs: &[PairArea]) -> Built {
        let (rows, columns) = (&self.clusters.node(a).range, &self.clusters.node(b).range);
        let entries = sparse(pairs, rows.start, columns.start);
        let (m, n) = (rows.len(), columns.len());
        let bytes = sparse_bytes(&entries).min(4 * m * n);
        let most = bytes / (4 * (m + n));
        let allowed = (0.75 * self.share(a, b)).powi(2);
        if allowed > 0.0
            && most > 0
            && let Some((block, error)) = LowRank::of(self.columns(a, b, &entries), allowed, most)
        {
            return Built::One(block, error);
        }
        let (entries, error) = self.without_smallest(a, b, entries, allowed);
        Built::Many(Compressed {
            blocks: vec![BlockDraft {
                rows: rows.clone(),
                columns: columns.clone(),
                content: BlockNumbers::Sparse(entries),
            }],
            error,
        })
    }

    /// The columns of a block of A^−½ S A^−½.
    fn columns(&self, a: usize, b: usize, entries: &[(u16, u16, f32)]) -> Vec<Vec<f64>> {
        let (rows, columns) = (&self.clusters.node(a).range, &self.clusters.node(b).range);
        let mut all = vec![vec![0.0; rows.len()]; columns.len()];
        for &(p, q, value) in entries {
            let (p, q) = (usize::from(p), usize::from(q));
            let areas = self.weight(rows.start, p) * self.weight(columns.start, q);
            all[q][p] = f64::from(value) / areas;
        }
        all
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
        a: usize,
        b: usize,
        entries: Vec<(u16, u16, f32)>,
        allowed: f64,
    ) -> (Vec<(u16, u16, f32)>, f64) {
        let (rows, columns) = (&self.clusters.node(a).range, &self.clusters.node(b).range);
        let square = |&(p, q, value): &(u16, u16, f32)| {
            let (p, q) = (usize::from(p), usize::from(q));
            let areas = self.weight(rows.start, p) * self.weight(columns.start, q);
            (f64::from(value) / areas).powi(2)
        };
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
    fn joined(
        &self,
        whole: (usize, usize),
        parts: [(usize, usize); 2],
        built: [Built; 2],
    ) -> Built {
        let length = |node: usize| self.clusters.node(node).len();
        let (m, n) = (length(whole.0), length(whole.1));
        match built {
            [Built::One(first, e1), Built::One(second, e2)] => {
                let terms = |k: usize, (a, b): (usize, usize)| k * (length(a) + length(b));
                let apart = terms(first.rank(), parts[0]) + terms(second.rank(), parts[1]);
                let left = 0.5 * (self.share(whole.0, whole.1) - (e1 + e2).sqrt()).max(0.0);
                let mut one = if parts[0].1 == whole.1 {
                    first
                        .clone()
                        .above(second.clone(), length(parts[0].0), length(parts[1].0))
                } else {
                    first
                        .clone()
                        .beside(second.clone(), length(parts[0].1), length(parts[1].1))
                };
                let dropped = one.truncate(left * left);
                if one.rank() * (m + n) <= apart {
                    // The triangle inequality, because the errors need not be orthogonal.
                    let error = ((e1 + e2).sqrt() + dropped.sqrt()).powi(2);
                    return Built::One(one, error);
                }
                let mut all = self.finished(parts[0].0, parts[0].1, Built::One(first, e1));
                all.append(self.finished(parts[1].0, parts[1].1, Built::One(second, e2)));
                Built::Many(all)
            }
            [first, second] => {
                let mut all = self.finished(parts[0].0, parts[0].1, first);
                all.append(self.finished(parts[1].0, parts[1].1, second));
                Built::Many(all)
            }
        }
    }

    /// Blocks to be stored.
    fn finished(&self, a: usize, b: usize, built: Built) -> Compressed {
        let (block, error) = match built {
            Built::Many(all) => return all,
            Built::One(block, error) => (block, error),
        };
        let (rows, columns) = (&self.clusters.node(a).range, &self.clusters.node(b).range);
        let mut factors = Vec::with_capacity(block.rank() * (rows.len() + columns.len()));
        let mut put = |vector: &[f64], start: u32, scale: f64| {
            let places = vector.iter().enumerate();
            factors.extend(places.map(|(k, x)| (x * scale * self.weight(start, k)) as f32));
        };
        for (u, v) in block.u.iter().zip(&block.v) {
            // Both factors get the root of the singular value.
            let root = v.iter().map(|x| x * x).sum::<f64>().sqrt().sqrt();
            put(u, rows.start, root);
            put(
                v,
                columns.start,
                if root > 0.0 { root.recip() } else { 0.0 },
            );
        }
        let rank = block.rank() as u32;
        let draft = BlockDraft {
            rows: rows.clone(),
            columns: columns.clone(),
            content: BlockNumbers::LowRank { rank, factors },
        };
        Compressed {
            blocks: if rank > 0 { vec![draft] } else { Vec::new() },
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
