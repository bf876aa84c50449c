//! Small scenes, and what becomes of them.

use crate::{Memory, ReadOptions, sff};
use azulejo_scene::{Scene, Shape};

const HEAD: &str = "view\n0 0 10\n0 0 0\n0 1 0\n30 20\ncolors\n.1 .2 .3\n.1 .1 .1\nlights\n1 0 9 0 1 1 1\n\nsurfaces\n1 1 .5 .2 .8 .8 .8 .1 .1 .1 30 0 0 0 0\n2 1 1 1 .5 .5 .5 0 0 0 0 0 0\n\nobjects\n";

fn read(objects: &str) -> Result<Scene, String> {
    let text = format!("{HEAD}{objects}");
    let loaded = sff::read(
        text.as_bytes(),
        "a.sff",
        &Memory::new(),
        &ReadOptions::default(),
    );
    loaded.map(|l| l.scene).map_err(|e| e.to_string())
}

#[test]
fn spheres_are_counted() {
    let scene = read("1 1 1 0 0 0 1\n1 2 1.5 2 0 0 1 - remark\n# a remark\n1 1 1 0 3 0 1").unwrap();
    assert_eq!((scene.objects.len(), scene.materials.len()), (3, 2));
    assert!(matches!(&scene.objects[2].shape, Shape::Primitive(_)));
}
