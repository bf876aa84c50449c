//! PNG: reads textures, writes finished pictures.

use super::error::{PictureError, check_size, malformed};
use super::samples::{from_samples, from_srgb_bytes};
use super::srgb::{linear_from_srgb, linear_table, srgb_bytes, srgb_from_linear};
use azulejo_scene::Image;
use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Limits, Transformations};
use std::io::{self, Cursor, Write};

/// Most memory of the decoder for everything but the pixels, which have their own limit: a row of the
/// widest picture that is read has 2²⁷ pixels of 8 bytes, and metadata that is kept (Exif) comes
/// uncompressed.
const LIMITS: Limits = Limits { bytes: 9 << 27 };

/// Reads a PNG as linear light.
///
/// Any depth and colour type. Values are taken as sRGB, whatever the file's own colour chunks
/// specify. Of an animation, the first frame is read.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let mut decoder = decoder(bytes);
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(malformed)?;
    let (width, height) = reader.info().size();
    check_size(width.into(), height.into(), bytes.len())?;
    let size = reader.output_buffer_size().ok_or(PictureError::TooLarge {
        width: width.into(),
        height: height.into(),
    })?;
    let mut samples = vec![0; size];
    let frame = reader.next_frame(&mut samples).map_err(malformed)?;
    samples.truncate(frame.buffer_size());
    let channels = frame.color_type.samples();
    let size = [width, height];
    if frame.bit_depth == BitDepth::Sixteen {
        let share = |i: usize| {
            f32::from(u16::from_be_bytes([samples[2 * i], samples[2 * i + 1]])) / 65535.0
        };
        let linear = |i: usize| linear_from_srgb(share(i));
        return from_samples(size, channels, samples.len() / 2, linear, share);
    }
    from_srgb_bytes(size, channels, &samples)
}

/// Columns and rows, from the header alone.
pub(super) fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    let mut decoder = decoder(bytes);
    let header = decoder.read_header_info().map_err(malformed)?;
    Ok([header.width.into(), header.height.into()])
}

/// A decoder that keeps nothing but what is used.
fn decoder(bytes: &[u8]) -> Decoder<Cursor<&[u8]>> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), LIMITS);
    // A colour profile is decompressed as soon as it is met.
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_ignore_text_chunk(true);
    decoder
}

/// Writes finished pixels as PNG: `rgb` holds three sRGB bytes per pixel, rows from the top.
///
/// # Errors
/// Errors of `out`, and a picture without pixels.
///
/// # Panics
/// If `rgb` does not have `3 × width × height` bytes.
pub fn write(width: u32, height: u32, rgb: &[u8], out: &mut dyn Write) -> io::Result<()> {
    assert_eq!(
        rgb.len(),
        3 * width as usize * height as usize,
        "three bytes per pixel"
    );
    write_samples(encoder([width, height], ColorType::Rgb, out), rgb)
}

/// Writes numbers that are no colours: three bytes per pixel, rows from the top.
///
/// # Errors
/// Errors of `out`, and a picture without pixels.
///
/// # Panics
/// If `numbers` does not have `3 × width × height` bytes.
pub fn write_data(width: u32, height: u32, numbers: &[u8], out: &mut dyn Write) -> io::Result<()> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    write_samples(encoder, numbers)
}

/// An encoder of sRGB samples of 8 bits.
fn encoder<'a>(
    [width, height]: [u32; 2],
    color: ColorType,
    out: &'a mut dyn Write,
) -> Encoder<'a, &'a mut dyn Write> {
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder
}

fn write_samples(encoder: Encoder<&mut dyn Write>, samples: &[u8]) -> io::Result<()> {
    let mut writer = encoder.write_header()?;
    writer.write_image_data(samples)?;
    Ok(writer.finish()?)
}

/// Writes linear light as an sRGB PNG, with its alpha channel: with 8 bits if they represent it exactly,
/// else with 16. Values above 1 become white.
///
/// # Errors
/// Errors of `out`, and a picture without pixels.
pub fn write_linear(image: &Image, out: &mut dyn Write) -> io::Result<()> {
    let (bytes, table) = (srgb_bytes(image), linear_table());
    let values = image.pixels.iter().flatten();
    let is_exact = (bytes.iter().zip(values)).all(|(&b, v)| table[usize::from(b)] == *v);
    let alphas: Vec<u8> = image.alpha.iter().flatten().map(|&a| byte_of(a)).collect();
    let is_exact = is_exact
        && (alphas.iter().zip(image.alpha.iter().flatten()))
            .all(|(&b, &a)| f32::from(b) / 255.0 == a);
    if is_exact && image.alpha.is_none() {
        return write(image.width, image.height, &bytes, out);
    }
    let word = |v: f32| ((65535.0 * v).round().clamp(0.0, 65535.0) as u16).to_be_bytes();
    let mut samples = Vec::new();
    for (k, pixel) in image.pixels.iter().enumerate() {
        if is_exact {
            samples.extend(&bytes[3 * k..3 * k + 3]);
            samples.extend(alphas.get(k));
        } else {
            samples.extend(pixel.iter().flat_map(|&v| word(srgb_from_linear(v))));
            let alpha = image.alpha.as_ref().map(|list| word(list[k]));
            samples.extend(alpha.into_iter().flatten());
        }
    }
    let color = match image.alpha {
        Some(_) => ColorType::Rgba,
        None => ColorType::Rgb,
    };
    let mut encoder = encoder([image.width, image.height], color, out);
    if !is_exact {
        encoder.set_depth(BitDepth::Sixteen);
    }
    write_samples(encoder, &samples)
}

/// The byte of a number in 0..=1.
fn byte_of(value: f32) -> u8 {
    (255.0 * value).round().clamp(0.0, 255.0) as u8
}

/// Writes a picture of at most 256 colours as PNG: `indices` holds an index into `palette` for each
/// pixel, rows from the top; colours are sRGB.
///
/// # Errors
/// Errors of `out`, and a picture without pixels.
///
/// # Panics
/// If `indices` does not have `width × height` bytes.
pub fn write_indexed(
    width: u32,
    height: u32,
    palette: &[[u8; 3]],
    indices: &[u8],
    out: &mut dyn Write,
) -> io::Result<()> {
    assert_eq!(
        indices.len(),
        width as usize * height as usize,
        "one byte per pixel"
    );
    let mut encoder = encoder([width, height], ColorType::Indexed, out);
    encoder.set_palette(palette.concat());
    encoder.set_compression(Compression::High);
    // Filters predict a pixel from its neighbours, which means nothing for palette indices.
    encoder.set_filter(png::Filter::NoFilter);
    write_samples(encoder, indices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::error::tests::damage;
    use flate2::write::ZlibEncoder;

    fn encoded(color: ColorType, depth: BitDepth, palette: &[u8], data: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = Encoder::new(&mut file, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if !palette.is_empty() {
            encoder.set_palette(palette.to_vec());
        }
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(data).unwrap();
        writer.finish().unwrap();
        file
    }

    #[test]
    fn few_colours_are_written_as_such() {
        let mut file = Vec::new();
        write_indexed(2, 1, &[[255, 0, 0], [255; 3]], &[1, 0], &mut file).unwrap();
        check(&file, [[1.0; 3], [1.0, 0.0, 0.0]]);
    }

    fn check(file: &[u8], expected: [[f32; 3]; 2]) {
        let image = read(file).unwrap();
        assert_eq!((image.width, image.height), (2, 1));
        for (pixel, expected) in image.pixels.iter().zip(expected) {
            let near = (0..3).all(|k| (pixel[k] - expected[k]).abs() < 1e-6);
            assert!(near, "{pixel:?} {expected:?}");
        }
    }

    #[test]
    fn every_kind_of_pixel_becomes_linear_rgb() {
        // 188 of 255 is half the light: ((188/255 + 0.055) / 1.055)^2.4.
        let half = 0.502_886_5;
        let (black, white) = ([0.0; 3], [1.0; 3]);
        let eight = BitDepth::Eight;
        check(
            &encoded(ColorType::Grayscale, eight, &[], &[188, 255]),
            [[half; 3], white],
        );
        check(
            &encoded(ColorType::GrayscaleAlpha, eight, &[], &[188, 9, 255, 9]),
            [[half; 3], white],
        );
        check(
            &encoded(ColorType::Rgb, eight, &[], &[188, 0, 255, 0, 0, 0]),
            [[half, 0.0, 1.0], black],
        );
        check(
            &encoded(ColorType::Rgba, eight, &[], &[188, 0, 255, 0, 0, 0, 0, 9]),
            [[half, 0.0, 1.0], black],
        );
        check(
            &encoded(ColorType::Grayscale, BitDepth::One, &[], &[0b0100_0000]),
            [black, white],
        );
        check(
            &encoded(
                ColorType::Indexed,
                BitDepth::One,
                &[188, 188, 188, 0, 255, 0],
                &[0b0100_0000],
            ),
            [[half; 3], [0.0, 1.0, 0.0]],
        );
        check(
            &encoded(
                ColorType::Grayscale,
                BitDepth::Sixteen,
                &[],
                &[188, 188, 0xff, 0xff],
            ),
            [[half; 3], white],
        );
    }

    #[test]
    fn written_pixels_come_back() {
        let mut file = Vec::new();
        write(2, 1, &[188, 0, 255, 0, 0, 0], &mut file).unwrap();
        check(&file, [[0.502_886_5, 0.0, 1.0], [0.0; 3]]);
        assert!(write(0, 0, &[], &mut Vec::new()).is_err());
    }

    #[test]
    fn alpha_channels_come_back() {
        let table = linear_table();
        for (v, a) in [(table[188], 51.0 / 255.0), (0.123, 0.3)] {
            let image = Image::opaque(2, 1, vec![[v, 0.0, 1.0]; 2]).with_alpha(vec![a, 1.0]);
            let mut file = Vec::new();
            write_linear(&image, &mut file).unwrap();
            let back = read(&file).unwrap();
            let alpha = back.alpha.unwrap();
            assert!((alpha[0] - a).abs() < 1e-5 && alpha[1] == 1.0);
            assert!((back.pixels[0][0] - v).abs() < 1e-5);
        }
    }

    /// Profiles and texts that decompress to a thousand times their size, and metadata that is longer
    /// than the picture.
    #[test]
    fn chunks_beside_the_pixels_take_no_memory() {
        let mut file = Vec::new();
        write(2, 1, &[188, 0, 255, 0, 0, 0], &mut file).unwrap();
        let mut packer = ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        for _ in 0..1 << 8 {
            packer.write_all(&[0; 1 << 16]).unwrap();
        }
        let packed = packer.finish().unwrap();
        // After the header, which has 25 bytes after the 8 of the signature.
        let with = |kind: &[u8; 4], start: &[u8]| {
            let content = [kind, start, &packed].concat();
            let mut sum = flate2::Crc::new();
            sum.update(&content);
            let length = (content.len() as u32 - 4).to_be_bytes();
            let chunk = [&length, &content[..], &sum.sum().to_be_bytes()].concat();
            [&file[..33], &chunk, &file[33..]].concat()
        };
        for (kind, start) in [
            (b"iCCP", &b"x\0\0"[..]),
            (b"zTXt", b"x\0\0"),
            (b"iTXt", b"x\0\x01\0\0\0"),
            (b"tEXt", b"x\0"),
            (b"eXIf", b""),
            (b"ruIn", b""),
        ] {
            let bytes = with(kind, start);
            check(&bytes, [[0.502_886_5, 0.0, 1.0], [0.0; 3]]);
            // The profile must not even be looked at, or it is kept in memory.
            let mut reader = decoder(&bytes).read_info().unwrap();
            reader.finish().unwrap();
            let info = reader.info();
            assert!(info.icc_profile.is_none() && info.compressed_latin1_text.is_empty());
            assert!(info.utf8_text.is_empty() && info.uncompressed_latin1_text.is_empty());
        }
    }

    #[test]
    fn damaged_files_are_refused_or_read() {
        let mut file = Vec::new();
        let pixels: Vec<u8> = (0..16 * 16 * 3).map(|i| (i * 7) as u8).collect();
        write(16, 16, &pixels, &mut file).unwrap();
        damage(&file, |bytes| read(bytes).is_ok());
        // A header that claims more pixels than the bytes can hold.
        file[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
        assert!(read(&file).is_err());
    }
}
