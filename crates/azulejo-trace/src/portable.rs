//! The kernel's operations on plain arrays.

use crate::bvh::{Node, WIDTH};
use crate::kernel::Instructions;
use crate::prepared::PreparedRay;
use crate::triangle::{PACKET, Packet, PacketHits, meet_exactly};

/// Plain arrays, for processors without AVX2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

impl Instructions for Portable {
    fn prefetch<T>(self, _value: &T) {}

    #[inline(always)]
    fn put(self, mut mask: u32, children: &[u32; WIDTH], stack: &mut [u64; WIDTH]) {
        let mut count = 0;
        while mask != 0 {
            stack[count % WIDTH] = u64::from(children[mask.trailing_zeros() as usize % WIDTH]);
            mask &= mask - 1;
            count += 1;
        }
    }

    #[inline(always)]
    fn boxes(self, ray: &PreparedRay, node: &Node, t_max: f32, near: &mut [f32; WIDTH]) -> u32 {
        let mut enter = [ray.t_min; WIDTH];
        let mut leave = [t_max; WIDTH];
        for axis in 0..3 {
            let (inverse, at) = (ray.inverse[axis], ray.near_offset[axis]);
            let planes = &node.planes[ray.near_row[axis]];
            for k in 0..WIDTH {
                let t = planes[k] * inverse - at;
                enter[k] = if t > enter[k] { t } else { enter[k] };
            }
            let at = ray.far_offset[axis];
            let planes = &node.planes[ray.far_row(axis)];
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
                let height = packet.corners[3 * c + kz][k] - ray.origin[kz];
                x[c][k] = (packet.corners[3 * c + kx][k] - ray.origin[kx]) - sx * height;
                y[c][k] = (packet.corners[3 * c + ky][k] - ray.origin[ky]) - sy * height;
                z[c][k] = sz * height;
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
            let met = if a == 0.0 || b == 0.0 || c == 0.0 {
                meet_exactly(x.map(|x| x[k]), y.map(|y| y[k]), z.map(|z| z[k]))
            } else {
                let whole = a + b + c;
                let t = (a * z[0][k] + b * z[1][k] + c * z[2][k]) / whole;
                Some((t, b / whole, c / whole))
            };
            if let Some(met) = met {
                hits.set(k, met);
                mask |= u32::from(met.0 >= ray.t_min && met.0 <= t_max) << k;
            }
        }
        mask
    }
}
