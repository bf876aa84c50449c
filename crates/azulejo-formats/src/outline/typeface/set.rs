//! Text set in fonts: bidirectional, shaped, kerned, in lines of a width.

use super::color::ColorLoss;
use super::face::{FontFace, SettingError, Typeface};
use super::features::FontFeature;
use super::runs::BidiParagraph;
use super::shape::{Cluster, FaceShaper, shape_in};
use super::styled::StyledText;
use azulejo_scene::{Letter, Line, PlacedGlyph};
use glam::DVec2;
use harfrust::Feature;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;
use unicode_linebreak::linebreaks;

/// Sets lines in one or several fonts; repeated glyphs share their figures.
pub struct Setting<'a> {
    fonts: Vec<FaceShaper<'a>>,
    features: Vec<Feature>,
    blank: BTreeSet<char>,
    losses: BTreeSet<ColorLoss>,
}

/// How the letters of paragraphs become lines, in ems.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Layout {
    /// Additional space between letters.
    pub spacing: f64,
    /// The width at which lines are broken; `None` if they are not.
    pub width: Option<f64>,
}

impl Typeface {
    /// Starts setting text.
    pub fn setting(&self) -> Setting<'_> {
        Setting::with(vec![FaceShaper::of(self)], &[])
    }
}

impl<'a> Setting<'a> {
    /// Starts setting text in fonts: what the first lacks is taken from the next.
    pub fn new(fonts: &'a [FontFace], features: &[FontFeature]) -> Setting<'a> {
        Setting::with(fonts.iter().map(FaceShaper::new).collect(), features)
    }

    fn with(fonts: Vec<FaceShaper<'a>>, features: &[FontFeature]) -> Setting<'a> {
        Setting {
            fonts,
            features: features.iter().map(|f| f.everywhere()).collect(),
            blank: BTreeSet::new(),
            losses: BTreeSet::new(),
        }
    }

    /// Sets one line with the font's kerning, ligatures and marks, with `spacing` extra ems between
    /// clusters. Right-to-left text is ordered by Unicode's bidirectional algorithm. A tab
    /// counts as a blank.
    ///
    /// # Errors
    /// All characters for which there is no glyph, or an outline that cannot be read.
    pub fn line(&mut self, text: &str, spacing: f64) -> Result<Line, SettingError> {
        let paragraph = Paragraph::new(StyledText::plain(text), spacing);
        self.set(&paragraph, 0..text.len())
    }

    /// Sets a paragraph as [`line`](Setting::line), and breaks it where Unicode's line breaking algorithm (UAX #14)
    /// allows. Blanks at the ends of lines are left out. What cannot be broken may be longer than the width.
    ///
    /// # Errors
    /// As [`line`](Setting::line).
    pub fn paragraph(
        &mut self,
        text: StyledText,
        layout: &Layout,
    ) -> Result<Vec<Line>, SettingError> {
        let length = text.text.len();
        let paragraph = Paragraph::new(text, layout.spacing);
        match layout.width {
            Some(width) if length > 0 => self.broken(&paragraph, width),
            _ => Ok(vec![self.set(&paragraph, 0..length)?]),
        }
    }

    /// Visible characters of what was set whose glyphs have no outlines: pictures are not drawn.
    pub fn blank(&self) -> &BTreeSet<char> {
        &self.blank
    }

    /// What was lost of the colours of glyphs that were set.
    pub fn losses(&self) -> &BTreeSet<ColorLoss> {
        &self.losses
    }

    /// Fills one line after the other, as long as they fit.
    fn broken(&mut self, paragraph: &Paragraph, width: f64) -> Result<Vec<Line>, SettingError> {
        let text = &paragraph.styled.text;
        let pens = self.pens(paragraph)?;
        let breaks: Vec<usize> = linebreaks(text).map(|(at, _)| at).collect();
        // A word that is divided at a soft hyphen would need a visible one.
        let breaks: Vec<usize> = (breaks.into_iter())
            .filter(|&at| !text[..at].ends_with('\u{ad}'))
            .collect();
        let mut lines = Vec::new();
        let (mut start, mut first) = (0, 0);
        while first < breaks.len() {
            let fits = |&at: &usize| {
                let inked = start + without_blanks(&text[start..at]).len();
                pens[inked] - pens[start] - paragraph.spacing <= width
            };
            let mut last = first + breaks[first..].partition_point(fits).max(1) - 1;
            // A line may be longer than it was in its paragraph, as letters at its end have other forms.
            let mut line = loop {
                let end = start + without_blanks(&text[start..breaks[last]]).len();
                let line = self.set(paragraph, start..end)?;
                if line.advance <= width || last == first {
                    break line;
                }
                last -= 1;
            };
            line.is_broken = last + 1 < breaks.len();
            lines.push(line);
            (start, first) = (breaks[last], last + 1);
        }
        Ok(lines)
    }

    /// The pen before each byte of a paragraph in a single line, and at its end, if all of it ran from left to right.
    fn pens(&mut self, paragraph: &Paragraph) -> Result<Vec<f64>, SettingError> {
        let text = &paragraph.styled.text;
        let mut pens = vec![0.0; text.len() + 1];
        for (cluster, size) in self.clusters(paragraph, 0..text.len())? {
            let advance = cluster.advance + paragraph.spacing;
            pens[cluster.bytes.end] = size * advance;
        }
        let mut pen = 0.0;
        for advance in &mut pens {
            pen += *advance;
            *advance = pen;
        }
        Ok(pens)
    }

    /// Sets a part of a paragraph as a line.
    fn set(&mut self, paragraph: &Paragraph, part: Range<usize>) -> Result<Line, SettingError> {
        let clusters = self.clusters(paragraph, part)?;
        let largest = clusters.iter().map(|(_, size)| *size).reduce(f64::max);
        let mut line = Line {
            size: largest.unwrap_or(1.0),
            is_rtl: paragraph.bidi.is_rtl(),
            ..Line::default()
        };
        let mut pen = 0.0;
        for (cluster, size) in clusters {
            let start = line.glyphs.len();
            let bytes = cluster.bytes.clone();
            let color = paragraph.styled.style_at(bytes.start).color;
            for glyph in cluster.glyphs {
                let at = DVec2::new(pen, 0.0) + size * glyph.pen;
                for (layer, drawn) in (0..).zip(&*glyph.layers) {
                    self.losses.extend(&drawn.losses);
                    line.glyphs.push(PlacedGlyph {
                        figure: Arc::clone(&drawn.figure),
                        pen: at,
                        axis: DVec2::new(size, 0.0),
                        color: drawn.color.or(color),
                        layer,
                        base: drawn.base,
                    });
                }
            }
            let characters = || paragraph.styled.text[bytes.clone()].chars();
            let is_blank = characters().all(char::is_whitespace);
            let advance = size * cluster.advance;
            line.letters.push(Letter {
                glyphs: start..line.glyphs.len(),
                start: pen,
                advance,
                is_blank,
            });
            let is_drawn = |g: &PlacedGlyph| !g.figure.contours.is_empty();
            if !is_blank && advance != 0.0 && !line.glyphs[start..].iter().any(is_drawn) {
                self.blank.extend(characters());
            }
            line.advance = pen + advance;
            pen = line.advance + size * paragraph.spacing;
        }
        Ok(line)
    }

    /// The clusters of a part of a paragraph from left to right, each with the size of its letters.
    fn clusters(
        &mut self,
        paragraph: &Paragraph,
        part: Range<usize>,
    ) -> Result<Vec<(Cluster, f64)>, SettingError> {
        let text = &*paragraph.styled.text;
        let mut clusters = Vec::new();
        let mut missing = BTreeSet::new();
        for run in paragraph.bidi.runs(text, part, &paragraph.cuts) {
            let size = paragraph.styled.style_at(run.bytes.start).size;
            for cluster in shape_in(&mut self.fonts, text, &run, &self.features)? {
                if cluster.is_missing {
                    missing.extend(self.missing(&text[cluster.bytes.clone()]));
                }
                clusters.push((cluster, size));
            }
        }
        if missing.is_empty() {
            Ok(clusters)
        } else {
            Err(SettingError::NoGlyphs(missing.into_iter().collect()))
        }
    }

    /// The characters of a cluster that no font has; if each has one, but no font has all, those that are not in the
    /// first.
    fn missing(&self, cluster: &str) -> Vec<char> {
        let lacked = |fonts: &[FaceShaper]| {
            let is_lacked = |c: &char| fonts.iter().all(|font| !font.has(*c));
            cluster.chars().filter(is_lacked).collect::<Vec<char>>()
        };
        let alternatives = [&*self.fonts, &self.fonts[..self.fonts.len().min(1)]];
        let mut found = alternatives.map(lacked).into_iter();
        let named = found.find(|missing| !missing.is_empty());
        named.unwrap_or_else(|| cluster.chars().collect())
    }
}

/// A paragraph that is being set.
struct Paragraph {
    styled: StyledText,
    bidi: BidiParagraph,
    /// Where sizes change.
    cuts: Vec<usize>,
    /// Additional ems between letters.
    spacing: f64,
}

impl Paragraph {
    fn new(mut styled: StyledText, spacing: f64) -> Paragraph {
        styled.text = styled.text.replace('\t', " ");
        Paragraph {
            bidi: BidiParagraph::new(&styled.text),
            cuts: styled.size_changes(),
            styled,
            spacing,
        }
    }
}

/// A line without the blanks at its end; blanks that do not break stay.
fn without_blanks(line: &str) -> &str {
    line.trim_end_matches(|c: char| c.is_whitespace() && !"\u{a0}\u{202f}\u{2007}".contains(c))
}
