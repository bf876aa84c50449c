//! Exact form factors by way of planar mirrors, by images.
//!
//! A chain of mirrors is unfolded: what comes after a mirror is reflected in its plane, so that
//! light goes straight on through the mirrors as through windows. What stands in the way stands
//! in the way of each leg: its image on a leg counts as far as the leg's two mirrors go.

use super::blocker::{Blocker, Effect};
use super::shadow::Between;
use super::{Approximate, Pair};
use azulejo_scene::math::{Frame, area_vector};
use azulejo_trace::lambert::{ArrayPolygon, clip};
use glam::{DAffine3, DMat3, DVec3};

/// Height above a mirror, relative to the size of things, that counts as lying in it.
const IN_PLANE: f64 = 1e-12;

/// Images that agree to this, relative to where they are, are one.
const SAME: f64 = 1e-9;

/// Form factor F₁₂ by way of perfect convex `mirrors`, in their order from `p1` to `p2`, past
/// opaque convex `occluders`, with an estimate of its error.
///
/// Mirrors reflect on both sides, with all their area; what is not reflected is the caller's to
/// multiply with. Mirrors in the way of light that does not meet them in this order block only
/// if they are among the occluders too, and may be. No mirrors: [`visible_form_factor`].
/// Accuracy, polygons and degenerate cases are as there.
///
/// ```
/// use azulejo_radiosity::analytic::mirrored_form_factor;
/// use glam::dvec3;
///
/// let square = |z: f64| [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| dvec3(x, y, z));
/// let (floor, mut ceiling) = (square(0.0), square(1.0));
/// ceiling.reverse();
/// let wall = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(y, z)| dvec3(0.0, y, z));
/// let none: [&[_]; 0] = [];
/// let found = mirrored_form_factor(&floor, &ceiling, &[wall], &none, 1e-10);
/// assert!((found.value - 0.0860504892).abs() < 1e-10);
/// ```
///
/// [`visible_form_factor`]: super::visible_form_factor
pub fn mirrored_form_factor<M: AsRef<[DVec3]>, O: AsRef<[DVec3]>>(
    p1: &[DVec3],
    p2: &[DVec3],
    mirrors: &[M],
    occluders: &[O],
    accuracy: f64,
) -> Approximate {
    let occluders: Vec<&[DVec3]> = occluders.iter().map(|o| o.as_ref()).collect();
    let mut chains = vec![Chain::default()];
    for mirror in mirrors {
        let longer = |chain: &Chain| {
            let sides = [1.0, -1.0].map(|side| chain.extended(mirror.as_ref(), side, &occluders));
            sides.into_iter().flatten()
        };
        chains = chains.iter().flat_map(longer).collect();
    }
    let found = chains.iter().map(|chain| {
        let blockers = chain.blockers(&occluders);
        chain.form_factor(p1, p2, &blockers, accuracy)
    });
    found.fold(Approximate::default(), |sum, f| Approximate {
        value: sum.value + f.value,
        error: sum.error + f.error,
    })
}

/// A chain of mirrors, unfolded.
///
/// A straight line through all its windows meets them in one order. Chains that only differ in
/// the order of mirrors at right angles to each other, and so have one image, can be one:
/// [`joined`](Chain::joined).
#[derive(Clone, Debug, Default)]
pub(crate) struct Chain {
    /// The mirrors, each as it is seen through those before it, but for those that are passed
    /// [anyway](Chain::without_passed).
    stages: Vec<Stage>,
    /// Number of mirrors.
    pub length: usize,
    /// The world after the last mirror, seen through all of them.
    pub image: DAffine3,
    /// Images of what stands in the way, of all legs but the last, with their numbers.
    settled: Vec<(ArrayPolygon, usize)>,
}

/// A mirror of a chain: light goes through the window, from the front of the plane to its back.
#[derive(Clone, Debug)]
struct Stage {
    window: ArrayPolygon,
    plane: Facing,
}

/// A plane, and which side of it light comes from.
#[derive(Clone, Copy, Debug)]
struct Facing {
    point: DVec3,
    normal: DVec3,
}

impl Facing {
    /// The part of a polygon in front, `None` if that is nothing or not beyond rounding.
    fn front(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        let heights = || polygon.iter().map(|&c| (c - self.point).dot(self.normal));
        let size = polygon
            .iter()
            .map(|&c| (c - self.point).length())
            .fold(0.0, f64::max);
        if heights().all(|h| h <= IN_PLANE * size) {
            None
        } else if heights().all(|h| h >= -IN_PLANE * size) {
            Some(polygon.iter().copied().collect())
        } else {
            Some(clip(polygon, self.point, self.normal)).filter(|p| p.len() > 2)
        }
    }

    fn is_before(&self, p: DVec3) -> bool {
        (p - self.point).dot(self.normal) > 0.0
    }

    /// Whether two planes are one, seen from the same side.
    fn is(&self, other: &Facing) -> bool {
        let way = other.point - self.point;
        self.normal.distance(other.normal) <= SAME
            && way.dot(self.normal).abs() <= SAME * (1.0 + way.length())
    }

    fn back(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        let turned = Facing {
            normal: -self.normal,
            ..*self
        };
        turned.front(polygon)
    }
}

impl Chain {
    /// This chain with one more mirror at its end, which reflects on the side that `side` times
    /// its normal points to; `None` if no light can go this way.
    pub fn extended(&self, mirror: &[DVec3], side: f64, occluders: &[&[DVec3]]) -> Option<Chain> {
        let normal = side * area_vector(mirror).normalize_or_zero();
        if normal == DVec3::ZERO || !normal.is_finite() {
            return None;
        }
        let plane = Facing {
            point: self.image.transform_point3(mirror[0]),
            normal: self.image.transform_vector3(normal),
        };
        let window = self.placed(mirror)?;
        // What is passed before the new mirror is passed in front of it.
        let before = self.stages.iter().map(|stage| {
            Some(Stage {
                window: plane.front(&stage.window)?,
                plane: stage.plane,
            })
        });
        let mut stages: Vec<Stage> = before.collect::<Option<_>>()?;
        stages.push(Stage { window, plane });
        let settled = self.blockers(occluders).into_iter();
        Some(Chain {
            stages,
            length: self.length + 1,
            image: self.image * reflection(mirror[0], normal),
            settled: settled
                .filter_map(|(polygon, k)| Some((plane.front(&polygon)?, k)))
                .collect(),
        })
    }

    /// The windows, from the first mirror to the last.
    pub fn windows(&self) -> impl DoubleEndedIterator<Item = &ArrayPolygon> {
        self.stages.iter().map(|stage| &stage.window)
    }

    /// Image of a polygon on the last leg, as far as it lies beyond the mirrors.
    pub fn placed(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        self.beyond(self.image_of(polygon))
    }

    /// The same, but only as far as it lies beyond the last mirror: less is cut off.
    pub fn placed_roughly(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        let image = self.image_of(polygon);
        match self.stages.last() {
            Some(stage) => stage.plane.back(&image),
            None => Some(image),
        }
    }

    /// As in [`mirror_polygon`](azulejo_trace::lambert::mirror_polygon), fronts stay fronts.
    fn image_of(&self, polygon: &[DVec3]) -> ArrayPolygon {
        let image = |&p: &DVec3| self.image.transform_point3(p);
        if self.length.is_multiple_of(2) {
            polygon.iter().map(image).collect()
        } else {
            polygon.iter().rev().map(image).collect()
        }
    }

    /// The part of an image beyond all mirrors.
    pub fn beyond(&self, image: ArrayPolygon) -> Option<ArrayPolygon> {
        let mut planes = self.stages.iter().map(|stage| stage.plane);
        planes.try_fold(image, |rest, plane| plane.back(&rest))
    }

    /// The part of a polygon on the first leg.
    pub fn before(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        let whole: ArrayPolygon = polygon.iter().copied().collect();
        let mut planes = self.stages.iter().map(|stage| stage.plane);
        planes.try_fold(whole, |rest, plane| plane.front(&rest))
    }

    /// The same without windows that all lines pass that go from any of some points through the
    /// last, but with those in planes of windows of another.
    pub fn without_passed(&self, from: &[DVec3], graze: f64, other: &Chain) -> Chain {
        let mut chain = self.clone();
        let Some(last) = chain.stages.pop() else {
            return chain;
        };
        let from = from.iter().copied().filter(|&p| last.plane.is_before(p));
        let from: Vec<DVec3> = from.collect();
        let is_kept = |stage: &Stage| other.stages.iter().any(|o| o.plane.is(&stage.plane));
        chain.stages.retain(|stage| {
            let window = Blocker::new(stage.window.clone());
            let effect = window.map(|w| w.effect(&from, &last.window, graze));
            effect != Some(Effect::Hides) || is_kept(stage)
        });
        chain.stages.push(last);
        chain
    }

    /// Whether the world looks the same after as many mirrors, but for what is seen of it.
    pub fn has_image_of(&self, other: &Chain) -> bool {
        let corners = self.windows().flat_map(|w| w.iter());
        let reach = corners.map(|c| c.length()).fold(1.0, f64::max);
        self.length == other.length && self.image.abs_diff_eq(other.image, SAME * reach)
    }

    /// One chain for two that meet two mirrors at right angles in either order: a line through
    /// the windows of either mirror, joined, has met one of them first.
    ///
    /// `None` if these are not such chains, or what is joined is not convex.
    pub fn joined(&self, other: &Chain) -> Option<Chain> {
        if !self.has_image_of(other) || self.stages.len() != other.stages.len() {
            return None;
        }
        let (ours, theirs) = (&self.stages, &other.stages);
        let at = (0..ours.len()).find(|&k| !ours[k].is(&theirs[k]))?;
        let is_other_way = at + 1 < ours.len()
            && ours[at].plane.is(&theirs[at + 1].plane)
            && ours[at + 1].plane.is(&theirs[at].plane);
        let rest_is_one = || (at + 2..ours.len()).all(|k| ours[k].is(&theirs[k]));
        let crossing = ours[at].plane.normal.dot(ours.get(at + 1)?.plane.normal);
        if !is_other_way || crossing.abs() > SAME || !rest_is_one() {
            return None;
        }
        let mut joined = self.clone();
        for (k, l) in [(at, at + 1), (at + 1, at)] {
            joined.stages[k].window = hull_of_both(&ours[k].window, &theirs[l].window)?;
        }
        let is_new = |(polygon, k): &&(ArrayPolygon, usize)| {
            let mut known = self.settled.iter().filter(|(_, number)| number == k);
            !known.any(|(p, _)| is_one(p, polygon))
        };
        let more = other.settled.iter().filter(is_new).cloned();
        joined.settled.extend(more);
        Some(joined)
    }

    /// Images of what stands in the way of any leg, with the numbers of the originals.
    pub fn blockers(&self, occluders: &[&[DVec3]]) -> Vec<(ArrayPolygon, usize)> {
        let last = occluders
            .iter()
            .enumerate()
            .filter_map(|(k, o)| Some((self.placed(o)?, k)));
        self.settled.iter().cloned().chain(last).collect()
    }

    fn form_factor(
        &self,
        p1: &[DVec3],
        p2: &[DVec3],
        blockers: &[(ArrayPolygon, usize)],
        accuracy: f64,
    ) -> Approximate {
        let pair = || {
            let mut pair = Pair::new(&self.before(p1)?, &self.placed(p2)?)?;
            pair.whole_area = area_vector(p1).length() / (pair.scale * pair.scale);
            let moved = |p: &ArrayPolygon| pair.moved(p);
            let between = Between {
                windows: self.windows().map(|w| moved(w)).collect(),
                blockers: blockers.iter().map(|(b, _)| moved(b)).collect(),
            };
            Some(pair.share_past(between, accuracy))
        };
        pair().unwrap_or_default()
    }
}

impl Stage {
    fn is(&self, other: &Stage) -> bool {
        self.plane.is(&other.plane) && is_one(&self.window, &other.window)
    }
}

/// Whether two polygons have the same corners, in the same order from some corner on.
fn is_one(a: &[DVec3], b: &[DVec3]) -> bool {
    let is_same = |p: DVec3, q: DVec3| p.distance(q) <= SAME * (1.0 + p.length());
    let is_turned = |turn: usize| (0..a.len()).all(|k| is_same(a[k], b[(k + turn) % b.len()]));
    a.len() == b.len() && (0..b.len()).any(is_turned)
}

/// Two convex polygons of one plane, which do not overlap, as one, if that is convex.
fn hull_of_both(a: &[DVec3], b: &[DVec3]) -> Option<ArrayPolygon> {
    let (first, second) = (area_vector(a), area_vector(b));
    let normal = first.normalize_or_zero();
    let frame = Frame::from_normal(normal);
    let flat = |&p: &DVec3| (frame.to_local(p - a[0]), p);
    let mut corners: Vec<(DVec3, DVec3)> = a.iter().chain(b).map(flat).collect();
    corners.sort_by(|(p, _), (q, _)| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    // Andrew's monotone chain: below from left to right, then above from right to left.
    let half = |ring: &mut Vec<(DVec3, DVec3)>, start: usize, p: (DVec3, DVec3)| {
        let is_corner = |ring: &[(DVec3, DVec3)]| {
            let [.., (q, _), (r, _)] = ring else {
                return true;
            };
            // Those that are one, or in line, but for rounding, are none.
            (*r - *q).cross(p.0 - *r).z > SAME * p.0.distance_squared(*q)
        };
        while ring.len() > start + 1 && !is_corner(ring) {
            ring.pop();
        }
        ring.push(p);
    };
    let mut ring = Vec::with_capacity(corners.len() + 1);
    corners.iter().for_each(|&p| half(&mut ring, 0, p));
    let start = ring.len() - 1;
    let back = corners.iter().rev().skip(1);
    back.for_each(|&p| half(&mut ring, start, p));
    ring.pop();
    let hull: ArrayPolygon = ring.into_iter().map(|(_, p)| p).collect();
    let area = first.length() + second.length();
    let is_both = (area_vector(&hull).length() - area).abs() <= SAME * area;
    is_both.then_some(hull)
}

/// Reflection in the plane through `point` with unit `normal`.
fn reflection(point: DVec3, normal: DVec3) -> DAffine3 {
    let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
    DAffine3::from_mat3_translation(
        DMat3::IDENTITY - 2.0 * outer,
        2.0 * point.dot(normal) * normal,
    )
}
