//! What is left of surfaces without their openings.

use crate::reading::options::{Budget, Exhausted};
use crate::surface::cut::{MOST_HOLES, without};
use crate::surface::holes::join;
use crate::surface::mean_plane::{MeanPlane, edges};
use azulejo_scene::Mesh;
use azulejo_scene::math::Frame;
use glam::{DVec2, DVec3};

/// Distances below this, relative to the size of a surface, are none.
const TOLERANCE: f64 = 1e-6;

/// Parts of the area of a surface below which areas are equal.
const SAME_AREA: f64 = 1e-4;

/// A surface without its openings.
#[derive(Debug, Default)]
pub(super) struct CutSurface {
    /// Polygons with the orientation of the surface.
    pub faces: Vec<Vec<DVec3>>,
    /// Whether openings overlap each other, or lie beside the surface.
    pub has_overlaps: bool,
    /// Whether corners of openings lie outside of its plane.
    pub has_distant_openings: bool,
}

/// Why a surface could not be cut.
#[derive(Debug)]
pub(super) enum CutFailure {
    /// There are too many openings, or they overlap too much.
    TooComplex,
    /// The budget does not suffice.
    Exhausted(Exhausted),
}

impl From<Exhausted> for CutFailure {
    fn from(exhausted: Exhausted) -> CutFailure {
        CutFailure::Exhausted(exhausted)
    }
}

/// Cuts openings out of a surface: as holes where they lie inside and apart; otherwise, as with a door
/// that reaches the floor, what is left consists of convex pieces.
pub(super) fn cut(
    outline: &[DVec3],
    openings: &[&[DVec3]],
    budget: &mut Budget,
) -> Result<CutSurface, CutFailure> {
    let plane = MeanPlane::of(outline);
    let corners: u64 = openings.iter().map(|o| o.len() as u64).sum();
    budget.spend(2 * (outline.len() as u64 + corners))?;
    let mut cut = CutSurface::default();
    if openings.is_empty() || plane.normal == DVec3::ZERO {
        cut.faces.push(outline.to_vec());
        return Ok(cut);
    }
    let within = TOLERANCE * plane.radius;
    let mut onto_plane = |p: &DVec3| {
        let height = plane.height(*p);
        cut.has_distant_openings |= height.abs() > within;
        // What lies in the plane keeps its coordinates, so that edges coincide with those of windows.
        if height.abs() > 1e-3 * within {
            *p - height * plane.normal
        } else {
            *p
        }
    };
    let holes = openings.iter();
    let holes: Vec<Vec<DVec3>> = holes
        .map(|hole| hole.iter().map(&mut onto_plane).collect())
        .collect();
    // Each edge is compared with all others.
    let edges = corners * (outline.len() as u64 + corners);
    budget.spend(edges / 8)?;
    if are_apart(outline, &holes, plane.normal, within) {
        cut.faces.push(with_holes(outline, &holes));
    } else {
        cut.faces = pieces(outline, &holes, budget)?;
    }
    let removed = plane.area - area(&cut.faces);
    cut.has_overlaps = removed < area(&holes) - SAME_AREA * plane.area;
    Ok(cut)
}

fn area(polygons: &[Vec<DVec3>]) -> f64 {
    polygons.iter().map(|p| MeanPlane::of(p).area).sum()
}

/// One loop around the surface and its holes.
fn with_holes(outline: &[DVec3], holes: &[Vec<DVec3>]) -> Vec<DVec3> {
    let points: Vec<DVec3> = outline
        .iter()
        .chain(holes.iter().flatten())
        .copied()
        .collect();
    let counts: Vec<usize> = holes.iter().map(Vec::len).collect();
    let (order, _) = join(&points, outline.len(), &counts);
    order.into_iter().map(|k| points[k]).collect()
}

/// Whether all holes lie inside of the outline, no edge within `distance` of those of others.
fn are_apart(outline: &[DVec3], holes: &[Vec<DVec3>], normal: DVec3, distance: f64) -> bool {
    let frame = Frame::from_normal(normal);
    let flat = |polygon: &[DVec3]| -> Vec<DVec2> {
        let corners = polygon.iter();
        corners
            .map(|&p| frame.to_local(p - outline[0]).truncate())
            .collect()
    };
    let border = flat(outline);
    let holes: Vec<Vec<DVec2>> = holes.iter().map(|hole| flat(hole)).collect();
    let others = |k: usize| holes[..k].iter().chain([&border]);
    holes.iter().enumerate().all(|(k, hole)| {
        let is_inside = surrounds(&border, hole[0]);
        let inside_another =
            |other: &Vec<DVec2>| surrounds(other, hole[0]) || surrounds(hole, other[0]);
        let is_free = !holes[..k].iter().any(inside_another);
        is_inside && is_free && others(k).all(|other| keep_apart(hole, other, distance))
    })
}

/// Whether a point is inside of a polygon.
fn surrounds(polygon: &[DVec2], p: DVec2) -> bool {
    let crossings = sides(polygon).filter(|(a, b)| {
        let x = a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x);
        (a.y <= p.y) != (b.y <= p.y) && x > p.x
    });
    crossings.count() % 2 == 1
}

fn sides(polygon: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().copied().zip(next.copied())
}

/// Whether no edge of a polygon comes near an edge of another one.
fn keep_apart(polygon: &[DVec2], other: &[DVec2], distance: f64) -> bool {
    let mut pairs = sides(polygon).flat_map(|side| sides(other).map(move |o| (side, o)));
    pairs.all(|((a, b), (c, d))| {
        let ends = [(a, c, d), (b, c, d), (c, a, b), (d, a, b)];
        let is_near = |&(p, a, b): &(DVec2, DVec2, DVec2)| to_segment(p, a, b) <= distance;
        !ends.iter().any(is_near) && !cross(a, b, c, d)
    })
}

/// The distance of a point from a segment.
fn to_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let ab = b - a;
    let length = ab.length_squared();
    let t = if length > 0.0 {
        ((p - a).dot(ab) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    p.distance(a + t * ab)
}

fn cross(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let side = |a: DVec2, b: DVec2, p: DVec2| (b - a).perp_dot(p - a) > 0.0;
    side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b)
}

/// What is left, in convex pieces.
fn pieces(
    outline: &[DVec3],
    holes: &[Vec<DVec3>],
    budget: &mut Budget,
) -> Result<Vec<Vec<DVec3>>, CutFailure> {
    let holes: Vec<Vec<DVec3>> = holes.iter().flat_map(|hole| convex(hole)).collect();
    if holes.len() > MOST_HOLES {
        return Err(CutFailure::TooComplex);
    }
    let mut left = Vec::new();
    for part in convex(outline) {
        let count = holes.len() as u64;
        budget.spend(count * count)?;
        left.extend(without(&part, &holes).ok_or(CutFailure::TooComplex)?);
    }
    budget.spend(left.iter().map(|p| 2 * p.len() as u64).sum())?;
    Ok(left)
}

/// A polygon in convex parts: itself, or its triangles.
fn convex(polygon: &[DVec3]) -> Vec<Vec<DVec3>> {
    if MeanPlane::is_flat_and_convex(polygon, TOLERANCE) && edges(polygon).count() > 2 {
        return vec![polygon.to_vec()];
    }
    let mut mesh = Mesh {
        positions: polygon.to_vec(),
        ..Mesh::default()
    };
    let corners: Vec<u32> = (0..polygon.len() as u32).collect();
    mesh.push_face(&corners, 0);
    let triangles = mesh.triangulate(0).into_iter();
    triangles
        .map(|t| t.map(|k| polygon[k as usize]).to_vec())
        .collect()
}
