//! Exact form factors from a point to a polygon; clipping of polygons to planes and windows; their
//! mirror images.
//!
//! The form factor from a surface element to a polygon is a sum over the polygon's edges (J. H.
//! Lambert, *Photometria*, 1760): F = 1/(2π) Σ γₖ uₖ·n, where γₖ is the angle under which edge k
//! appears and uₖ the unit normal of the plane through it and the element. The angles come from
//! `atan2(|a × b|, a · b)`, which is accurate for small and large angles alike.
//!
//! A polygon is a slice of corners in one plane, counter-clockwise seen from its front; it may be
//! concave but must not cross itself. Points further apart than about 1e150 overflow, and a
//! result that overflows or is not a number is returned as 0.

use azulejo_scene::math::{Frame, area_vector};
use glam::DVec3;
use std::f64::consts::TAU;
use std::ops::Deref;

/// Relative tolerance within which a point counts as lying in a polygon's plane.
const COPLANAR: f64 = 1e-14;

/// Form factor from a surface element at `point` with unit `normal` to `polygon`.
///
/// In 0..=1: the fraction of the element's diffuse light that reaches the front of the polygon if
/// nothing is in between. The part of the polygon below the element's horizon is clipped. Zero if
/// the point lies behind the polygon or in its plane, if the polygon has no area, and for
/// coordinates that are not finite. Relative error about 1e-16 times the distance over the size of
/// the polygon. Takes 80 ns for a small quadrilateral, 130 ns for one that fills the view, 160 ns
/// if the horizon cuts it.
///
/// ```
/// use azulejo_trace::lambert::point_to_polygon;
/// use glam::{DVec3, dvec3};
///
/// let ceiling = [dvec3(0., 0., 1.), dvec3(0., 1., 1.), dvec3(1., 1., 1.), dvec3(1., 0., 1.)];
/// let f = point_to_polygon(DVec3::ZERO, DVec3::Z, &ceiling);
/// assert!((f - 0.138531605994893).abs() < 1e-15);
/// ```
pub fn point_to_polygon(point: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    if !is_in_front(point, polygon) {
        return 0.0;
    }
    let is_above = |&corner: &DVec3| (corner - point).dot(normal) >= 0.0;
    // Most polygons lie entirely above the horizon, and clipping would double the cost.
    let vector = if polygon.iter().all(is_above) {
        contour_sum(point, polygon)
    } else {
        contour_sum(point, &clip(polygon, point, normal))
    };
    let f = vector.dot(normal);
    // Rounding may take the sum slightly outside of its range; NaN fails the comparison.
    if f > 0.0 && f.is_finite() {
        f.min(1.0)
    } else {
        0.0
    }
}

/// Irradiance vector at `point` due to a `polygon` with an exitance of 1, without a horizon.
///
/// Its product with a unit normal n is the form factor from an element with that normal, provided
/// the whole polygon lies above the element's horizon, so one vector serves several normals. It is
/// signed: it points towards a polygon that faces the point, away from one that faces away, and is
/// zero within rounding for a point in the polygon's plane but outside it. Not clamped; zero if the
/// coordinates are not finite.
pub fn polygon_vector(point: DVec3, polygon: &[DVec3]) -> DVec3 {
    let vector = contour_sum(point, polygon);
    if vector.is_finite() {
        vector
    } else {
        DVec3::ZERO
    }
}

/// Solid angle of a polygon, seen from a point outside of it, sr; zero if the coordinates are not finite.
///
/// Van Oosterom and Strackee, *The solid angle of a plane triangle*, 1983.
pub fn solid_angle(point: DVec3, polygon: &[DVec3]) -> f64 {
    let toward = |corner: &DVec3| (*corner - point).normalize_or_zero();
    let Some((first, rest)) = polygon.split_first() else {
        return 0.0;
    };
    let (a, mut sum) = (toward(first), 0.0);
    for edge in rest.windows(2) {
        let [b, c] = [toward(&edge[0]), toward(&edge[1])];
        sum += 2.0 * f64::atan2(a.dot(b.cross(c)), 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
    }
    if sum.is_finite() { sum.abs() } else { 0.0 }
}

/// Whether `point` lies on the front side of the plane of `polygon`, by more than rounding.
///
/// False for a polygon without area and for coordinates that are not finite.
pub fn is_in_front(point: DVec3, polygon: &[DVec3]) -> bool {
    let Some(&first) = polygon.first() else {
        return false;
    };
    let area = area_vector(polygon);
    let away = point - first;
    let height = away.dot(area);
    height > 0.0
        && height * height > COPLANAR * COPLANAR * away.length_squared() * area.length_squared()
}

/// Lambert's sum around a closed contour, divided by 2π.
fn contour_sum(point: DVec3, contour: &[DVec3]) -> DVec3 {
    let Some(&last) = contour.last() else {
        return DVec3::ZERO;
    };
    let (mut a, mut sum) = (last - point, DVec3::ZERO);
    for &corner in contour {
        let b = corner - point;
        sum += edge_vector(a, b);
        a = b;
    }
    sum / TAU
}

/// γ u of the edge from `a` to `b`, both relative to the element: polygons that face the element
/// have positive sums.
fn edge_vector(a: DVec3, b: DVec3) -> DVec3 {
    // a × (b - a) rather than a × b: far away, the product of two long vectors loses digits.
    let cross = (b - a).cross(a);
    cross * angle_over_sine(cross.length_squared(), a.dot(b))
}

/// γ / |a × b| for the angle γ between a and b, from |a × b|² and a · b.
///
/// Zero for an edge collinear with the element, which spans no plane and contributes nothing.
fn angle_over_sine(sine_squared: f64, cosine: f64) -> f64 {
    let t = sine_squared / (cosine * cosine);
    if t < 1.0 / 64.0 && cosine > 0.0 {
        // Small polygons are the common case; the series of atan is exact here and twice as fast.
        return SMALL_ANGLE.iter().rev().fold(0.0, |sum, c| sum * t + c) / cosine;
    }
    let sine = sine_squared.sqrt();
    if sine == 0.0 {
        0.0
    } else {
        sine.atan2(cosine) / sine
    }
}

/// Coefficients of atan(x)/x in powers of x²; the first omitted term is 3e-18 at x = 1/8.
const SMALL_ANGLE: [f64; 9] = [
    1.0,
    -1.0 / 3.0,
    1.0 / 5.0,
    -1.0 / 7.0,
    1.0 / 9.0,
    -1.0 / 11.0,
    1.0 / 13.0,
    -1.0 / 15.0,
    1.0 / 17.0,
];

/// The part of `polygon` on the side of a plane that `plane_normal` (any length) points to.
///
/// Sutherland and Hodgman 1974. Corners in the plane are kept; a polygon that only touches the
/// plane yields an empty one or, within rounding, a sliver. A concave polygon that is cut into
/// several parts remains one contour, its parts joined by coincident opposite edges in the plane,
/// which cancel in every contour integral. Corners with NaN are left out.
pub fn clip(polygon: &[DVec3], plane_point: DVec3, plane_normal: DVec3) -> ArrayPolygon {
    let height = |p: DVec3| (p - plane_point).dot(plane_normal);
    let mut clipped = ArrayPolygon::default();
    let Some(&last) = polygon.last() else {
        return clipped;
    };
    let (mut a, mut height_a) = (last, height(last));
    let mut highest = height_a;
    for &b in polygon {
        let height_b = height(b);
        // Always from the inner end to the outer one, so that neighbours with a common edge agree.
        if height_a > 0.0 && height_b < 0.0 {
            clipped.push(a.lerp(b, height_a / (height_a - height_b)));
        } else if height_a < 0.0 && height_b > 0.0 {
            clipped.push(b.lerp(a, height_b / (height_b - height_a)));
        }
        if height_b >= 0.0 {
            clipped.push(b);
        }
        (a, height_a, highest) = (b, height_b, highest.max(height_b));
    }
    if highest > 0.0 {
        clipped
    } else {
        ArrayPolygon::default()
    }
}

/// The part of `polygon` that is visible from the viewpoint `eye` through a convex `window`.
///
/// That is the part inside the pyramid from the viewpoint through the window's edges and beyond the
/// window's plane. Either side of the window may face the viewpoint. Empty if the viewpoint lies in
/// the window's plane within rounding, so that the window is seen edge-on, or if the window has no
/// area.
pub fn clip_to_window(polygon: &[DVec3], eye: DVec3, window: &[DVec3]) -> ArrayPolygon {
    let front = is_in_front(eye, window);
    let back = !front && is_in_back(eye, window);
    if !front && !back {
        return ArrayPolygon::default();
    }
    let outward = area_vector(window);
    // The edges of a window that faces the viewpoint are counter-clockwise about the reversed line
    // of sight; the sign makes all planes of the pyramid face inwards.
    let sign = if front { -1.0 } else { 1.0 };
    let mut seen = clip(polygon, window[0], sign * outward);
    for (k, &a) in window.iter().enumerate() {
        let b = window[(k + 1) % window.len()];
        // Relative to a, not to the viewpoint: the rounding of a viewpoint close to the window then
        // cancels.
        seen = clip(&seen, a, sign * (a - eye).cross(b - a));
    }
    seen
}

/// Whether `point` lies behind the plane of `polygon`, by more than rounding.
fn is_in_back(point: DVec3, polygon: &[DVec3]) -> bool {
    // The mirror image of the point in the first corner lies on the other side.
    polygon
        .first()
        .is_some_and(|&first| is_in_front(2.0 * first - point, polygon))
}

/// The mirror image of `point` in a plane; `plane_normal` of any length but zero.
///
/// A zero normal defines no plane and leaves the point unchanged.
pub fn mirror_point(point: DVec3, plane_point: DVec3, plane_normal: DVec3) -> DVec3 {
    let squared = plane_normal.length_squared();
    if squared > 0.0 {
        point - plane_normal * (2.0 * (point - plane_point).dot(plane_normal) / squared)
    } else {
        point
    }
}

/// The mirror image of `polygon` in a plane, as a polygon of the mirrored world.
///
/// The order of the corners is reversed, because a mirror reverses the winding: the front of the
/// image is the image of the front.
pub fn mirror_polygon(polygon: &[DVec3], plane_point: DVec3, plane_normal: DVec3) -> ArrayPolygon {
    let image = |&p: &DVec3| mirror_point(p, plane_point, plane_normal);
    polygon.iter().rev().map(image).collect()
}

/// Rounding of the points of a hull, relative to their extent.
const HULL_ROUNDING: f64 = 1e-12;

/// Smallest turn at each corner of a hull, relative to its sides.
const HULL_TURN: f64 = 1e-9;

/// The convex hull of points in a plane, counter-clockwise about its unit `normal`, without
/// collinear corners. Andrew, *Another efficient algorithm for convex hulls in two dimensions*,
/// 1979.
pub fn convex_hull(points: impl Iterator<Item = DVec3>, normal: DVec3) -> ArrayPolygon {
    let frame = Frame::from_normal(normal);
    let mut corners: Vec<(DVec3, DVec3)> = points.map(|p| (frame.to_local(p), p)).collect();
    let reach = |p: &(DVec3, DVec3)| p.0.truncate().abs().max_element();
    // Rounded, and without negative zeros, so that corners with the same abscissa are sorted as
    // such.
    let cell = HULL_ROUNDING * corners.iter().map(reach).fold(f64::MIN_POSITIVE, f64::max);
    for (p, _) in &mut corners {
        *p = (*p / cell).round() * cell + DVec3::ZERO;
    }
    corners.sort_by(|(p, _), (q, _)| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    // Andrew's monotone chain: the lower hull from left to right, then the upper one from right to
    // left.
    let half = |ring: &mut Vec<(DVec3, DVec3)>, start: usize, p: (DVec3, DVec3)| {
        let is_corner = |ring: &[(DVec3, DVec3)]| {
            let [.., (q, _), (r, _)] = ring else {
                return true;
            };
            // Points that coincide or are collinear within rounding are not corners.
            (*r - *q).cross(p.0 - *r).z > HULL_TURN * p.0.distance_squared(*q)
        };
        while ring.len() > start + 1 && !is_corner(ring) {
            ring.pop();
        }
        ring.push(p);
    };
    let mut ring = Vec::with_capacity(corners.len() + 1);
    corners.iter().for_each(|&p| half(&mut ring, 0, p));
    let start = ring.len().saturating_sub(1);
    let back = corners.iter().rev().skip(1);
    back.for_each(|&p| half(&mut ring, start, p));
    ring.pop();
    ring.into_iter().map(|(_, p)| p).collect()
}

/// A polygon stored inline up to [`ArrayPolygon::INLINE`] corners, beyond that on the heap.
#[derive(Clone, Debug)]
pub struct ArrayPolygon {
    inline: [DVec3; ArrayPolygon::INLINE],
    len: usize,
    /// Holds all corners once they exceed `inline`; empty until then.
    spilled: Vec<DVec3>,
}

impl ArrayPolygon {
    /// Corners that need no allocation: a quadrilateral clipped by twelve planes.
    pub const INLINE: usize = 16;

    /// Appends a corner.
    pub fn push(&mut self, corner: DVec3) {
        if self.len < Self::INLINE {
            self.inline[self.len] = corner;
        } else {
            if self.spilled.is_empty() {
                self.spilled.extend(self.inline);
            }
            self.spilled.push(corner);
        }
        self.len += 1;
    }
}

impl Default for ArrayPolygon {
    fn default() -> Self {
        ArrayPolygon {
            inline: [DVec3::ZERO; Self::INLINE],
            len: 0,
            spilled: Vec::new(),
        }
    }
}

impl Deref for ArrayPolygon {
    type Target = [DVec3];

    fn deref(&self) -> &[DVec3] {
        if self.len <= Self::INLINE {
            &self.inline[..self.len]
        } else {
            &self.spilled
        }
    }
}

impl FromIterator<DVec3> for ArrayPolygon {
    fn from_iter<I: IntoIterator<Item = DVec3>>(corners: I) -> Self {
        let mut polygon = ArrayPolygon::default();
        for corner in corners {
            polygon.push(corner);
        }
        polygon
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;
    use proptest::prelude::*;

    #[test]
    fn hulls_have_no_corner_twice() {
        let points = [
            (-0.0, 1.0),
            (0.0, 0.0),
            (1.0, 0.0),
            (0.5, 0.0),
            (1.0, 1.0),
            (0.0, 0.0),
        ];
        let points = points.map(|(x, y)| dvec3(x, y, 2.0));
        for way in [DVec3::Z, -DVec3::Z] {
            let hull = convex_hull(points.into_iter(), way);
            assert_eq!(hull.len(), 4);
            assert!((area_vector(&hull).dot(way) - 1.0).abs() < 1e-15);
        }
    }

    const ABOVE: [DVec3; 4] = [
        dvec3(0., 0., 1.),
        dvec3(0., 1., 1.),
        dvec3(1., 1., 1.),
        dvec3(1., 0., 1.),
    ];

    fn check(point: DVec3, normal: DVec3, polygon: &[DVec3], expected: f64) {
        let f = point_to_polygon(point, normal, polygon);
        assert!((f - expected).abs() < 1e-15, "{f} is not {expected}");
    }

    #[test]
    fn howell_b3_and_b4() {
        check(DVec3::ZERO, DVec3::Z, &ABOVE, 0.138531605994893);
        let wall = [
            dvec3(1., 0., 0.),
            dvec3(1., 0., 1.),
            dvec3(1., 1., 1.),
            dvec3(1., 1., 0.),
        ];
        check(DVec3::ZERO, DVec3::Z, &wall, 0.0557341970025535);
    }

    #[test]
    fn the_horizon_cuts() {
        // A wall that extends as far below the horizon as above it.
        let wall = [
            dvec3(1., 0., -1.),
            dvec3(1., 0., 1.),
            dvec3(1., 1., 1.),
            dvec3(1., 1., -1.),
        ];
        check(DVec3::ZERO, DVec3::Z, &wall, 0.0557341970025535);
        check(DVec3::ZERO, -DVec3::Z, &wall, 0.0557341970025535);
        check(DVec3::ZERO, -DVec3::Z, &ABOVE, 0.0);
    }

    #[test]
    fn behind_beside_or_degenerate_is_exactly_zero() {
        for point in [
            dvec3(0.5, 0.5, 1.0),
            dvec3(2.0, 0.5, 1.0),
            dvec3(0.5, 0.5, 2.0),
            ABOVE[1],
        ] {
            for normal in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z] {
                assert_eq!(point_to_polygon(point, normal, &ABOVE), 0.0);
            }
        }
        let bad = |p: DVec3| [p, ABOVE[1], ABOVE[2], ABOVE[3]];
        for polygon in [
            bad(DVec3::NAN),
            bad(DVec3::INFINITY),
            bad(1e200 * DVec3::Z),
            [DVec3::Z; 4],
        ] {
            assert_eq!(point_to_polygon(DVec3::ZERO, DVec3::Z, &polygon), 0.0);
        }
        assert_eq!(point_to_polygon(DVec3::ZERO, DVec3::Z, &[]), 0.0);
        assert_eq!(point_to_polygon(DVec3::ZERO, DVec3::Z, &ABOVE[..2]), 0.0);
        assert_eq!(polygon_vector(DVec3::ZERO, &bad(DVec3::NAN)), DVec3::ZERO);
    }

    #[test]
    fn small_angles_agree_with_the_arc_tangent() {
        for k in 0..1000 {
            let angle = f64::from(k) * 2e-4;
            let (sine, cosine) = (3.0 * angle.sin(), 3.0 * angle.cos());
            let ratio = angle_over_sine(sine * sine, cosine);
            assert!((ratio * sine - angle).abs() <= 1e-15 * angle, "{angle}");
        }
    }

    #[test]
    fn a_polygon_all_round_fills_the_hemisphere() {
        let r = 1e6;
        let sky = [
            dvec3(-r, -r, 1.),
            dvec3(-r, r, 1.),
            dvec3(r, r, 1.),
            dvec3(r, -r, 1.),
        ];
        let f = point_to_polygon(DVec3::ZERO, DVec3::Z, &sky);
        assert!((f - 1.0).abs() < 1e-11 && f <= 1.0);
    }

    #[test]
    fn concave_is_the_sum_of_its_parts() {
        let l = [(0., 0.), (0., 2.), (1., 2.), (1., 1.), (2., 1.), (2., 0.)]
            .map(|(x, y)| dvec3(x, y, 1.));
        let a = [(0., 0.), (0., 2.), (1., 2.), (1., 0.)].map(|(x, y)| dvec3(x, y, 1.));
        let b = [(1., 0.), (1., 1.), (2., 1.), (2., 0.)].map(|(x, y)| dvec3(x, y, 1.));
        let point = dvec3(1.7, 1.8, 0.2);
        for normal in [
            DVec3::Z,
            DVec3::X,
            -DVec3::Y,
            dvec3(-0.6, 0.0, 0.8),
            dvec3(-0.48, -0.64, 0.6),
        ] {
            let parts = point_to_polygon(point, normal, &a) + point_to_polygon(point, normal, &b);
            check(point, normal, &l, parts);
        }
    }

    #[test]
    fn a_window_of_either_side_clips_alike() {
        let big = ABOVE.map(|p| dvec3(8.0 * p.x - 4.0, 8.0 * p.y - 4.0, 2.0));
        let eye = dvec3(0.4, 0.3, 0.0);
        let mut window = ABOVE;
        // At twice the distance of the window and with four times its area it covers the same solid
        // angle.
        for _side in 0..2 {
            let seen = clip_to_window(&big, eye, &window);
            assert!((area_vector(&seen).length() - 4.0).abs() < 1e-14);
            let through = point_to_polygon(eye, DVec3::Z, &seen);
            check(eye, DVec3::Z, &ABOVE, through);
            window.reverse();
        }
        assert!(clip_to_window(&big, dvec3(3.0, 0.5, 1.0), &window).is_empty());
        assert!(clip_to_window(&big, dvec3(0.5, 0.5, 3.0), &window).is_empty());
        assert!(clip_to_window(&big, eye, &window[..2]).is_empty());
    }

    #[test]
    fn an_eye_close_to_the_window_sees_nearly_everything_beyond() {
        let far = ABOVE.map(|p| p + 9.0 * DVec3::Z);
        for gap in [1e-3, 1e-6, 1e-9, 1e-12] {
            let seen = clip_to_window(&far, dvec3(0.5, 0.5, 1.0 - gap), &ABOVE);
            assert!((area_vector(&seen).length() - 1.0).abs() < 1e-12, "{gap}");
        }
    }

    #[test]
    fn images_keep_their_front() {
        let plane = (dvec3(2.0, 0.0, 0.0), dvec3(-3.0, 0.0, 0.0));
        let image = mirror_polygon(&ABOVE, plane.0, plane.1);
        let eye = dvec3(0.3, 0.2, 0.1);
        let image_eye = mirror_point(eye, plane.0, plane.1);
        assert!((image_eye - dvec3(3.7, 0.2, 0.1)).length() < 1e-15);
        check(
            image_eye,
            DVec3::Z,
            &image,
            point_to_polygon(eye, DVec3::Z, &ABOVE),
        );
        assert_eq!(mirror_point(eye, plane.0, DVec3::ZERO), eye);
    }

    #[test]
    fn many_corners_spill() {
        let circle: ArrayPolygon = (0..40)
            .map(|k| f64::from(-k) * TAU / 40.0)
            .map(|a| dvec3(a.cos(), a.sin(), 1.0))
            .collect();
        assert_eq!(circle.len(), 40);
        let half = clip(&circle, DVec3::ZERO, DVec3::X);
        let whole = area_vector(&circle).length();
        assert!((area_vector(&half).length() - 0.5 * whole).abs() < 1e-14);
    }

    fn point() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| dvec3(x, y, z))
    }

    proptest! {
        /// The form factors from an element inside a tetrahedron to its four faces sum to 1.
        #[test]
        fn closure(corners in [point(), point(), point(), point()], n in point(), w in [0.05..1.0, 0.05..1.0, 0.05..1.0, 0.05..1.0]) {
            let [a, b, c, d] = corners;
            let volume = (b - a).cross(c - a).dot(d - a);
            prop_assume!(volume.abs() > 1e-3 && n.length() > 1e-3);
            let (b, c) = if volume > 0.0 { (b, c) } else { (c, b) };
            let eye = (w[0] * a + w[1] * b + w[2] * c + w[3] * d) / w.iter().sum::<f64>();
            let sum: f64 = [[a, b, c], [a, c, d], [a, d, b], [b, d, c]]
                .iter()
                .map(|face| point_to_polygon(eye, n.normalize(), face))
                .sum();
            prop_assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        }
    }
}
