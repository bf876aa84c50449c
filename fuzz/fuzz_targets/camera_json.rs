//! Any bytes as a camera file: what is read must make a valid scene.
#![no_main]

use azulejo_formats::camera_json;
use azulejo_scene::Scene;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut scene = Scene::default();
    if let Ok(camera) = camera_json::read(bytes, "fuzz.json") {
        scene.cameras.push(camera);
    }
    if let Ok(lights) = camera_json::read_lights(bytes, "fuzz.json") {
        scene.lights = lights;
    }
    scene.validate().expect("a reader gives valid scenes");
});
