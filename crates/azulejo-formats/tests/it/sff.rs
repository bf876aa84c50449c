//! RTRACE's own scenes, with the files that they name.

use crate::data;
use azulejo_formats::{Loaded, Memory, read};
use azulejo_scene::{Operation, PrimitiveKind, Scene, Shape, Solid};
use std::path::Path;

/// The stock files under the names that the scenes have for them.
fn stock(folder: &Path) -> Memory {
    let file = |name: &str| std::fs::read(folder.join(name)).expect("a stock file");
    Memory::new()
        .with("Font_exemplo.ppf", file("fonts/bangkok.ppf"))
        .with("zurichcg.ppf", file("fonts/zurichcg.ppf"))
        .with("renfrew.ppf", file("fonts/renfrew.ppf"))
        .with("encoding_ascii.ppe", file("encodings/encoding_ascii.ppe"))
        .with("abc.ppe", file("encodings/ascii.ppe"))
        .with("csg.t3d", file("scenes/csg.t3d"))
}

fn load(folder: &Path, path: &str) -> Loaded {
    let bytes = std::fs::read(folder.join(path)).expect("a stock scene");
    let name = path.rsplit('/').next().unwrap_or(path);
    let loaded = read(&bytes, name, &stock(folder)).unwrap_or_else(|e| panic!("{e}"));
    loaded.scene.validate().expect("a valid scene");
    loaded
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.objects.iter().map(|o| &*o.name).collect()
}

#[test]
fn scenes_of_the_manuals() {
    let Some(data) = data() else { return };
    let folder = data.join("corpus/sff");
    let check = |path: &str, expected: &[&str]| {
        let loaded = load(&folder, path);
        assert_eq!(names(&loaded.scene), expected, "{path}");
        loaded.scene
    };
    let demo = check("scenes/demo.sff", &["mesh 1", "box 1", "box 2", "sphere 1"]);
    let rtrace = demo.rtrace.expect("RTRACE's numbers");
    let textures = rtrace.materials.iter().map(|m| m.section_textures.len());
    assert_eq!(textures.collect::<Vec<_>>(), [1, 1, 0, 1]);
    check("scenes/exemplo1.sff", &["text 1", "mesh 1"]);
    let simple = ["sphere 1", "sphere 2", "box 1", "tube 1", "tube 2", "csg 1"];
    check("expected_sff/example1.sff", &simple);
}

#[test]
fn set_operations_of_the_manual() {
    let Some(data) = data() else { return };
    let scene = load(&data.join("corpus/sff"), "expected_sff/csgdemo.sff").scene;
    assert_eq!(names(&scene), ["csg 1", "text 1"]);
    let Shape::Exact(csg) = &scene.objects[0].shape else {
        panic!("a set operation is exact");
    };
    let [Solid::Csg(outer)] = &*csg.solids else {
        panic!("one set operation");
    };
    assert_eq!(
        (outer.operation, outer.right.len()),
        (Operation::Difference, 4)
    );
    let [Solid::Csg(inner)] = &*outer.left else {
        panic!("another on its left");
    };
    // A side and two discs are a cylinder.
    let Solid::Primitive(cylinder) = &inner.right[1] else {
        panic!("a list that is closed");
    };
    assert_eq!(cylinder.kind, PrimitiveKind::Cylinder);
    let Shape::Exact(text) = &scene.objects[1].shape else {
        panic!("text is exact");
    };
    // Blanks leave nothing, and /copyright/ is one glyph.
    assert_eq!(
        text.solids.len(),
        "AntonioCosta".len() + "c1992".len() + "INESCn".len()
    );
}
