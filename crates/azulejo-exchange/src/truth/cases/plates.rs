//! Infinite parallel plates, 1 m² of each, and shields between them.

use super::super::enclosures::{GreyEnclosure, nested};
use super::super::expected::{SIGMA, in_series, plates};
use super::super::known_factors;
use super::*;
use crate::thermal::network::STEFAN_BOLTZMANN;

/// The closed formula.
const SERIES: &str = "1/(1/e1 + 1/e2 - 1)";

/// The cases of this module.
pub fn cases() -> Vec<ExchangeCase> {
    [pairs(), mixed(), sweep(), shields(), balances()].concat()
}

fn between(paint: &GreyPaint) -> GreyEnclosure {
    nested([1.0; 2], paint)
}

fn asked(text: &str, paint: &GreyPaint) -> EnclosureCases {
    let paint = paint.clone();
    let description = format!("infinite parallel plates, {text}");
    EnclosureCases::new(description, move || between(&paint))
}

fn pairs() -> Vec<ExchangeCase> {
    let (matt, mirrors) = (
        GreyPaint::matt(&[0.8, 0.3]),
        GreyPaint::new(&[0.8, 0.3], &[0.2, 0.7]),
    );
    let (diffuse, specular) = (
        asked("e 0.8 and 0.3, diffuse", &matt),
        asked("e 0.8 and 0.3, mirrors", &mirrors),
    );
    let truth = plates(0.8, 0.3);
    vec![
        diffuse.conductance(known("plates_dd_GR", SERIES, truth), 0, 1),
        diffuse.gebhart(
            known("plates_dd_B12", "e2/(1 - r1 r2)", 0.3 / (1.0 - 0.2 * 0.7)),
            0,
            1,
        ),
        specular.conductance(known("plates_ss_GR", SERIES, truth), 0, 1),
        specular.script_f(known("plates_ss_scriptF", SERIES, truth), 0, 1),
    ]
}

fn mixed() -> Vec<ExchangeCase> {
    let paint = GreyPaint::new(&[0.3, 0.6], &[0.2, 0.3]);
    let plates_of = asked(
        "e 0.3 and 0.6, diffuse reflectance 0.5 and 0.1, mirror 0.2 and 0.3",
        &paint,
    );
    let book = known_factors::nested([1.0; 2], &paint);
    let own = 0.3 / (1.0 - 0.2 * 0.3);
    vec![
        plates_of.factor(known("plates_mix_Fs11", "rs2/(1 - rs1 rs2)", own), 0, 0),
        plates_of.factor(
            known(
                "plates_mix_Fs12",
                "1/(1 - rs1 rs2)",
                1.0 / (1.0 - 0.2 * 0.3),
            ),
            0,
            1,
        ),
        plates_of.gebhart(
            known("plates_mix_B11", GEBHART_IMAGES, book.gebhart(0, 0)),
            0,
            0,
        ),
        plates_of.conductance(known("plates_mix_GR", SERIES, plates(0.3, 0.6)), 0, 1),
    ]
}

/// Emissivities from small to black, and shares of mirror in the reflectance.
fn sweep() -> Vec<ExchangeCase> {
    let rows = [
        ("plates_e002_matt_GR", 0.02, 0.02, [0.0, 0.0]),
        ("plates_e002_mirror_GR", 0.02, 0.02, [1.0, 1.0]),
        ("plates_e005_half_GR", 0.05, 0.2, [0.5, 0.5]),
        ("plates_e020_one_GR", 0.2, 0.9, [1.0, 0.0]),
        ("plates_e050_other_GR", 0.5, 0.5, [0.0, 1.0]),
        ("plates_e080_tenth_GR", 0.8, 0.1, [0.1, 0.9]),
        ("plates_e095_half_GR", 0.95, 0.7, [0.5, 0.25]),
        ("plates_black_GR", 1.0, 1.0, [0.0, 0.0]),
        ("plates_black_grey_GR", 1.0, 0.4, [0.0, 0.5]),
    ];
    let case = |(id, e1, e2, shares): (&'static str, f64, f64, [f64; 2])| {
        let mirrors = [shares[0] * (1.0 - e1), shares[1] * (1.0 - e2)];
        let paint = GreyPaint::new(&[e1, e2], &mirrors);
        let [s1, s2] = shares;
        let text = format!("e {e1} and {e2}, shares {s1} and {s2} of the reflectance mirror");
        asked(&text, &paint).conductance(known(id, SERIES, plates(e1, e2)), 0, 1)
    };
    rows.into_iter().map(case).collect()
}

/// GR of gaps between these emissivities, in pairs, each by the solver.
fn in_gaps(emissivity: &[f64]) -> Result<f64, ExchangeError> {
    let gap = |pair: &[f64]| between(&GreyPaint::matt(pair)).conductance(0, 1);
    let gaps: Result<Vec<f64>, ExchangeError> = emissivity.chunks(2).map(gap).collect();
    Ok(in_series(&gaps?))
}

/// The temperature of the first plate that sends a flux through gaps to the last one, gap by gap.
fn before_gaps(emissivity: &[f64], flux: f64, last: f64) -> Result<f64, ExchangeError> {
    let gap = |cold: f64, pair: &[f64]| {
        let plates = between(&GreyPaint::matt(pair));
        Ok(plates.heat(&[giving(flux), at(cold)])?.temperatures[0])
    };
    emissivity.chunks(2).rev().try_fold(last, gap)
}

/// GR of the same by the closed formula.
fn of_gaps(emissivity: &[f64]) -> f64 {
    let gaps: Vec<f64> = emissivity.chunks(2).map(|e| plates(e[0], e[1])).collect();
    in_series(&gaps)
}

/// Emissivities of the sides of gaps: plates of 0.8 and `count` shields.
fn with_shields(count: usize, shield: f64) -> Vec<f64> {
    let mut emissivity = vec![0.8];
    emissivity.extend(vec![shield; 2 * count]);
    emissivity.push(0.8);
    emissivity
}

fn shields() -> Vec<ExchangeCase> {
    const SOURCE: &str = "resistances in series, 1/e1 + 1/e2 - 1 for each gap";
    let flux = |id, text: &str, emissivity: Vec<f64>| {
        let between = fourth_powers(500.0, 300.0);
        let truth = SIGMA * between * of_gaps(&emissivity);
        let description =
            format!("infinite parallel plates, e 0.8, 500 and 300 K, {text} between: q of 1");
        let answer = move || Ok(STEFAN_BOLTZMANN * between * in_gaps(&emissivity)?);
        case(
            id,
            description,
            SOURCE,
            ExchangeQuantity::Flux,
            truth,
            answer,
        )
    };
    let hot = |id, count: usize| {
        let emissivity = with_shields(count, 0.1);
        let cold = 300f64.powi(4);
        let truth = (cold + 50.0 / (SIGMA * of_gaps(&emissivity))).powf(0.25);
        let description = format!(
            "infinite parallel plates, e 0.8, {count} shields of e 0.1 between, 50 W/m² from 1 to 2 \
             at 300 K: T of 1"
        );
        let answer = move || before_gaps(&emissivity, 50.0, 300.0);
        case(
            id,
            description,
            SOURCE,
            ExchangeQuantity::Temperature,
            truth,
            answer,
        )
    };
    let two_faced = vec![0.8, 0.03, 0.3, 0.05, 0.6, 0.1, 0.9, 0.8];
    vec![
        flux(
            "plates_shield_q",
            "a shield of e 0.05",
            with_shields(1, 0.05),
        ),
        flux(
            "plates_10_shields_q",
            "10 shields of e 0.05",
            with_shields(10, 0.05),
        ),
        flux(
            "plates_two_faced_shields_q",
            "3 shields of two emissivities each",
            two_faced,
        ),
        hot("plates_2_shields_T1", 2),
        hot("plates_5_shields_T1", 5),
    ]
}

/// Fluxes and temperatures of partly specular plates.
fn balances() -> Vec<ExchangeCase> {
    const SOURCE: &str = "q = GR s (T1^4 - T2^4)";
    let paint = GreyPaint::new(&[0.3, 0.6], &[0.2, 0.3]);
    let plates_of = asked("e 0.3 and 0.6, mirror 0.2 and 0.3", &paint);
    let gap = SIGMA * plates(0.3, 0.6);
    let hot = (400f64.powi(4) + 1000.0 / gap).powf(0.25);
    let flux = gap * fourth_powers(800.0, 400.0);
    vec![
        plates_of.flux(
            known("plates_mix_q1", SOURCE, flux),
            0,
            &[at(800.0), at(400.0)],
        ),
        plates_of.temperature(
            known("plates_mix_T1", SOURCE, hot),
            0,
            &[giving(1000.0), at(400.0)],
        ),
    ]
}
