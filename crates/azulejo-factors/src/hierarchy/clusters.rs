//! Rows in the order of a tree, with what blocks need to know of its clusters.

use crate::cluster_tree::{ClusterNode, ClusterTree};
use crate::proxy::PointNormal;
use azulejo_scene::math::Aabb;
use std::ops::Range;

/// The nodes of rows and columns of a block.
pub(super) type NodePair = (usize, usize);

/// A tree over rows; *positions* are places in its order.
pub(super) struct Clusters {
    pub tree: ClusterTree,
    /// Area by position.
    pub areas: Vec<f64>,
    /// Sum of the areas before each position.
    sums: Vec<f64>,
    /// Box around the centres of each node.
    boxes: Vec<Aabb>,
}

impl Clusters {
    /// A tree over rows with these centres, normals and areas.
    pub fn new(places: &[PointNormal], areas: &[f64], leaf: usize) -> Clusters {
        let keys: Vec<_> = places.iter().map(|p| (p.position, p.normal)).collect();
        let whole = Aabb::around(places.iter().map(|p| p.position));
        let tree = ClusterTree::new(&keys, whole.size().max_element(), leaf);
        let areas: Vec<f64> = tree.order.iter().map(|&i| areas[i as usize]).collect();
        let mut sums = vec![0.0];
        for area in &areas {
            sums.push(sums[sums.len() - 1] + area);
        }
        let centres = |node: &ClusterNode| {
            let rows = &tree.order[node.range.start as usize..node.range.end as usize];
            Aabb::around(rows.iter().map(|&i| places[i as usize].position))
        };
        Clusters {
            boxes: tree.nodes.iter().map(centres).collect(),
            tree,
            areas,
            sums,
        }
    }

    pub fn node(&self, node: usize) -> &ClusterNode {
        &self.tree.nodes[node]
    }

    /// The positions of the rows and of the columns of a block.
    pub fn ranges(&self, (a, b): NodePair) -> [Range<u32>; 2] {
        [a, b].map(|node| self.node(node).range.clone())
    }

    /// The halves of a node that is not a leaf.
    pub fn children(&self, node: usize) -> [usize; 2] {
        [node + 1, self.tree.nodes[node].second as usize]
    }

    /// The leaves, in order of positions.
    pub fn leaves(&self) -> Vec<Range<u32>> {
        let leaves = self.tree.nodes.iter().filter(|n| n.is_leaf());
        leaves.map(|n| n.range.clone()).collect()
    }

    /// Area of a range of positions.
    pub fn area(&self, range: &Range<u32>) -> f64 {
        self.sums[range.end as usize] - self.sums[range.start as usize]
    }

    /// The whole area.
    pub fn whole(&self) -> f64 {
        self.sums[self.sums.len() - 1]
    }

    /// Diagonal of the box around a node's centres.
    pub fn diameter(&self, node: usize) -> f64 {
        self.boxes[node].size().length()
    }

    /// Distance of the boxes of two nodes.
    pub fn distance(&self, a: usize, b: usize) -> f64 {
        let (a, b) = (&self.boxes[a], &self.boxes[b]);
        let gap = (a.min - b.max).max(b.min - a.max);
        gap.max(glam::DVec3::ZERO).length()
    }

    /// The position of each row.
    pub fn positions(&self) -> Vec<u32> {
        let mut positions = vec![0; self.tree.order.len()];
        for (position, &row) in self.tree.order.iter().enumerate() {
            positions[row as usize] = position as u32;
        }
        positions
    }

    /// Divides the block of a node with itself, of which these are the pairs: `diagonal` of its first half,
    /// `between` of both halves, `diagonal` of the second.
    pub fn quartered<D: Send, B: Send>(
        &self,
        node: usize,
        pairs: &mut [PairArea],
        diagonal: impl Fn(usize, &mut [PairArea]) -> D + Sync,
        between: impl FnOnce(NodePair, &mut [PairArea]) -> B + Send,
    ) -> (D, B, D) {
        let [a, b] = self.children(node);
        let middle = self.node(b).range.start;
        let count = pairs.len();
        let (first, rest) = divided(pairs, |e| e.q < middle);
        let (beside, second) = divided(rest, |e| e.p < middle);
        let ((first, second), beside) = both(
            count,
            || (diagonal(a, first), diagonal(b, second)),
            || between((a, b), beside),
        );
        (first, beside, second)
    }

    /// Divides the block between two nodes, of which these are the pairs, at the larger node that is not a
    /// leaf: its halves, each with its `part`. `None` for two leaves.
    pub fn halved<T: Send>(
        &self,
        (a, b): NodePair,
        pairs: &mut [PairArea],
        part: impl Fn(NodePair, &mut [PairArea]) -> T + Sync,
    ) -> Option<[(NodePair, T); 2]> {
        let count = pairs.len();
        let is_leaf = |node: usize| self.node(node).is_leaf();
        // By numbers, so that boxes of one point are divided too.
        let divides_rows = is_leaf(b) || self.node(a).len() >= self.node(b).len();
        let (halves, (first, second)) = if !is_leaf(a) && divides_rows {
            let [upper, lower] = self.children(a);
            let middle = self.node(lower).range.start;
            ([(upper, b), (lower, b)], divided(pairs, |e| e.p < middle))
        } else if !is_leaf(b) {
            let [left, right] = self.children(b);
            let middle = self.node(right).range.start;
            ([(a, left), (a, right)], divided(pairs, |e| e.q < middle))
        } else {
            return None;
        };
        let (one, other) = both(count, || part(halves[0], first), || part(halves[1], second));
        Some([(halves[0], one), (halves[1], other)])
    }
}

/// The exchange area of two positions p ≤ q, or what a ray found of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PairArea {
    pub p: u32,
    pub q: u32,
    pub value: f32,
}

impl PairArea {
    pub fn new(a: u32, b: u32, value: f32) -> PairArea {
        PairArea {
            p: a.min(b),
            q: a.max(b),
            value,
        }
    }
}

/// Moves the pairs for which `is_first` holds to the front, and divides there.
fn divided(
    pairs: &mut [PairArea],
    is_first: impl Fn(&PairArea) -> bool,
) -> (&mut [PairArea], &mut [PairArea]) {
    let mut count = 0;
    for k in 0..pairs.len() {
        if is_first(&pairs[k]) {
            pairs.swap(k, count);
            count += 1;
        }
    }
    pairs.split_at_mut(count)
}

/// Least number of pairs for which the halves of a block are worth two threads.
const WORTH_THREADS: usize = 10_000;

/// Both results, computed in parallel if there is enough to do.
fn both<A: Send, B: Send>(
    pairs: usize,
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    if pairs < WORTH_THREADS {
        (a(), b())
    } else {
        rayon::join(a, b)
    }
}
