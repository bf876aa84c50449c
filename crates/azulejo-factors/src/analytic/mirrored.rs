//! Exact form factors by way of planar mirrors: the method of images.
//!
//! A chain of mirrors is unfolded: what comes after a mirror is reflected in its plane, so that
//! light passes straight through mirrors as through windows. Occluders have an image on each leg,
//! clipped at the two mirrors of the leg.

use super::blocker::{Blocker, Effect};
use super::shadow::Obstructions;
use super::{Approximate, Pair};
use azulejo_scene::math::area_vector;
use azulejo_trace::lambert::{ArrayPolygon, clip, convex_hull};
use glam::{DAffine3, DMat3, DVec3};

/// Height above a mirror, relative to the size of the scene, that counts as lying in it.
const IN_PLANE: f64 = 1e-12;

/// Orders of more windows than this are not all tried.
const MOST_ORDERED: usize = 4;

/// Relative difference below which two images are the same.
const SAME: f64 = 1e-9;

/// Form factor F₁₂ by way of perfect convex `mirrors`, in their order from `p1` to `p2`, past
/// opaque convex `occluders`, with an estimate of its error.
///
/// Mirrors reflect on both sides over their whole area; the caller multiplies with the reflectance.
/// Mirrors block light that passes them out of order only if they are among the occluders too, and
/// may be. Without mirrors the result is that of [`visible_form_factor`]; accuracy, polygons and
/// degenerate cases are as there.
///
/// ```
/// use azulejo_factors::analytic::mirrored_form_factor;
/// use glam::dvec3;
///
/// let square = |z: f64| [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| dvec3(x, y, z));
/// let (floor, mut ceiling) = (square(0.0), square(1.0));
/// ceiling.reverse();
/// let wall = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(y, z)| dvec3(0.0, y, z));
/// let none: [&[_]; 0] = [];
/// let share = mirrored_form_factor(&floor, &ceiling, &[wall], &none, 1e-10);
/// assert!((share.value - 0.0860504892).abs() < 1e-10);
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
    let shares = chains.iter().map(|chain| {
        let blockers = chain.blockers(&occluders);
        chain.form_factor(p1, p2, &blockers, accuracy)
    });
    shares.fold(Approximate::default(), |sum, f| Approximate {
        value: sum.value + f.value,
        error: sum.error + f.error,
    })
}

/// A chain of mirrors, unfolded.
///
/// Chains with the same image that differ only in the order of mirrors at right angles to each
/// other can be [`joined`](Chain::joined): the order in which a line crosses the windows does not
/// matter then.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chain {
    /// The mirrors, each as seen through those before it, without those whose windows need no test
    /// ([`without_passed`](Chain::without_passed)).
    mirrors: Vec<ChainMirror>,
    /// Planes of the windows that need no test: what lies in one of them is not in front of it.
    passed: Vec<MirrorPlane>,
    /// Number of mirrors.
    pub length: usize,
    /// The transform of the world after the last mirror, as seen through all of them.
    pub image: DAffine3,
    /// Images of the occluders on all legs but the last, with their indices.
    obstructions: Vec<(ArrayPolygon, usize)>,
    /// Distance from a mirror's plane that does not count.
    graze: f64,
}

/// A mirror of a chain: light goes through the window, from the front of the plane to its back.
#[derive(Clone, Debug)]
struct ChainMirror {
    window: ArrayPolygon,
    plane: MirrorPlane,
}

/// A plane, and the side that light comes from.
#[derive(Clone, Copy, Debug)]
struct MirrorPlane {
    point: DVec3,
    normal: DVec3,
    /// Distance that does not count.
    graze: f64,
}

impl MirrorPlane {
    /// The part of a polygon in front; `None` if that is empty or within rounding.
    fn front(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        let heights = || polygon.iter().map(|&c| self.height(c));
        let reaches = polygon.iter().map(|&c| (c - self.point).length());
        let size = reaches.fold(0.0, f64::max);
        let graze = self.graze.max(IN_PLANE * size);
        if heights().all(|h| h <= graze) {
            None
        } else if heights().all(|h| h >= -graze) {
            Some(polygon.iter().copied().collect())
        } else {
            Some(clip(polygon, self.point, self.normal)).filter(|p| p.len() > 2)
        }
    }

    fn height(&self, p: DVec3) -> f64 {
        (p - self.point).dot(self.normal)
    }

    fn is_before(&self, p: DVec3) -> bool {
        self.height(p) > 0.0
    }

    /// Whether two planes are the same, facing the same way.
    fn is(&self, other: &MirrorPlane) -> bool {
        let way = other.point - self.point;
        self.normal.distance(other.normal) <= SAME
            && way.dot(self.normal).abs() <= SAME * (1.0 + way.length())
    }

    fn back(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        let turned = MirrorPlane {
            normal: -self.normal,
            ..*self
        };
        turned.front(polygon)
    }
}

impl Chain {
    /// No mirrors yet; what is closer than `graze` to the plane of one lies in it.
    pub fn with_graze(graze: f64) -> Chain {
        Chain {
            graze,
            ..Chain::default()
        }
    }

    /// This chain with one more mirror at its end, which reflects on the side that `side` times its
    /// normal points to; `None` if no light can take this path.
    pub fn extended(&self, mirror: &[DVec3], side: f64, occluders: &[&[DVec3]]) -> Option<Chain> {
        let normal = side * area_vector(mirror).normalize_or_zero();
        if normal == DVec3::ZERO || !normal.is_finite() {
            return None;
        }
        let plane = MirrorPlane {
            point: self.image.transform_point3(mirror[0]),
            normal: self.image.transform_vector3(normal),
            graze: self.graze,
        };
        let window = self.placed(mirror)?;
        // Occluders before the new mirror are clipped to its front.
        let before = self.mirrors.iter().map(|stage| {
            Some(ChainMirror {
                window: plane.front(&stage.window)?,
                plane: stage.plane,
            })
        });
        let mut mirrors: Vec<ChainMirror> = before.collect::<Option<_>>()?;
        mirrors.push(ChainMirror { window, plane });
        let obstructions = self.blockers(occluders).into_iter();
        Some(Chain {
            mirrors,
            passed: self.passed.clone(),
            length: self.length + 1,
            image: self.image * reflection(mirror[0], normal),
            obstructions: obstructions
                .filter_map(|(polygon, k)| Some((plane.front(&polygon)?, k)))
                .collect(),
            graze: self.graze,
        })
    }

    /// The windows, from the first mirror to the last.
    pub fn windows(&self) -> impl DoubleEndedIterator<Item = &ArrayPolygon> {
        self.mirrors.iter().map(|stage| &stage.window)
    }

    /// Image of a polygon on the last leg, clipped to what lies beyond the mirrors.
    pub fn placed(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        self.beyond(self.imaged(polygon))
    }

    /// The same, clipped at the last mirror only, if it does not lie in one whose window needs no test.
    pub fn placed_roughly(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        let image = self.imaged(polygon);
        let is_beyond = |plane: &MirrorPlane| plane.back(&image).is_some();
        if !self.passed.iter().all(is_beyond) {
            return None;
        }
        match self.mirrors.last() {
            Some(stage) => stage.plane.back(&image),
            None => Some(image),
        }
    }

    /// As in [`mirror_polygon`](azulejo_trace::lambert::mirror_polygon), fronts stay fronts.
    fn imaged(&self, polygon: &[DVec3]) -> ArrayPolygon {
        let image = |&p: &DVec3| self.image.transform_point3(p);
        if self.length.is_multiple_of(2) {
            polygon.iter().map(image).collect()
        } else {
            polygon.iter().rev().map(image).collect()
        }
    }

    /// The part of an image beyond all mirrors.
    pub fn beyond(&self, image: ArrayPolygon) -> Option<ArrayPolygon> {
        self.planes()
            .try_fold(image, |rest, plane| plane.back(&rest))
    }

    /// The part of a polygon on the first leg.
    pub fn before(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        let whole: ArrayPolygon = polygon.iter().copied().collect();
        self.planes()
            .try_fold(whole, |rest, plane| plane.front(&rest))
    }

    /// Whether a polygon lies in or behind a mirror whose window needs no test, so that its light does not start
    /// on the first leg.
    pub fn is_behind(&self, polygon: &[DVec3]) -> bool {
        let is_before = |plane: &MirrorPlane| plane.front(polygon).is_some();
        !self.passed.iter().all(is_before)
    }

    /// The planes of all mirrors, those with windows first.
    fn planes(&self) -> impl Iterator<Item = MirrorPlane> {
        let own = self.mirrors.iter().map(|stage| stage.plane);
        own.chain(self.passed.iter().copied())
    }

    /// The same without windows that all lines from any of `corners` through the last window pass
    /// anyway, but keeping those in planes in which all of `others` have windows.
    pub fn without_passed(&self, from: &[DVec3], graze: f64, others: &[&Chain]) -> Chain {
        let mut chain = self.clone();
        let Some(last) = chain.mirrors.pop() else {
            return chain;
        };
        let from = from.iter().copied().filter(|&p| last.plane.is_before(p));
        let from: Vec<DVec3> = from.collect();
        let is_tested = |stage: &ChainMirror| {
            let window = Blocker::new(stage.window.clone());
            let effect = window.map(|w| w.effect(&from, &last.window, graze));
            effect != Some(Effect::Hides)
                || others.iter().all(|o| o.in_plane(&stage.plane).is_some())
        };
        let (tested, passed): (Vec<_>, Vec<_>) = chain.mirrors.into_iter().partition(is_tested);
        chain.mirrors = tested;
        // No light comes from behind the others.
        let is_touched = |plane: &MirrorPlane| from.iter().any(|&p| plane.height(p) <= graze);
        let planes = passed.iter().map(|stage| stage.plane);
        chain.passed.extend(planes.filter(is_touched));
        chain.mirrors.push(last);
        chain
    }

    /// The window in a plane, if there is one.
    fn in_plane(&self, plane: &MirrorPlane) -> Option<&ArrayPolygon> {
        let stage = self.mirrors.iter().find(|stage| stage.plane.is(plane))?;
        Some(&stage.window)
    }

    /// Whether two chains have the same image, regardless of their windows.
    pub fn has_image_of(&self, other: &Chain) -> bool {
        let corners = self.windows().flat_map(|w| w.iter());
        let reach = corners.map(|c| c.length()).fold(1.0, f64::max);
        self.length == other.length && self.image.abs_diff_eq(other.image, SAME * reach)
    }

    /// One chain for several with the same image whose mirrors come in different orders, as in a
    /// corner of a room: the windows in each plane are joined.
    ///
    /// `None` if a line through the joined windows, in whatever order, might belong to none of the
    /// chains.
    pub fn joined(chains: &[Chain]) -> Option<Chain> {
        let mut joined = chains.first()?.clone();
        let count = joined.mirrors.len();
        if count > MOST_ORDERED || chains.iter().any(|c| c.mirrors.len() != count) {
            return None;
        }
        let planes: Vec<MirrorPlane> = joined.mirrors.iter().map(|stage| stage.plane).collect();
        let windows = |chain: &Chain| {
            let own = planes.iter().map(|plane| chain.in_plane(plane).cloned());
            own.collect::<Option<Vec<ArrayPolygon>>>()
        };
        let own: Vec<Vec<ArrayPolygon>> = chains.iter().map(windows).collect::<Option<_>>()?;
        for (k, stage) in joined.mirrors.iter_mut().enumerate() {
            let corners = own.iter().flat_map(|windows| windows[k].iter().copied());
            stage.window = convex_hull(corners, stage.plane.normal);
        }
        let joint_windows = windows(&joined)?;
        let is_covered = |order: &Vec<usize>| is_covered(&joint_windows, &own, &planes, order);
        if !orders(count).iter().all(is_covered) {
            return None;
        }
        for other in &chains[1..] {
            joined.add_settled(other);
            let is_common = |plane: &MirrorPlane| other.passed.iter().any(|p| p.is(plane));
            joined.passed.retain(is_common);
        }
        Some(joined)
    }

    fn add_settled(&mut self, other: &Chain) {
        for (polygon, k) in &other.obstructions {
            let mut known = self.obstructions.iter().filter(|(_, number)| number == k);
            if !known.any(|(p, _)| is_one(p, polygon)) {
                self.obstructions.push((polygon.clone(), *k));
            }
        }
    }

    /// Images of the occluders on all legs, with the indices of the originals.
    pub fn blockers(&self, occluders: &[&[DVec3]]) -> Vec<(ArrayPolygon, usize)> {
        let last = occluders.iter().enumerate();
        let last = last.filter_map(|(k, o)| Some((self.placed(o)?, k)));
        self.obstructions.iter().cloned().chain(last).collect()
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
            let between = Obstructions {
                windows: self.windows().map(moved).collect(),
                blockers: blockers.iter().map(|(b, _)| moved(b)).collect(),
            };
            Some(pair.share_past(between, accuracy))
        };
        pair().unwrap_or_default()
    }
}

/// Whether all lines that cross some planes in this order, inside `windows`, cross the
/// windows of one of several chains.
fn is_covered(
    windows: &[ArrayPolygon],
    chains: &[Vec<ArrayPolygon>],
    planes: &[MirrorPlane],
    order: &[usize],
) -> bool {
    // The part of a window that such lines cross: behind the planes before it, in front of the
    // others.
    let area = |window: &ArrayPolygon, at: usize| {
        let others = order.iter().enumerate().filter(|(place, _)| *place != at);
        let mut parts = others.map(|(place, &k)| (place < at, planes[k]));
        let part = parts.try_fold(window.clone(), |rest, (is_met, plane)| {
            if is_met {
                plane.back(&rest)
            } else {
                plane.front(&rest)
            }
        });
        part.map_or(0.0, |p| area_vector(&p).length())
    };
    let areas = |windows: &[ArrayPolygon]| -> Vec<f64> {
        let each = order.iter().enumerate();
        each.map(|(at, &k)| area(&windows[k], at)).collect()
    };
    let whole = areas(windows);
    let is_whole = |windows: &Vec<ArrayPolygon>| {
        let mut pairs = areas(windows).into_iter().zip(&whole);
        pairs.all(|(part, whole)| (part - whole).abs() <= SAME * whole)
    };
    whole.contains(&0.0) || chains.iter().any(is_whole)
}

/// All permutations of the numbers below `count`.
fn orders(count: usize) -> Vec<Vec<usize>> {
    let Some(last) = count.checked_sub(1) else {
        return vec![Vec::new()];
    };
    let with_last = |order: Vec<usize>| {
        (0..count).map(move |place| {
            let mut longer = order.clone();
            longer.insert(place, last);
            longer
        })
    };
    orders(last).into_iter().flat_map(with_last).collect()
}

/// Whether two polygons have the same corners in the same cyclic order.
fn is_one(a: &[DVec3], b: &[DVec3]) -> bool {
    let is_same = |p: DVec3, q: DVec3| p.distance(q) <= SAME * (1.0 + p.length());
    let is_turned = |turn: usize| (0..a.len()).all(|k| is_same(a[k], b[(k + turn) % b.len()]));
    a.len() == b.len() && (0..b.len()).any(is_turned)
}

/// Reflection in the plane through `point` with unit `normal`.
fn reflection(point: DVec3, normal: DVec3) -> DAffine3 {
    let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
    DAffine3::from_mat3_translation(
        DMat3::IDENTITY - 2.0 * outer,
        2.0 * point.dot(normal) * normal,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    fn square(corner: DVec3, u: DVec3, v: DVec3) -> [DVec3; 4] {
        [corner, corner + u, corner + u + v, corner + v]
    }

    /// Both orders of two mirrors at x = 0 and y = `gap`, the second at right angles.
    fn check(gap: f64, is_joined: bool) {
        let first = square(DVec3::ZERO, DVec3::Y, DVec3::Z);
        let second = square(dvec3(0.0, -gap, 0.0), DVec3::Z, DVec3::X);
        let by = |mirrors: [&[DVec3]; 2]| {
            let longer = |chain: Chain, m: &&[DVec3]| chain.extended(m, 1.0, &[]);
            mirrors.iter().try_fold(Chain::default(), longer).unwrap()
        };
        let chains = [by([&first, &second]), by([&second, &first])];
        assert!(chains[0].has_image_of(&chains[1]));
        let joined = Chain::joined(&chains);
        assert_eq!(joined.is_some(), is_joined);
        let areas = |chain: &Chain| {
            chain
                .windows()
                .map(|w| area_vector(w).length())
                .sum::<f64>()
        };
        assert!(joined.is_none_or(|j| (areas(&j) - 4.0).abs() < 1e-12));
        assert!(Chain::joined(&chains[..1]).is_some());
    }

    /// Past the gap between mirrors that do not meet goes light that meets one of them only.
    #[test]
    fn mirrors_that_meet_at_right_angles_are_one_chain() {
        check(0.0, true);
        check(0.2, false);
    }
}
