//! Text set in a typeface: bidirectional, shaped, kerned.

use super::face::{SettingError, Typeface};
use azulejo_scene::{Figure, Line, PlacedGlyph};
use glam::DVec2;
use harfrust::{Buffer, Direction, Script, ShapeOptions, ShaperFont, shape, unicode};
use read_fonts::types::GlyphId;
use std::collections::{BTreeSet, HashMap};
use std::ops::Range;
use std::sync::Arc;
use unicode_bidi::BidiInfo;

/// Sets lines in one typeface; repeated glyphs share their figures.
pub struct Setting<'a> {
    typeface: &'a Typeface,
    shaper: ShaperFont<'a, 'static>,
    figures: HashMap<GlyphId, Arc<Figure>>,
}

/// Text that is shaped at once: one script, one direction.
#[derive(Clone, Debug, PartialEq)]
struct Run {
    bytes: Range<usize>,
    script: Script,
    is_rtl: bool,
}

impl Typeface {
    /// Starts setting text.
    pub fn setting(&self) -> Setting<'_> {
        Setting {
            typeface: self,
            shaper: ShaperFont::new(&self.file),
            figures: HashMap::new(),
        }
    }
}

impl Setting<'_> {
    /// Sets one line with the font's kerning, ligatures and marks, with `spacing` extra ems between
    /// clusters. Right-to-left text is ordered by Unicode's bidirectional algorithm. A tab
    /// counts as a blank.
    ///
    /// # Errors
    /// All characters for which there is no glyph, or an outline that cannot be read.
    pub fn line(&mut self, text: &str, spacing: f64) -> Result<Line, SettingError> {
        let text = text.replace('\t', " ");
        let mut line = Line::default();
        let mut missing = BTreeSet::new();
        let mut pen = 0.0;
        for run in visual_runs(&text) {
            let buffer = self.shape(&text, &run)?;
            if !self.find_missing(&text, &run, &buffer, &mut missing) {
                self.add_glyphs(&buffer, spacing, &mut pen, &mut line)?;
            }
        }
        if missing.is_empty() {
            Ok(line)
        } else {
            Err(SettingError::NoGlyphs(missing.into_iter().collect()))
        }
    }

    fn shape(&self, text: &str, run: &Run) -> Result<Buffer, SettingError> {
        let mut buffer = Buffer::new();
        buffer.set_direction(if run.is_rtl {
            Direction::RightToLeft
        } else {
            Direction::LeftToRight
        });
        buffer.set_script(Some(run.script));
        for (at, c) in text[run.bytes.clone()].char_indices() {
            buffer.push(u32::from(c), (run.bytes.start + at) as u32);
        }
        match shape(&self.shaper, &mut buffer, ShapeOptions::new()) {
            Ok(()) => Ok(buffer),
            Err(e) => Err(SettingError::Damaged(format!("(layout tables: {e})"))),
        }
    }

    /// Adds the characters of clusters that were shaped to the font's missing-glyph sign.
    fn find_missing(
        &self,
        text: &str,
        run: &Run,
        shaped: &Buffer,
        missing: &mut BTreeSet<char>,
    ) -> bool {
        let infos = shaped.glyph_infos();
        let none: Vec<usize> = (infos.iter())
            .filter(|g| g.glyph_id == GlyphId::NOTDEF.to_u32())
            .map(|g| g.cluster as usize)
            .collect();
        let mut starts: Vec<usize> = infos.iter().map(|g| g.cluster as usize).collect();
        starts.push(run.bytes.end);
        starts.sort_unstable();
        for &start in &none {
            let end = starts[starts.partition_point(|&s| s <= start)];
            let lost = text[start..end].chars().filter(|&c| !self.typeface.has(c));
            missing.extend(lost);
        }
        !none.is_empty()
    }

    fn add_glyphs(
        &mut self,
        shaped: &Buffer,
        spacing: f64,
        pen: &mut f64,
        line: &mut Line,
    ) -> Result<(), SettingError> {
        let em = self.typeface.em();
        let infos = shaped.glyph_infos();
        for (i, (info, shift)) in infos.iter().zip(shaped.glyph_positions()).enumerate() {
            let offset = DVec2::new(f64::from(shift.x_offset), f64::from(shift.y_offset));
            let figure = self.figure(GlyphId::new(info.glyph_id))?;
            line.glyphs.push(PlacedGlyph {
                figure,
                pen: DVec2::new(*pen, 0.0) + em * offset,
            });
            *pen += em * f64::from(shift.x_advance);
            line.advance = *pen;
            // A letter and its marks stay together.
            if infos
                .get(i + 1)
                .is_none_or(|next| next.cluster != info.cluster)
            {
                *pen += spacing;
            }
        }
        Ok(())
    }

    fn figure(&mut self, glyph: GlyphId) -> Result<Arc<Figure>, SettingError> {
        if let Some(figure) = self.figures.get(&glyph) {
            return Ok(Arc::clone(figure));
        }
        let figure = Arc::new(self.typeface.figure(glyph)?);
        self.figures.insert(glyph, Arc::clone(&figure));
        Ok(figure)
    }
}

/// The runs of a line from left to right.
fn visual_runs(text: &str) -> Vec<Run> {
    let bidi = BidiInfo::new(text, None);
    let mut runs = Vec::new();
    for paragraph in &bidi.paragraphs {
        let (levels, level_runs) = bidi.visual_runs(paragraph, paragraph.range.clone());
        for bytes in level_runs {
            let is_rtl = levels[bytes.start].is_rtl();
            let mut scripts = script_runs(text, bytes, is_rtl);
            if is_rtl {
                scripts.reverse();
            }
            runs.extend(scripts);
        }
    }
    runs
}

/// Splits text where the script changes. Characters without a script of their own, such as blanks and
/// accents, belong to the preceding run, at the start to the following one.
fn script_runs(text: &str, bytes: Range<usize>, is_rtl: bool) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (at, c) in text[bytes.clone()].char_indices() {
        let at = bytes.start + at;
        let script = unicode::script(u32::from(c));
        let is_own = ![Script::COMMON, Script::INHERITED, Script::UNKNOWN].contains(&script);
        match runs.last_mut() {
            Some(run) if is_own && run.script == Script::COMMON => run.script = script,
            Some(run) if !is_own || run.script == script => {}
            _ => runs.push(Run {
                bytes: at..at,
                script: if is_own { script } else { Script::COMMON },
                is_rtl,
            }),
        }
        if let Some(run) = runs.last_mut() {
            run.bytes.end = at + c.len_utf8();
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the texts of the runs, those from right to left in brackets.
    fn check(text: &str, expected: &[&str]) {
        let shown = |run: Run| {
            if run.is_rtl {
                format!("[{}]", &text[run.bytes])
            } else {
                text[run.bytes].to_owned()
            }
        };
        let runs: Vec<String> = visual_runs(text).into_iter().map(shown).collect();
        assert_eq!(runs, expected);
    }

    #[test]
    fn runs_are_in_visual_order() {
        check("", &[]);
        check("Luz, 12.", &["Luz, 12."]);
        check("Luz Φως свет", &["Luz ", "Φως ", "свет"]);
        check("ab אבג cd", &["ab ", "[אבג]", " cd"]);
        check("אב 12 ג", &["[ ג]", "12", "[אב ]"]);
        check("אב عر", &["[عر]", "[אב ]"]);
        check("e\u{301}", &["e\u{301}"]);
    }
}
