//! uDALES.

use super::*;

pub(super) fn experiment() -> FileOptions {
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
    let (written, notes) = files(&enclosure, FactorFormat::Udales, &experiment());
    let text = |k: usize| String::from_utf8_lossy(&written[k].1).into_owned();
    let names: Vec<&str> = written.iter().map(|f| f.0.as_str()).collect();
    let expected = ["vfsparse", "vf.nc", "svf", "facetarea", "facets"];
    assert_eq!(names, expected.map(|n| format!("{n}.inp.042")));
    assert_eq!(text(0), "1 2 0.20000000\n2 1 0.10000000\n2 2 0.25000000\n");
    let matrix = &written[1].1;
    // F_11, F_21, F_12, F_22.
    let expected: Vec<u8> = [0.0f32, 0.1, 0.2, 0.25]
        .iter()
        .flat_map(|f| f.to_be_bytes())
        .collect();
    assert_eq!(matrix[matrix.len() - 16..], expected[..]);
    assert_eq!(text(2), "# sky view factors\n0.80000000\n0.65000000\n");
    assert_eq!(text(3), "# area of facets\n4\n8\n");
    assert_eq!(
        text(4),
        "# type, normal\n3 0.0000 0.0000 1.0000\n3 0.0000 0.0000 -1.0000\n"
    );
    assert_eq!(
        notes,
        [
            "1 of 2 rows lose light downwards, at most 65% (cold/0): uDALES takes it for sky, and expects the ground \
             among the facets",
            "for &ENERGYBALANCE: lvfsparse=.true., nnz=3, and for &WALLS: nfcts=2"
        ]
    );
}

#[test]
fn udales_refuses_rows_that_are_no_facets() {
    let mut enclosure = plates();
    enclosure.factors.is_back[1] = true;
    let message = refusal(&enclosure, FactorFormat::Udales, &experiment());
    assert!(message.contains("found back sides"), "{message}");
    let mut enclosure = plates();
    enclosure.factors.faces[1] = enclosure.factors.faces[0];
    let message = refusal(&enclosure, FactorFormat::Udales, &experiment());
    assert!(
        message.contains("found 2 rows, several of a face"),
        "{message}"
    );
    let mut enclosure = plates();
    enclosure.factors.faces[1].face = 1;
    let message = refusal(&enclosure, FactorFormat::Udales, &experiment());
    assert!(
        message.contains("face 0 of \"cold\" has no row"),
        "{message}"
    );
    let message = refusal(&plates(), FactorFormat::Udales, &FileOptions::default());
    assert!(message.contains("vfsparse.inp.NNN"), "{message}");
    let message = refusal(&plates(), FactorFormat::Udales, &experiment());
    assert!(message.contains("need a folder"), "{message}");
}
