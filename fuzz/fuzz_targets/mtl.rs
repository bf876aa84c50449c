//! Any bytes as MTL: what is read must be valid, and must be the same after writing and reading,
//! but for names that no line can hold.
#![no_main]

use azulejo_formats::{Memory, obj, png};
use azulejo_scene::{Material, Scene};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut picture = Vec::new();
    png::write(1, 1, &[1, 2, 3], &mut picture).expect("memory takes everything");
    let files = Memory::new().with("a.png", picture);
    let Ok(loaded) = obj::read_materials(bytes, "fuzz.mtl", &files) else {
        return;
    };
    loaded
        .scene
        .validate()
        .expect("a reader gives valid scenes");
    let mut text = Vec::new();
    obj::write(&loaded.scene, "m.mtl", &mut Vec::new(), &mut text)
        .expect("memory takes everything");
    let again = obj::read_materials(&text, "m.mtl", &files).expect("what is written is read");
    assert_eq!(
        surfaces(&again.scene),
        surfaces(&loaded.scene),
        "{}",
        String::from_utf8_lossy(&text)
    );
});

/// The materials without what names refer to.
fn surfaces(scene: &Scene) -> Vec<Material> {
    let surface = |m: &Material| Material {
        name: String::new(),
        textures: Vec::new(),
        ..m.clone()
    };
    scene.materials.iter().map(surface).collect()
}
