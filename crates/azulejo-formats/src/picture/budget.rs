//! The limit on what the pictures of one model take together.

use super::error::{MOST_PIXELS, PictureError};
use super::{decode, size};
use azulejo_scene::Image;

/// Counts the pixels of a model's pictures before they take memory. Together they may have as many
/// as a single picture: a model can name a small file of very many pixels, in many copies.
#[derive(Debug)]
pub(crate) struct PixelBudget {
    left: u64,
}

impl Default for PixelBudget {
    fn default() -> PixelBudget {
        PixelBudget { left: MOST_PIXELS }
    }
}

impl PixelBudget {
    /// Decodes a picture if its pixels are left.
    ///
    /// # Errors
    /// As [`decode`](super::decode()), as text, and more pixels than are left, of which nothing is
    /// decoded then.
    pub fn decode(&mut self, bytes: &[u8]) -> Result<Image, String> {
        let message = |e: PictureError| e.to_string();
        let [width, height] = size(bytes).map_err(message)?;
        let left = self.after(width.saturating_mul(height))?;
        let image = decode(bytes).map_err(message)?;
        self.left = left;
        Ok(image)
    }

    /// Counts a picture whose pixels are there already.
    ///
    /// # Errors
    /// More pixels than are left, as text.
    pub fn admit(&mut self, image: &Image) -> Result<(), String> {
        self.left = self.after(image.pixels.len() as u64)?;
        Ok(())
    }

    fn after(&self, pixels: u64) -> Result<u64, String> {
        let left = self.left.checked_sub(pixels);
        left.ok_or_else(|| format!("the pictures have more than {MOST_PIXELS} pixels in total"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{hdr, jpeg, png};

    #[test]
    fn pixels_are_counted_before_they_are_decoded() {
        let image = Image::new(3, 2);
        let (mut first, mut second) = (Vec::new(), Vec::new());
        png::write(3, 2, &[0; 18], &mut first).unwrap();
        hdr::write(&image, &mut second).unwrap();
        for bytes in [first, second] {
            assert_eq!(size(&bytes), Ok([3, 2]));
            let mut budget = PixelBudget { left: 11 };
            assert_eq!(budget.decode(&bytes).unwrap().pixels.len(), 6);
            // The header alone suffices to refuse the next.
            let error = budget.decode(&bytes[..bytes.len() - 2]).unwrap_err();
            assert!(error.contains("pixels in total"), "{error}");
            budget.admit(&Image::new(5, 1)).unwrap();
            assert!(budget.admit(&image).is_err());
        }
        assert_eq!(jpeg::size(&jpeg::tests::grey()), Ok([16, 8]));
    }

    /// A file of kilobytes that claims the largest picture, a hundred times in one model.
    #[test]
    fn a_picture_in_a_hundred_copies() {
        let mut budget = PixelBudget::default();
        let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8192 +X 16384\n";
        let mut bytes = header.to_vec();
        bytes.resize(1 << 15, 0);
        for _ in 0..100 {
            assert!(budget.decode(&bytes).is_err());
        }
        budget.left -= 1;
        let error = budget.decode(&bytes).unwrap_err();
        assert!(error.contains("pixels in total"), "{error}");
    }
}
