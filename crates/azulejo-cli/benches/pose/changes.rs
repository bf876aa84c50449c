//! Changes of a scene that leave its light as it is.
//!
//! Each is a pure function of a pose and random numbers. They are applied in the order of [`CHANGES`]:
//! first the surface is divided, then it is moved, then its numbers are rounded, at last it is written.

use super::dice::Dice;
use azulejo_scene::{Attribute, Material, Mesh, Object, Rgb, Scene, Shape};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::HashMap;

/// A changed scene, with what is needed to find the original in it.
#[derive(Clone, Debug)]
pub struct Pose {
    /// The changed scene.
    pub scene: Scene,
    /// From the original to the changed scene.
    pub map: DAffine3,
    /// The size of the original.
    pub size: f64,
    /// The largest distance by which a vertex was moved beside that, in units of the changed scene.
    pub moved: f64,
    /// Extension of the file that it is written to.
    pub extension: &'static str,
    /// `--unit`, with its metres.
    pub unit: Option<(&'static str, f64)>,
    /// Whether the command gets one thread.
    pub is_single: bool,
    /// Formats that keep what the command needs, by their extensions.
    pub formats: &'static [&'static str],
    /// The changes with their parameters.
    pub words: Vec<String>,
}

/// A kind of change.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// Its name in tables and in `--pose`.
    pub name: &'static str,
    /// What it does.
    pub apply: fn(&mut Pose, &mut Dice),
}

/// All changes, in the order in which they are applied.
pub const CHANGES: [Change; 16] = [
    change("triangles", triangles),
    change("quarters", quarters),
    change("welded", |pose, _| weld(pose, true)),
    change("unwelded", |pose, _| weld(pose, false)),
    change("order", order),
    change("double", double),
    change("empty", empty),
    change("unused", unused),
    change("mirrored", mirrored),
    change("scale", scale),
    change("motion", motion),
    change("unit", unit),
    change("rounded", rounded),
    change("float32", float32),
    change("format", format),
    change("threads", threads),
];

/// Name of the copy far away.
const DOUBLE: &str = "double";

const fn change(name: &'static str, apply: fn(&mut Pose, &mut Dice)) -> Change {
    Change { name, apply }
}

impl Pose {
    /// A scene as it is.
    pub fn new(scene: Scene, formats: &'static [&'static str]) -> Pose {
        Pose {
            size: scene.bounds().diagonal(),
            scene,
            map: DAffine3::IDENTITY,
            moved: 0.0,
            extension: "grf",
            unit: None,
            is_single: false,
            formats,
            words: Vec::new(),
        }
    }

    /// The size of the original in this pose.
    fn size_here(&self) -> f64 {
        self.size * self.map.matrix3.determinant().abs().cbrt()
    }

    fn transform(&mut self, map: DAffine3) {
        self.scene = std::mem::take(&mut self.scene).transformed(&map);
        self.map = map * self.map;
    }

    /// Changes each coordinate by a function.
    fn round(&mut self, round: impl Fn(f64) -> f64) {
        let mut moved = 0.0f64;
        for object in &mut self.scene.objects {
            let is_double = object.name == DOUBLE;
            let Shape::Mesh(mesh) = &mut object.shape else {
                continue;
            };
            for position in &mut mesh.positions {
                let exact = *position;
                *position = DVec3::from_array(exact.to_array().map(&round));
                if !is_double {
                    moved = moved.max(position.distance(exact));
                }
            }
        }
        self.moved += moved;
    }
}

/// Polygons become triangles.
fn triangles(pose: &mut Pose, _: &mut Dice) {
    pose.scene.for_each_mesh(Mesh::divide_into_triangles);
    pose.words.push("faces become triangles".into());
}

/// Each triangle becomes four, so that edges stay whole on both of their sides.
fn quarters(pose: &mut Pose, _: &mut Dice) {
    pose.scene.for_each_mesh(|mesh| {
        let faces = faces_of(&mesh.in_triangles(|_| true));
        *mesh = assembled(faces.iter().flat_map(quartered), true);
    });
    pose.words.push("triangles become four".into());
}

fn weld(pose: &mut Pose, is_welded: bool) {
    pose.scene
        .for_each_mesh(|mesh| *mesh = assembled(faces_of(mesh).into_iter(), is_welded));
    let words = ["each face has its own vertices", "vertices are welded"];
    pose.words.push(words[usize::from(is_welded)].into());
}

/// Objects, faces, vertices and the first corner of each face in another order.
fn order(pose: &mut Pose, dice: &mut Dice) {
    pose.scene.for_each_mesh(|mesh| {
        let mut faces = faces_of(mesh);
        dice.shuffle(&mut faces);
        for face in &mut faces {
            let first = dice.below(face.corners.len());
            face.corners.rotate_left(first);
            if let Some(normals) = &mut face.normals {
                normals.rotate_left(first);
            }
        }
        *mesh = assembled(faces.into_iter(), true);
    });
    dice.shuffle(&mut pose.scene.objects);
    pose.words.push("another order".into());
}

/// A copy of a surface that does not shine, 1000 to 10,000 times the size of the scene away. It has fewer faces
/// than the scene: of two worlds that far apart, the larger is exact.
fn double(pose: &mut Pose, dice: &mut Dice) {
    let materials = &pose.scene.materials;
    let is_dark = |mesh: &Mesh| {
        let mut materials = mesh.face_materials.iter().map(|&m| &materials[m as usize]);
        materials.all(|m| !m.is_emitter())
    };
    let meshes = pose.scene.objects.iter().filter_map(|o| match &o.shape {
        Shape::Mesh(mesh) if is_dark(mesh) => Some(mesh.clone()),
        _ => None,
    });
    let meshes: Vec<Mesh> = meshes.collect();
    if meshes.is_empty() {
        return;
    }
    let faces: usize = meshes.iter().map(|mesh| mesh.faces.len()).sum();
    let mut copy = first_faces(dice.one_of(&meshes), faces.saturating_sub(1) / 2);
    if copy.faces.is_empty() {
        return;
    }
    let far = 1e3 * 10f64.powf(dice.unit()) * pose.size_here();
    copy.transform(&DAffine3::from_translation(far * dice.direction()));
    pose.scene
        .objects
        .push(Object::new(DOUBLE, Shape::Mesh(copy)));
    pose.words.push(format!("a double {far:.3e} away"));
}

/// A mesh of at most this many of the first faces of another.
fn first_faces(mesh: &Mesh, most: usize) -> Mesh {
    let mut part = mesh.clone();
    (part.faces, part.face_materials, part.normals) = Default::default();
    for (corners, &material) in mesh.faces.iter().zip(&mesh.face_materials).take(most) {
        part.push_face(corners, material);
    }
    part
}

fn empty(pose: &mut Pose, dice: &mut Dice) {
    let place = dice.below(pose.scene.objects.len() + 1);
    let nothing = Object::new("empty", Shape::Mesh(Mesh::default()));
    pose.scene.objects.insert(place, nothing);
    pose.words.push("an empty object".into());
}

/// Materials that no surface has, before and behind those in use.
fn unused(pose: &mut Pose, _: &mut Dice) {
    let shining = Material {
        emission: Rgb::grey(1e3),
        ..Material::diffuse("unused lamp", Rgb::grey(0.9))
    };
    pose.scene.materials.insert(0, shining);
    for object in &mut pose.scene.objects {
        match &mut object.shape {
            Shape::Mesh(mesh) => mesh.face_materials.iter_mut().for_each(|m| *m += 1),
            Shape::Primitive(p) => p.material += 1,
            Shape::Exact(exact) => exact.map_materials(&mut |m| m + 1),
            Shape::Instance(_) => {}
        }
    }
    pose.scene
        .add_material(Material::diffuse("unused", Rgb::grey(0.1)));
    pose.words.push("unused materials".into());
}

fn mirrored(pose: &mut Pose, _: &mut Dice) {
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    pose.transform(DAffine3::from_mat3(mirror));
    pose.words.push("mirrored".into());
}

fn scale(pose: &mut Pose, dice: &mut Dice) {
    let factor = *dice.one_of(&[1e-3, 1e3]);
    pose.transform(DAffine3::from_scale(DVec3::splat(factor)));
    pose.words.push(format!("times {factor:e}"));
}

/// A rotation, then a translation of 1 to 10,000 times the size.
fn motion(pose: &mut Pose, dice: &mut Dice) {
    let far = 10f64.powf(4.0 * dice.unit()) * pose.size_here();
    let turn = dice.rotation();
    let away = far * dice.direction();
    pose.transform(DAffine3::from_mat3_translation(turn, away));
    pose.words.push(format!("turned, and moved by {far:.3e}"));
}

/// The same lengths in another unit, by the file or by `--unit`.
fn unit(pose: &mut Pose, dice: &mut Dice) {
    let (name, metres) = *dice.one_of(&[("mm", 1e-3), ("m", 1.0), ("in", 0.0254)]);
    let own = pose.scene.units.metres_per_unit.unwrap_or(1.0);
    pose.scene.units.metres_per_unit = Some(own);
    if dice.unit() < 0.5 {
        pose.unit = Some((name, metres));
        pose.words.push(format!("--unit {name}"));
        return;
    }
    pose.transform(DAffine3::from_scale(DVec3::splat(own / metres)));
    pose.scene.units.metres_per_unit = Some(metres);
    pose.words.push(format!("in {name}"));
}

fn rounded(pose: &mut Pose, dice: &mut Dice) {
    let decimals = *dice.one_of(&[5, 6, 7]);
    let step = 10f64.powi(decimals);
    pose.round(|x| (x * step).round() / step);
    pose.words.push(format!("rounded to {decimals} decimals"));
}

fn float32(pose: &mut Pose, _: &mut Dice) {
    pose.round(|x| f64::from(x as f32));
    pose.words.push("32 bits".into());
}

fn format(pose: &mut Pose, dice: &mut Dice) {
    let has_double = pose.scene.objects.iter().any(|o| o.name == DOUBLE);
    // STL makes one object of all, and a double a part of what it is compared with.
    let suits = |format: &&str| !(has_double && *format == "stl");
    let formats: Vec<&'static str> = pose.formats.iter().copied().filter(suits).collect();
    pose.extension = *dice.one_of(&formats);
    pose.words.push(format!("as .{}", pose.extension));
}

fn threads(pose: &mut Pose, _: &mut Dice) {
    pose.is_single = true;
    pose.words.push("one thread".into());
}

/// A face with all that belongs to it.
#[derive(Clone, Debug)]
struct LooseFace {
    corners: Vec<DVec3>,
    normals: Option<Vec<DVec3>>,
    material: u32,
}

fn faces_of(mesh: &Mesh) -> Vec<LooseFace> {
    let face = |face: usize| {
        let range = mesh.faces.corner_range(face);
        let normal = |a: &Attribute<DVec3>| {
            let corners = range.clone().map(|c| a.at(c, mesh.faces.corners[c]));
            corners.collect()
        };
        LooseFace {
            corners: mesh.face_positions(face),
            normals: mesh.normals.as_ref().map(normal),
            material: mesh.face_materials[face],
        }
    };
    (0..mesh.faces.len()).map(face).collect()
}

/// The four triangles of one.
fn quartered(face: &LooseFace) -> [LooseFace; 4] {
    let middles = |values: &[DVec3]| [0, 1, 2].map(|k| 0.5 * (values[k] + values[(k + 1) % 3]));
    let parts = |values: &[DVec3]| {
        let (m, v) = (middles(values), values);
        [
            vec![v[0], m[0], m[2]],
            vec![m[0], v[1], m[1]],
            vec![m[2], m[1], v[2]],
            m.to_vec(),
        ]
    };
    let corners = parts(&face.corners);
    let unit = |part: Vec<DVec3>| -> Vec<DVec3> {
        part.iter().map(|n| n.normalize_or(DVec3::Z)).collect()
    };
    let normals = face.normals.as_ref().map(|n| parts(n).map(unit));
    let part = |k: usize| LooseFace {
        corners: corners[k].clone(),
        normals: normals.as_ref().map(|n| n[k].clone()),
        material: face.material,
    };
    [0, 1, 2, 3].map(part)
}

/// A mesh of loose faces, whose vertices are shared where their positions are the same bits.
fn assembled(faces: impl Iterator<Item = LooseFace>, is_welded: bool) -> Mesh {
    let mut mesh = Mesh::default();
    let mut normals = Vec::new();
    let mut known: HashMap<[u64; 3], u32> = HashMap::new();
    for face in faces {
        let mut vertex = |p: DVec3| {
            let new = mesh.positions.len() as u32;
            let key = p.to_array().map(|x| (x + 0.0).to_bits());
            let index = if is_welded {
                *known.entry(key).or_insert(new)
            } else {
                new
            };
            if index == new {
                mesh.positions.push(p);
            }
            index
        };
        let corners: Vec<u32> = face.corners.iter().map(|&p| vertex(p)).collect();
        mesh.push_face(&corners, face.material);
        normals.extend(face.normals.into_iter().flatten());
    }
    if !normals.is_empty() {
        mesh.normals = Some(Attribute {
            corners: Some((0..normals.len() as u32).collect()),
            values: normals,
        });
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::synthetic::cube_room;

    /// Areas, enclosed volume and validity stay under every change.
    #[test]
    fn changes_keep_the_surface() {
        for change in CHANGES {
            let mut pose = Pose::new(cube_room(), &["grf"]);
            (change.apply)(&mut pose, &mut Dice::new(5, change.name));
            pose.scene.validate().unwrap();
            let scale = pose.map.matrix3.determinant().abs().cbrt();
            let is_first = |o: &&Object| o.name == "cube";
            let cube = pose.scene.objects.iter().find(is_first).unwrap();
            let mesh = cube.shape.mesh().unwrap();
            let off = |x: f64| (x - 1.0).abs() < 1e-4 + 10.0 * pose.moved / scale;
            let area = mesh.area() / (6.0 * scale * scale);
            let volume = mesh.enclosed_volume().unwrap() / scale.powi(3);
            assert!(
                off(area) && off(-volume),
                "{}: {area} {volume}",
                change.name
            );
        }
    }

    #[test]
    fn faces_are_divided() {
        let faces = |name: &str| {
            let mut pose = Pose::new(cube_room(), &["grf"]);
            let change = CHANGES.iter().find(|c| c.name == name).unwrap();
            (change.apply)(&mut pose, &mut Dice::new(5, ""));
            let mesh = pose.scene.objects[0].shape.mesh().unwrap();
            [mesh.faces.len(), mesh.positions.len()]
        };
        assert_eq!(faces("triangles"), [12, 8]);
        assert_eq!(faces("quarters"), [48, 26]);
        assert_eq!(faces("unwelded"), [6, 24]);
        assert_eq!(faces("order"), [6, 8]);
    }
}
