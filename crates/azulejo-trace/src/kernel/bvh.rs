//! The bounding volume hierarchy: nodes of eight boxes over packets of triangles.

use super::build::{BinaryNode, Bounds, Reference};
use super::triangle::{PACKET, Packet};

/// Children of one node.
pub(crate) const WIDTH: usize = 8;

/// Eight children: their boxes side by side, and their indices.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct BvhNode {
    /// `[axis][side][child]`, side 0 is the lower one. Unused children have an empty box, which no
    /// ray hits.
    pub planes: [[[f32; WIDTH]; 2]; 3],
    /// [`Child`] in its packed form.
    pub children: [u32; WIDTH],
}

/// Bytes of a tree that is mostly read from the caches: several rays in flight gain nothing there (measured in rooms
/// of 7,000 and 34,000 triangles).
const CACHE: usize = 8 << 20;

impl BvhNode {
    const EMPTY: BvhNode = BvhNode {
        planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [0; WIDTH],
    };

    fn set(&mut self, slot: usize, bounds: &Bounds, child: u32) {
        for axis in 0..3 {
            self.planes[axis][0][slot] = bounds.min[axis];
            self.planes[axis][1][slot] = bounds.max[axis];
        }
        self.children[slot] = child;
    }
}

/// A child: a node, some packets, or some shapes that are not triangles.
///
/// Packed: bit 31 marks leaves, bit 30 other shapes, bits 26–29 hold the count less one, the rest
/// the first index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Child;

impl Child {
    pub(crate) const LEAF: u32 = 1 << 31;
    pub(crate) const OTHER: u32 = 1 << 30;
    const COUNT_SHIFT: u32 = 26;
    const FIRST: u32 = (1 << Child::COUNT_SHIFT) - 1;
    /// Largest number of packets, or other shapes, in one leaf.
    pub(crate) const MOST: usize = 16;

    fn leaf(kind: u32, first: usize, count: usize) -> u32 {
        assert!(
            first <= Child::FIRST as usize && (1..=Child::MOST).contains(&count),
            "a tracer holds at most 2^26 packets of triangles"
        );
        Child::LEAF | kind | ((count as u32 - 1) << Child::COUNT_SHIFT) | first as u32
    }

    /// The content of a leaf.
    #[inline(always)]
    pub(crate) fn range(leaf: u32) -> std::ops::Range<usize> {
        let first = (leaf & Child::FIRST) as usize;
        first..first + (((leaf >> Child::COUNT_SHIFT) & 15) + 1) as usize
    }
}

/// The tree, its packets, and the order of the shapes that are not triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bvh {
    /// The root is the first; none for an empty scene.
    pub nodes: Vec<BvhNode>,
    pub packets: Vec<Packet>,
    /// The shapes that are not triangles, in the order to which leaves refer.
    pub others: Vec<u32>,
}

/// A triangle in kernel coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KernelTriangle {
    pub corners: [[f32; 3]; 3],
    pub item: u32,
}

impl Bvh {
    /// Whether nodes and triangles are mostly read from the processor's caches.
    pub fn fits_the_cache(&self) -> bool {
        size_of_val(&*self.nodes) + size_of_val(&*self.packets) <= CACHE
    }

    /// Collapses a binary tree to nodes of eight. References below `triangles.len()` are triangles,
    /// the rest others.
    pub(crate) fn collapse(
        binary: &[BinaryNode],
        references: &[Reference],
        triangles: &[KernelTriangle],
    ) -> Bvh {
        let mut bvh = Bvh::default();
        if !binary.is_empty() {
            let source = Source {
                binary,
                references,
                triangles,
                costs: collapse_costs(binary),
            };
            bvh.nodes.reserve(references.len() / 12 + 1);
            bvh.packets.reserve(references.len() / 3 + 1);
            bvh.add_node(&source, 0);
        }
        bvh
    }

    fn add_node(&mut self, source: &Source, binary: usize) -> u32 {
        let index = self.nodes.len();
        self.nodes.push(BvhNode::EMPTY);
        for (slot, b) in source.children(binary).into_iter().enumerate() {
            let node = &source.binary[b];
            let child = if node.is_leaf() {
                self.add_leaf(source, node)
            } else {
                self.add_node(source, b)
            };
            self.nodes[index].set(slot, &node.bounds, child);
        }
        index as u32
    }

    fn add_leaf(&mut self, source: &Source, node: &BinaryNode) -> u32 {
        let references = &source.references[node.range()];
        if references[0].id() as usize >= source.triangles.len() {
            let first = self.others.len();
            let shape = |r: &Reference| r.id() - source.triangles.len() as u32;
            self.others.extend(references.iter().map(shape));
            return Child::leaf(Child::OTHER, first, references.len());
        }
        let first = self.packets.len();
        for chunk in references.chunks(PACKET) {
            let mut packet = Packet::EMPTY;
            for (lane, r) in chunk.iter().enumerate() {
                let t = &source.triangles[r.id() as usize];
                packet.set(lane, &t.corners, t.item);
            }
            self.packets.push(packet);
        }
        Child::leaf(0, first, self.packets.len() - first)
    }
}

struct Source<'a> {
    binary: &'a [BinaryNode],
    references: &'a [Reference],
    triangles: &'a [KernelTriangle],
    costs: Vec<[f32; WIDTH]>,
}

/// For each binary node the least area of the nodes of eight at and below it, if it becomes one child of a node, at most
/// two, and so on; leaves cost nothing.
///
/// Ylitie, Karras and Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
/// BVHs*, HPG 2017.
fn collapse_costs(binary: &[BinaryNode]) -> Vec<[f32; WIDTH]> {
    let mut costs = vec![[0.0; WIDTH]; binary.len()];
    for (index, node) in binary.iter().enumerate().rev() {
        if node.is_leaf() {
            continue;
        }
        let (left, right) = (costs[index + 1], costs[index + node.right as usize]);
        let mut least = f32::INFINITY;
        for count in 1..WIDTH {
            for k in 0..count {
                least = least.min(left[k] + right[count - 1 - k]);
            }
            costs[index][count] = least;
        }
        costs[index][0] = least + node.bounds.half_area();
    }
    costs
}

impl Source<'_> {
    /// The children of a node of eight, in the order from the last to the first in which any hit is found soonest:
    /// leaves before nodes, small ones before large ones.
    fn children(&self, root: usize) -> Vec<usize> {
        let mut children = Vec::with_capacity(WIDTH);
        self.open(root, WIDTH, &mut children);
        children.sort_by(|&a, &b| {
            let [a, b] = [&self.binary[a], &self.binary[b]];
            let by_area = b.bounds.half_area().total_cmp(&a.bounds.half_area());
            a.is_leaf().cmp(&b.is_leaf()).then(by_area)
        });
        children
    }

    /// Appends the nodes below one, or a leaf itself, that become `count` children at most, at the least cost.
    fn open(&self, node: usize, count: usize, opened: &mut Vec<usize>) {
        if self.binary[node].is_leaf() {
            return opened.push(node);
        }
        let (left, right) = (node + 1, node + self.binary[node].right as usize);
        let cost = |k: usize| self.costs[left][k - 1] + self.costs[right][count - k - 1];
        let split = (2..count).fold(1, |best, k| if cost(k) < cost(best) { k } else { best });
        for (child, count) in [(left, split), (right, count - split)] {
            let costs = &self.costs[child];
            if count == 1 || costs[0] <= costs[count - 1] {
                opened.push(child);
            } else {
                self.open(child, count, opened);
            }
        }
    }
}
