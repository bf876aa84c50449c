//! Faces and meshes: corners, colours, materials.

use super::super::opcode::*;
use super::writer::*;
use super::{check_warned, load, load_with, only_mesh, said};
use crate::surface::gloss::Gloss;
use crate::surface::phong::Highlight;
use crate::{Memory, ReadOptions};
use azulejo_scene::{Material, Opacity, Rgb, Sidedness};
use glam::{DVec2, DVec3};

const ORIGIN: [f64; 3] = [0.0; 3];
const WHITE: u32 = 0xffff_ffff;

/// A triangle of three vertex records, which are `size` bytes each.
fn triangle(vertices: [FltRecord; 3]) -> Flt {
    let size = vertices[0].0.len() as u32;
    Flt::of(header(1600))
        .palette(vertices.to_vec())
        .add(face())
        .with(|f| f.add(vertex_list(&[8, 8 + size, 8 + 2 * size])))
}

#[test]
fn vertices_of_every_kind() {
    let at = |opcode, length| move |x, y| FltRecord::new(opcode, length).doubles(8, &[x, y, 0.0]);
    let of = |make: &dyn Fn(f64, f64) -> FltRecord| {
        only_mesh(triangle([make(0.0, 0.0), make(1.0, 0.0), make(0.0, 1.0)]))
    };
    let normal = |r: FltRecord| r.singles(32, &[0.0, 3.0, 4.0]);
    let up = DVec3::new(0.0, 0.6, 0.8);

    let c = of(&at(VERTEX_C, 40));
    assert_eq!((c.normals, c.uvs, c.positions[1]), (None, None, DVec3::X));
    let cn = of(&|x, y| normal(at(VERTEX_CN, 56)(x, y)));
    assert!((cn.normals.unwrap().values[2] - up).length() < 1e-12);
    assert_eq!(cn.uvs, None);
    let cnt = of(&|x, y| normal(at(VERTEX_CNT, 64)(x, y)).singles(44, &[0.25, 0.5]));
    assert!((cnt.normals.unwrap().values[2] - up).length() < 1e-12);
    assert_eq!(cnt.uvs.unwrap().values[1], DVec2::new(0.25, 0.5));
    let ct = of(&|x, y| at(VERTEX_CT, 48)(x, y).singles(32, &[0.25, 0.5]));
    assert_eq!(ct.uvs.unwrap().values[1], DVec2::new(0.25, 0.5));
    assert_eq!((ct.normals, ct.colors.len()), (None, 0));
}

#[test]
fn vertices_without_a_normal_get_the_faces() {
    let with_normal = |x: f64| FltRecord::new(VERTEX_CN, 56).doubles(8, &[x, x * x, 0.0]);
    let tilted = with_normal(1.0).singles(32, &[1.0, 0.0, 0.0]);
    let broken = with_normal(2.0).singles(32, &[f32::NAN, 0.0, 0.0]);
    let mesh = only_mesh(triangle([with_normal(0.0), tilted, broken]));
    let normals = mesh.normals.unwrap();
    let at = |k: u32| normals.at(k as usize, k);
    assert_eq!([at(0), at(1), at(2)], [DVec3::Z, DVec3::X, DVec3::Z]);
}

#[test]
fn vertices_are_shared_within_an_object() {
    let flt = Flt::new().with(|f| {
        f.add(object("a"))
            .with(|f| f.face(face()).face(face()))
            .node(object("b"), &[])
    });
    let loaded = load(flt);
    let count = |k| super::mesh(&loaded, k).positions.len();
    assert_eq!([count(0), count(1)], [4, 4]);
}

#[test]
fn morphs_stand_at_their_start() {
    let pairs = vertex_list(&[8, 128, 48, 128, 88, 128]).u16(0, MORPH_VERTEX_LIST);
    let flt = Flt::new().add(face()).with(|f| f.add(pairs));
    let warning = ("morph vertex list: its state at 0 % is used", 1);
    check_warned(flt.clone(), &[("", &[ORIGIN])], &[warning]);
    assert_eq!(
        super::mesh(&load(flt), 0).positions[2],
        DVec3::new(1.0, 1.0, 0.0)
    );
}

#[test]
fn faces_that_are_no_surfaces_are_left_out() {
    let flt = Flt::new()
        .face(face().u8(18, 2))
        .face(face().u8(18, 3))
        .face(face().u8(18, 9))
        .face(face().u32(44, 1 << 26))
        .face(face().u16(40, u16::MAX))
        .add(face())
        .add(face())
        .with(|f| f.add(vertex_list(&CORNERS[..2])))
        .face(face().u8(18, 1));
    check_warned(
        flt,
        &[("", &[ORIGIN])],
        &[
            ("face drawn as a wireframe: skipped", 2),
            ("face drawn as light points: skipped", 1),
            ("hidden face: skipped", 1),
            ("fully transparent face: skipped", 1),
            ("face without corners: skipped", 1),
            ("face with fewer than three corners: skipped", 1),
        ],
    );
}

#[test]
fn sub_faces_are_kept() {
    let decal = |f: Flt| {
        f.add(FltRecord::new(PUSH_SUBFACE, 4))
            .face(face())
            .add(FltRecord::new(POP_SUBFACE, 4))
    };
    let behind = decal(
        Flt::new()
            .add(object("o"))
            .add(FltRecord::new(PUSH, 4))
            .face(face()),
    );
    let inside = Flt::new()
        .add(object("o"))
        .add(FltRecord::new(PUSH, 4))
        .add(face())
        .with(|f| f.add(vertex_list(&CORNERS)).face(face()));
    let warning = ("sub-face, coplanar with its parent face: both are kept", 1);
    for flt in [behind, inside] {
        let flt = flt.face(face()).add(FltRecord::new(POP, 4));
        check_warned(flt, &[("o", &[ORIGIN, ORIGIN, ORIGIN])], &[warning]);
    }
}

/// The one material of a face, and the warnings.
fn check_material(
    palettes: &[FltRecord],
    face: FltRecord,
    expected: Material,
    warnings: &[(&str, usize)],
) {
    check_material_of(header(1600), palettes, face, expected, warnings);
}

fn check_material_of(
    header: FltRecord,
    palettes: &[FltRecord],
    face: FltRecord,
    expected: Material,
    warnings: &[(&str, usize)],
) {
    let flt = palettes
        .iter()
        .cloned()
        .fold(Flt::of(header).square(), Flt::add);
    let loaded = load(flt.face(face));
    let near = |a: Rgb, b: Rgb| (a - b).map(f64::abs).max_channel() < 1e-6;
    let material = loaded.scene.materials[0].clone();
    assert!(near(material.diffuse, expected.diffuse), "{material:?}");
    let (diffuse, emission) = (material.diffuse, material.emission);
    assert!(near(emission, expected.emission), "{material:?}");
    let expected = Material {
        diffuse,
        emission,
        ..expected
    };
    assert_eq!(material, expected);
    assert_eq!(said(&loaded), warnings);
}

fn matt(r: f64, g: f64, b: f64) -> Material {
    Material {
        sidedness: Sidedness::One,
        ..Material::diffuse("", Rgb::new(r, g, b))
    }
}

/// A palette of two colours.
fn colors() -> FltRecord {
    FltRecord::new(COLOR_PALETTE, 140)
        .u32(132, 0xff00_00ff)
        .u32(136, 0xff00_ff80)
}

#[test]
fn colors_of_faces() {
    let plain = face().u32(44, 0);
    let second = 1 << 7;
    check_material(
        &[colors()],
        plain.clone().u32(68, 127),
        matt(1.0, 0.0, 0.0),
        &[],
    );
    let green = matt(128.0 / 255.0, 1.0, 0.0);
    check_material(
        &[colors()],
        plain.clone().u32(68, second | 127),
        green.clone(),
        &[],
    );
    let dark = 64.0 / 127.0;
    check_material(
        &[colors()],
        plain.clone().u32(68, 64),
        matt(dark, 0.0, 0.0),
        &[],
    );
    check_material(
        &[colors()],
        plain.clone().u32(68, u32::MAX),
        matt(1.0, 1.0, 1.0),
        &[],
    );
    check_material(
        &[colors()],
        plain.clone().u32(68, 9 << 7),
        matt(1.0, 1.0, 1.0),
        &[("face with a colour index beyond the palette: white", 1)],
    );
    // Packed, by the face's flag or the header's.
    let packed = plain.clone().u32(56, 0x0000_00ff);
    let red = matt(1.0, 0.0, 0.0);
    check_material(
        &[colors()],
        packed.clone().u32(44, 1 << 28),
        red.clone(),
        &[],
    );
    check_material_of(header(1600).u32(64, 1 << 30), &[], packed, red.clone(), &[]);
    check_material(&[colors()], face().u32(68, 127), matt(1.0, 1.0, 1.0), &[]);
    // Revision 15.0: index and intensity in the field that later holds the colour name index.
    let old = plain.u16(20, 1 << 7 | 127).u32(68, 127);
    check_material_of(header(1500), &[colors()], old, green, &[]);
}

fn material() -> FltRecord {
    FltRecord::new(MATERIAL_PALETTE, 84)
        .u32(4, 2)
        .text(8, "brick")
        .singles(36, &[0.5, 0.25, 1.0])
        .singles(76, &[1.0])
}

fn lit() -> FltRecord {
    face().u16(30, 2).u8(48, 2)
}

#[test]
fn materials_multiply_the_colours_of_lit_faces() {
    let brick = |r, g, b| Material {
        name: "brick".into(),
        ..matt(r, g, b)
    };
    let red = lit().u32(44, 1 << 28).u32(56, 0xff);
    check_material(&[material()], lit(), brick(0.5, 0.25, 1.0), &[]);
    check_material(&[material()], red, brick(0.5, 0.0, 0.0), &[]);
    check_material(&[material()], lit().u8(48, 0), matt(1.0, 1.0, 1.0), &[]);
    check_material(
        &[],
        lit(),
        matt(1.0, 1.0, 1.0),
        &[("material index that is not in the palette: white", 1)],
    );
    let wrong = material().singles(36, &[2.0, f32::NAN, -1.0]);
    check_material(
        &[wrong],
        lit(),
        brick(1.0, 0.0, 0.0),
        &[("material with a reflectance outside 0..1: clamped", 1)],
    );
}

#[test]
fn materials_glow_and_shine() {
    let glowing = material().singles(60, &[0.0, 2.0, -1.0]);
    let expected = Material {
        name: "brick".into(),
        emission: Rgb::new(0.0, 2.0, 0.0),
        emits_back: true,
        sidedness: Sidedness::Two,
        ..matt(0.5, 0.25, 1.0)
    };
    let warning = "material with negative emission: clamped to 0";
    check_material(&[glowing], lit().u8(18, 1), expected, &[(warning, 1)]);
    let glossy = material()
        .singles(48, &[1.0, 0.5, 0.25])
        .singles(72, &[20.0]);
    let expected = Material {
        name: "brick".into(),
        ..matt(0.5, 0.25, 1.0)
    };
    let highlight = Highlight::half(20.0, Rgb::new(1.0, 0.5, 0.25));
    let mut expected = expected;
    let warning = "glossy material that reflects more light than it receives: scaled to 90%";
    let made = Gloss::default().highlight(&mut expected, highlight);
    assert_eq!(made, Err(warning));
    check_material(&[glossy], lit(), expected, &[(warning, 1)]);
}

#[test]
fn the_old_material_palette_has_all_in_one() {
    let at = 4 + 184 * 3;
    let old = FltRecord::new(OLD_MATERIAL_PALETTE, 4 + 184 * 64)
        .singles(at + 12, &[0.5, 0.25, 1.0])
        .singles(at + 52, &[1.0])
        .text(at + 60, "clay");
    let expected = Material {
        name: "clay".into(),
        ..matt(0.5, 0.25, 1.0)
    };
    check_material_of(
        header(1420),
        &[old],
        lit().u16(30, 3).u16(20, u16::MAX),
        expected,
        &[],
    );
}

#[test]
fn transparency_is_an_opacity() {
    let see_through = |material: Material, opacity: f64| Material {
        opacity: Some(Opacity::constant(opacity)),
        ..material
    };
    let rest = 1.0 - f64::from(1u16 << 15) / 65535.0;
    let half = 1 << 15;
    let white = || matt(1.0, 1.0, 1.0);
    check_material(&[], face().u16(40, half), see_through(white(), rest), &[]);
    let clear = material().singles(76, &[0.5]);
    let brick = Material {
        name: "brick".into(),
        ..matt(0.5, 0.25, 1.0)
    };
    check_material(&[clear], lit(), see_through(brick, 0.5), &[]);
    let glass = object("o").u16(18, half);
    check_warned(Flt::new().node(glass, &[]), &[("o", &[ORIGIN])], &[]);
    let billboard = &[("billboard face: kept in its original orientation", 1)];
    check_material(&[], face().u8(25, 2), white(), billboard);
}

#[test]
fn pictures_are_named() {
    let texture = |index, name: &str| {
        FltRecord::new(TEXTURE_PALETTE, 216)
            .text(4, name)
            .u32(204, index)
    };
    let textured = |index| face().u16(28, index).u32(44, 1 << 28).u32(56, 0xff);
    let flt = Flt::new()
        .add(texture(7, "C:\\art\\brick.rgb"))
        .add(texture(8, "unused.rgb"))
        .face(textured(7))
        .face(textured(7).u8(19, 1))
        .face(textured(9));
    let loaded = load(flt);
    let [picture] = &loaded.scene.textures[..] else {
        panic!("one picture")
    };
    assert_eq!(picture.path, "C:/art/brick.rgb");
    let diffuse: Vec<Rgb> = loaded.scene.materials.iter().map(|m| m.diffuse).collect();
    let red = Rgb::new(1.0, 0.0, 0.0);
    assert_eq!(diffuse, [red, Rgb::WHITE, red]);
    assert_eq!(loaded.scene.materials[1].textures, [0]);
    let messages: Vec<&str> = loaded.warnings.iter().map(|w| &*w.message).collect();
    assert_eq!(
        messages,
        [
            "picture \"C:/art/brick.rgb\" is not used: there is no such file",
            "face with a texture, but without texture coordinates",
            "texture index that is not in the palette: ignored",
        ]
    );
}

#[test]
fn colours_of_vertices() {
    let corner = |x, y, color| vertex([x, y, 0.0], color);
    let red = corner(0.0, 0.0, 0xff00_00ff);
    let indexed = corner(1.0, 0.0, 0).u16(6, 0).u32(36, 127);
    let bare = corner(0.0, 1.0, 0).u16(6, 0x2000);
    let flt = Flt::of(header(1600))
        .palette(vec![red, indexed, bare])
        .add(colors().u32(132, 0xff00_ff00));
    let list = vertex_list(&[8, 48, 88]);
    let gouraud = face().u32(44, 1 << 28).u32(56, 0x00ff_0000).u8(48, 3);
    let plain = gouraud.clone().u8(48, 2);
    let flt = flt
        .with_face(gouraud.clone(), &list)
        .with_face(plain, &list);
    let loaded = load(flt.with_face(gouraud, &list));
    assert_eq!(loaded.warnings, []);
    let mesh = super::mesh(&loaded, 0);
    let of = |face: usize| {
        mesh.faces
            .get(face)
            .iter()
            .map(|&v| mesh.colors[v as usize])
    };
    let (r, g, b) = (
        Rgb::new(1.0, 0.0, 0.0),
        Rgb::new(0.0, 1.0, 0.0),
        Rgb::new(0.0, 0.0, 1.0),
    );
    assert!(of(0).eq([r, g, b]) && of(2).eq([r, g, b]));
    assert!(of(1).eq([Rgb::WHITE; 3]));
    let diffuse = |face: usize| loaded.scene.materials[mesh.face_materials[face] as usize].diffuse;
    assert_eq!([diffuse(0), diffuse(1)], [Rgb::WHITE, b]);
}

impl Flt {
    fn with_face(self, face: FltRecord, list: &FltRecord) -> Flt {
        self.add(face).with(|f| f.add(list.clone()))
    }
}

/// A pool of `count` vertices with all attributes, on a parabola.
fn pool(count: u32) -> FltRecord {
    let attributes = 0b1111_1100 << 24;
    let record = FltRecord::new(LOCAL_VERTEX_POOL, 12)
        .u32(4, count)
        .u32(8, attributes);
    (0..count).fold(record, |record, k| {
        let x = f64::from(k);
        let vertex = FltRecord::new(0, 60)
            .doubles(0, &[x, x * x, 0.0])
            .u32(24, 127)
            .u32(28, 0xff00_0000 | k)
            .singles(32, &[0.0, 0.0, 2.0])
            .singles(44, &[x as f32, 0.5]);
        record.more(&vertex.0)
    })
}

fn primitive(kind: u16, size: u16, indices: &[u32]) -> FltRecord {
    let record = FltRecord::new(MESH_PRIMITIVE, 12)
        .u16(4, kind)
        .u16(6, size)
        .u32(8, indices.len() as u32);
    indices.iter().fold(record, |record, index| {
        record.more(&index.to_be_bytes()[4 - usize::from(size)..])
    })
}

fn check_mesh(primitives: &[FltRecord], expected: &[&[u32]]) {
    let flt = Flt::new().add(object("o")).with(|f| {
        f.add(mesh())
            .add(pool(6))
            .with(|f| primitives.iter().cloned().fold(f, Flt::add))
    });
    let mesh = only_mesh(flt);
    // The position of a vertex encodes its number.
    let numbers = |face: &[u32]| -> Vec<u32> {
        let number = |&v: &u32| mesh.positions[v as usize].x as u32;
        face.iter().map(number).collect()
    };
    let faces: Vec<Vec<u32>> = mesh.faces.iter().map(numbers).collect();
    assert_eq!(faces, expected);
}

#[test]
fn mesh_primitives() {
    let corners = [0, 1, 2, 3, 4, 5];
    for size in [1, 2, 4] {
        check_mesh(
            &[primitive(1, size, &corners)],
            &[&[0, 1, 2], &[2, 1, 3], &[2, 3, 4], &[4, 3, 5]],
        );
    }
    check_mesh(&[primitive(2, 2, &corners[..4])], &[&[0, 1, 2], &[0, 2, 3]]);
    check_mesh(
        &[primitive(3, 2, &corners)],
        &[&[0, 1, 3, 2], &[2, 3, 5, 4]],
    );
    check_mesh(
        &[primitive(4, 2, &corners), primitive(4, 1, &[5, 0, 1])],
        &[&corners, &[5, 0, 1]],
    );
}

#[test]
fn meshes_have_attributes() {
    let flt = Flt::new()
        .add(mesh().u8(52, 1))
        .add(pool(3))
        .with(|f| f.add(primitive(4, 1, &[0, 1, 2])));
    let mesh = only_mesh(flt);
    assert_eq!(mesh.normals.unwrap().values, [DVec3::Z; 3]);
    assert_eq!(mesh.uvs.unwrap().values[2], DVec2::new(2.0, 0.5));
    assert_eq!(mesh.colors[2], Rgb::new(2.0 / 255.0, 0.0, 0.0));
}

#[test]
fn a_pool_may_have_positions_alone() {
    let record = FltRecord::new(LOCAL_VERTEX_POOL, 12)
        .u32(4, 3)
        .u32(8, 1 << 31);
    let pool = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        .iter()
        .fold(record, |r, p| {
            r.more(&FltRecord::new(0, 24).doubles(0, p).0)
        });
    let flt = Flt::new()
        .add(mesh())
        .add(pool)
        .with(|f| f.add(primitive(4, 2, &[0, 1, 2])));
    let mesh = only_mesh(flt);
    assert_eq!(mesh.positions[2], DVec3::Y);
    assert_eq!((mesh.normals, mesh.uvs, mesh.colors.len()), (None, None, 0));
}

#[test]
fn damaged_meshes_are_said() {
    let promising = pool(3).u32(4, 9);
    let colours_only = FltRecord::new(LOCAL_VERTEX_POOL, 12).u32(8, 1 << 30);
    let flt = Flt::new()
        .add(mesh())
        .add(promising)
        .with(|f| {
            f.add(primitive(2, 1, &[0, 1, 2, 3]))
                .add(primitive(4, 2, &[0, 1, 2]).u32(8, 5))
                .add(primitive(7, 2, &[0, 1, 2]))
                .add(primitive(4, 3, &[0, 1, 2]))
        })
        .add(mesh())
        .add(mesh())
        .add(colours_only);
    check_warned(
        flt,
        &[("", &[ORIGIN, ORIGIN])],
        &[
            ("mesh that declares 9 vertices, but has 3", 1),
            (
                "polygon of a mesh with a vertex index out of range: skipped",
                1,
            ),
            ("mesh primitive with fewer indices than declared", 2),
            ("mesh primitive of unknown type: skipped", 1),
            ("mesh without vertex positions: skipped", 2),
        ],
    );
}

#[test]
fn continuations_join() {
    let whole = pool(6);
    let (first, second) = whole.0.split_at(100);
    let (second, third) = second.split_at(60);
    let piece = |bytes: &[u8]| FltRecord::new(CONTINUATION, 4).more(bytes);
    let flt = Flt::new()
        .add(mesh())
        .add(FltRecord(first.to_vec()).u16(2, 100))
        .add(piece(second))
        .add(piece(third))
        .with(|f| f.add(primitive(4, 1, &[0, 1, 2, 3, 4, 5])));
    let mesh = only_mesh(flt);
    assert_eq!(mesh.positions[5], DVec3::new(5.0, 25.0, 0.0));
}

#[test]
fn revisions_before_15_1_index_colours_of_vertices_elsewhere() {
    let corner = |x, y| vertex([x, y, 0.0], WHITE).u16(6, 0).u16(4, 127);
    let flt = Flt::of(header(1420))
        .palette(vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)])
        .add(colors())
        .add(face().u8(48, 1))
        .with(|f| f.add(vertex_list(&[8, 48, 88])));
    let loaded = load_with(flt, &Memory::new(), &ReadOptions::default());
    assert_eq!(super::mesh(&loaded, 0).colors, [Rgb::new(1.0, 0.0, 0.0); 3]);
}
