//! Recipes: what is added to a model each time it is read.

use crate::support::Folder;

const MODEL: &str = "mtllib m.mtl\no room/floor\nv 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nusemtl tiles\nf 4 3 2 1\n\
    o room/lamp_1\nv 1 3 1\nv 2 3 1\nv 2 3 3\nv 1 3 3\nusemtl paint\nf 1 2 3 4\nf 5 6 7 8\n";
const MATERIALS: &str = "newmtl tiles\nKd 0.5 0.5 0.5\nnewmtl paint\nKd 0.8 0.8 0.8\n";
const RECIPE: &str = r#"
background = [0.1, 0.2, 0.3]

[[material]]
name = ["tile*", "stone"]
brdf = "ward kd=0.3 ks=0.1 ax=0.2 ay=0.2"

[[object]]
name = "*lamp?1"
diffuse = 0
lumens = 1790
temperature = 2700

[[light]]
name = "bulb"
kind = "point"
position = [2, 2, 2]
lumens = 179

[[camera]]
name = "door"
eye = [2, 1.6, 6]
target = [2, 1, 0]
up = [0, 1, 0]
fov = 60
size = [64, 48]

[fog]
color = 0.5
visibility = 100
"#;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("room.obj", MODEL);
    folder.write("m.mtl", MATERIALS);
    folder.write("studio.toml", RECIPE);
    folder
}

fn grf(folder: &Folder, options: &str) -> String {
    folder.ok(&format!("convert room.obj -o - {options}")).out
}

#[test]
fn a_recipe_enriches_a_model() {
    let folder = folder();
    let before = grf(&folder, "");
    let text = grf(&folder, "--recipe studio.toml");
    assert!(
        !before.contains("ward") && text.contains("def tiles = brdf ward kd = "),
        "{text}"
    );
    assert!(
        text.contains("ext background begin color = (0.1, 0.2, 0.3) end ext"),
        "{text}"
    );
    assert!(
        text.contains("ext light begin name = \"bulb\" kind = point position = (2, 2, 2)"),
        "{text}"
    );
    assert!(
        text.contains("name = \"door\"") && text.contains("ext fog begin"),
        "{text}"
    );
    let info = folder.json("info room.obj --recipe studio.toml");
    assert_eq!(info["cameras"].as_array().map(Vec::len), Some(1), "{info}");
    // 1790 lm are 10 W of luminance, of a warm colour, over all faces of the object.
    let lamp = text.lines().find(|l| l.starts_with("rgb (")).unwrap();
    let numbers: Vec<f64> = lamp
        .trim_start_matches("rgb (")
        .trim_end_matches(')')
        .split(", ")
        .map(|x| x.parse().unwrap())
        .collect();
    let luminance = 0.2126 * numbers[0] + 0.7152 * numbers[1] + 0.0722 * numbers[2];
    let area = 16.0 + 2.0;
    assert!(
        (luminance * std::f64::consts::PI * area / 10.0 - 1.0).abs() < 1e-3,
        "{lamp}"
    );
    assert!(numbers[0] > 2.0 * numbers[2], "{lamp}");
    // Nothing shines without it.
    folder.ok("solve room.obj --recipe studio.toml -o lit.grf --rays 16");
    folder.fails("solve room.obj -o dark.grf --rays 16", 1, "");
}

#[test]
fn mistakes_have_a_place() {
    let folder = folder();
    let check = |recipe: &str, expected: &str| {
        folder.write("r.toml", recipe);
        folder.fails("convert room.obj -o - --recipe r.toml", 1, expected);
    };
    check(
        "\n[[material]]\nnam = \"a\"",
        "r.toml:3:1: unknown field `nam`, did you mean `name`?",
    );
    check("[[material]]\nname = \"a[\"\ndiffuse = 1", "r.toml:2:8: ");
    check(
        "[[material]]\nname = \"a\"",
        "r.toml:2:8: a rule that changes nothing",
    );
    check(
        "[[material]]\nname = \"a\"\ndiffuse = 1.5",
        "r.toml:3:11: a reflectance is at most 1",
    );
    check(
        "[[material]]\nname = \"a\"\nemission = [1, -1, 0]",
        "r.toml:3:12: colours are finite and not negative",
    );
    check(
        "[[material]]\nname = \"a\"\nlumens = 3",
        "r.toml:2:8: `lumens` is the light of an object",
    );
    check(
        "[[object]]\nname = \"a\"\ntemperature = 3000",
        "`temperature` is the colour of `lumens`",
    );
    check("[[object]]\nname = \"*\"\nlumens = -3", "must be above 0");
    check(
        "[[material]]\nname = \"a\"\nbrdf = \"wart kd=1\"",
        "r.toml:3:8: ",
    );
    check(
        "[[material]]\nname = \"a\"\nbrdf = \"lewis kd=0.1 ks=0.1 n=9\"\nmirror = 1",
        "says all of the reflection",
    );
    check(
        "[[material]]\nname = \"a\"\nthin = true\nmirror = 1",
        "`thin` belongs to `glass`",
    );
    check(
        "[[light]]\nkind = \"star\"\nintensity = 1",
        "r.toml:1:1: kind: expected point, spot, directional or luminaire",
    );
    check(
        "[[light]]\nkind = \"point\"\nintensity = 1",
        "needs a `position`",
    );
    check(
        "[[light]]\nkind = \"point\"\nposition = [0, 0, 0]",
        "either `intensity` or `lumens`",
    );
    check(
        "[[camera]]\neye = [0, 0, 0]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nfov = 50",
        "sees nothing",
    );
    check(
        "background = \"blue\"",
        "expected a number, or [red, green, blue]",
    );
    check("not toml", "r.toml:1:5");
    folder.fails("convert room.obj -o - --recipe none.toml", 1, "none.toml");
}

#[test]
fn rules_that_match_nothing_are_said() {
    let folder = folder();
    folder.write("r.toml", "[[material]]\nname = \"til*\"\nglass = 1.5\n\n[[object]]\nname = [\"chair*\", \"sofa\"]\nmirror = 0.9\n");
    let run = folder.ok("convert room.obj -o a.grf --recipe r.toml");
    let expected = "warning: r.toml:6:8: the rule \"chair*\", \"sofa\" matches no object";
    assert!(run.err.contains(expected), "{}", run.err);
    let text = String::from_utf8(folder.read("a.grf")).unwrap();
    assert!(text.contains("ior = 1.5"), "{text}");
    folder.fails(
        "convert room.obj -o a.grf --recipe r.toml --strict",
        1,
        "matches no object",
    );
    folder.write("s.grf", ";");
    folder.fails("solve s.grf --in-place --recipe r.toml", 2, "--recipe");
}
