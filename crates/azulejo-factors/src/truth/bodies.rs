//! Curved bodies: exact disks, cylinders and spheres.

use super::builders::*;
use super::formulas::*;
use super::polygons::ELEMENT;
use super::{Case, CaseKind, Truth};
use glam::{DVec3, dvec3};

/// The cases of this module.
pub fn cases() -> Vec<Case> {
    [disks(), cylinders(), spheres(), elements(), infinite()].concat()
}

fn disks() -> Vec<Case> {
    let case = |id, r1: f64, r2: f64, h: f64| {
        let mut builder = SceneBuilder::default();
        let from = builder.disk(DVec3::ZERO, r1, true);
        let to = builder.disk(h * DVec3::Z, r2, false);
        let description = format!("coaxial disks of radius {r1} and {r2} at distance {h}");
        let truth = Truth::formula(coaxial_disks(r1, r2, h));
        builder
            .asks(from, to)
            .case(id, "Howell C-41", CaseKind::Curved, description, truth)
    };
    let mut builder = SceneBuilder::default();
    let from = builder.disk(DVec3::ZERO, 1.0, true);
    let to = builder.disk(DVec3::Z, 1.0, false);
    builder.polygon(&round(0.5, 0.5), GREY);
    let truth = Truth::constant(0.210755517, 9, "visible chords, integrated over both radii");
    let description = "coaxial unit disks at distance 1, a disk of half their radius between them";
    vec![
        case("disk_1_1_1", 1.0, 1.0, 1.0),
        case("disk_1_2_1", 1.0, 2.0, 1.0),
        case("disk_2_1_5", 2.0, 1.0, 5.0),
        builder.asks(from, to).case(
            "occ_disk",
            "visible part",
            CaseKind::Curved,
            description,
            truth.but_for(ROUND),
        ),
    ]
}

/// A polygonal disk: a regular polygon of the same area. What it covers differs by the fourth power
/// of its angle, because its outline lies as much outside as inside.
fn round(radius: f64, height: f64) -> Vec<DVec3> {
    const CORNERS: u32 = 128;
    let step = std::f64::consts::TAU / f64::from(CORNERS);
    let outer = radius * (step / step.sin()).sqrt();
    let corner = |k: u32| {
        let (sin, cos) = (step * f64::from(k)).sin_cos();
        dvec3(outer * cos, outer * sin, height)
    };
    (0..CORNERS).map(corner).collect()
}

/// Relative change by the polygon in the place of a disk.
const ROUND: f64 = 1e-7;

fn cylinders() -> Vec<Case> {
    let closed = |id, source, description: &str, from, to, value: f64| {
        let mut builder = SceneBuilder::default();
        let body = builder.cylinder(DVec3::ZERO, 1.0, 2.0).inside();
        let (from, to) = (body.clone().face(from), body.face(to));
        builder.asks(from, to).case(
            id,
            source,
            CaseKind::Curved,
            description,
            Truth::formula(value),
        )
    };
    let concentric = |id, source, description: &str, to: usize, value: f64| {
        let mut builder = SceneBuilder::default();
        let inner = builder.tube(DVec3::ZERO, 1.0, 2.0);
        let outer = builder.tube(DVec3::ZERO, 2.0, 2.0).inside();
        let groups = [inner, outer];
        builder.asks(groups[1].clone(), groups[to].clone()).case(
            id,
            source,
            CaseKind::Curved,
            description,
            Truth::formula(value),
        )
    };
    let base_to_wall = 1.0 - coaxial_disks(1.0, 1.0, 2.0);
    vec![
        closed(
            "cyl_base_wall",
            "1 − Howell C-41",
            "closed cylinder of radius 1 and height 2, base to wall",
            1,
            0,
            base_to_wall,
        ),
        closed(
            "cyl_wall_wall",
            "reciprocity",
            "closed cylinder of radius 1 and height 2, wall to itself",
            0,
            0,
            // The wall has four times the area of a base, and there are two of these.
            1.0 - 0.5 * base_to_wall,
        ),
        concentric(
            "cyl_finite_21",
            "Howell C-91",
            "concentric cylinders of radius 1 and 2, length 2, outer to inner",
            0,
            outer_to_inner(1.0, 2.0, 2.0),
        ),
        concentric(
            "cyl_finite_22",
            "Howell C-92",
            "concentric cylinders of radius 1 and 2, length 2, outer to itself",
            1,
            outer_to_itself(1.0, 2.0, 2.0),
        ),
    ]
}

fn spheres() -> Vec<Case> {
    let mut nested = SceneBuilder::default();
    nested.sphere(DVec3::ZERO, 1.0, GREY);
    let outer = nested.sphere(DVec3::ZERO, 2.0, GREY).inside();
    let mut under_disk = SceneBuilder::default();
    let below_disk = under_disk.sphere(DVec3::ZERO, 0.5, GREY);
    let disk = under_disk.disk(2.0 * DVec3::Z, 1.0, false);
    let mut under_square = SceneBuilder::default();
    let below_square = under_square.sphere(DVec3::ZERO, 0.5, GREY);
    let square = under_square.polygon(&square(1.0, false), GREY);
    let mut two = SceneBuilder::default();
    let spheres = [0.0, 3.0].map(|x| two.sphere(x * DVec3::X, 1.0, GREY));
    let [left, right] = spheres;
    vec![
        nested.asks(outer.clone(), outer).case(
            "spheres",
            "1 − (r₁/r₂)²",
            CaseKind::Curved,
            "concentric spheres of radius 1 and 2, outer to itself",
            Truth::formula(0.75),
        ),
        under_disk.asks(below_disk, disk).case(
            "sphere_disk",
            "solid angle / 4π",
            CaseKind::Curved,
            "sphere to a coaxial disk of radius 1, 2 from its centre",
            Truth::formula(0.5 * (1.0 - 2.0 / 5f64.sqrt())),
        ),
        under_square.asks(below_square, square).case(
            "sphere_rect",
            "solid angle / 4π",
            CaseKind::Curved,
            "sphere to a unit square, a corner of which stands 1 over its centre",
            Truth::formula(1.0 / 24.0),
        ),
        two.asks(left, right).case(
            "sphere_sphere",
            "Howell B-43, integrated",
            CaseKind::Curved,
            "unit spheres, centres 3 apart",
            Truth::quadrature(unit_spheres(3.0)).but_for(1e-11),
        ),
    ]
}

fn elements() -> Vec<Case> {
    let mut stages = [SceneBuilder::default(), SceneBuilder::default()];
    let [before_sphere, before_disk] = stages.each_mut().map(|s| s.element(DVec3::ZERO, DVec3::Z));
    let [mut facing_sphere, mut facing_disk] = stages;
    let sphere = facing_sphere.sphere(2.0 * DVec3::Z, 1.0, GREY);
    let disk = facing_disk.disk(2.0 * DVec3::Z, 1.0, false);
    vec![
        facing_sphere.asks(before_sphere, sphere).case(
            "dA_sphere",
            "(r/h)²",
            CaseKind::Curved,
            "element that faces a unit sphere, 2 from its centre",
            Truth::formula(0.25).but_for(ELEMENT),
        ),
        facing_disk.asks(before_disk, disk).case(
            "dA_disk",
            "r²/(r² + h²)",
            CaseKind::Curved,
            "element that faces a coaxial unit disk at distance 2",
            Truth::formula(0.2).but_for(ELEMENT),
        ),
    ]
}

/// Cells between perfect mirrors.
fn infinite() -> Vec<Case> {
    let mut coaxial = SceneBuilder::default();
    coaxial.tube(DVec3::ZERO, 1.0, 1.0);
    let outer = coaxial.tube(DVec3::ZERO, 3.0, 1.0).inside();
    coaxial.ends(&[(-3., -3.), (3., -3.), (3., 3.), (-3., 3.)]);
    let mut beside = SceneBuilder::default();
    let [left, right] = [-2.0, 2.0].map(|x| beside.tube(x * DVec3::X, 1.0, 1.0));
    // No light between the two leaves this rectangle.
    beside.ends(&[(-3., -1.), (3., -1.), (3., 1.), (-3., 1.)]);
    let mut row = SceneBuilder::default();
    let tube = row.tube(0.5 * DVec3::Y, 0.25, 1.0);
    let ground = row.wall((-0.5, 0.0), (0.5, 0.0), GREY);
    row.wall((0.5, 1.0), (0.5, 0.0), PERFECT_MIRROR);
    row.wall((-0.5, 0.0), (-0.5, 1.0), PERFECT_MIRROR);
    row.ends(&[(-0.5, 0.), (0.5, 0.), (0.5, 1.), (-0.5, 1.)]);
    vec![
        coaxial.asks(outer.clone(), outer).case(
            "cyl_inf",
            "1 − r₁/r₂",
            CaseKind::Curved,
            "infinite concentric cylinders of radius 1 and 3, outer to itself",
            Truth::formula(2.0 / 3.0),
        ),
        beside.asks(left, right).case(
            "two_cyl",
            "crossed strings",
            CaseKind::Curved,
            "infinite parallel cylinders of radius 1, a gap of 2 between them",
            Truth::formula(parallel_cylinders(1.0, 2.0)),
        ),
        row.asks(ground, tube).case(
            "plane_tubes",
            "crossed strings",
            CaseKind::Curved,
            "infinite plane to a row of cylinders of half their spacing",
            Truth::formula(plane_to_tubes(0.5)),
        ),
    ]
}
