//! Whatever the input is: a clear message, the right exit code, no panic.

use crate::support::Folder;
use serde_json::{Value, json};

/// A GRF triangle with holes for whatever should be wrong.
fn triangle(vertex: &str, face: &str) -> String {
    format!(
        "begin mesh\nbegin vertices\n(0, 0, 0)\n(1, 0, 0)\n{vertex}\nend vertices\n\
         begin faces\n{face}\nend faces\nend mesh\n"
    )
}

#[test]
fn files_that_are_no_models() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("folder")).unwrap();
    folder.write("empty.grf", "");
    folder.write("binary.grf", [0u8, 255, 3, 200, 7, 0, 0, 9].repeat(100));
    folder.write("empty.obj", "");
    for (name, expected) in [
        ("folder", "is a folder"),
        ("missing.grf", "No such file"),
        ("empty.grf", "empty"),
        ("binary.grf", "binary.grf"),
        ("empty.obj", "empty"),
    ] {
        folder.fails(&format!("info {name}"), 1, expected);
        folder.fails(&format!("convert {name} -o out.grf"), 1, expected);
    }
    assert!(!folder.names().contains(&"out.grf".to_owned()));
}

#[test]
fn models_that_are_wrong_say_where() {
    let folder = Folder::new();
    let check = |name: &str, content: &str, expected: &str| {
        folder.write(name, content);
        folder.fails(&format!("info {name}"), 1, expected);
    };
    check(
        "index.grf",
        &triangle("(0, 1, 0)", "(0, 1, 7)"),
        "index.grf:8",
    );
    check(
        "nan.grf",
        &triangle("(0, nan, 0)", "(0, 1, 2)"),
        "nan.grf:5",
    );
    check(
        "inf.grf",
        &triangle("(0, 1e999, 0)", "(0, 1, 2)"),
        "inf.grf:5",
    );
    check("two.grf", &triangle("(0, 1, 0)", "(0, 1)"), "two.grf:8");
    check(
        "index.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
        "index.obj:4",
    );
    check("cycle.grf", "include \"cycle.grf\"\n", "cycle");
    check("away.grf", "include \"/etc/passwd\"\n", "away.grf:1");
    let nested = "transform scale (1, 1, 1) begin\n".repeat(1_000_000);
    check("nested.grf", &nested, "nested.grf:");
}

#[test]
fn a_model_cut_anywhere_is_refused_or_read() {
    let folder = Folder::new();
    let whole = triangle("(0, 1, 0)", "(0, 1, 2)");
    for end in (0..whole.len()).step_by(7) {
        folder.write("cut.grf", &whole[..end]);
        let run = folder.run("info cut.grf");
        assert!(matches!(run.code, Some(0 | 1)), "{end}: {}", run.err);
        assert!(!run.err.contains("panicked"), "{end}: {}", run.err);
    }
}

#[test]
fn a_scene_without_light_is_not_rendered_black() {
    let folder = Folder::new();
    folder.write("dark.grf", triangle("(0, 1, 0)", "(0, 1, 2)"));
    folder.write("old.grf", "old");
    for line in [
        "solve dark.grf -o old.grf",
        "render dark.grf -o new.png",
        "render dark.grf -o old.grf.png --json",
    ] {
        folder.fails(line, 1, "light");
    }
    assert_eq!(folder.read("old.grf"), b"old");
    assert_eq!(folder.names(), ["dark.grf", "old.grf"]);
}

#[test]
fn degenerate_and_open_scenes_are_solved() {
    let folder = Folder::new();
    folder.write(
        "open.obj",
        "mtllib open.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nv 1 1 0\nv 1 1 1\n\
         v 0 1 1\nusemtl white\nf 1 4 3 2\nf 1 2 2\nf 1 1 1\nusemtl lamp\nf 5 6 7 8\n",
    );
    folder.write(
        "open.mtl",
        "newmtl white\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe 1 1 1\n",
    );
    let solved = folder.json("solve open.obj -o open.grf --patches 50 --rays 64");
    let power = |key: &str| solved[key][1].as_f64().unwrap();
    assert!(power("escaped") > 0.3 * power("emitted"), "{solved}");
}

#[test]
fn errors_are_json_for_those_who_ask() {
    let folder = Folder::new();
    let run = folder.run("info missing.grf --json");
    assert_eq!(run.code, Some(1));
    let value: Value = serde_json::from_str(&run.out).unwrap();
    assert!(value["error"].as_str().unwrap().contains("missing.grf"));
}

#[test]
fn warnings_are_said_once_and_counted() {
    let folder = Folder::new();
    folder.write(
        "a.obj",
        "mtllib lost.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    );
    let said = folder.ok("info a.obj").out;
    assert_eq!(said.matches("lost.mtl").count(), 1, "{said}");
    let said = folder.ok("convert a.obj -o a.grf").err;
    assert_eq!(said.matches("lost.mtl").count(), 1, "{said}");
    assert_eq!(folder.ok("convert a.obj -o a.grf --quiet").err, "");
    let info = folder.json("info a.obj");
    assert_eq!(info["warnings"].as_array().unwrap().len(), 1);
    assert_eq!(info["warnings"][0]["count"], json!(1));
}

#[test]
fn misuse_is_exit_code_2() {
    let folder = Folder::with_room();
    for line in [
        "",
        "paint room.obj",
        "info",
        "info room.obj --threads 0",
        "convert room.obj -o room.xyz",
        "solve room.obj -o room.obj",
        "solve room.obj -o out.grf --error 200%",
        "solve room.obj -o out.grf --patches 9 --patch-size 1",
        "render room.obj -o room.bmp",
        "render room.obj -o a.png --size 0x9",
        "render room.obj -o a.png --from 1,1,1 --at 1,1,1",
        "probe room.obj",
        "probe room.obj --points p.txt -o - --json",
        "convert room.obj -o - --json",
        "form-factors room.obj -o f.xyz",
    ] {
        folder.fails(line, 2, "");
    }
    assert_eq!(folder.names(), ["room.mtl", "room.obj"]);
}

#[test]
fn probes_that_are_wrong_say_where() {
    let folder = Folder::with_room();
    folder.write("p.txt", "1 1 1 0 1 0\n1 1 1 0 1\n");
    folder.fails("probe room.obj --points p.txt", 1, "p.txt: line 2");
    folder.write("n.txt", "1 1 1 0 0 0\n");
    folder.fails("probe room.obj --points n.txt", 1, "normal");
    folder.write("r.f32", [0u8; 33]);
    folder.fails("probe room.obj --hits r.f32", 1, "33 bytes");
    folder.write("z.f32", [0u8; 32]);
    folder.fails("probe room.obj --hits z.f32", 1, "ray 0");
    folder.fails("render room.obj -o a.png --camera nobody", 1, "nobody");
    folder.write("c.json", "{\"camera\": 3}");
    folder.fails("render room.obj -o a.png --camera c.json", 1, "c.json");
}

/// A room that was inserted many times: an answer in time in proportion to the faces, or to their pairs by formulas,
/// which is that there is none.
#[test]
fn coincident_rooms_are_named_as_what_they_are() {
    let folder = Folder::new();
    folder.write(
        "rooms.mtl",
        "newmtl white\nKd .5 .5 .5\nnewmtl lamp\nKd 0 0 0\nKe 9 9 9\n",
    );
    let (few, many) = (12, 51);
    for (rooms, engine) in [
        (few, "auto"),
        (many, "rays"),
        (many, "hemicube --patch-points 4"),
    ] {
        folder.write("rooms.obj", coincident_rooms(rooms));
        let line = format!("form-factors rooms.obj --patch-size 0 --engine {engine} -o f.npz");
        folder.fails(&line, 1, "remove duplicates");
        assert!(!folder.names().contains(&"f.npz".to_owned()), "{engine}");
    }
    // Formulas know nothing of coincident faces; rays do, and contradict them.
    folder.write("rooms.obj", coincident_rooms(few));
    folder.fails(
        "form-factors rooms.obj --patch-size 0 --engine analytic -o f.npz",
        1,
        "faces that overlap",
    );
    folder.fails(
        "solve rooms.obj --patches 500 -o out.grf",
        1,
        "faces that coincide",
    );
    assert!(!folder.names().contains(&"out.grf".to_owned()));
}

/// A room with a lamp as OBJ, the room this many times in one place.
fn coincident_rooms(rooms: usize) -> String {
    let corners = [
        "0 0 0", "4 0 0", "4 0 4", "0 0 4", "0 3 0", "4 3 0", "4 3 4", "0 3 4",
    ];
    let faces = [
        [1, 4, 3, 2],
        [5, 6, 7, 8],
        [1, 2, 6, 5],
        [4, 8, 7, 3],
        [1, 5, 8, 4],
        [2, 3, 7, 6],
    ];
    let mut obj = "v 1.5 2.9 1.5\nv 2.5 2.9 1.5\nv 2.5 2.9 2.5\nv 1.5 2.9 2.5\n\
                   mtllib rooms.mtl\nusemtl lamp\nf 1 2 3 4\nusemtl white\n"
        .to_owned();
    for room in 0..rooms {
        corners.iter().for_each(|c| obj += &format!("v {c}\n"));
        for face in faces {
            let [a, b, c, d] = face.map(|k| 4 + 8 * room + k);
            obj += &format!("f {a} {b} {c} {d}\n");
        }
    }
    obj
}

/// Triangles with vertices of their own in one place: the rays and patches of a solution are those of as
/// many triangles anywhere.
#[test]
fn coincident_triangles_cost_no_more_than_others() {
    let folder = Folder::new();
    folder.write(
        "t.mtl",
        "newmtl white\nKd .5 .5 .5\nnewmtl lamp\nKd 0 0 0\nKe 9 9 9\n",
    );
    let work = |step: f64| {
        let mut obj = "mtllib t.mtl\nv 0 3 0\nv 1 3 0\nv 1 3 1\nv 0 3 1\nusemtl lamp\nf 1 2 3 4\n\
                       usemtl white\n"
            .to_owned();
        for k in 0..2_000 {
            let x = step * f64::from(k);
            obj += &format!("v {x} 0 0\nv {x} 0 1\nv {} 0 0\nf -3 -2 -1\n", x + 1.0);
        }
        folder.write("t.obj", obj);
        let report = folder.json("solve t.obj --rays 32 --allow-imbalance -o out.grf");
        ["patches", "points", "rays"].map(|key| report[key].as_f64().unwrap())
    };
    let (together, apart) = (work(0.0), work(1.0));
    for (a, b) in together.into_iter().zip(apart) {
        assert!(a <= 1.5 * b, "{together:?} beside {apart:?}");
    }
}
