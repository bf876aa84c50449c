//! Edges at which charts end, because light may change abruptly there.
//!
//! An unwrapper folds a flat chart over an edge of 90° if that saves a cut; the bilinear filter of a
//! viewer then mixes the light of a floor with that of a wall.

use crate::Receiver;
use azulejo_scene::math::Ray;
use azulejo_trace::Tracer;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Shading normals of two faces at a vertex that differ by more than this make a hard edge, degrees.
const HARD: f64 = 5.0;

/// An edge of a triangle by the positions of its ends, in the order of the smaller bits.
pub(crate) type EdgeKey = [[u64; 3]; 2];

/// One side of an edge.
#[derive(Clone, Copy)]
pub(crate) struct EdgeSide {
    pub triangle: u32,
    /// The edge from this corner to the next.
    pub corner: u8,
    /// Whether the triangle has the ends in the order of the key.
    pub is_along: bool,
}

/// The edges of a receiver's triangles: where its surface goes on beyond each.
pub(crate) struct Edges {
    sides: HashMap<EdgeKey, Vec<EdgeSide>>,
}

/// Two triangles that meet at an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgePair {
    /// The triangles, and the corners at which the edge begins in each.
    pub sides: [(u32, u8); 2],
    /// Whether both have it in the same direction, so that their fronts are on different sides.
    pub is_twisted: bool,
    /// Whether more than two triangles meet here.
    pub is_shared_by_more: bool,
}

impl Edges {
    /// The edges of the triangles that are visible.
    pub fn of(receiver: &Receiver, is_visible: &[bool]) -> Edges {
        let key = |v: u32| {
            let p = receiver.positions[v as usize];
            // Negative zero is where zero is.
            (p + 0.0).to_array().map(f64::to_bits)
        };
        let mut sides: HashMap<EdgeKey, Vec<EdgeSide>> = HashMap::new();
        let triangles = receiver.triangles.iter().enumerate();
        for (triangle, corners) in triangles.filter(|(t, _)| is_visible[*t]) {
            for corner in 0..3 {
                let (a, b) = (key(corners[corner]), key(corners[(corner + 1) % 3]));
                let is_along = a <= b;
                let entry = sides.entry(if is_along { [a, b] } else { [b, a] });
                entry.or_default().push(EdgeSide {
                    triangle: triangle as u32,
                    corner: corner as u8,
                    is_along,
                });
            }
        }
        Edges { sides }
    }

    /// Edges at which no two triangles meet.
    pub fn borders(&self) -> Vec<(EdgeKey, EdgeSide)> {
        let of_edge = |(key, sides): (&EdgeKey, &Vec<EdgeSide>)| match sides[..] {
            [side] => Some((*key, side)),
            _ => None,
        };
        self.sides.iter().filter_map(of_edge).collect()
    }

    /// Pairs of triangles that meet at an edge, in the order of the triangles. Of more than two at one edge, each
    /// is in a pair with the next, so that there are no more pairs than triangles have edges.
    pub fn pairs(&self) -> Vec<EdgePair> {
        let mut pairs = Vec::new();
        for sides in self.sides.values() {
            for two in sides.windows(2) {
                pairs.push(EdgePair {
                    sides: [two[0], two[1]].map(|s| (s.triangle, s.corner)),
                    is_twisted: two[0].is_along == two[1].is_along,
                    is_shared_by_more: sides.len() > 2,
                });
            }
        }
        pairs.sort_unstable_by_key(|p| p.sides);
        pairs
    }
}

impl EdgePair {
    /// Whether the two triangles are one smooth surface here: nothing that light does at the edge
    /// keeps a filter from mixing both. `crease` is the largest angle between their normals, degrees.
    pub fn is_smooth(&self, receiver: &Receiver, crease: f64) -> bool {
        if self.is_twisted || self.is_shared_by_more {
            return false;
        }
        let [(a, i), (b, j)] = self.sides;
        if receiver.parts[a as usize] != receiver.parts[b as usize] {
            return false;
        }
        let normal = |t: u32| receiver.area_vector(t as usize).normalize_or_zero();
        is_within(normal(a), normal(b), crease) && !self.is_hard(receiver, (a, i), (b, j))
    }

    /// Whether shading normals differ at either end of the edge, which runs in opposite directions.
    fn is_hard(&self, receiver: &Receiver, a: (u32, u8), b: (u32, u8)) -> bool {
        let normal = |(t, corner): (u32, u8), end: u8| {
            let normals = receiver.normals.get(t as usize);
            normals.map(|n| n[((corner + end) % 3) as usize])
        };
        [(0, 1), (1, 0)]
            .into_iter()
            .any(|(of_a, of_b)| match (normal(a, of_a), normal(b, of_b)) {
                (Some(n), Some(m)) => !is_within(n, m, HARD),
                _ => false,
            })
    }
}

fn is_within(a: DVec3, b: DVec3, degrees: f64) -> bool {
    a.dot(b) >= degrees.to_radians().cos()
}

/// For each triangle which of its edges, from corner k to k + 1, a chart must not cross: creases, and
/// edges on which `tracer` finds something standing.
pub(crate) fn seams(
    receiver: &Receiver,
    is_visible: &[bool],
    crease: f64,
    tracer: Option<&Tracer>,
) -> Vec<[bool; 3]> {
    let pairs = Edges::of(receiver, is_visible).pairs();
    seams_among(&pairs, receiver, crease, tracer)
}

/// The same, of these pairs of its triangles.
pub(crate) fn seams_among(
    pairs: &[EdgePair],
    receiver: &Receiver,
    crease: f64,
    tracer: Option<&Tracer>,
) -> Vec<[bool; 3]> {
    let mut seams = vec![[false; 3]; receiver.triangles.len()];
    let (smooth, creases): (Vec<EdgePair>, Vec<EdgePair>) = pairs
        .iter()
        .partition(|pair| pair.is_smooth(receiver, crease));
    let is_contact =
        |pair: &&EdgePair| tracer.is_some_and(|tracer| pair.is_contact(receiver, tracer));
    let contacts: Vec<EdgePair> = smooth.par_iter().filter(is_contact).copied().collect();
    for (triangle, corner) in creases.iter().chain(&contacts).flat_map(|pair| pair.sides) {
        seams[triangle as usize][corner as usize] = true;
    }
    seams
}

impl EdgePair {
    /// Whether something stands along the edge, on either side of the surface: the way from one triangle to
    /// the other is not free.
    fn is_contact(&self, receiver: &Receiver, tracer: &Tracer) -> bool {
        let [(a, i), (b, _)] = self.sides;
        let corners = receiver.corners(a as usize);
        let (start, end) = (corners[usize::from(i)], corners[usize::from(i + 1) % 3]);
        let along = end - start;
        let flat = |t: u32| receiver.area_vector(t as usize).normalize_or_zero();
        // From the edge into each of them.
        let into = [flat(a).cross(along), -flat(b).cross(along)].map(|d| d.normalize_or_zero());
        let height = |t: u32| 2.0 * receiver.area_vector(t as usize).length() / along.length();
        let step = f64::min(
            NEAR_LENGTH * along.length(),
            NEAR_HEIGHT * height(a).min(height(b)),
        );
        let is_blocked = |share: f64, side: f64| {
            let on = start + share * along;
            let [from, to] = [(into[0], flat(a)), (into[1], flat(b))].map(|(into, normal)| {
                let up = side * normal;
                tracer.leaving(on + step * into, up) + 0.5 * step * up
            });
            tracer.occluded(&Ray::between(from, to))
        };
        [1.0, -1.0].into_iter().any(|side| {
            let blocked = ALONG.iter().filter(|&&share| is_blocked(share, side));
            2 * blocked.count() > ALONG.len()
        })
    }
}

/// Places along an edge at which the way across it is tested.
const ALONG: [f64; 3] = [0.2, 0.5, 0.8];

/// How far from the edge, as a share of its length, and of the height of the lower triangle.
const NEAR_LENGTH: f64 = 0.02;
const NEAR_HEIGHT: f64 = 0.1;
