//! Straight edges divided where they cross, at points of a grid.
//!
//! Hobby, *Practical segment intersection with finite precision output* (1999), in a simple form: points where edges cross
//! are rounded, which bends the edges a little, and what crosses then is divided again.
//!
//! spade can divide edges by itself, but stops with a failed assertion where many cross almost in one place (2.15.1).

use super::flat_figure::{Delaunay, Strips, key, point};
use glam::DVec2;
use robust::{Coord, orient2d};
use spade::handles::FixedVertexHandle;
use spade::{Point2, Triangulation};
use std::collections::HashMap;

/// How often edges are divided; after the second time hardly any cross.
const ROUNDS: u32 = 6;
/// Most pairs of edges that are compared in a round, and most points where they cross; more are not divided.
const MOST_PAIRS: usize = 1 << 24;
const MOST_CUTS: usize = 1 << 16;

/// Adds edges to a triangulation, divided where they cross each other, at points of a grid of the distance `grid`.
pub(super) fn add_edges(mesh: &mut Delaunay, edges: Vec<[DVec2; 2]>, grid: f64) {
    add_whole_edges(mesh, &uncrossed(edges, grid));
}

/// Adds those edges to a triangulation that cross none that it has.
pub(super) fn add_whole_edges(mesh: &mut Delaunay, edges: &[[DVec2; 2]]) {
    let vertices = mesh.vertices().map(|v| (key(point(v.position())), v.fix()));
    let vertices: HashMap<_, FixedVertexHandle> = vertices.collect();
    // All points come first: one beside an edge that is there already would not divide it.
    let mut vertex = |p: DVec2| {
        let known = vertices.get(&key(p)).copied();
        known.or_else(|| mesh.insert(Point2::new(p.x, p.y)).ok())
    };
    let ends: Vec<_> = edges.iter().map(|ends| ends.map(&mut vertex)).collect();
    for ends in ends {
        if let [Some(from), Some(to)] = ends {
            mesh.try_add_constraint(from, to);
        }
    }
}

/// Edges divided so that they do not cross, but for those beyond the limits. `grid` is the distance of the points where
/// they are.
fn uncrossed(mut edges: Vec<[DVec2; 2]>, grid: f64) -> Vec<[DVec2; 2]> {
    for _ in 0..ROUNDS {
        let cuts = cuts(&edges, grid);
        let is_whole = cuts.len() < MOST_CUTS;
        if cuts.is_empty() {
            break;
        }
        edges = divided(&edges, cuts);
        if !is_whole {
            break;
        }
    }
    edges
}

/// Where an edge is cut.
type EdgeCut = (u32, DVec2);

/// The rounded points where edges cross.
fn cuts(edges: &[[DVec2; 2]], grid: f64) -> Vec<EdgeCut> {
    let strips = Strips::new(edges.to_vec());
    let reach = |k: u32, f: fn(f64, f64) -> f64| f(edges[k as usize][0].x, edges[k as usize][1].x);
    let mut cuts = Vec::new();
    let mut left = MOST_PAIRS;
    for list in strips.lists() {
        let mut list = list.clone();
        list.sort_by(|a, b| reach(*a, f64::min).total_cmp(&reach(*b, f64::min)));
        for (i, a) in list.iter().enumerate() {
            let end = reach(*a, f64::max);
            let near = list[i + 1..]
                .iter()
                .take_while(|b| reach(**b, f64::min) <= end);
            for b in near {
                left -= 1;
                if left == 0 || cuts.len() >= MOST_CUTS {
                    return cuts;
                }
                let pair = [edges[*a as usize], edges[*b as usize]];
                if let Some(point) = crossing(pair) {
                    let point = (point / grid).round() * grid;
                    for (k, edge) in [a, b].into_iter().zip(pair) {
                        if !edge.contains(&point) {
                            cuts.push((*k, point));
                        }
                    }
                }
            }
        }
    }
    cuts
}

/// The point where two edges cross that do not just touch.
fn crossing([[a, b], [c, d]]: [[DVec2; 2]; 2]) -> Option<DVec2> {
    let apart = a.y.max(b.y) < c.y.min(d.y) || c.y.max(d.y) < a.y.min(b.y);
    if apart {
        return None;
    }
    let (at_c, at_d) = (side(a, b, c), side(a, b, d));
    let is_divided = |s: f64, t: f64| s.min(t) < 0.0 && s.max(t) > 0.0;
    let crosses = is_divided(at_c, at_d) && is_divided(side(c, d, a), side(c, d, b));
    crosses.then(|| c + at_c / (at_c - at_d) * (d - c))
}

/// Twice the area of a triangle, > 0 where `p` is left of the line from `a` to `b`, with an exact sign.
fn side(a: DVec2, b: DVec2, p: DVec2) -> f64 {
    let [a, b, p] = [a, b, p].map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, p)
}

/// The pieces of edges between their cuts.
fn divided(edges: &[[DVec2; 2]], mut cuts: Vec<EdgeCut>) -> Vec<[DVec2; 2]> {
    let along = |(k, p): &EdgeCut| {
        let [a, b] = edges[*k as usize];
        (*p - a).dot(b - a)
    };
    cuts.sort_by(|a, b| a.0.cmp(&b.0).then(along(a).total_cmp(&along(b))));
    let mut cuts = cuts.into_iter().peekable();
    let mut pieces = Vec::with_capacity(edges.len());
    for (k, [start, end]) in (0..).zip(edges) {
        let mut from = *start;
        while let Some((_, point)) = cuts.next_if(|(of, _)| *of == k) {
            if point != from {
                pieces.push([from, point]);
                from = point;
            }
        }
        if from != *end {
            pieces.push([from, *end]);
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines through a square from side to side, at points of a grid.
    #[test]
    fn edges_end_where_they_cross() {
        const GRID: f64 = 1.0 / 1024.0;
        let place = |k: u32, m: u32| f64::from(k * m % 1024) * GRID;
        let edge = |k: u32| {
            [
                DVec2::new(place(k, 37), 0.0),
                DVec2::new(place(k, 731), 1.0),
            ]
        };
        let edges: Vec<_> = (0..40).map(edge).collect();
        let pieces = uncrossed(edges.clone(), GRID);
        assert!(pieces.len() > 10 * edges.len(), "{}", pieces.len());
        for (k, a) in pieces.iter().enumerate() {
            for b in &pieces[..k] {
                assert_eq!(crossing([*a, *b]), None, "{a:?} {b:?}");
            }
        }
        let length = |edges: &[[DVec2; 2]]| edges.iter().map(|[a, b]| a.distance(*b)).sum::<f64>();
        let change = length(&pieces) / length(&edges) - 1.0;
        assert!(change.abs() < 1e-2, "{change}");
        let once = uncrossed(pieces.clone(), GRID);
        assert_eq!(once, pieces);
    }
}
