//! TIFF: the first picture of a file.

use super::error::{MOST_PIXELS, PictureError, check_size, malformed};
use super::samples::from_samples;
use super::srgb::linear_from_srgb;
use azulejo_scene::Image;
use std::io::Cursor;
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};

/// Most bytes that one byte of a file can encode: 1032 by DEFLATE, more by LZW's and fax's runs, of one
/// bit per pixel.
const MOST_BYTES_PER_BYTE: u64 = 4096;

/// Reads the first picture of a TIFF as linear light: grey and RGB, with alpha, of 1 to 16 bits
/// taken as sRGB, or of floating-point numbers taken as linear; uncompressed, PackBits, LZW, DEFLATE,
/// fax, JPEG; in strips or tiles, chunky or in planes.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, a palette, CMYK or Lab, another compression, or larger than its bytes
/// justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let mut decoder = start(bytes)?;
    let (width, height) = decoder.dimensions().map_err(malformed)?;
    check_size(width.into(), height.into(), bytes.len())?;
    let kind = decoder.colortype().map_err(malformed)?;
    let mut decoded = DecodingResult::U8(Vec::new());
    let layout = decoder
        .read_image_to_buffer(&mut decoded)
        .map_err(malformed)?;
    let planes = TiffPlanes {
        size: [width as usize, height as usize],
        channels: match kind {
            ColorType::Gray(_) => 1,
            ColorType::GrayA(_) => 2,
            ColorType::RGB(_) | ColorType::YCbCr(_) => 3,
            ColorType::RGBA(_) => 4,
            other => return Err(malformed(format!("a TIFF of {other:?}, which is not read"))),
        },
        separate: layout.planes > 1,
        bits: kind.bit_depth(),
        row: layout.row_stride.map_or(0, usize::from),
    };
    let samples = planes.shares(&decoded)?;
    let float = matches!(
        decoded,
        DecodingResult::F32(_) | DecodingResult::F64(_) | DecodingResult::F16(_)
    );
    // The decoder has inverted what is white at 0.
    let color = |i: usize| {
        if float {
            samples[i].clamp(0.0, f32::MAX)
        } else {
            linear_from_srgb(samples[i])
        }
    };
    let alpha = |i: usize| samples[i].clamp(0.0, 1.0);
    from_samples(
        [width, height],
        planes.channels,
        samples.len(),
        color,
        alpha,
    )
}

/// Columns and rows, from the header alone.
pub(super) fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    let (width, height) = start(bytes)?.dimensions().map_err(malformed)?;
    Ok([width.into(), height.into()])
}

fn start(bytes: &[u8]) -> Result<Decoder<Cursor<&[u8]>>, PictureError> {
    let justified = (bytes.len() as u64).saturating_mul(MOST_BYTES_PER_BYTE);
    let most = justified.min(16 * MOST_PIXELS) as usize;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = most;
    limits.intermediate_buffer_size = most;
    limits.ifd_value_size = bytes.len();
    let decoder = Decoder::new(Cursor::new(bytes)).map_err(malformed)?;
    Ok(decoder.with_limits(limits))
}

/// Where the decoder puts samples.
struct TiffPlanes {
    size: [usize; 2],
    channels: usize,
    /// Whether each channel has a plane of its own.
    separate: bool,
    bits: u8,
    /// Bytes per row.
    row: usize,
}

impl TiffPlanes {
    /// All samples pixel by pixel, integers as shares of their largest value.
    fn shares(&self, decoded: &DecodingResult) -> Result<Vec<f32>, PictureError> {
        let [width, height] = self.size;
        let count = width * height * self.channels;
        let order = |k: usize| {
            if self.separate {
                k % self.channels * width * height + k / self.channels
            } else {
                k
            }
        };
        fn listed(
            list: &[impl Copy],
            count: usize,
            order: impl Fn(usize) -> usize,
            value: impl Fn(usize) -> f32,
        ) -> Option<Vec<f32>> {
            (list.len() >= count).then(|| (0..count).map(|k| value(order(k))).collect())
        }
        let shares = match decoded {
            DecodingResult::U8(list) if self.bits < 8 => self.packed(list, count),
            DecodingResult::U8(list) => listed(list, count, order, |i| f32::from(list[i]) / 255.0),
            DecodingResult::U16(list) => {
                let most = ((1u32 << self.bits.clamp(9, 16)) - 1) as f32;
                listed(list, count, order, |i| f32::from(list[i]) / most)
            }
            DecodingResult::F16(list) => listed(list, count, order, |i| list[i].to_f32()),
            DecodingResult::F32(list) => listed(list, count, order, |i| list[i]),
            DecodingResult::F64(list) => listed(list, count, order, |i| list[i] as f32),
            _ => return Err(malformed("a TIFF of numbers that are not read")),
        };
        shares.ok_or_else(|| malformed("the TIFF ends before its last pixel"))
    }

    /// Samples of fewer than 8 bits, whose rows begin with whole bytes.
    fn packed(&self, list: &[u8], count: usize) -> Option<Vec<f32>> {
        let (bits, per_row) = (usize::from(self.bits), self.size[0] * self.channels);
        let whole = !self.separate && matches!(bits, 1 | 2 | 4) && per_row > 0;
        let stride = self.row.max((per_row * bits).div_ceil(8));
        let fits =
            count == 0 || list.len() >= (self.size[1] - 1) * stride + (per_row * bits).div_ceil(8);
        if !whole || !fits {
            return None;
        }
        let most = (1u32 << bits) - 1;
        let share = |k: usize| {
            let bit = k % per_row * bits;
            let byte = u32::from(list[k / per_row * stride + bit / 8]);
            (byte >> (8 - bits - bit % 8) & most) as f32 / most as f32
        };
        Some((0..count).map(share).collect())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::picture::error::tests::damage;
    use tiff::encoder::{TiffEncoder, colortype};

    /// 2 × 1 pixels of one encoder's kind.
    pub(crate) fn file<C: colortype::ColorType>(samples: &[C::Inner]) -> Vec<u8>
    where
        [C::Inner]: tiff::encoder::TiffValue,
    {
        let mut file = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut file).unwrap();
        encoder.write_image::<C>(2, 1, samples).unwrap();
        file.into_inner()
    }

    fn check(bytes: &[u8], expected: [[f32; 3]; 2], alpha: Option<Vec<f32>>) {
        let image = read(bytes).unwrap();
        let near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-6;
        let samples = image.pixels.as_flattened().iter();
        assert!(samples.zip(expected.as_flattened()).all(near), "{image:?}");
        assert_eq!(image.alpha, alpha);
        damage(bytes, |b| b.len() == bytes.len() && read(b).is_ok());
    }

    #[test]
    fn kinds_of_samples() {
        let (red, white, black) = ([1.0, 0.0, 0.0], [1.0; 3], [0.0; 3]);
        check(
            &file::<colortype::RGB8>(&[255, 0, 0, 255, 255, 255]),
            [red, white],
            None,
        );
        check(&file::<colortype::Gray8>(&[255, 0]), [white, black], None);
        check(
            &file::<colortype::Gray16>(&[65535, 0]),
            [white, black],
            None,
        );
        check(
            &file::<colortype::RGB32Float>(&[7.0, 0.0, 0.0, 1.0, 1.0, 1.0]),
            [[7.0, 0.0, 0.0], white],
            None,
        );
        check(
            &file::<colortype::RGBA8>(&[255, 0, 0, 51, 0, 0, 0, 255]),
            [red, black],
            Some(vec![0.2, 1.0]),
        );
    }

    /// Two columns of one bit, written by hand, where white is 0 or 1.
    #[test]
    fn single_bits() {
        let entry = |tag: u16, kind: u16, count: u32, value: u32| {
            [
                &tag.to_le_bytes()[..],
                &kind.to_le_bytes(),
                &count.to_le_bytes(),
                &value.to_le_bytes(),
            ]
            .concat()
        };
        let file = |photometric: u32, data: u8| {
            let entries = [
                entry(256, 3, 1, 2),
                entry(257, 3, 1, 1),
                entry(258, 3, 1, 1),
                entry(259, 3, 1, 1),
                entry(262, 3, 1, photometric),
                entry(273, 4, 1, 8),
                entry(277, 3, 1, 1),
                entry(278, 3, 1, 1),
                entry(279, 4, 1, 1),
            ];
            let start = [&b"II*\0\x10\0\0\0"[..], &[data], &[0; 7]].concat();
            let count = (entries.len() as u16).to_le_bytes();
            [start, count.to_vec(), entries.concat(), vec![0; 4]].concat()
        };
        let (white, black) = ([1.0; 3], [0.0; 3]);
        check(&file(0, 0x40), [white, black], None);
        check(&file(1, 0x40), [black, white], None);
    }

    #[test]
    fn sizes_are_justified() {
        let mut large = file::<colortype::Gray8>(&[255, 0]);
        // The entry of the width: tag 256.
        let at = large
            .windows(4)
            .position(|w| w == [0, 1, 4, 0] || w == [0, 1, 3, 0])
            .unwrap();
        large[at + 8..at + 12].copy_from_slice(&60_000_000u32.to_le_bytes());
        assert!(read(&large).is_err());
    }
}
