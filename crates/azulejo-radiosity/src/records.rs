//! Records: the points at which indirect irradiance is gathered, where there are far more points than
//! it varies between.
//!
//! Points that face one way are the leaves of octrees. A cell's record is the one of its points whose
//! key comes first, so dividing a cell keeps its record: what was gathered for a coarse choice of
//! records serves every finer one.

use azulejo_trace::GatherPoint;
use azulejo_trace::sampling::hash;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Depth of the octrees: cells of a 2^20th of the scene.
const DEPTH: u32 = 20;

/// Normals are told apart by steps of this part of a unit, per axis.
const NORMAL_STEPS: f64 = 2.0;

/// The points, divided into cells with a record each.
#[derive(Clone)]
pub struct RecordCells {
    /// Points, cell by cell.
    order: Vec<u32>,
    /// Where each of them lies, in the same order.
    codes: Vec<CellCode>,
    /// Rank of each point in the choice of records.
    ranks: Vec<u32>,
    cells: Vec<Cell>,
}

/// The way from the root to a point: its octree, by the direction that it faces, then three bits per
/// level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct CellCode {
    facing: [i8; 3],
    path: u64,
}

impl CellCode {
    /// The cell at a depth.
    fn at(self, depth: u32) -> CellCode {
        let path = self.path >> (3 * (DEPTH - depth));
        CellCode { path, ..self }
    }
}

#[derive(Clone, Debug)]
struct Cell {
    /// Of `order`.
    points: Range<usize>,
    depth: u32,
    /// Index of the record among the points.
    record: u32,
}

impl RecordCells {
    /// As few cells of one size as are at least `count`, or as many as there are.
    pub fn new(points: &[GatherPoint], seed: u32, count: usize) -> RecordCells {
        let mut cells = RecordCells::undivided(points, seed);
        let enough = |&depth: &u32| cells.count_at(depth) >= count;
        let depth = (0..DEPTH).find(enough).unwrap_or(DEPTH);
        cells.cells = cells.divided(0..cells.order.len(), depth);
        cells
    }

    /// As many cells of one size as are at most `count`, and no fewer than points face in different
    /// ways.
    pub fn at_most(points: &[GatherPoint], seed: u32, count: usize) -> RecordCells {
        let mut cells = RecordCells::undivided(points, seed);
        let too_many = |&depth: &u32| cells.count_at(depth) > count;
        let depth = (1..=DEPTH).find(too_many).map_or(DEPTH, |depth| depth - 1);
        cells.cells = cells.divided(0..cells.order.len(), depth);
        cells
    }

    fn undivided(points: &[GatherPoint], seed: u32) -> RecordCells {
        let coder = Coder::new(points);
        let mut sorted: Vec<(CellCode, u32)> = points
            .iter()
            .enumerate()
            .map(|(i, p)| (coder.code(p), i as u32))
            .collect();
        sorted.par_sort_unstable();
        let (codes, order): (Vec<CellCode>, Vec<u32>) = sorted.into_iter().unzip();
        let rank = |(i, p): (usize, &GatherPoint)| hash(&[seed, p.key, i as u32, 0x4ec]);
        RecordCells {
            order,
            codes,
            ranks: points.iter().enumerate().map(rank).collect(),
            cells: Vec::new(),
        }
    }

    /// Number of cells.
    pub fn count(&self) -> usize {
        self.cells.len()
    }

    /// The records' indices among the points, cell by cell.
    pub fn records(&self) -> impl Iterator<Item = u32> + '_ {
        self.cells.iter().map(|cell| cell.record)
    }

    /// The points of each cell.
    pub fn points(&self) -> impl Iterator<Item = &[u32]> {
        self.cells
            .iter()
            .map(|cell| &self.order[cell.points.clone()])
    }

    /// Divides the cells whose entry is set. Returns for each cell which one it was part of.
    pub fn divide(&mut self, is_divided: &[bool]) -> Vec<u32> {
        let (mut cells, mut parents) = (Vec::new(), Vec::new());
        for (parent, (cell, &divide)) in self.cells.iter().zip(is_divided).enumerate() {
            if divide {
                cells.extend(self.children(cell));
            } else {
                cells.push(cell.clone());
            }
            parents.resize(cells.len(), parent as u32);
        }
        self.cells = cells;
        parents
    }

    /// The parts of a cell at the next depth at which there are several; itself if there is none.
    fn children(&self, cell: &Cell) -> Vec<Cell> {
        let Range { start, end } = cell.points;
        let (first, last) = (self.codes[start], self.codes[end - 1]);
        let depth = (cell.depth + 1..=DEPTH).find(|&d| first.at(d) != last.at(d));
        self.divided(start..end, depth.unwrap_or(DEPTH))
    }

    fn count_at(&self, depth: u32) -> usize {
        let starts = |w: &&[CellCode]| w[0].at(depth) != w[1].at(depth);
        self.codes.windows(2).filter(starts).count() + usize::from(!self.codes.is_empty())
    }

    /// The cells of a range of points at a depth.
    fn divided(&self, range: Range<usize>, depth: u32) -> Vec<Cell> {
        let mut start = range.start;
        let stretch = |stretch: &[CellCode]| {
            let points = start..start + stretch.len();
            start = points.end;
            let first = self.order[points.clone()]
                .iter()
                .min_by_key(|&&i| (self.ranks[i as usize], i));
            Cell {
                record: *first.expect("a stretch has a point"),
                points,
                depth,
            }
        };
        self.codes[range]
            .chunk_by(|a, b| a.at(depth) == b.at(depth))
            .map(stretch)
            .collect()
    }
}

/// Codes the points in a cube around all of them.
struct Coder {
    corner: DVec3,
    scale: f64,
}

impl Coder {
    fn new(points: &[GatherPoint]) -> Coder {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points.iter().fold(start, |(low, high), p| {
            (low.min(p.position), high.max(p.position))
        });
        let size = (high - low).max_element().max(f64::MIN_POSITIVE);
        // An uneven margin, so that no wall of the scene lies on a wall of large cells.
        Coder {
            corner: low - 0.31 * size,
            scale: 1.0 / (1.71 * size),
        }
    }

    fn code(&self, point: &GatherPoint) -> CellCode {
        let steps = f64::from(1_u32 << DEPTH);
        let cell = ((point.position - self.corner) * self.scale * steps)
            .clamp(DVec3::ZERO, DVec3::splat(steps - 1.0));
        let path = (0..DEPTH).rev().fold(0, |path, bit| {
            let side = |x: f64| (x as u64) >> bit & 1;
            path << 3 | side(cell.x) << 2 | side(cell.y) << 1 | side(cell.z)
        });
        CellCode {
            facing: (NORMAL_STEPS * point.normal)
                .to_array()
                .map(|n| n.round() as i8),
            path,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    /// Points on two facing walls.
    fn walls(count: usize) -> Vec<GatherPoint> {
        let point = |i: usize| {
            let [u, v] = [1, 2].map(|k| f64::from(hash(&[i as u32, k])) / f64::from(u32::MAX));
            let side = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
            GatherPoint {
                position: dvec3(u, v, -side),
                normal: dvec3(0.0, 0.0, side),
                key: i as u32,
            }
        };
        (0..count).map(point).collect()
    }

    /// All points are in exactly one cell, with those that face the same way, and with its record.
    fn check(cells: &RecordCells, points: &[GatherPoint]) {
        let mut seen = vec![0; points.len()];
        for (record, inside) in cells.records().zip(cells.points()) {
            assert!(inside.contains(&record));
            let normal = points[record as usize].normal;
            assert!(inside.iter().all(|&i| points[i as usize].normal == normal));
            inside.iter().for_each(|&i| seen[i as usize] += 1);
        }
        assert!(seen.iter().all(|&n| n == 1));
    }

    #[test]
    fn cells_divide_the_points_and_keep_their_records() {
        let points = walls(5000);
        let mut cells = RecordCells::new(&points, 3, 100);
        check(&cells, &points);
        let before: Vec<u32> = cells.records().collect();
        assert!((100..=400).contains(&before.len()), "{}", before.len());
        let is_divided: Vec<bool> = (0..before.len()).map(|i| i % 3 == 0).collect();
        let parents = cells.divide(&is_divided);
        check(&cells, &points);
        let after: Vec<u32> = cells.records().collect();
        assert_eq!(after.len(), parents.len());
        for (parent, record) in before.iter().enumerate() {
            let parts = parents.iter().filter(|&&p| p as usize == parent).count();
            assert!(after.contains(record) && (parts > 1) == (parent % 3 == 0));
        }
    }

    #[test]
    fn equal_points_are_one_cell_that_is_not_divided() {
        let mut points = walls(64);
        for p in &mut points {
            (p.position, p.normal) = (DVec3::ONE, DVec3::Z);
        }
        let mut cells = RecordCells::new(&points, 0, 10);
        check(&cells, &points);
        assert_eq!(cells.records().count(), 1);
        assert_eq!(cells.divide(&[true]), [0]);
    }
}
