//! Text as prisms: fonts, encodings and layout.

use crate::{Figure, MaterialId, Prism, Rgb};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// Outlines by glyph name, as PPF files hold them. One em is about 1, y is up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Font {
    /// The glyphs.
    pub glyphs: BTreeMap<String, Glyph>,
}

/// One glyph of a [`Font`].
#[derive(Clone, Debug, PartialEq)]
pub struct Glyph {
    /// Its outline; all prisms of the glyph share it.
    pub figure: Arc<Figure>,
    /// How far the pen advances after it, font units.
    pub advance: f64,
}

impl Glyph {
    /// A glyph whose advance is the largest x that its curves reach, as in PPF.
    pub fn new(figure: Figure) -> Glyph {
        let reach = figure.bounds().max.x;
        Glyph {
            figure: Arc::new(figure),
            advance: if reach.is_finite() { reach } else { 0.0 },
        }
    }
}

/// Glyph names by character code.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Encoding {
    /// The names.
    pub names: BTreeMap<u32, String>,
}

/// A glyph at its position in a line or block of text.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedGlyph {
    /// The outline.
    pub figure: Arc<Figure>,
    /// Position of its origin, font units.
    pub pen: DVec2,
    /// Where the figure's x axis points on the page, as long as a unit of the figure is there. The y axis is a quarter
    /// turn to its left, as long.
    pub axis: DVec2,
    /// Its colour, linear; `None` if it is that of the text.
    pub color: Option<Rgb>,
    /// How many layers of its letter are painted below it.
    pub layer: u32,
    /// The layer on which all of it lies; `None` if it stands by itself.
    pub base: Option<u32>,
}

impl PlacedGlyph {
    /// An upright glyph of the text's size and colour.
    pub fn new(figure: Arc<Figure>, pen: DVec2) -> PlacedGlyph {
        PlacedGlyph {
            figure,
            pen,
            axis: DVec2::X,
            color: None,
            layer: 0,
            base: None,
        }
    }
}

/// What stays together in a line: a letter with its marks, a ligature, a blank.
#[derive(Clone, Debug, PartialEq)]
pub struct Letter {
    /// Its glyphs in the line.
    pub glyphs: Range<usize>,
    /// Where the pen is before it, font units.
    pub start: f64,
    /// How far the pen advances over it, without spacing, font units.
    pub advance: f64,
    /// Whether it is a blank, which justified lines stretch.
    pub is_blank: bool,
}

/// One line of text.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Its glyphs; the line's pen starts at the origin and runs toward +x.
    pub glyphs: Vec<PlacedGlyph>,
    /// Its letters from left to right.
    pub letters: Vec<Letter>,
    /// Final pen position, without the spacing after the last glyph, font units.
    pub advance: f64,
    /// The size of its largest letters, as a multiple of that of the text.
    pub size: f64,
    /// Whether its paragraph runs from right to left.
    pub is_rtl: bool,
    /// Whether it was broken: the next line continues its paragraph.
    pub is_broken: bool,
}

impl Default for Line {
    fn default() -> Line {
        Line {
            glyphs: Vec::new(),
            letters: Vec::new(),
            advance: 0.0,
            size: 1.0,
            is_rtl: false,
            is_broken: false,
        }
    }
}

impl Line {
    /// Fills `width` font units: blanks become wider. The last line of a paragraph, and one without blanks or longer
    /// than that, stay as they are; that of a paragraph from right to left moves to the end.
    pub fn justify(&mut self, width: f64) {
        let room = width - self.advance;
        let inner = self.letters.iter().skip(1).rev().skip(1);
        let blanks = inner.filter(|l| l.is_blank).count();
        let stretch = if self.is_broken && blanks > 0 {
            room.max(0.0) / blanks as f64
        } else {
            0.0
        };
        let last = self.letters.len().saturating_sub(1);
        let mut shift = if self.is_rtl && stretch == 0.0 {
            room
        } else {
            0.0
        };
        for (k, letter) in self.letters.iter_mut().enumerate() {
            letter.start += shift;
            for glyph in &mut self.glyphs[letter.glyphs.clone()] {
                glyph.pen.x += shift;
            }
            if letter.is_blank && k > 0 && k < last {
                letter.advance += stretch;
                shift += stretch;
            }
        }
        self.advance += shift;
    }
}

/// Alignment of lines of text: which of their points is at the origin's x.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Align {
    /// Lines begin at the origin's x.
    #[default]
    Left,
    /// The lines' middles are at the origin's x.
    Center,
    /// Lines end at the origin's x.
    Right,
}

impl Align {
    /// Stacks lines, each `leading` font units below the previous one, or that times the [size](Line::size) of its
    /// letters; the pen of the first is at y = 0.
    pub fn stack(self, lines: impl IntoIterator<Item = Line>, leading: f64) -> Vec<PlacedGlyph> {
        let mut y = 0.0;
        let place = |(k, line): (usize, Line)| {
            if k > 0 {
                y -= leading * line.size;
            }
            let shift = DVec2::new(-self.before() * line.advance, y);
            line.glyphs.into_iter().map(move |glyph| PlacedGlyph {
                pen: glyph.pen + shift,
                ..glyph
            })
        };
        lines.into_iter().enumerate().flat_map(place).collect()
    }

    /// The share of a line, or of the room it has, that is before the point where it is aligned.
    pub fn before(self) -> f64 {
        match self {
            Align::Left => 0.0,
            Align::Center => 0.5,
            Align::Right => 1.0,
        }
    }
}

/// Placement of text in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextFrame {
    /// World position of the pen's origin, on the front plane.
    pub origin: DVec3,
    /// Unit direction in which the line runs.
    pub progression: DVec3,
    /// Unit direction of the letters' up; need not be perpendicular.
    pub up: DVec3,
    /// Unit direction of extrusion, from front to back; need not be perpendicular.
    pub extrusion: DVec3,
    /// World size of one font unit along `progression` and `up`, and the depth along
    /// `extrusion`. Not zero.
    pub scale: DVec3,
}

impl TextFrame {
    /// The map of a prism whose glyph stands at `pen`.
    pub fn world_from_glyph(&self, pen: DVec2) -> DAffine3 {
        let (across, up) = (self.scale.x * self.progression, self.scale.y * self.up);
        DAffine3 {
            matrix3: DMat3::from_cols(across, up, self.scale.z * self.extrusion),
            translation: self.origin + pen.x * across + pen.y * up,
        }
    }

    /// The prisms of placed glyphs, whatever their colours and layers; those without contours, such as blanks, produce
    /// none.
    pub fn prisms(&self, glyphs: &[PlacedGlyph], material: MaterialId) -> Vec<Prism> {
        let prism = |g: &PlacedGlyph| self.prism(g, material);
        glyphs.iter().filter_map(prism).collect()
    }

    /// The prism of a placed glyph; none if it has no contours.
    pub fn prism(&self, glyph: &PlacedGlyph, material: MaterialId) -> Option<Prism> {
        let mut world_from_figure = self.world_from_glyph(glyph.pen);
        let [across, up, depth] = world_from_figure
            .matrix3
            .to_cols_array_2d()
            .map(DVec3::from);
        let axis = glyph.axis;
        world_from_figure.matrix3 = DMat3::from_cols(
            axis.x * across + axis.y * up,
            axis.x * up - axis.y * across,
            depth,
        );
        (!glyph.figure.contours.is_empty()).then(|| Prism {
            figure: Arc::clone(&glyph.figure),
            world_from_figure,
            material,
            bevel: None,
        })
    }

    /// The frame whose front lies `rise` before this one's, as a share of the depth. Its back is a little nearer than
    /// this one's: where both are in one plane, it would be a face in two colours.
    pub fn raised(&self, rise: f64) -> TextFrame {
        self.between(-rise, 1.0 - BACKS * rise)
    }

    /// The frame of a letter's layer, where the front of each lies a `step` before that of the one below, as a share of
    /// the depth. What lies on another layer reaches no further back than a little into it.
    pub fn of_layer(&self, glyph: &PlacedGlyph, step: f64) -> TextFrame {
        let front = step * f64::from(glyph.layer);
        match glyph.base {
            Some(base) => {
                let base = step * f64::from(base);
                self.between(-front, BACKS * (front - base) - base)
            }
            None => self.raised(front),
        }
    }

    /// The frame between two shares of the depth, of which 0 is the front and 1 the back.
    fn between(&self, front: f64, back: f64) -> TextFrame {
        TextFrame {
            origin: self.origin + front * self.scale.z * self.extrusion,
            scale: DVec3 {
                z: self.scale.z * (back - front),
                ..self.scale
            },
            ..*self
        }
    }
}

/// How far the backs of layers are apart, as a share of the distance of their fronts.
const BACKS: f64 = 1e-3;

/// Why a string cannot be laid out.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TextError {
    /// The encoding names no glyph for this character.
    NoName(char),
    /// The font has no glyph of this name.
    NoGlyph(String),
    /// A `/` opens a glyph's name that no second `/` closes.
    OpenName(String),
}

impl fmt::Display for TextError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TextError::NoName(c) => write!(
                f,
                "the encoding names no glyph for `{c}` (code {})",
                u32::from(*c)
            ),
            TextError::NoGlyph(name) => write!(f, "the font has no glyph `{name}`"),
            TextError::OpenName(name) => {
                write!(f, "`/{name}` opens a glyph name that is not closed by `/`")
            }
        }
    }
}

impl std::error::Error for TextError {}

/// Advance of a blank for which a font has no glyph, font units.
const BLANK: f64 = 0.5;

impl Font {
    /// Lays out one line as RTRACE does: glyph after glyph, `spacing` extra font units between
    /// them, no kerning. `/name/` selects the glyph of that name; a blank is as wide as the glyph that the encoding
    /// names for it, otherwise 0.5.
    ///
    /// # Errors
    /// [`TextError`]: a character or a name without a glyph.
    pub fn lay_out(
        &self,
        text: &str,
        encoding: &Encoding,
        spacing: f64,
    ) -> Result<Vec<PlacedGlyph>, TextError> {
        Ok(self.set_line(text, encoding, spacing)?.glyphs)
    }

    /// As [`lay_out`](Font::lay_out), with the length of the line.
    ///
    /// # Errors
    /// As [`lay_out`](Font::lay_out).
    pub fn set_line(
        &self,
        text: &str,
        encoding: &Encoding,
        spacing: f64,
    ) -> Result<Line, TextError> {
        let mut line = Line::default();
        let mut pen = DVec2::ZERO;
        let mut rest = text;
        while let Some((bytes, glyph)) = self.next_glyph(rest, encoding)? {
            let start = line.glyphs.len();
            if !glyph.figure.contours.is_empty() {
                line.glyphs.push(PlacedGlyph::new(glyph.figure, pen));
            }
            line.letters.push(Letter {
                glyphs: start..line.glyphs.len(),
                start: pen.x,
                advance: glyph.advance,
                is_blank: rest.starts_with(char::is_whitespace),
            });
            rest = &rest[bytes..];
            line.advance = pen.x + glyph.advance;
            pen.x = line.advance + spacing;
        }
        Ok(line)
    }

    /// The glyph at the start of a text, and how many bytes of the text it stands for; `None` at its end. A blank has
    /// no outline.
    ///
    /// # Errors
    /// As [`lay_out`](Font::lay_out).
    pub fn next_glyph(
        &self,
        text: &str,
        encoding: &Encoding,
    ) -> Result<Option<(usize, Glyph)>, TextError> {
        let Some(c) = text.chars().next() else {
            return Ok(None);
        };
        let named = encoding.names.get(&u32::from(c));
        if c == ' ' || c == '\u{a0}' {
            let own = named.and_then(|name| self.glyphs.get(name));
            let blank = Glyph {
                figure: Arc::default(),
                advance: own.map_or(BLANK, |glyph| glyph.advance),
            };
            return Ok(Some((c.len_utf8(), blank)));
        }
        let (bytes, name) = match text.strip_prefix('/') {
            Some(rest) => {
                let end = rest.find('/');
                let end = end.ok_or_else(|| TextError::OpenName(rest.to_owned()))?;
                (end + 2, &rest[..end])
            }
            None => (c.len_utf8(), &**named.ok_or(TextError::NoName(c))?),
        };
        let glyph = self.glyphs.get(name);
        let glyph = glyph.ok_or_else(|| TextError::NoGlyph(name.into()))?;
        Ok(Some((bytes, glyph.clone())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn font() -> (Font, Encoding) {
        let square = |w: f64| {
            let corners = [(0.1, 0.0), (w, 0.0), (w, 1.0), (0.1, 1.0)];
            Glyph::new(Figure::polygon(corners.map(DVec2::from)))
        };
        let glyphs = [
            ("A".to_owned(), square(0.6)),
            ("at".to_owned(), square(1.0)),
        ];
        let names = [
            (64, "at".to_owned()),
            (65, "A".to_owned()),
            (66, "B".to_owned()),
        ];
        let glyphs = glyphs.into_iter().collect();
        let names = names.into_iter().collect();
        (Font { glyphs }, Encoding { names })
    }

    #[test]
    fn pens_move_by_reach_and_spacing() {
        let (font, encoding) = font();
        let placed = font.lay_out("A @/A/", &encoding, 0.25).unwrap();
        let pens: Vec<f64> = placed.iter().map(|g| g.pen.x).collect();
        assert_eq!(pens, [0.0, 1.6, 2.85]);
        assert!(Arc::ptr_eq(&placed[0].figure, &placed[2].figure));
    }

    #[test]
    fn blanks_are_as_wide_as_their_glyph() {
        let (mut font, mut encoding) = font();
        let point = Figure::polygon([DVec2::new(0.3, 0.0)]);
        font.glyphs.insert("space".into(), Glyph::new(point));
        encoding.names.insert(32, "space".into());
        let line = font.set_line("A A\u{a0}A", &encoding, 0.25).unwrap();
        let starts: Vec<f64> = line.letters.iter().map(|l| l.start).collect();
        for (start, expected) in starts.iter().zip([0.0, 0.85, 1.4, 2.25, 3.0]) {
            assert!((start - expected).abs() < 1e-12, "{starts:?}");
        }
        assert_eq!((line.glyphs.len(), line.letters[1].is_blank), (3, true));
    }

    #[test]
    fn blanks_of_justified_lines_stretch() {
        let (font, encoding) = font();
        let line = |is_broken: bool, is_rtl: bool| {
            let line = font.set_line(" A A @ ", &encoding, 0.0).unwrap();
            let mut line = Line {
                is_broken,
                is_rtl,
                ..line
            };
            line.justify(5.2);
            let pens = line.glyphs.iter().map(|g| (1e6 * g.pen.x).round() / 1e6);
            (
                pens.collect::<Vec<f64>>(),
                (1e6 * line.advance).round() / 1e6,
            )
        };
        // 4.2 wide: only the two blanks inside stretch.
        assert_eq!(line(false, false), (vec![0.5, 1.6, 2.7], 4.2));
        assert_eq!(line(true, false), (vec![0.5, 2.1, 3.7], 5.2));
        assert_eq!(line(true, true), (vec![0.5, 2.1, 3.7], 5.2));
        assert_eq!(line(false, true), (vec![1.5, 2.6, 3.7], 5.2));
        let mut word = font.set_line("AA", &encoding, 0.0).unwrap();
        word.is_broken = true;
        word.justify(9.0);
        assert_eq!(word.advance, 1.2);
    }

    #[test]
    fn large_letters_need_room() {
        let (font, encoding) = font();
        let line = |size: f64| Line {
            size,
            ..font.set_line("A", &encoding, 0.0).unwrap()
        };
        let placed = Align::Left.stack([line(3.0), line(1.0), line(2.0)], 1.5);
        let y: Vec<f64> = placed.iter().map(|g| g.pen.y).collect();
        assert_eq!(y, [0.0, -1.5, -4.5]);
    }

    #[test]
    fn letters_turn_and_grow_on_the_page() {
        let frame = TextFrame {
            origin: DVec3::new(1.0, 2.0, 3.0),
            progression: DVec3::X,
            up: DVec3::Y,
            extrusion: DVec3::NEG_Z,
            scale: DVec3::new(2.0, 2.0, 0.5),
        };
        let (font, _) = font();
        let turned = PlacedGlyph {
            axis: DVec2::new(0.0, 3.0),
            ..PlacedGlyph::new(Arc::clone(&font.glyphs["A"].figure), DVec2::new(1.0, 1.0))
        };
        let place = |frame: &TextFrame, p: [f64; 3]| {
            let prism = frame.prism(&turned, 0).unwrap();
            prism.world_from_figure.transform_point3(p.into())
        };
        assert_eq!(place(&frame, [1.0, 0.0, 0.0]), DVec3::new(3.0, 10.0, 3.0));
        assert_eq!(place(&frame, [0.0, 1.0, 1.0]), DVec3::new(-3.0, 4.0, 2.5));
        let raised = frame.raised(0.2);
        assert!((place(&raised, [1.0, 0.0, 0.0]).z - 3.1).abs() < 1e-12);
        let back = place(&raised, [0.0, 1.0, 1.0]).z;
        assert!(back > 2.5 && back < 2.501, "{back}");
        // Its second layer, on the first or by itself.
        let ends = |base: Option<u32>| {
            let layer = PlacedGlyph {
                layer: 2,
                base,
                ..turned.clone()
            };
            let frame = frame.of_layer(&layer, 0.1);
            [0.0, 1.0].map(|z| (1e3 * place(&frame, [0.0, 0.0, z]).z).round() / 1e3)
        };
        assert_eq!(ends(Some(1)), [3.1, 3.05]);
        assert_eq!(ends(Some(0)), [3.1, 3.0]);
        assert_eq!(ends(None), [3.1, 2.5]);
    }

    #[test]
    fn lines_are_flush_where_they_should_be() {
        let (font, encoding) = font();
        let check = |align: Align, pens: [(f64, f64); 3]| {
            let lines = ["@A", "", "A"].map(|t| font.set_line(t, &encoding, 0.25).unwrap());
            let placed = align.stack(lines, 1.5);
            assert_eq!(placed.len(), pens.len());
            for (glyph, pen) in placed.iter().zip(pens) {
                let off = glyph.pen.distance(pen.into());
                assert!(off < 1e-12, "{align:?} {} {pen:?}", glyph.pen);
            }
        };
        check(Align::Left, [(0.0, 0.0), (1.25, 0.0), (0.0, -3.0)]);
        check(Align::Center, [(-0.925, 0.0), (0.325, 0.0), (-0.3, -3.0)]);
        check(Align::Right, [(-1.85, 0.0), (-0.6, 0.0), (-0.6, -3.0)]);
    }

    #[test]
    fn what_leads_nowhere_is_named() {
        let (font, encoding) = font();
        let check = |text: &str, error: TextError| {
            assert_eq!(font.lay_out(text, &encoding, 0.0), Err(error));
        };
        check("AC", TextError::NoName('C'));
        check("AB", TextError::NoGlyph("B".into()));
        check("A/at", TextError::OpenName("at".into()));
    }
}
