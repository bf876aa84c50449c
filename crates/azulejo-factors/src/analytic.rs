//! Exact form factors between polygons.
//!
//! [`form_factor`] integrates along both contours and is good to about 1e-13; [`form_factor_fast`]
//! picks the cheapest formula that is accurate enough; [`visible_form_factor`] accounts for
//! occluders, and [`mirrored_form_factor`] follows planar mirrors. All clip either polygon at the
//! plane of the other, accept concave polygons, and accept polygons that touch or cross.
//!
//! A polygon is a slice of corners in one plane, counter-clockwise seen from its front, which is
//! the side that emits and receives. It must not cross itself.

mod blocker;
mod cells;
mod contour;
mod discontinuities;
mod mirrored;
mod occluded;
mod quadrature;
mod shadow;

use azulejo_scene::math::area_vector;
use azulejo_trace::lambert::{ArrayPolygon, clip, polygon_vector};
pub(crate) use blocker::{Blocker, Effect, PLANE, edge_bit};
pub(crate) use cells::integrate as integrate_cells;
use glam::DVec3;
pub(crate) use mirrored::Chain;
pub use mirrored::mirrored_form_factor;
pub(crate) use occluded::exchange_area_past;
pub use occluded::visible_form_factor;
pub(crate) use quadrature::gauss;
use std::f64::consts::PI;

/// Quadrature error of the exact formula.
const EXACT: f64 = 1e-16;
/// Distance over radius beyond which area integrals replace the contours, which lose one digit per
/// factor of ten to cancellation there.
const REMOTE: f64 = 100.0;

/// Radius of the smaller polygon over its distance from the contour of the larger one, below which Gauss points
/// on it replace the contours: those lose two digits per factor of ten to cancellation, and four points
/// are good to rounding here.
const SMALL: f64 = 0.01;

/// Point to point is used while the squared radii over the squared distance stay below this times
/// the accuracy.
const FAST_FAR: f64 = 0.5;
/// Share of the accuracy allotted to choosing the number of points from radius over distance.
const FAST_SAFETY: f64 = 0.5;
/// Most points per direction; with more, the contours are cheaper.
const FAST_MOST_POINTS: f64 = 4.0;
/// Share of the accuracy allotted to each pair of edges of the contours.
const FAST_EXACT: f64 = 0.1;

/// A number with an estimate of its error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Approximate {
    /// The number.
    pub value: f64,
    /// Estimate of its absolute error.
    pub error: f64,
}

/// Form factor F₁₂ from polygon `p1` to polygon `p2`: the share of the power that leaves the
/// front of p1 diffusely and reaches the front of p2, when nothing stands between.
///
/// In 0..=1. Zero for polygons that lie in one plane, that turn their backs on each other, that
/// have no area, and for coordinates that are not finite. Relative error about 1e-13, but not
/// less than 1e-15 of the larger polygon's area if they touch at a grazing angle; on slivers
/// 1e-16 times their length over their width. Two quadrilaterals take 1 to 10 microseconds where
/// they touch along a common edge or face each other, 25 where they touch at odd angles.
///
/// ```
/// use azulejo_factors::analytic::form_factor;
/// use glam::dvec3;
///
/// let floor = [dvec3(0., 0., 0.), dvec3(1., 0., 0.), dvec3(1., 1., 0.), dvec3(0., 1., 0.)];
/// let wall = [dvec3(0., 0., 0.), dvec3(0., 1., 0.), dvec3(0., 1., 1.), dvec3(0., 0., 1.)];
/// assert!((form_factor(&floor, &wall) - 0.20004377607540).abs() < 1e-14);
/// ```
pub fn form_factor(p1: &[DVec3], p2: &[DVec3]) -> f64 {
    Pair::new(p1, p2).map_or(0.0, |pair| pair.share(pair.exact(EXACT)))
}

/// Exchange area A₁F₁₂ = A₂F₂₁ in square length units; conditions and errors of [`form_factor`].
pub fn exchange_area(p1: &[DVec3], p2: &[DVec3]) -> f64 {
    let Some(pair) = Pair::new(p1, p2) else {
        return 0.0;
    };
    let area = pair.share(pair.exact(EXACT)) * pair.whole_area * pair.scale * pair.scale;
    if area.is_finite() { area } else { 0.0 }
}

/// Form factor F₁₂ by the cheapest formula of about the requested relative `accuracy`.
///
/// Point to point far away, Lambert's formula from 4 to 16 points at middle distances, the double
/// contour close by. Sums over many pairs keep well within `accuracy`, and so do about 99 of 100
/// pairs. The rest see each other at grazing angles and contribute little; their error may be some
/// ten times as large. Zero in the cases where [`form_factor`] is.
///
/// Measured between the 600 patches of a cube, 10 by 10 on a face:
///
/// | `accuracy` | time per pair | sum of errors in a row | 99 of 100 within | worst |
/// | --- | --- | --- | --- | --- |
/// | 1e-1 | 0.28 μs | 3e-3 | 3e-2 | 3e-2 |
/// | 1e-2 | 0.85 μs | 5e-4 | 4e-3 | 4e-3 |
/// | 1e-3 | 1.0 μs | 8e-6 | 1e-4 | 4e-4 |
/// | 1e-4 | 1.2 μs | 8e-7 | 2e-5 | 6e-5 |
/// | 1e-6 | 1.6 μs | 1e-8 | 4e-7 | 6e-6 |
/// | 1e-8 | 1.8 μs | 5e-10 | 2e-8 | 7e-8 |
/// | [`form_factor`] | 2 to 3 μs | 1e-15 | | |
pub fn form_factor_fast(p1: &[DVec3], p2: &[DVec3], accuracy: f64) -> f64 {
    point_to_point(p1, p2, accuracy)
        .unwrap_or_else(|| Pair::new(p1, p2).map_or(0.0, |pair| pair.share(pair.fast(accuracy))))
}

/// Exchange area A₁F₁₂ as [`form_factor_fast`] computes it.
pub(crate) fn exchange_area_fast(p1: &[DVec3], p2: &[DVec3], accuracy: f64) -> f64 {
    let Some(pair) = Pair::new(p1, p2) else {
        return 0.0;
    };
    let area = pair.fast(accuracy) * pair.scale * pair.scale;
    let is_area = area > 0.0 && area.is_finite();
    if is_area { area } else { 0.0 }
}

/// The form factor with both polygons replaced by their centroids, where that is accurate enough:
/// both clearly in front of each other, and far apart.
fn point_to_point(p1: &[DVec3], p2: &[DVec3], accuracy: f64) -> Option<f64> {
    let (a1, a2) = (area_vector(p1), area_vector(p2));
    let (c1, c2) = (centroid(p1, a1)?, centroid(p2, a2)?);
    let r = c2 - c1;
    let squared = r.length_squared();
    let radii = radius_squared(p1, c1) + radius_squared(p2, c2);
    let rises = |to: &[DVec3], from: DVec3, normal: DVec3| {
        let least = 1e-6 * (squared * normal.length_squared()).sqrt();
        to.iter().all(|&c| (c - from).dot(normal) > least)
    };
    // Written so that NaN and overflow take the careful branch.
    let is_far = radii < FAST_FAR * accuracy * squared && rises(p2, c1, a1) && rises(p1, c2, a2);
    let f = -r.dot(a1) * r.dot(a2) / (PI * squared * squared * a1.length());
    (is_far && f.is_normal()).then_some(f)
}

/// Two polygons clipped to what they see of each other, moved and scaled to coordinates within 1.
struct Pair {
    p1: Side,
    p2: Side,
    plane1: PolygonPlane,
    plane2: PolygonPlane,
    /// Rounding error of the coordinates.
    rounding: f64,
    /// The origin of these coordinates in the caller's.
    origin: DVec3,
    /// Area of the first polygon before it was cut, in square units of `scale`.
    whole_area: f64,
    /// The length of one unit in the caller's coordinates.
    scale: f64,
}

struct Side {
    polygon: ArrayPolygon,
    normal: DVec3,
    area: f64,
    centre: DVec3,
    radius: f64,
}

impl Pair {
    /// `None` if no point of one polygon sees a point of the other, or there is no polygon.
    fn new(p1: &[DVec3], p2: &[DVec3]) -> Option<Pair> {
        let origin = *p1.first()?;
        let reaches = p1
            .iter()
            .chain(p2)
            .map(|c| (c - origin).abs().max_element());
        let scale = reaches.fold(0.0, f64::max);
        let [p1, p2] = [p1, p2].map(|p| scaled(p, origin, scale));
        if !p1.iter().chain(p2.iter()).all(|c| c.is_finite()) {
            return None;
        }
        // The coordinates were rounded before they were moved to the origin.
        let rounding = 8.0 * f64::EPSILON * (1.0 + origin.abs().max_element() / scale);
        let plane1 = PolygonPlane::new(&p1, rounding)?;
        let plane2 = PolygonPlane::new(&p2, rounding)?;
        Some(Pair {
            p1: Side::new(plane2.cut(p1)?, plane1.normal)?,
            p2: Side::new(plane1.cut(p2)?, plane2.normal)?,
            whole_area: plane1.area,
            plane1,
            plane2,
            rounding,
            origin,
            scale,
        })
    }

    /// The share of polygon 1's power that an exchange area stands for.
    fn share(&self, exchange: f64) -> f64 {
        // Rounding may leave 0..=1; NaN would fail the comparison.
        if exchange > 0.0 {
            (exchange / self.whole_area).min(1.0)
        } else {
            0.0
        }
    }

    fn small_and_large(&self) -> (&Side, &Side) {
        if self.p1.radius <= self.p2.radius {
            (&self.p1, &self.p2)
        } else {
            (&self.p2, &self.p1)
        }
    }

    fn distance(&self) -> f64 {
        (self.p1.centre - self.p2.centre).length()
    }

    fn exact(&self, tolerance: f64) -> f64 {
        if self.distance() > REMOTE * self.p1.radius.max(self.p2.radius) {
            return self.area_by_area(3);
        }
        let (small, large) = self.small_and_large();
        let ratio = small.radius / large.distance_to_contour(small.centre);
        if ratio < SMALL {
            let points = EXACT.ln() / (2.0 * ratio.ln());
            return Self::points_by_area(small, large, points.ceil().max(1.0) as usize);
        }
        contour::exchange_area(&self.p1.polygon, &self.p2.polygon, tolerance)
    }

    /// Gauss points on both polygons, `points` squared per quadrilateral.
    fn area_by_area(&self, points: usize) -> f64 {
        let (from, to) = (&self.p1, &self.p2);
        let mut sum = 0.0;
        from.for_each_node(points, |x, weight_x| {
            to.for_each_node(points, |y, weight_y| {
                sum += weight_x * weight_y * kernel(x, from.normal, y, to.normal);
            });
        });
        sum
    }

    /// Lambert's formula from `points` squared Gauss points per quadrilateral of one polygon.
    fn points_by_area(from: &Side, to: &Side, points: usize) -> f64 {
        let mut vector = DVec3::ZERO;
        // Clipped as they are, all of one polygon lies above every horizon of the other.
        from.for_each_node(points, |x, weight| {
            vector += weight * polygon_vector(x, &to.polygon)
        });
        vector.dot(from.normal)
    }

    fn fast(&self, accuracy: f64) -> f64 {
        let (small, large) = self.small_and_large();
        let ratio = small.radius / large.distance_to_contour(small.centre);
        let points = (FAST_SAFETY * accuracy).ln() / (2.0 * ratio.ln());
        if ratio < 1.0 && points <= FAST_MOST_POINTS {
            Self::points_by_area(small, large, points.ceil().max(1.0) as usize)
        } else {
            self.exact((FAST_EXACT * accuracy).clamp(EXACT, 1e-2))
        }
    }
}

/// A polygon in coordinates from `origin`, in units of `scale`.
fn scaled(polygon: &[DVec3], origin: DVec3, scale: f64) -> ArrayPolygon {
    polygon.iter().map(|&c| (c - origin) / scale).collect()
}

/// Form factor density cos₁ cos₂ / (π r²) between two points.
fn kernel(x: DVec3, normal_x: DVec3, y: DVec3, normal_y: DVec3) -> f64 {
    let r = y - x;
    let squared = r.length_squared();
    -r.dot(normal_x) * r.dot(normal_y) / (PI * squared * squared)
}

impl Side {
    fn new(polygon: ArrayPolygon, normal: DVec3) -> Option<Side> {
        let area = area_vector(&polygon).dot(normal);
        let centre = centroid(&polygon, area * normal)?;
        let radius = radius_squared(&polygon, centre).sqrt();
        (area > 0.0).then_some(Side {
            polygon,
            normal,
            area,
            centre,
            radius,
        })
    }

    /// Passes points and weights, which sum to the area, to `visit`.
    ///
    /// One point is the centroid. More lie in the quadrilaterals of a fan, each the bilinear image
    /// of the square; where the polygon is concave, the weights of folded parts are negative and
    /// the sum is still right.
    fn for_each_node(&self, points: usize, mut visit: impl FnMut(DVec3, f64)) {
        if points == 1 {
            return visit(self.centre, self.area);
        }
        let rule = gauss(points);
        let a = self.polygon[0];
        for k in (1..self.polygon.len() - 1).step_by(2) {
            let (b, c) = (self.polygon[k], self.polygon[k + 1]);
            let d = self.polygon.get(k + 2).copied().unwrap_or(c);
            let (ab, ad, twist) = (b - a, d - a, a - b + c - d);
            for &(u, weight_u) in rule {
                for &(v, weight_v) in rule {
                    let jacobian = (ab + v * twist).cross(ad + u * twist).dot(self.normal);
                    visit(
                        a + u * ab + v * ad + u * v * twist,
                        weight_u * weight_v * jacobian,
                    );
                }
            }
        }
    }

    fn distance_to_contour(&self, point: DVec3) -> f64 {
        let squared = edges(&self.polygon).map(|(a, b)| {
            let along = ((point - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            (point - a.lerp(b, along)).length_squared()
        });
        squared.fold(f64::INFINITY, f64::min).sqrt()
    }
}

/// Centre of mass of a polygon, by signed triangles; `None` if it has no area.
fn centroid(polygon: &[DVec3], area_vector: DVec3) -> Option<DVec3> {
    let (&first, rest) = polygon.split_first()?;
    let moment: DVec3 = rest
        .windows(2)
        .map(|w| (w[0] - first, w[1] - first))
        .map(|(u, v)| u.cross(v).dot(area_vector) * (u + v))
        .sum();
    let centre = first + moment / (6.0 * area_vector.length_squared());
    centre.is_finite().then_some(centre)
}

/// Square of the distance of the corner furthest from `centre`.
fn radius_squared(polygon: &[DVec3], centre: DVec3) -> f64 {
    polygon
        .iter()
        .map(|c| (c - centre).length_squared())
        .fold(0.0, f64::max)
}

/// The lowest and the highest of some numbers.
fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    })
}

/// The edges of a polygon, from each corner to the next.
fn edges(polygon: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().copied().zip(next.copied())
}

/// The plane of a polygon.
struct PolygonPlane {
    point: DVec3,
    normal: DVec3,
    area: f64,
    /// Height above the plane that is within rounding.
    rounding: f64,
}

impl PolygonPlane {
    fn new(polygon: &[DVec3], rounding: f64) -> Option<PolygonPlane> {
        let area_vector = area_vector(polygon);
        let area = area_vector.length();
        let normal = area_vector / area;
        // A small polygon's normal is as uncertain as its corners over its size.
        let rounding = rounding / area.sqrt();
        normal.is_finite().then_some(PolygonPlane {
            point: *polygon.first()?,
            normal,
            area,
            rounding,
        })
    }

    /// The part of `polygon` in front; `None` if that is empty or within rounding.
    fn cut(&self, polygon: ArrayPolygon) -> Option<ArrayPolygon> {
        let heights = polygon.iter().map(|&c| (c - self.point).dot(self.normal));
        let (lowest, highest) = extremes(heights);
        if highest <= self.rounding {
            None
        } else if lowest >= 0.0 {
            Some(polygon)
        } else {
            Some(clip(&polygon, self.point, self.normal))
        }
    }
}
