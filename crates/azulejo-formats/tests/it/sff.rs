//! RTRACE's own scenes, with the files that they refer to.

use azulejo_formats::{Memory, RecognizedModel, read, sff};
use azulejo_scene::{Operation, PrimitiveKind, Scene, Shape, Solid};
use azulejo_testing::data;
use std::path::Path;

/// The stock files, under the names used in the scenes.
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

fn load(folder: &Path, path: &str) -> RecognizedModel {
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
    // A lateral surface and two discs form a cylinder.
    let Solid::Primitive(cylinder) = &inner.right[1] else {
        panic!("a list that is closed");
    };
    assert_eq!(cylinder.kind, PrimitiveKind::Cylinder);
    let Shape::Exact(text) = &scene.objects[1].shape else {
        panic!("text is exact");
    };
    // Blanks have no outline, and /copyright/ is one glyph.
    assert_eq!(
        text.solids.len(),
        "AntonioCosta".len() + "c1992".len() + "INESCn".len()
    );
}

/// SCN is equivalent to its translation by the original.
#[test]
fn both_languages_mean_the_same() {
    let Some(data) = data() else { return };
    let folder = data.join("corpus/sff");
    for name in ["example1", "csgdemo"] {
        let scn = load(&folder, &format!("scenes/{name}.scn")).scene;
        let sff = load(&folder, &format!("expected_sff/{name}.sff")).scene;
        assert_eq!(names(&scn), names(&sff), "{name}");
        assert_eq!(
            (scn.materials.len(), scn.lights.len()),
            (sff.materials.len(), 2)
        );
        let (a, b) = (scn.bounds(), sff.bounds());
        assert!(
            a.min.distance(b.min) + a.max.distance(b.max) < 1e-5,
            "{name}"
        );
        let surfaces = |scene: Scene| scene.rtrace.expect("RTRACE's numbers").surfaces;
        let flags = |s: Vec<azulejo_scene::rtrace::RtraceSurface>| {
            s.iter()
                .map(|s| (s.is_emitter, s.is_unshadowed))
                .collect::<Vec<_>>()
        };
        assert_eq!(flags(surfaces(scn)), flags(surfaces(sff)), "{name}");
    }
}

/// Stock scenes are preserved by writing and reading, prisms up to rounding.
#[test]
fn stock_scenes_are_written_and_read_again() {
    let Some(data) = data() else { return };
    let folder = data.join("corpus/sff");
    for path in [
        "scenes/demo.sff",
        "scenes/exemplo1.sff",
        "scenes/example1.scn",
        "scenes/csgdemo.scn",
    ] {
        let scene = load(&folder, path).scene;
        assert_eq!(sff::losses(&scene), Vec::<String>::new(), "{path}");
        let mut text = Vec::new();
        let beside = sff::write(&scene, "again", &mut text).expect("memory takes everything");
        let files = beside
            .into_iter()
            .fold(Memory::new(), |f, (n, b)| f.with(n, b));
        let again = read(&text, "again.sff", &files).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(again.scene.rtrace, scene.rtrace, "{path}");
        assert_eq!(again.scene.lights, scene.lights, "{path}");
        assert_eq!(again.scene.materials, scene.materials, "{path}");
        assert_eq!(names(&again.scene), names(&scene), "{path}");
        for (a, b) in again.scene.objects.iter().zip(&scene.objects) {
            match (&a.shape, &b.shape) {
                (Shape::Exact(a), Shape::Exact(b)) if matches!(b.solids[0], Solid::Prism(_)) => {
                    assert_eq!(a.solids.len(), b.solids.len());
                    let (a, b) = (a.bounds(), b.bounds());
                    assert!(a.min.distance(b.min) + a.max.distance(b.max) < 1e-12);
                }
                (a, b) => assert_eq!(a, b, "{path}"),
            }
        }
    }
}
