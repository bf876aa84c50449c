//! How far the lines of a typeface reach.

use super::face::Typeface;

impl Typeface {
    /// How far a line reaches above and below its baseline, in ems: by the table that the font says counts, or four
    /// fifths and a fifth where it says nothing.
    pub fn line_extents(&self) -> [f64; 2] {
        let line = self.file.metrics().h_line();
        let Some(extents) = line.map(|line| line.extents()) else {
            return [0.8, 0.2];
        };
        [extents.ascender.to_f64(), -extents.descender.to_f64()].map(|units| units * self.em())
    }

    /// The height of a capital letter above the baseline, in ems: that of the outline of H, or seven tenths without one.
    pub fn capital_height(&self) -> f64 {
        let glyph = self.file.charmap().map_unicode('H');
        let figure = glyph.and_then(|glyph| self.figure(glyph).ok());
        let top = figure.map(|figure| figure.bounds().max.y);
        top.filter(|y| *y > 0.0 && y.is_finite()).unwrap_or(0.7)
    }
}
