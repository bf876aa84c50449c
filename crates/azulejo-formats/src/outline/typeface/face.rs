//! One face of a font file, and its glyphs as figures.

use super::afm::PairKerning;
use super::unpack::unpacked;
use crate::ReadError;
use crate::outline::pen::Pen;
use azulejo_scene::{Encoding, Figure, FillRule, Font, TextError};
use glam::DVec2;
use read_fonts::model::Font as FontFile;
use read_fonts::model::glyph::outline::{DrawMemory, DrawOptions, PathSink};
use read_fonts::model::variation::Variation;
use read_fonts::types::{GlyphId, NameId};
use std::collections::BTreeMap;
use std::fmt;
use unicode_script::UnicodeScript;

/// One face of a font file.
pub struct Typeface {
    pub(super) file: FontFile,
    /// Where it is on its axes; those that are not named are at their defaults.
    pub(super) variations: Vec<Variation>,
    /// Kerning from another file; that of its own tables is not here.
    pub(super) kerning: PairKerning,
}

/// A font of any format.
#[derive(Debug)]
pub enum FontFace {
    /// TrueType, OpenType or Type 1.
    Typeface(Typeface),
    /// RTRACE's glyphs by name, and the names of characters.
    Ppf(Font, Encoding),
}

/// Why a text cannot be set in a typeface.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SettingError {
    /// None of the fonts has glyphs for these characters, each named once.
    NoGlyphs(Vec<char>),
    /// The outline of this glyph cannot be read.
    Damaged(String),
    /// A name in a text for a font of PPF leads nowhere.
    Name(TextError),
}

impl FontFace {
    /// The typeface; `None` of PPF.
    pub fn typeface(&self) -> Option<&Typeface> {
        match self {
            FontFace::Typeface(typeface) => Some(typeface),
            FontFace::Ppf(..) => None,
        }
    }
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
            SettingError::NoGlyphs(missing) => write_missing(missing, f),
            SettingError::Name(e) => e.fmt(f),
            SettingError::Damaged(name) => write!(f, "the outline of glyph {name} is damaged"),
        }
    }
}

impl std::error::Error for SettingError {}

/// Characters without glyphs, by their scripts.
fn write_missing(missing: &[char], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    const SHOWN: usize = 20;
    let mut scripts: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for c in missing.iter().take(SHOWN) {
        let named = format!("`{c}` (U+{:04X})", u32::from(*c));
        scripts
            .entry(c.script().full_name())
            .or_default()
            .push(named);
    }
    let of_script = |(script, names): (&&str, &Vec<String>)| {
        // What belongs to all scripts, such as signs and pictures, has no name of its own.
        let of = match *script {
            "Common" | "Inherited" | "Unknown" => String::new(),
            script => format!(" of {}", script.replace('_', " ")),
        };
        format!("no glyph{of} for {}", names.join(", "))
    };
    let scripts: Vec<String> = scripts.iter().map(of_script).collect();
    f.write_str(&scripts.join(", "))?;
    match missing.len().saturating_sub(SHOWN) {
        0 => f.write_str("; another font after it may have them, --font A.ttf,B.ttf"),
        more => write!(f, " and {more} more characters"),
    }
}

/// Unsupported font formats, by their first bytes.
const OTHERS: [(&[u8], &str); 2] = [
    (b"STARTFONT", "a BDF bitmap font"),
    (b"\x01fcp", "a PCF bitmap font"),
];

impl Typeface {
    /// Reads a face of a font file (.ttf, .otf, .ttc, .otc, .woff, .woff2, .pfb, .pfa, .t1, or bare CFF). `name`
    /// is used in messages; `index` is 0 except in collections.
    ///
    /// # Errors
    /// Bytes that are not a font, a face that does not exist, and a font without outlines. Tables are
    /// read when they are needed: see [`SettingError::Damaged`].
    pub fn read(bytes: &[u8], name: &str, index: u32) -> Result<Typeface, ReadError> {
        const EXPECTED: &str = "a font in TrueType, OpenType, WOFF or Type 1";
        let bytes = unpacked(bytes, name)?;
        let Some(file) = FontFile::new(bytes.to_vec(), index) else {
            let other = OTHERS.iter().find(|(start, _)| bytes.starts_with(start));
            return Err(match other {
                Some((_, found)) => ReadError::whole(name, *found, EXPECTED),
                None if index > 0 => no_such_face(&bytes, name, index),
                None => ReadError::whole(name, "no font that can be read", EXPECTED),
            });
        };
        if file.outline_glyphs().is_empty() || file.units_per_em() == 0 {
            return Err(ReadError::whole(name, "a font without outlines", EXPECTED));
        }
        Ok(Typeface {
            file,
            variations: Vec::new(),
            kerning: PairKerning::default(),
        })
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

/// Names the faces there are.
fn no_such_face(bytes: &[u8], name: &str, index: u32) -> ReadError {
    const SHOWN: u32 = 16;
    let face = |k: u32| {
        let file = FontFile::new(bytes.to_vec(), k)?;
        let full = file.names().get(NameId::FULL_NAME);
        let full = full.and_then(|n| n.english_or_first());
        let full: String = full.map_or_else(String::new, |n| n.name().chars().collect());
        Some(format!("{k} {full}").trim_end().to_owned())
    };
    let faces: Vec<String> = (0..index.min(SHOWN)).map_while(face).collect();
    let expected = match &faces[..] {
        [] => "a font that can be read".to_owned(),
        faces => format!("one of {}", faces.join(", ")),
    };
    ReadError::whole(name, format!("no face {index}"), expected)
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
