//! Decoding of the bytes of text files.

use std::borrow::Cow;

/// The bytes of a text file as all readers expect them: UTF-8 without a byte-order mark, or else
/// Latin-1.
///
/// UTF-16 is converted to UTF-8 if the text starts with a byte-order mark or with plain letters; an
/// unpaired surrogate becomes U+FFFD. All other bytes are returned as they are, without copying.
pub(crate) fn decoded(bytes: &[u8]) -> Cow<'_, [u8]> {
    let decode = |text: &[u8], unit: fn([u8; 2]) -> u16| {
        let (pairs, _) = text.as_chunks::<2>();
        let units = pairs.iter().map(|&pair| unit(pair));
        let decoded = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        decoded.collect::<String>().into_bytes().into()
    };
    match bytes {
        [0xef, 0xbb, 0xbf, text @ ..] => text.into(),
        [0xfe, 0xff, text @ ..] => decode(text, u16::from_be_bytes),
        [0xff, 0xfe, text @ ..] => decode(text, u16::from_le_bytes),
        [0, a, 0, b, 0, c, ..] if are_letters([*a, *b, *c]) => decode(bytes, u16::from_be_bytes),
        [a, 0, b, 0, c, 0, ..] if are_letters([*a, *b, *c]) => decode(bytes, u16::from_le_bytes),
        _ => bytes.into(),
    }
}

/// Whether these bytes may begin a text.
fn are_letters(start: [u8; 3]) -> bool {
    start
        .iter()
        .all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace())
}

/// Bytes as text: UTF-8 or, failing that, Latin-1.
pub(crate) fn text(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(s) => s.into(),
        Err(_) => bytes.iter().map(|&b| b as char).collect(),
    }
}

/// [`decoded`] for owned bytes.
pub(crate) fn into_decoded(bytes: Vec<u8>) -> Vec<u8> {
    let changed = match decoded(&bytes) {
        Cow::Borrowed(same) if same.len() == bytes.len() => None,
        other => Some(other.into_owned()),
    };
    changed.unwrap_or(bytes)
}

/// [`decoded`] bytes as text.
pub(crate) fn decoded_text(bytes: &[u8]) -> Cow<'_, str> {
    match decoded(bytes) {
        Cow::Borrowed(bytes) => text(bytes),
        Cow::Owned(bytes) => text(&bytes).into_owned().into(),
    }
}

/// A text in the encoding of the bytes from which [`decoded_text`] got another: with their byte-order
/// mark, in UTF-16 as they are, or in Latin-1. `None` if it has letters that Latin-1 lacks.
pub(crate) fn encoded_like(bytes: &[u8], text: &str) -> Option<Vec<u8>> {
    let wide = |mark: &[u8], unit: fn(u16) -> [u8; 2]| {
        let units = text.encode_utf16().flat_map(unit);
        Some(mark.iter().copied().chain(units).collect())
    };
    let narrow = |mark: &[u8], rest: &[u8]| {
        let mut out = mark.to_vec();
        if std::str::from_utf8(rest).is_ok() {
            out.extend(text.as_bytes());
            return Some(out);
        }
        for c in text.chars() {
            out.push(u8::try_from(u32::from(c)).ok()?);
        }
        Some(out)
    };
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => narrow(&bytes[..3], rest),
        [0xfe, 0xff, ..] => wide(&bytes[..2], u16::to_be_bytes),
        [0xff, 0xfe, ..] => wide(&bytes[..2], u16::to_le_bytes),
        [0, a, 0, b, 0, c, ..] if are_letters([*a, *b, *c]) => wide(&[], u16::to_be_bytes),
        [a, 0, b, 0, c, 0, ..] if are_letters([*a, *b, *c]) => wide(&[], u16::to_le_bytes),
        _ => narrow(&[], bytes),
    }
}

/// A word in quotes for a message, shortened.
pub(crate) fn quoted(word: &[u8]) -> String {
    format!("\"{}\"", shortened(&text(word)))
}

/// The first characters of a word for a message.
pub(crate) fn shortened(word: &str) -> String {
    const SHOWN: usize = 40;
    match word.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &word[..end]),
        None => word.to_owned(),
    }
}
