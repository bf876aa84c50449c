//! Rays against polygons that are a solid: all meetings, in and out by turns.

use super::leaf::{Boundary, Meeting, ResolvedLeaf, facing};
use crate::build::{BinaryNode, Reference, binary_tree};
use crate::primitive::Line;
use crate::triangle;
use azulejo_scene::Mesh;
use azulejo_scene::math::Ray;
use glam::{DVec2, DVec3};

/// A mesh prepared for rays that ask for all meetings.
#[derive(Clone, Debug)]
pub(crate) struct ExactMesh {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    tree: Vec<BinaryNode>,
    /// Triangles in the order of the tree's leaves.
    order: Vec<u32>,
    /// Whether lines go in and out by turns, whichever way faces are turned.
    is_closed: bool,
}

/// Boxes are widened by this share of the coordinates at hand: far more than any rounding.
const MARGIN: f64 = 1e-6;

/// Sees the scene along a line: the line is the origin of a plane.
struct View {
    axes: [usize; 3],
    slope: DVec2,
    origin: DVec3,
    /// One over the direction's longest component.
    scale: f64,
}

impl View {
    /// Woop, Benthin and Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1), 2013.
    fn along(line: &Line) -> View {
        let size = line.direction.abs();
        let last = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
        let axes = [(last + 1) % 3, (last + 2) % 3, last];
        let scale = 1.0 / line.direction[last];
        let slope = |k: usize| line.direction[axes[k]] * scale;
        View {
            axes,
            slope: DVec2::new(slope(0), slope(1)),
            origin: line.origin,
            scale,
        }
    }

    /// A point as the line sees it, and its parameter along the line.
    fn see(&self, p: DVec3) -> (DVec2, f64) {
        let p = p - self.origin;
        let z = p[self.axes[2]];
        let flat = DVec2::new(p[self.axes[0]], p[self.axes[1]]);
        (flat - z * self.slope, z * self.scale)
    }
}

/// Whether the edge between two points crosses the positive x axis, half-open: an edge gives the
/// same answer to every triangle it bounds, so a line meets an even number of triangles of a mesh
/// whose edges all have an even number.
fn crosses(a: DVec2, b: DVec2) -> bool {
    if (a.y >= 0.0) == (b.y >= 0.0) {
        return false;
    }
    // One order of the two, whichever triangle asks.
    let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
    low.perp_dot(high) > 0.0
}

impl ExactMesh {
    /// From a mesh whose points go through `local`.
    pub(crate) fn new(mesh: &Mesh, local: impl Fn(DVec3) -> DVec3) -> ExactMesh {
        let positions: Vec<DVec3> = mesh.positions.iter().map(|&p| local(p)).collect();
        let mut triangles = Vec::with_capacity(mesh.faces.triangle_count());
        let mut split = Vec::new();
        for (face, corners) in mesh.faces.iter().enumerate() {
            split.clear();
            mesh.triangulate_into(face, &mut split);
            triangles.extend(split.iter().map(|t| t.map(|k| corners[k as usize])));
        }
        let mut references: Vec<Reference> = (0..)
            .zip(&triangles)
            .map(|(id, t): (u32, &[u32; 3])| {
                let [a, b, c] = t.map(|v| positions[v as usize].as_vec3());
                let (min, max) = (a.min(b).min(c), a.max(b).max(c));
                Reference::new(min.to_array(), max.to_array(), id)
            })
            .filter(Reference::is_finite)
            .collect();
        let tree = binary_tree(&mut references, triangles.len() as u32);
        ExactMesh {
            is_closed: mesh.is_closed(),
            order: references.iter().map(Reference::id).collect(),
            positions,
            triangles,
            tree,
        }
    }

    /// All meetings in order; with a closed mesh in and out by turns, with an open one by the
    /// way its faces are turned.
    pub(crate) fn all(&self, line: &Line, leaf: u32, out: &mut Vec<Boundary>) {
        let first = out.len();
        let view = View::along(line);
        self.walk(line, |triangle| {
            if let Some(t) = self.meet(&view, triangle) {
                out.push(Boundary {
                    meeting: Meeting {
                        t,
                        part: triangle,
                        parameter: 0.0,
                        enters: true,
                    },
                    leaf,
                });
            }
        });
        if self.is_closed && (out.len() - first) % 2 == 1 {
            // A face whose triangles leave out a corner that its neighbour has.
            out.pop();
        }
        let found = &mut out[first..];
        found.sort_by(|a, b| {
            let order = a.meeting.t.total_cmp(&b.meeting.t);
            order.then(a.meeting.part.cmp(&b.meeting.part))
        });
        for (k, boundary) in found.iter_mut().enumerate() {
            boundary.meeting.enters = match self.is_closed {
                true => k % 2 == 0,
                false => self.normal(boundary.meeting.part).dot(line.direction) < 0.0,
            };
        }
    }

    /// Visits the triangles whose boxes the line may meet.
    fn walk(&self, line: &Line, mut visit: impl FnMut(u32)) {
        let inverse = line.direction.recip();
        let reach = line.origin.abs().max_element() + 1.0;
        let mut waiting = Vec::with_capacity(64);
        if !self.tree.is_empty() {
            waiting.push(0);
        }
        while let Some(index) = waiting.pop() {
            let node: &BinaryNode = &self.tree[index];
            if !node.is_met(line.origin, inverse, reach * MARGIN) {
                continue;
            }
            if node.is_leaf() {
                self.order[node.range()].iter().for_each(|&t| visit(t));
            } else {
                waiting.push(index + node.right as usize);
                waiting.push(index + 1);
            }
        }
    }

    fn meet(&self, view: &View, triangle: u32) -> Option<f64> {
        let corners = self.corners(triangle).map(|p| view.see(p));
        let [(a, ta), (b, tb), (c, tc)] = corners;
        let odd = crosses(a, b) ^ crosses(b, c) ^ crosses(c, a);
        if !odd {
            return None;
        }
        let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        let whole: f64 = weights.iter().sum();
        let t = (weights[0] * ta + weights[1] * tb + weights[2] * tc) / whole;
        // Seen from its edge it is met between its nearest and farthest corner, anywhere.
        let (low, high) = (ta.min(tb).min(tc), ta.max(tb).max(tc));
        Some(if t.is_finite() {
            t.max(low).min(high)
        } else {
            0.5 * (low + high)
        })
    }

    fn normal(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|v| self.positions[v as usize])
    }

    /// The point of a triangle that the line meets or comes nearest to.
    pub(crate) fn resolve(&self, line: &Line, meeting: &Meeting) -> ResolvedLeaf {
        let ray = Ray::new(line.origin, line.direction);
        let at = triangle::meet(self.corners(meeting.part), &ray, meeting.t);
        ResolvedLeaf {
            t: at.t,
            u: at.u,
            v: at.v,
            position: at.position,
            normal: facing(at.normal, line.direction, meeting.enters),
        }
    }
}
