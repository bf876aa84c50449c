//! WebP: lossy, lossless, and the first frame of an animation.

use super::error::{PictureError, check_size, malformed};
use super::samples::{from_srgb_bytes, little};
use azulejo_scene::Image;
use image_webp::WebPDecoder;
use std::io::Cursor;

/// Reads a WebP as linear light, with its alpha channel. Values are taken as sRGB, whatever colour
/// profile the file contains.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let mut decoder = start(bytes)?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into(), bytes.len())?;
    check_frames(bytes.get(12..).unwrap_or_default(), bytes.len())?;
    let too_large = PictureError::TooLarge {
        width: width.into(),
        height: height.into(),
    };
    let mut samples = vec![0; decoder.output_buffer_size().ok_or(too_large)?];
    decoder.read_image(&mut samples).map_err(malformed)?;
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    from_srgb_bytes([width, height], channels, &samples)
}

/// Columns and rows, from the header alone.
pub(super) fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    let (width, height) = start(bytes)?.dimensions();
    Ok([width.into(), height.into()])
}

fn start(bytes: &[u8]) -> Result<WebPDecoder<Cursor<&[u8]>>, PictureError> {
    let mut decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(malformed)?;
    decoder.set_memory_limit(bytes.len());
    Ok(decoder)
}

/// Rejects lossy frames that claim more pixels than `length` bytes justify: the decoder allocates them
/// before it compares them with the picture.
fn check_frames(mut chunks: &[u8], length: usize) -> Result<(), PictureError> {
    while let Some(stored) = little::<4>(chunks, 4) {
        let content = chunks.get(8..).unwrap_or_default();
        let inside = &content[..content.len().min(stored as usize)];
        match &chunks[..4] {
            b"VP8 " => {
                let side = |at| little::<2>(inside, at).unwrap_or(0) & 0x3fff;
                check_size(side(6), side(8), length)?;
            }
            b"ANMF" => check_frames(inside.get(16..).unwrap_or_default(), length)?,
            _ => {}
        }
        let skipped = stored as usize + stored as usize % 2;
        chunks = content.get(skipped..).unwrap_or_default();
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::picture::error::tests::damage;
    use image_webp::{ColorType, WebPEncoder};

    /// 2 × 1 pixels, lossless.
    pub(crate) fn file(color: ColorType, samples: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let encoder = WebPEncoder::new(&mut file);
        encoder.encode(samples, 2, 1, color).unwrap();
        file
    }

    #[test]
    fn colours_and_alpha() {
        let opaque = file(ColorType::Rgb8, &[255, 0, 0, 255, 255, 255]);
        let image = read(&opaque).unwrap();
        assert_eq!(image.pixels, [[1.0, 0.0, 0.0], [1.0; 3]]);
        assert_eq!(image.alpha, None);
        let clear = file(ColorType::Rgba8, &[255, 0, 0, 51, 255, 255, 255, 255]);
        assert_eq!(read(&clear).unwrap().alpha, Some(vec![0.2, 1.0]));
        damage(&clear, |b| b.len() == clear.len() && read(b).is_ok());
    }

    #[test]
    fn sizes_are_justified() {
        let mut large = file(ColorType::Rgb8, &[255, 0, 0, 255, 255, 255]);
        // 14 bits of columns and rows after the signature.
        large[21..24].copy_from_slice(&[0xfe, 0xff, 0xff]);
        assert!(matches!(read(&large), Err(PictureError::TooLarge { .. })));
        // A small picture whose lossy frame claims to be the largest.
        let frame = b"\0\0\0\x9d\x01\x2a\xff\x3f\xff\x3f";
        let chunk = [&b"VP8 \x0a\0\0\0"[..], frame].concat();
        assert!(matches!(
            check_frames(&chunk, 60),
            Err(PictureError::TooLarge { .. })
        ));
        let nested = [&b"ANMF\x22\0\0\0"[..], &[0; 16], &chunk].concat();
        assert!(check_frames(&nested, 60).is_err());
    }
}
