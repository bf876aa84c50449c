//! A closed room of quadrilaterals, for form factors.

use super::metres;
use super::sheets::{Plate, Sheets, between, raised, steps};
use crate::{Camera, Material, MaterialId, Object, Rgb, Scene, Shape};
use glam::{DVec2, DVec3};
use std::ops::Range;

/// A closed room of 4 × 3 × 2.5 metres (z up) with a table and two boxes, one mesh of about
/// `facets` quadrilaterals, never fewer than 136: all rows of its form factors sum to 1.
///
/// Every facet is flat and convex, with its front towards the air; every edge has two facets. The
/// floor has holes below the objects that stand on it. The lamp is one field of the ceiling.
pub fn room_with_table(facets: usize) -> Scene {
    // Every length is a whole number of cells, so the count changes in steps: the nearest one is
    // chosen, with cells up to a quarter taller or lower than wide.
    let wide = (0..800).map(|k| 3.0 * 0.993f64.powi(k));
    let cells = wide.flat_map(|w| [1.0, 0.9, 1.1, 0.8, 1.25].map(|high| [w, high * w]));
    let plans = cells.map(Plan::new);
    let nearest = plans.min_by_key(|plan| plan.facets().abs_diff(facets));
    nearest.unwrap_or_else(|| Plan::new([1.0; 2])).scene()
}

/// The borders of the floor's fields. Every object on the floor has its own field.
const X: [f64; 6] = [0.0, 1.0, 1.5, 2.5, 3.0, 4.0];
const Y: [f64; 5] = [0.0, 1.0, 1.5, 2.0, 3.0];
const HEIGHT: f64 = 2.5;

/// The fields that the table covers.
const TABLE: [Range<usize>; 2] = [1..4, 1..3];
const TABLE_BOTTOM: f64 = 0.7;
const TABLE_TOP: f64 = 0.75;

/// Objects on the floor: field, size, rotation and height.
struct Pillar {
    field: [usize; 2],
    size: DVec2,
    turn: f64,
    top: f64,
    is_leg: bool,
}

const fn leg(i: usize, j: usize) -> Pillar {
    Pillar {
        field: [i, j],
        size: DVec2::splat(0.08),
        turn: 0.0,
        top: TABLE_BOTTOM,
        is_leg: true,
    }
}

const PILLARS: [Pillar; 6] = [
    leg(1, 1),
    leg(3, 1),
    leg(1, 2),
    leg(3, 2),
    Pillar {
        field: [4, 3],
        size: DVec2::new(0.6, 0.5),
        turn: 0.3,
        top: 0.9,
        is_leg: false,
    },
    Pillar {
        field: [0, 0],
        size: DVec2::new(0.5, 0.45),
        turn: -0.25,
        top: 0.5,
        is_leg: false,
    },
];

/// The field of the ceiling that emits.
const LAMP: [usize; 2] = [2, 2];

const WALL: MaterialId = 0;
const WOOD: MaterialId = 1;
const BOX: MaterialId = 2;
const SHINING: MaterialId = 3;

/// The division of the room: lines, and the first line of each field.
struct Plan {
    /// Width and height of a cell.
    cell: [f64; 2],
    lines: [Vec<f64>; 2],
    starts: [Vec<usize>; 2],
}

impl Plan {
    fn new(cell: [f64; 2]) -> Plan {
        let (xs, x_starts) = divided(&X, cell[0]);
        let (ys, y_starts) = divided(&Y, cell[0]);
        Plan {
            cell,
            lines: [xs, ys],
            starts: [x_starts, y_starts],
        }
    }

    /// Rows of cells of an upright face.
    fn rows(&self, height: f64) -> usize {
        cells(height, self.cell[1])
    }

    /// Numbers of cells along both axes of some fields.
    fn size(&self, [x, y]: [Range<usize>; 2]) -> [usize; 2] {
        [
            self.starts[0][x.end] - self.starts[0][x.start],
            self.starts[1][y.end] - self.starts[1][y.start],
        ]
    }

    fn plate(&self, [x, y]: [Range<usize>; 2]) -> Plate {
        let lines = |axis: usize, fields: Range<usize>| {
            let starts = &self.starts[axis];
            &self.lines[axis][starts[fields.start]..=starts[fields.end]]
        };
        Plate::from_lines(lines(0, x), lines(1, y))
    }

    /// Rows of cells from the border of a pillar's field to the pillar.
    fn rings(&self, pillar: &Pillar) -> usize {
        let field = X[pillar.field[0] + 1] - X[pillar.field[0]];
        cells((field - pillar.size.x) / 2.0, self.cell[0])
    }

    /// The number of facets that [`Plan::scene`] makes.
    fn facets(&self) -> usize {
        let [x, y] = self.size([0..5, 0..4]);
        let [tx, ty] = self.size(TABLE);
        let room = 2 * x * y + 2 * (x + y) * self.rows(HEIGHT);
        let table = 2 * tx * ty + 2 * (tx + ty) * self.rows(TABLE_TOP - TABLE_BOTTOM);
        let pillar = |p: &Pillar| {
            let [nx, ny] = self.size(one(p.field));
            let around = 2 * (nx + ny);
            let side = around * (self.rings(p) + self.rows(p.top));
            // The two rings of a leg replace two fields; the top of a box makes up for its field.
            if p.is_leg {
                side + around * self.rings(p) - 2 * nx * ny
            } else {
                side
            }
        };
        room + table + PILLARS.iter().map(pillar).sum::<usize>()
    }

    fn scene(&self) -> Scene {
        let mut sheets = Sheets::default();
        self.add_shell(&mut sheets);
        self.add_table(&mut sheets);
        for pillar in &PILLARS {
            self.add_pillar(&mut sheets, pillar);
        }
        Scene {
            objects: vec![Object::new("room", Shape::Mesh(sheets.into_mesh()))],
            materials: vec![
                Material::diffuse("wall", Rgb::grey(0.7)),
                Material::diffuse("wood", Rgb::new(0.5, 0.32, 0.18)),
                Material::diffuse("box", Rgb::new(0.35, 0.45, 0.6)),
                Material::emitter("lamp", Rgb::grey(10.0)),
            ],
            cameras: vec![Camera {
                name: "corner".into(),
                eye: DVec3::new(3.8, 0.2, 1.8),
                target: DVec3::new(1.8, 1.7, 0.7),
                up: DVec3::Z,
                vertical_fov: 1.2,
                size: Some((640, 480)),
            }],
            units: metres(),
            ..Scene::default()
        }
    }

    /// The field of a cell.
    fn field(&self, i: usize, j: usize) -> [usize; 2] {
        let field = |axis: usize, k: usize| self.starts[axis].partition_point(|&s| s <= k) - 1;
        [field(0, i), field(1, j)]
    }

    fn add_shell(&self, sheets: &mut Sheets) {
        let plate = self.plate([0..5, 0..4]);
        let is_free = |field| PILLARS.iter().all(|p| p.field != field);
        sheets.sheet(&plate.at(0.0), |i, j| {
            is_free(self.field(i, j)).then_some(WALL)
        });
        let mut ceiling = plate.at(HEIGHT);
        ceiling.reverse();
        let rows = ceiling.len() - 1;
        sheets.sheet(&ceiling, |i, j| match self.field(i, rows - 1 - j) {
            LAMP => Some(SHINING),
            _ => Some(WALL),
        });
        let mut around = plate.border();
        around.reverse();
        let walls = steps(0.0, HEIGHT, self.rows(HEIGHT));
        let walls: Vec<_> = walls.iter().map(|&z| raised(&around, z)).collect();
        sheets.sheet(&walls, |_, _| Some(WALL));
    }

    fn add_table(&self, sheets: &mut Sheets) {
        let plate = self.plate(TABLE);
        let border = plate.border();
        sheets.sheet(&plate.at(TABLE_TOP), |_, _| Some(WOOD));
        let (low, high) = (raised(&border, TABLE_BOTTOM), raised(&border, TABLE_TOP));
        let rim = between(&low, &high, self.rows(TABLE_TOP - TABLE_BOTTOM));
        sheets.sheet(&rim, |_, _| Some(WOOD));
        let mut underside = plate.at(TABLE_BOTTOM);
        underside.reverse();
        let rows = underside.len() - 1;
        let start = [
            self.starts[0][TABLE[0].start],
            self.starts[1][TABLE[1].start],
        ];
        sheets.sheet(&underside, |i, j| {
            let field = self.field(start[0] + i, start[1] + rows - 1 - j);
            PILLARS.iter().all(|p| p.field != field).then_some(WOOD)
        });
    }

    /// A leg or a box, with the floor around it and what stands on it.
    fn add_pillar(&self, sheets: &mut Sheets, pillar: &Pillar) {
        let [i, j] = pillar.field;
        let outer = self.plate(one(pillar.field));
        let centre = DVec2::new(X[i] + X[i + 1], Y[j] + Y[j + 1]) / 2.0;
        let inner = Plate::turned(centre, pillar.size, pillar.turn, outer.cells());
        let (around, foot) = (outer.border(), inner.border());
        let (rings, material) = (self.rings(pillar), if pillar.is_leg { WOOD } else { BOX });
        let ring = |z: f64| between(&raised(&around, z), &raised(&foot, z), rings);
        sheets.sheet(&ring(0.0), |_, _| Some(WALL));
        let side = steps(0.0, pillar.top, self.rows(pillar.top));
        let side: Vec<_> = side.iter().map(|&z| raised(&foot, z)).collect();
        sheets.sheet(&side, |_, _| Some(material));
        if pillar.is_leg {
            let mut ring = ring(pillar.top);
            ring.reverse();
            sheets.sheet(&ring, |_, _| Some(WOOD));
        } else {
            sheets.sheet(&inner.at(pillar.top), |_, _| Some(material));
        }
    }
}

/// A field as ranges of length one.
fn one([i, j]: [usize; 2]) -> [Range<usize>; 2] {
    [i..i + 1, j..j + 1]
}

fn cells(length: f64, cell: f64) -> usize {
    ((length / cell).round() as usize).max(1)
}

/// Lines through fields cut into cells, and the line at which each field begins.
fn divided(fields: &[f64], cell: f64) -> (Vec<f64>, Vec<usize>) {
    let (mut lines, mut starts) = (vec![fields[0]], vec![0]);
    for pair in fields.windows(2) {
        let inner = steps(pair[0], pair[1], cells(pair[1] - pair[0], cell));
        lines.extend(&inner[1..]);
        starts.push(lines.len() - 1);
    }
    (lines, starts)
}
