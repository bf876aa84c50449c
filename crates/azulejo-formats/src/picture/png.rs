//! PNG: reads textures, writes finished pictures.

use super::error::{PictureError, check_size, malformed};
use super::srgb::{linear_from_srgb, linear_table, srgb_bytes, srgb_from_linear};
use azulejo_scene::Image;
use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Limits, Transformations};
use std::io::{self, Cursor, Write};

/// Reads a PNG as linear light.
///
/// Any depth and colour type. Values are taken as sRGB, whatever the file's own colour chunks
/// specify. Transparency is ignored. Of an animation, the first frame is read.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let limits = Limits {
        bytes: bytes.len().saturating_mul(1100).saturating_add(1 << 20),
    };
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
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
    let linear = linear_samples(&samples, frame.bit_depth);
    let channels = frame.color_type.samples();
    let grey = matches!(
        frame.color_type,
        ColorType::Grayscale | ColorType::GrayscaleAlpha
    );
    let pixel = |p: &[f32]| if grey { [p[0]; 3] } else { [p[0], p[1], p[2]] };
    Ok(Image {
        width,
        height,
        pixels: linear.chunks_exact(channels).map(pixel).collect(),
    })
}

/// Linear light of 8-bit samples, or of big-endian 16-bit samples.
fn linear_samples(samples: &[u8], depth: BitDepth) -> Vec<f32> {
    if depth == BitDepth::Sixteen {
        let (pairs, _) = samples.as_chunks::<2>();
        let share = |&pair: &[u8; 2]| f32::from(u16::from_be_bytes(pair)) / 65535.0;
        return pairs.iter().map(|p| linear_from_srgb(share(p))).collect();
    }
    let table = linear_table();
    samples.iter().map(|&v| table[usize::from(v)]).collect()
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
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    Ok(writer.finish()?)
}

/// Writes linear light as an sRGB PNG: with 8 bits if they represent it exactly, else with 16.
/// Values above 1 become white.
///
/// # Errors
/// Errors of `out`, and a picture without pixels.
pub fn write_linear(image: &Image, out: &mut dyn Write) -> io::Result<()> {
    let (bytes, table) = (srgb_bytes(image), linear_table());
    let values = image.pixels.iter().flatten();
    if bytes
        .iter()
        .zip(values.clone())
        .all(|(&b, v)| table[usize::from(b)] == *v)
    {
        return write(image.width, image.height, &bytes, out);
    }
    let word = |&v: &f32| (65535.0 * srgb_from_linear(v)).round().clamp(0.0, 65535.0) as u16;
    let words: Vec<u8> = values.flat_map(|v| word(v).to_be_bytes()).collect();
    let mut encoder = Encoder::new(out, image.width, image.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Sixteen);
    encoder.set_compression(Compression::Balanced);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&words)?;
    Ok(writer.finish()?)
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
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(ColorType::Indexed);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_palette(palette.concat());
    encoder.set_compression(Compression::High);
    // Filters predict a pixel from its neighbours, which means nothing for palette indices.
    encoder.set_filter(png::Filter::NoFilter);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(indices)?;
    Ok(writer.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::error::tests::damage;

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
        for (found, expected) in image.pixels.iter().zip(expected) {
            let near = (0..3).all(|k| (found[k] - expected[k]).abs() < 1e-6);
            assert!(near, "{found:?} {expected:?}");
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
