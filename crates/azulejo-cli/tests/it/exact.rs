//! What the commands make of exact shapes: text, set operations.

use crate::support::{Folder, project};
use serde_json::json;

/// Two letters of one figure each, one cut out of a block, under a lamp.
const SCENE: &str = "\
def clay = brdf diffuse kd = 0.5 gilt = brdf diffuse kd = (0.8, 0.6, 0.2)
begin
ext figure begin name = I
contour begin line (0, 0) line (0.2, 0) line (0.2, 1) line (0, 1) end contour
end ext
ext figure begin name = D
contour begin line (0, 0) cubic (0.2, 0) (0.8, 0) (0.8, 1) line (0.2, 1) line (0, 1) end contour
end ext
ext object begin name = \"word\" end ext
ext text begin material = gilt scale = (1, 1, 0.3) I (0, 0) D (0.4, 0) I (1.3, 0) end ext
ext object begin name = \"block\" end ext
ext csg begin operation = difference material = clay
left begin primitive begin kind = box map = 1 0 0 0 1.4 0 0 0 0.5 3 -0.2 -0.5 end primitive end left
right begin prism begin figure = D map = 1 0 0 0 1 0 0 0 -0.3 3.2 0 0.1 material = gilt end prism end right
end ext
light begin rgb (5, 5, 5) (-1, 3, 3) (4, 0, 0) (0, 1, -1) end light
";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("word.grf", format!("{SCENE}end def\n"));
    folder
}

#[test]
fn info_says_what_they_are_made_of() {
    let folder = folder();
    let info = folder.json("info word.grf");
    for (key, expected) in [
        ("objects", json!(3)),
        ("exact_shapes", json!(3)),
        ("solids", json!(5)),
        ("prisms", json!(4)),
        ("figures", json!(2)),
        ("curves", json!(8)),
        ("solved", json!(false)),
        ("warnings", json!([])),
    ] {
        assert_eq!(info[key], expected, "{key}");
    }
    let list = &info["object_list"];
    let word = "3 prisms of 2 figures, 8 curves";
    assert_eq!(
        (&list[0]["kind"], &list[0]["content"]),
        (&json!("text"), &json!(word))
    );
    let block = "1 set operation; 1 prism of 1 figure, 4 curves; 1 primitive";
    assert_eq!(
        (&list[1]["kind"], &list[1]["content"]),
        (&json!("csg"), &json!(block))
    );
    assert_eq!(
        (&list[0]["materials"], &list[1]["materials"]),
        (&json!(1), &json!(2))
    );
    // Two bars: two faces and four sides of each.
    let bars = 2.0 * (2.0 * 0.2 + 0.3 * 2.4);
    let area = list[0]["area"].as_f64().unwrap();
    assert!(area > bars + 1.0 && area < bars + 3.0, "{area}");
    let words = folder.ok("info word.grf").out;
    assert!(words.contains("4 of 2 different figures, 8 curves") && words.contains(word));
}

#[test]
fn other_formats_get_polygons_and_say_so() {
    let folder = folder();
    let area = folder.json("info word.grf")["area"].as_f64().unwrap();
    for door in ["obj", "ply", "glb"] {
        let run = folder.ok(&format!("convert word.grf -o word.{door}"));
        assert!(
            run.err.contains("2 exact shapes that become polygons"),
            "{}",
            run.err
        );
        assert!(
            run.err.contains("1 exact primitives that become"),
            "{}",
            run.err
        );
        let info = folder.json(&format!("info word.{door}"));
        let there = info["area"].as_f64().unwrap();
        assert!(
            (there / area - 1.0).abs() < 0.01,
            "{door}: {there} of {area}"
        );
        assert!(info["faces"].as_u64().unwrap() > 30);
    }
    let kept = folder.ok("convert word.grf -o again.grf");
    assert!(!kept.err.contains("does not keep"), "{}", kept.err);
    assert_eq!(folder.json("info again.grf")["figures"], json!(2));
}

#[test]
fn placed_and_merged_shapes_share_their_figures() {
    let folder = folder();
    folder.write(
        "two.grf",
        SCENE.replace("ext csg", "ext unknown") + "end def\n",
    );
    folder.ok("convert word.grf two.grf -o all.grf --place two.grf:translate=0,2,0,scale=2");
    let info = folder.json("info all.grf");
    assert_eq!((&info["prisms"], &info["figures"]), (&json!(7), &json!(4)));
    let text = String::from_utf8(folder.read("all.grf")).unwrap();
    assert_eq!(text.matches("ext figure").count(), 4);
    // Scaled after it was moved, as the placement says.
    assert!(text.contains("map = 2 0 0 0 2 0 0 0 -0.6 0 4 0 "), "{text}");
}

#[test]
fn light_stays_on_them() {
    let folder = folder();
    folder.ok("solve word.grf -o lit.grf --patches 200 --rays 32");
    let info = folder.json("info lit.grf");
    assert_eq!(
        (&info["solved"], &info["figures"]),
        (&json!(true), &json!(2))
    );
    let list = info["object_list"].as_array().unwrap();
    assert!(list.iter().all(|o| o["solved"] == json!(true)));
    folder.ok("convert lit.grf -o again.grf");
    assert_eq!(folder.read("lit.grf"), folder.read("again.grf"));
    let picture = folder.json("render lit.grf -o lit.png --size 32x24 --spp 1");
    assert_eq!(picture["solved_before"], json!(true));
}

#[test]
fn the_title_example_is_text() {
    let folder = Folder::new();
    let path = project().join("examples/title.grf");
    let info = folder.json(&format!("info {}", path.display()));
    let kinds: Vec<&str> = (info["object_list"].as_array().unwrap().iter())
        .map(|o| o["kind"].as_str().unwrap())
        .collect();
    assert!(kinds.contains(&"text"), "{kinds:?}");
}

#[test]
fn what_is_wrong_with_them_is_placed() {
    let folder = folder();
    folder.write(
        "bad.grf",
        format!("{}end def\n", SCENE.replace("D (0.4", "E (0.4")),
    );
    let said = "bad.grf:10:61: found `E`, which no `ext figure` around it makes a figure";
    folder.fails("info bad.grf", 1, said);
}
