//! Typical files, valid and invalid.

use super::*;
use crate::{Format, Memory, detect};
use azulejo_scene::synthetic::{CornellVariant, cornell_box, room_with_table};
use azulejo_scene::{Mesh, Scene, Shape};

/// A 1 × 1 floor and a ceiling one unit above it that faces down, in two combined halves.
const SQUARES: &str = "T two squares\nC eps=1e-5, out=1\nF 3\n\
    V 1 0 0 0\nV 2 1 0 0\nV 3 1 1 0\nV 4 0 1 0\n\
    V 5 0 0 1\nV 6 1 0 1\nV 7 1 1 1\nV 8 0 1 1\nV 9 .5 0 1\nV 10 .5 1 1\n\
    S 1 1 2 3 4  0 0 0.5 low\n\
    S 2 5 8 10 9 0 0 0.8 upA\n\
    S 3 9 10 7 6 0 2 0.8 upB\nEnd of data\n";

/// The same floor with a window, mask or hole in its middle, `1 2 3 4` or reversed.
fn floor_with(kind: &str, corners: &str, more: &str) -> String {
    format!(
        "F 3\nV 1 0 0 0\nV 2 1 0 0\nV 3 1 1 0\nV 4 0 1 0\n\
         V 5 .25 .25 0\nV 6 .75 .25 0\nV 7 .75 .75 0\nV 8 .25 .75 0\n\
         S 1 1 2 3 4 0 0 .5 floor\n{kind} 2 {corners} 1 0 .9 part\n{more}"
    )
}

const WINDOW: &str = "5 6 7 8";
const TURNED: &str = "8 7 6 5";

fn mirrored(text: &str) -> Result<(View3dDocument, Vec<Warning>), ReadError> {
    View3dDocument::read(text.as_bytes(), "a.vs3", &ReadOptions::default())
}

fn model_of(document: &View3dDocument) -> View3dModel {
    View3dModel::new(document, "a.vs3").unwrap()
}

fn document(text: &str) -> View3dDocument {
    mirrored(text).unwrap().0
}

fn messages(text: &str) -> Vec<String> {
    let (_, warnings) = mirrored(text).unwrap();
    warnings.iter().map(|w| w.to_string()).collect()
}

fn check_error(text: &str, expected: &str) {
    let error = mirrored(text).unwrap_err().to_string();
    assert!(error.starts_with(expected), "{error}\nfor\n{text}");
}

fn mesh(scene: &Scene, object: usize) -> &Mesh {
    match &scene.objects[object].shape {
        Shape::Mesh(mesh) => mesh,
        _ => panic!("not a mesh"),
    }
}

#[test]
fn a_file_is_mirrored() {
    let d = document(SQUARES);
    assert_eq!(d.title, "two squares");
    assert_eq!(
        (d.controls.eps, d.controls.out),
        (1e-5, MatrixLayout::Binary)
    );
    assert_eq!((d.vertices.len(), d.surfaces.len()), (10, 3));
    let s = &d.surfaces[2];
    assert_eq!((s.base, s.combined, s.emissivity), (0, 2, 0.8));
    assert_eq!((s.name.as_str(), s.line), ("upB", 16));
    assert_eq!(s.outline, SurfaceOutline::Vertices(vec![9, 10, 7, 6]));
    assert_eq!(messages(SQUARES), [""; 0]);
}

#[test]
fn it_is_recognized_by_its_words() {
    let check = |text: &str, expected| assert_eq!(detect(text.as_bytes()).ok(), expected, "{text}");
    check(SQUARES, Some(Format::View3d));
    check(
        "! remark\nc encl=1\nf 3a\ns 1 R 0 0 .9 a\n",
        Some(Format::View3d),
    );
    check("C eps=1.e-4\nV 1 0 0 0\n", Some(Format::View3d));
    check("v 0 0 0\nf 1 2 3\n", Some(Format::Obj));
    check("f 3 4 5\nv 1 0 0\n", Some(Format::Obj));
    check("c red =\nv a =\n", Some(Format::Mgf));
    // Without F and C, only the file name identifies the format.
    let bare = "V 1 0 0 0\nV 2 1 0 0\nV 3 0 1 0\nS 1 1 2 3 0 0 0 .9 a\n";
    check(bare, Some(Format::Obj));
    let loaded = crate::read(bare.as_bytes(), "a.vs3", &Memory::new()).unwrap();
    assert_eq!(loaded.scene.objects[0].name, "a");
}

#[test]
fn letters_numbers_and_ends_are_lenient_where_view3d_is() {
    let d = document(
        "title is here ! and goes on\r\nf,3\r\n/ a remark\r\nV 0x1 0,0,0\r\nv\t2 1 0 1e-15\n\
         V 3 1 1 0\n\nS 01 1 2\n! between\n 3 0 0 0\n 2 wall ! remark\nX 1 2 3\nE\nS 9\n",
    );
    assert_eq!(d.title, "is here ! and goes on");
    assert_eq!(d.vertices[1].to_array(), [1.0, 0.0, 0.0]);
    assert_eq!(d.surfaces[0].name, "wall");
    assert_eq!(d.surfaces[0].emissivity, 0.999);
    assert_eq!(document("F 3\n* end\nV 7\n").vertices.len(), 0);
}

#[test]
fn placed_shapes_stand_where_their_angles_say() {
    // Walls of a unit cube seen from inside: the southern one faces north, and so on.
    let d = document(
        "T cube\nF 3a\nS 1 R 0 0 .9 south width follows\n 1 0 0 0 90 1 1\n\
         S 2 R 0 0 .9 floor\n 0 0 0 180 0 1 1\n\
         S 3 T 0 0 .9 ceiling\n 1 0 1 0 180 0 0 1 0 1 1\nO 4 q\n 0 .5 .5 90 90\n0 0 .1 0\n.1 .1 0 .1\n",
    );
    let corners = |k: usize| -> Vec<[f64; 3]> {
        d.corners(&d.surfaces[k])
            .iter()
            .map(|p| (*p + glam::DVec3::ZERO).to_array())
            .collect()
    };
    assert_eq!(
        corners(0),
        [[1., 0., 0.], [0., 0., 0.], [0., 0., 1.], [1., 0., 1.]]
    );
    assert_eq!(
        corners(1),
        [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]
    );
    assert_eq!(corners(2), [[1., 0., 1.], [0., 0., 1.], [0., 1., 1.]]);
    assert_eq!(corners(3)[1], [0.0, 0.6, 0.5]);
    assert_eq!(d.surfaces[3].kind, SurfaceKind::Obstruction);
}

#[test]
fn odd_things_are_said() {
    let check = |text: &str, expected: &str| {
        let actual = messages(text);
        assert!(
            actual.iter().any(|m| m.contains(expected)),
            "{actual:?} for\n{text}"
        );
    };
    check("C eps=1e-9\n", "a.vs3:1:3: eps is outside");
    check(
        "C eps = 1e-4 ! more\n",
        "that are not name=value: skipped (5 times)",
    );
    check("C speed=3\n", "unknown control parameter \"speed\"");
    check("C out=2\n", "taken as 0");
    check("Q 1 2\n", "\"Q\" is not a record type");
    check("X a\nX b\n", "X is reserved: line skipped (2 times)");
    check(&SQUARES.replace("0.5 low", "1.5 low"), "clamped");
    check(
        &SQUARES.replace("0.5 low", "0.5"),
        "a.vs3:14:18: surfaces without a name",
    );
    check(
        &SQUARES.replace("V 7 1 1 1\n", "V 7 1 1 1.00001\n"),
        "not quite flat",
    );
    check(
        &format!("T {}\n", "x".repeat(300)),
        "more than 255 characters",
    );
    let twice = floor_with("S", WINDOW, "S 3 5 6 7 8 1 0 .9 again\n");
    let loaded = read(
        twice.as_bytes(),
        "a.vs3",
        &Memory::new(),
        &ReadOptions::default(),
    )
    .unwrap();
    let message = loaded.warnings[0].to_string();
    assert!(
        message.starts_with("a.vs3:10:1: surfaces in one base overlap"),
        "{message}"
    );
}

#[test]
fn a_surface_without_a_name_does_not_swallow_the_next() {
    let d = document(&SQUARES.replace(" low", "").replace(" upB", ""));
    let names: Vec<&str> = d.surfaces.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["", "upA", ""]);
    let d = document(&SQUARES.replace(" low", "\n  low"));
    assert_eq!(d.surfaces[0].name, "low");
}

#[test]
fn what_view3d_refuses_is_refused_with_its_line() {
    let squares = |from: &str, to: &str| SQUARES.replace(from, to);
    check_error("F 2\n", "a.vs3:1:3: found geometry \"2\", expected 3");
    check_error(
        "C out=x\n",
        "a.vs3:1:3: found \"out=x\", expected an integer from 0 to 2",
    );
    check_error("C maxU=40000\n", "a.vs3:1:3: found \"maxU=40000\"");
    check_error("C eps=-1\n", "a.vs3:1:3: found \"eps=-1\"");
    check_error("F 3a\nV 1 0 0 0\n", "a.vs3:2:1: found a vertex");
    check_error("V 1 0 0 0\nF 3a\n", "a.vs3:2:1: found F after them");
    check_error(
        "V 2 0 0 0\n",
        "a.vs3:1:3: found vertex 2, expected vertex 1",
    );
    check_error(
        "V 1 0 x 0\n",
        "a.vs3:1:7: found \"x\", expected a coordinate",
    );
    check_error("V 1 0 0", "a.vs3:1:8: found the end of the file");
    check_error("V 1 0 inf 0\n", "a.vs3:1:7: found \"inf\"");
    check_error(
        "S 1 1 2 3 4 0 0 1 a\n",
        "a.vs3:1:5: found \"1\", expected vertices (V) before",
    );
    check_error(
        &squares("S 2 5 8 10", "S 2 5 8 11"),
        "a.vs3:15:9: found \"11\", expected one of the 10",
    );
    check_error(
        &squares("S 3", "S 4"),
        "a.vs3:16:3: found surface 4, expected surface 3",
    );
    check_error(
        &squares("End", "O 4 1 2 3 4\nS 5"),
        "a.vs3:18:1: found a surface after an obstruction",
    );
    check_error(
        &squares("V 3 1 1 0", "V 3 .2 .2 0"),
        "a.vs3:14:1: found surface 1, which is not convex",
    );
    check_error(
        &squares("S 1 1 2 3 4", "S 1 1 1 1 1"),
        "a.vs3:14:1: found surface 1, which has no area",
    );
    check_error(
        &squares("S 1 1 2 3 4", "S 1 1 2 3 8"),
        "a.vs3:14:1: found surface 1, which is not flat",
    );
    check_error(
        &squares("0 2 0.8 upB", "0 3 0.8 upB"),
        "a.vs3:16:16: found surface 3, expected an earlier",
    );
    check_error(
        &squares("End", "S 4 1 2 3 4 0 3 .8 c\nEnd"),
        "a.vs3:17:15: found surface 3, which itself is part of 2",
    );
}

#[test]
fn bases_hold_what_lies_in_them() {
    let parts = |kind, corners| floor_with(kind, corners, "");
    document(&parts("S", WINDOW));
    document(&parts("M", TURNED));
    document(&parts("N", TURNED));
    check_error(
        &parts("S", TURNED),
        "a.vs3:11:13: found a surface that does not face like",
    );
    check_error(
        &parts("M", WINDOW),
        "a.vs3:11:13: found a surface that does not face like",
    );
    let wide = parts("S", WINDOW)
        .replace("V 6 .75", "V 6 1.75")
        .replace("V 7 .75", "V 7 1.75");
    check_error(
        &wide,
        "a.vs3:11:13: found a surface that extends beyond base 1",
    );
    let high = parts("S", WINDOW)
        .replace(".25 0\n", ".25 .1\n")
        .replace(".75 0\n", ".75 .1\n");
    check_error(
        &high,
        "a.vs3:11:13: found a surface outside the plane of base 1",
    );
    let later = parts("S", WINDOW).replace("S 1 1 2 3 4 0", "S 1 1 2 3 4 2");
    check_error(&later, "a.vs3:10:13: found base 2 of surface 1");
    check_error(
        &parts("M", TURNED).replace("5 1 0", "5 0 0"),
        "a.vs3:11:13: found no base",
    );
    check_error(
        &parts("M", TURNED).replace("5 1 0", "5 7 0"),
        "a.vs3:11:13: found base 7",
    );
    let mask = floor_with("M", TURNED, "S 3 5 6 7 8 2 0 .5 a\n");
    check_error(&mask, "a.vs3:12:13: found a mask for a base");
    let combined = parts("M", TURNED).replace("5 1 0", "5 1 1");
    check_error(&combined, "a.vs3:11:15: found a mask that is combined");
    // An obstruction may be the base of an earlier surface.
    let pane = floor_with("S", WINDOW, "O 3 1 2 3 4\n").replace("8 1 0", "8 3 0");
    let model = model_of(&document(&pane));
    assert_eq!(model.rows, [vec![Some(0)], vec![Some(1)], vec![None; 4]]);
}

#[test]
fn subsurfaces_are_cut_out() {
    let model = model_of(&document(&floor_with("S", WINDOW, "")));
    model.scene.validate().unwrap();
    assert_eq!(model.names, ["floor", "part"]);
    assert_eq!(model.emissivities, [0.5, 0.9]);
    assert_eq!(model.rows, [vec![Some(0); 4], vec![Some(1)]]);
    assert_eq!(mesh(&model.scene, 0).area(), 0.75);
    assert_eq!(mesh(&model.scene, 1).area(), 0.25);
    let reflectance = |k: usize| model.scene.materials[k].diffuse[0];
    assert!((reflectance(0) - 0.5).abs() + (reflectance(1) - 0.1).abs() < 1e-12);
}

#[test]
fn too_many_in_one_base_are_refused() {
    let more: String = (3..4_100)
        .map(|k| format!("S {k} 5 6 7 8 1 0 .9 a\n"))
        .collect();
    let text = floor_with("S", WINDOW, &more);
    let error = View3dModel::new(&document(&text), "a.vs3")
        .unwrap_err()
        .to_string();
    assert!(
        error.starts_with("a.vs3:10:1: found 4098 surfaces with this one"),
        "{error}"
    );
}

#[test]
fn masks_and_holes_leave_a_place_that_blocks() {
    let model = model_of(&document(&floor_with("M", TURNED, "")));
    assert_eq!(model.rows, [vec![Some(0); 4], vec![None]]);
    assert_eq!(model.scene.objects[1].name, "obstructions");
    let mask = CoveringMask {
        row: 1,
        covers: 0,
        area: 0.25,
    };
    assert_eq!((model.names.len(), &model.masks[..]), (2, &[mask][..]));
    // A hole does not shift the numbers of later surfaces, as it does in View3D.
    let hole = floor_with(
        "N",
        TURNED,
        "S 3 1 2 3 4 0 0 .7 next\nS 4 1 2 3 4 0 3 .7 more\n",
    );
    let model = model_of(&document(&hole));
    assert_eq!(model.names, ["floor", "next"]);
    assert_eq!(model.rows[1], [Some(1)]);
    assert_eq!(model.rows[2], [Some(1)]);
    assert_eq!(model.emissivities, [0.5, 0.7]);
}

#[test]
fn a_window_may_hold_a_window() {
    let inner =
        "V 9 .4 .4 0\nV 10 .6 .4 0\nV 11 .6 .6 0\nV 12 .4 .6 0\nS 3 9 10 11 12 2 0 .5 pane\n";
    let text = floor_with("S", WINDOW, "");
    let model = model_of(&document(&format!("{text}{inner}")));
    let areas: Vec<f64> = (0..3).map(|k| mesh(&model.scene, k).area()).collect();
    for (area, expected) in areas.iter().zip([0.75, 0.21, 0.04]) {
        assert!((area - expected).abs() < 1e-12, "{areas:?}");
    }
}

fn written(scene: &Scene) -> View3dDocument {
    let mut text = Vec::new();
    write(scene, &mut text).unwrap();
    let (document, warnings) =
        View3dDocument::read(&text, "w.vs3", &ReadOptions::default()).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    document
}

#[test]
fn what_is_written_reads_back() {
    let room = room_with_table(500);
    let document = written(&room);
    let faces = mesh(&room, 0).faces.len();
    assert_eq!(document.surfaces.len(), faces);
    for (face, surface) in document.surfaces.iter().enumerate() {
        assert_eq!(
            document.corners(surface),
            mesh(&room, 0).face_positions(face)
        );
        assert_eq!((surface.name.as_str(), surface.combined), ("room", 0));
    }
    let model = model_of(&document);
    assert_eq!(model.names.len(), faces);
    let box_ = written(&cornell_box(CornellVariant::MirrorBlock));
    let mirror = box_.surfaces.iter().find(|s| s.name == "tall_top").unwrap();
    assert!((mirror.emissivity - 0.1).abs() < 1e-9);
    assert!(losses(&cornell_box(CornellVariant::MirrorBlock)).len() > 1);
}

#[test]
fn faces_of_many_corners_are_combined() {
    let l_shape = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
    let mut scene = Scene::default();
    let grey = scene.add_material(azulejo_scene::Material::default());
    let mut mesh = Mesh {
        positions: l_shape.map(|[x, y]| glam::DVec3::new(x, y, 0.0)).to_vec(),
        ..Mesh::default()
    };
    mesh.push_face(&[0, 1, 2, 3, 4, 5], grey);
    mesh.push_face(&[0, 1, 1], grey);
    mesh.push_face(&[0, 1, 2], grey);
    let object = azulejo_scene::Object::new("house/the floor, red", Shape::Mesh(mesh));
    scene.objects.push(object);
    let document = written(&scene);
    let roots: Vec<u32> = document.surfaces.iter().map(|s| s.combined).collect();
    assert_eq!(roots, [0, 0, 1, 1, 1]);
    assert_eq!(document.surfaces[0].name, "the_floor__red");
    let model = model_of(&document);
    assert_eq!(model.rows[0], [0, 1, 0, 0, 0].map(Some));
    assert_eq!(model.names.len(), 2);
}
