//! Shaping: the glyphs of runs, each in the first font that has them.

use super::color::GlyphLayer;
use super::face::{FontFace, SettingError, Typeface};
use super::runs::Run;
use azulejo_scene::{Encoding, Font, TextError};
use glam::DVec2;
use harfrust::{Buffer, Direction, Feature, Script, ShapeOptions, ShaperFont, Tag, shape};
use read_fonts::types::GlyphId;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// What stays together: a letter with its marks, a ligature, a blank; in ems of its font.
#[derive(Clone, Debug)]
pub(super) struct Cluster {
    /// Its bytes in the text.
    pub bytes: Range<usize>,
    pub glyphs: Vec<ShapedGlyph>,
    pub advance: f64,
    /// Whether the font lacks a glyph for it.
    pub is_missing: bool,
}

/// A glyph at its place in a cluster.
#[derive(Clone, Debug)]
pub(super) struct ShapedGlyph {
    pub layers: Arc<[GlyphLayer]>,
    pub pen: DVec2,
}

/// A font that shapes text. Glyphs that come again share their figures.
pub(super) enum FaceShaper<'a> {
    Typeface {
        typeface: &'a Typeface,
        shaper: Box<ShaperFont<'a, 'static>>,
        drawn: HashMap<GlyphId, Arc<[GlyphLayer]>>,
    },
    Ppf(&'a Font, &'a Encoding),
}

/// Shapes a run in the first of the fonts, and what that lacks in the next. What all lack is missing in the result.
pub(super) fn shape_in(
    fonts: &mut [FaceShaper],
    text: &str,
    run: &Run,
    features: &[Feature],
) -> Result<Vec<Cluster>, SettingError> {
    let Some((first, others)) = fonts.split_first_mut() else {
        return Ok(Vec::new());
    };
    let clusters = first.shape(text, run, features)?;
    if others.is_empty() || clusters.iter().all(|c| !c.is_missing) {
        return Ok(clusters);
    }
    let mut shaped = Vec::with_capacity(clusters.len());
    for group in clusters.chunk_by(|a, b| a.is_missing == b.is_missing) {
        let (Some(left), Some(right)) = (group.first(), group.last()) else {
            continue;
        };
        if !left.is_missing {
            shaped.extend_from_slice(group);
            continue;
        }
        let start = left.bytes.start.min(right.bytes.start);
        let end = left.bytes.end.max(right.bytes.end);
        let missing = Run {
            bytes: start..end,
            ..run.clone()
        };
        shaped.extend(shape_in(others, text, &missing, features)?);
    }
    Ok(shaped)
}

impl<'a> FaceShaper<'a> {
    pub fn new(face: &'a FontFace) -> FaceShaper<'a> {
        match face {
            FontFace::Typeface(typeface) => FaceShaper::of(typeface),
            FontFace::Ppf(font, encoding) => FaceShaper::Ppf(font, encoding),
        }
    }

    pub fn of(typeface: &'a Typeface) -> FaceShaper<'a> {
        FaceShaper::Typeface {
            typeface,
            shaper: Box::new(ShaperFont::new(&typeface.file)),
            drawn: HashMap::new(),
        }
    }

    /// Whether the font has a glyph for a character, precomposed or combined.
    pub fn has(&self, character: char) -> bool {
        match self {
            FaceShaper::Typeface { typeface, .. } => typeface.has(character),
            FaceShaper::Ppf(font, encoding) => {
                let name = encoding.names.get(&u32::from(character));
                name.is_some_and(|name| font.glyphs.contains_key(name))
            }
        }
    }

    /// The clusters of a run from left to right.
    fn shape(
        &mut self,
        text: &str,
        run: &Run,
        features: &[Feature],
    ) -> Result<Vec<Cluster>, SettingError> {
        match self {
            FaceShaper::Typeface {
                typeface,
                shaper,
                drawn,
            } => {
                let buffer = shaped(shaper, text, run, features)?;
                let is_off = |f: &Feature| f.tag == Tag::new(b"kern") && f.value == 0;
                let kerns = !features.iter().any(is_off);
                clusters(typeface, &buffer, run, kerns, drawn)
            }
            FaceShaper::Ppf(font, encoding) => glyph_by_glyph(font, encoding, text, run),
        }
    }
}

fn shaped(
    shaper: &ShaperFont,
    text: &str,
    run: &Run,
    features: &[Feature],
) -> Result<Buffer, SettingError> {
    let mut buffer = Buffer::new();
    buffer.set_direction(if run.is_rtl {
        Direction::RightToLeft
    } else {
        Direction::LeftToRight
    });
    let tag = Tag::from_u32(run.script.as_iso15924_tag());
    buffer.set_script(Script::from_iso15924_tag(tag));
    // Letters join across the borders of runs.
    buffer.set_pre_context(&text[..run.bytes.start]);
    for (at, c) in text[run.bytes.clone()].char_indices() {
        buffer.push(u32::from(c), (run.bytes.start + at) as u32);
    }
    buffer.set_post_context(&text[run.bytes.end..]);
    let options = ShapeOptions::new().features(features);
    match shape(shaper, &mut buffer, options) {
        Ok(()) if buffer.allocation_successful() => Ok(buffer),
        Ok(()) => Err(SettingError::Damaged("(layout tables without end)".into())),
        Err(e) => Err(SettingError::Damaged(format!("(layout tables: {e})"))),
    }
}

fn clusters(
    typeface: &Typeface,
    buffer: &Buffer,
    run: &Run,
    kerns: bool,
    drawn: &mut HashMap<GlyphId, Arc<[GlyphLayer]>>,
) -> Result<Vec<Cluster>, SettingError> {
    let em = typeface.em();
    let infos = buffer.glyph_infos();
    let mut starts: Vec<usize> = infos.iter().map(|g| g.cluster as usize).collect();
    starts.push(run.bytes.end);
    starts.sort_unstable();
    let mut clusters: Vec<Cluster> = Vec::new();
    for (k, (info, shift)) in infos.iter().zip(buffer.glyph_positions()).enumerate() {
        let start = info.cluster as usize;
        if clusters.last().is_none_or(|c| c.bytes.start != start) {
            clusters.push(Cluster {
                bytes: start..starts[starts.partition_point(|&s| s <= start)],
                glyphs: Vec::new(),
                advance: 0.0,
                is_missing: false,
            });
        }
        let Some(cluster) = clusters.last_mut() else {
            continue;
        };
        let glyph = GlyphId::new(info.glyph_id);
        cluster.is_missing |= glyph == GlyphId::NOTDEF;
        let offset = DVec2::new(f64::from(shift.x_offset), f64::from(shift.y_offset));
        cluster.glyphs.push(ShapedGlyph {
            layers: layers(typeface, glyph, drawn)?,
            pen: DVec2::new(cluster.advance, 0.0) + em * offset,
        });
        let next = infos.get(k + 1).filter(|_| kerns);
        let next = next.map(|next| GlyphId::new(next.glyph_id));
        let kerning = next.map_or(0.0, |next| typeface.kerning.between(glyph, next));
        cluster.advance += em * f64::from(shift.x_advance) + kerning;
    }
    Ok(clusters)
}

fn layers(
    typeface: &Typeface,
    glyph: GlyphId,
    drawn: &mut HashMap<GlyphId, Arc<[GlyphLayer]>>,
) -> Result<Arc<[GlyphLayer]>, SettingError> {
    if let Some(layers) = drawn.get(&glyph) {
        return Ok(Arc::clone(layers));
    }
    let layers: Arc<[GlyphLayer]> = typeface.layers(glyph)?.into();
    drawn.insert(glyph, Arc::clone(&layers));
    Ok(layers)
}

/// Sets a run as RTRACE does.
fn glyph_by_glyph(
    font: &Font,
    encoding: &Encoding,
    text: &str,
    run: &Run,
) -> Result<Vec<Cluster>, SettingError> {
    let mut clusters = Vec::new();
    let mut at = run.bytes.start;
    while let Some(c) = text[at..run.bytes.end].chars().next() {
        let mut cluster = Cluster {
            bytes: at..at + c.len_utf8(),
            glyphs: Vec::new(),
            advance: 0.0,
            is_missing: false,
        };
        match font.next_glyph(&text[at..run.bytes.end], encoding) {
            Ok(Some((bytes, glyph))) => {
                cluster.bytes.end = at + bytes;
                cluster.advance = glyph.advance;
                cluster.glyphs.push(ShapedGlyph {
                    layers: [GlyphLayer::plain(glyph.figure)].into(),
                    pen: DVec2::ZERO,
                });
            }
            Ok(None) => {}
            Err(TextError::NoGlyph(name)) if c == '/' => {
                return Err(SettingError::Name(TextError::NoGlyph(name)));
            }
            Err(e @ TextError::OpenName(_)) => return Err(SettingError::Name(e)),
            Err(_) => cluster.is_missing = true,
        }
        at = cluster.bytes.end;
        clusters.push(cluster);
    }
    if run.is_rtl {
        clusters.reverse();
    }
    Ok(clusters)
}
