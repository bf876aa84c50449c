//! A house: walls with windows, a roof, a chimney.

use super::{MIRROR, PLASTER, PLASTERS, ROOF, WINDOW};
use crate::MaterialId;
use crate::synthetic::Random;
use crate::synthetic::sheets::{Plate, Sheets, between, border, raised};
use glam::DVec3;

/// The position of a house on the grid of the site, in cells, and its height.
pub(super) struct House {
    corner: [usize; 2],
    size: [usize; 2],
    /// Rows of cells of its walls, five per storey of 3 m.
    rows: usize,
    storeys: usize,
    /// Rise of the ridge over the eaves, metres; 0 for a flat roof.
    rise: f64,
    chimney_rows: usize,
    plaster: MaterialId,
}

const STOREY: f64 = 3.0;

/// Storeys of the houses, first of one side of the street, then of the other.
const STOREYS: [usize; 24] = [
    5, 6, 5, 6, 5, 4, 6, 5, 6, 5, 5, 6, 5, 5, 6, 5, 6, 4, 6, 5, 5, 6, 5, 6,
];

impl House {
    pub(super) fn new(k: usize, corner: [usize; 2], size: [usize; 2], detail: f64) -> House {
        let storeys = STOREYS[k % STOREYS.len()];
        let of = |n: usize| ((n as f64 * detail).round() as usize).max(1);
        House {
            corner,
            size,
            rows: of(5 * storeys),
            storeys,
            rise: if k % 3 == 1 { 0.0 } else { 2.5 },
            chimney_rows: of(if k.is_multiple_of(3) { 5 } else { 4 }),
            plaster: PLASTER + (k * 7 % 5 % PLASTERS) as MaterialId,
        }
    }

    pub(super) fn covers(&self, i: usize, j: usize) -> bool {
        let within = |axis: usize, k: usize| {
            (self.corner[axis]..self.corner[axis] + self.size[axis]).contains(&k)
        };
        within(0, i) && within(1, j)
    }

    /// Adds walls, roof and chimney; the ground is a hole below.
    pub(super) fn build(&self, lines: &[Vec<f64>; 2], seed: u64, sheets: &mut Sheets) {
        let [xs, ys] = [0, 1].map(|axis: usize| {
            let start = self.corner[axis];
            &lines[axis][start..=start + self.size[axis]]
        });
        let plate = Plate::from_lines(xs, ys);
        let roof = self.roof(&plate, ys);
        let foot = raised(&plate.border(), 0.0);
        let eaves = border(&roof);
        let windows = self.windows(seed);
        sheets.sheet(&between(&foot, &eaves, self.rows), |i, j| {
            Some(self.wall(i, j, &windows))
        });
        let stack = [self.size[0] / 2, self.size[1] / 4];
        sheets.sheet(&roof, |i, j| ([i, j] != stack).then_some(ROOF));
        self.add_chimney(&roof, stack, sheets);
    }

    /// The points of the roof: the ridge runs along x.
    fn roof(&self, plate: &Plate, ys: &[f64]) -> Vec<Vec<DVec3>> {
        let deep = ys.len() - 1;
        let eaves = STOREY * self.storeys as f64;
        let mut rows = plate.at(eaves);
        for (j, row) in rows.iter_mut().enumerate() {
            // The lines are evenly spaced, so heights by index keep the two slopes flat.
            let up = j.min(deep - j) as f64 / (deep / 2) as f64;
            row.iter_mut().for_each(|p| p.z = eaves + self.rise * up);
        }
        rows
    }

    /// The material of each window: storey by storey, three in front and three behind.
    fn windows(&self, seed: u64) -> Vec<MaterialId> {
        let mut random = Random(seed);
        let kind = |_| if random.next() < 0.25 { MIRROR } else { WINDOW };
        (0..self.storeys * 6).map(kind).collect()
    }

    /// The material of cell (i, j) of the walls, `i` around the house from its corner. Where a
    /// long wall has 15 columns, windows are 2 × 2 of the 4 × 5 cells of a bay.
    fn wall(&self, i: usize, j: usize, windows: &[MaterialId]) -> MaterialId {
        let [wide, deep] = self.size;
        let (side, along) = match i {
            i if i < wide => (0, i),
            i if (wide + deep..2 * wide + deep).contains(&i) => (1, i - wide - deep),
            _ => return self.plaster,
        };
        let (row, column) = (j * 5 * self.storeys / self.rows, along * 15 / wide);
        let (storey, bay) = (row / 5, column / 4);
        if bay < 3 && column % 4 >= 2 && matches!(row % 5, 2 | 3) {
            windows[storey * 6 + side * 3 + bay]
        } else {
            self.plaster
        }
    }

    /// A column on one cell of the roof.
    fn add_chimney(&self, roof: &[Vec<DVec3>], [i, j]: [usize; 2], sheets: &mut Sheets) {
        let foot = [
            roof[j][i],
            roof[j][i + 1],
            roof[j + 1][i + 1],
            roof[j + 1][i],
        ];
        let top = foot.map(|p| p.with_z(STOREY * self.storeys as f64 + self.rise + 1.0));
        let closed = |c: [DVec3; 4]| [c[0], c[1], c[2], c[3], c[0]];
        let side = between(&closed(foot), &closed(top), self.chimney_rows);
        sheets.sheet(&side, |_, _| Some(self.plaster));
        sheets.face(&top, self.plaster);
    }
}
