//! A room with furniture and objects on shelves.

use super::ball::add_ball;
use super::{Random, add_grid};
use crate::{Camera, Material, MaterialId, Mesh, Object, Rgb, Scene, Shape};
use glam::DVec3;

/// A closed room of 6 × 5 × 3 metres (z up) with a table, four chairs, shelves full of objects, a
/// hanging lamp that emits, and four balls with hills, everything divided into quadrilaterals:
/// typical of a radiosity mesh.
///
/// About `target_triangles` triangles, two per quadrilateral; never fewer than some 3000.
pub fn furnished_room(target_triangles: usize) -> Scene {
    let target = target_triangles.max(1) as f64;
    // This cell size would be exact if every face held a whole number of cells; a few corrections
    // compensate for the rounding.
    let mut cell = (2.0 * 160.0 / target).sqrt();
    for _ in 0..12 {
        let count = 2.0 * room(cell).quads() as f64;
        if (count / target - 1.0).abs() < 0.01 {
            break;
        }
        cell = (cell * (count / target).sqrt()).clamp(1e-4, 1.0);
    }
    room(cell).scene()
}

/// A box or ball of the room, not yet divided.
enum Furnishing {
    /// Corners, and whether it is seen from inside.
    Box(DVec3, DVec3, bool),
    /// Centre, radius, seed.
    Ball(DVec3, f64, u32),
}

struct Room {
    cell: f64,
    things: Vec<(String, Furnishing, &'static str)>,
}

fn room(cell: f64) -> Room {
    let mut room = Room {
        cell,
        things: Vec::new(),
    };
    let p = DVec3::new;
    let whole = Furnishing::Box(DVec3::ZERO, p(6.0, 5.0, 3.0), true);
    room.things.push(("walls".into(), whole, "plaster"));
    room.add_table();
    for (k, (x, y)) in [(1.7, 1.7), (3.1, 1.7), (1.7, 3.2), (3.1, 3.2)]
        .into_iter()
        .enumerate()
    {
        room.add_chair(k, x, y);
    }
    room.add_shelves();
    room.add_box("lamp", p(2.6, 2.4, 2.2), p(3.0, 2.8, 2.26), "lamp");
    for (k, (x, y, r)) in [
        (5.0, 1.0, 0.45),
        (0.8, 4.2, 0.5),
        (5.2, 3.9, 0.35),
        (0.7, 0.8, 0.4),
    ]
    .into_iter()
    .enumerate()
    {
        let ball = Furnishing::Ball(p(x, y, 1.3 * r), r, k as u32);
        room.things.push((format!("ball{k}"), ball, "clay"));
    }
    room
}

impl Room {
    fn add_box(&mut self, name: impl Into<String>, a: DVec3, b: DVec3, material: &'static str) {
        self.things
            .push((name.into(), Furnishing::Box(a, b, false), material));
    }

    fn add_table(&mut self) {
        let p = DVec3::new;
        self.add_box("table top", p(1.7, 2.1, 0.72), p(3.7, 3.1, 0.75), "wood");
        for (k, (x, y)) in [(1.75, 2.15), (3.59, 2.15), (1.75, 2.99), (3.59, 2.99)]
            .into_iter()
            .enumerate()
        {
            let name = format!("table leg{k}");
            self.add_box(name, p(x, y, 0.001), p(x + 0.06, y + 0.06, 0.719), "wood");
        }
    }

    fn add_chair(&mut self, k: usize, x: f64, y: f64) {
        let p = DVec3::new;
        self.add_box(
            format!("seat{k}"),
            p(x, y, 0.44),
            p(x + 0.45, y + 0.42, 0.47),
            "wood",
        );
        let back = if y < 2.5 { y } else { y + 0.39 };
        let name = format!("back{k}");
        self.add_box(
            name,
            p(x, back, 0.48),
            p(x + 0.45, back + 0.03, 0.95),
            "wood",
        );
        for leg in 0..4 {
            let (i, j) = (f64::from(leg % 2), f64::from(leg / 2));
            let foot = p(x + 0.02 + 0.37 * i, y + 0.02 + 0.34 * j, 0.001);
            let name = format!("chair{k} leg{leg}");
            self.add_box(name, foot, foot + p(0.04, 0.04, 0.438), "wood");
        }
    }

    fn add_shelves(&mut self) {
        let p = DVec3::new;
        let mut random = Random(7);
        for board in 0..5 {
            let z = 0.3 + 0.45 * f64::from(board);
            let name = format!("board{board}");
            self.add_box(name, p(4.2, 4.62, z), p(5.95, 4.98, z + 0.02), "wood");
            let mut x = 4.25;
            for thing in 0..9 {
                let (w, d, h) = (random.next(), random.next(), random.next());
                let corner = p(x, 4.65 + 0.05 * d, z + 0.021);
                let size = p(0.04 + 0.1 * w, 0.15 + 0.1 * d, 0.12 + 0.25 * h);
                let name = format!("thing{board}.{thing}");
                if thing % 4 == 3 {
                    let r = 0.07;
                    let ball =
                        Furnishing::Ball(p(x + r, 4.8, z + 0.03 + 1.3 * r), r, board * 9 + thing);
                    self.things.push((name, ball, "clay"));
                    x += 0.19;
                } else {
                    self.add_box(name, corner, corner + size, "paper");
                    x += size.x + 0.02;
                }
            }
        }
    }

    fn quads(&self) -> usize {
        let count = |thing: &Furnishing| match *thing {
            Furnishing::Box(a, b, _) => {
                let [nx, ny, nz] = self.cells(b - a);
                2 * (nx * ny + ny * nz + nz * nx) as usize
            }
            Furnishing::Ball(_, radius, _) => 6 * (self.ball_cells(radius) as usize).pow(2),
        };
        self.things.iter().map(|(_, thing, _)| count(thing)).sum()
    }

    fn cells(&self, size: DVec3) -> [u32; 3] {
        (size / self.cell)
            .to_array()
            .map(|n| (n.round() as u32).max(1))
    }

    /// Balls are divided three times as finely as the rest.
    fn ball_cells(&self, radius: f64) -> u32 {
        ((1.5 * radius / (self.cell / 3.0)).round() as u32).max(2)
    }

    fn scene(&self) -> Scene {
        let mut scene = Scene::default();
        let materials = [
            Material::diffuse("plaster", Rgb::grey(0.75)),
            Material::diffuse("wood", Rgb::new(0.5, 0.32, 0.18)),
            Material::diffuse("paper", Rgb::new(0.4, 0.45, 0.6)),
            Material::diffuse("clay", Rgb::new(0.6, 0.5, 0.4)),
            Material::emitter("lamp", Rgb::grey(20.0)),
        ];
        scene.materials.extend(materials);
        for (name, thing, material) in &self.things {
            let named = |m: &Material| m.name == *material;
            let id = scene.materials.iter().position(named).unwrap_or(0) as MaterialId;
            let mut mesh = Mesh::default();
            match *thing {
                Furnishing::Box(a, b, inward) => {
                    add_box(&mut mesh, a, b, self.cells(b - a), inward, id)
                }
                Furnishing::Ball(centre, radius, seed) => {
                    add_ball(&mut mesh, centre, radius, self.ball_cells(radius), seed, id);
                }
            }
            scene.objects.push(Object::new(name, Shape::Mesh(mesh)));
        }
        scene.cameras.push(Camera {
            name: "door".into(),
            eye: DVec3::new(0.3, 0.4, 1.7),
            target: DVec3::new(3.4, 3.0, 1.0),
            up: DVec3::Z,
            vertical_fov: 1.1,
            size: Some((640, 480)),
        });
        scene
    }
}

/// Adds a box whose sides are grids over the same coordinates, so that they share their edges.
fn add_box(
    mesh: &mut Mesh,
    a: DVec3,
    b: DVec3,
    cells: [u32; 3],
    inward: bool,
    material: MaterialId,
) {
    for axis in 0..3 {
        let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
        for upper in [false, true] {
            // `first × second` points along the axis: outside on the upper side only.
            let swap = upper == inward;
            let (u, v) = if swap {
                (second, first)
            } else {
                (first, second)
            };
            add_grid(mesh, cells[u], cells[v], material, |i, j| {
                let mut p = if upper { b } else { a };
                for (k, step) in [(u, i), (v, j)] {
                    let part = f64::from(step) / f64::from(cells[k]);
                    p[k] = a[k] * (1.0 - part) + b[k] * part;
                }
                p
            });
        }
    }
}
