//! Overlapping pairs among many boxes.

use glam::DVec3;
use rayon::prelude::*;

/// Boxes per block, which are compared without a tree.
const BLOCK: usize = 8;
/// Limit of visited pairs of overlapping boxes, so that a scene in which everything overlaps ends;
/// 270 million take a few seconds.
const MOST_PAIRS: usize = 1 << 28;
/// Limit of stored results.
const MOST_FOUND: usize = 1 << 21;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub low: DVec3,
    pub high: DVec3,
    /// By how much it was enlarged on every side.
    pub margin: f64,
}

impl Bounds {
    pub const EMPTY: Bounds = Bounds {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
        margin: 0.0,
    };

    /// The longest extent of the intersection of two boxes; negative if they are apart.
    pub fn common(&self, other: &Bounds) -> f64 {
        (self.high.min(other.high) - self.low.max(other.low)).max_element()
    }

    pub fn around(points: impl Iterator<Item = DVec3>) -> Bounds {
        points.fold(Bounds::EMPTY, |b, p| Bounds {
            low: b.low.min(p),
            high: b.high.max(p),
            margin: 0.0,
        })
    }

    pub fn grown(self, margin: f64) -> Bounds {
        Bounds {
            low: self.low - margin,
            high: self.high + margin,
            margin,
        }
    }

    fn union(self, other: Bounds) -> Bounds {
        Bounds {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            margin: 0.0,
        }
    }

    fn overlaps(&self, other: &Bounds) -> bool {
        // Axis by axis: most boxes are separated by the first or second.
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }
}

/// Visits each pair of overlapping boxes once, and returns what `visit` appended, in an order
/// independent of threads. Beyond the limits above some pairs are left out.
pub(super) fn for_each_pair<T: Send>(
    boxes: &[Bounds],
    visit: impl Fn([u32; 2], [&Bounds; 2], &mut Vec<T>) + Sync,
) -> Vec<T> {
    let order = order(boxes);
    let sorted: Vec<Bounds> = order.iter().map(|&i| boxes[i as usize]).collect();
    let tree = PairTree::new(&sorted);
    let blocks = sorted.len().div_ceil(BLOCK);
    let (pairs, most) = (
        MOST_PAIRS / blocks.max(1),
        MOST_FOUND / blocks.max(1) + BLOCK,
    );
    let of_block = |block: usize| {
        let (mut found, mut left) = (Vec::new(), pairs);
        let first = block * BLOCK;
        let end = (first + BLOCK).min(sorted.len());
        tree.visit_from(block, |other| {
            let others = other * BLOCK..((other + 1) * BLOCK).min(sorted.len());
            let around = tree.block(other);
            for i in (first..end).filter(|&i| sorted[i].overlaps(around)) {
                for j in others.start.max(i + 1)..others.end {
                    if left > 0 && sorted[i].overlaps(&sorted[j]) {
                        left -= 1;
                        visit([order[i], order[j]], [&sorted[i], &sorted[j]], &mut found);
                    }
                }
            }
            left > 0 && found.len() < most
        });
        found
    };
    (0..blocks)
        .into_par_iter()
        .flat_map_iter(of_block)
        .collect()
}

/// Small boxes before large ones, neighbours together: a large box among small ones would make its
/// whole block large.
fn order(boxes: &[Bounds]) -> Vec<u32> {
    let all = boxes.iter().fold(Bounds::EMPTY, |b, c| b.union(*c));
    let scale = 1023.0 / (all.high - all.low).max(DVec3::splat(f64::MIN_POSITIVE));
    let mut keys: Vec<(u64, u32)> = (0..)
        .zip(boxes)
        .map(|(i, b)| {
            let extent = (b.high - b.low).max_element().max(1e-150);
            let class = (0.5 * extent.log2()).floor() as i64 + 512;
            let cell = (0.5 * (b.low + b.high) - all.low) * scale;
            let code = cell.to_array().map(|x| spread(x as u64 & 1023));
            let code = code[0] << 2 | code[1] << 1 | code[2];
            ((class as u64) << 30 | code, i)
        })
        .collect();
    keys.par_sort_unstable();
    keys.into_iter().map(|k| k.1).collect()
}

/// The ten bits of `x` with two zeros after each.
fn spread(x: u64) -> u64 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// A complete binary tree of boxes over blocks: node 1 is the root, node `i` has the children
/// `2i` and `2i + 1`, the blocks come last.
struct PairTree {
    nodes: Vec<Bounds>,
    leaves: usize,
}

impl PairTree {
    fn new(sorted: &[Bounds]) -> PairTree {
        let leaves = sorted.len().div_ceil(BLOCK).next_power_of_two();
        let mut nodes = vec![Bounds::EMPTY; 2 * leaves];
        for (node, block) in nodes[leaves..].iter_mut().zip(sorted.chunks(BLOCK)) {
            *node = block.iter().fold(Bounds::EMPTY, |b, c| b.union(*c));
        }
        for i in (1..leaves).rev() {
            nodes[i] = nodes[2 * i].union(nodes[2 * i + 1]);
        }
        PairTree { nodes, leaves }
    }

    fn block(&self, block: usize) -> &Bounds {
        &self.nodes[self.leaves + block]
    }

    /// Visits `block` and the later blocks that overlap it until `visit` returns false.
    fn visit_from(&self, block: usize, mut visit: impl FnMut(usize) -> bool) {
        let own = self.block(block);
        // Node and the blocks below it.
        let mut stack = vec![(1, 0..self.leaves)];
        while let Some((node, below)) = stack.pop() {
            if below.end <= block || !self.nodes[node].overlaps(own) {
                continue;
            }
            if node < self.leaves {
                let middle = (below.start + below.end) / 2;
                stack.push((2 * node + 1, middle..below.end));
                stack.push((2 * node, below.start..middle));
            } else if !visit(below.start) {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_those_of_all_with_all() {
        let mut state = 7u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005) + 1;
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        for count in [0, 1, 2, 9, 300] {
            let boxes: Vec<Bounds> = (0..count)
                .map(|k| {
                    let low = DVec3::new(next(), next(), next());
                    let size = if k % 17 == 0 { 0.6 } else { 0.08 };
                    let high = low + size * DVec3::new(next(), next(), next());
                    Bounds::around([low, high].into_iter())
                })
                .collect();
            let mut found = for_each_pair(&boxes, |[i, j], _, found| {
                found.push((i.min(j), i.max(j)));
            });
            found.sort_unstable();
            let n = boxes.len() as u32;
            let expected: Vec<(u32, u32)> = (0..n)
                .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
                .filter(|&(i, j)| boxes[i as usize].overlaps(&boxes[j as usize]))
                .collect();
            assert_eq!(found, expected);
        }
    }
}
