//! Path data: the `d` attribute of a path.

use super::values::LARGEST;
use crate::outline::pen::{Ellipse, Pen};
use glam::DVec2;
use std::f64::consts::{PI, TAU};
use svgtypes::{PathParser, PathSegment};

/// The problems found in path data.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PathProblems {
    /// Number of contours that neither return to their start nor are closed by Z.
    pub open: usize,
    /// Whether it contains an error: only what precedes the error is drawn.
    pub is_cut: bool,
}

/// Draws path data up to the first error, as SVG 2 requires (9.5.4).
pub(super) fn draw(data: &str, pen: &mut Pen) -> PathProblems {
    let mut path = Path {
        pen,
        last: PreviousCurve::Other,
        open: 0,
    };
    let is_whole = PathParser::from(data)
        .try_for_each(|segment| path.segment(segment.ok()?))
        .is_some();
    path.end_contour();
    PathProblems {
        open: path.open,
        is_cut: !is_whole,
    }
}

struct Path<'p> {
    pen: &'p mut Pen,
    last: PreviousCurve,
    open: usize,
}

/// The control point that a following smooth curve mirrors.
#[derive(Clone, Copy)]
enum PreviousCurve {
    Cubic(DVec2),
    Quadratic(DVec2),
    Other,
}

impl PreviousCurve {
    /// The first control point of a smooth cubic curve from `at`.
    fn cubic(self, at: DVec2) -> DVec2 {
        match self {
            PreviousCurve::Cubic(control) => 2.0 * at - control,
            PreviousCurve::Quadratic(_) | PreviousCurve::Other => at,
        }
    }

    /// The control point of a smooth quadratic curve from `at`.
    fn quadratic(self, at: DVec2) -> DVec2 {
        match self {
            PreviousCurve::Quadratic(control) => 2.0 * at - control,
            PreviousCurve::Cubic(_) | PreviousCurve::Other => at,
        }
    }
}

impl Path<'_> {
    /// Draws a segment; `None` if a coordinate is too large.
    fn segment(&mut self, segment: PathSegment) -> Option<()> {
        // Relative coordinates start at the pen, for horizontal and vertical lines, too.
        let at = self.pen.at();
        let base = if segment.is_abs() { DVec2::ZERO } else { at };
        let point = |x: f64, y: f64| {
            let offset = DVec2::new(x, y);
            (offset.abs().max_element() <= LARGEST).then_some(base + offset)
        };
        // Only a curve leaves a control point, and only a smooth curve directly after it mirrors that.
        let last = std::mem::replace(&mut self.last, PreviousCurve::Other);
        match segment {
            PathSegment::MoveTo { x, y, .. } => {
                let to = point(x, y)?;
                self.end_contour();
                self.pen.move_to(to);
            }
            PathSegment::ClosePath { .. } => {
                self.pen.close();
            }
            PathSegment::LineTo { x, y, .. } => self.pen.line_to(point(x, y)?),
            PathSegment::HorizontalLineTo { x, .. } => {
                self.pen.line_to(DVec2::new(point(x, 0.0)?.x, at.y));
            }
            PathSegment::VerticalLineTo { y, .. } => {
                self.pen.line_to(DVec2::new(at.x, point(0.0, y)?.y));
            }
            PathSegment::CurveTo {
                x1,
                y1,
                x2,
                y2,
                x,
                y,
                ..
            } => {
                self.cubic(point(x1, y1)?, point(x2, y2)?, point(x, y)?);
            }
            PathSegment::SmoothCurveTo { x2, y2, x, y, .. } => {
                self.cubic(last.cubic(at), point(x2, y2)?, point(x, y)?);
            }
            PathSegment::Quadratic { x1, y1, x, y, .. } => {
                self.quadratic(point(x1, y1)?, point(x, y)?);
            }
            PathSegment::SmoothQuadratic { x, y, .. } => {
                self.quadratic(last.quadratic(at), point(x, y)?);
            }
            PathSegment::EllipticalArc {
                rx,
                ry,
                x_axis_rotation,
                large_arc,
                sweep,
                x,
                y,
                ..
            } => {
                // SVG draws an arc without a radius or an extent as a line.
                let radii = DVec2::new(rx, ry).abs().min(DVec2::splat(LARGEST));
                let turned = x_axis_rotation.to_radians();
                let to = point(x, y)?;
                match Arc::new(at, to, radii, turned, large_arc, sweep) {
                    Some(arc) => self.pen.arc_to(arc.ellipse, arc.start, arc.angle, to),
                    None => self.pen.line_to(to),
                }
            }
        }
        Some(())
    }

    fn end_contour(&mut self) {
        let (from, to) = (self.pen.start(), self.pen.at());
        // Relative coordinates accumulate rounding errors.
        let size = from.abs().max(to.abs()).max_element();
        self.open += usize::from(from.distance(to) > 1e-5 * size);
    }

    fn cubic(&mut self, control1: DVec2, control2: DVec2, to: DVec2) {
        self.pen.cubic_to(control1, control2, to);
        self.last = PreviousCurve::Cubic(control2);
    }

    fn quadratic(&mut self, control: DVec2, to: DVec2) {
        self.pen.quadratic_to(control, to);
        self.last = PreviousCurve::Quadratic(control);
    }
}

/// An arc in centre parametrization.
#[derive(Debug)]
struct Arc {
    ellipse: Ellipse,
    start: f64,
    angle: f64,
}

impl Arc {
    /// From the end points to the centre: SVG 2, appendix B.2.4. `None` if a radius is 0 or the end
    /// points are equal: then it is a line.
    fn new(
        from: DVec2,
        to: DVec2,
        radii: DVec2,
        turned: f64,
        is_large: bool,
        is_positive: bool,
    ) -> Option<Arc> {
        if radii.min_element() <= 0.0 || from == to {
            return None;
        }
        let axis = DVec2::from_angle(turned);
        // Half of the chord, in a frame where the ellipse is the unit circle.
        let half = DVec2::from_angle(-turned).rotate(0.5 * (from - to)) / radii;
        let length = half.length();
        // Radii that are too small are scaled up until the arc reaches its end.
        let (radii, half) = if length > 1.0 {
            (radii * length, half / length)
        } else {
            (radii, half)
        };
        let off = (1.0 / half.length_squared() - 1.0).max(0.0).sqrt();
        let side = if is_large == is_positive { -1.0 } else { 1.0 };
        let centre = side * off * DVec2::new(half.y, -half.x);
        let (first, last) = (half - centre, -half - centre);
        let mut angle = (last.to_angle() - first.to_angle()).rem_euclid(TAU);
        if !is_positive {
            angle -= TAU;
        }
        // Half a turn is the same on either side up to rounding.
        if is_large && angle.abs() < PI - 1e-6 || !angle.is_finite() {
            return None;
        }
        Some(Arc {
            ellipse: Ellipse {
                centre: 0.5 * (from + to) + axis.rotate(radii * centre),
                x: radii.x * axis,
                y: radii.y * axis.perp(),
            },
            start: first.to_angle(),
            angle,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Figure, FillRule};

    fn drawn(data: &str) -> (Figure, PathProblems) {
        let mut pen = Pen::default();
        let outcome = draw(data, &mut pen);
        (pen.finish(FillRule::NonZero), outcome)
    }

    /// Checks that other commands draw the same figure.
    fn check_same(a: &str, b: &str) {
        let (figure, outcome) = drawn(a);
        assert_eq!(outcome, PathProblems::default(), "{a}");
        assert_eq!(figure, drawn(b).0, "{a}");
    }

    #[test]
    fn commands_in_their_forms() {
        check_same("M0 0L2 0L2 3Z", "m0,0 2,0 0,3z");
        check_same("M0 0L2 0L2 3L0 0Z", "M0 0H2V3L0 0");
        check_same("M1 1h2v3z", "M1 1L3 1L3 4Z");
        check_same(
            "M0 0C1 2 3 2 4 0C5 -2 7 -2 8 0Z",
            "M0 0C1 2 3 2 4 0S7 -2 8 0z",
        );
        check_same("M0 0c1 2 3 2 4 0s3 -2 4 0z", "M0 0C1 2 3 2 4 0S7 -2 8 0z");
        check_same("M0 0Q1 2 2 0Q3 -2 4 0Z", "M0 0q1 2 2 0t2 0z");
        check_same("M0 0Q0 0 2 0Z", "M0 0T2 0z");
        check_same("M1 1L2 1L2 2ZL1 2L0 1Z", "M1 1L2 1L2 2ZM1 1L1 2L0 1Z");
    }

    #[test]
    fn arcs_pass_where_they_should() {
        let check = |data: &str, middle: [f64; 2], pieces: usize| {
            let (figure, outcome) = drawn(data);
            assert_eq!(
                outcome,
                PathProblems {
                    open: 1,
                    is_cut: false
                },
                "{data}"
            );
            let segments: Vec<_> = figure.segments().collect();
            assert_eq!(segments.len(), pieces + 1, "{data}");
            let at = segments[pieces / 2].start();
            assert!(at.distance(middle.into()) < 1e-9, "{data} {at}");
        };
        check("M0 0A1 1 0 0 1 2 0", [1.0, -1.0], 4);
        check("M0 0A1 1 0 0 0 2 0", [1.0, 1.0], 4);
        check("M0 0a1 1 0 1 0 2 0", [1.0, 1.0], 4);
        // Too small radii are enlarged.
        check("M0 0A.5.5 0 0 1 2 0", [1.0, -1.0], 4);
        let s = 0.5f64.sqrt();
        check("M1 0A1 1 0 0 1 0 1", [s, s], 2);
        check("M1 0A1 1 0 110 1", [1.0 + s, 1.0 + s], 6);
        check("M0 0A1 2 90 0 1 4 0", [2.0, -1.0], 4);
        assert_eq!(drawn("M0 0A0 1 0 0 1 2 0z").0, drawn("M0 0L2 0z").0);
        assert_eq!(drawn("M0 0A1 1 0 0 1 0 0z").0.curve_count(), 1);
    }

    #[test]
    fn path_data_is_drawn_up_to_the_first_error() {
        let check = |data: &str, curves: usize| {
            let (figure, outcome) = drawn(data);
            assert!(outcome.is_cut, "{data}");
            assert_eq!(figure.curve_count(), curves, "{data}");
        };
        check("L1 1", 0);
        check("M0 0L1 0L1 1ZX9", 3);
        check("M0 0L1 0L1 1Z5 5", 3);
        check("M0 0L1 0L1 1L2", 3);
        check("M0 0L1 0A1 1 0 2 0 5 5", 2);
        check("M0 0L1 0L1e99 0", 2);
        assert_eq!(drawn("").1, PathProblems::default());
    }

    #[test]
    fn open_contours_are_counted() {
        let check = |data: &str, open: usize| assert_eq!(drawn(data).1.open, open, "{data}");
        check("M0 0L1 0L1 1", 1);
        check("M0 0L1 0L1 1L0 0", 0);
        check("M0 0L1 0L1 1ZM5 5", 0);
        check("M0 0L1 0L1 1M0 0L1 0L1 1", 2);
        check("M.1 .1l.1 .1l.1 -.1l-.2 0", 0);
    }
}
