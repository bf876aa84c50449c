//! Every formula against another one, or an integral over its surfaces.

use super::*;

fn check(value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value - expected).abs() < tolerance,
        "{value} is not {expected}"
    );
}

/// From the strip 0 to `a` on the x axis to the segment between two points above it, by the angles
/// at which it is seen: the mean of ½ |sin φ₁ − sin φ₂|.
fn strip_to_segment(a: f64, from: [f64; 2], to: [f64; 2]) -> f64 {
    let sine = |[x, y]: [f64; 2], s: f64| (x - s) / (x - s).hypot(y);
    let seen = |s: f64| 0.5 * (sine(from, s) - sine(to, s)).abs();
    // Squares near the common edge: s = a t² there.
    gauss(0.0, 1.0, |t| seen(a * t * t) * 2.0 * t)
}

#[test]
fn strips_by_angles() {
    for (a, b, h) in [(1.0, 0.25, 1.0), (1.0, 6.0, 1.0), (2.0, 1.0, 0.5)] {
        let ends = [[0.5 * (a - b), h], [0.5 * (a + b), h]];
        check(
            strips_of_widths(a, b, h),
            strip_to_segment(a, ends[0], ends[1]),
            1e-9,
        );
    }
    check(strips_of_widths(1.0, 1.0, 0.7), strips(1.0, 0.7), 1e-14);
    for (a, b, degrees) in [(1.0, 0.25, 90.0), (1.0, 2.0, 60.0), (1.0, 0.5, 120.0)] {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        // The strip itself is seen from its end as the direction along it.
        let value = strip_to_segment_from_edge(a, [b * cos, b * sin]);
        check(
            strips_at_angle_of(a, b, f64::to_radians(degrees)),
            value,
            1e-9,
        );
    }
    check(
        strips_at_angle_of(1.0, 1.0, 0.4),
        strips_at_angle(0.4),
        1e-14,
    );
}

/// The same to a segment that begins at the strip's end at 0, which is seen along the strip.
fn strip_to_segment_from_edge(a: f64, tip: [f64; 2]) -> f64 {
    let seen = |s: f64| 0.5 * ((tip[0] - s) / (tip[0] - s).hypot(tip[1]) + 1.0);
    gauss(0.0, 1.0, |t| seen(a * t * t) * 2.0 * t)
}

/// A cylinder is seen between its tangents.
#[test]
fn strips_and_cylinders_by_tangents() {
    for (a, b, h, r) in [(-1.0, 1.0, 1.0, 0.5), (1.0, 3.0, 0.75, 0.5)] {
        let seen = |s: f64| {
            let (middle, half) = ((-s / h).atan(), (r / s.hypot(h)).asin());
            0.5 * ((middle + half).sin() - (middle - half).sin())
        };
        let mean = gauss(0.0, 1.0, |t| seen(a + (b - a) * t));
        check(strip_to_cylinder(a, b, h, r), mean, 1e-9);
    }
}

/// cos cos / π r² over a disk in polar coordinates about its centre.
#[test]
fn elements_and_disks_by_area() {
    let over_disk = |d: f64, h: f64, radius: f64, cosine: &dyn Fn(f64) -> f64| {
        gauss(0.0, radius, |r| {
            let around = |angle: f64| {
                let (x, y) = (d + r * angle.cos(), r * angle.sin());
                let square = x * x + y * y + h * h;
                cosine(x) * h / (PI * square * square) * r
            };
            gauss(0.0, PI, |a| around(a) + around(a + PI))
        })
    };
    for (d, h, r) in [(1.0, 1.0, 0.75), (2.0, 1.0, 0.75), (1.5, 3.0, 0.75)] {
        check(
            element_to_disk_aside(d, h, r),
            over_disk(d, h, r, &|_| h),
            1e-9,
        );
        check(
            element_to_disk_across(d, h, r),
            over_disk(d, h, r, &|x| x),
            1e-9,
        );
    }
    // From a point on the axis, and for the sphere by its solid angle.
    check(element_to_disk_aside(1e-9, 2.0, 1.0), 0.2, 1e-9);
    check(
        sphere_to_disk(1.0, 2.0),
        gauss(0.0, 1.0, |r| TAU * r * 2.0 / (r * r + 4.0).powf(1.5)) / (4.0 * PI),
        1e-12,
    );
}

/// Directions in a cone about the sphere's centre, above the horizon.
#[test]
fn elements_and_spheres_by_directions() {
    for (h, degrees) in [(1.5, 30.0), (1.5, 60.0), (1.5, 90.0), (3.0, 80.0)] {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let half = (1.0f64 / h).asin();
        let value = gauss(0.0, half, |theta| {
            let (s, c) = theta.sin_cos();
            // cos θ cos γ + sin θ sin γ cos φ above 0: between −φ₀ and φ₀.
            let limit = (-(c * cos) / (s * sin).max(1e-300)).clamp(-1.0, 1.0).acos();
            s * 2.0 * (c * cos * limit + s * sin * limit.sin())
        }) / PI;
        check(element_to_unit_sphere(h, cos), value, 2e-5);
    }
}

/// Disks by the element's formula over one of them, cylinders by closure.
#[test]
fn disks_and_cylinders_by_elements() {
    for (r1, r2, h) in [(1.0, 0.25, 1.0), (1.0, 4.0, 1.0), (1.0, 1.0, 3.0)] {
        let mean = gauss(0.0, r1, |r| 2.0 * r * element_to_disk_aside(r, h, r2)) / (r1 * r1);
        check(coaxial_disks(r1, r2, h), mean, 1e-8);
    }
    // From the outer of concentric cylinders to the inner: an infinite one sees r₁/r₂ of it.
    check(outer_to_inner(1.0, 2.0, 1e5), 0.5, 1e-4);
    check(outer_to_itself(1.0, 2.0, 1e5), 0.5, 1e-4);
}

#[track_caller]
fn same(value: f64, expected: f64) {
    check(value, expected, 1e-13 * (1.0 + expected));
}

/// What two formulas say of one pair must agree.
#[test]
fn general_formulas_hold_the_special_ones() {
    same(
        parallel([0.0, 2.0], [0.0, 1.0], [0.0, 2.0], [0.0, 1.0], 0.5),
        opposed(2.0, 1.0, 0.5),
    );
    same(
        perpendicular([0.0, 1.0], [0.0, 2.0], [0.0, 2.0], [0.0, 3.0]),
        on_common_edge(2.0, 1.0, 3.0),
    );
    same(wedge(FRAC_PI_2), on_common_edge(1.0, 1.0, 1.0));
    let up = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let square = [
        up(0.0, 0.0, 0.0),
        up(1.0, 0.0, 0.0),
        up(1.0, 1.0, 0.0),
        up(0.0, 1.0, 0.0),
    ];
    let other = [
        up(0.0, 0.0, 1.0),
        up(0.0, 1.0, 1.0),
        up(1.0, 1.0, 1.0),
        up(1.0, 0.0, 1.0),
    ];
    same(double_contour(&square, &other), opposed(1.0, 1.0, 1.0));
    same(
        element(DVec3::ZERO, DVec3::Z, &other),
        element_parallel(1.0, 1.0, 1.0),
    );
    // Far away a sphere is a disk that faces the element.
    same(
        element_to_unit_sphere(2.0, 0.5),
        element_to_unit_sphere(2.0, 0.5 + 1e-14),
    );
    assert_eq!(element_to_unit_sphere(2.0, -0.5), 0.0);
}

#[test]
fn shares_of_closed_rooms_add_up() {
    same(2.0 * wedge(PI / 3.0) + 2.0 * triangle_ends(), 1.0);
    same(
        opposed(1.0, 1.0, 1.0) + 4.0 * on_common_edge(1.0, 1.0, 1.0),
        1.0,
    );
    same(coaxial_disks(1.0, 1e9, 1.0), 1.0);
}

/// From a side of the equilateral prism of height 1 to one of its ends.
fn triangle_ends() -> f64 {
    // An end sees the other end and three sides; the table's value for the ends.
    let ends = 0.105_605_828_980_41;
    (1.0 - ends) / 3.0 * (0.75f64.sqrt() / 2.0)
}
