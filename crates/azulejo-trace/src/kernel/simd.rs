//! The kernel in vector instructions, chosen at run time.
//!
//! `unsafe` is needed for loads from arrays of known length, and for calls of functions that need
//! instructions whose availability has been checked.
#![allow(
    unsafe_code,
    reason = "vector instructions double the speed of the kernel"
)]

use super::build::DEEPEST;
use super::bvh::WIDTH;
use super::portable::Portable;
use super::ray::{KernelHit, KernelRay};
use super::traversal::{Instructions, KernelScene, OtherShapes, trace};
use std::mem::MaybeUninit;

/// Room for all siblings along the longest path, and for one more node.
const STACK: usize = (WIDTH - 1) * DEEPEST + 2 * WIDTH;

/// Memory of a [`Stack`]. It is not initialized: that would take longer than to trace a short ray.
pub(crate) type StackMemory = [MaybeUninit<u64>; STACK];

/// The children that a ray has still to visit.
pub(crate) struct Stack<'a> {
    /// Those below `count` are initialized.
    entries: &'a mut StackMemory,
    count: usize,
}

impl Stack<'_> {
    /// Memory for [`new`](Stack::new).
    #[inline(always)]
    pub(crate) fn memory() -> StackMemory {
        [const { MaybeUninit::uninit() }; STACK]
    }

    /// An empty stack.
    #[inline(always)]
    pub(crate) fn new(memory: &mut StackMemory) -> Stack<'_> {
        Stack {
            entries: memory,
            count: 0,
        }
    }

    /// Removes all entries.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Pushes an entry; panics when the memory is full, which no tree can cause.
    #[inline(always)]
    pub(crate) fn push(&mut self, entry: u64) {
        self.push_if(entry, true);
    }

    /// Pushes an entry on a condition, without a branch.
    #[inline(always)]
    pub(crate) fn push_if(&mut self, entry: u64, is_pushed: bool) {
        self.entries[self.count].write(entry);
        self.count += usize::from(is_pushed);
    }

    /// Pushes an entry so that the last `siblings`, which descend, and this one descend.
    #[inline(always)]
    pub(crate) fn insert(&mut self, entry: u64, siblings: usize) {
        self.push(entry);
        let mut slot = self.count - 1;
        let first = slot.saturating_sub(siblings);
        while slot > first {
            // SAFETY: entries below `count` are initialized.
            let below = unsafe { self.entries[slot - 1].assume_init() };
            if below >= entry {
                break;
            }
            self.entries[slot].write(below);
            slot -= 1;
        }
        self.entries[slot].write(entry);
    }

    /// The entry that was pushed last.
    #[inline(always)]
    pub(crate) fn top(&self) -> Option<u64> {
        let last = self.count.checked_sub(1)?;
        // SAFETY: entries below `count` are initialized.
        Some(unsafe { self.entries[last].assume_init() })
    }

    /// Removes the entry that was pushed last.
    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<u64> {
        let entry = self.top()?;
        self.count -= 1;
        Some(entry)
    }
}

/// An instruction set for the kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InstructionSet {
    /// Plain Rust, for any processor.
    Portable,
    /// AVX2, and FMA for boxes.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl InstructionSet {
    /// The best one that this machine has.
    pub(crate) fn detect() -> InstructionSet {
        #[cfg(target_arch = "x86_64")]
        if Avx2::detect().is_some() {
            return InstructionSet::Avx2;
        }
        InstructionSet::Portable
    }

    /// Its name, for reports.
    pub(crate) fn name(self) -> &'static str {
        match self {
            InstructionSet::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => "AVX2",
        }
    }

    /// The nearest hit of each ray.
    pub(crate) fn closest<O: OtherShapes + ?Sized>(
        self,
        scene: &KernelScene<O>,
        rays: &[KernelRay],
        hits: &mut [KernelHit],
    ) {
        #[cfg(target_arch = "x86_64")]
        if self == InstructionSet::Avx2
            && let Some(isa) = Avx2::detect()
        {
            // SAFETY: the value of `isa` proves that AVX2 and FMA are available.
            return unsafe { closest_avx2(isa, scene, rays, hits) };
        }
        closest(Portable, scene, rays, hits);
    }

    /// Whether each ray hits anything.
    pub(crate) fn any<O: OtherShapes + ?Sized>(
        self,
        scene: &KernelScene<O>,
        rays: &[KernelRay],
        blocked: &mut [bool],
    ) {
        #[cfg(target_arch = "x86_64")]
        if self == InstructionSet::Avx2
            && let Some(isa) = Avx2::detect()
        {
            // SAFETY: the value of `isa` proves that AVX2 and FMA are available.
            return unsafe { any_avx2(isa, scene, rays, blocked) };
        }
        any(Portable, scene, rays, blocked);
    }
}

#[inline(always)]
fn closest<I: Instructions, O: OtherShapes + ?Sized>(
    isa: I,
    scene: &KernelScene<O>,
    rays: &[KernelRay],
    hits: &mut [KernelHit],
) {
    trace::<I, O, false>(isa, scene, rays, |index, hit| hits[index] = *hit);
}

#[inline(always)]
fn any<I: Instructions, O: OtherShapes + ?Sized>(
    isa: I,
    scene: &KernelScene<O>,
    rays: &[KernelRay],
    blocked: &mut [bool],
) {
    trace::<I, O, true>(isa, scene, rays, |index, hit| blocked[index] = hit.is_hit());
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn closest_avx2<O: OtherShapes + ?Sized>(
    isa: Avx2,
    scene: &KernelScene<O>,
    rays: &[KernelRay],
    hits: &mut [KernelHit],
) {
    closest(isa, scene, rays, hits);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn any_avx2<O: OtherShapes + ?Sized>(
    isa: Avx2,
    scene: &KernelScene<O>,
    rays: &[KernelRay],
    blocked: &mut [bool],
) {
    any(isa, scene, rays, blocked);
}

/// Work that benefits from being compiled for several instruction sets.
pub(crate) trait Vectorized {
    type Output;

    /// Does the work. Implementations are `#[inline(always)]`, and so are the hot functions that
    /// they call: only inlined code is compiled for the instruction set of the caller.
    fn run(self) -> Self::Output;
}

/// Runs `work` compiled for AVX2 if the machine has it. Without fused multiplications, so that
/// results are bit-identical everywhere.
#[inline(always)]
pub(crate) fn vectorized<W: Vectorized>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if Avx2::detect().is_some() {
        // SAFETY: `detect` has just found AVX2 and all bit instructions that the function enables.
        return unsafe { run_avx2(work) };
    }
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx2<W: Vectorized>(work: W) -> W::Output {
    work.run()
}

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::super::bvh::BvhNode;
    use super::super::prepared_ray::PreparedRay;
    use super::super::triangle::{PACKET, Packet, PacketHits, THIN, intersect_exactly};
    use super::{Instructions, Stack, WIDTH};
    use std::arch::x86_64::*;
    use std::mem::MaybeUninit;

    /// Proof that AVX2, FMA and the bit instructions are available: constructed by `detect` alone.
    #[derive(Clone, Copy, Debug)]
    pub(crate) struct Avx2(());

    impl Avx2 {
        #[inline]
        pub(crate) fn detect() -> Option<Avx2> {
            let there = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("fma")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt")
                && is_x86_feature_detected!("popcnt");
            there.then_some(Avx2(()))
        }
    }

    /// # Safety
    /// AVX2 and FMA must be available. Call it in a function that enables them, so that it is
    /// inlined.
    #[inline(always)]
    unsafe fn row(node: &BvhNode, axis: usize, side: usize) -> __m256 {
        // SAFETY: a row is eight floats, aligned because nodes are aligned and rows have 32 bytes.
        unsafe { _mm256_load_ps(node.planes[axis][side & 1].as_ptr()) }
    }

    /// # Safety
    /// SSE must be available.
    #[inline(always)]
    unsafe fn lanes(v: __m128) -> [f32; PACKET] {
        let mut lanes = [0.0; PACKET];
        // SAFETY: `lanes` has room for four floats.
        unsafe { _mm_storeu_ps(lanes.as_mut_ptr(), v) };
        lanes
    }

    /// Sheared coordinates of three corners.
    type Corners = [[f32; PACKET]; 3];

    /// Resolves the lanes of a mask in double precision; returns those that are hit within the
    /// range.
    #[cold]
    #[inline(never)]
    fn recheck(
        mask: u32,
        ray: PreparedRay,
        packet: &Packet,
        (x, y): (Corners, Corners),
        t_max: f32,
        hits: &mut PacketHits,
    ) -> u32 {
        let mut met = 0;
        for k in (0..PACKET).filter(|k| mask >> k & 1 == 1) {
            let corner = |c: Corners| c.map(|c| c[k]);
            if let Some(hit) = intersect_exactly(&ray, packet.triangle(k), corner(x), corner(y)) {
                hits.set(k, hit);
                met |= u32::from(hit.0 >= ray.t_min && hit.0 <= t_max) << k;
            }
        }
        met
    }

    /// For each mask the indices of its lanes, packed (AVX-512's compress).
    static COMPRESS: [[u8; WIDTH]; 256] = compress();

    const fn compress() -> [[u8; WIDTH]; 256] {
        let mut table = [[0; WIDTH]; 256];
        let mut mask = 0;
        while mask < 256 {
            let (mut lane, mut count) = (0, 0);
            while lane < WIDTH {
                if mask >> lane & 1 == 1 {
                    table[mask][count] = lane as u8;
                    count += 1;
                }
                lane += 1;
            }
            mask += 1;
        }
        table
    }

    impl Instructions for Avx2 {
        #[inline(always)]
        fn prefetch<T>(self, value: &T) {
            const LINE: usize = 64;
            let start = std::ptr::from_ref(value).cast::<i8>();
            for k in 0..size_of::<T>().div_ceil(LINE) {
                // SAFETY: prefetching has no effect on memory, and the addresses lie in `value`.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(k * LINE)) };
            }
        }

        #[inline(always)]
        fn boxes(
            self,
            ray: &PreparedRay,
            node: &BvhNode,
            t_max: f32,
            near: &mut [f32; WIDTH],
        ) -> u32 {
            // SAFETY: `self` proves the instructions; `stack` has room for eight of each.
            unsafe {
                let wide = |x: f32| _mm256_set1_ps(x);
                let enter = |axis: usize| {
                    let planes = row(node, axis, ray.near_side[axis]);
                    _mm256_fmsub_ps(planes, wide(ray.inverse[axis]), wide(ray.near_offset[axis]))
                };
                let leave = |axis: usize| {
                    let planes = row(node, axis, ray.near_side[axis] ^ 1);
                    _mm256_fmsub_ps(planes, wide(ray.inverse[axis]), wide(ray.far_offset[axis]))
                };
                let enter = _mm256_max_ps(
                    _mm256_max_ps(enter(0), enter(1)),
                    _mm256_max_ps(enter(2), wide(ray.t_min)),
                );
                let leave = _mm256_min_ps(
                    _mm256_min_ps(leave(0), leave(1)),
                    _mm256_min_ps(leave(2), wide(t_max)),
                );
                let met = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave);
                _mm256_storeu_ps(near.as_mut_ptr(), enter);
                _mm256_movemask_ps(met) as u32
            }
        }

        #[inline(always)]
        fn push(self, mask: u32, children: &[u32; WIDTH], stack: &mut Stack) {
            let order = COMPRESS[mask as usize % 256].as_ptr();
            let room: &mut [MaybeUninit<u64>] = &mut stack.entries[stack.count..][..WIDTH];
            stack.count += (mask as u8).count_ones() as usize;
            // SAFETY: `self` proves the instructions; `order` and `children` are eight lanes,
            // and `room` has as many.
            unsafe {
                let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(order.cast()));
                let children = _mm256_loadu_si256(children.as_ptr().cast());
                let packed = _mm256_permutevar8x32_epi32(children, order);
                let low = _mm256_cvtepu32_epi64(_mm256_castsi256_si128(packed));
                let high = _mm256_cvtepu32_epi64(_mm256_extracti128_si256::<1>(packed));
                let to = room.as_mut_ptr().cast::<__m256i>();
                _mm256_storeu_si256(to, low);
                _mm256_storeu_si256(to.add(1), high);
            }
        }

        #[inline(always)]
        fn triangles(
            self,
            ray: &PreparedRay,
            packet: &Packet,
            t_max: f32,
            hits: &mut PacketHits,
        ) -> u32 {
            // SAFETY: `self` proves the instructions; every row is four floats, aligned.
            unsafe {
                let origin = ray.origin.map(|x| _mm_set1_ps(x));
                let axes = ray.axes.map(|k| k.min(2));
                let shear = ray.shear.map(|x| _mm_set1_ps(x));
                let corner = |c: usize| {
                    let at = |k: usize| {
                        let row = packet.corners[c][axes[k]].as_ptr();
                        _mm_sub_ps(_mm_load_ps(row), origin[k])
                    };
                    let z = at(2);
                    let x = _mm_sub_ps(at(0), _mm_mul_ps(shear[0], z));
                    let y = _mm_sub_ps(at(1), _mm_mul_ps(shear[1], z));
                    (x, y, z)
                };
                let (ax, ay, az) = corner(0);
                let (bx, by, bz) = corner(1);
                let (cx, cy, cz) = corner(2);
                let cross = |px, py, qx, qy| _mm_sub_ps(_mm_mul_ps(px, qy), _mm_mul_ps(py, qx));
                let a = cross(cx, cy, bx, by);
                let b = cross(ax, ay, cx, cy);
                let c = cross(bx, by, ax, ay);
                let zero = _mm_setzero_ps();
                let low = _mm_min_ps(_mm_min_ps(a, b), c);
                let high = _mm_max_ps(_mm_max_ps(a, b), c);
                let inside = _mm_or_ps(_mm_cmpge_ps(low, zero), _mm_cmple_ps(high, zero));
                if _mm_movemask_ps(inside) == 0 {
                    return 0;
                }
                let whole = _mm_add_ps(_mm_add_ps(a, b), c);
                let height = |w, z| _mm_mul_ps(w, _mm_mul_ps(shear[2], z));
                let sum = _mm_add_ps(_mm_add_ps(height(a, az), height(b, bz)), height(c, cz));
                let t = _mm_div_ps(sum, whole);
                let within = _mm_and_ps(
                    _mm_cmpge_ps(t, _mm_set1_ps(ray.t_min)),
                    _mm_cmple_ps(t, _mm_set1_ps(t_max)),
                );
                let size = |a, b, c| {
                    let sign = _mm_set1_ps(-0.0);
                    let [a, b, c] = [a, b, c].map(|v| _mm_andnot_ps(sign, v));
                    _mm_max_ps(_mm_max_ps(a, b), c)
                };
                // As in `is_thin`.
                let widths = _mm_mul_ps(size(ax, bx, cx), size(ay, by, cy));
                let thin = _mm_cmpgt_ps(
                    _mm_mul_ps(widths, size(az, bz, cz)),
                    _mm_mul_ps(_mm_set1_ps(THIN * ray.reach), size(whole, whole, whole)),
                );
                let on_edge = _mm_or_ps(
                    _mm_or_ps(_mm_cmpeq_ps(a, zero), _mm_cmpeq_ps(b, zero)),
                    _mm_cmpeq_ps(c, zero),
                );
                let unsure = _mm_or_ps(on_edge, thin);
                let unsure = _mm_movemask_ps(_mm_and_ps(inside, unsure)) as u32;
                let mask = _mm_movemask_ps(_mm_and_ps(inside, within)) as u32;
                if mask | unsure == 0 {
                    return 0;
                }
                _mm_storeu_ps(hits.t.as_mut_ptr(), t);
                _mm_storeu_ps(hits.u.as_mut_ptr(), _mm_div_ps(b, whole));
                _mm_storeu_ps(hits.v.as_mut_ptr(), _mm_div_ps(c, whole));
                if unsure == 0 {
                    return mask;
                }
                let x = [ax, bx, cx].map(|x| lanes(x));
                let y = [ay, by, cy].map(|y| lanes(y));
                let sure = mask & !unsure;
                sure | recheck(unsure, *ray, packet, (x, y), t_max, hits)
            }
        }
    }
}
