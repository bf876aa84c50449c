//! Overlapping pairs among many boxes.

use azulejo_scene::math::Aabb;
use glam::DVec3;
use rayon::prelude::*;

/// Boxes per block, which are compared without a tree.
const BLOCK: usize = 8;
/// Limit of visited pairs of overlapping boxes, so that a scene in which everything overlaps ends;
/// 270 million take a few seconds.
const MOST_PAIRS: usize = 1 << 28;
/// Limit of stored results.
const MOST_RESULTS: usize = 1 << 21;

/// The box enlarged by a margin on every side.
pub(super) fn grown(bounds: Aabb, margin: f64) -> Aabb {
    Aabb {
        min: bounds.min - margin,
        max: bounds.max + margin,
    }
}

fn overlaps(a: &Aabb, b: &Aabb) -> bool {
    // Axis by axis: most boxes are separated by the first or second.
    (0..3).all(|k| a.min[k] <= b.max[k] && b.min[k] <= a.max[k])
}

fn around(boxes: &[Aabb]) -> Aabb {
    boxes.iter().fold(Aabb::EMPTY, |a, b| a.union(*b))
}

/// Visits the numbers of each pair of overlapping boxes once, and returns what `visit` appended, in an order
/// independent of threads. Beyond the limits above some pairs are left out.
pub(super) fn for_each_pair<T: Send>(
    boxes: &[Aabb],
    visit: impl Fn([u32; 2], &mut Vec<T>) + Sync,
) -> Vec<T> {
    let order = order(boxes);
    let sorted: Vec<Aabb> = order.iter().map(|&i| boxes[i as usize]).collect();
    let tree = PairTree::new(&sorted);
    let blocks = sorted.len().div_ceil(BLOCK);
    let most_pairs = MOST_PAIRS / blocks.max(1);
    let most_results = MOST_RESULTS / blocks.max(1) + BLOCK;
    let visit_block = |block: usize| {
        let (mut results, mut left) = (Vec::new(), most_pairs);
        let first = block * BLOCK;
        let end = (first + BLOCK).min(sorted.len());
        tree.visit_from(block, |other| {
            let others = other * BLOCK..((other + 1) * BLOCK).min(sorted.len());
            let around = tree.block(other);
            for i in (first..end).filter(|&i| overlaps(&sorted[i], around)) {
                for j in others.start.max(i + 1)..others.end {
                    if left > 0 && overlaps(&sorted[i], &sorted[j]) {
                        left -= 1;
                        visit([order[i], order[j]], &mut results);
                    }
                }
            }
            left > 0 && results.len() < most_results
        });
        results
    };
    let blocks = (0..blocks).into_par_iter();
    blocks.flat_map_iter(visit_block).collect()
}

/// Small boxes before large ones, neighbours together: a large box among small ones would make its
/// whole block large.
fn order(boxes: &[Aabb]) -> Vec<u32> {
    let whole = around(boxes);
    let scale = 1023.0 / (whole.max - whole.min).max(DVec3::splat(f64::MIN_POSITIVE));
    let mut keys: Vec<(u64, u32)> = (0..)
        .zip(boxes)
        .map(|(i, b)| {
            let extent = (b.max - b.min).max_element().max(1e-150);
            let class = (0.5 * extent.log2()).floor() as i64 + 512;
            let cell = (0.5 * (b.min + b.max) - whole.min) * scale;
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
    nodes: Vec<Aabb>,
    leaves: usize,
}

impl PairTree {
    fn new(sorted: &[Aabb]) -> PairTree {
        let leaves = sorted.len().div_ceil(BLOCK).next_power_of_two();
        let mut nodes = vec![Aabb::EMPTY; 2 * leaves];
        for (node, block) in nodes[leaves..].iter_mut().zip(sorted.chunks(BLOCK)) {
            *node = around(block);
        }
        for i in (1..leaves).rev() {
            nodes[i] = nodes[2 * i].union(nodes[2 * i + 1]);
        }
        PairTree { nodes, leaves }
    }

    fn block(&self, block: usize) -> &Aabb {
        &self.nodes[self.leaves + block]
    }

    /// Visits `block` and the later blocks that overlap it until `visit` returns false.
    fn visit_from(&self, block: usize, mut visit: impl FnMut(usize) -> bool) {
        let own = self.block(block);
        // Node and the blocks below it.
        let mut stack = vec![(1, 0..self.leaves)];
        while let Some((node, below)) = stack.pop() {
            if below.end <= block || !overlaps(&self.nodes[node], own) {
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
            let boxes: Vec<Aabb> = (0..count)
                .map(|k| {
                    let low = DVec3::new(next(), next(), next());
                    let size = if k % 17 == 0 { 0.6 } else { 0.08 };
                    let high = low + size * DVec3::new(next(), next(), next());
                    Aabb::around([low, high])
                })
                .collect();
            let mut pairs = for_each_pair(&boxes, |[i, j], pairs| {
                pairs.push((i.min(j), i.max(j)));
            });
            pairs.sort_unstable();
            let n = boxes.len() as u32;
            let expected: Vec<(u32, u32)> = (0..n)
                .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
                .filter(|&(i, j)| overlaps(&boxes[i as usize], &boxes[j as usize]))
                .collect();
            assert_eq!(pairs, expected);
        }
    }
}
