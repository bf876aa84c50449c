//! Triangles that lie over one another.

use super::grid::{BoxGrid, PageBox};
use super::{AtlasCheck, CheckedTriangle};
use crate::coverage::{COORDINATE_ROUNDING, area_and_centre, half};
use crate::layout::Layout;
use glam::DVec2;
use rayon::prelude::*;

/// Share of the smaller triangle above which two overlap.
const LEAST_SHARE: f64 = 1e-6;

/// Other triangles that are found for one, at most: more say nothing new.
const MOST_PARTNERS: usize = 16;

/// Two triangles that overlap, and the share of the smaller one.
type Overlap = (usize, usize, f64);

/// Finds the triangles that overlap.
pub(super) fn find(triangles: &[CheckedTriangle], layout: &Layout, found: &mut AtlasCheck) {
    let placed: Vec<usize> = (0..triangles.len())
        .filter(|&t| triangles[t].is_placed && triangles[t].texels != 0.0)
        .collect();
    let boxed = |&t: &usize| PageBox::around(triangles[t].page, &triangles[t].corners);
    let grid = BoxGrid::new(placed.iter().map(boxed).collect(), 0.0);
    let of_one = |k: usize| {
        let (mut list, own) = (Vec::new(), placed[k]);
        let is_complete = grid.near(k as u32, |other| {
            let other = placed[other as usize];
            let rounding = rounding(&triangles[own], layout);
            if let Some(share) = share(&triangles[own], &triangles[other], rounding) {
                list.push((own, other, share));
            }
            list.len() < MOST_PARTNERS
        });
        (list, is_complete)
    };
    let all: Vec<(Vec<Overlap>, bool)> = (0..placed.len())
        .into_par_iter()
        .map(of_one)
        .filter(|(list, is_complete)| !list.is_empty() || !is_complete)
        .collect();
    found.is_complete &= all.iter().all(|(_, is_complete)| *is_complete);
    let mut worst = vec![0.0f64; triangles.len()];
    for &(a, b, share) in all.iter().flat_map(|(list, _)| list) {
        worst[a] = worst[a].max(share);
        worst[b] = worst[b].max(share);
    }
    for (triangle, share) in triangles.iter().zip(worst).filter(|(_, s)| *s > 0.0) {
        found.overlaps.add(share, triangle.id);
    }
}

/// How far rounding moves the corners of a triangle, texels.
fn rounding(of: &CheckedTriangle, layout: &Layout) -> f64 {
    let size = layout.pages.get(of.page as usize).copied();
    let [width, height] = size.unwrap_or([1; 2]);
    COORDINATE_ROUNDING * f64::from(width.max(height))
}

/// What two triangles share, as a part of the smaller one, if that is more than `rounding` makes.
fn share(a: &CheckedTriangle, b: &CheckedTriangle, rounding: f64) -> Option<f64> {
    let (a_turned, b_turned) = (turned(a), turned(b));
    if is_apart(&a_turned, &b_turned) || is_apart(&b_turned, &a_turned) {
        return None;
    }
    let mut common = a_turned.to_vec();
    for k in 0..3 {
        let (from, to) = (b_turned[k], b_turned[(k + 1) % 3]);
        common = half(&common, |p| (to - from).perp_dot(p - from));
    }
    let area = area_and_centre(&common).0;
    let least = a.texels.abs().min(b.texels.abs());
    let extent = |c: &[DVec2; 3]| {
        let edges = [c[1] - c[0], c[2] - c[1], c[0] - c[2]];
        edges.iter().map(|e| e.length()).fold(0.0, f64::max)
    };
    let seam = rounding * extent(&a_turned).min(extent(&b_turned));
    let share = area / least;
    (share > LEAST_SHARE && area > seam).then_some(share.min(1.0))
}

/// The corners in the order in which the area is positive.
fn turned(triangle: &CheckedTriangle) -> [DVec2; 3] {
    let [a, b, c] = triangle.corners;
    if triangle.texels > 0.0 {
        [a, b, c]
    } else {
        [a, c, b]
    }
}

/// Whether a triangle lies on the outer side of an edge of another.
fn is_apart(of: &[DVec2; 3], other: &[DVec2; 3]) -> bool {
    (0..3).any(|k| {
        let (from, to) = (of[k], of[(k + 1) % 3]);
        other.iter().all(|&p| (to - from).perp_dot(p - from) <= 0.0)
    })
}
