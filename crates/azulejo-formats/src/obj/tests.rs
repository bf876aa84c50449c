//! Rules of OBJ and MTL, each in a small file.

use super::read;
use crate::reader_tests::mesh;
use crate::surface::model::gltf_mr;
use crate::surface::phong::{Angle, Highlight};
use crate::{Format, Loaded, Memory, Position, detect};
use azulejo_scene::{
    Image, Material, Mesh, NumberPicture, Opacity, OpacityChannel, OpacityPicture, PictureChannel,
    ReliefKind, Rgb, WrapMode,
};
use glam::{DVec2, DVec3};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn load(text: impl AsRef<[u8]>) -> Loaded {
    load_with(text, &Memory::new())
}

fn load_with(text: impl AsRef<[u8]>, files: &Memory) -> Loaded {
    let loaded = read(text.as_ref(), "a.obj", files).unwrap_or_else(|e| panic!("{e}"));
    loaded.scene.validate().unwrap_or_else(|e| panic!("{e}"));
    loaded
}

fn only_mesh(text: impl AsRef<[u8]>) -> Mesh {
    let loaded = load(text);
    assert_eq!(loaded.warnings, []);
    mesh(&loaded, 0).clone()
}

/// Checks the faces that a text adds to the square's vertices.
fn check_faces(text: &str, expected: &[&[u32]]) {
    let mesh = only_mesh(format!("{SQUARE}{text}"));
    assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), expected, "{text}");
}

/// The first line of the error of a text after the square's vertices.
fn check_error(text: &str, expected: &str) {
    let Err(error) = read(
        format!("{SQUARE}{text}").as_bytes(),
        "a.obj",
        &Memory::new(),
    ) else {
        panic!("{text}: read");
    };
    let message = error.to_string();
    assert_eq!(message.lines().next(), Some(expected), "{text}");
}

/// Messages and counts of the warnings of a text after the square's vertices.
fn check_warnings(text: &str, expected: &[(&str, usize)]) {
    let loaded = load(format!("{SQUARE}{text}"));
    let messages: Vec<(&str, usize)> = loaded
        .warnings
        .iter()
        .map(|w| (w.message.as_str(), w.count))
        .collect();
    assert_eq!(messages, expected, "{text}");
}

#[test]
fn index_forms() {
    check_faces("f 1 2 3", &[&[0, 1, 2]]);
    check_faces("f -4 -3 -2 -1", &[&[0, 1, 2, 3]]);
    check_faces("vt 0 0\nf 1/1 2/1 3/1", &[&[0, 1, 2]]);
    check_faces("vn 0 0 1\nf 1//1 2//-1 3//1", &[&[0, 1, 2]]);
    check_faces("vt 0\nvn 0 0 1\nf 1/1/1 2/-1/-1 3/1/1", &[&[0, 1, 2]]);
    check_faces("f 1/ 2// 3/", &[&[0, 1, 2]]);
    check_faces("fo 1 2 3 4", &[&[0, 1, 2, 3]]);
    check_faces("f +1 02 3", &[&[0, 1, 2]]);
    check_faces("f 1 1 1", &[&[0, 0, 0]]);
}

#[test]
fn negative_indices_count_back_from_their_line() {
    let text =
        "v 9 0 0\nv 0 0 0\nv 1 0 0\nf -1 -2 -3\nv 0 2 0\nf -1 -2 -3\nf 6 1 2\nv 0 0 0\nv 6 6 6\n";
    let mesh = only_mesh(text);
    assert_eq!(mesh.positions.len(), 5);
    let faces: Vec<_> = mesh.faces.iter().collect();
    assert_eq!(faces, [[2, 1, 0], [3, 2, 1], [4, 0, 1]]);
    assert_eq!(mesh.positions[4], DVec3::splat(6.0));
}

#[test]
fn wrong_indices() {
    check_error(
        "f 1 0 3",
        "a.obj:5:5: found vertex 0, expected 1 for the first vertex or -1 for the latest",
    );
    check_error(
        "f 1 2 5",
        "a.obj:5:7: found vertex 5, expected 1 to 4, the number of vertices in the file",
    );
    check_error(
        "\t f 1 2 -5",
        "a.obj:5:9: found vertex -5, expected -4 to -1, the number of vertices so far",
    );
    check_error(
        "f 1 2 99999999999999999999",
        "a.obj:5:7: found \"99999999999999999999\", expected a corner like 1, 1/2, 1//3 or 1/2/3",
    );
    check_error(
        "f 1 2 9999999999",
        "a.obj:5:7: found vertex 9999999999, expected 1 to 4, the number of vertices in the file",
    );
    check_error(
        "f 1 2 3.5",
        "a.obj:5:7: found \"3.5\", expected a corner like 1, 1/2, 1//3 or 1/2/3",
    );
    check_error(
        "f 1 2 3/4/5/6",
        "a.obj:5:7: found \"3/4/5/6\", expected a corner like 1, 1/2, 1//3 or 1/2/3",
    );
    check_error(
        "f 1 2 x",
        "a.obj:5:7: found \"x\", expected a corner like 1, 1/2, 1//3 or 1/2/3",
    );
    let error = read(b"f -1 2 3\nv 0 0 0", "a.obj", &Memory::new()).unwrap_err();
    assert_eq!(&*error.found, "vertex -1");
    let missing = "corner whose texture coordinate or normal does not exist: taken without it";
    check_warnings("vn 0 0 1\nf 1/9/1 2/0/1 3//1", &[(missing, 2)]);
    check_warnings("vt 0 0\nf 1//-1 2/-2/1 3//1", &[(missing, 4)]);
}

#[test]
fn wrong_numbers() {
    check_error(
        "v 1 2",
        "a.obj:5:6: found the end of the line, expected x, y and z of a vertex",
    );
    check_error("v 1 2 x3", "a.obj:5:7: found \"x3\", expected a number");
    check_error("v 1,5 2 3", "a.obj:5:3: found \"1,5\", expected a number");
    check_error(
        "  v 1 nan 3",
        "a.obj:5:5: found a vertex at [1, NaN, 3], expected finite coordinates",
    );
    check_error(
        "v 1 -1.#IND 3",
        "a.obj:5:3: found a vertex at [1, NaN, 3], expected finite coordinates",
    );
    check_error(
        "v 1 1e999 3",
        "a.obj:5:3: found a vertex at [1, inf, 3], expected finite coordinates",
    );
    check_error(
        "v 1 2 3 nan",
        "a.obj:5:9: found a number that is not finite, expected a weight or colour",
    );
    check_error(
        "vn 1 2",
        "a.obj:5:7: found the end of the line, expected x, y and z of a normal",
    );
    check_error(
        "vt",
        "a.obj:5:3: found the end of the line, expected u of a texture coordinate",
    );
}

#[test]
fn an_error_shows_its_line_with_any_line_end() {
    for end in ["\n", "\r\n", "\r"] {
        let text = format!("# ñ{end}{end}v 0 0 0{end}f 1 ñ 2 \\{end} 1 é 7 # x{end}v 1 1 1{end}");
        let error = read(text.as_bytes(), "a.obj", &Memory::new()).unwrap_err();
        assert_eq!(error.position, Position::Line(4, 5), "{end:?}");
        let line = error.source_line.as_deref();
        assert_eq!(line, Some("f 1 ñ 2 \\"));
        let text = text.replace('ñ', "1");
        let error = read(text.as_bytes(), "a.obj", &Memory::new()).unwrap_err();
        assert_eq!(error.position, Position::Line(5, 4), "{end:?}");
    }
}

#[test]
fn lines_end_in_every_way() {
    let text = format!("{SQUARE}f 1 2 3\nf 3 4 1 # comment\n");
    for end in ["\n", "\r\n", "\r", "\n\n", " \t\n", "\r\0\0"] {
        check_same(&text, &text.replace('\n', end));
    }
    let mixed = text.replacen('\n', "\r\n", 2).replacen("0\nv", "0\rv", 1);
    check_same(&text, &mixed);
}

fn check_same(a: &str, b: &str) {
    assert_eq!(only_mesh(a), only_mesh(b), "{b:?}");
}

#[test]
fn a_backslash_continues() {
    check_faces("f 1 \\\n 2 3", &[&[0, 1, 2]]);
    check_faces("f 1\\\r\n 2 \\\r3 \\\n\n", &[&[0, 1, 2]]);
    check_faces("# a comment does not \\\nf 1 2 3", &[&[0, 1, 2]]);
    check_warnings(
        "f 1 2 3\nnonsense \\\n f 1 2",
        &[("unknown statement \"nonsense\": skipped", 1)],
    );
    let loaded = load(format!("{SQUARE}o a \\\n  b\\c\nf 1 2 3 \\"));
    assert_eq!(loaded.scene.objects[0].name, "a   b\\c");
}

#[test]
fn comments_and_names() {
    check_faces("f 1 2 3 # 4", &[&[0, 1, 2]]);
    let name_of = |text: &str| {
        load(format!("{SQUARE}{text}\nf 1 2 3")).scene.objects[0]
            .name
            .clone()
    };
    assert_eq!(name_of("o  a b  # comment"), "a b");
    assert_eq!(name_of("o #1"), "#1");
    assert_eq!(name_of("o a#1"), "a#1");
    assert_eq!(name_of("g left wall \t"), "left wall");
    assert_eq!(name_of("o"), "");
    let latin = load(b"v 0 0 0\no ni\xf1o\nf 1 1 1");
    assert_eq!(latin.scene.objects[0].name, "niño");
}

#[test]
fn other_encodings() {
    let text = format!("o año\n{SQUARE}f 1 2 3");
    let expected = load(&text).scene;
    let marked = [b"\xef\xbb\xbf", text.as_bytes()].concat();
    let big: Vec<u8> = "\u{feff}"
        .encode_utf16()
        .chain(text.encode_utf16())
        .flat_map(u16::to_be_bytes)
        .collect();
    let little: Vec<u8> = "\u{feff}"
        .encode_utf16()
        .chain(text.encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect();
    for bytes in [marked, big, little] {
        assert_eq!(load(&bytes).scene, expected);
        assert_eq!(detect(&bytes), Ok(Format::Obj));
        // Without a byte-order mark.
        if let [0xfe | 0xff, _, rest @ ..] = bytes.as_slice() {
            assert_eq!(load(rest).scene, expected);
            assert_eq!(detect(rest), Ok(Format::Obj));
            // Truncated in the middle of a character.
            assert_eq!(load([rest, b"\n"].concat()).scene, expected);
        }
    }
    for padding in ["\0", "\n\0\0\0", "\0\0\0\0"] {
        assert_eq!(load(text.clone() + padding).scene, expected);
    }
    let error = read(b"v 0 0 0\nf \0 1 1", "a.obj", &Memory::new()).unwrap_err();
    assert_eq!(error.position, Position::Byte(10));
}

#[test]
fn vertices_belong_to_objects() {
    let loaded = load(format!(
        "{SQUARE}v 5 5 5\nf 1 2 3\no a\nf 4 3 1\nf 4 2 1\no b\no a\nf 5 5 5\n"
    ));
    let names: Vec<&str> = loaded
        .scene
        .objects
        .iter()
        .map(|o| o.name.as_str())
        .collect();
    assert_eq!(names, ["", "a", "a"]);
    let sizes = [0, 1, 2].map(|i| mesh(&loaded, i).positions.len());
    assert_eq!(sizes, [3, 4, 1]);
    assert_eq!(mesh(&loaded, 1).faces.get(0), [3, 2, 0]);
}

#[test]
fn groups_are_parts_of_objects() {
    let text = "g a\nf 1 2 3\ng a\nf 1 2 4\ng b c\nf 1 3 4\ng a\nf 2 3 4\n";
    let names = |text: &str| -> Vec<String> {
        load(format!("{SQUARE}{text}"))
            .scene
            .objects
            .into_iter()
            .map(|o| o.name)
            .collect()
    };
    assert_eq!(names(text), ["a", "b c", "a"]);
    assert_eq!(names(&format!("o x\n{text}")), ["x/a", "x/b c", "x/a"]);
    let rooms = "o x\nf 1 2 3\ng\nf 1 2 4\ng x\nf 1 2 3\ng a\nf 1 2 3\no y\nf 1 2 3\n";
    assert_eq!(names(rooms), ["x", "x/a", "y"]);
}

#[test]
fn vertices_with_weights_and_colours() {
    let colored = only_mesh("v 0 0 0\nv 1 0 0 1 0 0.5\nv 0 1 0 1 0 0 1\nf 1 2 3");
    let colors = [Rgb::WHITE, Rgb::new(1.0, 0.0, 0.5), Rgb::new(0.0, 0.0, 1.0)];
    assert_eq!(colored.colors, colors);
    let plain = load(format!("{SQUARE}v 0 0 0 1 1 1\no a\nf 1 2 3\no b\nf 1 2 5"));
    assert_eq!(mesh(&plain, 0).colors, []);
    assert_eq!(mesh(&plain, 1).colors.len(), 3);
    assert_eq!(
        only_mesh("v 1 2 3 1.0\nf 1 1 1").positions[0],
        DVec3::new(1.0, 2.0, 3.0)
    );
    check_warnings(
        "v 1 2 3 0.5\nf 1 2 5",
        &[(
            "vertex with a weight w: not used, weights apply only to rational surfaces",
            1,
        )],
    );
    check_warnings(
        "v 1 2 3 0 2 0\nf 1 2 5",
        &[("vertex colour outside 0..1: clamped", 1)],
    );
    check_warnings(
        "v 1 2 3 4 5\nf 1 2 5",
        &[(
            "numbers after x, y and z that are neither weight nor colour: skipped",
            1,
        )],
    );
}

#[test]
fn colours_from_zbrush() {
    let painted = only_mesh(
        "v 0 0 0\nv 1 0 0\n#MRGB 00ff0000FF00ff00\nv 0 1 0\n# x\n#MRGB 000000ff\nf 1 2 3",
    );
    let pure = |r, g, b| Rgb::new(r, g, b);
    let expected = [
        pure(1.0, 0.0, 0.0),
        pure(0.0, 1.0, 0.0),
        pure(0.0, 0.0, 1.0),
    ];
    assert_eq!(painted.colors, expected);
    let lines = "#MRGB 00808080\n#MRGB 00ffffff\n";
    let tail = only_mesh(format!("{SQUARE}f 1 2 3 4\n{lines}"));
    let linear = f64::from(crate::picture::srgb::linear_from_srgb(128.0 / 255.0));
    assert_eq!(
        tail.colors,
        [Rgb::WHITE, Rgb::WHITE, Rgb::grey(linear), Rgb::WHITE]
    );
    let bad = "#MRGB colours that are not hexadecimal: skipped";
    check_warnings("#MRGB 0080808\nf 1 2 3", &[(bad, 1)]);
    let many = "more #MRGB colours than vertices: skipped";
    check_warnings(&format!("{}f 1 2 3", lines.repeat(3)), &[(many, 1)]);
    // Without its blank it is an ordinary comment.
    check_warnings("#MRGBX\nf 1 2 3", &[]);
}

#[test]
fn texture_coordinates_and_normals() {
    let shared = only_mesh(format!(
        "{SQUARE}vt 0.5 0.25 9\nvt 1\nvn 0 0 2\nf 1/2/1 2/1/1 3/1/1"
    ));
    let uvs = shared.uvs.unwrap();
    assert_eq!((uvs.corners, uvs.values[0]), (None, DVec2::new(1.0, 0.0)));
    assert_eq!(uvs.values[2], DVec2::new(0.5, 0.25));
    assert_eq!(shared.normals.unwrap().values, [DVec3::Z; 3]);

    let creased = only_mesh(format!(
        "{SQUARE}vn 0 0 1\nvn 3 0 4\nvn 0 1 0\nf 1//3 2//3 3//3\nf 1//1 3//1 4//1"
    ));
    let normals = creased.normals.unwrap();
    assert_eq!(normals.values, [DVec3::Z, DVec3::Y]);
    assert_eq!(normals.corners, Some(vec![1, 1, 1, 0, 0, 0]));
    assert_eq!(
        only_mesh("v 0 0 0\nvn 1e300 1e300 0\nf 1//1 1//1 1//1")
            .normals
            .unwrap()
            .values[0]
            .z,
        0.0
    );
}

#[test]
fn missing_attributes_are_filled() {
    let text = format!(
        "{SQUARE}vt 1 1\nvn 0 1 0\nvn 0 0 0\nvn nan 0 0\nf 1/1/1 2/1/1 3/1/1\nf 1//2 3//3 4\n"
    );
    let loaded = load(&text);
    let mesh = mesh(&loaded, 0);
    let normals = mesh.normals.as_ref().unwrap();
    assert_eq!((normals.at(0, 0), normals.at(5, 3)), (DVec3::Y, DVec3::Z));
    assert_eq!(mesh.uvs.as_ref().unwrap().at(5, 3), DVec2::ZERO);
    let warnings: Vec<(&str, usize)> = loaded
        .warnings
        .iter()
        .map(|w| (w.message.as_str(), w.count))
        .collect();
    assert_eq!(
        warnings,
        [
            ("normal that is zero or not finite: dropped", 2),
            (
                "object with texture coordinates at only some corners: (0, 0) at the others",
                1
            ),
            (
                "object with normals at only some corners: face normals at the others",
                1
            ),
        ]
    );
    assert_eq!(only_mesh(format!("{SQUARE}f 1 2 3")).normals, None);
    check_warnings(
        "vt nan 1\nf 1/1 2/1 3/1",
        &[("texture coordinate that is not finite: taken as (0, 0)", 1)],
    );
}

#[test]
fn smoothing_groups() {
    let groups = |text: &str| only_mesh(format!("{SQUARE}{text}")).smoothing;
    assert!(groups("f 1 2 3\nf 1 2 3").is_empty());
    assert_eq!(groups("s 0\nf 1 2 3\ns off\nf 1 2 3"), [0, 0]);
    assert_eq!(
        groups("f 1 2 3\ns 7\nf 1 2 3\ns off\nf 1 2 3\ns on\nf 1 2 3\ns\nf 1 2 3"),
        [0, 7, 0, 1, 0]
    );
    check_warnings(
        "s -1\nf 1 2 3",
        &[("smoothing group that is not a number: taken as off", 1)],
    );
}

#[test]
fn statements_without_surface_are_counted() {
    let points = "points (p) have no surface: skipped";
    let lines = "lines (l) have no surface: skipped";
    check_warnings(
        "f 1 2 3\np 1 2\nl 1 2 3\nl 1/1 2/1",
        &[(points, 2), (lines, 2)],
    );
    check_warnings(
        "f 1 2 3\nf 1 2\nf",
        &[("face of fewer than three corners: skipped", 2)],
    );
    check_warnings(
        "f 1 2 3\nbevel on",
        &[("\"bevel\" does not change the geometry: skipped", 1)],
    );
    let pictures = "\"usemap\" (textures outside materials) is not used: skipped";
    check_warnings("f 1 2 3\nusemap a.png", &[(pictures, 1)]);
    check_warnings("", &[("no faces: the scene is empty", 1)]);
    check_warnings(
        "v 3.1+e2 0 0\nf 1 2 3",
        &[(
            "numbers like 3.1+e2, the exponent's sign before its letter: read as 3.1e+2",
            1,
        )],
    );
}

/// Reads a triangle of material `m`, defined by `mtl`; returns the material and the warnings.
fn material(mtl: &str) -> (Material, Vec<String>) {
    let files = Memory::new().with("m.mtl", format!("newmtl m\n{mtl}"));
    let loaded = load_with(format!("mtllib m.mtl\n{SQUARE}usemtl m\nf 1 2 3"), &files);
    assert_eq!(loaded.scene.materials.len(), 1);
    let warnings = loaded.warnings.iter().map(|w| w.message.clone()).collect();
    (loaded.scene.materials[0].clone(), warnings)
}

fn check_material(mtl: &str, expected: Material, warnings: &[&str]) {
    let (material, messages) = material(mtl);
    let expected = Material {
        name: "m".into(),
        ..expected
    };
    assert_eq!(material, expected, "{mtl}");
    assert_eq!(messages, warnings, "{mtl}");
}

#[test]
fn diffuse_materials() {
    let (half, quarter) = (Rgb::grey(0.5), Rgb::grey(0.25));
    check_material("", Material::diffuse("", half), &[]);
    check_material(
        "Kd 0.25\nKa 1 1 1\nNi 1\nillum 1",
        Material::diffuse("", quarter),
        &[],
    );
    check_material(
        "  Kd 0.1 0.2 0.3 # dark\r\n\tillum 2",
        Material::diffuse("", Rgb::new(0.1, 0.2, 0.3)),
        &[],
    );
    check_material(
        "Ke 17 12 4",
        Material::emitter("", Rgb::new(17.0, 12.0, 4.0)),
        &[],
    );
    let over = "material \"m\" has a reflectance or transmittance outside 0..1: clamped";
    check_material(
        "Kd 2 -1 0.5",
        Material::diffuse("", Rgb::new(1.0, 0.0, 0.5)),
        &[over],
    );
    let dark = "material \"m\" has negative emission: clamped to 0";
    check_material(
        "Kd 0.25\nKe -1 0 0",
        Material::diffuse("", quarter),
        &[dark],
    );
    let sheer = |opacity: f64| Material {
        opacity: Some(Opacity::constant(opacity)),
        ..Material::diffuse("", half)
    };
    check_material("d 0.5", sheer(0.5), &[]);
    check_material(
        "d -halo 0.5",
        sheer(0.5),
        &["\"-halo\" is not used: skipped"],
    );
    check_material("Tr 0.75", sheer(0.25), &[]);
    check_material("Tr 1\nd 0.5", sheer(0.5), &[]);
    check_material("d 0", sheer(0.0), &[]);
    check_material("Tr 0\nd 1", Material::diffuse("", half), &[]);
    let invisible = "material \"m\" has Tr 1 without d, which would be invisible: opaque";
    check_material("Tr 1", Material::diffuse("", half), &[invisible]);
    check_material(
        "Kd xyz 1 1 1",
        Material::diffuse("", half),
        &["colour as CIE xyz or spectrum: skipped"],
    );
    check_material(
        "illum 9",
        Material::diffuse("", half),
        &["material \"m\" has an unknown illum: taken as diffuse"],
    );
}

#[test]
fn glossy_materials_are_kept() {
    let (glossy, messages) = material("Kd 0.25\nKs 0.5\nNs 20");
    assert_eq!(glossy.diffuse, Rgb::grey(0.25));
    let highlight = Highlight::of(&glossy).unwrap();
    assert_eq!((highlight.angle, highlight.n), (Angle::Half, 20.0));
    assert!((highlight.ks.r - 0.5).abs() < 1e-12);
    assert_eq!(messages, Vec::<String>::new());
    let (scaled, messages) = material("Kd 0.75\nKs 1\nNs 1");
    assert!(scaled.diffuse.r < 0.75);
    assert_eq!(
        messages,
        ["glossy material that reflects more light than it receives: scaled to 90%"]
    );
    check_material(
        "Kd 0.25\nKs 0.5\nillum 1",
        Material::diffuse("", Rgb::grey(0.25)),
        &[],
    );
}

#[test]
fn mirrors_and_glass() {
    check_material("Ks 0.9\nillum 3", Material::mirror("", Rgb::grey(0.9)), &[]);
    let both = Material {
        diffuse: Rgb::grey(0.25),
        mirror: Rgb::grey(0.75),
        ..Material::default()
    };
    check_material("Kd 0.25\nKs 0.75\nillum 5", both.clone(), &[]);
    let scaled =
        "material \"m\" reflects more light than it receives (Kd + Ks > 1): both scaled down";
    let dim = Material {
        diffuse: Rgb::grey(0.5),
        mirror: Rgb::grey(0.5),
        ..Material::default()
    };
    check_material("Kd 1\nKs 1\nillum 3", dim, &[scaled]);
    check_material("Ks 1\nNi 1.5\nillum 7", Material::dielectric("", 1.5), &[]);
    check_material("Ni 1.5\nillum 4", Material::dielectric("", 1.5), &[]);
    let mut green = Material::dielectric("", 1.3);
    if let Some(glass) = &mut green.dielectric {
        glass.transmittance = Rgb::new(0.0, 1.0, 0.0);
    }
    check_material("Ni 1.3\nTf 0 1 0\nillum 6\nd 0.1", green, &[]);
    let thin = "material \"m\" is glass without an Ni above 1: taken as 1.5";
    check_material("Ni 1\nillum 7", Material::dielectric("", 1.5), &[thin]);
    check_material("illum 6", Material::dielectric("", 1.5), &[thin]);
    let maya = "material with illum 4 and Ni of 1 or none, as Maya writes for every surface: taken as opaque";
    check_material(
        "Kd 0.25\nNi 1\nTf 1 1 1\nillum 4",
        Material::diffuse("", Rgb::grey(0.25)),
        &[maya],
    );
    let kd = "Kd of a glass material: not used, the Fresnel equations determine reflectance and transmittance";
    check_material(
        "Kd 0.5\nNi 1.5\nillum 7",
        Material::dielectric("", 1.5),
        &[kd],
    );
}

#[test]
fn libraries() {
    let files = Memory::new()
        .with("a b.mtl", "newmtl one\nKd 0.1\n")
        .with("sub/c.mtl", "newmtl two\nmap_Kd pic.png\n")
        .with("d.mtl", "newmtl one\nKd 0.2\n");
    let text = |libs: &str| format!("{SQUARE}usemtl two\nf 1 2 3\n{libs}\nusemtl one\nf 1 2 3");
    let reds = |libs: &str| -> Vec<f64> {
        let loaded = load_with(text(libs), &files);
        let ids = mesh(&loaded, 0).face_materials.clone();
        ids.iter()
            .map(|&m| loaded.scene.materials[m as usize].diffuse.r)
            .collect()
    };
    assert_eq!(reds("mtllib a b.mtl"), [0.5, 0.1]);
    assert_eq!(reds("mtllib a b.mtl sub/c.mtl"), [1.0, 0.1]);
    assert_eq!(reds("mtllib sub/c.mtl a b.mtl"), [1.0, 0.1]);
    assert_eq!(
        reds("mtllib a b.mtl\nmtllib d.mtl\nmtllib .\\.//a b.mtl"),
        [0.5, 0.2]
    );
    let loaded = load_with(text("mtllib nowhere.mtl"), &files);
    let warnings: Vec<String> = loaded.warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(
        warnings,
        [
            "a.obj:7:7: material library \"nowhere.mtl\": there is no such file",
            "a.obj: material that no library defines: taken as grey with reflectance 0.5, for \"two\"",
            "a.obj: material that no library defines: taken as grey with reflectance 0.5, for \"one\"",
        ]
    );
}

#[test]
fn an_error_in_a_library_names_the_model() {
    let check = |mtl: &str, expected: &str| {
        let files = Memory::new().with("m.mtl", mtl);
        let error = read(b"\nmtllib m.mtl\n", "a.obj", &files).unwrap_err();
        assert_eq!(error.to_string(), expected);
    };
    check(
        "newmtl a\nKd 1 x 1",
        "m.mtl:2:6: found \"x\", expected a number\n   |\n 2 | Kd 1 x 1\n   |      ^\n  included from a.obj:2",
    );
    check(
        "newmtl a\nNi nan",
        "m.mtl:2:4: found \"nan\", expected a finite number\n   |\n 2 | Ni nan\n   |    ^\n  included from a.obj:2",
    );
}

/// A picture with an alpha channel is an opacity by this channel, another by its brightness.
#[test]
fn opacity_maps() {
    let (mut grey, mut cut) = (Vec::new(), Vec::new());
    crate::picture::png::write(1, 1, &[255, 0, 0], &mut grey).unwrap();
    let image = Image::opaque(1, 1, vec![[1.0; 3]]).with_alpha(vec![0.5]);
    crate::picture::png::write_linear(&image, &mut cut).unwrap();
    let check = |mtl: &str, picture: (u32, OpacityChannel), expected: &[&str]| {
        let files = Memory::new()
            .with("m.mtl", format!("newmtl m\n{mtl}"))
            .with("grey.png", grey.clone())
            .with("cut.png", cut.clone());
        let loaded = load_with(format!("mtllib m.mtl\n{SQUARE}usemtl m\nf 1 2 3"), &files);
        let opacity = loaded.scene.materials[0].opacity.unwrap();
        let (texture, channel) = picture;
        assert_eq!(opacity.picture, Some(OpacityPicture { texture, channel }));
        let warnings: Vec<&str> = loaded.warnings.iter().map(|w| w.message.as_str()).collect();
        assert_eq!(warnings, expected);
    };
    check("map_d grey.png", (0, OpacityChannel::Luminance), &[]);
    check(
        "map_Kd cut.png\nmap_d cut.png",
        (0, OpacityChannel::Alpha),
        &[],
    );
    check(
        "map_Kd grey.png\nmap_d cut.png",
        (1, OpacityChannel::Alpha),
        &[],
    );
    let placed = "map_d placed otherwise than map_Kd: placed as map_Kd";
    let mtl = "map_Kd grey.png\nmap_d -s 2 2 cut.png";
    check(mtl, (1, OpacityChannel::Alpha), &[placed]);
}

/// Emission, metalness, roughness and relief by pictures, read and written.
#[test]
fn pictures_beside_the_colour() {
    let picture = |pixel: [u8; 3]| {
        let mut file = Vec::new();
        crate::picture::png::write(1, 1, &pixel, &mut file).unwrap();
        file
    };
    let files = |mtl: String| {
        Memory::new()
            .with("m.mtl", mtl)
            .with("grey.png", picture([128; 3]))
            .with("blue.png", picture([128, 128, 255]))
            .with("black.png", picture([0; 3]))
    };
    let of = |mtl: &str| {
        let files = files(format!("newmtl m\n{mtl}"));
        let loaded = load_with(format!("mtllib m.mtl\n{SQUARE}usemtl m\nf 1 2 3"), &files);
        assert!(loaded.warnings.is_empty(), "{mtl}");
        let mut out = Vec::new();
        super::write::write_material(&loaded.scene, &loaded.scene.materials[0], "m", &mut out)
            .unwrap();
        let again = files.with("m.mtl", out);
        let back = load_with(format!("mtllib m.mtl\n{SQUARE}usemtl m\nf 1 2 3"), &again);
        assert_eq!(back.scene.materials, loaded.scene.materials, "{mtl}");
        loaded.scene.materials[0].clone()
    };
    let lamp = of("Ke 2 3 4\nmap_Ke grey.png");
    let emitted = (lamp.emission, lamp.emission_picture);
    assert_eq!(emitted, (Rgb::new(2.0, 3.0, 4.0), Some(0)));
    assert_eq!(of("map_Ke grey.png").emission, Rgb::WHITE);
    assert!(!of("Ke 1\nmap_Ke black.png").is_emitter());
    let finish = of("Kd 0.5\nPr 0.5\nmap_Pm -imfchan b blue.png\nmap_Pr grey.png").finish;
    let finish = finish.unwrap();
    assert_eq!((finish.metallic, finish.roughness), (1.0, 0.5));
    let blue = NumberPicture {
        texture: 0,
        channel: PictureChannel::Blue,
    };
    assert_eq!(finish.metallic_picture, Some(blue));
    let relief = |mtl: &str| of(mtl).relief.unwrap().kind;
    let normals = |scale: f64| ReliefKind::Normals { scale };
    assert_eq!(relief("norm blue.png"), normals(1.0));
    assert_eq!(relief("map_Bump -bm 0.5 blue.png"), normals(0.5));
    let heights = ReliefKind::Heights { slope: 0.25 };
    assert_eq!(relief("bump -bm 0.25 grey.png"), heights);
}

#[test]
fn pictures() {
    let mut png = Vec::new();
    crate::picture::png::write(1, 1, &[255, 0, 0], &mut png).unwrap();
    let files = Memory::new()
        .with("sub/m.mtl", "newmtl m\nmap_Kd -s 1 1 1 -o 0.5 -clamp on -mm 0 1 a b.png\nnewmtl n\nmap_Kd ./top.png\nnewmtl q\nmap_Kd .\\a b.png\nmap_Kd no.png\n")
        .with("sub/a b.png", png.clone())
        .with("top.png", png);
    let loaded = load_with(
        format!("mtllib sub/m.mtl\n{SQUARE}usemtl m\nf 1 2 3"),
        &files,
    );
    let paths: Vec<&str> = loaded
        .scene
        .textures
        .iter()
        .map(|t| t.path.as_str())
        .collect();
    // Clamped and repeated, the same picture is two textures.
    let expected = ["sub/a b.png", "top.png", "sub/a b.png", "sub/no.png"];
    assert_eq!(paths, expected);
    let wraps = [0, 2].map(|k: usize| loaded.scene.textures[k].wrap);
    assert_eq!(wraps, [[WrapMode::Clamp; 2], [WrapMode::Repeat; 2]]);
    let image = loaded.scene.textures[0].image.as_ref().unwrap();
    assert_eq!(image.pixels, [[1.0, 0.0, 0.0]]);
    assert_eq!(loaded.scene.materials[0].textures, [0]);
    assert_eq!(loaded.scene.materials[0].diffuse, Rgb::WHITE);
    assert_eq!(loaded.scene.materials[2].textures, [3]);
    let warnings: Vec<&str> = loaded.warnings.iter().map(|w| w.message.as_str()).collect();
    let missing = "picture \"sub/no.png\" is not used: there is no such file";
    assert_eq!(warnings, [missing]);
}

fn check_rough(mtl: &str, metallic: f64, roughness: f64, warnings: &[&str]) {
    let (material, messages) = material(mtl);
    let expected = Some((Rgb::grey(0.5), metallic, roughness));
    assert_eq!(gltf_mr(&material), expected, "{mtl}");
    assert_eq!(messages, warnings, "{mtl}");
}

#[test]
fn metals() {
    let smooth = |share: f64| Material {
        diffuse: Rgb::grey(0.5 * (1.0 - share)),
        mirror: Rgb::grey(0.5 * share),
        ..Material::default()
    };
    check_material("Kd 0.5\nPm 1\nPr 0", smooth(1.0), &[]);
    check_material("Kd 0.5\nKs 0.5\nillum 3\nPm 0.25\nPr 0", smooth(0.25), &[]);
    check_material("Kd 0.5\nPm 1\nPr 0\nillum 4\nNi 1", smooth(1.0), &[]);
    check_material(
        "Pm 1\nPr 0\nillum 7\nNi 1.5",
        Material::dielectric("", 1.5),
        &[],
    );
    let silent = "metal (Pm) without roughness (Pr): taken as fully rough";
    check_rough("Kd 0.5\nPm 1\nPr 0.5\nillum 3", 1.0, 0.5, &[]);
    check_rough("Kd 0.5\nPm 1", 1.0, 1.0, &[silent]);
    check_rough("Kd 0.5\nPr 0.25", 0.0, 0.25, &[]);
    check_material("Kd 0.5\nPr 1", smooth(0.0), &[]);
    check_material(
        "Kd 0.5\nPm 0\nPs 0\nPc 0.0\nPcr 0\naniso 0\nanisor 0",
        smooth(0.0),
        &[],
    );
    let unused = |key: &str| format!("\"{key}\" is not used: skipped");
    let keys = ["Ps", "Pc", "Pcr", "aniso", "anisor", "map_Ks", "map_Ns"];
    for key in keys.into_iter().chain(["disp", "decal", "refl"]) {
        check_material(&format!("{key} 1"), smooth(0.0), &[&unused(key)]);
    }
}

/// Texture coordinates of a triangle of two objects, the first with these options on its texture.
fn check_placement(options: &str, expected: [[f64; 2]; 3], warnings: usize) {
    let mtl = format!("newmtl m\nmap_Kd {options} a.png\nnewmtl n\n");
    let files = Memory::new().with("m.mtl", mtl);
    let text = "mtllib m.mtl\nvt 0 0\nvt 1 0\nvt 1 2\n\
                usemtl m\nf 1/1 2/2 3/3\nusemtl n\nf 1/1 2/2 4/3\n";
    let loaded = load_with(format!("{SQUARE}{text}"), &files);
    let uvs = mesh(&loaded, 0).uvs.as_ref().unwrap();
    let coordinates = [0, 1, 2].map(|k| uvs.at(k, k as u32).to_array());
    assert_eq!(coordinates, expected, "{options}");
    assert_eq!(uvs.at(5, 3).to_array(), [1.0, 2.0], "{options}");
    // One warning is about the missing texture.
    assert_eq!(loaded.warnings.len(), 1 + warnings, "{options}");
}

#[test]
fn pictures_are_placed() {
    check_placement("", [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]], 0);
    check_placement("-s 2 3 1", [[0.0, 0.0], [2.0, 0.0], [2.0, 6.0]], 0);
    check_placement("-o 0.5 -s 2", [[0.5, 0.0], [2.5, 0.0], [2.5, 2.0]], 0);
    check_placement("-s 1e308 1e308", [[0.0, 0.0], [1e308, 0.0], [1.0, 2.0]], 0);
    let plain = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]];
    check_placement("-clamp off -blendu on -blendv on -cc off -mm 0 1", plain, 0);
    check_placement("-t 0 0 0", plain, 0);
    check_placement("-t 1 -clamp on -mm 0 2 -blendu off", plain, 3);
}

#[test]
fn placed_pictures_on_surfaces() {
    let files = Memory::new().with("m.mtl", "newmtl m\nmap_Kd -o 0.5 0.25 a.png");
    let surface = "cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 4 3\nparm u 0 1\nparm v 0 1\nend";
    let text = format!("mtllib m.mtl\n{SQUARE}usemtl m\n{surface}");
    let loaded = load_with(text, &files);
    let uvs = mesh(&loaded, 0).uvs.as_ref().unwrap();
    assert_eq!(uvs.corners, None);
    assert_eq!(uvs.values[0], DVec2::new(0.5, 0.25));
}

#[test]
fn truncated_or_changed_anywhere() {
    let obj = format!(
        "o a\r\nmtllib m.mtl\n{SQUARE}v 1 1 1 1 0 0\nvt 0 1\nvn 0 0 1\ng b\ns 1\nusemtl m\nf 1/1/1 2//1 -1 \\\n 4\nl 1 2\n# x"
    );
    let mtl = "newmtl m\nKd 1 0.5 0\nKs 1\nNs 10\nillum 3\nTf 1 1 1\nmap_Kd -s 1 a.png\nd 0.5\n";
    for end in 0..=obj.len() {
        survive(&obj.as_bytes()[..end], mtl.as_bytes());
    }
    for end in 0..=mtl.len() {
        survive(obj.as_bytes(), &mtl.as_bytes()[..end]);
    }
    for value in b"\0\n\r \\#/-+.e0459fv\xff\x80" {
        for at in 0..obj.len() {
            let mut changed = obj.clone().into_bytes();
            changed[at] = *value;
            survive(&changed, mtl.as_bytes());
        }
        for at in 0..mtl.len() {
            let mut changed = mtl.as_bytes().to_vec();
            changed[at] = *value;
            survive(obj.as_bytes(), &changed);
        }
    }
}

/// Reads; a resulting scene must be valid.
fn survive(obj: &[u8], mtl: &[u8]) {
    let files = Memory::new().with("m.mtl", mtl);
    match read(obj, "a.obj", &files) {
        Ok(loaded) => loaded.scene.validate().unwrap_or_else(|e| panic!("{e}")),
        Err(e) => assert!(!e.to_string().is_empty()),
    }
}

/// Blender writes sRGB and says who it is; whoever says something else is believed.
#[test]
fn colours_by_blender_are_srgb() {
    let check = |first: &str, colors: Option<crate::VertexColors>, expected: f64, warned: usize| {
        let text = format!("{first}\nv 0 0 0 0.5 0 1\nv 1 0 0 0.5 0 1\nv 0 1 0 0.5 0 1\nf 1 2 3\n");
        let options = crate::ReadOptions {
            vertex_colors: colors,
            ..crate::ReadOptions::default()
        };
        let files = Memory::new();
        let loaded = crate::obj::read_with(text.as_bytes(), "a.obj", &files, &options).unwrap();
        let azulejo_scene::Shape::Mesh(mesh) = &loaded.scene.objects[0].shape else {
            panic!("a mesh")
        };
        let color = mesh.colors[0];
        assert!((color.r - expected).abs() < 1e-4, "{first}: {color:?}");
        assert_eq!((color.g, color.b), (0.0, 1.0));
        assert_eq!(loaded.warnings.len(), warned, "{first}");
    };
    let srgb = 0.21404;
    check("# Blender 5.3.0\n# www.blender.org", None, srgb, 1);
    check("# Blender 5.3.0", Some(crate::VertexColors::Linear), 0.5, 0);
    check("# from Blender", None, 0.5, 0);
    check("# anything", Some(crate::VertexColors::Srgb), srgb, 0);
}
