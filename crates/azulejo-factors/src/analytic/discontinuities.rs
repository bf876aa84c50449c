//! Visual events: where on a plane the view of a polygon past others changes its structure.
//!
//! As a point moves over a plane, what it sees of a polygon past others is a smooth function of its
//! position, except where a corner of one outline passes an edge of another (vertex–edge events),
//! and where the point crosses the plane of one of them. On the plane these are the projections of
//! edges through corners: segments, half-lines and lines. (Events of three edges of three polygons
//! lie on quadrics; there the view and its first derivatives are continuous, and they are left to
//! the adaptive rule.)

use super::shadow::Obstructions;
use super::{edges, extremes};
use azulejo_scene::math::area_vector;
use azulejo_trace::lambert::{ArrayPolygon, clip};
use glam::DVec3;

/// With more discontinuities than this none are cut at: plain adaptive rules are quicker then.
const MOST_DISCONTINUITIES: usize = 600;
/// Most cells per polygon.
const MOST_CELLS: usize = 1_000;
/// Shortest piece of a discontinuity inside a cell that is worth a cut; coordinates are about 1.
const SHORTEST: f64 = 1e-9;

/// A discontinuity line; `from` and `to` in units of length along it, possibly infinite.
#[derive(Clone, Copy, Debug)]
struct Discontinuity {
    origin: DVec3,
    direction: DVec3,
    from: f64,
    to: f64,
}

/// The plane of the receiving polygon, with the others above it.
struct ReceiverPlane {
    point: DVec3,
    normal: DVec3,
}

/// Convex `polygon`, with unit `normal`, cut along the discontinuities of the view of `target`.
pub(super) fn cells(
    polygon: &[DVec3],
    normal: DVec3,
    target: &[DVec3],
    between: &Obstructions,
) -> Vec<ArrayPolygon> {
    let plane = ReceiverPlane {
        point: polygon[0],
        normal,
    };
    let discontinuities = plane.discontinuities(target, between);
    let whole: ArrayPolygon = polygon.iter().copied().collect();
    let mut done = Vec::new();
    let mut rest = vec![(whole, discontinuities)];
    while let Some((cell, mut discontinuities)) = rest.pop() {
        discontinuities.retain(|line| line.length_in(&cell, normal) > SHORTEST);
        let length = |discontinuity: &Discontinuity| discontinuity.length_in(&cell, normal);
        let longest = discontinuities
            .iter()
            .max_by(|a, b| length(a).total_cmp(&length(b)));
        let Some(&discontinuity) = longest.filter(|_| done.len() + rest.len() < MOST_CELLS) else {
            done.push(cell);
            continue;
        };
        let across = normal.cross(discontinuity.direction);
        for side in [-across, across] {
            let half = clip(&cell, discontinuity.origin, side);
            if half.len() > 2 {
                rest.push((half, discontinuities.clone()));
            }
        }
    }
    done
}

impl ReceiverPlane {
    fn discontinuities(&self, target: &[DVec3], between: &Obstructions) -> Vec<Discontinuity> {
        let others = between.windows.iter().chain(&between.blockers);
        let others: Vec<&[DVec3]> = others.map(|p| &p[..]).collect();
        let mut discontinuities = Vec::new();
        for (k, other) in others.iter().enumerate() {
            discontinuities.extend(self.crossing(other));
            self.project(target, other, &mut discontinuities);
            for before in &others[..k] {
                self.project(before, other, &mut discontinuities);
                self.project(other, before, &mut discontinuities);
            }
            if discontinuities.len() > MOST_DISCONTINUITIES {
                return Vec::new();
            }
        }
        discontinuities
    }

    fn height(&self, p: DVec3) -> f64 {
        (p - self.point).dot(self.normal)
    }

    /// Edges of either polygon through corners of the other, `far` behind `near`.
    fn project(&self, far: &[DVec3], near: &[DVec3], discontinuities: &mut Vec<Discontinuity>) {
        let through = |far: DVec3, near: DVec3| {
            let (high, low) = (self.height(far), self.height(near));
            // The line through both intersects the plane at (point times weight, weight).
            let point = (near - self.point) * high - (far - self.point) * low;
            (point, high - low)
        };
        for (a, b) in edges(far) {
            let events = near
                .iter()
                .map(|&v| self.discontinuity(through(a, v), through(b, v)));
            discontinuities.extend(events.flatten());
        }
        for (a, b) in edges(near) {
            let events = far
                .iter()
                .map(|&v| self.discontinuity(through(v, a), through(v, b)));
            discontinuities.extend(events.flatten());
        }
    }

    /// The line between two points in homogeneous coordinates, where the weight is positive.
    fn discontinuity(&self, (p, u): (DVec3, f64), (q, v): (DVec3, f64)) -> Option<Discontinuity> {
        let least = 1e-9;
        if u.max(v) <= least {
            return None;
        }
        // The end with the larger weight is the more accurate.
        let ((p, u), (q, v)) = if u >= v {
            ((p, u), (q, v))
        } else {
            ((q, v), (p, u))
        };
        let start = p / u;
        let (way, is_finite) = if v > least {
            (q / v - start, true)
        } else {
            // Towards where the weight vanishes.
            (q - start * v, false)
        };
        let length = way.length();
        (length > SHORTEST).then(|| Discontinuity {
            origin: self.point + start,
            direction: way / length,
            from: 0.0,
            to: if is_finite { length } else { f64::INFINITY },
        })
    }

    /// The line in which the plane of a polygon intersects this one.
    fn crossing(&self, polygon: &[DVec3]) -> Option<Discontinuity> {
        let normal = area_vector(polygon).normalize_or_zero();
        let direction = normal.cross(self.normal);
        let squared = direction.length_squared();
        let down = self.normal.cross(direction).normalize_or_zero();
        let slope = down.dot(normal);
        (squared > 1e-18).then(|| Discontinuity {
            origin: self.point + down * ((polygon[0] - self.point).dot(normal) / slope),
            direction: direction / squared.sqrt(),
            from: f64::NEG_INFINITY,
            to: f64::INFINITY,
        })
    }
}

impl Discontinuity {
    /// Length of the part inside a convex cell, 0 along its border.
    fn length_in(&self, cell: &[DVec3], normal: DVec3) -> f64 {
        let across = normal.cross(self.direction);
        let height = |p: DVec3| (p - self.origin).dot(across);
        let (lowest, highest) = extremes(cell.iter().map(|&p| height(p)));
        if lowest > -SHORTEST || highest < SHORTEST {
            return 0.0;
        }
        let (mut start, mut end) = (f64::INFINITY, f64::NEG_INFINITY);
        for (a, b) in edges(cell) {
            let (u, v) = (height(a), height(b));
            if (u < 0.0) != (v < 0.0) {
                let along = (a.lerp(b, u / (u - v)) - self.origin).dot(self.direction);
                (start, end) = (start.min(along), end.max(along));
            }
        }
        end.min(self.to) - start.max(self.from)
    }
}
