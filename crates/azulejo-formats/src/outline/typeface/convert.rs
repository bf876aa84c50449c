//! Conversion of typefaces to PPF fonts.

use super::face::{SettingError, Typeface};
use super::overlap::{difference, union};
use azulejo_scene::{Curve, Encoding, Figure, FillRule, Font, Glyph};
use glam::DVec2;
use read_fonts::ps::agl;
use read_fonts::types::GlyphId;
use std::collections::BTreeMap;

/// Part of a typeface as PPF and PPE represent it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Converted {
    /// Outlines by glyph name, coordinates rounded to a millionth of an em.
    pub font: Font,
    /// Glyph names by character.
    pub encoding: Encoding,
    /// Requested characters that have no glyph.
    pub missing: Vec<char>,
    /// Glyphs whose overlapping contours could not be merged: PPF's even-odd rule leaves
    /// holes where the typeface fills.
    pub overlapping: Vec<String>,
}

impl Typeface {
    /// All characters that have a glyph of their own, in order.
    pub fn characters(&self) -> Vec<char> {
        let mapped = self.file.charmap().unicodes();
        let mut characters: Vec<char> = mapped.filter_map(|(c, _)| char::from_u32(c)).collect();
        characters.sort_unstable();
        characters.dedup();
        characters
    }

    /// Converts the glyphs of some characters to PPF.
    ///
    /// PPF has no side bearings: the advance is the largest x. Outlines are therefore shifted to
    /// the right by their right side bearing, so that text is as long as in the typeface,
    /// except for kerning. A blank is a contour without area as far to the right as the pen advances. Other characters
    /// without ink are left out. Names are those of the typeface,
    /// else those of Adobe's list, else `uni20AC`.
    ///
    /// # Errors
    /// An outline that cannot be read.
    pub fn convert(
        &self,
        characters: impl IntoIterator<Item = char>,
    ) -> Result<Converted, SettingError> {
        let mut converted = Converted::default();
        let mut names: BTreeMap<GlyphId, String> = BTreeMap::new();
        for character in characters {
            let glyph = self.file.charmap().map_unicode(character);
            let Some(glyph) = glyph.filter(|g| *g != GlyphId::NOTDEF) else {
                converted.missing.push(character);
                continue;
            };
            let name = match names.get(&glyph) {
                Some(name) => Some(name.clone()),
                None => self.add(glyph, character, &mut converted)?,
            };
            if let Some(name) = name {
                names.insert(glyph, name.clone());
                converted.encoding.names.insert(u32::from(character), name);
            }
        }
        Ok(converted)
    }

    /// Adds a glyph unless it exists and returns its name; none if it has no ink.
    fn add(
        &self,
        glyph: GlyphId,
        character: char,
        converted: &mut Converted,
    ) -> Result<Option<String>, SettingError> {
        let (mut figure, is_whole) = self.for_ppf(glyph)?;
        if figure.contours.is_empty() {
            let end = (1e6 * self.advance(glyph)).round() / 1e6;
            if character != ' ' || end <= 0.0 {
                return Ok(None);
            }
            figure = Figure::polygon([DVec2::new(end, 0.0)]);
        }
        let name = self.ppf_name(glyph, character, &converted.font);
        if !is_whole {
            converted.overlapping.push(name.clone());
        }
        let drawn = Glyph::new(figure);
        converted.font.glyphs.insert(name.clone(), drawn);
        Ok(Some(name))
    }

    /// The outline, shifted by its right side bearing, without overlaps if possible,
    /// rounded.
    fn for_ppf(&self, glyph: GlyphId) -> Result<(Figure, bool), SettingError> {
        let mut figure = self.figure(glyph)?;
        if figure.contours.is_empty() {
            return Ok((figure, true));
        }
        let bearing = DVec2::new(self.advance(glyph) - figure.bounds().max.x, 0.0);
        map_points(&mut figure, |p| p + bearing);
        let (mut figure, is_whole) = disentangled(figure);
        map_points(&mut figure, |p| (p * 1e6).round() / 1e6);
        Ok((figure, is_whole))
    }

    /// How far the pen advances over a glyph, ems.
    fn advance(&self, glyph: GlyphId) -> f64 {
        self.em() * f64::from(self.file.glyph_metrics().h_advance(glyph))
    }

    /// A name that PPF can represent and that no other glyph has.
    fn ppf_name(&self, glyph: GlyphId, character: char, taken: &Font) -> String {
        let own = self.file.glyph_name(glyph).filter(|n| !n.is_synthesized());
        let spelled = |name: &str| name.bytes().all(|b| b.is_ascii_graphic() && b != b'/');
        let name = match own.filter(|n| !n.as_str().is_empty() && spelled(n.as_str())) {
            Some(own) => own.as_str().to_owned(),
            None => {
                let mut room = [0; agl::MAX_NAME_LEN];
                let listed = agl::char_to_name(character, &mut room);
                let code = || format!("uni{:04X}", u32::from(character));
                listed.map_or_else(code, str::to_owned)
            }
        };
        if taken.glyphs.contains_key(&name) {
            format!("{name}.{}", glyph.to_u32())
        } else {
            name
        }
    }
}

/// An outline for which both fill rules agree, and whether that was possible.
fn disentangled(figure: Figure) -> (Figure, bool) {
    let even_odd = Figure {
        rule: FillRule::EvenOdd,
        contours: figure.contours.clone(),
    };
    if difference(&figure, &even_odd) < 1e-9 {
        return (even_odd, true);
    }
    match union(&figure) {
        Some(united) => (united, true),
        None => (even_odd, false),
    }
}

/// Maps all points of a figure.
pub(super) fn map_points(figure: &mut Figure, map: impl Fn(DVec2) -> DVec2) {
    let curves = figure.contours.iter_mut().flat_map(|c| &mut c.curves);
    let map = |p: &mut DVec2| *p = map(*p);
    curves.for_each(|curve| match curve {
        Curve::Line { start } => map(start),
        Curve::Cubic {
            start,
            control1,
            control2,
        } => [start, control1, control2].into_iter().for_each(map),
    });
}
