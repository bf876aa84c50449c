//! Faces whose edges cross each other, divided into triangles that do not overlap.

use crate::math::{Frame, area_vector};
use crate::proxy::FlatFigure;
use crate::triangulate::{MOST_TOUCHING, never_turns_right, turns};
use crate::{Attribute, Figure, Mesh};
use glam::{DVec2, DVec3};
use std::ops::{Add, Mul};

/// Largest distance of a face's corners from its plane, as a fraction of its size: the edges of a face
/// that is less flat pass each other in space.
const FLATNESS: f64 = 1e-4;

impl Mesh {
    /// Divides the faces whose edges cross, and returns how many there were.
    ///
    /// The inside of such a face is where a line from outside crosses its edges an odd number of
    /// times, as in SVG's `evenodd` and GLU's default for polygons. It becomes triangles, all with
    /// the front of the face's area vector (if that is zero, as that of a bow-tie can be, of its largest
    /// fan triangle), over the corners and new vertices at the crossings, whose attributes are interpolated
    /// along one of the two edges. The triangles have the area of the inside together.
    ///
    /// Faces that are not plane or have thousands of corners stay as they are, and so do all faces of a mesh
    /// with irradiance, which belongs to the vertices it has.
    pub fn divide_crossing_faces(&mut self) -> usize {
        if !self.irradiance.is_empty() || self.back.is_some() {
            return 0;
        }
        let crossing = |face| Some((face, DividedFace::of(&self.face_positions(face))?));
        let quads = (0..self.faces.len()).filter(|&f| self.faces.corner_range(f).len() > 3);
        let divided: Vec<(usize, DividedFace)> = quads.filter_map(crossing).collect();
        if !divided.is_empty() {
            self.replace(&divided);
        }
        divided.len()
    }

    fn replace(&mut self, divided: &[(usize, DividedFace)]) {
        let old = std::mem::take(&mut self.faces);
        let materials = std::mem::take(&mut self.face_materials);
        let smoothing = std::mem::take(&mut self.smoothing);
        let mut normals = self.normals.take().map(RebuiltAttribute::new);
        let mut uvs = self.uvs.take().map(RebuiltAttribute::new);
        let mut next = divided.iter().peekable();
        for face in 0..old.len() {
            let (first, corners) = (old.corner_range(face).start, old.get(face));
            let whole = DividedFace::whole(corners.len());
            let (parts, is_divided) = match next.next_if(|d| d.0 == face) {
                Some((_, parts)) => (parts, true),
                None => (&whole, false),
            };
            let vertices = parts.points.iter().map(|p| self.vertex(p, corners));
            let vertices: Vec<u32> = vertices.collect();
            if let Some(normals) = &mut normals {
                let unit = |n: DVec3| n.normalize_or(DVec3::Z);
                normals.push(parts, is_divided, first, corners, unit);
            }
            if let Some(uvs) = &mut uvs {
                uvs.push(parts, is_divided, first, corners, |uv| uv);
            }
            let mut copies = 1;
            if is_divided {
                copies = parts.triangles.len();
                for t in &parts.triangles {
                    self.faces.push(&t.map(|k| vertices[k as usize]));
                }
            } else {
                self.faces.push(corners);
            }
            let same = |list: &[u32], into: &mut Vec<u32>| {
                into.extend(list.get(face).into_iter().cycle().take(copies));
            };
            same(&materials, &mut self.face_materials);
            same(&smoothing, &mut self.smoothing);
        }
        self.normals = normals.map(RebuiltAttribute::finish);
        self.uvs = uvs.map(RebuiltAttribute::finish);
    }

    /// The vertex of a point of a face with these corners: one of them, or a new one.
    fn vertex(&mut self, point: &DividedPoint, corners: &[u32]) -> u32 {
        let [a, b] = point.edge(corners.len()).map(|k| corners[k] as usize);
        if point.share == 0.0 {
            return a as u32;
        }
        let share = point.share;
        let position = self.positions[a].lerp(self.positions[b], share);
        self.positions.push(position);
        if !self.colors.is_empty() {
            self.colors
                .push(mixed(self.colors[a], self.colors[b], share));
        }
        self.positions.len() as u32 - 1
    }
}

fn mixed<T: Copy + Add<Output = T> + Mul<f64, Output = T>>(a: T, b: T, share: f64) -> T {
    a * (1.0 - share) + b * share
}

/// An attribute while the faces that it belongs to are divided.
struct RebuiltAttribute<T> {
    values: Vec<T>,
    /// The index of each corner's value before and after, unless the values belong to vertices.
    corners: Option<[Vec<u32>; 2]>,
}

impl<T: Copy + Add<Output = T> + Mul<f64, Output = T>> RebuiltAttribute<T> {
    fn new(attribute: Attribute<T>) -> RebuiltAttribute<T> {
        RebuiltAttribute {
            values: attribute.values,
            corners: attribute.corners.map(|old| [old, Vec::new()]),
        }
    }

    /// Adds a face whose corners are these vertices, the first of them corner `first` of the mesh.
    fn push(
        &mut self,
        parts: &DividedFace,
        is_divided: bool,
        first: usize,
        vertices: &[u32],
        usable: impl Fn(T) -> T,
    ) {
        let n = vertices.len();
        let corner_index = |corners: &Option<[Vec<u32>; 2]>, k: usize| match corners {
            Some([old, _]) => old[first + k],
            None => vertices[k],
        };
        let mut indices = Vec::with_capacity(parts.points.len());
        for point in &parts.points {
            let [a, b] = point.edge(n).map(|k| corner_index(&self.corners, k));
            if point.share == 0.0 {
                indices.push(a);
                continue;
            }
            let value = mixed(
                self.values[a as usize],
                self.values[b as usize],
                point.share,
            );
            // Values of vertices get as many new ones as there are new vertices, in their order.
            indices.push(self.values.len() as u32);
            self.values.push(usable(value));
        }
        let Some([_, corners]) = &mut self.corners else {
            return;
        };
        if is_divided {
            let divided = parts.triangles.iter().flatten();
            corners.extend(divided.map(|&k| indices[k as usize]));
        } else {
            corners.extend(indices);
        }
    }

    fn finish(self) -> Attribute<T> {
        Attribute {
            values: self.values,
            corners: self.corners.map(|[_, new]| new),
        }
    }
}

/// A point of a divided face, on the edge from corner `from`, 0 <= `share` < 1 of the way.
#[derive(Clone, Copy, Debug)]
struct DividedPoint {
    from: usize,
    share: f64,
}

impl DividedPoint {
    /// The corners of its edge, in a face of `n`.
    fn edge(self, n: usize) -> [usize; 2] {
        [self.from, (self.from + 1) % n]
    }
}

/// A face as triangles over its corners and crossings.
#[derive(Debug)]
struct DividedFace {
    points: Vec<DividedPoint>,
    triangles: Vec<[u32; 3]>,
}

impl DividedFace {
    /// The corners of a face that is not divided.
    fn whole(n: usize) -> DividedFace {
        let corner = |from| DividedPoint { from, share: 0.0 };
        DividedFace {
            points: (0..n).map(corner).collect(),
            triangles: Vec::new(),
        }
    }

    /// The parts of a polygon whose edges cross; `None` for any other.
    fn of(polygon: &[DVec3]) -> Option<DividedFace> {
        let n = polygon.len();
        if !(4..=MOST_TOUCHING).contains(&n) {
            return None;
        }
        let frame = Frame::from_normal(front(polygon)?);
        let local = polygon.iter().map(|&p| frame.to_local(p - polygon[0]));
        let local: Vec<DVec3> = local.collect();
        let flat: Vec<DVec2> = local.iter().map(|p| p.truncate()).collect();
        let is_convex = never_turns_right(&flat) && turns(&flat) < 1.5;
        if is_convex || !crosses(&flat) {
            return None;
        }
        let figure = Figure::polygon(flat.iter().copied());
        let size = figure.bounds().size().max_element();
        if local.iter().any(|p| p.z.abs() > FLATNESS * size) {
            return None;
        }
        let inside = FlatFigure::new(&figure, size);
        let points = inside.points.iter().map(|&p| place(&flat, p, size));
        let triangles = inside.tiles.iter().flat_map(|tile| &tile.triangles);
        let divided = DividedFace {
            points: points.collect::<Option<_>>()?,
            triangles: triangles.copied().collect(),
        };
        (!divided.triangles.is_empty()).then_some(divided)
    }
}

/// Unit normal of a polygon's front; `None` if all its corners are on a line.
fn front(polygon: &[DVec3]) -> Option<DVec3> {
    let fan = polygon[1..]
        .windows(2)
        .map(|w| area_vector(&[polygon[0], w[0], w[1]]));
    let larger = |a: DVec3, b: DVec3| {
        if b.length_squared() > a.length_squared() {
            b
        } else {
            a
        }
    };
    let largest = fan.fold(DVec3::ZERO, larger);
    let area = area_vector(polygon);
    // What is left of two equal lobes is rounding, and no direction.
    let is_clear = area.length() > 1e-6 * largest.length();
    let normal = if is_clear { area } else { largest }.try_normalize();
    normal.filter(|n| n.is_finite())
}

/// Whether two edges cross between their ends. Edges are compared where their ranges of x overlap.
fn crosses(flat: &[DVec2]) -> bool {
    let n = flat.len();
    let mut edges: Vec<[DVec2; 2]> = (0..n).map(|k| [flat[k], flat[(k + 1) % n]]).collect();
    let left = |e: &[DVec2; 2]| e[0].x.min(e[1].x);
    edges.sort_by(|a, b| left(a).total_cmp(&left(b)));
    edges.iter().enumerate().any(|(k, edge)| {
        let right = edge[0].x.max(edge[1].x);
        let near = edges[k + 1..]
            .iter()
            .take_while(|other| left(other) <= right);
        near.into_iter().any(|other| cross(edge, other))
    })
}

/// Whether the ends of each edge are clearly on both sides of the other.
fn cross(a: &[DVec2; 2], b: &[DVec2; 2]) -> bool {
    let divides = |line: &[DVec2; 2], ends: &[DVec2; 2]| {
        let along = line[1] - line[0];
        let [p, q] = ends.map(|e| along.perp_dot(e - line[0]));
        let least = 1e-9 * along.length() * (along.length() + (ends[1] - ends[0]).length());
        p.min(q) < -least && p.max(q) > least
    };
    divides(a, b) && divides(b, a)
}

/// The corner at a point, or the point's place on the nearest edge; `None` if none is near.
fn place(flat: &[DVec2], p: DVec2, size: f64) -> Option<DividedPoint> {
    let n = flat.len();
    let near = 1e-8 * size;
    if let Some(from) = flat.iter().position(|c| c.distance(p) <= near) {
        return Some(DividedPoint { from, share: 0.0 });
    }
    let on_edge = |from: usize| {
        let (a, b) = (flat[from], flat[(from + 1) % n]);
        let along = b - a;
        let share = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0 - 1e-12);
        (a.lerp(b, share).distance(p), DividedPoint { from, share })
    };
    let nearest = (0..n).map(on_edge).filter(|e| e.0.is_finite());
    let (distance, point) = nearest.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (distance <= near).then_some(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn mesh(points: &[DVec2]) -> Mesh {
        let place = |p: &DVec2| {
            DVec3::new(40.0, 5.0, 10.0) + p.x * DVec3::new(0.6, 0.0, 0.8) + p.y * DVec3::Y
        };
        let mut mesh = Mesh {
            positions: points.iter().map(place).collect(),
            ..Mesh::default()
        };
        mesh.push_face(&(0..points.len() as u32).collect::<Vec<_>>(), 7);
        mesh
    }

    /// Sum of the areas of the triangles that are traced.
    fn traced_area(mesh: &Mesh) -> f64 {
        let of = |face: usize| {
            let corners = mesh.face_positions(face);
            let triangles = mesh.triangulate(face);
            let area = |t: &[u32; 3]| area_vector(&t.map(|k| corners[k as usize])).length();
            triangles.iter().map(area).sum::<f64>()
        };
        (0..mesh.faces.len()).map(of).sum()
    }

    /// Area where lines cross the outline an odd number of times: between neighbouring corners and
    /// crossings in x no edges cross, and every second trapezoid is inside.
    fn even_odd_area(flat: &[DVec2]) -> f64 {
        let n = flat.len();
        let edges: Vec<[DVec2; 2]> = (0..n).map(|k| [flat[k], flat[(k + 1) % n]]).collect();
        let mut cuts: Vec<f64> = flat.iter().map(|p| p.x).collect();
        for (k, [a, b]) in edges.iter().enumerate() {
            for [c, d] in &edges[..k] {
                let (u, v) = (*b - *a, *d - *c);
                let t = (*c - *a).perp_dot(v) / u.perp_dot(v);
                if (0.0..=1.0).contains(&t) {
                    cuts.push(a.x + t * u.x);
                }
            }
        }
        cuts.sort_by(f64::total_cmp);
        let slab = |w: &[f64]| {
            let middle = 0.5 * (w[0] + w[1]);
            let mut heights: Vec<f64> = edges
                .iter()
                .filter(|[a, b]| (a.x < middle) != (b.x < middle))
                .map(|[a, b]| a.y + (middle - a.x) / (b.x - a.x) * (b.y - a.y))
                .collect();
            heights.sort_by(f64::total_cmp);
            let inside: f64 = heights.chunks_exact(2).map(|h| h[1] - h[0]).sum();
            (w[1] - w[0]) * inside
        };
        cuts.windows(2).map(slab).sum()
    }

    fn divided(points: &[DVec2]) -> Mesh {
        let mut mesh = mesh(points);
        mesh.divide_crossing_faces();
        mesh
    }

    fn at(points: &[(f64, f64)]) -> Vec<DVec2> {
        points.iter().map(|&p| p.into()).collect()
    }

    #[test]
    fn bow_ties_are_two_triangles() {
        let even = at(&[(0., 0.), (2., 2.), (2., 0.), (0., 2.)]);
        let uneven = at(&[(0., 0.), (4., 3.), (4., 0.), (0., 1.)]);
        for points in [even, uneven] {
            let mesh = divided(&points);
            assert_eq!((mesh.faces.len(), mesh.positions.len()), (2, 5));
            assert_eq!(mesh.face_materials, [7, 7]);
            let [a, b] = [0, 1].map(|f| mesh.face_area_vector(f));
            assert!(a.dot(b) > 0.0, "both have the same front");
            assert!((traced_area(&mesh) - even_odd_area(&points)).abs() < 1e-9);
        }
    }

    #[test]
    fn the_middle_of_a_pentagram_is_outside() {
        let corner = |k: u32| DVec2::from_angle(f64::from(2 * k) * std::f64::consts::TAU / 5.0);
        let points: Vec<DVec2> = (0..5).map(corner).collect();
        let mesh = divided(&points);
        assert_eq!(mesh.positions.len(), 10);
        assert!((traced_area(&mesh) - even_odd_area(&points)).abs() < 1e-9);
    }

    #[test]
    fn attributes_are_interpolated_where_edges_cross() {
        let points = at(&[(0., 0.), (2., 2.), (2., 0.), (0., 2.)]);
        for per_corner in [false, true] {
            let mut mesh = mesh(&points);
            mesh.positions.push(DVec3::ZERO);
            mesh.push_face(&[0, 1, 4], 3);
            let uvs: Vec<DVec2> = points.iter().copied().chain([DVec2::ZERO]).collect();
            let mut attribute = Attribute::per_vertex(uvs);
            if per_corner {
                attribute.corners = Some(mesh.faces.corners.clone());
            }
            mesh.uvs = Some(attribute);
            assert_eq!(mesh.divide_crossing_faces(), 1);
            assert_eq!(
                (mesh.faces.len(), &*mesh.face_materials),
                (3, &[7, 7, 3][..])
            );
            let uvs = mesh.uvs.as_ref().unwrap();
            let crossing = mesh.faces.corners.iter().position(|v| *v == 5).unwrap();
            assert!(uvs.at(crossing, 5).distance(DVec2::ONE) < 1e-9);
            let last = mesh.faces.corner_range(2);
            let of = |k: usize| uvs.at(k, mesh.faces.corners[k]);
            assert_eq!(
                last.map(of).collect::<Vec<_>>(),
                [points[0], points[1], DVec2::ZERO]
            );
        }
    }

    #[test]
    fn what_does_not_cross_stays() {
        let folded = Mesh {
            positions: vec![
                DVec3::ZERO,
                DVec3::new(1., 1., 0.),
                DVec3::X,
                DVec3::new(0., 1., 0.9),
            ],
            faces: mesh(&[DVec2::ZERO; 4]).faces,
            face_materials: vec![0],
            ..Mesh::default()
        };
        // Two loops that touch at a corner, and a dent.
        let touching = at(&[(0., 0.), (1., 1.), (2., 2.), (2., 0.), (1., 1.), (0., 2.)]);
        let dent = at(&[(0., 0.), (2., -2.), (0.5, 0.), (2., 2.)]);
        for mut mesh in [
            folded,
            mesh(&touching),
            mesh(&dent),
            mesh(&at(&[(1., 1.); 5])),
        ] {
            assert_eq!(mesh.divide_crossing_faces(), 0);
        }
        let mut lit = mesh(&at(&[(0., 0.), (2., 2.), (2., 0.), (0., 2.)]));
        lit.irradiance = vec![crate::Rgb::WHITE; 4];
        assert_eq!(lit.divide_crossing_faces(), 0);
    }

    proptest! {
        #[test]
        fn triangles_have_the_area_of_the_inside(
            corners in prop::collection::vec((-1.0f64..1.0, -1.0f64..1.0), 4..12)
        ) {
            let points = at(&corners);
            let (found, expected) = (traced_area(&divided(&points)), even_odd_area(&points));
            prop_assert!((found - expected).abs() < 1e-6, "{found} of {expected}");
        }
    }
}
