//! The bounding volume hierarchy: nodes of eight boxes over packets of triangles.

use super::build::{BinaryNode, Bounds, Reference};
use super::triangle::{PACKET, Packet};

/// Children of one node.
pub(crate) const WIDTH: usize = 8;

/// Eight children: their boxes side by side, and their indices.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct BvhNode {
    /// `[2 * axis + side][child]`, side 0 is the lower one. Unused children have an empty box,
    /// which no ray hits.
    pub planes: [[f32; WIDTH]; 6],
    /// [`Child`] in its packed form.
    pub children: [u32; WIDTH],
}

impl BvhNode {
    const EMPTY: BvhNode = BvhNode {
        planes: [
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [0; WIDTH],
    };

    fn set(&mut self, slot: usize, bounds: &Bounds, child: u32) {
        for axis in 0..3 {
            self.planes[2 * axis][slot] = bounds.min[axis];
            self.planes[2 * axis + 1][slot] = bounds.max[axis];
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
    /// Nodes on the longest path from the root to a leaf.
    pub depth: usize,
}

/// A triangle in kernel coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KernelTriangle {
    pub corners: [[f32; 3]; 3],
    pub item: u32,
}

impl Bvh {
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
            };
            bvh.nodes.reserve(references.len() / 12 + 1);
            bvh.packets.reserve(references.len() / 3 + 1);
            bvh.add_node(&source, 0, 1);
        }
        bvh
    }

    fn add_node(&mut self, source: &Source, binary: usize, depth: usize) -> u32 {
        self.depth = self.depth.max(depth);
        let index = self.nodes.len();
        self.nodes.push(BvhNode::EMPTY);
        let mut opened = [0; WIDTH];
        let count = source.open(binary, &mut opened);
        for (slot, &b) in opened[..count].iter().enumerate() {
            let node = &source.binary[b];
            let child = if node.is_leaf() {
                self.add_leaf(source, node)
            } else {
                self.add_node(source, b, depth + 1)
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
}

impl Source<'_> {
    /// Replaces the inner node of largest area by its two children until there are eight.
    fn open(&self, root: usize, opened: &mut [usize; WIDTH]) -> usize {
        opened[0] = root;
        let mut count = 1;
        while count < WIDTH {
            let inner = (0..count).filter(|&k| !self.binary[opened[k]].is_leaf());
            let area = |k: usize| self.binary[opened[k]].bounds.half_area();
            let Some(widest) = inner.reduce(|a, b| if area(b) > area(a) { b } else { a }) else {
                break;
            };
            let node = opened[widest];
            opened[widest] = node + 1;
            opened[count] = node + self.binary[node].right as usize;
            count += 1;
        }
        count
    }
}
