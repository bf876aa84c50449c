//! Several models, their places, axes and units, and what readers skip.

use crate::support::Folder;
use serde_json::{Value, json};

/// A unit square on the ground of a scene with z up, one unit a centimetre.
const TILE: &str = "ext units begin metres_per_unit = 0.01 up = z end ext
begin mesh
begin vertices (0,0,0) (1,0,0) (1,1,0) (0,1,0) end vertices
begin faces (0,1,2,3) end faces
end mesh
";

/// A post of height 2 in a file that says neither axis nor unit.
const POST: &str = "o post\nv 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4\n";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("tile.grf", TILE);
    folder.write("post.obj", POST);
    folder
}

fn box_of(info: &Value) -> [[f64; 3]; 2] {
    ["min", "max"].map(|end| [0, 1, 2].map(|k| info["bounds"][end][k].as_f64().unwrap()))
}

fn names(info: &Value) -> Vec<&str> {
    let objects = info["object_list"].as_array().unwrap();
    objects
        .iter()
        .map(|o| o["name"].as_str().unwrap())
        .collect()
}

#[test]
fn the_first_model_says_what_is_up() {
    let folder = folder();
    let info = folder.json("info tile.grf post.obj");
    assert_eq!(
        (&info["up"], &info["metres_per_unit"]),
        (&json!("z"), &json!(0.01))
    );
    assert_eq!(box_of(&info), [[0.0, 0.0, 0.0], [1.0, 1.0, 2.0]]);
    assert_eq!(names(&info), ["tile", "post/post"]);
    assert_eq!(info["format"], json!(["GRF", "Wavefront OBJ"]));
    let info = folder.json("info post.obj tile.grf");
    assert_eq!(box_of(&info), [[0.0, 0.0, -1.0], [1.0, 2.0, 0.0]]);
}

#[test]
fn the_command_line_says_better() {
    let folder = folder();
    let info = folder.json("info tile.grf --up y --unit mm");
    assert_eq!(box_of(&info), [[0.0, 0.0, -10.0], [10.0, 0.0, 0.0]]);
    let info = folder.json("info post.obj --place post.obj:up=z,unit=m --up y --unit cm");
    assert_eq!(box_of(&info), [[0.0, 0.0, -200.0], [100.0, 0.0, 0.0]]);
}

#[test]
fn models_have_places_and_branches() {
    let folder = folder();
    let line = "info tile.grf post.obj post.obj --place post.obj:translate=0,0,3,name=high \
                --place post.obj:scale=2,rotate=0,0,90,translate=10,0,0";
    let info = folder.json(line);
    assert_eq!(names(&info), ["tile", "high/post", "post 2/post"]);
    assert_eq!(box_of(&info)[1][2], 5.0);
    assert!((box_of(&info)[1][0] - 10.0).abs() < 1e-12);
    let run = folder.run("info post.obj --place pots.obj:scale=2");
    assert_eq!(run.code, Some(2), "{}", run.err);
    let run = folder.run("info post.obj --place post.obj:scale=0");
    assert_eq!(run.code, Some(2), "{}", run.err);
    let run = folder.run("info post.obj --up 0,1,1");
    assert_eq!(run.code, Some(2), "{}", run.err);
}

#[test]
fn what_is_skipped_is_listed_and_may_be_forbidden() {
    let folder = folder();
    folder.write("odd.obj", format!("{POST}wobble 1\nwobble 2\n"));
    let info = folder.ok("info odd.obj");
    assert!(
        info.out.contains("odd.obj:7:7") && info.out.contains("(2 times)"),
        "{}",
        info.out
    );
    assert_eq!(info.err, "");
    let values = folder.json("info odd.obj");
    assert_eq!(values["warnings"][0]["count"], json!(2));
    let run = folder.run("convert odd.obj -o odd.grf --strict");
    assert_eq!(run.code, Some(1));
    assert!(run.err.contains("--strict"), "{}", run.err);
    assert!(!folder.names().contains(&"odd.grf".to_owned()));
    folder.ok("convert post.obj -o post.grf --strict");
}
