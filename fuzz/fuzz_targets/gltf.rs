//! Any bytes as glTF: what is read must be valid, and its objects must be the same after writing
//! and reading, once their numbers are in single precision.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, gltf};
use azulejo_scene::Scene;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    let files = Memory::new().with("a.bin", bytes);
    if let Ok(loaded) = gltf::read(bytes, "fuzz.gltf", &files, &options) {
        loaded
            .scene
            .validate()
            .expect("a reader gives valid scenes");
        let mut scene = loaded.scene;
        // Packing pictures takes most of the time and is tried elsewhere.
        scene.textures.iter_mut().for_each(|t| t.image = None);
        let once = round(&scene);
        assert_eq!(round(&once).objects, once.objects);
    }
});

/// The scene that is written and read.
fn round(scene: &Scene) -> Scene {
    let mut file = Vec::new();
    gltf::write(scene, &mut file).expect("memory takes everything");
    let read = gltf::read(&file, "again.glb", &Memory::new(), &ReadOptions::default());
    let again = read.expect("what is written is read").scene;
    again.validate().expect("a reader gives valid scenes");
    again
}
