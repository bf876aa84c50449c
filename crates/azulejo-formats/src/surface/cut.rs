//! Subtracts polygons from polygons.

use super::mean_plane::{MeanPlane, edges};
use azulejo_scene::math::Aabb;
use glam::DVec3;

/// Pieces smaller than this, relative to the whole area, are dropped.
const SPECK: f64 = 1e-12;

/// Maximum number of polygons subtracted from one: each is compared with everything that is left.
pub(crate) const MOST_HOLES: usize = 4_096;

/// Maximum number of pieces per hole. Holes that do not overlap leave about four.
const MOST_PIECES: usize = 16;

/// The difference of a convex polygon and others in its plane, in convex pieces with the same
/// orientation. Where possible, the pieces reuse the given corners.
///
/// `None` if it becomes too complex: more than [`MOST_HOLES`], or holes that overlap too much.
pub(crate) fn without(whole: &[DVec3], holes: &[Vec<DVec3>]) -> Option<Vec<Vec<DVec3>>> {
    if holes.len() > MOST_HOLES {
        return None;
    }
    let plane = MeanPlane::of(whole);
    let mut pieces = vec![whole.to_vec()];
    for hole in holes {
        let turned = turned_like(hole, plane.normal);
        let corners: Vec<DVec3> = whole.iter().chain(&turned).copied().collect();
        let cutter = OverlapCutter {
            normal: plane.normal,
            area: plane.area,
            snap: 1e-9 * plane.radius,
            bounds: Aabb::around(turned.iter().copied()),
            corners,
        };
        let cut = |piece: Vec<DVec3>| cutter.subtract(piece, &turned);
        pieces = pieces.into_iter().flat_map(cut).collect();
        if pieces.len() > MOST_PIECES * holes.len() {
            return None;
        }
    }
    Some(pieces)
}

/// The polygon, counter-clockwise about a normal.
fn turned_like(polygon: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    if MeanPlane::of(polygon).normal.dot(normal) < 0.0 {
        polygon.iter().rev().copied().collect()
    } else {
        polygon.to_vec()
    }
}

struct OverlapCutter {
    normal: DVec3,
    area: f64,
    /// Points closer than this to a corner are merged with it.
    snap: f64,
    corners: Vec<DVec3>,
    /// The bounding box of the hole.
    bounds: Aabb,
}

impl OverlapCutter {
    /// The parts of a convex piece outside of a convex hole: for each of its edges in turn, the
    /// part beyond it of what the previous edges have left.
    fn subtract(&self, piece: Vec<DVec3>, hole: &[DVec3]) -> Vec<Vec<DVec3>> {
        if self.is_beside(&piece) {
            return vec![piece];
        }
        let (mut outside, mut rest) = (Vec::new(), piece.clone());
        for (a, b) in edges(hole) {
            let inward = self.normal.cross(b - a).normalize_or_zero();
            let part = self.clip(&rest, a, -inward);
            rest = self.clip(&rest, a, inward);
            outside.extend((!self.is_speck(&part)).then_some(part));
        }
        // A piece that the hole does not touch stays unchanged.
        if self.is_speck(&rest) {
            vec![piece]
        } else {
            outside
        }
    }

    /// Whether bounding boxes show that the hole does not touch a piece.
    fn is_beside(&self, piece: &[DVec3]) -> bool {
        let own = Aabb::around(piece.iter().copied());
        let apart = own.min.max(self.bounds.min) - own.max.min(self.bounds.max);
        apart.max_element() > self.snap
    }

    fn is_speck(&self, polygon: &[DVec3]) -> bool {
        polygon.len() < 3 || MeanPlane::of(polygon).area <= SPECK * self.area
    }

    /// The part of a convex polygon beyond a line (Sutherland and Hodgman 1974).
    fn clip(&self, polygon: &[DVec3], on: DVec3, beyond: DVec3) -> Vec<DVec3> {
        let height = |p: DVec3| {
            let h = beyond.dot(p - on);
            if h.abs() < self.snap { 0.0 } else { h }
        };
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (a, b) in edges(polygon) {
            let (ha, hb) = (height(a), height(b));
            if ha >= 0.0 {
                kept.push(a);
            }
            if ha * hb < 0.0 {
                kept.push(self.snapped(a.lerp(b, ha / (ha - hb))));
            }
        }
        kept
    }

    /// The point with each coordinate snapped to that of a nearby corner: walls and windows are
    /// mostly axis-aligned, and remain so.
    fn snapped(&self, p: DVec3) -> DVec3 {
        let coordinate = |axis: usize| {
            let near = |c: &&DVec3| (c[axis] - p[axis]).abs() < self.snap;
            self.corners.iter().find(near).map_or(p[axis], |c| c[axis])
        };
        DVec3::from([0, 1, 2].map(coordinate))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn square(x: f64, y: f64, size: f64) -> Vec<DVec3> {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[i, j]| DVec3::new(x + size * i, y + size * j, 2.0))
            .to_vec()
    }

    fn check(holes: &[Vec<DVec3>], pieces: usize, area: f64) {
        let rest = without(&square(0.0, 0.0, 1.0), holes).unwrap();
        assert_eq!(rest.len(), pieces, "{rest:?}");
        let left: f64 = rest.iter().map(|p| MeanPlane::of(p).area).sum();
        assert!((left - area).abs() < 1e-12, "{left}");
        assert!(rest.iter().all(|p| MeanPlane::of(p).normal.z > 1.0 - 1e-12));
    }

    #[test]
    fn what_is_left_is_convex_and_as_large_as_it_should() {
        let window = square(0.25, 0.25, 0.5);
        let turned: Vec<DVec3> = window.iter().rev().copied().collect();
        check(&[], 1, 1.0);
        check(std::slice::from_ref(&window), 4, 0.75);
        check(&[turned], 4, 0.75);
        check(&[square(0.0, 0.0, 0.5)], 2, 0.75);
        check(&[square(0.0, 0.0, 1.0)], 0, 0.0);
        check(&[square(0.1, 0.1, 0.2), square(0.6, 0.6, 0.3)], 7, 0.87);
        // Subtracting the same twice removes nothing more.
        check(&[window.clone(), window], 4, 0.75);
    }

    #[test]
    fn a_sieve_is_refused() {
        let slit = |k: usize, across: bool| -> Vec<DVec3> {
            let (low, high) = (0.01 * k as f64, 0.01 * k as f64 + 0.005);
            let corners = [[0.0, low], [1.0, low], [1.0, high], [0.0, high]];
            let turn = |[x, y]: [f64; 2]| if across { [y, x] } else { [x, y] };
            corners.map(|c| DVec2::from(turn(c)).extend(2.0)).to_vec()
        };
        let slits = (0..100).flat_map(|k| [slit(k, false), slit(k, true)]);
        let slits: Vec<_> = slits.collect();
        assert!(without(&square(0.0, 0.0, 1.0), &slits).is_none());
        let many = vec![square(0.5, 0.5, 0.1); MOST_HOLES + 1];
        assert!(without(&square(0.0, 0.0, 1.0), &many).is_none());
    }
}
