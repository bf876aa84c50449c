//! The path of a shape, to be stroked.

use super::values::{LengthUnits, numbers};
use azulejo_scene::Figure;
use azulejo_scene::figure::Segment;
use glam::DVec2;
use kurbo::{BezPath, Point};
use roxmltree::Node;
use svgtypes::{SimplePathSegment, SimplifyingPathParser};

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
