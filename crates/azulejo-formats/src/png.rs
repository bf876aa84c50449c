//! PNG: pictures on surfaces in, finished pictures out.

use crate::PictureError;
use crate::picture::{check_size, malformed};
use azulejo_scene::Image;
use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Limits, Transformations};
use std::io::{self, Cursor, Write};

/// Reads a PNG as linear light.
///
/// Any depth and colour type; values are taken as sRGB, whatever the file's own colour chunks
/// say. Transparency is ignored. Animations give their first picture.
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
    let linear = match frame.bit_depth {
        BitDepth::Sixteen => samples
            .as_chunks::<2>()
            .0
            .iter()
            .map(|&pair| linear_from_srgb(f32::from(u16::from_be_bytes(pair)) / 65535.0))
            .collect(),
        _ => {
            let table: Vec<f32> = (0..=255u8)
                .map(|v| linear_from_srgb(f32::from(v) / 255.0))
                .collect();
            samples
                .iter()
                .map(|&v| table[usize::from(v)])
                .collect::<Vec<f32>>()
        }
    };
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

/// Linear light of an sRGB value, both 0..=1. IEC 61966-2-1.
fn linear_from_srgb(v: f32) -> f32 {
    if v <= 0.04045 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

/// Writes finished pixels as PNG: `rgb` holds three sRGB bytes per pixel, rows from the top.
///
/// # Errors
/// What `out` says, and a picture without pixels.
///
/// # Panics
/// If `rgb` has not `3 × width × height` bytes.
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
