//! Instances that become nodes.

use super::craft::{SQUARES, json_of, two_squares};
use super::*;
use crate::Memory;
use crate::gltf::patch::expansion::expanded;

/// Two instances at a node with a child, turned and mirrored ones among them; and a node whose instances cannot be read.
fn instanced() -> Vec<u8> {
    let mut craft = two_squares();
    let places = craft.floats(&[1.0, 2.0, 3.0, -4.0, 0.5, 0.0], "VEC3");
    // A quarter turn about y, as normalized bytes, and none.
    let turns = craft.accessor(
        &[0, 90, 0, 90, 0, 0, 0, 127],
        5120,
        2,
        "VEC4",
        ",\"normalized\":true",
    );
    let scales = craft.floats(&[1.0, 1.0, 1.0, -2.0, 1.0, 0.5], "VEC3");
    let attributes =
        format!("\"TRANSLATION\":{places},\"ROTATION\":{turns},\"SCALE\":{scales},\"_ID\":0");
    let instancing = |attributes: &str| {
        format!(
            "\"extensions\":{{\"EXT_mesh_gpu_instancing\":{{\"attributes\":{{{attributes}}}}}}}"
        )
    };
    let rest = format!(
        "\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\",\"other\"],\"meshes\":[{{\"primitives\":[{{{SQUARES}}}]}}],\
         \"nodes\":[{{\"name\":\"trees\",\"translation\":[0,0,7],\"mesh\":0,{},\"children\":[1]}},{{\"mesh\":0}},\
         {{\"mesh\":0,{}}}]",
        instancing(&attributes),
        instancing("\"SCALE\":99")
    );
    craft.glb(&rest)
}

fn file<'a>(bytes: &'a [u8], files: &'a Memory, options: &'a ReadOptions) -> GltfFile<'a> {
    GltfFile {
        bytes,
        name: "trees.glb",
        files,
        options,
    }
}

#[test]
fn instances_become_nodes_and_back() {
    let (bytes, files, options) = (instanced(), Memory::new(), ReadOptions::default());
    let read = |bytes: &[u8]| gltf::read_with_origins(bytes, "trees.glb", &files, &options);
    let new = expanded(&file(&bytes, &files, &options)).unwrap().unwrap();
    let [(before, _), (after, origins)] = [&bytes, &new].map(|bytes| read(bytes).unwrap());
    // The same places in the same order, to single precision.
    assert_eq!(before.scene.objects.len(), 4);
    assert_eq!(after.scene.objects.len(), 4);
    for (a, b) in before.scene.objects.iter().zip(&after.scene.objects) {
        assert_eq!(a.name, b.name);
        let [a, b] = [a, b].map(|o| o.shape.placed_mesh().unwrap());
        for v in 0..6 {
            let off = (a.position(v) - b.position(v)).length();
            assert!(off < 1e-5, "{:?} {:?}", a.position(v), b.position(v));
        }
    }
    let nodes: Vec<usize> = origins.iter().map(|o| o.node).collect();
    assert_eq!(nodes, [3, 4, 1, 2]);
    assert!(origins.iter().all(|o| o.instance.is_none()));
    let mirrored: Vec<bool> = origins.iter().map(|o| o.mirrored).collect();
    assert_eq!(mirrored, [false, true, false, false]);
    // The extension stays where its numbers cannot be read.
    let json = json_of(&PatchedFile {
        bytes: new.clone(),
        ..PatchedFile::default()
    });
    assert!(json["nodes"][0]["extensions"].is_null());
    assert!(json["nodes"][2]["extensions"].is_object());
    assert_eq!(json["nodes"][0]["children"], serde_json::json!([3, 4, 1]));
    let stripped = strip(&new, "trees.glb").unwrap();
    assert!(stripped.is_exact);
    kept::check_same("trees.glb", &bytes, &stripped.bytes);
    // Nothing is left to expand, and files without instances are none.
    let again = expanded(&file(&stripped.bytes, &files, &options)).unwrap();
    assert!(again.is_some_and(|again| again == new));
    let plain = two_squares().glb(&format!(
        "\"meshes\":[{{\"primitives\":[{{{SQUARES}}}]}}],\"nodes\":[{{\"mesh\":0}}]"
    ));
    assert!(expanded(&file(&plain, &files, &options)).unwrap().is_none());
}

/// Each instance has coordinates of its own, in either container, and one strip undoes everything.
#[test]
fn instances_get_lightmaps() {
    let (bytes, files, options) = (instanced(), Memory::new(), ReadOptions::default());
    let new = expanded(&file(&bytes, &files, &options)).unwrap().unwrap();
    let original = file(&new, &files, &options);
    let (loaded, origins) = gltf::read_with_origins(&new, "trees.glb", &files, &options).unwrap();
    let pages = pages(1);
    let objects = layouts(&loaded.scene, &origins, Charts::Random(5), 1);
    for container in [Container::Same, Container::Json] {
        let mut edit = usual(&objects, &pages);
        edit.output.container = container;
        let patched = with_lightmap(&original, &origins, &edit).unwrap();
        let beside = Overlay {
            old: &files,
            new: &patched.files,
        };
        let lit = GltfFile {
            bytes: &patched.bytes,
            files: &beside,
            ..original
        };
        let read = gltf::read_with_origins(&patched.bytes, "trees.glb", &beside, &options);
        let (_, new_origins) = read.unwrap();
        kept::check_origins(&origins, &new_origins);
        kept::check_coordinates(&lit, &new_origins, &objects);
        let json = json_of(&patched);
        let mut meshes: Vec<u64> = new_origins.iter().map(|o| o.mesh as u64).collect();
        meshes.sort_unstable();
        meshes.dedup();
        assert_eq!(meshes.len(), 4, "{json}");
        let stripped = strip(&patched.bytes, "trees.glb").unwrap();
        assert!(stripped.is_exact);
        if container == Container::Same {
            kept::check_same("trees.glb", &bytes, &stripped.bytes);
        } else {
            let json: serde_json::Value = serde_json::from_slice(&stripped.bytes).unwrap();
            assert!(json["nodes"][0]["extensions"].is_object());
            assert_eq!(json["nodes"].as_array().unwrap().len(), 3);
        }
        // Once more, over what is there.
        let twice = with_lightmap(&lit, &origins, &edit);
        assert!(twice.is_err(), "its origins are those of the expanded file");
    }
}

/// An instance at no place at all is left out, as by the reader (found by fuzzing).
#[test]
fn instances_that_are_nowhere() {
    let mut craft = two_squares();
    let places = craft.floats(
        &[f32::NAN, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, f32::INFINITY, 0.0],
        "VEC3",
    );
    craft.accessors[places] = craft.accessors[places]
        .split(",\"min\"")
        .next()
        .unwrap()
        .to_owned()
        + "}";
    let rest = format!(
        "\"meshes\":[{{\"primitives\":[{{{SQUARES}}}]}}],\"nodes\":[{{\"mesh\":0,\"extensions\":\
         {{\"EXT_mesh_gpu_instancing\":{{\"attributes\":{{\"TRANSLATION\":{places}}}}}}}}}]"
    );
    let (bytes, files, options) = (craft.glb(&rest), Memory::new(), ReadOptions::default());
    let new = expanded(&file(&bytes, &files, &options)).unwrap().unwrap();
    for bytes in [&bytes, &new] {
        let read = gltf::read_with_origins(bytes, "trees.glb", &files, &options);
        assert_eq!(read.unwrap().0.scene.objects.len(), 1);
    }
}

#[test]
fn instances_are_limited() {
    let (bytes, files) = (instanced(), Memory::new());
    let options = ReadOptions {
        most_elements: 16,
        ..ReadOptions::default()
    };
    let error = expanded(&file(&bytes, &files, &options)).unwrap_err();
    assert!(
        error.to_string().contains("2 instances at node 0"),
        "{error}"
    );
}
