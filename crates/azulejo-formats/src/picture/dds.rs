//! DDS: Direct3D's textures; the first picture at its full size.
//!
//! Microsoft, *Programming Guide for DDS*.

use super::blocks::{TexelStorage, word};
use super::error::{PictureError, check_size, malformed};
use azulejo_scene::Image;

/// What the header says: size, storage, and the offset of the pixels.
struct DdsHeader {
    size: [usize; 2],
    storage: TexelStorage,
    start: usize,
}

/// Reads a DDS as linear light: BC1 to BC7, and uncompressed pixels. Values are taken as sRGB, whatever
/// the header says, except floating-point numbers. Of cubes, arrays and volumes, the first picture.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, of another format, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let header = header(bytes)?;
    let [width, height] = header.size;
    check_size(width as u64, height as u64, bytes.len())?;
    let data = bytes.get(header.start..).unwrap_or_default();
    header.storage.decode(header.size, true, data)
}

/// Columns and rows, from the header alone.
pub(super) fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    Ok(header(bytes)?.size.map(|n| n as u64))
}

fn header(bytes: &[u8]) -> Result<DdsHeader, PictureError> {
    let field = |at| word(bytes, at).ok_or_else(|| malformed("a DDS whose header ends early"));
    let size = [field(16)? as usize, field(12)? as usize];
    let (flags, code, bits) = (field(80)?, field(84)?.to_le_bytes(), field(88)? as usize);
    let masks = [field(92)?, field(96)?, field(100)?, field(104)?];
    let alpha = if flags & 1 == 0 { 0 } else { masks[3] };
    let storage = match (flags & 4 != 0, &code) {
        (true, b"DX10") => {
            let format = field(128)?;
            let storage = direct_x(format);
            let other = || malformed(format!("a DDS of DXGI format {format}, which is not read"));
            let storage = storage.ok_or_else(other)?;
            return Ok(DdsHeader {
                size,
                storage,
                start: 148,
            });
        }
        (true, _) => {
            let other = || {
                malformed(format!(
                    "a DDS of format {}, which is not read",
                    code.escape_ascii()
                ))
            };
            four_letters(code).ok_or_else(other)?
        }
        (false, _) if !matches!(bits, 8 | 16 | 24 | 32) => {
            return Err(malformed(format!("a DDS of {bits} bits per pixel")));
        }
        // Luminance, which the mask of red selects.
        (false, _) if flags & 0x2_0000 != 0 => {
            TexelStorage::MaskedGrey(bits / 8, [masks[0], alpha])
        }
        (false, _) if flags & 0x40 != 0 => {
            TexelStorage::Masked(bits / 8, [masks[0], masks[1], masks[2], alpha])
        }
        _ => return Err(malformed("a DDS without colours")),
    };
    Ok(DdsHeader {
        size,
        storage,
        start: 128,
    })
}

/// Formats named by four letters, or by the number of Direct3D 9.
fn four_letters(code: [u8; 4]) -> Option<TexelStorage> {
    Some(match &code {
        b"DXT1" => TexelStorage::Bc1,
        b"DXT2" | b"DXT3" => TexelStorage::Bc2,
        b"DXT4" | b"DXT5" => TexelStorage::Bc3,
        b"ATI1" | b"BC4U" => TexelStorage::Bc4(false),
        b"BC4S" => TexelStorage::Bc4(true),
        b"ATI2" | b"BC5U" => TexelStorage::Bc5(false),
        b"BC5S" => TexelStorage::Bc5(true),
        [36, 0, 0, 0] => TexelStorage::Words(4),
        [113, 0, 0, 0] => TexelStorage::Halves(4),
        [116, 0, 0, 0] => TexelStorage::Floats(4),
        _ => return None,
    })
}

/// Formats by their number in `DXGI_FORMAT`.
fn direct_x(format: u32) -> Option<TexelStorage> {
    Some(match format {
        2 => TexelStorage::Floats(4),
        6 => TexelStorage::Floats(3),
        10 => TexelStorage::Halves(4),
        11 => TexelStorage::Words(4),
        27..=29 => TexelStorage::Bytes(4),
        48 | 49 => TexelStorage::Bytes(2),
        60 | 61 => TexelStorage::Bytes(1),
        70..=72 => TexelStorage::Bc1,
        73..=75 => TexelStorage::Bc2,
        76..=78 => TexelStorage::Bc3,
        79 | 80 => TexelStorage::Bc4(false),
        81 => TexelStorage::Bc4(true),
        82 | 83 => TexelStorage::Bc5(false),
        84 => TexelStorage::Bc5(true),
        85 => TexelStorage::Masked(2, [0xf800, 0x7e0, 0x1f, 0]),
        86 => TexelStorage::Masked(2, [0x7c00, 0x3e0, 0x1f, 0x8000]),
        87 | 90 | 91 => TexelStorage::Bgr(4, true),
        88 | 92 | 93 => TexelStorage::Bgr(4, false),
        94 | 95 => TexelStorage::Bc6(false),
        96 => TexelStorage::Bc6(true),
        97..=99 => TexelStorage::Bc7,
        115 => TexelStorage::Masked(2, [0xf00, 0xf0, 0xf, 0xf000]),
        _ => return None,
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::picture::error::tests::damage;

    /// A file of 4 × 4 pixels, whose format is these letters, with the number of DXGI if they are `DX10`.
    pub(crate) fn file(letters: &[u8; 4], format: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"DDS ".to_vec();
        bytes.resize(128, 0);
        let mut set =
            |at: usize, value: u32| bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        set(4, 124);
        set(12, 4);
        set(16, 4);
        set(76, 32);
        set(80, 4);
        bytes[84..88].copy_from_slice(letters);
        if letters == b"DX10" {
            bytes.extend([format, 3, 0, 1, 0].map(u32::to_le_bytes).as_flattened());
        }
        bytes.extend(data);
        bytes
    }

    /// Red in all pixels, by each compression.
    #[test]
    fn every_compression() {
        let red = [0x00, 0xf8, 0, 0, 0, 0, 0, 0];
        let opaque = [&[0xff; 8][..], &red].concat();
        // Mode 5 of BC7: end points of 7 bits, all of red set in both.
        let check = |bytes: &[u8], expected: [f32; 3], alpha: Option<f32>| {
            let image = read(bytes).unwrap();
            assert_eq!(size(bytes), Ok([4, 4]));
            assert!(image.pixels.iter().all(|p| *p == expected), "{image:?}");
            assert_eq!(image.alpha.map(|a| a[5]), alpha);
            damage(bytes, |b| b.len() == bytes.len() && read(b).is_ok());
        };
        check(&file(b"DXT1", 0, &red), [1.0, 0.0, 0.0], None);
        check(&file(b"DXT3", 0, &opaque), [1.0, 0.0, 0.0], None);
        check(&file(b"DX10", 72, &red), [1.0, 0.0, 0.0], None);
        let clear = [&[51, 51, 0, 0, 0, 0, 0, 0][..], &red].concat();
        check(&file(b"DXT5", 0, &clear), [1.0, 0.0, 0.0], Some(0.2));
        check(
            &file(b"ATI1", 0, &[255, 0, 0, 0, 0, 0, 0, 0]),
            [1.0; 3],
            None,
        );
        let two = [255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        check(&file(b"ATI2", 0, &two), [1.0, 0.0, 0.0], None);
        // Bits 0 to 5 mode 5, rotation 0 in 6 and 7, then 7 bits each: red 127, 127, green and blue 0;
        // alpha 255, 255.
        let mut seven: u128 = 1 << 5;
        seven |= 0x3fff << 8;
        seven |= 0xffff << 50;
        check(
            &file(b"DX10", 98, &seven.to_le_bytes()),
            [1.0, 0.0, 0.0],
            None,
        );
        check(&file(b"DX10", 95, &[0; 16]), [0.0; 3], None);
        check(
            &file(b"DX10", 28, &[255, 0, 0, 51].repeat(16)),
            [1.0, 0.0, 0.0],
            Some(0.2),
        );
    }

    #[test]
    fn plain_pixels_by_masks() {
        let mut bytes = file(b"\0\0\0\0", 0, &[0, 0, 255, 51].repeat(16));
        let mut set =
            |at: usize, value: u32| bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        set(80, 0x41);
        set(88, 32);
        for (k, mask) in [0xff_0000, 0xff00, 0xff, 0xff00_0000]
            .into_iter()
            .enumerate()
        {
            set(92 + 4 * k, mask);
        }
        let image = read(&bytes).unwrap();
        assert_eq!(image.pixel(3, 3), [1.0, 0.0, 0.0]);
        assert_eq!(image.alpha, Some(vec![0.2; 16]));
    }

    #[test]
    fn other_formats_and_sizes() {
        let error = read(&file(b"UYVY", 0, &[])).unwrap_err().to_string();
        assert!(error.contains("UYVY"), "{error}");
        let error = read(&file(b"DX10", 26, &[])).unwrap_err().to_string();
        assert!(error.contains("26"), "{error}");
        let mut large = file(b"DXT1", 0, &[0; 8]);
        large[12..20].fill(0xff);
        assert!(matches!(read(&large), Err(PictureError::TooLarge { .. })));
    }
}
