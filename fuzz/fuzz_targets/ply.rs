//! Any bytes as PLY: what is read must be valid, and its shapes must be the same after writing
//! and reading, but for normals and irradiance, which are rounded.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, ply};
use azulejo_scene::{Mesh, Scene, Shape};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions::in_proportion(bytes.len());
    let files = Memory::new();
    let Ok(loaded) = ply::read(bytes, "fuzz.ply", &files, &options) else {
        return;
    };
    loaded
        .scene
        .validate()
        .expect("a reader gives valid scenes");
    if !ply::losses(&loaded.scene).is_empty() {
        return;
    }
    let mut again = Vec::new();
    ply::write(&loaded.scene, &mut again).expect("memory takes everything");
    let read = ply::read(&again, "again.ply", &files, &options).expect("what is written is read");
    read.scene.validate().expect("a reader gives valid scenes");
    for (before, after) in std::iter::zip(meshes(&loaded.scene), meshes(&read.scene)) {
        assert_eq!(before.positions, after.positions);
        assert_eq!(before.faces, after.faces);
        assert_eq!(before.colors, after.colors);
        assert_eq!(before.irradiance.len(), after.irradiance.len());
    }
    assert_eq!(loaded.scene.objects.len(), read.scene.objects.len());
});

fn meshes(scene: &Scene) -> impl Iterator<Item = &Mesh> {
    scene.objects.iter().filter_map(|o| match &o.shape {
        Shape::Mesh(mesh) => Some(mesh),
        _ => None,
    })
}
