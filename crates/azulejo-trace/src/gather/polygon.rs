//! Sampling a polygonal lamp from a point, in proportion to what it sends there.

use super::GatherPoint;
use crate::lambert::is_in_front;
use crate::lights::sample_polygon;
use crate::sampling::cosine_about;
use azulejo_scene::math::{Frame, area_vector};
use glam::DVec3;
use std::f64::consts::PI;

/// A flat lamp as a point sees it: what samples of it need.
pub(super) struct LampShape<'p> {
    /// Counter-clockwise as seen from the point.
    pub polygon: &'p [DVec3],
    /// Unit, towards the point.
    pub normal: DVec3,
    pub area: f64,
    /// The mean of the corners, and the farthest of them from there.
    pub centre: DVec3,
    pub radius: f64,
}

impl<'p> LampShape<'p> {
    pub fn new(polygon: &'p [DVec3]) -> LampShape<'p> {
        let across = area_vector(polygon);
        let centre = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
        let distances = polygon.iter().map(|corner| corner.distance(centre));
        LampShape {
            polygon,
            normal: across.normalize_or_zero(),
            area: across.length(),
            centre,
            radius: distances.fold(0.0, f64::max),
        }
    }

    /// Whether a point is nearer than the lamp is wide.
    fn is_near(&self, p: DVec3) -> bool {
        p.distance_squared(self.centre) < 4.0 * self.radius * self.radius
    }
}

/// A point of a lamp and its weight, kernel over density; `None` where `u` misses the lamp.
///
/// The density is even over the lamp. Near a lamp, where the kernel has a peak, half of the
/// samples follow the cosine's directions instead, which bounds the weight (Veach and Guibas
/// 1995, balance heuristic for one sample).
pub(super) fn sample_lamp(
    point: &GatherPoint,
    lamp: &LampShape,
    u: (f64, f64),
) -> Option<(DVec3, f64)> {
    if !lamp.is_near(point.position) {
        let y = sample_polygon(lamp.polygon, u);
        return Some((y, kernel(point, y, lamp.normal) * lamp.area));
    }
    let y = if u.0 < 0.5 {
        sample_polygon(lamp.polygon, (2.0 * u.0, u.1))
    } else {
        let direction = cosine_about(&Frame::from_normal(point.normal), 2.0 * u.0 - 1.0, u.1);
        intersection(point.position, direction, lamp.polygon, lamp.normal)?
    };
    let kernel = kernel(point, y, lamp.normal);
    Some((y, kernel / (0.5 / lamp.area + 0.5 * kernel / PI)))
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

/// cos θ cos θ′/r² between a point and a point on a surface of unit `normal`; zero where either turns its back.
pub(super) fn kernel(point: &GatherPoint, y: DVec3, normal: DVec3) -> f64 {
    let d = y - point.position;
    let r2 = d.length_squared();
    let (cos_p, cos_y) = (d.dot(point.normal), -d.dot(normal));
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
