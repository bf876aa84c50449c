//! Writes KTX2: pictures of bright light, as graphics cards read them.
//!
//! Khronos, *KTX File Format Specification*, version 2.0; *Data Format Specification*, version 1.3; the encoder of
//! shared exponents is that of OpenGL's `EXT_texture_shared_exponent`.

use super::error::assert_whole;
use super::ktx2::START;
use ::exr::prelude::f16;
use azulejo_scene::Image;
use std::io::{self, Write};

/// How the texels of a written file are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ktx2Texels {
    /// `VK_FORMAT_E5B9G9R9_UFLOAT_PACK32`: 4 bytes, the largest channel exact to 0.2%, from 2⁻²⁴ to 65408.
    SharedExponent,
    /// `VK_FORMAT_R16G16B16A16_SFLOAT`: 8 bytes, every channel exact to 0.05%, from 6e-8 to 65504.
    Half,
}

/// Bytes of the header and the index of its parts.
const HEADER: usize = 80;

/// Bytes of a level in the index of levels.
const LEVEL: usize = 24;

/// Largest number with a shared exponent.
const MOST_SHARED: f32 = 65408.0;

/// Linear light as it is, with the primaries of sRGB (`KHR_DF_PRIMARIES_BT709`, `KHR_DF_TRANSFER_LINEAR`) as red,
/// green, blue and alpha (`KHR_DF_MODEL_RGBSDA`).
const LINEAR_RGB: u32 = 1 | 1 << 8 | 1 << 16;

/// One number of a texel, for the data format descriptor.
struct TexelSample {
    bit_offset: u32,
    bits: u32,
    /// The channel, and what its bits mean.
    channel: u32,
    lower: u32,
    upper: u32,
}

/// An exponent of the channel (`KHR_DF_SAMPLE_DATATYPE_EXPONENT`).
const EXPONENT: u32 = 0x20;

/// A floating-point number with a sign (`..._SIGNED`, `..._FLOAT`).
const SIGNED_FLOAT: u32 = 0xc0;

/// The channel of opacity.
const ALPHA: u32 = 15;

/// Writes a picture of linear light in `levels` sizes, each half as wide and high as the one before, as far as there
/// are any. Its first row is the upper one. Negative values and NaN become 0, and what is too bright the
/// brightest value; opacity is left out.
///
/// # Errors
/// Errors of `out`.
///
/// # Panics
/// If the picture does not have `width × height` pixels.
pub fn write(
    image: &Image,
    texels: Ktx2Texels,
    levels: u32,
    out: &mut dyn Write,
) -> io::Result<()> {
    assert_whole(image);
    let mut images = vec![image.clone()];
    while (images.len() as u32) < levels.max(1) {
        match images.last().and_then(halved) {
            Some(next) => images.push(next),
            None => break,
        }
    }
    let data = images.iter().map(|level| texels.bytes(level)).collect();
    write_levels([image.width, image.height, 0], "rd", texels, data, out)
}

/// Writes a volume of linear light, whose layers are pictures of equal size, as [`write()`] does, in one size.
///
/// # Errors
/// Errors of `out`.
///
/// # Panics
/// If a picture does not have `width × height` pixels, or the size of another.
pub fn write_volume(layers: &[Image], texels: Ktx2Texels, out: &mut dyn Write) -> io::Result<()> {
    let size = layers.first().map_or([0, 0], |l| [l.width, l.height]);
    let mut data = Vec::new();
    for layer in layers {
        assert_whole(layer);
        assert_eq!([layer.width, layer.height], size, "layers of one size");
        data.extend(texels.bytes(layer));
    }
    let size = [size[0], size[1], layers.len() as u32];
    write_levels(size, "rdi", texels, vec![data], out)
}

/// Writes a file of these levels; a depth of 0 is that of a picture.
fn write_levels(
    [width, height, depth]: [u32; 3],
    orientation: &str,
    texels: Ktx2Texels,
    data: Vec<Vec<u8>>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let descriptor = texels.descriptor();
    let words = key_values(&[("KTXorientation", orientation), ("KTXwriter", "azulejo")]);
    let described = HEADER + LEVEL * data.len();
    let named = described + descriptor.len();
    let first = (named + words.len()).next_multiple_of(texels.size());
    let mut file = START.to_vec();
    let count = data.len() as u32;
    // No layers, one face, no compression around the texels.
    let fields = [
        texels.format(),
        texels.type_size(),
        width,
        height,
        depth,
        0,
        1,
        count,
        0,
    ];
    let places = [described, descriptor.len(), named, words.len()];
    let fields = fields.into_iter().chain(places.map(|n| n as u32));
    file.extend(fields.flat_map(u32::to_le_bytes));
    // Nothing that all levels share.
    file.extend([0; 16]);
    // The smallest level comes first.
    let after: Vec<usize> = (0..data.len())
        .map(|level| data[level + 1..].iter().map(Vec::len).sum())
        .collect();
    for (level, bytes) in data.iter().enumerate() {
        let start = (first + after[level]) as u64;
        let entry = [start, bytes.len() as u64, bytes.len() as u64];
        file.extend(entry.into_iter().flat_map(u64::to_le_bytes));
    }
    file.extend(descriptor);
    file.extend(words);
    file.resize(first, 0);
    out.write_all(&file)?;
    data.iter().rev().try_for_each(|bytes| out.write_all(bytes))
}

impl Ktx2Texels {
    /// The number in `VkFormat`.
    fn format(self) -> u32 {
        match self {
            Ktx2Texels::SharedExponent => 123,
            Ktx2Texels::Half => 97,
        }
    }

    /// Bytes of the numbers whose order depends on the machine.
    fn type_size(self) -> u32 {
        match self {
            Ktx2Texels::SharedExponent => 4,
            Ktx2Texels::Half => 2,
        }
    }

    /// Bytes of a texel, of which offsets of levels are multiples.
    fn size(self) -> usize {
        match self {
            Ktx2Texels::SharedExponent => 4,
            Ktx2Texels::Half => 8,
        }
    }

    fn bytes(self, image: &Image) -> Vec<u8> {
        let pixels = image.pixels.iter();
        match self {
            Ktx2Texels::SharedExponent => pixels
                .flat_map(|p| shared_exponent(*p).to_le_bytes())
                .collect(),
            Ktx2Texels::Half => {
                let all = pixels.flat_map(|&[r, g, b]| [r, g, b, 1.0]);
                all.flat_map(|v| half(v).to_le_bytes()).collect()
            }
        }
    }

    /// The numbers of a texel.
    fn samples(self) -> Vec<TexelSample> {
        match self {
            Ktx2Texels::SharedExponent => (0..3)
                .flat_map(|channel| {
                    [
                        TexelSample {
                            bit_offset: 9 * channel,
                            bits: 9,
                            channel,
                            lower: 0,
                            // The mantissa of the largest exponent that is 1.0 with the bias of the other.
                            upper: 8448,
                        },
                        TexelSample {
                            bit_offset: 27,
                            bits: 5,
                            channel: channel | EXPONENT,
                            lower: 15,
                            upper: 31,
                        },
                    ]
                })
                .collect(),
            Ktx2Texels::Half => [0, 1, 2, ALPHA]
                .into_iter()
                .zip(0..)
                .map(|(channel, place)| TexelSample {
                    bit_offset: 16 * place,
                    bits: 16,
                    channel: channel | SIGNED_FLOAT,
                    lower: (-1f32).to_bits(),
                    upper: 1f32.to_bits(),
                })
                .collect(),
        }
    }

    /// The data format descriptor: one basic block of version 2 (of the specification 1.3).
    fn descriptor(self) -> Vec<u8> {
        let samples = self.samples();
        let block = 24 + 16 * samples.len() as u32;
        let mut words = vec![
            4 + block,
            // Khronos, basic format.
            0,
            2 | block << 16,
            LINEAR_RGB,
            // Blocks of one texel, in one plane.
            0,
            self.size() as u32,
            0,
        ];
        for sample in samples {
            let place = sample.bit_offset | (sample.bits - 1) << 16 | sample.channel << 24;
            words.extend([place, 0, sample.lower, sample.upper]);
        }
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }
}

/// Entries of names and texts, in the order of the names.
fn key_values(entries: &[(&str, &str)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (key, value) in entries {
        let entry = format!("{key}\0{value}\0");
        bytes.extend((entry.len() as u32).to_le_bytes());
        bytes.extend(entry.as_bytes());
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

/// Half precision, 0..=65504.
fn half(value: f32) -> u16 {
    f16::from_f32(positive(value, f16::MAX.to_f32())).to_bits()
}

/// 0 up to a value; 0 for what is not a number.
fn positive(value: f32, most: f32) -> f32 {
    // NaN is not above 0 either.
    if value > 0.0 { value.min(most) } else { 0.0 }
}

/// Three mantissas of nine bits, red in the lowest, and the exponent of the largest, in the highest five.
fn shared_exponent(pixel: [f32; 3]) -> u32 {
    let pixel = pixel.map(|v| positive(v, MOST_SHARED));
    let largest = pixel[0].max(pixel[1]).max(pixel[2]);
    // The largest is m 2^e with m in 0.5..1, or smaller where the exponent ends.
    let exponent = (largest.to_bits() >> 23) as i32 - 126;
    let mut exponent = exponent.max(-15);
    let mantissa = |v: f32, exponent: i32| (v * 2f32.powi(9 - exponent) + 0.5).floor() as u32;
    if mantissa(largest, exponent) == 1 << 9 {
        exponent += 1;
    }
    let [r, g, b] = pixel.map(|v| mantissa(v, exponent));
    r | g << 9 | b << 18 | ((exponent + 15) as u32) << 27
}

/// The means of a picture with half as many columns and rows; `None` if it has one of both.
fn halved(image: &Image) -> Option<Image> {
    let (width, height) = (image.width.max(1), image.height.max(1));
    if width == 1 && height == 1 {
        return None;
    }
    let mut half = Image::new((width / 2).max(1), (height / 2).max(1));
    let range = |k: u32, old: u32, new: u32| {
        let [k, old, new] = [k, old, new].map(u64::from);
        (k * old / new) as u32..((k + 1) * old).div_ceil(new) as u32
    };
    for y in 0..half.height {
        for x in 0..half.width {
            let (rows, columns) = (range(y, height, half.height), range(x, width, half.width));
            let share = 1.0 / (rows.len() * columns.len()) as f32;
            let mut sum = [0.0; 3];
            for (row, column) in rows.flat_map(|row| columns.clone().map(move |c| (row, c))) {
                let pixel = image.pixel(column, row);
                sum = [0, 1, 2].map(|k| sum[k] + share * pixel[k]);
            }
            half.pixels[(y * half.width + x) as usize] = sum;
        }
    }
    Some(half)
}

#[cfg(test)]
mod tests {
    use super::super::ktx2::read;
    use super::*;
    use crate::picture::error::tests::damage;

    fn written(image: &Image, texels: Ktx2Texels, levels: u32) -> Vec<u8> {
        let mut file = Vec::new();
        write(image, texels, levels, &mut file).unwrap();
        file
    }

    /// Values over many magnitudes.
    fn gradient() -> Image {
        let value = |k: i32| 1.37f32.powi(k % 50 - 40) * 1000.0;
        let pixels = (0..35).map(|k| [value(k), value(k + 1), 0.6 * value(k)]);
        Image::opaque(7, 5, pixels.collect())
    }

    #[test]
    fn light_comes_back_within_half_steps() {
        let image = gradient();
        for (texels, step) in [
            (Ktx2Texels::SharedExponent, 1.0 / 512.0),
            (Ktx2Texels::Half, 1.0 / 2048.0),
        ] {
            let back = read(&written(&image, texels, 1)).unwrap();
            assert_eq!([back.width, back.height], [7, 5]);
            for (pixel, given) in back.pixels.iter().zip(&image.pixels) {
                let most = given[0].max(given[1]).max(given[2]);
                for k in 0..3 {
                    let scale = if texels == Ktx2Texels::Half {
                        given[k]
                    } else {
                        most
                    };
                    let off = (pixel[k] - given[k]).abs();
                    assert!(off <= step * scale + 6e-8, "{pixel:?}, {given:?}");
                }
            }
        }
    }

    /// The ends of the range, and values that are none; 1 has the exponent 16 and the mantissa 256.
    #[test]
    fn shared_exponents() {
        assert_eq!(shared_exponent([0.0; 3]), 0);
        assert_eq!(shared_exponent([-1.0, f32::NAN, -0.0]), 0);
        assert_eq!(
            shared_exponent([1.0, 0.5, 0.25]),
            16 << 27 | 64 << 18 | 128 << 9 | 256
        );
        assert_eq!(shared_exponent([f32::INFINITY, 0.0, 0.0]), 31 << 27 | 511);
        assert_eq!(
            shared_exponent([MOST_SHARED; 3]),
            31 << 27 | 511 << 18 | 511 << 9 | 511
        );
        // The smallest, and half of it.
        assert_eq!(
            shared_exponent([2f32.powi(-24), 2f32.powi(-25), 2f32.powi(-26)]),
            1 << 9 | 1
        );
        // Rounded up to the next exponent.
        assert_eq!(shared_exponent([0.9999, 0.0, 0.0]), 16 << 27 | 256);
        assert_eq!(half(1e9), 0x7bff);
        assert_eq!(half(1.0), 0x3c00);
    }

    /// The bytes of a file of one black texel, field by field, as the specification orders them.
    #[test]
    fn the_file_is_as_specified() {
        let file = written(&Image::new(1, 1), Ktx2Texels::SharedExponent, 1);
        assert_eq!(
            file[..12],
            [
                0xab, 0x4b, 0x54, 0x58, 0x20, 0x32, 0x30, 0xbb, 0x0d, 0x0a, 0x1a, 0x0a
            ]
        );
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        let header: Vec<u32> = (12..48).step_by(4).map(word).collect();
        // vkFormat, typeSize, width, height, depth, layers, faces, levels, supercompression.
        assert_eq!(header, [123, 4, 1, 1, 0, 0, 1, 1, 0]);
        let words = 4 + 18 + 2 + 4 + 18 + 2;
        assert_eq!([word(48), word(52)], [104, 124], "the descriptor");
        assert_eq!([word(56), word(60)], [228, words], "names and texts");
        assert_eq!(file[64..80], [0; 16]);
        let start = 228 + words;
        let level: Vec<u32> = (80..104).step_by(4).map(word).collect();
        assert_eq!(level, [start, 0, 4, 0, 4, 0]);
        assert_eq!(file.len(), start as usize + 4);
        let descriptor: Vec<u32> = (104..228).step_by(4).map(word).collect();
        assert_eq!(
            descriptor[..7],
            [124, 0, 2 | 120 << 16, 0x0001_0101, 0, 4, 0]
        );
        let samples: Vec<&[u32]> = descriptor[7..].chunks(4).collect();
        assert_eq!(samples[0], [8 << 16, 0, 0, 8448]);
        assert_eq!(samples[1], [27 | 4 << 16 | 0x20 << 24, 0, 15, 31]);
        assert_eq!(samples[4], [18 | 8 << 16 | 2 << 24, 0, 0, 8448]);
        assert_eq!(samples[5], [27 | 4 << 16 | 0x22 << 24, 0, 15, 31]);
        assert_eq!(&file[232..250], b"KTXorientation\0rd\0");
        assert_eq!(&file[256..274], b"KTXwriter\0azulejo\0");
        let half = written(&Image::new(1, 1), Ktx2Texels::Half, 1);
        assert_eq!(half[104..108], 92u32.to_le_bytes());
        assert_eq!(half[104 + 28 + 3..][..1], [0xc0]);
        assert_eq!(half[104 + 28 + 48 + 3..][..1], [0xcf]);
        assert_eq!(half.len() % 8, 0);
    }

    /// Each level has the mean of the one before, and the smallest comes first.
    #[test]
    fn levels() {
        let pixels = (0..6).map(|k| [k as f32, 1.0, 0.0]).collect();
        let image = Image::opaque(3, 2, pixels);
        let file = written(&image, Ktx2Texels::SharedExponent, 9);
        let long = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
        assert_eq!(file[40..44], 2u32.to_le_bytes());
        let ([large, small], [of_large, of_small]) = ([long(80), long(104)], [long(88), long(112)]);
        assert_eq!([of_large, of_small], [24, 4]);
        assert_eq!([small + 4, large + 24], [large, file.len()]);
        assert_eq!(small % 4, 0);
        let texel = u32::from_le_bytes(file[small..small + 4].try_into().unwrap());
        assert_eq!(texel, shared_exponent([2.5, 1.0, 0.0]));
        assert_eq!(read(&file).unwrap().pixels, image.pixels);
        assert_eq!(halved(&Image::new(1, 1)), None);
    }

    /// Layers follow each other, and the file says how many there are.
    #[test]
    fn volumes() {
        let layer = |value: f32| Image::opaque(2, 1, vec![[value; 3], [2.0 * value; 3]]);
        let mut file = Vec::new();
        write_volume(
            &[layer(1.0), layer(4.0), layer(16.0)],
            Ktx2Texels::Half,
            &mut file,
        )
        .unwrap();
        let header: Vec<u8> = [2u32, 1, 3]
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .collect();
        assert_eq!(file[20..32], header);
        let half = |at: usize| u16::from_le_bytes(file[at..at + 2].try_into().unwrap());
        let start = file.len() - 6 * 8;
        let red: Vec<u16> = (0..6).map(|texel| half(start + 8 * texel)).collect();
        let expected = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0].map(|v| f16::from_f32(v).to_bits());
        assert_eq!(red, expected);
        // The first layer is the picture that readers of pictures see.
        assert_eq!(read(&file).unwrap().pixels, layer(1.0).pixels);
    }

    #[test]
    fn damaged_files_are_refused_or_read() {
        for texels in [Ktx2Texels::SharedExponent, Ktx2Texels::Half] {
            let file = written(&gradient(), texels, 3);
            damage(&file, |bytes| read(bytes).is_ok());
        }
    }
}
