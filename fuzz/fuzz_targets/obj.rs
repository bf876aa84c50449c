//! Any bytes as OBJ: what is read must be valid, and must be the same after writing and reading,
//! but for names that no line can hold.
#![no_main]

use azulejo_formats::{Memory, ReadOptions, obj};
use azulejo_scene::Scene;
use libfuzzer_sys::fuzz_target;

const LIBRARY: &str = "newmtl m\nKd 0.1 0.2 0.3\nnewmtl n\nKs 1\nillum 3\nnewmtl g\nNi 1.5\nillum 7\nnewmtl t\nmap_Kd -s 2 -o 0.5 a.png\n";

fuzz_target!(|bytes: &[u8]| {
    let files = Memory::new().with("m.mtl", LIBRARY);
    // Free-form surfaces make much of little.
    let options = ReadOptions::in_proportion(bytes.len());
    let Ok(loaded) = obj::read_with(bytes, "fuzz.obj", &files, &options) else {
        return;
    };
    loaded
        .scene
        .validate()
        .expect("a reader gives valid scenes");
    assert!(obj::losses(&loaded.scene).is_empty());
    let (text, again) = round(&loaded.scene);
    let shapes = |scene: &Scene| Vec::from_iter(scene.objects.iter().map(|o| o.shape.clone()));
    assert_eq!(shapes(&again), shapes(&loaded.scene));
    let (twice, last) = round(&again);
    assert_eq!(text, twice, "{}", String::from_utf8_lossy(&text.0));
    assert_eq!(last, again);
});

/// The two files of a scene, and the scene that they make.
fn round(scene: &Scene) -> ((Vec<u8>, Vec<u8>), Scene) {
    let (mut model, mut mtl) = (Vec::new(), Vec::new());
    obj::write(scene, "m.mtl", &mut model, &mut mtl).expect("memory takes everything");
    let files = Memory::new().with("m.mtl", mtl.clone());
    let again = obj::read(&model, "again.obj", &files).expect("what is written is read");
    ((model, mtl), again.scene)
}
