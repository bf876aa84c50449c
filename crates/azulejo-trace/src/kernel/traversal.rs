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

use super::bvh::{Bvh, BvhNode, Child, WIDTH};
use super::prepared_ray::PreparedRay;
use super::ray::{KernelHit, KernelRay};
use super::simd::{Stack, StackMemory};
use super::triangle::{PACKET, Packet, PacketHits};
use glam::Vec3;
use std::ops::Range;

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

    /// Pushes the children of a mask, in order and without branches.
    fn push(self, mask: u32, children: &[u32; WIDTH], stack: &mut Stack);

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

/// Pushes the children of a mask, which is not 0, farthest first, except for the nearest, which it returns.
#[inline(always)]
fn push_sorted(
    mut mask: u32,
    near: &[f32; WIDTH],
    children: &[u32; WIDTH],
    stack: &mut Stack,
) -> u32 {
    let mut take = || {
        let k = mask.trailing_zeros() as usize % WIDTH;
        let is_any = mask != 0;
        mask &= mask.wrapping_sub(1);
        (entry(near[k], children[k]), is_any)
    };
    let (first, _) = take();
    // No branch between one child and two, which the processor could not predict.
    let (second, is_pushed) = take();
    let second = second | u64::from(is_pushed).wrapping_sub(1);
    stack.push_if(first.max(second), is_pushed);
    let mut nearest = first.min(second);
    let mut siblings = 1;
    while let (next, true) = take() {
        stack.insert(nearest.max(next), siblings);
        nearest = nearest.min(next);
        siblings += 1;
    }
    nearest as u32
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
    mut done: impl FnMut(usize, &KernelHit),
) {
    if rays.len() >= FEW_RAYS && !scene.bvh.fits_the_cache() && !are_coherent(rays) {
        return trace_lanes::<I, O, ANY>(isa, scene, rays, done);
    }
    let mut memory: StackMemory = Stack::memory();
    for (index, ray) in rays.iter().enumerate() {
        let mut hit = KernelHit::NOTHING;
        if let Some(mut state) = TraversalState::new(scene.bvh, ray) {
            let mut stack = Stack::new(&mut memory);
            while state.step::<I, O, ANY, false>(isa, scene, ray, &mut stack) {}
            hit = state.result();
        }
        done(index, &hit);
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

/// As [`trace`], with several rays in flight.
#[inline(always)]
fn trace_lanes<I: Instructions, O: OtherShapes + ?Sized, const ANY: bool>(
    isa: I,
    scene: &KernelScene<O>,
    rays: &[KernelRay],
    mut done: impl FnMut(usize, &KernelHit),
) {
    // On the heap, because a large frame on the stack would slow down the calls for few rays.
    let mut memories = vec![Stack::memory(); LANES];
    let mut lanes: Vec<Lane> = memories.iter_mut().map(Lane::new).collect();
    let mut waiting = rays.iter().enumerate();
    while !lanes.is_empty() {
        for k in (0..lanes.len()).rev() {
            let lane = &mut lanes[k];
            if let Some(state) = &mut lane.state {
                if state.step::<I, O, ANY, true>(isa, scene, &rays[lane.index], &mut lane.stack) {
                    continue;
                }
                done(lane.index, &state.result());
                lane.state = None;
                lane.stack.clear();
            }
            while lane.state.is_none()
                && let Some((index, ray)) = waiting.next()
            {
                lane.index = index;
                lane.state = TraversalState::new(scene.bvh, ray);
                if lane.state.is_none() {
                    done(index, &KernelHit::NOTHING);
                }
            }
            if lane.state.is_none() {
                lanes.swap_remove(k);
            }
        }
    }
}

/// One of several rays in flight.
struct Lane<'a> {
    /// Index of the ray.
    index: usize,
    /// `None` between two rays.
    state: Option<TraversalState>,
    stack: Stack<'a>,
}

impl Lane<'_> {
    fn new(memory: &mut StackMemory) -> Lane<'_> {
        Lane {
            index: 0,
            state: None,
            stack: Stack::new(memory),
        }
    }
}

/// The state of the traversal of one ray, but for its stack.
struct TraversalState {
    ray: PreparedRay,
    /// The nearest hit so far; its `t` bounds further hits.
    hit: KernelHit,
    /// The next node or leaf, a packed [`Child`].
    current: u32,
}

impl TraversalState {
    /// `None` if the ray cannot hit anything.
    #[inline(always)]
    fn new(bvh: &Bvh, ray: &KernelRay) -> Option<TraversalState> {
        if bvh.nodes.is_empty() {
            return None;
        }
        Some(TraversalState {
            ray: PreparedRay::new(ray)?,
            hit: KernelHit::before(ray.t_max.next_down()),
            current: 0,
        })
    }

    #[inline(always)]
    fn result(&self) -> KernelHit {
        if self.hit.is_hit() {
            self.hit
        } else {
            KernelHit::NOTHING
        }
    }

    /// Visits children until the ray is done, or with `YIELDS` until a node has to be read from memory; returns
    /// whether there are more.
    #[inline(always)]
    fn step<I: Instructions, O: OtherShapes + ?Sized, const ANY: bool, const YIELDS: bool>(
        &mut self,
        isa: I,
        scene: &KernelScene<O>,
        ray: &KernelRay,
        stack: &mut Stack,
    ) -> bool {
        let bvh = scene.bvh;
        loop {
            if self.current & Child::LEAF == 0 {
                let node = &bvh.nodes[self.current as usize];
                if let Some(next) = self.visit::<I, ANY>(isa, node, stack) {
                    self.current = next;
                    if !YIELDS {
                        continue;
                    }
                    prefetch(isa, bvh, next);
                    prefetch_waiting(isa, bvh, stack);
                    return true;
                }
            } else if self.intersect_leaf::<I, O, ANY>(isa, scene, ray) && ANY {
                return false;
            }
            if !self.pop::<ANY>(stack) {
                return false;
            }
            // Children from the stack were prefetched when they were pushed, or earlier.
            if YIELDS {
                prefetch_waiting(isa, bvh, stack);
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
        self.hit = intersect_others::<O, ANY>(scene, range, ray, self.hit);
        self.hit.is_hit()
    }

    /// Pushes the children whose boxes the ray hits, except for one, which it returns: the nearest,
    /// or with `ANY` the last.
    #[inline(always)]
    fn visit<I: Instructions, const ANY: bool>(
        &self,
        isa: I,
        node: &BvhNode,
        stack: &mut Stack,
    ) -> Option<u32> {
        let mut near = [0.0; WIDTH];
        let mask = isa.boxes(&self.ray, node, self.hit.t, &mut near);
        if mask == 0 {
            return None;
        }
        if !ANY {
            return Some(push_sorted(mask, &near, &node.children, stack));
        }
        let last = mask.ilog2();
        isa.push(mask ^ (1 << last), &node.children, stack);
        Some(node.children[last as usize % WIDTH])
    }

    /// Tests triangles; returns whether anything was hit, for `ANY`.
    #[inline(always)]
    fn intersect_triangles<I: Instructions, const ANY: bool>(
        &mut self,
        isa: I,
        packets: &[Packet],
    ) -> bool {
        let mut hits = PacketHits::default();
        for packet in packets {
            let mut mask = isa.triangles(&self.ray, packet, self.hit.t, &mut hits);
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
                let (t, item) = (hits.t[lane], packet.items[lane]);
                if self.hit.is_after(t, item) {
                    let uv = [hits.u[lane], hits.v[lane]];
                    self.hit = KernelHit::on_surface(t, item, uv);
                }
            }
        }
        false
    }

    /// Pops the next child that may contain a nearer hit.
    #[inline(always)]
    fn pop<const ANY: bool>(&mut self, stack: &mut Stack) -> bool {
        while let Some(entry) = stack.pop() {
            if ANY || f32::from_bits((entry >> 32) as u32) <= self.hit.t {
                self.current = entry as u32;
                return true;
            }
        }
        false
    }
}

/// Prefetches a child.
#[inline(always)]
fn prefetch<I: Instructions>(isa: I, bvh: &Bvh, child: u32) {
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
fn prefetch_waiting<I: Instructions>(isa: I, bvh: &Bvh, stack: &Stack) {
    if let Some(child) = stack.top() {
        prefetch(isa, bvh, child as u32);
    }
}

/// Returns the nearest of `hit` and those on some shapes; with `ANY`, any hit suffices.
///
/// Not inlined, so that the ray's state stays in registers.
#[inline(never)]
fn intersect_others<O: OtherShapes + ?Sized, const ANY: bool>(
    scene: &KernelScene<O>,
    range: Range<usize>,
    ray: &KernelRay,
    mut hit: KernelHit,
) -> KernelHit {
    for &shape in &scene.bvh.others[range] {
        if !ANY {
            scene.others.closest(shape, ray, &mut hit);
        } else if scene.others.any(shape, ray, hit.t) {
            hit.item = 0;
        }
    }
    hit
}
