//! JPEG: reads textures.

use super::error::{PictureError, check_size, malformed};
use super::srgb::linear_table;
use azulejo_scene::Image;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Limit on the passes of a progressive picture: no encoder writes more, and each takes time.
const MOST_SCANS: usize = 64;

/// Reads a JPEG as linear light.
///
/// Baseline or progressive; grey, YCbCr, RGB, CMYK and YCCK. Values are taken as sRGB, whatever
/// colour profile the file contains. If the data after the header is damaged, what could be
/// decoded is returned, as in browsers.
///
/// # Errors
/// [`PictureError`]: not a JPEG, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGB)
        .jpeg_set_max_scans(MOST_SCANS)
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX));
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(malformed)?;
    let (width, height) = decoder
        .dimensions()
        .ok_or_else(|| malformed("a JPEG without a size"))?;
    check_size(width as u64, height as u64, bytes.len())?;
    let samples = decoder.decode().map_err(malformed)?;
    let (pixels, _) = samples.as_chunks::<3>();
    if pixels.len() != width * height {
        return Err(malformed("a JPEG with neither one nor three channels"));
    }
    let linear = linear_table();
    Ok(Image {
        width: width as u32,
        height: height as u32,
        pixels: pixels
            .iter()
            .map(|p| p.map(|v| linear[usize::from(v)]))
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::error::tests::damage;

    /// 16 × 8 pixels: the left half black, the right half sRGB 188.
    const GREY: &str = "ffd8ffe000104a46494600010100000100010000ffdb0043000302020302020303030304030304050805050404 \
        050a070706080c0a0c0c0b0a0b0b0d0e12100d0e110e0b0b1016101113141515150c0f171816141812141514ff \
        c0000b080008001001011100ffc40014000100000000000000000000000000000009ffc4001410010000000000 \
        0000000000000000000000ffda0008010100003f002a8fabffd9";

    /// 16 × 8 pixels in five passes: the left half red, the right half white.
    const PROGRESSIVE: &str = "ffd8ffe000104a46494600010100000100010000ffdb0043000302020302020303030304030304050805050404 \
        050a070706080c0a0c0c0b0a0b0b0d0e12100d0e110e0b0b1016101113141515150c0f171816141812141514ff \
        db00430103040405040509050509140d0b0d141414141414141414141414141414141414141414141414141414 \
        1414141414141414141414141414141414141414141414ffc20011080008001003011100021101031101ffc400 \
        1500010100000000000000000000000000000708ffc4001501010100000000000000000000000000000608ffda \
        000c03010002100310000001390b54ddeea56fffc40014100100000000000000000000000000000010ffda0008 \
        0101000105023fffc40014110100000000000000000000000000000010ffda0008010301013f013fffc4001411 \
        0100000000000000000000000000000010ffda0008010201013f013fffc4001410010000000000000000000000 \
        0000000010ffda0008010100063f023fffc40014100100000000000000000000000000000010ffda0008010100 \
        013f213fffda000c03010002000300000010f3ffc40014110100000000000000000000000000000010ffda0008 \
        010301013f103fffc40014110100000000000000000000000000000010ffda0008010201013f103fffc4001410 \
        0100000000000000000000000000000010ffda0008010100013f103fffd9";

    fn bytes(hex: &str) -> Vec<u8> {
        let digits: Vec<u8> = hex.bytes().filter(u8::is_ascii_hexdigit).collect();
        let value = |d: u8| char::from(d).to_digit(16).unwrap() as u8;
        let (pairs, _) = digits.as_chunks::<2>();
        pairs
            .iter()
            .map(|&[h, l]| value(h) << 4 | value(l))
            .collect()
    }

    fn check(hex: &str, left: [f32; 3], right: [f32; 3]) {
        let image = read(&bytes(hex)).unwrap();
        assert_eq!((image.width, image.height), (16, 8));
        for (x, expected) in [(0, left), (15, right)] {
            let found = image.pixel(x, 7);
            let near = (0..3).all(|k| (found[k] - expected[k]).abs() < 0.01);
            assert!(near, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn values_are_taken_as_srgb() {
        // 188 of 255 is half the light: ((188/255 + 0.055) / 1.055)^2.4.
        check(GREY, [0.0; 3], [0.502_886_5; 3]);
        check(PROGRESSIVE, [1.0, 0.0, 0.0], [1.0; 3]);
    }

    #[test]
    fn damaged_files_are_refused_or_read() {
        for hex in [GREY, PROGRESSIVE] {
            // After its header a JPEG may end anywhere and still be a picture.
            let file = bytes(hex);
            assert!(read(&file[..100]).is_err());
            damage(&file, |bytes| {
                bytes.len() == file.len() && read(bytes).is_ok()
            });
        }
        // A header that claims more pixels than the bytes can hold.
        let mut file = bytes(GREY);
        let size = file.windows(2).position(|w| w == [0xff, 0xc0]).unwrap() + 5;
        file[size..size + 4].fill(0xff);
        assert!(matches!(read(&file), Err(PictureError::TooLarge { .. })));
    }
}
