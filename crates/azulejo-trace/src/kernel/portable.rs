//! The kernel's operations on plain arrays.

use super::bvh::{BvhNode, WIDTH};
use super::prepared_ray::PreparedRay;
use super::simd::Stack;
use super::traversal::Instructions;
use super::triangle::{PACKET, Packet, PacketHits, intersect_exactly, is_thin};

/// Plain arrays, for processors without AVX2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

impl Instructions for Portable {
    fn prefetch<T>(self, _value: &T) {}

    #[inline(always)]
    fn push(self, mut mask: u32, children: &[u32; WIDTH], stack: &mut Stack) {
        while mask != 0 {
            stack.push(u64::from(children[mask.trailing_zeros() as usize % WIDTH]));
            mask &= mask - 1;
        }
    }

    #[inline(always)]
    fn boxes(self, ray: &PreparedRay, node: &BvhNode, t_max: f32, near: &mut [f32; WIDTH]) -> u32 {
        let mut enter = [ray.t_min; WIDTH];
        let mut leave = [t_max; WIDTH];
        for axis in 0..3 {
            let (inverse, at) = (ray.inverse[axis], ray.near_offset[axis]);
            let planes = &node.planes[axis][ray.near_side[axis]];
            for k in 0..WIDTH {
                let t = planes[k] * inverse - at;
                enter[k] = if t > enter[k] { t } else { enter[k] };
            }
            let at = ray.far_offset[axis];
            let planes = &node.planes[axis][ray.near_side[axis] ^ 1];
            for k in 0..WIDTH {
                let t = planes[k] * inverse - at;
                leave[k] = if t < leave[k] { t } else { leave[k] };
            }
        }
        *near = enter;
        (0..WIDTH).fold(0, |mask, k| mask | (u32::from(enter[k] <= leave[k]) << k))
    }

    #[inline(always)]
    fn triangles(
        self,
        ray: &PreparedRay,
        packet: &Packet,
        t_max: f32,
        hits: &mut PacketHits,
    ) -> u32 {
        let [kx, ky, kz] = ray.axes;
        let [sx, sy, sz] = ray.shear;
        let (mut x, mut y, mut z) = ([[0.0; 4]; 3], [[0.0; 4]; 3], [[0.0; 4]; 3]);
        for c in 0..3 {
            for k in 0..PACKET {
                z[c][k] = packet.corners[c][kz][k] - ray.origin[2];
                x[c][k] = (packet.corners[c][kx][k] - ray.origin[0]) - sx * z[c][k];
                y[c][k] = (packet.corners[c][ky][k] - ray.origin[1]) - sy * z[c][k];
            }
        }
        let mut mask = 0;
        for k in 0..PACKET {
            let a = x[2][k] * y[1][k] - y[2][k] * x[1][k];
            let b = x[0][k] * y[2][k] - y[0][k] * x[2][k];
            let c = x[1][k] * y[0][k] - y[1][k] * x[0][k];
            let inside = (a >= 0.0 && b >= 0.0 && c >= 0.0) || (a <= 0.0 && b <= 0.0 && c <= 0.0);
            if !inside {
                continue;
            }
            let whole = a + b + c;
            let widths = [x, y, z].map(|c| c[0][k].abs().max(c[1][k].abs()).max(c[2][k].abs()));
            let on_edge = a == 0.0 || b == 0.0 || c == 0.0;
            let met = if on_edge || is_thin(widths, whole, ray.reach) {
                let lane = |c: [[f32; PACKET]; 3]| c.map(|c| c[k]);
                intersect_exactly(ray, packet.triangle(k), lane(x), lane(y))
            } else {
                let sum = a * (sz * z[0][k]) + b * (sz * z[1][k]) + c * (sz * z[2][k]);
                Some((sum / whole, b / whole, c / whole))
            };
            if let Some(met) = met {
                hits.set(k, met);
                mask |= u32::from(met.0 >= ray.t_min && met.0 <= t_max) << k;
            }
        }
        mask
    }
}
