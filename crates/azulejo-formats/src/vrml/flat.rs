//! X3D's 2D geometry, in the plane z = 0.

use super::shape::{SurfaceFields, ValuePool};
use super::tree::VrmlNode;
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Sides of a circle: the chord error is below a thousandth of the radius.
const SIDES: usize = 72;

/// The polygons of a node; `None` if it is of another type, or has none.
pub(super) fn surface(node: &VrmlNode) -> Option<SurfaceFields<'_>> {
    let (points, corners) = match &*node.kind {
        "Rectangle2D" => rectangle(node.array("size", [2.0, 2.0]).into()),
        "Disk2D" => disk(node),
        "ArcClose2D" => arc(node),
        "TriangleSet2D" => triangles(node),
        _ => return None,
    };
    let positions = points.iter().map(|p| p.extend(0.0)).collect();
    let mut surface = SurfaceFields::new(node, positions, Cow::Owned(corners));
    // 2D geometry is two-sided by default: ISO/IEC 19775-1, 14.
    surface.solid = node.flag("solid", false);
    surface.uvs = Some(ValuePool::per_vertex(mapping(&points)));
    Some(surface)
}

/// Points and corners.
type FlatPolygons = (Vec<DVec2>, Vec<i32>);

fn rectangle(size: DVec2) -> FlatPolygons {
    let corner = |x, y| 0.5 * size * DVec2::new(x, y);
    let points = vec![
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    (points, vec![0, 1, 2, 3])
}

fn ring(radius: f64) -> impl Iterator<Item = DVec2> {
    (0..SIDES).map(move |k| radius * DVec2::from_angle(TAU * k as f64 / SIDES as f64))
}

/// A disc, or a ring if it has an inner radius.
fn disk(node: &VrmlNode) -> FlatPolygons {
    let inner = node.number("innerRadius", 0.0);
    let outer = node.number("outerRadius", 1.0);
    let sides = SIDES as i32;
    if inner <= 0.0 {
        return (ring(outer).collect(), (0..sides).collect());
    }
    let points = ring(inner).chain(ring(outer)).collect();
    let side = |k: i32| {
        let next = (k + 1) % sides;
        [k, sides + k, sides + next, next, -1]
    };
    (points, (0..sides).flat_map(side).collect())
}

/// A circular sector or segment.
fn arc(node: &VrmlNode) -> FlatPolygons {
    let radius = node.number("radius", 1.0);
    let start = node.number("startAngle", 0.0);
    let mut angle = node.number("endAngle", FRAC_PI_2) - start;
    if angle <= 0.0 || angle > TAU {
        angle = angle.rem_euclid(TAU);
    }
    if angle == 0.0 {
        return (ring(radius).collect(), (0..SIDES as i32).collect());
    }
    let steps = ((SIDES as f64 * angle / TAU).ceil() as usize).max(2);
    let on_arc = |k| radius * DVec2::from_angle(start + angle * k as f64 / steps as f64);
    let mut points: Vec<DVec2> = (0..=steps).map(on_arc).collect();
    let is_chord = node
        .strings("closureType")
        .first()
        .is_some_and(|t| t == "CHORD");
    if !is_chord {
        points.push(DVec2::ZERO);
    }
    let corners = (0..points.len() as i32).collect();
    (points, corners)
}

fn triangles(node: &VrmlNode) -> FlatPolygons {
    let mut points = node.points2("vertices");
    points.truncate(points.len() / 3 * 3);
    for point in points.iter_mut().filter(|p| !p.is_finite()) {
        *point = DVec2::ZERO;
    }
    let faces = (0..points.len() as i32 / 3).flat_map(|t| [3 * t, 3 * t + 1, 3 * t + 2, -1]);
    let corners = faces.collect();
    (points, corners)
}

/// Texture coordinates that map the texture to the bounding box of the points.
fn mapping(points: &[DVec2]) -> Vec<DVec2> {
    let solid = points.iter().map(|p| p.extend(0.0));
    let bounds = azulejo_scene::math::Aabb::around(solid);
    let size = bounds.size().max(DVec3::splat(f64::MIN_POSITIVE));
    let uv = |p: &DVec2| ((p.extend(0.0) - bounds.min) / size).truncate();
    points.iter().map(uv).collect()
}
