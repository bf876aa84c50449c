//! Closed formulas and quadratures of form factors, independent of the engines that they judge.
//!
//! Numbers such as C-11 are those of Howell, *A Catalog of Radiation Heat Transfer Configuration
//! Factors*, 3rd ed. Where a formula is a double sum over corners, polygons may touch.

mod quadrature;
#[cfg(test)]
mod tests;

use glam::DVec3;
use quadrature::gauss;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// An interval of one coordinate.
pub type Span = [f64; 2];

/// C-13: from the rectangle x × y to the rectangle xi × eta in the plane at distance `z` > 0.
pub fn parallel(x: Span, y: Span, xi: Span, eta: Span, z: f64) -> f64 {
    let corner = |dx: f64, dy: f64| {
        let (a, b) = (dx.hypot(z), dy.hypot(z));
        dy * a * (dy / a).atan() + dx * b * (dx / b).atan() - z * z * dx.hypot(dy).hypot(z).ln()
    };
    corners(|[i, j, k, l]| corner(x[i] - xi[k], y[j] - eta[l])) / (TAU * length(x) * length(y))
}

/// C-15: from the rectangle x × y in the plane z = 0 to the rectangle eta × zeta (along y and
/// along z) in the plane x = 0; `x` and `zeta` not negative.
pub fn perpendicular(x: Span, y: Span, eta: Span, zeta: Span) -> f64 {
    let corner = |c2: f64, d: f64| {
        let (d2, sum) = (d * d, c2 + d * d);
        let log = |part: f64| {
            if part > 0.0 {
                part * (sum / part).ln()
            } else {
                0.0
            }
        };
        let arc = if c2 > 0.0 {
            d * c2.sqrt() * (d / c2.sqrt()).atan()
        } else {
            0.0
        };
        arc - 0.25 * (log(c2) - log(d2))
    };
    let at = |[i, j, k, l]: [usize; 4]| corner(x[i] * x[i] + zeta[k] * zeta[k], y[j] - eta[l]);
    corners(at) / (TAU * length(x) * length(y))
}

/// Sum over the ends of four intervals, upper minus lower.
fn corners(f: impl Fn([usize; 4]) -> f64) -> f64 {
    let term = |bits: usize| {
        let index = [0, 1, 2, 3].map(|k| bits >> k & 1);
        let sign = if bits.count_ones().is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        sign * f(index)
    };
    (0..16).map(term).sum()
}

fn length(span: Span) -> f64 {
    span[1] - span[0]
}

/// C-11: opposed rectangles of sides a and b at distance c.
pub fn opposed(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (x2, y2) = (1.0 + x * x, 1.0 + y * y);
    let log = 0.5 * (x2 * y2 / (1.0 + x * x + y * y)).ln();
    let arcs = x * y2.sqrt() * (x / y2.sqrt()).atan() + y * x2.sqrt() * (y / x2.sqrt()).atan();
    2.0 / (PI * x * y) * (log + arcs - x * x.atan() - y * y.atan())
}

/// C-14: from the rectangle of depth w to the perpendicular one of height h on their common edge of
/// length l.
pub fn on_common_edge(l: f64, w: f64, h: f64) -> f64 {
    let (w, h) = (w / l, h / l);
    let (w2, h2) = (w * w, h * h);
    let (a, b, c, d) = (1.0 + w2, 1.0 + h2, 1.0 + w2 + h2, w2 + h2);
    let log = (a * b / c).ln() + w2 * (w2 * c / (a * d)).ln() + h2 * (h2 * c / (b * d)).ln();
    let arcs = w * (1.0 / w).atan() + h * (1.0 / h).atan() - d.sqrt() * (1.0 / d.sqrt()).atan();
    (arcs + 0.25 * log) / (PI * w)
}

/// C-16: unit squares with a common edge at `angle`, by the double contour integral.
///
/// Edges along the common one give a closed integral for each distance; of the other two pairs,
/// those that meet in a corner give a closed one, those a unit apart a smooth double integral.
pub fn wedge(angle: f64) -> f64 {
    let cos = angle.cos();
    // ∫∫ ln r ds dt over parallel unit edges at distance d.
    let along = |d: f64| {
        let (d2, sum) = (d * d, 1.0 + d * d);
        let end = if d > 0.0 {
            2.0 * d * (1.0 / d).atan() + 0.5 * d2 * d2.ln()
        } else {
            0.0
        };
        sum.ln() - 1.5 - 0.5 * sum * sum.ln() + end
    };
    // The same over unit edges that leave one corner at the angle: r = s times a function of t/s.
    let line = |v: f64| {
        let sin = angle.sin();
        let u = v - cos;
        u * (u * u + sin * sin).ln() - 2.0 * u + 2.0 * sin * (u / sin).atan()
    };
    let meeting = 0.5 * (line(1.0) - line(0.0)) - 0.5;
    let apart = gauss(0.0, 1.0, |s| {
        gauss(0.0, 1.0, |t| {
            0.5 * (1.0 + s * s + t * t - 2.0 * s * t * cos).ln()
        })
    });
    let far = (2.0 - 2.0 * cos).sqrt();
    let parallel = 2.0 * along(1.0) - along(0.0) - along(far);
    (parallel + 2.0 * cos * (apart - meeting)) / TAU
}

/// Between polygons that do not touch and see each other completely: the double contour integral,
/// with Gauss points on both edges.
pub fn double_contour(from: &[DVec3], to: &[DVec3]) -> f64 {
    let edges = |p: &[DVec3]| -> Vec<(DVec3, DVec3)> {
        (0..p.len())
            .map(|k| (p[k], p[(k + 1) % p.len()] - p[k]))
            .collect()
    };
    let mut sum = 0.0;
    for (a, da) in edges(from) {
        for &(b, db) in &edges(to) {
            let log = |s: f64, t: f64| (a + s * da).distance(b + t * db).ln();
            sum += da.dot(db) * gauss(0.0, 1.0, |s| gauss(0.0, 1.0, |t| log(s, t)));
        }
    }
    let double_area: DVec3 = edges(from).iter().map(|&(p, d)| p.cross(p + d)).sum();
    sum / (PI * double_area.length())
}

/// From an element to a polygon in front of it: Lambert's sum over the edges.
pub fn element(point: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    let corner = |k: usize| polygon[k % polygon.len()] - point;
    let edge = |k: usize| {
        let (a, b) = (corner(k), corner(k + 1));
        let cross = a.cross(b);
        cross.length().atan2(a.dot(b)) * cross.normalize().dot(normal)
    };
    (0..polygon.len()).map(edge).sum::<f64>().abs() / TAU
}

/// B-3: from an element to a rectangle a × b in a parallel plane at distance c, over its corner.
pub fn element_parallel(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let part = |x: f64, y: f64| {
        let root = (1.0 + x * x).sqrt();
        x / root * (y / root).atan()
    };
    (part(x, y) + part(y, x)) / TAU
}

/// B-4: from an element to a perpendicular rectangle at distance c, whose lower edge of length b
/// starts level with the element; a is its height.
pub fn element_perpendicular(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / b, c / b);
    let root = x.hypot(y);
    ((1.0 / y).atan() - y / root * (1.0 / root).atan()) / TAU
}

/// C-41: from a disk of radius r1 to a coaxial one of radius r2 at distance h.
pub fn coaxial_disks(r1: f64, r2: f64, h: f64) -> f64 {
    let s = 1.0 + (h * h + r2 * r2) / (r1 * r1);
    // The difference of s and its root, without cancellation.
    let q = 4.0 * (r2 / r1) * (r2 / r1);
    0.5 * q / (s + (s * s - q).sqrt())
}

/// C-91: from the outer of two concentric cylinders of length h to the inner one, r2 > r1.
pub fn outer_to_inner(r1: f64, r2: f64, h: f64) -> f64 {
    let (r, h) = (r2 / r1, h / r1);
    let (a, b) = (h * h + r * r - 1.0, h * h - r * r + 1.0);
    let root = ((a + 2.0) * (a + 2.0) - 4.0 * r * r).sqrt();
    let inner = root * (b / (r * a)).acos() + b * (1.0 / r).asin() - FRAC_PI_2 * a;
    (1.0 - ((b / a).acos() - inner / (2.0 * h)) / PI) / r
}

/// C-92: from the outer of two concentric cylinders of length h to itself, r2 > r1.
pub fn outer_to_itself(r1: f64, r2: f64, h: f64) -> f64 {
    let (r, h) = (r2 / r1, h / r1);
    let (r2, h2) = (r * r, h * h);
    let root = (4.0 * r2 + h2).sqrt();
    let q = 4.0 * (r2 - 1.0);
    let first = root / h * ((q + h2 / r2 * (r2 - 2.0)) / (h2 + q)).asin();
    let second = ((r2 - 2.0) / r2).asin();
    let third = FRAC_PI_2 * (root / h - 1.0);
    let gap = 2.0 / (PI * r) * (2.0 * (r2 - 1.0).sqrt() / h).atan();
    1.0 - 1.0 / r + gap - h / (TAU * r) * (first - second + third)
}

/// B-43: from an element to a unit sphere whose centre is h > 1 away, at an angle of cosine c to
/// the element's normal; the part below the horizon is invisible.
pub fn element_to_unit_sphere(h: f64, c: f64) -> f64 {
    if c * h >= 1.0 {
        return c / (h * h);
    }
    if c * h <= -1.0 {
        return 0.0;
    }
    let (sin, tangent) = ((1.0 - c * c).sqrt(), (h * h - 1.0).sqrt());
    let lens = c * (-tangent * c / sin).acos() - tangent * (1.0 - h * h * c * c).sqrt();
    0.5 - (tangent / (h * sin)).asin() / PI + lens / (PI * h * h)
}

/// From a unit sphere to another, centres `distance` > 2 apart: the element's formula over all
/// polar angles, split at the angles where the horizon begins and ends to matter.
pub fn unit_spheres(distance: f64) -> f64 {
    let at = |cos: f64| {
        let h = (1.0 + distance * (distance - 2.0 * cos)).sqrt();
        element_to_unit_sphere(h, (distance * cos - 1.0) / h)
    };
    let sine_substituted = |from: f64, to: f64| {
        // cos = middle + half sin φ smooths the roots at the ends.
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        gauss(-FRAC_PI_2, FRAC_PI_2, |p| {
            at(middle + half * p.sin()) * half * p.cos()
        })
    };
    let (dark, whole) = (0.0, 2.0 / distance);
    0.5 * (sine_substituted(dark, whole) + sine_substituted(whole, 1.0))
}

/// Crossed strings: infinite opposed strips of width w at distance h (C-1).
pub fn strips(w: f64, h: f64) -> f64 {
    let x = h / w;
    x.hypot(1.0) - x
}

/// Crossed strings: infinite strips of equal width that meet at `angle` (C-5).
pub fn strips_at_angle(angle: f64) -> f64 {
    1.0 - (0.5 * angle).sin()
}

/// Crossed strings: from an infinite strip of width a to one of width b over its middle at distance h
/// (C-2).
pub fn strips_of_widths(a: f64, b: f64, h: f64) -> f64 {
    let (sum, difference) = (0.5 * (a + b), 0.5 * (a - b));
    (sum.hypot(h) - difference.hypot(h)) / a
}

/// Crossed strings: from an infinite strip of width a to one of width b that meets it at `angle` (C-3,
/// C-5).
pub fn strips_at_angle_of(a: f64, b: f64, angle: f64) -> f64 {
    // The third side of the triangle, without cancellation.
    let half = (0.5 * angle).sin();
    let third = (a - b).hypot(2.0 * half * (a * b).sqrt());
    0.5 * (a + b - third) / a
}

/// From an infinite strip between x = a and x = b to a parallel cylinder of radius r, whose axis is at
/// x = 0 and at the height h above the strip's plane: the mean over the strip of r h / (x² + h²), and
/// r arctan(x/h) its integral.
pub fn strip_to_cylinder(a: f64, b: f64, h: f64, r: f64) -> f64 {
    r / (b - a) * ((b / h).atan() - (a / h).atan())
}

/// From a sphere to a disk of radius r on an axis through its centre, at the distance h of it.
pub fn sphere_to_disk(r: f64, h: f64) -> f64 {
    0.5 * (1.0 - h / h.hypot(r))
}

/// From an element to a parallel disk of radius r at height h, whose axis is at the distance d > 0.
pub fn element_to_disk_aside(d: f64, h: f64, r: f64) -> f64 {
    let (h, r) = (h / d, r / d);
    let z = 1.0 + h * h + r * r;
    0.5 * (1.0 - (z - 2.0 * r * r) / (z * z - 4.0 * r * r).sqrt())
}

/// From an element to a disk of radius r at height h, whose axis is at the distance d > r, where the
/// element's normal points.
pub fn element_to_disk_across(d: f64, h: f64, r: f64) -> f64 {
    let (h, r) = (h / d, r / d);
    let z = 1.0 + h * h + r * r;
    0.5 * h * (z / (z * z - 4.0 * r * r).sqrt() - 1.0)
}

/// C-65 type, crossed strings: infinite parallel cylinders of radius r, a gap s between them.
pub fn parallel_cylinders(r: f64, s: f64) -> f64 {
    let x = 1.0 + s / (2.0 * r);
    ((x * x - 1.0).sqrt() + (1.0 / x).asin() - x) / PI
}

/// Crossed strings: from a plane to a row of cylinders whose diameter is d times their spacing.
pub fn plane_to_tubes(d: f64) -> f64 {
    1.0 - (1.0 - d * d).sqrt() + d * (1.0 / (d * d) - 1.0).sqrt().atan()
}

/// Share of diffuse light that a body of refractive index n reflects specularly, from outside
/// (Duntley 1942).
pub fn diffuse_fresnel(n: f64) -> f64 {
    let (n2, n4) = (n * n, n * n * n * n);
    let (plus, minus) = (n2 + 1.0, n4 - 1.0);
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0))
        + n2 * (n2 - 1.0) * (n2 - 1.0) / (plus * plus * plus) * ((n - 1.0) / (n + 1.0)).ln()
        - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / (plus * minus)
        + 8.0 * n4 * (n4 + 1.0) / (plus * minus * minus) * n.ln()
}

/// Share of diffuse light that passes a clear pane of index n, with all internal reflections: the
/// mean of (1 − R)/(1 + R) over both polarizations.
pub fn diffuse_pane(n: f64) -> f64 {
    let passed = |amplitude: f64| {
        let r = amplitude * amplitude;
        (1.0 - r) / (1.0 + r)
    };
    gauss(0.0, 1.0, |c| {
        let inside = (1.0 - (1.0 - c * c) / (n * n)).sqrt();
        let across = (c - n * inside) / (c + n * inside);
        let along = (n * c - inside) / (n * c + inside);
        c * (passed(across) + passed(along))
    })
}
