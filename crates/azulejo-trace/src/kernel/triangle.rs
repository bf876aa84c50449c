//! Triangles in packets of four, and the test in double precision for cases that single precision
//! cannot decide.

use super::prepared_ray::PreparedRay;

/// Triangles in one packet.
pub(crate) const PACKET: usize = 4;

/// Four triangles in SIMD layout. Unused lanes hold NaN, which no ray hits.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Packet {
    /// Coordinates, `[corner][axis][lane]`.
    pub corners: [[[f32; PACKET]; 3]; 3],
    /// Item number of each lane.
    pub items: [u32; PACKET],
}

impl Packet {
    pub(crate) const EMPTY: Packet = Packet {
        corners: [[[f32::NAN; PACKET]; 3]; 3],
        items: [u32::MAX; PACKET],
    };

    /// The triangle in a lane.
    pub(crate) fn triangle(&self, lane: usize) -> [[f32; 3]; 3] {
        self.corners.map(|corner| corner.map(|row| row[lane]))
    }

    /// Stores a triangle in a lane.
    pub(crate) fn set(&mut self, lane: usize, corners: &[[f32; 3]; 3], item: u32) {
        let rows = self.corners.as_flattened_mut();
        for (row, coordinate) in rows.iter_mut().zip(corners.as_flattened()) {
            row[lane] = *coordinate;
        }
        self.items[lane] = item;
    }
}

/// The hits of a packet's lanes, valid in the lanes of the accompanying mask.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(16))]
pub(crate) struct PacketHits {
    pub t: [f32; PACKET],
    pub u: [f32; PACKET],
    pub v: [f32; PACKET],
}

impl PacketHits {
    /// Stores a hit in a lane.
    pub(crate) fn set(&mut self, lane: usize, (t, u, v): (f32, f32, f32)) {
        (self.t[lane], self.u[lane], self.v[lane]) = (t, u, v);
    }
}

/// Tests a triangle in double precision: whether it is hit, and at which `t`, `u`, `v`.
///
/// Called if an edge function is zero, which may be rounding, or if the triangle is so thin in
/// projection along the ray that `t` would be inaccurate ([`is_thin`]). `x`, `y` are the sheared
/// corners: they decide, because neighbours share them to the last bit, and their products are
/// exact in `f64`. A ray exactly on an edge hits both triangles there.
#[cold]
#[inline(never)]
pub(crate) fn intersect_exactly(
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
    let direction = ray.direction.map(f64::from);
    let relative =
        |corner: [f32; 3], k: usize| f64::from(corner[ray.axes[k]]) - f64::from(ray.origin[k]);
    let sheared = |k: usize| {
        let slope = direction[k] / direction[2];
        corners.map(|p| relative(p, k) - slope * relative(p, 2))
    };
    let weights = on_triangle(sheared(0), sheared(1)).unwrap_or(decisive);
    let whole: f64 = weights.iter().sum();
    let z = corners.map(|p| relative(p, 2) / direction[2]);
    let t = (0..3).map(|k| weights[k] * z[k]).sum::<f64>() / whole;
    Some((
        t as f32,
        (weights[1] / whole) as f32,
        (weights[2] / whole) as f32,
    ))
}

/// Weights of the corners for the triangle's point nearest to the axis of the shear, which passes
/// through it or, by rounding, beside it; `None` for a triangle seen exactly edge-on.
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

/// Edge functions opposite the three corners, at the axis of the shear.
fn weights(x: [f64; 3], y: [f64; 3]) -> [f64; 3] {
    let edge = |p: usize, q: usize| x[p] * y[q] - y[p] * x[q];
    [edge(2, 1), edge(0, 2), edge(1, 0)]
}

/// Whether rounding moves the point where a ray hits a triangle by more than the rounding of the
/// ray's own origin: `widths` are the largest sheared coordinates, `whole` is the sum of the edge
/// functions, `reach` the magnitude of the coordinates.
#[inline(always)]
pub(crate) fn is_thin(widths: [f32; 3], whole: f32, reach: f32) -> bool {
    widths[0] * widths[1] * widths[2] > THIN * reach * whole.abs()
}

/// The bound of [`is_thin`]: with it an error of `t` stays below half the step of
/// [`Tracer::leaving`](crate::Tracer::leaving).
pub(crate) const THIN: f32 = 4.0;
