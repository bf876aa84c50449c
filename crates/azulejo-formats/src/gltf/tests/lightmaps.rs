//! Lightmaps of materials and of nodes, of azulejo's own and of others' files.

use super::{loaded, mesh_of, read};
use crate::picture::{hdr, ktx2, png};
use crate::{Memory, ReadOptions, gltf};
use azulejo_scene::{Image, Rgb, Scene, Shape};
use glam::DVec2;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// A data URI.
fn data(bytes: &[u8]) -> String {
    let escaped: String = bytes.iter().map(|b| format!("%{b:02x}")).collect();
    format!("data:,{escaped}")
}

/// The bytes of a picture of four greys.
fn greys(values: [u8; 4]) -> Vec<u8> {
    let mut file = Vec::new();
    let pixels = values.map(|v| [v; 3]);
    png::write(2, 2, pixels.as_flattened(), &mut file).unwrap();
    file
}

/// A square with TEXCOORD_1 as its corners in the unit square, v downwards, and a grey material whose
/// lightmap this is.
fn square(lightmap: Value) -> Value {
    let corners = [[0.0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let positions = corners.iter().flat_map(|[x, y]| [*x, *y, 0.0]);
    // The top row of the picture, v = 0, is at y = 1.
    let uvs = corners.iter().flat_map(|[x, y]| [*x, 1.0 - *y]);
    let bytes: Vec<u8> = positions.chain(uvs).flat_map(f32::to_le_bytes).collect();
    let accessor = |view: u32, kind: &str| {
        json!({ "bufferView": view, "componentType": 5126, "count": 4, "type": kind,
                "min": [0, 0, 0], "max": [1, 1, 0] })
    };
    let corners: Vec<u8> = [0u16, 1, 2, 0, 2, 3]
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .collect();
    let length = bytes.len() + corners.len();
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["MOZ_lightmap", "MX_lightmap", "MOZ_texture_rgbe"],
        "buffers": [{ "byteLength": length, "uri": data(&[bytes, corners].concat()) }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 32 },
            { "buffer": 0, "byteOffset": 80, "byteLength": 12 },
        ],
        "accessors": [
            accessor(0, "VEC3"),
            accessor(1, "VEC2"),
            { "bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "TEXCOORD_1": 1 }, "indices": 2, "material": 0,
        }] }],
        "nodes": [{ "mesh": 0 }],
        "materials": [{
            "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0 },
            "doubleSided": true,
            "extensions": { "MOZ_lightmap": lightmap },
        }],
        "samplers": [{ "wrapS": 33071, "wrapT": 33071 }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "images": [{ "name": "light", "uri": data(&greys([255, 0, 188, 0])) }],
    })
}

/// Irradiance at a point of the square, as the second pass reads it, if there is any.
fn irradiance(scene: &Scene, object: usize, x: f64, y: f64) -> Option<Rgb> {
    let mesh = scene.objects[object].shape.mesh().unwrap();
    let (lightmap, image) = scene.lightmap(mesh.face_materials[0])?;
    let uvs = mesh.lightmap_uvs.as_ref()?;
    // An affine map of the corners (0, 0), (1, 0) and (0, 1).
    let find = |p: [f64; 2]| {
        let at = mesh.positions.iter().position(|q| [q.x, q.y] == p).unwrap();
        uvs.at(at, at as u32)
    };
    let [a, b, c] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(find);
    Some(lightmap.at(image, a + (b - a) * x + (c - a) * y))
}

fn near(irradiance: Option<Rgb>, expected: f64) {
    let irradiance = irradiance.expect("has a lightmap");
    assert!(
        (irradiance.r - expected).abs() < 1e-3 * expected.max(1.0),
        "{irradiance:?}, expected {expected}"
    );
}

#[test]
fn texels_are_decoded_and_multiplied() {
    let file = square(json!({ "index": 0, "texCoord": 1, "intensity": 40 }));
    let scene = read(&file.to_string(), &[]);
    assert!(scene.has_lightmap() && scene.is_solved());
    assert_eq!(scene.materials.len(), 1);
    // Centres of texels: white, black, and sRGB 188, which is 0.5029 in linear light.
    near(irradiance(&scene, 0, 0.25, 0.75), 40.0);
    near(irradiance(&scene, 0, 0.75, 0.75), 0.0);
    near(irradiance(&scene, 0, 0.25, 0.25), 40.0 * 0.502_886);
    near(
        irradiance(&scene, 0, 0.5, 0.5),
        40.0 * (1.0 + 0.502_886) / 4.0,
    );
    // Clamped at the borders.
    near(irradiance(&scene, 0, 0.0, 1.0), 40.0);
}

/// Without texCoord it is set 1, and without an intensity 1; a transform moves it and names another set.
#[test]
fn defaults_and_transforms() {
    let scene = read(&square(json!({ "index": 0 })).to_string(), &[]);
    near(irradiance(&scene, 0, 0.25, 0.75), 1.0);
    let moved = json!({ "index": 0, "texCoord": 7, "extensions": { "KHR_texture_transform": {
        "offset": [0.5, 0], "scale": [0.5, 1], "texCoord": 1 } } });
    let scene = read(&square(moved).to_string(), &[]);
    // The right half of the picture.
    near(irradiance(&scene, 0, 0.5, 0.75), 0.0);
    near(irradiance(&scene, 0, 0.0, 0.75), 0.5);
    let mesh = mesh_of(&scene, 0);
    let uvs = mesh.lightmap_uvs.as_ref().unwrap();
    assert!(uvs.values.contains(&DVec2::new(0.5, 1.0)));
}

/// The colour of an unlit material is its own times the texel: ρE/π for E = π t.
#[test]
fn unlit_materials_are_not_divided_by_pi() {
    let mut file = square(json!({ "index": 0, "intensity": 3 }));
    file["materials"][0]["extensions"]["KHR_materials_unlit"] = json!({});
    let scene = read(&file.to_string(), &["KHR_materials_unlit"]);
    near(irradiance(&scene, 0, 0.25, 0.75), 3.0 * PI);
    assert_eq!(scene.materials[0].diffuse, Rgb::grey(0.5));
}

#[test]
fn bright_pictures_come_before_others() {
    let mut bright = Vec::new();
    let pixels = vec![[8.0, 8.0, 8.0]; 4];
    hdr::write(&Image::opaque(2, 2, pixels), &mut bright).unwrap();
    let mut file = square(json!({ "index": 0, "intensity": 2 }));
    let images = file["images"].as_array_mut().unwrap();
    images.push(json!({ "uri": data(&bright), "mimeType": "image/vnd.radiance" }));
    file["textures"][0]["extensions"] = json!({ "MOZ_texture_rgbe": { "source": 1 } });
    let scene = read(&file.to_string(), &[]);
    // 8, with the half step that the format adds.
    near(irradiance(&scene, 0, 0.75, 0.75), 16.0625);
    // The other where that is damaged, or alone.
    file["images"][1]["uri"] = data(b"nothing").into();
    let scene = read(&file.to_string(), &["is not used"]);
    near(irradiance(&scene, 0, 0.25, 0.75), 2.0);
    file["images"][1]["uri"] = data(&bright).into();
    file["textures"][0]
        .as_object_mut()
        .unwrap()
        .remove("source");
    let scene = read(&file.to_string(), &[]);
    near(irradiance(&scene, 0, 0.75, 0.75), 16.0625);
}

/// A KTX2 with a shared exponent comes before the PNG for others, which is shown where that is Basis Universal.
#[test]
fn ktx2_comes_before_others() {
    let mut bright = Vec::new();
    let image = Image::opaque(2, 2, vec![[8.0, 8.0, 8.0]; 4]);
    ktx2::write(&image, ktx2::Ktx2Texels::SharedExponent, 1, &mut bright).unwrap();
    let mut file = square(json!({ "index": 0, "intensity": 2 }));
    let images = file["images"].as_array_mut().unwrap();
    images.push(json!({ "uri": data(&bright), "mimeType": "image/ktx2" }));
    file["textures"][0]["extensions"] = json!({ "KHR_texture_basisu": { "source": 1 } });
    let scene = read(&file.to_string(), &[]);
    near(irradiance(&scene, 0, 0.75, 0.75), 16.0);
    // No format of Vulkan's.
    bright[12..16].fill(0);
    file["images"][1]["uri"] = data(&bright).into();
    let scene = read(&file.to_string(), &[]);
    near(irradiance(&scene, 0, 0.25, 0.75), 2.0);
    file["textures"][0]
        .as_object_mut()
        .unwrap()
        .remove("source");
    read(&file.to_string(), &["Basis Universal"]);
}

/// Nodes of one mesh show the lightmap of its material; those with one of their own that, moved and scaled.
#[test]
fn places_share_a_lightmap_or_have_their_own() {
    let mut file = square(json!({ "index": 0 }));
    let of_node = |offset: [f64; 2]| {
        json!({ "lightMapTexture": { "index": 0, "texCoord": 1 }, "intensity": 10,
                "scale": [0.5, 1], "offset": offset })
    };
    file["nodes"] = json!([
        { "mesh": 0 },
        { "mesh": 0 },
        { "mesh": 0, "extensions": { "MX_lightmap": of_node([0.0, 0.0]) } },
        { "mesh": 0, "extensions": { "MX_lightmap": of_node([0.5, 0.0]) } },
    ]);
    let scene = read(&file.to_string(), &[]);
    let is_shared = |o: usize| matches!(scene.objects[o].shape, Shape::Instance(_));
    assert_eq!([0, 1, 2, 3].map(is_shared), [true, true, false, false]);
    assert_eq!(scene.materials.len(), 2);
    for object in [0, 1] {
        near(irradiance(&scene, object, 0.25, 0.75), 1.0);
    }
    near(irradiance(&scene, 2, 0.5, 0.75), 10.0);
    near(irradiance(&scene, 3, 0.5, 0.75), 0.0);
    // Flat, and of the default material.
    file["nodes"] = json!([{ "mesh": 0, "extensions": {
        "MX_lightmap": { "index": 0, "texCoord": 1, "intensity": 7 } } }]);
    let primitive = file["meshes"][0]["primitives"][0].as_object_mut();
    primitive.unwrap().remove("material");
    let scene = read(&file.to_string(), &[]);
    near(irradiance(&scene, 0, 0.25, 0.75), 7.0);
}

/// A primitive without the coordinates has no lightmap, and one beside it of the same material has.
#[test]
fn only_primitives_with_coordinates_have_one() {
    let mut file = square(json!({ "index": 0 }));
    let primitives = file["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(json!({ "attributes": { "POSITION": 0 }, "indices": 2, "material": 0 }));
    let scene = read(&file.to_string(), &["without TEXCOORD_1"]);
    let mesh = mesh_of(&scene, 0);
    let lit = mesh
        .face_materials
        .iter()
        .map(|&m| scene.lightmap(m).is_some());
    assert_eq!(lit.collect::<Vec<_>>(), [true, true, false, false]);
}

/// Whatever a file says, it is a warning and no lightmap.
#[test]
fn faults_are_warnings() {
    for (lightmap, warning) in [
        (json!({}), "it names no texture"),
        (json!({ "index": 1 }), "texture 1 of 1"),
        (json!({ "index": -1 }), "no index"),
        (json!({ "index": "0" }), "no index"),
        (json!({ "index": 99_999_999_999u64 }), "no index"),
        (json!([]), "it names no texture"),
        (json!(null), "it names no texture"),
        (json!({ "index": 0, "intensity": -1 }), "intensity"),
        (json!({ "index": 0, "intensity": "NaN" }), "intensity"),
        (json!({ "index": 0, "intensity": null }), "intensity"),
        (json!({ "index": 0, "texCoord": 0.5 }), "texCoord"),
        (json!({ "index": 0, "texCoord": 2 }), "without TEXCOORD_2"),
        (
            json!({ "index": 0, "texCoord": 4_000_000_000u32 }),
            "TEXCOORD_4000000000",
        ),
        (
            json!({ "index": 0, "extensions": { "KHR_texture_transform": 5 } }),
            "KHR_texture_transform",
        ),
    ] {
        let scene = read(&square(lightmap.clone()).to_string(), &[warning]);
        assert!(!scene.has_lightmap(), "{lightmap}");
        let mut of_node = square(json!({ "index": 0 }));
        of_node["materials"][0]["extensions"] = json!({});
        of_node["nodes"][0]["extensions"] = json!({ "MX_lightmap": lightmap });
        loaded(of_node.to_string().as_bytes());
    }
    for odd in [json!([1]), json!([1, "2"]), json!(3)] {
        let mut file = square(json!({ "index": 0 }));
        file["materials"][0]["extensions"] = json!({});
        file["nodes"][0]["extensions"] = json!({ "MX_lightmap": { "index": 0, "scale": odd } });
        let scene = read(&file.to_string(), &["not a pair of numbers"]);
        assert!(!scene.has_lightmap());
    }
    let mut file = square(json!({ "index": 0 }));
    file["images"][0]["uri"] = json!("missing.png");
    let scene = read(&file.to_string(), &["lightmap not used"]);
    assert!(!scene.has_lightmap() && !scene.is_solved());
    let mut file = square(json!({ "index": 0 }));
    file["extensionsRequired"] = json!(["MOZ_lightmap"]);
    assert!(read(&file.to_string(), &[]).has_lightmap());
}

/// What is written shows the same light when it is read again: within a step of 8 bits.
#[test]
fn written_lightmaps_are_read_again() {
    let mut file = square(json!({ "index": 0, "intensity": 40 }));
    for peak in [1.0, 6.5] {
        let mut scene = read(&file.to_string(), &[]);
        let image = scene.textures[0].image.as_mut().unwrap();
        image.pixels.iter_mut().flatten().for_each(|v| *v *= peak);
        let mut bytes = Vec::new();
        gltf::write(&scene, &mut bytes).unwrap();
        let back = gltf::read(&bytes, "a.glb", &Memory::new(), &ReadOptions::default());
        let back = back.unwrap();
        assert!(back.warnings.is_empty(), "{:?}", back.warnings);
        let back = back.scene;
        for (x, y) in [(0.25, 0.75), (0.25, 0.25), (0.5, 0.5), (0.75, 0.25)] {
            let expected = irradiance(&scene, 0, x, y).unwrap().r;
            let irradiance = irradiance(&back, 0, x, y).unwrap().r;
            let step = 40.0 * f64::from(peak) / 255.0;
            assert!(
                (irradiance - expected).abs() < step,
                "{irradiance}, not {expected}"
            );
        }
        let losses = gltf::losses(&scene);
        assert_eq!(
            losses.iter().any(|l| l.contains("lightmaps")),
            peak > 1.0,
            "{losses:?}"
        );
    }
    // Coordinates by corner make vertices.
    file["materials"][0]["doubleSided"] = json!(false);
    let mut scene = read(&file.to_string(), &[]);
    let Shape::Mesh(mesh) = &mut scene.objects[0].shape else {
        unreachable!("one mesh of its own")
    };
    let uvs = mesh.lightmap_uvs.take().unwrap();
    let corners: Vec<DVec2> = (mesh.faces.corners.iter().enumerate())
        .map(|(k, &v)| uvs.at(k, v) * 0.5)
        .collect();
    let count = corners.len() as u32;
    mesh.lightmap_uvs = Some(azulejo_scene::Attribute {
        values: corners,
        corners: Some((0..count).collect()),
    });
    let mut bytes = Vec::new();
    gltf::write(&scene, &mut bytes).unwrap();
    let back = loaded(&bytes).scene;
    assert_eq!(mesh_of(&back, 0).positions.len(), 6);
    assert!(back.has_lightmap());
}
