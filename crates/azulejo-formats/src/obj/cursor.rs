//! Lines, words and numbers of OBJ and MTL, over bytes.
//!
//! A line ends with LF, CR or CRLF. A backslash before the end of a line continues it. A word
//! that begins with `#` begins a comment, which no backslash continues, because comments hold
//! Windows paths. Names are UTF-8 or, failing that, Latin-1.

use crate::reading::number;
use crate::reading::text::{shortened, text};
use crate::{Position, ReadError};

/// A place in the bytes of a text file.
#[derive(Clone, Debug)]
pub(super) struct Cursor<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
    line: u32,
    line_start: usize,
}

/// Space, tab and what else nobody sees. NUL is among them: one exporter of 1991 writes it
/// behind its line ends; [`Cursor::new`] lets no other NUL pass but at the end of the file, where
/// tapes and disks filled their blocks.
#[inline]
fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | 0x0b | 0x0c | 0)
}

#[inline]
fn is_line_end(b: u8) -> bool {
    matches!(b, b'\n' | b'\r')
}

impl<'a> Cursor<'a> {
    /// The start of a text file; `file` is its name in messages.
    ///
    /// # Errors
    /// Bytes that are no text: a NUL that neither follows a line end nor fills the file's end.
    pub fn new(bytes: &'a [u8], file: &'a str) -> Result<Cursor<'a>, ReadError> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let text = bytes.len() - bytes.iter().rev().take_while(|b| **b == 0).count();
        let bytes = &bytes[..text];
        let cursor = Cursor {
            file,
            bytes,
            at: 0,
            line: 1,
            line_start: 0,
        };
        match stray_nul(bytes) {
            Some(at) => Err(ReadError::at_byte(
                file,
                at as u64,
                "a zero byte, which no text file holds",
                "OBJ or MTL text",
            )),
            None => Ok(cursor),
        }
    }

    /// Line and column of the cursor. Takes time in proportion to the column.
    pub fn position(&self) -> Position {
        let before = &self.bytes[self.line_start..self.at];
        Position::Line(self.line, text(before).chars().count() as u32 + 1)
    }

    /// The byte behind the cursor, for coming back to by [`Cursor::error_at`].
    pub fn offset(&self) -> usize {
        self.at
    }

    /// Skips blanks and continued line ends.
    #[inline]
    pub fn skip_blanks(&mut self) {
        while let Some(&b) = self.bytes.get(self.at) {
            if is_blank(b) {
                self.at += 1;
            } else if b == b'\\' && self.continues() {
                self.at += 1;
                self.pass_line_end();
            } else {
                break;
            }
        }
    }

    /// Whether the backslash at the cursor stands before a line end, or at the end of the file.
    fn continues(&self) -> bool {
        self.bytes.get(self.at + 1).is_none_or(|&b| is_line_end(b))
    }

    fn pass_line_end(&mut self) {
        match self.bytes[self.at..] {
            [] => return,
            [b'\r', b'\n', ..] => self.at += 2,
            _ => self.at += 1,
        }
        self.line += 1;
        self.line_start = self.at;
    }

    /// Goes to the first word of the next statement and takes it; `None` at the end of the file.
    /// One comment is a statement: `#MRGB `, in which ZBrush writes colours.
    #[inline]
    pub fn keyword(&mut self) -> Option<&'a [u8]> {
        loop {
            self.skip_blanks();
            match self.bytes.get(self.at)? {
                b'#' if self.bytes[self.at..].starts_with(b"#MRGB ") => return self.word_at(),
                b'#' => self.skip_comment(),
                &b if is_line_end(b) => self.pass_line_end(),
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
        let start = self.at;
        self.at += 1;
        while !self.at_delimiter() {
            self.at += 1;
        }
        Some(&self.bytes[start..self.at])
    }

    /// Skips blanks; whether the statement has no more words.
    #[inline]
    pub fn at_end(&mut self) -> bool {
        self.skip_blanks();
        self.bytes
            .get(self.at)
            .is_none_or(|&b| is_line_end(b) || b == b'#')
    }

    /// Whether a word ends here.
    #[inline]
    fn at_delimiter(&self) -> bool {
        match self.bytes.get(self.at) {
            None => true,
            Some(b'\\') => self.continues(),
            Some(&b) => is_blank(b) || is_line_end(b),
        }
    }

    /// Skips the rest of the statement, continued lines included.
    #[inline]
    pub fn finish_statement(&mut self) {
        while self.word().is_some() {}
        if self.bytes.get(self.at) == Some(&b'#') {
            self.skip_comment();
        }
    }

    fn skip_comment(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest
            .iter()
            .position(|&b| is_line_end(b))
            .unwrap_or(rest.len());
    }

    /// The rest of the statement as a name: words with the blanks between them, trimmed.
    ///
    /// A comment may follow behind a blank, but a name may begin with `#`.
    pub fn name(&mut self) -> String {
        self.skip_blanks();
        let mut name = String::new();
        let start = self.at;
        while self.bytes.get(self.at).is_some_and(|&b| !is_line_end(b)) {
            let piece = self.at;
            while !self.at_delimiter() {
                self.at += 1;
            }
            name += &text(&self.bytes[piece..self.at]);
            let gap = self.at;
            self.skip_blanks();
            if self.bytes.get(self.at) == Some(&b'#') && self.at > start {
                break;
            }
            let blanks = self.bytes[gap..self.at].iter();
            name.extend(
                blanks
                    .filter(|&&b| b == b' ' || b == b'\t')
                    .map(|&b| b as char),
            );
        }
        name.truncate(name.trim_end().len());
        name
    }

    /// The next `N` words as numbers, if all of them are plain; else none is taken, and
    /// [`Cursor::number`] says why.
    #[inline]
    pub fn plain_numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let start = self.at;
        let mut values = [0.0; N];
        for value in &mut values {
            while matches!(self.bytes.get(self.at), Some(b' ' | b'\t')) {
                self.at += 1;
            }
            let number = number::parse(&self.bytes[self.at..])
                .filter(|number| !number.misplaced_sign)
                .filter(|number| {
                    let behind = self.bytes.get(self.at + number.length);
                    behind.is_none_or(|&b| is_blank(b) || is_line_end(b))
                });
            let Some(number) = number else {
                self.at = start;
                return None;
            };
            self.at += number.length;
            *value = number.value;
        }
        Some(values)
    }

    /// The next word as a number, NaN and infinities included, with whether its exponent's sign
    /// was misplaced; `None` when the statement has no more words.
    ///
    /// # Errors
    /// A word that is no number.
    #[inline]
    pub fn number(&mut self) -> Result<Option<number::Number>, ReadError> {
        if self.at_end() {
            return Ok(None);
        }
        if let Some(found) = number::parse(&self.bytes[self.at..]) {
            self.at += found.length;
            if self.at_delimiter() {
                return Ok(Some(found));
            }
            self.at -= found.length;
        }
        self.odd_number().map(Some)
    }

    /// What C libraries print for numbers that are none: `nan`, `-nan(ind)`, `1.#QNAN`, `inf`.
    #[cold]
    fn odd_number(&mut self) -> Result<number::Number, ReadError> {
        let start = self.at;
        let word = text(self.word().unwrap_or_default()).to_ascii_lowercase();
        let bare = word.trim_start_matches(['+', '-']);
        let value = match bare {
            _ if bare.starts_with("nan") || bare.starts_with("1.#") => f64::NAN,
            "inf" | "infinity" => f64::INFINITY,
            _ => return Err(self.error_at(start, "a number")),
        };
        Ok(number::Number {
            value,
            length: word.len(),
            misplaced_sign: false,
        })
    }

    /// A decimal integer at the cursor, without skipping blanks; `None` if there is none, or one
    /// beyond 18 digits.
    #[inline]
    pub fn integer(&mut self) -> Option<i64> {
        let mut at = self.at;
        let sign = self.bytes.get(at).copied();
        if matches!(sign, Some(b'+' | b'-')) {
            at += 1;
        }
        let start = at;
        let mut value = 0i64;
        while let Some(d) = self
            .bytes
            .get(at)
            .map(|b| b.wrapping_sub(b'0'))
            .filter(|d| *d < 10)
        {
            value = value.wrapping_mul(10).wrapping_add(i64::from(d));
            at += 1;
        }
        if at == start || at - start > 18 {
            return None;
        }
        self.at = at;
        Some(if sign == Some(b'-') { -value } else { value })
    }

    /// Passes a `/` if one stands at the cursor.
    #[inline]
    pub fn slash(&mut self) -> bool {
        let found = self.at_slash();
        self.at += usize::from(found);
        found
    }

    /// Whether a `/` stands at the cursor.
    #[inline]
    pub fn at_slash(&self) -> bool {
        self.bytes.get(self.at) == Some(&b'/')
    }

    /// Whether a word ends at the cursor.
    #[inline]
    pub fn word_ends(&self) -> bool {
        self.at_delimiter()
    }

    /// An error about the word at byte `offset`, which need not be on this line.
    #[cold]
    pub fn error_at(&self, offset: usize, expected: &str) -> ReadError {
        let mut there = Cursor {
            at: offset,
            ..self.clone()
        };
        let found = match there.word() {
            Some(word) => format!("\"{}\"", shortened(&text(word))),
            None => "the end of the line".to_owned(),
        };
        self.error_saying(offset, found, expected)
    }

    /// An error at byte `offset` in the words of the caller.
    #[cold]
    pub fn error_saying(
        &self,
        offset: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> ReadError {
        let before = &self.bytes[..offset];
        let line_start = before
            .iter()
            .rposition(|&b| is_line_end(b))
            .map_or(0, |i| i + 1);
        let mut counter = Cursor {
            at: 0,
            line: 1,
            line_start: 0,
            ..self.clone()
        };
        while counter.line_start < line_start {
            counter.skip_comment();
            counter.pass_line_end();
        }
        let mut end = counter.clone();
        end.skip_comment();
        counter.at = offset;
        ReadError {
            position: counter.position(),
            source_line: Some(text(&self.bytes[line_start..end.at]).into_owned()),
            ..ReadError::whole(self.file, found, expected)
        }
    }
}

/// Where a NUL stands that does not follow a line end.
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
