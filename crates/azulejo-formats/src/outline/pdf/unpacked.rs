//! How much the streams of a file unpack to, before hayro unpacks them without a limit.

use crate::{ReadError, ReadOptions};
use flate2::bufread::{DeflateDecoder, ZlibDecoder};
use std::io::{BufRead, BufReader, Read};

/// Most layers of compression that are looked into: hayro unpacks any number.
const DEEPEST: usize = 6;

/// How often the bytes of a file may be unpacked: once, but what looks like the beginning of a stream may lie within another.
const MOST_TIMES: u64 = 8;

/// Checks that no stream unpacks to more than the options allow, whatever the tables of the file say about it.
///
/// Only DEFLATE is checked, which expands a thousandfold, also several times over. It cannot be seen through encryption.
///
/// # Errors
/// [`too_much`], and a file whose streams lie within each other.
pub(super) fn check(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<(), ReadError> {
    const STREAM: &[u8] = b"stream";
    let mut work = MOST_TIMES * bytes.len() as u64;
    let mut at = 0;
    while let Some(found) = position(&bytes[at..], STREAM) {
        at += found + STREAM.len();
        let data = match &bytes[at..] {
            [b'\r', b'\n', data @ ..] | [b'\n' | b'\r', data @ ..] => data,
            _ => continue,
        };
        for depth in 1..=DEEPEST {
            let (read, size, is_packed_again) = unpack(data, depth, options.most_unpacked);
            if size > options.most_unpacked {
                return Err(too_much(name, options));
            }
            let Some(left) = work.checked_sub(read) else {
                let found = "streams that lie within each other";
                return Err(ReadError::at_byte(name, at as u64, found, super::EXPECTED));
            };
            work = left;
            if !is_packed_again {
                break;
            }
        }
    }
    Ok(())
}

/// What is said of a file that unpacks to more than the options allow.
pub(super) fn too_much(name: &str, options: &ReadOptions) -> ReadError {
    let found = format!(
        "a stream that unpacks to more than {} bytes",
        options.most_unpacked
    );
    let expected = "less, or a higher limit (ReadOptions::most_unpacked)";
    ReadError::whole(name, found, expected)
}

/// Where a word begins.
fn position(bytes: &[u8], word: &[u8]) -> Option<usize> {
    bytes.windows(word.len()).position(|window| window == word)
}

/// Unpacks data several times over; returns how many bytes of them were read, how many there are in the end, up to one
/// more than `most`, and whether they look packed themselves.
fn unpack(data: &[u8], depth: usize, most: u64) -> (u64, u64, bool) {
    let mut left = data;
    let (size, is_packed) = unpacked_size(&mut left, depth, most);
    ((data.len() - left.len()) as u64, size, is_packed)
}

fn unpacked_size(data: &mut &[u8], depth: usize, most: u64) -> (u64, bool) {
    let mut reader: Box<dyn BufRead + '_> = Box::new(data);
    for _ in 0..depth {
        let start = reader.fill_buf().unwrap_or_default();
        reader = if is_zlib(start) {
            Box::new(BufReader::new(ZlibDecoder::new(reader)))
        } else {
            Box::new(BufReader::new(DeflateDecoder::new(reader)))
        };
    }
    let is_packed = is_zlib(reader.fill_buf().unwrap_or_default());
    // hayro keeps what comes before damage, and so does this count.
    let (mut size, mut buffer) = (0, [0; 1 << 14]);
    while let Ok(count @ 1..) = reader.read(&mut buffer) {
        size += count as u64;
        if size > most {
            break;
        }
    }
    (size, is_packed)
}

/// Whether data begin as zlib's do: RFC 1950, 2.2.
fn is_zlib(data: &[u8]) -> bool {
    match data {
        [method, flags, ..] => {
            let check = u16::from_be_bytes([*method, *flags]);
            method & 0xf == 8 && check.is_multiple_of(31)
        }
        _ => false,
    }
}
