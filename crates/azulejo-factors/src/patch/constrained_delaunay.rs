//! Delaunay refinement that preserves constraint lines.
//!
//! `spade` distinguishes inside from outside by counting constraints, so it cannot refine a region
//! with lines through it. This does: circumcentres of bad triangles are inserted, as in Chew's
//! algorithm, unless they would come too close to a constraint, and long edges are halved.

use super::ring::{Delaunay, Face, middles_of_long_edges};
use spade::handles::FixedVertexHandle;
use spade::{Point2, PositionInTriangulation, Triangulation};
use std::collections::HashSet;

/// Rounds of insertion; triangles become good within a few.
const ROUNDS: usize = 10;
/// A triangle is bad from this ratio of circumradius to shortest edge: angles below 22°.
const WORST_RATIO: f64 = 1.335;
/// Largest area of triangles, as a share of the squared size, as in regions without lines.
const MOST_AREA: f64 = 0.42;
/// Triangles below this share are not improved.
const LEAST_AREA: f64 = 1e-4;

/// A pair of vertices in ascending order.
pub(super) type Pair = [usize; 2];

/// Adds points until angles and sizes are good, and returns the faces outside the region, which is
/// bounded by `walls`. Other constraints are lines inside.
pub(super) fn refine(mesh: &mut Delaunay, walls: &HashSet<Pair>, size: f64) -> HashSet<Face> {
    let most = 3 * mesh.num_vertices() + 32;
    for _ in 0..ROUNDS {
        let outside = outside(mesh, walls);
        let before = mesh.num_vertices();
        for (centre, from, radius) in centres_of_bad(mesh, &outside, size) {
            if mesh.num_vertices() < most && is_free(mesh, centre, from, radius) {
                // If a point cannot be inserted its triangle stays bad.
                let _ = mesh.insert(centre);
            }
        }
        if mesh.num_vertices() == before {
            let middles = middles_of_long_edges(mesh, &outside, size);
            if middles.is_empty() || before >= most {
                return outside;
            }
            for p in middles {
                let _ = mesh.insert(p);
            }
        }
    }
    outside(mesh, walls)
}

/// The faces separated from infinity by an even number of walls.
fn outside(mesh: &Delaunay, walls: &HashSet<Pair>) -> HashSet<Face> {
    let mut seen = vec![false; mesh.num_all_faces()];
    let mut outside = HashSet::new();
    let mut open: Vec<_> = mesh.convex_hull().map(|e| (e.rev(), false)).collect();
    while let Some((edge, inside)) = open.pop() {
        let ends = edge.vertices().map(|v| v.fix().index());
        let is_wall = walls.contains(&[ends[0].min(ends[1]), ends[0].max(ends[1])]);
        let Some(face) = edge.face().as_inner() else {
            continue;
        };
        if std::mem::replace(&mut seen[face.fix().index()], true) {
            continue;
        }
        let inside = inside != is_wall;
        if !inside {
            outside.insert(face.fix());
        }
        open.extend([edge.next(), edge.prev()].map(|e| (e.rev(), inside)));
    }
    outside
}

/// Circumcentres of bad triangles, a point inside each, and the radii; the largest first.
fn centres_of_bad(
    mesh: &Delaunay,
    outside: &HashSet<Face>,
    size: f64,
) -> Vec<(Point2<f64>, Point2<f64>, f64)> {
    let square = size.min(1.0) * size.min(1.0);
    let most = if size < 1.0 {
        MOST_AREA * square
    } else {
        f64::INFINITY
    };
    let mut bad: Vec<_> = mesh
        .inner_faces()
        .filter(|f| !outside.contains(&f.fix()))
        .filter_map(|f| {
            let (centre, radius_2) = f.circumcircle();
            let lengths = f.adjacent_edges().map(|e| e.length_2());
            let shortest = lengths.into_iter().fold(f64::INFINITY, f64::min);
            let (area, ratio_2) = (f.area(), radius_2 / shortest);
            let poor = ratio_2 > WORST_RATIO * WORST_RATIO && area > LEAST_AREA * square;
            (poor || area > most).then(|| (centre, f.center(), radius_2.sqrt()))
        })
        .collect();
    bad.sort_by(|a, b| b.2.total_cmp(&a.2));
    bad
}

/// Whether a circumcentre may be inserted: its circle is still empty, no constraint lies between it
/// and its triangle, and it lies in no diametral circle of a constraint nearby.
fn is_free(mesh: &Delaunay, centre: Point2<f64>, from: Point2<f64>, radius: f64) -> bool {
    let PositionInTriangulation::OnFace(face) = mesh.locate(centre) else {
        return false;
    };
    let face = mesh.face(face);
    let empty = (face.positions().iter()).all(|p| p.distance_2(centre).sqrt() > 0.9 * radius);
    let encroached = face.adjacent_edges().into_iter().any(|e| {
        let around = [e, e.rev().next(), e.rev().prev()];
        around.into_iter().any(|e| {
            let [a, b] = e.positions();
            let [p, q] = [a, b].map(|end| (end.x - centre.x, end.y - centre.y));
            e.is_constraint_edge() && p.0 * q.0 + p.1 * q.1 <= 0.0
        })
    });
    empty && !encroached && !mesh.intersects_constraint(from, centre)
}

/// The pairs of vertices that a constraint joins.
pub(super) fn joined(mesh: &Delaunay, [a, b]: Pair) -> bool {
    let [a, b] = [a, b].map(FixedVertexHandle::from_index);
    mesh.exists_constraint(a, b)
}
