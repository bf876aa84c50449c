//! A bounding volume hierarchy over triangles, for nearest points and crossings.

use crate::Mesh;
use crate::math::Aabb;
use glam::DVec3;

/// Triangles in a leaf of the tree.
const LEAF: usize = 4;

/// Normals whose cosine is below this belong to different sides of an edge.
const SAME_SIDE_COSINE: f64 = 0.7;

/// A bounding volume hierarchy over the triangles of a mesh.
///
/// The second pass traces exact shapes and reads their irradiance from the proxy mesh, which is a
/// chord error away: this tree finds its nearest point.
#[derive(Clone, Debug, Default)]
pub struct TriangleTree {
    nodes: Vec<TreeNode>,
    triangles: Vec<MeshTriangle>,
    corners: Vec<[DVec3; 3]>,
}

/// A triangle of a mesh's face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshTriangle {
    /// The face.
    pub face: u32,
    /// Its index among those of [`Mesh::triangulate`].
    pub triangle: u32,
    /// Its corners, counted within the face.
    pub corners: [u32; 3],
}

/// A point on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnTriangle {
    /// Index of the triangle in the tree.
    pub index: u32,
    /// Weight of its corner 1.
    pub u: f64,
    /// Weight of its corner 2.
    pub v: f64,
    /// World position.
    pub position: DVec3,
    /// Distance from the query point.
    pub distance: f64,
}

#[derive(Clone, Debug)]
struct TreeNode {
    bounds: Aabb,
    /// The triangles of a leaf; of an inner node the second child, the first one being the next
    /// node.
    content: NodeContent,
}

#[derive(Clone, Debug)]
enum NodeContent {
    Leaf(std::ops::Range<u32>),
    Children(u32),
}

impl TriangleTree {
    /// Builds the tree of the triangles of a mesh, without those of zero area.
    pub fn new(mesh: &Mesh) -> TriangleTree {
        let (mut triangles, mut points, mut split) = (Vec::new(), Vec::new(), Vec::new());
        for (face, ring) in (0..).zip(mesh.faces.iter()) {
            split.clear();
            mesh.triangulate_into(face as usize, &mut split);
            for (triangle, &corners) in (0..).zip(&split) {
                points.push(corners.map(|k| mesh.positions[ring[k as usize] as usize]));
                triangles.push(MeshTriangle {
                    face,
                    triangle,
                    corners,
                });
            }
        }
        TriangleTree::of(triangles, points)
    }

    /// Builds the tree of any triangles; those of zero area are left out.
    pub(crate) fn of(mut triangles: Vec<MeshTriangle>, points: Vec<[DVec3; 3]>) -> TriangleTree {
        let has_area = |points: &[DVec3; 3]| {
            let normal = normal(points);
            normal.is_finite() && normal != DVec3::ZERO
        };
        let mut kept = points.iter().map(has_area);
        triangles.retain(|_| kept.next() == Some(true));
        let mut tree = TriangleTree {
            nodes: Vec::new(),
            triangles,
            corners: points.into_iter().filter(has_area).collect(),
        };
        let mut order: Vec<u32> = (0..tree.corners.len() as u32).collect();
        if !order.is_empty() {
            tree.build(&mut order, 0);
        }
        tree.triangles = order.iter().map(|&k| tree.triangles[k as usize]).collect();
        tree.corners = order.iter().map(|&k| tree.corners[k as usize]).collect();
        tree
    }

    /// Splits at the median along the longest side of the box of the centres.
    fn build(&mut self, order: &mut [u32], first: u32) {
        let corners = |k: &u32| self.corners[*k as usize];
        let bounds = Aabb::around(order.iter().flat_map(corners));
        let node = self.nodes.len();
        let content = NodeContent::Leaf(first..first + order.len() as u32);
        let centre = |k: &u32| corners(k).iter().sum::<DVec3>();
        let size = Aabb::around(order.iter().map(centre)).size();
        let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
        let middle = order.len() / 2;
        if order.len() > LEAF {
            order.select_nth_unstable_by(middle, |a, b| {
                let (p, q) = (centre(a)[axis], centre(b)[axis]);
                p.total_cmp(&q).then(a.cmp(b))
            });
        }
        self.nodes.push(TreeNode { bounds, content });
        if order.len() > LEAF {
            let (low, high) = order.split_at_mut(middle);
            self.build(low, first);
            self.nodes[node].content = NodeContent::Children(self.nodes.len() as u32);
            self.build(high, first + middle as u32);
        }
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The triangle of the mesh that a triangle of the tree stands for.
    pub fn triangle(&self, index: u32) -> MeshTriangle {
        self.triangles[index as usize]
    }

    /// The nearest point of a triangle whose front faces along the unit vector `normal`; if no
    /// triangle does, the nearest of all. `None` in an empty tree.
    ///
    /// Of several at the same distance it is the first in the tree, so that the result does not
    /// depend on the order of search.
    pub fn nearest(&self, point: DVec3, normal: DVec3) -> Option<OnTriangle> {
        let agrees = |k: u32| {
            let own = self::normal(&self.corners[k as usize]).normalize();
            own.dot(normal) > SAME_SIDE_COSINE
        };
        self.search(point, agrees)
            .or_else(|| self.search(point, |_| true))
    }

    fn search(&self, point: DVec3, accept: impl Fn(u32) -> bool) -> Option<OnTriangle> {
        let mut best: Option<OnTriangle> = None;
        let mut stack: Vec<u32> = (!self.nodes.is_empty()).then_some(0).into_iter().collect();
        while let Some(n) = stack.pop() {
            let node = &self.nodes[n as usize];
            let bound = best.as_ref().map_or(f64::INFINITY, |b| b.distance);
            if distance_to(&node.bounds, point) > bound {
                continue;
            }
            match node.content {
                NodeContent::Leaf(ref range) => {
                    for k in range.clone() {
                        let candidate = on_triangle(k, &self.corners[k as usize], point);
                        let nearer = best
                            .as_ref()
                            .is_none_or(|b| (candidate.distance, k) < (b.distance, b.index));
                        if nearer && accept(k) {
                            best = Some(candidate);
                        }
                    }
                }
                NodeContent::Children(second) => {
                    let far = |c: u32| distance_to(&self.nodes[c as usize].bounds, point);
                    let (a, b) = (n + 1, second);
                    // The nearer one is popped first.
                    stack.extend(if far(a) <= far(b) { [b, a] } else { [a, b] });
                }
            }
        }
        best
    }

    /// Visits the triangles whose boxes overlap `bounds`.
    pub fn for_each_in(&self, bounds: &Aabb, mut visit: impl FnMut(u32, &[DVec3; 3])) {
        let apart = |a: &Aabb| a.min.cmpgt(bounds.max).any() || a.max.cmplt(bounds.min).any();
        self.walk(apart, |k, corners| {
            if !apart(&Aabb::around(*corners)) {
                visit(k, corners);
            }
        });
    }

    /// Whether a point is inside the closed surface that the triangles form: by the parity of
    /// crossings along three lines, of which two agree even if one grazes an edge.
    pub fn contains(&self, point: DVec3) -> bool {
        let lines = [
            DVec3::new(0.57731, 0.30217, 0.75934),
            DVec3::new(-0.43519, 0.84147, 0.32219),
            DVec3::new(0.26149, -0.66274, 0.70188),
        ];
        let odd = lines.map(|d| self.crossings(point, d) % 2 == 1);
        u32::from(odd[0]) + u32::from(odd[1]) + u32::from(odd[2]) >= 2
    }

    /// Triangles that the half-line crosses.
    fn crossings(&self, origin: DVec3, direction: DVec3) -> u32 {
        let inverse = direction.recip();
        let mut count = 0;
        let misses = |b: &Aabb| {
            let (p, q) = ((b.min - origin) * inverse, (b.max - origin) * inverse);
            let (near, far) = (p.min(q).max_element(), p.max(q).min_element());
            far < near.max(0.0)
        };
        self.walk(misses, |_, corners| {
            count += u32::from(crosses(corners, origin, direction));
        });
        count
    }

    fn walk(&self, skip: impl Fn(&Aabb) -> bool, mut visit: impl FnMut(u32, &[DVec3; 3])) {
        let mut stack: Vec<u32> = (!self.nodes.is_empty()).then_some(0).into_iter().collect();
        while let Some(n) = stack.pop() {
            let node = &self.nodes[n as usize];
            match node.content {
                _ if skip(&node.bounds) => {}
                NodeContent::Leaf(ref range) => {
                    range
                        .clone()
                        .for_each(|k| visit(k, &self.corners[k as usize]));
                }
                NodeContent::Children(second) => stack.extend([second, n + 1]),
            }
        }
    }
}

fn normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Möller and Trumbore, *Fast, Minimum Storage Ray/Triangle Intersection* (1997).
fn crosses([a, b, c]: &[DVec3; 3], origin: DVec3, direction: DVec3) -> bool {
    let (e, f) = (b - a, c - a);
    let p = direction.cross(f);
    let (whole, s) = (e.dot(p), origin - a);
    let q = s.cross(e);
    let (u, v, t) = (s.dot(p) / whole, direction.dot(q) / whole, f.dot(q) / whole);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0
}

fn distance_to(bounds: &Aabb, point: DVec3) -> f64 {
    point.distance(point.clamp(bounds.min, bounds.max))
}

fn on_triangle(index: u32, corners: &[DVec3; 3], point: DVec3) -> OnTriangle {
    let (u, v) = nearest_weights(corners, point);
    let [a, b, c] = corners;
    let position = a + u * (b - a) + v * (c - a);
    OnTriangle {
        index,
        u,
        v,
        position,
        distance: position.distance(point),
    }
}

/// Weights of corners 1 and 2 at the nearest point of a triangle.
///
/// Ericson, *Real-Time Collision Detection* (2005), section 5.1.5.
fn nearest_weights([a, b, c]: &[DVec3; 3], p: DVec3) -> (f64, f64) {
    let (ab, ac) = (b - a, c - a);
    let [d1, d2] = [ab, ac].map(|e| e.dot(p - a));
    let [d3, d4] = [ab, ac].map(|e| e.dot(p - b));
    let [d5, d6] = [ab, ac].map(|e| e.dot(p - c));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if d1 <= 0.0 && d2 <= 0.0 {
        (0.0, 0.0)
    } else if d3 >= 0.0 && d4 <= d3 {
        (1.0, 0.0)
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        (d1 / (d1 - d3), 0.0)
    } else if d6 >= 0.0 && d5 <= d6 {
        (0.0, 1.0)
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        (0.0, d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        (1.0 - w, w)
    } else {
        let whole = va + vb + vc;
        (vb / whole, vc / whole)
    }
}
