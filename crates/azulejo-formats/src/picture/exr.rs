//! OpenEXR: lossless linear pictures.

use super::error::{PictureError, assert_whole, check_size, malformed};
use ::exr::prelude::*;
use azulejo_scene::Image as Picture;
use std::io::{self, Cursor};

/// Reads the first layer that has channels R, G and B as linear values, without colour
/// management. Alpha is ignored.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, without RGB, deep, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> std::result::Result<Picture, PictureError> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(malformed)?;
    for header in &meta.headers {
        let Vec2(width, height) = header.layer_size;
        check_size(width as u64, height as u64, bytes.len())?;
    }
    let image = ::exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| Picture::new(size.width() as u32, size.height() as u32),
            |picture, Vec2(x, y), (r, g, b): (f32, f32, f32)| {
                picture.pixels[y * picture.width as usize + x] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(malformed)?;
    Ok(image.layer_data.channel_data.pixels)
}

/// Writes a picture as 32-bit floats with lossless compression.
///
/// # Errors
/// Errors of `out`, and a picture without pixels.
///
/// # Panics
/// If the picture does not have `width × height` pixels.
pub fn write(image: &Picture, out: &mut dyn io::Write) -> io::Result<()> {
    assert_whole(image);
    let channels = SpecificChannels::rgb(|Vec2(x, y): Vec2<usize>| {
        let [r, g, b] = image.pixels[y * image.width as usize + x];
        (r, g, b)
    });
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (image.width as usize, image.height as usize);
    let layer = Layer::new(size, LayerAttributes::default(), encoding, channels);
    // The format's table of offsets is written last, which requires a seekable target.
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut file)
        .map_err(|e| match e {
            Error::Io(e) => e,
            other => io::Error::new(io::ErrorKind::InvalidInput, other.to_string()),
        })?;
    out.write_all(file.get_ref())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::error::tests::{damage, gradient};

    #[test]
    fn nothing_is_lost() {
        for (width, height) in [(1, 1), (7, 3), (64, 33)] {
            let image = gradient(width, height);
            let mut file = Vec::new();
            write(&image, &mut file).unwrap();
            assert_eq!(read(&file).unwrap(), image);
        }
        assert!(write(&Picture::new(0, 0), &mut Vec::new()).is_err());
    }

    #[test]
    fn damaged_files_are_refused_or_read() {
        let mut file = Vec::new();
        write(&gradient(16, 16), &mut file).unwrap();
        damage(&file, |bytes| read(bytes).is_ok());
    }
}
