//! Disks, finite cylinders, spheres, and elements before them.

use super::super::builders::{GREY, SceneBuilder};
use super::super::formulas::{
    coaxial_disks, element_to_disk_across, element_to_disk_aside, element_to_unit_sphere,
    outer_to_inner, outer_to_itself, sphere_to_disk, unit_spheres,
};
use super::super::polygons::ELEMENT;
use super::super::{Case, CaseKind, Truth};
use glam::{DVec3, dvec3};

/// The cases of this module.
pub fn cases() -> Vec<Case> {
    [
        disks(),
        closed_cylinders(),
        concentric_cylinders(),
        spheres(),
        elements_and_spheres(),
        elements_and_disks(),
    ]
    .concat()
}

fn disks() -> Vec<Case> {
    let case = |(r1, r2, h): (f64, f64, f64)| {
        let mut builder = SceneBuilder::default();
        let from = builder.disk(DVec3::ZERO, r1, true);
        let to = builder.disk(h * DVec3::Z, r2, false);
        builder.asks(from, to).case(
            format!("disks {r1} {r2} {h}"),
            if r1 == r2 {
                "Howell C-40"
            } else {
                "Howell C-41"
            },
            CaseKind::Curved,
            format!("coaxial disks of radius {r1} and {r2} at distance {h}"),
            Truth::formula(coaxial_disks(r1, r2, h)),
        )
    };
    let all = [
        (1.0, 1.0, 0.25),
        (1.0, 1.0, 3.0),
        (1.0, 0.25, 1.0),
        (1.0, 4.0, 1.0),
        (0.25, 1.0, 0.5),
        (1.0, 2.0, 6.0),
    ];
    all.map(case).to_vec()
}

fn closed_cylinders() -> Vec<Case> {
    let case = |height: f64| {
        let mut builder = SceneBuilder::default();
        let body = builder.cylinder(DVec3::ZERO, 1.0, height).inside();
        let (base, wall) = (body.clone().face(1), body.face(0));
        builder.asks(base, wall).case(
            format!("cylinder {height}"),
            "1 − Howell C-40",
            CaseKind::Curved,
            format!("closed cylinder of radius 1 and height {height}, base to wall"),
            Truth::formula(1.0 - coaxial_disks(1.0, 1.0, height)),
        )
    };
    [0.25, 1.0, 4.0].map(case).to_vec()
}

fn concentric_cylinders() -> Vec<Case> {
    let case = |(radius, length, is_inner): (f64, f64, bool)| {
        let mut builder = SceneBuilder::default();
        let inner = builder.tube(DVec3::ZERO, 1.0, length);
        let outer = builder.tube(DVec3::ZERO, radius, length).inside();
        let (to, source, words, value) = if is_inner {
            let value = outer_to_inner(1.0, radius, length);
            (inner, "Howell C-91", "inner", value)
        } else {
            let value = outer_to_itself(1.0, radius, length);
            (outer.clone(), "Howell C-92", "itself", value)
        };
        builder.asks(outer, to).case(
            format!("cylinders {radius} {length} {words}"),
            source,
            CaseKind::Curved,
            format!(
                "concentric cylinders of radius 1 and {radius}, length {length}, outer to {words}"
            ),
            Truth::formula(value).but_for(1e-11),
        )
    };
    let shapes = [(1.5, 1.0), (2.0, 8.0), (4.0, 2.0)];
    let both = shapes
        .into_iter()
        .flat_map(|(r, l)| [true, false].map(|inner| (r, l, inner)));
    both.map(case).collect()
}

fn spheres() -> Vec<Case> {
    let apart = |distance: f64| {
        let mut builder = SceneBuilder::default();
        let [left, right] = [0.0, distance].map(|x| builder.sphere(x * DVec3::X, 1.0, GREY));
        builder.asks(left, right).case(
            format!("spheres {distance}"),
            "element to sphere, integrated",
            CaseKind::Curved,
            format!("unit spheres, centres {distance} apart"),
            Truth::quadrature(unit_spheres(distance)).but_for(1e-10),
        )
    };
    let with_disk = |height: f64| {
        let mut builder = SceneBuilder::default();
        let sphere = builder.sphere(DVec3::ZERO, 0.5, GREY);
        let disk = builder.disk(height * DVec3::Z, 1.0, false);
        builder.asks(sphere, disk).case(
            format!("sphere disk {height}"),
            "solid angle / 4π",
            CaseKind::Curved,
            format!("sphere to a coaxial disk of radius 1, {height} from its centre"),
            Truth::formula(sphere_to_disk(1.0, height)),
        )
    };
    let apart = [2.5, 4.0, 10.0].map(apart);
    apart
        .into_iter()
        .chain([0.6, 1.0, 5.0].map(with_disk))
        .collect()
}

fn elements_and_spheres() -> Vec<Case> {
    let case = |(distance, degrees): (f64, f64)| {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let mut builder = SceneBuilder::default();
        let element = builder.element(DVec3::ZERO, dvec3(sin, 0.0, cos));
        let sphere = builder.sphere(distance * DVec3::Z, 1.0, GREY);
        builder.asks(element, sphere).case(
            format!("B-43 {distance} {degrees}"),
            "Howell B-43",
            CaseKind::Curved,
            format!(
                "element {distance} from the centre of a unit sphere, {degrees}° away from facing it"
            ),
            Truth::formula(element_to_unit_sphere(distance, cos)).but_for(2.0 * ELEMENT),
        )
    };
    let all = [
        (1.5, 30.0),
        (1.5, 60.0),
        (1.5, 90.0),
        (3.0, 45.0),
        (3.0, 80.0),
    ];
    all.map(case).to_vec()
}

fn elements_and_disks() -> Vec<Case> {
    let case = |(distance, height, is_across): (f64, f64, bool)| {
        let mut builder = SceneBuilder::default();
        let normal = if is_across { DVec3::X } else { DVec3::Z };
        let element = builder.element(DVec3::ZERO, normal);
        let disk = builder.disk(dvec3(distance, 0.0, height), 0.75, false);
        let (words, value) = if is_across {
            let value = element_to_disk_across(distance, height, 0.75);
            ("at 90° to its plane", value)
        } else {
            let value = element_to_disk_aside(distance, height, 0.75);
            ("parallel to it", value)
        };
        let kind = if is_across { "across" } else { "aside" };
        builder.asks(element, disk).case(
            format!("element disk {kind} {distance} {height}"),
            "closed form",
            CaseKind::Curved,
            format!(
                "element to a disk of radius 0.75, {words}, {distance} from its axis and {height} below it"
            ),
            Truth::formula(value).but_for(2.0 * ELEMENT),
        )
    };
    let places = [(1.0, 1.0), (2.0, 1.0), (1.5, 3.0)];
    let both = places
        .into_iter()
        .flat_map(|(d, h)| [true, false].map(|across| (d, h, across)));
    both.map(case).collect()
}
