//! Nearest points of curves, and their curvature.

use crate::figure::Segment;
use glam::DVec2;

/// Depth of the subdivision between roots: roots closer than this power of 1/2 are one.
const DEEPEST: u32 = 24;

/// Pieces of a curve whose curvature is bounded.
const BULGES: u32 = 8;

/// The parameter of a curve's point that is nearest to `point`.
#[inline]
pub(super) fn nearest_parameter(segment: &Segment, point: DVec2) -> f64 {
    match *segment {
        Segment::Line([a, b]) => {
            let way = b - a;
            let share = way.dot(point - a) / way.length_squared();
            if share > 0.0 { share.min(1.0) } else { 0.0 }
        }
        Segment::Cubic(points) => nearest_on_cubic(points, point),
    }
}

/// The best of a cubic's ends and of the minima between them, where the way to the curve is perpendicular to it: the
/// roots of a polynomial of degree 5 in Bernstein form.
fn nearest_on_cubic(points: [DVec2; 4], point: DVec2) -> f64 {
    let way = points.map(|p| p - point);
    let curve = Segment::Cubic(way);
    let (mut best, mut squared) = (0.0, way[0].length_squared());
    let mut try_at = |t: f64| {
        let here = curve.at(t).length_squared();
        if here < squared {
            (best, squared) = (t, here);
        }
    };
    try_at(1.0);
    let [a, b, c] = [way[1] - way[0], way[2] - way[1], way[3] - way[2]];
    let product = [
        way[0].dot(a),
        (2.0 * way[0].dot(b) + 3.0 * way[1].dot(a)) / 5.0,
        (way[0].dot(c) + 6.0 * way[1].dot(b) + 3.0 * way[2].dot(a)) / 10.0,
        (3.0 * way[1].dot(c) + 6.0 * way[2].dot(b) + way[3].dot(a)) / 10.0,
        (3.0 * way[2].dot(c) + 2.0 * way[3].dot(b)) / 5.0,
        way[3].dot(c),
    ];
    roots(product, [0.0, 1.0], DEEPEST, &mut try_at);
    best
}

/// Visits the sign changes of a polynomial of degree 5 with these Bernstein coefficients over a range of the
/// parameter. Variation diminishing: it has none where the coefficients have none, and one where they have one.
fn roots(b: [f64; 6], [first, last]: [f64; 2], depth: u32, visit: &mut impl FnMut(f64)) {
    let changes = (0..5)
        .filter(|&k| (b[k] >= 0.0) != (b[k + 1] >= 0.0))
        .count();
    match changes {
        0 => {}
        1 => visit(first + (last - first) * root(b)),
        _ if depth == 0 => visit(0.5 * (first + last)),
        _ => {
            let [low, high] = halves(b);
            let middle = 0.5 * (first + last);
            roots(low, [first, middle], depth - 1, visit);
            roots(high, [middle, last], depth - 1, visit);
        }
    }
}

/// The one root in 0..=1: Newton's method within a shrinking bracket.
fn root(b: [f64; 6]) -> f64 {
    let rises = b[5] >= 0.0;
    let (mut low, mut high) = (0.0, 1.0);
    let mut t = (b[0] / (b[0] - b[5])).clamp(0.0, 1.0);
    for _ in 0..64 {
        let (value, slope) = value_and_slope(b, t);
        if (value >= 0.0) == rises {
            high = t;
        } else {
            low = t;
        }
        let newton = t - value / slope;
        let is_within = newton >= low && newton <= high;
        let next = if is_within {
            newton
        } else {
            0.5 * (low + high)
        };
        let step = (next - t).abs();
        t = next;
        if step <= 1e-15 || (is_within && step <= 1e-9) {
            return t;
        }
    }
    t
}

fn value_and_slope(mut b: [f64; 6], t: f64) -> (f64, f64) {
    let s = 1.0 - t;
    for last in (1..5).rev() {
        for k in 0..=last {
            b[k] = s * b[k] + t * b[k + 1];
        }
    }
    (s * b[0] + t * b[1], 5.0 * (b[1] - b[0]))
}

/// De Casteljau's subdivision in the middle.
fn halves(b: [f64; 6]) -> [[f64; 6]; 2] {
    let (mut low, mut high) = (b, b);
    for k in 1..6 {
        for j in (k..6).rev() {
            low[j] = 0.5 * (low[j - 1] + low[j]);
        }
        for j in 0..6 - k {
            high[j] = 0.5 * (high[j] + high[j + 1]);
        }
    }
    [low, high]
}

/// An upper bound of the curvature with which a curve bulges into the inside.
pub(super) fn bulge(segment: &Segment, inner: f64) -> f64 {
    if let Segment::Line(_) = segment {
        return 0.0;
    }
    let at = |k: u32| f64::from(k) / f64::from(BULGES);
    let pieces = (0..BULGES).map(|k| segment.part([at(k), at(k + 1)]));
    pieces
        .map(|piece| bulge_of_piece(&piece, inner))
        .fold(0.0, f64::max)
}

/// The same of a piece that hardly turns: from the Bernstein coefficients of both parts of
/// κ = c′ × c″ / |c′|³.
fn bulge_of_piece(piece: &Segment, inner: f64) -> f64 {
    let Segment::Cubic([a, b, c, d]) = *piece else {
        return 0.0;
    };
    let [u, v, w] = [3.0 * (b - a), 3.0 * (c - b), 3.0 * (d - c)];
    let turns = [2.0 * u.perp_dot(v), u.perp_dot(w), 2.0 * v.perp_dot(w)];
    let most = turns
        .map(|turn| -inner * turn)
        .into_iter()
        .fold(0.0, f64::max);
    let ahead = (u + v + w).normalize_or_zero();
    let slowest = [u, v, w]
        .map(|way| way.dot(ahead))
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    if most == 0.0 {
        0.0
    } else if slowest > 0.0 {
        most / (slowest * slowest * slowest)
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::split_mix64;

    #[test]
    fn nearest_points_of_cubics_are_those_of_many_samples() {
        let mut state = 7;
        let mut point = || DVec2::new(split_mix64(&mut state), split_mix64(&mut state));
        for _ in 0..2000 {
            let curve = Segment::Cubic([point(), point(), point(), point()]);
            let from = point();
            let found = curve.at(nearest_parameter(&curve, from)).distance(from);
            let sampled = (0..=2000).map(|k| curve.at(f64::from(k) / 2000.0).distance(from));
            let best = sampled.fold(f64::INFINITY, f64::min);
            assert!(found <= best + 1e-12, "{found} {best}");
            assert!(found >= best - 2e-3, "{found} {best}");
        }
    }

    #[test]
    fn bulges_bound_curvature() {
        let mut state = 8;
        let mut point = || DVec2::new(split_mix64(&mut state), split_mix64(&mut state));
        for _ in 0..500 {
            let curve = Segment::Cubic([point(), point(), point(), point()]);
            for inner in [-1.0, 1.0] {
                let bound = bulge(&curve, inner);
                for k in 0..=100 {
                    let t = f64::from(k) / 100.0;
                    let (first, step) = (curve.derivative(t), 1e-5);
                    let second =
                        (curve.derivative(t + step) - curve.derivative(t - step)) / (2.0 * step);
                    let curvature = -inner * first.perp_dot(second) / first.length().powi(3);
                    assert!(
                        curvature <= bound * (1.0 + 1e-6) + 1e-4,
                        "{curvature} {bound}"
                    );
                }
            }
        }
    }
}
