//! Polygons with holes as polygons without: each hole is connected to its surroundings by a seam,
//! an edge that is used twice.
//!
//! David Eberly, *Triangulation by Ear Clipping*, 2002: a ray from the hole's rightmost corner to
//! the right hits the nearest edge; the seam ends at a corner that is visible from there.

use azulejo_scene::math::{Frame, area_vector};
use glam::{DVec2, DVec3};

/// The corners of `outline` and `holes`, numbered consecutively in this order, as one loop, and the
/// number of holes left out because they are not inside or have no corners.
pub(crate) fn join(points: &[DVec3], outline: usize, holes: &[usize]) -> (Vec<usize>, usize) {
    let mut joined: Vec<usize> = (0..outline).collect();
    let Some(normal) = area_vector(&points[..outline]).try_normalize() else {
        return (joined, holes.len());
    };
    let frame = Frame::from_normal(normal);
    let flat = |p: &DVec3| frame.to_local(*p - points[0]).truncate();
    let flat: Vec<DVec2> = points.iter().map(flat).collect();
    let mut rings = rings(&flat, outline, holes);
    // From right to left, so that a seam never crosses a hole that is not connected yet.
    rings.sort_by(|a, b| flat[b[0]].x.total_cmp(&flat[a[0]].x));
    let mut left_out = holes.len() - rings.len();
    for ring in rings {
        match visible_corner(&joined, &flat, flat[ring[0]]) {
            Some(k) => {
                let there_and_back = ring.iter().copied().chain([ring[0], joined[k]]);
                joined.splice(k + 1..k + 1, there_and_back.collect::<Vec<_>>());
            }
            None => left_out += 1,
        }
    }
    (joined, left_out)
}

/// The holes as clockwise loops, each starting at its rightmost corner.
fn rings(flat: &[DVec2], outline: usize, holes: &[usize]) -> Vec<Vec<usize>> {
    let mut start = outline;
    let mut rings = Vec::with_capacity(holes.len());
    for &count in holes {
        let mut ring: Vec<usize> = (start..start + count).collect();
        start += count;
        if signed_area(&ring, flat) > 0.0 {
            ring.reverse();
        }
        let rightmost = (0..count).max_by(|&a, &b| flat[ring[a]].x.total_cmp(&flat[ring[b]].x));
        if let Some(rightmost) = rightmost {
            ring.rotate_left(rightmost);
            rings.push(ring);
        }
    }
    rings
}

fn signed_area(ring: &[usize], flat: &[DVec2]) -> f64 {
    let next = |i: usize| ring[(i + 1) % ring.len()];
    (0..ring.len())
        .map(|i| flat[ring[i]].perp_dot(flat[next(i)]))
        .sum()
}

/// The position in a counter-clockwise loop of a corner that is visible from a point inside; `None`
/// if the point is outside.
fn visible_corner(ring: &[usize], flat: &[DVec2], from: DVec2) -> Option<usize> {
    let n = ring.len();
    let at = |i: usize| flat[ring[i % n]];
    // The nearest edge to the right. The inside is to the left of upward edges.
    let mut nearest: Option<(f64, usize)> = None;
    for i in 0..n {
        let (a, b) = (at(i), at(i + 1));
        if a.y <= from.y && from.y < b.y {
            let x = a.x + (from.y - a.y) / (b.y - a.y) * (b.x - a.x);
            if x >= from.x && nearest.is_none_or(|(least, _)| x < least) {
                nearest = Some((x, if a.x > b.x { i } else { i + 1 }));
            }
        }
    }
    let (x, end) = nearest?;
    let hit = DVec2::new(x, from.y);
    // The farther end of that edge is visible unless corners lie in between; then the one with the
    // smallest angle to the ray is.
    let turn = |p: DVec2| (p.y - from.y).abs().atan2(p.x - from.x);
    let between = (0..n)
        .filter(|&i| in_triangle(at(i), [from, hit, at(end)]))
        .filter(|&i| is_inside_at([at(i + n - 1), at(i), at(i + 1)], from));
    let best = between.min_by(|&i, &j| {
        let key = |k: usize| (turn(at(k)), at(k).x);
        key(i)
            .partial_cmp(&key(j))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    Some(best.unwrap_or(end) % n)
}

/// Whether a point is in a triangle of either orientation, its border included.
fn in_triangle(p: DVec2, [a, b, c]: [DVec2; 3]) -> bool {
    let side = |a: DVec2, b: DVec2| (b - a).perp_dot(p - a);
    let sides = [side(a, b), side(b, c), side(c, a)];
    sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0)
}

/// Whether the segment from a corner of a counter-clockwise loop to a point starts inside.
fn is_inside_at([before, corner, behind]: [DVec2; 3], to: DVec2) -> bool {
    let left_of = |a: DVec2, b: DVec2| (b - a).perp_dot(to - a) >= 0.0;
    let (first, second) = (left_of(before, corner), left_of(corner, behind));
    if (corner - before).perp_dot(behind - corner) >= 0.0 {
        first && second
    } else {
        first || second
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::Mesh;
    use proptest::prelude::*;

    fn place(&(x, y): &(f64, f64)) -> DVec3 {
        DVec3::new(x, 2.0 * y, 3.0 + x - y)
    }

    fn rectangle([x, y]: [f64; 2], [w, h]: [f64; 2]) -> Vec<(f64, f64)> {
        vec![(x, y), (x + w, y), (x + w, y + h), (x, y + h)]
    }

    /// Joins and checks that the loop has the remaining area and that its triangles cover it.
    fn check(outline: &[(f64, f64)], holes: &[Vec<(f64, f64)>], left_out: usize) {
        let points: Vec<DVec3> = outline
            .iter()
            .chain(holes.iter().flatten())
            .map(place)
            .collect();
        let counts: Vec<usize> = holes.iter().map(Vec::len).collect();
        let (joined, missing) = join(&points, outline.len(), &counts);
        assert_eq!(missing, left_out);
        let area = |loop_: &[(f64, f64)]| {
            area_vector(&loop_.iter().map(place).collect::<Vec<_>>()).length()
        };
        let expected = match left_out {
            0 => area(outline) - holes.iter().map(|h| area(h)).sum::<f64>(),
            _ => area(outline),
        };
        let mut mesh = Mesh {
            positions: points,
            ..Mesh::default()
        };
        mesh.push_face(&joined.iter().map(|&k| k as u32).collect::<Vec<_>>(), 0);
        assert!(
            (mesh.area() - expected).abs() < 1e-9 * expected,
            "{} {expected}",
            mesh.area()
        );
        let positions = mesh.face_positions(0);
        let covered: f64 = mesh
            .triangulate(0)
            .iter()
            .map(|t| area_vector(&t.map(|k| positions[k as usize])).length())
            .sum();
        assert!(
            (covered - expected).abs() < 1e-9 * expected,
            "{covered}, expected {expected}"
        );
    }

    #[test]
    fn windows_in_a_wall() {
        let wall = rectangle([0.0, 0.0], [10.0, 3.0]);
        let windows: Vec<_> = (0..4)
            .map(|i| rectangle([1.0 + 2.0 * f64::from(i), 1.0], [1.0, 1.0]))
            .collect();
        check(&wall, &windows, 0);
        let turned: Vec<Vec<_>> = windows
            .iter()
            .map(|w| w.iter().rev().copied().collect())
            .collect();
        check(&wall, &turned, 0);
        check(&wall, &[], 0);
    }

    #[test]
    fn an_outline_with_notches() {
        let comb = [
            (0.0, 0.0),
            (9.0, 0.0),
            (9.0, 5.0),
            (8.0, 5.0),
            (8.0, 1.0),
            (7.0, 1.0),
            (7.0, 5.0),
            (6.0, 5.0),
            (5.9, 1.1),
            (5.0, 5.0),
            (0.0, 5.0),
        ];
        check(
            &comb,
            &[
                rectangle([1.0, 1.0], [2.0, 3.0]),
                rectangle([3.5, 0.5], [1.0, 1.0]),
            ],
            0,
        );
    }

    #[test]
    fn what_is_no_hole() {
        let wall = rectangle([0.0, 0.0], [1.0, 1.0]);
        check(&wall, &[rectangle([5.0, 0.5], [1.0, 1.0])], 1);
        check(&wall, &[vec![]], 1);
        let line = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
        assert_eq!(join(&line, 3, &[]), (vec![0, 1, 2], 0));
        assert_eq!(
            join(&[&line[..], &line[..]].concat(), 3, &[3]),
            (vec![0, 1, 2], 1)
        );
    }

    proptest! {
        /// Holes of any convex shape, each in its own cell.
        #[test]
        fn any_holes(
            cells in prop::collection::vec(
                prop::option::of((0.05..0.45f64, prop::collection::vec(0.0..6.2f64, 3..8))),
                12,
            ),
            turn in 0.0..6.2f64,
        ) {
            let mut holes = Vec::new();
            for (i, cell) in cells.iter().enumerate() {
                let Some((radius, angles)) = cell else { continue };
                let mut angles = angles.clone();
                angles.sort_by(f64::total_cmp);
                let thin = angles.windows(2).any(|w| w[1] - w[0] < 0.05);
                let spread = angles[angles.len() - 1] - angles[0];
                prop_assume!(!thin && spread < 6.2 && spread > 0.5);
                let (x, y) = (f64::from(i as u32 % 4) + 0.5, f64::from(i as u32 / 4) + 0.5);
                let corner = |a: &f64| (x + radius * a.cos(), y + radius * a.sin());
                holes.push(angles.iter().map(corner).collect::<Vec<_>>());
            }
            let (sin, cos) = turn.sin_cos();
            let turned = |loop_: &[(f64, f64)]| -> Vec<(f64, f64)> {
                loop_.iter().map(|(x, y)| (cos * x - sin * y, sin * x + cos * y)).collect()
            };
            let outline = turned(&rectangle([0.0, 0.0], [4.0, 3.0]));
            let holes: Vec<_> = holes.iter().map(|h| turned(h)).collect();
            check(&outline, &holes, 0);
        }
    }
}
