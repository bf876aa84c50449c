//! The double contour integral of the logarithm of distance.
//!
//! By applying Stokes' theorem twice, the exchange area of two unoccluded polygons is A₁F₁₂ =
//! 1/(2π) Σ (dₐ·d_b) ∫∫ ln|r| ds dt over all pairs of edges, one of either polygon (E. M. Sparrow
//! 1963). The inner integral is elementary, and so is the outer one where the edges are parallel
//! (Schroeder and Hanrahan 1993 integrate every case, by dilogarithms). Elsewhere the outer
//! integral is numerical, with the number of points chosen beforehand: the integrand is analytic
//! except at three known points of the complex plane, and if the nearest lies on the ellipse with
//! semi-axes summing to ρ, the error of n Gauss points is about ρ^-2n.

use super::quadrature::{MOST_POINTS, Rule, gauss, tanh_sinh};
use glam::DVec3;
use std::f64::consts::TAU;

/// Cosine between two edges below which they count as perpendicular and contribute nothing.
const PERPENDICULAR: f64 = 1e-15;
/// Sine between two edges below which they count as parallel.
const PARALLEL: f64 = 1e-14;
/// Most points per edge for the plain product rule; beyond, closed forms are cheaper.
const MOST_FAR_POINTS: usize = 8;
/// Most points for an outer integral over a whole edge, before it is split.
const MOST_WHOLE_POINTS: usize = 16;

/// Exchange area A₁F₁₂ of two polygons, each wholly in front of the other's plane.
///
/// Coordinates should be of the order of 1, so that the logarithms are small. `tolerance` bounds
/// the quadrature error of each edge pair, relative to the product of the edges' lengths.
pub(super) fn exchange_area(p1: &[DVec3], p2: &[DVec3], tolerance: f64) -> f64 {
    let pairs = edges(p1).flat_map(|a| edges(p2).map(move |b| (a, b)));
    let sum: f64 = pairs
        .map(|(a, b)| (a.direction.dot(b.direction), a, b))
        .filter(|(cosine, ..)| cosine.abs() > PERPENDICULAR)
        .map(|(cosine, a, b)| cosine * log_distance(&a, &b, tolerance))
        .sum();
    sum / TAU
}

#[derive(Clone, Copy)]
struct Edge {
    from: DVec3,
    to: DVec3,
    direction: DVec3,
    length: f64,
}

impl Edge {
    fn new(from: DVec3, to: DVec3) -> Option<Edge> {
        let length = (to - from).length();
        let direction = (to - from) / length;
        (length > 0.0).then_some(Edge {
            from,
            to,
            direction,
            length,
        })
    }

    fn at(&self, s: f64) -> DVec3 {
        self.from + s * self.direction
    }

    fn middle(&self) -> DVec3 {
        0.5 * (self.from + self.to)
    }
}

fn edges(polygon: &[DVec3]) -> impl Iterator<Item = Edge> {
    super::edges(polygon).filter_map(|(a, b)| Edge::new(a, b))
}

/// ∫∫ ln|r| ds dt over two edges by arc length.
fn log_distance(a: &Edge, b: &Edge, tolerance: f64) -> f64 {
    let apart = (a.middle() - b.middle()).length();
    // No point of the other edge comes closer to the middle than this.
    let points_a = gauss_points((2.0 * apart - b.length) / a.length, tolerance);
    let points_b = gauss_points((2.0 * apart - a.length) / b.length, tolerance);
    if points_a.max(points_b) <= MOST_FAR_POINTS {
        far(a, b, gauss(points_a), gauss(points_b))
    } else if a.direction.cross(b.direction).length_squared() < PARALLEL * PARALLEL {
        parallel(a, b)
    } else {
        near(a, b, tolerance)
    }
}

/// Gauss points that bring the error below `tolerance` if the nearest singularity lies on the
/// ellipse around the interval whose long semi-axis is `ellipse` times half the interval.
///
/// More than [`MOST_POINTS`] if no rule does.
fn gauss_points(ellipse: f64, tolerance: f64) -> usize {
    if ellipse <= 1.0 {
        return MOST_POINTS + 1;
    }
    let rho = ellipse + (ellipse * ellipse - 1.0).sqrt();
    let points = (-0.5 * tolerance.ln() / rho.ln()).ceil();
    (points as usize).clamp(2, MOST_POINTS + 1)
}

fn far(a: &Edge, b: &Edge, rule_a: &Rule, rule_b: &Rule) -> f64 {
    let mut sum = 0.0;
    for &(s, weight_a) in rule_a {
        let p = a.at(s * a.length) - b.from;
        for &(t, weight_b) in rule_b {
            let squared = (p - t * b.length * b.direction).length_squared();
            sum += weight_a * weight_b * squared.ln();
        }
    }
    0.5 * sum * a.length * b.length
}

/// Closed form for parallel edges, collinear and common ones among them.
fn parallel(a: &Edge, b: &Edge) -> f64 {
    let offset = b.from - a.from;
    let start = offset.dot(a.direction);
    let gap = a.direction.cross(offset).length();
    let end = (b.to - a.from).dot(a.direction);
    let g = |v| twice_integrated(v, gap);
    // d²G/dv² = ln|r|; the sign is that of b running along a or against it.
    let sum = g(start - a.length) - g(start) + g(end) - g(end - a.length);
    if end > start { sum } else { -sum }
}

/// Second antiderivative of ½ ln(v² + h²) in v.
fn twice_integrated(v: f64, h: f64) -> f64 {
    let squared = v * v + h * h;
    if squared == 0.0 {
        return 0.0;
    }
    0.25 * (v * v - h * h) * squared.ln() - 0.75 * v * v + h * v * v.atan2(h)
}

/// Outer integral over `a`, inner one elementary, for edges that come close or touch.
fn near(a: &Edge, b: &Edge, tolerance: f64) -> f64 {
    let singular = singularities(a, b);
    let points = |from: f64, to: f64| {
        let ellipses = singular.iter().map(|s| s.ellipse(from, to));
        gauss_points(ellipses.fold(f64::INFINITY, f64::min), tolerance)
    };
    let whole = points(0.0, a.length);
    if whole <= MOST_WHOLE_POINTS {
        return outer(a, b, 0.0, a.length, gauss(whole));
    }
    let mut breaks = [0.0, 0.0, 0.0, 0.0, a.length];
    for (end, s) in breaks[1..4].iter_mut().zip(&singular) {
        *end = s.position.clamp(0.0, a.length);
    }
    breaks.sort_by(f64::total_cmp);
    let pieces = breaks.windows(2).filter(|w| w[1] > w[0]);
    pieces
        .map(|w| match points(w[0], w[1]) {
            n if n <= MOST_POINTS => outer(a, b, w[0], w[1], gauss(n)),
            _ => outer(a, b, w[0], w[1], tanh_sinh(tolerance)),
        })
        .sum()
}

fn outer(a: &Edge, b: &Edge, from: f64, to: f64, rule: &Rule) -> f64 {
    let length = to - from;
    let sum: f64 = rule
        .iter()
        .map(|&(s, weight)| weight * inner(a.at(from + s * length), b))
        .sum();
    sum * length
}

/// ∫ ln|r| dt from a point over an edge.
fn inner(point: DVec3, edge: &Edge) -> f64 {
    let (to_start, to_end) = (edge.from - point, edge.to - point);
    let (v1, v2) = (to_start.dot(edge.direction), to_end.dot(edge.direction));
    let h = to_start.cross(edge.direction).length();
    let angle = (h * edge.length).atan2(h * h + v1 * v2);
    0.5 * (v_log(v2, to_end) - v_log(v1, to_start)) - edge.length + h * angle
}

/// v ln|r|², whose limit at r = 0 is 0.
fn v_log(v: f64, r: DVec3) -> f64 {
    let squared = r.length_squared();
    if squared > 0.0 { v * squared.ln() } else { 0.0 }
}

/// A complex point on the line of an edge: along it, and off the real axis.
struct Singularity {
    position: f64,
    height: f64,
}

impl Singularity {
    /// Long semi-axis, over half the interval, of the ellipse through here with the interval's
    /// ends for foci.
    fn ellipse(&self, from: f64, to: f64) -> f64 {
        let sum =
            (self.position - from).hypot(self.height) + (to - self.position).hypot(self.height);
        sum / (to - from)
    }
}

/// Where the inner integral over `b` is singular as a function of the point on `a`: level with the
/// ends of b, and where the two lines would intersect in the complex plane.
fn singularities(a: &Edge, b: &Edge) -> [Singularity; 3] {
    let level = |p: DVec3| Singularity {
        position: (p - a.from).dot(a.direction),
        height: (p - a.from).cross(a.direction).length(),
    };
    let cross = a.direction.cross(b.direction);
    let offset = b.from - a.from;
    let squared = cross.length_squared();
    let meeting = Singularity {
        position: offset.cross(b.direction).dot(cross) / squared,
        height: offset.dot(cross).abs() / squared,
    };
    [level(b.from), level(b.to), meeting]
}
