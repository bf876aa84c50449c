//! Intersection of two triangles.

use glam::DVec3;

/// Planes whose angle has a smaller sine count as parallel.
const PARALLEL_SINE: f64 = 1e-7;

/// A triangle with the indices of its corners.
#[derive(Clone, Copy)]
pub(super) struct IndexedTriangle {
    pub numbers: [u32; 3],
    pub corners: [DVec3; 3],
    /// Unit normal.
    pub normal: DVec3,
}

/// An end of the segment along which two triangles intersect.
#[derive(Clone, Copy, Debug)]
pub(super) struct CrossingEnd {
    pub position: DVec3,
    /// The edge that crosses the other triangle's plane here, indices ascending; `None` at a
    /// corner.
    pub edge: Option<[u32; 2]>,
}

/// The segment along which two triangles intersect or touch; `None` if they do not, if they touch
/// in a point, or are coplanar.
///
/// Möller, *A Fast Triangle-Triangle Intersection Test* (1997): both triangles cut an interval out
/// of the line that their planes share, and the overlap of the two is the segment. Corners closer
/// to the other plane than `touch` count as lying in it. A point on an edge is the same to the bit
/// for both triangles at the edge.
pub(super) fn intersect(
    a: &IndexedTriangle,
    b: &IndexedTriangle,
    touch: f64,
) -> Option<[CrossingEnd; 2]> {
    let direction = a.normal.cross(b.normal);
    if direction.length() < PARALLEL_SINE {
        return None;
    }
    let direction = direction.normalize();
    let along = |e: &CrossingEnd| e.position.dot(direction);
    let sorted = |[p, q]: [CrossingEnd; 2]| {
        if along(&p) <= along(&q) {
            [p, q]
        } else {
            [q, p]
        }
    };
    let [a0, a1] = sorted(on_plane(a, b, touch)?);
    let [b0, b1] = sorted(on_plane(b, a, touch)?);
    let first = if along(&a0) >= along(&b0) { a0 } else { b0 };
    let last = if along(&a1) <= along(&b1) { a1 } else { b1 };
    (along(&last) - along(&first) > touch).then_some([first, last])
}

/// The points where a triangle's edges cut the plane of another.
fn on_plane(
    triangle: &IndexedTriangle,
    other: &IndexedTriangle,
    touch: f64,
) -> Option<[CrossingEnd; 2]> {
    let height = triangle.corners.map(|p| {
        let h = (p - other.corners[0]).dot(other.normal);
        if h.abs() <= touch { 0.0 } else { h }
    });
    let corners = (0..3).filter(|&k| height[k] == 0.0).map(|k| CrossingEnd {
        position: triangle.corners[k],
        edge: None,
    });
    let crossed = (0..3)
        .map(|k| [k, (k + 1) % 3])
        .filter(|e| height[e[0]] * height[e[1]] < 0.0)
        .map(|[j, k]| {
            let up = triangle.numbers[j] < triangle.numbers[k];
            let (p, q) = if up { (j, k) } else { (k, j) };
            let share = height[p] / (height[p] - height[q]);
            let (from, to) = (triangle.corners[p], triangle.corners[q]);
            CrossingEnd {
                position: from + share * (to - from),
                edge: Some([triangle.numbers[p], triangle.numbers[q]]),
            }
        });
    let ends: Vec<CrossingEnd> = corners.chain(crossed).collect();
    <[CrossingEnd; 2]>::try_from(ends).ok()
}
