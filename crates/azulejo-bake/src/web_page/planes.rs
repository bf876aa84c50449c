//! Lists of numbers in a form that DEFLATE compresses well: differences, their bytes apart.

use flate2::Compression;
use flate2::write::DeflateEncoder;
use std::io::{self, Write};

/// Adds the differences of successive `words` to `bytes`, little-endian bytes apart: first the
/// lowest of all of them, and so on.
pub(super) fn push_differences(words: impl Iterator<Item = u32> + Clone, bytes: &mut Vec<u8>) {
    for shift in [0, 8, 16, 24] {
        let mut last = 0u32;
        bytes.extend(words.clone().map(|word| {
            let difference = zigzag(word.wrapping_sub(last));
            last = word;
            (difference >> shift) as u8
        }));
    }
}

/// Small numbers of either sign, in two's complement, as small numbers: 0, −1, 1, −2, … become 0,
/// 1, 2, 3, …
fn zigzag(x: u32) -> u32 {
    x << 1 ^ 0u32.wrapping_sub(x >> 31)
}

/// The same for 16 bits.
pub(super) fn zigzag16(x: u16) -> u16 {
    x << 1 ^ 0u16.wrapping_sub(x >> 15)
}

/// Raw DEFLATE (RFC 1951) of `bytes`.
pub(super) fn deflate(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    encoder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_differences_are_small_numbers() {
        assert_eq!([0, u32::MAX, 1, 1 << 31].map(zigzag), [0, 1, 2, u32::MAX]);
        assert_eq!([0, u16::MAX, 1, 1 << 15].map(zigzag16), [0, 1, 2, u16::MAX]);
        let mut bytes = Vec::new();
        push_differences([5, 4, 0x104].into_iter(), &mut bytes);
        assert_eq!(bytes, [10, 1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0]);
    }
}
