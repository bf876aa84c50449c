//! Errors of picture readers, and the limit on the size of pictures.

use azulejo_scene::Image;
use std::fmt;

/// Why a picture could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PictureError {
    /// The bytes are not in this format, or are damaged; the text gives the reason.
    Malformed(String),
    /// More pixels than a picture may have.
    TooLarge {
        /// Columns that the file claims.
        width: u64,
        /// Rows that the file claims.
        height: u64,
    },
}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PictureError::Malformed(how) => f.write_str(how),
            PictureError::TooLarge { width, height } => write!(
                f,
                "the picture claims to have {width} × {height} pixels: more than {MOST_PIXELS}, or more than its bytes can hold"
            ),
        }
    }
}

impl std::error::Error for PictureError {}

/// Largest picture that is read, in pixels: 1.6 GB once it is decoded, 2.1 GB with an alpha channel.
pub(crate) const MOST_PIXELS: u64 = 1 << 27;

/// Most pixels that one byte of a file can encode. The densest compression, DEFLATE, makes 1032
/// bytes of one, hence 8256 pixels of one bit.
const MOST_PIXELS_PER_BYTE: u64 = 8256;

/// Rejects sizes that would take memory which the file's own length does not justify.
pub(crate) fn check_size(width: u64, height: u64, bytes: usize) -> Result<(), PictureError> {
    let justified = (bytes as u64).saturating_mul(MOST_PIXELS_PER_BYTE);
    // A side of 0 does not make the other one free: readers allocate whole rows.
    let fits = width
        .max(1)
        .checked_mul(height.max(1))
        .is_some_and(|pixels| pixels <= MOST_PIXELS.min(justified));
    if fits {
        Ok(())
    } else {
        Err(PictureError::TooLarge { width, height })
    }
}

pub(crate) fn malformed(how: impl fmt::Display) -> PictureError {
    PictureError::Malformed(how.to_string())
}

/// Panics unless the number of pixels matches the picture's size, as every writer requires.
pub(crate) fn assert_whole(image: &Image) {
    assert_eq!(
        image.pixels.len(),
        image.width as usize * image.height as usize,
        "a picture whose size does not match its pixels"
    );
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A picture with runs, ramps, large and small values.
    pub(crate) fn gradient(width: u32, height: u32) -> Image {
        let pixel = |i: u32| {
            let (x, y) = ((i % width) as f32, (i / width) as f32);
            [
                x * 0.25,
                if x > 9.0 { 3.0 } else { y * 1e4 },
                (x * y).exp2().min(1e9) * 1e-6,
            ]
        };
        Image {
            width,
            height,
            pixels: (0..width * height).map(pixel).collect(),
            alpha: None,
        }
    }

    /// Cuts a file at every byte, and changes every byte: `read` must return, and must reject
    /// what is cut before its last tenth.
    pub(crate) fn damage(file: &[u8], read: impl Fn(&[u8]) -> bool) {
        assert!(read(file));
        for end in 0..file.len() {
            let accepted = read(&file[..end]);
            assert!(
                !accepted || end * 10 > file.len() * 9,
                "accepted {end} of {} bytes",
                file.len()
            );
        }
        let mut changed = file.to_vec();
        for at in 0..file.len() {
            for value in [0, 0xff, file[at] ^ 0x80, file[at].wrapping_add(1)] {
                changed[at] = value;
                read(&changed);
            }
            changed[at] = file[at];
        }
    }

    #[test]
    fn sizes_are_justified() {
        assert_eq!(check_size(100, 100, 100), Ok(()));
        assert!(check_size(1000, 1000, 100).is_err());
        assert!(check_size(1 << 20, 1 << 20, usize::MAX).is_err());
        assert!(check_size(u64::MAX, 2, usize::MAX).is_err());
        assert!(check_size(u64::MAX, 0, 100).is_err());
        assert!(check_size(0, 1 << 40, 100).is_err());
    }
}
