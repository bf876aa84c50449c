//! Exact form factors between polygons that nothing hides from each other.
//!
//! [`form_factor`] integrates round both contours and is good to about 1e-13;
//! [`form_factor_fast`] takes the cheapest formula that is good enough. Both cut either polygon at
//! the plane of the other, take concave polygons, and take polygons that touch or cross.
//!
//! A polygon is a slice of corners in one plane, counter-clockwise seen from its front, which is
//! the side that emits and receives. It must not cross itself.

mod contour;
mod quadrature;

use azulejo_scene::math::area_vector;
use azulejo_trace::lambert::{ArrayPolygon, clip, polygon_vector};
use glam::DVec3;
use quadrature::gauss;
use std::f64::consts::PI;

/// Quadrature error of the exact formula.
const EXACT: f64 = 1e-16;
/// Distance over radius beyond which the area integrals replace the contours, which there lose
/// one digit per factor of ten to cancellation.
const REMOTE: f64 = 100.0;

/// Point to point where the radii squared over the distance squared stay below this times the
/// accuracy.
const FAST_FAR: f64 = 0.5;
/// Share of the accuracy left to the choice of points by the ratio of radius to distance.
const FAST_SAFETY: f64 = 0.5;
/// Most points per direction; with more, the contours are cheaper.
const FAST_MOST_POINTS: f64 = 4.0;
/// Share of the accuracy left to each edge pair of the contours.
const FAST_EXACT: f64 = 0.1;

/// Form factor F₁₂ from polygon `p1` to polygon `p2`: the share of the power that leaves the
/// front of p1 diffusely and reaches the front of p2, when nothing stands between.
///
/// In 0..=1. Zero for polygons that lie in one plane, that turn their backs on each other, that
/// have no area, and for coordinates that are not finite. Relative error about 1e-13, on slivers
/// 1e-16 times their length over their width. Takes 2 to 200 microseconds.
///
/// ```
/// use azulejo_radiosity::analytic::form_factor;
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
    Pair::new(p1, p2).map_or(0.0, |pair| {
        pair.share(pair.exact(EXACT)) * area_vector(p1).length()
    })
}

/// Form factor F₁₂ by the cheapest formula of about the relative `accuracy` asked for.
pub fn form_factor_fast(p1: &[DVec3], p2: &[DVec3], accuracy: f64) -> f64 {
    Pair::new(p1, p2).map_or(0.0, |pair| pair.share(pair.fast(accuracy)))
}

/// Two polygons as far as they see each other, moved and scaled to coordinates within 1.
struct Pair {
    p1: Side,
    p2: Side,
    /// Area of the first polygon before it was cut.
    whole_area: f64,
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
        let largest = |p: &[DVec3]| {
            p.iter()
                .map(|c| (c - origin).abs().max_element())
                .fold(0.0, f64::max)
        };
        let scale = largest(p1).max(largest(p2));
        let scaled = |p: &[DVec3]| {
            p.iter()
                .map(|&c| (c - origin) / scale)
                .collect::<ArrayPolygon>()
        };
        let (p1, p2) = (scaled(p1), scaled(p2));
        let finite = |p: &[DVec3]| p.iter().all(|c| c.is_finite());
        if !finite(&p1) || !finite(&p2) {
            return None;
        }
        // The coordinates came rounded, before they were moved to the origin.
        let rounding = 8.0 * f64::EPSILON * (1.0 + origin.abs().max_element() / scale);
        let (a1, a2) = (area_vector(&p1), area_vector(&p2));
        let cut1 = in_front(&p1, &p2, a2, rounding)?;
        let cut2 = in_front(&p2, &p1, a1, rounding)?;
        Some(Pair {
            p1: Side::new(cut1, a1)?,
            p2: Side::new(cut2, a2)?,
            whole_area: a1.length(),
        })
    }

    /// The share of polygon 1's power that an exchange area makes.
    fn share(&self, exchange: f64) -> f64 {
        // Rounding may leave its range; NaN would fail the comparison.
        if exchange > 0.0 {
            (exchange / self.whole_area).min(1.0)
        } else {
            0.0
        }
    }

    fn distance(&self) -> f64 {
        (self.p1.centre - self.p2.centre).length()
    }

    fn exact(&self, tolerance: f64) -> f64 {
        if self.distance() > REMOTE * self.p1.radius.max(self.p2.radius) {
            return self.area_by_area(3);
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
        // Cut as they are, all of one polygon lies above every horizon of the other.
        from.for_each_node(points, |x, weight| {
            vector += weight * polygon_vector(x, &to.polygon)
        });
        vector.dot(from.normal)
    }

    fn fast(&self, accuracy: f64) -> f64 {
        let (small, large) = if self.p1.radius <= self.p2.radius {
            (&self.p1, &self.p2)
        } else {
            (&self.p2, &self.p1)
        };
        let r2 = small.radius.powi(2) + large.radius.powi(2);
        if r2 < FAST_FAR * accuracy * self.distance().powi(2) {
            return small.area
                * large.area
                * kernel(small.centre, small.normal, large.centre, large.normal);
        }
        let ratio = small.radius / large.distance_to_contour(small.centre);
        let points = (FAST_SAFETY * accuracy).ln() / (2.0 * ratio.ln());
        if ratio < 1.0 && points <= FAST_MOST_POINTS {
            Self::points_by_area(small, large, points.ceil().max(1.0) as usize)
        } else {
            self.exact((FAST_EXACT * accuracy).clamp(EXACT, 1e-2))
        }
    }
}

/// Form factor density cos₁ cos₂ / (π r²) between two points.
fn kernel(x: DVec3, normal_x: DVec3, y: DVec3, normal_y: DVec3) -> f64 {
    let r = y - x;
    let squared = r.length_squared();
    -r.dot(normal_x) * r.dot(normal_y) / (PI * squared * squared)
}

impl Side {
    fn new(polygon: ArrayPolygon, whole_area: DVec3) -> Option<Side> {
        let normal = whole_area.normalize();
        let area = area_vector(&polygon).dot(normal);
        let centre = centroid(&polygon, normal, area);
        let radius = polygon
            .iter()
            .map(|c| (c - centre).length())
            .fold(0.0, f64::max);
        (area > 0.0).then_some(Side {
            polygon,
            normal,
            area,
            centre,
            radius,
        })
    }

    /// Hands points and weights, which sum to the area, to `visit`.
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
        let next = self.polygon.iter().cycle().skip(1);
        let edges = self.polygon.iter().zip(next);
        let squared = edges.map(|(&a, &b)| {
            let along = ((point - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            (point - a.lerp(b, along)).length_squared()
        });
        squared.fold(f64::INFINITY, f64::min).sqrt()
    }
}

/// Centre of mass of a polygon, by signed triangles.
fn centroid(polygon: &[DVec3], normal: DVec3, area: f64) -> DVec3 {
    let Some((&first, rest)) = polygon.split_first() else {
        return DVec3::ZERO;
    };
    let moment: DVec3 = rest
        .windows(2)
        .map(|w| (w[0] - first, w[1] - first))
        .map(|(u, v)| u.cross(v).dot(normal) * (u + v))
        .sum();
    first + moment / (6.0 * area)
}

/// The part of `polygon` in front of another, `None` if that is nothing or not beyond rounding.
fn in_front(
    polygon: &[DVec3],
    other: &[DVec3],
    other_area: DVec3,
    rounding: f64,
) -> Option<ArrayPolygon> {
    let normal = other_area.try_normalize()?;
    let height = |c: &DVec3| (c - other[0]).dot(normal);
    // A small polygon's normal is as uncertain as its corners over its size.
    let least = rounding / other_area.length().sqrt();
    polygon
        .iter()
        .any(|c| height(c) > least)
        .then(|| clip(polygon, other[0], normal))
}
