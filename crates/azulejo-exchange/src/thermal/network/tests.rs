//! Balances, closed forms and errors.

use super::*;
use crate::enclosure::{Groups, RowTable};
use crate::thermal::bands::SpectralRange;
use azulejo_factors::form_factors::{Exchange, ExchangeAreas, RowRemainder};
use azulejo_factors::{CompressedFactors, CompressionOptions, FormFactors, PointNormal};
use azulejo_trace::Progress;
use glam::DVec3;
use proptest::prelude::*;
use std::sync::Arc;

/// An enclosure of whole rows of S, with mirror reflectances, whose rows lack what goes to the sky.
pub fn enclosure_of(areas: &[f64], s: &[Vec<f64>], mirrors: &[f64]) -> Enclosure {
    let n = areas.len();
    let upper = |i: usize| -> Vec<Exchange> {
        let entry = |j: usize| Exchange {
            column: j as u32,
            value: s[i][j],
            error: 0.0,
        };
        (i..n).filter(|&j| s[i][j] > 0.0).map(entry).collect()
    };
    let rest = |i: usize| {
        let ended: f64 = (0..n)
            .map(|j| s[i][j] / areas[i] * (1.0 - mirrors[j]))
            .sum();
        let sky = 1.0 - ended;
        RowRemainder {
            sky: if sky > 1e-12 { sky } else { 0.0 },
            ..RowRemainder::default()
        }
    };
    Enclosure {
        factors: FormFactors {
            exchange: (0..n).map(upper).collect::<ExchangeAreas>(),
            areas: areas.to_vec(),
            rest: (0..n).map(rest).collect(),
            ends: mirrors.iter().map(|m| 1.0 - m).collect(),
            ..FormFactors::default()
        },
        rows: RowTable {
            names: (0..n).map(|i| format!("row {i}")).collect(),
            ..RowTable::default()
        },
        outside: None,
        sky: None,
        elsewhere: None,
    }
}

/// Numbers in 0..1 that depend on a seed.
fn numbers(seed: u32) -> impl FnMut() -> f64 {
    let mut state = u64::from(seed) + 0x9e37_79b9_7f4a_7c15;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as f64 / f64::from(1u32 << 31)
    }
}

/// A closed enclosure with mirrors, whose rows close to rounding.
pub fn random_enclosure(n: usize, seed: u32) -> Enclosure {
    let mut next = numbers(seed);
    let areas: Vec<f64> = (0..n).map(|_| 0.5 + next()).collect();
    let mirrors: Vec<f64> = (0..n)
        .map(|_| if next() < 0.4 { 0.8 * next() } else { 0.0 })
        .collect();
    let mut s = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in i..n {
            let value = areas[i] * areas[j] * (0.1 + next());
            (s[i][j], s[j][i]) = (value, value);
        }
    }
    // Symmetric scaling until Σ_j S_ij (1 − ρ_s,j) = A_i.
    let mut x = vec![1.0; n];
    for _ in 0..2_000 {
        let mut change = 0.0f64;
        for i in 0..n {
            let sum: f64 = (0..n).map(|j| s[i][j] * x[j] * (1.0 - mirrors[j])).sum();
            let before = x[i];
            x[i] = (before * areas[i] / sum).sqrt();
            change = change.max((x[i] / before - 1.0).abs());
        }
        if change < 1e-15 {
            break;
        }
    }
    for (row, xi) in s.iter_mut().zip(&x) {
        row.iter_mut().zip(&x).for_each(|(s, xj)| *s *= xi * xj);
    }
    enclosure_of(&areas, &s, &mirrors)
}

fn grey<'a>(enclosure: &'a Enclosure, emissivity: &[f64]) -> SurfaceBand<'a> {
    SurfaceBand {
        enclosure,
        range: SpectralRange::Thermal,
        emissivity: emissivity.to_vec(),
    }
}

/// Each row a node.
pub fn each_row(count: usize) -> Groups {
    Groups {
        of_rows: (0..count as u32).map(Some).collect(),
        names: (0..count).map(|i| format!("row {i}")).collect(),
    }
}

fn solve_heat(
    bands: &[SurfaceBand],
    conditions: &[RowCondition],
    nodes: &Groups,
) -> Result<HeatBalance, ExchangeError> {
    let problem = HeatProblem {
        bands,
        conditions,
        surroundings: [3.0, 3.0],
        solar: &[],
    };
    heat_balance(&problem, nodes, &Progress::new())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Σ_b B_ab = 1, GR_ab = GR_ba of both solutions, and Σ_b GR_ab = ε_a A_a.
    #[test]
    fn random_enclosures_balance(n in 3usize..40, seed in 0u32..10_000) {
        let enclosure = random_enclosure(n, seed);
        let mut next = numbers(seed + 1);
        let ends = &enclosure.factors.ends;
        let emissivity: Vec<f64> = ends.iter().map(|e| e * (0.02 + 0.98 * next())).collect();
        let band = grey(&enclosure, &emissivity);
        let network = exchange_factors(&band, &each_row(n), &Progress::new()).unwrap();
        prop_assert!(network.asymmetry < 1e-11, "{}", network.asymmetry);
        for sum in network.row_sums() {
            prop_assert!((sum - 1.0).abs() < 1e-10, "{sum}");
        }
        for a in 0..n {
            for b in 0..n {
                prop_assert_eq!(network.conductance(a, b), network.conductance(b, a));
            }
        }
    }

    /// Temperatures give fluxes, which give the temperatures back; and all heat is accounted for.
    #[test]
    fn fluxes_give_temperatures_back(n in 3usize..30, seed in 0u32..10_000) {
        let enclosure = random_enclosure(n, seed);
        let mut next = numbers(seed + 2);
        let ends = &enclosure.factors.ends;
        let emissivity: Vec<f64> = ends.iter().map(|e| e * (0.05 + 0.95 * next())).collect();
        let bands = [grey(&enclosure, &emissivity)];
        let given: Vec<RowCondition> =
            (0..n).map(|_| RowCondition::Temperature(250.0 + 500.0 * next())).collect();
        let nodes = each_row(n);
        let first = solve_heat(&bands, &given, &nodes).unwrap();
        let heat: f64 = first.node_heat.iter().sum();
        let scale: f64 = first.node_heat.iter().map(|q| q.abs()).sum();
        prop_assert!(heat.abs() < 1e-10 * scale, "{heat} of {scale}");
        let swapped: Vec<RowCondition> = (0..n)
            .map(|i| if i == 0 { given[0] } else { RowCondition::Flux(first.fluxes[i]) })
            .collect();
        let second = solve_heat(&bands, &swapped, &nodes).unwrap();
        for (a, b) in first.temperatures.iter().zip(&second.temperatures) {
            prop_assert!((a - b).abs() < 1e-8 * a, "{a} {b}");
        }
    }
}

/// Two infinite plates of one square metre each.
fn plates(mirrors: [f64; 2]) -> Enclosure {
    let [m1, m2] = mirrors;
    let both = 1.0 / (1.0 - m1 * m2);
    enclosure_of(
        &[1.0, 1.0],
        &[vec![m2 * both, both], vec![both, m1 * both]],
        &mirrors,
    )
}

#[test]
fn plates_exchange_as_the_textbook_says_however_they_reflect() {
    for (mirrors, emissivity, expected) in [
        ([0.0, 0.0], [0.8, 0.3], 0.279_069_767_441_860),
        ([0.2, 0.7], [0.8, 0.3], 0.279_069_767_441_860),
        ([0.2, 0.3], [0.3, 0.6], 0.25),
    ] {
        let enclosure = plates(mirrors);
        let band = grey(&enclosure, &emissivity);
        let network = exchange_factors(&band, &each_row(2), &Progress::new()).unwrap();
        let (conductance, _) = network.conductance(0, 1);
        assert!((conductance - expected).abs() < 1e-14, "{conductance}");
        let (b, script_f) = (network.gebhart(0, 1).0, network.script_f(1, 0).0);
        assert!((b * emissivity[0] - expected).abs() < 1e-14);
        assert!((script_f - expected).abs() < 1e-14);
    }
}

#[test]
fn units_are_square_metres() {
    let mut enclosure = plates([0.0, 0.0]);
    enclosure.rows.metres_per_unit = Some(0.1);
    let band = grey(&enclosure, &[0.8, 0.3]);
    let network = exchange_factors(&band, &each_row(2), &Progress::new()).unwrap();
    assert!((network.conductance(0, 1).0 - 0.002_790_697_674_418).abs() < 1e-15);
    assert_eq!(network.areas[0], 0.1f64.powi(2));
}

#[test]
fn bands_of_plates_add_up_with_newton_too() {
    // Below 4 µm ε = 0.9 and 0.2, above 0.1 and 0.8; 1500 K against 300 K.
    let enclosure = plates([0.0, 0.0]);
    let band = |low: f64, high: f64, emissivity: [f64; 2]| SurfaceBand {
        enclosure: &enclosure,
        range: SpectralRange::Between(low, high),
        emissivity: emissivity.to_vec(),
    };
    let bands = [
        band(0.0, 4.0, [0.9, 0.2]),
        band(4.0, f64::INFINITY, [0.1, 0.8]),
    ];
    let given = [
        RowCondition::Temperature(1500.0),
        RowCondition::Temperature(300.0),
    ];
    let balance = solve_heat(&bands, &given, &each_row(2)).unwrap();
    assert!((balance.fluxes[0] / 48_736.125_627_032_8 - 1.0).abs() < 1e-12);
    let given = [
        RowCondition::Flux(balance.fluxes[0]),
        RowCondition::Temperature(300.0),
    ];
    let back = solve_heat(&bands, &given, &each_row(2)).unwrap();
    assert!(
        (back.temperatures[0] - 1500.0).abs() < 1e-6,
        "{}",
        back.temperatures[0]
    );
    assert!(back.iterations > 1);
}

#[test]
fn the_sun_heats_a_plate_in_space() {
    let enclosure = enclosure_of(&[1.0], &[vec![0.0]], &[0.0]);
    let thermal = grey(&enclosure, &[0.8]);
    let solar = SurfaceBand {
        range: SpectralRange::Solar,
        emissivity: vec![0.2],
        ..thermal.clone()
    };
    let problem = HeatProblem {
        bands: &[thermal, solar],
        conditions: &[RowCondition::Flux(0.0)],
        surroundings: [0.0, 0.0],
        solar: &[1361.0],
    };
    let balance = heat_balance(&problem, &each_row(1), &Progress::new()).unwrap();
    let t = balance.temperatures[0];
    assert!((t - 278.321_399_358_4).abs() < 1e-8, "{t}");
    assert_eq!(balance.solar, [1361.0 * 0.2]);
    assert!((balance.to_surroundings[0] - 1361.0 * 0.2).abs() < 1e-9);
}

#[test]
fn what_cannot_be_solved_is_refused_in_sentences() {
    let enclosure = plates([0.0, 0.0]);
    let flux = |q: f64| RowCondition::Flux(q);
    let refusal = |emissivity: &[f64], conditions: &[RowCondition]| {
        let bands = [grey(&enclosure, emissivity)];
        solve_heat(&bands, conditions, &each_row(2)).unwrap_err()
    };
    let floating = refusal(&[0.5, 0.5], &[flux(1.0), flux(-1.0)]);
    assert!(
        matches!(&floating, ExchangeError::Floating { rows: 2, .. }),
        "{floating}"
    );
    let given = RowCondition::Temperature(300.0);
    let mirror = refusal(&[0.5, 0.0], &[given, flux(7.0)]);
    assert!(
        mirror.to_string().contains("\"row 1\" has emissivity 0"),
        "{mirror}"
    );
    let cold = refusal(&[0.5, 0.5], &[given, flux(-9_000.0)]);
    assert!(cold.to_string().contains("absolute zero"), "{cold}");
    // Without emission and without flux it reradiates.
    let bands = [grey(&enclosure, &[0.5, 0.0])];
    let adiabatic = solve_heat(&bands, &[given, flux(0.0)], &each_row(2)).unwrap();
    assert!((adiabatic.temperatures[1] - 300.0).abs() < 1e-9);
    let grows = enclosure_of(&[1.0, 1.0], &[vec![0.0, 1.3], vec![1.3, 0.0]], &[0.0, 0.0]);
    let band = grey(&grows, &[0.01, 0.01]);
    let refused = exchange_factors(&band, &each_row(2), &Progress::new()).unwrap_err();
    assert!(matches!(refused, ExchangeError::Grows { .. }), "{refused}");
}

/// Standard errors against changes of the factors, one at a time.
#[test]
fn errors_are_those_of_small_changes() {
    let n = 6;
    let step = 1e-6;
    let mut enclosure = random_enclosure(n, 3);
    let emissivity: Vec<f64> = enclosure.factors.ends.iter().map(|e| 0.6 * e).collect();
    let nodes = Groups {
        of_rows: (0..n as u32).map(|i| Some(i / 2)).collect(),
        names: vec!["a".into(), "b".into(), "c".into()],
    };
    let conditions: Vec<RowCondition> = (0..n)
        .map(|i| match i {
            0 | 1 => RowCondition::Temperature(600.0),
            2 | 3 => RowCondition::Temperature(300.0),
            _ => RowCondition::Flux(50.0),
        })
        .collect();
    let changed = |enclosure: &Enclosure, at: Option<(usize, usize)>| {
        let mut other = enclosure.clone();
        let rows = (0..n).map(|i| {
            let mut row = other.factors.exchange.upper(i).to_vec();
            for e in &mut row {
                e.error = 0.01 * (1 + i) as f32;
                if at == Some((i, e.column as usize)) {
                    e.value += step;
                }
            }
            row
        });
        other.factors.exchange = rows.collect();
        other
    };
    enclosure = changed(&enclosure, None);
    let results = |enclosure: &Enclosure| {
        let bands = [grey(enclosure, &emissivity)];
        let factors = exchange_factors(&bands[0], &nodes, &Progress::new()).unwrap();
        let heat = solve_heat(&bands, &conditions, &nodes).unwrap();
        (factors, heat)
    };
    let (factors, heat) = results(&enclosure);
    let (mut conductance, mut flux, mut temperature) = ([0.0f64; 2], 0.0, 0.0);
    for i in 0..n {
        for j in i..n {
            let (f, h) = results(&changed(&enclosure, Some((i, j))));
            let error = 0.01 * (1 + i) as f64;
            let slope = |new: f64, old: f64| (error * (new - old) / step).powi(2);
            conductance[0] += slope(f.conductance(0, 1).0, factors.conductance(0, 1).0);
            conductance[1] += slope(f.conductance(2, 2).0, factors.conductance(2, 2).0);
            flux += slope(h.node_heat[0], heat.node_heat[0]);
            temperature += slope(h.node_temperatures[2], heat.node_temperatures[2]);
        }
    }
    let check = |stated: f64, variance: f64, what: &str| {
        let ratio = stated / variance.sqrt();
        assert!((ratio - 1.0).abs() < 0.02, "{what}: {ratio}");
    };
    check(
        factors.conductance(0, 1).1,
        conductance[0],
        "GR between nodes",
    );
    check(factors.conductance(2, 2).1, conductance[1], "GR of a node");
    check(heat.node_heat_errors[0], flux, "heat");
    check(heat.node_temperature_errors[2], temperature, "temperature");
    assert_eq!(
        (heat.node_temperature_errors[0], heat.node_heat_errors[2]),
        (0.0, 0.0)
    );
}

/// The same enclosure with its matrix in blocks, all but `tolerance` of it.
fn in_blocks(enclosure: &Enclosure, tolerance: f64) -> Enclosure {
    let mut next = numbers(17);
    let mut point = || DVec3::new(next(), next(), next());
    let places: Vec<PointNormal> = (0..enclosure.len())
        .map(|_| PointNormal {
            position: point(),
            normal: point().normalize(),
        })
        .collect();
    let options = CompressionOptions {
        tolerance,
        keep_sums: true,
    };
    let compressed =
        CompressedFactors::new(&enclosure.factors, &places, &options, &Progress::new()).unwrap();
    let mut other = enclosure.clone();
    other.factors.exchange = ExchangeAreas::new();
    other.elsewhere = Some(Arc::new(compressed));
    other
}

/// Networks and heat balances of blocks are those of the matrix: factored, and by iterations.
#[test]
fn blocks_exchange_what_the_matrix_does() {
    for n in [60usize, 2_100] {
        let enclosure = random_enclosure(n, 9);
        let blocks = in_blocks(&enclosure, 1e-6);
        let ends = &enclosure.factors.ends;
        let emissivity: Vec<f64> = ends.iter().map(|e| 0.6 * e).collect();
        let nodes = Groups {
            of_rows: (0..n as u32).map(|i| Some(i % 3)).collect(),
            names: vec!["a".into(), "b".into(), "c".into()],
        };
        let conditions: Vec<RowCondition> = (0..n)
            .map(|i| match i % 3 {
                0 => RowCondition::Temperature(600.0),
                1 => RowCondition::Temperature(300.0),
                _ => RowCondition::Flux(50.0),
            })
            .collect();
        let two = |enclosure| {
            let grey = grey(enclosure, &emissivity);
            let range = |low, high| SurfaceBand {
                range: SpectralRange::Between(low, high),
                ..grey.clone()
            };
            let bands = [range(0.0, 6.0), range(6.0, f64::INFINITY)];
            let network = exchange_factors(&grey, &nodes, &Progress::new()).unwrap();
            let heat = solve_heat(&[grey], &conditions, &nodes).unwrap();
            (
                network,
                heat,
                solve_heat(&bands, &conditions, &nodes).unwrap(),
            )
        };
        let ((a, heat, banded), (b, other, other_banded)) = (two(&enclosure), two(&blocks));
        for (a, b) in a.conductances.iter().zip(&b.conductances) {
            assert!((a - b).abs() < 1e-5 * a, "{n}: {a} {b}");
        }
        assert!(b.asymmetry < 1e-9, "{n}: {}", b.asymmetry);
        assert!(other_banded.iterations > 0);
        for (one, other) in [(heat, other), (banded, other_banded)] {
            let rows = one.temperatures.iter().zip(&other.temperatures);
            for (a, b) in rows {
                assert!((a - b).abs() < 1e-4 * a, "{n}: {a} {b}");
            }
            assert!(one.node_heat_errors == [0.0; 3] && other.node_heat_errors == [0.0; 3]);
        }
    }
    // What floats is found in blocks too.
    let blocks = in_blocks(&random_enclosure(12, 1), 1e-3);
    let bands = [grey(&blocks, &[0.1; 12])];
    let floats = solve_heat(&bands, &[RowCondition::Flux(1.0); 12], &each_row(12)).unwrap_err();
    assert!(
        matches!(floats, ExchangeError::Floating { rows: 12, .. }),
        "{floats}"
    );
}
