//! Charts that are too near one another for the filters of viewers.

use super::grid::{BoxGrid, PageBox};
use super::{AtlasCheck, CheckedTriangle};
use glam::DVec2;
use rayon::prelude::*;

/// How much nearer charts may be for rounding, texels.
const ROUNDING: f64 = 1e-3;

/// Edges that are found near one, at most.
const MOST_NEAR: usize = 16;

/// An edge of a triangle at the border of its chart.
struct BorderEdge {
    triangle: usize,
    ends: [DVec2; 2],
}

/// Finds charts whose borders are nearer than `gap` texels.
pub(super) fn find(triangles: &[CheckedTriangle], gap: f64, found: &mut AtlasCheck) {
    let mut edges = Vec::new();
    for (number, triangle) in triangles.iter().enumerate().filter(|(_, t)| t.is_placed) {
        let is_border = |k: &usize| triangle.is_border[*k];
        edges.extend((0..3).filter(is_border).map(|k| BorderEdge {
            triangle: number,
            ends: [triangle.corners[k], triangle.corners[(k + 1) % 3]],
        }));
    }
    let of = |e: &BorderEdge| &triangles[e.triangle];
    let boxed = |e: &BorderEdge| PageBox::around(of(e).page, &e.ends);
    let grid = BoxGrid::new(edges.iter().map(boxed).collect(), gap);
    let of_one = |number: usize| {
        let (edge, mut list) = (&edges[number], Vec::new());
        let is_complete = grid.near(number as u32, |other| {
            let other = &edges[other as usize];
            if of(edge).chart != of(other).chart {
                let distance = distance(edge.ends, other.ends);
                if distance < gap - ROUNDING {
                    list.push((edge.triangle, distance));
                    list.push((other.triangle, distance));
                }
            }
            list.len() < 2 * MOST_NEAR
        });
        (list, is_complete)
    };
    let all: Vec<(Vec<(usize, f64)>, bool)> = (0..edges.len())
        .into_par_iter()
        .map(of_one)
        .filter(|(list, is_complete)| !list.is_empty() || !is_complete)
        .collect();
    found.is_complete &= all.iter().all(|(_, is_complete)| *is_complete);
    let mut nearest: Vec<Option<(f64, usize)>> = vec![None; found.charts];
    for &(triangle, distance) in all.iter().flat_map(|(list, _)| list) {
        let of_chart = &mut nearest[triangles[triangle].chart as usize];
        if of_chart.is_none_or(|known| (distance, triangle) < known) {
            *of_chart = Some((distance, triangle));
        }
    }
    // The worst is the nearest.
    for (distance, triangle) in nearest.into_iter().flatten() {
        found.near.add(-distance, triangles[triangle].id);
    }
    found.near.amount = 0.0 - found.near.amount;
}

/// Distance of two segments.
fn distance(a: [DVec2; 2], b: [DVec2; 2]) -> f64 {
    let side = |[from, to]: [DVec2; 2], p: DVec2| (to - from).perp_dot(p - from);
    let is_crossed = |s: [DVec2; 2], t: [DVec2; 2]| side(s, t[0]) * side(s, t[1]) < 0.0;
    if is_crossed(a, b) && is_crossed(b, a) {
        return 0.0;
    }
    let to_segment = |p: DVec2, [from, to]: [DVec2; 2]| {
        let along = to - from;
        let length = along.length_squared();
        let t = if length > 0.0 {
            ((p - from).dot(along) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        p.distance(from + t * along)
    };
    let all = [
        to_segment(a[0], b),
        to_segment(a[1], b),
        to_segment(b[0], a),
        to_segment(b[1], a),
    ];
    all.into_iter().fold(f64::INFINITY, f64::min)
}
