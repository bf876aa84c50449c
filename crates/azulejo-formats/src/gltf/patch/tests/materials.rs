//! Materials, lights, conventions and instances of edited files.

use super::super::super::container::tests::glb_of;
use super::super::convert::Overlay;
use super::super::glb::Parts;
use super::craft::{SQUARES, json_of, squares, two_squares};
use super::kept::{self, check_same};
use super::{Case, Charts, check, layouts, pages, usual};
use crate::gltf::patch::{
    Container, Convention, GltfFile, InstanceMode, LightmapEdit, LightmapUvs, LightsMode,
    MediaType, ObjectLayout, PatchError, PatchedFile, strip, with_lightmap,
};
use crate::gltf::read_with_origins;
use crate::{Memory, ReadOptions};
use serde_json::{Value, json};

/// A file of primitives with these materials, each a mesh, and what follows; the nodes of the meshes come in the
/// order of `nodes`.
fn file(materials: &[Option<usize>], nodes: &[usize], list: &str, more: &str) -> Vec<u8> {
    let mesh = |material: &Option<usize>| match material {
        Some(m) => format!("{{\"primitives\":[{{@,\"material\":{m}}}]}}"),
        None => "{\"primitives\":[{@}]}".to_owned(),
    };
    let meshes: Vec<String> = materials.iter().map(mesh).collect();
    let nodes: Vec<String> = nodes.iter().map(|m| format!("{{\"mesh\":{m}}}")).collect();
    let (meshes, nodes) = (meshes.join(","), nodes.join(","));
    squares(&format!(
        "\"meshes\":[{meshes}],\"nodes\":[{nodes}],\"materials\":[{list}]{more}"
    ))
}

/// Edits a file whose objects have these pages, `None` for those that receive nothing.
fn edit(
    bytes: &[u8],
    on: &[Option<u32>],
    change: impl Fn(&mut LightmapEdit),
) -> Result<PatchedFile, PatchError> {
    let options = ReadOptions::default();
    let files = Memory::new();
    let (loaded, origins) = read_with_origins(bytes, "a.glb", &files, &options).unwrap();
    let pages = pages(2);
    let mut objects = layouts(&loaded.scene, &origins, Charts::Random(1), 1);
    for (layout, page) in objects.iter_mut().zip(on) {
        match page {
            None => *layout = None,
            Some(page) => layout.as_mut().unwrap().pages.fill(*page),
        }
    }
    let mut edit = usual(&objects, &pages);
    change(&mut edit);
    let file = GltfFile {
        bytes,
        name: "a.glb",
        files: &files,
        options: &options,
    };
    let patched = with_lightmap(&file, &origins, &edit)?;
    let stripped = strip(&patched.bytes, "a.glb").unwrap();
    assert!(stripped.is_exact);
    check_same("a.glb", bytes, &stripped.bytes);
    Ok(patched)
}

/// The JSON of a file that is edited in this way.
fn edited(bytes: &[u8], on: &[Option<u32>], change: impl Fn(&mut LightmapEdit)) -> Value {
    json_of(&edit(bytes, on, change).unwrap())
}

fn material_of(json: &Value, mesh: usize) -> u64 {
    let material = &json["meshes"][mesh]["primitives"][0]["material"];
    material.as_u64().unwrap()
}

fn lightmap(json: &Value, material: u64) -> &Value {
    &json["materials"][material as usize]["extensions"]["MOZ_lightmap"]
}

const PICTURE: &str = r#","textures":[{"source":0}],"images":[{"uri":"a.png"}]"#;

/// Lightmaps of other programs go where they would show beside the new one, and come back ([`edit`] strips).
#[test]
fn lightmaps_of_others_are_replaced() {
    let old = r#"{"name":"a","extensions":{"MOZ_lightmap":{ "index" : 0, "intensity": 3.50 } }}"#;
    let bytes = file(&[Some(0), Some(0)], &[0, 1], old, PICTURE);
    let both = [Some(0), Some(0)];
    let replaced = edited(&bytes, &both, |_| {});
    let expected = json!({ "index": 1, "texCoord": 1, "intensity": 12.5 });
    assert_eq!(lightmap(&replaced, 0), &expected);
    // What receives nothing keeps its own.
    let kept = edited(&bytes, &[Some(0), None], |_| {});
    let intensities = [0, 1].map(|m| &lightmap(&kept, m)["intensity"]);
    assert_eq!(intensities, [&json!(3.5), &json!(12.5)]);
    let to_mx = |edit: &mut LightmapEdit| edit.convention = Convention::Mx;
    let of_nodes = edit(&bytes, &both, to_mx).unwrap();
    assert!(lightmap(&json_of(&of_nodes), 0).is_null());
    assert!(of_nodes.notes.iter().any(|n| n.contains("loses it")));
    // The other way round.
    let of_nodes = r#""meshes":[{"primitives":[{@}]}],"nodes":[{"mesh":0,"extensions":{"MX_lightmap":{"index":0}}}]"#;
    let again = edited(
        &squares(&(of_nodes.to_owned() + PICTURE)),
        &[Some(0)],
        |_| {},
    );
    assert!(again["nodes"][0]["extensions"]["MX_lightmap"].is_null());
}

#[test]
fn materials_stay_shared_where_their_users_agree() {
    let two = r#"{"name":"a"},{"name":"b","extensions":{"KHR_materials_unlit":{}}}"#;
    let bytes = file(&[Some(0), Some(0), Some(1), None], &[0, 1, 2, 3], two, "");
    let json = edited(&bytes, &[Some(0); 4], |_| {});
    assert_eq!([0, 1, 2, 3].map(|m| material_of(&json, m)), [0, 0, 1, 2]);
    let same = json!({ "index": 0, "texCoord": 1, "intensity": 12.5 });
    assert_eq!(lightmap(&json, 0), &same);
    let unlit = lightmap(&json, 1)["intensity"].as_f64().unwrap();
    assert!((unlit - 12.5 / std::f64::consts::PI).abs() < 1e-12);
    let used = json!(["KHR_materials_specular", "MOZ_lightmap"]);
    assert_eq!(json["extensionsUsed"], used);
    let clamped = json!([{ "magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071 }]);
    assert_eq!(json["samplers"], clamped);
    // Two pages: the first in place, a copy for the other.
    let json = edited(&bytes, &[Some(0), Some(1), Some(1), Some(1)], |_| {});
    assert_eq!([0, 1, 2].map(|m| material_of(&json, m)), [0, 3, 1]);
    assert_eq!(json["materials"][3]["name"], "a");
    let textures = [0, 3].map(|m| lightmap(&json, m)["index"].as_u64());
    assert_eq!(textures, [Some(0), Some(1)]);
    // One user without light: the material stays as it is.
    let json = edited(&bytes, &[None, Some(0), None, Some(0)], |_| {});
    assert_eq!(lightmap(&json, 0), &Value::Null);
    assert_eq!([0, 1, 2].map(|m| material_of(&json, m)), [0, 3, 1]);
    assert_eq!(lightmap(&json, 3), &same);
}

#[test]
fn occlusion_goes_to_materials_that_have_none() {
    let two = r#"{"name":"a"},{"occlusionTexture":{"index":0}}"#;
    let bytes = file(&[Some(0), Some(1)], &[0, 1], two, PICTURE);
    let to_occlusion = |e: &mut LightmapEdit| e.convention = Convention::Occlusion;
    let patched = edit(&bytes, &[Some(0); 2], to_occlusion).unwrap();
    let json = json_of(&patched);
    let occlusions = [0, 1].map(|m| &json["materials"][m]["occlusionTexture"]);
    assert_eq!(occlusions[0], &json!({ "index": 1, "texCoord": 1 }));
    assert_eq!(occlusions[1], &json!({ "index": 0 }));
    assert!(patched.notes.iter().any(|n| n.contains("keeps it")));
    assert_eq!(lightmap(&json, 0), &Value::Null);
}

#[test]
fn meshes_of_nodes_without_light_stay() {
    let bytes = file(&[Some(0)], &[0, 0, 0], "{}", "");
    let json = edited(&bytes, &[None, Some(0), Some(0)], |_| {});
    let mesh = |node: usize| json["nodes"][node]["mesh"].as_u64().unwrap();
    assert_eq!([0, 1, 2].map(mesh), [0, 1, 2]);
    let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
    assert_eq!(attributes, &json!({ "POSITION": 0 }));
    assert_eq!(material_of(&json, 1), material_of(&json, 2));
    assert_eq!(lightmap(&json, 0), &Value::Null);
}

#[test]
fn variants_get_it_too() {
    let bytes = squares(
        r#""meshes":[{"primitives":[{@,"material":0,"extensions":{"KHR_materials_variants":{"mappings":[{"material":1,"variants":[0]},{"material":2,"variants":[1]}]}}}]},
        {"primitives":[{@,"material":1}]}],"nodes":[{"mesh":0},{"mesh":1}],"materials":[{},{},{}],"extensionsUsed":["KHR_materials_variants"]"#,
    );
    let json = edited(&bytes, &[Some(0), None], |_| {});
    let primitive = &json["meshes"][0]["primitives"][0];
    let mappings = &primitive["extensions"]["KHR_materials_variants"]["mappings"];
    assert_eq!(primitive["material"], 0);
    let expected = json!([{ "material": 3, "variants": [0] }, { "material": 2, "variants": [1] }]);
    assert_eq!(mappings, &expected);
    assert!([0, 2, 3].iter().all(|m| lightmap(&json, *m).is_object()));
}

const LIGHTS: &str = r#","extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":1e2},{"type":"point"},{"type":"point","intensity":0.0}]}},"extensionsUsed":["KHR_lights_punctual"]"#;

#[test]
fn lights_do_not_shine_twice() {
    let bytes = file(&[Some(0)], &[0], "{}", LIGHTS);
    let intensities = |json: &Value| {
        let list = &json["extensions"]["KHR_lights_punctual"]["lights"];
        [0, 1, 2].map(|i| list[i]["intensity"].as_f64())
    };
    let dimmed = edited(&bytes, &[Some(0)], |_| {});
    assert_eq!(intensities(&dimmed), [Some(0.0); 3]);
    let baked = &dimmed["asset"]["extras"]["azulejo"]["lightmap"]["baked"];
    assert_eq!(baked, &json!([[0, 100.0], [1, null]]));
    let kept = edited(&bytes, &[Some(0)], |e| e.lights = LightsMode::Keep);
    assert_eq!(intensities(&kept), [Some(100.0), None, Some(0.0)]);
    let plain = edited(&bytes, &[Some(0)], |e| e.convention = Convention::Plain);
    assert_eq!(intensities(&plain), [Some(100.0), None, Some(0.0)]);
    assert!(plain.get("textures").is_none());
}

#[test]
fn another_program_in_between() {
    let bytes = file(&[Some(0), None], &[0, 1], "{\"name\":\"a\"}", LIGHTS);
    let patched = edit(&bytes, &[Some(0); 2], |_| {}).unwrap();
    // Blanks are not changes, another order is one.
    let parts = Parts::of(&patched.bytes, "a").unwrap();
    let text = parts.text.replace(",\"", " ,\n\"");
    let bin: (&[u8; 4], &[u8]) = (b"BIN\0", parts.bin().unwrap());
    let spaced = glb_of(&[(b"JSON", text.as_bytes()), bin]);
    let stripped = strip(&spaced, "a.glb").unwrap();
    check_same("a.glb", &bytes, &stripped.bytes);
    assert!(stripped.is_exact);
    let cut = glb_of(&[(b"JSON", text.as_bytes()), (b"BIN\0", b"")]);
    assert!(!strip(&cut, "a.glb").unwrap().is_exact);
    let text = json_of(&patched).to_string();
    let stripped = strip(text.as_bytes(), "a.gltf").unwrap();
    assert!(!stripped.is_exact && stripped.notes[0].contains("another program"));
    let json: Value = serde_json::from_slice(&stripped.bytes).unwrap();
    assert_eq!(json["asset"], json!({ "version": "2.0" }));
    assert_eq!(json["materials"][0], json!({ "name": "a" }));
    let list = &json["extensions"]["KHR_lights_punctual"]["lights"];
    let expected = json!([{ "type": "point", "intensity": 100.0 }, { "type": "point" }]);
    assert_eq!((&list[0], &list[1]), (&expected[0], &expected[1]));
    let used = json!(["KHR_lights_punctual", "KHR_materials_specular"]);
    assert_eq!(json["extensionsUsed"], used);
    assert!(strip(&stripped.bytes, "a.gltf").is_err());
}

/// Marks that say nothing sensible, and those of earlier versions.
#[test]
fn marks_of_others() {
    let check = |mark: &str, intensities: &str, note: &str| {
        let text = r#"{"asset":{"version":"2.0","extras":{"azulejo":{"lightmap":MARK}}},"extensions":{"KHR_lights_punctual":{"lights":[{"intensity":0},{"intensity":0}]}}}"#;
        let stripped = strip(text.replace("MARK", mark).as_bytes(), "a.gltf").unwrap();
        assert!(stripped.notes[0].contains(note), "{:?}", stripped.notes);
        let json: Value = serde_json::from_slice(&stripped.bytes).unwrap();
        assert_eq!(json["asset"], json!({ "version": "2.0" }));
        let lights = &json["extensions"]["KHR_lights_punctual"]["lights"];
        assert_eq!(lights.to_string(), intensities);
    };
    let (dark, other) = (r#"[{"intensity":0},{"intensity":0}]"#, "another program");
    check("{}", dark, other);
    check("7", dark, other);
    check(r#"{"before":{"asset":[]},"hash":""}"#, dark, other);
    let odd = r#"{"baked":[[9,1],[1,"x"],7]}"#;
    check(odd, r#"[{"intensity":0},{}]"#, other);
    let old = r#"{"undo":[1,2,""],"hash":"0","baked":[[0,"1e2"],[1,null]]}"#;
    check(
        old,
        r#"[{"intensity":100.0},{}]"#,
        "an earlier version of azulejo",
    );
}

#[test]
fn surfaces_that_seem_lit() {
    let list = r#"{"name":"a","pbrMetallicRoughness":{"baseColorFactor":[0.5,0.5,0.5,0.25],"metallicFactor":0,"baseColorTexture":{"index":0}}},
        {"emissiveFactor":[0,1,0]},{"pbrMetallicRoughness":{"roughnessFactor":0.5}},
        {"pbrMetallicRoughness":{"metallicFactor":0},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}}"#;
    let bytes = file(&[0, 1, 2, 3].map(Some), &[0, 1, 2, 3], list, PICTURE);
    let before: Value = serde_json::from_str(&format!("[{list}]")).unwrap();
    let as_if = |convention| edited(&bytes, &[Some(0); 4], |e| e.convention = convention);
    let json = as_if(Convention::Emissive);
    let material = &json["materials"][0];
    let surface = &material["pbrMetallicRoughness"];
    assert_eq!(surface["baseColorFactor"], json!([0, 0, 0, 0.25]));
    assert!(surface.get("baseColorTexture").is_none());
    let texture = json!({ "index": 1, "texCoord": 1 });
    assert_eq!(material["emissiveTexture"], texture);
    let strength = &material["extensions"]["KHR_materials_emissive_strength"];
    assert_eq!(strength["emissiveStrength"], 12.5);
    for other in 1..4 {
        assert_eq!(json["materials"][other], before[other], "{other}");
    }
    let json = as_if(Convention::Unlit);
    let material = &json["materials"][0];
    let colour = &material["pbrMetallicRoughness"]["baseColorFactor"];
    assert_eq!(colour, &json!([1.0, 1.0, 1.0, 0.25]));
    assert!(material["extensions"]["KHR_materials_unlit"].is_object());
}

/// Colours of vertices are in the picture of unlit surfaces; what stays as it is keeps them.
#[test]
fn colours_of_unlit_surfaces() {
    let mut craft = two_squares();
    craft.accessor(&[100; 24], 5121, 6, "VEC4", ",\"normalized\":true");
    let bytes = craft.glb(
        r#""meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":2},"indices":1,"material":0}]},
        {"primitives":[{"attributes":{"POSITION":0,"COLOR_0":2},"indices":1,"material":1}]}],"nodes":[{"mesh":0},{"mesh":1}],
        "materials":[{"pbrMetallicRoughness":{"metallicFactor":0}},{"name":"metal"}]"#,
    );
    let unlit = edit(&bytes, &[Some(0); 2], |e| e.convention = Convention::Unlit).unwrap();
    let json = json_of(&unlit);
    let attributes = |mesh: usize| &json["meshes"][mesh]["primitives"][0]["attributes"];
    let has_colours = [0, 1].map(|mesh| attributes(mesh)["COLOR_0"].is_u64());
    assert_eq!(has_colours, [false, true]);
    assert!(unlit.notes.iter().any(|n| n.contains("metal: stays")));
}

#[test]
fn pictures_of_other_types() {
    let bytes = file(&[Some(0)], &[0], "{}", "");
    let mut other = pages(1);
    (other[0].media_type, other[0].fallback) = (MediaType::Ktx2, Some(b"png".to_vec()));
    let with = |pages: &'static [_]| edited(&bytes, &[Some(0)], |e| e.pages = pages);
    let json = with(other.clone().leak());
    let texture = &json["textures"][0];
    assert_eq!(texture["source"], 1);
    assert_eq!(texture["extensions"]["KHR_texture_basisu"]["source"], 0);
    assert_eq!(json["images"][0]["mimeType"], "image/ktx2");
    (other[0].media_type, other[0].fallback) = (MediaType::Hdr, None);
    let texture = &with(other.leak())["textures"][0];
    assert_eq!(texture["extensions"]["MOZ_texture_rgbe"]["source"], 0);
    assert!(texture.get("source").is_none());
}

#[test]
fn instances_that_are_moved() {
    let bytes = file(&[Some(0)], &[0, 0, 0], "{}", "");
    let options = ReadOptions::default();
    let files = Memory::new();
    let (loaded, origins) = read_with_origins(&bytes, "a.glb", &files, &options).unwrap();
    let mut objects = layouts(&loaded.scene, &origins, Charts::Random(1), 1);
    let first = objects[0].clone().unwrap();
    let moved = |[u, v]: [f32; 2]| [0.25 + 0.5 * u, 0.5 - 0.25 * v];
    objects[1] = Some(ObjectLayout {
        uvs: first.uvs.iter().map(|c| c.map(moved)).collect(),
        pages: vec![1; first.pages.len()],
    });
    let pages = pages(2);
    let file = GltfFile {
        bytes: &bytes,
        name: "a.glb",
        files: &files,
        options: &options,
    };
    let mut change = usual(&objects, &pages);
    change.instances = InstanceMode::Transform;
    let patched = with_lightmap(&file, &origins, &change).unwrap();
    let json = json_of(&patched);
    let near = |value: &Value, expected: [f64; 2]| {
        let pair = [0, 1].map(|k| value[k].as_f64().unwrap());
        assert!(
            pair.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5),
            "{value}"
        );
    };
    let attributes = |mesh: usize| &json["meshes"][mesh]["primitives"][0]["attributes"];
    assert_eq!(attributes(1), attributes(0));
    assert_ne!(attributes(2)["TEXCOORD_1"], attributes(0)["TEXCOORD_1"]);
    let info = lightmap(&json, material_of(&json, 1));
    let placement = &info["extensions"]["KHR_texture_transform"];
    near(&placement["offset"], [0.25, 0.5]);
    near(&placement["scale"], [0.5, -0.25]);
    assert_eq!(info["index"], 1);
    assert_eq!(json["extensionsRequired"], json!(["KHR_texture_transform"]));
    check_same(
        "a.glb",
        &bytes,
        &strip(&patched.bytes, "a.glb").unwrap().bytes,
    );
    // At the node, with one mesh for both.
    change.instances = InstanceMode::Node;
    assert!(with_lightmap(&file, &origins, &change).is_err());
    change.convention = Convention::Mx;
    let patched = with_lightmap(&file, &origins, &change).unwrap();
    let json = json_of(&patched);
    assert_eq!(json["nodes"][1]["mesh"], 0);
    assert_eq!(json["nodes"][2]["mesh"], 1);
    let extension = &json["nodes"][1]["extensions"]["MX_lightmap"];
    near(&extension["offset"], [0.25, 0.5]);
    assert_eq!(
        extension["lightMapTexture"],
        json!({ "index": 1, "texCoord": 1 })
    );
    assert_eq!(
        json["nodes"][0]["extensions"]["MX_lightmap"]["scale"],
        json!([1.0, 1.0])
    );
    assert_eq!(json["materials"], json!([{}]));
    check_same(
        "a.glb",
        &bytes,
        &strip(&patched.bytes, "a.glb").unwrap().bytes,
    );
}

#[test]
fn other_containers() {
    let rest = r#""meshes":[{"primitives":[{@,"material":0}]}],"nodes":[{"mesh":0}],"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
        "textures":[{"source":0}],"images":[{"uri":"a%20b.png"},{"uri":"c.png"}]"#;
    let (craft, rest) = (two_squares(), rest.replace('@', SQUARES));
    let options = ReadOptions::default();
    let files = Memory::new()
        .with("a b.png", b"\x89PNG?".to_vec())
        .with("b.bin", craft.bin.clone());
    let json = craft.json("\"uri\":\"b.bin\",", &rest).into_bytes();
    for (bytes, container) in [(craft.glb(&rest), Container::Json), (json, Container::Glb)] {
        let (loaded, origins) = read_with_origins(&bytes, "a", &files, &options).unwrap();
        let objects = layouts(&loaded.scene, &origins, Charts::Faces, 1);
        let pages = pages(1);
        let mut edit = usual(&objects, &pages);
        edit.output.container = container;
        let file = GltfFile {
            bytes: &bytes,
            name: "a",
            files: &files,
            options: &options,
        };
        let patched = with_lightmap(&file, &origins, &edit).unwrap();
        let all = Overlay {
            old: &files,
            new: &patched.files,
        };
        let (again, new_origins) = read_with_origins(&patched.bytes, "a", &all, &options).unwrap();
        kept::check_scene(&loaded.scene, &again.scene);
        let file = GltfFile {
            bytes: &patched.bytes,
            files: &all,
            ..file
        };
        kept::check_coordinates(&file, &new_origins, &objects);
        let names: Vec<&str> = patched.files.iter().map(|(n, _)| n.as_str()).collect();
        let text = json_of(&patched);
        if container == Container::Glb {
            assert!(patched.bytes.starts_with(b"glTF") && names.is_empty());
            assert_eq!(text["images"][0]["mimeType"], "image/png");
            assert_eq!(text["images"][1]["uri"], "c.png");
        } else {
            assert_eq!(names, ["a.bin", "a.lightmap-0.png", "a.lightmap.bin"]);
        }
        // What remains is the file in that container.
        let stripped = strip(&patched.bytes, "a").unwrap();
        let (plain, _) = read_with_origins(&stripped.bytes, "a", &all, &options).unwrap();
        kept::check_scene(&loaded.scene, &plain.scene);
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let bytes = file(&[Some(0)], &[0], "{}", "");
    let refused = |change: &dyn Fn(&mut LightmapEdit), part: &str| {
        let error = edit(&bytes, &[Some(0)], change).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    refused(&|e| e.objects = &[], "0 layouts for 1 objects");
    refused(
        &|e| e.objects = Box::leak(Box::new([Some(ObjectLayout::default())])),
        "of 0 and pages of 0",
    );
    refused(&|e| e.pages = &[], "page 0 of 0");
    refused(
        &|e| e.uvs = LightmapUvs::Added(9),
        "no set of texture coordinates",
    );
    let far = |uv: f32, page: u32| {
        let mut pages = vec![0; 4];
        pages[3] = page;
        let layout = ObjectLayout {
            uvs: vec![[[uv; 2]; 3]; 4],
            pages,
        };
        Box::leak(Box::new([Some(layout)]))
    };
    refused(&|e| e.objects = far(f32::NAN, 0), "not finite");
    refused(&|e| e.objects = far(0.0, 1), "several pages");
    let mut odd = pages(1);
    odd[0].intensity = f64::NAN;
    let odd: &'static [_] = Box::leak(odd.into());
    refused(&|e| e.pages = odd, "intensity");
    let few = ReadOptions {
        most_unpacked: 100,
        ..ReadOptions::default()
    };
    let (loaded, origins) = read_with_origins(&bytes, "a", &Memory::new(), &few).unwrap();
    let objects = layouts(&loaded.scene, &origins, Charts::Faces, 1);
    let file = GltfFile {
        bytes: &bytes,
        name: "a",
        files: &Memory::new(),
        options: &few,
    };
    let error = with_lightmap(&file, &origins, &usual(&objects, &pages(1))).unwrap_err();
    assert!(
        error.to_string().contains("more bytes than allowed"),
        "{error}"
    );
    // Origins of another file.
    let mut other = origins.clone();
    other[0].faces = vec![
        crate::gltf::FaceOrigin {
            primitive: 0,
            triangle: 4
        };
        4
    ]
    .into();
    let file = GltfFile {
        options: &ReadOptions::default(),
        ..file
    };
    let error = with_lightmap(&file, &other, &usual(&objects, &pages(1))).unwrap_err();
    assert!(
        error.to_string().contains("a triangle out of range"),
        "{error}"
    );
    assert!(strip(b"glTF", "a").is_err());
    assert!(strip(&glb_of(&[(b"JSON", b"[")]), "a").is_err());
}

#[test]
fn coordinates_of_pictures_are_left_alone() {
    let list = r#"{"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"texCoord":1}},"normalTexture":{"index":0,"extensions":{"KHR_texture_transform":{"texCoord":2}}}}"#;
    let bytes = file(&[Some(0)], &[0], list, ",\"textures\":[{}]");
    let (name, files) = ("a.glb", &Memory::new());
    let case = Case {
        bytes: &bytes,
        name,
        files,
    };
    let json = json_of(&check(&case, Charts::Faces, |_| {}).unwrap());
    // Both sets are missing in the file, and numbered names have no gaps.
    let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
    let names: Vec<&str> = attributes
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    let expected = [
        "POSITION",
        "TEXCOORD_0",
        "TEXCOORD_1",
        "TEXCOORD_2",
        "TEXCOORD_3",
    ];
    assert_eq!(names, expected);
    assert_eq!(lightmap(&json, 0)["texCoord"], 3);
    let bytes = file(&[Some(0)], &[0], "{}", "");
    let case = Case {
        bytes: &bytes,
        ..case
    };
    let wished = check(&case, Charts::One, |e| e.uvs = LightmapUvs::Added(0)).unwrap();
    assert_eq!(lightmap(&json_of(&wished), 0)["texCoord"], 0);
}
