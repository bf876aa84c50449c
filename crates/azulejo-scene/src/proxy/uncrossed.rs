//! Straight edges divided where they cross, at points of a grid.
//!
//! Hobby, *Practical segment intersection with finite precision output* (1999), in a simple form: points where edges cross
//! are rounded, which bends the edges a little, and what crosses then is divided again.

use super::flat_figure::Strips;
use glam::DVec2;

/// How often edges are divided; after the second time hardly any cross.
const ROUNDS: u32 = 6;
/// Most pairs of edges that are compared in a round, and most points where they cross; more are not divided.
const MOST_PAIRS: usize = 1 << 24;
const MOST_CUTS: usize = 1 << 16;

/// Edges between points of a grid, divided so that they do not cross, but for those beyond the limits. `grid` is the distance
/// of its points, at least 2⁻²⁵ for coordinates up to 1: so which side of an edge a point is on is exact.
pub(super) fn uncrossed(mut edges: Vec<[DVec2; 2]>, grid: f64) -> Vec<[DVec2; 2]> {
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
    let side = |k: u32, f: fn(f64, f64) -> f64| f(edges[k as usize][0].x, edges[k as usize][1].x);
    let mut cuts = Vec::new();
    let mut left = MOST_PAIRS;
    for list in strips.lists() {
        let mut list = list.clone();
        list.sort_by(|a, b| side(*a, f64::min).total_cmp(&side(*b, f64::min)));
        for (i, a) in list.iter().enumerate() {
            let end = side(*a, f64::max);
            let near = list[i + 1..]
                .iter()
                .take_while(|b| side(**b, f64::min) <= end);
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
    let of_line = |p: DVec2| (b - a).perp_dot(p - a);
    let (at_c, at_d) = (of_line(c), of_line(d));
    if apart || at_c * at_d >= 0.0 {
        return None;
    }
    let of_other = |p: DVec2| (d - c).perp_dot(p - c);
    let divides = of_other(a) * of_other(b) < 0.0;
    divides.then(|| c + at_c / (at_c - at_d) * (d - c))
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
