//! What `text`, `font` and `extrude` promise.

use crate::support::{Folder, project};
use crate::tiny_font;
use azulejo_scene::Rgb;
use glam::DVec3;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

const SERIF: &str = "serif.ppf";

/// A folder with the typeface that comes with azulejo.
fn folder() -> Folder {
    let folder = Folder::new();
    let fonts = project().join("examples/fonts");
    folder.write(
        SERIF,
        std::fs::read(fonts.join("dejavu-serif.ppf")).unwrap(),
    );
    folder.write("latin.ppe", std::fs::read(fonts.join("latin.ppe")).unwrap());
    folder.write("tiny.ttf", tiny_font::bytes());
    folder
}

/// Lower and upper corner.
fn bounds(report: &Value) -> [f64; 6] {
    let corner = |end: &str, axis: usize| report["bounds"][end][axis].as_f64().unwrap();
    [0, 1, 2, 3, 4, 5].map(|i| corner(["min", "max"][i / 3], i % 3))
}

fn check(found: [f64; 6], expected: [f64; 6]) {
    let differ = std::iter::zip(found, expected).any(|(a, b)| (a - b).abs() > 1e-6);
    assert!(!differ, "{found:?} {expected:?}");
}

#[test]
fn text_becomes_solid() {
    let folder = folder();
    let report = folder.json("text AA --font tiny.ttf -o a.grf --size 2 --depth 0.5");
    assert_eq!(report["solids"], json!(2));
    check(bounds(&report), [0.0, 0.0, -0.5, 2.4, 1.4, 0.0]);
    let info = folder.json("info a.grf");
    assert_eq!(
        (&info["objects"], &info["warnings"]),
        (&json!(1), &json!([]))
    );
    check(bounds(&info), bounds(&report));
    let report = folder.json(
        "text AA --font tiny.ttf -o a.glb --at 1,2,3 --align right --spacing 0.1 --orientation \
         0,0,-1,0,2,0,-1,0,0 --depth 1",
    );
    check(bounds(&report), [0.0, 2.0, 3.0, 1.0, 2.7, 4.3]);
    assert_eq!(folder.json("info a.glb")["objects"], json!(1));
}

#[test]
fn text_has_lines() {
    let folder = folder();
    let both = |line: &str| bounds(&folder.json(line));
    let typed =
        both("text A\\nAA --font tiny.ttf -o a.grf --depth 1 --align center --line-spacing 2");
    check(typed, [-0.6, -2.0, -1.0, 0.6, 0.7, 0.0]);
    folder.write("lines.txt", "\u{feff}A\r\nAA\r\n");
    let read = both(
        "text --file lines.txt --font tiny.ttf -o b.grf --depth 1 --align center --line-spacing 2",
    );
    check(read, typed);
    assert_eq!(
        folder.json("info b.grf")["object_list"][0]["name"],
        json!("A")
    );
}

#[test]
fn text_comes_from_standard_input() {
    use std::io::Write;
    use std::process::Stdio;
    let folder = folder();
    let mut command = folder.command("text - --font tiny.ttf -o -");
    let pipes = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    let mut child = pipes.spawn().unwrap();
    child.stdin.take().unwrap().write_all(b"Ao\n").unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    folder.write("a.grf", &output.stdout);
    assert_eq!(folder.json("info a.grf")["objects"], json!(1));
}

#[test]
fn letters_lean() {
    let folder = folder();
    let found = |options: &str| {
        let line = format!("text A --font tiny.ttf -o a.grf --depth 1 {options}");
        bounds(&folder.json(&line))
    };
    // The box around the letter leans, too.
    check(found("--slant 45"), [0.0, 0.0, -1.0, 1.3, 0.7, 0.0]);
    check(found("--oblique 45"), [0.0, 0.0, -1.0, 1.6, 0.7, 0.0]);
    check(found("--oblique 0,-45"), [0.0, -1.0, -1.0, 0.6, 0.7, 0.0]);
}

#[test]
fn fonts_of_ppf_set_text() {
    let folder = folder();
    let by_names = folder.json("text Azulejo/at/ --ppf serif.ppf -o a.grf");
    let by_file = folder.json("text Azulejo/at/ --ppf serif.ppf --encoding latin.ppe -o b.grf");
    assert_eq!(by_names["solids"], json!(8));
    assert_eq!(by_names["bounds"], by_file["bounds"]);
    let letters = folder.json("text añÿ½¿ --font serif.ppf -o a.grf");
    assert_eq!(letters["solids"], json!(5));
}

#[test]
fn surfaces_are_as_they_are_asked_for() {
    let folder = folder();
    let text = "text A --font tiny.ttf -o";
    folder.ok(&format!("{text} a.grf --color #ffffff --name sign"));
    folder.ok(&format!("{text} b.grf --emission 5,4,3"));
    assert_eq!(
        folder.json("info a.grf")["object_list"][0]["name"],
        json!("sign")
    );
    assert_eq!(folder.json("info b.grf")["lights"]["area"], json!(1));
}

#[test]
fn lettering_that_has_no_meaning_is_refused() {
    let folder = folder();
    folder.write("a.ppf", "/A 1 2 l 0 0\n");
    folder.write("a.svg", "<svg><text/></svg>");
    folder.write("line.svg", "<svg><path d='M0 0h2'/></svg>");
    folder.write("wide.ttf", tiny_font::variable());
    for (line, code, expected) in [
        ("text A -o a.grf", 2, "--font"),
        (
            "text A --font tiny.ttf -o a.grf --size 0",
            2,
            "expected more than 0",
        ),
        ("text A --font tiny.ttf -o a.grf --depth -1", 2, "depth"),
        (
            "text A --font tiny.ttf -o a.grf --depth 0.1 --bevel 0.06:both",
            2,
            "expected at most 0.05, half the depth",
        ),
        (
            "text A --font tiny.ttf -o a.grf --bevel flat:0.06",
            2,
            "expected round or chamfer",
        ),
        (
            "text A --font tiny.ttf -o a.grf --orientation 1,0,0,0,1,0,0,0",
            2,
            "8 numbers",
        ),
        (
            "text A --font tiny.ttf -o a.grf --orientation 0,0,0,0,1,0,0,0,1",
            2,
            "no length",
        ),
        (
            "text A --font tiny.ttf -o a.grf --orientation 1,0,0,2,0,0,0,0,1",
            2,
            "one plane",
        ),
        (
            "text A --font tiny.ttf -o a.grf --color 0.8 --mirror 0.8",
            2,
            "creates energy",
        ),
        ("text A --font tiny.ttf -o a.txt", 2, "unknown model format"),
        (
            "text A --font tiny.ttf --encoding latin.ppe -o a.grf",
            2,
            "--encoding",
        ),
        (
            "text AżA --font tiny.ttf -o a.grf",
            1,
            "no glyph of Latin for `ż` (U+017C)",
        ),
        (
            "text A\\n--ж --font serif.ppf -o a.grf",
            1,
            "line 2 of the text",
        ),
        (
            "text A --font a.ppf -o a.grf",
            1,
            "a.ppf:2:1: found the end of the file",
        ),
        (
            "text A --font a.svg -o a.grf",
            1,
            "no font that can be read",
        ),
        ("text A --font tiny.ttf#3 -o a.grf", 1, "no face 3"),
        (
            "text Aक --font tiny.ttf,serif.ppf -o a.grf",
            1,
            "no glyph of Devanagari for `क` (U+0915)",
        ),
        (
            "text A --font tiny.ttf --variation wght=500 -o a.grf",
            2,
            "no font has an axis wght: none is variable",
        ),
        (
            "text A --font wide.ttf --variation wght=1000 -o a.grf",
            2,
            "wght=1000: expected wght from 100 to 900",
        ),
        (
            "text A --font tiny.ttf --features small -o a.grf",
            2,
            "expected a feature of four letters",
        ),
        (
            "text A --font tiny.ttf --align justify -o a.grf",
            2,
            "--align justify needs a --width or a --path",
        ),
        (
            "text A --font tiny.ttf --width 2 --path a.svg -o a.grf",
            2,
            "cannot be used with",
        ),
        (
            "text A --font tiny.ttf --path a.svg -o a.grf",
            1,
            "a drawing without paths",
        ),
        (
            "text AAAA --font tiny.ttf --path line.svg -o a.grf",
            1,
            "the path is 2.0000 ems long, and a line of the text 2.4000",
        ),
        (
            "text A\\n{size=2|A --font tiny.ttf -o a.grf",
            1,
            "line 2 of the text: `{size=2|A` is not closed",
        ),
        (
            "text {color=red|A} --font tiny.ttf -o a.grf",
            1,
            "`color=red`",
        ),
        ("text A --font no.ttf -o a.grf", 1, "no.ttf"),
        (
            "extrude a.svg --depth 0 -o a.grf",
            2,
            "expected more than 0",
        ),
        ("extrude a.svg --depth 1 -o a.grf", 1, "nothing to extrude"),
        (
            "extrude a.svg#2 --depth 1 -o a.grf",
            1,
            "page 2 of a file that is no PDF",
        ),
        (
            "extrude tiny.ttf --depth 1 -o a.grf",
            1,
            "expected a drawing in SVG, DXF or PDF",
        ),
        ("font sheet tiny.ttf -o a.jpg", 2, "expected .png"),
        (
            "font convert tiny.ttf -o a.ppf --characters 400-4ff",
            1,
            "none of the characters",
        ),
    ] {
        folder.fails(line, code, expected);
    }
    assert_eq!(folder.run("text A --font tiny.ttf -o -").code, Some(0));
    assert!(!folder.names().contains(&"a.grf".to_owned()));
}

#[test]
fn typefaces_are_converted() {
    let folder = folder();
    let report = folder.json("font convert tiny.ttf -o a.ppf --encoding a.ppe --characters ascii");
    assert_eq!(report["glyphs"], json!(4));
    let codes = String::from_utf8(folder.read("a.ppe")).unwrap();
    assert_eq!(codes, "32/space\n65/A\n88/X\n111/o\n");
    let from_ppf = folder.json("text AA --ppf a.ppf --encoding a.ppe -o a.grf");
    check(bounds(&from_ppf), [0.0, 0.0, -0.25, 1.2, 0.7, 0.0]);
    folder.write("spaced.txt", "A A");
    let blank = folder.json("text --file spaced.txt --font a.ppf -o a.grf");
    check(bounds(&blank), [0.0, 0.0, -0.25, 1.45, 0.7, 0.0]);
}

#[test]
fn fonts_come_in_lists_collections_and_packed() {
    let folder = folder();
    folder.write(
        "more.ttf",
        tiny_font::with_characters([' ', 'Ж', 'b', 'ב', 'c']),
    );
    folder.write("both.ttc", tiny_font::collection());
    folder.write("web.woff2", tiny_font::woff2());
    folder.write("web.woff", tiny_font::woff(<[u8]>::to_vec));
    let report = folder.json("text AЖ --font tiny.ttf,more.ttf -o a.grf");
    assert_eq!(report["solids"], json!(2));
    let again = folder.json("text AЖ --font tiny.ttf --font more.ttf -o a.grf");
    assert_eq!(again["bounds"], report["bounds"]);
    // A name that exists is one file, whatever letters it has.
    folder.write("a,b#1.ttf", tiny_font::bytes());
    for font in [
        "both.ttc",
        "both.ttc#0",
        "web.woff",
        "web.woff2",
        "a,b#1.ttf",
    ] {
        assert_eq!(
            folder.json(&format!("text A --font {font} -o a.grf"))["solids"],
            json!(1)
        );
    }
    folder.ok("text B --font both.ttc#1 -o a.grf");
    folder.fails("text A --font both.ttc#1 -o b.grf", 1, "no glyph of Latin");
    folder.ok("font convert both.ttc#1 -o b.ppf --characters 42");
    folder.ok("text B --font tiny.ttf,b.ppf,more.ttf -o a.grf");
}

/// What `text` reads beside a font, it takes by the ending of the font's name.
#[test]
fn metrics_beside_a_font_kern_it() {
    let folder = folder();
    folder.write("named.t1", tiny_font::named());
    let width = || bounds(&folder.json("text AX --font named.t1 -o a.grf"))[3];
    let plain = width();
    folder.write("named.afm", "StartFontMetrics 4.1\nKPX A X -80\n");
    assert!((plain - width() - 0.08).abs() < 1e-6);
    folder.write("named.afm", "nothing");
    let said = "named.afm: found another file, expected Adobe Font Metrics";
    folder.fails("text AX --font named.t1 -o b.grf", 1, said);
}

#[test]
fn variable_fonts_say_where_they_are() {
    let folder = folder();
    folder.write("wide.ttf", tiny_font::variable());
    let plain = folder.json("text A --font wide.ttf -o a.grf");
    check(bounds(&plain), [0.0, 0.0, -0.25, 0.6, 0.7, 0.0]);
    let expected =
        "wide.ttf: an instance without a name; axes wght 100 to 900 (the lightest is its default)";
    assert_eq!(plain["fonts"], json!([expected]));
    let bold = folder.json("text A --font wide.ttf --variation wght=900 -o a.grf");
    check(bounds(&bold), [0.0, 0.0, -0.25, 1.2, 0.7, 0.0]);
    assert_eq!(
        folder.json("text A --font tiny.ttf -o a.grf")["fonts"],
        json!([])
    );
}

#[test]
fn features_change_letters_or_are_named() {
    let folder = folder();
    let unkerned = folder.json("text Ao --font tiny.ttf --features kern=0,ss01 -o a.grf");
    let kerned = folder.json("text Ao --font tiny.ttf -o a.grf");
    assert!((bounds(&unkerned)[3] - bounds(&kerned)[3] - 0.1).abs() < 1e-6);
    let said = unkerned["warnings"].to_string();
    assert!(
        said.contains("no font has the feature ss01; there are: kern"),
        "{said}"
    );
}

#[test]
fn text_fills_a_width() {
    let folder = folder();
    folder.write("words.txt", "AA AA A");
    let text = "text --file words.txt --font tiny.ttf -o a.grf --depth 1 --size 2 --width";
    let ragged = folder.json(&format!("{text} 6"));
    check(bounds(&ragged), [0.0, -2.4, -1.0, 5.3, 1.4, 0.0]);
    let full = folder.json(&format!("{text} 6 --align justify"));
    check(bounds(&full), [0.0, -2.4, -1.0, 6.0, 1.4, 0.0]);
    let right = folder.json(&format!("{text} 6 --align right"));
    check(bounds(&right), [-5.3, -2.4, -1.0, 0.0, 1.4, 0.0]);
    let narrow = folder.json(&format!("{text} 2"));
    let said = narrow["warnings"].to_string();
    assert!(
        said.contains("2 lines cannot be broken and are longer"),
        "{said}"
    );
}

#[test]
fn text_follows_a_path() {
    let folder = folder();
    // Upwards along a line at x = 3 whose length is 4, y up from the lower edge.
    folder.write(
        "up.svg",
        "<svg viewBox='0 0 10 10'><g transform='translate(1 0)'><defs>\
         <path d='M2 8v-4'/></defs></g><rect width='5' height='5'/></svg>",
    );
    let text = "text AA --font tiny.ttf -o a.grf --depth 1 --path up.svg";
    check(bounds(&folder.json(text)), [2.3, 2.0, -1.0, 3.0, 3.2, 0.0]);
    let end = folder.json(&format!("{text} --align right"));
    check(bounds(&end), [2.3, 4.8, -1.0, 3.0, 6.0, 0.0]);
    let moved = folder.json(&format!("{text} --at 1,1,1 --size 2"));
    check(bounds(&moved), [2.6, 3.0, 0.0, 4.0, 5.4, 1.0]);
}

#[test]
fn parts_of_a_text_have_colors_and_sizes() {
    let folder = folder();
    let text = "text A{color=#c00|A{size=2|A}}A --font tiny.ttf -o a.glb --depth 1 --color 0.5";
    let report = folder.json(text);
    check(bounds(&report), [0.0, 0.0, -1.0, 3.0, 1.4, 0.0]);
    assert_eq!(folder.json("info a.glb")["materials"], json!(2));
    let name = folder.json("info a.glb")["object_list"][0]["name"].clone();
    assert_eq!(name, json!("AAAA"));
}

#[test]
fn letters_of_colors_have_layers() {
    let folder = folder();
    folder.write("color.ttf", tiny_font::colored());
    folder.write("paint.ttf", tiny_font::painted());
    let report = folder.json("text A --font color.ttf -o a.grf --depth 1");
    check(bounds(&report), [0.0, 0.0, -1.0, 0.6, 0.7, 0.05]);
    assert_eq!(report["solids"], json!(2));
    assert_eq!(folder.json("info a.grf")["materials"], json!(2));
    let said = folder.json("text Xo --font paint.ttf -o a.grf")["warnings"].to_string();
    assert!(said.contains("gradients have their mean colour"), "{said}");
    assert!(said.contains("partly transparent is opaque"), "{said}");
    folder.fails("text A --font paint.ttf -o b.grf", 1, "colours");
}

#[test]
fn sheets_show_all_glyphs() {
    let folder = folder();
    let report = folder.json("font sheet serif.ppf -o a.png --size 8");
    assert!(report["glyphs"].as_u64().unwrap() > 180);
    assert_eq!(report["warnings"], json!([]));
    assert!(folder.read("a.png").starts_with(b"\x89PNG"));
    // A font without letters for its own names says so.
    let report = folder.json("font sheet tiny.ttf -o b.png --characters all");
    assert!(
        report["warnings"]
            .to_string()
            .contains("names are not drawn")
    );
}

/// Letters in the named font, and only in one.
#[test]
fn texts_of_drawings_become_solid() {
    let folder = folder();
    folder.write(
        "sign.svg",
        "<svg viewBox='0 0 100 100'><text x='1' y='90' font-size='10'>AA</text></svg>",
    );
    let report = folder.json("extrude sign.svg --depth 3 --font tiny.ttf -o sign.grf");
    check(bounds(&report), [1.0, 10.0, -3.0, 13.0, 17.0, 0.0]);
    let said = folder.ok("extrude sign.svg --depth 3 --font tiny.ttf -o sign.grf");
    assert!(said.err.contains("set in tiny.ttf"), "{}", said.err);
    folder.fails(
        "extrude sign.svg --depth 3 --font sign.svg -o sign.grf",
        1,
        "sign.svg: found no font that can be read",
    );
    // Text on a layer of its own is inside of the plate, unless it is raised.
    folder.write(
        "plate.dxf",
        "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n8\nplate\n40\n30\n\
         0\nTEXT\n8\nwords\n1\nA\n40\n7\n0\nENDSEC\n0\nEOF\n",
    );
    let flat = folder.ok("extrude plate.dxf --depth 2 --font tiny.ttf -o plate.glb");
    assert!(flat.err.contains("--layers STEP raises"), "{}", flat.err);
    let line = "extrude plate.dxf --depth 2 --font tiny.ttf --layers 1 -o plate.glb";
    check(
        bounds(&folder.json(line)),
        [-30.0, -30.0, -2.0, 30.0, 30.0, 1.0],
    );
}

#[test]
fn drawings_become_solid() {
    let folder = Folder::new();
    folder.write(
        "logo.svg",
        "<svg width='10mm' viewBox='0 0 10 10'>\
         <rect x='1' y='1' width='4' height='2' fill='#f00'/><circle cx='8' cy='8' r='1'/></svg>",
    );
    let report = folder.json("extrude logo.svg --depth 3 --scale 2 -o logo.grf");
    assert_eq!(report["solids"], json!(2));
    check(bounds(&report), [2.0, 2.0, -3.0, 18.0, 18.0, 0.0]);
    let info = folder.json("info logo.grf");
    assert_eq!(info["materials"], json!(2));
    assert!((info["metres_per_unit"].as_f64().unwrap() - 0.0005).abs() < 1e-12);
    folder.write(
        "plate.dxf",
        "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n8\na\n40\n2\n0\nCIRCLE\n8\na\n40\n1\n0\nENDSEC\n0\nEOF\n",
    );
    let report = folder.json("extrude plate.dxf --depth 1 -o plate.grf --color 0.4");
    assert_eq!(report["solids"], json!(1));
    check(bounds(&report), [-2.0, -2.0, -1.0, 2.0, 2.0, 0.0]);
    // A hole is not filled because the outline around it is open.
    let open = "0\nLINE\n10\n-5\n20\n-5\n11\n5\n21\n-5\n0\nLINE\n10\n5\n20\n-5\n11\n0\n21\n9\n";
    folder.write(
        "open.dxf",
        format!("0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n40\n1\n{open}0\nENDSEC\n0\nEOF\n"),
    );
    let found = "open.dxf:9:1: found an outline around others that is open at (-5, -5)";
    folder.fails("extrude open.dxf --depth 1 -o open.stl", 1, found);
}

/// A plate of 4 × 4 × 2 with edges that are cut off loses known areas and volumes; all files say the same.
#[test]
fn edges_are_cut_off_or_rounded() {
    let folder = Folder::new();
    folder.write(
        "plate.svg",
        "<svg viewBox='0 0 4 4'><rect width='4' height='4'/></svg>",
    );
    let area = |file: &str| {
        let info = folder.json(&format!("info {file}"));
        info["object_list"][0]["area"].as_f64().unwrap()
    };
    let close = |found: f64, expected: f64| {
        assert!(
            (found - expected).abs() < 1e-3 * expected,
            "{found} {expected}"
        )
    };
    let report = folder.json("extrude plate.svg --depth 2 --bevel chamfer:0.5 -o front.grf");
    check(bounds(&report), [0.0, 0.0, -2.0, 4.0, 4.0, 0.0]);
    // The back, the rest of the sides, the trapezoids, and the front.
    let trapezoids = 4.0 * 3.5 * 0.5 * 2f64.sqrt();
    close(area("front.grf"), 16.0 + 24.0 + trapezoids + 9.0);
    for file in ["both.grf", "both.obj", "both.glb", "both.stl", "both.ply"] {
        folder.ok(&format!(
            "extrude plate.svg --depth 2 --bevel chamfer:0.5:both -o {file}"
        ));
        close(area(file), 16.0 + 2.0 * (trapezoids + 9.0));
    }
    folder.ok("extrude plate.svg --depth 2 --bevel 0.5:both -o round.grf");
    // Quarter cylinders, whose ends are mitred.
    let round = 4.0 * (3.0 * 0.25 * PI + 2.0 * 0.25);
    close(area("round.grf"), 16.0 + 2.0 * (round + 9.0));
    let lost = folder.ok("convert round.grf -o round.sff").err;
    assert!(lost.contains("1 shapes whose bevels are omitted"), "{lost}");
}

/// What is painted over other things stands out from them, and without --layers it is said that it does not.
#[test]
fn layers_rise_over_what_they_are_painted_on() {
    let folder = Folder::new();
    folder.write(
        "badge.svg",
        "<svg viewBox='0 0 10 10'><rect width='10' height='10' fill='#fff'/>\
         <circle cx='5' cy='5' r='3' fill='#f00'/><circle cx='5' cy='5' r='1' fill='#00f'/></svg>",
    );
    let flat = folder.ok("extrude badge.svg --depth 2 -o flat.glb");
    assert!(flat.err.contains("--layers STEP"), "{}", flat.err);
    let raised = folder.ok("extrude badge.svg --depth 2 --layers 0.5 -o raised.grf");
    assert!(!raised.err.contains("--layers"), "{}", raised.err);
    let report = folder.json("extrude badge.svg --depth 2 --layers 0.5 -o raised.grf");
    check(bounds(&report), [0.0, 0.0, -2.0, 10.0, 10.0, 1.0]);
    // Inlaid they are flush, and nothing is in one place twice: fronts and backs have the area of the square.
    folder.ok("extrude badge.svg --depth 2 --layers inlay -o flush.grf");
    let report = folder.json("info flush.grf");
    check(bounds(&report), [0.0, 0.0, -2.0, 10.0, 10.0, 0.0]);
    let around = 4.0 * 10.0 + 2.0 * TAU * (3.0 + 1.0);
    let area = report["object_list"][0]["area"].as_f64().unwrap();
    let expected = 2.0 * 100.0 + 2.0 * around;
    assert!((area / expected - 1.0).abs() < 1e-3, "{area} {expected}");
    let wrong = "extrude badge.svg --depth 2 --layers inlaid -o no.grf";
    folder.fails(wrong, 2, "expected a length or inlay");
    // Beside each other they are as they were.
    folder.write(
        "beside.svg",
        "<svg viewBox='0 0 10 10'><rect width='4' height='4' fill='#fff'/>\
         <rect x='4' width='4' height='4' fill='#f00'/></svg>",
    );
    let beside = folder.ok("extrude beside.svg --depth 2 -o beside.glb");
    assert!(!beside.err.contains("--layers"), "{}", beside.err);
    // Paint by paint, seen from the front: blue in the middle.
    folder.ok("render raised.grf --sky 1 --ground none --from 5,5,20 --at 5,5,0 --fov 40 --size 21x21 --spp 16 -o r.exr");
    let image = azulejo_formats::picture::decode(&folder.read("r.exr")).unwrap();
    let [r, g, b] = image.pixels[220];
    assert!(b > 5.0 * r.max(g), "{r} {g} {b}");
}

/// Volume of the triangles of a binary STL.
fn stl_volume(bytes: &[u8]) -> f64 {
    let number = |b: &[u8]| f64::from(f32::from_le_bytes(b.try_into().unwrap()));
    let volume = |facet: &[u8]| {
        let x: Vec<f64> = facet[12..48].chunks(4).map(number).collect();
        let [a, b, c] = [0, 3, 6].map(|k| DVec3::new(x[k], x[k + 1], x[k + 2]));
        a.dot(b.cross(c)) / 6.0
    };
    bytes[84..].chunks_exact(50).map(volume).sum()
}

/// The rest of closed solids is tested with their writers.
#[test]
fn printed_letters_have_a_tolerance() {
    let folder = folder();
    let volume = |tolerance: &str| {
        let line = format!("text S& --ppf {SERIF} --size 20 --depth 3 {tolerance} -o a.stl");
        folder.ok(&line);
        stl_volume(&folder.read("a.stl"))
    };
    let [coarse, middle, fine] =
        ["0.2", "0.02", "0.0005"].map(|t| volume(&format!("--tolerance {t}")));
    assert!(
        (coarse - fine).abs() > 3.0 * (middle - fine).abs(),
        "{coarse} {middle} {fine}"
    );
    assert!((middle / fine - 1.0).abs() < 2e-3);
    folder.ok(&format!(
        "text S& --ppf {SERIF} --size 20 --tolerance 0.02 -o a.3mf"
    ));
    assert_eq!(folder.json("info a.3mf")["objects"], json!(1));
    let line = format!("text S& --ppf {SERIF} --tolerance");
    folder.fails(&format!("{line} 0.1 -o a.grf"), 2, "GRF keeps exact shapes");
    folder.fails(&format!("{line} 0 -o a.stl"), 2, "above 0");
    folder.fails(&format!("{line} 1e-9 -o a.stl"), 1, "expected at least");
    // Other formats have as many polygons.
    let faces = |tolerance: &str| {
        folder.ok(&format!("{line} {tolerance} -o a.obj"));
        folder.json("info a.obj")["triangles"].as_u64().unwrap()
    };
    assert!(faces("0.0001") > 2 * faces("0.01"));
}

#[test]
fn open_meshes_are_converted_and_named() {
    let folder = Folder::with_room();
    folder.write("sheet.obj", "o sheet\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for name in ["a.stl", "a.3mf"] {
        let run = folder.ok(&format!("convert sheet.obj -o {name}"));
        let expected = "1 of 1 objects are not closed, so that slicers may refuse them: \"sheet\" (3 open edges)";
        assert!(run.err.contains(expected), "{}", run.err);
        assert_eq!(folder.json(&format!("info {name}"))["triangles"], json!(1));
    }
}

/// A convex letter in a black box of 4 m: what arrives at its six walls is its flux.
#[test]
fn all_of_the_flux_of_a_letter_arrives() {
    let folder = folder();
    let report = folder.json(
        "text A --font tiny.ttf --size 1 --depth 0.3 --at -0.3,-0.35,0.15 --flux 1000lm --emission 1,0.4,0.1 -o a.grf",
    );
    let flux = |value: &Value| value.as_f64().unwrap();
    assert_eq!(flux(&report["flux"]), 1000.0);
    // A triangle of base 0.6 and height 0.7.
    let outline = 0.6 + 2.0 * 0.3f64.hypot(0.7);
    let area = 0.6 * 0.7 + 0.3 * outline;
    let luminance = flux(&report["luminance"]);
    assert!(
        (luminance * area * PI / 1000.0 - 1.0).abs() < 1e-6,
        "{luminance} {area}"
    );
    assert!((flux(&report["stroke_metres"]) - 0.5 * outline).abs() < 1e-6);
    let power = folder.json("info a.grf")["lights"]["area_power"].clone();
    let power = Rgb::new(flux(&power[0]), flux(&power[1]), flux(&power[2])).luminance();
    assert!((power / 1000.0 - 1.0).abs() < 5e-3, "{power}");
    folder.write("box.mtl", "newmtl black\nKd 0 0 0\n");
    let mut walls = String::from("mtllib box.mtl\nusemtl black\n");
    for k in 0..8 {
        let at = |bit: u32| if k >> bit & 1 == 1 { 2 } else { -2 };
        walls += &format!("v {} {} {}\n", at(0), at(1), at(2));
    }
    walls += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    folder.write("box.obj", walls.replace("f 1 3 4 2", "o walls\nf 1 3 4 2"));
    let mut points = String::new();
    const STEPS: u32 = 24;
    for (axis, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
        for k in 0..STEPS * STEPS {
            let at = |k: u32| 4.0 * (f64::from(k) + 0.5) / f64::from(STEPS) - 2.0;
            let (mut point, mut normal) = (DVec3::ZERO, DVec3::ZERO);
            point[axis] = 1.9999 * side;
            point[(axis + 1) % 3] = at(k % STEPS);
            point[(axis + 2) % 3] = at(k / STEPS);
            normal[axis] = -side;
            let [x, y, z] = point.to_array();
            let [nx, ny, nz] = normal.to_array();
            points += &format!("{x} {y} {z} {nx} {ny} {nz}\n");
        }
    }
    folder.write("points.txt", points);
    folder.ok("probe a.grf box.obj --points points.txt -o lux.txt --rays 64");
    let text = String::from_utf8(folder.read("lux.txt")).unwrap();
    let each = 16.0 / f64::from(STEPS * STEPS);
    let lux = text.lines().map(|line| {
        let c: Vec<f64> = line
            .split_whitespace()
            .take(3)
            .map(|w| w.parse().unwrap())
            .collect();
        Rgb::new(c[0], c[1], c[2]).luminance()
    });
    let sum = each * lux.sum::<f64>();
    assert!((sum / 1000.0 - 1.0).abs() < 5e-3, "{sum} lm");
}

/// Rings and strokes have the length along which they run.
#[test]
fn flux_may_be_of_a_metre_of_strokes() {
    let folder = folder();
    folder.write(
        "ring.svg",
        "<svg xmlns='http://www.w3.org/2000/svg' fill='none' stroke='#000'><circle cx='0' cy='0' r='10' stroke-width='0.5'/></svg>",
    );
    let report =
        folder.json("extrude ring.svg --scale 0.1 --depth 0.05 --flux 500lm/m -o ring.grf");
    let [length, flux] = ["stroke_metres", "flux"].map(|key| report[key].as_f64().unwrap());
    assert!((length / (2.0 * PI) - 1.0).abs() < 1e-4, "{length}");
    assert!((flux / (500.0 * length) - 1.0).abs() < 1e-9, "{flux}");
    assert_eq!(folder.json("info ring.grf")["photometric"], json!(true));
    folder.fails(
        "extrude ring.svg --depth 1 --flux 3W -o a.grf",
        2,
        "1200lm or 800lm/m",
    );
    folder.fails(
        "extrude ring.svg --depth 1 --flux 3lm --emission 0 -o a.grf",
        2,
        "colour of the light",
    );
}

#[test]
fn illuminance_has_a_scale() {
    let folder = Folder::with_room();
    let line = "render room.obj --rays 64 --size 64x48 --spp 2 --look illuminance";
    let report = folder.json(&format!("{line} -o e.png"));
    assert!(report["scale_end"].as_f64().unwrap() > 0.0);
    let picture = azulejo_formats::read_picture(&folder.read("e.png")).unwrap();
    assert!(
        picture.width == 64 && picture.height > 48,
        "with a scale below"
    );
    folder.fails(
        &format!("{line} -o e.png --exposure 1"),
        2,
        "--exposure does not apply",
    );
}

#[test]
fn pages_become_solids() {
    let folder = Folder::new();
    // Without its tables, which are repaired.
    let pages = [
        (3, 5, "1 0 0 rg 9 9 72 36 re f"),
        (4, 6, "9 9 m 81 9 l 9 81 l f"),
    ];
    let mut text = "%PDF-1.7\n1 0 obj\n<</Type/Catalog/Pages 2 0 R>>\nendobj\n\
                    2 0 obj\n<</Type/Pages/Kids[3 0 R 4 0 R]/Count 2/MediaBox[0 0 99 99]>>\nendobj\n"
        .to_owned();
    for (page, content, drawn) in pages {
        let length = drawn.len();
        text +=
            &format!("{page} 0 obj\n<</Type/Page/Parent 2 0 R/Contents {content} 0 R>>\nendobj\n");
        text +=
            &format!("{content} 0 obj\n<</Length {length}>>\nstream\n{drawn}\nendstream\nendobj\n");
    }
    text += "trailer\n<</Root 1 0 R>>\n";
    folder.write("two.pdf", text);
    for (name, top) in [("two.pdf", 45.0), ("two.pdf#2", 81.0)] {
        let report = folder.json(&format!("extrude {name} --depth 2 -o a.grf"));
        check(bounds(&report), [9.0, 9.0, -2.0, 81.0, top, 0.0]);
    }
    folder.fails(
        "extrude two.pdf#3 --depth 2 -o b.grf",
        1,
        "a page from 1 to 2",
    );
}
