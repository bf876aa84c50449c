//! Any bytes as MTL: what is read must be valid, and must be the same after writing and reading,
//! but for names that no line can hold.
#![no_main]

use azulejo_formats::picture::png;
use azulejo_formats::{Memory, obj};
use azulejo_scene::{Material, Rgb, Scene};
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
    let (found, known) = (surfaces(&again.scene), surfaces(&loaded.scene));
    assert_eq!(found.len(), known.len());
    for (found, known) in found.iter().zip(&known) {
        assert!(
            is_rounded(found, known),
            "{found:?} is not {known:?}: {}",
            String::from_utf8_lossy(&text)
        );
    }
});

/// Whether materials are the same but for what rounding makes of the reflectance of a lobe, and of
/// what is scaled down because of it.
fn is_rounded(found: &Material, known: &Material) -> bool {
    let far = |a: Rgb, b: Rgb| (a - b).map(f64::abs).max_channel();
    let albedo = |m: &Material| m.brdf.as_ref().map_or(Rgb::BLACK, |b| b.mean_reflectance());
    let plain = |m: &Material| Material {
        diffuse: Rgb::BLACK,
        mirror: Rgb::BLACK,
        brdf: None,
        ..m.clone()
    };
    plain(found) == plain(known)
        && far(found.diffuse, known.diffuse) < 1e-2
        && far(found.mirror, known.mirror) < 1e-9
        && far(albedo(found), albedo(known)) < 1e-2
}

/// The materials without what names refer to.
fn surfaces(scene: &Scene) -> Vec<Material> {
    let surface = |m: &Material| Material {
        name: String::new(),
        textures: Vec::new(),
        ..m.clone()
    };
    scene.materials.iter().map(surface).collect()
}
