//! Files made to be difficult.

use super::super::super::container::tests::glb_of;
use super::craft::{Craft, json_of};
use super::{Case, Charts, check};
use crate::Memory;
use crate::gltf::patch::{InstanceMode, LightsMode, PatchedFile, strip};
use crate::gltf::tests::draco;
use proptest::prelude::*;

/// Checks a file with several kinds of charts, and returns what the last edit gave.
fn check_all(bytes: &[u8], name: &str, files: &Memory) -> PatchedFile {
    let case = Case { bytes, name, files };
    let mut last = None;
    for charts in [
        Charts::One,
        Charts::Random(3),
        Charts::Random(4),
        Charts::Faces,
    ] {
        last = check(&case, charts, |_| {});
        check(&case, charts, |edit| {
            edit.instances = InstanceMode::Transform;
            edit.lights = LightsMode::Remove;
        });
    }
    last.expect("a file that can be read")
}

/// Meshes of these primitives, one node each.
fn nodes_of(meshes: &[&str]) -> String {
    let nodes: Vec<String> = (0..meshes.len())
        .map(|m| format!("{{\"mesh\":{m}}}"))
        .collect();
    let meshes: Vec<String> = meshes
        .iter()
        .map(|p| format!("{{\"primitives\":[{p}]}}"))
        .collect();
    format!(
        "\"nodes\":[{}],\"meshes\":[{}]",
        nodes.join(","),
        meshes.join(",")
    )
}

fn glb_case(craft: &Craft, rest: &str) -> PatchedFile {
    check_all(&craft.glb(rest), "a.glb", &Memory::new())
}

#[test]
fn texts_that_look_like_others() {
    let mut craft = Craft::default();
    let (p, i) = (craft.positions(2), craft.triangles(2, 2));
    let odd = "\"name\":\"\\u0061\\\"],}{[\\\\\",\"extras\":{\"numbers\":[0.725,1e0,-0.0,1E+2,100000000000000000000],\
               \"text\":\"{\\\"lightmap\\\":[}\",\"\\u0065mpty\":{ }},\"extensions\":{\"EXT_unknown\":{\"a\":[ ]}}";
    let rest = format!(
        "\"materials\":[{{{odd},\"pbrMetallicRoughness\":{{\"metallicFactor\":0.0,{odd}}}}}],\
         \"m\\u0065shes\":[{{{odd},\"primitives\":[{{{odd},\"attributes\":{{\"POSITION\":{p}}},\
         \"indices\":{i},\"material\":0}}]}}],\"nodes\":[{{{odd},\"mesh\":0}}],{odd},\
         \"extensionsUsed\" : [\"EXT_unknown\" ]"
    );
    let patched = glb_case(&craft, &rest);
    let text = String::from_utf8_lossy(&patched.bytes).into_owned();
    assert_eq!(
        text.matches("[0.725,1e0,-0.0,1E+2,100000000000000000000]")
            .count(),
        6
    );
    // As text, with marks, blanks and line ends.
    let files = Memory::new().with("b c.bin", craft.bin.clone());
    for (before, after) in [("", ""), ("\u{feff}", "\r\n"), ("\n\t ", "  \n")] {
        let json = before.to_owned() + &craft.json("\"uri\":\"b%20c.bin\",", &rest) + after;
        let patched = check_all(json.as_bytes(), "a.gltf", &files);
        let names: Vec<&str> = patched.files.iter().map(|(n, _)| n.as_str()).collect();
        assert_eq!(names, ["a.lightmap-0.png", "a.lightmap.bin"]);
    }
}

#[test]
fn extras_of_any_kind() {
    let mut craft = Craft::default();
    let (p, i) = (craft.positions(2), craft.triangles(2, 2));
    let rest = nodes_of(&[&format!(
        "{{\"attributes\":{{\"POSITION\":{p}}},\"indices\":{i}}}"
    )]);
    let all = [
        "\"text\"",
        "7",
        "null",
        "[1,{\"azulejo\":2}]",
        "{}",
        "{\"azulejo\":7}",
        "{\"azulejo\":null}",
        "{\"azulejo\":{}}",
        "{\"azulejo\":{\"photometric\":true}}",
        "{\"a\":1,\"azulejo\" : [ ]}",
    ];
    for extras in all {
        let json = craft.json("", &rest);
        let json = json.replace("\"2.0\"", &format!("\"2.0\",\"extras\": {extras} "));
        let file = glb_of(&[(b"JSON", json.as_bytes()), (b"BIN\0", &craft.bin)]);
        check_all(&file, "a.glb", &Memory::new());
    }
}

#[test]
fn chunks_of_others() {
    let mut craft = Craft::default();
    let (p, i) = (craft.positions(2), craft.triangles(2, 1));
    let rest = nodes_of(&[&format!(
        "{{\"attributes\":{{\"POSITION\":{p}}},\"indices\":{i}}}"
    )]);
    let json = craft.json("", &rest);
    let json = json.as_bytes();
    let odd = [json, b"\0 \0"].concat();
    let mut files = vec![
        glb_of(&[
            (b"JSON", json),
            (b"abc\0", b"123"),
            (b"BIN\0", &craft.bin),
            (b"BIN\0", b"x"),
        ]),
        glb_of(&[(b"JSON", &odd), (b"BIN\0", &craft.bin), (b"zzzz", b"")]),
    ];
    let mut tail = files[0].clone();
    tail.extend(*b"1234567");
    tail[8] ^= 1;
    files.push(tail);
    for file in &files {
        check_all(file, "a.glb", &Memory::new());
    }
    // A primitive whose indices reach beyond the numbers must not find new ones there.
    let size = craft.bin.len();
    craft.accessors.push(format!(
        "{{\"bufferView\":{},\"componentType\":5121,\"count\":6,\"type\":\"SCALAR\"}}",
        craft.views.len()
    ));
    craft.views.push(format!(
        "{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":8}}",
        size - 4
    ));
    let far = craft.accessors.len() - 1;
    let primitive = |i: usize| format!("{{\"attributes\":{{\"POSITION\":{p}}},\"indices\":{i}}}");
    let damaged = nodes_of(&[&[primitive(i), primitive(far)].join(",")]);
    check_all(&craft.glb(&damaged), "a.glb", &Memory::new());
    // Numbers of a GLB in another file: new ones cannot be in it.
    let json = craft.json("\"uri\":\"a.bin\",", &rest);
    let files = Memory::new().with("a.bin", craft.bin.clone());
    let patched = check_all(&glb_of(&[(b"JSON", json.as_bytes())]), "a.glb", &files);
    assert!(patched.files.is_empty());
    check_all(
        &glb_of(&[(b"JSON", json.as_bytes()), (b"BIN\0", b"left")]),
        "a.glb",
        &files,
    );
}

#[test]
fn files_without_anything() {
    let least = "{\"asset\":{\"version\":\"2.0\"}}";
    check_all(least.as_bytes(), "a.gltf", &Memory::new());
    check_all(
        &glb_of(&[(b"JSON", least.as_bytes())]),
        "a.glb",
        &Memory::new(),
    );
    let bin: (&[u8; 4], &[u8]) = (b"BIN\0", b"");
    check_all(
        &glb_of(&[(b"JSON", least.as_bytes()), bin]),
        "a.glb",
        &Memory::new(),
    );
    assert!(strip(least.as_bytes(), "a.gltf").is_err());
}

#[test]
fn attributes_of_all_kinds() {
    let mut craft = Craft::default();
    let count = 6;
    let bytes = |n: usize| (0..n).map(|i| (i * 37 % 251) as u8).collect::<Vec<u8>>();
    let short: Vec<u8> = (0..count)
        .flat_map(|i: u16| [i / 2, i % 2, 0, 99].map(|v| v * 300))
        .flat_map(u16::to_le_bytes)
        .collect();
    let view = craft.view(&short, ",\"byteStride\":8");
    craft.accessors.push(format!(
        "{{\"bufferView\":{view},\"componentType\":5123,\"count\":{count},\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[600,300,0]}}"
    ));
    let p = craft.accessors.len() - 1;
    let normals: Vec<u8> = [0, 0, 127, 0].repeat(count.into());
    let n = craft.accessor(&normals, 5120, count.into(), "VEC3", ",\"normalized\":true");
    let view = craft.views.len() - 1;
    craft.views[view] = craft.views[view].replace("}", ",\"byteStride\":4}");
    let c = craft.accessor(
        &bytes(24),
        5121,
        6,
        "VEC4",
        ",\"normalized\":true,\"name\":\"c\"",
    );
    let uv = craft.accessor(&bytes(24), 5123, 6, "VEC2", ",\"normalized\":true");
    let uv1 = craft.floats(&[0.5; 12], "VEC2");
    let joints = craft.accessor(&[0; 24], 5121, 6, "VEC4", "");
    let weights = craft.floats(&[0.25; 24], "VEC4");
    let custom = craft.accessor(&bytes(6), 5121, 6, "SCALAR", "");
    let matrix = craft.accessor(&bytes(6 * 12), 5121, 6, "MAT3", "");
    let indices = craft.view(&[1, 4], "");
    let values: Vec<u8> = [9.0f32, 1.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let values = craft.view(&values, "");
    craft.accessors.push(format!(
        "{{\"componentType\":5126,\"count\":6,\"type\":\"SCALAR\",\"sparse\":{{\"count\":2,\
         \"indices\":{{\"bufferView\":{indices},\"componentType\":5121}},\"values\":{{\"bufferView\":{values}}}}}}}"
    ));
    let sparse = craft.accessors.len() - 1;
    let moves = craft.floats(&[0.5; 18], "VEC3");
    let i = craft.triangles(2, 1);
    let all = format!(
        "\"POSITION\":{p},\"NORMAL\":{n},\"COLOR_0\":{c},\"TEXCOORD_0\":{uv},\"TEXCOORD_1\":{uv1},\
         \"JOINTS_0\":{joints},\"WEIGHTS_0\":{weights},\"_CUSTOM\":{custom},\"_MATRIX\":{matrix},\"_SPARSE\":{sparse}"
    );
    let primitive = format!(
        "{{\"attributes\":{{{all}}},\"indices\":{i},\"targets\":[{{\"POSITION\":{moves}}},{{\"NORMAL\":{moves},\"POSITION\":{moves}}}]}}"
    );
    let other = format!("{{\"attributes\":{{{all}}},\"indices\":{i},\"material\":0}}");
    let rest = nodes_of(&[&primitive, &format!("{other},{other}")])
        + ",\"materials\":[{\"emissiveTexture\":{\"index\":0,\"texCoord\":1}}],\"textures\":[{}],\
           \"extensionsUsed\":[\"KHR_mesh_quantization\"],\"extensionsRequired\":[\"KHR_mesh_quantization\"]";
    let patched = glb_case(&craft, &rest);
    assert!(
        patched.notes.iter().any(|n| n.contains("TEXCOORD_2")),
        "{:?}",
        patched.notes
    );
    let json = json_of(&patched);
    let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
    let copied = |name: &str| {
        let index = attributes[name].as_u64().unwrap() as usize;
        assert!(index >= craft.accessors.len(), "{name}");
        &json["accessors"][index]
    };
    // Four triangles of which each corner is its own: 12 vertices.
    assert_eq!(copied("_CUSTOM")["count"], 12);
    assert_eq!(copied("COLOR_0")["name"], "c");
    assert_eq!(copied("NORMAL")["normalized"], true);
    assert_eq!(copied("POSITION")["max"][0], 600);
    assert!(copied("_SPARSE").get("sparse").is_none());
    assert_eq!(
        json["meshes"][0]["primitives"][0]["targets"][1]["NORMAL"],
        json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"]
    );
}

#[test]
fn indices_grow_when_they_must() {
    for (quads, size, expected) in [
        (100, 1, 5123),
        (40, 1, 5121),
        (40, 2, 5123),
        (40, 4, 5125),
        (10_922, 2, 5123),
        (10_923, 2, 5125),
    ] {
        let mut craft = Craft::default();
        let (p, i) = (craft.positions(quads), craft.triangles(quads, size));
        let rest = nodes_of(&[&format!(
            "{{\"attributes\":{{\"POSITION\":{p}}},\"indices\":{i}}}"
        )]);
        let file = craft.glb(&rest);
        let case = Case {
            bytes: &file,
            name: "a.glb",
            files: &Memory::new(),
        };
        let patched = check(&case, Charts::Faces, |_| {}).unwrap();
        let json = json_of(&patched);
        let index = json["meshes"][0]["primitives"][0]["indices"]
            .as_u64()
            .unwrap() as usize;
        assert_eq!(
            json["accessors"][index]["componentType"], expected,
            "{quads} × {size}"
        );
    }
}

#[test]
fn strips_and_fans() {
    let mut craft = Craft::default();
    let p = craft.positions(3);
    let corners = craft.accessor(&[0, 1, 2, 3, 4, 4, 5, 200], 5121, 8, "SCALAR", "");
    let strip = format!("{{\"attributes\":{{\"POSITION\":{p}}},\"indices\":{corners},\"mode\":5}}");
    let plain = format!("{{\"attributes\":{{\"POSITION\":{p}}},\"mode\":5}}");
    let fan = format!("{{\"attributes\":{{\"POSITION\":{p}}},\"mode\" : 6.0}}");
    let points = format!("{{\"attributes\":{{\"POSITION\":{p}}},\"mode\":0}}");
    let alone = format!("{{\"attributes\":{{\"POSITION\":{p}}}}}");
    let rest = nodes_of(&[
        &strip,
        &plain,
        &[&fan[..], &points, &alone].join(",").replace("6.0", "6"),
        &alone,
    ]);
    let file = craft.glb(&rest);
    let case = Case {
        bytes: &file,
        name: "a.glb",
        files: &Memory::new(),
    };
    let patched = check(&case, Charts::One, |_| {}).unwrap();
    let json = json_of(&patched);
    assert_eq!(json["meshes"][0]["primitives"][0]["mode"], 5);
    assert!(json["meshes"][3]["primitives"][0].get("indices").is_none());
    let patched = check(&case, Charts::Faces, |_| {}).unwrap();
    assert_eq!(json_of(&patched)["meshes"][0]["primitives"][0]["mode"], 4);
    check_all(&file, "a.glb", &Memory::new());
}

#[test]
fn instances_get_entries_of_their_own() {
    let mut craft = Craft::default();
    let (p, i) = (craft.positions(2), craft.triangles(2, 2));
    let primitive =
        format!("{{\"attributes\":{{\"POSITION\":{p}}},\"indices\":{i},\"material\":0}}");
    let rest = format!(
        "\"meshes\":[{{\"primitives\":[{primitive}],\"name\":\"m\"}},{{\"primitives\":[{primitive}]}}],\
         \"materials\":[{{}}],\"nodes\":[{{\"mesh\":0}},{{\"mesh\":0,\"scale\":[-1,1,1]}},\
         {{\"mesh\":0,\"rotation\":[0,0,0,1]}},{{\"children\":[4]}},{{\"mesh\":1,\"scale\":[1,-2,1]}},\
         {{\"children\":[4]}}]"
    );
    let file = craft.glb(&rest);
    let case = Case {
        bytes: &file,
        name: "a.glb",
        files: &Memory::new(),
    };
    let patched = check(&case, Charts::One, |_| {}).unwrap();
    let json = json_of(&patched);
    let mesh = |node: usize| json["nodes"][node]["mesh"].as_u64().unwrap();
    assert_eq!((0..3).map(mesh).collect::<Vec<_>>(), [0, 2, 3]);
    assert_eq!(json["meshes"][3]["name"], "m");
    let positions = |mesh: usize| &json["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"];
    assert_eq!(positions(2), positions(0));
    // The seams of all are the same, so copies share what they must copy.
    let patched = check(&case, Charts::Random(5), |_| {}).unwrap();
    let json = json_of(&patched);
    let primitive = |mesh: usize| &json["meshes"][mesh]["primitives"][0];
    assert_eq!(
        primitive(3)["attributes"]["POSITION"],
        primitive(0)["attributes"]["POSITION"]
    );
    assert_eq!(primitive(3)["indices"], primitive(0)["indices"]);
    check_all(&file, "a.glb", &Memory::new());
}

#[test]
fn compressed_primitives_are_no_longer() {
    for data in draco::BY_GOOGLE {
        let json = draco::file(&draco::bytes_of(data), 9, 24, 1, "");
        let case = Case {
            bytes: json.as_bytes(),
            name: "a.gltf",
            files: &Memory::new(),
        };
        for charts in [Charts::One, Charts::Random(2), Charts::Faces] {
            let patched = check(&case, charts, |_| {}).unwrap();
            let json = json_of(&patched);
            let primitive = &json["meshes"][0]["primitives"][0];
            assert!(primitive.get("extensions").is_none());
            assert_eq!(json["extensionsUsed"][0], "KHR_materials_specular");
            assert!(json.get("extensionsRequired").is_none());
            let positions = primitive["attributes"]["POSITION"].as_u64().unwrap() as usize;
            // The bounds are those of what was decompressed, not those that the file declares.
            assert_ne!(
                json["accessors"][positions]["min"],
                json["accessors"][0]["min"]
            );
            assert!(patched.notes.iter().any(|n| n.contains("Draco")));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Any charts over any triangles of shared vertices.
    #[test]
    fn any_layout_of_any_triangles(
        primitives in prop::collection::vec(prop::collection::vec(0u8..14, 0..40), 1..4),
        seed in any::<u64>(),
        nodes in prop::collection::vec((0usize..3, any::<bool>()), 1..5),
        mode in 4u32..7,
    ) {
        let mut craft = Craft::default();
        let positions = craft.positions(5);
        let meshes: Vec<String> = primitives.chunks(2).map(|mesh| {
            let list: Vec<String> = mesh.iter().map(|corners| {
                let i = craft.accessor(corners, 5121, corners.len(), "SCALAR", "");
                format!("{{\"attributes\":{{\"POSITION\":{positions}}},\"indices\":{i},\"mode\":{mode}}}")
            }).collect();
            format!("{{\"primitives\":[{}]}}", list.join(","))
        }).collect();
        let nodes: Vec<String> = nodes.iter().map(|(mesh, mirrored)| {
            let scale = if *mirrored { ",\"scale\":[1,-1,1]" } else { "" };
            format!("{{\"mesh\":{}{scale}}}", mesh % meshes.len())
        }).collect();
        let rest = format!("\"meshes\":[{}],\"nodes\":[{}]", meshes.join(","), nodes.join(","));
        let bytes = craft.glb(&rest);
        let case = Case { bytes: &bytes, name: "a.glb", files: &Memory::new() };
        check(&case, Charts::Random(seed), |_| {});
    }
}
