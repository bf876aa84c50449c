//! Nodes, instances, lights and cameras.

use super::{json, loaded, mesh_of, one_mesh, read, triangle};
use crate::gltf::container::tests::glb_of;
use crate::{Memory, ReadOptions, gltf};
use azulejo_scene::{LightKind, Rgb};
use glam::DVec3;

const MESH: &str =
    "\"meshes\":[{\"name\":\"leaf\",\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]";

fn names(file: &str, warnings: &[&str]) -> Vec<String> {
    let scene = read(file, warnings);
    scene.objects.into_iter().map(|o| o.name).collect()
}

#[test]
fn names_are_paths() {
    let nodes = "\"nodes\":[{\"name\":\"house\",\"children\":[1]},{\"children\":[2,3]},\
         {\"name\":\"table\",\"mesh\":0},{\"mesh\":0}],";
    let file = triangle(&[], "", &format!("{nodes}{MESH}"));
    assert_eq!(names(&file, &[]), ["house/table", "house/leaf"]);
}

#[test]
fn the_default_scene_is_read() {
    let check = |scenes: &str, expected: &[&str], warnings: &[&str]| {
        let nodes = "\"nodes\":[{\"name\":\"a\",\"mesh\":0},{\"name\":\"b\",\"mesh\":0}],";
        let file = triangle(&[], "", &format!("{scenes}{nodes}{MESH}"));
        assert_eq!(names(&file, warnings), expected);
    };
    check("", &["a", "b"], &[]);
    check("\"scenes\":[{\"nodes\":[1]}],", &["b"], &[]);
    check(
        "\"scene\":1,\"scenes\":[{\"name\":\"day\",\"nodes\":[1]},{\"nodes\":[0,0]}],",
        &["a", "a"],
        &["scene day: skipped, another scene is read (at scenes[0])"],
    );
}

/// A mirrored instance keeps its front, and each instance is an object.
#[test]
fn instances_are_copies() {
    let nodes = "\"nodes\":[{\"mesh\":0,\"children\":[1]},\
        {\"mesh\":0,\"scale\":[-2,1,1],\"translation\":[0,0,3]}],";
    let scene = read(&triangle(&[], "", &format!("{nodes}{MESH}")), &[]);
    let mesh = mesh_of(&scene, 1);
    assert_eq!(mesh.positions[1], DVec3::new(-2.0, 0.0, 3.0));
    assert_eq!(mesh.face_area_vector(0), DVec3::Z);
    assert_eq!(mesh_of(&scene, 0).positions[1], DVec3::X);
}

#[test]
fn instances_of_an_extension() {
    let more = [1.0, 0.0, 0.0, 2.0, 0.0, 0.0];
    let places = super::accessor(5126, 2, "VEC3");
    let nodes = "\"nodes\":[{\"name\":\"tree\",\"mesh\":0,\"extensions\":\
        {\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":1}}}}],";
    let scene = read(&triangle(&more, &places, &format!("{nodes}{MESH}")), &[]);
    let placed = scene.objects.iter().map(|o| o.shape.placed_mesh().unwrap());
    let places: Vec<f64> = placed.map(|mesh| mesh.position(0).x).collect();
    assert_eq!(places, [1.0, 2.0]);
    assert_eq!(scene.shared_meshes().len(), 1);
    let damaged = triangle(&[], &instances_out_of_range(), &format!("{nodes}{MESH}"));
    let scene = read(&damaged, &["instances left out"]);
    assert_eq!(scene.objects.len(), 1);
}

fn instances_out_of_range() -> String {
    super::accessor(5126, 2, "VEC3")
}

#[test]
fn hidden_and_lost_nodes() {
    let nodes = "\"nodes\":[{\"mesh\":0,\"extensions\":{\"KHR_node_visibility\":{\"visible\":false}}},\
        {\"mesh\":0,\"scale\":[1e39,1,1],\"children\":[2]},{\"mesh\":0},{\"mesh\":0}],";
    let file = triangle(&[], "", &format!("{nodes}{MESH}"));
    let scene = read(&file, &["hidden node", "node with an unusable transform"]);
    assert_eq!(scene.objects.len(), 1);
}

#[test]
fn buffers_beside_the_model() {
    let positions: Vec<u8> = [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .flat_map(|f| f.to_le_bytes())
        .collect();
    let rest = format!(
        "\"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\
         \"min\":[0,0,0],\"max\":[1,1,0]}}],\"nodes\":[{{\"mesh\":0}}],{MESH}"
    );
    let text = json(&format!(
        "\"buffers\":[{{\"byteLength\":36,\"uri\":\"a%20b.bin\"}}],{rest}"
    ));
    let files = Memory::new().with("a b.bin", positions.clone());
    let options = ReadOptions::default();
    let loaded_text = gltf::read(text.as_bytes(), "a.gltf", &files, &options).unwrap();
    let text = json(&format!("\"buffers\":[{{\"byteLength\":36}}],{rest}"));
    let glb = glb_of(&[(b"JSON", text.as_bytes()), (b"BIN\0", &positions)]);
    assert_eq!(loaded(&glb).scene, loaded_text.scene);
    let tight = ReadOptions {
        most_unpacked: 35,
        ..options
    };
    let text = json(&format!(
        "\"buffers\":[{{\"byteLength\":36,\"uri\":\"a%20b.bin\"}}],{rest}"
    ));
    let error = gltf::read(text.as_bytes(), "a.gltf", &files, &tight).unwrap_err();
    assert!(error.to_string().contains("larger than allowed"), "{error}");
}

fn lights(kind: &str) -> String {
    json(&format!(
        "\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{{\"KHR_lights_punctual\":\
         {{\"lights\":[{{\"name\":\"lamp\",\"color\":[1,0.5,0],\"intensity\":8,{kind}}}]}}}},\
         \"nodes\":[{{\"translation\":[1,2,3],\"rotation\":[-0.7071067811865476,0,0,0.7071067811865476],\
         \"scale\":[2,2,2],\
         \"extensions\":{{\"KHR_lights_punctual\":{{\"light\":0}}}}}}]"
    ))
}

#[test]
fn lights_are_photometric() {
    let check = |kind: &str, more: &[&str]| {
        let warnings: Vec<&str> = more.iter().copied().chain(["is empty"]).collect();
        let scene = read(&lights(kind), &warnings);
        assert_eq!(scene.lights[0].name, "lamp");
        scene.lights[0].kind.clone()
    };
    let at = DVec3::new(1.0, 2.0, 3.0);
    let colour = Rgb::new(8.0, 4.0, 0.0);
    match check("\"type\":\"point\",\"range\":5", &["range of a light"]) {
        LightKind::Point {
            position,
            intensity,
        } => assert_eq!((position, intensity), (at, colour)),
        other => panic!("{other:?}"),
    }
    match check(
        "\"type\":\"spot\",\"spot\":{\"innerConeAngle\":0.25,\"outerConeAngle\":0.5}",
        &[],
    ) {
        LightKind::Spot {
            direction,
            inner,
            outer,
            ..
        } => {
            assert!((direction - DVec3::NEG_Y).length() < 1e-7, "{direction}");
            assert_eq!((inner, outer), (0.25, 0.5));
        }
        other => panic!("{other:?}"),
    }
    match check("\"type\":\"directional\"", &[]) {
        LightKind::Directional { irradiance, .. } => assert_eq!(irradiance, colour),
        other => panic!("{other:?}"),
    }
}

#[test]
fn cameras() {
    let camera = |kind: &str| {
        json(&format!(
            "\"cameras\":[{{\"name\":\"eye\",{kind}}}],\
             \"nodes\":[{{\"camera\":0,\"translation\":[1,2,3]}}]"
        ))
    };
    let perspective = |fov: &str| {
        camera(&format!(
            "\"type\":\"perspective\",\"perspective\":{{\"yfov\":{fov},\"znear\":0.1}}"
        ))
    };
    let scene = read(&perspective("0.5"), &["is empty"]);
    let view = &scene.cameras[0];
    assert_eq!((view.name.as_str(), view.vertical_fov), ("eye", 0.5));
    assert_eq!(view.eye, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(view.axes(), (DVec3::X, DVec3::Y, DVec3::NEG_Z));
    read(&perspective("4"), &["without a usable view", "is empty"]);
    let flat = "\"type\":\"orthographic\",\
        \"orthographic\":{\"xmag\":1,\"ymag\":1,\"znear\":0,\"zfar\":1}";
    read(&camera(flat), &["orthographic camera: skipped", "is empty"]);
}

/// Image-based light: uniform by its coefficients, otherwise by its cube map, or else by what the
/// coefficients describe.
#[test]
fn image_based_light() {
    let scene = |light: &str, images: &str| {
        let more = format!(
            "\"extensionsUsed\":[\"EXT_lights_image_based\"],\"extensions\":\
             {{\"EXT_lights_image_based\":{{\"lights\":[{light}]}}}},\"scene\":0,\"scenes\":\
             [{{\"nodes\":[0],\"extensions\":{{\"EXT_lights_image_based\":{{\"light\":0}}}}}}],\
             {images}\"nodes\":[{{\"mesh\":0}}],"
        );
        read(&triangle(&[], "", &format!("{more}{MESH}")), &[])
    };
    let coefficients = |first: f64, up: f64| {
        let list: Vec<[f64; 3]> = (0..9)
            .map(|k| match k {
                0 => [first; 3],
                1 => [up; 3],
                _ => [0.0; 3],
            })
            .collect();
        format!("{list:?}")
    };
    let constant = 0.282_094_791_773_878_14;
    let uniform = format!(
        "{{\"intensity\":2,\"irradianceCoefficients\":{}}}",
        coefficients(std::f64::consts::PI / constant, 0.0)
    );
    let LightKind::Ambient { radiance } = scene(&uniform, "").lights[0].kind else {
        panic!("the same from everywhere")
    };
    assert!((radiance - Rgb::grey(2.0)).map(f64::abs).max_channel() < 1e-12);
    // Brighter above, by bands: L = c₀ Y₀₀ / π + c₁ Y₁₋₁ 3 / 2π, where Y₁₋₁ = −y for Babylon.js.
    let smooth = format!("{{\"irradianceCoefficients\":{}}}", coefficients(9.0, -3.0));
    let scene = scene(&smooth, "");
    let LightKind::Environment(sky) = scene.lights[0].kind else {
        panic!("it is brighter above")
    };
    let image = scene.textures[0].image.as_ref();
    let truth = 9.0 * constant / std::f64::consts::PI + 3.0 * 0.4886 * 1.5 / std::f64::consts::PI;
    let above = sky.radiance(DVec3::new(0.01, 1.0, 0.01).normalize(), image);
    assert!((above.g - truth).abs() < 0.01 * truth, "{above:?}, {truth}");
    assert!(sky.radiance(DVec3::NEG_Y, image).g < above.g);
}

/// Channels of `KHR_animation_pointer` have no node.
#[test]
fn animated_pointers() {
    let animation = "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"path\":\"pointer\",\
                     \"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"/materials/0/x\"}}}}],\
                     \"samplers\":[{\"input\":0,\"output\":0}]}],\
                     \"extensionsUsed\":[\"KHR_animation_pointer\"],";
    let file = triangle(&[], "", &one_mesh("{\"attributes\":{\"POSITION\":0}}"));
    let file = file.replace("\"nodes\":", &format!("{animation}\"nodes\":"));
    let scene = read(&file, &["animations: not used"]);
    assert_eq!(scene.objects.len(), 1);
}
