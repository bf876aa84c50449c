//! Traverses the tree: the same code for every instruction set.
//!
//! Boxes are tested with a margin for all rounding of the ray and of the test itself (similar to
//! Ize, *Robust BVH Ray Traversal*, JCGT 2(2), 2013, but once per ray), triangles with the
//! watertight test of Woop, Benthin and Wald, JCGT 2(1), 2013. Products in the edge functions are
//! rounded separately, never fused, so two triangles that share an edge always agree on its sign,
//! and every instruction set finds the same hits.
//!
//! A tree of some megabytes does not fit into the caches, and a ray spends most of its time waiting
//! for nodes. Therefore a batch keeps several rays in flight ([`LANES`]): each prefetches its next
//! node and yields to the others.

use super::build::DEEPEST;
use super::bvh::{Bvh, BvhNode, Child, WIDTH};
use super::prepared_ray::PreparedRay;
use super::ray::{KernelHit, KernelRay};
use super::triangle::{PACKET, Packet, PacketHits};
use glam::Vec3;

/// Room for all siblings along the longest path, and for one more node.
const STACK: usize = (WIDTH - 1) * DEEPEST + 2 * WIDTH;

/// Nodes on a path of a shallow tree, as the meshes of most instances have, and the room that it takes: to set up the
/// whole of [`STACK`] for the one ray that meets an instance costs more than to trace it.
const SHALLOW: usize = 8;
const SHALLOW_STACK: usize = (WIDTH - 1) * SHALLOW + 2 * WIDTH;

/// Rays that one thread has in flight. While one waits for its next node from memory the others
/// continue: in trees larger than the caches this nearly doubles the rate.
const LANES: usize = 8;

/// Fewer rays than this do not justify setting up all lanes.
const FEW_RAYS: usize = 4 * LANES;

/// The few operations that differ between instruction sets.
///
/// A value of an implementing type proves that its instructions are available.
pub(crate) trait Instructions: Copy {
    /// The boxes that the ray hits before `t_max`, as a mask; `near` receives the parameters of
    /// entry.
    fn boxes(self, ray: &PreparedRay, node: &BvhNode, t_max: f32, near: &mut [f32; WIDTH]) -> u32;

    /// Pushes the children of a mask; eight entries may be overwritten.
    fn put(self, mask: u32, children: &[u32; WIDTH], stack: &mut [u64; WIDTH]);

    /// The triangles that the ray hits at `t <= t_max`, as a mask, and their hits.
    fn triangles(
        self,
        ray: &PreparedRay,
        packet: &Packet,
        t_max: f32,
        hits: &mut PacketHits,
    ) -> u32;

    /// Prefetches a value that will soon be read.
    fn prefetch<T>(self, value: &T);
}

/// A child on the stack: the distance of its box (as bits, which are ordered like the numbers since
/// none is negative) above the packed child.
#[inline(always)]
fn entry(near: f32, child: u32) -> u64 {
    (u64::from(near.to_bits()) << 32) | u64::from(child)
}

/// Pushes the children of a mask, which is not 0, farthest first, except for the nearest; returns
/// that one and the number of those pushed.
#[inline(always)]
pub(crate) fn put_sorted(
    mut mask: u32,
    near: &[f32; WIDTH],
    children: &[u32; WIDTH],
    stack: &mut [u64; WIDTH],
) -> (u32, usize) {
    let mut take = || {
        let k = mask.trailing_zeros() as usize % WIDTH;
        mask &= mask - 1;
        (entry(near[k], children[k]), mask != 0)
    };
    let (mut nearest, mut more) = take();
    let mut count = 0;
    while more {
        let mut next;
        (next, more) = take();
        (nearest, next) = (nearest.min(next), nearest.max(next));
        // Insertion from the top: few entries, mostly in order.
        let mut slot = count;
        while slot > 0 && stack[slot - 1] < next {
            stack[slot] = stack[slot - 1];
            slot -= 1;
        }
        stack[slot] = next;
        count += 1;
    }
    (nearest as u32, count)
}

/// The shapes in leaves that are not triangles.
pub(crate) trait OtherShapes {
    /// Replaces `hit` if the ray hits `shape` at a smaller distance.
    fn closest(&self, shape: u32, ray: &KernelRay, hit: &mut KernelHit);

    /// Whether the ray hits `shape` at `t <= t_max`.
    fn any(&self, shape: u32, ray: &KernelRay, t_max: f32) -> bool;
}

/// The geometry that rays are traced against: the tree, and the shapes to which its leaves refer.
pub(crate) struct KernelScene<'a, O: ?Sized> {
    pub bvh: &'a Bvh,
    pub others: &'a O,
}

/// Calls `done` with the index and the nearest hit of each ray, in any order; with `ANY`, any hit
/// suffices.
#[inline(always)]
pub(crate) fn trace<I: Instructions, O: OtherShapes + ?Sized, const ANY: bool>(
    isa: I,
    scene: &KernelScene<O>,
    rays: &[KernelRay],
    done: impl FnMut(usize, &KernelHit),
) {
    if rays.len() < FEW_RAYS || are_coherent(rays) {
        if scene.bvh.depth <= SHALLOW {
            trace_lanes::<I, O, ANY, 1, SHALLOW_STACK>(isa, scene, rays, done);
        } else {
            trace_lanes::<I, O, ANY, 1, STACK>(isa, scene, rays, done);
        }
    } else {
        trace_lanes::<I, O, ANY, LANES, STACK>(isa, scene, rays, done);
    }
}

/// Whether consecutive rays mostly start at the same point: then they visit the same nodes, which
/// the previous ray left in the cache.
fn are_coherent(rays: &[KernelRay]) -> bool {
    const SAMPLES: usize = 16;
    let stride = rays.len() / SAMPLES;
    let pairs = (0..SAMPLES).map(|k| (&rays[k * stride], &rays[k * stride + 1]));
    let alike = |(a, b): &(&KernelRay, &KernelRay)| {
        let (p, q) = (Vec3::from(a.direction), Vec3::from(b.direction));
        a.origin == b.origin && p.dot(q) > 0.99 * p.length() * q.length()
    };
    2 * pairs.filter(alike).count() > SAMPLES
}

#[inline(always)]
fn trace_lanes<
    I: Instructions,
    O: OtherShapes + ?Sized,
    const ANY: bool,
    const N: usize,
    const ROOM: usize,
>(
    isa: I,
    scene: &KernelScene<O>,
    rays: &[KernelRay],
    mut done: impl FnMut(usize, &KernelHit),
) {
    let mut states = [const { TraversalState::<ROOM>::NONE }; N];
    let mut lanes: [usize; N] = std::array::from_fn(|lane| lane);
    let mut next = 0;
    let mut active = 0;
    while active < N && states[lanes[active]].start(scene.bvh, rays, &mut next, &mut done) {
        active += 1;
    }
    while active > 0 {
        let mut k = 0;
        while k < active {
            let state = &mut states[lanes[k]];
            if state.step::<I, O, ANY, N>(isa, scene, &rays[state.index]) {
                k += 1;
                continue;
            }
            let hit = if state.hit.is_hit() {
                state.hit
            } else {
                KernelHit::NOTHING
            };
            done(state.index, &hit);
            if state.start(scene.bvh, rays, &mut next, &mut done) {
                k += 1;
            } else {
                active -= 1;
                lanes.swap(k, active);
            }
        }
    }
}

/// The state of the traversal of one ray.
struct TraversalState<const ROOM: usize> {
    ray: PreparedRay,
    /// The nearest hit so far; its `t` bounds further hits.
    hit: KernelHit,
    /// The next node or leaf, a packed [`Child`].
    current: u32,
    /// Index of the ray in the batch.
    index: usize,
    waiting: usize,
    /// Children still to visit, as [`entry`] packs them.
    stack: [u64; ROOM],
}

impl<const ROOM: usize> TraversalState<ROOM> {
    const NONE: Self = TraversalState {
        ray: PreparedRay::NONE,
        hit: KernelHit::NOTHING,
        current: 0,
        index: 0,
        waiting: 0,
        stack: [0; ROOM],
    };

    /// Starts the next ray that can hit something, and reports those before it as misses.
    #[inline(always)]
    fn start(
        &mut self,
        bvh: &Bvh,
        rays: &[KernelRay],
        next: &mut usize,
        done: &mut impl FnMut(usize, &KernelHit),
    ) -> bool {
        while let Some(ray) = rays.get(*next) {
            let index = *next;
            *next += 1;
            if let (Some(prepared), false) = (PreparedRay::new(ray), bvh.nodes.is_empty()) {
                self.ray = prepared;
                self.hit = KernelHit::before(ray.t_max.next_down());
                (self.current, self.index, self.waiting) = (0, index, 0);
                return true;
            }
            done(index, &KernelHit::NOTHING);
        }
        false
    }

    /// Visits one child; returns whether there are more.
    #[inline(always)]
    fn step<I: Instructions, O: OtherShapes + ?Sized, const ANY: bool, const N: usize>(
        &mut self,
        isa: I,
        scene: &KernelScene<O>,
        ray: &KernelRay,
    ) -> bool {
        let bvh = scene.bvh;
        loop {
            if self.current & Child::LEAF == 0 {
                let node = &bvh.nodes[self.current as usize];
                if let Some(next) = self.visit::<I, ANY, N>(isa, node) {
                    self.current = next;
                    if N == 1 {
                        continue;
                    }
                    self.prefetch(isa, bvh, next);
                    self.prefetch_waiting(isa, bvh);
                    return true;
                }
            } else if self.intersect_leaf::<I, O, ANY>(isa, scene, ray) && ANY {
                return false;
            }
            if !self.pop::<ANY>() {
                return false;
            }
            // Children from the stack were prefetched when they were pushed, or earlier.
            if N > 1 {
                self.prefetch_waiting(isa, bvh);
            }
        }
    }

    /// Tests the content of the current leaf; returns whether anything was hit.
    #[inline(always)]
    fn intersect_leaf<I: Instructions, O: OtherShapes + ?Sized, const ANY: bool>(
        &mut self,
        isa: I,
        scene: &KernelScene<O>,
        ray: &KernelRay,
    ) -> bool {
        let range = Child::range(self.current);
        if self.current & Child::OTHER == 0 {
            return self.intersect_triangles::<I, ANY>(isa, &scene.bvh.packets[range]);
        }
        for &shape in &scene.bvh.others[range] {
            if !ANY {
                scene.others.closest(shape, ray, &mut self.hit);
            } else if scene.others.any(shape, ray, self.hit.t) {
                self.hit.item = 0;
            }
        }
        self.hit.is_hit()
    }

    /// Pushes the children whose boxes the ray hits, except for one, which it returns: the nearest,
    /// unless `ANY`.
    #[inline(always)]
    fn visit<I: Instructions, const ANY: bool, const N: usize>(
        &mut self,
        isa: I,
        node: &BvhNode,
    ) -> Option<u32> {
        let mut near = [0.0; WIDTH];
        let mut mask = isa.boxes(&self.ray, node, self.hit.t, &mut near);
        if mask == 0 {
            return None;
        }
        // Never too short: see `STACK`.
        let room = self.stack.get_mut(self.waiting..self.waiting + WIDTH)?;
        let room: &mut [u64; WIDTH] = room.try_into().ok()?;
        if !ANY {
            let (next, count) = put_sorted(mask, &near, &node.children, room);
            self.waiting += count;
            return Some(next);
        }
        if N > 1 {
            // No branches: the next ray can start before this one's children are known.
            let next = node.children[mask.trailing_zeros() as usize % WIDTH];
            mask &= mask - 1;
            isa.put(mask, &node.children, room);
            self.waiting += mask.count_ones() as usize;
            return Some(next);
        }
        // Branches, so that branch prediction hides the latency of memory.
        let mut count = 0;
        loop {
            let child = node.children[mask.trailing_zeros() as usize % WIDTH];
            mask &= mask - 1;
            if mask == 0 {
                self.waiting += count;
                return Some(child);
            }
            room[count % WIDTH] = u64::from(child);
            count += 1;
        }
    }

    /// Tests triangles; returns whether anything was hit, for `ANY`.
    #[inline(always)]
    fn intersect_triangles<I: Instructions, const ANY: bool>(
        &mut self,
        isa: I,
        packets: &[Packet],
    ) -> bool {
        let mut found = PacketHits::default();
        for packet in packets {
            let mut mask = isa.triangles(&self.ray, packet, self.hit.t, &mut found);
            if ANY {
                if mask != 0 {
                    self.hit.item = 0;
                    return true;
                }
                continue;
            }
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize % PACKET;
                mask &= mask - 1;
                let (t, item) = (found.t[lane], packet.items[lane]);
                if self.hit.is_after(t, item) {
                    let uv = [found.u[lane], found.v[lane]];
                    self.hit = KernelHit::on_surface(t, item, uv);
                }
            }
        }
        false
    }

    /// Pops the next child that may contain a nearer hit.
    #[inline(always)]
    fn pop<const ANY: bool>(&mut self) -> bool {
        while self.waiting > 0 {
            self.waiting -= 1;
            let entry = self.stack[self.waiting];
            if ANY || f32::from_bits((entry >> 32) as u32) <= self.hit.t {
                self.current = entry as u32;
                return true;
            }
        }
        false
    }

    /// Prefetches a child.
    #[inline(always)]
    fn prefetch<I: Instructions>(&self, isa: I, bvh: &Bvh, child: u32) {
        if child & Child::LEAF == 0 {
            if let Some(node) = bvh.nodes.get(child as usize) {
                isa.prefetch(node);
            }
        } else if let Some(packet) = bvh.packets.get(Child::range(child).start) {
            isa.prefetch(packet);
        }
    }

    /// Prefetches the child on top of the stack.
    #[inline(always)]
    fn prefetch_waiting<I: Instructions>(&self, isa: I, bvh: &Bvh) {
        self.prefetch(isa, bvh, self.stack[self.waiting.saturating_sub(1)] as u32);
    }
}
