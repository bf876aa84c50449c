//! SGI: the pictures of Silicon Graphics' image library (`.rgb`, `.rgba`, `.sgi`, `.bw`).
//!
//! P. Haeberli, *The SGI Image File Format*, version 1.00. One plane per channel, rows from below,
//! plain or with a table of runs for each row.

use super::error::{PictureError, check_size, malformed};
use super::samples::{from_samples, from_srgb_bytes};
use super::srgb::linear_from_srgb;
use azulejo_scene::Image;

/// Size of the header; what follows is the table of runs, or the pixels.
const HEADER: usize = 512;

/// What the header says.
struct SgiHeader {
    width: usize,
    height: usize,
    channels: usize,
    /// Bytes per sample: 1 or 2.
    depth: usize,
    packed: bool,
}

/// Reads an SGI picture as linear light: grey, grey and alpha, RGB, RGBA, with 8 or 16 bits, plain or
/// with runs. Values are taken as sRGB. Further channels are ignored.
///
/// # Errors
/// [`PictureError`]: damaged, cut short, or larger than its bytes justify.
pub fn read(bytes: &[u8]) -> Result<Image, PictureError> {
    let header = header(bytes)?;
    let (width, height) = (header.width, header.height);
    check_size(width as u64, height as u64, bytes.len())?;
    let (used, depth) = (header.channels.min(4), header.depth);
    let mut samples = vec![0; width * height * used * depth];
    let mut row = vec![0; width * depth];
    for channel in 0..used {
        for y in 0..height {
            let ended = || malformed(format!("the SGI picture ends in row {y} of {height}"));
            fill(&header, bytes, channel * height + y, &mut row).ok_or_else(ended)?;
            let target = &mut samples[(height - 1 - y) * width * used * depth..];
            let pixels = target.chunks_exact_mut(used * depth);
            for (pixel, sample) in pixels.zip(row.chunks_exact(depth)) {
                pixel[channel * depth..][..depth].copy_from_slice(sample);
            }
        }
    }
    let size = [width as u32, height as u32];
    if depth == 1 {
        return from_srgb_bytes(size, used, &samples);
    }
    let share =
        |i: usize| f32::from(u16::from_be_bytes([samples[2 * i], samples[2 * i + 1]])) / 65535.0;
    from_samples(
        size,
        used,
        samples.len() / 2,
        |i| linear_from_srgb(share(i)),
        share,
    )
}

/// Columns and rows, from the header alone.
pub(super) fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    let header = header(bytes)?;
    Ok([header.width as u64, header.height as u64])
}

fn header(bytes: &[u8]) -> Result<SgiHeader, PictureError> {
    if bytes.len() < HEADER {
        return Err(malformed("an SGI picture whose header ends early"));
    }
    let half = |at: usize| usize::from(u16::from_be_bytes([bytes[at], bytes[at + 1]]));
    let (packed, depth, dimensions) = (bytes[2], usize::from(bytes[3]), half(4));
    let height = if dimensions < 2 { 1 } else { half(8) };
    let channels = if dimensions < 3 { 1 } else { half(10) };
    let color_map = u32::from_be_bytes([bytes[104], bytes[105], bytes[106], bytes[107]]);
    let fits = packed <= 1 && matches!(depth, 1 | 2) && channels > 0 && color_map == 0;
    if !fits {
        return Err(malformed("an SGI picture of a kind that is not read"));
    }
    Ok(SgiHeader {
        width: half(6),
        height,
        channels,
        depth,
        packed: packed == 1,
    })
}

/// Fills row number `index`, counted through all channels; `None` where the bytes end or do not fit.
fn fill(header: &SgiHeader, bytes: &[u8], index: usize, row: &mut [u8]) -> Option<()> {
    if !header.packed {
        let start = HEADER + index * row.len();
        row.copy_from_slice(bytes.get(start..start + row.len())?);
        return Some(());
    }
    let entry = |table: usize| {
        let at = HEADER + 4 * (table * header.height * header.channels + index);
        let word = bytes.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_be_bytes(word) as usize)
    };
    let (start, length) = (entry(0)?, entry(1)?);
    let data = bytes.get(start..start.checked_add(length)?)?;
    unpack(data, header.depth, row)
}

/// Runs of samples: a count, with the highest of its low eight bits set where samples follow one by
/// one, else one sample that is repeated; a count of 0 ends the row.
fn unpack(data: &[u8], depth: usize, row: &mut [u8]) -> Option<()> {
    let mut samples = data.chunks_exact(depth);
    let mut targets = row.chunks_exact_mut(depth);
    while targets.len() > 0 {
        let code = *samples.next()?.last()?;
        let count = usize::from(code & 127);
        if count == 0 || count > targets.len() {
            return None;
        }
        if code & 128 != 0 {
            for target in targets.by_ref().take(count) {
                target.copy_from_slice(samples.next()?);
            }
        } else {
            let sample = samples.next()?;
            for target in targets.by_ref().take(count) {
                target.copy_from_slice(sample);
            }
        }
    }
    Some(())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::picture::error::tests::damage;

    /// A file of two columns and one row.
    pub(crate) fn file(packed: u8, depth: u8, channels: u16, data: &[u8]) -> Vec<u8> {
        let mut bytes = vec![1, 0xda, packed, depth];
        for n in [3u16, 2, 1, channels] {
            bytes.extend(n.to_be_bytes());
        }
        bytes.resize(HEADER, 0);
        bytes.extend(data);
        bytes
    }

    const RED: [f32; 3] = [1.0, 0.0, 0.0];
    const BLACK: [f32; 3] = [0.0; 3];
    const WHITE: [f32; 3] = [1.0; 3];

    fn check(bytes: &[u8], expected: [[f32; 3]; 2], alpha: Option<Vec<f32>>) {
        let image = read(bytes).unwrap();
        assert_eq!((&image.pixels[..], image.alpha), (&expected[..], alpha));
        damage(bytes, |b| b.len() == bytes.len() && read(b).is_ok());
    }

    #[test]
    fn planes_of_every_kind() {
        check(&file(0, 1, 3, &[255, 0, 0, 0, 0, 0]), [RED, BLACK], None);
        check(&file(0, 1, 1, &[255, 0]), [WHITE, BLACK], None);
        check(
            &file(0, 1, 4, &[255, 0, 0, 0, 0, 0, 51, 255]),
            [RED, BLACK],
            Some(vec![0.2, 1.0]),
        );
        check(&file(0, 2, 1, &[255, 255, 0, 0]), [WHITE, BLACK], None);
    }

    #[test]
    fn runs() {
        // The table of starts, the table of lengths, and the row.
        let table = |length: u8| [0, 0, 2, 8, 0, 0, 0, length];
        let run = [&table(3)[..], &[2, 255, 0]].concat();
        check(&file(1, 1, 1, &run), [WHITE; 2], None);
        let literal = [&table(4)[..], &[0x82, 255, 0, 0]].concat();
        check(&file(1, 1, 1, &literal), [WHITE, BLACK], None);
        let wide = [&table(6)[..], &[0, 2, 255, 255, 0, 0]].concat();
        check(&file(1, 2, 1, &wide), [WHITE; 2], None);
        let beyond = [&table(3)[..], &[3, 255, 0]].concat();
        assert!(read(&file(1, 1, 1, &beyond)).is_err());
    }

    #[test]
    fn rows_of_several() {
        let mut bytes = file(0, 1, 1, &[255, 255, 0, 0]);
        bytes[9] = 2;
        let image = read(&bytes).unwrap();
        assert_eq!(image.pixels, [BLACK, BLACK, WHITE, WHITE]);
        bytes[6..10].fill(0xff);
        assert!(matches!(read(&bytes), Err(PictureError::TooLarge { .. })));
    }
}
