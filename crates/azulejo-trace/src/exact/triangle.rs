//! The point of a triangle that a ray hits, in double precision.

use super::line::Line3;
use crate::hit::ResolvedPoint;
use azulejo_scene::math::Ray;
use glam::DVec3;

/// The point where `ray` hits the triangle, or the triangle's nearest point to it: the kernel works
/// with rounded corners and may report a ray that misses by the size of that rounding.
///
/// `t_guess` is the kernel's result, which is kept for a ray in the plane of the triangle.
pub(crate) fn point_on_triangle(corners: [DVec3; 3], ray: &Ray, t_guess: f64) -> ResolvedPoint {
    let [a, b, c] = corners;
    let (ab, ac) = (b - a, c - a);
    let area = ab.cross(ac);
    let (height, slope) = (area.dot(a - ray.origin), area.dot(ray.direction));
    let t = height / slope;
    let t = if t.is_finite() { t } else { t_guess };
    let (u, v) = barycentric(ab, ac, area, ray.at(t) - a);
    let position = a + u * ab + v * ac;
    ResolvedPoint {
        t,
        u,
        v,
        part: 0,
        position,
        normal: area.normalize_or_zero(),
    }
}

/// Weights of the second and third corner for the point at offset `p` from the first, clamped to
/// the triangle.
fn barycentric(ab: DVec3, ac: DVec3, area: DVec3, p: DVec3) -> (f64, f64) {
    let scale = area.length_squared();
    let u = (p.cross(ac).dot(area) / scale).clamp(0.0, 1.0);
    let v = (ab.cross(p).dot(area) / scale).clamp(0.0, 1.0);
    if !(u.is_finite() && v.is_finite()) {
        return (0.0, 0.0);
    }
    let over = (u + v).max(1.0);
    (u / over, v / over)
}

/// Where a line meets a triangle: `t`, and the weights of the second and third corner. Lines through a common
/// edge of two triangles meet at least one of them: both compute the same for it.
pub(crate) fn crossing(corners: [DVec3; 3], line: &Line3) -> Option<(f64, f64, f64)> {
    let [a, b, c] = corners.map(|p| p - line.origin);
    let weights = [b.cross(c), c.cross(a), a.cross(b)].map(|n| n.dot(line.direction));
    let sum: f64 = weights.iter().sum();
    let is_inside = weights.iter().all(|&w| w >= 0.0) || weights.iter().all(|&w| w <= 0.0);
    let area = (b - a).cross(c - a);
    let t = area.dot(a) / area.dot(line.direction);
    (is_inside && sum != 0.0 && t.is_finite()).then(|| (t, weights[1] / sum, weights[2] / sum))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_cross_inside_and_on_edges() {
        let corners = [DVec3::ZERO, 1e5 * DVec3::X, 1e5 * DVec3::Y];
        let down = |x: f64, y: f64| Line3 {
            origin: DVec3::new(x, y, 2.0),
            direction: -DVec3::Z,
        };
        let (t, u, v) = crossing(corners, &down(2e4, 3e4)).unwrap();
        assert!((t - 2.0).abs() < 1e-12 && (u - 0.2).abs() < 1e-12 && (v - 0.3).abs() < 1e-12);
        assert!(crossing(corners, &down(0.0, 0.25)).is_some());
        assert_eq!(crossing(corners, &down(-1e-9, 1.0)), None);
        let level = Line3 {
            origin: DVec3::ZERO,
            direction: DVec3::X,
        };
        assert_eq!(crossing(corners, &level), None);
    }

    #[test]
    fn point_is_on_the_triangle_and_near_the_ray() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let check = |to: DVec3, u: f64, v: f64| {
            let from = DVec3::new(0.3, -0.2, 2.0);
            let p = point_on_triangle(corners, &Ray::new(from, to - from), 1.0);
            assert!((p.t - 1.0).abs() < 1e-15, "{to}");
            assert!((p.u - u).abs() < 1e-15 && (p.v - v).abs() < 1e-15, "{to}");
            assert_eq!(p.normal, DVec3::Z);
        };
        check(DVec3::new(0.25, 0.5, 0.0), 0.25, 0.5);
        check(DVec3::X, 1.0, 0.0);
        check(DVec3::new(-1e-9, 0.5, 0.0), 0.0, 0.5);
        check(DVec3::new(0.5, 0.5 + 2e-16, 0.0), 0.5, 0.5);
    }
}
