//! Base64, RFC 4648, as a whole or piece by piece.

use std::borrow::Cow;

/// Value of each base64 character; 64 for all others.
const SEXTETS: [u8; 256] = {
    let mut table = [64; 256];
    let alphabet = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut value = 0;
    while value < 64 {
        table[alphabet[value] as usize] = value as u8;
        value += 1;
    }
    // The URL-safe alphabet does not clash with the common one.
    table[b'-' as usize] = 62;
    table[b'_' as usize] = 63;
    table
};

/// Decodes base64, RFC 4648, with or without padding.
pub(crate) fn decode(text: &[u8]) -> Option<Vec<u8>> {
    let end = text.iter().rposition(|b| *b != b'=').map_or(0, |e| e + 1);
    let text = &text[..end];
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    let (fours, rest) = text.as_chunks::<4>();
    for four in fours {
        bytes.extend(group(*four)?);
    }
    if !rest.is_empty() {
        let mut four = [b'A'; 4];
        four[..rest.len()].copy_from_slice(rest);
        bytes.extend_from_slice(&group(four)?[..rest.len() - 1]);
    }
    Some(bytes)
}

/// Three bytes of four characters.
fn group(four: [u8; 4]) -> Option<[u8; 3]> {
    let [a, b, c, d] = four.map(|character| SEXTETS[usize::from(character)]);
    let known = (a | b | c | d) < 64;
    known.then_some([a << 2 | b >> 4, b << 4 | c >> 2, c << 6 | d])
}

/// A cursor over bytes, which may be base64 of one or several pieces, each padded on its own.
///
/// Blanks are passed. Every read either succeeds and advances, or returns `None`.
#[derive(Clone, Debug)]
pub(crate) enum ByteStream<'a> {
    /// The bytes that are left.
    Plain(&'a [u8]),
    /// The characters that are left, and bytes of the last four that were not yet requested.
    Base64(&'a [u8], Vec<u8>),
}

impl<'a> ByteStream<'a> {
    /// The bytes of a text in base64.
    pub fn base64(text: &'a [u8]) -> ByteStream<'a> {
        ByteStream::Base64(text, Vec::new())
    }

    /// The next `count` bytes; `None` if there are fewer or a character is none of base64.
    pub fn take(&mut self, count: usize) -> Option<Cow<'a, [u8]>> {
        match self {
            ByteStream::Plain(bytes) => {
                let (taken, rest) = bytes.split_at_checked(count)?;
                *bytes = rest;
                Some(taken.into())
            }
            ByteStream::Base64(text, pending) => {
                // A count that the text cannot hold must not reserve memory.
                if count > pending.len() + text.len() / 4 * 3 {
                    return None;
                }
                let mut bytes = std::mem::take(pending);
                bytes.reserve(count.saturating_sub(bytes.len()) + 3);
                while bytes.len() < count {
                    next_bytes(text, &mut bytes)?;
                }
                *pending = bytes.split_off(count);
                Some(bytes.into())
            }
        }
    }
}

/// Decodes the next four characters, of which the last two may be padding.
fn next_bytes(text: &mut &[u8], bytes: &mut Vec<u8>) -> Option<()> {
    let mut four = [0; 4];
    for character in &mut four {
        let at = text.iter().position(|b| !b.is_ascii_whitespace())?;
        *character = text[at];
        *text = &text[at + 1..];
    }
    let count = match four {
        [_, _, b'=', b'='] => 1,
        [_, _, _, b'='] => 2,
        _ => 3,
    };
    four[count + 1..].fill(b'A');
    bytes.extend_from_slice(&group(four)?[..count]);
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_padded_on_their_own() {
        let check = |text: &str, counts: &[usize], expected: &[Option<&[u8]>]| {
            let mut stream = ByteStream::base64(text.as_bytes());
            for (&count, &expected) in std::iter::zip(counts, expected) {
                assert_eq!(stream.take(count).as_deref(), expected, "{count} of {text}");
            }
        };
        let counts = [1, 3, 2, 1];
        check(
            "Zm9vYmFy",
            &counts,
            &[Some(b"f"), Some(b"oob"), Some(b"ar"), None],
        );
        check(
            " Zg==\nb29i Y\tXI=",
            &counts,
            &[Some(b"f"), Some(b"oob"), Some(b"ar"), None],
        );
        check("Zm9v!mFy", &[3, 1], &[Some(b"foo"), None]);
        check("Zm9vYm", &[3, 1], &[Some(b"foo"), None]);
        check(
            "Zm9v",
            &[0, usize::MAX, 3],
            &[Some(b""), None, Some(b"foo")],
        );
        let mut plain = ByteStream::Plain(b"foobar");
        assert_eq!(plain.take(4).as_deref(), Some(&b"foob"[..]));
        assert_eq!(
            (plain.take(3), plain.take(2).as_deref()),
            (None, Some(&b"ar"[..]))
        );
    }
}
