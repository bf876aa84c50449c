//! A convex polygon that stands in the way, or does not.

use azulejo_scene::math::area_vector;
use azulejo_trace::lambert::ArrayPolygon;
use glam::DVec3;

/// What a convex polygon does to the view between two other things.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// No line of sight passes it.
    None,
    /// All of them pass it.
    Hides,
    /// Some may.
    Partial,
}

/// A convex polygon with its plane and edges at hand.
#[derive(Clone, Debug)]
pub(crate) struct Blocker {
    /// Corners, in either sense of turning.
    pub polygon: ArrayPolygon,
    /// Unit normal and offset: points p of the plane have `normal · p = offset`.
    pub normal: DVec3,
    pub offset: f64,
    /// Unit normals in the plane that point inwards, and offsets, of the edges.
    edges: Vec<(DVec3, f64)>,
}

impl Blocker {
    /// `None` without area, or where coordinates are not finite.
    pub fn new(polygon: ArrayPolygon) -> Option<Blocker> {
        let area = area_vector(&polygon);
        let normal = area / area.length();
        if !normal.is_finite() {
            return None;
        }
        let next = polygon.iter().cycle().skip(1);
        let edge = |(&a, &b): (&DVec3, &DVec3)| {
            let inward = normal.cross(b - a).normalize_or_zero();
            (inward != DVec3::ZERO).then_some((inward, inward.dot(a)))
        };
        Some(Blocker {
            normal,
            offset: normal.dot(polygon[0]),
            edges: polygon.iter().zip(next).filter_map(edge).collect(),
            polygon,
        })
    }

    /// Height of a point above the plane.
    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    /// What this does to the lines between the convex hulls of two sets of points.
    ///
    /// Where a plane parts the two, the lines between them meet it in the convex hull of those
    /// places where the lines between corners do. `graze` is the depth that does not count, or
    /// is not missed.
    pub fn effect(&self, a: &[DVec3], b: &[DVec3], graze: f64) -> Effect {
        let range = |points: &[DVec3]| {
            points
                .iter()
                .map(|&p| self.height(p))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
                    (low.min(h), high.max(h))
                })
        };
        let ((low_a, high_a), (low_b, high_b)) = (range(a), range(b));
        if low_a.min(low_b) >= -graze || high_a.max(high_b) <= graze {
            return Effect::None;
        }
        let parts = (low_a >= -graze && high_b <= graze) || (high_a <= graze && low_b >= -graze);
        if !parts {
            return Effect::Partial;
        }
        self.effect_on_crossings(a, b, graze)
    }

    fn effect_on_crossings(&self, a: &[DVec3], b: &[DVec3], graze: f64) -> Effect {
        let (mut hides, mut outside) = (true, u64::MAX >> (64 - self.edges.len().clamp(1, 64)));
        for &p in a {
            let height = self.height(p);
            for &q in b {
                let fall = height - self.height(q);
                // Both in the plane: lines close by cross it anywhere between.
                let [first, second] = match fall.abs() <= 4.0 * graze {
                    true => [p, q],
                    false => [p.lerp(q, height / fall); 2],
                };
                for (k, (inward, offset)) in self.edges.iter().enumerate() {
                    let depths = [first, second].map(|c| inward.dot(c) - offset);
                    hides &= depths[0].min(depths[1]) >= -graze;
                    if depths[0].max(depths[1]) > graze {
                        outside &= !(1 << k.min(63));
                    }
                }
            }
            if !hides && outside == 0 {
                return Effect::Partial;
            }
        }
        if outside != 0 {
            Effect::None
        } else {
            Effect::Hides
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    fn square(low: f64, high: f64, z: f64) -> [DVec3; 4] {
        [(low, low), (high, low), (high, high), (low, high)].map(|(x, y)| dvec3(x, y, z))
    }

    fn check(blocker: [DVec3; 4], expected: Effect) {
        let [floor, ceiling] = [square(0., 1., 0.), square(0., 1., 1.)];
        let turned = blocker.iter().rev().copied().collect();
        for polygon in [blocker.into_iter().collect(), turned] {
            let blocker = Blocker::new(polygon).unwrap();
            assert_eq!(blocker.effect(&floor, &ceiling, 1e-12), expected);
            assert_eq!(blocker.effect(&ceiling, &floor, 1e-12), expected);
        }
    }

    #[test]
    fn hides_touches_or_misses() {
        check(square(0., 1., 0.5), Effect::Hides);
        check(square(-1., 2., 0.5), Effect::Hides);
        check(square(0.1, 1., 0.5), Effect::Partial);
        check(square(0.4, 0.6, 0.5), Effect::Partial);
        check(square(1., 2., 0.5), Effect::None);
        check(square(-1., 2., 0.), Effect::None);
        check(square(-1., 2., -0.1), Effect::None);
        let fin = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)];
        check(fin.map(|(y, z)| dvec3(0., y, z)), Effect::None);
        check(fin.map(|(y, z)| dvec3(0.5, y, z)), Effect::Partial);
    }
}
