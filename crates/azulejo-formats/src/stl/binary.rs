//! The binary format: 80 arbitrary bytes, a count, and 50 bytes for each triangle.

use super::{StlSolid, default_material, painted};
use crate::reading::text::text;
use crate::reading::warnings::Warnings;
use crate::{Position, ReadError};
use azulejo_scene::{MaterialId, Rgb, Scene};
use glam::DVec3;
use std::collections::HashMap;

const HEADER: usize = 80;

/// Bytes before the first triangle.
const START: usize = HEADER + 4;

/// A normal and three corners with three numbers each, and two bytes for extensions.
const TRIANGLE: usize = 50;

/// Whether the number of bytes matches the count of triangles, in either byte order.
pub(super) fn has_right_length(bytes: &[u8]) -> bool {
    let fits = |count: u32| START as u64 + TRIANGLE as u64 * u64::from(count) == bytes.len() as u64;
    let count = bytes.get(HEADER..START).and_then(|b| b.try_into().ok());
    count.is_some_and(|c| fits(u32::from_le_bytes(c)) || fits(u32::from_be_bytes(c)))
}

/// Reads a binary file.
pub(super) fn read(bytes: &[u8], file: &str, warnings: &mut Warnings) -> Result<Scene, ReadError> {
    let Some((start, rest)) = bytes.split_first_chunk::<START>() else {
        let found = format!("{} bytes", bytes.len());
        let expected = "text that begins with \"solid\", or at least 84 bytes of binary STL";
        return Err(ReadError::whole(file, found, expected));
    };
    let (header, count) = start.split_at(HEADER);
    let mut warn = |at: usize, message: String, count: usize| {
        warnings.add_many(file, message, count, || Position::Byte(at as u64));
    };
    let (triangles, is_big) = triangles(count, rest, &mut warn);
    let mut scene = Scene::default();
    let mut colors = FacetColors::new(header, triangles);
    if colors.are_odd {
        let message = "bytes after triangles that are not colours: ignored";
        warn(START + TRIANGLE - 2, message.into(), 1);
    }
    let mut solid = StlSolid::new(name(header), triangles.len());
    for (i, triangle) in triangles.iter().enumerate() {
        let material = colors.material(triangle, &mut scene);
        let corners = if is_big {
            corners(triangle, f32::from_be_bytes)
        } else {
            corners(triangle, f32::from_le_bytes)
        };
        if let Err(problem) = solid.facet(&corners, material) {
            warn(START + i * TRIANGLE, problem.into(), 1);
        }
    }
    solid.finish(&mut scene);
    Ok(scene)
}

/// The triangles present, at most as many as `count` declares, and whether they are big-endian:
/// some old programs wrote the native byte order, which the file length reveals.
fn triangles<'a>(
    count: &[u8],
    rest: &'a [u8],
    warn: &mut impl FnMut(usize, String, usize),
) -> (&'a [[u8; TRIANGLE]], bool) {
    let number = |read: fn([u8; 4]) -> u32| count.try_into().map_or(0, read) as usize;
    let (little, big) = (number(u32::from_le_bytes), number(u32::from_be_bytes));
    let (triangles, _) = rest.as_chunks::<TRIANGLE>();
    let is_big = little != triangles.len() && big == triangles.len();
    let promised = if is_big { big } else { little };
    let triangles = &triangles[..promised.min(triangles.len())];
    if is_big {
        let message = "big-endian numbers, which the format does not allow: read as such";
        warn(HEADER, message.into(), 1);
    }
    let lost = promised - triangles.len();
    let surplus = rest.len() - triangles.len() * TRIANGLE;
    let message = "triangles missing from the end of the file";
    warn(START + rest.len(), message.into(), lost);
    if lost == 0 && surplus > 0 {
        let message = format!("{surplus} bytes after the last triangle: skipped");
        warn(START + rest.len() - surplus, message, 1);
    }
    (triangles, is_big)
}

#[inline]
fn corners(triangle: &[u8; TRIANGLE], number: fn([u8; 4]) -> f32) -> [DVec3; 3] {
    let (numbers, _) = triangle.as_chunks::<4>();
    let at = |i: usize| f64::from(number(numbers[i]));
    // The first three are the normal, which is computed from the corners.
    [3, 6, 9].map(|i| DVec3::new(at(i), at(i + 1), at(i + 2)))
}

/// The text after `solid` at the start of the header.
fn name(header: &[u8]) -> String {
    let end = header.iter().position(|b| *b == 0).unwrap_or(HEADER);
    let name = header[..end].strip_prefix(b"solid ").unwrap_or_default();
    text(name.trim_ascii()).into_owned()
}

/// Colours in the two bytes after each triangle, 5 bits per channel.
struct FacetColors {
    /// Default colour in the header of Magics files.
    whole: Option<Rgb>,
    /// Whether any triangle has its own colour.
    are_used: bool,
    /// Whether the bytes have another meaning.
    are_odd: bool,
    /// By the bits of the colour.
    known: HashMap<Option<[u64; 3]>, MaterialId>,
    /// The last triangle's bytes and material: neighbours are often equal.
    last: Option<(u16, MaterialId)>,
}

/// The top bit of the two bytes: colour present for VisCAM, absent for Magics.
const FLAG: u16 = 0x8000;

impl FacetColors {
    fn new(header: &[u8], triangles: &[[u8; TRIANGLE]]) -> FacetColors {
        let whole = magics_color(header);
        let is_own = |bits: u16| (bits & FLAG == 0) == whole.is_some();
        let mut extras = triangles.iter().map(extra);
        let are_used = extras.clone().any(is_own);
        FacetColors {
            whole,
            are_used,
            are_odd: extras.any(|bits| bits != 0 && !is_own(bits) && whole.is_none()),
            known: HashMap::new(),
            last: None,
        }
    }

    #[inline]
    fn material(&mut self, triangle: &[u8; TRIANGLE], scene: &mut Scene) -> MaterialId {
        let bits = if self.are_used { extra(triangle) } else { FLAG };
        match self.last {
            Some((last, material)) if last == bits => material,
            _ => self.find(bits, scene),
        }
    }

    fn find(&mut self, bits: u16, scene: &mut Scene) -> MaterialId {
        let color = self.color(bits);
        let key = color.map(|c| c.to_array().map(f64::to_bits));
        let new = || scene.add_material(color.map_or_else(default_material, painted));
        let material = *self.known.entry(key).or_insert_with(new);
        self.last = Some((bits, material));
        material
    }

    fn color(&self, bits: u16) -> Option<Rgb> {
        let channel = |shift: u16| f64::from(bits >> shift & 31) / 31.0;
        match (self.whole, bits & FLAG != 0) {
            (Some(whole), true) => Some(whole),
            (Some(_), false) => Some(Rgb::new(channel(0), channel(5), channel(10))),
            (None, true) if self.are_used => Some(Rgb::new(channel(10), channel(5), channel(0))),
            (None, _) => None,
        }
    }
}

fn extra(triangle: &[u8; TRIANGLE]) -> u16 {
    u16::from_le_bytes([triangle[TRIANGLE - 2], triangle[TRIANGLE - 1]])
}

/// The colour after `COLOR=` in the header.
fn magics_color(header: &[u8]) -> Option<Rgb> {
    const MARK: &[u8] = b"COLOR=";
    let at = header.windows(MARK.len()).position(|w| w == MARK)?;
    let rgb = header.get(at + MARK.len()..)?.first_chunk::<3>()?;
    Some(Rgb::from(rgb.map(|c| f64::from(c) / 255.0)))
}
