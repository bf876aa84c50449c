//! TGA: pictures of Truevision's Targa boards.
//!
//! *Truevision TGA File Format Specification*, version 2.0, 1991. The format has no magic number: a
//! header is recognized by values that go together.

use super::bmp::masked;
use super::error::{PictureError, check_size, malformed};
use super::samples::{from_srgb_bytes, little};
use azulejo_scene::Image;

/// What the 18 bytes of the header say.
struct TgaHeader {
    width: usize,
    height: usize,
    /// Whether pixels are indices.
    indexed: bool,
    grey: bool,
    packed: bool,
    /// Bits per pixel, and of them alpha.
    depth: u8,
    alpha: u8,
    downward: bool,
    leftward: bool,
    /// First index, number and depth of the colours.
    map: (usize, usize, u8),
    /// Offset of the colour map.
    start: usize,
}

/// Whether the bytes begin as a TGA does: no other format's first bytes pass.
pub(super) fn is_tga(bytes: &[u8]) -> bool {
    header(bytes).is_some()
}

/// Reads a TGA as linear light: indexed, true colour and grey, with or without runs, from every
/// corner. Values are taken as sRGB. An alpha channel counts if the header says that it has bits, and
/// not all are 0.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let header = header(bytes).ok_or_else(|| malformed(NOT_TGA))?;
    let (width, height) = (header.width, header.height);
    check_size(width as u64, height as u64, bytes.len())?;
    // The colour map precedes the pixels, even in files that do not use it.
    let (first, count, map_depth) = header.map;
    let map_bytes = usize::from(map_depth.div_ceil(8));
    let map = bytes.get(header.start..).unwrap_or_default();
    let data = map.get(count * map_bytes..).unwrap_or_default();
    // An index beyond the map is black.
    let color = |pixel: &[u8]| {
        if !header.indexed {
            return rgba(pixel, header.depth, header.grey);
        }
        let index = little_of(pixel).wrapping_sub(first);
        let entry = map.get(index.saturating_mul(map_bytes)..);
        match entry.filter(|_| index < count) {
            Some(entry) if entry.len() >= map_bytes => rgba(&entry[..map_bytes], map_depth, false),
            _ => [0, 0, 0, 255],
        }
    };
    let pixel_bytes = usize::from(header.depth.div_ceil(8));
    let mut samples = vec![0; 4 * width * height];
    let mut unpacker = TgaUnpacker {
        data,
        pixel_bytes,
        packed: header.packed,
        run: None,
    };
    for k in 0..width * height {
        let pixel = unpacker
            .next()
            .ok_or_else(|| malformed(format!("the TGA ends in row {} of {height}", k / width)))?;
        // Pixels begin at the lower left corner unless the header has them begin at another one.
        let (x, y) = (k % width, k / width);
        let x = if header.leftward { width - 1 - x } else { x };
        let y = if header.downward { y } else { height - 1 - y };
        samples[4 * (y * width + x)..][..4].copy_from_slice(&color(pixel));
    }
    // An alpha channel that is 0 everywhere was not meant to hide the picture.
    let has_alpha = header.alpha > 0 && samples.chunks_exact(4).any(|p| p[3] > 0);
    if !has_alpha {
        samples.chunks_exact_mut(4).for_each(|p| p[3] = 255);
    }
    from_srgb_bytes([width as u32, height as u32], 4, &samples)
}

/// Columns and rows, from the header alone.
pub(super) fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    let header = header(bytes).ok_or_else(|| malformed(NOT_TGA))?;
    Ok([header.width as u64, header.height as u64])
}

const NOT_TGA: &str = "not a TGA: its header contradicts itself";

fn header(bytes: &[u8]) -> Option<TgaHeader> {
    let head = bytes.get(..18)?;
    let (map_kind, kind, depth, flags) = (head[1], head[2], head[16], head[17]);
    let (indexed, grey) = match kind & !8 {
        1 => (true, false),
        2 => (false, false),
        3 => (false, true),
        _ => return None,
    };
    let half = |at| usize::from(u16::from_le_bytes([head[at], head[at + 1]]));
    let (map, alpha) = ((half(3), half(5), head[7]), flags & 15);
    let map_fits = match map_kind {
        0 => !indexed && map.1 == 0,
        1 => matches!(map.2, 15 | 16 | 24 | 32) && (!indexed || map.1 > 0),
        _ => false,
    };
    let depth_fits = match (indexed, grey) {
        (true, _) => matches!(depth, 8 | 16),
        (_, true) => matches!((depth, alpha), (8, 0) | (16, 8)),
        _ => matches!((depth, alpha), (15 | 16, 0 | 1) | (24, 0) | (32, 0 | 8)),
    };
    let (width, height) = (half(12), half(14));
    let whole = map_fits && depth_fits && flags & 0xc0 == 0 && width * height > 0;
    let start = 18 + usize::from(head[0]);
    whole.then_some(TgaHeader {
        width,
        height,
        indexed,
        grey,
        packed: kind & 8 != 0,
        depth,
        alpha: if indexed && map.2 == 32 { 8 } else { alpha },
        downward: flags & 0x20 != 0,
        leftward: flags & 0x10 != 0,
        map: if map_kind == 1 { map } else { (0, 0, 0) },
        start,
    })
}

fn little_of(pixel: &[u8]) -> usize {
    match pixel.len() {
        1 => usize::from(pixel[0]),
        _ => little::<2>(pixel, 0).unwrap_or(0) as usize,
    }
}

/// A stored colour as RGBA.
fn rgba(pixel: &[u8], depth: u8, grey: bool) -> [u8; 4] {
    match (grey, depth, pixel) {
        (true, _, &[v]) => [v, v, v, 255],
        (true, _, &[v, a]) => [v, v, v, a],
        (_, _, &[b, g, r]) => [r, g, b, 255],
        (_, _, &[b, g, r, a]) => [r, g, b, a],
        _ => {
            let number = little_of(pixel) as u32;
            let [r, g, b] = [10, 5, 0].map(|shift| masked(number, 31 << shift));
            [r, g, b, if number & 0x8000 == 0 { 0 } else { 255 }]
        }
    }
}

/// Pixels one after the other, with their runs unfolded.
struct TgaUnpacker<'b> {
    data: &'b [u8],
    pixel_bytes: usize,
    packed: bool,
    /// Pixels left of the run, and the pixel if all are the same.
    run: Option<(usize, Option<&'b [u8]>)>,
}

impl<'b> TgaUnpacker<'b> {
    fn take(&mut self) -> Option<&'b [u8]> {
        let (pixel, rest) = self.data.split_at_checked(self.pixel_bytes)?;
        self.data = rest;
        Some(pixel)
    }

    fn next(&mut self) -> Option<&'b [u8]> {
        if !self.packed {
            return self.take();
        }
        let (left, same) = match self.run {
            Some(run) => run,
            None => {
                let (&code, rest) = self.data.split_first()?;
                self.data = rest;
                let count = usize::from(code & 127) + 1;
                let same = if code & 128 == 0 {
                    None
                } else {
                    Some(self.take()?)
                };
                (count, same)
            }
        };
        self.run = Some((left - 1, same)).filter(|run| run.0 > 0);
        same.map_or_else(|| self.take(), Some)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::picture::error::tests::damage;

    /// A file of two columns; `map` holds its colours of 24 bits.
    pub(crate) fn file(
        kind: u8,
        height: u16,
        depth: u8,
        flags: u8,
        map: &[u8],
        data: &[u8],
    ) -> Vec<u8> {
        let count = (map.len() / 3) as u8;
        let mut bytes = vec![0, u8::from(count > 0), kind, 0, 0, count, 0];
        bytes.push(if count > 0 { 24 } else { 0 });
        bytes.extend([0, 0, 0, 0, 2, 0]);
        bytes.extend(height.to_le_bytes());
        bytes.extend([depth, flags]);
        bytes.extend(map);
        bytes.extend(data);
        bytes
    }

    const BLACK: [f32; 3] = [0.0; 3];
    const RED: [f32; 3] = [1.0, 0.0, 0.0];
    const WHITE: [f32; 3] = [1.0; 3];

    fn check(bytes: &[u8], expected: &[[f32; 3]], alpha: Option<Vec<f32>>) {
        let image = read(bytes).unwrap();
        assert_eq!((&image.pixels[..], image.alpha), (expected, alpha));
        damage(bytes, |b| b.len() == bytes.len() && read(b).is_ok());
    }

    #[test]
    fn kinds_and_corners() {
        let rows = [0, 0, 255, 255, 255, 255, 0, 0, 0, 0, 0, 0];
        check(
            &file(2, 2, 24, 0, &[], &rows),
            &[BLACK, BLACK, RED, WHITE],
            None,
        );
        check(
            &file(2, 2, 24, 0x20, &[], &rows),
            &[RED, WHITE, BLACK, BLACK],
            None,
        );
        check(
            &file(2, 2, 24, 0x30, &[], &rows),
            &[WHITE, RED, BLACK, BLACK],
            None,
        );
        check(&file(3, 1, 8, 0, &[], &[255, 0]), &[WHITE, BLACK], None);
        check(
            &file(1, 1, 8, 0, &[0, 0, 0, 0, 0, 255], &[1, 7]),
            &[RED, BLACK],
            None,
        );
        check(
            &file(2, 1, 16, 0, &[], &[0, 0x7c, 0xff, 0x7f]),
            &[RED, WHITE],
            None,
        );
    }

    #[test]
    fn runs_and_alpha() {
        check(
            &file(10, 2, 24, 0, &[], &[0x82, 0, 0, 255, 0, 255, 255, 255]),
            &[RED, WHITE, RED, RED],
            None,
        );
        let data = [0, 0, 255, 51, 0, 0, 0, 255];
        check(
            &file(2, 1, 32, 8, &[], &data),
            &[RED, BLACK],
            Some(vec![0.2, 1.0]),
        );
        check(&file(2, 1, 32, 0, &[], &data), &[RED, BLACK], None);
        // An alpha channel that is 0 everywhere was never filled.
        check(&file(2, 1, 32, 8, &[], &[0; 8]), &[BLACK, BLACK], None);
    }

    #[test]
    fn other_bytes_are_no_tga() {
        assert!(!is_tga(b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"));
        assert!(!is_tga(&[0; 100]));
        assert!(!is_tga(&file(2, 0, 24, 0, &[], &[])));
        assert!(!is_tga(&file(2, 1, 23, 0, &[], &[])));
        let short = file(10, 60_000, 24, 0, &[], &[]);
        assert!(read(&short).is_err());
    }
}
