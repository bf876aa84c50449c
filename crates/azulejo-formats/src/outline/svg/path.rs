//! Path data: the `d` attribute of a path.

use super::values::SvgScanner;
use crate::outline::pen::{Ellipse, Pen};
use glam::DVec2;
use std::f64::consts::{PI, TAU};

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
        data: SvgScanner::new(data),
        last: PreviousCurve::Other,
        open: 0,
        has_moved: false,
    };
    let is_whole = path.commands().is_some();
    path.end_contour();
    PathProblems {
        open: path.open,
        is_cut: !is_whole,
    }
}

struct Path<'a, 'p> {
    pen: &'p mut Pen,
    data: SvgScanner<'a>,
    last: PreviousCurve,
    open: usize,
    has_moved: bool,
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

impl Path<'_, '_> {
    /// All commands; `None` at an error.
    fn commands(&mut self) -> Option<()> {
        let mut command = 0;
        while let Some(next) = self.data.peek() {
            if next.is_ascii_alphabetic() {
                command = self.data.byte()?;
            } else {
                // Numbers alone repeat the command; after a move they are lines.
                command = match command {
                    b'M' => b'L',
                    b'm' => b'l',
                    0 | b'Z' | b'z' => return None,
                    other => other,
                };
            }
            self.command(command)?;
        }
        Some(())
    }

    fn command(&mut self, command: u8) -> Option<()> {
        let upper = command.to_ascii_uppercase();
        if !self.has_moved && upper != b'M' {
            return None;
        }
        let base = if command.is_ascii_lowercase() {
            self.pen.at()
        } else {
            DVec2::ZERO
        };
        let last = std::mem::replace(&mut self.last, PreviousCurve::Other);
        match upper {
            b'M' => self.move_to(base)?,
            b'Z' => {
                self.pen.close();
            }
            b'L' | b'H' | b'V' => {
                let to = self.line_end(upper, base)?;
                self.pen.line_to(to);
            }
            b'C' => {
                let control = base + self.data.point()?;
                self.cubic(base, control)?;
            }
            b'S' => self.cubic(base, last.cubic(self.pen.at()))?,
            b'Q' => {
                let control = base + self.data.point()?;
                self.quadratic(base, control)?;
            }
            b'T' => self.quadratic(base, last.quadratic(self.pen.at()))?,
            b'A' => self.arc(base)?,
            _ => return None,
        }
        Some(())
    }

    /// The end of a general, horizontal or vertical line.
    fn line_end(&mut self, command: u8, base: DVec2) -> Option<DVec2> {
        let at = self.pen.at();
        Some(match command {
            b'H' => DVec2::new(base.x + self.data.number()?, at.y),
            b'V' => DVec2::new(at.x, base.y + self.data.number()?),
            _ => base + self.data.point()?,
        })
    }

    fn move_to(&mut self, base: DVec2) -> Option<()> {
        let to = base + self.data.point()?;
        self.end_contour();
        self.pen.move_to(to);
        self.has_moved = true;
        Some(())
    }

    fn end_contour(&mut self) {
        let (from, to) = (self.pen.start(), self.pen.at());
        // Relative coordinates accumulate rounding errors.
        let size = from.abs().max(to.abs()).max_element();
        self.open += usize::from(from.distance(to) > 1e-5 * size);
    }

    fn cubic(&mut self, base: DVec2, control1: DVec2) -> Option<()> {
        let control2 = base + self.data.point()?;
        let to = base + self.data.point()?;
        self.pen.cubic_to(control1, control2, to);
        self.last = PreviousCurve::Cubic(control2);
        Some(())
    }

    fn quadratic(&mut self, base: DVec2, control: DVec2) -> Option<()> {
        let to = base + self.data.point()?;
        self.pen.quadratic_to(control, to);
        self.last = PreviousCurve::Quadratic(control);
        Some(())
    }

    fn arc(&mut self, base: DVec2) -> Option<()> {
        let radii = self.data.point()?.abs();
        let turned = self.data.number()?.to_radians();
        let (is_large, is_positive) = (self.data.flag()?, self.data.flag()?);
        let to = base + self.data.point()?;
        match Arc::new(self.pen.at(), to, radii, turned, is_large, is_positive) {
            Some(arc) => self.pen.arc_to(arc.ellipse, arc.start, arc.angle, to),
            None => self.pen.line_to(to),
        }
        Some(())
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
        let (found, outcome) = drawn(a);
        assert_eq!(outcome, PathProblems::default(), "{a}");
        assert_eq!(found, drawn(b).0, "{a}");
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
