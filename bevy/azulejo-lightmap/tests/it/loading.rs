use crate::model::{self, described, squares};
use azulejo_lightmap::LightmapExposure;
use bevy::gltf::GltfMaterialName;
use bevy::pbr::Lightmap;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::TextureFormat;
use bevy::render::settings::WgpuSettings;
use serde_json::{Value, json};
use std::f32::consts::PI;
use std::io::{self, Write};
use std::sync::{Mutex, OnceLock};

/// What Bevy and the plug-in have warned of.
static WARNINGS: Mutex<Vec<u8>> = Mutex::new(Vec::new());

struct Warnings;

impl Write for Warnings {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        WARNINGS.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Those of a file.
fn warnings(name: &str) -> Vec<String> {
    let all = String::from_utf8(WARNINGS.lock().unwrap().clone()).unwrap();
    let lines = all.lines().filter(|line| line.contains(name));
    lines.map(str::to_owned).collect()
}

/// Loads a file without a graphics card.
fn loaded(name: &str, file: Vec<u8>) -> App {
    static IS_RECORDED: OnceLock<()> = OnceLock::new();
    IS_RECORDED.get_or_init(|| {
        tracing_subscriber::fmt()
            .with_ansi(false)
            .with_writer(|| Warnings)
            .init();
    });
    let render = RenderPlugin {
        render_creation: WgpuSettings {
            backends: None,
            ..default()
        }
        .into(),
        ..default()
    };
    let mut app = model::app(name, file, render);
    model::spawn(&mut app, name);
    app
}

/// A mesh as it was spawned.
struct Spawned {
    material: String,
    /// The path of the picture, and the exposure.
    lightmap: Option<(String, f32)>,
    /// That of its StandardMaterial.
    exposure: f32,
}

fn spawned(app: &mut App) -> Vec<Spawned> {
    let mut meshes = app.world_mut().query::<(
        &GltfMaterialName,
        &MeshMaterial3d<StandardMaterial>,
        Option<(&Lightmap, &LightmapExposure)>,
    )>();
    let world = app.world();
    let materials = world.resource::<Assets<StandardMaterial>>();
    let meshes = meshes
        .iter(world)
        .map(|(name, material, lightmap)| Spawned {
            material: name.0.clone(),
            lightmap: lightmap.map(|(lightmap, exposure)| {
                assert_eq!(lightmap.uv_rect, Rect::new(0.0, 0.0, 1.0, 1.0));
                (lightmap.image.path().unwrap().to_string(), exposure.0)
            }),
            exposure: materials.get(&material.0).unwrap().lightmap_exposure,
        });
    meshes.collect()
}

#[test]
fn meshes_have_the_lightmap_of_their_material() {
    let json = described();
    let mut app = loaded("squares.glb", model::SQUARES.to_vec());
    let meshes = spawned(&mut app);
    let mut pictures = Vec::new();
    assert_eq!(meshes.len(), 4);
    for mesh in meshes {
        let materials = json["materials"].as_array().unwrap();
        let material = materials
            .iter()
            .find(|material| material["name"] == mesh.material.as_str());
        let entry = &material.unwrap()["extensions"]["MOZ_lightmap"];
        let exposure = entry["intensity"].as_f64().unwrap() as f32 / PI;
        let picture = format!("squares.glb#Texture{}", entry["index"]);
        assert_eq!(
            mesh.lightmap,
            Some((picture.clone(), exposure)),
            "{}",
            mesh.material
        );
        assert_eq!(mesh.exposure, exposure, "{}", mesh.material);
        pictures.push(picture);
    }
    pictures.sort();
    pictures.dedup();
    assert_eq!(pictures.len(), 2, "two pages");
    assert_eq!(warnings("squares.glb"), Vec::<String>::new());
    let images = app.world().resource::<Assets<Image>>();
    let mut formats = images
        .iter()
        .map(|(_, image)| image.texture_descriptor.format);
    assert!(formats.any(|format| format == TextureFormat::Rgba8UnormSrgb));
}

/// Loads the squares with a change to the material `red` and its mesh, and checks that the lightmap of the others stays
/// and that one warning names the file, the material and the words.
fn warns(name: &str, words: &str, edit: impl FnOnce(&mut Value, usize)) {
    let file = squares(|json| {
        let materials = json["materials"].as_array().unwrap();
        let red = materials
            .iter()
            .position(|material| material["name"] == "red");
        edit(json, red.unwrap());
    });
    let mut app = loaded(name, file);
    let meshes = spawned(&mut app);
    assert_eq!(meshes.len(), 4);
    for mesh in meshes {
        assert_eq!(
            mesh.lightmap.is_some(),
            mesh.material != "red",
            "{name}: {}",
            mesh.material
        );
    }
    let warnings = warnings(name);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    for words in [&format!("{name}: material \"red\" "), words] {
        assert!(warnings[0].contains(words), "{words}: {}", warnings[0]);
    }
}

#[test]
fn damaged_entries_are_warnings() {
    let entries = [
        ("index.glb", json!({ "index": 7 }), "texture 7 of 2"),
        (
            "no-index.glb",
            json!({ "texCoord": 1 }),
            "missing field `index`",
        ),
        ("negative.glb", json!({ "index": -1 }), "integer `-1`"),
        ("words.glb", json!("a"), "string \"a\""),
        (
            "dark.glb",
            json!({ "index": 0, "intensity": -2 }),
            "intensity is -2",
        ),
        (
            "bright.glb",
            json!({ "index": 0, "intensity": 1e60 }),
            "intensity is inf",
        ),
        (
            "text.glb",
            json!({ "index": 0, "intensity": "NaN" }),
            "string \"NaN\"",
        ),
        (
            "set.glb",
            json!({ "index": 0, "texCoord": 2 }),
            "on TEXCOORD_2",
        ),
        (
            "moved.glb",
            json!({ "index": 0, "extensions": { "KHR_texture_transform": { "offset": [0.5, 0] } } }),
            "KHR_texture_transform",
        ),
    ];
    for (name, entry, words) in entries {
        warns(name, words, |json, red| {
            json["materials"][red]["extensions"]["MOZ_lightmap"] = entry;
        });
    }
}

#[test]
fn surfaces_that_bevy_would_not_show_keep_their_material_without_lightmap() {
    warns("flat.glb", "has no TEXCOORD_1", |json, red| {
        let primitive = primitive(json, red);
        primitive["attributes"]
            .as_object_mut()
            .unwrap()
            .remove("TEXCOORD_1");
    });
    warns("unlit.glb", "unlit", |json, red| {
        json["materials"][red]["extensions"]["KHR_materials_unlit"] = json!({});
    });
    warns("morph.glb", "morph targets", |json, red| {
        let primitive = primitive(json, red);
        primitive["targets"] = json!([{ "POSITION": primitive["attributes"]["POSITION"] }]);
    });
}

fn primitive(json: &mut Value, material: usize) -> &mut Value {
    let meshes = json["meshes"].as_array_mut().unwrap();
    let mut primitives = meshes.iter_mut().map(|mesh| &mut mesh["primitives"][0]);
    primitives
        .find(|primitive| primitive["material"] == material)
        .unwrap()
}

#[test]
fn texcoord_and_intensity_may_be_left_out() {
    let file = squares(|json| {
        for material in json["materials"].as_array_mut().unwrap() {
            material["extensions"]["MOZ_lightmap"] = json!({ "index": 1 });
        }
    });
    for mesh in spawned(&mut loaded("short.glb", file)) {
        assert_eq!(
            mesh.lightmap,
            Some(("short.glb#Texture1".to_owned(), 1.0 / PI))
        );
        assert_eq!(mesh.exposure, 1.0 / PI);
    }
}
