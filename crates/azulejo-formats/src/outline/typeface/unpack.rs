//! Web fonts, which are compressed: WOFF and WOFF2.

use crate::ReadError;
use flate2::{Decompress, FlushDecompress, Status};
use std::borrow::Cow;
use std::error::Error;

/// Largest size of an unpacked font; the same limit as that of WOFF2's decoder. The largest fonts of Chinese have
/// 30 MB.
const LARGEST: usize = 128 << 20;

/// Unpacks a web font; other files stay as they are.
pub(super) fn unpacked<'a>(bytes: &'a [u8], name: &str) -> Result<Cow<'a, [u8]>, ReadError> {
    let (format, unpacked) = match bytes.get(..4) {
        Some(b"wOFF") => ("WOFF", woff(bytes)),
        Some(b"wOF2") => ("WOFF2", wuff::decompress_woff2(bytes).ok()),
        _ => return Ok(Cow::Borrowed(bytes)),
    };
    unpacked.map(Cow::Owned).ok_or_else(|| {
        let found = format!("a {format} font that is damaged or unpacks to more than 128 MiB");
        ReadError::whole(name, found, "a whole file")
    })
}

/// Unpacks WOFF (W3C, *WOFF File Format 1.0*). Its tables may overlap in the file, so their sizes are added before
/// anything is unpacked.
fn woff(bytes: &[u8]) -> Option<Vec<u8>> {
    const HEADER: usize = 44;
    const ENTRY: usize = 20;
    let count = usize::from(u16::from_be_bytes(*bytes.get(12..)?.first_chunk()?));
    let (entries, _) = bytes.get(HEADER..)?.as_chunks::<ENTRY>();
    let entries = entries.get(..count)?;
    let size = |entry: &[u8; ENTRY]| {
        let word = |at: usize| u64::from(u32::from_be_bytes([0, 1, 2, 3].map(|k| entry[at + k])));
        word(8).max(word(12))
    };
    let total: u64 = entries.iter().map(size).sum();
    if total > LARGEST as u64 {
        return None;
    }
    wuff::decompress_woff1_with_custom_z(bytes, &mut inflate).ok()
}

/// Decompresses exactly `size` bytes.
fn inflate(packed: &[u8], size: usize) -> Result<Vec<u8>, Box<dyn Error>> {
    // No byte of DEFLATE stands for more than 1032.
    if size / 1032 > packed.len() {
        return Err("a size that the data do not justify".into());
    }
    let mut plain = Vec::with_capacity(size);
    let mut inflater = Decompress::new(true);
    match inflater.decompress_vec(packed, &mut plain, FlushDecompress::Finish)? {
        Status::StreamEnd => Ok(plain),
        Status::Ok | Status::BufError => Err("data of another size".into()),
    }
}
