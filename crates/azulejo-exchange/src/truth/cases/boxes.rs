//! Cubes and a room, with mirrors too, and squares on a common edge.

use super::super::enclosures::{cube_of_three, squares_at};
use super::super::expected::{SIGMA, reradiating};
use super::super::images::{cube_of_24, mirrored_box};
use super::super::known_factors;
use super::*;
use azulejo_factors::truth::formulas::{on_common_edge, opposed, parallel, perpendicular, wedge};
use std::f64::consts::FRAC_PI_3;

const X0: usize = 0;
const X1: usize = 1;
const Y0: usize = 2;
const Z0: usize = 4;
const Z1: usize = 5;

/// The cases of this module.
pub fn cases() -> Vec<ExchangeCase> {
    [
        cube(),
        cube_of_few(),
        room(),
        heated_room(),
        furnace(),
        one_mirror(),
        two_mirrors(),
        mirrors_in_a_corner(),
        mirrors_but_one(),
        squares(),
        cube_in_quarters(),
    ]
    .concat()
}

fn three(paint: &GreyPaint) -> EnclosureCases {
    let [e1, e2, e3] = [0, 1, 2].map(|i| paint.emissivity[i]);
    let text = format!("unit cube, floor, ceiling, four walls as one, e {e1}, {e2}, {e3}");
    let paint = paint.clone();
    EnclosureCases::new(text, move || cube_of_three(&paint))
}

fn cube() -> Vec<ExchangeCase> {
    let paint = GreyPaint::matt(&[0.9, 0.5, 0.1]);
    let (asked, book) = (three(&paint), known_factors::cube_of_three(&paint));
    let given = [giving(1000.0), at(300.0), giving(0.0)];
    let [t1, _, t3] = [0, 1, 2].map(|i| book.balance(&given).temperatures[i]);
    vec![
        asked.gebhart(known("cube3_B12", GEBHART, book.gebhart(0, 1)), 0, 1),
        asked.gebhart(known("cube3_B33", GEBHART, book.gebhart(2, 2)), 2, 2),
        asked.conductance(known("cube3_GR13", GEBHART, book.conductance(0, 2)), 0, 2),
        asked.temperature(known("cube3_mixed_T1", NET_RADIATION, t1), 0, &given),
        asked.temperature(known("cube3_mixed_T3", NET_RADIATION, t3), 2, &given),
    ]
}

fn cube_of_few() -> Vec<ExchangeCase> {
    let f12 = opposed(1.0, 1.0, 1.0);
    let through = three(&GreyPaint::matt(&[1.0, 1.0, 0.5]));
    let black = three(&GreyPaint::matt(&[1.0; 3]));
    let [to_ceiling, to_walls] = [300.0, 400.0].map(|t| SIGMA * fourth_powers(500.0, t));
    let flux = f12 * to_ceiling + (1.0 - f12) * to_walls;
    vec![
        through.through_reradiating(
            known(
                "cube3_rerad",
                "Hottel, reradiating wall, (1 + F12)/2",
                reradiating(1.0, 1.0, f12),
            ),
            1.0,
        ),
        black.flux(
            known("cube3_black_q1", "sum of F s (T1^4 - Tj^4)", flux),
            0,
            &[at(500.0), at(300.0), at(400.0)],
        ),
    ]
}

const ROOM: [f64; 3] = [4.0, 3.0, 2.5];

fn room_of(emissivity: [f64; 6]) -> EnclosureCases {
    let text = format!("room 4 × 3 × 2.5 m, x0 x1 y0 y1 z0 z1 of e {emissivity:?}");
    let paint = GreyPaint::matt(&emissivity);
    EnclosureCases::new(text, move || mirrored_box(ROOM, &paint))
}

fn room() -> Vec<ExchangeCase> {
    let emissivity = [0.9, 0.8, 0.7, 0.6, 0.95, 0.5];
    let book = known_factors::room(ROOM, &GreyPaint::matt(&emissivity));
    let even = known_factors::room(ROOM, &GreyPaint::matt(&[0.8; 6]));
    let (asked, alike) = (room_of(emissivity), room_of([0.8; 6]));
    vec![
        asked.factor(
            known("room_F_z0_y0", "Howell C-14", on_common_edge(4.0, 3.0, 2.5)),
            Z0,
            Y0,
        ),
        asked.factor(
            known("room_F_z0_x0", "Howell C-14", on_common_edge(3.0, 4.0, 2.5)),
            Z0,
            X0,
        ),
        asked.gebhart(known("room_B_z0_z1", GEBHART, book.gebhart(Z0, Z1)), Z0, Z1),
        alike.script_f(
            known("room_scriptF_z0_y0", GEBHART, even.script_f(Z0, Y0)),
            Z0,
            Y0,
        ),
    ]
}

/// A heated floor, a window at 280 K, and an adiabatic ceiling.
fn heated_room() -> Vec<ExchangeCase> {
    let emissivity = [0.9, 0.84, 0.9, 0.9, 0.93, 0.9];
    let given = [
        at(292.0),
        at(280.0),
        at(292.0),
        at(292.0),
        giving(60.0),
        giving(0.0),
    ];
    let book = known_factors::room(ROOM, &GreyPaint::matt(&emissivity)).balance(&given);
    let asked = room_of(emissivity);
    let case = |id, row: usize| {
        asked.temperature(
            known(id, NET_RADIATION, book.temperatures[row]),
            row,
            &given,
        )
    };
    vec![
        case("room_heated_T_floor", Z0),
        case("room_heated_T_ceiling", Z1),
        asked.flux(
            known("room_heated_q_window", NET_RADIATION, book.fluxes[X1]),
            X1,
            &given,
        ),
    ]
}

/// All at one temperature.
fn furnace() -> Vec<ExchangeCase> {
    const ISOTHERMAL: &str = "isothermal enclosure: black radiation all over";
    let asked = room_of([0.9, 0.05, 0.7, 0.3, 0.95, 0.5]);
    let sum = |e: GreyEnclosure| {
        let exchange = e.exchange()?;
        Ok((0..6).map(|j| exchange.conductance(Z0, j).0).sum())
    };
    let irradiation = |e: GreyEnclosure| Ok(e.heat(&[at(700.0); 6])?.irradiations[X1]);
    let mut one_adiabatic = [at(700.0); 6];
    one_adiabatic[X1] = giving(0.0);
    vec![
        asked.case(
            known(
                "furnace_GR_sum",
                "sum of GR_ij over j = e_i A_i",
                0.95 * 12.0,
            ),
            "sum of GR between 5 and all rows",
            ExchangeQuantity::Conductance,
            sum,
        ),
        asked.case(
            known("furnace_H", ISOTHERMAL, SIGMA * 700f64.powi(4)),
            "irradiation of 2, all at 700 K",
            ExchangeQuantity::Flux,
            irradiation,
        ),
        asked.temperature(
            known("furnace_T_adiabatic", ISOTHERMAL, 700.0),
            X1,
            &one_adiabatic,
        ),
    ]
}

fn mirrored(text: &str, paint: &GreyPaint) -> EnclosureCases {
    let paint = paint.clone();
    let text = format!("unit cube x0 x1 y0 y1 z0 z1, {text}");
    EnclosureCases::new(text, move || mirrored_box([1.0; 3], &paint))
}

/// The ceiling a mirror, or as white without being one.
fn one_mirror() -> Vec<ExchangeCase> {
    let emissivity = [0.6, 0.6, 0.6, 0.6, 0.6, 0.1];
    let paint = GreyPaint::new(&emissivity, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.9]);
    let matt = GreyPaint::matt(&emissivity);
    let asked = mirrored("z1 a mirror of e 0.1, others diffuse of e 0.6", &paint);
    let diffuse = mirrored("z1 of e 0.1, others of e 0.6, all diffuse", &matt);
    let book = known_factors::mirrored_cube(&paint);
    let plain = known_factors::mirrored_cube(&matt);
    let (here, next) = ([0.0, 1.0], [1.0, 2.0]);
    let floor = 0.9 * opposed(1.0, 1.0, 2.0);
    let wall = on_common_edge(1.0, 1.0, 1.0) + 0.9 * perpendicular(here, here, here, next);
    let walls = opposed(1.0, 1.0, 1.0) + 0.9 * parallel(here, here, here, next, 1.0);
    vec![
        asked.factor(
            known("cube_m1_Fs_z0z0", "0.9 F(unit squares, 2)", floor),
            Z0,
            Z0,
        ),
        asked.factor(
            known("cube_m1_Fs_z0x0", "F + 0.9 F to the wall above", wall),
            Z0,
            X0,
        ),
        asked.factor(
            known("cube_m1_Fs_x0x1", "F + 0.9 F to the wall above", walls),
            X0,
            X1,
        ),
        asked.gebhart(
            known("cube_m1_B_z0z1", GEBHART_IMAGES, book.gebhart(Z0, Z1)),
            Z0,
            Z1,
        ),
        asked.gebhart(
            known("cube_m1_B_z0z0", GEBHART_IMAGES, book.gebhart(Z0, Z0)),
            Z0,
            Z0,
        ),
        diffuse.gebhart(
            known("cube_d1_B_z0z0", GEBHART, plain.gebhart(Z0, Z0)),
            Z0,
            Z0,
        ),
    ]
}

/// Two mirrors that face each other.
fn two_mirrors() -> Vec<ExchangeCase> {
    let paint = GreyPaint::new(
        &[0.2, 0.2, 0.5, 0.5, 0.5, 0.5],
        &[0.8, 0.8, 0.0, 0.0, 0.0, 0.0],
    );
    let asked = mirrored(
        "x0 and x1 mirrors of e 0.2, others diffuse of e 0.5",
        &paint,
    );
    let book = known_factors::mirrored_cube(&paint);
    let here = [0.0, 1.0];
    let offset = |n: i32| {
        let n = f64::from(n);
        0.8f64.powf(n.abs()) * parallel(here, here, [n, n + 1.0], here, 1.0)
    };
    let ceiling = (-180..=180).map(offset).sum();
    let wall = book.factor(Z0, X0);
    let given = [
        at(300.0),
        at(400.0),
        at(500.0),
        at(500.0),
        giving(3000.0),
        giving(0.0),
    ];
    let balance = book.balance(&given);
    vec![
        asked.factor(
            known("cube_m2_Fs_z0z1", "sum of 0.8^|n| F(offset n)", ceiling),
            Z0,
            Z1,
        ),
        asked.factor(
            known("cube_m2_Fs_z0x0", "F^s by images, Howell C-15", wall),
            Z0,
            X0,
        ),
        asked.gebhart(
            known("cube_m2_B_z0z1", GEBHART_IMAGES, book.gebhart(Z0, Z1)),
            Z0,
            Z1,
        ),
        asked.gebhart(
            known("cube_m2_B_x0x0", GEBHART_IMAGES, book.gebhart(X0, X0)),
            X0,
            X0,
        ),
        asked.flux(
            known("cube_m2_q_x0", NET_RADIATION, balance.fluxes[X0]),
            X0,
            &given,
        ),
        asked.temperature(
            known("cube_m2_T_z1", NET_RADIATION, balance.temperatures[Z1]),
            Z1,
            &given,
        ),
    ]
}

/// Two mirrors at a right angle, one of them partly diffuse.
fn mirrors_in_a_corner() -> Vec<ExchangeCase> {
    let paint = GreyPaint::new(
        &[0.5, 0.1, 0.5, 0.1, 0.5, 0.5],
        &[0.0, 0.7, 0.0, 0.9, 0.0, 0.0],
    );
    let text =
        "x1 of e 0.1, mirror 0.7, diffuse 0.2; y1 a mirror of e 0.1, others diffuse of e 0.5";
    let asked = mirrored(text, &paint);
    let book = known_factors::mirrored_cube(&paint);
    let (here, next) = ([0.0, 1.0], [1.0, 2.0]);
    let ceiling = opposed(1.0, 1.0, 1.0)
        + 1.6 * parallel(here, here, next, here, 1.0)
        + 0.63 * parallel(here, here, next, next, 1.0);
    vec![
        asked.factor(
            known(
                "cube_mc_Fs_z0z1",
                "F + 1.6 F(offset 1, 0) + 0.63 F(offset 1, 1)",
                ceiling,
            ),
            Z0,
            Z1,
        ),
        asked.gebhart(
            known("cube_mc_B_z0x1", GEBHART_IMAGES, book.gebhart(Z0, X1)),
            Z0,
            X1,
        ),
    ]
}

/// All mirrors but the floor.
fn mirrors_but_one() -> Vec<ExchangeCase> {
    let paint = GreyPaint::new(
        &[0.7, 0.7, 0.7, 0.7, 0.5, 0.6],
        &[0.3, 0.3, 0.3, 0.3, 0.0, 0.4],
    );
    let text = "x0 x1 y0 y1 mirrors of e 0.7, z1 of e 0.6, z0 diffuse of e 0.5";
    let asked = mirrored(text, &paint);
    let book = known_factors::mirrored_cube(&paint);
    let own = book.factor(Z0, Z0);
    let rows = 1.0 - 0.5 * own;
    vec![
        asked.factor(
            known("cube_m5_Fs_z0z0", "F^s by images, Howell C-13", own),
            Z0,
            Z0,
        ),
        asked.gebhart(
            known(
                "cube_m5_B_z0z0",
                "e F^s/(1 - rd F^s): one diffuse row",
                0.5 * own / rows,
            ),
            Z0,
            Z0,
        ),
        asked.gebhart(
            known(
                "cube_m5_B_z0z1",
                "e_j F^s_ij/(1 - rd F^s_ii): one diffuse row",
                0.6 * book.factor(Z0, Z1) / rows,
            ),
            Z0,
            Z1,
        ),
    ]
}

/// Unit squares on a common edge at 60° in black space.
fn squares() -> Vec<ExchangeCase> {
    let paint = GreyPaint::matt(&[0.7, 0.3]);
    let asked = EnclosureCases::new(
        "unit squares on a common edge at 60°, e 0.7 and 0.3, space is 3",
        move || squares_at(FRAC_PI_3, &paint),
    );
    let f = wedge(FRAC_PI_3);
    let rows = 1.0 - 0.3 * 0.7 * f * f;
    let space = 0.7 * (1.0 - f) * (1.0 + 0.7 * f) / rows;
    vec![
        asked.factor(known("squares60_F12", "Howell C-16", f), 0, 1),
        asked.conductance(
            known(
                "squares60_GR12",
                "e1 e2 F/(1 - r1 r2 F^2)",
                0.7 * 0.3 * f / rows,
            ),
            0,
            1,
        ),
        asked.conductance(
            known(
                "squares60_GR1s",
                "e1 (1 - F)(1 + r2 F)/(1 - r1 r2 F^2)",
                space,
            ),
            0,
            2,
        ),
    ]
}

/// A cube of 24 squares with all temperatures given.
fn cube_in_quarters() -> Vec<ExchangeCase> {
    let given = [at(500.0), at(300.0), at(400.0), at(400.0)];
    let book = known_factors::cube_of_24(&GreyPaint::matt(&[0.8; 4])).balance(&given);
    let case = |id, group: usize, square: &str| {
        let description = format!(
            "unit cube of 24 squares, e 0.8, floor 500 K, ceiling 300 K, walls 400 K: q of a square of \
             {square}"
        );
        let source = "four unknowns by symmetry, net-radiation equations, by elimination";
        let answer = move || flux_in_quarters(group);
        let quantity = ExchangeQuantity::Flux;
        case(
            id,
            description,
            source,
            quantity,
            book.fluxes[group],
            answer,
        )
    };
    vec![
        case("cube24_q_floor", 0, "the floor"),
        case("cube24_q_ceiling", 1, "the ceiling"),
        case("cube24_q_wall_low", 2, "the walls' lower half"),
        case("cube24_q_wall_high", 3, "the walls' upper half"),
    ]
}

/// The flux of squares of floor, ceiling, and lower or upper half of the walls; NaN if they differ.
fn flux_in_quarters(group: usize) -> Result<f64, ExchangeError> {
    let (cube, heights) = cube_of_24(&GreyPaint::matt(&[0.8; 24]));
    let temperatures = [500.0, 300.0, 400.0, 400.0, 400.0, 400.0];
    let given: Vec<RowCondition> = (0..24).map(|i| at(temperatures[i / 4])).collect();
    let fluxes = cube.heat(&given)?.fluxes;
    let of_square = |i: usize| match i {
        0..4 => 0,
        4..8 => 1,
        _ if heights[i] < 0.5 => 2,
        _ => 3,
    };
    let squares: Vec<f64> = (0..24)
        .filter(|&i| of_square(i) == group)
        .map(|i| fluxes[i])
        .collect();
    let is_alike = squares.iter().all(|q| (q - squares[0]).abs() < 1e-9);
    Ok(if is_alike { squares[0] } else { f64::NAN })
}
