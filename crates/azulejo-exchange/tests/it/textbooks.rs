//! What the equations and formulas of textbooks must hold among themselves.

use crate::expected::*;
use crate::known_factors;
use crate::net_radiation::{GreyPaint, NetRadiation, eliminate};
use crate::planck::{bisect, planck_fraction};
use azulejo_exchange::RowCondition;

#[test]
fn elimination_needs_its_pivots() {
    // The first pivot is 0; the solution is 1, 2, 3.
    let matrix = vec![
        vec![0.0, 2.0, 1.0],
        vec![1.0, 1.0, 1.0],
        vec![3.0, 0.0, -1.0],
    ];
    let solution = eliminate(matrix, vec![7.0, 6.0, 0.0]);
    for (x, expected) in solution.iter().zip([1.0, 2.0, 3.0]) {
        assert!((x - expected).abs() < 1e-14, "{solution:?}");
    }
}

#[test]
fn quadrature_gives_the_whole_and_the_quarter() {
    // Wien's displacement constant: a quarter of emission is at shorter wavelengths.
    assert!((planck_fraction(2_897.771_955) - 0.250_05).abs() < 1e-5);
    // Beyond this, 5 c₂³/(π⁴ (λT)³) is left: the law of Rayleigh and Jeans.
    let far = 1e8f64;
    let rest = 5.0 / std::f64::consts::PI.powi(4) * (14_387.768_77 / far).powi(3);
    assert!((planck_fraction(far) + rest - 1.0).abs() < 1e-13);
    assert!((bisect(0.0, 2.0, |x| x * x - 2.0) - 2f64.sqrt()).abs() < 1e-15);
}

/// Both equations of textbooks say the same of one enclosure, and absorption factors sum to 1.
#[test]
fn equations_of_both_books_agree() {
    let paint = GreyPaint {
        mirror: vec![0.0, 0.7, 0.1, 0.8, 0.0, 0.0],
        ..GreyPaint::matt(&[0.5, 0.1, 0.5, 0.2, 0.4, 0.6])
    };
    let cube = known_factors::mirrored_cube(&paint);
    let temperatures = [300.0, 400.0, 500.0, 600.0, 700.0, 800.0f64];
    let balance = cube.balance(&temperatures.map(RowCondition::Temperature));
    for i in 0..6 {
        let sum: f64 = (0..7).map(|j| cube.gebhart(i, j)).sum();
        assert!((sum - 1.0).abs() < 1e-11, "row {i}: {sum}");
        assert_eq!(cube.to_space(i), 0.0);
        let heat = |j: usize| {
            let between = temperatures[i].powi(4) - temperatures[j].powi(4);
            cube.conductance(i, j) * SIGMA * between
        };
        let heat: f64 = (0..6).map(heat).sum();
        assert!(
            (heat - balance.fluxes[i]).abs() < 1e-8 * heat.abs(),
            "row {i}"
        );
    }
}

/// Fluxes that follow from temperatures give these temperatures back.
#[test]
fn given_fluxes_give_temperatures() {
    let paint = GreyPaint::matt(&[0.9, 0.7, 0.5, 0.3]);
    let duct = known_factors::rectangular_duct(2.0, 1.0, &paint);
    let temperatures = [900.0, 700.0, 500.0, 300.0];
    let fluxes = duct
        .balance(&temperatures.map(RowCondition::Temperature))
        .fluxes;
    let mut mixed = fluxes
        .into_iter()
        .map(RowCondition::Flux)
        .collect::<Vec<_>>();
    mixed[1] = RowCondition::Temperature(700.0);
    let solved = duct.balance(&mixed).temperatures;
    for (t, expected) in solved.iter().zip(temperatures) {
        assert!((t - expected).abs() < 1e-9, "{solved:?}");
    }
}

/// General formulas hold special ones.
#[test]
fn formulas_hold_special_cases() {
    let check = |a: f64, b: f64| assert!((a - b).abs() < 1e-14 * b.abs(), "{a} {b}");
    check(concentric([1.0, 1.0], [0.3, 0.6], 0.2), plates(0.3, 0.6));
    check(concentric([1.0, 9.0], [0.3, 0.6], 0.4), plates(0.3, 0.6));
    check(reradiating(1.0, 1.0, 0.2), 0.6);
    check(in_series(&[2.0, 2.0]), 1.0);
    check(groove(0.4, 1.0), 0.4);
    check(disks(1.0, 1.0, 2.0), 3.0 - 8f64.sqrt());
    check(hole_of_sphere(0.4, 1.0), 0.4);
    check(opposed_strips(1.0, 1.0), 2f64.sqrt() - 1.0);
    // A crater as deep as a sphere is a cavity that is as hot all over.
    check(
        crater_shadow(1.0, 0.0, 0.9, 500.0),
        (500.0 / SIGMA).powf(0.25),
    );
    let parts = NetRadiation::new(
        &[0.1, 0.3, 0.6],
        &GreyPaint::matt(&[0.9, 0.5, 0.05]),
        |_, j| [0.1, 0.3, 0.6][j],
    );
    check(
        part_of_sphere(&[0.1, 0.3, 0.6], &[0.9, 0.5, 0.05], 1),
        parts.gebhart(2, 1),
    );
}
