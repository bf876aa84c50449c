//! Rays against meshes that are solids: all hits, alternately entering and leaving.

use super::leaf::{Boundary, LeafHit, LeafPoint, facing};
use super::line::Line3;
use super::triangle::point_on_triangle;
use crate::kernel::{BinaryNode, Reference, binary_tree};
use azulejo_scene::Mesh;
use azulejo_scene::math::Ray;
use glam::{DVec2, DVec3};

/// A mesh prepared for finding all hits of a line.
#[derive(Clone, Debug)]
pub(crate) struct ExactMesh {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    tree: Vec<BinaryNode>,
    /// Triangles in the order of the tree's leaves.
    order: Vec<u32>,
    /// Whether lines alternately enter and leave, regardless of the orientation of faces.
    is_closed: bool,
}

/// Boxes are enlarged by this fraction of the coordinates, which is much more than any rounding.
const MARGIN: f64 = 1e-6;

/// The projection along a line onto a plane whose origin is the line.
struct LineView {
    axes: [usize; 3],
    slope: DVec2,
    origin: DVec3,
    /// One over the direction's longest component.
    scale: f64,
}

impl LineView {
    /// Woop, Benthin and Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1), 2013.
    fn along(line: &Line3) -> LineView {
        let size = line.direction.abs();
        let last = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
        let axes = [(last + 1) % 3, (last + 2) % 3, last];
        let scale = 1.0 / line.direction[last];
        let slope = |k: usize| line.direction[axes[k]] * scale;
        LineView {
            axes,
            slope: DVec2::new(slope(0), slope(1)),
            origin: line.origin,
            scale,
        }
    }

    /// A point projected along the line, and its parameter along it.
    fn project(&self, p: DVec3) -> (DVec2, f64) {
        let p = p - self.origin;
        let z = p[self.axes[2]];
        let flat = DVec2::new(p[self.axes[0]], p[self.axes[1]]);
        (flat - z * self.slope, z * self.scale)
    }
}

/// Whether the edge between two points crosses the positive x axis, half-open: an edge gives the
/// same result for all of its triangles, so a line hits an even number of triangles of a mesh whose
/// edges all have an even number of triangles.
fn crosses(a: DVec2, b: DVec2) -> bool {
    if (a.y >= 0.0) == (b.y >= 0.0) {
        return false;
    }
    // A fixed order of the two, independent of the triangle.
    let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
    low.perp_dot(high) > 0.0
}

impl ExactMesh {
    /// Prepares a mesh, whose points are transformed by `local`.
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

    /// All hits in order; alternately entering and leaving for a closed mesh, by the orientation of
    /// faces for an open one.
    pub(crate) fn all(&self, line: &Line3, leaf: u32, out: &mut Vec<Boundary>) {
        let first = out.len();
        let view = LineView::along(line);
        self.walk(line, |triangle| {
            if let Some(t) = self.intersect(&view, triangle) {
                out.push(Boundary {
                    hit: LeafHit {
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
            // A face whose triangles omit a corner that its neighbour has.
            out.pop();
        }
        let boundaries = &mut out[first..];
        boundaries.sort_by(|a, b| {
            let order = a.hit.t.total_cmp(&b.hit.t);
            order.then(a.hit.part.cmp(&b.hit.part))
        });
        for (k, boundary) in boundaries.iter_mut().enumerate() {
            boundary.hit.enters = if self.is_closed {
                k % 2 == 0
            } else {
                self.normal(boundary.hit.part).dot(line.direction) < 0.0
            };
        }
    }

    /// Visits the triangles whose boxes the line may cross.
    fn walk(&self, line: &Line3, mut visit: impl FnMut(u32)) {
        let inverse = line.direction.recip();
        let reach = line.origin.abs().max_element() + 1.0;
        let mut waiting = Vec::with_capacity(64);
        if !self.tree.is_empty() {
            waiting.push(0);
        }
        while let Some(index) = waiting.pop() {
            let node: &BinaryNode = &self.tree[index];
            if !node.may_be_crossed(line.origin, inverse, reach * MARGIN) {
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

    fn intersect(&self, view: &LineView, triangle: u32) -> Option<f64> {
        let corners = self.corners(triangle).map(|p| view.project(p));
        let [(a, ta), (b, tb), (c, tc)] = corners;
        let odd = crosses(a, b) ^ crosses(b, c) ^ crosses(c, a);
        if !odd {
            return None;
        }
        let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        let whole: f64 = weights.iter().sum();
        let t = (weights[0] * ta + weights[1] * tb + weights[2] * tc) / whole;
        // Seen edge-on it is hit anywhere between its nearest and farthest corner.
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

    /// The point of a triangle that the line hits, or the nearest to it.
    pub(crate) fn resolve(&self, line: &Line3, hit: &LeafHit) -> LeafPoint {
        let ray = Ray::new(line.origin, line.direction);
        let at = point_on_triangle(self.corners(hit.part), &ray, hit.t);
        LeafPoint {
            t: at.t,
            u: at.u,
            v: at.v,
            position: at.position,
            normal: facing(at.normal, line.direction, hit.enters),
        }
    }
}
