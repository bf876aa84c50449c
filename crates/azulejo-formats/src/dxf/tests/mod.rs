//! Rules of DXF, each in a small drawing.

mod blocks;
mod entities;
mod figures;
mod files;

use super::read;
use crate::reader_tests::mesh;
use crate::{Files, Loaded, Memory, ReadError, ReadOptions};
use azulejo_scene::Mesh;
use glam::DVec3;

/// The lines of groups written as `code value; code value`. `@10 1 2 3` is a point: its
/// coordinates have the codes 10, 20 and 30.
fn groups(text: &str) -> String {
    let mut lines = String::new();
    let mut group = |code: &str, value: &str| lines.push_str(&format!("{code}\n{value}\n"));
    for item in text
        .split(';')
        .map(str::trim)
        .filter(|item| !item.is_empty())
    {
        let (code, value) = item.split_once(' ').unwrap_or((item, ""));
        match code.strip_prefix('@') {
            None => group(code, value),
            Some(first) => {
                let first: i32 = first.parse().unwrap();
                for (i, coordinate) in value.split_whitespace().enumerate() {
                    group(&(first + 10 * i as i32).to_string(), coordinate);
                }
            }
        }
    }
    lines
}

/// A file of these sections, each with its name and groups.
fn file(sections: &[(&str, &str)]) -> String {
    let section = |(name, text): &(&str, &str)| {
        let name = groups(&format!("0 SECTION; 2 {name}"));
        format!("{name}{}0\nENDSEC\n", groups(text))
    };
    let body: String = sections.iter().map(section).collect();
    body + "0\nEOF\n"
}

/// A drawing with only entities.
fn entities(text: &str) -> String {
    file(&[("ENTITIES", text)])
}

fn try_load(text: impl AsRef<[u8]>, files: &dyn Files) -> Result<Loaded, ReadError> {
    let loaded = read(text.as_ref(), "a.dxf", files, &ReadOptions::default())?;
    loaded.scene.validate().unwrap_or_else(|e| panic!("{e}"));
    Ok(loaded)
}

fn load_with(text: impl AsRef<[u8]>, files: &dyn Files) -> Loaded {
    try_load(text, files).unwrap_or_else(|e| panic!("{e}"))
}

fn load(text: impl AsRef<[u8]>) -> Loaded {
    load_with(text, &Memory::new())
}

/// The only mesh of a drawing that is read without a warning.
fn only_mesh(text: &str) -> Mesh {
    let loaded = load(text);
    assert_eq!(loaded.warnings, [], "{text}");
    assert_eq!(loaded.scene.objects.len(), 1, "{text}");
    mesh(&loaded, 0).clone()
}

fn names(loaded: &Loaded) -> Vec<&str> {
    loaded
        .scene
        .objects
        .iter()
        .map(|o| o.name.as_str())
        .collect()
}

/// Names of the materials.
fn materials(loaded: &Loaded) -> Vec<&str> {
    loaded
        .scene
        .materials
        .iter()
        .map(|m| m.name.as_str())
        .collect()
}

/// The warnings of a drawing, with their line and count.
fn warnings(loaded: &Loaded) -> Vec<String> {
    let messages = loaded.warnings.iter().map(ToString::to_string);
    messages
        .map(|w| w.trim_start_matches("a.dxf").to_owned())
        .collect()
}

fn check_warnings(text: impl AsRef<[u8]>, expected: &[&str]) {
    assert_eq!(warnings(&load(text)), expected);
}

/// Positions of the corners of a mesh's faces.
fn polygons(mesh: &Mesh) -> Vec<Vec<DVec3>> {
    (0..mesh.faces.len())
        .map(|f| mesh.face_positions(f))
        .collect()
}

/// Checks polygons corner by corner, up to rounding.
fn check_polygons(mesh: &Mesh, expected: &[&[[f64; 3]]]) {
    let actual = polygons(mesh);
    let same = |a: &DVec3, b: &[f64; 3]| (*a - DVec3::from_array(*b)).length() < 1e-9;
    let same_polygon = |a: &Vec<DVec3>, b: &&[[f64; 3]]| {
        a.len() == b.len() && a.iter().zip(*b).all(|(a, b)| same(a, b))
    };
    let is_same = actual.len() == expected.len()
        && actual.iter().zip(expected).all(|(a, b)| same_polygon(a, b));
    assert!(is_same, "{actual:?}\nand not {expected:?}");
}

/// Checks that a mesh is closed and that its fronts are outside: every edge occurs once in each
/// direction, and the volume is as given.
fn check_body(mesh: &Mesh, volume: f64) {
    let mut edges = std::collections::HashMap::new();
    let mut sum = 0.0;
    for polygon in polygons(mesh) {
        let key = |p: DVec3| p.to_array().map(|x| (x * 1e6).round() as i64);
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            *edges.entry((key(a), key(b))).or_insert(0) += 1;
            *edges.entry((key(b), key(a))).or_insert(0) -= 1;
            sum += polygon[0].dot(a.cross(b)) / 6.0;
        }
    }
    assert!(edges.values().all(|count| *count == 0), "open edges");
    assert!(
        (sum - volume).abs() < 1e-9 * volume.abs().max(1.0),
        "volume {sum} and not {volume}"
    );
}
