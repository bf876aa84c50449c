//! CalculiX.

use super::*;

#[test]
fn calculix_byte_by_byte() {
    let options = FileOptions::default();
    let content = bytes(&plates(), FactorFormat::CalculiX, &options);
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
    assert_eq!(content, expected);
    let newer = FileOptions {
        calculix: Some("2.22".into()),
        ..options
    };
    let content = bytes(&plates(), FactorFormat::CalculiX, &newer);
    assert_eq!(&content[4..17], b"Version 2.22 ");
}

#[test]
fn calculix_writes_the_lower_triangle_by_columns() {
    let enclosure = rows(
        &[1.0, 2.0, 4.0],
        &["a", "b", "c"],
        &[(0, 1, 0.25), (0, 2, 0.5), (1, 2, 1.0)],
    );
    let content = bytes(&enclosure, FactorFormat::CalculiX, &FileOptions::default());
    let start = 4 + 80 + 4 + 4 + 24 + 4 + 4;
    let numbers: Vec<f64> = content[start..start + 48]
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
        .collect();
    assert_eq!(numbers, [0.125, 0.125, 0.25, 0.25, 0.5, 0.5]);
}

#[test]
fn records_longer_than_a_part_are_divided() {
    let enclosure = plates();
    let factors = direct::DirectFactors::new(&enclosure, "").unwrap();
    let mut lines = Vec::new();
    crate::files::calculix::write(&factors, "T", 6, &mut lines).unwrap();
    // The second record, after 80 characters in 14 parts: 16 bytes in parts of 6, 6 and 4.
    let second = &lines[80 + 14 * 8..];
    let mark = |at: usize| i32::from_le_bytes(second[at..at + 4].try_into().unwrap());
    let marks = [mark(0), mark(10), mark(14), mark(24), mark(28), mark(36)];
    assert_eq!(marks, [-6, 6, -6, -6, 4, -4]);
}

#[test]
fn an_empty_matrix_has_empty_records() {
    let content = bytes(
        &rows(&[], &[], &[]),
        FactorFormat::CalculiX,
        &FileOptions::default(),
    );
    assert_eq!(&content[88..], [0; 24]);
}
