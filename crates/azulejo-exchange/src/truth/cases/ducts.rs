//! Infinitely long ducts and grooves, per metre.

use super::super::enclosures::{GreyEnclosure, duct, strips};
use super::super::expected::{SIGMA, groove, in_series, of_surface, opposed_strips, reradiating};
use super::super::images::mirrored_duct;
use super::super::known_factors;
use super::*;
use std::f64::consts::FRAC_PI_3;

/// The cases of this module.
pub fn cases() -> Vec<ExchangeCase> {
    [
        equilateral(),
        right_triangle(),
        rectangles(),
        reradiating_sides(),
        grooves(),
        wedge_with_mirror(
            FRAC_PI_3,
            ["wedge_ds_Fs11", "wedge_ds_Fspace", "wedge_ds_Bspace"],
        ),
        wedge_with_mirror(
            40f64.to_radians(),
            ["wedge40_ds_Fs11", "wedge40_ds_Fspace", "wedge40_ds_Bspace"],
        ),
        slots(),
        mirrors_but_one(),
    ]
    .concat()
}

/// Corners of an equilateral triangle of side 1.
fn equilateral_corners() -> [[f64; 2]; 3] {
    [[0.0, 0.0], [1.0, 0.0], [0.5, 0.75f64.sqrt()]]
}

fn equilateral() -> Vec<ExchangeCase> {
    let paint = GreyPaint::matt(&[0.8, 0.4, 0.2]);
    let book = known_factors::triangle([1.0; 3], &paint);
    let asked = EnclosureCases::new(
        "long duct, an equilateral triangle of side 1, e 0.8, 0.4, 0.2",
        move || duct(&equilateral_corners(), &paint),
    );
    let given = [at(1000.0), at(500.0), giving(0.0)];
    let balance = book.balance(&given);
    vec![
        asked.gebhart(known("tri_B12", GEBHART, book.gebhart(0, 1)), 0, 1),
        asked.gebhart(known("tri_B33", GEBHART, book.gebhart(2, 2)), 2, 2),
        asked.flux(
            known("tri_mixed_q1", NET_RADIATION, balance.fluxes[0]),
            0,
            &given,
        ),
        asked.temperature(
            known("tri_mixed_T3", NET_RADIATION, balance.temperatures[2]),
            2,
            &given,
        ),
    ]
}

fn right_triangle() -> Vec<ExchangeCase> {
    let paint = GreyPaint::matt(&[0.5, 0.9, 0.1]);
    let book = known_factors::triangle([3.0, 4.0, 5.0], &paint);
    let asked = EnclosureCases::new(
        "long duct, a triangle of sides 3, 4, 5, e 0.5, 0.9, 0.1",
        move || duct(&[[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]], &paint),
    );
    let given = [giving(2000.0), at(300.0), at(400.0)];
    let balance = book.balance(&given);
    vec![
        asked.factor(known("tri345_F12", "(3 + 4 - 5)/(2 3)", 1.0 / 3.0), 0, 1),
        asked.conductance(known("tri345_GR13", GEBHART, book.conductance(0, 2)), 0, 2),
        asked.temperature(
            known("tri345_mixed_T1", NET_RADIATION, balance.temperatures[0]),
            0,
            &given,
        ),
        asked.flux(
            known("tri345_mixed_q3", NET_RADIATION, balance.fluxes[2]),
            2,
            &given,
        ),
    ]
}

fn rectangle(width: f64, height: f64) -> [[f64; 2]; 4] {
    [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]
}

fn rectangular(width: f64, height: f64, paint: &GreyPaint) -> EnclosureCases {
    let emissivity = &paint.emissivity;
    let text =
        format!("long duct {width} × {height}, bottom, right, top, left of e {emissivity:?}");
    let paint = paint.clone();
    EnclosureCases::new(text, move || duct(&rectangle(width, height), &paint))
}

fn rectangles() -> Vec<ExchangeCase> {
    let paint = GreyPaint::matt(&[0.9, 0.7, 0.5, 0.3]);
    let (square, flat) = (rectangular(1.0, 1.0, &paint), rectangular(3.0, 0.5, &paint));
    let books =
        [(1.0, 1.0), (3.0, 0.5)].map(|(w, h)| known_factors::rectangular_duct(w, h, &paint));
    let given = [at(900.0), at(700.0), at(500.0), at(300.0)];
    let heated = [giving(500.0), giving(0.0), at(300.0), giving(0.0)];
    let [hot, side] = [0, 1].map(|i| books[1].balance(&heated).temperatures[i]);
    let [q1, q4] = [0, 3].map(|i| books[0].balance(&given).fluxes[i]);
    vec![
        square.factor(
            known(
                "duct_square_F13",
                "sqrt 2 - 1, crossed strings",
                2f64.sqrt() - 1.0,
            ),
            0,
            2,
        ),
        square.gebhart(
            known("duct_square_B13", GEBHART, books[0].gebhart(0, 2)),
            0,
            2,
        ),
        square.flux(known("duct_square_q1", NET_RADIATION, q1), 0, &given),
        square.flux(known("duct_square_q4", NET_RADIATION, q4), 3, &given),
        flat.conductance(
            known("duct_flat_GR24", GEBHART, books[1].conductance(1, 3)),
            1,
            3,
        ),
        flat.temperature(known("duct_flat_mixed_T1", NET_RADIATION, hot), 0, &heated),
        flat.temperature(known("duct_flat_mixed_T2", NET_RADIATION, side), 1, &heated),
    ]
}

/// Opposed sides 2 wide at distance 1, the others adiabatic.
fn reradiating_sides() -> Vec<ExchangeCase> {
    let asked = EnclosureCases::new(
        "long duct 2 × 1, 1 bottom, 2 top, 3 and 4 sides, e 0.8, 0.6, 0.5, 0.5",
        || {
            let paint = GreyPaint::matt(&[1.0; 4]);
            let around = duct(&rectangle(2.0, 1.0), &paint);
            let row = |i: usize| [0, 2, 1, 3][i];
            let paint = GreyPaint::matt(&[0.8, 0.6, 0.5, 0.5]);
            GreyEnclosure::new(&[2.0, 2.0, 1.0, 1.0], &paint, |i, j| {
                around.factor(row(i), row(j))
            })
        },
    );
    let black = reradiating(2.0, 2.0, opposed_strips(2.0, 1.0));
    let through = in_series(&[of_surface(0.8, 2.0), black, of_surface(0.6, 2.0)]);
    vec![asked.through_reradiating(
        known(
            "duct_rerad_GR",
            "Hottel, reradiating walls; both have one radiosity",
            through,
        ),
        2.0,
    )]
}

fn grooves() -> Vec<ExchangeCase> {
    const SOURCE: &str = "e/(s + e (1 - s)), s = sin of half the angle";
    let case = |id, degrees: f64, e: f64| {
        let half = (0.5 * degrees).to_radians();
        let text = format!("V-groove of {degrees}° of two strips of width 1, e {e}, diffuse");
        let paint = GreyPaint::matt(&[e; 2]);
        let tip = [half.sin(), half.cos()];
        let corners = [tip, [0.0, 0.0], [-tip[0], tip[1]]];
        let build = move || duct(&corners, &paint);
        let opening = 2.0 * half.sin();
        let known = known(id, SOURCE, groove(e, half.sin()));
        EnclosureCases::new(text, build).opening(known, opening)
    };
    let paint = GreyPaint::matt(&[0.5; 2]);
    let wedge = EnclosureCases::new(
        "strips of width 1 with a common edge at 60°, e 0.5, diffuse, space is 3",
        move || duct(&equilateral_corners(), &paint),
    );
    // Both strips send e B through the opening, s times as wide as both.
    let space = groove(0.5, 0.5) * 0.5 / 0.5;
    vec![
        wedge.gebhart(
            known("wedge_dd_Bspace", "1/(1 + e (1/s - 1)), s = sin 30°", space),
            0,
            2,
        ),
        case("groove_20_eps", 20.0, 0.3),
        case("groove_60_eps", 60.0, 0.05),
        case("groove_90_eps", 90.0, 0.5),
        case("groove_150_eps", 150.0, 0.8),
    ]
}

/// A diffuse strip and a mirror.
fn wedge_with_mirror(angle: f64, ids: [&'static str; 3]) -> Vec<ExchangeCase> {
    let paint = GreyPaint::new(&[0.5, 0.2], &[0.0, 0.8]);
    let book = known_factors::strips(angle, &paint);
    let text = format!(
        "strips of width 1 with a common edge at {:.0}°, 1 diffuse of e 0.5, 2 a mirror of e 0.2, space \
         is 3",
        angle.to_degrees()
    );
    let asked = EnclosureCases::new(text, move || strips(angle, &paint));
    let own = 0.8 * (1.0 - angle.sin());
    let space = 1.0 - own - 0.2 * (1.0 - (0.5 * angle).sin());
    let to_space = |e: GreyEnclosure| Ok(e.enclosure.factors.rest[0].sky);
    vec![
        asked.factor(
            known(
                ids[0],
                "0.8 (1 - sin of the angle): the own image, seen whole",
                own,
            ),
            0,
            0,
        ),
        asked.case(
            known(ids[1], "1 - F^s_11 - 0.2 F_12", space),
            "F^s from 1 to space",
            ExchangeQuantity::Factor,
            to_space,
        ),
        asked.gebhart(known(ids[2], GEBHART_IMAGES, book.gebhart(0, 2)), 0, 2),
    ]
}

/// Rectangular grooves.
fn slots() -> Vec<ExchangeCase> {
    let case = |id, depth: f64, emissivity: [f64; 3]| {
        let paint = GreyPaint::matt(&emissivity);
        let book = known_factors::slot(1.0, depth, &paint);
        let through: f64 = (0..3).map(|i| book.conductance(i, 3)).sum();
        let text = format!(
            "rectangular groove of width 1 and depth {depth}, right, bottom, left of e {:?}",
            [emissivity[1], emissivity[0], emissivity[2]]
        );
        let walls = GreyPaint::matt(&[emissivity[1], emissivity[0], emissivity[2]]);
        // Sides in order, from the upper right corner clockwise.
        let corners = [[1.0, depth], [1.0, 0.0], [0.0, 0.0], [0.0, depth]];
        let build = move || duct(&corners, &walls);
        EnclosureCases::new(text, build).opening(known(id, GEBHART, through), 1.0)
    };
    vec![
        case("slot_flat_eps", 0.25, [0.6, 0.6, 0.6]),
        case("slot_deep_eps", 3.0, [0.9, 0.2, 0.4]),
    ]
}

/// A square duct whose sides are mirrors but for the bottom.
fn mirrors_but_one() -> Vec<ExchangeCase> {
    let paint = GreyPaint::new(&[0.4, 0.3, 0.6, 0.2], &[0.6, 0.7, 0.0, 0.8]);
    let book = known_factors::mirrored_duct(&paint);
    let asked = EnclosureCases::new(
        "long square duct, x0, x1, y1 mirrors of e 0.4, 0.3, 0.2, y0 diffuse of e 0.6 (rows x0 x1 y0 y1)",
        move || mirrored_duct(&paint),
    );
    let given = [at(300.0), at(400.0), giving(1000.0), at(500.0)];
    let balance = book.balance(&given);
    // Row 3 alone reflects diffusely: H = F^s_33 (H + q) + what mirrors emit to it, and E = H + q/e.
    let own = book.factor(2, 2);
    let from = |j: usize, e: f64, t: f64| book.factor(2, j) * e * SIGMA * t.powi(4);
    let mirrors = from(0, 0.4, 300.0) + from(1, 0.3, 400.0) + from(3, 0.2, 500.0);
    let irradiation = (own * 1000.0 + mirrors) / (1.0 - own);
    let hot = ((irradiation + 1000.0 / 0.6) / SIGMA).powf(0.25);
    vec![
        asked.factor(
            known("duct_m3_Fs33", "F^s by images, crossed strings", own),
            2,
            2,
        ),
        asked.factor(
            known(
                "duct_m3_Fs12",
                "F^s by images, crossed strings",
                book.factor(0, 1),
            ),
            0,
            1,
        ),
        asked.gebhart(
            known(
                "duct_m3_B33",
                "e F^s_33/(1 - rd F^s_33)",
                0.6 * own / (1.0 - 0.4 * own),
            ),
            2,
            2,
        ),
        asked.gebhart(
            known("duct_m3_B14", GEBHART_IMAGES, book.gebhart(0, 3)),
            0,
            3,
        ),
        asked.temperature(
            known(
                "duct_m3_T3",
                "H = (F^s_33 q + sum F^s_3j e_j E_j)/(1 - F^s_33)",
                hot,
            ),
            2,
            &given,
        ),
        asked.flux(
            known("duct_m3_q1", NET_RADIATION, balance.fluxes[0]),
            0,
            &given,
        ),
    ]
}
