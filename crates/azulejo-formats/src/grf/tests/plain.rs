//! Scenes in the words of 2001.

use super::*;
use crate::grf::{plain_losses, write_plain};
use azulejo_scene::{
    BackIrradiance, Camera, Material, Object, Primitive, PrimitiveKind, Rgb, Texture, Units,
};
use glam::{DAffine3, DVec3};

fn plain(scene: &Scene) -> String {
    let pictures: Vec<String> = scene.textures.iter().map(|t| t.path.clone()).collect();
    let mut out = Vec::new();
    write_plain(scene, &pictures, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    let words: Vec<&str> = text.lines().filter(|l| !l.starts_with("//")).collect();
    assert!(!words.join("\n").contains("ext "), "{text}");
    text
}

fn quad(materials: &[u32]) -> Mesh {
    let mut mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y],
        ..Mesh::default()
    };
    for &material in materials {
        mesh.push_face(&[0, 1, 2, 3], material);
    }
    mesh
}

/// Matt, lamp, mirror, pictured.
fn materials() -> Scene {
    let mut scene = Scene::default();
    scene.add_material(Material::diffuse("wall", Rgb::grey(0.5)));
    scene.add_material(Material::emitter("lamp", Rgb::grey(9.0)));
    scene.add_material(Material {
        mirror: Rgb::grey(0.8),
        diffuse: Rgb::BLACK,
        ..Material::default()
    });
    scene.textures.push(Texture {
        path: "wood.png".to_owned(),
        image: None,
        ..Texture::default()
    });
    scene.add_material(Material {
        textures: vec![0],
        ..Material::diffuse("wood", Rgb::grey(0.25))
    });
    scene
}

fn with(mut scene: Scene, shape: Shape) -> Scene {
    scene.objects.push(Object::new("a table", shape));
    scene
}

#[test]
fn lamps_that_are_parallelograms_are_lights() {
    let lights = |text: &str| text.matches("\nlight begin rgb (9, 9, 9)").count();
    let map = DAffine3::from_scale(DVec3::new(2.0, 3.0, 7.0));
    let square = Primitive::new(PrimitiveKind::Square, map, 1);
    let scene = with(materials(), Shape::Primitive(square));
    let text = plain(&scene);
    assert!(
        text.contains("(0, 0, 0) (2, 0, 0) (0, 3, 0) end light"),
        "{text}"
    );
    // The canonical writer as well, whatever the third axis, as the workbench makes them.
    assert_eq!(lights(&written(&scene)), 1);
    assert_eq!(
        lights(&plain(&with(materials(), Shape::Mesh(quad(&[1]))))),
        1
    );
    let mut triangles = quad(&[]);
    triangles.push_face(&[0, 1, 2], 1);
    triangles.push_face(&[2, 3, 0], 1);
    let text = plain(&with(materials(), Shape::Mesh(triangles)));
    assert_eq!(lights(&text), 1);
    let light = super::scene(&text);
    let Shape::Primitive(light) = &light.objects[0].shape else {
        panic!("a light")
    };
    assert!((light.area() - 1.0).abs() < 1e-12);
    // A trapezium is a mesh that shines, and so are two triangles that face away from each other.
    let mut skewed = quad(&[1]);
    skewed.positions[2].x = 2.0;
    let mut folded = quad(&[]);
    folded.push_face(&[0, 1, 2], 1);
    folded.push_face(&[0, 3, 2], 1);
    for mesh in [skewed, folded] {
        let text = plain(&with(materials(), Shape::Mesh(mesh)));
        assert!(
            text.contains("mesh light begin\nrgb (9, 9, 9)\nbegin vertices"),
            "{text}"
        );
    }
}

#[test]
fn faces_that_one_mesh_cannot_hold_are_several() {
    let scene = with(materials(), Shape::Mesh(quad(&[0, 1, 2, 3, 0])));
    let text = plain(&scene);
    assert!(text.contains("def wall = rgb (0.5, 0.5, 0.5)\n"));
    assert!(text.contains("// a table\nbegin mesh\n"), "{text}");
    let again = super::scene(&text);
    assert_eq!(again.objects.len(), 4);
    let materials: Vec<(usize, &Material)> = (0..4)
        .map(|k| {
            let mesh = mesh(&again, k);
            (
                mesh.faces.len(),
                &again.materials[mesh.face_materials[0] as usize],
            )
        })
        .collect();
    assert_eq!(
        materials.iter().map(|f| f.0).collect::<Vec<_>>(),
        [2, 1, 1, 1]
    );
    assert_eq!(materials[0].1.diffuse, Rgb::grey(0.5));
    assert_eq!(materials[1].1.emission, Rgb::grey(9.0));
    assert_eq!(materials[2].1.mirror, Rgb::grey(0.8));
    assert!(materials[2].1.textures.is_empty());
    assert_eq!(materials[3].1.textures.len(), 1);
}

/// Lamps that are meshes are not taken from the number of primitives.
#[test]
fn a_lamp_of_four_vertices_loses_nothing() {
    let mut scene = with(materials(), Shape::Mesh(quad(&[1])));
    scene.materials[1].diffuse = Rgb::BLACK;
    assert!(plain_losses(&scene).is_empty());
}

#[test]
fn solids_become_meshes_and_backs_faces() {
    let mut scene = with(
        materials(),
        Shape::Primitive(Primitive::sphere(DVec3::ZERO, 1.0, 0)),
    );
    let mut sheet = quad(&[0]);
    sheet.irradiance = vec![Rgb::grey(1.0); 4];
    sheet.back = Some(Box::new(BackIrradiance {
        irradiance: vec![Some(Rgb::grey(2.0)); 4],
        error: Vec::new(),
    }));
    scene.objects.push(Object::new("", Shape::Mesh(sheet)));
    scene.units = Units {
        metres_per_unit: Some(0.01),
        ..Units::default()
    };
    scene.cameras.push(Camera {
        name: String::new(),
        eye: DVec3::ZERO,
        target: DVec3::X,
        up: DVec3::Z,
        vertical_fov: 1.0,
        size: None,
    });
    let again = super::scene(&plain(&scene));
    assert!((mesh(&again, 0).area() / 12.566 - 1.0).abs() < 0.01);
    assert_eq!(
        mesh(&again, 1).irradiance[..],
        [1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0].map(Rgb::grey)
    );
    let expected = [
        "the unit",
        "1 cameras",
        "1 exact primitives that become polygons",
        "1 meshes whose backs become faces of their own",
    ];
    assert_eq!(plain_losses(&scene), expected);
    assert!(plain_losses(&materials()).is_empty());
    assert_eq!(
        plain(&Scene::default()),
        "// azulejo 0.1.0\n// Components: 0\n// Vertices: 0, faces: 0\n;\n"
            .replace("0.1.0", env!("CARGO_PKG_VERSION"))
    );
}
