//! Radiance HDR: linear pictures, three mantissas with a common exponent.
//!
//! G. Ward, *Real Pixels*, Graphics Gems II, 1991, and the manual pages of Radiance. A
//! value has 8 bits of mantissa, so that the largest channel is exact to 0.4 %.

use super::error::{PictureError, assert_whole, check_size, malformed};
use azulejo_scene::Image;
use std::io::{self, Write};

/// Widths whose rows are compressed channel by channel; others are written uncompressed.
const COMPRESSED_WIDTHS: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// Shortest run that is encoded as one, and the longest whose length fits, channel by channel.
const RUN: std::ops::RangeInclusive<usize> = 4..=127;

/// Four bytes of a pixel: mantissas of red, green and blue, and their exponent.
type Rgbe = [u8; 4];

/// Reads a Radiance picture and divides by its exposure. All three row encodings are read; rows
/// may be in either vertical and horizontal direction, but columns may not come first.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, XYZ colours, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let mut input = Input { bytes };
    let (exposure, layout) = start(&mut input)?;
    check_size(layout.width as u64, layout.height as u64, bytes.len())?;
    let mut image = Image::new(layout.width as u32, layout.height as u32);
    let mut row = vec![Rgbe::default(); layout.width];
    for y in 0..layout.height {
        input.row(&mut row).ok_or_else(|| {
            malformed(format!("the picture ends in row {y} of {}", layout.height))
        })?;
        let target = if layout.upward {
            layout.height - 1 - y
        } else {
            y
        };
        if layout.leftward {
            row.reverse();
        }
        let pixels = &mut image.pixels[target * layout.width..][..layout.width];
        for (pixel, &rgbe) in pixels.iter_mut().zip(&row) {
            *pixel = decode(rgbe).map(|c| c / exposure);
        }
    }
    Ok(image)
}

/// Columns and rows, from the header alone.
pub(super) fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    let (_, layout) = start(&mut Input { bytes })?;
    Ok([layout.width as u64, layout.height as u64])
}

/// The exposure, and the line of the size.
fn start(input: &mut Input) -> Result<(f32, Layout), PictureError> {
    let exposure = header(input)?;
    Ok((exposure, Layout::parse(input.line().unwrap_or_default())?))
}

/// Writes a picture, compressed. Negative values and NaN become 0, values above 1.7e38 are clamped.
///
/// # Errors
/// Errors of `out`.
///
/// # Panics
/// If the picture does not have `width × height` pixels.
pub fn write(image: &Image, out: &mut dyn Write) -> io::Result<()> {
    assert_whole(image);
    let (width, height) = (image.width as usize, image.height as usize);
    write!(
        out,
        "#?RADIANCE\nSOFTWARE=azulejo\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"
    )?;
    let mut line = Vec::new();
    for row in image.pixels.chunks_exact(width.max(1)) {
        line.clear();
        let row: Vec<Rgbe> = row.iter().map(|&p| encode(p)).collect();
        if COMPRESSED_WIDTHS.contains(&width) {
            line.extend([2, 2, (width >> 8) as u8, width as u8]);
            for channel in 0..4 {
                let values: Vec<u8> = row.iter().map(|p| p[channel]).collect();
                compress(&values, &mut line);
            }
        } else {
            line.extend(row.as_flattened());
        }
        out.write_all(&line)?;
    }
    Ok(())
}

/// Radiance's own rounding: mantissas are truncated, and read back as the middle of their step.
fn encode(pixel: [f32; 3]) -> Rgbe {
    const LARGEST: f32 = 1.7e38;
    // NaN is not above 0 either.
    let pixel = pixel.map(|c| if c > 0.0 { c.min(LARGEST) } else { 0.0 });
    let largest = pixel[0].max(pixel[1]).max(pixel[2]);
    if largest < 1e-32 {
        return [0; 4];
    }
    // The largest channel is m 2^e with m in 0.5..1.
    let e = (largest.to_bits() >> 23) as i32 - 126;
    let scale = 2f32.powi(8 - e);
    let [r, g, b] = pixel.map(|c| (c * scale) as u8);
    [r, g, b, (e + 128) as u8]
}

fn decode([r, g, b, e]: Rgbe) -> [f32; 3] {
    if e == 0 {
        return [0.0; 3];
    }
    let scale = 2f64.powi(i32::from(e) - 136);
    [r, g, b].map(|c| ((f64::from(c) + 0.5) * scale) as f32)
}

/// One channel of a row as runs (128 + length, value) and literals (length, values).
fn compress(values: &[u8], out: &mut Vec<u8>) {
    let run_at = |at: usize| {
        let same = values[at..]
            .iter()
            .take_while(|v| **v == values[at])
            .count();
        same.min(*RUN.end())
    };
    let mut at = 0;
    while at < values.len() {
        let run = run_at(at);
        if RUN.contains(&run) {
            out.extend([128 + run as u8, values[at]]);
            at += run;
            continue;
        }
        let start = at;
        while at < values.len() && at - start < 128 && !RUN.contains(&run_at(at)) {
            at += 1;
        }
        out.push((at - start) as u8);
        out.extend(&values[start..at]);
    }
}

/// Reads the lines up to the empty one; returns the product of their exposures.
fn header(input: &mut Input) -> Result<f32, PictureError> {
    if !input.bytes.starts_with(b"#?") {
        return Err(malformed(
            "not a Radiance picture: it does not begin with #?",
        ));
    }
    let mut exposure = 1.0;
    loop {
        let line = input
            .line()
            .ok_or_else(|| malformed("the header does not end"))?;
        if line.is_empty() {
            return Ok(exposure);
        }
        match line.split_once('=') {
            Some(("FORMAT", format)) if format.trim() != "32-bit_rle_rgbe" => {
                return Err(malformed(format!(
                    "format {format:?}, expected 32-bit_rle_rgbe"
                )));
            }
            Some(("EXPOSURE", value)) => exposure *= factor(value)?,
            _ => {}
        }
    }
}

fn factor(value: &str) -> Result<f32, PictureError> {
    let factor = value.trim().parse::<f32>().ok();
    factor
        .filter(|f| f.is_normal() && *f > 0.0)
        .ok_or_else(|| malformed(format!("exposure {value:?}, expected a number above 0")))
}

/// The resolution line: `-Y height +X width`.
struct Layout {
    width: usize,
    height: usize,
    upward: bool,
    leftward: bool,
}

impl Layout {
    fn parse(line: &str) -> Result<Layout, PictureError> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let layout = match words[..] {
            [y @ ("-Y" | "+Y"), height, x @ ("-X" | "+X"), width] => (|| {
                Some(Layout {
                    width: width.parse().ok()?,
                    height: height.parse().ok()?,
                    upward: y == "+Y",
                    leftward: x == "-X",
                })
            })(),
            _ => None,
        };
        layout.ok_or_else(|| malformed(format!("size {line:?}, expected -Y height +X width")))
    }
}

/// The unread bytes.
struct Input<'a> {
    bytes: &'a [u8],
}

impl<'a> Input<'a> {
    /// Reads a line of the header, without its end.
    fn line(&mut self) -> Option<&'a str> {
        let end = self.bytes.iter().position(|b| *b == b'\n')?;
        let line = std::str::from_utf8(&self.bytes[..end]).unwrap_or("?");
        self.bytes = &self.bytes[end + 1..];
        Some(line)
    }

    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.bytes.split_first()?;
        self.bytes = rest;
        Some(*first)
    }

    /// Reads one row; `None` if the bytes end or do not fit it.
    fn row(&mut self, row: &mut [Rgbe]) -> Option<()> {
        let width = row.len();
        let mark = [2, 2, (width >> 8) as u8, width as u8];
        if COMPRESSED_WIDTHS.contains(&width) && self.bytes.starts_with(&mark) {
            self.bytes = &self.bytes[4..];
            (0..4).try_for_each(|channel| self.channel(row, channel))
        } else {
            self.pixels(row)
        }
    }

    /// Reads one channel of a row, as [`compress`] writes it.
    fn channel(&mut self, row: &mut [Rgbe], channel: usize) -> Option<()> {
        let mut at = 0;
        while at < row.len() {
            let code = usize::from(self.byte()?);
            let (count, is_run) = if code > 128 {
                (code - 128, true)
            } else {
                (code, false)
            };
            if count == 0 {
                return None;
            }
            let mut value = if is_run { self.byte()? } else { 0 };
            for pixel in row.get_mut(at..at + count)? {
                if !is_run {
                    value = self.byte()?;
                }
                pixel[channel] = value;
            }
            at += count;
        }
        Some(())
    }

    /// Reads whole pixels; mantissas of 1, 1, 1 repeat the previous pixel, with the count in the
    /// exponent, each consecutive such pixel counting 256 times more.
    fn pixels(&mut self, row: &mut [Rgbe]) -> Option<()> {
        let (mut at, mut shift) = (0, 0);
        while at < row.len() {
            let (&pixel, rest) = self.bytes.split_first_chunk::<4>()?;
            self.bytes = rest;
            if pixel[..3] == [1, 1, 1] {
                let count = usize::from(pixel[3]).checked_shl(shift)?;
                let last = *row.get(at.checked_sub(1)?)?;
                row.get_mut(at..at.checked_add(count)?)?.fill(last);
                at += count;
                shift += 8;
            } else {
                row[at] = pixel;
                at += 1;
                shift = 0;
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::error::tests::{damage, gradient};

    fn written(image: &Image) -> Vec<u8> {
        let mut file = Vec::new();
        write(image, &mut file).unwrap();
        file
    }

    #[test]
    fn read_back_to_a_mantissa_of_8_bits() {
        for (width, height) in [(1, 1), (7, 3), (8, 2), (300, 5)] {
            let image = gradient(width, height);
            let back = read(&written(&image)).unwrap();
            for (a, b) in image.pixels.iter().zip(&back.pixels) {
                let step = a.iter().fold(0f32, |m, c| m.max(*c)) / 128.0;
                assert!((0..3).all(|k| (a[k] - b[k]).abs() <= step), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn unrepresentable_values_are_clamped() {
        let pixels = vec![[f32::NAN, -1.0, 0.0], [f32::INFINITY, 1.0, 0.0]];
        let image = Image {
            width: 2,
            height: 1,
            pixels,
            alpha: None,
        };
        let back = read(&written(&image)).unwrap();
        assert_eq!(back.pixels[0], [0.0; 3]);
        assert!(back.pixels[1][0] > 1.6e38 && back.pixels[1][0].is_finite());
    }

    #[test]
    fn a_row_of_one_colour_is_short() {
        let file = written(&Image {
            width: 1000,
            height: 100,
            pixels: vec![[1.0; 3]; 100_000],
            alpha: None,
        });
        assert!(file.len() < 100 * 80, "{} bytes", file.len());
    }

    fn check(body: &[u8], expected: Option<&[[f32; 3]]>) {
        let file = [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n", body].concat();
        let pixels = read(&file).ok().map(|image| image.pixels);
        assert_eq!(pixels.as_deref(), expected, "{}", body.escape_ascii());
    }

    #[test]
    fn rows_of_every_kind() {
        // Exponent 136 makes a mantissa m the value m + 0.5, which exposure 2 halves.
        let (a, b) = ([0.25; 3], [1.25; 3]);
        check(b"-Y 1 +X 2\n\0\0\0\x88\x02\x02\x02\x88", Some(&[a, b]));
        check(b"-Y 1 -X 2\n\0\0\0\x88\x02\x02\x02\x88", Some(&[b, a]));
        check(b"+Y 2 +X 1\n\0\0\0\x88\x02\x02\x02\x88", Some(&[b, a]));
        check(
            b"-Y 1 +X 3\n\x02\x02\x02\x88\x01\x01\x01\x02",
            Some(&[b; 3]),
        );
        check(b"-Y 1 +X 2\n\x01\x01\x01\x02", None);
        check(b"-Y 1 +X 2\n\x02\x02\x02\x88\x01\x01\x01\x09", None);
        check(b"+X 1 -Y 1\n\0\0\0\0", None);
        check(b"-Y 99999999 +X 99999999\n", None);
        check(b"-Y 0 +X 3232323232\n", None);
        check(b"-Y 0 +X 2\n", Some(&[]));
        let run = b"-Y 1 +X 8\n\x02\x02\0\x08\x88\0\x88\0\x88\0\x88\x88";
        check(run, Some(&[a; 8]));
        check(b"-Y 1 +X 8\n\x02\x02\0\x08\x89\0", None);
    }

    #[test]
    fn damaged_files_are_refused_or_read() {
        damage(&written(&gradient(16, 16)), |bytes| read(bytes).is_ok());
    }
}
