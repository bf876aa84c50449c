//! Light at the points of grids.

use crate::support::{Folder, project};
use azulejo_formats::numpy::npz::NpzReader;
use serde_json::Value;
use std::fs;
use std::io::Cursor;

/// A triangle far below everything, which hardly hides any of a sky.
const FAR: &str = "v 0 -9000 0\nv 1 -9000 0\nv 1 -9000 1\nf 1 3 2\n";

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|n| n.as_f64().unwrap())
        .collect()
}

/// A sky of radiance 2 over white ground has one coefficient, 2 √(4π), and E = 2π on all sides.
#[test]
fn an_even_sky_has_one_coefficient() {
    let folder = Folder::new();
    folder.write("far.obj", FAR);
    let grid = "probe far.obj --sky 2 --ground 1 --grid 2,3,2 --grid-box 0,0,0,2,3,2 --error 1%";
    let report = folder.json(&format!("{grid} -o v.json"));
    assert_eq!(report["probes"], 12);
    let volume: Value = serde_json::from_slice(&folder.read("v.json")).unwrap();
    assert_eq!(volume["resolution"], serde_json::json!([2, 3, 2]));
    let (coefficients, errors) = (
        numbers(&volume["coefficients"]),
        numbers(&volume["standardErrors"]),
    );
    assert_eq!([coefficients.len(), errors.len()], [12 * 27; 2]);
    for (k, (&c, &error)) in coefficients.iter().zip(&errors).enumerate() {
        let expected = if k % 27 < 3 { 7.0899 } else { 0.0 };
        assert!(
            (c - expected).abs() < 0.1 + 3.0 * error,
            "{k}: {c} ± {error}"
        );
    }
    // Ambient cubes: 2 × 6 × 6 texels of 2, 4 bytes each, at the end of the file.
    folder.ok(&format!("{grid} -o v.ktx2"));
    let file = folder.read("v.ktx2");
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
    assert_eq!([word(20), word(24), word(28)], [2, 6, 6]);
    for texel in (file.len() - 2 * 6 * 6 * 4..file.len()).step_by(4) {
        let (mantissa, exponent) = (word(texel) & 511, word(texel) >> 27);
        let red = f64::from(mantissa) * 2f64.powi(exponent as i32 - 24);
        assert!((red - 2.0).abs() < 0.1, "{red}");
    }
    folder.ok(&format!("{grid} -o v.npz"));
    let bytes = folder.read("v.npz");
    let mut archive = NpzReader::new(Cursor::new(&bytes), 1 << 20).unwrap();
    let positions = archive.array("positions").unwrap().unwrap();
    assert_eq!(positions.shape(), [2, 3, 2, 3]);
    assert_eq!(
        positions.numbers().unwrap()[..6],
        [0.5, 0.5, 0.5, 1.5, 0.5, 0.5]
    );
    assert_eq!(
        archive.array("std_error").unwrap().unwrap().shape(),
        [2, 3, 2, 9, 3]
    );
}

/// The box is where `bake` puts the model: in metres, with y up.
#[test]
fn the_box_is_in_metres() {
    let folder = Folder::new();
    let text = fs::read(project().join("examples/cornell.grf")).unwrap();
    folder.write("box.grf", text);
    folder.ok("probe box.grf --grid 1,1,1 --grid-box 50,60,70,500,400,300 -o v.json --error 50%");
    let volume: Value = serde_json::from_slice(&folder.read("v.json")).unwrap();
    let [min, max] = ["min", "max"].map(|corner| numbers(&volume[corner]));
    for (found, expected) in [(min, [0.05, 0.06, 0.07]), (max, [0.5, 0.4, 0.3])] {
        let mut pairs = found.iter().zip(expected);
        assert!(pairs.all(|(f, e)| (f - e).abs() < 1e-12), "{found:?}");
    }
}

/// Probes inside of a box have the light of those around.
#[test]
fn probes_inside_of_solids_are_filled() {
    let folder = Folder::new();
    let mut text = String::from("o box\n");
    for k in 0..8 {
        let end = |axis: u32| if k >> axis & 1 == 1 { 1.1 } else { -1.1 };
        text += &format!("v {} {} {}\n", end(0), end(1), end(2));
    }
    text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    folder.write("box.obj", text);
    // Cells of 1: those from -1 to 1 are inside.
    let line = "probe box.obj --sky 1 --grid 4,4,4 --grid-box -2,-2,-2,2,2,2 -o v.json --error 5%";
    assert_eq!(folder.json(line)["inside"], 8);
    let volume: Value = serde_json::from_slice(&folder.read("v.json")).unwrap();
    let inside = numbers(&volume["inside"]);
    assert_eq!(inside, [21.0, 22.0, 25.0, 26.0, 37.0, 38.0, 41.0, 42.0]);
    let coefficients = numbers(&volume["coefficients"]);
    assert!(
        inside
            .iter()
            .all(|&probe| coefficients[27 * probe as usize] > 1.0)
    );
}

#[test]
fn grids_that_cannot_be_are_refused() {
    let folder = Folder::new();
    folder.write("far.obj", FAR);
    for (options, code, expected) in [
        ("--grid 2,2 -o v.json", 2, "three numbers of cells"),
        ("--grid 2,0,2 -o v.json", 2, "three numbers of cells"),
        (
            "--grid 4096,4096,4096 -o v.json",
            2,
            "more than 1048576 probes",
        ),
        ("--grid 2,2,2 -o v.txt", 2, ".json, .npz or .ktx2"),
        ("--grid 2,2,2", 2, "--output"),
        ("--grid 2,2,2 -o v.json", 1, "--grid-box"),
        (
            "--grid 2,2,2 --grid-box 0,0,0,1,1,0 -o v.json",
            2,
            "without a volume",
        ),
        (
            "--grid 2,2,2 --grid-box 0,0,0,1,1 -o v.json",
            2,
            "six numbers",
        ),
        (
            "--grid 2,2,2 --grid-box 0,0,0,1,1,nan -o v.json",
            2,
            "\"nan\" is not a number",
        ),
        (
            "--grid-box 0,0,0,1,1,1 --points p.txt -o v.txt",
            2,
            "--grid",
        ),
    ] {
        folder.fails(&format!("probe far.obj --sky 1 {options}"), code, expected);
    }
    assert_eq!(folder.names(), ["far.obj"]);
}
