//! Triangles: packets of four for the kernel, and one in double precision for what it found.

use azulejo_scene::math::Ray;
use glam::DVec3;

/// Triangles in one packet.
pub(crate) const PACKET: usize = 4;

/// Four triangles side by side. Lanes that are not in use hold NaN, which no ray meets.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Packet {
    /// Coordinates, `[3 * corner + axis][lane]`.
    pub corners: [[f32; PACKET]; 9],
    /// Item number of each lane.
    pub items: [u32; PACKET],
}

impl Packet {
    pub(crate) const EMPTY: Packet = Packet {
        corners: [[f32::NAN; PACKET]; 9],
        items: [u32::MAX; PACKET],
    };

    /// Puts a triangle into a lane.
    pub(crate) fn set(&mut self, lane: usize, corners: &[[f32; 3]; 3], item: u32) {
        for (k, coordinate) in corners.iter().flatten().enumerate() {
            self.corners[k][lane] = *coordinate;
        }
        self.items[lane] = item;
    }
}

/// Where a packet's lanes were met: valid in the lanes of the mask that comes with it.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(16))]
pub(crate) struct PacketHits {
    pub t: [f32; PACKET],
    pub u: [f32; PACKET],
    pub v: [f32; PACKET],
}

impl PacketHits {
    /// Puts a meeting into a lane.
    pub(crate) fn set(&mut self, lane: usize, (t, u, v): (f32, f32, f32)) {
        (self.t[lane], self.u[lane], self.v[lane]) = (t, u, v);
    }
}

/// Where the last axis meets a triangle, from its corners in sheared coordinates: `t`, `u`, `v`.
///
/// For triangles with an edge function that is zero in single precision, which may be rounding:
/// products of `f32` are exact in `f64`. A ray exactly on an edge meets both triangles there.
#[cold]
#[inline(never)]
pub(crate) fn meet_exactly(x: [f32; 3], y: [f32; 3], z: [f32; 3]) -> Option<(f32, f32, f32)> {
    let edge =
        |p: usize, q: usize| f64::from(x[p]) * f64::from(y[q]) - f64::from(y[p]) * f64::from(x[q]);
    let (a, b, c) = (edge(2, 1), edge(0, 2), edge(1, 0));
    let inside = (a >= 0.0 && b >= 0.0 && c >= 0.0) || (a <= 0.0 && b <= 0.0 && c <= 0.0);
    let whole = a + b + c;
    if !inside || whole == 0.0 {
        return None;
    }
    let t = (a * f64::from(z[0]) + b * f64::from(z[1]) + c * f64::from(z[2])) / whole;
    Some((t as f32, (b / whole) as f32, (c / whole) as f32))
}

/// Where a ray meets a triangle that the kernel has already said it meets.
pub(crate) struct TrianglePoint {
    pub t: f64,
    pub u: f64,
    pub v: f64,
    pub position: DVec3,
    pub normal: DVec3,
}

/// The point where `ray` meets the triangle, or the triangle's nearest to it: the kernel works
/// with rounded corners and may report a ray that passes by at its rounding's distance.
///
/// `t_guess` is the kernel's answer; it is kept for a ray in the plane of the triangle.
pub(crate) fn meet(corners: [DVec3; 3], ray: &Ray, t_guess: f64) -> TrianglePoint {
    let [a, b, c] = corners;
    let (ab, ac) = (b - a, c - a);
    let area = ab.cross(ac);
    let (height, slope) = (area.dot(a - ray.origin), area.dot(ray.direction));
    let t = height / slope;
    let t = if t.is_finite() { t } else { t_guess };
    let (u, v) = barycentric(ab, ac, area, ray.at(t) - a);
    let position = a + u * ab + v * ac;
    TrianglePoint {
        t,
        u,
        v,
        position,
        normal: area.normalize_or_zero(),
    }
}

/// Weights of the second and third corner for the point `p` from the first, clamped to the
/// triangle.
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
            let p = meet(corners, &Ray::new(from, to - from), 1.0);
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
