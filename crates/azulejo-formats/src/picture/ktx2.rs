//! KTX2: Khronos' textures; the first picture at its full size.
//!
//! Khronos, *KTX File Format Specification*, version 2.0.

use super::blocks::{TexelStorage, word};
use super::error::{PictureError, check_size, malformed};
use super::samples::little;
use azulejo_scene::Image;
use flate2::read::ZlibDecoder;
use ruzstd::decoding::StreamingDecoder;
use std::io::Read;

pub use super::ktx2_writer::{Ktx2Texels, write, write_volume};

/// The 12 bytes of all files.
pub(super) const START: &[u8; 12] = b"\xabKTX 20\xbb\r\n\x1a\n";

/// Most bytes that one byte of a compressed file justifies, as for PNG.
const MOST_BYTES_PER_BYTE: usize = 4 * 1032;

/// What the header says.
struct Ktx2Header {
    size: [usize; 2],
    storage: TexelStorage,
    srgb: bool,
    /// Number of the compression around the pixels.
    packing: u32,
    /// Offset and bytes of the largest level.
    level: (u64, u64),
}

/// Reads a KTX2 as linear light: uncompressed pixels, also with a shared exponent, and BC1 to BC7, plain or compressed by Zstandard or
/// DEFLATE. Values are sRGB or linear, as the format says. Of cubes, arrays and volumes, the first
/// picture. Basis Universal (UASTC, ETC1S) and the compressions of phones (ETC2, ASTC) are refused.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, of another format, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let header = header(bytes)?;
    let [width, height] = header.size;
    check_size(width as u64, height as u64, bytes.len())?;
    let ended = || malformed("the KTX2 ends before its last pixel");
    let (start, length) = header.level;
    let end = start.checked_add(length).ok_or_else(ended)?;
    let stored = usize::try_from(start).ok().zip(usize::try_from(end).ok());
    let stored = stored.and_then(|(start, end)| bytes.get(start..end));
    let stored = stored.ok_or_else(ended)?;
    let needed = header.storage.bytes(header.size).ok_or_else(ended)?;
    if header.packing != 0 && needed > stored.len().saturating_mul(MOST_BYTES_PER_BYTE) {
        return Err(PictureError::TooLarge {
            width: width as u64,
            height: height as u64,
        });
    }
    let mut data = Vec::new();
    let limit = needed as u64;
    match header.packing {
        0 => return header.storage.decode(header.size, header.srgb, stored),
        2 => {
            let decoder = StreamingDecoder::new(stored).map_err(malformed)?;
            decoder
                .take(limit)
                .read_to_end(&mut data)
                .map_err(malformed)?;
        }
        3 => {
            let decoder = ZlibDecoder::new(stored);
            decoder
                .take(limit)
                .read_to_end(&mut data)
                .map_err(malformed)?;
        }
        other => return Err(malformed(format!("a KTX2 of compression {other}"))),
    }
    header.storage.decode(header.size, header.srgb, &data)
}

/// Columns and rows, from the header alone.
pub(super) fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    Ok(header(bytes)?.size.map(|n| n as u64))
}

fn header(bytes: &[u8]) -> Result<Ktx2Header, PictureError> {
    let ended = || malformed("a KTX2 whose header ends early");
    let field = |at| word(bytes, at).ok_or_else(ended);
    let long = |at| little::<8>(bytes, at).ok_or_else(ended);
    let (format, packing) = (field(12)?, field(44)?);
    if packing == 1 {
        return Err(malformed(
            "Basis Universal (ETC1S), which is not read; written anew with Zstandard it is",
        ));
    }
    if format == 0 {
        return Err(malformed(
            "Basis Universal (UASTC), which is not read; written anew as RGBA or BC7 it is",
        ));
    }
    let other = || {
        malformed(format!(
            "a KTX2 of Vulkan's format {format}, which is not read"
        ))
    };
    let (storage, srgb) = vulkan(format).ok_or_else(other)?;
    Ok(Ktx2Header {
        // One-dimensional textures have a height of 0.
        size: [field(20)? as usize, field(24)?.max(1) as usize],
        storage,
        srgb,
        packing,
        level: (long(80)?, long(88)?),
    })
}

/// Formats by their number in `VkFormat`, and whether they are sRGB.
fn vulkan(format: u32) -> Option<(TexelStorage, bool)> {
    let storage = match format {
        9 | 15 => TexelStorage::Bytes(1),
        16 | 22 => TexelStorage::Bytes(2),
        23 | 29 => TexelStorage::Bytes(3),
        30 | 36 => TexelStorage::Bgr(3, false),
        37 | 43 => TexelStorage::Bytes(4),
        44 | 50 => TexelStorage::Bgr(4, true),
        70 => TexelStorage::Words(1),
        84 => TexelStorage::Words(3),
        91 => TexelStorage::Words(4),
        76 => TexelStorage::Halves(1),
        90 => TexelStorage::Halves(3),
        97 => TexelStorage::Halves(4),
        100 => TexelStorage::Floats(1),
        106 => TexelStorage::Floats(3),
        109 => TexelStorage::Floats(4),
        123 => TexelStorage::SharedExponent,
        131..=134 => TexelStorage::Bc1,
        135 | 136 => TexelStorage::Bc2,
        137 | 138 => TexelStorage::Bc3,
        139 => TexelStorage::Bc4(false),
        140 => TexelStorage::Bc4(true),
        141 => TexelStorage::Bc5(false),
        142 => TexelStorage::Bc5(true),
        143 => TexelStorage::Bc6(false),
        144 => TexelStorage::Bc6(true),
        145 | 146 => TexelStorage::Bc7,
        _ => return None,
    };
    let srgb = [15, 22, 29, 36, 43, 50, 132, 134, 136, 138, 146].contains(&format);
    Some((storage, srgb))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::picture::error::tests::damage;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};
    use std::io::Write;

    /// A file of 2 × 1 pixels.
    pub(crate) fn file(format: u32, packing: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = START.to_vec();
        for n in [format, 1, 2, 1, 0, 0, 1, 1, packing, 0, 0, 0, 0, 0, 0, 0, 0] {
            bytes.extend(n.to_le_bytes());
        }
        bytes.extend(104u64.to_le_bytes());
        bytes.extend((data.len() as u64).to_le_bytes());
        bytes.extend(8u64.to_le_bytes());
        bytes.extend(data);
        bytes
    }

    const SAMPLES: [u8; 8] = [255, 0, 0, 51, 0, 0, 255, 255];

    #[test]
    fn plain_and_packed() {
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        packer.write_all(&SAMPLES).unwrap();
        let deflated = packer.finish().unwrap();
        let zstd = compress_to_vec(&SAMPLES[..], CompressionLevel::Fastest);
        for (packing, data) in [(0, &SAMPLES[..]), (2, &zstd), (3, &deflated)] {
            let bytes = file(43, packing, data);
            let image = read(&bytes).unwrap();
            assert_eq!(image.pixels, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
            assert_eq!(image.alpha, Some(vec![0.2, 1.0]));
            damage(&bytes, |b| b.len() == bytes.len() && read(b).is_ok());
        }
    }

    #[test]
    fn sizes_and_other_formats() {
        let error = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        assert!(error(&file(0, 0, &SAMPLES)).contains("UASTC"));
        assert!(error(&file(0, 1, &SAMPLES)).contains("ETC1S"));
        assert!(error(&file(157, 0, &SAMPLES)).contains("157"));
        let mut large = file(43, 2, &SAMPLES);
        large[20..28].fill(0xff);
        assert!(matches!(read(&large), Err(PictureError::TooLarge { .. })));
        // A megapixel of bytes that a short text cannot hold.
        let mut wide = file(109, 3, &SAMPLES);
        wide[20..28].copy_from_slice(&[0, 2, 0, 0, 0, 2, 0, 0]);
        assert!(matches!(read(&wide), Err(PictureError::TooLarge { .. })));
    }
}
