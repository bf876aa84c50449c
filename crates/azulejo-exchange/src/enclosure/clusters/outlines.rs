//! The borders of rows, and which of them lie along each other.

use super::junctions::{PointWeld, split_edges};
use crate::enclosure::CellMesh;
use azulejo_scene::math::area_vector;
use glam::DVec3;
use std::collections::{BTreeMap, HashMap, HashSet};

/// No edge.
pub(super) const NONE: u32 = u32::MAX;

/// Positions that are closer than this share of the whole are one point: coordinates in 32 bits are
/// rounded to about that.
const SAME: f64 = 1e-7;

/// Rows that meet at one edge, at which they are not a surface, and not neighbours.
const CROWD: usize = 32;

/// What all rows of a cluster have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RowKey {
    pub(super) object: u32,
    pub(super) material: u32,
    pub(super) is_back: bool,
}

/// The outlines of rows as closed lines of directed edges.
#[derive(Clone, Debug, Default)]
pub(super) struct OutlineMesh {
    pub(super) edges: Vec<OutlineEdge>,
    /// The first edge of each row; [`NONE`] for rows that are not a simple polygon.
    pub(super) first: Vec<u32>,
    /// Area vector of each row.
    pub(super) vectors: Vec<DVec3>,
    /// The rows around each point.
    pub(super) around: Vec<Vec<u32>>,
}

/// An edge of a row's outline, with the row on its left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OutlineEdge {
    /// The point where it starts.
    pub(super) from: u32,
    pub(super) next: u32,
    pub(super) previous: u32,
    /// The same edge of the neighbour, in the other direction, or [`NONE`].
    pub(super) twin: u32,
    pub(super) row: u32,
    pub(super) length: f64,
}

impl OutlineMesh {
    /// The outlines of this many rows, connected where their keys are equal. Corners of one row on the
    /// edge of another divide that edge.
    pub(super) fn new(cells: &CellMesh, rows: usize, key: impl Fn(usize) -> RowKey) -> OutlineMesh {
        let weld = PointWeld::new(&cells.points, SAME);
        let mut mesh = OutlineMesh {
            first: vec![NONE; rows],
            vectors: vec![DVec3::ZERO; rows],
            around: vec![Vec::new(); cells.points.len()],
            ..OutlineMesh::default()
        };
        let mut uses = vec![0usize; rows];
        cells.rows.iter().for_each(|&row| uses[row as usize] += 1);
        // In order, so that results do not depend on how maps are laid out.
        let mut alike: BTreeMap<RowKey, Vec<(u32, Vec<u32>)>> = BTreeMap::new();
        for (i, &row) in cells.rows.iter().enumerate() {
            let vector = area_vector(&cells.polygon(i));
            let outline = weld.outline(cells.cell(i));
            if uses[row as usize] == 1 && vector.is_finite() && is_simple(&outline) {
                mesh.vectors[row as usize] = vector;
                let same = alike.entry(key(row as usize)).or_default();
                same.push((row, outline));
            }
        }
        for outlines in alike.values_mut() {
            split_edges(outlines, &cells.points, weld.tolerance);
            let first = mesh.edges.len() as u32;
            for (row, outline) in outlines {
                mesh.add(*row, outline, &cells.points);
            }
            mesh.pair(first);
        }
        mesh
    }

    fn add(&mut self, row: u32, outline: &[u32], points: &[DVec3]) {
        let (start, n) = (self.edges.len() as u32, outline.len() as u32);
        self.first[row as usize] = start;
        for (k, &from) in (0..).zip(outline) {
            let to = outline[(k as usize + 1) % outline.len()];
            self.edges.push(OutlineEdge {
                from,
                next: start + (k + 1) % n,
                previous: start + (k + n - 1) % n,
                twin: NONE,
                row,
                length: points[from as usize].distance(points[to as usize]),
            });
            self.around[from as usize].push(row);
        }
    }

    pub(super) fn to(&self, edge: u32) -> u32 {
        let next = self.edges[edge as usize].next;
        self.edges[next as usize].from
    }

    /// Pairs the edges from `first` on with those in the other direction.
    fn pair(&mut self, first: u32) {
        let mut places: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
        for edge in first..self.edges.len() as u32 {
            let ends = (self.edges[edge as usize].from, self.to(edge));
            let place = (ends.0.min(ends.1), ends.0.max(ends.1));
            places.entry(place).or_default().push(edge);
        }
        for edges in places.values() {
            self.pair_at_one_place(edges);
        }
    }

    /// Where more than two rows meet, as where walls of two sides lie back to back, those whose normals
    /// agree best are neighbours.
    fn pair_at_one_place(&mut self, edges: &[u32]) {
        if edges.len() > CROWD {
            return;
        }
        let mut pairs = Vec::new();
        for (k, &a) in edges.iter().enumerate() {
            for &b in &edges[k + 1..] {
                let [one, other] = [a, b].map(|e| self.edges[e as usize]);
                if one.from != other.from && one.row != other.row {
                    pairs.push((self.agreement(one.row, other.row), a, b));
                }
            }
        }
        pairs.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        for (_, a, b) in pairs {
            if [a, b].iter().all(|&e| self.edges[e as usize].twin == NONE) {
                self.edges[a as usize].twin = b;
                self.edges[b as usize].twin = a;
            }
        }
    }

    /// Cosine of the angle between two rows, in steps above rounding errors, so that equal ones are equal.
    fn agreement(&self, a: u32, b: u32) -> f64 {
        let [m, n] = [a, b].map(|row| self.vectors[row as usize].normalize_or_zero());
        (m.dot(n) * 1e6).round()
    }
}

fn is_simple(outline: &[u32]) -> bool {
    let mut seen = HashSet::new();
    outline.len() > 2 && outline.iter().all(|p| seen.insert(p))
}
