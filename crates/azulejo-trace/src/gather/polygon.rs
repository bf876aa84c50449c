//! Sampling a polygonal lamp from a point, in proportion to what it sends there.

use super::GatherPoint;
use crate::lambert::is_in_front;
use crate::lights::sample_polygon;
use crate::sampling::cosine_about;
use azulejo_scene::math::{Frame, area_vector};
use glam::DVec3;
use std::f64::consts::PI;

/// A point of a lamp and its weight, kernel over density; `None` where `u` misses the lamp.
///
/// The density is even over the lamp. Near a lamp, where the kernel has a peak, half of the
/// samples follow the cosine's directions instead, which bounds the weight (Veach and Guibas
/// 1995, balance heuristic for one sample).
pub(super) fn sample_lamp(
    point: &GatherPoint,
    polygon: &[DVec3],
    u: (f64, f64),
) -> Option<(DVec3, f64)> {
    let area = area_vector(polygon);
    let even = 1.0 / area.length();
    if !is_near(point.position, polygon) {
        let y = sample_polygon(polygon, u);
        return Some((y, kernel(point, y, area) / even));
    }
    let y = if u.0 < 0.5 {
        sample_polygon(polygon, (2.0 * u.0, u.1))
    } else {
        let direction = cosine_about(&Frame::from_normal(point.normal), 2.0 * u.0 - 1.0, u.1);
        intersection(point.position, direction, polygon, area)?
    };
    let kernel = kernel(point, y, area);
    Some((y, kernel / (0.5 * even + 0.5 * kernel / PI)))
}

/// Whether a point is nearer to a polygon than the polygon is wide.
fn is_near(p: DVec3, polygon: &[DVec3]) -> bool {
    let centre = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
    let radius2 = polygon
        .iter()
        .map(|c| c.distance_squared(centre))
        .fold(0.0, f64::max);
    p.distance_squared(centre) < 4.0 * radius2
}

/// The intersection of a ray with a convex polygon of a normal of any length.
fn intersection(from: DVec3, direction: DVec3, polygon: &[DVec3], normal: DVec3) -> Option<DVec3> {
    let t = (polygon[0] - from).dot(normal) / direction.dot(normal);
    let at = from + t * direction;
    (t > 0.0 && is_inside(at, polygon, normal)).then_some(at)
}

/// Whether a point of a convex polygon's plane lies in it.
fn is_inside(at: DVec3, polygon: &[DVec3], normal: DVec3) -> bool {
    (0..polygon.len()).all(|k| {
        let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        (q - p).cross(at - p).dot(normal) >= 0.0
    })
}

/// cos θ cos θ′/r² between a point and a point on a surface of normal `area`; zero where either
/// turns its back.
pub(super) fn kernel(point: &GatherPoint, y: DVec3, area: DVec3) -> f64 {
    let d = y - point.position;
    let r2 = d.length_squared();
    let (cos_p, cos_y) = (d.dot(point.normal), -d.dot(area.normalize_or_zero()));
    if cos_p > 0.0 && cos_y > 0.0 && r2 > 0.0 {
        cos_p * cos_y / (r2 * r2)
    } else {
        0.0
    }
}

/// Whether a cheap test proves that `point` sees nothing of `image` through `window`: all of the
/// image, or all of the window, is below the horizon, or the image shows its back or is beyond
/// one edge.
pub(super) fn is_hidden(point: &GatherPoint, image: &[DVec3], window: &[DVec3]) -> bool {
    let p = point.position;
    let below = |polygon: &[DVec3]| polygon.iter().all(|&c| (c - p).dot(point.normal) <= 0.0);
    if !is_in_front(p, image) || below(image) || below(window) {
        return true;
    }
    let facing = (p - window[0]).dot(area_vector(window)).signum();
    (0..window.len()).any(|k| {
        let (a, b) = (window[k], window[(k + 1) % window.len()]);
        let inward = (b - p).cross(a - p) * facing;
        image.iter().all(|&c| (c - p).dot(inward) <= 0.0)
    })
}

/// Whether the segment between two points crosses a convex polygon.
pub(super) fn is_through(from: DVec3, to: DVec3, polygon: &[DVec3]) -> bool {
    let normal = area_vector(polygon);
    let (a, b) = (
        (from - polygon[0]).dot(normal),
        (to - polygon[0]).dot(normal),
    );
    if a * b >= 0.0 {
        return false;
    }
    is_inside(from + (to - from) * (a / (a - b)), polygon, normal)
}
