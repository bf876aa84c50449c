//! Per-ray values that are computed once, before traversal.

use super::ray::KernelRay;

/// Directions shorter than this along their longest axis hit nothing.
const SHORTEST_DIRECTION: f32 = 1e-25;

/// Lower bound of the direction's components, relative to the largest, so that no product with the
/// inverse is 0 · ∞; over the scene's width this displaces a ray by less than the rounding of its
/// origin.
const SMALLEST_COMPONENT: f32 = 1e-10;

/// A ray with the values that each test of a box or triangle needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedRay {
    /// In the order of `axes`, and so is the direction.
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    /// 1 / direction, in the order x, y, z.
    pub inverse: [f32; 3],
    /// `origin · inverse`, plus the margin: for the planes where the ray enters.
    pub near_offset: [f32; 3],
    /// `origin · inverse`, less the margin: for the planes where it leaves.
    pub far_offset: [f32; 3],
    /// Side of [`BvhNode::planes`](super::bvh::BvhNode::planes) where the ray enters, per axis.
    pub near_side: [usize; 3],
    /// The three axes in cyclic order, that of the longest component last.
    pub axes: [usize; 3],
    /// Shear that maps the direction to the last axis, and the scale along it.
    pub shear: [f32; 3],
    pub t_min: f32,
    /// Bound of all coordinates, the ray's and the scene's.
    pub reach: f32,
}

/// Whether a ray can hit anything: its numbers are finite, it has a direction, and its range is
/// not empty.
pub(crate) fn can_hit(ray: &KernelRay) -> bool {
    PreparedRay::new(ray).is_some()
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
        // Comparisons with NaN are false, so this rejects NaN too.
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
            origin: axes.map(|k| o[k]),
            direction: axes.map(|k| d[k]),
            inverse,
            near_offset: [0, 1, 2].map(|k| o[k] * inverse[k] + margin * inverse[k].abs()),
            far_offset: [0, 1, 2].map(|k| o[k] * inverse[k] - margin * inverse[k].abs()),
            near_side: d.map(|x| usize::from(x.is_sign_negative())),
            axes,
            shear: [d[axes[0]] / d[last], d[axes[1]] / d[last], 1.0 / d[last]],
            t_min: ray.t_min.max(0.0),
            reach,
        })
    }
}
