//! Drawing of figures by commands, as fonts and SVG describe them.

use azulejo_scene::figure::Segment;
use azulejo_scene::{Contour, Curve, Figure, FillRule};
use glam::DVec2;
use kurbo::{PathEl, Point};
use std::f64::consts::{FRAC_PI_4, TAU};

/// Draws the contours of a figure. Every contour is closed, by a straight line if necessary.
#[derive(Debug, Default)]
pub(crate) struct Pen {
    contours: Vec<Contour>,
    /// Curves of the current contour.
    curves: Vec<Curve>,
    start: DVec2,
    at: DVec2,
}

/// The ellipse `centre + cos t·x + sin t·y`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ellipse {
    /// The centre.
    pub centre: DVec2,
    /// One of two conjugate half diameters.
    pub x: DVec2,
    /// The other.
    pub y: DVec2,
}

impl Ellipse {
    /// The point of an angle.
    pub fn at(&self, t: f64) -> DVec2 {
        self.centre + t.cos() * self.x + t.sin() * self.y
    }

    fn tangent(&self, t: f64) -> DVec2 {
        t.cos() * self.y - t.sin() * self.x
    }
}

impl Pen {
    /// The current point.
    pub fn at(&self) -> DVec2 {
        self.at
    }

    /// The start of the current contour.
    pub fn start(&self) -> DVec2 {
        self.start
    }

    /// Closes the current contour and begins another.
    pub fn move_to(&mut self, to: DVec2) {
        self.close();
        (self.start, self.at) = (to, to);
    }

    /// Draws a line.
    pub fn line_to(&mut self, to: DVec2) {
        self.curves.push(Curve::Line { start: self.at });
        self.at = to;
    }

    /// Draws a quadratic Bézier curve, exactly converted to a cubic one.
    pub fn quadratic_to(&mut self, control: DVec2, to: DVec2) {
        let toward = |end: DVec2| end + 2.0 / 3.0 * (control - end);
        self.cubic_to(toward(self.at), toward(to), to);
    }

    /// Draws a cubic Bézier curve.
    pub fn cubic_to(&mut self, control1: DVec2, control2: DVec2, to: DVec2) {
        self.curves.push(Curve::Cubic {
            start: self.at,
            control1,
            control2,
        });
        self.at = to;
    }

    /// Draws an arc of the ellipse `centre + cos t·x + sin t·y`, from the current point at
    /// `t = start` over `angle` to the point `to`; only the inner points are computed.
    ///
    /// Pieces of at most an eighth of a turn deviate from the ellipse by less than 5e-6 of its axes.
    pub fn arc_to(&mut self, ellipse: Ellipse, start: f64, angle: f64, to: DVec2) {
        // The margin keeps rounding from adding a piece.
        let count = (angle.abs() / FRAC_PI_4 - 1e-9).ceil().clamp(1.0, 64.0);
        let step = angle / count;
        let reach = 4.0 / 3.0 * (0.25 * step).tan();
        for i in 1..=count as u32 {
            let (before, now) = (f64::from(i - 1) * step, f64::from(i) * step);
            let end = if f64::from(i) == count {
                to
            } else {
                ellipse.at(start + now)
            };
            let control1 = self.at + reach * ellipse.tangent(start + before);
            self.cubic_to(control1, end - reach * ellipse.tangent(start + now), end);
        }
    }

    /// Draws a whole ellipse, counter-clockwise from its first axis if the second is to its left.
    pub fn ellipse(&mut self, ellipse: Ellipse) {
        let first = ellipse.at(0.0);
        self.move_to(first);
        self.arc_to(ellipse, 0.0, TAU, first);
        self.close();
    }

    /// Draws a path.
    pub fn trace(&mut self, path: impl IntoIterator<Item = PathEl>) {
        let place = |p: Point| DVec2::new(p.x, p.y);
        for element in path {
            match element {
                PathEl::MoveTo(to) => self.move_to(place(to)),
                PathEl::LineTo(to) => self.line_to(place(to)),
                PathEl::QuadTo(control, to) => self.quadratic_to(place(control), place(to)),
                PathEl::CurveTo(a, b, to) => self.cubic_to(place(a), place(b), place(to)),
                PathEl::ClosePath => _ = self.close(),
            }
        }
    }

    /// The curves of the current contour, which stays open.
    pub fn into_segments(self) -> Vec<Segment> {
        let ends = self.curves.iter().skip(1).map(Curve::start);
        let ends = ends.chain([self.at]);
        let pairs = self.curves.iter().zip(ends);
        pairs.map(|(curve, end)| curve.to(end)).collect()
    }

    /// Closes the contour at its start; returns whether the current point was there already.
    pub fn close(&mut self) -> bool {
        let is_closed = self.at == self.start;
        if !is_closed {
            self.line_to(self.start);
        }
        if !self.curves.is_empty() {
            let curves = std::mem::take(&mut self.curves);
            self.contours.push(Contour { curves });
        }
        is_closed
    }

    /// The figure that was drawn.
    pub fn finish(mut self, rule: FillRule) -> Figure {
        self.close();
        Figure {
            contours: self.contours,
            rule,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(x: f64, y: f64) -> DVec2 {
        DVec2::new(x, y)
    }

    #[test]
    fn contours_are_closed() {
        let mut pen = Pen::default();
        pen.move_to(v(1.0, 1.0));
        pen.move_to(v(0.0, 0.0));
        pen.line_to(v(1.0, 0.0));
        pen.line_to(v(0.0, 1.0));
        pen.move_to(v(2.0, 0.0));
        pen.cubic_to(v(3.0, 0.0), v(3.0, 1.0), v(2.0, 1.0));
        pen.line_to(v(2.0, 0.0));
        assert!(pen.close() && pen.close());
        let figure = pen.finish(FillRule::NonZero);
        let counts: Vec<usize> = figure.contours.iter().map(|c| c.curves.len()).collect();
        assert_eq!(counts, [3, 2]);
        let last = figure.contours[0].curves[2];
        assert_eq!(last, Curve::Line { start: v(0.0, 1.0) });
    }

    #[test]
    fn arcs_are_round() {
        let circle = Ellipse {
            centre: v(1.0, 2.0),
            x: v(3.0, 0.0),
            y: v(0.0, 3.0),
        };
        let mut pen = Pen::default();
        pen.ellipse(circle);
        pen.move_to(circle.at(1.0));
        pen.arc_to(circle, 1.0, -1.0, circle.at(0.0));
        let figure = pen.finish(FillRule::EvenOdd);
        let counts: Vec<usize> = figure.contours.iter().map(|c| c.curves.len()).collect();
        assert_eq!(counts, [8, 3]);
        for curve in figure.contours[0]
            .segments()
            .chain(figure.contours[1].segments().take(2))
        {
            let off = curve.at(0.3).distance(circle.centre) - 3.0;
            assert!(off.abs() < 3.0 * 5e-6, "{off}");
        }
    }

    #[test]
    fn quadratic_curves_keep_their_shape() {
        let (a, b, c) = (v(0.0, 0.0), v(1.0, 2.0), v(3.0, 0.0));
        let mut pen = Pen::default();
        pen.move_to(a);
        pen.quadratic_to(b, c);
        let figure = pen.finish(FillRule::EvenOdd);
        let curve = figure.segments().next().unwrap();
        for t in [0.0, 0.25, 0.5, 1.0] {
            let s = 1.0 - t;
            let expected = s * s * a + 2.0 * s * t * b + t * t * c;
            assert!(curve.at(t).distance(expected) < 1e-15);
        }
    }
}
