//! Shaft culling between two clusters.
//!
//! The convex hull of two boxes is bounded by the sides of the box around both and by planes
//! through an edge of either, each parallel to an axis (Haines and Wallace, *Shaft Culling for
//! Efficient Ray-Traced Radiosity*, 1991).

use crate::analytic::{Blocker, Effect};
use azulejo_scene::math::Aabb;
use glam::DVec3;

/// A hull as half-spaces: inside is where normal · p < offset for all.
pub(super) struct ClusterShaft {
    planes: [(DVec3, f64); 12],
    count: usize,
    bounds: Aabb,
    ends: [ShaftEnd; 2],
    graze: f64,
}

/// A box by its centre and half its size.
#[derive(Clone, Copy)]
struct ShaftEnd {
    centre: DVec3,
    half: DVec3,
}

impl ShaftEnd {
    /// Lowest and highest value of normal · p − offset.
    fn range(&self, normal: DVec3, offset: f64) -> [f64; 2] {
        let (middle, reach) = (
            normal.dot(self.centre) - offset,
            normal.abs().dot(self.half),
        );
        [middle - reach, middle + reach]
    }
}

impl ClusterShaft {
    /// The shaft from one box to another; what reaches into it by less than `graze` does not count.
    pub fn new(a: &Aabb, b: &Aabb, graze: f64) -> ClusterShaft {
        let mut shaft = ClusterShaft {
            planes: [(DVec3::ZERO, 0.0); 12],
            count: 0,
            bounds: a.union(*b),
            ends: [a, b].map(|b| ShaftEnd {
                centre: b.centre(),
                half: 0.5 * b.size(),
            }),
            graze,
        };
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for corner in 0..4 {
                shaft.join(a, b, u, v, [corner & 1 != 0, corner & 2 != 0]);
            }
        }
        shaft
    }

    /// The plane through the edges of both boxes at one corner of their outlines in the axes u
    /// and v, if it is one of the hull's.
    fn join(&mut self, a: &Aabb, b: &Aabb, u: usize, v: usize, upper: [bool; 2]) {
        let at =
            |of: &Aabb, axis: usize, upper: bool| if upper { of.max[axis] } else { of.min[axis] };
        let corner = |of: &Aabb| [at(of, u, upper[0]), at(of, v, upper[1])];
        let ([pu, pv], [qu, qv]) = (corner(a), corner(b));
        let (du, dv) = (qu - pu, qv - pv);
        let (su, sv) = (
            if upper[0] { 1.0 } else { -1.0 },
            if upper[1] { 1.0 } else { -1.0 },
        );
        // Outward in both axes, in either order.
        let sign = if dv * su > 0.0 && -du * sv > 0.0 {
            1.0
        } else if dv * su < 0.0 && -du * sv < 0.0 {
            -1.0
        } else {
            return;
        };
        let length = du.hypot(dv);
        let mut normal = DVec3::ZERO;
        normal[u] = sign * dv / length;
        normal[v] = -sign * du / length;
        let offset = normal[u] * pu + normal[v] * pv;
        self.planes[self.count] = (normal, offset - self.graze);
        self.count += 1;
    }

    /// The effect of a convex polygon on the lines from the first box to the second; partial where
    /// a quick test does not decide.
    pub fn effect(&self, blocker: &Blocker) -> Effect {
        let [a, b] = self
            .ends
            .each_ref()
            .map(|end| end.range(blocker.normal, blocker.offset));
        let graze = self.graze.max(blocker.graze);
        if a[0].min(b[0]) >= -graze || a[1].max(b[1]) <= graze || self.misses(&blocker.polygon) {
            return Effect::None;
        }
        if blocker.is_one_sided && (a[1] <= graze || b[0] >= -graze) {
            return Effect::None;
        }
        let (above, below, up, down) = if a[0] >= -graze && b[1] <= graze {
            (0, 1, a, b)
        } else if b[0] >= -graze && a[1] <= graze {
            (1, 0, b, a)
        } else {
            return Effect::Partial(u64::MAX);
        };
        // The line from p above to q below crosses the plane inside an edge if inward(p) · depth(q)
        // + inward(q) · height(p) is positive.
        let (height, depth) = (
            up.map(|h| h.max(0.0)),
            [-down[1], -down[0]].map(|h| h.max(0.0)),
        );
        // What lies in the plane is not behind it.
        let mut hides = height[0] > graze && depth[0] > graze;
        for &(inward, offset) in blocker.edges() {
            let of_above = self.ends[above].range(inward, offset);
            let of_below = self.ends[below].range(inward, offset);
            let least =
                product(of_above[0], depth, f64::min) + product(of_below[0], height, f64::min);
            let most =
                product(of_above[1], depth, f64::max) + product(of_below[1], height, f64::max);
            if most <= 0.0 {
                return Effect::None;
            }
            hides &= least >= 0.0;
        }
        if hides {
            Effect::Hides
        } else {
            Effect::Partial(u64::MAX)
        }
    }

    /// Whether a polygon lies outside.
    fn misses(&self, polygon: &[DVec3]) -> bool {
        let outside = |axis: usize| {
            polygon
                .iter()
                .all(|p| p[axis] <= self.bounds.min[axis] + self.graze)
                || polygon
                    .iter()
                    .all(|p| p[axis] >= self.bounds.max[axis] - self.graze)
        };
        (0..3).any(outside)
            || self.planes[..self.count]
                .iter()
                .any(|(n, d)| polygon.iter().all(|p| p.dot(*n) >= *d))
    }

    /// Whether a box may reach inside.
    pub fn meets(&self, other: &Aabb) -> bool {
        let apart = |axis: usize| {
            other.max[axis] <= self.bounds.min[axis] + self.graze
                || other.min[axis] >= self.bounds.max[axis] - self.graze
        };
        let lowest = |n: &DVec3| DVec3::select(n.cmpgt(DVec3::ZERO), other.min, other.max).dot(*n);
        !(0..3).any(apart)
            && self.planes[..self.count]
                .iter()
                .all(|(n, d)| lowest(n) < *d)
    }
}

/// The extreme product of a number with one out of a range.
fn product(x: f64, range: [f64; 2], extreme: fn(f64, f64) -> f64) -> f64 {
    extreme(x * range[0], x * range[1])
}
