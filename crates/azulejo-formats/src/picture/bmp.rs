//! BMP: device-independent bitmaps of Windows and OS/2.
//!
//! Microsoft, *Bitmap Storage*; the headers of 12 bytes (OS/2) and of 40 to 124 bytes. A reader of our
//! own, as the one whose JPEG reader is used here misplaces rows of 16 bits.

use super::error::{PictureError, check_size, malformed};
use super::samples::{from_srgb_bytes, little};
use azulejo_scene::Image;

/// How the pixels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BmpStorage {
    /// As numbers, from which masks select the channels where there are any.
    Plain,
    /// Runs of palette indices of one byte or of half a byte.
    Runs,
}

/// What the headers say.
struct BmpHeader {
    width: usize,
    height: usize,
    /// Whether the first row is the upper one.
    downward: bool,
    /// Bits per pixel.
    depth: usize,
    storage: BmpStorage,
    /// Bits of red, green, blue and alpha.
    masks: [u32; 4],
    palette: Vec<[u8; 3]>,
    /// Offset of the pixels.
    start: usize,
}

/// Reads a BMP as linear light: 1, 2, 4, 8, 16, 24 and 32 bits per pixel, palettes, bit fields and
/// runs. Values are taken as sRGB. A fourth channel without a mask is not an alpha channel.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, an embedded JPEG or PNG, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let header = header(bytes)?;
    let (width, height) = (header.width, header.height);
    check_size(width as u64, height as u64, bytes.len())?;
    let data = bytes.get(header.start..).unwrap_or_default();
    let channels = if header.masks[3] == 0 { 3 } else { 4 };
    let mut samples = vec![0; width * height * channels];
    match header.storage {
        BmpStorage::Plain => plain(&header, data, channels, &mut samples)?,
        BmpStorage::Runs => runs(&header, data, &mut samples)?,
    }
    from_srgb_bytes([width as u32, height as u32], channels, &samples)
}

/// Columns and rows, from the header alone.
pub(super) fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    let header = header(bytes)?;
    Ok([header.width as u64, header.height as u64])
}

fn header(bytes: &[u8]) -> Result<BmpHeader, PictureError> {
    parse(bytes).ok_or_else(|| malformed("a BMP whose header ends early"))?
}

/// `None` where the bytes end.
fn parse(bytes: &[u8]) -> Option<Result<BmpHeader, PictureError>> {
    let word = |at| little::<4>(bytes, at).map(|n| n as u32);
    let half = |at| little::<2>(bytes, at).map(|n| n as usize);
    let (start, length) = (word(10)? as usize, word(14)? as usize);
    if length < 12 {
        return Some(Err(malformed(format!("a BMP header of {length} bytes"))));
    }
    let old = length < 16;
    let (width, rows, depth) = if old {
        (half(18)? as u32, half(20)? as i32, half(24)?)
    } else {
        (word(18)?, word(22)? as i32, half(28)?)
    };
    let compression = if length >= 20 { word(30)? } else { 0 };
    let storage = match (compression, depth) {
        (0 | 3 | 6, _) => BmpStorage::Plain,
        (1, 8) | (2, 4) => BmpStorage::Runs,
        _ => {
            let what = format!("BMP compression {compression} at {depth} bits, which is not read");
            return Some(Err(malformed(what)));
        }
    };
    if !matches!(depth, 1 | 2 | 4 | 8 | 16 | 24 | 32) {
        return Some(Err(malformed(format!("a BMP of {depth} bits per pixel"))));
    }
    let given = matches!(compression, 3 | 6);
    let masks = match depth {
        16 | 32 if given => {
            let alpha = compression == 6 || length >= 56;
            let last = if alpha { word(66)? } else { 0 };
            [word(54)?, word(58)?, word(62)?, last]
        }
        16 => [31 << 10, 31 << 5, 31, 0],
        _ => [0xff << 16, 0xff << 8, 0xff, 0],
    };
    // Masks behind the header of 40 bytes, then the palette.
    let after = match compression {
        3 if length == 40 => 12,
        6 if length == 40 => 16,
        _ => 0,
    };
    let entry = if old { 3 } else { 4 };
    let mut palette = Vec::new();
    if depth <= 8 {
        let used = if length >= 36 { word(46)? as usize } else { 0 };
        let most = 1 << depth;
        let count = if (1..=most).contains(&used) {
            used
        } else {
            most
        };
        let table = bytes.get(14 + length + after..).unwrap_or_default();
        let room = start.saturating_sub(14 + length + after) / entry;
        let entries = table.chunks_exact(entry).take(count.min(room));
        palette.extend(entries.map(|c| [c[2], c[1], c[0]]));
        if palette.is_empty() {
            // Without a palette, shades of grey.
            palette.extend((0..most).map(|k| [(k * 255 / (most - 1)) as u8; 3]));
        }
    }
    Some(Ok(BmpHeader {
        width: width as usize,
        height: rows.unsigned_abs() as usize,
        downward: rows < 0,
        depth,
        storage,
        masks,
        palette,
        start,
    }))
}

impl BmpHeader {
    /// The row of the picture that the file's row `y` is.
    fn row(&self, y: usize) -> usize {
        if self.downward {
            y
        } else {
            self.height - 1 - y
        }
    }

    /// Black for an index beyond the palette.
    fn color(&self, index: usize) -> [u8; 3] {
        self.palette.get(index).copied().unwrap_or_default()
    }
}

/// Rows of numbers, each padded to four bytes.
fn plain(
    header: &BmpHeader,
    data: &[u8],
    channels: usize,
    samples: &mut [u8],
) -> Result<(), PictureError> {
    let (width, depth) = (header.width, header.depth);
    let stride = (width * depth).div_ceil(32) * 4;
    for y in 0..header.height {
        // The padding of the last row is often left out.
        let row = data.get(y * stride..).unwrap_or_default();
        if row.len() < (width * depth).div_ceil(8) {
            return Err(malformed(format!(
                "the BMP ends in row {y} of {}",
                header.height
            )));
        }
        let target = &mut samples[header.row(y) * width * channels..][..width * channels];
        for (x, pixel) in target.chunks_exact_mut(channels).enumerate() {
            match depth {
                24 => pixel.copy_from_slice(&[row[3 * x + 2], row[3 * x + 1], row[3 * x]]),
                16 | 32 => {
                    let number = match depth {
                        16 => little::<2>(row, 2 * x),
                        _ => little::<4>(row, 4 * x),
                    };
                    let number = number.unwrap_or(0) as u32;
                    for (sample, &mask) in pixel.iter_mut().zip(&header.masks) {
                        *sample = masked(number, mask);
                    }
                }
                _ => {
                    let bit = x * depth;
                    let byte = usize::from(row[bit / 8]);
                    let index = byte >> (8 - depth - bit % 8) & ((1 << depth) - 1);
                    pixel.copy_from_slice(&header.color(index));
                }
            }
        }
    }
    Ok(())
}

/// The bits of `number` under `mask`, scaled to 0..=255.
pub(super) fn masked(number: u32, mask: u32) -> u8 {
    if mask == 0 {
        return 0;
    }
    let shift = mask.trailing_zeros();
    let (value, most) = (
        u64::from((number & mask) >> shift),
        u64::from(mask >> shift),
    );
    ((value * 255 + most / 2) / most) as u8
}

/// Runs of palette indices. What no run reaches stays black; runs end at the end of their row.
fn runs(header: &BmpHeader, data: &[u8], samples: &mut [u8]) -> Result<(), PictureError> {
    let (mut x, mut y) = (0, 0);
    let mut pairs = data.iter().copied();
    // A run may leave its row or the picture: what lies outside has no effect.
    let mut put = |x: &mut usize, y: usize, index: u8| {
        if *x < header.width && y < header.height {
            let at = 3 * (header.row(y) * header.width + *x);
            samples[at..at + 3].copy_from_slice(&header.color(usize::from(index)));
        }
        *x += 1;
    };
    // At 4 bits, a byte holds two indices, the upper half first; a run alternates between them.
    let nibble = |byte: u8, k: usize| match (header.depth, k % 2) {
        (8, _) => byte,
        (_, 0) => byte >> 4,
        _ => byte & 15,
    };
    let ended = || malformed("the BMP ends in a run");
    while y < header.height {
        // A count of 0 is an escape: the end of a row or of the picture, a jump, or indices without runs.
        let (count, value) = pairs.next().zip(pairs.next()).ok_or_else(ended)?;
        match (count, value) {
            (0, 0) => (x, y) = (0, y + 1),
            (0, 1) => return Ok(()),
            (0, 2) => {
                let (right, up) = pairs.next().zip(pairs.next()).ok_or_else(ended)?;
                (x, y) = (x + usize::from(right), y + usize::from(up));
            }
            (0, literal) => {
                let literal = usize::from(literal);
                let length = (literal * header.depth).div_ceil(8);
                let mut byte = 0;
                for k in 0..literal {
                    if (k * header.depth).is_multiple_of(8) {
                        byte = pairs.next().ok_or_else(ended)?;
                    }
                    put(&mut x, y, nibble(byte, k));
                }
                // Such indices are padded to 16 bits.
                if length % 2 == 1 {
                    pairs.next();
                }
            }
            _ => (0..usize::from(count)).for_each(|k| put(&mut x, y, nibble(value, k))),
        }
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::picture::error::tests::damage;

    /// A file with the header of 40 bytes, what follows it, and the pixels.
    pub(crate) fn file(
        size: [i32; 2],
        depth: u16,
        compression: u32,
        table: &[u8],
        data: &[u8],
    ) -> Vec<u8> {
        let start = 54 + table.len() as u32;
        let mut bytes = b"BM\0\0\0\0\0\0\0\0".to_vec();
        bytes.extend(start.to_le_bytes());
        bytes.extend(40u32.to_le_bytes());
        size.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
        bytes.extend(1u16.to_le_bytes());
        bytes.extend(depth.to_le_bytes());
        bytes.extend(compression.to_le_bytes());
        bytes.extend([0; 20]);
        bytes.extend(table);
        bytes.extend(data);
        bytes
    }

    const BLACK: [f32; 3] = [0.0; 3];
    const RED: [f32; 3] = [1.0, 0.0, 0.0];
    const WHITE: [f32; 3] = [1.0; 3];

    fn check(bytes: &[u8], expected: &[[f32; 3]]) {
        assert_eq!(read(bytes).unwrap().pixels, expected);
        damage(bytes, |b| b.len() == bytes.len() && read(b).is_ok());
    }

    #[test]
    fn pixels_of_every_depth() {
        // Two rows of one pixel: the lower one first.
        check(
            &file([1, 2], 24, 0, &[], &[0, 0, 255, 0, 255, 255, 255, 0]),
            &[WHITE, RED],
        );
        check(
            &file([1, -2], 24, 0, &[], &[0, 0, 255, 0, 255, 255, 255, 0]),
            &[RED, WHITE],
        );
        // The last byte of 32 bits is not alpha, unless a mask says so.
        check(&file([1, 1], 32, 0, &[], &[0, 0, 255, 0]), &[RED]);
        check(
            &file([3, 1], 16, 0, &[], &[0, 0x7c, 0xff, 0x7f, 0, 0]),
            &[RED, WHITE, BLACK],
        );
        let palette = [0, 0, 0, 0, 0, 0, 255, 0];
        check(
            &file([3, 1], 1, 0, &palette, &[0b0100_0000, 0, 0, 0]),
            &[BLACK, RED, BLACK],
        );
        check(
            &file([3, 1], 4, 0, &palette, &[0x10, 0x10, 0, 0]),
            &[RED, BLACK, RED],
        );
        check(&file([2, 1], 8, 0, &palette, &[1, 9, 0, 0]), &[RED, BLACK]);
        check(&file([2, 1], 8, 0, &[], &[255, 0, 0, 0]), &[WHITE, BLACK]);
    }

    #[test]
    fn runs_and_jumps() {
        let palette = [0, 0, 0, 0, 0, 0, 255, 0];
        let data = [2, 1, 0, 0, 0, 2, 1, 0, 1, 1, 0, 1];
        check(
            &file([2, 2], 8, 1, &palette, &data),
            &[BLACK, RED, RED, RED],
        );
        let data = [3, 0x10, 0, 3, 0x10, 0x10, 0, 1];
        check(
            &file([6, 1], 4, 2, &palette, &data),
            &[RED, BLACK, RED, RED, BLACK, RED],
        );
    }

    #[test]
    fn alpha_is_what_a_mask_says() {
        let masks = [0xff0000u32, 0xff00, 0xff, 0xff00_0000].map(u32::to_le_bytes);
        let bytes = file(
            [2, 1],
            32,
            6,
            &masks.concat(),
            &[0, 0, 255, 51, 0, 0, 0, 255],
        );
        let image = read(&bytes).unwrap();
        assert_eq!(image.pixels, [RED, BLACK]);
        assert_eq!(image.alpha, Some(vec![0.2, 1.0]));
    }

    #[test]
    fn sizes_are_justified() {
        let bytes = file([30_000, -30_000], 8, 1, &[0; 8], &[0, 1]);
        assert!(matches!(read(&bytes), Err(PictureError::TooLarge { .. })));
        let bytes = file([i32::MIN, i32::MIN], 32, 0, &[], &[]);
        assert!(matches!(read(&bytes), Err(PictureError::TooLarge { .. })));
        assert_eq!(size(&file([7, -5], 1, 0, &[], &[])), Ok([7, 5]));
    }
}
