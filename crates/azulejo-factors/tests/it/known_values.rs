//! The cases with known answers: what their files say is what formulas say.

use crate::cases::{Case, Truth, cases, series};
use crate::polygons::polygon;
use azulejo_testing::closed_forms::*;
use glam::{DVec3, dvec3};
use std::collections::HashSet;
use std::f64::consts::{FRAC_PI_2, PI};

/// Relative difference by the small squares in the place of elements, and by the polygon in that of a disk.
const SIMPLIFIED: f64 = 2e-7;

/// Relative rounding of formulas whose terms cancel.
const CANCELLED: f64 = 1e-11;

const UNIT: Span = [0.0, 1.0];

#[test]
fn truths_are_what_formulas_say() {
    let constants = ["occ_centre", "occ_low", "occ_fin", "occ_disk", "mir_window"];
    for case in cases().iter().chain(&series()) {
        let Some(value) = formula(case) else {
            assert!(constants.contains(&&*case.id), "{}", case.id);
            assert!(case.truth.error >= half_of_last_digit(&case.truth));
            continue;
        };
        let off = (case.truth.value - value).abs();
        let most = case.truth.error.min(CANCELLED * value);
        assert!(off <= most, "{}: {value}, not {:?}", case.id, case.truth);
    }
}

#[test]
fn cases_are_complete_and_named_once() {
    let (cases, series) = (cases(), series());
    assert_eq!((cases.len(), series.len()), (68, 105));
    let both = || cases.iter().chain(&series);
    let ids: HashSet<&str> = both().map(|c| &*c.id).collect();
    assert_eq!(ids.len(), 68 + 105);
    for case in both() {
        let valid = case.scene.validate();
        valid.unwrap_or_else(|e| panic!("{}: {e:?}", case.id));
        assert!(
            case.truth.value > 0.0 && case.truth.error > 0.0,
            "{}",
            case.id
        );
        let most = SIMPLIFIED * case.truth.value;
        assert!(case.truth.error < most, "{}: {:?}", case.id, case.truth);
        assert!(!case.description.is_empty() && !case.source.is_empty());
    }
    for number in [1, 2, 3, 5, 11, 12, 13, 14, 15, 16, 17] {
        let numbers = |case: &Case| {
            let words = case.source.split([' ', ',']);
            words.map(str::to_owned).collect::<Vec<_>>()
        };
        let is_there = both().any(|case| numbers(case).contains(&format!("C-{number}")));
        assert!(is_there, "C-{number}");
    }
}

fn half_of_last_digit(truth: &Truth) -> f64 {
    let first = truth.value.log10().floor() as i32;
    let digits = truth.digits.expect("constants say their digits") as i32;
    0.5 * 10f64.powi(first + 1 - digits)
}

/// The name of a case without its numbers, and these; `0p5` is 0.5.
fn words_and_numbers(id: &str) -> (String, Vec<f64>) {
    let (mut words, mut numbers) = (Vec::new(), Vec::new());
    for word in id.split([' ', '_']) {
        let is_number = word.starts_with(|c: char| c.is_ascii_digit() || c == '-');
        match word.replace('p', ".").parse() {
            Ok(number) if is_number => numbers.push(number),
            _ => words.push(word),
        }
    }
    (words.join(" "), numbers)
}

/// What formulas say of a case; `None` for numbers from elsewhere.
fn formula(case: &Case) -> Option<f64> {
    let (words, numbers) = words_and_numbers(&case.id);
    let polygon_value = || double_contour(&polygon(&case.scene, 0), &polygon(&case.scene, 1));
    let (words, numbers) = (&*words, &numbers[..]);
    let mut values = [
        flat_pair_value(words, numbers),
        body_value(words, numbers),
        mirror_value(words, numbers),
        system_value(words),
        matches!(words, "tri par" | "hex par" | "tri skew" | "C-17").then(polygon_value),
    ]
    .into_iter()
    .flatten();
    let value = values.next();
    assert!(values.next().is_none(), "{} is in two tables", case.id);
    value
}

fn flat_pair_value(words: &str, numbers: &[f64]) -> Option<f64> {
    let beside = |x: Span, eta, zeta| perpendicular(x, UNIT, eta, zeta);
    Some(match (words, numbers) {
        ("par" | "C-11", &[a, b, c]) => opposed(a, b, c),
        ("perp" | "C-14", &[edge, depth, height]) => on_common_edge(edge, depth, height),
        ("wedge" | "C-16", &[degrees]) => wedge(degrees.to_radians()),
        ("par coax", _) => parallel(UNIT, UNIT, [-1.0, 2.0], [-1.0, 2.0], 1.0),
        ("par offset", _) => parallel(UNIT, UNIT, [2.0, 4.0], [1.0, 2.0], 1.5),
        ("perp offset", _) => beside([1.0, 2.0], [2.0, 4.0], [0.5, 2.0]),
        ("horizon", _) => beside([0.5, 1.5], [-0.5, 1.5], UNIT),
        ("C-12", &[side]) => {
            let other = [0.5 - 0.5 * side, 0.5 + 0.5 * side];
            parallel(UNIT, UNIT, other, other, 1.0)
        }
        ("C-13", &[shift]) => parallel(UNIT, UNIT, [shift, shift + 1.0], [0.5, 2.0], 1.0),
        ("C-15", &[gap]) => beside([gap, gap + 1.0], [0.5, 2.0], [0.2, 1.0]),
        ("tetra", _) => 1.0 / 3.0,
        ("L shape", _) => {
            // Two rectangles make the L; each contributes its share of the area.
            let (two, upper) = ([0.0, 2.0], [1.0, 2.0]);
            let lower = 2.0 * parallel(two, UNIT, two, two, 1.0);
            (lower + parallel(UNIT, upper, two, two, 1.0)) / 3.0
        }
        ("occ view3d", _) => 0.75 * opposed(1.0, 1.0, 1.0),
        ("dA rect par", _) => element_parallel(1.0, 1.0, 1.0),
        ("dA rect perp", _) => element_perpendicular(1.0, 1.0, 1.0),
        ("dA horizon", _) => {
            let [a, b] = [dvec3(1.0, -1.0, 0.0), dvec3(2.0, 2.0, 0.0)];
            let up = 2.0 * DVec3::Z;
            element(DVec3::ZERO, DVec3::Z, &[a, a + up, b + up, b])
        }
        ("B-3", &[distance]) => element_parallel(2.0, 1.0, distance),
        ("B-4", &[distance]) => element_perpendicular(2.0, 1.0, distance),
        _ => return None,
    })
}

fn body_value(words: &str, numbers: &[f64]) -> Option<f64> {
    let base_to_wall = |height| 1.0 - coaxial_disks(1.0, 1.0, height);
    Some(match (words, numbers) {
        ("disk" | "disks", &[r1, r2, h]) => coaxial_disks(r1, r2, h),
        ("cyl base wall", _) => base_to_wall(2.0),
        // The wall has four times the area of a base, and there are two of these.
        ("cyl wall wall", _) => 1.0 - 0.5 * base_to_wall(2.0),
        ("cylinder", &[height]) => base_to_wall(height),
        ("cyl finite", [21.0]) => outer_to_inner(1.0, 2.0, 2.0),
        ("cyl finite", [22.0]) => outer_to_itself(1.0, 2.0, 2.0),
        ("cylinders inner", &[radius, length]) => outer_to_inner(1.0, radius, length),
        ("cylinders itself", &[radius, length]) => outer_to_itself(1.0, radius, length),
        ("cyl inf", _) => 2.0 / 3.0,
        ("two cyl", _) => parallel_cylinders(1.0, 2.0),
        ("cylinders", &[gap]) => parallel_cylinders(1.0, gap),
        ("plane tubes", _) => plane_to_tubes(0.5),
        ("tubes", &[diameter]) => plane_to_tubes(diameter),
        ("strip cylinder", &[a, b, height]) => strip_to_cylinder(a, b, height, 0.5),
        ("spheres", []) => 0.75,
        ("spheres", &[distance]) => unit_spheres(distance),
        ("sphere sphere", _) => unit_spheres(3.0),
        ("sphere disk", []) => sphere_to_disk(1.0, 2.0),
        ("sphere disk", &[height]) => sphere_to_disk(1.0, height),
        ("sphere rect", _) => 1.0 / 24.0,
        ("dA sphere", _) => 0.25,
        ("dA disk", _) => 0.2,
        ("B-43", &[distance, degrees]) => {
            element_to_unit_sphere(distance, degrees.to_radians().cos())
        }
        ("element disk aside", &[d, h]) => element_to_disk_aside(d, h, 0.75),
        ("element disk across", &[d, h]) => element_to_disk_across(d, h, 0.75),
        _ => return None,
    })
}

fn mirror_value(words: &str, numbers: &[f64]) -> Option<f64> {
    let (once, twice) = (opposed(1.0, 1.0, 1.0), opposed(2.0, 1.0, 1.0));
    Some(match (words, numbers) {
        ("strips", []) | ("corridor", [1.0]) => strips(1.0, 1.0),
        ("C-1", &[height]) => strips(1.0, height),
        ("C-2", &[width]) => strips_of_widths(1.0, width, 1.0),
        ("strips", &[degrees, width]) => strips_at_angle_of(1.0, width, degrees.to_radians()),
        // The mirror of the wedge of 45° shows a strip itself at 90°.
        ("wedge inf" | "wedge45 mir", _) => strips_at_angle(FRAC_PI_2),
        ("prism mir", _) => 0.5 * 3f64.sqrt(),
        ("mir cube", _) => twice,
        ("cube mirror F", _) => once + 0.9 * (twice - once),
        ("mir corner", _) => 0.9 * parallel(UNIT, UNIT, [1.5, 2.5], UNIT, 2.0),
        ("corridor", &[reflectance]) => {
            // The k-th image of the ceiling is shifted by k and seen after k reflections.
            let image = |k: u32| {
                let shift = f64::from(k);
                let shifted = parallel(UNIT, UNIT, [shift, shift + 1.0], UNIT, 1.0);
                reflectance.powi(k as i32) * shifted
            };
            image(0) + 2.0 * (1..400).map(image).sum::<f64>()
        }
        ("fresnel ext", &[index]) => diffuse_fresnel(index),
        ("fresnel int", &[index]) => 1.0 - (1.0 - diffuse_fresnel(index)) / (index * index),
        ("pane", &[index]) => diffuse_pane(index),
        _ => return None,
    })
}

fn system_value(words: &str) -> Option<f64> {
    let rho = [0.5, 0.7, 0.3, 0.3, 0.6, 0.6];
    let floor = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    Some(match words {
        "furnace" => 1.0 / (1.0 - 0.5),
        "furnace spec" => 1.0 + 0.5 / (1.0 - 0.5 - 0.3),
        "plates" => 1.0 / (1.0 - 0.2 * 0.6),
        // Spheres of radius 1 and 2, emissivities 0.8 and 0.4.
        "shell diffuse" => 1.0 / (1.0 / 0.8 + 0.25 * (1.0 / 0.4 - 1.0)),
        "shell specular" => 1.0 / (1.0 / 0.8 + 1.0 / 0.4 - 1.0),
        "cube box" => radiosities(floor, rho, |i, j| cube_factor(i, j, 0.0))[1],
        "cube mirror B" => {
            // The mirror has no radiosity.
            let rho = [rho[0], rho[1], 0.0, rho[3], rho[4], rho[5]];
            radiosities(floor, rho, |i, j| cube_factor(i, j, 0.9))[1]
        }
        // Any part of a sphere receives the share of its area.
        "sphere encl" => 0.8 * 0.1 / (1.0 - 0.1 * 0.2 - 0.3 * 0.5 - 0.6 * 0.8),
        "prism mir B" => {
            let own = 0.8 * strips_at_angle(PI * 2.0 / 3.0);
            let other = 0.5 + 0.8 * 0.5 * (3f64.sqrt() - 1.0);
            radiosities(
                [1.0, 0.0],
                [0.4, 0.6],
                |i, j| if i == j { own } else { other },
            )[1]
        }
        _ => return None,
    })
}

/// B = M + ρ F B, reflection by reflection.
fn radiosities<const N: usize>(
    exitance: [f64; N],
    rho: [f64; N],
    factor: impl Fn(usize, usize) -> f64,
) -> [f64; N] {
    let mut b = exitance;
    for _ in 0..200 {
        let arriving = |i: usize| (0..N).map(|j| factor(i, j) * b[j]).sum::<f64>();
        b = std::array::from_fn(|i| exitance[i] + rho[i] * arriving(i));
    }
    b
}

/// Extended form factor between faces z = 0, z = 1, x = 0, x = 1, y = 0, y = 1 of the unit cube,
/// the wall x = 0 a mirror.
fn cube_factor(i: usize, j: usize, mirror: f64) -> f64 {
    let (once, twice) = (opposed(1.0, 1.0, 1.0), opposed(2.0, 1.0, 1.0));
    let corner = on_common_edge(1.0, 1.0, 1.0);
    let direct = match (i, j) {
        _ if i == j => 0.0,
        _ if i / 2 == j / 2 => once,
        _ => corner,
    };
    // The image of the room stands at −1 ≤ x ≤ 0.
    let image = match (i, j) {
        (2, _) | (_, 2) => 0.0,
        (3, 3) => opposed(1.0, 1.0, 2.0),
        (3, _) | (_, 3) => perpendicular([1.0, 2.0], UNIT, UNIT, UNIT),
        _ if i == j => 0.0,
        _ if i / 2 == j / 2 => twice - once,
        // Beside and behind the mirror, along the common edge.
        _ => on_common_edge(2.0, 1.0, 1.0) - corner,
    };
    direct + mirror * image
}
