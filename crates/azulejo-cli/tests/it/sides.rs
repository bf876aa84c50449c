//! `--sides` of `solve`: which side's irradiance reaches the files.

use crate::support::Folder;
use serde_json::Value;

/// A sheet that faces up, a lamp above it, and one of three times its radiance below.
const SHEET: &str = "\
mtllib sheet.mtl
v 0 0 0
v 0 0 2
v 2 0 2
v 2 0 0
v 0.8 1 0.8
v 1.2 1 0.8
v 1.2 1 1.2
v 0.8 1 1.2
v 0.8 -1 0.8
v 0.8 -1 1.2
v 1.2 -1 1.2
v 1.2 -1 0.8
o sheet
usemtl grey
f 1 2 3 4
o above
usemtl weak
f 5 6 7 8
o below
usemtl strong
f 9 10 11 12
";

const MATERIALS: &str = "\
newmtl grey
Kd 0.5 0.5 0.5
newmtl weak
Kd 0 0 0
Ke 10 10 10
newmtl strong
Kd 0 0 0
Ke 30 30 30
";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("sheet.obj", SHEET);
    folder.write("sheet.mtl", MATERIALS);
    folder
}

/// Solves into a file.
fn solve(folder: &Folder, sides: &str, output: &str) -> Value {
    folder.json(&format!(
        "solve sheet.obj --patches 200 --rays 64 --sides {sides} -o {output}"
    ))
}

/// Largest irradiance on the sheet, the first mesh of the file, and the corners of its first face.
fn stored(sides: &str) -> (f64, String) {
    let folder = folder();
    let report = solve(&folder, sides, "out.grf");
    assert!(report["error"].as_f64().unwrap() < 0.2, "{report}");
    let text = String::from_utf8(folder.read("out.grf")).unwrap();
    let sheet = text.split("end mesh").next().unwrap();
    let vertices = sheet.lines().filter_map(|l| l.strip_prefix("irad ("));
    let values = vertices.filter_map(|l| l.split([',', ')']).next()?.parse().ok());
    let first = sheet.lines().skip_while(|l| *l != "begin faces").nth(1);
    (values.fold(0.0, f64::max), first.unwrap().to_owned())
}

#[test]
fn front_is_what_is_stored_even_if_it_is_darker() {
    let (front, brighter) = (stored("front"), stored("brighter"));
    let [(dark, corners), (bright, turned)] = [front, brighter];
    assert!(
        (bright / dark - 3.0).abs() < 0.05,
        "{dark} in front, {bright} behind, of lamps of 10 and 30"
    );
    assert_ne!(corners, turned, "the brighter side is made the front");
}

#[test]
fn split_sheets_are_written_twice() {
    let (front, split) = (stored("front"), stored("split"));
    assert!(
        (split.0 / front.0 - 3.0).abs() < 0.05,
        "{split:?} beside {front:?}"
    );
    let folder = folder();
    let faces = |sides: &str| {
        solve(&folder, sides, "out.ply");
        let bytes = folder.read("out.ply");
        let header = String::from_utf8_lossy(&bytes[..bytes.len().min(2000)]).into_owned();
        let count = header.lines().find_map(|l| l.strip_prefix("element face "));
        count.unwrap().parse::<usize>().unwrap()
    };
    let (one, both) = (faces("front"), faces("split"));
    // The sheet is most of it; lamps are not sheets that light from both sides reaches.
    assert!(both > one + one / 2 && both <= 2 * one, "{one} and {both}");
    // What reads them again joins them.
    let info = folder.json("info out.ply");
    assert_eq!(info["faces"].as_u64().unwrap() as usize, one);
}

#[test]
fn split_gltf_shows_each_copy_from_its_own_side() {
    let folder = folder();
    let gltf = |sides: &str| -> Value {
        solve(&folder, sides, "out.glb");
        let bytes = folder.read("out.glb");
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        serde_json::from_slice(&bytes[20..20 + length]).unwrap()
    };
    let vertices = |gltf: &Value| -> u64 {
        let accessors = gltf["accessors"].as_array().unwrap();
        let positions = accessors.iter().filter(|a| a["min"].is_array());
        positions.map(|a| a["count"].as_u64().unwrap()).sum()
    };
    let (one, both) = (gltf("front"), gltf("split"));
    let (few, many) = (vertices(&one), vertices(&both));
    assert!(many > few + few / 2, "{few} and {many} vertices");
    let materials = both["materials"].as_array().unwrap();
    assert!(
        materials.iter().all(|m| m["doubleSided"] != true),
        "{materials:?}"
    );
}

#[test]
fn formats_without_irradiance_are_refused_before_the_work() {
    let folder = folder();
    for sides in ["front", "brighter", "split"] {
        let line = format!("solve sheet.obj --sides {sides} -o out.obj");
        folder.fails(&line, 2, "OBJ cannot store irradiance");
    }
    folder.fails("solve sheet.obj --sides back -o out.grf", 2, "--sides");
    assert_eq!(folder.names(), ["sheet.mtl", "sheet.obj"]);
}
