//! Kerning of Type 1 fonts, which is in files of their own: Adobe Font Metrics.
//!
//! Source: Adobe Technical Note #5004, *Adobe Font Metrics File Format Specification*, 1998, section 9.

use super::face::Typeface;
use crate::ReadError;
use crate::reading::text::decoded_text;
use read_fonts::types::GlyphId;
use std::collections::HashMap;

/// Largest correction that is believed, in ems.
const LARGEST: f64 = 4.0;

/// Distances between pairs of glyphs, ems.
#[derive(Clone, Debug, Default)]
pub(super) struct PairKerning(HashMap<(GlyphId, GlyphId), f64>);

impl PairKerning {
    /// Whether it has no pairs.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What is added to the advance of `left` before `right`.
    pub fn between(&self, left: GlyphId, right: GlyphId) -> f64 {
        self.0.get(&(left, right)).copied().unwrap_or(0.0)
    }
}

impl Typeface {
    /// Takes the kerning of a font of Type 1 from its metrics (.afm); returns the number of its pairs. `name` is used
    /// in messages. Pairs of glyphs that the font does not have are left out.
    ///
    /// # Errors
    /// Text that is no AFM, and a distance that is no number or beyond all measure, with its line.
    pub fn kern(&mut self, bytes: &[u8], name: &str) -> Result<usize, ReadError> {
        let text = decoded_text(bytes);
        if !text.trim_start().starts_with("StartFontMetrics") {
            let expected = "Adobe Font Metrics, which begin with StartFontMetrics";
            return Err(ReadError::whole(name, "another file", expected));
        }
        let mut pairs = HashMap::new();
        for (k, line) in text.lines().enumerate() {
            let mut words = line.split_ascii_whitespace();
            // KPY is vertical, and KPH names its glyphs by their codes.
            if !matches!(words.next(), Some("KPX" | "KP")) {
                continue;
            }
            let (left, right, distance) = (words.next(), words.next(), words.next());
            // Units are a thousandth of the em, whatever the font's are.
            let distance = distance.and_then(|d| Some(1e-3 * d.parse::<f64>().ok()?));
            let distance = distance.filter(|d| d.abs() <= LARGEST);
            let (Some(left), Some(right), Some(distance)) = (left, right, distance) else {
                let (line_number, expected) =
                    (k as u32 + 1, "two glyphs and a distance: KPX A V -80");
                return Err(ReadError::at_line(
                    name,
                    &text,
                    line_number,
                    1,
                    "no such pair",
                    expected,
                ));
            };
            let glyphs = [left, right].map(|glyph| self.file.glyph_by_name(glyph));
            if let [Some(left), Some(right)] = glyphs {
                pairs.insert((left, right), distance);
            }
        }
        let count = pairs.len();
        self.kerning = PairKerning(pairs);
        Ok(count)
    }
}
