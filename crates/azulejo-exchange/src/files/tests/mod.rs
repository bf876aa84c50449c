//! Small files in every format.

mod calculix;
mod udales;
mod vtu;

use super::*;
use crate::enclosure::tests::fronts;
use crate::enclosure::{CellMesh, OutsideLight};
use azulejo_factors::form_factors::{Exchange, ExchangeAreas};
use glam::DVec3;

/// Rows of so large areas, each an object, with exchange areas of pairs.
pub(in crate::files) fn rows(
    areas: &[f64],
    names: &[&str],
    pairs: &[(u32, u32, f64)],
) -> Enclosure {
    let row = |i: u32| -> Vec<Exchange> {
        let mut row: Vec<Exchange> = (pairs.iter().filter(|p| p.0 == i))
            .map(|&(_, column, value)| Exchange {
                column,
                value,
                error: 0.0,
            })
            .collect();
        row.sort_by_key(|e| e.column);
        row
    };
    let exchange = (0..areas.len() as u32).map(row).collect();
    let mut enclosure = fronts(areas.to_vec(), exchange);
    enclosure.rows.objects = names.iter().map(|n| (*n).to_owned()).collect();
    enclosure.rows.names = names.iter().map(|n| format!("{n}/0")).collect();
    enclosure
}

/// Two plates, of which the second is twice as large as the first.
pub(in crate::files) fn plates() -> Enclosure {
    rows(&[1.0, 2.0], &["hot", "cold"], &[(0, 1, 0.2), (1, 1, 0.5)])
}

/// The same with light that came by a mirror.
fn with_mirror() -> Enclosure {
    let mut enclosure = plates();
    enclosure.factors.ends = vec![1.0, 0.5];
    enclosure
}

fn bytes(enclosure: &Enclosure, format: FactorFormat, options: &FileOptions) -> Vec<u8> {
    let mut out = Vec::new();
    write(enclosure, format, options, &mut out).unwrap();
    out
}

fn text(enclosure: &Enclosure, format: FactorFormat) -> String {
    String::from_utf8(bytes(enclosure, format, &FileOptions::default())).unwrap()
}

fn refusal(enclosure: &Enclosure, format: FactorFormat, options: &FileOptions) -> String {
    write(enclosure, format, options, &mut Vec::new())
        .unwrap_err()
        .to_string()
}

#[test]
fn matrix_market() {
    assert_eq!(
        text(&plates(), FactorFormat::MatrixMarket),
        "%%MatrixMarket matrix coordinate real general\n% 1 hot/0\n% 2 cold/0\n2 2 3\n\
         1 2 2e-1\n2 1 1e-1\n2 2 2.5e-1\n"
    );
}

#[test]
fn elmer() {
    assert_eq!(
        text(&plates(), FactorFormat::Elmer),
        "1\n1 2 0.2\n2\n2 1 0.1\n2 2 0.25\n"
    );
    let mut expected = vec![2, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0];
    expected.extend(0.2f64.to_le_bytes());
    expected.extend([2, 0, 0, 0, 1, 0, 0, 0]);
    expected.extend(0.1f64.to_le_bytes());
    expected.extend([2, 0, 0, 0]);
    expected.extend(0.25f64.to_le_bytes());
    let options = FileOptions::default();
    assert_eq!(
        bytes(&plates(), FactorFormat::ElmerBinary, &options),
        expected
    );
}

#[test]
fn moose() {
    let mut enclosure = plates();
    enclosure.rows.objects[0] = "hot plate".into();
    let mut out = Vec::new();
    let notes = write(
        &enclosure,
        FactorFormat::Moose,
        &FileOptions::default(),
        &mut out,
    )
    .unwrap();
    assert_eq!(
        notes,
        ["1 names are not words, and are written as such: \"hot plate\" as hot_plate"]
    );
    assert_eq!(
        String::from_utf8(out).unwrap(),
        "[UserObjects]\n  [surface_radiation]\n    type = ConstantViewFactorSurfaceRadiation\n    \
         # Add temperature = VARIABLE, and fixed_temperature_boundary or adiabatic_boundary.\n    \
         boundary = '\n      hot_plate cold\n    '\n    # What the materials of the model absorb.\n    \
         emissivity = '\n      0.8 0.8\n    '\n    view_factors = '\n      0 0.2 ;\n      0.1 0.25\n    \
         '\n  []\n[]\n"
    );
}

#[test]
fn nastran() {
    assert_eq!(
        text(&plates(), FactorFormat::Nastran),
        "$ 1 = hot/0\n$ 2 = cold/0\n\
         RADLST*                1               1               1               2\n*\n\
         RADMTX*                1               1 0.000000000E+00 2.000000000E-01\n*\n\
         RADMTX*                1               2 5.000000000E-01\n*\n"
    );
    let mut enclosure = plates();
    enclosure.rows.objects = vec!["70".into(), "12".into()];
    assert_eq!(
        text(&enclosure, FactorFormat::NastranClassic),
        "$ 70 = hot/0\n$ 12 = cold/0\nRADLST*               70              12\n*\n\
         RADMTX*                1 0.000000000E+00 2.000000000E-01\n*\n\
         RADMTX*                2 5.000000000E-01\n*\n"
    );
}

#[test]
fn nastran_leaves_out_zeros_at_the_end_and_continues_lines() {
    let areas = [1.0; 9];
    let names: Vec<String> = (0..9).map(|i| format!("s{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let enclosure = rows(&areas, &names, &[(0, 5, 0.25)]);
    let text = text(&enclosure, FactorFormat::NastranClassic);
    let expected = format!(
        "RADLST*{}\n*       {}\n*       {}\n*\nRADMTX*{}\n*       {}\nRADMTX*{:>17}{:>16}\n*\n",
        "                1               2               3               4",
        "               5               6               7               8",
        "               9",
        "                1 0.000000000E+00 0.000000000E+00 0.000000000E+00",
        " 0.000000000E+00 0.000000000E+00 2.500000000E-01",
        2,
        "0.000000000E+00",
    );
    assert!(text.contains(&expected), "{text}\nexpected\n{expected}");
}

#[test]
fn energyplus_as_idf_and_json() {
    let mut enclosure = plates();
    enclosure.factors.rest[0].sky = 0.8;
    let options = FileOptions {
        zone: Some("Room".into()),
        ..FileOptions::default()
    };
    let mut out = Vec::new();
    let notes = write(&enclosure, FactorFormat::EnergyPlus, &options, &mut out).unwrap();
    assert!(notes[0].starts_with("1 of 2 rows lose light to sky or ground, at most 80% (hot)"));
    assert!(
        notes[1].starts_with("row sums are off by up to 0.65, which EnergyPlus takes as they are")
    );
    assert_eq!(notes.len(), 2);
    assert_eq!(
        String::from_utf8(out).unwrap(),
        "ZoneProperty:UserViewFactors:BySurfaceName,\n  Room,\n  hot, hot, 0,\n  hot, cold, 0.2,\n  \
         cold, hot, 0.1,\n  cold, cold, 0.25;\n"
    );
    enclosure.rows.objects[1] = "a \"b\"".into();
    let json = bytes(&enclosure, FactorFormat::EnergyPlusJson, &options);
    assert_eq!(
        String::from_utf8(json).unwrap(),
        "{\n  \"ZoneProperty:UserViewFactors:BySurfaceName\": {\n    \"Room factors\": {\n      \
         \"zone_or_zonelist_or_space_or_spacelist_name\": \"Room\",\n      \"view_factors\": [\n        \
         {\"from_surface\": \"hot\", \"to_surface\": \"hot\", \"view_factor\": 0},\n        \
         {\"from_surface\": \"hot\", \"to_surface\": \"a \\\"b\\\"\", \"view_factor\": 0.2},\n        \
         {\"from_surface\": \"a \\\"b\\\"\", \"to_surface\": \"hot\", \"view_factor\": 0.1},\n        \
         {\"from_surface\": \"a \\\"b\\\"\", \"to_surface\": \"a \\\"b\\\"\", \"view_factor\": 0.25}\n      \
         ]\n    }\n  }\n}\n"
    );
}

#[test]
fn energyplus_refuses_names_that_it_cannot_read() {
    let check = |name: &str, expected: &str| {
        let mut enclosure = plates();
        enclosure.rows.objects[0] = name.to_owned();
        let message = refusal(
            &enclosure,
            FactorFormat::EnergyPlus,
            &FileOptions::default(),
        );
        assert!(message.contains(expected), "{message}");
    };
    check("a, b", "\"a, b\": it has a comma");
    check("COLD", "\"cold\": it has a twin");
    check(&"x".repeat(101), "it has more than 100 characters");
    check("  ", "it has nothing but blanks");
}

/// A cube of six squares, of which the opposite ones come first.
pub(in crate::files) fn cube() -> Enclosure {
    let names = ["x0", "x1", "y0", "y1", "z0", "z1"];
    let pairs = (0..6u32).flat_map(|i| (i + 1..6).map(move |j| (i, j, 0.2)));
    let mut enclosure = rows(&[1.0; 6], &names, &pairs.collect::<Vec<_>>());
    let square = |k: usize| {
        let (axis, side) = (k / 2, (k % 2) as f64);
        let corner = |(u, v): (f64, f64)| {
            let mut p = [0.0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u, v);
            DVec3::from(p)
        };
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(corner);
        let mut corners = corners.to_vec();
        if side > 0.0 {
            corners.reverse();
        }
        corners
    };
    enclosure.rows.cells = CellMesh::new((0..6).map(square));
    enclosure
}

/// The files of a format of several, by name.
pub(in crate::files) fn files(
    enclosure: &Enclosure,
    format: FactorFormat,
    options: &FileOptions,
) -> (Vec<(String, Vec<u8>)>, Vec<String>) {
    let prepared = format.prepare(enclosure, options).unwrap();
    let content = |file: &FactorFile<'_>| {
        let mut out = Vec::new();
        file.write(&mut out).unwrap();
        (file.name.clone(), out)
    };
    (prepared.files.iter().map(content).collect(), prepared.notes)
}

#[test]
fn diffuse_solvers_get_direct_factors() {
    let mut enclosure = with_mirror();
    for format in [
        FactorFormat::EnergyPlus,
        FactorFormat::CalculiX,
        FactorFormat::Elmer,
        FactorFormat::Moose,
        FactorFormat::Nastran,
    ] {
        let message = refusal(&enclosure, format, &FileOptions::default());
        assert!(message.contains("--separate"), "{message}");
    }
    let exchange = &enclosure.factors.exchange;
    let mut direct = exchange.clone();
    direct.retain(|i, e| i as u32 != e.column);
    let mut mirrored = exchange.clone();
    mirrored.retain(|i, e| i as u32 == e.column);
    let none = ExchangeAreas::from_iter([vec![], vec![]]);
    enclosure.factors.orders = vec![direct, mirrored, none];
    assert_eq!(
        text(&enclosure, FactorFormat::Elmer),
        "1\n1 2 0.2\n1\n2 1 0.1\n"
    );
    // Others show all.
    assert!(text(&enclosure, FactorFormat::MatrixMarket).contains("2 2 3\n"));
}

#[test]
fn a_failing_disk_is_reported() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    for entry in FactorFormat::table() {
        let options = FileOptions {
            case: Some(OpenFoamCase {
                folder: "constant".into(),
                patches: Vec::new(),
                version: openfoam::OpenFoamVersion::V1912,
            }),
            ..udales::experiment()
        };
        let cube = cube();
        let Ok(prepared) = entry.format.prepare(&cube, &options) else {
            // A case without patches has no place for them.
            assert!(entry.name.starts_with("openfoam"), "{}", entry.name);
            continue;
        };
        for file in &prepared.files {
            let error = file.write(&mut Full).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull, "{}", entry.name);
        }
    }
}
