//! Text: its letters, their places, and lines along paths. SVG 2, 11.

use super::style::{Paint, Style};
use super::walk::{PendingElement, SvgWalk};
use crate::ReadError;
use crate::outline::letters::TextLine;
use crate::outline::pen::Pen;
use crate::reading::text::shortened;
use azulejo_scene::{Figure, FillRule, PlacedGlyph};
use glam::{DAffine2, DMat2, DVec2};
use roxmltree::Node;
use std::collections::VecDeque;
use svgtypes::NumberListParser;

/// Deepest nesting of elements in a text; deeper ones are left out.
const DEEPEST: usize = 64;

/// A character, and what the lists of its elements say of it.
#[derive(Clone, Debug, Default)]
struct Letter {
    character: char,
    /// Index of its style.
    style: usize,
    /// Its absolute place, one coordinate or both.
    place: [Option<f64>; 2],
    shift: DVec2,
    /// Its own rotation, degrees.
    turn: f64,
    /// Index of the path that it is on.
    path: Option<usize>,
}

/// The lists of an element, of which each letter takes one value.
#[derive(Default)]
struct LetterLists {
    x: VecDeque<f64>,
    y: VecDeque<f64>,
    dx: VecDeque<f64>,
    dy: VecDeque<f64>,
    /// The last is of all that follow.
    rotate: VecDeque<f64>,
}

/// A path with letters on it.
struct TextPath {
    /// Corners along it, in the coordinates of the text, and how far each is from its start.
    corners: Vec<(f64, DVec2)>,
    start: f64,
}

/// The letters of a text.
#[derive(Default)]
struct LetterReader {
    letters: Vec<Letter>,
    styles: Vec<Style>,
    paths: Vec<TextPath>,
    keeps_blanks: bool,
}

/// Letters in a row that are set together, from where the row before ended.
struct LetterRow {
    set: TextLine,
    first: usize,
    /// Length in user units, with the space after its last letter.
    advance: f64,
}

impl<'a, 'i> SvgWalk<'a, 'i> {
    /// Adds what the letters of an element `text` fill, and their strokes.
    ///
    /// # Errors
    /// The drawing expands to more than the options allow.
    pub(super) fn text(&mut self, site: &PendingElement<'a, 'i>) -> Result<(), ReadError> {
        let mut reader = LetterReader::default();
        let mut lists = Vec::new();
        self.gather(
            site.element,
            site.style.clone(),
            site,
            &mut reader,
            &mut lists,
            None,
        )?;
        reader.trim();
        let mut start = 0;
        let mut pen = DVec2::ZERO;
        while start < reader.letters.len() {
            // A chunk begins where a letter has a place of its own, or a path begins.
            let begins = |k: &usize| {
                let (before, letter) = (&reader.letters[k - 1], &reader.letters[*k]);
                letter.place != [None; 2] || letter.path != before.path
            };
            let end = (start + 1..reader.letters.len()).find(begins);
            let end = end.unwrap_or(reader.letters.len());
            pen = self.chunk(&reader, start..end, pen, site)?;
            start = end;
        }
        Ok(())
    }

    /// Reads the letters of an element and of those inside it.
    fn gather(
        &mut self,
        element: Node<'a, 'i>,
        style: Style,
        site: &PendingElement<'a, 'i>,
        reader: &mut LetterReader,
        lists: &mut Vec<LetterLists>,
        path: Option<usize>,
    ) -> Result<(), ReadError> {
        const XML: &str = "http://www.w3.org/XML/1998/namespace";
        const UNUSED: [&str; 7] = [
            "textLength",
            "writing-mode",
            "dominant-baseline",
            "alignment-baseline",
            "baseline-shift",
            "text-decoration",
            "word-spacing",
        ];
        for name in UNUSED
            .into_iter()
            .filter(|name| element.has_attribute(*name))
        {
            self.warn(format!("{name}: not applied"), element);
        }
        let units = style.units(site.view);
        let outer = reader.keeps_blanks;
        if let Some(space) = element.attribute((XML, "space")) {
            reader.keeps_blanks = space == "preserve";
        }
        let lengths = |name: &str| {
            let list = element.attribute(name).unwrap_or("");
            let parts = list
                .split([',', ' ', '\t', '\n', '\r'])
                .filter(|part| !part.is_empty());
            parts.map_while(|part| units.length(name, part)).collect()
        };
        let turns = NumberListParser::from(element.attribute("rotate").unwrap_or(""));
        lists.push(LetterLists {
            x: lengths("x"),
            y: lengths("y"),
            dx: lengths("dx"),
            dy: lengths("dy"),
            rotate: turns.map_while(Result::ok).collect(),
        });
        let index = reader.styles.len();
        reader.styles.push(style.clone());
        for child in element.children() {
            if let Some(text) = child.text().filter(|_| child.is_text()) {
                self.spend(text.len() as u64)?;
                reader.add(text, index, lists, path);
                continue;
            }
            if !child.is_element() {
                continue;
            }
            let inner = style.clone().of(child, &self.sheet, site.view);
            let Some((inner, _)) = inner else {
                continue;
            };
            match child.tag_name().name() {
                _ if lists.len() > DEEPEST => {
                    self.warn(
                        format!("text nested more than {DEEPEST} deep: left out"),
                        child,
                    );
                }
                "tspan" | "a" => self.gather(child, inner, site, reader, lists, path)?,
                "textPath" => match self.text_path(child, &inner, site) {
                    Some(along) => {
                        reader.paths.push(along);
                        let path = Some(reader.paths.len() - 1);
                        self.gather(child, inner, site, reader, lists, path)?;
                    }
                    None => self.warn("textPath without a path: left out", child),
                },
                "title" | "desc" | "animate" | "set" => {}
                name => self.warn(format!("{}: left out", shortened(name)), child),
            }
        }
        lists.pop();
        reader.keeps_blanks = outer;
        Ok(())
    }

    /// The path that a `textPath` refers to, and where its letters begin on it.
    fn text_path(
        &mut self,
        element: Node<'a, 'i>,
        style: &Style,
        site: &PendingElement<'a, 'i>,
    ) -> Option<TextPath> {
        let target = self.linked(element)?;
        let units = style.units(site.view);
        let mut pen = Pen::default();
        match target.tag_name().name() {
            "path" => _ = super::path::draw(target.attribute("d")?, &mut pen),
            _ => _ = super::shapes::draw(target, &units, &mut pen)?,
        }
        let own = target
            .attribute("transform")
            .and_then(super::values::transform);
        let figure = pen.finish(FillRule::NonZero);
        let contour = figure.contours.first()?;
        let count = contour.curves.len();
        // An open path has been closed by a line, along which no text runs.
        let is_closed = target.tag_name().name() != "path"
            || target
                .attribute("d")
                .is_some_and(|d| d.trim_end().ends_with(['z', 'Z']));
        let tolerance = 1e-3 * style.letters.size;
        let mut corners: Vec<(f64, DVec2)> = Vec::new();
        let mut add = |p: DVec2| {
            let p = own.map_or(p, |map| map.transform_point2(p));
            let along = corners
                .last()
                .map_or(0.0, |(along, last)| along + last.distance(p));
            corners.push((along, p));
        };
        for (k, segment) in contour.segments().enumerate() {
            let closes = k + 1 == count && !is_closed && count > 1;
            if closes && matches!(segment, azulejo_scene::figure::Segment::Line(_)) {
                break;
            }
            let chords = segment.chords(tolerance);
            let first = if k == 0 { 0 } else { 1 };
            (first..=chords).for_each(|i| add(segment.at(f64::from(i) / f64::from(chords))));
        }
        let length = corners.last()?.0;
        let start = match element.attribute("startOffset").map(str::trim) {
            Some(text) => match text.strip_suffix('%') {
                Some(share) => 0.01 * length * share.parse::<f64>().ok()?,
                None => units.length("startOffset", text)?,
            },
            None => 0.0,
        };
        Some(TextPath { corners, start })
    }

    /// Adds the letters of a chunk, and returns where the next one begins if it does not say so.
    fn chunk(
        &mut self,
        reader: &LetterReader,
        letters: std::ops::Range<usize>,
        pen: DVec2,
        site: &PendingElement<'a, 'i>,
    ) -> Result<DVec2, ReadError> {
        let first = &reader.letters[letters.start];
        let anchor = reader.styles[first.style].letters.anchor;
        let path = first.path.map(|k| &reader.paths[k]);
        let Some(rows) = self.rows(reader, letters, site) else {
            return Ok(pen);
        };
        let shifts = rows.iter().map(|row| reader.letters[row.first].shift.x);
        let length: f64 = rows.iter().map(|row| row.advance).sum::<f64>() + shifts.sum::<f64>();
        let [x, y] = first.place;
        let mut pen = match path {
            Some(path) => DVec2::new(path.start + x.unwrap_or(0.0), y.unwrap_or(0.0)),
            None => DVec2::new(x.unwrap_or(pen.x), y.unwrap_or(pen.y)),
        };
        pen.x -= anchor * length;
        for row in rows {
            let letter = &reader.letters[row.first];
            let style = &reader.styles[letter.style];
            pen += letter.shift;
            let figure = row.figure(style.letters.size, letter.turn, pen, path);
            pen.x += row.advance;
            let inside = PendingElement {
                style: style.clone(),
                ..site.clone()
            };
            self.add_letters(figure, &inside)?;
        }
        Ok(pen)
    }

    /// The letters of a chunk in rows of one style without shifts and turns between them; `None`, with a warning, if they
    /// cannot be set.
    fn rows(
        &mut self,
        reader: &LetterReader,
        letters: std::ops::Range<usize>,
        site: &PendingElement<'a, 'i>,
    ) -> Option<Vec<LetterRow>> {
        let mut rows = Vec::new();
        let mut start = letters.start;
        while start < letters.end {
            let begins = |k: &usize| {
                let (before, letter) = (&reader.letters[k - 1], &reader.letters[*k]);
                letter.style != before.style
                    || letter.shift != DVec2::ZERO
                    || letter.turn != 0.0
                    || before.turn != 0.0
            };
            let end = (start + 1..letters.end).find(begins).unwrap_or(letters.end);
            let row = &reader.letters[start..end];
            let style = &reader.styles[row[0].style].letters;
            let text: String = row.iter().map(|letter| letter.character).collect();
            let request = style.request();
            if style.size <= 0.0 {
                return None;
            }
            let spacing = style.spacing / style.size;
            let set = match self.letters.set(&text, &request, spacing) {
                Ok(set) => set,
                Err(message) => {
                    self.warn(message, site.element);
                    return None;
                }
            };
            if !text.trim().is_empty() {
                self.warn(set.remark(&request), site.element);
            }
            rows.push(LetterRow {
                advance: style.size * set.line.advance + style.spacing,
                set,
                first: start,
            });
            start = end;
        }
        Some(rows)
    }

    /// Adds letters in the coordinates of their text as one shape.
    fn add_letters(
        &mut self,
        figure: Figure,
        site: &PendingElement<'a, 'i>,
    ) -> Result<(), ReadError> {
        let (fills, strokes) = site.paints();
        let stroked = strokes.then(|| self.stroked(&figure, site)).flatten();
        if fills {
            self.add(figure, site.style.fill, site)?;
        }
        match stroked {
            Some(stroked) if site.style.stroke.paint != Paint::None => {
                self.add(stroked, site.style.stroke.paint, site)
            }
            _ => Ok(()),
        }
    }
}

impl LetterReader {
    /// Adds the characters of a text. Blanks are as in CSS: several are one, unless the document keeps them.
    fn add(&mut self, text: &str, style: usize, lists: &mut [LetterLists], path: Option<usize>) {
        for character in text.chars() {
            let character = if matches!(character, '\n' | '\t' | '\r') {
                ' '
            } else {
                character
            };
            let follows_blank = self.letters.last().is_none_or(|l| l.character == ' ');
            if character == ' ' && follows_blank && !self.keeps_blanks {
                continue;
            }
            // The innermost element with a value for a letter decides, but each of them counts the letter.
            let mut take = |list: fn(&mut LetterLists) -> &mut VecDeque<f64>| {
                let values = lists.iter_mut().map(|l| list(l).pop_front());
                values.fold(None, |outer, own: Option<f64>| own.or(outer))
            };
            let place = [take(|l| &mut l.x), take(|l| &mut l.y)];
            let shift = [take(|l| &mut l.dx), take(|l| &mut l.dy)].map(|s| s.unwrap_or(0.0));
            let turns = lists.iter_mut().map(|l| match l.rotate.len() {
                0 => None,
                1 => l.rotate.front().copied(),
                _ => l.rotate.pop_front(),
            });
            let turn = turns.fold(None, |outer, own| own.or(outer)).unwrap_or(0.0);
            self.letters.push(Letter {
                character,
                style,
                place,
                shift: shift.into(),
                turn,
                path,
            });
        }
    }

    /// Drops the blank at the end.
    fn trim(&mut self) {
        if !self.keeps_blanks && self.letters.last().is_some_and(|l| l.character == ' ') {
            self.letters.pop();
        }
    }
}

impl LetterRow {
    /// The letters as one figure in the coordinates of their text, y down: from a pen, or along a path, on which the
    /// pen's x is how far it is from the start.
    fn figure(&self, size: f64, turn: f64, pen: DVec2, path: Option<&TextPath>) -> Figure {
        let mut whole = Figure {
            contours: Vec::new(),
            rule: FillRule::NonZero,
        };
        let glyphs = &self.set.line.glyphs;
        for (k, glyph) in glyphs.iter().enumerate() {
            let next = glyphs
                .get(k + 1)
                .map_or(self.set.line.advance, |next| next.pen.x);
            let Some(map) = placed(glyph, next, size, turn, pen, path) else {
                continue;
            };
            let mut figure = Figure::clone(&glyph.figure);
            figure.move_points(|p| map.transform_point2(p));
            whole.contours.extend(figure.contours);
        }
        whole
    }
}

/// The map of a letter, whose neighbour begins at `next` ems; `None` beyond the ends of its path.
fn placed(
    glyph: &PlacedGlyph,
    next: f64,
    size: f64,
    turn: f64,
    pen: DVec2,
    path: Option<&TextPath>,
) -> Option<DAffine2> {
    let up = DMat2::from_diagonal(DVec2::new(size, -size));
    let turned = DMat2::from_angle(turn.to_radians());
    let Some(path) = path else {
        let at = pen + size * DVec2::new(glyph.pen.x, -glyph.pen.y);
        return Some(DAffine2::from_mat2_translation(turned * up, at));
    };
    // The middle of a letter is on the path.
    let half = 0.5 * size * (next - glyph.pen.x);
    let (at, along) = path.at(pen.x + size * glyph.pen.x + half)?;
    let turned = DMat2::from_cols(along, along.perp()) * turned;
    let start = DVec2::new(-half, pen.y - size * glyph.pen.y);
    let at = at + DMat2::from_cols(along, along.perp()) * start;
    Some(DAffine2::from_mat2_translation(turned * up, at))
}

impl TextPath {
    /// The place and direction at a distance along it.
    fn at(&self, along: f64) -> Option<(DVec2, DVec2)> {
        let next = self.corners.partition_point(|(at, _)| *at < along).max(1);
        let ((from, start), (to, end)) = (*self.corners.get(next - 1)?, *self.corners.get(next)?);
        if along < 0.0 {
            return None;
        }
        let direction = (end - start).try_normalize()?;
        let share = ((along - from) / (to - from)).clamp(0.0, 1.0);
        Some((start + share * (end - start), direction))
    }
}
