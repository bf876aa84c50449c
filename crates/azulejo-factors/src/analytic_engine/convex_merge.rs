//! Coplanar polygons that share edges, joined into larger convex ones.
//!
//! A table top of a thousand patches casts one shadow. Polygons grow across whole common edges as
//! long as they stay convex: rows of a grid first, then rows of rows. The rest stays as it is, so
//! the result covers the same points, with no more polygons than before.

use azulejo_scene::math::area_vector;
use glam::DVec3;
use std::collections::{HashMap, HashSet};

/// Relative to the size of the scene, coordinates closer than this are the same.
const SAME: f64 = 1e-9;

/// A polygon joined from others.
pub(super) struct ConvexPolygon {
    pub polygon: Vec<DVec3>,
    /// The closed surface that it is part of, if all of it belongs to one.
    pub surface: Option<u32>,
    /// One of the polygons that it was joined from.
    pub first: usize,
}

/// Convex polygons that together cover the same points as the convex `polygons`, and for each of
/// `polygons` the closed surface that it is part of, if any.
///
/// Polygons with the same number in `planes` are coplanar. Corners closer than `graze` to a straight line
/// lie on it.
pub(super) fn merged(
    polygons: &[Vec<DVec3>],
    planes: &[u32],
    size: f64,
    graze: f64,
) -> (Vec<ConvexPolygon>, Vec<Option<u32>>) {
    let mut mesh = Mesh::new(polygons, planes, size, graze);
    let surfaces = closed_surfaces(&mesh.loops);
    loop {
        let before = mesh.alive;
        (0..mesh.loops.len()).for_each(|k| mesh.grow(k));
        if mesh.alive == before {
            break;
        }
    }
    let joined = |(k, ring): (usize, &Vec<u32>)| ConvexPolygon {
        polygon: ring.iter().map(|&v| mesh.vertices[v as usize]).collect(),
        surface: surfaces[k],
        first: k,
    };
    let rings = mesh.loops.iter().enumerate();
    let joined = rings.filter(|(_, r)| !r.is_empty()).map(joined).collect();
    (joined, surfaces)
}

/// For each polygon the number of its surface, if that is closed: if all its edges are shared by
/// two polygons with the same orientation.
fn closed_surfaces(loops: &[Vec<u32>]) -> Vec<Option<u32>> {
    let mut owner: HashMap<(u32, u32), u32> = HashMap::new();
    let mut parents: Vec<u32> = (0..loops.len() as u32).collect();
    let mut is_open = vec![false; loops.len()];
    let edges = |k: usize| {
        let ring = &loops[k];
        (0..ring.len()).map(move |i| (ring[i], ring[(i + 1) % ring.len()]))
    };
    for (k, is_open) in is_open.iter_mut().enumerate() {
        for edge in edges(k) {
            // An edge that two polygons run along in the same direction does not separate inside
            // from outside.
            let other = owner.insert(edge, k as u32);
            *is_open |= other.is_some_and(|other| other != k as u32);
        }
    }
    for (k, is_open) in is_open.iter_mut().enumerate() {
        for (a, b) in edges(k) {
            match owner.get(&(b, a)) {
                Some(&mate) => {
                    let (mate, own) = (root(&mut parents, mate), root(&mut parents, k as u32));
                    parents[mate.max(own) as usize] = mate.min(own);
                }
                None => *is_open = true,
            }
        }
    }
    let roots: Vec<u32> = (0..loops.len() as u32)
        .map(|k| root(&mut parents, k))
        .collect();
    let open: HashSet<u32> = (0..loops.len())
        .filter(|&k| is_open[k])
        .map(|k| roots[k])
        .collect();
    roots
        .iter()
        .map(|r| (!open.contains(r)).then_some(*r))
        .collect()
}

/// The representative of a set, in a union-find forest with path halving.
fn root(parents: &mut [u32], mut k: u32) -> u32 {
    while parents[k as usize] != k {
        parents[k as usize] = parents[parents[k as usize] as usize];
        k = parents[k as usize];
    }
    k
}

struct Mesh<'a> {
    vertices: Vec<DVec3>,
    /// Corners of each polygon; empty once it has been joined to another.
    loops: Vec<Vec<u32>>,
    normals: Vec<DVec3>,
    /// The last polygon that had each directed edge.
    edges: HashMap<(u32, u32), u32>,
    alive: usize,
    /// The plane of each polygon.
    planes: &'a [u32],
    /// Distance from a straight line that does not count.
    rounding: f64,
}

impl<'a> Mesh<'a> {
    fn new(polygons: &[Vec<DVec3>], planes: &'a [u32], size: f64, graze: f64) -> Mesh<'a> {
        let cell = (SAME * size).max(f64::MIN_POSITIVE);
        let mut numbers: HashMap<[i64; 3], u32> = HashMap::new();
        let mut vertices = Vec::new();
        let mut number = |p: DVec3| {
            let key = (p / cell).round().to_array().map(|x| x as i64);
            *numbers.entry(key).or_insert_with(|| {
                vertices.push(p);
                vertices.len() as u32 - 1
            })
        };
        let ring = |p: &Vec<DVec3>| p.iter().map(|&c| number(c)).collect();
        let loops: Vec<Vec<u32>> = polygons.iter().map(ring).collect();
        let normals = polygons.iter().map(|p| area_vector(p).normalize_or_zero());
        let mut mesh = Mesh {
            normals: normals.collect(),
            alive: loops.len(),
            loops,
            vertices,
            edges: HashMap::new(),
            planes,
            rounding: cell.max(graze),
        };
        (0..mesh.loops.len()).for_each(|k| mesh.note_edges(k));
        mesh
    }

    fn note_edges(&mut self, k: usize) {
        let ring = &self.loops[k];
        for (i, &v) in ring.iter().enumerate() {
            self.edges.insert((v, ring[(i + 1) % ring.len()]), k as u32);
        }
    }

    /// Joins polygon `k` with neighbours as long as possible.
    fn grow(&mut self, k: usize) {
        let mut i = 0;
        while i < self.loops[k].len() {
            if self.join(k, i) {
                i = 0;
            } else {
                i += 1;
            }
        }
    }

    /// Joins polygon `k` with the one across its edge `i`, if their union is convex.
    fn join(&mut self, k: usize, i: usize) -> bool {
        let ring = &self.loops[k];
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        let Some(&other) = self.edges.get(&(b, a)) else {
            return false;
        };
        let other = other as usize;
        let mate = &self.loops[other];
        let Some(j) = mate.iter().position(|&v| v == b) else {
            return false;
        };
        if other == k || mate[(j + 1) % mate.len()] != a || !self.is_coplanar(k, other) {
            return false;
        }
        // All of this polygon from b around to a, then the other's corners between a and b.
        let own = (0..ring.len()).map(|s| ring[(i + 1 + s) % ring.len()]);
        let rest = (2..mate.len()).map(|s| mate[(j + s) % mate.len()]);
        let joined: Vec<u32> = own.chain(rest).collect();
        let Some(joined) = self.convex(&joined, self.normals[k]) else {
            return false;
        };
        self.loops[other].clear();
        self.loops[k] = joined;
        self.alive -= 1;
        self.note_edges(k);
        true
    }

    fn is_coplanar(&self, k: usize, other: usize) -> bool {
        self.planes[k] == self.planes[other] && self.normals[k].dot(self.normals[other]) > 0.0
    }

    /// The ring without corners on straight edges; `None` if it is not convex.
    fn convex(&self, ring: &[u32], normal: DVec3) -> Option<Vec<u32>> {
        let mut kept = Vec::with_capacity(ring.len());
        for (i, &v) in ring.iter().enumerate() {
            let [a, b, c] = [
                ring[(i + ring.len() - 1) % ring.len()],
                v,
                ring[(i + 1) % ring.len()],
            ]
            .map(|v| self.vertices[v as usize]);
            let turn = (b - a).cross(c - b).dot(normal);
            // Distance of b from the line from a to c.
            let least = self.rounding * (c - a).length();
            if turn < -least || (b - a).dot(c - b) < 0.0 && turn.abs() <= least {
                return None;
            }
            if turn > least {
                kept.push(v);
            }
        }
        (kept.len() > 2).then_some(kept)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    fn grid(n: u32, keep: impl Fn(u32, u32) -> bool) -> Vec<Vec<DVec3>> {
        let p = |i: u32, j: u32| dvec3(f64::from(i) / 7.0, f64::from(j) / 3.0, 0.25);
        let cells = (0..n * n)
            .map(|k| (k % n, k / n))
            .filter(|&(i, j)| keep(i, j));
        cells
            .map(|(i, j)| vec![p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1)])
            .collect()
    }

    fn check(polygons: &[Vec<DVec3>], count: usize) {
        let (joined, _) = merged(polygons, &vec![0; polygons.len()], 3.0, 0.0);
        let joined: Vec<Vec<DVec3>> = joined.into_iter().map(|j| j.polygon).collect();
        let area = |all: &[Vec<DVec3>]| all.iter().map(|p| area_vector(p)).sum::<DVec3>();
        assert_eq!(joined.len(), count);
        assert!(area(polygons).distance(area(&joined)) < 1e-12);
    }

    #[test]
    fn grids_become_rectangles() {
        check(&grid(5, |_, _| true), 1);
        check(&grid(5, |i, j| i < 2 || j < 2), 2);
        check(&grid(5, |i, j| (i, j) != (2, 2)), 4);
        let square = grid(1, |_, _| true).remove(0);
        let halves = [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| square[k]).to_vec());
        check(&halves, 1);
        // Back to back they are separate.
        let back: Vec<DVec3> = square.iter().rev().copied().collect();
        check(&[square, back], 2);
    }

    #[test]
    fn tetrahedra_are_closed_and_cups_are_not() {
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|f| f.map(|k| p[k]).to_vec());
        let far = |face: &Vec<DVec3>| face.iter().map(|&c| c + 5.0 * DVec3::X).collect();
        let mut all = faces.to_vec();
        all.extend(faces[..3].iter().map(far));
        let (_, surfaces) = merged(&all, &[0, 1, 2, 3, 4, 5, 6], 6.0, 0.0);
        let closed = [0; 4].map(Some).into_iter().chain([None; 3]);
        assert_eq!(surfaces, closed.collect::<Vec<_>>());
        // Back to back, two sheets share their edges but enclose nothing.
        let sheet = faces[0].clone();
        let back = sheet.iter().rev().copied().collect();
        assert_eq!(merged(&[sheet, back], &[0, 0], 6.0, 0.0).1, [Some(0); 2]);
    }
}
