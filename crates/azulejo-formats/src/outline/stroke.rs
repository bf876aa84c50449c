//! Strokes as figures: the inside of what a pen of some width draws.
//!
//! Offsets of curves by kurbo (Levien, *Cleaner parallel curves with Euler spirals*, 2021).

use super::pen::Pen;
use azulejo_scene::{Figure, FillRule};
use kurbo::{BezPath, ParamCurveArclen, Shape, Stroke, StrokeOpts};

/// Largest size of a path and width of its pen: far from overflow.
const LARGEST: f64 = 1e30;

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
pub(crate) enum StrokeProblem {
    /// It has no curve, or an unknown unit, which has been said.
    NoCurve,
    /// Its pen is so thin that its edges are one line in the precision of numbers.
    Vanishes,
    /// Its dashes are too many to be drawn.
    TooManyDashes,
}

/// The figure of the stroke of a path, whose dashes and gaps are `dashes` in turn from `dash_offset` on, an even number;
/// none if it has no gaps.
///
/// # Errors
/// [`StrokeProblem`].
pub(crate) fn stroked(
    path: BezPath,
    pen: &Stroke,
    dashes: &[f64],
    dash_offset: f64,
) -> Result<Figure, StrokeProblem> {
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
    let path = dashed(path, dashes, dash_offset, tolerance)?;
    let edges = kurbo::stroke(path, pen, &StrokeOpts::default(), tolerance);
    let mut pen = Pen::default();
    pen.trace(edges);
    let figure = pen.finish(FillRule::NonZero);
    if figure.contours.is_empty() {
        return Err(StrokeProblem::NoCurve);
    }
    Ok(figure)
}

/// The dashes of a path.
fn dashed(
    path: BezPath,
    dashes: &[f64],
    offset: f64,
    accuracy: f64,
) -> Result<BezPath, StrokeProblem> {
    let period: f64 = dashes.iter().sum();
    if !(period > 0.0 && period.is_finite()) {
        return Ok(path);
    }
    let length: f64 = path.segments().map(|s| s.arclen(accuracy)).sum();
    let count = dashes.len() as f64 * (length + offset.abs()) / period;
    if count > MOST_DASHES {
        return Err(StrokeProblem::TooManyDashes);
    }
    Ok(kurbo::dash(path.into_iter(), offset, dashes).collect())
}
