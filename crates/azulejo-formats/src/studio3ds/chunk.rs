//! Chunks: an id, a length, and content that may include further chunks.

use crate::Position;
use crate::reading::bytes::Bytes;
use crate::reading::text::text;
use crate::reading::warnings::Warnings;
use crate::surface::gloss::Gloss;
use azulejo_scene::Rgb;

/// Longest name kept, in bytes. The program itself allowed 16 at most.
const LONGEST_NAME: usize = 128;

/// Bytes of an id and a length.
const HEADER: usize = 6;

/// One chunk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chunk<'a> {
    pub id: u16,
    /// What follows the header: data, then child chunks.
    pub body: Bytes<'a>,
    /// Offset of the header in the file.
    pub at: u64,
}

/// Traverses chunks and collects warnings about them.
pub(super) struct ChunkWalker<'w> {
    pub file: &'w str,
    pub warnings: Warnings,
    pub gloss: Gloss,
}

impl<'a> ChunkWalker<'_> {
    /// The next chunk of a body. One that exceeds its parent is truncated.
    pub fn next(&mut self, body: &mut Bytes<'a>) -> Option<Chunk<'a>> {
        let at = body.offset();
        if body.left() == 0 {
            return None;
        }
        let (Some(id), Some(length)) = (body.u16_le(), body.u32_le()) else {
            self.warn(at, "stray bytes after the last chunk: skipped");
            return None;
        };
        let Some(body_length) = (length as usize).checked_sub(HEADER) else {
            let message = format!(
                "chunk {id:04X} shorter than its own header: the rest of its parent is skipped"
            );
            self.warn(at, message);
            return None;
        };
        if body_length > body.left() {
            let message = format!("chunk {id:04X} longer than its parent: truncated");
            self.warn(at, message);
        }
        let body = body.piece(body_length.min(body.left()))?;
        Some(Chunk { id, body, at })
    }

    pub fn warn(&mut self, at: u64, message: impl Into<String>) {
        self.warn_many(at, message, 1);
    }

    pub fn warn_many(&mut self, at: u64, message: impl Into<String>, count: usize) {
        let position = || Position::Byte(at);
        self.warnings
            .add_many(self.file, message.into(), count, position);
    }

    /// Warns about a chunk that is not used.
    pub fn skipped(&mut self, chunk: &Chunk<'_>, what: &str) {
        let blank = if what.is_empty() { "unknown" } else { what };
        self.warn(
            chunk.at,
            format!("{blank} (chunk {:04X}): skipped", chunk.id),
        );
    }

    /// The result of `read` on a chunk's data; a warning if there are too few bytes.
    pub fn data<T>(
        &mut self,
        chunk: &mut Chunk<'a>,
        read: impl FnOnce(&mut Bytes<'a>) -> Option<T>,
    ) -> Option<T> {
        let content = read(&mut chunk.body);
        if content.is_none() {
            let message = format!("chunk {:04X} too short for its data: skipped", chunk.id);
            self.warn(chunk.at, message);
        }
        content
    }

    /// Entries of `size` bytes after their count, as many as are present.
    pub fn list(&mut self, chunk: &mut Chunk<'a>, size: usize, what: &str) -> &'a [u8] {
        let Some(promised) = self.data(chunk, Bytes::u16_le).map(usize::from) else {
            return &[];
        };
        let there = promised.min(chunk.body.left() / size);
        let message = format!("{what} missing from a truncated list");
        self.warn_many(chunk.at, message, promised - there);
        let list = chunk.body.take(there * size).unwrap_or_default();
        if there < promised {
            // An incomplete entry is not a chunk.
            let _ = chunk.body.skip(chunk.body.left());
        }
        list
    }

    /// The colour among a chunk's children. If a file has a gamma-corrected and a linear one, the
    /// linear one is used; a single one is taken as linear, too, as in other readers.
    pub fn color(&mut self, chunk: &Chunk<'a>) -> Option<Rgb> {
        let (mut color, mut linear) = (None, None);
        let mut body = chunk.body;
        while let Some(mut child) = self.next(&mut body) {
            match child.id {
                0x0010 | 0x0011 => color = self.color_value(&mut child),
                0x0012 | 0x0013 => linear = self.color_value(&mut child),
                _ => self.skipped(&child, ""),
            }
        }
        linear.or(color)
    }

    /// The colour in one of the chunks 0010 to 0013.
    pub fn color_value(&mut self, chunk: &mut Chunk<'a>) -> Option<Rgb> {
        let color = match chunk.id {
            0x0010 | 0x0013 => self.data(chunk, vector).map(Rgb::from),
            _ => self.data(chunk, bytes),
        };
        let sound = color.filter(|c| c.is_finite());
        sound.map(|c| c.map(|x| x.max(0.0)))
    }

    /// The percentage among a chunk's children, as 0..=1.
    pub fn percent(&mut self, chunk: &Chunk<'a>) -> Option<f64> {
        let mut body = chunk.body;
        let mut child = self.next(&mut body)?;
        let share = match child.id {
            0x0030 => self.data(&mut child, |b| b.i16_le().map(|x| f64::from(x) / 100.0))?,
            0x0031 => self.data(&mut child, |b| b.f32_le().map(f64::from))?,
            _ => {
                self.skipped(&child, "");
                return None;
            }
        };
        if (0.0..=1.0).contains(&share) {
            return Some(share);
        }
        let message = format!(
            "percentage outside 0..100 (in chunk {:04X}): clamped",
            chunk.id
        );
        self.warn(chunk.at, message);
        Some(if share > 0.0 { share.min(1.0) } else { 0.0 })
    }
}

fn bytes(bytes: &mut Bytes<'_>) -> Option<Rgb> {
    let mut channel = || bytes.u8_le().map(|c| f64::from(c) / 255.0);
    Some(Rgb::new(channel()?, channel()?, channel()?))
}

/// Exactly `N` numbers, or none.
pub(super) fn vector<const N: usize>(bytes: &mut Bytes<'_>) -> Option<[f64; N]> {
    let mut values = [0.0; N];
    for value in &mut values {
        *value = f64::from(bytes.f32_le()?);
    }
    Some(values)
}

/// A name up to its NUL, or up to the end of the bytes.
pub(super) fn name(bytes: &mut Bytes<'_>) -> String {
    let mut rest = *bytes;
    let whole = rest.take(rest.left()).unwrap_or_default();
    let length = whole.iter().position(|b| *b == 0);
    let _ = bytes.skip(length.map_or(whole.len(), |l| l + 1));
    let kept = length.unwrap_or(whole.len()).min(LONGEST_NAME);
    text(&whole[..kept]).trim().to_owned()
}
