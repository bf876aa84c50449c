//! Text as flat letters in the plane z = 0: ISO/IEC 14772-1, 6.47 and 6.22; ISO/IEC 19775-1, 15.

use super::builder::{VrmlSceneBuilder, VrmlSource};
use super::shape::{SurfaceFields, ValuePool};
use super::tree::VrmlNode;
use crate::outline::letters::{Letters, TextLine};
use crate::{FontRequest, ReadError};
use azulejo_scene::{Figure, PlacedGlyph, Sidedness, Tiling};
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

/// How far the edges of letters may be off their curves, ems.
const TOLERANCE: f64 = 1e-3;

/// What a FontStyle says.
#[derive(Debug)]
pub(super) struct TextStyle {
    /// The font.
    pub request: FontRequest,
    /// Length of an em.
    pub size: f64,
    /// Distance of baselines or columns, in ems.
    pub spacing: f64,
    /// Whether strings are lines rather than columns.
    pub is_horizontal: bool,
    /// Whether letters, or columns, follow each other to the right.
    pub left_to_right: bool,
    /// Whether lines, or the letters of a column, follow each other downwards.
    pub top_to_bottom: bool,
    /// Along the strings, and across them.
    pub justify: [Justification; 2],
}

/// What of a text is at its origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Justification {
    /// The edge where it begins.
    Begin,
    /// The baseline of the first line; along the lines as `Begin`.
    First,
    /// Its middle.
    Middle,
    /// The edge where it ends.
    End,
}

impl Justification {
    fn named(name: Option<&String>, default: Justification) -> Justification {
        match name.map(String::as_str) {
            Some("BEGIN") => Justification::Begin,
            Some("FIRST") => Justification::First,
            Some("MIDDLE") => Justification::Middle,
            Some("END") => Justification::End,
            _ => default,
        }
    }

    /// What moves the text there, from where it begins and ends, and where its first baseline is.
    fn shift(self, begin: f64, end: f64, first: f64) -> f64 {
        match self {
            Justification::Begin => -begin,
            Justification::First => -first,
            Justification::Middle => -0.5 * (begin + end),
            Justification::End => -end,
        }
    }
}

impl TextStyle {
    /// The style of a node, or the default.
    fn of(node: Option<&VrmlNode>) -> TextStyle {
        let strings = |field: &str| node.map_or(Cow::Borrowed(&[][..]), |n| n.strings(field));
        let flag = |field: &str| node.is_none_or(|n| n.flag(field, true));
        let number = |field: &str| node.map_or(1.0, |n| n.number(field, 1.0));
        let style = strings("style").first().cloned().unwrap_or_default();
        let justify = strings("justify");
        TextStyle {
            request: request(strings("family").iter().map(String::as_str), &style),
            size: number("size"),
            spacing: number("spacing"),
            is_horizontal: flag("horizontal"),
            left_to_right: flag("leftToRight"),
            top_to_bottom: flag("topToBottom"),
            justify: [
                Justification::named(justify.first(), Justification::Begin),
                Justification::named(justify.get(1), Justification::First),
            ],
        }
    }
}

/// The font of some families, with VRML's names of generic ones, in the style PLAIN, BOLD, ITALIC or BOLDITALIC.
pub(super) fn request<'n>(families: impl Iterator<Item = &'n str>, style: &str) -> FontRequest {
    let generic = |family: &'n str| match family {
        "SANS" => "sans-serif",
        "TYPEWRITER" => "monospace",
        family => family,
    };
    let families = families.map(generic).chain(["serif"]);
    FontRequest {
        weight: if style.contains("BOLD") { 700 } else { 400 },
        is_italic: style.contains("ITALIC"),
        ..FontRequest::regular(families)
    }
}

/// The letters of a text as polygons, counter-clockwise, in the units of its node.
#[derive(Debug, Default)]
pub(super) struct FlatText {
    /// Corners.
    pub positions: Vec<DVec3>,
    /// Their indices; −1 ends a face.
    pub coord_index: Vec<i32>,
    /// Ems from the origin of the text.
    pub uvs: Vec<DVec2>,
}

/// One string in ems: along +x from 0, or along ±y from 0.
struct TextStrip {
    glyphs: Vec<PlacedGlyph>,
    /// Its extent along itself.
    length: f64,
    /// How far it reaches across, below and above its own line.
    reach: [f64; 2],
}

impl VrmlSceneBuilder<'_> {
    /// The letters of a node `Text`; `None` if there are none.
    ///
    /// # Errors
    /// The model unfolds to more than the options allow.
    pub(super) fn text<'n>(
        &mut self,
        node: &'n VrmlNode,
    ) -> Result<Option<SurfaceFields<'n>>, ReadError> {
        let style = TextStyle::of(self.child(node, "fontStyle")?.as_deref());
        let (strings, lengths) = (node.strings("string"), node.numbers("length"));
        let most = node.number("maxExtent", 0.0);
        let place = (&*node.source, node.at);
        let flat = self.flat_text(&strings, &lengths, most, &style, place)?;
        if flat.positions.is_empty() {
            return Ok(None);
        }
        let mut surface = SurfaceFields::new(node, flat.positions, Cow::Owned(flat.coord_index));
        // Two-sided by default, and always as seen from the front: ISO/IEC 19775-1, 15.4.2.
        surface.ccw = true;
        surface.solid = node.flag("solid", false);
        if surface.sidedness == Sidedness::Unsaid {
            surface.sidedness = Sidedness::Two;
        }
        surface.uvs = Some(ValuePool::per_vertex(flat.uvs));
        Ok(Some(surface))
    }

    /// Strings as polygons. `lengths` are those of single strings, and `most` that of the longest, in the units of the node;
    /// 0 is no limit.
    ///
    /// # Errors
    /// The model unfolds to more than the options allow.
    pub(super) fn flat_text(
        &mut self,
        strings: &[String],
        lengths: &[f64],
        most: f64,
        style: &TextStyle,
        (source, at): (&VrmlSource, usize),
    ) -> Result<FlatText, ReadError> {
        let mut strips = Vec::new();
        for string in strings {
            let strip = strip(&mut self.letters, string, style);
            let (strip, message) = match strip {
                Ok((strip, remark)) => (strip, Some(remark)),
                Err(message) => (TextStrip::blank(), Some(message)),
            };
            strips.push(strip);
            if let Some(message) = message.filter(|_| !string.is_empty()) {
                self.warn(source, at, message);
            }
        }
        let wanted = |k: usize| lengths.get(k).copied().unwrap_or(0.0) / style.size;
        for (k, strip) in strips.iter_mut().enumerate() {
            strip.stretch(wanted(k) / strip.length, style.is_horizontal);
        }
        let longest = strips.iter().map(|s| s.length).fold(0.0, f64::max);
        let limit = most / style.size;
        if limit > 0.0 && longest > limit {
            let strips = strips.iter_mut();
            strips.for_each(|s| s.stretch(limit / longest, style.is_horizontal));
        }
        let mut text = FlatText::default();
        let mut tilings = HashMap::new();
        for (strip, shift) in strips.iter().zip(shifts(&strips, style)) {
            for glyph in &strip.glyphs {
                let known = tilings.entry(Arc::as_ptr(&glyph.figure));
                let tiling = known.or_insert_with(|| Rc::new(glyph.figure.tiling(TOLERANCE)));
                self.spend(tiling.points.len() as u64)?;
                text.add(tiling, glyph.pen + shift, style.size);
            }
        }
        Ok(text)
    }
}

/// A string along its line or column, and what is to be said of its font.
fn strip(
    letters: &mut Letters,
    string: &str,
    style: &TextStyle,
) -> Result<(TextStrip, String), String> {
    if style.is_horizontal {
        let backwards: String;
        let text = if style.left_to_right {
            string
        } else {
            backwards = string.chars().rev().collect();
            &backwards
        };
        let set = letters.set(text, &style.request, 0.0)?;
        let remark = set.remark(&style.request);
        return Ok((TextStrip::line(set), remark));
    }
    let mut column = TextStrip::blank();
    let mut remark = String::new();
    for letter in string.chars() {
        let set = letters.set(letter.encode_utf8(&mut [0; 4]), &style.request, 0.0)?;
        remark = set.remark(&style.request);
        column.add_below(set, style.top_to_bottom);
    }
    Ok((column, remark))
}

impl TextStrip {
    fn blank() -> TextStrip {
        TextStrip {
            glyphs: Vec::new(),
            length: 0.0,
            reach: [0.0; 2],
        }
    }

    fn line(set: TextLine) -> TextStrip {
        TextStrip {
            length: set.line.advance,
            reach: [set.face.descent, set.face.ascent],
            glyphs: set.line.glyphs,
        }
    }

    /// Adds a letter to a column, centred; each takes the height of a line.
    fn add_below(&mut self, set: TextLine, top_to_bottom: bool) {
        let (ascent, descent) = (set.face.ascent, set.face.descent);
        let baseline = if top_to_bottom {
            -self.length - ascent
        } else {
            self.length + descent
        };
        let half = 0.5 * set.line.advance;
        self.reach = self.reach.map(|reach| reach.max(half));
        self.length += ascent + descent;
        let placed = set.line.glyphs.into_iter().map(|glyph| PlacedGlyph {
            pen: glyph.pen + DVec2::new(-half, baseline),
            ..glyph
        });
        self.glyphs.extend(placed);
    }

    /// Stretches it along itself, unless the factor is no positive number.
    fn stretch(&mut self, factor: f64, is_horizontal: bool) {
        if !(factor > 0.0 && factor.is_finite()) || factor == 1.0 {
            return;
        }
        let scale = if is_horizontal {
            DVec2::new(factor, 1.0)
        } else {
            DVec2::new(1.0, factor)
        };
        self.length *= factor;
        for glyph in &mut self.glyphs {
            glyph.pen *= scale;
            glyph.figure = Arc::new(scaled(&glyph.figure, scale));
        }
    }
}

fn scaled(figure: &Figure, scale: DVec2) -> Figure {
    let mut figure = figure.clone();
    figure.move_points(|p| scale * p);
    figure
}

/// Where the strings go, in ems.
fn shifts(strips: &[TextStrip], style: &TextStyle) -> Vec<DVec2> {
    // Lines follow each other downwards or upwards, columns to the left or to the right.
    let descends = if style.is_horizontal {
        style.top_to_bottom
    } else {
        !style.left_to_right
    };
    let step = if descends {
        -style.spacing
    } else {
        style.spacing
    };
    let across = |k: usize| k as f64 * step;
    let edge = |k: usize, is_high: bool| {
        let [below, above] = strips.get(k).map_or([0.0; 2], |strip| strip.reach);
        across(k) + if is_high { above } else { -below }
    };
    let begin = edge(0, descends);
    let end = edge(strips.len().saturating_sub(1), !descends);
    let first = if style.is_horizontal { 0.0 } else { begin };
    let [major, minor] = style.justify;
    let minor = minor.shift(begin, end, first);
    let along = |strip: &TextStrip| {
        // Lines are set from 0 to the right, whichever way they run; columns run away from 0.
        let ends = [0.0, strip.length];
        let [begin, end] = match (
            style.is_horizontal,
            style.left_to_right,
            style.top_to_bottom,
        ) {
            (true, true, _) | (false, _, false) => ends,
            (true, false, _) => [ends[1], ends[0]],
            (false, _, true) => ends.map(|end| -end),
        };
        major.shift(begin, end, begin)
    };
    let place = |(k, strip): (usize, &TextStrip)| {
        let (major, minor) = (along(strip), across(k) + minor);
        if style.is_horizontal {
            DVec2::new(major, minor)
        } else {
            DVec2::new(minor, major)
        }
    };
    strips.iter().enumerate().map(place).collect()
}

impl FlatText {
    fn add(&mut self, tiling: &Tiling, pen: DVec2, size: f64) {
        let first = self.positions.len() as i32;
        let places = tiling.points.iter().map(|p| pen + *p);
        self.uvs.extend(places.clone());
        self.positions
            .extend(places.map(|p| (size * p).extend(0.0)));
        for ring in &tiling.rings {
            let corners = ring.iter().map(|&k| first + k as i32);
            self.coord_index.extend(corners.chain([-1]));
        }
    }
}
