//! What convex polygons hide of another, and what windows show of it, from a viewpoint.
//!
//! A convex polygon covers a cone of directions, the intersection of the half-spaces through its
//! edges. The target is clipped at those planes into covered and uncovered pieces; only the
//! uncovered ones are tested against the next polygon, so that overlapping shadows count once.

use super::edges;
use azulejo_scene::math::area_vector;
use azulejo_trace::lambert::{ArrayPolygon, polygon_vector};
use glam::DVec3;

/// Sine of the angle above a polygon's plane below which a point sees it edge-on.
const EDGE_ON: f64 = 1e-13;

/// The convex polygons between a viewpoint and a target, in either winding.
#[derive(Clone, Debug, Default)]
pub(crate) struct Obstructions {
    /// The target is seen only through all of these.
    pub windows: Vec<ArrayPolygon>,
    /// The target is not seen through any of these.
    pub blockers: Vec<ArrayPolygon>,
}

impl Obstructions {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.windows.is_empty() && self.blockers.is_empty()
    }

    /// Irradiance vector at `eye` of the part of the target visible through all windows and past
    /// all blockers. Without windows the whole target's vector is subtracted, which makes a
    /// smoother integrand: what is hidden vanishes where the target touches the surface of `eye`.
    pub fn change(&self, eye: DVec3, target: &[DVec3], memory: &mut ViewScratch) -> DVec3 {
        let ViewScratch {
            here, next, planes, ..
        } = memory;
        here.clear();
        here.push(target.iter().map(|&c| c - eye));
        for window in &self.windows {
            if !cone(eye, window, planes) {
                return DVec3::ZERO;
            }
            next.clear();
            here.iter()
                .for_each(|piece| next.push_clipped(piece, planes));
            std::mem::swap(here, next);
        }
        let mut sum = if self.windows.is_empty() {
            DVec3::ZERO
        } else {
            here.vector()
        };
        for (k, blocker) in self.blockers.iter().enumerate() {
            if here.is_empty() {
                break;
            }
            if !cone(eye, blocker, planes) {
                continue;
            }
            next.clear();
            let is_last = k + 1 == self.blockers.len();
            for piece in here.iter() {
                let outside = (!is_last).then_some(&mut *next);
                sum -= hidden(piece, planes, &mut memory.rest, outside);
            }
            std::mem::swap(here, next);
        }
        sum
    }
}

/// Reusable working memory of [`Obstructions::change`].
#[derive(Default)]
pub(crate) struct ViewScratch {
    here: VisiblePieces,
    next: VisiblePieces,
    planes: Vec<DVec3>,
    rest: [Vec<DVec3>; 2],
}

/// Polygons, one after the other, relative to a viewpoint at the origin.
#[derive(Default)]
struct VisiblePieces {
    corners: Vec<DVec3>,
    ends: Vec<usize>,
}

impl VisiblePieces {
    fn clear(&mut self) {
        self.corners.clear();
        self.ends.clear();
    }

    fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    fn push(&mut self, corners: impl IntoIterator<Item = DVec3>) {
        self.corners.extend(corners);
        self.end();
    }

    /// Appends the side of `piece` that `normal` points to.
    fn push_side(&mut self, piece: &[DVec3], normal: DVec3) {
        clip(piece, normal, &mut self.corners);
        self.end();
    }

    /// Appends what is inside all planes.
    fn push_clipped(&mut self, piece: &[DVec3], planes: &[DVec3]) {
        let (mut rest, mut cut) = (piece.to_vec(), Vec::new());
        for &plane in planes {
            cut.clear();
            clip(&rest, plane, &mut cut);
            std::mem::swap(&mut rest, &mut cut);
        }
        self.push(rest);
    }

    fn end(&mut self) {
        let start = self.ends.last().copied().unwrap_or(0);
        if self.corners.len() > start + 2 {
            self.ends.push(self.corners.len());
        } else {
            self.corners.truncate(start);
        }
    }

    fn iter(&self) -> impl Iterator<Item = &[DVec3]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts
            .zip(&self.ends)
            .map(|(start, &end)| &self.corners[start..end])
    }

    fn vector(&self) -> DVec3 {
        self.iter()
            .map(|piece| polygon_vector(DVec3::ZERO, piece))
            .sum()
    }
}

/// The vector of the part of `piece` inside all planes. The parts outside go to `outside`, cut
/// apart so that none counts twice.
fn hidden(
    piece: &[DVec3],
    planes: &[DVec3],
    [rest, cut]: &mut [Vec<DVec3>; 2],
    mut outside: Option<&mut VisiblePieces>,
) -> DVec3 {
    let is_outside = |plane: &DVec3| piece.iter().all(|c| c.dot(*plane) <= 0.0);
    if planes.iter().any(is_outside) {
        if let Some(outside) = outside {
            outside.push(piece.iter().copied());
        }
        return DVec3::ZERO;
    }
    rest.clear();
    rest.extend(piece);
    for &plane in planes {
        if rest.iter().all(|c| c.dot(plane) >= 0.0) {
            continue;
        }
        if let Some(outside) = outside.as_mut() {
            outside.push_side(rest, -plane);
        }
        cut.clear();
        clip(rest, plane, cut);
        std::mem::swap(rest, cut);
    }
    polygon_vector(DVec3::ZERO, rest)
}

/// Inward normals of the planes through a viewpoint and the edges of a convex polygon; false if the
/// polygon is edge-on or has no area, and so covers nothing.
fn cone(eye: DVec3, polygon: &[DVec3], planes: &mut Vec<DVec3>) -> bool {
    let Some(&first) = polygon.first() else {
        return false;
    };
    let (area, away) = (area_vector(polygon), eye - first);
    let height = away.dot(area);
    // Written so that NaN counts as edge-on.
    let is_seen = height.abs() > EDGE_ON * away.length() * area.length();
    if !is_seen {
        return false;
    }
    planes.clear();
    // The edges of a front-facing polygon turn counter-clockwise around the line of sight.
    let sign = height.signum();
    planes.extend(edges(polygon).map(|(a, b)| (b - a).cross(a - eye) * sign));
    true
}

/// Appends the part of a polygon on the side of the plane through the origin that `normal` points
/// to (Sutherland and Hodgman 1974), as [`azulejo_trace::lambert::clip`] but into a list.
fn clip(polygon: &[DVec3], normal: DVec3, clipped: &mut Vec<DVec3>) {
    let Some(&last) = polygon.last() else {
        return;
    };
    let (mut a, mut height_a) = (last, last.dot(normal));
    for &b in polygon {
        let height_b = b.dot(normal);
        if height_a > 0.0 && height_b < 0.0 {
            clipped.push(a.lerp(b, height_a / (height_a - height_b)));
        } else if height_a < 0.0 && height_b > 0.0 {
            clipped.push(b.lerp(a, height_b / (height_b - height_a)));
        }
        if height_b >= 0.0 {
            clipped.push(b);
        }
        (a, height_a) = (b, height_b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_trace::lambert::point_to_polygon;
    use azulejo_trace::sampling::uniform;
    use glam::dvec3;

    fn square(x: f64, y: f64, z: f64, size: f64) -> ArrayPolygon {
        let corners = [(0., 0.), (0., 1.), (1., 1.), (1., 0.)];
        corners
            .into_iter()
            .map(|(u, v)| dvec3(x + size * u, y + size * v, z))
            .collect()
    }

    fn check(blockers: &[ArrayPolygon], hidden: f64) {
        let between = Obstructions {
            blockers: blockers.to_vec(),
            ..Obstructions::default()
        };
        let (eye, target) = (dvec3(0.5, 0.5, 0.0), square(0., 0., 1., 1.));
        let change = between.change(eye, &target, &mut ViewScratch::default()).z;
        assert!((change + hidden).abs() < 1e-15, "{change} and {hidden}");
    }

    /// A polygon at half the height casts a shadow twice as large.
    #[test]
    fn shadows_are_subtracted_once() {
        let seen = |shadow: &ArrayPolygon| point_to_polygon(dvec3(0.5, 0.5, 0.), DVec3::Z, shadow);
        let (small, shadow) = (square(0.4, 0.4, 0.5, 0.1), square(0.3, 0.3, 1., 0.2));
        check(&[], 0.0);
        check(std::slice::from_ref(&small), seen(&shadow));
        let turned: ArrayPolygon = small.iter().rev().copied().collect();
        check(&[small.clone(), small.clone(), turned], seen(&shadow));
        let next = square(0.45, 0.4, 0.5, 0.1);
        let both = [(0.3, 0.3), (0.3, 0.5), (0.6, 0.5), (0.6, 0.3)];
        let both: ArrayPolygon = both.into_iter().map(|(x, y)| dvec3(x, y, 1.)).collect();
        check(&[small, next], seen(&both));
        check(
            &[square(0., 0., 0.9, 1.), square(0.2, 0.2, 0.4, 0.5)],
            seen(&square(0., 0., 1., 1.)),
        );
        check(&[square(0., 0.5, 0., 1.)], 0.0);
    }

    /// Compared with points of the target, each hidden or not.
    #[test]
    fn hides_what_lines_of_sight_meet() {
        let between = Obstructions {
            windows: vec![square(0.1, 0.0, 0.3, 0.7)],
            blockers: vec![square(0.2, 0.3, 0.5, 0.3), square(0.3, 0.1, 0.7, 0.4)],
        };
        let (eye, target) = (dvec3(0.4, 0.3, 0.0), square(0., 0., 1., 1.));
        let exact = between.change(eye, &target, &mut ViewScratch::default()).z;
        let inside = |p: &ArrayPolygon, q: DVec3| {
            let at = eye + (q - eye) * (p[0].z / q.z);
            at.x > p[0].x && at.y > p[0].y && at.x < p[2].x && at.y < p[2].y
        };
        let n = 400_000;
        let kernel = |k: u32| {
            let q = dvec3(
                f64::from(uniform(&[k, 0])),
                f64::from(uniform(&[k, 1])),
                1.0,
            );
            let passes = between.windows.iter().all(|w| inside(w, q));
            let blocked = between.blockers.iter().any(|b| inside(b, q));
            let squared = (q - eye).length_squared();
            if passes && !blocked {
                1.0 / (std::f64::consts::PI * squared * squared)
            } else {
                0.0
            }
        };
        let sampled = (0..n).map(kernel).sum::<f64>() / f64::from(n);
        assert!(
            (exact - sampled).abs() < 1e-3 && exact > 0.05,
            "{exact} and {sampled}"
        );
    }
}
