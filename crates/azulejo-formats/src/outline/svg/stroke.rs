//! Strokes as figures: the inside of what a pen of some width draws.
//!
//! Offsets of curves by kurbo (Levien, *Cleaner parallel curves with Euler spirals*, 2021).

use super::style::StrokeStyle;
use super::values::{LARGEST, LengthUnits, numbers};
use crate::outline::pen::Pen;
use azulejo_scene::figure::Segment;
use azulejo_scene::{Figure, FillRule};
use glam::DVec2;
use kurbo::{BezPath, ParamCurveArclen, PathEl, Point, Shape, Stroke, StrokeOpts};
use roxmltree::Node;
use svgtypes::{SimplePathSegment, SimplifyingPathParser};

/// Thinnest pen, as a share of the largest coordinate: single precision, in which most models are stored.
const THINNEST: f64 = 1e-7;

/// How far the edges of a stroke may be off, as a share of its width.
const TOLERANCE: f64 = 1e-3;

/// The same as a share of the size of the shape, below which edges are not divided further.
const FINEST: f64 = 1e-7;

/// Most dashes of a stroke.
const MOST_DASHES: f64 = 20_000.0;

/// Why a shape has no stroke.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StrokeProblem {
    /// It has no curve, or an unknown unit, which has been said.
    NoCurve,
    /// Its pen is so thin that its edges are one line in the precision of numbers.
    Vanishes,
    /// Its dashes are too many to be drawn.
    TooManyDashes,
}

/// The figure of the stroke of a shape, whose outline `figure` is, in its own coordinates.
///
/// # Errors
/// [`StrokeProblem`].
pub(super) fn stroked(
    element: Node,
    figure: &Figure,
    style: &StrokeStyle,
    pen: &Stroke,
    units: &LengthUnits,
) -> Result<Figure, StrokeProblem> {
    let path = path(element, figure, units).ok_or(StrokeProblem::NoCurve)?;
    let bounds = path.bounding_box();
    let size = bounds.width().max(bounds.height());
    let is_usable = size.is_finite() && size.max(pen.width) < LARGEST;
    if path.elements().len() < 2 || !is_usable {
        return Err(StrokeProblem::NoCurve);
    }
    let farthest = [bounds.x0, bounds.x1, bounds.y0, bounds.y1].map(f64::abs);
    if pen.width <= THINNEST * farthest.into_iter().fold(0.0, f64::max) {
        return Err(StrokeProblem::Vanishes);
    }
    let tolerance = (TOLERANCE * pen.width).max(FINEST * size);
    let path = dashed(path, style, tolerance)?;
    let edges = kurbo::stroke(path, pen, &StrokeOpts::default(), tolerance);
    let place = |p: Point| DVec2::new(p.x, p.y);
    let mut pen = Pen::default();
    for edge in edges {
        match edge {
            PathEl::MoveTo(to) => pen.move_to(place(to)),
            PathEl::LineTo(to) => pen.line_to(place(to)),
            PathEl::QuadTo(control, to) => pen.quadratic_to(place(control), place(to)),
            PathEl::CurveTo(a, b, to) => pen.cubic_to(place(a), place(b), place(to)),
            PathEl::ClosePath => _ = pen.close(),
        }
    }
    let figure = pen.finish(FillRule::NonZero);
    if figure.contours.is_empty() {
        return Err(StrokeProblem::NoCurve);
    }
    Ok(figure)
}

/// The dashes of a path.
fn dashed(path: BezPath, style: &StrokeStyle, accuracy: f64) -> Result<BezPath, StrokeProblem> {
    let period: f64 = style.dashes.iter().sum();
    if !(period > 0.0 && period.is_finite()) {
        return Ok(path);
    }
    let length: f64 = path.segments().map(|s| s.arclen(accuracy)).sum();
    let count = style.dashes.len() as f64 * (length + style.dash_offset.abs()) / period;
    if count > MOST_DASHES {
        return Err(StrokeProblem::TooManyDashes);
    }
    let offset = style.dash_offset;
    Ok(kurbo::dash(path.into_iter(), offset, &style.dashes).collect())
}

/// The path of a shape: what is open stays so.
pub(super) fn path(element: Node, figure: &Figure, units: &LengthUnits) -> Option<BezPath> {
    let mut path = BezPath::new();
    match element.tag_name().name() {
        "path" => {
            let data = element.attribute("d").unwrap_or("");
            // Up to an error, as it is filled.
            for segment in SimplifyingPathParser::from(data).map_while(Result::ok) {
                match segment {
                    SimplePathSegment::MoveTo { x, y } => path.move_to((x, y)),
                    SimplePathSegment::LineTo { x, y } => path.line_to((x, y)),
                    SimplePathSegment::Quadratic { x1, y1, x, y } => path.quad_to((x1, y1), (x, y)),
                    SimplePathSegment::CurveTo {
                        x1,
                        y1,
                        x2,
                        y2,
                        x,
                        y,
                    } => path.curve_to((x1, y1), (x2, y2), (x, y)),
                    SimplePathSegment::ClosePath => path.close_path(),
                }
            }
        }
        "line" => {
            let value = |name: &str| units.of(element, name);
            path.move_to((value("x1")?, value("y1")?));
            path.line_to((value("x2")?, value("y2")?));
        }
        "polyline" => {
            let (coordinates, _) = numbers(element.attribute("points").unwrap_or(""));
            for (k, [x, y]) in coordinates.as_chunks().0.iter().copied().enumerate() {
                match k {
                    0 => path.move_to((x, y)),
                    _ => path.line_to((x, y)),
                }
            }
        }
        _ => {
            for contour in &figure.contours {
                for (k, segment) in contour.segments().enumerate() {
                    let point = |p: DVec2| Point::new(p.x, p.y);
                    if k == 0 {
                        path.move_to(point(segment.start()));
                    }
                    match segment {
                        Segment::Line([_, to]) => path.line_to(point(to)),
                        Segment::Cubic([_, a, b, to]) => {
                            path.curve_to(point(a), point(b), point(to))
                        }
                    }
                }
                path.close_path();
            }
        }
    }
    Some(path)
}
