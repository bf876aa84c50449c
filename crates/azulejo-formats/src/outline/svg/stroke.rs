//! Strokes as figures: the inside of what a pen of some width draws.
//!
//! Offsets of curves by kurbo (Levien, *Cleaner parallel curves with Euler spirals*, 2021).

use super::values::{LARGEST, length, numbers};
use crate::outline::pen::Pen;
use azulejo_scene::figure::Segment;
use azulejo_scene::{Figure, FillRule};
use glam::DVec2;
use kurbo::{BezPath, PathEl, Point, Shape, Stroke, StrokeOpts};
use roxmltree::Node;
use svgtypes::{SimplePathSegment, SimplifyingPathParser};

/// How far the edges of a stroke may be off, as a share of its width.
const TOLERANCE: f64 = 1e-3;

/// The same as a share of the size of the shape, below which edges are not divided further.
const FINEST: f64 = 1e-7;

/// The figure of the stroke of a shape, whose outline `figure` is, in its own coordinates. `None` if it has none: an
/// unknown unit, no curve, or coordinates beyond all measure.
pub(super) fn stroked(element: Node, figure: &Figure, stroke: &Stroke) -> Option<Figure> {
    let path = path(element, figure)?;
    let bounds = path.bounding_box();
    let size = bounds.width().max(bounds.height());
    let is_usable = size.is_finite() && size.max(stroke.width) < LARGEST;
    if path.elements().len() < 2 || !is_usable {
        return None;
    }
    let tolerance = (TOLERANCE * stroke.width).max(FINEST * size);
    let edges = kurbo::stroke(path, stroke, &StrokeOpts::default(), tolerance);
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
    Some(pen.finish(FillRule::NonZero)).filter(|figure| !figure.contours.is_empty())
}

/// The path of a shape: what is open stays so.
pub(super) fn path(element: Node, figure: &Figure) -> Option<BezPath> {
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
            let value = |name: &str| {
                element
                    .attribute(name)
                    .map_or(Some(0.0), |t| Some(length(t)?.0))
            };
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
