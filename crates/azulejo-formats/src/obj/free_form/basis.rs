//! Basis functions of one direction of a free-form curve or surface.

use std::rc::Rc;

/// Largest degree that is evaluated: polynomials of higher degree lose precision.
pub(super) const MOST_DEGREE: usize = 30;

/// The Catmull–Rom cubic, rows as in [`BasisKind::Matrix`].
const CARDINAL: [f64; 16] = [
    0.0, -0.5, 1.0, -0.5, //
    1.0, 0.0, -2.5, 1.5, //
    0.0, 0.5, 2.0, -1.5, //
    0.0, 0.0, -0.5, 0.5,
];

/// A family of basis functions.
#[derive(Clone, Debug)]
pub(super) enum BasisKind {
    /// Bernstein polynomials; neighbouring spans share a control point.
    Bezier,
    /// Cox and de Boor's functions over arbitrary knots.
    BSpline,
    /// Polynomials in the span's own parameter 0..=1.
    Matrix {
        /// One row per control point of a span, with coefficients in ascending powers.
        rows: Rc<[f64]>,
        /// Number of control points from one span to the next.
        step: usize,
    },
}

impl BasisKind {
    /// Cardinal splines, cubic only.
    pub fn cardinal() -> BasisKind {
        BasisKind::Matrix {
            rows: Rc::new(CARDINAL),
            step: 1,
        }
    }

    /// Control points that are the coefficients of the polynomial.
    pub fn taylor(degree: usize) -> BasisKind {
        let n = degree + 1;
        let rows = (0..n * n).map(|k| f64::from(u8::from(k % (n + 1) == 0)));
        BasisKind::Matrix {
            rows: rows.collect(),
            step: n,
        }
    }
}

/// The basis functions of one direction: their family, degree and parameter values.
#[derive(Clone, Debug)]
pub(super) struct Basis {
    kind: BasisKind,
    degree: usize,
    /// Knots of a B-spline; the boundaries of spans of the others.
    parm: Vec<f64>,
}

/// The non-zero functions at some parameter, and their derivatives.
#[derive(Clone, Debug)]
pub(super) struct Weights {
    /// Control point of the first of them.
    pub first: usize,
    pub values: Vec<f64>,
    pub slopes: Vec<f64>,
}

impl Basis {
    /// The basis, or what is wrong with `parm`.
    pub fn new(kind: BasisKind, degree: usize, parm: Vec<f64>) -> Result<Basis, String> {
        if !(1..=MOST_DEGREE).contains(&degree) {
            return Err(format!("degree {degree}, expected 1 to {MOST_DEGREE}"));
        }
        if let BasisKind::Matrix { rows, step } = &kind
            && (rows.len() != (degree + 1) * (degree + 1) || *step == 0)
        {
            return Err(format!(
                "a basis matrix or step that does not fit degree {degree}"
            ));
        }
        let least = match kind {
            BasisKind::BSpline => 2 * degree + 2,
            _ => 2,
        };
        if parm.len() < least {
            let count = parm.len();
            return Err(format!(
                "{count} parameter values (parm), expected {least} or more"
            ));
        }
        let rises = parm.windows(2).all(|w| w[0] <= w[1]);
        let basis = Basis { kind, degree, parm };
        let (from, to) = basis.range();
        if rises && from < to && (to - from).is_finite() {
            Ok(basis)
        } else {
            Err("parameter values (parm) that do not increase".to_owned())
        }
    }

    /// Number of control points.
    pub fn count(&self) -> usize {
        let spans = self.parm.len() - 1;
        match &self.kind {
            BasisKind::Bezier => spans * self.degree + 1,
            BasisKind::BSpline => spans - self.degree,
            BasisKind::Matrix { step, .. } => (spans - 1) * step + self.degree + 1,
        }
    }

    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The boundaries of spans; some spans of a B-spline may be empty.
    fn spans(&self) -> &[f64] {
        match self.kind {
            BasisKind::BSpline => &self.parm[self.degree..self.parm.len() - self.degree],
            _ => &self.parm,
        }
    }

    /// First and last parameter.
    pub fn range(&self) -> (f64, f64) {
        let spans = self.spans();
        (spans[0], spans[spans.len() - 1])
    }

    /// `from`, `to`, and the boundaries of spans in between.
    pub fn breaks(&self, from: f64, to: f64) -> Vec<f64> {
        let inner = self.spans().iter().copied();
        let mut breaks = vec![from];
        breaks.extend(inner.filter(|t| from < *t && *t < to));
        breaks.push(to);
        breaks.dedup();
        breaks
    }

    /// The functions at `t`, which must be in the range.
    pub fn at(&self, t: f64) -> Weights {
        let spans = self.spans();
        let to = spans[spans.len() - 1];
        let last = spans.partition_point(|x| *x < to).max(1) - 1;
        let span = (spans.partition_point(|x| *x <= t).max(1) - 1).min(last);
        let length = spans[span + 1] - spans[span];
        let local = (t - spans[span]) / length;
        match &self.kind {
            BasisKind::Bezier => bernstein(span * self.degree, self.degree, local, length),
            BasisKind::BSpline => self.cox_de_boor(span, t),
            BasisKind::Matrix { rows, step } => {
                polynomials(span * step, self.degree + 1, rows, local, length)
            }
        }
    }

    /// Piegl and Tiller, *The NURBS Book*, algorithm A2.2, with the first derivatives by
    /// equation 2.7. The knots that are subtracted enclose a non-empty span.
    fn cox_de_boor(&self, first: usize, t: f64) -> Weights {
        let (knots, n) = (&self.parm, self.degree);
        let span = first + n;
        let mut values = vec![0.0; n + 1];
        let mut slopes = vec![0.0; n + 1];
        values[0] = 1.0;
        for d in 1..=n {
            let mut saved = 0.0;
            for r in 0..d {
                let (low, high) = (knots[span + 1 + r - d], knots[span + 1 + r]);
                let share = values[r] / (high - low);
                if d == n {
                    slopes[r] -= n as f64 * share;
                    slopes[r + 1] += n as f64 * share;
                }
                values[r] = saved + (high - t) * share;
                saved = (t - low) * share;
            }
            values[d] = saved;
        }
        Weights {
            first,
            values,
            slopes,
        }
    }
}

/// Bernstein polynomials over a span of length `length`, built up degree by degree.
fn bernstein(first: usize, n: usize, t: f64, length: f64) -> Weights {
    let mut values = vec![0.0; n + 1];
    let mut slopes = vec![0.0; n + 1];
    values[0] = 1.0;
    for d in 1..=n {
        let mut saved = 0.0;
        for r in 0..d {
            let share = values[r];
            if d == n {
                slopes[r] -= n as f64 * share / length;
                slopes[r + 1] += n as f64 * share / length;
            }
            values[r] = saved + (1.0 - t) * share;
            saved = t * share;
        }
        values[d] = saved;
    }
    Weights {
        first,
        values,
        slopes,
    }
}

fn polynomials(first: usize, n: usize, rows: &[f64], t: f64, length: f64) -> Weights {
    let (mut values, mut slopes) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for row in rows.chunks_exact(n) {
        let (mut value, mut slope) = (0.0, 0.0);
        for &coefficient in row.iter().rev() {
            slope = slope * t + value;
            value = value * t + coefficient;
        }
        values.push(value);
        slopes.push(slope / length);
    }
    Weights {
        first,
        values,
        slopes,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Value and derivative at `t` of a curve with these control points.
    fn curve(kind: BasisKind, degree: usize, parm: &[f64], points: &[f64], t: f64) -> (f64, f64) {
        let basis = Basis::new(kind, degree, parm.to_vec()).unwrap();
        assert_eq!(basis.count(), points.len());
        let w = basis.at(t);
        let sum = |f: &[f64]| f.iter().zip(&points[w.first..]).map(|(a, b)| a * b).sum();
        (sum(&w.values), sum(&w.slopes))
    }

    fn check(value_and_slope: (f64, f64), expected: (f64, f64)) {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(
            near(value_and_slope.0, expected.0) && near(value_and_slope.1, expected.1),
            "{value_and_slope:?}, expected {expected:?}"
        );
    }

    /// The cubic t³ − 2t + 1 over 0..=1, with its derivative.
    fn cubic(t: f64) -> (f64, f64) {
        (t * t * t - 2.0 * t + 1.0, 3.0 * t * t - 2.0)
    }

    #[test]
    fn one_cubic_in_every_family() {
        let bezier = [1.0, 1.0 / 3.0, -1.0 / 3.0, 0.0];
        let cardinal = [2.0, 1.0, 0.0, 5.0].map(|x: f64| x);
        let knots = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
        let rows: Rc<[f64]> = Rc::new([
            1.0, -3.0, 3.0, -1.0, 0.0, 3.0, -6.0, 3.0, 0.0, 0.0, 3.0, -3.0, 0.0, 0.0, 0.0, 1.0,
        ]);
        let matrix = BasisKind::Matrix { rows, step: 3 };
        for t in [0.0, 0.25, 0.5, 1.0] {
            check(
                curve(BasisKind::Bezier, 3, &[0.0, 1.0], &bezier, t),
                cubic(t),
            );
            check(curve(BasisKind::BSpline, 3, &knots, &bezier, t), cubic(t));
            check(curve(matrix.clone(), 3, &[0.0, 1.0], &bezier, t), cubic(t));
            let taylor = [1.0, -2.0, 0.0, 1.0];
            check(
                curve(BasisKind::taylor(3), 3, &[0.0, 1.0], &taylor, t),
                cubic(t),
            );
        }
        // A cardinal spline interpolates its inner points, with tangents along their neighbours.
        let (value, slope) = curve(BasisKind::cardinal(), 3, &[0.0, 1.0], &cardinal, 0.0);
        check((value, slope), (1.0, -1.0));
        let (value, slope) = curve(BasisKind::cardinal(), 3, &[0.0, 1.0], &cardinal, 1.0);
        check((value, slope), (0.0, 2.0));
    }

    #[test]
    fn spans_meet() {
        // A parabola, t², whole and in pieces of unequal length.
        let square = |t: f64| (t * t, 2.0 * t);
        let bezier = [0.0, 0.0, 1.0, 2.0 * 1.0 * 2.0 - 0.0, 9.0].map(|x: f64| x);
        // The middle control point of the second piece lies where the tangents meet: 1·3.
        let bezier = [bezier[0], bezier[1], bezier[2], 3.0, bezier[4]];
        let taylor = [0.0, 0.0, 1.0, 1.0, 4.0, 4.0];
        let knots = [0.0, 0.0, 0.0, 1.0, 3.0, 3.0, 3.0];
        let spline = [0.0, 0.0, 3.0, 9.0];
        for t in [0.0, 0.5, 1.0, 2.0, 3.0] {
            let spans = [0.0, 1.0, 3.0];
            check(curve(BasisKind::Bezier, 2, &spans, &bezier, t), square(t));
            check(
                curve(BasisKind::taylor(2), 2, &spans, &taylor, t),
                square(t),
            );
            check(curve(BasisKind::BSpline, 2, &knots, &spline, t), square(t));
        }
        let uniform: Vec<f64> = (0..8).map(f64::from).collect();
        let basis = Basis::new(BasisKind::BSpline, 3, uniform).unwrap();
        assert_eq!((basis.range(), basis.count()), ((3.0, 4.0), 4));
        let sum: f64 = basis.at(3.7).values.iter().sum();
        assert!((sum - 1.0).abs() < 1e-15);
        assert_eq!(basis.breaks(3.2, 4.0), [3.2, 4.0]);
    }

    #[test]
    fn invalid_parameters_are_reported() {
        let check = |kind: BasisKind, degree, parm: &[f64], expected: &str| {
            let message = Basis::new(kind, degree, parm.to_vec()).unwrap_err();
            assert!(message.contains(expected), "{message}");
        };
        check(BasisKind::Bezier, 0, &[0.0, 1.0], "degree 0");
        check(BasisKind::Bezier, 31, &[0.0, 1.0], "degree 31");
        check(BasisKind::Bezier, 3, &[0.0], "1 parameter values");
        check(BasisKind::Bezier, 3, &[0.0, 0.0], "do not increase");
        check(BasisKind::Bezier, 3, &[0.0, 2.0, 1.0], "do not increase");
        check(
            BasisKind::Bezier,
            3,
            &[0.0, f64::NAN, 1.0],
            "do not increase",
        );
        check(
            BasisKind::Bezier,
            3,
            &[f64::MIN, f64::MAX],
            "do not increase",
        );
        check(BasisKind::BSpline, 2, &[0.0; 5], "expected 6 or more");
        check(
            BasisKind::cardinal(),
            2,
            &[0.0, 1.0],
            "does not fit degree 2",
        );
    }
}
