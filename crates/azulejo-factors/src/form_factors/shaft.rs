//! Whether nothing can occlude a pair of polygons.

use super::boxes::BoxTree;
use crate::patch::{Patches, Polygon};
use azulejo_scene::Scene;
use azulejo_scene::math::{Aabb, area_vector};
use glam::DVec3;

/// Depth, relative to the size of the shaft, that does not count: neighbours with a common edge
/// reach in this far by rounding.
const GRAZE: f64 = 1e-8;

/// The convex hull of two polygons as half-spaces (Haines and Wallace, *Shaft Culling for Efficient
/// Ray-Traced Radiosity*, 1991), without what is behind either polygon.
pub(super) struct Shaft {
    /// Outward normals and offsets: inside is where n·x < d for all.
    planes: Vec<(DVec3, f64)>,
}

impl Shaft {
    pub fn new(a: &[DVec3], b: &[DVec3]) -> Shaft {
        let hull: Vec<DVec3> = a.iter().chain(b).copied().collect();
        let bounds = Aabb::around(hull.iter().copied());
        let graze = GRAZE * bounds.diagonal();
        let mut planes: Vec<(DVec3, f64)> = Vec::with_capacity(24);
        for polygon in [a, b] {
            let n = -area_vector(polygon).normalize_or_zero();
            planes.push((n, n.dot(polygon[0]) - graze));
        }
        for axis in DVec3::AXES {
            planes.push((axis, axis.dot(bounds.max) - graze));
            planes.push((-axis, -axis.dot(bounds.min) - graze));
        }
        for (from, to) in [(a, b), (b, a)] {
            for (k, &p) in from.iter().enumerate() {
                let edge = from[(k + 1) % from.len()] - p;
                planes.extend(
                    to.iter()
                        .filter_map(|&q| supporting(edge, p, q, &hull, graze)),
                );
            }
        }
        Shaft { planes }
    }

    /// Whether all corners are outside one plane. A box or polygon that reaches around an edge of
    /// the shaft may be taken for inside.
    fn misses(&self, corners: &[DVec3]) -> bool {
        self.planes
            .iter()
            .any(|(n, d)| corners.iter().all(|c| c.dot(*n) >= *d))
    }

    fn enters(&self, bounds: &Aabb) -> bool {
        // The corner of the box that is furthest inside.
        let lowest =
            |n: &DVec3| DVec3::select(n.cmpgt(DVec3::ZERO), bounds.min, bounds.max).dot(*n);
        self.planes.iter().all(|(n, d)| lowest(n) < *d)
    }
}

/// The plane through an edge from `p` and the corner `q`, if the whole hull is on one side.
fn supporting(edge: DVec3, p: DVec3, q: DVec3, hull: &[DVec3], graze: f64) -> Option<(DVec3, f64)> {
    let across = edge.cross(q - p);
    let n = across.normalize_or_zero();
    let heights = || hull.iter().map(|c| (*c - p).dot(n));
    // A touching corner defines no plane.
    if across.length() <= graze * edge.length() {
        return None;
    }
    if heights().all(|h| h <= graze) {
        Some((n, p.dot(n) - graze))
    } else if heights().all(|h| h >= -graze) {
        Some((-n, -p.dot(n) - graze))
    } else {
        None
    }
}

/// All occluders.
pub(super) struct Occluders {
    tree: BoxTree,
    /// Corners of flat patches; of the others only the box is known.
    polygons: Vec<Option<Polygon>>,
    boxes: Vec<Aabb>,
}

impl Occluders {
    pub fn new(patches: &Patches, scene: &Scene) -> Occluders {
        let polygons: Vec<_> = (0..patches.len()).map(|i| patches.polygon(i)).collect();
        let bounds = |(i, polygon): (usize, &Option<Polygon>)| match polygon {
            Some(polygon) => Aabb::around(polygon.iter().copied()),
            None => scene.objects[patches.face(i).object as usize].bounds(),
        };
        let boxes: Vec<Aabb> = polygons.iter().enumerate().map(bounds).collect();
        Occluders {
            tree: BoxTree::new(&boxes),
            polygons,
            boxes,
        }
    }

    /// Whether nothing reaches into the shaft. Undecided cases count as no.
    pub fn is_free(&self, shaft: &Shaft) -> bool {
        let blocks = |i: u32| match &self.polygons[i as usize] {
            Some(polygon) => !shaft.misses(polygon),
            None => shaft.enters(&self.boxes[i as usize]),
        };
        !self.tree.any(|bounds| shaft.enters(bounds), blocks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_trace::sampling::uniform;
    use glam::dvec3;

    fn square(x: f64, y: f64, z: f64, size: f64) -> [DVec3; 4] {
        [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(u, v)| dvec3(x + size * u, y + size * v, z))
    }

    fn facing(polygon: [DVec3; 4]) -> [DVec3; 4] {
        let [a, b, c, d] = polygon;
        [d, c, b, a]
    }

    /// The unit squares z = 0 and z = 1 facing each other, and an obstacle.
    fn check(other: &[DVec3], is_missed: bool) {
        let shaft = Shaft::new(&square(0., 0., 0., 1.), &facing(square(0., 0., 1., 1.)));
        assert_eq!(shaft.misses(other), is_missed, "{other:?}");
        let around = Aabb::around(other.iter().copied());
        assert!(shaft.enters(&around) || is_missed);
    }

    #[test]
    fn what_stands_between_is_seen() {
        check(&square(0.4, 0.4, 0.5, 0.1), false);
        check(&square(-3.0, -3.0, 0.5, 9.0), false);
        check(&square(0.9, 0.9, 0.01, 1.0), false);
    }

    #[test]
    fn walls_neighbours_and_what_is_behind_are_not() {
        check(&square(1.0, 0.0, 0.5, 1.0), true);
        check(&square(0.0, 1.0, 0.0, 1.0), true);
        check(&square(-1.0, -1.0, -0.2, 3.0), true);
        check(
            &[(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(y, z)| dvec3(0.0, y, z)),
            true,
        );
    }

    /// No occluder of a line between two polygons is missed.
    #[test]
    fn no_blocker_is_missed() {
        let mut blocked = 0;
        for trial in 0..20_000_u32 {
            let number = |k: u32| f64::from(uniform(&[trial, k]));
            let corner = |k: u32| dvec3(number(k), number(k + 1), number(k + 2));
            let triangle = |k: u32| [corner(k), corner(k + 3), corner(k + 6)];
            let (a, b, other) = (triangle(0), triangle(9), triangle(18));
            let point =
                |t: [DVec3; 3], k: u32| t[0].lerp(t[1], number(k)).lerp(t[2], number(k + 1));
            let (from, to) = (point(a, 27), point(b, 29));
            let sees = |t: [DVec3; 3], p: DVec3| area_vector(&t).dot(p - t[0]) > 0.0;
            if crosses(from, to, other) && sees(a, to) && sees(b, from) {
                blocked += 1;
                assert!(!Shaft::new(&a, &b).misses(&other), "trial {trial}");
            }
        }
        assert!(blocked > 100, "{blocked}");
    }

    fn crosses(from: DVec3, to: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
        let volume = |p: DVec3, q: DVec3, r: DVec3, s: DVec3| (q - p).cross(r - p).dot(s - p);
        let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| volume(from, to, p, q) > 0.0);
        let same = sides == [true; 3] || sides == [false; 3];
        same && (volume(a, b, c, from) > 0.0) != (volume(a, b, c, to) > 0.0)
    }
}
