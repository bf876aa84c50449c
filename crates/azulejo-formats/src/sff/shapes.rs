//! Converts shapes of records to exact shapes and meshes, before their transforms.

use super::coons;
use super::document::{PatchData, PolygonData, SffCone, TriangleData};
use azulejo_scene::math::{Frame, normal_matrix};
use azulejo_scene::{Attribute, BicubicPatch, MaterialId, Mesh, Primitive, PrimitiveKind};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::HashMap;

/// A box around its centre.
pub(super) fn cuboid(centre: DVec3, half: DVec3, material: MaterialId) -> Primitive {
    let map = DAffine3 {
        matrix3: DMat3::from_diagonal(2.0 * half),
        translation: centre - half,
    };
    Primitive::new(PrimitiveKind::Cuboid, map, material)
}

/// The lateral surface of a cone, or all of it if it is `closed`. The wider end is the base.
pub(super) fn cone(cone: &SffCone, closed: bool, material: MaterialId) -> Primitive {
    let swapped = cone.apex_radius > cone.base_radius;
    let (base, wide, apex, narrow) = if swapped {
        (cone.apex, cone.apex_radius, cone.base, cone.base_radius)
    } else {
        (cone.base, cone.base_radius, cone.apex, cone.apex_radius)
    };
    let axis = apex - base;
    let frame = Frame::from_normal(axis.normalize());
    let map = DAffine3 {
        matrix3: DMat3::from_cols(wide * frame.x, wide * frame.y, axis),
        translation: base,
    };
    let top = narrow / wide;
    let kind = if !closed {
        PrimitiveKind::Tube { top }
    } else if top == 1.0 {
        PrimitiveKind::Cylinder
    } else {
        PrimitiveKind::Cone { top }
    };
    Primitive::new(kind, map, material)
}

/// A cone whose height is below this fraction of its radius is a cap: the original's flat cones are
/// 0.001 high.
const FLAT: f64 = 0.02;

/// The original's height of a disc, which counts as flat for any radius.
const DISC: f64 = 0.00101;

/// How far the ends of a lateral surface and of its caps may be apart, relative to the radius:
/// files have six digits.
const APART: f64 = 1e-5;

/// The single cone or cylinder with this lateral surface and these caps; `None` if the pieces do
/// not form one.
///
/// Caps are flat cones that end in a point, over the ends of the lateral surface.
pub(super) fn closed_cone(pieces: &[SffCone]) -> Option<SffCone> {
    if !(2..=3).contains(&pieces.len()) {
        return None;
    }
    let height = |c: &SffCone| c.base.distance(c.apex);
    let tallest = pieces
        .iter()
        .max_by(|a, b| height(a).total_cmp(&height(b)))?;
    let radius = tallest.base_radius.max(tallest.apex_radius);
    let is_cap = |piece: &SffCone, end: DVec3, end_radius: f64| {
        let (base, wide, apex, narrow) = wide_end_first(piece);
        let axis = tallest.apex - tallest.base;
        base.distance(end) <= APART * radius
            && (wide - end_radius).abs() <= APART * radius
            && narrow <= 1e-3 * wide
            && base.distance(apex) <= (FLAT * wide).max(DISC)
            && (apex - base).cross(axis).length() <= 1e-3 * height(piece) * axis.length()
    };
    let ends = [
        (tallest.base, tallest.base_radius),
        (tallest.apex, tallest.apex_radius),
    ];
    let caps = |&(end, end_radius): &(DVec3, f64)| {
        let caps = pieces.iter().filter(|p| !std::ptr::eq(*p, tallest));
        caps.filter(|p| is_cap(p, end, end_radius)).count()
    };
    let is_point = |&(_, end_radius): &(DVec3, f64)| end_radius <= 1e-5 * radius;
    let closed = ends
        .iter()
        .all(|end| caps(end) == 1 || is_point(end) && caps(end) == 0);
    let used: usize = ends.iter().map(caps).sum();
    (closed && used + 1 == pieces.len()).then_some(*tallest)
}

fn wide_end_first(c: &SffCone) -> (DVec3, f64, DVec3, f64) {
    if c.apex_radius > c.base_radius {
        (c.apex, c.apex_radius, c.base, c.base_radius)
    } else {
        (c.base, c.base_radius, c.apex, c.apex_radius)
    }
}

/// The scale and translation of the data of a record.
#[derive(Clone, Copy)]
pub(super) struct ScaleShift {
    pub origin: DVec3,
    pub scale: DVec3,
}

impl ScaleShift {
    fn point(&self, p: DVec3) -> DVec3 {
        p * self.scale + self.origin
    }
}

/// Bézier patches.
pub(super) fn patches(
    data: &PatchData,
    under: ScaleShift,
    material: MaterialId,
) -> impl Iterator<Item = BicubicPatch> + '_ {
    data.patches.iter().map(move |patch| {
        let points = patch.map(|v| under.point(data.vertices[v as usize]));
        coons::patch(&points, material)
    })
}

/// Polygons as listed in the record.
pub(super) fn polygons(data: &PolygonData, under: ScaleShift, material: MaterialId) -> Mesh {
    Mesh {
        positions: data.vertices.iter().map(|p| under.point(*p)).collect(),
        face_materials: vec![material; data.faces.len()],
        faces: data.faces.clone(),
        ..Mesh::default()
    }
}

/// Transformed triangles that share vertices with equal position, normal and surface. Corners are
/// ordered so that the normals are in front. Also returns the surfaces of the corners, counted from
/// 0, for triangles that have them.
pub(super) fn triangles(
    data: &TriangleData,
    under: ScaleShift,
    map: &DAffine3,
    material: MaterialId,
) -> (Mesh, Vec<[u32; 3]>) {
    let turned = normal_matrix(map.matrix3);
    let placed = |(position, normal): (DVec3, DVec3)| {
        let position = under.point(position);
        if *map == DAffine3::IDENTITY {
            return (position, normal);
        }
        let normal = (turned * normal).try_normalize().unwrap_or(normal);
        (map.transform_point3(position), normal)
    };
    let mut mesh = Mesh::default();
    let mut normals = Vec::new();
    let mut corner_surfaces = Vec::new();
    let mut known = HashMap::new();
    let bits = |v: DVec3| (v + DVec3::ZERO).to_array().map(f64::to_bits);
    for (k, corners) in data.corners.iter().enumerate() {
        let mut points = corners.map(placed);
        let mut surfaces = data.surfaces.get(k).copied();
        let [a, b, c] = points.map(|p| p.0);
        let facing: DVec3 = points.iter().map(|p| p.1).sum();
        if (b - a).cross(c - a).dot(facing) < 0.0 {
            points.swap(1, 2);
            surfaces.iter_mut().for_each(|s| s.swap(1, 2));
        }
        let mut face = [0; 3];
        for (corner, (position, normal)) in points.into_iter().enumerate() {
            let surface = surfaces.map_or(0, |s| s[corner]);
            let key = (bits(position), bits(normal), surface);
            face[corner] = *known.entry(key).or_insert_with(|| {
                mesh.positions.push(position);
                normals.push(normal);
                mesh.positions.len() as u32 - 1
            });
        }
        mesh.push_face(&face, material);
        corner_surfaces.extend(surfaces.map(|s| s.map(|s| s - 1)));
    }
    mesh.normals = Some(Attribute::per_vertex(normals));
    (mesh, corner_surfaces)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(base: f64, base_radius: f64, apex: f64, apex_radius: f64) -> SffCone {
        SffCone {
            base: base * DVec3::X,
            base_radius,
            apex: apex * DVec3::X,
            apex_radius,
        }
    }

    #[test]
    fn either_end_may_come_first() {
        let one = cone(&piece(1.0, 0.5, 3.0, 0.25), false, 0);
        let other = cone(&piece(3.0, 0.25, 1.0, 0.5), false, 0);
        assert_eq!(one, other);
        assert_eq!(one.kind, PrimitiveKind::Tube { top: 0.5 });
        let bounds = one.bounds();
        assert!((bounds.min - DVec3::new(1.0, -0.5, -0.5)).length() < 1e-12);
        assert!((bounds.max - DVec3::new(3.0, 0.5, 0.5)).length() < 1e-12);
    }

    #[test]
    fn a_side_with_its_caps_is_closed() {
        let check = |pieces: &[SffCone], expected: Option<usize>| {
            let cone = closed_cone(pieces);
            assert_eq!(cone, expected.map(|k| pieces[k]), "{pieces:?}");
        };
        let side = piece(-1.0, 0.5, 1.0, 0.5);
        let low = piece(-1.0, 0.5, -1.001, 5e-7);
        let high = piece(1.0, 0.5, 1.001, 5e-7);
        check(&[side, low, high], Some(0));
        check(&[high, side, low], Some(1));
        check(&[side, low], None);
        check(&[side, low, low], None);
        check(&[side, low, piece(1.0, 0.4, 1.001, 5e-7)], None);
        let pointed = piece(-1.0, 0.5, 1.0, 5e-7);
        check(&[pointed, low], Some(0));
        check(&[pointed, low, high], None);
        check(&[side, low, high, high], None);
    }
}
