//! Light of vertices in edited files.

use super::super::convert::Overlay;
use super::super::strip;
use super::craft::{SQUARES, json_of, two_squares};
use super::kept;
use super::{Case, Container, GltfFile, Output, PatchedFile, corpus, mixed, with_vertex_light};
use crate::gltf::read_with_origins;
use crate::gltf::tests::draco;
use crate::{Files, Memory, ReadOptions};
use azulejo_scene::{Rgb, Scene, Shape};
use serde_json::{Value, json};

const OUTPUT: Output = Output {
    container: Container::Same,
    stem: "a",
};

/// Light for every vertex, which single precision represents exactly, but none for every fourth object.
fn light(scene: &mut Scene) {
    scene.unfold();
    for (i, object) in scene.objects.iter_mut().enumerate() {
        let Shape::Mesh(mesh) = &mut object.shape else {
            panic!("a mesh");
        };
        mesh.irradiance.clear();
        if i % 4 != 3 {
            let value = |v: usize, k: u64| (mixed(v as u64, i as u64 + k) % 4096) as f64 / 16.0;
            let vertices = 0..mesh.positions.len();
            let light = vertices.map(|v| Rgb::new(value(v, 1), value(v, 2), value(v, 3)));
            mesh.irradiance = light.collect();
        }
    }
}

/// Puts light into a file and reads it again; `None` if it cannot be read.
fn check(case: &Case) -> Option<PatchedFile> {
    let options = ReadOptions::default();
    let read =
        |bytes: &[u8], files: &dyn Files| read_with_origins(bytes, case.name, files, &options);
    let (mut loaded, origins) = read(case.bytes, case.files).ok()?;
    light(&mut loaded.scene);
    let file = GltfFile {
        bytes: case.bytes,
        name: case.name,
        files: case.files,
        options: &options,
    };
    let patched = with_vertex_light(&file, &origins, &loaded.scene, OUTPUT);
    let patched = patched.unwrap_or_else(|e| panic!("{e}"));
    kept::check_values(case.bytes, &patched.bytes);
    let files = Overlay {
        old: case.files,
        new: &patched.files,
    };
    let (mut again, new_origins) = read(&patched.bytes, &files).unwrap_or_else(|e| panic!("{e}"));
    kept::check_origins(&origins, &new_origins);
    again.scene.unfold();
    let objects = loaded.scene.objects.iter().zip(&again.scene.objects);
    for (old, new) in objects {
        let (old, new) = (old.shape.mesh().unwrap(), new.shape.mesh().unwrap());
        let [old_light, new_light] = [&old.irradiance, &new.irradiance];
        assert_eq!(old_light.is_empty(), new_light.is_empty());
        for (v, w) in old.faces.corners.iter().zip(&new.faces.corners) {
            assert_eq!(old.positions[*v as usize], new.positions[*w as usize]);
            let of = |list: &[Rgb], v: u32| list.get(v as usize).copied();
            let [a, b] = [of(&old.irradiance, *v), of(&new.irradiance, *w)];
            assert_eq!(a, b, "{}", case.name);
            let [a, b] = [of(&old.colors, *v), of(&new.colors, *w)];
            let [a, b] = [a, b].map(|colour| colour.unwrap_or(Rgb::WHITE));
            assert_eq!(a, b, "{}", case.name);
        }
    }
    let stripped = strip(&patched.bytes, case.name).unwrap();
    assert!(
        stripped.is_exact && stripped.is_of_vertices,
        "{}",
        case.name
    );
    // All edits are undone at once.
    let before = strip(case.bytes, case.name).map(|stripped| stripped.bytes);
    let before = before.unwrap_or(case.bytes.to_vec());
    kept::check_same(case.name, &before, &stripped.bytes);
    Some(patched)
}

#[test]
fn light_of_vertices_comes_back() {
    let mut craft = two_squares();
    craft.accessor(&[100; 24], 5121, 6, "VEC4", ",\"normalized\":true");
    let rest = r#""meshes":[{"primitives":[{@}],"extras":"text"},{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":2},"indices":1},{"attributes":{"POSITION":0},"mode":5}]}],
        "nodes":[{"mesh":0},{"mesh":0,"scale":[1,1,-1]},{"mesh":1},{"mesh":1}]"#;
    let bytes = craft.glb(&rest.replace('@', SQUARES));
    let case = Case {
        bytes: &bytes,
        name: "a.glb",
        files: &Memory::new(),
    };
    let patched = check(&case).unwrap();
    let json = json_of(&patched);
    assert_eq!(json["meshes"][0]["extras"]["value"], "text");
    assert_eq!(
        json["meshes"][0]["extras"]["azulejo"]["irradiance"]["attribute"],
        "COLOR_0"
    );
    // The last node has no light, so its mesh stays, and the other one gets a copy.
    assert_eq!(json["nodes"][3]["mesh"], 1);
    assert_eq!(
        json["meshes"][1]["primitives"][1]["attributes"],
        json!({ "POSITION": 0 })
    );
    let copy = json["nodes"][2]["mesh"].as_u64().unwrap() as usize;
    let extras = &json["meshes"][copy]["extras"]["azulejo"]["irradiance"];
    assert_eq!(
        (&extras["attribute"], &extras["unit"]),
        (&json!("COLOR_1"), &json!("lx"))
    );
    // New light takes the place of old light.
    let again = check(&Case {
        bytes: &patched.bytes,
        ..case
    })
    .unwrap();
    let extras = &json_of(&again)["meshes"][copy]["extras"]["azulejo"]["irradiance"];
    assert_eq!(extras["attribute"], "COLOR_1");
    // Once another program has written the file, it stays.
    let json = json_of(&again).to_string();
    let stripped = strip(json.as_bytes(), "a.gltf").unwrap();
    assert!(!stripped.is_exact && stripped.is_of_vertices);
    assert!(stripped.notes[0].contains("light on vertices stays"));
    let json: Value = serde_json::from_slice(&stripped.bytes).unwrap();
    assert_eq!(json.pointer("/asset/extras"), None);
    assert_eq!(json["meshes"][copy], json_of(&again)["meshes"][copy]);
}

#[test]
fn light_of_compressed_vertices() {
    let json = draco::file(&draco::bytes_of(draco::BY_GOOGLE[0]), 9, 24, 1, "");
    let case = Case {
        bytes: json.as_bytes(),
        name: "a.gltf",
        files: &Memory::new(),
    };
    let patched = check(&case).unwrap();
    assert!(json_of(&patched).get("extensionsRequired").is_none());
    assert_eq!(patched.files[0].0, "a.light.bin");
}

#[test]
fn light_in_files_of_others() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    corpus::each(&data, |case| drop(check(case)));
}
