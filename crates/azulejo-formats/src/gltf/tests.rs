//! Reading, and writing and reading back.

pub(super) mod draco;
mod errors;
mod lightmaps;
mod materials;
mod meshes;
mod origins;
mod round_trip;
mod scenes;
mod surroundings;

use crate::{Loaded, Memory, ReadOptions, gltf};
use azulejo_scene::{Mesh, Scene, Shape};

/// JSON of a file: `more` after the asset.
fn json(more: &str) -> String {
    format!("{{\"asset\":{{\"version\":\"2.0\"}},{more}}}")
}

/// A triangle in the plane z = 0, its three positions at the start of a buffer of floats that
/// continues with `more`; accessor 0. Other accessors follow in `accessors`, each with its comma.
fn triangle(more: &[f32], accessors: &str, rest: &str) -> String {
    let positions = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let floats = positions.iter().chain(more);
    let bytes: Vec<u8> = floats.flat_map(|f| f.to_le_bytes()).collect();
    let escaped: String = bytes.iter().map(|b| format!("%{b:02x}")).collect();
    json(&format!(
        "\"buffers\":[{{\"byteLength\":{0},\"uri\":\"data:,{escaped}\"}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}},\
                          {{\"buffer\":0,\"byteOffset\":36,\"byteLength\":{1}}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\
                          \"min\":[0,0,0],\"max\":[1,1,0]}}{accessors}],{rest}",
        bytes.len(),
        bytes.len() - 36,
    ))
}

/// The JSON of an accessor of the second view.
fn accessor(component: u32, count: u32, kind: &str) -> String {
    format!(
        ",{{\"bufferView\":1,\"componentType\":{component},\"count\":{count},\"type\":\"{kind}\"}}"
    )
}

/// One node with a mesh of these primitives.
fn one_mesh(primitives: &str) -> String {
    format!("\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{primitives}]}}]")
}

fn loaded(file: &[u8]) -> Loaded {
    let loaded = gltf::read(file, "a.gltf", &Memory::new(), &ReadOptions::default());
    let loaded = loaded.unwrap_or_else(|e| panic!("{e}"));
    loaded.scene.validate().unwrap();
    loaded
}

/// The scene of a file with these warnings, in their order.
fn read(file: &str, warnings: &[&str]) -> Scene {
    let loaded = loaded(file.as_bytes());
    let messages: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(messages.len(), warnings.len(), "{messages:?}");
    for (message, part) in messages.iter().zip(warnings) {
        assert!(message.contains(part), "{message}, expected {part}");
    }
    loaded.scene
}

fn mesh_of(scene: &Scene, object: usize) -> &Mesh {
    match &scene.objects[object].shape {
        Shape::Mesh(mesh) => mesh,
        _ => panic!("glTF has meshes only"),
    }
}
