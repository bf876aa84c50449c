//! Regions of rows, which grow by joining.

use super::outlines::{NONE, OutlineMesh};
use super::rank;
use glam::DVec3;
use std::collections::BTreeMap;

/// Normals may be off by so much more: those of flat faces are rounded, too. In radians.
const ROUNDING: f64 = 1e-4;

/// Weight of a bend against the length of the border: a bend of 30° counts as a border that is half
/// longer.
const BEND: f64 = 10.0;

/// Regions of rows. Each is named after one of its rows, and is a disc.
pub(super) struct ClusterRegions {
    mesh: OutlineMesh,
    /// A row of the region that each row joined, up to that after which it is named.
    joined: Vec<u32>,
    /// The next row of the same region, in a circle.
    next: Vec<u32>,
    /// By the row after which each is named.
    regions: Vec<ClusterRegion>,
    /// Unit normals of rows; zero for those without area.
    normals: Vec<DVec3>,
    /// Least cosine of the angle between a row and its region.
    least: f64,
    count: usize,
}

#[derive(Clone, Copy, Debug)]
struct ClusterRegion {
    area: f64,
    vector: DVec3,
    perimeter: f64,
    /// One of the edges of its border, or [`NONE`].
    edge: u32,
}

/// The border between a region and a neighbour.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClusterBorder {
    /// The neighbour.
    pub(super) region: u32,
    length: f64,
    edges: usize,
    points: usize,
    /// Lines of edges that it consists of.
    lines: usize,
    /// The first edge of the last of them.
    first: u32,
}

impl ClusterBorder {
    /// Whether both regions together are a disc again: they touch along one line that does not close, and
    /// at no other point.
    pub(super) fn is_one_line(&self) -> bool {
        self.lines == 1 && self.points == self.edges + 1
    }
}

impl ClusterRegions {
    /// One region for each row; no normal of a row may be farther off that of its region than `angle`.
    pub(super) fn new(mesh: OutlineMesh, angle: f64) -> ClusterRegions {
        let rows = mesh.first.len();
        let limit = (angle + ROUNDING).clamp(0.0, std::f64::consts::PI);
        let mut regions = ClusterRegions {
            joined: (0..rows as u32).collect(),
            next: (0..rows as u32).collect(),
            regions: Vec::with_capacity(rows),
            normals: mesh.vectors.iter().map(|v| v.normalize_or_zero()).collect(),
            // Rounding of a cosine must not refuse opposite normals.
            least: limit.cos() - 1e-12,
            count: rows,
            mesh,
        };
        for row in 0..rows {
            let edge = regions.mesh.first[row];
            let lengths = regions.around(edge).into_iter();
            let perimeter = lengths.map(|e| regions.mesh.edges[e as usize].length).sum();
            let vector = regions.mesh.vectors[row];
            regions.regions.push(ClusterRegion {
                area: vector.length(),
                vector,
                perimeter,
                edge,
            });
        }
        regions
    }

    /// Number of regions.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// The rows after which regions were named at first.
    pub(super) fn rows_at_first(&self) -> impl Iterator<Item = u32> + use<> {
        0..self.joined.len() as u32
    }

    /// The area of a region.
    pub(super) fn area(&self, region: u32) -> f64 {
        self.regions[region as usize].area
    }

    /// The region of a row.
    pub(super) fn region_of(&mut self, row: u32) -> u32 {
        let mut row = row as usize;
        while self.joined[row] as usize != row {
            let next = self.joined[row] as usize;
            self.joined[row] = self.joined[next];
            row = next;
        }
        row as u32
    }

    /// The edges of a closed line, from one of them on.
    fn around(&self, start: u32) -> Vec<u32> {
        let mut edges = Vec::new();
        let mut edge = start;
        while edge != NONE && (edge != start || edges.is_empty()) {
            edges.push(edge);
            edge = self.mesh.edges[edge as usize].next;
        }
        edges
    }

    /// The borders with all neighbours, by their numbers.
    pub(super) fn borders(&mut self, region: u32) -> Vec<ClusterBorder> {
        let edges = self.around(self.regions[region as usize].edge);
        let across: Vec<u32> = edges.iter().map(|&e| self.across(e)).collect();
        let mut borders: BTreeMap<u32, ClusterBorder> = BTreeMap::new();
        for (k, (&edge, &other)) in edges.iter().zip(&across).enumerate() {
            if other == NONE {
                continue;
            }
            let border = borders.entry(other).or_default();
            border.region = other;
            border.length += self.mesh.edges[edge as usize].length;
            border.edges += 1;
            if across[(k + across.len() - 1) % across.len()] != other {
                border.lines += 1;
                border.first = edge;
            }
        }
        for &edge in &edges {
            for &other in self.at_point(self.mesh.edges[edge as usize].from) {
                if let Some(border) = borders.get_mut(&other) {
                    border.points += 1;
                }
            }
        }
        borders.into_values().collect()
    }

    /// The region on the other side of an edge, or [`NONE`].
    fn across(&mut self, edge: u32) -> u32 {
        match self.mesh.edges[edge as usize].twin {
            NONE => NONE,
            twin => self.region_of(self.mesh.edges[twin as usize].row),
        }
    }

    /// The regions around a point, each once.
    fn at_point(&mut self, point: u32) -> &[u32] {
        let mut around = std::mem::take(&mut self.mesh.around[point as usize]);
        around
            .iter_mut()
            .for_each(|row| *row = self.region_of(*row));
        around.sort_unstable();
        around.dedup();
        let place = &mut self.mesh.around[point as usize];
        *place = around;
        place
    }

    /// The border with the neighbour that a region joins best: the one with which it has the shortest
    /// border and the least bend.
    pub(super) fn best(&mut self, region: u32) -> Option<ClusterBorder> {
        let mut borders = self.borders(region);
        borders.retain(ClusterBorder::is_one_line);
        let cost = |b: &ClusterBorder| self.cost(region, b);
        let mut ranked: Vec<(u32, ClusterBorder)> =
            borders.iter().map(|b| (rank(cost(b)), *b)).collect();
        ranked.sort_by_key(|(cost, _)| *cost);
        let mut fitting = ranked.into_iter().map(|(_, b)| b);
        fitting.find(|b| self.fit(region, b.region))
    }

    fn cost(&self, region: u32, border: &ClusterBorder) -> f64 {
        let [a, b] = [region, border.region].map(|r| self.regions[r as usize]);
        let perimeter = a.perimeter + b.perimeter - 2.0 * border.length;
        let [m, n] = [a, b].map(|r| r.vector.normalize_or_zero());
        let has_normals = m != DVec3::ZERO && n != DVec3::ZERO;
        let bend = if has_normals { 1.0 - m.dot(n) } else { 0.0 };
        perimeter * perimeter * (1.0 + BEND * bend)
    }

    /// Whether the normals of all rows of both regions are near their mean.
    fn fit(&self, a: u32, b: u32) -> bool {
        let [m, n] = [a, b].map(|r| self.regions[r as usize].vector);
        let mean = (m + n).normalize_or_zero();
        let is_near = |row: u32| {
            let normal = self.normals[row as usize];
            normal == DVec3::ZERO || normal.dot(mean) >= self.least
        };
        [a, b].into_iter().all(|r| self.rows(r).all(is_near))
    }

    /// The rows of a region.
    fn rows(&self, region: u32) -> impl Iterator<Item = u32> {
        let next = move |row: &u32| Some(self.next[*row as usize]).filter(|r| *r != region);
        std::iter::successors(Some(region), next)
    }

    /// Joins a region and its neighbour over a border of one line. Returns the new one.
    pub(super) fn join(&mut self, region: u32, border: &ClusterBorder) -> u32 {
        let (a, b) = (region, border.region);
        let edge = self.remove(border);
        let [one, other] = [a, b].map(|r| self.regions[r as usize]);
        let (kept, gone) = (a.min(b), a.max(b));
        self.regions[kept as usize] = ClusterRegion {
            area: one.area + other.area,
            vector: one.vector + other.vector,
            perimeter: (one.perimeter + other.perimeter - 2.0 * border.length).max(0.0),
            edge,
        };
        self.joined[gone as usize] = kept;
        self.next.swap(kept as usize, gone as usize);
        self.count -= 1;
        kept
    }

    /// Takes the edges between two regions out of both outlines, which become one. Returns an edge of it.
    fn remove(&mut self, border: &ClusterBorder) -> u32 {
        let edges = &mut self.mesh.edges;
        let first = border.first;
        let mut last = first;
        for _ in 1..border.edges {
            last = edges[last as usize].next;
        }
        let before = edges[first as usize].previous;
        let after = edges[last as usize].next;
        let [twin_of_first, twin_of_last] = [first, last].map(|e| edges[e as usize].twin);
        let there_after = edges[twin_of_first as usize].next;
        let there_before = edges[twin_of_last as usize].previous;
        for (from, to) in [(before, there_after), (there_before, after)] {
            edges[from as usize].next = to;
            edges[to as usize].previous = from;
        }
        before
    }
}
