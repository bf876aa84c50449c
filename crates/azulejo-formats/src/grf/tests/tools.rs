//! Layout and findings.

use super::*;
use crate::grf::{formatted, lint};
use crate::reading::lexer::Lexer;

fn format_text(text: &str) -> String {
    let bytes = formatted(text.as_bytes(), "test.grf").unwrap_or_else(|e| panic!("{e}"));
    String::from_utf8(bytes).unwrap()
}

/// The tokens of a text, without comments.
fn words(text: &str) -> Vec<String> {
    let mut lexer = Lexer::new(text);
    let mut out = Vec::new();
    while lexer.peek().is_some() {
        let start = lexer.skip_blank();
        assert!(lexer.skip_any());
        out.push(text[start..lexer.pos()].to_owned());
    }
    out
}

fn comments(text: &str) -> Vec<&str> {
    let comments = text.lines().filter_map(|l| l.split_once("//"));
    comments.map(|(_, comment)| comment.trim_end()).collect()
}

/// Checks that only blanks change, and that formatting again changes nothing.
fn check_format(text: &str) -> String {
    let once = format_text(text);
    assert_eq!(words(&once), words(text), "{once}");
    assert_eq!(comments(&once), comments(text), "{once}");
    assert_eq!(format_text(&once), once);
    once
}

#[test]
fn files_get_the_canonical_layout() {
    let laid_out = check_format(
        "//head\n\n\n\n def  a=rgb(1,0 ,0)//red\nb = brdf phong n=20 ks=(.1,.1,.1) kd=0.5 begin\r\n\
         begin mesh use color a begin vertexs irad (1,2,3)(0,0,0) normal(0,0,1) (1,0,0)\n(0,1,0) end\n\
         begin faces use brdf b rgb (1, 0,0) (0,1,2) // one\n(0 ,1,2) 3 0 1 2 3 0 2 1 brdf phong n=20 ks=(1,1,1) \
         kd = 0 (2,1,0) end faces end mesh\n\n\ntransform scale(2,2,2) begin include \"a b.grf\" end transform \
         light begin rgb (1,1,1) (0,0,0) (1,0,0) (0,1,0) end light ext unit begin  what(ever\n  you like  end ext\n\
         end def",
    );
    let expected = "\
//head

def a = rgb (1, 0, 0) //red
b = brdf phong n = 20 ks = (.1, .1, .1) kd = 0.5
begin
  begin mesh
    use color a
    begin vertexs
      irad (1, 2, 3) (0, 0, 0)
      normal (0, 0, 1) (1, 0, 0)
      (0, 1, 0)
    end
    begin faces
      use brdf b
      rgb (1, 0, 0)
      (0, 1, 2) // one
      (0, 1, 2)
      3 0 1 2
      3 0 2 1
      brdf phong n = 20 ks = (1, 1, 1) kd = 0
      (2, 1, 0)
    end faces
  end mesh

  transform scale (2, 2, 2) begin
    include \"a b.grf\"
  end transform
  light begin rgb (1, 1, 1) (0, 0, 0) (1, 0, 0) (0, 1, 0) end light
  ext unit begin what(ever
  you like end ext
end def
";
    assert_eq!(laid_out, expected);
}

#[test]
fn formatting_changes_no_scene() {
    for text in [CUBE, EVERYTHING] {
        let laid_out = check_format(text);
        assert_eq!(scene(&laid_out), scene(text));
    }
    let laid_out = check_format(
        "include lamp//a.grf // not a comment before\nuse_me = 1"
            .split_once("\nuse")
            .unwrap()
            .0,
    );
    assert_eq!(laid_out, "include lamp//a.grf // not a comment before\n");
    // Names that another file defines, and textures that are not there.
    check_format(&triangle("use color elsewhere texture a(1).png"));
    // A blank of another alphabet is part of a name.
    let spaced = check_format("def a\u{a0}b = rgb (1, 0, 0)\u{c}def c=rgb(0,0,0)");
    assert_eq!(
        spaced,
        "def a\u{a0}b = rgb (1, 0, 0)\ndef c = rgb (0, 0, 0)\n"
    );
    assert_eq!(format_text(""), "");
    assert_eq!(format_text(" ; "), ";\n");
    assert!(formatted(b"begin mesh", "test.grf").is_err());
    let latin = b"// ni\xf1o\n  ;";
    assert_eq!(formatted(latin, "test.grf").unwrap(), b"// ni\xf1o\n;\n");
}

fn check_lint(text: &str, expected: &[&str]) {
    let files = Memory::new().with("part.grf", triangle("use color a"));
    let findings = lint(text.as_bytes(), "test.grf", &files);
    let messages: Vec<String> = findings.iter().map(ToString::to_string).collect();
    assert_eq!(messages, expected);
}

#[test]
fn every_rule_finds_its_fault() {
    check_lint(&triangle("rgb (0.5, 0.5, 0.5)"), &[]);
    check_lint(
        "begin mesh begin vertices (0,0,0) end",
        &[
            "test.grf:1:38: [syntax] found the end of the file, expected `end mesh` for the block that begins in line 1",
        ],
    );
    check_lint(
        "\ninclude \"nothing.grf\"",
        &[
            "test.grf:2:9: [missing-include] found the include \"nothing.grf\": there is no such file, expected a file that can be read",
        ],
    );
    check_lint(
        "def a = rgb (1, 0, 0)\ndef b = rgb (2 0, 0)\ninclude \"part.grf\"\next unknown begin end ext\n\
         begin mesh begin vertices\nnormal (0,0,2) (0,0,0) (1,0,0)\nnormal (0,0,1) (2,0,0)\n(0,1,0) (9,9,9)\n\
         end begin faces\n(0,1,2)\n(0,0,1) (0,2,1) (0,1,3) end end",
        &[
            "test.grf:2:5: [unused-definition] the color `b` is not used",
            "test.grf:2:16: [missing-comma] missing comma between two numbers",
            "test.grf:4:1: [unknown-extension] azulejo does not know `ext unknown`, and keeps it",
            "test.grf:5:1: [missing-attribute] vertex without normal in a mesh with normals: computed from its faces (3 times)",
            "test.grf:6:16: [normal-length] a normal whose length is not 1",
            "test.grf:8:9: [unused-vertex] a vertex that no face uses",
            "test.grf:10:1: [degenerate-face] a face without area (2 times)",
            "test.grf:11:1: [repeated-corner] a face that names a vertex twice in a row",
        ],
    );
    check_lint(
        "def shiny = brdf phong n = 20 ks = 0.9 kd = 0.9\next material begin of = shiny wrong = 1 end ext\n\
         def wood = texture \"wood.png\"\nbegin mesh use texture wood begin vertices (0,0,0) (1,0,0) (0,1,0) end \
         begin faces (0,1,2) end end",
        &[
            "test.grf: [missing-file] texture \"wood.png\" skipped: there is no such file",
            "test.grf:1:5: [unused-definition] the brdf `shiny` is not used",
            "test.grf:1:18: [reciprocity] the brdf `phong` is not reciprocal; `lewis` has the same highlight and is reciprocal",
            "test.grf:1:18: [energy] a brdf has the albedo 1.17 at 0 degrees: scaled down where it would not conserve energy",
            "test.grf:2:39: [unknown-key] `ext material` has no key `wrong`: skipped",
        ],
    );
}
