//! A convex polygon that may occlude the view between two others.

use super::{edges, extremes};
use azulejo_scene::math::area_vector;
use azulejo_trace::lambert::{ArrayPolygon, clip};
use glam::DVec3;

/// The effect of a convex polygon on the lines of sight between two point sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// It blocks no line of sight.
    None,
    /// It blocks all lines of sight.
    Hides,
    /// It may block some. The bits are those of the edges that separate blocked lines from free
    /// ones; the highest is the plane itself, where it does not separate the two ends.
    Partial(u64),
}

/// The bit of the blocker's plane among those of its edges.
pub(crate) const PLANE: u64 = 1 << 63;

/// The bit of edge `k`; edges from the 63rd on share one.
pub(crate) fn edge_bit(k: usize) -> u64 {
    1 << k.min(62)
}

/// A convex polygon with its plane and its edges' planes precomputed.
#[derive(Clone, Debug)]
pub(crate) struct Blocker {
    /// Corners, clockwise or counter-clockwise.
    pub polygon: ArrayPolygon,
    /// Unit normal and offset: points p of the plane have `normal · p = offset`.
    pub normal: DVec3,
    pub offset: f64,
    /// Inward unit normals, in the polygon's plane, and offsets of the edges.
    edges: Vec<(DVec3, f64)>,
    /// Whether only lines that hit its front count: enough if it is part of a closed surface and
    /// lines start outside.
    pub is_one_sided: bool,
    /// Depth that does not count: how far what lies in its plane may be from it.
    pub graze: f64,
}

impl Blocker {
    /// `None` for polygons without area or with coordinates that are not finite.
    pub fn new(polygon: ArrayPolygon) -> Option<Blocker> {
        let area = area_vector(&polygon);
        Blocker::facing(polygon, area / area.length())
    }

    /// The same with the normal of the plane that it is known to lie in.
    pub fn facing(polygon: ArrayPolygon, normal: DVec3) -> Option<Blocker> {
        if !normal.is_finite() || normal == DVec3::ZERO {
            return None;
        }
        let next = |k: usize| polygon[(k + 1) % polygon.len()];
        let is_corner = |&k: &usize| normal.cross(next(k) - polygon[k]).length_squared() > 0.0;
        let corners = (0..polygon.len()).filter(is_corner).map(|k| polygon[k]);
        let polygon: ArrayPolygon = corners.collect();
        let edge = |(a, b): (DVec3, DVec3)| {
            let inward = normal.cross(b - a).normalize_or_zero();
            (inward, inward.dot(a))
        };
        Some(Blocker {
            normal,
            offset: normal.dot(*polygon.first()?),
            edges: edges(&polygon).map(edge).collect(),
            polygon,
            is_one_sided: false,
            graze: 0.0,
        })
    }

    /// Inward unit normals, in the polygon's plane, and offsets of the edges.
    pub fn edges(&self) -> &[(DVec3, f64)] {
        &self.edges
    }

    /// Height of a point above the plane.
    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    /// The effect on the lines from the convex hull of some points to that of others.
    ///
    /// Where the plane separates the two, the lines between them cross it in the convex hull of the
    /// points where lines between corners cross it. A polygon that the plane cuts is first cut
    /// there, because only lines from its part above to what lies below matter: neighbours on a
    /// convex body, whose planes cut everything around it, hide nothing from each other. `graze` is
    /// the depth that does not count, if it is more than the polygon's own.
    pub fn effect(&self, a: &[DVec3], b: &[DVec3], graze: f64) -> Effect {
        let graze = graze.max(self.graze);
        let range = |points: &[DVec3]| extremes(points.iter().map(|&p| self.height(p)));
        let ((low_a, high_a), (low_b, high_b)) = (range(a), range(b));
        if low_a.min(low_b) >= -graze || high_a.max(high_b) <= graze {
            return Effect::None;
        }
        if self.is_one_sided && (high_a <= graze || low_b >= -graze) {
            return Effect::None;
        }
        let parts = (low_a >= -graze && high_b <= graze) || (high_a <= graze && low_b >= -graze);
        if parts {
            return self.effect_on_crossings(a, b, graze);
        }
        let down = high_a > graze && low_b < -graze;
        let up = !self.is_one_sided && high_b > graze && low_a < -graze;
        let ways = [down.then_some([a, b]), up.then_some([b, a])];
        let ways = ways.into_iter().flatten();
        let effects = ways.map(|[above, below]| self.effect_downwards(above, below, graze));
        let edges = effects.filter_map(|effect| match effect {
            Effect::None => None,
            Effect::Hides => Some(PLANE),
            Effect::Partial(edges) => Some(edges | PLANE),
        });
        match edges.fold(0, |bits, edges| bits | edges) {
            0 => Effect::None,
            edges => Effect::Partial(edges),
        }
    }

    /// The effect on lines from the part of one polygon above the plane to the part of another below.
    fn effect_downwards(&self, above: &[DVec3], below: &[DVec3], graze: f64) -> Effect {
        let Some(&place) = self.polygon.first() else {
            return Effect::None;
        };
        let above = clip(above, place, self.normal);
        let below = clip(below, place, -self.normal);
        self.effect_on_crossings(&above, &below, graze)
    }

    fn effect_on_crossings(&self, a: &[DVec3], b: &[DVec3], graze: f64) -> Effect {
        // Edges with a crossing inside, and edges with one outside.
        let (mut inside, mut outside) = (0_u64, 0_u64);
        let mut cross = |crossing: DVec3| {
            for (k, (inward, offset)) in self.edges.iter().enumerate() {
                let depth = inward.dot(crossing) - offset;
                inside |= if depth > graze { edge_bit(k) } else { 0 };
                outside |= if depth < -graze { edge_bit(k) } else { 0 };
            }
        };
        for &p in a {
            let height = self.height(p);
            for &q in b {
                let fall = height - self.height(q);
                if fall.abs() > 4.0 * graze {
                    cross(p.lerp(q, height / fall));
                } else {
                    // Both in the plane: lines close by cross it anywhere between them.
                    cross(p);
                    cross(q);
                }
            }
        }
        let every_edge = u64::MAX >> (64 - self.edges.len().clamp(1, 63));
        if inside & every_edge != every_edge {
            Effect::None
        } else if outside == 0 {
            Effect::Hides
        } else {
            Effect::Partial(outside)
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

    const SOME: u64 = 0;

    fn check(blocker: [DVec3; 4], expected: Effect) {
        let [floor, ceiling] = [square(0., 1., 0.), square(0., 1., 1.)];
        let turned = blocker.iter().rev().copied().collect();
        for polygon in [blocker.into_iter().collect(), turned] {
            let blocker = Blocker::new(polygon).unwrap();
            for (from, to) in [(&floor, &ceiling), (&ceiling, &floor)] {
                let effect = match blocker.effect(from, to, 1e-12) {
                    Effect::Partial(_) => Effect::Partial(SOME),
                    other => other,
                };
                assert_eq!(effect, expected);
            }
        }
    }

    /// Neighbours on a convex body, whose planes cut what lies around it.
    #[test]
    fn a_convex_body_hides_nothing_from_its_faces() {
        let corner = |k: i32| {
            let angle = f64::from(k) * std::f64::consts::PI / 64.0;
            angle.sin_cos()
        };
        let side = |k: i32| {
            let ((x, z), (u, w)) = (corner(k), corner(k + 1));
            [
                dvec3(x, 0., z),
                dvec3(x, 9., z),
                dvec3(u, 9., w),
                dvec3(u, 0., w),
            ]
        };
        let strip = [(-4., 0.), (4., 0.), (4., 9.), (-4., 9.)].map(|(x, y)| dvec3(x, y, 1.5));
        let in_front = |side: &Blocker| clip(&strip, side.polygon[0], side.normal);
        for seen in 0..128 {
            let mut target = Blocker::new(side(seen).into_iter().collect()).unwrap();
            if target.height(DVec3::ZERO) > 0.0 {
                target = Blocker::new(side(seen).into_iter().rev().collect()).unwrap();
            }
            let strip = in_front(&target);
            for other in (0..128).filter(|&k| k != seen && !strip.is_empty()) {
                let other = Blocker::new(side(other).into_iter().collect()).unwrap();
                let effect = other.effect(&strip, &target.polygon, 1e-12);
                assert_eq!(effect, Effect::None, "{seen}");
            }
        }
    }

    #[test]
    fn hides_touches_or_misses() {
        check(square(0., 1., 0.5), Effect::Hides);
        check(square(-1., 2., 0.5), Effect::Hides);
        check(square(0.1, 1., 0.5), Effect::Partial(SOME));
        check(square(0.4, 0.6, 0.5), Effect::Partial(SOME));
        check(square(1., 2., 0.5), Effect::None);
        check(square(-1., 2., 0.), Effect::None);
        check(square(-1., 2., -0.1), Effect::None);
        let fin = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)];
        check(fin.map(|(y, z)| dvec3(0., y, z)), Effect::None);
        check(fin.map(|(y, z)| dvec3(0.5, y, z)), Effect::Partial(SOME));
    }
}
