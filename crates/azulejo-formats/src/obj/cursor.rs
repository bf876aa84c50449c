//! Lines, words and numbers of OBJ and MTL, over bytes.
//!
//! A line ends with LF, CR or CRLF. A backslash before the end of a line continues it. A word
//! that begins with `#` begins a comment, which no backslash continues, because comments contain
//! Windows paths. Names are UTF-8 or, failing that, Latin-1.

use crate::reading::cursor::{TextCursor, column, is_line_end};
use crate::reading::number;
use crate::reading::text::{quoted, text};
use crate::{Position, ReadError};

/// A cursor over the statements of a file.
#[derive(Clone, Debug)]
pub(super) struct StatementCursor<'a> {
    file: &'a str,
    text: TextCursor<'a>,
    line: u32,
    line_start: usize,
}

/// White space other than line ends. NUL is included: one exporter of 1991 writes it after its
/// line ends. [`StatementCursor::new`] rejects all other NULs except at the end of the file, where
/// tapes and disks padded their blocks.
#[inline]
fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | 0x0b | 0x0c | 0)
}

impl<'a> StatementCursor<'a> {
    /// A cursor at the start of a text file; `file` is its name in messages.
    ///
    /// # Errors
    /// Bytes that are not text: a NUL that neither follows a line end nor pads the end of the file.
    pub fn new(bytes: &'a [u8], file: &'a str) -> Result<StatementCursor<'a>, ReadError> {
        let text = bytes.len() - bytes.iter().rev().take_while(|b| **b == 0).count();
        let bytes = &bytes[..text];
        let cursor = StatementCursor {
            file,
            text: TextCursor::new(bytes),
            line: 1,
            line_start: 0,
        };
        match stray_nul(bytes) {
            Some(at) => Err(ReadError::at_byte(
                file,
                at as u64,
                "a zero byte, which does not occur in text files",
                "OBJ or MTL text",
            )),
            None => Ok(cursor),
        }
    }

    /// Line and column of the cursor. Takes time proportional to the column.
    pub fn position(&self) -> Position {
        let before = &self.text.bytes()[self.line_start..self.text.offset()];
        Position::Line(self.line, column(before))
    }

    /// Offset of the next byte, for a later [`StatementCursor::error_at`].
    pub fn offset(&self) -> usize {
        self.text.offset()
    }

    /// Skips blanks and continued line ends.
    #[inline]
    pub fn skip_blanks(&mut self) {
        while let Some(b) = self.text.peek() {
            if is_blank(b) {
                self.text.advance(1);
            } else if b == b'\\' && self.continues() {
                self.text.advance(1);
                self.pass_line_end();
            } else {
                break;
            }
        }
    }

    /// Whether the backslash at the cursor precedes a line end or the end of the file.
    fn continues(&self) -> bool {
        self.text.peek_at(1).is_none_or(is_line_end)
    }

    fn pass_line_end(&mut self) {
        if self.text.pass_line_end() {
            self.line += 1;
            self.line_start = self.text.offset();
        }
    }

    /// Advances to the first word of the next statement and consumes it; `None` at the end of the file.
    /// One comment counts as a statement: `#MRGB `, in which ZBrush writes colours.
    #[inline]
    pub fn keyword(&mut self) -> Option<&'a [u8]> {
        loop {
            self.skip_blanks();
            match self.text.peek()? {
                b'#' if self.text.rest().starts_with(b"#MRGB ") => return self.word_at(),
                b'#' => self.skip_comment(),
                b if is_line_end(b) => self.pass_line_end(),
                _ => return self.word_at(),
            }
        }
    }

    /// The next word of this statement; `None` at its end.
    #[inline]
    pub fn word(&mut self) -> Option<&'a [u8]> {
        if self.at_end() {
            return None;
        }
        self.word_at()
    }

    /// The word at the cursor, whatever its first byte is.
    #[inline]
    fn word_at(&mut self) -> Option<&'a [u8]> {
        let start = self.text.offset();
        self.text.advance(1);
        while !self.at_delimiter() {
            self.text.advance(1);
        }
        Some(&self.text.bytes()[start..self.text.offset()])
    }

    /// Skips blanks; returns whether the statement has no more words.
    #[inline]
    pub fn at_end(&mut self) -> bool {
        self.skip_blanks();
        self.text.peek().is_none_or(|b| is_line_end(b) || b == b'#')
    }

    /// Whether a word ends here.
    #[inline]
    fn at_delimiter(&self) -> bool {
        match self.text.peek() {
            None => true,
            Some(b'\\') => self.continues(),
            Some(b) => is_blank(b) || is_line_end(b),
        }
    }

    /// Skips the rest of the statement, continued lines included.
    #[inline]
    pub fn finish_statement(&mut self) {
        while self.word().is_some() {}
        if self.text.peek() == Some(b'#') {
            self.skip_comment();
        }
    }

    fn skip_comment(&mut self) {
        self.text.take_line();
    }

    /// The rest of the statement as a name: words with the blanks between them, trimmed.
    ///
    /// A comment may follow after a blank, but a name may begin with `#`.
    pub fn name(&mut self) -> String {
        self.skip_blanks();
        let mut name = String::new();
        let (bytes, start) = (self.text.bytes(), self.text.offset());
        while !self.text.at_line_end() {
            let piece = self.text.offset();
            while !self.at_delimiter() {
                self.text.advance(1);
            }
            let gap = self.text.offset();
            name += &text(&bytes[piece..gap]);
            self.skip_blanks();
            if self.text.peek() == Some(b'#') && self.text.offset() > start {
                break;
            }
            let blanks = bytes[gap..self.text.offset()].iter();
            name.extend(
                blanks
                    .filter(|&&b| b == b' ' || b == b'\t')
                    .map(|&b| b as char),
            );
        }
        name.truncate(name.trim_end().len());
        name
    }

    /// The next `N` words as numbers, if all of them are plain; else none is consumed, and
    /// [`StatementCursor::number`] reports the reason.
    #[inline]
    pub fn plain_numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let before = self.text;
        let mut values = [0.0; N];
        for value in &mut values {
            while matches!(self.text.peek(), Some(b' ' | b'\t')) {
                self.text.advance(1);
            }
            let number = number::parse(self.text.rest())
                .filter(|number| !number.misplaced_sign)
                .filter(|number| {
                    let next = self.text.peek_at(number.length);
                    next.is_none_or(|b| is_blank(b) || is_line_end(b))
                });
            let Some(number) = number else {
                self.text = before;
                return None;
            };
            self.text.advance(number.length);
            *value = number.value;
        }
        Some(values)
    }

    /// The next word as a number, NaN and infinities included, and whether its exponent's sign
    /// was misplaced; `None` if the statement has no more words.
    ///
    /// # Errors
    /// A word that is not a number.
    #[inline]
    pub fn number(&mut self) -> Result<Option<number::Number>, ReadError> {
        if self.at_end() {
            return Ok(None);
        }
        if let Some(number) = number::parse(self.text.rest()) {
            let before = self.text;
            self.text.advance(number.length);
            if self.at_delimiter() {
                return Ok(Some(number));
            }
            self.text = before;
        }
        self.odd_number().map(Some)
    }

    #[cold]
    fn odd_number(&mut self) -> Result<number::Number, ReadError> {
        let start = self.text.offset();
        let word = self.word().unwrap_or_default();
        let value = number::non_finite(word).ok_or_else(|| self.error_at(start, "a number"))?;
        Ok(number::Number {
            value,
            length: word.len(),
            misplaced_sign: false,
        })
    }

    /// A decimal integer at the cursor, without skipping blanks; `None` if there is none, or one
    /// of more than 18 digits.
    #[inline]
    pub fn integer(&mut self) -> Option<i64> {
        let sign = self.text.peek();
        let start = usize::from(matches!(sign, Some(b'+' | b'-')));
        let (mut value, mut end) = (0i64, start);
        while let Some(d) = self
            .text
            .peek_at(end)
            .map(|b| b.wrapping_sub(b'0'))
            .filter(|d| *d < 10)
        {
            value = value.wrapping_mul(10).wrapping_add(i64::from(d));
            end += 1;
        }
        if end == start || end - start > 18 {
            return None;
        }
        self.text.advance(end);
        Some(if sign == Some(b'-') { -value } else { value })
    }

    /// Consumes a `/` if it comes next.
    #[inline]
    pub fn slash(&mut self) -> bool {
        let is_slash = self.at_slash();
        self.text.advance(usize::from(is_slash));
        is_slash
    }

    /// Whether a `/` comes next.
    #[inline]
    pub fn at_slash(&self) -> bool {
        self.text.peek() == Some(b'/')
    }

    /// Whether a word ends at the cursor.
    #[inline]
    pub fn word_ends(&self) -> bool {
        self.at_delimiter()
    }

    /// An error about the word at byte `offset`, which need not be on this line.
    #[cold]
    pub fn error_at(&self, offset: usize, expected: &str) -> ReadError {
        let mut cursor = self.clone();
        cursor.text.move_to(offset);
        let found = cursor
            .word()
            .map_or_else(|| "the end of the line".to_owned(), quoted);
        self.error_with(offset, found, expected)
    }

    /// An error at byte `offset` with the caller's description.
    #[cold]
    pub fn error_with(
        &self,
        offset: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        self.text.error(self.file, offset, found, expected)
    }
}

/// Offset of the first NUL that does not follow a line end.
fn stray_nul(bytes: &[u8]) -> Option<usize> {
    if !bytes.contains(&0) {
        return None;
    }
    let mut allowed = false;
    for (i, &b) in bytes.iter().enumerate() {
        if b == 0 && !allowed {
            return Some(i);
        }
        allowed = is_line_end(b) || (b == 0 && allowed);
    }
    None
}
