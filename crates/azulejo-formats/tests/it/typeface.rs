//! Typefaces: outlines, shaping, conversion, and malformed files.

use crate::tiny_font;
use azulejo_formats::outline::typeface::{SettingError, Typeface};
use azulejo_formats::outline::{ppe, ppf};
use azulejo_scene::{FillRule, Line};
use glam::DVec2;
use std::sync::Arc;

fn tiny() -> Typeface {
    Typeface::read(&tiny_font::bytes(), "tiny.ttf", 0).unwrap()
}

fn set(typeface: &Typeface, text: &str) -> Line {
    typeface.setting().line(text, 0.0).unwrap()
}

fn pens(line: &Line) -> Vec<f64> {
    line.glyphs
        .iter()
        .map(|g| (g.pen.x * 1e6).round() / 1e6)
        .collect()
}

/// An installed typeface, if the machine has it.
fn installed(path: &str) -> Option<Typeface> {
    let bytes = azulejo_testing::font(path)?;
    Some(Typeface::read(&bytes, path, 0).unwrap())
}

#[test]
fn outlines_are_exact() {
    let line = set(&tiny(), "Ao");
    let [a, o] = [0, 1].map(|i| &line.glyphs[i].figure);
    assert_eq!((a.rule, o.rule), (FillRule::NonZero, FillRule::NonZero));
    assert!((a.signed_area() + 0.5 * 0.6 * 0.7).abs() < 1e-12);
    // Four parabolas through the midpoints of a square's sides: 5/6 of the square.
    let expected = -5.0 / 6.0 * (0.6 * 0.6 - 0.3 * 0.3);
    assert!(
        (o.signed_area() - expected).abs() < 1e-9,
        "{}",
        o.signed_area()
    );
    assert!(!o.contains(DVec2::new(0.3, 0.3)) && o.contains(DVec2::new(0.06, 0.3)));
}

#[test]
fn pens_move_by_advance_kerning_and_spacing() {
    let typeface = tiny();
    let check = |text: &str, spacing: f64, expected: &[f64], advance: f64| {
        let line = typeface.setting().line(text, spacing).unwrap();
        assert_eq!(pens(&line), expected, "{text}");
        assert!(
            (line.advance - advance).abs() < 1e-9,
            "{text} {}",
            line.advance
        );
    };
    check("", 0.0, &[], 0.0);
    check("AA", 0.0, &[0.0, 0.6], 1.2);
    check("Ao", 0.0, &[0.0, 0.5], 1.2);
    check("A o", 0.0, &[0.0, 0.6, 0.85], 1.55);
    check("A\to", 0.0, &[0.0, 0.6, 0.85], 1.55);
    check("AA", 0.1, &[0.0, 0.7], 1.3);
}

#[test]
fn glyphs_that_come_again_share_their_figure() {
    let typeface = tiny();
    let mut setting = typeface.setting();
    let lines = ["AoA", "o"].map(|text| setting.line(text, 0.0).unwrap());
    assert!(Arc::ptr_eq(
        &lines[0].glyphs[0].figure,
        &lines[0].glyphs[2].figure
    ));
    assert!(Arc::ptr_eq(
        &lines[0].glyphs[1].figure,
        &lines[1].glyphs[0].figure
    ));
}

#[test]
fn right_to_left_runs_stand_in_their_order() {
    let line = set(&tiny(), "Aאo");
    assert_eq!(pens(&line), [0.0, 0.6, 1.1]);
    // The paragraph runs right to left: the last letter is on the left.
    let line = set(&tiny(), "אA");
    assert_eq!(line.glyphs[0].figure.curve_count(), 3);
}

#[test]
fn missing_characters_are_named() {
    let error = tiny().setting().line("AżBa ż\u{1f600}", 0.0).unwrap_err();
    assert_eq!(error, SettingError::NoGlyphs(vec!['B', 'a', 'ż', '😀']));
    assert!(error.to_string().contains("`ż` (U+017C)"), "{error}");
    let many: String = ('a'..='z').filter(|c| *c != 'o').collect();
    let error = tiny().setting().line(&many, 0.0).unwrap_err().to_string();
    assert!(error.ends_with(" and 5 more characters"), "{error}");
}

#[test]
fn what_is_no_font_is_named() {
    let check = |bytes: &[u8], index: u32, found: &str| {
        let error = Typeface::read(bytes, "a.ttf", index).unwrap_err();
        assert_eq!(&*error.found, found);
    };
    check(b"", 0, "no font that can be read");
    check(b"/A 0", 0, "no font that can be read");
    check(b"wOF2\0\x01", 0, "a WOFF2 font; unpack it to TTF or OTF");
    check(&tiny_font::bytes(), 1, "no font that can be read");
}

#[test]
fn conversion_keeps_advances_and_names() {
    let typeface = tiny();
    assert_eq!(typeface.characters(), [' ', 'A', 'X', 'o', 'א']);
    let converted = typeface.convert(" AoXB".chars()).unwrap();
    assert_eq!(converted.missing, ['B']);
    // Two boxes of 0.28 and 0.16 that overlap by 0.08 are merged into one outline.
    assert_eq!(converted.overlapping, Vec::<String>::new());
    let united = &converted.font.glyphs["X"].figure;
    assert_eq!((united.contours.len(), united.rule), (1, FillRule::EvenOdd));
    assert!((united.signed_area() - 0.36).abs() < 1e-5);
    let names: Vec<&String> = converted.font.glyphs.keys().collect();
    assert_eq!(names, ["A", "X", "o"]);
    assert_eq!(converted.encoding.names[&65], "A");
    // The outline of `o` ends at 0.6 - 1/20 because of its curve; spacing after the glyph does not
    // matter.
    for (name, advance) in [("A", 0.6), ("o", 0.7)] {
        let found = converted.font.glyphs[name].advance;
        assert!((found - advance).abs() < 2e-6, "{name} {found}");
    }
    let line = converted
        .font
        .lay_out("A o", &converted.encoding, 0.0)
        .unwrap();
    assert_eq!(line.len(), 2);
    let (mut font, mut encoding) = (Vec::new(), Vec::new());
    ppf::write(&converted.font, &mut font).unwrap();
    ppe::write(&converted.encoding, &mut encoding).unwrap();
    assert_eq!(ppf::read(&font, "a.ppf").unwrap().0, converted.font);
    assert_eq!(ppe::read(&encoding, "a.ppe").unwrap().0, converted.encoding);
}

/// Reads and sets arbitrary bytes; only a panic is a failure.
fn survives(bytes: &[u8]) {
    if let Ok(typeface) = Typeface::read(bytes, "a.ttf", 0) {
        let _ = typeface.setting().line("Ao Xא", 0.0);
        let _ = typeface.convert(typeface.characters().into_iter().take(100));
    }
}

#[test]
fn damaged_files_do_no_harm() {
    let whole = tiny_font::bytes();
    for end in 0..whole.len() {
        survives(&whole[..end]);
    }
    // Each value comes in each place where tests are thorough, else one of them.
    let values = [0, 1, 0x7f, 0x80, 0xff];
    let each = if azulejo_testing::is_thorough() {
        values.len()
    } else {
        1
    };
    for at in 0..whole.len() {
        for value in values
            .into_iter()
            .cycle()
            .skip(at % values.len())
            .take(each)
        {
            let mut bytes = whole.clone();
            bytes[at] = value;
            survives(&bytes);
        }
    }
}

#[test]
fn ligatures_marks_and_arabic() {
    let Some(typeface) = installed("truetype/dejavu/DejaVuSans.ttf") else {
        return;
    };
    assert_eq!(set(&typeface, "ffi").glyphs.len(), 1);
    // A combining accent forms one glyph with its letter, or is placed over it.
    assert_eq!(set(&typeface, "e\u{301}"), set(&typeface, "é"));
    let marked = set(&typeface, "x\u{301}");
    let above = &marked.glyphs[1];
    let ink = above.figure.bounds();
    let letter = marked.glyphs[0].figure.bounds();
    let (x, middle) = (
        above.pen.x + 0.5 * (ink.min.x + ink.max.x),
        0.5 * (letter.min.x + letter.max.x),
    );
    assert!((x - middle).abs() < 0.1, "{x} {middle}");
    // Letters join: the same letter has different outlines at the beginning and at the end.
    let arabic = set(&typeface, "ببب");
    assert_eq!(arabic.glyphs.len(), 3);
    assert!(!Arc::ptr_eq(
        &arabic.glyphs[0].figure,
        &arabic.glyphs[2].figure
    ));
    assert!(arabic.glyphs.windows(2).all(|w| w[0].pen.x < w[1].pen.x));
}

#[test]
fn kerning_of_opentype() {
    let Some(typeface) = installed("opentype/urw-base35/NimbusRoman-Regular.otf") else {
        return;
    };
    let apart = set(&typeface, "A").advance + set(&typeface, "V").advance;
    let together = set(&typeface, "AV").advance;
    assert!(together < apart - 0.05, "{together} {apart}");
}

/// The same face in both formats has the same outlines.
#[test]
fn type_1_and_opentype_agree() {
    let (Some(type1), Some(opentype)) = (
        installed("type1/urw-base35/NimbusRoman-Regular.t1"),
        installed("opentype/urw-base35/NimbusRoman-Regular.otf"),
    ) else {
        return;
    };
    for text in ["R", "g", "&", "ñ"] {
        let [a, b] = [&type1, &opentype].map(|t| set(t, text));
        let (a, b) = (&a.glyphs[0].figure, &b.glyphs[0].figure);
        assert_eq!(a.curve_count(), b.curve_count(), "{text}");
        assert!((a.signed_area() - b.signed_area()).abs() < 1e-9, "{text}");
    }
}
