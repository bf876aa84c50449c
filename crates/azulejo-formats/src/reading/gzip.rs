//! Decompression of files compressed with gzip.

use crate::{ReadError, ReadOptions};
use flate2::read::MultiGzDecoder;
use std::borrow::Cow;
use std::io::Read;

/// Whether bytes begin with the magic number of gzip.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x1f\x8b")
}

/// The bytes, decompressed if they are compressed.
///
/// # Errors
/// Damaged data, and more bytes than `options` allow.
pub(crate) fn unpacked<'a>(
    bytes: &'a [u8],
    file: &str,
    options: &ReadOptions,
) -> Result<Cow<'a, [u8]>, ReadError> {
    if !is_gzip(bytes) {
        return Ok(Cow::Borrowed(bytes));
    }
    let mut content = Vec::new();
    MultiGzDecoder::new(bytes)
        .take(options.most_unpacked.saturating_add(1))
        .read_to_end(&mut content)
        .map_err(|e| ReadError::whole(file, format!("damaged gzip ({e})"), "a complete file"))?;
    if content.len() as u64 > options.most_unpacked {
        let most = options.most_unpacked;
        return Err(ReadError::whole(
            file,
            format!("gzip data that decompresses to more than {most} bytes"),
            "a smaller file, or a higher limit (ReadOptions::most_unpacked)",
        ));
    }
    Ok(Cow::Owned(content))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;

    #[test]
    fn packed_or_not() {
        let mut packer = GzEncoder::new(Vec::new(), Compression::best());
        packer.write_all(&[b'v'; 1000]).unwrap();
        let packed = packer.finish().unwrap();
        let options = ReadOptions::default();
        assert_eq!(unpacked(&packed, "a", &options).unwrap().len(), 1000);
        assert_eq!(
            unpacked(b"v 1 2 3", "a", &options).unwrap(),
            &b"v 1 2 3"[..]
        );
        let tight = ReadOptions {
            most_unpacked: 999,
            ..options
        };
        let message = unpacked(&packed, "a", &tight).unwrap_err().to_string();
        assert!(message.contains("more than 999 bytes"), "{message}");
        let cut = &packed[..packed.len() - 9];
        assert!(
            unpacked(cut, "a", &options)
                .unwrap_err()
                .to_string()
                .contains("damaged")
        );
    }
}
