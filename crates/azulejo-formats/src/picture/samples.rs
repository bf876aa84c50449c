//! Samples of a decoded picture, row by row, to linear light and opacity.

use super::error::{PictureError, malformed};
use super::srgb::linear_table;
use azulejo_scene::Image;

/// A picture of `width × height` pixels of one to four samples each: grey, grey and alpha, RGB, RGBA.
/// `color` and `alpha` return the linear value of a sample by its index.
///
/// # Errors
/// [`PictureError`]: fewer than `count` samples were decoded, or another number of channels.
pub(super) fn from_samples(
    [width, height]: [u32; 2],
    channels: usize,
    count: usize,
    color: impl Fn(usize) -> f32,
    alpha: impl Fn(usize) -> f32,
) -> Result<Image, PictureError> {
    let pixels = width as usize * height as usize;
    if !(1..=4).contains(&channels) {
        return Err(malformed(format!("{channels} channels, expected 1 to 4")));
    }
    if pixels.checked_mul(channels).is_none_or(|n| n > count) {
        return Err(malformed("the picture ends before its last pixel"));
    }
    let parts = if channels < 3 { [0; 3] } else { [0, 1, 2] };
    let image = Image::opaque(
        width,
        height,
        (0..pixels)
            .map(|p| parts.map(|c| color(channels * p + c)))
            .collect(),
    );
    if channels % 2 == 1 {
        return Ok(image);
    }
    let last = channels - 1;
    // Most pictures with an alpha channel are opaque: no list is made for these.
    if (0..pixels).all(|p| alpha(channels * p + last) >= 1.0) {
        return Ok(image);
    }
    Ok(image.with_alpha((0..pixels).map(|p| alpha(channels * p + last)).collect()))
}

/// As [`from_samples`], from bytes: colours as sRGB, alpha as it is.
pub(super) fn from_srgb_bytes(
    size: [u32; 2],
    channels: usize,
    samples: &[u8],
) -> Result<Image, PictureError> {
    let linear = linear_table();
    from_samples(
        size,
        channels,
        samples.len(),
        |i| linear[usize::from(samples[i])],
        |i| f32::from(samples[i]) / 255.0,
    )
}

/// An unsigned integer of `N` bytes at `at`, the least significant first.
pub(super) fn little<const N: usize>(bytes: &[u8], at: usize) -> Option<u64> {
    let taken = bytes.get(at..at.checked_add(N)?)?;
    Some(taken.iter().rev().fold(0, |n, &b| n << 8 | u64::from(b)))
}
