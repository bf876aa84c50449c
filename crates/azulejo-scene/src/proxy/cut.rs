//! Set operations on the faces of their operands.
//!
//! 1. Where triangles of two solids intersect, both record the segment (`triangle_pair`).
//! 2. Every triangle with segments through it, or with points on its edges, is divided along them.
//! 3. A piece belongs to the surface of the result if of the points just before and just behind
//!    its middle one is inside and the other is not. A piece that two solids share is kept once, as
//!    part of the first one.
//!
//! Requicha and Voelcker, *Boolean Operations in Solid Modeling: Boundary Evaluation and Merging
//! Algorithms* (1985). Cuts and membership both use the polygons, so that they are consistent.

use super::builder::{ProxyMeshBuilder, Weld};
use super::facet::Facet;
use super::flat_figure::{Delaunay, GRID, point};
use super::triangle_pair::{IndexedTriangle, intersect};
use super::uncrossed::add_edges;
use crate::math::{Aabb, area_vector};
use crate::tree::{MeshTriangle, TriangleTree};
use crate::{Csg, Leaf, Mesh, Operation, Solid};
use glam::DVec3;
use spade::handles::FixedVertexHandle;
use spade::{Point2, Triangulation};
use std::collections::HashMap;

/// Points closer than this fraction of the size coincide.
const TOUCH: f64 = 1e-8;
/// The two sides of a surface are tested at this fraction of the size from it.
const BESIDE: f64 = 1e-6;
/// Most segments; further ones are ignored, and the surfaces then overlap uncut.
const MOST_LINES: usize = 1 << 20;
/// The largest number of lines along which one triangle is divided.
const MOST_LINES_EACH: usize = 1 << 12;

/// Appends the faces of the result of a set operation to `builder`, from the `facets` of its
/// leaves.
pub(super) fn cut(
    csg: &Csg,
    mut facets: impl FnMut(Leaf) -> Vec<Facet>,
    builder: &mut ProxyMeshBuilder,
) {
    let mut bodies = Vec::new();
    let root = CsgNode::new(csg, &mut |solid| {
        bodies.push(solid.leaves().into_iter().flat_map(&mut facets).collect());
        bodies.len() as u32 - 1
    });
    let Some(mut net) = Arrangement::new(&bodies) else {
        return;
    };
    net.find_lines();
    net.mark_edges();
    let classifier = SurfaceClassifier {
        root,
        bodies: bodies.iter().map(|facets| body_tree(facets)).collect(),
        beside: net.size * BESIDE,
    };
    for sheet in 0..net.sheets.len() {
        net.emit(sheet, &classifier, builder);
    }
}

/// A tree of set operations over numbered solids.
enum CsgNode {
    Body(u32),
    Csg(Operation, [Vec<CsgNode>; 2]),
}

impl CsgNode {
    /// `number` returns the number of each solid that is not itself a set operation.
    fn new(csg: &Csg, number: &mut impl FnMut(&Solid) -> u32) -> CsgNode {
        let mut side = |solids: &[Solid]| {
            let node = |solid: &Solid| match solid {
                Solid::Csg(csg) => CsgNode::new(csg, number),
                _ => CsgNode::Body(number(solid)),
            };
            solids.iter().map(node).collect()
        };
        CsgNode::Csg(csg.operation, [side(&csg.left), side(&csg.right)])
    }

    /// Whether a point is inside, given the bodies that contain it.
    fn is_inside(&self, is_in_body: &impl Fn(u32) -> bool) -> bool {
        match self {
            CsgNode::Body(body) => is_in_body(*body),
            CsgNode::Csg(operation, [left, right]) => {
                let any = |side: &[CsgNode]| side.iter().any(|n| n.is_inside(is_in_body));
                operation.is_inside(any(left), || any(right))
            }
        }
    }
}

/// Decides which pieces of surfaces belong to the result.
struct SurfaceClassifier {
    root: CsgNode,
    bodies: Vec<TriangleTree>,
    /// Distance from a surface at which its two sides are tested.
    beside: f64,
}

/// How a piece of an operand's surface appears in the result.
#[derive(Clone, Copy, PartialEq, Eq)]
enum PieceSide {
    Dropped,
    Kept,
    Reversed,
}

impl SurfaceClassifier {
    /// Classifies a piece of a body's surface, at a point of it with the unit normal there.
    fn classify(&self, body: u32, point: DVec3, normal: DVec3) -> PieceSide {
        let (behind, before) = (point - self.beside * normal, point + self.beside * normal);
        let is_in = |k: u32, p| self.bodies[k as usize].contains(p);
        let inner = self.root.is_inside(&|k| k == body || is_in(k, behind));
        let outer = self.root.is_inside(&|k| k != body && is_in(k, before));
        // Of coincident surfaces only the first one keeps the piece.
        let shared = || (0..body).any(|k| is_in(k, behind) != is_in(k, before));
        match (inner, outer) {
            _ if inner == outer || shared() => PieceSide::Dropped,
            (true, _) => PieceSide::Kept,
            _ => PieceSide::Reversed,
        }
    }
}

/// A facet of a body.
struct BodyFacet<'a> {
    body: u32,
    facet: &'a Facet,
    /// The range of its triangles.
    triangles: std::ops::Range<usize>,
}

/// All triangles, and the segments along which they intersect.
struct Arrangement<'a> {
    size: f64,
    touch: f64,
    weld: Weld,
    sheets: Vec<BodyFacet<'a>>,
    triangles: Vec<IndexedTriangle>,
    /// Corners of each triangle, as indices into its facet's corners.
    places: Vec<[u32; 3]>,
    owners: Vec<u32>,
    /// Lines through each triangle, as pairs of positions.
    lines: Vec<Vec<[u32; 2]>>,
    /// Positions on edges, whose ends ascend.
    on_edges: HashMap<[u32; 2], Vec<u32>>,
}

impl<'a> Arrangement<'a> {
    fn new(bodies: &'a [Vec<Facet>]) -> Option<Arrangement<'a>> {
        let facets = || {
            (0..)
                .zip(bodies)
                .flat_map(|(b, all)| all.iter().map(move |f| (b, f)))
        };
        let points = || facets().flat_map(|f| f.1.corners.iter().map(|c| c.0));
        let bounds = Aabb::around(points());
        let size = bounds.diagonal();
        if !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        let touch = TOUCH * size + 64.0 * f64::EPSILON * reach;
        let mut net = Arrangement {
            size,
            touch,
            weld: Weld::new(touch),
            sheets: Vec::new(),
            triangles: Vec::new(),
            places: Vec::new(),
            owners: Vec::new(),
            lines: Vec::new(),
            on_edges: HashMap::new(),
        };
        facets().for_each(|(body, facet)| net.add(body, facet));
        net.lines = vec![Vec::new(); net.triangles.len()];
        Some(net)
    }

    fn add(&mut self, body: u32, facet: &'a Facet) {
        let numbers: Vec<u32> = (facet.corners.iter())
            .map(|corner| self.weld.number(corner.0))
            .collect();
        let first = self.triangles.len();
        for places in triangulated(facet) {
            let numbers = places.map(|k| numbers[k as usize]);
            let corners = numbers.map(|v| self.weld.positions[v as usize]);
            let vector = area_vector(&corners);
            if let Some(normal) = vector.try_normalize() {
                self.triangles.push(IndexedTriangle {
                    numbers,
                    corners,
                    normal,
                });
                self.places.push(places);
                self.owners.push(self.sheets.len() as u32);
            }
        }
        self.sheets.push(BodyFacet {
            body,
            facet,
            triangles: first..self.triangles.len(),
        });
    }

    fn body(&self, triangle: usize) -> u32 {
        self.sheets[self.owners[triangle] as usize].body
    }

    /// Intersects the triangles of different bodies.
    fn find_lines(&mut self) {
        // Search near triangles by boxes, which are wider by the distance at which points coincide.
        let whole = |t: usize| MeshTriangle {
            face: t as u32,
            triangle: 0,
            corners: [0, 1, 2],
        };
        let tree = TriangleTree::of(
            (0..self.triangles.len()).map(whole).collect(),
            self.triangles.iter().map(|t| t.corners).collect(),
        );
        let mut line_count = 0;
        let mut near = Vec::new();
        for t in 0..self.triangles.len() {
            let own = self.triangles[t];
            let mut bounds = Aabb::around(own.corners);
            bounds.min -= self.touch;
            bounds.max += self.touch;
            near.clear();
            tree.for_each_in(&bounds, |k, _| near.push(tree.triangle(k).face as usize));
            // Take each pair once, in ascending order, on which the numbers of new points depend.
            near.retain(|&o| o > t && self.body(o) != self.body(t));
            near.sort_unstable();
            for &o in &near {
                let Some(ends) = intersect(&own, &self.triangles[o], self.touch) else {
                    continue;
                };
                // Record points on edges by their edge, so that the neighbour there is divided too.
                let line = ends.map(|end| {
                    let number = self.weld.number(end.position);
                    if let Some(edge) = end.edge {
                        self.on_edges.entry(edge).or_default().push(number);
                    }
                    number
                });
                // Ignore segments beyond the limits, and those whose ends coincide.
                if line[0] != line[1] && line_count < MOST_LINES {
                    line_count += 1;
                    for k in [t, o] {
                        if self.lines[k].len() < MOST_LINES_EACH {
                            self.lines[k].push(line);
                        }
                    }
                }
            }
        }
    }

    /// Records ends of segments that happen to lie on an edge of their triangle, so that the
    /// neighbour at that edge is divided too.
    fn mark_edges(&mut self) {
        for (triangle, lines) in self.triangles.iter().zip(&self.lines) {
            for &end in lines.iter().flatten() {
                let p = self.weld.positions[end as usize];
                for k in 0..3 {
                    let [a, b] = [k, (k + 1) % 3].map(|k| triangle.corners[k]);
                    let share = (p - a).dot(b - a) / a.distance_squared(b);
                    if p.distance(a + share.clamp(0.0, 1.0) * (b - a)) <= self.touch {
                        let edge = edge(triangle, k);
                        self.on_edges.entry(edge).or_default().push(end);
                    }
                }
            }
        }
    }

    /// Points between the ends of a triangle's side, in order.
    fn on_side(&self, triangle: &IndexedTriangle, side: usize) -> Vec<u32> {
        let Some(points) = self.on_edges.get(&edge(triangle, side)) else {
            return Vec::new();
        };
        let ends = [side, (side + 1) % 3];
        let [from, to] = ends.map(|k| triangle.corners[k]);
        let along = |&p: &u32| (self.weld.positions[p as usize] - from).dot(to - from);
        let between = |p: &&u32| !ends.iter().any(|&k| triangle.numbers[k] == **p);
        let mut points: Vec<u32> = points.iter().filter(between).copied().collect();
        points.sort_by(|p, q| along(p).total_cmp(&along(q)).then(p.cmp(q)));
        points.dedup();
        points
    }

    fn emit(
        &mut self,
        sheet: usize,
        classifier: &SurfaceClassifier,
        builder: &mut ProxyMeshBuilder,
    ) {
        let triangles = self.sheets[sheet].triangles.clone();
        let is_cut = |t: usize| {
            !self.lines[t].is_empty()
                || (0..3).any(|k| !self.on_side(&self.triangles[t], k).is_empty())
        };
        if !triangles.clone().any(is_cut) {
            return self.emit_whole(sheet, classifier, builder);
        }
        for t in triangles {
            for piece in self.divided(t) {
                self.emit_piece(t, piece, classifier, builder);
            }
        }
    }

    /// Emits a facet without segments, all of which is on one side.
    fn emit_whole(
        &self,
        sheet: usize,
        classifier: &SurfaceClassifier,
        builder: &mut ProxyMeshBuilder,
    ) {
        let BodyFacet {
            body,
            facet,
            triangles,
        } = &self.sheets[sheet];
        let area = |t: &&IndexedTriangle| area_vector(&t.corners).length();
        let widest = self.triangles[triangles.clone()]
            .iter()
            .max_by(|a, b| area(a).total_cmp(&area(b)));
        let Some(widest) = widest else { return };
        let centre = widest.corners.iter().sum::<DVec3>() / 3.0;
        let verdict = classifier.classify(*body, centre, widest.normal);
        push(builder, facet.corners.clone(), facet.material, verdict);
    }

    fn emit_piece(
        &self,
        t: usize,
        piece: [u32; 3],
        classifier: &SurfaceClassifier,
        builder: &mut ProxyMeshBuilder,
    ) {
        let triangle = &self.triangles[t];
        let corners = piece.map(|v| self.weld.positions[v as usize]);
        let longest = (0..3).map(|k| corners[k].distance(corners[(k + 1) % 3]));
        let longest = longest.fold(0.0, f64::max);
        if area_vector(&corners).length() <= 0.5 * self.touch * longest {
            return;
        }
        let sheet = &self.sheets[self.owners[t] as usize];
        let centre = corners.iter().sum::<DVec3>() / 3.0;
        let verdict = classifier.classify(sheet.body, centre, triangle.normal);
        let given = self.places[t].map(|k| sheet.facet.corners[k as usize].1);
        let corner = |p: DVec3| {
            let weights = weights(triangle, p);
            let normal: DVec3 = given.iter().zip(weights).map(|(&n, w)| n * w).sum();
            (p, normal.normalize_or(triangle.normal))
        };
        let corners = corners.map(corner).to_vec();
        push(builder, corners, sheet.facet.material, verdict);
    }

    /// The pieces into which the segments divide a triangle.
    fn divided(&mut self, t: usize) -> Vec<[u32; 3]> {
        let triangle = self.triangles[t];
        let sides = [0, 1, 2].map(|k| self.on_side(&triangle, k));
        let mut split = SplitTriangle::new(&triangle, &self.weld.positions);
        for (k, between) in sides.iter().enumerate() {
            let ends = [k, (k + 1) % 3].map(|k| triangle.numbers[k]);
            let mut chain = vec![ends[0]];
            chain.extend(between);
            chain.push(ends[1]);
            for pair in chain.windows(2) {
                split.add_line([pair[0], pair[1]], &self.weld.positions);
            }
        }
        let mut lines: Vec<[u32; 2]> = self.lines[t].clone();
        lines.sort_unstable();
        lines.dedup();
        for &line in &lines {
            split.add_line(line, &self.weld.positions);
        }
        split.pieces(&mut self.weld)
    }
}

/// The numbers of a side's ends, ascending.
fn edge(triangle: &IndexedTriangle, side: usize) -> [u32; 2] {
    let [a, b] = [side, (side + 1) % 3].map(|k| triangle.numbers[k]);
    [a.min(b), a.max(b)]
}

/// The triangles of a body, for inside tests.
fn body_tree(facets: &[Facet]) -> TriangleTree {
    let (mut names, mut points) = (Vec::new(), Vec::new());
    for (face, facet) in (0..).zip(facets) {
        for (triangle, corners) in (0..).zip(triangulated(facet)) {
            names.push(MeshTriangle {
                face,
                triangle,
                corners,
            });
            points.push(corners.map(|k| facet.corners[k as usize].0));
        }
    }
    TriangleTree::of(names, points)
}

fn triangulated(facet: &Facet) -> Vec<[u32; 3]> {
    let mut mesh = Mesh {
        positions: facet.corners.iter().map(|c| c.0).collect(),
        ..Mesh::default()
    };
    mesh.push_face(&(0..facet.corners.len() as u32).collect::<Vec<_>>(), 0);
    mesh.triangulate(0)
}

fn push(
    builder: &mut ProxyMeshBuilder,
    mut corners: Vec<(DVec3, DVec3)>,
    material: u32,
    verdict: PieceSide,
) {
    if verdict == PieceSide::Reversed {
        corners.reverse();
        corners.iter_mut().for_each(|corner| corner.1 = -corner.1);
    }
    if verdict != PieceSide::Dropped {
        builder.push(&corners, material);
    }
}

/// Barycentric weights of a point in a triangle's plane.
fn weights(triangle: &IndexedTriangle, p: DVec3) -> [f64; 3] {
    let [a, b, c] = triangle.corners;
    let area = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p).dot(triangle.normal);
    let whole = area(a, b, c);
    [area(p, b, c), area(a, p, c), area(a, b, p)].map(|w| (w / whole).clamp(0.0, 1.0))
}

/// The constrained triangulation of one triangle with the segments through it.
struct SplitTriangle {
    origin: DVec3,
    axes: [DVec3; 2],
    mesh: Delaunay,
    handles: HashMap<u32, FixedVertexHandle>,
    numbers: Vec<u32>,
    lines: Vec<[FixedVertexHandle; 2]>,
}

impl SplitTriangle {
    fn new(triangle: &IndexedTriangle, positions: &[DVec3]) -> SplitTriangle {
        let [a, b, c] = triangle.corners;
        let size = a.distance(b).max(a.distance(c));
        let along = (b - a).normalize();
        let mut split = SplitTriangle {
            origin: a,
            axes: [along, triangle.normal.cross(along)].map(|axis| size * axis),
            mesh: Delaunay::new(),
            handles: HashMap::new(),
            numbers: Vec::new(),
            lines: Vec::new(),
        };
        for v in triangle.numbers {
            split.handle(v, positions);
        }
        split
    }

    /// The vertex of the position with this number.
    fn handle(&mut self, number: u32, positions: &[DVec3]) -> Option<FixedVertexHandle> {
        if let Some(&known) = self.handles.get(&number) {
            return Some(known);
        }
        let offset = positions[number as usize] - self.origin;
        let p = self
            .axes
            .map(|axis| offset.dot(axis) / axis.length_squared());
        // Values below spade's smallest count as zero.
        let [x, y] = p.map(|x| if x.abs() < 1e-40 { 0.0 } else { x });
        let vertices = self.mesh.num_vertices();
        let handle = self.mesh.insert(Point2::new(x, y)).ok()?;
        if self.mesh.num_vertices() > vertices {
            self.numbers.push(number);
        }
        self.handles.insert(number, handle);
        Some(handle)
    }

    fn add_line(&mut self, [a, b]: [u32; 2], positions: &[DVec3]) {
        if let [Some(from), Some(to)] = [a, b].map(|number| self.handle(number, positions)) {
            self.lines.push([from, to]);
        }
    }

    fn pieces(mut self, weld: &mut Weld) -> Vec<[u32; 3]> {
        let place = |v: FixedVertexHandle| point(self.mesh.vertex(v).position());
        let lines = self.lines.iter().map(|ends| ends.map(place)).collect();
        add_edges(&mut self.mesh, lines, GRID);
        // Intersections of segments are numbered last.
        self.numbers.resize(self.mesh.num_vertices(), u32::MAX);
        for (number, vertex) in self.numbers.iter_mut().zip(self.mesh.vertices()) {
            if *number == u32::MAX {
                let p = point(vertex.position());
                let [x, y] = self.axes;
                *number = weld.number(self.origin + p.x * x + p.y * y);
            }
        }
        let faces = self.mesh.inner_faces();
        let corners = faces.map(|f| f.vertices().map(|v| self.numbers[v.fix().index()]));
        corners.collect()
    }
}
