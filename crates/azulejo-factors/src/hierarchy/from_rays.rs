//! Blocks filled by rays, while they are traced.

use super::blocks::{BlockDraft, BlockNumbers, store};
use super::clusters::{Clusters, PairArea};
use super::partition::{BlockShape, Partition, pooled};
use super::{CompressedFactors, CompressionError, CompressionOptions};
use crate::form_factors::PreparedPlan;
use crate::form_factors::row_stream::{RowStream, StreamedRow};
use azulejo_trace::{Cancelled, Progress};
use rayon::prelude::*;
use std::ops::Range;

/// Rows of a leaf: below it, a pair of clusters has few hits for each row.
const LEAF: usize = 32;

/// Rows traced at a time.
const BLOCK: usize = 512;

/// One of this many rays chooses the blocks that the others fill.
const PILOT: u32 = 8;

/// Fewest rays of a row that choose blocks.
const LEAST_PILOT: u32 = 32;

/// Least number of entries of a block whose equal ones are added up before it grows.
const WORTH_SORTING: usize = 4_096;

/// Bytes of a process before it reads a model, and of each patch, about.
const PROCESS_BYTES: f64 = 8e6;
const PATCH_BYTES: f64 = 700.0;

/// Bytes per row of blocks while they grow, for 1,024 rays a row and 100,000 rows of a closed room, and the
/// power of the number of rows with which they grow. In an open city 0.3 to 0.7 of it from 5,000 to
/// 100,000 rows.
const BLOCK_BYTES: f64 = 3_750.0;
const BLOCK_GROWTH: f64 = 0.4;

/// Bytes of each ray of the rows in progress: found, sorted by columns, and by blocks.
const RAY_BYTES: f64 = 96.0;

/// Bytes at the peak of the work by rays: an upper estimate.
pub(super) fn forecast_bytes(plan: &PreparedPlan) -> u64 {
    let (rows, rays) = (plan.rows() as f64, f64::from(plan.requested_rays()));
    let pilot = f64::from(pilot_rays(plan.requested_rays())) * size_of::<PairArea>() as f64;
    let blocks = BLOCK_BYTES * (rays / 1_024.0) * (rows / 1e5).powf(BLOCK_GROWTH);
    let work = (BLOCK as f64).min(rows) * rays * RAY_BYTES;
    (PROCESS_BYTES + work + rows * (PATCH_BYTES + pilot + blocks)) as u64
}

/// Rays of a row that choose blocks.
fn pilot_rays(rays: u32) -> u32 {
    (rays / PILOT).max(LEAST_PILOT)
}

impl CompressedFactors {
    /// Computes form factors by rays, as many for each row as the plan's options say, mirrors and glass
    /// included, without the matrix between all rows: the memory is that of the result, of the rays
    /// that choose the blocks (1/8 of them, 12 bytes each) and of one block of rows.
    ///
    /// A block of which these rays cannot tell, within the tolerance and their noise, whether it is
    /// other than u vᵀ is stored so: u_i is what the rays of row i exchange with the cluster of the
    /// columns, v_j what those of j exchange with the cluster of the rows. Both sums of a block are the
    /// ones found, all values are positive, and the noise of single pairs is averaged away. Radiosities
    /// that vary within a cluster are averaged too, with the weights v.
    ///
    /// Formulas for near pairs are not used, whatever the options; nor are item buffers. The same bits
    /// for any number of threads.
    ///
    /// # Errors
    /// [`CompressionError`].
    pub fn from_rays(
        plan: &PreparedPlan,
        options: &CompressionOptions,
        progress: &Progress,
    ) -> Result<CompressedFactors, CompressionError> {
        options.check()?;
        let (places, areas) = (plan.places(), plan.areas());
        let clusters = Clusters::new(&places, &areas, LEAF);
        let shapes = shapes(plan, &clusters, options.tolerance, progress)?;
        let stream = plan.row_stream(plan.requested_rays(), 1);
        let mut filling = Filling::new(&clusters, shapes);
        let n = areas.len();
        let mut factors = CompressedFactors {
            areas,
            ends: stream.ends.clone(),
            rest: vec![Default::default(); n],
            sum_errors: vec![0.0; n],
            entry_noise: vec![1.0 / f64::from(stream.rays()); n],
            bound: f64::NAN,
            rays: n as u64 * u64::from(stream.rays()),
            ..CompressedFactors::default()
        };
        let mut ended = vec![0.0; n];
        progress.begin("form factors", n as u64);
        for (block, rows) in clusters.tree.order.chunks(BLOCK).enumerate() {
            let streamed = stream.rows(rows, progress)?;
            filling.add((block * BLOCK) as u32, &streamed);
            for (&row, streamed) in rows.iter().zip(&streamed) {
                let row = row as usize;
                factors.rest[row] = streamed.rest;
                (ended[row], factors.sum_errors[row]) = streamed.ended;
            }
        }
        factors.parts = store(filling.drafts());
        factors.order = clusters.tree.order;
        if options.keep_sums {
            factors.keep_sums(&ended, progress)?;
        }
        Ok(factors)
    }
}

/// Blocks chosen by a part of the rays.
fn shapes(
    plan: &PreparedPlan,
    clusters: &Clusters,
    tolerance: f64,
    progress: &Progress,
) -> Result<Vec<BlockShape>, Cancelled> {
    let rays = plan.requested_rays();
    let pilot = plan.row_stream(pilot_rays(rays), 0);
    let (mut pairs, light) = pilot_pairs(&pilot, clusters, progress)?;
    let partition = Partition {
        clusters,
        allowed: tolerance * light / clusters.whole(),
        rays: f64::from(pilot.rays()),
        more: f64::from(rays) / f64::from(pilot.rays()),
        progress,
    };
    partition.diagonal(0, &mut pairs)
}

/// What the rays find of each pair, and Σ A_i X_ij.
fn pilot_pairs(
    pilot: &RowStream,
    clusters: &Clusters,
    progress: &Progress,
) -> Result<(Vec<PairArea>, f64), Cancelled> {
    let (positions, areas) = (clusters.positions(), &clusters.areas);
    let (mut pairs, mut light) = (Vec::new(), 0.0);
    progress.begin("clusters", areas.len() as u64);
    for (block, rows) in clusters.tree.order.chunks(BLOCK).enumerate() {
        for (k, row) in pilot.rows(rows, progress)?.iter().enumerate() {
            let p = block * BLOCK + k;
            for &(column, weight) in &row.entries {
                let q = positions[column as usize];
                let value = pooled(areas[p], areas[q as usize]) * f64::from(weight);
                light += areas[p] * f64::from(weight);
                pairs.push(PairArea::new(p as u32, q, value as f32));
            }
        }
    }
    Ok((pairs, light))
}

/// Blocks being filled.
struct Filling<'a> {
    clusters: &'a Clusters,
    positions: Vec<u32>,
    shapes: Vec<BlockShape>,
    /// Where the numbers of each link begin among `sums`.
    starts: Vec<usize>,
    /// For each link what each row exchanges with the columns, as its own rays found it, then what each
    /// column does with the rows.
    sums: Vec<f32>,
    /// The entries of each block that is not a link.
    entries: Vec<Vec<(u16, u16, f32)>>,
    /// For the leaf of each position its place in `views`.
    leaves: Vec<u32>,
    /// For each leaf the blocks that it is part of, by what they show: a division of all positions.
    views: Vec<Vec<LeafBlock>>,
}

/// One block as one of its leaves sees it.
#[derive(Clone, Copy)]
struct LeafBlock {
    /// The first position that is seen.
    start: u32,
    block: u32,
    /// Whether the leaf is among the columns.
    is_back: bool,
}

/// What one row found, by block.
struct RowShares {
    /// Index into `sums`, and exchange area.
    links: Vec<(usize, f32)>,
    /// Block, row, column and value of entries.
    entries: Vec<(u32, u16, u16, f32)>,
}

impl<'a> Filling<'a> {
    fn new(clusters: &'a Clusters, shapes: Vec<BlockShape>) -> Filling<'a> {
        let leaves = clusters.leaves();
        let mut position_leaves = vec![0; clusters.areas.len()];
        for (k, leaf) in leaves.iter().enumerate() {
            position_leaves[leaf.start as usize..leaf.end as usize].fill(k as u32);
        }
        // Where the sums of each link begin, and from which block on each leaf sees it.
        let (mut starts, mut count) = (Vec::with_capacity(shapes.len()), 0);
        let mut views = vec![Vec::new(); leaves.len()];
        for (block, shape) in shapes.iter().enumerate() {
            starts.push(count);
            let [rows, columns] = clusters.ranges(shape.nodes);
            if shape.is_link {
                count += rows.len() + columns.len();
            }
            let mut show = |to: &Range<u32>, start: u32, is_back: bool| {
                let first = position_leaves[to.start as usize] as usize;
                let last = position_leaves[to.end as usize - 1] as usize;
                let view = LeafBlock {
                    start,
                    block: block as u32,
                    is_back,
                };
                views[first..=last].iter_mut().for_each(|v| v.push(view));
            };
            show(&rows, columns.start, false);
            if shape.nodes.0 != shape.nodes.1 {
                show(&columns, rows.start, true);
            }
        }
        views
            .iter_mut()
            .for_each(|v| v.sort_unstable_by_key(|view| view.start));
        Filling {
            positions: clusters.positions(),
            entries: vec![Vec::new(); shapes.len()],
            sums: vec![0.0; count],
            clusters,
            shapes,
            starts,
            leaves: position_leaves,
            views,
        }
    }

    /// Adds rows of positions from `first` on.
    fn add(&mut self, first: u32, rows: &[StreamedRow]) {
        let shares = |(k, row): (usize, &StreamedRow)| self.shares(first + k as u32, row);
        let row_shares: Vec<RowShares> = rows.par_iter().enumerate().map(shares).collect();
        for shares in row_shares {
            for (at, value) in shares.links {
                self.sums[at] += value;
            }
            for (block, p, q, value) in shares.entries {
                let entries = &mut self.entries[block as usize];
                if entries.len() == entries.capacity() && entries.len() >= WORTH_SORTING {
                    add_equal(entries);
                }
                entries.push((p, q, value));
            }
        }
    }

    /// The row of position `p`, by block.
    fn shares(&self, p: u32, row: &StreamedRow) -> RowShares {
        let areas = &self.clusters.areas;
        let own = areas[p as usize];
        let views = &self.views[self.leaves[p as usize] as usize];
        let mut links = vec![0.0; views.len()];
        let mut entries = Vec::new();
        for &(column, weight) in &row.entries {
            let (q, weight) = (self.positions[column as usize], f64::from(weight));
            // The blocks of a leaf divide all positions, so that there is a view that starts before.
            let k = views.partition_point(|view| view.start <= q) - 1;
            let shape = &self.shapes[views[k].block as usize];
            if shape.is_link {
                links[k] += own * weight;
                continue;
            }
            let (i, j) = if shape.nodes.0 == shape.nodes.1 {
                (p.min(q), p.max(q))
            } else if views[k].is_back {
                (q, p)
            } else {
                (p, q)
            };
            let value = pooled(own, areas[q as usize]) * weight;
            // What a patch sees of itself is found once, not from two sides.
            let ways = if p == q { 2.0 } else { 1.0 };
            let [rows, columns] = self.clusters.ranges(shape.nodes);
            let (i, j) = ((i - rows.start) as u16, (j - columns.start) as u16);
            entries.push((views[k].block, i, j, (ways * value) as f32));
        }
        let sums = views.iter().zip(links).filter(|(_, sum)| *sum > 0.0);
        let links = sums.map(|(view, sum)| (self.place(view, p), sum as f32));
        RowShares {
            links: links.collect(),
            entries,
        }
    }

    /// Where the sum of position `p` is stored.
    fn place(&self, view: &LeafBlock, p: u32) -> usize {
        let block = view.block as usize;
        let [rows, columns] = self.clusters.ranges(self.shapes[block].nodes);
        self.starts[block]
            + if view.is_back {
                rows.len() + (p - columns.start) as usize
            } else {
                (p - rows.start) as usize
            }
    }

    /// The blocks as they are stored.
    fn drafts(mut self) -> Vec<BlockDraft> {
        let entries = std::mem::take(&mut self.entries);
        let draft = |(k, mut entries): (usize, Vec<(u16, u16, f32)>)| {
            let shape = self.shapes[k];
            let [rows, columns] = self.clusters.ranges(shape.nodes);
            let content = if shape.is_link {
                let sums = &self.sums[self.starts[k]..][..rows.len() + columns.len()];
                let factors = self.link(sums, [&rows, &columns]);
                let rank = u32::from(!factors.is_empty());
                BlockNumbers::LowRank { rank, factors }
            } else {
                add_equal(&mut entries);
                entries.shrink_to_fit();
                BlockNumbers::Sparse(entries)
            };
            BlockDraft {
                rows,
                columns,
                content,
            }
        };
        entries.into_par_iter().enumerate().map(draft).collect()
    }

    /// u, then v, from what the two sides of a link found. The exchange area of the block is pooled as
    /// that of a pair of patches, with the mean areas of patches where rays start.
    fn link(&self, sums: &[f32], sides: [&Range<u32>; 2]) -> Vec<f32> {
        let side = |range: &Range<u32>, sums: &[f32]| -> (Vec<f64>, f64, f64) {
            let areas = &self.clusters.areas[range.start as usize..range.end as usize];
            let whole: f64 = areas.iter().sum();
            let mean = areas.iter().map(|a| a * a).sum::<f64>() / whole;
            let sum: f64 = sums.iter().map(|&s| f64::from(s)).sum();
            // A side whose rays found nothing takes its share evenly.
            let shares = if sum > 0.0 {
                sums.iter().map(|&s| f64::from(s) / sum).collect()
            } else {
                areas.iter().map(|a| a / whole).collect()
            };
            (shares, sum, mean.recip())
        };
        let (to_rows, to_columns) = sums.split_at(sides[0].len());
        let (u, s, weight) = side(sides[0], to_rows);
        let (v, t, other) = side(sides[1], to_columns);
        let sum = (s * weight + t * other) / (weight + other);
        if sum.is_nan() || sum <= 0.0 {
            return Vec::new();
        }
        u.iter()
            .chain(&v)
            .map(|share| (share * sum.sqrt()) as f32)
            .collect()
    }
}

/// Sorts entries and adds up those of the same place.
fn add_equal(entries: &mut Vec<(u16, u16, f32)>) {
    entries.sort_unstable_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    entries.dedup_by(|next, kept| {
        let is_same = (next.0, next.1) == (kept.0, kept.1);
        if is_same {
            kept.2 += next.2;
        }
        is_same
    });
}
