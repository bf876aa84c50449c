//! RTRACE's images: PIC, which has no magic number, and PPM; and colour maps.

use crate::picture;
use crate::reading::words::Words;
use azulejo_scene::{Image, Rgb};

/// Decodes an image as RTRACE reads it: bytes divided by 255, without gamma. Other formats known to
/// azulejo are decoded as they specify.
pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let image = match bytes {
        [b'P', b'6', ..] => ppm(bytes)?,
        _ => match pic(bytes) {
            Some(image) => image,
            None => picture::decode(bytes).map_err(|_| UNKNOWN.to_owned())?,
        },
    };
    if image.width < 2 || image.height < 2 {
        return Err("the image has a single row or column, at least two are required".into());
    }
    Ok(image)
}

const UNKNOWN: &str = "it is neither PIC, PPM nor a picture of another known format";

/// PIC: four bytes with width and height, and three for each pixel.
fn pic(bytes: &[u8]) -> Option<Image> {
    let (head, pixels) = bytes.split_first_chunk::<4>()?;
    let width = u32::from(u16::from_le_bytes([head[0], head[1]]));
    let height = u32::from(u16::from_le_bytes([head[2], head[3]]));
    image(width, height, pixels).filter(|_| pixels.len() as u64 == 3 * u64::from(width * height))
}

fn ppm(bytes: &[u8]) -> Result<Image, String> {
    let mut words = Words::new(bytes, "").from(2);
    let mut header = [0; 3];
    for value in &mut header {
        words.skip_blanks();
        while words.peek() == Some(b'#') {
            words.rest_of_line();
            words.skip_blanks();
        }
        let number = words.small_integer();
        *value = number.ok_or("its header is not P6, width, height and 255")?;
    }
    let [width, height, most] = header;
    if most != 255 {
        return Err(format!(
            "its maximum value is {most}, only 255 is supported"
        ));
    }
    let pixels = bytes.get(words.offset() + 1..).unwrap_or_default();
    image(width, height, pixels).ok_or_else(|| "it ends before its last pixel".into())
}

fn image(width: u32, height: u32, bytes: &[u8]) -> Option<Image> {
    let length = 3 * u64::from(width) * u64::from(height);
    let bytes = bytes.get(..usize::try_from(length).ok()?)?;
    let (pixels, _) = bytes.as_chunks::<3>();
    Some(Image {
        width,
        height,
        pixels: pixels
            .iter()
            .map(|p| p.map(|b| f32::from(b) / 255.0))
            .collect(),
        alpha: None,
    })
}

/// A colour map: 256 lines of three numbers, 0 to 255.
pub(super) fn color_map(bytes: &[u8]) -> Result<[Rgb; 256], String> {
    let mut words = Words::new(bytes, "");
    let mut map = [Rgb::BLACK; 256];
    for (line, color) in map.iter_mut().enumerate() {
        let mut channel = || {
            let value = words.number().ok().filter(|v| (0.0..=255.0).contains(v));
            let message = || format!("colour {line} of 256 is not three numbers from 0 to 255");
            value.map(|v| v / 255.0).ok_or_else(message)
        };
        *color = Rgb::new(channel()?, channel()?, channel()?);
        words.rest_of_line();
    }
    Ok(map)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(bytes: &[u8], expected: Result<[f32; 3], &str>) {
        let pixel = decode(bytes).map(|image| image.pixel(1, 0));
        assert_eq!(pixel, expected.map_err(str::to_owned));
    }

    const PIXELS: [u8; 12] = [0, 0, 0, 255, 0, 51, 0, 0, 0, 0, 0, 0];

    #[test]
    fn pictures() {
        let pic = [&[2, 0, 2, 0][..], &PIXELS].concat();
        check(&pic, Ok([1.0, 0.0, 0.2]));
        check(&pic[..15], Err(UNKNOWN));
        let ppm = [&b"P6\n# made by hand\n2 2\n255\n"[..], &PIXELS].concat();
        check(&ppm, Ok([1.0, 0.0, 0.2]));
        check(&ppm[..30], Err("it ends before its last pixel"));
        check(
            b"P6 2 2 65535 ",
            Err("its maximum value is 65535, only 255 is supported"),
        );
        check(
            b"P6 2 two",
            Err("its header is not P6, width, height and 255"),
        );
        check(
            b"P6 1 1 255\nabc",
            Err("the image has a single row or column, at least two are required"),
        );
    }

    #[test]
    fn maps() {
        let text: String = (0..256).map(|k| format!("{k} 0 255\n")).collect();
        let map = color_map(text.as_bytes()).unwrap();
        assert_eq!(map[51], Rgb::new(0.2, 0.0, 1.0));
        let short = &text[..text.len() - 10];
        assert_eq!(
            color_map(short.as_bytes()),
            Err("colour 255 of 256 is not three numbers from 0 to 255".into())
        );
    }
}
