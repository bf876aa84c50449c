//! Table 1 of *Wannabe Amazing* (Montes, Ureña, Revelles, Lastra, 2001): those of its models that
//! are still available must have the printed counts, and result in a GRF no larger than the
//! paper's.

use azulejo_formats::{Folder, grf, read};
use azulejo_scene::Shape;
use azulejo_testing::data;

fn check(path: &str, vertices: usize, faces: usize, kilobytes: usize) -> usize {
    let Some(data) = data() else { return 0 };
    let path = data.join("corpus").join(path);
    let bytes = std::fs::read(&path).expect("a readable file");
    let loaded = read(&bytes, "model", &Folder::of_model(&path)).expect("a model");
    let mut found = [0, 0];
    for object in &loaded.scene.objects {
        if let Shape::Mesh(mesh) = &object.shape {
            found[0] += mesh.positions.len();
            found[1] += mesh.faces.len();
        }
    }
    assert_eq!(found, [vertices, faces]);
    let mut written = Vec::new();
    grf::write(&loaded.scene, &mut written).expect("memory takes all");
    assert!(written.len() <= kilobytes * 1024, "{} bytes", written.len());
    loaded.scene.objects.len()
}

#[test]
fn galleon() {
    let objects = check("obj/java3d-examples/galleon.obj", 3459, 2384, 2758);
    assert!(objects == 133 || data().is_none(), "{objects}");
}

/// The paper also counts a dummy of the keyframer, so objects are not compared.
#[test]
fn cart_wheel() {
    check("3ds/assimp/cart_wheel.3DS", 720, 1400, 91);
}
