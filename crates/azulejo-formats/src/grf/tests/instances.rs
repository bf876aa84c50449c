//! Meshes that stand in several places.

use super::*;
use crate::grf::GrfText;
use azulejo_scene::{BackIrradiance, Material, MeshInstance, Object, Rgb, SharedMesh, VertexLight};
use glam::{DAffine3, DMat3, DVec3};
use std::fmt::Write as _;

fn read_with(files: &Memory, text: &str) -> Scene {
    read(text.as_bytes(), "test.grf", files)
        .unwrap_or_else(|e| panic!("{e}"))
        .scene
}

fn instance(scene: &Scene, object: usize) -> &MeshInstance {
    match &scene.objects[object].shape {
        Shape::Instance(instance) => instance,
        _ => panic!("object {object} is not an instance"),
    }
}

/// A chair of two materials and its copies: turned, stretched unevenly, mirrored.
fn chairs() -> Scene {
    let mut scene = Scene::default();
    let wood = scene.add_material(Material::diffuse("wood", Rgb::new(0.5, 0.3, 0.1)));
    let cloth = scene.add_material(Material::diffuse("cloth", Rgb::new(0.1, 0.2, 0.7)));
    let mut mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        ..Mesh::default()
    };
    mesh.push_face(&[0, 2, 1], wood);
    mesh.push_face(&[0, 1, 3], cloth);
    let mut shared = SharedMesh::new(mesh);
    let places = [
        DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0)),
        DAffine3::from_rotation_z(0.1) * DAffine3::from_scale(DVec3::new(1.0, 2.0, 0.3)),
        DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0)), DVec3::X),
        DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
    ];
    for (k, place) in places.into_iter().enumerate() {
        let placed = shared.placed(place).unwrap();
        let name = format!("row/chair {k}");
        scene
            .objects
            .push(Object::new(name, Shape::Instance(placed)));
    }
    scene.validate().unwrap();
    scene
}

#[test]
fn shared_meshes_are_written_once() {
    let scene = chairs();
    let text = written(&scene);
    // The mesh and its mirrored copy.
    assert_eq!(text.matches("begin vertices").count(), 2, "{text}");
    assert_eq!(text.matches("ext mesh_instance").count(), 2, "{text}");
    let again = super::scene(&text);
    assert_eq!(again, scene);
    assert_eq!(again.shared_meshes().len(), 2);
    assert_eq!(written(&again), text);
}

#[test]
fn every_place_keeps_its_light() {
    let mut scene = chairs();
    for (k, object) in scene.objects.iter_mut().enumerate() {
        let Shape::Instance(instance) = &mut object.shape else {
            unreachable!("made so");
        };
        let level = |v: usize| Rgb::new(v as f64, k as f64, 1.0 / 3.0);
        let back = (k == 1).then(|| BackIrradiance {
            irradiance: vec![None, Some(Rgb::WHITE), None, Some(Rgb::BLACK)],
            error: vec![Rgb::BLACK, Rgb::grey(0.5), Rgb::BLACK, Rgb::grey(0.25)],
        });
        instance.light = Some(Box::new(VertexLight {
            irradiance: (0..4).map(level).collect(),
            error: if k > 1 {
                vec![Rgb::grey(0.1); 4]
            } else {
                Vec::new()
            },
            back: back.map(Box::new),
        }));
    }
    scene.validate().unwrap();
    let text = written(&scene);
    assert_eq!(super::scene(&text), scene);
    // A file of another number of values is refused by its line.
    let start = text.rfind("irad =").unwrap();
    let short = format!("{}irad = (1, 1, 1){}", &text[..start], {
        let rest = &text[start..];
        &rest[rest.find("\nirad_error").unwrap()..]
    });
    let error = read(short.as_bytes(), "test.grf", &Memory::new()).unwrap_err();
    assert!(
        error.to_string().contains("another number of values"),
        "{error}"
    );
}

#[test]
fn an_instance_of_nothing() {
    let text = "ext mesh_instance begin of = chair map = 1 0 0 0 1 0 0 0 1 0 0 0 end ext";
    let error = read(text.as_bytes(), "test.grf", &Memory::new()).unwrap_err();
    let message = error.to_string();
    assert!(message.starts_with("test.grf:1:"), "{message}");
    assert!(
        message.contains("the name of an `ext shared_mesh` before it"),
        "{message}"
    );
    let flat = format!(
        "{} ext shared_mesh begin name = a map = 1 0 0 0 1 0 0 0 1 0 0 0 end ext \
         ext mesh_instance begin of = a map = 1 0 0 0 1 0 0 0 0 0 0 0 end ext",
        triangle("")
    );
    let error = read(flat.as_bytes(), "test.grf", &Memory::new()).unwrap_err();
    assert!(
        error.to_string().contains("that form an invertible map"),
        "{error}"
    );
}

/// Five thousand includes of a part: one mesh and the materials of one part.
#[test]
fn many_includes_of_one_part() {
    let part = format!(
        "def oak = rgb (0.5, 0.3, 0.1) {}",
        triangle("use color oak brdf phong n = 20 ks = 0.2 kd = 0.1")
    );
    let files = Memory::new().with("part.grf", part);
    let mut text = String::new();
    for k in 0..5000 {
        writeln!(
            text,
            "transform translation ({k}, 0, 0) begin include \"part.grf\" end"
        )
        .unwrap();
    }
    let scene = read_with(&files, &text);
    assert_eq!(scene.objects.len(), 5000);
    assert_eq!(scene.shared_meshes().len(), 1);
    assert!(scene.materials.len() <= 2, "{}", scene.materials.len());
    let mesh = &instance(&scene, 0).mesh;
    assert!((0..5000).all(|k| std::sync::Arc::ptr_eq(mesh, &instance(&scene, k).mesh)));
    let last = instance(&scene, 4999);
    assert_eq!(last.position(1), DVec3::new(5000.0, 0.0, 0.0));
    // Written and read again it is still one mesh.
    let again = super::scene(&written(&scene));
    assert_eq!(again, scene);
    assert_eq!(again.shared_meshes().len(), 1);
}

/// A name that the included file leaves to the one around it may mean something else each time.
#[test]
fn includes_that_mean_something_else_each_time() {
    let files = Memory::new().with("part.grf", triangle("use color paint"));
    let text = "begin def paint = rgb (1, 0, 0) include \"part.grf\" end \
        begin def paint = rgb (0, 0, 1) include \"part.grf\" include \"part.grf\" end";
    let scene = read_with(&files, text);
    let color = |k: usize| {
        let id = scene.objects[k].shape.mesh().unwrap().face_materials[0];
        scene.materials[id as usize].diffuse
    };
    let [red, blue] = [Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.0, 1.0)];
    assert_eq!([0, 1, 2].map(color), [red, blue, blue]);
    assert_eq!(scene.shared_meshes().len(), 1);
}

/// A part within a part, and a mirrored include.
#[test]
fn includes_of_includes_are_shared() {
    let files = Memory::new().with("leaf.grf", triangle("")).with(
        "branch.grf",
        "include \"leaf.grf\" transform scale (1, 1, -2) begin include \"leaf.grf\" end",
    );
    let text =
        "include \"branch.grf\" transform translation (0, 0, 5) begin include \"branch.grf\" end";
    let scene = read_with(&files, text);
    assert_eq!(scene.objects.len(), 4);
    assert_eq!(scene.shared_meshes().len(), 2);
    // The front of a triangle in the mirrored leaf stays its front.
    let plain = |text: &str| {
        let unshared = text.replace("leaf", "other");
        let more = files.clone().with("other.grf", triangle(""));
        read_with(&more, &unshared)
    };
    let twice = plain("transform scale (1, 1, -2) begin include \"leaf.grf\" end");
    let alone = twice.unfolded();
    let unfolded = scene.unfolded();
    assert_eq!(
        unfolded.objects[1]
            .shape
            .mesh()
            .unwrap()
            .face_area_vector(0),
        alone.objects[0].shape.mesh().unwrap().face_area_vector(0)
    );
}

#[test]
fn light_in_place_of_repeated_includes() {
    let files = Memory::new().with("part.grf", triangle(""));
    let text =
        "include \"part.grf\"\ntransform translation (0, 0, 2) begin include \"part.grf\" end\n";
    let mut scene = read_with(&files, text);
    let triple = |k: usize| vec![Rgb::grey(k as f64 + 0.5); 3];
    for k in 0..2 {
        let Shape::Instance(instance) = &mut scene.objects[k].shape else {
            panic!("includes of one file are instances");
        };
        instance.light = Some(Box::new(VertexLight {
            irradiance: triple(k),
            ..VertexLight::default()
        }));
    }
    let given = GrfText::parse(text.as_bytes().to_vec(), "test.grf", &files).unwrap();
    let lit = given.lit(&scene, &files).unwrap();
    let again = read_with(&files, std::str::from_utf8(&lit.bytes).unwrap());
    for k in 0..2 {
        assert_eq!(
            *again.objects[k].shape.placed_mesh().unwrap().irradiance,
            triple(k)
        );
    }
}
