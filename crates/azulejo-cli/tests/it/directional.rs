//! Where the light of lightmaps comes from, lightmaps that are out of date, and noise that is removed.

use crate::support::Folder;
use azulejo_formats::picture::exr::read_channels;
use azulejo_formats::picture::png;
use serde_json::{Value, json};

/// The JSON of a GLB.
fn document(folder: &Folder, name: &str) -> Value {
    let bytes = folder.read(name);
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

/// A plate of 1 m² that faces up, or is tilted by 20° toward +x, with a lamp to its left and a red wall to its right;
/// `relief.gltf` has a normal map with that tilt.
pub fn write_plates(folder: &Folder) {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let normal = [sin, 0.0, cos].map(|v| (127.5 * (v + 1.0)).round() as u8);
    let mut picture = Vec::new();
    png::write_data(2, 2, &normal.repeat(4), &mut picture).unwrap();
    folder.write("normal.png", picture);
    for (name, [sin, cos], has_map) in [
        ("flat", [0.0, 1.0], false),
        ("tilted", [sin, cos], false),
        ("relief", [0.0, 1.0], true),
    ] {
        let corner = |x: f64, z: f64| [x * cos, -x * sin, z];
        let plate = [
            corner(-0.5, -0.5),
            corner(0.5, -0.5),
            corner(0.5, 0.5),
            corner(-0.5, 0.5),
        ];
        let lamp = [
            [-1.6, 1.5, -0.3],
            [-1.0, 1.9, -0.3],
            [-1.0, 1.9, 0.3],
            [-1.6, 1.5, 0.3],
        ];
        let wall = [
            [1.2, -1.0, -1.5],
            [1.2, 2.0, -1.5],
            [1.2, 2.0, 1.5],
            [1.2, -1.0, 1.5],
        ];
        let tangent = [cos, -sin, 0.0, 1.0];
        let mut numbers: Vec<f64> = [plate, lamp, wall]
            .into_iter()
            .flatten()
            .flatten()
            .collect();
        numbers.extend([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].concat());
        numbers.extend([tangent; 4].concat());
        numbers.extend([[sin, cos, 0.0]; 4].concat());
        let floats = numbers.iter().flat_map(|&v| (v as f32).to_le_bytes());
        let corners = [0u16, 2, 1, 0, 3, 2, 0, 1, 2, 0, 2, 3];
        let mut bytes: Vec<u8> = floats.collect();
        let triangles = bytes.len();
        bytes.extend(corners.iter().flat_map(|c| c.to_le_bytes()));
        let position = |of: usize, quad: [[f64; 3]; 4]| {
            let end = |pick: fn(f64, f64) -> f64| {
                [0, 1, 2].map(|k| {
                    quad.iter()
                        .map(|c| c[k] as f32 as f64)
                        .reduce(pick)
                        .unwrap()
                })
            };
            json!({ "bufferView": 0, "byteOffset": 48 * of, "componentType": 5126, "count": 4, "type": "VEC3",
                    "min": end(f64::min), "max": end(f64::max) })
        };
        let mut material = json!({ "name": "plate", "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0 } });
        if has_map {
            material["normalTexture"] = json!({ "index": 0 });
        }
        let surface = |colour: [f64; 4]| json!({ "baseColorFactor": colour, "metallicFactor": 0 });
        let gltf = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1, 2] }],
            "nodes": [{ "mesh": 0 }, { "mesh": 1 }, { "mesh": 2 }],
            "meshes": [
                { "primitives": [{ "material": 0, "indices": 3, "attributes": {
                    "POSITION": 0, "TEXCOORD_0": 5, "TANGENT": 6, "NORMAL": 7 } }] },
                { "primitives": [{ "material": 1, "indices": 4, "attributes": { "POSITION": 1 } }] },
                { "primitives": [{ "material": 2, "indices": 4, "attributes": { "POSITION": 2 } }] },
            ],
            "materials": [
                material,
                { "emissiveFactor": [1, 1, 1], "doubleSided": true, "pbrMetallicRoughness": surface([0.0, 0.0, 0.0, 1.0]),
                  "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 20 } } },
                { "doubleSided": true, "pbrMetallicRoughness": surface([0.8, 0.2, 0.2, 1.0]) },
            ],
            "extensionsUsed": ["KHR_materials_emissive_strength"],
            "textures": [{ "source": 0 }], "images": [{ "uri": "normal.png" }],
            "buffers": [{ "uri": format!("{name}.bin"), "byteLength": bytes.len() }],
            "bufferViews": [
                { "buffer": 0, "byteLength": triangles },
                { "buffer": 0, "byteOffset": triangles, "byteLength": 24 },
            ],
            "accessors": [
                position(0, plate), position(1, lamp), position(2, wall),
                { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
                { "bufferView": 1, "byteOffset": 12, "componentType": 5123, "count": 6, "type": "SCALAR" },
                { "bufferView": 0, "byteOffset": 144, "componentType": 5126, "count": 4, "type": "VEC2" },
                { "bufferView": 0, "byteOffset": 176, "componentType": 5126, "count": 4, "type": "VEC4" },
                { "bufferView": 0, "byteOffset": 240, "componentType": 5126, "count": 4, "type": "VEC3" },
            ],
        });
        folder.write(&format!("{name}.bin"), bytes);
        folder.write(&format!("{name}.gltf"), gltf.to_string());
    }
}

/// Three pictures in the extras of the lightmap, or one, and the coefficients as layers; all go when it is stripped.
#[test]
fn directions_are_written_and_removed() {
    let folder = Folder::new();
    write_plates(&folder);
    let bake = "bake relief.gltf -o baked.glb --size 32 --error 5% --sky 0.5";
    let report = folder.json(&format!(
        "{bake} --directional --lightmap e.exr --error-map se.exr"
    ));
    let errors = report["direction_errors"].as_array().unwrap();
    assert!(errors.iter().all(|e| e.as_f64().unwrap() > 0.0), "{report}");
    let gltf = document(&folder, "baked.glb");
    let named =
        &gltf["materials"][0]["extensions"]["MOZ_lightmap"]["extras"]["azulejo"]["directions"];
    let textures: Vec<usize> = named
        .as_array()
        .unwrap()
        .iter()
        .map(|t| t["index"].as_u64().unwrap() as usize)
        .collect();
    assert_eq!(textures.len(), 3);
    for texture in textures {
        let image = &gltf["textures"][texture]["source"];
        assert_eq!(
            gltf["images"][image.as_u64().unwrap() as usize]["mimeType"],
            "image/png"
        );
    }
    for name in ["e.exr", "se.exr"] {
        let (_, channels) = read_channels(&folder.read(name)).unwrap();
        let names: Vec<&str> = channels
            .iter()
            .map(|channel| channel.name.as_str())
            .collect();
        for layer in ["R", "L00.R", "L1-1.G", "L10.B", "L11.G"] {
            assert!(names.contains(&layer), "{name}: {names:?}");
        }
    }
    folder.ok("bake baked.glb --strip -o again.glb");
    let again = document(&folder, "again.glb");
    assert_eq!(again["textures"].as_array().unwrap().len(), 1);
    assert!(!again.to_string().contains("directions"));
    folder.ok(&format!("{bake} --directional=dominant"));
    let gltf = document(&folder, "baked.glb");
    let named =
        &gltf["materials"][0]["extensions"]["MOZ_lightmap"]["extras"]["azulejo"]["directions"];
    assert_eq!(named.as_array().unwrap().len(), 1);
}

#[test]
fn directions_without_a_place_are_refused() {
    let folder = Folder::new();
    write_plates(&folder);
    for options in [
        "--as emissive",
        "--as mx",
        "--light ao --as occlusion",
        "--html",
    ] {
        let line = format!("bake relief.gltf -o baked.glb --sky 1 --directional {options}");
        folder.fails(&line, 2, "--directional is for --as moz");
    }
    let part = "bake relief.gltf -o part --sky 1 --rays 16 --directional --shard 1/2";
    folder.fails(part, 2, "--directional");
    folder.fails(
        "bake flat.gltf -o x.glb --sky 1 --directional=both",
        2,
        "[possible values: sh, dominant]",
    );
}

/// Geometry, materials, lights and, if models are given, options.
#[test]
fn stale_lightmaps_are_found() {
    let folder = Folder::new();
    write_plates(&folder);
    let options = "--size 32 --error 10% --sky 0.5";
    folder.ok(&format!("bake flat.gltf -o baked.glb {options}"));
    assert_eq!(
        folder.json("bake --verify baked.glb --sky 0.5")["up_to_date"],
        true
    );
    folder.ok(&format!("bake --verify baked.glb flat.gltf {options}"));
    let stale = |line: &str, why: &str| {
        let run = folder.run(line);
        assert_eq!(run.code, Some(1), "{line}: {}", run.err);
        assert!((run.out + &run.err).contains(why), "{line}");
    };
    stale(
        "bake --verify baked.glb flat.gltf --size 64 --error 10% --sky 0.5",
        "other options",
    );
    stale(
        &format!("bake --verify baked.glb tilted.gltf {options}"),
        "have changed",
    );
    stale("bake --verify baked.glb", "have changed");
    let text = String::from_utf8(folder.read("flat.gltf")).unwrap();
    folder.write("darker.gltf", text.replace("0.8", "0.7"));
    stale(
        &format!("bake --verify baked.glb darker.gltf {options}"),
        "have changed",
    );
    folder.fails("bake --verify flat.gltf", 1, "no lightmap that says");
    folder.fails("bake --verify missing.glb", 1, "missing.glb");
}

/// Fewer rays with the filter leave what several times as many leave without it.
#[test]
fn noise_is_removed_where_texels_are_gathered() {
    let folder = Folder::with_room();
    let error = |options: &str| {
        let line = format!("bake room.obj -o baked.glb --size 96 {options}");
        folder.json(&line)["error"].as_f64().unwrap()
    };
    let (noisy, clean) = (error("--rays 32"), error("--rays 32 --denoise"));
    assert!(clean < 0.8 * noisy, "{noisy} {clean}");
    for options in [
        "--denoise",
        "--rays 64 --error 1% --denoise",
        "--rays 64 --time 5s --denoise",
    ] {
        let line = format!("bake room.obj -o baked.glb {options}");
        folder.fails(&line, 2, "--denoise is for --rays");
    }
}
