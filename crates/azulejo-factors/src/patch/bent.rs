//! Faces that count as flat, but are not so to the last digit: numbers of a file were rounded. The tracer
//! sees their triangles, which lie up to 1e-5 of their diameter in front of or behind their planes. Rays
//! that start on the plane would end on the backs of these triangles.

use super::outline::{Form, Outline, Region};
use glam::DVec3;
use std::collections::HashMap;

/// The triangles of each region that is not exactly flat.
pub(super) type BentRegions = HashMap<u32, Box<[[DVec3; 3]]>>;

/// Distance from the plane, as a share of the diameter, that is not worth a correction: a tenth of what
/// [`Tracer::leaving`](azulejo_trace::Tracer::leaving) steps off a surface of the scene's size.
const UNSEEN: f64 = 1e-7;

/// Finds those of a scene.
pub(super) fn bent_regions(outline: &Outline) -> BentRegions {
    let has_several_triangles =
        |r: &&(u32, &Region)| matches!(r.1.form, Form::Quad | Form::Polygon);
    let regions = (0..).zip(&outline.regions);
    let regions = regions.filter(|r| has_several_triangles(&r) && is_bent(outline, r.1));
    regions
        .map(|(k, region)| (k, triangles(outline, region)))
        .collect()
}

fn is_bent(outline: &Outline, region: &Region) -> bool {
    let slots = outline.slots_of(region);
    let from_first = |k: usize| slots[k].position - slots[0].position;
    let reach = (0..slots.len()).map(|k| from_first(k).length());
    let reach = reach.fold(0.0, f64::max);
    let height = |k: usize| from_first(k).dot(region.normal).abs();
    (0..slots.len()).any(|k| height(k) > UNSEEN * reach)
}

fn triangles(outline: &Outline, region: &Region) -> Box<[[DVec3; 3]]> {
    let slots = outline.slots_of(region);
    let triangles = outline.triangles_of(region).iter();
    let triangles = triangles.map(|t| t.map(|k| slots[k as usize].position));
    triangles.collect()
}

/// The point of one of some triangles from which a position is moved along `normal` alone: of the triangle
/// that it lies deepest in, seen along `normal`.
pub(super) fn onto(triangles: &[[DVec3; 3]], normal: DVec3, position: DVec3) -> DVec3 {
    let depth = |[a, b, c]: &[DVec3; 3]| {
        let weight = |p: &DVec3, q: &DVec3| (*q - *p).cross(position - *p).dot(normal);
        let area = (*b - *a).cross(*c - *a).dot(normal);
        weight(a, b).min(weight(b, c)).min(weight(c, a)) / area
    };
    let deepest = triangles
        .iter()
        .max_by(|s, t| depth(s).total_cmp(&depth(t)));
    let Some(&[a, b, c]) = deepest else {
        return position;
    };
    let own = (b - a).cross(c - a);
    let height = own.dot(a - position) / own.dot(normal);
    if height.is_finite() {
        position + height * normal
    } else {
        position
    }
}
