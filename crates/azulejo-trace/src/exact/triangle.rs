//! The point of a triangle that a ray hits, in double precision.

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

#[cfg(test)]
mod tests {
    use super::*;

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
