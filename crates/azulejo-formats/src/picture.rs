//! What the readers of pictures share.

use azulejo_scene::Image;
use std::fmt;

/// Why a picture could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PictureError {
    /// The bytes are not of this format, or are damaged; the text says how.
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
                "the picture claims {width} × {height} pixels, more than {MOST_PIXELS} or than its bytes can hold"
            ),
        }
    }
}

impl std::error::Error for PictureError {}

/// Largest picture read, in pixels: 1.6 GB once it is decoded.
const MOST_PIXELS: u64 = 1 << 27;

/// Pixels that one byte of a file can stand for. The densest, DEFLATE, makes 1032 bytes of one,
/// hence 8256 pixels of one bit.
const MOST_PIXELS_PER_BYTE: u64 = 8256;

/// Refuses sizes that would take memory which the file's own length does not justify.
pub(crate) fn check_size(width: u64, height: u64, bytes: usize) -> Result<(), PictureError> {
    let justified = (bytes as u64).saturating_mul(MOST_PIXELS_PER_BYTE);
    let fits = width
        .checked_mul(height)
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

/// Panics unless the picture has the pixels that its size promises, as every writer needs.
pub(crate) fn assert_whole(image: &Image) {
    assert_eq!(
        image.pixels.len(),
        image.width as usize * image.height as usize,
        "a picture whose size is not that of its pixels"
    );
}
