//! Exact form factors against closed forms, symmetry and the reference table.

use crate::cases::{CaseKind, Question, cases, series};
use crate::polygons::polygon;
use azulejo_factors::analytic::{exchange_area, form_factor, form_factor_fast};
use azulejo_testing::closed_forms::{on_common_edge, opposed};
use azulejo_trace::lambert::mirror_polygon;
use glam::{DQuat, DVec3, dvec3};
use proptest::prelude::*;
use std::f64::consts::PI;

const FLOOR: [DVec3; 4] = [
    dvec3(0., 0., 0.),
    dvec3(1., 0., 0.),
    dvec3(1., 1., 0.),
    dvec3(0., 1., 0.),
];

fn check(p1: &[DVec3], p2: &[DVec3], expected: f64) {
    let f = form_factor(p1, p2);
    assert!(
        (f - expected).abs() <= 1e-12 * expected,
        "{f} is not {expected}"
    );
}

fn rectangle(x: f64, y: f64) -> [DVec3; 4] {
    FLOOR.map(|p| p * dvec3(x, y, 1.0))
}

/// The polygon moved along z and turned to face down.
fn ceiling(polygon: &[DVec3], z: f64) -> Vec<DVec3> {
    polygon.iter().rev().map(|&p| p + z * DVec3::Z).collect()
}

fn c11(x: f64, y: f64) -> f64 {
    opposed(x, y, 1.0)
}

fn c14(w: f64, h: f64) -> f64 {
    on_common_edge(1.0, w, h)
}

#[test]
fn opposed_rectangles() {
    for (x, y) in [(1., 1.), (2., 3.), (0.3, 7.), (0.3, 0.5), (100., 100.)] {
        check(&rectangle(x, y), &ceiling(&rectangle(x, y), 1.0), c11(x, y));
    }
}

#[test]
fn rectangles_with_a_common_edge() {
    for (w, h) in [(1., 1.), (2., 0.5), (0.1, 3.), (5., 0.2), (8., 8.)] {
        let wall = [(0., 0.), (1., 0.), (1., h), (0., h)].map(|(y, z)| dvec3(0., y, z));
        check(&rectangle(w, 1.0), &wall, c14(w, h));
    }
}

#[test]
fn far_apart_keeps_its_digits() {
    let exact = |d: f64| {
        // Opposed unit squares, expanded in 1/d² beyond the distances where C-11 cancels.
        let t = 1.0 / (d * d);
        t / PI * (1.0 - t * (2.0 / 3.0 - t * (17.0 / 30.0 - t * 58.0 / 105.0)))
    };
    // The method changes at 70.7.
    for d in [60.0, 70.0, 71.0, 1e3, 1e5, 1e7] {
        check(&FLOOR, &ceiling(&FLOOR, d), exact(d));
    }
}

#[test]
fn regular_solids() {
    let (a, b, c, d) = (
        dvec3(1., 1., 1.),
        dvec3(1., -1., -1.),
        dvec3(-1., 1., -1.),
        dvec3(-1., -1., 1.),
    );
    check(&[c, b, a], &[d, c, a], 1.0 / 3.0);
    check(&[c, b, a], &[b, d, a], 1.0 / 3.0);
    check(&FLOOR, &ceiling(&FLOOR, 1.0), c11(1.0, 1.0));
}

#[test]
fn wedges_triangles_and_hexagons() {
    // Double contours in 30 digits of unit squares with a common edge (Howell C-16), and of
    // regular polygons of side 1 opposed at distances 1 and 2.
    let wedges = [
        (30.0, 0.61902832309080),
        (60.0, 0.37090532115005),
        (120.0, 0.086615001118276),
        (150.0, 0.021345325412689),
    ];
    for (degrees, expected) in wedges {
        let (sine, cosine) = f64::to_radians(degrees).sin_cos();
        let leaf = FLOOR.map(|p| dvec3(p.x * cosine, p.y, p.x * sine));
        let facing: Vec<DVec3> = leaf.into_iter().rev().collect();
        check(&FLOOR, &facing, expected);
    }
    let regular = |n: u32, radius: f64| -> Vec<DVec3> {
        (0..n)
            .map(|k| {
                DQuat::from_rotation_z(2.0 * PI * f64::from(k) / f64::from(n)) * (radius * DVec3::X)
            })
            .collect()
    };
    let triangle = regular(3, 1.0 / 3_f64.sqrt());
    check(&triangle, &ceiling(&triangle, 1.0), 0.10560582898041);
    let hexagon = regular(6, 1.0);
    check(&hexagon, &ceiling(&hexagon, 2.0), 0.14927498917694);
}

#[test]
fn neighbours_that_cross_each_others_plane() {
    // A wall through the floor counts only above it; standing through its middle, half of it sees.
    let wall = |x: f64, from: f64| {
        [(0., from), (1., from), (1., 1.), (0., 1.)].map(|(y, z)| dvec3(x, y, z))
    };
    check(&FLOOR, &wall(0.0, -1.0), c14(1.0, 1.0));
    check(&FLOOR, &wall(0.5, -1.0), 0.5 * c14(0.5, 1.0));
    // Two walls crossing in a vertical line with all four parts facing into one quarter.
    let cross = [
        dvec3(-1., 0., 0.),
        dvec3(1., 0., 0.),
        dvec3(1., 0., 1.),
        dvec3(-1., 0., 1.),
    ];
    let other = [
        dvec3(0., 1., 0.),
        dvec3(0., -1., 0.),
        dvec3(0., -1., 1.),
        dvec3(0., 1., 1.),
    ];
    check(&cross, &other, 0.5 * c14(1.0, 1.0));
}

#[test]
fn what_sees_nothing_is_exactly_zero() {
    let beside = FLOOR.map(|p| p + DVec3::X);
    let below = FLOOR.map(|p| p - DVec3::Z);
    let mut opposed = FLOOR;
    opposed.reverse();
    for other in [&beside, &below, &FLOOR, &opposed] {
        assert_eq!(form_factor(&FLOOR, other), 0.0);
        assert_eq!(form_factor_fast(&FLOOR, other, 1e-3), 0.0);
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7);
        let turned = |p: &[DVec3; 4]| p.map(|c| turn * c + dvec3(5.0, -80.0, 9.0));
        assert_eq!(form_factor(&turned(&FLOOR), &turned(other)), 0.0);
    }
}

#[test]
fn degenerate_input_is_zero() {
    let up = ceiling(&FLOOR, 1.0);
    let replaced = |p: DVec3| vec![p, up[1], up[2], up[3]];
    let mut cases: Vec<Vec<DVec3>> = [DVec3::NAN, DVec3::INFINITY, f64::NEG_INFINITY * DVec3::X]
        .into_iter()
        .map(replaced)
        .collect();
    cases.extend([
        vec![],
        vec![DVec3::Z],
        vec![DVec3::Z, DVec3::ONE],
        vec![DVec3::Z; 4],
    ]);
    cases.push(vec![
        dvec3(0., 0., 1.),
        dvec3(1., 0., 1.),
        dvec3(0.5, 0., 1.),
    ]);
    for case in &cases {
        for f in [form_factor, exchange_area, |a: &[DVec3], b: &[DVec3]| {
            form_factor_fast(a, b, 1e-2)
        }] {
            assert_eq!(f(&FLOOR, case), 0.0, "{case:?}");
            assert_eq!(f(case, &FLOOR), 0.0, "{case:?}");
        }
    }
    // The form factor is a number, but no area is.
    let huge = |p: &[DVec3]| p.iter().map(|&c| 1e200 * c).collect::<Vec<_>>();
    check(&huge(&FLOOR), &huge(&up), c11(1.0, 1.0));
    assert_eq!(exchange_area(&huge(&FLOOR), &huge(&up)), 0.0);
    for accuracy in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
        let f = form_factor_fast(&FLOOR, &up, accuracy);
        assert!((0.0..=1.0).contains(&f), "{f}");
    }
}

#[test]
fn doubled_corners_and_size_change_nothing() {
    let doubled: Vec<DVec3> = FLOOR.iter().flat_map(|&p| [p, p]).collect();
    let up = ceiling(&FLOOR, 1.0);
    check(&doubled, &up, c11(1.0, 1.0));
    for size in [1e-150, 1e-9, 1e9, 1e150] {
        let scaled = |p: &[DVec3]| p.iter().map(|&c| size * c).collect::<Vec<_>>();
        check(&scaled(&FLOOR), &scaled(&up), c11(1.0, 1.0));
    }
}

/// A rectangle cut into `n` times `n` patches of its winding.
fn patches(corner: DVec3, u: DVec3, v: DVec3, n: u32) -> Vec<[DVec3; 4]> {
    let at = |i: u32, j: u32| corner + (f64::from(i) * u + f64::from(j) * v) / f64::from(n);
    (0..n * n)
        .map(|k| (k / n, k % n))
        .map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])
        .collect()
}

#[test]
fn fast_is_as_good_as_asked() {
    let floor = patches(DVec3::ZERO, DVec3::X, DVec3::Y, 8);
    let wall = patches(DVec3::ZERO, DVec3::Y, 1.3 * DVec3::Z, 8);
    let tilted = patches(
        dvec3(0.2, 1.2, 0.9),
        dvec3(0.1, -0.8, 0.1),
        dvec3(0.9, 0.1, 0.6),
        8,
    );
    for accuracy in [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9] {
        let (mut wrong, mut total) = (0.0, 0.0);
        for (from, to) in floor
            .iter()
            .flat_map(|f| wall.iter().chain(&tilted).map(move |t| (f, t)))
        {
            let exact = form_factor(from, to);
            let error = (form_factor_fast(from, to, accuracy) - exact).abs();
            assert!(
                error <= 30.0 * accuracy * exact + 1e-14,
                "{accuracy}: {error} of {exact}"
            );
            wrong += error;
            total += exact;
        }
        assert!(
            total > 1.0 && wrong <= accuracy * total,
            "{accuracy}: {}",
            wrong / total
        );
    }
}

#[test]
fn slivers_keep_most_digits() {
    for width in [1e-3, 1e-5, 1e-7] {
        let sliver = rectangle(width, 1.0);
        let wall = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(y, z)| dvec3(2.0, 1.0 - y, z));
        // To second order in the width the sliver is its middle line: compare two widths.
        let moved = rectangle(0.5 * width, 1.0).map(|p| p + 0.25 * width * DVec3::X);
        let (whole, half) = (form_factor(&sliver, &wall), form_factor(&moved, &wall));
        assert!(
            (whole - half).abs() < 1e-7 * whole + width * width,
            "{width}: {whole} {half}"
        );
    }
}

#[test]
fn almost_touching_is_almost_touching() {
    // A gap, a turn or an overlap too small to matter must not change the result.
    let wall = |shift: f64, tilt: f64| {
        [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(y, z)| dvec3(shift + tilt * y, y, z))
    };
    for tiny in [1e-15, 1e-13, 1e-11, 1e-9, 1e-7] {
        for (shift, tilt) in [
            (-tiny, 0.0),
            (tiny, 0.0),
            (0.0, tiny),
            (0.0, -tiny),
            (-tiny, tiny),
        ] {
            let f = form_factor(&FLOOR, &wall(shift, tilt));
            let change = (f - c14(1.0, 1.0)).abs();
            assert!(change < 1e-12 + 20.0 * tiny, "{shift} {tilt}: {change}");
        }
    }
}

#[test]
fn truths_of_polygons() {
    let mut checked = 0;
    let cases = cases().into_iter().chain(series());
    for case in cases.filter(|c| c.kind == CaseKind::Polygons) {
        let Question::Factor { from, to } = &case.question else {
            continue;
        };
        let [p1, p2] = [from, to].map(|g| polygon(&case.scene, g.object));
        let off = (form_factor(&p1, &p2) - case.truth.value).abs();
        eprintln!("{:14} {:17} off {off:.1e}", case.id, case.truth.value);
        let most = case.truth.error + 2e-13 * case.truth.value;
        assert!(off <= most, "{}: {off:e} over {most:e}", case.id);
        checked += 1;
    }
    assert_eq!(checked, 67, "cases of two polygons and nothing about them");
}

#[test]
fn a_mirror_wall_by_its_image() {
    // The mirror contains all lines of sight, so the image needs no window.
    let ceiling = ceiling(&FLOOR, 1.0);
    let image = mirror_polygon(&ceiling, DVec3::ZERO, DVec3::X);
    check(
        &FLOOR,
        &image,
        opposed(2.0, 1.0, 1.0) - opposed(1.0, 1.0, 1.0),
    );
}

fn corner() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| dvec3(x, y, z))
}

fn triangle() -> impl Strategy<Value = [DVec3; 3]> {
    [corner(), corner(), corner()]
}

/// The six faces of a box, facing inward.
fn box_faces(size: DVec3) -> Vec<Vec<DVec3>> {
    let face = |u: DVec3, v: DVec3, w: DVec3| {
        let near = [DVec3::ZERO, u, u + v, v];
        [near.to_vec(), near.iter().rev().map(|&p| p + w).collect()]
    };
    let (x, y, z) = (size.x * DVec3::X, size.y * DVec3::Y, size.z * DVec3::Z);
    [face(x, y, z), face(y, z, x), face(z, x, y)].concat()
}

proptest! {
    #[test]
    fn reciprocity(p1 in triangle(), p2 in triangle()) {
        let (there, back) = (exchange_area(&p1, &p2), exchange_area(&p2, &p1));
        prop_assert!((there - back).abs() <= 1e-14 + 1e-12 * there, "{there} {back}");
    }

    #[test]
    fn a_box_is_closed(x in 0.05..5.0, y in 0.05..5.0, z in 0.05..5.0, turn in corner(), shift in corner()) {
        let turn = DQuat::from_scaled_axis(3.0 * turn);
        let place = |face: Vec<DVec3>| face.into_iter().map(|p| turn * p + shift).collect();
        let faces: Vec<Vec<DVec3>> = box_faces(dvec3(x, y, z)).into_iter().map(place).collect();
        for from in &faces {
            let sum: f64 = faces.iter().map(|to| form_factor(from, to)).sum();
            prop_assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        }
    }

    /// However two triangles lie, the parts of one add up to the whole.
    #[test]
    fn parts_add_up(p1 in triangle(), p2 in triangle(), split in 0.1..0.9) {
        let [a, b, c] = p1;
        let middle = a.lerp(b, split);
        let whole = exchange_area(&p1, &p2);
        let parts = exchange_area(&[a, middle, c], &p2) + exchange_area(&[middle, b, c], &p2);
        prop_assert!((whole - parts).abs() <= 1e-13 + 1e-11 * whole, "{whole} {parts}");
    }
}
