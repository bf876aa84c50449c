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

/// Most pixels that one byte can encode: a block of 64 takes at least one bit for its mean, and in a
/// progressive picture next to nothing else. Twice that, for files that end early.
const MOST_PIXELS_PER_BYTE: u64 = 2 * 8 * 64;

/// Reads a JPEG as linear light.
///
/// Baseline or progressive; grey, YCbCr, RGB, CMYK and YCCK. Values are taken as sRGB, whatever
/// colour profile the file contains. If the data after the header is damaged, what could be
/// decoded is returned, as in browsers.
///
/// # Errors
/// [`PictureError`]: not a JPEG, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let (mut decoder, [width, height]) = start(bytes)?;
    check_size(width as u64, height as u64, bytes.len())?;
    if (width * height) as u64 > MOST_PIXELS_PER_BYTE * bytes.len() as u64 {
        return Err(malformed(format!(
            "{width} × {height} pixels in {} bytes, which no JPEG can hold",
            bytes.len()
        )));
    }
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
        alpha: None,
    })
}

/// Columns and rows, from the header alone.
pub(super) fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    let (_, size) = start(bytes)?;
    Ok(size.map(|n| n as u64))
}

type Decoder<'b> = JpegDecoder<ZCursor<&'b [u8]>>;

/// A decoder that has read the header, and the size of the picture.
fn start(bytes: &[u8]) -> Result<(Decoder<'_>, [usize; 2]), PictureError> {
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
    Ok((decoder, [width, height]))
}

#[cfg(test)]
pub(crate) mod tests {
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

    /// A picture of 16 × 8 pixels.
    pub(crate) fn grey() -> Vec<u8> {
        bytes(GREY)
    }

    fn check(hex: &str, left: [f32; 3], right: [f32; 3]) {
        let image = read(&bytes(hex)).unwrap();
        assert_eq!((image.width, image.height), (16, 8));
        for (x, expected) in [(0, left), (15, right)] {
            let pixel = image.pixel(x, 7);
            let near = (0..3).all(|k| (pixel[k] - expected[k]).abs() < 0.01);
            assert!(near, "{pixel:?} {expected:?}");
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
        // Headers that claim more pixels than the bytes can hold.
        let mut file = bytes(GREY);
        let size = file.windows(2).position(|w| w == [0xff, 0xc0]).unwrap() + 5;
        file[size..size + 4].copy_from_slice(&[2, 0, 2, 0]);
        let error = read(&file).unwrap_err().to_string();
        assert!(error.contains("which no JPEG can hold"), "{error}");
        file[size..size + 4].fill(0xff);
        assert!(matches!(read(&file), Err(PictureError::TooLarge { .. })));
    }

    /// A segment of metadata takes 64 KB at most; what it claims about all of them together reserves
    /// nothing.
    #[test]
    fn segments_reserve_nothing() {
        let (start, rest) = (bytes("ffd8"), &bytes(GREY)[2..]);
        let segment = |marker: u8, content: &[u8]| {
            let length = (content.len() as u16 + 2).to_be_bytes();
            [&[0xff, marker], &length[..], content].concat()
        };
        let mut xmp = b"http://ns.adobe.com/xmp/extension/\0".to_vec();
        xmp.extend([b'a'; 32]);
        // The declared size of the whole is 4 GB.
        xmp.extend([0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0, 1, 2, 3]);
        let icc = [b"ICC_PROFILE\0\x01\xff", &[0; 60_000][..]].concat();
        let photoshop = [b"Photoshop 3.0\0", &[0xff; 60_000][..]].concat();
        for (marker, content) in [(0xe1, xmp), (0xe2, icc), (0xed, photoshop)] {
            let file = [&start, &segment(marker, &content)[..], rest].concat();
            assert_eq!(read(&file).unwrap(), read(&bytes(GREY)).unwrap());
        }
    }
}
