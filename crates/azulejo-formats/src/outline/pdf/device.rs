//! Receives what a page draws.

use crate::outline::clip::Clip;
use crate::outline::drawing::Filled;
use crate::outline::pen::Pen;
use crate::outline::stroke::{StrokeProblem, stroked};
use crate::picture::srgb::linear_from_srgb_f64;
use crate::reading::options::Budget;
use crate::reading::warnings::Warnings;
use crate::{ReadError, ReadOptions, Warning};
use azulejo_scene::{Figure, FillRule, Rgb};
use glam::DVec2;
use hayro_interpret::font::{Glyph, GlyphRun};
use hayro_interpret::{
    BlendMode, ClipPath, Device, DrawMode, DrawProps, Image, ImageDrawProps, Paint, SoftMask,
    StrokeProps,
};
use kurbo::{Affine, BezPath, Join, PathEl, Point, Size, Stroke};
use std::cell::Cell;
use std::panic::resume_unwind;
use std::rc::Rc;
use std::time::Duration;
#[cfg(not(target_family = "wasm"))]
use std::time::Instant;

/// Deepest nesting of letters that are drawings with letters (Type 3); deeper ones are left out, and thereby those that
/// contain themselves.
const DEEPEST_LETTERS: u32 = 8;

/// Larger coordinates are damage, and their squares could overflow.
const LARGEST: f64 = 1e30;

/// What hayro adds to the x of a point that is the one before it.
const STEP: f64 = 0.0001;

pub(super) const TRANSLUCENT: &str = "transparency, mask or blend mode: drawn opaque";

/// What unwinds through hayro when a limit is reached.
pub(super) struct Stopped;

/// The drawing under construction.
pub(super) struct PdfDevice<'s> {
    name: &'s str,
    warnings: Warnings,
    budget: Budget,
    shapes: Vec<Filled>,
    images: usize,
    /// The drawing from the device.
    map: Affine,
    /// What all of these are inside of, from the outermost on: each is inside those before it.
    clips: Vec<Rc<Clip>>,
    /// Whether each of the groups around is invisible.
    hidden: Vec<bool>,
    letter_depth: u32,
    #[cfg(not(target_family = "wasm"))]
    deadline: Instant,
    longest: Duration,
    stopped: &'s Cell<Option<ReadError>>,
}

impl<'s> PdfDevice<'s> {
    /// A device of so many pixels per unit, for a page of that size. It unwinds with [`Stopped`] after `longest`, or if
    /// the page expands to more than `options` allow, and leaves the error in `stopped`.
    pub fn new(
        name: &'s str,
        options: &ReadOptions,
        longest: Duration,
        size: Size,
        pixels: f64,
        stopped: &'s Cell<Option<ReadError>>,
    ) -> PdfDevice<'s> {
        let corner = DVec2::new(size.width, size.height);
        let page = Figure::polygon([
            DVec2::ZERO,
            DVec2::new(corner.x, 0.0),
            corner,
            DVec2::new(0.0, corner.y),
        ]);
        PdfDevice {
            name,
            warnings: Warnings::default(),
            budget: Budget::new(options),
            shapes: Vec::new(),
            images: 0,
            map: Affine::scale(pixels.recip()),
            clips: vec![Clip::new(page, None)],
            hidden: Vec::new(),
            letter_depth: 0,
            #[cfg(not(target_family = "wasm"))]
            deadline: Instant::now() + longest,
            longest,
            stopped,
        }
    }

    pub fn warn(&mut self, message: impl Into<String>) {
        self.warnings.add_whole(self.name, message);
    }

    /// The shapes, the number of pictures left out, and all warnings.
    pub fn finish(self) -> (Vec<Filled>, usize, Vec<Warning>) {
        (self.shapes, self.images, self.warnings.finish(self.name))
    }

    fn stop(&self, error: ReadError) -> ! {
        self.stopped.set(Some(error));
        resume_unwind(Box::new(Stopped))
    }

    /// Counts what is drawn, and the time.
    fn spend(&mut self, elements: usize) {
        if let Err(exhausted) = self.budget.spend(elements as u64) {
            self.stop(exhausted.error(self.name));
        }
        // The web has no such clock.
        #[cfg(not(target_family = "wasm"))]
        if Instant::now() > self.deadline {
            let found = format!("a page that takes longer than {:?}", self.longest);
            self.stop(ReadError::whole(self.name, found, "a simpler page"));
        }
    }

    /// What everything is inside of.
    fn clip(&self) -> Rc<Clip> {
        let innermost = self.clips.last();
        innermost.expect("the page is never popped").clone()
    }

    /// Adds what of a figure is inside the clip; `map` leads from its coordinates to the device.
    fn add(&mut self, mut figure: Figure, map: Affine, color: Option<Rgb>, clip: &Clip) {
        if !self.budget.keeps() || figure.contours.is_empty() {
            return;
        }
        let map = self.map * map;
        figure.move_points(|p| {
            let p = map * Point::new(p.x, p.y);
            DVec2::new(p.x, p.y)
        });
        if !is_usable(&figure) {
            self.warn("shape whose coordinates overflow: left out");
            return;
        }
        let figure = clip.clipped(figure);
        if figure.contours.is_empty() {
            return;
        }
        if color.is_none() {
            self.warn("paint that is not a single colour: not kept");
        }
        self.shapes.push(Filled {
            figure,
            color,
            name: String::new(),
        });
    }

    fn draw(&mut self, path: &BezPath, props: &DrawProps, mode: &DrawMode) {
        let clip = self.clip();
        self.spend(1 + path.elements().len() + clip.cost() as usize);
        let Some(color) = self.color(props) else {
            return;
        };
        let (rule, pen) = match mode {
            DrawMode::Fill(rule) => (Some(rule), None),
            DrawMode::Stroke(pen) => (None, Some(pen)),
            DrawMode::FillAndStroke(rule, pen) => (Some(rule), Some(pen)),
            DrawMode::Invisible => return,
        };
        if let Some(rule) = rule {
            let figure = filled(without_steps(path), *rule);
            self.add(figure, props.transform, color, &clip);
        }
        if let Some(stroke) = pen.and_then(|pen| self.stroke(path, props.transform, pen)) {
            self.spend(stroke.curve_count());
            self.add(stroke, props.transform, color, &clip);
        }
    }

    /// The colour of a shape, if it has a single one; `None` if it is not seen at all.
    fn color(&mut self, props: &DrawProps) -> Option<Option<Rgb>> {
        if self.hidden.contains(&true) {
            return None;
        }
        let is_plain = props.soft_mask.is_none() && props.blend_mode == BlendMode::Normal;
        let (color, alpha) = match &props.paint {
            Paint::Color(color) => {
                let [red, green, blue, alpha] = color.to_rgba().components();
                let linear = [red, green, blue].map(|part| linear_from_srgb_f64(f64::from(part)));
                (Some(Rgb::from(linear)), alpha)
            }
            Paint::Pattern(_) => (None, 1.0),
        };
        if alpha > 0.0 && !(is_plain && alpha >= 1.0) {
            self.warn(TRANSLUCENT);
        }
        (alpha > 0.0).then_some(color)
    }

    /// The figure of a stroke, in the coordinates of its path, from which `map` leads to the device.
    fn stroke(&mut self, path: &BezPath, map: Affine, props: &StrokeProps) -> Option<Figure> {
        let pen = Stroke::new(f64::from(props.line_width))
            .with_join(props.line_join)
            .with_caps(props.line_cap)
            .with_miter_limit(f64::from(props.miter_limit).max(1.0));
        let mut dashes: Vec<f64> = props.dash_array.iter().copied().map(f64::from).collect();
        if !dashes.iter().all(|dash| *dash >= 0.0) {
            dashes.clear();
        }
        // Gaps and dashes swap roles each time.
        if !dashes.len().is_multiple_of(2) {
            dashes = dashes.repeat(2);
        }
        let [xx, xy, yx, yy, ..] = map.as_coeffs();
        let pixels = pen.width * xx.hypot(xy).max(yx.hypot(yy));
        if props.line_join == Join::Bevel && (pixels - 1.0).abs() < 1e-3 {
            // hayro's line for a filled shape without an area.
            return None;
        }
        let is_usable = pen.width > 0.0 && path.is_finite() && props.dash_offset.is_finite();
        let offset = f64::from(props.dash_offset);
        let stroke = if is_usable {
            stroked(path.clone(), &pen, &dashes, offset)
        } else {
            Err(StrokeProblem::Vanishes)
        };
        match stroke {
            Ok(figure) => Some(figure),
            Err(StrokeProblem::NoCurve) => None,
            Err(StrokeProblem::Vanishes) => {
                self.warn("line without a width, or too thin to be seen: left out");
                None
            }
            Err(StrokeProblem::TooManyDashes) => {
                self.warn("line of too many dashes: left out");
                None
            }
        }
    }
}

impl<'a> Device<'a> for PdfDevice<'_> {
    fn draw_path(&mut self, path: &BezPath, props: DrawProps<'a>, mode: &DrawMode) {
        self.draw(path, &props, mode);
    }

    fn push_clip_path(&mut self, clip: &ClipPath) {
        let outer = self.clip();
        self.spend(1 + clip.path.elements().len() + outer.cost() as usize);
        let path = self.map * &clip.path;
        let mut figure = filled(path, clip.fill);
        if !is_usable(&figure) {
            self.warn("clip path whose coordinates overflow: nothing is inside");
            figure = Figure::default();
        }
        // One figure, however many clip paths are one inside the other.
        self.clips.push(Clip::new(outer.clipped(figure), None));
    }

    fn pop_clip(&mut self) {
        if self.clips.len() > 1 {
            self.clips.pop();
        }
    }

    fn push_transparency_group(
        &mut self,
        opacity: f32,
        mask: Option<SoftMask<'a>>,
        blend_mode: BlendMode,
    ) {
        self.spend(1);
        let is_hidden = opacity <= 0.0;
        let is_plain = opacity >= 1.0 && mask.is_none() && blend_mode == BlendMode::Normal;
        if !is_hidden && !is_plain {
            self.warn(TRANSLUCENT);
        }
        self.hidden.push(is_hidden);
    }

    fn pop_transparency_group(&mut self) {
        self.hidden.pop();
    }

    fn draw_glyph_run(&mut self, run: &GlyphRun<'_, 'a>, props: DrawProps<'a>, mode: &DrawMode) {
        // One shape for all outlines that are shown together.
        let mut path = BezPath::new();
        for glyph in run.glyphs() {
            match &**glyph {
                Glyph::Outline(letter) => {
                    let outline = letter.outline();
                    self.spend(1 + outline.elements().len());
                    path.extend(glyph.transform() * outline);
                }
                Glyph::Type3(_) if matches!(mode, DrawMode::Invisible) => self.spend(1),
                Glyph::Type3(_) if self.letter_depth == DEEPEST_LETTERS => {
                    self.spend(1);
                    self.warn(format!(
                        "letters nested more than {DEEPEST_LETTERS} deep: left out"
                    ));
                }
                Glyph::Type3(letter) => {
                    self.spend(1);
                    self.letter_depth += 1;
                    letter.interpret(self, props.transform, glyph.transform(), &props.paint);
                    self.letter_depth -= 1;
                }
            }
        }
        if !path.elements().is_empty() {
            self.draw(&path, &props, mode);
        }
    }

    fn draw_image(&mut self, _: Image<'a, '_>, _: ImageDrawProps<'a>) {
        self.spend(1);
        if !self.hidden.contains(&true) {
            self.images += 1;
            self.warn("picture: left out");
        }
    }
}

fn filled(path: BezPath, rule: hayro_interpret::FillRule) -> Figure {
    let mut pen = Pen::default();
    pen.trace(path);
    pen.finish(match rule {
        hayro_interpret::FillRule::NonZero => FillRule::NonZero,
        hayro_interpret::FillRule::EvenOdd => FillRule::EvenOdd,
    })
}

/// Whether all points of a figure are finite and not too far away.
fn is_usable(figure: &Figure) -> bool {
    let near = |p: DVec2| p.abs().max_element() <= LARGEST && p.is_finite();
    let bounds = figure.bounds();
    figure.contours.is_empty()
        || (near(bounds.min) && near(bounds.max) && figure.segments().all(|s| near(s.start())))
}

/// A path without the short lines that hayro draws from a point to itself, so that pens leave a dot there: the points
/// that follow are where the file has them.
fn without_steps(path: &BezPath) -> BezPath {
    let mut at = Point::ORIGIN;
    let is_drawn = |element: &&PathEl| {
        if let PathEl::LineTo(to) = element
            && *to == Point::new(at.x + STEP, at.y)
        {
            return false;
        }
        at = element.end_point().unwrap_or(at);
        true
    };
    path.elements().iter().filter(is_drawn).copied().collect()
}
