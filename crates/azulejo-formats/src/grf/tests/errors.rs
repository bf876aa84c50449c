//! Error messages for invalid files.

use super::*;
use crate::FileError;
use crate::Files;

fn error_with(text: &str, files: &dyn Files) -> String {
    match read(text.as_bytes(), "test.grf", files) {
        Ok(_) => panic!("read without error: {text}"),
        Err(e) => e.to_string(),
    }
}

fn check(text: &str, expected: &str) {
    let message = error_with(text, &Memory::new());
    let first = message.lines().next().unwrap_or("");
    assert_eq!(first, expected, "{text}");
}

#[test]
fn an_error_shows_its_line() {
    let text = "begin mesh\r\n  begin vertices\r\n    (1, x, 2)\r\n";
    assert_eq!(
        error_with(text, &Memory::new()),
        "test.grf:3:9: found the word `x`, expected a number\n   |\n 3 |     (1, x, 2)\n   |         ^"
    );
    let text = "begin mesh\r begin vertices\r (1, x, 2)\r";
    assert_eq!(
        error_with(text, &Memory::new()),
        "test.grf:3:6: found the word `x`, expected a number\n   |\n 3 |  (1, x, 2)\n   |      ^"
    );
}

#[test]
fn numbers() {
    let vertex = |v: &str| format!("begin mesh begin vertices {v}");
    check(
        &vertex("(1e999, 0, 0)"),
        "test.grf:1:28: found the number `1e999`, expected a number that is not so large",
    );
    check(
        &vertex("(nan, 0, 0)"),
        "test.grf:1:28: found the word `nan`, expected a number",
    );
    check(
        &vertex("(-inf, 0, 0)"),
        "test.grf:1:28: found the number `-inf`, expected a number",
    );
    check(
        "ext background begin picture = \"a.png\" fit = wide end ext",
        "test.grf:1:46: found `wide`, expected `scaled`, `centered` or `tiled`",
    );
    check(
        "ext background begin picture = \"a.png\" fit = tiled radiance = -1 end ext",
        "test.grf:1:63: found `-1`, expected a number of at least 0",
    );
    check(&vertex("(1, 2)"), "test.grf:1:32: found `)`, expected `,`");
    check(
        &vertex("(1, 2, 3, 4)"),
        "test.grf:1:35: found `,`, expected `)`",
    );
}

#[test]
fn faces() {
    check(
        &triangle("(0, 1, 3)"),
        "test.grf:1:83: found vertex 3 of a mesh with 3 vertices, expected an index from 0 to 2",
    );
    check(
        &triangle("(0, 1)"),
        "test.grf:1:76: found a face with 2 corners, expected a face with at least 3 corners",
    );
    check(
        &triangle("2 0 1"),
        "test.grf:1:76: found a face with 2 corners, expected a face with at least 3 corners",
    );
    check(
        &triangle("(0, 1, 2.5)"),
        "test.grf:1:83: found the number `2.5`, expected the index of a vertex, an integer from 0",
    );
    check(
        &triangle("(0, 1, 99999999999)"),
        "test.grf:1:83: found the number `99999999999`, expected the index of a vertex, an integer from 0 that is not so large",
    );
}

#[test]
fn names() {
    check(
        &triangle("use color nowhere"),
        "test.grf:1:86: found `nowhere`, which no enclosing `def` defines as a color, expected a color that is defined in this block or an enclosing one",
    );
    // A definition of another type, or in another block, does not count.
    check(
        &format!(
            "def c = rgb (1,1,1) begin end def\n{}",
            triangle("use color c")
        ),
        "test.grf:2:86: found `c`, which no enclosing `def` defines as a color, expected a color that is defined in this block or an enclosing one",
    );
    check(
        &format!("def c = rgb (1,1,1) begin {} end", triangle("use brdf c")),
        "test.grf:1:111: found `c`, which no enclosing `def` defines as a brdf, expected a brdf that is defined in this block or an enclosing one",
    );
}

#[test]
fn blocks() {
    check(
        "begin mesh begin vertices end faces",
        "test.grf:1:27: found `end faces`, expected `end vertices` for the block that begins in line 1",
    );
    check(
        "transform scale (1,1,1) begin\n\n",
        "test.grf:3:1: found the end of the file, expected `end transform` for the block that begins in line 1",
    );
    check(
        "\nend mesh",
        "test.grf:2:1: found the word `end`, expected a block; no block is open that this could end",
    );
    check(
        "transform begin end",
        "test.grf:1:11: found the word `begin`, expected `scale`, `rotation`, `translation`",
    );
    check(
        "sphere (0,0,0) 1",
        "test.grf:1:1: found the word `sphere`, expected a block: `begin mesh`, `mesh light`, `light`, `include`, `transform`, `def`, `params` or `ext`",
    );
    check(
        "light begin (0,0,0) (1,0,0) (2,0,0) end",
        "test.grf:1:13: found a light without area, expected a corner and two edges that span a parallelogram",
    );
    check(
        "def a = texture \"wood.png\nbegin end",
        "test.grf:1:17: found a string that does not end on its line, expected a file name, \"in double quotes\" on one line",
    );
}

#[test]
fn extensions() {
    check(
        "ext camera begin eye = (0,0,0) up = (0,0,1) fov = 40 end ext",
        "test.grf:1:1: found `ext camera` without `target`, expected `target = ...` in it",
    );
    check(
        "ext units begin metres_per_unit = 0 end ext",
        "test.grf:1:35: found 0 metres per unit, expected a positive length",
    );
    check(
        "ext smoothing begin groups = 1 end ext",
        "test.grf:1:1: found `ext smoothing`, expected its object immediately before it",
    );
    check(
        &format!(
            "{} ext irad_error begin values = (1,1,1) end ext",
            triangle("")
        ),
        "test.grf:1:136: found `values` of 1 triple, expected 3 triples (r, g, b)",
    );
    check(
        "ext mystery begin (1, 2",
        "test.grf:1:24: found the end of the file, expected `end ext` for the block that begins in line 1",
    );
}

#[test]
fn includes() {
    let files = Memory::new()
        .with("a.grf", "\ninclude \"b.grf\"")
        .with("b.grf", "\n\n include \"a.grf\"")
        .with("bad.grf", "begin mesh use color x end mesh");
    assert_eq!(
        error_with("include \"a.grf\"", &files),
        "b.grf:3:10: found an include of \"a.grf\", which is being included already, expected includes without a cycle\n   |\n 3 |  include \"a.grf\"\n   |          ^\n  included from a.grf:2\n  included from test.grf:1"
    );
    assert_eq!(
        error_with("\ninclude \"c.grf\"", &files),
        "test.grf:2:9: found the include \"c.grf\": there is no such file, expected a file that can be read\n   |\n 2 | include \"c.grf\"\n   |         ^"
    );
    assert_eq!(
        error_with("\ninclude \"bad.grf\"", &files),
        "bad.grf:1:22: found `x`, which no enclosing `def` defines as a color, expected a color that is defined in this block or an enclosing one\n   |\n 1 | begin mesh use color x end mesh\n   |                      ^\n  included from test.grf:2"
    );
    assert!(error_with("include \"test.grf\"", &files).contains("without a cycle"));
}

#[test]
fn an_include_may_not_leave_the_folder() {
    let folder = crate::Folder::new(concat!(env!("CARGO_MANIFEST_DIR"), "/src"));
    for name in ["../Cargo.toml", "/etc/passwd", "a/../../Cargo.toml"] {
        let message = error_with(&format!("include \"{name}\""), &folder);
        assert!(
            message.contains(&FileError::Outside.to_string()),
            "{message}"
        );
    }
}
