//! Exact form factors by way of planar mirrors, by images.
//!
//! A chain of mirrors is unfolded: what comes after a mirror is reflected in its plane, so that
//! light goes straight on through the mirrors as through windows. What stands in the way stands
//! in the way of each leg: its image on a leg counts as far as the leg's two mirrors go.

use super::shadow::Between;
use super::{Approximate, Pair};
use azulejo_scene::math::area_vector;
use azulejo_trace::lambert::{ArrayPolygon, clip};
use glam::{DAffine3, DMat3, DVec3};

/// Height above a mirror, relative to the size of things, that counts as lying in it.
const IN_PLANE: f64 = 1e-12;

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
#[derive(Clone, Debug, Default)]
pub(crate) struct Chain {
    /// The mirrors, each as it is seen through those before it.
    pub windows: Vec<ArrayPolygon>,
    /// Their planes, in the same order.
    planes: Vec<Facing>,
    /// The world after the last mirror, seen through all of them.
    pub image: DAffine3,
    /// Images of what stands in the way, of all legs but the last, with their numbers.
    settled: Vec<(ArrayPolygon, usize)>,
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
        let mut windows = self.windows.clone();
        if let Some(last) = windows.last_mut() {
            *last = plane.front(last)?;
        }
        windows.push(window);
        let leg = occluders
            .iter()
            .enumerate()
            .filter_map(|(k, o)| Some((plane.front(&self.placed(o)?)?, k)));
        let settled = self.settled.iter().cloned().chain(leg).collect();
        let mut planes = self.planes.clone();
        planes.push(plane);
        Some(Chain {
            windows,
            planes,
            image: self.image * reflection(mirror[0], normal),
            settled,
        })
    }

    /// Image of a polygon on the last leg, as far as it lies beyond the last mirror; as in
    /// [`mirror_polygon`](azulejo_trace::lambert::mirror_polygon), fronts stay fronts.
    pub fn placed(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        let image = |&p: &DVec3| self.image.transform_point3(p);
        let placed: ArrayPolygon = if self.planes.len().is_multiple_of(2) {
            polygon.iter().map(image).collect()
        } else {
            polygon.iter().rev().map(image).collect()
        };
        match self.planes.last() {
            Some(plane) => plane.back(&placed),
            None => Some(placed),
        }
    }

    /// The part of a polygon on the first leg.
    pub fn before(&self, polygon: &[DVec3]) -> Option<ArrayPolygon> {
        match self.planes.first() {
            Some(plane) => plane.front(polygon),
            None => Some(polygon.iter().copied().collect()),
        }
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
                windows: self.windows.iter().map(moved).collect(),
                blockers: blockers.iter().map(|(b, _)| moved(b)).collect(),
            };
            Some(pair.share_past(between, accuracy))
        };
        pair().unwrap_or_default()
    }
}

/// Reflection in the plane through `point` with unit `normal`.
fn reflection(point: DVec3, normal: DVec3) -> DAffine3 {
    let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
    DAffine3::from_mat3_translation(
        DMat3::IDENTITY - 2.0 * outer,
        2.0 * point.dot(normal) * normal,
    )
}
