//! Base64 (RFC 4648, section 4), the densest common code that HTML holds unchanged in any encoding.

use std::io::{self, Write};

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Bytes per piece that is handed on, a multiple of 3.
const PIECE: usize = 3 << 14;

/// Writes `bytes` in base64, padded, without line breaks.
pub(super) fn write(bytes: &[u8], out: &mut dyn Write) -> io::Result<()> {
    let mut text = Vec::with_capacity(PIECE / 3 * 4);
    for piece in bytes.chunks(PIECE) {
        text.clear();
        piece.chunks(3).for_each(|three| push(three, &mut text));
        out.write_all(&text)?;
    }
    Ok(())
}

/// Adds four letters for one to three bytes.
fn push(three: &[u8], text: &mut Vec<u8>) {
    let byte = |k: usize| u32::from(three.get(k).copied().unwrap_or(0));
    let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
    for k in 0..4 {
        let letter = ALPHABET[(bits >> (18 - 6 * k) & 63) as usize];
        text.push(if k <= three.len() { letter } else { b'=' });
    }
}

#[cfg(test)]
mod tests {
    /// The vectors of RFC 4648, section 10.
    #[test]
    fn vectors_of_the_standard() {
        for (plain, expected) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            let mut text = Vec::new();
            super::write(plain.as_bytes(), &mut text).unwrap();
            assert_eq!(String::from_utf8(text).unwrap(), expected);
        }
    }
}
