//! The cursor of all text formats, and the conversion of offsets to lines and columns.
//!
//! A line ends with LF, CR or CR LF. Lines and columns count from 1, columns in characters.
//! Byte-order marks and UTF-16 have been removed before: see [`decoded`](super::text::decoded).

use super::text::text;
use crate::{Position, ReadError};
use std::borrow::Cow;

/// A position in a text, given as bytes or as `str`, from which it is read forwards.
///
/// Scanners look ahead with a copy. The cursor handles bytes and line ends; separators and
/// comments are up to each format.
#[derive(Debug)]
pub(crate) struct TextCursor<'a, T: ?Sized = [u8]> {
    text: &'a T,
    at: usize,
}

// Derived implementations would require `T: Clone`.
impl<T: ?Sized> Copy for TextCursor<'_, T> {}

impl<T: ?Sized> Clone for TextCursor<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

/// Whether a byte ends a line, alone or as part of CR LF.
#[inline]
pub(crate) fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

impl<'a, T: AsRef<[u8]> + ?Sized> TextCursor<'a, T> {
    /// A cursor at the start of a text.
    pub fn new(text: &'a T) -> Self {
        TextCursor { text, at: 0 }
    }

    /// The same text from byte `offset` on.
    #[inline]
    pub fn moved_to(self, offset: usize) -> Self {
        TextCursor { at: offset, ..self }
    }

    /// The whole text, whatever the position.
    #[inline]
    pub fn text(&self) -> &'a T {
        self.text
    }

    /// The bytes of the whole text, whatever the position.
    #[inline]
    pub fn bytes(&self) -> &'a [u8] {
        self.text.as_ref()
    }

    /// The offset of the next byte.
    #[inline]
    pub fn offset(&self) -> usize {
        self.at
    }

    /// The bytes from here to the end.
    #[inline]
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes()[self.at..]
    }

    /// Whether the text ends here.
    #[inline]
    pub fn at_end(&self) -> bool {
        self.at >= self.bytes().len()
    }

    /// Whether the line or the text ends here.
    #[inline]
    pub fn at_line_end(&self) -> bool {
        self.peek().is_none_or(is_line_end)
    }

    /// The next byte, which is not consumed.
    #[inline]
    pub fn peek(&self) -> Option<u8> {
        self.peek_at(0)
    }

    /// The byte `ahead` bytes after the next one.
    #[inline]
    pub fn peek_at(&self, ahead: usize) -> Option<u8> {
        self.bytes().get(self.at + ahead).copied()
    }

    /// Skips `count` bytes, which must exist.
    #[inline]
    pub fn advance(&mut self, count: usize) {
        self.at += count;
    }

    /// Moves to byte `offset`, which must not be beyond the end.
    #[inline]
    pub fn move_to(&mut self, offset: usize) {
        self.at = offset;
    }

    /// Consumes bytes as long as they match, and returns them.
    #[inline]
    pub fn take_while(&mut self, matches: impl Fn(u8) -> bool) -> &'a [u8] {
        let start = self.at;
        while self.peek().is_some_and(&matches) {
            self.at += 1;
        }
        &self.bytes()[start..self.at]
    }

    /// The bytes up to the end of the line, which are not consumed.
    pub fn line_ahead(&self) -> &'a [u8] {
        let rest = self.rest();
        let length = rest.iter().position(|&b| is_line_end(b));
        &rest[..length.unwrap_or(rest.len())]
    }

    /// Consumes the rest of the line, but not its end, and returns it.
    #[inline]
    pub fn take_line(&mut self) -> &'a [u8] {
        let line = self.line_ahead();
        self.at += line.len();
        line
    }

    /// Consumes one line end if it comes next.
    #[inline]
    pub fn pass_line_end(&mut self) -> bool {
        let length = match self.rest() {
            [b'\r', b'\n', ..] => 2,
            [b'\r' | b'\n', ..] => 1,
            _ => 0,
        };
        self.at += length;
        length > 0
    }

    /// Line and column of a byte. Takes time proportional to its offset.
    pub fn position(&self, offset: usize) -> Position {
        position(self.bytes(), offset)
    }

    /// An error at byte `offset`, with its source line.
    #[cold]
    pub fn error(
        &self,
        file: &str,
        offset: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        ReadError {
            position: self.position(offset),
            source_line: line_around(self.bytes(), offset, usize::MAX),
            ..ReadError::whole(file, found, expected)
        }
    }
}

/// Line and column of a byte. Takes time proportional to its offset.
pub(crate) fn position(bytes: &[u8], offset: usize) -> Position {
    let before = &bytes[..offset.min(bytes.len())];
    let start = line_start(before);
    let ends = before[..start].iter().enumerate();
    // CR LF counts at its LF.
    let lines = ends.filter(|&(i, &b)| match b {
        b'\r' => before.get(i + 1) != Some(&b'\n'),
        _ => b == b'\n',
    });
    Position::Line(lines.count() as u32 + 1, column(&before[start..]))
}

/// The column after `before`, the part of a line before it.
pub(crate) fn column(before: &[u8]) -> u32 {
    text(before).chars().count() as u32 + 1
}

/// Offset at which the last line of `before` begins.
fn line_start(before: &[u8]) -> usize {
    let end = before.iter().rposition(|&b| is_line_end(b));
    end.map_or(0, |end| end + 1)
}

/// Most bytes of a line shown after an offset.
const MOST_BEHIND: usize = 1000;

/// The line around a byte, cut far after it; `None` if it begins more than `most_before` bytes
/// before.
pub(crate) fn line_around(bytes: &[u8], offset: usize, most_before: usize) -> Option<String> {
    let offset = offset.min(bytes.len());
    let from = offset.saturating_sub(most_before);
    let start = from + line_start(&bytes[from..offset]);
    if start == from && from > 0 {
        return None;
    }
    let rest = &bytes[offset..];
    let near = &rest[..rest.len().min(MOST_BEHIND)];
    let end = near.iter().position(|&b| is_line_end(b));
    let line = &bytes[start..offset + end.unwrap_or(near.len())];
    // A cut must not divide a character: the line would no longer be UTF-8.
    let whole = (0..4).map(|less| &line[..line.len().saturating_sub(less)]);
    let valid = whole.map(std::str::from_utf8).find_map(Result::ok);
    Some(valid.map_or_else(|| text(line), Cow::Borrowed).into_owned())
}

/// Line numbers of increasing offsets in one text, so that no line is counted twice.
#[derive(Debug, Default)]
pub(crate) struct LineCounter {
    offset: usize,
    ends: u32,
}

impl LineCounter {
    /// The line of an offset, from 1; no less than that of the offset before.
    pub fn at(&mut self, bytes: &[u8], offset: usize) -> u32 {
        for at in self.offset..offset.min(bytes.len()) {
            let ends = match bytes[at] {
                b'\r' => bytes.get(at + 1) != Some(&b'\n'),
                byte => byte == b'\n',
            };
            self.ends += u32::from(ends);
        }
        self.offset = self.offset.max(offset.min(bytes.len()));
        self.ends + 1
    }
}

/// Lines and columns of offsets in one text; fastest for increasing offsets.
#[derive(Default)]
pub(crate) struct Locator {
    offset: usize,
    lines: u32,
    columns: u32,
}

impl Locator {
    /// Line and column of an offset, both from 1; the column counts characters.
    pub fn locate(&mut self, text: &str, offset: usize) -> (u32, u32) {
        if offset < self.offset {
            *self = Locator::default();
        }
        let bytes = text.as_bytes();
        for at in self.offset..offset {
            // CR LF counts at its LF; a lone CR is the line end of old Macintosh computers.
            let ends = match bytes[at] {
                b'\n' => true,
                b'\r' => bytes.get(at + 1) != Some(&b'\n'),
                _ => false,
            };
            if ends {
                self.lines = self.lines.saturating_add(1);
                self.columns = 0;
            } else if bytes[at] & 0xc0 != 0x80 {
                self.columns = self.columns.saturating_add(1);
            }
        }
        self.offset = offset;
        (self.lines.saturating_add(1), self.columns.saturating_add(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_every_way() {
        let text = "a\rb\r\nc\n\u{e9}\u{e9}x";
        let mut locator = Locator::default();
        let mut check = |offset, line, column| {
            assert_eq!(
                position(text.as_bytes(), offset),
                Position::Line(line, column)
            );
            let located = locator.locate(text, offset.min(text.len()));
            assert_eq!(located, (line, column));
        };
        check(0, 1, 1);
        check(2, 2, 1);
        check(5, 3, 1);
        check(7, 4, 1);
        check(11, 4, 3);
        check(99, 4, 4);
        check(2, 2, 1);
        assert_eq!(line_around(text.as_bytes(), 5, 5).as_deref(), Some("c"));
        assert_eq!(line_around(text.as_bytes(), 11, 2), None);
        let mut cursor = TextCursor::new(text);
        let mut lines = vec![cursor.take_line()];
        while cursor.pass_line_end() {
            lines.push(cursor.take_line());
        }
        assert_eq!(lines, [b"a", b"b", b"c", "\u{e9}\u{e9}x".as_bytes()]);
        assert!(cursor.at_end() && cursor.at_line_end());
    }

    #[test]
    fn long_lines_are_cut_between_characters() {
        let text = format!("ab{}", "\u{e9}".repeat(2000));
        let line = line_around(text.as_bytes(), 1, 9).unwrap();
        assert!(
            text.starts_with(&line) && (990..=1001).contains(&line.len()),
            "{}",
            line.len()
        );
    }
}
