//! Pixels as graphics cards store them, plain or in compressed blocks: the content of DDS and KTX2.
//!
//! Microsoft, *Texture Block Compression in Direct3D 11*; Khronos, *Data Format Specification* 1.3.

use super::error::{MOST_PIXELS, PictureError, malformed};
use super::samples::{from_samples, from_srgb_bytes, little};
use ::exr::prelude::f16;
use azulejo_scene::Image;

/// How pixels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TexelStorage {
    /// Bytes of these many channels.
    Bytes(usize),
    /// Bytes blue, green, red, and a fourth that is alpha if `true`.
    Bgr(usize, bool),
    /// Words of 16 bits of these many channels.
    Words(usize),
    /// Floating-point numbers of 16 bits of these many channels.
    Halves(usize),
    /// Floating-point numbers of 32 bits of these many channels.
    Floats(usize),
    /// RGB of nine bits each with one exponent of five, in numbers of 32 bits.
    SharedExponent,
    /// Numbers of these many bytes, from which masks select red, green, blue and alpha.
    Masked(usize, [u32; 4]),
    /// As `Masked`, for grey.
    MaskedGrey(usize, [u32; 2]),
    /// RGB with alpha of one bit.
    Bc1,
    /// RGB with alpha of four bits.
    Bc2,
    /// RGB with interpolated alpha.
    Bc3,
    /// Grey, `true` if signed.
    Bc4(bool),
    /// Two channels, `true` if signed.
    Bc5(bool),
    /// Floating-point RGB, `true` if signed.
    Bc6(bool),
    /// RGBA of high quality.
    Bc7,
}

impl TexelStorage {
    /// Bytes of a picture; `None` if they overflow.
    pub(super) fn bytes(self, [width, height]: [usize; 2]) -> Option<usize> {
        let pixel = match self {
            TexelStorage::Bytes(n) | TexelStorage::Bgr(n, _) => n,
            TexelStorage::Words(n) | TexelStorage::Halves(n) => 2 * n,
            TexelStorage::Floats(n) => 4 * n,
            TexelStorage::SharedExponent => 4,
            TexelStorage::Masked(n, _) | TexelStorage::MaskedGrey(n, _) => n,
            TexelStorage::Bc1 | TexelStorage::Bc4(_) => return block_bytes([width, height], 8),
            _ => return block_bytes([width, height], 16),
        };
        width.checked_mul(height)?.checked_mul(pixel)
    }

    /// The picture, whose size the caller has limited. Integers are sRGB if `srgb`, else linear; alpha and
    /// floating-point numbers are linear.
    ///
    /// # Errors
    /// [`PictureError`]: fewer bytes than the size requires.
    pub(super) fn decode(
        self,
        size: [usize; 2],
        srgb: bool,
        bytes: &[u8],
    ) -> Result<Image, PictureError> {
        let needed = self.bytes(size).filter(|&n| n as u64 <= 16 * MOST_PIXELS);
        let bytes = needed.and_then(|n| bytes.get(..n));
        let bytes = bytes.ok_or_else(|| malformed("the picture ends before its last pixel"))?;
        let shown = size.map(|n| n as u32);
        let integers = |channels: usize, samples: &[u8]| {
            if srgb {
                return from_srgb_bytes(shown, channels, samples);
            }
            let value = |i: usize| f32::from(samples[i]) / 255.0;
            from_samples(shown, channels, samples.len(), value, value)
        };
        let numbers = |channels: usize, count: usize, value: &dyn Fn(usize) -> f32| {
            // What is not a number is black, and clear.
            let limited = |i: usize, most: f32| value(i).max(0.0).min(most);
            from_samples(
                shown,
                channels,
                count,
                |i| limited(i, f32::MAX),
                |i| limited(i, 1.0),
            )
        };
        match self {
            TexelStorage::Bytes(1) => integers(1, bytes),
            // Red and green, not grey and alpha.
            TexelStorage::Bytes(2) => integers(3, &pixels(bytes, 2, |p| [p[0], p[1], 0])),
            TexelStorage::Bytes(n) => integers(n, bytes),
            TexelStorage::Bgr(n, true) => {
                integers(4, &pixels(bytes, n, |p| [p[2], p[1], p[0], p[3]]))
            }
            TexelStorage::Bgr(n, false) => integers(3, &pixels(bytes, n, |p| [p[2], p[1], p[0]])),
            TexelStorage::Words(n) => {
                let word = |i: usize| u16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]);
                numbers(n, bytes.len() / 2, &|i| f32::from(word(i)) / 65535.0)
            }
            TexelStorage::Halves(n) => {
                let (halves, _) = bytes.as_chunks::<2>();
                numbers(n, halves.len(), &|i| f16::from_le_bytes(halves[i]).to_f32())
            }
            TexelStorage::Floats(n) => {
                let (words, _) = bytes.as_chunks::<4>();
                numbers(n, words.len(), &|i| f32::from_le_bytes(words[i]))
            }
            TexelStorage::SharedExponent => {
                let (words, _) = bytes.as_chunks::<4>();
                let channels = |w: &[u8; 4]| shared_exponent(u32::from_le_bytes(*w));
                let samples: Vec<f32> = words.iter().flat_map(channels).collect();
                numbers(3, samples.len(), &|i| samples[i])
            }
            TexelStorage::Masked(n, masks) => {
                let value = |p: &[u8]| masks.map(|mask| super::bmp::masked(number(p), mask));
                match masks[3] {
                    0 => integers(
                        3,
                        &pixels(bytes, n, |p| value(p)[..3].try_into().unwrap_or([0; 3])),
                    ),
                    _ => integers(4, &pixels(bytes, n, value)),
                }
            }
            TexelStorage::MaskedGrey(n, masks) => {
                let value = |p: &[u8]| masks.map(|mask| super::bmp::masked(number(p), mask));
                match masks[1] {
                    0 => integers(1, &pixels(bytes, n, |p| [value(p)[0]])),
                    _ => integers(2, &pixels(bytes, n, value)),
                }
            }
            TexelStorage::Bc1 => integers(4, &unpacked::<u8, 4>(size, bytes, 8, bcdec_rs::bc1)),
            TexelStorage::Bc2 => integers(4, &unpacked::<u8, 4>(size, bytes, 16, bcdec_rs::bc2)),
            TexelStorage::Bc3 => integers(4, &unpacked::<u8, 4>(size, bytes, 16, bcdec_rs::bc3)),
            TexelStorage::Bc7 => integers(4, &unpacked::<u8, 4>(size, bytes, 16, bcdec_rs::bc7)),
            TexelStorage::Bc4(signed) => {
                let samples =
                    unpacked::<u8, 1>(size, bytes, 8, |b, t, p| bcdec_rs::bc4(b, t, p, signed));
                integers(1, &samples)
            }
            TexelStorage::Bc5(signed) => {
                let samples =
                    unpacked::<u8, 2>(size, bytes, 16, |b, t, p| bcdec_rs::bc5(b, t, p, signed));
                integers(3, &pixels(&samples, 2, |p| [p[0], p[1], 0]))
            }
            TexelStorage::Bc6(signed) => {
                let decode = |b: &[u8], t: &mut [f32], p| bcdec_rs::bc6h_float(b, t, p, signed);
                let samples = unpacked::<f32, 3>(size, bytes, 16, decode);
                numbers(3, samples.len(), &|i| samples[i])
            }
        }
    }
}

/// Whole blocks of 4 × 4 pixels.
fn block_bytes([width, height]: [usize; 2], block: usize) -> Option<usize> {
    let blocks = width.div_ceil(4).checked_mul(height.div_ceil(4))?;
    blocks.checked_mul(block)
}

/// The number that up to four bytes are.
fn number(pixel: &[u8]) -> u32 {
    pixel.iter().rev().fold(0, |n, &b| n << 8 | u32::from(b))
}

/// Every pixel of `n` bytes, changed.
fn pixels<const M: usize>(bytes: &[u8], n: usize, change: impl Fn(&[u8]) -> [u8; M]) -> Vec<u8> {
    bytes.chunks_exact(n).flat_map(change).collect()
}

/// Red, green and blue with one exponent, from the lowest bits upwards.
fn shared_exponent(word: u32) -> [f32; 3] {
    let scale = 2f32.powi((word >> 27) as i32 - 24);
    [0, 9, 18].map(|shift| (word >> shift & 0x1ff) as f32 * scale)
}

/// Blocks of 4 × 4 pixels with `N` samples each; `decode` takes a block, its pixels and their pitch.
fn unpacked<T: Copy + Default, const N: usize>(
    [width, height]: [usize; 2],
    bytes: &[u8],
    block: usize,
    decode: impl Fn(&[u8], &mut [T], usize),
) -> Vec<T> {
    let mut samples = vec![T::default(); N * width * height];
    let across = width.div_ceil(4);
    let mut tile = vec![T::default(); 16 * N];
    for (k, packed) in bytes.chunks_exact(block).enumerate() {
        decode(packed, &mut tile, 4 * N);
        let (x, y) = (4 * (k % across), 4 * (k / across));
        let columns = (width - x).min(4);
        for row in 0..(height - y).min(4) {
            let at = N * ((y + row) * width + x);
            samples[at..at + N * columns].copy_from_slice(&tile[4 * N * row..][..N * columns]);
        }
    }
    samples
}

/// The 32 bits at `at`, the least significant byte first.
pub(super) fn word(bytes: &[u8], at: usize) -> Option<u32> {
    little::<4>(bytes, at).map(|n| n as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_precision() {
        let pairs = [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (1, 2f32.powi(-24)),
            (0x7c00, f32::INFINITY),
        ];
        for (bits, value) in pairs {
            assert_eq!(f16::from_bits(bits).to_f32(), value);
        }
    }

    #[test]
    fn blocks_are_cut_at_the_edges() {
        // BC1: red and black, the first pixel of each row red, the others black.
        let block = [0x00, 0xf8, 0, 0, 0x54, 0x54, 0x54, 0x54];
        let image = TexelStorage::Bc1
            .decode([5, 1], true, &block.repeat(2))
            .unwrap();
        assert_eq!(image.pixel(0, 0), [1.0, 0.0, 0.0]);
        assert_eq!(image.pixel(1, 0), [0.0; 3]);
        assert_eq!(image.pixel(4, 0), [1.0, 0.0, 0.0]);
        assert!(TexelStorage::Bc1.decode([5, 1], true, &block).is_err());
    }

    #[test]
    fn channels_are_sorted() {
        let check =
            |storage: TexelStorage, bytes: &[u8], expected: [f32; 3], alpha: Option<f32>| {
                let image = storage.decode([1, 1], true, bytes).unwrap();
                assert_eq!(image.pixels, [expected], "{storage:?}");
                assert_eq!(image.alpha.map(|a| a[0]), alpha, "{storage:?}");
            };
        let red = [1.0, 0.0, 0.0];
        check(TexelStorage::Bgr(4, true), &[0, 0, 255, 51], red, Some(0.2));
        check(TexelStorage::Bgr(4, false), &[0, 0, 255, 51], red, None);
        check(TexelStorage::Bytes(2), &[255, 0], red, None);
        check(TexelStorage::Bytes(4), &[255, 0, 0, 51], red, Some(0.2));
        check(
            TexelStorage::Masked(2, [0xf800, 0x7e0, 0x1f, 0]),
            &[0, 0xf8],
            red,
            None,
        );
        check(
            TexelStorage::Masked(2, [0xf00, 0xf0, 0xf, 0xf000]),
            &[0, 0x3f],
            red,
            Some(0.2),
        );
        check(
            TexelStorage::MaskedGrey(2, [0xff, 0xff00]),
            &[255, 51],
            [1.0; 3],
            Some(0.2),
        );
        check(
            TexelStorage::Halves(4),
            &[0, 0x40, 0, 0, 0, 0, 0, 0x3c],
            [2.0, 0.0, 0.0],
            None,
        );
        let unusual = [f32::NAN, f32::INFINITY, -1.0, f32::NAN].map(f32::to_le_bytes);
        check(
            TexelStorage::Floats(4),
            &unusual.concat(),
            [0.0, f32::MAX, 0.0],
            Some(0.0),
        );
    }
}
