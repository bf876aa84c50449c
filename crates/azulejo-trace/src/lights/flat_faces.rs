//! The flat convex polygons of a scene's surfaces.

use crate::lambert::ArrayPolygon;
use azulejo_scene::math::area_vector;
use azulejo_scene::{Material, MaterialId, PlacedMesh, Primitive, PrimitiveKind, Scene, Shape};
use glam::DVec3;

/// Which piece of a scene's surface a polygon is. Ordered as [`flat_faces`] visits them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct FaceKey {
    /// Index of the object.
    pub object: u32,
    /// Face of the mesh, or part of the primitive.
    pub face: u32,
    /// Which of the face's triangles; 0 for whole faces.
    pub triangle: u32,
}

/// A flat convex polygon of a surface.
pub(crate) struct FlatFace<'a> {
    pub key: FaceKey,
    /// Counter-clockwise about `normal`.
    pub polygon: ArrayPolygon,
    /// Unit normal of the front.
    pub normal: DVec3,
    pub material: &'a Material,
    /// Index of the material.
    pub id: MaterialId,
}

/// Visits the flat convex polygons of every surface whose material is `wanted`: whole faces
/// where they are flat and convex, else their triangles. Exact shapes, which are curved as a
/// rule, have none.
pub(crate) fn flat_faces<'a>(
    scene: &'a Scene,
    wanted: impl Fn(&Material) -> bool,
    mut visit: impl FnMut(FlatFace<'a>),
) {
    for (object, o) in (0..).zip(&scene.objects) {
        if let Some(placed) = o.shape.placed_mesh() {
            for (face, &id) in placed.mesh.face_materials.iter().enumerate() {
                let material = &scene.materials[id as usize];
                if wanted(material) {
                    visit_face(&placed, (object, face), (id, material), &mut visit);
                }
            }
        }
        match &o.shape {
            Shape::Primitive(p) if is_flat(p.kind) => {
                let material = &scene.materials[p.material as usize];
                if wanted(material) {
                    for part in 0..p.kind.parts() {
                        visit(FlatFace {
                            key: FaceKey {
                                object,
                                face: part as u32,
                                triangle: 0,
                            },
                            polygon: part_polygon(p, part),
                            normal: p.point(part, 0.5, 0.5).normal,
                            material,
                            id: p.material,
                        });
                    }
                }
            }
            _ => {}
        }
    }
}

/// Whether all parts of a primitive are flat.
pub(crate) fn is_flat(kind: PrimitiveKind) -> bool {
    matches!(kind, PrimitiveKind::Cuboid | PrimitiveKind::Square)
}

fn visit_face<'a>(
    mesh: &PlacedMesh,
    (object, face): (u32, usize),
    (id, material): (MaterialId, &'a Material),
    visit: &mut impl FnMut(FlatFace<'a>),
) {
    for (triangle, polygon) in (0..).zip(convex_pieces(mesh, face)) {
        let normal = area_vector(&polygon).normalize_or_zero();
        if normal != DVec3::ZERO {
            visit(FlatFace {
                key: FaceKey {
                    object,
                    face: face as u32,
                    triangle,
                },
                polygon,
                normal,
                material,
                id,
            });
        }
    }
}

/// A flat part of a primitive as a polygon.
fn part_polygon(p: &Primitive, part: usize) -> ArrayPolygon {
    let corner = |(u, v)| p.point(part, u, v).position;
    let polygon: ArrayPolygon = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        .into_iter()
        .map(corner)
        .collect();
    if area_vector(&polygon).dot(p.point(part, 0.5, 0.5).normal) < 0.0 {
        return polygon.iter().rev().copied().collect();
    }
    polygon
}

/// A face as one polygon if it is flat and convex, else as its triangles.
fn convex_pieces(placed: &PlacedMesh, face: usize) -> Vec<ArrayPolygon> {
    let corners = placed.face_positions(face);
    if is_flat_and_convex(&corners) {
        return vec![corners.into_iter().collect()];
    }
    let triangle = |t: [u32; 3]| t.iter().map(|&k| corners[k as usize]).collect();
    let triangles = placed.mesh.triangulate(face).into_iter();
    triangles.map(triangle).collect()
}

/// Whether all corners lie in one plane, to 1e-6 of the polygon's size, and turn one way.
fn is_flat_and_convex(polygon: &[DVec3]) -> bool {
    let area = area_vector(polygon);
    let normal = area.normalize_or_zero();
    let size = area.length().sqrt();
    let n = polygon.len();
    n <= ArrayPolygon::INLINE
        && normal != DVec3::ZERO
        && (0..n).all(|k| {
            let (a, b, c) = (polygon[k], polygon[(k + 1) % n], polygon[(k + 2) % n]);
            (b - polygon[0]).dot(normal).abs() <= 1e-6 * size
                && (b - a).cross(c - b).dot(normal) >= 0.0
        })
}
