//! Typefaces: outlines, shaping, conversion, and malformed files.

use crate::tiny_font;
use azulejo_formats::outline::typeface::{
    AxisValue, ColorLoss, FontFace, FontFeature, Layout, Setting, SettingError, StyledText,
    Typeface, VariationError, encoding_of, vary,
};
use azulejo_formats::outline::{ppe, ppf};
use azulejo_scene::{FillRule, Font, Line, Rgb};
use glam::DVec2;
use std::io::Write;
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
    let damaged =
        |format: &str| format!("a {format} font that is damaged or unpacks to more than 128 MiB");
    check(b"wOF2\0\x01", 0, &damaged("WOFF2"));
    check(b"wOFF\0\x01", 0, &damaged("WOFF"));
    check(&tiny_font::bytes(), 1, "no face 1");
    check(b"STARTFONT 2.1", 0, "a BDF bitmap font");
}

fn face(bytes: &[u8]) -> FontFace {
    FontFace::Typeface(Typeface::read(bytes, "a.ttf", 0).unwrap())
}

/// A PPF font whose `ж` is a square, and whose blank is 0.3 wide.
fn ppf_face() -> FontFace {
    let square = "1 4 l 0 0 l 0.4 0 l 0.4 0.4 l 0 0.4";
    let text = format!("/afii10072 {square} /A {square} /space 1 1 l 0.3 0");
    let (font, _) = ppf::read(text.as_bytes(), "a.ppf").unwrap();
    let encoding = encoding_of(&font);
    FontFace::Ppf(font, encoding)
}

#[test]
fn what_a_font_lacks_is_taken_from_the_next() {
    let fonts = [
        face(&tiny_font::bytes()),
        face(&tiny_font::with_characters([' ', 'Ж', 'b', 'ב', 'A'])),
        ppf_face(),
    ];
    let mut setting = Setting::new(&fonts, &[]);
    // The triangle of the first font, that of the second, the square of the third, and a box.
    let line = setting.line("AЖ жb", 0.0).unwrap();
    assert_eq!(pens(&line), [0.0, 0.6, 1.2, 1.45, 1.85]);
    let curves: Vec<usize> = line.glyphs.iter().map(|g| g.figure.curve_count()).collect();
    assert_eq!(curves, [3, 3, 0, 4, 8]);
    // Letters from right to left are in their order, whatever their fonts: bet, round here, is right of alef.
    let line = setting.line("בא A", 0.0).unwrap();
    let curves: Vec<usize> = line.glyphs.iter().map(|g| g.figure.curve_count()).collect();
    assert_eq!(curves, [3, 0, 4, 8]);
    assert_eq!(pens(&line), [0.0, 0.6, 0.85, 1.35]);
    let error = setting.line("Aжя क", 0.0).unwrap_err();
    assert_eq!(error, SettingError::NoGlyphs(vec!['я', 'क']));
    let words = error.to_string();
    let expected = "no glyph of Cyrillic for `я` (U+044F), no glyph of Devanagari for `क` (U+0915)";
    assert!(words.starts_with(expected), "{words}");
}

/// A letter whose mark only another font has is set in neither, and is no empty place either.
#[test]
fn letters_and_marks_need_one_font() {
    let fonts = [
        face(&tiny_font::bytes()),
        face(&tiny_font::with_characters([' ', '\u{301}', 'b', 'c', 'd'])),
    ];
    let error = Setting::new(&fonts, &[]).line("A\u{301}", 0.0).unwrap_err();
    assert_eq!(error, SettingError::NoGlyphs(vec!['\u{301}']));
}

#[test]
fn variable_fonts_move_along_their_axes() {
    let mut fonts = [face(&tiny_font::bytes()), face(&tiny_font::variable())];
    let axes = fonts[1].typeface().unwrap().axes();
    assert_eq!(axes[0].range, [100.0, 100.0, 900.0]);
    assert_eq!(
        axes[0].to_string(),
        "wght 100 to 900 (the lightest is its default)"
    );
    let value = |text: &str| -> Vec<AxisValue> { vec![text.parse().unwrap()] };
    let check = |fonts: &mut [FontFace], at: &str, width: f64| {
        vary(fonts, &value(at)).unwrap();
        let line = set(fonts[1].typeface().unwrap(), "A");
        let right = line.glyphs[0].figure.bounds().max.x;
        assert!((right - width).abs() < 1e-6, "{at} {right}");
        assert!(
            (line.advance - width).abs() < 1.1e-3,
            "{at} {}",
            line.advance
        );
    };
    check(&mut fonts, "wght=100", 0.6);
    check(&mut fonts, "wght=500", 0.9);
    check(&mut fonts, "wght=900", 1.2);
    let axes = fonts[1].typeface().unwrap().axes();
    assert_eq!(axes[0].to_string(), "wght 100 to 900 (here 900)");
    let far = vary(&mut fonts, &value("wght=901")).unwrap_err();
    assert_eq!(far.to_string(), "wght=901: expected wght from 100 to 900");
    let other = vary(&mut fonts, &value("wdth=80")).unwrap_err();
    assert!(matches!(&other, VariationError::NoAxis(tag, _) if tag == "wdth"));
    assert!(
        other.to_string().contains("expected wght 100 to 900"),
        "{other}"
    );
    let none = vary(&mut fonts[..1], &value("wght=500")).unwrap_err();
    assert!(none.to_string().contains("none is variable"), "{none}");
    for wrong in ["wght", "wght=", "wght=x", "weight=1", "wght=inf", "=1", ""] {
        assert!(wrong.parse::<AxisValue>().is_err(), "{wrong}");
    }
}

#[test]
fn features_are_switched() {
    let fonts = [face(&tiny_font::bytes())];
    let width = |features: &[&str]| {
        let features: Vec<FontFeature> = features.iter().map(|f| f.parse().unwrap()).collect();
        let advance = Setting::new(&fonts, &features)
            .line("Ao", 0.0)
            .unwrap()
            .advance;
        (1e6 * advance).round() / 1e6
    };
    assert_eq!(
        (width(&[]), width(&["kern"]), width(&["kern=on"])),
        (1.2, 1.2, 1.2)
    );
    assert_eq!(
        (width(&["kern=0"]), width(&["ss01", "kern=off"])),
        (1.3, 1.3)
    );
    for wrong in ["", "kern=", "kern=-1", "kerning", "liga=x", "l ga"] {
        assert!(wrong.parse::<FontFeature>().is_err(), "{wrong}");
    }
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn web_fonts_are_unpacked() {
    let plain = set(&tiny(), "Ao Xא");
    for packed in [
        tiny_font::woff(deflated),
        tiny_font::woff(<[u8]>::to_vec),
        tiny_font::woff2(),
    ] {
        let typeface = Typeface::read(&packed, "a.woff", 0).unwrap();
        assert_eq!(set(&typeface, "Ao Xא"), plain);
    }
    assert!(tiny_font::woff(deflated).len() < tiny_font::woff(<[u8]>::to_vec).len());
}

/// Little that claims to be much is refused before it is unpacked.
#[test]
fn web_fonts_that_claim_to_be_huge_are_refused() {
    let whole = tiny_font::woff(deflated);
    // The original length of the first table, and all tables at once.
    for tables in [1, 8] {
        let mut bytes = whole.clone();
        for table in 0..tables {
            let at = 44 + 20 * table + 12;
            bytes[at..at + 4].copy_from_slice(&(u32::MAX / 40).to_be_bytes());
        }
        assert!(Typeface::read(&bytes, "a.woff", 0).is_err());
    }
}

#[test]
fn collections_have_several_faces() {
    let bytes = tiny_font::collection();
    let has = |index: u32, c: char| Typeface::read(&bytes, "a.ttc", index).unwrap().has(c);
    assert_eq!(
        [has(0, 'A'), has(0, 'B'), has(1, 'A'), has(1, 'B')],
        [true, false, false, true]
    );
    let error = Typeface::read(&bytes, "a.ttc", 2).unwrap_err();
    assert_eq!(
        (&*error.found, &*error.expected),
        ("no face 2", "one of 0, 1")
    );
}

#[test]
fn metrics_bring_kerning() {
    let mut typeface = Typeface::read(&tiny_font::named(), "a.ttf", 0).unwrap();
    let afm = "StartFontMetrics 4.1\nStartKernPairs 3\nKPX A X -80\nKPX A nothing 9\nKP X A 50 0\n";
    assert_eq!(typeface.kern(afm.as_bytes(), "a.afm"), Ok(2));
    assert_eq!(pens(&set(&typeface, "AXAX")), [0.0, 0.52, 1.27, 1.79]);
    let fonts = [FontFace::Typeface(typeface)];
    let off = ["kern=0".parse().unwrap()];
    let line = Setting::new(&fonts, &off).line("AXA", 0.0).unwrap();
    assert_eq!(pens(&line), [0.0, 0.6, 1.3]);
    let check = |afm: &str, expected: &str| {
        let mut typeface = Typeface::read(&tiny_font::named(), "a.ttf", 0).unwrap();
        let error = typeface
            .kern(afm.as_bytes(), "a.afm")
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected), "{error}");
    };
    check("%!PS-AdobeFont-1.0", "StartFontMetrics");
    check("StartFontMetrics\nKPX A X", "a.afm:2:1");
    check("StartFontMetrics\nKPX A X nan", "KPX A V -80");
    check("StartFontMetrics\nKPX A X 1e9", "KPX A V -80");
}

#[test]
fn letters_have_sizes_and_colors() {
    let fonts = [face(&tiny_font::bytes())];
    let red = Rgb::new(1.0, 0.0, 0.0);
    let text = StyledText::parse("A{size=2 color=red|Ao}o", |_| Ok(red)).unwrap();
    let layout = Layout {
        spacing: 0.1,
        width: None,
    };
    let lines = Setting::new(&fonts, &[]).paragraph(text, &layout).unwrap();
    let [line] = &lines[..] else {
        panic!("{lines:?}");
    };
    // Spacing and kerning grow with the letters; between sizes there is no kerning.
    assert_eq!(pens(line), [0.0, 0.7, 1.9, 3.5]);
    let axes: Vec<f64> = line.glyphs.iter().map(|g| g.axis.x).collect();
    assert_eq!((axes, line.size), (vec![1.0, 2.0, 2.0, 1.0], 2.0));
    let colors: Vec<Option<Rgb>> = line.glyphs.iter().map(|g| g.color).collect();
    assert_eq!(colors, [None, Some(red), Some(red), None]);
}

/// The texts of lines by their letters' middles: tiny letters are as wide as their advance.
fn broken(text: &str, width: f64) -> Vec<(usize, f64)> {
    let fonts = [face(&tiny_font::bytes())];
    let layout = Layout {
        spacing: 0.0,
        width: Some(width),
    };
    let lines = Setting::new(&fonts, &[]).paragraph(StyledText::plain(text), &layout);
    let round = |x: f64| (1e6 * x).round() / 1e6;
    lines
        .unwrap()
        .iter()
        .map(|l| (l.letters.len(), round(l.advance)))
        .collect()
}

#[test]
fn lines_are_broken_where_they_may_be() {
    // A is 0.6 wide, a blank 0.25.
    assert_eq!(broken("AA AA  AA", 3.0), [(5, 2.65), (2, 1.2)]);
    assert_eq!(broken("AA AA  AA", 2.65), [(5, 2.65), (2, 1.2)]);
    assert_eq!(broken("AA AA  AA", 2.64), [(2, 1.2), (2, 1.2), (2, 1.2)]);
    assert_eq!(broken("AA AA ", 9.0), [(5, 2.65)]);
    assert_eq!(broken("AAA A", 1.0), [(3, 1.8), (1, 0.6)]);
    assert_eq!(broken("", 1.0), [(0, 0.0)]);
    assert_eq!(broken("   ", 1.0), [(0, 0.0)]);
    // No break at a blank that forbids it.
    let fonts = [face(&tiny_font::with_characters([
        ' ', 'A', '\u{a0}', 'o', 'x',
    ]))];
    let layout = Layout {
        spacing: 0.0,
        width: Some(1.0),
    };
    let text = StyledText::plain("A\u{a0}A A");
    let lines = Setting::new(&fonts, &[]).paragraph(text, &layout).unwrap();
    let flags: Vec<(usize, bool)> = lines
        .iter()
        .map(|l| (l.letters.len(), l.is_broken))
        .collect();
    assert_eq!(flags, [(3, true), (1, false)]);
}

/// Against the definition: the longest prefix of words that fits, word after word.
#[test]
fn lines_hold_as_many_words_as_fit() {
    let words = |seed: u64| -> Vec<String> {
        let letters = (0..40).map(|k| 1 + (seed.wrapping_mul(k * k + 7) >> 3) % 6);
        letters.map(|n| "AX".repeat(n as usize)).collect()
    };
    for (seed, width) in [(11, 4.0), (29, 9.5), (1234, 17.0)] {
        let words = words(seed);
        let wide = |n: usize| 1.3 * n as f64;
        let mut expected = vec![0.0];
        for word in &words {
            let letters = wide(word.len() / 2);
            let last = expected.last_mut().unwrap();
            let with = if *last > 0.0 { *last + 0.25 } else { 0.0 } + letters;
            if with <= width || *last == 0.0 {
                *last = with;
            } else {
                expected.push(letters);
            }
        }
        let found: Vec<f64> = broken(&words.join(" "), width)
            .iter()
            .map(|l| l.1)
            .collect();
        assert_eq!(found.len(), expected.len(), "{seed}");
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-5, "{seed} {found} {expected}");
        }
    }
}

#[test]
fn glyphs_have_layers_of_colors() {
    let fonts = [face(&tiny_font::colored())];
    let mut setting = Setting::new(&fonts, &[]);
    let line = setting.line("Ao", 0.0).unwrap();
    let layers: Vec<(u32, Option<Rgb>)> = line.glyphs.iter().map(|g| (g.layer, g.color)).collect();
    let red = Rgb::new(0.9, 0.0, 0.0);
    assert_eq!(layers, [(0, Some(red)), (1, None), (0, None)]);
    // The box reaches beyond the triangle, and stands by itself.
    assert_eq!(line.glyphs[1].base, None);
    // The box reaches beyond the triangle.
    assert_eq!(line.glyphs[1].base, None);
    assert_eq!(pens(&line), [0.0, 0.0, 0.5]);
    assert!(setting.losses().is_empty());
}

#[test]
fn paints_are_simplified_with_a_word() {
    let fonts = [face(&tiny_font::painted())];
    let mut setting = Setting::new(&fonts, &[]);
    let line = setting.line("Xo", 0.0).unwrap();
    let [gradient, moved] = &line.glyphs[..] else {
        panic!("{line:?}");
    };
    assert_eq!(gradient.color, Some(Rgb::new(0.45, 0.45, 0.0)));
    assert_eq!(moved.color, Some(Rgb::new(0.0, 0.0, 0.9)));
    let corners = [gradient, moved].map(|g| g.figure.bounds().min.x);
    assert!(
        corners[0].abs() < 1e-9 && (corners[1] - 0.1).abs() < 1e-9,
        "{corners:?}"
    );
    let losses: Vec<ColorLoss> = setting.losses().iter().copied().collect();
    assert_eq!(losses, [ColorLoss::Gradient, ColorLoss::Transparency]);
    // What paints itself has no end.
    let error = setting.line("A", 0.0).unwrap_err().to_string();
    assert!(error.contains("(colours"), "{error}");
}

#[test]
fn glyphs_without_outlines_are_named() {
    let fonts = [face(&tiny_font::with_characters(['b', 'A', 'x', 'o', 'c']))];
    let mut setting = Setting::new(&fonts, &[]);
    setting.line("Ab", 0.0).unwrap();
    assert_eq!(setting.blank().iter().collect::<String>(), "b");
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
    assert_eq!(names, ["A", "X", "o", "space"]);
    let line = |font: &Font, text: &str| font.set_line(text, &converted.encoding, 0.0).unwrap();
    assert!((line(&converted.font, "A A").advance - 1.45).abs() < 2e-6);
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
    for index in 0..2 {
        let Ok(typeface) = Typeface::read(bytes, "a.ttf", index) else {
            continue;
        };
        let _ = typeface.setting().line("Ao Xא", 0.0);
        let _ = typeface.convert(typeface.characters().into_iter().take(100));
        let _ = (typeface.features(), typeface.instance());
        let mut fonts = [FontFace::Typeface(typeface)];
        let _ = vary(&mut fonts, &["wght=500".parse().unwrap()]);
        let layout = Layout {
            spacing: 0.0,
            width: Some(1.0),
        };
        let _ = Setting::new(&fonts, &[]).paragraph(StyledText::plain("Ao Xא"), &layout);
    }
}

#[test]
fn damaged_files_do_no_harm() {
    let plain = tiny_font::bytes();
    damage(&plain, 1);
    // Other kinds differ in parts only.
    let step = if azulejo_testing::is_thorough() { 1 } else { 7 };
    for whole in [
        tiny_font::variable(),
        tiny_font::colored(),
        tiny_font::painted(),
        tiny_font::collection(),
        tiny_font::woff(deflated),
        tiny_font::woff2(),
    ] {
        damage(&whole, step);
    }
}

/// Cuts a file, and changes bytes of it, at every place or one in `step`.
fn damage(whole: &[u8], step: usize) {
    for end in (0..whole.len()).step_by(step) {
        survives(&whole[..end]);
    }
    // Each value comes in each place where tests are thorough, else one of them.
    let values = [0, 1, 0x7f, 0x80, 0xff];
    let each = if azulejo_testing::is_thorough() {
        values.len()
    } else {
        1
    };
    for at in (0..whole.len()).step_by(step) {
        for value in values
            .into_iter()
            .cycle()
            .skip(at % values.len())
            .take(each)
        {
            let mut bytes = whole.to_vec();
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

/// A real font of Type 1 with its own metrics is as long as the same face in OpenType, which kerns by tables.
#[test]
fn kerning_of_type_1() {
    let folder = "type1/urw-base35/NimbusRoman-Regular";
    let (Some(mut type1), Some(opentype)) = (
        installed(&format!("{folder}.t1")),
        installed("opentype/urw-base35/NimbusRoman-Regular.otf"),
    ) else {
        return;
    };
    let afm = azulejo_testing::font(&format!("{folder}.afm")).expect("it lies beside the font");
    assert!(type1.kern(&afm, "a.afm").unwrap() > 100);
    for text in ["AVATAR", "To Wo", "Yo."] {
        let [a, b] = [&type1, &opentype].map(|t| set(t, text).advance);
        assert!((a - b).abs() < 0.02, "{text} {a} {b}");
    }
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
