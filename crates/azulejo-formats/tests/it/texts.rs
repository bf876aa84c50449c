//! Text inside files, in a font of a few letters: A is 0.6 wide and 0.7 high, lines reach 0.8 up and not down.

use crate::tiny_font;
use azulejo_formats::outline::Drawing;
use azulejo_formats::{FontFile, Memory, ReadOptions, read, read_drawing, read_with};
use azulejo_scene::{Scene, Shape, Sidedness};
use glam::{DVec2, DVec3};

fn files() -> Memory {
    Memory::new().with_font(FontFile {
        name: "Tiny".into(),
        bytes: tiny_font::bytes(),
        face: 0,
    })
}

fn scene(name: &str, text: &str) -> (Scene, Vec<String>) {
    let model = read(text.as_bytes(), name, &files()).unwrap();
    model.scene.validate().unwrap();
    let messages = model.warnings.iter().map(|w| w.message.clone());
    (model.scene, messages.collect())
}

fn vrml(text_fields: &str) -> Scene {
    let file = format!(
        "#VRML V2.0 utf8\nShape {{ appearance Appearance {{ material Material {{ diffuseColor 1 0 0 }} }}
         geometry Text {{ {text_fields} }} }}"
    );
    let (scene, messages) = scene("a.wrl", &file);
    assert!(messages[0].ends_with("set in Tiny"), "{messages:?}");
    assert_eq!(messages.len(), 1, "{messages:?}");
    scene
}

fn check_bounds(scene: &Scene, min: [f64; 3], max: [f64; 3]) {
    let bounds = scene.bounds();
    let (min, max) = (DVec3::from(min), DVec3::from(max));
    let off = bounds.min.distance(min) + bounds.max.distance(max);
    assert!(
        off < 1e-7,
        "{} to {}, expected {min} to {max}",
        bounds.min,
        bounds.max
    );
}

#[test]
fn letters_of_vrml_lie_in_their_plane() {
    let scene = vrml("string [ \"AA\" ] fontStyle FontStyle { size 2 }");
    check_bounds(&scene, [0.0; 3], [2.4, 1.4, 0.0]);
    let Shape::Mesh(mesh) = &scene.objects[0].shape else {
        panic!("no mesh");
    };
    let area: f64 = (0..mesh.faces.len())
        .map(|f| mesh.face_area_vector(f).z)
        .sum();
    assert!((area - 4.0 * 2.0 * 0.5 * 0.6 * 0.7).abs() < 1e-9, "{area}");
    let material = &scene.materials[mesh.face_materials[0] as usize];
    assert_eq!(material.sidedness, Sidedness::Two);
    assert!(material.diffuse.r > 0.9 && material.diffuse.g == 0.0);
    // A ring: the hole stays open, and the edges keep to their curves.
    let scene = vrml("string \"o\"");
    let Shape::Mesh(mesh) = &scene.objects[0].shape else {
        panic!("no mesh");
    };
    let area: f64 = (0..mesh.faces.len())
        .map(|f| mesh.face_area_vector(f).z)
        .sum();
    let exact = 5.0 / 6.0 * (0.6 * 0.6 - 0.3 * 0.3);
    assert!((area / exact - 1.0).abs() < 5e-3, "{area} {exact}");
}

/// ISO/IEC 14772-1, 6.22.3: what `justify` puts at the origin.
#[test]
fn lines_of_vrml_are_justified() {
    let check = |style: &str, min: [f64; 2], max: [f64; 2]| {
        let fields = format!("string [ \"A\" \"AA\" ] fontStyle FontStyle {{ {style} }}");
        let [min, max] = [min, max].map(|[x, y]| [x, y, 0.0]);
        check_bounds(&vrml(&fields), min, max);
    };
    // Two lines, 1 apart: letters from 0.7 above the first baseline to the second one.
    check("", [0.0, -1.0], [1.2, 0.7]);
    check("spacing 2", [0.0, -2.0], [1.2, 0.7]);
    check("justify [ \"MIDDLE\" ]", [-0.6, -1.0], [0.6, 0.7]);
    check("justify [ \"END\" ]", [-1.2, -1.0], [0.0, 0.7]);
    check("justify [ \"FIRST\" \"FIRST\" ]", [0.0, -1.0], [1.2, 0.7]);
    check("justify [ \"BEGIN\" \"BEGIN\" ]", [0.0, -1.8], [1.2, -0.1]);
    check("justify [ \"BEGIN\" \"END\" ]", [0.0, 0.0], [1.2, 1.7]);
    check("justify [ \"BEGIN\" \"MIDDLE\" ]", [0.0, -0.9], [1.2, 0.8]);
    check("leftToRight FALSE", [-1.2, -1.0], [0.0, 0.7]);
    check("leftToRight FALSE justify \"END\"", [0.0, -1.0], [1.2, 0.7]);
    check("topToBottom FALSE", [0.0, 0.0], [1.2, 1.7]);
    check(
        "topToBottom FALSE justify [ \"\" \"END\" ]",
        [0.0, -1.8],
        [1.2, -0.1],
    );
    check(
        "topToBottom FALSE justify [ \"\" \"BEGIN\" ]",
        [0.0, 0.0],
        [1.2, 1.7],
    );
    // Columns, 1 apart, of cells 0.8 high.
    check("horizontal FALSE", [0.0, -1.6], [1.6, -0.1]);
    check(
        "horizontal FALSE leftToRight FALSE",
        [-1.6, -1.6],
        [0.0, -0.1],
    );
    check("horizontal FALSE topToBottom FALSE", [0.0, 0.0], [1.6, 1.5]);
    check(
        "horizontal FALSE justify [ \"END\" \"END\" ]",
        [-1.6, 0.0],
        [0.0, 1.5],
    );
    check(
        "horizontal FALSE justify [ \"MIDDLE\" \"MIDDLE\" ]",
        [-0.8, -0.8],
        [0.8, 0.7],
    );
}

#[test]
fn lengths_of_vrml_stretch_and_limit() {
    let check = |fields: &str, width: f64| {
        let scene = vrml(&format!("string \"AA\" {fields}"));
        check_bounds(&scene, [0.0; 3], [width, 0.7, 0.0]);
    };
    check("length 3", 3.0);
    check("length 0.6", 0.6);
    check("maxExtent 0.9", 0.9);
    check("maxExtent 9", 1.2);
    check("length 3 maxExtent 2", 2.0);
    check("length -3 maxExtent -2", 1.2);
}

#[test]
fn text_of_x3d_and_of_vrml_1_is_read() {
    let x3d = "<X3D version='3.3'><Scene><Transform translation='0 0 5'><Shape>
        <Text string='\"A\" \"A\"'><FontStyle size='2' spacing='0.5' justify='\"MIDDLE\" \"BEGIN\"'/></Text>
        </Shape></Transform></Scene></X3D>";
    let (x3d, _) = scene("a.x3d", x3d);
    check_bounds(&x3d, [-0.6, -2.6, 5.0], [0.6, -0.2, 5.0]);
    let vrml1 = "#VRML V1.0 ascii\nSeparator { FontStyle { size 2 family SANS style BOLD }
        Translation { translation 1 0 0 } AsciiText { string [ \"A\", \"AA\" ] justification CENTER spacing 2 } }
        AsciiText { string \"A\" justification RIGHT width 30 }";
    let (vrml1, messages) = scene("a.wrl", vrml1);
    assert_eq!(vrml1.objects.len(), 2);
    assert!(
        messages[0].starts_with("text that asks for sans-serif"),
        "{messages:?}"
    );
    let bounds = vrml1.objects[0].bounds();
    assert!(
        bounds.min.distance(DVec3::new(-0.2, -4.0, 0.0)) < 1e-7,
        "{bounds:?}"
    );
    assert!(
        bounds.max.distance(DVec3::new(2.2, 1.4, 0.0)) < 1e-7,
        "{bounds:?}"
    );
    let bounds = vrml1.objects[1].bounds();
    assert!(
        bounds.min.distance(DVec3::new(-30.0, 0.0, 0.0)) < 1e-7,
        "{bounds:?}"
    );
    assert!(
        bounds.max.distance(DVec3::new(0.0, 7.0, 0.0)) < 1e-7,
        "{bounds:?}"
    );
}

/// The scene is right but for the text, which is named.
#[test]
fn text_without_a_font_or_its_letters_is_named() {
    let text = "#VRML V2.0 utf8\nShape { geometry Box {} appearance DEF a Appearance { material Material {} } }
        Shape { geometry Text { string [ \"Hello\" \"\" ] } appearance USE a }";
    let model = read(text.as_bytes(), "a.wrl", &Memory::new()).unwrap();
    assert_eq!((model.scene.objects.len(), model.warnings.len()), (1, 1));
    let message = &model.warnings[0].message;
    assert_eq!(
        message,
        "text \"Hello\": no font to set it in (install or name one), left out"
    );
    let (scene, messages) = scene("a.wrl", text);
    assert_eq!(scene.objects.len(), 1);
    assert_eq!(
        messages,
        ["text \"Hello\": no font has all of its characters, left out"]
    );
}

/// A text of many letters is counted before it is built.
#[test]
fn many_letters_are_limited() {
    let long = "o".repeat(50_000);
    let text = format!("#VRML V2.0 utf8\nShape {{ geometry Text {{ string [ \"{long}\" ] }} }}");
    let options = ReadOptions::in_proportion(text.len());
    let error = read_with(text.as_bytes(), "a.wrl", &files(), &options).unwrap_err();
    assert!(error.to_string().contains("expand to more than"), "{error}");
}

fn drawn(name: &str, text: &str) -> Drawing {
    read_drawing(text.as_bytes(), name, &files(), &ReadOptions::default()).unwrap()
}

/// Bounds and area of a drawing's one shape, whose only warning names the font.
fn check_drawn(name: &str, text: &str, min: [f64; 2], max: [f64; 2], area: f64) {
    let drawing = drawn(name, text);
    let messages: Vec<&str> = drawing.warnings.iter().map(|w| &*w.message).collect();
    assert!(
        matches!(messages[..], [one] if one.ends_with("set in Tiny")),
        "{text}: {messages:?}"
    );
    let [shape] = &drawing.shapes[..] else {
        panic!("{text}: {} shapes", drawing.shapes.len());
    };
    let bounds = shape.figure.bounds();
    let off = bounds.min.distance(min.into()) + bounds.max.distance(max.into());
    assert!(off < 1e-5, "{text}: {bounds:?}");
    let found = shape.figure.outline().signed_area();
    assert!((found - area).abs() < 1e-4, "{text}: {found}");
}

/// The area of a letter A whose em is 1.
const A: f64 = 0.5 * 0.6 * 0.7;

/// Text in a view of 100 x 100, y up.
#[test]
fn letters_of_svg_are_where_they_should_be() {
    let check = |content: &str, min: [f64; 2], max: [f64; 2], area: f64| {
        let text = format!(
            "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 100 100'>{content}</svg>"
        );
        check_drawn("a.svg", &text, min, max, area);
    };
    let ten = "font-size='10'";
    check(
        &format!("<text x='5' y='90' {ten}>AA</text>"),
        [5.0, 10.0],
        [17.0, 17.0],
        200.0 * A,
    );
    check(
        "<text x='5' y='90' style='font-size:20px'>A</text>",
        [5.0, 10.0],
        [17.0, 24.0],
        400.0 * A,
    );
    check(
        "<text y='100' style='font: bold 32px/1.2 Arial, sans-serif'>A</text>",
        [0.0, 0.0],
        [19.2, 22.4],
        1024.0 * A,
    );
    let anchored =
        |anchor: &str| format!("<text x='50' y='100' {ten} text-anchor='{anchor}'>AA</text>");
    check(&anchored("middle"), [44.0, 0.0], [56.0, 7.0], 200.0 * A);
    check(&anchored("end"), [38.0, 0.0], [50.0, 7.0], 200.0 * A);
    // Blanks count as one, and none at the ends; a is 0.25 wide.
    check(
        &format!("<text y='100' {ten}>\n  A\n  A </text>"),
        [0.0, 0.0],
        [14.5, 7.0],
        200.0 * A,
    );
    check(
        &format!("<text y='100' {ten} letter-spacing='2'>AA</text>"),
        [0.0, 0.0],
        [14.0, 7.0],
        200.0 * A,
    );
    check(
        &format!("<text y='100' {ten} transform='rotate(-90 0 100)'>A</text>"),
        [-7.0, 0.0],
        [0.0, 6.0],
        100.0 * A,
    );
    // The same in a clip.
    let clip = format!("<clipPath id='c'><text y='100' {ten}>A</text></clipPath>");
    check(
        &format!("{clip}<rect clip-path='url(#c)' width='99' height='100'/>"),
        [0.0, 0.0],
        [6.0, 7.0],
        100.0 * A,
    );
}

#[test]
fn letters_of_svg_have_places_of_their_own() {
    let check = |content: &str, expected: &[[f64; 2]]| {
        let text = format!(
            "<svg viewBox='0 0 100 100'><text y='100' font-size='10' {content}</text></svg>"
        );
        let drawing = drawn("a.svg", &text);
        let corners: Vec<DVec2> = drawing
            .shapes
            .iter()
            .map(|s| s.figure.bounds().min)
            .collect();
        assert_eq!(corners.len(), expected.len(), "{content}: {corners:?}");
        for (corner, expected) in corners.iter().zip(expected) {
            assert!(
                corner.distance(DVec2::from(*expected)) < 1e-4,
                "{content}: {corners:?}"
            );
        }
    };
    check("x='1 20'>AAA", &[[1.0, 0.0], [20.0, 0.0]]);
    check("x='1' dx='0 3'>AA", &[[1.0, 0.0], [10.0, 0.0]]);
    check(
        "x='1' dy='0 -3 3'>AAA",
        &[[1.0, 0.0], [7.0, 3.0], [13.0, 0.0]],
    );
    check(
        ">A<tspan fill='red'>A</tspan>A",
        &[[0.0, 0.0], [6.0, 0.0], [12.0, 0.0]],
    );
    check(
        ">A<tspan x='50' y='50'>A</tspan>",
        &[[0.0, 0.0], [50.0, 50.0]],
    );
    check(">A<tspan dx='1em'>A</tspan>", &[[0.0, 0.0], [16.0, 0.0]]);
    check(
        "x='1 2 3'>A<tspan x='40 50'>A</tspan>A",
        &[[1.0, 0.0], [40.0, 0.0], [3.0, 0.0]],
    );
    check("rotate='-90'>AA", &[[-7.0, 0.0], [-1.0, 0.0]]);
    check("display='none'>A", &[]);
    check(
        "text-anchor='end' x='50'>A<tspan>A</tspan>",
        &[[38.0, 0.0], [44.0, 0.0]],
    );
}

#[test]
fn letters_of_svg_follow_paths() {
    let svg = |text: &str| {
        let paths = "<defs><path id='p' d='M10 50H90'/><path id='v' d='M50 90V10'/><circle id='c' r='20'/></defs>";
        format!("<svg viewBox='0 0 100 100'>{paths}<text font-size='10'>{text}</text></svg>")
    };
    let check = |text: &str, min: [f64; 2], max: [f64; 2]| {
        check_drawn("a.svg", &svg(text), min, max, 100.0 * A);
    };
    check(
        "<textPath href='#p'>A</textPath>",
        [10.0, 50.0],
        [16.0, 57.0],
    );
    check(
        "<textPath href='#p' startOffset='50%'>A</textPath>",
        [50.0, 50.0],
        [56.0, 57.0],
    );
    check(
        "<textPath href='#p' startOffset='50%' text-anchor='middle'>A</textPath>",
        [47.0, 50.0],
        [53.0, 57.0],
    );
    check(
        "<textPath href='#v'>A</textPath>",
        [43.0, 10.0],
        [50.0, 16.0],
    );
    // Beyond the end, nothing is drawn.
    assert!(
        drawn(
            "a.svg",
            &svg("<textPath href='#p' startOffset='78'>A</textPath>")
        )
        .shapes
        .is_empty()
    );
    let lost = drawn("a.svg", &svg("<textPath href='#q'>A</textPath>"));
    assert_eq!(
        lost.warnings[0].message,
        "textPath without a path: left out"
    );
}

/// Entities of a DXF drawing, after a STYLE with a font of strokes.
fn dxf(entities: &str) -> String {
    let style = "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nSTYLE\n0\nSTYLE\n2\nStandard\n3\ntxt.shx\n41\n1\n0\nENDTAB\n0\nENDSEC\n";
    format!("{style}0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n")
}

/// Heights are those of capital letters: an em of 10 for 7.
#[test]
fn text_of_dxf_is_justified_turned_and_stretched() {
    let check = |groups: &str, min: [f64; 2], max: [f64; 2], area: f64| {
        let text = dxf(&format!(
            "0\nTEXT\n8\n0\n1\nAA\n40\n7\n10\n5\n20\n2\n{groups}"
        ));
        check_drawn("a.dxf", &text, min, max, area);
    };
    let plain = 200.0 * A;
    check("", [5.0, 2.0], [17.0, 9.0], plain);
    check("41\n0.5\n", [5.0, 2.0], [11.0, 9.0], 0.5 * plain);
    check("50\n90\n", [-2.0, 2.0], [5.0, 14.0], plain);
    check("51\n45\n", [5.0, 2.0], [17.0 + 4.0, 9.0], plain);
    check("71\n2\n", [-7.0, 2.0], [5.0, 9.0], plain);
    check("71\n4\n", [5.0, -5.0], [17.0, 2.0], plain);
    // At the second point, unless it is fitted between both.
    let at = "11\n50\n21\n20\n";
    check(&format!("72\n1\n{at}"), [44.0, 20.0], [56.0, 27.0], plain);
    check(
        &format!("72\n2\n73\n3\n{at}"),
        [38.0, 13.0],
        [50.0, 20.0],
        plain,
    );
    check(&format!("72\n4\n{at}"), [44.0, 16.5], [56.0, 23.5], plain);
    check(
        "72\n5\n11\n29\n21\n2\n",
        [5.0, 2.0],
        [29.0, 9.0],
        2.0 * plain,
    );
    check(
        "72\n3\n11\n29\n21\n2\n",
        [5.0, 2.0],
        [29.0, 16.0],
        4.0 * plain,
    );
}

#[test]
fn paragraphs_of_dxf_are_attached_and_wrapped() {
    let check = |groups: &str, min: [f64; 2], max: [f64; 2], letters: f64| {
        let text = dxf(&format!("0\nMTEXT\n8\n0\n40\n7\n10\n5\n20\n2\n{groups}"));
        check_drawn("a.dxf", &text, min, max, letters * 100.0 * A);
    };
    // Baselines are 5/3 of the height apart.
    let next = 7.0 * 5.0 / 3.0;
    check("1\nAA\n", [5.0, -5.0], [17.0, 2.0], 2.0);
    check("1\nA\\PA\n71\n1\n", [5.0, -5.0 - next], [11.0, 2.0], 2.0);
    check("1\nA A\n41\n8\n", [5.0, -5.0 - next], [11.0, 2.0], 2.0);
    check("1\nA A\n41\n20\n", [5.0, -5.0], [19.5, 2.0], 2.0);
    check(
        "1\nA\\PA\n71\n1\n44\n2\n",
        [5.0, -5.0 - 2.0 * next],
        [11.0, 2.0],
        2.0,
    );
    check("1\nAA\n71\n5\n", [-1.0, -1.5], [11.0, 5.5], 2.0);
    check("1\nAA\n71\n9\n", [-7.0, 2.0], [5.0, 9.0], 2.0);
    check("1\nA\n50\n90\n", [5.0, 2.0], [12.0, 8.0], 1.0);
    check("1\nA\n11\n0\n21\n1\n", [5.0, 2.0], [12.0, 8.0], 1.0);
    check("1\n{\\H2x;A}\n", [5.0, -12.0], [17.0, 2.0], 4.0);
    check("1\n\\W0.5;A\n", [5.0, -5.0], [8.0, 2.0], 0.5);
    // Chunks of long texts: the last one has another code.
    check("3\nA\n1\nA\n", [5.0, -5.0], [17.0, 2.0], 2.0);
}

#[test]
fn letters_of_dxf_are_cut_out_of_their_layer_alone() {
    let square = "0\nLWPOLYLINE\n8\nplate\n70\n1\n10\n-10\n20\n-10\n10\n90\n20\n-10\n10\n90\n20\n90\n10\n-10\n20\n90\n";
    let text = |layer: &str, letters: &str| {
        format!("0\nTEXT\n8\n{layer}\n1\n{letters}\n40\n7\n10\n5\n20\n2\n")
    };
    // X is two boxes that overlap, which is one letter.
    let x = 0.4 * 0.7 + 0.4 * 0.4 - 0.2 * 0.4;
    let areas = |entities: &str| -> Vec<f64> {
        let drawing = drawn("a.dxf", &dxf(entities));
        drawing
            .shapes
            .iter()
            .map(|s| s.figure.outline().signed_area())
            .collect()
    };
    let one = areas(&format!("{square}{}", text("plate", "X")));
    assert!(
        one.len() == 1 && (one[0] - (1e4 - 100.0 * x)).abs() < 0.01,
        "{one:?}"
    );
    // Drawn twice, it counts once.
    let twice = format!("{square}{0}{0}", text("plate", "X"));
    assert_eq!(areas(&twice), one);
    let two = areas(&format!("{square}{}", text("words", "X")));
    assert!(
        two.len() == 2 && (two[0] - 1e4).abs() < 0.01 && (two[1] - 100.0 * x).abs() < 0.01,
        "{two:?}"
    );
}

#[test]
fn attributes_of_blocks_are_drawn_once() {
    let block = "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nb\n10\n0\n20\n0\n0\nTEXT\n8\n0\n1\nA\n40\n7\n10\n0\n20\n0\n
0\nATTDEF\n8\n0\n1\nA\n2\nTAG\n70\n0\n40\n7\n10\n50\n20\n0\n0\nENDBLK\n0\nENDSEC\n".replace("\n\n", "\n");
    let insert = "0\nINSERT\n8\nin\n2\nb\n10\n100\n20\n0\n41\n2\n42\n2\n66\n1\n0\nATTRIB\n8\nin\n1\nAA\n70\n0\n40\n7\n10\n0\n20\n50\n0\nSEQEND\n";
    let drawing = drawn(
        "a.dxf",
        &dxf(insert).replacen(
            "0\nSECTION\n2\nENTITIES",
            &format!("{block}0\nSECTION\n2\nENTITIES"),
            1,
        ),
    );
    assert_eq!(drawing.shapes.len(), 1);
    let shape = &drawing.shapes[0];
    assert_eq!(shape.name, "in");
    let bounds = shape.figure.bounds();
    let off = bounds.min.distance(DVec2::ZERO) + bounds.max.distance(DVec2::new(112.0, 57.0));
    assert!(off < 1e-5, "{bounds:?}");
    let area = shape.figure.outline().signed_area();
    assert!((area - (4.0 + 2.0) * 100.0 * A).abs() < 1e-3, "{area}");
    let remark = &drawing.warnings[0].message;
    assert_eq!(remark, "text that asks for txt.shx: set in Tiny");
}

#[test]
fn text_without_letters_is_named_in_drawings() {
    let check = |name: &str, text: &str, message: &str| {
        let read = read_drawing(
            text.as_bytes(),
            name,
            &Memory::new(),
            &ReadOptions::default(),
        );
        let drawing = read.unwrap();
        assert!(drawing.shapes.is_empty());
        let expected =
            format!("text \"{message}\": no font to set it in (install or name one), left out");
        assert_eq!(drawing.warnings[0].message, expected);
    };
    check("a.svg", "<svg><text>Hello</text></svg>", "Hello");
    check("a.dxf", &dxf("0\nTEXT\n8\n0\n1\n%%c20\n40\n7\n"), "Ø20");
    check("a.dxf", &dxf("0\nMTEXT\n8\n0\n1\nHello\n40\n7\n"), "Hello");
}
