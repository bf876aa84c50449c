use super::read;
use crate::reader_tests::{check_warnings, mesh};
use crate::{Loaded, Memory, ReadOptions};
use azulejo_scene::{Rgb, Up};
use glam::DVec3;
use proptest::prelude::*;

fn load(bytes: &[u8]) -> Loaded {
    let loaded = read(bytes, "a.stl", &Memory::new(), &ReadOptions::default()).unwrap();
    loaded.scene.validate().unwrap();
    loaded
}

fn check_error(bytes: &[u8], expected: &str) {
    let error = read(bytes, "a.stl", &Memory::new(), &ReadOptions::default()).unwrap_err();
    assert_eq!(error.to_string(), expected);
}

const SQUARE: &str = "solid a square
  facet normal 0 0 1
    outer loop
      vertex 0 0 0
      vertex 1 0 0
      vertex 1 1.0e0 0
    endloop
  endfacet
  FACET NORMAL nan nan nan
    OUTER LOOP
      VERTEX -0 0 0
      VERTEX 1 1 0
      VERTEX 0 1 0
    ENDLOOP
  ENDFACET
endsolid a square
";

#[test]
fn text() {
    let loaded = load(SQUARE.as_bytes());
    check_warnings(&loaded, &[]);
    assert_eq!(loaded.scene.objects[0].name, "a square");
    assert_eq!(loaded.scene.units.up, Up::Z);
    assert_eq!(loaded.scene.materials[0].diffuse, Rgb::grey(0.5));
    let mesh = mesh(&loaded, 0);
    assert_eq!(mesh.positions.len(), 4);
    assert_eq!(mesh.faces.corners, [0, 1, 2, 0, 2, 3]);
    let marked = ["\u{feff}", SQUARE].concat().replace('\n', "\r\n");
    assert_eq!(load(marked.as_bytes()).scene, loaded.scene);
}

#[test]
fn every_solid_is_an_object() {
    let twice = [
        SQUARE,
        "solid\nendsolid\n",
        &SQUARE.replace("a square", "b"),
    ]
    .concat();
    let loaded = load(twice.as_bytes());
    let names: Vec<&str> = loaded
        .scene
        .objects
        .iter()
        .map(|o| o.name.as_str())
        .collect();
    assert_eq!(names, ["a square", "b"]);
    assert_eq!(mesh(&loaded, 1), mesh(&load(SQUARE.as_bytes()), 0));
    check_warnings(&loaded, &["a.stl:19:1: solid without facets: skipped"]);
}

#[test]
fn text_with_flaws() {
    let flawed = SQUARE
        .replace("  FACET", "  color 1 0 0\n  FACET")
        .replace("vertex 1 0 0", "vertex inf 0 0")
        .replace("      VERTEX -0 0 0\n", "")
        .replace("endsolid", "");
    check_warnings(
        &load(flawed.as_bytes()),
        &[
            "a.stl:7:12: facet with a vertex that is not finite: skipped",
            "a.stl:9:3: \"color\" is not an STL keyword: line skipped",
            "a.stl:14:12: facet with fewer than three vertices: skipped",
            "a.stl:16:2: \"a\" is not an STL keyword: line skipped",
            "a.stl:17:1: the file ends inside a solid: what precedes the end is kept",
            "a.stl:17:1: solid without facets: skipped",
            "a.stl: no facets: the scene is empty",
        ],
    );
    check_error(
        b"solid\nvertex 1 2 x",
        "a.stl:2:12: found \"x\", expected a number\n   |\n 2 | vertex 1 2 x\n   |            ^",
    );
    check_error(
        b"solid\nvertex 1 2",
        "a.stl:2:11: found the end of the file, expected a number\n   |\n 2 | vertex 1 2\n   |           ^",
    );
}

#[test]
fn facets_outside_solids_are_an_object_too() {
    let bare = SQUARE.replacen("solid", "solidus", 1);
    let loaded = load(bare.as_bytes());
    assert_eq!(mesh(&loaded, 0).faces.len(), 2);
    check_warnings(
        &loaded,
        &["a.stl:1:1: \"solidus\" is not an STL keyword: line skipped"],
    );
}

#[test]
fn text_that_ends_too_soon_keeps_what_is_there() {
    let end = SQUARE.find("  ENDFACET").unwrap();
    let loaded = load(&SQUARE.as_bytes()[..end]);
    assert_eq!(mesh(&loaded, 0).faces.len(), 2);
    let loaded = load(
        [SQUARE.replace("endsolid", "solid").as_bytes(), b"endsolid"]
            .concat()
            .as_slice(),
    );
    assert_eq!(loaded.scene.objects.len(), 1);
    check_warnings(
        &loaded,
        &[
            "a.stl:16:6: solid without an end: it ends where the next one begins",
            "a.stl:17:9: solid without facets: skipped",
        ],
    );
}

const TRIANGLE: [[f32; 3]; 3] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]];

/// A binary file, with two extra bytes after each triangle.
fn binary(header: &[u8], triangles: &[([[f32; 3]; 3], u16)]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for (corners, extra) in triangles {
        bytes.extend([0; 12]);
        bytes.extend(corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(extra.to_le_bytes());
    }
    bytes
}

#[test]
fn binary_with_a_misleading_start() {
    let second = [TRIANGLE[0], TRIANGLE[2], [0., 1., -0.]];
    let bytes = binary(b"solid but not text", &[(TRIANGLE, 0), (second, 0)]);
    let loaded = load(&bytes);
    check_warnings(&loaded, &[]);
    assert_eq!(loaded.scene.objects[0].name, "but not text");
    assert_eq!(mesh(&loaded, 0).faces.corners, [0, 1, 2, 0, 2, 3]);
    assert_eq!(mesh(&loaded, 0).positions[3], DVec3::Y);
    // Also when truncated.
    let loaded = load(&bytes[..bytes.len() - 1]);
    assert_eq!(mesh(&loaded, 0).faces.len(), 1);
    check_warnings(
        &loaded,
        &["a.stl: byte 183 (0xb7): triangles missing from the end of the file"],
    );
}

#[test]
fn binary_with_flaws() {
    let mut far = TRIANGLE;
    far[1][0] = f32::NAN;
    let mut bytes = binary(b"", &[(far, 7)]);
    bytes.extend(b"tail");
    check_warnings(
        &load(&bytes),
        &[
            "a.stl: byte 134 (0x86): 4 bytes after the last triangle: skipped",
            "a.stl: byte 132 (0x84): bytes after triangles that are not colours: ignored",
            "a.stl: byte 84 (0x54): facet with a vertex that is not finite: skipped",
            "a.stl: no facets: the scene is empty",
        ],
    );
    check_error(
        b"short",
        "a.stl: found 5 bytes, expected text that begins with \"solid\", or at least 84 bytes of binary STL",
    );
}

#[test]
fn big_endian_is_told_by_the_length() {
    let little = binary(b"", &[(TRIANGLE, 0)]);
    let mut big = little.clone();
    big[80..].chunks_exact_mut(4).for_each(<[u8]>::reverse);
    let loaded = load(&big);
    assert_eq!(loaded.scene, load(&little).scene);
    check_warnings(
        &loaded,
        &[
            "a.stl: byte 80 (0x50): big-endian numbers, which the format does not allow: read as such",
        ],
    );
    assert_eq!(crate::detect(&big), Ok(crate::Format::Stl));
}

/// Checks the diffuse colours of the triangles of a file.
fn check_colors(header: &[u8], extras: &[u16], expected: &[Rgb]) {
    let triangles: Vec<_> = extras.iter().map(|&extra| (TRIANGLE, extra)).collect();
    let loaded = load(&binary(header, &triangles));
    let materials = mesh(&loaded, 0).face_materials.iter();
    let colors: Vec<Rgb> = materials
        .map(|&m| loaded.scene.materials[m as usize].diffuse)
        .collect();
    assert_eq!(colors, expected);
    let mut distinct: Vec<u64> = expected
        .iter()
        .map(|c| (100.0 * c.luminance()).to_bits())
        .collect();
    distinct.sort_unstable();
    distinct.dedup();
    assert_eq!(loaded.scene.materials.len(), distinct.len());
}

#[test]
fn colors() {
    let (red, blue, grey) = (
        Rgb::new(1.0, 0.0, 0.0),
        Rgb::new(0.0, 0.0, 1.0),
        Rgb::grey(0.5),
    );
    check_colors(
        b"VisCAM",
        &[0xfc00, 0x801f, 0, 0xfc00, 0xffff],
        &[red, blue, grey, red, Rgb::WHITE],
    );
    let header = b"made by Magics COLOR=\x00\xff\x00\xff,MATERIAL=";
    let green = Rgb::new(0.0, 1.0, 0.0);
    check_colors(
        header,
        &[0x001f, 0x7c00, 0x8000, 0xffff],
        &[red, blue, green, green],
    );
    check_colors(b"neither", &[5, 0], &[grey, grey]);
}

#[test]
fn no_solids_at_all() {
    check_warnings(
        &load(&binary(b"", &[])),
        &["a.stl: no facets: the scene is empty"],
    );
}

proptest! {
    #[test]
    fn text_and_binary_are_the_same(corners in prop::collection::vec([0u8..3, 0u8..3, 0u8..3], 3..30)) {
        let corners: Vec<[f32; 3]> = corners.iter().map(|c| c.map(|x| f32::from(x) / 3.0)).collect();
        let (triangles, _) = corners.as_chunks::<3>();
        let facet = |t: &[[f32; 3]; 3]| {
            let vertex = |v: &[f32; 3]| {
                let [x, y, z] = v.map(f64::from);
                format!("vertex {x} {y} {z}\n")
            };
            format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", t.iter().map(vertex).collect::<String>())
        };
        let text = format!("solid\n{}endsolid\n", triangles.iter().map(facet).collect::<String>());
        let binary = binary(b"", &triangles.iter().map(|t| (*t, 0)).collect::<Vec<_>>());
        prop_assert_eq!(load(text.as_bytes()).scene, load(&binary).scene);
    }
}
