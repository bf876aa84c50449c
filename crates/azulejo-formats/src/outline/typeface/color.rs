//! Glyphs of several colours: the layers of OpenType's COLR tables, of both versions.
//!
//! Source: OpenType 1.9.1, *COLR – Color Table* and *CPAL – Color Palette Table*; the first palette is used. Layers are
//! opaque and of one colour each, as they become solids: see [`ColorLoss`]. No colour reflects more than 90%.

use super::convert::map_points;
use super::face::{SettingError, Typeface};
use crate::picture::srgb::linear_from_srgb_f64;
use azulejo_scene::figure::Rectangle;
use azulejo_scene::{Figure, Rgb};
use glam::{DAffine2, DVec2};
use read_fonts::TableProvider;
use read_fonts::model::glyph::color::{Brush, Color, ColorStop, CompositeMode, PaintSink};
use read_fonts::types::{BoundingBox, GlyphId, Matrix};
use std::fmt;
use std::sync::Arc;

/// Most curves of all layers of a glyph: layers may repeat an outline without end.
const MOST_CURVES: usize = 1 << 17;

/// Stands for the colour of the text in palettes.
const FOREGROUND: u16 = 0xffff;

/// Largest reflectance: the white of a screen would return all light, for ever between two such surfaces.
const WHITEST: f64 = 0.9;

/// What is less opaque than this is left out: a shade that is painted over a drawing would hide it.
const OPAQUE: f64 = 0.5;

/// Points by which the base of a layer is found, and how far inside of it they are, ems.
const POINTS: usize = 64;
const INSIDE: f64 = 1e-3;

/// Most tests of a point with a curve for one glyph, about a tenth of a second's work.
const MOST_TESTS: usize = 4_000_000;

/// One layer of a glyph.
#[derive(Clone, Debug)]
pub(super) struct GlyphLayer {
    /// Its outline, ems.
    pub figure: Arc<Figure>,
    /// Its colour, linear; `None` if it is that of the text.
    pub color: Option<Rgb>,
    /// The layer on which it lies; `None` if it reaches beyond all layers below.
    pub base: Option<u32>,
    /// What was lost of its paint.
    pub losses: Vec<ColorLoss>,
}

/// What solids in one colour each cannot show of a glyph in colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ColorLoss {
    /// Gradients have their mean colour.
    Gradient,
    /// What is partly transparent is opaque, what is mostly transparent is left out.
    Transparency,
    /// Outlines that are clipped by others are whole.
    Clip,
    /// Layers that are blended or cut out of others are painted over them.
    Blending,
    /// Glyphs that are drawings in SVG are plain outlines.
    Svg,
}

impl fmt::Display for ColorLoss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ColorLoss::Gradient => "gradients have their mean colour",
            ColorLoss::Transparency => {
                "what is partly transparent is opaque, or left out if it is mostly transparent"
            }
            ColorLoss::Clip => "outlines that are clipped by others are whole",
            ColorLoss::Blending => "layers that are blended with others are painted over them",
            ColorLoss::Svg => {
                "those drawn in SVG are plain outlines; only those of COLR tables have colours"
            }
        })
    }
}

impl GlyphLayer {
    /// An outline in the colour of the text.
    pub fn plain(figure: Arc<Figure>) -> GlyphLayer {
        GlyphLayer {
            figure,
            color: None,
            base: None,
            losses: Vec::new(),
        }
    }
}

impl Typeface {
    /// The layers of a glyph in the order in which they are painted; a single one if it has no colours of its own.
    pub(super) fn layers(&self, glyph: GlyphId) -> Result<Vec<GlyphLayer>, SettingError> {
        let Some(painted) = self.file.color_glyphs().get(glyph) else {
            let mut layer = GlyphLayer::plain(Arc::new(self.figure(glyph)?));
            let drawings = self.file.tables().svg();
            if drawings.is_ok_and(|d| d.glyph_data(glyph).is_some()) {
                layer.losses.push(ColorLoss::Svg);
            }
            return Ok(vec![layer]);
        };
        let palette = self.file.palettes().get(0);
        let mut painter = LayerPainter {
            typeface: self,
            palette: palette.map(|p| p.colors()).unwrap_or_default(),
            maps: vec![DAffine2::IDENTITY],
            clips: Vec::new(),
            blending: Vec::new(),
            layers: Vec::new(),
            left_out: false,
            curves: 0,
            error: None,
        };
        let outcome = painted.paint(&mut painter);
        match (outcome, painter.error) {
            (_, Some(error)) => Err(error),
            (Err(e), None) => Err(SettingError::Damaged(format!(
                "{} (colours: {e})",
                self.name_of(glyph)
            ))),
            (Ok(()), None) => {
                let mut layers = painter.layers;
                find_bases(&mut layers);
                if let Some(last) = layers.last_mut().filter(|_| painter.left_out) {
                    last.losses.push(ColorLoss::Transparency);
                }
                Ok(layers)
            }
        }
    }
}

/// Finds on which layer each one lies: of those that are on top at its points, the lowest.
fn find_bases(layers: &mut [GlyphLayer]) {
    let bounds: Vec<Rectangle> = layers.iter().map(|l| l.figure.bounds()).collect();
    let mut left = MOST_TESTS;
    for k in 1..layers.len() {
        let (below, above) = layers.split_at_mut(k);
        let mut top = |point: DVec2| {
            (0..k).rev().find(|&j| {
                let figure = &below[j].figure;
                let is_near = point.cmpge(bounds[j].min).all() && point.cmple(bounds[j].max).all();
                left = left.saturating_sub(if is_near { figure.curve_count() } else { 0 });
                is_near && left > 0 && figure.contains(point)
            })
        };
        let tops = inner_points(&above[0].figure).map(&mut top);
        // Nothing is below a point where nothing is on top.
        let base = tops.reduce(Option::min).flatten();
        above[0].base = base.map(|j| j as u32);
    }
}

/// Points a little inside of the outline of a figure.
fn inner_points(figure: &Figure) -> impl Iterator<Item = DVec2> + '_ {
    let step = figure.curve_count().div_ceil(POINTS).max(1);
    figure.segments().step_by(step).filter_map(|segment| {
        let aside = INSIDE * segment.derivative(0.5).try_normalize()?.perp();
        let middle = segment.at(0.5);
        let sides = [middle + aside, middle - aside];
        sides.into_iter().find(|side| figure.contains(*side))
    })
}

/// Collects what is filled.
struct LayerPainter<'a> {
    typeface: &'a Typeface,
    palette: &'a [Color],
    /// The product of the open transforms, after each of them, in ems.
    maps: Vec<DAffine2>,
    /// The open clips.
    clips: Vec<PaintClip>,
    /// Whether each of the open groups is blended.
    blending: Vec<bool>,
    layers: Vec<GlyphLayer>,
    /// Whether a layer was left out, as it is mostly transparent.
    left_out: bool,
    /// Curves drawn so far.
    curves: usize,
    error: Option<SettingError>,
}

/// What confines a fill.
enum PaintClip {
    Outline(Arc<Figure>),
    Rectangle(Arc<Figure>),
}

impl LayerPainter<'_> {
    fn map(&self) -> DAffine2 {
        self.maps.last().copied().unwrap_or_default()
    }

    /// The outline of a glyph under the current transform.
    fn outline(&mut self, glyph: GlyphId) -> Result<Figure, SettingError> {
        let mut figure = self.typeface.figure(glyph)?;
        self.curves += figure.curve_count();
        if self.curves > MOST_CURVES {
            let name = self.typeface.name_of(glyph);
            let found = format!("{name} (more than {MOST_CURVES} curves in layers)");
            return Err(SettingError::Damaged(found));
        }
        let map = self.map();
        map_points(&mut figure, |p| map.transform_point2(p));
        if figure.segments().all(|s| s.start().is_finite()) {
            Ok(figure)
        } else {
            Err(SettingError::Damaged(self.typeface.name_of(glyph)))
        }
    }

    /// The colour of a palette and its opacity; the text's own is opaque.
    fn color(&self, index: u16, alpha: f32) -> (Option<Rgb>, f64) {
        let alpha = f64::from(alpha);
        let own = self.palette.get(usize::from(index));
        match own.filter(|_| index != FOREGROUND) {
            Some(own) => {
                let parts = [own.red, own.green, own.blue];
                let linear = parts.map(|part| linear_from_srgb_f64(f64::from(part) / 255.0));
                let color = Rgb::from(linear).map(|part| part.min(WHITEST));
                (Some(color), alpha * f64::from(own.alpha) / 255.0)
            }
            None => (None, alpha),
        }
    }

    /// The mean colour and opacity of a gradient from 0 to 1. Stops in the colour of the text count only if all are.
    fn mean(&self, stops: &[ColorStop]) -> (Option<Rgb>, f64) {
        let (mut sum, mut colored, mut opacity, mut whole) = (Rgb::BLACK, 0.0, 0.0, 0.0);
        for (k, stop) in stops.iter().enumerate() {
            // Colours are linear between stops, and constant before the first and behind the last.
            let before = k
                .checked_sub(1)
                .map_or(0.0, |b| middle(stops[b].offset, stop.offset));
            let behind = stops
                .get(k + 1)
                .map_or(1.0, |b| middle(stop.offset, b.offset));
            let share = (behind - before).max(0.0);
            let (color, alpha) = self.color(stop.palette_index, stop.alpha);
            opacity += share * alpha;
            whole += share;
            if let Some(color) = color {
                sum += share * color;
                colored += share;
            }
        }
        let mean = (colored > 0.0).then(|| (1.0 / colored) * sum);
        (mean, if whole > 0.0 { opacity / whole } else { 1.0 })
    }
}

fn middle(a: f32, b: f32) -> f64 {
    0.5 * (f64::from(a) + f64::from(b))
}

impl PaintSink for LayerPainter<'_> {
    fn push_transform(&mut self, m: Matrix<f32>) {
        let em = self.typeface.em();
        let [xx, yx, xy, yy, dx, dy] = [m.xx, m.yx, m.xy, m.yy, m.dx, m.dy].map(f64::from);
        let inner = DAffine2::from_cols_array(&[xx, yx, xy, yy, em * dx, em * dy]);
        self.maps.push(self.map() * inner);
    }

    fn pop_transform(&mut self) {
        self.maps.pop();
    }

    fn push_clip_glyph(&mut self, glyph: GlyphId) {
        let outline = match self.outline(glyph) {
            Ok(outline) => outline,
            Err(e) => {
                self.error.get_or_insert(e);
                Figure::default()
            }
        };
        self.clips.push(PaintClip::Outline(Arc::new(outline)));
    }

    fn push_clip_box(&mut self, b: BoundingBox<f32>) {
        let corners = [
            (b.x_min, b.y_min),
            (b.x_max, b.y_min),
            (b.x_max, b.y_max),
            (b.x_min, b.y_max),
        ];
        let em = self.typeface.em();
        let place = |(x, y): (f32, f32)| {
            let corner = em * DVec2::new(f64::from(x), f64::from(y));
            self.map().transform_point2(corner)
        };
        let rectangle = Figure::polygon(corners.map(place));
        self.clips.push(PaintClip::Rectangle(Arc::new(rectangle)));
    }

    fn pop_clip(&mut self) {
        self.clips.pop();
    }

    fn fill(&mut self, brush: Brush<'_>) {
        let mut losses = Vec::new();
        let (color, alpha) = match brush {
            Brush::Solid {
                palette_index,
                alpha,
            } => self.color(palette_index, alpha),
            Brush::LinearGradient { color_stops, .. }
            | Brush::RadialGradient { color_stops, .. }
            | Brush::SweepGradient { color_stops, .. } => {
                losses.push(ColorLoss::Gradient);
                self.mean(color_stops)
            }
        };
        if alpha <= 0.0 || alpha.is_nan() {
            return;
        }
        if alpha < 1.0 {
            losses.push(ColorLoss::Transparency);
        }
        if alpha < OPAQUE {
            self.left_out = true;
            return;
        }
        if self.blending.contains(&true) {
            losses.push(ColorLoss::Blending);
        }
        let outlines = self
            .clips
            .iter()
            .filter(|c| matches!(c, PaintClip::Outline(_)));
        let outlines: Vec<&PaintClip> = outlines.collect();
        if outlines.len() > 1 {
            losses.push(ColorLoss::Clip);
        }
        // Boxes around glyphs hold what is drawn anyway, unless nothing else is there.
        let innermost = outlines.last().copied().or(self.clips.last());
        let Some(PaintClip::Outline(figure) | PaintClip::Rectangle(figure)) = innermost else {
            return;
        };
        if !figure.contours.is_empty() {
            self.layers.push(GlyphLayer {
                figure: Arc::clone(figure),
                color,
                base: None,
                losses,
            });
        }
    }

    fn push_layer(&mut self, mode: CompositeMode) {
        self.blending.push(mode != CompositeMode::SrcOver);
    }

    fn pop_layer(&mut self) {
        self.blending.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_lie_on_what_is_on_top_below_all_of_them() {
        let square = |x: f64, y: f64, side: f64| {
            let corners = [(x, y), (x + side, y), (x + side, y + side), (x, y + side)];
            GlyphLayer::plain(Arc::new(Figure::polygon(corners.map(DVec2::from))))
        };
        let bases = |mut layers: Vec<GlyphLayer>| -> Vec<Option<u32>> {
            find_bases(&mut layers);
            layers.iter().map(|l| l.base).collect()
        };
        let face = square(0.0, 0.0, 1.0);
        let eye = square(0.2, 0.6, 0.2);
        assert_eq!(bases(vec![]), []);
        let pupil = square(0.25, 0.65, 0.1);
        let painted = vec![face.clone(), eye.clone(), pupil];
        assert_eq!(bases(painted), [None, Some(0), Some(1)]);
        // Half on the eye and half on the face, with an edge in common, and half on nothing.
        let lid = square(0.2, 0.7, 0.2);
        assert_eq!(
            bases(vec![face.clone(), eye, lid]),
            [None, Some(0), Some(0)]
        );
        let hat = square(0.2, 0.9, 0.4);
        assert_eq!(bases(vec![face.clone(), hat]), [None, None]);
        // The same outline again is on itself.
        assert_eq!(bases(vec![face.clone(), face]), [None, Some(0)]);
    }
}
