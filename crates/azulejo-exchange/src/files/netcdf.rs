//! netCDF's classic format, for one array of two dimensions.
//!
//! Its header is a hundred bytes, and the array follows; the crates that write the format keep
//! arrays in memory first.

use std::io::{self, Write};

/// Tags of lists in the header.
const DIMENSIONS: u32 = 10;
const VARIABLES: u32 = 11;
/// The type of 32-bit floating-point numbers.
const FLOAT: u32 = 5;

/// Writes a square array of this many rows, which `write` adds through the function that it is given.
pub(super) fn write_square(
    name: &str,
    rows: usize,
    out: &mut dyn Write,
    write: impl FnOnce(&mut dyn FnMut(f32) -> io::Result<()>) -> io::Result<()>,
) -> io::Result<()> {
    out.write_all(&header(name, rows as u32))?;
    write(&mut |x| out.write_all(&x.to_be_bytes()))
}

/// The header, in the variant with 64-bit offsets.
fn header(name: &str, rows: u32) -> Vec<u8> {
    let mut header = b"CDF\x02".to_vec();
    // No record, dimensions, no attribute.
    words(&[0, DIMENSIONS, 2], &mut header);
    for dimension in ["rows", "columns"] {
        text(dimension, &mut header);
        words(&[rows], &mut header);
    }
    words(&[0, 0, VARIABLES, 1], &mut header);
    text(name, &mut header);
    // Both dimensions, and again no attribute.
    words(&[2, 0, 1, 0, 0, FLOAT], &mut header);
    // Of an array that is too large for the field, readers compute the size.
    let bytes = 4 * u64::from(rows) * u64::from(rows);
    words(&[u32::try_from(bytes).unwrap_or(u32::MAX)], &mut header);
    let start = header.len() as u64 + 8;
    header.extend(start.to_be_bytes());
    header
}

fn words(numbers: &[u32], header: &mut Vec<u8>) {
    header.extend(numbers.iter().flat_map(|n| n.to_be_bytes()));
}

/// A text with its length before it, filled up to four bytes.
fn text(text: &str, header: &mut Vec<u8>) {
    words(&[text.len() as u32], header);
    header.extend(text.bytes());
    header.resize(header.len().next_multiple_of(4), 0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_byte_by_byte() {
        let expected = b"CDF\x02\0\0\0\0\
            \0\0\0\x0a\0\0\0\x02\0\0\0\x04rows\0\0\0\x03\0\0\0\x07columns\0\0\0\0\x03\
            \0\0\0\0\0\0\0\0\
            \0\0\0\x0b\0\0\0\x01\0\0\0\x0bview factor\0\0\0\0\x02\0\0\0\0\0\0\0\x01\
            \0\0\0\0\0\0\0\0\0\0\0\x05\0\0\0\x24\0\0\0\0\0\0\0\x70";
        let bytes = header("view factor", 3);
        assert_eq!(bytes, expected);
        assert_eq!(bytes.len(), 0x70);
    }

    #[test]
    fn large_arrays_have_no_size() {
        let bytes = header("a", 40_000);
        let end = bytes.len() - 8;
        assert_eq!(bytes[end - 4..end], [255; 4]);
    }
}
