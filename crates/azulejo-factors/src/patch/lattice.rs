//! The square lattice inside a flat region.

use super::divide::MAX_PATCHES;
use super::irregular::bounds;
use glam::DVec2;

/// Distance of squares from the border, as a share of the spacing.
const CLEARANCE: f64 = 0.6;
/// Height of the first row above the longest side: triangles of this height over one spacing are
/// equilateral.
const FIRST_ROW: f64 = 0.866;

/// Squares of one size at a distance from the border of a polygon.
pub(super) struct Lattice {
    pub spacing: f64,
    pub origin: DVec2,
    /// Corners of squares, row by row.
    pub points: Vec<DVec2>,
    /// Lower left corner of each square, in steps from the origin; row by row.
    cells: Vec<[u32; 2]>,
    /// The corners of each square among `points`, counter-clockwise.
    corners: Vec<[u32; 4]>,
}

/// The outline of the lattice.
pub(super) struct Rim {
    /// Points on it, among the lattice's.
    pub points: Vec<u32>,
    /// Its edges, as positions among `points`.
    pub edges: Vec<[u32; 2]>,
}

impl Lattice {
    /// The lattice of squares with sides `size` in a polygon, at a distance from the `lines`
    /// through it; without squares if none fits.
    pub fn new(corners: &[DVec2], lines: &[[DVec2; 2]], size: f64) -> Lattice {
        let (low, high) = bounds(corners);
        let steps = (high - low) / size;
        let fits = size > 0.0 && steps.min_element() >= 1.0 && steps.x * steps.y < LIMIT;
        let mut lattice = Lattice {
            spacing: if fits { size } else { 1.0 },
            origin: low,
            points: Vec::new(),
            cells: Vec::new(),
            corners: Vec::new(),
        };
        if fits {
            lattice.origin += DVec2::new(0.5, FIRST_ROW) * size;
            let rows = steps.y as u32;
            let sides =
                || (0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]]);
            let obstacles: Vec<[DVec2; 2]> = sides().chain(lines.iter().copied()).collect();
            (0..rows).for_each(|row| lattice.add_row(corners, &obstacles, row));
            lattice.number();
        }
        lattice
    }

    /// Number of squares.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Area of all squares.
    pub fn area(&self) -> f64 {
        self.len() as f64 * self.spacing * self.spacing
    }

    /// The corners of each square, counted from `base`.
    pub fn squares(&self, base: u32) -> Vec<[u32; 4]> {
        self.corners.iter().map(|c| c.map(|k| base + k)).collect()
    }

    fn add_row(&mut self, corners: &[DVec2], obstacles: &[[DVec2; 2]], row: u32) {
        let (size, origin) = (self.spacing, self.origin);
        let y = origin.y + f64::from(row) * size;
        let taken = taken(obstacles, y, size);
        for [from, to] in inside(corners, y + 0.5 * size) {
            let first = ((from - origin.x) / size).ceil().max(0.0) as u32;
            let end = ((to - origin.x) / size).floor().max(0.0) as u32;
            for column in first..end {
                let x = origin.x + f64::from(column) * size;
                if taken.iter().all(|[a, b]| x <= *a || x >= *b) {
                    self.cells.push([column, row]);
                }
            }
        }
    }

    /// Numbers the corners of the squares: each point once for two neighbouring rows.
    fn number(&mut self) {
        let mut keys: Vec<[u32; 2]> = self
            .cells
            .iter()
            .flat_map(|&[i, j]| [[j, i], [j, i + 1], [j + 1, i], [j + 1, i + 1]])
            .collect();
        keys.sort_unstable();
        keys.dedup();
        let at = |key: [u32; 2]| keys.binary_search(&key).unwrap_or(0) as u32;
        self.corners = self
            .cells
            .iter()
            .map(|&[i, j]| [[j, i], [j, i + 1], [j + 1, i + 1], [j + 1, i]].map(at))
            .collect();
        let place = |&[j, i]: &[u32; 2]| {
            self.origin + DVec2::new(f64::from(i), f64::from(j)) * self.spacing
        };
        self.points = keys.iter().map(place).collect();
    }

    /// The edges that belong to only one square, and their ends.
    pub fn outline(&self) -> Rim {
        let mut sides: Vec<[u32; 2]> = self
            .corners
            .iter()
            .flat_map(|c| (0..4).map(|k| [c[k], c[(k + 1) % 4]]))
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        sides.sort_unstable();
        let single: Vec<[u32; 2]> = sides
            .chunk_by(|a, b| a == b)
            .filter(|run| run.len() == 1)
            .map(|run| run[0])
            .collect();
        let mut points = single.concat();
        points.sort_unstable();
        points.dedup();
        let at = |k: u32| points.binary_search(&k).unwrap_or(0) as u32;
        let edges = single.iter().map(|e| e.map(at)).collect();
        Rim { points, edges }
    }
}

/// Most squares in the bounding box of a lattice.
const LIMIT: f64 = 4.0 * MAX_PATCHES as f64;

/// The pieces of the line at height `y` inside the polygon, by the even-odd rule.
fn inside(corners: &[DVec2], y: f64) -> Vec<[f64; 2]> {
    let n = corners.len();
    let mut crossings: Vec<f64> = (0..n)
        .map(|k| (corners[k], corners[(k + 1) % n]))
        .filter(|(a, b)| (a.y <= y) != (b.y <= y))
        .map(|(a, b)| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y))
        .collect();
    crossings.sort_by(f64::total_cmp);
    crossings.chunks_exact(2).map(|c| [c[0], c[1]]).collect()
}

/// Where on the row from `y` to `y + size` squares may not start, because a side or line comes too
/// close: one open interval for each.
fn taken(obstacles: &[[DVec2; 2]], y: f64, size: f64) -> Vec<[f64; 2]> {
    let clearance = CLEARANCE * size;
    let (low, high) = (y - clearance, y + size + clearance);
    obstacles
        .iter()
        .filter_map(|&[a, b]| {
            let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
            if b.y <= low || a.y >= high {
                return None;
            }
            let at = |y: f64| {
                if a.y < b.y {
                    a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)).clamp(0.0, 1.0)
                } else {
                    a.x
                }
            };
            let ends = if a.y < b.y {
                [at(low), at(high)]
            } else {
                [a.x, b.x]
            };
            let (left, right) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            Some([left - clearance - size, right + clearance])
        })
        .collect()
}
