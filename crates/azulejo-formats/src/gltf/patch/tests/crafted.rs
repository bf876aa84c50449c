//! Files made to be difficult.

use super::super::super::container::tests::glb_of;
use super::craft::{Craft, SQUARES, json_of, squares, two_squares};
use super::{Case, Charts, check};
use crate::Memory;
use crate::gltf::patch::{InstanceMode, LightsMode, PatchedFile, strip};
use crate::gltf::tests::draco;
use proptest::prelude::*;
use serde_json::Value;

/// Checks a file with several kinds of charts, and returns what the last edit gave.
fn check_all(bytes: &[u8], name: &str, files: &Memory) -> PatchedFile {
    let case = Case { bytes, name, files };
    let all = [
        Charts::One,
        Charts::Random(3),
        Charts::Random(4),
        Charts::Faces,
    ];
    let edited = all.map(|charts| {
        check(&case, charts, |edit| {
            edit.instances = InstanceMode::Transform;
            edit.lights = LightsMode::Remove;
        });
        check(&case, charts, |_| {})
    });
    let [.., last] = edited;
    last.expect("a file that can be read")
}

/// The JSON of a file that is edited once.
fn json_with(bytes: &[u8], charts: Charts) -> Value {
    let (name, files) = ("a.glb", &Memory::new());
    json_of(&check(&Case { bytes, name, files }, charts, |_| {}).unwrap())
}

/// Meshes of these primitives, one node each.
fn nodes_of(meshes: &[&str]) -> String {
    let list = |entry: &dyn Fn(usize) -> String| {
        let entries: Vec<String> = (0..meshes.len()).map(entry).collect();
        entries.join(",")
    };
    let nodes = list(&|m| format!("{{\"mesh\":{m}}}"));
    let meshes = list(&|m| format!("{{\"primitives\":[{}]}}", meshes[m]));
    format!("\"nodes\":[{nodes}],\"meshes\":[{meshes}]")
}

#[test]
fn texts_that_look_like_others() {
    let odd = r#""name":"\u0061\"],}{[\\","extras":{"numbers":[0.725,1e0,-0.0,1E+2,100000000000000000000],"text":"{\"lightmap\":[}","\u0065mpty":{ }},"extensions":{"EXT_unknown":{"a":[ ]}}"#;
    let rest = r#""materials":[{ODD,"pbrMetallicRoughness":{"metallicFactor":0.0,ODD}}],"m\u0065shes":[{ODD,"primitives":[{ODD,@,"material":0}]}],"nodes":[{ODD,"mesh":0}],ODD,"extensionsUsed" : ["EXT_unknown" ]"#;
    let rest = rest.replace("ODD", odd);
    let patched = check_all(&squares(&rest), "a.glb", &Memory::new());
    let text = String::from_utf8_lossy(&patched.bytes);
    let numbers = "[0.725,1e0,-0.0,1E+2,100000000000000000000]";
    assert_eq!(text.matches(numbers).count(), 6);
    assert!(text.contains("\"m\\u0065shes\":[{\"name\":\"\\u0061"));
    // As text, with marks, blanks and line ends.
    let craft = two_squares();
    let files = Memory::new().with("b c.bin", craft.bin.clone());
    let rest = rest.replace('@', SQUARES);
    for (before, after) in [("", ""), ("\u{feff}", "\r\n"), ("\n\t ", "  \n")] {
        let json = before.to_owned() + &craft.json("\"uri\":\"b%20c.bin\",", &rest) + after;
        let patched = check_all(json.as_bytes(), "a.gltf", &files);
        let names: Vec<&str> = patched.files.iter().map(|(n, _)| n.as_str()).collect();
        assert_eq!(names, ["a.lightmap-0.png", "a.lightmap.bin"]);
    }
}

#[test]
fn extras_of_any_kind() {
    let craft = two_squares();
    let json = craft.json("", &nodes_of(&[&format!("{{{SQUARES}}}")]));
    for extras in [
        r#""text""#,
        "7",
        "null",
        r#"[1,{"azulejo":2}]"#,
        "{}",
        r#"{"azulejo":7}"#,
        r#"{"azulejo":null}"#,
        r#"{"azulejo":{}}"#,
        r#"{"azulejo":{"photometric":true}}"#,
        r#"{"a":1,"azulejo" : [ ]}"#,
    ] {
        let json = json.replace("\"2.0\"", &format!("\"2.0\",\"extras\": {extras} "));
        let file = glb_of(&[(b"JSON", json.as_bytes()), (b"BIN\0", &craft.bin)]);
        check_all(&file, "a.glb", &Memory::new());
    }
}

#[test]
fn chunks_of_others() {
    let mut craft = Craft::default();
    let (p, i) = (craft.positions(2), craft.triangles(2, 1));
    let primitive = |i: usize| format!("{{\"attributes\":{{\"POSITION\":{p}}},\"indices\":{i}}}");
    let rest = nodes_of(&[&primitive(i)]);
    let json = craft.json("", &rest);
    let odd = [json.as_bytes(), b"\0 \0"].concat();
    let bin: (&[u8; 4], &[u8]) = (b"BIN\0", &craft.bin);
    let mut first = glb_of(&[
        (b"JSON", json.as_bytes()),
        (b"abc\0", b"123"),
        bin,
        (b"BIN\0", b"x"),
    ]);
    check_all(&first, "a.glb", &Memory::new());
    first.extend(*b"1234567");
    first[8] ^= 1;
    check_all(&first, "a.glb", &Memory::new());
    let second = glb_of(&[(b"JSON", &odd), bin, (b"zzzz", b"")]);
    check_all(&second, "a.glb", &Memory::new());
    // Numbers of a GLB in another file: new ones cannot be in it.
    let json = craft.json("\"uri\":\"a.bin\",", &rest);
    let files = Memory::new().with("a.bin", craft.bin.clone());
    let json: (&[u8; 4], &[u8]) = (b"JSON", json.as_bytes());
    assert!(
        check_all(&glb_of(&[json]), "a.glb", &files)
            .files
            .is_empty()
    );
    check_all(&glb_of(&[json, (b"BIN\0", b"left")]), "a.glb", &files);
    // A primitive whose indices reach beyond the numbers must not find new ones there.
    let (view, start) = (craft.views.len(), craft.bin.len() - 4);
    let far =
        format!("{{\"bufferView\":{view},\"componentType\":5121,\"count\":6,\"type\":\"SCALAR\"}}");
    craft.accessors.push(far);
    let view = format!("{{\"buffer\":0,\"byteOffset\":{start},\"byteLength\":8}}");
    craft.views.push(view);
    let damaged = nodes_of(&[&[primitive(i), primitive(2)].join(",")]);
    check_all(&craft.glb(&damaged), "a.glb", &Memory::new());
}

#[test]
fn files_without_anything() {
    let least = b"{\"asset\":{\"version\":\"2.0\"}}";
    check_all(least, "a.gltf", &Memory::new());
    let chunks: [(&[u8; 4], &[u8]); 2] = [(b"JSON", least), (b"BIN\0", b"")];
    check_all(&glb_of(&chunks[..1]), "a.glb", &Memory::new());
    check_all(&glb_of(&chunks), "a.glb", &Memory::new());
    assert!(strip(least, "a.gltf").is_err());
}

#[test]
fn attributes_of_all_kinds() {
    let mut craft = Craft::default();
    let bytes = |n: usize| (0..n).map(|i| (i * 37 % 251) as u8).collect::<Vec<u8>>();
    let short = (0..6u16).flat_map(|i| [i / 2, i % 2, 0, 99].map(|v| v * 300));
    let short: Vec<u8> = short.flat_map(u16::to_le_bytes).collect();
    let view = craft.view(&short, ",\"byteStride\":8");
    craft.accessors.push(format!(
        "{{\"bufferView\":{view},\"componentType\":5123,\"count\":6,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[600,300,0]}}"
    ));
    let normalized = ",\"normalized\":true,\"name\":\"c\"";
    let n = craft.accessor(&[0, 0, 127, 0].repeat(6), 5120, 6, "VEC3", normalized);
    let view = craft.views.len() - 1;
    craft.views[view] = craft.views[view].replace("}", ",\"byteStride\":4}");
    let c = craft.accessor(&bytes(24), 5121, 6, "VEC4", normalized);
    let uv = craft.accessor(&bytes(24), 5123, 6, "VEC2", normalized);
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
        "\"attributes\":{{\"POSITION\":0,\"NORMAL\":{n},\"COLOR_0\":{c},\"TEXCOORD_0\":{uv},\"TEXCOORD_1\":{uv1},\
         \"JOINTS_0\":{joints},\"WEIGHTS_0\":{weights},\"_CUSTOM\":{custom},\"_MATRIX\":{matrix},\"_SPARSE\":{sparse}}},\
         \"indices\":{i}"
    );
    let primitive = format!(
        "{{{all},\"targets\":[{{\"POSITION\":{moves}}},{{\"NORMAL\":{moves},\"POSITION\":{moves}}}]}}"
    );
    let other = format!("{{{all},\"material\":0}}");
    let rest = nodes_of(&[&primitive, &format!("{other},{other}")])
        + r#","materials":[{"emissiveTexture":{"index":0,"texCoord":1}}],"textures":[{}],"extensionsUsed":["KHR_mesh_quantization"],"extensionsRequired":["KHR_mesh_quantization"]"#;
    let patched = check_all(&craft.glb(&rest), "a.glb", &Memory::new());
    let notes = &patched.notes;
    assert!(notes.iter().any(|n| n.contains("TEXCOORD_2")), "{notes:?}");
    let json = json_of(&patched);
    let primitive = &json["meshes"][0]["primitives"][0];
    let copied = |name: &str| {
        let index = primitive["attributes"][name].as_u64().unwrap() as usize;
        assert!(index >= craft.accessors.len(), "{name}");
        &json["accessors"][index]
    };
    // Four triangles of which each corner is its own: 12 vertices.
    assert_eq!(copied("_CUSTOM")["count"], 12);
    assert_eq!(copied("COLOR_0")["name"], "c");
    assert_eq!(copied("NORMAL")["normalized"], true);
    assert_eq!(copied("POSITION")["max"][0], 600);
    assert!(copied("_SPARSE").get("sparse").is_none());
    let targets = &primitive["targets"];
    assert_eq!(targets[1]["NORMAL"], targets[0]["POSITION"]);
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
        craft.positions(quads);
        craft.triangles(quads, size);
        let rest = nodes_of(&[&format!("{{{SQUARES}}}")]);
        let json = json_with(&craft.glb(&rest), Charts::Faces);
        let index = json["meshes"][0]["primitives"][0]["indices"].as_u64();
        let accessor = &json["accessors"][index.unwrap() as usize];
        assert_eq!(accessor["componentType"], expected, "{quads} × {size}");
    }
}

#[test]
fn strips_and_fans() {
    let mut craft = Craft::default();
    craft.positions(3);
    craft.accessor(&[0, 1, 2, 3, 4, 4, 5, 200], 5121, 8, "SCALAR", "");
    let primitive = |more: &str| format!("{{\"attributes\":{{\"POSITION\":0}}{more}}}");
    let fan_and_points = [r#","mode" : 6"#, r#","mode":0"#, ""]
        .map(primitive)
        .join(",");
    let file = craft.glb(&nodes_of(&[
        &primitive(r#","indices":1,"mode":5"#),
        &primitive(r#","mode":5"#),
        &fan_and_points,
        &primitive(""),
    ]));
    let json = json_with(&file, Charts::One);
    assert_eq!(json["meshes"][0]["primitives"][0]["mode"], 5);
    assert!(json["meshes"][3]["primitives"][0].get("indices").is_none());
    let json = json_with(&file, Charts::Faces);
    assert_eq!(json["meshes"][0]["primitives"][0]["mode"], 4);
    check_all(&file, "a.glb", &Memory::new());
}

#[test]
fn instances_get_entries_of_their_own() {
    let file = squares(
        r#""meshes":[{"primitives":[{@,"material":0}],"name":"m"},{"primitives":[{@,"material":0}]}],"materials":[{}],
        "nodes":[{"mesh":0},{"mesh":0,"scale":[-1,1,1]},{"mesh":0,"rotation":[0,0,0,1]},{"children":[4]},
        {"mesh":1,"scale":[1,-2,1]},{"children":[4]}]"#,
    );
    let json = json_with(&file, Charts::One);
    let mesh = |node: usize| json["nodes"][node]["mesh"].as_u64().unwrap();
    assert_eq!([0, 1, 2].map(mesh), [0, 2, 3]);
    assert_eq!(json["meshes"][3]["name"], "m");
    let positions = |mesh: usize| &json["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"];
    assert_eq!(positions(2), positions(0));
    // The seams of all are the same, so copies share what they must copy.
    let json = json_with(&file, Charts::Random(5));
    let primitive = |mesh: usize| &json["meshes"][mesh]["primitives"][0];
    let positions = |mesh: usize| &primitive(mesh)["attributes"]["POSITION"];
    assert_eq!(positions(3), positions(0));
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
            assert!(patched.notes.iter().any(|n| n.contains("Draco")));
            let json = json_of(&patched);
            let primitive = &json["meshes"][0]["primitives"][0];
            assert!(primitive.get("extensions").is_none());
            assert_eq!(json["extensionsUsed"][0], "KHR_materials_specular");
            assert!(json.get("extensionsRequired").is_none());
            // The bounds are those of what was decompressed, not those that the file declares.
            let positions = primitive["attributes"]["POSITION"].as_u64().unwrap() as usize;
            let accessors = &json["accessors"];
            assert_ne!(accessors[positions]["min"], accessors[0]["min"]);
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
