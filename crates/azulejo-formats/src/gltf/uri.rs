//! URIs: embedded data and file names.

use crate::reading::base64;
use std::borrow::Cow;

/// The target of a URI.
#[derive(Debug, PartialEq)]
pub(super) enum Uri<'a> {
    /// Bytes embedded in the URI itself.
    Data(Vec<u8>),
    /// The name of a file, relative to the model's.
    File(Cow<'a, str>),
}

/// Parses a URI.
///
/// # Errors
/// The reason, for a URI that is neither data nor a file name.
pub(super) fn read(uri: &str) -> Result<Uri<'_>, String> {
    if let Some(rest) = uri.strip_prefix("data:") {
        return data(rest).map(Uri::Data);
    }
    if uri.contains("://") {
        return Err("a URI outside the model's folder".to_owned());
    }
    let plain = percent_decoded(uri);
    Ok(Uri::File(match plain {
        Cow::Borrowed(_) => uri.into(),
        Cow::Owned(bytes) => String::from_utf8_lossy(&bytes).into_owned().into(),
    }))
}

/// The bytes after `data:`, RFC 2397.
fn data(rest: &str) -> Result<Vec<u8>, String> {
    let (kind, content) = rest.split_once(',').ok_or("a data URI without a comma")?;
    if kind.ends_with(";base64") {
        base64::decode(content.as_bytes()).ok_or_else(|| "a data URI that is not base64".to_owned())
    } else {
        Ok(percent_decoded(content).into_owned())
    }
}

/// `%41` becomes `A`; a `%` without two hexadecimal digits is kept.
fn percent_decoded(text: &str) -> Cow<'_, [u8]> {
    let bytes = text.as_bytes();
    if !bytes.contains(&b'%') {
        return bytes.into();
    }
    let digit = |at: usize| char::from(*bytes.get(at)?).to_digit(16);
    let mut plain = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while let Some(&b) = bytes.get(at) {
        let escaped = (b == b'%').then(|| Some(16 * digit(at + 1)? + digit(at + 2)?));
        match escaped.flatten() {
            Some(value) => {
                plain.push(value as u8);
                at += 3;
            }
            None => {
                plain.push(b);
                at += 1;
            }
        }
    }
    plain.into()
}

/// A file name as a URI: reserved characters are escaped.
pub(super) fn escaped(name: &str) -> String {
    let mut uri = String::with_capacity(name.len());
    for b in name.replace('\\', "/").bytes() {
        match b {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                uri.push(b.into());
            }
            _ => uri += &format!("%{b:02X}"),
        }
    }
    uri
}

/// Bytes as a URI that contains them, RFC 2397.
pub(super) fn data_uri(media_type: &str, bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut uri = format!("data:{media_type};base64,");
    uri.reserve(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let sextet = bits >> (18 - 6 * k) & 63;
            let is_there = k <= three.len();
            uri.push(if is_there {
                ALPHABET[sextet as usize].into()
            } else {
                '='
            });
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(uri: &str, expected: Result<Uri, &str>) {
        match (read(uri), expected) {
            (Err(e), Err(part)) => assert!(e.contains(part), "{e}"),
            (parsed, expected) => assert_eq!(parsed.ok(), expected.ok(), "{uri}"),
        }
    }

    #[test]
    fn data_and_names() {
        let data = |bytes: &[u8]| Ok(Uri::Data(bytes.to_vec()));
        check("data:;base64,", data(b""));
        check("data:a/b;base64,Zg==", data(b"f"));
        check("data:;base64,Zm8", data(b"fo"));
        check("data:;base64,Zm9v", data(b"foo"));
        check("data:;base64,+/-_", data(&[0xfb, 0xff, 0xbf]));
        check("data:,a%20b%2", data(b"a b%2"));
        check("data:;base64,Zm9v!", Err("not base64"));
        check("data:;base64,Z", data(b""));
        check("data:", Err("without a comma"));
        check("http://a/b.bin", Err("outside"));
        check("a%20b%C3%A1.bin", Ok(Uri::File("a bá.bin".into())));
        check("c/d.bin", Ok(Uri::File("c/d.bin".into())));
    }

    #[test]
    fn bytes_come_back() {
        for length in 0..7u8 {
            let bytes: Vec<u8> = (0..length).map(|i| i.wrapping_mul(97)).collect();
            let uri = data_uri("a/b", &bytes);
            assert_eq!(uri.len() % 4, "data:a/b;base64,".len() % 4);
            assert_eq!(read(&uri), Ok(Uri::Data(bytes)));
        }
    }

    #[test]
    fn names_come_back() {
        for name in ["a b.png", "50%.png", "azulejo/á#?.png"] {
            assert_eq!(read(&escaped(name)), Ok(Uri::File(name.into())));
        }
        assert_eq!(escaped("maps\\a b.png"), "maps/a%20b.png");
    }
}
