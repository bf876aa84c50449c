//! Irradiance stored in a document.

use super::solids::{FIGURES, SOLIDS};
use super::*;
use azulejo_scene::{Rgb, SurfaceGrid, SurfaceLight};
use glam::DVec3;

/// Gives every object of a scene some irradiance.
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
            Shape::Exact(exact) => {
                let materials: Vec<_> = exact.leaves().iter().map(|l| l.material()).collect();
                let mut skin = Mesh {
                    positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
                    irradiance: vec![Rgb::new(1.0, 2.0, 3.0); 3],
                    ..Mesh::default()
                };
                for material in materials {
                    skin.push_face(&[0, 1, 2], material);
                }
                exact.proxy = Some(Box::new(skin));
            }
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

fn skin(scene: &Scene, object: usize) -> &Mesh {
    match &scene.objects[object].shape {
        Shape::Exact(exact) => exact.proxy.as_ref().unwrap(),
        _ => panic!("object {object} is not exact"),
    }
}

#[test]
fn exact_shapes_take_their_skins_along() {
    let text = format!("// Letters.\n{FIGURES}{SOLIDS}end def\n");
    let mut document = document(&text);
    let solved = lit(scene(&text));
    assert!(document.set_irradiance(&solved));
    let saved = document_text(&document);
    assert!(saved.starts_with("// Letters.\n") && saved.contains("end instance\nend ext"));
    let again = scene(&saved);
    assert!(solved.is_solved() && again.is_solved());
    for object in 0..solved.objects.len() {
        let (before, after) = (skin(&solved, object), skin(&again, object));
        // Transforms around a shape are inverted and applied again, which may round.
        let near = |(a, b): (&DVec3, &DVec3)| (*a - *b).length() < 1e-14;
        assert!(before.positions.iter().zip(&after.positions).all(near));
        assert_eq!(before.irradiance, after.irradiance);
        assert_eq!(before.face_materials, after.face_materials);
        assert_eq!(before.faces, after.faces);
    }
    // Without enclosing transforms, every bit is kept.
    assert_eq!(again.objects[0], solved.objects[0]);
    assert_eq!(scene(&written(&solved)), solved);
}

#[test]
fn included_objects_become_part_of_the_document() {
    let files = Memory::new().with("cube.grf", CUBE);
    let text = "transform scale (2, 2, 2) begin include \"cube.grf\" end";
    let (mut document, _) = GrfDocument::parse(text.as_bytes(), "test.grf", &files).unwrap();
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
