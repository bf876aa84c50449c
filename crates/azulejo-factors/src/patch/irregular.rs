//! Regions without a regular pattern: squares inside, triangles between them and the border.
//!
//! The points on the sides are given, because the neighbours share them. A square lattice fills the
//! inside; a constrained Delaunay triangulation joins its outline to the border, and Chew's
//! refinement ("Guaranteed-quality mesh generation for curved surfaces", SoCG 1993; here `spade`'s,
//! with border and lattice kept) adds points where angles are still small, as beside short sides.
//! Lines through the region, where other faces touch it, become edges of patches.

use super::cells::NO_CORNER;
use super::contacts::{Contact, is_inside};
use super::edge_points::EdgePoints;
use super::lines::{LinePoint, Lines};
use super::outline::{Outline, Region, Slot};
use super::ring::{Pieces, Ring, signed_area};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// How far from the border, as a share of the size, a line stops if it may not divide it.
const STOP: f64 = 0.1;

/// An irregular division of one region.
pub(super) struct Irregular {
    /// Pieces of each side.
    pub sides: Vec<u32>,
    /// The region's corners in its plane, about 1 across.
    pub corners: Vec<DVec2>,
    /// Points in the same plane: those of the border in order, then those inside.
    pub points: Vec<DVec2>,
    /// Local points of each patch, counter-clockwise: `squares` of the lattice, then triangles,
    /// whose fourth corner is `NO_CORNER`.
    pub cells: Vec<[u32; 4]>,
    /// How many patches are squares.
    pub squares: usize,
    /// Lattice spacing, or about 1 where there is no lattice.
    pub spacing: f64,
    /// A point of the lattice.
    pub origin: DVec2,
    /// Edges along which other faces touch or cross the region, as pairs of points.
    pub contacts: Vec<[u32; 2]>,
    /// Each point as a mean of three corners of the region.
    pub weights: Vec<[(u32, f64); 3]>,
}

impl Irregular {
    /// Divides a region whose sides are divided by `edge_points` into patches of about `size` (scene
    /// units; infinity for as large as the border allows), none of them across one of `lines`.
    ///
    /// A region no longer than √2 `size`, with undivided sides and without lines, becomes its own
    /// triangles. Where the triangulation fails (a border that touches itself within rounding) each
    /// of the region's triangles is divided about its centre: thin, but without cracks.
    pub fn new(
        outline: &Outline,
        region: &Region,
        edge_points: &EdgePoints,
        lines: Option<&Lines>,
        size: f64,
    ) -> Irregular {
        let (corners, scale) = flatten(outline, region);
        let (slots, own) = (outline.slots_of(region), outline.triangles_of(region));
        let border = Border::new(&corners, slots, edge_points);
        let ring = Ring {
            corners: &corners,
            border: &border.points,
            lines: lines.map(|lines| line_edges(lines, &border, size * scale)),
            size: size * scale,
        };
        let sides = slots.iter().map(|s| edge_points.pieces[s.edge as usize]);
        let sides: Vec<u32> = sides.collect();
        let mesh = ring.divided(&sides, own);
        let mut irregular = Irregular {
            weights: Vec::new(),
            sides,
            points: mesh.points,
            cells: mesh.lattice.squares(mesh.base),
            squares: mesh.lattice.len(),
            spacing: mesh.lattice.spacing,
            origin: mesh.lattice.origin,
            contacts: mesh.contacts,
            corners,
        };
        irregular.add_triangles(mesh.triangles);
        irregular.weights = irregular.corner_weights(slots, edge_points, own);
        irregular
    }

    /// Number of points on the border, which come first.
    pub fn border(&self) -> usize {
        self.sides.iter().map(|&k| k as usize).sum()
    }

    /// Appends the triangles that have an area. Neighbours are close in the numbering, which makes
    /// lookups cache-friendly.
    fn add_triangles(&mut self, mut triangles: Vec<[u32; 3]>) {
        let at = |k: u32| self.points[k as usize];
        triangles.retain(|t| signed_area(t.map(at)) > 0.0);
        let (low, high) = bounds(&self.points);
        let tiles = (triangles.len() as f64 / 32.0).sqrt().ceil();
        let scale = tiles / (high - low).max_element();
        triangles.sort_by_cached_key(|t| {
            let sum: DVec2 = t.iter().map(|&k| at(k)).sum();
            let tile = (sum / 3.0 - low) * scale;
            (tile.y as u32, tile.x as u32)
        });
        let cells = triangles.into_iter().map(|[a, b, c]| [a, b, c, NO_CORNER]);
        self.cells.extend(cells);
    }

    fn corner_weights(
        &self,
        slots: &[Slot],
        edge_points: &EdgePoints,
        own: &[[u32; 3]],
    ) -> Vec<[(u32, f64); 3]> {
        let n = self.corners.len() as u32;
        let mut weights = Vec::with_capacity(self.points.len());
        for (c, slot) in (0..).zip(slots) {
            weights.extend((0..self.sides[c as usize]).map(|i| {
                let share = edge_points.share_on(slot, i);
                let t = if slot.forward { share } else { 1.0 - share };
                [(c, 1.0 - t), ((c + 1) % n, t), (c, 0.0)]
            }));
        }
        let inside = &self.points[self.border()..];
        weights.extend(inside.iter().map(|&p| self.weights_at(p, own)));
        weights
    }

    /// Barycentric weights in the triangle that contains `p`, to within rounding.
    fn weights_at(&self, p: DVec2, own: &[[u32; 3]]) -> [(u32, f64); 3] {
        let mut best = ([0; 3], [1.0, 0.0, 0.0], f64::NEG_INFINITY);
        for &t in own {
            let b = barycentric(t.map(|k| self.corners[k as usize]), p);
            let least = b[0].min(b[1]).min(b[2]);
            if least > best.2 {
                best = (t, b, least);
            }
            if least >= 0.0 {
                break;
            }
        }
        let positive = best.1.map(|w| w.max(0.0));
        let sum: f64 = positive.iter().sum();
        [0, 1, 2].map(|i| (best.0[i], positive[i] / sum))
    }
}

/// Estimated number of patches of [`Irregular::new`], from the region's area and the lengths and
/// piece counts of its sides: squares inside, triangles in a ring somewhat wider than one.
pub(super) fn expected_patches(area: f64, sides: &[(f64, u32)], size: f64) -> f64 {
    let border: f64 = sides.iter().map(|s| f64::from(s.1)).sum();
    if size == f64::INFINITY {
        return border - 2.0;
    }
    let perimeter: f64 = sides.iter().map(|s| s.0).sum();
    let square = size * size;
    let inside = (area - 1.1 * size * perimeter + 4.0 * square).clamp(0.0, area);
    let ring = (area - inside) / (0.36 * square);
    inside / square + ring.max(border - 2.0)
}

/// The corners in the region's plane, the longest side along x, scaled to about 1; and the scale.
pub(super) fn flatten(outline: &Outline, region: &Region) -> (Vec<DVec2>, f64) {
    let frame = PlaneFrame::new(outline, region);
    let slots = outline.slots_of(region);
    let corners = slots.iter().map(|s| frame.flat(s.position)).collect();
    (corners, frame.scale)
}

/// The lines through the region in the same coordinates as [`flatten`].
pub(super) fn flatten_contacts(
    outline: &Outline,
    region: &Region,
    contacts: &[Contact],
) -> Vec<[DVec2; 2]> {
    let frame = PlaneFrame::new(outline, region);
    let inside = contacts.iter().filter(|c| c.inside);
    inside.map(|c| c.ends.map(|p| frame.flat(p))).collect()
}

/// Coordinates in a region's plane.
struct PlaneFrame {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
    scale: f64,
}

impl PlaneFrame {
    fn new(outline: &Outline, region: &Region) -> PlaneFrame {
        let slots = outline.slots_of(region);
        let n = slots.len();
        let side = |k: usize| slots[(k + 1) % n].position - slots[k].position;
        let is_longer = |k: usize, l: usize| side(k).length_squared() > side(l).length_squared();
        let longest = (0..n).fold(0, |best, k| if is_longer(k, best) { k } else { best });
        let x = side(longest).normalize_or_zero();
        PlaneFrame {
            origin: slots[0].position,
            x,
            y: region.normal.cross(x),
            scale: 1.0 / side(longest).length(),
        }
    }

    fn flat(&self, p: DVec3) -> DVec2 {
        let d = p - self.origin;
        DVec2::new(d.dot(self.x), d.dot(self.y)) * self.scale
    }
}

pub(super) fn bounds(points: &[DVec2]) -> (DVec2, DVec2) {
    points
        .iter()
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &p| {
            (low.min(p), high.max(p))
        })
}

/// Point `i` of the side from `a` to `b`, bit-identical for both sides of an edge: where a cut
/// joins a hole to the outline they must coincide.
fn side_point(a: DVec2, b: DVec2, slot: &Slot, edge_points: &EdgePoints, i: u32) -> DVec2 {
    let (from, to) = if slot.forward { (a, b) } else { (b, a) };
    if i == 0 {
        a
    } else {
        from + (to - from) * edge_points.share_on(slot, i)
    }
}

/// The points of lines that are not on the border, and the pieces as pairs of local points: those
/// of the border first, then these.
///
/// A line that ends between two points of the border, where no other face has lines and the border
/// may not be divided, goes to a nearby point, or stops short of the border.
fn line_edges(lines: &Lines, border: &Border, size: f64) -> Pieces {
    let mut points = lines.points.clone();
    let mut stops: HashMap<(u32, u64), u32> = HashMap::new();
    let base = border.points.len() as u32;
    let mut local = |p: LinePoint| match p {
        LinePoint::Inside(k) => base + k,
        LinePoint::Border { side, share } => {
            let (point, inward) = border.at(side as usize, share);
            let nearest = border.nearest(side as usize, share);
            let stop = point + STOP * size * inward;
            let is_near = border.points[nearest as usize].distance(point) <= STOP * size;
            if is_near || !is_inside(border.corners, stop) {
                return nearest;
            }
            *stops.entry((side, share.to_bits())).or_insert_with(|| {
                points.push(stop);
                base + points.len() as u32 - 1
            })
        }
    };
    let edges = lines.edges.iter().map(|e| e.map(&mut local)).collect();
    Pieces { points, edges }
}

/// The divided border of a region.
struct Border<'a> {
    corners: &'a [DVec2],
    slots: &'a [Slot],
    edge_points: &'a EdgePoints,
    points: Vec<DVec2>,
}

impl<'a> Border<'a> {
    fn new(corners: &'a [DVec2], slots: &'a [Slot], edge_points: &'a EdgePoints) -> Border<'a> {
        let n = corners.len();
        let side = |c: usize| {
            let (a, b, slot) = (corners[c], corners[(c + 1) % n], &slots[c]);
            (0..edge_points.pieces[slot.edge as usize])
                .map(move |i| side_point(a, b, slot, edge_points, i))
        };
        Border {
            corners,
            slots,
            edge_points,
            points: (0..n).flat_map(side).collect(),
        }
    }

    /// The point `share` of the way along a side, and the direction from there to the inside.
    fn at(&self, side: usize, share: f64) -> (DVec2, DVec2) {
        let next = (side + 1) % self.corners.len();
        let (a, b) = (self.corners[side], self.corners[next]);
        (a + share * (b - a), (b - a).perp().normalize_or_zero())
    }

    /// The division point of a side that is nearest to `share` of it.
    fn nearest(&self, side: usize, share: f64) -> u32 {
        let pieces = |slot: &Slot| self.edge_points.pieces[slot.edge as usize];
        let before: u32 = self.slots[..side].iter().map(pieces).sum();
        let step = self.edge_points.nearest(&self.slots[side], share);
        (before + step) % self.points.len() as u32
    }
}

fn barycentric([a, b, c]: [DVec2; 3], p: DVec2) -> [f64; 3] {
    let whole = (b - a).perp_dot(c - a);
    let u = (p - a).perp_dot(c - a) / whole;
    let v = (b - a).perp_dot(p - a) / whole;
    [1.0 - u - v, u, v]
}
