//! OBJ scenes with known content; `tests/corpus` compares the others with other programs.

use azulejo_formats::{Folder, ReadError, RecognizedModel, camera_json};
use azulejo_scene::{LightKind, Mesh, Object, Rgb, Shape};
use azulejo_testing::data;
use std::path::Path;

fn read(path: &Path) -> Result<RecognizedModel, ReadError> {
    let bytes = std::fs::read(path).expect("a readable file");
    let name = path.file_name().expect("a file name").to_string_lossy();
    let loaded = azulejo_formats::read(&bytes, &name, &Folder::of_model(path))?;
    loaded.scene.validate().expect("a valid scene");
    Ok(loaded)
}

fn mesh(object: &Object) -> &Mesh {
    match &object.shape {
        Shape::Mesh(mesh) => mesh,
        _ => panic!("OBJ has meshes only"),
    }
}

/// Sums of vertices, faces and triangles.
fn count(loaded: &RecognizedModel) -> [usize; 3] {
    let meshes = || loaded.scene.objects.iter().map(mesh);
    [
        meshes().map(|m| m.positions.len()).sum(),
        meshes().map(|m| m.faces.len()).sum(),
        meshes().map(|m| m.faces.triangle_count()).sum(),
    ]
}

#[test]
fn cornell_boxes() {
    let Some(data) = data() else { return };
    for (name, triangles, mirrors, glasses) in
        [("s1", 38, 0, 0), ("s2", 38, 1, 0), ("s2g", 40, 1, 1)]
    {
        let loaded = read(&data.join(format!("scenes/{name}.obj"))).expect("a scene");
        assert_eq!(loaded.warnings, [], "{name}");
        assert_eq!(count(&loaded)[2], triangles, "{name}");
        let materials = &loaded.scene.materials;
        let light = materials
            .iter()
            .find(|m| m.name == "light")
            .expect("a light");
        assert_eq!(light.emission, Rgb::new(17.0, 12.0, 4.0));
        let glass = |m: &&azulejo_scene::Material| m.dielectric.is_some();
        assert_eq!(materials.iter().filter(glass).count(), glasses, "{name}");
        let mirror = |m: &&azulejo_scene::Material| m.mirror == Rgb::grey(0.9);
        assert_eq!(materials.iter().filter(mirror).count(), mirrors, "{name}");
        let json = std::fs::read(data.join(format!("scenes/{name}.json"))).expect("a file");
        let camera = camera_json::read(&json, name).expect("a camera");
        assert_eq!((camera.eye.z, camera.size), (-800.0, Some((512, 512))));
    }
}

#[test]
fn a_page_of_text_and_its_light() {
    let Some(data) = data() else { return };
    let loaded = read(&data.join("scenes/s4.obj")).expect("a scene");
    assert_eq!(loaded.warnings, []);
    assert_eq!(count(&loaded)[2], 6578);
    let json = std::fs::read(data.join("scenes/s4.json")).expect("a file");
    let lights = camera_json::read_lights(&json, "s4.json").expect("lights");
    let [light] = lights.as_slice() else {
        panic!("one light")
    };
    assert!(matches!(light.kind, LightKind::Point { intensity, .. } if intensity.b == 100.0));
}
