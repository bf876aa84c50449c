//! TEXT, ATTRIB, ATTDEF and MTEXT as outlines.

use super::figures::{FigureEntity, FigureReader, ReadResult, bits};
use super::mtext::{LetterStyle, StyledLetters, Token, decoded_codes, tokens};
use super::pairs::Value;
use super::record::Record;
use crate::reading::text::text;
use crate::{FontRequest, ReadError};
use azulejo_scene::{Contour, Figure};
use glam::{DAffine2, DMat2, DVec2};
use std::borrow::Cow;
use std::collections::HashMap;
use std::rc::Rc;

/// Distance of baselines, in heights of capital letters: AutoCAD's single line spacing.
const LINE_SPACING: f64 = 5.0 / 3.0;
/// Height of the letters of two texts above each other, as a share of that of others.
const STACKED: f64 = 0.7;
/// Letters lean by no more, degrees.
const STEEPEST: f64 = 85.0;

/// What a STYLE says.
#[derive(Clone, Debug, Default)]
pub(super) struct TextFont {
    /// The file, which names its family more or less.
    file: String,
    width: Option<f64>,
    oblique: f64,
}

/// Styles by their names in lower case, and the outlines of letters without crossings.
#[derive(Default)]
pub(super) struct TextFonts {
    styles: HashMap<String, TextFont>,
    outlines: HashMap<Vec<u64>, Rc<Figure>>,
}

/// Contours to the right of a point on their baseline.
#[derive(Clone, Default)]
struct LetterBlock {
    contours: Vec<Contour>,
    width: f64,
}

impl LetterBlock {
    /// Adds another at a place.
    fn add(&mut self, other: LetterBlock, at: DVec2) {
        let mut figure = Figure {
            contours: other.contours,
            ..Figure::default()
        };
        figure.move_points(|p| p + at);
        self.contours.extend(figure.contours);
        self.width = self.width.max(at.x + other.width);
    }
}

impl TextFont {
    fn of(record: &Record) -> TextFont {
        let file = record.text(3);
        TextFont {
            file: file
                .rsplit(['/', '\\'])
                .next()
                .unwrap_or_default()
                .to_owned(),
            width: Some(record.real(41, 1.0)).filter(|w| *w > 0.0),
            oblique: record.real(50, 0.0),
        }
    }
}

/// The whole of a value, with its blanks.
fn unicode(value: Value<'_>) -> Cow<'_, str> {
    match value {
        Value::Text(bytes) => text(bytes),
        Value::Real(_) | Value::Integer(_) => Cow::default(),
    }
}

/// A font for a family or a file. Fonts of strokes (.shx) and unknown ones are replaced by one with serifs, with letters
/// of one width, or neither, by how AutoCAD and Windows name theirs.
fn request(family: &str, [is_bold, is_italic]: [bool; 2]) -> FontRequest {
    let stem = family.rsplit_once('.').map_or(family, |(stem, _)| stem);
    let name = stem.to_lowercase();
    let generic = match &*name {
        name if name.starts_with("times") || name.starts_with("roman") => "serif",
        name if name.starts_with("cour") || name.starts_with("mono") => "monospace",
        _ => "sans-serif",
    };
    let families = [family, stem, generic]
        .into_iter()
        .filter(|f| !f.is_empty());
    FontRequest {
        weight: if is_bold { 700 } else { 400 },
        is_italic,
        ..FontRequest::regular(families)
    }
}

impl FigureReader<'_> {
    /// Remembers a STYLE.
    pub(super) fn text_style(&mut self, record: &Record) {
        let name = record.text(2).to_lowercase();
        self.fonts.styles.insert(name, TextFont::of(record));
    }

    fn font_of(&self, record: &Record) -> TextFont {
        let name = record.text(7).to_lowercase();
        let name = if name.is_empty() { "standard" } else { &name };
        self.fonts.styles.get(name).cloned().unwrap_or_default()
    }

    /// A line of text, without those attributes of blocks that their INSERTs fill in.
    pub(super) fn text(&mut self, record: &Record) -> ReadResult {
        const INVISIBLE: i64 = 1;
        const CONSTANT: i64 = 2;
        let flags = match record.kind {
            b"ATTRIB" => record.integer(70, 0),
            b"ATTDEF" => record.integer(70, 0) ^ CONSTANT,
            _ => 0,
        };
        let hides = INVISIBLE
            | if record.kind == b"ATTDEF" {
                CONSTANT
            } else {
                0
            };
        if flags & hides != 0 {
            return Ok(());
        }
        let Some(plane) = self.plane(record) else {
            return Ok(());
        };
        let font = self.font_of(record);
        let style = LetterStyle {
            height: record.real(40, 1.0),
            width: record.real(41, 1.0),
            oblique: record.real(51, font.oblique),
            ..LetterStyle::default()
        };
        let said = decoded_codes(&record.find(1).map_or(Cow::default(), unicode));
        let Some(block) = self.letters(&said, &style, &font, record.offset)? else {
            return Ok(());
        };
        let placed = text_map(record, &block, &style);
        let plane = DMat2::from_cols(plane.x_axis.truncate(), plane.y_axis.truncate());
        self.place(record, block, DAffine2::from_mat2(plane) * placed)
    }

    /// Paragraphs of text.
    pub(super) fn paragraphs(&mut self, record: &Record) -> ReadResult {
        let Some(plane) = self.plane(record) else {
            return Ok(());
        };
        let font = self.font_of(record);
        let style = LetterStyle {
            height: record.real(40, 1.0),
            width: font.width.unwrap_or(1.0),
            oblique: font.oblique,
            ..LetterStyle::default()
        };
        let pieces = record.pairs.iter().filter(|p| matches!(p.code, 1 | 3));
        let whole: String = pieces.map(|pair| unicode(pair.value)).collect();
        let tokens = tokens(&decoded_codes(&whole), style.clone());
        let lines = self.lines(record, tokens, &font)?;
        let block = stacked(lines, record, style.height);
        let along = record.point(11).truncate();
        // The direction is in the drawing's coordinates, the angle in the entity's: in degrees, as programs write it,
        // although the reference speaks of radians.
        let plane = DMat2::from_cols(plane.x_axis.truncate(), plane.y_axis.truncate());
        let turn = match along.try_normalize() {
            Some(along) => DMat2::from_cols(along, along.perp() * plane.determinant().signum()),
            None => plane * DMat2::from_angle(record.real(50, 0.0).to_radians()),
        };
        let at = record.point(10).truncate();
        self.place(record, block, DAffine2::from_mat2_translation(turn, at))
    }

    /// The lines of some tokens: their heights and letters. Lines that are wider than the reference width end at blanks.
    fn lines(
        &mut self,
        record: &Record,
        tokens: Vec<Token>,
        font: &TextFont,
    ) -> Result<Vec<(f64, LetterBlock)>, ReadError> {
        let limit = record.real(41, 0.0);
        let (mut lines, mut line) = (Vec::new(), LetterBlock::default());
        let (mut height, mut pen) = (0.0_f64, 0.0);
        // Letters since the last blank, and the blank before them.
        let (mut word, mut blank) = (LetterBlock::default(), 0.0);
        let mut tokens = tokens.into_iter().chain([Token::Break]).peekable();
        while let Some(token) = tokens.next() {
            let is_last = matches!(tokens.peek(), None | Some(Token::Blank(_) | Token::Break));
            match token {
                Token::Text(text) => {
                    height = height.max(text.style.height);
                    let letters = self.styled(&text, font, record.offset)?;
                    let at = DVec2::new(word.width, 0.0);
                    word.add(letters, at);
                    if !is_last {
                        continue;
                    }
                    if limit > 0.0 && pen > 0.0 && pen + blank + word.width > limit * (1.0 + 1e-9) {
                        lines.push((height, std::mem::take(&mut line)));
                        (pen, blank) = (0.0, 0.0);
                    }
                    let word = std::mem::take(&mut word);
                    let end = pen + blank + word.width;
                    line.add(word, DVec2::new(pen + blank, 0.0));
                    (pen, blank) = (end, 0.0);
                }
                Token::Blank(style) => {
                    blank += self
                        .letters(" ", &style, font, record.offset)?
                        .map_or(0.0, |b| b.width);
                }
                Token::Break => {
                    lines.push((height, std::mem::take(&mut line)));
                    (height, pen, blank) = (0.0, 0.0, 0.0);
                }
            }
        }
        Ok(lines)
    }

    /// Letters, or two texts one above the other.
    fn styled(
        &mut self,
        text: &StyledLetters,
        font: &TextFont,
        offset: usize,
    ) -> Result<LetterBlock, ReadError> {
        let [above, below] = match &text.texts[..] {
            [above, below] => [above, below],
            texts => {
                let whole = self.letters(&texts.concat(), &text.style, font, offset)?;
                return Ok(whole.unwrap_or_default());
            }
        };
        let style = LetterStyle {
            height: STACKED * text.style.height,
            ..text.style.clone()
        };
        let mut stack = LetterBlock::default();
        for (said, rise) in [(above, 0.6), (below, -0.4)] {
            let letters = self.letters(said, &style, font, offset)?;
            let at = DVec2::new(0.0, rise * text.style.height);
            stack.add(letters.unwrap_or_default(), at);
        }
        Ok(stack)
    }

    /// One line of letters on the baseline, from 0 to the right; `None`, with a warning, if there is no font for it.
    fn letters(
        &mut self,
        said: &str,
        style: &LetterStyle,
        font: &TextFont,
        offset: usize,
    ) -> Result<Option<LetterBlock>, ReadError> {
        let request = match &style.font {
            Some((family, looks)) => request(family, *looks),
            None => request(&font.file, [false; 2]),
        };
        let set = match self.letters.set(said, &request, 0.0) {
            Ok(set) => set,
            Err(message) => {
                self.warn(message, offset);
                return Ok(None);
            }
        };
        if !said.trim().is_empty() {
            self.warn(set.remark(&request), offset);
        }
        // Heights are those of capital letters.
        let em = style.height / set.face.capital;
        let across = DVec2::new(em * style.width, 0.0);
        let lean = style.oblique.clamp(-STEEPEST, STEEPEST).to_radians().tan();
        let map = DMat2::from_cols(across, DVec2::new(em * lean, em));
        let mut block = LetterBlock::default();
        for glyph in &set.line.glyphs {
            self.spend(glyph.figure.curve_count())?;
            let outline = self.fonts.outline(&glyph.figure);
            let mut figure = Figure::clone(&outline);
            let pen = DVec2::new(style.tracking * glyph.pen.x, glyph.pen.y);
            figure.move_points(|p| map * (pen + p));
            block.contours.extend(figure.contours);
        }
        block.width = style.tracking * set.line.advance * across.x;
        Ok(Some(block))
    }

    fn place(&mut self, record: &Record, block: LetterBlock, map: DAffine2) -> ReadResult {
        let mut figure = Figure {
            contours: block.contours,
            ..Figure::default()
        };
        figure.move_points(|p| map.transform_point2(p));
        if !figure.bounds().size().is_finite() && !figure.contours.is_empty() {
            self.warn("text whose size is out of range: left out", record.offset);
            return Ok(());
        }
        let layer = self.layer(record);
        self.keep(FigureEntity::Letters(layer, figure.contours));
        Ok(())
    }
}

impl TextFonts {
    /// A letter whose contours do not cross, so that the even-odd rule fills it. Equal ones are found once.
    fn outline(&mut self, figure: &Figure) -> Rc<Figure> {
        let known = self.outlines.entry(bits(&figure.contours));
        Rc::clone(known.or_insert_with(|| Rc::new(figure.outline())))
    }
}

/// The plane of a line of TEXT from its letters, which begin at 0. Text that is fitted between two points is stretched.
fn text_map(record: &Record, block: &LetterBlock, style: &LetterStyle) -> DAffine2 {
    const ALIGNED: i64 = 3;
    const MIDDLE: i64 = 4;
    const FIT: i64 = 5;
    const BACKWARD: i64 = 2;
    const UPSIDE_DOWN: i64 = 4;
    let [first, second] = [10, 11].map(|code| record.point(code).truncate());
    let vertical = if record.kind == b"TEXT" { 73 } else { 74 };
    let (across, up) = (record.integer(72, 0), record.integer(vertical, 0));
    let mut angle = record.real(50, 0.0).to_radians();
    let flags = record.integer(71, 0);
    let mut scale = DVec2::new(
        if flags & BACKWARD != 0 { -1.0 } else { 1.0 },
        if flags & UPSIDE_DOWN != 0 { -1.0 } else { 1.0 },
    );
    let is_fitted = matches!(across, ALIGNED | FIT);
    let along = second - first;
    if is_fitted && along != DVec2::ZERO && block.width > 0.0 {
        angle = along.to_angle();
        let stretch = along.length() / block.width;
        scale *= DVec2::new(stretch, if across == ALIGNED { stretch } else { 1.0 });
    }
    let x = match across {
        1 | MIDDLE => 0.5 * block.width,
        2 => block.width,
        _ => 0.0,
    };
    let y = match up {
        2 => 0.5 * style.height,
        3 => style.height,
        _ if across == MIDDLE => 0.5 * style.height,
        _ => 0.0,
    };
    let is_second = !is_fitted && (across, up) != (0, 0);
    let at = if is_second { second } else { first };
    DAffine2::from_scale_angle_translation(scale, angle, at)
        * DAffine2::from_translation(DVec2::new(-x, -y))
}

/// Lines below each other around their point of attachment.
fn stacked(lines: Vec<(f64, LetterBlock)>, record: &Record, height: f64) -> LetterBlock {
    let attachment = record.integer(71, 1).clamp(1, 9) - 1;
    let (column, row) = (attachment % 3, attachment / 3);
    let spacing = record.real(44, 1.0) * LINE_SPACING;
    let heights = lines
        .iter()
        .map(|(own, _)| if *own > 0.0 { *own } else { height });
    let mut baselines: Vec<f64> = Vec::new();
    for own in heights {
        let next = baselines.last().map_or(-own, |last| last - spacing * own);
        baselines.push(next);
    }
    let bottom = baselines.last().copied().unwrap_or(0.0);
    let rise = [0.0, -0.5 * bottom, -bottom][row as usize];
    let mut all = LetterBlock::default();
    for ((_, line), baseline) in lines.into_iter().zip(baselines) {
        let shift = -0.5 * column as f64 * line.width;
        all.add(line, DVec2::new(shift, baseline + rise));
    }
    all
}
