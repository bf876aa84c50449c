use super::*;
use crate::Memory;
use crate::outline::drawing::Filled;
use azulejo_scene::{Figure, FillRule, Rgb};
use glam::DVec2;

/// Reads a whole file without errors.
fn read_text(text: &str) -> Drawing {
    let options = ReadOptions::default();
    read(text.as_bytes(), "a.svg", &Memory::new(), &options).unwrap()
}

fn drawing(content: &str) -> Drawing {
    let text =
        format!("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 100 100'>{content}</svg>");
    read_text(&text)
}

/// The only shape of a drawing without warnings.
fn only(content: &str) -> Filled {
    let drawing = drawing(content);
    let messages: Vec<String> = drawing.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        (drawing.shapes.len(), messages),
        (1, Vec::new()),
        "{content}"
    );
    drawing.shapes.into_iter().next().unwrap()
}

fn check_warning(content: &str, shapes: usize, message: &str) {
    let drawing = drawing(content);
    assert_eq!(drawing.shapes.len(), shapes, "{content}");
    let messages: Vec<&str> = drawing.warnings.iter().map(|w| &*w.message).collect();
    assert_eq!(messages, [message], "{content}");
}

#[test]
fn shapes_have_their_areas() {
    let check = |content: &str, area: f64| {
        let drawn_area = only(content).figure.signed_area().abs();
        assert!(
            (drawn_area - area).abs() < 1e-4 * area.max(1.0),
            "{content} {drawn_area} {area}"
        );
    };
    let pi = std::f64::consts::PI;
    check("<rect x='1' y='2' width='3' height='4'/>", 12.0);
    check("<rect width='1in' height='96'/>", 96.0 * 96.0);
    check("<rect width='6' height='4' rx='1'/>", 24.0 - (4.0 - pi));
    check("<rect width='6' height='4' rx='9' ry='9'/>", pi * 6.0);
    check("<circle cx='50' cy='50' r='10'/>", 100.0 * pi);
    check("<ellipse rx='10' ry='5'/>", 50.0 * pi);
    check("<polygon points='0,0 4,0 4,3'/>", 6.0);
    check("<polyline points='0,0 4,0 4,3 0,0'/>", 6.0);
    check("<path d='M0 0h4v3z'/>", 6.0);
    check(
        "<g transform='scale(2)'><g transform='rotate(30)'><path d='M0 0h4v3z'/></g></g>",
        24.0,
    );
}

#[test]
fn y_points_up_from_the_lower_left() {
    let corner = only("<rect x='10' y='80' width='5' height='20'/>")
        .figure
        .bounds();
    assert_eq!(
        (corner.min, corner.max),
        (DVec2::new(10.0, 0.0), DVec2::new(15.0, 20.0))
    );
    let text = "<svg height='50' width='9'><rect y='40' width='1' height='10'/></svg>";
    let drawing = read_text(text);
    assert_eq!(drawing.shapes[0].figure.bounds().min, DVec2::ZERO);
}

#[test]
fn units_are_known_where_the_drawing_has_a_size() {
    let check = |attributes: &str, metres: Option<f64>| {
        let text = format!("<svg {attributes}/>");
        let drawing = read_text(&text);
        let close = |(a, b): (f64, f64)| (a - b).abs() < 1e-12;
        assert_eq!(
            drawing.metres_per_unit.is_some(),
            metres.is_some(),
            "{attributes}"
        );
        assert!(
            drawing.metres_per_unit.zip(metres).is_none_or(close),
            "{attributes}"
        );
    };
    check("", None);
    check("width='100' viewBox='0 0 10 10'", None);
    check(
        "width='100mm' height='100mm' viewBox='0 0 50 50'",
        Some(0.002),
    );
    check("width='1in'", Some(0.0254 / 96.0));
}

#[test]
fn paint_is_inherited() {
    let check = |content: &str, expected: Option<[f64; 3]>| {
        let expected = expected.map(|[r, g, b]| Rgb::new(r, g, b));
        assert_eq!(only(content).color, expected, "{content}");
    };
    let path = "<path d='M0 0h1v1z'";
    check(&format!("{path}/>"), Some([0.0; 3]));
    check(
        &format!("<g fill='#f00'>{path}/></g>"),
        Some([1.0, 0.0, 0.0]),
    );
    check(
        &format!("<g fill='#f00'>{path} fill='lime'/></g>"),
        Some([0.0, 1.0, 0.0]),
    );
    check(
        &format!("{path} fill='red' style='fill: #00F;stroke:none'/>"),
        Some([0.0, 0.0, 1.0]),
    );
    check(
        &format!("<g color='red'>{path} fill='currentColor'/></g>"),
        Some([1.0, 0.0, 0.0]),
    );
    let sheet = "<style>/* .a{fill:red} */ .a, .b { fill : #00ff00; } path{fill:red}</style>";
    check(
        &format!("{sheet}{path} class='x b'/>"),
        Some([0.0, 1.0, 0.0]),
    );
    check(&format!("{sheet}{path}/>"), Some([1.0, 0.0, 0.0]));
}

#[test]
fn fill_rules_are_kept() {
    let star = "<path d='M0 3L2 -2L-3 1L3 1L-2 -2Z' ";
    assert_eq!(only(&format!("{star}/>")).figure.rule, FillRule::NonZero);
    let even_odd = only(&format!("<g fill-rule='evenodd'>{star}/></g>"));
    assert_eq!(even_odd.figure.rule, FillRule::EvenOdd);
}

#[test]
fn what_is_hidden_is_not_drawn() {
    for content in [
        "<g display='none'><path d='M0 0h1v1z'/></g>",
        "<path visibility='hidden' d='M0 0h1v1z'/>",
        "<path fill='none' d='M0 0h1v1z'/>",
        "<path fill-opacity='0' d='M0 0h1v1z'/>",
        "<defs><path d='M0 0h1v1z'/></defs>",
        "<rect width='0' height='4'/>",
        "<path d=''/>",
        "<!-- --><title>t</title>",
    ] {
        let drawing = drawing(content);
        assert_eq!(
            (drawing.shapes.len(), drawing.warnings.len()),
            (0, 0),
            "{content}"
        );
    }
}

#[test]
fn use_draws_with_its_own_transform() {
    let defs = "<defs><g id='a'><rect id='r' width='1' height='1'/></g></defs>";
    let check = |content: &str, min: [f64; 2]| {
        let corner = only(&format!("{defs}{content}")).figure.bounds().min;
        assert_eq!(corner, DVec2::from(min), "{content}");
    };
    check("<use href='#a'/>", [0.0, 99.0]);
    check(
        "<use href='#r' x='3' y='5' transform='scale(2)'/>",
        [6.0, 88.0],
    );
    let link = "xmlns:x='http://www.w3.org/1999/xlink' x:href='#a'";
    check(&format!("<use {link}/>"), [0.0, 99.0]);
}

#[test]
fn left_out_elements_are_reported() {
    let no_font = "text \"a b\": no font to set it in (install or name one), left out";
    check_warning("<text>\n a\n b </text>", 0, no_font);
    check_warning("<image/>", 0, "image: left out");
    check_warning(
        "<path fill='none' stroke='red' stroke-dasharray='1e-6' d='M0 0h1'/>",
        0,
        "stroke-dasharray of too many dashes: stroke left out",
    );
    check_warning(
        "<path fill='none' stroke='red' stroke-width='1e-9' d='M0 0h1'/>",
        0,
        "stroke too thin to be seen: left out",
    );
    check_warning(
        "<path d='M0 0h1v1'/>",
        1,
        "open outline: closed by a straight line, as for filling",
    );
    let cut = "malformed path or points: drawn up to the error";
    check_warning("<path d='M0 0h1v1zX'/>", 1, cut);
    check_warning("<polygon points='0 0 1 0 1 1 7'/>", 1, cut);
    let paint = "paint that is not a single colour: not kept";
    check_warning("<path fill='url(#g)' d='M0 0h1v1z'/>", 1, paint);
    let rect = "<rect width='1' height='1'/>";
    let check_clip = |content: &str, message: &str| {
        check_warning(&format!("<g {content}>{rect}</g>"), 1, message);
    };
    check_clip(
        "clip-path='url(#c)'",
        "clip-path that does not exist: not applied",
    );
    check_clip(
        "style='clip-path:circle(3px)'",
        "clip-path that names no element: not applied",
    );
    check_clip("style='marker-end:url(#m)'", "marker-end: not applied");
    check_clip("mask='url(#m)'", "mask: not applied");
    check_clip("style='filter:url(#m)'", "filter: not applied");
    check_clip(
        "vector-effect='non-scaling-stroke'",
        "vector-effect: not applied",
    );
    let circle = "<clipPath id='c' clip-path='url(#c)'><rect width='9' height='9'/></clipPath>";
    let content = format!("{circle}<rect clip-path='url(#c)' width='1' height='1'/>");
    check_warning(
        &content,
        1,
        "clip-path nested more than 8 deep: not applied",
    );
    check_warning(
        "<g transform='spin(3)'/>",
        0,
        "malformed transform: not applied",
    );
    check_warning(
        "<rect width='5q' height='1'/>",
        0,
        "shape with a length in an unknown unit: left out",
    );
    check_warning(
        "<use href='#no'/>",
        0,
        "use of an element that does not exist: left out",
    );
    let deep = "use nested more than 32 deep: left out";
    check_warning("<g id='a'><use href='#a'/></g>", 0, deep);
    let sheet = "style sheet rule whose selector is not a single class, id or element: not applied";
    check_warning("<style>g > path {fill:red}</style>", 0, sheet);
}

#[test]
fn other_files_are_refused() {
    let check = |text: &str, message: &str| {
        let error = read(
            text.as_bytes(),
            "a.svg",
            &Memory::new(),
            &ReadOptions::default(),
        )
        .unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    };
    check("<svg><g></svg>", "not well-formed");
    check("<html/>", "expected the element svg");
    check("<!DOCTYPE svg [<!ENTITY a 'b'>]><svg/>", "SVG without them");
}

#[test]
fn expansion_is_limited() {
    let mut content = String::from("<g id='g0'><path d='M0 0h1v1z'/></g>");
    for i in 1..30 {
        let inner = format!("<use href='#g{}'/>", i - 1);
        content += &format!("<g id='g{i}'>{inner}{inner}</g>");
    }
    let text = format!("<svg>{content}</svg>");
    let options = ReadOptions::in_proportion(text.len());
    assert!(read(text.as_bytes(), "a.svg", &Memory::new(), &options).is_err());
}

#[test]
fn deep_files_do_not_overflow() {
    let text = format!("<svg>{}{}</svg>", "<g>".repeat(900), "</g>".repeat(900));
    assert!(
        read(
            text.as_bytes(),
            "a.svg",
            &Memory::new(),
            &ReadOptions::default()
        )
        .is_ok()
    );
}

/// Each takes seconds to hours where attributes, rules or repeated elements are compared with each other.
#[test]
fn crowded_elements_take_no_quadratic_time() {
    let error = |content: &str| {
        let text = format!("<svg>{content}</svg>");
        let read = read(
            text.as_bytes(),
            "a.svg",
            &Memory::new(),
            &ReadOptions::default(),
        );
        read.unwrap_err().to_string()
    };
    let many: String = (0..300_000).map(|k| format!(" a{k}=''")).collect();
    let message = error(&format!("<g/><g{many}/>"));
    assert!(message.contains("more than 1000 attributes"), "{message}");
    let spaces: String = (0..900).map(|k| format!(" xmlns:a{k}='u{k}'")).collect();
    let message = error(&format!("<g{spaces}>{}</g>", "<a899:g/>".repeat(100_000)));
    assert!(message.contains("more than 256 namespaces"), "{message}");
    // A hundred thousand classes with as many declarations.
    let fill = "fill:red;".repeat(100_000);
    let classes = "a ".repeat(100_000);
    let path = "<path d='M0 0h4v3z'/>";
    let drawing = drawing(&format!(
        "<style>.a{{{fill}fill:blue}}</style><g class='{classes}'>{path}</g>"
    ));
    assert_eq!(drawing.shapes[0].color, Some(Rgb::new(0.0, 0.0, 1.0)));
    // A long element in a million places.
    let uses = |k: usize| {
        format!(
            "<g id='u{}'>{}</g>",
            k + 1,
            format!("<use href='#u{k}'/>").repeat(10)
        )
    };
    let doubling: String = (0..6).map(uses).collect();
    let long = format!("<g id='u0' class='{classes}'>{path}</g>");
    let message = error(&format!("<defs>{long}{doubling}</defs><use href='#u6'/>"));
    assert!(message.contains("expand to more than"), "{message}");
}

/// The areas of strokes: of straight ones exact, of round ones to the tolerance of their edges.
#[test]
fn strokes_are_figures() {
    use std::f64::consts::PI;
    let areas = |svg: &str| -> Vec<f64> {
        let drawing = drawing(svg);
        assert!(drawing.warnings.is_empty(), "{svg}: {:?}", drawing.warnings);
        let area = |figure: &Figure| {
            // Where edges overlap, they count once. Points of Roberts' sequence R2 (2018).
            let (b, count) = (figure.bounds(), 60_000);
            let inside = (0..count).filter(|k| {
                let share =
                    f64::from(*k) * DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_3);
                figure.contains(b.min + share.fract() * b.size())
            });
            inside.count() as f64 / f64::from(count) * b.size().x * b.size().y
        };
        drawing.shapes.iter().map(|s| area(&s.figure)).collect()
    };
    let check = |svg: &str, expected: &[f64]| {
        let found = areas(svg);
        assert_eq!(found.len(), expected.len(), "{svg}: {found:?}");
        for (a, b) in found.iter().zip(expected) {
            assert!((a / b - 1.0).abs() < 0.01, "{svg}: {found:?}");
        }
    };
    let none = "fill='none' stroke='red'";
    check(
        &format!("<line {none} x1='1' x2='11' stroke-width='2'/>"),
        &[20.0],
    );
    check(
        &format!("<line {none} x2='10' stroke-width='2' stroke-linecap='square'/>"),
        &[24.0],
    );
    check(
        &format!("<line {none} x2='10' stroke-width='2' stroke-linecap='round'/>"),
        &[20.0 + PI],
    );
    check(
        &format!("<path {none} d='M0 0H10V10' stroke-width='2'/>"),
        &[40.0],
    );
    check(
        &format!(
            "<polyline {none} points='0 0 10 0 10 10' stroke-width='2' stroke-linejoin='bevel'/>"
        ),
        &[39.5],
    );
    check(
        &format!("<rect {none} width='10' height='10' stroke-width='1'/>"),
        &[121.0 - 81.0],
    );
    check(
        &format!("<circle {none} r='10' stroke-width='2'/>"),
        &[PI * (121.0 - 81.0)],
    );
    // In millimetres, by a style sheet, under a map that stretches, and after what is filled.
    check(
        "<style>.a { stroke: #00f; stroke-width: 25.4mm }</style><g transform='scale(2,1)'><line class='a' x2='10'/></g>",
        &[96.0 * 20.0],
    );
    check(
        "<rect width='4' height='4' fill='#0f0' stroke='#000' stroke-width='1'/>",
        &[16.0, 25.0 - 9.0],
    );
    check(
        "<rect width='4' height='4' stroke='#000' stroke-width='0'/>",
        &[16.0],
    );
    check(
        "<line x2='10' stroke='none'/><line x2='10' stroke='red' opacity='0'/>",
        &[],
    );
    let both = drawing("<rect width='4' height='4' fill='#0f0' stroke='#00f'/>");
    assert_eq!(both.shapes[1].color, Some(Rgb::new(0.0, 0.0, 1.0)));
}

/// The sum of the areas that the shapes of a drawing without warnings fill.
fn check_clipped(content: &str, expected: f64) {
    let drawing = drawing(content);
    assert!(
        drawing.warnings.is_empty(),
        "{content}: {:?}",
        drawing.warnings
    );
    let areas = drawing
        .shapes
        .iter()
        .map(|s| s.figure.outline().signed_area());
    let area: f64 = areas.sum();
    assert!(
        (area - expected).abs() < 1e-3 * expected.max(0.01),
        "{content}: {area}"
    );
}

#[test]
fn shapes_are_clipped() {
    let pi = std::f64::consts::PI;
    let square = "<rect width='20' height='20'/>";
    let check = |clip: &str, shape: &str, area: f64| {
        check_clipped(&format!("<clipPath id='c' {clip}</clipPath>{shape}"), area);
    };
    let by_c = "clip-path='url(#c)'";
    let own = format!("<rect {by_c} width='20' height='20'/>");
    check("><circle r='10'/>", &own, 0.25 * pi * 100.0);
    // Also where the clip is an element in a group with a transform, or a use, or clipped itself.
    let group = format!("<g {by_c} transform='scale(2)'>{square}</g>");
    check("><circle r='10'/>", &group, pi * 100.0);
    let round = "><circle id='k' r='10' clip-path='url(#d)'/>";
    let inner = "<clipPath id='d'><rect x='5' width='9' height='99'/></clipPath>";
    let segment = 100.0 * (pi / 3.0 - 0.75_f64.sqrt() / 2.0) / 2.0;
    check(round, &format!("{inner}{own}"), segment);
    check(
        "><use href='#r'/>",
        &format!("<defs><rect id='r' x='15' width='10' height='10'/></defs>{own}"),
        50.0,
    );
    // Two shapes count once where they overlap; rules are those of clipping.
    check("><circle r='10'/><circle r='10'/>", &own, 0.25 * pi * 100.0);
    let ring = "M0 0h10v10h-10zM2 2h6v6h-6z";
    check(&format!("><path d='{ring}'/>"), &own, 100.0);
    check(
        &format!("><path clip-rule='evenodd' d='{ring}'/>"),
        &own,
        64.0,
    );
    // In units of the box of what is clipped, with a transform, and invisible.
    check(
        "clipPathUnits='objectBoundingBox'><rect width='.5' height='1'/>",
        &own,
        200.0,
    );
    check(
        "transform='scale(.5)'><circle r='10'/>",
        &own,
        0.25 * pi * 25.0,
    );
    check("><circle r='10' display='none'/>", &own, 0.0);
    check(">", &own, 0.0);
    // Strokes are clipped, too: as wide as the clip, and with round ends.
    let line = format!("<line {by_c} x1='-9' x2='30' stroke='red' stroke-width='4'/>");
    check("><rect y='-9' width='5' height='20'/>", &line, 20.0);
}

#[test]
fn viewports_move_scale_and_clip() {
    let rect = |x: f64, y: f64, w: f64, h: f64| {
        format!("<rect x='{x}' y='{y}' width='{w}' height='{h}'/>")
    };
    let check = |content: &str, min: [f64; 2], max: [f64; 2]| {
        let bounds = only(content).figure.bounds();
        let off = bounds.min.distance(min.into()) + bounds.max.distance(max.into());
        assert!(off < 1e-5, "{content}: {bounds:?}");
    };
    let whole = rect(0.0, 0.0, 10.0, 10.0);
    // The drawing is 100 x 100 with y down.
    check(
        &format!("<svg x='10' y='20' width='30' height='30'>{whole}</svg>"),
        [10.0, 70.0],
        [20.0, 80.0],
    );
    check(
        &format!("<svg width='30' height='30' viewBox='0 0 10 10'>{whole}</svg>"),
        [0.0, 70.0],
        [30.0, 100.0],
    );
    let wide = |aspect: &str| {
        format!(
            "<svg width='40' height='20' viewBox='0 0 10 10' preserveAspectRatio='{aspect}'>{whole}</svg>"
        )
    };
    check(&wide("xMidYMid"), [10.0, 80.0], [30.0, 100.0]);
    check(&wide("xMaxYMin meet"), [20.0, 80.0], [40.0, 100.0]);
    check(&wide("none"), [0.0, 80.0], [40.0, 100.0]);
    check(&wide("xMinYMin slice"), [0.0, 80.0], [40.0, 100.0]);
    // What is outside is not shown, unless it may be.
    let large = rect(-50.0, -50.0, 200.0, 200.0);
    check(
        &format!("<svg x='1' y='2' width='3' height='4'>{large}</svg>"),
        [1.0, 94.0],
        [4.0, 98.0],
    );
    check(
        &format!("<svg width='3' height='4' overflow='visible'>{large}</svg>"),
        [-50.0, -50.0],
        [150.0, 150.0],
    );
    let symbol = format!("<symbol id='s' viewBox='0 0 10 10'>{whole}</symbol>");
    check(
        &format!("{symbol}<use href='#s' x='5' width='20' height='20'/>"),
        [5.0, 80.0],
        [25.0, 100.0],
    );
    // Per cents are of the nearest viewport, ems of the font.
    check(
        "<rect width='50%' height='10%'/>",
        [0.0, 90.0],
        [50.0, 100.0],
    );
    check(
        "<svg width='50%' height='50%'><rect width='50%' height='10%'/></svg>",
        [0.0, 95.0],
        [25.0, 100.0],
    );
    check(
        "<g font-size='20'><rect width='1em' height='2em'/></g>",
        [0.0, 60.0],
        [20.0, 100.0],
    );
    let first = format!("<switch><g requiredExtensions='x'>{large}</g>{whole}{large}</switch>");
    check(&first, [0.0, 90.0], [10.0, 100.0]);
}

#[test]
fn strokes_have_gaps() {
    let check = |dashes: &str, area: f64| {
        check_clipped(
            &format!("<line x2='20' stroke='red' stroke-width='2' {dashes}/>"),
            area,
        );
    };
    check("stroke-dasharray='3 1'", 30.0);
    check("stroke-dasharray='3 1' stroke-dashoffset='2'", 30.0);
    check("stroke-dasharray='2'", 20.0);
    check("stroke-dasharray='10%,10%'", 20.0);
    check("stroke-dasharray='none'", 40.0);
    check("stroke-dasharray='-1 2'", 40.0);
    check("stroke-dasharray='0 0'", 40.0);
}

/// A path of 100,000 corners that crosses itself, a stroke of it, and a clip.
#[test]
fn long_outlines_take_no_quadratic_time() {
    let corner = |k: u32| {
        let turn = f64::from(k) * 0.01;
        format!(
            "{:.3} {:.3} ",
            50.0 + 40.0 * turn.cos() * (0.3 * turn).sin(),
            50.0 + 40.0 * turn.sin()
        )
    };
    let points: String = (0..100_000).map(corner).collect();
    let polygon = format!("<polygon points='{points}' fill-rule='evenodd'/>");
    assert_eq!(drawing(&polygon).shapes[0].figure.curve_count(), 100_000);
}
