//! Bytes of text files as text.

use std::borrow::Cow;

/// UTF-16 with its mark at the start becomes UTF-8; anything else stays as it is.
pub(crate) fn without_utf16(bytes: &[u8]) -> Cow<'_, [u8]> {
    let decode = |unit: fn([u8; 2]) -> u16| {
        let (pairs, _) = bytes[2..].as_chunks::<2>();
        let units = pairs.iter().map(|&pair| unit(pair));
        let decoded = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        decoded.collect::<String>().into_bytes().into()
    };
    match bytes {
        [0xfe, 0xff, ..] => decode(u16::from_be_bytes),
        [0xff, 0xfe, ..] => decode(u16::from_le_bytes),
        _ => bytes.into(),
    }
}

/// Bytes as text: UTF-8 or, failing that, Latin-1.
pub(crate) fn text(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(s) => s.into(),
        Err(_) => bytes.iter().map(|&b| b as char).collect(),
    }
}

/// The first characters of a word for a message.
pub(crate) fn shortened(word: &str) -> String {
    const SHOWN: usize = 40;
    match word.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &word[..end]),
        None => word.to_owned(),
    }
}
