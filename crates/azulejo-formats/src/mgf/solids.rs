//! Tessellation of MGF's curved surfaces.
//!
//! Circles become polygons with the same perimeter, so that tubes keep their area and lamps their
//! flux: corners lie slightly outside, edge midpoints slightly inside, by no more than [`sides`]
//! allows. Circles around one axis have their corners at the same angles, so that surfaces with a
//! common rim fit without cracks.

use azulejo_scene::math::{Frame, area_vector};
use azulejo_scene::{Attribute, Mesh};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Maximum distance between a polygon and its circle, metres.
const TOLERANCE: f64 = 1e-3;

/// Number of sides of a circle with this radius in metres: as [`TOLERANCE`] requires, but 16 to 64,
/// for which the relative error is 0.013 to 0.0008.
pub(super) fn sides(radius: f64) -> u32 {
    // An edge midpoint is r (1 − a/tan a) inside, about r a²/3, for a = π/n.
    let n = PI * (radius / (3.0 * TOLERANCE)).sqrt();
    n.ceil().clamp(16.0, 64.0) as u32
}

/// Directions from an axis to the corners of a circle.
struct CircleDirections {
    spokes: Vec<DVec3>,
    /// The ratio of the corner radius to the radius of the circle.
    stretch: f64,
}

impl CircleDirections {
    /// Counter-clockwise around a unit axis.
    fn new(axis: DVec3, sides: u32) -> CircleDirections {
        let frame = Frame::from_normal(one_of_both_ways(axis));
        let turn = frame.x.cross(frame.y).dot(axis);
        let spoke = |i: u32| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
            cos * frame.x + turn * sin * frame.y
        };
        let half = PI / f64::from(sides);
        CircleDirections {
            spokes: (0..sides).map(spoke).collect(),
            stretch: half / half.sin(),
        }
    }

    /// The unit direction halfway between a corner and the next.
    fn between(&self, i: usize) -> DVec3 {
        let next = self.spokes[(i + 1) % self.spokes.len()];
        (self.spokes[i] + next).normalize()
    }
}

/// A direction or its opposite, the same one for both.
fn one_of_both_ways(axis: DVec3) -> DVec3 {
    let largest = axis.abs().max_element();
    let first = axis.to_array().into_iter().find(|c| c.abs() == largest);
    axis * first.unwrap_or(1.0).signum()
}

/// A mesh with one material and one normal per vertex.
#[derive(Default)]
struct SolidMesh {
    mesh: Mesh,
    normals: Vec<DVec3>,
}

impl SolidMesh {
    fn vertex(&mut self, position: DVec3, normal: DVec3) {
        self.mesh.positions.push(position);
        self.normals.push(normal);
    }

    fn face(&mut self, corners: &[usize]) {
        let corners: Vec<u32> = corners.iter().map(|&c| c as u32).collect();
        self.mesh.push_face(&corners, 0);
    }

    /// The mesh, inverted if it faces inward.
    fn finish(mut self, inward: bool) -> Mesh {
        if inward {
            self.mesh.flip();
            self.normals.iter_mut().for_each(|n| *n = -*n);
        }
        self.mesh.normals = Some(Attribute::per_vertex(self.normals));
        self.mesh
    }
}

/// The lateral surface of a cylinder or cone from the circle (`a`, `ra`) to (`b`, `rb`). Radii are
/// both non-negative, or both non-positive for a surface that faces its axis; `None` if they are
/// not, if both are 0, or if the axis has no length.
pub(super) fn cone(a: DVec3, ra: f64, b: DVec3, rb: f64, sides: u32) -> Option<Mesh> {
    let (axis, length) = ((b - a).try_normalize()?, (b - a).length());
    if ra * rb < 0.0 || (ra == 0.0 && rb == 0.0) {
        return None;
    }
    let inward = ra < 0.0 || rb < 0.0;
    let (ra, rb) = (ra.abs(), rb.abs());
    let circle = CircleDirections::new(axis, sides);
    // Perpendicular to the slope, in the plane of a spoke and the axis.
    let tilt = (ra - rb) / length;
    let normal = |spoke: DVec3| (spoke + tilt * axis).normalize_or(axis);
    let n = circle.spokes.len();
    let mut draft = SolidMesh::default();
    for (centre, r) in [(a, ra), (b, rb)] {
        for (i, &spoke) in circle.spokes.iter().enumerate() {
            // The apex has a vertex for each side, so that each is shaded along its own middle.
            let at_tip = r == 0.0;
            let outward = if at_tip { circle.between(i) } else { spoke };
            draft.vertex(centre + r * circle.stretch * spoke, normal(outward));
        }
    }
    for i in 0..n {
        let j = (i + 1) % n;
        match (ra == 0.0, rb == 0.0) {
            (true, _) => draft.face(&[i, n + j, n + i]),
            (_, true) => draft.face(&[i, j, n + i]),
            _ => draft.face(&[i, j, n + j, n + i]),
        }
    }
    Some(draft.finish(inward))
}

/// A flat annulus, or a disc if the inner radius is 0. It has a single normal.
pub(super) fn ring(centre: DVec3, normal: DVec3, inner: f64, outer: f64, sides: u32) -> Mesh {
    let circle = CircleDirections::new(normal, sides);
    let mut draft = SolidMesh::default();
    let at = |r: f64, spoke: DVec3| centre + r * circle.stretch * spoke;
    for &spoke in &circle.spokes {
        draft.vertex(at(outer, spoke), normal);
    }
    let n = circle.spokes.len();
    if inner == 0.0 {
        draft.face(&Vec::from_iter(0..n));
    } else {
        for &spoke in &circle.spokes {
            draft.vertex(at(inner, spoke), normal);
        }
        for i in 0..n {
            let j = (i + 1) % n;
            draft.face(&[n + i, i, j, n + j]);
        }
    }
    // A flat surface needs no normals of its own.
    draft.mesh
}

/// A whole torus: `inner` and `outer` are distances from the axis, negative for one that faces the
/// centre of its tube.
pub(super) fn torus(centre: DVec3, axis: DVec3, inner: f64, outer: f64, sides: [u32; 2]) -> Mesh {
    let inward = inner < 0.0 || outer < 0.0;
    let (middle, tube) = (
        (inner.abs() + outer.abs()) / 2.0,
        (outer.abs() - inner.abs()).abs() / 2.0,
    );
    let around = CircleDirections::new(axis, sides[0]);
    let half = PI / f64::from(sides[1]);
    let tube_stretch = half / half.sin();
    let mut draft = SolidMesh::default();
    for &spoke in &around.spokes {
        for j in 0..sides[1] {
            let (sin, cos) = (TAU * f64::from(j) / f64::from(sides[1])).sin_cos();
            let out = (middle + tube_stretch * tube * cos) * around.stretch;
            let position = centre + out * spoke + tube_stretch * tube * sin * axis;
            draft.vertex(position, cos * spoke + sin * axis);
        }
    }
    let (n, m) = (around.spokes.len(), sides[1] as usize);
    for i in 0..n {
        for j in 0..m {
            let (i2, j2) = ((i + 1) % n, (j + 1) % m);
            draft.face(&[i * m + j, i2 * m + j, i2 * m + j2, i * m + j2]);
        }
    }
    draft.finish(inward)
}

/// A prism: the base, a copy of it translated by `length` against its normal, and the sides. If all
/// corners of the base have normals, these shade the sides. `None` if the base has no area.
pub(super) fn prism(base: &[(DVec3, Option<DVec3>)], length: f64) -> Option<Mesh> {
    let outline: Vec<DVec3> = base.iter().map(|v| v.0).collect();
    let normal = area_vector(&outline).try_normalize()?;
    let n = base.len();
    let mut mesh = Mesh {
        positions: outline.clone(),
        ..Mesh::default()
    };
    mesh.positions
        .extend(outline.iter().map(|&p| p - length * normal));
    let corners = n as u32;
    mesh.push_face(&Vec::from_iter(0..corners), 0);
    mesh.push_face(&Vec::from_iter((corners..2 * corners).rev()), 0);
    for i in 0..corners {
        let j = (i + 1) % corners;
        mesh.push_face(&[i, corners + i, corners + j, j], 0);
    }
    let normals: Option<Vec<DVec3>> = base.iter().map(|v| v.1).collect();
    mesh.normals = normals.map(|normals| shaded_sides(normals, normal));
    Some(mesh)
}

/// Normals of a prism's corners: the given ones on the sides; flat ends, the first with normal
/// `end`.
fn shaded_sides(mut normals: Vec<DVec3>, end: DVec3) -> Attribute<DVec3> {
    let n = normals.len() as u32;
    normals.extend([end, -end]);
    let mut corners = vec![n; n as usize];
    corners.extend(vec![n + 1; n as usize]);
    for i in 0..n {
        let j = (i + 1) % n;
        corners.extend([i, i, j, j]);
    }
    Attribute {
        values: normals,
        corners: Some(corners),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that every face is oriented like the normals of its corners.
    fn check_fronts(mesh: &Mesh) {
        let normals = mesh.normals.as_ref().unwrap();
        for f in 0..mesh.faces.len() {
            let area = mesh.face_area_vector(f);
            for (corner, &v) in mesh.faces.corner_range(f).zip(mesh.faces.get(f)) {
                let n = normals.at(corner, v);
                assert!((n.length() - 1.0).abs() < 1e-12);
                assert!(n.dot(area) > 0.5 * area.length(), "face {f}: {n} {area}");
            }
        }
    }

    fn check_area(mesh: &Mesh, expected: f64, tolerance: f64) {
        let area = mesh.area();
        assert!(
            (area / expected - 1.0).abs() < tolerance,
            "{area}, expected {expected}"
        );
    }

    /// The sum of area vectors: zero if the surface is closed.
    fn leak(mesh: &Mesh) -> f64 {
        let sum: DVec3 = (0..mesh.faces.len())
            .map(|f| mesh.face_area_vector(f))
            .sum();
        sum.length() / mesh.area()
    }

    const A: DVec3 = DVec3::new(1.0, 2.0, 3.0);
    const B: DVec3 = DVec3::new(2.0, 4.0, 5.0);

    #[test]
    fn tubes_keep_their_area_and_face_outside() {
        let tube = cone(A, 0.5, B, 0.5, 16).unwrap();
        check_fronts(&tube);
        check_area(&tube, TAU * 0.5 * 3.0, 1e-12);
        let out = tube.positions[0] - A;
        assert!(tube.normals.as_ref().unwrap().values[0].dot(out) > 0.0);
        let inside = cone(A, -0.5, B, -0.5, 16).unwrap();
        check_fronts(&inside);
        assert!(inside.normals.as_ref().unwrap().values[0].dot(out) < 0.0);
    }

    #[test]
    fn cones_have_tips() {
        for (ra, rb) in [
            (0.5, 0.0),
            (0.0, 0.5),
            (0.5, 0.2),
            (-0.2, -0.5),
            (0.0, -1.0),
        ] {
            let mesh = cone(A, ra, B, rb, 24).unwrap();
            check_fronts(&mesh);
            let slant = 3f64.hypot(ra.abs() - rb.abs());
            check_area(&mesh, PI * (ra.abs() + rb.abs()) * slant, 2e-3);
        }
        assert!(cone(A, 1.0, A, 1.0, 24).is_none());
        assert!(cone(A, 1.0, B, -1.0, 24).is_none());
        assert!(cone(A, 0.0, B, 0.0, 24).is_none());
    }

    #[test]
    fn a_tube_and_its_lids_share_their_rims() {
        let axis = (B - A).normalize();
        let tube = cone(A, 0.5, B, 0.5, 16).unwrap();
        let lid = ring(A, -axis, 0.0, 0.5, 16);
        for p in &lid.positions {
            assert!(tube.positions.iter().any(|q| (*p - *q).length() < 1e-12));
        }
        assert!(lid.face_area_vector(0).dot(axis) < 0.0);
    }

    #[test]
    fn rings() {
        let annulus = ring(A, DVec3::Y, 0.5, 1.0, 64);
        check_area(&annulus, PI * 0.75, 1e-3);
        assert!((0..64).all(|f| annulus.face_area_vector(f).y > 0.0));
        assert_eq!(ring(A, DVec3::Y, 0.0, 1.0, 64).faces.len(), 1);
    }

    #[test]
    fn tori_are_closed() {
        for (inner, outer) in [(1.0, 2.0), (0.0, 2.0), (-1.0, -2.0)] {
            let mesh = torus(A, DVec3::Z, inner, outer, [48, 32]);
            check_fronts(&mesh);
            let (middle, tube) = ((inner + outer) / 2.0, (outer - inner) / 2.0);
            check_area(&mesh, 4.0 * PI * PI * f64::abs(middle * tube), 3e-3);
            assert!(leak(&mesh) < 1e-12);
        }
    }

    #[test]
    fn prisms() {
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)];
        let base = |normals: bool| {
            square.map(|(x, y)| {
                let out = DVec3::new(x - 1.0, y - 1.0, 0.0).normalize();
                (DVec3::new(x, y, 0.0), normals.then_some(out))
            })
        };
        let mesh = prism(&base(false), 3.0).unwrap();
        assert_eq!(
            (mesh.faces.len(), mesh.area(), mesh.normals.is_none()),
            (6, 32.0, true)
        );
        assert_eq!(mesh.bounds().min.z, -3.0);
        assert_eq!(mesh.face_area_vector(0), DVec3::new(0.0, 0.0, 4.0));
        assert!(leak(&mesh) < 1e-12);
        // Each side faces away from the centre, or toward it.
        let middle = |z| DVec3::new(1.0, 1.0, z);
        for length in [3.0, -3.0] {
            let mesh = prism(&base(false), length).unwrap();
            for f in 0..6 {
                let away = mesh.face_positions(f)[0] - middle(-length / 2.0);
                assert_eq!(away.dot(mesh.face_area_vector(f)) > 0.0, length > 0.0);
            }
        }
        check_fronts(&prism(&base(true), 3.0).unwrap());
        assert!(prism(&base(true)[..2], 3.0).is_none());
    }

    #[test]
    fn the_more_sides_the_larger() {
        assert_eq!([1e-9, 0.1, 0.3, 1.0, 1e9].map(sides), [16, 19, 32, 58, 64]);
        let far = |n: u32| {
            let half = PI / f64::from(n);
            (1.0 - half / half.tan()).max(half / half.sin() - 1.0)
        };
        assert!(far(16) < 0.0131 && far(64) < 0.0009 && 0.3 * far(32) < TOLERANCE);
    }
}
