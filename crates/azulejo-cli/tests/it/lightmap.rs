//! Models with lightmaps: what is shown of them, and what is computed in their place.

use crate::support::{Folder, project};
use azulejo_formats::{Memory, ReadOptions, gltf, picture};
use azulejo_render::SecondPass;
use azulejo_scene::math::Ray;
use azulejo_scene::{Image, Rgb, Scene, WrapMode};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec2, DVec3};
use serde_json::json;
use std::f64::consts::PI;
use std::fs;

/// The Cornell box, baked: `baked.glb`, and irradiance as `e.exr`.
fn baked_box(options: &str) -> Folder {
    let folder = Folder::new();
    let scene = fs::read(project().join("examples/cornell.grf")).unwrap();
    folder.write("box.grf", scene);
    folder.ok(&format!(
        "bake box.grf -o baked.glb --size 128 --error 5% --lightmap e.exr {options}"
    ));
    folder
}

fn scene_of(folder: &Folder, name: &str) -> Scene {
    let bytes = folder.read(name);
    let loaded = gltf::read(&bytes, name, &Memory::new(), &ReadOptions::default()).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.scene.validate().unwrap();
    loaded.scene
}

/// The middle of a face.
struct MattPoint {
    position: DVec3,
    normal: DVec3,
    /// Where it is in the lightmap.
    uv: DVec2,
    reflectance: Rgb,
}

/// The middles of the faces of matt surfaces that do not emit.
fn matt_points(scene: &Scene) -> Vec<MattPoint> {
    let mut points = Vec::new();
    for placed in scene.objects.iter().filter_map(|o| o.shape.placed_mesh()) {
        let mesh = placed.mesh;
        for face in 0..mesh.faces.len() {
            let material = &scene.materials[mesh.face_materials[face] as usize];
            if material.is_emitter() || material.lightmap.is_none() {
                continue;
            }
            let corners = placed.face_positions(face);
            let uvs = mesh.faces.corner_range(face);
            let uv: DVec2 = uvs.map(|c| mesh.lightmap_uv(c).unwrap()).sum();
            points.push(MattPoint {
                position: corners.iter().sum::<DVec3>() / 3.0,
                normal: placed.face_area_vector(face).normalize(),
                uv: uv / 3.0,
                reflectance: material.diffuse,
            });
        }
    }
    points
}

/// Radiance that leaves points along their normals.
fn radiance(scene: &Scene, points: &[MattPoint]) -> Vec<Rgb> {
    let size = scene.bounds().diagonal();
    let ray = |p: &MattPoint| Ray::new(p.position + 1e-4 * size * p.normal, -p.normal);
    let rays: Vec<Ray> = points.iter().map(ray).collect();
    let tracer = Tracer::new(scene);
    let options = SecondPass::default();
    azulejo_render::radiance(scene, &tracer, &rays, &options, &Progress::new()).unwrap()
}

/// What is seen of a lightmap is ρE/π, with the E that was baked, but for the steps of 8 bits.
fn check_shown(folder: &Folder, tolerance: f64) {
    let scene = scene_of(folder, "baked.glb");
    assert!(scene.is_solved() && scene.has_lightmap());
    let exact: Image = picture::decode(&folder.read("e.exr")).unwrap();
    let points = matt_points(&scene);
    assert!(points.len() > 20, "{}", points.len());
    let (mut found, mut expected) = (0.0, 0.0);
    let seen = radiance(&scene, &points);
    let baked = points.iter().map(|p| {
        let e = exact.sample_wrapped(p.uv, [WrapMode::Clamp; 2]);
        p.reflectance * Rgb::from(e.map(f64::from)) / PI
    });
    let baked: Vec<Rgb> = baked.collect();
    let most = baked.iter().map(|l| l.max_channel()).fold(0.0, f64::max);
    for (seen, baked) in seen.iter().zip(&baked) {
        let off = (*seen - *baked).map(f64::abs).max_channel();
        assert!(off < tolerance * most, "{seen:?}, baked {baked:?}");
        found += seen.mean();
        expected += baked.mean();
    }
    let off = found / expected - 1.0;
    assert!(off.abs() < 0.01, "mean {found}, baked {expected}");
}

#[test]
fn what_was_baked_is_shown() {
    let folder = baked_box("");
    check_shown(&folder, 0.02);
    let report = folder.json("render baked.glb -o x.png --size 32x32 --spp 4");
    assert_eq!(report["solved_before"], true);
    let info = folder.json("info baked.glb");
    assert_eq!(info["solved"], true);
    assert!(info["lightmapped_objects"].as_u64().is_some_and(|n| n > 3));
    let words = folder.ok("info baked.glb");
    assert!(words.out.contains("in lightmaps, of"), "{}", words.out);
    // The same light as on vertices, in the mean of a picture.
    folder.ok("render baked.glb -o map.exr --size 24x24 --spp 16");
    folder.ok("render box.grf -o vertices.exr --size 24x24 --spp 16 --error 3%");
    let mean = |name: &str| {
        let image = picture::decode(&folder.read(name)).unwrap();
        image
            .pixels
            .iter()
            .flatten()
            .map(|v| v.min(1.0))
            .sum::<f32>()
    };
    let ratio = mean("map.exr") / mean("vertices.exr");
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

#[test]
fn bright_pictures_and_nodes_show_it_too() {
    check_shown(&baked_box("--image hdr"), 0.01);
    check_shown(&baked_box("--as mx"), 0.02);
}

/// Several places of one mesh: each shows its own part of the page, in all ways to say so.
#[test]
fn copies_show_their_own_light() {
    let folder = Folder::new();
    for how in ["copy", "transform", "node --as mx"] {
        folder.write("two.gltf", TWO_SHEETS);
        folder.ok(&format!(
            "bake two.gltf -o baked.glb --size 64 --error 5% --lightmap e.exr --instances {how}"
        ));
        let scene = scene_of(&folder, "baked.glb");
        let points = matt_points(&scene);
        assert_eq!(points.len(), 4, "{how}");
        let exact = picture::decode(&folder.read("e.exr")).unwrap();
        for (point, seen) in points.iter().zip(radiance(&scene, &points)) {
            let e = exact.sample_wrapped(point.uv, [WrapMode::Clamp; 2]);
            let baked = point.reflectance.g * f64::from(e[1]) / PI;
            assert!(
                (seen.g / baked - 1.0).abs() < 0.03,
                "{how}: {seen:?}, {baked}"
            );
        }
        let levels = radiance(&scene, &points);
        assert!(levels[0].g > 1.5 * levels[2].g, "{how}: {levels:?}");
    }
}

/// Instances at one node get light of their own as nodes, and are instances again without it.
#[test]
fn instances_show_their_own_light() {
    let folder = Folder::new();
    let mut file: serde_json::Value = serde_json::from_str(TWO_SHEETS).unwrap();
    let places = [0.0_f32, 0.0, 0.0, 0.0, -1.0, 3.0];
    let bytes = places.iter().flat_map(|v| v.to_le_bytes());
    folder.write("places.bin", bytes.collect::<Vec<u8>>());
    file["extensionsUsed"] = json!(["KHR_lights_punctual", "EXT_mesh_gpu_instancing"]);
    file["scenes"][0]["nodes"] = json!([0, 2]);
    file["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 4 } } });
    let list = |name: &str| file[name].as_array().unwrap().clone();
    let [mut buffers, mut views, mut accessors] = ["buffers", "bufferViews", "accessors"].map(list);
    buffers.push(json!({ "uri": "places.bin", "byteLength": 24 }));
    views.push(json!({ "buffer": 1, "byteLength": 24 }));
    accessors.push(json!({ "bufferView": 4, "componentType": 5126, "type": "VEC3", "count": 2 }));
    file["buffers"] = buffers.into();
    file["bufferViews"] = views.into();
    file["accessors"] = accessors.into();
    folder.write("one.gltf", file.to_string());
    folder.write("two.gltf", TWO_SHEETS);
    let [found, expected] = ["one", "two"].map(|name| {
        folder.ok(&format!(
            "bake {name}.gltf -o {name}.glb --size 64 --error 5%"
        ));
        let scene = scene_of(&folder, &format!("{name}.glb"));
        radiance(&scene, &matt_points(&scene))
    });
    assert_eq!(found.len(), 4);
    for (a, b) in found.iter().zip(&expected) {
        assert!((a.g / b.g - 1.0).abs() < 0.02, "{a:?}, {b:?}");
    }
    folder.ok("bake --verify one.glb");
    folder.ok("bake one.glb --strip -o again.glb");
    let scene = scene_of(&folder, "again.glb");
    assert_eq!(scene.shared_meshes().len(), 1);
    folder.ok("bake one.glb -o one2.glb --size 64 --error 5%");
    assert_eq!(folder.read("one2.glb"), folder.read("one.glb"));
}

/// Light that is computed anew begins without the old lightmap, and with the lamps that were dimmed for it.
#[test]
fn light_is_computed_anew_from_what_was_there_before() {
    let folder = Folder::new();
    folder.write("two.gltf", TWO_SHEETS);
    folder.ok("bake two.gltf -o baked.glb --size 64 --error 5%");
    let removed = "its lightmap, which azulejo has baked, is removed first";
    let again = folder.ok("bake baked.glb -o again.glb --size 64 --error 5%");
    assert!(again.err.contains(removed), "{}", again.err);
    // Nothing of the first time is left.
    let directly = folder.read("baked.glb").len();
    assert_eq!(folder.read("again.glb").len(), directly);
    let [first, second] = ["baked.glb", "again.glb"].map(|name| {
        let scene = scene_of(&folder, name);
        radiance(&scene, &matt_points(&scene))
    });
    for (a, b) in first.iter().zip(&second) {
        assert!((a.g / b.g - 1.0).abs() < 0.05, "{a:?}, {b:?}");
    }
    let solved = folder.ok("solve baked.glb -o solved.glb");
    assert!(solved.err.contains(removed), "{}", solved.err);
    let scene = scene_of(&folder, "solved.glb");
    assert!(!scene.has_lightmap() && scene.is_solved());
    assert!(scene.has_light(), "the lamps shine again");
    // Formats without lightmaps say so, once.
    let lost = folder.ok("convert baked.glb -o flat.ply");
    assert_eq!(lost.err.matches("lightmap").count(), 1, "{}", lost.err);
    folder.ok("convert baked.glb -o copy.glb");
    assert!(scene_of(&folder, "copy.glb").has_lightmap());
}

/// The lightmap of another program is shown, but it is neither a lamp nor kept beside a new one.
#[test]
fn lightmaps_of_others_are_replaced() {
    let folder = Folder::new();
    let mut file: serde_json::Value = serde_json::from_str(TWO_SHEETS).unwrap();
    // One white texel.
    let page = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4//8/AAX+Av4N70a4AAAAAElFTkSuQmCC";
    file["images"] = serde_json::json!([{ "uri": format!("data:image/png;base64,{page}") }]);
    file["textures"] = serde_json::json!([{ "source": 0 }]);
    file["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = 2.into();
    file["materials"][0]["extensions"] =
        serde_json::json!({ "MOZ_lightmap": { "index": 0, "intensity": 1000 } });
    let text = file.to_string();
    folder.write("foreign.gltf", &text);
    let scene = scene_of(&folder, "foreign.gltf");
    let bright = radiance(&scene, &matt_points(&scene));
    assert!(
        bright
            .iter()
            .all(|l| (l.g / (400.0 / PI) - 1.0).abs() < 1e-4)
    );
    let said = "lightmap of another program";
    let run = folder.ok("bake foreign.gltf -o baked.glb --size 64 --error 5%");
    assert!(run.err.contains(said), "{}", run.err);
    folder.write("two.gltf", TWO_SHEETS);
    folder.ok("bake two.gltf -o plain.glb --size 64 --error 5%");
    let [found, expected] = ["baked.glb", "plain.glb"].map(|name| {
        let scene = scene_of(&folder, name);
        radiance(&scene, &matt_points(&scene))
    });
    for (a, b) in found.iter().zip(&expected) {
        assert!((a.g / b.g - 1.0).abs() < 0.05, "{a:?}, {b:?}");
    }
    let run = folder.ok("solve foreign.gltf -o solved.glb");
    assert!(run.err.contains(said), "{}", run.err);
    folder.ok("bake baked.glb --strip -o stripped.glb");
    let json: serde_json::Value = {
        let glb = folder.read("stripped.glb");
        let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
        serde_json::from_slice(&glb[20..20 + length]).unwrap()
    };
    assert_eq!(
        json["materials"][0]["extensions"]["MOZ_lightmap"]["intensity"],
        1000
    );
}

/// Two nodes with one mesh, a square of one metre that looks up, at different distances below a lamp;
/// accessor 2 has texture coordinates that its one primitive does not use.
const TWO_SHEETS: &str = include_str!("two_sheets.gltf");
