//! Builds a binary tree by the surface area heuristic.
//!
//! Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies*, 2007: the centres of
//! the boxes go into bins along each axis, and the cheapest plane between two bins divides them.
//! Leaves are charged by the packet, not by the triangle.

use super::triangle::PACKET;
use glam::{DVec3, Vec3A, Vec4, Vec4Swizzles};
use std::ops::Range;

const BINS: usize = 16;
/// Leaves larger than this are divided at any cost.
const LARGEST_LEAF: usize = 16;
/// Cost of traversing a binary node, a third of one of eight children, in units of testing a packet.
const STEP_COST: f32 = 0.4;
/// From this depth on ranges are halved by count, so that the depth is bounded for any input.
const HALVING_DEPTH: u32 = 48;
/// Length of the longest path: [`HALVING_DEPTH`] and the halvings of 2^32 references.
pub(crate) const DEEPEST: usize = HALVING_DEPTH as usize + 33;
/// Ranges longer than this are divided between two threads.
const SHARED_WORK: usize = 16 * 1024;

/// A box, `f32`; lanes 3 are unused.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub min: Vec4,
    pub max: Vec4,
}

impl Bounds {
    pub(crate) const EMPTY: Bounds = Bounds {
        min: Vec4::INFINITY,
        max: Vec4::NEG_INFINITY,
    };

    #[inline]
    pub(crate) fn union(self, o: Bounds) -> Bounds {
        Bounds {
            min: self.min.min(o.min),
            max: self.max.max(o.max),
        }
    }

    #[inline]
    fn with_point(self, p: Vec4) -> Bounds {
        Bounds {
            min: self.min.min(p),
            max: self.max.max(p),
        }
    }

    /// Half the surface area; 0 for the empty box.
    #[inline]
    pub(crate) fn half_area(&self) -> f32 {
        let d = Vec3A::from_vec4(self.max - self.min).max(Vec3A::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

/// A box with the number of its content.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference {
    /// Lane 3 carries the number, as the bits of a float: [`Reference::FIRST_ID`] and up.
    min: Vec4,
    max: Vec4,
}

impl Reference {
    /// Numbers start here, so that as floats they are small but not denormal, which would slow down
    /// arithmetic on all four lanes.
    const FIRST_ID: u32 = 0x2000_0000;

    pub(crate) fn new(min: [f32; 3], max: [f32; 3], id: u32) -> Reference {
        Reference {
            min: Vec4::new(
                min[0],
                min[1],
                min[2],
                f32::from_bits(Reference::FIRST_ID + id),
            ),
            max: Vec4::new(max[0], max[1], max[2], 0.0),
        }
    }

    /// Whether the box is valid for a tree.
    pub(crate) fn is_finite(&self) -> bool {
        self.min.xyz().is_finite() && self.max.xyz().is_finite()
    }

    #[inline]
    pub(crate) fn id(&self) -> u32 {
        self.min.w.to_bits() - Reference::FIRST_ID
    }

    #[inline]
    fn bounds(&self) -> Bounds {
        Bounds {
            min: self.min,
            max: self.max,
        }
    }

    /// Twice the box's centre.
    #[inline]
    fn centre2(&self) -> Vec4 {
        self.min + self.max
    }
}

/// A node of the binary tree; its left child is the next node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BinaryNode {
    pub bounds: Bounds,
    /// Distance to the right child; 0 for a leaf.
    pub right: u32,
    first: u32,
    count: u32,
}

impl BinaryNode {
    pub(crate) fn is_leaf(&self) -> bool {
        self.right == 0
    }

    /// Whether a line may cross the box, enlarged by `margin` and by the rounding of `f32`.
    pub(crate) fn may_be_crossed(&self, origin: DVec3, inverse: DVec3, margin: f64) -> bool {
        let corner = |v: Vec4| v.xyz().as_dvec3() - origin;
        let low = corner(self.bounds.min) - margin;
        let high = corner(self.bounds.max) + margin;
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            if inverse[axis].is_finite() {
                let (a, b) = (low[axis] * inverse[axis], high[axis] * inverse[axis]);
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            } else if low[axis] > 0.0 || high[axis] < 0.0 {
                return false;
            }
        }
        enter <= leave
    }

    /// The references below it.
    pub(crate) fn range(&self) -> Range<usize> {
        self.first as usize..self.first as usize + self.count as usize
    }
}

/// A range of references and the boxes around them and around their centres.
#[derive(Clone, Copy)]
struct Extent {
    bounds: Bounds,
    centres2: Bounds,
}

impl Extent {
    const EMPTY: Extent = Extent {
        bounds: Bounds::EMPTY,
        centres2: Bounds::EMPTY,
    };

    #[inline]
    fn with(self, r: &Reference) -> Extent {
        Extent {
            bounds: self.bounds.union(r.bounds()),
            centres2: self.centres2.with_point(r.centre2()),
        }
    }

    fn of(references: &[Reference]) -> Extent {
        references.iter().fold(Extent::EMPTY, Extent::with)
    }
}

/// Builds the tree and orders the references so that every node has one range of them.
///
/// References from `first_other` on are not triangles; no leaf mixes the two. The result does
/// not depend on the number of threads.
pub(crate) fn binary_tree(references: &mut [Reference], first_other: u32) -> Vec<BinaryNode> {
    if references.is_empty() {
        return Vec::new();
    }
    let extent = Extent::of(references);
    let builder = BvhBuilder { first_other };
    builder.shared(references, 0, extent, 0)
}

struct BvhBuilder {
    first_other: u32,
}

impl BvhBuilder {
    fn shared(
        &self,
        references: &mut [Reference],
        first: usize,
        extent: Extent,
        depth: u32,
    ) -> Vec<BinaryNode> {
        if references.len() <= SHARED_WORK {
            let mut nodes = Vec::with_capacity(references.len() / 2 + 1);
            self.alone(&mut nodes, references, first, extent, depth);
            return nodes;
        }
        let count = references.len();
        let Some((middle, left, right)) = self.divide(references, &extent, depth) else {
            return vec![leaf(extent.bounds, first, count)];
        };
        let (low, high) = references.split_at_mut(middle);
        let (low, high) = rayon::join(
            || self.shared(low, first, left, depth + 1),
            || self.shared(high, first + middle, right, depth + 1),
        );
        let mut nodes = Vec::with_capacity(1 + low.len() + high.len());
        let mut node = leaf(extent.bounds, first, count);
        node.right = 1 + low.len() as u32;
        nodes.push(node);
        nodes.extend(low);
        nodes.extend(high);
        nodes
    }

    fn alone(
        &self,
        nodes: &mut Vec<BinaryNode>,
        references: &mut [Reference],
        first: usize,
        extent: Extent,
        depth: u32,
    ) {
        let index = nodes.len();
        nodes.push(leaf(extent.bounds, first, references.len()));
        let Some((middle, left, right)) = self.divide(references, &extent, depth) else {
            return;
        };
        let (low, high) = references.split_at_mut(middle);
        self.alone(nodes, low, first, left, depth + 1);
        nodes[index].right = (nodes.len() - index) as u32;
        self.alone(nodes, high, first + middle, right, depth + 1);
    }

    /// Partitions the references in two; `None` if they form one leaf.
    fn divide(
        &self,
        references: &mut [Reference],
        extent: &Extent,
        depth: u32,
    ) -> Option<(usize, Extent, Extent)> {
        let count = references.len();
        let is_other = |r: &Reference| r.id() >= self.first_other;
        if count > 1 && references.iter().all(is_other) {
            return Some(self.divide_others(references, extent, depth));
        }
        if count <= PACKET {
            return self.divide_kinds(references);
        }
        if depth < HALVING_DEPTH
            && let Some(plane) = SplitPlane::cheapest(references, extent)
        {
            let leaf_cost = extent.bounds.half_area() * packets(count as u32);
            let step_cost = extent.bounds.half_area() * STEP_COST;
            if count <= LARGEST_LEAF && leaf_cost <= plane.cost + step_cost {
                return self.divide_kinds(references);
            }
            return Some(plane.partition(references));
        }
        if count <= LARGEST_LEAF {
            return self.divide_kinds(references);
        }
        Some(at(count / 2, references))
    }

    /// Other shapes take much longer to intersect than a box: each is a leaf of its own.
    fn divide_others(
        &self,
        references: &mut [Reference],
        extent: &Extent,
        depth: u32,
    ) -> (usize, Extent, Extent) {
        if depth < HALVING_DEPTH
            && let Some(plane) = SplitPlane::cheapest(references, extent)
        {
            return plane.partition(references);
        }
        at(references.len() / 2, references)
    }

    fn divide_kinds(&self, references: &mut [Reference]) -> Option<(usize, Extent, Extent)> {
        let is_triangle = |r: &Reference| r.id() < self.first_other;
        let triangles = references.iter().filter(|r| is_triangle(r)).count();
        if triangles == 0 || triangles == references.len() {
            return None;
        }
        references.sort_by_key(|r| !is_triangle(r));
        Some(at(triangles, references))
    }
}

fn leaf(bounds: Bounds, first: usize, count: usize) -> BinaryNode {
    BinaryNode {
        bounds,
        right: 0,
        first: first as u32,
        count: count as u32,
    }
}

fn at(middle: usize, references: &[Reference]) -> (usize, Extent, Extent) {
    let (low, high) = references.split_at(middle);
    (middle, Extent::of(low), Extent::of(high))
}

/// Number of packets for this many triangles.
#[inline]
pub(crate) fn packets(count: u32) -> f32 {
    count.div_ceil(PACKET as u32) as f32
}

/// Maps centres to bins.
#[derive(Clone, Copy)]
struct Binning {
    origin2: Vec4,
    scale: Vec4,
}

impl Binning {
    fn new(centres2: &Bounds) -> Binning {
        let size = centres2.max - centres2.min;
        // A width of zero, or too small to be inverted, puts all into bin 0.
        let usable = size.cmpgt(Vec4::splat(1e-34));
        let scale = Vec4::select(usable, (BINS as f32 * (1.0 - 1e-6)) / size, Vec4::ZERO);
        Binning {
            origin2: centres2.min,
            scale,
        }
    }

    /// Bin of each axis.
    #[inline]
    fn bins(&self, centre2: Vec4) -> [usize; 3] {
        let x = ((centre2 - self.origin2) * self.scale - 0.5).max(Vec4::ZERO) + TO_BITS;
        x.xyz().to_array().map(lowest_bits)
    }

    /// Bin of one axis, as in [`bins`](Binning::bins).
    #[inline]
    fn bin(&self, axis: usize, r: &Reference) -> usize {
        let centre2 = r.min[axis] + r.max[axis];
        let x = (centre2 - self.origin2[axis]) * self.scale[axis] - 0.5;
        lowest_bits(x.max(0.0) + TO_BITS)
    }
}

/// Adding 2^23 leaves the rounded number in the lowest bits, without a slow conversion.
const TO_BITS: f32 = 8_388_608.0;

fn lowest_bits(x: f32) -> usize {
    (x.to_bits() & (BINS as u32 - 1)) as usize
}

/// A plane that divides references, and the cost of the two sides.
struct SplitPlane {
    binning: Binning,
    axis: usize,
    /// First bin of the right side.
    bin: usize,
    /// Half areas times packets.
    cost: f32,
}

impl SplitPlane {
    fn cheapest(references: &[Reference], extent: &Extent) -> Option<SplitPlane> {
        let binning = Binning::new(&extent.centres2);
        let mut bins = [[(Bounds::EMPTY, 0u32); BINS]; 3];
        for r in references {
            for (axis, bin) in binning.bins(r.centre2()).into_iter().enumerate() {
                let (bounds, count) = &mut bins[axis][bin];
                *bounds = bounds.union(r.bounds());
                *count += 1;
            }
        }
        let mut best: Option<SplitPlane> = None;
        for (axis, bins) in bins.iter().enumerate() {
            if binning.scale[axis] == 0.0 {
                continue;
            }
            let (bin, cost) = cheapest_gap(bins);
            if cost < best.as_ref().map_or(f32::INFINITY, |b| b.cost) {
                best = Some(SplitPlane {
                    binning,
                    axis,
                    bin,
                    cost,
                });
            }
        }
        best
    }

    /// Orders the references by side.
    fn partition(&self, references: &mut [Reference]) -> (usize, Extent, Extent) {
        let (mut left, mut right) = (Extent::EMPTY, Extent::EMPTY);
        let is_left = |r: &Reference| self.binning.bin(self.axis, r) < self.bin;
        let (mut low, mut high) = (0, references.len());
        loop {
            while low < high && is_left(&references[low]) {
                left = left.with(&references[low]);
                low += 1;
            }
            while low < high && !is_left(&references[high - 1]) {
                right = right.with(&references[high - 1]);
                high -= 1;
            }
            if low >= high {
                return (low, left, right);
            }
            references.swap(low, high - 1);
        }
    }
}

/// The split between bins with the smallest cost: first bin of the right side, and the cost, which
/// is infinite if all references are in one bin.
fn cheapest_gap(bins: &[(Bounds, u32); BINS]) -> (usize, f32) {
    let mut right_costs = [f32::INFINITY; BINS];
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for k in (1..BINS).rev() {
        bounds = bounds.union(bins[k].0);
        count += bins[k].1;
        if count > 0 {
            right_costs[k] = bounds.half_area() * packets(count);
        }
    }
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    let mut best = (0, f32::INFINITY);
    for k in 1..BINS {
        bounds = bounds.union(bins[k - 1].0);
        count += bins[k - 1].1;
        let cost = bounds.half_area() * packets(count) + right_costs[k];
        if count > 0 && cost < best.1 {
            best = (k, cost);
        }
    }
    best
}
