//! Set operations along a ray: Roth, *Ray Casting for Modeling Solids*, Computer Graphics and
//! Image Processing 18, 1982.

use super::leaf::{Boundary, ExactLeaf};
use super::line::Line3;
use azulejo_scene::Operation;
use azulejo_scene::math::Aabb;
use glam::DVec3;

/// A solid composed of leaves.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub leaves: Vec<TreeLeaf>,
    pub root: CsgNode,
}

/// A leaf, and whether its visible surface is reversed.
#[derive(Clone, Debug)]
pub(crate) struct TreeLeaf {
    pub shape: ExactLeaf,
    pub is_turned: bool,
}

/// A node of the CSG tree with its bounding box, in the tracer's own coordinates.
#[derive(Clone, Debug)]
pub(crate) struct CsgNode {
    pub bounds: Aabb,
    pub kind: CsgNodeKind,
}

#[derive(Clone, Debug)]
pub(crate) enum CsgNodeKind {
    /// A closed shape, by its index among the leaves.
    Leaf(u32),
    /// Open pieces that together enclose a volume.
    Shell(Vec<CsgNode>),
    Csg {
        operation: Operation,
        left: Box<CsgNode>,
        right: Box<CsgNode>,
    },
}

impl CsgNode {
    /// The union of several parts, recursively halved where they are far apart, so that a ray
    /// through a page of letters visits few of them.
    pub(crate) fn union(mut parts: Vec<CsgNode>) -> CsgNode {
        let boxes = parts.iter().map(|n| n.bounds);
        let bounds = boxes.fold(Aabb::EMPTY, Aabb::union);
        if parts.len() < 2 {
            let nothing = CsgNodeKind::Shell(Vec::new());
            let kind = parts.pop().map_or(nothing, |alone| alone.kind);
            return CsgNode { bounds, kind };
        }
        let size = bounds.size();
        let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
        let place = |n: &CsgNode| n.bounds.centre()[axis];
        parts.sort_by(|a, b| place(a).total_cmp(&place(b)));
        let right = parts.split_off(parts.len() / 2);
        let kind = CsgNodeKind::Csg {
            operation: Operation::Union,
            left: Box::new(CsgNode::union(parts)),
            right: Box::new(CsgNode::union(right)),
        };
        CsgNode { bounds, kind }
    }
}

/// Solid or empty layers thinner than this are dropped: they come from the rounding of surfaces
/// that should coincide. The scene is about 2 across.
const SLIVER: f64 = 1e-9;

/// Hits on two pieces of a shell closer than this may be one hit at a seam.
const SEAM: f64 = 1e-6;

impl Tree {
    /// All boundaries of the solid on a line, in order, alternately entering and leaving.
    pub(crate) fn boundaries(&self, line: &Line3) -> Vec<Boundary> {
        let mut out = Vec::new();
        let pass = LinePass {
            leaves: &self.leaves,
            line,
            inverse: line.direction.recip(),
            sliver: SLIVER / line.direction.length(),
        };
        pass.node(&self.root, &mut out);
        out
    }
}

/// The traversal of the tree along one line. Every function appends boundaries to a list, in order,
/// alternately entering and leaving, and keeps what is in the list.
struct LinePass<'a> {
    leaves: &'a [TreeLeaf],
    line: &'a Line3,
    inverse: DVec3,
    sliver: f64,
}

impl LinePass<'_> {
    fn node(&self, node: &CsgNode, out: &mut Vec<Boundary>) {
        if !may_be_crossed(&node.bounds, self.line.origin, self.inverse) {
            return;
        }
        match &node.kind {
            CsgNodeKind::Leaf(leaf) => self.leaf(*leaf, out),
            CsgNodeKind::Shell(pieces) => self.shell(pieces, out),
            CsgNodeKind::Csg {
                operation,
                left,
                right,
            } => {
                let first = out.len();
                self.node(left, out);
                let between = out.len();
                if between == first && *operation != Operation::Union {
                    return;
                }
                self.node(right, out);
                self.combine(*operation, first, between, out);
            }
        }
    }

    fn leaf(&self, leaf: u32, out: &mut Vec<Boundary>) {
        self.leaves[leaf as usize].shape.all(self.line, leaf, out);
    }

    /// Pairs the hits with all pieces.
    fn shell(&self, pieces: &[CsgNode], out: &mut Vec<Boundary>) {
        let first = out.len();
        for piece in pieces {
            self.node(piece, out);
        }
        out[first..].sort_by(|a, b| a.hit.t.total_cmp(&b.hit.t));
        if (out.len() - first) % 2 == 1 {
            let extra = self.doubled(&out[first..]).unwrap_or(out.len() - first - 1);
            out.remove(first + extra);
        }
        for (k, boundary) in out[first..].iter_mut().enumerate() {
            boundary.hit.enters = k % 2 == 0;
        }
    }

    /// Finds hits of a shell that occur twice, in two adjacent pieces.
    fn doubled(&self, hits: &[Boundary]) -> Option<usize> {
        let gap = |k: &usize| hits[*k].hit.t - hits[k - 1].hit.t;
        let seams = (1..hits.len()).filter(|&k| hits[k].leaf != hits[k - 1].leaf);
        let nearest = seams.min_by(|a, b| gap(a).total_cmp(&gap(b)))?;
        (gap(&nearest) * self.line.direction.length() < SEAM).then_some(nearest)
    }

    /// Replaces the lists from `first` and from `between` by the operation's result.
    fn combine(&self, operation: Operation, first: usize, between: usize, out: &mut Vec<Boundary>) {
        if operation == Operation::Union && (first == between || between == out.len()) {
            return;
        }
        let right = out.split_off(between);
        let left = out.split_off(first);
        let (mut a, mut b) = (left.iter().peekable(), right.iter().peekable());
        let mut inside = [false; 2];
        let mut is_in = false;
        loop {
            let (ta, tb) = (a.peek().map(|m| m.hit.t), b.peek().map(|m| m.hit.t));
            let side = match (ta, tb) {
                (None, None) => break,
                (Some(_), None) => 0,
                (None, Some(_)) => 1,
                (Some(ta), Some(tb)) => usize::from(tb < ta),
            };
            let next = if side == 0 { a.next() } else { b.next() };
            let Some(boundary) = next else { break };
            inside[side] = !inside[side];
            let now = match operation {
                Operation::Union => inside[0] || inside[1],
                Operation::Difference => inside[0] && !inside[1],
                Operation::Intersection => inside[0] && inside[1],
            };
            if now != is_in {
                is_in = now;
                self.push(first, boundary, out);
            }
        }
    }

    /// Appends a boundary, or removes the last one if the two enclose a sliver.
    fn push(&self, first: usize, boundary: &Boundary, out: &mut Vec<Boundary>) {
        let last = out[first..].last();
        if last.is_some_and(|l| boundary.hit.t - l.hit.t <= self.sliver) {
            out.pop();
        } else {
            out.push(*boundary);
        }
    }
}

/// Whether a line may cross a box, enlarged by much more than rounding.
fn may_be_crossed(bounds: &Aabb, origin: DVec3, inverse: DVec3) -> bool {
    let margin = DVec3::splat(1e-9 * (1.0 + origin.abs().max_element()));
    let (a, b) = (bounds.min - margin - origin, bounds.max + margin - origin);
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        if inverse[axis].is_finite() {
            let (p, q) = (a[axis] * inverse[axis], b[axis] * inverse[axis]);
            enter = enter.max(p.min(q));
            leave = leave.min(p.max(q));
        } else if a[axis] > 0.0 || b[axis] < 0.0 {
            return false;
        }
    }
    enter <= leave && a.cmple(b).all()
}
