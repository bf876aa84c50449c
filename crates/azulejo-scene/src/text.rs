//! Text as prisms: fonts, encodings and layout.

use crate::{Figure, MaterialId, Prism};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::collections::BTreeMap;
use std::fmt;
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
}

/// One line of text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// Its glyphs; the line's pen starts at the origin and runs toward +x.
    pub glyphs: Vec<PlacedGlyph>,
    /// Final pen position, without the spacing after the last glyph, font units.
    pub advance: f64,
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
    /// Stacks lines, each `leading` font units below the previous one; the pen of the first is at
    /// y = 0.
    pub fn stack(self, lines: impl IntoIterator<Item = Line>, leading: f64) -> Vec<PlacedGlyph> {
        let before = match self {
            Align::Left => 0.0,
            Align::Center => 0.5,
            Align::Right => 1.0,
        };
        let place = |(k, line): (usize, Line)| {
            let shift = DVec2::new(-before * line.advance, -leading * k as f64);
            line.glyphs.into_iter().map(move |glyph| PlacedGlyph {
                pen: glyph.pen + shift,
                ..glyph
            })
        };
        lines.into_iter().enumerate().flat_map(place).collect()
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

    /// The prisms of placed glyphs; those without contours, such as blanks, produce none.
    pub fn prisms(&self, glyphs: &[PlacedGlyph], material: MaterialId) -> Vec<Prism> {
        let inked = glyphs.iter().filter(|g| !g.figure.contours.is_empty());
        let prism = |g: &PlacedGlyph| Prism {
            figure: Arc::clone(&g.figure),
            world_from_figure: self.world_from_glyph(g.pen),
            material,
            bevel: None,
        };
        inked.map(prism).collect()
    }
}

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

/// Advance of a blank, for which fonts have no glyph, font units.
const BLANK: f64 = 0.5;

impl Font {
    /// Lays out one line as RTRACE does: glyph after glyph, `spacing` extra font units between
    /// them, no kerning. `/name/` selects the glyph of that name; blanks need no glyph.
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
        while let Some(c) = rest.chars().next() {
            rest = &rest[c.len_utf8()..];
            if c == ' ' {
                line.advance = pen.x + BLANK;
                pen.x = line.advance + spacing;
                continue;
            }
            let name = if c == '/' {
                let (name, behind) =
                    (rest.split_once('/')).ok_or_else(|| TextError::OpenName(rest.to_owned()))?;
                rest = behind;
                name
            } else {
                let name = encoding.names.get(&u32::from(c));
                name.ok_or(TextError::NoName(c))?
            };
            let glyph = (self.glyphs.get(name)).ok_or_else(|| TextError::NoGlyph(name.into()))?;
            line.glyphs.push(PlacedGlyph {
                figure: Arc::clone(&glyph.figure),
                pen,
            });
            line.advance = pen.x + glyph.advance;
            pen.x = line.advance + spacing;
        }
        Ok(line)
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
