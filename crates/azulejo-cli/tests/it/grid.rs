//! A wall in the coordinates of a national grid, 5,400 km from the origin.

use crate::support::Folder;
use azulejo_formats::{Memory, read};
use azulejo_scene::math::Aabb;
use azulejo_scene::{Scene, Units, Up};
use glam::DVec3;

const CORNER: DVec3 = DVec3::new(500_000.25, 5_400_000.5, 300.125);
const SIZE: DVec3 = DVec3::new(10.0, 0.3, 3.0);

fn folder() -> Folder {
    let mut text = String::from("o wall\n");
    for k in 0..8 {
        let step = |axis: u32| f64::from(k >> axis & 1);
        let [x, y, z] = (CORNER + SIZE * DVec3::new(step(0), step(1), step(2))).to_array();
        text += &format!("v {x:.3} {y:.3} {z:.3}\n");
    }
    text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    let folder = Folder::new();
    folder.write("wall.obj", text);
    folder
}

/// The box around the wall in a file, with z up.
fn bounds(folder: &Folder, name: &str) -> Aabb {
    let found = read(&folder.read(name), name, &Memory::new()).unwrap();
    assert!(found.warnings.is_empty(), "{name}: {:?}", found.warnings);
    let Scene { units, .. } = found.scene;
    let upright = found.scene.adapted(Units { up: Up::Z, ..units });
    upright.bounds()
}

fn check(folder: &Folder, name: &str, corner: DVec3) {
    let found = bounds(folder, name);
    let off = (found.min - corner)
        .length()
        .max((found.size() - SIZE).length());
    assert!(off < 1e-6, "{name}: {found:?}");
}

#[test]
fn a_wall_keeps_its_thickness_and_its_place() {
    let folder = folder();
    folder.ok("convert wall.obj --place wall.obj:up=z -o wall.glb");
    check(&folder, "wall.glb", CORNER);
    folder.ok("solve wall.obj --place wall.obj:up=z --sky 1 --patches 50 --rays 4 -o solved.glb");
    check(&folder, "solved.glb", CORNER);
    folder.ok(
        "bake wall.obj --place wall.obj:up=z --sky 1 --size 32 --patches 50 --rays 4 -o baked.glb",
    );
    check(&folder, "baked.glb", CORNER);
    // Light goes into the file as it is.
    folder.ok("solve wall.glb --keep-mesh --sky 1 --patches 50 --rays 4 -o kept.glb");
    check(&folder, "kept.glb", CORNER);
    folder.ok("bake wall.glb --sky 1 --size 32 --patches 50 --rays 4 -o rebaked.glb");
    check(&folder, "rebaked.glb", CORNER);
}

#[test]
fn what_single_precision_loses_is_said_with_a_remedy() {
    let folder = folder();
    let run = folder.ok("convert wall.obj --place wall.obj:up=z -o wall.stl");
    let (_, advice) = run.err.split_once("--place FILE:").expect("an advice");
    let advice = advice.split(')').next().unwrap();
    assert_eq!(advice, "translate=-500005,-5400001,-302");
    let place = format!("--place wall.obj:up=z,{advice}");
    let run = folder.ok(&format!("convert wall.obj {place} -o moved.stl"));
    assert!(!run.err.contains("float32"), "{}", run.err);
    check(
        &folder,
        "moved.stl",
        CORNER - DVec3::new(500_005.0, 5_400_001.0, 302.0),
    );
}
