use super::{losses, read, write};
use crate::reader_tests::check_warnings;
use crate::{Loaded, Memory, ReadOptions, VertexColors};
use azulejo_scene::{
    Attribute, Light, LightKind, Material, Mesh, Object, Primitive, Rgb, Scene, Shape, SurfaceGrid,
    SurfaceLight, Texture, Units, Up,
};
use glam::{DVec2, DVec3};
use proptest::prelude::*;

fn load(bytes: &[u8]) -> Loaded {
    load_with(bytes, &Memory::new())
}

fn load_with(bytes: &[u8], files: &Memory) -> Loaded {
    let loaded = read(bytes, "a.ply", files, &ReadOptions::default()).unwrap();
    loaded.scene.validate().unwrap();
    loaded
}

fn check_error(text: &str, expected: &str) {
    let error = read(
        text.as_bytes(),
        "a.ply",
        &Memory::new(),
        &ReadOptions::default(),
    );
    let message = error.unwrap_err().to_string();
    assert_eq!(message.lines().next(), Some(expected));
}

fn mesh(scene: &Scene, object: usize) -> &Mesh {
    match &scene.objects[object].shape {
        Shape::Mesh(mesh) => mesh,
        _ => unreachable!("PLY has meshes only"),
    }
}

const SQUARE: &str = "ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
1 1 0
0 1 0
4 0 1 2 3
";

#[test]
fn text() {
    let loaded = load(SQUARE.as_bytes());
    check_warnings(&loaded, &[]);
    let mesh = mesh(&loaded.scene, 0);
    assert_eq!(mesh.positions[2], DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(mesh.faces.get(0), [0, 1, 2, 3]);
    assert_eq!(loaded.scene.materials[0].diffuse, Rgb::grey(0.5));
    assert!(mesh.normals.is_none() && mesh.uvs.is_none() && mesh.colors.is_empty());
    for ends in ["\r\n", "\r", "  \n\n"] {
        assert_eq!(
            load(SQUARE.replace('\n', ends).as_bytes()).scene,
            loaded.scene
        );
    }
    let alike = SQUARE
        .replace("vertex_indices", "vertex_index")
        .replace("float", "float64");
    assert_eq!(load(alike.as_bytes()).scene, loaded.scene);
}

/// The square in binary, with other scalar types, big-endian if `big` holds.
fn binary_square(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let header = SQUARE.split_inclusive("end_header\n").next().unwrap();
    let header = header
        .replace("ascii", &format!("binary_{order}_endian"))
        .replace(
            "property float y",
            "property double y\nproperty short flags",
        )
        .replace("property float z", "property char z")
        .replace("uchar int", "ushort uint");
    let mut bytes = header.into_bytes();
    let mut put = |number: &[u8]| {
        if big {
            bytes.extend(number.iter().rev())
        } else {
            bytes.extend(number)
        }
    };
    for [x, y] in [[0, 0], [1, 0], [1, 1], [0, 1u8]] {
        put(&f32::from(x).to_le_bytes());
        put(&f64::from(y).to_le_bytes());
        put(&(-2i16).to_le_bytes());
        put(&[0]);
    }
    put(&4u16.to_le_bytes());
    (0..4u32).for_each(|i| put(&i.to_le_bytes()));
    bytes
}

#[test]
fn binary_of_both_orders() {
    let text = load(SQUARE.as_bytes());
    for big in [false, true] {
        let loaded = load(&binary_square(big));
        assert_eq!(loaded.scene, text.scene);
        check_warnings(
            &loaded,
            &["a.ply:3:1: property \"flags\" of \"vertex\": skipped"],
        );
    }
}

#[test]
fn the_first_byte_may_look_like_a_line_end() {
    let header = SQUARE.split_inclusive("end_header\n").next().unwrap();
    let header = header
        .replace("ascii", "binary_little_endian")
        .replace("float", "uchar");
    let rows = [10, 13, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 3];
    let mut bytes = header.into_bytes();
    bytes.extend(rows);
    (0..3i32).for_each(|i| bytes.extend(i.to_le_bytes()));
    assert_eq!(
        mesh(&load(&bytes).scene, 0).positions[0],
        DVec3::new(10.0, 13.0, 0.0)
    );
}

#[test]
fn headers_that_cannot_be() {
    check_error(
        "plx\n",
        "a.ply:1:1: found \"plx\", expected a PLY file, which begins with \"ply\"",
    );
    check_error(
        "ply\nelement vertex 1\n",
        "a.ply:3:1: found the end of the file, expected the end of the header, end_header",
    );
    check_error(
        "ply\nend_header\n",
        "a.ply:2:1: found \"end_header\", expected the format before the end of the header",
    );
    check_error(
        "ply\nformat acsii 1.0\n",
        "a.ply:2:8: found \"acsii\", expected ascii, binary_little_endian or binary_big_endian",
    );
    check_error(
        "ply\nelement vertex -1\n",
        "a.ply:2:16: found \"-1\", expected a number of elements",
    );
    check_error(
        "ply\nproperty int x\n",
        "a.ply:2:10: found \"int\", expected an element before its properties",
    );
    check_error(
        "ply\nelement vertex 1\nproperty list uchar long x\n",
        "a.ply:3:21: found \"long\", expected a scalar type (char, uchar, short, ushort, int, uint, float, double)",
    );
    check_error(
        &SQUARE.replace("property float z\n", ""),
        "a.ply:3:1: found vertices without x, y or z, expected these three properties",
    );
}

#[test]
fn strange_lines_of_headers_are_passed() {
    let text = SQUARE.replace("element face", "made by hand\n\nelement face");
    let loaded = load(text.as_bytes());
    assert_eq!(loaded.scene, load(SQUARE.as_bytes()).scene);
    check_warnings(
        &loaded,
        &["a.ply:7:1: header line that is not a PLY statement: skipped"],
    );
}

#[test]
fn rows_that_cannot_be() {
    check_error(
        &SQUARE.replace("1 1 0", "1 one 0"),
        "a.ply:12:3: found \"one\", expected a number",
    );
    check_error(
        &SQUARE.replace("1 1 0", "1 1"),
        "a.ply:12:4: found the end of the line, expected as many numbers as the header declares",
    );
    check_error(
        &SQUARE.replace("4 0 1 2 3", "4 0 1 2\n"),
        "a.ply:14:8: found the end of the line, expected as many numbers as the header declares",
    );
}

#[test]
fn rows_that_are_odd() {
    let odd = SQUARE
        .replace("element face 1", "element face 4")
        .replace("1 1 0", "1 1 0 7 8")
        .replace(
            "4 0 1 2 3",
            "3 0 1 2\n2 0 1\n3 0 1 -1\n3 0 1 4\n\nlast words",
        );
    let loaded = load(odd.as_bytes());
    assert_eq!(mesh(&loaded.scene, 0).faces.len(), 1);
    check_warnings(
        &loaded,
        &[
            "a.ply: face with fewer than three corners: skipped",
            "a.ply:12:7: numbers after the last property of a line: skipped",
            "a.ply:19:1: text after the last element: skipped",
            "a.ply: face with a vertex that does not exist or is not finite: skipped (2 times)",
        ],
    );
    let nowhere = load(SQUARE.replace("1 1 0", "1 nan 0").as_bytes());
    assert!(nowhere.scene.objects.is_empty());
    let listless = SQUARE.replace(
        "element face",
        "property list uchar int extra\nelement face",
    );
    check_warnings(
        &load(listless.as_bytes()),
        &[
            "a.ply:3:1: property \"extra\" of \"vertex\": skipped",
            "a.ply:11:6: line that ends before a list: the list is taken as empty (4 times)",
        ],
    );
}

#[test]
fn files_that_end_too_soon_keep_what_is_there() {
    let cut = SQUARE.replace("element face 1", "element face 4000000000");
    let loaded = load(cut.as_bytes());
    assert_eq!(loaded.scene, load(SQUARE.as_bytes()).scene);
    check_warnings(
        &loaded,
        &["a.ply:15:1: elements \"face\" missing from the end of the file (3999999999 times)"],
    );
    let binary = binary_square(false);
    check_warnings(
        &load(&binary[..binary.len() - 40]),
        &[
            "a.ply:3:1: property \"flags\" of \"vertex\": skipped",
            "a.ply: byte 230 (0xe6): elements \"vertex\" missing from the end of the file (2 times)",
            "a.ply: byte 230 (0xe6): elements \"face\" missing from the end of the file",
            "a.ply: no faces: 2 points without a surface, the scene is empty",
        ],
    );
    let start = binary.len() - 70;
    for end in start..binary.len() {
        load(&binary[..end]);
    }
}

/// Elements whose lines would each be counted from the start of the file.
#[test]
fn very_many_elements_take_no_quadratic_time() {
    let elements: String = (0..200_000)
        .map(|k| format!("element e{k} 0\nproperty float p\n"))
        .collect();
    let text = SQUARE.replace("element face", &format!("{elements}element face"));
    assert_eq!(mesh(&load(text.as_bytes()).scene, 0).faces.len(), 1);
}

#[test]
fn a_cloud_of_points_has_no_surface() {
    let cloud = SQUARE.split("element face").next().unwrap();
    let cloud = format!(
        "{cloud}element edge 0\nproperty int a\nelement nothing 9999999999\nend_header\n0 0 0\n1 1 1\n1 2 3\n4 5 6\n"
    );
    check_warnings(
        &load(cloud.as_bytes()),
        &[
            "a.ply:9:1: elements \"nothing\": skipped (9999999999 times)",
            "a.ply: no faces: 4 points without a surface, the scene is empty",
        ],
    );
}

/// The square with more properties, whose values are the same for all vertices.
fn with_properties(properties: &str, values: &str) -> Loaded {
    let properties: String = properties
        .split(',')
        .map(|p| format!("property {}\n", p.trim()))
        .collect();
    let text = SQUARE.replace(
        "property float z\n",
        &format!("property float z\n{properties}"),
    );
    let rows = ["0 0 0\n", "1 0 0\n", "1 1 0\n", "0 1 0\n"];
    let text = rows.iter().fold(text, |text, row| {
        text.replace(row, &format!("{} {values}\n", row.trim_end()))
    });
    load(text.as_bytes())
}

#[test]
fn normals_and_texture_coordinates() {
    let loaded = with_properties(
        "float nx, float ny, float nz, float u, float v",
        "0 0 2 0.25 0.5",
    );
    check_warnings(&loaded, &[]);
    let square = mesh(&loaded.scene, 0);
    assert_eq!(
        square.normals,
        Some(Attribute::per_vertex(vec![DVec3::Z; 4]))
    );
    assert_eq!(
        square.uvs,
        Some(Attribute::per_vertex(vec![DVec2::new(0.25, 0.5); 4]))
    );
    for none in ["0 0 0", "nan 0 1", "inf 0 0", "1 nan nan"] {
        let loaded = with_properties("float nx, float ny, float nz", none);
        assert!(mesh(&loaded.scene, 0).normals.is_none());
    }
    let large = with_properties("double nx, double ny, double nz", "0 1e300 0");
    let normals = mesh(&large.scene, 0).normals.as_ref().unwrap();
    assert_eq!(normals.values[0], DVec3::Y);
}

#[test]
fn colors() {
    let check = |properties: &str, values: &str, expected: Rgb, warnings: &[&str]| {
        let loaded = with_properties(properties, values);
        assert_eq!(mesh(&loaded.scene, 0).colors, [expected; 4]);
        assert_eq!(loaded.scene.materials[0].diffuse, Rgb::WHITE);
        check_warnings(&loaded, warnings);
    };
    let color = Rgb::new(1.0, 0.2, 0.0);
    check("uchar red, uchar green, uchar blue", "255 51 0", color, &[]);
    check("float r, float g, float b", "1 0.2 0", color, &[]);
    check(
        "uchar diffuse_red, uchar diffuse_green, uchar diffuse_blue",
        "255 51 0",
        color,
        &[],
    );
    check(
        "float red, float green, float blue",
        "255 51 0",
        color,
        &["a.ply: floating-point vertex colours above 1: scaled from 0..255 (4 times)"],
    );
    check(
        "float red, float green, float blue",
        "1 0.2 -3",
        color,
        &["a.ply: vertex colour outside 0..1: clamped (4 times)"],
    );
}

#[test]
fn colors_of_faces() {
    let text = SQUARE
        .replace("element face 1", "element face 3")
        .replace("vertex_indices", "vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha")
        .replace("4 0 1 2 3", "3 0 1 2 255 0 0 9\n3 0 2 3 0 255 0 9\n3 0 1 3 255 0 0 9");
    let loaded = load(text.as_bytes());
    check_warnings(
        &loaded,
        &["a.ply:7:1: property \"alpha\" of \"face\": skipped"],
    );
    assert_eq!(mesh(&loaded.scene, 0).face_materials, [0, 1, 0]);
    let names: Vec<&str> = loaded
        .scene
        .materials
        .iter()
        .map(|m| m.name.as_str())
        .collect();
    assert_eq!(names, ["#ff0000", "#00ff00"]);
}

#[test]
fn corners_with_texture_coordinates() {
    let text = SQUARE
        .replace(
            "ply\n",
            "ply\ncomment TextureFile a.png\ncomment TextureFile b.png\n",
        )
        .replace("element face 1", "element face 2")
        .replace(
            "vertex_indices",
            "vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber",
        )
        .replace("4 0 1 2 3", "3 0 1 2 6 0 0 1 0 1 1 1\n3 0 2 3 4 9 9 9 9 0");
    let mut png = Vec::new();
    crate::picture::png::write(1, 1, &[255, 0, 0], &mut png).unwrap();
    let loaded = load_with(text.as_bytes(), &Memory::new().with("B.png", png));
    check_warnings(
        &loaded,
        &[
            "a.ply: face without a texture coordinate for each corner: (0, 0) is used",
            "a.ply: picture \"a.png\" is not used: there is no such file",
        ],
    );
    let square = mesh(&loaded.scene, 0);
    let uvs = square.uvs.as_ref().unwrap();
    assert_eq!((uvs.at(1, 1), uvs.at(2, 2)), (DVec2::X, DVec2::ONE));
    assert_eq!(
        (uvs.at(4, 2), uvs.at(5, 3)),
        (DVec2::splat(9.0), DVec2::ZERO)
    );
    let of_face = |f: usize| &loaded.scene.materials[square.face_materials[f] as usize];
    assert_eq!(
        (of_face(0).textures.as_slice(), of_face(0).diffuse),
        (&[1][..], Rgb::WHITE)
    );
    assert_eq!(
        (of_face(1).textures.as_slice(), of_face(1).diffuse),
        (&[0][..], Rgb::grey(0.5))
    );
}

#[test]
fn strips() {
    let text = SQUARE
        .replace("element face", "element tristrips")
        .replace("4 0 1 2 3", "9 0 1 2 3 3 -1 3 2 1");
    let loaded = load(text.as_bytes());
    let faces: Vec<&[u32]> = mesh(&loaded.scene, 0).faces.iter().collect();
    assert_eq!(faces, [[0, 1, 2], [2, 1, 3], [3, 2, 1]]);
}

#[test]
fn faces_may_stand_before_their_vertices() {
    let text = "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_index\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n3 0 1 2\n3 0 1 3\n0 0 0\n1 0 0\n0 1 0\n";
    assert_eq!(mesh(&load(text.as_bytes()).scene, 0).faces.len(), 1);
}

fn written(scene: &Scene) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(scene, &mut bytes).unwrap();
    bytes
}

fn read_back(scene: &Scene) -> Scene {
    let loaded = load(&written(scene));
    check_warnings(&loaded, &[]);
    loaded.scene
}

/// Two solved objects with one material each.
fn solved() -> Scene {
    let mut scene = load(SQUARE.as_bytes()).scene;
    scene.units = Units {
        metres_per_unit: Some(0.1),
        up: Up::Z,
        photometric: true,
    };
    let mut floor = mesh(&scene, 0).clone();
    floor.irradiance = [0.1f32, 2.5, 1e9, 0.0]
        .map(|e| Rgb::grey(e.into()))
        .to_vec();
    floor.irradiance_error = floor.irradiance.iter().map(|&e| 0.5 * e).collect();
    let mut wall = floor.clone();
    wall.positions
        .iter_mut()
        .for_each(|p| *p += DVec3::splat(0.1));
    wall.face_materials =
        vec![scene.add_material(Material::diffuse("#ff0000", Rgb::new(1.0, 0.0, 0.0)))];
    scene.materials[0] = Material::diffuse("#333333", Rgb::grey(0.2));
    scene.objects = vec![
        Object::new("house/floor", Shape::Mesh(floor)),
        Object::new("wall", Shape::Mesh(wall)),
    ];
    scene
}

#[test]
fn what_is_written_is_read() {
    let scene = solved();
    assert_eq!(read_back(&scene), scene);
    assert!(losses(&scene).is_empty());
}

#[test]
fn the_header_is_as_other_programs_want_it() {
    let bytes = written(&solved());
    let end = bytes
        .windows(11)
        .position(|w| w == b"end_header\n")
        .unwrap();
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    assert_eq!(
        header,
        "ply
format binary_little_endian 1.0
comment written by azulejo
comment azulejo up z
comment azulejo metres_per_unit 1e-1
comment azulejo photometric
comment azulejo colours_of_faces
comment azulejo object house/floor
comment azulejo object wall
element vertex 8
property double x
property double y
property double z
property uchar red
property uchar green
property uchar blue
property float irradiance_red
property float irradiance_green
property float irradiance_blue
property float irradiance_error_red
property float irradiance_error_green
property float irradiance_error_blue
property uint object
element face 2
property list uchar uint vertex_indices
"
    );
}

/// The properties of an element in the header of a written file.
fn properties(scene: &Scene, element: &str) -> Vec<String> {
    let bytes = written(scene);
    let text = String::from_utf8_lossy(&bytes);
    let (header, _) = text.split_once("end_header").unwrap();
    let lines = header
        .lines()
        .skip_while(|l| !l.starts_with(&format!("element {element} ")));
    let own = lines.skip(1).take_while(|l| l.starts_with("property"));
    own.map(|l| l["property ".len()..].to_owned()).collect()
}

/// Bytes, which every program reads, and exact numbers beside them.
#[test]
fn colours_are_bytes_for_other_programs() {
    let mut scene = load(SQUARE.as_bytes()).scene;
    let set = |scene: &mut Scene, colors: [Rgb; 4]| {
        let Shape::Mesh(square) = &mut scene.objects[0].shape else {
            unreachable!("a mesh")
        };
        square.colors = colors.to_vec();
    };
    scene.materials[0].diffuse = Rgb::WHITE;
    set(&mut scene, [Rgb::new(0.25, 0.5, 0.75); 4]);
    let colors = [
        "uchar red",
        "uchar green",
        "uchar blue",
        "float diffuse_red",
        "float diffuse_green",
        "float diffuse_blue",
    ];
    assert_eq!(properties(&scene, "vertex")[3..], colors);
    let bytes = written(&scene);
    let at = bytes
        .windows(11)
        .position(|w| w == b"end_header\n")
        .unwrap()
        + 11;
    assert_eq!(bytes[at + 12..at + 15], [64, 128, 191]);
    assert_eq!(mesh(&read_back(&scene), 0).colors, mesh(&scene, 0).colors);
    // Faces keep theirs beside them.
    scene.materials[0].diffuse = Rgb::new(0.8, 0.4, 0.0);
    set(&mut scene, [Rgb::WHITE; 4]);
    assert_eq!(properties(&scene, "vertex").len(), 6);
    let again = read_back(&scene);
    assert_eq!(mesh(&again, 0).colors, [Rgb::WHITE; 4]);
    assert_eq!(again.materials[0].diffuse, scene.materials[0].diffuse);
}

/// Vertices carry the colours of their faces where these agree, as some programs fail at colours of faces.
#[test]
fn vertices_carry_colours_of_faces() {
    let mut scene = load(SQUARE.as_bytes()).scene;
    scene.materials[0].diffuse = Rgb::new(0.3, 0.6, 0.9);
    assert_eq!(properties(&scene, "vertex").len(), 9);
    assert_eq!(
        properties(&scene, "face"),
        ["list uchar uint vertex_indices"]
    );
    let again = read_back(&scene);
    assert!(mesh(&again, 0).colors.is_empty());
    assert_eq!(again.materials[0].diffuse, scene.materials[0].diffuse);
    // A second colour at the same vertices: the faces have theirs, as bytes and as numbers.
    let green = scene.add_material(Material::diffuse("green", Rgb::new(0.0, 1.0, 0.0)));
    let Shape::Mesh(square) = &mut scene.objects[0].shape else {
        unreachable!("a mesh")
    };
    square.push_face(&[0, 1, 2], green);
    assert_eq!(properties(&scene, "vertex").len(), 3);
    assert_eq!(
        properties(&scene, "face")[1..],
        [
            "uchar red",
            "uchar green",
            "uchar blue",
            "double diffuse_red",
            "double diffuse_green",
            "double diffuse_blue",
        ]
    );
    let again = read_back(&scene);
    let colors = again.materials.iter().map(|m| m.diffuse);
    assert_eq!(
        colors.collect::<Vec<_>>(),
        [Rgb::new(0.3, 0.6, 0.9), Rgb::new(0.0, 1.0, 0.0)]
    );
}

/// Blender writes sRGB and says who it is; whoever says something else is believed.
#[test]
fn colours_by_blender_are_srgb() {
    let text = |comment: &str| {
        let text = SQUARE.replace("ascii 1.0", &format!("ascii 1.0\ncomment {comment}"));
        let text = text.replace(
            "property float z",
            "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue",
        );
        text.lines()
            .map(|line| match line.split(' ').count() {
                3 if line.starts_with(['0', '1']) => format!("{line} 188 0 255\n"),
                _ => format!("{line}\n"),
            })
            .collect::<String>()
    };
    let check = |comment: &str, colors: Option<VertexColors>, expected: f64, warned: usize| {
        let options = ReadOptions {
            vertex_colors: colors,
            ..ReadOptions::default()
        };
        let loaded = read(text(comment).as_bytes(), "a.ply", &Memory::new(), &options).unwrap();
        let color = mesh(&loaded.scene, 0).colors[0];
        assert!((color.r - expected).abs() < 1e-3, "{comment}: {color:?}");
        assert_eq!((color.g, color.b), (0.0, 1.0));
        assert_eq!(loaded.warnings.len(), warned, "{comment}");
    };
    let (linear, srgb) = (188.0 / 255.0, 0.5029);
    check("Created in Blender version 5.3.0", None, srgb, 1);
    check(
        "Created by Blender 2.93.0 - www.blender.org, source file: ''",
        None,
        srgb,
        1,
    );
    check(
        "Created in Blender version 5.3.0",
        Some(VertexColors::Linear),
        linear,
        0,
    );
    check("VCGLIB generated", None, linear, 0);
    check("VCGLIB generated", Some(VertexColors::Srgb), srgb, 0);
}

#[test]
fn objects_without_what_others_have() {
    let mut scene = solved();
    let Shape::Mesh(floor) = &mut scene.objects[0].shape else {
        unreachable!("a mesh")
    };
    floor.normals = Some(Attribute::per_vertex(vec![DVec3::Z; 4]));
    let again = read_back(&scene);
    assert_eq!(mesh(&again, 0).normals, mesh(&scene, 0).normals);
    assert!(mesh(&again, 1).normals.is_none());
}

#[test]
fn corners_divide_vertices() {
    let mut scene = load(SQUARE.as_bytes()).scene;
    let Shape::Mesh(square) = &mut scene.objects[0].shape else {
        unreachable!("a mesh")
    };
    square.push_face(&[0, 1, 2], 0);
    square.uvs = Some(Attribute {
        values: vec![DVec2::ZERO, DVec2::X, DVec2::splat(0.1)],
        corners: Some(vec![0, 1, 0, 1, 0, 2, 2]),
    });
    assert_eq!(
        losses(&scene),
        ["1 meshes whose vertices are split where normals or texture coordinates differ"]
    );
    let again = read_back(&scene);
    let (before, after) = (mesh(&scene, 0), mesh(&again, 0));
    assert_eq!(after.positions.len(), 6);
    let corners = |m: &Mesh| -> Vec<(DVec3, DVec2)> {
        let uvs = m.uvs.as_ref().unwrap();
        let corners = m.faces.corners.iter().enumerate();
        corners
            .map(|(c, &v)| (m.positions[v as usize], uvs.at(c, v)))
            .collect()
    };
    assert_eq!(corners(after), corners(before));
}

/// Lists by corner are empty without faces, as are those of another object that has none.
#[test]
fn vertices_without_faces_need_no_values() {
    let cloud = Mesh {
        positions: vec![DVec3::X, DVec3::Y],
        normals: Some(Attribute {
            values: Vec::new(),
            corners: Some(Vec::new()),
        }),
        uvs: Some(Attribute {
            values: Vec::new(),
            corners: Some(Vec::new()),
        }),
        ..Mesh::default()
    };
    let mut scene = solved();
    scene
        .objects
        .insert(0, Object::new("cloud", Shape::Mesh(cloud)));
    scene.validate().unwrap();
    // An object without faces is not read again, and the other one is not affected.
    let (back, given) = (read_back(&scene), solved());
    assert_eq!(back.objects.len(), given.objects.len());
    assert_eq!(mesh(&back, 0).positions, mesh(&given, 0).positions);
    scene.objects.truncate(1);
    written(&scene);
}

#[test]
fn pictures_are_named() {
    let mut scene = load(SQUARE.as_bytes()).scene;
    scene.textures = vec![
        Texture {
            path: "a b.png".into(),
            image: None,
            ..Texture::default()
        },
        Texture {
            path: "c.png".into(),
            image: None,
            ..Texture::default()
        },
    ];
    scene.materials[0].textures = vec![1];
    let Shape::Mesh(square) = &mut scene.objects[0].shape else {
        unreachable!("a mesh")
    };
    square.uvs = Some(Attribute::per_vertex(vec![DVec2::splat(0.5); 4]));
    let again = load(&written(&scene)).scene;
    assert_eq!(again.textures, scene.textures);
    assert_eq!(again.materials[0].textures, [1]);
}

#[test]
fn exact_primitives_bring_their_light() {
    let mut scene = Scene::default();
    let white = scene.add_material(Material::diffuse("white", Rgb::WHITE));
    let mut square = Primitive::parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y, white);
    square.light = Some(Box::new(SurfaceLight {
        grids: vec![SurfaceGrid { nu: 1, nv: 1 }],
        irradiance: vec![Rgb::grey(0.5); 4],
        error: Vec::new(),
    }));
    scene
        .objects
        .push(Object::new("", Shape::Primitive(square)));
    scene.lights.push(Light {
        name: String::new(),
        kind: LightKind::Ambient {
            radiance: Rgb::WHITE,
        },
    });
    let again = read_back(&scene);
    assert_eq!(mesh(&again, 0).irradiance, [Rgb::grey(0.5); 4]);
    assert_eq!(
        losses(&scene),
        [
            "1 lights without area",
            "1 exact primitives that become polygons"
        ]
    );
}

/// Numbers that are exact in single precision, and others.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![-1e3..1e3, (-100i16..100).prop_map(f64::from), Just(-0.0)]
}

fn share() -> impl Strategy<Value = f64> {
    prop_oneof![0.0..=1.0, any::<u8>().prop_map(|b| f64::from(b) / 255.0)]
}

fn color() -> impl Strategy<Value = Rgb> {
    [share(), share(), share()].prop_map(Rgb::from)
}

fn light() -> impl Strategy<Value = Rgb> {
    [0.0f32..1e6, 0.0f32..1.0, 0.0f32..1.0].prop_map(|e| Rgb::from(e.map(f64::from)))
}

/// A mesh with per-vertex attributes only.
fn any_mesh() -> impl Strategy<Value = Mesh> {
    (3usize..9, any::<[bool; 4]>()).prop_flat_map(|(n, [colors, uvs, lit, errors])| {
        let count = move |is_given: bool| if is_given { n } else { 0 };
        let list = prop::collection::vec([coordinate(), coordinate(), coordinate()], n);
        let faces = prop::collection::vec(prop::collection::vec(0..n as u32, 3..300), 1..4);
        (
            list,
            faces,
            prop::collection::vec(color(), count(colors)),
            prop::collection::vec([coordinate(), coordinate()], count(uvs)),
            prop::collection::vec(light(), count(lit)),
            prop::collection::vec(light(), count(lit && errors)),
        )
            .prop_map(
                |(positions, faces, colors, uvs, irradiance, irradiance_error)| {
                    let uvs: Vec<DVec2> = uvs.into_iter().map(DVec2::from).collect();
                    let mut mesh = Mesh {
                        positions: positions.into_iter().map(DVec3::from).collect(),
                        colors,
                        uvs: (!uvs.is_empty()).then(|| Attribute::per_vertex(uvs)),
                        irradiance,
                        irradiance_error,
                        ..Mesh::default()
                    };
                    faces.iter().for_each(|face| mesh.push_face(face, 0));
                    mesh
                },
            )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn every_mesh_comes_back(mesh in any_mesh(), diffuse in color()) {
        let mut scene = Scene::default();
        scene.add_material(Material::diffuse("", diffuse));
        scene.objects.push(Object::new("a name", Shape::Mesh(mesh)));
        let again = read_back(&scene);
        prop_assert_eq!(&again.objects, &scene.objects);
        prop_assert_eq!(again.materials[0].diffuse, diffuse);
    }
}
