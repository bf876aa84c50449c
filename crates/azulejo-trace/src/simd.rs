//! The kernel in vector instructions, chosen at run time.
//!
//! The only module with `unsafe`: loads from arrays of known length, and calls of functions that
//! need instructions whose presence has been asked for.
#![allow(
    unsafe_code,
    reason = "vector instructions double the speed of the kernel"
)]

use crate::bvh::{Node, WIDTH};
use crate::exact::{Crossing, Line2, Outline};
use crate::kernel::{self, Instructions, Others, Surroundings};
use crate::portable::Portable;
use crate::prepared::PreparedRay;
use crate::ray::{KernelHit, KernelRay};
use crate::triangle::{Packet, PacketHits};

/// An instruction set for the kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Level {
    /// Plain Rust, whatever the compiler makes of it.
    Portable,
    /// AVX2, and FMA for boxes.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Level {
    /// The best one of this machine.
    pub(crate) fn detect() -> Level {
        #[cfg(target_arch = "x86_64")]
        if Avx2::detect().is_some() {
            return Level::Avx2;
        }
        Level::Portable
    }

    /// For people.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Level::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => "AVX2",
        }
    }

    /// Nearest meeting of each ray.
    pub(crate) fn closest<O: Others + ?Sized>(
        self,
        around: &Surroundings<O>,
        rays: &[KernelRay],
        hits: &mut [KernelHit],
    ) {
        #[cfg(target_arch = "x86_64")]
        if self == Level::Avx2
            && let Some(isa) = Avx2::detect()
        {
            // SAFETY: the value of `isa` is the proof that AVX2 and FMA are there.
            return unsafe { closest_avx2(isa, around, rays, hits) };
        }
        closest(Portable, around, rays, hits);
    }

    /// Whether each ray meets anything.
    pub(crate) fn any<O: Others + ?Sized>(
        self,
        around: &Surroundings<O>,
        rays: &[KernelRay],
        blocked: &mut [bool],
    ) {
        #[cfg(target_arch = "x86_64")]
        if self == Level::Avx2
            && let Some(isa) = Avx2::detect()
        {
            // SAFETY: the value of `isa` is the proof that AVX2 and FMA are there.
            return unsafe { any_avx2(isa, around, rays, blocked) };
        }
        any(Portable, around, rays, blocked);
    }
}

#[inline(always)]
fn closest<I: Instructions, O: Others + ?Sized>(
    isa: I,
    around: &Surroundings<O>,
    rays: &[KernelRay],
    hits: &mut [KernelHit],
) {
    kernel::trace::<I, O, false>(isa, around, rays, |place, hit| hits[place] = *hit);
}

#[inline(always)]
fn any<I: Instructions, O: Others + ?Sized>(
    isa: I,
    around: &Surroundings<O>,
    rays: &[KernelRay],
    blocked: &mut [bool],
) {
    kernel::trace::<I, O, true>(isa, around, rays, |place, hit| {
        blocked[place] = hit.is_hit()
    });
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn closest_avx2<O: Others + ?Sized>(
    isa: Avx2,
    around: &Surroundings<O>,
    rays: &[KernelRay],
    hits: &mut [KernelHit],
) {
    closest(isa, around, rays, hits);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn any_avx2<O: Others + ?Sized>(
    isa: Avx2,
    around: &Surroundings<O>,
    rays: &[KernelRay],
    blocked: &mut [bool],
) {
    any(isa, around, rays, blocked);
}

/// [`Outline::cross`], the same to the last bit, with the four runs of a node side by side where
/// the machine has AVX2.
#[inline(always)]
pub(crate) fn cross(
    outline: &Outline,
    line: &Line2,
    range: [f64; 2],
    visit: impl FnMut(Crossing) -> Option<f64>,
) -> i32 {
    #[cfg(target_arch = "x86_64")]
    if Avx2::detect().is_some() {
        // SAFETY: `detect` has just found AVX2 and all bit instructions that the function enables.
        return unsafe { cross_avx2(outline, line, range, visit) };
    }
    outline.cross_here(line, range, visit)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn cross_avx2(
    outline: &Outline,
    line: &Line2,
    range: [f64; 2],
    visit: impl FnMut(Crossing) -> Option<f64>,
) -> i32 {
    outline.cross_here(line, range, visit)
}

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Instructions, Node, Packet, PacketHits, PreparedRay, WIDTH};
    use crate::triangle::{PACKET, THIN, meet_exactly};
    use std::arch::x86_64::*;

    /// Proof that AVX2, FMA and the bit instructions are there: nothing else makes one.
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
    /// AVX2 and FMA must be there; in a function that enables them, so that it is inlined.
    #[inline(always)]
    unsafe fn row(node: &Node, row: usize) -> __m256 {
        // SAFETY: a row is eight floats; aligned, because nodes are and rows are 32 bytes.
        unsafe { _mm256_load_ps(node.planes[row % 6].as_ptr()) }
    }

    /// # Safety
    /// SSE must be there.
    #[inline(always)]
    unsafe fn lanes(v: __m128) -> [f32; PACKET] {
        let mut lanes = [0.0; PACKET];
        // SAFETY: `lanes` has room for four floats.
        unsafe { _mm_storeu_ps(lanes.as_mut_ptr(), v) };
        lanes
    }

    /// Sheared coordinates of three corners.
    type Corners = [[f32; PACKET]; 3];

    /// Decides the lanes of a mask in double precision; which of them are met within the range.
    #[cold]
    #[inline(never)]
    fn recheck(
        mask: u32,
        ray: &PreparedRay,
        packet: &Packet,
        (x, y): (Corners, Corners),
        t_max: f32,
        hits: &mut PacketHits,
    ) -> u32 {
        let mut met = 0;
        for k in (0..PACKET).filter(|k| mask >> k & 1 == 1) {
            let corner = |c: Corners| c.map(|c| c[k]);
            if let Some(hit) = meet_exactly(ray, packet.triangle(k), corner(x), corner(y)) {
                hits.set(k, hit);
                met |= u32::from(hit.0 >= ray.t_min && hit.0 <= t_max) << k;
            }
        }
        met
    }

    /// For each mask the lanes that are in it, one after the other (AVX-512's compress).
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
                // SAFETY: prefetching reads nothing, and the addresses lie in `value`.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(k * LINE)) };
            }
        }

        #[inline(always)]
        fn boxes(self, ray: &PreparedRay, node: &Node, t_max: f32, near: &mut [f32; WIDTH]) -> u32 {
            // SAFETY: `self` proves the instructions; `stack` has room for eight of each.
            unsafe {
                let wide = |x: f32| _mm256_set1_ps(x);
                let enter = |axis: usize| {
                    let planes = row(node, ray.near_row[axis]);
                    _mm256_fmsub_ps(planes, wide(ray.inverse[axis]), wide(ray.near_offset[axis]))
                };
                let leave = |axis: usize| {
                    let planes = row(node, ray.near_row[axis] ^ 1);
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
        fn put(self, mask: u32, children: &[u32; WIDTH], stack: &mut [u64; WIDTH]) {
            let order = COMPRESS[mask as usize % 256].as_ptr();
            // SAFETY: `self` proves the instructions; `order` and `children` are eight lanes,
            // and `stack` has room for as many.
            unsafe {
                let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(order.cast()));
                let children = _mm256_loadu_si256(children.as_ptr().cast());
                let packed = _mm256_permutevar8x32_epi32(children, order);
                let low = _mm256_cvtepu32_epi64(_mm256_castsi256_si128(packed));
                let high = _mm256_cvtepu32_epi64(_mm256_extracti128_si256::<1>(packed));
                let to = stack.as_mut_ptr().cast::<__m256i>();
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
                let origin = ray.axes.map(|k| _mm_set1_ps(ray.origin[k]));
                let shear = ray.shear.map(|x| _mm_set1_ps(x));
                let corner = |c: usize| {
                    let at = |k: usize| {
                        let row = packet.corners[(3 * c + ray.axes[k]) % 9].as_ptr();
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
                sure | recheck(unsure, ray, packet, (x, y), t_max, hits)
            }
        }
    }
}
