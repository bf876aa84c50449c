//! Shapes of SCN without an SFF record, composed of those that have one.

use crate::sff::document::{
    PatchData, PlacedData, PolygonData, RecordData, SffCone, SffGeometry, TriangleData,
};
use azulejo_scene::Faces;
use azulejo_scene::math::area_vector;
use glam::DVec3;
use std::f64::consts::TAU;

/// Radius of an apex, relative to that of the other end: SFF does not allow radius 0.
const POINT: f64 = 1e-6;

/// Height of discs and rings, which are flat cones.
const FLAT: f64 = 0.001;

/// Untransformed data.
pub(super) fn here<T>(data: T) -> Box<PlacedData<T>> {
    Box::new(PlacedData {
        origin: DVec3::ZERO,
        scale: DVec3::ONE,
        data: RecordData::Here(data),
    })
}

/// A disc that faces along the unit vector `normal`.
pub(super) fn disc(centre: DVec3, normal: DVec3, radius: f64) -> SffGeometry {
    SffGeometry::Cone(SffCone {
        base: centre,
        base_radius: radius,
        apex: centre + FLAT * normal,
        apex_radius: POINT * radius,
    })
}

/// A disc with a hole.
pub(super) fn ring(centre: DVec3, normal: DVec3, outer: f64, inner: f64) -> SffGeometry {
    SffGeometry::Cone(SffCone {
        base: centre,
        base_radius: outer,
        apex: centre + FLAT * normal,
        apex_radius: inner,
    })
}

/// A cone or cylinder and, unless it is open, discs over its ends. An end of radius 0 is an apex.
pub(super) fn cone(apex: (DVec3, f64), base: (DVec3, f64), open: bool) -> Vec<SffGeometry> {
    let ((apex, narrow), (base, wide)) = if apex.1 > base.1 {
        (base, apex)
    } else {
        (apex, base)
    };
    let side = SffGeometry::Cone(SffCone {
        base,
        base_radius: wide,
        apex,
        apex_radius: narrow.max(POINT * wide),
    });
    let mut pieces = vec![side];
    if !open {
        let axis = (apex - base).normalize_or_zero();
        pieces.push(disc(base, -axis, wide));
        if narrow > 0.0 {
            pieces.push(disc(apex, axis, narrow));
        }
    }
    pieces
}

/// Polygons over vertices.
pub(super) fn polygons(vertices: Vec<DVec3>, polygons: &[Vec<u32>]) -> SffGeometry {
    let mut faces = Faces::default();
    polygons.iter().for_each(|p| faces.push(p));
    SffGeometry::Polygons(here(PolygonData { faces, vertices }))
}

/// A base and a top with equally many corners, the sides between them and, unless it is open, both;
/// the top lies behind the base's front.
fn between(base: &[DVec3], top: Vec<DVec3>, open: bool) -> SffGeometry {
    let n = base.len() as u32;
    let vertices = [base, &top].concat();
    let side = |k: u32| {
        let next = (k + 1) % n;
        vec![next, k, n + k, n + next]
    };
    let mut faces: Vec<Vec<u32>> = (0..n).map(side).collect();
    if !open {
        faces.push((0..n).collect());
        faces.push((n..2 * n).rev().collect());
    }
    polygons(vertices, &faces)
}

/// The unit normal of a polygon's front; `None` if it has no area.
pub(super) fn normal(polygon: &[DVec3]) -> Option<DVec3> {
    area_vector(polygon).try_normalize()
}

/// A prism that extends behind its base.
pub(super) fn prism(base: &[DVec3], normal: DVec3, height: f64, open: bool) -> SffGeometry {
    let top = base.iter().map(|p| *p - height * normal);
    between(base, top.collect(), open)
}

/// A pyramid that extends behind its base, with its apex over the mean of the corners, or truncated
/// where its width is `top` times that of the base.
pub(super) fn pyramid(
    base: &[DVec3],
    normal: DVec3,
    height: f64,
    top: Option<f64>,
    open: bool,
) -> SffGeometry {
    let n = base.len() as u32;
    let mean = base.iter().sum::<DVec3>() / f64::from(n);
    let apex = mean - height * normal;
    if let Some(share) = top {
        let top = base.iter().map(|p| apex + share * (*p - mean));
        return between(base, top.collect(), open);
    }
    let side = |k: u32| vec![(k + 1) % n, k, n];
    let mut faces: Vec<Vec<u32>> = (0..n).map(side).collect();
    if !open {
        faces.push((0..n).collect());
    }
    polygons([base, &[apex]].concat(), &faces)
}

/// A tetrahedron.
pub(super) fn tetrahedron(p: [DVec3; 4]) -> SffGeometry {
    let turned = (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) > 0.0;
    let faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]].map(|mut face| {
        if turned {
            face.reverse();
        }
        face.to_vec()
    });
    polygons(p.to_vec(), &faces)
}

/// A patch over twelve points, listed once.
pub(super) fn patch(points: [DVec3; 12]) -> SffGeometry {
    SffGeometry::Patches(here(PatchData {
        patches: vec![std::array::from_fn(|k| k as u32)],
        vertices: points.to_vec(),
    }))
}

/// A torus around the y axis, or a segment of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScnTorus {
    /// Distance from the axis to the centre of the tube.
    pub radius: f64,
    /// Radius of the tube.
    pub tube: f64,
    /// The start angle, degrees from +x toward +z.
    pub from: f64,
    pub to: f64,
    /// Numbers of pieces along the ring and around the tube.
    pub pieces: [u32; 2],
    /// Whether the ends of a segment stay open.
    pub open: bool,
}

impl ScnTorus {
    /// Its triangles. The ends are closed by triangles, too, which match the tube's edges; the
    /// original's discs do not.
    pub fn triangles(&self) -> SffGeometry {
        let mut corners = Vec::new();
        let [along, around] = self.pieces;
        let full = (self.to - self.from).abs() >= 360.0;
        for i in 0..along {
            for j in 0..around {
                // A full turn ends exactly where it begins.
                let next = if full { (i + 1) % along } else { i + 1 };
                let [a, b, c, d] = [(i, j), (next, j), (next, j + 1), (i, j + 1)]
                    .map(|(i, j)| self.point(i, j % around));
                corners.push([a, c, b]);
                corners.push([a, d, c]);
            }
        }
        if !self.open && !full {
            self.end(0, -1.0, &mut corners);
            self.end(along, 1.0, &mut corners);
        }
        SffGeometry::Triangles(here(TriangleData {
            corners,
            surfaces: Vec::new(),
        }))
    }

    fn direction(&self, i: u32) -> (DVec3, DVec3) {
        let share = f64::from(i) / f64::from(self.pieces[0]);
        let angle = (self.from + (self.to - self.from) * share).to_radians();
        let (sin, cos) = angle.sin_cos();
        (DVec3::new(cos, 0.0, sin), DVec3::new(-sin, 0.0, cos))
    }

    fn point(&self, i: u32, j: u32) -> (DVec3, DVec3) {
        let (out, _) = self.direction(i);
        let (sin, cos) = (TAU * f64::from(j) / f64::from(self.pieces[1])).sin_cos();
        let normal = cos * out + sin * DVec3::Y;
        (self.radius * out + self.tube * normal, normal)
    }

    fn end(&self, i: u32, side: f64, corners: &mut Vec<[(DVec3, DVec3); 3]>) {
        let (out, onward) = self.direction(i);
        let normal = side * (self.to - self.from).signum() * onward;
        let around = self.pieces[1];
        for j in 0..around {
            let rim = [j, (j + 1) % around].map(|j| (self.point(i, j).0, normal));
            corners.push([(self.radius * out, normal), rim[0], rim[1]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that polygons close a volume with their fronts outside.
    fn check(geometry: &SffGeometry, volume: f64) {
        let (vertices, faces) = match geometry {
            SffGeometry::Polygons(placed) => match &placed.data {
                RecordData::Here(data) => (data.vertices.clone(), data.faces.clone()),
                RecordData::File(_) => unreachable!("made here"),
            },
            _ => unreachable!("polygons"),
        };
        let mut mesh = azulejo_scene::Mesh {
            positions: vertices,
            ..Default::default()
        };
        faces.iter().for_each(|f| mesh.push_face(f, 0));
        assert!(mesh.is_closed());
        let cone = |f: usize| mesh.face_area_vector(f).dot(mesh.face_positions(f)[0]) / 3.0;
        let mesh_volume: f64 = (0..mesh.faces.len()).map(cone).sum();
        assert!((mesh_volume - volume).abs() < 1e-12, "{mesh_volume}");
    }

    #[test]
    fn solids_are_closed_and_turned_outside() {
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)];
        let base = square.map(|(x, y)| DVec3::new(x, y, 1.0));
        let up = normal(&base).unwrap();
        assert_eq!(up, DVec3::Z);
        check(&prism(&base, up, 3.0, false), 12.0);
        check(&pyramid(&base, up, 3.0, None, false), 4.0);
        check(&pyramid(&base, up, 3.0, Some(0.5), false), 7.0);
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        check(&tetrahedron(corners), 1.0 / 6.0);
        let [a, b, c, d] = corners;
        check(&tetrahedron([a, c, b, d]), 1.0 / 6.0);
    }

    #[test]
    fn a_piece_of_a_torus_is_closed() {
        for (to, open, closed, count) in [
            (360.0, false, true, 2 * 6 * 5),
            (90.0, false, true, 2 * 6 * 5 + 10),
            (-90.0, false, true, 2 * 6 * 5 + 10),
            (90.0, true, false, 2 * 6 * 5),
        ] {
            let torus = ScnTorus {
                radius: 2.0,
                tube: 0.5,
                from: 0.0,
                to,
                pieces: [6, 5],
                open,
            };
            let SffGeometry::Triangles(placed) = torus.triangles() else {
                unreachable!("triangles")
            };
            let RecordData::Here(data) = &placed.data else {
                unreachable!("made here")
            };
            assert_eq!(data.corners.len(), count);
            let mut mesh = azulejo_scene::Mesh::default();
            for corners in &data.corners {
                let start = mesh.positions.len() as u32;
                mesh.positions.extend(corners.map(|c| c.0));
                mesh.push_face(&[start, start + 1, start + 2], 0);
            }
            assert_eq!(mesh.is_closed(), closed);
        }
    }
}
