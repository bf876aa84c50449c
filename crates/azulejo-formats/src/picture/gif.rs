//! GIF: the first frame.

use super::error::{PictureError, check_size, malformed};
use super::samples::from_srgb_bytes;
use azulejo_scene::Image;
use gif::{ColorOutput, DecodeOptions, Decoder};
use std::num::NonZeroU64;

/// Reads the first frame of a GIF as linear light, on its screen: transparent where the frame is, and
/// around it. Values are taken as sRGB.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, without a frame, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let mut decoder = start(bytes)?;
    let [width, height] = [decoder.width(), decoder.height()].map(usize::from);
    check_size(width as u64, height as u64, bytes.len())?;
    let frame = decoder.read_next_frame().map_err(malformed)?;
    let frame = frame.ok_or_else(|| malformed("a GIF without a picture"))?;
    let (columns, rows) = (usize::from(frame.width), usize::from(frame.height));
    let (left, top) = (usize::from(frame.left), usize::from(frame.top));
    let mut samples = vec![0; 4 * width * height];
    // The decoder has checked that the frame is inside.
    for (y, row) in frame
        .buffer
        .chunks_exact(4 * columns.max(1))
        .take(rows)
        .enumerate()
    {
        let at = 4 * ((top + y) * width + left);
        samples[at..at + row.len()].copy_from_slice(row);
    }
    from_srgb_bytes([width as u32, height as u32], 4, &samples)
}

/// Columns and rows, from the header alone.
pub(super) fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    let decoder = start(bytes)?;
    Ok([decoder.width().into(), decoder.height().into()])
}

fn start(bytes: &[u8]) -> Result<Decoder<&[u8]>, PictureError> {
    let mut options = DecodeOptions::new();
    options.set_color_output(ColorOutput::RGBA);
    options.check_frame_consistency(true);
    // One code of 12 bits stands for 4096 pixels at most.
    let most = 4 * 4096 * (bytes.len() as u64 + 1);
    let most = NonZeroU64::new(most).unwrap_or(NonZeroU64::MAX);
    options.set_memory_limit(gif::MemoryLimit::Bytes(most));
    options.read_info(bytes).map_err(malformed)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::picture::error::tests::damage;

    /// 4 × 2 pixels, of which a frame of 2 × 1 at (1, 1) shows red, and a colour that is transparent.
    pub(crate) const SMALL: &[u8] = b"GIF89a\x04\0\x02\0\x80\0\0\xff\0\0\0\0\xff\
        !\xf9\x04\x01\0\0\x01\0,\x01\0\x01\0\x02\0\x01\0\0\x02\x02\x44\x0a\0;";

    #[test]
    fn the_first_frame_on_its_screen() {
        let image = read(SMALL).unwrap();
        assert_eq!((image.width, image.height), (4, 2));
        assert_eq!(image.pixel(1, 1), [1.0, 0.0, 0.0]);
        let alpha = image.alpha.unwrap();
        assert_eq!(alpha, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        damage(SMALL, |b| b.len() == SMALL.len() && read(b).is_ok());
    }

    #[test]
    fn sizes_are_justified() {
        let mut large = SMALL.to_vec();
        large[6..10].fill(0xff);
        assert!(matches!(read(&large), Err(PictureError::TooLarge { .. })));
        let mut outside = SMALL.to_vec();
        let frame = outside.iter().position(|&b| b == b',').unwrap();
        outside[frame + 5..frame + 9].fill(0xff);
        assert!(read(&outside).is_err());
    }
}
