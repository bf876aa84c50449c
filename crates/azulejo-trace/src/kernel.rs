//! Walks the tree: the same code for every instruction set.
//!
//! Boxes are tested with a margin for all rounding of the ray and of the test itself (in the
//! spirit of Ize, *Robust BVH Ray Traversal*, JCGT 2(2), 2013, but paid once per ray), triangles
//! with the watertight test of Woop, Benthin and Wald, JCGT 2(1), 2013. Products in the edge
//! functions are rounded one by one, never fused, so two triangles that share an edge always
//! agree on its sign, and every instruction set finds the same hits.

use crate::build::DEEPEST;
use crate::bvh::{Bvh, Child, Node, WIDTH};
use crate::ray::{KernelHit, KernelRay};
use crate::triangle::{PACKET, Packet, PacketHits};

/// Room for all siblings along the longest path.
const STACK: usize = (WIDTH - 1) * DEEPEST + WIDTH;

/// Children that wait: distance of the box (as bits, which order like the numbers they are of,
/// none being negative) above the packed child.
pub(crate) type Stack = [u64; STACK];

/// A stack to be reused for many rays.
pub(crate) const EMPTY_STACK: Stack = [0; STACK];

/// Directions shorter than this along their longest axis hit nothing.
const SHORTEST_DIRECTION: f32 = 1e-25;

/// Components of the direction are kept this far from zero, relative to the largest, so that
/// no product with the inverse is 0 · ∞; over the scene's width a ray moves aside by less than
/// the rounding of its origin.
const SMALLEST_COMPONENT: f32 = 1e-10;

/// What one ray needs again and again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedRay {
    pub origin: [f32; 3],
    /// 1 / direction.
    pub inverse: [f32; 3],
    /// `origin · inverse`, plus the margin: for the planes where the ray enters.
    pub near_offset: [f32; 3],
    /// `origin · inverse`, less the margin: for the planes where it leaves.
    pub far_offset: [f32; 3],
    /// Row of [`Node::planes`] where the ray enters, per axis.
    pub near_row: [usize; 3],
    /// The axis of the longest component last.
    pub axes: [usize; 3],
    /// Shear that turns the direction into the last axis, and the scale along it.
    pub shear: [f32; 3],
    pub t_min: f32,
}

impl PreparedRay {
    /// `None` for a ray that cannot hit anything. Coordinates of the scene lie within −1..=1.
    #[inline(always)]
    pub(crate) fn new(ray: &KernelRay) -> Option<PreparedRay> {
        let (o, d) = (ray.origin, ray.direction);
        let size = d.map(f32::abs);
        let last = if size[0] > size[1] {
            if size[0] > size[2] { 0 } else { 2 }
        } else if size[1] > size[2] {
            1
        } else {
            2
        };
        // A comparison with NaN is false, so this also turns those away.
        let sum = o[0].abs() + o[1].abs() + o[2].abs() + size[0] + size[1] + size[2];
        let usable = sum < f32::INFINITY && size[last] >= SHORTEST_DIRECTION;
        if !(usable && ray.t_min < ray.t_max) {
            return None;
        }
        let axes = [(last + 1) % 3, (last + 2) % 3, last];
        let floor = size[last] * SMALLEST_COMPONENT;
        let inverse = [0, 1, 2].map(|k| 1.0 / size[k].max(floor).copysign(d[k]));
        let reach = o[0].abs().max(o[1].abs()).max(o[2].abs()) + 1.0;
        let margin = reach * (4.0 * f32::EPSILON);
        Some(PreparedRay {
            origin: o,
            inverse,
            near_offset: [0, 1, 2].map(|k| o[k] * inverse[k] + margin * inverse[k].abs()),
            far_offset: [0, 1, 2].map(|k| o[k] * inverse[k] - margin * inverse[k].abs()),
            near_row: [0, 1, 2].map(|k| 2 * k + usize::from(d[k].is_sign_negative())),
            axes,
            shear: [d[axes[0]] / d[last], d[axes[1]] / d[last], 1.0 / d[last]],
            t_min: ray.t_min.max(0.0),
        })
    }

    /// Row of [`Node::planes`] where the ray leaves.
    #[inline(always)]
    pub(crate) fn far_row(&self, axis: usize) -> usize {
        self.near_row[axis] ^ 1
    }
}

/// The few operations that differ between instruction sets.
///
/// An implementing type is the proof that its instructions are there.
pub(crate) trait Instructions: Copy {
    /// A ray spread over lanes.
    type Ray: Copy;

    fn spread(self, ray: &PreparedRay) -> Self::Ray;

    /// Which boxes the ray meets before `t_max`, as a mask; `near` gets where it enters them.
    fn boxes(self, ray: &Self::Ray, node: &Node, t_max: f32, near: &mut [f32; WIDTH]) -> u32;

    /// Which triangles the ray meets at `t <= t_max`, as a mask, and where.
    fn triangles(self, ray: &Self::Ray, packet: &Packet, t_max: f32, hits: &mut PacketHits) -> u32;
}

/// What is in leaves besides triangles.
pub(crate) trait Others {
    /// Improves `hit` if `shape` is met nearer.
    fn closest(&self, shape: u32, ray: &KernelRay, hit: &mut KernelHit);

    /// Whether `shape` is met at `t <= t_max`.
    fn any(&self, shape: u32, ray: &KernelRay, t_max: f32) -> bool;
}

/// Whether a meeting at `t` with `item` comes before what is already known.
#[inline(always)]
pub(crate) fn is_better(t: f32, item: u32, hit: &KernelHit) -> bool {
    t < hit.t || (t == hit.t && item < hit.item)
}

/// Nearest meeting, or `hit` unchanged; `hit.t` is the largest parameter that counts.
#[inline(always)]
pub(crate) fn closest<I: Instructions>(
    isa: I,
    bvh: &Bvh,
    others: &impl Others,
    ray: &KernelRay,
    stack: &mut Stack,
    hit: &mut KernelHit,
) {
    let (Some(prepared), false) = (PreparedRay::new(ray), bvh.nodes.is_empty()) else {
        return;
    };
    let spread = isa.spread(&prepared);
    let mut near = [0.0; WIDTH];
    let mut hits = PacketHits::default();
    let mut waiting = 0;
    let mut current = 0;
    loop {
        if current & Child::LEAF == 0 {
            let node = &bvh.nodes[current as usize];
            let mask = isa.boxes(&spread, node, hit.t, &mut near);
            if mask != 0 {
                current = push_sorted(mask, &near, node, stack, &mut waiting);
                continue;
            }
        } else if current & Child::OTHER == 0 {
            for packet in &bvh.packets[Child::range(current)] {
                let mut mask = isa.triangles(&spread, packet, hit.t, &mut hits);
                while mask != 0 {
                    let lane = mask.trailing_zeros() as usize % PACKET;
                    mask &= mask - 1;
                    if is_better(hits.t[lane], packet.items[lane], hit) {
                        *hit = KernelHit {
                            t: hits.t[lane],
                            item: packet.items[lane],
                            u: hits.u[lane],
                            v: hits.v[lane],
                        };
                    }
                }
            }
        } else {
            for &shape in &bvh.others[Child::range(current)] {
                others.closest(shape, ray, hit);
            }
        }
        loop {
            if waiting == 0 {
                return;
            }
            waiting -= 1;
            let entry = stack[waiting];
            if f32::from_bits((entry >> 32) as u32) <= hit.t {
                current = entry as u32;
                break;
            }
        }
    }
}

/// Puts the children of the mask on the stack, the nearest on top; returns the nearest.
#[inline(always)]
fn push_sorted(
    mut mask: u32,
    near: &[f32; WIDTH],
    node: &Node,
    stack: &mut Stack,
    waiting: &mut usize,
) -> u32 {
    let entry = |mask: u32| {
        let k = mask.trailing_zeros() as usize % WIDTH;
        (u64::from(near[k].to_bits()) << 32) | u64::from(node.children[k])
    };
    let first = entry(mask);
    mask &= mask - 1;
    if mask == 0 {
        return first as u32;
    }
    let second = entry(mask);
    mask &= mask - 1;
    let (mut top, below) = (first.min(second), first.max(second));
    let base = *waiting;
    stack[base] = below;
    let mut count = base + 1;
    while mask != 0 {
        let mut next = entry(mask);
        mask &= mask - 1;
        (top, next) = (top.min(next), top.max(next));
        // Insertion from the top: few entries, mostly in order.
        let mut place = count;
        while place > base && stack[place - 1] < next {
            stack[place] = stack[place - 1];
            place -= 1;
        }
        stack[place] = next;
        count += 1;
    }
    *waiting = count;
    top as u32
}

/// Whether anything is met at `t <= t_max`.
#[inline(always)]
pub(crate) fn any<I: Instructions>(
    isa: I,
    bvh: &Bvh,
    others: &impl Others,
    ray: &KernelRay,
    t_max: f32,
    stack: &mut Stack,
) -> bool {
    let (Some(prepared), false) = (PreparedRay::new(ray), bvh.nodes.is_empty()) else {
        return false;
    };
    let spread = isa.spread(&prepared);
    let mut near = [0.0; WIDTH];
    let mut hits = PacketHits::default();
    let mut waiting = 0;
    let mut current = 0;
    loop {
        if current & Child::LEAF == 0 {
            let node = &bvh.nodes[current as usize];
            let mut mask = isa.boxes(&spread, node, t_max, &mut near);
            if mask != 0 {
                loop {
                    let child = node.children[mask.trailing_zeros() as usize % WIDTH];
                    mask &= mask - 1;
                    if mask == 0 {
                        current = child;
                        break;
                    }
                    stack[waiting] = u64::from(child);
                    waiting += 1;
                }
                continue;
            }
        } else if current & Child::OTHER == 0 {
            for packet in &bvh.packets[Child::range(current)] {
                if isa.triangles(&spread, packet, t_max, &mut hits) != 0 {
                    return true;
                }
            }
        } else if bvh.others[Child::range(current)]
            .iter()
            .any(|&shape| others.any(shape, ray, t_max))
        {
            return true;
        }
        if waiting == 0 {
            return false;
        }
        waiting -= 1;
        current = stack[waiting] as u32;
    }
}

/// Plain arrays, for processors without AVX2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

impl Instructions for Portable {
    type Ray = PreparedRay;

    fn spread(self, ray: &PreparedRay) -> PreparedRay {
        *ray
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
            let whole = a + b + c;
            if !inside || whole == 0.0 {
                continue;
            }
            let t = (a * z[0][k] + b * z[1][k] + c * z[2][k]) / whole;
            (hits.t[k], hits.u[k], hits.v[k]) = (t, b / whole, c / whole);
            mask |= u32::from(t >= ray.t_min && t <= t_max) << k;
        }
        mask
    }
}
