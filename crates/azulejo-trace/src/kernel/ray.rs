//! Rays and hits of the kernel: single precision, in kernel coordinates.

/// A ray in kernel coordinates, `f32`; [`Tracer::kernel_ray`](crate::Tracer::kernel_ray) makes one.
///
/// Points `origin + t direction` for `t_min <= t < t_max`; `t` is the same as along the world's
/// ray. A ray with a number that is not finite (but `t_max`, which may be infinite), or with a
/// direction shorter than 1e-25, hits nothing; so does an empty range.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KernelRay {
    /// The point at `t` = 0.
    pub origin: [f32; 3],
    /// The smallest valid parameter; negative values count as 0.
    pub t_min: f32,
    /// Any length; `t` is in units of it.
    pub direction: [f32; 3],
    /// The end of the range of valid parameters, excluded.
    pub t_max: f32,
}

impl KernelRay {
    /// The ray from behind a hit on: no surface is hit twice at the same parameter.
    pub(crate) fn behind(&self, hit: &KernelHit) -> KernelRay {
        KernelRay {
            t_min: hit.t.next_up(),
            ..*self
        }
    }
}

/// The first hit of a [`KernelRay`]: 16 bytes.
///
/// Of several items at exactly the same `t` it is the one with the smallest number, so the result
/// does not depend on the order of traversal.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KernelHit {
    /// Parameter along the ray, to `f32` rounding; meaningless for a miss.
    pub t: f32,
    /// What was hit ([`Tracer::item`](crate::Tracer::item) describes it), or [`KernelHit::MISS`].
    pub item: u32,
    /// Position on the item. The interpretation of the bits depends on the shape: two parameters
    /// ([`KernelHit::uv`]) or a [`SolidPart`].
    location: [u32; 2],
}

/// Position of a hit on a leaf of an exact shape: the data for computing the point again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SolidPart {
    /// Index of the part of the leaf's surface; less than 2^31.
    pub part: u32,
    /// Parameter on that part.
    pub parameter: f32,
    /// Whether the ray enters here; for an open surface, whether it hits the front.
    pub enters: bool,
}

impl KernelHit {
    /// The item of a ray that hit nothing.
    pub const MISS: u32 = u32::MAX;

    /// A ray that hit nothing.
    pub const NOTHING: KernelHit = KernelHit::before(f32::INFINITY);

    /// No hit yet; only hits at or before `t` count.
    #[inline(always)]
    pub(crate) const fn before(t: f32) -> KernelHit {
        KernelHit {
            t,
            item: KernelHit::MISS,
            location: [0; 2],
        }
    }

    /// A hit on a triangle or a primitive.
    #[inline(always)]
    pub(crate) fn on_surface(t: f32, item: u32, [u, v]: [f32; 2]) -> KernelHit {
        KernelHit {
            t,
            item,
            location: [u.to_bits(), v.to_bits()],
        }
    }

    /// A hit on a leaf of an exact shape.
    #[inline(always)]
    pub(crate) fn on_solid(t: f32, item: u32, at: SolidPart) -> KernelHit {
        KernelHit {
            t,
            item,
            location: [at.part << 1 | u32::from(at.enters), at.parameter.to_bits()],
        }
    }

    /// The same place, at another parameter: that of another ray.
    pub(crate) fn at(self, t: f32) -> KernelHit {
        KernelHit { t, ..self }
    }

    /// Whether something was hit.
    pub fn is_hit(&self) -> bool {
        self.item != KernelHit::MISS
    }

    /// Position on a triangle (barycentric weights of corners 1 and 2) or on a primitive's part
    /// (its `u` and `v`).
    ///
    /// Has no meaning for items of other shapes: [`Tracer::resolve`](crate::Tracer::resolve)
    /// finds the point on them.
    #[inline(always)]
    pub fn uv(&self) -> [f32; 2] {
        self.location.map(f32::from_bits)
    }

    /// Position on a leaf of an exact shape; has no meaning for other items.
    pub(crate) fn solid_part(&self) -> SolidPart {
        let [packed, parameter] = self.location;
        SolidPart {
            part: packed >> 1,
            parameter: f32::from_bits(parameter),
            enters: packed & 1 == 1,
        }
    }

    /// Whether a hit at `t` on `item` comes before this one: by distance, then by number.
    #[inline(always)]
    pub(crate) fn is_after(&self, t: f32, item: u32) -> bool {
        t < self.t || (t == self.t && item < self.item)
    }
}
