//! One small file per rule of the grammar.

use super::*;
use azulejo_scene::{LightKind, PrimitiveKind, Rgb};
use glam::{DVec2, DVec3};

fn first_diffuse(text: &str) -> Rgb {
    let scene = scene(text);
    let material = mesh(&scene, 0).face_materials[0];
    scene.materials[material as usize].diffuse
}

fn check_point(transform: &str, expected: DVec3) {
    let text = format!(
        "{transform} {} {}",
        triangle("").replace("(0,0,0)", "(1,2,3)"),
        "end ".repeat(transform.matches("begin").count()),
    );
    let point = mesh(&scene(&text), 0).positions[0];
    assert!(
        (point - expected).length() < 1e-12,
        "{transform}: {point} instead of {expected}"
    );
}

#[test]
fn the_cube() {
    let loaded = loaded(CUBE);
    assert_eq!(loaded.warnings, []);
    let mesh = mesh(&loaded.scene, 0);
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (8, 6));
    assert_eq!(mesh.area(), 24.0);
    assert_eq!(mesh.irradiance[4], Rgb::new(1.0, 0.75, 0.5));
    assert_eq!(mesh.face_materials, [0, 0, 1, 1, 1, 1]);
    assert_eq!(loaded.scene.materials[1].diffuse, Rgb::new(0.0, 0.0, 1.0));
    // Every face points outwards.
    for face in 0..6 {
        let middle: DVec3 = mesh.face_positions(face).into_iter().sum();
        assert!(mesh.face_area_vector(face).dot(middle) > 0.0);
    }
    assert_eq!(document(CUBE).comments.len(), 6);
    assert_eq!(document(CUBE).comments[3], " Cube, size 2.0");
}

#[test]
fn everything_at_once() {
    let loaded = loaded(EVERYTHING);
    let scene = &loaded.scene;
    assert_eq!(scene.objects.len(), 4);
    assert_eq!(scene.objects[0].name, "panel");
    assert_eq!(scene.units.metres_per_unit, Some(0.01));
    assert!(scene.units.photometric);
    assert_eq!(scene.cameras[0].size, Some((640, 480)));
    assert_eq!(scene.cameras[0].vertical_fov, 45f64.to_radians());
    let panel = mesh(scene, 0);
    assert_eq!(panel.uvs.as_ref().unwrap().values[2], DVec2::ONE);
    assert_eq!(panel.colors[1], Rgb::new(1.0, 0.0, 0.0));
    assert_eq!(panel.irradiance_error[1], Rgb::new(0.5, 0.0, 0.0));
    assert_eq!(panel.smoothing, [1, 2]);
    assert_eq!(panel.faces.get(1), [2, 1, 0]);
    let cone = match &scene.objects[3].shape {
        Shape::Primitive(p) => p,
        _ => panic!("the cone is not a primitive"),
    };
    assert_eq!(cone.kind, PrimitiveKind::Cone { top: 0.5 });
    assert_eq!(scene.materials[cone.material as usize].name, "matt paint");
    assert!(matches!(scene.lights[0].kind, LightKind::Point { .. }));
}

#[test]
fn transforms_act_in_the_order_written() {
    check_point(
        "transform translation (1,0,0) begin",
        DVec3::new(2.0, 2.0, 3.0),
    );
    check_point("transform scale (2,3,4) begin", DVec3::new(2.0, 6.0, 12.0));
    check_point(
        "transform rotation (0,0,90) begin",
        DVec3::new(-2.0, 1.0, 3.0),
    );
    // About x first: y to z, then about y: z to x.
    check_point(
        "transform rotation (90,90,0) begin",
        DVec3::new(2.0, -3.0, -1.0),
    );
    check_point(
        "transform scale (2,2,2) translation (1,0,0) begin",
        DVec3::new(3.0, 4.0, 6.0),
    );
    check_point(
        "transform translation (1,0,0) scale (2,2,2) begin",
        DVec3::new(4.0, 4.0, 6.0),
    );
    check_point(
        "transform translation (1,0,0) begin transform scale (2,2,2) begin",
        DVec3::new(3.0, 4.0, 6.0),
    );
}

#[test]
fn normals_follow_the_inverse_transpose_and_irradiance_stays() {
    let text = "transform scale (2,1,1) begin begin mesh begin vertices \
        normal (0.6, 0.8, 0) irad (1, 2, 3) (0,0,0) normal (0, 0, 2) irad (1, 2, 3) (1,0,0) \
        normal (0, 0, 1) irad (1, 2, 3) (0,1,0) end begin faces (0,1,2) end end mesh end";
    let scene = scene(text);
    let mesh = mesh(&scene, 0);
    let normals = &mesh.normals.as_ref().unwrap().values;
    let expected = DVec3::new(0.3, 0.8, 0.0).normalize();
    assert!((normals[0] - expected).length() < 1e-12);
    assert_eq!(normals[1], DVec3::Z);
    assert_eq!(mesh.irradiance[0], Rgb::new(1.0, 2.0, 3.0));
}

#[test]
fn a_mirroring_transform_keeps_fronts_outside() {
    let scene = scene(&format!("transform scale (1,1,-1) begin {CUBE} end"));
    let mesh = mesh(&scene, 0);
    for face in 0..6 {
        let middle: DVec3 = mesh.face_positions(face).into_iter().sum();
        assert!(mesh.face_area_vector(face).dot(middle) > 0.0);
    }
    let lamp = "light begin (0,0,0) (2,0,0) (0,1,0) end";
    let point = |text: &str| match &super::scene(text).objects[0].shape {
        Shape::Primitive(p) => p.point(0, 0.5, 0.5),
        _ => panic!("a light is a primitive"),
    };
    assert_eq!(point(lamp).normal, DVec3::Z);
    let mirrored = format!("transform scale (1,1,-1) begin {lamp} end");
    assert_eq!(point(&mirrored).normal, -DVec3::Z);
}

#[test]
fn definitions_hold_inside_and_inner_ones_hide_outer_ones() {
    let face = triangle("use color c");
    let nested =
        format!("def c = rgb (1,0,0) begin def c = rgb (0,1,0) begin {face} end {face} end def");
    let scene = scene(&nested);
    let colors: Vec<Rgb> = (0..2)
        .map(|o| scene.materials[mesh(&scene, o).face_materials[0] as usize].diffuse)
        .collect();
    assert_eq!(colors, [Rgb::new(0.0, 1.0, 0.0), Rgb::new(1.0, 0.0, 0.0)]);
    assert_eq!(scene.materials[1].name, "c");
}

#[test]
fn a_use_may_stand_before_its_definition() {
    let text = format!("begin {} def c = rgb (0,1,0) end", triangle("use color c"));
    assert_eq!(first_diffuse(&text), Rgb::new(0.0, 1.0, 0.0));
    // A definition without blocks of its own, followed by a mesh.
    let text = format!("def c = rgb (0,0,1) {}", triangle("use color c"));
    assert_eq!(first_diffuse(&text), Rgb::new(0.0, 0.0, 1.0));
}

#[test]
fn several_definitions_under_one_def() {
    let text = format!(
        "def a = brdf lewis n = 3 ks = 0.25 kd = 0.25 b = rgb (0.5,0.5,0.5) begin {} end",
        triangle("use brdf a use color b")
    );
    assert_eq!(first_diffuse(&text), Rgb::grey(0.125));
}

#[test]
fn face_attributes_last_until_the_next_of_their_kind() {
    let text = "begin mesh begin vertices (0,0,0) (1,0,0) (0,1,0) end vertices begin faces \
        (0,1,2) rgb (1,0,0) (0,1,2) texture \"a\" (0,1,2) (0,1,2) rgb (0,1,0) (0,1,2) \
        texture \"b\" texture \"c\" (0,1,2) end faces end mesh";
    let scene = scene(text);
    let looks: Vec<(Rgb, Vec<u32>)> = mesh(&scene, 0)
        .face_materials
        .iter()
        .map(|&m| &scene.materials[m as usize])
        .map(|m| (m.diffuse, m.textures.clone()))
        .collect();
    let (red, green) = (Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 1.0, 0.0));
    assert_eq!(
        looks,
        [
            (Rgb::grey(0.5), vec![]),
            (red, vec![]),
            (red, vec![0]),
            (red, vec![0]),
            (green, vec![0]),
            (green, vec![1, 2]),
        ]
    );
    assert_eq!(scene.textures[2].path, "c");
}

#[test]
fn a_use_at_the_head_holds_for_the_whole_mesh() {
    let text = "def g = brdf diffuse kd = (0.1,0.2,0.3) begin begin mesh use brdf g \
        begin vertices (0,0,0) (1,0,0) (0,1,0) end vertices begin faces (0,1,2) end end mesh end";
    assert_eq!(first_diffuse(text), Rgb::new(0.1, 0.2, 0.3));
    assert_eq!(scene(text).materials.len(), 1);
}

#[test]
fn brdf_models() {
    let material = |brdf: &str| scene(&triangle(brdf)).materials[0].clone();
    let made = material("brdf diffuse kd = .25");
    assert_eq!((made.diffuse, made.brdf), (Rgb::grey(0.25), None));
    let made = material("brdf specular ks = (0.9, 0.8, 0.7)");
    assert_eq!(made.mirror, Rgb::new(0.9, 0.8, 0.7));
    assert_eq!(made.diffuse, Rgb::BLACK);
    let made =
        material("brdf combination weight = 0.5 diffuse kd = 0.8 weight = 0.25 specular ks = 1");
    assert_eq!(
        (made.diffuse, made.mirror),
        (Rgb::grey(0.4), Rgb::grey(0.25))
    );
    let made = material("brdf Lewis n = 10 ks=0.2 kd=(0.1,0.2,0.3)");
    assert_eq!(made.diffuse, Rgb::new(0.1, 0.2, 0.3));
    assert_eq!(made.mirror, Rgb::BLACK);
    let model = made.brdf.map(|b| b.description().to_string());
    assert_eq!(
        model.as_deref(),
        Some("Lewis n = 10 ks = 0.2 kd = (0.1, 0.2, 0.3)")
    );
    let made = material("rgb (0.1, 0.1, 0.1) brdf \"gold.binary\"");
    let model = made.brdf.map(|b| b.description().to_string());
    assert_eq!(model.as_deref(), Some("\"gold.binary\""));
    assert_eq!(made.diffuse, Rgb::grey(0.1));
}

/// The writer represents a diffuse mirror as a sum of two models with weights of 1.
#[test]
fn a_matt_mirror_is_plain() {
    let text = "brdf combination weight = 1 diffuse kd = 0.75 weight = 1 specular ks = 0.25";
    let made = scene(&triangle(text)).materials[0].clone();
    assert_eq!(
        (made.diffuse, made.mirror),
        (Rgb::grey(0.75), Rgb::grey(0.25))
    );
    assert_eq!(made.brdf, None);
}

#[test]
fn emitters() {
    let body = "begin vertices (0,0,0) (1,0,0) (0,1,0) end vertices begin faces (0,1,2) end faces";
    for end in ["end", "end mesh", "end light"] {
        let scene = scene(&format!("mesh light begin {body} rgb (3,2,1) {end}"));
        assert_eq!(
            scene.materials[0].emission,
            Rgb::new(3.0, 2.0, 1.0),
            "{end}"
        );
        assert_eq!(scene.materials[0].diffuse, Rgb::BLACK);
    }
    let silent = scene(&format!("mesh light begin {body} end"));
    assert_eq!(silent.materials[0].emission, Rgb::WHITE);
}

#[test]
fn area_lights() {
    for region in [
        "rgb (1,2,3) (0,0,1) (2,0,0) (0,3,0)",
        "(0,0,1) (2,0,0) (0,3,0) rgb (1,2,3)",
        "rgb (1,2,3) ( (0,0,1) (2,0,0) (0,3,0) )",
    ] {
        let scene = scene(&format!("light begin {region} end light"));
        let Shape::Primitive(lamp) = &scene.objects[0].shape else {
            panic!("a light is a primitive");
        };
        assert_eq!(lamp.kind, PrimitiveKind::Square);
        let middle = lamp.point(0, 0.5, 0.5);
        assert_eq!(middle.position, DVec3::new(1.0, 1.5, 1.0));
        assert_eq!(middle.normal, DVec3::Z);
        assert_eq!(middle.area_density, 6.0);
        let material = &scene.materials[lamp.material as usize];
        assert_eq!(material.emission, Rgb::new(1.0, 2.0, 3.0));
    }
}

#[test]
fn an_end_word_is_not_taken_for_a_block_nor_a_block_for_it() {
    let mesh_light = "mesh light begin begin vertices (0,0,0) (1,0,0) (0,1,0) end \
        begin faces (0,1,2) end end";
    let light = "light begin (0,0,0) (1,0,0) (0,1,0) end";
    let plain = triangle("").replace("end mesh", "end");
    for (text, objects) in [
        (format!("{mesh_light} {mesh_light}"), 2),
        (format!("{mesh_light} mesh {mesh_light}"), 2),
        (format!("{light} {light} light {light}"), 3),
        (format!("{mesh_light} {light} {plain}"), 3),
        (format!("{mesh_light} light {plain}"), 2),
        (format!("{plain} mesh {light}"), 2),
        (format!("{plain} {mesh_light}"), 2),
        (format!("{plain} {light}"), 2),
        (
            format!(
                "def a = rgb (1,1,1) begin {plain} end def b = rgb (1,1,1) begin {plain} end def"
            ),
            2,
        ),
        (
            format!("begin {plain} end transform scale (1,1,1) begin {plain} end transform"),
            2,
        ),
    ] {
        assert_eq!(scene(&text).objects.len(), objects, "{text}");
    }
}

#[test]
fn includes_stand_where_their_text_would() {
    let files = Memory::new()
        .with("lib/colors.grf", "def c = rgb (0,1,0)")
        .with(
            "lib/all.grf",
            "include \"colors.grf\" include '../t.grf'".replace('\'', "\""),
        )
        .with("t.grf", triangle("use color c"));
    let text = "transform translation (0,0,5) begin include lib/all.grf end";
    let loaded = read(text.as_bytes(), "/home/me/test.grf", &files).unwrap();
    let mesh = mesh(&loaded.scene, 0);
    assert_eq!(mesh.positions[0], DVec3::new(0.0, 0.0, 5.0));
    assert_eq!(loaded.scene.materials[0].diffuse, Rgb::new(0.0, 1.0, 0.0));
}

#[test]
fn small_liberties_are_warned_of_once() {
    let text = triangle("")
        .replace("(0,0,0)", "(0 0 0)")
        .replace("(0, 1, 2)", "(0 1 2)")
        + " .";
    assert_eq!(
        warnings(&text),
        [
            "test.grf:1:30: missing comma between two numbers (4 times)",
            "test.grf:1:104: single `.`: skipped",
        ]
    );
    let text = triangle("").replace("(0,0,0)", "irad (1,-1,1) (0,0,0)");
    let messages = warnings(&text);
    assert!(messages[0].contains("negative"), "{messages:?}");
    assert!(
        messages[1].contains("without `irad`") && messages[1].contains("(2 times)"),
        "{messages:?}"
    );
    let flat = triangle("(0, 0, 1) (1, 2, 1)");
    assert_eq!(
        warnings(&flat),
        ["test.grf:1:1: face without area: kept (2 times)"]
    );
    assert_eq!(mesh(&scene(&flat), 0).faces.len(), 3);
}

#[test]
fn missing_normals_come_from_the_faces() {
    let text = triangle("").replace("(0,0,0)", "normal (1,0,0) (0,0,0)");
    let scene = scene(&text);
    let normals = &mesh(&scene, 0).normals.as_ref().unwrap().values;
    assert_eq!(normals[..], [DVec3::X, DVec3::Z, DVec3::Z]);
}

#[test]
fn every_line_end_and_encoding() {
    let expected = scene(CUBE);
    for text in [
        CUBE.replace('\n', "\r\n"),
        CUBE.replace('\n', "\r"),
        format!("\u{feff}{CUBE}"),
        CUBE.replace("begin", "BEGIN").replace("mesh", "Mesh"),
    ] {
        assert_eq!(scene(&text), expected);
    }
    let latin = b"// \xf1\ndef a\xf1o = texture \"ba\xf1o.png\"";
    let loaded = read(latin, "test.grf", &Memory::new()).unwrap();
    assert_eq!(loaded.scene.textures[0].path, "baño.png");
}

#[test]
fn textures_are_loaded_or_warned_of() {
    let mut png = Vec::new();
    crate::picture::png::write(2, 1, &[0, 0, 0, 255, 255, 255], &mut png).unwrap();
    let files = Memory::new()
        .with("a.png", png)
        .with("b.png", *b"no picture");
    let text = triangle("texture \"a.png\" texture \"b.png\"");
    let loaded = read(text.as_bytes(), "test.grf", &files).unwrap();
    assert_eq!(loaded.scene.textures[0].image.as_ref().unwrap().width, 2);
    assert_eq!(loaded.scene.textures[1].image, None);
    assert!(loaded.warnings[0].message.contains("\"b.png\" skipped"));
}

/// A file with nothing in it is a list of no blocks.
#[test]
fn an_empty_scene_is_written_as_something() {
    let text = written(&Scene::default());
    assert_eq!(text, ";\n");
    for text in [&*text, "// nothing\n", "\n", "def a = rgb (1,1,1)\n"] {
        assert_eq!(scene(text), Scene::default(), "{text}");
    }
}
