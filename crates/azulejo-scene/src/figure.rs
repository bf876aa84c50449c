//! Plane figures: closed contours of straight lines and cubic Bézier curves.

use glam::DVec2;

/// A plane figure, such as the outline of a letter. Shared between prisms by `Arc`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// Closed contours; the direction in which they run matters for [`FillRule::NonZero`] alone.
    pub contours: Vec<Contour>,
    /// Which points are inside.
    pub rule: FillRule,
}

/// Which points are inside contours that overlap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FillRule {
    /// A point from which a half-line crosses the contours an odd number of times.
    #[default]
    EvenOdd,
    /// A point around which the contours wind, all counted together.
    NonZero,
}

/// A closed chain of curves. Each begins where the one before ends, and the last ends where the
/// first begins: an open contour cannot be represented.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contour {
    /// The curves in their order.
    pub curves: Vec<Curve>,
}

/// One curve of a contour, but for its end, which is where the next one starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curve {
    /// A straight line.
    Line {
        /// Where it starts.
        start: DVec2,
    },
    /// A cubic Bézier curve.
    Cubic {
        /// Where it starts, in the direction of `control1`.
        start: DVec2,
        /// The second control point.
        control1: DVec2,
        /// The third control point; the curve ends coming from there.
        control2: DVec2,
    },
}

/// A curve with both of its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    /// From the first point to the second.
    Line([DVec2; 2]),
    /// The four control points of a cubic Bézier curve.
    Cubic([DVec2; 4]),
}

/// The smallest upright rectangle around something; `min` > `max` around nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Lowest coordinates.
    pub min: DVec2,
    /// Highest coordinates.
    pub max: DVec2,
}

impl Figure {
    /// A figure of one contour of straight lines through `corners`.
    pub fn polygon(corners: impl IntoIterator<Item = DVec2>) -> Figure {
        let curves = corners.into_iter().map(|start| Curve::Line { start });
        Figure {
            contours: vec![Contour {
                curves: curves.collect(),
            }],
            rule: FillRule::EvenOdd,
        }
    }

    /// Moves every point that defines a curve; an affine map of them is that of the figure.
    pub fn move_points(&mut self, map: impl Fn(DVec2) -> DVec2) {
        for curve in self.contours.iter_mut().flat_map(|c| &mut c.curves) {
            match curve {
                Curve::Line { start } => *start = map(*start),
                Curve::Cubic {
                    start,
                    control1,
                    control2,
                } => [start, control1, control2]
                    .into_iter()
                    .for_each(|p| *p = map(*p)),
            }
        }
    }

    /// All curves with their end points, contour by contour.
    pub fn segments(&self) -> impl Iterator<Item = Segment> + '_ {
        self.contours.iter().flat_map(Contour::segments)
    }

    /// Number of curves.
    pub fn curve_count(&self) -> usize {
        self.contours.iter().map(|c| c.curves.len()).sum()
    }

    /// The smallest rectangle around the curves themselves, not their control points.
    pub fn bounds(&self) -> Rectangle {
        self.segments()
            .fold(Rectangle::EMPTY, |b, s| b.union(s.bounds()))
    }

    /// Sum of the areas that the contours enclose, counter-clockwise ones counting positive. Exact
    /// to rounding: Green's theorem on each Bézier curve.
    pub fn signed_area(&self) -> f64 {
        self.segments().map(|s| s.swept_area()).sum()
    }

    /// The winding number of the contours about a point, counter-clockwise counting positive.
    ///
    /// A point on a curve is consistently assigned to one of its sides.
    pub fn winding(&self, point: DVec2) -> i32 {
        self.segments().map(|s| s.winding(point)).sum()
    }

    /// Whether a point is inside, by the figure's own rule.
    pub fn contains(&self, point: DVec2) -> bool {
        self.rule.is_inside(self.winding(point))
    }

    /// The contours as polygons whose chords deviate from the curves by at most `tolerance`, > 0.
    /// The start of every curve is a corner.
    pub fn flatten(&self, tolerance: f64) -> Vec<Vec<DVec2>> {
        let flat = |contour: &Contour| {
            let mut corners = Vec::new();
            for segment in contour.segments() {
                segment.flatten_into(tolerance, &mut corners);
            }
            corners
        };
        self.contours.iter().map(flat).collect()
    }
}

impl FillRule {
    /// Whether a point with this winding number is inside.
    pub fn is_inside(self, winding: i32) -> bool {
        match self {
            FillRule::EvenOdd => winding & 1 != 0,
            FillRule::NonZero => winding != 0,
        }
    }
}

impl Contour {
    /// Its curves with their ends.
    pub fn segments(&self) -> impl Iterator<Item = Segment> + '_ {
        let next = self.curves.iter().cycle().skip(1);
        self.curves
            .iter()
            .zip(next)
            .map(|(curve, next)| curve.to(next.start()))
    }
}

impl Curve {
    /// Where it starts.
    pub fn start(&self) -> DVec2 {
        match *self {
            Curve::Line { start } | Curve::Cubic { start, .. } => start,
        }
    }

    /// With its end.
    pub fn to(&self, end: DVec2) -> Segment {
        match *self {
            Curve::Line { start } => Segment::Line([start, end]),
            Curve::Cubic {
                start,
                control1,
                control2,
            } => Segment::Cubic([start, control1, control2, end]),
        }
    }
}

impl Segment {
    /// Where it starts.
    pub fn start(&self) -> DVec2 {
        match *self {
            Segment::Line([start, _]) | Segment::Cubic([start, ..]) => start,
        }
    }

    /// Where it ends.
    pub fn end(&self) -> DVec2 {
        match *self {
            Segment::Line([_, end]) | Segment::Cubic([_, _, _, end]) => end,
        }
    }

    /// The point at `t`, 0..=1.
    pub fn at(&self, t: f64) -> DVec2 {
        match *self {
            Segment::Line([a, b]) => a + t * (b - a),
            Segment::Cubic([a, b, c, d]) => {
                let s = 1.0 - t;
                s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d
            }
        }
    }

    /// The derivative at `t`, 0..=1. Zero at an end whose control point falls on it.
    pub fn derivative(&self, t: f64) -> DVec2 {
        match *self {
            Segment::Line([a, b]) => b - a,
            Segment::Cubic([a, b, c, d]) => {
                let s = 1.0 - t;
                3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c))
            }
        }
    }

    /// The second derivative at `t`, 0..=1.
    pub fn second_derivative(&self, t: f64) -> DVec2 {
        match *self {
            Segment::Line(_) => DVec2::ZERO,
            Segment::Cubic([a, b, c, d]) => {
                6.0 * ((1.0 - t) * (a - 2.0 * b + c) + t * (b - 2.0 * c + d))
            }
        }
    }

    /// The smallest rectangle around it.
    pub fn bounds(&self) -> Rectangle {
        let ends = Rectangle::around([self.start(), self.end()]);
        let Segment::Cubic([a, b, c, d]) = *self else {
            return ends;
        };
        (0..2).fold(ends, |bounds, axis| {
            let turns = turning_points([a[axis], b[axis], c[axis], d[axis]]);
            let mut bounds = bounds;
            for t in turns.into_iter().flatten() {
                let p = self.at(t);
                bounds.min[axis] = bounds.min[axis].min(p[axis]);
                bounds.max[axis] = bounds.max[axis].max(p[axis]);
            }
            bounds
        })
    }

    /// The area between the curve and the origin: its share of [`Figure::signed_area`].
    fn swept_area(&self) -> f64 {
        match *self {
            Segment::Line([a, b]) => 0.5 * a.perp_dot(b),
            Segment::Cubic([a, b, c, d]) => {
                (6.0 * a.perp_dot(b)
                    + 3.0 * a.perp_dot(c)
                    + a.perp_dot(d)
                    + 3.0 * b.perp_dot(c)
                    + 3.0 * b.perp_dot(d)
                    + 6.0 * c.perp_dot(d))
                    / 20.0
            }
        }
    }

    /// Crossings of the half-line from `point` toward +x, upward ones counting 1, downward −1.
    ///
    /// A curve is above the half-line where its y is not below the point's, and signs are taken
    /// at the same numbers by the curves on both sides of a joint: none is counted twice or lost.
    fn winding(&self, point: DVec2) -> i32 {
        let side = |p: DVec2| p.y >= point.y;
        match *self {
            Segment::Line([a, b]) => {
                let up = i32::from(side(b)) - i32::from(side(a));
                if up == 0 || a.x.max(b.x) < point.x {
                    0
                } else if a.x.min(b.x) >= point.x {
                    up
                } else {
                    let x = a.x + (b.x - a.x) * ((point.y - a.y) / (b.y - a.y));
                    if x >= point.x { up } else { 0 }
                }
            }
            Segment::Cubic(p) => {
                if p.iter().all(|q| side(*q)) || p.iter().all(|q| !side(*q)) {
                    return 0;
                }
                if p.iter().all(|q| q.x < point.x) {
                    return 0;
                }
                if p.iter().all(|q| q.x >= point.x) {
                    return i32::from(side(p[3])) - i32::from(side(p[0]));
                }
                let height = p.map(|q| q.y - point.y);
                let crossings = crossings(height);
                let ahead = |&&(t, _): &&(f64, i32)| self.at(t).x >= point.x;
                crossings
                    .iter()
                    .flatten()
                    .filter(|c| ahead(c))
                    .map(|c| c.1)
                    .sum()
            }
        }
    }

    /// Appends its start and points along it, the end left out.
    fn flatten_into(&self, tolerance: f64, corners: &mut Vec<DVec2>) {
        let count = self.chords(tolerance);
        corners.extend((0..count).map(|k| self.at(f64::from(k) / f64::from(count))));
    }

    /// The number of chords, over equal steps of the parameter, that approximate it within
    /// `tolerance`; at most 4096.
    pub fn chords(&self, tolerance: f64) -> u32 {
        match *self {
            Segment::Line(_) => 1,
            // The chord of a piece of length h deviates from a curve by at most h² max|B″| / 8.
            Segment::Cubic([a, b, c, d]) => {
                let bend = (a - 2.0 * b + c).length().max((b - 2.0 * c + d).length());
                let count = (6.0 * bend / (8.0 * tolerance)).sqrt().ceil();
                count.clamp(1.0, 4096.0) as u32
            }
        }
    }

    /// The tangent at its start, any length; zero if it is a point.
    pub fn departure(&self) -> DVec2 {
        let towards = |rest: &[DVec2]| {
            let steps = rest.iter().map(|&p| p - self.start());
            steps.into_iter().find(|s| *s != DVec2::ZERO)
        };
        match self {
            Segment::Line([_, rest @ ..]) => towards(rest),
            Segment::Cubic([_, rest @ ..]) => towards(rest),
        }
        .unwrap_or(DVec2::ZERO)
    }

    /// The direction at `t`, any length; zero if it is a point. Also where control points coincide.
    pub fn tangent(&self, t: f64) -> DVec2 {
        let tangent = self.derivative(t);
        let size = self.hull().size().max_element();
        if tangent.length() > 1e-12 * size {
            return tangent;
        }
        self.at((t + 1e-3).min(1.0)) - self.at((t - 1e-3).max(0.0))
    }

    /// The smallest rectangle around its control points.
    pub fn hull(&self) -> Rectangle {
        match *self {
            Segment::Line(points) => Rectangle::around(points),
            Segment::Cubic(points) => Rectangle::around(points),
        }
    }

    /// The part between two parameters, 0..=1, as a curve of its own. The ends of the whole stay as they are.
    pub fn part(&self, [first, last]: [f64; 2]) -> Segment {
        if [first, last] == [0.0, 1.0] {
            return *self;
        }
        let (start, end) = (self.at(first), self.at(last));
        let start = if first == 0.0 { self.start() } else { start };
        let end = if last == 1.0 { self.end() } else { end };
        match self {
            Segment::Line(_) => Segment::Line([start, end]),
            Segment::Cubic(_) => {
                let third = (last - first) / 3.0;
                let control1 = start + third * self.derivative(first);
                let control2 = end - third * self.derivative(last);
                Segment::Cubic([start, control1, control2, end])
            }
        }
    }

    /// The same curve from its end to its start.
    pub fn reversed(&self) -> Segment {
        match *self {
            Segment::Line([a, b]) => Segment::Line([b, a]),
            Segment::Cubic([a, b, c, d]) => Segment::Cubic([d, c, b, a]),
        }
    }
}

impl Rectangle {
    /// Around nothing.
    pub const EMPTY: Rectangle = Rectangle {
        min: DVec2::INFINITY,
        max: DVec2::NEG_INFINITY,
    };

    /// The smallest around `points`.
    pub fn around(points: impl IntoIterator<Item = DVec2>) -> Rectangle {
        points.into_iter().fold(Rectangle::EMPTY, |b, p| Rectangle {
            min: b.min.min(p),
            max: b.max.max(p),
        })
    }

    /// The smallest around both.
    pub fn union(self, o: Rectangle) -> Rectangle {
        Rectangle {
            min: self.min.min(o.min),
            max: self.max.max(o.max),
        }
    }

    /// Larger by `margin` on all sides.
    pub fn enlarged(&self, margin: f64) -> Rectangle {
        Rectangle {
            min: self.min - margin,
            max: self.max + margin,
        }
    }

    /// Whether both have a point in common.
    pub fn overlaps(&self, o: &Rectangle) -> bool {
        self.min.cmple(o.max).all() && o.min.cmple(self.max).all()
    }

    /// The square of the distance of a point, 0 inside.
    #[inline]
    pub fn distance_squared(&self, p: DVec2) -> f64 {
        (self.min - p)
            .max(p - self.max)
            .max(DVec2::ZERO)
            .length_squared()
    }

    /// Whether a straight line between two points meets the rectangle, enlarged by `margin` on all sides.
    #[inline]
    pub fn is_met(&self, [a, b]: [DVec2; 2], margin: f64) -> bool {
        let Rectangle {
            min: low,
            max: high,
        } = self.enlarged(margin);
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for axis in 0..2 {
            let way = b[axis] - a[axis];
            let (p, q) = ((low[axis] - a[axis]) / way, (high[axis] - a[axis]) / way);
            if way != 0.0 {
                enter = enter.max(p.min(q));
                leave = leave.min(p.max(q));
            } else if a[axis] < low[axis] || a[axis] > high[axis] {
                return false;
            }
        }
        enter <= leave
    }

    /// Width and height; zero for the empty rectangle.
    pub fn size(&self) -> DVec2 {
        (self.max - self.min).max(DVec2::ZERO)
    }
}

/// The extrema in 0..1 of a cubic with these Bernstein coefficients: the roots of its derivative.
///
/// Rounding may move a root a little; the pieces between them are monotonic up to rounding.
pub fn turning_points([a, b, c, d]: [f64; 4]) -> [Option<f64>; 2] {
    let (u, v, w) = (b - a, c - b, d - c);
    // The derivative is 3 (u s² + 2 v s t + w t²).
    let (qa, qb, qc) = (u - 2.0 * v + w, v - u, u);
    let discriminant = qb * qb - qa * qc;
    if discriminant < 0.0 || discriminant.is_nan() {
        return [None; 2];
    }
    // Press et al., Numerical Recipes, eq. (5.6.4): the sum that does not cancel.
    let q = -(qb + discriminant.sqrt().copysign(qb));
    let within = |t: f64| (t > 0.0 && t < 1.0).then_some(t);
    let (r, s) = (within(q / qa), within(qc / q));
    match (r, s) {
        (Some(r), Some(s)) if r == s => [Some(r), None],
        (Some(r), Some(s)) => [Some(r.min(s)), Some(r.max(s))],
        (one, other) => [one.or(other), None],
    }
}

/// The sign changes in 0..=1 of a cubic with these Bernstein coefficients (0 counting as positive),
/// in order, each with its direction: rising (1) or falling (−1).
///
/// Their number is odd if the signs of the first and last coefficient differ and even if not, in
/// spite of rounding. Where the cubic only touches zero, both crossings may be found or none.
#[inline]
pub fn crossings(b: [f64; 4]) -> [Option<(f64, i32)>; 3] {
    let side = b.map(|x| i32::from(x >= 0.0));
    let changes = (0..3).filter(|&k| side[k] != side[k + 1]).count();
    match changes {
        0 => [None; 3],
        // Variation diminishing: the curve changes sign no more often than its control points.
        1 => {
            let root = root_between(b, (0.0, b[0]), (1.0, b[3]));
            [Some((root, side[3] - side[0])), None, None]
        }
        _ => crossings_by_pieces(b),
    }
}

/// [`crossings`], one for each monotonic piece whose ends differ in sign.
fn crossings_by_pieces(b: [f64; 4]) -> [Option<(f64, i32)>; 3] {
    let mut crossings = [None; 3];
    let mut count = 0;
    let (mut t0, mut f0) = (0.0, b[0]);
    let turns = turning_points(b).into_iter().flatten();
    for t1 in turns.chain([1.0]) {
        let f1 = if t1 == 1.0 { b[3] } else { bernstein(b, t1) };
        let sense = i32::from(f1 >= 0.0) - i32::from(f0 >= 0.0);
        if sense != 0 {
            crossings[count] = Some((root_between(b, (t0, f0), (t1, f1)), sense));
            count += 1;
        }
        (t0, f0) = (t1, f1);
    }
    crossings
}

/// The cubic with these Bernstein coefficients at `t`.
#[inline]
pub fn bernstein([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    let s = 1.0 - t;
    s * s * (s * a + 3.0 * t * b) + t * t * (3.0 * s * c + t * d)
}

/// The derivative of the cubic with these Bernstein coefficients at `t`.
#[inline]
pub fn bernstein_slope([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    let s = 1.0 - t;
    3.0 * (s * (s * (b - a) + 2.0 * t * (c - b)) + t * t * (d - c))
}

/// A Newton step shorter than this is the last: the next would be about its square.
const LAST_STEP: f64 = 1e-9;

/// The root between two parameters at which a cubic has different signs: Newton's method within a
/// shrinking bracket.
#[inline]
fn root_between(b: [f64; 4], low: (f64, f64), high: (f64, f64)) -> f64 {
    let rises = high.1 >= 0.0;
    let mut t = low.0 + (high.0 - low.0) * (low.1 / (low.1 - high.1)).clamp(0.0, 1.0);
    let (mut low, mut high) = (low.0, high.0);
    for _ in 0..64 {
        let f = bernstein(b, t);
        if (f >= 0.0) == rises {
            high = t;
        } else {
            low = t;
        }
        let newton = t - f / bernstein_slope(b, t);
        if newton >= low && newton <= high {
            if (newton - t).abs() <= LAST_STEP {
                return newton;
            }
            t = newton;
        } else {
            t = 0.5 * (low + high);
            if high - low <= 2.0 * f64::EPSILON {
                return t;
            }
        }
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(x: f64, y: f64) -> DVec2 {
        DVec2::new(x, y)
    }

    /// The letter D of Costa 1992: three lines and a Bézier curve, and a hole of one curve.
    fn letter_d() -> Figure {
        let line = |x, y| Curve::Line { start: v(x, y) };
        let outer = vec![
            line(0.0, 0.0),
            line(0.0, 23.0),
            Curve::Cubic {
                start: v(8.0, 23.0),
                control1: v(25.0, 21.0),
                control2: v(23.0, 0.0),
            },
            line(8.0, 0.0),
        ];
        let hole = vec![Curve::Cubic {
            start: v(6.0, 15.0),
            control1: v(4.0, -6.0),
            control2: v(23.0, 17.0),
        }];
        Figure {
            contours: vec![Contour { curves: outer }, Contour { curves: hole }],
            rule: FillRule::EvenOdd,
        }
    }

    #[test]
    fn the_letter_d_has_a_hole() {
        let d = letter_d();
        assert!(d.contains(v(2.0, 12.0)), "the stem");
        assert!(!d.contains(v(8.5, 10.0)), "the hole");
        assert!(d.contains(v(16.0, 12.0)), "the bow");
        for outside in [v(-0.1, 12.0), v(24.0, 12.0), v(4.0, 23.1), v(4.0, -0.1)] {
            assert!(!d.contains(outside), "{outside}");
        }
    }

    #[test]
    fn area_and_winding_agree_with_the_flat_figure() {
        let d = letter_d();
        let shoelace = |p: &[DVec2]| {
            let next = p.iter().cycle().skip(1);
            p.iter()
                .zip(next)
                .map(|(a, b)| 0.5 * a.perp_dot(*b))
                .sum::<f64>()
        };
        let flat: f64 = d.flatten(1e-7).iter().map(|c| shoelace(c)).sum();
        assert!((flat - d.signed_area()).abs() < 1e-5);
        let polygons = Figure {
            contours: d
                .flatten(1e-7)
                .into_iter()
                .flat_map(|c| Figure::polygon(c).contours)
                .collect(),
            rule: FillRule::EvenOdd,
        };
        let mut differ = 0;
        for k in 0..10_000 {
            let p = v(
                f64::from(k % 100) * 0.26 - 1.0,
                f64::from(k / 100) * 0.25 - 1.0,
            );
            differ += usize::from(polygons.contains(p) != d.contains(p));
        }
        assert_eq!(differ, 0);
    }

    #[test]
    fn bounds_are_those_of_the_curve() {
        let d = letter_d();
        let b = d.bounds();
        assert_eq!((b.min, b.max.y), (v(0.0, 0.0), 23.0));
        // Control points reach 25, the curve itself less than 20.
        assert!(b.max.x > 19.0 && b.max.x < 20.5, "{b:?}");
    }

    #[test]
    fn double_roots_do_not_break_parity() {
        // Touches zero at t = 1/2, from above, from below, and exactly.
        for shift in [-1e-17, 0.0, 1e-17, -1e-12, 1e-12] {
            let b = [
                0.25,
                -0.083_333_333_333_333_33,
                -0.083_333_333_333_333_33,
                0.25,
            ];
            let n = crossings(b.map(|x| x + shift)).iter().flatten().count();
            assert!(n == 0 || n == 2, "{n} crossings at shift {shift}");
        }
    }
}
