use super::read;
use crate::reader_tests::check_warnings;
use crate::{Loaded, Memory, ReadError, ReadOptions};
use azulejo_scene::{Mesh, Rgb, Shape};
use glam::{DVec2, DVec3};
use proptest::prelude::*;

fn try_load(text: &str) -> Result<Loaded, ReadError> {
    let files = Memory::new();
    let loaded = read(text.as_bytes(), "a.off", &files, &ReadOptions::default())?;
    loaded.scene.validate().unwrap();
    Ok(loaded)
}

fn load(text: &str) -> Loaded {
    try_load(text).unwrap_or_else(|e| panic!("{e}"))
}

fn mesh(loaded: &Loaded) -> &Mesh {
    match &loaded.scene.objects[0].shape {
        Shape::Mesh(mesh) => mesh,
        _ => unreachable!("OFF has meshes only"),
    }
}

fn check_error(text: &str, expected: &str) {
    let error = try_load(text).unwrap_err().to_string();
    assert_eq!(error.lines().next(), Some(expected));
}

const SQUARE: &str = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";

#[test]
fn words_may_be_anywhere() {
    let square = load(SQUARE);
    check_warnings(&square, &[]);
    assert_eq!(mesh(&square).positions[2], DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(mesh(&square).faces.corners, [0, 1, 2, 0, 2, 3]);
    let same = |text: &str| assert_eq!(load(text).scene, square.scene, "{text}");
    same("OFF 4 2 0 0 0 0 1 0 0 1 1 0 0 1 0 3 0 1 2\n3 0 2 3");
    same(&SQUARE.replace("OFF\n", ""));
    same(&SQUARE.replace("4 2 0", "# of vertices\n4 # and of faces\n 2"));
    same(&SQUARE.replace('\n', "\r\n"));
    same(&SQUARE.replace('\n', " # comment\n\n"));
    same(&["\u{feff}# made by hand\n", SQUARE].concat());
}

#[test]
fn faces_have_colours() {
    let paint = |color: &str| {
        let text = SQUARE.replace("3 0 1 2", &format!("3 0 1 2 {color}"));
        let loaded = load(&text);
        let material = mesh(&loaded).face_materials[0] as usize;
        (loaded.scene.materials[material].clone(), loaded)
    };
    let red = Rgb::new(1.0, 0.2, 0.0);
    for color in [
        "255 51 0",
        "1.0 0.2 0",
        "255 51 0 255",
        "1 .2 0 .5 # opacity",
        "7.0 .2 -1",
    ] {
        let (material, loaded) = paint(color);
        assert_eq!(
            (material.diffuse, material.name.as_str()),
            (red, "#ff3300"),
            "{color}"
        );
        assert_eq!(loaded.scene.materials.len(), 2);
        check_warnings(&loaded, &[]);
    }
    let (grey, loaded) = paint("3");
    assert_eq!(
        (grey.diffuse, grey.name.as_str()),
        (Rgb::grey(0.5), "default")
    );
    let message = "a.off: face with a number of a colour, whose table only Geomview has: grey";
    check_warnings(&loaded, &[message]);
    check_warnings(
        &paint("1 2 3 4 5").1,
        &["a.off: face with more numbers after its corners than a colour: these are skipped"],
    );
}

#[test]
fn vertices_have_more_than_places() {
    let text = "STCNOFF\n3 1 0\n0 0 0  0 0 2  255 0 51 255  0 .5\n1 0 0  0 0 1e300  0 0 0 255  1 .5\n\
                0 1 0  0 3 4  255 255 255 255  0 1\n3 0 1 2\n";
    let loaded = load(text);
    check_warnings(&loaded, &[]);
    let normals = mesh(&loaded).normals.as_ref().unwrap();
    assert_eq!(normals.values[..2], [DVec3::Z; 2]);
    assert!(normals.values[2].distance(DVec3::new(0.0, 0.6, 0.8)) < 1e-15);
    assert_eq!(mesh(&loaded).colors[0], Rgb::new(1.0, 0.0, 0.2));
    let uvs = mesh(&loaded).uvs.as_ref().unwrap();
    assert_eq!(uvs.values[1], DVec2::new(1.0, 0.5));
    // Colours multiply the material.
    assert_eq!(loaded.scene.materials[0].diffuse, Rgb::WHITE);
    let three = "COFF\n3 1 0\n0 0 0 255 0 51\n1 0 0 0 0 0 # black\n0 1 0 1.0 1 1\n3 0 1 2\n";
    assert_eq!(mesh(&load(three)).colors, mesh(&loaded).colors);
    let flat = load(&text.replace("0 3 4", "0 0 0"));
    assert_eq!(mesh(&flat).normals, None);
    check_warnings(
        &flat,
        &["a.off: normals of no length: all normals are skipped"],
    );
}

#[test]
fn what_is_no_face_is_counted() {
    let loaded =
        load("OFF 4 4 0 0 0 0 1 0 0 1 1 0 0 1 0 3 0 1 2\n2 0 1\n1 3\n0\n# end\nmore\nlines\n");
    assert_eq!(mesh(&loaded).faces.len(), 1);
    check_warnings(
        &loaded,
        &[
            "a.off: face of fewer than three corners: skipped (3 times)",
            "a.off: line after the last face: skipped (2 times)",
        ],
    );
    check_warnings(&load("OFF 0 0 0"), &["a.off: no faces: the scene is empty"]);
}

#[test]
fn errors_say_where() {
    let changed = |from: &str, to: &str| SQUARE.replace(from, to);
    check_error(
        &changed("3 0 2 3", "3 0 2 4"),
        "a.off:8:7: found vertex 4, expected one of the 4 vertices, from 0",
    );
    check_error(
        &changed("3 0 2 3", "3 0 2 -1"),
        "a.off:8:7: found \"-1\", expected the number of a vertex",
    );
    check_error(
        &changed("1 1 0", "1 nan 0"),
        "a.off:5:3: found \"nan\", expected a coordinate of a vertex",
    );
    check_error(
        &changed("4 2 0", "4 3 0"),
        "a.off:9:1: found the end of the file, expected a number of corners",
    );
    check_error(
        &changed("4 2 0", "four"),
        "a.off:2:1: found \"four\", expected a number of vertices",
    );
    check_error(
        &changed("3 0 1 2", "3 0 1 2 red"),
        "a.off:7:9: found \"red\", expected a colour of a face",
    );
    for first in ["4OFF", "nOFF", "C4OFF", "4nOFF"] {
        let found =
            "found vertices of more than three coordinates, expected vertices in space (OFF)";
        check_error(&changed("OFF", first), &format!("a.off:1:1: {found}"));
    }
    check_error(
        &changed("OFF", "OFF BINARY"),
        "a.off:1:1: found a binary OFF file, expected OFF as text, which all programs write",
    );
    check_error(
        &changed("OFF", "NCOFF"),
        "a.off:1:1: found \"NCOFF\", expected OFF, COFF, NOFF, CNOFF or STOFF",
    );
    check_error(
        &changed("OFF", "off"),
        "a.off:1:1: found \"off\", expected OFF",
    );
    check_error("", "a.off:1:1: found the end of the file, expected OFF");
}

#[test]
fn counts_reserve_no_memory() {
    for counts in ["18446744073709551615 1 0", "4 18446744073709551615 0"] {
        assert!(try_load(&SQUARE.replace("4 2 0", counts)).is_err());
    }
    assert!(try_load(&SQUARE.replace("3 0 2 3", "18446744073709551615 0 2 3")).is_err());
}

#[test]
fn a_cut_file_is_an_error() {
    let whole = load(SQUARE);
    for end in 0..SQUARE.len() - 2 {
        assert!(try_load(&SQUARE[..end]).is_err(), "{end}");
    }
    assert_eq!(load(SQUARE.trim()).scene, whole.scene);
}

proptest! {
    #[test]
    fn any_words_are_harmless(text in "(ST|C|N|4)?OFF [0-9. \n#-]{0,200}") {
        let _ = try_load(&text);
    }
}
