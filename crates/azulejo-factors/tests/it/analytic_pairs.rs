//! Pairs of polygons, with occluders and mirrors, against known answers.

use crate::cases::{Case, CaseKind, cases};
use crate::polygons::polygon;
use azulejo_factors::analytic::{form_factor, mirrored_form_factor, visible_form_factor};
use azulejo_testing::closed_forms::element_parallel;
use glam::DVec3;

/// The requested accuracy; the result is far better.
const ACCURACY: f64 = 1e-11;

#[track_caller]
fn check(case: &Case, value: f64, error: f64, tolerance: f64) {
    let off = (value - case.truth.value).abs();
    eprintln!("{:12} {value:.13} ± {error:.1e}, off {off:.1e}", case.id);
    assert!(error < tolerance, "{} claims only {error:e}", case.id);
    assert!(
        off < tolerance.max(case.truth.error),
        "{}: {value} is {off:e} off",
        case.id
    );
}

/// The polygons of a case: sender, receiver, and occluders.
fn polygons(case: &Case) -> (Vec<DVec3>, Vec<DVec3>, Vec<Vec<DVec3>>) {
    let objects = 0..case.scene.objects.len() as u32;
    let mut polygons: Vec<_> = objects.map(|k| polygon(&case.scene, k)).collect();
    let others = polygons.split_off(2);
    (polygons[0].clone(), polygons[1].clone(), others)
}

#[test]
fn occluded_pairs() {
    let cases = cases();
    let shadows = cases.iter().filter(|c| c.kind == CaseKind::Shadow);
    for case in shadows {
        let (p1, p2, occluders) = polygons(case);
        let share = visible_form_factor(&p1, &p2, &occluders, ACCURACY);
        check(case, share.value, share.error, 1e-9);
        let back = visible_form_factor(&p2, &p1, &occluders, ACCURACY);
        check(case, back.value, back.error, 1e-9);
    }
}

/// Whether the case's mirrors are one wall or two that face each other, of one reflectance.
fn is_mirrored_pair(case: &&Case) -> bool {
    let names = ["mir_", "corridor_", "cube_mirror_F"];
    names.iter().any(|name| case.id.starts_with(name))
}

#[test]
fn mirrored_pairs() {
    let cases = cases();
    assert_eq!(cases.iter().filter(is_mirrored_pair).count(), 7);
    for case in cases.iter().filter(is_mirrored_pair) {
        let (p1, p2, mirrors) = polygons(case);
        let walls: Vec<&[DVec3]> = mirrors.iter().map(|m| &m[..]).collect();
        let rho_s = case.scene.materials[2].mirror.mean();
        let (mut value, mut error) = (0.0, 0.0);
        // Starting from each mirror, the chains alternate.
        for first in 0..walls.len() {
            for length in 1..=100 {
                let chain: Vec<&[DVec3]> = (0..length)
                    .map(|k| walls[(first + k) % walls.len()])
                    .collect();
                let share = mirrored_form_factor(&p1, &p2, &chain, &walls, ACCURACY);
                value += rho_s.powi(length as i32) * share.value;
                error += rho_s.powi(length as i32) * share.error;
                if walls.len() == 1 {
                    break;
                }
            }
        }
        let direct = visible_form_factor(&p1, &p2, &walls, ACCURACY);
        // What 100 images leave of an endless corridor falls with the inverse cube.
        let tail = if rho_s == 1.0 && walls.len() == 2 {
            3e-7
        } else {
            1e-8
        };
        check(case, direct.value + value, direct.error + error, tail);
    }
}

/// Small polygons far from the contour of a large one, where integrals along contours cancel: the value is
/// that of an element (Howell B-3), but for the size, whose effect is of second order.
#[test]
fn small_polygons_are_as_exact_as_large_ones() {
    let lid = [(0.0, 0.0), (0.0, 1.0), (2.0, 1.0), (2.0, 0.0)];
    for height in [0.25, 4.0] {
        let lid = lid.map(|(x, y)| DVec3::new(x, y, height));
        let truth = element_parallel(2.0, 1.0, height);
        for side in [1e-4, 1e-5, 1e-6, 1e-7] {
            let corners = [(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)];
            let small = corners.map(|(x, y)| side * DVec3::new(x, y, 0.0));
            let relative = |f: f64| (f / truth - 1.0).abs();
            let (there, back) = (form_factor(&small, &lid), form_factor(&lid, &small));
            let most = 1e-12 + 2.0 * (side / height).powi(2);
            assert!(relative(there) < most, "{side}: {there}, {truth}");
            let back = back * 2.0 / (4.0 * side * side);
            assert!(relative(back) < most, "{side}: {back}, {truth}");
        }
    }
}
