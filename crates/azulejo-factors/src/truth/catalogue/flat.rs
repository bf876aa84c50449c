//! Rectangles and elements.

use super::super::builders::{GREY, SceneBuilder, rectangle, square, upright};
use super::super::formulas::{
    double_contour, element_parallel, element_perpendicular, on_common_edge, opposed, parallel,
    perpendicular, wedge,
};
use super::super::polygons::ELEMENT;
use super::super::{Case, CaseKind, Truth};
use glam::{DVec3, dvec3};

/// Relative change of the sum of a formula whose terms cancel.
const CANCELLED: f64 = 1e-11;

const UNIT: [f64; 2] = [0.0, 1.0];

/// The cases of this module.
pub fn cases() -> Vec<Case> {
    [
        opposed_rectangles(),
        coaxial_squares(),
        shifted_rectangles(),
        on_edges(),
        apart_and_square(),
        wedges(),
        tilted(),
        elements(),
    ]
    .concat()
}

fn pair(
    p1: &[DVec3],
    p2: &[DVec3],
    id: String,
    source: &'static str,
    description: String,
    truth: Truth,
) -> Case {
    let mut builder = SceneBuilder::default();
    let (from, to) = (builder.polygon(p1, GREY), builder.polygon(p2, GREY));
    let asked = builder.asks(from, to);
    asked.case(id, source, CaseKind::Polygons, description, truth)
}

fn opposed_rectangles() -> Vec<Case> {
    let case = |(a, b, c): (f64, f64, f64)| {
        let (x, y) = ([0.0, a], [0.0, b]);
        pair(
            &rectangle(x, y, 0.0, true),
            &rectangle(x, y, c, false),
            format!("C-11 {a} {b} {c}"),
            "Howell C-11",
            format!("opposed rectangles {a} × {b} at distance {c}"),
            Truth::formula(opposed(a, b, c)).but_for(CANCELLED),
        )
    };
    let sides = [(1.0, 1.0), (4.0, 1.0)];
    let distances = [0.1, 0.3, 1.0, 3.0];
    let all = sides
        .into_iter()
        .flat_map(|(a, b)| distances.map(|c| (a, b, c)));
    all.filter(|&of| of != (1.0, 1.0, 1.0)).map(case).collect()
}

fn coaxial_squares() -> Vec<Case> {
    let case = |side: f64| {
        let other = [0.5 - 0.5 * side, 0.5 + 0.5 * side];
        let value = parallel(UNIT, UNIT, other, other, 1.0);
        pair(
            &square(0.0, true),
            &rectangle(other, other, 1.0, false),
            format!("C-12 {side}"),
            "Howell C-12",
            format!("coaxial squares of sides 1 and {side} at distance 1"),
            Truth::formula(value).but_for(CANCELLED),
        )
    };
    [0.25, 0.5, 2.0, 8.0].map(case).to_vec()
}

fn shifted_rectangles() -> Vec<Case> {
    let case = |shift: f64| {
        let x = [shift, shift + 1.0];
        let value = parallel(UNIT, UNIT, x, [0.5, 2.0], 1.0);
        pair(
            &square(0.0, true),
            &rectangle(x, [0.5, 2.0], 1.0, false),
            format!("C-13 {shift}"),
            "Howell C-13",
            format!("parallel rectangles at distance 1, shifted by {shift}"),
            Truth::formula(value).but_for(CANCELLED),
        )
    };
    [0.0, 0.5, 1.0, 2.0].map(case).to_vec()
}

fn on_edges() -> Vec<Case> {
    let case = |(edge, depth, height): (f64, f64, f64)| {
        let y = [0.0, edge];
        pair(
            &rectangle([0.0, depth], y, 0.0, true),
            &upright(0.0, y, [0.0, height]),
            format!("C-14 {edge} {depth} {height}"),
            "Howell C-14",
            format!("rectangles at 90° on an edge of {edge}, depth {depth}, height {height}"),
            Truth::formula(on_common_edge(edge, depth, height)),
        )
    };
    let all = [
        (1.0, 1.0, 0.1),
        (1.0, 0.1, 1.0),
        (1.0, 3.0, 3.0),
        (10.0, 1.0, 1.0),
        (0.1, 1.0, 1.0),
    ];
    all.map(case).to_vec()
}

fn apart_and_square() -> Vec<Case> {
    let case = |gap: f64| {
        let value = perpendicular([gap, gap + 1.0], UNIT, [0.5, 2.0], [0.2, 1.0]);
        pair(
            &rectangle([gap, gap + 1.0], UNIT, 0.0, true),
            &upright(0.0, [0.5, 2.0], [0.2, 1.0]),
            format!("C-15 {gap}"),
            "Howell C-15",
            format!("rectangles at 90°, beside each other, {gap} apart"),
            Truth::formula(value).but_for(CANCELLED),
        )
    };
    [0.0, 0.25, 1.0, 4.0].map(case).to_vec()
}

/// The unit square that leaves the y axis at an angle to the floor, facing it.
fn leaf(degrees: f64) -> [DVec3; 4] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [
        dvec3(0., 0., 0.),
        dvec3(0., 1., 0.),
        dvec3(cos, 1., sin),
        dvec3(cos, 0., sin),
    ]
}

fn wedges() -> Vec<Case> {
    let case = |degrees: f64| {
        pair(
            &square(0.0, true),
            &leaf(degrees),
            format!("C-16 {degrees}"),
            "Howell C-16",
            format!("unit squares with a common edge at {degrees}°"),
            Truth::quadrature(wedge(degrees.to_radians())),
        )
    };
    [10.0, 15.0, 20.0, 45.0, 75.0, 90.0, 105.0, 135.0, 165.0]
        .map(case)
        .to_vec()
}

/// Rectangles in planes at an angle, which do not touch.
fn tilted() -> Vec<Case> {
    let case = |degrees: f64| {
        let floor = rectangle([0.4, 1.4], UNIT, 0.0, true);
        let other = leaf(degrees).map(|p| p * 1.5 + 0.25 * DVec3::Y);
        // Away from the common edge.
        let shift = 0.3 * (other[2] - other[1]).normalize();
        let other = other.map(|p| p + shift);
        pair(
            &floor,
            &other,
            format!("C-17 {degrees}"),
            "Howell C-17, double contour integral",
            format!("rectangles in planes at {degrees}°, apart"),
            Truth::quadrature(double_contour(&floor, &other)).but_for(CANCELLED),
        )
    };
    [30.0, 60.0, 90.0, 120.0].map(case).to_vec()
}

fn elements() -> Vec<Case> {
    let case = |id: String, source, description: String, polygon: &[DVec3], value: f64| {
        let mut builder = SceneBuilder::default();
        let element = builder.element(DVec3::ZERO, DVec3::Z);
        let polygon = builder.polygon(polygon, GREY);
        let asked = builder.asks(element, polygon);
        let truth = Truth::formula(value).but_for(ELEMENT);
        asked.case(id, source, CaseKind::Polygons, description, truth)
    };
    let below = |c: f64| {
        case(
            format!("B-3 {c}"),
            "Howell B-3",
            format!("element below the corner of a parallel rectangle 2 × 1 at distance {c}"),
            &rectangle([0.0, 2.0], UNIT, c, false),
            element_parallel(2.0, 1.0, c),
        )
    };
    let beside = |c: f64| {
        let wall = [
            dvec3(c, 0., 0.),
            dvec3(c, 0., 2.),
            dvec3(c, 1., 2.),
            dvec3(c, 1., 0.),
        ];
        case(
            format!("B-4 {c}"),
            "Howell B-4",
            format!("element at 90° to a rectangle 2 high and 1 wide at distance {c}"),
            &wall,
            element_perpendicular(2.0, 1.0, c),
        )
    };
    let distances = [0.25, 1.0, 4.0];
    let lower = distances.map(below);
    lower.into_iter().chain(distances.map(beside)).collect()
}
