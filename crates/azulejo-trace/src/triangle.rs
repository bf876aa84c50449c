//! Triangles: packets of four for the kernel, and one in double precision for what it found.

use crate::placed::ResolvedPoint;
use crate::prepared::PreparedRay;
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

    /// The triangle in a lane.
    pub(crate) fn triangle(&self, lane: usize) -> [[f32; 3]; 3] {
        [0, 3, 6].map(|first| [0, 1, 2].map(|axis| self.corners[first + axis][lane]))
    }

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

/// What single precision could not settle about one triangle: whether it is met, and `t`, `u`, `v`.
///
/// Called if an edge function is zero, which may be rounding, or if the triangle is so thin, as
/// the ray sees it, that `t` would be worth little ([`is_thin`]). `x`, `y` are the sheared
/// corners: they decide, because neighbours share them to the last bit, and their products are
/// exact in `f64`. A ray exactly on an edge meets both triangles there.
#[cold]
#[inline(never)]
pub(crate) fn meet_exactly(
    ray: &PreparedRay,
    corners: [[f32; 3]; 3],
    x: [f32; 3],
    y: [f32; 3],
) -> Option<(f32, f32, f32)> {
    let decisive = weights(x.map(f64::from), y.map(f64::from));
    let [a, b, c] = decisive;
    let inside = (a >= 0.0 && b >= 0.0 && c >= 0.0) || (a <= 0.0 && b <= 0.0 && c <= 0.0);
    if !inside || a + b + c == 0.0 {
        return None;
    }
    let [kx, ky, kz] = ray.axes;
    let direction = ray.direction.map(f64::from);
    let relative = |corner: [f32; 3], k: usize| f64::from(corner[k]) - f64::from(ray.origin[k]);
    let sheared = |k: usize| {
        let slope = direction[k] / direction[kz];
        corners.map(|p| relative(p, k) - slope * relative(p, kz))
    };
    let weights = on_triangle(sheared(kx), sheared(ky)).unwrap_or(decisive);
    let whole: f64 = weights.iter().sum();
    let z = corners.map(|p| relative(p, kz) / direction[kz]);
    let t = (0..3).map(|k| weights[k] * z[k]).sum::<f64>() / whole;
    Some((
        t as f32,
        (weights[1] / whole) as f32,
        (weights[2] / whole) as f32,
    ))
}

/// Weights of the corners for the triangle's point nearest to the axis of the shear, which passes
/// through it or, by rounding, beside it; `None` for a triangle seen exactly from its edge.
fn on_triangle(x: [f64; 3], y: [f64; 3]) -> Option<[f64; 3]> {
    let weights = weights(x, y);
    let whole: f64 = weights.iter().sum();
    if whole == 0.0 || !whole.is_finite() {
        return None;
    }
    let outside = (0..3).min_by(|&i, &j| (weights[i] / whole).total_cmp(&(weights[j] / whole)))?;
    if weights[outside] / whole >= 0.0 {
        return Some(weights);
    }
    let (j, k) = ((outside + 1) % 3, (outside + 2) % 3);
    let (ex, ey) = (x[k] - x[j], y[k] - y[j]);
    let along = -(x[j] * ex + y[j] * ey) / (ex * ex + ey * ey);
    let mut nearest = [0.0; 3];
    nearest[k] = along.clamp(0.0, 1.0);
    nearest[j] = 1.0 - nearest[k];
    Some(nearest)
}

/// Edge functions opposite the three corners, as the axis of the shear sees them.
fn weights(x: [f64; 3], y: [f64; 3]) -> [f64; 3] {
    let edge = |p: usize, q: usize| x[p] * y[q] - y[p] * x[q];
    [edge(2, 1), edge(0, 2), edge(1, 0)]
}

/// Whether rounding moves the point where a ray meets a triangle by more than the rounding of the
/// ray's own origin: `widths` are the largest sheared coordinates, `whole` is the sum of the edge
/// functions, `reach` the size of the coordinates at hand.
#[inline(always)]
pub(crate) fn is_thin(widths: [f32; 3], whole: f32, reach: f32) -> bool {
    widths[0] * widths[1] * widths[2] > THIN * reach * whole.abs()
}

/// The bound of [`is_thin`]: with it an error of `t` stays below half the step of
/// [`Tracer::leaving`](crate::Tracer::leaving).
pub(crate) const THIN: f32 = 4.0;

/// The point where `ray` meets the triangle, or the triangle's nearest to it: the kernel works
/// with rounded corners and may report a ray that passes by at its rounding's distance.
///
/// `t_guess` is the kernel's answer; it is kept for a ray in the plane of the triangle.
pub(crate) fn meet(corners: [DVec3; 3], ray: &Ray, t_guess: f64) -> ResolvedPoint {
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
