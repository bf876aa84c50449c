//! VRML97 and X3D, tested with small files.

mod appearances;
mod broken;
mod groups;
mod prototypes;
mod shapes;

use crate::{Files, Lod, Memory, ReadOptions};
use azulejo_scene::{Mesh, Scene, Shape};
use glam::DVec3;

/// Reads a model, which must be readable and valid.
fn load_with(text: &str, files: &dyn Files, options: &ReadOptions) -> (Scene, Vec<String>) {
    let loaded = super::read(text.as_bytes(), "model.wrl", files, options).unwrap();
    loaded.scene.validate().unwrap();
    let warnings = loaded.warnings.iter().map(ToString::to_string);
    (loaded.scene, warnings.collect())
}

/// Reads the text after the header of VRML97, or a whole file.
fn load(text: &str) -> (Scene, Vec<String>) {
    let header = if text.starts_with(['#', '<']) {
        ""
    } else {
        "#VRML V2.0 utf8\n"
    };
    let files = Memory::new();
    load_with(&format!("{header}{text}"), &files, &ReadOptions::default())
}

/// One line per object: name, vertices and faces or the type of an exact shape, and the bounding
/// box, rounded to thousandths.
fn described(scene: &Scene) -> Vec<String> {
    let round = |v: DVec3| {
        // Adding zero turns −0 into 0.
        let rounded = v.to_array().map(|x| (x * 1e3).round() / 1e3 + 0.0);
        format!("{} {} {}", rounded[0], rounded[1], rounded[2])
    };
    let describe = |o: &azulejo_scene::Object| {
        let kind = match &o.shape {
            Shape::Mesh(m) => format!("{} vertices {} faces", m.positions.len(), m.faces.len()),
            Shape::Primitive(p) => format!("{:?}", p.kind),
            Shape::Exact(_) | Shape::Instance(_) => "exact or shared".to_owned(),
        };
        let bounds = o.bounds();
        format!(
            "{}: {kind}, {} to {}",
            o.name,
            round(bounds.min),
            round(bounds.max)
        )
    };
    scene.objects.iter().map(describe).collect()
}

/// Checks the objects, and that there are no warnings.
fn check(text: &str, objects: &[&str]) {
    check_lossy(text, objects, &[]);
}

/// Checks the objects and the beginnings of the warnings after the file name.
fn check_lossy(text: &str, objects: &[&str], warnings: &[&str]) {
    let (scene, messages) = load(text);
    assert_eq!(described(&scene), objects, "{text}");
    expect_warnings(&messages, warnings);
}

fn expect_warnings(messages: &[String], expected: &[&str]) {
    assert_eq!(messages.len(), expected.len(), "{messages:#?}");
    for (message, expected) in messages.iter().zip(expected) {
        let message = message.strip_prefix("model.wrl").unwrap_or(message);
        assert!(
            message.starts_with(expected),
            "{message:?} is not {expected:?}"
        );
    }
}

/// The one mesh of a model.
fn mesh(text: &str) -> Mesh {
    let (scene, _) = load(text);
    match &scene.objects[..] {
        [object] => match &object.shape {
            Shape::Mesh(mesh) => mesh.clone(),
            _ => panic!("an exact shape"),
        },
        objects => panic!("{} objects", objects.len()),
    }
}

/// Six times the volume of a mesh, positive if its faces point outwards.
fn volume(mesh: &Mesh) -> f64 {
    let part = |f: usize| mesh.face_area_vector(f).dot(mesh.face_positions(f)[0]) / 3.0;
    (0..mesh.faces.len()).map(part).sum()
}

fn with_lod(lod: Lod) -> ReadOptions {
    ReadOptions {
        lod,
        ..ReadOptions::default()
    }
}

/// A Shape of a material and this geometry.
fn shape(geometry: &str) -> String {
    format!("Shape {{ appearance Appearance {{ material Material {{ }} }} geometry {geometry} }}")
}
