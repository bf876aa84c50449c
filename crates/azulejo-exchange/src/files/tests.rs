//! Small files in every format.

use super::*;
use crate::enclosure::{CellMesh, OutsideLight, RowTable};
use azulejo_factors::form_factors::{Exchange, ExchangeAreas, RowRemainder};
use azulejo_factors::{FaceId, FormFactors};
use azulejo_scene::Rgb;
use glam::DVec3;

/// Rows of so large areas, each an object, with exchange areas of pairs.
pub(super) fn rows(areas: &[f64], names: &[&str], pairs: &[(u32, u32, f64)]) -> Enclosure {
    let n = areas.len();
    let of_row = |i: u32| -> Vec<Exchange> {
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
    let factors = FormFactors {
        exchange: ExchangeAreas::from_iter((0..n as u32).map(of_row)),
        areas: areas.to_vec(),
        faces: (0..n as u32)
            .map(|object| FaceId { object, face: 0 })
            .collect(),
        materials: vec![0; n],
        is_back: vec![false; n],
        rest: vec![RowRemainder::default(); n],
        ends: vec![1.0; n],
        row_errors: vec![0.0; n],
        ..FormFactors::default()
    };
    let names: Vec<String> = names.iter().map(|n| (*n).to_owned()).collect();
    Enclosure {
        factors,
        rows: RowTable {
            names: names.iter().map(|n| format!("{n}/0")).collect(),
            objects: names,
            materials: vec!["grey".into()],
            diffuse: vec![Rgb::grey(0.2); n],
            ..RowTable::default()
        },
        outside: None,
    }
}

/// Two plates, of which the second is twice as large as the first.
pub(super) fn plates() -> Enclosure {
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
    assert_eq!(notes.len(), 1);
    assert!(notes[0].starts_with("1 of 2 rows lose light to sky or ground, at most 80% (hot/0)"));
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
        let found = refusal(
            &enclosure,
            FactorFormat::EnergyPlus,
            &FileOptions::default(),
        );
        assert!(found.contains(expected), "{found}");
    };
    check("a, b", "\"a, b\": it has a comma");
    check("COLD", "\"cold\": it has a twin");
    check(&"x".repeat(101), "it has more than 100 characters");
    check("  ", "it has nothing but blanks");
}

/// A cube of six squares, of which the opposite ones come first.
pub(super) fn cube() -> Enclosure {
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

#[test]
fn calculix_byte_by_byte() {
    let options = FileOptions::default();
    let found = bytes(&plates(), FactorFormat::CalculiX, &options);
    let record = |content: &[u8]| {
        let mark = (content.len() as i32).to_le_bytes();
        [&mark, content, &mark].concat()
    };
    let numbers =
        |numbers: &[f64]| -> Vec<u8> { numbers.iter().flat_map(|f| f.to_le_bytes()).collect() };
    let title = format!("{:80}", "Version 2.20");
    let expected = [
        record(title.as_bytes()),
        record(&numbers(&[0.0, 0.25])),
        // From the second to the first, and back.
        record(&numbers(&[0.1, 0.2])),
        record(&numbers(&[1.0 - 0.2, 1.0 - (0.7 / 2.0)])),
    ]
    .concat();
    assert_eq!(found, expected);
    let newer = FileOptions {
        calculix: Some("2.22".into()),
        ..options
    };
    let found = bytes(&plates(), FactorFormat::CalculiX, &newer);
    assert_eq!(&found[4..17], b"Version 2.22 ");
}

#[test]
fn calculix_writes_the_lower_triangle_by_columns() {
    let enclosure = rows(
        &[1.0, 2.0, 4.0],
        &["a", "b", "c"],
        &[(0, 1, 0.25), (0, 2, 0.5), (1, 2, 1.0)],
    );
    let found = bytes(&enclosure, FactorFormat::CalculiX, &FileOptions::default());
    let start = 4 + 80 + 4 + 4 + 24 + 4 + 4;
    let numbers: Vec<f64> = found[start..start + 48]
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
        .collect();
    assert_eq!(numbers, [0.125, 0.125, 0.25, 0.25, 0.5, 0.5]);
}

#[test]
fn records_longer_than_a_part_are_divided() {
    let enclosure = plates();
    let factors = direct::DirectFactors::new(&enclosure, "").unwrap();
    let mut found = Vec::new();
    calculix::write(&factors, "T", 6, &mut found).unwrap();
    // The second record, after 80 characters in 14 parts: 16 bytes in parts of 6, 6 and 4.
    let second = &found[80 + 14 * 8..];
    let mark = |at: usize| i32::from_le_bytes(second[at..at + 4].try_into().unwrap());
    let marks = [mark(0), mark(10), mark(14), mark(24), mark(28), mark(36)];
    assert_eq!(marks, [-6, 6, -6, -6, 4, -4]);
}

#[test]
fn an_empty_matrix_has_empty_records() {
    let found = bytes(
        &rows(&[], &[], &[]),
        FactorFormat::CalculiX,
        &FileOptions::default(),
    );
    assert_eq!(&found[88..], [0; 24]);
}

/// The files of a format of several, by name.
pub(super) fn files(
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

fn experiment() -> FileOptions {
    FileOptions {
        experiment: Some("042".into()),
        ..FileOptions::default()
    }
}

#[test]
fn udales() {
    let mut enclosure = plates();
    enclosure.factors.rest[0].sky = 0.8;
    enclosure.factors.rest[1].ground = 0.65;
    enclosure.rows.metres_per_unit = Some(2.0);
    enclosure.rows.materials = vec!["3".into()];
    let triangle = |z: f64| {
        vec![
            DVec3::new(0.0, 0.0, z),
            DVec3::X + DVec3::Z * z,
            DVec3::new(0.0, 1.0, z),
        ]
    };
    enclosure.rows.cells =
        CellMesh::new([triangle(0.0), triangle(1.0).into_iter().rev().collect()]);
    let (found, notes) = files(&enclosure, FactorFormat::Udales, &experiment());
    let text = |k: usize| String::from_utf8_lossy(&found[k].1).into_owned();
    let names: Vec<&str> = found.iter().map(|f| f.0.as_str()).collect();
    let expected = ["vfsparse", "vf.nc", "svf", "facetarea", "facets"];
    assert_eq!(names, expected.map(|n| format!("{n}.inp.042")));
    assert_eq!(text(0), "1 2 0.20000000\n2 1 0.10000000\n2 2 0.25000000\n");
    let matrix = &found[1].1;
    // F_11, F_21, F_12, F_22.
    let expected: Vec<u8> = [0.0f32, 0.1, 0.2, 0.25]
        .iter()
        .flat_map(|f| f.to_be_bytes())
        .collect();
    assert_eq!(matrix[matrix.len() - 16..], expected[..]);
    assert_eq!(text(2), "# sky view factors\n0.80000000\n0.00000000\n");
    assert_eq!(text(3), "# area of facets\n4\n8\n");
    assert_eq!(
        text(4),
        "# type, normal\n3 0.0000 0.0000 1.0000\n3 0.0000 0.0000 -1.0000\n"
    );
    assert_eq!(
        notes,
        [
            "1 of 2 rows lose light downwards, at most 65% (cold/0): uDALES expects the ground among \
             the facets",
            "for &ENERGYBALANCE: lvfsparse=.true., nnz=3, and for &WALLS: nfcts=2"
        ]
    );
}

#[test]
fn udales_refuses_rows_that_are_no_facets() {
    let mut enclosure = plates();
    enclosure.factors.is_back[1] = true;
    let found = refusal(&enclosure, FactorFormat::Udales, &experiment());
    assert!(found.contains("found back sides"), "{found}");
    let mut enclosure = plates();
    enclosure.factors.faces[1] = enclosure.factors.faces[0];
    let found = refusal(&enclosure, FactorFormat::Udales, &experiment());
    assert!(
        found.contains("found 2 rows, several of a facet"),
        "{found}"
    );
    let found = refusal(&plates(), FactorFormat::Udales, &FileOptions::default());
    assert!(found.contains("vfsparse.inp.NNN"), "{found}");
    let found = refusal(&plates(), FactorFormat::Udales, &experiment());
    assert!(found.contains("need a folder"), "{found}");
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
        let found = refusal(&enclosure, format, &FileOptions::default());
        assert!(found.contains("--separate"), "{found}");
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

/// An array of a VTU file: its type, components and bytes.
fn vtu_array<'a>(file: &'a [u8], name: &str) -> (String, usize, &'a [u8]) {
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let at = file
        .windows(mark.len())
        .position(|w| w == mark)
        .expect("appended data");
    let xml = std::str::from_utf8(&file[..at]).unwrap();
    let line = xml
        .lines()
        .find(|l| l.contains(&format!("Name=\"{name}\"")))
        .expect("the array");
    let attribute = |key: &str| {
        let (_, rest) = line.split_once(&format!("{key}=\""))?;
        rest.split_once('"').map(|(value, _)| value.to_owned())
    };
    let data = &file[at + mark.len()..];
    let offset: usize = attribute("offset").unwrap().parse().unwrap();
    let length = u64::from_le_bytes(data[offset..offset + 8].try_into().unwrap()) as usize;
    let components = attribute("NumberOfComponents").map_or(1, |c| c.parse().unwrap());
    (
        attribute("type").unwrap(),
        components,
        &data[offset + 8..offset + 8 + length],
    )
}

fn doubles(file: &[u8], name: &str) -> Vec<f64> {
    let (kind, _, bytes) = vtu_array(file, name);
    assert_eq!(kind, "Float64", "{name}");
    bytes
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
        .collect()
}

fn longs(file: &[u8], name: &str) -> Vec<i64> {
    let (kind, _, bytes) = vtu_array(file, name);
    assert_eq!(kind, "Int64", "{name}");
    bytes
        .chunks_exact(8)
        .map(|b| i64::from_le_bytes(b.try_into().unwrap()))
        .collect()
}

#[test]
fn vtu_is_read_back() {
    let mut enclosure = crate::enclosure::tests::two_squares();
    enclosure.factors.ends[1] = 0.75;
    enclosure.outside = Some(vec![OutsideLight::default(); 2]);
    enclosure.outside.as_mut().unwrap()[1].irradiance = Rgb::new(1.0, 2.0, 3.0);
    let options = FileOptions {
        arrays: vec![("T & more".into(), vec![300.0, 400.0])],
        shown_rows: vec!["lid/0 (back)".into()],
        ..FileOptions::default()
    };
    let file = bytes(&enclosure, FactorFormat::Vtu, &options);
    let points = doubles(&file, "Points");
    assert_eq!(points, [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    assert_eq!(vtu_array(&file, "Points").1, 3);
    assert_eq!(longs(&file, "connectivity"), [0, 1, 2, 3, 0, 3, 1]);
    assert_eq!(longs(&file, "offsets"), [4, 7]);
    assert_eq!(vtu_array(&file, "types").2, [9, 5]);
    let (kind, _, rows) = vtu_array(&file, "row");
    assert_eq!(
        (kind.as_str(), rows),
        ("Int32", &[0, 0, 0, 0, 1, 0, 0, 0][..])
    );
    assert_eq!(vtu_array(&file, "side").2, [0, 0, 0, 0, 1, 0, 0, 0]);
    for (name, expected) in [
        ("area", vec![2.0, 1.0]),
        ("sky", vec![0.75, 0.5]),
        ("row_sum", vec![0.25, 0.5]),
        // Three quarters of the light on the second end there.
        ("residual", vec![1.0 - 0.1875 - 0.75, 0.0]),
        ("row_error", vec![0.1, 0.2]),
        ("rho_s", vec![0.0, 0.25]),
        ("diffuse", vec![0.25, 0.25, 0.25, 0.5, 0.25, 0.0]),
        ("irradiance", vec![0.0, 0.0, 0.0, 1.0, 2.0, 3.0]),
        ("T &amp; more", vec![300.0, 400.0]),
        ("F_from_lid/0 (back)", vec![0.5, 0.0]),
    ] {
        assert_eq!(doubles(&file, name), expected, "{name}");
    }
    assert!(file.ends_with(b"\n  </AppendedData>\n</VTKFile>\n"));
}

#[test]
fn vtu_has_cell_types_by_their_corners() {
    let mut enclosure = rows(&[1.0; 3], &["a", "b", "c"], &[]);
    let corner = |k: usize| DVec3::new(k as f64, (k * k) as f64, 0.0);
    let outline = |corners: usize| (0..corners).map(corner).collect();
    enclosure.rows.cells = CellMesh::new([3, 4, 5].map(outline));
    let file = bytes(&enclosure, FactorFormat::Vtu, &FileOptions::default());
    assert_eq!(vtu_array(&file, "types").2, [5, 9, 7]);
    assert_eq!(longs(&file, "offsets"), [3, 7, 12]);
}

#[test]
fn vtu_refuses_what_it_cannot_show() {
    let options = FileOptions::default();
    let found = refusal(&plates(), FactorFormat::Vtu, &options);
    assert!(found.contains("no polygons"), "{found}");
    let options = FileOptions {
        shown_rows: vec!["x9".into()],
        ..FileOptions::default()
    };
    let found = refusal(&cube(), FactorFormat::Vtu, &options);
    assert!(
        found.contains("no row \"x9\", expected one of x0/0, x1/0,"),
        "{found}"
    );
    let options = FileOptions {
        arrays: vec![("T".into(), vec![1.0])],
        ..FileOptions::default()
    };
    let found = refusal(&cube(), FactorFormat::Vtu, &options);
    assert_eq!(
        found,
        "array T: found 1 values, expected 6, one for each row"
    );
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
            ..experiment()
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
