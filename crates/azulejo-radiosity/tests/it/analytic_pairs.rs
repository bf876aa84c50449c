//! Pairs of polygons, past others and by mirrors, against the reference table.

use crate::{table, table_scenes};
use azulejo_radiosity::analytic::{mirrored_form_factor, visible_form_factor};
use glam::DVec3;

/// What is asked for; it is reached by far.
const ACCURACY: f64 = 1e-11;

#[track_caller]
fn check(row: &table::Row, value: f64, error: f64, tolerance: f64) {
    let off = (value - row.value).abs();
    eprintln!("{:12} {value:.13} ± {error:.1e}, off {off:.1e}", row.id);
    assert!(error < tolerance, "{} claims only {error:e}", row.id);
    assert!(
        off < tolerance.max(row.tolerance()),
        "{}: {value} is {off:e} off",
        row.id
    );
}

#[test]
fn occluded_rows() {
    for row in table::rows().unwrap_or_default() {
        if row.occluders.is_empty() || row.p1.is_empty() {
            continue;
        }
        let found = visible_form_factor(&row.p1, &row.p2, &row.occluders, ACCURACY);
        check(&row, found.value, found.error, 1e-9);
        let back = visible_form_factor(&row.p2, &row.p1, &row.occluders, ACCURACY);
        check(&row, back.value, back.error, 1e-9);
    }
}

#[test]
fn mirrored_rows() {
    for row in table::rows().unwrap_or_default() {
        let row = table_scenes::in_polygons(&row);
        if row.mirrors.is_empty() {
            continue;
        }
        let walls: Vec<&[DVec3]> = row.mirrors.iter().map(|m| &m.polygon[..]).collect();
        let rho_s = row.mirrors[0].rho_s;
        let (mut value, mut error) = (0.0, 0.0);
        // From each mirror on, the chains take turns.
        for first in 0..walls.len() {
            for length in 1..=100 {
                let chain: Vec<&[DVec3]> = (0..length)
                    .map(|k| walls[(first + k) % walls.len()])
                    .collect();
                let found = mirrored_form_factor(&row.p1, &row.p2, &chain, &walls, ACCURACY);
                value += rho_s.powi(length as i32) * found.value;
                error += rho_s.powi(length as i32) * found.error;
                if walls.len() == 1 {
                    break;
                }
            }
        }
        let direct = visible_form_factor(&row.p1, &row.p2, &walls, ACCURACY);
        // What 100 images leave of an endless corridor falls as the inverse cube.
        let tail = if rho_s == 1.0 && walls.len() == 2 {
            3e-7
        } else {
            1e-8
        };
        check(&row, direct.value + value, direct.error + error, tail);
    }
}
