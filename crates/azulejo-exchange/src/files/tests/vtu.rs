//! VTK.

use super::*;
use azulejo_scene::Rgb;

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
    let message = refusal(&plates(), FactorFormat::Vtu, &options);
    assert!(message.contains("no polygons"), "{message}");
    let options = FileOptions {
        shown_rows: vec!["x9".into()],
        ..FileOptions::default()
    };
    let message = refusal(&cube(), FactorFormat::Vtu, &options);
    assert!(
        message.contains("no row \"x9\", expected one of x0/0, x1/0,"),
        "{message}"
    );
    let options = FileOptions {
        arrays: vec![("T".into(), vec![1.0])],
        ..FileOptions::default()
    };
    let message = refusal(&cube(), FactorFormat::Vtu, &options);
    assert_eq!(
        message,
        "array T: found 1 values, expected 6, one for each row"
    );
}
