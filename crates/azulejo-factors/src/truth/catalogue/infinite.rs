//! Infinite strips and cylinders: cells between perfect mirrors.

use super::super::builders::{GREY, SceneBuilder};
use super::super::formulas::{
    parallel_cylinders, plane_to_tubes, strip_to_cylinder, strips, strips_at_angle_of,
    strips_of_widths,
};
use super::super::{Case, CaseKind, Truth};
use crate::truth::builders::PERFECT_MIRROR;
use glam::DVec3;

/// The cases of this module.
pub fn cases() -> Vec<Case> {
    [
        opposed_strips(),
        strips_at_angles(),
        strips_and_cylinders(),
        cylinders(),
        tubes(),
    ]
    .concat()
}

fn opposed_strips() -> Vec<Case> {
    let equal = |h: f64| {
        let mut builder = SceneBuilder::default();
        let below = builder.wall((0., 0.), (1., 0.), GREY);
        let above = builder.wall((1., h), (0., h), GREY);
        builder.ends(&[(0., 0.), (1., 0.), (1., h), (0., h)]);
        builder.asks(below, above).case(
            format!("C-1 {h}"),
            "Howell C-1",
            CaseKind::Mirrors,
            format!("infinite opposed strips of width 1 at distance {h}"),
            Truth::formula(strips(1.0, h)),
        )
    };
    let unequal = |w: f64| {
        let mut builder = SceneBuilder::default();
        let below = builder.wall((-0.5, 0.), (0.5, 0.), GREY);
        let half = 0.5 * w;
        let above = builder.wall((half, 1.), (-half, 1.), GREY);
        let most = half.max(0.5);
        builder.ends(&[(-most, 0.), (most, 0.), (most, 1.), (-most, 1.)]);
        builder.asks(below, above).case(
            format!("C-2 {w}"),
            "Howell C-2",
            CaseKind::Mirrors,
            format!("infinite strips of widths 1 and {w}, one over the other at distance 1"),
            Truth::formula(strips_of_widths(1.0, w, 1.0)),
        )
    };
    let equals = [0.2, 0.5, 2.0, 5.0].map(equal);
    let unequals = [0.25, 0.5, 2.0, 6.0].map(unequal);
    equals.into_iter().chain(unequals).collect()
}

fn strips_at_angles() -> Vec<Case> {
    let case = |(degrees, w): (f64, f64)| {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let tip = (w * cos, w * sin);
        let mut builder = SceneBuilder::default();
        let floor = builder.wall((0., 0.), (1., 0.), GREY);
        let wall = builder.wall(tip, (0., 0.), GREY);
        builder.ends(&[(0., 0.), (1., 0.), tip]);
        builder.asks(floor, wall).case(
            format!("strips {degrees} {w}"),
            match (degrees, w) {
                (90.0, _) => "Howell C-3",
                (_, 1.0) => "Howell C-5",
                _ => "crossed strings",
            },
            CaseKind::Mirrors,
            format!("infinite strips of widths 1 and {w} on a common edge at {degrees}°"),
            Truth::formula(strips_at_angle_of(1.0, w, degrees.to_radians())),
        )
    };
    let all = [
        (90.0, 0.25),
        (90.0, 0.5),
        (90.0, 2.0),
        (90.0, 4.0),
        (20.0, 1.0),
        (45.0, 1.0),
        (60.0, 1.0),
        (120.0, 1.0),
        (150.0, 1.0),
        (60.0, 2.0),
        (120.0, 0.5),
    ];
    all.map(case).to_vec()
}

fn strips_and_cylinders() -> Vec<Case> {
    let case = |(a, b, height): (f64, f64, f64)| {
        let mut builder = SceneBuilder::default();
        let strip = builder.wall((a, 0.), (b, 0.), GREY);
        let cylinder = builder.tube(height * DVec3::Y, 0.5, 1.0);
        let (left, right) = (a.min(-0.5), b.max(0.5));
        let top = height + 0.5;
        builder.ends(&[(left, 0.), (right, 0.), (right, top), (left, top)]);
        builder.asks(strip, cylinder).case(
            format!("strip cylinder {a} {b} {height}"),
            "crossed strings",
            CaseKind::Curved,
            format!(
                "infinite strip from {a} to {b} below a parallel cylinder of radius 0.5, whose axis is {height} high"
            ),
            Truth::formula(strip_to_cylinder(a, b, height, 0.5)),
        )
    };
    let all = [(-1.0, 1.0, 1.0), (0.0, 2.0, 1.0), (1.0, 3.0, 0.75)];
    all.map(case).to_vec()
}

fn cylinders() -> Vec<Case> {
    let case = |gap: f64| {
        let mut builder = SceneBuilder::default();
        let x = 1.0 + 0.5 * gap;
        let [left, right] = [-x, x].map(|x| builder.tube(x * DVec3::X, 1.0, 1.0));
        let end = x + 1.0;
        builder.ends(&[(-end, -1.), (end, -1.), (end, 1.), (-end, 1.)]);
        builder.asks(left, right).case(
            format!("cylinders {gap}"),
            "crossed strings",
            CaseKind::Curved,
            format!("infinite parallel cylinders of radius 1, a gap of {gap} between them"),
            Truth::formula(parallel_cylinders(1.0, gap)),
        )
    };
    [0.1, 0.5, 1.0, 5.0].map(case).to_vec()
}

fn tubes() -> Vec<Case> {
    let case = |diameter: f64| {
        let mut builder = SceneBuilder::default();
        let tube = builder.tube(0.5 * DVec3::Y, 0.5 * diameter, 1.0);
        let ground = builder.wall((-0.5, 0.0), (0.5, 0.0), GREY);
        builder.wall((0.5, 1.0), (0.5, 0.0), PERFECT_MIRROR);
        builder.wall((-0.5, 0.0), (-0.5, 1.0), PERFECT_MIRROR);
        builder.ends(&[(-0.5, 0.), (0.5, 0.), (0.5, 1.), (-0.5, 1.)]);
        builder.asks(ground, tube).case(
            format!("tubes {diameter}"),
            "crossed strings",
            CaseKind::Curved,
            format!("infinite plane to a row of cylinders, diameter {diameter} of their spacing"),
            Truth::formula(plane_to_tubes(diameter)),
        )
    };
    [0.2, 0.35, 0.7, 0.9].map(case).to_vec()
}
