//! Matrices chosen by mirrors, lumping, truncation, and files.

use super::*;
use crate::thermal::network::ExchangeError;
use crate::thermal::tables::{BoundaryTable, MaterialTable};
use azulejo_factors::FormFactors;
use azulejo_factors::form_factors::{Exchange, ExchangeAreas, RowRemainder};
use azulejo_formats::numpy::npz::NpzReader;
use std::io::Cursor;

/// Rows of unit area that see each other with these factors; what they lack goes to the sky.
fn matrix(factors: &[&[f64]], names: &[&str], mirrors: &[f64]) -> Enclosure {
    let n = factors.len();
    let upper = |i: usize| -> Vec<Exchange> {
        let entry = |j: usize| Exchange {
            column: j as u32,
            value: factors[i][j],
            error: 1e-4,
        };
        (i..n).map(entry).filter(|e| e.value > 0.0).collect()
    };
    let rest = |i: usize| RowRemainder {
        sky: 1.0
            - (0..n)
                .map(|j| factors[i][j] * (1.0 - mirrors[j]))
                .sum::<f64>(),
        ..RowRemainder::default()
    };
    let exchange = (0..n).map(upper).collect::<ExchangeAreas>();
    Enclosure {
        factors: FormFactors {
            exchange,
            areas: vec![1.0; n],
            rest: (0..n).map(rest).collect(),
            ends: mirrors.iter().map(|m| 1.0 - m).collect(),
            ..FormFactors::default()
        },
        rows: crate::RowTable {
            names: names.iter().map(|n| (*n).to_owned()).collect(),
            ..crate::RowTable::default()
        },
        outside: None,
        sky: None,
        elsewhere: None,
    }
}

/// Two plates that see each other alone.
fn plates(mirrors: [f64; 2]) -> Enclosure {
    let [m1, m2] = mirrors;
    let both = 1.0 / (1.0 - m1 * m2);
    let rows: [&[f64]; 2] = [&[m2 * both, both], &[both, m1 * both]];
    matrix(&rows, &["hot", "cold"], &mirrors)
}

fn model(matrices: Vec<Enclosure>, materials: &str, boundary: Option<&str>) -> ThermalModel {
    let table = MaterialTable::read(materials).unwrap();
    let first = &matrices[0];
    let properties = table.of_rows(first).unwrap();
    let boundary = boundary.map(|text| BoundaryTable::read(text).unwrap());
    ThermalModel {
        bands: table
            .bands
            .iter()
            .map(|b| b.range)
            .zip(properties)
            .collect(),
        conditions: boundary.as_ref().map(|b| b.of_rows(first).unwrap()),
        surroundings: boundary.map_or([None; 2], |b| b.surroundings),
        nodes: None,
        lump: false,
        matrices: matrices
            .into_iter()
            .enumerate()
            .map(|(k, e)| (format!("matrix {k}"), e))
            .collect(),
    }
}

fn solved(model: ThermalModel) -> ThermalSolution {
    model.solve(&Progress::new()).unwrap()
}

const GREY: &str = "name,eps,rho_s\nhot,0.8,0\ncold,0.5,0\n";

/// GR of parallel plates is 1 / (1/ε₁ + 1/ε₂ − 1), with and without mirrors.
#[test]
fn parallel_plates() {
    for (table, mirrors) in [
        (GREY, [0.0, 0.0]),
        ("name,eps,rho_s\nhot,0.8,0.2\ncold,0.5,0.4\n", [0.2, 0.4]),
    ] {
        let solution = solved(model(vec![plates(mirrors)], table, None));
        let (gr, _) = solution.networks[0].1.conductance(0, 1);
        assert!((gr - 1.0 / (1.0 / 0.8 + 1.0 / 0.5 - 1.0)).abs() < 1e-12);
        assert!(ThermalSolution::closure(&solution.networks[0].1) < 1e-12);
        assert_eq!(solution.imbalance(), None);
    }
}

#[test]
fn each_band_takes_the_matrix_of_its_mirrors() {
    let table = "name,eps@0-4,rho_s@0-4,eps@4-inf\nhot,0.5,0.5,0.9\ncold,0.5,0,0.9\n";
    let matrices = vec![plates([0.0, 0.0]), plates([0.5, 0.0])];
    let solution = solved(model(matrices, table, None));
    let gr = |k: usize| solution.networks[k].1.conductance(0, 1).0;
    assert!((gr(0) - 1.0 / 3.0).abs() < 1e-12);
    assert!((gr(1) - 1.0 / (2.0 / 0.9 - 1.0)).abs() < 1e-12);
    let refused = model(vec![plates([0.0, 0.0])], table, None).solve(&Progress::new());
    let message = refused.unwrap_err().to_string();
    assert!(
        message.contains("matrix 0") && message.contains("\"hot\"") && message.contains("0-4"),
        "{message}"
    );
}

#[test]
fn matrices_of_other_rows_are_refused() {
    let mut other = plates([0.0, 0.0]);
    other.rows.names[1] = "lid".into();
    let refused = model(vec![plates([0.0, 0.0]), other], GREY, None).solve(&Progress::new());
    let message = refused.unwrap_err().to_string();
    assert_eq!(message, "matrix 1: its rows are not those of matrix 0");
}

#[test]
fn heat_balances_and_unknown_surroundings_are_said() {
    let rows: [&[f64]; 2] = [&[0.0, 0.7], &[0.7, 0.0]];
    let open = matrix(&rows, &["hot", "cold"], &[0.0, 0.0]);
    let solution = solved(model(
        vec![open],
        GREY,
        Some("name,T,q\nhot,500,\ncold,,0\n"),
    ));
    assert!(solution.imbalance().unwrap().abs() < 1e-9);
    assert_eq!(
        solution.notes,
        ["no temperature of the sky is given: 3 K, that of space, is taken"]
    );
    let heat = solution.heat.unwrap();
    assert!(heat.to_surroundings[0] > 1.0 && heat.node_heat[1].abs() < 1e-9);
}

#[test]
fn sunlight_without_absorptance_or_by_mirrors_is_said() {
    let boundary = "name,T,solar\nhot,500,100\ncold,300,0\n";
    let solution = solved(model(vec![plates([0.0, 0.0])], GREY, Some(boundary)));
    assert!(solution.notes[0].starts_with("sunlight has no effect"));
    let table = "name,eps,alpha,rho_s@solar\nhot,0.5,0.3,0.5\ncold,0.5,0.5,0\n";
    let matrices = vec![plates([0.0, 0.0]), plates([0.5, 0.0])];
    let solution = solved(model(matrices, table, Some(boundary)));
    assert!(solution.notes[0].starts_with("sunlight that mirrors reflect"));
    let heat = solution.heat.as_ref().unwrap();
    let absorbed: f64 = heat.solar.iter().sum();
    assert!((30.0..70.0).contains(&absorbed), "{absorbed}");
    assert!(solution.imbalance().unwrap().abs() < 1e-9);
}

/// Three rows of two objects.
fn three() -> Enclosure {
    let rows: [&[f64]; 3] = [&[0.0, 0.1, 0.9], &[0.1, 0.0, 0.9], &[0.9, 0.9, 0.0]];
    let mut three = matrix(&rows, &["a/0", "a/1", "b/0"], &[0.0; 3]);
    three.rows.objects = vec!["a".into(), "b".into()];
    three.factors.faces = [(0, 0), (0, 1), (1, 0)]
        .map(|(object, face)| azulejo_factors::FaceId { object, face })
        .into();
    three.factors.is_back = vec![false; 3];
    three.factors.materials = vec![0; 3];
    three
}

#[test]
fn nodes_are_lumped_only_if_they_are_even() {
    let even = "name,eps\na,0.5\nb,0.7\n";
    let by_object = |table: &str, boundary: Option<&str>| ThermalModel {
        nodes: Some(GroupBy::Object),
        lump: true,
        ..model(vec![three()], table, boundary)
    };
    let solution = solved(by_object(even, Some("name,T\na,300\nb,400\n")));
    assert_eq!(solution.nodes.names, ["a", "b"]);
    assert_eq!(solution.enclosure.len(), 2);
    assert_eq!(solution.heat.unwrap().temperatures, [300.0, 400.0]);
    let uneven = by_object("name,eps\na/0,0.5\na/1,0.6\nb,0.7\n", None);
    let message = uneven.solve(&Progress::new()).unwrap_err().to_string();
    assert!(
        message.contains("\"a\" have eps from 0.5 to 0.6"),
        "{message}"
    );
    let uneven = by_object(even, Some("name,T\na/0,300\na/1,301\nb,400\n"));
    assert_eq!(
        uneven.solve(&Progress::new()).unwrap_err(),
        ModelError::UnevenConditions { node: "a".into() }
    );
    let uneven = by_object(even, Some("name,T,solar\na/0,300,5\na/1,300,\nb,400,\n"));
    assert!(uneven.solve(&Progress::new()).is_err());
}

#[test]
fn adiabatic_enclosures_are_refused() {
    let model = model(vec![plates([0.0, 0.0])], GREY, Some("name,q\n*,0\n"));
    assert!(matches!(
        model.solve(&Progress::new()),
        Err(ModelError::Exchange(ExchangeError::Floating { .. }))
    ));
}

fn text(solution: &ThermalSolution, format: SolutionFormat, truncate: Option<f64>) -> String {
    let mut out = Vec::new();
    let options = SolutionOptions {
        truncate,
        ..SolutionOptions::default()
    };
    solution.write(format, &options, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

/// What lists leave out goes to the other pairs of both nodes.
#[test]
fn truncated_lists_keep_sums() {
    let rows: [&[f64]; 4] = [
        &[0.0, 0.001, 0.5, 0.499],
        &[0.001, 0.0, 0.499, 0.5],
        &[0.5, 0.499, 0.0, 0.001],
        &[0.499, 0.5, 0.001, 0.0],
    ];
    let black = matrix(&rows, &["a", "b", "c", "d"], &[0.0; 4]);
    let solution = solved(model(vec![black], "name,eps\n*,1\n", None));
    let pairs = |text: &str| -> Vec<(String, f64)> {
        let fields = text
            .lines()
            .skip(1)
            .map(|l| l.split(',').collect::<Vec<_>>());
        fields
            .map(|f| (format!("{}{}", f[0], f[1]), f[2].parse().unwrap()))
            .collect()
    };
    let every = pairs(&text(&solution, SolutionFormat::Csv, None));
    assert_eq!(every.len(), 6);
    let kept = pairs(&text(&solution, SolutionFormat::Csv, Some(0.01)));
    assert_eq!(kept.len(), 4);
    let sum_at_a: f64 = kept
        .iter()
        .filter(|(p, _)| p.contains('a'))
        .map(|p| p.1)
        .sum();
    assert!((sum_at_a - 1.0).abs() < 1e-9, "{sum_at_a}");
}

#[test]
fn bands_have_a_column() {
    let table = "name,eps@0-4,eps@4-inf\n*,0.5,0.9\n";
    let solution = solved(model(vec![plates([0.0, 0.0])], table, None));
    let list = text(&solution, SolutionFormat::Csv, None);
    let lines: Vec<&str> = list.lines().collect();
    assert_eq!(lines[0], "band_um,from,to,gr_m2,std_error");
    assert_eq!(lines.len(), 3);
    assert!(lines[1].starts_with("0-4,hot,cold,0.333") && lines[2].starts_with("4-inf,hot,cold,"));
    let refused = solution.write(
        SolutionFormat::Esatan,
        &SolutionOptions::default(),
        &mut Vec::new(),
    );
    assert!(refused.unwrap_err().to_string().contains("several"));
}

#[test]
fn networks_are_written_without_temperatures() {
    let table = "name,eps@0-4,eps@4-inf\n*,0.5,0.9\n";
    let boundary = Some("name,T\nhot,500\ncold,300\n");
    let solution = solved(model(vec![plates([0.0, 0.0])], table, boundary));
    let text = |format: SolutionFormat, part: SolutionPart| {
        let options = SolutionOptions {
            part,
            ..SolutionOptions::default()
        };
        let mut out = Vec::new();
        let written = solution.write(format, &options, &mut out);
        written.map(|()| String::from_utf8(out).unwrap())
    };
    let whole = text(SolutionFormat::Csv, SolutionPart::Whole).unwrap();
    assert!(whole.starts_with("name,area,T,"), "{whole}");
    let networks = text(SolutionFormat::Csv, SolutionPart::Networks).unwrap();
    assert!(networks.starts_with("band_um,from,to,"), "{networks}");
    assert_eq!(networks.lines().count(), 3);
    let second = text(SolutionFormat::Csv, SolutionPart::Network(1)).unwrap();
    assert_eq!(second.lines().count(), 2);
    assert!(second.contains("4-inf,hot,cold,"), "{second}");
    // Thermal programs take the conductances of one band.
    assert!(text(SolutionFormat::Esatan, SolutionPart::Networks).is_err());
    assert!(text(SolutionFormat::Esatan, SolutionPart::Network(0)).is_ok());
    assert!(text(SolutionFormat::Vtu, SolutionPart::Networks).is_err());
}

#[test]
fn heat_beyond_floating_point_is_refused() {
    for boundary in [
        "name,T\nhot,1e200\ncold,3\n",
        "name,T,q\nhot,,1e305\ncold,3,\n",
    ] {
        let solved = model(vec![plates([0.0, 0.0])], GREY, Some(boundary)).solve(&Progress::new());
        let Err(ModelError::Exchange(ExchangeError::TooHot { row })) = solved else {
            panic!("{boundary}");
        };
        assert_eq!(row, "hot");
    }
}

#[test]
fn archives_have_everything() {
    let boundary = "name,T,q\nhot,500,\ncold,,0\n";
    let solution = solved(model(vec![plates([0.0, 0.0])], GREY, Some(boundary)));
    let mut out = Vec::new();
    let options = SolutionOptions::default();
    solution
        .write(SolutionFormat::Archive, &options, &mut out)
        .unwrap();
    let archive = NpzReader::new(Cursor::new(out), 1 << 20).unwrap();
    let names = archive.names();
    for name in [
        "GR", "GR_error", "B", "script_F", "names", "T", "q", "node_T", "row_node",
    ] {
        assert!(
            names.iter().any(|n| n == name),
            "{name} is not in {names:?}"
        );
    }
    assert!(matches!(
        solution.heat.as_ref().map(|h| h.temperatures[1]),
        Some(t) if (t - 500.0).abs() < 1e-9
    ));
    let text = text(&solution, SolutionFormat::Csv, None);
    assert!(
        text.starts_with("name,area,T,T_error,Q,Q_error\nhot,1,500,0,"),
        "{text}"
    );
}

#[test]
fn factors_that_lose_heat_are_named() {
    let boundary = "name,T,q\nhot,500,\ncold,300,\n";
    let lossy = |error: f32| {
        let mut pair = matrix(&[&[0.0, 0.5], &[0.5, 0.0]], &["hot", "cold"], &[0.0; 2]);
        pair.factors.rest[1].sky = 0.0;
        let known = pair.factors.exchange.get(0, 1).value;
        let entry = Exchange {
            column: 1,
            value: known,
            error,
        };
        pair.factors.exchange = ExchangeAreas::from_iter([vec![entry], vec![]]);
        solved(model(vec![pair], GREY, Some(boundary))).notes
    };
    let message = &lossy(1e-4)[0];
    assert!(
        message.contains("of \"cold\" lack 50.00% of its light"),
        "{message}"
    );
    assert!(lossy(0.2)[0].starts_with("no temperature"), "noise");
}
