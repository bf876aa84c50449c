//! PPF: the glyphs of RTRACE's 3D text, as outlines of lines and cubic Bézier curves.
//!
//! ```text
//! /A 2            name, number of contours
//! 3               number of curves of the first contour
//! l 0.1 0         start of a line
//! c 0.5 0 1 0 1 1 start and two control points of a curve
//! l 0 1           the last curve ends at the start of the contour
//! ...
//! ```
//!
//! Every contour is closed by construction. What is inside follows the even-odd rule
//! ([`FillRule::EvenOdd`](azulejo_scene::FillRule::EvenOdd)) over all contours of a glyph, whatever
//! their orientation: where an outline crosses itself, or two of them overlap, the area surrounded
//! twice is outside. A contour without area, such as a single line, has no inside, and a glyph
//! without contours is blank.

use crate::reading::text::{decoded, shortened, text};
use crate::reading::warnings::Warnings;
use crate::reading::words::Words;
use crate::{ReadError, Warning};
use azulejo_scene::{Contour, Curve, Figure, Font, Glyph};
use glam::DVec2;
use std::collections::btree_map::Entry;
use std::io::{self, Write};

/// Bytes of the shortest curve, `l 0 0` and a blank: no more curves than could fit are reserved.
const SHORTEST_CURVE: usize = 6;

/// Whether a file may be a PPF: text whose first word after comments is a glyph's name.
pub fn is_ppf(bytes: &[u8]) -> bool {
    let bytes = decoded(bytes);
    let mut lines = bytes.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|l| !l.is_empty() && !l.starts_with(b"#"));
    first.is_some_and(|l| l.starts_with(b"/"))
}

/// Reads a font. `name` is used in messages.
///
/// Extensions beyond RTRACE: comments from `#` to the end of the line where a word may begin,
/// capital letters for the curves, and a letter without a blank before its first number. If
/// several glyphs have the same name, the first is used, with a warning.
///
/// # Errors
/// Text that is not PPF, with the position and the glyph.
pub fn read(bytes: &[u8], name: &str) -> Result<(Font, Vec<Warning>), ReadError> {
    let bytes = &*decoded(bytes);
    let mut reader = PpfReader {
        words: Words::new(bytes, name),
        length: bytes.len(),
        place: PpfSection::Start,
        glyph: String::new(),
    };
    let mut font = Font::default();
    let mut warnings = Warnings::default();
    while !reader.is_at_end() {
        let at = reader.words.offset();
        let glyph = reader.glyph()?;
        match font.glyphs.entry(reader.glyph.clone()) {
            Entry::Vacant(entry) => {
                entry.insert(glyph);
            }
            Entry::Occupied(entry) => {
                let message = format!(
                    "glyph /{} is defined again: the first definition is used",
                    shortened(entry.key())
                );
                warnings.add(name, message, || reader.words.position(at));
            }
        }
    }
    if font.glyphs.is_empty() {
        warnings.add_whole(name, "no glyphs");
    }
    Ok((font, warnings.finish(name)))
}

struct PpfReader<'a> {
    words: Words<'a>,
    length: usize,
    place: PpfSection,
    /// Name of the last glyph that began.
    glyph: String,
}

/// The current position in a font, for messages.
#[derive(Clone, Copy)]
enum PpfSection {
    /// Before the first glyph.
    Start,
    /// At a glyph's number of contours.
    Glyph,
    /// In a contour, counted from 1, and the number of contours.
    Contour(u32, u32),
    /// After a glyph with this number of contours.
    Behind(u32),
}

impl PpfReader<'_> {
    fn glyph(&mut self) -> Result<Glyph, ReadError> {
        let at = self.words.offset();
        self.glyph = match self.words.word() {
            Some([b'/', name @ ..]) if !name.is_empty() => text(name).into_owned(),
            _ => return Err(self.error(at, "\"/\" and the name of a glyph")),
        };
        self.place = PpfSection::Glyph;
        let count = self.count("the number of its contours", 0)?;
        let mut figure = Figure::default();
        for i in 1..=count {
            self.place = PpfSection::Contour(i, count);
            figure.contours.push(self.contour()?);
        }
        self.place = PpfSection::Behind(count);
        Ok(Glyph::new(figure))
    }

    fn contour(&mut self) -> Result<Contour, ReadError> {
        let count = self.count("the number of its curves, at least 1", 1)?;
        let room = (self.length - self.words.offset()) / SHORTEST_CURVE;
        let mut curves = Vec::with_capacity(room.min(count as usize));
        for _ in 0..count {
            curves.push(self.curve(curves.len(), count)?);
        }
        Ok(Contour { curves })
    }

    /// Reads a curve, after `done` of `count`.
    fn curve(&mut self, done: usize, count: u32) -> Result<Curve, ReadError> {
        self.skip();
        let at = self.words.offset();
        match self.letter() {
            Some(b'l' | b'L') => Ok(Curve::Line {
                start: self.point()?,
            }),
            Some(b'c' | b'C') => Ok(Curve::Cubic {
                start: self.point()?,
                control1: self.point()?,
                control2: self.point()?,
            }),
            _ => {
                let expected = format!("\"l\" or \"c\": curve {} of {count}", done + 1);
                Err(self.error(at, &expected))
            }
        }
    }

    /// Consumes a single letter, unless it begins a word.
    fn letter(&mut self) -> Option<u8> {
        let letter = self.words.peek()?;
        let behind = self.words.from(self.words.offset() + 1);
        if behind.peek().is_some_and(|b| b.is_ascii_alphabetic()) {
            return None;
        }
        self.words = behind;
        Some(letter)
    }

    fn point(&mut self) -> Result<DVec2, ReadError> {
        Ok(DVec2::new(self.coordinate()?, self.coordinate()?))
    }

    fn coordinate(&mut self) -> Result<f64, ReadError> {
        self.skip();
        let at = self.words.offset();
        match self.words.number() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(self.error(at, "a coordinate")),
        }
    }

    fn count(&mut self, what: &str, least: u32) -> Result<u32, ReadError> {
        self.skip();
        let at = self.words.offset();
        let count = self.words.small_integer().filter(|&n| n >= least);
        count.ok_or_else(|| self.error(at, what))
    }

    /// Whether only blanks and comments are left.
    fn is_at_end(&mut self) -> bool {
        self.skip();
        self.words.at_end()
    }

    /// Skips blanks and comments.
    fn skip(&mut self) {
        self.words.skip_blanks();
        while self.words.peek() == Some(b'#') {
            self.words.rest_of_line();
            self.words.skip_blanks();
        }
    }

    #[cold]
    fn error(&self, at: usize, expected: &str) -> ReadError {
        let glyph = shortened(&self.glyph);
        let place = match self.place {
            PpfSection::Start => String::new(),
            PpfSection::Glyph => format!(" in glyph /{glyph}"),
            PpfSection::Contour(i, count) => {
                format!(" in contour {i} of {count} of glyph /{glyph}")
            }
            PpfSection::Behind(count) => format!(" after the {count} contours of glyph /{glyph}"),
        };
        let error = self.words.error(at, expected);
        ReadError {
            found: format!("{}{place}", error.found).into(),
            ..error
        }
    }
}

/// Writes a font so that [`read`] returns the same outlines, in the order of their names.
///
/// PPF does not store advances: a reader takes the largest x, as [`Glyph::new`] does. Nor does it
/// store fill rules: a figure filled by [`FillRule::NonZero`](azulejo_scene::FillRule::NonZero)
/// whose contours overlap changes.
///
/// # Errors
/// Errors of `out`, and [`io::ErrorKind::InvalidInput`] for what cannot be represented: names that are
/// empty or contain blanks or control characters, contours without curves, and coordinates that
/// are not finite.
pub fn write(font: &Font, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    for (name, glyph) in &font.glyphs {
        let spelled = text_of(name, &glyph.figure)
            .ok_or_else(|| refusal(format!("PPF cannot represent glyph \"{name}\"")))?;
        out.write_all(spelled.as_bytes())?;
    }
    Ok(())
}

fn refusal(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, message)
}

/// The text of a glyph; `None` if it cannot be represented.
fn text_of(name: &str, figure: &Figure) -> Option<String> {
    if name.is_empty() || name.bytes().any(|b| b <= b' ') {
        return None;
    }
    let mut text = format!("/{name}\n{}\n", figure.contours.len());
    for contour in &figure.contours {
        if contour.curves.is_empty() {
            return None;
        }
        text.push_str(&format!("{}\n", contour.curves.len()));
        for curve in &contour.curves {
            push_curve(curve, &mut text)?;
        }
    }
    text.push('\n');
    Some(text)
}

fn push_curve(curve: &Curve, text: &mut String) -> Option<()> {
    let (letter, points) = match *curve {
        Curve::Line { start } => ('l', &[start][..]),
        Curve::Cubic {
            start,
            control1,
            control2,
        } => ('c', &[start, control1, control2][..]),
    };
    text.push(letter);
    for p in points {
        if !p.is_finite() {
            return None;
        }
        push_number(p.x, text);
        push_number(p.y, text);
    }
    text.push('\n');
    Some(())
}

/// The shortest decimal number that is read as the same bits.
fn push_number(x: f64, text: &mut String) {
    let plain = x == 0.0 || (1e-5..1e16).contains(&x.abs());
    if plain {
        text.push_str(&format!(" {x}"))
    } else {
        text.push_str(&format!(" {x:e}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outline::ppe;
    use azulejo_scene::{FillRule, PlacedGlyph};
    use proptest::prelude::*;

    fn v(x: f64, y: f64) -> DVec2 {
        DVec2::new(x, y)
    }

    fn only(text: &str) -> Glyph {
        let (font, warnings) = read(text.as_bytes(), "a.ppf").unwrap();
        assert_eq!((font.glyphs.len(), &warnings[..]), (1, &[][..]));
        font.glyphs.into_values().next().unwrap()
    }

    #[test]
    fn a_font_is_known_by_its_first_word() {
        for text in ["/A 0\n", "\n# remark\n  /A 0", "\u{feff}/A 0"] {
            assert!(is_ppf(text.as_bytes()), "{text:?}");
        }
        for text in [
            "",
            "# only\n",
            "A 0",
            "OTTO",
            "%!PS-AdobeFont-1.0\n/FontName",
        ] {
            assert!(!is_ppf(text.as_bytes()), "{text:?}");
        }
    }

    #[test]
    fn the_letter_d() {
        let d = only("/D\n2\n4\nl 0 0\nl 0 23\nc 8 23 25 21 23 0\nl 8 0\n\n1\nc 6 15 4 -6 23 17\n");
        let contours = &d.figure.contours;
        assert_eq!([contours[0].curves.len(), contours[1].curves.len()], [4, 1]);
        assert_eq!(
            contours[0].curves[1],
            Curve::Line {
                start: v(0.0, 23.0)
            }
        );
        let curve = Curve::Cubic {
            start: v(6.0, 15.0),
            control1: v(4.0, -6.0),
            control2: v(23.0, 17.0),
        };
        assert_eq!(contours[1].curves, [curve]);
        assert!(d.figure.contains(v(2.0, 2.0)) && !d.figure.contains(v(8.0, 10.0)));
        assert!(d.advance > 20.0 && d.advance < 20.1, "{}", d.advance);
    }

    #[test]
    fn every_form_of_a_curve() {
        let expected = only("/A 1 2 l .5 -2 c 1 2 3 4 9.5e-3 6");
        let check = |text: &str| assert_eq!(only(text), expected, "{text}");
        check("\u{feff}/A\r\n1\r\n\r\n2\r\nl.5 -2\r\nc 1 2 3 4 0.0095 6\r\n\x1a");
        check("# a font\n/A 1 # contour\n2 L 0.5 -2.\t#start\n #\nC1 2 3 4 .0095 +6 # end");
    }

    #[test]
    fn blanks_have_no_contours() {
        let blank = only("/space 0");
        assert_eq!((blank.figure.contours.len(), blank.advance), (0, 0.0));
    }

    #[test]
    fn errors_name_position_and_glyph() {
        let check = |text: &str, message: &str| {
            let error = read(text.as_bytes(), "a.ppf").unwrap_err().to_string();
            let first = error.lines().next().unwrap();
            assert_eq!(first, format!("a.ppf:{message}"), "{text}");
        };
        check(
            "A 1",
            "1:1: found \"A\", expected \"/\" and the name of a glyph",
        );
        check(
            "\n/ A 1",
            "2:1: found \"/\", expected \"/\" and the name of a glyph",
        );
        check(
            "/A two",
            "1:4: found \"two\" in glyph /A, expected the number of its contours",
        );
        check(
            "/A -1",
            "1:4: found \"-1\" in glyph /A, expected the number of its contours",
        );
        check(
            "/A 1\n0\n",
            "2:1: found \"0\" in contour 1 of 1 of glyph /A, expected the number of its curves, \
             at least 1",
        );
        check(
            "/A 2 1 l 0 0\n/B 0",
            "2:1: found \"/B\" in contour 2 of 2 of glyph /A, expected the number of its curves, \
             at least 1",
        );
        check(
            "/A 1\n4000000000\nl 0 0",
            "2:1: found \"4000000000\" in contour 1 of 1 of glyph /A, expected the number of its \
             curves, at least 1",
        );
        check(
            "/A 1\n400000000\nl 0 0",
            "3:6: found the end of the file in contour 1 of 1 of glyph /A, expected \"l\" or \
             \"c\": curve 2 of 400000000",
        );
        check(
            "/A 1\n1\nl 0 0 \nl 1 1",
            "4:1: found \"l\" after the 1 contours of glyph /A, expected \"/\" and the name of \
             a glyph",
        );
        check(
            "/A 1\n1\nq 0 0",
            "3:1: found \"q\" in contour 1 of 1 of glyph /A, expected \"l\" or \"c\": curve 1 of 1",
        );
        check(
            "/A 1\n1\nline 0 0",
            "3:1: found \"line\" in contour 1 of 1 of glyph /A, expected \"l\" or \"c\": curve 1 \
             of 1",
        );
        check(
            "/A 1\n2\nl .5 .6\nl 0.\nl 1 1",
            "5:1: found \"l\" in contour 1 of 1 of glyph /A, expected a coordinate",
        );
        check(
            "/A 1\n1\nc 0 1e999",
            "3:5: found \"1e999\" in contour 1 of 1 of glyph /A, expected a coordinate",
        );
        check(
            "/A 1\n1\nl 0 -",
            "3:5: found \"-\" in contour 1 of 1 of glyph /A, expected a coordinate",
        );
    }

    #[test]
    fn the_first_glyph_of_a_name_is_used() {
        let text = "/A 0\n/B 0\n/A 1 1 l 0 0\n /A 0\n";
        let (font, warnings) = read(text.as_bytes(), "a.ppf").unwrap();
        assert_eq!(font.glyphs.len(), 2);
        assert_eq!(font.glyphs["A"].figure.contours, []);
        let messages: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        assert_eq!(
            messages,
            ["a.ppf:3:1: glyph /A is defined again: the first definition is used (2 times)"]
        );
    }

    #[test]
    fn an_empty_font_is_a_warning() {
        for text in ["", " \n# nothing"] {
            let (font, warnings) = read(text.as_bytes(), "a.ppf").unwrap();
            assert_eq!((font.glyphs.len(), warnings.len()), (0, 1));
        }
    }

    #[test]
    fn outlines_that_cross_themselves_are_even_odd() {
        // A star of five points in one stroke: its middle is surrounded twice.
        let star = only("/star 1 5 l 0 1 l .59 -.81 l -.95 .31 l .95 .31 l -.59 -.81");
        assert!(!star.figure.contains(v(0.0, 0.0)));
        assert!(star.figure.contains(v(0.0, 0.8)));
        let nothing = only("/line 1 2 l 0 0 l 1 1");
        assert!(!nothing.figure.contains(v(0.5, 0.25)) && nothing.advance == 1.0);
        assert_eq!(only("/point 1 1 l 2 3").advance, 2.0);
    }

    #[test]
    fn a_million_curves_in_a_glyph() {
        let mut text = String::from("/map 1 1000000\n");
        for i in 0..1_000_000 {
            text.push_str(&format!("l {} {}\n", i, i % 7));
        }
        assert_eq!(only(&text).figure.curve_count(), 1_000_000);
    }

    #[test]
    fn unrepresentable_fonts_are_refused() {
        let check = |name: &str, figure: Figure| {
            let font = Font {
                glyphs: [(name.to_owned(), Glyph::new(figure))].into(),
            };
            let error = write(&font, &mut Vec::new()).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::InvalidInput, "{name}");
        };
        check("", Figure::default());
        check("a b", Figure::default());
        check("A", Figure::polygon([]));
        check("A", Figure::polygon([v(f64::NAN, 0.0)]));
    }

    fn curve() -> impl Strategy<Value = Curve> {
        let any_finite = any::<f64>().prop_filter("finite", |x| x.is_finite());
        let number = prop_oneof![-2.0..2.0, any_finite];
        let point = (number.clone(), number).prop_map(DVec2::from);
        let cubic = (point.clone(), point.clone(), point.clone());
        prop_oneof![
            point.prop_map(|start| Curve::Line { start }),
            cubic.prop_map(|(start, control1, control2)| Curve::Cubic {
                start,
                control1,
                control2,
            }),
        ]
    }

    /// Contours of several glyphs.
    fn outlines() -> impl Strategy<Value = Vec<Vec<Vec<Curve>>>> {
        use proptest::collection::vec;
        vec(vec(vec(curve(), 1..6), 0..4), 1..5)
    }

    proptest! {
        #[test]
        fn written_fonts_are_read_back(
            name in "[A-Za-z0-9./#_é-]{1,12}",
            outlines in outlines(),
        ) {
            let glyph = |contours: Vec<Vec<Curve>>| Glyph::new(Figure {
                contours: contours.into_iter().map(|curves| Contour { curves }).collect(),
                rule: FillRule::EvenOdd,
            });
            let names = (0..).map(|i| format!("{name}{i}"));
            let font = Font {
                glyphs: names.zip(outlines.into_iter().map(glyph)).collect(),
            };
            let mut bytes = Vec::new();
            write(&font, &mut bytes).unwrap();
            prop_assert_eq!(read(&bytes, "a.ppf"), Ok((font, Vec::new())));
        }
    }

    /// A font of RTRACE, if the folder that holds them is given.
    fn stock(name: &str) -> Option<Vec<u8>> {
        let path = azulejo_testing::data()?.join("corpus/sff/fonts");
        Some(std::fs::read(path.join(name)).unwrap())
    }

    #[test]
    fn stock_fonts_come_back_as_they_are() {
        for name in ["bangkok.ppf", "renfrew.ppf", "zurichcg.ppf"] {
            let Some(bytes) = stock(name) else {
                return;
            };
            let (font, warnings) = read(&bytes, name).unwrap();
            assert_eq!(font.glyphs.len(), 213, "{name}");
            assert_eq!(warnings.len(), 1);
            let message = &warnings[0].message;
            assert_eq!(
                message,
                "glyph /periodcentered is defined again: the first definition is used"
            );
            let mut again = Vec::new();
            write(&font, &mut again).unwrap();
            assert_eq!(read(&again, name), Ok((font, Vec::new())));
        }
    }

    fn close(values: &[f64], expected: &[f64], tolerance: f64) {
        assert_eq!(values.len(), expected.len());
        let differ = |(a, b): (&f64, &f64)| (a - b).abs() > tolerance;
        assert!(
            !std::iter::zip(values, expected).any(differ),
            "{values:?} {expected:?}"
        );
    }

    /// Curves, box and areas of the typeface of which Costa 1992 prints two letters.
    #[test]
    fn stock_glyphs_have_the_measures_of_the_paper() {
        let Some(bytes) = stock("bangkok.ppf") else {
            return;
        };
        let (font, _) = read(&bytes, "bangkok.ppf").unwrap();
        let check = |name: &str, curves: [usize; 2], bounds: [f64; 4], areas: [f64; 2]| {
            let glyph = &font.glyphs[name];
            let contours = &glyph.figure.contours;
            assert!(contours.iter().map(|c| c.curves.len()).eq(curves));
            let b = glyph.figure.bounds();
            close(&[b.min.x, b.min.y, b.max.x, b.max.y], &bounds, 1e-6);
            assert_eq!(glyph.advance, b.max.x);
            let area = |contour: &Contour| {
                let alone = Figure {
                    contours: vec![contour.clone()],
                    rule: FillRule::EvenOdd,
                };
                alone.signed_area()
            };
            let contour_areas: Vec<f64> = contours.iter().map(area).collect();
            close(&contour_areas, &areas, 1e-4);
        };
        check(
            "A",
            [3, 18],
            [0.0, 0.0666667, 0.683333, 0.729167],
            [0.0232, -0.1729],
        );
        check(
            "at",
            [13, 4],
            [0.000000060, 0.0504170, 0.648921, 0.733874],
            [-0.2181, 0.0450],
        );
    }

    #[test]
    fn a_font_and_an_encoding_set_a_line() {
        let font = "/A 1 3 l 0 0 l .6 0 l .3 1\n/at 1 3 l .1 0 l 1 0 l .5 1";
        let (font, _) = read(font.as_bytes(), "a.ppf").unwrap();
        let (encoding, _) = ppe::read(b"65/A\n64/at\n", "a.ppe").unwrap();
        let placed = font.lay_out("A /at/", &encoding, 0.1).unwrap();
        let pens: Vec<f64> = placed.iter().map(|g: &PlacedGlyph| g.pen.x).collect();
        close(&pens, &[0.0, 0.6 + 0.1 + 0.5 + 0.1], 1e-15);
    }
}
