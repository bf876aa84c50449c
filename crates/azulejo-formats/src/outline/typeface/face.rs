//! One face of a font file, and its glyphs as figures.

use crate::ReadError;
use crate::outline::pen::Pen;
use azulejo_scene::{Figure, FillRule};
use glam::DVec2;
use read_fonts::model::Font as FontFile;
use read_fonts::model::glyph::outline::{DrawMemory, DrawOptions, PathSink};
use read_fonts::types::GlyphId;
use std::fmt;

/// One face of a font file.
pub struct Typeface {
    pub(super) file: FontFile,
}

/// Why a text cannot be set in a typeface.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SettingError {
    /// The typeface has no glyphs for these characters, each named once.
    NoGlyphs(Vec<char>),
    /// The outline of this glyph cannot be read.
    Damaged(String),
}

impl fmt::Debug for Typeface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let glyphs = self.file.num_glyphs();
        f.debug_struct("Typeface").field("glyphs", &glyphs).finish()
    }
}

impl fmt::Display for SettingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SettingError::NoGlyphs(missing) => {
                const SHOWN: usize = 20;
                let named = |c: &char| format!("`{c}` (U+{:04X})", u32::from(*c));
                let names: Vec<String> = missing.iter().take(SHOWN).map(named).collect();
                let names = names.join(", ");
                write!(f, "the typeface has no glyph for {names}")?;
                match missing.len().saturating_sub(SHOWN) {
                    0 => Ok(()),
                    more => write!(f, " and {more} more characters"),
                }
            }
            SettingError::Damaged(name) => write!(f, "the outline of glyph {name} is damaged"),
        }
    }
}

impl std::error::Error for SettingError {}

/// Unsupported font formats, by their first bytes.
const OTHERS: [(&[u8], &str); 4] = [
    (b"wOFF", "a WOFF font; unpack it to TTF or OTF"),
    (b"wOF2", "a WOFF2 font; unpack it to TTF or OTF"),
    (b"STARTFONT", "a BDF bitmap font"),
    (b"\x01fcp", "a PCF bitmap font"),
];

impl Typeface {
    /// Reads a face of a font file (.ttf, .otf, .ttc, .otc, .pfb, .pfa, .t1, or bare CFF). `name`
    /// is used in messages; `index` is 0 except in collections.
    ///
    /// # Errors
    /// Bytes that are not a font, a face that does not exist, and a font without outlines. Tables are
    /// read when they are needed: see [`SettingError::Damaged`].
    pub fn read(bytes: &[u8], name: &str, index: u32) -> Result<Typeface, ReadError> {
        const EXPECTED: &str = "a font in TrueType, OpenType or Type 1";
        let Some(file) = FontFile::new(bytes.to_vec(), index) else {
            let other = OTHERS.iter().find(|(start, _)| bytes.starts_with(start));
            let is_collection = bytes.starts_with(b"ttcf") && index > 0;
            return Err(match other {
                Some((_, found)) => ReadError::whole(name, *found, EXPECTED),
                None if is_collection => {
                    let found = format!("no face {index} in the collection");
                    ReadError::whole(name, found, "a smaller number; the first face is 0")
                }
                None => ReadError::whole(name, "no font that can be read", EXPECTED),
            });
        };
        if file.outline_glyphs().is_empty() || file.units_per_em() == 0 {
            return Err(ReadError::whole(name, "a font without outlines", EXPECTED));
        }
        Ok(Typeface { file })
    }

    /// Whether the typeface has a glyph for a character, precomposed or combined.
    pub fn has(&self, character: char) -> bool {
        let glyph = self.file.charmap().map_unicode(character);
        glyph.is_some_and(|g| g != GlyphId::NOTDEF)
    }

    /// Ems per unit of the file.
    pub(super) fn em(&self) -> f64 {
        1.0 / f64::from(self.file.units_per_em())
    }

    /// The outline of a glyph; without contours for a blank one.
    pub(super) fn figure(&self, glyph: GlyphId) -> Result<Figure, SettingError> {
        let mut sink = Sink {
            pen: Pen::default(),
            em: self.em(),
            is_finite: true,
        };
        let Some(outline) = self.file.outline_glyphs().get(glyph) else {
            return Ok(Figure::default());
        };
        let drawn = outline.draw(&DrawOptions::new(), DrawMemory::Scratch, &mut sink);
        match drawn {
            Ok(_) if sink.is_finite => Ok(sink.pen.finish(FillRule::NonZero)),
            _ => Err(SettingError::Damaged(self.name_of(glyph))),
        }
    }

    /// The glyph's name in the file, or its number.
    pub(super) fn name_of(&self, glyph: GlyphId) -> String {
        let name = self.file.glyph_name(glyph);
        name.map_or_else(|| glyph.to_string(), |n| n.as_str().to_owned())
    }
}

/// Converts the outline from font units to ems.
struct Sink {
    pen: Pen,
    em: f64,
    is_finite: bool,
}

impl Sink {
    fn point(&mut self, x: f32, y: f32) -> DVec2 {
        let point = DVec2::new(f64::from(x), f64::from(y)) * self.em;
        self.is_finite &= point.is_finite();
        point
    }
}

impl PathSink for Sink {
    fn move_to(&mut self, x: f32, y: f32) {
        let to = self.point(x, y);
        self.pen.move_to(to);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let to = self.point(x, y);
        self.pen.line_to(to);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (control, to) = (self.point(x1, y1), self.point(x, y));
        self.pen.quadratic_to(control, to);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let controls = (self.point(x1, y1), self.point(x2, y2));
        let to = self.point(x, y);
        self.pen.cubic_to(controls.0, controls.1, to);
    }

    fn close(&mut self) {
        self.pen.close();
    }
}
