use super::*;
use crate::outline::drawing::Filled;
use azulejo_scene::{Figure, Rgb};
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::io::Write as _;

/// A file of these objects, the first of which is the catalogue; streams have their length and their tables are right.
fn file(objects: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"%PDF-1.7\n".to_vec();
    let mut places = Vec::new();
    for (k, object) in objects.iter().enumerate() {
        places.push(bytes.len());
        bytes.extend(format!("{} 0 obj\n", k + 1).into_bytes());
        bytes.extend_from_slice(object);
        bytes.extend(b"\nendobj\n");
    }
    let start = bytes.len();
    let mut table = format!("xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
    for place in places {
        writeln!(table, "{place:010} 00000 n ").unwrap();
    }
    let size = objects.len() + 1;
    write!(
        table,
        "trailer\n<</Size {size}/Root 1 0 R>>\nstartxref\n{start}\n%%EOF\n"
    )
    .unwrap();
    bytes.extend(table.into_bytes());
    bytes
}

fn stream(entries: &str, data: &[u8]) -> Vec<u8> {
    let head = format!("<<{entries}/Length {}>>\nstream\n", data.len());
    [head.as_bytes(), data, b"\nendstream"].concat()
}

/// A file of one page of 100 by 100 that draws `content`; `page` are further entries of the page, and `more` objects from
/// number 5 on.
fn page_file(page: &str, content: &[u8], more: &[Vec<u8>]) -> Vec<u8> {
    let first = [
        b"<</Type/Catalog/Pages 2 0 R/OCProperties<</OCGs[9 0 R]/D<</OFF[9 0 R]>>>>>>".to_vec(),
        b"<</Type/Pages/Kids[3 0 R]/Count 1/MediaBox[0 0 100 100]>>".to_vec(),
        format!("<</Type/Page/Parent 2 0 R/Contents 4 0 R{page}>>").into_bytes(),
        stream("", content),
    ];
    file(&[&first[..], more].concat())
}

fn try_read(bytes: &[u8]) -> Result<Drawing, ReadError> {
    read(bytes, "a.pdf", &ReadOptions::default())
}

fn drawn(page: &str, content: &str, more: &[Vec<u8>]) -> Drawing {
    try_read(&page_file(page, content.as_bytes(), more)).unwrap()
}

fn messages(drawing: &Drawing) -> Vec<&str> {
    drawing.warnings.iter().map(|w| &*w.message).collect()
}

/// The only shape of a page without warnings.
fn only(content: &str) -> Filled {
    let drawing = drawn("", content, &[]);
    assert_eq!(
        (drawing.shapes.len(), messages(&drawing)),
        (1, vec![]),
        "{content}"
    );
    drawing.shapes.into_iter().next().unwrap()
}

/// The area that is inside, whatever the rule.
fn area(figure: &Figure) -> f64 {
    Figure::union(&[figure]).signed_area().abs()
}

fn check_area(content: &str, expected: f64) {
    let area = area(&only(content).figure);
    assert!(
        (area - expected).abs() < 1e-3 * expected.max(1.0),
        "{content}: {area} {expected}"
    );
}

fn bounds(figure: &Figure) -> [f64; 4] {
    let bounds = figure.bounds();
    [bounds.min.x, bounds.min.y, bounds.max.x, bounds.max.y]
}

fn check_bounds(page: &str, content: &str, expected: [f64; 4]) {
    let drawing = drawn(page, content, &[]);
    near(bounds(&drawing.shapes[0].figure), expected);
}

fn near(found: [f64; 4], expected: [f64; 4]) {
    let off = std::array::from_fn::<f64, 4, _>(|k| (found[k] - expected[k]).abs());
    assert!(off.iter().all(|off| *off < 1e-5), "{found:?} {expected:?}");
}

#[test]
fn paths_have_their_areas() {
    check_area("1 2 3 4 re f", 12.0);
    check_area("0 0 m 4 0 l 4 3 l f", 6.0);
    // Bézier's approximation of a circle.
    let circle = "60 50 m 60 55.5228 55.5228 60 50 60 c 44.4772 60 40 55.5228 40 50 c \
                  40 44.4772 44.4772 40 50 40 c 55.5228 40 60 44.4772 60 50 c h";
    check_area(&format!("{circle} f"), 100.0 * PI);
    // x = 10 t³, y = 30 t² − 20 t³, and its mirror image.
    check_area("0 0 m 0 10 10 10 v 10 0 l f", 80.0);
    check_area("0 0 m 0 10 10 10 y 10 0 l f", 80.0);
    let rings = "0 0 9 9 re 3 3 3 3 re";
    check_area(&format!("{rings} f*"), 72.0);
    check_area(&format!("{rings} f"), 81.0);
    check_area("0 0 m 4 0 l 4 0 l 4 3 l f", 6.0);
}

#[test]
fn strokes_have_their_areas() {
    check_area("2 w 10 10 m 30 10 l S", 40.0);
    check_area("2 w 2 J 10 10 m 30 10 l S", 44.0);
    check_area("2 w 1 J 10 10 m 30 10 l S", 40.0 + PI);
    check_area("2 w 10 10 20 20 re S", 160.0);
    check_area("2 w 1 j 10 10 20 20 re S", 160.0 - (4.0 - PI));
    check_area("2 w [3 2] 0 d 10 10 m 30 10 l S", 24.0);
    check_area("2 w [3] 4 d 10 10 m 30 10 l S", 18.0);
    // The pen is turned and stretched as all else is.
    check_area("3 0 0 1 0 0 cm 2 w 10 10 m 10 30 l S", 120.0);
    let both = drawn("", "1 0 0 rg 0 0 1 RG 2 w 10 10 20 20 re B", &[]);
    let areas: Vec<f64> = both.shapes.iter().map(|s| area(&s.figure)).collect();
    assert!(
        (areas[0] - 400.0).abs() < 1e-9 && (areas[1] - 160.0).abs() < 1e-3,
        "{areas:?}"
    );
    assert_eq!(both.shapes[1].color, Some(Rgb::new(0.0, 0.0, 1.0)));
}

#[test]
fn lines_without_a_width_are_left_out() {
    for content in ["0 w 10 10 m 30 10 l S", "0.000000001 w 10 10 m 30 10 l S"] {
        let drawing = drawn("", content, &[]);
        assert_eq!(drawing.shapes, [], "{content}");
        assert_eq!(
            messages(&drawing),
            ["line without a width, or too thin to be seen: left out"]
        );
    }
    // Shapes without an area are not even lines.
    for (content, shapes) in [("10 10 m 30 10 l f", 0), ("10 10 m 30 10 l B", 1)] {
        let drawing = drawn("", content, &[]);
        assert_eq!(
            (drawing.shapes.len(), messages(&drawing)),
            (shapes, vec![]),
            "{content}"
        );
    }
}

#[test]
fn pages_are_seen_as_they_are_turned() {
    let mark = "10 20 5 3 re f";
    check_bounds("", mark, [10.0, 20.0, 15.0, 23.0]);
    let cut = "/CropBox[5 10 80 60]";
    check_bounds(cut, mark, [5.0, 10.0, 10.0, 13.0]);
    check_bounds(&format!("{cut}/Rotate 90"), mark, [10.0, 65.0, 13.0, 70.0]);
    check_bounds(&format!("{cut}/Rotate 180"), mark, [65.0, 37.0, 70.0, 40.0]);
    check_bounds(&format!("{cut}/Rotate -90"), mark, [37.0, 5.0, 40.0, 10.0]);
    // What is outside of the page is not seen.
    check_bounds(cut, "-9 -9 30 30 re f", [0.0, 0.0, 16.0, 11.0]);
    assert_eq!(drawn("/CropBox[50 50 90 90]", mark, &[]).shapes, []);
    let metres = |page: &str| drawn(page, mark, &[]).metres_per_unit.unwrap();
    assert!((72.0 * metres("") - 0.0254).abs() < 1e-15);
    assert!((72.0 * metres("/UserUnit 10") - 0.254).abs() < 1e-14);
}

#[test]
fn states_are_saved_and_clips_cut() {
    check_bounds("", "q 2 0 0 2 1 1 cm 0 0 1 1 re f Q", [1.0, 1.0, 3.0, 3.0]);
    check_area("q 0 0 10 10 re W n 5 5 20 20 re f Q", 25.0);
    check_area("q 0 0 10 10 re W n Q 5 5 20 20 re f", 400.0);
    check_area("0 0 10 10 re W n 5 5 10 10 re W n 7 0 20 20 re f", 15.0);
    // A ring.
    check_area(
        "0 0 9 9 re 3 3 3 3 re W* n 0 0 m 99 0 l 99 99 l 0 99 l f",
        72.0,
    );
    let circle = "10 0 m 10 5.5228 5.5228 10 0 10 c -5.5228 10 -10 5.5228 -10 0 c \
                  -10 -5.5228 -5.5228 -10 0 -10 c 5.5228 -10 10 -5.5228 10 0 c h";
    check_area(
        &format!("1 0 0 1 50 50 cm {circle} W n 0 0 99 99 re f"),
        25.0 * PI,
    );
}

#[test]
fn colours_are_linear() {
    let check = |paint: &str, srgb: [f64; 3]| {
        let color = only(&format!("{paint} 0 0 9 9 re f")).color.unwrap();
        let expected = Rgb::from(srgb.map(crate::picture::srgb::linear_from_srgb_f64));
        let off = [0, 1, 2].map(|k| (color.to_array()[k] - expected.to_array()[k]).abs());
        assert!(
            off.into_iter().fold(0.0, f64::max) < 0.006,
            "{paint}: {color:?} {expected:?}"
        );
    };
    check("1 0 0 rg", [1.0, 0.0, 0.0]);
    check("0.5 g", [0.5; 3]);
    check("/DeviceRGB cs 0.2 0.4 0.6 sc", [0.2, 0.4, 0.6]);
    check("0 0 0 0 k", [1.0; 3]);
    // Black ink alone is #231f20 in the profile that the reader has, as in most programs for print.
    check("0 0 0 1 k", [35.0, 31.0, 32.0].map(|part| part / 255.0));
}

#[test]
fn gradients_and_patterns_have_no_colour() {
    let resources = "/Resources<</Shading<</S 5 0 R>>/Pattern<</P 6 0 R>>/ExtGState<</G<</ca 0.5>>/H<</ca 0>>>>>>";
    let more = [
        b"<</ShadingType 2/ColorSpace/DeviceRGB/Coords[0 0 1 0]/Function<</FunctionType 2/Domain[0 1]\
          /C0[1 0 0]/C1[0 0 1]/N 1>>>>"
            .to_vec(),
        b"<</PatternType 2/Shading 5 0 R>>".to_vec(),
    ];
    for content in [
        "q 10 10 m 40 10 l 40 50 l W n /S sh Q",
        "/Pattern cs /P scn 10 10 m 40 10 l 40 50 l f",
    ] {
        let drawing = drawn(resources, content, &more);
        assert!(
            (area(&drawing.shapes[0].figure) - 600.0).abs() < 1e-6,
            "{content}"
        );
        assert_eq!(drawing.shapes[0].color, None);
        assert_eq!(
            messages(&drawing),
            ["paint that is not a single colour: not kept"]
        );
    }
    let drawing = drawn(resources, "/G gs 0 0 9 9 re f /H gs 9 9 9 9 re f", &more);
    assert_eq!(
        (drawing.shapes.len(), messages(&drawing)),
        (1, vec![device::TRANSLUCENT])
    );
}

/// Resources of forms (`F` 5, `G` 6, `I` an image 7), a letter (8), and something that is not shown (9).
fn forms(f: &str, g: &str) -> (String, Vec<Vec<u8>>) {
    let page = "/Resources 10 0 R".to_owned();
    let form = |content: &str| {
        let entries =
            "/Type/XObject/Subtype/Form/BBox[0 0 10 10]/Matrix[2 0 0 2 0 0]/Resources 10 0 R";
        stream(entries, content.as_bytes())
    };
    let image =
        "/Type/XObject/Subtype/Image/Width 1/Height 1/ColorSpace/DeviceGray/BitsPerComponent 8";
    let letter = stream(
        "",
        b"1000 0 0 0 750 750 d1 0 0 500 500 re f /T 1000 Tf (a) Tj",
    );
    let more = vec![
        form(f),
        form(g),
        stream(image, b"x"),
        letter,
        b"<</Type/OCG/Name(hidden)>>".to_vec(),
        b"<</XObject<</F 5 0 R/G 6 0 R/I 7 0 R>>/Font<</T 11 0 R/H 12 0 R>>/Properties<</O 9 0 R>>>>".to_vec(),
        b"<</Type/Font/Subtype/Type3/FontBBox[0 0 750 750]/FontMatrix[.001 0 0 .001 0 0]/FirstChar 97/LastChar 97\
          /Widths[1000]/CharProcs<</a 8 0 R>>/Encoding<</Type/Encoding/Differences[97/a]>>/Resources 10 0 R>>"
            .to_vec(),
        b"<</Type/Font/Subtype/Type1/BaseFont/Helvetica>>".to_vec(),
    ];
    (page, more)
}

#[test]
fn forms_are_placed_and_cut() {
    let (page, more) = forms("1 1 20 3 re f /G Do", "0 0 1 1 re f");
    let drawing = drawn(&page, "1 0 0 1 30 30 cm /F Do", &more);
    let expected = [[32.0, 32.0, 50.0, 38.0], [30.0, 30.0, 34.0, 34.0]];
    assert_eq!(drawing.shapes.len(), 2);
    for (shape, expected) in drawing.shapes.iter().zip(expected) {
        near(bounds(&shape.figure), expected);
    }
    let drawing = drawn(&page, "/OC /O BDC /F Do EMC 0 0 1 1 re f", &more);
    assert_eq!(drawing.shapes.len(), 1);
}

#[test]
fn forms_that_draw_themselves_end() {
    let (page, more) = forms("/F Do 0 0 1 1 re f", "");
    assert_eq!(drawn(&page, "/F Do", &more).shapes.len(), 50);
    // Twice as many at each level.
    let (page, more) = forms("/F Do /G Do", "/F Do /G Do 0 0 1 1 re f");
    let bytes = page_file(&page, b"/F Do", &more);
    let error = read(&bytes, "a.pdf", &ReadOptions::in_proportion(bytes.len())).unwrap_err();
    assert!(error.to_string().contains("expand to more than"), "{error}");
    let stopped = Cell::new(None);
    let options = ReadOptions::default();
    let slow = catch_unwind(AssertUnwindSafe(|| {
        interpreted(
            &bytes,
            "a.pdf",
            &options,
            Duration::from_millis(50),
            &stopped,
        )
    }));
    assert!(slow.is_err());
    let error = stopped.take().unwrap().to_string();
    assert!(error.contains("takes longer than 50ms"), "{error}");
}

#[test]
fn letters_are_outlines() {
    let (page, more) = forms("", "");
    let drawing = drawn(
        &page,
        "BT /H 20 Tf 10 10 Td (II) Tj 0 30 Td 3 Tr (I) Tj ET",
        &more,
    );
    assert_eq!(
        messages(&drawing),
        [
            "font Helvetica is not in the file: its letters, if any, are those of a similar one of PDFium's"
        ]
    );
    // Two bars, 278 thousandths of the size apart, as high as Helvetica's capitals.
    let [bars] = &drawing.shapes[..] else {
        panic!("{:?}", drawing.shapes)
    };
    assert_eq!(bars.figure.contours.len(), 2);
    let [x0, y0, x1, y1] = bounds(&bars.figure);
    let one = Figure {
        contours: bars.figure.contours[..1].to_vec(),
        rule: bars.figure.rule,
    };
    let width = one.bounds().size().x;
    assert!(
        (x1 - x0 - width - 20.0 * 0.278).abs() < 1e-3,
        "{x0} {x1} {width}"
    );
    assert!(
        (y0 - 10.0).abs() < 0.1 && (y1 - y0 - 14.4).abs() < 0.3,
        "{y0} {y1}"
    );
    // A letter that is a drawing, and contains itself.
    let drawing = drawn(&page, "BT /T 20 Tf 10 10 Td 0 0 1 rg (a) Tj ET", &more);
    assert_eq!(bounds(&drawing.shapes[0].figure), [10.0, 10.0, 20.0, 20.0]);
    assert_eq!(drawing.shapes[0].color, Some(Rgb::new(0.0, 0.0, 1.0)));
    assert_eq!(drawing.shapes.len(), 8);
    assert_eq!(
        messages(&drawing),
        ["letters nested more than 8 deep: left out"]
    );
}

#[test]
fn pictures_are_left_out() {
    let (page, more) = forms("", "");
    let drawing = drawn(&page, "/I Do 0 0 1 1 re f /I Do", &more);
    assert_eq!(
        drawing.warnings[0].to_string(),
        "a.pdf: picture: left out (2 times)"
    );
    let error = try_read(&page_file(&page, b"/I Do", &more)).unwrap_err();
    assert_eq!(&*error.found, "page 1 with 1 pictures and no outlines");
    assert!(error.expected.contains("trace the picture"));
}

#[test]
fn pages_have_numbers() {
    let page =
        |content: u32| format!("<</Type/Page/Parent 2 0 R/Contents {content} 0 R>>").into_bytes();
    let bytes = file(&[
        b"<</Type/Catalog/Pages 2 0 R>>".to_vec(),
        b"<</Type/Pages/Kids[3 0 R 4 0 R]/Count 2/MediaBox[0 0 9 9]>>".to_vec(),
        page(5),
        page(6),
        stream("", b"0 0 1 1 re f"),
        stream("", b"0 0 2 2 re f"),
    ]);
    let read = |page| {
        let options = ReadOptions {
            page,
            ..ReadOptions::default()
        };
        read(&bytes, "a.pdf", &options)
    };
    let size = |page| read(page).unwrap().shapes[0].figure.signed_area().abs();
    assert_eq!([size(None), size(Some(1)), size(Some(2))], [1.0, 1.0, 4.0]);
    assert!(messages(&read(None).unwrap())[0].starts_with("one of 2 pages is taken"));
    assert_eq!(messages(&read(Some(2)).unwrap()), [""; 0]);
    for page in [0, 3, usize::MAX] {
        let error = read(Some(page)).unwrap_err();
        assert_eq!(
            (&*error.found, &*error.expected),
            (&*format!("no page {page}"), "a page from 1 to 2")
        );
    }
}

#[test]
fn numbers_may_be_huge() {
    for content in [
        "1e300 0 0 1e300 0 0 cm 1e300 0 0 1e300 0 0 cm 0 0 1 1 re f",
        "1 0 0 1 99999999999999999999999999999999999999999 0 cm 0 0 m 1 0 l 0 1 l f",
        "0 0 m 1e38 1e38 l 5 0 l S",
        "nan nan m 1 0 l 0 1 l f",
        "1e30 w 0 0 m 1 1 l S",
        "[-1 1] 0 d 0 0 m 1 1 l S",
        "[0.000001] 0 d 0 0 m 90 90 l S",
        "0 0 0 0 0 0 cm 0 0 9 9 re f",
        "1 0 l 2 2 c f S W n",
    ] {
        for shape in drawn("", content, &[]).shapes {
            let size = shape.figure.bounds().size();
            assert!(size.max_element() <= 100.0 + 1e-6, "{content}: {size}");
        }
    }
    let many = "0 0 1 1 re f ".repeat(100_000);
    assert_eq!(drawn("", &many, &[]).shapes.len(), 100_000);
    let nested = "q 0 0 50 50 re W n ".repeat(100_000);
    assert_eq!(
        drawn("", &format!("{nested} 0 0 99 1 re f"), &[])
            .shapes
            .len(),
        1
    );
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut writer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    writer.write_all(bytes).unwrap();
    writer.finish().unwrap()
}

#[test]
fn streams_may_be_packed_within_limits() {
    let with = |filter: &str, content: Vec<u8>, contents: &str| {
        file(&[
            b"<</Type/Catalog/Pages 2 0 R>>".to_vec(),
            b"<</Type/Pages/Kids[3 0 R]/Count 1/MediaBox[0 0 100 100]>>".to_vec(),
            format!("<</Type/Page/Parent 2 0 R/Contents {contents}>>").into_bytes(),
            stream(filter, &content),
        ])
    };
    let once = "/Filter/FlateDecode";
    let twice = "/Filter[/FlateDecode/FlateDecode]";
    let plain = b"0 0 9 9 re f".to_vec();
    for bytes in [
        with(once, packed(&plain), "4 0 R"),
        with(twice, packed(&packed(&plain)), "4 0 R"),
    ] {
        assert_eq!(try_read(&bytes).unwrap().shapes.len(), 1);
    }
    let long = vec![b' '; 1 << 20];
    let many = "4 0 R ".repeat(100);
    for bytes in [
        with(once, packed(&long), "4 0 R"),
        with(once, packed(&long)[2..].to_vec(), "4 0 R"),
        with(twice, packed(&packed(&long)), "4 0 R"),
        with("", long[..1 << 16].to_vec(), &format!("[{many}]")),
    ] {
        let options = ReadOptions {
            most_unpacked: 1 << 19,
            ..ReadOptions::default()
        };
        let error = read(&bytes, "a.pdf", &options).unwrap_err().to_string();
        assert!(
            error.contains("unpacks to more than 524288 bytes"),
            "{error}"
        );
    }
    let words = [&packed(&plain)[..], b"stream\n"].concat().repeat(3000);
    drop(try_read(&with("", words, "4 0 R")));
}

#[test]
fn damage_is_an_error_or_repaired() {
    let good = page_file("", b"0 0 9 9 re f", &[]);
    for length in (0..good.len()).step_by(7) {
        if let Err(error) = try_read(&good[..length]) {
            assert!(error.to_string().starts_with("a.pdf: "), "{error}");
        }
    }
    let mut moved = good.clone();
    moved.splice(9..9, *b"% the tables are wrong now\n");
    assert_eq!(try_read(&moved).unwrap().shapes.len(), 1);
    let error = try_read(b"%PDF-1.7\nnothing").unwrap_err().to_string();
    assert_eq!(
        error,
        "a.pdf: found a PDF so damaged that no page is found, expected a PDF without damage and password"
    );
    assert_eq!(try_read(&page_file("", b"", &[])).unwrap().shapes, []);
}
