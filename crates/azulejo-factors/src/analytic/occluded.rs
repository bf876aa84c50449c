//! Exact form factors of pairs with occluders in between.
//!
//! The visible part of the larger polygon from a point of the smaller one is known exactly
//! ([`shadow`](super::shadow)). It is integrated adaptively ([`cells`](super::cells)) over cells of
//! the smaller polygon in which the view is smooth ([`discontinuities`](super::discontinuities)).

use super::blocker::{Blocker, Effect};
use super::shadow::{Obstructions, ViewScratch};
use super::{Approximate, EXACT, Pair, Side, cells, discontinuities, scaled};
use azulejo_trace::lambert::ArrayPolygon;
use glam::DVec3;

/// Relative error of the formula for unoccluded pairs.
const WHOLE_ERROR: f64 = 1e-13;
/// Most evaluations of the integrand, times the number of polygons in between.
const MOST_VALUES: usize = 1_000_000;

/// Form factor F₁₂ from polygon `p1` to polygon `p2` past opaque convex `occluders`, with an
/// estimate of its error.
///
/// Occluders block from both sides. They may overlap, touch or cross the polygons; those that stand
/// elsewhere cost little. Polygons and degenerate cases are as for
/// [`form_factor`](super::form_factor); an occluder without area blocks nothing.
///
/// Ends when the estimated error is below `accuracy` (absolute; 1e-10 takes a few milliseconds with
/// one occluder), or after about a million views.
///
/// ```
/// use azulejo_factors::analytic::visible_form_factor;
/// use glam::dvec3;
///
/// let square = |z: f64, size: f64| {
///     [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| dvec3(size * x, size * y, z))
/// };
/// let (floor, mut ceiling) = (square(0.0, 1.0), square(1.0, 1.0));
/// ceiling.reverse();
/// // A plate half as large in the corner, at half the height, leaves three quarters.
/// let share = visible_form_factor(&floor, &ceiling, &[square(0.5, 0.5)], 1e-10);
/// assert!((share.value - 0.14986867177379).abs() < 1e-10);
/// ```
pub fn visible_form_factor<P: AsRef<[DVec3]>>(
    p1: &[DVec3],
    p2: &[DVec3],
    occluders: &[P],
    accuracy: f64,
) -> Approximate {
    let Some(pair) = Pair::new(p1, p2) else {
        return Approximate::default();
    };
    let blockers = occluders.iter().map(|o| pair.moved(o.as_ref()));
    let between = Obstructions {
        blockers: blockers.collect(),
        windows: Vec::new(),
    };
    pair.share_past(between, accuracy)
}

/// Exchange area through windows and past blockers to about `tolerance`, with its error, and the number of
/// views times obstructions that it took.
pub(crate) fn exchange_area_past<'a>(
    p1: &[DVec3],
    p2: &[DVec3],
    screens: impl Iterator<Item = (&'a Blocker, bool)>,
    tolerance: f64,
) -> (Approximate, usize) {
    let Some(pair) = Pair::new(p1, p2) else {
        return (Approximate::default(), 0);
    };
    let mut between = Obstructions::default();
    for (screen, is_window) in screens {
        let list = if is_window {
            &mut between.windows
        } else {
            &mut between.blockers
        };
        list.push(pair.moved(&screen.polygon));
    }
    let unit = pair.scale * pair.scale;
    let (seen, views) = match pair.simplified(between) {
        Some(between) => pair.past(&between, tolerance / unit),
        None => (Approximate::default(), 0),
    };
    let seen = Approximate {
        value: seen.value.max(0.0) * unit,
        error: seen.error * unit,
    };
    (seen, views)
}

impl Pair {
    /// A polygon in this pair's coordinates.
    pub(super) fn moved(&self, polygon: &[DVec3]) -> ArrayPolygon {
        scaled(polygon, self.origin, self.scale)
    }

    /// The share of polygon 1's power that arrives past the obstructions, which are in this pair's
    /// coordinates.
    pub(super) fn share_past(&self, between: Obstructions, accuracy: f64) -> Approximate {
        let exchange = match self.simplified(between) {
            Some(between) => self.past(&between, accuracy * self.whole_area).0,
            None => Approximate::default(),
        };
        let value = self.share(exchange.value);
        let error = exchange.error / self.whole_area;
        Approximate {
            value,
            error: if error.is_finite() { error } else { value },
        }
    }

    /// Removes obstructions without effect; `None` if nothing is visible at all.
    fn simplified(&self, between: Obstructions) -> Option<Obstructions> {
        let (a, b) = (&self.p1.polygon[..], &self.p2.polygon[..]);
        let graze = 64.0 * self.rounding;
        let mut kept = Obstructions::default();
        for window in between.windows {
            match Blocker::new(window).map(|w| (w.effect(a, b, graze), w)) {
                None | Some((Effect::None, _)) => return None,
                Some((Effect::Hides, _)) => {}
                Some((Effect::Partial(_), window)) => kept.windows.push(window.polygon),
            }
        }
        for blocker in between.blockers {
            let mut planes = [&self.plane1, &self.plane2].into_iter();
            let inside = planes.try_fold(blocker, |rest, plane| plane.cut(rest));
            let blocker = inside.and_then(Blocker::new);
            match blocker.map(|blocker| (blocker.effect(a, b, graze), blocker)) {
                None | Some((Effect::None, _)) => {}
                Some((Effect::Hides, _)) => return None,
                Some((Effect::Partial(_), blocker)) => kept.blockers.push(blocker.polygon),
            }
        }
        Some(kept)
    }

    /// Exchange area past the obstructions, to about `tolerance`, and the views times obstructions.
    fn past(&self, between: &Obstructions, tolerance: f64) -> (Approximate, usize) {
        let whole = if between.windows.is_empty() {
            self.exact(EXACT)
        } else {
            0.0
        };
        let known = Approximate {
            value: whole,
            error: WHOLE_ERROR * whole,
        };
        if between.is_empty() {
            return (known, 0);
        }
        let (from, to) = self.small_and_large();
        let pieces = from.pieces().into_iter();
        let cells =
            pieces.flat_map(|p| discontinuities::cells(&p, from.normal, &to.polygon, between));
        let pieces: Vec<ArrayPolygon> = cells.collect();
        let count = between.windows.len() + between.blockers.len();
        let most = MOST_VALUES / count;
        let mut views = 0;
        let mut memory = ViewScratch::default();
        let change = cells::integrate(&pieces, from.normal, tolerance, most, |x| {
            views += 1;
            between.change(x, &to.polygon, &mut memory).dot(from.normal)
        });
        let seen = Approximate {
            value: known.value + change.value,
            error: known.error + change.error,
        };
        (seen, views * count)
    }
}

impl Side {
    /// The polygon if it is convex, else the triangles of its fan, some possibly clockwise.
    fn pieces(&self) -> Vec<ArrayPolygon> {
        let p = &self.polygon[..];
        let turn = |k: usize| {
            let [a, b, c] = [k, k + 1, k + 2].map(|k| p[k % p.len()]);
            (b - a).cross(c - b).dot(self.normal)
        };
        if (0..p.len()).all(|k| turn(k) >= -1e-12) {
            return vec![self.polygon.clone()];
        }
        let triangle = |w: &[DVec3]| [p[0], w[0], w[1]].into_iter().collect();
        p[1..].windows(2).map(triangle).collect()
    }
}
