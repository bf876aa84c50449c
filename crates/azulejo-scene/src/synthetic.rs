//! Scenes made by formula: for tests, examples and benchmarks.
//!
//! All are deterministic, and closed where their documentation says so: faces that meet share
//! their corners' positions exactly.

use crate::{Camera, Material, MaterialId, Mesh, Object, Rgb, Scene, Shape, Units};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// The closed unit cube, six quadrilaterals that face inward, reflectance 0.5, no light.
///
/// Form factors between its sides are known: 0.1998 to the opposite one, 0.2000 to each other.
pub fn cube_room() -> Scene {
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let mut mesh = Mesh {
        positions: (0..8)
            .map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)))
            .collect(),
        ..Mesh::default()
    };
    for corners in [
        [0, 2, 6, 4],
        [1, 5, 7, 3],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 1, 3, 2],
        [4, 6, 7, 5],
    ] {
        mesh.push_face(&corners, grey);
    }
    scene.objects.push(Object::new("cube", Shape::Mesh(mesh)));
    scene
}

/// What the tall block of the [`cornell_box`] is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CornellVariant {
    /// White, as in the laboratory.
    Diffuse,
    /// A mirror of reflectance 0.9.
    MirrorBlock,
}

/// The box of the Program of Computer Graphics at Cornell University, with its published
/// measured geometry, in millimetres; reflectances and light as the usual RGB approximations.
///
/// The lamp fills a hole in the ceiling; the front, z = 0, is open. One object per face, the
/// camera as published.
pub fn cornell_box(variant: CornellVariant) -> Scene {
    let mut scene = Scene {
        units: Units {
            metres_per_unit: Some(1e-3),
            ..Units::default()
        },
        ..Scene::default()
    };
    let mut diffuse =
        |name: &str, r, g, b| scene.add_material(Material::diffuse(name, Rgb::new(r, g, b)));
    let white = diffuse("white", 0.725, 0.71, 0.68);
    let red = diffuse("red", 0.63, 0.065, 0.05);
    let green = diffuse("green", 0.14, 0.45, 0.091);
    let light = scene.add_material(Material::emitter("light", Rgb::new(17.0, 12.0, 4.0)));
    let tall = match variant {
        CornellVariant::Diffuse => white,
        CornellVariant::MirrorBlock => {
            scene.add_material(Material::mirror("mirror", Rgb::grey(0.9)))
        }
    };
    add_cornell_room(&mut scene, white, red, green, light);
    let short_top = [
        [130, 165, 65],
        [82, 165, 225],
        [240, 165, 272],
        [290, 165, 114],
    ];
    let tall_top = [
        [423, 330, 247],
        [265, 330, 296],
        [314, 330, 456],
        [472, 330, 406],
    ];
    add_cornell_block(&mut scene, "short", short_top, white);
    add_cornell_block(&mut scene, "tall", tall_top, tall);
    scene.cameras.push(Camera {
        name: "front".into(),
        eye: DVec3::new(278.0, 273.0, -800.0),
        target: DVec3::new(278.0, 273.0, -799.0),
        up: DVec3::Y,
        vertical_fov: 39.307_724f64.to_radians(),
        size: Some((512, 512)),
    });
    scene
}

type Quad = [DVec3; 4];

fn add_quad(scene: &mut Scene, name: impl Into<String>, quad: Quad, material: MaterialId) {
    let mut mesh = Mesh {
        positions: quad.to_vec(),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3], material);
    scene.objects.push(Object::new(name, Shape::Mesh(mesh)));
}

fn add_cornell_room(
    scene: &mut Scene,
    white: MaterialId,
    red: MaterialId,
    green: MaterialId,
    light: MaterialId,
) {
    let p = DVec3::new;
    let (height, depth) = (548.8, 559.2);
    let floor = [
        p(552.8, 0.0, 0.0),
        p(0.0, 0.0, 0.0),
        p(0.0, 0.0, depth),
        p(549.6, 0.0, depth),
    ];
    let ceiling = [
        p(556.0, height, 0.0),
        p(556.0, height, depth),
        p(0.0, height, depth),
        p(0.0, height, 0.0),
    ];
    let lamp = [
        p(343.0, height, 227.0),
        p(343.0, height, 332.0),
        p(213.0, height, 332.0),
        p(213.0, height, 227.0),
    ];
    add_quad(scene, "floor", floor, white);
    for k in 0..4 {
        // Four trapezoids around the lamp.
        let next = (k + 1) % 4;
        let piece = [ceiling[k], ceiling[next], lamp[next], lamp[k]];
        add_quad(scene, format!("ceiling{k}"), piece, white);
    }
    let [a, b, c, d] = floor;
    let [e, f, g, h] = ceiling;
    add_quad(scene, "back", [d, c, g, f], white);
    add_quad(scene, "right", [c, b, h, g], green);
    add_quad(scene, "left", [a, d, f, e], red);
    add_quad(scene, "light", lamp, light);
}

fn add_cornell_block(scene: &mut Scene, name: &str, top: [[i32; 3]; 4], material: MaterialId) {
    let top = top.map(|c| DVec3::from_array(c.map(f64::from)));
    let foot = |p: DVec3| DVec3::new(p.x, 0.0, p.z);
    add_quad(scene, format!("{name}_top"), top, material);
    for k in 0..4 {
        let (a, b) = (top[k], top[(k + 1) % 4]);
        let side = [b, a, foot(a), foot(b)];
        add_quad(scene, format!("{name}_side{k}"), side, material);
    }
}

/// A closed sphere of radius about 1 with hills of 15 %, of about `triangles` triangles (12 n²):
/// a stand-in for a scanned model, all triangles of similar size.
pub fn displaced_sphere(triangles: usize) -> Scene {
    let mut scene = Scene::default();
    let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
    let n = ((triangles as f64 / 12.0).sqrt().round() as u32).clamp(1, 16_384);
    let mut mesh = Mesh::default();
    add_ball(&mut mesh, DVec3::ZERO, 1.0, n, 0, grey);
    let mut triangulated = Mesh {
        positions: mesh.positions,
        ..Mesh::default()
    };
    for quad in mesh.faces.iter() {
        triangulated.push_face(&[quad[0], quad[1], quad[2]], grey);
        triangulated.push_face(&[quad[0], quad[2], quad[3]], grey);
    }
    scene
        .objects
        .push(Object::new("displaced sphere", Shape::Mesh(triangulated)));
    scene
}

/// Adds a sphere with hills: a cube of n × n cells a side, blown up. Front outside.
fn add_ball(mesh: &mut Mesh, centre: DVec3, radius: f64, n: u32, seed: u32, material: MaterialId) {
    let waves = Waves::new(seed);
    let place = |cube: DVec3| {
        // Equal angles instead of equal lengths: cells of similar size.
        let p = (cube * (PI / 4.0)).map(f64::tan).normalize();
        centre + radius * waves.height(p) * p
    };
    let along = |k: u32| f64::from(2 * k) / f64::from(n) - 1.0;
    for side in 0..6 {
        let place_on_side = |i: u32, j: u32| place(on_cube(side, along(i), along(j)));
        add_grid(mesh, n, n, material, place_on_side);
    }
}

/// Point of the cube −1..=1: side 0..6, whose `u × v` looks outside.
fn on_cube(side: u32, u: f64, v: f64) -> DVec3 {
    match side {
        0 => DVec3::new(1.0, u, v),
        1 => DVec3::new(-1.0, v, u),
        2 => DVec3::new(v, 1.0, u),
        3 => DVec3::new(u, -1.0, v),
        4 => DVec3::new(u, v, 1.0),
        _ => DVec3::new(v, u, -1.0),
    }
}

/// A sum of plane waves: smooth hills in four sizes.
struct Waves([(DVec3, f64, f64); 12]);

impl Waves {
    fn new(seed: u32) -> Waves {
        let mut random = Random(u64::from(seed));
        Waves(std::array::from_fn(|k| {
            let octave = f64::powi(2.0, k as i32 / 3);
            let direction = DVec3::new(random.next(), random.next(), random.next()) - 0.5;
            let frequency = 6.0 * octave * direction.normalize_or_zero();
            (frequency, TAU * random.next(), 0.07 / octave)
        }))
    }

    fn height(&self, p: DVec3) -> f64 {
        let wave = |&(frequency, phase, height): &(DVec3, f64, f64)| {
            height * (frequency.dot(p) + phase).sin()
        };
        1.0 + self.0.iter().map(wave).sum::<f64>()
    }
}

/// SplitMix64 (Steele, Lea and Flood 2014); numbers in 0..1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Adds `nu × nv` quadrilaterals over the vertices `place(i, j)`.
fn add_grid(
    mesh: &mut Mesh,
    nu: u32,
    nv: u32,
    material: MaterialId,
    place: impl Fn(u32, u32) -> DVec3,
) {
    let base = mesh.positions.len() as u32;
    for j in 0..=nv {
        mesh.positions.extend((0..=nu).map(|i| place(i, j)));
    }
    let at = |i: u32, j: u32| base + j * (nu + 1) + i;
    for j in 0..nv {
        for i in 0..nu {
            mesh.push_face(
                &[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)],
                material,
            );
        }
    }
}

/// A closed room of 6 × 5 × 3 metres (z up) with a table, four chairs, shelves full of things,
/// a hanging lamp that emits, and four balls with hills, everything divided into quadrilaterals:
/// what a radiosity mesh looks like.
///
/// About `target_triangles` triangles, two per quadrilateral; never fewer than some 3000.
pub fn furnished_room(target_triangles: usize) -> Scene {
    let target = target_triangles.max(1) as f64;
    // Cells of this size would be right if every face were a whole number of them; a few
    // corrections make up for the rounding.
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

/// A thing of the room, not yet divided.
enum Thing {
    /// Corners, and whether it is seen from inside.
    Box(DVec3, DVec3, bool),
    /// Centre, radius, seed.
    Ball(DVec3, f64, u32),
}

struct Room {
    cell: f64,
    things: Vec<(String, Thing, &'static str)>,
}

fn room(cell: f64) -> Room {
    let mut room = Room {
        cell,
        things: Vec::new(),
    };
    let p = DVec3::new;
    let whole = Thing::Box(DVec3::ZERO, p(6.0, 5.0, 3.0), true);
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
        let ball = Thing::Ball(p(x, y, 1.3 * r), r, k as u32);
        room.things.push((format!("ball{k}"), ball, "clay"));
    }
    room
}

impl Room {
    fn add_box(&mut self, name: impl Into<String>, a: DVec3, b: DVec3, material: &'static str) {
        self.things
            .push((name.into(), Thing::Box(a, b, false), material));
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
                    let ball = Thing::Ball(p(x + r, 4.8, z + 0.03 + 1.3 * r), r, board * 9 + thing);
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
        let count = |thing: &Thing| match *thing {
            Thing::Box(a, b, _) => {
                let [nx, ny, nz] = self.cells(b - a);
                2 * (nx * ny + ny * nz + nz * nx) as usize
            }
            Thing::Ball(_, radius, _) => 6 * (self.ball_cells(radius) as usize).pow(2),
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
                Thing::Box(a, b, inward) => add_box(&mut mesh, a, b, self.cells(b - a), inward, id),
                Thing::Ball(centre, radius, seed) => {
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
            // `first × second` looks along the axis: outside on the upper side only.
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    /// Every directed edge of a closed, consistently turned surface is met by its reverse.
    fn check_closed(mesh: &Mesh) {
        let mut ids: HashMap<[u64; 3], usize> = HashMap::new();
        let mut edges: HashMap<(usize, usize), i32> = HashMap::new();
        for face in mesh.faces.iter() {
            let corner: Vec<usize> = face
                .iter()
                .map(|&v| {
                    // Adding zero makes -0 and 0 the same corner.
                    let key = mesh.positions[v as usize]
                        .to_array()
                        .map(|x| (x + 0.0).to_bits());
                    let next = ids.len();
                    *ids.entry(key).or_insert(next)
                })
                .collect();
            for k in 0..corner.len() {
                let (a, b) = (corner[k], corner[(k + 1) % corner.len()]);
                *edges.entry((a, b)).or_default() += 1;
                *edges.entry((b, a)).or_default() -= 1;
            }
        }
        assert!(edges.values().all(|&n| n == 0));
    }

    /// Volume by Gauss's theorem: positive if the fronts look outside.
    fn volume(mesh: &Mesh) -> f64 {
        let cone = |f: usize| mesh.face_area_vector(f).dot(mesh.face_positions(f)[0]) / 3.0;
        (0..mesh.faces.len()).map(cone).sum()
    }

    fn mesh(object: &Object) -> &Mesh {
        match &object.shape {
            Shape::Mesh(mesh) => mesh,
            _ => panic!("{} is not a mesh", object.name),
        }
    }

    #[test]
    fn cube_is_closed_and_faces_inward() {
        let scene = cube_room();
        scene.validate().unwrap();
        check_closed(mesh(&scene.objects[0]));
        assert_eq!(volume(mesh(&scene.objects[0])), -1.0);
    }

    #[test]
    fn room_is_closed_and_as_large_as_asked() {
        for target in [20_000, 200_000] {
            let scene = furnished_room(target);
            scene.validate().unwrap();
            let meshes = || scene.objects.iter().map(mesh);
            let count: usize = meshes().map(|m| m.faces.triangle_count()).sum();
            let ratio = count as f64 / target as f64;
            assert!(
                (0.9..1.1).contains(&ratio),
                "{count} triangles for {target}"
            );
            meshes().for_each(check_closed);
            assert!((volume(mesh(&scene.objects[0])) + 90.0).abs() < 1e-9);
            assert!(meshes().skip(1).all(|m| volume(m) > 0.0));
        }
    }

    #[test]
    fn sphere_is_closed_and_as_large_as_asked() {
        let scene = displaced_sphere(30_000);
        scene.validate().unwrap();
        let mesh = mesh(&scene.objects[0]);
        check_closed(mesh);
        assert_eq!(mesh.faces.len(), 30_000);
        assert!(volume(mesh) > 3.0);
    }

    #[test]
    fn cornell_box_looks_inward_and_blocks_outward() {
        for variant in [CornellVariant::Diffuse, CornellVariant::MirrorBlock] {
            let scene = cornell_box(variant);
            scene.validate().unwrap();
            assert_eq!(scene.objects.len(), 19);
            let middle = DVec3::new(278.0, 274.0, 280.0);
            for o in &scene.objects[..9] {
                let m = mesh(o);
                let inward = m.face_area_vector(0).dot(middle - m.positions[0]);
                assert!(inward > 0.0, "{}", o.name);
            }
            for block in [&scene.objects[9..14], &scene.objects[14..]] {
                let centre = block[0].bounds().centre() * DVec3::new(1.0, 0.5, 1.0);
                for o in block {
                    let m = mesh(o);
                    let outward = m.face_area_vector(0).dot(m.positions[0] - centre);
                    assert!(outward > 0.0, "{}", o.name);
                }
            }
        }
    }
}
