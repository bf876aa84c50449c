//! View factor matrices in the formats of View3D 4.0.0.

use super::document::MatrixLayout;
use std::io::{self, Write};

/// The header of a matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FactorHeader {
    /// Text or binary.
    pub layout: MatrixLayout,
    /// Whether rows were normalized to sum to 1.
    pub encl: bool,
    /// Whether it holds grey interchange factors.
    pub emit: bool,
}

impl FactorHeader {
    /// 30 characters: six words, padded with blanks.
    fn words(self, rows: usize) -> String {
        let out = u8::from(self.layout == MatrixLayout::Binary);
        let [encl, emit] = [self.encl, self.emit].map(u8::from);
        format!("{:30}", format!("View3D 4.0.0 {out} {encl} {emit} {rows}"))
    }
}

/// Writes a matrix: its header, areas, rows in order, and emissivities.
///
/// Text has six digits for areas, six decimals for factors and three for emissivities; binary is
/// little-endian `f32`, as on the machines on which View3D runs.
///
/// # Errors
/// Those of `out` and of the rows, and rows whose length differs from that of `areas`.
pub fn write_factors(
    header: FactorHeader,
    areas: &[f64],
    rows: impl Iterator<Item = io::Result<Vec<f64>>>,
    emissivities: &[f64],
    out: &mut dyn Write,
) -> io::Result<()> {
    let n = areas.len();
    let mut out = io::BufWriter::new(out);
    out.write_all(header.words(n).as_bytes())?;
    let mut list: fn(&[f64], &mut dyn Write) -> io::Result<()> = binary;
    match header.layout {
        MatrixLayout::Text => {
            writeln!(out)?;
            text(areas, general, &mut out)?;
            list = |row, out| text(row, |f| decimal(f, 6), out);
        }
        MatrixLayout::Binary => {
            out.write_all(b"\r\n")?;
            binary(areas, &mut out)?;
        }
    }
    let mut count = 0;
    for row in rows {
        let row = row?;
        check(row.len(), n)?;
        list(&row, &mut out)?;
        count += 1;
    }
    check(count, n)?;
    match header.layout {
        MatrixLayout::Text => text(emissivities, |e| decimal(e, 3), &mut out)?,
        MatrixLayout::Binary => binary(emissivities, &mut out)?,
    }
    out.flush()
}

fn check(found: usize, expected: usize) -> io::Result<()> {
    if found == expected {
        Ok(())
    } else {
        let message = format!("{found} rows or columns instead of {expected}");
        Err(io::Error::new(io::ErrorKind::InvalidInput, message))
    }
}

fn binary(numbers: &[f64], out: &mut dyn Write) -> io::Result<()> {
    let bytes: Vec<u8> = numbers
        .iter()
        .flat_map(|&x| (x as f32).to_le_bytes())
        .collect();
    out.write_all(&bytes)
}

fn text(numbers: &[f64], word: impl Fn(f64) -> String, out: &mut dyn Write) -> io::Result<()> {
    let words: Vec<String> = numbers.iter().map(|&x| word(x)).collect();
    writeln!(out, "{}", words.join(" "))
}

/// C's `%.Nf`, but without a minus before zero.
fn decimal(x: f64, places: usize) -> String {
    let text = format!("{x:.places$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.bytes().all(|b| matches!(b, b'0' | b'.')) => zero.to_owned(),
        _ => text,
    }
}

/// C's `%g`: six digits, the shorter of the two notations, no trailing zeros.
fn general(x: f64) -> String {
    const DIGITS: i32 = 6;
    if x == 0.0 || !x.is_finite() {
        return decimal(x, 0);
    }
    let scientific = format!("{x:.5e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..DIGITS).contains(&exponent) {
        return bare(&format!("{x:.*}", (DIGITS - 1 - exponent) as usize)).to_owned();
    }
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{}e{sign}{:02}", bare(mantissa), exponent.abs())
}

/// A decimal number without trailing zeros.
fn bare(number: &str) -> &str {
    if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.')
    } else {
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_c_prints_them() {
        for (x, expected) in [
            (1.0, "1"),
            (0.75, "0.75"),
            (1234567.0, "1.23457e+06"),
            (123456.4, "123456"),
            (999999.5, "1e+06"),
            (0.0001, "0.0001"),
            (0.00001234, "1.234e-05"),
            (100.0, "100"),
            (2.5e-120, "2.5e-120"),
            (0.0, "0"),
        ] {
            assert_eq!(general(x), expected);
        }
        assert_eq!(decimal(-1e-9, 6), "0.000000");
        assert_eq!(decimal(-0.25, 2), "-0.25");
    }

    fn two_squares(layout: MatrixLayout) -> Vec<u8> {
        let header = FactorHeader {
            layout,
            ..FactorHeader::default()
        };
        // A value computed by View3D in single precision.
        let f = f64::from(f32::from_bits(0x3e4c_9eea));
        let rows = [Ok(vec![0.0, f]), Ok(vec![f, 0.0])];
        let mut out = Vec::new();
        write_factors(header, &[1.0, 1.0], rows.into_iter(), &[0.5, 0.8], &mut out).unwrap();
        out
    }

    #[test]
    fn text_is_laid_out_as_view3d_does() {
        let expected = "View3D 4.0.0 0 0 0 2          \n1 1\n0.000000 0.199825\n\
                        0.199825 0.000000\n0.500 0.800\n";
        assert_eq!(
            String::from_utf8(two_squares(MatrixLayout::Text)).unwrap(),
            expected
        );
    }

    #[test]
    fn binary_is_laid_out_as_view3d_does() {
        let bytes = two_squares(MatrixLayout::Binary);
        assert_eq!(bytes.len(), 32 + 4 * (4 + 4));
        assert_eq!(&bytes[..32], b"View3D 4.0.0 1 0 0 2          \r\n");
        assert_eq!(bytes[32..40], [0, 0, 0x80, 0x3f, 0, 0, 0x80, 0x3f]);
        assert_eq!(bytes[44..48], [0xea, 0x9e, 0x4c, 0x3e]);
        assert_eq!(bytes[56..60], 0.5f32.to_le_bytes());
    }

    #[test]
    fn rows_of_another_length_are_refused() {
        let rows = [Ok(vec![0.0; 3]), Ok(vec![0.0; 2])];
        let header = FactorHeader::default();
        let written = write_factors(
            header,
            &[1.0; 2],
            rows.into_iter(),
            &[0.5; 2],
            &mut io::sink(),
        );
        assert!(written.is_err());
    }
}
