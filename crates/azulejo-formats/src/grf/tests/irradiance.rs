//! Light put back into a document.

use super::*;
use azulejo_scene::{Rgb, SurfaceGrid, SurfaceLight};

/// Gives every object of a scene some light.
fn lit(mut scene: Scene) -> Scene {
    for object in &mut scene.objects {
        match &mut object.shape {
            Shape::Mesh(mesh) => {
                let count = mesh.positions.len();
                mesh.irradiance = (0..count).map(|v| Rgb::grey(v as f64 + 0.1)).collect();
                mesh.irradiance_error = vec![Rgb::grey(0.01); count];
            }
            Shape::Primitive(p) => {
                let grids = vec![SurfaceGrid { nu: 1, nv: 2 }; p.kind.parts()];
                p.light = Some(SurfaceLight {
                    irradiance: vec![Rgb::grey(7.0); 6 * grids.len()],
                    grids,
                    error: Vec::new(),
                });
            }
            Shape::Exact(_) => unreachable!("made for primitives and meshes"),
        }
    }
    scene
}

#[test]
fn a_solved_scene_goes_back_into_its_document() {
    let mut document = document(EVERYTHING);
    let solved = lit(scene(EVERYTHING));
    assert!(document.set_irradiance(&solved));
    let text = document_text(&document);
    assert!(text.starts_with("// A head.\n"));
    assert!(text.contains("rotation (0, 0, 90)"));
    assert_eq!(scene(&text), solved);
}

#[test]
fn included_objects_become_part_of_the_document() {
    let files = Memory::new().with("cube.grf", CUBE);
    let text = "transform scale (2, 2, 2) begin include \"cube.grf\" end";
    let (mut document, _) = Document::parse(text.as_bytes(), "test.grf", &files).unwrap();
    let solved = lit(document.resolve().unwrap().scene);
    assert!(document_text(&document).contains("include"));
    assert!(document.set_irradiance(&solved));
    let text = document_text(&document);
    assert!(!text.contains("include"));
    assert_eq!(scene(&text), solved);
}

#[test]
fn another_scene_changes_nothing() {
    let mut document = document(CUBE);
    let before = document_text(&document);
    let mut other = scene(CUBE);
    other.objects.push(other.objects[0].clone());
    assert!(!document.set_irradiance(&other));
    assert!(!document.set_irradiance(&scene(&triangle(""))));
    assert!(!document.set_irradiance(&Scene::default()));
    assert_eq!(document_text(&document), before);
}
