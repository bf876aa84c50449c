//! Pictures: PNG, JPEG, Radiance HDR and OpenEXR, and what their readers share.

mod budget;
pub(crate) mod error;
pub mod exr;
pub mod hdr;
pub mod jpeg;
pub mod png;
pub(crate) mod srgb;

pub(crate) use budget::PixelBudget;
pub use error::PictureError;

use azulejo_scene::Image;
use error::malformed;

/// Reads a PNG, JPEG or Radiance HDR picture as linear light, recognized by its content.
///
/// # Errors
/// [`PictureError`]: another format, damaged, or larger than its bytes justify.
pub fn decode(bytes: &[u8]) -> Result<Image, PictureError> {
    match bytes {
        [0xff, 0xd8, ..] => jpeg::read(bytes),
        [b'#', b'?', ..] => hdr::read(bytes),
        [0x89, b'P', b'N', b'G', ..] => png::read(bytes),
        _ => Err(malformed(UNKNOWN)),
    }
}

/// What is said of all other bytes.
const UNKNOWN: &str = "a picture that is neither PNG, JPEG nor Radiance HDR";

/// The size of a picture that [`decode`] reads, from its header alone.
fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    match bytes {
        [0xff, 0xd8, ..] => jpeg::size(bytes),
        [b'#', b'?', ..] => hdr::size(bytes),
        [0x89, b'P', b'N', b'G', ..] => png::size(bytes),
        _ => Err(malformed(UNKNOWN)),
    }
}
